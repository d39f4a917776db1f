"""Maps of many specifications at the price of a few.

Asking for more never turns an infeasible request feasible (chapter 15). So
the feasible cells of a map lie below a staircase: only cells along it are
looked at, those on both sides of it are solved, and a design that was found is
tried on the next cell first.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...requirements.vocabulary import Parameter
from ...runtime.time_limit import OutOfTime, checked_seconds
from ...runtime.time_limit import time_limit as limited
from ...solver.loop import margin
from .ask import Ask, again, point, seen
from .search import Search, certified, provably_refused, replaced

__all__ = ["FeasibilityMap", "feasibility_map"]

REUSE_MARGIN = 1e-4  # with which an easier cell's design serves a harder cell
TIME_LIMIT = 3600.0  # seconds


@dataclass(frozen=True, eq=False)
class FeasibilityMap:
    """Which of many specifications have a design, and why.

    Parameters
    ----------
    across, up : str
        Names of the two parameters.
    ways : tuple of Parameter
        The same, with their directions.
    x, y : (columns,), (rows,) arrays
        Their values.
    designs : dict
        The `Design` of a cell (row, column): those that ask for most. Each
        serves every cell that asks for no more.
    refusals : dict
        Those with status "infeasible" that ask for least; None
        where the region itself is empty. Each excludes every cell that
        asks for no less.
    solves : int
        How many requests were solved, or looked at for a point inside.
    """

    across: str
    up: str
    ways: tuple[Parameter, Parameter]
    x: np.ndarray
    y: np.ndarray
    designs: dict
    refusals: dict
    solves: int

    def __repr__(self):
        return (
            f"<FeasibilityMap: {self.up} over {self.across}, "
            f"{self.status.size} cells from {self.solves} solves>"
        )

    @property
    def feasible(self):
        """(rows, columns) array of bool."""
        return self._any(self.designs, -1)

    @property
    def infeasible(self):
        """(rows, columns) array of bool."""
        return self._any(self.refusals, 1)

    @property
    def status(self):
        """(rows, columns) array: "feasible", "infeasible", "undecided"."""
        return np.where(
            self.feasible,
            "feasible",
            np.where(self.infeasible, "infeasible", "undecided"),
        )

    @cached_property
    def proven(self):
        """(rows, columns) array of bool: which verdicts are theorems.

        Every design is certified, and the multipliers of every refusal
        repaired, in exact arithmetic. A cell is proven where one of
        those that pass decides it.
        """
        yes = {cell: d for cell, d in self.designs.items() if _certified(d)}
        no = [
            cell
            for cell, d in self.refusals.items()
            if d is None or _provably_refused(d, yes.values())
        ]
        return self._any(yes, -1) | self._any(no, 1)

    def _any(self, cells, way):
        """The cells that ask for no less (way 1), no more (way -1)."""
        covered = np.zeros((len(self.y), len(self.x)), bool)
        across, up = self.ways
        y = way * up.harder * np.asarray(self.y)
        x = way * across.harder * np.asarray(self.x)
        for i, j in cells:
            covered |= (y >= y[i])[:, None] & (x >= x[j])
        return covered


def feasibility_map(
    plant,
    U=None,
    region=None,
    gamma=None,
    saturation=None,
    *,
    across,
    up,
    time_limit=TIME_LIMIT,
    **options,
):
    """Which of many specifications have a design.

    Parameters
    ----------
    plant, U, region, gamma, saturation
        As in `design_pid`.
    across, up : (str, sequence of float)
        The two bounds that vary, with their values: "sigma", "theta"
        (in radians), "rho", "gamma", "u_max", "cost" or that of a
        requirement of your own.
    time_limit : float
        Seconds after which the cells that are left are "undecided".
    **options
        cost, requirements, K_A, coupling, mu and slack, for `design_pid`; without a
        word the coupling is "pairs", and with "auto" a refusal is one of slack
        matrices, too. Or a law, and starts and seed of its searches.

    Returns
    -------
    FeasibilityMap
        The map, with a proof for each cell that is decided.

    Raises
    ------
    ValueError
        If a name is unknown, what it needs isn't given, or its values
        aren't two or more positive numbers.

    Examples
    --------
    >>> import sosbook as sos
    >>> robot = sos.thesis.example_1()
    >>> grid = feasibility_map(
    ...     robot.plant, **robot.requirements,
    ...     across=("sigma", [0.5, 1.0, 1.5]),
    ...     up=("theta", np.radians([30, 60])))
    >>> grid.feasible
    array([[ True, False, False],
           [ True,  True,  True]])
    >>> bool(grid.proven.all())
    True
    """
    ask = Ask(
        plant, U, dict(region=region, gamma=gamma, saturation=saturation), options
    )
    if options.get("minimize") is not None:
        raise ValueError("minimize has no meaning in a map: leave it out")
    across, x = _axis("across", across, ask)
    up, y = _axis("up", up, ask)
    if across == up:
        raise ValueError(f'across and up are both "{up.key}": name two requirements')
    cells = _Cells(ask, across, x, up, y)
    seconds = checked_seconds(time_limit, needed=True)
    try:
        with limited(seconds):
            cells.walk()
    except OutOfTime:
        cells.keep_points()
    return cells.map()


class _Cells:
    """Solves cells and remembers what decides them."""

    def __init__(self, ask, across, x, up, y):
        self.ask, self.across, self.x, self.up, self.y = ask, across, x, up, y
        self.designs, self.refusals = {}, {}
        self.last = self.near = None  # the last design, and the last point inside
        self.trials, self.tried = {}, set()

    def walk(self):
        """Walk along the staircase, then solve what it left open.

        The walk starts where the longer axis asks for least and the shorter
        one for most. A feasible cell decides all easier ones, so the walk goes
        on along the longer axis; from a cell that isn't feasible it goes back
        along the shorter one. The last design of each line is solved. Then what
        isn't feasible is refused where that decides most: from the easiest line on.
        """
        rows = np.argsort(self.up.harder * self.y).tolist()
        columns = np.argsort(self.across.harder * self.x).tolist()
        lines = [[(i, j) for j in columns] for i in rows]
        if len(rows) > len(columns):
            lines = [[(i, j) for i in rows] for j in columns]
        begin, step = 0, 1
        for line in reversed(lines):
            end = self.end(line, begin, begin + step - 1)
            if end > begin:
                self.holds(line[end - 1])
            begin, step = end, max(end - begin, 1)
        cells = [cell for line in lines for cell in line]
        while (undecided := self.open()).any():
            self.holds(next(cell for cell in cells if undecided[cell]))

    def open(self):
        """The cells that are neither decided nor tried."""
        cells = self.whole().status == "undecided"
        for cell in self.tried:
            cells[cell] = False
        return cells

    def end(self, line, begin, place):
        """Where the designs of a line end, from ``begin`` on.

        It looks at a ``place`` first, from there in growing strides, then halfway
        between.
        """
        good, bad, stride = begin - 1, len(line), 1
        while bad - good > 1:
            place = min(max(place, good + 1), bad - 1)
            if self.sees(line[place]):
                good, place = place, place + stride
            else:
                bad, place = place, place - stride
            stride *= 2
            if begin <= good and bad < len(line):
                place = (good + bad) // 2
        return good + 1

    def sees(self, cell):
        """Whether a cell has a design, as far as a trial tells."""
        if not self.ask.has_trials:
            return self.holds(cell)
        design = self.reused(cell)
        if design is not None:
            self.designs[cell] = design
            return True
        first = self.ask.trial(self.near, **self.bounds(cell))
        self.trials[cell] = first
        if not seen(first):
            return False
        self.near = first
        return self.last is not None or self.holds(cell)  # others reuse a design

    def holds(self, cell):
        """Whether a cell has a design."""
        self.tried.add(cell)
        design = self.designs.get(cell)
        if design is None and cell not in self.trials:
            design = self.reused(cell)
        if design is None:
            first = self.trials.setdefault(cell)
            design = self.ask.finished(first, **self.bounds(cell))
        if design is None or design.status == "infeasible":
            self.refusals[cell] = design
        elif design.status == "feasible":
            self.designs[cell] = self.last = self.near = design
            return True
        return False

    def bounds(self, cell):
        """What a cell asks, by the parameters' names."""
        row, column = cell
        return {self.up.key: float(self.y[row]), self.across.key: float(self.x[column])}

    def reused(self, cell):
        """The last design, if it is one of a cell's, too; else None."""
        last, bounds = self.last, self.bounds(cell)
        if last is None or last.P is None or self.ask.empty(bounds):
            return None
        request = replaced(last.request, bounds)
        blocks = request.blocks(last.P, last.Y, V=last.V, own=last.own)
        margins = {name: margin(g) for name, g in blocks.items()}
        if min(margins.values()) <= REUSE_MARGIN:
            return None
        return replace(last, request=request, margins=margins)

    def keep_points(self):
        """Let points inside decide where the time was over before their centres."""
        for cell, first in self.trials.items():
            if seen(first) and cell not in self.tried:
                design = point(first)
                if design.status == "feasible":
                    self.designs[cell] = design

    def whole(self):
        """The map so far."""
        return FeasibilityMap(
            self.across.key,
            self.up.key,
            (self.across, self.up),
            self.x,
            self.y,
            self.designs,
            self.refusals,
            len(self.trials),
        )

    def map(self):
        """The map so far, from the cells that decide the others."""
        whole = self.whole()
        return replace(
            whole,
            designs=_fewest(whole, self.designs, -1),
            refusals=_fewest(whole, self.refusals, 1),
        )


def _fewest(whole, deciding, way):
    """The deciding cells that no other one makes superfluous."""
    needed = dict(deciding)
    for cell in deciding:
        others = [other for other in needed if other != cell]
        if whole._any(others, way)[cell]:
            del needed[cell]
    return needed


def _axis(side, axis, ask):
    try:
        name, values = axis
        values = np.array([float(v) for v in values])
    except (TypeError, ValueError):
        raise ValueError(
            f'{side} must be a name and its values: ("sigma", [0.5, 1])'
        ) from None
    which = Search(ask, name, 2).parameter  # refuses what can't be varied
    good = np.isfinite(values).all() and (values > 0).all()
    if not good or len(values) < 2:
        raise ValueError(f"{side}: values of {name} must be two or more, positive")
    if which.fault(values):
        raise ValueError(f"{side}: {which.fault(values)}")
    return which, values


def _certified(design):
    """Whether a design has a proof, if need be in its own, sharper coordinates."""
    if certified(design):
        return True
    if design.V is not None or design.P is None:
        return False
    better = again(design.request, design)
    return bool(better) and better.status == "feasible" and certified(better)


def _provably_refused(refusal, designs):
    """Whether a refusal is proven, if need be in coordinates of some design."""
    if provably_refused(refusal):
        return True
    near = next(iter(designs), None)
    if near is None or near.V is not None or near.P is None:
        return False
    if refusal.request.coupling == "slack":  # it is one of a vertex
        return False
    return provably_refused(again(refusal.request, near))
