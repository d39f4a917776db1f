"""Second-order plants and polytopes of them."""

import sys
import warnings
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from scipy.linalg import eigvals

from ..runtime.array_like import ArrayLike
from ..runtime.read_only import ReadOnly
from ..runtime.sparse import issparse
from .checks import checked_names, matrix, rank_deficient
from .descriptor import descriptors
from .parametric import MayBeSymbolic
from .reduction import Reducible, Reduction
from .sparse import check_mass, check_small, reader, same_matrix
from .suspicions import suspicion

if TYPE_CHECKING:
    from scipy.sparse import sparray, spmatrix

    from .signals import Sine, Step, Steps

    Matrix: TypeAlias = ArrayLike | sparray | spmatrix


class MassWarning(UserWarning):
    """A mass matrix that isn't symmetric, has a negative eigenvalue or one that is lost
    in its digits; or half of a symmetric M, D or S.
    """


class _Plant(Reducible):
    """The common base of a plant and a polytope of plants."""

    vertices: Any
    family: Any = None  # the `Uncertain` whose vertices these are, if so

    @property
    def n(self) -> int:
        """Degrees of freedom."""
        return self.vertices[0].M.shape[0]

    @property
    def m(self) -> int:
        """Inputs."""
        return self.vertices[0].B.shape[1]

    @property
    def p(self) -> int:
        """Disturbances."""
        return self.vertices[0].F.shape[1]

    def simulate(
        self,
        t: ArrayLike,
        x0: ArrayLike | None = None,
        u: "Sine | Step | Steps | None" = None,
        w: "Sine | Step | Steps | None" = None,
    ) -> Any:
        """Simulate the plant without a controller; exact, no ODE solver.

        Parameters
        ----------
        t : (k,) array_like
            Increasing times, in seconds, from 0.
        x0 : (2n,) array_like, optional
            Initial [z; z']; zero without it.
        u : Sine, Step, Steps or Ramps, optional
            Input; zero without it.
        w : Sine, Step, Steps or Ramps, optional
            Disturbance; zero without it.

        Returns
        -------
        Response
            The response with r = 0 and x = [z; z']; a list of them, one for
            each vertex, for a Polytope.

        Raises
        ------
        ValueError
            On bad input, or a singular mass.

        Examples
        --------
        >>> plant = SecondOrderSystem(M=1, D=0, S=1, B=1)
        >>> plant.simulate([0, np.pi], x0=[1, 0]).z.round(6)
        array([[ 1., -1.]])
        """
        from .response import simulate_open

        check_small(self.vertices[0])
        try:
            vertices = descriptors(self)
        except ValueError as error:
            raise ValueError(
                f"{error}; simulate the plant of sosbook.regularize(...).regular"
            ) from None
        return self.per_vertex([simulate_open(d, t, x0, u, w) for d in vertices])

    def per_vertex(self, values: Any) -> Any:
        """One value for each vertex, of a sequence; for one plant the value itself."""
        return values[0] if self.vertices[0] is self else values


@dataclass(frozen=True, eq=False, repr=False)
class SecondOrderSystem(_Plant, MayBeSymbolic, ReadOnly):
    r"""The plant :math:`M \ddot z + D \dot z + S z = B u + F w`.

    Nested lists, arrays and scipy.sparse are taken, and numbers where
    there is one degree of freedom. Plants with equal matrices are equal.

    Parameters
    ----------
    M, D, S : (n, n) array_like
        Mass, damping and stiffness. ``M`` may be singular as long as
        ``[M B]`` has full row rank.
    B : (n, m) array_like
        Input matrix.
    F : (n, p) array_like, optional
        Disturbance matrix; needed where an H-infinity bound is asked.
    coordinates : sequence of n str, optional
        The names of z, by which a `Gain` says what it multiplies. They are no
        part of the plant's mechanics, and so of none of its comparisons.
    reduction : Reduction, optional
        Of what it is a part: `reduce` says so, and every proof does.

    Raises
    ------
    ValueError
        On wrong shapes, entries that aren't finite, names that aren't n, or
        ``[M B]`` without full row rank.

    Warns
    -----
    MassWarning
        If M isn't symmetric, or has a negative eigenvalue: the theorems
        hold all the same, but in Lagrange's equations it is neither. If a
        mass is lost in its digits, or all entries of M, D or S are on one
        side of the diagonal, as in half of a symmetric matrix.

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
    >>> plant == SecondOrderSystem(M=2, D=3, S=1, B=1)
    True
    """

    M: np.ndarray
    D: np.ndarray
    S: np.ndarray
    B: np.ndarray
    F: np.ndarray = None  # type: ignore[assignment]  # an array once it is made
    coordinates: tuple[str, ...] | None = None
    reduction: Reduction | None = None

    if TYPE_CHECKING:  # what the constructor takes

        def __init__(
            self,
            M: Matrix,
            D: Matrix,
            S: Matrix,
            B: Matrix,
            F: Matrix | None = None,
            coordinates: Iterable[str] | None = None,
            reduction: Reduction | None = None,
        ) -> None: ...

    def __post_init__(self):
        """Check the matrices and keep them read-only."""
        read = reader(self.M, self.D, self.S)
        M = read("M", self.M)
        n = M.shape[0]
        if n == 0:
            raise ValueError("M is empty: a plant has at least one row")
        if np.ndim(self.M) == 0 and np.shape(self.D) not in ((), (1, 1)):
            raise ValueError(
                "M must be a matrix like D: a number stands for one degree of freedom"
            )
        F = np.zeros((n, 0)) if self.F is None else self.F
        for name, value in dict(M=M, D=self.D, S=self.S, B=self.B, F=F).items():
            shape = (n, n if name in "MDS" else None)
            made = read if name in "MDS" else matrix
            object.__setattr__(self, name, made(name, value, shape))
        object.__setattr__(self, "coordinates", checked_names(self.coordinates, n))
        if self.m == 0:
            raise ValueError("B has no column: the plant has no input")
        given = {name: getattr(self, name) for name in "MDSBF"}
        check_mass(given)
        self._warn(given)

    def _warn(self, given):
        """Warn of what is odd, unless this package itself has made the plant."""
        caller = sys._getframe(3).f_globals.get("__name__", "")  # of __init__
        if caller.split(".")[0] != __package__.split(".")[0]:
            if fault := suspicion(given):
                warnings.warn(fault, MassWarning, stacklevel=4)

    def __repr__(self):
        return f"<SecondOrderSystem: {_sizes(self)}>"

    def __eq__(self, other):
        if not isinstance(other, SecondOrderSystem):
            return NotImplemented
        return str(self.reduction) == str(other.reduction) and all(
            same_matrix(getattr(self, x), getattr(other, x)) for x in "MDSBF"
        )

    def __hash__(self):
        parts = (getattr(self, x) for x in "MDSBF")
        data = ((x.data if issparse(x) else x) + 0.0 for x in parts)  # one zero
        return hash((self.n, *(x.tobytes() for x in data)))

    def keep(self, rationals: dict) -> None:
        """Let it know the rationals, by argument, next to which its floats are."""
        vars(self)["_rationals"] = rationals

    @property
    def vertices(self) -> "tuple[SecondOrderSystem, ...]":  # type: ignore[override]
        """The plant itself: a polytope with one vertex."""
        return (self,)

    def poles(self) -> np.ndarray:
        """Finite open-loop poles, in rad/s, sorted by real part.

        Returns
        -------
        (k,) array
            Fewer than 2 n if the mass is singular.

        Raises
        ------
        ValueError
            If the plant is large and sparse, which has too many.
        """
        from .response import sort_poles

        n = self.n
        check_small(self)
        zero, one = np.zeros((n, n)), np.eye(n)
        if not rank_deficient(self.M):
            rows = np.linalg.solve(self.M, np.hstack([-self.S, -self.D]))
            return sort_poles(eigvals(np.block([[zero, one], [rows]])))
        A = np.block([[zero, one], [-self.S, -self.D]])
        E = np.block([[one, zero], [zero, self.M]])
        alpha, beta = eigvals(A, E, homogeneous_eigvals=True)
        finite = np.abs(beta) > 1e-12 * np.abs(alpha)
        return sort_poles(alpha[finite] / beta[finite])


@dataclass(frozen=True, eq=False, repr=False)
class Polytope(_Plant, ReadOnly):
    """All convex combinations of some plants (2.4).

    Parameters
    ----------
    vertices : sequence of SecondOrderSystem
        The corners, all of one size, in an order that counts for equality.

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

    vertices: tuple

    if TYPE_CHECKING:  # what the constructor takes

        def __init__(self, vertices: Iterable[SecondOrderSystem]) -> None: ...

    def __post_init__(self):
        """Check that the vertices are plants of one size, with the same names."""
        try:
            vertices = tuple(self.vertices)
        except (TypeError, NotImplementedError):  # the latter of a memoryview
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
                    + (": join the lists of vertices" if hasattr(v, "vertices") else "")
                )
        sizes = {(v.n, v.m, v.p) for v in vertices}
        if len(sizes) > 1:
            raise ValueError(f"vertices differ in size (n, m, p): {sorted(sizes)}")
        object.__setattr__(self, "vertices", vertices)
        if len({str(v.reduction) for v in vertices}) > 1:
            raise ValueError("vertices are reduced differently: reduce the polytope")
        if len(named := self._named) > 1:
            raise ValueError(
                f"vertices name their coordinates differently: {sorted(named)}"
            )

    def __repr__(self):
        corners = "1 vertex" if self.N == 1 else f"{self.N} vertices"
        return f"<Polytope: {corners}, {_sizes(self)}>"

    def __eq__(self, other):
        if not isinstance(other, Polytope):
            return NotImplemented
        return self.vertices == other.vertices

    def __hash__(self):
        return hash(self.vertices)

    @property
    def N(self) -> int:
        """Number of vertices."""
        return len(self.vertices)

    @property
    def coordinates(self) -> tuple[str, ...] | None:
        """The names of z, of all vertices; None where none names them."""
        return next(iter(self._named), None)

    @property
    def reduction(self) -> Reduction | None:
        """Of what the vertices are parts, as in `SecondOrderSystem`."""
        return self.vertices[0].reduction

    @property
    def _named(self):
        return {v.coordinates for v in self.vertices} - {None}

    @property
    def mean(self) -> SecondOrderSystem:
        """The plant in the middle of the vertices."""
        return self.at(np.full(self.N, 1 / self.N))

    def at(self, weights: ArrayLike) -> SecondOrderSystem:
        """The plant with the given convex weights (2.5).

        Parameters
        ----------
        weights : (N,) array_like
            Non-negative, of sum one.
        """
        from .simplex import checked_weights

        given = checked_weights(weights, self.N)
        M, D, S, B, F = (
            sum(w * getattr(v, x) for w, v in zip(given, self.vertices))
            for x in "MDSBF"
        )
        return SecondOrderSystem(M, D, S, B, F, self.coordinates, self.reduction)

    def sample(self, count: int, seed: int) -> list[SecondOrderSystem]:
        """Random plants, uniform over the weights.

        Parameters
        ----------
        count : int
            How many.
        seed : int
            The seed of numpy's generator: the same seed gives the same plants.
        """
        from .simplex import random_weights

        return [self.at(w) for w in random_weights(self.N, count, seed)]


def _sizes(plant):
    """The sizes n, m and p in words."""
    counts = (
        (plant.n, "degree of freedom", "degrees of freedom"),
        (plant.m, "input", "inputs"),
        (plant.p, "disturbance", "disturbances"),
    )
    return ", ".join(f"{k} {one if k == 1 else many}" for k, one, many in counts)
