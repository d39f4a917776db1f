"""What a page makes a reader load, and that its icons need no script."""

import re
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest

ROOT = Path(__file__).resolve().parent.parent
PAGES = re.findall(
    r"(?:root|file): *(\S+)", (ROOT / "_toc.yml").read_text("utf-8"), re.MULTILINE
)
#: Bytes, uncompressed: the first page, and any other.
FIRST, ANY = 1_500_000, 3_200_000
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


def loaded(tab):
    """The files that the browser asked for; fonts and what scripts load, too."""
    return {Path(unquote(urlsplit(url).path)) for url in tab.requests}


@pytest.mark.parametrize("page", PAGES)
def test_a_page_is_light(site, page):
    weight = sum(file.stat().st_size for file in resources(site / f"{page}.html"))
    assert weight <= (FIRST if page == "book/intro" else ANY)


def test_the_first_page_is_light_in_the_browser(site, visit):
    tab = visit(site / "book" / "intro.html")
    assert sum(file.stat().st_size for file in loaded(tab)) <= FIRST
    assert tab.errors == []


def test_a_chapter_is_light_in_the_browser_with_its_fonts(site, visit):
    tab = visit(site / "book" / "20_delay_theorem.html")
    assert sum(file.stat().st_size for file in loaded(tab)) <= ANY


@pytest.mark.parametrize("page", ["book/05_hinf", "search", "book/own_plant"])
def test_icons_are_drawn_by_the_sheet(site, visit, page):
    text = (site / f"{page}.html").read_text("utf-8")
    assert "fontawesome" not in text
    assert not list((site / "_static" / "scripts").glob("fontawesome*"))
    tab = visit(site / f"{page}.html")
    seen = tab.page.evaluate(
        """() => [...document.querySelectorAll("i[class*='fa-']")]
          .filter((icon) => icon.checkVisibility())
          .map((icon) => {
            const style = getComputedStyle(icon), box = icon.getBoundingClientRect();
            return [style.maskImage.startsWith("url("), box.width, box.height];
          })"""
    )
    assert seen
    for drawn, width, height in seen:
        assert drawn and 8 <= width <= 40 and 8 <= height <= 40
