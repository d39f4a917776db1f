"""Questions to a controller's loop: proofs, margins, rests, cycles and runs."""

from typing import Any

import numpy as np

from ..plants.checks import positive
from ..runtime.read_only import ReadOnly
from ..sampled.furthest import furthest_sampled
from ..sampled.proof import certify_sampled
from .describing import predicted_cycles
from .margins import Margins, margins_of
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
        T, delay = self.clock.ranges
        T, delay = asked.pop("T", T), asked.pop("delay", delay)
        return certify_sampled(self.plant, self.of_state, T, delay, **asked)

    def furthest(self, find: str = "T", most: float | None = None, **asked: Any) -> Any:
        """The longest interval, or delay, for which the program as it is is proven.

        Parameters
        ----------
        find : {"T", "delay"}
            Every sequence of intervals from T to it, the delay being as it is; or of
            delays from the present one to it.
        most : float, optional
            Up to which it is sought, in s; without it 4 T, or the tick after the
            present delay: beyond, older inputs would be others.
        **asked
            ``tolerance``, ``time_limit`` and more of `furthest_sampled`.

        Returns
        -------
        SampledProof
            Its ``T`` or ``delay`` says how far it goes. Its matrices stay those of T: a
            program for another T is that of ``design.controller(T=...)``.

        Raises
        ------
        ValueError
            If another thing is sought, or ``most`` isn't above the present value.

        Examples
        --------
        >>> import sosbook as sos
        >>> cart = sos.SecondOrderSystem(1, 0, 0, 1, coordinates=["place"])
        >>> design = sos.design_pid(cart, region=sos.PoleRegion(1, rho=9))
        >>> proof = design.controller(T=0.01).furthest(tolerance=0.1)
        >>> proof.proven, bool(proof.T[1] > 0.02)
        (True, True)
        """
        T, delay = self.clock.T, self.clock.latest
        ends = {"T": (T, LONGER * T), "delay": (delay, (delay // T + 1) * T)}
        if find not in ends:
            raise ValueError(f'find must be "T" or "delay", got {find!r}')
        low, high = ends[find]
        high = high if most is None else positive("most", most)
        if high <= low:
            raise ValueError(f"most = {high:g} s isn't above the {find} of {low:g} s")
        clock = {"T": T, "delay": delay, find: (low, high)}
        return furthest_sampled(self.plant, self.of_state, find=find, **clock, **asked)

    def margins(self, at: int | str = 0, time_limit: float = 60.0) -> Margins:
        """Gain, phase, delay and disk margins of the loop that is opened at a signal.

        Parameters
        ----------
        at : int or str
            The index of an input, or the name of an input or of what is measured.
        time_limit : float
            Seconds, after which the best until then is the answer.

        Returns
        -------
        Margins
            Each proven for every plant of the family, and seen at the worst of some;
            ``open_loop`` has the frequency response, and Bode's, Nyquist's and
            Nichols's plots. T and delay don't vary in them.

        Raises
        ------
        ValueError
            If there is no such signal, or the loop isn't stable.

        Examples
        --------
        >>> import sosbook as sos
        >>> cart = sos.SecondOrderSystem(1, 0, 0, 1, coordinates=["place"])
        >>> design = sos.design_pid(cart, region=sos.PoleRegion(1, rho=9))
        >>> found = design.controller(T=0.01, delay=0.01).margins()
        >>> 0.97 < found.phase.proven / found.phase.seen <= 1
        True
        """
        return margins_of(self, at, time_limit)

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
        x, u = zip(*(loop.at_rest(r, w) for loop in self.loops))
        return np.array(x), np.array(u)

    def cycles(self, friction: Any = None, backlash: Any = None) -> list:
        """The limit cycles that friction and a gap make, predicted: none is a proof.

        Parameters
        ----------
        friction, backlash
            As in `simulate`.

        Returns
        -------
        list of Cycle
            Of first harmonics, at all corners; empty where none balance.
        """
        return predicted_cycles(self, friction, backlash)

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
        return simulate_controller(self, seconds, r, w, **more)
