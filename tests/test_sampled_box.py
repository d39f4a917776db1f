"""Plants whose halves are proven, by balls, with the Lyapunov matrices of the whole."""

import copy
from functools import cache

import numpy as np
import pytest
from scipy.linalg import solve_discrete_are

import sosbook as sos
from sosbook.sampled import SampledProof, c2d, sampled_loop
from sosbook.sampled import cover as search
from sosbook.sampled.proof import by_balls
from tests.cases import campaign, later, seeds

RANGES = dict(c=(0.952, 1.048), a=(0.608, 0.672), f=(2.76, 3.24), e=(0.92, 1.08))
T = 0.02


def pendulum(c, a, f, e, unit=1.0):
    """A body on two wheels: c and a are on the diagonal, f brakes, e drives."""
    return sos.SecondOrderSystem(
        unit * np.array([[c, 0.6], [0.6, a]]),
        unit * f * np.array([[1, -1], [-1, 1]]),
        unit * np.array([[-10.0, 0], [0, 0]]),
        unit * e * np.array([[-1.0], [1]]),
    )


MIDDLE = {name: sum(ends) / 2 for name, ends in RANGES.items()}


def gain(delay=0.0):
    """Least squares for the plant in the middle, with u before where it is late."""
    (d,) = c2d(pendulum(**MIDDLE), T, delay)
    Q = np.eye(len(d.A)) * 1.0
    P = solve_discrete_are(d.A, d.B, Q, [[0.1]])
    return -np.linalg.solve(0.1 + d.B.T @ P @ d.B, d.B.T @ P @ d.A).round(6)


def box(unit=1.0):
    return sos.Uncertain(lambda c, a, f, e: pendulum(c, a, f, e, unit), **RANGES)


def worst(K, delay, rng):
    """The largest radius of the loops of some plants of a box and its corners."""
    low, high = np.transpose(list(RANGES.values()))
    shares = [*rng.integers(0, 2, (100, 4)), *rng.random((100, 4))]
    plants = [pendulum(*(low + x * (high - low))) for x in shares]
    loops = [sampled_loop(p, K, T, delay)[0] for p in plants]
    return abs(np.linalg.eigvals(loops)).max()


@pytest.fixture
def searches(monkeypatch):
    """How often Lyapunov matrices were searched: a list as long."""
    found, seen = search._multipliers, []
    monkeypatch.setattr(search, "_multipliers", lambda *x: seen.append(1) or found(*x))
    return seen


def forged(proof, change):
    data = copy.deepcopy(proof.data)
    change(data["cells"])
    try:
        return SampledProof.of(data).proven
    except ValueError:
        return False


def leaves(node):
    return sum(map(leaves, node["halves"])) if "halves" in node else 1


@cache
def late_box():
    """The proof of the box in another unit, a millisecond late."""
    return by_balls(box(9.81), gain(0.001), T, 0.001)


@pytest.mark.parametrize("delay, unit", [(0.001, 9.81), *later((0.0, 0.3))])
def test_one_search_for_lyapunov_matrices_proves_a_box(delay, unit, searches):
    """Each of its halves asked for a search of its own, six times as slow."""
    K = gain(delay)
    proof = late_box() if delay else by_balls(box(unit), K, T, delay)
    tree = proof.data["cells"]
    assert proof.proven, proof.failed
    assert len(searches) == 1 and "P" in tree and leaves(tree) > 1
    assert worst(K, delay, np.random.default_rng(0)) < 1
    assert len(proof.cells) == leaves(tree)
    assert SampledProof(proof.text).verify()


def test_forged_parts_prove_nothing():
    proof = late_box()
    assert forged(proof, lambda tree: None)
    for change in (
        lambda tree: tree.pop("P"),
        lambda tree: tree.pop("L"),
        lambda tree: tree["P"][3][0].__setitem__(0, "-1"),
        lambda tree: tree["halves"][0].update(P=tree["P"]),
        lambda tree: tree.update(times={}),
        lambda tree: tree["halves"].pop(),
        lambda tree: [tree.pop(x) for x in ("halve", "halves")],
    ):
        assert not forged(proof, change)


@pytest.mark.parametrize("seed", seeds(3))
def test_no_box_with_an_unstable_loop_is_proven(seed):
    """Gains by chance, some too weak for some of the plants."""
    rng = np.random.default_rng(seed)
    K = (gain() * rng.uniform(0.25, 1.3, (1, 4))).round(5)
    radius = worst(K, 0.0, rng)
    proof = by_balls(box(), K, T, cells=20)
    assert not (proof.proven and radius >= 1), radius


CORNERS = np.array([[0.94, 1.1], [1.06, 0.9], [1.06, 1.1]])  # c and e


def triangle(unit=1.0):
    """Three plants far apart, of which all mixtures are plants, too."""
    several = [MIDDLE | dict(c=c, e=e) for c, e in CORNERS]
    return sos.Polytope([pendulum(**x, unit=unit) for x in several])


CLOCK = (0.018, 0.022), (0.0, 0.002)


@pytest.mark.parametrize("unit", [0.3, *campaign([9.81, 1])])
def test_one_search_proves_a_simplex_whose_clock_varies(unit, searches):
    """It asked for one in each of its cells, and in each it asked several times."""
    proof = by_balls(triangle(unit), gain(), *CLOCK)
    tree = proof.data["cells"]
    assert proof.proven and "P" in tree and leaves(tree) > 1
    assert len(searches) == 1 and SampledProof(proof.text).verify()
    for change in (
        lambda tree: tree.update(halve=[0, 0]),
        lambda tree: tree.update(halve=[1, 3]),
        lambda tree: tree.pop("P"),
    ):
        assert not forged(proof, change)


@pytest.mark.parametrize("seed", [1, 2, *campaign([0, 3])])
def test_no_pattern_of_clocks_grows_where_a_simplex_is_proven(seed):
    """Gains by chance; plants by chance and patterns of up to six ticks, repeated."""
    rng, worst = np.random.default_rng(seed), 0.0
    K = (gain() * rng.uniform(0.4, 1.2, (1, 4))).round(5)
    proof = by_balls(triangle(), K, *CLOCK, cells=6)
    for k in range(100):
        c, e = (rng.dirichlet([0.3] * 3) if k > 2 else np.eye(3)[k]) @ CORNERS
        plant, count = pendulum(**MIDDLE | dict(c=c, e=e)), rng.integers(1, 7)
        word = np.eye(5)
        for _ in range(count):
            T, late = (rng.choice(x) if k % 2 else rng.uniform(*x) for x in CLOCK)
            word = sampled_loop(plant, K, T, max(late, 1e-9))[0] @ word
        worst = max(worst, abs(np.linalg.eigvals(word)).max() ** (1 / count))
    assert not (proof.proven and worst >= 1), worst


def test_multipliers_are_found_for_slow_loops():
    """The identity is one for them; from elsewhere none was found."""
    rng = np.random.default_rng(0)
    turns = [np.linalg.qr(rng.standard_normal((14, 14)))[0] for _ in range(3)]
    loops = [[(1 - 1e-4) * turn for turn in turns]]
    P, G = search._multipliers(loops, [1e-9 * np.eye(14)], 1.0)
    assert P is not None and len(G) == 1


def test_few_cells_say_how_many_and_go_on_in_time():
    """A mass and a spring in ranges: two corners of four are far from the others."""
    both = sos.Polytope(
        sos.SecondOrderSystem([[m]], [[0.3]], [[k]], [[1]])
        for m in (1, 2.5)
        for k in (0, 3)
    )
    asked = dict(plant=both, K=[[-1, -1.5]], T=0.3, delay=0.3, cells=1)
    few = by_balls(**asked)
    assert not few.proven and "undecided after 1 cell; cells=4 goes on" in few.failed[0]
    assert by_balls(**asked | {"cells": 16}).proven
    assert by_balls(**asked, time_limit=200).proven
    late = by_balls(**asked, time_limit=1e-3)
    assert "stopped after 0.001 s; raise time_limit" in late.failed[0]
