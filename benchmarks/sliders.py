"""What a reader waits for: slider moves, refusals, advice, exact proofs."""

import time

import numpy as np

import sosbook as sos
from sosbook.book import thesis
from sosbook.studies.maps.search import requirements
from sosbook.synthesis.request import Request

from .clock import cpu
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


def answers(example, count=15):
    """Records of a design, a known gain, a refusal, with advice too, and a proof.

    CPU seconds of one call each, in turns: their ratios hold on other machines.
    Refused is a tenth of the printed gamma; a refusal has its exact proof.
    """
    given = getattr(thesis, f"example_{example}")()
    plant, asked = given.plant, given.requirements
    impossible = asked | dict(gamma=sos.HInfinity(given.gamma / 10, mu=1.0))
    design = sos.design_pid(plant, **asked)

    def refuse():
        return sos.design_pid(plant, **impossible)

    rows = {
        "a design": (lambda: sos.design_pid(plant, **asked).K, np.size),
        "a known gain": (lambda: sos.analyse_pid(plant, design.K, **asked).K, np.size),
        "refusal": (lambda: refuse().infeasibility, lambda c: bool(c and c.proven)),
        "refusal with advice": (lambda: refuse().advice, bool),
        "exact proof of a design": (design.certify, lambda c: c.proven),
    }
    times, good = {name: [] for name in rows}, {}
    for k in range(-1, count):  # one to warm up
        for name, (call, right) in rows.items():
            begin = cpu()
            found = call()
            times[name] += [cpu() - begin] * (k >= 0)
            good[name] = right(found)
    for name, some in times.items():
        yield record(
            family="answers",
            case=f"example {example}, answers",
            n=plant.n,
            vertices=len(plant.vertices),
            competitor=f"sosbook, {name}",
            clock="CPU seconds of one call",
            status="right" if good[name] else "wrong",
            **(summary(some) if good[name] else {}),
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
