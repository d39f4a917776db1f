"""The goal of a search at the ticks: the spectral radius of loops affine in numbers."""

import numpy as np

from ..synthesis.structured.objective import Objective

FLOOR = 0.05  # of the spectral radius: nothing is asked to die out faster


class TickLoops:
    """Sampled loops of some ``plants``, affine in the free numbers of a ``form``:
    controllers ``made`` without a gain, and with a step of each number, ``steps``;
    ``some``: one with all numbers.
    """

    def __init__(self, made, steps, form, plants, some=None):
        self.made, self.steps, self.plants, self.form = made, steps, plants, form
        self.some = some
        self.first, self.slopes = self.affine(
            lambda c: np.array([c.loop(d).F for d in plants])
        )
        self.K = self.slope = lambda x: x  # what `Objective` moves and asks

    def affine(self, of):
        """The array that ``of`` makes of one without a gain, and its slopes."""
        first, *moved = map(of, self.made)
        several = zip(moved, self.steps)
        return first, np.array([(x - first) / step for x, step in several])

    def at(self, kappa):
        """F of each plant, (plants, N, N), for the free numbers ``kappa``."""
        return self.first + np.tensordot(kappa, self.slopes, 1)


class Radius(Objective):
    """The largest modulus of an eigenvalue less a ``radius``, in units of a ``size``,
    of a ``task`` for ``loops`` in a ``unit`` of each number.
    """

    def __init__(self, task, loops, unit, radius, size):
        super().__init__(task, loops, unit, False)
        self.radius, self.size = radius, size

    def _of(self, kappa, most):
        """As that of `Objective`; the slope in the free numbers ``kappa``."""
        F = self.loops.at(kappa)
        if not np.isfinite(F).all():
            return np.inf, None
        z, V = np.linalg.eig(F)
        i, j = divmod(int(abs(z).argmax()), z.shape[1])
        value = abs(z[i, j])
        if value < FLOOR:
            return (FLOOR - self.radius) / self.size, lambda: 0 * kappa

        def slope():
            one = np.eye(len(V[i]))[j] + 0j
            left = np.linalg.lstsq(V[i].T, one, rcond=None)[0]
            turned = self.loops.slopes[:, i] @ V[i, :, j] @ left
            return (turned * z[i, j].conj() / value).real / self.size

        return (value - self.radius) / self.size, slope
