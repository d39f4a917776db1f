"""Values and gradients of blocks, many blocks in one numpy call.

Parts of one kind and similar size are padded with identities and
stacked. A set of matrices, one for each block, is a list of such stacks.
"""

import numpy as np

from .structure import unfold

__all__ = ["Stacked", "squares", "transposed"]

TABLE = 4e6  # most entries of a table of all slopes


def transposed(stack):
    """The conjugate transposes of a stack of matrices."""
    return stack.conj().swapaxes(-1, -2)


def squares(roots):
    """W = N' N of each N, stack by stack."""
    return [transposed(N) @ N for N in roots]


class Stacked:
    """Blocks as stacks, and their adjoint.

    Parameters
    ----------
    blocks : Blocks
    lift : list of (q, q) arrays, optional
        Slopes of one more variable, the last.

    Attributes
    ----------
    slots : list of Slot
    numbers : (s,) array
        Places of the variables that are numbers.
    stacks : list of Stack
    variables : int
    degree : int
        Sum of the sizes, padding included.
    """

    def __init__(self, blocks, lift=None):
        self.slots, numbers, parts = blocks.structure
        self.variables = blocks.variables
        if lift is not None:
            numbers = np.append(numbers, self.variables)
            self.variables += 1
            parts = [p.joined(slope) for p, slope in zip(parts, lift)]
        self.numbers = numbers
        self.stacks = _stacks(parts)
        self.degree = sum(s.weight * len(s.parts) * s.q for s in self.stacks)
        entries = sum(s.constant.size for s in self.stacks)
        kind = _Table if entries * self.variables <= TABLE else _Sums
        self._values = kind(self)

    def at(self, x):
        """All blocks at x."""
        return self._values.at(x)

    def along(self, direction):
        """What a change of the variables adds to the blocks."""
        return self._values.along(direction)

    def adjoint(self, Z):
        """sum_k <G_ka, Z_k> for each variable a."""
        return self._values.adjoint(Z)

    def inner(self, Y, Z):
        """sum_k <Y_k, Z_k>."""
        return sum(
            s.weight * np.vdot(y, z).real
            for s, y, z in zip(self.stacks, Y, Z)
        )

    def least(self, x):
        """Smallest eigenvalue of each block at x, or 1 if that is less."""
        found = np.ones(sum(len(s.places) for s in self.stacks))
        for s, g in zip(self.stacks, self.at(x)):
            found[s.places] = np.minimum(np.linalg.eigvalsh(g)[:, 0], 1)
        return found

    def unstacked(self, Z):
        """Stacked matrices as a list of the real ones of each block."""
        found = {}
        for s, stack in zip(self.stacks, Z):
            for place, z, k in zip(s.places, stack, s.sizes):
                z = z[:k, :k]
                found[place] = unfold(z) if s.weight == 2 else z
        return [found[place] for place in range(len(found))]


class _Stack:
    """Parts of one kind, padded to one size."""

    def __init__(self, places, parts):
        self.places, self.parts = places, parts
        self.sizes = [len(p.constant) for p in parts]
        self.q = q = max(self.sizes)
        self.weight = parts[0].weight
        kind = complex if self.weight == 2 else float
        self.constant = np.zeros((len(parts), q, q), kind)
        self.constant[:] = np.eye(q)
        numbers = len(parts[0].slopes)
        self.slopes = np.zeros((numbers, len(parts), q, q), kind)
        for i, (p, k) in enumerate(zip(parts, self.sizes)):
            self.constant[i, :k, :k] = p.constant
            self.slopes[:, i, :k, :k] = p.slopes


def _stacks(parts):
    """Parts by kind and rough size; large ones are not padded."""
    groups = {}
    for place, p in enumerate(parts):
        q = len(p.constant)
        room = next((s for s in (4, 8, 12, 20) if q <= s), q)
        groups.setdefault((p.weight, room), []).append(place)
    return [
        _Stack(places, [parts[k] for k in places])
        for places in groups.values()
    ]


def real(z):
    """Complex numbers as pairs of reals, along the last axis."""
    return np.hstack([z.real, z.imag]) if np.iscomplexobj(z) else z


class _Table:
    """By one table of all slopes: fast for few variables."""

    def __init__(self, owner):
        self.stacks = owner.stacks
        self.constant = np.concatenate(
            [real(s.constant.reshape(1, -1))[0] for s in self.stacks])
        columns = []
        for s in self.stacks:
            full = np.zeros(
                (owner.variables, *s.constant.shape), s.constant.dtype)
            for i, (p, k) in enumerate(zip(s.parts, s.sizes)):
                full[owner.numbers, i, :k, :k] = p.slopes
                for t in p.products:
                    slot = owner.slots[t.slot]
                    end = slot.start + slot.size
                    full[slot.start:end, i, :k, :k] += _slopes(slot, t)
            columns.append(real(full.reshape(owner.variables, -1)))
        self.table = np.hstack(columns)
        self.ends = np.cumsum([c.shape[1] for c in columns])[:-1]
        self.weights = np.concatenate([
            np.full(c.shape[1], s.weight)
            for c, s in zip(columns, self.stacks)
        ])

    def at(self, x):
        return self._split(self.constant + x @ self.table)

    def along(self, direction):
        return self._split(direction @ self.table)

    def adjoint(self, Z):
        flat = np.concatenate([real(z.reshape(1, -1))[0] for z in Z])
        return self.table @ (self.weights * flat)

    def _split(self, flat):
        found = []
        for part, s in zip(np.split(flat, self.ends), self.stacks):
            if s.weight == 2:
                half = len(part) // 2
                part = part[:half] + 1j * part[half:]
            found.append(part.reshape(s.constant.shape))
        return found


def _slopes(slot, product):
    """Derivatives of a product and its mirror by the free entries."""
    L, R = product.left, product.right
    full = np.multiply.outer(L, R).transpose(1, 2, 0, 3)
    full = full + transposed(full)
    if not slot.symmetric:
        return full.reshape(-1, *full.shape[2:])
    i, j, off = slot.lower
    return full[i, j] + off[:, None, None] * full[j, i]


class _Sums:
    """Product by product, without their zeros: for many variables."""

    def __init__(self, owner):
        self.owner = owner
        self.rights, known = [], {}
        self.plans = []  # for each part: (slot, left, rows, right, cols)
        for s in owner.stacks:
            for p in s.parts:
                plan = []
                for t in p.products:
                    rows = _span(t.left.any(axis=1))
                    cols = _span(t.right.any(axis=0))
                    right = np.ascontiguousarray(t.right[:, cols])
                    key = t.slot, right.shape, right.tobytes()
                    if key not in known:
                        known[key] = len(self.rights)
                        self.rights.append((t.slot, right))
                    left = np.ascontiguousarray(t.left[rows])
                    plan.append((left, rows, known[key], cols))
                self.plans.append(plan)

    def at(self, x):
        return [
            s.constant + g for s, g in zip(self.owner.stacks, self.along(x))
        ]

    def along(self, direction):
        X = [slot.matrix(direction) for slot in self.owner.slots]
        half = [X[slot] @ right for slot, right in self.rights]
        numbers = direction[self.owner.numbers]
        plans, found = iter(self.plans), []
        for s in self.owner.stacks:
            total = np.zeros_like(s.constant)
            for g, k in zip(total, s.sizes):
                for left, rows, right, cols in next(plans):
                    g[rows, cols] += left @ half[right]
                g += g.conj().T.copy()
            for a, slopes in zip(numbers, s.slopes):
                if a:
                    total += a * slopes
            found.append(total)
        return found

    def adjoint(self, Z):
        half = [0.0] * len(self.rights)
        out = np.zeros(self.owner.variables)
        plans = iter(self.plans)
        for s, stack in zip(self.owner.stacks, Z):
            for z in stack:
                for left, rows, right, cols in next(plans):
                    part = left.conj().T @ z[rows, cols]
                    half[right] = half[right] + 2 * s.weight * part
            for place, slopes in zip(self.owner.numbers, s.slopes):
                out[place] += s.weight * np.vdot(slopes, stack).real
        X = [np.zeros((slot.rows, slot.cols)) for slot in self.owner.slots]
        for (slot, right), part in zip(self.rights, half):
            X[slot] += (part @ right.conj().T).real
        for slot, x in zip(self.owner.slots, X):
            out[slot.start:slot.start + slot.size] = slot.gradient(x)
        return out


def _span(used):
    """The slice from the first to the last entry that is used."""
    places = np.flatnonzero(used)
    return slice(places[0], places[-1] + 1)
