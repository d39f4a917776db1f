"""Interior point: phase one, analytic centre, linear objectives.

Everything minimises, by Newton's method with an exact line search, the
self-concordant barrier of blocks G_k(x) > 0 that are affine in x.
"""

from dataclasses import dataclass

import numpy as np

from .blocks import Blocks
from .newton import Newton, newton_of
from .primal_dual import descend, positive, raise_blocks
from .stacks import squares, transposed

__all__ = [
    "Blocks", "Phase", "Unbounded", "centre", "margin", "minimize",
    "phase_one", "refine",
]


CERTAIN = 1e9  # a solution longer than this is none in floats


class Unbounded(ValueError):
    """Raised where a set has no analytic centre."""


class _Barrier:
    """Newton's method for weight * cost.x - sum log det G_k(x)."""

    def __init__(self, newton, radius=None):
        self.newton = newton
        self.radius = radius
        self._known = None, None

    def factors(self, x):
        """Cholesky factors of all blocks, or None outside."""
        if self._known[0] is x:
            return self._known[1]
        if self.radius is not None and x @ x >= self.radius**2:
            return None
        try:
            found = [np.linalg.cholesky(g) for g in self.newton.at(x)]
        except np.linalg.LinAlgError:
            return None
        self._known = x, found
        return found

    @np.errstate(over="ignore", invalid="ignore", divide="ignore")
    def step(self, x, cost, tolerance=0.1):
        """One damped Newton step; returns the new x and the decrement."""
        roots = [np.linalg.inv(L) for L in self.factors(x)]
        gradient = cost - self.newton.adjoint(squares(roots))
        if self.radius is not None:
            gradient = gradient + 2 * x / (self.radius**2 - x @ x)
        solve = self.newton.solver(roots, x, self.radius)
        direction = -solve(gradient, tolerance)
        decrement = np.sqrt(max(-gradient @ direction, 0.0))
        length = 1.0
        if decrement > 0.2:  # otherwise Newton's step is as good
            rates, weights = self._rates(roots, direction)
            length = self._search(
                x, direction, cost @ direction, rates, weights)
        while True:  # rounding may put the end point outside
            moved = x + length * direction
            if self.factors(moved) is not None:
                return moved, decrement
            length /= 2
            if length < 1e-12:
                return x, 0.0

    def _rates(self, roots, direction):
        """Eigenvalues of the whitened change of the blocks, weights."""
        rates = [
            np.linalg.eigvalsh(N @ d @ transposed(N)).ravel()
            for N, d in zip(roots, self.newton.along(direction))
        ]
        weights = [
            np.full(len(r), s.weight)
            for r, s in zip(rates, self.newton.stacks)
        ]
        return np.concatenate(rates), np.concatenate(weights)

    def _search(self, x, direction, slope, rates, weights):
        """Minimise slope s - sum log(1 + s rate) (minus the ball's)."""
        limit = np.inf
        if rates.min() < 0:
            limit = -1 / rates.min()
        if self.radius is not None:
            a, b = direction @ direction, x @ direction
            room = self.radius**2 - x @ x
            limit = min(limit, (np.sqrt(b * b + a * room) - b) / a)
        s, low, high = min(1.0, 0.9 * limit), 0.0, limit
        for _ in range(30):
            ratio = rates / (1 + s * rates)
            first = slope - weights @ ratio
            second = weights @ ratio**2
            if self.radius is not None:
                left = room - 2 * s * b - s * s * a
                bend = 2 * (b + s * a) / left
                first += bend
                second += 2 * a / left + bend**2
            if abs(first) < 1e-3 * np.sqrt(second):
                break
            low, high = (s, high) if first < 0 else (low, s)
            s = s - first / second
            if not low < s < high:
                s = (low + high) / 2 if np.isfinite(high) else 2 * low
        return min(s, 0.99 * limit)

    def descend(self, x, cost, tolerance, most=100):
        """Newton steps until the decrement falls below the tolerance."""
        for _ in range(most):
            x, decrement = self.step(x, cost)
            if decrement < tolerance:
                return x
        return x

    def multipliers(self, x):
        """Inverse blocks: the dual point that belongs to a centre."""
        roots = [np.linalg.inv(L) for L in self.factors(x)]
        return self.newton.unstacked(squares(roots))


@dataclass(frozen=True, eq=False)
class Phase:
    """Outcome of phase one.

    Parameters
    ----------
    verdict : {"feasible", "infeasible", "undecided"}
    x : array or None
        A strictly feasible point.
    Z : list of arrays or None
        Multipliers of an infeasibility proof: Z_k > 0,
        sum <G_ka, Z_k> = 0 for all a, sum <G_k0, Z_k> <= 0.
    near : array or None
        Where no feasible point was found: the least infeasible one.
    reach : float
        No feasible point is shorter than this.
    """

    verdict: str
    x: np.ndarray = None
    Z: list = None
    near: np.ndarray = None
    reach: float = 0.0


def phase_one(blocks, radius=1e4, wide=1e8, start=None, watch=None,
              multipliers=True):
    """Find x with all G_k(x) > 0, or multipliers that exclude it.

    Maximises t subject to G_k(x) > t I along the central path, inside
    the ball |x| < radius, and stops as soon as t is known to be
    positive or known to stay negative. Where all blocks are homogeneous
    the first one, X > 0, is read as X > I, which changes nothing but
    excludes x = 0. Where only the ball stands in the way, the larger
    ball ``wide`` is tried. "infeasible" says that there is no solution
    within ``reach``, half the radius or more, and that none was found
    beyond.

    Parameters
    ----------
    blocks : Blocks
    radius, wide : float
        Of the balls.
    start : array, optional
        Where to start from, if that is better than 0.
    watch : callable, optional
        See `raise_blocks`.
    multipliers : bool
        Without them what isn't found feasible is "undecided", sooner.

    Returns
    -------
    Phase
    """
    if start is not None and positive(newton_of(blocks).at(start)):
        return Phase("feasible", x=start)
    given = blocks
    if not any(c.any() for c in blocks.constants):
        first = -np.eye(len(blocks.constants[0]))
        blocks = blocks.with_constants([first, *blocks.constants[1:]])
    # t is raised in units in which the blocks' diagonals are near one
    newton = Newton(blocks, [-np.diag(1 / d**2) for d in blocks.sizes])
    x = np.zeros(blocks.variables)
    least, below = _least(newton, blocks, x), 1.0
    if start is not None and (better := _least(newton, blocks, start)) > least:
        x, least, below = start, better, max(abs(better), 0.1)
    x = np.append(x, min(least, 0) - below)
    verdict, near = raise_blocks(newton, x, watch=watch)
    if verdict == "feasible":
        return Phase("feasible", x=near[:-1])
    if not multipliers:
        return Phase("undecided", near=near[:-1])
    weight = 1.0
    if verdict == "infeasible":
        near[-1] *= 2
        if _Barrier(newton).factors(near) is not None:
            x = near
            while 8 * weight < -2 * blocks.degree / x[-1]:
                weight *= 8  # t < 0 can't be seen with so little
    return _central_path(given, blocks, newton, x, weight, radius, wide)


def _least(newton, blocks, x):
    """The smallest eigenvalue of all blocks, their diagonals near one."""
    return min(
        np.linalg.eigvalsh(g * np.outer(d, d))[0]
        for g, d in zip(
            newton.unstacked(newton.at(np.append(x, 0.0))), blocks.sizes)
    )


def _central_path(given, blocks, newton, x, weight, radius, wide):
    """Phase one inside a ball, until t is positive or stays negative."""
    radius = max(radius, 10 * np.linalg.norm(x))  # the ball holds the start
    barrier = _Barrier(newton, radius)
    cost = np.zeros(len(x))
    cost[-1] = -1.0
    level = np.append(np.ones(len(x) - 1), 0.0)
    while weight < 1e13:
        for _ in range(300):
            x, decrement = barrier.step(x, weight * cost)
            if x[-1] > 0 and barrier.factors(x * level) is not None:
                return Phase("feasible", x=x[:-1])
            if decrement < 0.1:
                break
        else:
            return Phase("undecided", near=x[:-1])
        # at a centre, t* <= t + (degree + ball) / weight
        if x[-1] + 2 * (blocks.degree + 1) / weight < 0:
            x = barrier.descend(x, weight * cost, 1e-9, 20)
            Z = [z / weight for z in barrier.multipliers(x)]
            reach = _excluded_radius(blocks, Z)
            if reach < CERTAIN:
                Z = refine(blocks, Z)
                reach = _excluded_radius(blocks, Z)
            verdict = "infeasible" if reach >= radius / 2 else "undecided"
            if reach < wide / 2 and radius < wide:
                further = phase_one(given, wide)
                if further.x is not None or verdict == "undecided":
                    return further
            return Phase(verdict, Z=Z, near=x[:-1], reach=reach)
        weight *= 8
    return Phase("undecided", near=x[:-1])


def _excluded_radius(blocks, Z):
    """No feasible x is shorter than this, if all Z_k > 0."""
    value, residual = blocks.value(Z), blocks.adjoint(Z)
    size = np.linalg.norm(residual)
    return 0.0 if value >= 0 else (-value / size if size else np.inf)


def refine(blocks, Z):
    """Multipliers that satisfy sum <G_ka, Z_k> = 0 more closely.

    Each Z_k = L L' becomes L (I + X) L' with the smallest X_k: that
    spares the small eigenvalues of Z_k.
    """
    slopes = [s.astype(float) for s in blocks.slopes]
    try:
        factors = [np.linalg.cholesky(z) for z in Z]
    except np.linalg.LinAlgError:
        return Z
    white = [L.T @ s @ L for L, s in zip(factors, slopes)]
    rows = np.hstack([h.reshape(len(h), -1) for h in white])
    size = np.linalg.norm(rows, axis=1)
    rows = rows / np.where(size == 0, 1, size)[:, None]
    ones = np.concatenate([np.eye(len(L)).ravel() for L in factors])
    X = -np.linalg.lstsq(rows, rows @ ones, rcond=1e-12)[0]
    ends = np.cumsum([L.size for L in factors])[:-1]
    changes = [x.reshape(L.shape) for L, x in zip(factors, np.split(X, ends))]
    if min(np.linalg.eigvalsh(x)[0] for x in changes) <= -1:
        return Z
    return [L @ (np.eye(len(L)) + x) @ L.T for L, x in zip(factors, changes)]


def centre(blocks, x, watch=None, enough=None):
    """The analytic centre, from a strictly feasible point.

    Parameters
    ----------
    blocks : Blocks
    x : array
    watch : callable, optional
        Called after each Newton step with a dict: step, x, decrement and
        the iterations of conjugate gradients.
    enough : float, optional
        Stop at a smaller decrement than this.

    Raises
    ------
    Unbounded
        If the set is unbounded: it has no centre.
    """
    newton = newton_of(blocks)
    barrier = _Barrier(newton)
    zero, decrement = np.zeros(len(x)), 1.0
    # a step leaves decrement^2, or as much as its equations were solved to
    enough = enough or (1e-3 if newton.iterative else 1e-8)
    for count in range(200):
        x, decrement = barrier.step(x, zero, min(0.1, decrement))
        if watch is not None:
            watch(dict(step=count + 1, x=x, decrement=decrement,
                       iterations=newton.iterations[-1:]))
        if decrement < enough:
            return x
        if x @ x > 1e16:
            break
    raise Unbounded(
        "the feasible set is unbounded and has no analytic centre"
    )


def minimize(blocks, cost, x, gap=1e-6):
    """Minimise cost.x over the blocks, from a strictly feasible point.

    Parameters
    ----------
    gap : float
        Stop when the optimum is known to this relative accuracy.

    Returns
    -------
    x : array
        Strictly feasible, nearly optimal.
    bound : float
        A lower bound of the optimum.

    Raises
    ------
    Unbounded
        If no such point is found: the infimum is zero or isn't attained.
    """
    newton = newton_of(blocks)
    found = descend(newton, x, cost, gap)
    if found is not None and _Barrier(newton).factors(found[0]) is not None:
        return found
    barrier = _Barrier(newton)
    weight = blocks.degree / max(abs(cost @ x), 1e-12)
    for _ in range(20):
        try:
            x = barrier.descend(x, weight * cost, 0.1)
        except np.linalg.LinAlgError:
            break
        if np.abs(x).max() > 1e100 or x @ x > 1e16:
            break
        slack = 2 * blocks.degree / weight
        if slack < gap * abs(cost @ x):
            return x, cost @ x - slack
        weight *= 8
    raise Unbounded("the infimum is zero or isn't attained")


def margin(g):
    """Smallest eigenvalue after scaling the diagonal to one."""
    diagonal = np.diag(g)
    if diagonal.min() <= 0:
        return float(diagonal.min())
    scale = 1 / np.sqrt(diagonal)
    return float(np.linalg.eigvalsh(g * np.outer(scale, scale))[0])
