"""Blocks that differ in numbers only, and their factors as arrays."""

from dataclasses import dataclass

import numpy as np

from .structure import Product


@dataclass(frozen=True, eq=False)
class Alike:
    """Those of many blocks whose products have the same unknowns and shapes.

    ``indices``, (b,) of int: which blocks; ``products``: those of all b blocks at once.
    The factors are arrays (b, rows, columns); an array (1, rows, columns) is the same
    in all of them.
    """

    indices: np.ndarray
    products: list


def alike(blocks):
    """The `Alike` of some blocks, a list; each block is in one of them.

    ``blocks``: the blocks.
    """
    forms = {}
    for index, b in enumerate(blocks):
        form = tuple(
            (t.unknown, t.left.shape, t.left.dtype, t.right.shape, t.right.dtype)
            for t in b.products
        )
        forms.setdefault(form, []).append(index)
    found = []
    for indices in forms.values():
        products = zip(*(blocks[i].products for i in indices))
        found.append(Alike(np.array(indices), [_together(some) for some in products]))
    return found


def _together(products):
    """Products of the same shapes as one."""
    left, right = (
        _array([getattr(t, side) for t in products]) for side in ("left", "right")
    )
    return Product(products[0].unknown, left, right)


def _array(matrices):
    """Matrices of one shape as an array; of equal ones the first."""
    first = matrices[0]
    if all(m is first for m in matrices):
        return first[None]
    array = np.array(matrices)
    return array[:1] if (array[1:] == first).all() else array


def sliced(indices):
    """A slice of these ``indices`` where no other is between them."""
    if (np.diff(indices) == 1).all():
        return slice(int(indices[0]), int(indices[-1]) + 1)
    return indices
