"""Verdicts and bounds against Clarabel, on the same blocks."""

import numpy as np
import pytest

import sosbook as sos
from sosbook.lmi import Unknown
from sosbook.solver.blocks import Blocks
from sosbook.synthesis.request import Request
from sosbook.synthesis.scaling import Frame
from tests import clarabel


def scaled_blocks(request):
    """The request's blocks in its frame, entries near one."""
    frame = Frame.of(request)
    expressions, unknowns = request.in_unknowns(frame)
    blocks = Blocks(expressions.values(), unknowns)
    if not any(c.any() for c in blocks.constants):  # read P > 0 as P > I
        first = -np.eye(request.order)
        blocks = blocks.with_constants([first] + blocks.constants[1:])
    return scaled(blocks)


def scaled(blocks):
    """A diagonal congruence that brings the entries near one."""
    outer = [np.outer(d, d) for d in blocks.diagonal_scales]
    return clarabel.Explicit(
        [c * o for c, o in zip(blocks.constants, outer)],
        [s * o for s, o in zip(blocks.slopes, outer)],
    )


def smallest_gamma(plant, asked):
    """Clarabel's infimum of gamma, in coordinates where P is near I."""
    near = sos.design_pid(plant, minimize="gamma", **asked)
    request = Request(plant, gamma=1.0, **asked)
    mean = np.mean([d.E for d in request.vertices], axis=0)
    T = np.linalg.cholesky(near.P)
    frame = Frame(
        np.linalg.inv(mean @ T), T, np.linalg.inv(T), np.linalg.norm(near.K @ T, 2)
    )
    g, unit = Unknown("gamma2", 1), near.gamma**2
    expressions, unknowns = request.in_unknowns(frame, levels={"gamma": g * unit})
    blocks = Blocks(expressions.values(), unknowns + [g])
    blocks = scaled(blocks)
    cost = np.zeros(blocks.variables)
    cost[-1] = 1.0
    x, status = clarabel.minimize(blocks, cost)
    assert status in ("Solved", "AlmostSolved")
    return near, np.sqrt(x[-1] * unit)


def example_1():
    ex = sos.thesis.example_1()
    return ex.plant, dict(U=ex.U, region=ex.region, saturation=ex.saturation)


def car_seat_pair():
    seat = sos.thesis.example_2()
    plants, asked = seat.plant, seat.requirements
    del asked["gamma"]
    return plants, asked


@pytest.mark.parametrize("case", [example_1, car_seat_pair])
def test_smallest_gamma(case):
    """Ours is Clarabel's infimum, one percent backed off, rounded up."""
    design, wanted = smallest_gamma(*case())
    assert design.certify().proven
    assert 1.0099 * wanted < design.gamma < 1.02 * wanted
