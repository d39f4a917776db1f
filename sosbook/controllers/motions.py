"""Questions to a controller about motions of its set points that don't jump."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..exact.proof import Stopped, proven_within
from ..plants.checks import finite, not_negative, positive
from ..runtime.time_limit import checked_seconds
from .bounded import SECONDS, Bounded
from .bounds import rest, stable
from .follow import per_unit
from .limits import per_signal
from .profile import Profile, fastest, quickest
from .signals import known_index
from .step_bounds import Row

BAND = 0.02  # of a way, within which a move has arrived


@dataclass(frozen=True, eq=False)
class Move:
    """A move of a set point over a ``distance``, from rest to rest, by a ``profile``.

    Parameters
    ----------
    profile : Profile
        Its limits, set points and program.
    distance : float
        In the unit of the set point.
    effort : tuple of Bounded
        The largest size of each u.
    error : Bounded
        The farthest that the output is from where it would rest, at the ticks: from
        the set point, where it is what is integrated.
    arrival : Bounded or None
        In s: after it the output stays within 2 % of its way of where it ends; None of
        one that ends where it began, as a sway does, or elsewhere for each plant.
    """

    profile: Profile
    distance: float
    effort: tuple
    error: Bounded
    arrival: Bounded | None = None

    @property
    def duration(self) -> float:
        """Seconds in which the set point moves."""
        return self.profile.duration(self.distance)

    def __str__(self):
        p = self.profile
        words = ", ".join(str(x) for x in self.effort)
        there = f"; within 2 % of its way after {self.arrival}" if self.arrival else ""
        return (
            f"{self.distance:g} {p.unit}".strip()
            + f" in {self.duration:.4g} s, at most {p.velocity:.4g} a second, "
            f"{p.acceleration:.4g} and {p.jerk:.4g} of acceleration and jerk: "
            f"u {words}; at ticks from its rest {self.error}{there}"
        )


class Motions:
    """Motions of a controller's set points within limits, and what they ask: proven.

    Parameters
    ----------
    controller : Controller
        Whose `Controller.motions` this is.
    """

    def __init__(self, controller: Any) -> None:
        self.controller = controller

    def follow(
        self,
        velocity: float,
        acceleration: float,
        jerk: float | None = None,
        set_point: int = 0,
        output: Any = None,
        time_limit: float = SECONDS,
        range: float | None = None,
    ) -> Bounded:
        """The largest distance of an output from where it would rest, at the ticks,
        for every motion of a set point within these limits, of any length.

        Parameters
        ----------
        velocity, acceleration, jerk : float
            Of the set point, per second, and so on; without ``jerk`` any.
        set_point : int
            Which one.
        output : str, int or Output, optional
            As in `OutputBounds.step_response`: of a u, by its index, its largest size.
        time_limit : float
            Seconds, after which there is no proof, or a less sharp one.
        range : float, optional
            How far from zero the set point goes: of a u that isn't zero at rest.

        Returns
        -------
        Bounded
            Proven for every plant of the loop without limits; see
            `sosbook.controllers.follow` for the theorem. No file holds it.

        Raises
        ------
        ValueError
            If ``range`` is missing: springs push back, and u holds against them.

        Examples
        --------
        >>> import sosbook as sos
        >>> cart = sos.Uncertain(lambda m: sos.SecondOrderSystem(m, 0, 0, 1), m=(1, 2))
        >>> design = sos.design_pid(cart, [[1]], region=sos.PoleRegion(1, rho=9))
        >>> c = design.controller(T=0.01)
        >>> force = c.motions.follow(9, 0.5, 2, output=0)
        >>> 1 < force.seen <= force.proven  # the heavier mass is 2
        True
        """
        names = "range", "velocity", "acceleration", "jerk"
        given = zip(names, (range, velocity, acceleration, jerk))
        size = [np.inf if x is None else not_negative(name, x)
                for name, x in given]  # fmt: skip
        units = self._units(set_point, output, time_limit)
        if range is None and units.seen[..., 0].any():
            raise ValueError(
                "range is missing: how far from zero the set point goes. Springs push "
                "back, and u holds against them where it rests"
            )
        proven, seen = units.bound(size)
        return Bounded(proven, seen, units.unit)

    def limits_for(
        self,
        u_max: Any = None,
        distance: float = 1.0,
        set_point: int = 0,
        time_limit: float = SECONDS,
        start: float = 0.0,
        error: float | None = None,
        output: Any = None,
    ) -> Profile:
        """The limits with which a ``distance`` takes least, and every other motion
        within them asks no more than ``u_max``, too.

        Parameters
        ----------
        u_max : float or dict, optional
            Of the outputs, one number or by name; the controller's own without it.
        distance, set_point
            Of a set point, and which.
        time_limit : float
            As for `follow`.
        start : float
            Where the ``distance`` begins. Where springs push back all motions stay as
            near to zero as this one.
        error : float, optional
            The farthest that an ``output`` may be from where it would rest, in its own
            unit: 0.05 of the ``distance`` leaves 5 % for an overshoot.
        output : str, int or Output, optional
            As for `follow`: a row of a sway, for example, which rests at zero.

        Raises
        ------
        ValueError
            If nothing was proven, no output has a limit, or springs ask more at rest.
        """
        asked = u_max, distance, set_point, time_limit, start, error, output
        return self._planned(fastest, *asked)[0]

    def move(
        self,
        distance: float,
        u_max: Any = None,
        set_point: int = 0,
        output: Any = None,
        time_limit: float = SECONDS,
        start: float = 0.0,
        error: float | None = None,
    ) -> Move:
        """The fastest move over a ``distance`` that was found within ``u_max``.

        Parameters
        ----------
        distance, u_max, set_point
            As for `limits_for`.
        output : str, int or Output, optional
            Of which `Move.error` speaks, as in `OutputBounds.step_response`.
        time_limit : float
            As for `follow`.
        start : float
            From where, which matters where springs push back.
        error : float, optional
            As for `limits_for`; without it the set point may be far ahead.

        Returns
        -------
        Move
            Of this one move, from rest, proven for every plant of the loop without
            limits. A shorter one within the same limits asks another u, by `follow`.

        Raises
        ------
        ValueError
            As for `limits_for`.

        Examples
        --------
        >>> import sosbook as sos
        >>> cart = sos.Uncertain(lambda m: sos.SecondOrderSystem(m, 0, 0, 1), m=(1, 2))
        >>> design = sos.design_pid(cart, [[1]], region=sos.PoleRegion(1, rho=9))
        >>> move = design.controller(T=0.01).motions.move(3.0, u_max=2.0)
        >>> move.duration > 2 * (3 * 2 / 2.0) ** 0.5, bool(move.effort[0].proven <= 2)
        (True, True)
        """
        asked = u_max, distance, set_point, time_limit, start, error, output
        profile, units = self._planned(quickest, *asked)
        r = profile.points(distance, start)
        if error is None:
            units.append(self._units(set_point, output, time_limit))
        *effort, farthest = (_of_move(p, r, profile.T) for p in units)
        c = self.controller
        ends = Row.of(c, set_point, rest(c, set_point), output).ends
        arrival = _arrival(units[-1], r, profile.T, distance * float(ends or 0))
        return Move(profile, float(distance), tuple(effort), farthest, arrival)

    def _units(self, set_point, output, seconds):
        """The `PerUnit` of an ``output``, within some ``seconds``."""
        c = self.controller
        known_index("set_point", set_point, c.set_points)
        asked = c, rest(c, set_point), set_point, output
        limit = checked_seconds(seconds, needed=True)
        found = proven_within(limit, lambda: per_unit(*asked))
        return per_unit(*asked, most=0) if isinstance(found, Stopped) else found

    def _planned(self, plan, u_max, distance, set_point, seconds, start, error, output):
        """The `Profile` that ``plan`` makes, and the `PerUnit` of each output that has
        a limit; last that of an ``output`` with an ``error``, if one is asked for.
        """
        c, distance = self.controller, positive("distance", distance)
        stable(c, "motions")
        limits = c.limits.u_max
        if u_max is not None:
            limits = per_signal("u_max", u_max, c.outputs)
        some = np.flatnonzero(np.isfinite(limits)).tolist()
        if not some:
            raise ValueError("u_max is missing: give the largest output")
        most = [*limits[some]]
        if error is not None:
            some.append(output)
            most.append(positive("error", error))
        units = [self._units(set_point, k, seconds) for k in some]
        if any(p.cells is None for p in units):
            raise ValueError(
                "u_max: no bound was proven of what motions ask: a longer time_limit "
                "may help"
            )
        unit, way = c.set_points[set_point].unit, (distance, finite("start", start))
        return plan(units, most, way, float(c.T), unit), units


def _of_move(units, r, T):
    """The `Bounded` of a `PerUnit` for one move r."""
    proven = max((k.largest(r, T) for k in units.kernels), default=None)
    seen = max((k.largest(r, T, False) for k in units.kernels), default=np.nan)
    return Bounded(proven, seen, units.unit)


def _arrival(units, r, T, way):
    """The `Bounded` time after which an output is within `BAND` of its ``way``."""
    if not way:
        return None
    band = BAND * abs(way)
    proven = [k.arrival(r, T, band) for k in units.kernels]
    seen = [k.arrival(r, T, band, False) for k in units.kernels]
    latest = max((x for x in seen if x is not None), default=np.nan)
    known = proven and None not in proven
    return Bounded(float(f"{max(proven):.12g}") if known else None, latest, "s")
