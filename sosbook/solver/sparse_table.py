"""Values and adjoints of blocks from a sparse table of their slopes.

Most factors of a product L X R are rows of an identity: then each variable moves a
few entries of the blocks, and two products of a sparse matrix with a vector take
less time than numpy's calls for all the small matrices.
"""

from copy import copy

import numpy as np
from scipy.sparse import csr_array

from ..runtime.time_limit import check_time
from .structure import real

__all__ = ["SparseTable"]

SECONDS_OF_A_NUMBER = 2e-7  # that isn't zero, to be sorted into the table; about


class SparseTable:
    """Values of blocks at points and along directions, and their adjoint.

    Parameters
    ----------
    owner : Stacked
        The blocks.
    """

    def __init__(self, owner):
        stacks = owner.stacks
        self.constant = np.concatenate([real(s.constant) for s in stacks])
        self.weights = np.repeat(
            [float(s.weight) for s in stacks], [real(s.constant).size for s in stacks]
        )
        self.parts, start = [], 0  # of a vector of all entries: place, kind, shape
        rows, columns, numbers = [], [], []
        for s in stacks:
            stop = start + real(s.constant).size
            self.parts.append((slice(start, stop), s.constant.dtype, s.constant.shape))
            for row, column, number in _slopes(owner, s):
                check_time()
                rows.append(row)
                if s.weight == 2:  # an imaginary part follows its real one
                    rows.append(row)
                    columns += [start + 2 * column, start + 2 * column + 1]
                    numbers += [number.real, number.imag]
                else:
                    columns.append(start + column)
                    numbers.append(number)
            start = stop
        check_time(SECONDS_OF_A_NUMBER * sum(map(len, numbers)))
        shape = owner.variables, start
        index = np.concatenate(rows), np.concatenate(columns)
        self.table = csr_array((np.concatenate(numbers), index), shape=shape)
        self.mirrored = self.table.T.tocsr()
        self.more, self.row = [], None  # slopes of further variables, one more block

    def joined(self, owner):
        """The same with one more scalar variable, as the ``owner`` has it; or a row."""
        joined = copy(self)
        blocks = [s for s in owner.stacks if s.gradient is None]
        joined.more = [*self.more, np.concatenate([real(s.slopes[-1]) for s in blocks])]
        for s in owner.stacks[len(blocks) :]:
            joined.row = s.constant, s.gradient
        return joined

    def moved(self, owner):
        """The same slopes with the constants of an ``owner``."""
        moved = copy(self)
        moved.constant = np.concatenate([real(s.constant) for s in owner.stacks])
        return moved

    def diagonal_squares(self):
        """Sums of squares of each diagonal entry's derivatives, by stack."""
        squares = self.table.power(2).sum(axis=0) + sum(g**2 for g in self.more)
        return [g.real.diagonal(0, 1, 2) for g in self._split(squares)]

    def at(self, x):
        """The blocks at a (k,) array x."""
        stacks = self._split(self.constant + self._change(x))
        if self.row is not None:
            constant, gradient = self.row
            stacks.append(constant + gradient @ x)
        return stacks

    def along(self, direction):
        """The change of the blocks along a ``direction``."""
        stacks = self._split(self._change(direction))
        if self.row is not None:
            constant, gradient = self.row
            stacks.append(np.full_like(constant, gradient @ direction))
        return stacks

    def adjoint(self, Z):
        """sum_k <G_ka, Z_k> for each variable a, for a list of stacks Z."""
        flat = self.weights * np.concatenate([real(z) for z in Z[: len(self.parts)]])
        out = np.append(self.table @ flat, [g @ flat for g in self.more])
        if self.row is not None:
            out += Z[-1].item() * self.row[1]
        return out

    def _change(self, direction):
        """A vector of all entries' changes, without those of a row."""
        k = self.table.shape[0]
        change = self.mirrored @ direction[:k]
        for step, slope in zip(direction[k:], self.more):
            change += step * slope
        return change

    def _split(self, flat):
        """The list of stacks that a vector of all their entries holds."""
        return [flat[at].view(kind).reshape(shape) for at, kind, shape in self.parts]


def _slopes(owner, stack):
    """(variables, entries, numbers) of a stack's slopes that aren't zero, in parts."""
    q = stack.q
    at, i, r, c = np.nonzero(stack.slopes)
    yield owner.scalars[at], (i * q + r) * q + c, stack.slopes[at, i, r, c]
    for i, b in enumerate(stack.blocks):
        for t in b.products:
            r, a = np.nonzero(t.left)
            d, c = np.nonzero(t.right)
            layout = owner.layouts[t.unknown]
            variable = layout.start + layout.places[a[:, None], d]
            number = t.left[r, a][:, None] * t.right[d, c]
            for row, column, part in (
                (r[:, None], c, number),
                (c, r[:, None], number.conj()),
            ):
                entry = np.broadcast_to((i * q + row) * q + column, number.shape)
                yield variable.ravel(), entry.ravel(), part.ravel()
