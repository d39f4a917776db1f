"""What the integral is for, in the page: signs and sizes of K_I."""

import numpy as np

from .mover import Mover, slider

__all__ = ["integral"]

HINT = (
    "Set both factors to zero: what remains of the error, and what does the force do "
    "to it? Then make one of them negative, ever so little."
)


class Integral(Mover):
    tag, script = "sos-integral", "integral"


def integral(plant, K, U):
    """A PID loop with factors on both columns of K_I, in the page.

    The set point is 1 for both coordinates; from 10 s on a force pushes
    through F.

    Parameters
    ----------
    plant : SecondOrderSystem
        A plant with two coordinates and its F.
    K : (m, 6) array_like
        [K_P K_D K_I], with two integrals.
    U : (2, 2) array_like
        The errors that are integrated.

    Returns
    -------
    Mover
        The element.

    Raises
    ------
    ValueError
        If the shapes aren't these.

    Examples
    --------
    >>> from sosbook.book import thesis
    >>> example = thesis.example_1()
    >>> integral(example.plant, example.K, example.U)
    Integral: first, second, force
    """
    K, U = np.asarray(K, float), np.asarray(U, float)
    if plant.n != 2 or K.shape != (plant.m, 6) or U.shape != (2, 2):
        raise ValueError(
            "plant must have two coordinates, K the shape (m, 6) and U the "
            f"shape (2, 2), got {plant.n}, {K.shape} and {U.shape}"
        )
    matrices = {x: getattr(plant, x).tolist() for x in "MDSBF"}
    return Integral(
        "What the integral is for",
        HINT,
        [
            slider("first", "Factor on the integral of e₁", "", (-0.2, 3), 0.05, 1),
            slider("second", "Factor on the integral of e₂", "", (-0.2, 3), 0.05, 1),
            slider("force", "Force from 10 s on", " N", (0, 40), 1, 20),
        ],
        U=U.tolist(),
        K=K.tolist(),
        **matrices,
    )
