"""What the page elements share: one kit, whichever of them stand on a page."""

import json
import re
from functools import cache

import pytest

from sosbook.book.elements import movers
from sosbook.book.elements.page import PageElement
from sosbook.book.notebooks import BOOK
from tests import layout
from tests.cases import by_turns, later
from tests.conftest import Tab
from tests.elements import (
    assert_quiet,
    assert_readable,
    held,
    points,
    said,
    step,
    still,
    write_page,
)

KINDS = {"sos-delay", "sos-map", "sos-robot"}
pytestmark = pytest.mark.skipif(
    not BOOK.exists(), reason="the package without its book"
)


def _stored():
    for path in sorted(BOOK.glob("*.ipynb")):
        for cell in json.loads(path.read_text("utf8"))["cells"]:
            for output in cell.get("outputs", ()):
                text = "".join(output.get("data", {}).get("text/html", ""))
                if text.startswith("<sos-"):
                    yield path.stem, text


@cache
def stored():
    """(chapter, HTML) of the elements that the book shows, without their scripts."""
    return [*_stored()]


def test_noise_of_a_processor_is_in_no_turn_of_a_shaft():
    """Beside the largest value an angle of 1e-15 is zero; a level has few digits."""

    def move(k):
        return {
            "state": "feasible",
            "words": ["moved"],
            "turns": [[0, k, 0], [2e-15, -0.12345, 4e-15]],
            "line": [-4.77e-15, 0.99996, 0.5],
            "rules": [-0.1896425745879263, 0.1896425745879263],
        }

    grid = {"k": ("Angle", " rad", [1.2345, 2.2345], 1.2345)}
    shown = movers.shaft(
        *("Discs", "Turn.", "By {k}.", grid, move),
        captions={"scene": "Discs.", "curve": "A torque."},
        names={},
        seconds=1,
    )
    first = shown.data["settings"][0]
    assert first["turns"] == [[0, 1.23, 0], [0, -0.12, 0]]
    assert first["line"] == [0, 1, 0.5] and first["rules"] == [-0.19, 0.19]


#: The first element of each kind, by its tag.
FIRST = {re.match(r"<(sos-\w+)", text)[1]: text for _, text in reversed(stored())}
TAGS = sorted(FIRST)


def first_and_all(few, many, turn):
    """(HTML, few) for the first of each fourth kind, from ``turn`` on; (HTML, many) for
    all, once a week.
    """
    return [
        *(pytest.param(FIRST[tag], few, id=tag) for tag in TAGS[turn::4]),
        *(
            pytest.param(text, many, id=stem, marks=pytest.mark.campaign)
            for stem, text in stored()
        ),
    ]


@pytest.fixture
def tab(visit, tmp_path):
    """A page with an element of some kinds, and the first kind once more."""
    shown = [FIRST[tag] for tag in (*sorted(KINDS), "sos-delay")]
    return visit(write_page(tmp_path / "all.html", *shown))


def test_all_kinds_work_on_one_page(tab):
    views = tab.page.evaluate(
        """tags => tags.map(tag => [...document.querySelectorAll(tag)].map(
             e => [e.view.querySelectorAll("svg").length, e.name]))""",
        sorted(KINDS),
    )
    assert [len(v) for v in views] == [2, 1, 1]
    assert all(count for v in views for count, _ in v)
    assert len({name for v in views for _, name in v}) == 4
    ids = tab.page.evaluate("[...document.querySelectorAll('[id]')].map(e => e.id)")
    assert len(ids) == len(set(ids)) > 4
    assert tab.errors == []


def test_a_control_moves_its_own_element_only(tab):
    for tag in KINDS:
        before, after = tab.page.evaluate(
            """tag => {
          const all = [...document.querySelectorAll(Object.keys({
            "sos-delay": 1, "sos-map": 1, "sos-robot": 1}).join())];
          const said = () => all.map(e => e.view.textContent);
          const before = said();
          const input = document.querySelector(tag + " .sos-ruler input");
          input.value = input.value === input.max ? 0 : input.max;
          input.dispatchEvent(new Event("input", {bubbles: true}));
          return [before, said()]; }""",
            tag,
        )
        moved = [one != two for one, two in zip(before, after, strict=True)]
        assert sum(moved) == 1, tag
    assert tab.errors == []


@pytest.fixture(scope="module")
def sheet(tmp_path_factory):
    """A page with the first of every kind."""
    inside = "<main><h1>All</h1>", *FIRST.values(), "</main>"
    return write_page(tmp_path_factory.mktemp("shelf") / "all.html", *inside)


@pytest.fixture(scope="module")
def shelf(browser, sheet):
    """The page, that fingers can touch."""
    context = browser.new_context(reduced_motion="reduce", has_touch=True)
    context.add_init_script(layout.UNPAINTED)
    page, errors = context.new_page(), []
    page.on("pageerror", lambda e: errors.append(str(e)))
    page.goto(sheet.as_uri(), timeout=120_000)  # dozens of elements start
    yield page
    assert errors == []
    context.close()


@pytest.fixture
def alone(shelf, tag):
    """The shelf with all but one kind hidden: no step lays out the others."""
    style = f"main > :not({tag}, h1) {{content-visibility: hidden}}"
    sheet = shelf.add_style_tag(content=style)
    yield shelf
    sheet.evaluate("style => style.remove()")


@pytest.mark.parametrize("tag", by_turns(TAGS, 2, of=4))
def test_every_number_by_key_mouse_and_finger(alone, tag):
    """Each by arrows; the one that was taken last by the ruler, too."""
    numbers = alone.locator(f"{tag} .sos-num").all()
    assert numbers
    for number in numbers:
        before, name = number.input_value(), number.get_attribute("aria-label")
        step(number)
        assert name and number.input_value() != before
        assert number.get_attribute("aria-valuetext").startswith(number.input_value())
    ruler = alone.locator(f"{tag} .sos-ruler input")
    assert alone.locator(f"{tag} .sos-ruler label").inner_text() == name
    at = points(ruler, 0.2, 0.9)  # where it stays, whatever is said above it
    clicked = [alone.mouse.click(*point) or number.input_value() for point in at]
    tapped = [alone.touchscreen.tap(*point) or number.input_value() for point in at]
    assert clicked[0] != clicked[1] and tapped == clicked


#: {width: tops of the ruler} as each number takes its shortest and its longest text.
TOPS = """([tag, widths]) => {
  const e = document.querySelector(tag), ruler = e.find("ruler"), tops = {};
  const input = ruler.querySelector("input");
  for (const {dataset: {slot}} of e.querySelectorAll(".sos-num"))
    for (const part of [0, 0.4, 0.5, 1]) {
      e.find(`num[data-slot="${slot}"]`).focus();
      input.value = Number(input.min) + part * (input.max - input.min);
      input.dispatchEvent(new Event("input"));
      for (const width of widths) {
        e.style.width = `${width}px`;
        const far = ruler.getBoundingClientRect().top - e.getBoundingClientRect().top;
        (tops[width] ??= []).push(far);
      }
    }
  e.style.width = "";
  return Object.values(tops).map(list => Math.max(...list) - Math.min(...list)); }"""


#: How often an element asks for a layout as it says all anew, and how its room grows:
#: the heights of a readout with a long text, and with its own again.
LAID_OUT = """async tag => {
  const e = document.querySelector(tag), box = e.find("readout"), asked = [];
  const count = (kind, name, of) => {
    const own = Object.getOwnPropertyDescriptor(kind, name), f = own[of];
    const heard = {[of]() { asked.push(name); return f.apply(this, arguments); }};
    Object.defineProperty(kind, name, {...own, ...heard});
    return () => Object.defineProperty(kind, name, own);
  };
  const frame = () => new Promise(done =>
    requestAnimationFrame(() => requestAnimationFrame(done)));
  const back = [count(Element.prototype, "getBoundingClientRect", "value"),
    ...["offsetWidth", "offsetHeight"].map(
      name => count(HTMLElement.prototype, name, "get"))];
  if (e.say && e.answer) e.say(); else e.update?.();
  const moves = [...asked], text = box.innerHTML, high = () => box.offsetHeight;
  back.forEach(undo => undo());
  let long = 0;
  do {  // an answer that was still computed may be written over it
    box.innerHTML = "<p>long</p>".repeat(60);
    await frame();
    long = high();
  } while (!box.textContent.startsWith("long"));
  box.innerHTML = text;
  await frame();
  const after = high();
  e.reserve();
  return [moves, long, after]; }"""


@pytest.mark.parametrize("tag", ["sos-bench", "sos-delay", "sos-segment", "sos-wish"])
def test_a_move_asks_for_no_layout_and_its_room_grows(alone, tag):
    """The browser lays out once a frame; what is longer than all before makes room."""
    moves, long, after = alone.evaluate(LAID_OUT, tag)
    assert moves == []
    assert long == after > 600


@pytest.mark.parametrize("tag", ["sos-bench", "sos-wish"])
def test_a_ruler_stays_where_it_is_pressed(alone, tag):
    """Whatever the number and the verdict, no second click falls beside it."""
    alone.locator(f"{tag} .sos-reset").click()
    widths = [1264, *range(1200, 300, -130)]
    assert set(alone.evaluate(TOPS, [tag, widths])) == {0}


def test_every_element_has_a_task_and_its_answer():
    """The workbench's task stands on its page."""
    for stem, text in stored():
        data = json.loads(re.search(r"json\">(.*?)</script>", text, re.S)[1])
        assert data.get("hint") or text.startswith("<sos-bench"), stem
        assert data.get("answer") or text.startswith("<sos-bench"), stem
        if "grids" in data or text.startswith("<sos-landscape"):
            keys = [control["key"] for control in data["controls"]]
            assert sorted(re.findall(r"{(\w+)}", data["says"])) == sorted(keys), stem
            assert ": " not in data["says"], stem  # no list of labels


#: Elements whose answer leaves one of their plots as it is.
ALIKE = {"sos-wish", "sos-landscape", "sos-sensors"}
#: What the plots of an element tell; a scene shows what moves, whatever is asked.
PLOTS = """element => [...element.querySelectorAll(
  ".sos-panel > div:not(.sos-scene) > svg")].map(x => x.ariaLabel)"""


@pytest.mark.parametrize("tag", by_turns(TAGS, 3, of=4))
def test_the_answer_of_a_task_is_shown(alone, tag):
    button = alone.locator(f"{tag} .sos-answer")
    if not button.count():
        return
    alone.locator(f"{tag} .sos-reset").click()
    told = said(alone.locator(tag))
    before = alone.locator(tag).evaluate(PLOTS)
    button.click()
    held = "t => Object.entries(t.data.answer).every(([k, v]) => t.address[k] == v)"
    assert alone.locator(tag).evaluate(held)
    alone.wait_for_function(
        "([tag, said]) => { const e = document.querySelector(tag);"
        "  return e.querySelector('.sos-readout:not(.sos-old)') && said !== "
        "    `${e.find('say em').innerText} ${e.find('readout').innerText}`; }",
        arg=[tag, told],
    )
    after = alone.locator(tag).evaluate(PLOTS)
    assert tag in ALIKE or [x for x in before if x in after] == []


@pytest.mark.parametrize("tag", by_turns(TAGS, 0, of=4))
def test_a_swipe_gives_every_slider_back(shelf, tag):
    faults = shelf.evaluate(
        """tag => {
      const all = document.querySelectorAll(tag + " input[type=range]:enabled");
      return [...all].filter(input => {
        const fire = kind => input.dispatchEvent(kind), before = input.value;
        fire(new PointerEvent("pointerdown"));
        input.value = Number(input.value) > Number(input.max) / 2 ? 0 : input.max;
        fire(new Event("input"));
        fire(new PointerEvent("pointercancel"));
        return Math.abs(input.value - before) > 1e-9
          || getComputedStyle(input).touchAction !== "pan-y";
      }).length; }""",
        tag,
    )
    assert faults == 0


@pytest.fixture(scope="module")
def judged(shelf, axe):
    """The shelf with axe in it, which walks through all that is there."""
    shelf.add_script_tag(url=axe)
    assert shelf.evaluate(layout.AXE) == []
    return shelf, set()


@pytest.mark.parametrize(
    "tag, every",
    [*((x, False) for x in TAGS[1::4]), *later(*((x, True) for x in TAGS))],
)
def test_axe_has_no_objection_after_any_button(judged, tag, every):
    """With what each button brings: the first of its name, and an element's last; every
    one once a week. Contrast has tests of its own.
    """
    judged, names = judged
    judged.evaluate(
        "tag => { globalThis.all = [...document.querySelectorAll('main > *')];"
        "document.querySelector('main').replaceChildren("
        "...all.filter(e => [tag, 'h1'].includes(e.localName))); }",
        tag,
    )
    lasting = f"{tag} button:not([data-do^=offer])"  # an offer goes when it is taken
    buttons = judged.locator(lasting).all()
    for button in buttons:
        button.click()
        judged.wait_for_timeout(100)
        name = button.inner_text()
        if every or name not in names or button is buttons[-1]:
            names.add(name)
            assert judged.evaluate(layout.AXE) == [], name
    judged.evaluate("document.querySelector('main').replaceChildren(...all)")


#: Labels of the ruler that are cut, number after number.
CUT_LABELS = """const label = a.querySelector(".sos-ruler label");
return [...a.querySelectorAll(".sos-num")].filter(number => {
  number.focus();
  return label.scrollWidth > label.clientWidth ||
    label.scrollHeight > label.clientHeight + 1;
}).map(number => number.ariaLabel);"""


THUMBED = """all => all.filter(e => e.checkVisibility()).map(e => {
  const {width, height} = e.getBoundingClientRect();
  return [width, height]; })"""


def test_all_are_readable_in_light_and_dark_and_fit_a_phone(shelf):
    """None scrolls sideways, and a thumb hits every slider. To turn the page that is
    there takes half of opening another.
    """
    tab, size = Tab(shelf), shelf.viewport_size
    shelf.set_viewport_size({"width": 390, "height": 844})
    assert assert_readable(tab, TAGS) > 4 * len(TAGS)
    assert shelf.evaluate("document.documentElement.scrollWidth <= innerWidth")
    for tag in TAGS:
        sizes = shelf.locator(f"{tag} input[type=range]").evaluate_all(THUMBED)
        assert all(width > 250 and height >= 24 for width, height in sizes), tag
        assert held(tab, tag, CUT_LABELS) == [], tag
    assert tab.errors == []
    shelf.emulate_media(color_scheme="light")
    shelf.evaluate("delete document.documentElement.dataset.theme")
    shelf.set_viewport_size(size)


#: All have drawn and said what they start with, and what is solved is there.
STARTED = """() => [...document.querySelectorAll("main > *")].every(e =>
  e.querySelector("svg") && e.find("readout").textContent.trim() &&
  (!e.solver || e.answer?.digest === e.digest))"""


def test_every_element_of_the_book_starts_and_fits_a_phone(visit, tmp_path):
    """In silence; the first of each kind are on the shelf."""
    others = [text for _, text in stored() if text not in FIRST.values()]
    sheet = tmp_path / "others.html"
    write_page(sheet, "<main class='bd-article'>", *others, "</main>")
    tab = visit(sheet, width=390, height=844)
    tab.page.wait_for_function(STARTED)
    assert tab.page.locator("main > *").count() == len(others) > 15
    assert tab.page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    assert tab.page.evaluate(layout.LOOSE_READOUTS) == []
    assert tab.page.evaluate(layout.PROGRAM_UNITS) == []
    assert_quiet(tab)


def test_numbers_are_short_and_have_powers_of_ten(tab):
    numbers = [0, 0.00000989, -2.5e-7, 0.000123, 0.1234, 40000, 999999, 1.26e6, -3e12]
    shown = tab.page.evaluate("list => list.map(x => sosModules.kit.clean(x))", numbers)
    assert shown == ["0", "9.89·10⁻⁶", "−2.5·10⁻⁷", "0.000123", "0.123", "40000",
                     "1·10⁶", "1.26·10⁶", "−3·10¹²"]  # fmt: skip


def test_an_element_that_a_page_could_break_out_of_is_escaped():
    class Trap(PageElement):
        tag, title = "sos-trap", 'a</script><b>"&'
        data = {"title": title}

    text = Trap().html
    assert "</script><b>" not in text.replace("\\u003c", "")
    assert 'aria-label="a&lt;/script&gt;&lt;b&gt;&quot;&amp;"' in text


def test_a_place_is_measured_once_it_stands_still(visit, tmp_path):
    """A handle that is away at first, and moves while its picture is drawn anew."""
    script = """<div id="a"></div><script>let k = 0;
      const turn = () => { k++;
        const at = `position:absolute;left:${10 * k}px`;
        a.innerHTML = k % 2 ? "" : `<b style="${at}">x</b>`;
        if (k < 12) setTimeout(turn, 30); };
      turn();</script>"""
    tab = visit(write_page(tmp_path / "drawn.html", script))
    assert still(tab.page.locator("#a b"))["x"] == 120
    tab.page.evaluate("a.innerHTML = '<b hidden>x</b>'")
    with pytest.raises(AssertionError, match="doesn't stand still"):
        still(tab.page.locator("#a b"))
