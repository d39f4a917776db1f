"""Many pairs of vertices: looked at together, solved a few at a time."""

import json
from functools import cache
from itertools import product

import numpy as np
import pytest
from numpy.testing import assert_allclose

import sosbook as sos
from sosbook.exact.checker import kernel
from sosbook.exact.checker import verdict as check
from sosbook.lmi import problem
from sosbook.requirements.stability import Stability
from sosbook.solver.barrier import Barrier
from sosbook.solver.blocks import Blocks
from sosbook.solver.loop import margin
from sosbook.synthesis import (
    centre,
    cutting,
    feasibility,
    pair_stacks,
    proofs,
    small_input,
)
from sosbook.synthesis.cutting import Cuts
from sosbook.synthesis.pair_stacks import named_margins, pair_margins
from sosbook.synthesis.request import Request
from sosbook.synthesis.scaled_lmis import ScaledLMIs
from sosbook.synthesis.scaling import Frame
from tests.cases import by_turns, campaign, later, seeds
from tests.hunt.requests import request as hunted

REGION = sos.PoleRegion(sigma=0.4, theta=1.3, rho=20)


def plants(seed=0, k=4, n=2, spread=0.15):
    """2^k vertices in random directions; in all the mass changes: no box of columns."""
    rng = np.random.default_rng(seed)

    def definite(size):
        X = rng.normal(size=(n, n))
        return size * (X @ X.T / n + np.eye(n))

    middle = dict(M=definite(1.0), D=definite(0.3), S=definite(4.0))
    ways = []
    for letter, _ in zip("MSDM" * k, range(k)):
        v = rng.normal(size=n)
        size = spread * np.trace(middle[letter]) / n
        change = np.outer(v, v) / (v @ v) + (letter == "M") * np.eye(n)
        ways.append((letter, size * change / np.trace(change)))
    vertices = []
    for signs in product((-1, 1), repeat=k):
        parts = dict(middle)
        for sign, (letter, change) in zip(signs, ways):
            parts[letter] = parts[letter] + sign * change
        vertices.append(sos.SecondOrderSystem(**parts, B=np.eye(n), F=np.eye(n)[:, :1]))
    return sos.Polytope(vertices)


@pytest.fixture
def few_at_a_time(monkeypatch):
    """The way of many pairs, with sixteen vertices."""
    monkeypatch.setattr(centre, "CENTRE_UP_TO_PAIRS", 20)


ASKED = {
    "region": dict(region=REGION),
    "gamma": dict(region=REGION, gamma=2.0),
    "saturation": dict(
        region=REGION, gamma=2.0, saturation=sos.Saturation(50.0, [0.1, 0.1, 0, 0])
    ),
    "cost": dict(
        region=REGION,
        requirements=[sos.QuadraticCost(np.eye(4), np.eye(2), "F", bound=90.0)],
    ),
    "least": dict(region=sos.PoleRegion(sigma=0.4, rho=9), minimize="gamma"),
}


@cache
def designed(asked, seed=0):
    """The design of sixteen vertices, for tests that solve `few_at_a_time`."""
    return sos.design_pid(plants(seed), **ASKED[asked])


@pytest.mark.parametrize("seed", seeds(3))
@pytest.mark.parametrize("integrators", [0, 1])
def test_many_pairs_are_looked_at_as_each_alone(seed, integrators):
    asked = ASKED["saturation"] | ASKED["cost"]
    if integrators:
        asked = dict(region=REGION, gamma=2.0, U=[[1.0, 0.0]])
    request = Request(plants(seed, k=3), **asked)
    rng = np.random.default_rng(seed)
    X = rng.normal(size=(request.order, request.order))
    P, Y = X @ X.T + np.eye(request.order), rng.normal(size=(2, request.order))
    own = {"J": np.eye(1)}
    found = named_margins(request, P, Y, own)
    alone = {name: margin(g) for name, g in request.blocks(P, Y, own=own).items()}
    assert list(found) == list(alone)
    assert [n.vertices for n in found] == [n.vertices for n in alone]
    assert_allclose(list(found.values()), list(alone.values()), rtol=1e-9, atol=1e-12)
    some = pair_margins(request, P, Y, own=own, below=0.1)
    whole = pair_margins(request, P, Y, own=own)
    for key, values in some.items():
        assert (np.isinf(values) == (whole[key] > 0.1)).all()
        near = np.isfinite(values)
        assert_allclose(values[near], whole[key][near], rtol=1e-12)


@pytest.mark.parametrize("asked", by_turns(ASKED, 2, of=5))
def test_a_few_pairs_need_no_guess_to_start_from(asked, monkeypatch):
    """Some blocks are no numbers where all unknowns are zero."""
    design = designed(asked)
    monkeypatch.setattr(ScaledLMIs, "guess", lambda lmis: None)
    monkeypatch.setattr(cutting, "CUTTING_PLANE_ABOVE_PAIRS", 6)
    again = sos.design_pid(plants(0), **ASKED[asked])
    assert_allclose(again.K, design.K, rtol=1e-5)
    words = {k: v for k, v in ASKED[asked].items() if k != "minimize"}
    refused = sos.design_pid(plants(0), **words | {"gamma": 1e-4})
    assert refused.status == "infeasible" and refused.infeasibility.proven


class Peculiar(Stability):
    """Its text looks at single numbers, and at which vertices are meant."""

    kind = name = "peculiar"

    def pair(self, loop, c):
        total = c.Theta[0, 0] if isinstance(c.Theta, np.ndarray) else c.Theta[0]
        yield "peculiar", np.array([[float(total)]])


class Unequal(Stability):
    """Its text is another one for a single vertex."""

    kind = name = "unequal"

    def pair(self, loop, c):
        yield "unequal", c.EPE * (2.0 if c.i is c.j else 1.0) - 3.0 * np.eye(4)


@pytest.mark.parametrize("requirement", [Peculiar(), Unequal()])
def test_a_text_that_needs_single_matrices_is_read_pair_by_pair(requirement):
    request = Request(plants(k=3), requirements=[requirement])
    P, Y = np.diag([2.0, 1.0, 1.0, 3.0]), np.ones((2, 4))
    found = named_margins(request, P, Y)
    for name, g in request.blocks(P, Y).items():
        assert_allclose(found[name], margin(g), rtol=1e-12)


@pytest.mark.parametrize("asked", by_turns([*ASKED, "unequal", "one mass"], 1))
def test_expressions_of_many_pairs_are_those_of_each_alone(asked, monkeypatch):
    """Written at once and compiled at once, and one by one, they are the same."""
    plant, words = plants(1, k=3), ASKED.get(asked, dict(region=REGION, gamma=2.0))
    if asked == "unequal":
        words = dict(requirements=[Unequal()])
    if asked == "one mass":
        plant = sos.Polytope(stiffer(plant.vertices[0], 7))
    words = {k: v for k, v in words.items() if k != "minimize"}
    request = Request(plant, **words)
    frame = Frame.of(request)

    def written():
        expressions, unknowns = request.in_unknowns(frame)
        return expressions, Blocks(expressions.values(), unknowns)

    at_once, many = written()
    monkeypatch.setattr(pair_stacks, "FEWEST", np.inf)
    alone, one_by_one = written()
    assert list(at_once) == list(alone)
    assert sum(g.whole is not None for g in at_once.values()) >= len(request.pairs) - 1
    assert all(g.whole is None for g in alone.values())
    x = np.random.default_rng(0).standard_normal(many.variables)
    for mine, plain in zip(many(x), one_by_one(x), strict=True):
        assert_allclose(mine, plain, rtol=0, atol=1e-11 * abs(plain).max())
    found, wanted = many.newton.at(x), one_by_one.newton.at(x)
    for mine, plain in zip(found, wanted, strict=True):
        assert_allclose(mine, plain, rtol=0, atol=1e-11 * abs(plain).max())


def stiffer(plant, count):
    """The same plant with stiffer springs, several of them."""
    M, D, S, B, F = (getattr(plant, letter) for letter in "MDSBF")
    return [
        sos.SecondOrderSystem(M, D, S * (1 + k / count), B, F)
        for k in range(1, count + 1)
    ]


@pytest.mark.slow
@pytest.mark.parametrize("asked", by_turns(ASKED, 3, of=5))
def test_a_few_pairs_at_a_time_answer_for_all(few_at_a_time, asked):
    design = designed(asked)
    assert design.status == "feasible"
    blocks = design.request.blocks(design.P, design.Y, own=design.own or {})
    assert list(design.margins) == list(blocks)
    assert min(map(margin, blocks.values())) > 0
    proof = design.certify()
    assert proof.proven and len(proof.blocks) == len(blocks)
    assert check.check(proof.text) == list(proof.claims)


@pytest.mark.slow
def test_the_least_bound_is_that_of_all_blocks(monkeypatch):
    plant, asked = plants(1), ASKED["least"]
    whole = sos.design_pid(plant, **asked)
    monkeypatch.setattr(centre, "CENTRE_UP_TO_PAIRS", 20)
    assert sos.design_pid(plant, **asked).gamma == pytest.approx(whole.gamma, rel=2e-3)


@pytest.mark.parametrize(
    "asked",
    [pytest.param("saturation", marks=pytest.mark.slow), *campaign(["gamma", "cost"])],
)
@pytest.mark.parametrize("seed", [0, *campaign([1])])
def test_neither_order_nor_repetition_matters(few_at_a_time, asked, seed):
    one = designed(asked, seed)
    rng = np.random.default_rng(seed)
    again = [one.request.plant.vertices[k] for k in rng.permutation(16)]
    again += again[3:6]
    two = sos.design_pid(sos.Polytope(again), **ASKED[asked])
    assert one.status == two.status == "feasible"
    assert_allclose(two.K, one.K, rtol=1e-5)


@pytest.mark.parametrize("coupling", ["pairs", "slack"])
def test_a_guess_that_no_pair_violates_will_do(coupling):
    """With a slack matrix no block is without a vertex, and none need be chosen."""
    slack = dict(coupling=("slack", 0.1)) if coupling == "slack" else {}
    request = Request(plants(k=5, spread=0.01), **slack)
    assert len(request.pairs) > cutting.CUTTING_PLANE_ABOVE_PAIRS
    lmis = ScaledLMIs(request, Frame.of(request))
    assert Cuts(lmis).holds(lmis.text.packed(lmis.guess()))
    found = Cuts(lmis).find(lmis.guess())  # of no block once with a slack matrix
    assert Cuts(lmis).holds(lmis.text.packed(found.values))
    assert feasibility.answer(request).status == "feasible"


def bounded_input(k, n=8):
    """A chain with 2^k vertices, and an input that bounds how far P may grow."""
    T = 2.5 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    vertices = [
        sos.SecondOrderSystem(
            np.eye(n),
            0.1 * np.eye(n) + 0.05 * T,
            T + np.eye(n) + np.diag([*(0.15 * np.array(signs)), *np.zeros(n - k)]),
            np.eye(n)[:, ::3],
        )
        for signs in product((-1, 1), repeat=k)
    ]
    return dict(
        plant=sos.Polytope(vertices),
        region=sos.PoleRegion(sigma=0.15, rho=5),
        saturation=sos.Saturation(20.0, np.full(2 * n, 0.1)),
    )


@pytest.mark.parametrize("k", [3, *campaign([4, 5])])
def test_the_centre_of_many_vertices_depends_on_no_start(k, monkeypatch):
    """Newton's method creeps there; the set was once taken for one without a centre."""
    asked = bounded_input(k)
    design = sos.design_pid(**asked)
    request = design.request
    lmis = ScaledLMIs(request, Frame.of_solution(request, design))
    newton = lmis.compiled.newton
    x = lmis.text.packed(lmis.point(design))
    _, decrement = Barrier(newton).step(x, np.zeros(len(x)))
    assert decrement < 1e-6
    others = asked["plant"].vertices
    rng = np.random.default_rng(k)
    asked["plant"] = sos.Polytope([others[i] for i in rng.permutation(len(others))])
    assert_allclose(sos.design_pid(**asked).K, design.K, rtol=1e-6)
    monkeypatch.setattr(cutting, "CUTTING_PLANE_ABOVE_PAIRS", 6)
    assert_allclose(sos.design_pid(**asked).K, design.K, rtol=1e-6)


def stiffer_springs(count, n, seed):
    """Vertices whose springs and forces change by a third."""
    rng = np.random.default_rng(seed)
    S = 3 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    vertices = [
        sos.SecondOrderSystem(
            np.eye(n),
            0.1 * S,
            S * (1 + 0.3 * rng.uniform(-1, 1)),
            np.diag(1 + 0.3 * rng.uniform(-1, 1, n)),
            np.eye(n),
        )
        for _ in range(count)
    ]
    return sos.Polytope(vertices)


def stiffnesses(count, gain, seed=0):
    """Such vertices, and what is asked of them."""
    saturation = sos.Saturation(gain, np.ones(6))
    plant = stiffer_springs(count, 3, seed)
    return dict(plant=plant, region=REGION, gamma=0.8, saturation=saturation)


@pytest.mark.parametrize("seed", [0, *campaign([1, 2])])
def test_few_pairs_refuse_for_all(seed, monkeypatch):
    """What a few vertices exclude isn't excluded once more by hundreds of blocks."""
    sizes = []

    def watched(module):
        plain = module.phase_one

        def phase_one(blocks, **options):
            sizes.append(len(blocks.constants))
            return plain(blocks, **options)

        monkeypatch.setattr(module, "phase_one", phase_one)

    watched(cutting)
    watched(problem)
    design = sos.design_pid(**stiffnesses(26, 0.3, seed))
    assert design.status == "infeasible" and design.infeasibility.proven
    assert max(sizes) < 60 < len(design.request.blocks(np.eye(6), np.ones((3, 6))))
    names = design.infeasibility.multipliers
    assert len({v for name in names for v in name.vertices}) < 10
    few = sos.design_pid(**stiffnesses(20, 0.3, seed))
    assert few.status == "infeasible"  # whose blocks are looked at together
    assert (
        len({v for name in few.infeasibility.multipliers for v in name.vertices}) < 10
    )


@pytest.mark.parametrize("n, count", [(3, 12), *later((2, 16))])
def test_few_vertices_refuse_with_a_slack_matrix(n, count):
    design = sos.design_pid(
        stiffer_springs(count, n, count),
        region=sos.PoleRegion(sigma=0.4, rho=8),
        saturation=sos.Saturation(0.5, np.ones(2 * n)),
        coupling=("slack", 0.1),
    )
    proof = design.infeasibility
    assert design.status == "infeasible" and proof.verify()
    assert check.check(proof.text) == list(proof.claims)
    assert len({v for name in proof.multipliers for v in name.vertices}) < count


def test_what_few_pairs_leave_open_is_asked_of_all(monkeypatch):
    asked = stiffnesses(24, 0.3)
    plain, whole = feasibility.search, []

    def search(request, **options):
        whole.append(options.get("whole", False))
        return plain(request, **options)

    def proof(problem, Z):
        """None, if they are multipliers of a few pairs."""
        if problem.pairs is not None:
            return None
        return refuse(problem, Z)

    refuse = ScaledLMIs.refuse
    monkeypatch.setattr(feasibility, "search", search)
    monkeypatch.setattr(feasibility, "refused_alone", lambda *_: None)
    monkeypatch.setattr(small_input, "refuse_by_input", lambda *_: None)
    monkeypatch.setattr(ScaledLMIs, "refuse", proof)
    design = sos.design_pid(**asked, coupling="pairs")
    assert design.status == "infeasible" and whole == [False, True]
    assert len(design.infeasibility.multipliers) > 90


def test_the_checker_builds_the_pairs_that_a_refusal_names(monkeypatch):
    """One vertex of eight is refused: all other pairs have no multiplier."""
    whole = plants(k=3)
    asked = dict(
        region=sos.PoleRegion(sigma=4.0),
        saturation=sos.Saturation(1e-3, [1.0, 1.0, 0, 0]),
    )
    first = feasibility.search(Request(whole.vertices[0], **asked))
    request = Request(whole, **asked)
    Z, frame = first.multipliers, first.problem.frame
    proof = proofs.refuse_design(request, frame, Z, [(0, 0)])
    assert proof.proven and len(request.pairs) > 10
    assert json.loads(proof.text)["sets"]["pairs"] == [["1", "1"]]
    built, read = [], kernel.Reader.statements

    def watched(reader, program):
        for statement in read(reader, program):
            built.append(statement[1])
            yield statement

    monkeypatch.setattr(kernel.Reader, "statements", watched)
    assert check.check(proof.text) == list(proof.claims)
    assert {name for name in built if "region" in name} == {"region.1.1.1"}


def test_pairs_of_two_plants_each_refuse_without_a_vertex():
    """Of the few pairs that decide none is a vertex with itself: the largest weight of
    a vertex was that of an empty list.
    """
    asked = hunted(99)
    design = sos.design_pid(asked.plant, **asked.keywords)
    assert design.status == "infeasible" and check.check(design.infeasibility.text)
    pairs = json.loads(design.infeasibility.text)["sets"]["pairs"]
    assert len(pairs) < 15 and all(i != j for i, j in pairs)
