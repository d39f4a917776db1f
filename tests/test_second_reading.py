"""The thesis's numbers, typed a second time, and what follows with numpy alone."""

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from sosbook.book import thesis
from tests.processes import process

FILE = Path(__file__).resolve().parent.parent / "book/second_reading.py"
pytestmark = pytest.mark.skipif(
    not FILE.exists(), reason="the package without its book"
)


@pytest.fixture(scope="module")
def second():
    spec = importlib.util.spec_from_file_location("second_reading", FILE)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_what_follows_from_them_alone():
    """In an interpreter of its own, which sees neither the package nor SciPy."""
    program = (
        "import sys; sys.modules.update(scipy=None, sosbook=None, control=None); "
        f"import runpy; runpy.run_path({str(FILE)!r}, run_name='__main__')"
    )
    done = process(sys.executable, "-c", program)
    lines = done.stdout.splitlines()
    assert done.returncode == 0, done.stdout + done.stderr
    assert len(lines) > 20 and all(line.startswith("ok ") for line in lines)


def test_a_mistyped_digit_is_noticed(second, monkeypatch):
    monkeypatch.setitem(second.PD, 1, [38.4331, 1.0001, 4.0221, 1.5153])
    assert second.main() == 1


@pytest.mark.parametrize(
    "table, example",
    [("Table 3.1", "example_1"), ("Table 3.2", "example_3"), ("Table 3.3", None)],
)
def test_the_examples_are_those_of_the_book(second, table, example):
    """Both typings of chapter 3, entry by entry."""
    mine = [x for name, x in second.EXAMPLES.items() if name.startswith(table)]
    theirs = getattr(thesis, example or "example_4")()
    vertices = getattr(theirs.plant, "vertices", [theirs.plant])
    poles = [
        np.atleast_2d(getattr(theirs, kind + "_loop_poles"))
        for kind in ("open", "closed")
    ]
    for k, (M, D, S, B, U, K_A, K, *printed) in enumerate(mine):
        v = vertices[k]
        for one, other in ((M, v.M), (D, v.D), (S, v.S), (B, v.B)):
            assert_array_equal(one, other)
        assert_array_equal(U, theirs.U)
        assert_array_equal(K, theirs.K)
        if theirs.K_A is not None:
            assert_array_equal(K_A, theirs.K_A)
        for own, found in zip(printed, poles):
            upper = np.sort_complex([p for p in found[k] if p.imag >= 0])
            assert_array_equal(np.sort_complex(own), upper)
    assert len(mine) == len(vertices)


def test_the_pendulum_is_that_of_the_book(second):
    """Both typings of chapter 4, entry by entry."""
    mip = thesis.mip()
    assert second.BODY == mip.body
    assert -second.GAIN == mip.ratios["e_c"]
    assert_array_equal(second.M, mip.M[:, 0, 0])
    assert_array_equal(second.D, mip.D)
    assert_array_equal(second.S, mip.S[:, :, 0])
    assert_array_equal(second.B, mip.B[:, :, 0])
    letters = second.LETTERS
    assert [letters[x] for x in "bcd"] == [mip.letters[x] for x in "bcd"]
    assert letters["a"] == mip.letters["a"][0]
    assert list(letters["e"]) == mip.letters["e"]
    for mine, theirs in ((second.PD, mip.pd), (second.PID, mip.pid)):
        assert {R: list(K[0]) for R, K in theirs.items()} == mine
    assert {R: list(K[0]) for R, (K, _) in mip.lqe.items()} == second.LQE
    assert_array_equal(second.L_2, mip.lqe[2][1])
    assert (second.FULL, second.LESS) == (mip.controller, mip.reduced)
    for mine, theirs in zip(
        (second.A_D, second.B_D, second.C_D, second.D_D), mip.discrete
    ):
        assert_array_equal(mine, theirs)
