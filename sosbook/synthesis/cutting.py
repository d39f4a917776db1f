"""Cutting planes: of the blocks of many pairs of vertices a few decide."""

from collections import defaultdict
from functools import cached_property

import numpy as np

from ..language import Affine
from ..lmi.solution import LMISolution
from ..runtime.time_limit import check_time
from ..solver.blocks import Blocks
from ..solver.bounded import any_centre, unpacked
from ..solver.loop import margin, phase_one
from .pair_stacks import pair_margins

# pairs of vertices
CUTTING_PLANE_ABOVE_PAIRS = 24  # from here on it is faster than all blocks at once
CENTRE_UP_TO_PAIRS = 1000  # up to here the centre is that of all blocks
PAIRS_PER_CUT = 4  # how many join at a time
TIE = 1e-6  # relative; pairs whose margins differ by less join together
NEAR_CENTRE = 2.0  # a decrement after which few pairs' centre is near enough
MOST_DIRECTIONS = 16  # in which vertices are told apart
CLEARANCE = 0.1  # of the least margin of what is chosen; a pair that has less joins


class Cuts:
    """The LMIs of many pairs of vertices, ``lmis``, of which a few are solved at a
    time; all are looked at in floats, many in one numpy call.
    """

    def __init__(self, lmis):
        self.lmis, self.chosen = lmis, {}
        self._written = {(): self._write(())}

    def _write(self, pairs):
        """Expressions and structures of the blocks that some pairs bring along."""
        unknowns = self.lmis.unknowns
        named = self.lmis.written_for(pairs, {u.name: u for u in unknowns})
        named = {_key(n): g for n, g in named.items()}
        if pairs:
            named = {k: g for k, g in named.items() if k not in self._written[()]}
        blocks = Blocks(
            [g if isinstance(g, Affine) else Affine(g) for g in named.values()],
            unknowns,
        )
        return dict(zip(named, zip(blocks.expressions, blocks.structure[2])))

    def some(self):
        """The `Blocks` of the pairs that are chosen so far."""
        fresh = [pair for pair in self.chosen if pair not in self._written]
        for key, block in self._write(fresh).items() if fresh else ():
            pair = key[2] if len(key[2]) == 2 else key[2] * 2
            self._written.setdefault(pair, {})[key] = block
        parts = [p for pair in [(), *self.chosen] for p in self._written[pair].items()]
        self.keys = [key for key, _ in parts]
        return Blocks.compiled(*zip(*(b for _, b in parts)), self.lmis.unknowns)

    def margins(self, x, below=np.inf):
        """The least margin of each pair at ``x``; above ``below`` perhaps infinite."""
        request, values = self.lmis.request, unpacked(self.lmis.unknowns, x)
        if request.coupling.own_P:
            least = defaultdict(lambda: np.inf)
            for name, g in self.lmis.text.blocks(values).items():
                if _key(name) not in self._written[()]:
                    i = name.vertices[0]
                    least[i] = min(least[i], margin(g))
            return np.array([least[i] for i, _ in request.pairs])
        (P, Y, _, own), levels = self.lmis.taken_apart(values)
        found = pair_margins(request, P, Y, self.lmis.frame, levels, own, below)
        return np.min(list(found.values()), axis=0)

    def holds(self, x):
        """True if all blocks are positive definite at x."""
        self.chosen = {}
        once = not self._written[()] or self.some().newton.least(x).min() > 0
        return once and bool(self.margins(x, 0.0).min() > 0)

    def join(self, margins, below, count=PAIRS_PER_CUT, ties=False, apart=False):
        """Choose ``count`` of the pairs whose ``margins``, (pairs,), are the least and
        not above ``below``; with ``ties`` all that have the margin of the last one,
        too, with ``apart`` rather one of those that are alike, for the others will hold
        with it. Returns whether there was one more.
        """
        pairs = self.lmis.request.pairs
        fresh = [
            k for k in np.flatnonzero(margins <= below) if pairs[k] not in self.chosen
        ]
        if not fresh:
            return False
        if apart:
            fresh = self._apart(np.array(fresh), below - margins[fresh], count)
        else:
            fresh.sort(key=lambda k: margins[k])
        if ties:
            edge = margins[fresh[:count][-1]]
            edge += TIE * abs(edge)
            count = sum(margins[k] <= edge for k in fresh)
        self.chosen |= {pairs[k]: None for k in fresh[:count]}
        return True

    def _apart(self, fresh, depths, count):
        """The deepest ``fresh`` pairs, by ``depths`` and distance to those chosen."""
        places, found = self.places, []
        squared, free = np.ones(len(fresh)), np.ones(len(fresh), bool)
        known = np.array([pair in self.chosen for pair in self.lmis.request.pairs])
        for k in np.flatnonzero(known):
            near = ((places[fresh] - places[k]) ** 2).sum(axis=1)
            squared = np.minimum(squared, near)
        for _ in range(min(count, len(fresh))):
            worst = np.argmax(np.where(free, depths * squared, -np.inf))
            near = ((places[fresh] - places[fresh[worst]]) ** 2).sum(axis=1)
            squared = np.minimum(squared, near)
            free[worst] = False
            found.append(int(fresh[worst]))
        return found

    @cached_property
    def places(self):
        """Where the pairs lie among all, (pairs, k), without units."""
        request, frame, parts = self.lmis.request, self.lmis.frame, []
        vertices = request.ground.at(frame)
        for name in ("E", "A", "Bu", "Bw"):
            part = np.array([getattr(d, name).ravel() for d in vertices])
            part = part - part.mean(axis=0)
            parts.append(part / (np.linalg.norm(part) or 1.0))
        U, sizes, _ = np.linalg.svd(np.hstack(parts), full_matrices=False)
        at = (U * sizes)[:, :MOST_DIRECTIONS]
        at /= np.linalg.norm(at) / np.sqrt(len(at)) or 1.0
        i, j = np.array(request.pairs).T
        return np.hstack([at[i] + at[j], at[i] * at[j]])

    def find(self, start, refuse=True):
        """A point inside all blocks, or the refusal of some pairs, as an LMISolution,
        from the unknowns ``start`` by name. The centre of a few pairs' blocks; then
        those that it violates most join them, until it violates none; ``refuse`` is as
        for `LMIProblem.find`.
        """
        lmis, inside, count = self.lmis, False, PAIRS_PER_CUT
        x = None if start is None else lmis.text.packed(start)
        margins = -np.ones(len(lmis.request.pairs))  # of no point
        if x is not None:
            margins = self.margins(x, 0.0)
        if margins.min() > 0 and not self._written[()]:  # else there is no block
            self.join(margins, np.inf)
        while self.join(margins, 0.0, count, apart=True) or not inside:
            check_time()
            count *= 2
            some = self.some()
            phase = phase_one(some, start=x, multipliers=refuse)
            if phase.x is None:
                return self._refusal(phase)
            x = any_centre(some, lmis.unknowns, phase.x, enough=NEAR_CENTRE)
            margins, inside = self.margins(x, 0.0), True
        return LMISolution(lmis, unpacked(lmis.unknowns, x))

    def _refusal(self, phase):
        problem, Z = self.lmis.of_pairs(tuple(self.chosen)), phase.Z
        if Z is not None:
            given = dict(zip(self.keys, Z))
            Z = [given[_key(name)] for name in problem.text.expressions]
        return LMISolution(
            problem,
            multipliers=Z,
            verdict=phase.verdict,
            last_iterate=unpacked(problem.unknowns, phase.last_iterate),
            excluded_radius=phase.excluded_radius,
        )

    def centre(self, x):
        """The centre, inside all blocks as x is, of the blocks that decide: those of
        the vertices, and of the pairs that come near the edge at the centre of those
        before. So it doesn't depend on ``x``, nor on the order of the vertices.
        """
        pairs, count = self.lmis.request.pairs, PAIRS_PER_CUT
        self.chosen = {(i, j): None for i, j in pairs if i == j}
        while True:
            check_time()
            some = self.some()
            newton = some.newton
            centre = any_centre(some, self.lmis.unknowns, x)
            least = min(map(margin, newton.unstacked(newton.at(centre))))
            near = CLEARANCE * max(least, 0.0)
            if not self.join(self.margins(centre, near), near, count, ties=True):
                return centre
            count *= 2

    def least(self, x, work):
        """Where ``work``, from some `Blocks` and a point ``x`` inside all to another
        point inside them, ends if it sees those blocks only that matter. It may raise a
        ValueError, and gets more blocks then.
        """
        self.chosen, count, at_x = {}, PAIRS_PER_CUT, self.margins(x)
        self.join(at_x, np.inf)
        while True:
            check_time()
            count *= 2
            try:
                outcome = work(self.some(), x)
            except ValueError:
                if not self.join(at_x, np.inf, count):
                    raise
                continue
            if not self.join(self.margins(outcome, 0.0), 0.0, count):
                return outcome


def few_decide(request):
    """True if `Cuts` find a point of a ``request`` sooner than all blocks at once; not
    with a slack matrix, for each vertex has a P of its own.
    """
    many = len(request.pairs) > CUTTING_PLANE_ABOVE_PAIRS
    return many and not request.coupling.own_P


def few_refuse(request):
    """True if `Cuts` find multipliers that exclude all points of a request sooner."""
    return len(request.pairs) > PAIRS_PER_CUT


def _key(name):
    """The key of a `BlockName`, whatever the labels are."""
    return name.requirement, name.block, name.vertices


def holds(lmis, values):
    """True if all blocks of ``lmis`` are definite at ``values`` by name."""
    x = lmis.text.packed(values)
    if len(lmis.request.pairs) > CENTRE_UP_TO_PAIRS:
        return Cuts(lmis).holds(x)
    return bool(lmis.compiled.newton.least(x).min() > 0)
