"""Maps of many specifications, and many designs, at the price of a few.

Asking for more never turns an infeasible request feasible (chapter 15). So
the feasible cells of a map lie below a staircase: only the cells along it
are solved, and a design that was found is tried on the next cell first.
"""

from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...lmi.centre import margin
from ...lmi.time_limit import OutOfTime, checked_seconds
from ...lmi.time_limit import time_limit as limited
from ...requirements.vocabulary import Parameter
from ...synthesis.pid import design_pid
from .ask import Ask, again
from .parallel import sweep
from .search import Search, certified, refuted, replaced

__all__ = ["FeasibilityMap", "designs", "feasibility_map"]

REUSE_MARGIN = 1e-4  # with which an easier cell's design serves a harder cell
TIME_LIMIT = 3600.0  # seconds
DESIGNS_PER_PROCESS = 25  # designs in a row, each of which starts from the last


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
        How many requests were solved.
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

    def backing(self, row, column):
        """The design or the refusal that decides a cell in a row and a column.

        None where nothing decides it.
        """
        for deciding, way in ((self.designs, -1), (self.refusals, 1)):
            for cell, design in deciding.items():
                if self._any([cell], way)[row, column]:
                    return design
        return None

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
            if d is None or _refuted(d, yes.values())
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
        cost, requirements, K_A, coupling, mu and slack, for `design_pid`.

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
    with suppress(OutOfTime), limited(checked_seconds(time_limit, needed=True)):
        cells.walk()
    return cells.map()


class _Cells:
    """Solves cells and remembers what decides them."""

    def __init__(self, ask, across, x, up, y):
        self.ask, self.across, self.x, self.up, self.y = ask, across, x, up, y
        self.designs, self.refusals = {}, {}
        self.last, self.solves, self.tried = None, 0, set()

    def walk(self):
        """Walk along the staircase, then solve what it left open.

        The walk starts where the longer axis asks for least and the shorter
        one for most. A feasible cell decides all easier ones, so the walk goes
        on along the longer axis; from a cell that isn't feasible it goes back
        along the shorter one.
        """
        rows = np.argsort(self.up.harder * self.y)
        columns = np.argsort(self.across.harder * self.x)
        lines = [[(i, j) for j in columns] for i in rows]
        if len(rows) > len(columns):
            lines = [[(i, j) for i in rows] for j in columns]
        k = 0
        for line in reversed(lines):
            while k < len(line) and self.holds(line[k]):
                k += 1
        while (undecided := self.open()).any():
            cells = (c for line in lines for c in line if undecided[c])
            self.holds(next(cells))

    def open(self):
        """The cells that are neither decided nor tried."""
        cells = self.map().status == "undecided"
        for cell in self.tried:
            cells[cell] = False
        return cells

    def holds(self, cell):
        """Whether a cell has a design."""
        row, column = cell = tuple(map(int, cell))
        self.tried.add(cell)
        design = self.solve(
            {self.up.key: float(self.y[row]), self.across.key: float(self.x[column])}
        )
        if design is None or design.status == "infeasible":
            self.refusals[cell] = design
        elif design.status == "feasible":
            self.designs[cell] = self.last = design
            return True
        return False

    def solve(self, bounds):
        """A Design, or None where the region is empty."""
        last = self.last
        if last is not None and not self.ask.empty(bounds):
            request = replaced(last.request, bounds)
            blocks = request.blocks(last.P, last.Y, V=last.V, own=last.own)
            margins = {name: margin(g) for name, g in blocks.items()}
            if min(margins.values()) > REUSE_MARGIN:
                return replace(last, request=request, margins=margins)
        self.solves += 1
        return self.ask.solve(**bounds)

    def map(self):
        """The map so far, from the cells that decide the others."""
        whole = FeasibilityMap(
            self.across.key,
            self.up.key,
            (self.across, self.up),
            self.x,
            self.y,
            self.designs,
            self.refusals,
            self.solves,
        )
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
    better = design.V is None and again(design.request, design)
    return bool(better) and better.status == "feasible" and certified(better)


def _refuted(refusal, designs):
    """Whether a refusal is proven, if need be in coordinates of some design."""
    if refuted(refusal):
        return True
    near = next(iter(designs), None)
    if near is None or near.V is not None:
        return False
    return refuted(again(refusal.request, near))


def designs(plant, specifications, n_jobs=None, progress=True):
    """A design for each of many specifications.

    Each one starts from the last, if that was feasible: list neighbours
    next to each other.

    Parameters
    ----------
    plant : SecondOrderSystem or Polytope
        The plant, or the polytope of plants.
    specifications : sequence of dict
        Keywords of `design_pid`.
    n_jobs, progress
        As in `sweep`; a worker takes 25 specifications at a time.

    Returns
    -------
    list of Design
        Those of `design_pid`, whatever the order and the workers.

    Raises
    ------
    ValueError
        If a specification isn't a dict, or a value in it is bad.

    Examples
    --------
    >>> import sosbook as sos
    >>> robot = sos.thesis.example_1()
    >>> grid = designs(robot.plant, [
    ...     robot.requirements | dict(gamma=g) for g in (0.3, 1, 2)])
    >>> [design.status for design in grid]
    ['infeasible', 'feasible', 'feasible']
    """
    specifications = list(specifications)
    for place, asked in enumerate(specifications):
        if not isinstance(asked, dict):
            raise ValueError(
                f"specification {place} must be a dict of keywords of "
                f"design_pid, got {type(asked).__name__}"
            )

    def solve(run):
        designs_of_run, last = [], {}  # by the shape of U
        for asked in run:
            key = str(asked.get("coupling")), np.shape(asked.get("U"))
            try:
                design = design_pid(plant, **{"start": last.get(key)} | asked)
            except Exception as error:
                error.add_note(f"for the specification {asked!r}")
                raise
            designs_of_run.append(design)
            # next to a refusal the next one is probably refused, too
            feasible = design.status == "feasible"
            last[key] = design if feasible else None
        return designs_of_run

    runs = [
        specifications[k : k + DESIGNS_PER_PROCESS]
        for k in range(0, len(specifications), DESIGNS_PER_PROCESS)
    ]
    return [d for run in sweep(solve, runs, n_jobs, progress) for d in run]
