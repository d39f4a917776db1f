"""Elements that compute in the page: their numbers, and mouse, keyboard, touch.

One page holds the first of each kind that the book shows.
"""

import json
import re

import numpy as np
import pytest
from scipy.linalg import expm, solve_continuous_are, solve_continuous_lyapunov
from scipy.optimize import linear_sum_assignment
from sosbook.widgets.pendulum_control import recover

from sosbook.book.elements import movers
from sosbook.book.notebooks import BOOK
from sosbook.pendulum import Mip, polytope, vertices
from sosbook.plants import descriptors
from sosbook.requirements.cost import QuadraticCost, noise_cost
from tests.test_page_elements import stored

pytestmark = pytest.mark.skipif(
    not BOOK.exists(), reason="the package without its book"
)
KINDS = {kind.tag: kind for kind in movers.Mover.__subclasses__()}
TAGS = sorted(KINDS)


def page_of(pieces):
    return (
        '<!doctype html><html lang="en"><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width">'
        '<link rel="icon" href="data:,"><title>t</title>' + "".join(pieces)
    )


@pytest.fixture(scope="module")
def sheet(tmp_path_factory):
    first = {}
    for _, text in stored():
        tag = re.match(r"<(sos-\w+)", text)[1]
        if tag in KINDS:
            first.setdefault(tag, text)
    assert sorted(first) == TAGS
    path = tmp_path_factory.mktemp("movers") / "all.html"
    path.write_text(page_of(first.values()), "utf8")
    return path


class Sheet:
    """The page, and what the elements on it say and compute."""

    def __init__(self, page):
        self.page, self.errors = page, []
        page.on("pageerror", lambda e: self.errors.append(str(e)))
        page.on("console", lambda m: m.type == "error" and self.errors.append(m.text))
        page.on("request", lambda r: self.errors.append(r.url))

    def open(self, path):
        self.page.goto(path.as_uri())
        self.errors.remove(path.as_uri())

    def compute(self, tag, places):
        """What an element computes at places, from where it starts."""
        return self.page.evaluate(
            """([tag, places]) => {
          const element = document.querySelector(tag);
          element.reset();
          return places.map(p => element.compute({...element.place, ...p})); }""",
            [tag, places],
        )

    def data(self, tag):
        return self.page.evaluate("tag => document.querySelector(tag).data", tag)

    def said(self, tag):
        return self.page.locator(f"{tag} .sos-readout").inner_text()


@pytest.fixture(scope="module")
def desk(browser, sheet):
    context = browser.new_context(reduced_motion="reduce", has_touch=True)
    desk = Sheet(context.new_page())
    desk.open(sheet)
    yield desk
    assert desk.errors == []
    context.close()


def distance(found, true):
    """The largest distance of eigenvalues from their partners."""
    found = np.array([complex(*z) for z in found])
    apart = abs(found[:, None] - np.asarray(true))
    return apart[linear_sum_assignment(apart)].max()


# ------------------------------------------------------------- linear algebra


def test_the_pages_eigenvalues_are_numpys(desk):
    random = np.random.default_rng(5)
    matrices = [
        random.normal(size=(n, n)) * 10 ** random.uniform(-3, 3)
        for n in [1, 2, 3, 4, 5, 6, 7, 8] * 12 + [24, 40]
    ]
    matrices += [np.diag(10 ** random.uniform(-4, 4, 5)) @ m for m in matrices[4:40:8]]
    matrices += [np.zeros((3, 3)), np.roll(np.eye(4), 1, 0), np.eye(5)]
    found = desk.page.evaluate(
        "all => all.map(A => sosLinalg.eigenvalues(A))", [m.tolist() for m in matrices]
    )
    for A, values in zip(matrices, found, strict=True):
        size = np.linalg.norm(A) or 1
        assert distance(values, np.linalg.eigvals(A)) < 1e-10 * size


def test_the_pages_functions_of_matrices_are_scipys(desk):
    random = np.random.default_rng(6)
    for n in (1, 2, 4, 5):
        A = 5 * random.normal(size=(n, n))
        B = random.normal(size=(n, 2))
        Q = np.diag(10 ** random.uniform(-1, 1, n))
        R = np.eye(2) * 10 ** random.uniform(-1, 2)
        stable = A - (abs(np.linalg.eigvals(A)).max() + 1) * np.eye(n)
        X, L, E, (Phi, Gamma) = desk.page.evaluate(
            """([A, B, Q, R, S]) => [sosLinalg.riccati(A, B, Q, R),
                sosLinalg.lyapunov(S, Q), sosLinalg.exponential(A),
                sosLinalg.held(A, B, 0.1)]""",
            [x.tolist() for x in (A, B, Q, R, stable)],
        )
        true = solve_continuous_are(A, B, Q, R)
        assert np.allclose(X, true, rtol=0, atol=1e-7 * abs(true).max())
        assert np.allclose(L, solve_continuous_lyapunov(stable.T, -Q), atol=1e-10)
        assert np.allclose(E, expm(A), rtol=0, atol=1e-10 * abs(expm(A)).max())
        both = expm(0.1 * np.block([[A, B], [np.zeros((2, n + 2))]]))[:n]
        assert np.allclose(np.hstack([Phi, Gamma]), both, atol=1e-12)


# ---------------------------------------------------- every element, every hand


def values(desk, tag):
    return desk.page.evaluate(
        "tag => Object.values(document.querySelector(tag).place)", tag
    )


@pytest.mark.parametrize("tag", TAGS)
def test_mouse_keyboard_and_reset(desk, tag):
    desk.compute(tag, [])
    begin, said = values(desk, tag), desk.said(tag)
    for slider in desk.page.locator(f"{tag} input[type=range]").all():
        before, text = values(desk, tag), slider.get_attribute("aria-valuetext")
        slider.focus()
        highest = slider.input_value() == slider.get_attribute("max")
        desk.page.keyboard.press("ArrowLeft" if highest else "ArrowRight")
        assert values(desk, tag) != before
        assert slider.get_attribute("aria-valuetext") != text
        box = slider.bounding_box()
        before = values(desk, tag)
        right = slider.input_value() < slider.get_attribute("max")
        slider.click(position={"x": box["width"] * 0.4, "y": box["height"] / 2})
        slider.click(position={"x": box["width"] * 0.7, "y": box["height"] / 2})
        assert values(desk, tag) != before or not right
        name = slider.get_attribute("id")
        assert desk.page.locator(f'label[for="{name}"]').inner_text()
    desk.page.locator(f"{tag} .sos-reset").click()
    assert values(desk, tag) == begin and desk.said(tag) == said


@pytest.mark.parametrize("tag", TAGS)
def test_every_position_has_a_picture_and_a_sentence(desk, tag):
    """Both ends of every slider, every choice; no NaN in what is drawn."""
    faults = desk.page.evaluate(
        """tag => {
      const element = document.querySelector(tag), faults = [];
      const look = where => {
        const text = element.view.innerHTML;
        const wrong = text.match(/NaN|undefined|Infinity/);
        if (wrong) faults.push([where, wrong[0]]);
        if (!element.view.querySelector(".sos-readout").textContent.trim())
          faults.push([where, "says nothing"]);
        if (element.view.querySelectorAll("svg:not([aria-label])").length)
          faults.push([where, "a picture without a name"]);
      };
      for (const control of element.data.controls) {
        const input = element.inputs[control.key];
        const ends = control.names ? control.names.map((_, k) => k) : [0, input.max];
        for (const end of ends) {
          element.reset();
          input.value = end;
          input.dispatchEvent(new Event("input"));
          look([control.key, end]);
        }
      }
      element.reset();
      return faults; }""",
        tag,
    )
    assert faults == []


@pytest.mark.parametrize("tag", TAGS)
def test_a_swipe_that_scrolls_leaves_the_slider(desk, tag):
    moved = desk.page.evaluate(
        """tag => {
      const element = document.querySelector(tag);
      element.reset();
      const input = element.view.querySelector("input[type=range]");
      const before = [input.value, JSON.stringify(element.place)];
      const fire = name => input.dispatchEvent(new PointerEvent(name));
      fire("pointerdown");
      input.value = input.value === input.max ? 0 : input.max;
      input.dispatchEvent(new Event("input"));
      const between = JSON.stringify(element.place);
      fire("pointercancel");
      return [before, between, [input.value, JSON.stringify(element.place)],
              getComputedStyle(input).touchAction]; }""",
        tag,
    )
    before, between, after, touch = moved
    assert before == after and between != before[1] and touch == "pan-y"


@pytest.mark.parametrize("tag", TAGS)
def test_a_tap_moves_a_slider(desk, tag):
    desk.compute(tag, [])
    slider = desk.page.locator(f"{tag} input[type=range]").first
    before, box = values(desk, tag), slider.bounding_box()
    for part in (0.15, 0.85):
        slider.tap(position={"x": box["width"] * part, "y": box["height"] / 2})
    assert values(desk, tag) != before


def test_all_fit_a_phone_and_answer_at_once(browser, sheet):
    context = browser.new_context(
        viewport={"width": 390, "height": 844}, color_scheme="dark"
    )
    phone = Sheet(context.new_page())
    phone.open(sheet)
    assert phone.page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    for tag in TAGS:
        milliseconds = phone.page.evaluate(
            """tag => {
          const element = document.querySelector(tag), times = [];
          for (let k = 0; k < 5; k++) {
            const start = performance.now();
            element.update();
            times.push(performance.now() - start);
          }
          return times.sort((a, b) => a - b)[2]; }""",
            tag,
        )
        assert milliseconds < 400, (tag, milliseconds)
    assert phone.errors == []
    context.close()


def test_a_motion_plays_and_rests(desk):
    for tag in TAGS:
        button = desk.page.locator(f"{tag} .sos-play")
        if button.count():
            assert button.inner_text() == "Play"  # motion is reduced here
            at = "tag => document.querySelector(tag).time"
            before = desk.page.evaluate(at, tag)
            button.click()
            desk.page.wait_for_function(
                f"([tag, t]) => ({at})(tag) !== t", arg=[tag, before]
            )
            button.click()
            rest = desk.page.evaluate(at, tag)
            desk.page.wait_for_timeout(60)
            assert desk.page.evaluate(at, tag) == rest


# -------------------------------------------------------- regulator (23 and 27)


@pytest.mark.parametrize("design", [0, 1, 2, 3])
def test_regulator_computes_what_the_package_computes(desk, design):
    middle = Mip.printed()
    (here,) = desk.compute(
        "sos-regulator", [{"design": design, "R": 31.6, "spread": 63, "tilt": 20}]
    )
    robots, K = vertices(middle, 0.63), np.array([here["K"]])
    if design < 3:
        plant = [middle, robots[0], robots[3]][design].plant()
        A, B, _ = descriptors(plant)[0].state_space()
        X = solve_continuous_are(A, B, np.eye(4), [[31.6]])
        assert np.allclose(K, -B.T @ X / 31.6, rtol=1e-7)
    t = np.arange(0, 1.5001, 0.0025)
    x, V = recover(robots, K, np.radians(20), t)
    cost = QuadraticCost(np.eye(4), [[31.6]])
    for k, d in enumerate(descriptors(polytope(middle, 0.63))):
        loop, A, B = here["loops"][k], *d.state_space()[:2]
        assert distance(loop["poles"], np.linalg.eigvals(A + B @ K)) < 1e-6
        true = noise_cost(d, K, cost)
        assert (
            loop["cost"] is None
            if np.isinf(true)
            else np.isclose(loop["cost"], true, rtol=1e-6)
        )
        early = t < 0.6
        assert np.allclose(np.array(loop["theta"])[early], x[0, k, early], atol=1e-6)
        assert np.allclose(np.array(loop["V"])[early], V[k, early], atol=1e-4)


def test_robust_gains_of_the_page_are_proven_for_the_spread(desk):
    robust = desk.data("sos-regulator")["robust"][0]
    assert len(robust["K"]) == len(robust["R"]) >= 4
    for weight, gains, bounds in zip(robust["R"], robust["K"], robust["bound"]):
        for spread, K, bound in zip(robust["spread"], gains, bounds):
            plants = polytope(Mip.printed(), spread / 100)
            inside = descriptors(plants)
            cost = QuadraticCost(np.eye(4), [[weight]])
            costs = [noise_cost(d, np.array([K]), cost) for d in inside]
            assert max(costs) < bound * (1 + 1e-3)


def test_where_the_regulator_of_the_middle_falls(desk):
    tag, places = "sos-regulator", [{"R": 1, "spread": 70}, {"R": 100, "spread": 70}]
    cheap, dear = desk.compute(tag, places)
    (held,) = desk.compute(tag, [{"R": 100, "spread": 70, "design": 3}])
    assert all(cheap["stands"]) and all(held["stands"])
    assert dear["stands"] == [False, False, True, True]


def test_what_an_element_is_made_of():
    made = movers.Mover("t", "h", [movers.slider("x", "X", " m", (0, 2), 0.5, 1)])
    assert repr(made) == "Mover: x"
    assert json.loads(json.dumps(made.data))["controls"][0]["unit"] == " m"
