"""Changes of the checker by rule, and the judge of whether an input notices them."""

import ast
import json
from itertools import count

import pytest

from sosbook.book.elements.scripts import script
from sosbook.exact.checker import CHECKER
from tests.forged import base
from tests.mutants import __main__ as command
from tests.mutants import page
from tests.mutants.changes import mutants
from tests.mutants.judge import Checker, Inputs
from tests.mutants.lists import WHY, listed
from tests.test_every_need import text

SOURCE = '''
LINE = "a: P - 2 Q > 0"
def f(x, y=1):
    """No - 3 change."""
    need(x < y and not x, "a < b")
    return -x + 2
'''


def test_each_sign_number_and_need_is_changed_and_no_words():
    found = [ast.unparse(tree) for *_, tree in mutants(SOURCE)]
    for part in (
        *("need(True)", "x <= y", "or not x", "and x", "return x + 2", "-x - 2"),
        *("-x + 3", "y=2", "P + 2 Q", "P - 3 Q", "> 1"),
    ):
        assert sum(part in x for x in found) == 1, part
    assert all("No - 3 change" in x for x in found)
    assert len(found) == len({*found}) == 11


def test_a_checker_without_a_need_is_noticed_by_the_file_that_it_refuses():
    cut = base("known gain, in a simplex")
    (name, kind, cuts) = cut["cells"][0]
    less = cut | {"cells": [[name, kind, cuts[:-1]]]}
    inputs = Inputs([("asked", json.dumps(x)) for x in (cut, less)])
    source = (CHECKER / "known.py").read_text("utf-8")
    for owner, words, *change in mutants(source):
        if "need(...) -> nothing" in words and "a cell is missing" in words:
            assert inputs.notices("known", owner, *change, 60.0) is True
    assert inputs.notices("known", "Known._cells", (), source, 60.0) is False


def test_each_input_enters_what_a_cache_kept_of_another():
    whole = "asked", json.dumps(base("a mode beside a sector"))
    assert {*Inputs([whole, whole]).near("regions", "tangent", ())} == {0, 1}


def test_a_change_without_an_end_is_noticed():
    source = (CHECKER / "kernel.py").read_text("utf-8")
    endless = source.replace(
        "def holds(", "def holds(*_):\n    while True:\n        pass\n\n\ndef other("
    )
    whole = ("kernel", json.dumps(text("a: 1 > 0")))
    assert Checker().answer(*whole) == ["a"]
    assert Inputs([whole]).notices("kernel", "holds", (), endless, 0.1) is True


def test_a_change_that_ends_the_program_is_noticed():
    source = (CHECKER / "kernel.py").read_text("utf-8")
    found = [
        change
        for _, words, *change in mutants(source)
        if "Eq -> NotEq" in words and "main" in words
    ]
    assert any(Inputs([]).notices("kernel", "module", *x, 1.0) for x in found)


def test_the_survivors_without_a_word_may_only_become_fewer():
    why = [*listed(command.LIST).values(), *listed(page.LIST).values()]
    assert {x.partition(":")[0] for x in why} <= WHY - {""}


def test_an_input_is_asked_where_it_enters_the_changed_line():
    """The first statement refuses both; only one of them gets to the second."""
    texts = [text("a: x > 0", data={"x": x}) for x in ("1", "2 3")]
    inputs = Inputs([("kernel", json.dumps(x)) for x in texts])
    source = (CHECKER / "arithmetic.py").read_text("utf-8")
    here = {words.split(" in ")[1][:40]: lines for owner, words, lines, _
            in mutants(source) if owner == "number"}  # fmt: skip
    asked = [inputs.near("arithmetic", "number", x) for x in here.values()]
    assert {*map(len, asked)} == {1, 2}


@pytest.fixture
def three(tmp_path, monkeypatch):
    """A run of the command on three functions, each with a change that survives."""

    class NoInputs:
        all = ()

        def __init__(self, kept):
            """There are none."""

        def notices(self, name, owner, lines, tree, most):
            return tree == "dies"

    every = {
        f"kernel f{k} {k}": {f"f{k} {x}": ((), x) for x in ("lives", "dies")}
        for k in range(3)
    }
    (tmp_path / "inputs").write_text("[]", "utf-8")
    monkeypatch.setattr(command, "functions", lambda: every)
    monkeypatch.setattr(command, "Inputs", NoInputs)
    for name, file in dict(KEPT="inputs", LIST="list", ASKED="asked").items():
        monkeypatch.setattr(command, name, tmp_path / file)
    return lambda *words: command.main(["--again", *words])


def test_what_was_never_asked_is_no_survivor_that_the_list_lacks(
    three, tmp_path, monkeypatch, capsys
):
    """A run ends where its time does, and the next goes on there."""
    assert three() == command.NOT_ASKED
    assert "SURVIVES, NOT ASKED BEFORE: f1 lives" in capsys.readouterr().out
    with monkeypatch.context() as hurried:
        ticks = count()
        hurried.setattr(command.time, "process_time", lambda: next(ticks))
        assert three("--write", "--seconds", "3") == command.NOT_ASKED
    found, asked = tmp_path / "list", tmp_path / "asked"
    assert len(asked.read_text("utf-8").splitlines()) == 1
    assert three("--write") == three() == 0
    assert found.read_text("utf-8").split("\n") == [f"f{k} lives" for k in range(3)] + [
        ""
    ]
    found.write_text("f1 lives  # words\nf2 dies\nf9 was\n", "utf-8")
    capsys.readouterr()
    assert three() == command.SURVIVES
    said = capsys.readouterr().out
    assert "SURVIVES: f0 lives" in said and "NOTICED NOW" in said and "f2 dies" in said
    assert three("--write") == three() == 0
    assert "f1 lives  # words" in found.read_text("utf-8").splitlines()


def test_each_sign_and_number_of_a_page_s_script_is_changed_and_no_words():
    """Of what stands in templates, too; not of words, comments and expressions."""
    text = r"""const f = x => `a - ${x - 1} 1` + (x < 2n ? -x : !y); // 3 - 4
      /a-1/.test("1 - 2") || odd("1"); s.every(g) / 2; throw new Error("-");"""
    found = [(text[a:b], other) for a, b, other in page.changes(text)]
    assert found == [
        *(("-", "+"), ("1", "2"), ("+", "-"), ("<", "<="), ("2n", "3n"), ("-", " ")),
        *(("!", " "), ("||", "&&"), ("odd", "(() => null)"), ("every", "some")),
        *(("2", "3"), ("throw", "void")),
    ]


def test_a_page_s_reader_is_changed_as_pages_have_it():
    """To the letter, but for its data; each change is in a module that decides."""
    text, places = page.body()
    whole = script("kernel")
    parts = {x: page.plain(text[a:b]).strip() for x, (a, b) in places.items()}
    assert all(part in whole for x, part in parts.items() if x != "text")
    _, every = page.mutants()
    assert {x.split()[0] for x in every} == {*page.DECIDE}
    for line, (owner, begin, end, _) in every.items():
        first, last = places[owner.split()[0]]
        assert first <= begin < end <= last and f": {text[begin:end]} -> " in line


def test_a_change_of_the_page_s_reader_is_noticed_or_survives(monkeypatch):
    monkeypatch.setattr(page, "JUDGE", page.JUDGE.replace("+ 5000", "+ 300"))  # ms
    source = page.COUNTER + page.counted("""return {counter, coupledPairs: n => {
      for (let k = 0; k < n; k += 1) if (k > 8) return "many"; return "few"; }};""")
    at = {x: (x, source.index(x), source.index(x) + len(x)) for x in ("> 8", "+= 1")}
    at["1"] = "1", at["+= 1"][1] + 3, at["+= 1"][2]
    judge = page.Judge(source, at, [["pairs", 3], ["pairs", 20]])
    assert judge.answers == ['"few"', '"many"']
    assert judge.survives(*at["> 8"], ">= 8") == 2
    assert judge.survives(*at["> 8"], "> 30") == -1
    _, begin, end = at["+= 1"]  # a number isn't added to a large integer
    assert judge.survives("n", begin, end, "+= 1") == 2
    assert judge.survives("n", begin + 3, end, "1n") == -1
    assert judge.survives(*at["> 8"], "> > 8") == -1
    assert judge.survives(*at["+= 1"], "+= 0") == -1  # it has no end
    assert judge.survives(*at["> 8"], ">= 8") == 2
    judge.close()
