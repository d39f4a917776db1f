"""Edges of requirements, proven from both sides.

Asking for more never turns an infeasible request feasible (chapter 28). A certified
design stands on the edge's feasible side and exact multipliers, which exclude every
design, on the other, both on round numbers: what is printed is what is proven.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...language import Unknown, block, eye
from ...requirements.shorthand import parameter
from ...runtime.time_limit import OutOfTime, checked_seconds
from ...runtime.time_limit import time_limit as limited
from ...solver.blocks import Blocks
from ...solver.bounded import unpacked
from ...solver.loop import Unbounded
from ...solver.primal_dual import interior_steps
from ...synthesis.design import Design
from ...synthesis.request import Request
from ...synthesis.scaling import Frame
from .ask import Ask
from .search import EdgeSearch, certified, provably_refused, requirements

TIME_LIMIT = 1800.0  # seconds
WIDE = 1e3  # of P, V and Y in that frame: so far out it decides nothing
SADDLE_GAP = 1e-3  # relative; nearer to the optimum rounding moves shares by per cents
STEPS_TO_SADDLE = 60  # of the interior-point method, which takes about twenty
STEPS_ALONG = 4  # onto the central path; what they leave moves no share by 1e-4


@dataclass(frozen=True, eq=False)
class Edge:
    """The edge of a requirement, the others held.

    Parameters
    ----------
    name : str
        The parameter's name.
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
    feasible: float | None = None
    infeasible: float | None = None
    design: Design | None = None
    excluded: Design | None = None
    reason: str = ""

    def __repr__(self):
        there = [x for x in (self.feasible, self.infeasible) if x is not None]
        sides = [f"{self.parameter.shown(x):.6g}" for x in there]
        if len(sides) < 2:
            word = "feasible" if self.infeasible is None else "infeasible"
            side = f"{self.name} = {sides[0]} is {word}" if sides else f"no {self.name}"
            return f"<Edge: {side}; {self.reason}>"
        return f"<Edge: {self.name} = {sides[0]} is feasible, {sides[1]} is not>"

    @property
    def parameter(self):
        """The `Parameter`: words, unit, direction."""
        asked = self.design or self.excluded
        return parameter(self.name, () if asked is None else asked.request.requirements)

    @property
    def proven(self):
        """True if both sides are there, each with its exact proof."""
        return (
            None not in (self.design, self.excluded)
            and certified(self.design)
            and provably_refused(self.excluded)
        )

    @cached_property
    def shares(self):
        r"""The share of each requirement if all are relaxed alike.

        On the infeasible side phase one has an optimum t* < 0. With its
        saddle point x, Z requirement p weighs
        :math:`\langle p\,\partial G/\partial p(x), Z\rangle`, the slope
        of t* in log p. The shares are positive and sum to one; along the
        frontier of p and q, one per cent more of p costs
        share(p)/share(q) per cent of q.

        Returns
        -------
        dict

        Notes
        -----
        Where every block is homogeneous t* is 0 or infinite, so there a
        normalising block P > I joins them. Blocks that bound P and Y keep
        the saddle point finite. These belong to no requirement, and the
        bounds are so wide that they decide nothing.
        """
        if None in (self.design, self.excluded):
            raise ValueError(f"the edge has one side only: {self.reason}")
        request = self.excluded.request
        if request.coupling.open or request.coupling.free:
            raise ValueError(
                "shares are those of LMIs of the whole polytope: the refusal is one of "
                "single plants"
            )
        frame = Frame.of(request)  # whatever frames the refusal went through
        x, Z = _least_violation(request, frame)
        bounds = requirements(request)
        step, contributions = 1e-4, {}
        for name, value in bounds.items():
            high, low = (
                _blocks_at(request.with_bounds({name: value * factor}), frame, x)
                for factor in (1 + step, 1 - step)
            )
            moved = (((h - k) * z).sum() for h, k, z in zip(high, low, Z))
            contributions[name] = abs(sum(moved))
        whole = sum(contributions.values())
        return {name: float(x / whole) for name, x in contributions.items()}


def _listed(named_blocks):
    expressions, unknowns = named_blocks
    return list(expressions.values()), unknowns


def _blocks_at(request, frame, x):
    """The blocks of a request, in a frame, at a vector x of variables."""
    blocks, unknowns = _listed(request.in_unknowns(frame))
    named = unpacked(unknowns, x)
    values = {u: named[u.name] for u in unknowns}
    return [g.value(values) for g in blocks]


def _least_violation(request, frame):
    """The unknowns and multipliers where phase one attains its optimum, in a ``frame``
    in which P and Y aren't much larger than I: none is above `WIDE`.
    """
    blocks, unknowns = _listed(request.in_unknowns(frame))
    sizes = Blocks(blocks, unknowns).diagonal_scales
    t = Unknown("t", 1)
    raised = [g - t * np.diag(1 / d**2) for g, d in zip(blocks, sizes)]
    upper = [WIDE * eye(u.shape[0]) - u for u in unknowns if u.symmetric]
    for u in unknowns:
        if u.name in ("V", "Y"):
            rows, cols = u.shape
            upper.append(block([[WIDE * eye(cols), u.T], [u, WIDE * eye(rows)]]))
    P = [u for u in unknowns if u.name in request.lyapunov]
    lower = []
    if not any(g.constant.any() for g in blocks):
        lower = [u - eye(u.shape[0]) for u in P]
    lifted = Blocks([*raised, *lower, *upper], [*unknowns, t])
    values = {u: np.zeros(u.shape) for u in [*unknowns, t]}
    values |= {u: 2 * np.eye(u.shape[0]) for u in P}
    start = np.concatenate([u.pack(value) for u, value in values.items()])
    scaled = (g * np.outer(d, d) for g, d in zip(lifted(start), sizes))
    start[-1] = min(0.0, *(np.linalg.eigvalsh(g)[0] for g in scaled)) - 1.0
    cost = np.zeros(lifted.variables)
    cost[-1] = -1.0
    x, Z = _saddle_point(lifted, cost, start, SADDLE_GAP)
    return x[:-1], Z[: len(blocks)]


def _saddle_point(blocks, cost, x, gap):
    """A minimum of cost.x over ``blocks``, from x inside, with its multipliers: the
    point of the central path at which it is known to the relative accuracy ``gap``.
    """
    newton = blocks.newton
    weight = blocks.degree / abs(cost @ x)
    for state in interior_steps(newton, x, cost, weight, STEPS_TO_SADDLE):
        x, goal = state["x"], gap * abs(cost @ state["x"])
        if state["gap"] < goal:
            break
    else:
        raise Unbounded("the minimum isn't found")
    Z, target = state["Z"], goal / blocks.degree
    for state in interior_steps(newton, x, cost, weight, STEPS_ALONG, target, Z):
        x, Z = state["x"], state["Z"]
    return x, newton.unstacked(Z)


def edge(
    name,
    plant,
    U=None,
    region=None,
    gamma=None,
    saturation=None,
    *,
    digits=3,
    time_limit=TIME_LIMIT,
    **options,
):
    """Find how far one requirement can be pushed, the others held.

    Parameters
    ----------
    name : {"sigma", "theta", "rho", "gamma", "u_max", "cost"}
        The parameter to push, or that of a requirement of your own.
    plant, U, region, gamma, saturation
        As in `design_pid`. Only parts of a `PoleRegion`, half-planes,
        sectors and disks can be moved.
    digits : int
        The sides are numbers of so many significant digits (theta: in
        degrees).
    time_limit : float
        Seconds after which the search stops; the sides are those that
        are proven by then, and the reason says so.
    **options
        requirements, K_A and coupling, for `design_pid`; without a
        word the coupling is "pairs", and with "auto" a refusal is one of slack
        matrices, too. Or a law, and its search.

    Returns
    -------
    Edge
        Its two sides are neighbours, unless a few values between them
        can be neither solved nor excluded.

    Raises
    ------
    ValueError
        If the name is unknown, or what it needs isn't given: x0 for "u_max",
        the weights for "cost", F for "gamma".

    Notes
    -----
    Tried are values from a thousandth to a thousand times the one given (one
    without it), and angles from 1 to 90 degrees.

    Examples
    --------
    >>> import sosbook as sos
    >>> from sosbook.book import thesis
    >>> robot = thesis.example_1()
    >>> fastest = edge("rho", robot.plant, **robot.requirements)
    >>> fastest.proven, fastest.feasible < 5
    (True, True)
    """
    asked = dict(region=region, gamma=gamma, saturation=saturation)
    search = EdgeSearch(Ask(plant, U, asked, options), name, digits)
    seconds = checked_seconds(time_limit, needed=True)
    try:
        with limited(seconds):
            return Edge(name, *search.edge())
    except OutOfTime:
        reason = f"stopped after {seconds:g} s"
        return Edge(name, *search.so_far(reason))


def request(example):
    """The `Request` of an example of `sosbook.book.thesis`."""
    return Request(example.plant, **example.requirements)
