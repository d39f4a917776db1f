"""Blocks G_k(x) > 0 that are affine in a vector of variables."""

from functools import cached_property

import numpy as np

from .structure import Part, structure

__all__ = ["Blocks"]


class Blocks:
    """Affine symmetric blocks G_k(x) = G_k0 + sum_a x_a G_ka.

    Parameters
    ----------
    constants : list of (q, q) arrays
    slopes : list of (k, q, q) arrays
        One slice for each of the k variables.
    """

    def __init__(self, constants, slopes):
        self.constants = list(constants)
        self.slopes = list(slopes)
        self.variables = len(self.slopes[0])

    @classmethod
    def of(cls, expressions, unknowns):
        """From `Affine` expressions in the given unknowns.

        These remember their structure; the slopes are made when asked.
        """
        self = object.__new__(cls)
        self.expressions, self.unknowns = list(expressions), list(unknowns)
        self.constants = [g.constant for g in self.expressions]
        self.variables = sum(u.size for u in unknowns)
        return self

    @cached_property
    def slopes(self):
        return [
            np.concatenate([g.jacobian(u) for u in self.unknowns])
            for g in self.expressions
        ]

    @cached_property
    def structure(self):
        """Slots, places of the numbers, parts: see `structure`."""
        if "slopes" in self.__dict__ and not hasattr(self, "unknowns"):
            return [], np.arange(self.variables), [
                Part(c.astype(float), [], s.astype(float))
                for c, s in zip(self.constants, self.slopes)
            ]
        return structure(self.expressions, self.unknowns)

    def with_constants(self, constants):
        """The same slopes with other constants."""
        other = object.__new__(Blocks)
        other.__dict__.update(self.__dict__, constants=list(constants))
        slots, numbers, parts = self.structure
        vars(other).pop("newton", None)
        other.structure = slots, numbers, [
            p.with_constant(c) for p, c in zip(parts, constants)]
        return other

    def only(self, places):
        """Some of the blocks."""
        other = object.__new__(Blocks)
        other.unknowns, other.variables = self.unknowns, self.variables
        other.expressions = [self.expressions[k] for k in places]
        other.constants = [self.constants[k] for k in places]
        slots, numbers, parts = self.structure
        other.structure = slots, numbers, [parts[k] for k in places]
        return other

    @cached_property
    def sizes(self):
        """Factors d of each block for which d_i d_j G_ij is near one.

        Powers of two.
        """
        slots, _, parts = self.structure
        found = []
        for p in parts:
            size = p.sizes(slots)
            size[size == 0] = 1
            found.append(2.0 ** np.round(-np.log2(size) / 2))
        return found

    @property
    def degree(self):
        """Sum of the block sizes, the barrier's parameter."""
        return sum(len(c) for c in self.constants)

    def __call__(self, x):
        return [
            c + np.tensordot(x, s, 1)
            for c, s in zip(self.constants, self.slopes)
        ]

    def contain(self, x):
        """Whether all blocks are positive definite at x."""
        return all(np.linalg.eigvalsh(g)[0] > 0 for g in self(x))

    def adjoint(self, Z):
        """sum_k <G_ka, Z_k> for each variable a."""
        return sum(
            np.tensordot(s, z, 2) for s, z in zip(self.slopes, Z)
        )

    def value(self, Z):
        """sum_k <G_k0, Z_k>."""
        return sum((c * z).sum() for c, z in zip(self.constants, Z))
