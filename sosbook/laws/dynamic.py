"""A controller with states of its own, all of whose numbers are free."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..exact.rational import exact
from ..plants.checks import count
from ..plants.outputs import Output
from ..runtime.array_like import ArrayLike
from .base import Law, Parts, checked_limits, checked_outputs, listed
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
    position, velocity, sensors, lag, noise
        What is measured, as in `PIDLaw`; y has the velocities last.
    strictly_proper : bool
        Whether D_c is zero, so that u doesn't jump with y.
    structure : dict, optional
        Which entries are free, by name, as in `PIDLaw`: ``{"A_c": "diagonal"}``.
    limits : dict, optional
        The largest size of an entry, by name.

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
    sensors: Any = None
    rates: Any = None
    strictly_proper: bool = True
    form: Any = None
    limits: Any = None
    noise: Any = None
    lag: float | None = None

    def __init__(
        self,
        order: int,
        position: ArrayLike | None = None,
        velocity: ArrayLike | None = None,
        *,
        sensors: Output | None = None,
        lag: float | None = None,
        noise: ArrayLike | None = None,
        strictly_proper: bool = True,
        structure: dict | None = None,
        limits: dict | None = None,
    ) -> None:
        """Check the arguments and keep them read-only."""
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
        if structure is not None and not isinstance(structure, dict):
            raise ValueError(
                f"structure must be a dict by name ({', '.join(NAMES)}), got "
                f"{structure!r}"
            )
        for name, value in dict(
            order=int(order),
            **checked_outputs(position, velocity, sensors, noise, lag),
            strictly_proper=strictly_proper,
            form=structure,
            limits=checked_limits(limits, NAMES),
        ).items():
            object.__setattr__(self, name, value)
        self.__post_init__()

    def parts(self, plant: Any) -> Parts:
        plant, law = self.on(plant)
        if law is not self:
            return law.parts(plant)
        seen = self.readings(plant)
        words, s, c = seen.names, len(seen), self.order
        states = tuple(f"xc{k + 1}" for k in range(c))
        eye, zero = np.eye, np.zeros
        parts = eye(c), zero((c, c)), zero((c, s)), eye(s + c, s), eye(s + c, c, -s)
        seen = exact(seen.C), exact(seen.Dw)
        E, A, B, take, stay = map(exact, parts)
        said = words, states, (*words, *states)
        return Parts(*seen, E, A, B, take, stay, c, *said)

    def structure(self, plant: Any) -> Structure:
        m, c = plant.m, self.order
        s = len(self.readings(plant))
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
        words = listed(self.readings(plant).names)
        return f"u depends on {words}: a controller of order {self.order}"
