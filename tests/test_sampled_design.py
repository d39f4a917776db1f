"""Gains searched on the sampled loop, against scipy, closed forms and recursions."""

import functools
from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import cont2discrete

import sosbook as sos
from sosbook.controllers import CompiledCode, StepLimits, code_fault, sampled_search
from sosbook.controllers.sampled_search import SampledSearch
from sosbook.requirements import LMIRegion
from sosbook.runtime.time_limit import OutOfTime
from tests.cases import campaign

T = 0.4  # s, with modes at 0.57 and 1.6 rad/s; an answer is a tick late
PID = sos.PIDLaw(position=[[0, 1]], filter=T)


def pair(m=1.0):
    """Two lightly damped masses: pushed on the first, measured on the second."""
    return sos.SecondOrderSystem(
        np.diag([1, m]), [[0.02, -0.02], [-0.02, 0.02]], [[1.5, -1], [-1, 1]],
        [[1], [0]], F=[[0], [1]],
    )  # fmt: skip


PAIRS = sos.Polytope([pair(), pair(1.5)])
FEW = sos.Search(starts=2)


@functools.cache
def several():
    law = sos.DynamicLaw(2, position=[[0, 1]])
    return sos.design_sampled(PAIRS, law, T, T, search=FEW)


def held(plant):
    """A, B and B_w of a plant by scipy, its input a tick late."""
    n, back = plant.n, np.linalg.inv(plant.M)
    A = np.block([[np.zeros((n, n)), np.eye(n)], [-back @ plant.S, -back @ plant.D]])
    B = np.vstack([np.zeros((n, 2)), back @ np.hstack([plant.B, plant.F])])
    A, B, *_ = cont2discrete((A, B, np.eye(2 * n), np.zeros((2 * n, 2))), T)
    A = np.block([[A, B[:, :1]], [np.zeros((1, 2 * n + 1))]])
    return A, np.eye(2 * n + 1)[:, -1:], np.vstack([B[:, 1:], [[0]]])


def held_loop(design, plant):
    """F, C_c and B_w of x_c(k + 1) = A_c x_c + B_c y, u = C_c x_c."""
    A, B, W = held(plant)
    A_c, B_c, C_c = (design.gains[x] for x in ("A_c", "B_c", "C_c"))
    F = np.block([[A, B @ C_c], [B_c @ np.eye(len(A))[[1]], A_c]])
    return F, C_c, np.vstack([W, np.zeros((len(A_c), 1))])


def filtered_loop(plant, K_P, K_D):
    """u = K_P y + K_D (y - lag) (1 - e) / T, lag(k+1) = e lag + (1 - e) y."""
    (A, B, _), keep = held(plant), np.exp(-1)
    y = np.eye(len(A))[[1]]
    K_D = K_D * (1 - keep) / T
    own = (1 - keep) * y
    return np.block([[A + B @ ((K_P + K_D) * y), -K_D * B], [own, np.array([[keep]])]])


def radius(F):
    return abs(np.linalg.eigvals(F)).max()


def test_a_slow_clock_needs_a_gain_of_its_own_and_it_is_proven():
    slow = sos.design_sampled(pair(), PID, T, T, search=FEW)
    assert slow.status == "feasible" and slow.certify().verify()
    continuous = sos.design_pid(pair(), law=PID, maximize="sigma", search=FEW)
    assert continuous.status == "feasible"
    assert continuous.controller(T=T, delay=T).radius > 1
    true = radius(filtered_loop(pair(), *(slow.gains[x].item() for x in slow.gains)))
    assert abs(slow.poles()).max() == pytest.approx(true, abs=1e-9)
    rate = slow.certify().rate
    assert true < rate < true**0.985 and rate <= np.exp(-slow.sigma * T)
    again = sos.design_sampled(pair(), PID, T, T, search=FEW)
    assert (again.K == slow.K).all() and again.sigma == slow.sigma
    asked = sos.design_sampled(pair(), PID, T, T, sigma=0.95 * slow.sigma, search=FEW)
    assert asked.status == "feasible" and "e^(-0.07" in asked.words


def test_every_plant_between_keeps_the_decay_of_a_controller_of_order_two():
    design = several()
    assert design.sigma > 0.15 and "every constant plant of" in str(design.proof)
    for m in np.linspace(1, 1.5, 11):
        assert radius(held_loop(design, pair(m))[0]) < design.proof.rate
    assert (
        "decays at least as e^(-" in design.words and "region" in design._repr_html_()
    )


def test_the_fastest_loops_are_those_of_closed_forms():
    lag, a = sos.DescriptorSystem([[1]], [[-1]], [[1]]), np.exp(-0.3)
    P = sos.PIDLaw(position=[[1]])
    late = sos.design_sampled(
        lag, P, 0.3, 0.3, search=sos.Search(backoff=1e-3)
    )  # z z - a z = (1 - a) K
    assert late.K.item() == pytest.approx(-(a**2) / 4 / (1 - a), rel=1e-2)
    assert np.exp(-late.sigma * 0.3) == pytest.approx(a / 2, rel=1e-2)
    for sigma in (3.0, 3.01, 3.02, 3.03):  # what is proven is no less than asked
        asked = sos.design_sampled(lag, P, 0.3, 0.3, sigma=sigma, search=FEW)
        assert asked.certify().rate <= np.exp(-sigma * 0.3)
    cart = sos.SecondOrderSystem(1, 0, 0, 1)
    full = sos.PIDLaw(position=[[1]], velocity=[[1]])
    beat = sos.design_sampled(cart, full, 0.5)  # dead beat: -1 / T^2, -1.5 / T
    assert beat.status == "feasible" and beat.certify().rate < 0.06
    assert np.allclose(beat.K, [[-4, -3]], rtol=0.03)


def test_an_integral_and_two_inputs_are_joined_as_they_run():
    plant = sos.SecondOrderSystem(
        np.diag([1, 2]), 0.1 * np.eye(2), [[2, -1], [-1, 1]], np.eye(2)
    )
    law = sos.PIDLaw(position=np.eye(2), integrate=True, filter=0.3)
    design = sos.design_sampled(plant, law, 0.2, 0.13, sigma=0.05)
    c = design.controller(units={"z1": "m"})
    assert design.status == "feasible" and c.radius < design.proof.rate
    run = c.simulate(200, r=[1, 0.5])
    assert np.allclose(run.x[0, -1, :2], [1, 0.5], atol=1e-3)


def test_what_runs_and_what_is_reported_come_from_it(tmp_path):
    c = several().controller(units={"z2": "m", "u": "N"})
    assert str(c.readings.signals[0]) == "z2 (m)" and c.radius < several().proof.rate
    runs = [
        c.simulate(20, x0=[0.1, 0, 0, 0], program=p) for p in (None, CompiledCode(c, 2))
    ]
    assert (runs[0].u == runs[1].u).all() and abs(runs[0].u).max() > 0.01
    code = c.to_c("axis")
    assert code_fault(c.certify().data, code.texts["axis_gains.h"]) == ""
    page = several().report(tmp_path, controller=c).read_text("utf-8")
    assert "every motion decays at least as" in page and "continuous" not in page


def test_what_isnt_found_is_undecided_with_what_was_reached():
    much = sos.design_sampled(pair(), PID, T, T, sigma=0.5)
    assert much.status == "undecided" and much.K is None and not much.certify().proven
    assert "nearest gain reaches a decay of 0.08" in much.reason
    assert repr(much).startswith("<SampledDesign: undecided")
    with pytest.raises(ValueError, match="the design is undecided"):
        much.controller()
    assert (
        "(asked: 0.5), found by 8 starts" in much.reason
        and "Sample faster" in much.reason
    )
    blind = sos.SecondOrderSystem(np.eye(2), np.zeros((2, 2)), np.eye(2), [[1], [0]])
    none = sos.design_sampled(
        blind, sos.PIDLaw([[1, 0]], filter=T), T, search=sos.Search(starts=2)
    )
    assert none.status == "undecided" and "No stable loop was found" in none.reason
    short = sos.design_sampled(PAIRS, PID, T, T, search=sos.Search(time_limit=1e-3))
    assert short.status == "undecided" and "The time was over" in short.reason
    for words in (much.reason, none.reason, short.reason):
        assert not any(
            x in words for x in ("infeasible", "impossible", "no controller")
        )


def test_a_rounding_that_is_too_coarse_leaves_the_next_one_its_digits(monkeypatch):
    """The numbers of the second trial were those of the first."""
    fast = sos.design_sampled(pair(), PID, T, T, search=FEW).sigma
    monkeypatch.setattr(sampled_search, "DIGITS", (1,))
    coarse = sos.design_sampled(pair(), PID, T, T, sigma=0.99 * fast, search=FEW)
    assert coarse.status == "undecided" and "It isn't proven" in coarse.reason
    monkeypatch.setattr(sampled_search, "DIGITS", (1, 10))
    asked = sos.design_sampled(pair(), PID, T, T, sigma=0.99 * fast, search=FEW)
    assert asked.status == "feasible" and asked.proof.verify()
    monkeypatch.setattr(sampled_search, "round_digits", lambda x, digits: 9.81 * x)
    unstable = sos.design_sampled(pair(), PID, T, T, search=FEW)
    assert unstable.status == "undecided" and "fastest decay" in unstable.words


def test_limits_are_those_of_the_numbers_at_the_ticks():
    law = sos.DynamicLaw(
        1, [[0, 1]], structure={"A_c": "diagonal"}, limits={"A_c": 0.3}
    )
    design = sos.design_sampled(pair(), law, T, T, search=sos.Search(starts=3))
    assert design.searched.limits["A_c"] == 0.3 and design.K is not None
    assert abs(design.gains["A_c"]).max() <= 0.3


def test_bad_input_is_named():
    unstable = sos.SecondOrderSystem(1, 0, -4, 1)
    P = sos.PIDLaw(position=[[1]])
    with pytest.raises(ValueError, match="no controller can do it at T = 2 s"):
        sos.design_sampled(unstable, P, 2.0)
    with pytest.raises(ValueError, match="longer than the law's filter of 0.1 s"):
        sos.design_sampled(pair(), sos.PIDLaw([[0, 1]], filter=0.1), T)
    with pytest.raises(ValueError, match="law must be a PIDLaw or DynamicLaw"):
        sos.design_sampled(pair(), sos.FullState(), T)
    with pytest.raises(ValueError, match="sigma must be positive"):
        sos.design_sampled(pair(), PID, T, sigma=0)
    for wrong in (sos.PoleRegion(0.1), sos.H2(3.0)):
        with pytest.raises(ValueError, match="at the ticks an HInfinity"):
            sos.design_sampled(pair(), PID, T, requirements=[wrong])
    with pytest.raises(ValueError, match="leaves the unit disk"):
        sos.design_sampled(pair(), PID, T, requirements=[LMIRegion.disk(0.9, 0.2)])
    both, asked = sos.PIDLaw(np.eye(2), np.eye(2)), [StepLimits(overshoot=0.3)]
    spring = [[9.81, -9.81], [-9.81, 9.81]]
    free = sos.SecondOrderSystem(np.eye(2), np.zeros((2, 2)), spring, [[1], [0]])
    with pytest.raises(ValueError, match="ends where gains say"):  # K_P of both
        sos.design_sampled(free, both, T, requirements=asked)
    with pytest.raises(ValueError, match="give one of overshoot"):
        StepLimits(size=0.3)


def fastest(matrix, box, T):
    """The fastest decay of matrix(k) for k in a box, by a search of all of it."""
    from scipy.optimize import differential_evolution

    def radii(several):  # (len(box), count) gains, or one
        loops = np.array([matrix(k) for k in np.atleast_2d(several.T)])
        return abs(np.linalg.eigvals(loops)).max(axis=1)

    found = differential_evolution(
        radii, [(-x, x) for x in box], seed=1, tol=1e-6, maxiter=600,
        vectorized=True, updating="deferred",
    )  # fmt: skip
    return -np.log(found.fun) / T


def lag_loop(gain, lag, T, late):
    """x' = -x / lag + gain u, s(k + 1) = s + T y, u = K_P y + K_I s, a tick late."""
    a = np.exp(-T / lag)
    b = gain * lag * (1 - a)
    if not late:
        return lambda k: np.array([[a + b * k[0], b * k[1]], [T, 1]])
    return lambda k: np.array([[a, b, 0], [k[0], 0, k[1]], [T, 0, 1]])


def cart_loop(m, T):
    """A mass, a tick late: u = K_P z + K_D z'."""
    return lambda k: np.array([[1, T, T * T / 2 / m], [0, 1, T / m], [k[0], k[1], 0]])


PI = sos.PIDLaw(position=[[1]], integrate=True)
FASTEST = {  # plant, law, T, delay, loop, box
    "a drive, a tick late": (1e-3, 1e-3, 500.0, 1.0, PI, (2, 400)),
    "another unit of time and of force": (0.3, 0.3, 9.81, 40.0, PI, (1, 1)),
    "limits": (
        1e-3, 1e-3, 500.0, 1.0,
        sos.PIDLaw([[1]], integrate=True, limits={"K_P": 2, "K_I": 20}), (2, 20),
    ),
    "no delay": (1e-3, 0.0, 500.0, 1.0,
        sos.PIDLaw([[1]], integrate=True, limits={"K_P": 1, "K_I": 300}), (1, 300)),
}  # fmt: skip


# the first is the second in other units, and the last has limits, too
@pytest.mark.parametrize("name", [*[*FASTEST][1::2], *campaign([*FASTEST][::2])])
def test_the_fastest_decay_is_that_of_all_gains(name):
    T, delay, gain, lag, law, box = FASTEST[name]
    plant = sos.DescriptorSystem([[1.0]], [[-1 / lag]], [[gain]])
    design = sos.design_sampled(plant, law, T, delay, search=FEW)
    true = fastest(lag_loop(gain, lag, T, delay > 0), box, T)
    assert design.status == "feasible" and 0.96 * true < design.sigma < true
    known = (
        ("limit: an entry of K_I", "an entry of K_P is") if law.limits else ("asked",)
    )
    assert any(x in design.reason for x in known), design.reason
    less = 0.9 * design.sigma
    asked = sos.design_sampled(plant, law, T, delay, sigma=less, search=FEW)
    assert asked.status == "feasible"


@pytest.mark.campaign  # in the gate two masses in odd units are as fast as can be
@pytest.mark.parametrize("m", [9.81, 0.3])
def test_the_fastest_mass_a_tick_late_has_three_equal_poles(m):
    T, law = 0.01, sos.PIDLaw(position=[[1]], velocity=[[1]])
    cart = sos.SecondOrderSystem(m, 0, 0, 1)
    design = sos.design_sampled(cart, law, T, T, search=FEW)
    true = np.log(1.5) / T
    assert 0.95 * true < design.sigma < true
    assert radius(cart_loop(m, T)(design.K[0])) < np.exp(-design.sigma * T)


def test_two_masses_in_odd_units_are_as_fast_as_any_gain_of_the_state_makes_them():
    T, M = 0.1, np.diag([0.3, 9.81])
    plant = sos.SecondOrderSystem(
        M, [[0.01, -0.01], [-0.01, 0.01]], [[20, -20], [-20, 20]], [[1], [0]]
    )
    law = sos.PIDLaw(position=np.eye(2), velocity=np.eye(2))
    design = sos.design_sampled(plant, law, T, T, search=FEW)
    back = np.linalg.inv(M)
    A = np.block([[np.zeros((2, 2)), np.eye(2)], [-back @ plant.S, -back @ plant.D]])
    B = np.vstack([np.zeros((2, 1)), back @ plant.B])
    A, B, *_ = cont2discrete((A, B, np.eye(4), np.zeros((4, 1))), T)

    def loop(k):
        return np.block([[A, B], [k[None], np.zeros((1, 1))]])

    true = fastest(loop, (200,) * 4, T)
    assert 0.9 * true < design.sigma < true * 1.001
    assert radius(loop(design.K[0])) < np.exp(-design.sigma * T)


def test_time_that_is_over_says_what_to_turn(monkeypatch):
    monkeypatch.setattr(sampled_search, "SEARCH", 1e-9)
    some = sos.design_sampled(PAIRS, PID, T, T, search=sos.Search(time_limit=30))
    assert "a longer time_limit goes further" in some.reason


def test_a_gain_whose_proof_has_no_time_left_is_not_called_too_slow(monkeypatch):
    """A satellite's reached what was asked, and its owner was told to ask for less."""

    def late(*_):
        raise OutOfTime

    monkeypatch.setattr(SampledSearch, "_best", late)
    cart = sos.SecondOrderSystem(9.81, 0, 0, 3)
    law = sos.PIDLaw(position=[[1]], filter=0.5)
    limits = StepLimits(effort=100)
    for more in ({"sigma": 0.2}, {}, {"sigma": 0.2, "requirements": [limits]}):
        more["search"] = FEW
        design = sos.design_sampled(cart, law, T=0.5, delay=0.5, **more)
        assert design.status == "undecided"
        assert "before it was proven" in design.reason
        assert "ask for less" not in design.reason and "starts had" not in design.reason
    design = sos.design_sampled(cart, law, T=0.5, delay=0.5, sigma=40)
    assert "ask for less" in design.reason


@pytest.mark.parametrize("effort", [None, 0.2])
def test_the_fastest_drive_that_hardly_overshoots_is_that_of_all_gains(effort):
    """By a grid of all gains; my own loop keeps to what is asked."""
    plant, clock = sos.DescriptorSystem([[1.0]], [[-1.0]], [[500.0]]), 1e-3
    asked = StepLimits(overshoot=0.05, effort=effort)
    more = dict(requirements=[asked], search=FEW)
    design = sos.design_sampled(plant, PI, clock, clock, **more)
    assert design.status == "feasible" and "At its bound: overshoot" in design.reason
    assert ("fastest pole" in design.reason) == (effort is None)
    (step,) = design.kept
    P, I = (design.gains[x].item() for x in ("K_P", "K_I"))
    rows, integrals = np.meshgrid(
        np.linspace(-0.7, -0.02, 60), -np.geomspace(1, 20, 60)
    )
    P, I = np.append(rows.ravel(), P), np.append(integrals.ravel(), I)
    F = np.zeros((len(P), 3, 3))
    F[:, 0, 0], F[:, 0, 1] = np.exp(-clock), 500 * (1 - np.exp(-clock))
    F[:, 1, 0], F[:, 1, 2], F[:, 2, 0], F[:, 2, 2] = P, I, clock, 1
    x, most, force = np.zeros((3, len(P))), np.zeros(len(P)), np.zeros(len(P))
    for _ in range(600):
        u = P * (x[0] - 1) + I * x[2]
        most, force = np.maximum(most, x[0]), np.maximum(force, abs(u))
        x = np.array(
            [F[0, 0, 0] * x[0] + F[0, 0, 1] * x[1], u, x[2] + clock * (x[0] - 1)]
        )
    decay = -np.log(abs(np.linalg.eigvals(F)).max(axis=1)) / clock
    good = (most <= 1.05) & (force <= (effort or np.inf))
    assert good[-1] and step.overshoot.proven >= most[-1] - 1
    assert decay[-1] >= 0.97 * decay[good].max() and decay[-1] >= design.sigma


def test_masses_between_keep_a_norm_a_disk_and_a_step_in_odd_units():
    masses = sos.Uncertain(
        lambda m: sos.SecondOrderSystem(m, 0, 0, 9.81, F=[[1]]), m=(0.3, 0.5)
    )
    law = sos.PIDLaw(position=[[1]], velocity=[[1]])
    asked = [
        sos.HInfinity(0.3, outputs=sos.Output(position=[[1]])),
        LMIRegion.disk(0.45, 0.52),
        StepLimits(settling_time=1.5, effort=4.0, size=0.3),
    ]
    more = dict(requirements=asked, search=FEW)
    design = sos.design_sampled(masses, law, 0.05, 0.05, **more)
    assert design.status == "feasible" and len(design.kept) == 3
    assert all(proof.verify() for proof in design.kept[:2])
    assert "norm" in design.words and "after a step of 0.3" in design.words
    K = np.hstack([design.gains["K_P"], design.gains["K_D"]])
    for m in np.linspace(0.3, 0.5, 5):
        A, B = np.array([[1, 0.05], [0, 1]]), np.array([[0.05**2 / 2], [0.05]]) / m
        F = np.block([[A, 9.81 * B], [K, np.zeros((1, 1))]])
        w, y = np.vstack([B, [[0]]]), np.eye(3)[:1]
        z = np.exp(1j * np.linspace(0, np.pi, 400))[:, None, None]
        assert abs(y @ np.linalg.solve(z * np.eye(3) - F, w + 0j)).max() < 0.3
        assert abs(np.linalg.eigvals(F) - 0.52).max() < 0.45
        x = np.array([-0.3, 0, 0])
        for k in range(100):
            assert abs(K @ x[:2]).max() <= 4.0
            assert k < 30 or abs(x[0]) <= 0.02 * 0.3
            x = F @ x


@pytest.mark.parametrize("law", [PI, sos.DynamicLaw(1, position=[[1]])])
def test_what_is_asked_falls_as_its_slopes_say(law):
    plant = sos.DescriptorSystem([[0.3]], [[-1.0]], [[9.81]], [[1.0]])
    asked = [
        sos.HInfinity(1, outputs=sos.Output(state=[[1]])),
        LMIRegion.disk(0.3, 0.5),
    ]
    if law is PI:
        asked.append(StepLimits(overshoot=0.05, settling_time=0.3, effort=2.0))
    design = sos.design_sampled(plant, law, 0.02, 0.02, sigma=0.1)
    some = replace(design, requirements=tuple(asked), K=None)
    work = SampledSearch(some, 0.1, 0.01, 64)
    demands, count = work.demands, len(work.loops.steps)
    kappa = np.random.default_rng(2).uniform(-0.03, 0.03, count)
    for k, step in enumerate(1e-7 * np.eye(count)):
        ends = [demands.levels(kappa + s * step) for s in (1, -1)]
        for (*_, slope), one, two in zip(demands.levels(kappa), *ends):
            found = (one[3] - two[3]) / 2e-7
            assert found == pytest.approx(slope[k], rel=1e-4, abs=1e-5)


def test_what_no_gain_keeps_is_named():
    drive = sos.DescriptorSystem([[1.0]], [[-1.0]], [[500.0]])
    little = [StepLimits(effort=0.001)]  # at rest u is 1 / 500
    design = sos.design_sampled(drive, PI, 1e-3, 1e-3, sigma=10, requirements=little)
    assert design.status == "undecided" and design.K is None and not design.kept
    assert "No gain was found that keeps all" in design.reason
    assert "effort" in design.reason and "(asked: at most 0.001)" in design.reason


def test_the_decay_that_is_true_stands_beside_the_one_that_was_asked():
    cart = sos.SecondOrderSystem(0.3, 0.02, 9.81, 2)
    law = sos.PIDLaw(position=[[1]], filter=0.1)
    d = sos.design_sampled(cart, law, T=0.05, sigma=0.5)
    true = -np.log(abs(d.poles()).max()) / 0.05
    assert d.decay == pytest.approx(true) and true > d.sigma == 0.5
    assert f"in floats {true:.4g} 1/s" in repr(d)


def test_a_loop_with_a_clock_is_simulated_for_some_seconds():
    cart = sos.SecondOrderSystem(0.3, 0.02, 9.81, 2)
    law = sos.PIDLaw(position=[[1]], filter=0.1)
    loop = sos.Loop(cart, law, {"K_P": [[-1]], "K_D": [[-1]]}).at(0.05)
    with pytest.raises(ValueError, match="^t must be a finite number"):
        loop.simulate([0, 1, 2])
    with pytest.raises(ValueError, match="^t must be positive"):
        loop.simulate(-1)
    assert loop.simulate(2).t[-1] >= 2 - 0.05
