"""Signals that are linear between times, against python-control, closed forms and
scipy's integrator.
"""

import control
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import sosbook as sos
from sosbook.analysis import precise

G = 9.81
M, D, S, B = 0.3 / G, 0.01, 0.3 * G, 0.7  # lightly damped, in units that aren't round
K = np.array([[-0.4, -0.05, -0.3]])
TIMES = np.array([0, 0.7, 0.7, 1.3, 2.9])
LEVELS = np.array([[0.3], [G], [-1.0], [0.5], [2.0]])
JUMPING = sos.Ramps(TIMES, LEVELS)
GRID = np.linspace(0, 4, 161)
PLANT = sos.SecondOrderSystem(M, D, S, B, 2 * B)


def line(k, t):
    """The straight line from point k of `JUMPING` to the next one, and its slope."""
    if k == len(TIMES) - 1:
        return LEVELS[k, 0], 0.0
    slope = (LEVELS[k + 1, 0] - LEVELS[k, 0]) / (TIMES[k + 1] - TIMES[k])
    return LEVELS[k, 0] + slope * (t - TIMES[k]), slope


def written_out(rate, size, x0=None):
    """``rate(t, x, signal, slope)`` integrated from piece to piece of `JUMPING`."""
    x, found = np.zeros(size) if x0 is None else x0, np.empty((size, len(GRID)))
    for k, now in enumerate(TIMES):
        then = np.append(TIMES, GRID[-1])[k + 1]
        if now == then:
            continue
        inside = (now <= GRID) & (GRID <= then)
        how = dict(method="DOP853", rtol=1e-11, atol=1e-12, dense_output=True)
        done = solve_ivp(lambda t, x: rate(t, x, *line(k, t)), (now, then), x, **how)
        found[:, inside], x = done.sol(GRID[inside]), done.y[:, -1]
    return found


def pid(t, x, r, slope, more=lambda z: 0.0):
    """The mass with u = K_P e + K_D e' + K_I x3, e = z - r, and a force f(z)."""
    u = K[0] @ [x[0] - r, x[1] - slope, x[2]]
    return [x[1], (B * u - D * x[1] - S * x[0] - more(x[0])) / M, x[0] - r]


@pytest.mark.parametrize("exactly", [False, True])
def test_a_jumping_line_against_an_integrator(exactly, monkeypatch):
    """Also by exact matrices, which sensitive loops take."""
    monkeypatch.setattr("sosbook.analysis.precise.in_rationals", lambda *_: exactly)
    assert precise.in_rationals() == exactly
    found = sos.analyse_pid(PLANT, K, [[1]]).simulate(GRID, r=JUMPING)
    x = written_out(pid, 3)
    assert found.x == pytest.approx(x, abs=1e-7)
    after = np.array([line(np.sum(TIMES <= t) - 1, t) for t in GRID]).T
    assert found.e[0] == pytest.approx(x[0] - after[0], abs=1e-7)
    u = K[0, 0] * found.e[0] + K[0, 1] * (x[1] - after[1]) + K[0, 2] * x[2]
    assert found.u[0] == pytest.approx(u, abs=1e-6)


def test_a_record_against_python_control():
    """Its simulation of linear inputs is exact, too."""
    step, rng = 0.05, np.random.default_rng(3)
    t = step * np.arange(81)
    record = rng.normal(size=81)
    record[0] = 0.0
    found = sos.analyse_pid(PLANT, K, [[1]]).simulate(
        t, r=sos.Ramps(t, record[:, None])
    )
    p, d, i = -B * K[0]
    loop = control.tf([d, p, i], [M, D + d, S + p, i])
    true = np.asarray(control.forced_response(loop, t, record).outputs)
    assert found.z[0] == pytest.approx(true, abs=1e-8 * float(abs(true).max()))
    free = control.tf([2 * B], [M, D, S])
    true = np.asarray(control.forced_response(free, t, record).outputs)
    pushed = PLANT.simulate(t, w=sos.Ramps(t, record[:, None]))
    assert pushed.z[0] == pytest.approx(true, abs=1e-8 * float(abs(true).max()))
    assert pushed.w[0] == pytest.approx(record)


def test_a_force_that_grows_in_closed_form():
    """M z'' + S z = v t has z = v/S (t - sin(w t)/w)."""
    plant = sos.SecondOrderSystem(M, 0, S, 1)
    omega = np.sqrt(S / M)
    run = plant.simulate(GRID, u=sos.Ramps([0, 4], [[0], [4 * G]]))
    true = G / S * (GRID - np.sin(omega * GRID) / omega)
    assert run.z[0] == pytest.approx(true, abs=1e-10)
    assert run.u[0] == pytest.approx(G * GRID)


def test_the_error_behind_a_ramp():
    """Without an integrator it grows where there is a spring, and is D v / (-B K_P)
    where there is none; one integrator leaves S v / (-B K_I), or nothing.
    """
    t, v = np.array([0, 300.0, 400.0]), 0.3
    ramp = sos.Ramps([0, 400], [[0], [400 * v]])

    def errors(S, K, U):
        plant = sos.SecondOrderSystem(M, D, S, B)
        return sos.analyse_pid(plant, K, U).simulate(t, r=ramp).e[0, 1:]

    left = S * v / (B * K[0, 2])
    assert errors(S, K, [[1]]) == pytest.approx([left, left], abs=1e-6)
    assert errors(0, K, [[1]]) == pytest.approx([0, 0], abs=1e-6)
    behind = D * v / (B * K[0, 0])
    assert errors(0, K[:, :2], None) == pytest.approx([behind, behind], abs=1e-6)
    grown = np.diff(errors(S, K[:, :2], None)).item() / 100
    assert grown == pytest.approx(-S * v / (S - B * K[0, 0]))


def test_two_integrators_leave_no_error_behind_a_ramp():
    """The same ramp behind the spring, with K(s) of python-control."""
    law = control.tf([-0.22, -2.015, -1.505, -0.5], [0.01, 1, 0, 0])  # 1/s^2 in it
    law = control.ss(law)
    law.set_inputs(["z1"]), law.set_outputs(["u"])
    loop = sos.Loop(PLANT, law)
    assert loop.poles().real.max() < -0.1
    run = loop.simulate([0, 300.0, 400.0], r=sos.Ramps([0, 400], [[0], [400 * 0.3]]))
    assert run.e[0, 1:] == pytest.approx([0, 0], abs=1e-6)


def test_a_law_at_ticks_against_its_own_loop():
    """u is held from tick to tick, and the integral is the plant's own."""
    T = 0.1
    lqr = sos.design_sampled_lqr(PLANT, np.eye(3), [[1]], T, U=[[1]])
    t = np.unique(np.concatenate([GRID, T * np.arange(41)]))
    found = lqr.simulate(t, r=JUMPING, w=sos.Ramps(TIMES, LEVELS / 3))
    x, gain = np.zeros(3), lqr.K[0]
    for tick in range(40):
        now = t[np.argmin(abs(t - T * tick))]
        r, slope = JUMPING([now])[0, 0], JUMPING.slope([now])[0, 0]
        u = gain @ (x - [r, slope, 0])
        assert found.u[0, np.searchsorted(t, now)] == pytest.approx(u, abs=1e-6)

        def rate(s, y):
            r = JUMPING([s])[0, 0]
            force = B * u + 2 * B * r / 3 - D * y[1] - S * y[0]
            return [y[1], force / M, y[0] - r]

        for a, b in ((now, now + T / 2), (now + T / 2, now + T)):
            done = solve_ivp(rate, (a, b), x, max_step=T / 8, rtol=1e-9, atol=1e-11)
            x = done.y[:, -1]
        then = np.argmin(abs(t - T * (tick + 1)))
        assert found.x[:, then] == pytest.approx(x, abs=2e-3)


def test_a_nonlinear_plant_against_an_integrator():
    def force(z, dz):
        return [np.sin(3 * z[0])]

    found = sos.simulate_nonlinear(PLANT, force, K, GRID, [[1]], r=JUMPING)
    true = written_out(lambda *a: pid(*a, more=lambda z: np.sin(3 * z)), 3)
    assert found.x == pytest.approx(true, abs=1e-6)
    pushed = sos.simulate_nonlinear(
        PLANT, lambda z, dz: [0], 0 * K, GRID, [[1]], w=JUMPING
    )
    assert pushed.z == pytest.approx(PLANT.simulate(GRID, w=JUMPING).z, abs=1e-7)


def test_a_program_takes_it_as_a_function():
    """Its ticks read the record, and so do those of a function of the same values."""
    law = sos.PIDLaw([[1]], integrate=True, filter=0.02)
    gains = {"K_P": [[-0.4]], "K_D": [[-0.05]], "K_I": [[-0.3]]}
    c = sos.Loop(PLANT, law, gains).at(T=0.01)
    one = c.simulate(3.0, r=JUMPING)
    two = c.simulate(3.0, r=lambda s: [line(np.sum(TIMES <= s) - 1, s)[0]])
    assert one.x == pytest.approx(two.x) and abs(one.x).max() > 0.1


def test_steps_are_ramps_that_jump():
    """Also as forces, in every verb."""
    steps = sos.Steps([0, 1.5, 2.0], [[0.3], [-G], [1.0]])
    ramps = sos.Ramps([0, 1.5, 1.5, 2, 2], [[0.3], [0.3], [-G], [-G], [1.0]])
    design = sos.analyse_pid(PLANT, K, [[1]])
    lqr = sos.design_sampled_lqr(PLANT, np.eye(3), [[1]], 0.1, U=[[1]])
    for run in (design.simulate, lqr.simulate):
        for name in ("r", "w"):
            a, b = (run(GRID, **{name: signal}) for signal in (steps, ramps))
            assert a.x == pytest.approx(b.x, abs=1e-9)
            assert a.u == pytest.approx(b.u, abs=1e-9)


def test_an_acceleration_gain_is_counted_in_u():
    """M z'' + D z' + S z = B u + F w, on a ramp and under one."""
    design = sos.analyse_pid(PLANT, K, [[1]], K_A=[[-0.02]])
    t = np.linspace(0, 1, 20001)
    run = design.simulate(
        t, r=sos.Ramps([0, 2], [[0], [1]]), w=sos.Ramps([0, 2], [[1], [0]])
    )
    left = M * np.gradient(run.dz[0], t) + D * run.dz[0] + S * run.z[0]
    right = B * run.u[0] + 2 * B * run.w[0]
    assert np.abs(left - right)[5:-5].max() < 1e-5


@pytest.mark.parametrize(
    "times, levels, words",
    [
        ([0, 2, 1], [[1], [2], [3]], "times must increase from 0"),
        ([1, 2], [[1], [2]], "times must increase from 0"),
        ([0, 1], [[1], [np.nan]], "levels"),
        ([0, 1], [[1]], "levels"),
    ],
)
def test_ramps_are_checked(times, levels, words):
    with pytest.raises(ValueError, match=words):
        sos.Ramps(times, levels)


def test_what_a_verb_does_not_take_is_refused_with_a_cure():
    design = sos.analyse_pid(PLANT, K, [[1]])
    with pytest.raises(ValueError, match="w has levels of 2 numbers, needs 1"):
        design.simulate(GRID, w=sos.Ramps([0, 1], np.eye(2)))
    bare = sos.analyse_pid(sos.SecondOrderSystem(1, 1, 1, 1), [[-1, -1]])
    with pytest.raises(ValueError, match="the plant has no F"):
        bare.simulate(GRID, w=JUMPING)
    late = sos.Loop(PLANT, sos.FullState([[1]]), K).late(tau=0.01)
    for bad in (dict(r=JUMPING), dict(w=JUMPING), dict(r=lambda t: [t])):
        with pytest.raises(ValueError, match=r"at ticks, loop\.at\(T, delay\)"):
            late.simulate(GRID, **bad)
