"""``python -m sosbook.book.printing SITE PDF [CHROMIUM]``: see `print_book`.

With ``--chapter 7`` a chapter alone, with ``--textbook`` what teaches; both lie beside
PDF, under names of their own.
"""

import argparse
import re
import sys
from pathlib import Path

from ...runtime.writing import write_file
from . import chosen, contents, print_book

NOTE = re.compile(r'<span class="sos-pdf">.*?</span>', re.DOTALL)


def main(arguments=None):
    """Print the book, which its first page then links, or a part of it."""
    parser = argparse.ArgumentParser(prog="python -m sosbook.book.printing")
    parser.add_argument("site", type=Path)
    parser.add_argument("output", type=Path)
    parser.add_argument("chromium", nargs="?")
    parser.add_argument("--contents", type=Path, default=Path("_toc.yml"))
    parser.add_argument("--address", default="", help="where the site is served")
    part = parser.add_mutually_exclusive_group()
    part.add_argument("--chapter", help="its number, or the name of its page")
    part.add_argument("--textbook", action="store_true", help="without the reference")
    asked = parser.parse_args(arguments)
    chapters = contents(asked.site, asked.contents)
    try:
        chapters = chosen(chapters, asked.chapter, asked.textbook)
    except ValueError as fault:
        parser.error(str(fault))
    whole, output = not (asked.chapter or asked.textbook), asked.output
    if not whole:
        output = output.with_stem("textbook" if asked.textbook else chapters[0].name)
    bound = print_book(
        asked.site, output, chapters, asked.chromium, asked.address, asked.textbook
    )
    size = f"{bound.pages} pages, {bound.size / 1e6:.1f} MB"
    if whole:
        mention(asked.site, bound.path, size)
    print(f"{bound.path}: {size}")
    return 0


def mention(site, path, size):
    """Link the file on the book's first page, if it lies in the site."""
    first = site / "book" / "intro.html"
    if path.resolve().is_relative_to(site.resolve()):
        name = path.resolve().relative_to(site.resolve()).as_posix()
        link = f'<span class="sos-pdf"><a href="../{name}">PDF</a> ({size})</span>'
        text = first.read_text("utf-8")
        write_file(first, NOTE.sub(link, text))


if __name__ == "__main__":
    sys.exit(main())
