"""A primal-dual interior point method with Nesterov-Todd scaling.

It minimises cost.x over blocks G_k(x) > 0 from a point inside. With one
more variable t, raised until the blocks hold without it, it finds a
point inside, or sees that there is none. Both take the same few steps
whatever the size.
"""

import numpy as np

from .stacks import squares, transposed

__all__ = ["descend", "positive", "raise_blocks"]


class _Scaling:
    """R with inv(R) S inv(R') = R' Z R = diag(lam), block by block."""

    def __init__(self, S, Z):
        left, right = np.linalg.cholesky(S), np.linalg.cholesky(Z)
        U, self.lam, Vh = np.linalg.svd(transposed(right) @ left)
        size = 1 / np.sqrt(self.lam)
        self.back = size[..., None] * (transposed(U) @ transposed(right))

    def shrink(self, dS):
        """A change of S in these coordinates."""
        return self.back @ dS @ transposed(self.back)

    def grow(self, dZ):
        """A change of Z from these coordinates to the blocks' own."""
        return transposed(self.back) @ dZ @ self.back

    def diagonal(self):
        return self.lam[..., None] * np.eye(self.lam.shape[-1])

    def longest(self, changes):
        """For each change the longest step, 2 at most, that stays inside.

        That is, with diag(lam) + step * change > 0.
        """
        unit = 1 / np.sqrt(self.lam)
        white = unit[..., None] * np.array(changes) * unit[:, None, :]
        least = np.linalg.eigvalsh(white)[..., 0].min(axis=-1)
        return 1 / np.maximum(-least, 0.5)

    def divide(self, change):
        """T with (diag(lam) T + T diag(lam)) / 2 = change."""
        return 2 * change / (self.lam[..., None] + self.lam[:, None, :])


def raise_blocks(newton, x, most=60, watch=None):
    """Raise t, the last variable, until all blocks hold with t = 0.

    Parameters
    ----------
    newton : Newton
        Of blocks G_k(x) - t D_k with D_k > 0.
    x : (k + 1,) array
        All blocks are positive definite there.
    watch : callable, optional
        Called after each step with a dict: step, x, t, gap, residual,
        the step lengths and the iterations of conjugate gradients.

    Returns
    -------
    verdict : {"feasible", "infeasible", "undecided"}
        "infeasible" is a guess: t can't be raised to zero, says a dual
        point that isn't exact.
    x : (k + 1,) array
        The last point.
    """
    cost = np.zeros(len(x))
    cost[-1] = -1.0
    level = np.append(np.ones(len(x) - 1), 0.0)
    inverse = squares([
        np.linalg.inv(np.linalg.cholesky(s)) for s in newton.at(x)])
    weight = -newton.adjoint(inverse)[-1]  # then <D, Z> = 1
    for state in _steps(newton, x, cost, weight, most):
        x = state["x"]
        if watch is not None:
            watch(state | {"t": x[-1]})
        if x[-1] > 0 and positive(newton.at(x * level)):
            return "feasible", x * level
        if x[-1] + 1.1 * state["gap"] < 0 and state["residual"] < 1e-6:
            return "infeasible", x
    return "undecided", x


def descend(newton, x, cost, gap, most=40):
    """Minimise cost.x from a point inside.

    Parameters
    ----------
    newton : Newton
    x : (k,) array
    cost : (k,) array
    gap : float
        Stop when the optimum is known to this relative accuracy.

    Returns
    -------
    (x, bound) or None
        None where that accuracy isn't reached: there may be no minimum.
    """
    size = np.linalg.norm(cost)
    weight = newton.degree / max(abs(cost @ x), 1e-12)
    for state in _steps(newton, x, cost, weight, most):
        x, slack = state["x"], state["gap"]
        slack += state["residual"] * np.linalg.norm(x)
        if x @ x > 1e16:
            return None
        if state["residual"] < 1e-6 * size and slack < gap * abs(cost @ x):
            return x, cost @ x - slack
    return None


def _steps(newton, x, cost, weight, most):
    """Yield what is known after each step, until no step helps."""
    S = newton.at(x)
    Z = [s / weight for s in squares(
        [np.linalg.inv(np.linalg.cholesky(s)) for s in S])]
    for count in range(most):
        try:
            scales = [_Scaling(s, z) for s, z in zip(S, Z)]
            dx, dz, primal, dual = _direction(newton, scales, S, Z, x, cost)
        except np.linalg.LinAlgError:
            return
        if max(primal, dual) < 1e-8 or not np.isfinite(dx).all():
            return
        x = x + primal * dx
        Z = [z + dual * d for z, d in zip(Z, dz)]
        Z = [(z + transposed(z)) / 2 for z in Z]
        S = newton.at(x)
        yield dict(
            step=count + 1, x=x, gap=newton.inner(S, Z), primal=primal,
            residual=np.linalg.norm(cost - newton.adjoint(Z)), dual=dual,
            iterations=newton.iterations[-2:],
        )


def _direction(newton, scales, S, Z, x, cost):
    """Mehrotra's predictor and corrector, and the step lengths."""
    solve = newton.solver([s.back for s in scales], x)
    residual = cost - newton.adjoint(Z)
    mean = newton.inner(S, Z) / newton.degree

    def aim(targets):
        """The step with scaled dS + dZ = targets and a dual residual 0."""
        pull = newton.adjoint([s.grow(t) for s, t in zip(scales, targets)])
        dx = solve(pull - residual, 0.1)
        ds = [s.shrink(d) for s, d in zip(scales, newton.along(dx))]
        return dx, ds, [t - d for t, d in zip(targets, ds)]

    def longest(*changes):
        return np.min([s.longest(c) for s, *c in zip(scales, *changes)], 0)

    here = [s.diagonal() for s in scales]
    _, ds, dz = aim([-h for h in here])
    primal, dual = np.minimum(1, longest(ds, dz))
    after = newton.inner(
        [h + primal * d for h, d in zip(here, ds)],
        [h + dual * d for h, d in zip(here, dz)],
    ) / newton.degree
    target = min(max(after / mean, 0.0), 1.0) ** 3 * mean
    targets = [
        s.divide(target * np.eye(h.shape[-1]) - h @ h
                 - (a @ b + transposed(a @ b)) / 2)
        for s, h, a, b in zip(scales, here, ds, dz)
    ]
    dx, ds, dz = aim(targets)
    primal, dual = np.minimum(1, 0.95 * longest(ds, dz))
    return dx, [s.grow(d) for s, d in zip(scales, dz)], primal, dual


def positive(stacks):
    """Whether all matrices in all stacks are positive definite."""
    try:
        for s in stacks:
            np.linalg.cholesky(s)
    except np.linalg.LinAlgError:
        return False
    return True
