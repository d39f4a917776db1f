"""What every element of the rendered page has in common: it needs no other file."""

import re
from importlib.resources import files

from ...display.escape import json_text, page_text
from ..kernel import lean

__all__ = ["PageElement", "script", "significant"]


class PageElement:
    """An element that a cell shows: its style, data and script stand inline.

    A subclass names its tag, its files in ``assets`` and what its data shows;
    it has a ``title`` and ``data``, a dict as JSON has it.
    """

    tag = ""
    sheets = ()
    scripts = ()
    notice = ""  # where there is no JavaScript

    def _repr_html_(self):
        return self.html

    @property
    def html(self):
        """The element as HTML; ``kit.js`` is the same for all of them."""
        sheets = [_asset(name) for name in ("kit.css", *self.sheets)]
        style = _tight("\n".join(sheets)).replace("sos-element", self.tag)
        scripts = "\n".join(map(script, ("kit.js", *self.scripts)))
        data = json_text(self.data)
        return (
            f'<{self.tag} role="group" aria-label="{page_text(self.title)}">'
            f"<style>{style}</style>"
            f"<noscript>{self.notice}; in "
            "JupyterLab, trust the notebook (View → Activate Command "
            "Palette → Trust Notebook) and run the cell, or open the book "
            "with python3 tasks.py lab.</noscript>"
            f'<script type="application/json">{data}</script>'
            f"</{self.tag}>\n<script>\n{scripts}\n</script>"
        )


def script(name):
    """An asset by ``name``, JavaScript, as readers load it.

    Examples
    --------
    >>> "sosSolver" in script("solver.js")
    True
    """
    return lean(_asset(name))


def _tight(style):
    """A style sheet without comments and needless spaces.

    Examples
    --------
    >>> _tight("a b { color: red;  /* why */ }")
    'a b{color:red}'
    """
    style = re.sub(r"/\*.*?\*/", "", style, flags=re.DOTALL)
    style = re.sub(r"\s*([{};,])\s*", r"\1", " ".join(style.split()))
    return style.replace(": ", ":").replace(";}", "}").strip()


def _asset(name):
    return (files(__package__) / "assets" / name).read_text("utf8")


def significant(value, digits):
    """A float ``value`` rounded to so many significant digits, and never -0.

    Examples
    --------
    >>> significant(0.123456, 3), significant(-0.0, 3)
    (0.123, 0.0)
    """
    return float(f"{float(value):.{digits}g}") + 0.0
