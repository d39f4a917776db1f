"""The functional over the whole interval, against roots, motions and numbers."""

import numpy as np
import pytest

from sosbook.book import thesis
from sosbook.delay import (
    ConstantDelay,
    DelayedLoop,
    DelayRequest,
    RandomDelay,
    SawtoothDelay,
    SwitchingDelay,
    analyse_delay,
    largest,
    simulate_delay,
)
from sosbook.theorems import Times, interval_decay, interval_kernel
from tests.cases import examples, seeds
from tests.test_delay_theorems import Motion, integral

SCALAR = DelayedLoop([[0]], [[-1]])
MASSES = thesis.delay_example_2()


def jensen(A, Ad, h1, h2, values):
    """Minus the bound of V' as in Park, Ko and Jeong (2011), block by block."""
    P, Q1, Q2, R1, R2, T = (values[k] for k in ("P", "Q1", "Q2", "R1", "R2", "T"))
    W = h1**2 * R1 + (h2 - h1) ** 2 * R2
    zero = 0 * P
    rows = [
        [P @ A + A.T @ P + Q1 - R1 + A.T @ W @ A, R1, P @ Ad + A.T @ W @ Ad, zero],
        [R1, -Q1 + Q2 - R1 - R2, R2 - T, T],
        [
            (P @ Ad + A.T @ W @ Ad).T,
            (R2 - T).T,
            Ad.T @ W @ Ad - 2 * R2 + T + T.T,
            R2 - T,
        ],
        [zero, T.T, (R2 - T).T, -Q2 - R2],
    ]
    return -np.block(rows)


def test_order_0_is_the_printed_matrix():
    rng = np.random.default_rng(5)
    N, tau, mu = 3, 0.7, 0.4
    A, Ad = rng.standard_normal((2, N, N))
    values = {}
    for name in ("P", "Q1", "Q2", "R1", "R2"):
        X = rng.standard_normal((N, N))
        values[name] = X + X.T
    values["T"] = rng.standard_normal((N, N))
    t = Times(tau, mu, 0.0, 1.0, 1.0)
    ours = interval_decay(A, Ad, **values, order=0, t=t, late=0)
    np.testing.assert_allclose(
        ours, jensen(A, Ad, tau - mu, tau + mu, values), atol=1e-12
    )


@pytest.mark.parametrize("order", [0, 1])
@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
def test_the_form_bounds_the_derivative_of_V(order, share):
    """Along a random past: V' by quadrature is at most minus the form."""
    rng, N, tau = np.random.default_rng(11 + order), 2, 0.8
    h1, h2 = tau - share * tau, tau + share * tau
    loop, asked = DelayedLoop(*np.zeros((2, N, N))), dict(tau=tau, mu=share * tau)
    request = DelayRequest(loop, **asked, method="interval", order=order)
    v = dict.fromkeys(("P", "Q1", "Q2", "R1", "R2", "T"))
    for u in request.unknowns():
        X = rng.standard_normal(u.shape)
        v[u.name] = X @ X.T if u.symmetric else X
    while share and np.linalg.eigvalsh(interval_kernel(v["R2"], v["T"], order))[0] <= 0:
        v["T"] = v["T"] / 2  # a T for which the kernel is positive
    A, Ad = rng.standard_normal((2, N, N))
    x = Motion(rng, N, 5)

    def mean(a, b):
        return integral(x, a, b) / (b - a) if a < b else x(a)

    def grown(Q, R, a, b):
        """What the terms in Q and R of the interval [-a, -b] add to V'."""
        energy = integral(lambda s: x.dx(s) @ R @ x.dx(s), -a, -b)
        known = x(-b) @ Q @ x(-b) - x(-a) @ Q @ x(-a)
        return known + (a - b) ** 2 * q @ R @ q - (a - b) * energy

    for d in np.linspace(h1, h2, 4):
        t = Times(tau, share * tau, 0.0, 1.0, 1.0)
        near, far = (
            interval_decay(A, Ad, **v, order=order, t=t, late=late) for late in (0, 1)
        )
        form = near + (far - near) * ((d - h1) / (h2 - h1) if share else 0.0)
        q = A @ x(0.0) + Ad @ x(-d)
        state, rate, parts, means, true = [x(0.0)], [q], [x(0.0)], [], 0.0
        if h1 > 0:
            parts.append(x(-h1))
            means.append(mean(-h1, 0.0))
            true += grown(v["Q1"], v["R1"], h1, 0.0)
            state.append(integral(x, -h1, 0.0))
            rate.append(x(0.0) - x(-h1))
        if share:
            parts += [x(-d), x(-h2)]
            means += [mean(-d, -h1), mean(-h2, -d)]
            true += grown(v["Q2"], v["R2"], h2, h1)
            state.append(integral(x, -h2, -h1))
            rate.append(x(-h1) - x(-h2))
        if order == 0:
            state, rate, means = state[:1], rate[:1], []
        true += 2 * np.concatenate(state) @ v["P"] @ np.concatenate(rate)
        zeta = np.concatenate(parts + means)
        assert zeta @ form @ zeta <= -true + 1e-9 * abs(true)


@pytest.mark.campaign  # "Sharper certificates" has both ends
@pytest.mark.parametrize("order, proven, beyond", [(0, 1.338, 1.34), (1, 1.34, 1.46)])
def test_the_scalar_loop_beyond_the_wall(order, proven, beyond):
    """x' = -x(t - d), d in [0, D]: Theorem A.3's wall is at .92, truth 3/2."""
    inside = analyse_delay(
        SCALAR, tau=proven / 2, mu=proven / 2, method="interval", order=order
    )
    assert inside.certify().proven
    outside = analyse_delay(
        SCALAR, tau=beyond / 2, mu=beyond / 2, method="interval", order=order
    )
    assert outside.status == "infeasible"
    assert outside.infeasibility.proven
    old = analyse_delay(SCALAR, tau=0.47, mu=0.47, method="legendre")
    assert old.status == "undecided" and "order" in old.reason


@pytest.mark.campaign
def test_the_two_masses_beyond_the_wall():
    asked = dict(K=MASSES.K, U=MASSES.U, tau=0.4, method="interval", order=0)
    d = analyse_delay(MASSES.plant, mu=0.397, **asked)
    assert d.certify().proven
    coarse = analyse_delay(
        MASSES.plant, MASSES.K, MASSES.U, 0.4, 0.39, method="legendre"
    )
    assert coarse.status != "feasible"


def test_order_1_proves_what_order_0_proves():
    rng = np.random.default_rng(3)
    seen = 0
    for _ in range(examples(7, 12)):
        A = rng.standard_normal((2, 2)) - np.eye(2)
        Ad = 0.8 * rng.standard_normal((2, 2))
        asked = dict(tau=0.5, mu=0.3, method="interval")
        coarse = analyse_delay(DelayedLoop(A, Ad), order=0, **asked)
        if coarse.status == "feasible":
            sharp = analyse_delay(DelayedLoop(A, Ad), order=1, **asked)
            assert sharp.certify().proven
            seen += 1
    assert seen >= 2


@pytest.mark.parametrize("seed", seeds(6))
def test_a_certified_rate_is_true(seed):
    """Roots of constant delays, and motions under delays that vary."""
    rng = np.random.default_rng(seed)
    N = 1 + seed % 2
    loop = DelayedLoop(
        rng.standard_normal((N, N)) - 2.5 * np.eye(N), 0.6 * rng.standard_normal((N, N))
    )
    tau = round(float(rng.uniform(0.2, 0.8)), 2)
    mu = round(tau * (0.0, 0.4, 1.0)[seed % 3], 3)
    asked = dict(tau=tau, mu=mu, method="interval", order=seed // 3)
    found = largest("delta", loop, delta=0.1, **asked)
    assert found.design.certify().proven
    assert found.design.slowest_decay()[0] >= found.value
    kinds = [ConstantDelay(tau + mu)]
    if mu:
        low, high = tau - mu, tau + mu
        kinds += [
            SawtoothDelay(low, high),
            SwitchingDelay(low, high, 0.7),
            RandomDelay(low, high, 0.3, seed=seed),
        ]
    t, start = np.linspace(0, 20, 401), rng.standard_normal(N)
    for delay in kinds:
        motion = simulate_delay(
            loop.vertices[0], np.eye(N), t, delay, history=lambda s: start
        )
        size = np.linalg.norm(motion.x, axis=0) * np.exp(found.value * t)
        assert size[300:].max() < 2 * size[:100].max()


def test_an_unstable_loop_gets_no_certificate():
    """Constant delays of the interval that are unstable exclude a proof."""
    for D in (1.58, 2.0):
        for order in (0, 1):
            found = analyse_delay(
                SCALAR, tau=D - 0.1, mu=0.1, method="interval", order=order
            )
            assert found.status == "infeasible"
    with pytest.raises(ValueError, match="order must be 0 or 1, got 2"):
        analyse_delay(SCALAR, tau=1, method="interval", order=2)
    with pytest.raises(ValueError, match='method="interval" analyses a given gain'):
        DelayRequest(MASSES.plant, MASSES.U, 0.4, method="interval")
