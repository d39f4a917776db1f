"""Bounds of what a step asks: own simulations stay below them, and near."""

import itertools

import numpy as np
import pytest
from flint import ctx
from scipy.linalg import expm

import sosbook as sos
from sosbook.controllers import windup
from sosbook.controllers.bounds import _best, root
from sosbook.controllers.cells import BALL_BITS, Joined
from sosbook.controllers.tube import Sizes, _norms, motions_of
from sosbook.exact.rational import exact
from sosbook.sampled.balls import middle
from tests.axis import drive


def cart(m=1.0):
    return sos.SecondOrderSystem([[0.3 * m]], [[0.02]], [[0]], [[9.81]])


def two(m=1.0):
    """Two carts, two motors, unsymmetric dampers, and nothing that holds them."""
    mass, damper = [[0.3 * m, 0.02], [0, 1.7]], [[1, -0.3], [0.1, 0.5]]
    return sos.SecondOrderSystem(mass, damper, np.zeros((2, 2)), [[1, 0.2], [0, 9.81]])


def light(m=1.0):
    return drive(0.004 * m, k=20, d=1e-4)


PLANTS = {
    "a cart": (cart, {"rho": 60}, {"T": 0.01, "delay": 0.004}),
    "two inputs": (two, {"rho": 60}, {"T": 0.01, "delay": 0.013}),
    "hardly damped": (light, {"rho": 600}, {"T": 0.001, "delay": 0.001}),
}


def controller(name, ranges=None):
    make, region, clock = PLANTS[name]
    plant = make() if ranges is None else sos.Uncertain(make, m=ranges)
    U = [[1, 0]] if name == "hardly damped" else None
    found = sos.design_pid(plant, U, region=sos.PoleRegion(1, **region))
    return found.controller(make().coordinates, **clock)


def steps(c, plant, j, seconds=8.0):
    """u, (ticks, m), after a step of set point j, by an own loop from tick to tick."""
    n, (whole, late) = plant.n, divmod(c.delay + 1e-12, c.T)
    back = np.linalg.inv(plant.M)
    A = np.block([[np.zeros((n, n)), np.eye(n)], [-back @ plant.S, -back @ plant.D]])
    B = np.vstack([np.zeros_like(plant.B), back @ plant.B])
    wide = np.zeros((2 * n + B.shape[1],) * 2)
    wide[: 2 * n] = np.hstack([A, B])
    parts = [expm(wide * t)[: 2 * n] for t in (late, c.T - late)]
    x, m, r = np.zeros(2 * n), np.zeros(c.order), np.eye(len(c.set_points))[j]
    sent, found = [np.zeros(B.shape[1])] * (int(whole) + 1), []
    for _ in range(round(seconds / c.T)):
        y = c.readings.rows @ x
        u = c.C @ m + c.D @ y + c.D_r @ r
        m = c.A @ m + c.B @ y + c.B_r @ r
        sent.append(u)
        for part, v in zip(parts, (sent.pop(0), sent[0])):
            x = part @ np.concatenate([x, v])
        found.append(u)
    return np.array(found)


@pytest.mark.parametrize("name", PLANTS)
def test_the_bound_of_one_plant_is_its_peak(name):
    c, plant = controller(name), PLANTS[name][0]()
    for j, k in itertools.product(range(len(c.set_points)), range(len(c.outputs))):
        peak = abs(steps(c, plant, j)[:, k]).max()
        assert peak <= c.bounds.step(1.0, j, k).proven <= 1.005 * peak
    assert c.bounds.largest_step(2.0) == pytest.approx(2 / c.bounds.step().proven)


@pytest.mark.parametrize("name", PLANTS)
def test_the_bound_of_a_family_is_near_the_worst_plant(name):
    c, make = controller(name, (0.75, 1.5)), PLANTS[name][0]
    plants = [make(m) for m in np.linspace(0.75, 1.5, 7)]
    for j, k in itertools.product(range(len(c.set_points)), range(len(c.outputs))):
        peak = max(abs(steps(c, plant, j)[:, k]).max() for plant in plants)
        assert peak <= c.bounds.step(1.0, j, k).proven <= 1.1 * peak


def test_what_the_corners_motions_leave_is_bounded_and_each_term_needed():
    """Loops between two corners push by no more than delta; without a term, by more."""
    c = controller("hardly damped", (0.75, 1.5))
    with ctx.workprec(BALL_BITS):
        joined = Joined(c, c.B_r, c.D_r)
        whole = joined.family.shape.whole()
        N = len(joined.family.loop(whole[0], c.timing))
        L, loops, bent = joined.cell(whole, np.eye(N)).parts
        L, F, W = middle(L), [middle(x) for x in loops], middle(bent)
        corners = [middle(joined.family.loop(w, c.timing)) for w in whole]
        shares = exact(np.arange(1, 8)) / 8
        between = [(1 - s) * whole[0] + s * whole[1] for s in shares]
        inside = [middle(joined.family.loop(w, c.timing)) for w in between]
    x = np.eye(N)[:, -1:]
    motions = motions_of(corners, x, 300)
    row, known = np.eye(N)[:1], (_norms, np.matmul)
    left = Sizes.of(motions, L, F, W, row, *known).left
    pushed = np.zeros(len(left))
    for share, loop in zip(shares.astype(float), inside):
        p = (1 - share) * motions[0] + share * motions[1]
        off = L @ (p[1:] - loop @ p[:-1])
        pushed = np.maximum(pushed, np.linalg.norm(off, axis=1)[:, 0])
    assert (pushed <= left * (1 + 1e-9) + 1e-12).all() and pushed.max() > left.max() / 9
    straight = Sizes.of(motions, L, F, None, row, *known).left
    alone = [Sizes.of(motions[[k]], L, [F[k]], W, row, *known).left for k in (0, 1)]
    assert (pushed > straight + 1e-9).any() and (pushed > np.max(alone, 0) + 1e-9).any()


def test_no_bound_where_no_matrix_is_finite(monkeypatch):
    """As where a radius meets the rate to rounding, and floats hold no sum."""
    for module in ("bounds", "windup"):
        monkeypatch.setattr(
            f"sosbook.controllers.{module}.discrete_lyapunov",
            lambda F, W: np.full(W.shape, np.inf),
        )
    assert _best(np.eye(2) / 2, np.ones((2, 1)), np.ones(2), 0.0) == (None,) * 3
    assert windup._coordinates(np.eye(2) / 2, np.ones((1, 2))) is None
    assert root(np.diag([1.0, -1e-30])) is None  # floats see no positive P
    c = controller("a cart", (0.75, 1.5))
    assert c.bounds.step().proven is None and str(c.bounds.step()).startswith(
        "no bound found"
    )
    assert c.limit(200.0).bounds.reach().step is None
