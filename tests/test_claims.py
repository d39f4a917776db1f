"""A claim of the thesis has one verdict, in the rows and in the errata."""

import json
import re
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from sosbook.book import reproduction, tables, thesis
from sosbook.book.reproduction.files import files
from sosbook.book.reproduction.table import TEXTS, _assumed, read_texts
from sosbook.plants.descriptor import descriptors
from sosbook.requirements.pole_region import PoleRegion
from tests.values import words

#: What an erratum calls a claim that its rows give a verdict on.
AGREES = {
    "claim refuted": {"claim refuted"},
    "misprint": {"misprint", "single character"},
    "not reproducible": {"gap", "single character"},
}
ROOT = Path(__file__).resolve().parent.parent


@pytest.fixture(scope="module")
def claims(rows):
    """The verdicts of each claim."""
    found = {}
    for row in rows:
        found.setdefault(row.about, set()).add(row.verdict)
    return found


def test_a_claim_has_one_verdict(claims):
    assert {name: x for name, x in claims.items() if len(x) > 1} == {}


def test_rows_and_errata_call_a_claim_alike(claims, errata):
    named = {e.claim: e for e in errata if e.claim}
    assert named.keys() <= claims.keys()
    for name, erratum in named.items():
        (verdict,) = claims[name]
        assert erratum.kind in AGREES[verdict], name


def test_each_misprint_and_refuted_claim_has_its_erratum(rows, errata):
    for row in rows:
        if row.verdict in ("claim refuted", "misprint"):
            assert any(e.claim == row.claim for e in errata), row


def test_each_refuted_claim_of_the_errata_is_computed(claims, errata):
    refuted = [e for e in errata if e.kind == "claim refuted"]
    assert all(e.claim in claims for e in refuted)
    counted = [name for name, verdicts in claims.items() if "claim refuted" in verdicts]
    assert sorted(counted) == sorted(e.claim for e in refuted)


def test_no_two_errata_are_of_one_claim_of_rows(errata):
    named = [e.claim for e in errata if e.claim]
    assert len(named) == len(set(named))


def test_a_single_character_stands_in_one_place(errata):
    """What stands twice, or differs in more, is no slip of a reading machine."""
    for erratum in errata:
        if erratum.kind == "single character":
            assert len(re.findall(r"\(\w\.\d+(?:\.\d)?\)", erratum.place)) <= 1
            assert not re.search("twice|both|three", erratum.evidence, re.I), erratum


def test_no_two_rows_say_the_same(rows):
    tested = [(row.about, row.item, row.ours) for row in rows]
    assert len(tested) == len(set(tested))
    covered = [row for row in rows if "(2.12)" in row.item and "vertices" in row.item]
    assert len(covered) == 1


@pytest.mark.parametrize(
    "name", ["reproduction.csv", "reproduction.json", "readings.csv"]
)
def test_the_page_offers_what_is_computed(rows, errata, name, monkeypatch):
    """Each verdict, each number: also the record of what they were."""
    monkeypatch.setattr("sosbook.book.reproduction.files.rows", lambda: rows)
    monkeypatch.setattr("sosbook.book.reproduction.files.errata", lambda: errata)
    stored = (ROOT / "book" / name).read_text("utf-8")
    assert words.differences(stored, files()[name]) == []


def cells(name):
    """(source, shown table) of each cell of a page that shows one."""
    page = json.loads((ROOT / "book" / f"{name}.ipynb").read_text("utf-8"))
    for cell in page["cells"]:
        for output in cell.get("outputs", ()):
            if "text/html" in output.get("data", ()):
                yield "".join(cell["source"]), "".join(output["data"]["text/html"])


def test_the_rows_are_those_that_the_page_computes(rows):
    """Its cells, which the gate runs, show each of them."""
    shown = set()
    for source, stored in cells("reproduction"):
        if asked := re.match(r'table\("(\w+)", "(.*)"\)$', source):
            some = [row for row in rows if row.chapter == asked[1]]
            found = tables.reproduction(some, asked[2])
            shown.add(asked[1])
        elif source.endswith("tables.verdicts(rows)"):
            assert "rows = reproduction.rows()\n" in source
            found = tables.verdicts(rows)
        else:
            continue
        assert words.differences(stored, found._repr_html_()) == [], source
    assert shown == {row.chapter for row in rows}


def test_the_errata_are_those_that_their_page_computes(errata):
    """And have the texts of their table, with some words."""
    shown = dict(cells("errata"))
    (kinds,) = (x for source, x in shown.items() if source.endswith("kinds(errata)"))
    (every,) = (x for source, x in shown.items() if source == "tables.errata(errata)")
    assert any("errata = reproduction.errata()\n" in source for source in shown)
    assert words.differences(kinds, tables.kinds(errata)._repr_html_()) == []
    assert words.differences(every, tables.errata(errata)._repr_html_()) == []
    for entry, erratum in zip(read_texts("corrections")["errata"], errata, strict=True):
        for name, text in entry.items():
            assert filled(text, getattr(erratum, name)), erratum


def written(entry, row):
    """Whether a row has the texts of an entry of ``rows.toml``, with some words."""
    texts = {"claim": ""} | {name: entry[name] for name in TEXTS if name in entry}
    if row.verdict in ("claim refuted", "not reproducible"):
        texts["ours"] = entry.get("otherwise", texts.get("ours", "{ours}"))
    form = re.sub(r"[^\w.{}-]+", "-", texts.pop("id")).strip("-")
    within = ""
    if "tolerance" in entry:
        within = f"{entry['tolerance']:g} {entry.get('unit', '')}".strip()
    return (
        all(filled(text, getattr(row, name)) for name, text in texts.items())
        and filled(form, row.id)
        and row.kind == entry["kind"]
        and row.tolerance == (entry.get("within") or within)
        and row.assumptions == (entry.get("assumptions") or _assumed(row.place))
    )


def filled(form, text):
    """Whether a text is a form with words in its braces."""
    parts = re.split(r"\{[^{}]*\}", form)
    return re.fullmatch(".*".join(map(re.escape, parts)), text, re.DOTALL) is not None


def test_the_rows_have_the_texts_of_their_table(rows):
    entries = read_texts("rows")["rows"]
    used = [[written(entry, row) for row in rows] for entry in entries]
    for k, row in enumerate(rows):
        assert any(of[k] for of in used), row
    assert [entry["id"] for entry, of in zip(entries, used) if not any(of)] == []


def test_a_reading_decides_rows_that_exist_and_names_their_numbers(rows):
    known = {row.id: row for row in rows}
    assert len(reproduction.readings()) == 12
    for reading in reproduction.readings():
        decided = [known[name] for name in reading["decides"]]
        texts = " ".join(f"{r.printed} {r.ours} {r.why}" for r in decided)
        for number in re.findall(r"\d+\.\d+(?= ?kN|:)", reading["then"]):
            assert number in texts, (reading["place"], number)


def test_a_row_says_what_its_figure_is_redrawn_with(rows):
    """Each row of a motion; poles, masses and transfer functions assume nothing."""
    still = {"3.1", "3.5", "3.10", "3.14", "4.7", "4.12"}
    for row in rows:
        shown = set(re.findall(r"\d\.\d+", row.place)) if "Fig" in row.place else set()
        assert bool(row.assumptions) == bool(shown - still - {"4.3", "4.23", "4.24"}), (
            row
        )


def test_the_paper_counts_what_there_is(rows, claims, errata):
    text = (ROOT / "paper" / "paper.md").read_text("utf-8")
    count = Counter(verdict for (verdict,) in claims.values())
    for number, what in (
        (len(rows), r"rows about"),
        (len(claims), r"printed numbers"),
        (len(claims), r"claims"),
        (len(errata), "corrections with"),
        (count["reproduced"], "are numbers"),
        (count["property holds"], "are properties"),
        (count["another solution"], "are gains"),
        (count["misprint"], "are misprints"),
        (count["claim refuted"], "are refuted"),
        (count["not reproducible"], "can't be told"),
    ):
        assert re.search(rf"\b{number} {what}", text), (number, what)
    cited = set(re.findall(r"@(\w+)", text))
    there = re.findall(
        r"^@\w+\{(\w+)", (ROOT / "paper/paper.bib").read_text("utf-8"), re.M
    )
    assert cited == set(there)


def test_the_script_for_matlab_asks_what_example_4_asks():
    """Its data are the thesis's, and its terms add up to (2.18) to (2.20)."""
    script, ex = (ROOT / "book" / "feasp_test.m").read_text("utf-8"), thesis.example_4()
    assert re.search(r"printed = \[(.*)\]", script)[1].split() == [
        f"{k:.4f}" for k in ex.K[0]
    ]
    data = {x: re.search(rf"\b{x} = ([^;]+);", script)[1] for x in ("sigma", "rho")}
    assert data == {"sigma": "5", "rho": "15"} and "theta = pi/3" in script
    assert str(ex.region) == str(PoleRegion(sigma=5, theta=np.pi / 3, rho=15))
    assert "{[51 -50; -50 50], [50+2/pi -50; -50 50]}" in script
    (d, _), rng = descriptors(ex.plant, ex.U), np.random.default_rng(0)
    P, Y = rng.normal(size=(5, 5)), rng.normal(size=(1, 5))
    P, s, c = P + P.T, np.sin(np.pi / 3), np.cos(np.pi / 3)
    names = {"s": s, "c": c, "sigma": 5, "rho": 15}
    names |= {"E": np.matrix(d.E), "A": np.matrix(d.A), "B": np.matrix(d.Bu)}
    asked = {}
    term = r"lmiterm\(\[(\w+) (\d) (\d) (-?\w)\], ([^,]+), ([^,)]+)(, 's')?\);"
    for name, i, j, unknown, left, right, twice in re.findall(term, script):
        left, right = (eval(x.replace("'", ".T"), names) for x in (left, right))
        block = left @ {"P": P, "Y": Y, "-Y": Y.T}[unknown] @ right
        asked.setdefault((name, i, j), np.zeros((5, 5)))
        asked[name, i, j] += np.asarray(block + block.T if twice else block)
    N, EPE = (d.A @ P + d.Bu @ Y) @ d.E.T, d.E @ P @ d.E.T
    twice = N + N.T
    wanted = {("half", "1", "1"): twice + 2 * 5 * EPE, ("disk", "1", "2"): N}
    wanted |= {("disk", k, k): -15 * EPE for k in "12"}
    wanted |= {("sector", k, k): s * twice for k in "12"}
    wanted["sector", "1", "2"] = c * (N - N.T)
    assert asked.keys() == wanted.keys()
    for key, block in wanted.items():
        np.testing.assert_allclose(asked[key], block, atol=1e-12)
