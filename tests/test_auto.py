"""What a design chooses by itself: one P for all plants, or one for each vertex."""

import re
from time import monotonic

import numpy as np
import pytest

import sosbook as sos
from sosbook.book.counterexamples import actuated
from sosbook.exact.checker.families import given_vertices
from sosbook.plants import descriptors
from sosbook.runtime.time_limit import OutOfTime
from sosbook.synthesis import known_gain, slack
from sosbook.synthesis.proofs import DesignRefusal
from tests.cases import by_hand, campaign, examples

ROOMY = sos.PoleRegion(rho=10)


def carts(*masses):
    return sos.Polytope([sos.SecondOrderSystem(m, 0.1, 1, 1) for m in masses])


def test_one_p_where_there_is_one():
    asked = dict(region=sos.PoleRegion(sigma=0.5))
    auto, pairs = (sos.design_pid(carts(0.5, 2), **asked, **how) for how in ({}, PAIRS))
    assert auto.request.coupling.word == "pairs" and auto.reason == pairs.reason
    assert (auto.K == pairs.K).all()


PAIRS = {"coupling": "pairs"}


def test_a_p_for_each_vertex_where_there_is_none_for_all():
    plants = actuated()
    refused = sos.design_pid(plants, region=ROOMY, **PAIRS)
    assert refused.status == "infeasible" and refused.infeasibility.proven
    assert "no common P in this form of the rows" in refused.reason
    design = sos.design_pid(plants, region=ROOMY)
    assert design.request.coupling.own_P and 'coupling="slack"' in design.reason
    proof = design.certify()
    assert proof.proven
    for plant in plants.sample(100, 1):
        (d,) = descriptors(plant)
        poles = np.linalg.eigvals(np.linalg.solve(d.E, d.A + d.Bu @ proof.K))
        assert poles.real.max() < 0 and np.abs(poles).max() < 10


@pytest.mark.parametrize("unit", [0.3, 9.81])
def test_a_gain_with_a_common_p_has_no_plant_searched(monkeypatch, unit):
    def swinging(k, c):  # lightly damped, pushed by what leans on it
        M, S = np.diag([unit, 1]), [[k + 1, c - 1], [-c - 1, 2]]
        return sos.SecondOrderSystem(M, 1e-3 * np.eye(2), S, [[1], [0]])

    searched = []
    monkeypatch.setattr(known_gain, "_search", lambda *_: searched.append(1) or [])
    K, slow = np.array([[-0.1, 0.05, -2.0, 0.1]]), sos.PoleRegion(sigma=1e-3)
    for plants in (
        sos.Uncertain(swinging, k=(1, 1.05), c=(0.1, 0.12)),
        sos.Polytope([swinging(1, 0.1), swinging(1.1, 0.1), swinging(1, 0.13)]),
    ):
        found = sos.analyse_pid(plants, K, region=slow)
        assert found.request.coupling.word == "pairs" and not searched
        proof = found.certify()
        assert proof.proven and (proof.K == K).all()
        for plant in plants.sample(20, 1):
            (d,) = descriptors(plant)
            poles = np.linalg.eigvals(np.linalg.solve(d.E, d.A + d.Bu @ K))
            assert poles.real.max() < -1e-3


def test_a_refusal_says_that_both_were_tried():
    asked = dict(region=sos.PoleRegion(sigma=3, rho=3.3))
    design = sos.design_pid(carts(0.01, 1, 100), **asked)
    one = sos.design_pid(carts(0.01, 1, 100), **asked, **PAIRS)
    assert design.status == one.status == "infeasible"
    assert design.request.coupling.word == "pairs"
    assert "no common P" in one.reason and "for each vertex" in design.reason


def test_what_one_p_has_shown_stays_where_the_time_ends(monkeypatch):
    def late(request, *how, **more):
        if request.coupling.word == "slack":
            raise OutOfTime(end=monotonic())
        return designed(request, *how, **more)

    designed = slack.designed
    monkeypatch.setattr(slack, "designed", late)
    design = sos.design_pid(
        carts(0.01, 1, 100), region=sos.PoleRegion(sigma=3, rho=3.3)
    )
    assert design.status == "infeasible" and design.infeasibility.proven
    assert "s, half of the time that was left: raise time_limit" in design.reason


@pytest.mark.parametrize("bound", [0.1, 1e-3])
def test_what_a_vertex_alone_excludes_needs_no_second_look(bound):
    limit = sos.Saturation(bound, [1, 0])
    design = sos.design_pid(
        carts(0.5, 2), region=sos.PoleRegion(sigma=0.5), saturation=limit
    )
    assert design.status == "infeasible" and "each vertex" not in design.reason


@pytest.mark.parametrize("how", [{}, PAIRS])
def test_a_vertex_that_refuses_alone_refuses_its_family(monkeypatch, how):
    mended, repaired = DesignRefusal.mended, []
    monkeypatch.setattr(
        DesignRefusal, "mended", lambda *x: repaired.append(1) or mended(*x)
    )

    def follower(c):  # a force that follows the column makes S unsymmetric
        S = [[3, c - 1.5, 0], [-1.5 - c, 3, c - 1.5], [0, -1.5 - c, 1.5]]
        M, w = np.diag([1, 1.2, 0.8]), [[0], [0], [1]]
        return sos.SecondOrderSystem(M, 0.05 * np.eye(3), S, [[1], [0], [0]], w)

    asked = dict(region=sos.PoleRegion(sigma=0.05, rho=50), gamma=0.909)
    plants = sos.Polytope([follower(c) for c in (0.45, 0.4)])
    found = sos.design_pid(plants, **asked, **how)
    (k,) = re.findall(r"At vertex (\d) alone: Exact multipliers", found.reason)
    proof, vertex = found.infeasibility, plants.vertices[int(k) - 1]
    (only,) = given_vertices(proof.data["plant"])
    alone = sos.design_pid(vertex, **asked).infeasibility
    assert proof.proven and only == given_vertices(alone.data["plant"])[0]
    assert len(repaired) == 2 and found.request.plant is plants  # one for each design
    assert DesignRefusal(proof.text).proven


@pytest.mark.parametrize("size", [1e-3, *campaign([1e3])])
def test_what_is_minimised_excludes_no_vertex_by_the_number_that_stands_in(
    monkeypatch, size
):
    def seen(request, *how, **more):
        words.add(request.coupling.word)
        return designed(request, *how, **more)

    designed, words = slack.designed, set()
    monkeypatch.setattr(slack, "designed", seen)
    plants = sos.Uncertain(
        lambda a: sos.SecondOrderSystem(a**2, 0.1 * a, 1, 1), a=(0.5, 2)
    )
    limit = sos.Saturation(None, [size, 0])
    design = sos.design_pid(
        plants, region=sos.PoleRegion(0.1), saturation=limit, minimize="u_max"
    )
    assert "slack" in words
    cut = len(design.request.vertices) > 3  # whose P are those of the uncut family
    assert cut and "The bound is lower" in design.reason


def test_a_least_bound_is_that_of_the_pairs():
    limit = sos.Saturation(None, [1, 0])
    least = [
        sos.design_pid(
            carts(0.5, 2),
            region=sos.PoleRegion(sigma=0.3),
            saturation=limit,
            minimize="u_max",
            **how,
        ).request.saturation.u_max
        for how in ({}, PAIRS)
    ]
    assert least[0] == least[1]


def test_a_start_of_another_coupling_is_passed_over():
    asked = dict(region=sos.PoleRegion(sigma=0.3))
    slack = sos.design_pid(carts(0.5, 2), **asked, coupling="slack")
    plain = sos.design_pid(carts(0.5, 2), **asked)
    again = sos.design_pid(carts(0.5, 2), **asked, search=sos.Search(start=slack))
    assert np.allclose(again.K, plain.K)
    with pytest.raises(ValueError, match="coupling"):
        sos.design_pid(carts(0.5, 2), **asked, search=sos.Search(start=slack), **PAIRS)


@pytest.mark.parametrize("unit", [9.81, *campaign([1.0, 0.3])])
@pytest.mark.parametrize("held, words", [(2.0, "K = 0"), (-1.0, "the mean plant")])
def test_a_simple_gain_is_tried_before_a_design_is_undecided(
    monkeypatch, held, words, unit
):
    """No input reaches the first mass, whose spring is 1 to 9 times as stiff with
    little damping; the second falls over where its spring pushes. No slack scalar has
    a design, and the gate tries two.
    """
    monkeypatch.setattr(slack, "STEPS", slack.STEPS[: examples(2, 9)])
    carts = [
        sos.SecondOrderSystem(
            unit * np.eye(2),
            unit * np.diag([0.1, 0.3]),
            unit * np.diag([k, held]),
            [[0], [unit]],
        )
        for k in (1.0, 9.0)
    ]
    design = sos.design_pid(sos.Polytope(carts))
    assert design.status == "feasible" and words in design.reason
    assert design.request.coupling.word == "multipliers"
    proof = design.certify()
    assert proof.proven and "every constant plant" in proof.claims[0]
    for cart in (*carts, sos.Polytope(carts).mean):
        A, B = by_hand(cart)
        assert np.linalg.eigvals(A + B @ proof.K).real.max() < 0
    asked = sos.design_pid(sos.Polytope(carts), coupling="pairs")
    assert asked.status != "feasible"
