"""What multipliers exclude for every controller: against Riccati equations."""

from fractions import Fraction
from itertools import product

import numpy as np
import pytest

import sosbook as sos
from sosbook.exact.rational import exact
from sosbook.synthesis.structured.any_order import (
    AnyOrder,
    best_excluded,
    unseen_motions,
)
from tests.cases import campaign, examples, later, seeds

from .test_structured_search import best_of_any_order


def plant(seed, time=1.0):
    """A plant of three states, one input, a force and noise; time in other units."""
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(3, 3)) / time
    B, b = (rng.normal(size=(3, 1)) / time for _ in range(2))
    c = rng.normal(size=(1, 3))
    parts = (A, B, np.hstack([b, 0 * b]), np.vstack([c, 0 * c]))
    A, B, Bw, C = (x.round(6) for x in parts)
    C_y = rng.normal(size=(1, 3)).round(2)
    return sos.DescriptorSystem(np.eye(3), A, B, Bw, C, [[0], [0.3]]), C_y


def bound(known, law, reached):
    """The largest norm that is excluded below ``reached``, and its refusal."""
    zero = np.zeros(law.structure(known).shape)
    request = sos.analyse_pid(known, zero, law=law, gamma=1.0).request
    return best_excluded(request, request.owner("gamma"), reached)


@pytest.mark.parametrize(
    "seed, time",
    [
        *((0, 0.3e-3), (1, 9.81)),
        *later((0, 9.81), (1, 0.3e-3), (0, 1.0), (1, 1.0)),
        *later(*product((2, 3), (0.3e-3, 9.81, 1.0))),
    ],
)
def test_with_noise_and_weight_the_best_of_all_is_met(seed, time):
    """Unstable ones among them, by the two Riccati equations."""
    known, C_y = plant(seed, time)
    (d,) = known.vertices
    best = best_of_any_order(d, C_y, 0.3, 0.5)
    law = sos.DynamicLaw(1, C_y, noise=[[0, 0.5]])
    gamma, proof = bound(known, law, 1.5 * best)
    assert 0.98 * best < gamma < best and proof.verify()
    more = proof.data["requirement"] | {"gamma": str(1.001 * best)}
    assert not AnyOrder.of(proof.data | {"requirement": more}).proven


@pytest.mark.campaign
@pytest.mark.parametrize("seed", seeds(5))
def test_the_search_ends_near_the_best_of_all(seed):
    known, C_y = plant(seed)
    law = sos.DynamicLaw(3, C_y, noise=[[0, 0.5]])
    d = sos.design_pid(
        known, law=law, minimize="gamma", search=sos.Search(starts=4, backoff=0.001)
    )
    row = d.bounds()["gamma"]
    assert row.excluded < row.proven < 1.06 * row.excluded


def test_a_controller_of_lower_order_begins_with_a_part_of_the_best():
    """Two carts on a spring, seen at the load: random starts ended at 12."""
    A = np.vstack([np.eye(2, 4, 2), [[-1, 1, -0.1, 0.1], [1, -1, 0.1, -0.1]]])
    w, z = np.outer(np.eye(4)[3], [1, 0]), np.outer([1, 0], np.eye(4)[1])
    carts = sos.DescriptorSystem(np.eye(4), A, np.eye(4, 1, -2), w, z, [[0], [0.5]])
    law = sos.DynamicLaw(2, np.eye(4)[[1]], noise=[[0, 0.2]])
    d = sos.design_pid(carts, law=law, gamma=8, search=sos.Search(starts=1))
    assert d.certify().proven


@pytest.mark.campaign  # the strange plants below are asked the same
@pytest.mark.parametrize("seed", [0, 1, 2, 3, 4, 8])
def test_without_noise_no_more_is_excluded_than_little_noise_allows(seed):
    """Less and less noise comes down to it; but multipliers of 2, 8 aren't rational."""
    known, C_y = plant(seed)
    little = best_of_any_order(known.vertices[0], C_y, 0.3, 1e-3)
    gamma, proof = bound(known, sos.DynamicLaw(1, C_y), 1.5 * little)
    near = 0.2 if seed in (2, 8) else 0.98
    assert near * little < gamma < little and proof.verify()


def strange(kind, seed):
    """A plant of some kind, seen by one sensor without noise."""
    rng = np.random.default_rng(seed)
    A, (B, b) = rng.normal(size=(3, 3)).round(4), rng.normal(size=(2, 3, 1)).round(4)
    c, C_y = rng.normal(size=(2, 1, 3)).round(2)
    if kind == "undamped":
        A = A - A.T
    if kind == "a mode alone":
        A[0] = [-0.3, 0, 0]
    B, Bw, C = (
        b if kind == "matched" else B,
        np.hstack([b, 0 * b]),
        np.vstack([c, 0 * c]),
    )
    return sos.DescriptorSystem(np.eye(3), A, B, Bw, C, [[0], [0.3]]), C_y


@pytest.mark.parametrize("kind", ["matched", *campaign(["undamped", "a mode alone"])])
def test_strange_plants_are_excluded_no_more_than_little_noise_allows(kind):
    """Rational multipliers aren't found for each of them."""
    found = 0
    for seed in range(examples(2, 3)):
        known, C_y = strange(kind, seed)
        little = best_of_any_order(known.vertices[0], C_y, 0.3, 1e-3)
        gamma, proof = bound(known, sos.DynamicLaw(1, C_y), 1.5 * little)
        if proof is not None:
            assert proof.verify() and gamma < little, seed
            found += gamma > 0.9 * little
    assert found >= 2


@pytest.mark.campaign
@pytest.mark.parametrize("kind", ["any", "undamped", "a mode alone", "matched"])
def test_no_controller_that_is_built_does_what_is_excluded(kind):
    """Its norm is a bisection's; rational multipliers aren't found for each plant."""
    found = 0
    for seed in range(8):
        known, C_y = strange(kind, seed)
        asked = dict(minimize="gamma", search=sos.Search(starts=2, backoff=0.001))
        d = sos.design_pid(known, law=sos.DynamicLaw(3, C_y), **asked)
        if d.status != "feasible":
            continue
        gamma, proof = bound(known, sos.DynamicLaw(1, C_y), 2 * d.hinf())
        if proof is not None:
            assert proof.verify() and gamma < d.hinf(), seed
            found += 1
    assert found >= 2


@pytest.fixture(scope="module")
def excluded():
    """A plant, and the proof of what no controller keeps of it."""
    known, C_y = plant(0)
    _, proof = bound(known, sos.DynamicLaw(1, C_y, noise=[[0, 0.5]]), 10.0)
    return known, proof


@pytest.mark.parametrize("kind", ["nothing moves", "twice the same", "another rate"])
def test_a_file_whose_motions_are_none_proves_nothing(kind, excluded):
    """A push of zero would exclude every controller, of every plant."""
    known, proof = excluded
    data = proof.data
    motions = dict(data["sides"]["Y"])
    if kind == "twice the same":
        motions["V"] = [[*row, row[0]] for row in motions["V"]]
        for name in ("here", "rate"):
            motions[name] = [*motions[name], ["0"] * len(motions["push"][0])]
    elif kind == "another rate":
        (first, *row), *rows = motions["rate"]
        motions["rate"] = [[str(Fraction(first) + 1), *row], *rows]
    else:
        motions = dict(V=[[]] * 3, here=[], rate=[], push=[["0"], ["0"]])
    size = len(motions["push"][0]) + len(known.vertices[0].C)
    Z = [["1" if i == j == 0 else "0" for j in range(size)] for i in range(size)]
    sides = {"Y": motions}
    false = AnyOrder.of(data | {"sides": sides, "multipliers": [["not seen", Z]]})
    said = {"nothing moves": "different", "twice the same": "independent",
            "another rate": "rate"}[kind]  # fmt: skip
    assert not false.proven and said in str(false)
    assert proof.proven and "of any order with these sensors" in proof.claims[0]


def test_free_masses_have_a_bound():
    """Undamped, so multipliers of both sides together aren't rational."""
    A = np.array([[0, 1, 0, 0], [-1, 0, 1, 0], [0, 0, 0, 1], [1, 0, -1, 0]])
    one = np.eye(4)
    C, D = np.vstack([one, np.zeros((1, 4))]), [[0], [0], [0], [0], [1]]
    known = sos.DescriptorSystem(one, A, one[:, 1:2], one[:, 3:], C, D)
    gamma, proof = bound(known, sos.DynamicLaw(1, one[2:3], noise=[[1]]), 5.0)
    assert 2.1 < gamma < 5**0.5 and proof.verify()  # a law of order 4 has 2.281


def test_motions_that_sensors_do_not_see_are_the_largest_subspace():
    """Seen at the pushed end, a chain's other masses move as if that stood still."""
    S = 2 * np.eye(3) - np.eye(3, k=1) - np.eye(3, k=-1)
    A = exact(np.block([[np.zeros((3, 3)), np.eye(3)], [-S, -0.1 * np.eye(3)]]))
    B = exact(np.eye(6)[:, 5:])
    none = exact(np.zeros((1, 1)))
    far, near = (exact(np.eye(6)[k : k + 1]) for k in (0, 2))
    V, here, rate, push = unseen_motions(A, B, far, none)
    assert V.shape == (6, 0) and push.shape == (1, 0)
    V, here, rate, push = unseen_motions(A, B, near, none)
    assert V.shape == (6, 4) and here.shape == rate.shape == (4, 4)
    assert (near @ V == 0).all() and (A @ V @ here + B @ push == V @ rate).all()
    free = np.linalg.eigvals(rate.astype(float) @ np.linalg.inv(here.astype(float)))
    two = np.block([[np.zeros((2, 2)), np.eye(2)], [-S[:2, :2], -0.1 * np.eye(2)]])
    assert np.allclose(np.poly(free), np.poly(two))


def test_what_is_sought_has_no_bound_that_is_refused():
    """Three integrators, too many for order one: without s^2 the norm is 1."""
    one = np.eye(3)
    chain = sos.DescriptorSystem(one, np.eye(3, k=1), one[:, 2:], one, one)
    for asked in (dict(minimize="gamma"), dict(maximize="sigma")):
        design = sos.design_pid(
            chain, law=sos.DynamicLaw(1, one[:1]), **asked, search=sos.Search(starts=2)
        )
        assert design.status == "undecided", design.reason
        design = sos.design_pid(chain, law=sos.DynamicLaw(1, one[1:2]), **asked)
        assert design.status == "infeasible" and design.infeasibility.verify()
        assert "these sensors don't see it. It violates stability" in design.reason
