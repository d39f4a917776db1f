"""Exact proofs that no gain meets a request: by a fixed mode, or by a mass."""

from dataclasses import dataclass, replace
from itertools import combinations, islice

import numpy as np
from flint import fmpq, fmpq_mat, fmpq_poly

from ..exact.algebraic import roots_of
from ..exact.definite import exact
from ..exact.rational import decimal, decimals, fraction, fractions, rational_matrix
from ..exact.refusal import Refusal
from ..laws.base import Parts
from ..plants.controllability import FixedPart, fixed_part, is_singular, matrix_of
from ..requirements.base import Requirement
from ..requirements.lmi_region import by_matrices
from ..requirements.stability import Stability
from ..runtime.names import claimed
from ..runtime.time_limit import check_time
from .growing import FROM_STATES, refuse_by_growth
from .request_as_data import loop_data

LAW = "rows", "noise", "E", "A", "B", "of_sensors", "of_states"
MOST_MIDPOINTS = 100  # pairs of vertices between which the plant halfway is looked at
BITS = 64, 128, 256, 512, 1024  # of the point near a mode, until it decides


class FixedModeRefusal(Refusal):
    """A mode that no gain moves and that breaks what is asked.

    Its ``text`` is a file with the plant, rows V and a polynomial h with the
    companion matrix L: V A = L V E, V B = 0 and V has full rank, so every
    root of h is a mode that no input moves. With a given gain A is that of
    the loop and there is no B. A point c lies within n |h(c) / h'(c)| of a
    root (for h'/h is the sum of 1 / (c - root)), and a vector v shows that
    this disk keeps out of the region. Of a root on the boundary the file has
    no v; there h is its own mirror image, so the roots come in pairs of which
    one lies outside. With a law the file has what it joins: see `OfLaw`.
    """

    kind = "fixed mode"

    @property
    def mode(self):
        """The mode, in rad/s, to the nearest floats."""
        return complex(*(float(fraction(x)) for x in self.data["point"]))

    @property
    def place(self):
        """Which vertex has it, from 0: (k, k), or (i, j) for the plant halfway."""
        return tuple(self.data["place"])

    @property
    def part(self):
        """The `FixedPart` with the rows V and the matrix L."""
        data = self.data
        h, V = fmpq_poly([*map(fraction, data["polynomial"])]), _rows(data)
        return FixedPart(matrix_of(V), matrix_of(_companion(h)))

    @property
    def requirement(self):
        """The requirement that the mode breaks, in words."""
        asked = self.data["requirement"]
        r = Stability() if asked is None else Requirement.read(asked)
        return r.words or r.name

    @classmethod
    def of_mode(cls, request, place, part, root, requirement, how=None):
        """The file for a ``root``, a mode of a `FixedPart` ``part`` at a ``place`` (see
        `place`) of a ``request``, which breaks a ``requirement``; ``how`` is an
        `OfLaw` that read it.
        """
        h, V = _cyclic(part, root)
        requirement = by_matrices(requirement)
        for bits in BITS:
            c = _point(root, bits)
            for v in (_witness(requirement, complex(*map(float, c))), []):
                data = cls.contents(request, requirement, place, h, V, c, v)
                proof = cls.of(data if how is None else data | how.data())
                if proof.proven:
                    return proof
        return proof

    @classmethod
    def contents(cls, request, requirement, place, h, V, c, v):
        """The data of the file; ``request``, ``requirement`` and ``place`` are as in
        `of_mode`, ``h`` is the polynomial of the mode, ``V``, (k, N), the rows, ``c`` a
        point near it and ``v`` the vector, or nothing at the boundary.
        """
        stable = requirement.key == Stability().key
        return {
            **loop_data(request),
            "K": None if request.gain is None else decimals(request.gain),
            "requirement": None if stable else requirement.data(),
            "place": list(place),
            "polynomial": [str(h[k]) for k in range(h.degree() + 1)],
            "rows": [[str(e) for e in row] for row in V.tolist()],
            "point": [str(x) for x in c],
            "witness": [[decimal(e.real), decimal(e.imag)] for e in v],
        }


@dataclass(frozen=True, eq=False)
class OfLaw:
    """How a plant joined with ``parts`` of a law is read, whose mode no gain moves:
    transposed if the mode is ``seen`` by no sensor, else with the law's states.
    """

    parts: Parts
    seen: bool

    def data(self):
        """The data of the law and its free gains."""
        free = None if self.seen else self.parts.free
        return {"law": parts_data(self.parts), "free": free}

    def read(self, d):
        """E, A and B of a plant d in rationals."""
        if self.seen:
            return d.E.T, d.A.T, self.parts.rows.T
        whole = self.parts.joined(d)
        return whole.E, whole.A, whole.Bu


def parts_data(parts):
    """The data of the ``parts`` that a law joins, and what its signals are called."""
    found = {name: fractions(getattr(parts, name)) for name in LAW}
    names = dict(states=parts.states, signals=parts.signals)
    return found | {x: claimed(some) for x, some in names.items()}


def plant_at(request, place, how=None):
    """E, A, B in rationals at a ``place`` of a ``request``: the vertex (k, k), or
    halfway between (i, j). With a given gain there are no columns in B; ``how``
    is an `OfLaw` that reads it.
    """
    first, *other = request.vertices_in(exact, dict.fromkeys(place))
    E, A, B = first.E, first.A, first.Bu
    for j in other:
        half = exact(0.5)
        E, A, B = ((x + y) * half for x, y in ((E, j.E), (A, j.A), (B, j.Bu)))
    if request.gain is not None:
        A, B = A + B @ exact(request.gain), B[:, :0]
    return (E, A, B) if how is None else how.read(replace(first, E=E, A=A, Bu=B))


def _places(request):
    """Where plants must be stable: at the vertices and, if all are meant, halfway."""
    count = len(request.vertices)
    places = [(k, k) for k in range(count)]
    if request.coupling.between:
        pairs = combinations(range(count), 2)
        places += list(islice(pairs, MOST_MIDPOINTS))
    return places


def refuse_by_mode(request, places=None, how=None):
    """The `FixedModeRefusal` of a ``request`` at some ``places``, see
    `FixedModeRefusal.place`, or all, of a large loop a `GrowingRefusal`; None without
    one. ``how`` is an `OfLaw` that reads the plant of the law's request.
    """
    # whatever else is asked, all claims say that it is stable
    asked = {r.key: r for r in (*request.demands, request.claims.stability)}.values()
    large = request.gain is not None and request.order >= FROM_STATES and how is None
    large = large and request.step is None
    for place in _places(request) if places is None else places:
        check_time()
        grown = refuse_by_growth(request, place, asked) if large else None
        if grown is not None:
            return grown
        part = fixed_part(*plant_at(request, place, how))
        for mode in part.modes() if part is not None else ():
            for r in asked:
                form = r.pole_matrices()
                if form is not None and mode.inside(*form) is False:
                    found = place, part, mode, r, how
                    proof = FixedModeRefusal.of_mode(request, *found)
                    if proof.proven:
                        return proof
    return None


def _rows(data):
    rows = [[*map(fraction, row)] for row in data["rows"]]
    if len({len(row) for row in rows}) != 1:
        raise ValueError("the rows differ in length")
    return rational_matrix(rows)


def _companion(h):
    """L with L (1, s, s^2, ..)' = s (1, s, s^2, ..)' for the roots of h."""
    k = h.degree()
    L = exact(np.eye(k, k=1))
    L[k - 1] = [-h[i] for i in range(k)]
    return L


def _cyclic(part, root):
    """The irreducible polynomial of a root and rows in its companion form."""
    factors = [f / f[f.degree()] for f, _ in root.factor.factor()[1]]
    h = factors[0]
    if len(factors) > 1:
        (h,) = (f for f in factors if any(_same(root, r) for r in roots_of(f)))
    L, V = part.dynamics, part.rows
    value = 0 * L  # Cayley and Hamilton, if h is the whole polynomial
    if h.degree() < L.nrows():
        one = matrix_of(exact(np.eye(L.nrows())))
        for k in range(h.degree(), -1, -1):
            value = value * L + h[k] * one
    integers, _ = value.transpose().numer_denom()
    null, _ = integers.nullspace()
    u = fmpq_mat(1, L.nrows(), [null[i, 0] for i in range(L.nrows())])
    rows = []
    for _ in range(h.degree()):
        rows.append((u * V).entries())
        u = u * L
    V = rational_matrix(rows)
    return h, V / abs(V).max()  # as integers they outgrow floats


def _same(root, other):
    """True if two roots of factors without common roots are the same."""
    return all(root.ball(bits).overlaps(other.ball(bits)) for bits in BITS[:3])


def _point(root, bits):
    """A point with rational coordinates near a root; itself, if rational."""
    if root.factor.degree() == 1:
        return -root.factor[0] / root.factor[1], fmpq(0)
    ball = root.ball(bits)
    coordinates = []
    for x in (ball.real, ball.imag):
        mantissa, exponent = map(int, x.mid().man_exp())
        coordinates.append(fmpq(mantissa) * fmpq(2) ** exponent)
        if x.contains(0):
            coordinates[-1] = fmpq(0)
    return tuple(coordinates)


def _witness(requirement, s):
    """A vector v for which v* (alpha + beta s + beta' conj(s)) v isn't negative."""
    alpha, beta = (x.astype(float) for x in requirement.pole_matrices())
    v = np.linalg.eigh(alpha + beta * s + beta.T * np.conj(s))[1][:, -1]
    return [complex(round(e.real, 6), round(e.imag, 6)) for e in v]


class SingularMassRefusal(Refusal):
    """Two vertices between which the matrix E becomes singular, with the plant the
    ``text`` of a file: halfway det E is zero, or it has other signs at the two, and
    then it is zero in between.
    """

    kind = "singular mass"

    @property
    def vertices(self):
        """The two, from 0."""
        return tuple(self.data["between"])

    @classmethod
    def of_pair(cls, request, i, j):
        """The file for the vertices i and j of a request, from 0."""
        return cls.of({**loop_data(request), "between": [i, j]})


def refuse_by_mass(request):
    """The `SingularMassRefusal` of a ``request`` about all of a polytope; or None."""
    vertices = request.vertices
    if not request.coupling.between or all(
        np.array_equal(d.E, vertices[0].E) for d in vertices
    ):
        return None
    exactly = [matrix_of(d.E) for d in request.vertices_in(exact)]
    signs = [E.det() > 0 for E in exactly]
    if len(set(signs)) > 1:
        places = [sorted((signs.index(True), signs.index(False)))]
    else:
        pairs = islice(combinations(range(len(exactly)), 2), MOST_MIDPOINTS)
        places = [(i, j) for i, j in pairs if is_singular(exactly[i] + exactly[j])]
    proofs = (SingularMassRefusal.of_pair(request, *place) for place in places)
    return next((proof for proof in proofs if proof.proven), None)
