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
from .arrow import ArrowMatrix, arrow_of
from .congruence import Congruence
from .kronecker import Hessian
from .modal import Modal
from .stacks import Stacked, gram
from .sums import Sums
from .work import hessian_work, iteration_work, products_work, sums_work

__all__ = ["Newton", "newton_of"]

#: Of conjugate gradients for one matrix, its Modal included. It was chosen on grounded
#: and free chains and cantilevers, none of them held back in benchmarks/catalogue.py.
EXPECTED_ITERATIONS = 65
MOST_DENSE_VARIABLES = 6000  # a dense matrix of so many takes 300 MB
MOST_ITERATIONS = 300  # for one solution, where a dense matrix can take over
MOST_ITERATIONS_ALONE = 3000  # where it can't
RIDGES = [10.0**k for k in range(-15, 1)]  # that are added, relative to the diagonal


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
        self.iterations = []
        self._hessian = None
        self._ridged = False  # whether a matrix has needed more than rounding
        self.iterative = Modal.fits(self) and self.patience > EXPECTED_ITERATIONS
        self._prepare()

    def _prepare(self):
        """What conjugate gradients multiply with, in both precisions."""
        self._double = self._congruence = None
        if not self.iterative:
            return
        known = isinstance(self.values, Sums)
        self._double = self.values if known else Sums(self)
        if products_work(self) > sums_work(self):  # and not numpy's calls
            self._congruence = Congruence(self)

    @cached_property
    def patience(self):
        """How many iterations take as long as the matrix."""
        return hessian_work(self) / iteration_work(self)

    @property
    def _fits(self):
        """Whether the matrix fits into the memory."""
        k, arrow = self.variables, self._arrow
        entries = k * k if arrow is None else arrow.entries
        return entries <= MOST_DENSE_VARIABLES**2

    @cached_property
    def _arrow(self):
        """What is an `Arrow` in the matrix, if that takes less time; else None."""
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
            ``solve(g, tolerance)``, valid until the next solver is made; a dense
            matrix ignores the tolerance.

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
        W = gram(roots)
        modal = Modal(self, W, x)
        s = None if radius is None else radius**2 - x @ x

        def product(sums, W):
            def times(d):
                """H d: the adjoint of W dG W, and the part of the ball."""
                WGW = [w @ g @ w for w, g in zip(W, sums.along(d))]
                Hd = sums.adjoint(WGW)
                if s is not None:
                    Hd += 2 / s * d + (4 / s**2 * (x @ d)) * x
                return Hd

            return times

        times, rough = product(self._double, W), None
        if self._congruence is not None:
            rough = product(self._congruence.sums, self._congruence.metric(W))
        dense, spent = None, 0

        def solve(g, tolerance=0.1):
            nonlocal dense, spent
            if self.iterative:
                d, count = self._conjugate(times, rough, g, modal, tolerance)
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

    def _conjugate(self, times, rough, g, modal, tolerance):
        """Conjugate gradients: the solution or None, and the number of products.

        They go as far as they get with products in single precision. What
        these have left of the equations is then solved in double precision.
        """
        most = MOST_ITERATIONS_ALONE
        if self._fits:  # three times what the dense matrix takes is too much
            most = int(min(MOST_ITERATIONS, 3 * self.patience))
        if rough is None:
            return _conjugate_gradients(times, g, modal, tolerance, most)
        d, count = _conjugate_gradients(rough, g, modal, tolerance, most)
        if d is None:
            d = np.zeros_like(g)
        r = g - times(d)
        left, goal = np.sqrt(r @ modal(r)), tolerance * np.sqrt(g @ modal(g))
        if left <= 2 * goal:
            return d, count
        more, again = _conjugate_gradients(times, r, modal, min(goal / left, 1), most)
        return None if more is None else d + more, count + again


def newton_of(blocks):
    """The `Newton` of a `Blocks`, made once and kept with these blocks."""
    if "newton" not in vars(blocks):
        blocks.newton = Newton(blocks)
    return blocks.newton


def _conjugate_gradients(times, g, precondition, tolerance, most):
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
