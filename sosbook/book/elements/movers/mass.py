"""A vanishing mass in the page: jump or impulse, and mass that is lent."""

import numpy as np

from .mover import Mover, slider

__all__ = ["mass"]

HINT = (
    "Let the last mass vanish with the damper, then without it. Which of the two "
    "velocities has a limit? Then lend the body some mass."
)
DAMPER, SPRING = 20.0, 20.0  # Ns/m and N/m, between the last two bodies


class Mass(Mover):
    tag, script = "sos-mass", "mass"


def mass(chain):
    """The chain of Example 3 with a last body that may weigh little.

    Parameters
    ----------
    chain : SecondOrderSystem
        The chain, whose last mass is zero; its masses, its last damper
        and its last spring are those of the thesis's Example 3.

    Returns
    -------
    Mover
        The element.

    Raises
    ------
    ValueError
        If it is another plant.

    Examples
    --------
    >>> from sosbook.book import thesis
    >>> mass(thesis.example_3().plant)
    Mass: m4, b4, lent
    """
    same = (
        np.array_equal(np.diag(chain.M), [3, 2, 1, 0])
        and chain.D[3, 3] == DAMPER
        and chain.S[3, 3] == SPRING
    )
    if not same:
        raise ValueError("chain must be the plant of the thesis's Example 3")
    return Mass(
        "A mass that vanishes",
        HINT,
        [
            slider("m4", "Mass m₄", " kg", (-5, 0), 0.05, 0.01, "log"),
            slider("b4", "Damper b₄", " Ns/m", (0, 40), 1, DAMPER),
            slider(
                "lent", "Mass lent by acceleration feedback", " kg", (0, 1), 0.01, 0
            ),
        ],
        D=chain.D.tolist(),
        S=chain.S.tolist(),
        k4={"damper": DAMPER, "spring": SPRING},
    )
