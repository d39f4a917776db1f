"""Newton's equations: a dense matrix for few variables, CG for many.

The equations are H d = g with H_ab = sum_k <G_ka, W_k G_kb W_k>. With
W_k = inv(G_k) this is the Hessian of the barrier (Boyd and Vandenberghe 2004,
section 9.5); with W_k the scaling point of the blocks and their multipliers it
is the Schur complement of the primal-dual equations (Nesterov and Todd 1997;
Todd, Toh and Tütüncü 1998). Both callers hand over N with W = N' N.
"""

import numpy as np
from scipy.linalg.lapack import dpotrf, dpotrs

from ..deprecation import renamed
from .kronecker import Hessian
from .modal import Modal
from .stacks import Stacked, gram
from .time_limit import check_time

__all__ = ["Newton", "newton_of"]

CG_ABOVE_VARIABLES = 450  # from here on conjugate gradients are faster
MOST_DENSE_VARIABLES = 6000  # a dense matrix of so many takes 300 MB
MOST_CG_ITERATIONS = 300  # for one solution, before the dense matrix is tried
RIDGES = [10.0**k for k in range(-15, 1)]  # that are added to a unit diagonal

__getattr__ = renamed(__name__, DENSE="CG_ABOVE_VARIABLES")


class Newton(Stacked):
    """Blocks with the means to solve Newton's equations.

    Parameters
    ----------
    blocks : Blocks
        The blocks G_k, affine in k variables.

    Attributes
    ----------
    iterative : bool
        Whether conjugate gradients are used; False from where they fail.
    iterations : list of int
        Iterations of conjugate gradients, one entry for each solution.
    """

    def __init__(self, blocks):
        super().__init__(blocks)
        self.iterative = self.variables > CG_ABOVE_VARIABLES and Modal.fits(self)
        self.iterations = []
        self._hessian = None

    def joined(self, slopes):
        joined = super().joined(slopes)
        joined.iterations = []
        joined._hessian = None
        return joined

    def solver(self, roots, x, radius=None):
        """A function that solves H d = g.

        Parameters
        ----------
        roots : list of stacks
            N with W = N' N in H = sum of <G_ka, W_k G_kb W_k>.
        x : (k,) array
            The point, which the preconditioner and the ball need.
        radius : float, optional
            With it the barrier of the ball, -log(radius^2 - x.x), is added.

        Returns
        -------
        callable
            ``solve(g, tolerance)``; a dense matrix ignores the tolerance.

        Raises
        ------
        OutOfTime
            If a `time_limit` is over.
        """
        check_time()
        if self.iterative:
            return self._iterative(roots, x, radius)
        return self._dense(roots, x, radius)

    def _dense(self, roots, x, radius):
        if self._hessian is None:
            if self.variables > MOST_DENSE_VARIABLES:
                raise MemoryError(
                    f"{self.variables} variables are too many for a dense "
                    "matrix, and conjugate gradients don't converge"
                )
            self._hessian = Hessian(self)
        H = self._hessian(roots)
        if radius is not None:  # 2 I / s + 4 x x' / s^2, with s = radius^2 - x.x
            s = radius**2 - x @ x
            H[np.diag_indices(len(x))] += 2 / s
            H += np.outer(2 * x / s, 2 * x / s)
        unused = H.diagonal() == 0  # variables that no block depends on
        H[unused, unused] = 1.0
        scale = 1 / np.sqrt(H.diagonal())
        factor = _cholesky(scale[:, None] * H * scale)

        def solve(g, tolerance=None):
            return scale * dpotrs(factor, scale * g, lower=1)[0]

        return solve

    def _iterative(self, roots, x, radius):
        W = gram(roots)
        modal = Modal(self, W, x)
        s = None if radius is None else radius**2 - x @ x

        def times(d):
            """H d: the adjoint of W dG W, and the part of the ball."""
            WGW = [w @ g @ w for w, g in zip(W, self.along(d))]
            product = self.adjoint(WGW)
            if s is not None:
                product += 2 / s * d + (4 / s**2 * (x @ d)) * x
            return product

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
    """The `Newton` of a `Blocks`, made once and kept with these blocks."""
    if "newton" not in vars(blocks):
        blocks.newton = Newton(blocks)
    return blocks.newton


def _conjugate_gradients(times, g, precondition, tolerance, most=MOST_CG_ITERATIONS):
    """Solve H d = g by preconditioned conjugate gradients.

    They stop when the residual, in the preconditioner's norm, has fallen to
    ``tolerance`` times what it was, and return None for d where H isn't
    positive definite to rounding, or ``most`` iterations aren't enough.
    Vandenberghe and Boyd (1995) solve Lyapunov inequalities in this way.
    """
    d, r = np.zeros_like(g), g.copy()
    z = precondition(r)
    p, squared = z, r @ z  # the residual's norm, squared
    goal = tolerance**2 * squared
    for count in range(1, most + 1):
        Hp = times(p)
        curvature = p @ Hp
        if not curvature > 0 or not np.isfinite(curvature):
            return None, count
        step = squared / curvature
        d += step * p
        r -= step * Hp
        z = precondition(r)
        squared, before = r @ z, squared
        if squared <= goal:
            return d, count
        p = z + (squared / before) * p
    return None, most


def _cholesky(matrix):
    """Factor of a matrix with unit diagonal; a ridge is added where it fails."""
    if not np.isfinite(matrix).all():
        raise np.linalg.LinAlgError("the Hessian has NaN entries")
    diagonal = matrix.diagonal().copy()
    for ridge in RIDGES:
        np.fill_diagonal(matrix, diagonal + ridge)
        factor, failed = dpotrf(matrix, lower=1)
        if not failed:
            return factor
    raise np.linalg.LinAlgError("the Hessian has no factor")
