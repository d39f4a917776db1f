"""A gain that asks little of the input, to start from where the input is bounded.

A frame's own gain makes the loop as fast as `Request.typical_rate`, and a bound of the
input often forbids that. The Riccati equation

    (A + s I)' X + X (A + s I) - X B B' X + w I = 0

asks no more than to decay a little faster than the poles' half-plane does. In a frame
P = c / X and Y = -c B' are a point where that holds, and from x0 the input stays below
sqrt(x0' X x0 |B' X B|) there, which falls with the weight w.
"""

import numpy as np

from ..analysis.riccati import riccati
from ..solver.newton import newton_of
from ..solver.primal_dual import positive

__all__ = ["start_of"]

FASTER = 1.05  # times the decay rate that is asked
SLOWEST = 1e-3  # of the typical rate, where none is asked
WEIGHT = 0.1  # by that rate, of all states at first
TRIES = 3  # of weights
ENOUGH = 0.5  # of the bound's square: less leaves room inside
AIM = 0.2  # of it, with the next weight


def start_of(lmis):
    """A point to begin a search from, by the unknowns' names, or None.

    It is the frame's guess where this lies inside, and where no gentle gain does.

    Parameters
    ----------
    lmis : ScaledLMIs
        All blocks of a request in a frame.
    """
    guess = lmis.guess()
    if guess is None or _holds(lmis, guess):
        return guess
    gentle = _gentle(lmis, guess)
    return gentle if gentle is not None and _holds(lmis, gentle) else guess


def _holds(lmis, values):
    return positive(newton_of(lmis.compiled).at(lmis.packed(values)))


def _gentle(lmis, guess):
    """A point with a gentle gain; None where more than the input is bounded."""
    request, frame = lmis.request, lmis.frame
    sized = request.sized
    x0 = sized[0].bounds_input_from() if len(sized) == 1 and not lmis.free else None
    if x0 is None or request.gain is not None:
        return None
    A, B, _ = request.mean.change(frame.left, frame.T, frame.scale).state_space()
    one, x0, most = np.eye(len(A)), frame.back @ x0, (sized[0].bound / frame.scale) ** 2
    rate = max(FASTER * _decay(request), SLOWEST * request.typical_rate)
    weight = WEIGHT * rate
    for _ in range(TRIES):
        try:
            X = riccati(A + rate * one, B, weight * one, np.eye(B.shape[1]))
        except np.linalg.LinAlgError:
            return None
        reach, effort = x0 @ X @ x0, np.linalg.norm(B.T @ X @ B, 2)
        if reach * effort < ENOUGH * most:
            size = np.sqrt(reach * most / effort)  # between what both blocks need
            P = size * np.linalg.inv(X)
            point = dict.fromkeys(("V", *request.lyapunov), (P + P.T) / 2)
            return (
                guess | {n: point[n] for n in guess if n in point} | {"Y": -size * B.T}
            )
        weight *= AIM * most / (reach * effort)
    return None


def _decay(request):
    """The decay rate that half-planes ask, in 1/s; 0 without any."""
    rates = [r.rate() for r in request.demands if r.rate()]
    return max((rate / 4 for rank, rate in rates if rank == 1), default=0)
