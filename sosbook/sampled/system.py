"""A sampled linear system: what a loop needs of python-control's StateSpace."""

from dataclasses import dataclass

import numpy as np

from ..plants.checks import matrix
from ..runtime.libraries import library

__all__ = ["SampledSystem"]


@dataclass(frozen=True, eq=False)
class SampledSystem:
    """x(k+1) = A x(k) + B u(k), y(k) = C x(k) + D u(k).

    Parameters
    ----------
    A : (N, N) array_like
        How the state moves.
    B : (N, m) array_like
        How the input acts on the state.
    C : (p, N) array_like
        How the state is seen.
    D : (p, m) array_like
        How the input is seen at once.
    dt : float
        Time between samples, in s.
    B_w, D_w : (N, p_w) and (p, p_w) array_like, optional
        Of a controller: how the plant's disturbance w enters it by what it reads.
    inputs, outputs : tuple of str, optional
        What they are called; a loop is closed by these names.

    Examples
    --------
    >>> delay = SampledSystem([[0]], [[1]], [[1]], [[0]], 0.1)
    >>> twice = delay.then(delay)
    >>> twice.nstates, twice.at(1j).round(12)
    (2, array([[-1.+0.j]]))
    """

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    D: np.ndarray
    dt: float
    B_w: np.ndarray | None = None
    D_w: np.ndarray | None = None
    inputs: tuple = ()
    outputs: tuple = ()

    def __post_init__(self):
        """Check the shapes, the step and the names."""
        D = matrix("D", self.D)
        N = len(np.asarray(self.A))
        for name, shape in (
            ("A", (N, N)),
            ("B", (N, D.shape[1])),
            ("C", (len(D), N)),
            ("D", D.shape),
        ):
            value = np.asarray(getattr(self, name), float)
            if not value.size:  # [] for a matrix without rows or columns
                value = value.reshape(shape)
            object.__setattr__(self, name, matrix(name, value, shape))
        if (self.B_w is None) != (self.D_w is None):
            raise ValueError("B_w and D_w say together how w is read: give both")
        if self.D_w is not None:
            object.__setattr__(self, "D_w", matrix("D_w", self.D_w, (len(D), None)))
            width, B_w = self.D_w.shape[1], np.asarray(self.B_w, float)
            B_w = matrix("B_w", B_w.reshape(N, width), (N, width))
            object.__setattr__(self, "B_w", B_w)
        for name, size in (("inputs", D.shape[1]), ("outputs", len(D))):
            words = getattr(self, name)
            good = isinstance(words, (list, tuple)) and len(words) in (0, size)
            if not good or len(set(map(str, words))) < len(words):
                raise ValueError(f"{name} must name each of the {size} once, or none")
            object.__setattr__(self, name, tuple(map(str, words)))

    @property
    def nstates(self):
        """N, the number of states."""
        return len(self.A)

    @property
    def ninputs(self):
        """m, the number of inputs."""
        return self.D.shape[1]

    @property
    def noutputs(self):
        """p, the number of outputs."""
        return len(self.D)

    def then(self, other):
        """The series: the outputs of this system are the other's inputs."""
        corner = np.zeros((self.nstates, other.nstates))
        return SampledSystem(
            np.block([[self.A, corner], [other.B @ self.C, other.A]]),
            np.vstack([self.B, other.B @ self.D]),
            np.hstack([other.D @ self.C, other.C]),
            other.D @ self.D,
            self.dt,
        )

    def at(self, z):
        """The transfer matrices C (z I - A)^-1 B + D.

        Parameters
        ----------
        z : complex, or (...) array_like of them
            Where they are taken.

        Returns
        -------
        (..., p, m) array of complex
            One matrix for each z.
        """
        pencil = np.asarray(z)[..., None, None] * np.eye(self.nstates) - self.A
        return self.C @ np.linalg.solve(pencil, self.B + 0j) + self.D

    def to_control(self):
        """As python-control's StateSpace."""
        return library("control").ss(self.A, self.B, self.C, self.D, self.dt)
