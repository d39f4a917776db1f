"""coupling="slack" promises less data, never less truth: by hand, cvxpy, hypothesis."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import event, given, settings
from hypothesis import strategies as st

import sosbook as sos
from sosbook.book import counterexamples, thesis
from sosbook.exact.checker import CHECKER
from sosbook.studies import maps
from sosbook.studies.polytopes import scale_polytope, verify_on_samples
from sosbook.synthesis import slack as slack_search
from sosbook.synthesis.request import Request
from sosbook.synthesis.scaling import Frame
from tests import clarabel
from tests.cases import (
    campaign,
    crossed,
    examples,
    later,
    random_plant,
    random_request,
    seeds,
)
from tests.processes import alone
from tests.random_plants import float_blocks, scaled

few, many = (
    settings(max_examples=n, derandomize=True, deadline=None)
    for n in (examples(2, 6), 60)
)
numbers = st.integers(0, 10**6)


def uncertain(seed):
    """A polytope whose mass is strongly uncertain, and requirements."""
    rng = np.random.default_rng(seed)
    kind = rng.integers(3)
    if kind == 0:
        plants = scale_polytope(
            counterexamples.random_pair(seed, 9), rng.uniform(0.3, 1)
        )
    elif kind == 1:
        plants = counterexamples.random_chain(
            seed, 2, rng.uniform(0.2, 0.95), bool(rng.integers(2))
        )
    else:
        plants = scale_polytope(counterexamples.actuated(), rng.uniform(0.3, 1.1))
    asked = {"plant": plants}
    if rng.random() < 0.5:
        asked["gamma"] = 10 ** rng.uniform(-0.5, 1)
    if rng.random() < 0.5:
        asked["saturation"] = sos.Saturation(10 ** rng.uniform(0, 2), [1, 0, 0, 0])
    if rng.random() < 0.6 or len(asked) == 1:
        asked["region"] = sos.PoleRegion(
            rng.choice([None, rng.uniform(0.05, 0.5)]),
            rng.uniform(0.4, 1.4),
            rng.uniform(5, 20),
        )
    return asked


def keeps_its_promises(design):
    event(f"{design.request.coupling.word}: {design.status}")
    if design.status != "feasible":
        assert design.K is None
        return
    proof = design.certify(12)
    assert proof.proven
    assert not any("vertices" in claim for claim in proof.claims)
    kept = verify_on_samples(design, 9)
    assert min(kept.values()) > 0, kept


def with_slack(seed):
    return uncertain(seed) | dict(coupling=("slack", (0.03, 0.1, 0.3)[seed % 3]))


def with_any_requirements(seed):
    asked = random_request(seed)
    if len(asked["plant"].vertices) == 1:
        asked["plant"] = sos.Polytope(asked["plant"].vertices)
    return asked | dict(coupling=("slack", 0.1))


KINDS = uncertain, with_slack, with_any_requirements


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
@few
@given(numbers)
def test_promises_are_kept_with_uncertain_masses(kind, seed):
    keeps_its_promises(sos.design_pid(**kind(seed)))


@pytest.mark.campaign
@pytest.mark.parametrize("kind", KINDS)
@many
@given(numbers)
def test_many_promises_are_kept(kind, seed):
    keeps_its_promises(sos.design_pid(**kind(seed)))


def polytope(seed):
    rng = np.random.default_rng(seed)
    return random_plant(rng, 2, 1, 1, vertices=3, spread=0.4), rng


@pytest.mark.slow
@pytest.mark.parametrize("seed", seeds(6))
@pytest.mark.parametrize("share", [0.4, 1.0])
def test_the_verdict_is_that_of_cvxpy_and_clarabel(seed, share):
    plants = scale_polytope(counterexamples.random_pair(seed, 9), share)
    region = sos.PoleRegion(0.1, np.pi / 6, 6)
    design = sos.design_pid(plants, region=region, coupling=("slack", 0.1))
    blocks = float_blocks(design.request, Frame.of(design.request))
    _, margin, _ = clarabel.deepest(scaled(blocks))
    if margin > 1e-4:
        assert design.status == "feasible"
    elif margin < 1e-7:
        assert design.status == "infeasible"


@pytest.mark.slow
@few
@given(numbers)
def test_a_certain_E_makes_slack_at_least_as_good(seed):
    """With a small scalar the slack LMIs contain the common P."""
    rng = np.random.default_rng(seed)
    base = random_plant(rng, 2, int(rng.integers(1, 3)))
    plants = sos.Polytope(
        [replace(base, S=base.S * f, D=base.D / f) for f in (0.9, 1.1)]
    )
    region = sos.PoleRegion(
        rng.uniform(0.1, 2), rng.uniform(0.2, 1.4), rng.uniform(2.5, 9)
    )
    common = sos.design_pid(plants, region=region)
    event(common.status)
    if common.status == "feasible" and min(common.margins.values()) > 1e-4:
        found = [
            sos.design_pid(plants, region=region, coupling=("slack", e)).status
            for e in (1e-2, 1e-3)
        ]
        assert "feasible" in found


@pytest.mark.parametrize(
    "more",
    [
        dict(),
        dict(coupling=("slack", 0.3)),
        dict(gamma=sos.HInfinity(2.0, mu=1.0)),
        dict(minimize="gamma"),
        dict(minimize="cost", requirements=[sos.QuadraticCost(np.eye(2), [])]),
        dict(region=sos.PoleRegion(sigma=0.5)),
        dict(search=sos.Search(time_limit=100)),
        dict(requirements=[sos.LMIRegion.disk(20)]),
    ],
    ids=lambda more: ", ".join(more) or "stability",
)
def test_a_loop_is_asked_by_the_same_door(more):
    """A loop as it is is a system without an input, and needs no K."""
    E, A = np.eye(2), [[[0, 1], [-2, -3]], [[0, 1], [-3, -2]]]
    rest = [[0], [1]], [[1, 0]]
    system = sos.DescriptorSystem(E, A, None, *rest)
    asked = dict(coupling="slack") | more
    found = sos.analyse_pid(system, **asked)
    same = sos.analyse_pid(system, np.zeros((0, 2)), **asked)
    assert found.status == same.status == "feasible" and found.certify().proven
    assert found.certify().text == same.certify().text
    assert found.poles(samples=5).shape == (7, 2)


@pytest.mark.parametrize("factor", [0.3, *campaign([1, 1e3, 1 / 9.81, 2.2046])])
def test_an_observed_loop_takes_what_any_loop_takes(factor):
    """With the length in other units, in which nothing changes but gamma and J."""
    stiff = [
        sos.SecondOrderSystem(1, 0.2, s, factor, 1 / factor) for s in (1.0, 1.5, 2.0)
    ]
    plant = sos.Polytope(stiff)
    observer = sos.design_observer(
        plant, np.array([[-1, -1.5]]) / factor, np.eye(4), [[factor]]
    )
    held = ("slack", 0.5)
    for more in (dict(), dict(minimize="gamma"), dict(gamma=9 / factor, coupling=held)):
        found = observer.analyse(**dict(coupling="slack") | more)
        assert found.status == "feasible" and found.certify().proven
        if found.gamma:
            assert found.hinf(samples=20) < found.gamma
    bound = observer.analyse(
        coupling="slack", saturation=sos.Saturation(9.0 / factor, [1, 0, 1, 0])
    )
    assert bound.certify().proven and bound.peak_input() < 9 / factor


def test_a_gain_that_is_given_keeps_its_own_matrices():
    plants = counterexamples.actuated()
    region = sos.PoleRegion(rho=10)
    design = sos.design_pid(plants, region=region, coupling=("slack", 0.1))
    given_ = sos.analyse_pid(plants, design.K, region=region, coupling=("slack", 0.1))
    assert given_.certify().proven
    wrong = sos.design_pid(plants, region=region, coupling="vertices")
    refused = sos.analyse_pid(plants, wrong.K, region=region, coupling=("slack", 0.1))
    assert refused.status == "infeasible"


@pytest.mark.parametrize("asked", [{"coupling": ("slack", 0.1)}, {}])
def test_vertices_that_repeat_share_a_P_and_its_proof(asked, tmp_path):
    one = thesis.example_1().plant
    heavy = sos.SecondOrderSystem(1.1 * one.M, one.D, one.S, one.B, one.F)
    plants = sos.Polytope([one, heavy, one])
    design = sos.design_pid(plants, region=sos.PoleRegion(0.3), gamma=2.0, **asked)
    proof = design.certify()
    assert proof.proven
    if "coupling" in asked:
        assert proof.P.shape == (3, 4, 4)
        assert np.array_equal(proof.P[0], proof.P[2])
    proof.save(tmp_path / "proof.json")
    done = alone(CHECKER, tmp_path / "proof.json")
    assert done.returncode == 0, done.stderr


def sharp(seed):
    """Two plants that differ little, and a bound that shall be minimised."""
    plants, rng = polytope(seed)
    plants = sos.Polytope(plants.vertices[:2])
    N, m = 2 * plants.n, plants.m
    x0 = rng.standard_normal(N)
    asked = dict(region=sos.PoleRegion(sigma=rng.uniform(0.5, 2)))
    key = ("u_max", "gamma", "cost")[rng.integers(3)]
    if key == "u_max":
        asked["saturation"] = sos.Saturation(None, x0)
    elif key == "gamma":
        asked["saturation"] = sos.Saturation(10 ** rng.uniform(0, 2), x0)
    else:
        asked["requirements"] = [sos.QuadraticCost(np.eye(N), np.eye(m))]
    return plants, asked, key


@pytest.mark.slow
@pytest.mark.parametrize("seed", [2, *campaign([0, 1, *range(3, 8)])])
def test_what_a_vertex_excludes_is_excluded_for_every_scalar(seed):
    """A bound below the least one of a vertex alone."""
    plants, asked, key = sharp(seed)
    first = plants.vertices[0]
    alone = sos.design_pid(
        first, **asked, minimize=key, search=sos.Search(backoff=1e-4)
    )
    if alone.status != "feasible":
        return
    bound = 0.9 * maps.requirements(alone.request)[key]
    asked = dict(requirements=alone.request.with_bounds({key: bound}).requirements)
    d = sos.design_pid(plants, **asked, coupling="slack")
    assert d.status != "feasible"
    if sos.design_pid(first, **asked).status == "infeasible":
        assert d.status == "infeasible"
    if d.status == "infeasible":
        assert d.infeasibility.proven and d.condition == ""
    for slack in (0.03, 0.3):
        one = sos.design_pid(plants, **asked, coupling=("slack", slack))
        assert one.status != "feasible"


@pytest.mark.parametrize("noise, seed", crossed(["F", "states"], range(3)))
def test_slack_at_a_vertex_implies_its_own_LMIs(seed, noise):
    """With P = V' P_i^-1 V, for each requirement of the package."""
    plants, rng = polytope(seed)
    asked = dict(
        region=sos.PoleRegion(0.05, 1.4, 30),
        gamma=100.0,
        saturation=sos.Saturation(1e3, 0.1 * rng.standard_normal(4)),
        requirements=[sos.QuadraticCost(np.eye(4), np.eye(1), noise, bound=1e6)],
    )
    d = sos.design_pid(plants, **asked, coupling="slack")
    assert d.status == "feasible"
    for vertex, p in zip(plants.vertices, d.P):
        P = d.V.T @ np.linalg.solve(p, d.V)
        P = (P + P.T) / 2
        blocks = Request(vertex, **asked).blocks(P, d.K @ P, own=d.own)
        assert all(np.linalg.eigvalsh(g)[0] > 0 for g in blocks.values())


@pytest.mark.parametrize("minimize", [None, "gamma"])
def test_a_mode_that_stays_is_known_before_any_scalar_is_tried(minimize, monkeypatch):
    """Nine scalars would be tried in vain, and the time would be over."""
    parts = np.eye(2), 0 * np.eye(2), [[0], [1]], np.eye(2)
    plants = sos.Polytope(
        [sos.SecondOrderSystem(m * np.eye(2), *parts) for m in (1.0, 1.2)]
    )

    def never(*asked):
        raise AssertionError("a scalar is tried")

    for module in ("slack.search", "objectives.search"):
        monkeypatch.setattr(f"sosbook.synthesis.{module}", never, raising=False)
    monkeypatch.setattr(slack_search, "optimum", never)
    design = sos.design_pid(plants, coupling="slack", minimize=minimize)
    assert design.status == "infeasible" and design.infeasibility.proven
    assert "No gain moves the mode of vertex 1" in design.reason


def hardly_damped(m, k):
    S = 100 * k * np.array([[2, -1, 0], [-1, 2, -1], [0, -1, 1]])
    return sos.SecondOrderSystem(np.diag([1, m, 1]), 0.002 * S, S, np.eye(3, 1))


@pytest.mark.parametrize("unit", [9.81, *campaign([0.3, 1.0])])
def test_a_structure_that_settles_slowly_and_swings_fast(unit):
    """The settling time that is asked is thousands of times that of a swing."""
    force = [hardly_damped(0.7, 1), hardly_damped(1.3, 1.1)]
    plants = sos.Polytope(
        [
            sos.SecondOrderSystem(*(unit * x for x in (v.M, v.D, v.S)), v.B)
            for v in force
        ]
    )
    limit = sos.Saturation(20 * unit, [0.1, 0.1, 0.1, 0, 0, 0])
    asked = dict(region=sos.PoleRegion(sigma=0.001), saturation=limit)
    found = sos.design_pid(plants, coupling="slack", **asked)
    assert found.status == "feasible" and found.certify().proven
    assert found.slack < 1 < 1 / 0.001
    assert found.poles(samples=50).real.max() < -0.001
    assert found.peak_input(samples=10) < 20 * unit


def test_the_vertices_that_refuse_one_scalar_are_asked_for_the_next(monkeypatch):
    """All plants are looked at for a part of the scalars only."""

    def build(a, b):
        D, S = [[0.3, -0.1], [-0.1, 0.4]], [[2, -1], [-1, 2]]
        return sos.SecondOrderSystem(np.diag([1 + a, 2 + b]), D, S, [[1], [0]])

    family = sos.Uncertain(build, a=(-0.3, 0.3), b=(-0.3, 0.3))
    asked = dict(region=sos.PoleRegion(sigma=0.9, rho=3.3))
    looked, search = [], slack_search.search

    def counted(request, minimized=(), pairs=None):
        looked.append(pairs)
        return search(request, minimized, pairs=pairs)

    monkeypatch.setattr(slack_search, "search", counted)
    first = sos.design_pid(family, **asked)
    assert first.status == "infeasible" and "P for each vertex" in first.reason
    assert 1 <= looked.count(None) < len(slack_search.STEPS) / 2


@pytest.mark.parametrize("bound, status", [(3, "feasible"), *later((2, "infeasible"))])
def test_a_least_bound_refuses_no_scalar_that_a_vertex_refuses(
    bound, status, monkeypatch
):
    """A scalar without a point needs no proof, which took thrice as long."""

    def car(m):
        D, S = [[1, -1], [-1, 1]], [[20, -20], [-20, 200]]
        M, B, F = np.diag([m, 0.04]), [[1], [-1]], [[0], [180]]
        return sos.SecondOrderSystem(M, D, S, B, F)

    ends = [car(m) for m in (0.25, 0.4)]
    refused, find = [], slack_search.ScaledLMIs.find

    def counted(lmis, refuse=True, *start):
        first, slack = find(lmis, refuse, *start), lmis.request.coupling.slack
        refused.append(refuse and slack is not None and first.values is None)
        return first

    monkeypatch.setattr(slack_search.ScaledLMIs, "find", counted)
    push, stroke = sos.Output(input=1), sos.Output(position=[[1, -1]])
    asked = dict(
        minimize="softness",
        requirements=[
            sos.HInfinity(outputs=sos.Output(acceleration=[[1, 0]]), name="softness"),
            sos.HInfinity(bound, outputs=stroke, name="stroke"),
            sos.HInfinity(60, outputs=push, name="push"),
        ],
    )
    design = sos.design_pid(sos.Polytope(ends), coupling="slack", **asked)
    assert design.status == status
    assert refused and not any(refused)
