"""A page's explorer, with the package behind it where a kernel runs."""

import json

from ...display.escape import page_text
from ...runtime.libraries import library
from ..elements.answers import Answers
from ..elements.explorer import Explorer
from .widget import OnPage

ipywidgets = library("ipywidgets")

__all__ = ["Live", "live"]

BY = "the package"
HIDDEN = {"display": "none"}


class Live(OnPage, ipywidgets.VBox):
    """An explorer of the rendered pages whose questions the package answers.

    Made by `live`.

    ``element``: what is shown, on a page by itself. Has ``question``: what the element
    asks, as JSON; not seen; ``answer``: what the package says to it, as JSON; not seen.
    """

    def __init__(self, element):
        self.element, self.answers = element, Answers()
        self.question = ipywidgets.Textarea(layout=HIDDEN, continuous_update=True)
        self.answer = ipywidgets.HTML(layout=HIDDEN)
        self.question.add_class("sos-question").observe(self._asked, "value")
        self.answer.add_class("sos-answer")
        shown = {
            "output_type": "display_data",
            "data": {"text/html": element.html, "text/plain": repr(element)},
            "metadata": {},
        }
        picture = ipywidgets.Output(outputs=(shown,))
        super().__init__([picture, self.question, self.answer])
        self.add_class("sos-live")

    @property
    def html(self):
        """The explorer as HTML, which needs no kernel."""
        return self.element.html

    @property
    def text(self):
        """The explorer in a terminal."""
        return repr(self.element)

    def _asked(self, change):
        if not change["new"]:
            return
        job = json.loads(change["new"])
        found = self.answers(job["kind"], job["request"])
        self.answer.value = page_text(json.dumps({"id": job["id"], "by": BY} | found))


def live(element):
    """The same explorer as in the rendered pages, with the package behind it.

    In Jupyter it asks the package for each move, offer and proof. On a page, where no
    kernel runs, it is the explorer alone, whose own solver answers.

    Parameters
    ----------
    element : elements.Explorer
        As `elements.design_explorer` and `elements.bench` return it.

    Returns
    -------
    Live
        The widget; put it last in a cell.

    Raises
    ------
    ValueError
        If the element isn't an explorer: the others compute what they show.
    """
    if not isinstance(element, Explorer):
        raise ValueError(
            "live needs an explorer, as elements.design_explorer returns; "
            f"got {element!r}"
        )
    return Live(element)
