"""Sparse matrices, told from others without loading the library that makes them."""

import sys


def issparse(x):
    """True if ``x`` is a sparse matrix or array of SciPy.

    >>> issparse([[1, 0], [0, 1]])
    False
    >>> from scipy.sparse import csc_array
    >>> issparse(csc_array([[1, 0], [0, 1]]))
    True
    """
    maker = sys.modules.get("scipy.sparse")  # nobody has one before it is imported
    return maker is not None and maker.issparse(x)
