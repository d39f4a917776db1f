"""Figures of a delayed loop: what is drawn is what was computed."""

import numpy as np
import pytest
from scipy.special import lambertw

from sosbook.book.plots import decay_curve, delay_signal, root_map, show
from sosbook.delay import (
    ConstantDelay,
    RandomDelay,
    SawtoothDelay,
    SineDelay,
    SwitchingDelay,
)


def names(ax):
    return [text.get_text() for text in ax.get_legend().get_texts()]


def test_roots_are_where_they_are(ax):
    roots = np.array([-1 + 2j, -1 - 2j, -3])
    root_map(ax, roots, delta=0.5, label="ours")
    drawn = ax.collections[0].get_offsets()
    assert np.allclose(drawn, np.c_[roots.real, roots.imag])
    assert np.allclose(ax.lines[-1].get_xdata(), -0.5)
    assert names(ax) == ["ours", "Re s = -0.5"]


def test_sets_of_roots_differ_in_colour_and_the_axes_are_drawn_once(ax):
    root_map(root_map(ax, [-1], label="a"), [-2, -3], label="b")
    first, second = ax.collections
    assert len(ax.lines) == 2
    assert not np.allclose(first.get_edgecolor(), second.get_edgecolor())
    root_map(ax, [-4], colour="black", delta=0)
    assert np.allclose(ax.collections[2].get_edgecolor(), [[0, 0, 0, 1]])
    assert names(ax) == ["a", "b", "Re s = 0"]


def test_decay_curve_against_lambert_w(ax):
    delays = np.array([0.1, 0.3, 1.0])
    decay_curve(ax, [[0]], [[-1]], delays, (0.2, 0.4), 0.3, "loop")
    curve = ax.lines[-1]
    assert np.allclose(curve.get_xdata(), delays)
    assert np.allclose(curve.get_ydata(), (lambertw(-delays) / delays).real)
    assert names(ax) == ["interval of delays", "−δ = -0.3", "loop"]
    decay_curve(ax, [[-1]], [[0]], delays, label="another")
    assert ax.lines[-1].get_color() != curve.get_color()
    assert ax.lines[-1].get_linestyle() != curve.get_linestyle()


@pytest.mark.parametrize(
    "delay",
    [
        ConstantDelay(0.2),
        SineDelay(0.1, 0.3, omega=40),
        SawtoothDelay(0.1, 0.4),
        SwitchingDelay(0.1, 0.3, dwell=0.5),
        RandomDelay(0.1, 0.3, dwell=0.5, seed=0),
    ],
    ids=lambda delay: type(delay).__name__,
)
def test_a_delay_is_drawn_as_it_is(ax, delay):
    delay_signal(ax, delay, t_end=2)
    t, d = ax.lines[0].get_data()
    whole = np.isfinite(d)
    assert (~whole).sum() == len(delay.jumps(2))
    assert t[0] == 0 and t[-1] == 2 and (np.diff(t) >= 0).all()
    edges = np.r_[delay.jumps(2), 2]
    between = whole & (abs(t[:, None] - edges).min(1) > 1e-6)
    assert np.allclose(d[between], delay(t[between]))
    middle = (t[1:] + t[:-1]) / 2  # what the eye reads off
    seen = (d[1:] + d[:-1]) / 2
    inside = np.isfinite(seen) & (np.diff(t) > 1e-6)
    assert np.allclose(seen[inside], delay(middle[inside]), atol=1e-3)


def test_no_gap_is_bridged(ax):
    delay_signal(ax, SwitchingDelay(0.1, 0.3, dwell=1), t_end=3)
    _, d = ax.lines[0].get_data()
    steps = abs(np.diff(d))
    assert np.nanmax(steps) == 0


def test_the_figures_are_accessible_svg(ax):
    root_map(ax, [-1 + 1j, -1 - 1j], label="ours")
    assert 'role="img"' in show(ax.figure, alt="Two roots").html
