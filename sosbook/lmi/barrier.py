"""The logarithmic barrier of blocks, and Newton's method on it.

-sum log det G_k(x) is self-concordant with the parameter nu, the sum of the
blocks' sizes (Nesterov and Nemirovskii 1994). The numbers of sections are those
of Boyd and Vandenberghe (2004), where each step is derived.
"""

import numpy as np

from .stacks import gram, transposed

__all__ = ["Barrier"]

RATE_ROUNDING = 1e-10  # of the largest rate: a smaller one may be zero
LINE_SEARCH_ABOVE = 0.2  # a decrement; smaller ones are squared by a full step


class Barrier:
    """Newton's method for weight * cost.x - sum log det G_k(x).

    With a radius the barrier -log(radius^2 - x.x) of a ball is added.

    Parameters
    ----------
    newton : Newton
        The blocks G_k, affine in x.
    radius : float, optional
        The radius of the ball; without it there is none.
    """

    def __init__(self, newton, radius=None):
        self.newton = newton
        self.radius = radius
        self._last = None, None  # a point and its Cholesky factors

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

    @np.errstate(over="ignore", invalid="ignore", divide="ignore")
    def step(self, x, cost, tolerance=0.1):
        """One damped Newton step from x; returns the new x and the decrement.

        ``cost`` is a (k,) array; ``tolerance`` is that of conjugate gradients.

        The gradient of the barrier is -adjoint(inv(G)); the direction solves
        H d = -gradient, and the decrement is sqrt(-gradient.d), the length of
        d in the norm of H (section 9.5).
        """
        factors = self.factors(x)
        if factors is None:
            raise np.linalg.LinAlgError("the point isn't inside")
        roots = [np.linalg.inv(L) for L in factors]
        gradient = cost - self.newton.adjoint(gram(roots))
        if self.radius is not None:
            gradient = gradient + 2 * x / (self.radius**2 - x @ x)
        solve = self.newton.solver(roots, x, self.radius)
        direction = -solve(gradient, tolerance)
        decrement = np.sqrt(max(-gradient @ direction, 0.0))
        length = 1.0
        if decrement > LINE_SEARCH_ABOVE:  # below it the full step converges
            rates, weights = self._rates(roots, direction)
            length = self._search(x, direction, cost @ direction, rates, weights)
        while True:  # rounding may put the end point outside
            moved = x + length * direction
            if self.factors(moved) is not None:
                return moved, decrement
            length /= 2
            if length < 1e-12:
                return x, 0.0

    def recedes(self, x, direction):
        """Whether all points from x, inside, along a direction are inside, too.

        Then no block decreases along it: up to rounding no rate is negative.
        """
        roots = [np.linalg.inv(L) for L in self.factors(x)]
        rates, _ = self._rates(roots, direction)
        return rates.min() > -RATE_ROUNDING * rates.max()

    def _rates(self, roots, direction):
        """Eigenvalues r of inv(L) dG inv(L') for all blocks, and their weights.

        Along the direction det G(x + s d) = det G(x) prod (1 + s r).
        """
        rates = [
            np.linalg.eigvalsh(N @ d @ transposed(N)).ravel()
            for N, d in zip(roots, self.newton.along(direction))
        ]
        weights = [np.full(len(r), s.weight) for r, s in zip(rates, self.newton.stacks)]
        return np.concatenate(rates), np.concatenate(weights)

    def _search(self, x, direction, slope, rates, weights):
        """The s that minimises slope s - sum log(1 + s rate), and the ball's part.

        Newton's method on the derivative, kept within an interval: an exact
        line search costs nothing once the rates are known (section 9.7.1).
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
            first = slope - weights @ ratio
            second = weights @ ratio**2
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
        """At most ``most`` steps from x, until the decrement is below a tolerance.

        ``cost`` is a (k,) array, and the last x is returned.
        """
        for _ in range(most):
            x, decrement = self.step(x, cost)
            if decrement < tolerance:
                return x
        return x

    def multipliers(self, x):
        """Inverse blocks at x: the dual point that belongs to a centre (11.6)."""
        roots = [np.linalg.inv(L) for L in self.factors(x)]
        return self.newton.unstacked(gram(roots))
