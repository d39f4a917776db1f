"""Poles, norms and peaks of loops that are too sensitive for floats: quotients of
rational polynomials, of matrices read as decimals, evaluated with many digits.
"""

from contextlib import contextmanager
from contextvars import ContextVar

import numpy as np
from flint import acb, acb_mat, acb_poly, ctx, fmpq, fmpq_mat, fmpq_poly
from scipy.linalg import matrix_balance

from ..bisection import lowest
from ..exact.definite import exact
from .peaks import ALIVE, DOUBLINGS, amplitude, largest_size

POLYNOMIAL_BITS = 320  # of the arithmetic in which polynomials are evaluated
MOST_STATES = 60  # up to which the characteristic polynomial is computed
LARGEST_POLE_ERROR = 1e-5  # relative; beyond it floats don't know a pole
SEARCH_POINTS = 400  # frequencies of the first, coarse search
MOST_RUNS = 100  # in search of a peak

_asked = ContextVar("asked", default=True)


def sensitive(d, K):
    """True if rounding errors may show in the poles of a `Descriptor` d under u = K x:
    an eigenvalue's error, to first order, exceeds 1e-5 of it or hides its real part's
    sign.

    Source: Golub and Van Loan, Matrix Computations, section 7.2.2: an eigenvalue moves
    by |y| |x| / |y x| times the norm of a change of the matrix. That norm is taken
    after balancing, and of the terms A and B K before they cancel.
    """
    with np.errstate(all="ignore"):
        back = np.linalg.inv(d.E)
        A = back @ (d.A + d.Bu @ K)
        terms = np.abs(back) @ (np.abs(d.A) + np.abs(d.Bu) @ np.abs(K))
        if not np.isfinite(terms).all():
            return True
        balanced, (scale, _) = matrix_balance(A, permute=False, separate=True)
        terms = terms * np.outer(1 / scale, scale)
        try:
            poles, right = np.linalg.eig(balanced)
            both = (np.linalg.inv(right), 1), (right, 0)
        except np.linalg.LinAlgError:
            return True
        left, right = (np.linalg.norm(x, axis=k) for x, k in both)
        error = np.finfo(float).eps * np.linalg.norm(terms) * (left * right)
        known = np.minimum(LARGEST_POLE_ERROR * np.abs(poles), np.abs(poles.real))
        return bool((error > known).any())


def in_rationals(d, K):
    """True if the loop of d and K is small enough, and too sensitive for floats, unless
    these shall answer alone.
    """
    return _asked.get() and ExactLoop.fits(d) and sensitive(d, K)


@contextmanager
def floats_alone():
    """Nobody asks whether a loop is `sensitive`: to search, not to know."""
    before = _asked.set(False)
    try:
        yield
    finally:
        _asked.reset(before)


class ExactLoop:
    """The loop E x' = (A + B K) x + B_w w of a `Descriptor` d in rationals."""

    def __init__(self, d, K):
        E, A, B, gain, Bw, C = map(_flint, (d.E, d.A, d.Bu, K, d.Bw, d.C))
        if d.Du is not None:
            C = C + _flint(d.Du) * gain
        solved = E.inv()
        self.A, self.Bw, self.K = solved * (A + B * gain), solved * Bw, gain
        self.D = None if d.Dw is None else _flint(d.Dw)
        if d.Ca is not None:
            rates = _flint(d.Ca)
            C, through = C + rates * self.A, rates * self.Bw
            self.D = through if self.D is None else self.D + through
        self.C = C
        self.chi = self.A.charpoly()

    @staticmethod
    def fits(d):
        """True if the loop of a plant d is small enough."""
        return len(d.E) <= MOST_STATES

    def poles(self):
        """The poles as complex floats, each as often as it counts."""
        poles = []
        with ctx.workprec(POLYNOMIAL_BITS):
            for root, count in self.chi.complex_roots():
                mid = root.mid()
                poles += count * [complex(float(mid.real), float(mid.imag))]
        return np.array(poles)

    def hinf_norm(self):
        """The largest gain from w to the output on the imaginary axis, searched on a
        grid of frequencies, which is refined where it is largest.
        """
        poles = self.poles()
        if poles.real.max() >= 0:
            return np.inf
        numerators = self._numerators(self.C, self.Bw)
        through = [] if self.D is None else self.D.table()
        D = np.array([[_float(x) for x in row] for row in through] or [[0.0]])

        def gain(log_omega):
            with ctx.workprec(POLYNOMIAL_BITS):
                s = acb(0, float(np.exp(log_omega)))
                below = acb_poly(self.chi)(s)
                table = [[(n(s) / below).mid() for n in row] for row in numerators]
            return np.linalg.norm(np.array(table, complex) + D, 2)

        sizes = np.abs(poles)
        ends = np.log(sizes.min()) - 7, np.log(sizes.max()) + 7
        near = *np.log(sizes), *np.log(np.abs(poles.imag) + sizes / 1e3)
        grid = np.sort([*np.linspace(*ends, SEARCH_POINTS), *near])
        return float(max(_highest(gain, grid), np.linalg.norm(D, 2)))

    def peak_input(self, x0, inputs=None):
        """The largest |K x(t)| of some ``inputs`` from x0; None of double poles."""
        poles = self.poles()
        if poles.real.max() >= 0:
            return np.inf
        if self.chi.gcd(self.chi.derivative()).degree() > 0:
            return None
        start = _flint(np.asarray(x0, float)[:, None])
        rows = [row[0] for row in self._numerators(self.K, start)]
        rows = rows if inputs is None else [rows[i] for i in inputs]
        with ctx.workprec(POLYNOMIAL_BITS):
            roots = [root for root, _ in self.chi.complex_roots()]
            slope = acb_poly(self.chi.derivative())
            parts = [[n(s) / slope(s) for s in roots] for n in rows]
            return largest_size(_Waves(roots, parts), MOST_RUNS)

    def _numerators(self, C, B):
        """The numerators of C (s - A)^-1 B: acb polynomials, in rows and columns."""
        N, power, markov = self.A.nrows(), B, []
        for _ in range(N):
            markov.append((C * power).table())
            power = self.A * power
        chi = [self.chi[k] for k in range(N + 1)]

        def numerator(i, j):
            # the polynomial part of chi(s) (h0 / s + h1 / s^2 + ...)
            h = [table[i][j] for table in markov]
            terms = ([x * y for x, y in zip(chi[p + 1 :], h)] for p in range(N))
            return acb_poly(fmpq_poly([sum(x, fmpq(0)) for x in terms]))

        rows, columns = range(C.nrows()), range(B.ncols())
        with ctx.workprec(POLYNOMIAL_BITS):
            return [[numerator(i, j) for j in columns] for i in rows]


class _Waves:
    """Signals that are sums of ``parts[i][k] exp(roots[k] t)``: see `largest_size`."""

    def __init__(self, roots, parts):
        self.roots, self.poles, self.now = roots, np.array(list(map(complex, roots))), 0
        self.weights = [acb_mat(parts)]  # of u, u' and u''
        for _ in range(2):
            parts = [[p * s for p, s in zip(row, roots)] for row in parts]
            self.weights.append(acb_mat(parts))
        table = self.weights[0].table()
        self.parts = np.array([[complex(p) for p in row] for row in table])

    def _decayed(self):
        return self.parts * np.exp(self.poles.real * self.now)

    def alive(self, top):
        """Which modes haven't died out, beside a ``top`` that is known."""
        return np.linalg.norm(self._decayed(), axis=0) > ALIVE * top

    def run(self, step):
        """u and u' at samples every ``step``; the motion goes on."""
        self.begun, self.step = self.now, step
        waves = [[(s * self.now).exp()] for s in self.roots]
        for k in range(DOUBLINGS):
            forward = [(s * step * 2**k).exp() for s in self.roots]
            waves = [row + [f * w for w in row] for row, f in zip(waves, forward)]
        self.now += step * 2**DOUBLINGS
        for row, s in zip(waves, self.roots):
            row.append((s * self.now).exp())
        waves = acb_mat(waves)
        return tuple(_reals(weight * waves) for weight in self.weights[:2])

    def near(self, k, t):
        """u, u' and u'' at a time ``t`` after the ``k``-th sample of the last run."""
        t = self.begun + k * self.step + t
        waves = acb_mat([[(s * t).exp()] for s in self.roots])
        return tuple(_reals(weight * waves)[:, 0] for weight in self.weights)

    def bound(self):
        """Of |u| from now on."""
        return amplitude(self._decayed(), self.poles)


def _reals(x):
    return np.array([[float(e.real.mid()) for e in row] for row in x.table()])


def _flint(x):
    x = np.atleast_2d(np.asarray(x, float))
    return fmpq_mat(*x.shape, exact(x).ravel().tolist())


def _float(q):
    return int(q.p) / int(q.q)


def _highest(function, grid):
    """The largest value on a grid, refined between its neighbours."""
    values = [function(x) for x in grid]
    k = int(np.argmax(values))
    low, high = grid[max(k - 1, 0)], grid[min(k + 1, len(grid) - 1)]
    return max(values[k], -lowest(lambda x: -function(x), low, high, 1e-10)[1])
