"""The protocol that every requirement keeps; consumers ask nothing else.

A requirement is a frozen object: a bound of a norm, a region of the poles.
It writes its own LMI blocks, says in words what a proof of them proves and
computes the true value in a loop. A new one is a new file, here or elsewhere.
"""

import re
from abc import ABC, abstractmethod

from .vocabulary import Parameter

__all__ = ["BlockName", "BlockTable", "Requirement", "sane_name"]


class Requirement(ABC):
    """Something that is asked of a loop.

    Attributes
    ----------
    kind : str
        What sort of requirement it is: "region", "cost", ...
    name : str
        Distinguishes it from others of its kind; `Request.without` takes it.
    parameter : Parameter or None
        What its bound is called and which way it tightens; None where
        nothing can be moved.
    bound : float or None
        The bound itself; None where it is to be minimised.
    implies_stability : bool
        Whether its blocks demand Re s < 0, so that no other need do so.
    rank : int
        Its place among the requirements of a problem.
    promise : str
        Name of the promise that `truth` is compared with.
    titles : dict
        From a block's name to its words in tables and pages.
    """

    kind = name = promise = ""
    parameter: Parameter = None
    bound = None
    implies_stability = False
    rank = 50
    titles = {}

    @property
    def key(self):
        """Distinguishes it from every other requirement of a problem."""
        return self.kind, self.name

    @property
    def words(self):
        """What messages call it."""
        return self.parameter.words if self.parameter else self.name

    def with_bound(self, bound):
        """The same requirement with another bound."""
        raise ValueError(f"{self.name} has no bound that can be moved")

    def check(self, problem):
        """Raise a ValueError that names argument and cure, if it can't be met."""

    def contradicts(self, other):
        """Whether no loop at all meets both, at sight."""
        return False

    def admits(self, s):
        """Whether a pole at s, in rad/s, keeps it."""
        return True

    def unknowns(self, problem):
        """Unknowns of its own, beside P, V and Y: a tuple of `Unknown`."""
        return ()

    def own_unit(self, problem, frame):
        """In which its own unknowns are measured in a frame."""
        return 1.0

    def level_unit(self, problem, frame):
        """In which its level (see `Parameter`) is measured in a frame."""
        return 1.0

    def once(self, loop):
        """Blocks that are demanded once: (name, vertices, matrix) each."""
        return ()

    @abstractmethod
    def pair(self, loop, c):
        """Blocks of a pair of vertices: (name, matrix) each.

        Parameters
        ----------
        loop : Loop
        c : Coupled
        """

    def slack(self, loop, c, i):
        """Blocks of a vertex with a slack matrix: (name, matrix) each.

        Parameters
        ----------
        loop : Loop
        c : SlackVertex
        i : int
            Which vertex it is.
        """
        raise ValueError(
            f'{self.words} has no LMI with a slack matrix: take '
            'coupling="pairs"'
        )

    @abstractmethod
    def claim(self):
        """What a proof of its blocks proves, in words; never more."""

    @abstractmethod
    def truth(self, loops, K, K_A=None):
        """The true value of the worst loop, to be compared with the bound.

        Parameters
        ----------
        loops : sequence of Descriptor
        K : (m, N) array
        K_A : (m, n) array, optional
        """

    def kept(self, truth):
        """Positive where the promise is kept: the bound less the truth."""
        return self.bound - truth

    def tuned(self, smallest):
        """Itself with the best free scalar of its theorem, or None.

        Parameters
        ----------
        smallest : callable
            From a requirement of this kind to the smallest bound that can
            be proven with it; infinity for none.
        """
        return self

    # coordinates in which the LMIs are well conditioned

    def rate(self):
        """(rank, typical rate in rad/s); None where it names no rate."""

    def riccati(self):
        """(Q, R) of the Riccati equation that it is about, or None."""

    def reach(self, T, Bw, omega):
        """How large P must be in coordinates x = T xi, roughly."""
        return 0.0


class BlockName(str):
    """The label of a block, which also knows whose block it is.

    Attributes
    ----------
    requirement : tuple or None
        The key of its requirement; None for P itself.
    block : str
        The requirement's own name of the block.
    vertices : tuple of int
        Of the vertex or the pair; empty for what is demanded once.
    """

    def __new__(cls, label, requirement, block, vertices):
        self = super().__new__(cls, label)
        self.requirement, self.block = requirement, block
        self.vertices = vertices
        return self

    def __getnewargs__(self):
        return str(self), self.requirement, self.block, self.vertices


class BlockTable:
    """The one place where the blocks of a problem come together.

    Their keys are (requirement, block, vertices), so that no name that a
    user chose can take the place of another block.

    Parameters
    ----------
    many : bool
        Whether labels show the vertices' numbers.
    """

    def __init__(self, many):
        self.many, self.matrices, self.owners = many, {}, {}

    def add(self, requirement, block, vertices, matrix):
        """Join a block; refuse one that is there already."""
        key = (requirement and requirement.key, block,
               tuple(dict.fromkeys(vertices)))
        if key in self.matrices:
            raise ValueError(f"two blocks are called {key}")
        self.matrices[key], self.owners[key] = matrix, requirement

    def named(self):
        """dict from `BlockName` to matrix, in the order of joining."""
        taken = {block for _, block, _ in self.matrices}
        found = {}
        for key, matrix in self.matrices.items():
            owner, block = self.owners[key], key[1]
            label = block or owner.name
            if not block and label in taken:  # a name that a user chose
                label = f"{owner.kind} {label}"
            label += self._numbers(key[2])
            if label in found:
                label = f"{owner.name} {label}"
            if label in found:
                raise ValueError(f"two blocks are labelled {label!r}")
            found[BlockName(label, *key)] = matrix
        return found

    def _numbers(self, vertices):
        if not self.many or not vertices:
            return ""
        return " " + ",".join(str(i + 1) for i in vertices)


def sane_name(name):
    """A name that is safe in messages, pages and files, or a ValueError."""
    if not isinstance(name, str) or not re.fullmatch(
            r"(?!\s)[\w -]+(#\d+)?(?<!\s)", name):
        raise ValueError(
            f"name = {name!r} must be a string of letters, digits, spaces "
            "and hyphens"
        )
    return name
