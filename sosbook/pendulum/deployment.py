"""From two logs to a C program: identify, design, prove, write.

``python -m sosbook.mip robot.toml body.csv wheels.csv folder`` does it
all.
"""

from pathlib import Path

from ..runtime.digests import digest
from ..runtime.reading import read_bytes
from .fit_spread import FitSpread
from .gate import Inspection, refused, widened
from .log import Log
from .proven import Deployment
from .rig import DATA
from .robot import Robot

__all__ = ["Deployment", "deploy", "described", "inspect", "recommend"]


def recommend(mip, R=20.0, **asked):
    """The controller that this book recommends for a robot.

    Parameters
    ----------
    mip : Mip
        The pendulum, with its I_w.
    R : float or None
        Weight of the voltage, or None to search it.
    **asked
        As for `Deployment`.

    Returns
    -------
    Deployment
        The controller and all that is known of it.

    Raises
    ------
    ValueError
        On bad input, or where there is no design; it says why.
    """
    found = Deployment(mip, R, **asked)
    _ = found.design, found.delayed  # where there is none, it says so now
    return found


def deploy(body, wheels, robot=None, force=False, confidence=None, **asked):
    """From the logs of the two experiments to a controller.

    Parameters
    ----------
    body, wheels : str or Path
        CSV files, as `Log.read` takes them.
    robot : Robot, path_like or dict, optional
        The robot's description, or the file that holds it. Only the
        logs that the package ships need none: they are the thesis's
        robot's, of which a dict changes some keys.
    force : bool
        Go on with logs that `check_log` or `check_fits` refuses; the
        header says so.
    confidence : float, optional
        With it all five ratios are uncertain: the spread is the `FitSpread` of the
        logs, around the ellipsoid of this probability. Not beside ``spread``.
    **asked
        As for `recommend`; a described robot's R is searched.

    Returns
    -------
    Deployment
        The controller and all that is known of it.

    Raises
    ------
    ValueError
        If other logs come without a description, or if the logs are
        refused; it says why.
    """
    if robot is not None and not isinstance(robot, dict):
        asked.setdefault("R", None)  # searched
    seen = inspect(body, wheels, robot)
    if refused(seen.findings) and (not force or seen.identified is None):
        raise ValueError(seen.refusal)
    identified = seen.identified
    sd = widened(identified)
    if confidence is not None:
        if "spread" in asked:
            raise ValueError("give spread or confidence: each says which robots")
        asked["spread"] = FitSpread.of(identified, sd, confidence)
    data = {
        f"log of the {name}": f"{Path(path).name}, sha256 {digest(read_bytes(path))}"
        for name, path in (("body", body), ("wheels", wheels))
    }
    data["identified"] = ", ".join(
        f"{name.replace('_', '/')} = {value:.5g} +- {1.96 * s:.2g}"
        for (name, value), s in zip(identified.ratios.items(), sd)
    )
    data["the two logs"] = (
        f"e/f by the wheels over e/f by the body: {identified.contradiction:.4f}; "
        "the intervals hold this disagreement and that of the wheels"
    )
    for k, finding in enumerate(seen.findings, 1):
        forced = "FORCED, " * (finding.severity == "refused")
        data[f"warning {k}"] = forced + str(finding)
    return recommend(
        identified.mip, identified=identified, data=data, robot=seen.robot, **asked
    )


def inspect(body, wheels, robot=None):
    """The `Inspection` of two log files; body, wheels, robot are as for `deploy`."""
    robot = described(robot, (body, wheels))
    logs = Log.read(body), Log.read(wheels)
    return Inspection.of(*logs, robot)


def described_or_none(robot):
    """The `Robot` in a file or itself; None stays None."""
    return robot if robot is None or isinstance(robot, Robot) else Robot.read(robot)


def described(robot, logs):
    """The `Robot` that ``robot`` and two logs describe; ValueError if none does."""
    if isinstance(robot, Robot):
        return robot
    if robot is not None and not isinstance(robot, dict):
        return Robot.read(robot)
    ours = [read_bytes(DATA / f"{name}.csv") for name in ("body", "wheels")]
    if [read_bytes(path) for path in logs] != ours:
        raise ValueError(
            "these logs aren't those that the package ships, so the "
            "robot must be described: its masses, lengths, counts, "
            "motors and clock, in a file robot.toml like "
            f"{DATA / 'gearmotors.toml'}"
        )
    return Robot.shipped("thesis").but(**(robot or {}))
