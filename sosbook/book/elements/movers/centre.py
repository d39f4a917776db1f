"""A set of LMIs that can be drawn, its centre and the way there, in the page."""

import numpy as np

from .mover import Mover, slider

__all__ = ["centre"]

HINT = (
    "Move your point until both bars are above zero. Then ask for a faster decay σ: "
    "the set shrinks around its centre and vanishes at the true rate."
)


class Centre(Mover):
    tag, script = "sos-centre", "centre"


def centre(A, *, start=(1.5, -0.6), sigma=0.3, title="The set and its centre", hint=""):
    """The feasible set of P = [p q; q 1] for a decay rate, in the page.

    The page walks from the reader's point to the analytic centre by
    Newton's method, the decrement beside each step.

    Parameters
    ----------
    A : (2, 2) array_like
        The matrix of x' = A x.
    start : (float, float)
        p and q at first.
    sigma : float
        The decay rate at first, in 1/s.
    title, hint : str
        The heading, and what to try; without a hint the one of the set.

    Returns
    -------
    Mover
        The element.

    Raises
    ------
    ValueError
        If A isn't 2 x 2.

    Examples
    --------
    >>> centre([[0, 1], [-2, -3]])
    Centre: sigma, p, q
    """
    A = np.asarray(A, float)
    if A.shape != (2, 2):
        raise ValueError(f"A must be 2 x 2, got the shape {A.shape}")
    p, q = start
    return Centre(
        title,
        hint or HINT,
        [
            slider("sigma", "Decay rate σ", " s⁻¹", (0, 1.2), 0.01, sigma),
            slider("p", "p of your point", "", (0, 4), 0.02, p),
            slider("q", "q of your point", "", (-1.8, 0.5), 0.02, q),
        ],
        A=A.tolist(),
    )
