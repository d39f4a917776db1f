"""The loops of a law as its gain moves, in floats, and units of that gain."""

from functools import cached_property

import numpy as np

from ...exact.rational import exact
from ...laws.base import plain
from ...plants.descriptor import Descriptor

__all__ = ["Loops", "loops_of"]

TINY = 1e-9  # of the largest entry of G: below it a sensor doesn't see an input


class Loops:
    """x' = (A + B K C_y) x + (W + B K D_y) w, z = (C + D K C_y) x + (D_w + ...) w.

    Parameters
    ----------
    plants : list of Descriptor
        Joined with the law's states, of floats.
    measured, noisy : (q, N) and (q, p) arrays
        C_y and D_y.
    form : Structure
        Which gains are free.
    """

    def __init__(self, plants, measured, noisy, form):
        self.plants, self.measured, self.noisy, self.form = (
            plants,
            measured,
            noisy,
            form,
        )
        self.directions = form.directions

    def __len__(self):
        return len(self.plants)

    def with_more(self, plants):
        """The same with some ``plants`` more."""
        return Loops([*self.plants, *plants], self.measured, self.noisy, self.form)

    @cached_property
    def matrices(self):
        """A, B, W, C, D, D_w, each a stack: E is divided out."""
        solved = [
            np.linalg.solve(d.E, np.hstack([d.A, d.Bu, d.Bw])) for d in self.plants
        ]
        N, m = self.plants[0].Bu.shape
        A, B, W = np.split(np.array(solved), [N, N + m], axis=2)
        C = np.array([d.C for d in self.plants])
        D = np.array([_or_zero(d.Du, (len(d.C), m)) for d in self.plants])
        through = [
            _or_zero(getattr(d, "Dw", None), (len(d.C), d.Bw.shape[1]))
            for d in self.plants
        ]
        return A, B, W, C, D, np.array(through)

    def K(self, kappa):
        """The gain of the free numbers ``kappa``."""
        return np.tensordot(kappa, self.directions, 1)

    def slope(self, S):
        """The derivative in kappa, from ``S``, that in K."""
        return np.einsum("kij,ij->k", self.directions, S)

    def closed(self, K):
        """The stack A + B ``K`` C_y."""
        A, B, *_ = self.matrices
        return A + B @ (K @ self.measured)

    def whole(self, K):
        """Stacks of the four matrices of the loop from w to z, under ``K``."""
        A, B, W, C, D, through = self.matrices
        KC, KD = K @ self.measured, K @ self.noisy
        return A + B @ KC, W + B @ KD, C + D @ KC, through + D @ KD

    def descriptor(self, i, K, m):
        """The loop ``i`` under ``K``, ``m`` inputs left open, and its state gain."""
        A, B, W, C, D, _ = (x[i] for x in self.matrices)
        pushed = B[:, m:] @ K[m:]
        noise = (B @ K) @ self.noisy
        d = Descriptor(
            np.eye(len(A)),
            A + pushed @ self.measured,
            B[:, :m],
            W + noise,
            C,
            D[:, :m] if D.any() else None,
        )
        return d, K[:m] @ self.measured

    def sizes(self, s):
        """Units of u and y: in them the plant's answer at a real s is about one.

        Sinkhorn's scaling of its entries' logarithms: covariant in every unit.
        """
        A, B, *_ = (x.mean(axis=0) for x in self.matrices)
        G = np.abs(self.measured @ np.linalg.solve(s * np.eye(len(A)) - A, B))
        seen = np.argwhere(G > TINY * G.max(initial=0))
        q, m = G.shape
        rows, right = np.zeros((len(seen), q + m)), np.zeros(len(seen))
        for k, (j, i) in enumerate(seen):
            rows[k, j], rows[k, q + i] = 1.0, -1.0
            right[k] = np.log(G[j, i])
        logs = np.linalg.lstsq(rows, right, rcond=None)[0]
        return np.exp(logs[q:]), np.exp(logs[:q])

    def units(self, s):
        """The unit of each free number at a real s."""
        of_u, of_y = self.sizes(s)
        each = np.log(np.outer(of_u, 1 / of_y))
        weights = (self.directions != 0) + 0.0
        return np.exp((weights * each).sum(axis=(1, 2)) / weights.sum(axis=(1, 2)))

    @cached_property
    def rates(self):
        """The slowest and the fastest pole of the mean plant and the law, in rad/s."""
        A = self.matrices[0].mean(axis=0)
        sizes = np.abs(np.linalg.eigvals(A))
        sizes = sizes[sizes > 1e-6 * sizes.max(initial=0)]
        if not len(sizes):  # free masses and integrators: any rate will do
            return 1.0, 1.0
        return float(sizes.min()), float(sizes.max())


def loops_of(request, plants=None):
    """The `Loops` of a request with a law, of its vertices or of other ``plants``.

    These are `Descriptor` objects without a controller, in rationals.
    """
    parts, form = request.law_parts, request.law.structure(request.plant)
    if plants is None:
        vertices = plain(request.plant, request.K_A)
        plants = [vertices[i] for i in request.distinct]
    joined = [parts.joined(d).map(_float) for d in plants]
    return Loops(joined, _float(parts.measured), _float(parts.noisy), form)


def _float(x):
    return exact(x).astype(float)


def _or_zero(x, shape):
    return np.zeros(shape) if x is None else x
