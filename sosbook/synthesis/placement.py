"""Gains that move chosen poles to given places, and how little the others move."""

from dataclasses import dataclass
from decimal import ROUND_CEILING, Context

import numpy as np
from flint import acb, ctx, fmpq_mat
from scipy.optimize import linear_sum_assignment

from ..plants.descriptor import descriptors
from ..plants.response import exact_forms
from ..plants.second_order import SecondOrderSystem
from ..runtime.array_like import ArrayLike

BITS = 256  # of the balls around the poles
NEAR = 0.1  # of the largest pole that is asked for: a guess that is worse is refused
TINY = 1e-9  # of b, and of that pole: what floats can't tell from zero


@dataclass(frozen=True)
class Placement:
    """A gain of one input, and where it leaves the poles: by an enclosure of one
    program, for the gain's numbers as they are printed.

    Parameters
    ----------
    K : (1, 2n) array
        u = K [z; z'].
    miss, spill : float
        No moved pole is further from its place, no other one from where it was:
        proven, in rad/s.
    """

    K: np.ndarray
    miss: float
    spill: float

    def __str__(self):
        up = Context(prec=2, rounding=ROUND_CEILING)
        miss, spill = (float(up.create_decimal(x)) for x in (self.miss, self.spill))
        return (
            f"the moved poles lie within {miss:.2g} rad/s of their places, and no "
            f"other pole moves by more than {spill:.2g}, by an enclosure of one program"
            f"; |K| = {np.linalg.norm(self.K):.4g}"
        )


def place_poles(
    plant: SecondOrderSystem, poles: ArrayLike, places: ArrayLike
) -> Placement:
    r"""Move some poles of a plant with one input, and leave the others.

    Parameters
    ----------
    plant : SecondOrderSystem
        One plant with one input; where several shall act in the ratio g, the plant
        whose B is B g.
    poles, places : (k,) array_like
        Which poles, in rad/s, as near as they are known, and where they shall be. A
        complex one stands for its pair.

    Returns
    -------
    Placement
        The gain and its proof.

    Raises
    ------
    ValueError
        If the plant has several inputs, or u doesn't reach a pole.

    Notes
    -----
    Source: Datta, Elhay and Ram, Linear Algebra and its Applications 257, 1997. With
    left eigenvectors :math:`l_i`, :math:`K = \sum_i c_i l_i / (l_i b)` and :math:`c_i =
    -\prod_j (\lambda_i - \mu_j) / \prod_{j \ne i} (\lambda_i - \lambda_j)`: K sees no
    right eigenvector of another pole, so these poles stay.

    Examples
    --------
    >>> two = SecondOrderSystem(np.eye(2), 0 * np.eye(2), np.diag([1, 4]), [[1], [1]])
    >>> found = place_poles(two, [1j], [-1 + 1j])
    >>> found.K.round(6) + 0.0
    array([[-1.,  0., -2.,  0.]])
    >>> found.miss < 1e-12 and found.spill < 1e-12
    True
    """
    if not isinstance(plant, SecondOrderSystem) or plant.m != 1:
        raise ValueError(
            "plant must be one SecondOrderSystem with one input: where several shall "
            "act in the ratio g, give the plant whose B is B g"
        )
    (d,) = descriptors(plant)
    old, new = _closed("poles", poles), _closed("places", places)
    if len(old) != len(new):
        raise ValueError(f"{len(old)} poles can't be moved to {len(new)} places")
    A, b, _ = d.state_space()
    values, left = np.linalg.eig(A.T)
    at = linear_sum_assignment(abs(np.subtract.outer(old, values)))[1]
    moved, rows = values[at], left[:, at].T
    if (abs(old - moved) > NEAR * abs(old).max()).any():
        found = ", ".join(f"{x:.4g}" for x in np.sort_complex(values) if x.imag >= 0)
        raise ValueError(f"poles must be some of the plant's, {found}, got {poles!r}")
    reach = rows @ b[:, 0]
    apart = np.subtract.outer(moved, moved) + np.eye(len(moved))
    if (
        min(abs(reach).min() / np.linalg.norm(b), abs(apart / abs(old).max()).min())
        < TINY
    ):
        raise ValueError(
            f"poles: u doesn't reach one of {poles!r}, or one is double: leave it out"
        )
    c = -np.subtract.outer(moved, new).prod(axis=1) / apart.prod(axis=1)
    K = ((c / reach) @ rows).real[None]
    before, after = (_poles(d, gain) for gain in (0 * K, K))
    stay = list(range(len(before)))
    for k in _nearest(moved, before):
        stay.remove(k)
    goals = [acb(x.real, x.imag) for x in new.tolist()] + [before[k] for k in stay]
    now = (after[k] for k in _nearest([complex(x) for x in goals], after))
    off = [float(abs(x - y).upper()) * (1 + 1e-15) for x, y in zip(now, goals)]
    return Placement(K, max(off[: len(new)]), max(off[len(new) :], default=0.0))


def _nearest(points, balls):
    """Which of the ``balls`` belong to these ``points``, each to another one."""
    middle = [complex(x) for x in balls]
    return linear_sum_assignment(abs(np.subtract.outer(points, middle)))[1]


def _closed(name, values):
    """Numbers and the conjugates that they lack."""
    given = np.atleast_1d(np.asarray(values, complex))
    if given.ndim != 1 or not np.isfinite(given).all():
        raise ValueError(f"{name} must be some finite numbers, got {values!r:.60}")
    lone = [x for x in given if x.imag and not np.isclose(given, x.conjugate()).any()]
    return np.append(given, np.conj(lone))


def _poles(d, K):
    """Balls around the poles of a loop, its numbers read as decimals: roots of the
    characteristic polynomial, as often as they occur.
    """
    matrix = fmpq_mat(exact_forms(d, K)[0].tolist())
    with ctx.workprec(BITS):
        roots = matrix.charpoly().numer().complex_roots()
    return [root for root, times in roots for _ in range(times)]
