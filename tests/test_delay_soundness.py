"""Certificates near their limit, held against roots and motions.

Random plants get gains at 95 % of the largest rate that can be proven,
where the LMIs are nearly tight. Nothing that is proven may fail: no
constant delay of the interval has a slower root, no sampled loop a
larger multiplier, and V grows on no motion, however the delay varies.
"""

from functools import cache
from itertools import product
from types import SimpleNamespace

import numpy as np
import pytest

import sosbook as sos
from sosbook.book import counterexamples, thesis
from sosbook.delay import (
    ConstantDelay,
    DelayedLoop,
    RandomDelay,
    SawtoothDelay,
    SineDelay,
    SwitchingDelay,
    analyse_delay,
    characteristic_roots,
    delayed_loop,
    design_delay_pid,
    largest,
    solve_delay,
)
from sosbook.delay.lyapunov import lyapunov_values
from sosbook.exact.definite import round_digits
from sosbook.theorems import Functional, delay_functional
from tests.cases import crossed, later, random_plant
from tests.test_delay_theorems import NAMES, functional

RAM = thesis.delay_example_2()


def loops(design):
    """(A, A_d) of each vertex."""
    return [delayed_loop(d, design.K) for d in design.request.vertices]


@cache
def near_the_limit(seed, method="functional"):
    """A design at 95 % of the largest provable rate."""
    rng = np.random.default_rng(seed)
    n = 1 + seed % 4 // 3
    plant = random_plant(rng, n, 1)
    U = rng.standard_normal((1, n)) if seed % 2 else None
    fast = np.abs(plant.poles()).max()
    tau = float(round_digits(rng.uniform(0.05, 0.4) / fast, 2))
    mu = float(round_digits(tau * rng.choice([0, 0.3, 0.6, 1]), 2))
    asked = dict(U=U, tau=tau, mu=mu, alpha=2 * tau, method=method)
    limit = largest("delta", plant, **asked, delta=0.2 * fast).value
    rate = float(round_digits(0.95 * limit, 3))
    return design_delay_pid(plant, **asked, delta=rate)


def signals(request, seed):
    """Delays of all kinds that use the whole interval."""
    tau, mu = request.tau, request.mu
    low, high = tau - mu, tau + mu
    found = [ConstantDelay(high)]
    if mu:
        rng = np.random.default_rng(seed)
        found += [
            ConstantDelay(low),
            SawtoothDelay(low, high),
            SineDelay(low, high, rng.uniform(0.3, 3) / tau),
            SwitchingDelay(low, high, rng.uniform(0.5, 6) * tau),
            RandomDelay(low, high, rng.uniform(0.3, 2) * tau, seed),
        ]
    return found


def motion(design, delay, seed, length=30, points=1500):
    """A motion from a random past, with the delay's jumps on its mesh."""
    request = design.request
    rng = np.random.default_rng(seed)
    end = length * request.tau
    still, wave = (
        request.frame.T @ xi for xi in rng.standard_normal((2, request.states))
    )
    omega = rng.uniform(0.5, 2) / request.tau
    t = np.union1d(np.linspace(0, end, points), delay.jumps(end))
    t = t[np.append(True, np.diff(t) > 1e-9 * end)]
    return design.simulate(t, delay, history=lambda s: still + np.sin(omega * s) * wave)


def growth(design, response):
    """The largest rise of e^(2 delta t) V, as a part of its first value."""
    V = lyapunov_values(design, response)
    known = ~np.isnan(V)
    W = (V * np.exp(2 * design.request.delta * response.t))[known]
    assert W[0] > 0
    return (W - np.minimum.accumulate(W)).max() / W[0]


def smallest_eigenvalue(design):
    """V is at least this times the square of xi, with x = T xi."""
    v, t = unbarred(design), design.request.times()
    return np.linalg.eigvalsh(delay_functional(v, t)[0])[0]


def unbarred(design):
    """The functional of Theorem A.3 in the design's coordinates."""
    v = {"Z": 0 * design.values["S"]} | design.values
    back = np.eye(len(v["P"]))
    if design.request.gain is None:
        back = np.linalg.inv(v["F"])
    return Functional(*(back @ v[name] @ back.T for name in NAMES))


# V itself


class Mode:
    """A real motion of a loop with a constant delay: c e^(s t)."""

    def __init__(self, c, s):
        self.c, self.s = c, s

    @classmethod
    def of(cls, A, A_d, delay):
        s = characteristic_roots(A, A_d, delay, 1)[0]
        at = s * np.eye(len(A)) - A - A_d * np.exp(-s * delay)
        return cls(np.linalg.svd(at)[2][-1].conj(), s)

    def __call__(self, t):
        return (self.c * np.exp(self.s * t)).real

    def dx(self, t):
        return (self.s * self.c * np.exp(self.s * t)).real

    def w(self, t):
        return np.concatenate([self(t), self.dx(t)])


@pytest.mark.slow
@pytest.mark.parametrize("case, mu", crossed(["design", "analysis", "shift"], [0.2, 0]))
def test_v_is_the_functional_as_defined(case, mu):
    """On a mode of the loop, against Gauss quadrature of V's integrals."""
    tau, delta = 0.4, 0.1
    asked = dict(tau=tau, mu=mu, delta=delta)
    if case == "analysis":
        d = analyse_delay(RAM.plant, RAM.K, RAM.U, **asked)
    else:
        method = "shift" if case == "shift" else "functional"
        d = design_delay_pid(RAM.plant, RAM.U, **asked, alpha=0.8, method=method)
    mode = Mode.of(*loops(d)[0], tau + mu / 2)
    t = np.linspace(0, 4, 401)
    response = d.simulate(t, ConstantDelay(tau + mu / 2), history=mode)
    assert np.allclose(response.x, np.array([mode(s) for s in t]).T, atol=1e-6)
    V = lyapunov_values(d, response)
    assert np.array_equal(np.isnan(V), t < tau + mu - 1e-9)
    # x = T xi, time in units of tau; shifted: times e^(delta t)
    shift = delta if case == "shift" else 0.0
    scaled = Mode(np.linalg.solve(d.request.frame.T, mode.c), tau * (mode.s + shift))
    wanted = functional(scaled, unbarred(d), 1.0, mu / tau, tau * (delta - shift))
    for k in (60, 61, 200, 400):
        assert V[k] * np.exp(2 * shift * t[k]) == pytest.approx(
            wanted(t[k] / tau), rel=1e-5
        )


def test_bad_questions_for_v():
    d = near_the_limit(0)
    response = motion(d, ConstantDelay(d.request.tau), 0)
    short = d.simulate([0, d.request.tau / 2], ConstantDelay(d.request.tau))
    other = SimpleNamespace(x=np.ones((7, 2)), dx=np.ones((7, 2)))
    other_v = analyse_delay(DelayedLoop([[0]], [[-1]]), tau=1, method="legendre")
    none = analyse_delay(DelayedLoop([[0]], [[-1]]), tau=2)
    for question, words in [
        ((d, short), "must last longer than tau"),
        ((d, other), "response must be a DelayedResponse with"),
        ((d, [response]), "the one of a single vertex"),
        ((other_v, response), 'must have method="functional" or "shift"'),
        ((none, response), "the design is infeasible"),
    ]:
        with pytest.raises(ValueError, match=words):
            lyapunov_values(*question)


# The campaign


@pytest.mark.slow
@pytest.mark.parametrize(
    "seed, method",
    [
        *((1, "shift"), (5, "functional")),
        *later((1, "functional"), (5, "shift")),
        *later(*product((0, 2, 3, 6, 9, 11), ("functional", "shift"))),
    ],
)
def test_no_delay_refutes_a_proof(seed, method):
    """No constant one by its roots; and e^(2 delta t) V falls, and holds the motion
    below a falling bound.
    """
    d = near_the_limit(seed, method)
    assert d.certify().proven and d.slowest_decay()[0] > d.request.delta
    least = smallest_eigenvalue(d)
    for k, delay in enumerate(signals(d.request, seed)):
        response = motion(d, delay, 100 * seed + k)
        assert growth(d, response) < 1e-6, delay
        V = lyapunov_values(d, response)
        xi = np.linalg.solve(d.request.frame.T, response.x)
        known = ~np.isnan(V)
        size = (xi**2).sum(0)[known]
        assert (V[known] >= least * size).all(), delay
        t = response.t[known] - response.t[known][0]
        bound = V[known][0] * np.exp(-2 * d.request.delta * t) / least
        assert (size <= bound).all(), delay


@pytest.mark.slow
@pytest.mark.parametrize(
    "changes", [dict(mu=0.24), dict(delta=0.13), dict(mu=0.0, tau=0.6)], ids=str
)
def test_v_of_an_analysis_grows_on_no_motion(changes):
    """The thesis's gain of Example 2 near the limits of its proof."""
    asked = dict(tau=0.4, mu=0.2, delta=0.1) | changes
    d = analyse_delay(RAM.plant, RAM.K, RAM.U, **asked)
    assert d.certify().proven
    assert d.slowest_decay()[0] > asked["delta"]
    for k, delay in enumerate(signals(d.request, 5)):
        assert growth(d, motion(d, delay, k)) < 1e-6, delay


def slowest_switched(design, seconds=8.0, h=0.002):
    """The slowest decay of a loop whose plant and delay are chosen at each step, by
    what a motion does: a spring is stiff on the way out and soft on the way back.
    """
    A, A_d = (np.array(part) for part in zip(*loops(design)))
    tau, mu = design.request.tau, design.request.mu
    low, high = (round((tau + s * mu) / h) for s in (-1, 1))
    ways = np.array([*product((1, -1), (low, high), (low, high))])  # all in one go
    plant, each, steps = ways[:, 0], np.arange(len(ways)), round(seconds / h)
    x = np.zeros((high + 1 + steps, len(ways), 2, 1))
    x[: high + 1, :, 0] = 1
    for now in range(high, high + steps):
        out = (x[now, :, :, 0].prod(axis=1) * plant > 0).astype(int)
        here, there, late = A[out], A_d[out], np.where(out, ways[:, 1], ways[:, 2])
        seen = x[now - late, each]
        middle = x[now] + h / 2 * (here @ x[now] + there @ seen)
        soon = (seen + x[now - late + 1, each]) / 2
        seen = np.where((late > 1)[:, None, None], soon, x[now])
        x[now + 1] = x[now] + h * (here @ middle + there @ seen)
    size, part = np.linalg.norm(x[..., 0], axis=2), round(steps / 4)
    first, last = size[part : 2 * part].max(axis=0), size[-part:].max(axis=0)
    return (np.log(first / last) / (2.5 * part * h)).min()


@pytest.mark.parametrize(
    "spread, delta", [(0.1, 0.3), (0.8, 0.0), *later((0.05, 0.45))]
)
def test_no_switching_of_plants_and_delays_refutes_a_proof(spread, delta):
    """A swing whose spring changes with its motion decays slower than any of its
    plants, or grows; what is proven of a changing plant holds, and what grows isn't
    proven.
    """
    springs = [9.81 * (1 - spread), 9.81 * (1 + spread)]
    plants = sos.Polytope(sos.SecondOrderSystem(0.3, 0.2, k, 1) for k in springs)
    d = analyse_delay(plants, [[0.3, -0.4]], tau=0.05, mu=0.03, delta=delta)
    rate = slowest_switched(d)
    assert rate < 0.97 * d.slowest_decay()[0]
    assert (d.status == "feasible") == (rate > 0)
    if d.status == "feasible":
        proof = d.certify()
        assert proof.proven and "constant or changing plant" in proof.claims[0]
        assert rate > delta


# What a refutation looks like


@pytest.mark.parametrize("name", ["transpose", "alpha"])
def test_v_of_a_misprinted_proof_grows(name):
    d = solve_delay(counterexamples.misprint(name))
    assert d.certify().proven
    delay = ConstantDelay(d.request.tau + d.request.mu)
    response = motion(d, delay, 0, length=40)
    assert growth(d, response) > 1


def test_the_misprinted_sign_leaves_v_without_a_bound():
    """Nothing makes Z positive then: V falls, and goes to -infinity."""
    for d in (
        solve_delay(counterexamples.misprint("sign")),
        design_delay_pid(RAM.plant, **RAM.requirements, printed=True),
    ):
        assert d.certify().proven
        assert np.linalg.eigvalsh(d.values["Z"])[0] < 0
        V = lyapunov_values(d, motion(d, ConstantDelay(d.slowest_decay()[1]), 0))
        assert V[-1] < 1e6 * min(V[~np.isnan(V)][0], -1)


def test_v_grows_on_motions_of_another_loop():
    """The check itself can fail: V of one gain, motion of another."""
    d = near_the_limit(1)
    (vertex,) = d.request.vertices
    response = sos.delay.simulate_delay(
        vertex,
        -d.K,
        np.linspace(0, 20 * d.request.tau, 1501),
        ConstantDelay(d.request.tau),
        history=lambda s: d.request.frame.T[0],
    )
    assert growth(d, response) > 0.1
