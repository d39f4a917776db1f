"""From two logs to a C program: identify, design, prove, write.

``python -m sosbook.pendulum robot.toml body.csv wheels.csv folder`` does it
all.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np

from ..runtime.digests import digest
from ..runtime.reading import read_bytes
from .fit_spread import FitSpread
from .gate import Inspection, refused, widened
from .log import Log
from .proven import Deployment
from .rig import DATA
from .robot import Robot

__all__ = ["Deployment", "deploy", "described", "inspect", "recommend"]

SPREAD = 0.04  # of e/c and e/a, at least: that of (4.25)


def recommend(mip, R=20.0, **asked):
    """The controller that this book recommends for a robot.

    A robot whose description has no law gets the observer; or the gain, where that is
    proven and the observer isn't. The header says why.

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
    if asked.get("robot") and not asked["robot"].law:
        return _or_gain(found)
    _ = found.design, found.delayed  # where there is none, it says so now
    return found


def _or_gain(found):
    """The ``found`` observer, or where it isn't proven the gain that is, and why."""
    try:
        why = ". ".join(found.lacking_sampled)
    except ValueError as error:
        why = str(error)
    if not why:
        return found
    law = f"gain, since of the {found.robot.law} it is said: {why}"
    gain = replace(
        found, robot=found.robot.but(law="gain"), data=found.data | {"law": law}
    )
    try:
        if gain.delayed and not gain.lacking_sampled:
            return gain
    except ValueError:  # no gain either
        pass
    _ = found.design  # says again what it said
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
        logs, a box that holds the robot with this probability. Not beside ``spread``.
        Without both the spread of e/c and e/a is that of (4.25), or the logs' own
        95 % interval where that is wider.
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
    asked.setdefault("spread", least_spread(identified.ratios, sd))
    data = {
        f"log of the {name}": f"{Path(path).name}, sha256 {digest(read_bytes(path))}"
        for name, path in (("body", body), ("wheels", wheels))
    }
    data["identified"] = ", ".join(
        f"{name.replace('_', '/')} = {value:.5g} +- {1.96 * s:.2g}"
        for (name, value), s in zip(identified.ratios.items(), sd)
    )
    data["what the numbers mean"] = in_words(identified.mip, seen.robot.limit)
    data["of these intervals"] = covered(identified.ratios, sd, asked["spread"])
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


def least_spread(ratios, sd):
    """That of (4.25), or what holds the 95 % intervals of e/c and e/a.

    The ``sd`` are the standard deviations of the ``ratios``, in their order.
    """
    known = dict(zip(ratios, sd))
    widest = max(1.96 * known[x] / ratios[x] for x in ("e_c", "e_a"))
    if widest <= SPREAD:
        return SPREAD
    if widest >= 1:
        raise ValueError(
            f"the logs know e/c or e/a to {100 * widest:.0f} % only, which no program "
            "can stand: sweep longer, or with a larger V"
        )
    return float(np.ceil(1000 * widest) / 1000)


def covered(ratios, sd, spread):
    """Which of the ratios' 95 % intervals the proven set holds, in words.

    The ``sd`` are the standard deviations of the ``ratios``, of which the ``spread``
    is a number or a `FitSpread`.
    """
    if isinstance(spread, FitSpread):
        return "the proofs' robots are those of the box below, of all five"
    words = []
    for (name, value), s in zip(ratios.items(), sd):
        half = 1.96 * s / value
        if half > (spread if name in ("e_c", "e_a") else 0):
            words.append(f"{name.replace('_', '/')} ({100 * half:.2g} %)")
    return (
        f"NOT in the proofs' robots: {', '.join(words)}, beyond the spread below; "
        "confidence = 0.99 (--confidence 0.99) takes all five"
    )


def in_words(mip, limit):
    """Facts on a pendulum for a data sheet, a pair of scales and a stopwatch.

    Both motors of the ``mip`` get the ``limit``, in V.
    """
    inertia = mip.c - mip.J
    return (
        f"each motor stalls at {mip.e * limit / 2:.3g} N m and runs freely at "
        f"{30 / np.pi * limit * mip.e / mip.f:.0f} rpm with {limit:g} V: what does "
        f"the sheet say? The body's inertia about the axle is {inertia:.3g} kg m^2, a "
        f"wheel's {mip.I_w - mip.J / 2:.3g}. Unpowered and upside down, without the "
        f"gears' drag, ten swings take {20 * np.pi * np.sqrt(mip.c / mip.d):.1f} s by "
        "a stopwatch"
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
