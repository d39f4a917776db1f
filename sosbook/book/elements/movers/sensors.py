"""Ticking the sensors of a drive: the page searches gains and proves what they do."""

import numpy as np

from ....laws import PIDLaw
from ..page import significant
from .mover import Mover, choice, slider, tick

__all__ = ["sensors", "ticked_law"]

TICKS = {
    "p1": "the motor's angle φ₁",
    "p2": "the load's angle φ₂",
    "v1": "the motor's rate φ₁′",
    "v2": "the load's rate φ₂′",
    "integral": "and integrate the first angle",
}
PARTS = "MDSB"


def ticked_law(place, filters, limits):
    """The law of the ticks that a page has; None where nothing is ticked.

    ``place``: 1 or 0 for "p1", "p2", "v1", "v2" and "integral", and the index of
    "filter", which counts where angles alone are measured; ``filters``: time constants
    in s; ``limits``: the largest size of an entry of K_P, K_D, K_I.

    >>> place = dict(p1=0, p2=1, v1=0, v2=0, integral=0, filter=0)
    >>> ticked_law(place, [0.01], {"K_P": 20, "K_D": 1, "K_I": 100}).filter
    0.01
    """
    one = np.eye(2)
    angles, rates = (one[[i for i in range(2) if place[f"{x}{i + 1}"]]] for x in "pv")
    law, kinds = {}, []
    if len(angles):
        law["position"] = angles
        kinds.append("K_P")
    if len(rates):
        law["velocity"] = rates
    elif len(angles):
        law["filter"] = filters[place["filter"]]
    else:
        return None
    if len(angles) and place["integral"]:
        law["integrate"] = np.eye(1, len(angles))
        kinds.append("K_I")
    return PIDLaw(**law, limits={k: limits[k] for k in ("K_D", *kinds)})


def sensors(drives, filters, limits, box):
    """A drive whose sensors, spring and ranges are the reader's.

    The page searches the gains of the sensors that are ticked and proves, in exact
    arithmetic, what they do to every drive of the ranges.

    ``drives``: a mass J and a spring k, no powers: the largest ranges that the page can
    show. J stands in M alone, by a matrix of rank one, and k in S alone; the motions
    are the angles of motor and load, and there is one torque; ``filters``: time
    constants in s of the rates that angles alone give; ``limits``: the largest size of
    an entry of K_P, K_D, K_I; ``box``: the ranges at first, J and k by name. Raises
    ValueError if the drives aren't of this kind.

    >>> import sosbook as sos
    >>> def drive(J, k):
    ...     return sos.SecondOrderSystem(np.diag([1, J]), np.diag([1, 0]),
    ...                                  [[k, -k], [-k, k]], [[1], [0]])
    >>> limits = {"K_P": 20, "K_D": 20, "K_I": 20}
    >>> drives = sos.Uncertain(drive, J=(1, 2), k=(5, 9))
    >>> sensors(drives, [0.1], limits, dict(J=(1, 2), k=(9, 9)))
    Sensors: p1, p2, v1, v2, integral, filter, J0, J1, k0, k1
    """
    ends = [[float(x) for x in end] for end in (drives.box.low, drives.box.high)]
    spans = np.subtract(*ends[::-1])
    corners = [[getattr(v, x) for x in PARTS] for v in drives.vertices]
    parts = {}
    for name, *at in zip(PARTS, *corners):
        ways = [(at[k] - at[0]) / span for k, span in zip((2, 1), spans)]
        base = at[0] - sum(end * way for end, way in zip(ends[0], ways))
        parts[name] = [significant(x, 12) for x in (base, *ways)]
    moved = {x: list(map(np.any, (J, k))) for x, (_, J, k) in parts.items()}
    alone = dict(M=[1, 0], D=[0, 0], S=[0, 1], B=[0, 0])
    shapes = parts["M"][0], parts["B"][0]
    if (
        list(drives.degree.items()) != [("J", 1), ("k", 1)]
        or moved != alone
        or np.linalg.matrix_rank(parts["M"][1]) != 1
        or list(map(np.shape, shapes)) != [(2, 2), (2, 1)]
    ):
        raise ValueError(
            "drives must have two coordinates, one input, a mass J and a spring k, "
            f"got {drives!r}"
        )
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
        parts=parts,
        ranges=ends,
        rates=[significant(1 / x, 12) for x in filters],
        limits=limits,
        answer={"p1": 0, "p2": 1, "v1": 1},
    )
