"""The benchmarks: peers agree, wrong answers are caught, records are tidy."""

import json
from pathlib import Path

import numpy as np
import pytest

import sosbook as sos
from benchmarks import maps, run
from benchmarks.cases import CASES, many_vertices
from benchmarks.cones import Task, compiled
from benchmarks.foreign import foreign
from benchmarks.lqr import LqrTask, pendulum
from benchmarks.measure import FIELDS, Job, record, status, summary, trial
from benchmarks.peers import PEERS
from benchmarks.robustness import SYSTEMS, asked_in_units
from benchmarks.truth import broken, loop, poles

RESULTS = Path(run.__file__).with_name("results.json")
ROBOT = CASES["example 1"].build()


@pytest.mark.parametrize("coordinates", ["raw", "frame"])
@pytest.mark.parametrize("name", ["example 2", "chain 8", "pendulum LQR"])
def test_cone_data_are_the_blocks(name, coordinates):
    case = CASES[name]
    task = case.kind.of(*case.build(), coordinates)
    expressions, unknowns = task.expressions()
    rng = np.random.default_rng(0)
    x = [rng.normal(size=u.size) for u in unknowns]
    values = {u: u.unpack(part) for u, part in zip(unknowns, x)}
    cones = compiled(expressions, unknowns)
    for g, c, A in zip(expressions, cones.constants, cones.matrices):
        true = g.value(values).ravel()
        found = c + A @ np.concatenate(x)
        np.testing.assert_allclose(found, true, atol=1e-9 * abs(true).max())


def test_both_ways_to_cone_data_agree(monkeypatch):
    expressions, unknowns = Task.of(*ROBOT).expressions()
    dense = compiled(expressions, unknowns)
    monkeypatch.setattr("benchmarks.cones.SMALL", 0)
    sparse = compiled(expressions, unknowns)
    for A, B in zip(dense.matrices, sparse.matrices):
        np.testing.assert_allclose(A, B.toarray(), rtol=1e-12, atol=1e-12)
    for a, b in zip(
        dense.scaled().lifted().stacked(_all), sparse.scaled().lifted().stacked(_all)
    ):
        np.testing.assert_allclose(
            *(x if isinstance(x, np.ndarray) else x.toarray() for x in (a, b)),
            atol=1e-12,
        )


def _all(q):
    return np.arange(q * q), np.ones(q * q)


@pytest.mark.slow
@pytest.mark.parametrize("peer", [p for p in PEERS if PEERS[p].feasible])
def test_every_peer_solves_example_1(peer):
    if not PEERS[peer].installed():
        pytest.skip(f"{PEERS[peer].package} is not installed")
    job = Job("example 1", peer, PEERS[peer].coordinates)
    times, judgement = job.run()
    assert status(judgement) == "right"
    assert judgement["margin"] > 1e-3
    assert min(times.values()) > 0


def test_gains_of_all_coordinates_are_the_plants():
    for coordinates in ("raw", "frame"):
        task = Task.of(*ROBOT, coordinates)
        peer = PEERS["clarabel"]()
        K = task.gain(*peer.solve(peer.prepare(task)))
        design = sos.analyse_pid(ROBOT[0], K, **ROBOT[1])
        assert design.status == "feasible"


def test_a_wrong_answer_is_caught():
    task = Task.of(*ROBOT)
    peer = PEERS["sosbook"]()
    framed = Task.of(*ROBOT, "frame")
    P, Y = framed.home(*peer.solve(peer.prepare(framed)))
    assert status(task.judge(P, Y)) == "right"
    assert status(task.judge(P, 0 * Y)) == "wrong"
    assert status(task.judge(-P, Y)) == "wrong"
    harder = Task.of(ROBOT[0], ROBOT[1] | dict(gamma=0.1))
    assert status(harder.judge(P, Y)) == "wrong"


def test_the_lqr_is_judged_by_the_riccati_equation():
    task = LqrTask.of(pendulum())
    peer = PEERS["scipy, Riccati"]()
    P, Y, J = peer.solve(peer.prepare(task))
    # thesis, Table 4.1, R = 1; print was made from rounded matrices
    np.testing.assert_allclose(
        task.gain(P, Y, J), [[38.3431, 1.0001, 4.0221, 1.5153]], rtol=5e-4
    )
    assert status(task.judge(P, Y, J)) == "right"
    assert status(task.judge(P, 1.5 * Y, J)) == "wrong"
    assert status(task.judge(P, 0 * Y, J)) == "wrong"
    assert status(dict(margin=1.0, excess=np.inf)) == "wrong"


def test_the_lqr_lmi_finds_the_riccati_gain():
    _, judgement = Job("pendulum LQR", "sosbook", "frame").run()
    assert status(judgement) == "right"


def test_the_staircase_is_the_map():
    requests = maps.grid(3, 4)
    stairs, solves = maps.staircase(requests)
    cells = maps.one_by_one(requests)
    np.testing.assert_array_equal(stairs, cells)
    assert 0 < cells.sum() < cells.size
    assert solves < cells.size


@pytest.mark.slow
def test_a_trial_tells_time_memory_and_limit():
    job = Job("chain 2", "clarabel", "raw")
    found = trial(job, 60)
    assert found["status"] == "right"
    assert set(found["times"]) == {"end to end", "solve only"}
    assert 10 < found["base_mb"] <= found["peak_mb"]
    assert trial(job, 1e-9) == dict(status="over the limit")


def test_many_vertices_differ_in_stiffness_only():
    plant, _ = many_vertices(4)
    assert len(plant.vertices) == 4
    assert len({v.S.tobytes() for v in plant.vertices}) == 4
    assert len({v.M.tobytes() for v in plant.vertices}) == 1


def test_records_have_the_fields_and_no_others():
    job = Job("example 1", "clarabel", "raw")
    one = dict(
        status="right", times={"solve only": 0.5}, margin=0.1, base_mb=1.0, peak_mb=2.0
    )
    (made,) = run.clocks(job, one, None, job.sizes())
    assert set(made) == set(FIELDS)
    assert (made["n"], made["states"], made["unknowns"]) == (2, 6, 33)
    assert (made["median_s"], made["repeats"]) == (0.5, 1)
    with pytest.raises(ValueError, match="colour"):
        record(colour="red")


def test_a_wrong_answer_has_no_time():
    job = Job("example 1", "scs", "raw")
    one = dict(status="wrong", times={"solve only": 0.5}, margin=-0.1)
    (made,) = run.clocks(job, one, None, job.sizes())
    assert made["status"] == "wrong" and made["median_s"] is None
    assert "after 0.5 s" in made["note"]


def test_growth_is_the_slope_between_40_and_100():
    records = [
        record(
            family="chain",
            case=f"chain {n}",
            n=n,
            competitor="sosbook",
            coordinates="frame",
            clock="solve only",
            status="right",
            **summary([2e-6 * n**3]),
        )
        for n in (20, 40, 100, 200)
    ]
    (one,) = run.growth(records)
    assert (one["from_n"], one["to_n"]) == (40, 100)
    assert one["exponent"] == pytest.approx(3)


@pytest.mark.skipif(not RESULTS.exists(), reason="nothing was measured yet")
def test_the_stored_results_are_consistent():
    document = json.loads(RESULTS.read_text("utf8"))
    assert document["fields"] == FIELDS
    assert {"cpu", "cores", "python", "packages", "date"} <= set(document["machine"])
    assert document["growth"] == run.growth(document["records"])
    for r in document["records"]:
        assert set(r) == set(FIELDS)
        if r["status"] != "right":
            assert r["median_s"] is None and r["ratio"] is None
            continue
        assert 0 < r["min_s"] <= r["median_s"] and r["repeats"] >= 1
        if r["family"] == "lqr":
            assert 0 <= r["excess"] < 1e-3
        elif r["margin"] is not None:
            assert r["margin"] > 0
        else:
            assert r["family"] in ("map", "designs", "slider", "answers")


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(foreign()))
def test_foreign_plants_are_answered_in_all_units(name):
    """The gain is proven, and does in interval arithmetic what was asked."""
    plant, asked = foreign()[name]
    design = sos.design_pid(plant, **asked)
    assert design.status == "feasible" and design.certify().proven
    assert broken(plant, asked, design.K) == []
    assert broken(plant, asked, -design.K)
    there, other = asked_in_units(plant, asked, *SYSTEMS["uN, mm, ms"])
    assert sos.design_pid(there, **other).status == "feasible"


def test_a_loop_is_written_down_twice():
    """The poles of `benchmarks.truth` are those of the package."""
    plant, asked = foreign()["quadrotor"]
    K = sos.design_pid(plant, **asked).K
    A, _ = loop([getattr(plant, name) for name in "MDSBF"], K, asked["U"])
    found = np.array([complex(s.mid()) for s in poles(A)])
    wanted = sos.analyse_pid(plant, K, asked["U"]).poles()
    for s in wanted:
        assert abs(found - s).min() < 1e-9 * abs(s)
