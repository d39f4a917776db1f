"""Cutting planes: of the blocks of many pairs of vertices a few decide."""

import numpy as np

from ..lmi.newton import newton_of
from ..lmi.time_limit import check_time

__all__ = ["CENTRE_UP_TO_PAIRS", "CUTTING_PLANE_ABOVE_PAIRS", "Cuts"]

# pairs of vertices
CUTTING_PLANE_ABOVE_PAIRS = 24  # from here on it is faster than all blocks at once
CENTRE_UP_TO_PAIRS = 1000  # up to here the centre is that of all blocks
PAIRS_PER_CUT = 4  # how many join at a time


class Cuts:
    """Blocks of many pairs of vertices, of which a few are solved at a time.

    Parameters
    ----------
    blocks : Blocks
        All the blocks.
    names : sequence of BlockName
        Theirs. Blocks of no pair, such as P, are there from the start.
    """

    def __init__(self, blocks, names):
        self.blocks, self.newton = blocks, newton_of(blocks)
        self.owners = np.array([str(name.vertices) for name in names])
        self.chosen = {"()": None}

    def some(self):
        """The blocks that are chosen so far."""
        return self.blocks.only(np.flatnonzero(np.isin(self.owners, list(self.chosen))))

    def holds(self, x):
        """Whether all blocks are positive definite at x."""
        return bool(self.newton.least(x).min() > 0)

    def join(self, x, violated=True):
        """Choose the pairs with the smallest eigenvalues at x.

        Parameters
        ----------
        x : array
            The point that is looked at.
        violated : bool
            Only those that aren't positive definite there.

        Returns
        -------
        bool
            Whether there was one more.
        """
        least = self.newton.least(x)
        order = np.argsort(least)[: (least <= 0).sum() if violated else None]
        fresh = [o for o in dict.fromkeys(self.owners[order]) if o not in self.chosen]
        self.chosen.update(dict.fromkeys(fresh[:PAIRS_PER_CUT]))
        return bool(fresh)

    def solve(self, x, work):
        """Where ``work`` ends if it sees those blocks only that matter.

        Parameters
        ----------
        x : array
            All blocks are positive definite there.
        work : callable
            From some `Blocks` and x to another point inside them; it may
            raise a ValueError, and gets more blocks then.

        Returns
        -------
        array
            What ``work`` returned last.
        """
        more = self.join(x, violated=False)
        while True:
            check_time()
            try:
                outcome = work(self.some(), x)
            except ValueError:
                if not more:
                    raise
                more = self.join(x, violated=False)
                continue
            if self.holds(outcome) or not self.join(outcome):
                return outcome
