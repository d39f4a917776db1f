"""Congruent blocks, whose products take one factor less.

In well conditioned coordinates a plant's E is I but for a few digits, so that
each product A P E' multiplies P with what is almost I. For blocks G = B* K B

    <G_a, W G_b W> = <K_a, V K_b V>,   V = B W B*,

and with E' on the diagonal of B the products of K are inv(E) A P alone.
"""

from copy import copy
from dataclasses import replace

import numpy as np

from .alike import alike
from .structure import Product
from .sums import Sums, single, span

__all__ = ["Congruence"]

NEAR_ONE = 0.1  # the largest entry of R - I, for right factors R that are taken out
DIGITS = 12  # of what is left of a right factor


class Congruence:
    """Congruent blocks in single precision, and their metric.

    Parameters
    ----------
    stacked : Stacked
        The blocks G.

    Attributes
    ----------
    sums : Sums
        The changes of K along directions, and their adjoint.
    """

    def __init__(self, stacked):
        owner, self._factors = copy(stacked), []
        owner.stacks = []
        for s in stacked.stacks:
            factors, changed = [_near_one(b) for b in s.blocks], copy(s)
            inverse = [[(at, np.linalg.inv(R).T) for at, R in f] for f in factors]
            changed.blocks = [_congruent(*of) for of in zip(s.blocks, inverse)]
            changed.alike = alike(changed.blocks)
            changed.slopes = s.slopes.copy()
            for i, f in enumerate(inverse):
                _put_around(changed.slopes[:, i], f)
            owner.stacks.append(changed)
            self._factors.append([[(at, single(R)) for at, R in f] for f in factors])
        self.sums = Sums(owner).in_single()

    def metric(self, W):
        """V in single precision, for a list of stacks W."""
        V = [single(w) for w in W]
        for stack, factors in zip(V, self._factors):
            for v, f in zip(stack, factors):
                _put_around(v, f)
        return V


def _near_one(block):
    """(place, R) of the right factors of a block that are nearly I, on its diagonal."""
    found = {}
    for t in block.products:
        at = span(t.right.any(axis=0))
        R = t.right[:, at]
        if R.dtype == float and R.shape[0] == R.shape[1]:
            free = all(
                at.stop <= a.start or a.stop <= at.start for a, _ in found.values()
            )
            away = np.abs(R - np.eye(len(R))).max()
            if free and 0 < away < NEAR_ONE:
                found[at.start] = at, R
    return list(found.values())


def _congruent(block, factors):
    """The block's products with B of ``factors`` taken out; its constant stays."""
    products = []
    for t in block.products:
        left, right = t.left.copy(), t.right.copy()
        for at, C in factors:
            left[at] = C @ left[at]
            right[:, at] = (right[:, at] @ C.T).round(DIGITS)
        products.append(Product(t.unknown, left, right))
    return replace(block, products=products)


def _put_around(matrices, factors):
    """Make B M B* of an array M of matrices, in its place."""
    for at, R in factors:
        matrices[..., at, :] = R @ matrices[..., at, :]
    for at, R in factors:
        matrices[..., at] = matrices[..., at] @ R.T
