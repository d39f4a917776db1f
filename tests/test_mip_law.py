"""Sampled laws: against what they stand for, step by step."""

import control
import numpy as np
import pytest
from sosbook.mip import SampledLaw
from sosbook.mip.law import combine

from sosbook import thesis

PRINTED = thesis.mip()
T = 0.01
PATH = np.random.default_rng(1).normal(size=(4, 200))


def outputs(law, y, x=None):
    """u at every tick, without a limit."""
    x, found = np.zeros(law.order) if x is None else x, []
    for sample in y.T:
        found.append(law.output(x, sample))
        x = np.array(law.next(x, sample, 0.0))
    return np.array(found, float)


def test_a_pd_gain_is_its_product_with_the_samples():
    K = PRINTED.pd[2]
    assert np.allclose(outputs(SampledLaw.of_gain(K, T), PATH), K[0] @ PATH)


def test_a_pid_gain_adds_the_sum_of_the_wheels_angle():
    K = PRINTED.pid[5]
    x3 = T * np.append(0, np.cumsum(PATH[1])[:-1])
    expected = K[0, :4] @ PATH + K[0, 4] * x3
    assert np.allclose(outputs(SampledLaw.of_gain(K, T), PATH), expected)


@pytest.mark.parametrize("name", ["pd", "pid"])
def test_appendix_b_is_a_pid_of_angles_summed_by_euler(name):
    K = getattr(PRINTED, name)[2]
    angles = T * np.hstack([np.zeros((2, 1)), np.cumsum(PATH[2:], 1)[:, :-1]])
    tilt = 0.1
    angles[0] += tilt
    summed = T * np.append(0, np.cumsum(angles[1])[:-1])
    K_I = K[0, 4] if name == "pid" else 0.0
    expected = K[0, :2] @ angles + K[0, 2:4] @ PATH[2:] + K_I * summed
    law = SampledLaw.appendix_b(K, T)
    assert np.allclose(outputs(law, PATH, tilt * law.start), expected)


def test_the_printed_discrete_controller_is_the_hold_of_4_29():
    reduced = [
        control.zpk(zeros, PRINTED.reduced[2], -gain)
        for gain, zeros in PRINTED.reduced[:2]
    ]
    parts = [control.ss(x) for x in reduced]
    both = control.ss(
        np.block([[parts[0].A, np.zeros((2, 2))], [np.zeros((2, 2)), parts[1].A]]),
        np.block([[parts[0].B, np.zeros((2, 1))], [np.zeros((2, 1)), parts[1].B]]),
        np.hstack([parts[0].C, parts[1].C]),
        np.hstack([parts[0].D, parts[1].D]),
    )
    A, B, C, D = PRINTED.discrete
    printed = control.ss(A, B, -C, -D, T)
    ours = outputs(SampledLaw.of_controller(both, T), PATH)
    print_ = outputs(SampledLaw.of_controller(printed, T), PATH)
    # print rounds A to 5e-5, which moves the gain at s = 0 by 1e-3
    assert np.abs(ours - print_).max() < 1e-3 * np.abs(ours).max()


def test_back_calculation_unwinds_the_integral_with_its_time_constant():
    law = SampledLaw.of_gain([[0, 0, 0, 0, 2.0]], 0.001, tracking_time=0.1)
    x, limit = np.array([10.0]), 5.0
    for _ in range(100):
        u = law.output(x, np.zeros(4))
        x = np.array(law.next(x, np.zeros(4), np.clip(u, -limit, limit) - u))
    assert np.isclose(2 * x[0] - 5, (20 - 5) * np.exp(-1), rtol=0.01)


def test_combine_skips_zeros_and_keeps_the_precision():
    kind = np.float32
    found = combine([0.1, 0.0, 3.0], [kind(1), kind(np.nan), kind(2)])
    assert found.dtype == kind
    assert found == kind(0.1) * kind(1) + kind(3) * kind(2)
    assert combine([0.0], [np.inf]) == 0


@pytest.mark.parametrize(
    "make, words",
    [
        (lambda: SampledLaw.of_gain([[1, 2, 3]], T), "K must be"),
        (lambda: SampledLaw.of_gain([[1, 2, 3, np.nan]], T), "K"),
        (lambda: SampledLaw.of_gain([[1, 2, 3, 4, 0]], T), "leave it out"),
        (lambda: SampledLaw.of_gain([[1, 2, 3, 4]], 0), "T"),
        (
            lambda: SampledLaw.of_gain([[1, 2, 3, 4, 5]], T, tracking_time=-1),
            "tracking_time",
        ),
        (lambda: SampledLaw([[1]], [[1]], [[1]], [[1]], T), "B"),
        (lambda: SampledLaw([1], [[1]], [[1]], [[1]], T), "A must be a matrix"),
        (lambda: SampledLaw.of_controller(control.ss([], [], [], [[1]]), T), "theta'"),
        (
            lambda: SampledLaw.of_controller(control.ss([], [], [], [[1, 2]], 0.5), T),
            "sampled with 0.5",
        ),
    ],
)
def test_bad_input_is_named(make, words):
    with pytest.raises(ValueError, match=words):
        make()


def test_the_former_name_of_the_tracking_time_warns_and_works():
    K = [[1.0, 2, 3, 4, 5]]
    with pytest.warns(DeprecationWarning, match="unwind is now called tracking_time"):
        former = SampledLaw.of_gain(K, 0.01, unwind=0.3)
    assert np.array_equal(former.W, SampledLaw.of_gain(K, 0.01, tracking_time=0.3).W)
