"""Blocks that are read at once, against their products written out."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import sosbook as sos
from sosbook.delay.request import DelayRequest
from sosbook.lmi.trusted import TrustedProblem
from sosbook.solver.blocks import Blocks
from sosbook.solver.evaluated import EvaluatedBlocks, unit_readings
from sosbook.synthesis.request import Request
from sosbook.synthesis.scaled_lmis import ScaledLMIs
from sosbook.synthesis.scaling import Frame
from tests.energy_to_peak import EnergyToPeak

ROBOT = sos.thesis.example_1()
X0 = [1.0, 0, 0, 0, 0, 0]
ASKED = {
    "regions": dict(region=ROBOT.requirements["region"]),
    "sizes": dict(gamma=2.0, saturation=sos.Saturation(9.0, X0)),
    "tied": dict(gamma=2.0, mu=1.0, saturation=sos.Saturation(9.0, X0)),
    "cost": dict(cost=sos.QuadraticCost(np.eye(6), np.eye(2), bound=90.0), gamma=2.0),
    "slack": dict(gamma=2.0, coupling="slack", slack=0.1),
    "gain": dict(gamma=2.0, gain=ROBOT.K),
}


def compare(problem):
    written = Blocks.of(problem.expressions.values(), problem.unknowns)
    values = problem.blocks(unit_readings(problem.unknowns)).values()
    read = EvaluatedBlocks(values, problem.unknowns)
    assert read.variables == written.variables
    for mine, plain in zip(read.constants, written.constants, strict=True):
        assert_allclose(mine, plain, rtol=0, atol=1e-14 * max(abs(plain).max(), 1))
    for mine, plain in zip(read.slopes, written.slopes, strict=True):
        assert_allclose(mine, plain, rtol=0, atol=1e-14 * abs(plain).max())
    for mine, plain in zip(read.diagonal_scales, written.diagonal_scales, strict=True):
        assert np.array_equal(mine, plain)


@pytest.mark.parametrize("kind", ASKED)
def test_requests_are_read_as_they_are_written(kind):
    request = Request(ROBOT.plant, ROBOT.U, **ASKED[kind])
    compare(ScaledLMIs(request, Frame.of(request)))


def test_a_small_constant_beside_large_slopes_is_no_rounding():
    """The square of a bound in megametres is 1e-24 of the other entries."""
    request = Request(ROBOT.plant, ROBOT.U, gamma=1e-11)
    compare(ScaledLMIs(request, Frame.of(request)))


def test_free_levels_are_read_as_they_are_written():
    request = Request(ROBOT.plant, ROBOT.U, **ASKED["sizes"])
    for r in request.requirements:
        compare(ScaledLMIs(request, Frame.of(request), (r,)))


def test_delays_are_read_as_they_are_written():
    request = DelayRequest(ROBOT.plant, tau=0.3, mu=0.1, delta=0.1, alpha=0.5)
    compare(TrustedProblem(request.blocks, request.unknowns()))


def test_requirements_of_others_are_written():
    plant = sos.SecondOrderSystem(1, 1, 1, 1, 1)
    for requirements, at_once in (((), True), ((EnergyToPeak(2.0),), False)):
        request = Request(plant, gamma=2.0, requirements=requirements)
        lmis = ScaledLMIs(request, Frame.of(request))
        assert isinstance(lmis.compiled, EvaluatedBlocks) == at_once


def test_large_problems_keep_their_products():
    one = np.eye(5)
    request = Request(sos.SecondOrderSystem(one, one, one, one, one), gamma=2.0)
    lmis = ScaledLMIs(request, Frame.of(request))
    assert not isinstance(lmis.compiled, EvaluatedBlocks)
