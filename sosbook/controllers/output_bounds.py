"""Bounds of what sensors and set points do to the outputs of a controller."""

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from flint import arb

from ..exact.proof import Stopped, proven_within
from ..exact.rational import exact
from ..plants.checks import count, positive
from ..runtime.time_limit import checked_seconds
from .bounded import SECONDS, Bounded
from .bounds import at_rest, bounded_output, rest, rounded, sizes_of
from .limits import per_signal, quantum
from .rounding import rounding_bound
from .signals import known_index
from .step_bounds import StepBounds, step_bounds
from .weights import weighted
from .windup import Reach, proven_reach


class OutputBounds:
    """The bounds of a ``controller``'s outputs: proven for every plant.

    Each bound is of the linear loop, but for `reach`. ``controller.bounds`` is one.

    Parameters
    ----------
    controller : Controller
        Whose outputs are bounded.

    Examples
    --------
    >>> import sosbook as sos
    >>> cart = sos.SecondOrderSystem(1, 0, 0, 1)
    >>> design = sos.design_pid(cart, region=sos.PoleRegion(1, rho=9))
    >>> bounds = design.controller(T=0.01).bounds
    >>> print(bounds.largest_step(1.0) * bounds.step().proven <= 1)
    True
    """

    def __init__(self, controller: Any) -> None:
        """Of which controller."""
        self.controller = controller

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
        c, steps = self.controller, self.controller.readings.steps
        known_index("output", output, c.outputs)
        if counts is not None:
            steps = quantum(counts, c.readings.signals)
        off = steps * (0.5 + 2.0**-52)  # what 2 pi / counts lacks by rounding, too
        known = np.flatnonzero(off > 0)

        def work():
            total = arb(0)
            for k in known:
                found = bounded_output(c, c.B[:, [k]], c.D[:, [k]], output)
                if found is None:
                    return None
                total += arb(float(off[k])) * arb(found)
            return rounded(total, np.inf)

        sizes = [sizes_of(x, x.noise, x.direct, output).sum(axis=0) for x in c.loops]
        seen = max(float(h[known] @ off[known]) for h in sizes)
        return Bounded.within(time_limit, work, seen, c.outputs[output].unit)

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
        size = exact(positive("speed", speed)) * exact(self.controller.T)
        return self._of_motion(size, set_point, output, time_limit)

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
            As for `step_response`, which answers where springs push back.
        """
        c, size = self.controller, exact(positive("size", size))
        known_index("set_point", set_point, c.set_points)
        known_index("output", output, c.outputs)
        if rest(c, set_point) is None:
            asked = float(size), set_point, None
            return self.step_response(*asked, time_limit=time_limit).effort[output]
        return self._of_motion(size, set_point, output, time_limit, peak=True)

    def step_response(
        self,
        size: float = 1.0,
        set_point: int = 0,
        output: Any = None,
        band: float = 0.02,
        cells: int = 256,
        time_limit: float = SECONDS,
    ) -> StepBounds:
        """Overshoot, settling time and more of a step from rest, for every plant.

        Parameters
        ----------
        size : float
            Of the step, in the unit of the set point.
        set_point : int
            Which one.
        output : str, int or Output, optional
            Of what: a coordinate, a speed or a reading by its name, the index of a u,
            or one row; without it what the set point is of.
        band : float
            What counts as settled, as a share of the step.
        cells : int
            Into how many parts the family is cut, at most: more are sharper.
        time_limit : float
            Seconds, after which there is no proof, or a less sharp one.

        Returns
        -------
        StepBounds
            Each number proven for every plant, and seen at some; see
            `sosbook.controllers.tube` for the theorem. No file holds this proof: one
            program, this package, has made it.

        Raises
        ------
        ValueError
            Where no row is an output, or springs push back and the output isn't one
            that is integrated: then it ends elsewhere for each plant.
        """
        c = self.controller
        known_index("set_point", set_point, c.set_points)
        x = rest(c, set_point)
        asked = c, x, size, set_point, output, band
        work = partial(step_bounds, *asked, count("cells", cells, least=1))
        found = proven_within(checked_seconds(time_limit, needed=True), work)
        return step_bounds(*asked, 0) if isinstance(found, Stopped) else found

    def weights(
        self,
        overshoot: float = 0.05,
        effort: float | None = None,
        *,
        size: float = 1.0,
        set_point: int = 0,
        output: Any = None,
        band: float = 0.02,
    ) -> Any:
        """The controller with the b of `Controller.set_point` that settles soonest.

        Parameters
        ----------
        overshoot, effort : float
            The most of every plant: a share of the step, and of each u, if given.
        size, set_point, output, band
            As in `step_response`, by which it is proven.

        Returns
        -------
        Controller
            Proven for every plant.

        Raises
        ------
        ValueError
            If no b does it, which two plants then prove, or none was proven.
        """
        return weighted(
            self.controller, overshoot, effort, size, set_point, output, band
        )

    def _of_motion(self, size, set_point, output, seconds, peak=False):
        """The `Bounded` of an ``output`` while ``set_point`` moves by ``size`` a tick,
        or at its step (``peak``); ``seconds`` for the proof.
        """
        x, c = at_rest(self.controller, set_point), self.controller
        known_index("output", output, c.outputs)
        own, direct = c.B_r[:, [set_point]], c.D_r[:, [set_point]]

        def work():
            found = bounded_output(c, own, direct, output, -x, peak)
            return None if found is None else rounded(arb(size) * arb(found), np.inf)

        most, moved = np.max if peak else np.sum, (-x.astype(float), 0 * direct)
        seen = max(most(sizes_of(loop, *moved, output)) for loop in c.loops)
        unit = c.outputs[output].unit
        return Bounded.within(seconds, work, float(size) * float(seen), unit)

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
        c = self.controller
        unit = c.outputs[output].unit
        work = partial(rounding_bound, c, precision, range, speed, output)
        return Bounded.within(time_limit, work, np.nan, unit)

    def reach(
        self, set_point: int = 0, seconds: float = 30.0, asked: Any = None
    ) -> Reach:
        """Which steps settle although the output is limited: see `Reach`.

        Parameters
        ----------
        set_point : int
            Which one.
        seconds : float
            After which the best that was proven is the answer.
        asked : float or dict, optional
            The most that a motion by itself asks of each output: see `Motions.follow`.
            Then such steps settle at any time of it, and it goes on as without them.
        """
        c = self.controller
        if not np.isfinite(c.limits.u_max).all():
            raise ValueError("u_max is missing: limit every output first")
        known_index("set_point", set_point, c.set_points)
        if asked is not None:
            # where |u_p| <= U, sat(u_p + e) - u_p is e for |e| <= u_max - U, never
            # beyond e, and at least (1 - kappa) e up to (u_max - U) / (1 - kappa)
            most = per_signal("asked", asked, c.outputs)
            left = [rounded(arb(a) - arb(b), 0) for a, b in zip(c.limits.u_max, most)]
            if not min(left) > 0:
                raise ValueError(
                    f"asked = {asked!r} leaves nothing of u_max = {c.limits.u_max}: "
                    "move more gently"
                )
            c = replace(c, limits=replace(c.limits, u_max=np.array(left)))
        return proven_reach(c, set_point, seconds)
