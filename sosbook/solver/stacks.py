"""Values and adjoints of blocks, many blocks in one numpy call.

Small blocks are padded with identities and stacked with others of similar size into
arrays (blocks, q, q). Wherever this module, `newton` and `primal_dual` speak of a list
of stacks, it is one matrix for each block, arranged so.
"""

from copy import copy
from dataclasses import replace

import numpy as np

from .structure import StructuredBlock
from .sums import Sums, span

ROUNDING = 1e-13  # of what cancels in a diagonal entry that is zero
SMALL_ROWS = 12  # of blocks that are padded to one size: fewer calls, as many digits


def gram(roots):
    """The products W = N' N of each N in a list of stacks ``roots``."""
    return [N.mT @ N for N in roots]


class Stacked:
    """Blocks G_k of k ``variables`` as stacks, and their adjoint.

    ``blocks``: a `Blocks`, which gives ``layouts`` of unknown matrices, indices of the
    ``scalars`` and the ``settings``. ``stacks`` hold constants and slopes of one size;
    ``degree`` is the sum of sizes, padding included; ``values``, a `Sums` or `_Table`,
    computes blocks at points, changes and adjoints.
    """

    def __init__(self, blocks):
        self.layouts, self.scalars, members = blocks.structure
        self.variables, self.settings = blocks.variables, blocks.settings
        self.stacks = _stacks(members)
        self.degree = sum(len(s.blocks) * s.q for s in self.stacks)
        entries = self.variables * sum(s.constant.size for s in self.stacks)
        products = sum(len(b.products) for s in self.stacks for b in s.blocks)
        most = self.settings.table_per_product * products
        most = min(most, self.settings.most_table_entries)
        # without unknown matrices the slopes are a table already
        self.values = (_Table if entries <= most or not self.layouts else Sums)(self)

    def joined(self, slopes, row=None):
        """The blocks with one more scalar, the last, whose ``slopes`` are by block.

        With a ``row`` (c, g) the number c + g.x is one more block. What it can share
        with this one, it shares.
        """
        joined = copy(self)
        joined.variables += 1
        joined.scalars = np.append(self.scalars, self.variables)
        joined.stacks = [s.joined(slopes) for s in self.stacks]
        if row is not None:
            joined.stacks.append(_Row(joined, len(slopes), *row))
            joined.degree += 1
        joined.values = self.values.joined(joined)
        return joined

    def with_constants(self, constants):
        """The blocks with other ``constants``, a list of (q, q) arrays."""
        changed = copy(self)
        changed.stacks = [s.with_constants(constants) for s in self.stacks]
        changed.values = self.values.moved(changed)
        return changed

    def diagonal_magnitudes(self):
        """How large each diagonal entry may become, (q,) for each block: the constant's
        entry plus the 2-norm of its derivatives; zero where all of it cancels.
        """
        squares = self.values.diagonal_squares()
        large = [
            np.abs(s.constant.diagonal(0, 1, 2)) + np.sqrt(np.maximum(e, 0))
            for s, e in zip(self.stacks, squares)  # rounding may leave -1e-17
        ]
        for s, e in zip(self.stacks, large):
            e[e <= ROUNDING * s.before_cancelling()] = 0
        return self._by_block(large, lambda e, k: e[:k])

    def at(self, x):
        """The blocks at a (k,) array x, as a list of stacks."""
        return self.values.at(x)

    def along(self, direction):
        """sum_a d_a G_ka: the change of the blocks along a ``direction`` d."""
        return self.values.along(direction)

    def scaled(self, roots, direction):
        """N dG N' of all blocks for their change dG `along` a direction.

        ``roots`` are the N, a list of stacks.
        """
        changes = self.along(direction)
        return [N @ d @ N.mT for N, d in zip(roots, changes)]

    def scaled_adjoint(self, roots, Z):
        """The adjoint of N' Z N, for two lists of stacks: the N, ``roots``, and Z."""
        return self.adjoint([N.mT @ z @ N for N, z in zip(roots, Z)])

    def adjoint(self, Z):
        """sum_k <G_ka, Z_k> for each variable a, for a list of stacks Z."""
        return self.values.adjoint(Z)

    def inner(self, Y, Z):
        """sum_k <Y_k, Z_k>, for two lists of stacks Y and Z."""
        return sum(np.vdot(y, z) for y, z in zip(Y, Z))

    def least(self, x, scales=None):
        """The smallest eigenvalue of each block at x, at most 1.

        With ``scales``, as `stacked_diagonals` gives them, it is that of d_i d_j G_ij.
        """
        stacks = self.at(x)
        if scales is not None:
            stacks = [d[..., None] * g * d[:, None] for d, g in zip(scales, stacks)]
        smallest = np.ones(sum(len(s.indices) for s in self.stacks))
        for s, g in zip(self.stacks, stacks):
            smallest[s.indices] = np.minimum(np.linalg.eigvalsh(g)[:, 0], 1)
        return smallest

    def unstacked(self, Z):
        """A list of stacks Z as a list of matrices, one for each block."""
        return self._by_block(Z, lambda z, k: z[:k, :k])

    def stacked_diagonals(self, diagonals):
        """(q,) ``diagonals`` of all blocks, padded with ones, by stack."""
        stacks = [np.ones(s.constant.shape[:2]) for s in self.stacks]
        for s, stack in zip(self.stacks, stacks):
            for row, index, k in zip(stack, s.indices, s.sizes):
                row[:k] = diagonals[index]
        return stacks

    @property
    def table_entries(self):
        """How many entries the table of all slopes has; infinite without one."""
        return self.values.table.size if isinstance(self.values, _Table) else np.inf

    def _by_block(self, stacks, cut):
        """A list of ``cut(entry, size)``, one for each block."""
        found = {}
        for s, entries in zip(self.stacks, stacks):
            found.update(zip(s.indices, map(cut, entries, s.sizes)))
        return [found[index] for index in range(len(found))]


class _Stack:
    """Blocks that are padded to one size q; ``indices`` says which."""

    gradient = None

    def __init__(self, indices, blocks):
        self.indices, self.blocks = indices, blocks
        self.sizes = [len(b.constant) for b in blocks]
        self.q = q = max(self.sizes)
        self.constant = self._filled()
        self.slopes = np.zeros((len(blocks[0].slopes), len(blocks), q, q))
        for i, (b, k) in enumerate(zip(blocks, self.sizes)):
            self.slopes[:, i, :k, :k] = b.slopes

    def _filled(self):
        """The blocks' constants, with ones on the diagonal below them."""
        constant = np.zeros((len(self.blocks), self.q, self.q))
        constant[:] = np.eye(self.q)
        for g, b, k in zip(constant, self.blocks, self.sizes):
            g[:k, :k] = b.constant
        return constant

    def before_cancelling(self):
        """How large diagonal entries were if no product cancelled another: (b, q), by
        |g_ij|^2 <= g_ii g_jj from what is left in their rows.
        """
        large = np.abs(self.constant.diagonal(0, 1, 2))
        squares = (self.slopes**2).sum(axis=0)
        for entries, b, k, square in zip(large, self.blocks, self.sizes, squares):
            if not b.products:
                diagonal = entries + np.sqrt(square.diagonal())
                others = np.where(np.eye(len(square)), 0, square)
                known = np.where(diagonal > 0, diagonal, np.inf)
                row = np.minimum(
                    np.sqrt(square.sum(axis=1)), (others / known).max(axis=1)
                )
                entries[:] = np.where(entries > 0, entries, row)
            for t in b.products:
                left = np.linalg.norm(t.left, axis=1)
                entries[:k] += 2 * left * np.linalg.norm(t.right, axis=0)
        return large

    def with_constants(self, constants):
        """The stack with those of other ``constants`` that are its blocks'."""
        changed = copy(self)
        changed.blocks = [
            replace(b, constant=constants[k]) for b, k in zip(self.blocks, self.indices)
        ]
        changed.constant = changed._filled()
        return changed

    def joined(self, slopes):
        """The stack with one more scalar variable; ``slopes`` are of all blocks."""
        joined, last = copy(self), np.zeros((1, *self.constant.shape))
        for i, (index, k) in enumerate(zip(self.indices, self.sizes)):
            last[0, i, :k, :k] = slopes[index]
        joined.slopes = np.concatenate([self.slopes, last])
        return joined


class _Row(_Stack):
    """One block of one entry, with its ``gradient`` by all variables."""

    def __init__(self, owner, index, constant, gradient):
        self.gradient = np.append(gradient, 0.0)
        slopes = self.gradient[owner.scalars].reshape(-1, 1, 1)
        block = StructuredBlock(np.array([[float(constant)]]), [], slopes)
        super().__init__([index], [block])


def _stacks(blocks):
    """Stacks of blocks, of all small ones and of large ones by size."""
    groups = {}
    for index, b in enumerate(blocks):
        groups.setdefault(max(len(b.constant), SMALL_ROWS), []).append(index)
    return [_Stack(at, [blocks[k] for k in at]) for at in groups.values()]


class _Table:
    """Values from one table of all slopes, which is fast for few variables."""

    def __init__(self, owner):
        """Tabulate every entry's slope in every variable."""
        self.constant = np.concatenate([s.constant.ravel() for s in owner.stacks])
        columns, start = [], 0
        self.parts = []  # of a vector of all entries: place and shape
        for s in owner.stacks:
            full = np.zeros((owner.variables, *s.constant.shape))
            full[owner.scalars] = s.slopes
            for i, b in enumerate(s.blocks):
                for t in b.products:
                    layout = owner.layouts[t.unknown]
                    end = layout.start + layout.size
                    _add_slopes(full[layout.start : end, i], layout, t)
            columns.append(full.reshape(owner.variables, -1))
            place = slice(start, start + columns[-1].shape[1])
            self.parts.append((place, s.constant.shape))
            start = place.stop
        self.table = np.hstack(columns)

    def joined(self, owner):
        joined = copy(self)
        blocks = [s for s in owner.stacks if s.gradient is None]
        last = np.concatenate([s.slopes[-1].ravel() for s in blocks])
        joined.table = np.vstack([self.table, last])
        for s in owner.stacks[len(blocks) :]:  # a row is one more column
            end = len(joined.constant)
            joined.parts = [*self.parts, (slice(end, end + 1), (1, 1, 1))]
            joined.constant = np.append(joined.constant, s.constant)
            joined.table = np.column_stack([joined.table, s.gradient])
        return joined

    def moved(self, owner):
        """The same slopes with the constants of an ``owner``."""
        moved = copy(self)
        moved.constant = np.concatenate([s.constant.ravel() for s in owner.stacks])
        return moved

    def diagonal_squares(self):
        """Sums of squares of each diagonal entry's derivatives, by stack."""
        sums = self._split(np.einsum("ak,ak->k", self.table, self.table))
        return [g.diagonal(0, 1, 2) for g in sums]

    def slopes(self):
        """Arrays (k, blocks, q, q), one for each stack."""
        return [self.table[:, at].reshape(-1, *shape) for at, shape in self.parts]

    def at(self, x):
        return self._split(self.constant + x @ self.table)

    def along(self, direction):
        return self._split(direction @ self.table)

    def adjoint(self, Z):
        return self.table @ np.concatenate([z.ravel() for z in Z])

    def _split(self, flat):
        """The list of stacks that a vector of all their entries holds."""
        return [flat[at].reshape(shape) for at, shape in self.parts]


def _add_slopes(total, layout, product):
    """Add the derivatives of a product and its mirror by the free entries."""
    rows, cols = span(product.left.any(axis=1)), span(product.right.any(axis=0))
    L, R = product.left[rows].T, product.right[:, cols]
    if layout.symmetric:
        i, j, off = layout.lower
        part = L[i][:, :, None] * R[j][:, None, :]
        part += (off[:, None] * L[j])[:, :, None] * R[i][:, None, :]
    else:
        part = L[:, None, :, None] * R[None, :, None, :]
        part = part.reshape(-1, *part.shape[2:])
    total[:, rows, cols] += part
    total[:, cols, rows] += part.mT
