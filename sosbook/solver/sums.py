"""Values and adjoints of blocks, product by product, for many variables.

In L X R the product X R is computed once for each X and R. What remains of the
left factors are combinations of few: those of a half-plane, a sector and a disk
are all made of A and E. So each right factor has one tall matrix, a basis of the
pieces of its left factors, and blocks add multiples of its rows. Many blocks of one
form, such as those of all vertices, need no basis: their left factors are one array.
"""

from copy import copy
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import qr, solve_triangular

__all__ = ["Sums", "single", "sliced", "span"]

ROUNDING = 1e-14  # relative, of a left factor that is a combination of others
LARGEST_WEIGHT = 100.0  # of such a combination; larger ones lose digits
MOST_OPERATIONS = 2e8  # that may be spent on looking for a basis: a tenth of a second
MANY = 0.25  # blocks of one form for each row of an unknown


class Sums:
    """Values of blocks at points and along directions, and their adjoint.

    Parameters
    ----------
    owner : Stacked
        The blocks.
    """

    def __init__(self, owner):
        self.kind, self.layouts = float, owner.layouts
        self._belong(owner)
        self.rights, self.parts, pieces = [], [], []
        places, plans = {}, []  # of each stack: (block, place, right, piece)
        for stack in (s for s in owner.stacks if s.gradient is None):
            few, many = [], []
            for some in stack.alike:
                if _are_many(some):
                    many += [_Many.of(some.indices, t) for t in some.products]
                else:
                    few += some.indices.tolist()
            self.parts.append(many)
            plans.append([])
            for i in sorted(few):
                for t in stack.blocks[i].products:
                    cols = span(t.right.any(axis=0))
                    right = np.ascontiguousarray(t.right[:, cols])
                    key = t.unknown, right.shape, (right.round(14) + 0.0).tobytes()
                    if key not in places:
                        places[key] = len(self.rights)
                        self.rights.append((t.unknown, right))
                        pieces.append([])
                    here = places[key]
                    for rows in _rows(t.left, max(t.left.shape[1], len(t.right))):
                        plans[-1].append((i, (rows, cols), here, len(pieces[here])))
                        pieces[here].append(t.left[rows])
        self.plain = [_is_one(right) for _, right in self.rights]
        found = [_shared(some) for some in pieces]
        self.lefts = [tall for tall, _ in found]
        for parts, plan in zip(self.parts, plans):
            parts += [
                _Alone(i, place, here, found[here][1][k]) for i, place, here, k in plan
            ]

    def _belong(self, owner):
        self.stacks, self.scalars = owner.stacks, owner.scalars
        self.variables = owner.variables
        self.constants = [s.constant for s in owner.stacks]
        self.slopes = [s.slopes for s in owner.stacks]
        self.gradients = [s.gradient for s in owner.stacks]

    def joined(self, owner):
        """The same with one more scalar variable, which the ``owner`` has."""
        return self.moved(owner)

    def moved(self, owner):
        """The same slopes with the constants of an ``owner``."""
        moved = copy(self)
        moved._belong(owner)
        return moved

    def diagonal_squares(self):
        """Sums of squares of each diagonal entry's derivatives, by stack."""
        sums = []
        for s in self.stacks:
            squares = (s.slopes.diagonal(0, 2, 3).real ** 2).sum(0)
            for e, b, k in zip(squares, s.blocks, s.sizes):
                e[:k] += b.diagonal_squares(self.layouts)
            sums.append(squares)
        return sums

    def in_single(self):
        """The same in single precision, for directions."""
        twin = copy(self)
        twin.kind = np.float32
        twin.lefts = [tall.astype(np.float32) for tall in self.lefts]
        twin.rights = [(u, single(right)) for u, right in self.rights]
        twin.slopes = [single(slopes) for slopes in self.slopes]
        twin.constants = [single(constant) for constant in self.constants]
        twin.parts = [[part.in_single() for part in parts] for parts in self.parts]
        return twin

    def at(self, x):
        """The blocks at a (k,) array x."""
        return [c + g for c, g in zip(self.constants, self.along(x))]

    def along(self, direction):
        """The change of the blocks along a ``direction``."""
        direction = direction.astype(self.kind, copy=False)
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
            for part in next(of_stacks):
                part.add(total, X, products)
            total += total.conj().swapaxes(1, 2)
            for a, slope in zip(scalars, slopes):
                if a:
                    total += float(a) * slope
            changes.append(total)
        return changes

    def adjoint(self, Z):
        """sum_k <G_ka, Z_k> for each variable a, for a list of stacks Z.

        It is added up in double precision.
        """
        gathered = [
            np.zeros((len(tall), right.shape[1]), right.dtype)
            for tall, (_, right) in zip(self.lefts, self.rights)
        ]
        X = [np.zeros((layout.rows, layout.cols)) for layout in self.layouts]
        out, row = np.zeros((2, self.variables))
        of_stacks = iter(self.parts)
        for s, stack, slopes in zip(self.stacks, Z, self.slopes):
            if s.gradient is not None:
                row += stack.item() * s.gradient
                continue
            for part in next(of_stacks):
                part.gather(X, gathered, stack, 2 * s.weight)
            for index, slope in zip(self.scalars, slopes):
                out[index] += s.weight * np.vdot(slope, stack).real
        of_rights = zip(self.lefts, self.rights, self.plain, gathered)
        for tall, (unknown, right), plain, total in of_rights:
            total = tall.T @ total
            X[unknown] += total if plain else (total @ right.conj().T).real
        for layout, x in zip(self.layouts, X):
            out[layout.start : layout.start + layout.size] = layout.gradient(x)
        return out + row


@dataclass(frozen=True, eq=False)
class _Alone:
    """What one block of a stack adds at one place: multiples of rows of a product.

    Parameters
    ----------
    block : int
    place : (slice, slice)
        The rows and columns.
    right : int
        Whose product: an index of the right factors.
    terms : list of (float or complex, slice)
        How often it takes which rows.
    """

    block: int
    place: tuple
    right: int
    terms: list

    def add(self, total, X, products):
        """Add this to a stack's ``total``; ``X`` are the unknowns."""
        g, product = total[self.block][self.place], products[self.right]
        for weight, rows in self.terms:
            g += weight * product[rows]

    def gather(self, X, products, stack, factor):
        """Add the adjoint, ``factor`` times, to the ``products``' or the unknowns'."""
        z, total = stack[self.block][self.place], products[self.right]
        for weight, rows in self.terms:
            term = (factor * weight.conjugate()) * z
            total[rows] += term if total.dtype == complex else term.real

    def in_single(self):
        return self


@dataclass(frozen=True, eq=False)
class _Many:
    """A product in many blocks, one array for all of their left factors.

    Parameters
    ----------
    blocks : slice or (b,) array of int
    place : (slice, slice)
        The rows and columns.
    unknown : int
        Index of X among the unknown matrices.
    left, right : array
        The factors, see `Alike`.
    """

    blocks: slice | np.ndarray
    place: tuple
    unknown: int
    left: np.ndarray
    right: np.ndarray

    @classmethod
    def of(cls, blocks, product):
        """The same of a `Product` of some ``blocks``, without rows of zeros."""
        rows = span(product.left.any(axis=(0, 2)))
        cols = span(product.right.any(axis=(0, 1)))
        left = np.ascontiguousarray(product.left[:, rows])
        if len(left) == 1:
            left = np.repeat(left, len(blocks), axis=0)
        right = np.ascontiguousarray(product.right[..., cols])
        return cls(sliced(blocks), (rows, cols), product.unknown, left, right)

    def add(self, total, X, products):
        right = X[self.unknown] @ self.right
        if len(right) == 1:  # one product of two matrices
            b, h, r = self.left.shape
            added = (self.left.reshape(-1, r) @ right[0]).reshape(b, h, -1)
        else:
            added = self.left @ right
        total[self.blocks, *self.place] += added

    def gather(self, X, products, stack, factor):
        z, right = stack[self.blocks, *self.place], self.right.conj().mT
        if len(right) == 1:
            left = self.left.reshape(-1, self.left.shape[-1]).conj().T
            term = left @ z.reshape(left.shape[1], -1) @ right[0]
        else:
            term = (self.left.conj().mT @ z @ right).sum(axis=0)
        X[self.unknown] += factor * term.real

    def in_single(self):
        return replace(self, left=single(self.left), right=single(self.right))


def _are_many(some):
    """Whether the calls for so many blocks, `Alike`, take longer than their work."""
    rows = max((t.left.shape[-1] for t in some.products), default=0)
    return len(some.indices) >= max(MANY * rows, 2)


def sliced(indices):
    """A slice of these indices where no other is between them."""
    if (np.diff(indices) == 1).all():
        return slice(int(indices[0]), int(indices[-1]) + 1)
    return indices


def _rows(left, height):
    """The rows of a left factor that aren't zero, in pieces of a height."""
    used = span(left.any(axis=1))
    for start in range(used.start // height * height, used.stop, height):
        piece = left[start : start + height].any(axis=1)
        if piece.any():
            rows = span(piece)
            yield slice(start + rows.start, start + rows.stop)


def _shared(pieces):
    """A tall real matrix, and for each piece its (weight, rows) there.

    The weight is complex where the piece is.
    """
    parts = []  # real and imaginary ones: (piece, factor, matrix)
    for k, piece in enumerate(pieces):
        parts.append((k, 1.0, piece.real))
        if np.iscomplexobj(piece):
            parts.append((k, 1j, piece.imag))
    parts = [(k, factor, m) for k, factor, m in parts if m.any()]
    tall, combinations, top = [], [[] for _ in pieces], 0
    for shape in dict.fromkeys(m.shape for *_, m in parts):
        alike = [p for p in parts if p[2].shape == shape]
        basis, weights = _basis([m for *_, m in alike])
        for (k, factor, _), row in zip(alike, weights):
            for b in np.flatnonzero(row):
                start = top + b * shape[0]
                part = slice(start, start + shape[0])
                combinations[k].append((factor * row[b], part))
        tall += basis
        top += len(basis) * shape[0]
    return np.ascontiguousarray(np.vstack(tall)), [_merged(c) for c in combinations]


def _basis(matrices):
    """Some of the matrices, and the weights that make all of them, by rows."""
    count = len(matrices)
    norms = np.array([np.linalg.norm(m) for m in matrices])
    flat = np.array([m.ravel() for m in matrices]).T / norms
    if count == 1 or flat.size * min(flat.shape) > MOST_OPERATIONS:
        return matrices, np.eye(count)
    R, order = qr(flat, mode="r", pivoting=True)
    rank = int((abs(np.diag(R)) > ROUNDING).sum())
    chosen, rest = list(order[:rank]), order[rank:]
    weights = np.zeros((count, count))
    weights[chosen, range(rank)] = 1.0
    rows = solve_triangular(R[:rank, :rank], R[:rank, rank:]).T
    for k, row in zip(rest, np.where(abs(rows) > ROUNDING, rows, 0.0)):
        if abs(row).max() > LARGEST_WEIGHT:
            weights[k, len(chosen)] = 1.0
            chosen.append(k)
        else:
            weights[k, :rank] = row * norms[k] / norms[chosen[:rank]]
    return [matrices[k] for k in chosen], weights[:, : len(chosen)]


def _is_one(right):
    """Whether a right factor is I."""
    return np.array_equal(right, np.eye(len(right)))


def _merged(combination):
    """(weight, rows) with one entry for each rows, and weights of Python's."""
    total = {}
    for weight, part in combination:
        ends = part.start, part.stop
        total[ends] = total.get(ends, 0.0) + weight
    return [
        (complex(w) if np.imag(w) else float(np.real(w)), slice(*ends))
        for ends, w in total.items()
    ]


def single(array):
    """An array in single precision."""
    return array.astype(np.complex64 if np.iscomplexobj(array) else np.float32)


def span(used):
    """The slice from the first to the last entry that is used."""
    indices = np.flatnonzero(used)
    return slice(indices[0], indices[-1] + 1)
