"""The steps and loads that are shown of a controller: how large they are, and why."""

from dataclasses import dataclass
from decimal import ROUND_FLOOR

import numpy as np
from flint import arb

from ..plants.checks import positive
from .bounded import Bounded
from .bounds import four_digits, rest, rounded, settled

FAR = 10.0  # times its step: beyond that a motion is cut, and no overshoot is said
SHARE = 0.1  # of the limit, that a load asks


@dataclass(frozen=True)
class Trial:
    """A step of a set point that is shown, or a load: its ``size`` in the unit of that,
    ``why`` it has it, and what it ``asks`` each output, a tuple of `Bounded`.
    """

    size: float
    why: str
    asks: tuple = ()


def steps_of(c, step=None):
    """A `Trial` for each set point of a controller c, of its own size or of ``step``:
    a number, or one for each.
    """
    p = len(c.set_points)
    if step is None:
        return tuple(_own_step(c, j) for j in range(p))
    sizes = np.atleast_1d(np.asarray(step, float))
    if sizes.shape not in ((1,), (p,)):
        raise ValueError(
            f"step needs a number or one for each of {p} set points, got {step!r}"
        )
    sizes = [positive("step", x) for x in np.broadcast_to(sizes, (p,)).tolist()]
    return tuple(Trial(x, "as asked", _asked(c, j, x)) for j, x in enumerate(sizes))


def _asked(c, j, size):
    """The largest size of each output after a step of set point j, from rest; () where
    no bound of it is known, or none of a ramp that is asked for.
    """
    if np.isfinite(c.limits.ramp[j]) and rest(c, j) is None:
        return ()
    try:
        return tuple(c.bounds.step(size, j, k) for k in range(len(c.outputs)))
    except ValueError:  # where the step ends is another place for each plant
        return ()


def _own_step(c, j):
    """The `Trial` of set point j whose size is the machine's own."""
    one, limited = _asked(c, j, 1.0), np.isfinite(c.limits.u_max)
    if not limited.any():
        return Trial(1.0, "no output has a limit", one)
    pairs = [(c.limits.u_max[k], k) for k in np.flatnonzero(limited).tolist()]
    size, why = np.inf, ""
    proven = bool(one) and all(one[k].proven is not None for _, k in pairs)
    read = [
        c.bounds.noise(output=k).proven if c.readings.steps.any() else 0
        for _, k in pairs * proven
    ]
    if proven and None not in read:
        found = [
            rounded((arb(u) - arb(noise)) / arb(one[k].proven), 0)
            for noise, (u, k) in zip(read, pairs)
            if one[k].proven > 0
        ]
        size = min(found, default=np.inf)
        why = "the largest that is proven to stay within the limit"
    elif one and limited.all() and (reach := c.bounds.reach(j).step) is not None:
        size, why = reach, "the largest that is proven to settle with the limit"
    if not 0 < size < np.inf:
        size = _largest(c, lambda loop: (loop.set_point[:, [j]], loop.direct_r[:, [j]]))
        why = "the largest that stays within the limit at the corners, in floats"
    if not 0 < size < np.inf:
        return Trial(1.0, "no step is known that stays within the limit", one)
    size = float(four_digits(size, ROUND_FLOOR))
    return Trial(size, why, tuple(_times(size, bound) for bound in one))


def _times(size, bound):
    """The `Bounded` of a step of a ``size``, from the ``bound`` of a step of 1."""
    most = bound.proven
    if most is not None:
        most = rounded(arb(size) * arb(most), np.inf)
    return Bounded(most, size * bound.seen, bound.unit, bound.stopped)


def _largest(c, of):
    """The largest step of an input that asks no more than the limits of a controller c
    at the corners; ``of``: from a loop to how the input acts on state and output.
    """
    most = 0.0
    for loop in c.loops:
        if loop.radius >= 1:
            return 0.0
        read = abs(loop.impulses(loop.noise, loop.direct, settled(loop))).sum(axis=0)
        room = (
            c.limits.u_max - read @ c.readings.steps / 2
        )  # what the sensors' steps leave
        u = np.cumsum(loop.impulses(*of(loop), settled(loop)), axis=0)
        most = max(most, (abs(u[:, :, 0]).max(axis=0) / room).max())
    return 1 / most if most else np.inf


def loads_of(c):
    """A `Trial` for each disturbance of a controller c: of a part of its limit."""
    trials, limited = [], np.isfinite(c.limits.u_max).any()
    for j in range(c.vertices[0].Bw.shape[1]):
        size = SHARE * _largest(
            c, lambda loop, j=j: (loop.load[:, [j]], loop.direct_w[:, [j]])
        )
        if limited and 0 < size < np.inf:
            why = f"it asks {100 * SHARE:g} % of the limit at the corners"
            trials.append(Trial(float(f"{size:.2g}"), why))
        else:
            why = "no output has a limit" if not limited else "its limit says no size"
            trials.append(Trial(1.0, why))
    return tuple(trials)


def kept(c, run, j=None, size=1.0):
    """How many ticks of each plant of a ``run`` of a controller c are shown: up to its
    fault, or until what follows set point j is ``FAR`` times its step's ``size`` away.
    """
    bad = run.fault > 0
    k = None if j is None else c.followed[j]
    if k is not None:
        bad = bad | (abs(run.x @ c.readings.rows[k]) > FAR * size)
    return np.where(bad.any(axis=1), bad.argmax(axis=1) + 1, bad.shape[1])
