"""What stands below an element stays, without blank room, as controls move."""

import re

import pytest

from sosbook.book.elements.page import whole
from sosbook.book.notebooks import BOOK
from tests.test_page_elements import TAGS, first_and_all

pytestmark = pytest.mark.skipif(
    not BOOK.exists(), reason="the package without its book"
)
#: Width of the window, and of the column in it: of a desk's screen, and of a phone.
WIDTHS = (1280, 740), (390, 358)
FEW = 3  # places of a control in the gate
#: Nobody answers before the empty element has been looked at, however fast the machine.
HELD = """<script>
let held = [];
Worker = class extends Worker {
  postMessage(...parts) {
    const send = () => super.postMessage(...parts);
    if (held) held.push(send);
    else send();
  }
};
const release = () => { const all = held; held = null; all.forEach(send => send()); };
</script>"""
#: Over a sweep of every control {y of foot and ruler: where they were there first}, and
#: [request, answer] of what was solved: what is known already isn't solved again.
SWEEP = """async ([tag, count, known]) => {
  const e = document.querySelector(tag), foot = document.querySelector("#foot");
  const wait = ms => new Promise(done => setTimeout(done, ms)), seen = {};
  const until = async holds => {   // an answer that is known comes without a pause
    for (let k = 0; !holds(); k++) {
      if (k === 3000) throw new Error(`never holds: ${holds}`);
      await (k < 20 ? null : wait(4));
    }
  };
  const solved = () => e.answer?.digest === e.digest;
  const answers = new Map(known), ask = e.solver?.ask;
  if (ask) e.solver.ask = async (key, kind, request) => {
    const text = JSON.stringify([kind, request]);
    if (kind === "move") e.solver.cancel(key);
    const answer = answers.get(text) ?? await ask(key, kind, request);
    if (answer) answers.set(text, answer);
    return answer;
  };
  const note = where => {
    const tops = [foot, e.find("ruler")].map(x => x?.getBoundingClientRect().top);
    seen[tops.map(top => top + scrollY)] ??= where;
  };
  note("empty");
  release();
  if (e.solve) await until(solved);
  note("start");
  const ruler = e.find("ruler").querySelector("input"), choice = "[data-choice]";
  const sweep = async (key, input, kind, begin) => {
    const before = input.value;
    const [low, high] = kind === "number" ? [Number(input.min), Number(input.max)]
                                         : [0, input.options.length - 1];
    const steps = Math.min(count, high - low);
    const put = async value => {
      begin?.();
      input.value = value;
      input.dispatchEvent(new Event("input", {bubbles: true}));
      note(`${key} at ${value}, at once`);
      if (e.solve) await until(solved); else await wait(0);
      note(`${key} at ${value}`);
    };
    for (let k = 0; k <= steps; k++) {
      await put(Math.round(low + (high - low) * k / steps));
      if (e.answer?.status === "infeasible" && k % 4 === 0) {
        await until(() => e.offers);
        note(`${key} with advice`);
      }
    }
    await put(before);
  };
  const keys = (list, name) => [...e.find("say").querySelectorAll(list)].map(
    x => [x.dataset[name], () => e.find(`say [data-${name}="${x.dataset[name]}"]`)]);
  for (const [key, number] of keys(".sos-num", "slot"))
    await sweep(key, ruler, "number", () => number().focus());
  if (tag !== "sos-bench")  // another choice, another form
    for (const [key, select] of keys(`select${choice}`, "choice"))
      await sweep(key, select(), "choice");
  return [seen, [...answers]]; }"""
#: Pixels between the readout's last line and its end.
BLANK = """tag => {
  const box = document.querySelector(tag + " .sos-readout");
  const {bottom} = box.getBoundingClientRect(), words = document.createRange();
  words.selectNodeContents(box);
  const last = words.getBoundingClientRect().bottom;
  return bottom - last - parseFloat(getComputedStyle(box).paddingBottom); }"""


@pytest.mark.slow
@pytest.mark.parametrize("text, places", first_and_all(FEW, 9, 0))
def test_nothing_below_moves_while_a_control_does(visit, tmp_path, text, places):
    """All is laid out and nothing painted: nobody looks at the pixels. One width for
    each kind, by turns; both once a week.
    """
    sheet, known = tmp_path / "sheet.html", []
    tag = re.match(r"<(sos-\w+)", text)[1]
    turn = TAGS.index(tag) % 2
    for window, column in WIDTHS if places > FEW else WIDTHS[turn : turn + 1]:
        sheet.write_text(
            '<!doctype html><html lang="en"><meta charset="utf-8"><title>t</title>'
            '<meta name="viewport" content="width=device-width">'
            '<link rel="icon" href="data:,">'
            f"<style>body {{margin: 16px; width: {column}px; visibility: hidden}}"
            f'</style>{HELD}{whole(text)}<p id="foot">foot',
            "utf8",
        )
        tab = visit(sheet, width=window)
        seen, known = tab.page.evaluate(SWEEP, [tag, places, known])
        assert len(seen) == 1, (window, seen)
        assert tab.page.evaluate(BLANK, tag) < 60
        assert tab.errors == []
