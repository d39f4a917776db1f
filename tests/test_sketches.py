"""Parts of a drawing join where they are told to."""

import matplotlib.pyplot as plt
import numpy as np
import pytest
from sosbook.plots import sketches


@pytest.fixture
def ax():
    figure, ax = plt.subplots()
    yield sketches.canvas(ax, 4, 3)
    plt.close(figure)


@pytest.mark.parametrize("part", [sketches.spring, sketches.damper])
@pytest.mark.parametrize("end", [(3, 1), (1, 2.5), (2, 2)])
def test_a_part_joins_its_ends(ax, part, end):
    part(ax, (1, 1), end, "$k$")
    x, y = ax.lines[0].get_data()
    assert np.allclose([x[0], y[0]], (1, 1))
    assert np.allclose([x[-1], y[-1]], end)
    (label,) = ax.texts
    assert label.get_text() == "$k$"


def test_a_spring_stays_within_its_width(ax):
    sketches.spring(ax, (1, 1), (3, 1), coils=4, width=0.2)
    _, y = ax.lines[0].get_data()
    assert np.isclose(y.max(), 1.2) and np.isclose(y.min(), 0.8)
    assert np.sum(np.isclose(np.abs(y - 1), 0.2)) == 8


def test_a_weightless_mass_is_dashed(ax):
    sketches.mass(ax, (1, 1), "m")
    sketches.mass(ax, (3, 1), "0", weightless=True)
    solid, dashed = ax.patches
    assert solid.get_linestyle() in ("-", "solid")
    assert dashed.get_linestyle() in ("--", "dashed")
    assert np.allclose(solid.get_xy().mean(axis=0)[0], 1, atol=0.4)


def test_a_force_ends_at_its_tip(ax):
    sketches.force(ax, (2, 1), (0, 0.5), "u")
    arrow, label = ax.texts
    assert arrow.xy == (2, 1)
    assert np.allclose(arrow.xyann, (2, 0.5))
    assert label.get_position()[1] < 0.5


def test_a_displacement_starts_at_its_tail(ax):
    sketches.displacement(ax, (1, 1), (0, 0.5), "z")
    arrow = ax.texts[0]
    assert np.allclose(arrow.xyann, (1, 1))
    assert ax.texts[-1].get_position()[1] > 1.5


def test_a_wall_is_hatched_on_one_side(ax):
    sketches.wall(ax, (0, 1), (4, 1))
    _, hatch = ax.lines
    assert np.nanmax(hatch.get_ydata()) <= 1
    assert np.nanmin(hatch.get_ydata()) < 1
