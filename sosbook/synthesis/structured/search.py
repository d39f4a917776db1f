"""A search of gains: several starts, descent, sampled gradients at the best."""

from dataclasses import dataclass

import numpy as np

from ...analysis.riccati import lyapunov, riccati
from ...runtime.time_limit import OutOfTime, check_time
from .central import RIDGE, balanced, central, late, near_least, slower
from .descent import descend, refine
from .objective import DECAY, Objective

ROOMS = 1.02, 1.1, 1.3, 2.0  # times a least norm, where gains have no bound
ROOM = 0.02  # of the rate, or of a bound: with so much room a search ends
SPREAD = 3.0  # times the fastest pole: so far the rates of the starts reach
STEPS = 120  # of a descent
NORM_STEPS = 60  # of the first descent of a norm
NORM_SHARE = 4  # of so many starts one descends in a norm, its poles in place
BEST = 3  # of these go on
TURNS = 4  # of sampled gradients and descent, for norms, at the best
WORTH = 1e-4  # of a norm, as a fraction: what such a turn has to win for another one
PACE = 3e-6  # of a norm: what a step of a turn, or some of a descent, have to win
ROUNDS = 30, 8  # of sampled gradients, for poles and for norms


@dataclass(frozen=True, eq=False)
class Found:
    """The result of a search.

    ``kappa``, (k,) or None: the free numbers; None where no loop has a value;
    ``value``: the objective's; below zero all is kept, where nothing is to be as good
    as can be. Infinite where no loop is stable, or a norm isn't finite; ``starts``: how
    many were taken; ``stopped``: whether the time was over before the search was: it is
    the best so far.
    """

    kappa: np.ndarray | None
    value: float
    starts: int
    stopped: bool = False


def search(task, loops, starts, seed, near=(), make=Objective, begin=None, turns=TURNS):
    """The best `Found` of a ``task`` for the ``loops`` of all plants that count, from
    so many ``starts`` besides those ``near``, free numbers. What is found depends on
    the ``seed`` of numpy's generator and the time alone; ``make`` and ``begin`` make
    the `Objective` and, as `starting_points`, the starts; so many ``turns`` at its end.
    """
    rng = np.random.default_rng(seed)
    bounded = bool(task.bounded) or task.goal not in (None, DECAY)
    found, tried, count = [], [], 0
    enough = -ROOM if task.goal is None else -np.inf

    def function(unit, norms):
        tried.append(make(task, loops, unit, norms))
        return tried[-1]

    try:
        begin = begin or starting_points
        for unit, x in begin(task, loops, starts, rng, near):
            count += 1
            f = function(unit, False)
            x, value, _ = descend(f, x, STEPS, -ROOM / 5 if bounded else enough)
            if np.isfinite(value):
                found.append((value, unit, x))
            inside = sum(v < 0 for v, *_ in found)
            if bounded and inside >= -(-starts // NORM_SHARE):
                break
            if not bounded and value <= enough:
                break
        if not found:
            return Found(None, np.inf, count)
        found.sort(key=lambda entry: entry[0])
        if bounded:
            found = _norms(function, found, enough) or found[:1]
        _, unit, x = found[0]
        f = function(unit, bounded)
        value = f(x)[0]
        for _ in range(turns if bounded else min(turns, 1)):
            if value <= enough or not np.isfinite(value):
                break
            before = value
            x, value = refine(f, x, value, rng, ROUNDS[bounded], PACE * bounded)
            if bounded:
                x, value, _ = descend(f, x, STEPS, enough, PACE)
            if before - value < WORTH:
                break
    except OutOfTime:
        return _so_far(function, tried, bounded, count)
    return Found(task.inside(x * unit), value, count)


def _so_far(function, tried, bounded, count):
    """The `Found` of a search that is stopped, of the functions that it has tried."""
    some = [f for f in tried if f.at is not None]
    if not some:
        return Found(None, np.inf, count, True)
    best = min(some, key=lambda f: (f.norms != bounded, f.least))
    value = best.least
    if best.norms != bounded:
        try:
            value = function(best.unit, bounded)(best.at)[0]
        except OutOfTime:  # a norm takes too long
            value = np.inf
    kappa = best.task.inside(best.at * best.unit)
    return Found(kappa, value, count, True)


def _norms(function, found, enough):
    """Points from which norms have fallen, the best first."""
    inside = [entry for entry in found if entry[0] < 0]
    ended = []
    for _, unit, x in inside:
        x, value, H = descend(function(unit, True), x, NORM_STEPS, enough, PACE)
        ended.append((value, unit, x, H))
        if value <= enough:
            break
    ended.sort(key=lambda entry: entry[0])
    for k, (value, unit, x, H) in enumerate(ended[:BEST]):
        if value > enough and H is not None:
            f = function(unit, True)
            x, value, _ = descend(f, x, STEPS, enough, PACE, H)
        ended[k] = value, unit, x
    return sorted((entry[:3] for entry in ended), key=lambda entry: entry[0])


def starting_points(task, loops, count, rng, near):
    """(unit, x) of each start for a ``task`` and its ``loops``: given ones, ``near``,
    then ``count`` projected and random ones, of ``rng``.
    """
    slow, fast = loops.rates
    rates = np.geomspace(min(slow, task.rate), SPREAD * max(fast, task.rate), 7)[1:-1]
    middle = loops.units(task.rate)
    for kappa in near:
        yield middle, kappa / middle
    guess = _projected if loops.matrices[1].shape[2] == task.m else _observer
    for r in (task.goal, *task.bounded) if guess is _observer else ():
        if r not in (None, DECAY) and r.bounds_response() is not None:
            for room in ROOMS:
                kappa = _observer(loops, task.rate, task.m, r, room)
                if kappa is None or (task.inside(kappa) == kappa).all():
                    break
            if kappa is not None:
                yield middle, kappa / middle
            break
    k = 0
    for rate in (task.rate, *rates):
        check_time()
        kappa = guess(loops, rate, task.m)
        if kappa is not None and k < count:
            k, unit = k + 1, loops.units(rate)
            yield unit, task.inside(kappa) / unit
    while k < count:
        unit = loops.units(rates[k % len(rates)])
        x = rng.normal(size=len(unit)) * 10 ** rng.uniform(-2.5, 0.5)
        k += 1
        yield unit, task.inside(x, unit)


def _observer(loops, rate, m, r=None, room=None):
    """The free numbers of a state feedback with an observer of the mean plant; or None.
    ``room`` times the least norm that a requirement ``r`` bounds, or, without one, of
    LQR, as in `_projected`. For a norm a controller of less than the plant's order has
    a part of it; otherwise there is none. States to spare decay by themselves.
    """
    A, B, *_ = (x.mean(axis=0) for x in loops.matrices)
    c = B.shape[1] - m
    N, q = len(A) - c, len(loops.measured) - c
    few = min(c, N)
    if few < N and r is None:
        return None
    rate = loops.beside_poles(rate)
    of_u, of_y = loops.sizes(rate)
    A, B, C = A[:N, :N], B[:N, :m], loops.measured[:q, :N]
    A, B, C, of_x = _scaled(A, B * of_u[:m], C / of_y[:q, None], rate)
    try:
        if r is None:
            none = np.zeros((q, m))
            F, L, inner = central(A, B, C, B, C, none, none, 1.0)
        else:
            W, Z, D, through = (x.mean(axis=0) for x in loops.channel(r, m)[:4])
            W, Z = W[:N] / of_x[:, None] / rate, Z[:, :N] * of_x
            D, V = D[:, :m] * of_u[:m], loops.channel(r, m)[4][:q] / of_y[:q, None]
            if through.any():
                A, B, C, W, Z = late(A, B, C, W, Z, through)
            w, z = (np.linalg.norm(x, 2) or 1.0 for x in (W, Z))
            F, L, inner = near_least(room, A, B, C, W / w, Z / z, D / z, V / w)
        T = balanced(inner, L, F)
    except (np.linalg.LinAlgError, ValueError):
        return None
    inner, L = np.linalg.solve(T, inner @ T)[:few, :few], np.linalg.solve(T, L)[:few]
    K, own = np.zeros((m + c, q + c)), of_y[q : q + few]  # units of its states
    K[:m, q : q + few] = of_u[:m, None] * (F @ T)[:, :few] / own
    K[m : m + few, :q] = -rate * own[:, None] * L / of_y[:q]
    K[m : m + few, q : q + few] = rate * own[:, None] * inner / own
    K[m + few :, q + few :] = -rate * np.eye(c - few)
    units = loops.units(rate)
    M = np.array([(k * u).ravel() for k, u in zip(loops.directions, units)]).T
    return np.linalg.lstsq(M, (K - loops.first).ravel(), rcond=None)[0] * units


def _scaled(A, B, C, rate):
    """A, B and C in units of the state and of time, and the state's units: covariant,
    for a state is as large as inputs of size one make it at the rate.
    """
    of_x = np.linalg.norm(np.linalg.solve(rate * np.eye(len(A)) - A, B), axis=1)
    of_x[of_x == 0] = 1.0
    turned = A * of_x / of_x[:, None] / rate
    return turned, B / of_x[:, None] / rate, C * of_x, of_x


def _projected(loops, rate, m):
    """The free numbers nearest to a state feedback of the mean plant; or None. The
    feedback is LQR's for signals of the sizes that they have at the rate, shifted so
    that it needn't stabilise what it can't; near is what weighs least in its loop.
    """
    A, B, *_ = (x.mean(axis=0) for x in loops.matrices)
    rate = loops.beside_poles(rate)
    of_u, of_y = loops.sizes(rate)
    A, B, C, of_x = _scaled(A, B * of_u, loops.measured / of_y[:, None], rate)
    one = np.eye(len(A))
    try:
        X = riccati(slower(A), B, C.T @ C + RIDGE * one, np.eye(m))
        K = -B.T @ X
        spread = lyapunov(slower(A) + B @ K, -B @ B.T)
        root = np.linalg.cholesky(spread + RIDGE * np.trace(spread) * one)
    except (np.linalg.LinAlgError, ValueError):
        return None
    seen = loops.measured * of_x @ root
    M = np.array([(k / of_u[:, None] @ seen).ravel() for k in loops.directions]).T
    size = np.linalg.norm(M, axis=0)
    if not np.isfinite(M).all() or not size.all():
        return None
    free = K @ root - loops.first / of_u[:, None] @ seen
    kappa = np.linalg.lstsq(M / size, free.ravel(), rcond=RIDGE)[0] / size
    return kappa if np.isfinite(kappa).all() else None
