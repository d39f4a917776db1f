"""The pendulums that two logs allow: a box that holds them with a confidence.

Five ratios are measured: e/c, f/c, d/c, e/a and f/a. On one robot whose masses
and lengths are known, d among them, they are functions of four numbers: c, e, f
and 2 I_w. M, D, S and B are affine in these four, so a box in any coordinates of
theirs is a box of plants that holds just the pendulums in it.
"""

from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from ..analysis.fit import radius
from ..plants.checks import finite, matrix
from ..plants.uncertain import Uncertain

__all__ = ["CONFIDENCE", "FitSpread"]

CONFIDENCE = 0.99  # of the box, without another being asked for
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
#: The logarithms of the ratios by those of `SYMBOLS`, and whose log has them.
RATIOS = {
    "e/c": ([-1, 1, 0, 0], "body"),
    "f/c": ([-1, 0, 1, 0], "body"),
    "d/c": ([-1, 0, 0, 0], "body"),
    "e/a": ([0, 1, 0, -1], "wheels"),
    "f/a": ([0, 0, 1, -1], "wheels"),
}


@dataclass(frozen=True, eq=False)
class FitSpread:
    """A spread from the fit, for every place that takes a number for one.

    ``covariance``, (4, 4): of c, e, f and I_w relative to their values; ``confidence``:
    the probability of the box, between 0 and 1: with normal errors of this covariance
    it holds the true c, e, f and I_w, all four at once, so often. Raises ValueError if
    the covariance isn't positive definite, the confidence isn't between 0 and 1, or the
    box reaches a pendulum that can't be.

    The box lies along the principal axes of the covariance, along which errors are
    independent: to a half of `radius` standard deviations each holds the truth with
    the fourth root of the confidence. Its corners are two such halves away; those of
    a simplex around the ellipsoid of the same confidence would be 2.4 times as far.
    The covariance is the fit's to first order, widened by the misfit as `widened` does
    it. Masses, lengths and g are taken for exact.

    >>> spread = FitSpread(0.01**2 * np.eye(4))
    >>> round(spread.radius, 2), len(spread.corners)
    (3.02, 16)
    """

    covariance: np.ndarray
    confidence: float = CONFIDENCE

    def __post_init__(self):
        """Check the covariance and the corners of its box."""
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
                "the fit is too uncertain: its box reaches "
                f"{', '.join(self.reached)}. {self.cure}"
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
        """From the middle to a face, in standard deviations along an axis."""
        return radius(self.confidence, len(SYMBOLS))

    @property
    def axes(self):
        """(4, 4): what leads from the middle to a face, a column for each axis."""
        values, vectors = np.linalg.eigh(self.covariance)
        return self.radius * vectors * np.sqrt(values)

    @property
    def corners(self):
        """(16, 4): the corners of the box, c, e, f and I_w relative to the fit's."""
        return np.array(list(product((-1, 1), repeat=len(SYMBOLS)))) @ self.axes.T

    @property
    def reached(self):
        """How far the corners reach, in words: one for each number."""
        most = abs(self.corners).max(axis=0)
        return [f"{name} by {100 * x:.2g} %" for name, x in zip(SYMBOLS, most)]

    @property
    def cure(self):
        """Which ratio the logs know least, and what to do about it."""
        rows = {name: np.array(row) for name, (row, _) in RATIOS.items()}
        variance = {name: row @ self.covariance @ row for name, row in rows.items()}
        name = max(variance, key=variance.get)
        return (
            f"Of the five ratios the logs know {name} least, to "
            f"{196 * variance[name] ** 0.5:.2g} % either way (95 %): record the log of "
            f"the {RATIOS[name][1]} again, with a longer sweep and a larger V, or give "
            "a smaller confidence"
        )

    def vertices(self, mip):
        """The 16 pendulums around a ``mip``, with its I_w."""
        return tuple(self._moved(mip, *corner) for corner in self.corners)

    def plants(self, mip):
        """The plants of all pendulums of the box around ``mip``, of one family."""
        middle, changes = mip.plant(), {}
        for k, axis in enumerate(self.axes.T, 1):
            moved = self._moved(mip, *axis).plant()
            rows = np.hstack([getattr(moved, x) - getattr(middle, x) for x in "MDSBF"])
            changes[f"axis_{k}"] = -1, 1, list(zip(np.eye(2), rows))
        return Uncertain.of(middle, **changes).polytope()

    def _moved(self, mip, c, e, f, I_w):
        moved = {"c": c, "e": e, "f": f, "I_w": I_w}
        moved = {name: getattr(mip, name) * (1 + x) for name, x in moved.items()}
        more = 2 * mip.I_w * I_w
        J = mip.J + more if mip.J else 0.0
        return replace(mip, a=mip.a + more, J=J, **moved)

    def places(self, moved):
        """The places (..., 4) along the axes of points ``moved`` (..., 4).

        A point lies in the box where all are from -1 to 1.
        """
        return np.linalg.solve(self.axes, np.asarray(moved, float)[..., None])[..., 0]
