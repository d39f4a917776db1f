"""What stands below an element stays, without blank room, as controls move."""

import re

import pytest

from sosbook.book.notebooks import BOOK
from tests.test_page_elements import first_and_all

pytestmark = pytest.mark.skipif(
    not BOOK.exists(), reason="the package without its book"
)
#: Width of the window, and of the column in it: of a desk's screen, and of a phone.
WIDTHS = (1280, 740), (390, 358)
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
#: Over a sweep of every control {y of the foot: where it was seen there first}, and
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
  const note = where => { seen[foot.getBoundingClientRect().top + scrollY] ??= where; };
  note("empty");
  release();
  if (e.solve) await until(solved);
  note("start");
  const plants = tag === "sos-bench" ? "" : ", select[data-key]";  // another form
  const controls = `input[type=range]:enabled${plants}`;
  for (const input of e.view.querySelectorAll(controls)) {
    const before = input.value, choice = input.localName === "select";
    const last = choice ? input.options.length - 1 : Number(input.max);
    const snaps = choice || (input.step !== "any" && Number(input.step) >= 1);
    const steps = snaps ? Math.min(count, last / (Number(input.step) || 1)) : count;
    const put = async value => {
      input.value = value;
      input.dispatchEvent(new Event("input", {bubbles: true}));
      note(`${input.dataset.key} at ${value}, at once`);
      if (e.solve) await until(solved); else await wait(0);
      note(`${input.dataset.key} at ${value}`);
    };
    for (let k = 0; k <= steps; k++) {
      await put(snaps ? Math.round(last * k / steps) : last * k / steps);
      if (e.answer?.status === "infeasible" && k % 4 === 0) {
        await until(() => e.offers);
        note(`${input.dataset.key} with advice`);
      }
    }
    await put(before);
  }
  return [seen, [...answers]]; }"""
#: Pixels between the readout's last line and its end.
BLANK = """tag => {
  const box = document.querySelector(tag + " .sos-readout");
  const {bottom} = box.getBoundingClientRect(), words = document.createRange();
  words.selectNodeContents(box);
  const last = words.getBoundingClientRect().bottom;
  return bottom - last - parseFloat(getComputedStyle(box).paddingBottom); }"""


@pytest.mark.slow
@pytest.mark.parametrize("text, places", first_and_all(5, 9))
def test_nothing_below_moves_while_a_control_does(visit, tmp_path, text, places):
    """All is laid out and nothing painted: nobody looks at the pixels."""
    sheet, known = tmp_path / "sheet.html", []
    tag = re.match(r"<(sos-\w+)", text)[1]
    for window, column in WIDTHS:
        sheet.write_text(
            '<!doctype html><html lang="en"><meta charset="utf-8"><title>t</title>'
            '<meta name="viewport" content="width=device-width">'
            '<link rel="icon" href="data:,">'
            f"<style>body {{margin: 16px; width: {column}px; visibility: hidden}}"
            f'</style>{HELD}{text}<p id="foot">foot',
            "utf8",
        )
        tab = visit(sheet, width=window)
        seen, known = tab.page.evaluate(SWEEP, [tag, places, known])
        assert len(seen) == 1, (window, seen)
        assert tab.page.evaluate(BLANK, tag) < 60
        assert tab.errors == []
