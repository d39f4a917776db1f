"""The checks of one log, as it comes from the robot, before a fit."""

from dataclasses import dataclass

from .deployment import described_or_none
from .fit_checks import check_fit
from .identify import fitted
from .log import Log
from .log_checks import Subject, check_log, refused

__all__ = ["Recording", "check_recording"]

UNDESCRIBED_COUNTS = 2000.0  # a turn, where no description says how many
VAGUE = 0.02  # relative half-width of a ratio's interval, beyond which it is vague
EXPERIMENTS = ("body", "wheels")


@dataclass(frozen=True, eq=False)
class Recording:
    """One log, its fits, and what speaks against it.

    ``experiment``, {"body", "wheels"}: which of the two experiments it is of; ``log``:
    the log; ``fits``: one for the gyro or for each encoder; none where the log gives
    none; ``findings``: what speaks against it.
    """

    experiment: str
    log: Log
    fits: tuple
    findings: tuple

    @property
    def usable(self):
        """True if nothing refuses it."""
        return not refused(self.findings)

    @property
    def report(self):
        """Lines of text: what it is, what it says, what speaks against it."""
        log = self.log
        lines = [
            f"log of the {self.experiment}: {len(log.t)} samples, "
            f"{log.t[-1] - log.t[0]:.1f} s at {1 / log.T:.4g} Hz, V up to "
            f"{abs(log.V).max():.3g} V"
        ]
        for fit in self.fits:
            ratios = (
                f"{name.replace('_', '/')} = {fit[name]:.5g} +- {1.96 * sd:.2g}"
                for name, sd in zip(fit.names, fit.sd)
                if "_" in name
            )
            lines.append("  " + ", ".join(ratios))
        lines += [f"  {f.severity}: {f.text}" for f in self.findings]
        lines.append("  usable" if self.usable else "  not usable")
        return "\n".join(lines)


def check_recording(path, robot=None, experiment=None):
    """Look at one log alone, before the other experiment is done.

    Parameters
    ----------
    path : str or Path
        A CSV file, as `Log.read` takes it.
    robot : Robot or path_like, optional
        The robot's description. Without it counts, the gyro's range and
        the motors' limit can't be checked.
    experiment : {"body", "wheels"}, optional
        Without it a log with a gyro is the body's, one with encoders the
        wheels'.

    Returns
    -------
    Recording
        The log, its fits and what speaks against it.

    Raises
    ------
    ValueError
        If the file is no log, or may be of either experiment.

    Examples
    --------
    >>> from sosbook.pendulum.rig import DATA
    >>> print(check_recording(DATA / "body.csv").report)
    log of the body: 6000 samples, 60.0 s at 100 Hz, V up to 1.85 V
      e/c = 30.519 +- 0.0013, f/c = 7.133 +- 0.00042, d/c = 110.6 +- 0.0031
      usable
    """
    log = Log.read(path)
    robot = described_or_none(robot)
    present = [
        name
        for name, column in zip(EXPERIMENTS, ("gyro", "encoder1"))
        if getattr(log, column) is not None
    ]
    if experiment is None and len(present) != 1:
        raise ValueError(
            f"{path} has {'both a gyro and encoders' if present else 'no sensor'}: "
            "say experiment='body' or 'wheels'"
        )
    experiment = experiment or present[0]
    if experiment not in EXPERIMENTS:
        raise ValueError(f"experiment must be one of {EXPERIMENTS}, got {experiment!r}")
    findings = check_log(experiment, log, robot)
    fits, subject = (), Subject(f"log of the {experiment}")
    if robot is None and experiment == "wheels":
        presumed = f"no description: e/a is for {UNDESCRIBED_COUNTS:g} counts a turn"
        findings.append(subject.warned(presumed))
    counts = robot.counts if robot else UNDESCRIBED_COUNTS
    try:
        fits = fitted(experiment, log, counts, robot is not None and robot.friction)
    except ValueError as error:
        if not refused(findings):  # a log that is wrong says why itself
            findings.append(subject.refused(str(error)))
    else:
        findings += check_fit(experiment, fits, log, counts)
    for fit in fits:
        findings += _vague(fit, subject)
    return Recording(experiment, log, fits, tuple(findings))


def _vague(fit, subject):
    """Findings on a ratio that is hardly known."""
    wide = [
        f"{name.replace('_', '/')} to {100 * 1.96 * sd / abs(fit[name]):.2g} %"
        for name, sd in zip(fit.names, fit.sd)
        if "_" in name and 1.96 * sd > VAGUE * abs(fit[name])
    ]
    if wide:
        yield subject.warned(
            f"it gives {', '.join(wide)} only: sweep longer, or with a larger V"
        )
