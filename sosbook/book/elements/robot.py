"""The robot in the rendered page: simulated and drawn there, live.

A page has no Python behind it, so it gets the pendulums and the gains and
runs the loop itself: the nonlinear pendulum, its sensors, and what
`Controller` does at every tick. Gains are never interpolated.
"""

import numpy as np

from ...pendulum.firmware import Firmware
from ...pendulum.law import TRACKING_TIME, SampledLaw, pendulum_gain
from ...pendulum.model import Mip
from ...pendulum.rig import COUNTS_PER_TURN, GYRO_STEP, Rig
from ...pendulum.spread import vertices
from ...plants.checks import positive
from .movers.mover import Mover, choice, slider

__all__ = ["Animation", "animation"]

STEPS_PER_TICK = 8  # of Runge and Kutta's method
GRAVITY = 9.8  # m/s^2, of `Mip.from_ratios`
SEED = 2023
#: Sliders from zero on: label, unit, largest value, step.
SLIDERS = {
    "tilt": ("Initial tilt", "°", 40, 1),
    "delay": ("Delay of the voltage", " ms", 30, 2.5),
    "noise": ("Gyro noise", " × nominal", 5, 0.5),
}
PUSH = (
    "Push the robot. Then choose the smallest weight R, and let the voltage come a "
    "whole tick late: what do the motors do?"
)
START = {"tilt": 10.0, "delay": 5.0, "noise": 1.0}


class Animation(Mover):
    """A page element that runs the robot; made by `animation`.

    Its title, hint, script, controls and what is given are those of `Mover`.
    """

    sheets = ("mover", "robot")

    def __repr__(self):
        gains = sum(len(law["R"]) for law in self.data["laws"])
        return (
            f"Animation: {gains} gains of {len(self.data['laws'])} laws "
            f"on {len(self.data['robots'])} robots"
        )


def animation(
    laws, robots=None, *, T=0.01, start=None, title="The robot, simulated in this page"
):
    """The robot under sampled gains, with sliders, in the page.

    The page integrates `Mip.acceleration` by Runge and Kutta's method and
    does what `Controller` does at every tick; only the stall fault is
    off, so that chatter can be seen. The gyro is noisy and rounded, the
    encoders count, and each voltage acts from its delay on. A tilt
    beyond the firmware's ``tip`` is a fall: the motors go off. Delays
    count in eighths of a tick.

    ``laws``: for each name a dict from R to a `Gain` of the pendulum. The slider for R
    stops at these values only; ``robots``: A `Mip` for each name. Without it the
    printed one and its four `vertices`; ``T``: time between ticks, in s; ``start``:
    {"law": "PD", "R": 5, "robot": "printed", "tilt": 10, "delay": 5, "noise": 1}: where
    the controls stand at first; the tilt in degrees, the delay in ms, the noise
    relative to the gyro's 0.1 deg/s. Without it the first law, robot and R; ``title``:
    the heading of the element. Returns the element, with all gains and pendulums.
    Raises ValueError if there is no law or robot, a gain isn't a pendulum's, an R or T
    isn't positive, or a start value isn't on its control.

    Source: thesis (4.13), mended, with the gains of section 4.3.

    The words in the page: it falls, if the motors go off; it chatters,
    if in the last of 8 seconds the voltage has an rms above 1 V and
    more than 10 changes of sign; it sways, if the rms is as high
    without them or the tilt beyond 1 degree; else it stands. In the
    page ``element.run({law, R, robot, tilt, delay, noise, seconds,
    ideal, pushes})`` returns any run as arrays over the ticks.

    >>> from sosbook.book import thesis
    >>> animation(thesis.mip().gains)
    Animation: 6 gains of 2 laws on 5 robots
    """
    T = positive("T", T)
    if robots is None:
        robots = {"printed": Mip.printed()} | {
            f"vertex {k}": v for k, v in enumerate(vertices(Mip.printed()), 1)
        }
    stored = [_law(name, gains, T) for name, gains in _named("laws", laws).items()]
    pendulums = [_robot(name, mip) for name, mip in _named("robots", robots).items()]
    return Animation(
        "robot",
        title,
        PUSH,
        _controls(stored, pendulums, start),
        answer={"R": 0, "delay": 1000 * T},
        laws=stored,
        robots=pendulums,
        T=T,
        fine=STEPS_PER_TICK,
        unwind=TRACKING_TIME,
        seed=SEED,
        limit=Firmware.limit,
        tip=Firmware.tip,
        sigma=float(Rig.noise),
        gyro=float(GYRO_STEP),
        count=2 * np.pi / COUNTS_PER_TURN,
    )


def _named(argument, values):
    if not isinstance(values, dict) or not values:
        raise ValueError(
            f"{argument} must be a dict with a name or more, got {values!r}"
        )
    return values


def _law(name, gains, T):
    """One law: its values of R, increasing, and the gain of each."""
    where = f"laws[{name!r}]"
    by_R = {}
    for R, gain in _named(where, gains).items():
        try:
            SampledLaw.of_gain(gain, T)
        except ValueError as error:
            raise ValueError(f"{where}[{R}]: {error}") from None
        by_R[positive(f"R in {where}", R)] = pendulum_gain(gain)[0].tolist()
    values = sorted(by_R)
    return {"name": str(name), "R": values, "K": [by_R[R] for R in values]}


def _robot(name, mip):
    if not isinstance(mip, Mip):
        raise ValueError(f"robots[{name!r}] must be a Mip, got {mip!r}")
    radius = GRAVITY * positive("b", mip.b) / positive("d", mip.d)
    letters = {letter: getattr(mip, letter) for letter in "abcdefJ"}
    return {"name": str(name), **letters, "radius": radius}


def _controls(laws, robots, start):
    """The controls, which stand where ``start`` says by names and values."""
    asked = START | dict(start or {})
    names, plants = ([x["name"] for x in parts] for parts in (laws, robots))
    law = _index("law", asked.pop("law", names[0]), names)
    weights, most = laws[law]["R"], max(len(x["R"]) for x in laws) - 1
    weight = _index("R", asked.pop("R", weights[0]), weights)
    robot = _index("robot", asked.pop("robot", plants[0]), plants)
    controls = [
        choice("law", "Law", names, law),
        slider("R", "Weight R of the design", "", (0, most), 1, weight),
        choice("robot", "Robot", plants, robot),
    ]
    for key, (label, unit, top, step) in SLIDERS.items():
        value = float(asked.pop(key))
        if not (0 <= value <= top and np.isclose(value % step, 0)):
            raise ValueError(
                f"start: {key} = {value:g} must be a multiple of {step} from 0 to {top}"
            )
        controls.append(slider(key, label, unit, (0, top), step, value))
    if asked:
        raise ValueError(f"start names no control: {sorted(asked)}")
    return controls


def _index(key, value, values):
    if value not in values:
        raise ValueError(f"start: {key} must be one of {values}, got {value!r}")
    return values.index(value)
