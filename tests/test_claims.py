"""A claim of the thesis has one verdict, in the rows and in the errata."""

import re

import pytest

from sosbook import reproduction

#: What an erratum calls a claim that its rows give a verdict on.
AGREES = {
    "claim refuted": {"claim refuted"},
    "misprint": {"misprint", "single character"},
    "not reproducible": {"gap", "single character"},
}
ERRATA = {e.claim: e for e in reproduction.errata() if e.claim}


@pytest.fixture(scope="module")
def claims(rows):
    """The verdicts of each claim."""
    found = {}
    for row in rows:
        found.setdefault(row.about, set()).add(row.verdict)
    return found


def test_a_claim_has_one_verdict(claims):
    assert {name: x for name, x in claims.items() if len(x) > 1} == {}


def test_rows_and_errata_call_a_claim_alike(claims):
    assert ERRATA.keys() <= claims.keys()
    for name, erratum in ERRATA.items():
        (verdict,) = claims[name]
        assert erratum.kind in AGREES[verdict], name


def test_each_misprint_and_refuted_claim_has_its_erratum(rows):
    for row in rows:
        if row.verdict in ("claim refuted", "misprint"):
            assert row.claim in ERRATA, row


def test_each_refuted_claim_of_the_errata_is_computed(claims):
    refuted = [e for e in reproduction.errata() if e.kind == "claim refuted"]
    assert all(e.claim in claims for e in refuted)
    counted = [name for name, verdicts in claims.items() if "claim refuted" in verdicts]
    assert sorted(counted) == sorted(e.claim for e in refuted)


def test_no_two_errata_are_of_one_claim_of_rows():
    named = [e.claim for e in reproduction.errata() if e.claim]
    assert len(named) == len(set(named))


def test_a_single_character_stands_in_one_place():
    """What stands twice, or differs in more, is no slip of a reading machine."""
    for erratum in reproduction.errata():
        if erratum.kind == "single character":
            assert len(re.findall(r"\(\w\.\d+(?:\.\d)?\)", erratum.place)) <= 1
            assert not re.search("twice|both|three", erratum.evidence, re.I), erratum


def test_no_two_rows_say_the_same(rows):
    tested = [(row.about, row.item, row.ours) for row in rows]
    assert len(tested) == len(set(tested))
    covered = [row for row in rows if "(2.12)" in row.item and "vertices" in row.item]
    assert len(covered) == 1
