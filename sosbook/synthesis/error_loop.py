"""The loop with an observer, in the error of the estimate and the state."""

from dataclasses import replace

import numpy as np

from ..exact.rational import exact
from ..language import block
from ..plants.checks import matrix
from ..plants.descriptor import Descriptor, descriptors, mean_descriptor
from ..plants.descriptor_system import DescriptorSystem
from ..plants.gain import gain_of
from ..plants.joined import joined_family
from ..plants.kinds import Plant, checked_plant
from ..runtime.array_like import ArrayLike


def observer_loop(
    plant: Plant, K: ArrayLike, L: ArrayLike, C: ArrayLike
) -> DescriptorSystem:
    """The loop with the observer: E x' = A x, x = [e; state] (2.40).

    Parameters
    ----------
    plant : SecondOrderSystem, Polytope, Uncertain or DescriptorSystem
        The plant, or several.
    K : (m, N) array_like
        The gain of u = K x.
    L : (N, q) array_like
        The observer's gain.
    C : (q, N) array_like
        What is measured.

    Returns
    -------
    DescriptorSystem
        With a vertex for each of the plant's, e = x - x^; of an Uncertain it has the
        same parameters. The observer's matrices are the means over the vertices.
    """
    return _joined(plant, K, L, C, closed=True)


def _joined(plant, K, L, C, closed):
    """The plant with its observer: the loop, or opened at u."""
    plant = checked_plant(plant, of="error_loop")
    vertices = vertices_of(plant)
    N = len(vertices[0].E)
    C = matrix("C", C, (None, N))
    K = matrix("K", gain_of(K, plant), (vertices[0].Bu.shape[1], N))
    L = matrix("L", L, (N, len(C)))
    mean = mean_descriptor(vertices)

    def joined(d, number=np.asarray):
        near, gain, seen = mean.map(number), number(K), number(C)
        inject = number(np.zeros((2 * N, 2 * N)))
        inject[:N, :N] = near.E @ number(L) @ seen
        E, A = error_loop(replace(d, Bu=d.Bu * closed), near, gain)
        if closed:
            none = number(np.zeros((2 * N, 0)))
            return Descriptor(E, A + inject, none, none, none.T)
        B, push = (np.vstack([x, x]) for x in (d.Bu, d.Bw))
        return Descriptor(E, A + inject, B, push, np.hstack([0 * d.C, d.C]), d.Du)

    if plant.family is not None:
        return joined_family(plant.family, lambda d: joined(d, exact)).polytope()
    return DescriptorSystem.of([joined(d) for d in vertices])


def observed(plant, K, L, C):
    """E x' = A x + B u + B_w w with x = [e; state] and the outputs of a ``plant`` with
    its observer, opened where u enters the plant, and the gain [-K K], (m, 2N), that
    closes it to `observer_loop`. The observer is told K x^ whatever u is; ``K``, ``L``
    and ``C`` are as there.
    """
    K = np.array(K, float)
    return _joined(plant, K, L, C, closed=False), np.hstack([-K, K])


def vertices_of(plant):
    """One `Descriptor` for each vertex of a plant of any kind; of ticks its change."""
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
