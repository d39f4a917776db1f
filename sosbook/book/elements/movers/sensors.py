"""Ticking the sensors of a drive: the page searches gains and proves what they do."""

from ..page import matrices, significant
from .boxes import bilinear, ends_of
from .mover import Mover, choice, slider, tick

TICKS = {
    "p1": "the motor's φ₁",
    "p2": "the load's φ₂",
    "v1": "the rate φ₁′",
    "v2": "the rate φ₂′",
    "integral": "and an integral",
}


def sensors(drives, filters, limits, box):
    """A drive whose sensors, spring and ranges are the reader's.

    The page searches the gains of the sensors that are ticked and proves, in exact
    arithmetic, what they do to every drive of the ranges.

    ``drives``: a mass J and a spring k, no powers: the largest ranges that the page can
    show, see `bilinear`. The motions are the angles of motor and load, and there is one
    torque; ``filters``: time constants in s of the rates that angles
    alone give; ``limits``: the largest size of an entry of K_P, K_D, K_I; ``box``: the
    ranges at first, J and k by name. Raises ValueError if the drives aren't of this
    kind.

    >>> import numpy as np
    >>> import sosbook as sos
    >>> def drive(J, k):
    ...     return sos.SecondOrderSystem(np.diag([1, J]), np.diag([1, 0]),
    ...                                  [[k, -k], [-k, k]], [[1], [0]])
    >>> limits = {"K_P": 20, "K_D": 20, "K_I": 20}
    >>> drives = sos.Uncertain(drive, J=(1, 2), k=(5, 9))
    >>> sensors(drives, [0.1], limits, dict(J=(1, 2), k=(9, 9)))
    Sensors: p1, p2, v1, v2, integral, filter, J0, J1, k0, k1
    """
    ends, corners = ends_of(drives, "Jk"), drives.vertices
    if (
        corners[0].n != 2
        or corners[0].m != 1
        or any(matrices(v, "DB") != matrices(corners[0], "DB") for v in corners)
    ):
        raise ValueError(
            "drives must have two coordinates and one input, and the same D and B, "
            f"got {drives!r}"
        )
    M, S = bilinear([v.M for v in corners], [v.S for v in corners], ends)
    names = [f"{1000 * x:g} ms" for x in filters]
    (J, k), (loads, springs) = (box[x] for x in "Jk"), zip(*ends)
    inertia, stiff = (" kg m²", loads, 0.0005), (" N m/rad", springs, 0.1)
    return Mover(
        "sensors",
        "Tick your sensors",
        "Move the encoder from the motor to the load: untick φ₁, tick φ₂. What is left "
        "of the decay? Which single rate brings it back? Then drag the ends of the "
        "range: what do a softer shaft and heavier loads cost?",
        [
            *(tick(key, words, int(key == "p1")) for key, words in TICKS.items()),
            choice("filter", "Filter, if no rate is measured", names, len(names) // 2),
            slider("J0", "Lightest load", *inertia, J[0]),
            slider("J1", "Heaviest load", *inertia, J[1]),
            slider("k0", "Softest shaft", *stiff, k[0]),
            slider("k1", "Stiffest shaft", *stiff, k[1]),
        ],
        parts={"M": M, "S": S} | matrices(corners[0], "DB"),
        ranges=ends,
        rates=[significant(1 / x, 12) for x in filters],
        limits=limits,
        answer={"p1": 0, "p2": 1, "v1": 1},
    )


def noises(grid, least):
    """Two encoders whose noises can be moved, with what any controller keeps.

    ``grid``: the noises in rad, evenly spaced in their logarithms, from 0.001 to 0.1;
    ``least``: the least norms with the "motor"'s encoder and the "load"'s, a number for
    each noise, and with "both", (motor's, load's) noise.

    >>> noises([0.001, 0.01, 0.1], {"motor": [1, 2, 3], "load": [1, 2, 3]})
    Noises: motor, load
    """
    step, log = 2 / (len(grid) - 1), (-3, -1)
    return Mover(
        "noises",
        "What an encoder is worth",
        "Make the load's encoder noisier until the motor's is the better one. Where is "
        "a second encoder worth its money?",
        [
            slider("motor", "Motor's noise", " rad", log, step, 0.01, "log"),
            slider("load", "Load's noise", " rad", log, step, 0.01, "log"),
        ],
        answer={"load": 0.1},
        grid=list(grid),
        least=least,
    )
