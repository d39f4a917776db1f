"""Reduced models: a plant in fewer coordinates, which knows what it is a part of."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import eigh, solve_continuous_lyapunov, svd

from ..runtime.read_only import ReadOnly
from ..runtime.sparse import issparse
from .checks import count, matrix
from .massless import definite_cure

STABLE_BY = 1e-12  # of the largest pole's size
NO_BASIS = (
    "the plant isn't the one that reduce() gave: its states, or the file that it is "
    "from, have no basis in the whole"
)
REACHED = 1e-12  # of the largest Hankel singular value; below it is rounding


@dataclass(frozen=True, eq=False)
class Reduction(ReadOnly):
    """The reduction of a whole plant to a part.

    ``kept``, ``of``: its coordinates, and those of the whole: displacements z, or the
    states of a `DescriptorSystem`; ``basis``, (of, kept): the whole's z is ``basis``
    times the part's. A plant from a proof file knows the numbers alone; ``back``,
    (kept, of): the part's z is ``back`` times the whole's; ``back @ basis`` is I;
    ``whole``: what was reduced.

    >>> str(Reduction(12, 336))
    '12 of 336'
    """

    kept: int
    of: int
    basis: np.ndarray | None = None
    back: np.ndarray | None = None
    whole: Any = None

    def __post_init__(self):
        kept = count("kept", self.kept, 1)
        if not kept < count("of", self.of, 2):
            raise ValueError(f"a reduced model keeps less than all, got {self}")
        super().__post_init__()

    def __str__(self):
        return f"{self.kept} of {self.of}"

    @property
    def words(self) -> str:
        """The first words of each claim of a proof about the part."""
        return f"of the reduced model ({self}): "

    @classmethod
    def in_states(cls, plant: Any, count: int) -> "Reduction | None":
        """That of a loop or a first-order form of a reduced plant; None of a whole one.

        ``plant``: the plant; ``count``: states of the loop: the plant's, and some that
        aren't reduced.

        >>> from sosbook import SecondOrderSystem
        >>> whole = SecondOrderSystem(np.eye(3), np.eye(3), np.eye(3), np.eye(3))
        >>> str(Reduction.in_states(whole.reduce(modes=1), 2))
        '2 of 6'
        """
        part = plant.reduction
        if part is None:
            return None
        per_row = 2 if hasattr(plant.vertices[0], "M") else 1
        return cls(count, count + per_row * (part.of - part.kept))

    def law(self, law: Any) -> Any:
        """The law of the part whose sensors are those of a ``law`` of the whole.

        A sensor of the whole sees the modes that are left out, too, and rows on the
        part don't say how. This law knows it: design with it, and `Design.check_on` and
        ``certify(on=whole)`` close the loop with the sensors of the whole.

        Parameters
        ----------
        law : PIDLaw, DynamicLaw, ShapedLaw or FullState
            With rows on the whole's z, z' and z'', or on its state.

        Examples
        --------
        >>> import sosbook as sos
        >>> one = np.eye(2)
        >>> whole = sos.SecondOrderSystem(one, one, np.diag([1, 9]), one[:, :1])
        >>> part = whole.reduce(modes=1)
        >>> law = part.reduction.law(sos.PIDLaw([[2, 3]], integrate=True))
        >>> law.words(part)
        'u depends on 2 mode 1 alone: PI'
        """
        if self.basis is None:
            raise ValueError(NO_BASIS)
        return law.on_part(self.basis, self.halves)

    @property
    def halves(self) -> int:
        """How many parts of its size a state has: z and z', or x alone."""
        return 1 + hasattr(self.whole.vertices[0], "M")

    def lift(self, K: np.ndarray) -> np.ndarray:
        """The gain on the whole plant's state that a gain of the part stands for.

        Parameters
        ----------
        K : (m, N) array
            ``[K_P K_D K_I]`` of the part, or K of a `DescriptorSystem`'s.

        Returns
        -------
        (m, N') array
            ``[K_P back, K_D back, K_I]``: the integrators of U are those of
            ``U @ back``.

        Examples
        --------
        >>> from sosbook import SecondOrderSystem
        >>> one = np.eye(2)
        >>> whole = SecondOrderSystem(one, one, np.diag([1, 9]), one)
        >>> whole.reduce(modes=1).reduction.lift(np.array([[2, 3], [0, 0]]))
        array([[2., 0., 3., 0.],
               [0., 0., 0., 0.]])
        """
        if self.back is None:
            raise ValueError(NO_BASIS)
        r, many, K = self.kept, self.halves, matrix("K", K)
        if K.shape[1] < many * r:
            raise ValueError(f"K has {K.shape[1]} columns, needs {many * r} or more")
        *parts, rest = np.split(K, [r * (k + 1) for k in range(many)], axis=1)
        return np.hstack([*(x @ self.back for x in parts), rest])


class Reducible:
    """Second-order plants, and polytopes of them, that can be reduced."""

    vertices: Any
    mean: Any

    def reduce(
        self, modes: int | None = None, *, rows: Iterable[int] | None = None
    ) -> Any:
        """The plant in fewer coordinates, which knows that it is a part of this one.

        A proof about it says "of the reduced model (12 of 336)": what is left out may
        do anything. `Design.check_on` looks at the whole plant under the gain, and
        ``design.certify(on=whole)`` proves it.

        Parameters
        ----------
        modes : int, optional
            How many of the slowest real modes of M and S are kept: those of negative
            stiffness first. With ``rows`` they are those of the other rows while these
            are held (Craig and Bampton).
        rows : sequence of int, optional
            Displacements that stay what they are, from 0; the others follow them at
            rest (Guyan). A gain then needs only these to be measured.

        Returns
        -------
        SecondOrderSystem or Polytope
            Of this kind, with a ``reduction``. All vertices have the coordinates of
            the mean plant's modes.

        Raises
        ------
        ValueError
            On bad input, if nothing is left out, where M isn't positive definite, or
            where a mode of negative stiffness would be left out.

        Examples
        --------
        >>> from sosbook import SecondOrderSystem
        >>> whole = SecondOrderSystem(np.eye(3), np.eye(3), np.diag([1, 4, 9]),
        ...                           [[1], [1], [1]])
        >>> part = whole.reduce(modes=2)
        >>> part.S, str(part.reduction)
        (array([[1., 0.],
               [0., 4.]]), '2 of 3')
        """
        from .modes import NoModes, modal, static

        vertices = self.vertices
        if vertices[0].reduction is not None:
            raise ValueError("the plant is reduced already: reduce the whole one")
        mean = vertices[0] if len(vertices) == 1 else self.mean
        rows = None if rows is None else list(rows)
        if rows is None and modes is None:
            raise ValueError("modes is missing: say how many are kept, or give rows=")
        try:
            if rows is None:
                basis, back = modal(mean.M, mean.S, modes)
            else:
                basis, back = static(mean.M, mean.S, rows, modes)
        except NoModes as fault:
            given = {name: getattr(mean, name) for name in "MDSBF"}
            cure = "" if issparse(mean.M) else definite_cure(given)
            raise ValueError(f"{fault}{cure}") from None
        names = mean.coordinates or [f"z{k + 1}" for k in range(mean.n)]
        kept = [names[k] for k in rows or ()]
        kept += [f"mode {k + 1}" for k in range(len(back) - len(kept))]
        more = dict(
            coordinates=kept, reduction=Reduction(len(back), mean.n, basis, back, self)
        )
        parts = [type(v)(**_projected(v, basis), **more) for v in vertices]
        polytope: Any = type(self)
        return parts[0] if vertices[0] is self else polytope(parts)


def _projected(plant, basis):
    """The matrices by name in the coordinates of a basis; symmetric ones stay it."""
    parts = {}
    for name in "MDS":
        x = getattr(plant, name)
        small = basis.T @ (x @ basis)
        parts[name] = small if abs(x - x.T).max() else (small + small.T) / 2
    return parts | {name: basis.T @ getattr(plant, name) for name in "BF"}


def balanced(d, states):
    """Basis and back of so many ``states`` of a stable d, reached and seen the most:
    from the square roots of both Gramians and the singular vectors of their product.

    Source: B. C. Moore, IEEE Trans. Automatic Control 26, 1981.
    """
    from .modes import few

    A, B, Bw = d.state_space()
    states = few("states", states, len(A))
    poles = np.linalg.eigvals(A)
    if poles.real.max() >= -STABLE_BY * abs(poles).max():
        raise ValueError(
            "only a stable plant can be balanced: close a first loop around it, or "
            "reduce its second-order form by modes"
        )
    C = d.explicit().C
    if not C.any():
        raise ValueError("the plant has no C: what is seen of it decides what is kept")
    push = np.hstack([B, Bw])
    reach, sight = (
        _root(solve_continuous_lyapunov(X, -Y))
        for X, Y in ((A, push @ push.T), (A.T, C.T @ C))
    )
    U, sizes, V = svd(sight.T @ reach)
    if not sizes[states - 1] > REACHED * sizes[0]:
        least = int((sizes > REACHED * sizes[0]).sum())
        raise ValueError(f"only {least} states are reached and seen: keep no more")
    roots = np.sqrt(sizes[:states])
    return reach @ V[:states].T / roots, (U[:, :states] / roots).T @ sight.T


def _root(W):
    squares, V = eigh((W + W.T) / 2)
    return V * np.sqrt(np.maximum(squares, 0.0))
