"""Controllable plants whose poles can go anywhere, with a gain that does it."""

import numpy as np
from flint import fmpq_mat

import sosbook as sos
from sosbook.exact.definite import exact
from sosbook.synthesis.fixed_mode import refuse_by_mode
from sosbook.synthesis.request import Request
from tests.random_plants import Case, Units


def placed(plant, poles):
    """The gain of one input for these poles, as floats: Ackermann's formula."""
    (d,) = Request(plant).vertices_in(exact)
    E, A, B = (fmpq_mat(*x.shape, list(x.ravel())) for x in (d.E, d.A, d.Bu))
    A, B = E.inv() * A, E.inv() * B
    N = A.nrows()
    one = fmpq_mat(N, N, [int(i == j) for i in range(N) for j in range(N)])
    reach, value = [B], one
    for p in poles:
        value = value * (A - exact(float(p)) * one)
        reach.append(A * reach[-1])
    reach = fmpq_mat([[r[i, 0] for r in reach[:-1]] for i in range(N)])
    last = fmpq_mat(1, N, [int(i == N - 1) for i in range(N)])
    K = -1 * (last * reach.inv() * value)
    return np.array([[float(k.p) / float(k.q) for k in K.entries()]])


def attack(seed):
    """A feasible `Case` with a large gain: a chain, two equal masses, or any plant."""
    rng = np.random.default_rng([seed, 16])
    kind = rng.choice(["chain", "alike", "any"])
    while True:
        plant, sigma = _plant(rng, kind)
        N = 2 * plant.n
        poles = -sigma * (1.2 + 0.1 * np.arange(N))
        region = sos.PoleRegion(sigma=float(sigma))
        try:
            K = placed(plant, poles)
        except (ZeroDivisionError, OverflowError):  # not controllable
            continue
        if np.abs(K).max() < 1e90 and _does_it(plant, K, region):
            break
    return Case(
        seed,
        "attacked",
        "feasible",
        f"{kind}, a gain of {np.abs(K).max():.0e} puts the poles there",
        plant,
        {"region": region},
        Units.plain(plant.n, 1, 0),
    )


def _does_it(plant, K, region):
    """Whether the gain, as floats, puts all poles into the region: exactly."""
    return refuse_by_mode(Request(plant, region=region, gain=K)) is None


def _plant(rng, kind):
    if kind == "chain":
        n = int(rng.integers(3, 13))
        S = 2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
        plant = sos.SecondOrderSystem(np.eye(n), np.zeros((n, n)), S, np.eye(n)[:, :1])
        return plant, rng.choice([0.5, 1.0, 2.0, 3.0])
    if kind == "alike":
        gap = float(f"{10 ** rng.uniform(-12, -2):.2g}")
        S = np.diag([1, 1 + gap])
        plant = sos.SecondOrderSystem(np.eye(2), 0.01 * np.eye(2), S, [[1], [1]])
        return plant, rng.choice([0.1, 1.0])
    n = int(rng.integers(1, 6))
    root = rng.standard_normal((n, n))
    plant = sos.SecondOrderSystem(
        np.eye(n) + 0.3 * root @ root.T,
        rng.standard_normal((n, n)),
        3 * rng.standard_normal((n, n)),
        rng.standard_normal((n, 1)),
    )
    return plant, rng.choice([0.5, 2.0, 8.0])
