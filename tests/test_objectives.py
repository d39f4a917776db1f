"""Smallest bounds, warm starts, many vertices."""

from itertools import product

import cvxpy
import numpy as np
import pytest
from numpy.testing import assert_allclose

import sosbook as sos
from sosbook.book import thesis
from sosbook.synthesis import cutting
from sosbook.synthesis.request import Request


def without(example, *names):
    return {k: v for k, v in example.requirements.items() if k not in names}


@pytest.mark.filterwarnings("ignore:Solution may be inaccurate")  # on some processors
def test_the_smallest_u_max_is_cvxpys(robot):
    """min u_max^2 over the same blocks, by Clarabel."""
    x0 = robot.saturation.x0
    asked = without(robot, "saturation")
    d = sos.design_pid(
        robot.plant,
        **asked,
        saturation=sos.Saturation(None, x0),
        minimize="u_max",
        search=sos.Search(backoff=1e-4),
    )
    P, Y = cvxpy.Variable((6, 6), symmetric=True), cvxpy.Variable((2, 6))
    square = cvxpy.Variable((1, 1))
    request = Request(robot.plant, **asked, saturation=sos.Saturation(1.0, x0))
    scale = 1e4
    blocks = request.blocks(P, 100 * Y, levels={"u_max": scale * square})
    problem = cvxpy.Problem(
        cvxpy.Minimize(square[0, 0]), [(g + g.T) / 2 >> 0 for g in blocks.values()]
    )
    problem.solve(solver="CLARABEL")
    assert_allclose(
        d.request.saturation.u_max, np.sqrt(scale * square.value[0, 0]), rtol=1e-2
    )
    assert d.peak_input() <= d.request.saturation.u_max
    assert d.certify().proven


def test_weights_trade_gamma_against_u_max(robot):
    """The more u_max weighs, the smaller it is and the larger gamma."""
    x0 = robot.saturation.x0
    asked = without(robot, "saturation", "gamma")
    found = [
        sos.design_pid(
            robot.plant,
            **asked,
            saturation=sos.Saturation(None, x0),
            minimize={"gamma": 1.0, "u_max": weight},
        ).request
        for weight in (1e-5, 1e-3)
    ]
    assert found[1].saturation.u_max < found[0].saturation.u_max
    assert found[1].gamma > found[0].gamma


@pytest.mark.parametrize(
    "more, words",
    [
        (dict(minimize="speed"), "must be None"),
        (dict(minimize={}), "must be None"),
        (dict(minimize="u_max"), "needs saturation"),
        (dict(minimize={"gamma": -1}), "minimize"),
        (dict(minimize="u_max", saturation=sos.Saturation(1, np.ones(6))), "not both"),
        (dict(saturation=sos.Saturation(None, np.ones(6))), "u_max is None"),
    ],
)
def test_bad_objectives(robot, more, words):
    with pytest.raises(ValueError, match=words):
        sos.design_pid(robot.plant, U=robot.U, **more)


def test_a_warm_start_of_what_is_infeasible_is_the_cold_answer(robot):
    first = sos.design_pid(robot.plant, **robot.requirements)
    asked = dict(robot.requirements, gamma=sos.HInfinity(0.1, mu=1.0))
    warm = sos.design_pid(robot.plant, **asked, search=sos.Search(start=first))
    cold = sos.design_pid(robot.plant, **asked)
    assert warm.status == cold.status == "infeasible"
    assert warm.infeasibility.value == cold.infeasibility.value
    again = sos.design_pid(
        robot.plant, **robot.requirements, search=sos.Search(start=cold)
    )
    assert_allclose(again.K, first.K, rtol=1e-10)


def test_a_start_of_another_shape_is_refused(robot):
    first = sos.design_pid(robot.plant, **robot.requirements)
    seat = thesis.example_2()
    with pytest.raises(ValueError, match="start has other sizes"):
        sos.design_pid(seat.plant, **seat.requirements, search=sos.Search(start=first))


def many(gamma):
    """Two masses, springs and dampers uncertain: 32 vertices."""
    vertices = []
    for s1, s2, s3, d1, d2 in product((-1, 1), repeat=5):
        k1, k2, k3 = 2 + 0.4 * s1, 1 + 0.3 * s2, 2 + 0.4 * s3
        vertices.append(
            sos.SecondOrderSystem(
                np.eye(2),
                np.diag([0.4 + 0.1 * d1, 0.4 + 0.1 * d2]),
                [[k1 + k2, -k2], [-k2, k2 + k3]],
                np.eye(2),
                np.eye(2),
            )
        )
    region = sos.PoleRegion(sigma=0.5, rho=8)
    return sos.Polytope(vertices), dict(U=np.eye(2), region=region, gamma=gamma)


def test_a_cutting_plane_over_vertices_changes_nothing(monkeypatch):
    plant, asked = many(0.5)
    found = sos.design_pid(plant, **asked)
    monkeypatch.setattr(cutting, "CUTTING_PLANE_ABOVE_PAIRS", 10**6)
    wanted = sos.design_pid(plant, **asked)
    assert found.status == wanted.status == "feasible"
    assert len(found.margins) == len(wanted.margins)
    assert_allclose(found.K, wanted.K, rtol=1e-6)
    assert found.hinf(samples=20) < 0.5
