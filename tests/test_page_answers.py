"""What an element shows answers what its controls ask, whatever readers do.

After random moves of every control whatever answers another question must be marked,
its downloads gone. Settings are read from the controls themselves.
"""

import re
from urllib.parse import quote

import pytest

from sosbook.book.elements.scripts import script
from sosbook.book.notebooks import BOOK
from tests.cases import later
from tests.elements import write_page
from tests.test_page_elements import FIRST, TAGS, first_and_all

pytestmark = pytest.mark.skipif(
    not BOOK.exists(), reason="the package without its book"
)
#: Texts for the fields of a plant: some fit, some don't.
TEXTS = ["1 0; 0 1", "2 0\n0 3", "1", "", "0.1 -0.1; -0.1 0.1", "1 0", "1,5", "x"]
#: How many moves, and what was seen that is false: [faults, settings, settings with an
#: answer that isn't marked].
DRIVE = """async ([tag, seed, moves, texts]) => {
  const e = document.querySelector(tag), {view} = e, faults = new Set();
  const uniform = () => {
    seed = (seed + 0x6D2B79F5) | 0;
    let t = Math.imul(seed ^ (seed >>> 15), 1 | seed);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
  const whole = count => Math.floor(uniform() * count);
  const all = words => [...view.querySelectorAll(words)].filter(part =>
    !part.closest("[inert]") && !part.disabled && part.checkVisibility());
  const wait = ms => new Promise(done => setTimeout(done, ms));
  const until = async holds => {
    for (let k = 0; !holds(); k++) {
      if (k === 15000) throw new Error(`never holds: ${holds}`);
      await wait(4);
    }
  };
  // what the controls show, and what was asked when a button was pressed
  const setting = () => JSON.stringify([...view.querySelectorAll(
    "input:not(.sos-slow input, .sos-ruler input), select, textarea")].map(part =>
    part.type === "checkbox" ? part.checked
      : part.matches(".sos-field[hidden] textarea") ? null : part.value));
  const pressed = {html: "", setting: ""}, told = new Map(), sync = !e.solver;
  const marked = part => part.closest(".sos-old, .sos-locked");
  const solved = () => sync || e.answer?.digest === e.digest ||
    view.querySelector(".sos-locked");

  function check(after) {
    const now = setting(), fault = words => faults.add(`${words}, after ${after}`);
    for (const part of view.querySelectorAll(".sos-readout, .sos-more, .sos-panel")) {
      const empty = part.matches(".sos-panel") ? !part.querySelector("svg")
        : !part.textContent.trim();
      if (empty || marked(part)) continue;
      if (!part.dataset.digest || part.dataset.digest !== e.digest)
        fault(`${part.className} has another digest`);
    }
    const more = view.querySelector(".sos-more");
    if (more && more.innerHTML !== pressed.html) {   // an answer to the last button
      pressed.html = more.innerHTML;
      pressed.asked = pressed.setting;
    }
    if (more?.innerHTML && !marked(more) && pressed.asked !== now)
      fault("what a button answered stands under another setting");
    for (const link of view.querySelectorAll("a[download]"))
      if (marked(link) && link.checkVisibility({visibilityProperty: true}))
        fault("a download of another setting");
    const code = view.querySelector("pre");
    if (code?.textContent.startsWith("import") && !marked(code)
      && code.textContent !== e.program) fault("code of another setting");
    const readout = view.querySelector(".sos-readout");
    if (sync && tag !== "sos-robot" && !marked(readout)) {   // its pushes: no control
      const said = readout.textContent + [...view.querySelectorAll("svg")].map(
        svg => svg.getAttribute("aria-label"));
      if ((told.get(now) ?? said) !== said) fault("one setting, two answers");
      told.set(now, said);
    }
    const html = view.innerHTML.replace(/<textarea.*?<.textarea>/gs, "");
    const [strange] = /NaN|undefined|\\bInfinity|\\[object/.exec(html) || [];
    if (strange) fault(strange);
  }

  function move(part) {
    const fire = (kind, Kind = Event, more = {}) =>
      part.dispatchEvent(new Kind(kind, {bubbles: true, ...more}));
    if (part.localName === "button" || part.type === "checkbox") {
      pressed.setting = setting();
      pressed.html = "";   // the same answer again is a new one
      part.click();
      if (part.type === "checkbox") return part.dataset.wanted;
      return part.textContent;
    }
    if (part.matches("textarea, [type=text]")) part.value = texts[whole(texts.length)];
    else if (part.localName === "select") part.value = whole(part.options.length);
    else if (uniform() < 0.3) {
      const key = ["ArrowLeft", "ArrowRight", "PageUp"][whole(3)];
      if (fire("keydown", KeyboardEvent, {key, cancelable: true}))
        part.value = Number(part.value) + (key === "ArrowLeft" ? -1 : 1);
      else return key;
    } else {
      fire("pointerdown", PointerEvent);
      part.value = Number(part.max) * whole(4) / 3;   // places repeat
    }
    fire("input");
    if (part.type !== "range" || uniform() < 0.5) fire("change");
    if (part.type === "range" && uniform() < 0.1) fire("pointercancel", PointerEvent);
    return part.dataset.key ?? part.dataset.field;
  }

  await until(solved);
  check("the start");
  const buttons = () => all("button:not(.sos-measure, .sos-play, .sos-push)");
  const controls = () => all("input, select, textarea");
  const step = async (part, calm) => {
    const after = move(part);
    check(`${after}, at once`);
    if (calm) {
      await until(solved);
      await until(() => !view.textContent.includes("Computing with whole"));
    } else await wait(0);
    check(after);
  };
  const settings = new Set();
  for (let k = 0; k < buttons().length; k++) {   // each of them, and a move
    await step(buttons()[k], true);
    const sliders = all("input[type=range]");
    if (sliders.length) await step(sliders[k % sliders.length], k % 2);
    settings.add(setting());
  }
  for (let k = 0; k < moves; k++) {
    const list = uniform() < 0.35 ? buttons() : controls();
    if (list.length) await step(list[whole(list.length)], uniform() < 0.6);
    settings.add(setting());
  }
  const design = all(".sos-design")[0], example = all("[data-key=example]")[0];
  if (design && marked(view.querySelector(".sos-readout"))) {   // to one that fits
    example.value = 1;
    example.dispatchEvent(new Event("change", {bubbles: true}));
    all("[type=checkbox]").forEach(box => box.checked && box.click());
  }
  await until(solved);
  if (sync) await until(() => !marked(view.querySelector(".sos-readout")));
  buttons().find(x => x.textContent === "Link to this")?.click();
  const readout = view.querySelector(".sos-readout").textContent;
  return [[...faults], settings.size, setting(), sync ? readout : ""]; }"""
HERE = """([tag, sync]) => {
  const e = document.querySelector(tag), {view} = e;
  return [JSON.stringify([...view.querySelectorAll(
      "input:not(.sos-slow input, .sos-ruler input), select, textarea")].map(part =>
      part.type === "checkbox" ? part.checked
        : part.matches(".sos-field[hidden] textarea") ? null : part.value)),
    sync ? view.querySelector(".sos-readout").textContent : "",
    view.querySelector(".sos-more")?.textContent ?? ""]; }"""


@pytest.mark.parametrize("text, moves", first_and_all(5, 200, 1))
def test_whatever_is_shown_answers_what_is_asked(visit, tmp_path, text, moves):
    sheet, tag = tmp_path / "sheet.html", re.match(r"<(sos-\w+)", text)[1]
    write_page(sheet, text)
    tab = visit(sheet)
    faults, settings, setting, readout = tab.page.evaluate(
        DRIVE, [tag, 11, moves, TEXTS]
    )
    assert faults == []
    assert settings > 1 or tag == "sos-digits"
    assert tab.errors == []
    if "#" in tab.page.url:  # what was linked comes back, and nothing is left out
        copy = visit(tab.page.url)
        assert copy.page.evaluate(HERE, [tag, bool(readout)]) == [setting, readout, ""]
        assert copy.errors == []


WORDS = ["1,5", "-9e9", "0x1", "", "x", "1e999", "<b>"]


@pytest.mark.parametrize(
    "tag, turns",  # each sixth kind hears half of the words; all once a week
    [
        *((tag, [k // 6 % 2]) for k, tag in enumerate(TAGS) if k % 6 == 0),
        *later(*((tag, [0, 1]) for tag in TAGS)),
    ],
)
def test_what_an_address_asks_in_vain_is_said(visit, tmp_path, tag, turns):
    """Nothing of it is taken for a number or brought into a range in silence."""
    sheet = write_page(tmp_path / "sheet.html", FIRST[tag])
    tab, ask = visit(sheet), f"document.querySelector('{tag}')"
    start = tab.page.evaluate(f"Object.entries({ask}.address)")
    free = {*"MDSBFU", "lines", "words"}  # texts: tests/test_bench, _own_theorem
    keys = [key for key, _ in start if key not in free]
    for turn in turns:
        asked = [(key, WORDS[(k + turn) % 7]) for k, key in enumerate([*keys, "wings"])]
        tab.page.goto("about:blank")
        words = "&".join(f"{key}={word}" for key, word in asked)
        tab.page.goto(f"{sheet.as_uri()}#{tag}-1:{words}")
        said = tab.page.locator(".sos-more").first.inner_text()
        assert all(f"{key} = {word}" in said for key, word in asked)
        ends = [key for key, word in asked if word == "-9e9"]  # of a slider, and said
        now = tab.page.evaluate(f"Object.entries({ask}.address)")
        assert [x for x in now if x[0] not in ends] == [
            x for x in start if x[0] not in ends
        ]
    here = "&".join(f"{key}={quote(str(value))}" for key, value in start)
    tab.page.evaluate(f"location.hash = {f'#{tag}-1:{here}'!r}")  # a link, pasted
    tab.page.wait_for_function(f"{ask}?.find('more').textContent === ''")
    assert tab.page.evaluate(f"Object.entries({ask}.address)") == start
    assert tab.errors == []


def test_half_an_answer_of_the_package_is_none(browser):
    """What isn't JSON, or answers something else, leaves the question open."""
    page, errors = browser.new_page(), []
    page.on("pageerror", lambda e: errors.append(str(e)))
    page.set_content(
        '<div id="home"><div class="sos-question"><textarea></textarea></div>'
        '<div class="sos-answer"></div></div>'
    )
    page.add_script_tag(content=script("line"))
    heard = page.evaluate(
        """async () => {
      const heard = [], home = document.querySelector("#home");
      const alone = () => heard.push("alone");
      const line = sosModules.line.line(home, () => alone)(x => heard.push(x));
      line({id: 7});
      for (const text of ['{"id": 7', "null", "[7]", '{"id": 6}', '{"id": 7}']) {
        home.querySelector(".sos-answer").textContent = text;
        await new Promise(done => setTimeout(done, 20));
      }
      return heard; }"""
    )
    assert heard == [{"id": 7}] and errors == []
    page.close()
