"""The steps and loads that header, bench and report show: of the machine's own size."""

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm

import sosbook as sos
from sosbook.controllers.facts import ended, facts_of
from sosbook.controllers.trial import FAR, kept, loads_of, steps_of
from tests.axis import axis
from tests.cases import later
from tests.processes import process

T, GAINS = 1e-4, np.array([[-36e3, -25.0, -22e6]])  # A / m, A s / m, A / m s
AMPERES = 5.0
OVERSHOT = re.compile(r"by ([\d.]+) %, asks ([\d.]+)")


def bearing(metre=1.0, ampere=1.0, limit=AMPERES, **more):
    """A magnetic bearing, ``metre`` units long and with an ``ampere`` of so many."""

    def plant(ks):
        push = 200 * metre / ampere
        return sos.SecondOrderSystem(2, 0, -ks, push, F=[[metre]], coordinates=["gap"])

    family = sos.Uncertain(plant, ks=(1e5, 3e5))
    gains = GAINS * ampere / metre
    design = sos.analyse_pid(family, gains, U=[[1]], region=sos.PoleRegion(1))
    c = design.controller(T=T, **more)
    return design, c if limit is None else c.limit(limit * ampere)


def peak(c, d, ticks=2000):
    """The largest |u| of a step of 1 with a plant d: by an expm of its own."""
    N = len(d.E)
    both = np.zeros((N + 1,) * 2)
    both[:N] = np.linalg.solve(d.E, np.hstack([d.A, d.Bu]))
    held, x, memory, most = expm(both * c.T)[:N], np.zeros(N), np.zeros(c.order), 0.0
    r = np.ones(1)
    for _ in range(ticks):
        y = c.readings.rows @ x
        u = c.C @ memory + c.D @ y + c.D_r @ r
        memory = c.A @ memory + c.B @ y + c.B_r @ r
        x, most = held @ np.r_[x, u], max(most, abs(u).max())
    return most


@pytest.mark.parametrize(
    ("metre", "ampere"), [(0.3, 9.81), *later((1, 1), (9.81, 0.3))]
)
def test_a_small_machine_steps_as_far_as_its_current_goes(metre, ampere):
    c = bearing(metre, ampere)[1]
    (trial,) = steps_of(c)
    most = max(peak(c, d) for d in c.vertices)
    assert trial.size == pytest.approx(AMPERES * ampere / most, rel=2e-3)
    assert trial.size / metre < 3e-4 and "proven to stay within the limit" in trial.why
    assert loads_of(c)[0].size == pytest.approx(loads_of(bearing()[1])[0].size, rel=0.1)
    line = facts_of(c, 60.0)[0][2][1][1]
    over, asks = OVERSHOT.search(line).groups()
    first = OVERSHOT.search(facts_of(bearing()[1], 60.0)[0][2][1][1])[1]
    assert float(over) == pytest.approx(float(first), abs=0.2)
    assert (
        0.99 * AMPERES * ampere < float(asks) <= AMPERES * ampere and "no fault" in line
    )


def test_a_proven_step_is_shown_and_is_no_fault():
    """Of a small limit, beside which a ramp is too slow."""
    c = axis().set_point(ramp=25).limit(0.3)
    (trial,) = steps_of(c)
    assert "proven" in trial.why and trial.asks[0].proven <= c.limits.u_max[0]
    run = c.simulate(2.0, r=[trial.size])
    assert not run.fault.any() and abs(run.u).max() < c.limits.u_max[0]
    facts = facts_of(c, 60.0)[0]
    assert facts_of(c, 60.0)[0] is facts  # a report proves no more than a program
    lines = "\n".join(sum((list(x) for _, x in facts), []))
    assert f"a step of {trial.size:.4g} rad of set point of motor" in lines
    assert all(float(x) < 1000 for x in re.findall(r"([\d.e+]+) %", lines))


def test_a_lost_sample_is_simulated_where_it_is_bridged():
    plant = sos.SecondOrderSystem(
        np.diag([0.3, 9.81]), 0.02 * np.eye(2), [[2, -1], [-1.3, 1]], np.eye(2)
    )
    design = sos.design_pid(plant, np.eye(2), region=sos.PoleRegion(0.3, rho=20))
    c = design.controller(T=0.02).limit(1e-3)
    for now, said in ((c, "none is lost here"), (c.watch(lost=0.02), "one of 97 is")):
        first, *steps, _, _ = facts_of(now, 60.0)[0][2][1]
        assert said in first and len(steps) == 2
        assert all(line.endswith("most, no fault") for line in steps)
    assert [trial.size for trial in steps_of(c, [0.1, 0.2])] == [0.1, 0.2]


def test_without_a_limit_the_step_is_1_and_an_asked_one_is_taken():
    c = bearing(limit=None)[1]
    assert steps_of(c)[0].size == 1 and "no output has a limit" in steps_of(c)[0].why
    assert "a step of 1 of set point of gap (no output has" in str(facts_of(c, 60.0)[0])
    assert steps_of(c, 0.02)[0].size == steps_of(c, [0.02])[0].size == 0.02
    for wrong in ([1, 2], 0, -1.0, np.nan):
        with pytest.raises(ValueError, match=r"^step (needs|must)"):
            steps_of(c, wrong)


@pytest.mark.usefixtures("without_bounds")
def test_a_run_ends_where_it_leaves_and_no_overshoot_is_said(tmp_path):
    design, c = bearing(units={"gap": "m", "u": "A"})
    step = 0.02  # far more than 5 A hold
    line = facts_of(c, 60.0, step)[0][2][1][1]
    assert "overshoots" not in line and "NOT AT REST after 0.0" in line
    slower = replace(c, limits=replace(c.limits, ramp=np.array([4.0])))  # 5 ms of it
    line = facts_of(slower, 60.0, step)[0][2][1][1]
    assert "overshoots" not in line and re.search(r"FURTHER .* s \(corner", line)
    run = c.simulate(0.05, r=[step])
    shown = kept(c, run, 0, step)
    for x, count in zip(run.x, shown):
        assert abs(x[: count - 1, 0]).max() <= FAR * step < abs(x[count - 1, 0])
    assert (shown < 500).all() and "FURTHER than 10 times" in ended(c, run, 0, step)
    watched = c.watch(stall=0.002)
    run = watched.simulate(0.05, r=[step])
    assert "FAULTS after 0.00" in ended(watched, run, 0, step)
    assert (run.fault[np.arange(2), kept(watched, run, 0, step) - 1] > 0).all()
    page = design.report(tmp_path, controller=c, step=step).read_text("utf-8")
    assert "A step of 0.02 m of set point of gap (as asked)" in page
    assert "corner 2: ks = 300000" in page and "u (A), limit 5" in page
    assert page.count("time in s</text>") == 4 and page.count("sos-limit") >= 2
    charts = page[page.index("A step of 0.02 m") :]
    far = [float(x) for x in re.findall(r'anchor="end">([^<]+)', charts)]
    assert max(map(abs, far)) < 12  # of 0.2 m, 5 A
    for x, text in re.findall(r'<text x="([\d.]+)"[^>]*middle">([^<]+)', page):
        wide = float(re.search(r'viewBox="0 0 (\d+)', charts)[1])
        assert float(x) + 3.5 * len(text) < wide  # half a text of 12 px


@pytest.mark.slow
def test_its_bench_comes_to_rest(gcc, tmp_path):
    bearing()[1].to_c("axis").write(tmp_path)
    sources = [str(tmp_path / x) for x in ("axis.c", "axis_bench.c")]
    bench = str(tmp_path / "bench")
    for command in ([*gcc, "-O2", "-o", bench, *sources], [bench]):
        done = process(*command, timeout=60)
    rows = done.stdout.splitlines()
    assert len(rows) == 2
    assert all("fault 0" in row and "still" not in row for row in rows)
