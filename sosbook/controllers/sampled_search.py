"""The search of a law's gains on its sampled loop, and the proof of what it finds."""

from dataclasses import replace
from functools import partial

import numpy as np
from scipy.linalg import expm

from ..exact.definite import round_digits
from ..runtime.time_limit import LONGEST, OutOfTime, time_left, time_limit
from ..synthesis.structured.continuation import Ended, further, hasty, why_ended
from ..synthesis.structured.design import DIGITS, record
from ..synthesis.structured.moving_gain import corners_of, loops_of
from ..synthesis.structured.objective import DECAY, LARGEST, Task
from ..synthesis.structured.search import Found, search, starting_points
from .demands import Demanded, Demands, proven
from .tick_loops import FLOOR, TickLoops

EASIER = 1, 3, 10, 50  # times the backoff, until a proof is found
EDGE = 1e-9  # of the circle, that floats don't see
HALVINGS = 12  # of the fastest decay, until what else is asked is found
SEARCH = 0.5  # of the time, for the search; the rest is for the proof
STOPPED = (
    " The time was over when {} starts had begun: a longer time_limit goes further."
)
UNPROVEN = " The time was over before it was proven: a longer time_limit goes further."
HALF = 0.5
ASK = "ask for an effort, too, or for limits"


class SampledSearch:
    """A search of gains at the ticks, and the proof of what it finds, of a ``design``
    without a gain; ``sigma``, ``backoff``, ``cells``: as in `design_sampled`.
    """

    def __init__(self, design, sigma, backoff, cells):
        """Set the task of the search at the ticks: loops, limits, units, demands."""
        self.design, self.sigma = design, sigma
        self.backoff, self.cells = backoff, cells
        request, goal = design.request, DECAY if sigma is None else None
        self.continuous = loops_of(request)
        self.slow, form = Task.of(request, self.continuous, goal), self.continuous.form
        rows = abs(form.directions).sum(axis=2).argmax(axis=1)
        self.pace = np.where(rows < request.plant.m, 1.0, design.T)  # of memory: a tick
        largest = LARGEST * self.continuous.units(1 / design.T)  # nothing is as fast
        ends = form.within(np.maximum(self.slow.limits, largest) * self.pace)
        self.task = replace(self.slow, ends=ends)
        limits = self.task.limits
        held = np.where(self.pace == 1, ends, [-limits, limits])  # of ticks, else
        self.slow = replace(self.slow, ends=held / self.pace)
        steps = limits / LARGEST
        gains = [self.continuous.K(x) for x in (0 * steps, *np.diag(steps))]
        made = [replace(design, K=K).controller() for K in gains]
        corners = corners_of(request).values()
        plants = [d.map(lambda x: x.astype(float)) for d in corners]
        some = steps * np.linspace(0.7, 1.3, len(steps))
        some = replace(design, K=self.continuous.K(some)).controller()
        self.loops = TickLoops(made, steps, form, plants, some)
        self.missing = []
        self.demands = Demands(design.requirements, self.loops, 1 - backoff)
        self.task = replace(self.task, bounded=tuple(self.demands.parts))

    def done(self, starts, seed, seconds):
        """Search for some ``seconds`` from so many ``starts``, by a ``seed``, and
        return the result with its proof.
        """
        best, found, stopped, ended = None, Found(None, np.inf, 0), "", Ended()
        self.kept = []  # (decay, numbers) of what was found on the way
        try:
            with time_limit(seconds):
                with time_limit(SEARCH * time_left()):
                    found = self._first(starts, seed)
                    kept = found.value < 0 or not self.demands.parts
                    if kept and self.sigma is None and self._decay(found.kappa) > 0:
                        ask = partial(self._asked, starts, seed)
                        found, ended = further(found, self._decay, ask, 1)
                stopped = STOPPED.format(found.starts) * found.stopped
                if self._keeps(found.kappa):
                    self.kept.append((self._decay(found.kappa), found.kappa))
                    best = self._best()
        except OutOfTime:
            stopped = STOPPED.format(found.starts)
            if self._keeps(found.kappa):
                stopped = UNPROVEN
        by = record(self.task, self.loops, found.starts, seed, 0)
        if best is None or best.status != "feasible":
            words = f"{self._reason(found.kappa, best, by)}{stopped}"
            best = self.design
        else:
            ends, blocks = self.task.ends, self.continuous.form.blocks
            words = stopped or why_ended(ended, float, found.kappa, ends, blocks)
            if at := self.demands.words(found.kappa, bounds=True):
                words += f" At its bound: {at}."
            if not any(getattr(r, "effort", None) for r in best.requirements):
                words += f" {self._hasty(best.poles())}"
        return replace(best, reason=words.strip(), searched=by)

    def _keeps(self, kappa):
        """True if floats see all that is asked at these numbers ``kappa``."""
        fast = self._decay(kappa) > (self.sigma or 0)
        return fast and not self.demands.words(kappa)

    def _first(self, starts, seed):
        """The result of what is asked first: of demands without a decay, that of half
        of the fastest decay, or of half of that, and so on.
        """
        if self.sigma is not None or not self.demands.parts:
            return self._found(self.sigma, starts, seed)
        free = replace(self.task, bounded=())
        found = self._found(None, starts, seed, task=free)
        top, count = self._decay(found.kappa), found.starts
        for k in range(1, HALVINGS + 1) if top > 0 else ():
            found = self._asked(starts, seed, top / 2**k, found.kappa)
            count += found.starts
            if found.value < 0:
                break
        return replace(found, starts=count)

    def _found(self, sigma, starts, seed, near=(), task=None):
        """The result of a search for a decay of ``sigma``, or for the fastest."""
        rate = sigma or self.task.rate
        slow, task = (replace(t, rate=rate) for t in (self.slow, task or self.task))
        if sigma is not None:
            task = replace(task, goal=None)
        radius = 0.0 if sigma is None else np.exp(-sigma * self.design.T)
        size = min(1.0, rate * self.design.T)

        def objective(*asked):
            return Demanded(*asked, radius, size, self.demands)

        ways = near, objective, partial(self._begin, slow)
        return search(task, self.loops, starts, seed, *ways)

    def _asked(self, starts, seed, sigma, kappa):
        found = self._found(sigma, starts, seed, (kappa,))
        decay = self._decay(found.kappa)  # below what was asked it may be the fastest
        if found.value < 0 or (decay > 0 and not self.demands.words(found.kappa)):
            self.kept.append((decay, found.kappa))
        return found

    def _begin(self, slow, task, loops, count, rng, near):
        """Those ``near``, and those of the loop in continuous time, a task ``slow``,
        taken from tick to tick.
        """
        unit = self.continuous.units(task.rate) * self.pace
        for kappa in near:
            yield unit, kappa / unit
        for unit, x in starting_points(slow, self.continuous, count, rng, ()):
            kappa, unit = self._held(unit * x), unit * self.pace
            yield unit, task.inside(kappa) / unit

    def _held(self, kappa):
        """The free numbers of a memory whose inputs are held over a tick."""
        K, c = self.continuous.K(kappa), self.design.request.applied.parts.free
        if not c:
            return kappa
        whole = np.zeros((K.shape[1],) * 2)
        whole[:c] = np.roll(K[-c:], c, axis=1)  # what it remembers, then what it sees
        K[-c:] = np.roll(expm(whole * self.design.T)[:c], -c, axis=1)
        M = self.continuous.directions.reshape(len(kappa), -1).T
        K = K - self.continuous.first
        return np.linalg.lstsq(M, K.ravel(), rcond=None)[0]

    def _decay(self, kappa):
        """In 1/s, at the vertices; not positive where floats see none."""
        if kappa is None:
            return -np.inf
        radius = abs(np.linalg.eigvals(self.loops.at(kappa))).max()
        return -np.log(max(radius + EDGE, FLOOR)) / self.design.T

    def _best(self):
        """The fastest design that is proven, of all numbers that were found: a gain
        that is fast at the vertices may not be so between; or the last that was tried.
        """
        best = None
        for decay, kappa in sorted(self.kept, key=lambda x: -x[0]):
            if best is not None and best.status == "feasible" and best.sigma >= decay:
                break
            design = self._proven(kappa)
            if best is None or (design and design.status == "feasible"):
                best = design
        if best is not None and best.status != "feasible":  # with more cells, in time
            best = self._with_proof(best, time_limit=min(time_left(), LONGEST))
        return best

    def _proven(self, kappa):
        """The design with the free numbers in few digits that is proven, else the last
        that was tried; None where each rounding is unstable.
        """
        design = None
        for digits in DIGITS:
            rounded = self.task.inside(round_digits(kappa, digits))
            asked = [self.sigma]
            if self.sigma is None:
                fast = self._decay(rounded)
                asked = [fast * (1 - k * self.backoff) for k in EASIER]
            for sigma in (x for x in asked if x > 0):
                K = self.continuous.K(rounded)
                design = self._with_proof(replace(self.design, K=K, sigma=sigma))
                if design.status == "feasible":
                    return design
                if self.missing:  # of what is slower, too
                    break
        return design

    def _with_proof(self, design, **asked):
        rate = float(np.floor(np.exp(-design.sigma * design.T) * 1e9) / 1e9)
        proof = design.controller().certify(rate=rate, cells=self.cells, **asked)
        self.missing, kept = [], []
        for r in design.requirements if proof.proven else ():
            one, missing = proven(r, design.controller(), self.cells)
            kept.append(one)
            self.missing += missing
        status = "undecided" if self.missing or not proof.proven else "feasible"
        return replace(design, proof=proof, status=status, kept=tuple(kept))

    def _hasty(self, poles):
        """Words where a pole at the ticks is far faster than asked, or none; those that
        fall by half in a tick are of the clock.
        """
        some = poles[abs(poles) > HALF]
        lag = getattr(self.design.request.law, "filter", None)
        return hasty(np.log(some) / self.design.T, lag, ASK) if some.size else ""

    def _reason(self, kappa, best, by):
        """The words on the nearest numbers ``kappa`` and what of ``best`` isn't proven,
        which were searched ``by`` some starts.
        """
        words, decay = f"No stable loop was found by {by}.", self._decay(kappa)
        asked = "" if self.sigma is None else f" (asked: {self.sigma:.4g})"
        if decay > 0:
            decay = f"{decay:.4g} 1/s at the vertices"
            words = (
                f"The nearest gain reaches a decay of {decay}{asked}, found by {by}."
            )
        if away := self.demands.words(kappa):
            words = (
                "No gain was found that keeps all that is asked: the nearest one has "
                f"{away}, and a decay of {max(self._decay(kappa), 0.0):.4g} 1/s at the "
                f"vertices{asked}, found by {by}."
            )
        if best is not None:
            failed = [*best.proof.failed, *self.missing]
            words = f"{words} It isn't proven: {', '.join(failed)}."
        elif self._keeps(kappa):  # nothing is missing but the proof
            return words
        return f"{words} Sample faster, act earlier, measure more, or ask for less."
