"""Simulated loops against an ODE solver and python-control."""

import control
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import sosbook as sos
from sosbook.analysis.precise import sensitive
from sosbook.book import thesis

SINE = sos.Sine(5, 10, offset=5, start=1, stop=2.05)
R, X0 = np.array([1.0, -0.5]), np.array([0.2, 0.2, 0.8, 0.8, 0.1, 0.1])


@pytest.fixture(scope="module")
def design():
    ex = thesis.example_1()
    return sos.analyse_pid(ex.plant, ex.K, **ex.requirements)


def second_order(d, r, w, K_A=None):
    """M z'' = B u + F w - D z' - S z and x3' = U e, written out."""
    v, U = d.request.plant, d.request.U
    M = v.M if K_A is None else v.M - v.B @ K_A

    def rate(t, x):
        z, dz, x3 = x[:2], x[2:4], x[4:]
        u = d.K_P @ (z - r) + d.K_D @ dz + d.K_I @ x3
        force = v.B @ u + v.F @ w([t])[:, 0] - v.D @ dz - v.S @ z
        return np.concatenate([dz, np.linalg.solve(M, force), U @ (z - r)])

    return rate


def integrate(rate, pieces, x0, t):
    """Piece by piece, so that no jump lies within one."""
    found = np.empty((len(x0), len(t)))
    for now, then in zip(pieces, pieces[1:]):
        inside = (t >= now) & (t <= then)
        done = solve_ivp(
            rate,
            (now, then),
            x0,
            rtol=1e-11,
            atol=1e-12,
            method="DOP853",
            t_eval=np.union1d(t[inside], [then]),
        )
        found[:, inside] = done.y[:, np.isin(done.t, t[inside])]
        x0 = done.y[:, -1]
    return found


def test_against_an_ode_solver(design):
    t = np.linspace(0, 4, 401)
    answer = design.simulate(t, r=R, w=SINE, x0=X0)

    def w(t):  # on through the closed interval, unlike Sine
        t = np.asarray(t)
        on = (t >= 1 - 1e-9) & (t <= 2.05 + 1e-9)
        return np.tile(on * (5 * np.sin(10 * t) + 5), (2, 1))

    rate = second_order(design, R, w)
    off = second_order(design, R, lambda t: np.zeros((2, 1)))
    x = integrate(off, [0, 1], X0, t)
    first, second, third = t <= 1, (t > 1) & (t <= 2.05), t > 2.05
    now = x[:, first][:, -1]
    middle = integrate(rate, [1, 2.05], now, t[second])
    x[:, second] = middle
    x[:, third] = integrate(off, [2.05, 4], middle[:, -1], t[third])
    assert np.abs(answer.x - x).max() < 1e-8
    assert np.array_equal(answer.e, answer.z - R[:, None])
    assert np.allclose(answer.w[:, second][:, :-1], w(t[second])[:, :-1])


def test_constant_set_points_are_reached(design):
    answer = design.simulate(np.linspace(0, 40, 11), r=R)
    assert np.abs(answer.e[:, -1]).max() < 1e-10


def test_steps_of_any_length_give_the_same_points(design):
    t = np.linspace(0, 4, 9)
    fine = np.union1d(t, np.random.default_rng(1).uniform(0, 4, 100))
    coarse = design.simulate(t, r=R, w=SINE, x0=X0)
    dense = design.simulate(fine, r=R, w=SINE, x0=X0)
    assert np.allclose(dense.x[:, np.isin(fine, t)], coarse.x, atol=1e-10)


def test_a_time_scale_of_picoseconds():
    """Steps far below 1e-12 s aren't mistaken for each other."""
    one, c = [[1.0]], 1e-13
    fast = sos.SecondOrderSystem([[c * c]], [[3 * c]], [[2.0]], one, one)
    slow = sos.SecondOrderSystem(one, [[3.0]], [[2.0]], one, one)
    t = np.array([0, 0.1, 0.5, 0.7, 2.0, 3.0])
    K, w = np.zeros((1, 2)), sos.Sine(1.0, 2.0)
    here = sos.analyse_pid(slow, K).simulate(t, w=w)
    there = sos.analyse_pid(fast, K).simulate(t * c, w=sos.Sine(1.0, 2 / c))
    assert np.allclose(here.z, there.z, rtol=1e-9)


@pytest.mark.slow
def test_acceleration_feedback_is_counted_in_u():
    """M z'' + D z' + S z = B u + F w, u with its K_A z''."""
    ex = thesis.example_1()
    K_A = np.array([[-1.0, 0.5], [0, -2]])
    d = sos.analyse_pid(ex.plant, ex.K, ex.U, K_A=K_A)
    t = np.linspace(0, 1, 100001)
    answer = d.simulate(t, r=R, w=sos.Sine(3, 4), x0=X0)
    v = ex.plant
    ddz = np.gradient(answer.dz, t, axis=1)
    left = v.M @ ddz + v.D @ answer.dz + v.S @ answer.z
    right = v.B @ answer.u + v.F @ answer.w
    assert np.abs(left - right)[:, 5:-5].max() < 1e-5


def test_channels_of_the_disturbance(design):
    t = np.linspace(0, 1, 11)
    both = design.simulate(t, w=sos.Sine([1, 0], 2, offset=[0, 3]))
    assert np.allclose(both.w[0], np.sin(2 * t))
    assert np.allclose(both.w[1], 3)


def test_one_response_for_each_vertex():
    seat = thesis.example_2()
    plants, asked = seat.plant, seat.requirements
    d = sos.design_pid(plants, **asked)
    answers = d.simulate([0, 1, 2], r=[1, 0])
    assert len(answers) == 2
    assert not np.allclose(answers[0].z, answers[1].z)


@pytest.mark.parametrize(
    "t",
    [
        [0.0],
        [1.0, 2.0],
        [0, 1, 1],
        [0, 2, 1],
        [0, np.nan, 1],
        [0, np.inf],
        [[0, 1]],
        [],
    ],
)
def test_times_are_checked(design, t):
    with pytest.raises(ValueError, match="t must increase from 0"):
        design.simulate(t)


@pytest.mark.parametrize(
    "bad, words",
    [
        (dict(r=[1.0]), "r must hold 2"),
        (dict(r=[1.0, np.nan]), "r must hold 2"),
        (dict(x0=np.zeros(4)), "x0 must hold 6"),
        (dict(w=np.sin), "w must be a Sine"),
        (dict(w=sos.Sine([1, 2, 3], 1)), "w: amplitude"),
        (dict(w=sos.Sine(1, 1, offset=[1, 2, 3])), "w: offset"),
    ],
)
def test_signals_are_checked(design, bad, words):
    with pytest.raises(ValueError, match=words):
        design.simulate([0, 1], **bad)


def test_a_function_is_refused_and_the_advice_is_its_cure(design):
    """Its values as `Ramps` are a function that is linear between its times."""
    t = np.linspace(0, 2, 401)

    def ramp(time):
        return np.array([0.3 * time, -9.81 * time])

    with pytest.raises(ValueError, match=r"as Ramps\(times, levels\)"):
        design.simulate(t, r=ramp)
    found = design.simulate(t, r=sos.Ramps(t, ramp(t).T))
    none, v = sos.Step([0.0, 0.0]), design.request.plant

    def following(time, x):
        rate = second_order(design, ramp(time), none)(time, x)
        rate[2:4] -= np.linalg.solve(v.M, v.B @ design.K_D @ ramp(1.0))  # e' = z' - r'
        return rate

    done = solve_ivp(following, (0, 2), np.zeros(6), rtol=1e-9, atol=1e-10)
    assert done.y[:2, -1] == pytest.approx(found.z[:, -1], abs=1e-6)


def test_a_disturbance_needs_f():
    one = [[1.0]]
    d = sos.design_pid(sos.SecondOrderSystem(one, one, one, one))
    with pytest.raises(ValueError, match="no F"):
        d.simulate([0, 1], w=sos.Sine(1, 1))


def test_a_step_is_a_sine_without_a_wave(design):
    t = np.linspace(0, 4, 81)
    a = design.simulate(t, w=sos.Step([2, -1], start=0.7, stop=2.2))
    b = design.simulate(t, w=sos.Sine(0, 1, offset=[2, -1], start=0.7, stop=2.2))
    assert np.array_equal(a.x, b.x) and np.array_equal(a.w, b.w)


def test_a_set_point_that_steps(design):
    """Against the sum of two steps of the linear loop, each begun on time."""
    t = np.linspace(0, 4, 81)
    whole = design.simulate(t, r=R, x0=X0)
    assert np.array_equal(whole.z, design.simulate(t, r=sos.Step(R), x0=X0).z)
    late = design.simulate(t, r=sos.Step(R, start=1.5, stop=3.0))
    first = design.simulate(t[t >= 1.5] - 1.5, r=R)
    second = design.simulate(t[t >= 3.0] - 3.0, r=-R)
    x, u, e = (np.zeros_like(y) for y in (late.x, late.u, late.e))
    for part, begin in ((first, 1.5), (second, 3.0)):
        x[:, t >= begin] += part.x
        u[:, t >= begin] += part.u
        e[:, t >= begin] += part.e
    assert late.x == pytest.approx(x, abs=1e-9)
    assert late.u == pytest.approx(u, abs=1e-7)
    assert late.e == pytest.approx(e, abs=1e-9)


def test_levels_of_a_set_point(design):
    t = np.linspace(0, 4, 81)
    levels = sos.Steps([0, 1.5, 3.0], [[0, 0], R, [0, 0]])
    a = design.simulate(t, r=levels)
    b = design.simulate(t, r=sos.Step(R, start=1.5, stop=3.0))
    assert np.array_equal(a.x, b.x) and np.array_equal(a.e, b.e)


def test_a_plant_alone_is_the_loop_without_a_gain():
    plant = thesis.example_1().plant
    t = np.linspace(0, 4, 401)
    zero = sos.analyse_pid(plant, np.zeros((2, 4)))
    x0, push = [0.1, -0.2, 0.3, 0], sos.Step([1, 2], start=0.5, stop=1.5)
    free = plant.simulate(t, x0=x0, w=SINE, u=push)
    assert free.u == pytest.approx(push(t))
    system = control.ss(*control.ssdata(zero.open_loop()))  # from (u, w, r) to x

    def rate(now, x):
        signals = np.concatenate([push([now])[:, 0], SINE([now])[0] * np.ones(2)])
        return system.A @ x + system.B[:, :4] @ signals

    x = integrate(rate, [0, 0.5, 1, 1.5, 2.05, 4], np.array(x0, float), t)
    assert free.x == pytest.approx(x, abs=1e-6)
    assert np.array_equal(free.e, free.z)
    both = sos.Polytope([plant, plant])
    assert [r.z.tolist() for r in both.simulate(t, x0=x0, w=SINE, u=push)] == [
        free.z.tolist()
    ] * 2


@pytest.mark.parametrize(
    "bad, words",
    [
        (dict(u=sos.Step([1, 2, 3])), "u: offset"),
        (dict(u=1.0), "u must be a Sine, Step, Steps or Ramps"),
        (dict(x0=[1, 2]), "x0 must hold 4"),
    ],
)
def test_what_acts_on_a_plant_is_checked(bad, words):
    with pytest.raises(ValueError, match=words):
        thesis.example_1().plant.simulate([0, 1], **bad)


def test_a_singular_mass_isnt_simulated():
    plant = sos.SecondOrderSystem(np.diag([1, 0]), np.eye(2), np.eye(2), np.eye(2))
    with pytest.raises(ValueError, match=r"regularize\(...\).regular"):
        plant.simulate([0, 1])


@pytest.mark.parametrize("size", [1e3, 1e13])
def test_gains_that_cancel_are_simulated_without_rounding_errors(size):
    """Two inputs pull against each other: A + B K is lost in floats."""
    plant = sos.SecondOrderSystem(1, 0.2, 1, [[1, 1]], 1)
    plain = sos.SecondOrderSystem(1, 0.2, 1, 1, 1)
    K = [[size - 1.3, size - 0.7, size - 0.4], [-size, -size, -size]]
    t, U = np.linspace(0, 4, 9), [[1]]
    wave = sos.Sine(0.3, 2.0, 0.1, 0.4, 3.0)
    wanted = sos.analyse_pid(plain, [[-1.3, -0.7, -0.4]], U)
    found = sos.analyse_pid(plant, K, U)
    assert sensitive(found.request.vertices[0], found.K) == (size > 1e9)
    ramps = sos.Ramps([0, 1.3, 1.3, 2.9], [[0], [2], [1], [4]])
    for r in (sos.Step(2.0, 1.0), ramps):
        how = dict(x0=[1, 0, 0.5], r=r, w=wave)
        x, y = (d.simulate(t, **how).x for d in (wanted, found))
        np.testing.assert_allclose(y, x, atol=1e-14 * size if size < 1e9 else 1e-12)


@pytest.mark.parametrize("slope", [0.0, 0.9])
def test_a_program_knows_no_velocity_of_its_set_point(slope):
    """At quick ticks it moves as K_P e + K_D z' + K_I x3 does, along a ramp, too."""
    plant = sos.SecondOrderSystem(
        [[2, 0], [0, 1]], [[0.4, -0.1], [0.3, 0.2]], [[6, -2], [-2, 4]], np.eye(2)
    )
    design = sos.design_pid(plant, U=np.eye(2), region=sos.PoleRegion(0.8, rho=8))
    level = np.array([0.5, -0.3])

    def r(t):
        return level * (slope * min(t, 1) if slope else 1)

    ran = sos.Loop(plant, design).at(T=0.002).simulate(1.4, r=r)
    K_P, K_D, K_I = np.hsplit(design.K, 3)

    def rate(t, x):
        z, dz, x3 = x.reshape(3, 2)
        u = K_P @ (z - r(t)) + K_D @ dz + K_I @ x3
        ddz = np.linalg.solve(plant.M, u - plant.D @ dz - plant.S @ z)
        return np.concatenate([dz, ddz, z - r(t)])

    times = np.ravel(ran.t)
    meant = solve_ivp(
        rate, (0, 1.4), np.zeros(6), t_eval=times, max_step=0.01, rtol=1e-8
    )
    moved = np.asarray(ran.x)[0, :, :2]
    assert np.abs(moved - meant.y[:2].T).max() < 0.005 * np.abs(moved).max()
    along = [sos.Ramps([0, 1, 9], [0 * level, slope * level, slope * level]), level]
    free = design.simulate(times, r=along[slope == 0])
    apart = np.abs(free.z.T - moved).max()
    assert (apart > 0.1 * np.abs(moved).max()) == (slope > 0)
