"""The chain from ratios to a program in the page: move one link, see the rest."""

from ....plants.checks import positive
from .mover import Mover, slider

__all__ = ["chain"]

#: What a scale and a ruler say of the robot; as `Mip.from_ratios` has it.
MEASURED = {"M_b": 0.272, "l": 0.040, "r": 0.032, "M_w": 0.027, "g": 9.8}
HINT = (
    "Say that the motors are weaker (e/c), and follow the change down to the loop. "
    "Then make the voltage cheap, and late."
)


class Chain(Mover):
    tag, script = "sos-chain", "chain"


def chain(ratios):
    """From four measured ratios to the loop that the program closes.

    The page computes the pendulum's letters, the regulator of the middle
    plant with the integral (Riccati), the poles at the vertices and the
    sampled loop at 100 Hz with its delay.

    Parameters
    ----------
    ratios : dict
        "e_c", "f_c", "d_c" and "e_a", as an identification gives them.

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
    >>> chain({"e_c": 30.52, "f_c": 7.133, "d_c": 110.6, "e_a": 208.8})
    Chain: e_c, f_c, d_c, e_a, R, spread, late
    """
    units = {"e_c": " V⁻¹s⁻²", "f_c": " s⁻¹", "d_c": " s⁻²", "e_a": " V⁻¹s⁻²"}
    moved = []
    for key, unit in units.items():
        value = float(f"{positive(key, ratios[key]):.4g}")
        step = value / 100
        ends = (50 * step, 150 * step)
        moved.append(slider(key, key.replace("_", "/"), unit, ends, step, value))
    return Chain(
        "From ratios to a program",
        HINT,
        [
            *moved,
            slider("R", "Weight R of the voltage", "", (-1, 3), 0.05, 20, "log"),
            slider("spread", "Spread of the vertices", " %", (0, 60), 1, 4),
            slider("late", "Delay", " % of a tick", (0, 100), 5, 50),
        ],
        **MEASURED,
    )
