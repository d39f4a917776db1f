"""PID design and analysis with a delayed input, through its public face."""

import importlib
from functools import cache

import cvxpy
import numpy as np
import pytest

import sosbook as sos
from sosbook import delay
from sosbook.book import thesis
from sosbook.delay import (
    DelayedLoop,
    DelayRequest,
    analyse_delay,
    delay_margin,
    delayed_loop,
    design_delay_pid,
    largest,
    slowest_decay,
    solve_delay,
)
from sosbook.plants.descriptor import descriptors
from sosbook.theorems import Functional, delay_stabilization
from tests.cases import campaign, examples, later

RAM = thesis.delay_example_2()
BENCHMARK = DelayedLoop([[-2, 0], [0, -0.9]], [[-1, 0], [-1, -1]])
HEAVIER = sos.SecondOrderSystem(
    1.2 * RAM.plant.M, RAM.plant.D, 1.1 * RAM.plant.S, RAM.plant.B
)
ONE = [[1.0]]


def design(**changes):
    return design_delay_pid(RAM.plant, **RAM.requirements | changes)


@cache
def thesis_design(method="functional"):
    return design(method=method)


def test_a_family_with_squares_is_cut_until_its_vertices_can_be_proven():
    """In one piece a vertex is unstable that is no plant."""
    plants = sos.Uncertain(
        lambda v: sos.SecondOrderSystem(1, 0.5 + 4 * (v - 0.4) ** 2, 2, 1), v=(0, 1)
    )
    asked = dict(K=[[0, 0]], tau=0.001)
    assert analyse_delay(sos.Polytope(plants.vertices), **asked).status == "infeasible"
    found = analyse_delay(plants, **asked)
    assert (
        found.certify()
        .claims[0]
        .startswith("every constant or changing plant with v in")
    )


# The thesis's examples


def test_example_2_is_designed_and_proven():
    d = thesis_design()
    assert d.status == "feasible"
    assert d.alpha == 0.8
    certificate = d.certify()
    assert certificate.proven
    assert certificate.claims == (
        "the plant, under u = K x(t - d), decays at least as fast as "
        "exp(-0.1 t) for every delay in [0.2, 0.6] s, however it varies",
    )
    rate, _ = d.slowest_decay()
    assert 0.1 < rate < 1
    assert np.array_equal(np.hstack([d.K_P, d.K_D, d.K_I]), d.K)
    # the printed gain isn't the centre, yet a neighbour in K_D
    assert np.allclose(d.K_D, RAM.K_D, rtol=0.15)


def test_the_printed_gain_of_example_2_is_proven():
    """By Theorem A.3 with a free G, at the printed tau, mu and delta."""
    d = analyse_delay(RAM.plant, RAM.K, RAM.U, RAM.tau, RAM.mu, RAM.delta)
    assert d.status == "feasible"
    certificate = d.certify()
    assert certificate.proven
    assert np.array_equal(certificate.K, RAM.K)
    assert slowest_decay(
        *delayed_loop(descriptors(RAM.plant, RAM.U)[0], RAM.K), 0.2, 0.6
    )[0] == pytest.approx(0.2934, abs=2e-4)


@pytest.mark.campaign  # chapters 16 and 17 design by it, and say that the loops grow
@pytest.mark.parametrize("name", ["wing, printed", "wing, published", "ram"])
def test_the_printed_theorem_designs_unstable_loops(name):
    """printed=True: the LMIs hold, exactly, and the loop diverges."""
    example = {
        "wing, printed": thesis.delay_example_1(False),
        "wing, published": thesis.delay_example_1(True),
        "ram": RAM,
    }[name]
    d = design_delay_pid(example.plant, **example.requirements, printed=True)
    assert d.status == "feasible"
    assert d.slowest_decay()[0] < -1
    certificate = d.certify()
    assert certificate.proven
    assert certificate.claims == (
        "the LMIs as printed hold: that proves nothing about the loop",
    )


# What a design consists of


def test_margins_are_those_of_the_blocks():
    d = thesis_design()
    blocks = d.request.blocks(d.values)
    assert set(d.margins) == set(blocks) == {"functional", "R", "Z", "decay"}
    for name, g in blocks.items():
        scale = 1 / np.sqrt(np.diag(g))
        wanted = np.linalg.eigvalsh(g * np.outer(scale, scale))[0]
        assert d.margins[name] == pytest.approx(wanted)
        assert wanted > 0


def test_alpha_is_searched():
    """The rate 0.17 has no design with the thesis's alpha."""
    assert design(delta=0.17).status == "infeasible"
    found = design(delta=0.17, alpha=None)
    assert found.status == "feasible"
    assert found.alpha != 0.8
    assert found.certify().proven
    again = design(delta=0.17, alpha=found.alpha)
    assert np.allclose(again.K, found.K)


def test_where_no_alpha_succeeds_nothing_is_decided():
    d = design(delta=0.6, alpha=None)
    assert d.status == "undecided"
    for ask in (lambda: d.certify().K, d.slowest_decay, lambda: d.K_P):
        with pytest.raises(ValueError, match="the design is undecided"):
            ask()


@pytest.mark.slow
@pytest.mark.parametrize(
    "mu, delta, method",
    [  # each value with each other once
        *((0.0, 0.0, "functional"), (0.0, 0.1, "shift")),
        *((0.2, 0.0, "shift"), (0.2, 0.1, "functional")),
        *later((0.0, 0.0, "shift"), (0.0, 0.1, "functional")),
        *later((0.2, 0.0, "functional"), (0.2, 0.1, "shift")),
    ],
)
def test_a_constant_delay_and_a_rate_of_zero(mu, delta, method):
    d = design(mu=mu, delta=delta, method=method)
    assert d.status == "feasible"
    certificate = d.certify()
    assert certificate.proven
    constant = "for the constant delay 0.4 s" in certificate.claims[0]
    assert constant == (mu == 0)
    assert ("is exponentially stable" in certificate.claims[0]) == (delta == 0)
    assert ("Z" in d.values) == (mu > 0)
    rate, where = d.slowest_decay()
    assert rate > delta
    assert 0.4 - mu <= where <= 0.4 + mu


def test_a_pd_controller():
    d = design_delay_pid(RAM.plant, tau=0.4, mu=0.2, delta=0.1, alpha=0.8)
    assert d.K.shape == (1, 4)
    assert d.K_I.shape == (1, 0)
    assert d.certify().proven


def test_the_proof_is_about_the_rounded_gain():
    d = thesis_design()
    rough = d.certify(digits=3)
    assert rough.proven
    assert np.array_equal(rough.K, [[float(f"{k:.2e}") for k in d.K[0]]])
    for bad in (0, 2.5):
        with pytest.raises(ValueError, match="digits must be 1 or more"):
            d.certify(digits=bad)


# Polytopes


def test_one_functional_serves_a_polytope():
    """At vertices by proof, between them by convexity, and by roots."""
    plants = sos.Polytope([RAM.plant, HEAVIER])
    asked = RAM.requirements | dict(delta=0.05)
    d = design_delay_pid(plants, **asked)
    assert d.status == "feasible"
    certificate = d.certify()
    assert certificate.proven
    assert certificate.claims[0].startswith("every constant or changing plant of")
    assert {"decay 1", "decay 2"} < set(certificate.blocks)
    frame, t, v = d.request.frame, d.request.times(), d.values
    bars = Functional(*(v[n] for n in ("P", "Q", "S", "R1", "R2", "R3", "Z")))
    for a in (0.0, 0.3, 0.8, 1.0):
        (vertex,) = descriptors(plants.at([1 - a, a]), U=RAM.U)
        loop = delayed_loop(vertex, d.K)
        assert slowest_decay(*loop, 0.2, 0.6)[0] > 0.05
        part = vertex.change(frame.left, frame.T, frame.scale)
        part = type(part)(part.E, 0.4 * part.A, 0.4 * part.Bu, part.Bw, part.C)
        matrix = delay_stabilization(part, bars, v["F"], v["X"], t, d.alpha / 0.4)
        assert np.linalg.eigvalsh(matrix)[0] > 0
    assert len(d.roots(0.4)) == len(d.stable_delays(0.5)) == 2
    assert d.stable_delays(0.5) == [[(0.0, 0.5)], [(0.0, 0.5)]]


# Sharper methods and their limits


@pytest.mark.parametrize(
    "asked, proven, beyond",
    [
        (dict(method="functional"), 4.47, 4.48),  # as sharp as Jensen
        (dict(method="legendre", order=0), 4.47, 4.48),
        (dict(method="legendre", order=1), 6.059, 6.06),
        (dict(method="legendre", order=2), 6.168, 6.169),
        (dict(method="legendre", order=3), 6.1724, 6.17255),
        (dict(method="legendre", order=4), 6.1725, 6.1726),
    ],
    ids=str,
)
def test_legendre_orders_approach_the_true_margin(asked, proven, beyond):
    """Known limits: 4.472 (Jensen), 6.059 (Wirtinger), 6.17258 (true).

    Source: Seuret and Gouaisbaut (2013).
    """
    true = delay_margin(BENCHMARK.A, BENCHMARK.A_d)
    assert true == pytest.approx(6.17258, abs=1e-5)
    assert proven < true
    d = analyse_delay(BENCHMARK, tau=proven, **asked)
    assert d.certify().proven
    request = d.request.at(tau=beyond)
    assert solve_delay(request, refuse=False).status != "feasible"


@pytest.mark.parametrize("name", ["mu", *campaign(["tau", "delta"])])
def test_largest_ends_between_two_neighbours(name):
    loop = DelayedLoop([[0]], [[-1]])
    asked = dict(tau=0.5, mu=0.1, delta=0.05)
    found = largest(name, loop, **asked)
    assert found.design.certify().proven
    step = 10.0 ** (np.floor(np.log10(found.value)) - 1)
    assert found.beyond == pytest.approx(found.value + step, rel=1e-9)
    again = analyse_delay(loop, **asked | {name: found.value})
    assert again.status == "feasible"
    beyond = analyse_delay(loop, **asked | {name: found.beyond})
    assert beyond.status == "infeasible"
    assert f"{name} = {found.value} has a certificate" in repr(found)


@pytest.mark.parametrize("start", [6, 5.9, 6.2, 1, 40])
def test_a_given_start_decides_how_long_largest_takes_and_nothing_else(
    start, monkeypatch
):
    searched, tried = importlib.import_module("sosbook.delay.largest"), []
    first_design = searched.first_design

    def design(request, *given, **more):
        tried.append(request.tau)
        return first_design(request, *given, **more)

    monkeypatch.setattr(searched, "first_design", design)
    asked = dict(method="legendre", order=1, refuse=False)
    found = largest("tau", BENCHMARK, tau=start, **asked)
    assert (found.value, found.beyond) == (6.0, 6.1)
    assert abs(start - 6.05) > 1 or len(tried) <= 4


def test_largest_stops_at_the_parameters_own_limit():
    loop = DelayedLoop([[-2]], [[0.5]])
    found = largest("mu", loop, tau=0.3)
    assert (found.value, found.beyond) == (0.3, None)
    never = largest("delta", DelayedLoop([[1]], [[0]]), tau=0.3)
    assert never.value is None
    assert never.design is None


CLOCKED = RAM.loop.late(0.4)


@pytest.mark.parametrize(
    "bad, words",
    [
        (dict(name="d"), "name must be"),
        (dict(digits=0), "digits must be"),
        (dict(digits=1.5), "digits must be"),
        (dict(digits=True), "digits must be"),
        (dict(plant=CLOCKED), "has no clock here"),
        (dict(plant=RAM.loop, U=RAM.U), "leave U out"),
    ],
)
def test_bad_questions_for_the_largest(bad, words):
    with pytest.raises(ValueError, match=words):
        largest(**dict(name="tau", plant=BENCHMARK, tau=1) | bad)


# Bad input

SINGULAR = sos.SecondOrderSystem(np.diag([1.0, 0]), np.eye(2), np.eye(2), [[1], [1]])


@pytest.mark.parametrize(
    "bad, words",
    [
        (dict(tau=None), "tau is missing"),
        (dict(tau=0), "tau must be"),
        (dict(tau=-1.0), "tau must be"),
        (dict(tau=np.nan), "tau"),
        (dict(tau="1"), "tau"),
        (dict(mu=-0.1), "mu must be 0 or more"),
        (dict(mu=0.5), "mu = 0.5 exceeds tau = 0.4.*take mu <= tau"),
        (dict(mu=np.inf), "mu"),
        (dict(delta=-0.1), "delta must be 0 or more"),
        (dict(delta=[0.1]), "delta"),
        (dict(alpha=0), "alpha must be"),
        (dict(alpha=-2.0), "alpha must be"),
        (dict(method="legendre"), "analyses a given gain"),
        (dict(U=[[1, 0, 0]]), "U has 3 columns, needs 2"),
        (dict(U=[1, 0]), "U must be a matrix"),
        (dict(U=[[1, 0], [0, 1]]), "U"),
        (dict(K_A=[[0.1, 0]]), "K_A must be zero.*neutral"),
        (dict(plant=SINGULAR, U=None), "M is singular.*neutral"),
        (dict(plant="wing"), "plant"),
        (dict(method="shift", printed=True), "printed=True"),
    ],
)
def test_bad_input_of_a_design(bad, words):
    asked = dict(plant=RAM.plant) | RAM.requirements | bad
    with pytest.raises(ValueError, match=words):
        design_delay_pid(**asked)


@pytest.mark.parametrize(
    "bad, words",
    [
        (dict(K=None), "K is missing"),
        (dict(K=[[1, 2, 3]]), "K has 3 columns, needs 5"),
        (dict(K=np.ones((2, 5))), "K has 2 rows, needs 1"),
        (dict(K=[1, 2, 3, 4, 5]), "K must be a matrix"),
        (dict(K=[[1, 2, 3, 4, np.nan]]), "K has NaN"),
        (dict(printed=-0.8), "alpha must be"),
        (dict(method="legendre", order=-1), "order must be 0, 1, 2"),
        (dict(method="legendre", order=1.0), "order must be 0, 1, 2"),
        (dict(method="legendre", order=True), "order must be 0, 1, 2"),
        (
            dict(method="legendre", plant=sos.Polytope([RAM.plant, HEAVIER])),
            "takes one plant",
        ),
        (dict(method="legendre", printed=True), "printed=True"),
        (dict(plant=BENCHMARK), "has its controller inside"),
        (dict(plant=BENCHMARK, K=None), "has its controller inside"),
    ],
)
def test_bad_input_of_an_analysis(bad, words):
    asked = dict(plant=RAM.plant, K=RAM.K, U=RAM.U, tau=0.4, mu=0.2, delta=0.1)
    with pytest.raises(ValueError, match=words):
        analyse_delay(**asked | bad)


@pytest.mark.parametrize(
    "bad, words",
    [
        (dict(A=[[1, 2]], A_d=[[1, 2]]), "A must be square"),
        (dict(A=[[1]], A_d=[[1, 2]]), "A_d has 2 columns, needs 1"),
        (dict(A=[1], A_d=[[1]]), "A must be a matrix"),
    ],
)
def test_bad_loops(bad, words):
    with pytest.raises(ValueError, match=words):
        DelayedLoop(**bad)


def test_a_zero_acceleration_gain_is_none():
    d = design(K_A=np.zeros((1, 2)))
    assert np.array_equal(d.K, thesis_design().K)


# Other methods


def outside(request):
    """Clarabel's verdict: all blocks >= I, for they are a cone."""
    values = {
        u.name: cvxpy.Variable(u.shape, symmetric=u.symmetric)
        for u in request.unknowns()
    }
    problem = cvxpy.Problem(
        cvxpy.Minimize(0),
        [(g + g.T) / 2 >> np.eye(g.shape[0]) for g in request.blocks(values).values()],
    )
    problem.solve(solver=cvxpy.CLARABEL)
    return {"optimal": "feasible"}.get(problem.status, problem.status)


@pytest.mark.slow
@pytest.mark.parametrize(
    "changes, status",
    [
        (dict(mu=0.2), "feasible"),
        (dict(tau=1.2, mu=0.4), "infeasible"),
        (dict(mu=0.2, delta=0.3, method="shift"), "feasible"),
        (dict(tau=1.5, method="legendre"), "feasible"),
        *later(
            (dict(tau=0.7), "feasible"),
            (dict(tau=1.6), "infeasible"),
            (dict(tau=1.6, method="legendre"), "infeasible"),
        ),
    ],
)
def test_clarabel_agrees_on_an_analysis(changes, status):
    loop = DelayedLoop([[0, 0], [0.2, -0.5]], [[-1, 0], [0, -0.3]])
    request = DelayRequest(loop, **dict(tau=0.5) | changes)
    found = solve_delay(request)
    assert found.status == status
    assert outside(request) == status


@pytest.mark.parametrize(
    "changes, status", [(dict(), "feasible"), (dict(delta=2.0), "infeasible")]
)
def test_clarabel_agrees_on_a_design(changes, status):
    plant = sos.SecondOrderSystem(ONE, [[0.1]], [[-1.0]], ONE)
    asked = dict(tau=0.2, mu=0.1, delta=0.1, alpha=0.4) | changes
    d = design_delay_pid(plant, [[1.0]], **asked)
    assert d.status == status
    assert outside(d.request) == status


@pytest.mark.slow
def test_a_tiny_delay_changes_nothing():
    """A gain is accepted where the loop without delay is Hurwitz."""
    rng = np.random.default_rng(4)
    (d,) = descriptors(RAM.plant, U=RAM.U)
    seen = set()
    for _ in range(examples(4, 8)):
        K = RAM.K + 0.6 * rng.standard_normal(RAM.K.shape)
        A, Ad = delayed_loop(d, K)
        stable = np.linalg.eigvals(A + Ad).real.max() < 0
        request = DelayRequest(RAM.plant, RAM.U, 1e-4, 1e-4, gain=K)
        found = solve_delay(request, refuse=False)
        assert (found.status == "feasible") == stable
        seen.add(bool(stable))
    assert seen == {True, False}


# Units


def test_a_loop_that_is_given_as_such_takes_no_controller():
    loop = delay.DelayedLoop([[-2.0]], [[-1.0]])
    with pytest.raises(ValueError, match="nothing to design"):
        sos.design_delay_pid(loop, tau=1)
    with pytest.raises(ValueError, match="leave K and U out"):
        delay.largest("tau", loop, U=[[1.0]], tau=1)
    found = sos.analyse_delay(loop, tau=1)
    with pytest.raises(ValueError, match="has no K_P, K_D and K_I"):
        _ = found.K_P


def test_order_is_an_integer_of_any_kind_but_no_truth_value():
    loop = delay.DelayedLoop([[-2.0]], [[-1.0]])
    found = sos.analyse_delay(loop, tau=1, method="legendre", order=np.int64(1))
    assert found.status == "feasible"
