"""Bounds of outputs, and proofs with limits: no plant between vertices breaks them."""

from dataclasses import replace
from fractions import Fraction
from itertools import product

import numpy as np
import pytest
from flint import arb, ctx

import sosbook as sos
from sosbook.controllers import Bounded, Reach, Replay
from sosbook.controllers.bounds import bounded_output, rounded
from sosbook.controllers.cells import BALL_BITS, Joined, JoinedCell
from sosbook.controllers.facts import bounded as bounded_lines
from sosbook.controllers.facts import facts_of
from sosbook.controllers.step_bounds import _Numbers, _times
from sosbook.controllers.trial import steps_of
from sosbook.exact.rational import exact
from sosbook.plants.descriptor import descriptors
from sosbook.sampled.balls import balls
from tests.axis import T, axis, design, drive, stepless
from tests.cases import campaign

LOADS = np.linspace(0.003, 0.006, 7)


def loops(c, loads=LOADS):
    return [c.loop(descriptors(drive(J2))[0]) for J2 in loads]


def worst(h):
    """The largest sum of |h| over the ticks."""
    return float(abs(h).sum(axis=0).max())


@pytest.fixture(scope="module")
def bounded():
    c = axis()
    return c, c.bounds.noise(), c.bounds.ramp(1.0), c.bounds.step(1.0)


def test_noise_of_an_encoder_at_the_worst(bounded):
    c, noise, *_ = bounded
    step = 2 * np.pi / 4096
    true = [worst(x.impulses(x.noise, x.direct, 5000)) * step / 2 for x in loops(c)]
    assert max(true) <= noise.proven < 1.6 * max(true)
    assert noise.seen == pytest.approx(max(true[0], true[-1]), rel=1e-3)
    coarse = c.bounds.noise(1024)
    assert coarse.proven == pytest.approx(4 * noise.proven)
    # a reading that is off as badly as it can be, tick by tick
    loop = loops(c)[3]
    h = loop.impulses(loop.noise, loop.direct, 600)[:, 0, 0]
    x, push = np.zeros(len(loop.F)), np.sign(h[::-1]) * step / 2
    for e in push:
        u = loop.H @ x + loop.direct[0] * e
        x = loop.F @ x + loop.noise[:, 0] * e
    assert 0.9 * true[3] < abs(u[0]) <= noise.proven


@pytest.mark.parametrize("T", [0.004, *campaign([0.002])])
def test_slow_clocks_whose_loads_differ_more_from_tick_to_tick_are_bounded(T):
    c = design().controller(["motor"], T=T, delay=T, counts=4096)
    for bound in (c.bounds.noise(), c.bounds.ramp(1.0)):
        assert bound.seen < bound.proven < 1.6 * bound.seen
    true = [worst(x.impulses(x.noise, x.direct, 3000)) * np.pi / 4096 for x in loops(c)]
    assert max(true) <= c.bounds.noise().proven


def test_ramps_and_steps_of_every_load(bounded):
    c, _, ramp, step = bounded
    sums, peaks = [], []
    for loop in loops(c):
        x, u = np.zeros(len(loop.F)), []
        for _ in range(5000):
            u.append((loop.H @ x + loop.direct_r[:, 0])[0])
            x = loop.F @ x + loop.set_point[:, 0]
        sums.append(abs(np.array(u)).sum() * T)
        peaks.append(abs(np.array(u)).max())
    assert max(sums) <= ramp.proven < 1.8 * max(sums)
    assert max(peaks) <= step.proven < 2.2 * max(peaks)
    assert ramp.seen <= max(sums) * (1 + 1e-6) and step.seen <= max(peaks) * (1 + 1e-6)
    assert c.bounds.largest_step(2.0) == pytest.approx(2.0 / step.proven)
    assert c.bounds.ramp_for(2.0) == pytest.approx(2.0 / ramp.proven)


def arm(m):
    """A pendulum upside down on an arm that turns freely: 0.1 to 0.16 kg; N m."""
    r, l, g = 0.12, 0.15, 9.81
    return sos.SecondOrderSystem(
        [[0.003 + m * r * r, m * r * l], [m * r * l, 4 / 3 * m * l * l]],
        [[0.005, 0], [0, 1e-4]],
        [[0, 0], [0, -m * g * l]],
        [[1], [0]],
        [[0], [1]],
    )


def test_a_rest_is_found_where_one_coordinate_is_free_and_another_falls():
    """In rationals: floats leave the pendulum 1e-18 rad beside the vertical."""
    c = sos.design_pid(
        sos.Uncertain(arm, m=(0.1, 0.16)),
        region=sos.PoleRegion(2, 1.2, 60),
        saturation=sos.Saturation(None, [0, 0.15, 0, 0]),
        minimize="u_max",
    ).controller(T=0.004)
    step, turned = c.bounds.step(), -c.D_r[0, 0]
    loop, x = c.loop(descriptors(arm(0.13))[0]), np.array([-1.0, 0, 0, 0])
    asked = []
    for _ in range(3000):
        asked.append(abs(loop.H @ x)[0])
        x = loop.F @ x
    assert turned == pytest.approx(max(asked)) and turned <= step.proven
    assert c.bounds.largest_step(0.5) == pytest.approx(0.5 / step.proven)


def test_a_bound_that_takes_too_long_is_none_and_says_so(bounded):
    c, noise, *_ = bounded
    late = c.bounds.noise(time_limit=1e-9)
    assert (late.proven, late.seen, late.stopped) == (None, noise.seen, 1e-9)
    assert str(late).startswith("no bound found within 1e-09 s (a longer ")
    asked = dict(range=1, speed=1, time_limit=1e-9)
    for bound in (
        c.bounds.ramp(time_limit=1e-9),
        c.bounds.rounding(**asked),
        c.bounds.step(time_limit=1e-9),
    ):
        assert bound.proven is None and bound.stopped and "nan" not in str(bound)
    with pytest.raises(ValueError, match="u_max: no bound was proven: no bound found"):
        c.bounds.largest_step(2.0, time_limit=1e-9)
    with pytest.raises(ValueError, match="time_limit must be positive"):
        c.bounds.ramp_for(2.0, time_limit=0)


@pytest.mark.slow
def test_what_is_said_to_settle_settles():
    """With the limit at work, on plants between and within the proof."""
    c = axis().limit(2.0, tracking_time=0.05).watch(stall=20)
    naive = c.set_point(r=[[1], [1]])
    reach = naive.bounds.reach()
    assert reach.step > 0.3 and reach.sector > 0
    inside = [descriptors(drive(J2))[0] for J2 in (0.0041, 0.006)]
    run = naive.simulate(2.0, r=[reach.step], plants=inside)
    assert run.x[:, -1, 1] == pytest.approx([reach.step] * 2, rel=0.03)
    assert abs(run.u).max() > 1.0  # it asks much


def test_the_sign_of_the_anti_windup_is_right():
    c = axis().set_point(r=[[1], [1]]).watch(stall=20)
    ways = {}
    for name, time in (("right", 0.05), ("none", None), ("wrong", -0.05)):
        limits = replace(c.limit(2.0).limits, tracking_time=time)
        one = replace(c, limits=limits)
        run = one.simulate(1.2, r=[8.0])
        ways[name] = run.x[:, :, 1].max()
    assert ways["right"] < 1.3 * 8 < ways["none"] < ways["wrong"]


def test_no_reach_without_limits_and_no_ramp_against_springs():
    with pytest.raises(ValueError, match="limit every output first"):
        axis().bounds.reach()
    spring = sos.SecondOrderSystem([[0.3]], [[1]], [[9.81]], [[1]])
    found = sos.design_pid(spring, [[1]], region=sos.PoleRegion(1, rho=60))
    c = found.controller(T=0.002)
    with pytest.raises(ValueError, match="isn't exactly zero"):
        c.bounds.ramp()
    assert c.limit(5.0).bounds.reach().step is None


def cart(U=None, **clock):
    """One without springs, held by its place and its rate, and the integrals of U."""
    plant = sos.SecondOrderSystem([[1]], [[0]], [[0]], [[1]], coordinates=["place"])
    found = sos.design_pid(plant, U, region=sos.PoleRegion(1, rho=9))
    return found.controller(["place"], counts=500, **clock)


def test_a_memory_of_rounded_numbers_rests_where_it_does():
    """An observer, at almost the set point: bounds are of the motion to that place."""
    c = cart(T=0.01, delay=0.01)
    loop = c.loops[0]
    x, u = np.zeros(len(loop.F)), []
    for _ in range(3000):
        u.append((loop.H @ x + loop.direct_r[:, 0])[0])
        x = loop.F @ x + loop.set_point[:, 0]
    assert 1e-14 < abs(x[0] - 1) < 1e-6 and abs(u[-1]) < 1e-12
    asked = max(map(abs, u)), np.abs(u).sum() * c.T
    for bound, true in zip((c.bounds.step(), c.bounds.ramp()), asked, strict=True):
        assert true * (1 - 1e-9) <= bound.proven < 1.6 * true


@pytest.mark.filterwarnings("ignore:T = .* the loop is sampled")
def test_a_loop_that_is_unstable_has_no_bound():
    """Neither infinity nor what isn't a number is called one."""
    c = cart(T=0.4, memory="filter", filter_time=0)
    assert c.radius > 1
    for found in (c.bounds.noise(), c.bounds.step(), c.bounds.ramp()):
        assert found.proven is None and found.seen == np.inf
        assert str(found).startswith("no bound found; inf")
    with pytest.raises(ValueError, match="no bound was proven"):
        c.bounds.largest_step(1.0)
    found = c.bounds.step_response()  # it neither settles nor rises
    words = repr(found)
    assert "svg" not in found._repr_html_()
    assert words.count("no bound found") == 7 and " s at " not in words
    for ask, what in ((c.bounds.weights, "weights"), (c.motions.move, "motions")):
        with pytest.raises(ValueError, match=f"{what} are of a stable loop"):
            ask(0.05, 2.0)


@pytest.mark.parametrize("stretch", [0, 1e-13, -1e-13])
def test_an_inequality_is_of_the_given_P_and_R(monkeypatch, stretch):
    """To 1e-20 of F'F, with axes that are orthonormal to rounding, or not at all."""
    c, eigh = cart(T=0.01, memory="filter", filter_time=0.02), np.linalg.eigh

    def stretched(x):
        sizes, axes = eigh(x)
        return sizes, axes * (1 + stretch)

    monkeypatch.setattr("sosbook.sampled.cells.np.linalg.eigh", stretched)
    with ctx.workprec(BALL_BITS):
        joined = Joined(c, c.B[:, :0], c.D[:, :0])
        whole = joined.family.shape.whole()
        F = joined.family.loop(whole[0], c.timing)
        L = np.diag([0.3, 9.81 * (1 + 2 * stretch), 1, 2][: len(F)])
        cell = joined.cell(whole, L)
        gram = F.T @ balls(exact(L) @ exact(L)) @ F
        e = balls(1e-20 * np.eye(len(F)))
        assert cell.least(gram + e) > 0
        assert not cell.least(gram - e) > 0
        turn = cell.cell.turn
        off = abs(turn @ turn.T - balls(np.eye(len(F))))
        assert all(x < 1e-30 and x.contains(0) for x in off.flat)


def split(c):
    """The same of 0.1 z and z: floats of D R are rounded."""
    rows = np.array([[0.1, 0.0], [1.0, 0.0]])
    twice = c.readings.steps.repeat(2)
    seen = replace(c.readings, rows=rows, steps=twice, signals=c.readings.signals * 2)
    same = replace(c, readings=seen)
    rest = {n: (exact(c.parts[n]) * 9 / 10).astype(float) for n in "BD"}
    same.__dict__["parts"] = c.parts | {
        n: np.hstack([c.parts[n], more]) for n, more in rest.items()
    }
    return same


def test_the_inequalities_have_no_rounded_numbers(monkeypatch):
    """R of what is proven of limits, again in fractions."""
    c = cart([[1]], T=0.01, memory="filter", filter_time=0.02)
    c = split(c.limit(73.3, tracking_time=0.3))
    asked, least = [], JoinedCell.least

    def noted(cell, R):
        asked.append((cell, R))
        return least(cell, R)

    monkeypatch.setattr(JoinedCell, "least", noted)
    A, B, C, D, W, rows = map(exact, (c.A, c.B, c.C, c.D, c.W, c.readings.rows))
    H, u_max = np.hstack([D @ rows, C]), exact(73.3)
    assert c.bounds.reach().sector and asked
    for cell, R in asked:
        N, less, family = len(R) - 1, cell.joined.less, cell.joined.family
        L = exact(cell.cell.L[:N, :N])
        assert around(R[:N, :N], L.T @ L - H.T @ H / u_max**2)
        assert around(R[N:, N:], exact(np.eye(1)) / less**2)
        own = np.hstack([B @ rows - less * W @ D @ rows, A - less * W @ C])
        assert around(family.own[: len(A), :-1], own)
        u = np.hstack([(1 - less) * D @ rows, (1 - less) * C, [[-u_max]]])
        assert around(family.full[-1:], u)


def around(x, exactly):
    """Whether balls hold rationals, and little else."""
    with ctx.workprec(400):
        pairs = zip(x.flat, balls(exactly).flat, strict=True)
        return all(e.contains(true) and e.rad() < 1e-25 for e, true in pairs)


def test_a_proof_of_rounded_numbers_says_so():
    whole = cart(T=0.01, memory="filter", filter_time=0.02)
    rows = 1.00000001234567 * whole.readings.rows
    odd = replace(whole, readings=replace(whole.readings, rows=rows))
    for c, said in ((whole, False), (odd, True)):
        (_, proven), *_ = facts_of(c, 60.0)[0]
        assert any("rounded to 17 digits" in line for line in proven) == said


def test_products_of_bounds_are_rounded_to_the_safe_side():
    c = cart(T=0.01, memory="filter", filter_time=0.02)
    one = Fraction(c.bounds.ramp(100.0).proven)  # 100 T is 1
    sizes = np.random.default_rng(0).uniform(1, 9, 20).round(3).tolist()
    for x, p in product(sizes, sizes):
        largest = c.bounds._largest(Bounded(p, p), x)
        assert Fraction(largest) * Fraction(p) <= Fraction(str(x))
        assert largest == pytest.approx(x / p, rel=1e-15)
        most = rounded(arb(exact(x)) * arb(p), np.inf)
        assert Fraction(most) >= Fraction(str(x)) * Fraction(p)
    for x in sizes[:3]:
        assert (
            Fraction(c.bounds.ramp(100 * x).proven)
            >= one * Fraction(str(100 * x)) / 100
        )
    assert rounded(arb(0), np.inf) == 0 and rounded(arb(0.5), 0) == 0.5
    assert rounded(arb(exact(0.006)), np.inf) == np.nextafter(0.006, 1)
    for ticks, tick in ((6, 0.001), (3, 0.1), (7, 0.3), (981, 0.01)):
        most = str(Bounded(_times(ticks, exact(tick)), 0.0)).split()[2]
        assert Fraction(most) == ticks * Fraction(str(tick))  # and no digit more
    with ctx.workprec(BALL_BITS):
        for third in (arb(1) / 3, arb(2) / 3):
            assert arb(rounded(third, 0)) < third < arb(rounded(third, np.inf))
    c = stepless(c)
    assert c.bounds.noise().proven == 0
    turn = Fraction("6.283185307179586476925286766559005768")
    c = cart(T=0.01, memory="filter", filter_time=0.02)
    unit = Fraction(bounded_output(c, c.B, c.D, 0))
    for counts in (500, 1000, 4096, 7919):
        assert Fraction(c.bounds.noise(counts).proven) >= turn / counts / 2 * unit


def test_a_header_says_which_loop_a_bound_is_of():
    """Beyond the limit it is of the loop without it, and a reach says what it lacks."""
    c = cart(T=0.01, memory="filter", filter_time=0.02)
    asked = c.bounds.step().proven
    limited = [c.limit(x * asked) for x in (0.99, 1.01)]
    low, high = (bounded_lines(x, steps_of(x, 1.0)) for x in limited)
    assert any(line.endswith(", without its limit") for line in low)
    assert not any("without its limit" in line for line in high)
    assert any("Slew, ramps, faults" in line for line in low)


@pytest.mark.parametrize(
    "ask, words",
    [
        (lambda c: c.bounds.step(-1.0), "size must be positive"),
        (lambda c: c.bounds.step(float("nan")), "size must be a finite"),
        (lambda c: c.bounds.ramp(-1.0), "speed must be positive"),
        (
            lambda c: c.bounds.step(set_point=2),
            "set_point must be one of 0: set point of",
        ),
        (lambda c: c.bounds.ramp(output=1), "output must be one of 0: u; got 1"),
        (lambda c: c.bounds.noise(output=-1), "output must be one of 0: u; got -1"),
        (lambda c: c.limit(20.0).bounds.reach("a"), "set_point must be one of"),
    ],
)
def test_what_no_bound_is_of_is_named(ask, words):
    with pytest.raises(ValueError, match=words):
        ask(cart(T=0.01, memory="filter", filter_time=0.02))


def test_an_encoder_that_is_too_coarse_is_named():
    rough = design().controller(["motor"], T=T, delay=T, counts=24)
    with pytest.raises(ValueError, match="counts are too coarse.*a count, and u_max"):
        rough.limit(2.0)


@pytest.mark.slow
def test_bounds_of_four_vertices_and_two_inputs():
    """Masses and springs in a box, units by .3 and 9.81: sums of all plants tried."""

    def two(m, k):
        return sos.SecondOrderSystem(
            [[0.3 * m, 0], [0, 0.3]],
            [[1, 0], [0.2, 1]],
            [[9.81 * k, -1], [-1, 9.81]],
            [[1, 0], [0, 2]],
        )

    plants = sos.Uncertain(two, m=(1, 1.3), k=(1, 1.2))
    found = sos.design_pid(plants, region=sos.PoleRegion(1, rho=60))
    c = found.controller(["z1", "z2"], T=0.005, delay=0.002)
    c = replace(c, readings=replace(c.readings, steps=np.array([1e-3, 2e-3])))
    true = []
    for m, s in np.random.default_rng(0).uniform((1, 1), (1.3, 1.2), (8, 2)):
        loop = c.loop(descriptors(two(m, s))[0])
        h = abs(loop.impulses(loop.noise, loop.direct, 3000)).sum(axis=0)
        true.append(h @ c.readings.steps / 2)
    for k, most in enumerate(np.max(true, axis=0)):
        noise = c.bounds.noise(output=k)
        assert noise.proven is not None
        assert most <= noise.proven < 2 * most


def test_jitter_is_proven_too():
    proof = axis().certify(T=(0.9e-3, 1.1e-3), delay=(0, 0.2e-3), time_limit=60)
    assert proof.proven or proof.failed  # an answer either way, of these clocks
    steady = axis().certify(time_limit=60)
    assert steady.proven and "0.0009" not in steady.claims[0]


def test_the_program_stays_below_its_bounds():
    c = axis().set_point(ramp=6.0).limit(2.0)
    most = c.bounds.ramp(6.0).proven + c.bounds.noise().proven
    run = c.simulate(1.2, r=lambda t: [6.0 if t < 0.5 else -6.0])
    assert abs(run.u).max() <= most and not run.fault.any()
    assert isinstance(Replay(c), Replay)


@pytest.mark.slow
@pytest.mark.parametrize("load", [0.0047, *campaign([None])])
def test_single_precision_stays_within_its_bound(load):
    """Two closed loops without steps of sensors, in both precisions; of all loads in
    the campaign, and in chapter 40.
    """
    c = axis()
    if load:
        c = sos.analyse_pid(drive(load), design().K, [[1, 0]]).controller(
            ["motor"], T=T, delay=T, counts=4096
        )
    c = stepless(c.set_point(ramp=6.0))
    single = c.bounds.rounding("single", range=60.0, speed=6.0)
    count = 1 if load else 2
    ways = [Replay(c, count, kind) for kind in (float, np.float32)]
    runs = [c.simulate(1.0, r=[6.0], program=way) for way in ways]
    off = abs(runs[0].u - runs[1].u).max()
    assert 0 < off < single.proven < 0.1
    double = c.bounds.rounding("double", range=60.0, speed=6.0)
    assert double.proven == pytest.approx(single.proven * 2.0**-29, rel=1e-2)
    with pytest.raises(ValueError, match="precision must be"):
        c.bounds.rounding("half", range=1.0, speed=1.0)


def test_a_bound_in_words_is_no_smaller_than_what_is_proven():
    assert str(Bounded(0.0231449, 0.02, "N m")).startswith("at most 0.02315 N m")
    assert "up to 2.134 rad" in str(Reach(2.1349, 0.9, 1, "rad"))


def test_an_unstable_loop_settles_at_no_time():
    """Its overflow was no number, and counted as within the band after 86.54 s."""
    plant = sos.SecondOrderSystem(0.3, 0.1, 3, 1)
    law = sos.PIDLaw(position=[[1]], filter=0.05, integrate=True)
    gains = {"K_P": [[-32.0]], "K_D": [[-24.0]], "K_I": [[-80.0]]}
    for tick, stable in ((0.04, False), (0.002, True)):
        c = sos.Loop(plant, law, gains).at(tick, delay=tick).controller
        found = c.bounds.step_response()
        several = [found.overshoot, found.settling_time, found.rise_time, found.peak]
        assert (abs(np.linalg.eigvals(c.loops[0].F)).max() < 1) == stable
        for one in (c, sos.Loop(plant, [[-1.0, -5.0 if stable else 5.0]])):
            if stable:
                one.static(w=[])
                continue
            with pytest.raises(ValueError, match="isn't stable"):
                one.static(w=[])
        assert stable == all(x.proven is not None for x in several)
        assert stable == (not any(np.isnan(x.seen) for x in several))
    slow = _Numbers(np.full(9, -0.5), np.full(9, 0.5), 0.0, 1.0, [])
    assert slow.settled(0.02) is None and slow.settled(0.6) == 0
