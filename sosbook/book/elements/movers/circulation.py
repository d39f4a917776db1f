"""Circulation in the page: energy that a skew stiffness gives and damping takes."""

import numpy as np

from .mover import Mover, slider

__all__ = ["circulation"]

START = [0.2, 0.2]
HINT = (
    "Find the κ at which the hand's path neither dies out nor grows. How much damping "
    "does the robot need at κ = 1.5?"
)


class Circulation(Mover):
    tag, script = "sos-circulation", "circulation"


def circulation(plant):
    """A robot whose circulatory force can be turned up and down.

    Parameters
    ----------
    plant : SecondOrderSystem
        The robot with two coordinates. The skew part of its S is what
        the slider kappa multiplies.

    Returns
    -------
    Mover
        The element.

    Raises
    ------
    ValueError
        If the plant hasn't two coordinates.

    Examples
    --------
    >>> from sosbook.book import thesis
    >>> circulation(thesis.example_1().plant)
    Circulation: kappa, damping
    """
    if plant.n != 2:
        raise ValueError(f"plant must have two coordinates, got {plant.n}")
    S = np.asarray(plant.S)
    return Circulation(
        "Energy: turn the circulation",
        HINT,
        [
            slider("kappa", "Circulation κ", "", (0, 2), 0.01, 1),
            slider("damping", "Damping", " × the robot's", (0.2, 2), 0.05, 1),
        ],
        M=plant.M.tolist(),
        D=plant.D.tolist(),
        S=((S + S.T) / 2).tolist(),
        K=((S - S.T) / 2).tolist(),
        start=START,
    )
