"""Plants and loops in first order, where the second-order form ends."""

from dataclasses import dataclass

import numpy as np

from .checks import matrix, rank_deficient
from .descriptor import Descriptor

__all__ = ["DescriptorSystem"]


@dataclass(frozen=True, eq=False)
class DescriptorSystem:
    """E x' = A x + B u + B_w w, y = C x, or a polytope of them.

    For plants from which a state was taken out, and for closed loops
    with an observer or a filter. Its controllers are u = K x.

    Parameters
    ----------
    E, A : (N, N) array_like, or lists of them, one for each vertex
        E regular.
    B : (N, m) array_like, or a list of them, optional
        Without it there is nothing to design: a closed loop.
    B_w : (N, p) array_like, or a list of them, optional
    C : (q, N) array_like, optional

    Examples
    --------
    >>> DescriptorSystem(np.eye(2), [[0, 1], [-2, -3]]).order
    2
    """

    E: np.ndarray
    A: np.ndarray
    B: np.ndarray = None
    B_w: np.ndarray = None
    C: np.ndarray = None

    def __post_init__(self):
        N = len(_several("E", self.E)[0])
        lists = {
            name: _several(
                name, np.zeros((N, 0)) if value is None else value)
            for name, value in (
                ("E", self.E), ("A", self.A), ("B", self.B),
                ("B_w", self.B_w))
        }
        count = max(map(len, lists.values()))
        for name, found in lists.items():
            if len(found) not in (1, count):
                raise ValueError(
                    f"{name} has {len(found)} vertices, needs {count} or one"
                )
            shape = N, N if name in "EA" else found[0].shape[1]
            lists[name] = [
                matrix(name, x, shape) for x in found * (count // len(found))
            ]
        if any(rank_deficient(x, 1e-14) for x in lists["E"]):
            raise ValueError("E is singular at a vertex")
        C = np.zeros((0, N)) if self.C is None else self.C
        C = matrix("C", C, (None, N))
        vertices = tuple(
            Descriptor(e, a, b, w, C) for e, a, b, w in zip(*lists.values())
        )
        object.__setattr__(self, "vertices", vertices)

    @property
    def order(self):
        """Number of states."""
        return len(self.vertices[0].E)

    @property
    def m(self):
        """Number of inputs."""
        return self.vertices[0].Bu.shape[1]

    @property
    def p(self):
        """Number of disturbances."""
        return self.vertices[0].Bw.shape[1]

    @property
    def n(self):
        """Number of outputs."""
        return len(self.vertices[0].C)


def _several(name, value):
    """A list of matrices from one or several."""
    if np.ndim(value) == 2:
        return [matrix(name, value)]
    found = [matrix(name, x) for x in value]
    if not found:
        raise ValueError(f"{name} is an empty list")
    return found
