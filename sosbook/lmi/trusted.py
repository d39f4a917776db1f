"""LMIs that are known to be affine and symmetric, for this package wrote them."""

from functools import cached_property

from ..solver.blocks import Blocks
from ..solver.evaluated import EvaluatedBlocks, unit_readings
from .problem import LMIProblem

__all__ = ["TrustedProblem"]

# Up to here blocks are read at once, and the Hessian comes from the table of slopes.
# Sums of Kronecker products take numpy's calls for each two unknown matrices.
FEW_VARIABLES, VARIABLES_OF_PART = 52, 1.5
SMALL_TABLE, TABLE_OF_PART = 32_000, 2_900  # entries of all slopes


class TrustedProblem(LMIProblem):
    """An `LMIProblem` whose blocks aren't checked, and read at once if they are few.

    What isn't affine is refused when products of unknowns are written, and goes
    unnoticed when blocks are read at once.

    Parameters
    ----------
    write, unknowns, time_limit
        As for `LMIProblem`.
    """

    def reads_at_once(self):
        """Whether the blocks may be read with `unit_readings`."""
        return True

    @cached_property
    def compiled(self):
        """The `Blocks` that the solver takes."""
        variables = sum(u.size for u in self.unknowns)
        matrices = sum(u.shape != (1, 1) for u in self.unknowns)
        parts = matrices * (matrices + 1) / 2
        few = variables <= FEW_VARIABLES + VARIABLES_OF_PART * parts
        if few and self.reads_at_once():
            blocks = self.blocks(unit_readings(self.unknowns)).values()
            table = variables * sum(g.shape[0] ** 2 for g in blocks)
            if table <= SMALL_TABLE + TABLE_OF_PART * parts:
                return EvaluatedBlocks(blocks, self.unknowns)
        return Blocks.of(self.expressions.values(), self.unknowns)
