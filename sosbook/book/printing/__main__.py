"""``python -m sosbook.book.printing SITE PDF [CHROMIUM]``: see `print_book`."""

import argparse
import re
import sys
from pathlib import Path

from ...runtime.writing import write_file
from . import print_book

NOTE = re.compile(r'<span class="sos-pdf">.*?</span>', re.DOTALL)


def main(arguments=None):
    """Print the book; tell the first page of it."""
    parser = argparse.ArgumentParser(prog="python -m sosbook.book.printing")
    parser.add_argument("site", type=Path)
    parser.add_argument("output", type=Path)
    parser.add_argument("chromium", nargs="?")
    parser.add_argument("--contents", type=Path, default=Path("_toc.yml"))
    parser.add_argument("--address", default="", help="where the site is served")
    parser.add_argument("--only", type=int, help="so many chapters, for a trial")
    asked = parser.parse_args(arguments)
    bound = print_book(
        asked.site,
        asked.output,
        asked.contents,
        asked.chromium,
        asked.address,
        asked.only,
    )
    size = f"{bound.pages} pages, {bound.size / 1e6:.1f} MB"
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
