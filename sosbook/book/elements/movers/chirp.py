"""An experiment and its fit in the page: how wide may the body swing?"""

from ....plants.checks import positive
from .mover import Mover, slider

__all__ = ["chirp"]

HINT = (
    "Raise the voltage until the body swings by 45°, without any noise. Whose d/c is "
    "wrong now? Then try a weak shake with a bad gyro."
)
LOW, HIGH = 0.5, 3.5  # Hz, of the sweep


class Chirp(Mover):
    tag, script = "sos-chirp", "chirp"


def chirp(ratios):
    """The body's experiment, recorded and fitted in the page.

    The page simulates the pendulum with the wheels held under a chirp of
    ten seconds, adds noise to the gyro, and fits e/c, f/c and d/c by
    output error, with the pendulum's sine and without.

    Parameters
    ----------
    ratios : dict
        The true ratios "e_c", "f_c" and "d_c", in SI units.

    Returns
    -------
    Mover
        The element.

    Raises
    ------
    ValueError
        If a ratio isn't positive.

    Examples
    --------
    >>> chirp({"e_c": 30.5, "f_c": 7.1, "d_c": 110.6})
    Chirp: amplitude, noise
    """
    truth = [positive(key, ratios[key]) for key in ("e_c", "f_c", "d_c")]
    return Chirp(
        "Shake it, fit it",
        HINT,
        [
            slider("amplitude", "Voltage of the chirp", " V", (0.1, 4), 0.05, 0.5),
            slider("noise", "Noise of the gyro", "°/s", (0, 20), 0.5, 0.5),
        ],
        truth=truth,
        low=LOW,
        high=HIGH,
    )
