"""A controller with states of its own, all of whose numbers are free."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..exact.rational import exact
from ..plants.checks import count, matrix
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

NAMES = "A_c", "B_c", "C_c", "D_c"
MOST_STATES = 100  # whose A_c has 10,000 numbers, more than any search moves


@dataclass(frozen=True, eq=False)
class DynamicLaw(Law):
    """x_c' = A_c x_c + B_c y, u = C_c x_c + D_c y, with numbers that are free.

    A state feedback with an observer is one of the plant's order.

    Parameters
    ----------
    order : int
        Number of states x_c, from 1 to 100.
    position, velocity : (q, n) array_like, optional
        What is measured, as in `PIDLaw`; y has the positions first.
    strictly_proper : bool
        Whether D_c is zero, so that u doesn't jump with y.
    structure : dict, optional
        Which entries are free, by name, as in `PIDLaw`: ``{"A_c": "diagonal"}``.
    limits : dict, optional
        The largest size of an entry, by name.
    noise : (q, p) array_like, optional
        How the disturbance w enters the measured positions.

    Raises
    ------
    ValueError
        If the order isn't a whole number from 1 to 100, or nothing is measured.

    Examples
    --------
    >>> import sosbook as sos
    >>> one = np.eye(2)
    >>> plant = sos.SecondOrderSystem(one, one, one, [[1], [0]])
    >>> DynamicLaw(order=3, position=[[0, 1]]).words(plant)
    'u depends on z2 alone: a controller of order 3'
    """

    order: int
    position: Any = None
    velocity: Any = None
    strictly_proper: bool = True
    form: Any = None
    limits: Any = None
    noise: Any = None

    def __init__(
        self,
        order: int,
        position: ArrayLike | None = None,
        velocity: ArrayLike | None = None,
        *,
        strictly_proper: bool = True,
        structure: dict | None = None,
        limits: dict | None = None,
        noise: ArrayLike | None = None,
    ) -> None:
        if count("order", order) == 0:
            raise ValueError(
                "order is 0: a DynamicLaw has states; take PIDLaw(position=...) for "
                "a controller without"
            )
        if order > MOST_STATES:
            raise ValueError(
                f"order must be {MOST_STATES} or less, got {order}: reduce the plant "
                "or the controller first"
            )
        if not isinstance(strictly_proper, bool):
            raise ValueError(
                f"strictly_proper must be True or False, got {strictly_proper!r}"
            )
        if position is None and velocity is None:
            raise ValueError(
                "position is missing: say what is measured, one row for each sensor"
            )
        if structure is not None and not isinstance(structure, dict):
            raise ValueError(
                f"structure must be a dict by name ({', '.join(NAMES)}), got "
                f"{structure!r}"
            )
        for name, value in dict(
            order=int(order),
            position=checked_sensors("position", position),
            velocity=checked_sensors("velocity", velocity),
            strictly_proper=strictly_proper,
            form=structure,
            limits=checked_limits(limits, NAMES),
            noise=None if noise is None else matrix("noise", noise),
        ).items():
            object.__setattr__(self, name, value)
        self.__post_init__()

    def parts(self, plant: Any) -> Parts:
        rows, words, q = sensor_rows(plant, self.position, self.velocity)
        s, c = len(rows), self.order
        states = tuple(f"xc{k + 1}" for k in range(c))
        seen, eye, zero = s + c, np.eye, np.zeros
        parts = eye(c), zero((c, c)), zero((c, s)), eye(seen, s), eye(seen, c, -s)
        E, A, B, take, stay = map(exact, parts)
        noise, said = noise_rows(self.noise, s, q, plant.p), (*words, *states)
        return Parts(rows, noise, E, A, B, take, stay, c, words, states, said)

    def structure(self, plant: Any) -> Structure:
        m, c = plant.m, self.order
        s = sum(len(x) for x in (self.position, self.velocity) if x is not None)
        places = {
            "A_c": ((m, m + c), (s, s + c)),
            "B_c": ((m, m + c), (0, s)),
            "C_c": ((0, m), (s, s + c)),
            "D_c": ((0, m), (0, s)),
        }
        if self.strictly_proper:
            del places["D_c"]
        return placed((m + c, s + c), places, self.form, self.limits)

    def words(self, plant: Any) -> str:
        """Its sensors by the names of a ``plant``, and its kind."""
        _, words, _ = sensor_rows(plant, self.position, self.velocity)
        return f"u depends on {listed(words)}: a controller of order {self.order}"
