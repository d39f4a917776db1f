"""What a page makes a reader load, as test_site reads it; icons need no script."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
PAGES = re.findall(
    r"(?:root|file): *(\S+)", (ROOT / "_toc.yml").read_text("utf-8"), re.MULTILINE
)
#: Bytes, uncompressed: the first page, and any other.
FIRST, ANY = 1_500_000, 2_500_000


def assert_light(files, page):
    """Not more than a reader of this page should load."""
    weight = sum(file.stat().st_size for file in files)
    assert weight <= (FIRST if page == "book/intro" else ANY)


@pytest.mark.parametrize("page", [*PAGES, "search"])
def test_icons_need_no_script(site, page):
    assert "fontawesome" not in (site / f"{page}.html").read_text("utf-8")
    assert not list((site / "_static" / "scripts").glob("fontawesome*"))
