"""Elements of the page that compute what they show, in the reader's browser."""

from ..page import PageElement


class Mover(PageElement):
    """A page element with controls that computes what it shows; put it last in a cell.

    ``script``: the name of its script, and behind "sos-" of its tag; ``title``: the
    heading; ``hint``: what to try, in a sentence or two; ``controls``: made by
    `slider`, `choice` and `tick`, in their order; ``**given``: what the page computes
    with, as JSON has it, and ``answer``, as for `task`.
    """

    sheets = ("mover",)

    def __init__(self, script, title, hint, controls, **given):
        self.tag, self.script, self.title = f"sos-{script}", script, title
        self.data = {"title": title, "hint": hint, "controls": controls, **given}

    def __repr__(self):
        keys = ", ".join(control["key"] for control in self.data["controls"])
        return f"{self.script.capitalize()}: {keys}"


def slider(key, label, unit, ends, step, start, scale="linear"):
    """A slider as the page needs it.

    Parameters
    ----------
    key : str
        The name of the value in the script.
    label : str
        What stands above the slider.
    unit : str
        What stands behind the value, with its space: " s".
    ends : (float, float)
        Both ends; powers of ten of the value where the scale is "log".
    step : float
        From one position to the next, in the same measure.
    start : float
        The value at first.
    scale : {"linear", "log"}
        Whether the positions are values or their logarithms to base 10.

    Examples
    --------
    >>> slider("R", "Weight R", "", (-1, 2), 0.5, 1, "log")["max"]
    2
    """
    if scale not in ("linear", "log"):
        raise ValueError(f'scale must be "linear" or "log", got {scale!r}')
    words = {"key": key, "label": label, "unit": unit}
    where = {"min": ends[0], "max": ends[1], "step": step, "start": start}
    return words | where | {"scale": scale}


def choice(key, label, names, start=0):
    """A list to choose from; the script gets the index of the name.

    ``key``, ``label``: as for `slider`; ``names``: what can be chosen; ``start``: the
    index of the first choice.
    """
    return {"key": key, "label": label, "names": list(names), "start": start}


def tick(key, label, start, of="Measured"):
    """A box to tick; the script gets 1 or 0.

    ``key``, ``label``: as for `slider`; ``start``: 1 where it is ticked at first, else
    0; ``of``: what stands before all boxes.
    """
    return choice(key, label, ["no", "yes"], start) | {"tick": of}
