"""A step of a set point: its numbers proven for every plant, and seen at some."""

from dataclasses import dataclass

import numpy as np
from flint import arb

from ..exact.rational import exact
from ..plants.checks import positive
from ..plants.gain import signals
from ..plants.outputs import Output
from ..plants.sensed import in_states
from .bounded import Bounded, plants_of
from .bounds import ENDS, fixed_end, of_all_plants, outputs_of, rest, rounded, ticks_of
from .cells import Joined, work
from .charts import chart
from .signals import known_index, unit_of
from .tube import SAFE

FINE = 0.002, 0.01  # of the output's step, and of the largest u: no more halving
RISE = 0.1, 0.9  # of the way, between which an output rises
TOLD, DUST = 1e-5, 1e-11  # shares: of what a proof and floats can tell from none
ALIKE = 1e-6  # of the largest: the first plant that reaches so much is named
NOTHING = "0 but for rounding"
NUMBERS = "overshoot", "undershoot", "settling_time", "rise_time", "peak"


@dataclass(frozen=True, eq=False, repr=False)
class StepBounds:
    """A step of a set point, from rest, of the loop without limits, at the ticks.

    The words are those of python-control's ``step_info``, but each number is a
    `Bounded`: no plant of the family exceeds ``proven``, and ``seen`` is the largest of
    some plants in floats. Both are of ticks: what happens between two isn't looked at.

    Parameters
    ----------
    output : str
        The output, in words.
    size : float
        Of the step, in the unit of the set point.
    overshoot, undershoot : Bounded or None
        As shares of where the output ends, beyond that and below the start: 0.05 is
        5 %. None, as the next two, of an output that ends at zero.
    settling_time, rise_time : Bounded or None
        In s: after the one it stays in the band; the other is from 10 to 90 %.
    peak : Bounded
        The largest size of the output, in its unit.
    effort, slew : tuple of Bounded
        The largest size of each u, and its largest change per second, the first jump
        among it.
    curves : (3, k) array
        Times of the ticks in s, and the lowest and the highest output of all plants.
    cells : int
        In how many parts of the family.
    plants : dict
        The plant at which a number is largest among those seen, by the number's name.

    Examples
    --------
    >>> import sosbook as sos
    >>> cart = sos.Uncertain(lambda m: sos.SecondOrderSystem(m, 0, 0, 1), m=(1, 2))
    >>> design = sos.design_pid(cart, region=sos.PoleRegion(1, rho=9))
    >>> found = design.controller(T=0.01).bounds.step_response(output="z1")
    >>> found.overshoot.seen <= found.overshoot.proven < 0.01 + found.overshoot.seen
    True
    """

    output: str
    size: float
    overshoot: Bounded | None
    undershoot: Bounded | None
    settling_time: Bounded | None
    rise_time: Bounded | None
    peak: Bounded
    effort: tuple
    slew: tuple
    curves: np.ndarray
    cells: int
    plants: dict

    def __repr__(self):
        where = f"{self.output}, at the ticks, in {self.cells} cells"
        lines = [f"a step of {self.size:g}, {where}:"]
        pairs = [(name, getattr(self, name)) for name in NUMBERS]
        for name in ("effort", "slew"):
            several = getattr(self, name)
            for k, bound in enumerate(several, 1):
                pairs.append((f"{name} {k}" if len(several) > 1 else name, bound))
        for name, bound in pairs:
            if bound is not None:
                lines.append(f"  {name.replace('_', ' ')}: {self.words(name, bound)}")
        return "\n".join(lines)

    def words(self, name, bound=None):
        """A number by its ``name``, or a ``bound``, in words, and where it is seen."""
        bound = getattr(self, name) if bound is None else bound
        where = self.plants[name.partition(" ")[0]]
        if bound.unit == "%" and bound.proven is not None and bound.proven < TOLD:
            seen = f"{100 * bound.seen:.4g} at {where}"
            seen = seen if bound.seen > DUST else NOTHING
            return f"less than {100 * TOLD:g} % ({seen})"
        return str(bound).replace("at the corners", f"at {where}")

    def _repr_html_(self):
        """The band of all plants over the time."""
        from html import escape

        drawn, words = "", f"<pre>{escape(repr(self))}</pre>"
        if np.isfinite(self.curves).all():  # of a loop that is stable
            curves = [(self.curves[0], ends) for ends in self.curves[1:]]
            drawn = chart(curves, self.output, band=2)
        return words + drawn


@dataclass(frozen=True, eq=False)
class Row:
    """An output: ``row``, (N,), of the loop's state, where it ``ends`` after a step of
    1, in rationals, or None where each plant has its own end; its ``name`` and
    ``unit``; of a u ``direct``: how the set point acts on it at once.
    """

    row: np.ndarray
    ends: object
    name: str
    unit: str
    direct: float | None = None

    @classmethod
    def of(cls, c, j, x, output):
        """That of an ``output`` (see `OutputBounds.step_response`) of c after a
        step of set point j to the rest x.
        """
        N, whole = c.readings.rows.shape[1], len(c.loops[0].F)
        names = signals(c.plant)
        if isinstance(output, Output):
            row, share = _weights(c, output)
            name, unit = output.name or output.words, ""
            row = np.concatenate([row, exact(np.zeros(whole - N))])
            ends = fixed_end(c, j, x, row)
            if x is None and share.any():
                ends = None  # of u, springs ask something at rest
            return cls(row + share @ outputs_of(c), ends, name, unit)
        if output is None:
            n, name = len(c.R), c.set_points[j].name.removeprefix("set point of ")
            known = c.readings.rows[:n] if c.estimate.errors else np.eye(N)[:n]
            row = c.U[j] @ known if c.U is not None and len(c.U) else known[j]
        elif isinstance(output, str):
            several = dict(zip([s.name for s in c.readings.signals], c.readings.rows))
            several |= dict(zip(names, np.eye(N)))
            if output not in several:
                raise ValueError(
                    f"output must be an Output, the index of a u, or one of "
                    f"{', '.join(several)}; got {output!r}"
                )
            name, row = output, several[output]
        else:
            known_index("output", output, c.outputs)
            signal, ends = c.outputs[output], None if x is None else exact(0)
            words, direct = (signal.name, signal.unit), float(c.D_r[output, j])
            return cls(outputs_of(c)[output], ends, *words, direct)
        row = np.concatenate([exact(row), exact(np.zeros(whole - N))])
        return cls(row, fixed_end(c, j, x, row), name, unit_of(name, c.units))


def _weights(c, output):
    """The rows of an `Output` on the plant's state and on u, in rationals."""
    known = getattr(c.plant, "sensed", None)
    if known is not None:
        bare = known.rows.shape[1]
        output = in_states(output, bare, known.n).resized(
            bare, c.readings.rows.shape[1]
        )
    d = output.seen(c.vertices[0])
    if d.Ca is not None or len(d.C) != 1:
        raise ValueError(
            "output must have one row, and none on accelerations, which differ from "
            "plant to plant: give a position, a velocity, a state or an input"
        )
    share = np.zeros((1, len(c.outputs))) if d.Du is None else d.Du
    return exact(d.C[0]), exact(share[0])


@work
def step_bounds(c, x, size, j, output, band, most):
    """The `StepBounds` of a controller c after a step of a ``size`` of set point j.

    x: see `rest`, None where each plant has its own; ``output``, ``band``: see
    `OutputBounds.step_response`; in ``most`` cells at most: none proves nothing.
    """
    size = exact(positive("size", size))
    positive("band", band)
    row = Row.of(c, j, x, output)
    if row.ends is None:
        raise ValueError(ENDS)
    asked = outputs_of(c)
    ticks = ticks_of(c.radius) if c.radius < 1 else 1
    end = float(row.ends)
    goal = abs(end) or 1.0

    def judged(tube):
        """The numbers of a ``tube``'s step, and how far its doubt is above `FINE`."""
        y, away = tube.rest(x)
        motion = tube.motion(-y, away, ticks=ticks)
        near, off, tail = motion.seen(row.row)
        answer = _Numbers.of(near.min(axis=1) - off, near.max(axis=1) + off, tail, end)
        excess = [off.max() - FINE[0] * (goal if end else abs(near).max())]
        for h, at_once in zip(asked, c.D_r[:, j]):
            u, doubt, last = motion.seen(h)
            end_u = 0.0
            if x is None:  # what springs ask at rest
                held, more, _ = tube.motion(y, away).seen(h)
                u, doubt = u + held[0] + at_once, doubt + more[0]
                end_u = abs(held[0] + at_once).max() + more[0]
            most = max((abs(u).max(axis=1) + doubt).max(), last + end_u)
            jump = abs(np.diff(u, axis=0)).max(axis=1) + doubt[1:] + doubt[:-1]
            jump = max(jump.max(initial=0.0), 2 * last, abs(u[0]).max() + doubt[0])
            answer.asked.append((most * SAFE, jump * SAFE))
            excess.append(doubt.max() - FINE[1] * abs(u).max())
        return answer, max(excess)

    found = None
    if most:
        pushed = slice(0) if x is not None else [j]
        joined = Joined(c, c.B_r[:, pushed], c.D_r[:, pushed])
        found = of_all_plants(c, joined, judged, most)
    plants = plants_of(c)
    seen = [_Numbers.seen(c, d, x, row, ticks, j) for *_, d in plants]
    names = [name for name, *_ in plants]
    where = {}

    def bound(name, of, times, unit):
        values = [of(one) for one in seen] if c.radius < 1 else [None]
        known = [np.nan] if None in values else values  # nobody saw the worst
        worst = np.fmax.reduce(known)
        near = np.asarray(known) >= worst * (1 - ALIKE * np.sign(worst))
        where[name] = names[int(np.argmax(near))]
        proven = None
        if found is not None and None not in (each := [of(one) for one in found]):
            proven = _times(max(each), exact(times))
        return Bounded(proven, float(worst) * float(times), unit)

    def per_output(name, k, times, more=""):
        return tuple(
            bound(name, lambda one, i=i: one.asked[i][k], times, signal.unit + more)
            for i, signal in enumerate(c.outputs)
        )

    moves = [("overshoot", 1, "%"), ("undershoot", 1, "%")] * bool(row.ends)
    times = [("settling_time", c.T, "s"), ("rise_time", c.T, "s")] * bool(row.ends)
    asks = dict(settling_time=lambda one: one.settled(band))
    numbers = dict.fromkeys(NUMBERS)
    for name, share, unit in moves + times:
        of = asks.get(name, lambda one, name=name: getattr(one, name))
        numbers[name] = bound(name, of, share, unit)
    numbers["peak"] = bound("peak", lambda one: one.peak, size, row.unit)
    per_second = "/s" if any(s.unit for s in c.outputs) else ""
    low = np.min([one.low for one in found or seen], axis=0)
    high = np.max([one.high for one in found or seen], axis=0)
    ends = [float(size) * (end + y) for y in (low, high)]
    return StepBounds(
        f"{row.name} ({row.unit})" if row.unit else row.name,
        float(size),
        **numbers,
        effort=per_output("effort", 0, size),
        slew=per_output("slew", 1, size / exact(c.T), per_second),
        curves=np.array([c.T * np.arange(ticks + 1), *ends]),
        cells=len(found or ()),
        plants=where,
    )


@dataclass(frozen=True, eq=False)
class _Numbers:
    """The numbers of a step, in ticks and shares of the step, of outputs between
    ``low`` and ``high``, (k,), less where they ``end``, and from then on within
    ``tail``; ``asked``: the largest u and its largest change, of each; ``safe``: a
    factor for the roundings of bounds.
    """

    low: np.ndarray
    high: np.ndarray
    tail: float
    end: float
    asked: list
    safe: float = SAFE

    @classmethod
    def of(cls, low, high, tail, end):
        """With room for the last roundings."""
        room = 2.0**-50 * (abs(low) + abs(high) + abs(end))
        return cls(low - room, high + room, tail * SAFE, end, [])

    @classmethod
    def seen(cls, c, d, x, row, ticks, j):
        """Those of a plant d of a controller c, in floats: none of an unstable loop."""
        loop, held = c.loop(d), 0.0
        if x is None:
            left = np.eye(len(loop.F)) - loop.F
            x = np.linalg.solve(left, loop.set_point[:, [j]])
            held = (loop.H @ x)[:, 0] + loop.direct_r[:, j]
        stays, states = loop.radius < 1, np.full((ticks + 1, len(x)), np.nan)
        if stays:
            states = motion_of(loop, -x, ticks)
        y = states @ row.row.astype(float)
        found = cls(y, y, 0.0 if stays else np.inf, float(row.ends), [], 1.0)
        for u in (states @ loop.H.T + held).T:
            moved = abs(np.diff(u, prepend=0.0)).max()
            found.asked.append((abs(u).max(), moved))
        return found

    @property
    def away(self):
        """(low, high) as shares of the step's way, upwards."""
        low, high = self.low / self.end, self.high / self.end
        return (low, high) if self.end > 0 else (high, low)

    @property
    def overshoot(self):
        """Beyond the end."""
        return max(self.away[1].max(), self.tail / abs(self.end), 0.0) * self.safe

    @property
    def undershoot(self):
        """Below the start."""
        least = max(-self.away[0].min(), self.tail / abs(self.end))
        return max(least * self.safe - 1, 0.0)

    @property
    def peak(self):
        """The largest size of the output."""
        ends = abs(self.low + self.end).max(), abs(self.high + self.end).max()
        return max(*ends, abs(self.end) + self.tail) * self.safe

    def settled(self, band):
        """The first tick from which on the output stays in the ``band``, or None."""
        low, high = self.away
        out = np.flatnonzero(np.maximum(abs(low), abs(high)) * self.safe > band)
        if not self.tail / abs(self.end) * self.safe <= band:
            return None
        if out.size and out[-1] == len(low) - 1:
            return None
        return int(out[-1]) + 1 if out.size else 0

    @property
    def rise_time(self):
        """Ticks from a tenth to nine tenths of the way, or None."""
        low, high = self.away
        first, last = (np.flatnonzero(x >= s - 1) for x, s in zip((high, low), RISE))
        rises = last.size and np.isfinite(self.tail)
        return int(last[0] - first[0]) if rises else None


def motion_of(loop, x, ticks):
    """(ticks + 1, N) states of a ``loop`` from x, (N, 1), in floats."""
    now, found = x.astype(float)[:, 0], []
    for _ in range(ticks + 1):
        found.append(now)
        now = loop.F @ now
    return np.array(found)


def seen_overshoot(c):
    """The largest overshoot in % of all set points of c at the vertices, in floats;
    None where none rests by itself, or the loop is unstable.
    """
    found = []
    for j, _ in enumerate(c.set_points if c.radius < 1 else ()):
        if (x := rest(c, j)) is not None:
            row = Row.of(c, j, x, None)
            ticks = ticks_of(c.radius)
            found += [
                _Numbers.seen(c, d, x, row, ticks, j).overshoot for d in c.vertices
            ]
    return 100 * max(found) if found else None


def _times(most, share):
    """A float that is no less than a product; itself, as a decimal, where it can be."""
    if isinstance(most, int):
        near = float(most * share)
        return (
            near if exact(near) == most * share else rounded(arb(most * share), np.inf)
        )
    return rounded(arb(most) * arb(share), np.inf)


def described(c):
    """A controller c in a line."""
    names = ", ".join(s.name for s in c.readings.signals)
    given = ", ".join(s.name for s in c.outputs)
    kind = f"T = {c.T:g} s, order {c.order}, {c.estimate.words}"
    if (over := seen_overshoot(c)) is not None:
        kind += f", a step overshoots by {round(over, 6):.3g} % at corners"
    return f"<Controller: {given} of {names}, {kind}>"
