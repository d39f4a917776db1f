"""A bound of the input from given initial states (Lemma 2.2)."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import analysis, theorems
from ..exact.rational import exact
from ..language import Unknown, block, eye
from ..plants.checks import matrix, numbers, positive
from ..plants.coupled import Coupled, SlackVertex
from ..plants.descriptor import Descriptor
from ..runtime.array_like import ArrayLike
from ..runtime.names import sane_name
from ..runtime.read_only import put
from .base import Requirement
from .channel import places
from .known_gain import KnownVertex
from .posed import PosedLoop
from .vocabulary import PARAMETERS, U_MAX, Parameter

PLAIN = "saturation"  # what a bound is called to which nobody gave a name


@dataclass(frozen=True, eq=False)
class Saturation(Requirement):
    """The requirement |K x(t)| <= u_max from x(0) = x0 (Lemma 2.2).

    Parameters
    ----------
    u_max : float, list of float or None
        Bound of the Euclidean norm of K x, in the unit of u; of a list one number
        bounds each input, and the plant has as many. None where it is to be minimised.
    x0 : (N,) or (k, N) array_like
        Initial state [z(0); z'(0); x3(0)]. With a law the plant's is enough: integrals
        start at zero, filters at what is measured, and free dynamics at zero. Of k
        rows it holds from each, from its negative, and from all states between them.
    acceleration : bool
        Bound the whole signal u = K x + K_A z'' instead, which the
        lemma as printed doesn't. ``M - B K_A`` must be certain.
    name : str
        Tells it from others; ``minimize=name`` minimises it. Of a list each input's is
        "name of u1", and so on.
    u : list of int, optional
        Of which inputs, counted from 0; without it of all.
    count : int, optional
        How many inputs the plant must have; a list says it.

    Examples
    --------
    >>> import sosbook as sos
    >>> limits = sos.Saturation([1, 2], [[0.5, 0, 0, 0], [0, 0.5, 0, 0]])
    >>> [f"{r.name}: {r.u_max:g}" for r in limits.parts]
    ['saturation of u1: 1', 'saturation of u2: 2']
    """

    u_max: Any
    x0: np.ndarray
    acceleration: bool = False
    name: str = PLAIN
    u: tuple | None = None
    count: int | None = None

    kind = "input"
    affine_in_quotient = True
    rank = 40
    of_two = 'give one of them another name, as in Saturation(..., name="of the drive")'
    titles = {"x0": "x(0) in the ellipsoid", "u_max": "input bound u_max"}

    if TYPE_CHECKING:  # what the constructor takes

        def __init__(
            self,
            u_max: float | Sequence[float] | None,
            x0: ArrayLike,
            acceleration: bool = False,
            name: str = PLAIN,
            u: Sequence[int] | None = None,
            count: int | None = None,
        ) -> None: ...

    def __post_init__(self):
        """Check the bounds, the initial states, the name and the inputs."""
        if np.ndim(self.u_max):
            bounds = numbers("u_max", self.u_max)
            if bounds.ndim != 1 or not bounds.size or self.u is not None:
                raise ValueError(
                    "u_max must be a number, or a list of one for each input of the "
                    "plant, without u"
                )
            bounds = [positive(f"u_max[{k}]", float(x)) for k, x in enumerate(bounds)]
            put(self, u_max=tuple(bounds), count=len(bounds))
        elif self.u_max is not None:
            put(self, u_max=positive("u_max", self.u_max))
        x0 = numbers("x0", self.x0)
        if x0.ndim not in (1, 2) or not x0.size:
            raise ValueError("x0 must be a vector of finite numbers, or rows of them")
        rows = matrix("x0", np.atleast_2d(x0))
        put(self, x0=rows if x0.ndim == 2 else rows[0])
        if not isinstance(self.acceleration, bool):
            raise ValueError(
                f"acceleration must be True or False, got {self.acceleration!r}"
            )
        if sane_name(self.name) in PARAMETERS:
            raise ValueError(
                f"name={self.name!r} is that of another bound: take one of its own"
            )
        if self.u is not None:
            put(self, u=places("u", self.u))

    @staticmethod
    def box(sizes: ArrayLike) -> np.ndarray:
        """Corners of a box of initial states, one of each pair x and -x.

        Parameters
        ----------
        sizes : (N,) array_like
            The largest size of each entry of x(0); zero where it is certain.

        Returns
        -------
        (k, N) array
            The ``x0`` of a bound from all of the box.

        Examples
        --------
        >>> Saturation.box([0.5, 0.1, 0, 0]).tolist()
        [[0.5, 0.1, 0.0, 0.0], [0.5, -0.1, 0.0, 0.0]]
        """
        sizes = matrix("sizes", [numbers("sizes", sizes)])[0]
        if (sizes < 0).any() or not sizes.any():
            raise ValueError("sizes must not be negative, nor all zero")
        first, *others = np.flatnonzero(sizes)
        signs = np.zeros((2 ** len(others), len(sizes)))
        signs[:, first] = 1.0
        signs[:, others] = np.array(list(product((1.0, -1.0), repeat=len(others))))
        return signs * sizes + 0.0

    @property
    def parts(self) -> tuple:
        """Itself; where ``u_max`` is a list, a bound of each input."""
        if not isinstance(self.u_max, tuple):
            return (self,)
        return tuple(
            replace(self, u_max=x, name=f"{self.name} of u{k + 1}", u=(k,))
            for k, x in enumerate(self.u_max)
        )

    @property
    def named(self) -> bool:
        """True if it has a name of its own."""
        return self.name != PLAIN

    @property
    def parameter(self) -> Parameter:
        """The bound; a name of its own is its key, so that it can be minimised."""
        if not self.named:
            return U_MAX
        words, label = f"{U_MAX.words}, {self.name}", f"{U_MAX.label} ({self.name})"
        return replace(U_MAX, key=self.name, words=words, label=label)

    @property
    def promise(self) -> str:
        """The name of the promise."""
        return self.parameter.key

    @property
    def bound(self) -> float | None:
        return self.u_max

    def with_bound(self, bound: float) -> "Saturation":
        return replace(self, u_max=bound)

    @property
    def points(self) -> list:
        """(name, x0) of each initial state; the names are those of its blocks."""
        if self.x0.ndim == 1:
            return [("x0", self.x0)]
        return [(f"x0 {j}", x) for j, x in enumerate(self.x0, 1)]

    def data(self) -> dict:
        data = super().data()
        del data["count"]
        if self.u is None:
            del data["u"]
        else:
            data["u"] = list(self.u)
        return data

    @classmethod
    def of_data(cls, data: dict) -> "Requirement":
        known = {k: data[k] for k in ("name", "u") if k in data}
        return replace(super().of_data({**data, "u": None}), **known)

    def joined(self, parts: Any) -> "Saturation":
        if self.x0.shape[-1] != parts.rows.shape[1]:  # a file has the law's states, too
            return self
        return replace(self, x0=self.x0 @ parts.rest.astype(float).T)

    def check(self, request: Any) -> None:
        """Raise ValueError if ``request`` has no input, or x0 doesn't fit."""
        super().check(request)
        if request.plant.m == 0:
            raise ValueError(
                "saturation bounds the input, but the plant has no B: give its input "
                "as the B of a DescriptorSystem to analyse_pid"
            )
        first = request.ground.certain[0].E
        bounded = self.acceleration and request.K_A is not None
        if bounded and any(
            not np.array_equal(d.E, first) for d in request.ground.certain
        ):
            raise ValueError(
                "saturation: acceleration=True needs the same M - B K_A "
                "at every vertex; bound K x only"
            )
        if self.x0.shape[-1] != request.order:
            states = request.applied.states
            raise ValueError(
                f"x0 has {self.x0.shape[-1]} entries, needs "
                f"{states[0]} = {request.order}: {states[1]}"
            )
        m = request.plant.m
        if self.count not in (None, m):
            raise ValueError(
                f"u_max is a list of {self.count}, and the plant has {m} inputs: give "
                "a number for each, or u=[0] to bound some"
            )
        if self.u is not None and max(self.u) >= m:
            raise ValueError(
                f"u: there is no input {max(self.u)}, for the plant has {m}, "
                "counted from 0"
            )

    def once(self, loop: PosedLoop) -> Iterable:
        if loop.epsilon is not None:
            return
        for name, x0 in self.points:
            yield name, (), theorems.initial_state(loop.near(loop.P), loop.state(x0))
        whole = self._whole(loop)
        for i in range(len(loop.plain)) if whole else (0,):
            vertices = (i,) if whole else ()
            yield "u_max", vertices, self._bound(loop, loop.P, loop.P, loop.Y, i)

    def bounds_input_from(self) -> np.ndarray | None:
        plain = self.u is None and self.x0.ndim == 1 and not self.acceleration
        return self.x0 if plain else None

    def of_part(self, rows: np.ndarray) -> "Saturation | None":
        return None if self.acceleration else replace(self, x0=self.x0 @ rows.T)

    def pair(self, loop: PosedLoop, c: Coupled) -> Iterable:
        return ()

    def slack(self, loop: PosedLoop, c: SlackVertex, i: int) -> Iterable:
        P, V = loop.near(c.P), loop.near(c.V)
        for name, x0 in self.points:
            yield name, theorems.slack_initial_state(P, V, loop.state(x0))
        yield "u_max", self._bound(loop, c.P, c.V.T, c.Y, i)

    @property
    def takes_multipliers(self) -> bool:
        return not self.acceleration

    def known_gain(self, c: KnownVertex) -> Iterable:
        some = c.loop.K if self.u is None else c.loop.K[list(self.u)]
        K = c.mu * c.rows(some)
        yield "decay", theorems.free_stability(c)
        for name, x0 in self.points:
            start = c.state(exact(x0)[:, None])
            yield name, c.mu - start.T @ c.P @ start
        limit = c.level(self) * c.mu * eye(len(some))
        yield "u_max", block([[c.P, K.T], [K, limit]])

    def known_gain_unknowns(self, c: KnownVertex) -> dict:
        starts = c.state(exact(np.atleast_2d(self.x0)).T)
        most = float((starts**2).sum(axis=0).max())
        return {Unknown("mu", 1, symmetric=True): most or 1.0}

    def _whole(self, loop):
        """True if the accelerations' part is bounded, too."""
        return self.acceleration and loop.request.K_A is not None

    def _bound(self, loop, P, X, Y, i):
        """The block of vertex i, where K = Y X^-1."""
        u_max2 = loop.level(self) / loop.scale**2
        some = None
        if self.u is not None:
            some = loop.number(np.eye(loop.request.plant.m)[list(self.u)])
        if not self._whole(loop):
            return theorems.control_bound(P, Y if some is None else some @ Y, u_max2)
        d, n = loop.plain[i], loop.request.plant.n
        K_A = loop.number(np.array(loop.request.K_A, float))
        second = slice(n, 2 * n)  # the rows of M z'' = ..
        row = loop.row(d.A[second])
        mass, push = d.E[second, second], d.Bu[second]
        parts = P, X, Y, K_A, mass, row, push, u_max2
        return theorems.whole_control_bound(*parts, some)

    def claim(self) -> str:
        from ..exact.checker.requirements import claim

        return claim(self.data())

    def truth(
        self, loops: Sequence[Descriptor], K: np.ndarray, K_A: np.ndarray | None = None
    ) -> float:
        K_A = K_A if self.acceleration else None
        starts = np.atleast_2d(self.x0)
        several = ((d, x0) for d in loops for x0 in starts)
        return max(analysis.peak_input(d, K, x0, K_A, self.u) for d, x0 in several)
