"""Gains that follow measured parameters, beside plants written by hand."""

import ctypes

import numpy as np
import pytest

import sosbook as sos
from sosbook.controllers.compiler import loaded
from sosbook.plants.schedule import Schedule, scheduled
from tests.cases import campaign, later

REGION = dict(region=sos.PoleRegion(sigma=1, rho=4))
UNITS = [(0.3, 9.81), *later((1.0, 1.0))]  # of mass and force
START = [1, 1, 0, 0]


def crane(kappa, m, g=9.81):
    """A cart of 1 kg and a load of m kg on a rope of 1/kappa m; z: their places."""
    S = [[m * g * kappa, -m * g * kappa], [-g * kappa, g * kappa]]
    return sos.SecondOrderSystem(np.eye(2), [[0.1, 0], [0, 0]], S, [[1], [0]])


CRANE = sos.Uncertain(crane, kappa=(0.1, 1), m=(0.3, 0.6))
ASKED = dict(
    region=sos.PoleRegion(sigma=0.4, theta_deg=60),
    saturation=sos.Saturation(150, START),
)


@pytest.fixture(scope="module")
def swinging():
    return sos.design_pid(CRANE, law=sos.Scheduled("kappa"), **ASKED)


def crane_loop(K, kappa, m, g=9.81):
    """x' = A x of the crane under u = K x, from its equations of motion."""
    A = np.zeros((4, 4))
    A[:2, 2:] = np.eye(2)
    A[2] = [-m * g * kappa, m * g * kappa, -0.1, 0]
    A[3] = [g * kappa, -g * kappa, 0, 0]
    A[2] += np.ravel(K)
    return A


@pytest.mark.parametrize("unit, force", UNITS)
def test_a_gain_that_follows_the_mass_does_what_no_fixed_gain_does(unit, force):
    """m s^2 + c s + k: with poles in |s| < 4 c is below 8 m, so below 8 at m = 1; left
    of -1 it is above 2 m, so above 18 at m = 9.
    """
    cart = sos.Uncertain(
        lambda m: sos.SecondOrderSystem(m * unit, 0, 0, force), m=(1, 9)
    )
    assert sos.design_pid(cart, **REGION).status == "infeasible"
    design = sos.design_pid(cart, law=sos.Scheduled("m"), **REGION)
    assert design.certify().proven
    for m in np.linspace(1, 9, 41):
        ((k, c),) = design.schedule.K(m=m)
        poles = np.roots([m * unit, -c * force, -k * force])
        assert poles.real.max() < -1 and abs(poles).max() < 4


@pytest.mark.parametrize("force", [9.81, *campaign([1.0])])
def test_where_the_input_follows_it_too_the_hull_is_bernstein_s(force):
    """A motor whose constant is measured: B K(k) is of degree two, so there is a vertex
    beside the corners for each piece of the range.
    """
    motors = sos.Uncertain(
        lambda k: sos.SecondOrderSystem(1, 0.1, 0, force * k), k=(0.3, 4)
    )
    ask = dict(region=sos.PoleRegion(sigma=1, rho=7))
    design = sos.design_pid(motors, law=sos.Scheduled("k"), **ask)
    family = design.request.plant.family
    assert len(design.request.vertices) == family.pieces["k"] + 2
    assert design.certify().proven
    assert sos.design_pid(motors, **ask).status == "infeasible"
    for k in np.linspace(0.3, 4, 41):
        ((p, d),) = design.schedule.K(k=k)
        poles = np.roots([1, 0.1 - force * k * d, -force * k * p])
        assert poles.real.max() < -1 and abs(poles).max() < 7


def test_a_crane_whose_rope_is_measured(swinging):
    assert sos.design_pid(CRANE, coupling="pairs", **ASKED).status == "infeasible"
    proof = swinging.certify()
    assert proof.proven and "constant or changing" in proof.claims[0]
    schedule = swinging.schedule
    for kappa in np.linspace(0.1, 1, 19):
        K = schedule.K(kappa=kappa)
        for m in np.linspace(0.3, 0.6, 7):
            poles = np.linalg.eigvals(crane_loop(K, kappa, m))
            assert poles.real.max() < -0.4
            assert (abs(poles.imag) <= -np.tan(np.pi / 3) * poles.real).all()


def test_the_rope_may_move_as_fast_as_it_likes(swinging):
    """By Runge and Kutta's own formula; V falls as sigma says, and u is bounded."""
    schedule, h, t = swinging.schedule, 2e-3, np.linspace(0, 4, 81)
    motion = dict(
        kappa=lambda t: 0.55 + 0.45 * np.sin(5 * t), m=lambda t: 0.45 + 0.15 * np.cos(t)
    )
    found = schedule.simulate(t, motion, START)

    def rate(t, x):
        kappa = motion["kappa"](t)
        return crane_loop(schedule.K(kappa=kappa), kappa, motion["m"](t)) @ x

    x, own = np.array(START, float), []
    for k in range(2001):
        if k % 25 == 0:
            own.append(x)
        a = rate(k * h, x)
        b = rate((k + 0.5) * h, x + h / 2 * a)
        c = rate((k + 0.5) * h, x + h / 2 * b)
        d = rate((k + 1) * h, x + h * c)
        x = x + h / 6 * (a + 2 * b + 2 * c + d)
    np.testing.assert_allclose(found.x.T, own, atol=1e-7)
    kappa = found.parameters["kappa"]
    u = [schedule.K(kappa=p) @ x for p, x in zip(kappa, found.x.T)]
    np.testing.assert_allclose(found.u.T, u, atol=1e-9)
    assert abs(found.u).max() < 150
    P = np.linalg.inv(swinging.certify().P)
    V = np.einsum("ik,ij,jk->k", found.x, P, found.x)
    assert (V <= V[0] * np.exp(-0.8 * t)).all()


def test_an_encoder_is_enough_for_a_measured_mass():
    carts = sos.Uncertain(lambda m: sos.SecondOrderSystem(m, 0.1, 1, 1), m=(1, 4))
    law = sos.Scheduled("m", sos.PIDLaw(position=[[1]], filter=0.05))
    design = sos.design_pid(carts, law=law, region=sos.PoleRegion(sigma=0.5))
    assert design.certify().proven
    for m in np.linspace(1, 4, 13):
        P, D = design.schedule.K(m=m)[0]
        poles = np.roots([0.05 * m, m + 0.005, 0.1 + 0.05 - 0.05 * P - D, 1 - P])
        assert poles.real.max() < -0.5
    assert "follows m" in law.words(design.request.plant)


def test_weights_are_the_means_of_corners():
    def builder(a, b, c):
        return sos.DescriptorSystem([[a + b, 0], [0, 1]], [[0, 1], [b * c, c]],
                                    [[a, 2], [b * c, 1]])  # fmt: skip

    family = sos.Uncertain(builder, a=(0.3, 2), b=(1, 9.81), c=(-1, 1))
    wide = scheduled(family, ("c", "a"))
    schedule = Schedule(("c", "a"), family.box)
    corners = [(x["c"], x["a"]) for x in schedule.corners]
    assert corners == [(-1, 0.3), (-1, 2), (1, 0.3), (1, 2)]
    for a, b, c in [(0.3, 1, -1), (1.1, 3, 0.2), (2, 9.81, 0.7)]:
        w = schedule.weights(c=c, a=a)
        assert abs(w.sum() - 1) < 1e-15 and w.min() >= 0
        np.testing.assert_allclose(w @ np.array(corners), (c, a), atol=1e-12)
        whole = wide.at(a=a, b=b, c=c).vertices[0].Bu
        B = family.at(a=a, b=b, c=c).vertices[0].Bu
        np.testing.assert_allclose(whole, np.kron(w, B), atol=1e-12)


@pytest.mark.parametrize("precision", ["single", *campaign(["double"])])
def test_the_program_mixes_bit_by_bit(precision):
    """All corners' outputs from axis_step, and their mean from axis_mixed."""
    plants = sos.Uncertain(
        lambda m, k: sos.SecondOrderSystem(m, 0.1, k, 1), m=(0.3, 1), k=(0.5, 9.81)
    )
    law = sos.Scheduled(["m", "k"])
    design = sos.design_pid(plants, law=law, region=sos.PoleRegion(sigma=0.5, rho=9))
    controller = design.controller(T=0.01)
    assert controller.certify().proven
    texts = sos.controllers.Code(controller, "law", precision).texts
    texts["law.c"] += (
        '#include "law_schedule.h"\n'
        "int law_mean(const law_real p[], const law_real u[], law_real mixed[])\n"
        "{\n    return law_mixed(p, u, mixed);\n}\n"
    )
    real = {"double": ctypes.c_double, "single": ctypes.c_float}[precision]
    mean = loaded("law", texts).law_mean
    rng, schedule = np.random.default_rng(3), design.schedule
    for _ in range(200):
        p, u = rng.uniform([0.3, 0.5], [1, 9.81]), rng.normal(size=4)
        found = (real * 1)()
        assert mean((real * 2)(*p), (real * 4)(*u), found) == 1
        (own,) = schedule.mixed(u[:, None], m=p[0], k=p[1])
        assert found[0] == own if precision == "double" else abs(found[0] - own) < 1e-5
    for p in ([0.2, 1], [1, 10], [np.nan, 1]):
        assert mean((real * 2)(*p), (real * 4)(1, 2, 3, 4), found) == 0
        assert np.isfinite(found[0])


@pytest.mark.parametrize(
    "law, words",
    [
        (lambda: sos.Scheduled("l"), "'l' is measured, but is no parameter"),
        (lambda: sos.Scheduled([]), "name each measured parameter once"),
        (lambda: sos.Scheduled(["m", "m"]), "name each measured parameter once"),
        (lambda: sos.Scheduled(3), "measured must be names"),
        (lambda: sos.Scheduled("m", "PID"), "law must be another law"),
        (
            lambda: sos.Scheduled("m", sos.DynamicLaw(1, position=[[1]])),
            "only those of u follow",
        ),
        (
            lambda: sos.Scheduled(
                "m", sos.PIDLaw(sensors=sos.Output(acceleration=[[1]]), lag=0.1)
            ),
            "no late sensors",
        ),
    ],
)
def test_a_bad_schedule_says_the_cure(law, words):
    carts = sos.Uncertain(lambda m: sos.SecondOrderSystem(m, 0.1, 1, 1), m=(1, 4))
    with pytest.raises(ValueError, match=words):
        sos.design_pid(carts, law=law(), region=sos.PoleRegion(sigma=0.5))
    if words.startswith("name"):
        cart = sos.SecondOrderSystem(1, 0, 0, 1)
        with pytest.raises(ValueError, match="no parameters to be measured"):
            sos.design_pid(cart, law=law())


def test_values_out_of_the_proof_are_refused(swinging):
    schedule = swinging.schedule
    with pytest.raises(ValueError, match=r"kappa = 2 isn't in \[0.1, 1\]"):
        schedule.K(kappa=2)
    with pytest.raises(ValueError, match="give a value of kappa"):
        schedule.K(m=0.5)
    with pytest.raises(ValueError, match="motion needs a number or a function of"):
        schedule.simulate([0, 1], dict(kappa=0.5), START)
    with pytest.raises(ValueError, match="m = 7 isn't in"):
        schedule.simulate([0, 1], dict(kappa=0.5, m=7), START)
    with pytest.raises(ValueError, match="has no schedule"):
        assert sos.design_pid(crane(0.5, 0.5)).schedule
