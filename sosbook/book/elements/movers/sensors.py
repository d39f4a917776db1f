"""Ticking the sensors of a drive: what was found and proven for each choice."""

from itertools import product

import numpy as np

from ....laws import PIDLaw
from ....synthesis.pid import design_pid
from ..page import matrices, significant
from .mover import Mover, choice, slider, tick

__all__ = ["sensors", "ticked_law"]

TICKS = {
    "p1": "the motor's angle φ₁",
    "p2": "the load's angle φ₂",
    "v1": "the motor's rate φ₁′",
    "v2": "the load's rate φ₂′",
    "integral": "and integrate the first angle",
}
STARTS = 4  # descents of each choice's search: more found nothing faster here


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


def sensors(plants, filters, limits):
    """A drive whose sensors can be ticked; every choice is designed and proven here.

    The page has sliders for the gains and computes their poles itself.

    ``plants``: drives with the angles of motor and load, and a torque on the motor;
    ``filters``: time constants in s of the rates that angles alone give; ``limits``:
    the largest size of an entry of K_P, K_D, K_I. Raises ValueError if the plants
    aren't of two coordinates and one input.

    >>> import sosbook as sos
    >>> drive = sos.SecondOrderSystem(
    ...     np.eye(2), [[1, 0], [0, 0]], [[9, -9], [-9, 9]], [[1], [0]])
    >>> sensors(sos.Polytope([drive]), [0.1], {"K_P": 20, "K_D": 20, "K_I": 20})
    Sensors: p1, p2, v1, v2, integral, filter, K_P, K_D, K_I
    """
    corners = plants.vertices
    if corners[0].n != 2 or corners[0].m != 1:
        raise ValueError(
            "plants must have two coordinates and one input, got "
            f"{corners[0].n} and {corners[0].m}"
        )
    found = {}
    keys = (*TICKS, "filter")
    for p1, p2, v1, v2 in product((0, 1), repeat=4):
        spans = (1 + (p1 or p2), 1 if v1 or v2 else len(filters))
        for integral, filter in product(*map(range, spans)):
            place = dict(zip(keys, (p1, p2, v1, v2, integral, filter)))
            law = ticked_law(place, filters, limits)
            if law is not None:
                found["".join(map(str, place.values()))] = _found(plants, law)
    names = [f"{1000 * x:g} ms" for x in filters]
    parts = [
        slider(k, f"{k}, times what was found", " ×", (0, 2), 0.01, 1) for k in limits
    ]
    return Mover(
        "sensors",
        "Tick your sensors",
        "Move the encoder from the motor to the load: untick φ₁, tick φ₂. What is left "
        "of the decay? Which single rate brings it back, and is it a matter of where "
        "the angle is measured?",
        [
            *(tick(key, words, int(key == "p1")) for key, words in TICKS.items()),
            choice("filter", "Filter, if no rate is measured", names, len(names) // 2),
            *parts,
        ],
        plants=[matrices(v, "MDSB") for v in corners],
        filters=list(filters),
        limits=limits,
        found=found,
    )


def _found(plants, law):
    """What is said of a law: its decay and gains, or why there are none."""
    design = design_pid(plants, law=law, maximize="sigma", starts=STARTS)
    if design.status != "feasible" or not design.certify().proven:
        return {"status": design.status, "reason": design.reason}
    (half_plane,) = design.request.region.parts
    gains = {k: significant(x[0], 12) for k, x in design.gains.items()}
    return {"status": "feasible", "sigma": half_plane.bound, "gains": gains}
