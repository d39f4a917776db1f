"""A fit: parameters of a simulation, and how well a log knows them."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq, least_squares
from scipy.stats import norm

TOLERANCES = dict(ftol=1e-12, xtol=1e-10, gtol=1e-12)
CORRELATED_SAMPLES = 50  # so many samples later residuals count as unrelated
ORDERS = np.arange(1, 200)  # of rounding's Fourier series; the rest is 3e-4 of a step


@dataclass(frozen=True, eq=False)
class Fit:
    """Parameters that were fitted to a log, and how well they're known.

    ``names``: the parameters' names; ``values``, (p,): their values, in this order;
    ``covariance``, (p, p): their covariance, from the Jacobian, for residuals that may
    be coloured; ``residuals``, (N,) or (N, q): measured minus modelled.
    """

    names: tuple
    values: np.ndarray
    covariance: np.ndarray
    residuals: np.ndarray

    def __getitem__(self, name):
        return float(self.values[self.names.index(name)])

    @property
    def sd(self) -> np.ndarray:
        """Standard deviation of each value."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def rms(self) -> float:
        """The root mean square of the residuals, in the output's unit."""
        return float(np.sqrt(np.mean(self.residuals**2)))

    def interval(self, name: str, level: float = 0.95) -> tuple[float, float]:
        """The interval that holds the parameter ``name`` with confidence ``level``.

        It holds for a model that can be true: a bias isn't part of it.
        """
        half = radius(level) * self.sd[self.names.index(name)]
        return float(self[name] - half), float(self[name] + half)


class UnseenError(ValueError):
    """A log says nothing of a parameter, in a text; with values that were tried, and
    their residuals.
    """

    def __init__(self, text, values, residuals):
        super().__init__(text)
        self.values, self.residuals = values, residuals


def radius(confidence, count=1):
    """Half the side, in standard deviations, of a box around normal errors.

    The box holds all ``count`` errors at once with at least this ``confidence``,
    however they are correlated (Sidak's inequality); with just this where they aren't.

    >>> round(radius(0.95), 2), round(radius(0.99, 4), 2)
    (1.96, 3.02)
    """
    return float(norm.ppf((1 + confidence ** (1 / count)) / 2))


def output_error(
    model, y, start, step=None, rounds=100, slopes="2-point", window=CORRELATED_SAMPLES
):
    """Fit a simulation to what was measured, by least squares.

    ``model``: ``model(*values)`` is the output without noise; ``y``, (N,) or (N, q):
    what was measured; ``start``: names and first guesses; ``step``: the parameters'
    relative change for differences: larger than what rounding needs where the model has
    corners; ``rounds``: how often the model may be evaluated at most, beside the
    differences; ``slopes``: ``slopes(values)`` are its derivatives, (N q, p);
    ``window``: as for `covariance`. Returns the parameters, their covariance and the
    residuals. Raises ValueError if y doesn't determine every parameter.
    """
    y = np.asarray(y, dtype=float)
    guess = np.array(list(start.values()), dtype=float)
    try:
        with np.errstate(over="ignore"):  # a trial that ran away isn't taken
            how = dict(x_scale="jac", diff_step=step, max_nfev=rounds, **TOLERANCES)
            solution = least_squares(
                lambda x: np.ravel(model(*x) - y), guess, slopes, **how
            )
    except (ValueError, OverflowError):
        raise ValueError(
            "the simulation with "
            + ", ".join(start)
            + " ran away from the log: does a column stand in another's place, V in "
            "the sensor's for example, or is a unit wrong?"
        ) from None
    names, J, r = tuple(start), solution.jac, -solution.fun
    scale = np.linalg.norm(J, axis=0)
    unseen = scale == 0
    if scale.all():
        _, sizes, directions = np.linalg.svd(J / scale, full_matrices=False)
        if sizes[-1] * 1e8 < sizes[0]:
            unseen = abs(directions[-1]) > 0.1
    r = r.reshape(y.shape)
    if unseen.any():
        text = ", ".join(np.array(names)[unseen])
        text = f"the log doesn't determine {text}: it needs an input that excites the "
        raise UnseenError(f"{text}motion", solution.x, r)
    return Fit(names, solution.x, covariance(J, r, window), r)


def covariance(J, r, window=CORRELATED_SAMPLES):
    """Covariance of a least-squares fit with coloured residuals.

    (J'J)^-1 J' Sigma J (J'J)^-1, where Sigma is the Toeplitz matrix of
    the residuals' own correlations, tapered (Bartlett). ``r``, (N,) or (N, q): outputs
    may be correlated; ``J``, (N q, p); ``window``: so many samples later residuals
    count as unrelated.
    """
    inverse = np.linalg.inv(J.T @ J)
    N = len(r)
    r = r.reshape(N, -1).T
    J = J.reshape(N, len(r), -1).swapaxes(0, 1)
    middle = 0.0
    for one, of_one in zip(r, J):
        for other, of_other in zip(r, J):
            middle = middle + (one @ other) * of_one.T @ of_other
            for lag in range(1, min(window, N)):
                taper = 1 - lag / window
                cross = of_one[lag:].T @ of_other[:-lag]
                cross = taper * (one[lag:] @ other[:-lag]) * cross
                middle = middle + cross + cross.T
    return inverse @ middle @ inverse / (N - len(inverse))


def standing(y, modelled, window):
    """The rests of a reading longer than a window, and the error they have in common.

    A sensor of steps is wrong by one number as long as it stands: the residuals of a
    whole rest are one, and no window of their colours sees that. ``y``, (N,): what it
    reads; ``modelled``, (N,): what a model says, which stands where it stays within a
    quarter of a step. Returns the slices, and the variance v of the error that a rest
    has in common. Where a sensor is shaken by the variance q before it rounds, in
    steps, v is the sum of exp(-4 pi^2 n^2 q) / (2 pi^2 n^2) over n = 1, 2, .., and its
    reading shakes by q + 1/12 - v (Widrow and Kollar, Quantization Noise, 2008).

    >>> read, path = np.array([0.0, 1, 2, 2, 2, 2]), np.array([0, 1, 2.1, 2, 2, 2])
    >>> runs, variance = standing(read, path, 3)
    >>> runs, round(variance, 3)
    ([slice(2, 6, None)], 0.083)
    """
    levels = np.unique(np.round(y / (np.ptp(y) or 1.0), 9)) * np.ptp(y)
    step = np.diff(levels).min(initial=np.inf)
    runs, first = [], 0
    for k in range(1, len(y) + 1):
        if k == len(y) or abs(modelled[k] - modelled[first]) > step / 4:
            if k - first > window:
                runs.append(slice(first, k))
            first = k
    if not runs or step == np.inf:
        return [], 0.0
    count = sum(k.stop - k.start for k in runs)
    shaken = sum(np.square(y[k] - y[k].mean()).sum() for k in runs) / (
        count - len(runs)
    )
    shaken /= step**2

    def common(q):
        return (
            np.exp(-4 * np.pi**2 * ORDERS**2 * q) / (2 * np.pi**2 * ORDERS**2)
        ).sum()

    def left(q):
        return q + 1 / 12 - common(q) - shaken

    q = brentq(left, 0, shaken) if left(0) < 0 else 0.0
    return runs, float(step**2 * common(q))
