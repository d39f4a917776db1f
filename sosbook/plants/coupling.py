"""How LMIs couple the plants of a family: with which unknowns and which blocks, what
the gain is divided by, and of which plants a proof speaks.

`BY_WORD` is the one table that finds a coupling by the word that users and files give.
Everybody else asks the object.
"""

from dataclasses import dataclass, field, replace
from itertools import combinations
from typing import ClassVar

import numpy as np

from ..exact.checker.families import CHANGING, CONSTANT
from ..exact.rational import decimal, decimals
from ..language import Unknown
from ..runtime.read_only import put
from ..runtime.time_limit import check_time
from .checks import positive
from .coupled import Coupled, SlackVertex
from .descriptor import twins
from .hull import quotient_in_hull


@dataclass(frozen=True)
class Coupling:
    """One way to couple the plants; each subclass has a word in `BY_WORD`. Either all
    plants share an unknown P (``one_P``), or each vertex has its own beside a slack
    matrix V (``own_P``), or neither: a known gain is proven with multipliers.
    ``between``: the blocks speak of the plants between the vertices, too; ``chooses``:
    which coupling it is, is settled later; ``scope``: of constant plants alone, or of
    changing ones; ``unknown_words``: for messages; ``slack``: the scalar of the slack
    LMIs, or None.
    """

    one_P: ClassVar[bool] = False
    own_P: ClassVar[bool] = False
    between: ClassVar[bool] = True
    chooses: ClassVar[bool] = False
    scope: ClassVar[str] = CONSTANT
    unknown_words: ClassVar[str] = "P"
    slack: float | None = field(default=None, repr=False)

    def __post_init__(self):
        if self.slack is None:
            return
        if not (self.own_P or self.chooses):
            raise ValueError(
                'slack is given, but coupling is not "slack": leave one out'
            )
        put(self, slack=positive("slack", self.slack))

    @property
    def word(self):
        """The word that users and files give for it."""
        return next(word for word, kind in BY_WORD.items() if kind is type(self))

    @property
    def proof(self):
        """The coupling that files call it by, whose theorem proves a point of it."""
        return self

    @property
    def free(self):
        """True if each requirement has unknowns of its own: P and free multipliers."""
        return not (self.one_P or self.own_P)

    @property
    def open(self):
        """True if the scalar is still sought."""
        return self.own_P and self.slack is None

    @property
    def condition(self):
        """The condition of a refusal, in words: ("slack = 0.1 s",) or nothing."""
        return ()

    def of_ticks(self, step):
        """The same for a plant with the tick ``step``, None in continuous time."""
        return self

    def settled(self, request):
        """The coupling to be taken for a ``request``: itself, unless it `chooses`."""
        return self

    def check(self, gain):
        """Raise a ValueError if it isn't for this ``gain``, which is None if sought."""

    def pairs(self, vertices, quotient=True, corners=False):
        """Indices (i, j), i <= j, of the pairs of ``vertices``, in descriptor form,
        that need a block: here each vertex with itself, but for those that repeat one.

        ``quotient``: whether all LMIs are affine in the quotient: see
        `Requirement.affine_in_quotient`; ``corners``: whether the vertices are the
        corners of ranges: see `quotient_in_hull`.
        """
        return [(i, i) for i in sorted(set(twins(vertices)))]

    def lyapunov(self, first):
        """Names of the unknown P, one for each of the `Coupling.given`; ``first`` says
        for each vertex which one it repeats.
        """
        return ("P",)

    def unknowns(self, first, N):
        """Its `Unknown` for N states; ``first`` as in `lyapunov`."""
        names = dict.fromkeys(self.lyapunov(first))
        return [Unknown(name, N, symmetric=True) for name in names]

    def given(self, P):
        """The theorems' part of the matrices ``P`` of `lyapunov`: the only one."""
        (P,) = P
        return P

    def divisor(self, values):
        """The X of K = Y X'^-1, of the ``values`` of all unknowns by name."""
        return values["P"]

    def once(self, P):
        """The blocks of P that are demanded once: as `blocks` has them."""
        yield None, "P", (), P

    def each(self, P, i):
        """The blocks of P that vertex i demands: as `blocks` has them."""
        return ()

    def coupled(self, loop, i, j):
        """The theorems' matrices of the vertices i and j of a ``loop``."""
        return Coupled(loop.vertices[i], loop.vertices[j], loop.P, loop.Y)

    def asked(self, r, loop, c, i):
        """The blocks of a requirement ``r`` of a ``loop``, (name, matrix) each, of what
        is `coupled`, ``c``, with vertex i.
        """
        return r.pair(loop, c)

    def blocks(self, demands, P, loops, pairs, known):
        """(requirement, name, vertices, matrix) of each block of some ``pairs``. The
        ``loops`` are those that the requirements in ``demands`` see, by key, and
        ``known`` has blocks that are written already, by requirement and pair; ``P`` is
        as `given` has it.
        """
        for i, j in pairs:
            yield from self.each(P, i)
            coupled = {}
            for r in demands:
                loop, blocks = loops[r.key], known.get((r.key, (i, j)))
                if blocks is None:
                    if loop.exact:  # floats have to end, so that a point isn't lost
                        check_time()
                    if loop not in coupled:
                        coupled[loop] = self.coupled(loop, i, j)
                    blocks = dict(self.asked(r, loop, coupled[loop], i))
                for name, g in blocks.items():
                    yield r, name, (i, j), g

    def data(self, request):
        """Its data in a proof file of a ``request``: its word, and a slack matrix's."""
        E0 = None if self.slack is None else decimals(request.mean.E)
        scalar = None if self.slack is None else decimal(self.slack)
        return {"coupling": self.proof.word, "epsilon": scalar, "E0": E0}


class VerticesOnly(Coupling):
    """One P, with blocks of the vertices alone and no ``slack`` scalar: the thesis's
    reading, which may prove nothing inside the polytope when E is uncertain.
    """

    one_P, between, scope = True, False, CHANGING


class OneP(Coupling):
    """One P for all plants, with blocks of pairs and no ``slack`` scalar. V = x'P^-1 x
    doesn't know which plant it is: parameters may change, as fast as they like, in
    E(p(t)) x' = A(p(t)) x.
    """

    one_P, scope = True, CHANGING

    def pairs(self, vertices, quotient=True, corners=False):
        """Where ``E_i = E_j`` the pair's block is the mean of the vertices' blocks and
        is left out. So is every pair where the vertices suffice: see ``quotient`` and
        ``corners`` in `Coupling.pairs`.
        """
        pairs = super().pairs(vertices)
        if quotient and quotient_in_hull(vertices, corners):
            return pairs
        masses = {i: tuple(np.ravel(vertices[i].E)) for i, _ in pairs}
        kinds = {E: kind for kind, E in enumerate(dict.fromkeys(masses.values()))}
        kind = {i: kinds[E] for i, E in masses.items()}
        return pairs + [(i, j) for i, j in combinations(kind, 2) if kind[i] != kind[j]]


@dataclass(frozen=True)
class PPerVertex(Coupling):
    """A P for each vertex and one slack matrix V, with the scalar ``slack`` in seconds,
    which is sought where it is None. The blocks are affine in the plant, so that no
    pair is needed.
    """

    own_P: ClassVar[bool] = True
    unknown_words: ClassVar[str] = "P_i, V"
    slack: float | None = None

    def of_ticks(self, step):
        """With the tick as scalar no gain of one plant is lost: de Oliveira, Bernussou
        and Geromel (1999).
        """
        return self if step is None or not self.open else PPerVertex(step)

    @property
    def condition(self):
        return () if self.slack is None else (f"slack = {self.slack:g} s",)

    def lyapunov(self, first):
        return tuple(f"P {i + 1}" for i in first)

    def unknowns(self, first, N):
        return [*super().unknowns(first, N), Unknown("V", N, N)]

    def given(self, P):
        return P

    def divisor(self, values):
        return values["V"]

    def once(self, P):
        return ()

    def each(self, P, i):
        yield None, "P", (i,), P[i]

    def coupled(self, loop, i, j):
        return SlackVertex(loop.vertices[i], loop.E0, loop.P[i], loop.V, loop.Y)

    def asked(self, r, loop, c, i):
        return r.slack(loop, c, i)


class Multipliers(Coupling):
    """A known gain: P of its own for each vertex and requirement, free multipliers,
    cells where these need them, and no ``slack`` scalar.
    """

    def check(self, gain):
        if gain is None:
            raise ValueError(
                'coupling="multipliers" is for a given gain: take "slack" for a design'
            )


class Auto(OneP):
    """One P; where what is asked has no such LMIs, a P each, with ``slack``."""

    chooses: ClassVar[bool] = True

    def settled(self, request):
        known = request.gain is not None
        if known or all(r.fits_one_P(request) for r in request.requirements):
            return coupling_of("pairs", self.slack)
        return PPerVertex(self.slack)


#: Each coupling by its word.
BY_WORD: dict[str, type[Coupling]] = {
    "vertices": VerticesOnly,
    "pairs": OneP,
    "slack": PPerVertex,
    "multipliers": Multipliers,
    "auto": Auto,
}
#: Words of those that design; what accepts most comes first.
COUPLINGS = tuple(
    word
    for word, kind in BY_WORD.items()
    if (kind.one_P or kind.own_P) and not kind.chooses
)


def coupling_of(word, slack=None):
    """The `Coupling` of a ``word``, of a word and its scalar ``slack`` in a pair, or
    one that is given.

    >>> coupling_of("slack", 0.1) == coupling_of(("slack", 0.1))
    True
    >>> coupling_of("pairs", 0.1)
    Traceback (most recent call last):
    ValueError: slack is given, but coupling is not "slack": leave one out
    """
    if isinstance(word, (tuple, list)) and len(word) == 2:
        return coupling_of(*word)
    kind = BY_WORD.get(word) if isinstance(word, str) else None
    if kind is None and not isinstance(word, Coupling):
        raise ValueError(
            'coupling must be "pairs", "vertices", "slack" or a pair ("slack", 0.1), '
            'for a given gain also "multipliers", for a single request also "auto", '
            f"got {word!r}"
        )
    found = kind() if kind else word
    return found if slack is None else replace(found, slack=slack)
