"""What a request says of its loop, and who demands the blocks that prove it."""

from functools import cached_property

from ..plants.descriptor import coupled_pairs
from ..plants.kinds import every_plant
from ..requirements.stability import Stability
from .probe import affine_in_quotient


class Statements:
    """The part of a `Request` that knows its claims, and which pairs they need."""

    @property
    def covers_polytope(self):
        """Whether the blocks say something about the whole polytope."""
        if self.coupling != "vertices":
            return True
        return len(self.pairs) == len(self._pairs_of("pairs"))

    @property
    def at_corners(self):
        """Whether the vertices are the corners of ranges, and nothing else is meant."""
        return self.plant.family is not None and self.plant.family.multi_affine

    def _pairs_of(self, coupling):
        authors = [r for r in self.requirements if not r.of_package]
        quotient = all(r.affine_in_quotient for r in self.requirements)
        pairs = coupled_pairs(self.certain, coupling, quotient, self.at_corners)
        if quotient and authors:  # what is left out must be more than their word
            every = coupled_pairs(self.certain, coupling, False)
            if every != pairs and not all(affine_in_quotient(r, self) for r in authors):
                return every
        return pairs

    def statements(self):
        """What the blocks prove: (words, requirement) each.

        The one place where claims are made: each stands beside the requirement
        that demands the blocks which prove it, and `demands` and the proofs' claims
        come from here. What exactly repeats an earlier requirement rests on that
        one's blocks. That an author's class implies stability is no proof of it.
        """
        N = len(self.vertices)
        where = every_plant(self.plant)
        if N > 1 and not self.covers_polytope:
            where = f"each of the {N} vertices (not the plants between)"
        under = ", under u = K x," if self.plant.m else ""
        if self.law is not None:
            under = f", under u = K y ({self.law.words(self.plant)}),"
        implying = (r for r in self.requirements if r.implies_stability)
        stable = next((r for r in implying if r.of_package), Stability())
        said = [(f"{where}{under} is stable", stable)]
        owners = []
        for r in self.requirements:
            owner = next((o for o in owners if r.of_package and r.repeats(o)), r)
            owners.append(owner)
            said.append((r.statement, owner))
        return said

    @cached_property
    def demands(self):
        """The requirements in the order of their blocks; stability joins.

        Those with unknowns of their own come first.
        """
        (_, stable), *others = self.statements()
        asked = {r.key: r for _, r in others}
        if stable.key not in asked:
            asked = {stable.key: stable} | asked
        return tuple(sorted(asked.values(), key=lambda r: not r.unknowns(self)))
