"""What a gain does in a loop, computed from M, D, S, B, F and K alone.

Nothing of sosbook is used but the numbers of its plants: the loop is
written down here, and its poles, its frequency response and the input
after an initial state come from interval arithmetic of 300 bits.
"""

from fractions import Fraction

import numpy as np
from flint import acb as complex_ball
from flint import acb_mat, arb, ctx, fmpq, fmpq_mat

BITS = 300
FREQUENCIES = 40
TIMES = 40
EXCESS = 1e-9  # of floats in the norm and the peak


def members(plant, samples=3, seed=0):
    """The vertices of a plant and some random plants between them."""
    vertices = [[v.M, v.D, v.S, v.B, v.F] for v in plant.vertices]
    yield from vertices
    if len(vertices) == 1:
        return
    rng = np.random.default_rng(seed)
    for weights in rng.dirichlet(np.ones(len(vertices)), samples):
        yield [sum(w * x for w, x in zip(weights, part)) for part in zip(*vertices)]


def loop(parts, K, U=None, K_A=None):
    """A and F of x' = A x + F w with u = K x + K_A z'', in rationals."""
    M, D, S, B, F = map(_rational, parts)
    n, a = M.nrows(), 0 if U is None else len(U)
    K = _rational(K)
    if K_A is not None:
        M = M - B * _rational(K_A)
    back = M.inv()
    push, driven, free = back * B * K, back * F, (back * S, back * D)
    N = 2 * n + a
    A, G = fmpq_mat(N, N), fmpq_mat(N, F.ncols())
    for i in range(n):
        A[i, n + i] = 1
        for j in range(N):
            A[n + i, j] = push[i, j]
        for j in range(n):
            A[n + i, j] -= free[0][i, j]
            A[n + i, n + j] -= free[1][i, j]
        for j in range(F.ncols()):
            G[n + i, j] = driven[i, j]
    if a:
        U = _rational(U)
        for i in range(a):
            for j in range(n):
                A[2 * n + i, j] = U[i, j]
    return A, G


def _rational(x):
    x = np.atleast_2d(x)
    fractions = [Fraction(float(v)) for v in x.ravel()]
    return fmpq_mat(*x.shape, [fmpq(f.numerator, f.denominator) for f in fractions])


def poles(A):
    """The eigenvalues of a rational matrix, each in a ball."""
    for bits in (
        BITS,
        4 * BITS,
    ):  # where they are far apart 300 bits may not enclose them
        with ctx.workprec(bits):
            balls = acb_mat(A).eig(nonstop=True, multiple=True)
        if all(s.is_finite() for s in balls):
            return balls
    return [s for s, times in A.charpoly().complex_roots() for _ in range(times)]


def broken(plant, asked, K):
    """Requirements that a gain breaks for certain, in words.

    Parameters
    ----------
    plant : SecondOrderSystem or Polytope
        Its vertices and some plants between them are looked at.
    asked : dict
        Arguments of `design_pid`.
    K : (m, 2 n + a) array
        A gain.

    Returns
    -------
    list of str
        Empty if nothing was found against the gain.
    """
    with ctx.workprec(BITS):
        found = []
        for parts in members(plant):
            A, F = loop(parts, K, asked.get("U"), asked.get("K_A"))
            balls = poles(A)
            found += _places(balls, asked.get("region"))
            if "gamma" in asked:
                found += _norm(A, F, len(parts[0]), balls, asked["gamma"])
            if "saturation" in asked:
                found += _peak(A, K, balls, asked["saturation"])
        return found


def _places(balls, region):
    """Poles that aren't inside the region for certain."""
    sigma, theta, rho = (
        (0, None, None) if region is None else (region.sigma, region.theta, region.rho)
    )
    found = []
    for s in balls:
        if not s.real < -arb(sigma or 0):
            found.append(f"a pole at {s.mid().str(5)} is right of sigma")
        if theta is not None and theta < np.pi / 2:
            if not abs(s.imag) < -s.real * arb(theta).tan():
                found.append(f"a pole at {s.mid().str(5)} is outside theta")
        if rho is not None and not abs(s) < arb(rho):
            found.append(f"a pole at {s.mid().str(5)} is outside rho")
    return found


def _norm(A, F, n, balls, gamma):
    """Frequencies at which the response of z exceeds gamma."""
    sizes = [float(abs(s).mid()) for s in balls]
    grid = np.geomspace(min(sizes) / 10, max(sizes) * 10, FREQUENCIES)
    grid = [0.0, *grid, *(abs(float(s.imag.mid())) for s in balls)]
    N = A.nrows()
    identity, A, F = acb_mat(fmpq_mat(N, N, _eye(N))), acb_mat(A), acb_mat(F)
    found = []
    for w in grid:
        x = (complex_ball(0, w) * identity - A).solve(F)
        z = [[complex(x[i, j]) for j in range(x.ncols())] for i in range(n)]
        size = np.linalg.norm(np.array(z), 2)
        if not size <= gamma * (1 + EXCESS):
            found.append(f"the response at {w:.4g} rad/s is {size:.6g}")
    return found


def _peak(A, K, balls, limit):
    """Times at which |K x| exceeds u_max, from the initial state."""
    slowest = min(float(-s.real.mid()) for s in balls)
    fastest = max(float(abs(s).mid()) for s in balls)
    times = np.geomspace(0.01 / fastest, 5 / max(slowest, 1e-300), TIMES)
    x = acb_mat(_rational(np.reshape(limit.x0, (-1, 1))))
    try:
        balls, V = acb_mat(A).eig(right=True)
    except ValueError:  # poles too close to each other to be told apart
        return []
    modes, seen = V.solve(x), acb_mat(_rational(K)) * V
    found = []
    for t in [0.0, *times]:
        decay = [(s * t).exp() * modes[k, 0] for k, s in enumerate(balls)]
        u = seen * acb_mat(len(decay), 1, decay)
        size = np.linalg.norm([complex(u[i, 0]) for i in range(u.nrows())])
        if size > limit.u_max * (1 + EXCESS):
            found.append(f"|u| is {size:.6g} at {t:.4g} s")
    return found


def _eye(N):
    return [int(i == j) for i in range(N) for j in range(N)]
