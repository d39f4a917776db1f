"""Designs of families with powers: ranges are cut while the bound falls."""

import numpy as np
import pytest

import sosbook as sos
from sosbook.plants import descriptors
from sosbook.synthesis import slack as pieces
from tests.cases import campaign
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


def check(plants, proof, u_max):
    """Random plants of the family, by eigenvalues and simulated peaks."""
    assert proof.proven and proof.claims[0].startswith("every constant plant with v in")
    request = sos.design_pid(
        plants, region=SLOW, saturation=sos.Saturation(u_max, START), coupling="slack"
    ).request
    loops = [d for p in plants.sample(20, 4) for d in descriptors(p)]
    for r in request.demands:
        assert r.kept(r.truth(loops, proof.K)) > 0


def test_what_cuts_have_overtaken_is_said_no_more():
    """In one piece a vertex is unstable that is no plant."""
    plants = sos.Uncertain(
        lambda v: sos.SecondOrderSystem(1, 0.5 + 4 * (v - 0.4) ** 2, 2, 1), v=(0, 1)
    )
    asked = dict(region=sos.PoleRegion(sigma=0.2), coupling="pairs")
    found = sos.analyse_pid(plants, [[0, 0]], **asked)
    assert found.status == "feasible" and found.reason == ""


@pytest.fixture(scope="module")
def quick():
    """The least force for a bicycle at any speed."""
    return least(BICYCLES, "auto")


# "auto" takes a slack matrix, too
@pytest.mark.parametrize("coupling", ["pairs", "auto", *campaign(["slack"])])
def test_cuts_lower_the_bound_of_a_bicycle(coupling, quick, monkeypatch):
    whole = in_one_piece(monkeypatch, BICYCLES, coupling)
    cut = quick if coupling == "auto" else least(BICYCLES, coupling)
    family = cut.request.plant.family
    assert whole.request.plant.family.pieces == {"v": 1}
    assert family.pieces["v"] > 1 and family.count <= pieces.MOST_VERTICES
    u_max = cut.request.saturation.u_max
    if whole.status == "feasible":
        assert u_max < 0.6 * whole.request.saturation.u_max
    assert BICYCLES.pieces == {"v": 1}  # what was given stays as it is
    check(BICYCLES, cut.certify(), u_max)
    assert cut.request.coupling == ("pairs" if coupling == "pairs" else "slack")


def test_cuts_stop_where_they_help_no_more():
    design = least(sos.Uncertain(bicycle, v=(3, 7)))
    assert design.request.plant.family.pieces == {"v": 1}


def test_what_one_piece_cant_do_some_can(monkeypatch):
    asked = dict(region=SLOW, saturation=sos.Saturation(200.0, START), coupling="slack")
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


@pytest.mark.slow
def test_what_was_found_before_the_time_was_over_is_kept(quick):
    assert quick.status == "feasible"
    u_max = quick.request.saturation.u_max
    short = least(BICYCLES, time_limit=2)
    if short.status == "feasible":
        assert short.request.saturation.u_max >= 0.99 * u_max
        assert short.certify().proven
