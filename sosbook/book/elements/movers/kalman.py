"""An observer for the pendulum in the page: Kalman's filter and its noises."""

import numpy as np

from .mover import Mover, choice, slider

__all__ = ["kalman"]

HINT = (
    "Make the gyro bad: the filter slows down and the voltage calms. Then give the "
    "loop a plant that the observer doesn't have in mind."
)


class Kalman(Mover):
    tag, script = "sos-kalman", "kalman"


def kalman(plant, K, spread):
    """A Kalman filter of the mean plant, made and tried in the page.

    Parameters
    ----------
    plant : DescriptorSystem
        Its vertices have three states, one input and two outputs: the
        pendulum without its wheels' angle.
    K : (1, 3) array_like
        The gain of u = K x^.
    spread : float
        The spread of the vertices, in per cent, for the reader.

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
    >>> from sosbook.pendulum import Mip
    >>> from sosbook.pendulum.spread import reduced
    >>> kalman(reduced(Mip.printed(), 0.4), thesis.mip().lqe[1][0], 40)
    Kalman: gyro, wheels, push, plant
    """
    K, vertices = np.asarray(K, float), plant.vertices
    C = np.asarray(plant.C, float)
    if K.shape != (1, 3) or C.shape != (2, 3) or vertices[0].E.shape != (3, 3):
        raise ValueError(
            f"K must have the shape (1, 3) and C (2, 3), got {K.shape} and {C.shape}"
        )
    names = [f"vertex {k} of ±{spread:g} %" for k in range(1, len(vertices) + 1)]
    return Kalman(
        "An observer and its noises",
        HINT,
        [
            slider("gyro", "Gyro's noise", " rad/s/√Hz", (-3, 0), 0.05, 0.1, "log"),
            slider(
                "wheels",
                "Noise of the wheels' rate",
                " rad/s/√Hz",
                (-3, 1),
                0.05,
                0.316,
                "log",
            ),
            slider("push", "Knocks, as a voltage", " V/√Hz", (-1, 1), 0.05, 2, "log"),
            choice("plant", "The plant is", ["the mean itself", *names]),
        ],
        E=[d.E.tolist() for d in vertices],
        A=[d.A.tolist() for d in vertices],
        B=[d.Bu.tolist() for d in vertices],
        C=C.tolist(),
        K=K.tolist(),
    )
