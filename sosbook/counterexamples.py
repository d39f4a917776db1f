"""Where checking the vertices isn't enough.

A(a) P E(a)^T is quadratic in the weights a: with an uncertain E the
theorems' LMIs can hold at both vertices while a plant between them is
unstable.
"""

import numpy as np

from .descriptor import Descriptor
from .system import Polytope, SecondOrderSystem

__all__ = ["mechanical", "rotation"]


def rotation():
    """Two first-order descriptor systems E x' = A x, and P = I.

    At both vertices A P E^T + E P A^T = -0.2 I; halfway the eigenvalues
    of E^-1 A are 4.9 +- 5j.

    Returns
    -------
    (Descriptor, Descriptor), (2, 2) array

    Examples
    --------
    >>> (first, second), P = rotation()
    >>> first.A @ P @ first.E.T + first.E @ P @ first.A.T
    array([[-0.2,  0. ],
           [ 0. , -0.2]])
    """
    S = np.array([[0.0, -1.0], [1.0, 0.0]])
    nothing = np.zeros((2, 1))
    first = Descriptor(
        np.eye(2), -0.1 * np.eye(2) + 10 * S, nothing, nothing, np.eye(2)
    )
    second = Descriptor(S, -0.1 * S, nothing, nothing, np.eye(2))
    return (first, second), np.eye(2)


def mechanical():
    """A mechanical polytope with positive definite masses, and its P.

    (2.18) with sigma = 0 and K = 0 holds strictly at both vertices with
    the common P; the plant halfway has a pole near +3.91.

    Returns
    -------
    Polytope, (4, 4) array

    Examples
    --------
    >>> plants, P = mechanical()
    >>> round(float(plants.mean.poles().real.max()), 2)
    3.91
    """
    B = np.zeros((2, 1))
    first = SecondOrderSystem(
        M=np.diag([1.8, 0.2]), D=[[-3.6, 6.4], [-3, 0.7]],
        S=[[-0.2, 2.9], [-2.5, 0.8]], B=B,
    )
    second = SecondOrderSystem(
        M=np.diag([0.2, 1.8]), D=[[0.7, -0.3], [7.9, -0.9]],
        S=[[1, 0], [9.2, 3.9]], B=B,
    )
    P = np.array([
        [0.31, 0.11, -0.27, -0.02],
        [0.11, 1.24, -0.09, -0.44],
        [-0.27, -0.09, 1.02, 0.67],
        [-0.02, -0.44, 0.67, 3.43],
    ])
    return Polytope([first, second]), P
