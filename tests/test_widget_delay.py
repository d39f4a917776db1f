"""The delay explorer solves again and holds the truth beside the verdict."""

import re

import numpy as np
import pytest
from sosbook.widgets.delay import (
    OURS,
    PRINTED,
    explore_delay,
    input_figure,
    output_figure,
    simulated,
    truth,
)

import sosbook as sos
from sosbook.book.elements.delay import DELAY_KINDS, signal_of, unit_set_point
from sosbook.delay import (
    ConstantDelay,
    RandomDelay,
    SawtoothDelay,
    SineDelay,
    SwitchingDelay,
)

EXAMPLE = sos.thesis.delay_example_2()
ASKED = dict(tau=0.4, mu=0.2, delta=0.1, alpha=0.8)


@pytest.fixture(scope="module")
def first():
    return explore_delay()


@pytest.fixture
def explorer(first):
    """As it starts: what was solved before is known and costs nothing."""
    for name, value in [
        ("tau", 0.4),
        ("ratio", 0.5),
        ("delta", 0.1),
        ("alpha", 0.8),
        ("gain", OURS),
        ("kind", "sine"),
    ]:
        first.sliders[name].value = value
    return first


def design(**changes):
    return sos.design_delay_pid(EXAMPLE.plant, EXAMPLE.U, **ASKED | changes)


def shown(explorer):
    """The gains in the picture's table."""
    table = re.search(r"<table class='gains'>.*?</table>", explorer.picture.value)
    return [float(x) for x in re.findall(r"'>(-?[\d.e-]+)<", table[0])]


def agrees(explorer, design):
    """Whether the picture shows this design and its true slowest rate."""
    rate, delay = design.slowest_decay()
    return np.allclose(shown(explorer), design.K, rtol=1e-3) and (
        f"is {rate:.3g} 1/s (at {delay:.3g} s)" in explorer.picture.value
    )


def test_it_starts_with_our_design_for_example_2(explorer):
    page = explorer.picture.value
    assert agrees(explorer, design())
    assert "<strong>feasible</strong>" in page
    assert "varies within [0.2, 0.6] s" in page
    assert page.count("<svg role='img'") == 3


@pytest.mark.slow
@pytest.mark.parametrize(
    "name, value, changes",
    [
        ("tau", 0.3, dict(tau=0.3, mu=0.15)),
        ("ratio", 0.25, dict(mu=0.1)),
        ("delta", 0.05, dict(delta=0.05)),
        ("alpha", 1.2, dict(alpha=1.2)),
    ],
)
def test_each_slider_designs_again(explorer, name, value, changes):
    explorer.sliders[name].value = value
    assert agrees(explorer, design(**changes))


def test_the_printed_gains_are_analysed_without_alpha(explorer):
    explorer.sliders["gain"].value = PRINTED
    page = explorer.picture.value
    assert np.allclose(shown(explorer), EXAMPLE.K, rtol=1e-3)
    loop = sos.analyse_delay(EXAMPLE.plant, EXAMPLE.K, EXAMPLE.U, 0.4, 0.2, 0.1)
    assert loop.status == "feasible" and agrees(explorer, loop)
    assert "<strong>feasible</strong>" in page
    explorer.sliders["alpha"].value = 2.0
    assert explorer.picture.value == page


@pytest.mark.slow
def test_no_certificate_does_not_make_the_printed_loop_slower(explorer):
    """At delta = 0.2 Theorem A.3 is silent; the true rate is larger."""
    explorer.sliders["gain"].value = PRINTED
    explorer.sliders["delta"].value = 0.2
    loop = sos.analyse_delay(EXAMPLE.plant, EXAMPLE.K, EXAMPLE.U, 0.4, 0.2, 0.2)
    assert loop.status == "infeasible" and loop.slowest_decay()[0] > 0.2
    assert "<strong>infeasible</strong>" in explorer.picture.value
    assert "doesn't make the loop slower" in explorer.picture.value
    assert agrees(explorer, loop)


@pytest.mark.slow
def test_without_a_design_there_is_no_gain_to_show(explorer):
    explorer.sliders["delta"].value = 0.25
    assert design(delta=0.25).status == "infeasible"
    page = explorer.picture.value
    assert "<strong>infeasible</strong>" in page
    assert "the corrected LMI has no solution" in page
    assert "<table" not in page and page.count("<svg role='img'") == 1


def test_a_constant_delay_is_named_alone(explorer):
    explorer.sliders["ratio"].value = 0.0
    assert "under the delay 0.4 s" in explorer.picture.value
    assert agrees(explorer, design(mu=0.0))


SIGNALS = dict(
    zip(
        DELAY_KINDS,
        (
            ConstantDelay(0.4),
            SineDelay(0.2, 0.6, 2 * np.pi / 4),
            SawtoothDelay(0.2, 0.6),
            SwitchingDelay(0.2, 0.6, 0.8),
            RandomDelay(0.2, 0.6, 0.8, seed=0),
        ),
    )
)


@pytest.mark.slow
@pytest.mark.parametrize("kind", DELAY_KINDS)
def test_the_response_is_that_of_the_delay_named(explorer, kind):
    explorer.sliders["kind"].value = kind
    t = np.linspace(0, 30, 301)
    answer = design().simulate(t, SIGNALS[kind], r=[1, 0])
    assert output_figure(answer, EXAMPLE.U) in explorer.picture.value
    assert input_figure(answer) in explorer.picture.value


@pytest.mark.parametrize("kind", DELAY_KINDS)
def test_every_kind_stays_within_its_interval(kind):
    t = np.linspace(0, 20, 2001)
    d = signal_of(kind, 0.5, 0.3)(t)
    assert 0.2 <= d.min() + 1e-12 and d.max() <= 0.8 + 1e-12
    assert (np.ptp(d) > 0.4) == (kind != "constant")
    assert (signal_of(kind, 0.5, 0.0)(t) == 0.5).all()


def test_an_unknown_kind_is_refused():
    with pytest.raises(ValueError, match="kind must be one of"):
        signal_of("noisy", 0.5, 0.1)


def test_the_set_point_asks_every_integrated_error_for_one():
    U = np.array([[1.0, 0, 0], [0, 1, 1]])
    assert np.allclose(U @ unit_set_point(U), 1)


def test_the_roots_come_before_the_verdict(explorer):
    """What is quick is drawn first."""
    values = {k: s.value for k, s in explorer.sliders.items()}
    pages = explorer.draw(**values | {"gain": PRINTED, "delta": 0.03})
    start, *_, last = pages
    assert "Looking for a certificate" in start
    roots = re.search(r"<svg role='img' aria-label='Rightmost.*?</svg></div>", last)[0]
    assert roots in start and "Response" not in start


def test_the_roots_are_drawn_where_they_are(explorer):
    """Marks of the longest delay against the axis and the line -delta."""
    explorer.sliders["gain"].value = PRINTED
    page = explorer.picture.value
    chart = page[: page.index("Response of z1")]
    lines = re.findall(r"<polyline points='([\d.]+),", chart)
    zero, bound = map(float, lines[:2])  # Re s = 0 and Re s = -0.1
    marks = [float(x) + 4 for x in re.findall(r"<path d='M(-?[\d.]+) ", chart)]
    real = [-0.1 * (x - zero) / (bound - zero) for x in marks]
    loop = sos.delay.delayed_loop(_descriptor(), EXAMPLE.K)
    roots = sos.delay.characteristic_roots(*loop, 0.6, count=8)
    assert np.allclose(real, roots.real, atol=0.002 + 0.01 * abs(roots.real))


def _descriptor():
    return sos.delay.DelayRequest(EXAMPLE.plant, EXAMPLE.U, 0.4).vertices[0]


@pytest.mark.slow
def test_an_unstable_loop_is_called_so_and_drawn_within_bounds(explorer):
    """The printed gains of Example 2 bear delays below 0.9963 s only."""
    explorer.sliders["gain"].value = PRINTED
    explorer.sliders["tau"].value = 1.0
    page = explorer.picture.value
    loop = sos.delay.delayed_loop(_descriptor(), EXAMPLE.K)
    growth = sos.delay.spectral_abscissa(*loop, 1.5)
    assert "<strong>infeasible</strong>" in page
    assert "<strong>unstable</strong> for the constant delay 1.5 s" in page
    assert f"grows at {growth:.3g} 1/s" in page


def test_what_runs_away_is_drawn_as_far_as_numbers_go():
    wild = np.array([[0, 0, 100.0, 0, -1]])
    loop = sos.delay.DelayDesign(
        sos.delay.DelayRequest(EXAMPLE.plant, EXAMPLE.U, 0.01, gain=wild),
        "undecided",
        wild,
    )
    t, late, r = np.linspace(0, 16, 301), ConstantDelay(0.01), [1.0, 0]
    with pytest.raises(ValueError, match="runs away"):
        loop.simulate(t, late, r=r)
    answer = simulated(loop, t, late, r)
    page = output_figure(answer, EXAMPLE.U) + input_figure(answer)
    assert not re.search(r"nan|inf[^e]|\d{9}", page)
    assert "unstable" in truth(loop)


def test_the_way_back_shows_the_first_picture_again(explorer):
    before = explorer.picture.value
    explorer.sliders["gain"].value = PRINTED
    explorer.sliders["gain"].value = OURS
    explorer.sliders["tau"].value = 0.3
    explorer.sliders["tau"].value = 0.4
    assert explorer.picture.value == before
