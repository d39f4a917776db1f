"""The numbers of the C program in the page: literals, bits and one tick."""

import numpy as np

from .mover import Mover, choice, slider

__all__ = ["digits"]

HINT = (
    "Switch to single precision: which bits go, and by how much does the voltage of "
    "this tick change? Compare with the encoder's step, which is far coarser."
)
STATES = ("θ", "φ", "θ′", "φ′", "∫φ")


class Digits(Mover):
    tag, script = "sos-digits", "digits"


def digits(K):
    """A gain as the C program writes it, and what a tick makes of it.

    Parameters
    ----------
    K : (1, 5) array_like
        The gain of V = K [theta, phi, theta', phi', integral of phi].

    Returns
    -------
    Mover
        The element.

    Raises
    ------
    ValueError
        If K hasn't five finite entries.

    Examples
    --------
    >>> digits([[17.0, 0.6, 1.6, 0.8, 0.3]])
    Digits: entry, precision, tilt, rate
    """
    K = np.ravel(np.asarray(K, float))
    if K.size != 5 or not np.isfinite(K).all():
        raise ValueError(f"K must have five finite entries, got {K}")
    return Digits(
        "The numbers of the program",
        HINT,
        [
            choice("entry", "Gain of", STATES),
            choice("precision", "Precision", ["double", "single"]),
            slider("tilt", "Tilt θ", "°", (-20, 20), 0.5, 3),
            slider("rate", "Rate θ′", " rad/s", (-2, 2), 0.05, 0.1),
        ],
        K=K.tolist(),
    )
