"""Polytopes whose vertices speak for the plants between."""

import json
import math
from dataclasses import replace
from functools import cache
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import nnls

import sosbook as sos
from sosbook.exact.checker import verdict
from sosbook.exact.checker.arithmetic import Refused
from sosbook.exact.checker.plants import corners_suffice, suffice
from sosbook.exact.checker.text import mat
from sosbook.lmi.text import floats
from sosbook.plants import coupling as plants_coupling
from sosbook.plants.as_data import plant_data
from sosbook.plants.coupled import Coupled
from sosbook.plants.descriptor import Descriptor, descriptors, mean_descriptor
from sosbook.plants.hull import quotient_in_hull
from sosbook.requirements.hinf import HInfinity
from sosbook.requirements.stability import Stability
from sosbook.studies import polytopes
from sosbook.synthesis.request import Request
from tests import energy_to_peak
from tests.cases import campaign, examples, seeds

N, INPUTS = 3, 2
SHAPES = {"E": (N, N), "A": (N, N), "Bu": (N, INPUTS), "Bw": (N, 1)}
WIDTH = sum(columns for _, columns in SHAPES.values())
CUTS = np.cumsum([columns for _, columns in SHAPES.values()])[:-1]


def system(wide):
    """A `Descriptor` of one matrix [E A B_u B_w]."""
    return Descriptor(*np.split(wide, CUTS, axis=1), C=np.eye(N))


def leaves_hull(vertices, weights):
    """How far E^-1 [A B_u B_w] of their mean lies from the hull of theirs."""
    return beside_hull(vertices, np.tensordot(weights, vertices, 1))


def beside_hull(vertices, plant):
    """How far E^-1 [A B_u B_w] of a plant lies from the hull of the vertices' ones."""

    def quotient(wide):
        E, rest = wide[:, :N], wide[:, N:]
        return np.append(np.linalg.solve(E, rest).ravel(), 1.0)

    corners = np.array([quotient(w) for w in vertices]).T
    target = quotient(plant)
    return nnls(corners, target)[1] / np.linalg.norm(target)


small = st.integers(-3, 3)


@st.composite
def families(draw):
    """Boxes that the theorem knows, and others that are near them."""

    def array(*shape):
        count = int(np.prod(shape))
        entries = draw(st.lists(small, min_size=count, max_size=count))
        return np.array(entries, float).reshape(shape)

    base = array(N, WIDTH)
    base[:, :N] += 12 * np.eye(N)
    inner = [base]
    for _ in range(draw(st.integers(0, 2))):
        other = base.copy()
        other[:, N:] = array(N, WIDTH - N)
        inner.append(other)
    changes = [np.outer(array(N), array(WIDTH)) for _ in range(draw(st.integers(0, 3)))]
    if draw(st.booleans()):
        changes.append(array(N, WIDTH))
    vertices = [
        v + sum((c for c, on in zip(changes, signs) if on), np.zeros((N, WIDTH)))
        for v in inner
        for signs in product((0, 1), repeat=len(changes))
    ]
    if draw(st.booleans()):
        vertices = draw(st.permutations(vertices))
    if len(vertices) > 2 and draw(st.booleans()):
        vertices = vertices[1:]
    return vertices


@settings(max_examples=examples(70, 150), deadline=None)
@given(families(), st.integers(0, 2**32 - 1))
def test_where_vertices_suffice_the_quotient_stays_in_their_hull(vertices, seed):
    found = quotient_in_hull([system(w) for w in vertices])
    E = [rational(w[:, :N]) for w in vertices]
    assert suffice(E, [tuple(map(int, w.T.ravel())) for w in vertices]) == found
    if found:
        weights = np.random.default_rng(seed).dirichlet(np.ones(len(vertices)), 5)
        for some in weights:
            assert leaves_hull(np.array(vertices), some) < 1e-7


@pytest.mark.parametrize("spoilt", [False, True])
@pytest.mark.parametrize("seed", seeds(6))
def test_between_corners_the_quotient_is_a_mean_of_theirs(seed, spoilt):
    """A parameter of E has one column and row, which depend on the others."""
    rng = np.random.default_rng(seed)
    base, free = rng.integers(-3, 4, (2, N, WIDTH)).astype(float)
    base[:, :N] += 60 * np.eye(N)
    free[:, :N] = 0  # what isn't in E may have any columns
    u, v = rng.integers(1, 4, (2, N)) * [[1, -1, 1], [1, 1, -1]]
    rows = rng.integers(-3, 4, (4, WIDTH))
    rows[1::2, :N] = 0

    def plant(a, b, k):  # as a crane's rope, b has a column with the load a in it
        along_a = np.outer(u, a * (rows[0] + k * rows[1]))
        along_b = np.outer(v + a * u, b * rows[2]) + spoilt * a * b * np.outer(
            v, rows[3]
        )
        return base + k * free + along_a + along_b

    corners = [plant(*t) for t in product((0, 1), repeat=3)]
    found = quotient_in_hull([system(w) for w in corners], corners=True)
    points = [tuple(map(int, w.T.ravel())) for w in corners]
    assert corners_suffice([rational(w[:, :N]) for w in corners], points) == found
    assert found != spoilt and not quotient_in_hull([system(w) for w in corners])
    if found:
        for t in rng.random((20, 3)):
            assert beside_hull(corners, plant(*t)) < 1e-7


def rational(rows):
    return mat([[str(int(e)) for e in row] for row in rows], len(rows))


def box(changes, base=None):
    """All sums of a plant and of some of the changes of its matrices."""
    base = base or dict.fromkeys("MDSBF", np.eye(2))
    vertices = []
    for signs in product((0, 1), repeat=len(changes)):
        parts = dict(base)
        for on, change in zip(signs, changes):
            for name, x in change.items():
                parts[name] = parts[name] + on * np.asarray(x, float)
        vertices.append(sos.SecondOrderSystem(**parts))
    return sos.Polytope(vertices)


FIRST, SECOND = np.diag([1.0, 0.0]), np.diag([0.0, 1.0])
ROW = {"M": FIRST, "D": [[0.5, 0.25], [0, 0]], "S": [[2, -1], [0, 0]]}
ONE_PLANT = [{}]
SUFFICE = {
    "one plant": ONE_PLANT,
    "a certain mass": [{"S": [[1, 2], [3, 4]]}, {"D": FIRST, "B": SECOND}],
    "two masses": [{"M": FIRST}, {"M": SECOND}],
    "two masses and two springs": [
        {"M": FIRST},
        {"M": SECOND},
        {"S": FIRST},
        {"S": [[1, -1], [-1, 1]]},
    ],
    "a row of the equations": [ROW],
    "a row, and another mass": [ROW, {"M": SECOND}],
    "a mass at a lever": [{"M": [[4, 2], [2, 1]]}, {"M": FIRST}],
    "decimals": [{"M": 0.1 * FIRST}, {"M": 0.7 * FIRST}],
}
MISLEAD = {
    "two masses at once": [{"M": np.eye(2)}],
    "a mass and the other's damper": [{"M": FIRST, "D": SECOND}],
    "a mass that passes zero": [{"M": -2 * FIRST}],
    "a mass that is zero": [{"M": -1 * FIRST}],
}


SHORT = [name for name in SUFFICE if name != "two masses and two springs"]


@pytest.mark.parametrize("name", [*SHORT, *campaign(["two masses and two springs"])])
def test_polytopes_whose_vertices_suffice(name):
    plants = box(SUFFICE[name])
    assert polytopes.vertices_suffice(plants)
    if name != "one plant":
        assert polytopes.hull_gap(plants, count=50) < 1e-9
    again = [*plants.vertices[::-1], plants.vertices[0]]
    assert polytopes.vertices_suffice(sos.Polytope(again))
    request = Request(plants, region=sos.PoleRegion(rho=30), gamma=3.0)
    assert all(i == j for i, j in request.pairs) and request.claims.covers_polytope


@pytest.mark.parametrize("name", MISLEAD)
def test_polytopes_whose_vertices_may_mislead(name):
    plants = box(MISLEAD[name])
    if name == "a mass that is zero":  # refused before anybody asks
        with pytest.raises(ValueError, match="singular"):
            polytopes.vertices_suffice(plants)
        few = descriptors(box([{"M": FIRST}]))
        singular = [replace(d, E=np.diag([1.0, 1, m, 1])) for d, m in zip(few, (1, 0))]
        assert not quotient_in_hull(singular)
        return
    assert not polytopes.vertices_suffice(plants)
    assert len(Request(plants).pairs) == 3


def test_a_corner_that_is_missing_counts():
    whole = box([{"M": FIRST}, {"M": SECOND}])
    for k in range(4):
        some = [v for i, v in enumerate(whole.vertices) if i != k]
        assert not polytopes.vertices_suffice(sos.Polytope(some))
        assert len(Request(sos.Polytope(some)).pairs) == 6


def test_the_acceleration_gain_belongs_to_the_mass():
    """M - B K_A changes with B: by one column where B does, else by more."""
    K_A = [[0.5, 0.25], [0.1, 0.2]]
    some = 0.25 * FIRST
    assert polytopes.vertices_suffice(box([{"B": some}]), K_A=K_A)
    assert polytopes.vertices_suffice(box([{"B": some}, {"M": SECOND}]), K_A=K_A)
    assert not polytopes.vertices_suffice(box([{"B": FIRST}]), K_A=K_A)  # det < 0
    assert not polytopes.vertices_suffice(box([{"B": 0.5 * np.eye(2)}]), K_A=K_A)
    assert polytopes.vertices_suffice(box([{"B": 0.5 * np.eye(2)}]))


def test_vertices_along_one_column_need_no_box():
    """The quotient's weights are those of the vertices times det E."""
    rng = np.random.default_rng(2)
    rows = rng.integers(-2, 3, (5, WIDTH)).astype(float)
    base = np.hstack([9 * np.eye(N), rng.integers(-2, 3, (N, WIDTH - N))])
    vertices = [base + np.outer([1.0, -1.0, 2.0], row) for row in rows]
    assert quotient_in_hull([system(w) for w in vertices])
    weights = rng.dirichlet(np.ones(5))
    middle = np.tensordot(weights, vertices, 1)
    beta = weights * [np.linalg.det(w[:, :N]) for w in vertices]
    beta /= np.linalg.det(middle[:, :N])
    quotients = [np.linalg.solve(w[:, :N], w[:, N:]) for w in (middle, *vertices)]
    assert beta.min() > 0
    assert np.allclose(quotients[0], np.tensordot(beta, quotients[1:], 1))


def test_rounded_sums_are_no_box_but_are_read_as_one():
    """0.1 + 0.2 isn't 0.3 in floats; a plant that is given is the box near it."""
    lever = np.array([[0.0, 1.0], [0.0, 0.0]])
    plain = dict(D=np.eye(2), S=np.eye(2), B=np.eye(2))

    def plants(offsets):
        return sos.Polytope(
            [
                sos.SecondOrderSystem(np.eye(2) + x * lever + m * SECOND, **plain)
                for x in offsets
                for m in (0, 1)
            ]
        )

    assert polytopes.vertices_suffice(plants([0, 0.1, 0.2, 0.3]))
    rounded = plants([0, 0.1, 0.2, 0.1 + 0.2])
    assert not quotient_in_hull(descriptors(rounded))
    assert polytopes.vertices_suffice(rounded)


@pytest.mark.parametrize("seed", seeds(4))
def test_designs_at_vertices_that_suffice_keep_their_promises(seed):
    """Gamma, poles and cost of plants between, by formulas without LMIs."""
    rng = np.random.default_rng(seed)
    plants = box(
        [
            {"M": 0.8 * FIRST, "S": [[rng.uniform(-1, 1), 0.5], [0, 0]]},
            {"M": 1.5 * SECOND},
            {"D": rng.uniform(-0.3, 0.3, (2, 2))},
        ],
        dict(M=np.eye(2), D=0.5 * np.eye(2), S=np.eye(2), B=np.eye(2), F=np.eye(2)),
    )
    region = sos.PoleRegion(sigma=0.2, theta=1.3, rho=30)
    cost = sos.QuadraticCost(np.eye(4), np.eye(2), "F", bound=100.0)
    design = sos.design_pid(plants, region=region, gamma=2.0, requirements=[cost])
    assert len(design.request.pairs) == 8
    assert "every constant or changing plant of" in design.certify().claims[0]
    for plant in plants.sample(20, seed=seed):
        loop = sos.analyse_pid(plant, design.K)
        (d,) = descriptors(plant)
        assert region.contains(loop.poles())
        assert loop.hinf() < 2.0
        assert cost.truth([d], design.K) < 100.0


def test_eight_uncertain_masses_need_no_pair():
    """256 vertices; all pairs would be 32,896."""
    masses = [np.diag(m) for m in product((0.8, 1.2), repeat=8)]
    one = np.eye(8)
    plants = sos.Polytope([sos.SecondOrderSystem(M, one, one, one) for M in masses])
    request = Request(plants, region=sos.PoleRegion(rho=6))
    assert len(request.pairs) == 256 and request.claims.covers_polytope


def test_what_says_that_it_is_affine_in_the_quotient_is():
    """Each block of a vertex, divided by E, and of a mean of quotients."""
    rng = np.random.default_rng(8)
    plants = box([{"M": FIRST}, {"M": [[0.25, 0.5], [0.5, 1]]}])
    asked = [
        Stability(),
        HInfinity(3.0),
        sos.QuadraticCost(np.eye(4), np.eye(2), "F", bound=9.0),
        energy_to_peak.EnergyToPeak(2.0),
        *sos.PoleRegion(sigma=0.2, theta=1.2, rho=8).parts,
    ]
    P, Y = rng.standard_normal((4, 4)), rng.standard_normal((2, 4))
    P, own = P @ P.T, {"J": np.eye(2)}
    request = Request(plants, requirements=asked)
    loops, _ = request.loops(P, Y, floats, None, None, (), own)

    def blocks(r, d):
        return [g for _, g in r.pair(loops[r.key], Coupled(d, d, P, Y))]

    def divided(d):
        A, Bu, Bw = d.state_space()
        return replace(d, E=np.eye(4), A=A, Bu=Bu, Bw=Bw)

    quotients = [divided(d) for d in request.vertices]
    mean = mean_descriptor(quotients)
    for r in request.demands:
        assert r.affine_in_quotient
        each = [blocks(r, d) for d in quotients]
        for g, *some in zip(blocks(r, mean), *each, strict=True):
            assert np.allclose(g, np.mean(some, axis=0))
        for d, one in zip(request.vertices, each, strict=True):
            for g, divided_g in zip(blocks(r, d), one, strict=True):
                signs = [np.sum(np.linalg.eigvalsh(x) > 0) for x in (g, divided_g)]
                assert signs[0] == signs[1]


# the second row divided by what all of it has, and the first as Lagrange has it
CRANE = {
    "M": [["m + 1", "m*l"], [1, "l"]],
    "D": [[0, 0], [0, 0]],
    "S": [[0, 0], [0, 9.81]],
    "B": [[1], [0]],
}


SLOWLY = dict(region=sos.PoleRegion(sigma=0.1, rho=10), coupling="pairs")


@cache
def crane():
    """The crane with both ranges, its design and the design's proof."""
    ranges = {"parameters": [["m", 0.1, 2], ["l", 3, 8]]}
    plants = sos.Uncertain.read(sos.SecondOrderSystem, ranges | CRANE)
    design = sos.design_pid(plants, **SLOWLY)
    return plants, design, design.certify()


def test_a_crane_that_pairs_refuse_is_designed_by_its_corners():
    plants, design, proof = crane()
    bare = sos.Polytope(plants.vertices)
    assert polytopes.vertices_suffice(plants) and not polytopes.vertices_suffice(bare)
    assert sos.design_pid(bare, **SLOWLY).status == "infeasible"
    assert verdict.check(proof.text) == list(proof.claims) and proof.proven
    for plant in plants.sample(200, 3):
        (d,) = descriptors(plant)
        poles = np.linalg.eigvals(np.linalg.solve(d.E, d.A + d.Bu @ design.K))
        assert poles.real.max() < -0.1 and abs(poles).max() < 10


@pytest.mark.filterwarnings("ignore::sosbook.MassWarning")
def test_no_reader_takes_the_corners_word_where_a_change_has_two_columns(monkeypatch):
    def spoilt(m, l):
        M, S = [[1 + m, m * l], [1, l + m / 1000]], [[0, 0], [0, 9.81]]
        return sos.SecondOrderSystem(M, np.zeros((2, 2)), S, [[1], [0]])

    plants = sos.Uncertain(spoilt, m=(0.1, 2), l=(3, 8))
    assert not polytopes.vertices_suffice(plants)
    monkeypatch.setattr(plants_coupling, "quotient_in_hull", lambda *_: True)
    design = sos.design_pid(plants, **SLOWLY)
    assert design.status == "feasible" and not design.certify().proven


def test_vertices_of_a_power_are_no_corners():
    """A cubic range whose four vertices are the crane's corners has other plants
    between: they need the blocks of all pairs, which no proof of the crane has.
    """
    plants, _, proof = crane()
    corners = [
        (float(v.M[0, 0]), float(v.M[0, 1]), float(v.M[1, 1])) for v in plants.vertices
    ]

    def build(s):
        weights = [math.comb(3, k) * s**k * (1 - s) ** (3 - k) for k in range(4)]
        a, b, c = (sum(w * x for w, x in zip(weights, some)) for some in zip(*corners))
        return sos.SecondOrderSystem(
            [[a, b], [1, c]], np.zeros((2, 2)), [[0, 0], [0, 9.81]], [[1], [0]]
        )

    curve = sos.Uncertain(build, s=(0, 1))
    assert all(x == y for x, y in zip(curve.vertices, plants.vertices, strict=True))
    whole = json.loads(proof.text)
    whole["asks"]["plant"] = plant_data(curve)
    whole["about"] = verdict.about(verdict.asked_of(whole))
    with pytest.raises(Refused, match="'sets' isn't what is written"):
        verdict.check(json.dumps(whole))
