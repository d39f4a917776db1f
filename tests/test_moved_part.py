"""Bounds of the input of large plants: the modes that must move decide them."""

import numpy as np
import pytest
from scipy.linalg import expm

import sosbook as sos
from sosbook.synthesis import feasibility, small_input
from sosbook.synthesis.request import Request
from tests.cases import by_hand, campaign
from tests.least_input import least_input
from tests.test_points import rotor, structure

N = 20  # rows: just as many as count for large


def driven(unit=1.0):
    """Springs that a circulating force in two turned rows drives, in any unit."""
    rng = np.random.default_rng(N)
    S = np.diag(np.linspace(1, 9.81, N) ** 2)
    S[0, 1], S[1, 0] = 3.0, -3.0
    turn, _ = np.linalg.qr(np.eye(N) + 0.2 * rng.normal(size=(N, N)))
    parts = np.eye(N), 0.05 * np.eye(N), turn.T @ S @ turn, np.eye(N)[:, :1]
    return sos.SecondOrderSystem(*(unit * x for x in parts))


def on_its_back():
    """A rotor, gyroscopic, on a magnetic bearing that pushes it away."""
    one = rotor(N)
    S = one.S.copy()
    S[0, 0] -= 2.5e4
    return sos.SecondOrderSystem(one.M, one.D, S, one.B)


def grid():
    """Hardly damped modes over more than two decades, of which some must decay."""
    return structure(n=N, damping=0.002)


CASES = {
    "driven, .3": (driven(0.3), sos.PoleRegion(sigma=0.01)),
    "driven, 9.81e3": (driven(9.81e3), sos.PoleRegion(sigma=0.01)),
    "rotor": (on_its_back(), sos.PoleRegion(sigma=0.01)),
    "grid": (grid(), sos.PoleRegion(sigma=0.009)),
}


def start(plant):
    x0 = np.zeros(2 * plant.n)
    x0[: plant.n : 3] = 0.01
    return x0


def least(plant, region, x0):
    """Clarabel's least bound for the modes outside of a half-plane alone."""
    A, B = by_hand(plant)
    poles, W = np.linalg.eig(A.T)
    some = np.flatnonzero((poles.real > -region.sigma) & (poles.imag >= 0))
    rows = np.array([w for k in some for w in (W[:, k].real, W[:, k].imag) if w.any()])
    L, push, x0 = rows @ A @ np.linalg.pinv(rows), rows @ B, rows @ x0
    rate, b, x = np.abs(L).max(), np.linalg.norm(push), np.linalg.norm(x0)
    part = sos.DescriptorSystem(np.eye(len(L)), L / rate, push / b)
    asked = dict(region=sos.PoleRegion(sigma=region.sigma / rate))
    one = least_input(Request(part, saturation=sos.Saturation(1.0, x0 / x), **asked))
    return one * rate * x / b


LEFT = "driven, 9.81e3", "rotor", "grid"


@pytest.mark.parametrize("name", [x for x in CASES if x not in LEFT] + campaign(LEFT))
def test_the_part_decides_on_both_sides_of_its_least_bound(name):
    plant, region = CASES[name]
    x0, (A, B) = start(plant), by_hand(plant)
    u = least(plant, region, x0)
    bound = sos.Saturation(1.02 * u, x0)
    design = sos.design_pid(plant, region=region, saturation=bound)
    assert design.status == "feasible" and not design.central
    assert "looked at alone" in design.reason
    proof = design.certify()
    loop = A + B @ proof.K
    assert proof.proven and np.linalg.eigvals(loop).real.max() < -region.sigma
    step = expm(0.1 * loop / np.abs(np.linalg.eigvals(A)).min())
    x = x0
    for _ in range(300):
        assert np.linalg.norm(proof.K @ x) <= 1.02 * u
        x = step @ x
    low = sos.Saturation(0.98 * u, x0)
    refused = sos.design_pid(plant, region=region, saturation=low)
    assert refused.status == "infeasible" and refused.infeasibility.proven


def pushed_away(n, count, inputs, unit):
    """Turned modes, some of negative stiffness, as magnets make them."""
    rng = np.random.default_rng(n + count)
    squares = np.r_[
        -(np.linspace(0.5, 3, count) ** 2), np.linspace(1, 30, n - count) ** 2
    ]
    turn, _ = np.linalg.qr(rng.normal(size=(n, n)))
    S, D = (turn.T * x @ turn for x in (squares, 0.03 * np.sqrt(abs(squares))))
    parts = np.eye(n), (D + D.T) / 2, (S + S.T) / 2, rng.normal(size=(n, inputs))
    return sos.SecondOrderSystem(*(unit * x for x in parts))


def follower(n, pairs, inputs, unit):
    """Pairs that a force which follows the motion drives: S isn't symmetric."""
    S = np.diag(np.linspace(1, 12, n) ** 2)
    for k in range(0, 2 * pairs, 2):
        S[k, k + 1], S[k + 1, k] = 9.81, -9.81
    B = np.random.default_rng(n).normal(size=(n, inputs))
    return sos.SecondOrderSystem(
        unit * np.eye(n), 0.03 * unit * np.eye(n), unit * S, unit * B
    )


@pytest.mark.parametrize(
    "family, modes, inputs, unit, designed",
    [
        (pushed_away, 2, 1, 0.3, True),
        (pushed_away, 7, 1, 9.81, False),
        (pushed_away, 36, 36, 0.3, True),
        (pushed_away, 36, 3, 9.81, False),
        (follower, 7, 7, 9.81, True),
        (follower, 2, 1, 0.3, True),
    ],
)
def test_many_unstable_modes_are_answered_by_their_part(
    family, modes, inputs, unit, designed, monkeypatch
):
    """No search among all modes: where the part has no gain that floats tell, neither
    does the whole, and nothing is claimed.
    """
    n, search = (60 if modes > 20 else 30), feasibility.search

    def small(request, *given, **more):
        assert request.order < 2 * n
        return search(request, *given, **more)

    monkeypatch.setattr(feasibility, "search", small)
    plant = family(n, modes, inputs, unit)
    design = sos.design_pid(plant)
    if not designed:
        assert design.status == "undecided" and "modes must move" in design.reason
        return
    A, B = by_hand(plant)
    assert np.linalg.eigvals(A).real.max() > 0.1
    assert design.status == "feasible" and design.certify().proven
    assert np.linalg.eigvals(A + B @ design.K).real.max() < 0


def test_the_least_bound_is_that_of_the_part():
    plant, region = CASES["grid"]
    x0 = start(plant)
    bound = sos.Saturation(None, x0)
    design = sos.design_pid(plant, region=region, saturation=bound, minimize="u_max")
    u = design.request.owner("u_max").bound
    assert 1 <= u / least(plant, region, x0) < 1.03 and design.certify().proven


def test_bounds_of_each_input_from_several_states_and_integrators():
    """A pole at zero for each integrator must move, too."""
    plant, (A, B) = grid(), by_hand(grid())
    x0 = np.zeros((2, 2 * N + 1))
    x0[0, :N:3], x0[1, 0] = 0.01, 0.3
    design = sos.design_pid(
        plant, U=np.eye(N)[:1], saturation=sos.Saturation([3.0, 9.81], x0)
    )
    assert "looked at alone" in design.reason
    proof = design.certify()
    assert proof.proven and "9.81" in str(proof)
    loop = np.zeros((2 * N + 1, 2 * N + 1))
    loop[: 2 * N, : 2 * N], loop[2 * N, 0] = A, 1.0
    loop[: 2 * N] += B @ proof.K
    assert np.linalg.eigvals(loop).real.max() < 0
    step = expm(0.5 * loop)
    for x in x0:
        for _ in range(300):
            assert (np.abs(proof.K @ x) <= [3.0, 9.81]).all()
            x = step @ x


def test_a_given_gain_is_bounded_mode_by_mode():
    plant, region = CASES["driven, .3"]
    asked = dict(region=region, saturation=sos.Saturation(0.06, start(plant)))
    design = sos.design_pid(plant, **asked)
    again = sos.analyse_pid(plant, design.K, **asked)
    assert again.status == "feasible" and again.certify().proven
    assert "looked at alone" in design.reason and not again.reason


def test_bases_of_too_few_digits_are_taken_whole(monkeypatch):
    plant, region = CASES["grid"]
    low = sos.Saturation(0.5 * least(plant, region, start(plant)), start(plant))
    sizes = []
    for digits in (1, 10):
        monkeypatch.setattr(small_input, "FEW", digits)
        refused = sos.design_pid(plant, region=region, saturation=low)
        assert refused.infeasibility.proven
        sizes.append(len(str(refused.infeasibility.data)))
    assert sizes[1] < 0.8 * sizes[0]
