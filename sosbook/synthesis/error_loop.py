"""The loop with an observer, in the error of the estimate and the state."""

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from ..language import block
from ..plants.checks import matrix
from ..plants.descriptor import descriptors, mean_descriptor
from ..plants.descriptor_system import DescriptorSystem
from ..plants.kinds import Plant, checked_plant

__all__ = ["error_loop", "observed", "observer_loop", "vertices_of"]


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
    return DescriptorSystem(*_loops(plant, K, L, C, 1)[:2])


def _loops(plant, K, L, C, reach):
    """Lists of E and A, closed (``reach`` 1) or opened at u (0); the vertices; K."""
    vertices = vertices_of(plant)
    N = len(vertices[0].E)
    C = matrix("C", C, (None, N))
    K = matrix("K", K, (vertices[0].Bu.shape[1], N))
    L = matrix("L", L, (N, len(C)))
    mean = mean_descriptor(vertices)
    inject = np.zeros((2 * N, 2 * N))
    inject[:N, :N] = mean.E @ L @ C
    loops = [error_loop(replace(d, Bu=reach * d.Bu), mean, K) for d in vertices]
    return [E for E, _ in loops], [A + inject for _, A in loops], vertices, K


def observed(plant, K, L, C):
    """The plant with its observer, opened where u enters the plant.

    ``plant``, ``K``, ``L``, ``C``: as in `observer_loop`. Returns system: E x' = A x +
    B u + B_w w with x = [e; state] and the plant's outputs. The observer is inside, and
    is told K x^ whatever u is; gain, (m, 2N): [-K K]: u = K x^ closes the loop, which
    is that of `observer_loop`.
    """
    E, A, vertices, K = _loops(plant, K, L, C, 0)
    first = vertices[0]
    system = DescriptorSystem(
        E,
        A,
        [np.vstack([d.Bu, d.Bu]) for d in vertices],
        [np.vstack([d.Bw, d.Bw]) for d in vertices],
        np.hstack([0 * first.C, first.C]),
        first.Du,
    )
    return system, np.hstack([-K, K])


def vertices_of(plant):
    """One `Descriptor` for each vertex of a plant of any kind."""
    plant = checked_plant(plant)
    if isinstance(plant, DescriptorSystem):
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
