"""A fit of the robot's logs: that of `sosbook.analysis.fit`, and what gears add."""

from dataclasses import dataclass

from ..analysis import fit as of_any_machine

__all__ = ["Fit", "output_error"]


@dataclass(frozen=True, eq=False)
class Fit(of_any_machine.Fit):
    """A fit to a log of the robot: names, values, covariance, residuals.

    ``alone``: of a body's fit that has f/e of the wheels': e/f by its own log alone;
    ``misfit``: of a fit with a play: the residuals over the signal, rms. Its gears are
    a spring's and nobody's, so each value may be off by as much.
    """

    alone: float | None = None
    misfit: float = 0.0


def output_error(*args, **how):
    """A `Fit` of the robot; args and how as for any machine's least squares."""
    return Fit(**vars(of_any_machine.output_error(*args, **how)))
