r"""Newton's direction, bent on the way to the centre.

On a curve x(s) the barrier's gradient shall be 1 - s times that at x = x(0): then
x(1) is the centre, and the first term of

    x(s) = x + s a_1 + s^2 a_2 + ...

is Newton's direction. In coordinates in which each block is the identity at x, it
is I + s D_1 + s^2 D_2 + ... on the curve, where D_k = N dG(a_k) N' is made from the
block's change along a_k. Its inverse is I + s B_1 + s^2 B_2 + ... with

    B_k = -D_k - C_k,    C_k = D_1 B_(k-1) + ... + D_(k-1) B_1.

The gradient is the adjoint of the inverse, and has no terms of s^2 and more, so that
H a_k = -adjoint(N' C_k N) for k > 1. One factor of Newton's matrix H solves all of
them, and each takes a small part of the time in which H is made.

The series ends at the first pole of x(s), and a valley that leads far away has one
soon after s = 1. So it is summed as a fraction with one pole (Padé's approximant),

    x(s) = x + (s e_1 + s^2 e_2 + ...) / (1 - s rho),    e_k = a_k - rho a_(k-1),

where rho is what a_2 is along a_1, in the norm of H.
"""

import numpy as np

MOST_TERMS = 8  # of the series; sixteen save one step in twenty
FARTHEST_POLE = 0.9  # where the sum of the series is at most ten times as far


class Curve:
    """The curve of the module's head, as a function of t = s / (1 - s rho).

    At x, with ``newton``'s blocks and their ``roots``, ``direction`` is Newton's,
    ``change`` the `Stacked.scaled` blocks along it, and ``solve(g)`` the d with H d =
    g. A term shorter than ``small`` in the norm of H is the last; with a ``radius`` a
    ball's barrier belongs to the gradient. ``end`` is the t of the centre.
    """

    def __init__(self, newton, roots, x, direction, change, solve, small, radius=None):
        """Compute the terms of the curve until its radius is known."""
        self.x = x
        inverse, ball = [_Inverse(d) for d in change], _Ball(x, radius, direction)
        self.rho, self.end, self.terms = 0.0, 1.0, [direction]
        last, squared = direction, newton.inner(change, change)
        squared += ball.inner(last, last)
        for k in range(2, MOST_TERMS + 1):
            known = [series.products() for series in inverse]
            term = -solve(newton.scaled_adjoint(roots, known) + ball.products())
            ball.append(term)
            before, change = change, newton.scaled(roots, term)
            if k == 2:
                along = newton.inner(before, change) + ball.inner(last, term)
                self.rho = max(along / squared, 0.0)
                self.end = 1 / (1 - min(self.rho, FARTHEST_POLE))
            self.terms.append(term - self.rho * last)
            rest = [d - self.rho * b for d, b in zip(change, before)]
            left = newton.inner(rest, rest) + ball.inner(self.terms[-1], self.terms[-1])
            if not self.end * np.sqrt(left) > small:
                break
            last = term
            for series, d, c in zip(inverse, change, known):
                series.append(d, c)

    def __call__(self, t):
        """The point at t = s / (1 - s rho), a (k,) array."""
        s, total = t / (1 + t * self.rho), self.terms[-1]
        for e in self.terms[-2::-1]:
            total = e + s * total
        return self.x + t * total


class _Inverse:
    """The series of the inverse of I + s D_1 + s^2 D_2 + ..., of one stack."""

    def __init__(self, first):
        self.changes, self.terms = [first], [-first]

    def append(self, change, products):
        """Add the next D_k and its B_k, which needs the ``products`` C_k."""
        self.changes.append(change)
        self.terms.append(-change - products)

    def products(self):
        """C_k of the first k that isn't known."""
        total = self.changes[0] @ self.terms[-1]
        for change, term in zip(self.changes[1:], self.terms[-2::-1]):
            total += change @ term
        return total


class _Ball:
    """The series of the gradient 2 x / (radius^2 - x.x), and its part of H's norm."""

    def __init__(self, x, radius, direction):
        self.radius, self.x = radius, [x]
        if radius is not None:
            self.inside = [radius**2 - x @ x]  # the series of radius^2 - x.x
            self.inverse = [1 / self.inside[0]]
            self.append(direction)

    def append(self, term):
        """Add the next term of x."""
        if self.radius is None:
            return
        self.x.append(term)
        self.inside.append(-sum(a @ b for a, b in zip(self.x, self.x[::-1])))
        self.inverse.append(self._next(self.inside))

    def _next(self, inside):
        pairs = zip(inside[1:], self.inverse[::-1])
        return -self.inverse[0] * sum(s * q for s, q in pairs)

    def products(self):
        """The next term of the gradient, if that of x were zero."""
        if self.radius is None:
            return 0.0
        inside = [*self.inside, -sum(a @ b for a, b in zip(self.x[1:], self.x[:0:-1]))]
        inverse = [*self.inverse, self._next(inside)]
        return 2 * sum(x * q for x, q in zip(self.x, inverse[:0:-1]))

    def inner(self, a, b):
        if self.radius is None:
            return 0.0
        q, x = self.inverse[0], self.x[0]
        return 2 * q * (a @ b) + 4 * q**2 * (x @ a) * (x @ b)
