"""The header of a robot's program."""

import numpy as np

from .. import __version__
from ..runtime.digests import digest
from .firmware import SOFTNESS
from .rest import BRIDGE_STEPS, DEAD_SHARE, LOUDER, QUIET_SHARE
from .spread import spread_words
from .tuning import recoverable_tilt
from .turning import inertia_bounds

__all__ = ["facts", "unequal"]

COARSE_SHARE = 0.5  # of the limit, by which one count may move the voltage


def facts(deployment):
    """The facts of a ``deployment``, from a word to a sentence."""
    mip, robot = deployment.mip, deployment.robot
    letters = ", ".join(f"{x} = {getattr(mip, x):.6g}" for x in "abcdef")
    return {
        **deployment.data,
        "robot": robot.words,
        "plant": f"{letters} (SI units), I_w = {mip.I_w:.6g}, J = {mip.J:.6g}",
        **_digests(deployment),
        "spread": spread_words(deployment.spread),
        **(_optimal(deployment.design) if deployment.optimal else _gain(deployment)),
        "proof of the sampled loop": _sampled(deployment),
        **_compensation(deployment),
        **_coarse(deployment),
        **(_steering(deployment.steering) if deployment.steering else {}),
        "sampling": f"T = {robot.T:g} s, computed within {robot.delay:g} s, "
        f"ticks late by at most {robot.jitter:g} s",
        "estimate": f"{robot.blend:g} of the accelerometers' tilt per "
        "tick; the proof of the sampled loop takes it for the truth",
        "sampled loop": f"spectral radius {deployment.radius:.4f}, peak "
        f"sensitivity {deployment.sensitivity:.3f}, worst of "
        f"{len(deployment.robots)} robots and {len(deployment.loops)} delays",
        **_rest(deployment),
        "reach": _reach(deployment),
        "written by": f"sosbook {__version__}",
    }


def _digests(deployment):
    """Of the plants and the proofs of the law, which `verify --code` looks for."""
    proofs = [*deployment.continuous_proofs.values()]
    proofs += [proof for row in deployment.sampled.values() for proof in row]
    proofs += deployment.varying_robots
    proofs += deployment.steering.proofs.values() if deployment.steering else ()
    proofs = [proof for proof in proofs if proof.proven]
    if not proofs:
        return {}
    plants = dict.fromkeys(digest(x.data["plant"])[:16] for x in proofs)
    files = ", ".join(f"(file sha256 {digest(x.text.encode())})" for x in proofs)
    return {
        "digests of the plants": "sha256 " + " ".join(plants),
        "proofs of the law": files,
    }


def _rest(deployment):
    """How loud it is at rest, with a warning where that is much."""
    robot, volts = deployment.robot, deployment.rest
    cure = ', or law = "observer"' if robot.law != "observer" else ""
    gears = deployment.gears
    low, high = gears.frictions
    rub = f"{high:.2g}" if low == high else f"{low:.2g} or {high:.2g}"
    words = (
        f"{volts:.2g} V rms, {100 * volts / robot.limit:.2g} % of the limit: "
        f"{LOUDER:g} times those of a simulated minute of the robot in the middle with "
        f"{robot.counts:g} counts a turn, {np.degrees(gears.play):.3g} degrees of "
        f"play, {rub} V of dry friction and a bridge of {BRIDGE_STEPS} steps that "
        f"gives nothing below {100 * DEAD_SHARE:g} %; this run decides, for describing "
        "functions of a play foresee no cycle of robots that hum"
    )
    if volts <= QUIET_SHARE * robot.limit:
        return {"at rest": words}
    return {
        "at rest": words,
        "warning, at rest": "the motors chatter: take a larger R, encoders with more "
        f"counts, gears with less play{cure}",
    }


def _reach(deployment):
    """From which tilts: what bounds every law, and what this program is seen to do."""
    robot = deployment.robot
    bound, tip = recoverable_tilt(deployment.mip, robot.limit), robot.tip
    most = (
        f"no law can from more than {np.degrees(bound):.0f} degrees at rest, by the "
        f"linear plant and {robot.limit:g} V"
        if bound < tip
        else f"the motors go off beyond tip = {np.degrees(tip):.0f} degrees"
    )
    return (
        f"{most}. Simulated, not proven: with all faults on, and the largest delay, "
        f"each of {len(deployment.robots)} robots stands up from "
        f"{np.degrees(deployment.reach):.0f} degrees at rest"
    )


def _gain(deployment):
    """Of a gain: how it was found, and its proofs in continuous time."""
    cost = deployment.design.request.cost
    return {
        "specification": "least quadratic cost (Theorem 2.4, vertices "
        f"and pairs), Q = {_weights(cost.Q)}, R = {cost.R[0, 0]:g}, U = [0 1]",
        "gain": " ".join(f"{k:.6g}" for k in deployment.certificate.K[0]),
        "proof": "; ".join(deployment.certificate.claims) or "none",
        "proof with the hold": "; ".join(deployment.held.claims) or "none",
    }


def _optimal(design):
    """Of an `OptimalLaw`: what it is."""
    rows = ("; ".join(f"{m:.6g}" for m in row) for row in design.M)
    return {
        "specification": "sampled and delay-aware least quadratic cost for the plant "
        "in the middle, behind a Kalman filter of theta, phi and theta', Q = "
        f"{_weights(design.Q)}, R = {design.R:g}, U = [0 1]",
        "gain": " ".join(f"{k:.6g}" for k in design.K[0]),
        "observer": "gain " + " | ".join(rows),
    }


def _compensation(deployment):
    """The facts with friction compensated; empty without."""
    volts = deployment.robot.compensation
    if not volts:
        return {}
    sector, peak = 1 + 1 / SOFTNESS, deployment.sensitivity
    return {
        "compensation": f"{volts:g} V against friction: the gain from the law to the "
        f"voltage lies between 1 and {sector:g} and varies. The proofs are about the "
        f"law without it. With it the {len(deployment.robots)} x "
        f"{len(deployment.loops)} sampled loops below are stable by the circle "
        f"criterion, in floats: a peak sensitivity of {peak:.3f} allows every gain "
        f"from 1 to {peak / (peak - 1):.3f}, however it varies"
    }


def _coarse(deployment):
    """A warning where one count of an encoder takes half of the voltage there is.

    Between two counts the wheels' rate is nothing or a count a tick, and the law
    answers a count by so many volts for a tick: two in opposite senses are then as
    much as the motors can get, which no proof of a linear loop has.
    """
    robot, gain = deployment.robot, deployment.law.D[0]
    volts = 2 * np.pi / robot.counts * abs(gain[1] + gain[3] / deployment.law.T)
    if volts < COARSE_SHARE * robot.limit:
        return {}
    return {
        "warning, counts": f"one count of an encoder moves V by {volts:.3g} V for a "
        f"tick, and limit = {robot.limit:g} V: the motors will shake. Take encoders "
        'with more counts, a larger R, a larger T, or law = "observer"'
    }


def _steering(design):
    """The facts of the law that holds the heading."""
    robot, law, mip = design.robot, design.law, design.robots[0]
    low, high = inertia_bounds(mip, robot)
    cost = design.design.request.cost
    proven = all(x.proven for row in design.sampled.values() for x in row)
    delays = ", ".join(f"{1000 * late:g}" for late in design.sampled)
    return {
        "steering": f"the right motor's volts less the left's, at most {law.volts:.6g} "
        "V on either side and what balancing leaves. Of the wheels' difference, its "
        f"rate and its sum, least quadratic cost (Theorem 2.4), Q = I, "
        f"R = {cost.R[0, 0]:g}, U = 1, poles damped and decaying as the proof says; "
        "gain "
        + " ".join(f"{k:.6g}" for k in law.K[0])
        + f"; {law.per_radian:.6g} rad of it are a radian of heading",
        "steering's plants": f"a_d delta'' + f delta' = e W, a_d from {low:.6g} to "
        f"{high:.6g} kg m^2 in the middle; a_d / e and f / e in the rectangle around "
        "the balance's spread",
        "steering's proof": "; ".join(
            [*design.certificate.claims, *design.held.claims]
            + proven * [f"sampled, stable for each of the delays {delays} ms"]
        ),
        "motors that differ": unequal(design),
    }


def unequal(design):
    """The header's words on both loops as one, where the motors differ; ``design`` is
    the `SteeringDesign` of the robot.
    """
    share, many = 100 * design.robot.unequal, len(design.robots)
    floats = (
        f"with one motor stronger by {share:g} % and the other weaker both loops as "
        f"one have the spectral radius {design.coupled_radius:.4f}, in floats, worst "
        f"of {many} robots, two inertias and {len(design.sampled)} delays"
    )
    equal = (
        "the proofs above are of equal motors, with which neither law feels the other"
    )
    if not design.unequal_proven:
        return f"{equal}. Of motors that differ nothing is proven: {floats}"
    return (
        f"{equal}. Proven, too: both loops as one, sampled, are stable for every e and "
        f"f of the right motor up to {share:g} % above or below the mean, and the "
        f"left's as much below or above it, for each of {many} robots (the middle and "
        f"the corners of the spread), either bound of the inertia and each of these "
        f"delays. Of robots between these that isn't proven. In floats: {floats}"
    )


def _weights(Q):
    if np.array_equal(Q, np.eye(5)):
        return "I"
    return "diag(" + ", ".join(f"{q:g}" for q in np.diag(Q)) + ")"


def _sampled(deployment):
    """Of which clocks the sampled loop is proven stable, and of which it isn't."""
    robot, proofs = deployment.robot, deployment.sampled
    if not all(x.proven for row in proofs.values() for x in row):
        return "none"
    words = (
        "every constant plant of the polytope, with this law and its estimates of "
        "theta, phi and phi', is stable for "
    )
    T, late = 1000 * robot.T, 1000 * robot.jitter
    varies = (
        f"every sequence of delays from 0 to {1000 * robot.delay:g} ms"
        + f" and of ticks from {T - late:g} to {T + late:g} ms apart" * (late > 0)
    )
    if deployment.varying:
        return words + varies
    delays = ", ".join(f"{1000 * late:g}" for late in proofs)
    words += f"each of the constant delays {delays} ms"
    if not deployment.optimal:
        return words
    if many := len(deployment.varying_robots):
        words += (
            f"; and each of {many} robots, in the middle and at the corners of the "
            f"spread, for {varies}"
        )
    where = "robots between these" if many else "delays and ticks that vary"
    return words + (
        f". That isn't proven of {where}: patience = 300 (--patience 300) tries it "
        "for so many seconds"
    )
