"""A move of a slider in the rendered page, in a headless Chromium."""

import numpy as np

import sosbook as sos
from sosbook.book.elements.stopwatch import NAMES, stopwatch
from tests import browser as chromium

from .records import record, summary
from .run import machine

NAME = "sosbook, slider move in the page"
MEASURE = """async k => {
  const e = document.querySelector("sos-stopwatch"), choice = e.querySelector("select");
  choice.value = k;
  choice.dispatchEvent(new Event("change"));
  await new Promise(done => setTimeout(done, 1500));
  await e.measure();
  return e.measure(); }"""


def moves():
    """Records of the page's sliders, for the examples of the stopwatch.

    The whole time from a move to the new picture's markup; the second of two rounds.
    Without a Chromium there are none.
    """
    path = chromium.find()
    if path is None:
        return
    from playwright.sync_api import sync_playwright

    with sync_playwright() as engine:
        window = engine.chromium.launch(**chromium.options(path))
        where = f"Chromium {window.version}, {machine()['cpu']}"
        page = window.new_page()
        page.set_content(f"<!doctype html>{stopwatch().html}")
        for place, k in enumerate(NAMES):
            plant = getattr(sos.thesis, f"example_{k}")().plant
            found = page.evaluate(MEASURE, str(place))
            whole, solver = (np.array(found[key]) for key in ("times", "solver"))
            yield record(
                family="page",
                case=f"example {k}, every slider",
                n=plant.n,
                vertices=len(plant.vertices),
                competitor=NAME,
                clock="slider move",
                note=where,
                status="right",
                count=len(whole),
                share_solver=float(np.median(solver / whole)),
                share_drawing=float(np.median(1 - solver / whole)),
                **summary((whole / 1000).tolist()),
            )
        window.close()
