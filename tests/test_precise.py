"""Loops that are too sensitive for floats, against mpmath's arithmetic."""

import mpmath
import numpy as np
import pytest

import sosbook as sos
from sosbook.analysis import linear
from sosbook.analysis.precise import ExactLoop, sensitive
from sosbook.book import thesis
from tests.cases import by_turns

mpmath.mp.dps = 60


def alike(gap, time=1.0, force=1.0):
    """Two masses whose frequencies differ by ``gap``, one force for both."""
    return sos.SecondOrderSystem(
        np.eye(2) * time**2 / force,
        0.01 * np.eye(2) * time / force,
        np.diag([1, 1 + gap]) / force,
        [[1], [1]],
        [[1], [0]],
    )


def matrices(d, K):
    """A + B K and B_w in state space, the floats read as decimals."""

    def matrix(x):
        return mpmath.matrix([[mpmath.mpf(repr(float(e))) for e in r] for r in x])

    E, A, B, Bw = map(matrix, (d.E, d.A, d.Bu, d.Bw))
    back = E**-1
    return back * (A + B * matrix(K)), back * Bw


def designed(gap, **units):
    d = sos.design_pid(
        alike(gap, **units), region=sos.PoleRegion(sigma=1 / units.get("time", 1.0))
    )
    assert d.status == "feasible"
    (v,) = d.request.vertices
    return d, v


@pytest.mark.parametrize(
    "gap, units",
    [
        (1e-4, {}),
        (1e-5, {}),
        (1e-6, {}),
        (1e-4, dict(time=1e-3, force=1e3)),
        (1e-6, dict(time=1e3)),
    ],
)
def test_poles_never_contradict_the_proof(gap, units):
    no_contradiction(*designed(gap, **units), units)


@pytest.mark.parametrize("gap", [3e-7, 1e-7, 3e-8, 1e-12])
def test_poles_never_contradict_the_proof_where_floats_end(gap):
    """Whether floats find the gain there depends on the processor's last bits."""
    d = sos.design_pid(alike(gap), region=sos.PoleRegion(sigma=1))
    if d.status == "feasible":
        no_contradiction(d, d.request.vertices[0], {}, 17)
    else:
        assert (d.status, d.infeasibility) == ("undecided", None) and d.reason


def no_contradiction(d, v, units, digits=10):
    assert d.certify(digits).proven
    A, _ = matrices(v, d.K)
    true = np.array([complex(s) for s in mpmath.eig(A, left=False, right=False)])
    found = np.asarray(d.poles(), complex)
    size = np.abs(true).max()
    for s in true:
        assert np.abs(found - s).min() < 1e-9 * size
    assert found.real.max() < -1 / units.get("time", 1.0)


@pytest.mark.parametrize("gap", by_turns([1e-4, 1e-6], 1))
def test_norm_and_peak_of_a_sensitive_loop(gap):
    d, v = designed(gap)
    A, Bw = matrices(v, d.K)
    one = mpmath.eye(4)

    def gain(omega):
        z = (mpmath.mpc(0, omega) * one - A) ** -1 * Bw
        return float(mpmath.norm(z[:2, 0]))

    known = max(gain(w) for w in np.geomspace(1e-2, 1e2, 200))
    assert known * (1 - 1e-9) <= d.hinf() <= known * 1.01
    x0 = mpmath.matrix([1, 0, 0, 0])
    K = mpmath.matrix(d.K.tolist())
    step, peak = mpmath.expm(A * mpmath.mpf("0.005")), 0.0
    for _ in range(1200):
        peak, x0 = max(peak, abs(float((K * x0)[0]))), step * x0
    found = linear.peak_input(v, d.K, [1, 0, 0, 0])
    assert peak * (1 - 1e-9) <= found <= peak * 1.01


def test_a_plain_loop_is_left_to_floats_and_agrees():
    ex = thesis.example_1()
    d = sos.analyse_pid(ex.plant, ex.K, ex.U)
    (v,) = d.request.vertices
    assert not sensitive(v, ex.K)
    loop = ExactLoop(v, ex.K)
    x0 = [0.2, 0.2, 0.8, 0.8, 0.1, 0.1]
    assert np.allclose(np.sort_complex(loop.poles()), np.sort_complex(d.poles()))
    assert np.isclose(loop.hinf_norm(), d.hinf(), rtol=1e-9)
    assert np.isclose(loop.peak_input(x0), linear.peak_input(v, ex.K, x0), rtol=1e-6)


def test_a_mode_on_the_axis_is_neither_stable_nor_lost():
    """z'' + z = u with K = 0: rounding hides the sign of the real part."""
    plant = sos.SecondOrderSystem([[1]], [[0]], [[1]], [[1]], [[1]])
    d = sos.analyse_pid(plant, [[0.0, 0.0]])
    assert d.status == "infeasible" and d.infeasibility.proven
    assert (np.asarray(d.poles()).real == 0).all()
    assert d.hinf() == np.inf
