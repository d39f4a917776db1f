"""Feasibility maps in the rendered page: pick two requirements, read the proof.

A page has no Python behind it, so the proofs come with it: the staircase of
every `Frontier`, its certified designs and what excludes the rest.
"""

import html
import json
from importlib.resources import files

import numpy as np

from ...studies.maps.search import requirements, round_numbers
from .designs import BLOCKS, _block, _digits

__all__ = ["MapAtlas"]


class MapAtlas:
    """A page element that shows frontiers; put it last in a cell.

    Parameters
    ----------
    frontiers : dict
        From a heading, as "Example 1", to its `Frontier` objects.
    title : str

    Raises
    ------
    ValueError
        If there is no frontier.
    """

    def __init__(self, frontiers, title="Feasibility maps"):
        if not frontiers or not all(len(f) for f in frontiers.values()):
            raise ValueError("frontiers must name one Frontier or more for "
                             'each heading: {"Robot": [frontier, ...]}')
        self.title = title
        self.frontiers = {k: tuple(f) for k, f in frontiers.items()}
        blocks = list(BLOCKS)
        groups = [{"name": name, "maps": [_map(f, blocks) for f in group]}
                  for name, group in self.frontiers.items()]
        self.data = {"title": title, "blocks": blocks, "groups": groups}

    def __repr__(self):
        count = sum(len(group) for group in self.frontiers.values())
        return f"MapAtlas: {count} frontiers"

    def _repr_html_(self):
        return self.html

    @property
    def html(self):
        """The element: style, data and script inline, no other file."""
        assets = files(__package__) / "assets"
        style = (assets / "atlas.css").read_text("utf8")
        style = style.replace("sos-atlas", "sos-map")
        style += (assets / "map.css").read_text("utf8")
        script = (assets / "map.js").read_text("utf8").strip()
        data = json.dumps(self.data, ensure_ascii=False,
                          separators=(",", ":"), allow_nan=False)
        data = data.replace("<", "\\u003c")
        return (
            f'<sos-map role="group" aria-label="{html.escape(self.title)}">'
            f"<style>{' '.join(style.split())}</style>"
            "<noscript>Maps of solved requests. They need JavaScript; in "
            "JupyterLab, trust the notebook (View → Activate Command "
            "Palette → Trust Notebook) and run the cell, or open the book "
            "with python3 tasks.py lab.</noscript>"
            f'<script type="application/json">{data}</script>'
            f"</sos-map>\n<script>\n{script}\n</script>")


def _map(frontier, blocks):
    """What the page needs to know of a frontier; new blocks join the list."""
    x, y = map(frontier.parameter, (frontier.x, frontier.y))
    designs, refusals = [], []
    rows = []
    for e in frontier.edges:
        rows.append([
            _side(y, e.feasible), _side(y, e.infeasible),
            _index(designs, e.design), _index(refusals, e.excluded),
        ])
    weights = {id(e.excluded): e.shares for e in frontier.edges
               if e.design is not None and e.excluded is not None}
    asked = requirements(frontier.request)
    which = {name: frontier.parameter(name) for name in asked}
    return {
        "x": _axis(x, frontier.values),
        "y": _axis(y, _steps(frontier, y)),
        "asked": [_side(p, asked[p.key]) for p in (x, y)],
        "held": [which[name].text(value) for name, value in asked.items()
                 if name not in (frontier.x, frontier.y)],
        "rows": rows,
        "shape": _shape(frontier.request),
        "designs": [_design(d, (x, y), blocks) for d in designs],
        "refusals": [
            _words(d, (x, y)) | {"shares": [
                [which[name].label, round(100 * share)]
                for name, share in sorted(
                    weights.get(id(d), {}).items(), key=lambda p: -p[1])
                if share >= 0.005
            ]} for d in refusals
        ],
    }


def _axis(which, values):
    return {"key": which.key, "label": which.label, "symbol": which.symbol,
            "unit": which.unit, "harder": which.harder,
            "values": [_side(which, v) for v in values]}


def _steps(frontier, which):
    """Round numbers of y around the staircase, hardest last."""
    known = [v for v in (*frontier.feasible, *frontier.infeasible,
                         requirements(frontier.request)[frontier.y])
             if np.isfinite(v)]
    low, high = min(known) / 1.3, max(known) * 1.3
    steps = round_numbers(which, low, high, frontier.digits)
    thin = -(-len(steps) // 80)
    return steps[::thin]


def _side(which, value):
    return None if value is None else _digits(which.shown(value), 6)


def _index(found, design):
    if design is None:
        return None
    places = [k for k, other in enumerate(found) if other is design]
    if not places:
        found.append(design)
    return places[0] if places else len(found) - 1


def _shape(request):
    n = request.plant.n
    return [n, request.plant.m, request.order - 2 * n]


def _words(design, axes):
    asked = requirements(design.request)
    return {"asked": ", ".join(p.text(asked[p.key]) for p in axes)}


def _design(design, axes, blocks):
    worst = min(design.margins, key=design.margins.get)
    return _words(design, axes) | {
        "K": [_digits(x, 4) for x in design.K.ravel()],
        "block": _block(worst, design.request, blocks),
    }
