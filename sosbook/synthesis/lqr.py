"""Procedures 2.3 and 2.4: PID and PD controllers of least quadratic cost."""

from dataclasses import replace

from ..requirements.cost import QuadraticCost
from .feasibility import answer, gain_of
from .objectives import optimum, with_slack
from .pid import Design
from .problem import Request

__all__ = ["design_lqr"]

GAPS = 1e-10, 1e-8, 1e-6  # to which the optimum is known; the first that succeeds
BACKOFF = 1e-4  # the proven bound exceeds the optimum by this


def design_lqr(plant, Q, R, U=None, K_A=None, noise="states",
               coupling="pairs", slack=None, region=None):
    r"""Design the PID (without ``U`` PD) controller of least cost bound.

    Parameters
    ----------
    plant : SecondOrderSystem or Polytope
    Q : (N, N) array_like
        Weight of the state [z; z'; x3], symmetric, not negative.
    R : (m, m) array_like
        Weight of the input, symmetric and positive definite.
    U, K_A, coupling, slack, region
        As in `design_pid`.
    noise : {"states", "F"}
        As in `QuadraticCost`.

    Returns
    -------
    Design
        K is the optimum of Theorem 2.4; for one plant it is the gain of
        the Riccati equation. Its certificate is of K and a bound one in
        ten thousand above the optimum: ``.request.cost.bound``.

    Raises
    ------
    ValueError
        On bad input.

    Notes
    -----
    Source: thesis Theorem 2.4, Procedures 2.3 and 2.4. The bound is
    tr J for noise of intensity one (not its square root).

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
    request = Request(plant, U, region, K_A=K_A, coupling=coupling,
                      slack=slack, requirements=[asked])
    objective = {name: 1.0}
    request, found = with_slack(request, objective)
    if not found:
        return Design(request, "undecided")
    values, x, frame = _first_optimum(request, objective)
    if values is None:
        return Design(request, x.verdict, frame=frame, multipliers=x.Z)
    gain = gain_of(request, frame, request.unknowns(), x)
    bound = float(f"{values[name] * (1 + BACKOFF):.5e}")
    found = answer(replace(request.with_bounds({name: bound}), gain=gain))
    return Design(**vars(found))


def _first_optimum(request, objective):
    for gap in GAPS[:-1]:
        try:
            return optimum(request, objective, gap)
        except ValueError:  # not to be had in floats
            pass
    return optimum(request, objective, GAPS[-1])
