"""The plant with its integrator as a descriptor system, with the signs that reproduce
the thesis's printed poles (equation (2.7) prints a minus): ``e = z - r``, ``x3 = +
integral of U e``, ``u = K x`` with ``x = [z; z'; x3]``.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..exact.rational import exact, inverse
from ..runtime.read_only import ReadOnly
from .checks import as_in_a_file, check_rank, matrix, rank_deficient
from .sparse import check_small

MATRICES = ("E", "A", "Bu", "Bw", "C", "Du", "Dw", "Ca")
OF_ARGUMENTS = {"B": "Bu", "B_w": "Bw", "D_u": "Du", "D_w": "Dw", "C_a": "Ca"}


@dataclass(frozen=True, eq=False)
class Descriptor(ReadOnly):
    """E x' = A x + Bu u + Bw w, y = C x + Ca x' + Du u + Dw w (2.8), (2.11).

    Parameters
    ----------
    E, A : (N, N) array
        ``E = diag(I, M - B K_A, I)``; ``N = 2n + a``.
    Bu : (N, m) array
        The input matrix.
    Bw : (N, p) array
        The disturbance matrix.
    C : (q, N) array
        The output matrix; of a second-order plant it picks the displacement ``z``.
    Du : (q, m) array, optional
        How u enters the output y; zero without it.
    Dw : (q, p) array, optional
        How w enters it.
    Ca : (q, N) array, optional
        How x' enters it: the accelerations among it.
    Uw : (m, p) array, optional
        How w enters u = K x + Uw w, by the noise of a sensor; zero without it.
    n, a : int
        The first states are n displacements z, n velocities z' and a integrals x3;
        zero where they aren't.
    """

    E: np.ndarray
    A: np.ndarray
    Bu: np.ndarray
    Bw: np.ndarray
    C: np.ndarray
    Du: np.ndarray | None = None
    Dw: np.ndarray | None = None
    Ca: np.ndarray | None = None
    Uw: np.ndarray | None = None
    n: int = 0
    a: int = 0

    def map(self, function):
        """Apply a function to each matrix, of rationals where these are rounded."""
        E = function(self.E)
        if E is self.E:  # floats stay floats
            return self
        d = vars(self).get("_exactly", self)
        if isinstance(d, tuple):
            d = first_order(exact, *map(exact, d))
        E = E if d is self else function(d.E)
        parts = (getattr(d, name) for name in (*MATRICES[1:], "Uw"))
        made = (x if x is None else function(x) for x in parts)
        return Descriptor(E, *made, self.n, self.a)

    @property
    def rounded(self):
        """True if the floats aren't the matrices themselves, but near them."""
        return "_exactly" in vars(self)

    def keep(self, rationals):
        """Let it know the rationals, by argument, next to which its floats are."""
        own = {OF_ARGUMENTS.get(k, k): x for k, x in rationals.items()}
        vars(self)["_exactly"] = replace(self, **own)

    def output(self, K):
        """The matrix from x to y in the loop u = K x: C + Du K."""
        d = self.explicit()
        return d.C if d.Du is None else d.C + d.Du @ K

    def explicit(self):
        """The same output without x', which the equation of the plant gives."""
        if self.Ca is None:
            return self
        L = self.Ca @ inverse(self.E)
        C, Du, Dw = self.C + L @ self.A, L @ self.Bu, L @ self.Bw
        Du = Du if self.Du is None else self.Du + Du
        Dw = Dw if self.Dw is None else self.Dw + Dw
        return replace(self, C=C, Du=Du, Dw=Dw, Ca=None)

    def change(self, left, T, scale=1):
        """The system in coordinates x = T xi, u = scale v, its rows times ``left``."""
        moved = left @ self.E @ T, left @ self.A @ T, left @ self.Bu * scale
        Du = None if self.Du is None else self.Du * scale
        Ca = None if self.Ca is None else self.Ca @ T
        return Descriptor(*moved, left @ self.Bw, self.C @ T, Du, self.Dw, Ca)

    def state_space(self):
        """E^-1 [A Bu Bw], the standard form."""
        N, m = self.Bu.shape
        solved = self._solved
        return solved[:, :N], solved[:, N : N + m], solved[:, N + m :]

    @cached_property
    def _solved(self):
        solved = np.linalg.solve(self.E, np.hstack([self.A, self.Bu, self.Bw]))
        solved.flags.writeable = False
        return solved


def descriptors(plant, U=None, K_A=None):
    """One `Descriptor` for each vertex of a plant.

    Parameters
    ----------
    plant : SecondOrderSystem or Polytope
        The plant, or the polytope of plants.
    U : (a, n) array_like, optional
        Which errors are integrated; without it the controller is PD.
    K_A : (m, n) array_like, optional
        Acceleration gain; zero without it.

    Raises
    ------
    ValueError
        If shapes are wrong, ``M - B K_A`` is singular at a vertex, or
        the integrators are uncontrollable from u.

    Notes
    -----
    Source: thesis (2.2), (2.8), (2.11), with errata: the sign of (2.7)
    and E = diag(I, M - B K_A, I), not E = M - B K_A.
    """
    check_small(plant.vertices[0])
    U = np.zeros((0, plant.n)) if U is None else matrix("U", U, (None, plant.n))
    if K_A is None:
        K_A = np.zeros((plant.m, plant.n))
    K_A = matrix("K_A", K_A, (plant.m, plant.n))
    if plant.family and not K_A.any() and not as_in_a_file():
        plant.family.check_regular()
    return tuple(_descriptor(v, U, K_A) for v in plant.vertices)


def _descriptor(v, U, K_A):
    """The `Descriptor` of a vertex, which keeps its last one: a search asks again at
    each value, and most of the time would go into the checks.
    """
    key = U.shape, U.tobytes(), K_A.tobytes()
    kept = vars(v).get("_described")
    if kept is None or kept[0] != key:
        kept = key, _checked_descriptor(v, U, K_A)
        vars(v)["_described"] = kept
    return kept[1]


def _checked_descriptor(v, U, K_A):
    """The `Descriptor` of a plant with integrals U and K_A, checked."""
    a = len(U)
    inertia = v.M - v.B @ K_A
    check_rank(
        inertia,
        "M - B K_A is singular: give an acceleration gain K_A that makes it regular "
        "(Lemma 2.1; regularize finds one). A row without mass and damping is taken "
        "out by sosbook.plants.condense, and one with damping alone is a state of a "
        "DescriptorSystem",
        1e-14,
    )
    if a:
        check_rank(
            U,
            "U has linearly dependent rows: two integrators would carry "
            "the same error; remove one",
        )
        check_rank(
            np.block([[-v.S, v.B], [U, np.zeros((a, v.m))]]),
            "U is uncontrollable: [-S B; U 0] lacks full row rank, so a "
            "transmission zero at s = 0 hides an integrator from u; "
            "integrate fewer or other errors",
        )

    parts = v.M, v.D, v.S, v.B, v.F, U, K_A
    d = first_order(np.asarray, *parts)
    own = vars(v).get("_rationals", {})
    if own or K_A.any():
        parts = (*(own.get(x, getattr(v, x)) for x in "MDSBF"), U, K_A)
        vars(d)["_exactly"] = parts
    return d


def first_order(number, M, D, S, B, F, U, K_A):
    """(2.8) of ``M``, ``D``, ``S``, ``B``, ``F``, ``U``, ``K_A``, each a ``number``."""
    n, a = len(M), len(U)
    N, z, speed = 2 * n + a, slice(n), slice(n, 2 * n)
    E, A = number(np.eye(N)), number(np.zeros((N, N)))
    E[speed, speed] = M - B @ K_A
    A[z, speed], A[2 * n :, z] = number(np.eye(n)), U
    A[speed, z], A[speed, speed] = -S, -D
    Bu, Bw = (number(np.zeros((N, x.shape[1]))) for x in (B, F))
    Bu[speed], Bw[speed] = B, F
    return Descriptor(E, A, Bu, Bw, C=number(np.eye(n, N)), n=n, a=a)


def twins(vertices):
    """For each of the vertices the index of the first one that equals it."""
    first = {}

    def entries(d):
        matrices = (getattr(d, name) for name in MATRICES)
        return tuple(None if x is None else tuple(np.ravel(x)) for x in matrices)

    if len(vertices) == 1:
        return [0]
    return [first.setdefault(entries(d), i) for i, d in enumerate(vertices)]


def mean_descriptor(vertices):
    """The mean of some vertices; the first one if the mean's E is nearly singular.

    A vertex that repeats an earlier one doesn't count again.
    """
    vertices = [vertices[i] for i in sorted(set(twins(vertices)))]
    if len(vertices) == 1:
        return vertices[0]
    mean = combined(vertices, lambda some: sum(some) / len(some))
    return vertices[0] if rank_deficient(mean.E, 1e-6) else mean


def combined(vertices, function):
    """The plant whose matrices a ``function`` makes of lists of the ``vertices``' ones;
    an output matrix that all share stays as it is.
    """

    def one(name):
        first, *others = some = [getattr(d, name) for d in vertices]
        if first is None or (
            name in MATRICES[4:] and all(same_output(first, x) for x in others)
        ):
            return first
        return function(some)

    first = vertices[0]  # of one law: w enters u alike
    return Descriptor(*map(one, MATRICES), Uw=first.Uw, n=first.n, a=first.a)


def same_output(x, y):
    """True if the output matrices ``x`` and ``y`` are the same, or both None."""
    plain = isinstance(x, np.ndarray) and isinstance(y, np.ndarray)
    return x is y or (plain and np.array_equal(x, y))
