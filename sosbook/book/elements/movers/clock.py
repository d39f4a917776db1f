"""The clock in the page: a gain that is sampled, held and late."""

from ....pendulum import Mip, vertices
from ....pendulum.law import pendulum_gain
from .mover import Mover, choice, slider

__all__ = ["clock"]

HINT = (
    "Let the clock slow down until a pole leaves the circle. At 10 ms with "
    "differenced wheels and no delay the loop chatters: what does half a tick of "
    "delay do?"
)
SENSING = ("exact", "differenced counts")


class Clock(Mover):
    tag, script = "sos-clock", "clock"


def clock(gains, spread=0.04):
    """Sampled loops of the pendulum whose clock can be moved.

    The page solves the hold exactly, from tick to tick, with the delay;
    the integral of a PID is the sum of T phi.

    Parameters
    ----------
    gains : dict
        For each name a `Gain` that `SampledLaw.of_gain` takes.
    spread : float
        Of the four vertices, as `vertices` takes it.

    Returns
    -------
    Mover
        The element.

    Raises
    ------
    ValueError
        If a gain isn't a pendulum's.

    Examples
    --------
    >>> from sosbook.book import thesis
    >>> clock({"PD, R = 5": thesis.mip().gains["PD"][5]})
    Clock: law, sensing, T, delay
    """
    laws = []
    for name, gain in gains.items():
        try:
            laws.append({"name": name, "K": pendulum_gain(gain)[0].tolist()})
        except ValueError as error:
            raise ValueError(f"gains[{name!r}]: {error}") from None
    middle = Mip.printed()
    robots = (middle, *vertices(middle, spread))
    return Clock(
        "From gains to samples: move the clock",
        HINT,
        [
            choice("law", "Law", gains),
            choice("sensing", "Wheels' rate", SENSING),
            slider("T", "Time between ticks", " ms", (1, 40), 0.5, 10),
            slider("delay", "Delay", " % of a tick", (0, 100), 5, 0),
        ],
        laws=laws,
        robots=[{x: getattr(robot, x) for x in "abcdef"} for robot in robots],
    )
