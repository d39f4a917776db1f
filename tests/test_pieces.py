"""Designs of families with powers: ranges are cut while the bound falls."""

from time import monotonic

import numpy as np
import pytest

import sosbook as sos
from sosbook.plants import descriptors
from sosbook.runtime.time_limit import OutOfTime
from sosbook.synthesis import families as pieces
from tests.cases import campaign, later
from tests.test_uncertain import bicycle, drive

BICYCLES = sos.Uncertain(bicycle, v=(1, 10))
START = np.radians([2, 0, 0, 0])
SLOW = sos.PoleRegion(sigma=0.3)


def least(plants, coupling="slack", **how):
    limit = sos.Saturation(None, START)
    asked = dict(region=SLOW, saturation=limit, minimize="u_max", coupling=coupling)
    return sos.design_pid(plants, **asked, **how)


def in_one_piece(monkeypatch, *given, **how):
    with monkeypatch.context() as patch:
        patch.setattr(pieces, "MOST_VERTICES", 0)
        return least(*given, **how)


def check(plants, design):
    """Random plants of the family, by eigenvalues and simulated peaks."""
    proof = design.certify()
    assert proof.proven and " plant with v in [" in proof.claims[0]
    loops = [d for p in plants.sample(20, 4) for d in descriptors(p)]
    for r in design.request.demands:
        assert r.kept(r.truth(loops, proof.K)) > 0


def test_what_cuts_have_overtaken_is_said_no_more():
    """In one piece a vertex is unstable that is no plant."""
    plants = sos.Uncertain(
        lambda v: sos.SecondOrderSystem(1, 0.5 + 4 * (v - 0.4) ** 2, 2, 1), v=(0, 1)
    )
    asked = dict(region=sos.PoleRegion(sigma=0.2), coupling="pairs")
    found = sos.analyse_pid(plants, [[0, 0]], **asked)
    assert found.status == "feasible" and found.reason == ""


# "auto" takes a slack matrix, too
@pytest.mark.parametrize("coupling", ["pairs", *campaign(["slack", "auto"])])
def test_cuts_lower_the_bound_of_a_bicycle(coupling, monkeypatch):
    whole = in_one_piece(monkeypatch, BICYCLES, coupling)
    cut = least(BICYCLES, coupling)
    family = cut.request.plant.family
    assert whole.request.plant.family.pieces == {"v": 1}
    assert family.pieces["v"] > 1 and family.count <= pieces.MOST_VERTICES
    u_max = cut.request.saturation.u_max
    if whole.status == "feasible":
        assert u_max < 0.6 * whole.request.saturation.u_max
    assert BICYCLES.pieces == {"v": 1}  # what was given stays as it is
    check(BICYCLES, cut)
    assert cut.request.coupling.word == ("pairs" if coupling == "pairs" else "slack")


def test_what_was_found_before_the_time_was_over_is_kept(monkeypatch):
    class Late:
        def polytope(self):
            raise OutOfTime(end=monotonic())

    monkeypatch.setattr(pieces, "_cuts", lambda family: [Late()])
    assert least(BICYCLES, "pairs").certify().proven


def test_cuts_stop_where_they_help_no_more():
    design = least(sos.Uncertain(bicycle, v=(3, 7)), "pairs")
    assert design.request.plant.family.pieces == {"v": 1}


@pytest.mark.parametrize("coupling, most", [("pairs", 400.0), *later(("slack", 200.0))])
def test_what_one_piece_cant_do_some_can(coupling, most, monkeypatch):
    limit = sos.Saturation(most, START)
    asked = dict(region=SLOW, saturation=limit, coupling=coupling)
    with monkeypatch.context() as patch:
        patch.setattr(pieces, "MOST_VERTICES", 0)
        assert sos.design_pid(BICYCLES, **asked).status != "feasible"
    design = sos.design_pid(BICYCLES, **asked)
    assert design.status == "feasible" and design.certify().proven
    assert design.request.plant.family.pieces["v"] > 1


def test_corners_are_not_cut():
    plants = sos.Uncertain(drive, J2=(0.003, 0.006), k=(1.7, 2.1))
    wish = sos.PoleRegion(sigma=1)
    limit = sos.Saturation(None, [0.1, 0, 0, 0])
    design = sos.design_pid(plants, region=wish, saturation=limit, minimize="u_max")
    assert design.request.plant is plants.polytope()


STRAIGHT = {
    "a square alone": (lambda a: (1, a * a), dict(a=(1, 3)), True),
    "a product": (
        lambda m, r: (0.01 + m * r * r, 1),
        dict(m=(0, 2), r=(0.05, 0.1)),
        True,
    ),
    "two squares": (lambda a, b: (a * a, b * b), dict(a=(1, 3), b=(0.3, 9.81)), True),
    "a parabola": (lambda v: (v, v * v), dict(v=(0.3, 1)), False),
    "through zero": (lambda a: (1, a * a), dict(a=(-1, 3)), False),
}


@pytest.mark.parametrize("name", STRAIGHT)
def test_ranges_are_cut_only_where_the_hull_may_come_nearer(name):
    """By the area or length of the hull of D and S at many plants and at vertices."""
    both, ranges, straight = STRAIGHT[name]

    def builder(**values):
        D, S = both(**values)
        return sos.SecondOrderSystem(1, D, S, 1)

    plants = sos.Uncertain(builder, **ranges)
    assert plants.straight is straight
    vertices = np.array([(v.D.item(), v.S.item()) for v in plants.vertices])
    grid = np.meshgrid(*(np.linspace(*ends, 60) for ends in ranges.values()))
    some = [np.ravel(x) for x in both(*grid)]
    inside = np.column_stack([np.broadcast_to(x, grid[0].size) for x in some])
    for turn in np.linspace(0, np.pi, 50):  # the hulls' extent in each direction
        way = np.array([np.cos(turn), np.sin(turn)])
        extents = [np.ptp(points @ way) for points in (vertices, inside)]
        assert extents[0] >= extents[1] - 1e-9
        if straight:
            assert extents[0] == pytest.approx(extents[1], rel=1e-9)


def test_a_product_of_two_ranges_is_not_cut():
    """J = 0.01 + m r^2 has six vertices; those of its two ends give the same bound."""

    def table(m, r):
        J, k = 0.01 + m * r**2, [[10, -10], [-10, 10]]
        D = [[0.03, -0.01], [-0.01, 0.01]]
        return sos.SecondOrderSystem([[0.01, 0], [0, J]], D, k, [[1], [0]])

    plants = sos.Uncertain(table, m=(0, 2), r=(0.05, 0.1))
    limit = sos.Saturation(None, [0.1, 0.1, 0, 0])
    asked = dict(region=sos.PoleRegion(sigma=5, rho=200), saturation=limit)
    assert not pieces._cuts(plants) and pieces._cuts(BICYCLES)
    ends = sos.Polytope([table(0, 0.1), table(2, 0.1)])
    several = [sos.design_pid(p, minimize="u_max", **asked) for p in (plants, ends)]
    bounds = [d.request.saturation.u_max for d in several]
    assert bounds[0] == bounds[1] and all(d.certify().proven for d in several)
