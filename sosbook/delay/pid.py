"""Procedure 2.2: a PID controller for a plant with a delayed input."""

from dataclasses import replace
from typing import Any, Literal

import numpy as np

from ..laws import Law, Scheduled
from ..laws.taken import law_of, taken
from ..loops import Loop, opened
from ..plants.checks import matrix
from ..plants.kinds import SecondOrderPlant
from ..runtime.array_like import ArrayLike
from ..runtime.threads import one_thread
from ..synthesis.families import in_pieces
from .design import DelayDesign
from .request import DelayedLoop, DelayRequest, check_loop
from .rising import solve_rising, with_truth
from .searched import searched
from .solve import first_design, solve_delay, within
from .theorems import MISPRINTS


@one_thread
def design_delay_pid(
    plant: SecondOrderPlant,
    U: ArrayLike | None = None,
    tau: float | None = None,
    mu: float = 0.0,
    delta: float = 0.0,
    *,
    alpha: float | None = None,
    K_A: None = None,
    law: Law | None = None,
    method: Literal["functional", "shift"] = "functional",
    printed: bool = False,
    time_limit: float | None = None,
    progress: bool = False,
) -> DelayDesign:
    r"""Design a PID controller whose input arrives late.

    Parameters
    ----------
    plant : SecondOrderSystem, Polytope or Uncertain
        With regular masses. A polytope gets one functional for all its
        plants; they may even change with time.
    U : (a, n) array_like, optional
        Which displacement errors are integrated.
    tau, mu : float
        The delay d(t) stays in [tau - mu, tau + mu], in seconds, and may
        vary there as fast as it likes; tau > 0, 0 <= mu <= tau.
    delta : float
        Decay rate, in 1/s; 0 asks for stability.
    alpha : float, optional
        The positive scalar of Theorem 2.3, in seconds. Without it the
        first of some multiples of tau that succeeds.
    K_A : None
        Must be left out (or zero): see Raises.
    law : Law, optional
        In the place of U. Gains of a PIDLaw, a DynamicLaw or a ShapedLaw are searched
        by `design_pid` behind a filter like the delay, then proven with the delay.
    method : {"functional", "shift"}
        "functional" is the thesis's theorem, corrected. "shift" designs
        for stability of :math:`e^{\delta t} x(t)`, whose input comes
        multiplied by :math:`e^{\delta d}`, an uncertain factor.
    printed : bool
        Read Theorem 2.3 as printed: unsound, for study only.
    time_limit : float, optional
        In seconds; without it the search takes as long as it takes. What
        isn't finished then is "undecided".
    progress : bool
        Show a bar of the seconds that have passed.

    Returns
    -------
    DelayDesign
        The analytic centre of the LMIs, which are a cone, within a bound of
        the unknowns. "infeasible" is proven exactly, and says that no gain has
        such a proof (at this alpha), not that no gain has the rate.

    Raises
    ------
    ValueError
        On bad input, or a scheduled gain. Acceleration feedback through a delay makes a
        neutral loop, M z''(t) - B K_A z''(t - d), which the theorems don't cover.

    Notes
    -----
    Source: thesis, Procedure 2.2 and Theorem 2.3 with its errata.

    Examples
    --------
    >>> from sosbook import SecondOrderSystem
    >>> plant = SecondOrderSystem(
    ...     M=np.eye(2), D=[[1, -1], [-1, 1]], S=[[3, -2], [-2, 3]],
    ...     B=[[1], [0]])
    >>> d = design_delay_pid(plant, U=[[1, 0]], tau=0.4, mu=0.2,
    ...                      delta=0.1, alpha=0.8)
    >>> d.status, d.certify().proven, d.slowest_decay()[0] > 0.1
    ('feasible', True, True)
    """
    if K_A is not None and np.any(matrix("K_A", K_A)):
        raise ValueError(
            "K_A must be zero with a delayed input: it makes the loop neutral, M z''(t)"
            " - B K_A z''(t - d), which the theorems don't cover; leave K_A out"
        )
    if isinstance(plant, DelayedLoop):
        raise ValueError("a DelayedLoop leaves nothing to design: use analyse_delay")
    law = law_of(U, law)
    if isinstance(law, Scheduled):
        raise ValueError(
            "law: a gain that is scheduled isn't designed behind a delay; the law "
            "inside it is, with one gain for all plants"
        )
    request = DelayRequest(
        *(plant, law.U if law.whole else None, tau, mu, delta, alpha, method),
        misprints=("sign",) if printed else (),
    )
    if not law.whole:
        return within(time_limit, request, lambda: searched(request, law), progress)
    return _in_pieces(request, first_design, time_limit, progress)


@one_thread
def analyse_delay(
    plant: SecondOrderPlant | DelayedLoop,
    K: Any = None,
    U: ArrayLike | None = None,
    tau: float | None = None,
    mu: float = 0.0,
    delta: float = 0.0,
    *,
    law: Law | None = None,
    method: Literal["functional", "shift", "legendre", "interval"] = "functional",
    order: int | None = None,
    printed: bool | float = False,
    time_limit: float | None = None,
    progress: bool = False,
) -> DelayDesign:
    """Find a certificate of decay under delay for a given gain.

    Parameters
    ----------
    plant : SecondOrderSystem, Polytope or DelayedLoop
        The plant, or a loop as it is.
    K : (m, N) array_like, dict, Gain, design or StateSpace
        As in `analyse_pid`; left out for a `DelayedLoop`.
    U, tau, mu, delta
        As in `design_delay_pid`.
    law : Law, optional
        As in `analyse_pid`. The loop is opened where u enters the plant, and the
        proof is of the plant with the law's memory in it: see `Loop.opened`.
    method : {"functional", "shift", "legendre", "interval"}
        "functional" is Theorem A.3, corrected, with G free. For one plant:
        "legendre" uses Bessel's inequality, "interval" the functional over
        the whole interval with the reciprocally convex bound. Of these two
        the first is sharper for a small mu, the second for a large one.
    order : int, optional
        Of Bessel's inequality. For "legendre" 0, 1, ...; without it 2, and higher ones
        where that proves nothing and floats see a stable loop. For "interval" 0 or 1 (1
        without it).
    printed : bool or float
        Read Theorem A.3 as printed: unsound, for study only. A number is the factor
        alpha in the printed (A.20), without unit; True is one.
    time_limit : float, optional
        In seconds; without it the search takes as long as it takes. What
        isn't finished then is "undecided".
    progress : bool
        Show a bar of the seconds that have passed.

    Returns
    -------
    DelayDesign
        With this very K; "infeasible" is proven exactly, and says that no functional of
        this form proves the rate, not that the loop is slower.

    Notes
    -----
    Source: thesis, Theorem A.3 with its errata; Seuret and Gouaisbaut
    (2015) for "legendre"; Park, Ko and Jeong (2011) and Seuret and
    Gouaisbaut (2013) for "interval".

    Examples
    --------
    >>> from sosbook.delay import DelayedLoop
    >>> loop = DelayedLoop([[-2, 0], [0, -0.9]], [[-1, 0], [-1, -1]])
    >>> analyse_delay(loop, tau=6.16, method="legendre").status
    'feasible'
    """
    if K is None and not isinstance(plant, DelayedLoop):
        raise ValueError("K is missing: give the gain to be analysed")
    check_loop(plant, K, U)
    source = None
    if not isinstance(plant, DelayedLoop):
        known, K = taken(plant, K, law, U)
        if not known.whole:
            source = Loop(plant, known, K)
        plant, K, U = opened(plant, K, None, known)
    alpha = None if printed is True or not printed else printed
    asked = plant, U, tau, mu, delta, alpha, method, order
    request = DelayRequest(*asked, MISPRINTS if printed else (), K)
    if method == "legendre" and order is None:
        design = solve_rising(request, time_limit, progress)
    else:
        design = _in_pieces(request, solve_delay, time_limit, progress)
    design = replace(design, source=source)
    return design if design.status == "feasible" else with_truth(design)


def _in_pieces(request, solve, seconds, progress):
    """The `DelayDesign` of a request; ranges of a family are cut where that helps."""
    if request.plant.family is None:
        return solve(request, time_limit=seconds, progress=progress)
    return within(seconds, request, lambda: in_pieces(request, {}, solve), progress)
