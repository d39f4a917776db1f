"""Nonlinear loops against the linear ones, energy and statics."""

import numpy as np
import pytest
from scipy.optimize import brentq

import sosbook as sos
from sosbook.analysis.nonlinear import arm_gravity, simulate_nonlinear
from sosbook.book import thesis
from sosbook.plants.descriptor import descriptors
from sosbook.plants.signals import Steps
from tests.cases import campaign

ARM = thesis.arm(0.0)
EX = thesis.example_4()
SIGNALS = ("z", "dz", "e", "u", "x", "w")


def nothing(z, dz):
    return np.zeros(len(z))


def swing(t, r=None, x0=None, K=EX.K, U=EX.U):
    return simulate_nonlinear(ARM, arm_gravity, K, t, U, r, x0=x0)


def test_without_a_force_it_is_the_linear_loop():
    ex = thesis.example_1()
    t = np.linspace(0, 4, 201)
    asked = dict(
        r=[1.0, -0.5],
        w=sos.Sine([5, 2], 10, 5, 1, 2.05),
        x0=[0.2, 0.2, 0.8, 0.8, 0.1, 0.1],
    )
    K_A = np.array([[-1.0, 0.5], [0, -2]])
    for gain in (None, K_A):
        (d,) = descriptors(ex.plant, ex.U, gain)
        exact = sos.analysis.simulate(d, ex.K, t, **asked, K_A=gain)
        found = simulate_nonlinear(
            ex.plant, nothing, ex.K, t, ex.U, **asked, K_A=gain, rtol=1e-11
        )
        for name in SIGNALS:
            gap = getattr(found, name) - getattr(exact, name)
            assert np.abs(gap).max() < 1e-8, name


def test_a_spring_may_be_given_as_a_force():
    """Moving S z into f changes nothing."""
    arm, t = thesis.arm(1.0), np.linspace(0, 3, 61)
    soft = sos.SecondOrderSystem(arm.M, arm.D, np.zeros((2, 2)), arm.B)
    asked = dict(U=EX.U, r=[1, 1])
    one = simulate_nonlinear(arm, nothing, EX.K, t, **asked)
    # the integrator needs the true stiffness, so shift only a part
    part = sos.SecondOrderSystem(arm.M, arm.D, 0.9 * arm.S, arm.B)
    other = simulate_nonlinear(part, lambda z, dz: 0.1 * arm.S @ z, EX.K, t, **asked)
    assert np.allclose(one.x, other.x, atol=1e-7)
    with pytest.raises(ValueError, match="U is uncontrollable"):
        simulate_nonlinear(soft, lambda z, dz: arm.S @ z, EX.K, t, **asked)


def test_small_swings_are_those_of_the_linear_arm():
    x0 = 1e-4 * np.array([1, 1, 0, 0, 0])
    t = np.linspace(0, 2, 101)
    (d,) = descriptors(thesis.arm(1.0), EX.U)
    linear = sos.analysis.simulate(d, EX.K, t, x0=x0)
    assert np.abs(swing(t, x0=x0).x - linear.x).max() < 1e-10


@pytest.mark.parametrize("angle", [3.1, *campaign([0.5, 1.5])])
def test_the_free_arm_keeps_its_energy(angle):
    t = np.linspace(0, 10, 501)
    free = simulate_nonlinear(
        ARM, arm_gravity, np.zeros((1, 4)), t, x0=[angle, angle - 0.1, 0, 1]
    )
    z, dz = free.z, free.dz
    energy = (
        np.sum(dz * (ARM.M @ dz), axis=0) / 2
        + np.sum(z * (ARM.S @ z), axis=0) / 2
        - np.cos(z[0])
    )
    assert np.ptp(z[0]) > 0.1
    assert np.abs(energy - energy[0]).max() < 1e-6


@pytest.mark.parametrize("degrees", [30, 60, 90, 150])
def test_at_rest_the_arm_hangs_back(degrees):
    """phi2 on the set point, k (phi2 - phi1) = m g l sin(phi1) = u."""
    r = np.radians(degrees)
    end = swing(np.array([0.0, 12.0]), [r, r])
    phi1 = brentq(lambda p: np.sin(p) + 50 * (p - r), 0, r)
    assert np.allclose(end.z[:, -1], [phi1, r], atol=1e-7)
    assert np.allclose(end.u[0, -1], np.sin(phi1), atol=1e-6)
    assert np.allclose(end.dz[:, -1], 0, atol=1e-6)


def test_steps_are_runs_one_after_the_other():
    r = Steps([0, 1.0, 1.7], [[0.5, 0.5], [1, 1], [-1, -0.5]])
    t = np.array([0, 0.5, 1.0, 1.35, 1.7, 2.0])
    whole = swing(t, r)
    first = swing(np.array([0, 0.5, 1.0]), [0.5, 0.5])
    second = swing(np.array([0, 0.35, 0.7]), [1, 1], first.x[:, -1])
    third = swing(np.array([0, 0.3]), [-1, -0.5], second.x[:, -1])
    states = np.hstack([first.x, second.x[:, 1:], third.x[:, 1:]])
    assert np.allclose(whole.x, states, atol=1e-8)
    assert np.array_equal(whole.e[:, 2], whole.z[:, 2] - [1, 1])
    assert np.allclose(whole.u[0, 4], third.u[0, 0])


def test_steps_beyond_the_end_are_not_reached():
    t = np.array([0.0, 1.0])
    late = Steps([0, 5], [[1, 1], [9, 9]])
    assert np.allclose(swing(t, late).x, swing(t, [1, 1]).x)


def test_two_motions_approach_as_the_common_p_says():
    """V(x - y) falls at 2 sigma, for factors down to -1."""
    arms = sos.Polytope([thesis.arm(-1.0), thesis.arm(1.0)])
    sigma = 2.0
    region = sos.PoleRegion(sigma=sigma)
    found = sos.analyse_pid(arms, EX.K, EX.U, region=region, coupling="pairs")
    assert found.certify(8).proven
    t, rng = np.linspace(0, 3, 61), np.random.default_rng(3)
    r = Steps([0, 1.5], [[3, 3], [-1, -1]])
    for _ in range(2):
        x, y = (swing(t, r, x0=rng.normal(0, 2, 5)).x for _ in range(2))
        V = np.sum((x - y) * np.linalg.solve(found.P, x - y), axis=0)
        scaled = V * np.exp(2 * sigma * t)
        assert (np.diff(scaled) < 1e-6 * scaled[0]).all()


def test_a_runaway_is_named():
    push = np.array([[0, 3000.0, 0, 0, 0]])
    with pytest.raises(ValueError, match="can't be followed beyond t"):
        swing(np.array([0, 100.0]), x0=np.ones(5), K=push)


@pytest.mark.parametrize(
    "bad, words",
    [
        (dict(plant=EX.plant), "plant must be a SecondOrderSystem"),
        (dict(K=np.zeros((1, 4))), "K has 4 columns"),
        (dict(t=[1, 2]), "t must increase from 0"),
        (dict(t=[0]), "t must increase from 0"),
        (dict(r=[1.0]), "r must hold 2"),
        (dict(r=Steps([0], [[1.0]])), "r has levels of 1"),
        (dict(x0=np.zeros(4)), "x0 must hold 5"),
        (dict(x0=[np.nan] * 5), "x0 must hold 5"),
        (dict(w=np.sin), "w must be a Sine"),
        (dict(w=sos.Sine(1, 1)), "no F"),
        (dict(force=lambda z, dz: 0.0), "force.* must return 2"),
    ],
)
def test_bad_input_is_named(bad, words):
    good = dict(plant=ARM, force=arm_gravity, K=EX.K, t=[0, 1], U=EX.U)
    with pytest.raises(ValueError, match=words):
        simulate_nonlinear(**good | bad)


@pytest.mark.parametrize("times", [[1.0], [0, 0], [0, 2, 1], []])
def test_times_of_steps_are_checked(times):
    with pytest.raises(ValueError, match="times must increase from 0"):
        Steps(times, np.zeros((len(times), 2)))


def test_levels_of_steps_are_checked():
    with pytest.raises(ValueError, match="levels has 1 rows"):
        Steps([0, 1], [[1.0, 2.0]])


@pytest.mark.timeout(20)
@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(
    "wrong", [[np.nan], [np.inf], [1j], ["1"], [None], None, 0.0, [1.0, 2.0], [True]]
)
def test_a_force_that_is_no_number_is_named(wrong):
    """With NaN the integrator has no step to take, and takes it for ever."""
    mass = sos.SecondOrderSystem(1, 1, 1, 1)
    for late in (0.0, 0.5):

        def force(z, dz, late=late):
            return [0.0] if z[0] < 1 - late else wrong

        start = [1.0 - late / 2, 1.0]
        with pytest.raises(ValueError, match=r"force\(z, dz\) must return 1 finite"):
            sos.simulate_nonlinear(mass, force, [[0.0, 0.0]], [0, 1], x0=start)


@pytest.mark.timeout(20)
@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("rtol", [np.nan, 0, -1, 1e-16, 1.0, np.inf, None, "fine"])
def test_a_tolerance_that_is_none_is_named(rtol):
    mass = sos.SecondOrderSystem(1, 1, 1, 1)
    with pytest.raises(ValueError, match="rtol must be"):
        sos.simulate_nonlinear(
            mass, lambda z, dz: [0.0], [[0.0, 0.0]], [0, 1], rtol=rtol
        )


def test_an_acceleration_gain_may_be_a_number():
    mass = sos.SecondOrderSystem(1, 1, 1, 1)
    asked = mass, lambda z, dz: [0.0], [[-1.0, -1.0]], [0, 1]
    one = sos.simulate_nonlinear(*asked, x0=[1, 0], K_A=0.5)
    other = sos.simulate_nonlinear(*asked, x0=[1, 0], K_A=[[0.5]])
    assert np.array_equal(one.u, other.u)
    with pytest.raises(ValueError, match="force must be a function"):
        sos.simulate_nonlinear(mass, 3.0, [[0.0, 0.0]], [0, 1])
