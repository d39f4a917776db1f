"""Loops with a late input against series and ODE solvers."""

from dataclasses import dataclass
from math import factorial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.optimize import brentq

import sosbook as sos
from sosbook.book import thesis
from sosbook.delay.profiles import (
    ConstantDelay,
    RandomDelay,
    SawtoothDelay,
    SineDelay,
    SwitchingDelay,
)
from sosbook.delay.simulation import simulate_delay
from sosbook.plants.descriptor import Descriptor, descriptors
from sosbook.plants.response import simulate
from tests.cases import campaign, examples

# Example 2 of the thesis's part on delay, joined by a disturbance
PLANT = sos.SecondOrderSystem(
    np.eye(2), [[1, -1], [-1, 1]], [[3, -2], [-2, 3]], [[1], [0]], [[0.5], [1]]
)
(LOOP,) = descriptors(PLANT, [[1, 0]])
K = thesis.delay_example_2().K
R = np.array([1.0, 0.0])
X0 = np.array([0.3, -0.2, 0.5, 0.1, 0.05])
# M = I: x' = A x + B u(t - d) + C, written out
A = np.array(
    [
        [0, 0, 1, 0, 0],
        [0, 0, 0, 1, 0],
        [-3, 2, -1, 1, 0],
        [2, -3, 1, -1, 0],
        [1, 0, 0, 0, 0.0],
    ]
)
B = np.array([0, 0, 1, 0, 0.0])
C = np.array([0, 0, 0, 0, -1.0])


def controller(x):
    return K[0] @ x - K[0, :2] @ R


def scalar(a, b):
    """x' = a x + b u with u = x, so K = [[1]]."""
    one = np.eye(1)
    return Descriptor(one, a * one, b * one, np.zeros((1, 0)), one)


def integrate(edges, delays, x0):
    """Dormand and Prince from edge to edge, d by pieces, u = 0 before 0.

    No piece is longer than its shortest delay: the past is known.
    """
    past, ends = [], [x0]

    def late(s):
        return next(p for p in past if s <= p.t_max + 1e-12)(s)

    for a, b, delay in zip(edges, edges[1:], delays):
        on = (a + b) / 2 - delay((a + b) / 2) > 0

        def rate(t, x):
            asked = t - delay(t)
            u = controller(late(max(asked, 0.0))) if on else 0.0
            return A @ x + B * u + C

        done = solve_ivp(
            rate, (a, b), x0, method="DOP853", rtol=1e-11, atol=1e-12, dense_output=True
        )
        past.append(done.sol)
        x0 = done.y[:, -1]
        ends.append(x0)
    return np.array(ends).T


def cut(edges, longest):
    """Further edges, so that no piece is longer."""
    return np.concatenate(
        [
            np.linspace(a, b, int(np.ceil((b - a) / longest)) + 1)[:-1]
            for a, b in zip(edges, edges[1:])
        ]
        + [edges[-1:]]
    )


def test_polynomials_by_the_method_of_steps():
    """x' = -x(t - 1), x = 1 before: a sum of powers, piece by piece."""
    t = np.linspace(0, 6, 241)
    exact = sum(
        (-1) ** k / factorial(k) * np.maximum(t - (k - 1), 0) ** k for k in range(8)
    )
    answer = simulate_delay(
        scalar(0, 1), [[-1]], t, ConstantDelay(1), history=lambda s: [1.0]
    )
    assert np.abs(answer.x[0] - exact).max() < 1e-10
    assert np.allclose(answer.dx, answer.applied)
    # cubics are read off exactly, parabolas are integrated exactly
    first = t <= 3
    coarse = simulate_delay(
        scalar(0, 1),
        [[-1]],
        t[first],
        ConstantDelay(1),
        history=lambda s: [1.0],
        step=1.0,
    )
    assert np.abs(coarse.x[0] - exact[first]).max() < 1e-12


@dataclass(frozen=True)
class Pantograph:
    """d = t / 2: a delay of another kind, zero at the start."""

    low: float = 0.0
    high: float = 2.0

    def __call__(self, t):
        return np.asarray(t) / 2

    def jumps(self, end):
        return []


def test_a_delay_that_starts_at_zero_against_a_power_series():
    """x' = -x(t / 2): sum of (-1)^k 2^(-k (k - 1) / 2) t^k / k!."""
    t = np.linspace(0, 4, 81)
    exact = sum(
        (-1) ** k * 2.0 ** (-k * (k - 1) / 2) * t**k / factorial(k) for k in range(30)
    )
    answer = simulate_delay(scalar(0, 1), [[-1]], t, Pantograph(), x0=[1])
    assert np.abs(answer.x[0] - exact).max() < 1e-9


@pytest.mark.parametrize("start", [0.0, 0.3])
def test_without_delay_it_is_the_exact_simulation(start):
    t = np.linspace(0, 8, 161)
    w = sos.Sine(2, 3, offset=0.5, start=start, stop=4.123)
    answer = simulate_delay(LOOP, K, t, ConstantDelay(0), R, w, X0)
    exact = simulate(LOOP, K, t, R, w, X0)
    for name in ("x", "z", "dz", "e", "u", "w"):
        near = getattr(answer, name) - getattr(exact, name)
        assert np.abs(near).max() < 1e-8
    assert np.abs(answer.applied - answer.u).max() < 1e-8
    assert np.allclose(answer.dx[:2], answer.dz, atol=1e-12)


def test_two_inputs_without_delay():
    ex = thesis.example_1()
    d = descriptors(ex.plant, ex.U)[0]
    t, r = np.linspace(0, 3, 31), [1.0, -0.5]
    exact = simulate(d, ex.K, t, r)
    nearly = SineDelay(0, 1e-12, 1)
    for delay in (ConstantDelay(0), SineDelay(0, 0, 1), nearly):
        answer = simulate_delay(d, ex.K, t, delay, r)
        assert np.abs(answer.x - exact.x).max() < 1e-8


@pytest.mark.parametrize("low, high", [(0, 2), (1, 3), (2, 6), (5, 7), (3, 4)])
def test_sawtooth_is_sample_and_hold(low, high):
    """Recursion with matrix exponentials, times counted in tenths."""
    big = np.zeros((7, 7))
    big[:5, :5], big[:5, 5], big[:5, 6] = A, B, C
    flow = expm(0.1 * big)[:5]
    x, u, applied = np.empty((5, 101)), np.empty(101), np.zeros(101)
    x[:, 0], period = X0, high - low
    for k in range(101):
        u[k] = controller(x[:, k])
        sample = (k - low) // period * period
        applied[k] = u[sample] if sample >= 0 else 0.0
        if k < 100:
            x[:, k + 1] = flow @ [*x[:, k], applied[k], 1]
    delay = SawtoothDelay(low / 10, high / 10)
    answer = simulate_delay(LOOP, K, np.arange(101) / 10, delay, R, x0=X0)
    assert np.abs(answer.x - x).max() < 1e-10
    assert np.abs(answer.applied[0] - applied).max() < 1e-10


@pytest.mark.parametrize(
    "low, high, omega, phase",
    [
        (0.2, 0.6, 3.0, 0.0),  # t - d(t) grows
        (0.2, 0.6, 9.0, 0.7),  # it doesn't always: d' > 1
        (0.4, 0.4, 3.0, 0.0),  # constant
    ],
)
def test_sine_delay_against_an_ode_solver(low, high, omega, phase):
    def delay(t):
        return (low + high) / 2 + (high - low) / 2 * np.sin(omega * t + phase)

    def arrivals(mark):
        near = np.linspace(mark, mark + 0.7, 2001)
        passed = near - delay(near) > mark
        return [
            brentq(lambda t: t - delay(t) - mark, a, b, xtol=1e-14)
            for a, b, one, two in zip(near, near[1:], passed, passed[1:])
            if one != two
        ]

    first = arrivals(0.0)
    edges = np.unique([0, *first, *(b for a in first for b in arrivals(a)), 6])
    edges = cut(edges, low)
    x = integrate(edges, [delay] * len(edges), X0)
    signal = SineDelay(low, high, omega, phase)
    assert np.allclose(signal(edges), delay(edges), atol=1e-15)
    answer = simulate_delay(LOOP, K, edges, signal, R, x0=X0)
    assert np.abs(answer.x - x).max() < 1e-8


@pytest.mark.slow
@pytest.mark.parametrize(
    "delay",
    [
        SwitchingDelay(0.1, 0.6, 0.15),
        RandomDelay(0.2, 0.6, 0.5, seed=3),
        *campaign([SwitchingDelay(0.2, 0.6, 0.7), RandomDelay(0.1, 0.7, 0.1, seed=4)]),
    ],
    ids=str,
)
def test_jumping_delays_against_an_ode_solver(delay):
    end = 5.0
    jumps = delay.dwell * np.arange(int(np.ceil(end / delay.dwell)) + 1)
    values = delay(jumps + delay.dwell / 2)
    arrive = [v for a, b, v in zip(jumps, jumps[1:], values) if a < v < b]
    edges = np.unique([*jumps[jumps < end], *arrive, end])
    edges = cut(edges, delay.low)
    middle = (edges[1:] + edges[:-1]) / 2
    known = values[np.floor(middle / delay.dwell).astype(int)]
    x = integrate(edges, [lambda t, v=v: v for v in known], X0)
    answer = simulate_delay(LOOP, K, edges, delay, R, x0=X0)
    assert np.abs(answer.x - x).max() < 1e-7
    assert np.abs(answer.x - x)[:, edges < 2].max() < 1e-8


def test_steps_chosen_for_a_faster_plant():
    """The thesis's wing: without a step the answer has eight digits."""
    wing = thesis.delay_example_1()
    (d,) = descriptors(wing.plant, wing.U)
    for delay in (
        ConstantDelay(0.2),
        SineDelay(0.1, 0.3, 5),
        RandomDelay(0, 0.3, 0.2, seed=1),
    ):
        answer, exact = (
            simulate_delay(d, wing.K, [0, 1, 4], delay, [1, 0, 0], step=step).x
            for step in (None, 0.002)
        )
        assert np.abs(answer - exact).max() < 1e-8 * np.abs(exact).max()


@pytest.mark.parametrize(
    "delay",
    [
        SineDelay(0, 0.8, 3.0),
        SwitchingDelay(0, 0.6, 0.23),
        RandomDelay(0, 0.8, 0.5, seed=2),
        RandomDelay(0, 0.8, 0.007, seed=2),
    ],
    ids=str,
)
def test_the_order_survives_jumps_and_zero_delays(delay):
    """Errors fall like step^4, measured against much finer steps."""

    def end(step):
        w = sos.Sine(1, 2, offset=1, start=0.77, stop=1.9)
        answer = simulate_delay(LOOP, K, [0, 3], delay, R, w, X0, step=step)
        return answer.x[:, -1]

    exact = end(0.002)
    errors = [np.abs(end(h) - exact).max() for h in (0.1, 0.05, 0.025)]
    assert errors[2] < 1e-8
    # jumps that are closer than the step shorten it anyway
    assert errors[2] < errors[0] / 100 or errors[0] < 1e-7


def test_samples_of_the_past_are_held_as_well():
    """low > high - low: more than one sample is on its way at t = 0."""
    delay, t = SawtoothDelay(0.5, 0.7), np.linspace(0, 0.5, 51)[:-1]
    answer = simulate_delay(scalar(0, 1), [[1]], t, delay, history=lambda s: [1 + s])
    u = np.array([0.4, 0.6, 0.8])  # of t = -0.6, -0.4 and -0.2
    held = u[np.floor((np.arange(50) + 10) / 20).astype(int)]
    x = 1 + 0.01 * np.concatenate([[0], np.cumsum(held)[:-1]])
    assert np.allclose(answer.applied[0], held, atol=1e-12)
    assert np.allclose(answer.x[0], x, atol=1e-12)


def test_an_initial_state_may_differ_from_the_past():
    t = np.linspace(0, 1, 11)
    answer = simulate_delay(
        scalar(0, 1), [[1]], t, ConstantDelay(1), x0=[5], history=lambda s: [s]
    )
    assert np.allclose(answer.x[0], 5 - t + t**2 / 2, atol=1e-14)
    off = simulate_delay(scalar(0, 1), [[1]], t, ConstantDelay(1), x0=[5])
    assert np.array_equal(off.x[0], np.full(11, 5.0))
    assert np.array_equal(off.u[0], off.x[0])
    assert np.isclose(off.applied[0, -1], 5) and not off.applied[0, :-1].any()


def test_a_loop_at_rest_stays_there_until_the_disturbance_starts():
    w = sos.Sine(1, 2, offset=1, start=0.5, stop=1.0)
    t = np.linspace(0, 2, 81)
    answer = simulate_delay(LOOP, K, t, ConstantDelay(0.3), w=w)
    free = simulate(LOOP, np.zeros((1, 5)), t, w=w)
    assert np.abs(answer.x[:, t <= 0.5]).max() == 0
    untouched = t <= 0.8
    assert np.abs(answer.x - free.x)[:, untouched].max() < 1e-12
    assert np.abs(answer.x - free.x)[:, ~untouched].max() > 1e-3


def test_set_points_reach_the_integrator_first():
    answer = simulate_delay(LOOP, K, [0, 0.2, 0.39, 0.4], ConstantDelay(0.4), R)
    assert np.allclose(answer.x[4], -answer.t, atol=1e-14)
    assert np.array_equal(answer.applied[0, :3], [0, 0, 0])
    assert np.isclose(answer.applied[0, 3], -K[0, 0], atol=1e-13)
    assert np.array_equal(answer.e, answer.z - R[:, None])


def test_a_time_scale_of_picoseconds():
    """The same loop with seconds of 1e12 of ours."""
    c, t = 1e-12, np.linspace(0, 3, 21)
    answers = [
        simulate_delay(
            scalar(-1 / s, 1 / s),
            [[-1]],
            t * s,
            SineDelay(0.1 * s, 0.5 * s, 4 / s),
            x0=[1],
        )
        for s in (1, c)
    ]
    assert np.allclose(answers[0].x, answers[1].x, rtol=1e-9, atol=1e-12)


@given(
    low=st.floats(0, 0.5),
    width=st.floats(0.01, 0.5),
    dwell=st.floats(0.02, 1),
    seed=st.integers(0, 10**6),
    kind=st.sampled_from(["sine", "saw", "switch", "random"]),
)
@settings(max_examples=examples(12, 30))
def test_what_is_applied_was_asked_for(low, width, dwell, seed, kind):
    """applied(t) is u at t - d(t), simulated as a time of its own."""
    high = low + width
    delay = {
        "sine": SineDelay(low, high, 1 / dwell, seed % 7),
        "saw": SawtoothDelay(low, high),
        "switch": SwitchingDelay(low, high, dwell),
        "random": RandomDelay(low, high, dwell, seed),
    }[kind]
    t = np.linspace(0, 2, 14)
    values = delay(t)
    assert (low <= values).all() and (values <= high).all()
    asked = t - values
    asked = asked[asked > 1e-9]
    every = np.unique(np.concatenate([t, asked]).round(12))
    every = every[np.diff(every, prepend=-1) > 1e-9]
    few = simulate_delay(LOOP, K, t, delay, R, x0=X0)
    many = simulate_delay(LOOP, K, every, delay, R, x0=X0)
    late = t - values > 1e-8
    there = np.abs(every - (t - values)[late, None]).argmin(1)
    assert np.abs(few.applied[0, late] - many.u[0, there]).max(initial=0) < 1e-7
    assert np.abs(few.applied[0, t - values < -1e-8]).max(initial=0) == 0


def test_random_delays_come_from_their_seed():
    one, other = (RandomDelay(0.1, 0.5, 0.05, seed=s) for s in (1, 2))
    t = np.linspace(0, 20, 4001)
    assert np.array_equal(one(t), one(t))
    assert np.array_equal(one(t[:100]), one(t)[:100])
    assert one(t[77]) == one(t)[77]
    assert not np.allclose(one(t), other(t))
    values = np.unique(one(t))
    assert len(values) == 401 and 0.1 <= values.min() < values.max() <= 0.5
    assert abs(values.mean() - 0.3) < 0.02
    first, second = (
        simulate_delay(LOOP, K, [0, 3, 4], d, R).x
        for d in (one, RandomDelay(0.1, 0.5, 0.05, 1))
    )
    assert np.array_equal(first, second)


@pytest.mark.parametrize(
    "delay",
    [
        SawtoothDelay(0.1, 0.4),
        SawtoothDelay(0, 0.7),
        SawtoothDelay(0.5, 0.7),
        SwitchingDelay(0.1, 0.3, 0.1),
        RandomDelay(0, 1, 0.7, 5),
    ],
    ids=str,
)
def test_jumps_are_where_the_delay_jumps(delay):
    """Also where multiples of a decimal fraction are rounded."""
    jumps = delay.jumps(50.0)
    assert (np.diff(jumps) > 0).all() and 0 < jumps[0] and jumps[-1] < 50
    period = getattr(delay, "dwell", delay.high - delay.low)
    assert np.allclose(np.diff(jumps), period)
    assert max(jumps[0], 50 - jumps[-1]) < period + 1e-9
    after = delay(jumps + 1e-9)
    assert np.allclose(delay(jumps), after, atol=1e-8)
    assert np.allclose(delay(jumps.round(9)), after, atol=1e-8)
    assert (np.abs(delay(jumps - 1e-9) - after) > 1e-5).all()
    between = np.linspace(jumps[:-1] + 1e-6, jumps[1:] - 1e-6, 9)
    slopes = np.diff(delay(between), axis=0) / np.diff(between, axis=0)
    slope = 1 if isinstance(delay, SawtoothDelay) else 0
    assert np.allclose(slopes, slope, atol=1e-6)


@pytest.mark.parametrize(
    "kind, numbers, words",
    [
        (ConstantDelay, (-0.1,), "value must be 0 or more"),
        (ConstantDelay, (np.nan,), "value must be a finite number"),
        (ConstantDelay, ("1",), "value must be a finite number"),
        (SineDelay, (-0.1, 1, 1), "low must be 0 or more"),
        (SineDelay, (2, 1, 1), "low must not exceed high"),
        (SineDelay, (0, np.inf, 1), "high must be a finite number"),
        (SineDelay, (0, 1, 0), "omega must be positive"),
        (SineDelay, (0, 1, 1, np.nan), "phase"),
        (SawtoothDelay, (1, 1), "high must exceed low"),
        (SwitchingDelay, (0, 1, 0), "dwell must be positive"),
        (SwitchingDelay, (1, 0, 1), "low must not exceed high"),
        (RandomDelay, (0, 1, -1, 0), "dwell must be positive"),
        (RandomDelay, (0, 1, 1, -1), "seed must be 0, 1"),
        (RandomDelay, (0, 1, 1, 0.5), "seed must be 0, 1"),
    ],
)
def test_delays_are_checked(kind, numbers, words):
    with pytest.raises(ValueError, match=words):
        kind(*numbers)


class Early(Pantograph):
    def __call__(self, t):
        return -np.asarray(t)


class Nowhere(Pantograph):
    def __call__(self, t):
        return np.nan * np.asarray(t)


@pytest.mark.parametrize(
    "bad, words",
    [
        (dict(t=[0, 1, 1]), "t must increase from 0"),
        (dict(K=[[1, 2]]), "K has 2 columns"),
        (dict(r=[1.0]), "r must hold 2"),
        (dict(x0=np.zeros(4)), "x0 must hold 5"),
        (dict(w=np.sin), "w must be a Sine"),
        (dict(delay=0.4), "delay must be a delay signal"),
        (dict(delay=np.sin), "delay must be a delay signal"),
        (dict(delay=Early()), "delay must be a number >= 0"),
        (dict(delay=Nowhere()), "delay must be a number >= 0"),
        (dict(delay=RandomDelay(0, 1, 1e-9, 0)), "delay jumps .* times"),
        (dict(history=1.0), "history must be a function"),
        (dict(history=lambda s: [1.0]), r"history\(s\) must hold 5"),
        (dict(history=lambda s: None), r"history\(s\) must hold 5"),
        (dict(step=0.0), "step must be a positive"),
        (dict(step=np.nan), "step must be a positive"),
        (dict(step="1"), "step must be a positive"),
        (dict(step=1e-9), "would take .* steps"),
        (dict(t=[0, 1e3], K=1e3 * K, r=R, step=0.1), "runs away"),
    ],
)
def test_what_is_asked_is_checked(bad, words):
    asked = dict(d=LOOP, K=K, t=[0, 1], delay=ConstantDelay(0.4))
    with pytest.raises(ValueError, match=words):
        simulate_delay(**{**asked, **bad})


def test_a_disturbance_needs_f():
    one = [[1.0]]
    (d,) = descriptors(sos.SecondOrderSystem(one, one, one, one))
    with pytest.raises(ValueError, match="no F"):
        simulate_delay(d, [[1, 1]], [0, 1], ConstantDelay(1), w=sos.Sine(1, 1))
