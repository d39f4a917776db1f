"""The falling pendulum in the page, and its linear model beside it."""

from ....pendulum import V_MAX, Mip
from .mover import Mover, choice, slider

__all__ = ["fall"]

ROTORS = {"J = 0": False, "on the body": True}
HINT = (
    "Let it go at 5° and at 45°. In which of the two does the linear model run ahead "
    "of the truth? Then throw it back from 10° with a short pulse."
)


class Fall(Mover):
    tag, script = "sos-fall", "fall"


def fall():
    """The pendulum falls in the page, and so does its linear model.

    The page integrates `Mip.acceleration` by Runge and Kutta's method
    with steps of 5 ms, and the linear model exactly. A voltage acts
    from the start for as long as the pulse lasts.

    Returns
    -------
    Mover
        The element.

    Notes
    -----
    Source: thesis (4.13) and (4.15), mended.

    Examples
    --------
    >>> fall()
    Fall: angle, volts, pulse, rotors
    """
    robots = [
        Mip.from_ratios(30.52, 7.133, 110.6, 208.8, rotors=rotors)
        for rotors in ROTORS.values()
    ]
    return Fall(
        "Let it fall",
        HINT,
        [
            slider("angle", "Let go at θ", "°", (0, 90), 1, 10),
            slider("volts", "Voltage of the pulse", " V", (-V_MAX, V_MAX), 0.1, 0),
            slider("pulse", "Length of the pulse", " s", (0, 0.8), 0.01, 0.1),
            choice("rotors", "Inertia of the rotors", ROTORS),
        ],
        robots=[{x: getattr(robot, x) for x in "abcdefJ"} for robot in robots],
    )
