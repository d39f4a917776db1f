"""Sliders that the reader's browser solves, against the package."""

import re
from functools import partial

import numpy as np
import pytest

import sosbook as sos
from sosbook.__main__ import main
from sosbook.analysis.linear import hinf_norm, peak_input
from sosbook.book import thesis
from sosbook.book.elements.explorer import design_explorer
from sosbook.plants.response import simulate
from sosbook.synthesis.proofs import DesignProof
from tests.elements import assert_quiet, first, middle, say, two_of, write_page

LABELS = {
    "sigma": "Decay rate σ",
    "theta": "Half-angle θ",
    "rho": "Disk radius ρ",
    "gamma": "H∞ bound γ",
    "u_max": "Input bound uₘₐₓ",
}


@pytest.fixture(scope="module")
def explorer(robot):
    return design_explorer(
        robot.plant,
        robot.U,
        (0.3, 4),
        robot.saturation,
        sigma=(0.1, 2.5),
        theta=np.radians([15, 90]),
        rho=(1.5, 12),
        u_max=(40, 400),
        start={"sigma": 0.7, "theta": np.pi / 4, "rho": 5, "gamma": 1.257,
               "u_max": 150},
        title="The <robot> & its designs",
    )  # fmt: skip


@pytest.fixture(scope="module")
def sheet(explorer, tmp_path_factory):
    return two_of(explorer, tmp_path_factory.mktemp("page"))


@pytest.fixture
def tab(visit, sheet):
    tab = visit(sheet)
    settled(tab)
    yield tab
    assert_quiet(tab)


def settled(tab, more="true"):
    """Wait until the page has solved what its sliders ask for."""
    tab.page.wait_for_function(
        """more => { const e = document.querySelector("sos-explorer");
          return e?.answer && e.answer.values.every((v, k) => v === e.values[k])
            && (more === "true" || e.edges); }""",
        arg=more,
    )


first, say = (partial(f, tag="sos-explorer") for f in (first, say))


def state(tab):
    """The element's own words: what it asked for and what it found."""
    return tab.page.evaluate(
        "(() => { const {answer, values, edges, shown, found} ="
        "document.querySelector('sos-explorer');"
        "return {answer, values, edges, response: shown}; })()"
    )


def at(robot, values):
    """The package's design where the sliders stand, in the units they show."""
    sigma, theta, rho, gamma, u_max = values
    return sos.design_pid(
        robot.plant,
        robot.U,
        region=sos.PoleRegion(sigma, rho=rho, theta_deg=theta),
        gamma=gamma,
        saturation=sos.Saturation(u_max, robot.saturation.x0),
    )


def move(tab, values):
    """Put the sliders somewhere at once."""
    tab.page.evaluate(
        "values => { const e = document.querySelector('sos-explorer');"
        "e.remember(); values.forEach((v, k) => e.set(k, v)); }",
        values,
    )
    settled(tab)


def test_what_the_page_shows_is_what_the_package_finds(tab, robot):
    rng = np.random.default_rng(4)
    low, high = np.array([0.2, 30, 4, 0.8, 120]), np.array([1.2, 80, 9, 3, 350])
    feasible = 0
    for values in [state(tab)["values"], *rng.uniform(low, high, (8, 5)).round(2)]:
        move(tab, [float(v) for v in values])
        answer, design = state(tab)["answer"], at(robot, values)
        assert answer["status"] == design.status
        assert say(tab).lower().startswith(design.status)
        if design.status != "feasible":
            continue
        feasible += 1
        assert np.abs(answer["K"] - design.K).max() < 1e-7 * np.abs(design.K).max()
        loop = design.request.vertices[0]
        assert answer["norm"] == pytest.approx(hinf_norm(loop, design.K), rel=1e-4)
        peak = peak_input(loop, design.K, robot.saturation.x0)
        assert answer["peak"] == pytest.approx(peak, rel=1e-3)
    assert feasible > 5


def test_the_region_s_edges_are_dragged_in_the_pole_map(tab):
    handle = first(tab).locator("[data-handle='0']")  # sigma
    x, y = middle(handle)
    tab.page.mouse.move(x, y)
    tab.page.mouse.down()
    tab.page.mouse.move(x - 12, y, steps=4)
    tab.page.mouse.up()
    settled(tab)
    assert state(tab)["values"][0] > 0.9
    assert state(tab)["values"][1:] == [45, 5, 1.257, 150]
    assert first(tab).locator(".sos-ghost").count() > 0


def test_a_finger_drags_an_edge_and_the_page_stays(browser, sheet):
    context = browser.new_context(
        viewport={"width": 390, "height": 500}, has_touch=True, is_mobile=True
    )
    page = context.new_page()
    page.goto(sheet.as_uri())
    page.wait_for_function("document.querySelector('sos-explorer')?.answer")
    handle = page.locator("[data-handle='2']").first  # rho
    x, y = middle(handle)
    scrolled = page.evaluate("scrollY")
    fingers = context.new_cdp_session(page)
    for kind, at in [("Start", x), ("Move", x + 8), ("Move", x + 20), ("End", None)]:
        points = [] if at is None else [{"x": at, "y": y - 3 * (at - x)}]
        fingers.send(
            "Input.dispatchTouchEvent", {"type": f"touch{kind}", "touchPoints": points}
        )
    page.wait_for_function(
        """() => { const e = document.querySelector("sos-explorer");
          return e.values[2] < 5 && e.answer.values[2] === e.values[2]; }"""
    )
    values = page.evaluate("document.querySelector('sos-explorer').values")
    assert values[:2] == [0.7, 45] and 2 < values[2] < 5
    assert page.evaluate("scrollY") == scrolled
    context.close()


def test_a_pole_its_number_and_its_curve_belong_together(tab):
    page, element = tab.page, first(tab)
    number = element.locator(".sos-number").first
    number.hover()
    assert element.locator(".sos-pole.sos-lit").count() in (1, 2)
    words = element.locator(".sos-mode text").text_content()
    poles = state(tab)["answer"]["poles"][0]
    re_, im = max(p for p in poles if p[1] >= 0)  # the slowest comes first
    shown = re.search(r"decays by e in ([\d.]+) s", words)[1]
    assert float(shown) == pytest.approx(-1 / re_, rel=6e-3)
    if im:
        damping = re.search(r"ζ = ([\d.]+)", words)[1]
        assert float(damping) == pytest.approx(-re_ / abs(complex(re_, im)), abs=6e-3)
    # the curve: the envelope at one decay time is 1/e away from the set point
    away = page.evaluate(
        """() => { const e = document.querySelector("sos-explorer"), plot = e.stepPlot;
          const d = e.view.querySelector(".sos-mode path").getAttribute("d");
          const points = d.split(/[ML]/).filter(x => x).map(p => p.split(" "));
          const {l, r, t, b, y: [low, high]} = plot;
          return points.map(([x, y]) => [(Number(x) - l) / (r - l) * e.data.horizon,
            low + (b - Number(y)) / (b - t) * (high - low)]); }"""
    )
    assert all(abs(1 - z) == pytest.approx(np.exp(re_ * t), abs=0.02) for t, z in away)
    element.locator(".sos-title").hover()
    assert element.locator(".sos-lit, .sos-mode").count() == 0


def test_the_step_response_is_the_one_of_python(tab, robot):
    """The page's matrix exponential against `sosbook.plants.response`."""
    found = state(tab)
    z, design = np.array(found["response"][0]), at(robot, found["values"])
    t = np.linspace(0, 8.0, len(z))
    K = np.array(found["answer"]["K"])
    true = simulate(design.request.vertices[0], K, t, r=np.ones(2))
    assert np.abs(z - true.z.T).max() < 1e-9
    assert np.abs(z[-1] - 1).max() < 0.02


def test_the_poles_are_drawn_in_the_shaded_region(tab):
    inside = tab.page.evaluate("""() => {
      const atlas = document.querySelector("sos-explorer");
      const area = atlas.querySelector(".sos-region");
      return [...atlas.querySelectorAll(".sos-pole")].map(pole => {
        const box = pole.getBBox(), at = new DOMPoint(
          box.x + box.width / 2, box.y + box.height / 2);
        return area.isPointInFill(at);
      }); }""")
    assert inside == [True] * 6


def test_the_shaded_region_is_the_one_asked_for(tab):
    sigma, theta, rho, *_ = state(tab)["values"]
    region = sos.PoleRegion(sigma, rho=rho, theta_deg=theta)
    held = tab.page.evaluate("""() => {
      const atlas = document.querySelector("sos-explorer");
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


def test_infeasible_keeps_the_picture_and_says_what_helps(tab, robot):
    drawn = state(tab)["response"]
    move(tab, [2.3, 45, 5, 1.257, 150])
    settled(tab, "edges")
    tab.page.wait_for_function(
        "document.querySelector('sos-explorer .sos-readout')"
        ".textContent.includes('Relax first')"
    )
    text, shown = say(tab), state(tab)
    assert text.startswith("Infeasible") and "Exact multipliers" in text
    assert at(robot, shown["values"]).status == "infeasible"
    assert shown["response"] == drawn
    assert first(tab).locator(".sos-step.sos-stale").count() == 1
    helped = re.search(r"Relax first: (\S+) = ([\d.]+)", text)
    symbols = {"σ": 0, "θ": 1, "ρ": 2, "γ": 3, "uₘₐₓ": 4}
    values = shown["values"]
    values[symbols[helped[1]]] = float(helped[2])
    assert at(robot, values).status == "feasible"


def test_bands_end_where_the_package_s_designs_end(tab, robot):
    settled(tab, "edges")
    shown = state(tab)
    for k, (key, far) in enumerate(zip(LABELS, (-1, 1, 1, 1, 1), strict=True)):
        edge = shown["edges"][k]
        verdicts = []
        ends = edge in (0, 200)  # the slider ends before the designs do
        for step in (0,) if ends else (2 * far, -4 * far):  # looser, harder
            values = list(shown["values"])
            values[k] = tab.page.evaluate(
                """([k, at]) => {
              const s = document.querySelector("sos-explorer").data.sliders[k];
              return s.log ? s.min * (s.max / s.min) ** (at / 200)
                : s.min + (s.max - s.min) * at / 200; }""",
                [k, edge + step],
            )
            verdicts.append(at(robot, values).status)
        assert verdicts == ["feasible", "infeasible"][: 2 - ends], key


def test_bands_are_looked_for_once_the_explorer_is_in_sight(tab):
    """Of the sheet's two only the first has been seen; the second is solved, too."""
    settled(tab, "edges")
    tab.page.wait_for_timeout(300)
    of_second = "[...document.querySelectorAll('sos-explorer')][1]"
    assert tab.page.evaluate(f"{of_second}.answer.status") == "feasible"
    assert tab.page.evaluate(f"{of_second}.edges") is None
    tab.page.locator("sos-explorer").nth(1).scroll_into_view_if_needed()
    tab.page.wait_for_function(f"{of_second}.edges?.length === 5")


def test_the_proof_is_one_for_the_package(tab):
    first(tab).get_by_role("button", name="Prove it exactly").click()
    link = first(tab).locator("a[download]")
    with tab.page.expect_download() as loading:
        link.click()
    proof = DesignProof(loading.value.path().read_text("utf8"))
    assert proof.proven and len(proof.claims) == 6
    for claim in proof.claims:
        assert claim in first(tab).inner_text()


def test_a_refusal_is_proven_and_its_file_is_one_for_the_package(tab, capsys):
    move(tab, [2.3, 45, 5, 1.257, 150])
    assert state(tab)["answer"]["status"] == "infeasible"
    first(tab).get_by_role("button", name="Prove it exactly").click()
    link = first(tab).locator("a[download]")
    with tab.page.expect_download() as loading:
        link.click()
    path = loading.value.path()
    assert main(["verify", str(path)]) == 0
    assert "no gain and no matrices prove" in capsys.readouterr().out
    assert "multipliers of" in first(tab).locator(".sos-more").inner_text()
    first(tab).get_by_role("button", name="Reset").click()
    settled(tab)


def test_a_polytope_moves_with_all_its_vertices(visit, tmp_path):
    example = thesis.example_4()
    element = design_explorer(
        example.plant, example.U, sigma=(1, 9), rho=15, theta=np.pi / 3,
        start={"sigma": 5}, horizon=3.0,
    )  # fmt: skip
    tab = visit(write_page(tmp_path / "arm.html", element.html))
    settled(tab)
    design = sos.design_pid(
        example.plant, example.U, region=sos.PoleRegion(5, np.pi / 3, 15)
    )
    answer = state(tab)["answer"]
    assert np.abs(answer["K"] - design.K).max() < 1e-6 * np.abs(design.K).max()
    assert len(answer["poles"]) == 2 and answer["norm"] is None


@pytest.fixture
def priced(visit, tmp_path, robot):
    """An explorer with a cost, in a page of its own."""
    element = design_explorer(
        robot.plant, robot.U, sigma=(0.1, 2), cost_bound=(0.3, 300),
        cost=sos.QuadraticCost(np.diag([1, 2, 0.5, 0, 1, 3]), np.eye(2), "F"),
        start={"sigma": 0.7, "cost": 30},
    )  # fmt: skip
    tab = visit(write_page(tmp_path / "cost.html", element.html))
    settled(tab)
    yield tab
    assert tab.errors == []


def test_a_cost_is_bounded_told_and_copied(priced):
    answer, names = state(priced)["answer"], {}
    assert answer["status"] == "feasible"
    first(priced).get_by_role("button", name="As Python").click()
    exec(first(priced).locator("pre").inner_text(), names)
    design = names["design"]
    assert design.request.cost.bound == 30
    assert np.abs(answer["K"] - design.K).max() < 1e-7 * np.abs(design.K).max()
    assert answer["cost"] == pytest.approx(design.noise_cost(), rel=1e-6)
    assert f"True cost {answer['cost']:.4g} (bound J = 30)." in say(priced)


@pytest.mark.parametrize(
    "wrong, words",
    [
        ({}, "nothing to slide"),
        ({"sigma": (0.7, 0.5)}, "sigma must be a number, or a pair"),
        ({"theta": (0.5, 45)}, "half-angle in radians"),
        ({"sigma": (0.5, 0.7), "start": {"sigma": 0.9}}, "outside of its slider"),
        ({"sigma": (0.5, 0.7), "start": {"rho": 5}}, "names no slider"),
        ({"u_max": (10, 20)}, "u_max needs saturation"),
        ({"cost_bound": (10, 20)}, "a cost needs both"),
        ({"sigma": (1, 2), "cost": sos.QuadraticCost([[1]], [[1]], bound=1)}, "Q"),
        ({"sigma": (0.5, 0.7), "coupling": "slack"}, "coupling must be"),
    ],
)
def test_bad_input_is_explained(robot, wrong, words):
    with pytest.raises(ValueError, match=words):
        design_explorer(robot.plant, robot.U, **wrong)


def test_a_plant_that_is_too_large_is_refused():
    five = sos.SecondOrderSystem(np.eye(5), np.eye(5), np.eye(5), np.eye(5))
    with pytest.raises(ValueError, match="MapAtlas"):
        design_explorer(five, sigma=(0.1, 1))
