r"""Margins of a sampled loop that is opened at one signal: proven for every plant.

Let the signal s, an input of the plant or a reading, be multiplied by a complex number
g where it goes on. **Disks.** With g = c + r d the loop is that of g = c, pushed by r d
s where s goes on. If the H-infinity norm from this push w to r s is below one, it is
stable for every constant complex d with :math:`|d| \le 1` (small gain), so for every g
of the disk. The norm is proven for every plant as that of any disturbance is, see
`sosbook.sampled.cells`: with w and z joined to the state.

So gains are those of disks on the real axis that overlap, and a phase is what one
of them covers of the unit circle. Source of disk margins: Seiler, Packard and Gahinet,
An introduction to disk margins (2020).
"""

from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from ..exact.rational import exact
from ..runtime.threads import one_thread
from ..runtime.time_limit import OutOfTime, checked_seconds, time_limit
from ..sampled.balls import balls
from ..sampled.cover import cover
from ..sampled.loops import SampledFamily
from ..sampled.proof import by_balls
from ..sampled.shapes import PlantShape
from ..sampled.timing import TimeBox
from .bounded import plants_of
from .bounds import stable
from .cells import unrounded, work
from .charts import key
from .frequency import OpenLoop
from .signals import known_index

SHARES = 0.98, 0.9, 0.7  # of what is seen, that are tried
CENTRES = np.geomspace(0.05, 50, 121)  # of disks for a phase
LINKS = 6  # disks in a chain for a gain
STEPS = 60  # places where the centre of the next one may be
CLOSE = 0.97  # of a gain that is seen: no more links
LARGEST = 1e3  # a gain beyond which none is sought
ROUND = np.linspace(-1, 1, 9)  # frequencies around a resonance, in widths
CELLS = 256
LATEST = 64  # ticks that a delay is followed in floats
PROVEN = 16  # ticks of them that a proof follows at most: each has its own state
PARTS = 24  # of the delay that crossovers tell, at which eigenvalues are looked at


@dataclass(frozen=True)
class Margin:
    """A margin: ``proven`` for every plant, and ``seen`` at the worst ``plant``.

    Both are floats, in a ``unit``; ``proven`` is None where nothing was proven, and
    ``seen`` is nan where the end of a margin is later than was looked.
    """

    proven: float | None
    seen: float
    plant: str = ""
    unit: str = ""

    def __str__(self):
        unit = f" {self.unit}" if self.unit else ""
        known = "nothing proven" if self.proven is None else f"{self.proven:.4g}{unit}"
        if np.isnan(self.seen):
            return f"{known} (its end wasn't seen)"
        return f"{known} ({self.seen:.4g}{unit} at {self.plant})"


@dataclass(frozen=True, eq=False, repr=False)
class Margins:
    """How far a sampled loop is from instability, opened at one signal.

    All are of the linear loop and constant plants; gain, phase and disk change one
    signal alone. No file holds these proofs: one program, this package, has made them.

    Parameters
    ----------
    at : str
        The signal.
    gain : (Margin, Margin)
        It may be multiplied by any number between these two.
    phase : Margin
        It may turn by so many degrees, either way, at all frequencies.
    disk : Margin
        alpha: it may be multiplied by any complex (2 + a) / (2 - a) with |a| < alpha.
    delay : Margin or None
        All inputs may come later by any constant time up to this, in s; None where it
        wasn't asked.
    open_loop : OpenLoop
        Its frequency response at some plants, and charts.
    stopped : bool
        Whether the time was over before all was looked for.
    """

    at: str
    gain: tuple
    phase: Margin
    disk: Margin
    delay: Margin | None
    open_loop: OpenLoop
    stopped: bool = False

    def __repr__(self):
        low, high = self.gain
        lines = [
            f"the loop opened at {self.at}, proven by one program for every plant (and "
            "seen at some):",
            f"  gain, times: from {low} to {high}",
            f"  phase, either way: {self.phase}",
            f"  disk, alpha: {self.disk}",
        ]
        if self.delay is not None:
            lines.append(f"  delay of all inputs, more: {self.delay}")
        if self.stopped:
            lines.append("  the time was over: a longer time_limit may prove more")
        return "\n".join(lines)

    def _repr_html_(self):
        """The numbers, Bode's and Nyquist's plots, and which line is which plant."""
        from html import escape

        loop = self.open_loop
        charts = loop.bode() + loop.nyquist() + key(loop.names)
        return f"<pre>{escape(repr(self))}</pre>{charts}"


@dataclass(frozen=True, eq=False)
class Cut:
    """The loop of a ``controller``, opened at its output ``k``, or what it reads."""

    controller: Any
    k: int
    of_input: bool

    @classmethod
    def at(cls, c, at):
        """That of a signal ``at``: the index of an input, or a name."""
        names = [s.name for s in c.outputs], [s.name for s in c.readings.signals]
        if isinstance(at, str):
            if at not in names[0] + names[1]:
                raise ValueError(
                    "at must be the index of an input, or one of "
                    f"{', '.join(names[0] + names[1])}; got {at!r}"
                )
            whole = at in names[0]
            return cls(c, names[1 - whole].index(at), whole)
        known_index("at", at, c.outputs)
        return cls(c, at, True)

    @property
    def name(self):
        """The signal's."""
        c = self.controller
        several = c.outputs if self.of_input else c.readings.signals
        return several[self.k].name

    def parts(self, loop):
        """(push, row) of a loop, `Ticks`: how w acts on the state, and s = row x."""
        if self.of_input:
            return loop.pushed[:, self.k], loop.H[self.k]
        row = np.zeros(len(loop.F))
        seen = self.controller.readings.rows[self.k]
        row[: len(seen)] = seen
        return loop.noise[:, self.k], row

    def family(self, centre, radius):
        """The loops where g is ``centre``, joined with w and z = ``radius`` s."""
        c, k = self.controller, self.k
        rows = exact(c.readings.rows)
        A, B, C, D = (exact(x) for x in (c.A, c.B, c.C, c.D))
        (l, q), m, N = B.shape, len(C), rows.shape[1]
        if self.of_input:
            seen, own = (D[k] @ rows, C[k]), exact(np.zeros(l))
            direct, turn = exact(np.eye(m)[k]), exact(np.eye(m))
            turn[k, k] = exact(centre)
            C, D = turn @ C, turn @ D
        else:
            seen, own, direct = (rows[k], exact(np.zeros(l))), B[:, k], D[:, k]
            turn = exact(np.eye(q))
            turn[k, k] = exact(centre)
            rows = turn @ rows
        wide = unrounded(A, B @ rows, C, D @ rows, c.T)
        full, memory = c.timing.feedback(wide, c.vertices[0], exact)
        order = full.shape[1]
        full = _bordered(full, 1, 1)
        full[-1 - m : -1, -1], full[-1, -1] = direct, exact(1)
        memory = _bordered(memory, 1, 1)
        memory[:l, -1] = own
        memory[-1, :N] = exact(radius) * seen[0]
        memory[-1, order - l : order] = exact(radius) * seen[1]
        none = exact(np.zeros((N, 1)))
        vertices = [d.map(exact) for d in c.vertices]
        vertices = [replace(d, Bu=np.hstack([d.Bu, none])) for d in vertices]
        shape = PlantShape.of(c.plant, vertices)
        return SampledFamily(shape, balls(full), balls(memory), 0.0, 1)

    @cached_property
    def seen(self):
        """(names, Descriptors, `OpenLoop`) of plants to look at."""
        c, curves, omega = self.controller, [], []
        names, _, several = zip(*plants_of(c))
        loops = [c.loop(d) for d in several]
        for loop in loops:
            poles = np.linalg.eigvals(loop.F)
            at, wide = abs(np.angle(poles)), abs(np.log(abs(poles) + 1e-300))
            omega.append((at[:, None] + wide[:, None] * ROUND).ravel() / c.T)
        omega = np.concatenate([*omega, np.geomspace(1e-4, 1, 2000) * np.pi / c.T])
        omega = np.unique(omega[(omega > 1e-5 / c.T) & (omega <= np.pi / c.T)])
        for loop in loops:
            push, row = self.parts(loop)
            z = np.exp(1j * omega * c.T)
            at = z[:, None, None] * np.eye(len(loop.F)) - loop.F
            S = 1 + np.linalg.solve(at, push[None, :, None] + 0j)[..., 0] @ row
            curves.append(S)
        return names, several, OpenLoop(omega, np.array(curves), names, self.name)

    @work
    def proven(self, centre, radius, cells=CELLS):
        """True if every g of a disk is proven to leave every plant's loop stable."""
        c = self.controller
        family = self.family(centre, radius)
        return cover(family, TimeBox.only(c.timing), 1.0, cells)[0] is not None


def _bordered(x, rows, columns):
    """A matrix of rationals with zeros below and beside it."""
    found = exact(np.zeros((len(x) + rows, x.shape[1] + columns)))
    found[: len(x), : x.shape[1]] = x
    return found


@one_thread
def margins_of(c, at=0, seconds=60.0, sharp=True):
    """The `Margins` of a controller c, opened ``at`` a signal, in some ``seconds``;
    ``sharp``: see its `margins`.
    """
    cut = Cut.at(c, at)
    stable(c, "margins")
    names, several, loop = cut.seen
    known = {x: loop.seen(x) for x in ("low", "high", "phase", "disk")}
    later = sharp and not c.timing.steps  # inputs between the ticks
    late, which = _latest(c, several, loop) if later else (np.inf, 0)
    disks, found = [], dict.fromkeys(("disk", "low", "high", "phase", "delay"))
    stopped = True
    with suppress(OutOfTime), time_limit(checked_seconds(seconds, needed=True)):
        _of_disks(cut, loop, known, disks, found)
        if later:
            _of_delay(c, late, found)
        if sharp:
            _of_gains(cut, loop, known, disks)
        stopped = False
    if disks:  # what they hold is known, also where the time has ended a search
        found["phase"] = np.degrees(max(_covered(*x) for x in disks)) * (1 - 1e-9)
        low, high = _joined(disks)
        found |= {"low": max(low, 0.0), "high": high}

    def margin(name, unit=""):
        value, k = known[name]
        return Margin(found[name], float(value), names[k], unit)

    known["delay"] = late, which
    return Margins(
        cut.name,
        (margin("low"), margin("high")),
        margin("phase", "deg"),
        margin("disk"),
        margin("delay", "s") if later else None,
        loop,
        stopped,
    )


def _add(cut, disks, centre, radius):
    """Add to ``disks`` the largest share of one that is proven, if any is."""
    centre = float(f"{centre:.6g}")
    for share in SHARES:
        some = float(f"{share * radius:.4g}")
        if cut.proven(centre, some):
            disks.append((centre, some))
            return


def _of_disks(cut, loop, known, disks, found):
    """Prove two ``disks``: that around one is ``found``; the other has most phase."""
    for share in SHARES:
        alpha = float(f"{share * min(known['disk'][0], 1.99):.4g}")
        low, high = (2 - alpha) / (2 + alpha), (2 + alpha) / (2 - alpha)
        centre, radius = float(f"{(low + high) / 2:.9g}"), (high - low) / 2
        radius = float(f"{radius:.9g}")
        if cut.proven(centre, radius):
            disks.append((centre, radius))
            # of the disk that was proven, which was rounded
            ends = centre + radius, 1 / max(centre - radius, 1e-12)
            found["disk"] = min(2 * (x - 1) / (x + 1) for x in ends) * (1 - 1e-9)
            break
    sizes = [loop.distance(x) for x in CENTRES]
    angles = [_covered(x, SHARES[0] * r) for x, r in zip(CENTRES, sizes)]
    best = int(np.argmax(angles))
    _add(cut, disks, CENTRES[best], sizes[best])


def _of_gains(cut, loop, known, disks):
    """Prove a chain of more ``disks`` towards each end of the gain."""
    reach = _joined(disks)
    for name, k, way in (("high", 1, 1), ("low", 0, -1)):
        goal = known[name][0]
        for _ in range(LINKS):
            here = reach[k]
            near = goal if goal not in (0, np.inf) else (LARGEST if way > 0 else 1e-3)
            if way * (here - near * CLOSE**way) >= 0 or here <= 0:
                break
            several = [(x, loop.distance(x)) for x in np.geomspace(here, near, STEPS)]
            overlap = [
                (x, r) for x, r in several if abs(x - here) < SHARES[0] * r * (1 - 1e-6)
            ]
            most = max(overlap, key=lambda p: way * p[0] + SHARES[0] * p[1])
            _add(cut, disks, *most)
            reach = _joined(disks)
            if reach[k] == here:
                break


def _joined(disks):
    """The real gains around one that some overlapping ``disks`` cover, (low, high)."""
    low = high = 1.0
    for _ in disks:
        for c, r in disks:
            if c - r < high and c + r > low:
                low = min(low, (c - r) + 1e-12 * (c + r))
                high = max(high, (c + r) * (1 - 1e-12))
    return low, high


def _covered(centre, radius):
    """The angle of the unit circle around one that a disk holds: zero without one."""
    if abs(1 - centre) >= radius:
        return 0.0
    return float(np.arccos(np.clip((1 + centre**2 - radius**2) / (2 * centre), -1, 1)))


def _latest(c, several, loop):
    """(seconds, which): how much later all inputs may come, at a plant, by eigenvalues;
    the delay that frequencies tell is where they are looked for, and the answer where
    so many ticks have too many eigenvalues.
    """

    def radius(d, late):
        clock = replace(c.clock, delay=late, jitter=0.0)
        return replace(c, clock=clock).loop(d).radius

    guess, which = loop.seen("delay")
    if len(c.outputs) > 1:  # what frequencies tell is of one of them
        guess = np.nan
    elif guess > LATEST * c.T:
        return guess, which
    best = np.inf
    for k, d in enumerate(several):
        low, most = 0.0, np.fmin(1.3 * guess, min(LATEST * c.T, best))
        for high in np.linspace(0, most, PARTS + 1)[1:]:
            if radius(d, c.delay + high) >= 1:
                break
            low = high
        else:
            continue
        while high - low > 1e-3 * high:
            mean = (low + high) / 2
            low, high = (low, mean) if radius(d, c.delay + mean) >= 1 else (mean, high)
        best, which = low, k
    return (best, which) if np.isfinite(best) else (guess, which)


def _of_delay(c, late, found):
    """The delay that is proven: one interval after the other, in which it may vary."""
    T = exact(c.T)
    most = np.fmin(late * SHARES[0], PROVEN * c.T)
    low = exact(c.delay)
    while float(low) < c.delay + most:
        whole = (low / T).floor() + 1  # to the next tick
        left = min(float(whole * T), c.delay + most) - float(low)
        for share in (1.0, *SHARES[1:], 0.4):
            end = float(f"{float(low) + share * left:.9g}")
            if by_balls(
                c.plant, c.of_state, c.T, (float(low), end), cells=CELLS
            ).proven:
                found["delay"] = float(exact(end) - exact(c.delay)) * (1 - 1e-12)
                break
        else:
            return
        if exact(end) < whole * T:
            return
        low = exact(end)
