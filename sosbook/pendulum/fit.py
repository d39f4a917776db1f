"""A fit: parameters of a simulation, and how well a log knows them."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import norm

__all__ = ["Fit", "output_error"]

TOLERANCES = dict(ftol=1e-12, xtol=1e-10, gtol=1e-12)
CORRELATED_SAMPLES = 50  # so many samples later residuals count as unrelated


@dataclass(frozen=True, eq=False)
class Fit:
    """Parameters that were fitted to a log, and how well they're known.

    ``names``: the parameters' names; ``values``, (p,): their values, in this order;
    ``covariance``, (p, p): their covariance, from the Jacobian, for residuals that may
    be coloured; ``residuals``, (N,): measured minus modelled; ``alone``: of a body's
    fit that has f/e of the wheels': e/f by its own log alone; ``misfit``: of a fit with
    a play: the residuals over the signal, rms. Its gears are a spring's and nobody's,
    so each value may be off by as much.
    """

    names: tuple
    values: np.ndarray
    covariance: np.ndarray
    residuals: np.ndarray
    alone: float | None = None
    misfit: float = 0.0

    def __getitem__(self, name):
        return float(self.values[self.names.index(name)])

    @property
    def sd(self):
        """Standard deviation of each value."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def rms(self):
        """The root mean square of the residuals, in the output's unit."""
        return float(np.sqrt(np.mean(self.residuals**2)))

    def interval(self, name, level=0.95):
        """The interval that holds the parameter ``name`` with confidence ``level``.

        It holds for a model that can be true: a bias isn't part of it.
        """
        half = norm.ppf((1 + level) / 2) * self.sd[self.names.index(name)]
        return float(self[name] - half), float(self[name] + half)


def output_error(model, y, start, step=None, rounds=100):
    """Fit a simulation to what was measured, by least squares.

    ``model``: ``model(*values)`` is the (N,) output without noise; ``y``, (N,): what
    was measured; ``start``: names and first guesses; ``step``: the parameters' relative
    change for differences: larger than what rounding needs where the model has corners;
    ``rounds``: how often the model may be evaluated at most, beside the differences.
    Returns the parameters, their
    covariance and the residuals. Raises ValueError if y doesn't determine every
    parameter.
    """
    y = np.asarray(y, dtype=float)
    guess = np.array(list(start.values()), dtype=float)
    try:
        with np.errstate(over="ignore"):  # a trial that ran away isn't taken
            how = dict(x_scale="jac", diff_step=step, max_nfev=rounds, **TOLERANCES)
            solution = least_squares(lambda x: model(*x) - y, guess, **how)
    except (ValueError, OverflowError):
        raise ValueError(
            "the simulation with "
            + ", ".join(start)
            + " ran away from the log: does a column stand in another's place, V in "
            "the sensor's for example, or is a unit wrong?"
        ) from None
    names, J, r = tuple(start), solution.jac, -solution.fun
    scale = np.linalg.norm(J, axis=0)
    if not scale.all() or np.linalg.cond(J / scale) > 1e8:
        raise ValueError(
            "the log doesn't determine "
            + ", ".join(names)
            + ": it needs a voltage that excites the motion"
        )
    return Fit(names, solution.x, covariance(J, r), r)


def covariance(J, r):
    """Covariance of a least-squares fit with coloured residuals.

    (J'J)^-1 J' Sigma J (J'J)^-1, where Sigma is the Toeplitz matrix of
    the residuals' own correlations, tapered (Bartlett).
    """
    inverse = np.linalg.inv(J.T @ J)
    N = len(r)
    middle = (r @ r) * J.T @ J
    for lag in range(1, min(CORRELATED_SAMPLES, N)):
        taper = (1 - lag / CORRELATED_SAMPLES) * (r[lag:] @ r[:-lag])
        cross = J[lag:].T @ J[:-lag]
        middle = middle + taper * (cross + cross.T)
    return inverse @ middle @ inverse / (N - len(inverse))
