"""The benchmarks: peers agree, wrong answers are caught, records are tidy."""

import json
import math
from itertools import product
from pathlib import Path

import flint
import numpy as np
import pytest

import sosbook as sos
from benchmarks import ablation, clock, maps, masses, run, waiting
from benchmarks.catalogue import FAMILIES, case
from benchmarks.clock import Job, trial
from benchmarks.competitors import COMPETITORS, Competitor
from benchmarks.cones import compiled
from benchmarks.foreign import foreign
from benchmarks.questions import Lqr, NoAnswer, Pid, right
from benchmarks.records import FIELDS
from benchmarks.robustness import SYSTEMS, asked_in_units
from benchmarks.truth import broken, poles
from sosbook.book import thesis
from sosbook.book.plots import profiles
from tests.cases import by_turns, crossed, later

HOME = Path(run.__file__).parent
PROFILE, WAITING = HOME / "profile.json", HOME / "waiting.json"
EXAMPLE = thesis.example_1()
ROBOT = EXAMPLE.plant, {k: v for k, v in EXAMPLE.requirements.items() if v is not None}


@pytest.mark.parametrize("framed", [False, True])
@pytest.mark.parametrize("name", ["grid", "tree", "pendulums", "delayed modes"])
def test_cone_data_are_the_blocks(name, framed):
    expressions, unknowns = case(name, FAMILIES[name].sizes[0], framed).expressions()
    rng = np.random.default_rng(0)
    x = [rng.normal(size=u.size) for u in unknowns]
    values = {u: u.unpack(part) for u, part in zip(unknowns, x)}
    cones = compiled(expressions, unknowns)
    for g, c, A in zip(expressions, cones.constants, cones.matrices):
        true = g.value(values).ravel()
        found = c + A @ np.concatenate(x)
        np.testing.assert_allclose(found, true, atol=1e-9 * abs(true).max())


@pytest.mark.slow
@pytest.mark.parametrize(
    "name, kind",
    [
        *crossed(COMPETITORS, ["grid", "delayed chain"]),
        *later(*product(COMPETITORS, ["tree", "pendulums", "observed beam"])),
    ],
)
def test_every_competitor_solves_every_kind(name, kind):
    if not COMPETITORS[name].installed():
        pytest.skip(f"{COMPETITORS[name].package} is not installed")
    times, judgement = Job(kind, FAMILIES[kind].sizes[0], name).run(framed=True)
    assert right(judgement) and all(whole > data >= 0 for whole, data in times)


def test_sosbook_is_not_timed_on_lmis_that_others_are_asked():
    question, _ = COMPETITORS["sosbook"]().answer(lambda: Pid(*ROBOT, True))
    assert "request" not in vars(question) and "lmis" not in vars(question)


@pytest.mark.parametrize("framed", [False, True])
def test_gains_of_all_coordinates_are_the_plants(framed):
    question, answer = COMPETITORS["clarabel"]().answer(lambda: Pid(*ROBOT, framed))
    assert right(question.judge(answer))
    K = np.linalg.solve(answer["P"], answer["Y"].T).T
    assert sos.analyse_pid(ROBOT[0], K, **ROBOT[1]).status == "feasible"
    harder = Pid(ROBOT[0], ROBOT[1] | dict(gamma=0.1))
    assert not right(harder.judge(answer))


def test_the_lqr_is_judged_by_the_riccati_equation():
    p = thesis.mip()  # (4.25), vertex 1; print has D and S on the right-hand side
    plant = sos.SecondOrderSystem(p.M[0], -p.D[0], -p.S[0], p.B[0], p.F)
    question = Lqr(plant, {})
    K = question.design()["K"]
    # thesis, Table 4.1, R = 1; print was made from rounded matrices
    np.testing.assert_allclose(K, [[38.3431, 1.0001, 4.0221, 1.5153]], rtol=5e-4)
    assert right(question.judge(dict(K=K)))
    assert not right(question.judge(dict(K=1.5 * K)))
    assert question.judge(dict(K=0 * K))["excess"] == np.inf


def test_a_profile_by_hand():
    """Two competitors and three cases, the last of which nobody solves."""
    seconds = {
        ("a", 2): {"sosbook": 1.0, "x": 2.0},
        ("a", 4): {"sosbook": 6.0, "x": 4.0},
        ("b", 2): {"sosbook": math.inf, "x": math.inf},
        ("b", 4): {"sosbook": 1.0, "x": math.inf},
    }
    found = profiles.ratios(seconds)
    assert found == {
        "sosbook": [1.0, 1.5, math.inf, 1.0],
        "x": [2.0, 1.0, math.inf, math.inf],
    }
    shares = [profiles.share(found["sosbook"], tau) for tau in (1, 1.2, 1.5, 1e9)]
    assert shares == [0.5, 0.5, 0.75, 0.75]
    assert [profiles.share(found["x"], tau) for tau in (1, 2)] == [0.25, 0.5]
    assert profiles.faster(seconds) == [(("a", 4), "x", 1.5)]
    seconds["b", 2]["x"] = 1.0
    assert profiles.faster(seconds)[0] == (("b", 2), "x", math.inf)
    assert profiles.speedup(seconds, 2, "x") == 1.0  # of 2 and 0: ours has no answer
    assert profiles.speedup(seconds, 4, "x") == math.inf  # of 2 / 3 and infinity
    seconds["c", 4] = {"sosbook": 1.0, "x": 5.0}
    assert profiles.speedup(seconds, 4, "x") == 5.0
    assert profiles.speedup(seconds, 8, "x") is None
    assert profiles.uphill({2: 1.0, 3: 3.0, 5: 2.0}) == (1.5, 3, 5)
    assert profiles.power({10: 2.0, 100: 200.0}, 10, 100) == pytest.approx(2)


class Failing(Competitor):
    name = package = "sosbook"

    def __init__(self, error):
        self.error = error

    def ready(self, make):
        raise self.error


@pytest.mark.parametrize("error", [NoAnswer("none"), ValueError("odd"), MemoryError()])
def test_a_failing_competitor_counts(monkeypatch, error):
    monkeypatch.setitem(clock.COMPETITORS, "clarabel", lambda: Failing(error))
    found = clock._tried(Job("free chain", 2, "clarabel"), False)
    assert found["status"] == "no answer"
    known = dict(family="free chain", size=2, cpu_s=None)
    rows = [
        known | dict(competitor="sosbook", status="right", cpu_s=1.0),
        known | dict(competitor="clarabel") | found,
    ]
    ratios = profiles.ratios(profiles.times(rows))
    assert ratios == {"sosbook": [1.0], "clarabel": [math.inf]}


class Wrong(Competitor):
    def ready(self, make):
        question, answer = COMPETITORS["sosbook"]().answer(make)
        return lambda: (question, answer | dict(P=-answer["P"]))


def test_a_wrong_answer_has_no_time_that_counts(monkeypatch):
    monkeypatch.setitem(clock.COMPETITORS, "clarabel", Wrong)
    found = clock._tried(Job("free chain", 2, "clarabel"), True)
    assert found["status"] == "wrong" and found["margin"] < 0
    row = dict(family="f", size=2, competitor="clarabel") | found
    assert profiles.times([row]) == {("f", 2): {"clarabel": math.inf}}


@pytest.mark.parametrize(
    "step, steady", crossed([1e-6, 1e-4, 0.004, 0.01], [True, False])
)
@pytest.mark.parametrize("price", [0.0013, 0.0071, 0.09])
def test_a_clock_with_ticks_tells_the_time_of_a_short_call(
    monkeypatch, step, price, steady
):
    """Linux may count in ticks of 4 ms, and once more after another process."""
    spent, known = 0.0, []

    def ticking():
        nonlocal spent
        spent += 1e-7  # of the question itself
        ticks = math.floor(spent / step)
        late = not steady and spent - step * ticks > 1e-3 * step
        return step * (ticks + 1e-3 * late)

    class Priced(Competitor):
        def ready(self, make):
            nonlocal spent
            spent += price / 4
            if not known:  # it is one question, however often it is asked
                known.append(COMPETITORS["sosbook"]().answer(make))
            return self.paid

        def paid(self):
            nonlocal spent
            spent += 3 * price / 4
            return known[0]

    monkeypatch.setattr(clock, "cpu", ticking)
    clock.tick.cache_clear()
    monkeypatch.setitem(clock.COMPETITORS, "clarabel", Priced)
    try:
        found = clock._tried(Job("free chain", 2, "clarabel"), True)
    finally:
        clock.tick.cache_clear()
    assert found["status"] == "right"
    assert found["cpu_s"] == pytest.approx(price, rel=2 / clock.TICKS)
    assert found["data_s"] == pytest.approx(price / 4, abs=2 * price / clock.TICKS)


@pytest.mark.slow
def test_a_trial_has_a_limit():
    late = trial(Job("free chain", 24, "cvxpy + clarabel", 0.5))
    assert late["status"] == "over the limit"


def test_who_was_over_the_limit_is_not_asked_again(monkeypatch):
    monkeypatch.setattr(Competitor, "installed", classmethod(lambda c: True))

    def asked(competitor, last, family="grid", size=8):
        return run.not_tried(family, size, competitor, last, 20.0)

    over = 4, dict(status="over the limit")
    slow, quick = (
        (4, dict(status="right", cpu_s=2.0)),
        (4, dict(cpu_s=0.5, status="right")),
    )
    assert asked("clarabel", None) is None
    assert asked("clarabel", over)["status"] == "not tried"
    assert "32 s" in asked("clarabel", slow)["why"]  # 2 s times 2^4
    assert asked("scs", slow) is asked("clarabel", quick) is None
    assert asked("sosbook", slow) is None  # we are always asked
    assert (
        asked("clarabel", over, "foreign") is None
    )  # one has nothing to do with another
    assert asked("clarabel", slow, "bicycles") is None  # of vertices it is linear


def test_the_staircase_is_the_map():
    requests = maps.grid(2, 3)
    stairs, solves = maps.staircase(requests)
    cells = maps.one_by_one(requests)
    np.testing.assert_array_equal(stairs, cells)
    assert 0 < cells.sum() < cells.size and solves > 0
    assert maps.naive(requests[0][0]) and not maps.naive(requests[-1][-1])
    flat = [r for row in requests for r in row]
    found = maps.designs(flat[0].plant, map(maps.keywords, flat), progress=False)
    assert [d.status == "feasible" for d in found] == cells.ravel().tolist()


@pytest.mark.slow
@pytest.mark.skipif(not PROFILE.exists(), reason="nothing was measured yet")
def test_the_quick_run_is_a_document():
    """It tells time and memory, and keeps the records of what wasn't asked."""
    old = json.loads(PROFILE.read_text("utf-8"))
    found = run.measure(["free chain"], ["clarabel"], old=old, quick=True)
    _check_profile(json.loads(json.dumps(found, allow_nan=False)))
    known = [json.dumps(r) for r in old["records"]]
    fresh = {r["size"]: r for r in found["records"] if json.dumps(r) not in known}
    assert fresh.keys() == {2, 4} and len(found["records"]) >= len(known)
    assert {(r["family"], r["competitor"]) for r in fresh.values()} == {
        ("free chain", "clarabel")
    }
    assert fresh[2]["status"] == "right" and fresh[2]["coordinates"] == "raw"
    assert 10 < fresh[2]["base_mb"]


@pytest.mark.skipif(not PROFILE.exists(), reason="nothing was measured yet")
def test_the_stored_profile_is_consistent():
    document = json.loads(PROFILE.read_text("utf-8"))
    _check_profile(document)
    assert set(document["families"]) == set(FAMILIES)
    for name, family in FAMILIES.items():
        kept = document["families"][name]
        assert kept["half"] == family.half and tuple(kept["sizes"]) == family.sizes


#: This edition, and the name that it had before it was released.
EDITION = {"1.0.0", "0.3.0.dev0"}


@pytest.mark.parametrize("name", ["ablation", "profile", "structures", "waiting"])
def test_what_chapter_18_shows_was_measured_with_this_edition(name):
    machine = json.loads((HOME / f"{name}.json").read_text("utf-8"))["machine"]
    assert {machine["packages"]["sosbook"], sos.__version__} <= EDITION


def _check_profile(document):
    assert document["fields"] == run.FIELDS
    assert {"cpu", "cores", "python", "packages", "date"} <= set(document["machine"])
    for r in document["records"]:
        assert set(r) == set(run.FIELDS)
        if r["status"] != "right":
            assert r["why"] or r["status"] == "not installed"
            continue
        assert r["cpu_s"] > 0 and r["calls"] >= 1
        assert 0 < r["base_mb"] <= r["peak_mb"]
        if r["excess"] is None:
            assert r["margin"] > 1e-9
        else:
            assert 0 <= r["excess"] < 1e-3


def test_chains_are_left_out_whose_forces_stand_in_nodes():
    """The modes of equal masses in a row are cosines."""
    for n in range(2, 25):
        forced = np.flatnonzero(masses.spread_over(n).any(axis=1))
        shapes = np.cos(np.outer(forced + 0.5, np.arange(n)) * np.pi / n)
        reached = abs(shapes).max(axis=0).min() > 1e-9
        assert reached == (n in run.SECTIONS["monotony"]["free chain"]), n


def test_what_one_waits_for_is_consistent():
    document = json.loads(WAITING.read_text("utf-8"))
    assert document["fields"] == FIELDS
    known = {family for families in waiting.PARTS.values() for family in families}
    for r in document["records"]:
        assert set(r) == set(FIELDS) and r["family"] in known
        assert r["status"] == "right" and 0 < r["min_s"] <= r["median_s"]


@pytest.mark.slow
@pytest.mark.parametrize("name", by_turns(sorted(foreign()), 0, of=3))
def test_foreign_plants_are_answered_in_all_units(name):
    """The gain is proven, and does in interval arithmetic what was asked."""
    plant, asked = foreign()[name]
    design = sos.design_pid(plant, **asked)
    assert design.status == "feasible" and design.certify().proven
    assert broken(plant, asked, design.K) == []
    assert broken(plant, asked, -design.K)
    there, other = asked_in_units(plant, asked, *SYSTEMS["uN, mm, ms"])
    assert sos.design_pid(there, **other).status == "feasible"


def test_poles_far_apart_have_finite_balls():
    """300 bits don't enclose the eigenvalues of this companion matrix."""
    big = flint.fmpq(10)
    A = flint.fmpq_mat([[0, 1, 0], [0, 0, 1], [-(big**100), -(big**90), -(big**60)]])
    assert all(s.is_finite() for s in poles(A))


def test_every_path_can_be_switched_off_and_changes_no_verdict():
    for path in ablation.PATHS:
        with ablation.without(path):
            found = sos.design_pid(ROBOT[0], **ROBOT[1])
        assert found.status == "feasible", path


def test_the_rule_of_an_ablation_by_hand():
    def record(family, size, ratio, verdicts=None):
        times = dict(with_s=1.0, without_s=ratio, verdicts=verdicts, gain=0.0)
        return dict(path="p", family=family, size=size) | times

    records = [record("a", 1, 1.0), record("a", 2, 4.0), record("b", 1, 1.0)]
    found = ablation.summary("p", records + [record(ablation.RANDOM, 0, 9.0)])
    assert (found["worst"], found["where"], found["stays"]) == (2.0, "a", True)
    assert not ablation.summary("p", records[::2])["stays"]
    differs = record("b", 2, 1.0, ["feasible", "undecided"])
    assert ablation.summary("p", [records[0], differs])["stays"]


def test_the_stored_ablation_has_all_paths():
    stored = json.loads(ablation.RESULTS.read_text("utf-8"))
    assert set(ablation.PATHS) <= set(stored["paths"])
    assert stored == ablation.told(stored)
    assert all(r.keys() == stored["fields"].keys() for r in stored["records"])
    stays = [p for p in ablation.PATHS if p not in ablation.KEPT]
    assert all(ablation.summary(p, stored["records"])["stays"] for p in stays)
