"""Procedure 2.5: an observer for a known state feedback."""

from collections.abc import Sequence
from dataclasses import replace
from time import monotonic

import numpy as np

from ..lmi.solution import LMISolution
from ..plants.checks import matrices_of, matrix
from ..plants.descriptor import mean_descriptor
from ..plants.descriptor_system import DescriptorSystem
from ..plants.gain import gain_of
from ..plants.kinds import Plant, checked_plant
from ..requirements.pole_region import Region
from ..runtime.array_like import ArrayLike
from ..runtime.threads import one_thread
from ..runtime.time_limit import OutOfTime, checked_seconds
from ..runtime.time_limit import time_limit as limited
from ..solver.loop import Unbounded
from .error_loop import vertices_of
from .feasibility import FROM_STATES
from .observer_design import ObserverDesign
from .observer_model import ObserverModel, loads_of
from .observer_problem import ObserverProblem
from .pid import design_pid
from .riccati_point import bound_of, riccati_observer
from .search import USUAL, Search

REFUSED = (
    "Exact multipliers of the LMIs exclude every observer with this K by Theorem 2.5; "
    "others may do."
)
REFUSED_IN_FLOATS = (
    "Multipliers in floating point exclude every observer with this K by Theorem 2.5; "
    "no exact proof was found. Others may do."
)
OF_TRANSPOSED = "Of the transposed plant, whose input is C', which sees its modes:"
NOTHING_FOUND = (
    "The numerics found neither an observer with this K by Theorem 2.5 nor multipliers "
    "that exclude it."
)
TOO_THIN = (
    "The numerics found an observer whose margins are below what floats can tell from "
    "zero."
)


@one_thread
def design_observer(
    plant: Plant,
    K: ArrayLike,
    Q_F: ArrayLike | None = None,
    R_F: ArrayLike | None = None,
    *,
    region: Region | None = None,
    C: ArrayLike | None = None,
    B_w: ArrayLike | Sequence[ArrayLike] | None = None,
    disturbance: ArrayLike | bool | None = None,
    reduced: bool = False,
    time_limit: float = USUAL.time_limit,
) -> ObserverDesign:
    """Design an observer for a known state feedback (Theorem 2.5), or by its poles.

    Parameters
    ----------
    plant : SecondOrderSystem, Polytope, Uncertain or DescriptorSystem
        Without integrators: an integral is a state of a DescriptorSystem, and
        measured.
    K : (m, N) array_like
        The gain of u = K x.
    Q_F : (2N, k) array_like
        Q = Q_F Q_F' weighs the dual state; its upper half is where
        noise enters the estimate.
    R_F : (q, q) array_like
        R = R_F R_F': covariance of the measurement noise.
    region : PoleRegion or LMIRegion, optional
        In the place of Q_F and R_F: where the poles of the error lie, for each plant
        under its own model. The plant may be one of discrete time.
    C : (q, N) array_like, optional
        What is measured; the plant's own C without it.
    B_w : (N, p) array_like, or one for each vertex, optional
        Where the noise of the cost (2.44) enters; the plant's own without it, or E
        where the plant has none: then tr J bounds the sum of the variances of the
        error. Of one plant L doesn't depend on it, only the bound does.
    disturbance : (N, p) array_like or True, optional
        With a ``region``: where loads enter E x' that stay constant. They are
        estimated, too, and u cancels them: in a stable loop what is measured comes to
        rest at zero, if the loads are as many. True: one beside each input.
    reduced : bool
        With a ``region``: whether the sensors are believed, and only the rest of the
        state is estimated. Then u jumps with y.
    time_limit : float
        Seconds after which the answer is "undecided".

    Returns
    -------
    ObserverDesign
        The observer's gain, and what is known of its loop.

    Notes
    -----
    By a ``region`` L is the gain of the transposed plant, with C' in the place of B:
    A + L C and A' + C' L' have the same poles (R. E. Kalman, 1960). Then
    ``certify`` proves the loop, ``observer.loop.prove(HInfinity(...))`` a norm of it.

    Source: thesis (2.43)-(2.45), Procedure 2.5. With Q_F and R_F as
    section 4.3.2 uses them (it prints them under each other's name).
    Where several observers have the least cost it is the central one, if that is found.
    The theorem divides by E, so neither its vertices nor their pairs
    say anything about the plants between: see `ObserverDesign.analyse`.

    Examples
    --------
    >>> from sosbook import SecondOrderSystem, design_lqr
    >>> plant = SecondOrderSystem([[1]], [[0.1]], [[-1]], [[1]], [[1]])
    >>> K = design_lqr(plant, np.eye(2), [[1]]).K
    >>> observer = design_observer(
    ...     plant, K, Q_F=[[0], [1], [0], [0]], R_F=[[0.1]])
    >>> observer.status, observer.analyse().certify().proven
    ('feasible', True)
    """
    plant = checked_plant(plant, of=None if region else "design_observer by noise")
    vertices = vertices_of(plant)
    N = len(vertices[0].E)
    C = matrix("C", vertices[0].C if C is None else C, (None, N))
    K = matrix("K", gain_of(K, plant), (vertices[0].Bu.shape[1], None))
    if K.shape[1] != N:
        raise ValueError(
            f"K has {K.shape[1]} columns, needs {N}: here are no integrators; put the "
            "integral into the matrices of a DescriptorSystem, and measure it (a row "
            "of C)"
        )
    if len(C) == 0:
        raise ValueError("C is missing: the plant has no outputs, so say what is seen")
    if region is not None:
        if Q_F is not None or R_F is not None or B_w is not None:
            raise ValueError("give region, or the noise by Q_F and R_F, not both")
        if not isinstance(reduced, bool):
            raise ValueError(f"reduced must be True or False, got {reduced!r}")
        loads = loads_of(disturbance, N, mean_descriptor(vertices).Bu)
        model = ObserverModel(tuple(vertices), K, C, loads, reduced, region)
        return _by_region(plant, model, region, time_limit)
    if disturbance is not None or reduced:
        raise ValueError("disturbance and reduced need a region: give where poles lie")
    if Q_F is None or R_F is None:
        raise ValueError("give the noise by Q_F and R_F, or where poles lie by region")
    Q_F = matrix("Q_F", Q_F, (2 * N, None))
    R_F = matrix("R_F", R_F, (len(C), len(C)))
    if B_w is None:
        own = any(d.Bw.any() for d in vertices)
        noises = [d.Bw if own else d.E for d in vertices]
    else:
        noises = [matrix("B_w", w, (N, None)) for w in matrices_of("B_w", B_w)]
        if len(noises) not in (1, len(vertices)):
            raise ValueError(
                f"B_w has {len(noises)} matrices, needs {len(vertices)} or one"
            )
        noises *= len(vertices) // len(noises)
        if not any(w.any() for w in noises):
            raise ValueError("B_w is zero or has no column: leave it out")
    seconds, begun = checked_seconds(time_limit, needed=True), monotonic()
    try:
        with limited(seconds):
            problem = ObserverProblem(plant, vertices, K, Q_F, R_F, C, noises)
            return _solved(problem)
    except OutOfTime as over:
        if over.end < begun + seconds:  # somebody else's limit
            raise
        reason = over.words(seconds)
    except (Unbounded, ArithmeticError, np.linalg.LinAlgError) as error:
        reason = f"The numerics gave up ({error}): are the units far apart?"
    return ObserverDesign(plant, K, C, "undecided", reason=reason)


def _by_region(plant, model, region, seconds):
    """The design with the gain of the transposed plants, whose input is C'."""
    dual = DescriptorSystem.of(model.duals(), dt=getattr(plant, "dt", None))
    found = design_pid(dual, region=region, search=Search(time_limit=seconds))
    L = None
    if found.K is not None and found.status == "feasible":
        L = model.observer_gain(found.K)
    reason = "" if L is not None else f"{OF_TRANSPOSED} {found.reason}"
    loads = 0 if model.loads is None else model.loads.shape[1]
    if reason and loads > len(model.C):
        reason += (
            f" {loads} loads that stay aren't told apart by {len(model.C)} of the "
            "readings: measure as many as there are loads, or say by disturbance=... "
            "where fewer of them push."
        )
    known = dict(L=L, margins=found.margins, reason=reason, model=model)
    return ObserverDesign(plant, model.K, model.C, found.status, **known)


def _solved(problem):
    """The design of an `ObserverProblem`, by an equation or by the LMIs."""
    near = riccati_observer(problem)
    if near is not None:
        design = _certain(problem, *near)
        if design.status == "feasible":
            return design
    least, optimum = problem.optimum()
    if optimum.values is None:
        reason = NOTHING_FOUND
        if optimum.verdict == "infeasible":
            reason = REFUSED_IN_FLOATS
        refused = _design(problem, reason=reason, multipliers=optimum.multipliers)
        if refused.infeasibility is not None:
            return replace(refused, status="infeasible", reason=REFUSED)
        return refused
    known = optimum.values
    L = problem.gain(known)
    known = {name: x for name, x in known.items() if name != "Y"}
    return _certain(problem, L, bound_of(least), known)


def _certain(problem, L, bound, near):
    """The design of this L, with P1, P2 and J for the bound, ``near`` these."""
    lmis = problem.bounded(L, bound)
    large = len(problem.T[0]) >= FROM_STATES
    solution = LMISolution(lmis, near) if large else None
    if not large or solution.status != "feasible":
        solution = lmis.solve(start=near)
    if solution.values is None:
        reason = f"The numerics found an observer, but no proof of tr J < {bound:g}."
        return _design(problem, reason=reason)
    reason = "" if solution.status == "feasible" else TOO_THIN
    known = dict(L=L, bound=bound, margins=solution.margins, values=solution.values)
    return _design(problem, solution.status, reason=reason, **known)


def _design(problem, status="undecided", **known):
    asked = problem.plant, problem.K, problem.C
    return ObserverDesign(*asked, status, problem=problem, **known)
