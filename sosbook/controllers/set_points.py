"""Set points of a controller: what they are called, and what they ask."""

from dataclasses import replace

import numpy as np

from ..plants.checks import finite, matrix
from .limits import per_signal
from .signals import NOTHING_TO_SET, signals_of


def set_points_of(c):
    """A `Signal` for each set point of a controller c."""
    if not c.R.shape[1]:
        return ()
    names = c.gain.signals[: len(c.R)]
    if c.U is not None and len(c.U):
        sums = c.gain.signals[len(c.estimate.take) :]
        names = tuple(name.removeprefix("integral of ") for name in sums)
    return signals_of([f"set point of {x}" for x in names], c.units)


def followed_of(c):
    """For each set point of c the index of what is measured of it, or None."""
    named = {s.name: k for k, s in enumerate(c.readings.signals)}
    goals = (s.name.removeprefix("set point of ") for s in c.set_points)
    return [named.get(name) for name in goals]


def with_set_point(c, r, ramp, b, profile):
    """c with set points of ``r``, ``ramp``, ``b``, ``profile``: see its `set_point`."""
    new, limits = replace(c, R=chosen_set_point(c, r, b)), c.limits
    if profile is not None:
        if profile.T != c.T:
            raise ValueError(
                f"profile has T = {profile.T:g} s, and the controller {c.T:g} s"
            )
        limits = replace(limits, profile=profile)
    if ramp is not None:
        limits = replace(limits, ramp=per_signal("ramp", ramp, new.set_points))
    return replace(new, limits=limits)


def chosen_set_point(c, r, b=1.0):
    """The coordinates' set points, (n, p), for one unit of each of a controller c: r,
    checked, without it those of `quiet_set_point`; times the weight b.
    """
    n = len(c.R)
    if not n:
        raise ValueError(NOTHING_TO_SET)
    U = np.zeros((0, n)) if c.U is None else c.U
    if finite("b", b) != 1 and not len(U):
        raise ValueError(
            "b weighs what an integral moves, and nothing is integrated: leave b out"
        )
    if r is None:
        return b * quiet_set_point(U, c.gains[0][:, :n])
    r = matrix("r", r, (n, None))
    if len(U) and (r.shape[1] != len(U) or abs(U @ r - np.eye(len(U))).max() > 1e-9):
        raise ValueError(
            "r must have U r = I: one column for each integral, and its set point "
            f"there; got U r = {(U @ r).tolist()}"
        )
    return b * r


def quiet_set_point(U, K_P):
    """The least r with U r = I of which K_P r is least, (n, a); all of z without U."""
    a, n = U.shape
    if not a:
        return np.eye(n)
    base = np.linalg.pinv(U)
    free = np.linalg.svd(U)[2][a:].T
    if not free.shape[1]:
        return base
    return base - free @ (np.linalg.pinv(K_P @ free) @ (K_P @ base))
