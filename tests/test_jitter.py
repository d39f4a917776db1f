"""Clocks that vary: proofs against closed forms and simulations by pieces."""

from dataclasses import replace
from functools import cache
from itertools import product

import control
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm
from scipy.optimize import brentq

import sosbook as sos
from sosbook.pendulum import Mip, Robot
from sosbook.pendulum.proven import Deployment
from sosbook.plants.descriptor import descriptors
from sosbook.sampled import (
    SampledSystem,
    certify_sampled,
    furthest_sampled,
    sampled_loop,
)
from sosbook.sampled.proof import by_balls
from sosbook.sampled.timing import TimeBox
from tests.cases import campaign
from tests.six_robots import spared

# x' = A x + B u, u = K x(t_k): stable for each constant interval up to 1.7294 s
TEXTBOOK = sos.DescriptorSystem(np.eye(2), [[0, 1], [0, -0.1]], [[0], [0.1]])
TEXTBOOK_GAIN = [[-3.75, -11.5]]
CART = sos.SecondOrderSystem([[1]], [[0.1]], [[-0.5]], [[1]])


def lag(pole):
    return sos.DescriptorSystem([[1]], [[pole]], [[1]])


def motion(plant, K, intervals, delays, x0):
    """|x(t_k)|, by pieces of constant input, of a gain or a sampled controller."""
    (d,) = descriptors(plant, None)
    A, B, _ = d.state_space()
    N, m = B.shape
    if not hasattr(K, "A"):
        K = SampledSystem([], [], [], K, 1.0)
    x, own, acting = np.array(x0, float), np.zeros(K.nstates), np.zeros(m)

    @cache
    def flow(span):
        return expm(np.block([[A, B], [np.zeros((m, N + m))]]) * span)[:N]

    def held(x, u, span):
        return flow(span) @ np.concatenate([x, u])

    sizes = []
    for T, late in zip(intervals, delays):
        u = K.C @ own + K.D @ x
        own = K.A @ own + K.B @ x
        x = held(x, acting, late)
        acting = u
        x = held(x, acting, T - late)
        sizes.append(np.linalg.norm(np.concatenate([x, own, acting])))
    return np.array(sizes)


def test_the_textbook_loop_is_proven_up_to_its_largest_constant_interval():
    """Each sequence in [0.01, 1.729] s; at 1.7295 a constant one is unstable."""
    radius = [
        abs(np.linalg.eigvals(sampled_loop(TEXTBOOK, TEXTBOOK_GAIN, T)[0])).max()
        for T in (1.7293, 1.7295)
    ]
    assert radius[0] < 1 < radius[1]
    proof = certify_sampled(TEXTBOOK, TEXTBOOK_GAIN, T=(0.01, 1.729))
    assert proof.proven and "every sequence" in proof.claims[0]
    assert "[0.01, 1.729] s" in proof.claims[0]
    broken = certify_sampled(TEXTBOOK, TEXTBOOK_GAIN, T=(0.01, 1.7295))
    assert not broken.proven and "T = 1.7295" in broken.failed[0]


def test_every_constant_interval_isnt_every_sequence():
    """Intervals that are stable each, and unstable in turn."""
    plant, K = sos.SecondOrderSystem([[1]], [[0]], [[1]], [[1]]), [[-0.8, -0.8]]
    grid = [sampled_loop(plant, K, T)[0] for T in np.linspace(0.7, 1.5, 41)]
    assert max(abs(np.linalg.eigvals(F)).max() for F in grid) < 0.98
    assert abs(np.linalg.eigvals(grid[0] @ grid[-1])).max() > 1.1
    proof = certify_sampled(plant, K, T=(0.7, 1.5))
    assert not proof.proven and not proof.claims
    assert "T = 0.7 and T = 1.5 in turn: its spectral radius is 1.1" in proof.failed[0]


def test_a_lag_has_its_interval_in_closed_form():
    """x' = x + u, u = -3 x: x+ = (3 - 2 e^T) x, stable for e^T < 2."""
    edge = np.log(2)
    assert certify_sampled(lag(1), [[-3]], T=(1e-4, 0.98 * edge)).proven
    assert certify_sampled(lag(1), [[-3]], T=(0.1, 0.999 * edge)).proven
    assert not certify_sampled(lag(1), [[-3]], T=(0.1, 1.001 * edge)).proven
    slow = certify_sampled(lag(1), [[-3]], T=(0.4, 0.5), rate=0.31)
    assert slow.proven and slow.claims[0].endswith("at least as 0.31^k")
    assert not certify_sampled(lag(1), [[-3]], T=(0.4, 0.5), rate=0.29).proven


def test_a_delay_that_varies_in_closed_form():
    """x' = u, u = -k x: x+ = x - k ((T - d) x + d x_old), whatever d in [0, T]."""
    proof = certify_sampled(lag(0), [[-0.9]], T=1, delay=(0, 1), cells=200)
    assert proof.proven
    assert proof.claims[0].endswith("for every sequence of delays in [0.0, 1.0] s")
    late = certify_sampled(lag(0), [[-1.01]], T=1, delay=(0, 1))
    assert not late.proven and "delay = 1" in late.failed[0]  # one whole sample
    whole = certify_sampled(lag(0), [[-0.5]], T=1, delay=(1, 1.5))
    assert whole.proven


def memory(T, pole=0.5):
    """A lead-lag with a state, which mends a gain's loop."""
    return SampledSystem([[pole]], [[0.2, 0.1]], [[-0.4]], [[-1.0, -1.2]], T)


def test_a_controller_with_memory_is_proven_and_simulated():
    carts = sos.Polytope(
        [sos.SecondOrderSystem([[M]], [[0.1]], [[-0.5]], [[1]]) for M in (0.8, 1.5)]
    )
    law = memory(0.1)
    proof = certify_sampled(carts, law, T=(0.05, 0.15), delay=(0, 0.15))
    assert proof.proven, proof
    rng = np.random.default_rng(0)
    for M in (0.8, 1.1, 1.5):
        plant = sos.SecondOrderSystem([[M]], [[0.1]], [[-0.5]], [[1]])
        T = rng.choice([0.05, 0.15], 1500)
        sizes = motion(plant, law, T, T * rng.choice([0, 1], 1500), [1, -1])
        assert sizes[-1] < 1e-3 * sizes[0]
    same = type(proof)(proof.text)
    assert same.verify() and same.claims == proof.claims


@settings(max_examples=6, deadline=None, derandomize=True)
@given(seed=st.integers(0, 10**6), late=st.booleans())
def test_no_sequence_grows_that_is_proven(seed, late):
    """x'P x falls in every interval and delay of a random loop's proof."""
    rng = np.random.default_rng(seed)
    half = rng.normal(size=(2, 2))
    plants = sos.Polytope(
        [
            sos.SecondOrderSystem(
                half @ half.T + s * np.eye(2),
                rng.normal(size=(2, 2)) / 5 + np.eye(2),
                half.T @ half + np.eye(2),
                np.eye(2),
            )
            for s in (1, 1.3)
        ]
    )
    K = (rng.normal(size=(2, 4)) - np.eye(2, 4, 2) - np.eye(2, 4)).round(3)
    low, high = sorted(rng.uniform(0.02, 1.2, 2).round(3).tolist())
    delay = (0, round(high * 0.7, 4)) if late else 0
    proof = certify_sampled(plants, K, (low, high), delay, cells=40, time_limit=20)
    grid = [
        (T, d)
        for T in np.linspace(low, high, 12)
        for d in (np.linspace(0, min(T, delay[1]), 6) if late else [0])
    ]
    worst = 0.0
    for w in ([1, 0], [0, 1], [0.5, 0.5], [0.2, 0.8]):
        loops = []
        for T, d in grid:
            (F,) = sampled_loop(plants.at(w), K, T, d if d < T else T * (1 - 1e-9))
            if late and len(F) == 4:
                F = np.block([[F, np.zeros((4, 2))], [K, np.zeros((2, 2))]])
            loops.append(F)
        products = loops
        for _ in range(40):
            first, second = rng.integers(len(loops), size=2)
            products = [*products, loops[first] @ loops[second]]
        worst = max(worst, *(abs(np.linalg.eigvals(F)).max() for F in products))
    if proof.proven:
        assert worst < 1
    elif worst < 0.9 and not late:  # it gives up seldom
        assert "undecided" in proof.failed[0]


def test_what_is_proven_of_a_range_is_proven_of_its_parts():
    whole = certify_sampled(CART, [[-1, -1.2]], (0.1, 0.4), (0, 0.1), rate=0.99)
    assert whole.proven
    for T, late in ((0.1, 0), (0.4, 0.1), (0.25, 0.04)):
        (F,) = sampled_loop(CART, [[-1, -1.2]], T, late)
        assert abs(np.linalg.eigvals(F)).max() < 0.99
        assert certify_sampled(CART, [[-1, -1.2]], T, late, rate=0.99).proven


@pytest.mark.parametrize(
    "change, text",
    [
        (dict(T=(0.2, 0.1)), "the first end must be the smaller"),
        (dict(T=(0.1, 0.2, 0.3)), "T must be a number or"),
        (dict(T=(0, 0.1)), "T must be positive"),
        (dict(delay=(-0.1, 0)), "delay must not be negative"),
        (dict(T=(0.1, 0.2), delay=0.15), "isn't always within one interval"),
        (dict(T=(0.1, 0.2), delay=(0, 0.3)), "isn't always within one interval"),
        (dict(T=0.1, delay=(0.05, 0.95)), "varies over 10 ticks of T = 0.1 s"),
        (dict(T=(0.1, 0.2), K=memory(0.3)), "dt = 0.3, which isn't in T"),
        (dict(T=(0.1, float("nan"))), "T must be a finite number"),
    ],
)
def test_what_no_clock_does_is_said(change, text):
    asked = dict(plant=CART, K=[[-1, -1.2]], T=0.1) | change
    with pytest.raises(ValueError, match=text):
        certify_sampled(**asked)


def test_a_range_of_one_point_is_a_number():
    for T, delay in ((0.1, 0.04), (0.1, 0.1), (0.1, 0.25)):
        one = TimeBox.of((T, T), (delay, delay))
        assert one == TimeBox.of(T, delay) and not one.varies
        assert certify_sampled(CART, [[-1, -1.2]], (T, T), (delay, delay)).proven


def drive(m, k):
    """Two masses on a spring, each with a force: positions alone are measured."""
    return sos.SecondOrderSystem(
        np.diag([1, m]), 0.2 * np.eye(2), [[k + 1, -k], [-k, k]], np.eye(2)
    )


def differences(T, stiff, damp, tau):
    """u = -stiff z - damp z', where a filter of positions has z'."""
    a, one, o = np.exp(-T / tau), np.eye(2), np.zeros((2, 2))
    return SampledSystem(
        a * one,
        np.hstack([(1 - a) * one, o]),
        damp / tau * one,
        np.hstack([-(stiff + damp / tau) * one, o]),
        T,
    )


def boxed(listed):
    """Drives of a range of masses and springs, as a list of corners or by two names."""
    ranges = dict(m=(0.5, 1.5), k=(0.8, 1.6))
    if not listed:
        return sos.Uncertain(drive, **ranges)
    corners = [drive(m, k) for k in ranges["k"] for m in ranges["m"]]
    return sos.Polytope([corners[j] for j in (2, 0, 3, 1)])


@pytest.mark.parametrize(
    "case", [(0.05, True), *campaign([(0.0, True), (0.05, False), (0.0, False)])]
)
def test_a_box_of_mass_and_stiffness_is_decided_in_few_cells(case):
    """Four vertices, an uncertain mass: 64 cells with one P each weren't enough."""
    delay, listed = case
    law, plants = differences(0.05, 1.0, 2.0, 0.15), boxed(listed)
    grid = [drive(m, k) for m in np.linspace(0.5, 1.5, 9) for k in (0.8, 1.2, 1.6)]
    worst = max(
        abs(np.linalg.eigvals(sampled_loop(p, law, 0.05, delay)[0])).max() for p in grid
    )
    rate = round(float(worst**0.95), 6)
    proof = certify_sampled(plants, law, 0.05, delay, rate=rate)
    assert proof.proven and len(proof.cells) < 16, proof
    assert not certify_sampled(plants, law, 0.05, delay, rate=worst - 1e-6).proven


@pytest.mark.campaign  # in the gate test_sampled_box has three plants and such a clock
@pytest.mark.parametrize("listed", [True, False])
def test_a_box_of_mass_and_stiffness_is_proven_for_a_clock_that_varies(listed):
    law = differences(0.05, 1.0, 2.0, 0.15)
    moving = by_balls(boxed(listed), law, (0.04, 0.06), (0, 0.04), cells=200)
    assert moving.proven, moving


def test_python_control_agrees_on_a_sequence_of_two_intervals():
    """The matrix of two unequal intervals, from control's sample_system."""
    law, steps = [[-1, -1.2]], []
    (d,) = descriptors(CART, None)
    A, B, _ = d.state_space()
    for T in (0.1, 0.4):
        held = control.sample_system(control.ss(A, B, np.eye(2), 0 * B), T, "zoh")
        steps.append(held.A + held.B @ np.array(law))
        assert np.allclose(steps[-1], sampled_loop(CART, law, T)[0])
    assert certify_sampled(CART, law, (0.1, 0.4), rate=0.99).proven
    for word in (steps[0] @ steps[1], steps[0] @ steps[0] @ steps[1]):
        assert abs(np.linalg.eigvals(word)).max() < 1


def radius(plant, K, T, delay=0.0):
    return abs(np.linalg.eigvals(sampled_loop(plant, K, T, delay)[0])).max()


def test_the_furthest_interval_is_almost_the_largest_constant_one():
    """Within a thousandth of the interval that no sequence survives."""
    edge = brentq(lambda T: radius(TEXTBOOK, TEXTBOOK_GAIN, T) - 1, 1, 2)
    proof = furthest_sampled(TEXTBOOK, TEXTBOOK_GAIN, T=(0.01, 3), tolerance=2e-4)
    assert proof.proven and 0.999 * edge < proof.T[1] < edge and proof.T[0] == 0.01
    lagging = furthest_sampled(lag(1), [[-3]], T=(0.1, 5))
    assert 0.98 * np.log(2) < lagging.T[1] < np.log(2)


def test_the_furthest_interval_of_a_controller_has_its_own_clock():
    """No shorter range is asked for, and beyond the range nothing is."""
    law = memory(0.1)
    edge = brentq(lambda T: abs(np.linalg.eigvals(cart_and(law, T))).max() - 1, 1, 2)
    found = furthest_sampled(CART, law, T=(0.05, 2.0), tolerance=0.01)
    assert found.proven and 1 < found.T[1] < edge
    slow = furthest_sampled(CART, law, T=(0.05, 2.0), tolerance=0.02, rate=0.7)
    assert not slow.proven and slow.T == (0.05, 0.1)
    with pytest.raises(ValueError, match="tolerance"):
        furthest_sampled(CART, law, T=(0.05, 1.0), tolerance=2.0)


def cart_and(law, T):
    """The loop of CART, held for T seconds, with a controller."""
    both = expm(np.array([[0, 1, 0], [0.5, -0.1, 1], [0, 0, 0]]) * T)[:2]
    A, B = both[:, :2], both[:, 2:]
    return np.block([[A + B @ law.D, B @ law.C], [law.B, law.A]])


def worst_word(late):
    """The radius per sample of the worst sequence of six delays, none or ``late``.

    x' = u, u = -1.5 x, T = 1, of the state [x; u_old].
    """
    steps = [np.array([[1 - 1.5 * (1 - d), d], [-1.5, 0]]) for d in (0, late)]
    words = (np.linalg.multi_dot(w) for w in product(steps, repeat=6))
    return max(abs(np.linalg.eigvals(M)).max() for M in words) ** (1 / 6)


def test_the_furthest_delay_and_rate():
    late = furthest_sampled(lag(0), [[-1.5]], T=1, delay=(0, 1), find="delay")
    assert late.proven and worst_word(late.delay[1]) < 1 < worst_word(
        1.1 * late.delay[1]
    )
    fast = furthest_sampled(CART, [[-1, -1.2]], 0.1, 0.03, find="rate")
    true = radius(CART, [[-1, -1.2]], 0.1, 0.03)
    assert fast.proven and true < fast.rate < true + 0.003
    varied = furthest_sampled(lag(1), [[-3]], (0.4, 0.5), find="rate", rate=0.9)
    assert 3 - 2 * np.exp(0.5) > -0.298 and 0.2974 < varied.rate < 0.31
    assert not furthest_sampled(lag(1), [[0]], T=(0.1, 1)).proven
    for bad, text in ((dict(find="gain"), "find must be"), (dict(), "T must be")):
        with pytest.raises(ValueError, match=text):
            furthest_sampled(CART, [[-1, -1.2]], 0.1, **bad)


@pytest.mark.campaign  # in the gate test_mip_robot proves a robot's observer so
def test_the_pendulums_observer_keeps_its_proof_under_delays_that_vary():
    """Its law holds for each delay from none to a tick, in any order."""
    robot = replace(Robot.shipped("thesis"), law="observer")
    assert Deployment(Mip.printed(), robot=robot).varying == ()
    found = spared(Deployment(Mip.printed(), robot=robot, patience=500.0))
    assert all(proof.proven for proof in found.varying) and len(found.varying) == 2
    assert found.lacking == () and list(found.sampled) == [(0.0, robot.delay)]
    said = found.facts["proof of the sampled loop"]
    assert said.endswith("stable for every sequence of delays from 0 to 10 ms")
    for proof in found.varying:
        assert f"delays in [0.0, {robot.delay!r}] s" in proof.claims[0]
    plant = Mip.printed().plant()
    late = np.random.default_rng(1).choice([0, robot.T], 4000)
    T = np.full(4000, robot.T)
    sizes = motion(plant, found.loops[0.0][0].controller, T, late, [0.1, 0, 0, 0])
    assert sizes[-1] < 1e-2 * sizes.max()


def test_a_disk_that_has_all_eigenvalues():
    """x' = a x + u, u = k x: the eigenvalue of each plant in closed form."""
    law, T = [[-2.0]], 0.3
    poles = np.array([-1.0, 0.5])
    ends = np.exp(poles * T) - 2 * np.expm1(poles * T) / poles
    plants = sos.DescriptorSystem([[1]], [[[a]] for a in poles], [[1]])
    centre = round(float(ends.mean()), 6)
    half = abs(ends - centre).max()
    good = certify_sampled(plants, law, T, rate=1.01 * half, centre=centre)
    assert good.proven and good.centre == centre and good.rate == 1.01 * half
    assert good.claims[0].endswith(f"are in |z - {centre!r}| < {good.rate!r}")
    bad = certify_sampled(plants, law, T, rate=0.99 * half, centre=centre)
    assert not bad.proven and f"away from {centre:.6g}" in bad.failed[0]
    assert type(good)(good.text).verify()
    moved = good.text.replace(f'"centre":"{centre!r}"', '"centre":"0.01"')
    assert moved != good.text and not type(good)(moved).proven
    cart = certify_sampled(CART, [[-1, -1.2]], 0.1, 0.03, rate=0.47, centre=0.5)
    eigenvalues = np.linalg.eigvals(sampled_loop(CART, [[-1, -1.2]], 0.1, 0.03)[0])
    assert cart.proven == (abs(eigenvalues - 0.5).max() < 0.47)
    for change in (dict(rate=0.6), dict(T=(0.1, 0.2), rate=0.4)):
        with pytest.raises(ValueError, match="must lie in the unit disk"):
            asked = dict(T=0.1, centre=0.5) | change
            certify_sampled(CART, [[-1, -1.2]], **asked)
