"""Promises that hold for every plant: hypothesis looks for exceptions."""

import numpy as np
import pytest
from hypothesis import event, given, settings
from hypothesis import strategies as st

import sosbook as sos
from sosbook.synthesis.scaling import Frame
from tests import clarabel
from tests.cases import examples, random_request
from tests.random_plants import float_blocks, scaled
from tests.test_slack import keeps_its_promises

few = settings(max_examples=examples(5, 8), derandomize=True, deadline=None)
seeds = st.integers(0, 10**6)


@pytest.mark.slow
@few
@given(seeds)
def test_a_feasible_design_keeps_its_promises(seed):
    """Over the vertices and sampled plants of the polytope."""
    asked = random_request(seed)
    keeps_its_promises(
        sos.design_pid(**asked | {"plant": sos.Polytope(asked["plant"].vertices)})
    )


def scaled_blocks(request):
    """The request's blocks in its frame, entries near one; P > 0 is read as P > I."""
    blocks = float_blocks(request, Frame.of(request))
    if not any(c.any() for c in blocks.constants):
        first = -np.eye(request.order)
        blocks = clarabel.Explicit([first, *blocks.constants[1:]], blocks.slopes)
    return scaled(blocks)


@pytest.mark.slow
@few
@given(seeds)
def test_the_verdict_is_clarabels(seed):
    """And where multipliers are proven, no solver finds a design."""
    d = sos.design_pid(**random_request(seed))
    event(d.status)
    _, t, status = clarabel.deepest(scaled_blocks(d.request))
    if d.status == "undecided":  # no design, and no multipliers in rationals
        assert t < 1e-3
        assert "multipliers exclude all P, Y shorter than" in d.reason
    if status == "Solved" and abs(t) > 1e-4:
        assert (t > 0) == (d.status == "feasible")
    if d.status == "infeasible":
        assert d.infeasibility.proven and t < 1e-6


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
