"""The program of a controller in Python, operation by operation as in C."""

from types import SimpleNamespace

import numpy as np

from .lanes import Lanes, within
from .limits import FAULTS
from .numbers import program_numbers

SENSOR, CLOCK, STALL, COMMAND, SILENT = range(1, len(FAULTS))
#: Counters of ticks in a row, and last of all ticks that came late.
COUNTERS = ("late", "silent", "full", "overruns")
MOST_COUNTED = 30000  # of ticks that came late; then the counter stays


class Replay:
    """The program <name>.c in Python, bit for bit, for machines side by side.

    Parameters
    ----------
    controller : Controller
        What it is the program of.
    runs : int
        How many machines.
    kind : float or np.float32
        The precision of all arithmetic.

    Attributes
    ----------
    fault : (runs,) array of int
        Indices in `FAULTS`.
    """

    def __init__(self, controller, runs=1, kind=float):
        self.controller, self._lanes = controller, Lanes(runs, kind)
        self._n = self._lanes.numbers(program_numbers(controller))
        self._now = None

    @property
    def fault(self):
        """Indices in `FAULTS`, one for each machine; None before the start."""
        if self._now is None:
            return None
        return np.array(self._now.fault).reshape(-1).astype(int)

    def start(self, y):
        """Forget everything; y (q,) or (q, runs) is what is measured now."""
        lanes, n = self._lanes, self._n
        y = self._read(y, len(n.RANGE))
        zero = lanes.zero
        none = 0 if lanes.runs == 1 else np.zeros(lanes.runs, int)
        good = True
        for value, bound in zip(y, n.RANGE):
            good = good & within(value, bound)
        with np.errstate(all="ignore"):
            x = lanes.begun(n, y)
        self._now = SimpleNamespace(
            x=[lanes.where(good, value, zero) for value in x],
            y=[lanes.where(good, value, zero) for value in y],
            r=[zero for _ in n.REACH],
            u=[zero for _ in n.LIMIT],
            lost=[none for _ in n.RANGE],
            fault=lanes.where(good, none, none + SENSOR),
            **dict.fromkeys(COUNTERS, none),
        )
        p = len(n.REACH)
        for j, k in enumerate(self.controller.followed[:p]):
            if k is not None:
                self._now.r[j] = self._now.y[k]

    def step(self, y, r=(), elapsed=None):
        """One tick.

        Parameters
        ----------
        y : (q,) or (q, runs) array_like
            What is measured; not a number where there is no sample.
        r : (p,) or (p, runs) array_like
            Set points; not a number: there is no new one.
        elapsed : float, optional
            Seconds since the last tick; T without it.

        Returns
        -------
        (m, runs) array
            The outputs; zero after a fault.
        """
        if self._now is None:
            raise ValueError("the program isn't started: call start(y)")
        lanes, n = self._lanes, self._n
        y, r = self._read(y, len(n.RANGE)), self._read(r, len(n.REACH))
        elapsed = n.TICK if elapsed is None else lanes.read(elapsed)
        with np.errstate(all="ignore"):
            u, self._now = self._step(self._now, y, r, elapsed)
        return np.array([lanes.shown(value).reshape(-1) for value in u])

    def _read(self, values, count):
        values, runs = np.asarray(values, float), self._lanes.runs
        if runs == 1:
            values = values.reshape(count).tolist()
            if self._lanes.real is float:
                return values
        else:
            values = values.reshape(count, -1 if count else runs)
            values = np.broadcast_to(values, (count, runs))
        with np.errstate(over="ignore"):
            return [self._lanes.read(x) for x in values]

    def _step(self, now, y, r, elapsed):
        """One tick of `step` of the C program, on all machines at once."""
        n, where, lanes = self._n, self._lanes.where, self._lanes
        running = now.fault == 0
        fault = now.fault

        def blame(bad, number):
            return where(running & (fault == 0) & bad, number, fault)

        # the clock
        late = where(within(elapsed - n.TICK, n.SLACK), 0, now.late + 1)
        overruns = where(
            (late > 0) & (now.overruns < MOST_COUNTED), now.overruns + 1, now.overruns
        )
        fault = blame(late > n.MOST_LATE, CLOCK)

        # the sensors
        seen, last, lost = [], [], []
        for i, value in enumerate(y):
            near = lanes.believable(value - now.y[i], n.JUMP[i], now.lost[i])
            good = within(value, n.RANGE[i]) & near
            guess = now.y[i]
            if n.PREDICTS:
                guess = lanes.total((n.GUESS[i], now.x))
            seen.append(where(good, value, guess))
            last.append(where(good, value, now.y[i]))
            lost.append(where(good, 0, now.lost[i] + 1))
            fault = blame(lost[i] > n.MOST_LOST, SENSOR)

        # the set points
        told, follows = True, []
        for j, value in enumerate(r):
            good = within(value, n.REACH[j])
            goal = value
            if n.RAMPS:
                goal = now.r[j] + lanes.cut(value - now.r[j], n.RAMP[j])
            follows.append(where(good, goal, now.r[j]))
            told = told & good
        silent = where(told | (n.MOST_SILENT == 0), 0, now.silent + 1)
        fault = blame(silent > n.MOST_SILENT, SILENT)

        # the law and its limits
        asked, given, full = [], [], False
        for k, old in enumerate(now.u):
            want = lanes.answered(n, k, now.x, seen, follows)
            fault = blame(~np.asarray(within(want, n.TRUSTED[k])), COMMAND)
            full = full | (want > n.LIMIT[k]) | (want < -n.LIMIT[k])
            v = lanes.cut(want, n.LIMIT[k])
            if n.SLEWS:
                v = lanes.cut(old + lanes.cut(v - old, n.SLEW[k]), n.LIMIT[k])
            asked.append(want)
            given.append(v)
        full = where(full, now.full + 1, 0)
        fault = blame(full > n.MOST_FULL, STALL)

        withheld = [v - u for v, u in zip(given, asked)]
        x = lanes.remembered(n, now.x, seen, follows, withheld)
        keep = lanes.keeper(np.asarray(running & (fault == 0)))

        def kept(new, old):
            return [keep(x, y) for x, y in zip(new, old)]

        u = [keep(v, lanes.zero) for v in given]
        return u, SimpleNamespace(
            x=kept(x, now.x),
            y=kept(last, now.y),
            r=kept(follows, now.r),
            u=u,
            lost=kept(lost, now.lost),
            fault=where(running, fault, now.fault),
            late=keep(late, now.late),
            silent=keep(silent, now.silent),
            full=keep(full, now.full),
            overruns=keep(overruns, now.overruns),
        )
