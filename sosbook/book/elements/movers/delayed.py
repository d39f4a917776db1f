"""A loop with a delay in the page: its roots, and a delay that moves."""

import numpy as np

from ....plants.checks import positive
from ..page import significant
from .mover import Mover, choice, slider

__all__ = ["delayed"]

HINT = (
    "Let the delay grow until a pair of roots reaches the axis. Then stay a little "
    "below and choose the clinging delay."
)
STEPS = 1200


class Delayed(Mover):
    tag, script = "sos-delayed", "delayed"


def delayed(
    loops,
    longest,
    *,
    horizon,
    window,
    rest=1.0,
    start=None,
    title="Late inputs",
    hint=HINT,
):
    """Loops x' = A x + A_d x(t - d(t)) whose delay can be moved.

    The page finds the characteristic roots for a constant delay h on
    Chebyshev nodes and polishes them by Newton's method, and it
    integrates the loop. The clinging delay grows with the time up to h,
    stays there for ``rest`` seconds and starts again.

    Parameters
    ----------
    loops : dict
        (A, A_d) for each name; square matrices of up to 5 states.
    longest : float
        The longest delay, in s.
    horizon : float
        How long the loop is simulated, in s.
    window : ((float, float), (float, float))
        What the map of roots shows, in 1/s and rad/s.
    rest : float
        In s.
    start : float, optional
        The delay at first, in s; half of the longest without it.
    title, hint : str
        The heading, and what to try.

    Returns
    -------
    Mover
        The element.

    Raises
    ------
    ValueError
        If a loop has more than five states or isn't square.

    Examples
    --------
    >>> delayed({"integrator": ([[0]], [[-1]])}, 1.7, horizon=30,
    ...         window=((-4, 1), (-12, 12)))
    Delayed: h, gain, kind
    """
    stored = []
    for name, (A, A_d) in loops.items():
        A, A_d = np.asarray(A, float), np.asarray(A_d, float)
        if A.ndim != 2 or A.shape[0] != A.shape[1] or A.shape != A_d.shape:
            raise ValueError(f"loops[{name!r}] must be two square matrices alike")
        if len(A) > 5:
            raise ValueError(f"loops[{name!r}] must have 5 states at most")
        shown = [[[significant(x, 10) for x in row] for row in M] for M in (A, A_d)]
        stored.append({"name": name, "A": shown[0], "Ad": shown[1]})
    step = 10.0 ** np.floor(np.log10(positive("longest", longest)) - 2)
    kinds = ("constant", "clinging: it grows with the time, then starts again")
    return Delayed(
        title,
        hint,
        [
            *([choice("loop", "Loop", loops)] if len(loops) > 1 else []),
            slider("h", "Delay h", " s", (0, longest), step, start or longest / 2),
            slider("gain", "Gain", " ×", (0.1, 2), 0.05, 1),
            choice("kind", "The delay is", kinds),
        ],
        loops=stored,
        horizon=positive("horizon", horizon),
        steps=STEPS,
        rest=rest,
        window=window,
    )
