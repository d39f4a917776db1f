"""Families of plants that the solvers are timed on.

``python -m benchmarks.families`` lists and times them.

Half of them are for tuning the solver: whoever changes it may look at them as
often as he likes. The other half is held back: it is only run to report. No
constant, switch or formula of the solver may be chosen by a held-back family.
Each kind of request stands in both halves.
"""

from dataclasses import dataclass
from functools import cache

from . import continua, foreign, machines, masses, plants
from .questions import KINDS

__all__ = ["FAMILIES", "Family", "case"]

TUNING, HELD_BACK = "tuning", "held back"


@dataclass(frozen=True, eq=False)
class Family:
    """Plants of several sizes with what is asked of them.

    Parameters
    ----------
    make : callable
        From a size to a plant and requirements.
    kind : str
        What is asked: a name in `KINDS`.
    asks : str
        In words.
    half : {"tuning", "held back"}
    why : str
        The reason for this half.
    sizes : tuple
        Those of the profile.
    size : str
        What the size counts.
    """

    make: object
    kind: str
    asks: str
    half: str
    why: str
    sizes: tuple
    size: str = "degrees of freedom"


def case(name, size, framed=False):
    """The question of a family's plant of a size."""
    family = FAMILIES[name]
    return KINDS[family.kind](*family.make(size), framed)


@cache
def collection(name):
    """A collection's plants in a row, for the sizes 1, 2, 3, ..."""
    if name == "published":
        return list(plants.public().values())
    return [v for k, v in foreign.foreign().items() if k not in plants.public()]


def _of(name):
    return lambda place: collection(name)[place - 1]


SIZES = (2, 4, 8, 12, 24, 40)
FAMILIES = {
    # name: make, kind, asks, half, why, sizes, what a size counts
    "grounded chain": Family(
        plants.chain, "pid", "gamma", TUNING, "the solver was tuned on it", SIZES
    ),
    "free chain": Family(
        masses.free_chain, "pid", "regions", TUNING, "the solver was tuned on it", SIZES
    ),
    "cantilever": Family(
        continua.cantilever,
        "pid",
        "saturation",
        TUNING,
        "it was the benchmark's stiff plant",
        (2, 4, 8, 12, 24),
    ),
    "tree": Family(
        masses.tree, "pid", "slack", TUNING, "a slack in both halves", (2, 4, 6, 8)
    ),
    "pendulums": Family(
        machines.pendulums,
        "lqr",
        "least cost",
        TUNING,
        "a cost in both halves",
        (2, 3, 4, 6, 8),
    ),
    "uncertain masses": Family(
        masses.uncertain_masses,
        "pid",
        "vertices",
        TUNING,
        "as many as uncertain springs",
        (4, 16, 64, 256),
        "vertices",
    ),
    "tied masses": Family(
        masses.tied_masses,
        "pid",
        "pairs",
        TUNING,
        "pairs in both halves",
        (1, 2, 4, 8),
        "vertices",
    ),
    "uncertain springs": Family(
        masses.uncertain_springs,
        "pid",
        "vertices",
        TUNING,
        "the solver was tuned on it",
        (4, 16, 64, 256),
        "vertices",
    ),
    "delayed chain": Family(
        masses.delayed_chain, "delay", "delay", TUNING, "a delay in both", (1, 2, 3, 5)
    ),
    "observed beam": Family(
        continua.observed_beam,
        "observer",
        "observer",
        TUNING,
        "an observer in both halves",
        (2, 4, 8, 12),
    ),
    "published": Family(
        _of("published"),
        "pid",
        "as it comes",
        TUNING,
        "every change was tried on them",
        tuple(range(1, 9)),
        "in the collection",
    ),
    "grid": Family(
        masses.grid, "pid", "gamma", HELD_BACK, "two-dimensional, random", SIZES
    ),
    "plate": Family(
        continua.plate,
        "pid",
        "regions",
        HELD_BACK,
        "stiffer than beams",
        (6, 9, 12, 18, 27, 36),
    ),
    "modes": Family(
        masses.modes,
        "pid",
        "saturation",
        HELD_BACK,
        "full matrices, random",
        (2, 4, 8, 12, 24),
    ),
    "building": Family(
        masses.building, "pid", "slack", HELD_BACK, "a slack in both", (2, 4, 6, 8)
    ),
    "stations": Family(
        masses.stations,
        "pid",
        "regions",
        HELD_BACK,
        "lightly damped, many modes",
        (6, 12, 24, 60, 135, 200),
    ),
    "rotor": Family(
        continua.rotor, "lqr", "least cost", HELD_BACK, "gyroscopic", (4, 8, 12, 16)
    ),
    "arm": Family(
        machines.arm, "pid", "pairs", HELD_BACK, "unstable, uncertain M", (1, 2, 3)
    ),
    "bicycles": Family(
        machines.bicycles,
        "pid",
        "vertices",
        HELD_BACK,
        "S isn't symmetric",
        (1, 3, 6, 12, 24, 64, 256),
        "vertices",
    ),
    "delayed modes": Family(
        masses.delayed_modes, "delay", "delay", HELD_BACK, "random", (1, 2, 3, 5)
    ),
    "observed wire": Family(
        continua.observed_wire,
        "observer",
        "observer",
        HELD_BACK,
        "gyroscopic",
        (2, 4, 8, 12),
    ),
    "foreign": Family(
        _of("foreign"),
        "pid",
        "as it comes",
        HELD_BACK,
        "of other people",
        tuple(range(1, 19)),
        "in the collection",
    ),
}
