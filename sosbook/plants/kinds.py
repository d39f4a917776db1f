"""What the design functions take for a plant, and what they say to others."""

from .descriptor_system import DescriptorSystem
from .second_order import Polytope, SecondOrderSystem

__all__ = ["Plant", "SecondOrderPlant", "checked_plant"]

SecondOrderPlant = SecondOrderSystem | Polytope
Plant = SecondOrderSystem | Polytope | DescriptorSystem


def checked_plant(plant, kinds=Plant):
    """The plant, or a ValueError that says what to give instead.

    Parameters
    ----------
    plant : object
        What was given for a plant.
    kinds : type or union of types
        What is taken.

    Examples
    --------
    >>> checked_plant([SecondOrderSystem(1, 1, 1, 1)], SecondOrderSystem)
    Traceback (most recent call last):
    ValueError: plant must be a SecondOrderSystem, got list: wrap it in Polytope([...])
    """
    if isinstance(plant, kinds):
        return plant
    cure = ""
    if isinstance(plant, (list, tuple)):
        cure = ": wrap it in Polytope([...])"
    elif hasattr(plant, "regular"):
        cure = ": give its .regular, the plant with K_A inside"
    *first, last = (kind.__name__ for kind in getattr(kinds, "__args__", (kinds,)))
    names = f"{', a '.join(first)} or a {last}" if first else last
    raise ValueError(f"plant must be a {names}, got {type(plant).__name__}{cure}")
