"""Whether a gain is the analytic centre's, and which one it is where there is none."""

import json
from functools import cache

import numpy as np
import pytest

import sosbook as sos
from sosbook.__main__ import main
from sosbook.solver.barrier import CONVERGES_BELOW, Barrier
from sosbook.synthesis import centre
from sosbook.synthesis.scaled_lmis import ScaledLMIs
from tests.cases import (
    campaign,
    chain,
    examples,
    random_cost_request,
    random_request,
    seeds,
)

COUPLING = np.array([[1.0, -1.0], [-1.0, 1.0]])


def drive(sigma, unit=1.0, **asked):
    """A motor that turns a load through a shaft; its unit of torque is ``unit``."""
    plant = sos.SecondOrderSystem(
        unit * np.diag([0.0025, 0.0045]),
        unit * 0.004 * COUPLING,
        unit * 1.9 * COUPLING,
        [[1], [0]],
    )
    asked = {
        "region": sos.PoleRegion(sigma=sigma, theta_deg=60, rho=280),
        "saturation": sos.Saturation(136 * unit, [-1, -1, 0, 0, 0]),
    } | asked
    return sos.design_pid(plant, [[0, 1]], **asked)


def largest_step(designs):
    """The largest change of a gain from one design to the next, relative."""
    gains = [d.K for d in designs]
    return max(
        np.abs(K - L).max() / max(np.abs(K).max(), np.abs(L).max())
        for K, L in zip(gains, gains[1:])
    )


def decrement(design):
    """Newton's decrement of all blocks of a request at a design."""
    lmis = ScaledLMIs(design.request, design.frame)
    x = lmis.text.packed(lmis.point(design))
    return Barrier(lmis.compiled.newton).step(x, 0 * x)[1]


@pytest.mark.parametrize("unit", [0.3, *campaign([1.0, 1 / 9.81, 2.2046])])
def test_the_gain_of_a_drive_follows_the_decay_rate(unit):
    designs = [drive(sigma, unit) for sigma in np.arange(2.2, 3.25, 0.05)]
    assert largest_step(designs) < 0.08
    for design in designs:
        assert design.central and design.reason == "" and decrement(design) < 1e-3
        assert np.abs(design.K).max() < unit


def test_a_centre_far_away_is_that_of_another_unit():
    for sigma in (2.2, 2.65):
        K = drive(sigma).K
        np.testing.assert_allclose(drive(sigma, 0.3).K / 0.3, K, rtol=1e-5)


def oscillator(sigma):
    plant = sos.SecondOrderSystem([[1]], [[0.2]], [[1]], [[1]])
    region, saturation = sos.PoleRegion(sigma=sigma), sos.Saturation(9, [1, 0])
    return sos.design_pid(plant, region=region, saturation=saturation)


def chained(sigma):
    region, saturation = sos.PoleRegion(sigma=sigma), sos.Saturation(5, [1] + 6 * [0])
    return sos.design_pid(chain(3), np.eye(3)[:1], region=region, saturation=saturation)


@pytest.mark.parametrize(
    "family, sigmas, edge",
    [
        (
            oscillator,
            (0.09, 0.0999, 0.1001, 0.103, 0.106, 0.11),
            0.1,
        ),  # the plant decays with 0.1
        (chained, (0.06, 0.1, 0.14, 0.16, 0.18, 0.22), 0.17),
    ],
)
def test_a_gain_does_not_jump_where_the_plant_ceases_to_do_without(
    family, sigmas, edge
):
    designs = [family(sigma) for sigma in sigmas]
    assert [d.central for d in designs] == [s > edge for s in sigmas]
    size = max(np.abs(d.K).max() for d in designs)
    steps = [np.abs(a.K - b.K).max() for a, b in zip(designs, designs[1:])]
    assert max(steps) < 0.45 * size
    assert all(d.certify().proven for d in designs)


@cache
def asked_without_centre():
    found = []
    for seed in range(examples(20, 36)):
        if seed in (7, 16, 18, 32):  # these are refused, slowly
            continue
        asked = random_request(seed)
        try:
            design = sos.design_pid(**asked)
        except ValueError:  # the integrators can't be reached
            continue
        if design.status == "feasible" and not design.central:
            found.append((asked, design))
    return found


def test_central_means_a_small_newton_decrement():
    found = 0
    for asked in map(random_cost_request, range(examples(7, 12))):
        design = sos.design_pid(**asked)
        if design.status == "feasible":
            assert design.central == (decrement(design) < CONVERGES_BELOW)
            found += 1
    assert found > 2


@pytest.mark.parametrize("count", [6, *campaign([14])])
def test_what_would_make_a_gain_a_centre_does(count):
    """A bound of the cost gives requests a centre, as each reason says."""
    reasons, central = set(), []
    for asked, design in asked_without_centre()[:count]:
        reasons.add(design.reason[:20])
        assert "bound of a cost" in design.reason or "one of a cost" in design.reason
        assert design.reason in design._repr_html_().replace("&#x27;", "'")
        plant, N = asked["plant"], design.request.order
        weights = np.eye(N), np.eye(plant.m)
        cheapest = sos.analyse_pid(
            plant, design.K, asked.get("U"), requirements=[sos.QuadraticCost(*weights)],
            minimize="cost", coupling="pairs",
        )  # fmt: skip
        bound = 100 * cheapest.request.cost.bound
        cost = sos.QuadraticCost(*weights, bound=float(f"{bound:.3g}"))
        bounded = sos.design_pid(**asked, requirements=[cost])
        assert bounded.status == "feasible"
        central.append(bounded.central)
    assert len(reasons) == 3
    assert central.count(False) <= 1  # one lies too far away for floats


def test_a_disk_or_an_input_bound_limits_gains_that_nothing_bounds():
    plant = chain(2)
    alone = sos.design_pid(plant, region=sos.PoleRegion(0.3), gamma=3.0)
    assert alone.reason == centre.NO_GAIN_BOUND and not alone.central
    for more in (
        {"region": sos.PoleRegion(0.3, rho=50)},
        {"saturation": sos.Saturation(50, [1, 0, 0, 0])},
    ):
        asked = {"region": sos.PoleRegion(0.3), "gamma": 3.0} | more
        assert sos.design_pid(plant, **asked).reason != centre.NO_GAIN_BOUND


def test_a_gain_that_settles_does_not_depend_on_the_bound(monkeypatch):
    words = centre.NO_BOUND.format(end=centre.SETTLES)
    settled = [x for x in asked_without_centre() if x[1].reason == words]
    monkeypatch.setattr(centre, "LARGE_BOUNDS", centre.LARGE_BOUNDS[-1:])
    others = [(d, sos.design_pid(**asked)) for asked, d in settled]
    compared = [(d, other) for d, other in others if other.reason == words]
    assert len(compared) > examples(2, 3)
    for design, other in compared:
        change = np.abs(design.K - other.K).max()
        assert change < 2e-3 * np.abs(other.K).max()


def test_a_gain_that_no_centre_chooses_is_neither():
    plant = chain(2)
    assert sos.design_lqr(plant, np.eye(4), np.eye(1)).central is None
    K = sos.design_pid(plant, region=sos.PoleRegion(0.1)).K
    assert sos.analyse_pid(plant, K).central is None


def test_of_a_cone_behind_a_delay_the_bound_does_not_matter():
    mass = sos.SecondOrderSystem([[1]], [[1]], [[1]], [[1]])
    design = sos.design_delay_pid(mass, tau=0.1, delta=0.2)
    assert design.status == "feasible" and design.central is False
    assert "bound" in design.reason
    assert design.reason in design._repr_html_().replace("&#x27;", "'")
    assert sos.analyse_delay(mass, design.K, tau=0.1, delta=0.2).central is None


def test_an_acceleration_gain_is_a_centre_or_the_shortest():
    loose = sos.SecondOrderSystem(np.diag([2.0, 0]), np.eye(2), np.eye(2), [[0], [1]])
    assert sos.regularize(loose).central is True
    assert sos.regularize(loose, choose="least norm").central is None


@pytest.mark.parametrize("bounded", [True, False])
def test_the_command_line_says_it_too(bounded, tmp_path, capsys):
    asked = {"plant": {key: [[1]] for key in "MDSB"}, "region": {"sigma": 1}}
    if bounded:
        asked["saturation"] = {"u_max": 9, "x0": [1, 0]}
    file = tmp_path / "mass.json"
    file.write_text(json.dumps(asked), "utf-8")
    assert main(["design", str(file), "--proof", str(tmp_path / "proof.json")]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["central"] is bounded
    assert answer["reason"] == ("" if bounded else centre.NO_SIZE)


@pytest.mark.parametrize("seed", seeds(6))
def test_a_plant_without_inputs_keeps_a_loose_bound(seed):
    """Its solutions have no centre, and it has no gain that could settle."""
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(6, 6)) * 10.0 ** rng.uniform(-2, 2, (6, 1))
    A -= (np.linalg.eigvals(A).real.max() + 0.05) * np.eye(6)
    w, y = rng.normal(size=(6, 1)), rng.normal(size=(1, 6))
    plant = sos.DescriptorSystem(np.eye(6), A, B_w=w, C=y)
    design = sos.analyse_pid(plant, np.zeros((0, 6)), gamma=1e8)
    assert design.status == "feasible" and design.certify().proven
