"""A wish whose numbers move, solved by the reader's browser, against the package."""

import re
import sys
from functools import partial
from importlib import import_module

import numpy as np
import pytest

import sosbook as sos
from sosbook.__main__ import main
from sosbook.analysis.linear import hinf_norm, peak_input
from sosbook.book import thesis
from sosbook.book.elements.explorer import design_explorer
from sosbook.book.elements.page import whole
from sosbook.book.notebooks import BOOK
from sosbook.plants.response import simulate
from sosbook.synthesis.proofs import DesignProof
from tests.cases import campaign, examples
from tests.elements import assert_quiet, first, middle, say, two_of, write_page
from tests.test_page_elements import stored
from tests.test_page_steady import HELD

BOUNDS = "sigma", "theta", "rho", "gamma", "u_max"


@pytest.fixture(scope="module")
def explorer(robot):
    return design_explorer(
        robot.plant,
        robot.U,
        region=sos.PoleRegion(0.7, np.pi / 4, 5),
        gamma=1.257,
        saturation=robot.saturation,
        title="The <robot> & its designs",
    )


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
    """Wait until the page has solved what its sentence asks."""
    tab.page.wait_for_function(
        """more => { const e = document.querySelector("sos-wish");
          return e?.answer?.digest === e.digest && e.answer
            && (more === "true" || e.offers || e.answer.proof); }""",
        arg=more,
    )


first, say = (partial(f, tag="sos-wish") for f in (first, say))


def state(tab):
    """The element's own words: what it asked for and what it found."""
    return tab.page.evaluate(
        "(() => { const {answer, named, offers, shown, word} ="
        "document.querySelector('sos-wish');"
        "return {answer, named, offers, word, response: shown}; })()"
    )


def at(robot, named):
    """The package's design for bounds by name, in the units of the page."""
    return sos.design_pid(
        robot.plant,
        robot.U,
        region=sos.PoleRegion(
            named["sigma"], rho=named["rho"], theta_deg=named["theta"]
        ),
        gamma=named["gamma"],
        saturation=sos.Saturation(named["u_max"], robot.saturation.x0),
    )


def move(tab, **named):
    """Ask for bounds at once."""
    tab.page.evaluate(
        "named => { const e = document.querySelector('sos-wish');"
        "e.remember(); e.set(named); }",
        named,
    )
    settled(tab)


def test_what_the_page_shows_is_what_the_package_finds(tab, robot):
    rng = np.random.default_rng(4)
    low, high = np.array([0.2, 30, 4, 0.8, 120]), np.array([1.2, 80, 9, 3, 350])
    feasible, count = 0, examples(4, 8)
    for values in [None, *rng.uniform(low, high, (count, 5)).round(2)]:
        if values is not None:
            move(tab, **dict(zip(BOUNDS, map(float, values))))
        found = state(tab)
        answer, design = found["answer"], at(robot, found["named"])
        assert answer["status"] == design.status
        word = {"infeasible": ["no design"]}.get(design.status, ["feasible", "proven"])
        assert found["word"] in word
        assert say(tab).lower().startswith(tuple(word))
        if design.status != "feasible":
            continue
        feasible += 1
        assert np.abs(answer["K"] - design.K).max() < 1e-7 * np.abs(design.K).max()
        loop = design.request.vertices[0]
        assert answer["norm"] == pytest.approx(hinf_norm(loop, design.K), rel=1e-4)
        peak = peak_input(loop, design.K, robot.saturation.x0)
        assert answer["peak"] == pytest.approx(peak, rel=1e-3)
    assert feasible > count / 2


def test_the_region_s_edges_are_dragged_in_the_pole_map(tab):
    handle = first(tab).locator("[data-handle='sigma']")  # sigma
    x, y = middle(handle)
    tab.page.mouse.move(x, y)
    tab.page.mouse.down()
    tab.page.mouse.move(x - 12, y, steps=4)
    tab.page.mouse.up()
    settled(tab)
    sigma, *others = state(tab)["named"].values()
    assert sigma > 0.9 and others == [45, 5, 1.257, 150]
    assert first(tab).locator(".sos-ghost").count() > 0


def test_a_finger_drags_an_edge_and_the_page_stays(browser, sheet):
    context = browser.new_context(
        viewport={"width": 390, "height": 500}, has_touch=True, is_mobile=True
    )
    page = context.new_page()
    page.goto(sheet.as_uri())
    page.wait_for_function("document.querySelector('sos-wish')?.answer")
    handle = page.locator("[data-handle='rho']").first  # rho
    x, y = middle(handle)
    scrolled = page.evaluate("scrollY")
    fingers = context.new_cdp_session(page)
    for kind, at in [("Start", x), ("Move", x + 8), ("Move", x + 20), ("End", None)]:
        points = [] if at is None else [{"x": at, "y": y - 3 * (at - x)}]
        fingers.send(
            "Input.dispatchTouchEvent", {"type": f"touch{kind}", "touchPoints": points}
        )
    page.wait_for_function(
        """() => { const e = document.querySelector("sos-wish");
          return e.bounds.rho < 5 && e.answer.asked.rho === e.bounds.rho; }"""
    )
    named = page.evaluate("document.querySelector('sos-wish').named")
    assert (named["sigma"], named["theta"]) == (0.7, 45) and 2 < named["rho"] < 5
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
        """() => { const e = document.querySelector("sos-wish"), plot = e.stepPlot;
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
    z, design = np.array(found["response"][0]), at(robot, found["named"])
    t = np.linspace(0, 8.0, len(z))
    K = np.array(found["answer"]["K"])
    true = simulate(design.request.vertices[0], K, t, r=np.ones(2))
    assert np.abs(z - true.z.T).max() < 1e-9
    assert np.abs(z[-1] - 1).max() < 0.02


def test_the_shaded_region_is_the_one_asked_for(tab):
    sigma, theta, rho, *_ = state(tab)["named"].values()
    region = sos.PoleRegion(sigma, rho=rho, theta_deg=theta)
    held = tab.page.evaluate("""() => {
      const atlas = document.querySelector("sos-wish");
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


def test_infeasible_keeps_the_picture_and_offers_what_would_do(tab, robot):
    """Each offer is a design of the package; to press it gives what it says."""
    drawn = state(tab)["response"]
    move(tab, sigma=2.3)
    settled(tab, "offers")
    text, shown = say(tab), state(tab)
    assert "No design: Exact multipliers" in text
    assert at(robot, shown["named"]).status == "infeasible"
    assert shown["response"] == drawn
    assert first(tab).locator(".sos-step.sos-stale").count() == 1
    offers = shown["offers"]
    assert len(offers) > 1 and offers[-1]["key"] == "sigma"  # which was just asked
    for one in offers:
        assert at(robot, shown["named"] | {one["key"]: one["to"]}).status == "feasible"
    buttons = first(tab).locator("[data-do^='offer:']")
    words = buttons.first.inner_text()
    assert f"{offers[0]['to']:g}" in words or offers[0]["key"] in ("sigma", "rho")
    buttons.first.click()
    settled(tab, "proof")
    assert state(tab)["word"] == "proven"
    assert f", {words}" in f", {sentence(tab)}"


def test_the_first_page_s_puzzle_has_an_answer(visit, tmp_path, robot):
    """A bound that doesn't move in the sentence is looked at and offered, too."""
    text = next(text for stem, text in stored() if stem == "intro" and "wish" in text)
    tab = visit(write_page(tmp_path / "puzzle.html", text))
    settled(tab, "proof")
    first(tab).get_by_role("button", name="Show me").click()
    settled(tab, "offers")
    shown = state(tab)
    assert at(robot, shown["named"]).status == "infeasible"
    assert (
        shown["offers"][0]["key"] == "u_max" and shown["offers"][-1]["key"] == "sigma"
    )
    assert first(tab).locator(".sos-say input").count() == 3
    first(tab).locator("[data-do='offer:u_max']").click()
    settled(tab, "proof")
    shown = state(tab)
    assert shown["word"] == "proven" and at(robot, shown["named"]).status == "feasible"
    assert tab.errors == []


def sentence(tab):
    return first(tab).get_attribute("aria-label").split(". ", 1)[1]


def test_the_proof_is_one_for_the_package(tab):
    settled(tab, "proof")  # nobody has to press anything for it
    assert state(tab)["word"] == "proven"
    first(tab).get_by_role("button", name="Prove it exactly").click()
    link = first(tab).locator("a[download]")
    with tab.page.expect_download() as loading:
        link.click()
    proof = DesignProof(loading.value.path().read_text("utf8"))
    assert proof.proven and len(proof.claims) == 6
    for claim in proof.claims:
        assert claim in first(tab).inner_text()


def test_a_refusal_is_proven_and_its_file_is_one_for_the_package(tab, capsys):
    move(tab, sigma=2.3)
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
        example.plant, example.U, region=sos.PoleRegion(5, np.pi / 3, 15),
        move="sigma", horizon=3.0,
    )  # fmt: skip
    tab = visit(write_page(tmp_path / "arm.html", element.html))
    settled(tab)
    design = sos.design_pid(
        example.plant, example.U, region=sos.PoleRegion(5, np.pi / 3, 15)
    )
    answer = state(tab)["answer"]
    assert np.abs(answer["K"] - design.K).max() < 1e-6 * np.abs(design.K).max()
    assert len(answer["poles"]) == 2 and answer["norm"] is None


#: Each word that ends the sentence, from the start on.
SEEN = """<script>
const end = document.querySelector(".sos-say em"), words = [end.textContent];
new MutationObserver(() => {
  if (words.at(-1) !== end.textContent) words.push(end.textContent);
}).observe(end, {childList: true, characterData: true, subtree: true});
</script>"""


@pytest.mark.parametrize("stem", ["intro", *campaign(["14_flexible_arm"]), "own_plant"])
def test_a_page_without_a_script_has_a_still_of_it(visit, browser, tmp_path, stem):
    """Its sentence, its verdict and its pictures are those of the script."""
    sys.path.append(str(BOOK / "_ext"))
    pages = import_module("elements")
    text = whole(
        next(x for name, x in stored() if name == stem and x.startswith(pages.WISHES))
    )
    (still,) = pages.stills(pages.WHOLE.match(text)[0])
    rest = text[text.index("<style") :]
    sheet = write_page(tmp_path / "still.html", HELD, still, rest, SEEN)
    tab = visit(sheet)
    tab.page.evaluate("release()")
    tab.page.wait_for_function(
        "document.querySelector('.of-kit:has(.sos-say)').answer?.proof"
    )
    assert tab.page.evaluate("words") == [
        "proven."
    ]  # before any answer, and ever after
    assert tab.page.evaluate("document.querySelector('.of-kit').ended")
    live = tab.page.locator(".of-kit").first
    assert live.locator(".sos-absent").count() == 0
    drawn = live.locator(".sos-map svg, .sos-step svg").all()
    pictures = [x.get_attribute("aria-label") for x in drawn]
    words = live.get_attribute("aria-label").split(". ", 1)[1].removesuffix(".")
    context = browser.new_context(java_script_enabled=False)
    page = context.new_page()
    page.goto(sheet.as_uri())
    absent = page.locator(".sos-absent")
    assert absent.locator(".sos-say").inner_text() == f"{words}: proven."
    shown = absent.locator("svg").all()
    assert [x.get_attribute("aria-label") for x in shown] == pictures
    assert all(x.is_visible() for x in shown)
    context.close()


@pytest.fixture
def priced(visit, tmp_path, robot):
    """An explorer with a cost, in a page of its own."""
    element = design_explorer(
        robot.plant, robot.U, region=sos.PoleRegion(0.7), requirements=[
            sos.QuadraticCost(np.diag([1, 2, 0.5, 0, 1, 3]), np.eye(2), "F", bound=30)],
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
        ({}, "nothing moves"),
        (
            {"region": sos.PoleRegion(0.5), "move": "rho"},
            "move names rho, and asked are",
        ),
        ({"region": sos.PoleRegion(0.5), "coupling": "slack"}, "coupling must be"),
        ({"requirements": [sos.H2(3.0)]}, "no page solves"),
        ({"r": [1], "gamma": 2.0}, "r must hold n = 2"),
        ({"law": sos.PIDLaw(position=[[1, 0]]), "gamma": 2.0}, "a law"),
    ],
)
def test_bad_input_is_explained(robot, wrong, words):
    U = None if "law" in wrong else robot.U
    with pytest.raises(ValueError, match=words):
        design_explorer(robot.plant, U, **wrong)


def test_a_plant_that_is_too_large_is_refused():
    five = sos.SecondOrderSystem(np.eye(5), np.eye(5), np.eye(5), np.eye(5))
    with pytest.raises(ValueError, match="MapAtlas"):
        design_explorer(five, region=sos.PoleRegion(0.1))
