"""A time limit is asked for in every loop that may be long, exact ones too."""

import itertools

import numpy as np
import pytest
from flint import fmpq_mat, fmpq_poly

import sosbook as sos
from sosbook.analysis.linear import peak_gain
from sosbook.analysis.riccati import lyapunov, riccati
from sosbook.exact.adjoint import adjoint
from sosbook.exact.algebraic import _Factor
from sosbook.exact.definite import definite, exact, pivots, semidefinite
from sosbook.exact.proof import Examined
from sosbook.exact.rational import AT_ONCE
from sosbook.exact.repair import repair_multipliers
from sosbook.lmi import LMIProblem, Unknown, he, symmetric
from sosbook.plants.controllability import FixedPart, fixed_part, is_singular, matrix_of
from sosbook.requirements.weights import square_factors
from sosbook.runtime import time_limit as clock
from sosbook.solver.newton import _conjugate_gradients
from sosbook.studies import maps
from sosbook.synthesis import feasibility
from sosbook.synthesis.fixed_mode import refuse_by_mass, refuse_by_mode
from sosbook.synthesis.request import Request
from sosbook.synthesis.scaled_lmis import ScaledLMIs
from sosbook.synthesis.scaling import Frame
from sosbook.synthesis.small_input import refuse_by_input
from tests.cases import campaign, crossed

SMALL, LARGE = exact(np.eye(5) + 1), exact(np.eye(40) + 1)
P, Q9 = Unknown("P", 2, symmetric=True), symmetric("Q", 9)
LYAPUNOV = {"P": exact(np.eye(2)) @ P, "decay": he(exact(np.eye(2)) @ P)}
ZS = [exact(np.eye(2)), exact(np.eye(2))]


def polytope(*masses):
    n = len(masses[0])
    parts = np.eye(n), np.eye(n), np.eye(n), np.eye(n)
    return sos.Polytope([sos.SecondOrderSystem(np.diag(M), *parts) for M in masses])


ONE = sos.SecondOrderSystem(np.eye(2), 0.1 * np.eye(2), [[2, -1], [-1, 1]], [[1], [0]])
POLES = Request(ONE, region=sos.PoleRegion(sigma=1))
FALL = Request(
    sos.SecondOrderSystem([[1.0]], [[0.1]], [[-2.0]], [[1.0]]),
    saturation=sos.Saturation(1.0, [1.0, 0.0]),
)
PAIRS = Request(polytope([1, 2], [1, 3], [2, 2]))
WRITTEN = dict(text=["P: P > 0"], data={}, sets={}, unknowns={"P": "symmetric 1"},
               point={"P": [["1"]]})  # fmt: skip
EXACT = {  # what runs for long where a request is large
    "pivots": lambda: pivots(SMALL),
    "definite, small": lambda: definite(SMALL),
    "definite, large": lambda: definite(LARGE),
    "semidefinite": lambda: semidefinite(SMALL),
    "adjoint": lambda: adjoint(list(LYAPUNOV.values()), [P], ZS),
    "repair": lambda: repair_multipliers(
        list(LYAPUNOV.values()), [P], [np.eye(2), np.eye(2)]
    ),
    "a text": lambda: Examined.by_kernel(WRITTEN, (), {}),
    "fixed part": lambda: fixed_part(*(exact(x) for x in _plant())),
    "modes": lambda: refuse_by_mode(POLES),
    "masses": lambda: refuse_by_mass(PAIRS),
    "small input": lambda: refuse_by_input(FALL, feasibility.search),
    "blocks in rationals": lambda: PAIRS.in_unknowns(Frame.of(PAIRS), exact),
    "a proof": lambda: Examined.of({"P": SMALL}, ()),
    "phase one": lambda: ScaledLMIs(POLES, Frame.of(POLES)).find(),
}


def _plant():
    d = POLES.vertices[0]
    return d.E, d.A, d.Bu


@pytest.mark.parametrize("name", EXACT)
def test_each_long_loop_ends_with_the_time(name, monkeypatch):
    EXACT[name]()  # without a limit it ends by itself
    with clock.time_limit(1.0), pytest.raises(clock.OutOfTime):
        monkeypatch.setattr(clock, "monotonic", lambda: float("inf"))
        EXACT[name]()


WIDE = np.random.default_rng(1).standard_normal((30, 30))
LONG = {  # each takes many looks at the clock: the time may end in the middle
    "reading": lambda: exact(np.zeros(9 * AT_ONCE)),
    "a weight of low rank": lambda: square_factors(exact(np.eye(9))),
    "singular": lambda: is_singular(matrix_of(exact(np.eye(9)))),
    "reach": lambda: fixed_part(*map(exact, (np.eye(20), np.eye(20, k=1), np.eye(20)))),
    "a norm": lambda: peak_gain(WIDE - 30 * np.eye(30), WIDE, WIDE),
    "a linear objective": lambda: LMIProblem({"Q": Q9}).minimize(
        np.ones((9, 9)) @ Q9, start={"Q": np.eye(9)}
    ),
    "conjugate gradients": lambda: _conjugate_gradients(
        lambda d: np.arange(1, 31.0) * d, np.ones(30), lambda r: r, 1e-9, 99
    ),
}


@pytest.mark.parametrize("name", LONG)
def test_a_long_loop_looks_at_the_clock_again_and_again(name, monkeypatch):
    monkeypatch.setattr("sosbook.analysis.linear.MOST_ENTRIES", 900)
    ticks = itertools.count()
    with clock.time_limit(1.0), pytest.raises(clock.OutOfTime):
        now = clock.monotonic()
        monkeypatch.setattr(clock, "monotonic", lambda: now + (next(ticks) > 4) * 1e9)
        LONG[name]()
    assert next(ticks) == 6


AHEAD = {  # what no clock can stop isn't begun where it would end too late
    "a Riccati equation": lambda: riccati(*[np.eye(3)] * 4),
    "a rate": lambda: Request(ONE).typical_rate,
    "a Lyapunov equation": lambda: lyapunov(np.eye(3), np.eye(3)),
    "a polynomial": lambda: FixedPart(None, fmpq_mat([[1, 2], [3, 4]])).modes(),
    "its roots": lambda: _Factor(fmpq_poly([1] * 30)).balls(64),
}


@pytest.mark.parametrize("name", AHEAD)
def test_a_step_that_takes_longer_than_is_left_is_not_begun(name, monkeypatch):
    AHEAD[name]()
    monkeypatch.setattr(clock, "SECONDS_OF_EIGENVALUES", 1e6)
    monkeypatch.setattr("sosbook.plants.controllability.SECONDS_FOR_A_BIT", 1e6)
    monkeypatch.setattr("sosbook.exact.algebraic.DEGREE_OF_A_SECOND", 0.1)
    with clock.time_limit(999.0), pytest.raises(clock.OutOfTime) as stopped:
        AHEAD[name]()
    assert "before 999 s were over" in stopped.value.words(999)


def test_the_limit_of_somebody_else_is_not_taken_for_ones_own():
    loop = Request(ONE, region=sos.PoleRegion(sigma=1))
    with clock.time_limit(5.0), pytest.raises(clock.OutOfTime):
        feasibility.guarded(loop, 60.0, lambda: clock.check_time(ahead=9.0))
    own = feasibility.guarded(loop, 5.0, lambda: clock.check_time(ahead=9.0))
    assert own.status == "undecided" and "before 5 s were over" in own.reason


@pytest.mark.parametrize(
    "ask, dense", crossed(["design_pid", "analyse_pid", "design_lqr"], [False, True])
)
def test_a_larger_request_has_an_answer_wherever_its_time_ends(ask, dense, monkeypatch):
    """The clock moves by one at each look, and soon after the end there is none."""
    n = 12
    turn = np.linalg.qr(np.random.default_rng(3).standard_normal((n, n)))[0]
    turn = turn if dense else np.eye(n)
    S = turn @ (2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)) @ turn.T
    S = (S + S.T) / 2
    plant = sos.SecondOrderSystem(np.eye(n), 0.1 * S, S, np.eye(n)[:, ::4])
    asked = {
        "design_pid": ((plant,), {"region": sos.PoleRegion(sigma=0.01)}),
        "analyse_pid": ((plant, np.zeros((3, 2 * n))), {}),
        "design_lqr": ((plant, np.eye(2 * n), np.eye(3)), {}),
    }
    (given, more), ticks = asked[ask], itertools.count()
    for module in (clock, feasibility):
        monkeypatch.setattr(module, "monotonic", lambda: next(ticks))
    monkeypatch.setattr(clock, "SECONDS_OF_EIGENVALUES", 0.0)
    begun = next(ticks)
    whole = sos.Search(time_limit=1e9)
    assert getattr(sos, ask)(*given, **more, search=whole).status == "feasible"
    total = next(ticks) - begun
    assert total > 15
    for limit in (1, 2, 5, total // 7, total // 3, total // 2):
        begun = next(ticks)
        design = getattr(sos, ask)(*given, **more, search=sos.Search(time_limit=limit))
        assert design.status == "feasible" or design.reason
        assert next(ticks) - begun < limit + 20


REQUESTS = {
    "feasible": dict(plant=ONE, region=sos.PoleRegion(sigma=0.1, rho=5)),
    "too little force": dict(plant=FALL.plant, saturation=FALL.saturation),
    "too fast": dict(
        plant=FALL.plant,
        saturation=sos.Saturation(1, [1, 0]),
        region=sos.PoleRegion(sigma=5),
    ),
    "minimised": dict(
        plant=FALL.plant,
        saturation=sos.Saturation(None, [1, 0]),
        region=sos.PoleRegion(rho=9),
        minimize="u_max",
    ),
    "slack": dict(plant=PAIRS.plant, coupling="slack"),
    "singular": dict(plant=polytope([1, 2], [1, -3])),
}


@pytest.mark.parametrize("name", [*list(REQUESTS)[:-1], *campaign(["singular"])])
def test_wherever_the_time_ends_there_is_an_answer(name, monkeypatch):
    """The clock moves by one at each question: it runs out at any of them."""
    asked = dict(REQUESTS[name])
    whole = sos.design_pid(**asked).status
    ticks = itertools.count()
    for module in (clock, feasibility):
        monkeypatch.setattr(module, "monotonic", lambda: next(ticks))
    begun = next(ticks)
    assert sos.design_pid(**asked, search=sos.Search(time_limit=1e9)).status == whole
    total = next(ticks) - begun
    for limit in sorted({1, 2, *np.linspace(1, total, 5).astype(int).tolist()}):
        begun = next(ticks)
        design = sos.design_pid(**asked, search=sos.Search(time_limit=limit))
        assert design.status in (whole, "undecided")
        if design.status == "undecided":
            assert design.reason
        assert next(ticks) - begun < limit + 20  # and soon


LATE = sos.SecondOrderSystem(*[[[1.0]]] * 5)
PROVEN = {
    "design": lambda: sos.design_pid(ONE),
    "delay": lambda: sos.design_delay_pid(LATE, tau=0.1, delta=0.1),
    "regularization": lambda: sos.regularize(polytope([0.0, 1.0]), beta=0.1),
    "observer": lambda: sos.design_observer(
        LATE, sos.design_pid(LATE).K, np.eye(4)[:, :1], [[1.0]]
    ),
    "sampled": lambda: sos.design_sampled_lqr(LATE, np.eye(2), [[1.0]], T=0.1),
}


@pytest.mark.parametrize("name", PROVEN)
def test_a_proof_that_has_no_time_says_so(name):
    result = PROVEN[name]()
    assert result.certify(time_limit=600).proven
    stopped = result.certify(time_limit=1e-9)
    assert not stopped.proven and not stopped.verify() and stopped.claims == ()
    assert str(stopped) == "not proven: stopped after 1e-09 s; raise time_limit"
    with clock.time_limit(1e-9), pytest.raises(clock.OutOfTime):
        result.certify(time_limit=600)  # the outer limit is somebody else's


def test_an_observer_takes_a_limit():
    plant = sos.SecondOrderSystem([[1]], [[0.1]], [[-1]], [[1]], [[1]])
    asked = dict(K=sos.design_lqr(plant, np.eye(2), [[1]]).K, R_F=[[0.1]])
    asked["Q_F"] = [[0], [1], [0], [0]]
    whole = sos.design_observer(plant, **asked, time_limit=1e9)
    assert whole.status == "feasible" and not whole.reason and not whole.advice
    stopped = sos.design_observer(plant, **asked, time_limit=1e-9)
    assert stopped.status == "undecided" and stopped.L is None
    assert "1e-09 s: raise time_limit" in stopped.reason == stopped.advice
    with clock.time_limit(1e-9), pytest.raises(clock.OutOfTime):
        sos.design_observer(plant, **asked)  # the outer limit is somebody else's


LIMITED = {
    "design_pid": lambda s: sos.design_pid(CART, search=sos.Search(time_limit=s)),
    "design_lqr": lambda s: sos.design_lqr(
        CART, np.eye(2), [[1]], search=sos.Search(time_limit=s)
    ),
    "observer": lambda s: sos.design_observer(
        CART, [[-1, -1]], np.eye(4), [[1]], B_w=[[0], [1]], time_limit=s
    ),
    "delay": lambda s: sos.design_delay_pid(CART, tau=0.1, time_limit=s),
    "largest": lambda s: sos.delay.largest(
        "tau", sos.Loop(CART, [[-1, -1]]), tau=0.1, digits=1, alpha=0.1, time_limit=s
    ),
    "certify": lambda s: sos.design_pid(CART).certify(time_limit=s),
    "edge": lambda s: maps.edge(
        "rho", CART, region=sos.PoleRegion(rho=9), digits=1, time_limit=s
    ),
    "own": lambda s: LMIProblem({"Q": Q9}, s),
}
ENDLESS = "delay", "largest", "certify", "own"  # None sets no limit
CART = sos.SecondOrderSystem(1, 0, 0, 1)
WRONG = 0, -1, np.nan, np.inf, 10**400, True, "5", 1j, [5], np.ones((1, 1)), object()


@pytest.mark.parametrize("name", LIMITED)
def test_a_wrong_limit_is_named_and_leaves_none_in_force(name):
    for wrong in WRONG:
        with pytest.raises(ValueError, match="time_limit must be positive"):
            LIMITED[name](wrong)
        clock.check_time()
    if name in ENDLESS:
        LIMITED[name](None)
    else:
        with pytest.raises(ValueError, match="time_limit must be positive"):
            LIMITED[name](None)
    clock.check_time()


def test_a_bar_that_cannot_be_shown_leaves_no_limit_in_force(monkeypatch):
    def broken(*asked):
        raise RuntimeError("no bar")

    monkeypatch.setattr("sosbook.runtime.time_limit.bar", broken)
    with (
        pytest.raises(RuntimeError, match="no bar"),
        clock.time_limit(1e-9, progress=True),
    ):
        pass
    clock.check_time()
