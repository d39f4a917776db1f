"""From two logs to a C program: identify, design, prove, write.

``python -m sosbook.mip robot.toml body.csv wheels.csv folder`` does it
all.
"""

from pathlib import Path

import numpy as np

from ..plants.checks import finite, positive
from ..runtime.digests import digest
from ..runtime.reading import read_bytes
from .fit_spread import FitSpread
from .gate import Inspection, refused, widened
from .log import Log
from .proven import LARGEST_PEAK, Deployment
from .rig import DATA
from .robot import Robot
from .spread import polytope
from .tuning import U, design, design_optimal, prove, recoverable_tilt

__all__ = ["Deployment", "deploy", "described", "inspect", "recommend"]

LARGEST_DECAY = 0.2  # 1/s, the most that the proof with the hold is asked for
LEAST_TILT = np.deg2rad(5)  # rad; a robot must be able to come back from here


def recommend(
    mip,
    R=20.0,
    spread=0.04,
    T=None,
    delay=None,
    blend=None,
    robot=None,
    Q=None,
    decay=LARGEST_DECAY,
    peak=LARGEST_PEAK,
    **more,
):
    """The controller that this book recommends for a robot.

    Parameters
    ----------
    mip : Mip
        The pendulum, with its I_w.
    R : float or None
        Weight of the voltage. None searches the smallest of 1, 2, 5,
        10, ... with which no sampled loop's sensitivity exceeds
        ``peak``.
    spread : float or FitSpread
        Relative spread of e/c and of e/a; or that of all five ratios, from a fit.
    T, delay, blend : float, optional
        Time between samples and the longest time from the sample to
        the voltage, in s; as in `Firmware`. Without them those of
        ``robot``.
    robot : Robot, optional
        The description; the thesis's robot without it.
    Q : (5,) or (5, 5) array_like, optional
        Weight of [theta, phi, theta', phi', x3], or its diagonal; the
        identity without it.
    decay : float
        The decay rate behind the hold, in 1/s, if it can be proven; else the
        largest of some shares of it that can.
    peak : float
        The largest peak of the sensitivity; above it nothing is written.
    **more
        cells, identified and data of `Deployment`.

    Returns
    -------
    Deployment
        The controller and all that is known of it.

    Raises
    ------
    ValueError
        On bad input, or where there is no design; it says why.
    """
    clock = {"T": T, "delay": delay, "blend": blend}
    robot = (robot or Robot.shipped("thesis")).but(
        **{k: x for k, x in clock.items() if x is not None}
    )
    if R is not None:
        positive("R", R)
    if positive("peak", peak) <= 1:
        raise ValueError(f"peak must be above 1, got {peak!r}")
    if finite("decay", decay) < 0:
        raise ValueError(f"decay must be 0 or more, in 1/s, got {decay!r}")
    tilt = recoverable_tilt(mip, robot.limit)
    if tilt < LEAST_TILT:
        raise ValueError(
            f"the motors are too weak: {robot.limit:g} V can bring the robot "
            f"back from {np.degrees(tilt):.1f} degrees at most. It takes "
            f"{robot.limit * LEAST_TILT / tilt:.0f} V or stronger motors for "
            f"{np.degrees(LEAST_TILT):.0f} degrees"
        )
    Q = np.eye(5) if Q is None else np.asarray(Q, float)
    Q = np.diag(Q) if Q.ndim == 1 else Q
    if robot.law == "gain":
        designed = design(mip, robot, spread, Q, R, peak)
        delayed = prove(polytope(mip, spread), U, robot, designed.certify().K, decay)
    else:
        designed, delayed = design_optimal(mip, robot, spread, Q, R, peak), None
    return Deployment(
        mip,
        spread,
        designed,
        delayed,
        robot.T,
        robot.delay,
        robot.blend,
        robot=robot,
        peak=peak,
        **more,
    )


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
