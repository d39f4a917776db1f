"""Second-order plants and polytopes of them."""

from dataclasses import dataclass, field

import numpy as np
from scipy.linalg import eigvals

from .checks import matrix, rank_deficient

__all__ = ["Polytope", "SecondOrderSystem"]


@dataclass(frozen=True, eq=False)
class SecondOrderSystem:
    r"""The plant :math:`M \ddot z + D \dot z + S z = B u + F w`.

    Parameters
    ----------
    M, D, S : (n, n) array_like
        Mass, damping and stiffness. ``M`` may be singular as long as
        ``[M B]`` has full row rank.
    B : (n, m) array_like
        Input matrix.
    F : (n, p) array_like, optional
        Disturbance matrix; needed where an H-infinity bound is asked.

    Raises
    ------
    ValueError
        On wrong shapes, entries that aren't finite, or ``[M B]``
        without full row rank.

    Notes
    -----
    Source: thesis equation (2.1), with d(t) = 0.

    Examples
    --------
    >>> plant = SecondOrderSystem([[2]], [[3]], [[1]], B=[[1]])
    >>> plant.n, plant.m, plant.p
    (1, 1, 0)
    >>> plant.poles()
    array([-1. , -0.5])
    """

    M: np.ndarray
    D: np.ndarray
    S: np.ndarray
    B: np.ndarray
    F: np.ndarray = None

    def __post_init__(self):
        M = matrix("M", self.M)
        n = M.shape[0]
        if n == 0:
            raise ValueError("M is empty: a plant has at least one row")
        F = np.zeros((n, 0)) if self.F is None else self.F
        checked = {
            "M": matrix("M", M, (n, n)),
            "D": matrix("D", self.D, (n, n)),
            "S": matrix("S", self.S, (n, n)),
            "B": matrix("B", self.B, (n, None)),
            "F": matrix("F", F, (n, None)),
        }
        for name, value in checked.items():
            object.__setattr__(self, name, value)
        if self.m == 0:
            raise ValueError("B has no column: the plant has no input")
        if rank_deficient(np.hstack([self.M, self.B]), 1e-14):
            raise ValueError(
                "[M B] lacks full row rank: no acceleration feedback can "
                "make M - B K_A nonsingular; remove the rows that carry "
                "neither mass nor input by hand"
            )

    @property
    def n(self):
        """Degrees of freedom."""
        return self.M.shape[0]

    @property
    def m(self):
        """Inputs."""
        return self.B.shape[1]

    @property
    def p(self):
        """Disturbances."""
        return self.F.shape[1]

    @property
    def vertices(self):
        """The plant itself: a polytope with one vertex."""
        return (self,)

    def poles(self):
        """Finite open-loop poles, in rad/s, sorted by real part."""
        n = self.n
        zero, one = np.zeros((n, n)), np.eye(n)
        if not rank_deficient(self.M):
            rows = np.linalg.solve(self.M, np.hstack([-self.S, -self.D]))
            upper = np.hstack([zero, one])
            return sort_poles(eigvals(np.vstack([upper, rows])))
        A = np.block([[zero, one], [-self.S, -self.D]])
        E = np.block([[one, zero], [zero, self.M]])
        return sort_poles(_finite(A, E))


@dataclass(frozen=True, eq=False)
class Polytope:
    """All convex combinations of some plants (2.4).

    Parameters
    ----------
    vertices : sequence of SecondOrderSystem
        The corners; all of one size.

    Raises
    ------
    ValueError
        If there is no vertex, or the vertices differ in size.

    Examples
    --------
    >>> light = SecondOrderSystem([[1]], [[1]], [[1]], [[1]])
    >>> heavy = SecondOrderSystem([[3]], [[1]], [[1]], [[1]])
    >>> Polytope([light, heavy]).at([0.5, 0.5]).M
    array([[2.]])
    """

    vertices: tuple = field()

    def __post_init__(self):
        try:
            vertices = tuple(self.vertices)
        except TypeError:
            raise ValueError(
                "vertices must be a sequence of SecondOrderSystem objects, "
                f"got {type(self.vertices).__name__}"
            ) from None
        if not vertices:
            raise ValueError("vertices is empty: a polytope needs a plant")
        for v in vertices:
            if not isinstance(v, SecondOrderSystem):
                raise ValueError(
                    "vertices must be SecondOrderSystem objects, "
                    f"got {type(v).__name__}"
                )
        sizes = {(v.n, v.m, v.p) for v in vertices}
        if len(sizes) > 1:
            raise ValueError(
                f"vertices differ in size (n, m, p): {sorted(sizes)}"
            )
        object.__setattr__(self, "vertices", vertices)

    @property
    def N(self):
        """Number of vertices."""
        return len(self.vertices)

    @property
    def n(self):
        """Degrees of freedom."""
        return self.vertices[0].n

    @property
    def m(self):
        """Inputs."""
        return self.vertices[0].m

    @property
    def p(self):
        """Disturbances."""
        return self.vertices[0].p

    @property
    def mean(self):
        """The plant in the middle of the vertices."""
        return self.at(np.full(self.N, 1 / self.N))

    def at(self, weights):
        """The plant with the given convex weights (2.5).

        Parameters
        ----------
        weights : (N,) array_like
            Non-negative, of sum one.
        """
        weights = np.asarray(weights, float)
        good = weights.shape == (self.N,) and np.isfinite(weights).all()
        if not good or (weights < 0).any() or abs(weights.sum() - 1) > 1e-9:
            raise ValueError(
                f"weights must be {self.N} non-negative numbers of sum 1"
            )
        mixed = (
            sum(w * getattr(v, x) for w, v in zip(weights, self.vertices))
            for x in "MDSBF"
        )
        return SecondOrderSystem(*mixed)

    def sample(self, count, seed):
        """Random plants, uniform over the weights.

        Parameters
        ----------
        count : int
            How many.
        seed : int
            For numpy's generator: the same seed gives the same plants.
        """
        rng = np.random.default_rng(seed)
        weights = rng.dirichlet(np.ones(self.N), size=count)
        return [self.at(w) for w in weights]


def _finite(A, E):
    alpha, beta = eigvals(A, E, homogeneous_eigvals=True)
    finite = np.abs(beta) > 1e-12 * np.abs(alpha)
    return alpha[finite] / beta[finite]


def sort_poles(poles):
    """Sorted by real part, then imaginary part; real if they all are."""
    poles = np.asarray(poles)
    if np.abs(np.imag(poles)).max(initial=0) == 0:
        return np.sort(poles.real)
    order = np.lexsort((poles.imag, np.round(poles.real, 9)))
    return poles[order]
