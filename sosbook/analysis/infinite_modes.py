"""Modes at infinity of a plant with singular mass."""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import orth

from ..plants.checks import rank_deficient
from ..plants.kinds import SecondOrderPlant, checked_plant
from ..plants.second_order import Polytope
from ..runtime.threads import one_thread


@dataclass(frozen=True)
class InfiniteModes:
    """Modes of M z'' + D z' + S z = 0, as E x' = A x with x = [z; z'].

    Parameters
    ----------
    finite, infinite : int
        Numbers of finite and of infinite generalised eigenvalues of
        (A, E), E = diag(I, M); together 2n.
    impulses : int
        How many of the infinite ones are impulsive modes: the others
        are algebraic equations.
    index : int
        The index of the descriptor system: 0 if M is regular, 1 if there are
        only algebraic equations, 2 or more with impulses.
    """

    finite: int
    infinite: int
    impulses: int
    index: int

    @property
    def impulsive(self) -> int:
        """True if a jump of u can cause an impulse in x = [z; z']."""
        return self.impulses > 0


@one_thread
def infinite_modes(
    plant: SecondOrderPlant,
) -> InfiniteModes | tuple[InfiniteModes, ...]:
    r"""Count the modes that a singular mass sends to infinity.

    Parameters
    ----------
    plant : SecondOrderSystem or Polytope
        The plant, or the polytope of plants.

    Returns
    -------
    InfiniteModes
        A tuple of them, one per vertex, for a polytope.

    Raises
    ------
    ValueError
        If ``det(s^2 M + s D + S)`` vanishes for every s.

    Notes
    -----
    The plant is free of impulses if and only if L' D R is regular, the columns
    of L and R being bases of the left and right null space of M: thesis
    (A.3)-(A.5) for E = diag(I, M), where A22 = -L' D R. The modes are counted
    by the Wong sequence, with ranks to ten digits after scaling.

    Examples
    --------
    >>> from sosbook import SecondOrderSystem
    >>> parts = dict(M=[[1, 0], [0, 0]], S=[[2, -1], [-1, 1]], B=[[0], [1]])
    >>> infinite_modes(SecondOrderSystem(D=[[1, 0], [0, 1]], **parts))
    InfiniteModes(finite=3, infinite=1, impulses=0, index=1)
    >>> infinite_modes(SecondOrderSystem(D=[[1, 0], [0, 0]], **parts))
    InfiniteModes(finite=2, infinite=2, impulses=1, index=2)
    """
    plant = checked_plant(plant, SecondOrderPlant)
    if isinstance(plant, Polytope):
        return tuple(infinite_modes(v) for v in plant.vertices)  # type: ignore[misc]
    E, A = _scaled_pencil(plant)
    points = 0.31 + 1.7j, -2.3 + 0.6j, 0.9 - 1.1j
    if all(rank_deficient(s * E - A, 1e-12) for s in points):
        raise ValueError(
            "plant has a singular pencil: det(s^2 M + s D + S) vanishes "
            "for every s, so u doesn't determine the motion; use the "
            "plant with M - B K_A, see regularize"
        )
    W = np.zeros((len(E), 0))
    dimensions = [0]
    while True:
        image = orth(A @ W, rcond=1e-10) if W.size else W
        _, s, rows = np.linalg.svd(E - image @ (image.T @ E))
        W = rows[s < 1e-10].T
        if W.shape[1] == dimensions[-1]:
            break
        dimensions.append(W.shape[1])
    infinite, index = dimensions[-1], len(dimensions) - 1
    impulses = infinite - dimensions[min(1, index)]
    return InfiniteModes(len(E) - infinite, infinite, impulses, index)


def _scaled_pencil(plant):
    """E and A after scaling rows, coordinates and time to size one."""
    parts = np.stack([plant.M, plant.D, plant.S])
    for _ in range(3):
        for axis in (1, 2):
            size = np.abs(parts).max(axis=(0, 3 - axis), keepdims=True)
            parts = parts / np.where(size > 0, size, 1)
    M, D, S = parts
    m, d, s = (np.linalg.norm(x, 2) for x in parts)
    omega = 1.0
    if m > 0 and max(d, s) > 0:
        omega = np.sqrt(s / m) if s > 0 else d / m
    elif s > 0 and d > 0:
        omega = s / d
    M, D = M * omega**2, D * omega
    size = max(np.linalg.norm(x, 2) for x in (M, D, S)) or 1.0
    M, D, S = M / size, D / size, S / size
    zero, one = np.zeros_like(M), np.eye(plant.n)
    return np.block([[one, zero], [zero, M]]), np.block([[zero, one], [-S, -D]])
