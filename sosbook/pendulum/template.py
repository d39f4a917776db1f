"""Templates of programs: filled, and with comments that nothing can end."""

import textwrap
from importlib import resources
from importlib.metadata import version
from string import Template

from .spelling import plain

__all__ = ["comment", "fill", "python_comment", "written_by"]

COMMENT_WIDTH = 70  # characters in a line of a comment


def comment(lines, margin):
    """The ``lines`` of a comment, each behind a ``margin``; none ends it in C."""
    wrapped = [
        part for line in lines for part in textwrap.wrap(plain(line), COMMENT_WIDTH)
    ]
    return "\n".join((margin + line).rstrip() for line in wrapped)


def python_comment(lines):
    """The ``lines`` of a docstring of Python, which none of them can end."""
    return comment(lines, "").replace("\\", "/").replace('"""', "'''")


def written_by():
    """The first line of every written program."""
    return (
        f"Written by sosbook {version('sosbook')}; write it again rather than edit it."
    )


def fill(template, values, **more):
    """The text of a ``template`` with the ``values`` in it, and some more."""
    text = resources.files("sosbook.pendulum").joinpath("templates", template)
    return Template(text.read_text("utf-8")).substitute(values, **more)
