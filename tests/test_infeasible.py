"""Requests that no gain fulfils: exact proof and useful advice."""

import numpy as np
import pytest
from flint import fmpq

import sosbook as sos
from sosbook.synthesis.scaling import Frame
from sosbook.lmi.centre import Blocks
from sosbook.lmi.exact import exact
from sosbook.synthesis.problem import Request
from sosbook.synthesis.feasibility import closer
from tests.test_certificate import positive_definite

ONE = [[1.0]]


def mass(**changes):
    """z'' = u + w."""
    parts = dict(M=ONE, D=[[0.0]], S=[[0.0]], B=ONE, F=ONE) | changes
    return sos.SecondOrderSystem(**parts)


IMPOSSIBLE = {
    "too little force": (
        dict(plant=mass(D=[[-1.0]], S=ONE),
             saturation=sos.Saturation(0.5, [1, 0])),
        "input bound u_max first",
    ),
    "bound below what u_max allows": (
        dict(plant=mass(), gamma=0.01, saturation=sos.Saturation(1, [1, 0])),
        "H-infinity bound gamma first",
    ),
    "fast with little force": (
        dict(plant=mass(), region=sos.PoleRegion(sigma=3),
             saturation=sos.Saturation(1, [1, 0])),
        "input bound u_max first|decay rate sigma first",
    ),
}


@pytest.mark.parametrize("name", IMPOSSIBLE)
def test_the_certificate_is_a_proof(name):
    """Z > 0, its adjoint is zero, its value isn't positive.

    A design x would give 0 < sum <G_k(x), Z_k> = value <= 0. Checked
    here with rational matrices only.
    """
    asked, _ = IMPOSSIBLE[name]
    d = sos.design_pid(**asked)
    assert d.status == "infeasible"
    assert d.K is None
    proof = d.infeasibility
    assert proof.proven
    expressions, unknowns = d.request.in_unknowns(d.frame, exact)
    assert set(proof.multipliers) == set(expressions)
    blocks = Blocks.of(expressions.values(), unknowns)
    Z = [proof.multipliers[name] for name in expressions]
    for z in Z:
        assert (z == z.T).all()
        assert positive_definite(z)
    for a in range(blocks.variables):
        pairs = zip(blocks.slopes, Z)
        assert sum((fmpq(1) * s[a] * z).sum() for s, z in pairs) == 0
    value = sum((c * z).sum() for c, z in zip(blocks.constants, Z))
    assert value <= 0
    assert float(value) == proof.value


@pytest.mark.parametrize("name", IMPOSSIBLE)
def test_following_the_advice_helps(name):
    asked, words = IMPOSSIBLE[name]
    d = sos.design_pid(**asked)
    first = d.advice.split(";")[0]
    assert any(w in first for w in words.split("|"))
    key = {"u_max": "saturation", "gamma": "gamma", "sigma": "region"}
    left_out = next(k for w, k in key.items() if w in first)
    rest = {k: v for k, v in asked.items() if k != left_out}
    assert sos.design_pid(**rest).certify().proven


@pytest.mark.slow
@pytest.mark.parametrize("change, words", [
    (dict(saturation=sos.Saturation(20, [.2, .2, .8, .8, .1, .1])),
     "input bound u_max first"),
    (dict(region=sos.PoleRegion(0.7, np.pi / 4, 0.75)),
     "disk radius rho first"),
    (dict(gamma=0.05), "H-infinity bound gamma first"),
])
def test_example_1_asked_too_much(change, words):
    ex = sos.thesis.example_1()
    d = sos.design_pid(ex.plant, **ex.requirements | change)
    assert d.status == "infeasible"
    assert d.infeasibility.proven
    assert words in d.advice


def test_the_limit_of_the_force_is_where_physics_puts_it():
    """z'' = z + u, |u| <= u_max from z(0) = 1: u_max = 1 is the limit."""
    def status(u_max):
        limit = sos.Saturation(u_max, [1, 0])
        return sos.design_pid(mass(S=[[-1.0]]), saturation=limit).status

    assert status(0.99) == "infeasible"
    assert status(4.0) == "feasible"


def test_a_mode_out_of_reach_is_named():
    plant = sos.SecondOrderSystem(
        np.eye(2), np.diag([1, -1]), np.eye(2), [[1], [0]])
    d = sos.design_pid(plant)
    assert d.status == "infeasible"
    assert "uncontrollable" in d.advice
    assert "0.5" in d.advice


def test_masses_of_both_signs_between_the_vertices():
    """M = 0 halfway: infeasible, not an error."""
    plants = sos.Polytope([mass(S=ONE), mass(M=[[-1.0]], S=ONE)])
    assert sos.design_pid(plants).status == "infeasible"


def test_contradicting_regions():
    """Two half-planes that share a name are both kept."""
    strip = sos.LMIRegion.half_plane(1) & sos.LMIRegion(
        [[1]], [[-1]], "half-plane")  # Re s > 0.5
    d = sos.design_pid(mass(), region=strip)
    assert d.status == "infeasible"


def test_an_unstable_gain_has_no_certificate():
    d = sos.analyse_pid(mass(), [[-1.0, 1.0]])
    assert d.status == "infeasible"
    assert "this gain" in d.advice
    assert d.infeasibility.proven


def test_singular_multipliers_are_not_called_a_proof():
    """With one stable mode each multiplier has to be singular."""
    d = sos.analyse_pid(mass(), [[1.0, 0.0]])
    assert d.status == "infeasible"
    assert not d.infeasibility.proven


def test_asking_an_infeasible_design_for_its_gain():
    d = sos.design_pid(**IMPOSSIBLE["too little force"][0])
    for ask in (lambda: d.K_P, d.certify, d.poles, d.closed_loop):
        with pytest.raises(ValueError, match="the design is infeasible"):
            ask()


@pytest.mark.parametrize("share", [0.999, 0.99, 0.9])
def test_a_bound_just_below_the_norm_is_proven_impossible(share):
    robot = sos.thesis.example_1()
    norm = sos.analyse_pid(robot.plant, robot.K, robot.U).hinf()
    below = sos.analyse_pid(
        robot.plant, robot.K, robot.U, gamma=share * norm
    )
    assert below.status == "infeasible"
    assert below.infeasibility.proven


def test_a_point_without_direction_keeps_the_frame():
    """Where the least infeasible P isn't positive in any direction."""
    request = Request(mass())
    frame = Frame.of(request)
    _, unknowns = request.in_unknowns(frame)
    for size in (0.0, -1.0):
        P = size * np.eye(2)
        near = np.concatenate([unknowns[0].pack(P), np.zeros(2)])
        assert closer(request, frame, unknowns, near) is frame
