"""Random requests of known verdict: no wrong answer, all of them backed."""

import doctest
import signal
import time
from functools import cache

import numpy as np
import pytest

from benchmarks import plants
from benchmarks.robustness import SYSTEMS, Row, at_most, cpu_time_limits, judge, summary
from sosbook.runtime.time_limit import OutOfTime, check_time, time_limit
from sosbook.synthesis.proofs import prove
from sosbook.synthesis.request import Request
from tests.attacks import attack
from tests.cases import campaign
from tests.random_plants import ROUNDED, random_case

pytestmark = pytest.mark.slow
LARGEST = 4  # degrees of freedom; the benchmark goes to 8
SEEDS = range(28)


@cache
def known(seed):
    return random_case(seed, LARGEST)


@pytest.mark.parametrize("seed", [*range(4), *campaign(range(4, 84))])
def test_the_answer_is_right_and_backed(seed):
    """Certified, excluded exactly or undecided: never wrong, nor without a proof."""
    case = known(seed)
    row = judge(case)
    assert not row.wrong, case.reason
    if row.verdict != "undecided":
        assert row.proven
    elif case.verdict == "feasible":  # a gain exists by rounding errors only
        assert ROUNDED in case.reason


@pytest.mark.parametrize("seed", [*range(2), *campaign(range(2, 12))])
def test_an_attack_never_finds_a_false_refusal(seed):
    """The gain exists, in exact arithmetic; its proof may be beyond floats."""
    case = attack(seed)
    row = judge(case, systems=SYSTEMS)
    assert row.verdict in ("feasible", "undecided"), case.reason
    assert set(row.elsewhere) <= {"feasible", "undecided"}, case.reason


@pytest.mark.parametrize("seed", [0, *campaign([12, 24, 36, 48, 60, 72])])
def test_no_units_contradict_each_other(seed):
    assert not judge(known(seed), systems=SYSTEMS).contradicted


@pytest.mark.parametrize("seed", [*range(0, 77, 7), *campaign([77])])
def test_a_witness_is_a_proof(seed):
    """What is called feasible by construction is, without a solver."""
    case = known(seed)
    if case.verdict == "infeasible":
        assert case.witness is None
        return
    if case.witness is None:  # a mode just inside, or Riccati's
        assert "out of reach" in case.reason
        return
    request = Request(case.plant, **case.requirements)
    assert prove(request, *case.witness, 17).proven


@pytest.mark.campaign
def test_the_seeds_cover_what_they_should():
    cases = [known(seed) for seed in SEEDS]
    asked = [c.requirements for c in cases]
    for name in ("U", "gamma", "region", "saturation", "K_A"):
        assert 0 < sum(name in a for a in asked) < len(cases)
    vertices = {len(c.plant.vertices) for c in cases}
    assert vertices == {1, 2, 3, 4}
    uncertain = [
        c
        for c in cases
        if len(c.plant.vertices) > 1
        and not np.array_equal(c.plant.vertices[0].M, c.plant.vertices[1].M)
    ]
    assert uncertain
    rates = [c.units.w0 for c in cases]
    assert min(rates) < 1e-5
    assert max(rates) > 1e5
    marginal = [c.verdict for c in cases if c.kind == "marginal"]
    assert {"feasible", "infeasible"} == set(marginal)


def test_the_summary_counts_what_is_wrong():
    def row(seed, known, verdict, backing, seconds=0.1, reason="", elsewhere=()):
        found = seed, "feasible", known, reason, 2, 1, 1, verdict, backing, seconds
        return Row(*found, elsewhere=elsewhere)

    found = summary(
        [
            row(1, "feasible", "feasible", "6 digits"),
            row(2, "feasible", "infeasible", "none"),
            row(3, "infeasible", "feasible", "none", 3.0),
            row(4, "infeasible", "feasible", "12 digits"),
            row(5, "feasible", "undecided", "none"),
            row(6, "feasible", "error: ValueError: x", "none"),
            row(7, "feasible", "feasible", "6 digits", elsewhere=("undecided",)),
            row(
                8,
                "feasible",
                "undecided",
                "none",
                reason="a mode out of reach" + ROUNDED,
                elsewhere=("feasible",),
            ),
        ]
    )
    assert found["wrong"] == {
        "feasible, called infeasible": [2],
        "infeasible, called feasible": [3],
    }
    assert found["known verdict disproven"] == [4]
    assert found["undecided"] == [5, 8]
    assert found["undecided share"] == 2 / 8
    assert found["undecided share, not by rounding"] == 1 / 7
    assert found["by rounding"] == {"undecided": 1}
    assert found["units"]["another verdict"] == [7]
    assert found["units"]["another verdict, by rounding"] == [8]
    assert list(found["errors"]) == ["6"]
    assert found["feasible, not certified"] == [3]
    assert found["seconds"]["above 2 s"] == [3]


def _busy(seconds):
    end = time.process_time() + seconds
    while time.process_time() < end:
        check_time()


def test_limits_count_the_seconds_of_this_process():
    with cpu_time_limits(), time_limit(0.1):
        time.sleep(0.2)
        check_time()
        with pytest.raises(OutOfTime):
            _busy(0.5)


@pytest.mark.skipif(not hasattr(signal, "SIGPROF"), reason="no such signal")
def test_an_answer_that_takes_too_long_is_an_error():
    with at_most(0.1):
        time.sleep(0.2)
    with at_most(0.1), pytest.raises(TimeoutError, match="no answer in 0.1 CPU s"):
        _busy(0.5)


def test_chain_needs_two_masses():
    with pytest.raises(ValueError, match="n = 1 must be 2 or more"):
        plants.chain(1)


def test_the_wing_flutters():
    """NLEVP's wing: one pair right of the axis, 0.0947 +- 2.5229i."""
    poles = plants.wing()[0].poles()
    unstable = poles[poles.real > 0]
    assert np.allclose(
        np.sort_complex(unstable), [0.0947 - 2.5229j, 0.0947 + 2.5229j], atol=1e-4
    )


def test_the_examples_of_the_plants():
    assert doctest.testmod(plants).failed == 0
