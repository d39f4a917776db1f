"""The curve that Newton's steps follow: its definition, and what it is for."""

import numpy as np
import pytest

import sosbook as sos
from benchmarks.catalogue import case
from sosbook.solver.barrier import Barrier
from sosbook.solver.curve import MOST_TERMS, Curve
from sosbook.solver.loop import centre
from sosbook.solver.stacks import gram
from sosbook.synthesis.feasibility import search
from sosbook.synthesis.request import Request
from tests.cases import campaign, crossed


def gradient(newton, x, radius=None):
    """Of -sum log det of all blocks, and of the ball's -log(radius^2 - x.x)."""
    of_ball = 0 if radius is None else 2 * x / (radius**2 - x @ x)
    return of_ball - newton.adjoint([np.linalg.inv(g) for g in newton.at(x)])


def curve_at(newton, x, small=0.0, radius=None):
    roots = [np.linalg.inv(np.linalg.cholesky(g)) for g in newton.at(x)]
    solve = newton.solver(roots, x, radius)
    direction = -solve(gradient(newton, x, radius))
    change = newton.scaled(roots, direction)
    return Curve(newton, roots, x, direction, change, solve, small, radius)


CASES = [
    ("grounded chain", 2),
    ("grounded chain", 12),
    ("cantilever", 4),
    ("tree", 2),
    ("uncertain springs", 16),
    ("published", 5),
]


@pytest.mark.parametrize("at, times", crossed(CASES, [None, 1.02, 3.0]))
def test_the_gradient_shrinks_evenly(at, times):
    """At s it is 1 - s times that at the start, in a ball ``times`` the way."""
    first = search(case(*at).request)
    newton = first.problem.compiled.newton
    x = first.problem.text.packed(first.values)
    radius = None if times is None else times * np.linalg.norm(x)
    curve = curve_at(newton, x, radius=radius)
    assert len(curve.terms) == MOST_TERMS
    start, left = gradient(newton, x, radius), []
    for s in (0.02, 0.04):
        there = gradient(newton, curve(s / (1 - s * curve.rho)), radius)
        left.append(np.abs(there - (1 - s) * start).max() / np.abs(start).max())
    # twice the way leaves about 2^8 times as much, or what rounding leaves
    assert left[1] < 2e-7
    assert left[0] < left[1] / 50 or left[0] < 1e-11


def test_a_short_sum_ends_early():
    first = search(case("grounded chain", 4).request)
    newton = first.problem.compiled.newton
    x = centre(first.problem.compiled, first.problem.text.packed(first.values))
    near = x * (1 + 1e-3)
    assert len(curve_at(newton, near, small=0.1).terms) == 2
    assert len(curve_at(newton, near, small=1e-8).terms) > 2


def valley(seed, n):
    """A plant of random modes whose slow states make a long way for P."""
    rng = np.random.default_rng(seed)
    Q = np.linalg.qr(rng.normal(size=(n, n)))[0]
    rates = np.sort(rng.uniform(0.3, 4, n))
    L = np.eye(n) + 0.3 * np.tril(rng.normal(size=(n, n)), -1)
    turned = L @ Q
    B = rng.normal(size=(n, max(1, n // 2)))
    plant = sos.SecondOrderSystem(
        L @ L.T,
        turned @ np.diag(0.04 * rates) @ turned.T,
        turned @ np.diag(rates**2) @ turned.T,
        B,
        B[:, :1],
    )
    x0 = np.zeros(2 * n + plant.m)
    x0[:n] = 0.3 * rng.normal(size=n)
    slowest = -plant.poles().real.max()
    return plant, dict(
        U=B.T,
        region=sos.PoleRegion(sigma=2 * slowest),
        gamma=20.0,
        saturation=sos.Saturation(20 * rng.uniform(1, 5), x0),
    )


@pytest.mark.parametrize("n", [4, *campaign([2, 6])])
def test_long_valleys_take_few_steps(n):
    """With one correction of the direction it took 10 to 18, and multipliers."""
    for seed in range(6):
        plant, asked = valley(seed, n)
        first = search(Request(plant, **asked))
        blocks, steps = first.problem.compiled, []
        x = first.problem.text.packed(first.values)
        found = centre(
            blocks, x, steps.append, directions=first.problem.free_directions
        )
        assert len(steps) <= 13
        newton = blocks.newton
        roots = [np.linalg.inv(np.linalg.cholesky(g)) for g in newton.at(found)]
        slope = newton.adjoint(gram(roots))
        assert abs(slope @ newton.solver(roots, found)(slope)) < 1e-16


@pytest.mark.parametrize("n", [4, *campaign([2, 6])])
def test_so_do_they_within_a_ball(n):
    """In straight lines it took 8 to 17."""
    for seed in range(6):
        plant, asked = valley(seed, n)
        first = search(Request(plant, **asked))
        newton = first.problem.compiled.newton
        x = first.problem.text.packed(first.values)
        barrier = Barrier(newton, 10 * np.linalg.norm(x))
        cost, decrements = np.zeros(len(x)), [1.0]
        while decrements[-1] > 1e-4:
            x, decrement = barrier.step(x, cost)
            decrements.append(decrement)
        assert len(decrements) <= 9
