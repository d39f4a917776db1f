"""Orders that rise, and delays that are constant and unknown."""

import numpy as np
import pytest

import sosbook as sos
from sosbook.delay import (
    DelayedLoop,
    analyse_delay,
    constant_delays,
    spectral_abscissa,
    stable_delays,
)
from sosbook.exact.checker import verdict as checker
from sosbook.exact.rational import exact
from tests.cases import campaign, later

TURNING = [[0, 1], [-1.0364, -0.024]], [[0, 0], [0.0364, 0]]  # a cut and the last one


@pytest.mark.parametrize(
    "tau, order", [(3.0, 2), (6.0, 6), (13.9, 9), *later((26.2, 18))]
)
def test_the_order_rises_until_it_proves_what_is_stable(tau, order):
    loop = DelayedLoop(*TURNING)
    d = analyse_delay(loop, tau=tau, method="legendre")
    assert spectral_abscissa(*TURNING, tau) < 0
    assert d.status == "feasible" and d.request.order == order
    assert checker.check(d.certify().text) == list(d.certify().claims)
    assert ("raised to" in d.reason) == (order > 2)


def test_a_slow_loop_is_refused_and_a_given_order_stays():
    loop = DelayedLoop(*TURNING)
    assert spectral_abscissa(*TURNING, 5.0) > 0
    slow = analyse_delay(loop, tau=5.0, method="legendre")
    assert slow.status == "infeasible" and slow.infeasibility.proven
    low = analyse_delay(loop, tau=13.9, method="legendre", order=2)
    assert low.status == "infeasible" and low.request.order == 2


def test_what_no_order_proves_is_undecided_and_says_what_to_do():
    loop = DelayedLoop([[-0.5]], [[-1.0]])  # stable below 2.418 s
    d = analyse_delay(loop, tau=1.2, mu=1.15, method="legendre")
    assert d.status == "undecided" and d.infeasibility is None
    assert "constant_delays" in d.reason
    low, high = d.request.tau - d.request.mu, d.request.tau + d.request.mu
    assert constant_delays(loop, low=low, high=high).status == "feasible"


@pytest.mark.parametrize("mu", [3000, *campaign([0])])
def test_a_delay_too_long_for_its_roots_gets_an_answer(mu):
    slow = DelayedLoop([[-2e4]], [[-1]])  # 2e4 > 1: stable for every delay
    late = DelayedLoop([[-2]], [[-3]])  # stable below 1.03 s
    assert analyse_delay(slow, tau=3000, method="legendre").status == "feasible"
    d = analyse_delay(late, tau=3000, mu=mu, method="legendre")
    assert d.status != "feasible" and d.reason.count("delay is too long") == 1
    found = constant_delays(late, low=2900, high=3000, time_limit=0.2)
    assert found.status == "undecided" and found.reason


def test_the_rate_of_a_loop_stands_once_in_its_reason():
    loop = DelayedLoop([[-0.5]], [[-1.0]])
    for how in ({"method": "legendre"}, {"method": "legendre", "order": 2}, {}):
        d = analyse_delay(loop, tau=1.2, mu=1.15, **how)
        assert d.reason.lower().count("in floats the slowest") == 1


def test_every_constant_delay_of_an_interval_is_proven_in_pieces():
    loop = DelayedLoop(*TURNING)
    found = constant_delays(loop, low=6, high=9.5)
    assert found.covered and len(found.parts) > 1
    for proof in found.certify():
        assert checker.check(proof.text) == list(proof.claims)
    ends = [(p.request.tau, p.request.mu) for p in found.parts]
    assert exact(ends[0][0]) - exact(ends[0][1]) <= 6
    assert exact(ends[-1][0]) + exact(ends[-1][1]) >= exact(9.5)
    for delay in np.linspace(6, 9.5, 30):
        assert spectral_abscissa(*TURNING, delay) < 0
    assert not sos.delay.ConstantDelays(6, 9.6, "feasible", found.parts).covered
    assert not sos.delay.ConstantDelays(6, 9.5, "feasible", found.parts[::2]).covered


def test_a_window_s_edge_is_where_the_pieces_end():
    """Of a plant with odd units, under a gain, and of a law with a filter."""
    plant = sos.SecondOrderSystem(0.3, 0.05, 9.81 * 0.3, 1)
    for law, K in (
        (None, [[-0.9, -0.2]]),
        (sos.PIDLaw(position=[[1]], filter=0.05), {"K_P": [[-0.9]], "K_D": [[-0.2]]}),
    ):
        design = sos.analyse_pid(plant, K, law=law)
        opened, gain = design.loop.opened
        (d,) = opened.vertices
        A, B, _ = d.state_space()
        (low, edge), *_ = stable_delays(A, B @ gain, 5.0)
        assert low == 0 and edge < 5
        inside = constant_delays(plant, design, low=0.01, high=round(0.97 * edge, 4))
        assert all(proof.proven for proof in inside.certify())
        beyond = constant_delays(plant, design, low=0.01, high=round(1.03 * edge, 4))
        assert beyond.status == "undecided" and "has the decay -" in beyond.reason
        with pytest.raises(ValueError, match="undecided"):
            beyond.certify()


def test_the_ends_of_the_interval_are_checked():
    for low, high in ((0, 1), (2, 1), (-1, 1)):
        with pytest.raises(ValueError, match="low"):
            constant_delays(DelayedLoop([[-2]], [[-1]]), low=low, high=high)
