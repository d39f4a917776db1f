"""Checks of two logs by their fits, and by the agreement of these."""

import numpy as np
from scipy.optimize import least_squares

from ..analysis import doubts
from .experiments import STICTION_SPEED
from .log_checks import Subject
from .srivc import respond

__all__ = ["check_fit", "check_fits", "lateness", "wheel_lateness", "widened"]

CONTRADICTION_LIMITS = (0.97, 1.03), (0.8, 1.25)  # beyond: a warning; a refusal
RESIDUAL_LIMITS = 0.05, 0.25  # residual over signal, rms: a warning; a refusal
LATENESS_TRIED = 3  # samples of delay that are tried, either way
UNMODELLED = (
    "friction, a late sensor, spikes, or play in the gears, which a larger amplitude "
    "makes small"
)
#: Of each number but d/c where gears rub, one standard deviation: what no log of such
#: a robot knows, its battery's sag, its bridge's dead zone, its gyro's scale and how
#: soft its gears' teeth are.
UNKNOWN_SHARE = 0.02
WEAK_MOTOR, UNEQUAL_MOTORS = 0.5, 0.8  # of the other one: a refusal; a warning
SHEET_SHARE, WATCH_SHARE = 0.25, 0.05  # so far off may a sheet be, and a stopwatch
MOVES = 8.0  # times the later residual: dry gears alone leave five times as much
MOST_APART = 1.25  # so far apart may both wheels' e/a be
LEAST_WHEEL = 0.1  # of M_w r^2, a wheel's inertia; a disc has 0.5, a rim 1
LATE_IF_BETTER_THAN = 0.8  # of the residual: so much less says that a sample is late
PLAUSIBLE_SPEEDS = 1.0, 120.0  # rad/s, of free wheels under the whole voltage
PLAUSIBLE_RATIOS = {  # of robots from 0.1 to 100 kg, SI units
    "e_c": (0.01, 2000.0),
    "f_c": (0.005, 1000.0),
    "d_c": (2.0, 2000.0),
    "e_a": (1.0, 2e4),
    "f_a": (0.5, 5000.0),
}


def check_fits(identified, body, wheels, robot):
    """Look for signs that the fits, or what was logged, are wrong.

    ``identified``: the fits; ``body``, ``wheels``: the logs they were made of;
    ``robot``: the robot's description. Returns what speaks against the fits; empty if
    nothing does.
    """
    return [
        *_together(identified, robot),
        *_description(identified.mip, robot),
        *check_fit("body", (identified.body,), body, robot.counts),
        *check_fit("wheels", identified.wheels, wheels, robot.counts),
    ]


def _together(identified, robot):
    """Findings on logs of two robots, or of one that can't be."""
    kappa, both = identified.contradiction, Subject("both logs")
    (low, high), (least, most) = CONTRADICTION_LIMITS
    if identified.body.alone is not None:
        if not low <= kappa <= high:
            yield both.warned(
                f"f/e is the wheels' log's, which explains the body's as well as its "
                f"own that is {kappa:.3g} times as much: friction or play hides it in "
                "the body's motion. A larger amplitude says more"
            )
    elif not low <= kappa <= high:
        asked = "is the gyro in deg/s? " if 0.5 < np.degrees(kappa) < 2 else ""
        yield (both.warned if least <= kappa <= most else both.refused)(
            f"e/f by the wheels is {kappa:.3g} times e/f by the body, which "
            f"should be one on one robot: {asked}wrong counts per turn, a gyro in "
            "another unit, late or askew, V as a duty in one log, swapped "
            "columns, friction that is ignored, or play in the gears, beside which "
            "the motion is small: take friction = true and a larger amplitude"
        )
    for name, value in identified.ratios.items():
        least, most = PLAUSIBLE_RATIOS[name]
        if not least <= value <= most:
            yield both.refused(
                f"{name.replace('_', '/')} = {value:.4g} is beyond any such robot's "
                f"({least:g} to {most:g}): check the units of V, of the sensors and "
                "of t"
            )
    free = robot.limit * identified.mip.e / identified.mip.f
    least, most = PLAUSIBLE_SPEEDS
    if not least <= free <= most:
        yield both.refused(
            f"with limit = {robot.limit:g} V free wheels would turn at "
            f"{free:.3g} rad/s, and such motors' turn at {least:g} to {most:g}: "
            "is V a duty in both logs, or in mV, or limit another motor's?"
        )
    yield from _outside(identified.mip, free * 30 / np.pi, robot)


def _outside(mip, rpm, robot):
    """Findings where a sheet or a stopwatch, if described, says otherwise."""
    sheet, swings = robot.free_rpm, 20 * np.pi * np.sqrt(mip.c / mip.d)
    if sheet and abs(np.log(rpm / sheet)) > SHEET_SHARE:
        yield Subject("both logs").refused(
            f"by them a free wheel turns at {rpm:.0f} rpm under limit, and by the "
            f"sheet at {sheet:g}: is V what a motor gets, and the battery the sheet's?"
        )
    if robot.ten_swings and abs(np.log(swings / robot.ten_swings)) > WATCH_SHARE:
        yield Subject("log of the body").refused(
            f"by it ten swings take {swings:.1f} s, and by the stopwatch "
            f"{robot.ten_swings:g}: is it this body's, and t in seconds of a clock "
            "that is right?"
        )


def _description(mip, robot):
    """Findings where the described masses and lengths don't fit the logs."""
    described, rim = Subject("the description"), robot.M_w * robot.r**2
    if robot.l**2 * robot.M_b * 8 < mip.c:
        yield described.warned(
            f"the body's inertia about the axle, {mip.c:.3g} kg m^2, is over eight "
            "times M_b l^2: check l, and that M_b is in kg"
        )
    if not 1e-4 <= mip.e / robot.M_b <= 10:
        yield described.refused(
            f"e = {mip.e:.3g} N m/V for a body of {robot.M_b:g} kg: "
            "check that M_b is in kg and V in volts"
        )
    if mip.I_w < LEAST_WHEEL * rim:
        yield described.refused(
            f"by the logs a wheel has the inertia {mip.I_w:.3g} kg m^2, and no wheel "
            f"with M_w r^2 = {rim:.3g} kg m^2 has so little: check M_b, M_w and r"
        )


def check_fit(experiment, fits, log, counts):
    """Findings on the ``log`` of one ``experiment``, by its ``fits``.

    A turn of a wheel has so many ``counts``. It returns findings.
    """
    subject = Subject(f"log of the {experiment}")
    if experiment == "body":
        (fit,) = fits
        return [
            *_residuals(subject, fit, log.gyro, 0.0),
            *_start(subject, fit, log),
            *_each(subject, fit, log),
            *_late(subject, "gyro", lateness(fit, log), fit),
        ]
    findings, one = [], 2 * np.pi / counts / log.T
    for k, fit in enumerate(fits, 1):
        y = np.diff(*log.need(f"encoder{k}")) * one
        which = Subject(f"{subject}, encoder{k}") if len(fits) > 1 else subject
        findings += _residuals(which, fit, y, one)
        late = wheel_lateness(fit, y, log)
        findings += _late(subject, f"encoder{k}", late, fit)
    return [*findings, *_alike(subject, fits)]


def _residuals(subject, fit, y, quantum):
    """The size of a fit's residuals to y, whose step is ``quantum``; are they noise?"""
    relative = fit.rms / max(np.std(y), 1e-12)
    times = doubts.roughness(y, fit.residuals)
    text = f"the fit leaves {fit.rms:.3g} rad/s, {100 * relative:.2g} % of the signal"
    if fit.rms < 0.5 * quantum:
        return  # coarse counts explain it
    if relative > RESIDUAL_LIMITS[1]:
        yield subject.refused(text + ": the model isn't this log's")
    elif relative > RESIDUAL_LIMITS[0] and fit.rms > 1.5 * quantum:
        yield subject.warned(f"{text}: {UNMODELLED}?")
    elif times > doubts.STRUCTURED and relative > 0.005:
        yield subject.warned(
            f"{text}, {times:.1f} times its own noise: something isn't "
            f"modelled ({UNMODELLED})"
        )


def _start(subject, fit, log):
    """Findings on a body that wasn't at rest when a log began, by its ``fit``."""
    early = fit.residuals[log.t < log.t[0] + 1.0]
    later = fit.residuals[log.t > log.t[0] + 4.0]
    if not len(later):
        return
    first, last = (float(np.sqrt(np.mean(x**2))) for x in (early, later))
    if first > MOVES * last and first > RESIDUAL_LIMITS[0] * np.std(log.gyro):
        yield subject.refused(
            f"in the first second the model is off by {first:.2g} rad/s, later by "
            f"{last:.2g}: the body moves when the log begins. Start it at rest"
        )


def _each(subject, fit, log):
    """Findings on a motor that, alone, moves the body less than the other."""
    if log.alone is None:
        return
    volts = np.array([log.V * (log.alone == side) for side in (1, 2)])
    moved = respond([-fit["e_c"], 0.0], [1.0, fit["f_c"], fit["d_c"]], volts, log.T).T
    left, right = 1 + np.linalg.lstsq(moved, fit.residuals, rcond=None)[0]
    name, other = ("left", "right") if left < right else ("right", "left")
    share = min(left, right) / max(left, right)
    said = f"alone, the {name} motor moves the body {share:.2g} times as much as the "
    if share < WEAK_MOTOR:
        why = "is it dead, unplugged or reversed, or does its wheel slip?"
        yield subject.refused(f"{said}{other} one: {why}")
    elif share < UNEQUAL_MOTORS:
        why = "gears that rub, or motors that differ: unequal in robot.toml bears it"
        yield subject.warned(f"{said}{other} one: {why}")


def _alike(subject, fits):
    """Findings on wheels that, by their ``fits``, turn differently by one voltage."""
    ratio = fits[0]["e_a"] / fits[-1]["e_a"]
    if not 1 / MOST_APART <= ratio <= MOST_APART:
        yield subject.refused(
            f"under the same V encoder1 moves {ratio:.3g} times as much as encoder2: "
            "has one lost a channel, or other counts per turn? Does a wheel touch "
            "something?"
        )


def _late(subject, column, late, fit):
    """Findings on a column that is so many samples late; play may cause it."""
    if late:
        yield (subject.warned if "play" in fit.names else subject.refused)(
            f"{column} seems to be {abs(late):g} sample(s) "
            f"{'late' if late > 0 else 'early'} against V: read the sensors "
            "before V acts, in the same row"
        )


def lateness(fit, log):
    """By how many samples the gyro of a log is later than a ``fit``.

    A linear body with a shifted V is fitted to the log, to which the
    gears' friction and the pendulum's sine are added as the fit has them:
    zero unless another shift leaves clearly less.
    """
    w = log.gyro - fit.residuals - fit["offset"]
    angle = np.cumsum(w) * log.T
    extra = np.tanh(w / STICTION_SPEED), angle - np.sin(angle)

    def columns(V, f, d):
        inputs = np.array([V, *extra])
        moved = respond([1.0, 0.0], [1.0, f, d], inputs, log.T)
        return np.vstack([moved, np.ones(len(log.t))]).T

    return _late_by(log.V, log.gyro, columns, fit["f_c"], fit["d_c"])


def wheel_lateness(fit, y, log):
    """By how many samples an encoder is later than a ``fit``.

    As `lateness`, of the wheel's mean speeds y between the samples of a log.
    """
    rub, T = np.tanh(np.append(0.0, y - fit.residuals) / STICTION_SPEED), log.T

    def columns(V, f):
        return np.diff(respond([1.0], [1.0, f, 0.0], np.array([V, rub]), T)).T / T

    return _late_by(log.V, y, columns, fit["f_a"])


def _late_by(V, y, columns, *start):
    """The shift of V that leaves clearly less of y than none does, or 0.

    For each that is tried the numbers that ``start`` so are fitted anew, and the
    gains of the ``columns`` that V and they make.
    """

    def rms(shift):
        moved = _moved(V, shift)

        def residuals(scales):
            numbers = np.array(start) * np.exp(np.clip(scales, -1, 1))
            A = columns(moved, *numbers)
            return y - A @ np.linalg.lstsq(A, y, rcond=None)[0]

        fitted = least_squares(
            residuals, np.zeros(len(start)), diff_step=1e-4, max_nfev=6
        )
        return float(np.sqrt(np.mean(fitted.fun**2)))

    shifts = range(-LATENESS_TRIED, LATENESS_TRIED + 1)
    residuals = {shift: rms(shift) for shift in shifts}
    shift = min(residuals, key=residuals.get)
    return shift if residuals[shift] < LATE_IF_BETTER_THAN * residuals[0] else 0


def _moved(V, shift):
    """V that comes ``shift`` samples later; zero before."""
    V = np.roll(V, shift)
    V[: max(shift, 0)] = 0
    if shift < 0:
        V[shift:] = 0
    return V


def widened(identified):
    """Standard deviations of the ratios, widened by what disagrees.

    To what noise explains, each of the four ratios gets a quarter of
    the disagreement of e/f, which is what the pendulum in the middle
    moves it by, and e/a and f/a half the difference of the two wheels. It counts
    up to the largest that is allowed; more says that a log doesn't know e/f. What a
    fit with a play leaves, its misfit, is taken for two standard deviations; where
    gears rub comes `UNKNOWN_SHARE`.

    ``identified``: the fits. Returns (5,): in the order of ``identified.ratios``.
    """
    most = CONTRADICTION_LIMITS[1][1]
    apart = abs(np.log(np.clip(identified.contradiction, 1 / most, most))) / 4
    variance = np.diag(identified.covariance).copy()
    for k, (name, value) in enumerate(identified.ratios.items()):
        if name != "d_c":
            rubs = "friction" in identified.body.names
            variance[k] += (apart**2 + rubs * UNKNOWN_SHARE**2) * value**2
        fit = identified.body if name.endswith("c") else identified.wheels[0]
        variance[k] += (fit.misfit * value / 2) ** 2
        if name in ("e_a", "f_a"):
            variance[k] += np.ptp([fit[name] for fit in identified.wheels]) ** 2 / 4
    return np.sqrt(variance)
