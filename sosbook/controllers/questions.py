"""Questions to a controller's loop: proofs, margins, rests and runs."""

from typing import Any

import numpy as np

from ..plants.checks import positive
from ..runtime.read_only import ReadOnly
from ..sampled.furthest import furthest_sampled
from ..sampled.proof import certify_sampled
from .margins import Margins, margins_of
from .own_ticks import proven
from .signals import vector_of
from .simulation import Run, simulate_controller

LONGER = 4.0  # times T, up to which a longer interval is sought


class Questions(ReadOnly):
    """A `Controller`'s loop, asked."""

    plant: Any
    clock: Any
    loops: Any
    of_state: Any
    R: Any

    @property
    def radius(self) -> float:
        """The largest spectral radius of the vertices' loops, in floats."""
        return max(loop.radius for loop in self.loops)

    def certify(self, **asked: Any) -> Any:
        """Prove the sampled loop, with its memory and its delay, for every plant.

        Parameters
        ----------
        **asked
            Of `certify_sampled`; ``T`` and ``delay`` are the clock's, or other ranges.
            Of a plant of discrete time ``norm``, ``rate`` and ``time_limit`` alone.

        Returns
        -------
        SampledProof
            Of the linear loop: limits and quantisation are no part of it. B R, D R, B N
            and D N, of the noise N of a law's readings, are doubles, as its file shows.
            Of a plant of discrete time a `DesignProof` without such roundings, see
            `sosbook.controllers.own_ticks`.
        """
        return certified(self, asked)

    def furthest(self, find: str = "T", most: float | None = None, **asked: Any) -> Any:
        """The longest interval, or delay, for which the program as it is is proven.

        Parameters
        ----------
        find : {"T", "delay"}
            Every sequence of intervals from T to it; or of delays from the present one.
        most : float, optional
            Up to which it is sought, in s; without it 4 T, or the tick after the delay.
        **asked
            ``tolerance``, ``time_limit`` and more of `furthest_sampled`.

        Returns
        -------
        SampledProof
            Its ``T`` or ``delay`` says how far it goes, with the program as it is.

        Raises
        ------
        ValueError
            If another thing is sought, or ``most`` isn't above the present value.
        """
        return furthest_of(self, find, most, asked)

    def margins(
        self, at: int | str = 0, time_limit: float = 60.0, *, sharp: bool = True
    ) -> Margins:
        """Gain, phase, delay and disk margins of a stable loop, opened at a signal.

        Parameters
        ----------
        at : int or str
            The index of an input, or the name of an input or of what is measured.
        time_limit : float
            Seconds, after which the best until then is the answer.
        sharp : bool
            Without it gains are those of the disks for the others alone, and no delay
            is looked for, which takes a tenth of the time.

        Returns
        -------
        Margins
            Each proven for every plant of the family, and seen at the worst of some;
            ``open_loop`` has the plots. T and delay don't vary in them.
        """
        return margins_of(self, at, time_limit, sharp)

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
        r = vector_of("r", r, self.R.shape[1])
        w = vector_of("w", w, self.plant.p)
        if self.radius >= 1:
            raise ValueError("this loop isn't stable at its ticks: it rests nowhere")
        x, u = zip(*(loop.at_rest(r, w) for loop in self.loops))
        return np.array(x), np.array(u)

    def simulate(
        self, seconds: float, r: Any = None, w: Any = None, **more: Any
    ) -> Run:
        """Run its program against every vertex, or against other plants.

        Parameters
        ----------
        seconds : float
            How long.
        r, w : array_like or callable, optional
            Set points and disturbances, constant or functions of the time. A program
            knows no velocity of a set point: where r moves, its u is that of the loop
            in continuous time without K_D r'.
        **more
            ``x0``, at the start; ``plants``, others than the vertices, as `Descriptor`;
            ``friction``, Coulomb's on each coordinate; ``backlash``, a `Backlash`;
            ``program``, for `Replay`; ``lose``, from a tick to whether its sample is.

        Returns
        -------
        Run
            It proves nothing. Encoders have their steps.
        """
        return simulate_controller(self, seconds, r, w, **more)


def certified(c, asked):
    """The proof of `Questions.certify` for a controller c and what is ``asked``."""
    if c.timing.steps:
        return proven(c, asked)
    asked = dict(zip(("T", "delay"), c.clock.ranges)) | asked
    return certify_sampled(c.plant, c.of_state, **asked)


def furthest_of(c, find, most, asked):
    """The proof of `Questions.furthest` for a controller c: ``find``, ``most`` and what
    else is ``asked``.
    """
    if c.timing.steps:
        return proven(c, {"furthest": find})  # raises
    T, delay = c.clock.T, c.clock.latest
    ends = {"T": (T, LONGER * T), "delay": (delay, (delay // T + 1) * T)}
    if find not in ends:
        raise ValueError(f'find must be "T" or "delay", got {find!r}')
    low, high = ends[find]
    high = high if most is None else positive("most", most)
    if high <= low:
        raise ValueError(f"most = {high:g} s isn't above the {find} of {low:g} s")
    clock = {"T": T, "delay": delay, find: (low, high)}
    return furthest_sampled(c.plant, c.of_state, find=find, **clock, **asked)
