"""The claims of a request: what its blocks prove, and which requirement's they are."""

from functools import cached_property

from ..exact.checker.families import ticks
from ..plants.coupling import OneP
from ..plants.gain import states_data
from ..plants.kinds import every_plant
from ..requirements.stability import Stability


class Claims:
    """The statements that the blocks of a ``request`` prove."""

    def __init__(self, request):
        self.request = request

    @property
    def covers_polytope(self):
        """True if the blocks say something about the whole polytope."""
        request = self.request
        every = request.coupling.between
        return every or len(request.pairs) == len(request.pairs_of(OneP()))

    def statements(self):
        """The (words, requirement) that the blocks prove: the one place where claims
        are made. What repeats an earlier requirement rests on that one's blocks; that
        an author's class implies stability is no proof of it.
        """
        request, N = self.request, len(self.request.vertices)
        where = every_plant(request.plant, request.coupling.scope)
        if N > 1 and not self.covers_polytope:
            where = f"each of the {N} vertices (not the plants between)"
        under = request.applied.under if request.plant.m else ""
        said = [f"{where}{under} is stable{ticks(states_data(request.plant))}"]
        said += [r.statement for r in request.requirements]
        return list(zip(said, self.owners, strict=True))

    @property
    def stability(self):
        """That the plants are stable, as a requirement."""
        return Stability().stepped(self.request.step)

    def place(self, s):
        """Where the pole ``s`` of the loops is, in words: of ticks as the plant's z."""
        step = self.request.step
        return f"{s:.4g} rad/s" if step is None else f"z = {1 + step * s:.4g}"

    @cached_property
    def owners(self):
        """The requirements whose blocks prove stability and what is required."""
        asked = self.request.requirements
        implying = (r for r in asked if r.implies_stability)
        stated = (r for r in implying if r.of_package)
        owners = [next(stated, self.stability)]
        for r in asked:
            owned = (o for o in owners[1:] if r.of_package and r.repeats(o))
            owners.append(next(owned, r))
        return owners
