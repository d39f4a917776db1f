"""The loop with an observer, in the error of the estimate and the state."""

import numpy as np
from numpy.typing import ArrayLike

from ..lmi import block
from ..plants.checks import matrix
from ..plants.descriptor import descriptors, mean_descriptor
from ..plants.descriptor_system import DescriptorSystem
from ..plants.kinds import Plant, checked_plant

__all__ = ["error_loop", "observer_loop", "vertices_of"]


def observer_loop(
    plant: Plant, K: ArrayLike, L: ArrayLike, C: ArrayLike
) -> DescriptorSystem:
    """The loop with the observer: E x' = A x, x = [e; state] (2.40).

    Parameters
    ----------
    plant : SecondOrderSystem, Polytope or DescriptorSystem
        The plant, or the polytope of plants.
    K : (m, N) array_like
        The gain of u = K x.
    L : (N, q) array_like
        The observer's gain.
    C : (q, N) array_like
        What is measured.

    Returns
    -------
    DescriptorSystem
        With a vertex for each of the plant's, e = x - x^. The
        observer's matrices are the means over the vertices.
    """
    vertices = vertices_of(plant)
    N = len(vertices[0].E)
    C = matrix("C", C, (None, N))
    K = matrix("K", K, (vertices[0].Bu.shape[1], N))
    L = matrix("L", L, (N, len(C)))
    mean = mean_descriptor(vertices)
    loops = [error_loop(d, mean, K) for d in vertices]
    inject = np.zeros((2 * N, 2 * N))
    inject[:N, :N] = mean.E @ L @ C
    return DescriptorSystem([E for E, _ in loops], [A + inject for _, A in loops])


def vertices_of(plant):
    """One `Descriptor` for each vertex of a plant of any kind."""
    if isinstance(checked_plant(plant), DescriptorSystem):
        return plant.vertices
    return descriptors(plant)


def error_loop(d, mean, K):
    """E-bar and A-tilde of (2.40), for a vertex d, the ``mean`` vertex, and K."""
    off_B = mean.Bu - d.Bu
    E = block([[mean.E, d.E - mean.E], [0, d.E]])
    A = block(
        [[mean.A + off_B @ K, d.A - mean.A - off_B @ K], [-d.Bu @ K, d.A + d.Bu @ K]]
    )
    return E, A
