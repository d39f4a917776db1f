"""Feasibility maps in the rendered page: pick two requirements, read the proof.

A page has no Python behind it, so the proofs come with it: the staircase of
every `Frontier`, its certified designs and what excludes the rest.
"""

import numpy as np

from ...studies.maps.search import requirements, round_numbers
from .page import PageElement, significant
from .program import program_data
from .records import BLOCKS, map_record


class MapAtlas(PageElement):
    """A page element that shows frontiers; put it last in a cell.

    Parameters
    ----------
    frontiers : dict
        The `Frontier` objects by their heading, such as "Example 1".
    title : str
        The heading of the element.

    Raises
    ------
    ValueError
        If there is no frontier.
    """

    tag, script, sheets = "sos-map", "map", ("map",)

    def __init__(self, frontiers, title="Feasibility maps"):
        if not frontiers or not all(len(f) for f in frontiers.values()):
            raise ValueError(
                "frontiers must name one Frontier or more for "
                'each heading: {"Robot": [frontier, ...]}'
            )
        self.title = title
        self.frontiers = {k: tuple(f) for k, f in frontiers.items()}
        blocks = list(BLOCKS)
        groups = [
            {"name": name, "maps": [_map(f, blocks) for f in group]}
            for name, group in self.frontiers.items()
        ]
        self.data = {"title": title, "blocks": blocks, "groups": groups}

    def __repr__(self):
        count = sum(len(group) for group in self.frontiers.values())
        return f"MapAtlas: {count} frontiers"


def _map(frontier, blocks):
    """The data of a frontier; new blocks join the list."""
    x, y = map(frontier.parameter, (frontier.x, frontier.y))
    designs, refusals, rows = [], [], []
    for e in frontier.edges:
        kept = _index(designs, e.design), _index(refusals, e.excluded)
        rows.append([_side(y, e.feasible), _side(y, e.infeasible), *kept])
    weights = {
        id(e.excluded): e.shares
        for e in frontier.edges
        if e.design is not None and e.excluded is not None
    }
    asked = requirements(frontier.request)
    which = {name: frontier.parameter(name) for name in asked}
    others = [name for name in asked if name not in (frontier.x, frontier.y)]

    def shares(d):
        largest_first = sorted(weights.get(id(d), {}).items(), key=lambda p: -p[1])
        found = [[which[name].label, round(x, 2)] for name, x in largest_first]
        return [pair for pair, (_, x) in zip(found, largest_first) if x >= 0.005]

    return {
        "x": _axis(x, frontier.values),
        "y": _axis(y, _steps(frontier, y)),
        "asked": [_side(p, asked[p.key]) for p in (x, y)],
        "held": [which[name].text(asked[name]) for name in others],
        "bounds": {name: _side(which[name], value) for name, value in asked.items()},
        "program": program_data(frontier.request),
        "rows": rows,
        "shape": _shape(frontier.request),
        "designs": [_asked(d, (x, y)) | map_record(d, blocks) for d in designs],
        "refusals": [_asked(d, (x, y)) | {"shares": shares(d)} for d in refusals],
    }


def _axis(which, values):
    names = "key", "label", "symbol", "unit", "harder"
    words = {name: getattr(which, name) for name in names}
    return words | {"values": [_side(which, v) for v in values]}


def _steps(frontier, which):
    """Round numbers of y around the staircase, hardest last."""
    asked = requirements(frontier.request)[frontier.y]
    bounds = np.array([*frontier.feasible, *frontier.infeasible, asked], float)
    bounds = bounds[np.isfinite(bounds)]
    low, high = float(min(bounds)) / 1.3, float(max(bounds)) * 1.3
    steps = round_numbers(which, low, high, frontier.digits)
    thin = -(-len(steps) // 80)
    return steps[::thin]


def _side(which, value):
    return None if value is None else significant(which.shown(value), 6)


def _index(kept, design):
    """A design's place in the list of those kept; a new one joins it."""
    if design is None:
        return None
    places = [k for k, old in enumerate(kept) if old is design]
    if not places:
        kept.append(design)
    return places[0] if places else len(kept) - 1


def _shape(request):
    n = request.plant.n
    return [n, request.plant.m, request.order - 2 * n]


def _asked(design, axes):
    asked = requirements(design.request)
    return {"asked": ", ".join(p.text(asked[p.key]) for p in axes)}
