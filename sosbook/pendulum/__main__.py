"""Identify a robot from two logs; write a proven program for it.

Without logs it takes those that the package ships.
"""

import argparse

from .deployment import deploy
from .rig import DATA

OPTIONS = {
    "R": "weight of the voltage", "spread": "of e/c and e/a, relative",
    "T": "time between samples, s", "delay": "to compute, at most, s",
    "blend": "share of the accelerometers' tilt in each estimate",
}
ROBOT = {
    "M_b": "mass of the body, kg", "l": "axle to its centre, m",
    "r": "radius of the wheels, m", "M_w": "mass of one wheel, kg",
    "g": "gravity, m/s^2", "counts": "of an encoder, per turn of a wheel",
}


def main(words=None):
    """The command; returns the `Deployment`."""
    parser = argparse.ArgumentParser(
        prog="python -m sosbook.pendulum", description=__doc__)
    parser.add_argument("body", nargs="?", default=DATA / "body.csv")
    parser.add_argument("wheels", nargs="?", default=DATA / "wheels.csv")
    parser.add_argument("folder", nargs="?", default="deployment")
    for name, text in OPTIONS.items():
        parser.add_argument(f"--{name}", type=float, help=text)
    for name, text in ROBOT.items():
        parser.add_argument(f"--{name}", type=float, help=text)
    given = {name: value for name, value
             in vars(parser.parse_args(words)).items() if value is not None}
    paths = [given.pop(name) for name in ("body", "wheels", "folder")]
    robot = {name: given.pop(name) for name in ROBOT if name in given}
    try:
        found = deploy(*paths[:2], robot, **given)
        for word, text in found.facts.items():
            print(f"{word}: {text}")
        for path in found.write(paths[2]):
            print(f"wrote {path}")
    except (OSError, ValueError) as error:
        parser.exit(1, f"{error}\n")
    return found


if __name__ == "__main__":
    main()
