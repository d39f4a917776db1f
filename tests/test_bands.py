"""Figures over a polytope: what is drawn is what was given."""

import numpy as np
import pytest

import sosbook as sos
from sosbook.analysis.linear import poles
from sosbook.book import thesis
from sosbook.book.plots import envelope, pole_cloud, track_poles
from sosbook.plants.descriptor import descriptors


@pytest.fixture(scope="module")
def seats():
    ex = thesis.example_2()
    masses = np.arange(70, 121, 5)
    plants = sos.Polytope([thesis.car_seat(m) for m in masses])
    loops = descriptors(plants, ex.U)
    return masses, np.array([poles(d, ex.K) for d in loops]), ex.region


def test_band_is_the_envelope(ax):
    t = np.linspace(0, 1, 11)
    signals = np.array([t, 1 - t, 0.5 + 0 * t])
    envelope(ax, t, signals, "z")
    corners = ax.collections[0].get_paths()[0].vertices
    for at, low, high in zip(t, signals.min(0), signals.max(0)):
        heights = corners[np.isclose(corners[:, 0], at), 1]
        assert np.isclose(heights.min(), low)
        assert np.isclose(heights.max(), high)


def test_band_draws_the_named_plant_and_keeps_the_last_time(ax):
    t = np.linspace(0, 3, 1001)
    signals = np.array([np.sin(t), 2 * np.sin(t), 3 * np.sin(t)])
    envelope(ax, t, signals, middle=1, points=50)
    x, y = ax.lines[0].get_data()
    assert len(x) <= 52 and x[-1] == 3
    assert np.allclose(y, 2 * np.sin(x))


@pytest.mark.parametrize(
    "signals", [np.zeros((2, 4)), np.zeros((0, 3)), np.zeros((2, 2, 3))]
)
def test_band_refuses_what_does_not_fit(ax, signals):
    with pytest.raises(ValueError, match="needs a row for each plant"):
        envelope(ax, [0, 1, 2], signals)


def test_branches_permute_rows_and_move_little(seats):
    _, found, _ = seats
    rng = np.random.default_rng(1)
    shuffled = np.array([rng.permutation(row) for row in found])
    followed = track_poles(shuffled)
    for row, kept in zip(shuffled, followed):
        assert np.array_equal(np.sort_complex(row), np.sort_complex(kept))
    jumps = np.abs(np.diff(followed, axis=0))
    assert jumps.max() < 0.25 * np.abs(found).max()
    assert jumps.sum() <= np.abs(np.diff(shuffled, axis=0)).sum()


def test_a_pair_that_meets_parts_the_same_way_whatever_the_order():
    rows = [[-2 + 1j, -2 - 1j], [-1.5, -2.5], [-1.8 + 1j, -1.8 - 1j]]
    for noise in (1e-15, -1e-15):
        for flip in (1, -1):
            shaken = [
                rows[0],
                np.array(rows[1])[::flip] + noise,
                np.array(rows[2])[::flip],
            ]
            upper = track_poles(shaken)[:, 0]
            assert np.allclose(upper, [-2 + 1j, -2.5, -1.8 + 1j])


def test_branches_leave_the_argument_alone():
    poles = np.array([[-1.0, -3], [-3, -1]])
    track_poles(poles)
    assert poles[1, 0] == -3


def test_pole_cloud_marks_both_ends(ax, seats):
    masses, found, region = seats
    pole_cloud(ax, found, masses, region, name="m_s (kg)")
    first, last = ax.lines[-2:]
    marked = np.sort_complex(first.get_xdata() + 1j * first.get_ydata())
    assert np.allclose(marked, np.sort_complex(found[0]))
    marked = np.sort_complex(last.get_xdata() + 1j * last.get_ydata())
    assert np.allclose(marked, np.sort_complex(found[-1]))
    words = [text.get_text() for text in ax.get_legend().get_texts()]
    assert words == ["D-region", "m_s (kg) = 70", "m_s (kg) = 120"]
    assert ax.get_xlim()[0] < -15  # the whole disk is seen


def test_pole_cloud_refuses_what_does_not_fit(ax):
    with pytest.raises(ValueError, match="needs one for each of the 2 rows"):
        pole_cloud(ax, [[-1], [-2]], [1, 2, 3])
    with pytest.raises(ValueError, match="poles must have a row"):
        pole_cloud(ax, [], [])
