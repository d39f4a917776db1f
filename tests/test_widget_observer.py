"""The explorer of observers, against Riccati equations and free motions."""

import re
from functools import cache

import control
import numpy as np
import pytest
from scipy.integrate import odeint
from sosbook.mip import Mip, reduced, vertices
from sosbook.widgets import observer as widget
from sosbook.widgets.observer import explore_observer

import sosbook as sos
from sosbook import design_observer, observer_loop

C = np.array([[0, 1, 0], [0, 0, 1]])


START = dict(factor=1.0, gyro=0.01, wheels=0.1, R=1.0, spread=4.0)


@cache
def explorer():
    return explore_observer()


@cache
def shown(**asked):
    """The last picture for these positions of the sliders."""
    return list(explorer().draw(**START | asked))[-1]


def plants(spread=4.0):
    """(A, B) of each vertex, by the equations of motion solved."""
    found = []
    for mip in vertices(Mip.printed(), spread / 100):
        step = 1e-6
        A = np.zeros((3, 3))
        A[0, 1] = 1
        for k in range(3):
            x = np.zeros(3)
            x[k] = step
            A[1:, k] = mip.acceleration([x[0], 0], x[1:], 0) / step
        B = np.r_[0, mip.acceleration([0, 0], [0, 0], 1)][:, None]
        found.append((A, B))
    return found


def regulator(R=1.0, spread=4.0):
    A, B = plants(spread)[0]
    return -control.lqr(A, B, np.eye(3), [[R]])[0]


def mean(spread=4.0):
    four = [v.plant() for v in vertices(Mip.printed(), spread / 100)]
    M, D, S, B = (np.mean([getattr(p, x) for p in four], axis=0) for x in "MDSB")
    A = np.vstack([[0, 1, 0], -np.linalg.solve(M, np.c_[S[:, 0], D])])
    return A, np.vstack([[[0]], np.linalg.solve(M, B)])


def kalman(factor=1.0, gyro=0.01, wheels=0.1, spread=4.0):
    A, B = mean(spread)
    return -control.lqe(A, 2 * factor * B, C, [[1]], np.diag([gyro, wheels]))[0]


def columns(picture):
    """K and each L, as shown."""
    table = re.search("<table class='gains'>(.*?)</table>", picture)[1]
    rows = [re.findall(r">(-?[\d.e+-]+)</td>", row) for row in table.split("<tr>")]
    return np.array([row for row in rows if row], float)


def facts(picture):
    """Status, rightmost pole, peak and fastest own pole of each row."""
    table = re.search("<table class='facts'>(.*?)</table>", picture)[1]
    return [re.findall("<td.*?>(.*?)</td>", row) for row in table.split("<tr>")[2:]]


def test_it_starts_with_table_4_3():
    K, L = sos.thesis.mip().lqe[1]
    found = columns(shown())
    assert np.allclose(found[:, 0], np.ravel(K), rtol=2e-4)
    assert np.allclose(found[1:, 3:], np.array(L)[1:], rtol=1e-3)
    assert np.allclose(found[0, 3:], np.array(L)[0], atol=0.11)
    assert "<strong>feasible</strong> at the vertices" in shown()
    assert "<strong>proven stable</strong>" in shown()


@pytest.mark.slow
def test_each_slider_moves_the_filter_and_the_regulator():
    explorer, asked = explore_observer(), dict(START)
    assert explorer.picture.value == shown()
    for name, value in dict(
        spread=8.0, factor=2.0, gyro=0.1, wheels=1.0, R=10.0
    ).items():
        explorer.sliders[name].value = asked[name] = value
        found = columns(explorer.picture.value)
        R, noise = asked["R"], {k: asked[k] for k in asked if k != "R"}
        assert np.allclose(found[:, 0], regulator(R, asked["spread"]), rtol=1e-3)
        assert np.allclose(found[:, 1:3], kalman(**noise), rtol=1e-3)


def test_three_noises_have_two_ratios():
    """All standard deviations times two: no other observer."""
    twice = shown(factor=2.0, gyro=0.04, wheels=0.4)
    assert np.allclose(columns(twice), columns(shown()), rtol=2e-3)


def test_the_theorem_is_the_one_of_design_observer():
    picture = shown(wheels=1.0, R=10.0, spread=10.0)
    push = 2 * mean(10.0)[1]
    design = design_observer(
        reduced(Mip.printed(), 0.1),
        regulator(10.0, 10.0),
        np.vstack([push, 0 * push]),
        np.sqrt(np.diag([0.01, 1.0])),
    )
    assert np.allclose(columns(picture)[:, 3:], design.L, rtol=1e-3)
    bound = re.search(r"tr J = ([\d.e+]+)\.", picture)[1]
    assert float(bound) == pytest.approx(design.bound, rel=1e-3)


def test_where_the_theorem_finds_nothing_the_filter_is_still_proven():
    picture = shown(spread=20.0)
    assert "Theorem 2.5: <strong>undecided</strong>" in picture
    assert columns(picture).shape == (3, 3)
    (row,) = facts(picture)
    assert row[0] == "proven stable"
    loop = observer_loop(
        reduced(Mip.printed(), 0.2), regulator(1.0, 20.0), kalman(spread=20.0), C
    )
    proof = sos.analyse_loop(loop.E, loop.A).certify()
    assert proof.claims == ("every plant of the polytope is stable",)


def test_a_wide_polytope_is_not_called_proven():
    picture = shown(spread=70.0)
    assert "not proven (infeasible)" in picture
    assert "proven stable" not in picture


def test_the_first_picture_promises_nothing_between_the_vertices():
    first = next(explorer().draw(**START))
    assert "proven" not in first and "Theorem 2.5" not in first
    assert "the vertices are stable" in first


def loops(K, L):
    """x and x^ of plant and observer side by side, for each vertex."""
    A_hat, B_hat = mean()
    inner = A_hat + B_hat @ K + L @ C
    return [np.block([[A, B @ K], [-L @ C, inner]]) for A, B in plants()]


def test_the_curves_are_the_motions_of_plant_and_observer():
    K, L = regulator(), kalman()
    loop = widget.Loop("", "", reduced(Mip.printed()), K, L)
    start, peaks = np.r_[np.radians(5), np.zeros(5)], []
    for F, run in zip(loops(K, L), loop.run):
        x = odeint(
            lambda x, t: F @ x,
            start,
            widget.RELEASE_TIMES,
            Dfun=lambda x, t: F,
            rtol=1e-8,
            atol=1e-10,
        ).T
        assert np.allclose(run[3:], x[:3], atol=1e-5)
        assert np.allclose(run[:3], x[:3] - x[3:], atol=1e-5)
        peaks.append(np.abs(K @ x[3:]).max())
    assert loop.peak == pytest.approx(max(peaks), rel=1e-3)


def test_the_facts_are_those_of_the_loop_and_of_the_controller_alone():
    K, L = regulator(), kalman()
    four = loops(K, L)
    status, right, _, fast = facts(shown())[0]
    assert status == "proven stable"
    assert float(right) == pytest.approx(
        max(np.linalg.eigvals(F).real.max() for F in four), rel=1e-3
    )
    own = np.linalg.eigvals(four[0][3:, 3:])
    assert float(fast) == pytest.approx(np.abs(own).max(), rel=1e-3)


def test_the_fastest_pole_of_the_controller_against_100_Hz():
    for picture, side in ((shown(), "BEYOND"), (shown(factor=0.1, gyro=1.0), "within")):
        fast = float(facts(picture)[-1][-1])
        assert (fast > np.pi / 0.01) == (side == "BEYOND")
        assert f"{side} half the sampling rate" in picture


def test_a_stable_loop_with_an_unstable_controller_is_named():
    """Nothing in the theorem asks the controller alone to be stable."""
    picture = shown(factor=0.1)
    A, B = mean()
    alone = A + B @ regulator() + columns(picture)[:, 3:] @ C
    assert np.linalg.eigvals(alone).real.max() > 0
    assert "The controller alone is UNSTABLE" in picture
    assert "<strong>proven stable</strong>" in picture


def test_a_loop_that_falls_is_named():
    loop = widget.Loop(
        "idle one", "", reduced(Mip.printed()), 0 * regulator(), kalman()
    )
    loop.analyse()
    assert "UNSTABLE at a vertex" in loop.message()
    assert loop.status.startswith("not proven")


def test_the_pictures_hold_every_vertex():
    poles, angle, error = re.findall("<svg role='img'.*?</svg>.*?</svg>", shown())
    assert poles.count("<path d='M") == poles.count("<circle") == 24
    assert angle.count("<polyline") == error.count("<polyline") == 9
