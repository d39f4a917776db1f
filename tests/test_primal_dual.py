"""One primal-dual step against its equations, solved densely with <G_a, W G_b W>,
where W is the geometric mean of inv(S) and Z.
"""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.linalg import block_diag, sqrtm

from sosbook.lmi import Unknown, eye, he
from sosbook.solver.blocks import Blocks
from sosbook.solver.primal_dual import _direction, _Scaling


def lyapunov(n, seed):
    """Blocks P > 0, 20 I - P > 0 and -(A P + P A') + I > 0, and a point inside."""
    random = np.random.default_rng(seed)
    A = random.standard_normal((n, n)) - 2.5 * n**0.5 * np.eye(n)
    P = Unknown("P", n, symmetric=True)
    blocks = Blocks([P, 20 * eye(n) - P, -he(A @ P) + eye(n)], [P])
    newton = blocks.newton
    x = np.zeros(newton.variables)
    for a in range(newton.variables):  # x of P = I
        change = newton.along(np.eye(newton.variables)[a])[0][0]
        x[a] = float(np.trace(change) > 0.5)
    x += 0.1 * random.standard_normal(len(x))
    S = newton.at(x)
    Z = []
    for s in S:  # not on the central path
        root = random.standard_normal(s.shape) / 3
        Z.append(np.linalg.inv(s) + root @ root.swapaxes(1, 2))
    return newton, x, S, Z, random.standard_normal(len(x))


CASES = [(2, 0), (3, 1), (4, 2)]


def one(stacks):
    """All matrices of a list of stacks on the diagonal of one."""
    return block_diag(*(m for stack in stacks for m in stack))


class Reference:
    """Newton's equations of S Z = target, in the coordinates of W's root."""

    def __init__(self, newton, S, Z, cost):
        S, Z = one(S), one(Z)
        root = np.real(sqrtm(S))
        inverse = np.linalg.inv(root)
        W = inverse @ np.real(sqrtm(root @ Z @ root)) @ inverse
        assert np.allclose(W @ S @ W, Z)
        self.Z, self.cost = Z, cost
        self.N, count = np.real(sqrtm(W)), newton.variables
        self.V = self.N @ S @ self.N
        self.slopes = [one(newton.along(unit)) for unit in np.eye(count)]

    def scaled(self, dS, dZ):
        """A change of S and one of Z in these coordinates."""
        back = np.linalg.inv(self.N)
        return self.N @ dS @ self.N, back @ dZ @ back

    def step(self, wanted):
        """Scaled dS, dZ whose linearised products change by ``wanted``."""
        size = len(self.V)
        kron = np.kron(self.V, np.eye(size)) + np.kron(np.eye(size), self.V)
        T = np.linalg.solve(kron / 2, wanted.ravel()).reshape(size, size)
        G = [self.N @ g @ self.N for g in self.slopes]
        H = np.array([[np.sum(a * b) for b in G] for a in G])
        g = np.array([np.sum(a * (self.V + T)) for a in G]) - self.cost
        dS = sum(d * a for d, a in zip(np.linalg.solve(H, g), G))
        return dS, T - dS

    def predicted(self):
        """dS and dZ towards S Z = 0, and Mehrotra's target after them."""
        dS, dZ = self.step(-self.V @ self.V)
        V = self.V
        longest = [
            min(1.0, 1 / -np.linalg.eigvals(np.linalg.solve(V, d)).real.min())
            for d in (dS, dZ)
        ]
        after = np.sum((V + longest[0] * dS) * (V + longest[1] * dZ))
        mu = np.sum(V * V) / len(V)
        return dS, dZ, (after / len(V) / mu) ** 3 * mu


def found(newton, x, S, Z, cost, target=None):
    """The module's step: dS and dZ as matrices, and the lengths."""
    scalings = [_Scaling(s, z) for s, z in zip(S, Z)]
    mu = newton.inner(S, Z) / newton.degree
    dx, dZ, *lengths = _direction(newton, scalings, x, mu, cost, target)
    return dx, one(newton.along(dx)), one(dZ), lengths


def without_predictor(newton):
    """Newton's equations as where they are solved by conjugate gradients."""
    names = "solver", "along", "adjoint", "inner", "degree", "settings", "variables"
    return SimpleNamespace(iterative=True, **{k: getattr(newton, k) for k in names})


@pytest.mark.parametrize("n, seed", CASES)
@pytest.mark.parametrize("target, corrected", [(None, True), (0.7, True), (0.7, False)])
def test_the_step_is_that_of_the_equations_from_scratch(n, seed, target, corrected):
    """Of S Z = target, or Mehrotra's; corrected, less the predictor's dS dZ."""
    newton, x, S, Z, cost = lyapunov(n, seed)
    about = Reference(newton, S, Z, cost)
    dS, dZ, mehrotra = about.predicted()
    V, error = about.V, (dS @ dZ + dZ @ dS) / 2
    assert np.linalg.norm(error) > 1e-3  # it could tell
    aim = (mehrotra if target is None else target) * np.eye(len(V)) - V @ V
    theirs = about.step(aim - corrected * error)
    way = newton if corrected else without_predictor(newton)
    _, *step, lengths = found(way, x, S, Z, cost, target)
    for mine, its, length in zip(about.scaled(*step), theirs, lengths):
        assert np.allclose(mine, its, atol=1e-9 * np.linalg.norm(its))
        inside = np.linalg.eigvalsh(V + length * mine).min()
        farther = np.linalg.eigvalsh(V + length / 0.95 * 1.001 * mine).min()
        assert inside > 0 and (length == 1 or farther < 0)
    # the dual equations hold after a whole step
    total = [np.sum(g * (about.Z + step[1])) for g in about.slopes]
    assert np.allclose(total, cost, atol=1e-9)
