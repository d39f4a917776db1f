"""The chapters of the built book, in the order of its table of contents."""

import html
import re
from dataclasses import dataclass
from pathlib import Path

#: Parts that are looked up, on a screen.
LOOKED_UP = ("The package", "The record")

LINE = re.compile(r"^ *(?:- )?(root|caption|file): *(\S.*?) *$", re.MULTILINE)
TITLE = re.compile(r'<h1[^>]*>((?:(?!</h1>).)*?)<a class="headerlink"', re.DOTALL)


@dataclass(frozen=True)
class Chapter:
    """A page of the book: the ``path`` built, its ``title`` with the number, the
    ``part`` that it belongs to, and whether it ``opens`` that.
    """

    path: Path
    title: str
    part: str = ""
    opens: bool = False

    @property
    def name(self):
        """The page's name."""
        return self.path.stem


def contents(site: Path, listing: Path) -> list:
    """The `Chapter` of each page of the built ``site``, in the order of the
    ``listing``, a ``_toc.yml``, the root first. Raises FileNotFoundError for a page
    that isn't built.
    """
    chapters, part, opens = [], "", False
    for key, value in LINE.findall(listing.read_text("utf-8")):
        if key == "caption":
            part, opens = value, True
            continue
        path = site / f"{value}.html"
        if not path.is_file():
            raise FileNotFoundError(
                f"{path} isn't built: run python3 tasks.py book first"
            )
        chapters.append(Chapter(path, title_of(path), part, opens))
        opens = False
    return chapters


def chosen(chapters, chapter=None, textbook=False):
    """One of the ``chapters``, those of the textbook, or all.

    ``chapter``: its number, such as "7", or its page's name; another one is a
    ValueError. ``textbook``: whether what is looked up is left out.
    """
    if chapter is None:
        return [one for one in chapters if not textbook or one.part not in LOOKED_UP]
    number = f"{chapter.zfill(2)}_"
    for one in chapters:
        if one.name == chapter or one.name.startswith(number):
            return [one]
    raise ValueError(
        f"no chapter is called {chapter}: give a number such as 7, or one of "
        + ", ".join(one.name for one in chapters)
    )


def title_of(path):
    """The title of a built page as plain text."""
    match = TITLE.search(path.read_text("utf-8"))
    text = re.sub(r"<[^>]+>", "", match[1]) if match else path.stem
    return " ".join(html.unescape(text).replace("\\(", "").replace("\\)", "").split())
