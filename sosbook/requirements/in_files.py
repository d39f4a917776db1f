"""The requirements of a plant file, as keywords of `design_pid`."""

from inspect import signature

from ..laws.dynamic import DynamicLaw
from ..laws.pid import PIDLaw
from ..plants.outputs import Output
from .cost import QuadraticCost
from .h2 import H2
from .hinf import HInfinity
from .input_bound import Saturation
from .pole_region import PoleRegion

OBJECTS = {"region": PoleRegion, "saturation": Saturation}  # what makes a key's object
ONE = {"cost": QuadraticCost}  # one of the requirements
SEVERAL = {"hinf": HInfinity, "h2": H2}  # lists of them, told apart by name
VALUES = ("gamma", "minimize", "coupling", "U", "K_A")
OF_LAW = ("maximize",)  # what a search for its gains takes
KEYS = (*OBJECTS, *ONE, *SEVERAL, "law", *VALUES, *OF_LAW, "search")


def asked_in_file(data: dict) -> dict:
    """Keywords of `design_pid` from the ``data`` of a plant file, with keys among
    `KEYS`; "region", "saturation" and "cost" hold the parameters of `PoleRegion`,
    `Saturation` and `QuadraticCost`, "hinf" and "h2" those of `HInfinity` and `H2`, or
    lists of them. "law" holds those of `PIDLaw` or, if "order" is among them, of
    `DynamicLaw`. "outputs" and a law's "sensors" are objects with the parameters of
    `Output`, or lists of them, which are stacked. Raises ValueError if a key or a
    parameter isn't known; it names it.

    >>> asked_in_file({"region": {"sigma": 0.5}, "gamma": 2})["region"]
    PoleRegion(sigma=0.5, theta=None, rho=None)
    """
    keywords = {}
    for key, value in data.items():
        if key in OF_LAW and data.get("law") is None:
            raise ValueError(f"{key} needs a law: say what is measured under law")
        if key in VALUES or key in OF_LAW:
            keywords[key] = value
            continue
        if key == "law":
            dynamic = isinstance(value, dict) and "order" in value
            keywords[key] = made(key, DynamicLaw if dynamic else PIDLaw, value)
            continue
        if key in ONE or key in SEVERAL:
            given = value if isinstance(value, list) and key in SEVERAL else [value]
            named = keywords.setdefault("requirements", [])
            named += [made(key, (ONE | SEVERAL)[key], one) for one in given]
            continue
        if key not in OBJECTS:
            raise ValueError(
                f"{key!r:.80} isn't known: the keys are plant, controller, "
                f"{', '.join(KEYS)}"
            )
        if key == "saturation" and isinstance(value, dict):
            value = {"u_max": None} | value  # null in JSON, which TOML hasn't
        keywords[key] = made(key, OBJECTS[key], value)
    return keywords


def made(key, kind, value):
    """The object of a ``key``, of a ``kind``, from its ``value`` in the file."""
    if not isinstance(value, dict):
        raise ValueError(f'{key} must be an object, such as {{"name": value}}')
    known = signature(kind).parameters
    for name in value:
        if name not in known:
            raise ValueError(
                f"{key}: {name!r:.80} isn't known: its keys are {', '.join(known)}"
            )
    try:
        for name in ("outputs", "sensors"):
            rows = value.get(name)
            if rows is not None and name in known:
                rows = Output.read(rows if isinstance(rows, list) else [rows])
                value = value | {name: rows}
        return kind(**value)
    except TypeError as error:  # one is missing
        text = str(error).split("__init__() ")[-1]
        raise ValueError(f"{key}: {text}") from None
    except ValueError as error:
        raise ValueError(f"{key}: {error}") from None
