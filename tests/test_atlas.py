"""Sliders of the rendered page: solved designs, in a browser and in Python."""

import re
from dataclasses import dataclass
from functools import partial

import numpy as np
import pytest

import sosbook as sos
from sosbook.analysis.linear import poles as loop_poles
from sosbook.book.elements.designs import Atlas, Slider, design_atlas
from sosbook.book.elements.records import record
from sosbook.plants.response import simulate
from sosbook.requirements.vocabulary import Parameter
from tests import energy_to_peak
from tests.elements import assert_buttons, first, green, held, say, two_of, write_page

ANGLES = np.radians([30, 45, 60])


@pytest.fixture(scope="module")
def atlas(robot):
    return design_atlas(
        robot.plant,
        robot.U,
        requirements=[robot.saturation],
        gamma=[0.4, 1.257],
        sigma=[0.3, 0.7, 1.3],
        theta=ANGLES,
        rho=[1, 3, 5],
        u_max=[100, 150],
        start={"sigma": 0.7, "rho": 5, "gamma": 1.257, "u_max": 150},
        title="The <robot> & its designs",
        mu=1.0,
    )


@pytest.fixture(scope="module")
def sheet(atlas, tmp_path_factory):
    return two_of(atlas, tmp_path_factory.mktemp("page"))


def request_at(robot, atlas, place):
    """The design at a place of the grid, solved here and now."""
    asked = {s.key: s.values[at] for s, at in zip(atlas.sliders, place)}
    return sos.design_pid(
        robot.plant,
        robot.U,
        region=sos.PoleRegion(asked["sigma"], asked["theta"], asked["rho"]),
        gamma=asked["gamma"],
        saturation=sos.Saturation(asked["u_max"], robot.saturation.x0),
        mu=1.0,
    )


# ------------------------------------------------------------------ in Python
@pytest.mark.slow
def test_what_is_stored_is_what_is_solved(robot, atlas):
    n = 0
    for place in sorted(atlas.designs)[::7]:
        stored = atlas.designs[place]
        if stored == 0:
            continue
        n += 1
        fresh = request_at(robot, atlas, place)
        assert fresh.status == "feasible"
        gain, poles, (block, margin), norm, peak = stored
        assert np.allclose(gain, fresh.K.ravel(), rtol=6e-5)
        upper = fresh.poles()[fresh.poles().imag >= 0]
        assert np.allclose(poles[::2], upper.real, rtol=6e-4)
        assert np.allclose(poles[1::2], upper.imag, rtol=6e-4)
        assert np.isclose(margin, min(fresh.margins.values()), rtol=0.06)
        assert np.isclose(norm, fresh.hinf(), rtol=6e-3)
        assert np.isclose(peak, fresh.peak_input(), rtol=6e-3)
    assert n >= 3


def test_infeasible_is_never_put_where_a_design_exists(robot, atlas):
    """The places that were skipped, because a looser request failed."""
    bad = [place for place, stored in atlas.designs.items() if stored == 0]
    empty = [
        p for p in bad if atlas.sliders[2].values[p[2]] <= atlas.sliders[0].values[p[0]]
    ]
    assert len(bad) > 20 and empty
    for place in sorted(set(bad) - set(empty))[::8]:
        assert request_at(robot, atlas, place).status == "infeasible"


def test_fixed_requirements_are_asked_and_named(robot):
    atlas = design_atlas(robot.plant, robot.U, sigma=[0.5, 0.7], rho=5.0)
    assert atlas.data["also"] == ["ρ = 5 1/s"]
    fresh = sos.design_pid(robot.plant, robot.U, region=sos.PoleRegion(0.7, rho=5))
    assert atlas.designs[(1,)] == record(fresh)
    assert atlas.designs[(1,)][4] is None  # no x(0), so no peak


def test_a_polytope_stores_the_poles_of_every_vertex(robot):
    first = robot.plant
    second = sos.SecondOrderSystem(1.1 * first.M, first.D, first.S, first.B, first.F)
    both = sos.Polytope([first, second])
    atlas = design_atlas(both, robot.U, sigma=[0.3, 0.5], rho=6.0)
    fresh = sos.design_pid(both, robot.U, region=sos.PoleRegion(0.5, rho=6))
    stored = atlas.designs[(1,)]
    assert len(stored[1]) == 2 * (fresh.poles().imag >= 0).sum()
    assert len(atlas.data["vertices"]) == 2
    assert atlas.data["caption"].endswith("every vertex.")


@pytest.mark.parametrize(
    "wrong, words",
    [
        ({}, "nothing to slide"),
        ({"sigma": [0.5, 0.7], "start": {"sigma": 0.6}}, "is not a value"),
        ({"sigma": [0.5, 0.7], "start": {"rho": 5}}, "names no slider"),
        ({"sigma": [0.5, 0.7], "r": [1]}, "r must hold n = 2"),
        ({"u_max": [100, 150]}, "u_max needs saturation"),
    ],
)
def test_bad_input_is_explained(robot, wrong, words):
    with pytest.raises(ValueError, match=words):
        design_atlas(robot.plant, robot.U, **wrong)


def test_a_grid_with_a_hole_is_refused():
    with pytest.raises(ValueError, match="lacks 1 places"):
        Atlas("t", [Slider("rho", (1.0, 2.0))], {(0,): 0}, {})


# -------------------------------------------------------------- in the browser
first, say, held = (partial(f, tag="sos-atlas") for f in (first, say, held))


def numbers(text):
    return [
        float(x)
        for x in re.findall(r"-?\d+(?:\.\d+)?(?:e-?\d+)?", text.replace("−", "-"))
    ]


LABELS = [
    "Decay rate σ",
    "Half-angle θ",
    "Disk radius ρ",
    "H∞ bound γ",
    "Input bound uₘₐₓ",
]


def test_reset_a_link_and_python(tab, visit, robot, atlas):
    names = assert_buttons(tab, visit, "sos-atlas", "Half-angle θ")
    place = [s.values.index(v) for s, v in zip(atlas.sliders, (0.7, ANGLES[2]))]
    fresh = request_at(robot, atlas, (*place, *atlas.start[2:]))
    assert names["design"].status == fresh.status == "feasible"
    assert np.abs(names["design"].K - fresh.K).max() < 1e-9 * np.abs(fresh.K).max()


def test_a_requirement_of_ones_own_is_in_the_program(visit, tmp_path):
    plant = sos.SecondOrderSystem([[1]], [[1]], [[1]], [[1]], [[1]])
    element = design_atlas(
        plant, requirements=[energy_to_peak.EnergyToPeak(0.6)], sigma=0.2,
        slide={"peak": [0.5, 0.6]}, progress=False,
    )  # fmt: skip
    element.data["own"][0]["note"] = "from tests.energy_to_peak import EnergyToPeak"
    page = write_page(tmp_path / "own.html", element.html)
    names = assert_buttons(visit(page), visit, "sos-atlas", "peak")
    asked = {r.name: r for r in names["design"].request.requirements}
    assert asked["peak"].peak == 0.5 and asked["half-plane"].bound == 0.2


@dataclass(frozen=True, eq=False)
class Swing(energy_to_peak.PeakBlocks):
    """A requirement that no file of the package knows, nor any script of the page."""

    swing: float = None

    parameter = Parameter(
        "swing", "bound of the swing", "Swing of <the> arm", "ŝ", " cm", power=2
    )
    kind = name = promise = "swing"

    def claim(self):
        return f"it swings by less than {self.swing!r} cm"

    def truth(self, loops, K, K_A=None):
        return max(energy_to_peak.true_peak(d, K) for d in loops)


def test_a_new_requirement_has_its_slider_from_its_words(visit, tmp_path):
    plant = sos.SecondOrderSystem([[1]], [[1]], [[1]], [[1]], [[1]])
    limit = sos.Saturation(0.3, [0.1, 0])
    element = design_atlas(
        plant, requirements=[limit, Swing(0.6)], mu=1.0, sigma=0.1,
        slide={"swing": [0.01, 0.5, 0.6]}, start={"swing": 0.5}, progress=False,
    )  # fmt: skip
    (slider,) = element.sliders
    assert slider.looser == 1 and slider.texts[1] == "ŝ = 0.5 cm"
    tab = visit(write_page(tmp_path / "swing.html", element.html))
    moved = first(tab).get_by_label("Swing of <the> arm")
    assert moved.get_attribute("aria-valuetext") == "ŝ = 0.5 cm"
    assert say(tab).startswith("Feasible for ŝ = 0.5 cm")
    moved.press("ArrowLeft")
    assert say(tab).startswith("Infeasible for ŝ = 0.01 cm")
    assert "Relax first: ŝ = 0.5 cm." in say(tab)
    assert [good for good, *_ in green(tab, "sos-atlas")[0]] == [False, True, True]
    first(tab).get_by_role("button", name="As Python").click()
    assert "Swing(swing=0.01)" in first(tab).locator("pre").inner_text()
    assert tab.errors == []


def test_bands_are_green_where_a_design_is_stored(tab, atlas):
    for k, stretches in enumerate(green(tab, "sos-atlas")):
        stored = [
            not isinstance(
                atlas.designs[(*atlas.start[:k], at, *atlas.start[k + 1 :])], int
            )
            for at in range(len(atlas.sliders[k].values))
        ]
        assert [good for good, _, _ in stretches] == stored
        assert stretches[0][1] < 0 and stretches[-1][2] > 1


def test_the_page_says_what_was_solved(tab, robot, atlas):
    fresh = request_at(robot, atlas, atlas.start)
    text = say(tab)
    assert text.startswith("Feasible for σ = 0.7 s⁻¹, θ = 45°, ρ = 5 s⁻¹")
    n = robot.plant.n
    shown = numbers(text[text.index("KP") : text.index("Poles")])
    blocks = [fresh.K[:, :n], fresh.K[:, n : 2 * n], fresh.K[:, 2 * n :]]
    gains = np.concatenate([block.ravel() for block in blocks])
    assert np.allclose(shown, gains, rtol=6e-5)
    poles = numbers(text[text.index("Poles") : text.index("Smallest")])
    upper = fresh.poles()[fresh.poles().imag >= 0]
    parts = [x for s in upper for x in ((s.real, s.imag) if s.imag else (s.real,))]
    assert np.allclose(poles, parts, rtol=6e-3)
    least = min(fresh.margins, key=fresh.margins.get)
    assert f"{fresh.margins[least]:.2g}" in text and "uₘₐₓ" in text


def test_the_step_response_is_the_one_of_python(tab, robot, atlas):
    """The page's matrix exponential against `sosbook.plants.response`."""
    code = "return {z: a.response[0], K: a.design.K, T: a.data.horizon};"
    data = held(tab, code=code)
    K, z = np.array(data["K"]), np.array(data["z"])
    t = np.linspace(0, data["T"], len(z))
    request = request_at(robot, atlas, atlas.start).request
    true = simulate(request.vertices[0], K, t, r=np.ones(2))
    assert np.abs(z - true.z.T).max() < 1e-9
    assert np.abs(z[-1] - 1).max() < 0.02
    assert (loop_poles(request.vertices[0], K).real < 0).all()


def test_the_poles_are_drawn_in_the_shaded_region(tab):
    inside = tab.page.evaluate("""() => {
      const atlas = document.querySelector("sos-atlas");
      const area = atlas.querySelector(".sos-region");
      return [...atlas.querySelectorAll(".sos-pole")].map(pole => {
        const box = pole.getBBox(), at = new DOMPoint(
          box.x + box.width / 2, box.y + box.height / 2);
        return area.isPointInFill(at);
      }); }""")
    assert inside == [True] * 6


def test_the_page_says_that_it_has_a_grid_and_why(tab, atlas):
    text = first(tab).inner_text()
    assert f"Solved beforehand at {len(atlas)} positions" in text
    assert "the page's own solver doesn't know" in text


def test_infeasible_is_drawn_and_says_what_to_relax(tab, atlas, robot):
    place = list(atlas.start)
    for label, key in [
        ("Decay rate σ", "End"),
        ("H∞ bound γ", "Home"),
        ("Input bound uₘₐₓ", "Home"),
    ]:
        slider = first(tab).get_by_label(label)
        slider.focus()
        slider.press(key)
        place[LABELS.index(label)] = int(slider.input_value())
    assert request_at(robot, atlas, place).status == "infeasible"
    text = say(tab)
    assert text.startswith("Infeasible for σ = 1.3")
    assert "KP" not in text
    assert first(tab).locator(".sos-pole").count() == 0
    assert first(tab).locator(".sos-map text.sos-no").inner_html() == ("infeasible")
    hatch = first(tab).locator(".sos-region").get_attribute("style")
    name = re.search(r"url\(#(.+?)\)", hatch)[1]
    assert first(tab).locator(f"pattern[id='{name}']").count() == 1
    # Do what the page says: the result must be feasible.
    advice = text[text.index("Relax") :].split(".  ")[0]
    moves = re.split(r"Moving one other", advice)[0]
    for k, slider in enumerate(atlas.sliders):
        for at, words in enumerate(slider.texts):
            words = words.replace("1/s", "s⁻¹").replace("u_max", "uₘₐₓ")
            if re.search(re.escape(words) + r"(?=[.;,]|\s|$)", moves):
                place[k] = at
    assert request_at(robot, atlas, place).status == "feasible"


def test_the_nearest_single_move_is_named_first(tab, atlas):
    """Against the same search in Python, at every infeasible place."""
    places = [p for p, stored in atlas.designs.items() if stored == 0]
    said = tab.page.evaluate(
        """places => {
      const atlas = document.querySelector("sos-atlas");
      return places.map(place => { atlas.place = place; return atlas.advice(); });
    }""",
        [list(place) for place in places],
    )
    single = 0
    for place, words in zip(places, said):
        steps = {}
        for k, slider in enumerate(atlas.sliders):
            for far in range(1, len(slider.values)):
                at = place[k] + far * slider.looser
                goal = (*place[:k], at, *place[k + 1 :])
                if not isinstance(atlas.designs.get(goal, 0), int):
                    steps[slider.texts[at]] = far
                    break
        if not steps:
            assert words.startswith("No ")
            continue
        single += 1
        named = [text for text in steps if f"first: {text}." in words]
        assert len(named) == 1 and steps[named[0]] == min(steps.values())
        assert all(text in words for text in steps)
    assert 5 < single < len(places)


def test_the_shaded_region_is_the_one_asked_for(tab, atlas):
    asked = [s.values[at] for s, at in zip(atlas.sliders, atlas.start)]
    region = sos.PoleRegion(*asked[:3])
    held = tab.page.evaluate("""() => {
      const atlas = document.querySelector("sos-atlas");
      const ticks = [...atlas.querySelectorAll(".sos-map .sos-grid")];
      const area = atlas.querySelector(".sos-region");
      const labels = [...atlas.querySelectorAll(".sos-map text[text-anchor]")];
      const scale = (side, anchor) => {   // two ticks fix the axis
        const lines = ticks.filter(
          line => line.getAttribute(side + "1") === line.getAttribute(side + "2"));
        const values = labels.filter(t => t.getAttribute("text-anchor") === anchor)
          .map(t => Number(t.textContent.replace("−", "-")));
        const at = lines.map(line => Number(line.getAttribute(side + "1")));
        return v => at[0] + (v - values[0]) * (at[1] - at[0]) / (values[1] - values[0]);
      };
      const X = scale("x", "middle"), Y = scale("y", "end"), found = [];
      for (let re = -5.9; re < 0.9; re += 0.4) {
        for (let im = -4.9; im < 5; im += 0.4) {
          found.push([re, im, area.isPointInFill(new DOMPoint(X(re), Y(im)))]);
        }
      }
      return found; }""")
    compared = 0
    for re_, im, inside in held:
        least = min(d.min() for d in region.distances([complex(re_, im)]).values())
        if abs(least) > 0.1:
            compared += 1
            assert inside == (least > 0), (re_, im)
    assert compared > 350
