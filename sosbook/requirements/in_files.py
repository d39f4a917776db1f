"""What a JSON file asks of a plant, as the keywords of `design_pid`."""

from inspect import signature

from .cost import QuadraticCost
from .input_bound import Saturation
from .pole_region import PoleRegion

__all__ = ["KEYS", "asked_in_file"]

OBJECTS = {  # what makes a key's object
    "region": PoleRegion,
    "saturation": Saturation,
    "cost": QuadraticCost,
}
VALUES = ("gamma", "mu", "minimize", "coupling", "slack", "U", "K_A")
KEYS = (*OBJECTS, *VALUES)


def asked_in_file(data: dict) -> dict:
    """Keywords of `design_pid` from the contents of a JSON file.

    Parameters
    ----------
    data : dict
        Keys among `KEYS`; "region", "saturation" and "cost" hold the
        parameters of `PoleRegion`, `Saturation` and `QuadraticCost`.

    Raises
    ------
    ValueError
        If a key or a parameter isn't known; it names it.

    Examples
    --------
    >>> asked_in_file({"region": {"sigma": 0.5}, "gamma": 2})["region"]
    PoleRegion(sigma=0.5, theta=None, rho=None)
    """
    keywords = {}
    for key, value in data.items():
        if key in VALUES:
            keywords[key] = value
            continue
        if key not in OBJECTS:
            raise ValueError(f"{key!r:.80} isn't known: the keys are {', '.join(KEYS)}")
        if not isinstance(value, dict):
            raise ValueError(f'{key} must be an object, such as {{"name": value}}')
        known = signature(OBJECTS[key]).parameters
        for name in value:
            if name not in known:
                raise ValueError(
                    f"{key}: {name!r:.80} isn't known: its keys are {', '.join(known)}"
                )
        try:
            keywords[key] = OBJECTS[key](**value)
        except TypeError as error:  # one is missing
            text = str(error).split("__init__() ")[-1]
            raise ValueError(f"{key}: {text}") from None
        except ValueError as error:
            raise ValueError(f"{key}: {error}") from None
    return keywords
