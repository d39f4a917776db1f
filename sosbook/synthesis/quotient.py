"""A trial of an author's word: that blocks are affine in E^-1 [A B_u B_w]."""

import numpy as np

from ..exact.definite import exact
from ..plants.controllability import matrix_of
from ..plants.coupled import Coupled
from ..plants.descriptor import Descriptor
from ..requirements.posed import PosedLoop
from ..runtime.time_limit import check_time

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
