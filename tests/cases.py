"""Plants and requests that several tests share."""

import os

import numpy as np
import pytest

import sosbook as sos
from sosbook.solver.settings import Settings

#: Newton's equations by conjugate gradients wherever they fit, and nowhere.
GRADIENTS = Settings(iterations_per_variable=np.inf)
DENSE = Settings(iterations_per_variable=0.0)
CAMPAIGN = "SOSBOOK_CAMPAIGN"  # set where pytest has --campaign, before tests are read


def campaign(values):
    """Values of a parameter that wait for the campaign; the gate takes others."""
    return [pytest.param(x, marks=pytest.mark.campaign) for x in values]


def later(*rows):
    """The same of several parameters: a row for each case."""
    return [pytest.param(*row, marks=pytest.mark.campaign) for row in rows]


def examples(gate, weekly):
    """How many examples hypothesis draws: so many in the gate, more in the campaign."""
    return weekly if os.environ.get(CAMPAIGN) else gate


def by_turns(values, turn, of=2):
    """Each second of some values, or each ``of``-th, from ``turn`` on; the others wait
    for the campaign. Tests of the same values take other turns, so that the gate looks
    at each value.
    """
    values = list(values)
    others = [x for k, x in enumerate(values) if k % of != turn]
    return [*values[turn::of], *campaign(others)]


def crossed(some, others):
    """Pairs of both, as on a chessboard: the gate takes those on fields of one colour,
    where each value meets half of the others; those between wait for the campaign.
    """
    pairs = [
        ((i + j) % 2, x, y) for i, x in enumerate(some) for j, y in enumerate(others)
    ]
    now, between = ([(x, y) for c, x, y in pairs if c == k] for k in (0, 1))
    return [*now, *later(*between)]


def seeds(count):
    """A third of some seeds, at least two; the others wait for the campaign."""
    now = max(2, -(-count // 3))
    return [*range(now), *campaign(range(now, count))]


def chain(n):
    """n masses between walls, a force on each second one."""
    S = 2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    return sos.SecondOrderSystem(
        np.eye(n), 0.1 * S, S, np.eye(n)[:, ::2], np.eye(n)[:, :1]
    )


def random_plant(rng, n, m, p=1, vertices=1, spread=0.0):
    """A plant, or a polytope around it, that nothing makes stable."""
    root = rng.standard_normal((n, n))
    parts = [
        np.eye(n) + 0.3 * root @ root.T,
        rng.standard_normal((n, n)),
        3 * rng.standard_normal((n, n)),
        rng.standard_normal((n, m)),
        rng.standard_normal((n, p)),
    ]
    found = [
        sos.SecondOrderSystem(
            *(x * (1 + spread * rng.uniform(-1, 1, x.shape)) for x in parts)
        )
        for _ in range(vertices)
    ]
    return found[0] if vertices == 1 else sos.Polytope(found)


def falling_plant(seed, count=1):
    """A plant that falls over, or a polytope, of one or two degrees of freedom."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 3))
    m = int(rng.integers(1, n + 1))

    def spd(low):
        root = rng.standard_normal((n, n))
        return low * np.eye(n) + 0.3 * root @ root.T

    M, D, S = spd(1.0), 0.1 * spd(1.0), -spd(0.5)  # it falls over
    B = np.eye(n)[:, :m] + 0.3 * rng.standard_normal((n, m))
    F = rng.standard_normal((n, 1))
    vertices = [
        sos.SecondOrderSystem(M * (1 + 0.1 * k), D, S * (1 + 0.05 * k), B, F)
        for k in range(count)
    ]
    return vertices[0] if count == 1 else sos.Polytope(vertices)


def random_request(seed):
    """Keyword arguments of `design_pid`, of every kind."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 4))
    m = int(rng.integers(1, n + 1))
    a = int(rng.integers(0, m + 1))
    plant = random_plant(
        rng, n, m, 1, int(rng.integers(1, 4)), rng.choice([0, 0.05, 0.2])
    )
    asked = {"plant": plant}
    if a:
        asked["U"] = rng.standard_normal((a, n))
    region = {}
    if rng.random() < 0.6:
        region["sigma"] = 10 ** rng.uniform(-1, 0.3)
    if rng.random() < 0.4:
        region["theta"] = rng.uniform(0.2, np.pi / 2)
    if rng.random() < 0.4:
        region["rho"] = 10 ** rng.uniform(0.4, 1.5)
    if region:
        asked["region"] = sos.PoleRegion(**region)
    if rng.random() < 0.5:
        asked["gamma"] = 10 ** rng.uniform(-1.5, 1)
    if rng.random() < 0.5:
        asked["saturation"] = sos.Saturation(
            10 ** rng.uniform(0, 3), 0.3 * rng.standard_normal(2 * n + a)
        )
    return asked


def random_cost_request(seed):
    """A `random_request` that bounds a cost, too; every fourth holds mu."""
    asked, rng = random_request(seed), np.random.default_rng([seed, 1])
    plant, N = asked["plant"], 2 * asked["plant"].n + len(asked.get("U", ()))
    root = rng.standard_normal((N, int(rng.integers(1, N + 1))))
    full = np.round(root @ root.T, 3) + 0.01 * np.eye(N)
    Q = (
        full
        if rng.random() < 0.5
        else np.diag(np.round(10 ** rng.uniform(-2, 1, N), 3))
    )
    root = rng.standard_normal((plant.m, plant.m))
    R = np.round(root @ root.T, 3) + 0.1 * np.eye(plant.m)
    noise, bound = rng.choice(["states", "F"]), 10 ** rng.uniform(0, 3.5)
    asked["requirements"] = [sos.QuadraticCost(Q, R, str(noise), bound)]
    if "gamma" in asked and seed % 4 == 0:
        asked["gamma"] = sos.HInfinity(asked["gamma"], mu=10 ** rng.uniform(-1, 1))
    return asked


def close(K, wanted, tolerance=1e-6):
    """Whether the entries differ by so much of the largest one."""
    return np.abs(K - wanted).max() <= tolerance * np.abs(wanted).max()


def by_hand(plant):
    """A and B of x' = A x + B u with x = [z; z'], by numpy alone."""
    n = plant.n
    lower = np.linalg.solve(plant.M, np.hstack([-plant.S, -plant.D, plant.B]))
    A = np.vstack([np.eye(n, 2 * n, n), lower[:, : 2 * n]])
    return A, np.vstack([np.zeros_like(plant.B), lower[:, 2 * n :]])


def norm_on_a_grid(A, B, C, D=0.0):
    """The largest singular value of C (jw - A)^-1 B + D, near its top."""
    poles = np.linalg.eigvals(A)
    grid = np.geomspace(abs(poles).min() / 100, abs(poles).max() * 100, 300)
    grid, most = np.unique([0.0, *grid, *abs(poles.imag)]), 0.0
    for _ in range(3):  # again, from neighbour to neighbour of the highest
        pencils = 1j * grid[:, None, None] * np.eye(len(A)) - A
        values = C @ np.linalg.solve(pencils, B + 0j) + D
        sizes = np.linalg.norm(values, 2, axis=(1, 2))
        top, most = int(np.argmax(sizes)), max(most, sizes.max())
        grid = np.linspace(grid[max(top - 1, 0)], grid[min(top + 1, len(grid) - 1)], 60)
    return most
