"""Sampled laws and firmware: against what they stand for, step by step."""

from dataclasses import replace

import control
import numpy as np
import pytest
from scipy.linalg import block_diag

import sosbook as sos
from sosbook.book import thesis
from sosbook.pendulum import Firmware, Gain, Mip, SampledLaw, SampledLoop, polytope
from sosbook.pendulum.law import PD_SIGNALS, PID_SIGNALS, pendulum_gain
from tests.gains import named

PRINTED = thesis.mip()
T = 0.01
PATH = np.random.default_rng(1).normal(size=(4, 200))


def outputs(law, y, x=None):
    """u at every tick, without a limit."""
    x, found = np.zeros(law.order) if x is None else x, []
    for sample in y.T:
        found.append(law.C[0] @ x + law.D[0] @ sample)
        x = law.A @ x + law.B @ sample
    return np.array(found, float)


def test_a_pd_gain_is_its_product_with_the_samples():
    K = PRINTED.pd[2]
    assert np.allclose(outputs(SampledLaw.of_gain(named(K), T), PATH), K[0] @ PATH)


def test_a_pid_gain_adds_the_sum_of_the_wheels_angle():
    K = PRINTED.pid[5]
    x3 = T * np.append(0, np.cumsum(PATH[1])[:-1])
    expected = K[0, :4] @ PATH + K[0, 4] * x3
    assert np.allclose(outputs(SampledLaw.of_gain(named(K), T), PATH), expected)


@pytest.mark.parametrize("name", ["pd", "pid"])
def test_appendix_b_is_a_pid_of_angles_summed_by_euler(name):
    K = getattr(PRINTED, name)[2]
    angles = T * np.hstack([np.zeros((2, 1)), np.cumsum(PATH[2:], 1)[:, :-1]])
    tilt = 0.1
    angles[0] += tilt
    summed = T * np.append(0, np.cumsum(angles[1])[:-1])
    K_I = K[0, 4] if name == "pid" else 0.0
    expected = K[0, :2] @ angles + K[0, 2:4] @ PATH[2:] + K_I * summed
    law = SampledLaw.appendix_b(named(K), T)
    assert np.allclose(outputs(law, PATH, tilt * law.start), expected)


def test_the_printed_discrete_controller_is_the_hold_of_4_29():
    reduced = [
        control.zpk(zeros, PRINTED.reduced[2], -gain)
        for gain, zeros in PRINTED.reduced[:2]
    ]
    parts = [control.ss(x) for x in reduced]
    A, B = (block_diag(*(getattr(x, name) for x in parts)) for name in "AB")
    C, D = (np.hstack([getattr(x, name) for x in parts]) for name in "CD")
    both = control.ss(A, B, C, D)
    A, B, C, D = PRINTED.discrete
    printed = control.ss(A, B, -C, -D, T)
    ours = outputs(SampledLaw.of_controller(both, T), PATH)
    print_ = outputs(SampledLaw.of_controller(printed, T), PATH)
    # print rounds A to 5e-5, which moves the gain at s = 0 by 1e-3
    assert np.abs(ours - print_).max() < 1e-3 * np.abs(ours).max()


def test_back_calculation_unwinds_the_integral_with_its_time_constant():
    law = SampledLaw.of_gain(named([[0, 0, 0, 0, 2.0]]), 0.001, tracking_time=0.1)
    x, limit = np.array([10.0]), 5.0
    for _ in range(100):
        u = law.C[0] @ x
        x = law.A @ x + law.W[:, 0] * (np.clip(u, -limit, limit) - u)
    assert np.isclose(2 * x[0] - 5, (20 - 5) * np.exp(-1), rtol=0.01)


of_gain, of_controller = SampledLaw.of_gain, SampledLaw.of_controller


@pytest.mark.parametrize(
    "make, words",
    [
        (lambda: of_gain(named([[1, 2, 3, np.nan]]), T), "K"),
        (lambda: of_gain(named([[1, 2, 3, 4, 0]]), T), "leave it out"),
        (lambda: of_gain(named([[1, 2, 3, 4]]), 0), "T"),
        (lambda: of_gain(named([range(1, 6)]), T, tracking_time=-1), "tracking_time"),
        (lambda: SampledLaw([[1]], [[1]], [[1]], [[1]], T), "B"),
        (lambda: SampledLaw([1], [[1]], [[1]], [[1]], T), "A must be a matrix"),
        (lambda: of_controller(control.ss([], [], [], [[1]]), T), "theta'"),
        (lambda: of_controller(control.ss([], [], [], [[1, 2]], 0.5), T), "with 0.5"),
        (
            lambda: of_controller(control.ss([], [], [], [[1, 2]], T * 1.000001), T),
            "not with T",
        ),
    ],
)
def test_bad_input_is_named(make, words):
    with pytest.raises(ValueError, match=words):
        make()


# What a gain multiplies


def pendulum(**asked):
    """A design for the pendulum in the middle, of the integral of phi."""
    return sos.design_lqr(Mip.printed().plant(), np.eye(5), [[5]], **asked)


def test_a_designs_gain_becomes_the_law_of_its_numbers():
    design = pendulum(U=[[0, 1]])
    assert design.gain.signals == PID_SIGNALS
    assert pendulum(U=[[0, 2]]).gain.signals[-1] == "integral of 2 phi"
    law = SampledLaw.of_gain(design.gain, T)
    assert np.array_equal(np.hstack([law.D, law.C]), design.K)
    proven = design.gain.but(design.certify(digits=4).K)
    assert np.array_equal(
        SampledLaw.of_gain(proven, T).D, design.certify(digits=4).K[:, :4]
    )
    for plant in (polytope(Mip.printed()), Mip.printed().printed_form()):
        assert sos.design_lqr(plant, np.eye(4), [[5]]).gain.signals == PD_SIGNALS


def test_signals_in_another_order_are_put_in_the_robots():
    """A plant of [phi; theta] is the same robot, and its gain the same law."""
    swap, plant = np.eye(2)[::-1], Mip.printed().plant()
    parts = *(swap @ getattr(plant, x) @ swap for x in "MDS"), swap @ plant.B
    turned = sos.SecondOrderSystem(*parts, coordinates=("phi", "theta"))
    gain = sos.design_lqr(turned, np.eye(5), [[5]], [[1, 0]]).gain
    assert gain.signals == ("phi", "theta", "phi'", "theta'", "integral of phi")
    straight = pendulum(U=[[0, 1]])
    assert pendulum_gain(gain) == pytest.approx(straight.K, rel=1e-4)


#: What a gain multiplies that no robot's law is of, and what is said of it. The fifth
#: entry isn't K_I, though there are five.
BARE = "z1", "z2", "z1'", "z2'"
OTHERS = {
    BARE: "multiplies z1, z2, z1', z2' and not theta, phi, theta'",
    (*PD_SIGNALS, "u(k-1)"): r"older voltages, u\(k-1\), which this law doesn't keep",
    (*PID_SIGNALS, "u(k-1)"): 'law = "observer"',
    (*PD_SIGNALS, "x"): "it multiplies .*, x. The robot",
    (*PD_SIGNALS, "integral of 2 phi"): "integral of 2 phi",
    ("delta", "delta'", "integral of delta"): "multiplies delta, delta', integral of",
}


@pytest.mark.parametrize("law", [SampledLaw.of_gain, SampledLaw.appendix_b])
def test_a_gain_of_something_else_is_refused(law):
    for signals, words in OTHERS.items():
        with pytest.raises(ValueError, match=words):
            law(Gain([range(len(signals))], signals), T)
    with pytest.raises(ValueError, match="2 outputs"):
        law(Gain(np.ones((2, 4)), PD_SIGNALS), T)
    with pytest.raises(ValueError, match="an array doesn't say .* Give design.gain"):
        law([[20, 0.8, 2, 0.9]], T)


def test_the_fifth_entry_of_a_regulator_that_knows_its_delay_is_no_integral():
    """Taken for K_I, as a bare array would have it, the loop is unstable."""
    plant = Mip.printed().plant()
    late = sos.design_sampled_lqr(plant, np.eye(4), [[5]], T, T).gain
    assert late.signals == (*PD_SIGNALS, "u(k-1)")
    wrong = SampledLaw.of_gain(named(late.K), T)
    assert SampledLoop(Mip.printed(), wrong, T).radius > 1


def test_names_of_coordinates_go_with_the_plant():
    plant = polytope(Mip.printed())
    assert plant.coordinates == plant.mean.coordinates == ("theta", "phi")
    first, *others = plant.vertices
    bare = sos.SecondOrderSystem(*(getattr(first, x) for x in "MDSBF"))
    assert bare == first and bare.coordinates is None  # the same mechanics
    assert sos.Polytope([bare, *others]).coordinates == ("theta", "phi")
    other = replace(first, coordinates=("phi", "theta"))
    with pytest.raises(ValueError, match="name their coordinates differently"):
        sos.Polytope([other, *others])


@pytest.mark.parametrize(
    "K, signals, words",
    [
        ([[1, 2]], ("a",), "each of K's 2 columns once"),
        ([[1, 2]], ("a", "a"), "each of K's 2 columns once"),
        ([[1, 2]], "ab", "each of K's 2 columns once"),
        ([[1, np.nan]], ("a", "b"), "K"),
    ],
)
def test_a_gain_names_each_of_its_columns(K, signals, words):
    with pytest.raises(ValueError, match=words):
        Gain(K, signals)


def test_a_gain_is_read_only_and_compared_by_numbers_and_names():
    gain = Gain([[1, 2]], ("a", "b"))
    assert gain == Gain([1, 2], ["a", "b"]) != Gain([[1, 2]], ("b", "a"))
    assert gain.but([[3, 4]]) == Gain([[3, 4]], gain.signals) != "gain"
    assert not gain.K.flags.writeable


# The firmware: what the motors get, whatever the sensors say

K = [[16.0, 0.5, 1.4, 0.7, 0.2]]
LAW = SampledLaw.of_gain(named(K), T)


def test_while_the_encoder_is_silent_the_wheels_roll_on():
    controller = Firmware(SampledLaw.of_gain(named([[0, 0, 0, 1]]), T)).controller()
    controller.start(0.0)
    rates = [controller.step(0.0, w)[0] for w in (0.02, 0.04, np.nan, np.nan, 0.10)]
    assert np.allclose(rates, 2.0)


@pytest.mark.parametrize("kind", [float, np.float32])
def test_robots_side_by_side_do_what_each_does_alone(kind):
    random = np.random.default_rng(3)
    gyro = random.normal(0, 2, (300, 7))
    wheels = np.cumsum(random.normal(0, 0.05, (300, 7)), 0)
    gyro[random.random((300, 7)) < 0.05] = np.nan
    tilts = np.linspace(-0.3, 0.3, 7)
    firmware = Firmware(LAW, missing=1)
    fleet = firmware.controller(7, kind)
    fleet.start(tilts)
    together = np.array([fleet.step(g, w) for g, w in zip(gyro, wheels)])
    for k, tilt in enumerate(tilts):
        one = firmware.controller(1, kind)
        one.start(tilt)
        alone = [one.step(g, w)[0] for g, w in zip(gyro[:, k], wheels[:, k])]
        assert alone == together[:, k].tolist()
    assert len(set(fleet.fault)) > 1


@pytest.mark.parametrize(
    "key, value",
    [("limit", 0), ("tip", -1), ("blend", 1.5), ("missing", -1), ("stall", 0.5),
     ("frozen", -2), ("fastest", np.nan)],
)  # fmt: skip
def test_bad_settings_are_named(key, value):
    with pytest.raises(ValueError, match=key):
        Firmware(LAW, **{key: value})
    with pytest.raises(ValueError, match="law"):
        Firmware(K)


def test_a_controller_that_is_not_started_says_so():
    with pytest.raises(ValueError, match="start"):
        Firmware(LAW).controller().step(0.0, 0.0)
