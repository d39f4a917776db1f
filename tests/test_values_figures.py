"""Drawings of the book's own outputs: which changes count and which don't."""

import random
import re
from functools import cache

import numpy as np
import pytest

from tests.each import each
from tests.test_values import PAGES
from tests.values import figures, pages, shapes
from tests.values.trees import parse

FIGURES = [(name, page) for name, page in PAGES if "sos-figure" in page]
NAMES = [name for name, _ in FIGURES]
SOME = random.Random(4).sample(FIGURES, 24)
# A line of a plot in its frame, not a line of the grid.
CURVE = re.compile(
    r'<path d="([^"]*)" clip-path="[^"]*" '
    r'style="fill:none;(?:stroke-dasharray:[^;]*;stroke-dashoffset:0;)?'
    r'stroke:(?!#e3e5e8)[^"]*"/>'
)
MARK = re.compile(r'<use xlink:href="#[\w-]+" x="([^"]*)" y="([^"]*)"[^>]*/>')


def curves(page, points=3):
    """Matches of all lines in plots with so many points."""
    return [found for found in CURVE.finditer(page) if found[1].count("L") >= points]


def replaced(page, found, new, group=1):
    start, end = found.span(group)
    return page[:start] + new + page[end:]


def shifted(data, x, y):
    """Path data with absolute pairs of coordinates, elsewhere."""

    def pair(found):
        return f"{float(found[1]) + x:.2f} {float(found[2]) + y:.2f}"

    return re.sub(r"(-?[\d.]+) (-?[\d.]+)", pair, data)


@cache
def tree(page):
    return next(node for node in parse(page).elements() if node.tag == "svg")


def with_other_names(page):
    """The same figure with other ids."""
    return re.sub(
        r'(id="|href="#|url\(#)(f[0-9a-f]{6})-(\d+)',
        lambda found: f"{found[1]}g-{int(found[3]) + 7}",
        page,
    )


@each("name, page", FIGURES[::3])  # a notebook that runs has its figures compared
def test_a_figure_agrees_with_itself_under_other_names(name, page):
    other = with_other_names(page)
    assert other != page
    assert pages.differences(page, other) == []


CUT = [(name, page) for name, page in FIGURES if "data-parts" in page]


@each("name, page", CUT)
def test_each_letter_of_a_figure_is_in_a_part_that_a_phone_shows(name, page):
    """Within the two points that the page leaves around a part."""
    drawing = tree(page)
    parts = [box.split() for box in drawing.attributes["data-parts"].split(";")]
    x, y, width, height = np.array(parts, float).T
    for letter in shapes.drawn(drawing):
        if letter.kind == "glyph":
            at = np.reshape(letter.corners, (2, 2))
            (left, top), (right, bottom) = at.min(0), at.max(0)
            across = (x - 2 < left) & (right < x + width + 2)
            assert (across & (y - 2 < top) & (bottom < y + height + 2)).any(), at


def test_a_curve_that_moved_is_found_and_half_a_px_is_forgiven():
    seen = 0
    for name, page in SOME:
        for found in curves(page)[:2]:
            near = replaced(page, found, shifted(found[1], 0.35, 0.35))
            assert pages.differences(page, near) == [], name
            for by in ((3, 0), (0, 3)):
                far = replaced(page, found, shifted(found[1], *by))
                assert "moved by" in str(pages.differences(page, far)), name
            seen += 1
    assert seen > 15


def test_a_mark_that_moved_or_is_missing_is_found_in_any_order():
    seen = 0
    for name, page in FIGURES[::4]:
        groups = re.findall(r"(?:<use [^>]* x=[^>]*/>){4,}", page)
        if not groups:
            continue
        group = groups[-1]
        marks = [found[0] for found in MARK.finditer(group)]
        random.Random(2).shuffle(marks)
        assert pages.differences(page, page.replace(group, "".join(marks))) == [], name
        x, y = MARK.match(marks[0]).groups()
        far = marks[0].replace(f'y="{y}"', f'y="{float(y) + 3:.2f}"', 1)
        for fewer in ([far, *marks[1:]], marks[1:], [*marks, marks[0]]):
            assert pages.differences(page, page.replace(group, "".join(fewer))), name
        seen += 1
    assert seen > 10


def svg(*elements):
    drawing = f'<svg viewBox="0 0 200 100">{"".join(elements)}</svg>'
    return parse(drawing).children[0]


def path(data, style="stroke:#000000"):
    return f'<path d="{data}" style="{style}"/>'


LOOP = "M50 20L80 20L80 50L50 50z"


@pytest.mark.parametrize(
    "old, new",
    [
        (path("M0 0L100 50"), path("M0 0L30 15L100 50")),
        (path("M0 0L100 50"), path("M0.5 0L100.5 50")),
        (path("M0 0L100 50"), path("M0 0.5L100 50.3L0 0.2")),
        (path(LOOP), path("M80 50L50 50L50 20L80 20z")),
        (path(LOOP), path("M50 20L50 50L80 50L80 20z")),
        (path(LOOP + "M0 0L9 9"), path("M0 0L9 9" + LOOP)),
        (path("M0 0L9 9L50 50"), path("M0 0L9 9M9 9L50 50")),
        (path("M0 0C30 0 60 0 90 0"), path("M0 0L90 0")),
        (path("M0 0h90v40"), path("M0 0L90 0L90 40")),
        (path("M-900 50L900 50"), path("M-700 50L950 50")),
        (
            path("M0 0L9 9") + path("M0 50L90 50"),
            path("M0 50L90 50") + path("M0 0L9 9"),
        ),
        ("<circle cx='20' cy='20' r='5'/>", "<circle cx='20.4' cy='20' r='5'/>"),
        ("<text x='5' y='5'>0.50 Hz</text>", "<text x='5.4' y='5'>0.51 Hz</text>"),
        (
            "<g transform='rotate(90 5 5)'>" + path(LOOP) + "</g>",
            "<g transform='translate(10 0) rotate(90)'>" + path(LOOP) + "</g>",
        ),
    ],
)
def test_what_a_reader_cannot_see_is_forgiven(old, new):
    assert figures.differences(svg(old), svg(new)) == []
    assert figures.differences(svg(new), svg(old)) == []


@pytest.mark.parametrize(
    "old, new",
    [
        (path("M0 0L100 50"), path("M0 3L100 53")),
        (path("M0 0L100 50"), path("M0 0L100 50", "stroke:#ff0000")),
        (path("M0 0L100 50"), path("M0 0L50 25")),
        (path("M0 0L100 50"), path("M0 0L40 20M60 30L100 50")),
        (path("M0 0L100 50"), path("M0 0L50 29L100 50")),
        (path(LOOP), path(LOOP) + path(LOOP)),
        (path(LOOP), path(LOOP + "M0 0L9 9")),
        (path(LOOP), path("M50 20L80 20L80 50L50 50")),
        (path(LOOP), "<g opacity='0.5'>" + path(LOOP) + "</g>"),
        ("<circle cx='20' cy='20' r='5'/>", "<circle cx='20' cy='20' r='8'/>"),
        ("<circle cx='20' cy='20' r='5'/>", "<circle cx='23' cy='20' r='5'/>"),
        ("<text x='5' y='5'>feasible</text>", "<text x='5' y='5'>infeasible</text>"),
        ("<text x='5' y='5'>0.50 Hz</text>", "<text x='5' y='5'>0.52 Hz</text>"),
        ("<text x='5' y='5'>Hz</text>", "<text x='9' y='5'>Hz</text>"),
        ("<text fill='red'>Hz</text>", "<text fill='blue'>Hz</text>"),
    ],
)
def test_what_a_reader_sees_is_found(old, new):
    assert figures.differences(svg(old), svg(new))
    assert figures.differences(svg(new), svg(old))


@pytest.mark.parametrize(
    "one, two",
    [("M-3 3L3 -3", "M-3 0L3 0"), ("M0 -3L3 0L0 3L-3 0z", "M-3 -3L3 -3L3 3L-3 3z")],
)
def test_another_mark_is_found(one, two):
    mark = "<defs><path id='a' d='{}'/></defs><use xlink:href='#a' x='50' y='50'/>"
    assert figures.differences(svg(mark.format(one)), svg(mark.format(two)))


def test_a_letter_is_compared_closely():
    letter = (
        "<g transform='translate(20 20) scale(0.09 -0.09)'><defs><path id='a' "
        "d='M0 0L{} 0' transform='scale(0.015625)'/></defs>"
        "<use xlink:href='#a'/></g>"
    )
    assert figures.differences(svg(letter.format(640)), svg(letter.format(650)))


def test_messages_name_the_curve_and_how_far_it_moved():
    old = path("M0 0L9 9", "stroke:#d55e00") + path("M0 50L90 50", "stroke:#0072b2")
    assert figures.differences(svg(old), svg(old.replace("50", "53.2"))) == [
        "curve 2 (stroke:#0072b2) moved by 3.2 px at (0, 50)"
    ]
    fewer = path("M0 0L9 9", "stroke:#d55e00")
    assert figures.differences(svg(old), svg(fewer)) == [
        "stored 1 curve (stroke:#0072b2), now nothing at (0, 50)"
    ]


def test_clips_hide_what_is_outside():
    clip = (
        "<defs><clipPath id='c'><rect x='0' y='0' width='{}' height='60'/>"
        "</clipPath></defs><path d='M0 {}L40 40L90 {}' clip-path='url(#c)'/>"
    )
    shown = svg(clip.format(50, 10, 40))
    assert figures.differences(shown, svg(clip.format(50, 10.4, 40))) == []
    assert figures.differences(shown, svg(clip.format(60, 10, 40)))
    assert shapes.drawn(shown)[1].box == (0, 0, 50, 60)


def test_every_figure_of_the_book_is_read_completely():
    """No letter is lost: each use that is not in defs is a shape."""
    for name, page in FIGURES:
        drawn = shapes.drawn(tree(page))
        count = sum(shape.kind in ("mark", "glyph") for shape in drawn)
        assert count == page.count("<use "), name
        assert not any(shape.text for shape in drawn), name
