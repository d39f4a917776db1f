"""What stands below an element stays where it is while its controls are moved."""

import re

import pytest

from sosbook.book.notebooks import BOOK
from tests.test_page_elements import stored

pytestmark = pytest.mark.skipif(
    not BOOK.exists(), reason="the package without its book"
)
PLACES = 5  # of each control
#: Width of the window, and of the column in it.
WIDTHS = {"desktop": (1280, 740), "phone": (390, 358)}
#: {y of the foot: where it was seen there first}, over a sweep of every control.
SWEEP = """async ([tag, count]) => {
  const e = document.querySelector(tag), foot = document.querySelector("#foot");
  const wait = ms => new Promise(done => setTimeout(done, ms)), seen = {};
  const until = async holds => {
    for (let k = 0; k < 1000 && !holds(); k++) await wait(10);
  };
  const solved = () => e.answer?.values.every((v, k) => v === e.values[k]);
  const note = where => { seen[foot.getBoundingClientRect().top + scrollY] ??= where; };
  note("empty");
  if (e.solve) await until(solved);
  note("start");
  const controls = "input[type=range]:enabled, select[data-key]";
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
        await until(() => e.edges);
        note(`${input.dataset.key} with advice`);
      }
    }
    await put(before);
  }
  return seen; }"""


@pytest.mark.slow
@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize(
    "text", [text for _, text in stored()], ids=[stem for stem, _ in stored()]
)
def test_nothing_below_moves_while_a_control_does(visit, tmp_path, text, width):
    window, column = WIDTHS[width]
    sheet = tmp_path / "sheet.html"
    sheet.write_text(
        '<!doctype html><html lang="en"><meta charset="utf-8"><title>t</title>'
        '<meta name="viewport" content="width=device-width">'
        '<link rel="icon" href="data:,">'
        f'<body style="margin: 16px; width: {column}px">{text}<p id="foot">foot',
        "utf8",
    )
    tab = visit(sheet, width=window)
    tag = re.match(r"<(sos-\w+)", text)[1]
    seen = tab.page.evaluate(SWEEP, [tag, PLACES])
    assert len(seen) == 1, seen
    assert tab.errors == []
