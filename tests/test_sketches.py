"""Parts of a drawing join where they are told to; figures are compared as stored."""

import re

import matplotlib.pyplot as plt
import numpy as np
import pytest

from sosbook.book import plots
from sosbook.book.plots import mechanisms, sketches


@pytest.fixture
def ax():
    figure, ax = plt.subplots()
    yield sketches.canvas(ax, 4, 3)
    plt.close(figure)


@pytest.mark.parametrize("right_wall", [False, True])
def test_links_of_a_row_join_its_bodies(ax, right_wall):
    links = [("k", "b")] * (2 + right_wall)
    mechanisms.row(ax, ["1", "2"], links, right_wall=right_wall)
    sides = [patch.get_xy()[:, 0] for patch in ax.patches]
    walls = 1 + right_wall
    parts = [line.get_xdata() for line in ax.lines[2 * walls :]]
    assert len(parts) == 2 * len(links)
    for start, end in ((x[0], x[-1]) for x in parts[2:4]):
        assert np.isclose(start, sides[0].max())
        assert np.isclose(end, sides[1].min())
    assert ax.get_xlim()[1] > max(x.max() for x in (*sides, *parts[-1:]))


def test_a_row_wants_a_link_for_each_body(ax):
    with pytest.raises(ValueError, match="one for each body"):
        mechanisms.row(ax, ["1", "2"], [("k", None)])


@pytest.mark.parametrize("draw", [mechanisms.hand, mechanisms.cart_pendulum])
def test_a_drawing_stays_on_its_canvas(ax, draw):
    draw(ax)
    (left, right), (low, high) = ax.get_xlim(), ax.get_ylim()
    for patch in ax.patches:
        x, y = patch.get_xy().T
        assert left < x.min() and x.max() < right
        assert low < y.min() and y.max() < high
    for text in ax.texts:
        x, y = text.xy if hasattr(text, "xy") else text.get_position()
        assert left < x < right and low < y < high


@pytest.mark.parametrize("axis", [0, 1])
def test_what_sways_stays_joined(axis):
    """A spring's end moves as its body does, its other end not at all."""
    figure, ax = plt.subplots()
    sketches.canvas(ax, 6, 6)
    ends = [(1, 3), (3, 3)] if axis == 0 else [(3, 1), (3, 3)]
    sketches.spring(ax, *ends)
    sketches.mass(ax, (4, 3) if axis == 0 else (3, 4), "", (2, 2))
    sketches.sway(ax, [(1, 0), (3, 0.5), (5, 0.5)], axis)
    svg = plots.show(figure, alt="A mass on a spring.").svg
    found = re.findall(r"sway-(\d)\" style=\"--by:(\S+)px;--more:(\S+);--from", svg)
    (kind, start, more), (_, body, none) = found[:2]
    assert [int(kind), *map(float, (start, more, none))] == [axis, 0, 0.25, 0]
    unit = ax.transData.transform((1, 1)) - ax.transData.transform((0, 0))
    moved = 0.5 * unit[axis] * 72 / figure.dpi
    assert abs(float(body)) == pytest.approx(moved, abs=0.01)
    assert (float(body) > 0) is (axis == 0)  # up is the other way in an SVG
