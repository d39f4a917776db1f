"""How long a computation takes, counted from its shapes.

The unit is the second of a typical processor of 2024. Only quotients count:
of several ways to the same numbers the shortest is taken. So nothing depends
on the processor at hand, and a request is solved the same way everywhere.
"""

import numpy as np

__all__ = [
    "arrow_work",
    "dense_work",
    "factor_work",
    "hessian_work",
    "iteration_work",
    "kronecker_work",
    "leaves_work",
    "products_work",
    "sums_work",
    "table_work",
]

FLOPS = 2e10  # additions and multiplications a second, in products of matrices
NUMBERS = 1e9  # floats read or written a second, in large arrays
TABLE = 3e9  # the same in a table that is read again and again
CALL = 0.8e-6  # seconds for each array that numpy makes
ARRAYS_OF_PRODUCT = 4  # its right and left factor, its place, its mirror
ARRAYS_OF_BLOCK = 5
ARRAYS_OF_MODAL = 30  # of one application of the preconditioner
ARRAYS_OF_STACK = 8  # of the Hessian
ARRAYS_OF_KIND = 22  # of the Kronecker products of two kinds of unknowns
ARRAYS_OF_PART = 3  # of those of two unknowns, among others of their kinds
ARRAYS_OF_ARROW = 400  # of the factor of Newton's matrix, and of several solutions
ARRAYS_OF_LEAF = 60  # of each leaf's part in them
PASSES = 6  # over the matrix of a Kronecker product, until it is in its place


def table_work(stacked):
    """Seconds for the values of all blocks from a table of all slopes.

    Parameters
    ----------
    stacked : Stacked
        The blocks.
    """
    return 2 * CALL + _entries(stacked) * stacked.variables / TABLE


def sums_work(stacked):
    """Seconds for the same values, product by product.

    Parameters
    ----------
    stacked : Stacked
        The blocks.
    """
    arrays, flops = 0, 0
    for s in stacked.stacks:
        for b in s.blocks:
            arrays += ARRAYS_OF_BLOCK + ARRAYS_OF_PRODUCT * len(b.products)
            for t in b.products:
                q, rows = t.left.shape
                flops += 2 * q * rows * (len(t.right) + q) * s.weight
        arrays += len(s.slopes)
    return arrays * CALL + flops / FLOPS


def iteration_work(stacked):
    """Seconds for one iteration of conjugate gradients.

    It takes the blocks along a direction, the metric on both of their
    sides, the adjoint, and the preconditioner.

    Parameters
    ----------
    stacked : Stacked
        The blocks.
    """
    return 2 * sums_work(stacked) + ARRAYS_OF_MODAL * CALL + products_work(stacked)


def products_work(stacked):
    """Seconds for the products of large matrices in one iteration.

    Parameters
    ----------
    stacked : Stacked
        The blocks.
    """
    metric = sum(4 * s.weight**2 * s.q**3 * len(s.blocks) for s in stacked.stacks)
    modal = sum(8 * max(u.rows, u.cols) ** 3 for u in stacked.layouts)
    return (metric + modal) / FLOPS


def hessian_work(stacked):
    """Seconds for the matrix of all variables, and its factor.

    Parameters
    ----------
    stacked : Stacked
        The blocks.
    """
    return _parts_work(stacked) + factor_work(stacked)


def factor_work(stacked):
    """Seconds for the factor of that matrix, and for writing it.

    Parameters
    ----------
    stacked : Stacked
        The blocks.
    """
    k = stacked.variables
    return k**3 / 3 / FLOPS + PASSES * k**2 / NUMBERS


def leaves_work(count):
    """Seconds for the calls that so many leaves of an `Arrow` take.

    Parameters
    ----------
    count : int
        How many leaves.
    """
    return (ARRAYS_OF_ARROW + ARRAYS_OF_LEAF * count) * CALL


def dense_work(stacked):
    """Seconds for the same, with the products that make the matrix.

    Parameters
    ----------
    stacked : Stacked
        The blocks.
    """
    return kronecker_work(stacked) + stacked.variables**3 / 3 / FLOPS


def arrow_work(stacked, arrow):
    """Seconds for the same as an `ArrowMatrix`, and a few solutions.

    Parameters
    ----------
    stacked : Stacked
        The blocks.
    arrow : Arrow
        Which variables belong to leaves and which to the border.
    """
    inner, border = len(arrow.inner), len(arrow.border)
    flops = sum(s**3 / 3 + s * s * border for s in arrow.sizes)
    flops += inner * border**2 + border**3 / 3
    less = stacked.variables**2 - arrow.entries
    seconds = kronecker_work(stacked) + leaves_work(len(arrow.sizes)) + flops / FLOPS
    return seconds - PASSES * less / NUMBERS


def kronecker_work(stacked):
    """Seconds for the same matrix as sums of Kronecker products.

    Parameters
    ----------
    stacked : Stacked
        The blocks.
    """
    shapes = [(u.rows, u.cols, u.symmetric) for u in stacked.layouts]
    parts = np.argwhere(np.triu(_terms(stacked)))
    kinds = {frozenset((shapes[u], shapes[v])) for u, v in parts}
    arrays = ARRAYS_OF_STACK * len(stacked.stacks) + ARRAYS_OF_PART * len(parts)
    arrays += ARRAYS_OF_KIND * len(kinds)
    passes = PASSES * stacked.variables**2 / NUMBERS
    return arrays * CALL + _parts_work(stacked) + passes


def _terms(stacked):
    """How many Kronecker products make the part of each two unknowns."""
    unknowns = len(stacked.layouts)
    blocks = [(b.products, s.weight) for s in stacked.stacks for b in s.blocks]
    held = [k * unknowns + t.unknown for k, (p, _) in enumerate(blocks) for t in p]
    counts = np.bincount(np.array(held, int), minlength=len(blocks) * unknowns)
    counts = counts.reshape(len(blocks), unknowns)
    return counts.T @ (2.0 * np.array([w for _, w in blocks])[:, None] * counts)


def _parts_work(stacked):
    """Seconds for the parts of all two unknowns, as sums of Kronecker products."""
    terms = np.triu(_terms(stacked))
    sizes = np.array([u.rows * u.cols for u in stacked.layouts], float)
    seconds = 2 * terms / FLOPS + PASSES / NUMBERS * (terms > 0)
    return float(sizes @ seconds @ sizes)


def _entries(stacked):
    return sum(s.weight * s.constant.size for s in stacked.stacks)
