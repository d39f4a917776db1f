"""The logarithmic barrier of blocks, and Newton's method on it.

-sum log det G_k(x) is self-concordant with the parameter nu, the sum of the
blocks' sizes (Nesterov and Nemirovskii 1994). The numbers of sections are those
of Boyd and Vandenberghe (2004), where each step is derived.
"""

import numpy as np

from .curve import Curve
from .stacks import gram

RATE_ROUNDING = 1e-10  # of the largest rate: a smaller one may be zero
MOST_DOUBLINGS = 30  # of a curve's length; there may be no end

CONVERGES_BELOW = 0.25  # a decrement that each step squares (section 9.6.4)
GROWTH_ABOVE = 1e-3  # what rounding leaves of a decrement near a centre is less
MOST_GROWTHS = 1  # of a decrement; rounding may have made one
LINE_SEARCH_ABOVE = 0.3  # a decrement; below, the full step converges (9.6.4)
LONGEST_CURVE = 4.0  # where it is tried first, by the best step on the line
MOST_PROMISED = 1.5  # decrements, by which a step shall lower the barrier at most
# a curve's term of this length is the last: far from the centre, and near
SMALL_TERM, LAST_TERM = 0.1, 1e-8


def grows(before, decrement):
    """True if a decrement grows, ``before`` which it was small enough to be squared.

    The equations are too ill-conditioned then, or there is no centre.
    """
    return before < CONVERGES_BELOW and decrement > max(before, GROWTH_ABOVE)


class Barrier:
    """Newton's method for weight * cost.x - sum log det G_k(x) of ``newton``.

    With a ``radius`` the barrier -log(radius^2 - x.x) of a ball is added.
    """

    def __init__(self, newton, radius=None):
        self.newton, self.radius = newton, radius
        self._last = None, None  # a point and its Cholesky factors
        self._inverses = None, None  # and theirs

    def factors(self, x):
        """Cholesky factors of all blocks at x, or None outside."""
        if self._last[0] is x:
            return self._last[1]
        if self.radius is not None and x @ x >= self.radius**2:
            return None
        try:
            factors = [np.linalg.cholesky(g) for g in self.newton.at(x)]
        except np.linalg.LinAlgError:
            return None
        self._last = x, factors
        return factors

    def roots(self, x):
        """Inverse Cholesky factors at x; a LinAlgError if rounding sees it outside."""
        factors = self.factors(x)
        if factors is None:
            raise np.linalg.LinAlgError("the point isn't inside")
        if self._inverses[0] is not x:
            self._inverses = x, [np.linalg.inv(L) for L in factors]
        return self._inverses[1]

    @np.errstate(over="ignore", invalid="ignore", divide="ignore")
    def step(self, x, cost, tolerance=0.1):
        """One damped Newton step from x for a ``cost``: the new x and the decrement.

        The direction solves H d = -gradient, that of the barrier being
        -adjoint(inv(G)), and conjugate gradients to a ``tolerance``; the decrement
        sqrt(-gradient.d) is the length of d in the norm of H (9.5). Where H has a
        factor the step follows a `Curve` on which the barrier falls by half the
        decrement's square, as by Newton's quadratic model, or by a few decrements where
        it is large; else one on which it falls by more than on the straight line, or
        that line.
        """
        roots = self.roots(x)
        factors = self.factors(x)
        gradient = cost - self.newton.adjoint(gram(roots))
        if self.radius is not None:
            gradient = gradient + 2 * x / (self.radius**2 - x @ x)
        solve = self.newton.solver(roots, x, self.radius)
        direction = -solve(gradient, tolerance)
        decrement = np.sqrt(max(-gradient @ direction, 0.0))
        curved = not self.newton.iterative
        bends = curved and decrement > self.newton.settings.straight_below
        searched = decrement > LINE_SEARCH_ABOVE  # else the full step converges
        change = self.newton.scaled(roots, direction) if bends or searched else None
        if bends:
            small = SMALL_TERM if searched else LAST_TERM
            curve = Curve(
                self.newton, roots, x, direction, change, solve, small, self.radius
            )
            promised = decrement * min(decrement / 2, MOST_PROMISED)
            least = -promised if searched else np.inf
            moved = self._along(curve, factors, cost, 1.0, least)
            if moved is not None:
                return moved, decrement
        length = 1.0
        if searched:
            length, least = self._on_line(x, direction, change, cost)
            if bends:
                moved = self._along(curve, factors, cost, length, least)
                if moved is not None:
                    return moved, decrement
        while True:  # rounding may put the end point outside
            moved = x + length * direction
            if self.factors(moved) is not None:
                return moved, decrement
            length /= 2
            if length < 1e-12:
                return x, 0.0

    def _along(self, curve, factors, cost, length, least):
        """A point on a curve where the barrier rises by less than ``least``, or None.

        Farther and farther points are looked at while it goes on falling; ``length`` is
        that of a step on the straight line.
        """
        if least == np.inf:
            moved = curve(curve.end)
            return moved if self.factors(moved) is not None else None
        begin = self._logarithms(factors)

        def change(t):
            moved = curve(t)
            factors = self.factors(moved)
            if factors is None:
                return np.inf, None
            rise = begin - self._logarithms(factors) + cost @ (moved - curve.x)
            rise += self._in_ball(curve.x, moved)
            return rise, (moved, factors)

        longest = LONGEST_CURVE * max(length, 1.0)
        t = min(curve.end, longest)
        for _ in range(3):
            fallen, best = change(t)
            if fallen < least:
                break
            t /= 2
        else:
            return None
        for _ in range(MOST_DOUBLINGS):  # the way may be long
            if t < longest:
                break
            longest *= 2
            t *= 2
            further, there = change(t)
            if not further < fallen:
                break
            fallen, best = further, there
        self._last = best
        return best[0]

    def _on_line(self, x, direction, change, cost):
        """The best length of a step on a straight line, and the rise with it."""
        rates, slope = _rates(change), cost @ direction
        length = self._search(x, direction, slope, rates)
        rise = length * slope - np.log1p(length * rates).sum()
        return length, rise + self._in_ball(x, x + length * direction)

    def _in_ball(self, x, moved):
        """The rise of the ball's barrier between two points inside."""
        if self.radius is None:
            return 0.0
        return np.log((self.radius**2 - x @ x) / (self.radius**2 - moved @ moved))

    def _logarithms(self, factors):
        """log det of all blocks, from their Cholesky factors."""
        return sum(2 * np.log(L.diagonal(0, 1, 2)).sum() for L in factors)

    def recedes(self, x, directions):
        """True if no block, from x inside, decreases along one of the directions."""
        roots = self.roots(x)
        rates = (_rates(self.newton.scaled(roots, d)) for d in directions)
        return any(r.min() > -RATE_ROUNDING * r.max() for r in rates)

    def _search(self, x, direction, slope, rates):
        """The s that minimises slope s - sum log(1 + s rate) and the ball's part, by
        Newton's method within an interval: with known rates that costs nothing (9.7.1).
        """
        limit = np.inf
        if rates.min() < 0:
            limit = -1 / rates.min()
        if self.radius is not None:
            a, b = direction @ direction, x @ direction
            inside = self.radius**2 - x @ x
            limit = min(limit, (np.sqrt(b * b + a * inside) - b) / a)
        s, low, high = min(1.0, 0.9 * limit), 0.0, limit
        for _ in range(30):
            ratio = rates / (1 + s * rates)
            first = slope - ratio.sum()
            second = ratio @ ratio
            if self.radius is not None:
                remaining = inside - 2 * s * b - s * s * a
                ratio = 2 * (b + s * a) / remaining
                first += ratio
                second += 2 * a / remaining + ratio**2
            if abs(first) < 1e-3 * np.sqrt(second):
                break
            low, high = (s, high) if first < 0 else (low, s)
            s = s - first / second
            if not low < s < high:
                s = (low + high) / 2 if np.isfinite(high) else 2 * low
        return min(s, 0.99 * limit)

    def descend(self, x, cost, tolerance, most=100):
        """``most`` steps for a ``cost`` from x, or to a decrement below ``tolerance``.

        It ends soon where rounding keeps the decrement from falling (see `grows`).
        """
        growths, decrement = 0, np.inf
        for _ in range(most):
            before = decrement
            x, decrement = self.step(x, cost)
            growths += grows(before, decrement)
            if decrement < tolerance or growths > MOST_GROWTHS:
                break
        return x

    def multipliers(self, x):
        """Inverse blocks at x: the dual point that belongs to a centre (11.6)."""
        roots = self.roots(x)
        return self.newton.unstacked(gram(roots))


def _rates(changes):
    """Eigenvalues r of scaled ``changes``: det G(x + s d) = det G(x) prod (1 + s r)."""
    return np.concatenate([np.linalg.eigvalsh(d).ravel() for d in changes])
