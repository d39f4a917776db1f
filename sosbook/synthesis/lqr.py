"""Procedures 2.3 and 2.4: PID and PD controllers of least quadratic cost."""

from collections.abc import Iterable
from contextlib import suppress
from dataclasses import replace
from typing import Literal

import numpy as np

from ..exact.definite import exact
from ..laws import Law
from ..laws.taken import law_of
from ..lmi.solution import LMISolution
from ..plants.controllability import fixed_part
from ..plants.coupling import Coupling, coupling_of
from ..plants.kinds import Plant
from ..requirements.base import Requirement
from ..requirements.cost import QuadraticCost
from ..requirements.hinf import HInfinity
from ..requirements.input_bound import Saturation
from ..requirements.pole_region import Region
from ..requirements.shorthand import asked_once
from ..runtime.array_like import ArrayLike
from ..runtime.threads import one_thread
from ..runtime.time_limit import OutOfTime
from ..solver.bounded import unpacked
from .bracket import bracketed
from .centre import AMID, analytic_centre, too_many
from .design import Design
from .feasibility import FROM_STATES, answer, follow, guarded
from .objectives import Unattained, Unfinished, optimum, without_optimum
from .pid import Word, design_pid
from .procedure import given, without_input
from .regularization import Regularization
from .request import Request
from .riccati_point import bound_of, riccati_point
from .scaled_lmis import ScaledLMIs
from .search import USUAL, Search
from .slack import with_slack, without_slack
from .solution import Solution
from .starting_points import at

# relative accuracies to which the optimum is sought; the first that is reached
OPTIMUM_GAPS = 1e-10, 1e-8, 1e-6
UNSETTLED = "Give states that the open loop doesn't settle a weight in Q."


@one_thread
def design_lqr(
    plant: Plant | Regularization,
    Q: ArrayLike,
    R: ArrayLike,
    U: ArrayLike | None = None,
    *,
    noise: Literal["states", "F"] = "states",
    coupling: Word | tuple[str, float] | Coupling = "pairs",
    region: Region | None = None,
    gamma: float | HInfinity | None = None,
    saturation: Saturation | None = None,
    requirements: Iterable[Requirement] = (),
    law: Law | None = None,
    search: Search = USUAL,
) -> Design:
    r"""Design the PID (without ``U`` PD) controller of least cost bound.

    Parameters
    ----------
    plant : SecondOrderSystem, Polytope or Uncertain
        The plant, or the polytope of plants.
    Q : (N, N) array_like
        Weight of the state [z; z'; x3], symmetric, not negative.
    R : (m, m) array_like
        Weight of the input, symmetric and positive definite.
    U
        As in `design_pid`.
    noise : {"states", "F"}
        As in `QuadraticCost`.
    coupling, region, gamma, saturation, requirements
        As in `design_pid`.
    law : Law, optional
        What the controller measures and remembers, as in `design_pid`, which searches
        its gain: the same as ``design_pid(law=law, minimize="cost",
        requirements=[QuadraticCost(Q, R, noise)])``. Q weighs the law's states as
        well, the last ones.
    search : Search
        Its ``time_limit``; with a law all that this search takes.

    Returns
    -------
    Design
        K is the optimum of Theorem 2.4; for one plant it is the gain of
        the Riccati equation. Where several gains have the least cost it is the central
        one, if that is found. Its certificate is of K and a bound one in
        ten thousand above the optimum: ``.request.cost.bound``. Where no optimum
        is found, ``reason`` says what is known of smaller bounds. Where Q
        doesn't see a mode on the imaginary axis no gain attains the optimum:
        K comes near it, and ``reason`` says so, too.

    Notes
    -----
    Source: thesis Theorem 2.4, Procedures 2.3 and 2.4. The bound is
    tr J for noise of intensity one (not its square root). Where only the
    cost of one plant is asked, K is computed from the Riccati equation and
    the LMIs certify it; else they find it.

    Examples
    --------
    >>> import numpy as np
    >>> from sosbook import SecondOrderSystem
    >>> plant = SecondOrderSystem([[1]], [[0]], [[0]], B=[[1]])
    >>> design = design_lqr(plant, np.diag([1, 0]), [[1]])
    >>> design.K.round(4)  # [-1, -sqrt(2)]
    array([[-1.    , -1.4142]])
    """
    asked = QuadraticCost(Q, R, noise, bound=1.0)
    name = asked.parameter.key
    law = law_of(U, law)
    if law.searched:
        wanted = coupling_of(coupling)
        common = wanted.one_P and wanted.between
        return design_pid(
            plant, region=region, gamma=gamma, saturation=saturation, law=law,
            coupling="auto" if common else coupling, minimize=name, search=search,
            requirements=[QuadraticCost(Q, R, noise), *requirements],
        )  # fmt: skip
    search.taking("time_limit", "a least cost without a law")
    more = given(region=region, gamma=gamma, saturation=saturation)
    more = asked_once(**more, requirements=requirements)
    request = Request(
        plant,
        law=law,
        coupling=coupling,
        requirements=sorted((asked, *more), key=lambda r: r.rank),
    )

    def solved():
        return _explained(_least(request, name), asked)

    return Design(**vars(guarded(request, search.time_limit, solved)))


def _least(request, name):
    """The Solution of least cost."""
    near = riccati_point(request)
    if near is not None:
        solution = None
        if request.order < FROM_STATES:
            solution = follow(near.request, near)
        if solution is None or solution.status != "feasible":
            lmis = ScaledLMIs(near.request, near.frame)
            solution = at(lmis, lmis.point(near))
        if solution is not None:
            return _with_any_gain(solution)
    objective = {name: 1.0}
    idle = without_input(request, objective)
    if idle is not None:
        return idle
    settled, attained = with_slack(request, objective, refuse=True), True
    if settled is None:
        return without_slack(request, objective)
    request = settled
    try:
        bounds, best = _first_optimum(request, objective)
    except Unfinished as stopped:
        return stopped.solution(request)
    except Unattained as missed:
        bounds, best, attained = missed.bounds, missed.point, False
    if bounds is None:
        return without_optimum(best)
    gain = best.problem.gain(best.values)
    bound = {name: bound_of(bounds[name])}
    asked = request.with_bounds(bound)
    given = replace(asked, gain=gain)
    natural = best.problem.in_plant_units(best.values)
    near = Solution(given, "feasible", frame=best.problem.frame, **natural)
    solution = follow(given, near) or answer(given)
    if attained and solution.status == "feasible":
        return _with_any_gain(solution)
    solution = bracketed(request, bound, _with_any_gain(solution))
    return replace(solution, reason=f"{solution.reason} {UNSETTLED}")


def _explained(solution, cost):
    """The Solution, with a reason where certainly no gain attains the least cost."""
    request = solution.request
    alone = len(request.requirements) == len(request.distinct) == 1
    plain, mode = cost.noise == "states" and cost.N is None, None
    if solution.status == "feasible" and alone and plain and request.step is None:
        with suppress(OutOfTime):
            mode = _unseen(request, cost.Q)
    if mode is None:
        return solution
    place = f"±{abs(complex(mode)):.4g}j" if abs(complex(mode)) else "0"
    text = (
        f"Q doesn't see the mode at {place} rad/s, so that no gain attains the least "
        "cost: the nearer to it, the slower the mode. This gain is near. Give that "
        "motion a weight in Q, or ask for a region."
    )
    return replace(solution, reason=" ".join(filter(None, (text, solution.reason))))


def _unseen(request, Q):
    """A mode on the imaginary axis that Q doesn't see, exactly, or None: no gain
    attains the least cost then, as the Riccati gain's loop has it on the axis.
    """
    (d,) = request.vertices_in(exact, request.distinct)
    part = fixed_part(d.E.T, d.A.T, exact(Q))
    zero, one = exact(np.zeros((1, 1))), exact(np.eye(1))
    for mode in part.modes() if part is not None else ():
        if mode.inside(zero, one) is mode.inside(zero, -one) is False:
            return mode
    return None


def _with_any_gain(solution):
    """The Solution of a request in which nobody gave the gain: it may be rounded."""
    return replace(solution, request=replace(solution.request, gain=None))


def _first_optimum(request, objective):
    """The least bounds and a point that nearly keeps them; None and the lack of one.
    Many gains may have the least cost, as where noise moves few states: of those that
    miss it by less than `AMID` times its accuracy it is the analytic centre's, which
    neither units nor the order of vertices change.
    """
    for gap in OPTIMUM_GAPS:
        try:
            bounds, best = optimum(request, objective, gap)
            break
        except Unattained:  # not to be had in floats
            if gap == OPTIMUM_GAPS[-1]:
                raise
    if bounds is not None and not too_many(request):
        nearly = {name: (1 + AMID * gap) * b for name, b in bounds.items()}
        lmis, values = best.problem.led(best.values, request.with_bounds(nearly))
        amid = analytic_centre(lmis, lmis.text.packed(values))
        if amid is not None:
            lmis, x = amid
            best = LMISolution(lmis, unpacked(lmis.unknowns, x))
    return bounds, best
