"""Exact proofs, as files, that an input bound is too small for some modes."""

from copy import copy

import numpy as np

from ..exact.definite import exact
from ..exact.rational import decimals, read_array
from ..exact.refusal import Refusal
from ..requirements.stability import Stability
from .request_as_data import read_request, request_data


def pole_demands(request):
    """The requirements of a request that its LMIs make of the poles, by key."""
    asked = [r for r in request.requirements if r.pole_matrices() is not None]
    return {r.key: r for r in (*asked, Stability())}


def input_bound(request):
    """The one requirement of a request that bounds K x from x0; else None."""
    bounds = [r for r in request.requirements if r.bounds_input_from() is not None]
    return bounds[0] if len(bounds) == 1 else None


def real_form(re, im):
    """The real matrix [re, -im; im, re] of a complex one: products stay products."""
    return np.vstack([np.hstack([re, -im]), np.hstack([im, re])])


def _parts(x):
    rows, columns = x.shape[0] // 2, x.shape[1] // 2
    return x[:rows, :columns], x[rows:, :columns]


def _bound(x):
    """Of the size of each entry, from above."""
    re, im = _parts(x)
    return abs(re) + abs(im)


def _cut(x, rows, columns):
    re, im = _parts(x)
    return real_form(re[rows, columns], im[rows, columns])


def _twice(x):
    """A diagonal matrix in the real form."""
    return real_form(x, 0 * x)


class ModesPart:
    """An enclosure of a part of a plant that A leaves invariant.

    There are X and L with W A = L W E and W = [I X] T, and with every
    |X| <= spread and every |L - L0| <= blur, if the kernel says so.

    ``E``, ``A``, ``B``: the plant at one vertex, in rationals; ``T``, ``R``, (2N, 2N):
    in `real_form`: rows near those of the part and of a complement, and a matrix near
    the inverse of T E; ``k``: how many of the rows are the part's. Has ``spread``, (k,
    N - k): bounds of X: see `within`; ``blur``, (k, k): bounds of L - L0, where L0 =
    K11.

    With K = T A R and J = T E R the equation is [I X] K = L [I X] J, by blocks

        L = K11 + X K21 - L (J11 - I) - L X J21,
        X K22 - L X J22 = L J12 - K12.

    Divided by the differences of the diagonals of K22 and K11, both are maps of
    (L, X). Where they map the bounds into themselves a fixed point exists (Brouwer).
    The sum of <G, z> over the regions of `sums` is completed by a part U of Q, the
    multipliers [U N; N* price] of "u_max" and, with D = Q - U and h = V x0,
    [h* D h, -h* D; -D h, D] of "x0": it doesn't depend on p and y, and can't be
    negative, but is u_max^2 tr(price) - h* D h. The kernel decides it all.
    """

    def __init__(self, E, A, B, T, R, k):
        self.k, top = k, slice(0, k)
        E, A, B = map(_twice, (E, A, B))
        self.K, self.J = T @ A @ R, T @ E @ R
        self.off = self.J - _twice(exact(np.eye(len(self.J) // 2)))
        self.L = _cut(self.K, top, top)
        self.first = self.L @ _cut(self.J, top, slice(k, None))
        self.first = self.first - _cut(self.K, top, slice(k, None))
        self.push = T @ B
        self.b = _cut(self.push, top, slice(None))

    def within(self, spread, blur):
        """The part with these bounds ``spread`` and ``blur``."""
        part = copy(self)
        part.spread, part.blur = spread, blur
        rest = _cut(self.push, slice(self.k, None), slice(None))
        part.b_blur = spread @ _bound(rest)
        return part

    def in_floats(self):
        """The same in floats, for estimates."""
        part = copy(self)
        for name, value in vars(self).items():
            if name != "k":
                setattr(part, name, value.astype(float))
        return part

    def image(self):
        """What the maps make of the bounds: every image of X lies within ``spread /
        gaps``, of L - L0 in ``blur``.
        """
        k, K, J = self.k, self.K, self.J
        N, spread, blur = k + self.spread.shape[1], self.spread, self.blur
        top, rest = slice(0, k), slice(k, N)
        diagonal = np.diag(np.ones(N, int)) == 1
        size_K, size_off = _bound(K), _bound(self.off)
        inner = np.where(diagonal, 0, size_K)  # without the diagonal
        L = size_K[top, top] + blur
        new_blur = (
            spread @ size_K[rest, top]
            + L @ size_off[top, top]
            + L @ spread @ size_off[rest, top]
        )
        own = np.where(diagonal, size_K, 0)[top, top]
        new_spread = (
            _bound(self.first)
            + blur @ _bound(_cut(J, top, rest))
            + (inner[top, top] + blur) @ spread @ _bound(_cut(J, rest, rest))
            + own @ spread @ size_off[rest, rest]
            + spread @ inner[rest, rest]
        )
        re, im = (x.diagonal() for x in _parts(K))
        gaps = np.maximum(
            abs(re[None, rest] - re[top, None]), abs(im[None, rest] - im[top, None])
        )
        return new_spread, gaps, new_blur

    def sums(self, demands, multipliers):
        """What ``multipliers`` z of the poles' blocks, in `real_form`, leave of p and
        of y: for all p and y = Y V' the sum of <G, z> is -tr(Q p) - 2 Re tr(N y).
        ``demands`` are the regions' (alpha, beta). Returns Q, (2k, 2k), and N, (2k,
        2m), in `real_form` at L0 and b0, and bounds of their errors.
        """
        k, S, F = self.k, 0 * self.L, 0 * self.L
        for (alpha, beta), z in zip(demands, multipliers):
            for i in range(len(alpha)):
                for j in range(len(alpha)):
                    z_ji = _cut(z, slice(j * k, j * k + k), slice(i * k, i * k + k))
                    S, F = S + alpha[i, j] * z_ji, F + beta[i, j] * z_ji
        move, size = F @ self.L, _bound(F)
        Q_blur = size @ self.blur
        Q, N = S + move + move.T, F @ self.b
        return Q, N, Q_blur + Q_blur.T, size @ self.b_blur


class SmallInputRefusal(Refusal):
    """An input bound that is too small for the modes outside of the region. ``text`` is
    that of the file: the plant and what is asked of it, a `ModesPart`, and multipliers
    of its LMIs, in decimals; complex matrices are pairs of real and imaginary part.
    """

    kind = "small input"

    @property
    def place(self):
        """Which vertex has the modes, from 0."""
        return self.data["vertex"]

    @property
    def modes(self):
        """The modes, in rad/s, to the accuracy of floats."""
        data = self.data
        A = read_request(data).vertices[data["vertex"]].A
        T, R = (_complex(data[x]) for x in ("rows", "columns"))
        k = len(data["spread"])
        return np.linalg.eigvals((T @ A @ R)[:k, :k])

    @classmethod
    def contents(cls, request, vertex, bases, spread, blur, multipliers, share, price):
        """The data of the file for the ``vertex`` of a ``request`` that has the modes:
        ``bases``, T and R of `ModesPart` as pairs of real and imaginary part, its
        ``spread`` and ``blur``, ``multipliers`` of the poles' blocks by key, ``share``,
        which is U, and ``price``.
        """

        def pair(parts):
            return [decimals(x) for x in parts]

        return {
            **request_data(request),
            "K": None,
            "vertex": vertex,
            "rows": pair(bases[0]),
            "columns": pair(bases[1]),
            "spread": decimals(spread),
            "blur": decimals(blur),
            "multipliers": [[list(key), pair(z)] for key, z in multipliers],
            "share": pair(share),
            "price": pair(price),
        }


def _complex(pair):
    re, im = (read_array(x, None, None) for x in pair)
    return re + 1j * im
