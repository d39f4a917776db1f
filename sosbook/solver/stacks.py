"""Values and adjoints of blocks, many blocks in one numpy call.

Blocks of one kind and similar size are padded with identities and stacked
into arrays (blocks, q, q). Wherever this module, `newton` and `primal_dual`
speak of a list of stacks, it is one matrix for each block, arranged so.
"""

from copy import copy
from functools import cached_property

import numpy as np

from .alike import alike
from .structure import StructuredBlock, fold, real, unfold
from .sums import Sums, span
from .work import sums_work, table_work

__all__ = ["Stacked", "gram", "transposed"]

ROUNDING = 1e-13  # of what cancels in a diagonal entry that is zero
PADDED = 4, 8, 12, 20  # rows of blocks that are stacked together
FEW_ROWS = 12  # where numpy's calls may take longer than its work
SLOPES_OF_STACK = 8000  # entries of slopes that take as long as the calls of a stack
FOLD_ABOVE_ROWS = 10  # smaller complex blocks are faster among the real ones
MOST_TABLE_ENTRIES = 4e6  # of all slopes as one dense table (32 MB)


def transposed(stack):
    """The conjugate transposes of the matrices in an array ``stack``."""
    return stack.conj().swapaxes(-1, -2)


def gram(roots):
    """The products W = N' N of each N in a list of stacks ``roots``."""
    return [transposed(N) @ N for N in roots]


class Stacked:
    """Blocks as stacks, and their adjoint.

    Parameters
    ----------
    blocks : Blocks
        The blocks G_k, affine in k variables.

    Attributes
    ----------
    layouts : list of UnknownLayout
        The layouts of the unknown matrices.
    scalars : (s,) array
        Indices of the scalar variables.
    stacks : list
        The constants and slopes of the blocks of one kind and size.
    variables : int
        Number of the variables.
    degree : int
        Sum of the sizes of the blocks, padding included.
    values : Sums or _Table
        What computes the blocks at points, their changes and adjoints.
    """

    def __init__(self, blocks):
        self.layouts, self.scalars, members = blocks.structure
        self.variables = blocks.variables
        self.stacks = _stacks(members, self.variables)
        self.degree = sum(s.weight * len(s.blocks) * s.q for s in self.stacks)
        entries = sum(s.constant.size for s in self.stacks)
        few = entries * self.variables <= MOST_TABLE_ENTRIES
        fast = few and table_work(self) < sums_work(self)
        self.values = (_Table if fast else Sums)(self)

    def joined(self, slopes, row=None):
        """The blocks with one more scalar variable, the last.

        Parameters
        ----------
        slopes : list of (q, q) arrays
            Its slopes, one for each block.
        row : (float, (k,) array), optional
            One more block, the last: the number c + g.x for a row (c, g).

        Returns
        -------
        Stacked
            Of the same class; what it can share with this one, it shares.
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
        """The blocks with other ``constants``, a list of (q, q) arrays.

        It is of the same class, and shares what depends on the slopes alone.
        """
        changed = copy(self)
        changed.stacks = [s.with_constants(constants) for s in self.stacks]
        changed.values = self.values.moved(changed)
        return changed

    def diagonal_magnitudes(self):
        """How large each diagonal entry of a block may become.

        It is the constant's entry plus the 2-norm of the entry's derivatives,
        which bounds the entry for all variables of norm one. Where products
        cancel and leave nothing but rounding, it is zero.

        Returns
        -------
        list of (q,) arrays
            One for each block.
        """
        squares = self.values.diagonal_squares()
        large = [
            np.abs(s.constant.diagonal(0, 1, 2)) + np.sqrt(np.maximum(e, 0))
            for s, e in zip(self.stacks, squares)  # rounding may leave -1e-17
        ]
        for s, e in zip(self.stacks, large):
            e[e <= ROUNDING * s.before_cancelling()] = 0
        return self._by_block(
            large, lambda e, s, k: e[:k] if s.weight == 1 else np.tile(e[:k], 2)
        )

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
        return [N @ d @ transposed(N) for N, d in zip(roots, changes)]

    def scaled_adjoint(self, roots, Z):
        """The adjoint of N' Z N, for two lists of stacks: the N, ``roots``, and Z."""
        return self.adjoint([transposed(N) @ z @ N for N, z in zip(roots, Z)])

    def adjoint(self, Z):
        """sum_k <G_ka, Z_k> for each variable a, for a list of stacks Z."""
        return self.values.adjoint(Z)

    def inner(self, Y, Z):
        """sum_k <Y_k, Z_k>, for two lists of stacks Y and Z."""
        return sum(s.weight * np.vdot(y, z).real for s, y, z in zip(self.stacks, Y, Z))

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
        """A list of stacks Z as a list of real matrices, one for each block."""

        def cut(z, s, k):
            return unfold(z[:k, :k]) if s.weight == 2 else z[:k, :k]

        return self._by_block(Z, cut)

    def stacked_diagonals(self, diagonals):
        """Diagonals of all blocks by stack, padded with ones.

        Parameters
        ----------
        diagonals : list of (q,) arrays
            One for each block.

        Returns
        -------
        list of (blocks, q) arrays
            One for each stack.
        """
        stacks = [np.ones(s.constant.shape[:2]) for s in self.stacks]
        for s, stack in zip(self.stacks, stacks):
            for row, index, k in zip(stack, s.indices, s.sizes):
                row[:k] = diagonals[index][:k]  # of a folded one the first half
        return stacks

    @property
    def has_table(self):
        """Whether all slopes are held as a table."""
        return isinstance(self.values, _Table)

    def _by_block(self, stacks, cut):
        """A list of ``cut(entry, stack, size)``, one for each block."""
        parts = {}
        for s, entries in zip(self.stacks, stacks):
            for index, e, k in zip(s.indices, entries, s.sizes):
                parts[index] = cut(e, s, k)
        return [parts[index] for index in range(len(parts))]


class _Stack:
    """Blocks of one kind, padded to one size q; ``indices`` says which."""

    gradient = None

    def __init__(self, indices, blocks):
        self.indices, self.blocks = indices, blocks
        self.sizes = [len(b.constant) for b in blocks]
        self.q = q = max(self.sizes)
        self.weight = blocks[0].weight
        kind = complex if self.weight == 2 else float
        self.constant = self._filled(kind)
        scalars = len(blocks[0].slopes)
        self.slopes = np.zeros((scalars, len(blocks), q, q), kind)
        for i, (b, k) in enumerate(zip(blocks, self.sizes)):
            self.slopes[:, i, :k, :k] = b.slopes

    @cached_property
    def alike(self):
        """Which of its blocks are alike, see `alike`."""
        return alike(self.blocks)

    def _filled(self, kind):
        """The blocks' constants, with ones on the diagonal below them."""
        constant = np.zeros((len(self.blocks), self.q, self.q), kind)
        constant[:] = np.eye(self.q)
        for g, b, k in zip(constant, self.blocks, self.sizes):
            g[:k, :k] = b.constant
        return constant

    def before_cancelling(self):
        """How large diagonal entries were if no product cancelled another: (b, q).

        Of what was added up no product is left. What doesn't cancel in its row is
        as large then, or in rows of another unit as large as in a block that is
        positive, where |g_ij|^2 <= g_ii g_jj.
        """
        large = np.abs(self.constant.diagonal(0, 1, 2))
        squares = np.einsum("abij,abij->bij", self.slopes, self.slopes.conj()).real
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
            b.with_constant(constants[k]) for b, k in zip(self.blocks, self.indices)
        ]
        changed.constant = changed._filled(self.constant.dtype)
        return changed

    def joined(self, slopes):
        """The stack with one more scalar variable; ``slopes`` are of all blocks."""
        last = np.zeros_like(self.constant)
        for i, (index, k) in enumerate(zip(self.indices, self.sizes)):
            g = slopes[index]
            last[i, :k, :k] = fold(g) if self.weight == 2 else g
        joined = copy(self)
        joined.slopes = np.concatenate([self.slopes, last[None]])
        return joined


class _Row(_Stack):
    """One block of one entry, with its ``gradient`` by all variables."""

    def __init__(self, owner, index, constant, gradient):
        self.gradient = np.append(gradient, 0.0)
        slopes = self.gradient[owner.scalars].reshape(-1, 1, 1)
        block = StructuredBlock(np.array([[float(constant)]]), [], slopes)
        super().__init__([index], [block])


def _stacks(blocks, variables):
    """Stacks of blocks by kind and rough size; large ones are not padded."""
    blocks = [b.unfolded() if len(b.constant) <= FOLD_ABOVE_ROWS else b for b in blocks]
    groups, steps = {}, PADDED
    small = [len(b.constant) for b in blocks if len(b.constant) <= FEW_ROWS]
    if small:
        spared = len({_padded(q, steps) for q in small}) - 1
        padding = len(small) * max(small) ** 2 - sum(q * q for q in small)
        if padding * variables <= spared * SLOPES_OF_STACK:
            steps = [s for s in PADDED if s >= FEW_ROWS]
    for index, b in enumerate(blocks):
        kind = b.weight, _padded(len(b.constant), steps)
        groups.setdefault(kind, []).append(index)
    return [_Stack(at, [blocks[k] for k in at]) for at in groups.values()]


def _padded(rows, steps):
    return next((s for s in steps if rows <= s), rows)


class _Table:
    """Values from one table of all slopes, which is fast for few variables."""

    def __init__(self, owner):
        self.constant = np.concatenate([real(s.constant) for s in owner.stacks])
        columns, start = [], 0
        self.parts = []  # of a vector of all entries: place, kind and shape
        for s in owner.stacks:
            full = np.zeros((owner.variables, *s.constant.shape), s.constant.dtype)
            full[owner.scalars] = s.slopes
            for i, b in enumerate(s.blocks):
                for t in b.products:
                    layout = owner.layouts[t.unknown]
                    end = layout.start + layout.size
                    _add_slopes(full[layout.start : end, i], layout, t)
            columns.append(full.reshape(owner.variables, -1).view(float))
            place = slice(start, start + columns[-1].shape[1])
            self.parts.append((place, full.dtype, s.constant.shape))
            start = place.stop
        self.table = np.hstack(columns)
        self.weights = None  # all of them one
        if any(s.weight != 1 for s in owner.stacks):
            self.weights = np.concatenate(
                [np.full(c.shape[1], s.weight) for c, s in zip(columns, owner.stacks)]
            )

    def joined(self, owner):
        joined = copy(self)
        blocks = [s for s in owner.stacks if s.gradient is None]
        last = np.concatenate([real(s.slopes[-1]) for s in blocks])
        joined.table = np.vstack([self.table, last])
        for s in owner.stacks[len(blocks) :]:  # a row is one more column
            end = len(joined.constant)
            joined.parts = [*self.parts, (slice(end, end + 1), float, (1, 1, 1))]
            joined.constant = np.append(joined.constant, s.constant)
            if self.weights is not None:
                joined.weights = np.append(joined.weights, 1.0)
            joined.table = np.column_stack([joined.table, s.gradient])
        return joined

    def moved(self, owner):
        """The same slopes with the constants of an ``owner``."""
        moved = copy(self)
        moved.constant = np.concatenate([real(s.constant) for s in owner.stacks])
        return moved

    def diagonal_squares(self):
        """Sums of squares of each diagonal entry's derivatives, by stack."""
        sums = self._split(np.einsum("ak,ak->k", self.table, self.table))
        return [g.real.diagonal(0, 1, 2) for g in sums]

    def at(self, x):
        return self._split(self.constant + x @ self.table)

    def along(self, direction):
        return self._split(direction @ self.table)

    def adjoint(self, Z):
        flat = [real(z) for z in Z]
        flat = flat[0] if len(flat) == 1 else np.concatenate(flat)
        return self.table @ (flat if self.weights is None else self.weights * flat)

    def _split(self, flat):
        """The list of stacks that a vector of all their entries holds."""
        return [flat[at].view(kind).reshape(shape) for at, kind, shape in self.parts]


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
    total[:, cols, rows] += transposed(part)
