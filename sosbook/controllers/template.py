"""Texts of programs: comments that nothing ends, and templates that are read."""

import re
import textwrap
from importlib import resources

from .. import __version__

COMMENT_WIDTH = 70  # characters in a line of a comment
PLACE = "(Where this comes from.)"  # of the note in a template's comment
MARK = "(Anything.)"  # stands for the lines of a note that are compared with none


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


def written_by(edition=None):
    """The first line of every program that this ``edition`` of sosbook wrote."""
    edition = edition or __version__
    return f"Written by sosbook {edition}; write it again rather than edit it."


def version_in(text):
    """The edition of sosbook that wrote a program with this ``text``, or None."""
    found = re.search(r"Written by sosbook (\S+); write it again", text)
    return found and found[1]


def replaced(pattern, text, new):
    """The ``text`` with ``new`` behind the first group of the ``pattern``'s match."""
    text, count = re.subn(pattern, lambda match: match[1] + new, text, flags=re.M)
    if count != 1:
        raise LookupError(f"{pattern!r} matches {count} times in a template")
    return text


def read(package, template):
    """The text of a ``template``, a file in the folder templates of a package."""
    return resources.files(package).joinpath("templates", template).read_text("utf-8")


def renamed(text, old, name):
    """A template's ``text`` with a ``name`` in the place of the ``old`` one."""
    text = re.sub(rf"\b{old}(?=[_. ()*]|$)|(?<=_){old}\b", name, text, flags=re.M)
    return re.sub(rf"\b{old.upper()}(?=_)", name.upper(), text)


def noted(text, note):
    """The ``text`` of a template with the lines of a ``note`` in their `PLACE`."""
    margin, found, _ = text.partition(PLACE)
    margin = margin.rpartition("\n")[2]
    lines = comment(note, margin) if margin else python_comment(note)
    return text.replace(margin + PLACE, lines) if found else text


def fitted(wanted, mine):
    """A ``wanted`` text with the note of mine in the place of a `MARK`.

    A note is comments alone: where it isn't, the mark stays.
    """
    head, found, tail = wanted.partition(MARK)
    note = mine.removeprefix(head).removesuffix(tail)
    margin = head.rpartition("\n")[2].strip()
    alone = all(x.strip().startswith(margin) for x in note.split("\n")[1:])
    ends = any(x in note for x in ("*/", "\\", '"""'))
    return head + note + tail if found and alone and not ends else wanted
