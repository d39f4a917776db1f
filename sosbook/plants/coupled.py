"""Matrices of the theorems: of a pair of vertices, and of one with a slack matrix."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..language import he
from .descriptor import Descriptor, same_output


@dataclass(frozen=True, eq=False)
class Coupled:
    r"""The matrices of a pair of vertices in the theorems.

    With weights :math:`\alpha` each theorem's matrix is a quadratic form
    :math:`L(\alpha) = \sum_{ij} \alpha_i \alpha_j L_{ij}`. This class
    holds the parts of the symmetric :math:`\tfrac12 (L_{ij} + L_{ji})`.
    One vertex is the pair ``i = j``.

    Parameters
    ----------
    i, j : Descriptor
        The two vertices.
    P : (N, N) matrix-like
        The common Lyapunov matrix.
    Y : (m, N) matrix-like
        ``K P``.
    """

    i: Descriptor
    j: Descriptor
    P: object
    Y: object

    @cached_property
    def Theta(self):
        """½[(A_i P + B_i Y) E_jᵀ + (A_j P + B_j Y) E_iᵀ]."""
        i, j = self.i, self.j
        half = (i.A @ self.P + i.Bu @ self.Y) @ j.E.T
        if i is j:
            return half
        return (half + (j.A @ self.P + j.Bu @ self.Y) @ i.E.T) / 2

    @cached_property
    def EPE(self):
        """½(E_i P E_jᵀ + E_j P E_iᵀ)."""
        if self.i is self.j:
            return self.i.E @ self.P @ self.i.E.T
        return he(self.i.E @ self.P @ self.j.E.T) / 2

    @cached_property
    def EP(self):
        """½(E_i + E_j) P."""
        return (self.i.E + self.j.E) @ self.P / 2

    @cached_property
    def EY(self):
        """½(E_i + E_j) Yᵀ."""
        return (self.i.E + self.j.E) @ self.Y.T / 2

    @cached_property
    def EPC(self):
        """½[E_i (P C_jᵀ + Yᵀ Du_jᵀ) + E_j (P C_iᵀ + Yᵀ Du_iᵀ)]."""
        i, j = self.i, self.j
        if same_output(i.C, j.C) and same_output(i.Du, j.Du):
            if i.Du is None:
                return self.EP @ i.C.T
            return self.EP @ i.C.T + self.EY @ i.Du.T
        return (i.E @ self._PC(j) + j.E @ self._PC(i)) / 2

    def _PC(self, d):
        PC = self.P @ d.C.T
        return PC if d.Du is None else PC + self.Y.T @ d.Du.T

    @cached_property
    def Bw(self):
        """½(B_w,i + B_w,j)."""
        return (self.i.Bw + self.j.Bw) / 2

    @cached_property
    def Dw(self):
        """½(D_w,i + D_w,j), or 0."""
        return 0 if self.i.Dw is None else (self.i.Dw + self.j.Dw) / 2


@dataclass(frozen=True, eq=False)
class SlackVertex:
    """The matrices of a vertex in the theorems with a slack matrix.

    Parameters
    ----------
    i : Descriptor
        The vertex.
    E0 : (N, N) array
        Any nonsingular matrix. With one near the E_i, P_i and V come out
        alike.
    P : (N, N) matrix-like
        The vertex has this P of its own, and the Lyapunov function x' V^-1 P
        V'^-1 x.
    V : (N, N) matrix-like
        The slack matrix, common to all vertices and requirements; it isn't
        symmetric.
    Y : (m, N) matrix-like
        ``K V'``.
    """

    i: Descriptor
    E0: np.ndarray
    P: object
    V: object
    Y: object

    @cached_property
    def Theta(self):
        """(A_i Vᵀ + B_i Y) E0ᵀ."""
        return (self.i.A @ self.V.T + self.i.Bu @ self.Y) @ self.E0.T

    @cached_property
    def EPE(self):
        """E0 P_i E0ᵀ."""
        return self.E0 @ self.P @ self.E0.T

    @cached_property
    def EVE(self):
        """E_i Vᵀ E0ᵀ."""
        return self.i.E @ self.V.T @ self.E0.T

    @cached_property
    def EV(self):
        """E0 V."""
        return self.E0 @ self.V

    @cached_property
    def EY(self):
        """E0 Yᵀ."""
        return self.E0 @ self.Y.T

    @cached_property
    def EVC(self):
        """E0 (V Cᵀ + Yᵀ Duᵀ)."""
        if self.i.Du is None:
            return self.EV @ self.i.C.T
        return self.EV @ self.i.C.T + self.EY @ self.i.Du.T

    @cached_property
    def EVA(self):
        """E0 V C_a,iᵀ, or 0."""
        return 0 if self.i.Ca is None else self.EV @ self.i.Ca.T

    @cached_property
    def Bw(self):
        """B_w,i."""
        return self.i.Bw

    @cached_property
    def Dw(self):
        """D_w,i, or 0."""
        return 0 if self.i.Dw is None else self.i.Dw
