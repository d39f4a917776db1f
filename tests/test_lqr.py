"""Lemma 2.3 and Theorem 2.4: quadratic cost, against Riccati and chance."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm, solve_continuous_are

import sosbook as sos
from sosbook.book import thesis
from sosbook.plants.descriptor import descriptors
from sosbook.requirements.cost import noise_cost
from sosbook.synthesis import lqr
from tests.cases import crossed, examples, later


def riccati(plant, Q, R, U=None):
    """K and the cost trace X of scipy's Riccati equation."""
    (d,) = descriptors(plant, U)
    A, B, _ = d.state_space()
    X = solve_continuous_are(A, B, Q, R)
    return -np.linalg.solve(R, B.T @ X), np.trace(X)


def light_pendulum(effort=1.0, inertia=1.0):
    """A pendulum on wheels in SI units: masses of a few 1e-4."""
    a, b, c, d, f, e = 4.7e-4, 3.5e-4, 9.6e-4, 0.107, 6.9e-3, 0.0294
    return sos.SecondOrderSystem(
        [[c, b], [b, a * inertia]],
        f * np.array([[1, -1], [-1, 1]]),
        np.diag([-d, 0]),
        e * effort * np.array([[-1], [1]]),
        [[1], [1]],
    )


@pytest.fixture(params=["equation", "LMIs"])
def way(request, monkeypatch):
    """How the optimum of one plant is found: as a user does, or by its LMIs alone."""
    if request.param == "LMIs":
        monkeypatch.setattr(lqr, "riccati_point", lambda *a: None)


@pytest.mark.usefixtures("way")
@pytest.mark.parametrize("U", [None, np.eye(2)])
def test_one_plant_gives_the_riccati_gain(U):
    robot = thesis.example_1().plant
    N = 4 if U is None else 6
    Q, R = np.diag(np.arange(1.0, N + 1)), np.array([[2, 0.5], [0.5, 1]])
    design = sos.design_lqr(robot, Q, R, U)
    K, cost = riccati(robot, Q, R, U)
    assert design.status == "feasible"
    assert np.abs(design.K - K).max() < 1e-6 * np.abs(K).max()
    assert design.request.cost.bound == pytest.approx(cost, rel=2e-4)
    assert design.certify().proven


@settings(max_examples=examples(6, 25), deadline=None, derandomize=True)
@given(seed=st.integers(0, 10**6), n=st.integers(1, 3), by_lmis=st.booleans())
def test_random_plants_give_the_riccati_gain(seed, n, by_lmis):
    """So do the LMIs by themselves, where nobody tells them the equation's point."""
    rng = np.random.default_rng(seed)
    half = rng.normal(size=(n, n))
    plant = sos.SecondOrderSystem(
        half @ half.T + np.eye(n),
        rng.normal(size=(n, n)),
        rng.normal(size=(n, n)),
        rng.normal(size=(n, n)) + 2 * np.eye(n),
    )
    weight = rng.normal(size=(2 * n, 2 * n))
    Q, R = weight @ weight.T + 0.1 * np.eye(2 * n), np.eye(n)
    with pytest.MonkeyPatch.context() as patch:
        if by_lmis:
            patch.setattr(lqr, "riccati_point", lambda *a: None)
        design = sos.design_lqr(plant, Q, R)
    K, _ = riccati(plant, Q, R)
    assert np.abs(design.K - K).max() < 1e-6 * np.abs(K).max()
    assert design.certify().proven


def test_a_singular_weight_is_factored_exactly():
    Q = np.array([[4.0, 2, 0, 0], [2, 1, 0, 0], [0, 0, 0, 0], [0, 0, 0, 3]])
    L, W, V = sos.QuadraticCost(Q, [[4.0]]).factors
    assert L.shape == (4, 2)
    inner = np.diag([1 / w for w in np.diag(W)])
    assert (L @ inner @ L.T).astype(float).tolist() == Q.tolist()
    assert V.astype(float).tolist() == [[0.25]]


@pytest.fixture(scope="module")
def polytope():
    return sos.Polytope(
        [
            light_pendulum(effort, inertia)
            for effort in (0.9, 1.1)
            for inertia in (0.95, 1.05)
        ]
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    "coupling, noise", crossed(["pairs", "slack"], ["states", "F"])
)
def test_the_bound_holds_over_the_polytope(polytope, coupling, noise):
    design = sos.design_lqr(
        polytope,
        np.eye(4),
        [[1]],
        noise=noise,
        coupling=("slack", 0.02) if coupling == "slack" else coupling,
    )
    assert design.status == "feasible"
    assert design.certify().proven
    assert design.noise_cost(samples=60) < design.request.cost.bound


@pytest.mark.campaign  # chapter 18 prints bounds and costs
def test_slack_comes_closer_to_the_truth_than_pairs(polytope):
    pairs = sos.design_lqr(polytope, np.eye(4), [[1]])
    slack = sos.design_lqr(polytope, np.eye(4), [[1]], coupling="slack")
    assert slack.request.cost.bound < pairs.request.cost.bound
    assert slack.noise_cost() < pairs.noise_cost()


def test_no_gain_beats_the_least_of_the_worst(polytope):
    """The polytope's bound is above the Riccati cost of each vertex."""
    bound = sos.design_lqr(polytope, np.eye(4), [[1]]).request.cost.bound
    for vertex in polytope.vertices:
        assert bound > riccati(vertex, np.eye(4), np.eye(1))[1]


def test_cost_is_a_requirement_among_others():
    robot = thesis.example_1()
    Q, R = np.eye(6), np.eye(2)
    least = riccati(robot.plant, Q, R, robot.U)[1]
    fast = sos.PoleRegion(sigma=1.0)
    design = sos.design_pid(
        robot.plant,
        robot.U,
        region=fast,
        requirements=[sos.QuadraticCost(Q, R)],
        minimize="cost",
    )
    assert design.status == "feasible" and design.certify().proven
    assert design.request.cost.bound > 1.1 * least
    assert design.poles().real.max() < -1
    tight = sos.QuadraticCost(Q, R, bound=1.05 * least)
    refused = sos.design_pid(robot.plant, robot.U, region=fast, requirements=[tight])
    assert refused.status == "infeasible" and refused.infeasibility.proven
    alone = sos.design_pid(robot.plant, robot.U, requirements=[tight])
    assert alone.status == "feasible" and alone.certify().proven


def test_a_given_gain_has_its_true_cost_as_least_bound():
    ex = thesis.example_1()
    given_ = sos.analyse_pid(
        ex.plant,
        ex.K,
        ex.U,
        requirements=[sos.QuadraticCost(np.eye(6), np.eye(2))],
        minimize="cost",
        search=sos.Search(backoff=1e-3),
    )
    true = given_.noise_cost()
    assert true < given_.request.cost.bound < 1.01 * true
    assert given_.certify().proven


def test_the_trace_bounds_the_cost_and_its_root_does_not():
    """Lemma 2.3 by Lyapunov and by chance: lambda_max(W) tr J holds."""
    plant = sos.SecondOrderSystem(
        np.eye(2), np.eye(2), [[3, -1], [-1, 2]], np.eye(2), np.eye(2)
    )
    design = sos.design_lqr(plant, 100 * np.eye(4), np.eye(2), noise="F")
    bound = design.request.cost.bound
    (d,) = descriptors(plant)
    A = d.state_space()[0] + d.state_space()[1] @ design.K
    G, W = d.state_space()[2], np.array([[3.0, 1], [1, 2]])
    weight = 100 * np.eye(4) + design.K.T @ design.K
    step, rng = 0.05, np.random.default_rng(1)
    block = np.block([[-A, G @ W @ G.T], [np.zeros((4, 4)), A.T]])
    both = expm(block * step)
    forward = both[4:, 4:].T  # Van Loan (1978)
    root = np.linalg.cholesky(forward @ both[:4, 4:])
    x, costs = np.zeros((4, 400)), []
    for k in range(1200):
        x = forward @ x + root @ rng.normal(size=x.shape)
        if k > 300:
            costs.append(np.mean(np.sum(x * (weight @ x), axis=0)))
    found = np.mean(costs)
    worst = np.linalg.eigvalsh(W)[-1]
    assert 0.5 * worst * bound < found < worst * bound
    assert found > np.sqrt(worst * bound) and found > worst * np.sqrt(bound)


def test_a_mode_at_the_origin_that_no_cost_sees_is_still_moved():
    design = sos.design_lqr(
        sos.SecondOrderSystem([[1]], [[0]], [[0]], [[1]]), np.diag([0.0, 1]), [[1]]
    )
    assert design.status == "feasible" and design.certify().proven
    assert design.poles().real.max() < 0
    assert design.K[0, 1] == pytest.approx(-1, abs=1e-3)  # sqrt(q / r)


@pytest.mark.parametrize(
    "Q, R, words",
    [
        (np.eye(3), [[1]], "Q has 3 rows, needs 4"),
        (np.eye(4), np.eye(2), "R has 2 rows, needs 1"),
        (np.triu(np.ones((4, 4))), [[1]], "Q must be symmetric"),
    ],
)
def test_bad_weights_are_named(Q, R, words):
    with pytest.raises(ValueError, match=words):
        sos.design_lqr(light_pendulum(), Q, R)


def test_noise_on_a_missing_channel_is_refused():
    plant = sos.SecondOrderSystem([[1]], [[1]], [[1]], [[1]])
    with pytest.raises(ValueError, match="no F"):
        sos.design_lqr(plant, np.eye(2), [[1]], noise="F")


def test_a_cost_without_bound_needs_an_objective():
    plant = thesis.example_1().plant
    cost = sos.QuadraticCost(np.eye(4), np.eye(2))
    with pytest.raises(ValueError, match="bound is None"):
        sos.design_pid(plant, requirements=[cost])
    with pytest.raises(ValueError, match="without a bound"):
        sos.design_pid(plant, minimize="cost")


def test_costs_are_infinite_where_the_loop_is_unstable():
    plant = light_pendulum()
    (d,) = descriptors(plant)
    cost = sos.QuadraticCost(np.eye(4), [[1]])
    assert noise_cost(d, np.zeros((1, 4)), cost) == np.inf


def test_a_first_order_plant_has_no_displacements():
    """Without [z; z'; x3] there are no parts of K and no set points."""
    plant = sos.DescriptorSystem(
        np.eye(3), np.diag([1.0, 2, 3]), np.ones((3, 1)), C=np.eye(3)[1:]
    )
    design = sos.design_lqr(plant, np.eye(3), [[1]])
    assert design.status == "feasible" and design.K.shape == (1, 3)
    for wanted in (
        lambda: design.K_P,
        design.closed_loop,
        design.open_loop,
        lambda: design.simulate([0, 1]),
    ):
        with pytest.raises(ValueError, match="its state isn't"):
            wanted()


UNSEEN = {  # S, D and Q of a unit mass beside one that Q sees; the mode, if it bites
    "free": (0.0, 0.0, "at 0 rad/s"),
    "undamped": (4.0, 0.0, "at ±2j rad/s"),
    "undamped, from a root": (2.0, 0.0, "at ±1.414j rad/s"),
    "damped a little": (4.0, 1e-9, ""),
    "unstable": (-4.0, 0.0, ""),
    "free, with friction": (0.0, 0.3, "at 0 rad/s"),
}
NAMED = "undamped, from a root", "damped a little", "free, with friction"


@pytest.mark.parametrize(  # test_least_bounds has a mode of another plant that falls
    "name, factor",
    [
        *((name, 1 / 9.81) for name in NAMED),
        *later(*product(sorted({*UNSEEN}.difference(NAMED)), [1 / 9.81])),
        *later(*product(UNSEEN, [1, 0.3, 2.2046])),
    ],
)
def test_an_optimum_that_no_gain_attains_is_named(name, factor):
    """By the modes of (Q, A) on the imaginary axis, in exact arithmetic."""
    s, d, words = UNSEEN[name]
    M = factor * np.array([[2.0, 0.0], [0.0, 1.0]])
    plant = sos.SecondOrderSystem(
        M, factor * np.diag([0.1, d]), factor * np.diag([3.0, s]), factor * np.eye(2)
    )
    design = sos.design_lqr(plant, np.diag([1.0, 0, 1, 0]), np.eye(2))
    assert ("no gain attains" in design.reason) == bool(words)
    assert words in design.reason
    if name == "unstable":  # P is infinite
        return
    assert design.status == "feasible" and design.certify().proven
    seen = sos.design_lqr(plant, np.diag([1.0, 1, 1, 0]), np.eye(2))
    assert seen.status == "feasible" and seen.reason == ""
    if words:
        assert "no gain attains the least cost: the nearer" in design.reason
        costs = []  # of the optima as the weight of that motion goes to zero
        for share in (1e-2, 1e-4, 1e-6):
            Q = np.diag([1.0, share, 1, 0])
            costs.append(sos.design_lqr(plant, Q, np.eye(2)))
        slowest = [-d.poles().real.max() for d in costs]
        assert slowest[0] > 2 * slowest[1] > 4 * slowest[2]  # ever slower
        mine = design.noise_cost()
        assert mine < costs[0].noise_cost() + 1e-3 * abs(mine)
        inside = sos.PoleRegion(sigma=0.01)
        assert sos.design_lqr(plant, np.diag([1.0, 0, 1, 0]), np.eye(2), region=inside)


def test_what_else_is_asked_of_an_optimal_gain_means_the_same():
    """The least cost beside other bounds is that of `design_pid`, backed off by 1 %."""
    plant = sos.Polytope([sos.SecondOrderSystem(m, 0.1, 1, 1, 1) for m in (1, 1.4)])
    Q, R = np.eye(2), [[1]]
    alone = sos.design_lqr(plant, Q, R).request.cost.bound
    for asked in (
        dict(gamma=0.5),
        dict(gamma=sos.HInfinity(0.5, mu=1.0)),
        dict(saturation=sos.Saturation(0.8, [1, 0])),
        dict(requirements=[sos.LMIRegion.half_plane(0.9)]),
        dict(gamma=0.6, coupling=("slack", 0.5)),
    ):
        found = sos.design_lqr(plant, Q, R, **asked)
        assert found.status == "feasible" and found.certify().proven
        wanted = [sos.QuadraticCost(Q, R), *asked.pop("requirements", ())]
        same = sos.design_pid(plant, requirements=wanted, minimize="cost", **asked)
        bound = found.request.cost.bound
        assert bound == pytest.approx(same.request.cost.bound, rel=0.012)
        assert found.noise_cost(samples=20) < bound
        if "coupling" not in asked:
            assert bound > alone * 1.001
    with pytest.raises(ValueError, match="two requirements are called cost"):
        second = sos.QuadraticCost(Q, R, bound=9.0)
        sos.design_lqr(plant, Q, R, requirements=[second])
