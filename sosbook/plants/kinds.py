"""The plants that the design functions take, and the errors for others."""

from abc import ABC, abstractmethod
from copy import copy

import numpy as np

from ..exact.checker.families import by_corners, every
from ..runtime.array_like import ArrayLike
from .descriptor_system import OF_TICKS, DescriptorSystem
from .second_order import Polytope, SecondOrderSystem
from .uncertain import Uncertain

SecondOrderPlant = SecondOrderSystem | Polytope | Uncertain
Plant = SecondOrderSystem | Polytope | Uncertain | DescriptorSystem


class Prepared(ABC):
    """A plant with a K_A of its own, as a `Regularization` is: designs take it, too."""

    @abstractmethod
    def applied(
        self, K_A: ArrayLike | None = None
    ) -> tuple[SecondOrderSystem | Polytope, np.ndarray]:
        """The plant and its K_A; raises ValueError if another ``K_A`` is given."""


def checked_plant(plant, kinds=Plant, of=None):
    """The ``plant``, if it is of the ``kinds``, or a ValueError that says what to give
    instead. Here alone a family with parameters becomes the polytope around it. ``of``
    names what takes no plant of discrete time; without it they are taken, too.

    >>> checked_plant([SecondOrderSystem(1, 1, 1, 1)], SecondOrderSystem)
    Traceback (most recent call last):
    ValueError: plant must be a SecondOrderSystem, got list: wrap it in Polytope([...])
    """
    if isinstance(plant, Uncertain):
        plant = plant.polytope()
    if isinstance(plant, kinds):
        if of is not None and getattr(plant, "dt", None) is not None:
            raise ValueError(OF_TICKS.format(of))
        return plant
    cure = ": wrap it in Polytope([...])" if isinstance(plant, (list, tuple)) else ""
    if isinstance(plant, Prepared):
        cure = ": give its .regular, the plant with K_A inside"
    kinds = getattr(kinds, "__args__", (kinds,))
    *first, last = (f"{'an' if x is Uncertain else 'a'} {x.__name__}" for x in kinds)
    names = f"{', '.join(first)} or {last}" if first else last
    raise ValueError(f"plant must be {names}, got {type(plant).__name__}{cure}")


def of_floats(plant):
    """The ``plant``, or one of the same floats: vertices that somebody took out of a
    family know its rationals, 1/3 say, but a list of plants is what its floats say, as
    in its proof files.
    """
    known = "_rationals"
    if plant.family is not None or not any(known in vars(v) for v in plant.vertices):
        return plant
    several = [copy(v) for v in plant.vertices]
    for v in several:
        vars(v).pop(known, None)
    return several[0] if isinstance(plant, SecondOrderSystem) else Polytope(several)


def every_plant(plant, scope):
    """Of which plants a proof of a ``scope`` speaks: see `every`.

    >>> family = Uncertain(lambda m: SecondOrderSystem(m, 1, 1, 1), m=(1, 2))
    >>> every_plant(family, "constant")
    'every constant plant with m in [1, 2]'
    >>> every_plant(family, "constant or changing")
    'every constant or changing plant with m in [1, 2]'
    """
    family = plant if isinstance(plant, Uncertain) else plant.family
    if family is not None and family.box.names:
        followed = by_corners(family.schedule)
        return every(f"with {family.box}{followed}", scope)
    many = len(plant.vertices) > 1
    return every("of the polytope", scope) if many else "the plant"
