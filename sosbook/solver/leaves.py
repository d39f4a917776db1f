"""Things that few blocks hold: independent leaves, and a border that they share."""

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components


def leaves(held, count):
    """Leaves of ``count`` things that share no block, for one border after another.

    What shares blocks with many others belongs to the border; how many is too many, the
    caller finds out. ``held``: the indices that each block holds. Yields a (count,)
    array: the leaf of each, 0, 1, ..., or -1 for the border. What no block holds is a
    leaf.

    >>> [leaf.tolist() for leaf in leaves([{0, 1}, {1, 2}, {1, 3}], 5)]
    [[0, -1, 1, 2, 3], [0, 0, 0, 0, 1]]
    """
    pairs = [(k, thing) for k, some in enumerate(held) for thing in some]
    places = np.array(pairs, int).reshape(-1, 2).T
    shape = len(held), count
    holds = csr_array((np.ones(len(pairs)), tuple(places)), shape=shape)
    shared = (holds.T @ holds).tocsr()
    others = np.diff(shared.indptr)
    for most in np.unique(others[others > 0]):
        inner = np.flatnonzero(others <= most)
        leaf = np.full(count, -1)
        leaf[inner] = connected_components(shared[inner][:, inner])[1]
        yield leaf
