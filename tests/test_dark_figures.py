"""Figures in the dark: every stored colour has a counterpart that can be seen."""

import io
import re
from functools import cache
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread

from sosbook.book import notebooks
from sosbook.book.plots import style
from tests.cases import campaign
from tests.each import each

ROOT = Path(__file__).resolve().parent.parent
FILES = sorted((ROOT / "book").glob("*.ipynb"))
SHEET = (ROOT / "book" / "_static" / "figures.css").read_text("utf-8")
DARK = dict(re.findall(r"--fig-(\w+): (#[0-9a-f]{6});", SHEET))
RULE = re.compile(
    r'^\[style\*="(fill|stroke):(#[0-9a-f]{6})"\] '
    r"{ \1: var\(--fig-(\w+), \2\) !important; }$",
    re.MULTILINE,
)
NAMES = {(kind, stored): name for kind, stored, name in RULE.findall(SHEET)}
PAPER = "#15191f"
#: What lies behind lines and words; it needn't be seen by itself.
BEHIND = {"paper", "grid", "tint"}


def light(colour):
    """Relative luminance, plus the eye's share, as WCAG has it."""
    parts = [int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)]
    r, g, b = [
        x / 12.92 if x <= 0.04045 else ((x + 0.055) / 1.055) ** 2.4 for x in parts
    ]
    return 0.2126 * r + 0.7152 * g + 0.0722 * b + 0.05


def contrast(one, other):
    small, large = sorted((light(one), light(other)))
    return large / small


@cache
def drawings(path):
    return [
        html
        for cell in notebooks.read(path).cells
        for output in cell.get("outputs", [])
        if "sos-figure" in (html := output.get("data", {}).get("text/html", ""))
    ]


def stored(path):
    """The colours of a notebook's figures: (fill or stroke, colour)."""
    return {
        pair
        for html in drawings(path)
        for pair in re.findall(r"\b(fill|stroke):(#[0-9a-f]+)", html)
    }


@each("path", FILES)
def test_every_stored_colour_can_be_seen_in_the_dark(path):
    for kind, colour in stored(path):
        name = NAMES.get((kind, colour))
        if name not in BEHIND:
            assert contrast(DARK[name] if name else colour, PAPER) >= 3, colour
        if name is None:  # the same in both; on white, too
            assert contrast(colour, "#ffffff") >= 3, colour


@each("path", FILES)
def test_words_stand_out_from_paper(path):
    words = r'<g style="fill:(#[0-9a-f]{6})[^"]*" transform="[^"]*scale\('
    for html in drawings(path):
        for colour in set(re.findall(words, html)) - {"#ffffff"}:
            assert contrast(DARK[NAMES["fill", colour]], PAPER) >= 4.5


def test_words_stand_out_from_bodies_and_bars():
    for name in ("body", "tint"):
        assert contrast(DARK["ink"], DARK[name]) >= 4.5
    assert contrast(DARK["paper"], DARK["blue"]) >= 4.5  # words on a bar


def test_the_styles_colours_have_counterparts_that_differ():
    assert DARK["paper"] == PAPER and f"background: {PAPER}" in SHEET
    for colour in (*style.COLOURS, style.GREY, style.INK):
        assert {("fill", colour.lower()), ("stroke", colour.lower())} <= NAMES.keys()
    shown = [DARK[NAMES["stroke", colour.lower()]] for colour in style.COLOURS]
    for one, other in combinations(shown, 2):
        apart = [
            abs(int(one[k : k + 2], 16) - int(other[k : k + 2], 16)) for k in (1, 3, 5)
        ]
        assert sum(apart) >= 80, (one, other)


MARKS = """
figure => {
  const sheet = figure.querySelector(".sos-sheet").getBoundingClientRect();
  return [...figure.querySelectorAll("svg g > use[x]")]
    .map((mark) => mark.getBoundingClientRect())
    .filter(({left, top, right, bottom}) => left > sheet.left && top > sheet.top &&
      right < sheet.right && bottom < sheet.bottom)
    .map(({left, top, right, bottom}) =>
      [left - sheet.left, top - sheet.top, right - sheet.left, bottom - sheet.top]);
}
"""


@pytest.mark.parametrize(
    "page", ["28_feasibility_maps", *campaign(["07_grasping_robot"])]
)
def test_paper_is_dark_and_each_mark_is_seen(site, visit, page):
    """Pixel by pixel, as the browser draws marks that are used again."""
    tab = visit(site / "book" / f"{page}.html", scheme="dark", painted=True)
    figures = tab.page.locator("figure.sos-figure:visible")
    seen = 0
    for figure in figures.all():
        sheet = figure.locator(".sos-sheet")
        sheet.scroll_into_view_if_needed()
        boxes = figure.evaluate(MARKS)
        picture = imread(io.BytesIO(sheet.screenshot()))[:, :, :3]
        assert np.mean(picture.mean(axis=2) > 0.5) < 0.4
        for left, top, right, bottom in boxes:
            box = picture[
                int(top) - 1 : int(bottom) + 2, int(left) - 1 : int(right) + 2
            ]
            colours = np.unique((255 * box.reshape(-1, 3)).round().astype(int), axis=0)
            best = max(
                contrast("#" + bytes(rgb).hex(), PAPER) for rgb in colours.tolist()
            )
            assert best >= 3, (figure.get_attribute("id"), left, top)
            seen += 1
    assert seen > 100
