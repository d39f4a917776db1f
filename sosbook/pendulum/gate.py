"""Whether two logs may speak for a robot: what a fit alone can't see.

Least squares give numbers for any log. Here each log, each fit and
their agreement are held against what a working robot does.
"""

from dataclasses import dataclass

import numpy as np

from .identify import identify
from .srivc import respond

__all__ = ["Finding", "Inspection", "check_fits", "check_log", "refused",
           "widened"]

KAPPA = (0.97, 1.03), (0.8, 1.25)  # beyond: a warning; a refusal
UNLIKE = 0.05, 0.25  # residual over signal, rms: a warning; a refusal
NOISE = 3.0  # times its own jitter, a residual is more than noise
SPIKE = 12.0  # times the usual step away from both neighbours
CLIPPED = 4  # samples in a row at the very largest value
REST = 10  # samples
LATE = 3  # samples of delay that are tried, either way
BETTER = 0.8  # of the residual: so much less says that a sample is late
FASTEST = 60.0  # rad/s, 573 rpm at the wheel or 3400 deg/s of a body
VOLTS = 0.2, 60.0  # of a plausible chirp
CLOCK = 1e-3, 0.1  # s
RATIOS = {  # of plausible robots, SI units
    "e_c": (0.5, 2000.0), "f_c": (0.05, 1000.0), "d_c": (5.0, 2000.0),
    "e_a": (2.0, 2e4), "f_a": (0.5, 5000.0)}


@dataclass(frozen=True)
class Finding:
    """Something about the logs that a working robot doesn't do.

    Parameters
    ----------
    severity : {"refused", "warning"}
    subject : str
        The log or the fit.
    text : str
        What is wrong, and what it may come from.
    """

    severity: str
    subject: str
    text: str

    def __str__(self):
        return f"{self.subject}: {self.text}"


def refused(findings):
    """The findings that forbid a program, unless it is forced."""
    return [f for f in findings if f.severity == "refused"]


@dataclass(frozen=True, eq=False)
class Inspection:
    """Two logs, what they say of a robot, and what speaks against it.

    Parameters
    ----------
    robot : Robot
    body, wheels : Log
    identified : Identified or None
        None where the logs give no pendulum at all.
    findings : tuple of Finding
    """

    robot: object
    body: object
    wheels: object
    identified: object
    findings: tuple

    @classmethod
    def of(cls, body, wheels, robot):
        """Check the logs, fit them, and check the fits."""
        findings = [*check_log("body", body, robot),
                    *check_log("wheels", wheels, robot)]
        found = None
        try:
            found = identify(body, wheels, **robot.identification)
        except ValueError as error:
            findings.append(Finding("refused", "the fit", str(error)))
        else:
            findings += check_fits(found, body, wheels, robot)
        return cls(robot, body, wheels, found, tuple(findings))

    @property
    def refusal(self):
        """Why these logs give no program, one reason a line."""
        lines = [f"- {f}" for f in refused(self.findings)]
        more = "" if self.identified is None else (
            "\nIf all this is right, force=True (--force) goes on with "
            "them, and the program says so")
        return "these logs give no program:\n" + "\n".join(lines) + more


def check_log(name, log, robot=None):
    """What can be seen in one log before any fit.

    Parameters
    ----------
    name : {"body", "wheels"}
    log : Log
    robot : Robot, optional
        Its counts and its gyro's range.

    Returns
    -------
    list of Finding
    """
    found, subject = [], f"log of the {name}"

    def say(severity, text):
        found.append(Finding(severity, subject, text))

    low, high = CLOCK
    if not low <= log.T <= high:
        say("refused", f"samples are {log.T:g} s apart, which is no robot's "
            "clock: t must be in seconds (not in ms)")
    top = abs(log.V).max()
    if not VOLTS[0] <= top <= VOLTS[1]:
        say("refused", f"V reaches {top:g}: it must be in volts, not a duty "
            "or mV")
    elif robot and top > 1.05 * robot.limit:
        say("refused", f"V reaches {top:g} V, but limit = {robot.limit:g} V: "
            "are V and the description about the same motors?")
    if abs(log.V[:REST]).max() == 0 and len(set(log.V)) < 5:
        say("refused", "V hardly changes: it needs a chirp")
    columns = ["gyro"] if name == "body" else [
        x for x in ("encoder1", "encoder2") if getattr(log, x) is not None]
    for column in columns:
        _check_column(say, log, column, *log.need(column), robot)
    return found


def _check_column(say, log, column, y, robot):
    """One sensor's column; ``say`` takes what is found."""
    whole = bool((y == np.round(y)).all())
    if column == "gyro":
        rate = y
        if whole and np.ptp(y) > 10:
            say("refused", "gyro has whole numbers: is it raw, or an "
                "encoder's column? It must be in rad/s")
    else:
        turn = 2 * np.pi / (robot.counts if robot else 2000.0)
        rate = np.diff(y) * turn / np.diff(log.t)
        if not whole:
            say("refused", f"{column} has fractions: it must be in counts, "
                "not in rad or degrees, and no gyro's column")
    fast = np.quantile(abs(rate), 0.98)
    if fast > FASTEST:
        say("refused", f"{column} means {fast:.3g} rad/s, faster than such "
            "robots are: " + (
                "is it in deg/s? It must be in rad/s" if column == "gyro"
                else "are the counts per turn right?"))
    step = np.diff(y)
    usual = np.quantile(abs(np.diff(step)), 0.9) + 1e-12
    alone = (abs(np.diff(step)) > SPIKE * usual) & (step[1:] * step[:-1] < 0)
    if alone.any():
        row = int(np.flatnonzero(alone)[0]) + 2
        say("refused", f"{column} has {alone.sum()} spike(s), the first in "
            f"row {row + 1} (t = {log.t[row - 1]:g} s): a glitch of the "
            "bus? Cut the log there or record it anew")
    if column == "gyro":
        _check_gyro(say, y, robot)


def _check_gyro(say, y, robot):
    top = max(abs(y.max()), abs(y.min()))
    for end in (y.max(), y.min()):
        runs, longest = 0, 0
        for at in y == end:
            runs = runs + 1 if at else 0
            longest = max(longest, runs)
        if longest >= CLIPPED and abs(end) > 0.5 * top and top > 0:
            say("refused", f"gyro stays at {end:.4g} rad/s for {longest} "
                "samples: it is clipped. Widen its range or lower V")
            return
    if robot and top > 1.01 * robot.gyro_range:
        say("refused", f"gyro reads {top:.3g} rad/s, more than gyro_range = "
            f"{robot.gyro_range:g} rad/s")
    elif robot and top > 0.98 * robot.gyro_range:
        say("refused", f"gyro reads {top:.3g} rad/s: it is clipped at "
            f"gyro_range = {robot.gyro_range:g} rad/s")


def check_fits(found, body, wheels, robot):
    """What the fits and their agreement say.

    Parameters
    ----------
    found : Identified
    body, wheels : Log
    robot : Robot

    Returns
    -------
    list of Finding
    """
    reports, kappa = [], found.contradiction
    (low, high), (least, most) = KAPPA
    if not low <= kappa <= high:
        reports.append(Finding(
            "warning" if least <= kappa <= most else "refused", "both logs",
            f"e/f by the wheels is {kappa:.3g} times e/f by the body, which "
            "should be one on one robot: wrong counts per turn, a gyro in "
            "another unit or late, V as a duty in one log, swapped columns, "
            "or friction that is ignored"))
    for name, value in found.ratios.items():
        least, most = RATIOS[name]
        if not least <= value <= most:
            reports.append(Finding(
                "refused", "both logs", f"{name.replace('_', '/')} = "
                f"{value:.4g} is beyond any such robot's ({least:g} to "
                f"{most:g}): check the units of V, of the sensors and of t"))
    I_b = found.mip.c - robot.M_b * robot.l**2
    if I_b < 0:
        reports.append(Finding(
            "refused", "the description", f"M_b l^2 is larger than the "
            f"body's inertia about the axle, {found.mip.c:.3g} kg m^2, that "
            "the log gives: check M_b and l"))
    if robot.l**2 * robot.M_b * 8 < found.mip.c:
        reports.append(Finding(
            "warning", "the description", f"the body's inertia about the "
            f"axle, {found.mip.c:.3g} kg m^2, is over eight times M_b l^2: "
            "check l, and that M_b is in kg"))
    if not 1e-4 <= found.mip.e / robot.M_b <= 10:
        reports.append(Finding(
            "refused", "the description",
            f"e = {found.mip.e:.3g} N m/V for a body of {robot.M_b:g} kg: "
            "check that M_b is in kg and V in volts"))
    reports += _check_fit("log of the body", found.body, body.gyro, 0.0)
    for k, fit in enumerate(found.wheels, 1):
        (count,) = wheels.need(f"encoder{k}")
        one = 2 * np.pi / robot.counts / wheels.T
        reports += _check_fit(
            "log of the wheels" + f", encoder{k}" * (len(found.wheels) > 1),
            fit, np.diff(count) * one, one)
    reports += _check_start(found.body, body)
    late = lateness(found, body)
    if late:
        reports.append(Finding(
            "refused" if abs(late) >= 1 else "warning", "log of the body",
            f"gyro seems to be {abs(late):g} sample(s) "
            f"{'late' if late > 0 else 'early'} against V: read the sensors "
            "before V acts, in the same row"))
    return reports


def _check_fit(subject, fit, y, quantum):
    """The size of the residuals, and whether they are noise."""
    size = fit.rms / max(np.std(y), 1e-12)
    rough = np.std(np.diff(fit.residuals)) / 2**0.5
    floor = max(rough, quantum / 12**0.5)
    text = (f"the fit leaves {fit.rms:.3g} rad/s, {100 * size:.2g} % of the "
            "signal")
    if fit.rms < 0.5 * quantum:
        return []  # coarse counts explain it
    if size > UNLIKE[1]:
        return [Finding("refused", subject, text + ": the model isn't this "
                        "log's")]
    if size > UNLIKE[0] and fit.rms > 1.5 * quantum:
        return [Finding("warning", subject, text + ": friction, a late "
                        "sensor or spikes?")]
    if fit.rms > NOISE * floor and size > 0.005:
        return [Finding("warning", subject, text + f", {fit.rms / floor:.1f} "
                        "times its own noise: something isn't modelled "
                        "(friction, backlash, a late sensor)")]
    return []


def _check_start(fit, log):
    """Whether the body was at rest when the log began."""
    early = fit.residuals[log.t < log.t[0] + 1.0]
    later = fit.residuals[log.t > log.t[0] + 4.0]
    if not len(later):
        return []
    first, last = (float(np.sqrt(np.mean(x**2))) for x in (early, later))
    if first > 4 * last and first > UNLIKE[0] * np.std(log.gyro):
        return [Finding(
            "refused", "log of the body", "in the first second the model is "
            f"off by {first:.2g} rad/s, later by {last:.2g}: the body moves "
            "when the log begins. Start it at rest")]
    return []


def lateness(found, log):
    """By how many samples the gyro follows V later than the model.

    The linear fit of a shifted V, least squares in its gains alone, is
    compared: zero unless another shift is clearly better.
    """
    e, f, d = (found.body[x] for x in ("e_c", "f_c", "d_c"))
    sizes = {}
    for shift in range(-LATE, LATE + 1):
        V = np.roll(log.V, shift)
        V[:max(shift, 0)] = 0
        if shift < 0:
            V[shift:] = 0
        best = np.inf
        for x in (0.8, 0.9, 1.0, 1.1, 1.25):
            for z in (0.8, 0.9, 1.0, 1.1, 1.25):
                y = respond([-e, 0.0], [1.0, x * f, z * d], V, log.T)
                y = np.array([y, np.ones(len(y))]).T
                _, rest, *_ = np.linalg.lstsq(y, log.gyro, rcond=None)
                best = min(best, float(rest[0]) if len(rest) else np.inf)
        sizes[shift] = best**0.5
    shift = min(sizes, key=sizes.get)
    return shift if sizes[shift] < BETTER * sizes[0] else 0


def widened(found):
    """Standard deviations of the ratios, widened by what disagrees.

    To what noise explains, each of the four ratios gets a quarter of
    the disagreement of e/f, which is what the pendulum in the middle
    moves it by, and e/a and f/a half the difference of the two wheels.

    Returns
    -------
    (5,) array
        In the order of ``found.ratios``.
    """
    apart = abs(np.log(found.contradiction)) / 4
    variance = np.diag(found.covariance).copy()
    for k, (name, value) in enumerate(found.ratios.items()):
        if name != "d_c":
            variance[k] += (apart * value) ** 2
        if name in ("e_a", "f_a"):
            variance[k] += np.ptp([fit[name] for fit in found.wheels])**2 / 4
    return np.sqrt(variance)
