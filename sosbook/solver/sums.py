"""Values and adjoints of blocks, product by product, for many variables.

In L X R the product X R is computed once for each X and R. The left factors that go
with it are the rows of one tall matrix, and blocks add parts of the product.
"""

from copy import copy
from dataclasses import dataclass

import numpy as np


class Sums:
    """Values of an ``owner``'s blocks, their changes, and their adjoint."""

    def __init__(self, owner):
        """Collect the products that share an unknown and a right factor."""
        self.layouts = owner.layouts
        self._belong(owner)
        self.rights, lefts, heights = [], [], []
        places, self.parts = {}, []
        for stack in (s for s in owner.stacks if s.gradient is None):
            self.parts.append([])
            for i, b in enumerate(stack.blocks):
                for t in b.products:
                    cols = span(t.right.any(axis=0))
                    right = np.ascontiguousarray(t.right[:, cols])
                    key = t.unknown, right.shape, (right.round(14) + 0.0).tobytes()
                    if key not in places:
                        places[key] = len(self.rights)
                        self.rights.append((t.unknown, right))
                        lefts.append([])
                        heights.append(0)
                    here, rows = places[key], span(t.left.any(axis=1))
                    lefts[here].append(t.left[rows])
                    begin = heights[here]
                    heights[here] += rows.stop - rows.start
                    product = slice(begin, heights[here])
                    self.parts[-1].append(_Piece(i, (rows, cols), here, product))
        self.plain = [_is_one(right) for _, right in self.rights]
        self.lefts = [np.ascontiguousarray(np.vstack(some)) for some in lefts]

    def _belong(self, owner):
        self.stacks, self.scalars = owner.stacks, owner.scalars
        self.variables = owner.variables
        self.constants = [s.constant for s in owner.stacks]
        self.slopes = [s.slopes for s in owner.stacks]
        self.gradients = [s.gradient for s in owner.stacks]

    def moved(self, owner):
        """The same slopes with the constants, or one more scalar, of an ``owner``."""
        moved = copy(self)
        moved._belong(owner)
        return moved

    joined = moved

    def diagonal_squares(self):
        """Sums of squares of each diagonal entry's derivatives, by stack."""
        sums = []
        for s in self.stacks:
            squares = (s.slopes.diagonal(0, 2, 3) ** 2).sum(0)
            for e, b, k in zip(squares, s.blocks, s.sizes):
                e[:k] += b.diagonal_squares(self.layouts)
            sums.append(squares)
        return sums

    def at(self, x):
        """The blocks at a (k,) array x."""
        return [c + g for c, g in zip(self.constants, self.along(x))]

    def along(self, direction):
        """The change of the blocks along a ``direction``."""
        X = [layout.matrix(direction) for layout in self.layouts]
        products = [
            tall @ (X[unknown] if plain else X[unknown] @ right)
            for tall, (unknown, right), plain in zip(
                self.lefts, self.rights, self.plain
            )
        ]
        scalars = direction[self.scalars]
        of_stacks, changes = iter(self.parts), []
        stacks = zip(self.constants, self.slopes, self.gradients)
        for constant, slopes, gradient in stacks:
            if gradient is not None:
                changes.append(np.full_like(constant, gradient @ direction))
                continue
            total = np.zeros_like(constant)
            for piece in next(of_stacks):
                piece.add(total, products)
            total += total.mT
            for a, slope in zip(scalars, slopes):
                if a:
                    total += float(a) * slope
            changes.append(total)
        return changes

    def adjoint(self, Z):
        """sum_k <G_ka, Z_k> for each variable a, for a list of stacks Z."""
        gathered = [
            np.zeros((len(tall), right.shape[1]))
            for tall, (_, right) in zip(self.lefts, self.rights)
        ]
        X = [np.zeros((layout.rows, layout.cols)) for layout in self.layouts]
        out, row = np.zeros((2, self.variables))
        of_stacks = iter(self.parts)
        for s, stack, slopes in zip(self.stacks, Z, self.slopes):
            if s.gradient is not None:
                row += stack.item() * s.gradient
                continue
            twice = 2 * stack
            for piece in next(of_stacks):
                piece.gather(gathered, twice)
            for index, slope in zip(self.scalars, slopes):
                out[index] += np.vdot(slope, stack)
        of_rights = zip(self.lefts, self.rights, self.plain, gathered)
        for tall, (unknown, right), plain, total in of_rights:
            total = tall.T @ total
            X[unknown] += total if plain else total @ right.T
        for layout, x in zip(self.layouts, X):
            out[layout.start : layout.start + layout.size] = layout.gradient(x)
        return out + row


@dataclass(frozen=True, eq=False)
class _Piece:
    """The part of a stack's ``block`` at a ``place``: ``rows`` of product ``right``."""

    block: int
    place: tuple
    right: int
    rows: slice

    def add(self, total, products):
        """Add this to a stack's ``total``."""
        g = total[self.block][self.place]
        g += products[self.right][self.rows]

    def gather(self, products, stack):
        """Add the adjoint to the ``products``'."""
        products[self.right][self.rows] += stack[self.block][self.place]


def _is_one(right):
    """True if a right factor is I."""
    return np.array_equal(right, np.eye(len(right)))


def span(used):
    """The slice from the first to the last entry that is used."""
    indices = np.flatnonzero(used)
    return slice(indices[0], indices[-1] + 1)
