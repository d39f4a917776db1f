"""Vertices that repeat others or are means of others: found in rationals alone."""

import numpy as np
import pytest
from flint import fmpq

import sosbook as sos
from sosbook.exact.rational import exact
from sosbook.lmi import LMIProblem
from sosbook.plants.bernstein import means
from sosbook.synthesis import known_gain
from sosbook.synthesis.ranges import family
from tests.cases import seeds
from tests.test_bounds import table

K = [[-8.56, 6.008, -0.369, -0.22]]


def again(points, found):
    """Each point that was found is the mean that its weights say of what stays."""
    for k, weights in found.items():
        assert not weights.keys() & found.keys()
        assert min(weights.values()) >= 0 and sum(weights.values()) == 1
        mean = sum(w * points[i] for i, w in weights.items())
        assert (mean == points[k]).all(), k


def test_corners_stay():
    corners = [[x, y, x * y] for x in (-0.3, 9.81) for y in (0, 1e-7)]
    assert means(exact(np.array(corners))) == {}
    round_ = np.random.default_rng(1).normal(size=(30, 3))
    round_ /= np.linalg.norm(round_, axis=1)[:, None]
    assert means(exact(round_)) == {}


def test_what_is_a_mean_but_for_the_last_bit_stays():
    third = np.nextafter(0.3 / 2, 1)
    line = exact(np.array([[0.0, 0.0], [0.3, 0.3], [0.15, third]]))
    assert means(line) == {}
    line[2, 1] = line[2, 0]
    assert means(line) == {2: {0: fmpq(1, 2), 1: fmpq(1, 2)}}


@pytest.mark.parametrize("seed", seeds(4))
def test_repeated_points_and_means_of_means_go(seed):
    rng = np.random.default_rng(seed)
    points = exact(rng.integers(-9, 9, (5, 3)) / 7)
    mean = (points[0] + points[1]) / 2
    more = [mean, (mean + points[2]) / 3 + mean / 3, points[3], mean]
    points = np.vstack([points, *(x[None] for x in more)])
    order = rng.permutation(len(points))
    found = means(points[order])
    again(points[order], found)
    assert len(found) >= 4


@pytest.mark.parametrize(
    "ranges, dropped",
    [
        ({"m": (0, 2), "r": (0.05, 0.1)}, 4),
        ({"m": (-0.3, 2), "r": (0.05, 0.1)}, 4),  # it meets zero inside
        ({"m": (1, 2), "r": (0.05, 0.1)}, 4),  # J alone varies: two ends
    ],
)
def test_one_product_of_parameters_has_two_ends(ranges, dropped):
    plants = sos.Uncertain(table, **ranges)
    loop = sos.analyse_pid(plants, K, region=sos.PoleRegion(sigma=3))
    cell = family(loop.request).whole
    rows = [np.concatenate([x.ravel() for x in y.matrices]) for y in cell.loops]
    again(np.array(rows), cell.means)
    assert len(cell.means) == dropped


def test_the_proof_has_every_vertex_and_the_checker_agrees(monkeypatch):
    """The LMIs are solved at two vertices; the file proves the blocks at all six."""
    sizes, find = [], LMIProblem.find

    def count(problem, **more):
        sizes.append(len(getattr(problem, "loops", ())))
        return find(problem, **more)

    monkeypatch.setattr(known_gain.KnownLMIs, "find", count)
    plants = sos.Uncertain(table, m=(0, 2), r=(0.05, 0.1))
    region = sos.PoleRegion(sigma=5)
    loop = sos.analyse_pid(plants, K, region=region, coupling="multipliers")
    proof = loop.certify()
    assert proof.proven and max(sizes) == 2
    first, second = (proof.data["unknowns"][f"P.1.1.{k}"] for k in (1, 2))
    assert first == second and '"P.1.1.6"' in proof.text
    B = np.array([[0], [0], [100], [0]])
    for J in np.linspace(0.01, 0.03, 9):  # by the motor's and the load's own equations
        A = np.array([[0, 0, 1, 0], [0, 0, 0, 1], [-1e3, 1e3, -3, 1], [0, 0, 0, 0]])
        A[3] = np.array([10, -10, 0.01, -0.01]) / J
        assert np.linalg.eigvals(A + B @ np.array(K)).real.max() < -5
