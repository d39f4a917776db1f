"""A plant to type, and a controller that the reader's browser designs and proves."""

from functools import cache

import numpy as np

from ...plants.second_order import SecondOrderSystem
from ...plants.suspicions import LIGHT, half_fault, mass_fault
from ...synthesis.request import Request
from ..thesis import example_1
from .explorer import Explorer

#: What sentences call the parts of some plants.
SAID = {
    "Two carts and a spring, one force": {
        "it": "second cart",
        "z": ["position", "m"],
        "u": ["force", "N"],
        "w": ["push", "N"],
    },
    "A drive whose load is known by a range": {
        "it": "load",
        "J2": ["load", "g m²", -3],
        "z": ["angle", "rad"],
        "u": ["torque", "N m"],
        "w": ["load torque", "N m"],
        "z1": "motor's encoder",
        "z2": "load's encoder",
    },
    "A pendulum, upright": {
        "it": "pendulum",
        "z": ["angle", "rad"],
        "u": ["torque", "N m"],
        "w": ["torque", "N m"],
    },
}
CARTS = "1 -1\n-1 1"
WALL = "2 -1 0 0\n-1 2 -1 0\n0 -1 2 -1\n0 0 -1 2"
ENDS = "1 0\n0 0\n0 0\n0 1"  # the first and the last of four masses
#: Plants to start from: what stands in their fields.
EXAMPLES = {
    "Two carts and a spring, one force": {
        "M": "1 0\n0 1",
        "D": "0.1 -0.1\n-0.1 0.1",
        "S": CARTS,
        "B": "1\n0",
        "F": "0\n1",
        "U": "0 1",
    },
    "A drive whose load is known by a range": {
        "M": "0.0025 0\n0 J2",
        "D": "0.004 -0.004\n-0.004 0.004",
        "S": "1.9 -1.9\n-1.9 1.9",
        "B": "1\n0",
        "F": "0\n1",
        "U": "0 1",
        "ranges": "J2 = 0.003 .. 0.006",
    },
    "A pendulum, upright": dict.fromkeys("MBFU", "1") | {"D": "0.1", "S": "-9.81"},
    "Four masses between walls, two forces": {
        "M": "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1",
        "D": "0.1 -0.05 0 0\n-0.05 0.1 -0.05 0\n0 -0.05 0.1 -0.05\n0 0 -0.05 0.1",
        "S": WALL,
        "B": ENDS,
        "F": "0\n1\n0\n0",
        "U": "1 0 0 0\n0 0 1 0",
    },
}


class Bench(Explorer):
    """The page element for a plant of the reader's own; made by `bench`.

    Parameters
    ----------
    data : dict
        "title", "examples": plants to start from, and "refusals": the package's words
        for what it refuses.
    """

    tag, script, sheets = "sos-bench", "bench", ("wish",)

    def __repr__(self):
        return f"Bench: {self.title}"


def bench(title="A plant of your own"):
    """An element in which readers type the matrices of a plant and design for it.

    Parameters
    ----------
    title : str
        The heading of the element.

    Returns
    -------
    Bench
        With a few plants to start from. The page solves, proves and judges at all
        corners, and writes Python, C, a file for ``python -m sosbook design`` and a
        report.

    Examples
    --------
    >>> bench("Your drive")
    Bench: Your drive
    """
    robot = example_1()
    grasping = {name: _text(getattr(robot.plant, name)) for name in "MDSBF"}
    names = {"The grasping robot (Example 1)": grasping | {"U": _text(robot.U)}}
    examples = [
        {"name": k, "texts": v, "words": SAID.get(k)}
        for k, v in (EXAMPLES | names).items()
    ]
    examples[-1]["x0"] = robot.saturation.x0.tolist()
    return Bench({"title": title, "examples": examples, "refusals": _refusals()})


def _text(matrix):
    return "\n".join(" ".join(f"{x:g}" for x in row) for row in matrix)


@cache
def _refusals():
    """The package's words on plants that it refuses or warns of, by short names.

    The package is asked for each, so that the page can't say anything else. A number
    has the place {}.
    """
    plants = {  # M, B, U and what else is asked
        "massless": (0, 0, None, {}),
        "singular": (0, 1, None, {}),
        "dependent": (1, 1, [[1], [1]], {}),
        "uncontrollable": (1, 0, [[1]], {}),
        "disturbance": (1, 1, None, {"gamma": 1.0}),
    }
    words = {
        "skew": mass_fault(np.array([[1.0, 8.0], [0.0, 1.0]])).replace("8", "{}"),
        "negative": mass_fault(np.array([[-8.0]])).replace("-8", "{}"),
        "light": LIGHT.replace("{:.3g}", "{}"),
    }
    for name in "MDS":
        for side, half in (("above", np.triu), ("below", np.tril)):
            plain = dict.fromkeys("MDS", np.eye(3))
            words[f"{name} {side}"] = half_fault(plain | {name: half(np.ones((3, 3)))})
    for name, (M, B, U, asked) in plants.items():
        try:
            Request(SecondOrderSystem(M, 1, 1, B), U, **asked)
        except ValueError as fault:
            words[name] = str(fault)
    return words
