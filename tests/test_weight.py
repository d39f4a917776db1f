"""What a page makes a reader load, and that its icons need no script.

What a browser really loads and draws is read in the pages' visits (test_site).
"""

import re
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest

ROOT = Path(__file__).resolve().parent.parent
PAGES = re.findall(
    r"(?:root|file): *(\S+)", (ROOT / "_toc.yml").read_text("utf-8"), re.MULTILINE
)
#: Bytes, uncompressed: the first page, and any other.
FIRST, ANY = 1_500_000, 2_500_000
SOURCE = re.compile(r'<(?:script|link|img)[^>]*? (?:src|href)="([^"]+)"')


def resources(path):
    """The files that a page names: its scripts, sheets and pictures."""
    found = {path}
    for address in SOURCE.findall(path.read_text("utf-8")):
        parts = urlsplit(address)
        file = (path.parent / unquote(parts.path)).resolve()
        if not parts.scheme and file.suffix in (".js", ".css", ".svg", ".png"):
            found.add(file)
    return found


def assert_light(files, page):
    """Not more than a reader of this page should load."""
    weight = sum(file.stat().st_size for file in files)
    assert weight <= (FIRST if page == "book/intro" else ANY)


@pytest.mark.parametrize("page", PAGES)
def test_a_page_is_light(site, page):
    assert_light(resources(site / f"{page}.html"), page)


@pytest.mark.parametrize("page", [*PAGES, "search"])
def test_icons_need_no_script(site, page):
    assert "fontawesome" not in (site / f"{page}.html").read_text("utf-8")
    assert not list((site / "_static" / "scripts").glob("fontawesome*"))
