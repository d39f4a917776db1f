"""Promises that hold for every plant: hypothesis looks for exceptions."""

import numpy as np
import pytest
from hypothesis import event, given, settings
from hypothesis import strategies as st

import sosbook as sos
from sosbook.analysis.linear import hinf_norm, peak_input, poles
from sosbook.plants.descriptor import descriptors
from sosbook.synthesis.certificates import DesignRefusal
from tests import clarabel
from tests.cases import random_request
from tests.test_conic import scaled_blocks

few = settings(max_examples=25, derandomize=True, deadline=None)
seeds = st.integers(0, 10**6)


@pytest.mark.slow
@few
@given(seeds)
def test_a_feasible_design_keeps_its_promises(seed):
    """Over the vertices and sampled plants of the polytope."""
    asked = random_request(seed)
    d = sos.design_pid(**asked)
    event(d.status)
    if d.status != "feasible":
        assert d.K is None
        return
    assert d.certify(12).proven
    plant, U = asked["plant"], asked.get("U")
    inside = [*plant.vertices]
    if len(inside) > 1:
        inside += [plant.mean, *plant.sample(5, seed=1)]
    for v in inside:
        (e,) = descriptors(v, U)
        found = poles(e, d.K)
        assert found.real.max() < 0
        if "region" in asked:
            assert asked["region"].contains(found)
        if d.gamma is not None:
            assert hinf_norm(e, d.K) < d.gamma
        if "saturation" in asked:
            limit = asked["saturation"]
            assert peak_input(e, d.K, limit.x0) <= limit.u_max


@pytest.mark.slow
@few
@given(seeds)
def test_the_verdict_is_clarabels(seed):
    d = sos.design_pid(**random_request(seed))
    _, t, status = clarabel.deepest(scaled_blocks(d.request))
    if d.status == "undecided":  # no design, and no multipliers in rationals
        assert t < 1e-3
        assert "multipliers exclude all P, Y shorter than" in d.reason
    if status == "Solved" and abs(t) > 1e-4:
        assert (t > 0) == (d.status == "feasible")


@pytest.mark.slow
@few
@given(seeds)
def test_relaxing_a_request_keeps_it_feasible(seed):
    asked = random_request(seed)
    if sos.design_pid(**asked).status != "feasible":
        return
    if "gamma" in asked:
        asked["gamma"] *= 1.1
    if "saturation" in asked:
        limit = asked["saturation"]
        asked["saturation"] = sos.Saturation(1.1 * limit.u_max, 0.9 * limit.x0)
    if "region" in asked:
        given_ = asked["region"]
        asked["region"] = sos.PoleRegion(
            given_.sigma and 0.9 * given_.sigma,
            given_.theta and min(1.05 * given_.theta, np.pi / 2),
            given_.rho and 1.1 * given_.rho,
        )
    assert sos.design_pid(**asked).status == "feasible"


@pytest.mark.slow
@few
@given(seeds)
def test_an_exact_proof_of_infeasibility_is_never_wrong(seed):
    """If multipliers are proven, no solver may find a design."""
    d = sos.design_pid(**random_request(seed))
    if d.status == "infeasible" and d.infeasibility.proven:
        event("proven infeasible")
        if isinstance(d.infeasibility, DesignRefusal):  # by multipliers
            assert d.infeasibility.value <= 0
        _, t, _ = clarabel.deepest(scaled_blocks(d.request))
        assert t < 1e-6
