"""What a loop really does, from its matrices alone: an oracle for what is claimed.

Poles are those of the exact characteristic polynomial, costs those of an exact
Lyapunov equation. Norms and peaks are values on a grid, so that they are too small,
never too large: what exceeds a claimed bound refutes it.
"""

from fractions import Fraction

import numpy as np
from flint import acb_mat, ctx, fmpq, fmpq_mat
from scipy.linalg import eigvals, expm

SLACK = 1e-7  # relative: what floats may be wrong by


def broken(vertices, K, U, requirements, rng, between=0):
    """What a gain breaks of what was asked, in words; empty where all is kept.

    Parameters
    ----------
    vertices : list of objects with M, D, S, B, F, n and p
    K : (m, N) array
    U : (a, n) array or None
    requirements : sequence of Requirement
        Regions of the poles, gamma, an input bound, a cost; read as data.
    rng : numpy Generator
    between : int
        How many plants between the vertices are tried, too.
    """
    faults = []
    for weights in _weights(len(vertices), between, rng):
        E, A, W = loop(vertices, weights, K, U)
        poles = _poles(E, A)
        if poles.real.max() >= 0:
            faults.append(f"a pole at {poles[np.argmax(poles.real)]:.6g}")
            continue
        for r in requirements:
            data = r.data()
            if data["kind"] == "region":
                worst = max(_outside(data, s, r) for s in poles)
                if worst > SLACK:
                    faults.append(f"a pole outside of {data['name']} by {worst:.3g}")
            elif data["kind"] == "gamma":
                fast, pushed = _floats(E.solve(A)), _floats(E.solve(W))
                one = np.eye(len(fast))
                size = norm(one, fast, pushed, one[: vertices[0].n])
                if size > r.gamma * (1 + SLACK):
                    faults.append(f"the norm is {size:.8g}, not below {r.gamma:.8g}")
            elif data["kind"] == "input" and not r.acceleration:
                peak = _peak(E, A, K, r.x0)
                if peak > r.u_max * (1 + SLACK):
                    faults.append(f"|K x| reaches {peak:.8g}, not below {r.u_max:.8g}")
            elif data["kind"] == "cost":
                cost = cost_of(E, A, W if r.noise == "F" else None, K, r)
                if cost >= r.bound:
                    faults.append(f"the cost is {cost:.8g}, not below {r.bound:.8g}")
    return faults


def _weights(count, between, rng):
    """Those of the vertices, and of some plants between two or all of them."""
    yield from np.eye(count).astype(int)
    for k in range(between if count > 1 else 0):
        chosen = rng.permutation(count)[: 2 if k % 2 else count]
        parts = np.zeros(count, int)
        parts[chosen] = rng.integers(1, 1000, len(chosen))
        yield parts


def _rational(x):
    value = Fraction(repr(float(x)))
    return fmpq(value.numerator, value.denominator)


def _exact(rows):
    rows = np.atleast_2d(np.asarray(rows, float))
    return fmpq_mat(*rows.shape, [_rational(x) for x in rows.ravel()])


def loop(vertices, weights, K, U):
    """E, A + B K and the matrix of w, in rationals, of a mean of the vertices."""
    total = int(sum(weights))
    mean = {
        name: sum(
            (
                fmpq(int(w), total) * _exact(getattr(v, name))
                for w, v in zip(weights, vertices)
                if w
            ),
            fmpq_mat(*np.shape(getattr(vertices[0], name))),
        )
        for name in "MDSBF"
    }
    n, a = vertices[0].n, 0 if U is None else len(U)
    N, K = 2 * n + a, _exact(K)
    E, A = fmpq_mat(N, N), fmpq_mat(N, N)
    W, pull = fmpq_mat(N, vertices[0].p), mean["B"] * K
    for i in range(n):
        E[i, i] = A[i, n + i] = 1
        for j in range(n):
            E[n + i, n + j] = mean["M"][i, j]
            A[n + i, j], A[n + i, n + j] = -mean["S"][i, j], -mean["D"][i, j]
        for j in range(N):
            A[n + i, j] += pull[i, j]
        for j in range(vertices[0].p):
            W[n + i, j] = mean["F"][i, j]
    for i in range(a):
        E[2 * n + i, 2 * n + i] = 1
        for j in range(n):
            A[2 * n + i, j] = _rational(U[i][j])
    return E, A, W


def _poles(E, A, bits=200):
    quotient = E.solve(A)
    with ctx.workprec(bits):
        try:
            roots = [root for root, _ in quotient.charpoly().complex_roots()]
        except ValueError:
            roots = acb_mat(quotient).eig(multiple=True)
        return np.array(
            [complex(float(s.real.mid()), float(s.imag.mid())) for s in roots]
        )


def _outside(data, s, region):
    """How far a pole is outside of a region, relative to its own size."""
    size = {k: float(v) for k, v in data.items() if k in _SIZES}
    scale = abs(s) + max(map(abs, size.values()), default=0.0) + 1e-300
    match data["form"]:
        case "half-plane":
            return (s.real + size["sigma"]) / scale
        case "disk":
            return (abs(s - size["centre"]) - size["rho"]) / scale
        case "sector":
            t = s - size["apex"]
            edge = abs(t.imag) * np.cos(size["theta"]) + t.real * np.sin(size["theta"])
            return edge / scale
        case "strip":
            return max(size["left"] - s.real, s.real - size["right"]) / scale
        case "horizontal strip":
            return (abs(s.imag) - size["omega"]) / scale
    value = region.alpha + region.beta * s + region.beta.T * s.conjugate()
    return np.linalg.eigvalsh(value)[-1] / (np.abs(value).max() + 1e-300)


_SIZES = ("sigma", "theta", "apex", "rho", "centre", "left", "right", "omega")


def _floats(x):
    return np.array([[float(Fraction(int(e.p), int(e.q))) for e in row]
                     for row in x.tolist()]).reshape(x.nrows(), x.ncols())  # fmt: skip


def norm(E, A, W, C):
    """The largest gain from w to C x: a little too small, never too large."""
    s = eigvals(A, E)
    grid = np.unique(np.r_[0, abs(s.imag), abs(s), 0.7 * abs(s), 1.4 * abs(s)])

    def gain(w):
        return np.linalg.norm(C @ np.linalg.solve(1j * w * E - A, W), 2)

    best = max(grid, key=gain)
    for step in (0.3, 0.1, 0.03, 0.01, 0.003, 0.001):
        best = max(best * (1 + step * np.linspace(-1, 1, 13)), key=gain)
    return gain(best)


def _peak(E, A, K, x0, steps=400):
    """The largest |K x(t)| from x0 at the times of a grid that grows."""
    A, K, x = _floats(E.solve(A)), np.asarray(K, float), np.asarray(x0, float)
    peak, h = np.linalg.norm(K @ x), 0.05 / max(abs(np.linalg.eigvals(A)))
    for _ in range(12):  # each grid is twice as coarse as the one before
        step = expm(A * h)
        for _ in range(steps // 12):
            x = step @ x
            peak = max(peak, np.linalg.norm(K @ x))
        h *= 2
    return peak


def cost_of(E, A, W, K, r):
    """tr(W' X W) with A'X + X A + Q + K'R K = 0, exactly; of all states the largest.

    The noise enters E x' = A x + B u + W w, or each state of x' alone.
    """
    N, quotient, K = E.nrows(), E.solve(A), _exact(K)
    weight = _exact(r.Q) + K.transpose() * _exact(r.R) * K
    system, right = fmpq_mat(N * N, N * N), fmpq_mat(N * N, 1)
    for i in range(N):
        for j in range(N):
            right[i * N + j, 0] = -weight[i, j]
            for k in range(N):
                system[i * N + j, k * N + j] += quotient[k, i]
                system[i * N + j, i * N + k] += quotient[k, j]
    x = system.solve(right)
    X = fmpq_mat(N, N, [x[k, 0] for k in range(N * N)])
    if W is not None:
        entering = E.solve(W)
        X = entering.transpose() * X * entering
    trace = sum((X[i, i] for i in range(X.nrows())), fmpq(0))
    return float(Fraction(int(trace.p), int(trace.q)))
