"""Edges and frontiers of requirements, proven from both sides.

Asking for more never turns an infeasible request feasible (chapter 15), so
each requirement has an edge.  A certified design stands on its feasible side
and exact multipliers, which exclude every design, on the other.  Both stand
on round numbers: what is printed is what is proven.
"""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from ...requirements.shorthand import parameter
from ...synthesis.pid import Design
from ...synthesis.problem import Request
from .parallel import bar, finished
from .search import Ask, Search, certified, refuted, replaced, requirements

__all__ = ["Edge", "Frontier", "edge", "frontier", "request"]


@dataclass(frozen=True, eq=False)
class Edge:
    """The edge of a requirement, the others held.

    Parameters
    ----------
    name : str
        Of the parameter.
    feasible : float or None
        The most that a certified design keeps (theta in radians); None
        where no value gave a design.
    infeasible : float or None
        The least that is proven infeasible; None where every value that
        was tried has a design.
    design : Design or None
        Keeps ``feasible`` (or more); proven by its ``certify()``.
    excluded : Design or None
        Proven infeasible at ``infeasible`` (or less) by its
        ``infeasibility``; None where the region itself is empty.
    reason : str
        Why a side is missing; else empty.
    """

    name: str
    feasible: float = None
    infeasible: float = None
    design: Design = None
    excluded: Design = None
    reason: str = ""

    def __repr__(self):
        sides = [
            "none" if side is None else f"{self.parameter.shown(side):.6g}"
            for side in (self.feasible, self.infeasible)
        ]
        return (f"<Edge: {self.name} = {sides[0]} is feasible, "
                f"{sides[1]} is not>")

    @property
    def parameter(self):
        """The `Parameter`: words, unit, direction."""
        asked = self.design or self.excluded
        return parameter(
            self.name, () if asked is None else asked.request.requirements)

    @property
    def proven(self):
        """Whether both sides are there, each with its exact proof."""
        return (
            None not in (self.design, self.excluded)
            and certified(self.design) and refuted(self.excluded)
        )

    @cached_property
    def shares(self):
        r"""What each requirement contributes if all are relaxed alike.

        With multipliers Z from the infeasible side and P, Y from the
        feasible one, requirement p weighs
        :math:`\langle p\,\partial G/\partial p, Z\rangle`: the slope of
        phase one's optimum in log p (envelope theorem). The shares are
        positive and sum to one; along the frontier of p and q, one per
        cent more of p costs share(p)/share(q) per cent of q.

        Returns
        -------
        dict
        """
        if None in (self.design, self.excluded):
            raise ValueError(f"the edge has one side only: {self.reason}")
        if self.design.V is not None:
            raise ValueError(
                "shares are known for one Lyapunov matrix only, not for "
                'coupling="slack"'
            )
        request, frame = self.excluded.request, self.excluded.frame
        T = frame.T
        P = np.linalg.solve(T, np.linalg.solve(T, self.design.P).T)
        Y = np.linalg.solve(T, self.design.Y.T).T / frame.scale
        own = {name: self.design.own[name] / unit
               for name, unit in request.own_units(frame).items()}
        known = requirements(request)
        step, found = 1e-4, {}
        for name, value in known.items():
            ends = []
            for factor in (1 + step, 1 - step):
                near = replaced(request, {name: value * factor})
                ends.append(near.blocks(P, Y, frame=frame, own=own))
            found[name] = abs(sum(
                ((high - low) * z).sum() for high, low, z in zip(
                    ends[0].values(), ends[1].values(),
                    self.excluded.multipliers)))
        whole = sum(found.values())
        return {name: float(x / whole) for name, x in found.items()}


@dataclass(frozen=True, eq=False)
class Frontier:
    """Two requirements against each other, the others held.

    Parameters
    ----------
    x, y : str
        Names of the requirements.
    values : tuple of float
        Of x, from the least demanding.
    edges : tuple of Edge
        Of y, one for each value of x.
    request : Request
        What was given.
    digits : int
        Of the values of y.
    """

    x: str
    y: str
    values: tuple
    edges: tuple
    request: Request
    digits: int

    def __repr__(self):
        solved = {id(d) for e in self.edges
                  for d in (e.design, e.excluded) if d is not None}
        return (f"<Frontier: {self.y} over {len(self.values)} values of "
                f"{self.x}, {len(solved)} proofs>")

    @property
    def feasible(self):
        """The edges' feasible sides, nan where there is none."""
        return self._side("feasible")

    @property
    def infeasible(self):
        """The edges' infeasible sides, nan where there is none."""
        return self._side("infeasible")

    def _side(self, side):
        found = [getattr(e, side) for e in self.edges]
        return np.array([np.nan if f is None else f for f in found])

    def design(self, x, y):
        """The certified design that keeps x and y, or None.

        Of those that do it is the one that asks for least.
        """
        for value, e in zip(self.values, self.edges):
            if (e.design is not None and self._harder(self.x, value, x) >= 0
                    and self._harder(self.y, e.feasible, y) >= 0):
                return e.design
        return None

    def excluded(self, x, y):
        """A request that asks for no more and is proven infeasible."""
        for value, e in reversed(list(zip(self.values, self.edges))):
            if (e.excluded is not None and self._harder(self.x, x, value) >= 0
                    and self._harder(self.y, y, e.infeasible) >= 0):
                return e.excluded
        return None

    def parameter(self, name):
        """The `Parameter` of x or y: words, unit, direction."""
        return parameter(name, self.request.requirements)

    def _harder(self, name, a, b):
        return self.parameter(name).harder_than(a, b)

    def status(self, x, y):
        """What the proofs say: "feasible", "infeasible" or "undecided".

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


def edge(name, plant, U=None, region=None, gamma=None, saturation=None,
         *, digits=3, **options):
    """Find how far one requirement can be pushed, the others held.

    Parameters
    ----------
    name : {"sigma", "theta", "rho", "gamma", "u_max", "cost"}
        Or the parameter of a requirement of your own.
    plant, U, region, gamma, saturation
        As in `design_pid`. Only parts of a `PoleRegion`, half-planes,
        sectors and disks can be moved.
    digits : int
        The sides are numbers of so many significant digits (theta: in
        degrees).
    **options
        cost, requirements, K_A, coupling and so on, for `design_pid`.

    Returns
    -------
    Edge
        Its two sides are neighbours, unless a few values between them
        can be neither solved nor excluded.

    Raises
    ------
    ValueError
        If the name is unknown, or what it needs isn't given.

    Notes
    -----
    Tried are values up to a thousand times the one given, and angles
    from 1 to 90 degrees.

    Examples
    --------
    >>> import sosbook as sos
    >>> robot = sos.thesis.example_1()
    >>> found = edge("rho", robot.plant, **robot.requirements)
    >>> found.proven, found.feasible < 5
    (True, True)
    """
    ask = Ask(plant, U, dict(
        region=region, gamma=gamma, saturation=saturation), options)
    return Edge(name, *Search(ask, name, digits).edge())


def request(example):
    """The `Request` of an example of `sosbook.book.thesis`."""
    return Request(example.plant, **example.requirements)


def frontier(x, y, plant, U=None, region=None, gamma=None, saturation=None,
             *, values, digits=2, n_jobs=None, progress=True, **options):
    """The edge of y at each value of x, the other requirements held.

    Parameters
    ----------
    x, y : str
        Names of parameters, as in `edge`.
    plant, U, region, gamma, saturation, digits, options
        As in `edge`.
    values : sequence of float
        Of x; theta in radians.
    n_jobs, progress
        As in `sweep`.

    Returns
    -------
    Frontier
        A staircase. The proofs of one value of x bracket the next; where
        they leave nothing open they serve there as well.
    """
    ask = Ask(plant, U, dict(
        region=region, gamma=gamma, saturation=saturation), options)
    if x == y:
        raise ValueError(f'x and y are both "{x}": name two requirements')
    for name in (x, y):
        Search(ask, name, digits)  # refuses what it can't search
    way = parameter(x, ask.requirements).harder
    values = sorted(map(float, values), reverse=way < 0)
    if len(set(values)) < 2 or min(values) <= 0:
        raise ValueError(f"values of {x} must be two or more, positive")
    values = list(dict.fromkeys(values))
    last, known = len(values) - 1, {}

    def solve(task):
        at, easier, harder = task
        search = Search(ask.at(**{x: values[at]}), y, digits)
        return Edge(y, *search.edge(easier, harder))

    tasks = [(0, None, None), (last, None, None)]
    with bar(len(values), progress) as done:
        while tasks:
            for place, found in finished(solve, tasks, n_jobs):
                known[tasks[place][0]] = found
                done.update()
            ends = sorted(known)
            tasks = [
                ((a + b) // 2, known[a], known[b])
                for a, b in pairwise(ends) if b - a > 1
            ]
    edges = tuple(known[k] for k in range(len(values)))
    return Frontier(x, y, tuple(values), edges, ask.request(), digits)
