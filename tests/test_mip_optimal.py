"""Laws of least cost on a robot: the sampled regulator and the observer."""

import numpy as np
import pytest

from sosbook.pendulum import Mip, Robot, recommend
from sosbook.pendulum.margins import SampledLoop
from sosbook.pendulum.optimal import optimal_law
from sosbook.pendulum.rest import Gears
from sosbook.pendulum.tuning import design, recoverable_tilt
from sosbook.sampled import c2d, design_sampled_lqr
from tests.six_robots import ALL, by_its_sheet

MIP, THESIS, Q = Mip.printed(), Robot.shipped("thesis"), np.eye(5)
#: Its motors settle in 24 ms, its clock is 20 ms.
SLOW = Mip(0.0147, 0.01536, 0.0653, 2.511, 0.3667, 0.4, I_w=0.00416, J=0.008)
LAZY = by_its_sheet(ALL["1:100 at 50 Hz"], friction=False, law="gain")


def contains(many, few):
    """Whether each of few is one of many, to rounding."""
    return all(min(abs(many - x)) < 1e-6 for x in few)


@pytest.mark.parametrize("late", [0.0, 0.004, 0.01, 0.013])
@pytest.mark.parametrize("mip, T", [(MIP, 0.01), (SLOW, 0.02)], ids=["thesis", "slow"])
def test_the_observer_separates_from_the_gain(mip, T, late):
    """For its own plant the loop's poles are those of gain and filter."""
    robot = (THESIS if mip is MIP else LAZY).but(T=T, delay=late)
    found = optimal_law(mip, robot, Q, 5.0)
    poles = SampledLoop(mip, found.law, late).poles
    (step,) = c2d(mip.plant(), T, late)
    A, B = np.array(step.A), np.array(step.B)
    sees = np.eye(4)[:3]
    flow = A[:4, :4]
    assert contains(poles, np.linalg.eigvals(flow @ (np.eye(4) - found.M @ sees)))
    n = len(A)
    sums = np.zeros((n + 1, n + 1))  # [x; older; the sum of T phi]
    sums[:n, :n], sums[n, n], sums[n, 1] = A, 1, T
    K = np.hstack([found.K[:, :4], found.K[:, 5:], found.K[:, 4:5]])
    gain = np.linalg.eigvals(sums + np.vstack([B, [[0]]]) @ K)
    assert contains(poles, gain)


def test_the_gain_is_the_sampled_regulators_and_the_filter_is_kalmans():
    found = optimal_law(MIP, THESIS, Q, 5.0)
    same = design_sampled_lqr(MIP.plant(), Q, [[5.0]], 0.01, 0.01, [[0, 1]])
    assert np.array_equal(found.K, same.K)
    (step,) = c2d(MIP.plant(), 0.01)
    A, B, sees = np.array(step.A), np.array(step.B), np.eye(4)[:3]
    noise = np.diag([0.01, 2 * np.pi / THESIS.counts / 12**0.5, 0.003]) ** 2
    push = 0.37**2 * B @ B.T
    push += 1e-9 * np.trace(push) * np.eye(4)
    P = np.eye(4)  # the covariance, tick by tick, from a bad guess
    for _ in range(20000):
        M = P @ sees.T @ np.linalg.inv(sees @ P @ sees.T + noise)
        P = A @ (P - M @ sees @ P) @ A.T + push
    assert found.M == pytest.approx(M, rel=1e-3, abs=1e-4)


def test_the_limit_is_known_to_the_law():
    """Its older voltages are those that the motors got."""
    law = optimal_law(MIP, THESIS, Q, 5.0).law
    x, y = 0.3 * law.start, np.array([0.3, 0.0, 0.0, 0.0])
    u = law.C[0] @ x + law.D[0] @ y
    V = np.clip(u, -1, 1)
    assert abs(u) > 1
    following = law.A @ x + law.B @ y + law.W[:, 0] * (V - u)
    assert following[-1] == pytest.approx(V)


@pytest.mark.slow
def test_a_clock_too_slow_for_a_gain_is_one_for_the_observer():
    assert recoverable_tilt(SLOW, LAZY.limit) > 0.3
    with pytest.raises(ValueError, match='law = "observer" would do'):
        recommend(SLOW, R=None, robot=LAZY)
    seeing = design(SLOW, LAZY.but(law="observer"), 0.04, Q, None, 2.0, Gears())
    assert seeing.M.shape == (4, 3)


def test_an_unstable_law_is_not_written(tmp_path):
    robot = LAZY.but(law="observer")
    found = recommend(SLOW, R=5.0, robot=robot)
    vars(found)["design"] = optimal_law(MIP, robot, Q, 5.0)  # of another robot
    assert not found.proven and found.radius > 1
    with pytest.raises(ValueError, match="isn't proven"):
        found.write(tmp_path)


def test_another_law_is_refused_by_its_name():
    with pytest.raises(ValueError, match="law must be one of"):
        THESIS.but(law="pid")
