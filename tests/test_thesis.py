"""The thesis's data, and the rows and errata made from it."""

import ast
import re
from pathlib import Path

import numpy as np
import pytest

import sosbook as sos
from sosbook.book import reproduction, thesis

BOOK = Path(__file__).resolve().parent.parent / "book"


def find(rows, item):
    """Of Example 1."""
    (found,) = [
        r for r in rows if r.item.startswith(item) and r.chapter == "07_grasping_robot"
    ]
    return found


def test_every_row_is_complete(rows):
    for r in rows:
        assert r.verdict in reproduction.VERDICTS
        may_lack = ("claim", "tolerance", "assumptions")
        assert all(text for name, text in vars(r).items() if name not in may_lack)
        assert bool(r.tolerance) == (r.kind in ("number", "gains"))
    for names in ({r.id for r in rows}, {(r.chapter, r.item, r.place) for r in rows}):
        assert len(names) == len(rows)


def test_every_erratum_is_complete(errata):
    for e in errata:
        assert all(text for name, text in vars(e).items() if name != "claim")
        assert e.printed != e.correct
        assert e.kind in reproduction.KINDS
    names = [(e.place, e.printed) for e in errata]
    assert len(set(names)) == len(names)


@pytest.mark.skipif(not BOOK.exists(), reason="the package without its book")
def test_chapters_that_rows_and_errata_name_exist(rows, errata):
    for found in {x.chapter for x in (*rows, *errata)}:
        assert list(BOOK.glob(found + ".*")), found


def test_an_unknown_verdict_is_refused():
    with pytest.raises(ValueError, match="unknown verdict"):
        reproduction.Row("a", "b", "c", "d", "e", "perhaps", "f")
    with pytest.raises(ValueError, match="unknown kind"):
        reproduction.Erratum("slip", "a", "b", "c", "d", "e")


def test_verdicts_are_never_typed():
    """Each comes from `claim` and its kin; elsewhere it is compared with."""
    folder = Path(reproduction.__file__).parent
    for module in {*folder.glob("*.py")} - {folder / "table.py"}:
        tree = ast.parse(module.read_text("utf8"))
        compared = {
            part
            for node in ast.walk(tree)
            if isinstance(node, ast.Compare)
            for part in ast.walk(node)
        }
        typed = [
            node.value
            for node in ast.walk(tree)
            if isinstance(node, ast.Constant)
            and node not in compared
            and node.value in tuple(reproduction.VERDICTS)
        ]
        assert not typed, module.name


def half_a_unit(text):
    """Half a unit of the last printed digit."""
    return 0.5 * 10.0 ** -len(text.partition(".")[2])


def test_what_rounding_explains_is_no_misprint(errata):
    """(4.28) has its numbers rounded; (4.29) is a product of them."""

    def ends(text):
        return float(text) - half_a_unit(text), float(text) + half_a_unit(text)

    (low, high), (near, far), (slow, fast) = map(ends, ("188.18", "232.5", "1694"))
    assert low * near / fast < 25.831 < high * far / slow
    assert not [e for e in errata if e.place == "(4.29)"]


def test_numbers_in_the_rows_are_those_of_other_means(rows):
    """The norm by a sweep, the peak by small steps."""
    ex = thesis.example_1()
    d = sos.analyse_pid(ex.plant, ex.K, ex.U)
    loop = d.closed_loop()
    omega = np.linspace(0, 20, 4001)
    answers = loop(1j * omega, squeeze=False)[:2, :2].transpose(2, 0, 1)
    gains = np.linalg.norm(answers, 2, axis=(1, 2))
    printed = float(find(rows, "H-infinity norm").ours)
    assert abs(max(gains) - printed) < 1e-5
    t = np.linspace(0, 20, 20001)
    x = d.simulate(t, x0=ex.saturation.x0).x
    peak = np.linalg.norm(ex.K @ x, axis=0).max()
    ours = re.match(r"[\d.]+", find(rows, "|K x(t)| at most").ours)[0]
    assert abs(peak - float(ours)) < 0.1
