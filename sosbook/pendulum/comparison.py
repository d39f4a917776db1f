"""A robot against its model: what the log of a running program shows."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..display.escape import page_text
from .fit_spread import FitSpread
from .log_checks import Subject
from .modelled import Model
from .report import PAGE, curve, write_page
from .ticks import STEER_COLUMNS, TickLog
from .tracking import Heading, Tracking, track, track_heading
from .turning import turning_plants

__all__ = ["Comparison", "compare"]

REPLAY_SHARE = 1e-3  # of the limit: so far may a replayed voltage be off
FULL_SHARE = 0.05  # of the ticks at the voltage's limit, which is a lot
LATE_TICKS = 0.01  # share of the ticks that may be later than the description says
LEAST_COUNTS = 2.0  # a tick, rms: slower wheels say too little of the robot
RUBBING_SHARE = 0.02  # of the limit: more friction than that is worth a word


HEADING_WORDS = {
    "inertia": "a_d/e of the turn (V s^2)",
    "damping": "f/e of the turn (V s)",
    "stronger": "the right motor's e above the mean",
    "braking": "the right motor's f above the mean",
}


@dataclass(frozen=True, eq=False)
class Comparison:
    """The log of a running program beside what the program was made for.

    ``model``: the pendulum, the robot's description and the law; ``log``: what the
    program logged; ``tracking``: the pendulum in the log; None where it doesn't move
    enough; ``findings``: what the log shows that the model and the proofs don't have;
    ``turning``: how the robot in the log turns; None where it doesn't, or not enough.
    """

    model: Model
    log: TickLog
    tracking: Tracking | None
    findings: tuple
    turning: Heading | None = None

    @property
    def within(self):
        """True if the robot is within what was proven: True, False or None.

        None is undecided: the log allows both. Of a robot that steers both the
        balance and the heading must be.
        """
        parts = [self.balance_within]
        if self.model.steering:
            parts.append(self.heading_within)
        return False if False in parts else None if None in parts else True

    @property
    def heading_within(self):
        """The same of the plants behind the heading, and of unequal motors."""
        if self.turning is None:
            return None
        bounds = heading_bounds(self.model)
        return _inside([*map(self.turning.interval, bounds)], bounds.values())

    @property
    def balance_within(self):
        """The same of the pendulum alone."""
        if self.tracking is None:
            return None
        ends = [self.tracking.interval(name) for name in ("body", "wheels")]
        if isinstance(self.model.spread, FitSpread):
            return self._within_fit(*ends)
        return _inside(ends, 2 * [(1 - self.model.spread, 1 + self.model.spread)])

    def _within_fit(self, body, wheels):
        """The same for a `FitSpread` and the intervals of e/c and e/a."""
        moved = [[0, e - 1, 0, e / w - 1] for e in body for w in wheels]
        places = self.model.spread.places(moved)
        if ((places > 1).all(axis=0) | (places < -1).all(axis=0)).any():
            return False  # all of them lie beyond one face
        return True if (abs(places) <= 1).all() else None

    @property
    def verdict(self):
        """A sentence about `within`."""
        return {
            True: "The robot is within what was proven",
            False: "The robot is outside of what was proven: identify it again",
            None: "Undecided: this log doesn't say whether the robot is within "
            "what was proven; "
            + (
                "drive it back and forth for longer"
                if self.balance_within is None
                else "let it turn left and right while it rolls"
            ),
        }[self.within]

    @property
    def report(self):
        """Lines of text: what was found, and the verdict."""
        log = self.log
        lines = [
            f"{len(log.t)} ticks, {log.t[-1] - log.t[0]:.1f} s, tilt up to "
            f"{np.degrees(abs(log.theta).max()):.2g} degrees, V up to "
            f"{abs(log.V).max():.3g} V"
        ]
        if self.tracking:
            words = {"body": "e/c over the model's", "wheels": "e/a over the model's"}
            words |= {"back-EMF": "f over the model's", "delay": "delay (s)"}
            words |= {"friction": "friction (V)"}
            for name, value in self.tracking.values.items():
                half = 1.96 * self.tracking.sd[name]
                lines.append(f"{words[name]}: {value:.3g} +- {half:.2g}")
        if log.steers and self.model.steering:
            lines.append(self._heading_words)
        if self.turning:
            bounds = heading_bounds(self.model)
            for name, words in HEADING_WORDS.items():
                value, half = self.turning.values[name], 1.96 * self.turning.sd[name]
                low, high = bounds[name]
                lines.append(
                    f"{words}: {value:.3g} +- {half:.2g}, proven from {low:.3g} "
                    f"to {high:.3g}"
                )
        lines += [f"{f.severity}: {f}" for f in self.findings]
        return "\n".join([*lines, self.verdict])

    @property
    def _heading_words(self):
        """How far the heading was from its set point."""
        off = np.degrees(self.heading - self.log.heading)
        return (
            f"heading: up to {np.nanmax(abs(off)):.3g} degrees from its set point, "
            f"{np.sqrt(np.nanmean(off**2)):.2g} degrees rms"
        )

    @property
    def heading(self):
        """(N,) array: the heading in rad, from the wheels of a robot with a track."""
        robot = self.model.robot
        return self.log.turned * robot.r / robot.track

    @property
    def page(self):
        """The report as HTML, with pictures."""
        rows = "".join(
            f"<li>{page_text(line)}</li>" for line in self.report.split("\n")
        )
        log = self.log
        t = log.t - log.t[0]
        parts = [f"<p>{page_text(self.model.robot.words)}</p><ul>{rows}</ul>"]
        for name, unit in (("theta", "rad"), ("wheels", "rad"), ("V", "V")):
            y = np.nan_to_num(getattr(log, name))
            parts += [f"<h2>{name}</h2>", curve(t, y, f"{name} in {unit}")]
        if log.steers and self.model.steering:
            for y, name in (
                (self.heading, "heading"),
                (self.heading - log.heading, "heading beyond its set point"),
            ):
                parts += [
                    f"<h2>{name}</h2>",
                    curve(t, np.nan_to_num(y), f"{name}, rad"),
                ]
        if self.tracking:
            for y, name, unit in zip(
                self.tracking.innovations, ("gyro", "wheels"), ("rad/s", "rad")
            ):
                label = f"{name} beyond the model's prediction, {unit}"
                at = self.tracking.t - log.t[0]
                parts += [f"<h2>{name}: what isn't predicted</h2>", curve(at, y, label)]
        name = page_text(self.model.robot.name)
        return PAGE.format(title=f"Model against robot: {name}", body="\n".join(parts))


def compare(log, model):
    """Hold the log of a running program against its model.

    Parameters
    ----------
    log : TickLog or path_like
        What a program logged, or its file.
    model : Model or path_like
        What it was made for, or the folder with its programs.

    Returns
    -------
    Comparison
        The robot in the log, and what differs.

    Raises
    ------
    ValueError
        If a file isn't what it should be.
    """
    log = log if isinstance(log, TickLog) else TickLog.read(log)
    model = model if isinstance(model, Model) else Model.read(model)
    findings = [*_clock(log, model.robot), *_program(log, model), *_limits(log, model)]
    tracking, robot = None, model.robot
    step = np.diff(log.wheels[1:])
    speed = float(np.sqrt(np.nanmean(step**2))) * robot.counts / (2 * np.pi)
    if speed < LEAST_COUNTS:
        text = f"the wheels turn by {speed:.2g} counts a tick, too little to fit"
        findings.append(Subject("the motion").warned(text))
    else:
        try:
            tracking = track(log, model.mip, model.law.T, robot.counts)
        except ValueError as error:
            findings.append(Subject("the motion").warned(str(error)))
    if tracking:
        findings += _motion(tracking, robot)
    turning = None
    if model.steering and log.steers:
        late = tracking.values["delay"] if tracking else robot.delay
        try:
            turning = track_heading(log, model.law.T, robot.counts, late)
        except ValueError as error:
            findings.append(Subject("the heading").warned(str(error)))
    return Comparison(model, log, tracking, tuple(findings), turning)


def heading_bounds(model):
    """The proven bounds of the heading of a ``model``: (low, high) by name.

    The proofs are of equal motors; motors that differ were looked at as both
    loops together.
    """
    plants = turning_plants(model.mip, model.robot, model.spread)[0].vertices
    values = {
        "inertia": [p.M[0, 0] for p in plants],
        "damping": [p.D[0, 0] for p in plants],
    }
    more = model.robot.unequal
    return {
        **{name: (min(x), max(x)) for name, x in values.items()},
        "stronger": (-more, more),
        "braking": (-more, more),
    }


def _inside(ends, bounds):
    """True if intervals lie within bounds; None where one reaches beyond."""
    pairs = [(*end, *bound) for end, bound in zip(ends, bounds)]
    if any(b < low or a > high for a, b, low, high in pairs):
        return False
    return all(low <= a and b <= high for a, b, low, high in pairs) or None


def _clock(log, robot):
    """Findings on ticks that don't come when the description says."""
    step = np.diff(log.t[1:])
    late, found = step - robot.T, []
    if abs(np.median(step) / robot.T - 1) > 0.01:
        found.append(
            f"a tick takes {1000 * np.median(step):.4g} ms, but T = "
            f"{1000 * robot.T:g} ms: the program is for another clock"
        )
    allowed = robot.jitter + 0.01 * robot.T
    if log.late is not None and log.late[-1]:
        found.append(f"the program counted {log.late[-1]:.0f} late ticks")
    share = (late > allowed).mean()
    if share > LATE_TICKS:
        found.append(
            f"{100 * share:.2g} % of the ticks are late by more than jitter = "
            f"{1000 * robot.jitter:g} ms, the worst by {1000 * late.max():.3g} ms"
        )
    return [*map(Subject("the clock").warned, found)]


def _program(log, model):
    """Findings on volts that the logged readings don't give."""
    ran, texts = log.running, []
    pairs = [("volts", log.replayed(model.firmware)[ran], log.V[ran])]
    if model.steering and log.steers:
        motors = np.column_stack([log.V_left, log.V_right])
        replayed = log.replayed_motors(model.steering)
        pairs.append(("motors' volts", replayed[ran], motors[ran]))
    elif model.steering or log.steers:
        has, does = ("has", "doesn't") if log.steers else ("lacks", "does")
        why = "another program ran" + ", or they weren't logged" * (not log.steers)
        texts.append(
            f"the log {has} the columns {', '.join(STEER_COLUMNS)} of a program that "
            f"steers, and the model's {does}: {why}"
        )
    for name, ours, theirs in pairs:
        apart = abs(ours - theirs)
        if apart.size and apart.max() > REPLAY_SHARE * model.robot.limit:
            texts.append(
                f"its {name} differ by up to {apart.max():.3g} V from those that this "
                "law gives for the logged readings: another program ran, or the log "
                "has gaps"
            )
    return [*map(Subject("the program").warned, texts)]


def _limits(log, model):
    """Voltage at its limit, faults, readings that failed, the battery."""
    robot, ran, found = model.robot, log.running, []
    full = (abs(log.V[ran]) > 0.999 * robot.limit).mean() if ran.any() else 0.0
    if full > FULL_SHARE:
        found.append(f"V is at its limit in {100 * full:.0f} % of the ticks")
    if log.fault[-1] > 0:
        found.append(f"it ended with the fault {int(log.fault[-1])}")
    for name in ("gyro", "wheels"):
        lost = (~np.isfinite(getattr(log, name)[ran])).mean() if ran.any() else 0.0
        if lost:
            found.append(f"{name} said nothing in {100 * lost:.2g} % of the ticks")
    low = np.nanmin(log.battery) if np.isfinite(log.battery).any() else np.inf
    if low < robot.limit:
        found.append(
            f"the battery sinks to {low:.3g} V, below limit = {robot.limit:g} V: "
            "the program asks for more than there is"
        )
    return [*map(Subject("the run").warned, found)]


def _motion(tracking, robot):
    """Delay and friction beyond the description."""
    found = []
    late, allowed = tracking.interval("delay")[0], robot.delay + robot.jitter
    if late > allowed + 0.02 * robot.T:
        found.append(
            f"the voltage acts {1000 * tracking.values['delay']:.3g} ms after the "
            f"sample, but delay + jitter = {1000 * allowed:g} ms was proven"
        )
    rub = tracking.interval("friction")[0]
    if rub > RUBBING_SHARE * robot.limit:
        found.append(
            f"the gears eat {tracking.values['friction']:.2g} V by friction, which no "
            "proof has: a small oscillation about upright comes from it"
        )
    return [*map(Subject("the motion").warned, found)]


def write_comparison(comparison, folder):
    """Write the page of a ``comparison`` to comparison.html in a folder.

    Returns its path.
    """
    return write_page(Path(folder) / "comparison.html", comparison.page)
