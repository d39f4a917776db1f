"""LMIs that are known to be affine and symmetric, for this package wrote them."""

from functools import cached_property

from ..solver.blocks import Blocks
from ..solver.evaluated import EvaluatedBlocks, unit_readings
from .problem import LMIProblem

__all__ = ["TrustedProblem"]


class TrustedProblem(LMIProblem):
    """An `LMIProblem` whose blocks aren't checked, and read at once if they are few.

    What isn't affine is refused when products of unknowns are written, and goes
    unnoticed when blocks are read at once.

    ``write``, ``unknowns``, ``time_limit``, ``settings``: as for `LMIProblem`.
    """

    def reads_at_once(self):
        """Whether the blocks may be read with `unit_readings`."""
        return True

    @cached_property
    def compiled(self):
        """The `Blocks` that the solver takes."""
        use = self.settings or Blocks.settings
        few = sum(u.size for u in self.unknowns) <= use.read_up_to_variables
        if few and self.reads_at_once():
            values = self.blocks(unit_readings(self.unknowns)).values()
            blocks = EvaluatedBlocks(values, self.unknowns)
        else:
            blocks = Blocks.of(self.expressions.values(), self.unknowns)
        blocks.settings = use
        return blocks
