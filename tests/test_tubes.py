"""Bounds of what a step asks: own simulations stay below them, and near."""

import functools
from dataclasses import replace

import numpy as np
import pytest
from flint import ctx
from scipy.linalg import expm

import sosbook as sos
from sosbook.controllers import windup
from sosbook.controllers.bounds import rest, root
from sosbook.controllers.cells import BALL_BITS, Joined
from sosbook.controllers.tube import Tube
from sosbook.exact.rational import exact
from sosbook.plants.gain import signals
from sosbook.sampled.balls import middle
from sosbook.sampled.discretize import input_vertices
from sosbook.sampled.loops import SampledFamily
from tests.axis import drive
from tests.cases import later


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
WIDE, LESS = (0.75, 1.5), (1.25, 1.5)  # the mass, which takes more cells if it's light
HARDLY = ("hardly damped", LESS), ("hardly damped", WIDE)
FAMILIES = [("a cart", WIDE), ("two inputs", WIDE), HARDLY[0], *later(HARDLY[1])]


@functools.cache
def controller(name, ranges=None):
    make, region, clock = PLANTS[name]
    plant = make() if ranges is None else sos.Uncertain(make, m=ranges)
    U = [[1, 0]] if name == "hardly damped" else None
    found = sos.design_pid(plant, U, region=sos.PoleRegion(1, **region))
    return found.controller(make().coordinates, **clock)


def steps(c, plant, j, seconds=8.0, row=None):
    """u, (ticks, m), or a coordinate, (ticks,), after a step of set point j, by an own
    loop from tick to tick.
    """
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
        place, y = x[row or 0], c.readings.rows @ x
        u = c.C @ m + c.D @ y + c.D_r @ r
        m = c.A @ m + c.B @ y + c.B_r @ r
        sent.append(u)
        for part, v in zip(parts, (sent.pop(0), sent[0])):
            x = part @ np.concatenate([x, v])
        found.append(u if row is None else place)
    return np.array(found)


@pytest.mark.timeout(900)
# of the hardly damped one the tube of its outputs is in the gate, in the next test
@pytest.mark.parametrize("name, masses", [*FAMILIES[:2], *later(*HARDLY)])
def test_the_bound_of_a_family_is_near_the_worst_plant(name, masses):
    c, make = controller(name, masses), PLANTS[name][0]
    plants = [make(m) for m in np.linspace(*masses, 4)]
    for j in range(len(c.set_points)):
        several = [abs(steps(c, plant, j, 4.0)).max(axis=0) for plant in plants]
        for k, peak in enumerate(np.max(several, axis=0)):
            bound = c.bounds.step(1.0, j, k, time_limit=600)  # a slow computer's, too
            assert peak <= bound.proven <= 1.1 * peak


def outside(c, found, make, masses, j=0, row=0, ticks=2000):
    """How far coordinate ``row`` of some plants is outside what was found, at most."""
    ticks = min(ticks, len(found.curves[0]))
    several = [steps(c, make(m), j, ticks * c.T, row) * found.size for m in masses]
    _, low, high = found.curves[:, :ticks]
    return max(max((low - y).max(), (y - high).max()) for y in several)


@pytest.mark.parametrize("name, masses", FAMILIES)
def test_every_plant_is_between_at_every_tick(name, masses):
    c, make = controller(name, masses), PLANTS[name][0]
    for j, word in enumerate(
        ["load"] if make is light else signals(make())[: make().n]
    ):
        found = c.bounds.step_response(9.81, j, word, cells=16 if make is light else 99)
        row = signals(make()).index(word)
        assert outside(c, found, make, np.linspace(*masses, 4), j, row) < 1e-9
        assert 0 <= found.overshoot.proven - found.overshoot.seen < 0.01


def box(m, d):
    """A cart with two parameters."""
    return sos.SecondOrderSystem([[0.3 * m]], [[d]], [[0]], [[9.81]])


def families():
    """Those whose cells aren't between two corners, or have no inertia."""
    both = two(), two(1.2)
    third = [both[0].M * 1.1, both[0].D * 1.3, both[0].S, both[0].B * 0.9]
    law = sos.PIDLaw(position=[[0, 1]], filter=0.05, limits={"K_P": 9, "K_D": 9})
    lags = [np.diag([x, 1.0]) for x in (0.3, 0.6)]
    motor = sos.DescriptorSystem(lags, [[-1, 0], [9.81, 0]], [[1], [0]])
    yield sos.Uncertain(box, m=(0.7, 1.4), d=(0.02, 0.3)), None, 60
    yield sos.Polytope([*both, sos.SecondOrderSystem(*third)]), None, 60
    yield motor, law, None


@pytest.mark.parametrize("plants, law, rho", list(families()))
def test_plants_inside_any_family_are_between(plants, law, rho):
    region = sos.PoleRegion(0.5, rho=rho)
    c = sos.design_pid(plants, law=law, region=region).controller(T=0.01, delay=0.004)
    found, rng = c.bounds.step_response(0.3, cells=8), np.random.default_rng(1)
    x, row = rest(c, 0).astype(float)[:, 0], int(c.vertices[0].n == 0)
    for weights in rng.dirichlet(np.full(len(c.vertices), 0.7), 5):
        if isinstance(plants, sos.Uncertain):
            d = input_vertices(plants.sample(1, rng.integers(99))[0], None)[0]
        else:
            parts = {
                k: sum(w * getattr(d, k) for w, d in zip(weights, c.vertices))
                for k in ("E", "A", "Bu")
            }
            d = replace(c.vertices[0], **parts)
        F, now, y = c.loop(d).F, -x, []
        for _ in found.curves[0]:
            y.append(0.3 * (now[row] + x[row]))
            now = F @ now
        assert (found.curves[1] <= np.array(y) + 1e-9).all()
        assert (np.array(y) - 1e-9 <= found.curves[2]).all()
    assert "slew" in repr(found) and "polyline" in found._repr_html_()


def test_a_loop_is_its_polynomial_at_every_plant_and_hardly_anything_is_left():
    """A box, a simplex and a line, where balls of second derivatives were off by 2e-5:
    the loops of plants inside, each sampled alone, are as near as is said.
    """
    cases = [(plants, 60, {"T": 0.01, "delay": 0.004}) for plants, *_ in families()][:2]
    line = sos.Uncertain(light, m=(1.3, 1.5))
    for plants, rho, clock in [*cases, (line, 600, PLANTS["hardly damped"][2])]:
        U = [[1, 0]] if plants is line else None
        design = sos.design_pid(plants, U, region=sos.PoleRegion(1, rho=rho))
        c = design.controller(**clock)
        with ctx.workprec(BALL_BITS):
            joined = Joined(c, c.B_r[:, :0], c.D_r[:, :0])
            rho, ((weights, L, P), *_) = c.falling
            tube = Tube(joined, weights, L, P, rho)
            floats, off, _ = tube.pieces
            back, rng = np.linalg.inv(tube.frame), np.random.default_rng(3)
            for share in rng.dirichlet(np.full(len(weights), 0.5), 4):
                parts = share
                if joined.family.shape.axes:
                    a, b = share[:2] / share[:2].sum(), share[2:] / share[2:].sum()
                    parts = np.outer(a, b).ravel()
                q = parts @ tube.points
                mixed = (parts[:, None] * weights.astype(float)).sum(axis=0)
                F = (
                    tube.frame
                    @ middle(joined.family.loop(exact(mixed), c.timing))
                    @ back
                )
                p = sum(M * np.prod(q ** np.array(e)) for e, M in floats.items())
                assert (abs(p - F) <= off + 1e-12).all()
    assert off.max() < 1e-7


MUTANTS = {  # what is changed, and how
    "no bend": (
        SampledFamily,
        "expansion",
        lambda true: lambda *a: {e: (sum(e) < 2) * M for e, M in true(*a).items()},
    ),
    "nothing leaves the polynomials": (
        Tube,
        "recursion",
        lambda true: property(
            lambda tube: [x[: len(tube.exponents)] for x in true.func(tube)]
        ),
    ),
}


def left_and_allowed(c):
    """How far the loops of plants between leave the polynomials of one tube, (ticks,),
    and by how much they may.
    """
    with ctx.workprec(BALL_BITS):
        joined = Joined(c, c.B_r[:, :0], c.D_r[:, :0])
        rho, ((weights, L, P), *_) = c.falling
        tube = Tube(joined, weights, L, P, rho)
        motion = tube.motion(*tube.rest(-rest(c, 0)), ticks=200)
        back, worst = np.linalg.inv(tube.frame), np.zeros(200)
        for share in exact(np.arange(1, 8)) / 8:
            mixed = (1 - share) * weights[0] + share * weights[1]
            F = tube.frame @ middle(joined.family.loop(mixed, c.timing)) @ back
            q = np.array([(2 * float(share) - 1) ** e for (e,) in tube.exponents])
            p = np.tensordot(motion.X, q, (1, 0))
            mean = (1 - float(share)) * tube.matrices[0] + float(share) * tube.matrices[
                1
            ]
            off = (p[1:] - p[:-1] @ F.T) @ np.linalg.cholesky(middle(mean))
            worst = np.maximum(worst, np.linalg.norm(off, axis=1))
    return worst, motion.e[1:] - rho * motion.e[:-1]


def test_a_tube_is_as_wide_as_its_loops_push(monkeypatch):
    """Without a term of delta plants between would leave it."""
    c = controller("hardly damped", LESS)
    for degree, (owner, name, change) in zip((5, 1), MUTANTS.values()):
        monkeypatch.setattr("sosbook.controllers.tube.DEGREES", (0, degree))
        left, allowed = left_and_allowed(c)
        assert (left <= allowed).all()
        with monkeypatch.context() as m:
            m.setattr(owner, name, change(vars(owner)[name]))
            left, allowed = left_and_allowed(c)
            assert (left > 1.1 * allowed).any()


def test_no_bound_where_no_matrix_is_finite(monkeypatch):
    """As where a radius meets the rate to rounding, and floats hold no sum."""
    monkeypatch.setattr(
        "sosbook.controllers.windup.discrete_lyapunov",
        lambda F, W: np.full(W.shape, np.inf),
    )
    assert windup._coordinates(np.eye(2) / 2, np.ones((1, 2))) is None
    assert root(np.diag([1.0, -1e-30])) is None  # floats see no positive P
    c = replace(controller("a cart", WIDE))  # which knows no rate yet
    monkeypatch.setattr("sosbook.controllers.bounds.RATES", ())
    assert c.bounds.step().proven is None and str(c.bounds.step()).startswith(
        "no bound found"
    )
    assert c.bounds.step_response().overshoot.proven is None
    assert c.limit(200.0).bounds.reach().step is None


def test_what_one_plant_forbids_is_looked_for_in_no_cell(monkeypatch):
    """By frequencies; LMIs of one cell after the other come to the same steps."""
    c, tried, answers = controller("a cart", WIDE).limit(0.3), [], []
    monkeypatch.setattr(windup, "MOST_CELLS", 8)
    common = windup._common
    monkeypatch.setattr(windup, "_common", lambda *a: tried.append(1) or common(*a))
    for _ in range(2):
        answers.append((c.bounds.reach(), len(tried)))
        monkeypatch.setattr(windup, "_louder", lambda *a: False)
    (quick, few), (slow, all_of_them) = answers
    assert quick == slow and quick.step > 0 and quick.sector < 0.99
    assert few < (all_of_them - few) / 3


def test_a_loop_is_louder_than_what_its_norm_is_above():
    """By a fine grid of my own, of two inputs, lightly damped and unsymmetric."""
    rng = np.random.default_rng(5)
    for _ in range(6):
        A, B, H = rng.normal(size=(5, 5)), rng.normal(size=(5, 2)), np.eye(2, 5)
        A *= 0.99 / abs(np.linalg.eigvals(A)).max()
        z = np.exp(1j * np.linspace(0, np.pi, 20_001))[:, None, None]
        answers = H @ np.linalg.solve(z * np.eye(5) - A, B + 0j)
        norm, F = np.linalg.norm(answers, 2, (1, 2)).max(), np.hstack([A, B])
        assert windup._louder(F, H, 0.95 * norm)
        assert not windup._louder(F, H, 1.001 * norm)
        assert windup._louder(np.hstack([1.02 * A, B]), H, np.inf)
