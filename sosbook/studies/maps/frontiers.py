"""Frontiers: the edge of one requirement over the values of another."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ...requirements.shorthand import parameter
from ...runtime.progress import bar
from ...synthesis.request import Request
from .ask import Ask
from .edges import Edge
from .parallel import finished
from .search import EdgeSearch


@dataclass(frozen=True, eq=False)
class Frontier:
    """Two requirements against each other, the others held.

    Parameters
    ----------
    x, y : str
        Names of the requirements.
    values : tuple of float
        Values of x, from the least demanding.
    edges : tuple of Edge
        The edge of y at each value of x.
    request : Request
        What was asked for.
    digits : int
        Significant digits of the values of y.
    """

    x: str
    y: str
    values: tuple
    edges: tuple
    request: Request
    digits: int

    def __repr__(self):
        designs = (d for e in self.edges for d in (e.design, e.excluded))
        solved = {id(d) for d in designs if d is not None}
        return (
            f"<Frontier: {self.y} over {len(self.values)} values of "
            f"{self.x}, {len(solved)} proofs>"
        )

    @property
    def feasible(self):
        """The edges' feasible sides, nan where there is none."""
        return self._side("feasible")

    @property
    def infeasible(self):
        """The edges' infeasible sides, nan where there is none."""
        return self._side("infeasible")

    def _side(self, side):
        values = [getattr(e, side) for e in self.edges]
        return np.array([np.nan if f is None else f for f in values])

    def design(self, x, y):
        """The certified design that keeps x and y and asks for least, or None."""
        for value, e in zip(self.values, self.edges):
            if e.design is not None and self._no_less((value, e.feasible), (x, y)):
                return e.design
        return None

    def excluded(self, x, y):
        """A request that asks for no more than (x, y) and is proven infeasible."""
        for value, e in reversed(list(zip(self.values, self.edges))):
            if e.excluded is not None and self._no_less((x, y), (value, e.infeasible)):
                return e.excluded
        return None

    def parameter(self, name):
        """The `Parameter` of this name, x or y: words, unit, direction."""
        return parameter(name, self.request.requirements)

    def _no_less(self, some, others):
        """True if some values of x and y ask for no less than others."""
        each = zip((self.x, self.y), some, others)
        return all(self.parameter(name).harder_than(a, b) >= 0 for name, a, b in each)

    def status(self, x, y):
        """The proven status of (x, y): "feasible", "infeasible" or "undecided".

        Raises
        ------
        ValueError
            If a value isn't positive.
        """
        for name, value in ((self.x, x), (self.y, y)):
            if not value > 0:
                raise ValueError(f"{name} = {value} must be positive")
        if self.design(x, y) is not None:
            return "feasible"
        return "undecided" if self.excluded(x, y) is None else "infeasible"


def frontier(
    x,
    y,
    plant,
    U=None,
    region=None,
    gamma=None,
    saturation=None,
    *,
    values,
    digits=2,
    n_jobs=None,
    progress=True,
    **options,
):
    """The edge of y at each value of x, the other requirements held.

    Parameters
    ----------
    x, y : {"sigma", "theta", "rho", "gamma", "u_max", "cost"}
        Names of parameters, as in `edge`.
    plant, U, region, gamma, saturation
        As in `edge`.
    values : sequence of float
        Values of x; theta in radians.
    digits
        As in `edge`.
    n_jobs, progress
        As in `sweep`.
    **options
        As in `edge`.

    Returns
    -------
    Frontier
        A staircase. The proofs of one value of x bracket the next; where
        they leave nothing open they serve there as well.
    """
    asked = dict(region=region, gamma=gamma, saturation=saturation)
    ask = Ask(plant, U, asked, options)
    if x == y:
        raise ValueError(f'x and y are both "{x}": name two requirements')
    for name in (x, y):
        EdgeSearch(ask, name, digits)  # refuses what it can't search
    way = parameter(x, ask.requirements).harder
    values = sorted(map(float, values), reverse=way < 0)
    if len(set(values)) < 2 or min(values) <= 0:
        raise ValueError(f"values of {x} must be two or more, positive")
    values = list(dict.fromkeys(values))
    last, by_place = len(values) - 1, {}

    def solve(task):
        at, easier, harder = task
        search = EdgeSearch(ask.at(**{x: values[at]}), y, digits)
        return Edge(y, *search.edge(easier, harder))

    tasks = [(0, None, None), (last, None, None)]
    with bar(len(values), progress=progress) as done:
        while tasks:
            for place, edge_there in finished(solve, tasks, n_jobs):
                by_place[tasks[place][0]] = edge_there
                done.update()
            wide = [(a, b) for a, b in pairwise(sorted(by_place)) if b - a > 1]
            tasks = [((a + b) // 2, by_place[a], by_place[b]) for a, b in wide]
    edges = tuple(by_place[k] for k in range(len(values)))
    return Frontier(x, y, tuple(values), edges, ask.request(), digits)
