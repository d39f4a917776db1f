"""Values and adjoints of blocks, product by product, for many variables.

In L X R the product X R is computed once for each X and R. What remains of the
left factors are combinations of few: those of a half-plane, a sector and a disk
are all made of A and E. So each right factor has one tall matrix, a basis of
the pieces of its left factors, and a block adds multiples of its rows.
"""

from copy import copy

import numpy as np
from scipy.linalg import qr, solve_triangular

__all__ = ["Sums", "single", "span"]

ROUNDING = 1e-14  # relative, of a left factor that is a combination of others
LARGEST_WEIGHT = 100.0  # of such a combination; larger ones lose digits
MOST_SHARED = 64  # left factors of one right factor, among which to look


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
        self.rights, pieces = [], []
        places, self.plans = {}, []  # of each block: (rows, columns, sum of pieces)
        for b in (b for s in owner.stacks if s.gradient is None for b in s.blocks):
            plan = []
            for t in b.products:
                cols = span(t.right.any(axis=0))
                right = np.ascontiguousarray(t.right[:, cols])
                key = t.unknown, right.shape, (right.round(14) + 0.0).tobytes()
                if key not in places:
                    places[key] = len(self.rights)
                    self.rights.append((t.unknown, right))
                    pieces.append([])
                here = places[key]
                for rows in _rows(t.left, max(t.left.shape[1], len(t.right))):
                    plan.append((rows, cols, here, len(pieces[here])))
                    pieces[here].append(t.left[rows])
            self.plans.append(plan)
        found = [_shared(some) for some in pieces]
        self.lefts = [tall for tall, _ in found]
        self.plans = [
            [(rows, cols, here, found[here][1][k]) for rows, cols, here, k in plan]
            for plan in self.plans
        ]

    def _belong(self, owner):
        self.owner, self.scalars = owner, owner.scalars
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
        for s in self.owner.stacks:
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
        return twin

    def at(self, x):
        """The blocks at a (k,) array x."""
        return [c + g for c, g in zip(self.constants, self.along(x))]

    def along(self, direction):
        """The change of the blocks along a ``direction``."""
        direction = direction.astype(self.kind, copy=False)
        X = [layout.matrix(direction) for layout in self.layouts]
        products = [
            tall @ (X[unknown] @ right)
            for tall, (unknown, right) in zip(self.lefts, self.rights)
        ]
        scalars = direction[self.scalars]
        plans, changes = iter(self.plans), []
        parts = zip(self.constants, self.slopes, self.gradients)
        for constant, slopes, gradient in parts:
            if gradient is not None:
                changes.append(np.full_like(constant, gradient @ direction))
                continue
            total = np.zeros_like(constant)
            for g in total:
                for rows, cols, here, combination in next(plans):
                    for weight, part in combination:
                        g[rows, cols] += weight * products[here][part]
                g += g.conj().T.copy()
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
        out, row = np.zeros((2, self.owner.variables))
        plans = iter(self.plans)
        for s, stack, slopes in zip(self.owner.stacks, Z, self.slopes):
            if s.gradient is not None:
                row += stack.item() * s.gradient
                continue
            for z in stack:
                for rows, cols, here, combination in next(plans):
                    total, here_z = gathered[here], z[rows, cols]
                    for weight, part in combination:
                        term = (2 * s.weight * weight.conjugate()) * here_z
                        total[part] += term if total.dtype == complex else term.real
            for index, slope in zip(self.scalars, slopes):
                out[index] += s.weight * np.vdot(slope, stack).real
        X = [np.zeros((layout.rows, layout.cols)) for layout in self.layouts]
        for tall, (unknown, right), total in zip(self.lefts, self.rights, gathered):
            X[unknown] += ((tall.T @ total) @ right.conj().T).real
        for layout, x in zip(self.layouts, X):
            out[layout.start : layout.start + layout.size] = layout.gradient(x)
        return out + row


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
    if count == 1 or count > MOST_SHARED:
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
