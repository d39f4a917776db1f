"""Margins of a controller's loop: eigenvalues and python-control, made without it."""

import functools
import re

import numpy as np
import pytest
from scipy.linalg import expm

import sosbook as sos
from sosbook.controllers import margins as margins_module
from sosbook.controllers.charts import chart
from tests.cases import campaign


def drive(J2):
    return sos.SecondOrderSystem(
        M=[[0.0025, 0], [0, J2]], D=[[0.004, -0.004], [-0.004, 0.004]],
        S=[[20, -20], [-20, 20]], B=[[1], [0]], coordinates=["motor", "load"],
    )  # fmt: skip


def odd(m):
    stiff = np.array([[9.81, -1], [-1.3, 3]])
    return sos.SecondOrderSystem(
        [[1, 0.2], [0.2, m]], 0.02 * np.eye(2), stiff, [[1, 0.3], [0, 1]]
    )


def drives():
    gains = {"K_P": [[-4.0129]], "K_D": [[-0.199962]], "K_I": [[-23.2486]]}
    law = sos.PIDLaw(position=[[1, 0]], integrate=True, filter=0.004)
    family = sos.Uncertain(drive, J2=(0.003, 0.006))
    return sos.analyse_pid(family, gains, law=law).controller(T=0.001, delay=0.001)


def odds():
    plants = sos.Polytope([odd(2), odd(2.4)])
    gentle = sos.Search(prefer="least")
    design = sos.design_pid(plants, region=sos.PoleRegion(0.5), search=gentle)
    return design.controller(T=0.05, delay=0.0125)


def cart():
    plant = sos.SecondOrderSystem(1, 0, 0, 1, coordinates=["place"])
    design = sos.design_pid(plant, [[1]], region=sos.PoleRegion(1, rho=9))
    return design.controller(["place"], T=0.02, delay=0.02)


CASES = {  # controller, signal, whether it is an input, and its plants
    "drive, u": (drives, 0, True, [drive(J) for J in (0.003, 0.00371, 0.0052, 0.006)]),
    "odd, u2": (odds, 1, True, [odd(m) for m in (2, 2.17, 2.4)]),
    "odd, z1": (odds, "z1", False, [odd(m) for m in (2, 2.3, 2.4)]),
    "cart, observed": (cart, "place", False, [sos.SecondOrderSystem(1, 0, 0, 1)]),
}


@functools.cache
def found(name, sharp=True):
    """A controller and its margins; what is seen at plants needs no sharp ones."""
    make, at, *_ = CASES[name]
    c = make()
    return c, c.margins(at, time_limit=600, sharp=sharp)


def held(plant, T, late):
    """x+ = A x + B0 u(now) + B1 u(before), an input ``late`` within a tick."""
    n, m = plant.n, plant.B.shape[1]
    inverse = np.linalg.inv(plant.M)
    whole = np.zeros((2 * n + m,) * 2)
    whole[:n, n : 2 * n] = np.eye(n)
    whole[n : 2 * n] = inverse @ np.hstack([-plant.S, -plant.D, plant.B])
    first, rest = expm(whole * late), expm(whole * (T - late))
    A = rest[: 2 * n, : 2 * n]
    return (
        A @ first[: 2 * n, : 2 * n],
        rest[: 2 * n, 2 * n :],
        A @ first[: 2 * n, 2 * n :],
    )


def radius(c, plant, at, of_input, g=1.0, late=0.0):
    """The spectral radius of the loop with a signal times g, by my own loop."""
    whole, rest = divmod(c.delay + late + 1e-12, c.T)
    A, now, before = held(plant, c.T, max(rest - 1e-12, 0.0))
    N, m = now.shape
    older = int(whole) + 1
    rows = c.readings.rows
    turn_u, turn_y = np.eye(m, dtype=complex), np.eye(len(rows), dtype=complex)
    k = at
    if not of_input:
        k = [s.name for s in c.readings.signals].index(at)
    (turn_u if of_input else turn_y)[k, k] = g
    l, C_y = len(c.A), turn_y @ rows
    size = N + m * older + l
    F = np.zeros((size, size), complex)
    u = np.zeros((m, size), complex)
    u[:, :N], u[:, size - l :] = turn_u @ c.D @ C_y, turn_u @ c.C
    past = [u] + [np.eye(m, size, N + m * j).astype(complex) for j in range(older)]
    F[:N, :N] = A
    F[:N] += now @ past[int(whole)] + before @ past[int(whole) + 1]
    for j in range(older):
        F[N + m * j : N + m * (j + 1)] = past[j]
    F[size - l :, :N], F[size - l :, size - l :] = c.B @ C_y, c.A
    return abs(np.linalg.eigvals(F)).max()


@pytest.mark.parametrize(
    "name", ["cart, observed", *campaign(["drive, u", "odd, u2", "odd, z1"])]
)
def test_what_is_proven_is_stable_and_little_beyond_is_not(name):
    c, margins = found(name)
    _, at, of_input, plants = CASES[name]
    (low, high), rng = margins.gain, np.random.default_rng(3)
    phase = np.radians(margins.phase.proven)
    inside = [*np.geomspace(max(low.proven, 1e-4), high.proven, 9)]
    inside += [*np.exp(1j * phase * np.linspace(-1, 1, 9))]
    alpha = margins.disk.proven
    a = alpha * np.sqrt(rng.random(15)) * np.exp(2j * np.pi * rng.random(15))
    inside += [*((2 + a) / (2 - a))]
    for plant in plants:
        assert max(radius(c, plant, at, of_input, g) for g in inside) < 1
        some = np.linspace(0, margins.delay.proven, 9)
        assert max(radius(c, plant, at, of_input, late=x) for x in some) < 1
    ends = [low.seen * 0.98] * (low.seen > 0) + [high.seen * 1.02] * (high.seen < 999)
    ends += [np.exp(1.02j * np.radians(margins.phase.seen))] * (
        margins.phase.seen < 170
    )
    for g in ends:
        assert max(radius(c, x, at, of_input, g) for x in plants) > 1
    late = margins.delay.seen * 1.02
    assert max(radius(c, x, at, of_input, late=late) for x in plants) > 1
    for margin, least in (
        (high, 0.9), (margins.phase, 0.9), (margins.disk, 0.95), (margins.delay, 0.5)
    ):  # fmt: skip
        assert least * min(margin.seen, 500) < margin.proven <= margin.seen * 1.0001
    assert low.seen * 0.9999 <= low.proven <= low.seen * 1.1 + 0.01


@pytest.mark.filterwarnings("ignore:stability_margins")
@pytest.mark.parametrize("name", ["drive, u", "cart, observed"])
def test_python_control_sees_the_same(name):
    control = pytest.importorskip("control")
    c, margins = found(name, sharp=name == "cart, observed")
    _, _, _, plants = CASES[name]
    law, worst = c.to_ss(), []
    for plant in (plants[0], plants[-1]):
        A, now, before = held(plant, c.T, 0.0)
        motor = control.ss(A, now, c.readings.rows, 0 * (c.readings.rows @ now), c.T)
        tick = control.ss(0, 1, 1, 0, c.T)
        assert c.delay == c.T and not before.any()
        L = -control.series(
            tick, motor, control.ss(law.A, law.B[:, :1], law.C, law.D[:, :1], c.T)
        )
        gains, turns, *_ = control.stability_margins(L, returnall=True)
        low = max((x for x in gains if x < 1), default=0)
        up, turn = min(x for x in gains if x > 1), min(abs(x) for x in turns)
        alpha = control.disk_margins(L, np.linspace(1e-2, np.pi / c.T, 4000), skew=0.0)[
            0
        ]
        worst.append((low, up, turn, alpha))
    worst = np.array(worst)
    seen = [x.seen for x in (*margins.gain, margins.phase, margins.disk)]
    assert np.allclose(seen, [worst[:, 0].max(), *worst[:, 1:].min(axis=0)], rtol=0.01)


def test_curves_are_those_of_the_plant_and_the_law():
    c, margins = found("drive, u", sharp=False)
    loop = margins.open_loop
    J, name = 0.006, "J2 = 0.006"
    A, now, _ = held(drive(J), c.T, 0.0)
    rows = c.readings.rows
    for k in (0, len(loop.omega) // 2, len(loop.omega) - 1):
        z = np.exp(1j * loop.omega[k] * c.T)
        P = rows @ np.linalg.solve(z * np.eye(4) - A, now + 0j) / z
        law = c.C @ np.linalg.solve(z * np.eye(c.order) - c.A, c.B + 0j) + c.D
        L = -(law @ P)[0, 0]
        assert np.isclose(loop.L[loop.names.index(name), k], L, rtol=1e-6)
    for svg in (loop.bode(), loop.nyquist(), loop.nichols(), margins._repr_html_()):
        assert "polyline" in svg and "nan" not in svg
        lines = re.findall("<polyline.*?/>", svg)
        assert all('fill="none"' in x for x in lines)  # on pages without a style, too
    for line in re.findall('<polyline points="(.*?)"', loop.nyquist()):  # no chord
        at = np.array([[*map(float, p.split(","))] for p in line.split()])
        assert np.linalg.norm(np.diff(at, axis=0), axis=1).max() < 50
    assert "rad/s" in loop.bode() and "J2 = 0.003" in margins._repr_html_()
    assert loop.bode().count("as seen") >= 2  # between these plants nothing is proven
    beside = sos.plants.MeasuredResponse(loop.omega[5:-5:9], 0.9 * loop.L[0, 5:-5:9])
    for draw in (loop.bode, loop.nyquist, loop.nichols):
        both = [re.findall('points="(.*?)"', draw(x)) for x in (None, beside)]
        assert len(both[1]) == len(both[0]) + (2 if draw == loop.bode else 1)
        assert "nan" not in draw(beside)
    here, there = (re.findall("<polygon.*?/>", loop.bode(x)) for x in (None, beside))
    assert here == there  # it is inside the axes, and no part of the band


def test_a_band_is_what_the_curves_span():
    t = np.array([1.0, 2.0, 4.0])
    curves = [(t, np.array(y)) for y in ([1.0, 5.0, 3.0], [2.0, 4.0, 9.0], [0.0, 6, 4])]
    svg = chart(curves, "y", log=True, low=True, band=3)
    found = re.findall('points="(.*?)"', svg)
    band, *lines = [[[*map(float, p.split(","))] for p in x.split()] for x in found]
    least, most = (way(np.array(lines)[:, :, 1], axis=0) for way in (np.max, np.min))
    assert [p[1] for p in band] == [*least, *most[::-1]]  # down is up
    assert [p[0] for p in band[:3]] == [p[0] for p in band[:2:-1]]


def test_a_long_label_is_drawn_within_its_chart():
    """Nyquist's was cut where it says what its mark is."""
    t = np.linspace(0, 1, 5)
    for label, close in (
        ("u", False),
        ("Im of L at axis two, to the size 4" * 3, True),
    ):
        svg = chart([(t, t)], label)
        wide = float(re.search('viewBox="0 0 ([0-9.]+) ', svg)[1])
        words = re.search(f'<text x="([0-9.]+)"[^>]*>{re.escape(label)}', svg)
        assert ("textLength" in words[0]) == close
        if close:
            length = float(re.search('textLength="([0-9.]+)"', words[0])[1])
            assert float(words[1]) + length <= wide


def test_margins_whose_time_is_over_say_so():
    c = cart()
    short, whole = (c.margins(time_limit=s, sharp=False) for s in (1e-9, 60))
    assert short.stopped and short.disk.proven is None
    assert not whole.stopped and whole.disk.proven > 0
    for margins in (short, whole):
        assert ("the time was over" in repr(margins)) == margins.stopped


def test_the_clock_goes_as_far_as_own_sequences_of_ticks():
    c = drives()
    _, _, _, plants = CASES["drive, u"]
    proof = c.furthest(tolerance=0.2)
    (short, long), rng = proof.T, np.random.default_rng(5)
    assert proof.proven and short == c.T and long > 1.5 * c.T
    late = c.furthest("delay", tolerance=0.5)
    assert late.proven and late.delay[1] > c.delay
    for plant in plants[:2]:
        steps, F = [], np.eye(4 + 1 + c.order)
        for T in (short, long):  # the input comes 1 ms late in intervals of both
            A, now, before = held(plant, T, c.delay)
            u = np.hstack([c.D @ c.readings.rows, [[0]], c.C])
            own = np.hstack([c.B @ c.readings.rows, np.zeros((c.order, 1)), c.A])
            x = np.hstack([A, before, np.zeros((4, c.order))]) + now @ u
            steps.append(np.vstack([x, u, own]))
        for pick in rng.integers(0, 2, 4000):
            F = steps[pick] @ F
        assert np.linalg.norm(F) < 1e-6
    for words, asked in (
        ("isn't above", dict(most=0.0005)),
        ('"T" or "delay"', dict(find="rate")),
    ):
        with pytest.raises(ValueError, match=words):
            c.furthest(**asked)


def test_delays_of_many_ticks_are_seen_and_no_disk_is_proven_twice(monkeypatch):
    """A slow axis at a quick clock: it was said to bear any delay. The chain of its
    gains, which a limit of time ends, comes after the delay.
    """
    plant, asked = sos.SecondOrderSystem(9.81, 0.3, 0, 3, coordinates=["place"]), []
    law, gains = sos.PIDLaw(position=[[1]], filter=0.5), {"K_P": [[-0.02]]}
    c = sos.analyse_pid(plant, gains | {"K_D": [[-0.3]]}, law=law).controller(T=0.05)
    names, parts = ["proven", "by_balls"], []

    def noted(name, of, work):
        def asks(*args, **more):
            asked.append((name, str(args[1:]), str(more)))
            parts.append(name)
            return work(*args, **more)

        monkeypatch.setattr(of, name, asks)

    for name, of in zip(names, (margins_module.Cut, margins_module)):
        noted(name, of, getattr(of, name))
    late = c.margins().delay
    step, ticks = 25 * c.T, []
    for k in range(1, 12):
        ticks.append(radius(c, plant, 0, True, late=k * step))
    last = next(k for k, x in enumerate(ticks) if x >= 1)
    assert last * step < late.seen < (last + 1) * step
    assert late.seen > 64 * c.T and 0 < late.proven < late.seen
    assert len(set(asked)) == len(asked)
    assert parts.index("by_balls") == 2 and parts[-1] == "proven"


def test_inputs_that_may_come_later_than_is_looked_for_have_no_end_seen():
    """Two slow axes: what frequencies tell of one isn't what all inputs may do."""
    plant = sos.SecondOrderSystem(
        np.diag([9.81, 3]), 0.3 * np.eye(2), np.zeros((2, 2)), np.eye(2)
    )
    law = sos.PIDLaw(position=np.eye(2), filter=0.5)
    gains = {"K_P": -0.02 * np.eye(2), "K_D": -0.3 * np.eye(2)}
    c = sos.analyse_pid(plant, gains, law=law).controller(T=0.05)
    assert radius(c, plant, 0, True, late=64 * c.T) < 1
    late = c.margins(time_limit=0.7).delay
    assert np.isnan(late.seen) and "its end wasn't seen" in str(late)


def test_what_has_no_margin_is_said():
    c = cart()
    for at in ("speed", 1, 2.5):
        with pytest.raises(ValueError, match="at must|at = |at:"):
            c.margins(at)
    law = sos.PIDLaw(position=[[1]], filter=0.02)
    plant = sos.SecondOrderSystem(1, 0, 0, 1)
    bad = sos.analyse_pid(plant, {"K_P": [[1.0]], "K_D": [[0.0]]}, law=law)
    with pytest.raises(ValueError, match="stable loop"):
        bad.controller(T=0.01).margins()
