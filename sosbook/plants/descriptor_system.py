"""Plants and loops in first order, where the second-order form ends."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..exact.rational import exact
from ..runtime.array_like import ArrayLike
from ..runtime.read_only import ReadOnly
from .checks import check_rank, checked_names, matrices_of, matrix, positive
from .descriptor import MATRICES, OF_ARGUMENTS, Descriptor, combined
from .parametric import MayBeSymbolic
from .reduction import Reduction, balanced


@dataclass(frozen=True, eq=False, repr=False)
class DescriptorSystem(MayBeSymbolic, ReadOnly):
    """E x' = A x + B u + B_w w, y = C x + C_a x' + D_u u + D_w w, or a polytope.

    For plants from which a state was taken out, and for closed loops
    with an observer or a filter. Its controllers are u = K x.

    With ``dt`` it is a plant of discrete time, E x(k+1) = A x(k) + B u(k) + B_w w(k),
    y(k) = C x(k) + D_u u(k) + D_w w(k): an identified model, or one from a file.

    Parameters
    ----------
    E, A : (N, N) array_like, or lists of them, one for each vertex
        E regular.
    B : (N, m) array_like, or a list of them, optional
        Without it there is nothing to design: a closed loop.
    B_w : (N, p) array_like, or a list of them, optional
        The disturbance matrix.
    C : (q, N) array_like, or a list of them, optional
        The output matrix.
    D_u : (q, m) array_like, or a list of them, optional
        Lets gamma bound the input too: with C = [I; 0], D_u = [0; R] it
        bounds the norm from w to [x; R u]. Systems with equal matrices
        are equal.
    D_w : (q, p) array_like, or a list of them, optional
        What of w is seen at once.
    C_a : (q, N) array_like, or a list of them, optional
        Weighs x', so that an acceleration needs no division by a mass.
    reduction : Reduction, optional
        Of what it is a part: `reduce` says so, and every proof does.
    sensed : Sensed, optional
        What it was before sensors that are late were joined: a law does it.
    states : sequence of N str, optional
        What the states are called, by proofs too; x1, x2, ... without it.
    dt : float, optional
        The time from one tick to the next, in s, of a plant of discrete time. Regions
        are of its poles z then: ``LMIRegion.disk(0.9)`` asks for abs(z) < 0.9. The H2
        norm and the cost are means over the ticks, with noise of variance one at each.

    Notes
    -----
    The ``vertices`` of a plant of discrete time are those of its change from tick to
    tick: with v = (x(k+1) - x(k)) / dt it is dt E v = (A - E) x + B u + B_w w, which
    is one of continuous time with v in the place of x'. A pole z is s = (z - 1) / dt
    there, and stability is the disk of radius 1 / dt around -1 / dt. x' P x rises in a
    tick by dt (2 x' P v + dt v' P v): each theorem has one more term, of size dt.

    Examples
    --------
    >>> DescriptorSystem(np.eye(2), [[0, 1], [-2, -3]]).order
    2
    >>> plant = DescriptorSystem(1, 1.2, 0.5, dt=0.1)
    >>> print(plant.vertices[0].E, plant.vertices[0].A)
    [[0.1]] [[0.2]]
    """

    E: np.ndarray
    A: np.ndarray
    B: np.ndarray | None = None
    B_w: np.ndarray | None = None
    C: np.ndarray | None = None
    D_u: np.ndarray | None = None
    D_w: np.ndarray | None = None
    C_a: np.ndarray | None = None
    reduction: Reduction | None = None
    sensed: Any = None
    states: Any = None
    dt: float | None = None

    if TYPE_CHECKING:  # what the constructor takes, and makes

        @property
        def vertices(self) -> tuple[Descriptor, ...]: ...

        def __init__(
            self,
            E: ArrayLike | Sequence[ArrayLike],
            A: ArrayLike | Sequence[ArrayLike],
            B: ArrayLike | Sequence[ArrayLike] | None = None,
            B_w: ArrayLike | Sequence[ArrayLike] | None = None,
            C: ArrayLike | Sequence[ArrayLike] | None = None,
            D_u: ArrayLike | Sequence[ArrayLike] | None = None,
            D_w: ArrayLike | Sequence[ArrayLike] | None = None,
            C_a: ArrayLike | Sequence[ArrayLike] | None = None,
            reduction: Reduction | None = None,
            sensed: Any = None,
            states: Iterable[str] | None = None,
            dt: float | None = None,
        ) -> None:
            """Take the matrices, and what else is known."""

    #: The `Uncertain` whose vertices these are; None where they were given.
    family = None

    @classmethod
    def of(
        cls,
        vertices: "Sequence[Descriptor]",
        reduction: Reduction | None = None,
        sensed: Any = None,
        states: Any = None,
        dt: float | None = None,
    ) -> "DescriptorSystem":
        """The polytope of some vertices.

        Parameters
        ----------
        vertices : sequence of Descriptor
            They have the same sizes.
        reduction, sensed, states, dt
            As of the class; with ``dt`` they are those of the change.
        """
        shown = list(vertices)
        if dt is not None:
            shown = [of_next(d, dt).map(lambda x: x.astype(float)) for d in vertices]
        several: Any = [[getattr(d, x) for d in shown] for x in MATRICES]
        alone = len(shown) == 1
        given: Any = [None if x[0] is None else x[0] if alone else x for x in several]
        made = cls(*given)
        object.__setattr__(made, "reduction", reduction)
        object.__setattr__(made, "sensed", sensed)
        object.__setattr__(made, "states", checked_names(states, made.order, "states"))
        object.__setattr__(made, "dt", dt)
        object.__setattr__(made, "vertices", tuple(vertices))
        return made

    def __post_init__(self):
        """Check the shapes and make the vertices."""
        if self.dt is not None:
            object.__setattr__(self, "dt", positive("dt", self.dt))
            if self.C_a is not None:
                raise ValueError(
                    "C_a weighs x', which a plant of discrete time hasn't: leave it "
                    "out, and write what is weighed as C x + D_u u + D_w w"
                )
        N = len(matrices_of("E", self.E)[0])
        object.__setattr__(self, "states", checked_names(self.states, N, "states"))
        empty = {"B": (N, 0), "B_w": (N, 0), "C": (0, N)}
        lists: dict = {}
        for name in ("E", "A", "B", "B_w", "C", "D_u", "D_w", "C_a"):
            value = getattr(self, name)
            if value is None and name in empty:
                value = np.zeros(empty[name])
            lists[name] = [None] if value is None else matrices_of(name, value)
        q, m, p = len(lists["C"][0]), lists["B"][0].shape[1], lists["B_w"][0].shape[1]
        shapes = {"B": (N, m), "B_w": (N, p), "C": (q, N)}
        shapes |= {"D_u": (q, m), "D_w": (q, p), "C_a": (q, N)}
        count = max(map(len, lists.values()))
        for name, matrices in lists.items():
            if len(matrices) not in (1, count):
                raise ValueError(
                    f"{name} has {len(matrices)} vertices, needs {count} or one"
                )
            if matrices[0] is not None:
                if name in ("D_u", "D_w", "C_a") and not q:
                    raise ValueError(f"{name} is given without C: give both")
                shape = shapes.get(name, (N, N))
                matrices = [matrix(name, x, shape) for x in matrices]
            lists[name] = matrices * (count // len(matrices))
        for E in lists["E"]:
            check_rank(E, NO_RATE, 1e-14)
        several = map(Descriptor, *lists.values())
        if self.dt is not None:
            several = (of_change(d, self.dt) for d in several)
        object.__setattr__(self, "vertices", tuple(several))

    def __repr__(self):
        corners = "" if len(self.vertices) == 1 else f"{len(self.vertices)} vertices, "
        ticks = "" if self.dt is None else f"ticks of {self.dt:g} s, "
        return (
            f"<DescriptorSystem: {ticks}{corners}order {self.order}, {self.m} inputs, "
            f"{self.p} disturbances, {self.n} outputs>"
        )

    def __eq__(self, other):
        if not isinstance(other, DescriptorSystem):
            return NotImplemented
        alike = str(self.reduction) == str(other.reduction)
        return (
            alike
            and self.dt == other.dt
            and len(self.vertices) == len(other.vertices)
            and all(
                _equal(getattr(a, name), getattr(b, name))
                for a, b in zip(self.vertices, other.vertices)
                for name in MATRICES
            )
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
        from .simplex import checked_weights

        given = checked_weights(weights, len(self.vertices))

        def mean(some):
            return sum(w * x for w, x in zip(given, some))

        return self.having([combined(self.vertices, mean)])

    def having(self, vertices: "Sequence[Descriptor]") -> "DescriptorSystem":
        """The same system with other ``vertices``, as `of` takes them."""
        own = "reduction", "sensed", "states", "dt"
        return DescriptorSystem.of(vertices, **{x: getattr(self, x) for x in own})

    def reduce(self, states: int) -> "DescriptorSystem":
        """The system in fewer states, which knows that it is a part of this one.

        Balanced: kept is what the inputs reach and the outputs see the most. Proofs
        say "of the reduced model (8 of 270)", as of `SecondOrderSystem.reduce`.

        Parameters
        ----------
        states : int
            How many are kept.

        Raises
        ------
        ValueError
            On bad input, of several vertices, an unstable system or one without C.

        Examples
        --------
        >>> whole = DescriptorSystem(np.eye(2), [[-1, 0], [0, -50]], [[1], [1]],
        ...                          C=[[1, 1]])
        >>> part = whole.reduce(states=1)
        >>> str(part.reduction), bool(-1.2 < part.vertices[0].A < -1)
        ('1 of 2', True)
        """
        if self.reduction is not None or len(self.vertices) > 1:
            raise ValueError("reduce one whole system: this has vertices, or is a part")
        if self.dt is not None:
            raise ValueError(OF_TICKS.format("reduce"))
        (d,) = self.vertices
        basis, back = balanced(d, states)
        A, B, B_w = d.state_space()
        seen = d.explicit()
        return DescriptorSystem(
            np.eye(len(back)), back @ A @ basis, back @ B, back @ B_w,
            seen.C @ basis, seen.Du, seen.Dw,
            reduction=Reduction(len(back), len(A), basis, back, self),
        )  # fmt: skip

    def sample(self, count: int, seed: int) -> "list[DescriptorSystem]":
        """Random systems between the vertices, uniform over the weights.

        Parameters
        ----------
        count : int
            How many.
        seed : int
            The seed of numpy's generator: the same seed gives the same systems.
        """
        from .simplex import random_weights

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

    @property
    def outputs(self) -> dict:
        """C, D_u, D_w and C_a, those that there are; empty where vertices differ."""
        first, *others = self.vertices
        names = {"C": "C"} | {k: x for k, x in OF_ARGUMENTS.items() if x[0] != "B"}
        for d in others:
            if not all(
                _equal(getattr(first, x), getattr(d, x)) for x in names.values()
            ):
                return {}
        every = {k: getattr(first, x) for k, x in names.items()}
        return {k: x for k, x in every.items() if x is not None}


NO_RATE = (
    "E is singular at a vertex: solve the rows without a derivative for some of the "
    "states, put these into the other rows, and leave them out"
)
OF_TICKS = (
    "the plant is one of discrete time (dt is given), and {} is for plants of "
    "continuous time: design_pid, analyse_pid and design_lqr take both, with regions, "
    "norms and a quadratic cost; design.controller() is the program at its ticks"
)


def of_change(d, dt):
    """A `Descriptor` ``d`` of x(k+1) as the one of v = (x(k+1) - x(k)) / ``dt``: its
    floats are next to the rationals dt E and A - E, which it keeps.
    """
    exactly = d.map(exact)
    E, A = exact(dt) * exactly.E, exactly.A - exactly.E
    made = replace(d, E=E.astype(float), A=A.astype(float))
    vars(made)["_exactly"] = replace(exactly, E=E, A=A)
    return made


def keep(plant, matrices):
    """Let the one vertex of a ``plant`` know its rationals, ``matrices`` by name."""
    (d,), dt = plant.vertices, getattr(plant, "dt", None)
    d.keep(matrices)
    if dt is not None:
        known = vars(of_change(vars(d)["_exactly"], dt))
        vars(d)["_exactly"] = known["_exactly"]


def of_next(d, dt):
    """The `Descriptor` of x(k+1), in rationals, from ``d``, of `of_change`, and dt."""
    exactly = d.map(exact)
    E = exactly.E / exact(dt)
    return replace(exactly, E=E, A=exactly.A + E)


def _equal(a, b):
    if a is None or b is None:
        return a is b
    return np.array_equal(a, b)
