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
    """An explorer of the rendered pages, ``element``, whose questions the package
    answers, made by `live`. ``question``, ``answer``: what is asked and said, as JSON,
    unseen.
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
    """The same explorer, ``element``, as in the rendered pages, with the package behind
    it, as a `Live`: in Jupyter it asks the package for each move, offer and proof; on a
    page its own solver answers. Raises ValueError for other elements, which compute
    what they show.
    """
    if not isinstance(element, Explorer):
        raise ValueError(
            "live needs an explorer, as elements.design_explorer returns; "
            f"got {element!r}"
        )
    return Live(element)
