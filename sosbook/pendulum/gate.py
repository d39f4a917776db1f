"""Whether two logs may speak for a robot: what a fit alone can't see.

Least squares give numbers for any log. Here each log, each fit and
their agreement are held against what a working robot does.
"""

from dataclasses import dataclass

from .fit_checks import check_fits, widened
from .identify import identify
from .log_checks import Finding, check_log, refused

__all__ = ["Finding", "Inspection", "check_fits", "check_log", "refused", "widened"]


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
        return cls(robot, body, wheels, identified, tuple(findings))

    @property
    def refusal(self):
        """Why these logs give no program, one reason a line."""
        lines = [f"- {f}" for f in refused(self.findings)]
        more = (
            ""
            if self.identified is None
            else (
                "\nIf all this is right, force=True (--force) goes on with "
                "them, and the program says so"
            )
        )
        return "these logs give no program:\n" + "\n".join(lines) + more
