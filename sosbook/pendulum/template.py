"""Templates of programs, which run as they stand; a robot's get its numbers.

A template is a program with an example's numbers. What a robot's program has
instead is looked up by its name: in ``#define NAME 0``, ``static const int NAME =
0;`` or ``NAME = 0`` the value is replaced.
"""

import re
import textwrap
from importlib import resources
from importlib.metadata import version

__all__ = ["comment", "fill", "python_comment", "replaced", "written_by"]

COMMENT_WIDTH = 70  # characters in a line of a comment
PLACE = "(Where this comes from.)"  # of the note in a template's comment


def comment(lines, margin):
    """The ``lines`` of a comment, each behind a ``margin``; none ends it in C."""
    wrapped = [
        part for line in lines for part in textwrap.wrap(plain(line), COMMENT_WIDTH)
    ]
    return "\n".join((margin + line).rstrip() for line in wrapped)


def plain(text):
    """A text in printable ASCII, without what begins or ends a comment of C."""
    text = text.encode("ascii", "backslashreplace").decode()
    text = "".join(c if c.isprintable() else " " for c in text)
    for pair in ("*/", "/*", "??"):
        while pair in text:
            text = text.replace(pair, " ".join(pair))
    return text


def python_comment(lines):
    """The ``lines`` of a docstring of Python, which none of them can end."""
    return comment(lines, "").replace("\\", "/").replace('"""', "'''")


def written_by():
    """The first line of every written program."""
    return (
        f"Written by sosbook {version('sosbook')}; write it again rather than edit it."
    )


def replaced(pattern, text, new):
    """The ``text`` with ``new`` in the one place that the ``pattern`` matches.

    What the pattern's groups match stays before it.
    """
    text, count = re.subn(
        pattern, lambda match: "".join(match.groups()) + new, text, flags=re.M
    )
    if count != 1:
        raise LookupError(f"{pattern!r} matches {count} times in a template")
    return text


def fill(template, note, values, name="balance"):
    """The program of a ``template`` for a robot.

    Parameters
    ----------
    template : str
        The name of a file in the folder templates.
    note : list of str
        Lines that say where the program comes from.
    values : dict
        From the names in it to the texts of their values.
    name : str
        What stands for "balance" in the names of files and of functions.
    """
    path = resources.files("sosbook.pendulum").joinpath("templates", template)
    text = path.read_text("utf-8")
    for label, value in values.items():
        defines = rf"^(#define {label} |(?:static .*\b)?{label}(?:\[\w*\])* = )"
        text = replaced(rf"{defines}[^;\n]*?(?=;|  ?/\*|  #|$)", text, str(value))
    text = re.sub(r"\bbalance(?=_|\.(?:c|h|py|ino)\b)|(?<=_)balance\b", name, text)
    text = re.sub(r"\bBALANCE(?=_)", name.upper(), text)
    margin, found, _ = text.partition(PLACE)
    margin = margin.rpartition("\n")[2]
    lines = comment(note, margin) if margin else python_comment(note)
    return text.replace(margin + PLACE, lines) if found else text
