"""The free scalar mu of Theorem 2.1, and the size of P in general."""

import numpy as np
import pytest

import sosbook as sos
from sosbook.plants.coupled import Coupled
from sosbook.plants.coupling import coupling_of
from sosbook.plants.descriptor import descriptors
from sosbook.requirements.hinf import HInfinity
from sosbook.studies import maps
from sosbook.synthesis.request import Request
from sosbook.theorems import bounded_real
from tests.cases import campaign
from tests.energy_to_peak import EnergyToPeak


@pytest.fixture(scope="module")
def asked(robot):
    """The robot's requirements but for gamma."""
    return dict(U=robot.U, region=robot.region, saturation=robot.saturation)


def units(plant, force, length, w=1.0):
    """The plant, with gamma's unit, in other units of force, length and w."""
    return sos.SecondOrderSystem(
        plant.M * force / length,
        plant.D * force / length,
        plant.S * force / length,
        plant.B,
        plant.F / w,
    ), length / force / w


@pytest.mark.parametrize("mu", [0.01, 1, 100])
def test_alone_gamma_does_not_depend_on_mu(robot, mu):
    """Without a block that fixes the size of P."""
    d = sos.design_pid(
        robot.plant,
        robot.U,
        region=robot.region,
        gamma=sos.HInfinity(mu=mu),
        minimize="gamma",
    )
    wanted = sos.design_pid(robot.plant, robot.U, region=robot.region, minimize="gamma")
    assert d.gamma == wanted.gamma
    assert np.allclose(d.K, wanted.K, rtol=1e-4)
    assert d.request.sizes.condition == ""


def test_a_number_for_mu_is_a_unit_of_w(robot, asked):
    """-mu I and -(gamma^2/mu) I are F / sqrt(mu) and gamma / sqrt(mu)."""
    plant, mu = robot.plant, 0.04
    other, unit = units(plant, 1, 1, np.sqrt(mu))
    first = sos.design_pid(plant, gamma=sos.HInfinity(0.3, mu=mu), **asked)
    second = sos.design_pid(other, gamma=sos.HInfinity(0.3 * unit, mu=1.0), **asked)
    assert np.allclose(first.K, second.K, rtol=1e-5)


def test_one_program_finds_the_best_mu(robot, asked):
    """The optimum of a scan over mu, which is never lower."""
    best = sos.design_pid(
        robot.plant, minimize="gamma", search=sos.Search(backoff=1e-3), **asked
    )
    scan = [
        sos.design_pid(
            robot.plant,
            minimize="gamma",
            search=sos.Search(backoff=1e-3),
            gamma=sos.HInfinity(mu=mu),
            **asked,
        )
        for mu in 2.271e-4 * np.array([0.8, 1.0, 1.25])
    ]
    found = [d.gamma or np.inf for d in scan]
    assert best.gamma <= min(found) == found[1] == best.gamma
    assert best.gamma == 0.00985
    given = sos.analyse_pid(
        robot.plant, robot.K, minimize="gamma", search=sos.Search(backoff=1e-3), **asked
    )
    assert given.gamma == 0.0184 and given.certify(17).proven


def test_free_mu_proves_what_one_cannot(robot, asked):
    """A bound near the true norm, over the other requirements."""
    fixed = sos.design_pid(
        robot.plant, minimize="gamma", gamma=sos.HInfinity(mu=1.0), **asked
    )
    free = sos.design_pid(robot.plant, minimize="gamma", **asked)
    assert free.gamma < fixed.gamma / 10
    assert free.hinf() < free.gamma < 2 * free.hinf()
    assert free.certify().proven


def test_a_refusal_for_one_mu_says_so(robot, asked):
    refused = sos.design_pid(robot.plant, gamma=sos.HInfinity(0.02, mu=1.0), **asked)
    assert refused.status == "infeasible" and refused.infeasibility.proven
    assert refused.infeasibility.condition == "for mu = 1"
    assert refused.request.sizes.condition == "for mu = 1"
    assert repr(refused) == "<Design: infeasible for mu = 1>"
    assert refused.advice.startswith("Leave out mu = 1 first")
    assert sos.design_pid(robot.plant, gamma=0.02, **asked).certify().proven


def test_a_refusal_without_mu_excludes_every_mu(robot, asked):
    never = sos.design_pid(robot.plant, gamma=0.0098, **asked)
    assert never.status == "infeasible" and never.infeasibility.proven
    assert never.infeasibility.condition == "" and repr(never).endswith("infeasible>")
    for mu in (2.27e-4, 1):
        one = sos.design_pid(robot.plant, gamma=sos.HInfinity(0.0098, mu=mu), **asked)
        assert one.status == "infeasible"


def test_the_printed_blocks_hold_with_the_mu_of_the_design(robot, asked):
    """P, Y and mu in the plant's units, in the theorem as it is printed."""
    d = sos.design_pid(robot.plant, gamma=0.02, **asked)
    (v,) = descriptors(robot.plant, robot.U)
    block = bounded_real(Coupled(v, v, d.P, d.Y), 0.02**2, d.mu)
    assert np.linalg.eigvalsh(block)[0] > 0
    x0 = robot.saturation.x0
    assert x0 @ np.linalg.solve(d.P, x0) < 1
    push = d.K @ d.P @ d.K.T
    assert np.linalg.eigvalsh(push)[-1] < robot.saturation.u_max**2
    tied = sos.analyse_pid(
        robot.plant, d.K, gamma=sos.HInfinity(0.02, mu=d.mu), **asked
    )
    assert tied.status == "feasible"


# ------------------------------------------ every pair that fixes the size of P
COST = sos.QuadraticCost(np.eye(4), np.eye(2), noise="F", bound=8.0)
SIZED = {
    "gamma": HInfinity(0.5),
    "u_max": sos.Saturation(60.0, [0.2, 0.1, 0, 0]),
    "cost": COST,
    "peak": EnergyToPeak(0.5),
}


@pytest.mark.parametrize("key", ["cost", *campaign(["gamma", "u_max"])])
def test_a_bound_is_minimised_over_every_size(robot, key):
    """One step further is refused, with a proof for every size."""
    r = SIZED[key]
    others = [SIZED[n] for n in ("gamma", "u_max", "cost") if n != key]
    best = sos.design_pid(
        robot.plant,
        requirements=[r.with_bound(None), *others],
        minimize=key,
        search=sos.Search(backoff=1e-3),
    )
    bound = maps.requirements(best.request)[key]
    assert best.certify(9).proven
    refused = sos.design_pid(
        robot.plant, requirements=[r.with_bound(0.99 * bound), *others]
    )
    assert refused.status == "infeasible" and refused.infeasibility.proven


@pytest.mark.parametrize("mu", [1e-4, *campaign([1e-6])])
def test_a_minimum_that_one_mu_forbids_says_so(robot, asked, mu):
    """Below a mu of about 2e-4 nothing has any bound at all, however large."""
    d = sos.design_pid(
        robot.plant, minimize="gamma", gamma=sos.HInfinity(mu=mu), **asked
    )
    assert d.status == "infeasible" and d.infeasibility.proven
    assert d.reason.endswith(f"exclude every gamma for mu = {mu:g}.")
    assert repr(d) == f"<Design: infeasible for mu = {mu:g}>"
    assert d.advice.startswith(f"Leave out mu = {mu:g} first")
    assert d.gamma is None and d.K is None
    one = sos.design_pid(robot.plant, gamma=sos.HInfinity(1e6, mu=mu), **asked)
    assert one.status != "feasible"
    more = sos.design_pid(
        robot.plant, minimize="gamma", gamma=sos.HInfinity(mu=1e-3), **asked
    )
    assert more.certify().proven


def test_a_minimum_beside_too_little_force_does_not_blame_mu(robot, asked):
    weak = dict(asked, saturation=sos.Saturation(1.0, robot.saturation.x0))
    d = sos.design_pid(
        robot.plant, minimize="gamma", gamma=sos.HInfinity(mu=1e-6), **weak
    )
    assert d.status == "infeasible" and d.infeasibility.proven
    assert "mu =" not in d.reason + d.advice + repr(d)


def test_two_bounds_at_once(robot, asked):
    """Never worse than at any size that a scan tries."""
    weights = {"gamma": 1.0, "u_max": 1e-9}
    free = dict(asked, saturation=sos.Saturation(None, robot.saturation.x0))

    def total(d):
        found = maps.requirements(d.request)
        return sum(w * found[name] ** 2 for name, w in weights.items())

    best = sos.design_pid(
        robot.plant, minimize=weights, search=sos.Search(backoff=1e-3), **free
    )
    assert best.certify(9).proven
    for mu in best.mu * np.array([0.9, 1.1]):
        fixed = sos.design_pid(
            robot.plant,
            minimize=weights,
            search=sos.Search(backoff=1e-3),
            gamma=sos.HInfinity(mu=mu),
            **free,
        )
        assert total(best) < 1.005 * total(fixed)


def test_a_request_knows_what_fixes_the_size(robot):
    request = Request(robot.plant, robot.U, robot.region)
    assert request.sizes.fixing == () and request.sizes.leader() is None
    request = Request(robot.plant, requirements=list(SIZED.values()))
    assert [r.name for r in request.sizes.fixing] == [
        "gamma",
        "cost",
        "saturation",
        "peak",
    ]
    assert request.sizes.leader().name == "gamma"
    assert request.sizes.leader(["u_max"]).name == "saturation"
    assert [r.name for r in request.sizes.followers(request.sizes.leader())] == [
        "cost",
        "saturation",
        "peak",
    ]
    held = [
        sos.HInfinity(r.gamma, mu=2) if r.name == "gamma" else r for r in SIZED.values()
    ]
    tied = Request(robot.plant, requirements=held)
    sizes = tied.sizes
    assert sizes.followers(sizes.leader()) == () and sizes.condition == "for mu = 2"
    assert tied.untied().sizes.condition == ""


@pytest.mark.parametrize(
    "made, words",
    [
        (lambda: sos.HInfinity(mu=0), "mu must be positive"),
        (lambda: coupling_of(("slack", -1)), "slack must be positive"),
    ],
)
def test_bad_input(made, words):
    with pytest.raises(ValueError, match=words):
        made()
