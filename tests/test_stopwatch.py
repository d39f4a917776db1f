"""The stopwatch for the reader's browser: it moves, measures and says what it saw."""

import re

import numpy as np
import pytest

import sosbook as sos
from sosbook.book.elements.stopwatch import stopwatch
from tests.elements import write_page


@pytest.fixture
def tab(visit, tmp_path):
    tab = visit(write_page(tmp_path / "stopwatch.html", stopwatch([1, 2]).html))
    ready(tab, 1)
    yield tab
    assert tab.errors == []


def ready(tab, vertices):
    tab.page.wait_for_function(
        """count => { const e = document.querySelector("sos-stopwatch");
      return e?.answer?.poles?.length === count; }""",
        arg=vertices,
    )


def test_it_says_the_median_of_what_it_measured_and_puts_the_sliders_back(tab):
    assert "Not measured yet" in tab.page.locator(".sos-told").inner_text()
    before = tab.page.evaluate("document.querySelector('sos-stopwatch').values")
    found = tab.page.evaluate("document.querySelector('sos-stopwatch').measure()")
    assert len(found["times"]) == len(found["solver"]) == 5 * 60
    assert all(0 < s < t for s, t in zip(found["solver"], found["times"], strict=True))
    words = tab.page.locator(".sos-told").inner_text()
    told = [float(x) for x in re.findall(r"([\d.]+) ms", words)]
    true = [np.median(found[key]) for key in ("times", "solver")]
    assert told[:2] == pytest.approx(true, rel=0.1)
    assert tab.page.locator(".sos-dot").count() == 300
    tab.page.wait_for_function(
        """old => { const {values, answer} = document.querySelector("sos-stopwatch");
      return values.every((v, k) => v === old[k] && v === answer.values[k]); }""",
        arg=before,
    )


def test_another_plant_is_the_package_s(tab):
    tab.page.locator("sos-stopwatch select").select_option("1")
    ready(tab, 2)
    example = sos.thesis.example_2()
    K = tab.page.evaluate("document.querySelector('sos-stopwatch').answer.K")
    design = sos.design_pid(example.plant, **example.requirements)
    assert np.abs(K - design.K).max() < 1e-5 * np.abs(design.K).max()


def test_another_plant_ends_a_measurement(tab):
    words = tab.page.evaluate(
        """async () => {
      const e = document.querySelector("sos-stopwatch"), run = e.measure();
      for (let k = 0; k < 8; k++) await new Promise(requestAnimationFrame);
      e.choose(1);
      return [await run, e.view.innerHTML]; }"""
    )
    assert words[0] is None and "NaN" not in words[1]
    ready(tab, 2)
    assert tab.page.get_by_role("button", name="Move every slider").is_enabled()


@pytest.mark.parametrize("examples", [(), (4,), (1, 9)])
def test_examples_that_have_no_stopwatch(examples):
    with pytest.raises(ValueError, match="examples must be some of"):
        stopwatch(examples)
