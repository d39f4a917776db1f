"""Families of plants that the solvers are timed on.

``python -m benchmarks`` lists and times them.

Half of them are for tuning the solver: whoever changes it may look at them as
often as he likes. The other half is held back: it is only run to report. No
constant, switch or formula of the solver may be chosen by a held-back family.
Each kind of request stands in both halves.
"""

from dataclasses import dataclass
from functools import cache

from . import continua, foreign, machines, masses, plants
from .questions import KINDS

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
FEW = SIZES[:5]
PLANTS = "in the collection"
TUNED_ON = "the solver was tuned on it"


def _half(half, table):
    """The families of a half: make, kind, asks, why, sizes, and what these count."""
    families = {}
    for name, (make, kind, asks, why, sizes, *counts) in table.items():
        families[name] = Family(make, kind, asks, half, why, sizes, *counts)
    return families


# fmt: off
FAMILIES = _half(TUNING, {
    "grounded chain": (plants.chain, "pid", "gamma", TUNED_ON, SIZES),
    "free chain": (masses.free_chain, "pid", "regions", TUNED_ON, SIZES),
    "cantilever": (
        continua.cantilever, "pid", "saturation", "it was the benchmark's stiff plant",
        FEW),
    "tree": (masses.tree, "pid", "slack", "a slack in both halves", (2, 4, 6, 8)),
    "pendulums": (
        machines.pendulums, "lqr", "least cost", "a cost in both halves",
        (2, 3, 4, 6, 8)),
    "uncertain masses": (
        masses.uncertain_masses, "pid", "vertices", "as many as uncertain springs",
        (4, 16, 64, 256), "vertices"),
    "tied masses": (
        masses.tied_masses, "pid", "pairs", "pairs in both halves", (1, 2, 4, 8),
        "vertices"),
    "uncertain springs": (
        masses.uncertain_springs, "pid", "vertices", TUNED_ON, (4, 16, 64, 256),
        "vertices"),
    "delayed chain": (
        masses.delayed_chain, "delay", "delay", "a delay in both", (1, 2, 3, 5)),
    "observed beam": (
        continua.observed_beam, "observer", "observer", "an observer in both halves",
        (2, 4, 8, 12)),
    "published": (
        _of("published"), "pid", "as it comes", "every change was tried on them",
        tuple(range(1, 9)), PLANTS),
}) | _half(HELD_BACK, {
    "grid": (masses.grid, "pid", "gamma", "two-dimensional, random", SIZES),
    "plate": (
        continua.plate, "pid", "regions", "stiffer than beams", (6, 9, 12, 18, 27, 36)),
    "modes": (masses.modes, "pid", "saturation", "full matrices, random", FEW),
    "building": (masses.building, "pid", "slack", "a slack in both", (2, 4, 6, 8)),
    "stations": (
        masses.stations, "pid", "regions", "lightly damped, many modes",
        (6, 12, 24, 60, 135, 200)),
    "rotor": (continua.rotor, "lqr", "least cost", "gyroscopic", (4, 8, 12, 16)),
    "arm": (machines.arm, "pid", "pairs", "unstable, uncertain M", (1, 2, 3)),
    "bicycles": (
        machines.bicycles, "pid", "vertices", "S isn't symmetric",
        (1, 3, 6, 12, 24, 64, 256), "vertices"),
    "delayed modes": (masses.delayed_modes, "delay", "delay", "random", (1, 2, 3, 5)),
    "observed wire": (
        continua.observed_wire, "observer", "observer", "gyroscopic", (2, 4, 8, 12)),
    "foreign": (
        _of("foreign"), "pid", "as it comes", "of other people", tuple(range(1, 19)),
        PLANTS),
})
# fmt: on
