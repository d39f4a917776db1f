"""What is solved: the thesis's examples, chains, public plants, LQR, vertices."""

from dataclasses import dataclass
from itertools import product

import numpy as np

import sosbook as sos

from . import plants
from .cones import Task
from .lqr import LqrTask, pendulum

__all__ = ["CASES", "Case", "many_vertices"]


@dataclass(frozen=True, eq=False)
class Case:
    """A plant and its requirements, made when asked.

    Parameters
    ----------
    name, family : str
    build : callable
        Gives the plant and the keyword arguments of `design_pid`.
    size : int
        n, where the family has one plant of each size.
    quick : bool
        Part of the quick run.
    kind : type
        `Task` or `LqrTask`.
    """

    name: str
    family: str
    build: object
    size: int = 0
    quick: bool = True
    kind: type = Task


def many_vertices(count=256, n=8, spread=0.1):
    """A chain whose first stiffnesses to the ground are uncertain.

    Parameters
    ----------
    count : int
        Vertices, a power of two.
    spread : float
        Relative change of a stiffness, up and down.
    """
    plant, asked = plants.chain(n)
    uncertain = int(np.log2(count))
    vertices = []
    for signs in product((-1, 1), repeat=uncertain):
        change = np.append(signs, np.zeros(n - uncertain))
        vertices.append(
            sos.SecondOrderSystem(
                plant.M,
                plant.D,
                plant.S + spread * np.diag(change),
                B=plant.B,
                F=plant.F,
            )
        )
    return sos.Polytope(vertices), asked


def _example(k):
    example = getattr(sos.thesis, f"example_{k}")()
    return example.plant, example.requirements


def _public(name):
    return plants.public()[name]


def _cases():
    for k in (1, 2, 3):
        yield Case(f"example {k}", "example", lambda k=k: _example(k))
    for n in (2, 4, 8, 16, 20, 40, 100, 200):
        yield Case(f"chain {n}", "chain", lambda n=n: plants.chain(n), n, quick=n <= 4)
    yield Case("pendulum LQR", "lqr", lambda: (pendulum(), {}), kind=LqrTask)
    for place, name in enumerate(plants.public()):
        yield Case(name, "public", lambda name=name: _public(name), quick=place < 1)
    for count in (4, 256):
        yield Case(
            f"{count} vertices",
            "vertices",
            lambda count=count: many_vertices(count),
            count,
            quick=False,
        )


CASES = {case.name: case for case in _cases()}
