"""Gains of a law: searched, proven, refused by a door, or said to be undecided."""

import copy
import functools
import itertools
import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import eigh, schur

import sosbook as sos
from sosbook.exact.rational import exact
from sosbook.laws.base import plain
from sosbook.plants.reduction import Reduction
from sosbook.runtime import time_limit as clock
from sosbook.synthesis import feasibility
from sosbook.synthesis.request import Request
from sosbook.synthesis.structured import design as structured
from sosbook.synthesis.structured import slopes
from sosbook.synthesis.structured.continuation import further
from sosbook.synthesis.structured.doors import SumOfPoles, mean_pole
from sosbook.synthesis.structured.moving_gain import loops_of
from sosbook.synthesis.structured.objective import Objective, Task
from sosbook.synthesis.structured.search import Found
from tests.cases import by_hand, by_turns, campaign, later
from tests.test_proof_files import held_against

FEW, ONE = sos.Search(starts=2), sos.Search(starts=1)
LAW = sos.PIDLaw(position=[[1, 0]], integrate=True, filter=0.02)


def joint(J, k, length=1.0, force=1.0, time=1.0):
    """A motor and a load; z, u and t in other units."""
    M = np.diag([1.0, J]) * length / time**2
    D = np.array([[0.15, -0.05], [-0.05, 0.05]]) * length / time
    S = np.array([[k, -k], [-k, k]]) * length
    return sos.SecondOrderSystem(M, D, S, [[force], [0]], [[0], [1]])


def arm(**units):
    return sos.Polytope([joint(J, k, **units) for J in (1, 2) for k in (8, 12)])


@pytest.fixture(scope="module")
def base():
    """The fastest loop of the arm."""
    return sos.design_pid(arm(), law=LAW, maximize="sigma", search=FEW)


@functools.cache
def controller(design):
    """That of a design, which hundreds of plants meet."""
    return design.loop.to_ss()


def loop_poles(plant, design):
    """The poles of a plant and the controller of a design, by numpy."""
    c = controller(design)
    A, B, C, D = c.A, c.B, c.C, c.D
    rows = design.request.applied.parts.rows.astype(float)
    plain, push = by_hand(plant)
    return np.linalg.eigvals(
        np.block([[plain + push @ D @ rows, push @ C], [B @ rows, A]])
    )


def test_the_fastest_decay_is_proven_near_the_truth_and_found_by_a_global_search():
    from scipy.optimize import differential_evolution

    design = sos.design_pid(
        arm(), law=LAW, maximize="sigma", search=sos.Search(starts=2, backoff=0.001)
    )
    sigma = design.request.region.sigma
    plants = [*arm().vertices, *arm().sample(200, seed=3)]
    true = -max(loop_poles(p, design).real.max() for p in plants)
    assert 0.998 * true < sigma < true and design.certify().proven
    loops = loops_of(design.request)

    def slowest(logs):
        K = loops.K(-np.exp(logs))
        return np.linalg.eigvals(loops.closed(K)).real.max()

    best = differential_evolution(slowest, [(-4, 4)] * 3, seed=1, maxiter=40, popsize=8)
    assert true > 0.995 * -best.fun


@pytest.mark.parametrize("seed", [1, *campaign([0, 2, 3])])
def test_slopes_are_differences(seed):
    """Of regions, a norm and a cost, also with shared entries and noisy sensors."""
    rng = np.random.default_rng(seed)
    n = 3
    M = np.eye(n) + 0.1 * rng.normal(size=(n, n))
    D, S = np.eye(n) + 0.1 * rng.normal(size=(n, n)), 2 * np.eye(n)
    plant = sos.SecondOrderSystem(M, D, S, rng.normal(size=(n, 2)), np.eye(n))
    C = rng.normal(size=(2, n)).round(2)
    laws = [
        sos.PIDLaw(C, filter=0.1, structure=[["a", "b"], ["-b", "a"]]),
        sos.DynamicLaw(2, C, strictly_proper=False, noise=rng.normal(size=(2, n))),
    ]
    for law in laws:
        region = sos.PoleRegion(sigma=0.1, theta=0.9, rho=30)
        cost = sos.QuadraticCost(np.eye(2 * n + 2), np.eye(2), noise="F", bound=1.0)
        K = law.applied(plant).gain(None)
        d = sos.analyse_pid(
            plant, K, law=law, region=region, gamma=1.0, requirements=[cost]
        )
        loops = loops_of(d.request)
        kappa = 0.05 * rng.normal(size=len(loops.directions))
        if law is laws[1]:  # its own states decay
            kappa[[0, 3]] = -1.0
        for goal in (None, "sigma"):
            for norms in (False, goal is None):
                task = Task.of(d.request, loops, goal)
                f = Objective(task, loops, np.ones(len(kappa)), norms)
                _check(f, kappa, rng)
        N = 0.1 * rng.normal(size=(2 * n + 2, 2))
        mixed = sos.QuadraticCost(np.eye(2 * n + 2), np.eye(2), N=N, bound=1.0)
        for value in (
            lambda K: slopes.norm(loops, K, d.request.owner("gamma"), 2),
            lambda K: slopes.reached(loops, K, cost, 2, np.ones(len(kappa))),
            lambda K: slopes.reached(loops, K, mixed, 2, np.ones(len(kappa))),
        ):

            def f(x, value=value):
                level, T = value(loops.K(x))
                return level, loops.slope(T)

            _check(f, kappa, rng)


def _check(f, x, rng):
    way = rng.normal(size=len(x))
    h = 1e-4
    up, down = (f(x + s * h * way)[0] for s in (1, -1))
    assert np.isfinite(up)
    assert f(x)[1] @ way == pytest.approx((up - down) / (2 * h), rel=5e-3, abs=1e-4)


@pytest.mark.parametrize("goal", [None, "gamma", "sigma"])
def test_nobody_asks_the_slope_of_a_value_that_is_too_high(goal):
    """It is said to be so, soon or by itself; below, nothing is another number."""
    cart, law = sos.SecondOrderSystem(0.3, 0.3, 9.81, 1, F=1), sos.PIDLaw([[1]], [[1]])
    asked = [sos.HInfinity(0.1), sos.LMIRegion.half_plane(0.2)]
    request = Request(cart, law=law, requirements=asked)
    loops, rng, soon = loops_of(request), np.random.default_rng(0), 0
    task = Task.of(request, loops, asked[0] if goal == "gamma" else goal)
    for x in rng.normal(-1, 2, (40, 2)):
        f = Objective(task, loops, np.ones(2), goal != "sigma")
        value, slope = f(x)
        for most in (value - 0.5, value - 1e-6, value + 1e-6):
            f.least = -np.inf  # else its value has to be known to be no less
            v, s = f(x, most)
            if value > most and np.isfinite(value):
                assert s is None and most < v <= value + 1e-9
                soon += v < value
            else:
                assert v == value and (s == slope).all()
    assert (soon > 0) == (goal != "sigma")


@pytest.mark.parametrize(
    "units",
    [
        dict(length=1e-3, force=1e3, time=0.3),
        *campaign([dict(length=0.3, force=9.81), dict(length=1e3), dict(time=1e-3)]),
    ],
)
def test_units_change_nothing(units, base):
    """The same gains in their units, to five digits, and the same bound."""
    size = dict(length=1.0, force=1.0, time=1.0) | units
    law = sos.PIDLaw([[1, 0]], integrate=True, filter=0.02 / size["time"])
    moved = sos.design_pid(arm(**units), law=law, maximize="sigma", search=FEW)
    turn = np.array([1, size["time"], 1 / size["time"]])
    K = moved.K * turn * size["force"] / size["length"]
    assert pytest.approx(base.K, rel=2e-5) == K
    sigma = base.request.region.sigma * size["time"]  # three digits of it
    assert moved.request.region.sigma == pytest.approx(sigma, rel=5e-3)


def test_order_names_and_sizes_of_sensors_change_nothing(base):
    swap = [
        sos.SecondOrderSystem(
            *(x[::-1, ::-1] for x in (v.M, v.D, v.S)), v.B[::-1], v.F[::-1],
            coordinates=("load", "motor"),
        )
        for v in arm().vertices[::-1]
    ]  # fmt: skip
    law = sos.PIDLaw([[0, 3.0]], integrate=True, filter=0.02)
    design = sos.design_pid(sos.Polytope(swap), law=law, maximize="sigma", search=FEW)
    assert pytest.approx(base.K, rel=2e-5) == design.K * 3
    assert "motor alone" in law.words(design.request.plant)


def test_the_same_seed_gives_the_same_gain():
    asked = dict(law=LAW, region=sos.PoleRegion(sigma=0.6), search=sos.Search(seed=7))
    assert (sos.design_pid(arm(), **asked).K == sos.design_pid(arm(), **asked).K).all()


def test_a_norm_falls_to_that_of_a_global_search():
    plant = sos.SecondOrderSystem(1, 0.1, 1, 1, 1)
    law = sos.PIDLaw([[1]], [[1]], limits={"K_P": 3, "K_D": 2})
    how = sos.Search(starts=2, backoff=0.001)
    design = sos.design_pid(plant, law=law, minimize="gamma", search=how)
    assert np.allclose(design.K, [[-3, -2]], rtol=1e-3)  # both limits are reached
    assert design.gamma == pytest.approx(design.hinf(), rel=6e-3)  # three digits
    assert design.certify().proven and "K_P up to 3" in str(design.searched)


@pytest.mark.parametrize("rate, gain", [(0.3, 9.81), *later((1, 500), (1000, 0.3))])
def test_the_fastest_lag_ends_at_its_limit_in_each_unit(rate, gain):
    """s^2 + (rate - gain K_P) s - gain K_I: two equal poles, as K_I allows."""
    lag = sos.DescriptorSystem([[1.0]], [[-rate]], [[gain]])
    law = sos.PIDLaw(position=[[1]], integrate=True)
    one = sos.Search(starts=1)
    design = sos.design_pid(lag, law=law, maximize="sigma", search=one)
    most = design.searched.limits["K_I"]
    sigma = design.request.region.sigma
    assert sigma == pytest.approx(np.sqrt(gain * most), rel=0.02)
    assert "limit: an entry of K_I is" in design.reason


@pytest.mark.campaign  # of the same search, whose limit the test above finds
def test_a_wider_limit_lets_a_lag_be_faster():
    lag = sos.DescriptorSystem([[1.0]], [[-0.3]], [[9.81]])
    law = sos.PIDLaw(position=[[1]], integrate=True)
    one = sos.Search(starts=1)
    design = sos.design_pid(lag, law=law, maximize="sigma", search=one)
    most, sigma = design.searched.limits["K_I"], design.request.region.sigma
    far = sos.PIDLaw([[1]], integrate=True, limits={"K_P": 1e9, "K_I": 1e4 * most})
    far = sos.design_pid(lag, law=far, maximize="sigma", search=one)
    assert far.request.region.sigma > 20 * sigma


def test_a_pole_that_nobody_asked_for_is_named():
    """One pole that every gain leaves at -1, and one that it may move at will."""
    plant = sos.DescriptorSystem(np.eye(2), np.diag([-1.0, -2]), [[0], [1]])
    law = sos.PIDLaw(position=[[0, 1]], limits={"K_P": 500})
    design = sos.design_pid(plant, law=law, maximize="sigma")
    gain = abs(design.K).max()
    assert ("fastest pole is at" in design.reason) == (gain + 2 > 20)


def test_a_plant_between_the_vertices_joins_the_search(monkeypatch):
    """Springs between two whose loop of the first search is the slowest."""
    G = np.array([[-1.0, 1.6], [1.9, 0]])
    springs = sos.Polytope(
        sos.SecondOrderSystem(
            np.eye(2), 0.2 * np.eye(2), np.diag([1, 2]) + k * G, [[1], [0.5]]
        )
        for k in (-1, 1)
    )
    law = sos.PIDLaw(np.eye(2), filter=0.1, limits={"K_P": 2.0, "K_D": 2.0})
    asked = dict(plant=springs, law=law, maximize="sigma", search=ONE)
    design = sos.design_pid(**asked)
    assert design.searched.between and "between the vertices" in str(design.searched)
    plants = [*springs.vertices, *springs.sample(100, seed=5)]
    true = -max(loop_poles(p, design).real.max() for p in plants)
    assert design.request.region.sigma < true and design.certify().proven
    monkeypatch.setattr(structured, "AGAIN", 1)
    first = sos.design_pid(**asked)
    assert not first.searched.between
    assert first.request.region.sigma < design.request.region.sigma


def asked_in(seconds, monkeypatch, **asked):
    """The design by a clock that moves a second at each look, and how many."""
    ticks = itertools.count()
    for module in (clock, feasibility):
        monkeypatch.setattr(module, "monotonic", lambda: float(next(ticks)))
    how = replace(asked.pop("search", sos.Search()), time_limit=seconds)
    design = sos.design_pid(**asked, search=how)
    monkeypatch.undo()
    return design, next(ticks)


def test_a_search_that_is_stopped_has_its_best_gain_proven(monkeypatch):
    """Half of the time is for the search; what it has by then is proven."""
    asked = dict(plant=arm(), law=LAW, maximize="sigma", search=sos.Search(starts=3))
    whole, seconds = asked_in(1e8, monkeypatch, **asked)
    assert whole.status == "feasible" and whole.reason.startswith("The search ended")
    some = 0
    for share in (0.001, 0.9):
        design, _ = asked_in(share * seconds, monkeypatch, **asked)
        if design.status == "undecided":
            assert design.K is None and "raise time_limit" in design.reason
            continue
        some += 1
        assert design.reason.startswith("The time was over before the search was: ")
        assert "starts were begun" in design.reason and "time_limit" in design.reason
        assert design.searched.starts < whole.searched.starts
        assert design.certify().proven
        true = max(loop_poles(p, design).real.max() for p in arm().vertices)
        assert true < -design.request.region.sigma
    assert some


@pytest.mark.parametrize("share", by_turns([0.01, 0.2, 0.4, 0.6, 0.95, 0.8], 2, of=3))
def test_a_search_of_a_cost_that_is_stopped_answers(share, monkeypatch):
    plant = sos.SecondOrderSystem(1, 0.1, 1, 1, 1)
    law = sos.PIDLaw([[1]], filter=0.1)
    cost = sos.QuadraticCost(np.eye(3), [[1]], noise="F")
    asked = dict(
        plant=plant,
        law=law,
        requirements=[cost],
        minimize="cost",
        search=sos.Search(starts=2),
    )
    whole, seconds = asked_in(1e8, monkeypatch, **asked)
    design, used = asked_in(share * seconds, monkeypatch, **asked)
    assert whole.status == "feasible" and used < seconds + 9
    assert design.status == "undecided" or design.certify().proven


def test_how_many_starts_found_nothing_is_said():
    """For s^2 + s = p the poles have (p + 1 - k) (p - 1) = 0.01: one p is positive."""
    S, one = [[1, 0.1], [0.1, -1]], np.eye(2)
    plant = sos.SecondOrderSystem(one, one, S, one, one)
    law = sos.PIDLaw([[1, 0]], structure=[[1], [0]])
    design = sos.design_pid(
        plant, law=law, minimize="gamma", search=sos.Search(starts=3)
    )
    assert design.status == "undecided"
    assert design.reason.startswith("No stable loop of finite norms was found by 3 ")


def test_nothing_is_asked_or_named_that_nobody_asked_for():
    """Neither the number that stands in for a decay, nor a least decay above it."""
    M, S = np.diag([0.0025, 0.004]), 9 * np.array([[1, -1], [-1, 1]])
    plant = sos.SecondOrderSystem(M, S / 450, S, [[1], [0]])
    wide = dict(region=sos.PoleRegion(sigma=0.5, rho=5000))
    law = sos.PIDLaw([[1, 0]], filter=0.01, integrate=True)
    assert (
        sos.design_pid(plant, law=law, **wide, search=sos.Search(starts=1)).status
        == "feasible"
    )
    small = dict(region=sos.PoleRegion(rho=30), law=sos.PIDLaw([[1, 0]]))
    design = sos.design_pid(
        plant, **small, maximize="sigma", search=sos.Search(starts=1)
    )
    assert design.status == "undecided"
    assert "Re s < -1" not in design.reason and "Re s < 0" in design.reason


# the doors


def test_the_sum_of_the_poles_is_a_door():
    design = sos.design_pid(arm(), law=LAW, region=sos.PoleRegion(sigma=8.5))
    assert design.status == "infeasible" and design.infeasibility.verify()
    mean = -(0.15 + 0.05 / 1 + 1 / 0.02) / 6  # at J = 1
    said = float(design.reason.split("least ")[1].split(",")[0])
    assert mean - 2e-5 * abs(mean) < said <= mean
    below = sos.design_pid(arm(), law=LAW, region=sos.PoleRegion(8.3), search=FEW)
    assert below.status == "undecided"


def test_what_all_of_the_state_can_not_do_no_law_can(tmp_path):
    S, B = np.diag([1.0, 4.0]), [[1], [0]]  # the second mass, which w moves, has no u
    plant = sos.SecondOrderSystem(np.eye(2), 0.1 * np.eye(2), S, B, [[0], [1]])
    law = sos.DynamicLaw(2, np.eye(2))
    design = sos.design_pid(plant, law=law, gamma=4.5, search=ONE)  # 5.0 without u
    assert design.status == "infeasible" and design.infeasibility.proven
    assert "all of the state" in design.reason
    held_against(plant, design.infeasibility, tmp_path)


def weak(D, B):
    """Carts whose middle Bernstein coefficient is no plant: D or B is other there."""
    return sos.Uncertain(lambda q: sos.SecondOrderSystem(1, D(q), 1, B(q), 1), q=(0, 1))


def test_doors_are_about_plants_of_a_family_with_powers():
    """Its vertices needn't be plants: damped by -0.8, and without an input."""
    limp = weak(lambda q: 1 - 3.6 * (q - q * q), lambda q: 1)
    weary = weak(lambda q: 0.2, lambda q: 1 - 2 * (q - q * q))
    assert limp.vertices[1].D < 0 and weary.vertices[1].B == 0
    alone, both = sos.PIDLaw([[1]]), sos.PIDLaw([[1]], [[1]])
    for plants, law, asked in (
        (limp, alone, dict(region=sos.PoleRegion(sigma=0.02))),
        (weary, both, dict(region=sos.PoleRegion(sigma=0.5))),
        (weary, both, dict(gamma=0.9)),
    ):
        design = sos.design_pid(plants, law=law, **asked)
        assert design.status == "feasible" and design.certify().proven
    bound = design.bounds()["gamma"]
    assert bound.excluded is None or bound.excluded < design.hinf()
    out = sos.design_pid(limp, law=alone, region=sos.PoleRegion(sigma=0.6))
    assert out.status == "infeasible" and "the plant with q = 0;" in out.reason


def test_an_output_of_the_law_s_states_has_no_door_of_the_plant():
    seen = sos.HInfinity(1e-8, outputs=sos.Output(integral=1))
    mass = sos.SecondOrderSystem(0.3, 0.1, 9.81, 1, 1)
    law = sos.PIDLaw([[1]], integrate=True, filter=0.02)
    design = sos.design_pid(mass, law=law, requirements=[seen], search=ONE)
    assert design.status == "undecided"


def test_what_is_not_found_is_undecided_with_what_was_reached():
    asked = dict(region=sos.PoleRegion(sigma=2), search=sos.Search(starts=3))
    design = sos.design_pid(joint(1.5, 10), law=LAW, **asked)
    assert design.status == "undecided" and design.K is None
    reached = re.search(r"reaches decay rate sigma (\S+) \(asked: 2\)", design.reason)
    assert 1 < float(reached[1]) < 1.6  # no gain has 1.6
    assert not design.certify().proven and "Measure more" in design.advice


@pytest.mark.parametrize("seed", [0, *campaign(range(1, 11))])
def test_random_families_are_sound(seed):
    """Twenty families each, two in the gate: what is proven holds at fifty plants."""
    rng, kept = np.random.default_rng(seed), 0
    for _ in range(20 if seed else 2):
        n = int(rng.integers(1, 4))
        base = [rng.normal(size=(n, n)) for _ in range(3)]
        corners = []
        for k in range(int(rng.integers(1, 4))):
            M = np.eye(n) * (1 + 0.5 * k * rng.random())
            D = np.eye(n) + 0.3 * base[1] + 0.1 * rng.normal(size=(n, n))
            S = np.eye(n) + 0.3 * base[2]
            corners.append(sos.SecondOrderSystem(M, D, S, rng.normal(size=(n, 1))))
        plant = sos.Polytope(corners)
        rows = rng.normal(size=(1, n)).round(2)
        while not rows.any():  # a sensor that sees nothing is refused
            rows = rng.normal(size=(1, n)).round(2)
        law = [
            sos.PIDLaw(rows, filter=0.1), sos.PIDLaw(rows, rows, integrate=True),
            sos.DynamicLaw(1, rows),
        ][int(rng.integers(3))]  # fmt: skip
        design = sos.design_pid(
            plant, law=law, maximize="sigma", search=sos.Search(starts=1)
        )
        if design.status != "feasible":
            assert design.status == "undecided"
            continue
        assert design.certify().proven
        kept += 1
        sigma = design.request.region.sigma
        for p in [*plant.vertices, *plant.sample(50, seed=seed)]:
            assert loop_poles(p, design).real.max() < -sigma
    assert kept > 0


@pytest.mark.parametrize("filtered", [None, 0.1])
@pytest.mark.parametrize("kind", ["one", "polytope", "part"])
def test_a_sum_of_poles_is_a_file_that_says_no_more_than_is_true(kind, filtered):
    """Of the mean it says a number that isn't above it; a changed file is refused."""
    rng = np.random.default_rng(3)
    plants = sos.Polytope(joint(1 + k, 8.0 + k, time=0.3) for k in range(2))
    if kind != "polytope":
        D, B = (
            np.diag(rng.uniform(0.1, 1, 3).round(3)),
            rng.normal(size=(3, 1)).round(2),
        )
        plants = sos.SecondOrderSystem(0.3 * np.eye(3), D, np.diag([1, 2, 9]), B)
    if kind == "part":
        plants = plants.reduce(modes=2)
    law = sos.PIDLaw([np.eye(plants.n)[0]], filter=filtered)
    design = sos.design_pid(plants, law=law, region=sos.PoleRegion(sigma=90.0))
    proof = design.infeasibility
    assert design.status == "infeasible" and isinstance(proof, SumOfPoles)
    assert proof.proven and proof.verify()
    words = "of the reduced model (2 of 3): " * (kind == "part")
    (claim,) = proof.claims
    assert claim.startswith(words + "no gain of the law moves")
    assert design.reason == claim[0].upper() + claim[1:] + "."
    loops, said = (
        loops_of(design.request),
        float(claim.split("least ")[1].split(",")[0]),
    )
    for kappa in rng.normal(size=(5, len(loops.directions))):
        poles = np.linalg.eigvals(loops.closed(loops.K(kappa))[0])
        assert poles.real.mean() >= said - 1e-9 and poles.real.max() > -90
    mean = mean_pole(plain(plants)[0], design.request.applied.parts, loops.directions)
    assert exact(said) <= mean < exact(said + 2e-5 * abs(said))

    def changed(change):
        data = copy.deepcopy(proof.data)
        change(data)
        return SumOfPoles.of(data)

    for change in (
        lambda d: d["requirement"].update(sigma="0.001"),
        lambda d: d["gains"].append([["1"], ["1"], ["1"]]),
        lambda d: d["law"]["rows"][0].__setitem__(plants.n, "1"),  # sees a velocity
        lambda d: d["plant"]["vertices"][0]["D"][0].__setitem__(0, "70000"),
        lambda d: d.update(vertex=7),
        lambda d: d.update(vertex=-1),
        lambda d: d.update(U=[["1"] * plants.n]),
        lambda d: d["plant"].update(reduced=[1, 9]),
    ):
        assert not changed(change).proven
    assert changed(lambda d: None) == proof


UNDAMPED = {
    "a norm": dict(gamma=10.0),
    "the least norm": dict(minimize="gamma"),
    "the fastest decay": dict(maximize="sigma"),
    "a sector": dict(region=sos.PoleRegion(theta=1.0)),
    "an input bound": dict(saturation=sos.Saturation(9, [1, 0, 0, 0])),
}


@pytest.mark.parametrize("asked", UNDAMPED)
@pytest.mark.parametrize("unit", [0.3e-3, 9.81e3, *campaign([1.0])])
def test_positions_alone_never_damp_what_is_undamped(asked, unit, tmp_path):
    """Whatever is asked, the loop is stable; the sum of its poles stays zero."""
    M, S, B = np.diag([1, 2]), np.array([[2, -1], [-1, 2]]), [[unit], [0]]
    free = sos.SecondOrderSystem(unit * M, np.zeros((2, 2)), unit * S, B, F=[[0], [1]])
    law = sos.PIDLaw(np.eye(2))
    design = sos.design_pid(
        free, law=law, search=sos.Search(starts=2), **UNDAMPED[asked]
    )
    proof = design.infeasibility
    assert design.status == "infeasible" and isinstance(proof, SumOfPoles)
    assert proof.claims[0].endswith("its poles lie left of the imaginary axis")
    held_against(free, proof, tmp_path)
    data = copy.deepcopy(proof.data)
    data["plant"]["vertices"][0]["D"][0][0] = "0.001"
    assert not SumOfPoles.of(data).proven


def test_the_sum_of_the_poles_refuses_what_only_their_mean_would_keep():
    """All poles left of their mean there are none: the theorem has no gap at it."""
    cart = sos.SecondOrderSystem([[0.3]], [[0.3]], [[9.81]], [[1]])
    for sigma, status in ((0.5, "infeasible"), (0.499, "feasible")):
        design = sos.design_pid(
            cart, law=sos.PIDLaw([[1]]), region=sos.PoleRegion(sigma=sigma)
        )
        assert design.status == status


def test_a_search_goes_on_where_a_norm_is_lost(monkeypatch):
    """At a pole on the axis, to rounding, the pencil is singular: that point is bad."""
    honest, asked = slopes.norm, itertools.count(1)

    def norm(*words):
        if next(asked) % 5 == 0:
            raise np.linalg.LinAlgError("Singular matrix")
        return honest(*words)

    monkeypatch.setattr(slopes, "norm", norm)
    cart = sos.SecondOrderSystem([[0.3]], [[0.3]], [[9.81]], [[1]], F=[[1]])
    law = sos.PIDLaw([[1]], [[1]], limits={"K_P": 3, "K_D": 2})
    design = sos.design_pid(
        cart, law=law, minimize="gamma", search=sos.Search(starts=1)
    )
    assert next(asked) > 20 and design.searched is not None
    assert "gave up" not in design.reason


def test_a_goal_is_asked_for_more_until_a_twentieth_is_left():
    for limit, harder in ((1.0, 1), (3.7, 1), (900.0, 1), (0.02, -1)):
        asked = []

        def ask(level, kappa, limit=limit, harder=harder, asked=asked):
            asked.append(level)
            kept = harder * (limit - level) >= 0
            return Found(np.array([level]) if kept else kappa, 0.5 - kept, 1)

        one = Found(np.ones(1), -1.0, 1)
        best, ended = further(one, lambda kappa: kappa[0], ask, harder)
        assert 1 <= (limit / best.kappa[0]) ** harder < 1.05
        assert ended.missed in asked and (limit > 1 or len(asked) == 1 or harder < 0)


@pytest.mark.parametrize("zeta", [1e-4, 0.03, 0.3])
@pytest.mark.parametrize("omega", [0.3, 981.0])
def test_the_peak_of_a_damped_mode_is_found_to_many_digits(zeta, omega):
    """Of 1 / (omega^2 - w^2 + 2 i zeta omega w), by its closed form."""
    mode = sos.SecondOrderSystem(1, 2 * zeta * omega, omega**2, 1, F=1)
    law = sos.PIDLaw(position=[[1]])
    request = Request(mode, requirements=[sos.HInfinity(1.0)], law=law)
    loops = loops_of(request)
    value, _ = slopes.norm(loops, 0 * loops.first, request.requirements[0], 1)
    peak = 1 / (2 * zeta * np.sqrt(1 - zeta**2) * omega**2)
    assert value == pytest.approx(peak, rel=1e-8, abs=0)


def test_free_masses_that_are_seen_badly_are_no_matter_of_units():
    slow = sos.SecondOrderSystem(
        [[10.6362, 0.162475], [0.162475, 2.94623]],
        [[0.0073884, -0.00608104], [-0.00608104, 0.0495649]],
        np.zeros((2, 2)),
        [[-0.938927, 1.01095], [-2.17173, 0.161174]],
        F=[[1.35351], [-0.0585743]],
    )
    law = sos.DynamicLaw(1, [[0, -2.03], [-0.78, 0.69]])
    design = sos.design_pid(
        slow, law=law, gamma=6180.0, search=sos.Search(starts=2, seed=1)
    )
    assert "gave up" not in design.reason


HUNG = sos.SecondOrderSystem(  # the second and third angle turn together
    np.diag([0.3, 0.5, 2.2046]), np.diag([0.1, 0, 0]),
    [[9.81, -1, 1], [0.7, 3, -3], [-0.2, -3, 3]], [[1], [0.3], [0]],
)  # fmt: skip
TWINS = sos.SecondOrderSystem(
    0.3 * np.eye(3), 0.3 * np.eye(3),
    9.81 * np.array([[2, -1, 0], [-1, 2, -1], [0, -1, 2]]), [[1], [0], [0]],
)  # fmt: skip
MODES = {  # a plant, a law, a decay that the mode breaks, and who can't move it
    "rates alone": (HUNG, sos.PIDLaw(velocity=np.eye(3)), 0.01, "No controller"),
    "memory": (HUNG, sos.DynamicLaw(2, velocity=np.eye(3)), 0.01, "No controller"),
    "a node": (TWINS, sos.DynamicLaw(1, [[0, 1, 0]]), 0.51, "No controller"),
    "no input": (
        sos.SecondOrderSystem(0.3 * np.eye(2), 0.3 * np.eye(2),
                              np.diag([9.81, 2]), [[1], [0]]),
        sos.PIDLaw(np.eye(2), np.eye(2)), 0.51, "No controller",
    ),
    "two integrals": (
        sos.Polytope([joint(1, 8), joint(2, 8)]),
        sos.PIDLaw(np.eye(2), filter=0.3, integrate=True), 0.01, "No gain of the law",
    ),
}  # fmt: skip


ADVISED = {  # plant, what is measured, decay, whether a memory does it
    "near": (joint(0.3, 9.81), [[0, 1]], None, 2.0, True),
    "rates of the far side": (joint(0.3, 9.81), [[0, 1]], [[0, 1]], 3.0, True),
    "rates alone": (joint(0.3, 9.81), None, [[0, 1]], 2.0, False),
}


@pytest.mark.parametrize("name", ADVISED)
def test_another_law_is_advised_where_it_does_what_was_asked(name):
    """An observer, or a memory: the advice is followed as it is printed."""
    plant, position, velocity, sigma, does = ADVISED[name]
    lag = 0.05 if velocity is None else None
    law = sos.PIDLaw(position, velocity, filter=lag, limits={"K_D": 1})
    asked = dict(region=sos.PoleRegion(sigma=sigma))
    refused = sos.design_pid(plant, law=law, search=sos.Search(starts=1), **asked)
    advised = "as tried." in refused.advice
    assert refused.status != "feasible" and advised == does
    if does:
        error = re.search(
            r"design_observer.*PoleRegion\(sigma=(\S+)\)\)", refused.advice
        )
        if error:
            rows = [([0, 0] if x is None else x[0]) for x in (position, velocity)]
            seen = np.kron(np.eye(2), rows)[[0, 3]]
            seen = seen[seen.any(axis=1)]
            place = sos.PoleRegion(sigma=float(error[1]))
            K = sos.design_pid(plant, **asked).K
            found = sos.design_observer(plant, K, C=seen, region=place)
        else:
            more = sos.DynamicLaw(4, position, velocity)
            found = sos.design_pid(plant, law=more, **asked)
        poles = np.ravel(found.poles())
        assert len(poles) == 8 and poles.real.max() < -sigma


@pytest.mark.parametrize("name", MODES)
def test_a_mode_that_no_gain_of_the_law_moves_is_a_door(name, tmp_path):
    plant, law, sigma, who = MODES[name]
    asked = dict(law=law, search=sos.Search(starts=1))
    design = sos.design_pid(plant, **asked, region=sos.PoleRegion(sigma=sigma))
    proof = design.infeasibility
    assert design.status == "infeasible" and design.reason.startswith(who)
    assert proof.verify() and design.advice.endswith("Measure more, or ask for less.")
    held_against(plant, proof, tmp_path)
    loops, rng = loops_of(design.request), np.random.default_rng(1)
    for kappa in rng.normal(size=(5, len(loops.directions))):
        poles = np.linalg.eigvals(loops.closed(loops.K(kappa))[0])
        assert abs(poles - proof.mode).min() < 1e-6 and proof.mode.real > -sigma
    if name == "a node":  # slower than the mode is possible
        slow = sos.design_pid(plant, **asked, region=sos.PoleRegion(sigma=0.2))
        assert slow.status == "feasible"
    if name == "rates alone":  # a spring to the wall, and no mode stays
        held = sos.SecondOrderSystem(
            HUNG.M, HUNG.D, HUNG.S + np.diag([0, 0, 1]), HUNG.B
        )
        region = sos.PoleRegion(sigma=1e-4)
        assert sos.design_pid(held, **asked, region=region).status != "infeasible"
        design = sos.design_pid(plant, **asked, maximize="sigma")
        assert design.status == "infeasible" and "It violates stab" in design.reason


def modes(count):
    """Modes of a chain of masses, whose numbers have all digits, as E, A, B, F, rows of
    two accelerometers, which are late by 0.3 s, and of two positions.
    """
    spring = 9.81 * (2 * np.eye(20) - np.eye(20, k=1) - np.eye(20, k=-1))
    square, V = eigh(spring, 0.3 * np.eye(20))
    square, V, none = square[:count], V[:, :count], np.zeros((2, count))
    rate = np.hstack([none, V[[19, 9]] / 0.3, -np.eye(2) / 0.3])
    still = np.hstack([V[[19, 9]], none, 0 * np.eye(2)])
    A = np.zeros((2 * count + 2, 2 * count + 2))
    A[:count, count:-2] = np.eye(count)
    A[count:-2, :-2] = -np.hstack([np.diag(square), np.diag(0.02 * square**0.5)])
    A[-2:] = rate
    B, F = (np.r_[0 * V[0], push, 0, 0][:, None] for push in (V[19], V.sum(axis=0)))
    return (np.eye(len(A)), A, B, F), {"accelerations": rate, "positions": still}


@pytest.mark.parametrize("seen", ["accelerations", "positions"])
def test_a_mode_of_the_integrals_is_a_door_before_a_norm_is_searched(seen):
    """One input and two integrals: some mixture of them rests, whatever K_I is."""
    matrices, sensors = modes(6)
    law = sos.PIDLaw(position=sensors[seen], integrate=True, filter=0.05)
    norm = sos.HInfinity(10.0, outputs=sos.Output(state=sensors["positions"]), name="x")
    plant = sos.DescriptorSystem(*matrices)
    design = sos.design_pid(plant, law=law, requirements=[norm])
    proof = design.infeasibility
    assert design.status == "infeasible" and design.searched is None
    assert proof.verify() and proof.mode == 0
    loops, rng = loops_of(design.request), np.random.default_rng(1)
    for kappa in rng.normal(size=(5, len(loops.directions))):
        poles = np.linalg.eigvals(loops.closed(loops.K(kappa))[0])
        assert abs(poles).min() < 1e-9


def test_rounded_gains_keep_the_structure():
    law = sos.PIDLaw(np.eye(2), filter=0.1, structure=[["a", "b"], ["-b", "a"]])
    plant = sos.SecondOrderSystem(np.eye(2), np.eye(2), np.eye(2), np.eye(2))
    design = sos.design_pid(plant, law=law, region=sos.PoleRegion(sigma=0.3))
    K = design.gains["K_P"]
    assert K[0, 0] == K[1, 1] and K[0, 1] == -K[1, 0]
    assert (exact(K) * 10**9).astype(float).max() < 10**12


BAD = {
    "maximize is given without law": dict(maximize="sigma"),
    'maximize must be None or "sigma"': dict(law=LAW, maximize="gamma"),
    "minimize and maximize are given": dict(
        law=LAW, maximize="sigma", minimize="gamma"
    ),
    "give sigma or maximize": dict(
        law=LAW, maximize="sigma", region=sos.PoleRegion(sigma=1)
    ),
    "search has prefer": dict(law=LAW, search=sos.Search(prefer="least")),
    "coupling=('slack', 1.0)": dict(law=LAW, coupling=("slack", 1.0)),
    "coupling='slack'": dict(law=LAW, coupling="slack"),
    "x0 has 5 entries, needs the plant's 4, or with the law's = 6": dict(
        law=LAW, saturation=sos.Saturation(9.0, [1, 0, 0, 0, 0])
    ),
    "searched for poles, and for bounds that": dict(
        plant=joint(1, 8),
        law=LAW,
        saturation=sos.Saturation(9.0, [1, 0, 0, 0, 0, 0], acceleration=True),
    ),
}


@pytest.mark.parametrize("words", BAD)
def test_bad_input_is_named(words):
    with pytest.raises(ValueError) as told:
        sos.design_pid(**dict(plant=arm()) | BAD[words])
    assert words in str(told.value)


def noisy_spring():
    """x' = A x + B1 w + B u, y = x1 + 0.5 w2, z = [x1; 0.2 u]."""
    B1 = [[0, 0], [1, 0]]
    plant = sos.DescriptorSystem(
        np.eye(2), [[0, 1], [-1, -0.1]], [[0], [1]], B1, [[1, 0], [0, 0]],
        [[0], [0.2]],
    )  # fmt: skip
    return plant, sos.PIDLaw([[1, 0]], noise=[[0, 0.5]])


def best_of_any_order(d, C, of_u, of_y):
    """The least norm of all controllers, by the two Riccati equations (DGKF 1989)."""

    def stable(A, R, Q):
        """X with A'X + X A + X R X + Q = 0 and A + R X stable, or None."""
        n = len(A)
        Z = schur(np.block([[A, R], [-Q, -A.T]]), sort="lhp")[1]
        X = np.linalg.solve(Z[:n, :n].T, Z[n:, :n].T)
        poles = np.linalg.eigvals(A + R @ X)
        settles = poles.real.max() < -1e-7 * np.abs(poles).max()
        return X if settles and np.linalg.eigvalsh(X + X.T).min() > -1e-9 else None

    def kept(g):
        B1, B2, C1 = d.Bw, d.Bu, d.C
        X = stable(d.A, B1 @ B1.T / g**2 - B2 @ B2.T / of_u**2, C1.T @ C1)
        Y = stable(d.A.T, C1.T @ C1 / g**2 - C.T @ C / of_y**2, B1 @ B1.T)
        some = X is not None and Y is not None
        return some and np.abs(np.linalg.eigvals(X @ Y)).max() <= g**2

    best = 1000.0
    for step in (0.9, 0.99, 0.999):  # from above: below the best anything goes
        while kept(step * best):
            best *= step
    return best


def test_no_controller_of_any_order_does_what_multipliers_exclude():
    plant, law = noisy_spring()
    design = sos.design_pid(plant, law=law, minimize="gamma", search=ONE)
    bound = design.bounds()["gamma"]
    (d,) = plant.vertices
    best = best_of_any_order(d, np.array([[1.0, 0]]), 0.2, 0.5)
    assert 0.95 * best < bound.excluded < best < bound.proven
    assert bound.refusal.verify()
    assert "no linear controller keeps" in repr(design.bounds())
    below = sos.design_pid(plant, law=law, gamma=bound.excluded, search=ONE)
    assert below.status == "infeasible" and "of any order" in below.reason


@pytest.mark.campaign  # in the gate test_any_order compares a search with the least
def test_a_law_of_the_plant_s_order_comes_near_the_least_of_all():
    plant, _ = noisy_spring()
    best = best_of_any_order(plant.vertices[0], np.array([[1.0, 0]]), 0.2, 0.5)
    law = sos.DynamicLaw(2, [[1, 0]], noise=[[0, 0.5]])
    full = sos.design_pid(plant, law=law, minimize="gamma", search=ONE)
    assert best < full.gamma < 1.1 * best


def test_what_excludes_every_controller_of_a_part_says_so():
    plant, law = noisy_spring()
    (d,) = plant.vertices
    part = sos.DescriptorSystem.of([d], Reduction(2, 5))
    assert part.reduction.of == 5 and part.at([1.0]) == part
    design = sos.design_pid(part, law=law, gamma=0.1, search=sos.Search(starts=1))
    words = "Of the reduced model (2 of 5): no linear controller of any order"
    assert design.status == "infeasible" and design.reason.startswith(words)
    (claim,) = design.infeasibility.claims
    words = "of the reduced model (2 of 5): no linear controller of any order"
    assert claim.startswith(words)
    weak = sos.SecondOrderSystem(
        np.eye(3), 0.1 * np.eye(3), np.diag([1, 4, 9]), [[1], [0], [0]]
    ).reduce(modes=2)
    asked = dict(law=sos.DynamicLaw(2, [[1, 0]]), region=sos.PoleRegion(0.5))
    design = sos.design_pid(weak, **asked, search=sos.Search(starts=1))
    words = "Of the reduced model (2 of 3): no controller moves the mode of the plant"
    assert design.status == "infeasible" and design.reason.startswith(words)
    (claim,) = design.infeasibility.claims
    assert claim.startswith("of the reduced model (2 of 3): no controller with these")


def test_the_worst_plant_between_the_ends_of_one_range_is_searched_with():
    """The best gain of both ends breaks halfway, where a next search looks, too."""
    turn = np.array([[1.21, -1.1], [-1.1, 1]])
    soft = np.array([[-0.21, -0.465], [-0.465, -0.18]])
    S = np.array([[3.7, -3], [-3, 3]])
    plants = sos.Uncertain(
        lambda a: sos.SecondOrderSystem(
            np.diag([0.9, 1]) + a * turn, 0.02 * S, S + a * soft, [[1], [0.6]]
        ),
        a=(0, 7.7),
    )
    design = sos.design_pid(
        plants,
        law=sos.PIDLaw(np.eye(2), np.eye(2)),
        region=sos.PoleRegion(0.1),
        search=sos.Search(starts=4),
    )
    assert design.searched.between and design.certify().proven
    K = design.K
    for a in np.linspace(0, 7.7, 78):
        A, B = by_hand(plants.at(a=a))
        assert np.linalg.eigvals(A + B @ K).real.max() < -0.1


LAWS = [
    sos.PIDLaw(position=[[1]], velocity=[[1]]),
    sos.PIDLaw(position=[[1]], filter=0.02),
    sos.PIDLaw(position=[[1]], velocity=[[1]], integrate=[[1]]),
    sos.DynamicLaw(order=2, position=[[1]]),
]


@pytest.mark.parametrize("law", LAWS, ids=["PD", "filter", "PID", "dynamic"])
@pytest.mark.parametrize("pole", [1.0, 3.0, 9.81**0.5, 9.81**0.5 / 0.3])
def test_a_pendulum_s_pole_is_no_rate_to_measure_sizes_at(pole, law):
    """Its answer is infinite there: units of gains came from a singular matrix."""
    pendulum = sos.SecondOrderSystem(1, 0, -(pole**2), 1)
    region = sos.PoleRegion(sigma=0.1 * pole)
    design = sos.design_pid(pendulum, law=law, region=region)
    assert design.status == "feasible", design.reason
    assert design.certify().proven
