"""The slow modes of a plant, enclosed in balls, as a smaller plant.

Let W' A = Lambda W' with real W of full rank, for the plant x' = A x + B u.
Multiplied by W' and W, a solution of the design LMIs of the plant is one
for (Lambda, W' B): a design for the plant contains one for each of its
modes, as if that alone had the whole actuator.

Without it every refusal of a whole wing in chapter 17 would be "undecided".
"""

from dataclasses import dataclass

import numpy as np
from flint import acb, acb_mat, arb, arb_mat, ctx

from ..exact.adjoint import adjoint, slopes_at
from ..exact.checker.verdict import text_of
from ..exact.definite import exact, inverse, positive
from ..exact.proof import Examined
from ..exact.rational import decimal, decimals, read_array, read_fractions, read_number
from ..exact.refusal import MultiplierRefusal
from ..plants.descriptor import Descriptor
from ..plants.descriptor_system import DescriptorSystem
from ..solver.blocks import Blocks
from ..synthesis.proofs import frame_data, read_frame
from .proofs import in_frame, problem_data, read_delay_request

__all__ = ["Modes", "ModesRefusal", "modes_near", "slow_modes"]

BALL_BITS = 256  # of the balls' midpoints; a double has 53


@dataclass(frozen=True, eq=False)
class Modes:
    """Some modes of a plant.

    ``eigenvalues``: those on or above the real axis, as floats; ``pivots``: for each
    the entry of its left vector that is one; ``Lam``, ``B``: balls that hold Lambda and
    W' B.
    """

    eigenvalues: tuple
    pivots: tuple
    Lam: np.ndarray
    B: np.ndarray

    def __str__(self):
        return ", ".join(
            f"{s.real:.4g} ± {s.imag:.4g}j" if s.imag else f"{s.real:.4g}"
            for s in self.eigenvalues
        )

    def plant(self):
        """The `DescriptorSystem` at the balls' midpoints."""
        return DescriptorSystem(
            np.eye(len(self.Lam)), _middle(self.Lam), _middle(self.B)
        )

    def refused(self, request, multipliers):
        """True if ``multipliers`` of a ``request`` for `plant` refuse the modes.

        With the modes themselves sum <G_ka, Z_k> isn't quite zero. Adding sum_a c_a Z_k
        G_ka Z_k, with the midpoints' G_ka, makes it zero; c solves linear equations
        between balls. Z_k stays positive definite if it is so after the change's row
        sums are taken off its diagonal (Gershgorin).
        """
        expressions, unknowns = request.in_unknowns()
        slopes = Blocks(expressions.values(), unknowns).slopes
        floats = [z.astype(float) for z in multipliers]
        lower = [np.tril_indices(len(z)) for z in multipliers]
        changes = [
            [(z @ slope @ z)[rows] for slope in g]
            for g, z, rows in zip(slopes, floats, lower)
        ]
        with ctx.workprec(BALL_BITS):
            balls, unknowns = request.in_unknowns(_plain, (self._vertex(),))
            balls = list(balls.values())
            changes = _arb_mat(np.hstack(changes)).transpose()  # a column a variable
            seen = [
                slopes_at(g, unknowns, list(zip(*rows)))
                for g, rows in zip(balls, lower)
            ]
            M = _arb_mat(np.vstack(seen)).transpose() * changes
            off = adjoint(balls, unknowns, [np.array(z) for z in multipliers])
            try:
                c = M.solve(_arb_mat(-off[:, None]))
            except ZeroDivisionError:
                return False
            entries = iter((changes * c).entries())
            for z, rows in zip(multipliers, lower):
                change = np.empty(z.shape, object)
                for i, j in zip(*rows):
                    change[i, j] = change[j, i] = next(entries)
                if not positive(z - np.diag(_row_bounds(change))):
                    return False
        return True

    def _vertex(self):
        empty = np.zeros((len(self.Lam), 0))
        return Descriptor(np.eye(len(self.Lam)), self.Lam, self.B, empty, empty.T)


def slow_modes(vertex, rate):
    """The modes of a plant, ``vertex``, that are slower than a ``rate`` in 1/s.

    Yields the integrators with each slow mode, the slowest first, and then with all of
    them. Nothing where eigenvalues can't be isolated.
    """
    A, B, roots = _enclosed(vertex)
    with ctx.workprec(BALL_BITS):
        roots.sort(key=lambda s: -float(s.real.mid()))
        idle = [s for s in roots if s.contains(0)]
        slow = [s for s in roots if s not in idle and s.real > -exact(rate)]
    chosen = [[s] for s in slow]
    if len(slow) > 1:
        chosen.append(slow)
    for some in chosen:
        with ctx.workprec(BALL_BITS):
            modes = _of(A, B, [*some, *idle])
        if modes is not None:
            yield modes


def modes_near(vertex, eigenvalues, pivots):
    """The `Modes` of a ``vertex`` nearest to ``eigenvalues``, of these ``pivots``.

    Raises ValueError if two are nearest to the same one, or one can't be enclosed.
    """
    A, B, roots = _enclosed(vertex)
    mids = np.array([complex(s.mid()) for s in roots])
    nearest = [int(np.argmin(abs(mids - s))) if len(mids) else -1 for s in eigenvalues]
    if len(set(nearest)) < len(nearest) or -1 in nearest:
        raise ValueError("the modes aren't those of the plant")
    with ctx.workprec(BALL_BITS):
        modes = _of(A, B, [roots[k] for k in nearest], pivots)
    if modes is None:
        raise ValueError("the modes can't be enclosed")
    return modes


def _enclosed(vertex):
    """A and B of x' = A x + B u, and balls of eigenvalues with Im s >= 0.

    None of these where they can't be isolated.
    """
    E, A, B = (exact(x) for x in (vertex.E, vertex.A, vertex.Bu))
    back = inverse(E)
    A, B = back @ A, back @ B
    with ctx.workprec(BALL_BITS):
        try:
            roots = acb_mat(_arb_mat(A)).eig()
        except ValueError:  # a multiple eigenvalue
            roots = []
        return A, B, [s for s in roots if s.imag > 0 or s.imag.contains(0)]


def _of(A, B, roots, pivots=None):
    """The `Modes` of these eigenvalues, or None; for given pivots if any."""
    parts, columns, ones = [], [], []
    for j, s in enumerate(roots):
        w, one = _left_vector(A, s, None if pivots is None else pivots[j])
        if w is None:
            return None
        ones.append(one)
        a, b = s.real, s.imag
        if b.contains(0):  # simple, so it is real
            parts.append([[a]])
            columns.append([e.real for e in w])
        else:
            parts.append([[a, -b], [b, a]])
            columns += [[e.real for e in w], [e.imag for e in w]]
    size = len(columns)
    Lam, start = np.full((size, size), arb(0), object), 0
    for p in parts:
        end = start + len(p)
        Lam[start:end, start:end] = p
        start = end
    W = np.array(columns, object)
    return Modes(tuple(map(_in_floats, roots)), tuple(ones), Lam, W @ np.array(B))


def _in_floats(s):
    """A ball as a float, or a complex one; 0 where it may be 0."""
    if s.contains(0):
        return 0.0
    return float(s.real.mid()) if s.imag.contains(0) else complex(s)


def _left_vector(A, s, k=None):
    """Balls of w with w' A = s w' and w_k = 1, and k, of the largest without it.

    Without balls w is None.
    """
    floats, near = A.astype(float), complex(s)
    left = np.linalg.svd(floats.T - near * np.eye(len(A)))[2][-1].conj()
    right = np.linalg.svd(floats - near * np.eye(len(A)))[2][-1].conj()
    r = abs(right).argmax()
    k = int(abs(left).argmax()) if k is None else range(len(A))[k]
    rows = [i for i in range(len(A)) if i != r]
    cols = [j for j in range(len(A)) if j != k]
    shifted = np.array([[acb(e) for e in row] for row in A.T], object)
    for i in range(len(A)):
        shifted[i, i] = shifted[i, i] - s
    part = shifted[np.ix_(rows, cols)]
    try:
        w = acb_mat(part.tolist()).solve(acb_mat((-shifted[rows, k])[:, None].tolist()))
    except ZeroDivisionError:
        return None, k
    vector = np.full(len(A), acb(1), object)
    vector[cols] = w.entries()
    return vector, k


def _plain(x):
    """Rationals of floats in a plain array, which may meet balls."""
    return x if x.dtype == object else np.array(exact(x))


def _row_bounds(change):
    """Rationals above the sums of |change| along each row."""
    sums = [sum((abs(e) for e in row), arb(0)).upper() for row in change]
    return np.array([exact(float(f"{1.01 * float(s) + 1e-300:.2e}")) for s in sums])


def _middle(x):
    return np.array([[float(e.mid()) for e in row] for row in x])


def _arb_mat(x):
    return arb_mat([[arb(e) for e in row] for row in x])


BALLS = (
    "rationals alone can't redo this proof: it encloses eigenvalues in balls; "
    "python -m sosbook verify does"
)


class ModesRefusal(MultiplierRefusal):
    """An enclosure: multipliers exclude a design for some modes of a plant alone.

    Its ``text`` is a file with the plant, the modes in floats and multipliers for
    these. The modes themselves are irrational: `verify` encloses them in balls and
    mends the multipliers, see `Modes.refused`.
    """

    kind = "infeasible delay modes"

    @property
    def modes(self):
        """The `Modes` that the proof is about, enclosed again."""
        return _modes(self.data)

    @property
    def part(self):
        """Which part of the plant the multipliers are about, in words."""
        return f"the modes {self.modes} alone"

    @classmethod
    def rebuilt(cls, data):
        small, modes = _small(data), _modes(data)
        again = cls.contents(
            read_delay_request(data, framed=False), data["vertex"], modes, small
        )
        expressions, unknowns = small.in_unknowns(exact)
        return again, expressions, unknowns, str

    @classmethod
    def examine(cls, data):
        again, examined = super().examine(data)
        if examined.proven:
            small, modes = _small(data), _modes(data)
            names = list(map(str, small.in_unknowns()[0]))
            Z = {name: read_fractions(rows) for name, rows in again["multipliers"]}
            if Z.keys() != set(names):
                return again, Examined.nothing("a block has no multiplier")
            if not modes.refused(small, [Z[name] for name in names]):
                return again, Examined.nothing("the modes leave the unknowns a way out")
        return again, examined

    @classmethod
    def contents(cls, request, vertex, modes, small):
        """The data of a ``request``'s file for ``modes`` of a ``vertex``.

        It counts from 0; ``small`` is the same request for floats near the modes alone.
        """
        (d,) = small.vertices
        asked = {**problem_data(request), "K": None}
        _, said = text_of({"kind": "infeasible delay", **asked, "multipliers": []})
        return {
            "claims": list(said),
            **asked,
            "vertex": vertex,
            "modes": [
                [decimal(complex(s).real), decimal(complex(s).imag), k]
                for s, k in zip(modes.eigenvalues, modes.pivots)
            ],
            "near": {"A": decimals(d.A), "B": decimals(d.Bu)},
            "coordinates": frame_data(small.frame),
            "note": BALLS,
        }


def _modes(data):
    """The modes of a file, enclosed again."""
    request, places = read_delay_request(data, framed=False), data["modes"]
    vertex = request.vertices[range(len(request.vertices))[data["vertex"]]]
    values = [complex(read_number(re), read_number(im)) for re, im, _ in places]
    pivots = [k for *_, k in places]
    if any(type(k) is not int or k < 0 for k in [*pivots, data["vertex"]]):
        raise ValueError("vertex and pivots must be integers, 0 or more")
    return modes_near(vertex, values, pivots)


def _small(data):
    """The request of a file for the modes alone, at the floats."""
    size = len(data["near"]["A"])
    A = read_array(data["near"]["A"], size, size)
    B = read_array(data["near"]["B"], size, None)
    request = read_delay_request(data, framed=False)
    small = request.at(plant=DescriptorSystem(np.eye(size), A, B), U=None)
    return in_frame(small, read_frame(data["coordinates"], size))
