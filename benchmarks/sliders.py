"""What a reader waits for: moves of a slider."""

import time

import numpy as np

import sosbook as sos
from sosbook.book import thesis
from sosbook.studies.maps.search import requirements
from sosbook.synthesis.request import Request

from .maps import keywords
from .records import record, summary

MOVES = 60


def moves(example, count=MOVES):
    """Records of the sliders of an example.

    Each slider goes from the printed value to a harder and an easier one
    and back, smoothly: value * (1 + 0.2 sin).
    """
    given = getattr(thesis, f"example_{example}")()
    request = Request(given.plant, **given.requirements)
    asked = requirements(request)
    ways = {"sosbook, slider move": False, "sosbook, slider move, warm start": True}
    found = {(way, name): [] for way in ways for name in asked}
    for name, value in asked.items():
        last = dict.fromkeys(ways)
        for k in range(-1, count):  # one to warm up
            factor = 1 + 0.2 * np.sin(2 * np.pi * k / count)
            moved = request.with_bounds(asked | {name: value * factor})
            for way, follow in ways.items():
                start = last[way] if follow else None
                row, design = _move(moved, start)
                last[way] = design if design.P is not None else last[way]
                if k >= 0:
                    found[way, name].append(row)
    plant = given.plant
    for (way, name), rows in found.items():
        whole, solver = np.array([r[:2] for r in rows]).T
        yield record(
            family="slider",
            case=f"example {example}, {name}",
            n=plant.n,
            vertices=len(plant.vertices),
            competitor=way,
            clock="slider move",
            note=f"{sum(r[2] for r in rows)} of {len(rows)} requests had a "
            "design; the rest were refused",
            status="right",
            count=len(rows),
            margin=min((r[3] for r in rows if r[2]), default=None),
            share_solver=float(np.median(solver / whole)),
            share_drawing=float(np.median(1 - solver / whole)),
            **summary(whole.tolist()),
        )


def _move(request, start):
    """(whole, solver, feasible, margin), and the design; its card is drawn."""
    begin = time.perf_counter()
    design = sos.design_pid(
        request.plant,
        **keywords(request),
        K_A=request.K_A,
        coupling=request.coupling.word,
        search=sos.Search(start=start),
    )
    solved = time.perf_counter()
    card = design._repr_html_()
    end = time.perf_counter()
    feasible = design.status == "feasible"
    if ("<svg" in card) != feasible:
        raise AssertionError("a design has a picture, a refusal none")
    smallest = min(design.margins.values()) if feasible else None
    return (end - begin, solved - begin, feasible, smallest), design
