"""Requests that no gain fulfils: exact proof and useful advice."""

import numpy as np
import pytest
from flint import fmpq_mat

import sosbook as sos
from sosbook.book import counterexamples, thesis
from sosbook.exact.checker import verdict
from sosbook.exact.checker.verdict import check
from sosbook.exact.definite import exact
from sosbook.runtime.time_limit import OutOfTime
from sosbook.synthesis import objectives
from sosbook.synthesis.feasibility import closer
from sosbook.synthesis.request import Request
from sosbook.synthesis.scaled_lmis import ScaledLMIs
from sosbook.synthesis.scaling import Frame
from tests.attacks import placed
from tests.cases import campaign, crossed, later
from tests.closed import analyse_loop

ONE = [[1.0]]


def mass(**changes):
    """z'' = u + w."""
    parts = dict(M=ONE, D=[[0.0]], S=[[0.0]], B=ONE, F=ONE) | changes
    return sos.SecondOrderSystem(**parts)


IMPOSSIBLE = {
    "too little force": (
        dict(plant=mass(D=[[-1.0]], S=ONE), saturation=sos.Saturation(0.5, [1, 0])),
        "input bound u_max first",
    ),
    "bound below what u_max allows": (
        dict(plant=mass(), gamma=0.01, saturation=sos.Saturation(1, [1, 0])),
        "H-infinity bound gamma first",
    ),
    "fast with little force": (
        dict(
            plant=mass(),
            region=sos.PoleRegion(sigma=3),
            saturation=sos.Saturation(1, [1, 0]),
        ),
        "input bound u_max first|decay rate sigma first",
    ),
}


@pytest.mark.parametrize("name", IMPOSSIBLE)
def test_the_certificate_is_a_proof(name):
    """Z > 0, adjoint 0, value <= 0: a design would give 0 < sum <G_k, Z_k> = value."""
    asked, _ = IMPOSSIBLE[name]
    d = sos.design_pid(**asked)
    assert d.status == "infeasible" and d.K is None
    proof = d.infeasibility
    assert proof.proven and proof.value <= 0
    assert set(proof.multipliers) == set(d.request.in_unknowns(d.frame)[0])
    assert verdict.check(proof.text) == list(proof.claims)


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
@pytest.mark.parametrize(
    "change, words",
    [
        (dict(gamma=sos.HInfinity(0.05, mu=1.0)), "Leave out mu = 1 first"),
        *later(
            (
                dict(saturation=sos.Saturation(20, [0.2, 0.2, 0.8, 0.8, 0.1, 0.1])),
                "input bound u_max first",
            ),
            (
                dict(region=sos.PoleRegion(0.7, np.pi / 4, 0.75)),
                "disk radius rho first",
            ),
            (dict(gamma=sos.HInfinity(0.005, mu=None)), "H-infinity bound gamma first"),
        ),
    ],
)
def test_example_1_asked_too_much(change, words):
    ex = thesis.example_1()
    d = sos.design_pid(ex.plant, **ex.requirements | change)
    assert d.status == "infeasible"
    assert d.infeasibility.proven
    assert words in d.advice


def test_the_limit_of_the_force_is_where_physics_puts_it():
    """z'' = z + u, z(0) = 1: u_max = 1; one mode alone has regular multipliers."""

    def design(u_max):
        limit = sos.Saturation(u_max, [1, 0])
        return sos.design_pid(mass(S=[[-1.0]]), saturation=limit)

    low = design(0.999)
    assert low.status == "infeasible" and low.infeasibility.verify()
    assert "u_max = 0.999 is too small to move the modes at 1 rad/s" in low.reason
    assert design(1.001).status == "feasible"


def test_masses_of_both_signs_between_the_vertices():
    """M = 0 halfway: infeasible, not an error."""
    plants = sos.Polytope([mass(S=ONE), mass(M=[[-1.0]], S=ONE)])
    d = sos.design_pid(plants)
    assert d.status == "infeasible"
    assert d.infeasibility.proven and d.infeasibility.vertices == (0, 1)
    assert "between the vertices 1 and 2" in d.reason.lower()
    alone = sos.design_pid(plants, coupling="vertices")
    assert "singular" not in alone.reason  # only the vertices count there


def test_a_hull_that_holds_a_plant_without_mass():
    """The determinants agree at both ends and are zero halfway."""
    turn = np.array([[0, 1], [-1, 0]])
    one = np.eye(2)
    plants = sos.Polytope(
        [sos.SecondOrderSystem(s * turn, *3 * [one]) for s in (1, -1)]
    )
    d = sos.design_pid(plants)
    assert d.status == "infeasible" and d.infeasibility.proven


@pytest.mark.parametrize("mass, spring", crossed([1.0, 2.0, 0.5], [10.0, 20.0]))
def test_a_loop_without_inputs_is_refused_by_exact_multipliers(mass, spring):
    # Every plant is stable, but the two vertices share no P.
    A = [np.array([[0.0, 1.0], [-k, -0.1]]) for k in (1.0, spring)]
    E = [np.eye(2), np.diag([1.0, mass])]
    assert analyse_loop(E, A).certify().proven  # with P for each vertex
    found = analyse_loop(E, A, coupling="pairs")
    assert found.status == "infeasible"
    assert "Exact multipliers" in found.reason
    assert found.infeasibility.proven


def test_an_unstable_gain_is_refused_by_its_own_pole():
    d = sos.analyse_pid(mass(), [[-1.0, 1.0]])
    assert d.status == "infeasible"
    assert "this gain" in d.advice.lower()
    assert d.infeasibility.proven
    assert np.isclose(d.infeasibility.mode, 0.5 + np.sqrt(0.75) * 1j)


@pytest.mark.parametrize(
    "plant, mode",
    [
        # equal modes of two masses that are pushed alike: one stays at rest
        (([[1, 0], [0, 1]], 0.01, [[1, 0], [0, 1]], [[1], [1]]), -0.005),
        # the difference of the coordinates isn't pushed
        (([[1, 0], [0, 1]], 0.01, [[2, -0.3], [-0.3, 2]], [[1], [1]]), -0.005),
        # nor is it at rest: a mode on the imaginary axis, by no rounding
        (([[1, 0], [0, 1]], 0, [[2, -0.3], [-0.3, 2]], [[1], [1]]), 0.0),
    ],
)
def test_a_hidden_mode_is_found_exactly(plant, mode):
    M, damping, S, B = plant
    plant = sos.SecondOrderSystem(M, damping * np.eye(2), S, B)
    d = sos.design_pid(plant, region=sos.PoleRegion(sigma=1))
    assert d.status == "infeasible"
    proof = d.infeasibility
    assert proof.proven and np.isclose(proof.mode.real, mode, atol=1e-15)
    (v,) = d.request.vertices_in(exact)
    V, L = proof.part.rows, proof.part.dynamics
    E, A, B = (fmpq_mat(*x.shape, list(x.ravel())) for x in (v.E, v.A, v.Bu))
    assert V * A == L * V * E
    assert V * B == 0 * (V * B)
    assert V.rank() == V.nrows() > 0


def test_a_controllable_plant_is_feasible_for_its_poles():
    """A chain of unit masses with one force on its first."""
    n = 8
    S = 2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    plant = sos.SecondOrderSystem(np.eye(n), np.zeros((n, n)), S, np.eye(n)[:, :1])
    d = sos.design_pid(plant, region=sos.PoleRegion(sigma=3))
    assert d.status == "feasible"
    assert d.certify().proven


@pytest.mark.parametrize("gap", [1e-6, 1e-8, 1e-12])
def test_two_masses_that_are_nearly_alike(gap):
    """One force moves both: a gain of size 1 / gap, too large for floats, is there."""
    S = np.diag([1, 1 + gap])
    plant = sos.SecondOrderSystem(np.eye(2), 0.01 * np.eye(2), S, [[1], [1]])
    d = sos.design_pid(plant, region=sos.PoleRegion(sigma=1))
    if gap < 1e-7:
        assert d.status == "undecided" and "no exact proof" in d.reason
        return
    assert d.status == "feasible" and d.certify().proven
    assert d.poles().real.max() < -1


@pytest.mark.parametrize("gap", [1e-13, *campaign([1e-6, 1e-9, 1e-12])])
def test_a_mass_that_is_nearly_singular(gap):
    """Neither a design without a gain nor a mode that doesn't exist."""
    one = np.eye(2)
    plant = sos.SecondOrderSystem(
        [[1, 1], [1, 1 + gap]], 0.1 * one, [[6, -2], [-2, 4]], one, one
    )
    d = sos.design_pid(plant, region=sos.PoleRegion(sigma=0.5))
    assert d.status != "infeasible"
    if d.status == "feasible":
        assert d.K is not None
    elif d.K is not None:
        assert min(d.margins.values()) > -1e-6
    assert "uncontrollable" not in d.advice


def test_a_mode_out_of_reach_stops_the_least_cost_too():
    plant = sos.SecondOrderSystem(np.eye(2), np.eye(2), np.diag([1, -1]), [[1], [0]])
    d = sos.design_lqr(plant, np.eye(4), [[1]])
    assert d.status == "infeasible" and d.infeasibility.proven
    assert "0.618" in d.advice
    # and with an objective
    d = sos.design_pid(
        plant, minimize="u_max", saturation=sos.Saturation(None, [1, 0, 0, 0])
    )
    assert d.status == "infeasible" and d.infeasibility.proven


def test_a_gain_whose_proof_is_too_long_for_floats_is_undecided():
    """Exact poles of this loop lie where they should."""
    plant = sos.SecondOrderSystem(
        np.eye(2), 0.01 * np.eye(2), np.diag([1, 1 + 1e-8]), [[1], [1]]
    )
    poles = -1.4 - 0.2 * np.arange(4)
    K = placed(plant, poles)
    region = sos.PoleRegion(sigma=1)
    d = sos.analyse_pid(plant, K, region=region)
    assert d.status != "infeasible"


def test_asking_an_infeasible_design_for_its_gain():
    d = sos.design_pid(**IMPOSSIBLE["too little force"][0])
    for ask in (lambda: d.K_P, lambda: d.certify().K, d.poles, d.closed_loop):
        with pytest.raises(ValueError, match="the design is infeasible"):
            ask()


@pytest.mark.parametrize("share", [0.999, 0.99, 0.9])
def test_a_bound_just_below_the_norm_is_proven_impossible(share):
    robot = thesis.example_1()
    norm = sos.analyse_pid(robot.plant, robot.K, robot.U).hinf()
    below = sos.analyse_pid(robot.plant, robot.K, robot.U, gamma=share * norm)
    assert below.status == "infeasible"
    assert below.infeasibility.proven


def test_a_point_without_direction_keeps_the_frame():
    """Where the least infeasible P isn't positive in any direction."""
    request = Request(mass())
    lmis = ScaledLMIs(request, Frame.of(request))
    for size in (0.0, -1.0):
        near = {"P": size * np.eye(2), "Y": np.zeros((1, 2))}
        assert closer(lmis, near) is lmis.frame


def test_a_minimum_that_time_cuts_short_still_has_a_design(monkeypatch):
    """The point that phase one found, with the bounds that it keeps."""
    plant = thesis.example_1().plant

    def slow(*_):
        raise OutOfTime

    monkeypatch.setattr(objectives, "any_minimum", slow)
    d = sos.design_pid(plant, region=sos.PoleRegion(0.3), minimize="gamma")
    assert d.status == "feasible"
    assert "Stopped before the least gamma" in d.reason
    assert d.certify().proven and d.hinf() < d.gamma


@pytest.mark.parametrize(
    "B, spread", [("random", False), *later(("first two", True), ("first two", False))]
)
def test_a_large_plant_that_is_not_controllable_answers_at_once(B, spread):
    n = 60
    pushed = np.eye(n)[:, :2]
    if B == "random":
        pushed = np.random.default_rng(0).standard_normal((n, 2))
    S = np.diag(np.arange(1.0, n + 1)) if spread else np.eye(n)
    plant = sos.SecondOrderSystem(np.eye(n), 0.1 * np.eye(n), S, pushed)
    d = sos.design_pid(
        plant, region=sos.PoleRegion(sigma=1), search=sos.Search(time_limit=60)
    )
    assert d.status == "infeasible" and d.infeasibility.proven
    assert np.isclose(d.infeasibility.mode.real, -0.05)


def test_a_refusal_for_one_slack_scalar_says_so():
    """Without the number only what a vertex alone excludes is infeasible."""
    plants = sos.Polytope([mass(), mass(M=[[2.0]])])
    asked = dict(gamma=0.01, saturation=sos.Saturation(1, [1, 0]))
    one = sos.design_pid(plants, coupling=("slack", 0.5), **asked)
    assert one.status == "infeasible" and one.infeasibility.proven
    assert "for slack = 0.5 s" in one.reason
    every = sos.design_pid(plants, coupling="slack", **asked)
    assert every.status == "infeasible" and every.infeasibility.proven
    assert every.reason.startswith("At vertex 1 alone, and so for every slack scalar")
    far = counterexamples.random_pair(1, 9)  # each of them can do it
    asked = dict(region=sos.PoleRegion(2, 0.1, 3))
    both = sos.design_pid(far, coupling="slack", **asked)
    for vertex in far.vertices:
        assert sos.design_pid(vertex, **asked).status == "feasible"
    assert both.status == "undecided"
    assert "slack scalars that were tried" in both.reason


@pytest.mark.parametrize(
    "D, S, region, status",
    [
        (1.0, 5.0, sos.PoleRegion(sigma=0.5), "infeasible"),  # on the line
        (1.0, 5.0, sos.PoleRegion(sigma=0.5 - 1e-14), "feasible"),
        (0.1, 0.25, sos.PoleRegion(rho=0.5), "infeasible"),  # on the circle
        (0.0, -2.0, None, "infeasible"),  # one polynomial, a mode on either side
        # its slow mode is 2e-17 from the line, its fast one inside
        (3.0, 1.0, sos.PoleRegion(sigma=0.3819660112501052), "infeasible"),
        (3.0, 1.0, sos.PoleRegion(sigma=0.381966), "feasible"),
    ],
)
def test_edges_of_fixed_modes_are_exact(D, S, region, status):
    plant = sos.SecondOrderSystem(
        np.eye(2), np.diag([1.0, D]), np.diag([1.0, S]), [[1.0], [0.0]]
    )
    d = sos.design_pid(plant, region=region)
    assert d.status == status, d.reason
    if status == "infeasible":
        assert list(d.infeasibility.claims) == check(d.infeasibility.text)
    else:
        assert d.certify().proven


def test_a_mode_within_the_last_bit_is_never_refused():
    """Whether floats find its design depends on the processor."""
    plant = sos.SecondOrderSystem(
        np.eye(2), np.eye(2), np.diag([1.0, 5.0]), [[1.0], [0.0]]
    )
    d = sos.design_pid(plant, region=sos.PoleRegion(float(np.nextafter(0.5, 0))))
    assert d.status != "infeasible"
    assert d.certify().proven == (d.status == "feasible")
