"""PID on what is measured: proportional, rate and integral gains of the sensors."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..exact.rational import exact
from ..plants.checks import matrix, positive
from ..runtime.array_like import ArrayLike
from .base import (
    Law,
    Parts,
    checked_limits,
    checked_sensors,
    listed,
    noise_rows,
    sensor_rows,
)
from .structure import Structure, placed

NAMES = "K_P", "K_D", "K_I"


@dataclass(frozen=True, eq=False)
class PIDLaw(Law):
    """u = K_P y + K_D y' + K_I (integral of y), of measured positions y.

    Parameters
    ----------
    position : (q, n) array_like, optional
        Measured positions, y = position z, one row for each sensor; of a
        `DescriptorSystem` (q, N) rows on its state.
    velocity : (r, n) array_like, optional
        Measured velocities, velocity z'; K_D multiplies them.
    integrate : bool or (a, q) array_like
        Whether every y is integrated, or which mixtures of them.
    filter : float, optional
        Time constant in s: K_D multiplies y' after the filter 1 / (filter s + 1).
        Without ``filter`` and ``velocity`` there is no K_D.
    structure : None, "diagonal", nested list or dict
        Which entries of the gains are free: 0 for none, 1 for a number of its own,
        a word such as "a" for one that others share ("-a": minus that). One for
        all gains, or by name: ``{"K_P": ..., "K_D": ...}``.
    limits : dict, optional
        The largest size of an entry, by name: ``{"K_P": 200}``.
    noise : (q, p) array_like, optional
        How the disturbance w enters the measured positions.

    Raises
    ------
    ValueError
        If a sensor sees nothing, the filter isn't positive, or no gain is free. What
        depends on the plant is said when a design is asked for.

    Examples
    --------
    >>> import sosbook as sos
    >>> law = PIDLaw(position=[[1, 0]], integrate=True, filter=0.02)
    >>> one = np.eye(2)
    >>> plant = sos.SecondOrderSystem(one, one, one, [[1], [0]])
    >>> law.words(plant)
    'u depends on z1 alone: PID with a filter of 0.02 s'
    """

    position: Any = None
    velocity: Any = None
    integrate: Any = False
    filter: float | None = None
    form: Any = None
    limits: Any = None
    noise: Any = None

    def __init__(
        self,
        position: ArrayLike | None = None,
        velocity: ArrayLike | None = None,
        *,
        integrate: bool | ArrayLike = False,
        filter: float | None = None,
        structure: Any = None,
        limits: dict | None = None,
        noise: ArrayLike | None = None,
    ) -> None:
        if position is None and velocity is None:
            raise ValueError(
                "position is missing: say what is measured, one row for each sensor"
            )
        if filter is not None:
            filter = positive("filter", filter)
            if velocity is not None:
                raise ValueError(
                    "filter and velocity are given: measured velocities need no filter"
                )
        kept = dict(
            position=checked_sensors("position", position),
            velocity=checked_sensors("velocity", velocity),
            integrate=integrate,
            filter=filter,
            form=structure,
            limits=checked_limits(limits, NAMES),
            noise=None if noise is None else matrix("noise", noise),
        )
        if position is None:
            for name in ("integrate", "filter", "noise"):
                if kept[name] is not None and kept[name] is not False:
                    raise ValueError(f"{name} is given without position")
        if integrate is None:
            raise ValueError("integrate must be True, False or rows, got None")
        if not isinstance(integrate, bool):
            rows = len(kept["position"])
            kept["integrate"] = checked_sensors("integrate", integrate, rows)
        for name, value in kept.items():
            object.__setattr__(self, name, value)
        self.__post_init__()

    def _mixtures(self):
        """What is integrated, as rows on the measured positions."""
        if isinstance(self.integrate, bool):
            q = len(self.position) if self.integrate else 0
            return np.eye(q) if q else np.zeros((0, len(self._positions())))
        return self.integrate

    def _positions(self):
        return np.zeros((0, 1)) if self.position is None else self.position

    def parts(self, plant: Any) -> Parts:
        rows, words, q = sensor_rows(plant, self.position, self.velocity)
        s, mixed = len(rows), self._mixtures()
        a, f = len(mixed), q if self.filter is not None else 0
        one, zero = np.eye, np.zeros
        E, A, B = one(a + f), zero((a + f, a + f)), zero((a + f, s))
        B[:a, :q] = mixed
        of_sensors = exact(np.vstack([one(s), zero((f + a, s))]))
        of_states = exact(zero((s + f + a, a + f)))
        of_states[s + f :, :a] = exact(one(a))
        names = [f"integral of {_mix(row, words)}" for row in mixed]
        lagged = []
        if self.filter is not None:
            E[a:, a:] = self.filter * one(f)
            A[a:, a:], B[a:, :q] = -one(f), one(f)
            fast = exact(one(f)) / exact(self.filter)
            of_sensors[s : s + f, :q], of_states[s : s + f, a:] = fast, -fast
            lagged = [f"filtered {w}" for w in words[:q]]
        rates = [f"rate of {w}" for w in words[:q]] if f else []
        E, A, B = map(exact, (E, A, B))
        seen = rows, noise_rows(self.noise, s, q, plant.p)
        said = words, (*names, *lagged), (*words, *rates, *names)
        return Parts(*seen, E, A, B, of_sensors, of_states, 0, *said, a)

    def structure(self, plant: Any) -> Structure:
        q = len(self._positions())
        s = q + (0 if self.velocity is None else len(self.velocity))
        d = q if self.filter is not None else s - q
        a = len(self._mixtures())
        spans = {"K_P": (0, q), "K_D": (q, q + d), "K_I": (q + d, q + d + a)}
        rows = 0, plant.m
        places = {k: (rows, span) for k, span in spans.items() if span[1] > span[0]}
        return placed((plant.m, q + d + a), places, self.form, self.limits)

    def words(self, plant: Any) -> str:
        """Its sensors by the names of a ``plant``, and its kind."""
        _, words, _ = sensor_rows(plant, self.position, self.velocity)
        rate = self.velocity is not None or self.filter is not None
        kind = ("P" if self.position is not None else "") + "I" * bool(
            len(self._mixtures())
        )
        lag = "" if self.filter is None else f" with a filter of {self.filter:g} s"
        return f"u depends on {listed(words)}: {kind}{'D' * rate}{lag}"


def _mix(row, words):
    shares = [f"{x:g} ({w})" if x != 1 else w for x, w in zip(row, words) if x]
    return " + ".join(shares)
