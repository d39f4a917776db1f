"""The checks of two logs for one robot: what a fit alone can't see.

Least squares give numbers for any log. Here each log, each fit and
their agreement are held against what a working robot does.
"""

from dataclasses import dataclass

from .fit_checks import UNMODELLED, check_fits, widened
from .identify import identify
from .log_checks import Finding, Subject, check_log, refused

__all__ = ["Finding", "Inspection", "check_fits", "check_log", "refused", "widened"]

RUBS = 1.5  # times as much the fits leave without the friction that there is


@dataclass(frozen=True, eq=False)
class Inspection:
    """Two logs, what they say of a robot, and what speaks against it.

    ``robot``: the robot's description; ``body``, ``wheels``: the two logs;
    ``identified``: None where the logs give no pendulum at all; ``findings``: what
    speaks against a fit or a log.
    """

    robot: object
    body: object
    wheels: object
    identified: object
    findings: tuple

    @classmethod
    def of(cls, body, wheels, robot):
        """Check the logs body and wheels of a robot, fit them, and check the fits."""
        findings = [
            *check_log("body", body, robot),
            *check_log("wheels", wheels, robot),
        ]
        identified = None
        try:
            identified = identify(body, wheels, **robot.identification)
        except ValueError as error:
            if not refused(findings):  # a log that is wrong says why itself
                findings.append(Finding("refused", "the fit", str(error)))
        else:
            findings += check_fits(identified, body, wheels, robot)
            findings += _rubbing(identified, body, wheels, robot, findings)
        return cls(robot, body, wheels, identified, tuple(findings))

    @property
    def refusal(self):
        """Why these logs give no program, one reason a line."""
        lines = [f"- {f}" for f in refused(self.findings)]
        if self.identified is not None:
            lines.append(
                "If all this is right, force=True (--force) goes on with them, and the "
                "program says so"
            )
        return "\n".join(["these logs give no program:", *lines])


def _rubbing(identified, body, wheels, robot, findings):
    """The fits with friction, where those without it leave more than noise."""
    if robot.friction or not any(UNMODELLED in str(x) for x in findings):
        return
    try:
        other = identify(body, wheels, **robot.identification | {"friction": True})
    except ValueError:
        return
    fits = zip((identified.body, *identified.wheels), (other.body, *other.wheels))
    if max(mine.rms / max(theirs.rms, 1e-12) for mine, theirs in fits) < RUBS:
        return
    pairs = ", ".join(
        f"{x.replace('_', '/')} = {value:.4g} instead of {identified.ratios[x]:.4g}"
        for x, value in other.ratios.items()
    )
    yield Subject("both logs").warned(
        f"the gears rub: with friction = true the fits are closer, and {pairs}. Set it "
        "(--friction): the robot may lie beyond the other interval"
    )
