"""Matrices to type, and sliders that the reader's browser solves for them."""

from functools import cache

import numpy as np

from ...plants.second_order import SecondOrderSystem
from ...plants.sparse import mass_fault
from ...synthesis.request import Request
from ..thesis import example_1
from .explorer import Explorer, design_explorer

__all__ = ["OwnPlant", "own_plant"]


class OwnPlant(Explorer):
    """The page element for a plant of the reader's own; made by `own_plant`.

    Parameters
    ----------
    data : dict
        That of an `Explorer`, "examples": plants to start from, and "refusals": the
        package's words for what it refuses.
    """

    tag, script, sheets = "sos-plant", "plant", ("explorer", "plant")
    notice = "A solver for your own matrices"


def own_plant(title="A plant of your own"):
    """An element in which readers type the matrices of a plant.

    Parameters
    ----------
    title : str
        The heading of the element.

    Returns
    -------
    OwnPlant
        With a few plants to start from; the page solves, proves and writes code.
    """
    robot = example_1()
    plants = [
        ("The grasping robot (Example 1)", robot.plant, robot.U, robot.saturation.x0),
        *((name, plant, U, np.zeros(0)) for name, plant, U in _examples()),
    ]
    elements = [
        design_explorer(
            plant,
            U,
            sigma=(0.1, 2.5),
            theta=np.radians([15, 90]),
            rho=(1.5, 12),
            start={"sigma": 0.7, "theta": np.pi / 4, "rho": 5},
            title=title,
        ).data
        for _, plant, U, _ in plants
    ]
    examples = [
        {"name": name, "request": data["request"], "x0": x0.tolist() or None}
        for (name, _, _, x0), data in zip(plants, elements, strict=True)
    ]
    return OwnPlant(
        elements[0] | {"examples": examples, "mu": None, "refusals": _refusals()}
    )


def _examples():
    """Name, plant and integrated errors of a few plants of three lines each."""
    wall = 2 * np.eye(4) - np.eye(4, k=1) - np.eye(4, k=-1)
    carts = np.array([[1.0, -1], [-1, 1]])
    return (
        (
            "Two carts and a spring, one force",
            SecondOrderSystem(
                np.eye(2), 0.1 * carts, carts, [[1], [0]], [[0], [1]]
            ),
            [[0, 1]],
        ),
        (
            "A pendulum, upright",
            SecondOrderSystem([[1]], [[0.1]], [[-9.81]], [[1]], [[1]]),
            [[1]],
        ),
        (
            "Four masses between walls, two forces",
            SecondOrderSystem(
                np.eye(4), 0.05 * wall, wall, np.eye(4)[:, [0, 3]], np.eye(4)[:, [1]]
            ),
            np.eye(4)[[0, 3]],
        ),
    )  # fmt: skip


@cache
def _refusals():
    """What the package says of plants that it refuses or warns of, by short names.

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
    }
    for name, (M, B, U, asked) in plants.items():
        try:
            Request(SecondOrderSystem(M, 1, 1, B), U, **asked)
        except ValueError as fault:
            words[name] = str(fault)
    return words
