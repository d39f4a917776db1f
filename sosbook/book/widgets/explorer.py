"""Sliders over a picture: what every explorer is made of."""

import asyncio

import numpy as np

from ...display.escape import page_text
from ...runtime.libraries import library
from ...synthesis.pid import design_pid
from ..plots import BLUE, INK, VERMILLION, smallest_of_each

ipywidgets = library("ipywidgets")


__all__ = [
    "Explorer",
    "Follower",
    "gains_table",
    "linear",
    "log",
    "margins_table",
    "note",
    "page",
]


class Explorer(ipywidgets.VBox):
    """Sliders over a picture.

    Parameters
    ----------
    sliders : dict of str to ipywidgets slider
        What can be moved.
    draw : callable
        Takes the sliders' values by name and yields HTML, once or more
        often: first what is quick, then what takes longer.

    Attributes
    ----------
    sliders : dict
        Set ``sliders["rho"].value`` to move one from code.
    picture : ipywidgets.HTML
        What is shown.
    """

    def __init__(self, sliders, draw):
        self.sliders = sliders
        self.picture = ipywidgets.HTML()
        self.draw = draw
        self._waiting = None
        for slider in sliders.values():
            slider.observe(self._move, "value")
        super().__init__([*sliders.values(), self.picture])
        self._move()

    def _move(self, change=None):
        if self._waiting is not None:
            self._waiting.cancel()
        values = {name: s.value for name, s in self.sliders.items()}
        pages = self.draw(**values)
        self._show(pages, 1)
        self._waiting = _when_idle(lambda: self._show(pages))

    def _show(self, pages, count=None):
        try:
            for _, page in zip(range(count or 9), pages):
                self.picture.value = page
        except ValueError as error:  # e.g. an empty region
            self.picture.value = note(page_text(str(error)))


class Follower:
    """`design_pid` for a slider: each design starts from the last.

    The answer is that of `design_pid` alone, it only comes sooner: a
    design is the analytic centre of what is asked, and there is one.
    """

    def __init__(self):
        self.last = None

    def __call__(self, plant, U=None, **asked):
        design = design_pid(plant, U, start=self.last, **asked)
        if design.status == "feasible":
            self.last = design
        return design


def _when_idle(function, seconds=0.25):
    """Call when the sliders rest; at once where no event loop runs."""
    try:
        loop = asyncio.get_running_loop()
    except RuntimeError:
        return function()
    return loop.call_later(seconds, function)


def _slider(kind, name, value, low, high, step, form=".3g"):
    return kind(
        value=value,
        min=low,
        max=high,
        step=step,
        description=name,
        readout_format=form,
        continuous_update=True,
        style={"description_width": "14em"},
        layout=ipywidgets.Layout(width="min(40em, 95%)"),
    )


def linear(name, value, low, high, form=".3g"):
    """A slider from ``low`` to ``high`` that starts at a ``value``.

    Its ``name`` stands beside it; the value is shown in this ``form``.
    """
    step = 10.0 ** np.floor(np.log10((high - low) / 60))
    return _slider(ipywidgets.FloatSlider, name, value, low, high, step, form)


def log(name, value, below, above):
    """A slider on a logarithmic scale that starts at a ``value``.

    It goes down by a factor ``below`` and up by a factor ``above``; its
    ``name`` stands beside it.
    """
    middle = np.log10(value)
    return _slider(
        ipywidgets.FloatLogSlider,
        name,
        value,
        middle - np.log10(below),
        middle + np.log10(above),
        0.02,
    )


def note(message, colour=VERMILLION):
    """A note with a ``message`` in HTML, and a bar of this ``colour``."""
    return (
        f"<p role='status' style='margin:0;padding:.4em 1em;"
        f"border-left:5px solid {colour};background:#f6f8fa;"
        f"color:{INK}'>{message}</p>"
    )


def page(*parts):
    """The parts of a view, one below the other."""
    cells = "".join(f"<div>{part}</div>" for part in parts if part)
    return (
        "<div style='display:flex;flex-wrap:wrap;gap:1em;background:white;"
        f"color:{INK};padding:.5em'>{cells}</div>"
    )


def margins_table(margins):
    """The smallest of the margins of each requirement, with bars."""
    rows = []
    for name, value in smallest_of_each(margins).items():
        width = 100 * np.clip(1 + np.log10(max(value, 1e-9)) / 4, 0.02, 1)
        bar = f"<div style='background:{BLUE};height:.7em;width:{width:.0f}%'></div>"
        rows.append(
            f"<tr><th scope='row' style='text-align:left;font-weight:"
            f"normal'>{page_text(name)}</th><td>{value:.2g}</td>"
            f"<td style='width:9em'>{bar}</td></tr>"
        )
    head = "<caption>Margins (log scale)</caption>"
    return f"<table class='margins'>{head}{''.join(rows)}</table>"


def gains_table(design):
    """The gains of a design, one row for each input."""
    names = ("K_P", "K_D", "K_I")
    parts = [getattr(design, name) for name in names]
    rows = "".join(
        "<tr>"
        + "".join(
            f"<td style='padding:0 .6em;text-align:right'>{k:.4g}</td>"
            for part in parts
            for k in part[i]
        )
        + "</tr>"
        for i in range(len(parts[0]))
    )
    heads = "".join(
        f"<th scope='colgroup' colspan='{part.shape[1]}'>{name}</th>"
        for name, part in zip(names, parts)
        if part.shape[1]
    )
    return f"<table class='gains'><tr>{heads}</tr>{rows}</table>"
