"""A law whose gain follows measured parameters."""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import Any

from ..plants.kinds import checked_plant
from ..plants.schedule import Schedule, scheduled
from ..runtime.read_only import put
from .base import Law, Parts
from .full_state import FullState
from .structure import Structure

NO_FAMILY = (
    "plant has no parameters to be measured: make it with Uncertain(builder, "
    "name=(low, high))"
)
FREE = (
    "the memory of this law has free gains, and only those of u follow a parameter: "
    "take a PIDLaw with a fixed filter, or measure all of the state"
)
LATE = "a scheduled law takes no late sensors: make them states of a DescriptorSystem"


@dataclass(frozen=True, eq=False)
class Scheduled(Law):
    """u = K(p) y, with the gain between those at the corners of measured ranges.

    Parameters
    ----------
    measured : str or sequence of str
        Names of parameters of the plant, an `Uncertain`, that are measured while it
        runs. The others aren't, and may have any value in their ranges.
    law : Law, optional
        What is measured besides, and remembered: `FullState` without it, or a `PIDLaw`.

    Notes
    -----
    ``design.K`` has the gains of all corners below each other: see `Design.schedule`.
    A `Saturation` bounds the gain of each corner, and so u, a mean of these. What else
    weighs u weighs the inputs of all corners, which are together no smaller than u.

    Examples
    --------
    A mass that is measured has another gain at each of its ends:

    >>> import sosbook as sos
    >>> cart = sos.Uncertain(lambda m: sos.SecondOrderSystem(m, 0, 0, 1), m=(1, 9))
    >>> ask = dict(region=sos.PoleRegion(sigma=1, rho=4))
    >>> sos.design_pid(cart, law=Scheduled("m"), **ask).status
    'feasible'
    >>> sos.design_pid(cart, **ask).status
    'infeasible'
    """

    measured: Any
    law: Law = field(default_factory=FullState)

    def __post_init__(self):
        """Check the names and the inner law."""
        names = (
            (self.measured,) if isinstance(self.measured, str) else self.measured or ()
        )
        if not isinstance(names, Iterable) or not all(
            isinstance(x, str) for x in names
        ):
            raise ValueError(
                f"measured must be names of parameters, got {self.measured!r}"
            )
        if not isinstance(self.law, Law) or isinstance(self.law, Scheduled):
            raise ValueError(
                "law must be another law, such as FullState, got "
                f"{type(self.law).__name__}"
            )
        put(self, measured=tuple(names))
        super().__post_init__()

    @property
    def searched(self) -> bool:  # type: ignore[override]
        """True if the inner law's gain is searched."""
        return self.law.searched

    @property
    def whole(self) -> bool:  # type: ignore[override]
        """True if the inner law's gain is that of the whole state."""
        return self.law.whole

    @property
    def U(self) -> Any:  # type: ignore[override]
        """The errors that the inner law integrates."""
        return self.law.U

    def on(self, plant: Any) -> tuple:
        """The ``plant`` with an input for each corner, and the inner law."""
        family = checked_plant(plant).family
        if family is None or not family.box.names:
            raise ValueError(NO_FAMILY)
        if family.schedule and family.schedule != self.measured:
            raise ValueError("the plant has another schedule: give the plant itself")
        if not family.schedule:
            plant = scheduled(family, self.measured).polytope()
        if self.law.readings(plant).late.any():
            raise ValueError(LATE)
        if not self.law.whole and self.law.parts(plant).free:
            raise ValueError(FREE)
        return self.law.on(plant)

    def demands(self, plant: Any, asked: tuple) -> tuple:
        """The requirements ``asked`` of a ``plant``, with a bound of each corner's gain
        in the place of a bound of u.
        """
        family = checked_plant(plant).family
        if family is None or family.schedule:
            return asked
        many, m = (
            len(Schedule(self.measured, family.box).corners),
            checked_plant(plant).m,
        )
        found = []
        for r in asked:
            if r.kind != "input" or r.u_max is None:
                found.append(r)
                continue
            inputs = range(m) if r.u is None else r.u
            for k in range(many):
                own = tuple(k * m + j for j in inputs)
                name = f"{r.name} at corner {k + 1}"
                found.append(replace(r, u=own, name=name, count=None))
        return tuple(found)

    def parts(self, plant: Any) -> Parts:
        return self.law.parts(plant)

    def structure(self, plant: Any) -> Structure:
        return self.law.structure(plant)

    def words(self, plant: Any) -> str:
        """The inner law's words at a ``plant``, and what its gain follows."""
        return (
            f"{self.law.words(plant)}; its gain follows {' and '.join(self.measured)}"
        )
