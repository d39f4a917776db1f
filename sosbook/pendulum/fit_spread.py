"""The pendulums that two logs allow: a simplex around their confidence ellipsoid.

Five ratios are measured: e/c, f/c, d/c, e/a and f/a. On one robot whose masses
and lengths are known, d among them, they are functions of four numbers: c, e, f
and 2 I_w. M, D, S and B are affine in these four, so a simplex of five pendulums
is a polytope of plants that holds just the pendulums between them.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import chi2

from ..plants.checks import finite, matrix

__all__ = ["CONFIDENCE", "FitSpread"]

CONFIDENCE = 0.99  # of the ellipsoid, without another being asked for
#: How log c, log e, log f and log 2 I_w follow from the logarithms of e/c, f/c,
#: d/c, e/a and f/a, as `Mip.from_ratios` fits them.
LOGARITHMS = np.array(
    [
        [0, 0, -1, 0, 0],
        [3 / 4, 1 / 4, -1, 1 / 4, -1 / 4],
        [1 / 4, 3 / 4, -1, -1 / 4, 1 / 4],
        [1 / 2, 1 / 2, -1, -1 / 2, -1 / 2],
    ]
)
SYMBOLS = "c", "e", "f", "I_w"


@dataclass(frozen=True, eq=False)
class FitSpread:
    """A spread from the fit, for every place that takes a number for one.

    ``covariance``, (4, 4): of c, e, f and I_w relative to their values; ``confidence``:
    the probability of the ellipsoid, between 0 and 1: with normal errors of this
    covariance it holds the true c, e, f and I_w so often. Raises ValueError if the
    covariance isn't positive definite, the confidence isn't between 0 and 1, or the
    simplex reaches a pendulum that can't be.

    The ellipsoid is that of chi-square with four degrees of freedom, to first
    order in the errors. Its covariance is the fit's, widened by the misfit as
    `widened` does it. Masses, lengths and g are taken for exact. The simplex is
    regular where the ellipsoid is a ball, and touches it with its five faces; its
    corners are four radii away.

    >>> spread = FitSpread(0.01**2 * np.eye(4))
    >>> round(spread.radius, 2), len(spread.corners)
    (3.64, 5)
    """

    covariance: np.ndarray
    confidence: float = CONFIDENCE

    def __post_init__(self):
        object.__setattr__(
            self, "covariance", matrix("covariance", self.covariance, (4, 4))
        )
        if not 0 < finite("confidence", self.confidence) < 1:
            raise ValueError(
                f"confidence must lie between 0 and 1, got {self.confidence!r}"
            )
        if not (np.linalg.eigvalsh(self.covariance) > 0).all():
            raise ValueError("covariance must be positive definite")
        if (self.corners <= -1).any():
            raise ValueError(
                "the fit is too uncertain: the simplex around its ellipsoid "
                f"reaches {', '.join(self.reached)}. Record longer logs, or "
                "give a smaller confidence"
            )

    @classmethod
    def of(cls, identified, sd, confidence=CONFIDENCE):
        """The spread of a fit.

        ``identified``: the fit of both logs; ``sd``, (5,): standard deviations of its
        ratios, as `widened` gives them; ``confidence``: as above.
        """
        value = np.array(list(identified.ratios.values()))
        covariance = np.array(identified.covariance)
        np.fill_diagonal(covariance, np.asarray(sd) ** 2)
        slopes = LOGARITHMS / value
        return cls(slopes @ covariance @ slopes.T, confidence)

    @property
    def radius(self):
        """Of the ellipsoid, in standard deviations."""
        return float(np.sqrt(chi2.ppf(self.confidence, len(SYMBOLS))))

    @property
    def axes(self):
        """(4, 4): where the unit ball's axes go; their hull is the ellipsoid."""
        values, vectors = np.linalg.eigh(self.covariance)
        return self.radius * vectors * np.sqrt(values)

    @property
    def corners(self):
        """(5, 4): the corners of the simplex, c, e, f and I_w relative to the fit's."""
        n = len(SYMBOLS)
        even = np.eye(n + 1) - 1 / (n + 1)  # a regular simplex, in n + 1 dimensions
        plane = np.linalg.qr(even[:, :n])[0]
        flat = even @ plane
        return flat * (n / np.linalg.norm(flat[0])) @ self.axes.T

    @property
    def reached(self):
        """How far the corners reach, in words: one for each number."""
        most = abs(self.corners).max(axis=0)
        return [f"{name} by {100 * x:.2g} %" for name, x in zip(SYMBOLS, most)]

    def vertices(self, mip):
        """The five pendulums around a ``mip``, with its I_w."""
        return tuple(self._moved(mip, *corner) for corner in self.corners)

    def _moved(self, mip, c, e, f, I_w):
        more = 2 * mip.I_w * I_w
        return replace(
            mip,
            a=mip.a + more,
            c=mip.c * (1 + c),
            e=mip.e * (1 + e),
            f=mip.f * (1 + f),
            I_w=mip.I_w * (1 + I_w),
            J=mip.J + more if mip.J else 0.0,
        )

    def weights(self, moved):
        """The weights (..., 5) of the corners in points ``moved`` (..., 4).

        A point lies in the simplex where none is negative.
        """
        system = np.vstack([self.corners.T, np.ones(len(SYMBOLS) + 1)])
        moved = np.asarray(moved, float)
        right = np.concatenate([moved, np.ones((*moved.shape[:-1], 1))], axis=-1)
        return np.linalg.solve(system, right[..., None])[..., 0]
