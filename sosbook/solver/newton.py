"""Newton's equations: a dense matrix or an arrow for few variables, CG for many.

The equations are H d = g with H_ab = sum_k <G_ka, W_k G_kb W_k>. With
W_k = inv(G_k) this is the Hessian of the barrier (Boyd and Vandenberghe 2004,
section 9.5); with W_k the scaling point of the blocks and their multipliers it
is the Schur complement of the primal-dual equations (Nesterov and Todd 1997;
Todd, Toh and Tütüncü 1998). Both callers hand over N with W = N' N.
"""

from functools import cached_property

import numpy as np

from ..runtime.time_limit import check_time
from .kronecker import Hessian
from .matrix import ArrowMatrix, arrow_of
from .modal import Modal
from .stacks import Stacked, gram
from .sums import Sums

MOST_ITERATIONS = 300  # of one solution, where a dense matrix can take over
MOST_ITERATIONS_ALONE = 3000  # where it can't
RIDGES = [10.0**k for k in range(-15, 1)]  # that are added, relative to the diagonal


class Newton(Stacked):
    """``blocks`` with the means to solve Newton's equations, ``iterative``, by
    conjugate gradients, until they fail; ``iterations``: how many each solution took.
    """

    def __init__(self, blocks):
        super().__init__(blocks)
        self.iterations = []
        self._hessian = None
        self._ridged = False  # whether a matrix has needed more than rounding
        expected = self.settings.expected_iterations
        self.iterative = Modal.fits(self) and self.patience > expected
        self._prepare()

    def _prepare(self):
        """Prepare the matrices that conjugate gradients multiply with."""
        known = isinstance(self.values, Sums)
        self._sums = Sums(self) if self.iterative and not known else self.values

    @cached_property
    def patience(self):
        """How many iterations take about as long as the matrix and its factor."""
        return self.variables * self.settings.iterations_per_variable

    @property
    def _fits(self):
        """True if the matrix fits into the memory."""
        k, arrow = self.variables, self._arrow
        entries = k * k if arrow is None else arrow.entries
        return entries <= self.settings.most_dense_variables**2

    @cached_property
    def _arrow(self):
        """The `Arrow` in the matrix, if it takes less time; else None."""
        return arrow_of(self)

    def joined(self, slopes, row=None):
        return super().joined(slopes, row)._anew()

    def with_constants(self, constants):
        return super().with_constants(constants)._anew()

    def _anew(self):
        """This one, a copy of another, with nothing of what that has solved."""
        vars(self).pop("_arrow", None)
        self.iterations = []
        self._hessian = None
        self._ridged = False  # whether a matrix has needed more than rounding
        self._prepare()
        return self

    def solver(self, roots, x, radius=None):
        """A function that solves H d = g, H = sum of <G_ka, W_k G_kb W_k>.

        ``roots``: N with W = N' N; x: the point, for the preconditioner and the ball,
        whose barrier -log(radius^2 - x.x) a ``radius`` adds. ``solve(g, tolerance)`` is
        valid until the next solver is made; a dense matrix ignores the tolerance.
        """
        check_time()
        if self.iterative:
            return self._iterative(roots, x, radius)
        return self._dense(roots, x, radius)

    def _dense(self, roots, x, radius):
        """The Newton step at ``x`` by a factorised matrix, ridged if it must."""
        if self._hessian is None:
            if not self._fits:
                raise MemoryError(
                    f"{self.variables} variables are too many for a dense "
                    "matrix, and conjugate gradients don't converge"
                )
            arrow = self._arrow
            self._hessian = Hessian(self, None if arrow is None else ArrowMatrix(arrow))
        H = self._matrix(roots, x, radius)
        spare = H.copy() if self._ridged else None
        solve = H.factor(RIDGES[0])
        if solve is None:  # what is left of the matrix is no matrix any more
            H = self._matrix(roots, x, radius) if spare is None else spare
            self._ridged = True
            solves = (H.copy().factor(ridge) for ridge in RIDGES[1:])
            solve = next((s for s in solves if s is not None), None)
        if solve is None:
            raise np.linalg.LinAlgError("the Hessian has no factor")
        return solve

    def _matrix(self, roots, x, radius):
        """The matrix H, a `Dense` or an `ArrowMatrix`."""
        H = self._hessian.upper(roots)
        if radius is not None:  # 2 I / s + 4 x x' / s^2, with s = radius^2 - x.x
            s = radius**2 - x @ x
            H.add_diagonal(2 / s)
            H.add_square(2 * x / s)
        H.fill_empty()
        return H

    def _iterative(self, roots, x, radius):
        """The Newton step at ``x`` by conjugate gradients."""
        W = gram(roots)
        modal = Modal(self, W, x)
        s = None if radius is None else radius**2 - x @ x

        def times(d):
            """H d: the adjoint of W dG W, and the part of the ball."""
            Hd = self._sums.adjoint([w @ g @ w for w, g in zip(W, self._sums.along(d))])
            if s is not None:
                Hd += 2 / s * d + (4 / s**2 * (x @ d)) * x
            return Hd

        dense, spent, most = None, 0, MOST_ITERATIONS_ALONE
        if self._fits:  # three times what the dense matrix takes is too much
            most = int(min(MOST_ITERATIONS, 3 * self.patience))

        def solve(g, tolerance=0.1):
            nonlocal dense, spent
            if self.iterative:
                d, count = _conjugate_gradients(times, g, modal, tolerance, most)
                self.iterations.append(count)
                spent += count
                if d is None or (self._fits and spent > self.patience):
                    self.iterative = False  # too stiff, here and further on
                if d is not None:
                    return d
            if dense is None:
                dense = self._dense(roots, x, radius)
            return dense(g)

        return solve


def _conjugate_gradients(times, g, precondition, tolerance, most):
    """Solve H d = g by preconditioned conjugate gradients, to a fall of the residual by
    ``tolerance``; d is None where ``most`` aren't enough or H isn't definite.
    """
    d, r = np.zeros_like(g), g.copy()
    z = precondition(r)
    p, squared = z, r @ z  # the residual's norm, squared
    goal = tolerance**2 * squared
    for count in range(1, most + 1):
        check_time()
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
