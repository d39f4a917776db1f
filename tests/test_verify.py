"""The benchmark of known gains: its figures are those of its records."""

import json

from benchmarks.verify import TARGET, measured, summary
from benchmarks.verify_plants import FAMILIES


def test_a_family_is_measured():
    case = next(f for f in FAMILIES if f.name == "quarter car")
    decay, norm = (measured(case, what) for what in ("decay", "norm"))
    assert 0.98 <= decay["proven"] < 1 < norm["proven"] <= 1.02
    for record in (decay, norm):
        assert record["held"] and record["broken"]


def test_the_stored_figures():
    stored = json.loads(TARGET.read_text("utf8"))
    assert stored["summary"] == summary(stored["records"])
    assert {r["family"] for r in stored["records"]} == {f.name for f in FAMILIES}
    assert stored["summary"]["proofs that a sample breaks"] == 0
