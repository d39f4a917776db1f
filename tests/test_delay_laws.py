"""Laws behind a delay: their gains are searched, then proven; refusals have numbers."""

import re
from functools import cache

import numpy as np
import pytest

import sosbook as sos
from sosbook.delay import analyse_delay, constant_delays, design_delay_pid
from sosbook.exact.checker import verdict as checker
from sosbook.laws import Filter, ShapedLaw
from tests.cases import campaign, later

# a train of two masses that turns a little: hardly damped, unsymmetric, two inputs
M, D = [[3.2, 0.3], [0.3, 1.1]], [[0.05, 0.4], [-0.4, 0.03]]
S, B = [[9.81 * 3, -4], [-2.5, 9.81]], [[1, 0], [0.2, 0.7]]
TRAIN = sos.SecondOrderSystem(M, D, S, B)
ENCODERS = sos.PIDLaw(position=np.eye(2), filter=0.03)
LOADED = sos.Uncertain(
    lambda k: sos.SecondOrderSystem(M, D, k * np.array(S), B), k=(0.9, 1.1)
)


@cache
def searched():
    """The gains of the encoders' law, as of no delay."""
    return sos.design_pid(TRAIN, law=ENCODERS, region=sos.PoleRegion(sigma=0.3))


def slowest(design, delays, N=30):
    """The least decay of a design's loop, by collocation at Chebyshev's points."""
    plant, K = design.loop.opened
    points = np.arange(N + 1)
    x = np.cos(np.pi * points / N)
    c = np.where(points % N == 0, 2, 1) * (-1.0) ** points
    steps = np.outer(c, 1 / c) / (x[:, None] - x + np.eye(N + 1))
    steps -= np.diag(steps.sum(1))
    found = []
    for d in plant.vertices:
        A, A_d = np.linalg.solve(d.E, d.A), np.linalg.solve(d.E, d.Bu @ K)
        n = len(A)
        for tau in delays:
            big = np.kron(steps * 2 / tau, np.eye(n))
            big[:n] = 0
            big[:n, :n], big[:n, -n:] = A, A_d
            found.append(-np.linalg.eigvals(big).real.max())
    return min(found)


@pytest.mark.parametrize(
    "law",
    [
        ENCODERS,
        sos.DynamicLaw(2, position=np.eye(2)),
        *later((ShapedLaw(ENCODERS, [Filter.notch(40, 0.1, 0.6)]),)),
    ],
)
def test_a_law_is_found_behind_a_delay_and_proven_with_it(law):
    plain = searched()
    if law is not ENCODERS:
        plain = sos.design_pid(TRAIN, law=law, region=sos.PoleRegion(sigma=0.3))
    if law is ENCODERS:  # without the delay it finds what is unstable with it
        assert plain.status == "feasible" and slowest(plain, [0.3]) < 0
    asked = dict(tau=0.3, mu=0.02, delta=0.2)
    late = design_delay_pid(TRAIN, law=law, **asked)
    proof = late.certify()
    assert checker.check(proof.text) == list(proof.claims)
    assert "every delay in [0.28, 0.32] s" in proof.claims[0]
    assert slowest(late, [0.28, 0.3, 0.32]) > 0.2
    assert late.gains.keys() == plain.gains.keys() and late.loop.law is law
    again = analyse_delay(TRAIN, late.gains, law=law, method="legendre", **asked)
    assert again.status == "feasible" and again.gains.keys() == plain.gains.keys()


def test_the_program_of_a_law_behind_a_delay_reads_the_law_s_sensors():
    asked = dict(tau=0.3, delta=0.2)
    late = design_delay_pid(TRAIN, law=ENCODERS, **asked)
    known = analyse_delay(TRAIN, late.gains, law=ENCODERS, method="legendre", **asked)
    for design in (late, known):  # the filters are the program's, no sensors
        program = design.controller(T=0.01, delay=0.3)
        assert program.order > 0 and "filtered" not in repr(program)
        assert program.certify().proven


def test_a_law_is_found_for_every_plant_of_a_family():
    late = design_delay_pid(LOADED, law=ENCODERS, tau=0.1, mu=0.01, delta=0.1)
    assert late.certify().proven and slowest(late, [0.09, 0.11]) > 0.1


def test_a_law_that_is_asked_for_too_much_says_what_it_reaches():
    cart, law = (
        sos.SecondOrderSystem(0.3, 0.01, 9.81, 2),
        sos.PIDLaw([[1]], filter=0.03),
    )
    late = design_delay_pid(cart, law=law, tau=0.3, mu=0.03, delta=20)
    assert late.status == "undecided" and late.infeasibility is None
    rate, at = map(
        float, re.findall(r"with (\S+) 1/s at the delay (\S+) s", late.reason)[0]
    )
    assert np.isclose(slowest(late, [0.27, 0.3, 0.33]), rate, rtol=5e-3)
    assert 0.27 <= at <= 0.33


def test_a_scheduled_gain_is_not_taken_for_a_constant_one():
    with pytest.raises(ValueError, match="scheduled"):
        design_delay_pid(LOADED, law=sos.Scheduled("k"), tau=0.1)


@pytest.mark.parametrize(
    "asked", [dict(mu=0.02), *campaign([dict(delta=2.0), dict(mu=0.03), dict(tau=0.2)])]
)
def test_a_refusal_says_how_slow_the_loop_is_and_what_has_a_proof(asked):
    gains = searched().gains
    asked = dict(tau=0.03) | asked
    d = analyse_delay(TRAIN, gains, law=ENCODERS, **asked)
    assert d.status != "feasible"
    at, rate = map(
        float, re.findall(r"interval, (\S+) s, decays with (\S+) ", d.reason)[0]
    )
    assert np.isclose(slowest(d, [at]), rate, rtol=5e-3)
    assert ("less than was asked" in d.reason) == (rate <= asked.get("delta", 0))
    name, value = re.findall(r"a \w+ (\w+) of (\S+)", d.advice)[0]
    less = asked | {name: float(value)} | ({"mu": 0} if name == "tau" else {})
    assert analyse_delay(TRAIN, gains, law=ENCODERS, **less).certify().proven


def test_constant_delays_of_a_family_names_what_it_is_asked_for():
    with pytest.raises(ValueError, match="one plant") as error:
        constant_delays(LOADED, {}, law=ENCODERS, low=0.01, high=0.05)
    assert "method" not in str(error.value)


def test_a_gain_is_analysed_with_what_it_integrates_said_by_U_or_by_a_law():
    U = [[0.0, 1.0]]
    late = design_delay_pid(TRAIN, U=U, tau=0.02)
    for said in (dict(U=U), dict(law=sos.FullState(U))):
        again = analyse_delay(TRAIN, late.K, tau=0.02, **said)
        assert again.certify().proven and again.gains.keys() == late.gains.keys()
    assert analyse_delay(TRAIN, late, tau=0.02).certify().proven
