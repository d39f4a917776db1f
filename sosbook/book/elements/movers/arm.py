"""An arm of many modes, of which a design knows a few."""

import numpy as np

from ..page import significant
from .mover import Mover, slider

DIGITS = 6  # of a frequency: later digits differ from processor to processor
ACROSS = 0.05  # of the largest shape; a mode with less moves along the arm
STEP = 0.01  # m, from one place of the arm to the next


def arm(plant, shapes, kept=5):
    """An arm that is pushed against the rate at a sensor; both are dragged along it.

    Parameters
    ----------
    plant : SecondOrderSystem
        The arm in its modes, the slowest first: M = I, D and S are diagonal.
    shapes : (places, n) array
        The mode shapes at places 0.01 m apart, from 0 to 1 m. A mode that hardly moves
        across the arm is left out.
    kept : int
        So many of the modes are kept by the reduced model.

    Examples
    --------
    >>> import sosbook as sos
    >>> two = sos.SecondOrderSystem(np.eye(2), np.eye(2), np.diag([9, 16]), [[1], [1]])
    >>> arm(two, np.ones((101, 2)), kept=1)
    Arm: a, s, g
    """
    sizes = abs(np.asarray(shapes)).max(axis=0)
    across = sizes > ACROSS * sizes.max()
    squares, damping = (np.diag(x)[across] for x in (plant.S, plant.D))
    place = " m", (STEP, 1), STEP
    return Mover(
        "arm",
        "A push and a sensor on an arm",
        "Drag the push away from the sensor until a mode grows that the reduced model "
        "doesn't have. Where may it stand?",
        [
            slider("a", "Push", *place, 1),
            slider("s", "Sensor", *place, 1),
            slider("g", "Push for each m/s", " N", (0, 3), 0.1, 1.5),
        ],
        answer={"a": 0.94},
        kept=kept,
        frequencies=significant(np.sqrt(squares), DIGITS),
        damping=significant(damping, DIGITS),
        free=significant(-damping / 2, DIGITS),
        shapes=significant(np.transpose(shapes)[across], DIGITS - 2),
    )
