"""PID on what is measured: proportional, rate and integral gains of the sensors."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..exact.rational import exact
from ..plants.checks import matrix, positive
from ..plants.outputs import Output
from ..runtime.array_like import ArrayLike
from .base import (
    MODELS,
    Law,
    Parts,
    checked_limits,
    checked_outputs,
    listed,
    seeing_rows,
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
        a word such as "a" for one that others share ("-a": minus that), (low, high)
        for one in this range, where None is an open end, and (x, x) for x itself. One
        for all gains, or by name: ``{"K_P": ..., "K_D": ...}``.
    limits : dict, optional
        The largest size of an entry, by name: ``{"K_P": 200}``.
    noise : (q, p) array_like, optional
        How the disturbance w enters the measured positions, or ``sensors``.
    sensors : Output, optional
        In the place of position: any q rows on what the plant does, accelerations and
        forces among them; y is what these sensors say.
    lag : float, optional
        The time constant, in s, of those sensors that see x' or u: they jump with u,
        as no sensor does, and there is no loop without it.

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

    sensors: Any = None
    rates: Any = None
    integrate: Any = False
    filter: float | None = None
    form: Any = None
    limits: Any = None
    noise: Any = None
    lag: float | None = None

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
        sensors: Output | None = None,
        lag: float | None = None,
    ) -> None:
        """Check the arguments and keep them read-only."""
        seen = checked_outputs(position, velocity, sensors, noise, lag)
        if filter is not None:
            filter = positive("filter", filter)
            if velocity is not None:
                raise ValueError(
                    "filter and velocity are given: measured velocities need no filter"
                )
        kept = dict(
            **seen,
            integrate=integrate,
            filter=filter,
            form=structure,
            limits=checked_limits(limits, (*NAMES, MODELS)),
        )
        if seen["sensors"] is None:
            for name in ("integrate", "filter", "noise"):
                if kept[name] is not None and kept[name] is not False:
                    raise ValueError(f"{name} is given without position")
        if integrate is None:
            raise ValueError("integrate must be True, False or rows, got None")
        if not isinstance(integrate, bool):
            columns = None if position is None else np.shape(position)[0]
            kept["integrate"] = seeing_rows("integrate", integrate, columns)
        for name, value in kept.items():
            object.__setattr__(self, name, value)
        self.__post_init__()

    def _mixtures(self, q):
        """The integrated signals, as rows on q readings that aren't rates."""
        if isinstance(self.integrate, bool):
            return np.eye(q if self.integrate else 0, q)
        return matrix("integrate", self.integrate, (None, q))

    def parts(self, plant: Any) -> Parts:
        """The integrals and the filters that the law joins to a ``plant``."""
        plant, law = self.on(plant)
        if law is not self:
            return law.parts(plant)
        seen = self.readings(plant)
        words, s, q = seen.names, len(seen), seen.first
        mixed = self._mixtures(q)
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
        rows, noise, E, A, B = map(exact, (seen.C, seen.Dw, E, A, B))
        said = words, (*names, *lagged), (*words, *rates, *names)
        return Parts(rows, noise, E, A, B, of_sensors, of_states, 0, *said, a)

    def structure(self, plant: Any) -> Structure:
        seen = self.readings(plant)
        s, q = len(seen), seen.first
        d = q if self.filter is not None else s - q
        a = len(self._mixtures(q))
        spans = {"K_P": (0, q), "K_D": (q, q + d), "K_I": (q + d, q + d + a)}
        rows = 0, plant.m
        places = {k: (rows, span) for k, span in spans.items() if span[1] > span[0]}
        return placed((plant.m, q + d + a), places, self.form, self.limits)

    def words(self, plant: Any) -> str:
        """Its sensors by the names of a ``plant``, and its kind."""
        seen = self.readings(plant)
        kind = ("P" if seen.first else "") + "I" * bool(len(self._mixtures(seen.first)))
        rate = self.rates is not None or self.filter is not None
        lag = "" if self.filter is None else f" with a filter of {self.filter:g} s"
        return f"u depends on {listed(seen.names)}: {kind}{'D' * rate}{lag}"


def _mix(row, words):
    shares = [f"{x:g} ({w})" if x != 1 else w for x, w in zip(row, words) if x]
    return " + ".join(shares)
