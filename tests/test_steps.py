"""An answer is looked for by a list of steps: the list runs, the manual shows it, and a
reason says what was tried of it.
"""

import re
from pathlib import Path

import numpy as np
import pytest

import sosbook as sos
from sosbook.synthesis import feasibility, small_input
from sosbook.synthesis.request import Request
from sosbook.synthesis.solution import Solution
from sosbook.synthesis.steps import Step

PAGE = Path(sos.__file__).parents[1] / "book" / "api" / "life_of_a_request.md"
TOO_LITTLE = dict(saturation=sos.Saturation(1e-3, [1, 0]), region=sos.PoleRegion(2))
ARM = sos.SecondOrderSystem(0.3, 0.01, 9.81, 1, 1)


def test_the_manual_shows_the_steps_in_their_order():
    table = PAGE.read_text("utf8").partition("| Step | What it costs")[2]
    rows = re.findall(r"^\| ([^|]+) \| ([^|]+) \|$", table.partition("\n\n")[0], re.M)
    assert rows == [(step.name, step.cost) for step in feasibility.STEPS]


def watched(monkeypatch, tried):
    """The steps, each of which also tells its name where it is tried."""

    def told(step):
        def tries(case):
            tried.append(step.name)
            return step.tries(case)

        return Step(step.name, step.cost, step.applies, tries)

    steps = tuple(map(told, feasibility.STEPS))
    monkeypatch.setattr(feasibility, "STEPS", steps)


@pytest.mark.parametrize(
    "asked, status, last",
    [
        (dict(region=sos.PoleRegion(sigma=0.5)), "feasible", "the centre"),
        (TOO_LITTLE, "infeasible", "multipliers"),
        (
            dict(gain=[[0, 0]], gamma=0.3),
            "infeasible",
            "a response that no input reaches",
        ),
    ],
)
def test_the_first_step_with_an_answer_ends_it(monkeypatch, asked, status, last):
    tried = []
    watched(monkeypatch, tried)
    found = feasibility.answer(Request(ARM, **asked))
    assert (found.status, tried[-1]) == (status, last)
    names = [step.name for step in feasibility.STEPS]
    places, at = [], 0
    for name in tried:
        at = names.index(name, at) + 1
        places.append(at)
    assert places == sorted(places)
    if status == "feasible":  # by the eigenvalues of the loop
        A = [[0, 1], [-9.81 / 0.3, -0.01 / 0.3]] + np.array([[0], [1 / 0.3]]) @ found.K
        assert np.linalg.eigvals(A).real.max() < -0.5


def test_a_step_that_is_put_first_answers_first(monkeypatch):
    mine = Step("a guess", "nothing", lambda case: True, guess)
    monkeypatch.setattr(feasibility, "STEPS", (mine, *feasibility.STEPS))
    assert feasibility.answer(Request(ARM)).reason == "guessed"


def guess(case):
    return Solution(case.request, "undecided", reason="guessed")


def test_an_undecided_reason_says_which_steps_were_tried(monkeypatch):
    monkeypatch.setattr(small_input, "refuse_by_input", lambda *_: None)
    monkeypatch.setattr(feasibility.ScaledLMIs, "refuse", lambda *_: None)
    tried = []
    watched(monkeypatch, tried)
    found = feasibility.answer(Request(ARM, **TOO_LITTLE))
    assert found.status == "undecided" and found.infeasibility is None
    said = found.reason.partition(" Tried: ")[2].removesuffix(".").split(", ")
    assert said == tried and {"a search", "multipliers"} <= set(said)
    less = feasibility.answer(found.request, refuse=False)
    assert less.reason.endswith("isn't asked. Tried: a search.")
