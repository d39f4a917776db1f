"""Changes of the checker by rule, and the judge of whether an input notices them."""

import json

from sosbook.exact.checker import CHECKER
from tests.forged import base
from tests.mutants.changes import mutants
from tests.mutants.judge import Checker, Inputs
from tests.test_every_need import text

SOURCE = '''
LINE = "a: P - 2 Q > 0"
def f(x, y=1):
    """No - 3 change."""
    need(x < y and not x, "a < b")
    return -x + 2
'''


def test_each_sign_number_and_need_is_changed_and_no_words():
    found = [source for _, _, source in mutants(SOURCE)]
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
    for owner, words, changed in mutants(source):
        if "need(...) -> nothing" in words and "a cell is missing" in words:
            assert inputs.notices("known", owner, changed, 60.0) is True
    assert inputs.notices("known", "Known._cells", source, 60.0) is False


def test_a_change_without_an_end_is_noticed():
    source = (CHECKER / "kernel.py").read_text("utf-8")
    endless = source.replace(
        "def holds(", "def holds(*_):\n    while True:\n        pass\n\n\ndef other("
    )
    whole = ("kernel", json.dumps(text("a: 1 > 0")))
    assert Checker().answer(*whole) == ["a"]
    assert Inputs([whole]).notices("kernel", "holds", endless, 0.1) is True


def test_a_change_that_ends_the_program_is_noticed():
    source = (CHECKER / "kernel.py").read_text("utf-8")
    found = [
        x
        for _, words, x in mutants(source)
        if "Eq -> NotEq" in words and "main" in words
    ]
    assert any(Inputs([]).notices("kernel", "module", x, 1.0) for x in found)
