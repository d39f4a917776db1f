"""Plants and loops in first order, where the second-order form ends."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from ..runtime.read_only import ReadOnly
from .checks import check_rank, matrices_of, matrix
from .descriptor import Descriptor
from .parametric import MayBeSymbolic
from .simplex import checked_weights, random_weights

__all__ = ["DescriptorSystem"]


@dataclass(frozen=True, eq=False, repr=False)
class DescriptorSystem(MayBeSymbolic, ReadOnly):
    """E x' = A x + B u + B_w w, y = C x + D_u u, or a polytope of them.

    For plants from which a state was taken out, and for closed loops
    with an observer or a filter. Its controllers are u = K x.

    Parameters
    ----------
    E, A : (N, N) array_like, or lists of them, one for each vertex
        E regular.
    B : (N, m) array_like, or a list of them, optional
        Without it there is nothing to design: a closed loop.
    B_w : (N, p) array_like, or a list of them, optional
        The disturbance matrix.
    C : (q, N) array_like, optional
        The output matrix, the same at all vertices. An output that differs from
        vertex to vertex is that of a fast filter, whose state y is one of the
        plant's: tau y' = C_i x + D_i u - y.
    D_u : (q, m) array_like, optional
        Lets gamma bound the input too: with C = [I; 0], D_u = [0; R] it
        bounds the norm from w to [x; R u]. Systems with equal matrices
        are equal.

    Examples
    --------
    >>> DescriptorSystem(np.eye(2), [[0, 1], [-2, -3]]).order
    2
    """

    E: np.ndarray
    A: np.ndarray
    B: np.ndarray | None = None
    B_w: np.ndarray | None = None
    C: np.ndarray | None = None
    D_u: np.ndarray | None = None

    if TYPE_CHECKING:  # what the constructor takes, and makes

        @property
        def vertices(self) -> tuple[Descriptor, ...]: ...

        def __init__(
            self,
            E: ArrayLike | Sequence[ArrayLike],
            A: ArrayLike | Sequence[ArrayLike],
            B: ArrayLike | Sequence[ArrayLike] | None = None,
            B_w: ArrayLike | Sequence[ArrayLike] | None = None,
            C: ArrayLike | None = None,
            D_u: ArrayLike | None = None,
        ) -> None: ...

    #: The `Uncertain` whose vertices these are; None where they were given.
    family = None

    @classmethod
    def of(cls, vertices: "Sequence[Descriptor]") -> "DescriptorSystem":
        """The polytope of some vertices.

        Parameters
        ----------
        vertices : sequence of Descriptor
            They have the same outputs.
        """
        first = vertices[0]
        E, A, Bu, Bw = (
            [getattr(d, x) for d in vertices] for x in ("E", "A", "Bu", "Bw")
        )
        made = cls(E, A, Bu, Bw, first.C, first.Du)
        object.__setattr__(made, "vertices", tuple(vertices))
        return made

    def __post_init__(self):
        N = len(matrices_of("E", self.E)[0])
        lists = {
            name: matrices_of(name, np.zeros((N, 0)) if value is None else value)
            for name, value in (
                ("E", self.E),
                ("A", self.A),
                ("B", self.B),
                ("B_w", self.B_w),
            )
        }
        count = max(map(len, lists.values()))
        for name, matrices in lists.items():
            if len(matrices) not in (1, count):
                raise ValueError(
                    f"{name} has {len(matrices)} vertices, needs {count} or one"
                )
            shape = N, N if name in "EA" else matrices[0].shape[1]
            lists[name] = [
                matrix(name, x, shape) for x in matrices * (count // len(matrices))
            ]
        for E in lists["E"]:
            check_rank(E, "E is singular at a vertex", 1e-14)
        C = np.zeros((0, N)) if self.C is None else self.C
        C = matrix("C", _common("C", C), (None, N))
        D_u = self.D_u
        if D_u is not None:
            if not len(C):
                raise ValueError("D_u is given without C: give both, or neither")
            D_u = _common("D_u", D_u)
            D_u = matrix("D_u", D_u, (len(C), lists["B"][0].shape[1]))
        vertices = tuple(
            Descriptor(e, a, b, w, C, D_u) for e, a, b, w in zip(*lists.values())
        )
        object.__setattr__(self, "vertices", vertices)

    def __repr__(self):
        corners = "" if len(self.vertices) == 1 else f"{len(self.vertices)} vertices, "
        return (
            f"<DescriptorSystem: {corners}order {self.order}, {self.m} inputs, "
            f"{self.p} disturbances, {self.n} outputs>"
        )

    def __eq__(self, other):
        if not isinstance(other, DescriptorSystem):
            return NotImplemented
        return len(self.vertices) == len(other.vertices) and all(
            _equal(getattr(a, f.name), getattr(b, f.name))
            for a, b in zip(self.vertices, other.vertices)
            for f in fields(a)
        )

    def __hash__(self):
        first = self.vertices[0]
        return hash((len(self.vertices), self.order, (first.A + 0.0).tobytes()))

    def at(self, weights: ArrayLike) -> "DescriptorSystem":
        """The system with the given convex weights of the vertices.

        Parameters
        ----------
        weights : (vertices,) array_like
            Non-negative, of sum one.

        Examples
        --------
        >>> DescriptorSystem(1, [[[-1]], [[-3]]]).at([0.5, 0.5]).vertices[0].A
        array([[-2.]])
        """
        given = checked_weights(weights, len(self.vertices))
        first = self.vertices[0]
        E, A, B, B_w = (
            sum(w * getattr(d, name) for w, d in zip(given, self.vertices))
            for name in ("E", "A", "Bu", "Bw")
        )
        return DescriptorSystem(E, A, B, B_w, first.C, first.Du)

    def sample(self, count: int, seed: int) -> "list[DescriptorSystem]":
        """Random systems between the vertices, uniform over the weights.

        Parameters
        ----------
        count : int
            How many.
        seed : int
            The seed of numpy's generator: the same seed gives the same systems.
        """
        weights = random_weights(len(self.vertices), count, seed)
        return [self.at(w) for w in weights]

    def per_vertex(self, values: Any) -> Any:
        """One of the ``values`` for each vertex; for one plant the value itself."""
        return values if len(self.vertices) > 1 else values[0]

    @property
    def order(self) -> int:
        """Number of states."""
        return len(self.vertices[0].E)

    @property
    def m(self) -> int:
        """Number of inputs."""
        return self.vertices[0].Bu.shape[1]

    @property
    def p(self) -> int:
        """Number of disturbances."""
        return self.vertices[0].Bw.shape[1]

    @property
    def n(self) -> int:
        """Number of outputs."""
        return len(self.vertices[0].C)


def _common(name, value):
    """The one matrix of all vertices, or a ValueError that says what to do."""
    first, *others = matrices_of(name, value)
    if not all(_equal(first, other) for other in others):
        raise ValueError(
            f"{name} has {1 + len(others)} matrices that differ, needs one for all "
            "vertices: make such an output a state y of a fast filter, "
            "tau y' = C_i x + D_i u - y, by rows of E, A and B, and let C pick it"
        )
    return first


def _equal(a, b):
    if a is None or b is None:
        return a is b
    return np.array_equal(a, b)
