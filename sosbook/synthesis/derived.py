"""Consequences of a request: its claims, its unknowns, and the sizes of P.

A requirement whose blocks aren't homogeneous fixes the size of its P. Where several do,
each has a P of its own: a multiple of the unknown P, which is that of the leader.
Theorem 2.1's mu is such a multiple.
"""

import re
from dataclasses import replace
from functools import cached_property

import numpy as np

from ..exact.definite import exact
from ..language import Unknown
from ..lmi.text import floats
from ..plants.coupled import Coupled
from ..plants.coupling import OneP
from ..plants.descriptor import Descriptor, twins
from ..plants.kinds import every_plant
from ..plants.near_box import NearBox
from ..requirements.posed import PosedLoop
from ..requirements.stability import Stability
from ..runtime.names import sane_name
from ..runtime.time_limit import check_time, check_time_of_eigenvalues
from .payments import pays

POINTS = 3  # where it is tried
UNREADABLE = (TypeError, AttributeError, ValueError, LookupError, ArithmeticError)


def affine_in_quotient(r, request):
    """True if the blocks of ``r`` look as it says, at random points with the sizes of a
    ``request``, in rationals, with a fixed seed.

    Let q = E^-1 [A B_u B_w]. At E = I the block of the mean of two q must be the mean
    of their blocks, entry by entry. With another E the blocks G(E, q) must be T G(I, q)
    T' with one regular T for all q, P, Y and own unknowns: then det sum_k c_k G(E, q_k)
    over det sum_k c_k G(I, q_k) is the same number for all sums, and that is tried.
    What isn't so passes by an unlikely coincidence alone.
    """
    try:
        return _affine(r, request, np.random.default_rng(20260))
    except UNREADABLE:  # then its blocks can't be read in a proof, either
        return False


def _affine(r, request, rng):
    """True if the blocks of r pass the test with these numbers."""
    d = request.vertices[0]
    N, shapes = len(d.E), [x.shape for x in (d.A, d.Bu, d.Bw)]
    C, Du = exact(d.C), None if d.Du is None else exact(d.Du)
    one = exact(np.eye(N))
    E = exact(np.eye(N) * 20) + _some(rng, N, N)  # dominated by its diagonal: regular

    def point():
        P, Y = _some(rng, N, N), _some(rng, request.plant.m, N)
        own = {u.name: _some(rng, *u.shape) for u in r.unknowns(request)}
        symmetric = {u.name for u in r.unknowns(request) if u.symmetric}
        own = {k: x + x.T if k in symmetric else x for k, x in own.items()}
        return P + P.T, Y, own

    def blocks(E, q, point):
        check_time()
        P, Y, own = point
        levels = {} if r.parameter is None else {r.parameter.key: LEVEL}
        loop = PosedLoop(request, exact, None, P, Y, None, levels, own)
        plant = Descriptor(E, *(E @ x for x in q), C, Du)
        return dict(r.pair(loop, Coupled(plant, plant, P, Y)))

    known = []
    for _ in range(POINTS):
        here = point()
        q, other = ([_some(rng, *shape) for shape in shapes] for _ in range(2))
        mean = [(a + b) / 2 for a, b in zip(q, other)]
        plain, second, middle = (blocks(one, x, here) for x in (q, other, mean))
        for name, g in plain.items():
            if (2 * middle[name] != g + second[name]).any():
                return False
        known.append((plain, blocks(E, q, here)))
    weights = [*np.eye(POINTS, dtype=int), *rng.integers(1, 9, (2 * POINTS, POINTS))]
    return all(_congruent(known, name, weights) for name in known[0][0])


def _congruent(known, name, weights):
    """True if determinants of sums of two families of blocks have one quotient."""
    from ..plants.controllability import matrix_of

    quotients = set()
    for c in weights:
        at_one, at_E = (
            matrix_of(sum(int(w) * pair[k][name] for w, pair in zip(c, known))).det()
            for k in (0, 1)
        )
        if at_one == 0 or at_E == 0:
            return False
        quotients.add(at_E / at_one)
    return len(quotients) == 1


LEVEL = exact(7.0)  # in the place of a bound that is sought


def _some(rng, *shape):
    """A matrix of small whole numbers."""
    return exact(rng.integers(-9, 10, shape).astype(float))


RESERVED = re.compile(r"P|P \d+|V|Y|size for .*")  # names of a request's unknowns


class Derived:
    """The consequences of a `Request`'s fields."""

    # its claims, and which pairs they need

    @property
    def covers_polytope(self):
        """True if the blocks say something about the whole polytope."""
        return self.coupling.between or len(self.pairs) == len(self._pairs_of(OneP()))

    @property
    def at_corners(self):
        """True if the vertices are the corners of ranges, and nothing else is meant."""
        return self.plant.family is not None and self.plant.family.multi_affine

    def _pairs_of(self, coupling):
        authors = [r for r in self.requirements if not r.of_package]
        quotient = all(r.affine_in_quotient for r in self.requirements)
        pairs = coupling.pairs(self.certain, quotient, self.at_corners)
        if quotient and authors:  # what is left out must be more than their word
            every = coupling.pairs(self.certain, False)
            if every != pairs and not all(affine_in_quotient(r, self) for r in authors):
                return every
        return pairs

    def statements(self):
        """The statements that the blocks prove: (words, requirement) each, the
        requirement that demands the blocks which prove it. It is the one place where
        claims are made: `demands` and the proofs' claims come from here. What exactly
        repeats an earlier requirement rests on that one's blocks; that an author's
        class implies stability is no proof of it.
        """
        N = len(self.vertices)
        where = every_plant(self.plant, self.coupling.scope)
        if N > 1 and not self.covers_polytope:
            where = f"each of the {N} vertices (not the plants between)"
        under = ", under u = K x," if self.plant.m else ""
        if self.law is not None:
            under = f", under u = K y ({self.law.words(self.plant)}),"
        owners = self._owners()
        said = [f"{where}{under} is stable", *(r.statement for r in self.requirements)]
        return list(zip(said, owners, strict=True))

    def _owners(self):
        """The requirements whose blocks prove stability and what is required."""
        implying = (r for r in self.requirements if r.implies_stability)
        owners = [next((r for r in implying if r.of_package), Stability())]
        for r in self.requirements:
            owned = (o for o in owners[1:] if r.of_package and r.repeats(o))
            owners.append(next(owned, r))
        return owners

    @cached_property
    def demands(self):
        """The requirements in the order of their blocks, those with unknowns of their
        own first; stability joins.
        """
        stable, *others = self._owners()
        asked = {r.key: r for r in others}
        if stable.key not in asked:
            asked = {stable.key: stable} | asked
        return tuple(sorted(asked.values(), key=lambda r: not r.unknowns(self)))

    @property
    def of_poles(self):
        """The `demands` that are regions of the poles."""
        return [r for r in self.demands if r.pole_matrices() is not None]

    def kept_by(self, K, some):
        """True if the loops of the vertices keep ``some`` demands under ``K``."""
        loops = self.vertices
        return all(r.kept(r.truth(loops, K, self.K_A)) > 0 for r in some)

    # where its blocks are written

    def _near_box(self):
        """The box near the vertices at whose corners the blocks are written, where
        these speak for the plants between and the vertices don't; or None.
        """
        common = self.coupling.one_P and self.law is None
        if not (common and all(map(pays, self.requirements))):
            return None
        near = NearBox.of(self.plant)
        return near and near.ground(self.vertices, self.described) and near

    @property
    def ground(self):
        """The vertices of the blocks: the plant's, or the corners near them."""
        if self.near is None:
            return self.vertices
        return self.near.ground(self.vertices, self.described)[0]

    @cached_property
    def certain(self):
        """The `ground`, such as E = diag(I, M - B K_A, I), free of rounding errors:
        whether two of them are equal, floats can't tell.
        """
        rounded = any(d.rounded for d in self.ground)
        return [d.map(exact) for d in self.ground] if rounded else self.ground

    # its unknowns by name

    def unknowns(self, levels=()):
        """Unknowns P, Y (P alone if the gain is given), sizes, the own ones, which a
        requirement's size multiplies; with a slack matrix P 1, P 2, ..., V, Y and so
        on. ``levels`` are as in `leader`.
        """
        unknowns = self.coupling.unknowns(twins(self.certain), self.order)
        if self.gain is None:
            unknowns.append(Unknown("Y", self.plant.m, self.order))
        for r in self.followers(self.leader(levels)):
            unknowns.append(Unknown(r.size_name, 1))
        unknowns.extend(u for _, u in self.owned)
        names = [u.name for u in unknowns]
        if len(set(names)) < len(names):
            raise ValueError(f"two unknowns have one name: {names}")
        return unknowns

    @property
    def owned(self):
        """(r, u) of each own unknown u of a requirement r, as `demands` has them."""
        return [(r, u) for r in self.demands for u in r.unknowns(self)]

    def _check_unknowns(self):
        """A ValueError where a requirement's own unknown has a name that is taken."""
        for r in self.requirements:
            for name in (sane_name(u.name) for u in r.unknowns(self)):
                if RESERVED.fullmatch(name):
                    raise ValueError(
                        f"{r.words}: an unknown of its own is called {name!r}, which "
                        "is one of every problem: give it another name"
                    )

    @cached_property
    def lyapunov(self):
        """Names of the unknown Lyapunov matrices; equal vertices share one."""
        return self.coupling.lyapunov(twins(self.certain))

    def in_unknowns(self, frame, number=floats, levels=(), sizes=(), pairs=None):
        """`blocks` by name in the `unknowns`, which come, too. ``frame``, ``number``,
        ``levels`` and ``pairs`` are as there; ``sizes`` has numbers for some of the
        unknown sizes.
        """
        unknowns = self.unknowns(levels)
        unknowns = [u for u in unknowns if u.name not in sizes]
        values = {u.name: u for u in unknowns} | dict(sizes)
        return self.blocks_at(values, number, frame, levels, pairs), unknowns

    def blocks_at(self, values, number=floats, frame=None, levels=(), pairs=None):
        """`blocks` for ``values`` of the `unknowns` by name; ``number``, ``frame``,
        ``levels`` and ``pairs`` are as there.
        """
        P, Y, V, own = self.taken_apart(values, number, frame)
        return self.blocks(P, Y, number, frame, V, levels, own, pairs)

    def taken_apart(self, values, number=floats, frame=None):
        """P, Y, V and own of ``values`` by name, as `blocks` takes them with ``number``
        and ``frame``.
        """
        names = self.lyapunov
        P, of_K = [values[name] for name in names], self.coupling.divisor(values)
        values = {name: x for name, x in values.items() if name not in names}
        for name, unit in () if frame is None else frame.own.items():
            if name in values:
                values[name] = values[name] * number(np.array(unit)).item()
        V = values.pop("V", None)
        if self.gain is None:
            Y = values.pop("Y")
        else:
            K = number(self.gain)
            if frame is not None:
                scale = number(np.array(frame.scale)).item()
                K = K @ number(frame.T) / scale
            Y = K @ of_K.T
        return self.coupling.given(P), Y, V, values

    # the sizes of P, and the loop's rate

    @cached_property
    def typical_rate(self):
        """A typical angular frequency of the closed loop, in rad/s."""
        rates = filter(None, (r.rate() for r in self.requirements))
        rank, rate = min(rates, default=(2, 1.0))
        if rank < 2:
            return rate
        A, _, _ = self.mean.state_space()
        check_time_of_eigenvalues(len(A))
        return np.abs(np.linalg.eigvals(A)).max() or rate

    @cached_property
    def sized(self):
        """The requirements that fix the size of P, lowest rank first: their blocks
        aren't zero where P, Y and their own unknowns are.
        """
        if self.coupling.free:  # each requirement has a P of its own
            return ()
        if self.coupling.open:
            return self.with_slack(1.0).sized
        V = np.zeros((self.order, self.order))
        Y = np.zeros((self.plant.m, self.order))
        P = self.coupling.given([V] * len(self.lyapunov))
        own = {u.name: np.zeros(u.shape) for _, u in self.owned}
        loop = PosedLoop(self, floats, None, P, Y, V, (), own)
        first = self.coupling.coupled(loop, *self.pairs[0])

        def constants(r):
            yield from (g for _, _, g in r.once(loop))
            yield from (g for _, g in self.coupling.asked(r, loop, first, 0))

        sized = [r for r in self.requirements if any(g.any() for g in constants(r))]
        return tuple(sorted(sized, key=lambda r: (r.rank, r.key)))

    @property
    def ties(self):
        """The ties between the sizes of P, in words: ("mu = 1",) or nothing."""
        ties = tuple(r.tied for r in self.requirements if r.tied)
        return ties if len(self.sized) > 1 else ()

    @property
    def condition(self):
        """The condition of a refusal, also a slack: "for mu = 1"; else empty."""
        ties = self.ties + self.coupling.condition
        return f"for {' and '.join(ties)}" if ties else ""

    def subject(self, text):
        """A ``text`` with the `condition` at its end."""
        return " ".join(filter(None, (text, self.condition)))

    def untied(self):
        """The request in which each requirement's P has its own size."""
        return replace(self, requirements=tuple(r.untied() for r in self.requirements))

    def leader(self, levels=()):
        """The requirement whose P is the unknown P; None if none fixes its size. A
        level times an unknown size isn't affine, so with unknown ``levels``, by the
        parameters' names, the first one's owner leads.
        """
        order = {name: place for place, name in enumerate(levels)}
        return min(
            self.sized,
            key=lambda r: order.get(r.parameter and r.parameter.key, len(order)),
            default=None,
        )

    def followers(self, leader):
        """The requirements whose P is the leader's times an unknown size."""
        if self.ties:
            return ()
        return tuple(r for r in self.sized if r is not leader)
