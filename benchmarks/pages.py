"""A move of a slider in the rendered page, in a headless Chromium."""

import numpy as np

from sosbook.book import thesis
from sosbook.book.elements.explorer import design_explorer
from sosbook.requirements.hinf import HInfinity
from tests import browser as chromium

from .records import record, summary
from .run import machine

NAME = "sosbook, slider move in the page"
SHARE = 0.2  # of its printed value, by which each slider goes up and down
MEASURE = """async share => {
  const e = document.querySelector("sos-wish"), moves = 60;
  const times = [], solver = [];
  for (const [key, value] of Object.entries(e.named)) {
    for (let move = 0; move < moves; move++) {
      const from = performance.now();
      const there = value * (1 + share * Math.sin(2 * Math.PI * move / moves));
      e.bounds[key] = key === "theta" ? Math.min(there, 90) : there;
      await e.solve();
      times.push(performance.now() - from);
      solver.push(e.answer?.ms);
      await new Promise(requestAnimationFrame);
    }
    e.set({[key]: value});
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
            page.wait_for_function("document.querySelector('sos-wish')?.answer")
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
    """A wish as an example prints it."""
    return design_explorer(
        example.plant,
        example.U,
        region=example.region,
        gamma=HInfinity(example.gamma, mu=1.0),
        saturation=example.saturation,
        K_A=example.K_A,
    )
