"""Sliders over a function of the reader's own."""

import inspect
import io
from contextlib import redirect_stdout

import numpy as np

from ...display.escape import page_text
from ...requirements.vocabulary import PARAMETERS, Parameter
from ...runtime.libraries import library
from ..elements.records import DELAY_PARAMETERS
from .widget import OnPage

ipywidgets = library("ipywidgets")
InteractiveShell = library("IPython.core.interactiveshell").InteractiveShell
DisplayFormatter = library("IPython.core.formatters").DisplayFormatter

__all__ = ["Sliders", "sliders"]

#: What the sliders of these names are called; any other has its name alone.
LABELS = (
    PARAMETERS
    | DELAY_PARAMETERS
    | {"R": Parameter("R", "weight R", "Weight R of the input", "R")}
)
DECADES = 100  # high / low of a range from which on the slider is logarithmic
STYLE = {"description_width": "14em"}
WIDTH = "min(40em, 95%)"


class Sliders(OnPage, ipywidgets.VBox):
    """Sliders, and below them what a function says of their values.

    Made by `sliders`.

    ``function``: takes a value by the name of each slider; ``ranges``: as `sliders`
    takes them. Has ``sliders``: set ``sliders["rho"].value`` to move one from code, in
    the unit shown; ``result``: what the function returned last: a design, to certify or
    to simulate. None where it failed.
    """

    def __init__(self, function, ranges):
        self.function, self.picture = function, ipywidgets.Output()
        self.sliders = {key: _slider(key, ends) for key, ends in ranges.items()}
        made = {
            key for key, slider in self.sliders.items() if slider is not ranges[key]
        }
        self._in_degrees = made & {"theta"}
        self._show()
        for slider in self.sliders.values():
            slider.observe(self._move, "value")
        super().__init__([*self.sliders.values(), self.picture])

    @property
    def values(self):
        """The function's arguments: angles in radians, though they are shown in °."""
        return {
            key: float(np.radians(s.value)) if key in self._in_degrees else s.value
            for key, s in self.sliders.items()
        }

    @property
    def html(self):
        """The picture as HTML."""
        parts = "".join(map(_html, self.picture.outputs))
        return f'<div class="sos-moved">{parts}</div>'

    @property
    def text(self):
        """The picture as text, for a terminal."""
        return "\n".join(map(_text, self.picture.outputs))

    def _move(self, change):
        try:
            self._show()
        except Exception as fault:  # a reader's function may raise whatever it likes
            name = "" if isinstance(fault, ValueError) else f"{type(fault).__name__}: "
            self.result = None
            self.picture.outputs = (_stream(f"{name}{fault}", "stderr"),)

    def _show(self):
        said = io.StringIO()
        with redirect_stdout(said):
            self.result = result = self.function(**self.values)
        if isinstance(result, str):
            said.write(result)
        outputs = (_stream(said.getvalue()),) if said.getvalue() else ()
        if not (result is None or isinstance(result, str)):
            outputs += (_displayed(result),)
        self.picture.outputs = outputs


def sliders(function, **ranges):
    """Sliders that call a function again at each move.

    Put it last in a cell. A page without a kernel shows what the function says where
    the sliders stand at first.

    Parameters
    ----------
    function : callable
        Takes a number by the name of each slider. What it returns is shown as a cell
        would show it: a design, a figure of `plots.show`, a text; and so is
        what it prints.
    **ranges : (low, start, high) or ipywidgets.Widget
        One for each argument: three numbers that rise, or any widget that has a
        value. From high / low = 100 on the slider is logarithmic. The angle theta is
        in radians, as everywhere in the package, and shown in degrees.

    Returns
    -------
    Sliders
        The widget. If the function fails at a move, its error is shown in words.

    Raises
    ------
    ValueError
        If a range isn't three rising numbers, or the function has no such argument
        or another one. What the function raises at the start is raised.

    Examples
    --------
    >>> import sosbook as sos
    >>> cart = sos.SecondOrderSystem([[1]], [[0]], [[0]], [[1]])
    >>> def design(sigma, rho):
    ...     return sos.design_pid(cart, region=sos.PoleRegion(sigma, rho=rho))
    >>> moved = sliders(design, sigma=(0.1, 0.5, 4), rho=(1, 3, 9))
    >>> moved.sliders["sigma"].description, moved.result.status
    ('Decay rate σ (1/s)', 'feasible')
    >>> moved.sliders["sigma"].value = 3.5
    >>> print(moved.text)
    the region is empty: rho = 3.0 must exceed sigma = 3.5
    """
    takes = inspect.signature(function)
    try:
        takes.bind(**ranges)
    except TypeError as fault:
        name = getattr(function, "__name__", "the function")
        raise ValueError(
            f"sliders needs a range for each argument of {name}{takes}: {fault}"
        ) from None
    return Sliders(function, ranges)


def _slider(key, ends):
    """A slider with the name of its argument, in the unit shown."""
    if isinstance(ends, ipywidgets.Widget) and hasattr(ends, "value"):
        return ends
    which = LABELS.get(key, Parameter(key, key, key, key))
    try:
        low, start, high = map(float, ends)
    except (TypeError, ValueError):
        low = start = high = np.nan
    if not (low <= start <= high and low < high and np.isfinite(high - low)):
        raise ValueError(
            f"{key} must be (low, start, high), three finite numbers that rise, or a "
            f"widget with a value; got {ends!r}"
        )
    if fault := which.fault(high):
        raise ValueError(fault)
    low, start, high = map(which.shown, (low, start, high))
    unit = which.unit.strip()
    how = {
        "value": start,
        "description": which.label + (f" ({unit})" if unit else ""),
        "readout_format": ".3g",
        "style": STYLE,
        "layout": ipywidgets.Layout(width=WIDTH),
    }
    if low > 0 and high / low >= DECADES:
        low, high = np.log10([low, high])
        return ipywidgets.FloatLogSlider(min=low, max=high, step=0.02, **how)
    step = 10.0 ** np.floor(np.log10((high - low) / 60))
    return ipywidgets.FloatSlider(min=low, max=high, step=step, **how)


def _stream(text, name="stdout"):
    return {"output_type": "stream", "name": name, "text": text}


def _displayed(result):
    """A result as a cell displays it."""
    shell = InteractiveShell.initialized() and InteractiveShell.instance()
    formatter = shell.display_formatter if shell else DisplayFormatter()
    data, metadata = formatter.format(result)
    return {"output_type": "display_data", "data": data, "metadata": metadata}


def _html(output):
    shown = output.get("data", {}).get("text/html")
    return shown or f"<pre>{page_text(_text(output))}</pre>"


def _text(output):
    return output["text"].rstrip() if "text" in output else output["data"]["text/plain"]
