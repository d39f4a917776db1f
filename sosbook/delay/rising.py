"""Bessel's order raised until it proves, and a constant delay proven in pieces."""

from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from ..exact.definite import round_digits
from ..exact.rational import exact
from ..laws import Law
from ..loops import opened
from ..plants.checks import not_negative
from ..runtime.array_like import ArrayLike
from ..runtime.read_only import ReadOnly
from ..runtime.threads import one_thread
from ..runtime.time_limit import OutOfTime, check_time, checked_seconds
from ..runtime.time_limit import time_limit as limited
from .design import DelayDesign
from .request import DelayRequest, check_loop
from .solve import solve_delay, within

ORDERS = 2, 4, 6, 9, 13, 18, 24  # of Bessel's inequality, in the order of trial
MOST_ROWS = 80  # of the functional's matrix, where nobody gave an order
MOST_PIECES = 64  # of an interval of constant delays
NARROW = 32  # a piece so many times narrower is as good as its middle


def orders(request):
    """The orders that are tried for a ``request``: those above have large LMIs."""
    return [k for k in ORDERS if (1 + k) * request.states <= MOST_ROWS] or ORDERS[:1]


def solve_rising(request, time_limit=None, progress=False):
    """The `DelayDesign` of a ``request`` with the first order that proves it.

    A higher order proves all that a lower one does (Seuret and Gouaisbaut, 2015), so
    that nothing is refused which a higher one may prove: a loop that is slow for a
    constant delay of the interval, in floats, is left to the first order, whose refusal
    says that. ``time_limit`` and ``progress`` are as for `solve_delay`.
    """
    return within(time_limit, request, partial(_rising, request), progress)


def _rising(request):
    """The result of `solve_rising` without a limit of time."""
    first, *higher = orders(request)
    found = solve_delay(request.at(order=first))
    known = None if found.status == "feasible" else _slowest(request)
    if found.status == "feasible" or (known and known[0] <= request.delta):
        return found
    for order in higher:
        check_time()
        found = solve_delay(request.at(order=order), refuse=False)
        if found.status == "feasible":
            return replace(found, reason=f"Bessel's order was raised to {order}.")
    tried = ", ".join(map(str, (first, *higher)))
    text = f"no proof was found with the orders {tried}, "
    if request.mu:
        text += "and a delay that is constant is proven in pieces by constant_delays"
    else:
        text += "and a higher order=... may prove it"
    return replace(found, status="undecided", reason=text)


def _slowest(request):
    """The slowest decay, and the constant delay where it occurs, in floats; None where
    the delay is too long for that.
    """
    try:
        return DelayDesign(request, "undecided", request.gain).slowest_decay()
    except ValueError:
        return None


def with_truth(design):
    """A ``design`` of a given gain that isn't feasible, whose reason says how slow the
    loop is: a functional may fail where the loop doesn't.
    """
    known = _slowest(design.request)
    if known is None:
        truth = "its delay is too long for its roots to be computed"
    else:
        truth = "in floats the slowest constant delay of the interval, {1:.4g} s, "
        truth = truth.format(*known) + f"decays with {known[0]:.3g} 1/s"
        if known[0] <= design.request.delta:
            truth += ", which is less than was asked"
    if design.status == "infeasible":
        reason = f"I{truth[1:]}. No functional of this form proves it."
        return replace(design, reason=reason)
    return replace(design, reason="; ".join(filter(None, (design.reason, truth))))


@dataclass(frozen=True, eq=False)
class ConstantDelays(ReadOnly):
    """A loop whose delay is constant, and unknown in [low, high], proven in pieces.

    Parameters
    ----------
    low, high : float
        The interval, in s.
    status : {"feasible", "undecided"}
        Whether each piece has a proof.
    parts : tuple of DelayDesign
        One for each piece that is proven, the shortest delays first.
    reason : str
        Which delay has no proof, and what is known of it in floats.
    """

    low: float
    high: float
    status: str
    parts: tuple = ()
    reason: str = ""

    def __repr__(self):
        pieces = f"{len(self.parts)} pieces of [{self.low:g}, {self.high:g}] s"
        return f"<ConstantDelays: {self.status}, {pieces}>"

    @property
    def covered(self) -> bool:
        """True if the pieces hold every delay of the interval, in rationals."""
        reach = exact(self.low)
        for part in self.parts:
            tau, mu = exact(part.request.tau), exact(part.request.mu)
            if tau - mu > reach:
                return False
            reach = max(reach, tau + mu)
        return bool(reach >= exact(self.high))

    def certify(self) -> tuple:
        """The proofs, one `DelayProof` for each piece; of a delay that is constant in
        [low, high] one of them speaks, whichever it is.

        Raises
        ------
        ValueError
            Where a piece has no proof.
        """
        proofs = tuple(part.certify() for part in self.parts)
        if self.status != "feasible" or not self.covered:
            raise ValueError(f"the delays are {self.status}: {self.reason}")
        if not all(proof.proven for proof in proofs):
            raise ValueError("a piece isn't proven in exact arithmetic")
        return proofs


@one_thread
def constant_delays(
    plant: Any,
    K: Any = None,
    U: ArrayLike | None = None,
    *,
    low: float,
    high: float,
    delta: float = 0.0,
    law: Law | None = None,
    time_limit: float | None = None,
) -> ConstantDelays:
    """Prove a loop for every constant delay of an interval.

    In each piece of it the delay may even vary, so that a piece which has no such proof
    is halved; its order is raised where the middle alone asks for that.

    Parameters
    ----------
    plant, K, U
        As in `analyse_delay`; one plant.
    low, high : float
        The interval of delays, in s; 0 < low <= high.
    delta, law
        As in `analyse_delay`.
    time_limit : float, optional
        In seconds; what isn't proven then is "undecided".

    Returns
    -------
    ConstantDelays
        With a `DelayDesign` for each piece.

    Raises
    ------
    ValueError
        On bad input, or several plants.

    Notes
    -----
    Source: Seuret and Gouaisbaut (2015): for one delay and one stable loop some order
    proves it, and then a small interval around it. So finitely many pieces cover an
    interval in whose every constant delay the loop is faster than delta.

    Examples
    --------
    >>> from sosbook.delay import DelayedLoop
    >>> loop = DelayedLoop([[-0.5]], [[-1]])  # stable below 2.418 s
    >>> found = constant_delays(loop, low=0.1, high=2.3)
    >>> found.status, all(proof.proven for proof in found.certify())
    ('feasible', True)
    >>> constant_delays(loop, low=0.1, high=2.5).status
    'undecided'
    """
    low, high = not_negative("low", low), not_negative("high", high)
    if not 0 < low <= high:
        raise ValueError(
            f"low = {low:g} and high = {high:g} must be 0 < low <= high, in s"
        )
    check_loop(plant, K, U)
    if not hasattr(plant, "A_d"):
        plant, K, U = opened(plant, K, U, law)
    if len(plant.vertices) > 1:
        raise ValueError(
            "constant_delays takes one plant: ask it of each vertex, or prove delays "
            "that may vary, of all plants, by analyse_delay"
        )
    asked = partial(DelayRequest, plant, U, delta=delta, method="legendre", gain=K)
    whole = asked(**_around(low, high))
    known = _slowest(whole)
    if known is not None and known[0] <= delta:
        text = "in floats the constant delay {1:.6g} s has the decay {0:.3g} 1/s"
        text = text.format(*known)
        return ConstantDelays(low, high, "undecided", reason=text)
    seconds = checked_seconds(time_limit)
    parts: list = []
    try:
        with limited(seconds, False):
            left = _pieces(asked, low, high, parts)
    except OutOfTime as over:
        if seconds is None:
            raise
        left = over.words(seconds)
    status = "undecided" if left else "feasible"
    return ConstantDelays(low, high, status, tuple(parts), left)


def _around(a, b):
    """A tau and a mu whose interval, in decimals, holds that from a to b."""
    tau = (a + b) / 2
    wanted = max(exact(tau) - exact(a), exact(b) - exact(tau))
    mu = float(wanted)
    while exact(mu) < wanted:
        mu = float(np.nextafter(mu, np.inf))
    return {"tau": tau, "mu": mu}


def _pieces(asked, low, high, parts):
    """Fill ``parts`` with a design for each piece; why there are no more, or ""."""
    waiting, order = [(low, high)], 0
    several = orders(asked(tau=high))

    def tried(a, b):
        request = asked(**_around(a, b))
        check_time()
        return solve_delay(request.at(order=several[order]), False, centred=False)

    while waiting:
        a, b = waiting.pop()
        found = tried(a, b)
        if found.status == "feasible":
            parts.append(found)
            continue
        middle = float(round_digits(np.array((a + b) / 2), 6))
        off = (b - a) / (2 * NARROW)
        if tried(middle - off, middle + off).status == "feasible":
            waiting += [(middle, b), (a, middle)]
        elif order + 1 < len(several):
            order += 1
            waiting.append((a, b))
        else:
            return f"no order up to {several[-1]} proves the delay {middle:.6g} s"
        if len(parts) + len(waiting) > MOST_PIECES or not a < middle < b:
            return f"{MOST_PIECES} pieces aren't enough around {middle:.6g} s"
    return ""
