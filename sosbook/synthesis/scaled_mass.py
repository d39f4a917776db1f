"""Lemma 2.1 in coordinates in which masses and inputs have size one."""

import numpy as np

from ..language import Unknown, block, eye, he
from ..lmi.problem import LMIProblem
from ..lmi.text import LMIText
from ..theorems.regularization import regular_mass
from .regularity import mass_pairs


class ScaledMass:
    """(2.12) of a ``plant`` and ``beta``, with masses and inputs of size one, in the
    unknown L: K_A = root^2 diag(force) basis L. The default basis leaves out what does
    nothing at any vertex: combinations of redundant inputs.
    """

    def __init__(self, plant, beta):
        self.M, self.B = zip(*mass_pairs(plant).values())
        self.beta = beta
        size = max(beta**2, *(np.linalg.norm(M, 2) for M in self.M))
        self.root = np.sqrt(size)
        stacked = np.vstack(self.B)
        norms = np.linalg.norm(stacked, axis=0)
        self.force = 1 / np.where(norms > 0, norms, 1)
        _, s, rows = np.linalg.svd(stacked * self.force)
        rank = max(int((s > 1e-10).sum()), 1)
        m = stacked.shape[1]
        self.basis = rows[:rank].T if rank < m else np.eye(m)

    def problem(self, basis=None, raised=1.0, size=None, more=()):
        """(2.12) in a ``basis`` with beta^2 ``raised``, what ``size`` demands of L, and
        ``more`` unknowns.
        """
        basis = self.basis if basis is None else basis
        effect = self.force[:, None] * basis
        beta = np.sqrt(raised) * self.beta / self.root
        scaled = [(M / self.root**2, B @ effect) for M, B in zip(self.M, self.B)]

        def write(values, number):
            blocks = {
                f"mass {k}": regular_mass(M, B, values["L"], beta)
                for k, (M, B) in enumerate(scaled)
            }
            return blocks | (size(values, scaled) if size else {})

        L = Unknown("L", basis.shape[1], len(self.M[0]))
        return LMIProblem(LMIText(write, [L, *more]))

    def gain(self, L, basis):
        """The K_A of an L in a basis."""
        return self.root**2 * self.force[:, None] * (basis @ L)

    def centre(self, inside):
        """Analytic centre of (2.12) and |M - B K_A| < rho, from an L ``inside``."""

        def bounded(rho=None):
            def size(values, scaled):
                limit = values["rho"] if rho is None else rho
                masses = [M - B @ values["L"] for M, B in scaled]
                return {
                    f"norm {k}": _norm_below(limit, g) for k, g in enumerate(masses)
                }

            return self.problem(size=size, more=[free] if rho is None else [])

        free = Unknown("rho", 1)
        rho = max(np.linalg.norm(M, 2) for M in self.M) / self.root**2
        values = bounded(rho).find().values if rho > 0 else None
        if values is None:  # then the least rho is larger
            effect = self.force[:, None] * (self.basis @ inside["L"])
            norms = [
                np.linalg.norm(M / self.root**2 - B @ effect, 2)
                for M, B in zip(self.M, self.B)
            ]
            start = inside | {"rho": np.array([[1.5 * max(norms)]])}
            values = bounded().minimize(free, 1e-7, start).values
            rho = values["rho"].item()
        L = bounded(2 * rho).centre({"L": values["L"]}).values["L"]
        return self.gain(L, self.basis)

    def least_norm(self, inside):
        """The smallest Frobenius norm of K_A, from an L ``inside``."""
        m, n = len(self.force), len(self.M[0])
        if all(np.linalg.eigvalsh(he(M) / 2)[0] > self.beta**2 for M in self.M):
            return np.zeros((m, n))
        for raised in (1.01, 1.0001, 1.000001):
            values = self.problem(np.eye(m), raised).find().values
            if values is not None:
                break
        else:  # beta is all but the largest that can be had
            return self.gain(inside["L"], self.basis)
        weight = np.diag(self.force / self.force.max())

        def shorter(L, gap):
            unit = np.linalg.norm(weight @ L)

            def size(values, _):
                t, column = values["t"], _column(weight @ values["L"] / unit)
                return {"size": block([[t * eye(m * n), column], [column.T, t]])}

            least = Unknown("t", 1)
            problem = self.problem(np.eye(m), raised, size, [least])
            start = {"L": L, "t": np.array([[1.5]])}
            return problem.minimize(least, gap, start).values["L"]

        L = shorter(values["L"], 1e-2)  # finds the unit
        return self.gain(shorter(L, 1e-9), np.eye(m))


def _column(x):
    """The entries of a matrix, one below the other."""
    rows, columns = x.shape
    parts = [
        np.kron(e[:, None], np.eye(rows)) @ x @ e[:, None] for e in np.eye(columns)
    ]
    return sum(parts[1:], parts[0])


def _norm_below(size, x):
    """|x| < size, for a square matrix x, as a block."""
    one = eye(x.shape[0])
    return block([[size * one, x], [x.T, size * one]])
