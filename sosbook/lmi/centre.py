"""Interior point: phase one, analytic centre, linear objectives.

Everything minimises, by Newton's method with an exact line search, the
self-concordant barrier of blocks G_k(x) > 0 that are affine in x.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.linalg.lapack import dtrtri

__all__ = [
    "Blocks", "Phase", "Unbounded", "centre", "margin", "minimize",
    "phase_one", "refine",
]


@dataclass(frozen=True, eq=False)
class Blocks:
    """Affine symmetric blocks G_k(x) = G_k0 + sum_a x_a G_ka.

    Parameters
    ----------
    constants : list of (q, q) arrays
    slopes : list of (k, q, q) arrays
        One slice for each of the k variables.
    """

    constants: list
    slopes: list

    @classmethod
    def of(cls, expressions, unknowns):
        """From `Affine` expressions in the given unknowns."""
        constants = [g.constant for g in expressions]
        slopes = [
            np.concatenate([g.jacobian(u) for u in unknowns])
            for g in expressions
        ]
        return cls(constants, slopes)

    @property
    def variables(self):
        return len(self.slopes[0])

    @property
    def degree(self):
        """Sum of the block sizes, the barrier's parameter."""
        return sum(len(c) for c in self.constants)

    def __call__(self, x):
        return [
            c + np.tensordot(x, s, 1)
            for c, s in zip(self.constants, self.slopes)
        ]

    def adjoint(self, Z):
        """sum_k <G_ka, Z_k> for each variable a."""
        return sum(
            np.tensordot(s, z, 2) for s, z in zip(self.slopes, Z)
        )

    def value(self, Z):
        """sum_k <G_k0, Z_k>."""
        return sum((c * z).sum() for c, z in zip(self.constants, Z))

    def scaled(self):
        """Diagonal congruence to entries near one (powers of two).

        Returns the blocks, and the factors by which their entries and
        multipliers are multiplied.
        """
        factors = []
        for c, s in zip(self.constants, self.slopes):
            size = np.abs(np.diag(c)) + np.sqrt(
                (np.diagonal(s, axis1=1, axis2=2) ** 2).sum(axis=0)
            )
            size[size == 0] = 1
            factors.append(2.0 ** np.round(-np.log2(size) / 2))
        outer = [np.outer(d, d) for d in factors]
        return Blocks(
            [c * o for c, o in zip(self.constants, outer)],
            [s * o for s, o in zip(self.slopes, outer)],
        ), outer


CERTAIN = 1e10  # a solution longer than this is none in floats


class Unbounded(ValueError):
    """Raised where a set has no analytic centre."""


class _Barrier:
    """Newton's method for weight * cost.x - sum log det G_k(x)."""

    def __init__(self, blocks, radius=None):
        self.blocks = blocks
        self.radius = radius
        self._sizes = [len(c) for c in blocks.constants]
        self._ends = np.cumsum([q * q for q in self._sizes])[:-1]
        k = blocks.variables
        self._constant = np.concatenate(
            [c.ravel() for c in blocks.constants]
        ).astype(float)
        self._slope = np.hstack(
            [s.reshape(k, -1) for s in blocks.slopes]
        ).astype(float)
        # left factors laid out for one matrix product each
        self._wide = [
            np.ascontiguousarray(s.transpose(1, 0, 2), float).reshape(
                s.shape[1], -1)
            for s in blocks.slopes
        ]

    def _split(self, flat):
        """A long vector as the list of its square blocks."""
        parts = np.split(flat, self._ends)
        return [x.reshape(q, q) for x, q in zip(parts, self._sizes)]

    def factors(self, x):
        """Cholesky factors of all blocks, or None outside."""
        if self.radius is not None and x @ x >= self.radius**2:
            return None
        try:
            return [
                np.linalg.cholesky(g)
                for g in self._split(self._constant + x @ self._slope)
            ]
        except np.linalg.LinAlgError:
            return None

    def _whiten(self, factors):
        """L^-1 G_ka L^-T of every block, each row a flat matrix."""
        white = []
        for L, wide in zip(factors, self._wide):
            q = len(L)
            inverse = dtrtri(L, lower=1)[0]
            half = (inverse @ wide).reshape(-1, q) @ inverse.T
            white.append(
                half.reshape(q, -1, q).transpose(1, 0, 2).reshape(-1, q * q)
            )
        return np.hstack(white)

    @np.errstate(over="ignore", invalid="ignore", divide="ignore")
    def step(self, x, cost):
        """One damped Newton step; returns the new x and the decrement."""
        factors = self.factors(x)
        white = self._whiten(factors)
        ones = np.concatenate([np.eye(q).ravel() for q in self._sizes])
        gradient = cost - white @ ones
        hessian = white @ white.T
        if self.radius is not None:
            room = self.radius**2 - x @ x
            gradient = gradient + 2 * x / room
            hessian += 2 / room * np.eye(len(x))
            hessian += np.outer(2 * x / room, 2 * x / room)
        idle = np.diag(hessian) == 0  # variables of no block
        hessian[idle, idle] = 1.0
        scale = 1 / np.sqrt(np.diag(hessian))
        factor = _cholesky(hessian * np.outer(scale, scale))
        direction = -scale * cho_solve(
            factor, scale * gradient, check_finite=False
        )
        decrement = np.sqrt(max(-gradient @ direction, 0.0))
        rates = np.concatenate([
            np.linalg.eigvalsh(d) for d in self._split(direction @ white)
        ])
        length = self._search(x, direction, cost @ direction, rates)
        while True:  # rounding may put the end point outside
            moved = x + length * direction
            if self.factors(moved) is not None:
                return moved, decrement
            length /= 2
            if length < 1e-12:
                return x, 0.0

    def _search(self, x, direction, slope, rates):
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
            first, second = slope - ratio.sum(), (ratio**2).sum()
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
        inverses = [dtrtri(L, lower=1)[0] for L in self.factors(x)]
        return [inverse.T @ inverse for inverse in inverses]


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


def phase_one(blocks, radius=1e4, wide=1e8):
    """Find x with all G_k(x) > 0, or multipliers that exclude it.

    Maximises t subject to G_k(x) > t I along the central path, inside
    the ball |x| < radius, and stops as soon as t is known to be
    positive or known to stay negative. Where all blocks are homogeneous
    the first one, X > 0, is read as X > I, which changes nothing but
    excludes x = 0. Where only the ball stands in the way, the larger
    ball ``wide`` is tried. "infeasible" says that there is no solution
    within ``reach``, half the radius or more, and that none was found
    beyond.

    Returns
    -------
    Phase
    """
    given = blocks
    if not any(c.any() for c in blocks.constants):
        first = -np.eye(len(blocks.constants[0]))
        blocks = Blocks([first] + blocks.constants[1:], blocks.slopes)
    blocks, outer = blocks.scaled()
    k = blocks.variables
    lifted = Blocks(
        blocks.constants,
        [
            np.concatenate([s, -np.eye(s.shape[1])[None]])
            for s in blocks.slopes
        ],
    )
    start = min(np.linalg.eigvalsh(c)[0] for c in blocks.constants)
    x = np.append(np.zeros(k), min(start, 0) - 1)
    radius = max(radius, 10 * abs(x[-1]))  # the ball holds the start
    barrier = _Barrier(lifted, radius)
    cost = np.zeros(k + 1)
    cost[-1] = -1.0
    strict = _Barrier(blocks)
    weight = 1.0
    while weight < 1e13:
        for _ in range(300):
            x, decrement = barrier.step(x, weight * cost)
            if x[-1] > 0 and strict.factors(x[:-1]) is not None:
                return Phase("feasible", x=x[:-1])
            if decrement < 0.1:
                break
        else:
            return Phase("undecided", near=x[:-1])
        # at a centre, t* <= t + (degree + ball) / weight
        if x[-1] + 2 * (lifted.degree + 1) / weight < 0:
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
            Z = [z * o for z, o in zip(Z, outer)]
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


def centre(blocks, x):
    """The analytic centre, from a strictly feasible point.

    Raises
    ------
    Unbounded
        If the set is unbounded: it has no centre.
    """
    barrier = _Barrier(blocks)
    zero = np.zeros(len(x))
    for _ in range(200):
        x, decrement = barrier.step(x, zero)
        if decrement < 1e-8:
            return barrier.step(x, zero)[0]
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
    barrier = _Barrier(blocks)
    weight = blocks.degree / max(abs(cost @ x), 1e-12)
    for _ in range(20):
        try:
            x = barrier.descend(x, weight * cost, 0.1)
        except np.linalg.LinAlgError:
            break
        if x @ x > 1e16:
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
