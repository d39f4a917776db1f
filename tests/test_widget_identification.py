"""The explorer of the identification, against the truth and own fits."""

import re

import numpy as np
import pytest
from sosbook.mip.identify import fit_body, fit_wheel
from sosbook.mip.rig import Rig
from sosbook.widgets import explore_identification

TRUTH = {"e/c": 30.52, "f/c": 7.133, "d/c": 110.6, "e/a": 208.8, "f/a": 48.80}


@pytest.fixture(scope="module")
def explorer():
    return explore_identification()


def rows(page):
    """Estimate, half interval, truth and verdict, by method and ratio."""
    found = re.findall(
        r">(\w+ ./.)</th><td[^>]*>(\S+) ± (\S+)</td><td[^>]*>(\S+)</td>"
        r"<td[^>]*>(\w+)</td>",
        page,
    )
    return {name: (*map(float, numbers), verdict) for name, *numbers, verdict in found}


def first_half(log):
    return log.part(slice(3000))


def drawn(explorer, amplitude=1.85, noise=0.1, friction=0.0, encoder="modelled"):
    """The rows that these values of the sliders lead to."""
    *_, page = explorer.draw(amplitude, noise, friction, encoder)
    return rows(page)


def test_every_ratio_stands_beside_the_truth(explorer):
    shown = rows(explorer.picture.value)
    assert list(shown) == [
        "linear e/c",
        "linear f/c",
        "linear d/c",
        "pendulum e/c",
        "pendulum f/c",
        "pendulum d/c",
        "wheels e/a",
        "wheels f/a",
    ]
    for name, (estimate, half, truth, verdict) in shown.items():
        assert truth == pytest.approx(TRUTH[name[-3:]], rel=1e-4)
        misses = abs(estimate - truth) > half
        assert verdict == ("misses" if misses else "holds")
        assert misses == name.startswith("linear")
    assert "<strong>3 of 8</strong> intervals miss" in (explorer.picture.value)


@pytest.mark.slow
def test_the_numbers_are_the_fits_of_the_rig(explorer):
    shown = drawn(explorer, 0.5, 2.0, 0.1, "plain")
    rig = Rig(amplitude=0.5, noise=np.deg2rad(2.0), friction=0.1)
    body, wheels = first_half(rig.body()), first_half(rig.wheels())
    fits = {
        "linear": fit_body(body, "linear"),
        "pendulum": fit_body(body),
        "wheels": fit_wheel(wheels, 1, "plain"),
    }
    for name, (estimate, half, *_) in shown.items():
        method, ratio = name.split()
        ratio, fit = ratio.replace("/", "_"), fits[method]
        assert estimate == pytest.approx(fit[ratio], rel=1e-4)
        low, high = fit.interval(ratio)
        assert half == pytest.approx((high - low) / 2, rel=0.06)


def test_much_noise_makes_the_linear_fit_honest(explorer):
    shown = drawn(explorer, 0.5, 10.0)
    assert {row[-1] for row in shown.values()} == {"holds"}


def test_plain_differencing_moves_the_wheels_only(explorer):
    before = rows(explorer.picture.value)
    explorer.sliders["encoder"].value = "plain"
    after = rows(explorer.picture.value)
    explorer.sliders["encoder"].value = "modelled"
    assert rows(explorer.picture.value) == before
    for name in before:
        assert (before[name] == after[name]) == (name[:6] != "wheels")
    assert after["wheels f/a"][0] < 0.7 * TRUTH["f/a"]


@pytest.mark.slow
def test_friction_looks_like_damping(explorer):
    explorer.sliders["friction"].value = 0.2
    shown = rows(explorer.picture.value)
    explorer.sliders["friction"].value = 0.0
    for name in ("linear f/c", "pendulum f/c", "wheels f/a"):
        estimate, _, truth, verdict = shown[name]
        assert estimate > 1.15 * truth and verdict == "misses"


def test_it_says_what_it_does_and_has_words(explorer):
    first = next(explorer.draw(1.85, 0.1, 0.0, "modelled"))
    assert "The pendulum is being fitted" in first
    assert "linear e/c" in first and "pendulum e/c" not in first
    page = explorer.picture.value
    assert page.count("<svg role='img' aria-label='") == 2
    assert "role='status'" in page and "scope='row'" in page
    for slider in explorer.sliders.values():
        assert slider.description


@pytest.mark.slow
@pytest.mark.parametrize(
    "amplitude, noise, friction", [(0.25, 10.0, 0.3), (3.0, 0.0, 0.3)]
)
def test_the_corners_of_the_sliders_give_numbers(explorer, amplitude, noise, friction):
    shown = drawn(explorer, amplitude, noise, friction)
    assert len(shown) == 8
    assert np.isfinite([row[:3] for row in shown.values()]).all()
