"""The answers of a controller: its loop, proofs, bounds, motions and program."""

from functools import cached_property, partial
from typing import Any

import numpy as np
from flint import arb

from ..exact.rational import exact
from ..plants.checks import positive
from ..plants.gain import signals
from ..runtime.libraries import library
from ..sampled.proof import certify_sampled
from ..sampled.system import SampledSystem
from ..sampled.ticks import Ticks
from .bounded import SECONDS, Bounded, of_motion, of_noise
from .bounds import rest, rounded
from .describing import predicted_cycles
from .facts import facts_of
from .limits import quantum
from .program import Code
from .rounding import rounding_bound
from .signals import NOTHING_TO_SET, known_index, vector_of
from .simulation import Run, simulate_controller
from .windup import Reach, proven_reach


class Answers:
    """The questions that a `Controller` answers."""

    A: Any
    B: Any
    B_r: Any
    C: Any
    clock: Any
    D: Any
    D_r: Any
    R: Any
    T: float
    delay: float
    limits: Any
    measured: tuple
    outputs: tuple
    parts: Any
    plant: Any
    noise_rows: Any
    rows: Any
    set_points: Any
    steps: Any
    timing: Any
    vertices: tuple

    @property
    def sampled(self) -> SampledSystem:
        """From y to u, as `certify_sampled` takes a controller of x = y."""
        return SampledSystem(self.A, self.B, self.C, self.D, self.T)

    @cached_property
    def of_state(self) -> SampledSystem:
        """From the plant's state x, and from w by what is read, to u: see `certify`."""

        def of(rows):
            return (np.asarray(exact(M) @ exact(rows), float) for M in (self.B, self.D))

        B, D = of(self.rows)
        B_w, D_w = of(self.noise_rows) if self.noise_rows.any() else (None, None)
        names = signals(self.plant), tuple(s.name for s in self.outputs)
        return SampledSystem(self.A, B, self.C, D, self.T, B_w, D_w, *names)

    def to_ss(self) -> Any:
        """python-control's StateSpace from [y; r] to u, with names.

        A point in a name is "_" there: "z1 - 0_5 z2".
        """
        inputs = [s.name.replace(".", "_") for s in (*self.measured, *self.set_points)]
        names = dict(inputs=inputs, outputs=[s.name for s in self.outputs])
        B, D = np.hstack([self.B, self.B_r]), np.hstack([self.D, self.D_r])
        return library("control").ss(self.A, B, self.C, D, self.T, **names)

    def loop(self, d: Any) -> Ticks:
        """The sampled loop with a plant d, a `Descriptor` without integrators."""
        return Ticks.of(self.parts, self.rows, self.timing, d, self.noise_rows)

    @cached_property
    def loops(self) -> list:
        """The sampled loops with the plant's vertices."""
        return [self.loop(d) for d in self.vertices]

    @property
    def radius(self) -> float:
        """The largest spectral radius of the vertices' loops, in floats."""
        return max(loop.radius for loop in self.loops)

    def sensitivity_peak(self) -> float:
        """The largest sensitivity at the plant's input, over the vertices, in floats.

        Sampled: with the hold, the delay and the estimate.
        """
        return max(loop.sensitivity_peak for loop in self.loops)

    def certify(self, **asked: Any) -> Any:
        """Prove the sampled loop, with its memory and its delay, for every plant.

        Parameters
        ----------
        **asked
            ``rate``, ``cells``, ``time_limit`` and more of `certify_sampled`; T and
            ``delay`` as ranges (low, high) prove it for a clock that jitters, as do
            ``jitter`` and a range of delays of `Gains.controller`.

        Returns
        -------
        SampledProof
            Of the linear loop: limits and quantisation are no part of it. B R and D R
            are rounded to doubles, as its file shows them; so are B N and D N of a
            law whose ``noise`` N brings w into the readings.
        """
        clock = (self.T, self.delay) if self.clock is None else self.clock
        T, delay = (asked.pop(x, of) for x, of in zip(("T", "delay"), clock))
        return certify_sampled(self.plant, self.of_state, T, delay, **asked)

    def static(self, r: Any = None, w: Any = None) -> tuple:
        """Where every vertex comes to rest, and what it asks there.

        Parameters
        ----------
        r : (p,) array_like, optional
            Set points.
        w : (p_w,) array_like, optional
            Constant disturbances, of the plant's F and of what is measured.

        Returns
        -------
        (vertices, N) and (vertices, m) arrays
            The plant's state and the outputs. A load on what isn't measured leaves an
            error there, which no integral of another signal takes away.
        """
        x, u = [], []
        for d, loop in zip(self.vertices, self.loops):
            p = self.R.shape[1]
            r_now = vector_of("r", r, p)
            w_now = vector_of("w", w, d.Bw.shape[1])
            push = loop.set_point @ r_now + loop.load @ w_now
            rest = np.linalg.solve(np.eye(len(loop.F)) - loop.F, push)
            x.append(rest[: len(d.E)])
            u.append(loop.H @ rest + loop.direct_r @ r_now + loop.direct_w @ w_now)
        return np.array(x), np.array(u)

    def noise(
        self, counts: Any = None, output: int = 0, time_limit: float = SECONDS
    ) -> Bounded:
        """How far the steps of the sensors move an output, at the worst.

        Parameters
        ----------
        counts : float or dict, optional
            Of encoders, by name; those that the controller was made for without.
        output : int
            Which output.
        time_limit : float
            Seconds, after which nothing is said but what the corners do.

        Returns
        -------
        Bounded
            A reading is off by half a step at most, as it pleases, at every tick.
        """
        steps = self.steps if counts is None else quantum(counts, self.measured)
        off = steps * (0.5 + 2.0**-52)  # what 2 pi / counts lacks by rounding, too
        return of_noise(self, off, output, time_limit)

    def ramp(
        self,
        speed: float = 1.0,
        set_point: int = 0,
        output: int = 0,
        time_limit: float = SECONDS,
    ) -> Bounded:
        """The largest output while a set point moves.

        Parameters
        ----------
        speed : float
            The set point moves no faster than this per second, as it pleases.
        set_point, output : int
            Which ones.
        time_limit : float
            As for `noise`.

        Raises
        ------
        ValueError
            Where the output at rest isn't exactly zero, as where springs push back:
            then where it goes counts, too.
        """
        size = exact(positive("speed", speed)) * exact(self.T)
        x = self._at_rest(set_point)
        return of_motion(self, x, size, set_point, output, time_limit)

    def step(
        self,
        size: float = 1.0,
        set_point: int = 0,
        output: int = 0,
        time_limit: float = SECONDS,
    ) -> Bounded:
        """The largest output after a step of a set point from rest.

        Parameters
        ----------
        size : float
            Of the step.
        set_point, output : int
            Which ones.
        time_limit : float
            As for `noise`.

        Raises
        ------
        ValueError
            As for `ramp`.
        """
        size = exact(positive("size", size))
        x = self._at_rest(set_point)
        return of_motion(self, x, size, set_point, output, time_limit, peak=True)

    def _at_rest(self, set_point):
        known_index("set_point", set_point, self.set_points)
        x = rest(self, set_point)
        if x is None:
            raise ValueError(
                "set_point: where it rests the output isn't exactly zero for every "
                "plant (springs push back, or a memory without integrals has rounded "
                "numbers), so what a motion asks depends on where it ends; see "
                "static(r=...)"
            )
        return x

    def largest_step(self, u_max: float, time_limit: float = SECONDS) -> float:
        """The largest step of the first set point that asks no more: proven.

        A larger one may do, too: the bound of `step` is above what corners ask.

        Parameters
        ----------
        u_max : float
            Of the first output, which then acts as if it had no limit.
        time_limit : float
            As for `noise`.
        """
        return self._largest(self.step(time_limit=time_limit), u_max)

    def ramp_for(self, u_max: float, time_limit: float = SECONDS) -> float:
        """How fast the first set point may move, as it pleases: proven, per second.

        Parameters
        ----------
        u_max : float
            As for `largest_step`.
        time_limit : float
            As for `noise`.
        """
        return self._largest(self.ramp(time_limit=time_limit), u_max)

    @staticmethod
    def _largest(bound, u_max):
        if bound.proven is None:
            raise ValueError(f"u_max: no bound was proven: {bound}")
        return rounded(exact(positive("u_max", u_max)) / arb(bound.proven), 0)

    def rounding(
        self,
        precision: str = "single",
        *,
        range: float,
        speed: float,
        output: int = 0,
        time_limit: float = SECONDS,
    ) -> Bounded:
        """The largest error of an output by the program's rounding.

        Parameters
        ----------
        precision : {"double", "single"}
            Of the program.
        range, speed : float
            How far from zero the set point goes, from rest, and how fast.
        output : int
            Which one.
        time_limit : float
            As for `noise`.

        Returns
        -------
        Bounded
            To first order in the rounding of one operation, as long as no limit is
            reached; for every plant and every time.

        Raises
        ------
        ValueError
            As for `ramp`.
        """
        unit = self.outputs[output].unit
        work = partial(rounding_bound, self, precision, range, speed, output)
        return Bounded.within(time_limit, work, np.nan, unit)

    def cycles(self, friction: Any = None, backlash: Any = None) -> list:
        """The limit cycles that friction and a gap make, predicted: none is a proof.

        Parameters
        ----------
        friction : (n,) array_like, optional
            Coulomb's friction on each coordinate.
        backlash : Backlash, optional
            A gap between two coordinates.

        Returns
        -------
        list of Cycle
            Of first harmonics, at all corners; empty where none balance. `simulate`
            takes both, too.
        """
        return predicted_cycles(self, friction, backlash)

    def reach(self, set_point: int = 0, seconds: float = 30.0) -> Reach:
        """Which steps settle although the output is limited: see `Reach`.

        Parameters
        ----------
        set_point : int
            Which one.
        seconds : float
            After which the best that was proven is the answer.
        """
        if not np.isfinite(self.limits.u_max).all():
            raise ValueError("u_max is missing: limit every output first")
        known_index("set_point", set_point, self.set_points)
        return proven_reach(self, set_point, seconds)

    def simulate(
        self, seconds: float, r: Any = None, w: Any = None, **more: Any
    ) -> Run:
        """Run its program against every vertex, or against other plants.

        Parameters
        ----------
        seconds : float
            How long.
        r, w : array_like or callable, optional
            Set points and disturbances, constant or functions of the time.
        **more
            ``x0``, the state at the start; ``plants``, others than the vertices, as
            `Descriptor`; ``friction``, Coulomb's on each coordinate; ``backlash``, a
            `Backlash`; ``program``, in the place of `Replay`; ``lose``, from a tick's
            number to whether its sample is lost.

        Returns
        -------
        Run
            It proves nothing. Encoders have their steps.
        """
        if r is not None and not self.set_points:
            raise ValueError(NOTHING_TO_SET)
        return simulate_controller(self, seconds, r, w, **more)

    def to_c(
        self,
        name: str = "axis",
        precision: str = "double",
        time_limit: float = 60.0,
        step: Any = None,
    ) -> Code:
        """Its program in C99, with what is proven, bounded and simulated of it.

        Parameters
        ----------
        name : str
            Of the files, and in front of every identifier.
        precision : {"double", "single"}
            Of all arithmetic; single for boards without wide floats.
        time_limit : float
            Seconds for the proof of the sampled loop.
        step : float or (p,) array_like, optional
            Of each set point, that is bounded and simulated; without it the largest
            that is known to stay within the limits, and 1 without limits.

        Returns
        -------
        Code
            `Code.write` makes the files; `Code.texts` has them.
        """
        Code(self, name, precision)  # a bad name is said before anything is proven
        return Code(self, name, precision, *facts_of(self, time_limit, step))
