"""Poles, norms and peaks against python-control and brute force."""

from dataclasses import replace

import control
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import sosbook as sos
from sosbook.analysis.linear import hinf_norm, peak_gain, peak_input
from sosbook.analysis.precise import ExactLoop
from sosbook.book import thesis
from sosbook.plants.descriptor import descriptors
from tests.cases import campaign, random_plant, seeds
from tests.random_plants import ODD


def stable_loop(seed, p=2):
    """A random plant and the gain of a design for it."""
    rng = np.random.default_rng(seed)
    plant = random_plant(rng, 2, 2, p)
    d = sos.design_pid(plant, np.eye(2), region=sos.PoleRegion(0.3, rho=30))
    return d, descriptors(plant, np.eye(2))[0]


def lightly_damped(damping, scale=1.0, rate=1.0):
    """Two masses, K = 0; scale is F's size, rate the unit of time."""
    S = np.array([[3.0, -1], [-1, 2]])
    plant = sos.SecondOrderSystem(
        np.eye(2) / rate**2, damping * S / rate, S, np.eye(2), [[scale], [0.3 * scale]]
    )
    return descriptors(plant)[0], np.zeros((2, 4))


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_norm_and_poles_agree_with_python_control(seed):
    d, v = stable_loop(seed)
    loop = d.closed_loop()
    assert np.allclose(np.sort_complex(d.poles() + 0j), np.sort_complex(loop.poles()))
    w_to_z = control.ss(loop.A, loop.B[:, :2], loop.C[:2], loop.D[:2, :2])
    norm = control.system_norm(w_to_z, p="inf", tol=1e-9)
    assert np.isclose(hinf_norm(v, d.K), norm, rtol=1e-6, atol=0)


def test_norm_of_a_disturbance_that_does_nothing_is_zero():
    d, K = lightly_damped(0.5, scale=0)
    assert hinf_norm(d, K) == 0


def test_unstable_loops_have_no_finite_norm_or_peak():
    d, K = lightly_damped(-0.1)
    assert hinf_norm(d, K) == np.inf
    assert peak_input(d, K, np.ones(4)) == np.inf


def dense_peak(d, K, x0, end):
    A = np.linalg.solve(d.E, d.A + d.Bu @ K)
    done = solve_ivp(
        lambda t, x: A @ x,
        (0, end),
        x0,
        rtol=1e-10,
        atol=1e-12,
        method="LSODA",
        dense_output=True,
    )
    times = np.union1d(np.linspace(0, end, 20001), done.t)
    return np.linalg.norm(K @ done.sol(times), axis=0).max()


@pytest.mark.parametrize("seed", [1, 2, 3, 4])
def test_peak_against_a_dense_simulation(seed):
    d, v = stable_loop(seed)
    x0 = np.random.default_rng(seed).standard_normal(6)
    peak = peak_input(v, d.K, x0)
    assert np.isclose(peak, dense_peak(v, d.K, x0, 30), rtol=1e-6, atol=0)


def test_late_peak_of_a_stiff_loop():
    """Poles -1, -2 and -1e5: u = z1 / 1e9 peaks at ln 2, long after."""
    plant = sos.SecondOrderSystem(
        np.diag([1, 1e-5]), np.diag([3.0, 1]), np.diag([2, 1e-5]), np.eye(2)
    )
    (d,) = descriptors(plant)
    K = 1e-9 * np.array([[0.0, 0, 0, 0], [1, 0, 0, 0]])
    # z1(0) = 0, z1'(0) = 1: z1 = e^-t - e^-2t, at most 1/4
    peak = peak_input(d, K, [0, 0, 1, 0])
    assert np.isclose(peak, 0.25e-9, rtol=1e-6, atol=0)


def oscillator(damping, omega):
    """A loop with one resonance, the push of its gain, and its peak from z' = 1."""
    k = 0.3 * omega**2
    plant = sos.SecondOrderSystem(
        [[1.0]], [[2 * damping * omega]], [[omega**2 + k]], [[1.0]], [[1.0]]
    )
    (d,) = descriptors(plant)
    own = omega * np.sqrt(1 - damping**2)
    time = np.arctan2(own, damping * omega) / own
    peak = k * np.exp(-damping * omega * time) * np.sin(own * time) / own
    return d, np.array([[k, 0.0]]), peak


@pytest.mark.last_digits
@pytest.mark.parametrize("omega", [1e-9, 1e-3, 1.0, 3.3e4, 1e9])
@pytest.mark.parametrize("damping", [0.5, 1e-2, 1e-6, 1e-8])
def test_norm_and_peak_of_a_resonance_against_closed_forms(damping, omega):
    """Far from any sample, and whatever the unit of time."""
    d, K, peak = oscillator(damping, omega)
    norm = 1 / (2 * damping * np.sqrt(1 - damping**2)) / omega**2
    for loop in (hinf_norm(d, K), ExactLoop(d, K).hinf_norm()):
        assert loop == pytest.approx(norm, rel=1e-11)
    for found in (peak_input(d, K, [0, 1]), ExactLoop(d, K).peak_input([0, 1])):
        assert found == pytest.approx(peak, rel=1e-13)


@pytest.mark.parametrize("unit", [1e-9, ODD[0], *campaign([1.0, 1e9, *ODD[1:]])])
def test_peak_of_two_resonances_that_beat(unit):
    """u = exp(-1e-6 t) (cos t - cos 1.0037 t): largest after a hundred periods."""
    damping, faster = 1e-6, 1.0037
    rates = np.sqrt(np.array([1, faster]) ** 2 + damping**2)
    K = np.array([[1e-13, -1e-13, 0, 0]])
    plant = sos.SecondOrderSystem(
        np.eye(2),
        2 * damping * np.eye(2) / unit,
        np.diag(rates**2) / unit**2,
        [[1.0], [1.0]],
    )
    (d,) = descriptors(plant)
    t = np.linspace(845, 853, 400_001)
    peak = max(np.abs(np.exp(-damping * t) * (np.cos(t) - np.cos(faster * t))))
    x0 = [1, 1, -damping / unit, -damping / unit]
    found = peak_input(d, K / unit**2, x0) * unit**2
    assert found == pytest.approx(1e-13 * peak, rel=1e-9)


@pytest.mark.parametrize("seed", [1, 2])
def test_peak_of_several_inputs_in_other_units(seed):
    d, v = stable_loop(seed)
    x0 = np.random.default_rng(seed).standard_normal(6)
    peak = peak_input(v, d.K, x0)
    units = 10.0 ** np.random.default_rng(seed).integers(-9, 10, 6)
    there = replace(v, E=v.E / units, A=v.A / units)
    assert peak_input(there, d.K / units, x0 * units) == pytest.approx(peak, rel=1e-9)


def test_one_answer_for_each_vertex():
    seat = thesis.example_2()
    plants, asked = seat.plant, seat.requirements
    d = sos.design_pid(plants, **asked)
    assert d.poles().shape == (2, 6)
    assert len(d.closed_loop()) == 2
    single = [sos.analyse_pid(v, d.K, **asked) for v in plants.vertices]
    assert d.hinf() == max(s.hinf() for s in single)
    assert d.peak_input() == max(s.peak_input() for s in single)
    assert all(np.allclose(row, s.poles()) for row, s in zip(d.poles(), single))


def test_feedback_closes_the_open_loop():
    robot = thesis.example_1()
    design = sos.analyse_pid(robot.plant, robot.K, robot.U)
    loop = control.feedback(
        design.open_loop()[:, :2], control.ss([], [], [], robot.K), sign=1
    )
    assert np.allclose(np.sort_complex(loop.poles()), np.sort_complex(design.poles()))
    names = design.open_loop().input_labels
    assert names == ["u1", "u2", "w1", "w2", "r1", "r2"]


def test_samples_join_the_vertices_of_a_polytope():
    robot = thesis.example_1()
    heavy = sos.SecondOrderSystem(
        1.2 * robot.plant.M, robot.plant.D, robot.plant.S, robot.plant.B, robot.plant.F
    )
    design = sos.analyse_pid(
        sos.Polytope([robot.plant, heavy]), robot.K, **robot.requirements
    )
    few, many = design.poles(), design.poles(samples=5, seed=1)
    assert many.shape == (7, 6) and np.array_equal(many[:2], few)
    assert robot.region.contains(many)
    assert design.hinf() <= design.hinf(samples=5) < robot.gamma
    assert design.peak_input() <= design.peak_input(samples=5) <= 150


def test_a_single_plant_has_nothing_to_sample():
    robot = thesis.example_1()
    design = sos.analyse_pid(robot.plant, robot.K, robot.U)
    with pytest.raises(ValueError, match="samples asks for plants between several"):
        design.poles(samples=3)


@pytest.mark.parametrize("seed", seeds(8))
def test_the_peak_of_a_gain_with_a_direct_part_is_that_of_a_sweep(seed):
    """Against python-control's frequency response, refined around its top."""
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(5, 5))
    A -= (np.linalg.eigvals(A).real.max() + 0.05 + rng.random()) * np.eye(5)
    B, C = rng.normal(size=(5, 2)), rng.normal(size=(3, 5))
    D = 10 ** rng.uniform(-2, 1) * rng.normal(size=(3, 2))
    system, w = control.ss(A, B, C, D), np.r_[0, np.geomspace(1e-3, 1e4, 3000)]
    for _ in range(4):
        at = np.moveaxis(system(1j * w), -1, 0)
        sizes = np.linalg.norm(at, 2, axis=(1, 2))
        k = sizes.argmax()
        w = np.linspace(w[max(k - 1, 0)], w[min(k + 1, len(w) - 1)], 200)
    seen = max(sizes[k], np.linalg.norm(D, 2))
    assert peak_gain(A, B, C, D) == pytest.approx(seen, rel=1e-6)


def test_an_all_pass_has_one_gain():
    one = np.eye(1)
    assert peak_gain(-3 * one, one, -6 * one, one) == pytest.approx(1, rel=1e-7)
    assert peak_gain(one, one, one, one) == np.inf
    assert peak_gain(-one, 0 * one, one, 2 * one) == 2
