"""A controller's program at work on its plants: between two changes the linear plant is
solved exactly; friction and backlash are constant over a part of a tick.
"""

from dataclasses import dataclass

import numpy as np

from ..plants.checks import count, positive
from .replay import Replay
from .signals import NOTHING_TO_SET

PARTS = 10  # of a tick, in which friction and backlash are constant
FEW = 5  # machines, whose programs take less time one by one, in plain numbers


@dataclass(frozen=True)
class Backlash:
    """A gap between two coordinates: within it their spring S_ij does nothing.

    Parameters
    ----------
    first, second : int
        The coordinates.
    gap : float
        How far one moves free of the other, from end to end.
    """

    first: int
    second: int
    gap: float


@dataclass(frozen=True, eq=False)
class Run:
    """The record of a program that ran with several plants, tick by tick.

    Parameters
    ----------
    t : (k,) array
        Times of the ticks, in s.
    x : (plants, k, N) array
        The plant's state [z; z'].
    u : (plants, k, m) array
        What the program gave.
    y : (plants, k, q) array
        What it saw.
    fault : (plants, k) array
        Indices in `FAULTS`.
    """

    t: np.ndarray
    x: np.ndarray
    u: np.ndarray
    y: np.ndarray
    fault: np.ndarray


def simulate_controller(
    controller,
    seconds,
    r=None,
    w=None,
    x0=None,
    *,
    plants=None,
    friction=None,
    backlash=None,
    program=None,
    lose=None,
):
    """Run a ``controller``'s program; ``seconds``, ``r``, ``w``, ``x0``, ``plants``,
    ``friction``, ``backlash``, ``program``, ``lose``: see `Controller.simulate`.
    """
    c = controller
    if r is not None and not c.set_points:
        raise ValueError(NOTHING_TO_SET)
    plants = c.vertices if plants is None else plants
    runs, (N, m) = len(plants), plants[0].Bu.shape
    p, read = plants[0].Bw.shape[1], c.readings.noise
    if not read.any():
        read = np.zeros((len(read), p))  # whatever disturbances these plants have
    if read.shape[1] != p:
        raise ValueError(
            f"plants have {p} disturbances, and the law's noise is one of "
            f"{read.shape[1]}: give them the same columns of F, with zeros for noise"
        )
    ticks = count("seconds / T", round(positive("seconds", seconds) / c.T), 1)
    if program is None:
        program = _OneByOne(c, runs) if runs <= FEW else Replay(c, runs)
    forces = _Forces(plants, friction, backlash)
    early, rest = float(c.timing.remainder), float(c.timing.T - c.timing.remainder)
    parts = PARTS if forces.entry.size else 1  # else nothing changes within a span
    spans = (span / parts for span in (early, rest))
    flows = [_flow(c.timing, plants, forces.entry, span) for span in spans]
    joined = getattr(c.plant, "sensed", None)
    x0 = x0 if joined is None else joined.whole(x0)
    x = np.zeros((runs, N)) if x0 is None else np.broadcast_to(x0, (runs, N)) + 0.0
    late = c.timing.whole_samples
    queue = [np.zeros((runs, m))] * (late + 2)
    seen = np.empty((runs, ticks, len(c.readings.rows)))
    xs, us = np.empty((runs, ticks, N)), np.empty((runs, ticks, m))
    faults = np.empty((runs, ticks), int)
    rows, exact = c.readings.rows, c.readings.steps[:, None] <= 0
    fine = np.where(exact, 1.0, c.readings.steps[:, None])
    for k in range(ticks):
        force = _at(w, k * c.T, p)
        y = (x @ rows.T + read @ force).T
        y = np.where(exact, y, fine * np.floor(y / fine + 0.5))
        if lose is not None and lose(k):
            y = np.full_like(y, np.nan)
        if k == 0:
            program.start(y)
        now = _at(r, k * c.T, len(c.set_points))
        u = program.step(y, np.repeat(now[:, None], runs, axis=1))
        xs[:, k], us[:, k], seen[:, k], faults[:, k] = x, u.T, y.T, program.fault
        queue = [u.T, *queue[:-1]]
        acting = queue[late + 1], queue[late]
        for (Phi, G_u, G_w, G_f, span), held in zip(flows, acting):
            moved = _times(G_u, held) + G_w @ force
            for _ in range(parts if span else 0):
                f = _times(G_f, forces(x, span)) if G_f.size else 0.0
                x = _times(Phi, x) + moved + f
    return Run(c.T * np.arange(ticks), xs, us, seen, faults)


class _OneByOne:
    """The program of `Replay` for a few machines."""

    def __init__(self, controller, runs):
        self.each = [Replay(controller) for _ in range(runs)]

    @property
    def fault(self):
        return np.concatenate([program.fault for program in self.each])

    def start(self, y):
        for program, seen in zip(self.each, y.T):
            program.start(seen)

    def step(self, y, r):
        pairs = zip(self.each, y.T, r.T)
        return np.hstack([program.step(seen, told) for program, seen, told in pairs])


def _times(matrices, vectors):
    return (matrices @ vectors[..., None])[..., 0]


def _at(signal, t, size):
    """The value at a time of a constant or a function of time; zero without."""
    value = signal(t) if callable(signal) else signal
    if value is None:
        return np.zeros(size)
    return np.broadcast_to(np.asarray(value, float).reshape(-1), (size,))


def _flow(timing, plants, entry, span):
    """The flow over a ``span`` of seconds, for each of ``plants``, as of ``timing``."""
    steps = []
    for d in plants:
        N, m, p = len(d.E), d.Bu.shape[1], d.Bw.shape[1]
        wide = np.hstack([d.A, d.Bu, d.Bw, entry])
        A = np.zeros((wide.shape[1],) * 2)
        A[:N] = np.linalg.solve(d.E, wide)
        steps.append(timing.flow(A, span)[:N])
    steps = np.array(steps)
    parts = np.split(steps, [N, N + m, N + m + p], axis=2)
    return *parts, span


def coordinates(plants, friction, backlash):
    """How many coordinates all ``plants`` have, on which ``friction`` or a ``backlash``
    acts; a ValueError where they act on none.
    """
    if friction is None and backlash is None:
        return plants[0].n
    what = "friction" if backlash is None else "backlash"
    if not all(d.n for d in plants):
        raise ValueError(
            f"{what} is a force between coordinates, and a DescriptorSystem has none: "
            "its state has no positions and speeds. Give a SecondOrderSystem"
        )
    n = plants[0].n
    if friction is not None and np.shape(friction) not in ((), (1,), (n,)):
        raise ValueError(
            f"friction needs a number, or one for each of {n} coordinates, got "
            f"{friction!r}"
        )
    for name in ("first", "second") if backlash is not None else ():
        if getattr(backlash, name) not in range(n):
            raise ValueError(
                f"backlash.{name} must be a coordinate's index below {n}, got "
                f"{getattr(backlash, name)!r}"
            )
    return n


class _Forces:
    """Friction and backlash of some plants, as forces on their equations."""

    def __init__(self, plants, friction, backlash):
        N = len(plants[0].E)
        self.n = n = coordinates(plants, friction, backlash)
        self.entry = np.eye(N)[:, n if friction is not None or backlash else N :]
        if self.entry.size:
            light = [np.diag(np.linalg.inv(d.E[n:, n:])) for d in plants]
            self.heavy = 1 / np.array(light)
        friction = 0.0 if friction is None else friction
        self.friction = np.broadcast_to(np.asarray(friction, float), (n,))
        self.backlash = backlash
        if backlash is not None:
            i, j = backlash.first, backlash.second
            self.stiff = np.array([d.A[n + i, j] for d in plants])

    def __call__(self, x, span):
        if not self.entry.size:
            return np.zeros((len(x), 0))
        speed = x[:, self.n :]
        # no more than would stop it
        f = -np.clip(speed * self.heavy / span, -self.friction, self.friction)
        if self.backlash is not None:
            i, j, gap = self.backlash.first, self.backlash.second, self.backlash.gap
            lost = self.stiff * np.clip(x[:, i] - x[:, j], -gap / 2, gap / 2)
            f[:, i] += lost
            f[:, j] -= lost
        return f
