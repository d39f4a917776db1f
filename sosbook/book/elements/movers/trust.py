"""Status against proof in the page: tolerances, digits, and exact integers."""

import numpy as np
from scipy.optimize import brentq

from ....plants.second_order import SecondOrderSystem
from .mover import Mover, slider

__all__ = ["trust"]

HINT = (
    "Turn the circulation κ past 0.98, where the plant loses stability: which rung "
    "still says yes? Then tighten the tolerance, and round P to fewer digits."
)


class Trust(Mover):
    tag, script = "sos-trust", "trust"


def trust(plant):
    """A Lyapunov inequality near the edge, on four rungs of the ladder.

    P solves the Lyapunov equation of the plant with kappa times its
    circulation, or where that is unstable, of the last stable one. The
    page rounds P to some digits, looks at the blocks with a
    solver's tolerance and in floats, and proves them in exact integers.

    Parameters
    ----------
    plant : SecondOrderSystem
        Two coordinates; its entries are read as decimals.

    Returns
    -------
    Mover
        The element.

    Raises
    ------
    ValueError
        If the plant hasn't two coordinates, or no kappa up to 2 makes it
        unstable.

    Examples
    --------
    >>> from sosbook.book import thesis
    >>> trust(thesis.example_1().plant)
    Trust: kappa, tolerance, digits
    """
    if plant.n != 2:
        raise ValueError(f"plant must have two coordinates, got {plant.n}")
    S = np.asarray(plant.S)
    spring, turn = (S + S.T) / 2, (S - S.T) / 2

    def rightmost(kappa):
        moved = SecondOrderSystem(plant.M, plant.D, spring + kappa * turn, plant.B)
        return moved.poles().real.max()

    edge = brentq(rightmost, 0, 2, xtol=1e-6)
    return Trust(
        "Status against proof",
        HINT,
        [
            slider("kappa", "Circulation κ", "", (0.9, 1.05), 0.001, 0.96),
            slider("tolerance", "Tolerance: power of ten", "", (-9, -1), 1, -2),
            slider("digits", "Digits of P", "", (1, 12), 1, 6),
        ],
        M=plant.M.tolist(),
        D=plant.D.tolist(),
        S=spring.tolist(),
        K=turn.tolist(),
        held=round(edge, 3) - 0.001,
    )
