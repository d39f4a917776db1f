"""Sliders for delays in the rendered page: real solutions, true responses."""

import re
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

import sosbook as sos
from sosbook.book import thesis
from sosbook.book.elements.delay import DELAY_KINDS, delay_atlas
from sosbook.book.elements.records import delay_record
from sosbook.delay import (
    ConstantDelay,
    RandomDelay,
    SawtoothDelay,
    SineDelay,
    SwitchingDelay,
    characteristic_roots,
    delayed_loop,
    simulate_delay,
)
from tests.elements import assert_buttons, first, green, held, say, two_of, write_page

EXAMPLE = thesis.delay_example_2()
GRID = dict(taus=[0.2, 0.4], ratios=[0, 0.5], deltas=[0.1, 0.2])
START = dict(tau=0.4, ratio=0.5, delta=0.1)
#: The delay of each kind that the page computes, from tau and its interval.
SIGNALS = {
    "constant": lambda tau, low, high: ConstantDelay(tau),
    "sine": lambda tau, low, high: SineDelay(low, high, 2 * np.pi / (10 * tau)),
    "sawtooth (sample and hold)": lambda tau, low, high: SawtoothDelay(low, high),
    "switching": lambda tau, low, high: SwitchingDelay(low, high, 2 * tau),
    "random": lambda tau, low, high: RandomDelay(low, high, 2 * tau, 0),
}


@pytest.fixture(scope="module")
def atlas():
    return delay_atlas(EXAMPLE, **GRID, start=START, horizon=15, title="Late & <bold>")


@pytest.fixture(scope="module")
def sheet(atlas, tmp_path_factory):
    return two_of(atlas, tmp_path_factory.mktemp("page"))


def numbers(text):
    return [
        float(x)
        for x in re.findall(r"-?\d+(?:\.\d+)?(?:e-?\d+)?", text.replace("−", "-"))
    ]


def asked_at(atlas, place):
    return {s.key: s.values[at] for s, at in zip(atlas.sliders, place)}


def design_at(atlas, place):
    """The design at a place of the grid, solved here and now."""
    asked = asked_at(atlas, place)
    return sos.design_delay_pid(
        EXAMPLE.plant,
        EXAMPLE.U,
        asked["tau"],
        asked["ratio"] * asked["tau"],
        asked["delta"],
        alpha=asked.get("alpha", EXAMPLE.alpha),
    )


# ------------------------------------------------------------------ in Python


@pytest.mark.slow
def test_what_is_stored_is_what_is_solved(atlas):
    assert len(atlas) == 8
    for place, stored in [*atlas.designs.items()][1::3]:
        fresh = design_at(atlas, place)
        assert (stored == 0) == (fresh.status == "infeasible")
        if stored == 0:
            continue
        assert fresh.status == "feasible" and fresh.certify().proven
        gain, (_, margin), slowest, roots = stored
        assert np.allclose(gain, fresh.K.ravel(), rtol=6e-4)
        assert np.isclose(margin, min(fresh.margins.values()), rtol=0.06)
        assert np.allclose(slowest, fresh.slowest_decay(), rtol=6e-3)
        tau, mu = fresh.request.tau, fresh.request.mu
        for delay, row in zip((tau - mu, tau, tau + mu), roots):
            true = fresh.roots(delay)
            true = true[true.imag >= 0]
            assert np.allclose(row[::2], true.real, rtol=6e-3)
            assert np.allclose(row[1::2], true.imag, rtol=6e-3)


def test_the_grid_has_both_verdicts(atlas):
    held = [not isinstance(d, int) for d in atlas.designs.values()]
    assert 4 <= sum(held) < 8
    assert repr(atlas) == (
        f"DelayAtlas: 8 requests solved, {sum(held)} feasible, {8 - sum(held)} not"
    )


def test_an_undecided_request_is_not_called_infeasible():
    request = sos.delay.DelayRequest(EXAMPLE.plant, EXAMPLE.U, 0.4)
    assert delay_record(sos.delay.DelayDesign(request, "undecided")) == 1
    assert delay_record(sos.delay.DelayDesign(request, "infeasible")) == 0


def test_alpha_is_a_slider_where_it_is_given():
    atlas = delay_atlas(EXAMPLE, [0.4], [0.25], [0.1], [0.4, 1.2])
    assert atlas.sliders[3].texts == ["α = 0.4 s", "α = 1.2 s"]
    assert atlas.data["also"] == []
    for place in [(0, 0, 0, 0), (0, 0, 0, 1)]:
        assert atlas.designs[place] == delay_record(design_at(atlas, place))
    assert atlas.designs[0, 0, 0, 0] != atlas.designs[0, 0, 0, 1]


def test_the_output_is_small(atlas):
    """Two hundred designs have room in a page."""
    data = re.search(r'<script type="application/json">(.*?)</script>', atlas.html)[1]
    assert len(atlas.light) + 200 * len(data) / len(atlas) < 110_000


@pytest.mark.parametrize(
    "wrong, words",
    [
        (dict(ratios=[0.5, 1.5]), "ratios are mu / tau"),
        (dict(deltas=[]), "deltas is empty"),
        (dict(start=dict(tau=0.3)), "is not a value"),
        (dict(start=dict(alpha=0.8)), "names no slider"),
        (dict(horizon=1e4), "horizon = 1e\\+04 s takes"),
    ],
)
def test_bad_input_is_explained(wrong, words):
    with pytest.raises(ValueError, match=words):
        delay_atlas(EXAMPLE, **GRID | wrong)


# -------------------------------------------------------------- in the browser

KIND = "How the delay varies"


first, say, held = (partial(f, tag="sos-delay") for f in (first, say, held))


def test_the_page_says_what_was_solved(tab, atlas):
    fresh, text = design_at(atlas, atlas.start), say(tab)
    assert text.startswith("Feasible: the delay stays in [0.2, 0.6] s.")
    assert "τ = 0.4 s that varies by 0.5 of itself" in first(tab).get_attribute(
        "aria-label"
    )
    shown = numbers(text[text.index("KP") : text.index("Promised")])
    assert np.allclose(shown, fresh.K.ravel(), rtol=6e-4)
    rate, delay = fresh.slowest_decay()
    assert "Promised rate, however the delay varies: 0.1 s⁻¹." in text
    assert f"delays: {rate:.3g} s⁻¹, at {delay:.3g} s." in text


def test_the_page_says_that_it_has_a_grid_and_where_designs_are(tab, atlas):
    assert "Solved beforehand at 8 positions" in first(tab).inner_text()
    for k, slider in enumerate(atlas.sliders):
        stretches = green(tab, "sos-delay", slider.key)
        stored = [
            not isinstance(
                atlas.designs[(*atlas.start[:k], at, *atlas.start[k + 1 :])], int
            )
            for at in range(len(atlas.sliders[k].values))
        ]
        last = len(stored) - 1
        for at, known in enumerate(stored):
            assert known in [g for g, a, b in stretches if a <= at / last <= b]
        assert sum(g != h for g, h in zip(stored, stored[1:])) == len(stretches) - 1


def test_reset_a_link_and_python(tab, visit, atlas):
    kind = first(tab).get_by_label(KIND)
    kind.select_option("3")
    first(tab).get_by_role("button", name="Link to this").click()
    again = visit(tab.page.url)
    assert first(again).get_by_label(KIND).input_value() == "3"
    first(tab).get_by_role("button", name="Reset").click()
    assert kind.input_value() == "0"
    design = assert_buttons(tab, visit, "sos-delay", "Decay rate δ")["design"]
    fresh = design_at(atlas, (1, 1, 1))
    assert design.status == fresh.status
    assert (design.request.mu, design.request.delta) == (0.2, 0.2)


def compared(tab, example, kind, K, tau, mu):
    """Largest differences of page and Python, at every eighth instant.

    Of the output, of u as asked, and of u as it arrives the mean one: it
    jumps, and a jump early or late is a large difference for a moment.
    """
    first(tab).get_by_label(KIND).select_option(kind)
    answer = held(
        tab,
        code="""
      const pick = name => a.response[name].filter((_, k) => k % 8 === 0);
      return Object.fromEntries(
        ["t", "z", "asked", "applied"].map(name => [name, pick(name)]));""",
    )
    d = sos.delay.DelayRequest(example.plant, example.U, tau).vertices[0]
    true = simulate_delay(
        d,
        K,
        answer["t"],
        SIGNALS[kind](tau, tau - mu, tau + mu),
        r=np.linalg.pinv(example.U) @ np.ones(len(example.U)),
    )
    z, asked, applied = (np.array(answer[k]).T for k in ("z", "asked", "applied"))
    return [
        abs(z - example.U @ true.z).max(),
        abs(asked - true.u).max(),
        abs(applied - true.applied).mean(),
    ]


def test_the_response_is_the_one_of_python(tab, atlas):
    """Runge-Kutta in the page against the exponential integrator."""
    K = np.reshape(atlas.designs[tuple(atlas.start)][0], (1, 5))
    for kind in DELAY_KINDS:
        z, asked, applied = compared(tab, EXAMPLE, kind, K, 0.4, 0.2)
        assert z < 2e-3 and asked < 4e-3 and applied < 4e-3, kind
        assert abs(held(tab, code="return a.response.z.at(-1)[0];") - 1) < 0.02, kind


def test_two_inputs_and_two_outputs_without_the_least_delay(visit, tmp_path):
    """mu = tau: the delay passes through zero."""
    both = replace(
        EXAMPLE,
        U=np.eye(2),
        plant=sos.SecondOrderSystem(
            EXAMPLE.plant.M, EXAMPLE.plant.D, EXAMPLE.plant.S, np.eye(2)
        ),
    )
    atlas = delay_atlas(both, [0.1], [1.0], [0.2], horizon=15)
    K = np.reshape(atlas.designs[0, 0, 0][0], (2, 6))
    tab = visit(write_page(tmp_path / "two.html", atlas.html))
    for kind in ("sine", "sawtooth (sample and hold)"):
        z, asked, applied = compared(tab, both, kind, K, 0.1, 0.1)
        assert z < 4e-3 and asked < 0.01 * abs(K).max()
        assert applied < 0.01 * abs(K).max()
    assert tab.errors == []
    assert first(tab).locator(".sos-step .sos-line").count() == 2
    assert first(tab).locator(".sos-input .sos-line").count() == 4


def test_a_varying_delay_changes_the_picture_not_the_verdict(tab):
    text, seen = say(tab), set()
    for kind in DELAY_KINDS:
        first(tab).get_by_label(KIND).select_option(kind)
        seen.add(first(tab).locator(".sos-input").inner_html())
        assert say(tab) == text
    assert len(seen) == len(DELAY_KINDS)


def test_the_roots_are_drawn_where_they_are(tab, atlas):
    """Crosses of the longest delay, by the axes' own ticks."""
    at = held(
        tab,
        code="""
      const texts = [...a.querySelectorAll(".sos-map text")];
      const scale = anchor => {
        const side = anchor === "middle" ? "x" : "y";
        const all = texts.filter(t => t.getAttribute("text-anchor") === anchor
          && t.hasAttribute(side) && Number.isFinite(value(t))).slice(0, 2);
        const [p, q] = all.map(t => Number(t.getAttribute(side)));
        const [v, w] = all.map(value);
        const shift = side === "y" ? 4 : 0;
        return u => v + (u - p + shift) * (w - v) / (q - p);
      };
      function value(t) { return Number(t.textContent.replace("−", "-")); }
      const X = scale("middle"), Y = scale("end");
      return [...a.querySelectorAll(".sos-map .sos-pole")].map(root => {
        const [x, y] = root.getAttribute("transform").match(/[-.\\d]+/g).map(Number);
        return [root.getAttribute("style"), X(x), Y(y)]; });""",
    )
    found = np.array([x + 1j * y for style, x, y in at if "second" in style])
    K = np.reshape(atlas.designs[tuple(atlas.start)][0], (1, 5))
    d = sos.delay.DelayRequest(EXAMPLE.plant, EXAMPLE.U, 0.4).vertices[0]
    roots = characteristic_roots(*delayed_loop(d, K), 0.6)
    left = atlas.data["window"][0]
    assert len(found) >= 4
    for root in found:
        assert abs(roots - root).min() < 0.03
    for root in roots[:4]:
        assert root.real < left or abs(found - root).min() < 0.03


def test_infeasible_is_drawn_and_says_what_helps(tab, atlas):
    first(tab).get_by_role("spinbutton", name="Decay rate δ").fill("0.2")
    assert atlas.designs[1, 1, 1] == 0
    text = say(tab)
    assert text.startswith("Infeasible: the delay stays in [0.2, 0.6] s.")
    assert "No certificate: the corrected LMI has no solution" in text
    assert "KP" not in text
    assert first(tab).locator(".sos-map .sos-pole, .sos-line").count() == 0
    assert first(tab).locator("text.sos-no").count() == 3
    helps = {
        slider.texts[0].replace("1/s", "s⁻¹")
        for k, slider in enumerate(atlas.sliders)
        if atlas.designs[tuple(0 if j == k else 1 for j in range(3))] != 0
    }
    named = re.search(r"leads to a design: (.*)\.", text)[1].split("; or ")
    assert set(named) == helps and helps


def test_undecided_is_said(visit, atlas, tmp_path):
    doubt = type(atlas)(
        "t",
        atlas.sliders,
        dict.fromkeys(atlas.designs, 1),
        atlas.data | {"designs": None},
        atlas.start,
    )
    tab = visit(write_page(tmp_path / "doubt.html", doubt.html))
    assert say(tab).startswith("Undecided")
    assert "nor a proof that there is none" in say(tab)
    assert "No move of a single number" in say(tab)
    assert tab.errors == []
