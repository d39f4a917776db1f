"""How long a move of a slider takes in the reader's own browser."""

import numpy as np

from .. import thesis
from .explorer import Explorer, design_explorer

SHARE = 0.2  # of its printed value, by which each slider moves
NAMES = {
    1: "Example 1: two coordinates",
    2: "Example 2: two vertices, their pair",
    3: "Example 3: four coordinates",
}


class Stopwatch(Explorer):
    """The page element that moves sliders and takes the time; made by `stopwatch`.

    Parameters
    ----------
    data : dict
        That of an `Explorer`, and "examples": plants to choose from.
    """

    tag, script = "sos-stopwatch", "stopwatch"
    sheets = ("explorer", "plant", "stopwatch")
    notice = "A stopwatch for your browser"


def stopwatch(examples=(1, 2, 3), title="How long does a move take on your computer?"):
    """An element that moves the sliders of the thesis's examples by itself.

    Parameters
    ----------
    examples : sequence of int
        Numbers of examples with all requirements: 1, 2 or 3.
    title : str
        The heading of the element.

    Returns
    -------
    Stopwatch
        The element. Its ``measure()`` in the page returns milliseconds.

    Raises
    ------
    ValueError
        If there is no such example.

    Examples
    --------
    >>> stopwatch([1])  # doctest: +ELLIPSIS
    Explorer: How long does a move take on your computer? (sigma, ...)
    """
    if not examples or set(examples) - set(NAMES):
        raise ValueError(f"examples must be some of {list(NAMES)}, got {examples!r}")
    chosen = [
        {"name": NAMES[k], "data": _explorer(getattr(thesis, f"example_{k}")(), title)}
        for k in examples
    ]
    return Stopwatch(chosen[0]["data"] | {"examples": chosen})


def _explorer(example, title):
    """The data of an explorer whose sliders go around what is printed."""
    region, limit = example.region, example.saturation
    printed = {name: getattr(region, name) for name in ("sigma", "theta", "rho")}
    printed |= {"gamma": example.gamma, "u_max": limit.u_max}
    given = example.requirements
    ends = {key: (x * (1 - SHARE), x * (1 + SHARE)) for key, x in printed.items()}
    ends["theta"] = (ends["theta"][0], min(ends["theta"][1], np.pi / 2))
    return design_explorer(
        example.plant,
        example.U,
        saturation=example.saturation,
        K_A=given.get("K_A"),
        mu=given.get("mu"),
        start=printed,
        title=title,
        **ends,
    ).data
