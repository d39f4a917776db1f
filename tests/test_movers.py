"""Elements that compute in the page: their numbers, and mouse, keyboard, touch."""

import re
from itertools import product

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm, solve_continuous_are, solve_continuous_lyapunov
from scipy.optimize import least_squares, linear_sum_assignment

import sosbook as sos
from sosbook.book import counterexamples, thesis, turntable
from sosbook.book.notebooks import BOOK
from sosbook.delay import (
    ConstantDelay,
    characteristic_roots,
    simulate_delay,
    spectral_abscissa,
)
from sosbook.lmi import Unknown, block
from sosbook.pendulum import Mip, SampledLaw, polytope, vertices
from sosbook.pendulum.experiments import motion
from sosbook.pendulum.margins import SampledLoop
from sosbook.pendulum.recovery import recover
from sosbook.pendulum.srivc import respond
from sosbook.plants import Descriptor, descriptors
from sosbook.requirements.cost import QuadraticCost, noise_cost
from sosbook.solver.blocks import Blocks
from sosbook.solver.loop import centre, phase_one
from tests import layout
from tests.axis import stepless
from tests.cases import by_turns, campaign, examples
from tests.conftest import Tab
from tests.elements import green, said, step, still, write_page
from tests.gains import named
from tests.test_page_elements import FIRST

pytestmark = pytest.mark.skipif(
    not BOOK.exists(), reason="the package without its book"
)
MOVERS = {tag: text for tag, text in FIRST.items() if '"controls":' in text}
TAGS = sorted(MOVERS)
SHARP = {"rtol": 1e-11, "atol": 1e-12}  # of an integrator beside the page's


@pytest.fixture(scope="module")
def sheet(tmp_path_factory):
    """A page with all of them."""
    page = tmp_path_factory.mktemp("movers") / "all.html"
    return write_page(page, *MOVERS.values())


class Sheet(Tab):
    """The page, and what the elements on it say and compute."""

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

    def place(self, tag):
        return self.page.evaluate("tag => document.querySelector(tag).place", tag)

    def said(self, tag):
        return said(self.page.locator(tag))

    def drag(self, handle, right, down, beside=0):
        """Move a handle by the mouse, pressed some pixels ``beside`` its middle."""
        box = still(handle)
        x, y = box["x"] + 8 + beside, box["y"] + 8
        self.page.mouse.move(x, y)
        self.page.mouse.down()
        self.page.mouse.move(x + right, y + down, steps=3)
        self.page.mouse.up()


@pytest.fixture(scope="module")
def desk(browser, sheet):
    context = browser.new_context(reduced_motion="reduce", has_touch=True)
    context.add_init_script(layout.UNPAINTED)
    desk = Sheet(context.new_page())
    desk.page.goto(sheet.as_uri())
    yield desk
    assert desk.errors == [] and desk.requests == [sheet.as_uri()]
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
        "all => all.map(A => sosModules.linalg.eigenvalues(A))",
        [m.tolist() for m in matrices],
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
            """([A, B, Q, R, S]) => [sosModules.linalg.riccati(A, B, Q, R),
                sosModules.linalg.lyapunov(S, Q), sosModules.linalg.exponential(A),
                sosModules.linalg.held(A, B, 0.1)]""",
            [x.tolist() for x in (A, B, Q, R, stable)],
        )
        true = solve_continuous_are(A, B, Q, R)
        assert np.allclose(X, true, rtol=0, atol=1e-7 * abs(true).max())
        assert np.allclose(L, solve_continuous_lyapunov(stable.T, -Q), atol=1e-10)
        assert np.allclose(E, expm(A), rtol=0, atol=1e-10 * abs(expm(A)).max())
        both = expm(0.1 * np.block([[A, B], [np.zeros((2, n + 2))]]))[:n]
        assert np.allclose(np.hstack([Phi, Gamma]), both, atol=1e-12)


# ---------------------------------------------------- every element, every hand
@pytest.fixture
def alone(desk, tag):
    """The desk with all but one element out of sight: no step lays out the others."""
    style = f"body > :not({tag}) {{content-visibility: hidden}}"
    sheet = desk.page.add_style_tag(content=style)
    yield desk
    sheet.evaluate("style => style.remove()")


#: Where the numbers stand, the address that says so, and the sentence.
ADDRESS = """tag => { const e = document.querySelector(tag);
  return [e.place, e.digest, e.sentence]; }"""


@pytest.mark.parametrize("tag", by_turns(TAGS, 1, of=4))
def test_reset_brings_the_first_setting_back_and_the_address_the_other(alone, tag):
    alone.compute(tag, [])
    begin, told = alone.place(tag), alone.said(tag)
    for number in alone.page.locator(f"{tag} .sos-num").all():
        step(number)
    there, address, sentence = alone.page.evaluate(ADDRESS, tag)
    assert there != begin
    alone.page.locator(f"{tag} .sos-reset").click()
    assert alone.place(tag) == begin and alone.said(tag) == told
    alone.page.evaluate(
        """([tag, address]) => document.querySelector(tag).reset(
             Object.fromEntries(new URLSearchParams(address)))""",
        [tag, address],
    )
    assert alone.page.evaluate(ADDRESS, tag) == [there, address, sentence]


@pytest.mark.parametrize("tag", by_turns(TAGS, 0, of=3))
def test_every_position_has_a_picture_and_a_sentence(desk, tag):
    """Both ends of every number, every choice; no NaN in what is drawn."""
    faults = desk.page.evaluate(
        """tag => {
      const element = document.querySelector(tag), faults = [];
      const look = where => {
        const text = element.view.innerHTML;
        const wrong = text.match(/NaN|undefined|Infinity/);
        if (wrong) faults.push([where, wrong[0]]);
        if (!element.words || element.find("say em").textContent !== element.words)
          faults.push([where, "says nothing"]);
        for (const svg of element.view.querySelectorAll("svg")) {
          const plot = svg.querySelector(".sos-grid ~ .sos-line:not(.sos-ghost)");
          if (!svg.ariaLabel || (plot && !/\\d/.test(svg.ariaLabel)))
            faults.push([where, "a plot that doesn't say its state"]);
        }
      };
      for (const {key, names} of element.controls) {
        const {low, high, value} = names ? {} : element.scaleOf(key);
        for (const end of names ? names.map((_, k) => k) : [value(low), value(high)]) {
          element.reset();
          element.move({[key]: end});
          look([key, end]);
        }
      }
      element.reset();
      return faults; }""",
        tag,
    )
    assert faults == []


@pytest.mark.parametrize("tag", by_turns(TAGS, 3, of=4))
def test_the_ruler_is_green_where_the_verdict_is(alone, tag):
    """At random places of each number, a step or more away from an end of green."""
    element = alone.page.locator(tag)
    means = alone.page.evaluate("t => document.querySelector(t).means", tag)
    assert element.get_by_text(f"Green below the ruler: there {means}").count() == bool(
        means
    )
    if not means:
        return
    told = 0
    numbers = element.locator(".sos-num").all()
    for number in {numbers[0], numbers[-1]}:
        key = number.get_attribute("data-slot")
        alone.compute(tag, [])
        bands = green(alone, tag, key)
        found = alone.page.evaluate(
            """([tag, key, bands]) => {
          const element = document.querySelector(tag), told = [];
          const {high, value} = element.scaleOf(key);
          for (let k = 0; k < 12; k++) {
            const at = Math.round(high * ((0.618 * (k + 1)) % 1));
            const [good, from, to] = bands.find(e => at / high <= e[2]);
            const inside = at / high - from > 1.1 / high || from === 0;
            if (!inside || (to - at / high < 1.1 / high && to < 1)) continue;
            element.reset();
            element.move({[key]: value(at)});
            told.push([at, good, element.kind === "feasible"]);
          }
          element.reset();
          return told; }""",
            [tag, key, bands],
        )
        assert [t for t in found if t[1] != t[2]] == []
        told += len(found)
    assert told > 5


def test_a_motion_plays_and_rests(desk):
    """The others are out of sight: no frame lays them out. Each second; all weekly."""
    style = desk.page.add_style_tag(content="*{}")
    for tag in TAGS[:: examples(2, 1)]:
        button = desk.page.locator(f"{tag} .sos-play")
        if button.count():
            hidden = f"body > :not({tag}) {{content-visibility: hidden}}"
            style.evaluate("(style, text) => { style.textContent = text; }", hidden)
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
    style.evaluate("style => style.remove()")


# -------------------------------------------------------- regulator (23 and 27)
@pytest.mark.parametrize("design", [1, 3, *campaign([0, 2])])
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


# ------------------------------------------------------------ fall (chapter 20)
@pytest.mark.parametrize("rotors", [0, 1])
def test_fall_is_the_packages(desk, rotors):
    place = {"angle": 33, "volts": -3.3, "pulse": 0.23, "rotors": rotors}
    (here,) = desk.compute("sos-fall", [place])
    mip = Mip.from_ratios(30.52, 7.133, 110.6, 208.8, rotors=bool(rotors))
    A, B, _ = descriptors(mip.plant())[0].state_space()

    def truth(_, x, V):
        return [*x[2:], *mip.acceleration(x[:2], x[2:], V)]

    def line(_, x, V):
        return A @ x + B[:, 0] * V

    for model, names, off in (
        (truth, ("theta", "phi"), 2e-5),  # the page takes steps of 5 ms
        (line, ("lineTheta", "linePhi"), 1e-8),
    ):
        x, shown = [np.radians(33), 0, 0, 0], np.empty((4, 0))
        for V, steps in ((-3.3, 46), (0.0, 114)):
            t = 0.005 * np.arange(steps + 1)
            path = solve_ivp(model, t[[0, -1]], x, "DOP853", t, args=(V,), **SHARP).y
            x, shown = path[:, -1], np.hstack([shown[:, :-1], path])
        for name, values in zip(names, shown):
            assert np.allclose(here[name], values, rtol=0, atol=off)


# ----------------------------------------------------- circulation (chapter 1)
def circulating(kappa, damping=1):
    """Example 1 with so much of its circulatory forces and of its damping."""
    robot = thesis.example_1().plant
    S = (robot.S + robot.S.T) / 2 + kappa * (robot.S - robot.S.T) / 2
    return sos.SecondOrderSystem(robot.M, damping * robot.D, S, robot.B)


def test_circulation_has_the_poles_and_the_path_of_the_plant(desk):
    places = [{"kappa": 0, "damping": 1}, {"kappa": 1.37, "damping": 0.55}]
    for place, here in zip(places, desk.compute("sos-circulation", places)):
        plant, still = circulating(**place), circulating(0)
        assert distance(here["poles"], plant.poles()) < 1e-9
        run = plant.simulate(np.linspace(0, 60, 1201), x0=[0.2, 0.2, 0, 0])
        assert np.allclose(np.transpose(here["z"]), run.z, atol=1e-7)
        z, v = run.z[:, 500], run.dz[:, 500]
        energy = v @ still.M @ v + z @ still.S @ z
        assert np.isclose(here["energy"][500], energy / 2, rtol=1e-6)


# -------------------------------------------------------- integral (chapter 2)
@pytest.mark.parametrize("factors", [*campaign([(1, 1)]), (2.5, 0.3), (-0.1, 1)])
def test_integral_is_the_packages_loop(desk, factors):
    example = thesis.example_1()
    K = example.K * np.r_[1, 1, 1, 1, factors]
    first, second = factors
    place = {"first": first, "second": second, "force": 13}
    (here,) = desk.compute("sos-integral", [place])
    loop = sos.analyse_pid(example.plant, K, U=example.U)
    assert distance(here["poles"], np.ravel(loop.poles())) < 1e-8
    t = np.linspace(0, 20, 801)
    run = loop.simulate(t, r=[1, 1], w=sos.Step(13, start=10))
    z = np.transpose(here["z"])
    assert np.allclose(z[:, :401], run.z[:, :401], atol=1e-6)
    assert np.allclose(z[:, -1], run.z[:, -1], rtol=1e-4, atol=1e-4)


def test_without_integrals_the_error_is_the_theorems(desk):
    example, place = thesis.example_1(), {"first": 0, "second": 0, "force": 0}
    (here,) = desk.compute("sos-integral", [place])
    offset = -np.linalg.solve(
        example.plant.S - example.plant.B @ example.K_P, example.plant.S @ [1, 1]
    )
    assert np.allclose(np.array(here["z"][-1]) - 1, offset, atol=1e-5)


# ---------------------------------------------------- centre (chapters 3 and 30)
def test_centre_is_the_solvers_and_the_edge_is_singular(desk):
    A = np.array([[0, 1], [-2, -3]])
    p, q, unit = Unknown("p", 1), Unknown("q", 1), np.ones((1, 1))
    for sigma in (0.0, 0.47, 0.9):
        (here,) = desk.compute("sos-centre", [{"sigma": sigma}])
        P = block([[p, q], [q, unit]])
        rate = -((A + sigma * np.eye(2)) @ P + P @ (A + sigma * np.eye(2)).T)
        blocks = Blocks([P, rate], [p, q])
        assert np.allclose(
            here["centre"], centre(blocks, phase_one(blocks).x), atol=1e-4
        )
        for x in here["edge"]:
            least = min(np.linalg.eigvalsh(g)[0] for g in blocks(np.array(x)))
            assert abs(least) < 1e-6


def test_no_point_is_feasible_beyond_the_true_rate(desk):
    kept, lost = desk.compute("sos-centre", [{"sigma": 0.99}, {"sigma": 1}])
    assert kept["centre"] and kept["edge"]
    assert lost["centre"] is None and not lost["edge"] and not lost["feasible"]


# --------------------------------------------------------- segment (chapter 9)
def test_segment_has_the_poles_and_the_inequality_between(desk):
    plants, P = counterexamples.mechanical()
    cases = [(counterexamples.rotation()), (descriptors(plants), P)]
    names = [p["name"] for p in desk.data("sos-segment")["plants"]]
    for name, ((first, second), P) in zip(("rotation", "mechanical"), cases):
        for a in (0, 0.31, 1):
            place = {"plant": names.index(name), "weight": a}
            (here,) = desk.compute("sos-segment", [place])
            E, A = ((1 - a) * getattr(first, x) + a * getattr(second, x) for x in "EA")
            poles = np.linalg.eigvals(np.linalg.solve(E, A))
            assert distance(here["poles"], poles) < 1e-8
            L = A @ P @ E.T + E @ P @ A.T
            assert np.isclose(here["least"], np.linalg.eigvalsh(-L)[0], atol=1e-8)


# ------------------------------------------------------ ranges (chapters 31, 32)
TABLES = [  # gain, sigma, box
    (1, 5, (0, 2, 25, 100)),
    (1, 3, (0, 3, 25, 100)),
    (0, 4.5, (0, 0.1, 25, 60)),
    (0, 5, (0, 2, 25, 100)),
]


def table_loop(data, gain, m, q):
    """E and A + B K from what the page holds: X + m P + q Q + m q R."""
    for parts in (data["E"], data["gains"][gain]):
        yield sum(w * np.array(X) for w, X in zip((1, m, q, m * q), parts))


@pytest.mark.parametrize("gain, sigma, box", TABLES)
def test_ranges_prove_what_is_true_and_break_what_is_not(desk, gain, sigma, box):
    place = dict(zip(("m0", "m1", "q0", "q1"), box), gain=gain, sigma=sigma)
    (here,) = desk.compute("sos-ranges", [place])
    data = desk.data("sos-ranges")

    def right(m, q):
        E, A = table_loop(data, gain, m, q)
        return np.linalg.eigvals(np.linalg.solve(E, A)).real.max()

    assert np.isclose(here["right"], right(*here["worst"]), atol=1e-7)
    assert here["broken"] is (here["right"] >= -sigma)
    rng = np.random.default_rng(5)
    for low, high in here["done"]:
        for m, q in rng.uniform(low, high, (40, 2)):
            assert right(m, q) < -sigma
    area = (box[1] - box[0]) * (box[3] - box[2])
    cells = here["done"] + here["open"]
    covered = sum(np.prod(np.subtract(*cell[::-1])) for cell in cells)
    assert here["broken"] or (np.isclose(covered, area) and here["open"] == [])
    assert here["broken"] is (gain == 0 and box == (0, 2, 25, 100))


def test_ranges_are_the_chapters_tables(desk):
    """Between the corners stand the tables of the function, by a radius of 7 cm."""
    E, A = table_loop(desk.data("sos-ranges"), 0, 1.3, 49)
    (d,) = descriptors(turntable.table(1.3, 0.07))
    assert np.allclose(E, d.E) and np.allclose(A[[0, 1, 3]], d.A[[0, 1, 3]])


def test_a_corner_of_the_box_is_dragged(desk):
    before = desk.said("sos-ranges")
    desk.drag(desk.page.locator("sos-ranges .sos-handle").nth(1), 92, -28)
    place = desk.place("sos-ranges")
    assert place["m1"] > 1 and place["m0"] == 0
    assert desk.said("sos-ranges") != before


# ---------------------------------------------------------- landscape (chapter 35)
def table_loop_of(data, place):
    """A + B K C from what the page holds."""
    A = np.array(data["A"]) + sum(
        place[other["key"]] * np.array(other["part"]) for other in data["others"]
    )
    return lambda a, b: (
        A + a * np.array(data["ways"][0]) + b * np.array(data["ways"][1])
    )


@pytest.mark.parametrize("x, y", [(9, 0), (-40, -0.4), (20, -1.1), (-35, 0.02)])
def test_descents_end_in_minima_of_the_largest_real_part(desk, x, y):
    """Where no step of a hundredth of the map goes down by a thousandth."""
    place = dict(x=x, y=y, k_P=20, k=10, many=1)
    (here,) = desk.compute("sos-landscape", [place])
    loop = table_loop_of(desk.data("sos-landscape"), place)

    def right(a, b):
        return np.linalg.eigvals(loop(a, b)).real.max()

    assert np.isclose(here["right"], right(x, y), atol=1e-7)
    low, size = np.array([[-60, -1.2], [100, 1.26]])
    parts = (np.array(here["path"]) - low) / size
    over = np.maximum(0, np.maximum(-parts, parts - 1)).sum(axis=1)
    path = [right(*point) for point in here["path"]] + 30 * over  # the map's edge
    assert (np.diff(path) <= 1e-9).all()
    assert np.isclose(here["value"], right(*here["end"]), atol=1e-3)
    minima = here["minima"]
    assert sum(m["count"] for m in minima) == 16
    assert minima[0]["value"] == pytest.approx(-16.96, abs=0.3)
    for m in minima[:1]:
        turns = np.linspace(0, 2 * np.pi, 24)
        steps = 1e-2 * np.array([100 * np.cos(turns), 1.26 * np.sin(turns)]).T
        around = [right(*(m["end"] + step)) for step in steps]
        assert min(around) > m["value"] - 1e-3


def test_a_gain_is_dragged_by_mouse_and_by_touch_and_moved_by_keys(desk):
    tag = "sos-landscape"
    desk.page.evaluate("tag => document.querySelector(tag).reset()", tag)
    handle, before = desk.page.locator(f"{tag} .sos-handle"), desk.place(tag)
    said = desk.said(tag)
    desk.drag(handle, 52, 82)
    after = desk.place(tag)
    assert after["x"] > before["x"] and after["y"] < before["y"]
    assert desk.said(tag) != said
    desk.page.locator(f"{tag} [data-slot=x]").press("ArrowUp")
    assert desk.place(tag)["x"] == pytest.approx(after["x"] + 0.5)
    box = still(handle)
    touch = desk.page.context.new_cdp_session(desk.page)
    at = {"x": box["x"] + 8, "y": box["y"] + 8}
    for kind, points in (
        ("touchStart", [at]),
        ("touchMove", [{"x": at["x"] - 40, "y": at["y"] - 50}]),
        ("touchEnd", []),
    ):
        touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
    moved = desk.place(tag)
    assert moved["x"] < after["x"] and moved["y"] > after["y"]


# ----------------------------------------------------------- ride (chapter 37)
@pytest.mark.parametrize(
    "place",
    [
        dict(made=0, stroke=3, m=0.31, bump=0.1),
        *campaign([dict(made=1, stroke=3, m=0.25, bump=0.05)]),
        dict(made=2, stroke=4, m=0.4, bump=0.33),
    ],
)
def test_the_ride_is_that_of_the_packages_loop(desk, place):
    """Of the road held for a step, by scipy; the mass of the page is between two."""
    (page,) = desk.compute("sos-ride", [place])
    k = [2, 3, 4].index(place["stroke"])
    stored = desk.data("sos-ride")["designs"]
    K = np.array(stored[place["made"] - 1][k]["K"] if place["made"] else [0] * 4)
    (d,) = descriptors(
        sos.SecondOrderSystem(
            np.diag([place["m"], 0.04]), [[1, -1], [-1, 1]],
            [[20, -20], [-20, 200]], [[1], [-1]], [[0], [180]],
        )
    )  # fmt: skip
    A, B, W = d.state_space()
    A, h = A + B @ K[None], 1.5 / 600
    t = (np.arange(600) + 0.5) * h
    road = 0.05 * np.sin(np.pi * t / place["bump"]) ** 2 * (t < place["bump"])
    held = expm(h * np.block([[A, W], [np.zeros((1, 5))]]))
    x = [np.zeros(4)]
    for w in road:
        x.append(held[:4, :4] @ x[-1] + held[:4, 4] * w)
    x = np.array(x)
    assert np.allclose(page["z"], x[:, :2], rtol=0, atol=1e-9)
    assert np.allclose(page["s"], x[:, 0] - x[:, 1], rtol=0, atol=1e-9)
    assert np.allclose(page["u"], x @ K, rtol=0, atol=1e-7)
    assert np.allclose(page["a"], x @ A[2], rtol=0, atol=1e-6)


def test_the_ride_says_what_is_proven_and_where_nothing_is(desk):
    """Proven bounds hold for cars that nobody designed for, by their responses."""
    said = desk.page.evaluate(
        """all => { const e = document.querySelector("sos-ride");
          return all.map(p => { e.reset(p); return e.textContent; }); }""",
        [dict(made=1, stroke=s) for s in (2, 3)],
    )
    assert "These bounds: infeasible" in said[0]
    (bound,) = re.findall(r"comfort below ([\d.]+)", said[1])
    K = np.array(desk.data("sos-ride")["designs"][0][2]["K"])
    grid, largest = 1j * np.linspace(1, 200, 2000), 0
    for m in (0.25, 0.3, 0.4):
        for s in grid:
            loop = np.diag([m, 0.04]) * s**2 + s * np.array([[1, -1], [-1, 1]])
            loop = loop + [[20, -20], [-20, 200]]
            loop -= np.outer([1, -1], K[:2] + s * K[2:])
            size = abs(s**2 * np.linalg.solve(loop, [0, 180])[0])
            largest = max(largest, size)
    assert 720 < largest < float(bound) < 1.005 * largest


# ---------------------------------------------------------- drive (chapter 39)
@pytest.fixture(scope="module")
def programs():
    """The chapter's controllers, made anew, by clock."""
    units = {"motor": "rad", "load": "rad", "u": "N m"}
    plants = sos.Uncertain(turntable.drive, J=(0.01, 0.03))
    K = np.array([[-11.068, 5.641, -0.4, -0.356, -13.099]])
    region = sos.PoleRegion(sigma=4, rho=200)
    design = sos.analyse_pid(plants, K, [[1, 0]], region=region)
    return [
        design.controller(["motor"], T=t, delay=t, counts=4096, units=units)
        for t in (0.001, 0.004, 0.006)
    ]


@pytest.mark.parametrize(
    "law, limit, clock, r, w",
    [(0, 1, 0, 20, 0), (0, 2, 1, 6, 0.3), (1, 0, 2, 3, 0.5), (2, 2, 1, 60, 0)],
)
def test_the_drive_moves_as_the_packages_program_does(
    desk, programs, law, limit, clock, r, w
):
    place = dict(law=law, limit=limit, clock=clock, r=r, w=w, counts=0, J=0.03)
    (page,) = desk.compute("sos-drive", [place])
    c, ramp = programs[clock], desk.data("sos-drive")["clocks"][clock]["ramp"]
    c = stepless(c).watch(stall=20)
    c = c if law else c.set_point(r=[[1], [1]])
    c = c.set_point(ramp=ramp) if law == 2 else c
    c = c.limit(2.0, anti_windup=limit == 2) if limit else c
    load = (lambda t: [w if t >= 2.5 else 0]) if w else None
    run = c.simulate(4, r=[r], w=load)
    at = np.rint(np.array(page["t"]) / c.T).astype(int)
    shown, size = np.array([page["q"], page["z"]]), abs(run.x[1, :, :2]).max()
    assert np.allclose(shown.T, run.x[1, at, :2], rtol=0, atol=1e-7 * size)
    assert np.allclose(page["u"], run.u[1, at, 0], atol=1e-6)
    assert page["high"] == pytest.approx(abs(run.x[1, :, 1]).max(), rel=1e-7)


def test_the_drives_encoder_has_the_packages_steps(desk, programs):
    """Rounding may move a single reading by a step; the motion is the same to a few."""
    (page,) = desk.compute("sos-drive", [dict(law=1, limit=2, r=0.5, J=0.01)])
    run = programs[0].limit(2.0).simulate(4, r=[0.5])
    at = np.rint(np.array(page["t"]) / 0.001).astype(int)
    few = 20 * 2 * np.pi / 4096
    assert np.allclose(page["z"], run.x[0, at, 1], atol=few)
    assert np.allclose(page["u"][:9], run.u[0, at[:9], 0], atol=1e-9)
    assert abs(np.array(page["u"]) - run.u[0, at, 0]).max() < 0.2


def test_the_drive_says_proven_where_a_bound_of_the_package_is_kept(desk, programs):
    c, naive = programs[0], programs[0].set_point(r=[[1], [1]])
    sums = {law: x.bounds.step().proven for law, x in ((0, naive), (1, c))}
    noise = c.bounds.noise().proven
    places = [
        dict(law=law, limit=limit, r=r, counts=3)
        for law in (0, 1) for limit in (0, 1, 2) for r in (0.9, 1.05, 8, 10, 20)
    ]  # fmt: skip
    found = desk.page.evaluate(
        """places => { const e = document.querySelector("sos-drive"); e.reset();
        return places.map(p => e.proven({...e.place, ...p})); }""",
        places,
    )
    for place, proven in zip(places, found, strict=True):
        most = sums[place["law"]] * place["r"] + noise
        assert proven["total"] == pytest.approx(most)
        assert proven["holds"] is (not place["limit"] or most <= 2)
    (loaded,) = desk.page.evaluate(
        """() => [document.querySelector("sos-drive")].map(
             e => e.proven({...e.place, limit: 2, law: 1, r: 1, w: 0.1}))"""
    )
    assert loaded["holds"] is False


def test_the_drive_runs_away_comes_back_and_ramps(desk):
    def said(**place):
        desk.page.evaluate(
            """p => { const e = document.querySelector("sos-drive");
            e.reset(); e.move(p); }""",
            place,
        )
        return desk.said("sos-drive")

    assert "It runs away." in said() and "no proof reaches this step" in said()
    assert "It settles here: simulated only." in said(limit=2)
    assert "It settles: proven." in said(limit=2, law=2)
    assert "w/k = 0.05 rad" in said(limit=2, law=2, w=0.5)


# --------------------------------------------------------- sensors (chapter 34)
KEYS = "p1", "p2", "v1", "v2", "integral", "filter"
RANGES = "J0", "J1", "k0", "k1"


def drive(J, k):
    return sos.SecondOrderSystem(
        [[0.01, 0], [0, J]], [[0.03, -0.01], [-0.01, 0.01]],
        [[k, -k], [-k, k]], [[1], [0]], [[0], [1]],
    )  # fmt: skip


def drives(place):
    """The plants of the box of a place."""
    J0, J1, k0, k1 = (place[k] for k in RANGES)
    loads = tuple(sorted((J0, J1)))
    if k0 == k1:
        return sos.Uncertain(lambda J: drive(J, k0), J=loads)
    return sos.Uncertain(drive, J=loads, k=tuple(sorted((k0, k1))))


def drawn(seed, count):
    """Places of the element with a sensor or more, their ranges on its sliders."""
    rng = np.random.default_rng(seed)
    while count:
        place = dict(zip(KEYS, (*rng.integers(0, 2, 5).tolist(), int(rng.integers(3)))))
        loads = (0.005 + 0.0005 * rng.choice(91, 2, replace=False)).round(4).tolist()
        k0 = round(2 + 0.1 * int(rng.integers(281)), 1)
        k1 = k0 if rng.random() < 0.7 else min(30.0, round(1.1 * k0, 1))
        if any(place[k] for k in KEYS[:4]):
            yield place | dict(zip(RANGES, (*loads, k0, k1)))
            count -= 1


def gains_of(here):
    """What the page found, as the package has it."""
    pairs = [*zip(here["names"], here["gains"])]
    return {k: [[x for name, x in pairs if name == k]] for k in here["names"]}


def law_of(desk, place, here):
    """The law of the ticks, with the gains that the page has."""
    data, one = desk.data("sos-sensors"), np.eye(2)
    p, v = (one[[i for i in (0, 1) if place[f"{x}{i + 1}"]]] for x in "pv")
    return sos.PIDLaw(
        p if len(p) else None,
        v if len(v) else None,
        filter=None if len(v) else 1 / data["rates"][place["filter"]],
        integrate=np.eye(1, len(p)) if len(p) and place["integral"] else False,
        limits={k: data["limits"][k] for k in here["names"]},
    )


def settled(desk, place):
    """What the element computes at a place, and proves when nothing moves."""
    return desk.page.evaluate(
        """place => {
      const e = document.querySelector("sos-sensors");
      e.reset(place);
      for (const _ of e.looks(e.place)) if (e.result.tried) break;
      return e.result; }""",
        place,
    )


def test_sensors_have_the_poles_and_the_motion_of_the_law(desk):
    """And the truth is the slowest of numpy's on a grid; random sensors and ranges."""
    for place in drawn(1, examples(2, 5)):
        (here,) = desk.compute("sos-sensors", [place])
        law, gains = law_of(desk, place, here), gains_of(here)
        (low, soft), (high, stiff) = here["box"]
        spans = np.linspace(low, high, 9), np.unique(np.linspace(soft, stiff, 9))
        points = [(J, k) for J in spans[0] for k in spans[1]]
        poles = [sos.analyse_pid(drive(*p), gains, law=law).poles() for p in points]
        right = max(p.real.max() for p in poles)
        assert np.isclose(right, -here["decay"], rtol=1e-6, atol=1e-6)
        loop = sos.analyse_pid(drive(*here["worst"]), gains, law=law)
        assert distance(here["poles"][0], loop.poles()[0]) < 1e-7 * 500
        means = [p.real.mean() for p in (poles[0], poles[-1])]
        assert (here["limit"] is None) is bool(place["v1"])
        assert place["v1"] or np.isclose(here["limit"], -max(means))
        assert bool(here["unseen"]) is not bool(place["p1"] or place["p2"])
        angles = place["p1"] + place["p2"]
        slow = 0 if place["v1"] or place["v2"] else angles
        start = [1, 1, 0, 0, *[0] * (place["integral"] if angles else 0), *[1] * slow]
        run = loop.simulate(np.linspace(0, 3, 601), x0=start)
        early = np.abs(run.z).max(axis=0) < 1e3
        shown = np.array(here["angles"][0]).T
        assert np.allclose(shown[:, early], run.z[:, early], atol=1e-5)


@pytest.mark.parametrize("count", [3, *campaign([30])])
def test_what_the_page_proves_of_a_range_the_package_keeps(desk, count):
    shares = []
    for place in drawn(2, count):
        here = settled(desk, place)
        shares.append(here["sigma"] / here["decay"] if here["sigma"] else 0)
        if not here["sigma"]:
            continue
        sigma, family = here["sigma"], drives(place)
        asked = dict(law=law_of(desk, place, here), region=sos.PoleRegion(sigma=sigma))
        kept = sos.analyse_pid(family, gains_of(here), **asked)
        assert kept.status == "feasible" and sigma < here["decay"]
        cells, thin = np.array(here["cells"]), [0, place["k0"] == place["k1"]]
        spans = cells[:, 1] - cells[:, 0] + thin  # without a gap
        box = np.subtract(*here["box"][::-1]) + thin
        assert np.isclose(spans.prod(axis=1).sum(), box.prod())
    assert sum(share > 0.9 for share in shares) >= count / 2


def test_the_page_proves_nothing_that_is_false(desk):
    """Claims a hundredth above what the slowest plant does, whose grid is coarse."""
    count = examples(10, 20)
    claims = desk.page.evaluate(
        """places => places.map(place => {
      const e = document.querySelector("sos-sensors"), {cells} = sosModules;
      const {loop, decay} = e.best({...e.place, ...place});
      return [0.9, 1.01].map(share => {
        const work = cells.covering(
          loop, e.box({...e.place, ...place}), share * decay, 60);
        for (;;) {
          const {done, value} = work.next();
          if (done) return !value.open.length;
        }
      }); })""",
        [*drawn(3, count)],
    )
    assert (
        not any(false for _, false in claims) and sum(t for t, _ in claims) > count / 5
    )


@pytest.mark.parametrize(
    "ticks", [(0, 1, 0, 1), *campaign([(1, 0, 0, 0), (1, 1, 1, 1)])]
)
def test_the_search_of_the_page_is_as_good_as_the_packages(desk, ticks):
    here = dict(J0=0.01, J1=0.03, k0=10, k1=10, integral=0, filter=1)
    place = here | dict(zip(KEYS, ticks))
    (found,) = desk.compute("sos-sensors", [place])
    law = law_of(desk, place, found)
    design = sos.design_pid(
        drives(place), law=law, maximize="sigma", search=sos.Search(starts=4)
    )
    assert found["decay"] > design.request.region.parts[0].bound


def test_a_sensor_is_ticked_by_mouse_key_and_finger(desk):
    tag, box = "sos-sensors", desk.page.locator("sos-sensors input[type=checkbox]")
    desk.compute(tag, [])
    seen = [desk.said(tag)]
    desk.page.locator(f"{tag} [data-tick=v1]").click()
    assert desk.place(tag)["v1"] == 1 and box.nth(2).is_checked()
    seen.append(desk.said(tag))
    box.nth(1).focus()
    desk.page.keyboard.press("Space")
    assert desk.place(tag)["p2"] == 1
    seen.append(desk.said(tag))
    desk.page.locator(f"{tag} [data-cell='0100']").tap()
    assert [desk.place(tag)[k] for k in KEYS[:4]] == [0, 1, 0, 0]
    seen.append(desk.said(tag))
    for where, keys in (("map", ("J1", "k1")), ("scene", ("k0", "k1"))):
        handle = desk.page.locator(f"{tag} .sos-{where} .sos-handle").last
        before = desk.place(tag)
        desk.drag(handle, 16, -16)
        after = desk.place(tag)
        assert all(after[k] > before[k] for k in keys)
        assert all(after[k] == before[k] for k in {*RANGES} - {*keys})
        seen.append(desk.said(tag))
    assert len(set(seen)) == 6
    desk.page.locator(f"{tag} .sos-reset").click()
    assert desk.said(tag) == seen[0]


# ----------------------------------------------------------- reach (chapter 33)
def test_what_the_page_leaves_is_what_the_best_input_leaves(desk):
    """By least squares of numpy; nothing is left where the motor pushes as w does."""
    M, D, S = (np.array(x) for x in desk.data("sos-reach")["plant"].values())
    names = "motor", "gust", "omega"
    asked = [*product(range(3), range(3), (0.1, 7.3, 14.1, 25))][:: examples(3, 1)]
    places = [dict(zip(names, x)) for x in asked]
    for place, here in zip(places, desk.compute("sos-reach", places), strict=True):
        motor, gust, omega = place.values()
        G = np.linalg.inv(S - omega**2 * M + 1j * omega * D)
        u, w = G[:, [motor]], G[:, gust]
        left = w - u @ np.linalg.lstsq(u, w, rcond=None)[0]
        for found, true in ((here["free"], w), (here["left"], left)):
            found = np.array(found) @ [1, 1j]
            assert np.allclose(found, true, rtol=0, atol=1e-12)
            assert motor != gust or found is w or abs(left).max() < 1e-12


def test_what_is_refused_and_kept_lies_around_the_highest_point(desk):
    found = desk.data("sos-reach")["found"]
    for motor, gust in np.ndindex(3, 3):
        (here,) = desk.compute("sos-reach", [dict(motor=motor, gust=gust)])
        top = max(y for _, y in here["curves"]["left"]) / 1000
        pair = found[motor][gust]
        assert pair["excluded"] <= 1.001 * top and top < pair["reached"]
        assert (pair["excluded"] == 0) == (motor == gust)
        assert motor == gust or pair["reached"] < 1.05 * pair["excluded"]
        assert len(pair["fixed"]) == (motor == 1)  # mass 1 against mass 3
    said = desk.page.evaluate(
        """all => { const e = document.querySelector("sos-reach");
          return all.map(gamma => { e.reset({gamma}); return e.textContent; }); }""",
        [25, 25.6, 27],
    )
    words = "No gain keeps 25 mm/N", "Undecided", "found a gain and proved 26 mm/N"
    assert all(x in y for x, y in zip(words, said, strict=True))
    assert all("doesn't move the mode at −1 ± 14.1j rad/s" in x for x in said)


def test_a_mass_is_chosen_by_mouse_and_finger(desk):
    tag, seen = "sos-reach", [desk.said("sos-reach")]
    for mass, press in ((0, "click"), (2, "tap")):
        getattr(desk.page.locator(f"{tag} [data-cell='{mass}']"), press)()
        assert desk.place(tag)["motor"] == mass
        seen.append(desk.said(tag))
    assert len(set(seen)) == 3 and "The motor moves every mode." in seen[1]


# ------------------------------------------------- delayed (chapter 15)
@pytest.mark.parametrize("h", [0, 1.6, *campaign([0.4, 1.1])])
def test_delayed_roots_are_the_packages(desk, h):
    for k, loop in enumerate(desk.data("sos-delayed")["loops"]):
        place = {"loop": k, "h": h, "gain": 1.5, "kind": 0}
        (here,) = desk.compute("sos-delayed", [place])
        A, A_d = np.array(loop["A"]), 1.5 * np.array(loop["Ad"])
        true = characteristic_roots(A, A_d, h, count=5)
        found = np.array([complex(*s) for s in here["roots"]])
        for s in true:
            assert abs(found - s).min() < 1e-7
        assert np.isclose(found.real.max(), spectral_abscissa(A, A_d, h), atol=1e-7)


def test_delayed_responses_are_the_packages(desk):
    one, none = np.eye(1), np.zeros((1, 0))
    loop = Descriptor(E=one, A=0 * one, Bu=one, Bw=none, C=one)
    places = [{"loop": 0, "h": 1.1, "gain": 1, "kind": 0}, {"h": 1.55, "kind": 1}]
    steady, clinging = desk.compute("sos-delayed", places)
    run = simulate_delay(
        loop, [[-1.0]], steady["t"], ConstantDelay(1.1), history=lambda s: [1.0]
    )
    assert np.allclose(steady["x"], run.x[0], atol=1e-3)
    t, x = np.array(clinging["t"]), np.array(clinging["x"])
    period = np.interp(2.55 * np.arange(9), t, x)
    assert np.allclose(period[2:] / period[1:-1], -(1.55 - 0.5), atol=5e-3)


# ----------------------------------------------------------- clock (chapter 23)
@pytest.mark.parametrize("sensing", [0, 1])
def test_clock_has_the_radius_of_the_sampled_loop(desk, sensing):
    middle, laws = Mip.printed(), desk.data("sos-clock")["laws"]
    for k, law in enumerate(laws):
        place = {"law": k, "T": 12.5, "delay": 35, "sensing": sensing}
        (here,) = desk.compute("sos-clock", [place])
        sampled = SampledLaw.of_gain(named([law["K"]]), 0.0125)
        kind = ("exact", "differenced")[sensing]
        robots = (middle, *vertices(middle))
        true = [SampledLoop(r, sampled, 0.35 * 0.0125, kind).radius for r in robots]
        assert np.allclose(here["radius"], true, atol=1e-7)


# ------------------------------------------------------------- mass (chapter 8)
def test_mass_is_the_chain_with_a_light_body(desk):
    chain = thesis.example_3().plant
    places = [
        {"m4": 0.02, "b4": 20, "lent": 0},
        {"m4": 0.001, "b4": 0, "lent": 0},
        {"m4": 0.001, "b4": 7, "lent": 0.3},
    ]
    for place, here in zip(places, desk.compute("sos-mass", places)):
        M, D = np.diag([3, 2, 1, place["m4"] + place["lent"]]), chain.D.copy()
        D[2:, 2:] += (place["b4"] - 20) * np.array([[1, -1], [-1, 1]])
        plant = sos.SecondOrderSystem(M, D, chain.S, chain.B, chain.F)
        true = plant.poles()
        assert distance(here["poles"], true) < 1e-8 * abs(true).max()
        t = np.linspace(0, 0.05, 301)
        run = plant.simulate(t, w=sos.Step([0, 0, 0, 1]))
        assert np.allclose(here["v"], run.dz[3], atol=1e-6)


# ---------------------------------------------------------- kalman (chapter 19)
def test_kalman_is_scipys_filter_and_the_loops_poles(desk):
    data = desk.data("sos-kalman")
    E, A, B = (np.array(data[x]) for x in "EAB")
    C, K = np.array(data["C"]), np.array(data["K"])
    place = {"gyro": 0.02, "wheels": 0.5, "push": 0.7}
    a, b = (np.linalg.solve(E.mean(0), x.mean(0)) for x in (A, B))
    R = np.diag([0.02, 0.5]) ** 2
    X = solve_continuous_are(a.T, C.T, 0.49 * b @ b.T, R)
    L = -X @ C.T @ np.linalg.inv(R)
    for k in range(len(E) + 1):
        (here,) = desk.compute("sos-kalman", [place | {"plant": k}])
        assert np.allclose(here["L"], L, rtol=1e-6)
        f, g = (
            (a, b) if k == 0 else (np.linalg.solve(E[k - 1], x[k - 1]) for x in (A, B))
        )
        loop = np.block([[f, g @ K], [-L @ C, a + b @ K + L @ C]])
        assert distance(here["poles"], np.linalg.eigvals(loop)) < 1e-5


# ----------------------------------------------------------- chirp (chapter 21)
def test_chirp_is_the_packages_experiment_and_its_fit(desk):
    e, f, d = desk.data("sos-chirp")["truth"]
    places = [{"amplitude": 1.85, "noise": 0}, {"amplitude": 1, "noise": 3}]
    quiet, noisy = desk.compute("sos-chirp", places)
    q, _ = motion(-e, f, d, np.array(quiet["V"]), 0.01)
    assert np.allclose(quiet["q"][: len(q)], q, atol=1e-5)
    assert np.allclose(quiet["fits"][0], [e, f, d], rtol=1e-5)
    assert abs(quiet["fits"][1][2] / d - 1) > 0.03  # the linear model's bias
    V, y = np.array(noisy["V"]), np.array(noisy["y"])[:-1]

    def residual(x, linear):
        if linear:
            return respond([-x[0], 0], [1, x[1], x[2]], V, 0.01) - y
        return motion(-x[0], x[1], x[2], V, 0.01)[1][: len(y)] - y

    for linear, found in zip((False, True), noisy["fits"]):
        best = least_squares(residual, [e, f, d], args=(linear,), x_scale="jac").x
        assert np.allclose(found, best, rtol=2e-3)


# ---------------------------------------------------------- digits (chapter 25)
def test_digits_are_pythons_and_numpys(desk):
    K = np.array(desk.data("sos-digits")["K"])
    places = [{"precision": k, "tilt": 7.5, "rate": -0.35} for k in (0, 1)]
    double, single = desk.compute("sos-digits", places)
    for text, k in zip(double["hex"], K):
        assert float.fromhex(text) == k and text == short(k)
    for text, k in zip(single["hex"], K):
        assert float.fromhex(text) == float(np.float32(k))
    state = [np.radians(7.5), 0.5, -0.35, -0.3, 0.1]
    assert np.isclose(double["exact"], K @ state, rtol=1e-14)
    told = np.float32(0)
    for k, x in zip(K, state):
        told = np.float32(told + np.float32(np.float32(k) * np.float32(x)))
    assert double["single"] == single["single"] == float(told)


def short(x):
    """The hexadecimal literal without the zeros at its end."""
    return re.sub(
        r"(\.[0-9a-f]*?)0*p", lambda m: (m[1].rstrip(".") or "") + "p", x.hex()
    )


# ----------------------------------------------------------- chain (chapter 26)
def test_chain_hands_on_what_the_package_computes(desk):
    ratios = {"e_c": 27.0, "f_c": 7.2, "d_c": 120.0, "e_a": 199.0}
    place = ratios | {"R": 10, "spread": 12, "late": 70}
    (here,) = desk.compute("sos-chain", [place])
    mip = Mip.from_ratios(*ratios.values())
    for letter in "abcdef":
        assert np.isclose(here["mip"][letter], getattr(mip, letter), rtol=1e-12)
    A, B, _ = descriptors(mip.plant(), [[0, 1]])[0].state_space()
    K = -B.T @ solve_continuous_are(A, B, np.eye(5), [[10]]) / 10
    assert np.allclose(here["K"], K[0], rtol=1e-7)
    law = SampledLaw.of_gain(named(K), 0.01)
    true = [SampledLoop(r, law, 0.007).radius for r in vertices(mip, 0.12)]
    assert np.allclose(here["radius"], true, atol=1e-7)


# ----------------------------------------------------------- trust (chapter 29)
def test_trust_proves_what_exact_arithmetic_proves(desk):
    """Against floats where they are sure; the status alone is sometimes wrong."""
    places = [
        {"kappa": kappa, "digits": digits, "tolerance": tolerance}
        for kappa in (0.9, 0.974, 0.979, 0.982, 1.04)
        for digits in (1, 2, 3, 6, 12)
        for tolerance in (-9, -2)
    ]
    seen = desk.compute("sos-trust", places)
    for place, here in zip(places, seen):
        plant = circulating(place["kappa"])
        assert here["stable"] == (plant.poles().real.max() < 0)
        assert here["stable"] or not here["proven"]  # a proof never lies
        assert here["floats"] == here["proven"] or abs(min(here["least"])) < 1e-9
    assert any(x["status"] and not x["stable"] for x in seen)
    assert any(x["stable"] and not x["proven"] for x in seen)
    assert sum(x["proven"] for x in seen) > 10


# ------------------------------------------------------------ shaft (chapter 33)
def test_a_shaft_shows_what_was_computed_for_its_setting(desk):
    """The setting of the values that stand; an angle's mark turns by it, grown."""
    data = desk.data("sos-shaft")
    keys, grids = list(data["grids"]), data["grids"].values()
    settings = dict(zip(product(*grids), data["settings"], strict=True))
    steps = {c["key"]: range(len(c["names"])) for c in data["controls"] if "names" in c}
    places = [
        {k: list(steps[k])[data["grids"][k].index(v)] if k in steps else v
         for k, v in zip(keys, values, strict=True)} for values in settings
    ]  # fmt: skip
    found = desk.compute("sos-shaft", places)
    assert found == list(settings.values())
    turns, discs, dots = desk.page.evaluate(
        """() => {
      const element = document.querySelector("sos-shaft");
      const all = (kind, keys) => [...element.querySelectorAll(kind)].map(
        e => keys.map(key => Number(e.getAttribute(key))));
      element.seek(element.horizon / 4);
      return [element.result.turns, all("ellipse", ["cx", "cy", "rx", "ry"]),
              all("circle", ["cx", "cy"])]; }"""
    )
    here = np.array(turns)
    angles = here[:, round((here.shape[1] - 1) / 4)]
    (x, y, rx, ry), (u, v) = np.transpose(discs), np.transpose(dots[: len(discs)])
    drawn = np.arctan2((u - x) / rx, (y - v) / ry)
    scale = abs(here).max()
    assert np.ptp(here, 1).max() > 0.1 * scale
    assert np.allclose(drawn * angles[-1], drawn[-1] * angles, atol=0.04 * scale)


# --------------------------------------------------------------- arm (chapter 38)
def test_an_arm_s_poles_are_those_of_its_modes(desk):
    """By numpy, on the beam's closed form, too; a mode moves as its vector does."""
    data = desk.data("sos-arm")
    w, d, shapes, kept = (
        np.array(data[k]) for k in ("frequencies", "damping", "shapes", "kept")
    )
    thin = np.array([1.87510407, 4.69409113]) ** 2 * np.sqrt(70e9 * 0.009**2 / 32400)
    assert np.allclose(w[:2], thin, rtol=5e-3)
    places = [dict(a=0.94, s=1, g=1.5), dict(a=0.3, s=0.7, g=0.4), dict(a=1, s=1, g=3)]
    seen = desk.compute("sos-arm", places)
    for place, found in zip(places, seen, strict=True):
        push, rate = (shapes[:, round(100 * place[k])] for k in "as")
        for n, poles in ((kept, found["few"]), (len(w), found["all"])):
            D = np.diag(d) + place["g"] * np.outer(push, rate)
            A = np.block(
                [[np.zeros((n, n)), np.eye(n)], [-np.diag(w[:n] ** 2), -D[:n, :n]]]
            )
            true, vectors = np.linalg.eig(A)
            upper = sorted(true[true.imag > 0], key=abs)
            assert np.allclose([complex(*x) for x in poles], upper, atol=1e-5)
        q = vectors[:n, true.real.argmax()] @ shapes
        drawn = np.array(found["shape"]) @ [1, 1j]
        assert abs(np.vdot(q, drawn)) == pytest.approx(
            np.linalg.norm(q) * np.linalg.norm(drawn), rel=1e-6
        )
    grows = [max(x[k], key=lambda p: p[0])[0] > 0 for x in seen for k in ("few", "all")]
    assert grows[:2] == [False, True] and grows[4:] == [False, False]


@pytest.mark.parametrize("beside", [0, 18])
def test_push_and_sensor_are_dragged_along_the_arm(desk, beside):
    """A handle that swings is held, too, where it was a moment ago."""
    element = desk.page.locator("sos-arm")
    element.evaluate("node => node.reset()")
    push = element.locator(".sos-handle").first
    push.scroll_into_view_if_needed()
    desk.drag(push, -120, 0, beside)
    place = desk.place("sos-arm")
    assert 0.2 < place["a"] < 0.95 and place["s"] == 1
    assert f"pushed at {place['a']:g} m" in element.locator("svg").first.get_attribute(
        "aria-label"
    )


# ---------------------------------------------------------- noises (chapter 36)
def test_an_encoder_s_worth_is_that_of_the_grid(desk):
    """Less noise and a further encoder never hurt; the page takes the right entry."""
    data = desk.data("sos-noises")
    grid, least = data["grid"], {k: np.array(v) for k, v in data["least"].items()}
    both = least["both"]
    assert np.allclose(np.diff(np.log10(grid)), 2 / (len(grid) - 1), atol=1e-3)
    for values in (*both, *both.T, least["motor"], least["load"]):
        assert (np.diff(values) >= -1e-4 * values[1:]).all()
    alone = np.minimum(least["motor"][:, None], least["load"])
    assert (both <= 1.0001 * alone).all() and (both < 0.99 * alone).any()
    cells = [(0, 6), (6, 0), (2, 3), (5, 5)]
    places = [{"motor": grid[i], "load": grid[j]} for i, j in cells]
    for (i, j), found in zip(cells, desk.compute("sos-noises", places), strict=True):
        wanted = least["motor"][i], least["load"][j], both[i, j]
        assert (found["motor"], found["load"], found["both"]) == wanted
