"""Every requirement meets every consumer; none takes another one's place."""

import pickle
import re
from dataclasses import replace
from functools import cache
from itertools import cycle, product

import cvxpy
import numpy as np
import pytest

import sosbook as sos
from sosbook.book import elements
from sosbook.plants import descriptors
from sosbook.requirements.blocks import BlockName, BlockTable
from sosbook.requirements.hinf import HInfinity
from sosbook.requirements.stability import Stability
from sosbook.studies import maps
from sosbook.studies.polytopes import verify_on_samples
from sosbook.synthesis.request import Request
from tests.cases import by_turns, campaign, crossed, later
from tests.energy_to_peak import EnergyToPeak

COUPLINGS = ("pairs", "vertices", "slack")
REQUIREMENTS = {
    "sigma": sos.LMIRegion.half_plane(0.3),
    "theta": sos.LMIRegion.sector(1.2),
    "rho": sos.LMIRegion.disk(30.0),
    "ellipse": sos.LMIRegion.ellipse(-10, 9.9, 9),
    "strip": sos.LMIRegion.strip(-40, -0.2, name="slow and fast"),
    "gamma": HInfinity(0.8),
    "u_max": sos.Saturation(40.0, [1, 0]),
    "cost": sos.QuadraticCost(np.eye(2), [[1]], bound=60.0),
    "noise": sos.QuadraticCost(np.eye(2), [[1]], noise="F", bound=60.0),
    "peak": EnergyToPeak(2.0),
}
MOVABLE = [name for name, r in REQUIREMENTS.items() if r.parameter]
OPEN = [name for name in MOVABLE if REQUIREMENTS[name].parameter.power]


def plant(m):
    return sos.SecondOrderSystem([[m]], [[0.1]], [[1]], B=[[1]], F=[[1]])


PLANTS = sos.Polytope([plant(1.0), plant(1.2)])
ROOF = sos.Saturation(500.0, [0.3, 0])  # bounds the set of designs
FAST = sos.LMIRegion.half_plane(1.0)
TIGHT = sos.Saturation(0.3, [0.3, 0])


def asked(name, *others):
    """Keywords with a requirement, others and a bound of the input."""
    r = REQUIREMENTS[name]
    roof = () if isinstance(r, sos.Saturation) else (ROOF,)
    return dict(requirements=[r, *others, *roof])


@cache
def solved(name, **more):
    return sos.design_pid(PLANTS, **asked(name), **more)


@pytest.fixture(scope="module")
def designs():
    return {name: solved(name) for name in REQUIREMENTS}


@pytest.mark.parametrize("coupling", COUPLINGS)
@pytest.mark.parametrize("r", REQUIREMENTS.values(), ids=REQUIREMENTS)
def test_those_with_constants_fix_the_size_of_P(r, coupling):
    how = ("slack", 0.1) if coupling == "slack" else coupling
    if coupling == "slack" and isinstance(r, EnergyToPeak):
        pytest.skip("it has no LMI with a slack matrix")
    request = Request(PLANTS, requirements=[r], coupling=how)
    expressions, _ = request.in_unknowns(None)
    constant = any(
        g.constant.any() for name, g in expressions.items() if name.requirement == r.key
    )
    assert bool(request.sizes.fixing) == constant


@pytest.mark.parametrize("name, coupling", crossed(REQUIREMENTS, COUPLINGS))
def test_solve_prove_and_truth(name, coupling):
    d, r = solved(name, coupling=coupling), REQUIREMENTS[name]
    assert d.status == "feasible" and min(d.margins.values()) > 0
    assert all(isinstance(n, BlockName) for n in d.margins)
    proof = d.certify()
    assert proof.proven
    kept, at_vertices = verify_on_samples(d), r.kept(r.truth(descriptors(PLANTS), d.K))
    assert kept[r.promise] <= at_vertices  # the plants between join in
    assert at_vertices > 0
    if coupling != "vertices":
        assert r.statement in proof.claims and min(kept.values()) > 0


@pytest.mark.parametrize("name, coupling", crossed(OPEN, ["pairs", "slack"]))
def test_minimise(designs, name, coupling):
    r = REQUIREMENTS[name]
    key = r.parameter.key
    fixed = [FAST] if name == "u_max" else [ROOF]
    coupling = ("slack", 0.3) if coupling == "slack" else coupling
    d = sos.design_pid(
        PLANTS,
        requirements=[r.with_bound(None), *fixed],
        minimize=key,
        coupling=coupling,
    )
    assert d.status == "feasible" and d.certify().proven
    bound = maps.requirements(d.request)[key]
    assert bound < r.bound
    assert min(verify_on_samples(d).values()) > 0
    harder = sos.design_pid(
        PLANTS, requirements=[r.with_bound(0.97 * bound), *fixed], coupling=coupling
    )
    assert harder.status != "feasible"


@pytest.mark.parametrize(
    "name, coupling",
    [
        *zip(list(REQUIREMENTS)[1::2], cycle(["pairs", "slack"])),
        *later(*product(list(REQUIREMENTS)[::2], ["pairs", "slack"])),
        *later(*zip(list(REQUIREMENTS)[1::2], cycle(["slack", "pairs"]))),
    ],
)
def test_a_warm_start_gives_the_same_design(name, coupling):
    more = dict(coupling=("slack", 0.3) if coupling == "slack" else coupling)
    r = REQUIREMENTS[name]
    first = solved(name, **more)
    wanted = r
    if r.parameter:
        wanted = r.with_bound(r.bound * (1 + 0.05 * r.parameter.harder))
    fixed = [] if name == "u_max" else [ROOF]
    cold = sos.design_pid(PLANTS, requirements=[wanted, *fixed], **more)
    warm = sos.design_pid(
        PLANTS, requirements=[wanted, *fixed], search=sos.Search(start=first), **more
    )
    assert warm.status == cold.status == "feasible"
    assert np.allclose(warm.K, cold.K, rtol=1e-4)


@pytest.mark.parametrize("name", by_turns(REQUIREMENTS, 0))
def test_a_start_that_knows_less_is_no_fault(name):
    plain = sos.design_pid(PLANTS, saturation=ROOF)
    warm, cold = (
        sos.design_pid(PLANTS, **asked(name), search=sos.Search(start=plain)),
        solved(name),
    )
    assert warm.status == "feasible"
    assert np.allclose(warm.K, cold.K, rtol=1e-4)


@pytest.mark.parametrize("name", REQUIREMENTS)
def test_refute_and_advise(name):
    r = REQUIREMENTS[name]
    tight = sos.Saturation(1e-3, [1, 0])
    if r.parameter is None:  # a region far to the left
        r = sos.LMIRegion.strip(-40, -30, name="far")
    elif name == "theta":
        r, tight = r.with_bound(0.3), sos.Saturation(1e-3, [1, -0.5])
    elif name == "rho":  # no gain holds all poles so near to zero
        r, tight = r.with_bound(0.01), sos.Saturation(0.05, [1, 0])
    else:
        r = r.with_bound(r.bound * 1000.0**r.parameter.harder)
    others = [] if name == "u_max" else [tight]
    if name == "u_max":
        others = [sos.LMIRegion.half_plane(3.0)]
    d = sos.design_pid(PLANTS, requirements=[r, *others])
    assert d.status == "infeasible" and d.infeasibility.proven
    assert r.words in d.advice
    by = d.request
    if one := re.match(r"At vertex (\d+) alone", d.reason):
        by = replace(by, plant=PLANTS.vertices[int(one[1]) - 1])
    assert set(d.infeasibility.multipliers) == set(by.in_unknowns(d.frame)[0])
    without = d.request.without(r)
    assert r.key not in {x.key for x in without.requirements}
    assert len(without.requirements) == len(others)


EACH = [*product(REQUIREMENTS, COUPLINGS)]
OF_FOUR = [*EACH[::4], *later(*(one for k, one in enumerate(EACH) if k % 4))]


@pytest.mark.parametrize("name, coupling", OF_FOUR)
def test_export_to_cvxpy(name, coupling):
    how = ("slack", 0.3) if coupling == "slack" else coupling
    d = solved(name, coupling=how)
    constraints, P, Y = d.to_cvxpy()
    problem = cvxpy.Problem(cvxpy.Minimize(0), constraints)
    problem.solve(solver="CLARABEL")
    assert problem.status == "optimal"
    assert len(constraints) == len(d.margins)
    if coupling != "slack":
        K = np.linalg.solve(P.value, Y.value.T).T
        poles = [
            np.linalg.eigvals(x.state_space()[0] + x.state_space()[1] @ K)
            for x in descriptors(PLANTS)
        ]
        assert np.real(poles).max() < 1e-6


@pytest.mark.parametrize("name", by_turns(MOVABLE, 1, of=4))
def test_edges_and_shares(name):
    r = REQUIREMENTS[name]
    key = r.parameter.key
    held = {
        "u_max": [FAST],
        "theta": [REQUIREMENTS["sigma"], TIGHT],
        "rho": [TIGHT.with_bound(0.2)],
        "gamma": [ROOF.with_bound(50.0)],
    }
    edge = maps.edge(key, PLANTS, digits=1, requirements=[r, *held.get(name, [ROOF])])
    assert edge.proven, edge.reason
    assert r.parameter.harder_than(edge.infeasible, edge.feasible) == 1
    assert key in edge.shares and np.isclose(sum(edge.shares.values()), 1)
    assert f"<Edge: {key}" in repr(edge)


HELD = "strip", "u_max"  # held, and moved


@pytest.mark.parametrize(
    "name", [*HELD, *campaign(x for x in REQUIREMENTS if x not in HELD)]
)
def test_maps_hold_it_or_move_it(name):
    """Each verdict of a map is that of a design of its own."""
    r = REQUIREMENTS[name]
    across = ("rho", [5.0, 20.0]) if name == "sigma" else ("sigma", [0.4, 6.0])
    up = ("gamma", [0.3, 0.9])
    if r.parameter and name not in ("sigma", "gamma"):
        up = r.parameter.key, [0.9 * r.bound, 1.1 * r.bound]
    found = maps.frontier(
        across[0], up[0], PLANTS, values=across[1], progress=False, **asked(name)
    )
    for y in up[1]:
        for x in across[1]:
            wanted = Request(PLANTS, **asked(name)).with_bounds(
                {across[0]: x, up[0]: y}
            )
            d = sos.design_pid(PLANTS, requirements=wanted.requirements)
            assert found.status(x, y) == d.status
    for e in found.edges:
        if e.design is not None:
            assert any(x.key == r.key for x in e.design.request.requirements)
            assert e.design.certify().proven


SHOWN = "gamma", "peak"  # ours, an author's


@pytest.mark.parametrize(
    "name", [*SHOWN, *campaign(x for x in REQUIREMENTS if x not in SHOWN)]
)
def test_pages_show_it(name):
    r = REQUIREMENTS[name]
    key = r.parameter.key if r.parameter else "gamma"
    x, values, held = "sigma", [0.4, 0.5], [REQUIREMENTS["sigma"]]
    if key == "sigma":
        x, values, held = "rho", [20.0, 30.0], [REQUIREMENTS["rho"]]
    if not r.parameter:
        held.append(REQUIREMENTS["gamma"])
    front = maps.frontier(
        x,
        key,
        PLANTS,
        values=values,
        digits=1,
        n_jobs=1,
        progress=False,
        **asked(name, *held),
    )
    page = elements.MapAtlas({"Mass": [front]}).data
    assert page["groups"][0]["maps"][0]["y"]["key"] == key


def test_a_region_cannot_take_a_theorems_place():
    """ "lqr" overwrote the block of the cost, and a falsehood was proven."""
    for name in ("lqr", "cost", "trace", "P", "x0", "hinf", "stability", "u_max"):
        d = sos.design_pid(
            plant(0.3),
            [[9.81]],
            region=sos.LMIRegion.half_plane(5.0, name=name),
            requirements=[sos.QuadraticCost(np.eye(3), [[1]], bound=1e5)],
        )
        assert {"P", "trace", "cost", "lqr"} <= set(
            d.margins
            or d.request.blocks(np.eye(3), np.zeros((1, 3)), own={"J": np.eye(3)})
        )
        if d.status == "feasible" and d.certify().proven:
            assert d.noise_cost() < 1e5


def test_names_of_regions_are_kept_apart():
    region = sos.LMIRegion.half_plane(0.3, name="cost")
    request = Request(
        PLANTS, region=region, requirements=[REQUIREMENTS["cost"]], gamma=0.8
    )
    d = sos.design_pid(PLANTS, requirements=request.requirements)
    assert d.status == "feasible"
    labels = list(d.margins)
    assert len(set(labels)) == len(labels)
    assert "region cost 1" in labels and "cost" in labels
    assert {n.requirement for n in labels} == {
        None,
        ("region", "cost"),
        ("cost", "cost"),
        ("gamma", "gamma"),
    }
    with pytest.raises(ValueError, match="2 requirements are called"):
        request.without("cost")
    assert request.without(region).names == ["gamma", "cost"]


def test_a_block_comes_once():
    table = BlockTable(many=False)
    table.add(Stability(), "stability", (0, 0), 1)
    with pytest.raises(ValueError, match="two blocks"):
        table.add(Stability(), "stability", (0,), 2)


def test_block_names_can_be_pickled(designs):
    name = next(iter(designs["gamma"].margins))
    again = pickle.loads(pickle.dumps(name))
    assert again == name and again.vertices == name.vertices


def test_keywords_and_objects_say_the_same():
    both = dict(
        region=sos.PoleRegion(0.3, 1.2, 30),
        gamma=sos.HInfinity(0.8, mu=2.0),
        saturation=REQUIREMENTS["u_max"],
        requirements=[REQUIREMENTS["cost"]],
    )
    by_name = Request(PLANTS, **both)
    by_object = Request(
        PLANTS,
        requirements=[
            sos.PoleRegion(0.3, 1.2, 30),
            HInfinity(0.8, 2.0),
            REQUIREMENTS["cost"],
            both["saturation"],
        ],
    )
    P, Y = np.diag([2.0, 3.0]), np.ones((1, 2))
    one, two = (r.blocks(P, Y, own={"J": np.eye(2)}) for r in (by_name, by_object))
    assert list(one) == list(two)
    assert all(np.array_equal(one[n], two[n]) for n in one)
    assert by_object.gamma == 0.8 and by_object.mu == 2.0
    assert by_object.region.sigma == 0.3
    assert by_object.saturation is both["saturation"]


def test_two_of_a_kind_are_refused():
    with pytest.raises(ValueError, match="two requirements are called gamma"):
        sos.design_pid(PLANTS, requirements=[HInfinity(1.0), HInfinity(2.0)])
    with pytest.raises(ValueError, match="must hold Requirement"):
        sos.design_pid(PLANTS, requirements=["gamma"])
    with pytest.raises(ValueError, match="sequence of requirements"):
        sos.design_pid(PLANTS, requirements=3)


# ------------------------------------------------------- what used to crash
def test_a_proven_bound_is_never_rounded_down():
    cost = sos.QuadraticCost(np.eye(2), [[1]], bound=1 + 1e-12)
    assert "below 1.000000000001 " in cost.claim()


CART = sos.SecondOrderSystem(1, 0.1, 1, 1, 1)


def test_two_of_a_kind_are_asked_as_the_error_says():
    """Each advice is followed on the case for which it is printed."""
    first, second = sos.Saturation(3, [1, 0]), sos.Saturation(4, [0, 1])
    with pytest.raises(ValueError, match=r'Saturation\(..., name="of the drive"\)'):
        sos.design_pid(CART, requirements=[first, second])
    second = sos.Saturation(4, [0, 1], name="of the drive")
    both = sos.design_pid(CART, requirements=[first, second])
    assert both.status == "feasible"
    costs = [sos.QuadraticCost(np.eye(2), [[r]], bound=30.0) for r in (1, 2)]
    with pytest.raises(
        ValueError, match=r"analyse_pid\(plant, design.K, requirements="
    ) as said:
        sos.design_pid(CART, requirements=costs)
    assert "another name" not in str(said.value)
    design = sos.design_pid(CART, requirements=costs[1:])
    assert sos.analyse_pid(CART, design.K, requirements=[costs[0]]).status == "feasible"
    regions = [sos.PoleRegion(1), sos.PoleRegion(2)]
    with pytest.raises(ValueError, match=r"PoleRegion\(1\) & PoleRegion\(2\)"):
        sos.design_pid(CART, requirements=regions)
    design = sos.design_pid(CART, region=regions[0] & regions[1])
    assert design.status == "feasible" and design.poles().real.max() < -2
    norms = [sos.HInfinity(3.0), sos.HInfinity(4.0)]
    with pytest.raises(ValueError, match="another name"):
        sos.design_pid(CART, requirements=norms)
    norms[1] = sos.HInfinity(4.0, name="other")
    assert sos.design_pid(CART, requirements=norms).status == "feasible"


def test_a_sector_is_named_where_a_searched_gain_breaks_it():
    """A motor, a shaft and loads; PD on the motor damps some too little."""
    k = [[3.6, -3.6], [-3.6, 3.6]]

    def drive(J):
        return sos.SecondOrderSystem(
            [[1e-3, 0], [0, J]], np.zeros((2, 2)), k, [[1], [0]]
        )

    plants = sos.Uncertain(drive, J=(5e-4, 2e-3))
    law = sos.PIDLaw(position=[[1, 0]], velocity=[[1, 0]])
    region = sos.PoleRegion(theta_deg=75)
    design = sos.design_pid(
        plants, law=law, region=region, maximize="sigma", search=sos.Search(starts=2)
    )
    assert design.status == "undecided" and "alpha" not in design.reason
    assert "its poles lie in the sector of half-angle 75 degrees" in design.reason


@pytest.mark.parametrize("noise", ["F", *campaign(["states"])])
def test_a_law_of_least_cost_is_asked_in_two_ways(noise):
    law, cost = sos.PIDLaw([[1]], velocity=[[1]]), (np.eye(2), [[1]], noise)
    one = sos.design_lqr(CART, *cost[:2], noise=noise, law=law)
    asked = dict(law=law, requirements=[sos.QuadraticCost(*cost)], minimize="cost")
    assert one.certify().proven and (one.K == sos.design_pid(CART, **asked).K).all()
    best = sos.design_lqr(CART, *cost[:2], noise=noise)  # of the whole state, as here
    assert one.request.cost.bound == pytest.approx(best.request.cost.bound, rel=0.03)
    same = sos.design_lqr(CART, *cost[:2], noise=noise, law=sos.FullState())
    assert (same.K == best.K).all()
    with pytest.raises(ValueError, match="coupling='slack': a law's loop"):
        sos.design_lqr(CART, *cost[:2], law=law, coupling="slack")
