"""A move of a slider in the rendered page, in a headless Chromium."""

import numpy as np

from sosbook.book import thesis
from sosbook.book.elements.explorer import design_explorer
from tests import browser as chromium

from .records import record, summary
from .run import machine

NAME = "sosbook, slider move in the page"
SHARE = 0.2  # of its printed value, by which each slider goes up and down
MEASURE = """async share => {
  const e = document.querySelector("sos-explorer"), moves = 60;
  const times = [], solver = [], begin = [...e.values];
  for (const [k, value] of begin.entries()) {
    for (let move = 0; move < moves; move++) {
      const from = performance.now();
      e.put(k, value * (1 + share * Math.sin(2 * Math.PI * move / moves)));
      await e.solve();
      times.push(performance.now() - from);
      solver.push(e.answer?.ms);
      await new Promise(requestAnimationFrame);
    }
    e.set(k, value);
  }
  return {times, solver}; }"""


def moves():
    """Records of the page's sliders, for Examples 1 to 3 with all requirements.

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
        for k in (1, 2, 3):
            example = getattr(thesis, f"example_{k}")()
            plant = example.plant
            page.set_content(f"<!doctype html>{_explorer(example).html}")
            page.wait_for_function("document.querySelector('sos-explorer')?.answer")
            for _ in range(2):
                found = page.evaluate(MEASURE, SHARE)
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


def _explorer(example):
    """Sliders around what is printed of an example."""
    region, limit = example.region, example.saturation
    printed = {name: getattr(region, name) for name in ("sigma", "theta", "rho")}
    printed |= {"gamma": example.gamma, "u_max": limit.u_max}
    given = {"K_A": example.K_A, "mu": 1.0}
    ends = {key: (x * (1 - SHARE), x * (1 + SHARE)) for key, x in printed.items()}
    ends["theta"] = (ends["theta"][0], min(ends["theta"][1], np.pi / 2))
    return design_explorer(
        example.plant, example.U, saturation=limit, start=printed, **given, **ends
    )
