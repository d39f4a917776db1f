"""Blocks G_k(x) > 0 that are affine in a vector of variables."""

from functools import cached_property

import numpy as np

from .newton import newton_of
from .settings import DEFAULTS
from .structure import structure


class Blocks:
    """Symmetric blocks G_k(x) = G_k0 + sum_a x_a G_ka, of `Affine` ``expressions``.

    The variables are the free entries of the ``unknowns``, one after the other;
    ``constants``: the G_k0, (q, q) arrays; ``settings``: how they are solved.
    """

    settings = DEFAULTS

    def __init__(self, expressions, unknowns):
        self.expressions, self.unknowns = list(expressions), list(unknowns)
        self.constants = [g.constant for g in self.expressions]
        self.variables = sum(u.size for u in self.unknowns)

    @classmethod
    def compiled(cls, expressions, blocks, unknowns):
        """``expressions`` in ``unknowns`` whose structures, ``blocks``, are known."""
        self = cls(expressions, unknowns)
        layouts, scalars, _ = structure([], self.unknowns)
        self.structure = layouts, scalars, list(blocks)
        return self

    def joined(self, write):
        """These blocks and more, which ``write`` makes of a list of values."""
        more = Blocks(write(self.unknowns), self.unknowns)
        joined = Blocks.compiled(
            [*self.expressions, *more.expressions],
            [*self.structure[2], *more.structure[2]],
            self.unknowns,
        )
        joined.settings = self.settings
        return joined

    @cached_property
    def slopes(self):
        """Derivatives of each block: a list of (k, q, q) arrays."""
        slopes = []
        for g in self.expressions:
            parts = (x for t in g.terms for x in (t.left, t.right))
            kind = np.result_type(g.constant, *parts)  # exact ones stay exact
            slopes.append(np.zeros((self.variables, *g.constant.shape), kind))
            held, start = {t.unknown for t in g.terms}, 0
            for u in self.unknowns:
                if u in held:
                    slopes[-1][start : start + u.size] = g.jacobian(u)
                start += u.size
        return slopes

    @cached_property
    def structure(self):
        """Layouts, indices of the scalars, blocks: see `structure`."""
        return structure(self.expressions, self.unknowns)

    def adjoint(self, Z):
        """sum_k <G_ka, Z_k> for each variable a, of symmetric Z: a (k,) array."""
        gradients = {u: np.zeros(u.shape) for u in self.unknowns}
        for g, z in zip(self.expressions, Z):
            for t in g.terms:
                if t.unknown in gradients:
                    left, right = t.left.astype(float), t.right.astype(float)
                    of_X = left.T @ z @ right.T
                    gradients[t.unknown] += of_X.T if t.transposed else of_X
        return np.concatenate(
            [
                u.pack(X + np.tril(X.T, -1) if u.symmetric else X)
                for u, X in gradients.items()
            ]
        )

    def with_constants(self, constants):
        """Blocks with the same slopes and these constants."""
        changed = object.__new__(type(self))
        changed.__dict__.update(self.__dict__, constants=list(constants))
        layouts, scalars, blocks = self.structure
        vars(changed).pop("diagonal_scales", None)
        if "newton" in vars(self):
            changed.newton = self.newton.with_constants(changed.constants)
        changed.structure = (
            layouts,
            scalars,
            [b.with_constant(c) for b, c in zip(blocks, constants)],
        )
        return changed

    @cached_property
    def diagonal_scales(self):
        """Powers of two d for each block with d_i d_j G_ij near one; none rounds."""
        magnitudes = newton_of(self).diagonal_magnitudes()
        ends = np.cumsum([len(m) for m in magnitudes])
        flat = np.concatenate(magnitudes)
        flat[flat == 0] = 1
        flat = 2.0 ** np.round(-np.log2(flat) / 2)
        return [flat[end - len(m) : end] for end, m in zip(ends, magnitudes)]

    @property
    def degree(self):
        """Sum of the block sizes: the parameter nu of the barrier -log det."""
        return sum(len(c) for c in self.constants)

    def __call__(self, x):
        return [c + np.tensordot(x, s, 1) for c, s in zip(self.constants, self.slopes)]

    def contain(self, x):
        """Whether all blocks are positive definite at a (k,) array x."""
        return all(np.linalg.eigvalsh(g)[0] > 0 for g in self(x))

    def value(self, Z):
        """The number sum_k <G_k0, Z_k> for a list Z of one matrix a block."""
        return sum((c * z).sum() for c, z in zip(self.constants, Z))
