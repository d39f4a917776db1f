"""Newton's equations: a dense matrix for few variables, CG for many."""

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from .kronecker import Hessian
from .modal import Modal
from .stacks import Stacked, squares

__all__ = ["Newton", "newton_of"]

DENSE = 450  # from here conjugate gradients are faster
LARGEST = 6000  # most variables of a dense matrix (300 MB)


class Newton(Stacked):
    """Blocks with the means to solve Newton's equations.

    Parameters
    ----------
    blocks : Blocks
    lift : list of (q, q) arrays, optional
        Slopes of one more variable, the last.

    Attributes
    ----------
    iterative : bool
        Whether conjugate gradients are used; given up where they fail.
    iterations : list of int
        Of conjugate gradients, one entry for each solution.
    """

    def __init__(self, blocks, lift=None):
        super().__init__(blocks, lift)
        self.iterative = self.variables > DENSE and Modal.fits(self)
        self.iterations = []
        self._hessian = None

    def solver(self, roots, x, radius=None):
        """A function that solves H d = g.

        Parameters
        ----------
        roots : list of stacks
            N with W = N' N in H = sum of <G_ka, W_k G_kb W_k>.
        x : (k,) array
            The point, for preconditioning and for the ball.
        radius : float, optional
            With it H has the ball's part too.

        Returns
        -------
        callable
            Of g and a relative tolerance, which dense matrices ignore.
        """
        if self.iterative:
            return self._iterative(roots, x, radius)
        return self._dense(roots, x, radius)

    def _dense(self, roots, x, radius):
        if self._hessian is None:
            if self.variables > LARGEST:
                raise MemoryError(
                    f"{self.variables} variables are too many for a dense "
                    "matrix, and conjugate gradients don't converge"
                )
            self._hessian = Hessian(self)
        H = self._hessian(roots)
        if radius is not None:
            room = radius**2 - x @ x
            H[np.diag_indices(len(x))] += 2 / room
            H += np.outer(2 * x / room, 2 * x / room)
        idle = np.diag(H) == 0  # variables of no block
        H[idle, idle] = 1.0
        scale = 1 / np.sqrt(np.diag(H))
        factor = _cholesky(H * np.outer(scale, scale))

        def solve(g, tolerance=None):
            return scale * cho_solve(factor, scale * g, check_finite=False)

        return solve

    def _iterative(self, roots, x, radius):
        W = squares(roots)
        modal = Modal(self, W, x)
        room = None if radius is None else radius**2 - x @ x

        def times(d):
            bent = [w @ g @ w for w, g in zip(W, self.along(d))]
            out = self.adjoint(bent)
            if room is not None:
                out += 2 / room * d + (4 / room**2 * (x @ d)) * x
            return out

        dense = None

        def solve(g, tolerance=0.1):
            nonlocal dense
            if self.iterative:
                d, count = _conjugate_gradients(times, g, modal, tolerance)
                self.iterations.append(count)
                if d is not None:
                    return d
                self.iterative = False  # too stiff, here and further on
            if dense is None:
                dense = self._dense(roots, x, radius)
            return dense(g)

        return solve


def newton_of(blocks):
    """The Newton of these blocks, made once."""
    if "newton" not in vars(blocks):
        blocks.newton = Newton(blocks)
    return blocks.newton


def _conjugate_gradients(times, g, precondition, tolerance, most=300):
    """Solve H d = g; the residual in the preconditioner's norm."""
    d, r = np.zeros_like(g), g.copy()
    z = precondition(r)
    p, size = z, r @ z
    goal = tolerance**2 * size
    for count in range(1, most + 1):
        Hp = times(p)
        bend = p @ Hp
        if not bend > 0 or not np.isfinite(bend):
            return None, count
        step = size / bend
        d += step * p
        r -= step * Hp
        z = precondition(r)
        size, before = r @ z, size
        if size <= goal:
            return d, count
        p = z + (size / before) * p
    return None, most


def _cholesky(matrix):
    """Factor of a matrix with unit diagonal, lifted if it must be."""
    if not np.isfinite(matrix).all():
        raise np.linalg.LinAlgError("the Hessian has NaN entries")
    for ridge in 10.0 ** np.arange(-15, 1):
        try:
            return cho_factor(matrix + ridge * np.eye(len(matrix)))
        except np.linalg.LinAlgError:
            continue
    raise np.linalg.LinAlgError("the Hessian has no factor")
