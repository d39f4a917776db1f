"""The common base of the elements of a rendered page."""

import re

import numpy as np

from ...display.escape import json_text, page_text
from .scripts import modules, script, sheet

ELEMENT = re.compile(r'<sos-[a-z]+ class="([a-z -]+)" data-script="([a-z]+)"')


class PageElement:
    """An element that a cell shows: its data, its style and its scripts.

    A subclass names its tag, its script and its style sheets in ``assets``, and what
    its data shows; it has a ``title`` and ``data``, a dict as JSON has it.
    """

    tag = ""
    script = ""
    sheets = ()

    def _repr_html_(self):
        return self.html

    def task(self, hint, **answer):
        """Say what to try first; return the element.

        ``hint``: a sentence or two; ``answer``: controls by name, and the value of
        each, as its slider shows it: a button moves them there.
        """
        self.data |= {"hint": hint, "answer": answer or None}
        return self

    @property
    def html(self):
        """The element as HTML, which needs no other file."""
        return whole(self.light)

    @property
    def light(self):
        """The same without style and scripts: the book's pages load those as files."""
        kinds = " ".join(f"of-{name}" for name in ("kit", *self.sheets))
        return (
            f'<{self.tag} class="{kinds}" data-script="{self.script}" role="group" '
            f'aria-label="{page_text(self.title)}">'
            f'<p class="sos-absent">“{page_text(self.title)}” is a figure with numbers '
            "to move. It needs JavaScript; in JupyterLab, run its cell.</p>"
            f'<script type="application/json">{json_text(self.data)}</script>'
            f"</{self.tag}>"
        )


def whole(text):
    """HTML with the style and the scripts of its elements.

    What all elements share has the class "sos-shared": stored notebooks leave it out.

    ``text``: elements as HTML, each with its data.
    """
    sheets, scripts = named(text)
    style, code = "".join(map(sheet, sheets)), "".join(map(script, scripts))
    return (
        f'{text}\n<style class="sos-shared">\n{style}</style>\n'
        f'<script class="sos-shared">\n{code}</script>\n'
    )


def named(text):
    """The names of the style sheets and the scripts that a page's elements need.

    ``text``: the page's HTML.

    >>> named('<sos-map class="of-kit of-map" data-script="map" role="group">')
    (('kit', 'map'), ('kit', 'plot', 'sentence', 'spoken', 'mover', 'program', 'map'))
    """
    found = ELEMENT.findall(text)
    sheets = dict.fromkeys(
        name.removeprefix("of-") for kinds, _ in found for name in kinds.split()
    )
    return tuple(sheets), modules(*(name for _, name in found))


def matrices(plant, names):
    """The matrices of a ``plant`` with these ``names``, as JSON has them.

    >>> from sosbook.plants import SecondOrderSystem
    >>> matrices(SecondOrderSystem(1, 0, 4, 1), "MS")
    {'M': [[1.0]], 'S': [[4.0]]}
    """
    return {name: getattr(plant, name).tolist() for name in names}


def significant(value, digits):
    """A float, or an array as lists, rounded to so many significant digits; never -0.

    ``value``: of any shape; ``digits``: how many digits are kept.

    >>> significant(0.123456, 3), significant([[-0.0, 12345]], 3)
    (0.123, [[0.0, 12300.0]])
    """
    if np.ndim(value):
        return [significant(x, digits) for x in value]
    return float(f"{float(value):.{digits}g}") + 0.0
