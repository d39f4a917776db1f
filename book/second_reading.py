"""Recompute the thesis's tables with numpy alone, from numbers typed again.

The book's data are in `sosbook.book.thesis`. The numbers below were typed a second
time, from the text and without looking there, and a test compares the two.
Nothing else of the book is used: what holds here holds for anybody with numpy.

    python second_reading.py
"""

import numpy as np

a = np.array
# M, D, S, B, U, K_A, K = [K_P K_D K_I], then the poles, without and with control
EXAMPLES = {
    "Table 3.1": (
        np.diag([10, 11]),
        a([[4, 1], [1, 5]]),
        a([[8, 4], [-4, 9]]),
        np.eye(2),
        np.eye(2),
        np.zeros((2, 2)),
        np.hstack(
            [
                a([[-101.9639, 9.7931], [-1.8587, -101.0996]]),
                a([[-51.3961, 2.6837], [3.0071, -51.4268]]),
                a([[-62.1859, 6.3242], [-5.9849, -61.5149]]),
            ]
        ),
        [0.0039 + 0.9001j, -0.4312 + 0.8953j],
        [-0.9119 + 0.1141j, -2.0789 + 1.3140j, -2.3439 + 1.1754j],
    ),
    "Table 3.2": (
        np.diag([3, 2, 1, 0]),
        a([[15, -10, 0, 0], [-10, 25, -15, 0], [0, -15, 35, -20], [0, 0, -20, 20]]),
        a([[20, -15, 0, 0], [-15, 30, -15, 0], [0, -15, 35, -20], [0, 0, -20, 20]]),
        np.eye(4)[:, [0, 3]],
        np.eye(4)[[0, 3]],
        a([[1.2655, 0, 0, 0], [0, 0, 0, -1.7345]]),
        np.hstack(
            [
                a([[-61.819, -16.591], [-27.325, 31.7718]]).T,
                a([[14.2869, -71.324], [-20.834, 2.8653]]).T,
                [
                    [-7.9785, -16.5291, 10.9827, -10.6981],
                    [-6.8143, 29.4912, -71.0446, 31.8443],
                ],
                a([[-75.4615, -4.2255], [-9.7808, -33.2117]]),
            ]
        ),
        [-23.698, -0.3680 + 0.7923j, -1.9284, -5.0792, -1.0585, -1],
        [-14.2587 + 6.2459j, -4.0065, -3.2294, -1.4582]
        + [-1.3700, -7.2055, -5.8602, -1.2489, -1.0232],
    ),
} | {
    f"Table 3.3, sinc = {factor:.4f}": (
        np.diag([0.05, 0.1]),
        np.zeros((2, 2)),
        a([[50 + factor, -50], [-50, 50]]),
        a([[0], [1]]),
        a([[0, 1]]),
        np.zeros((1, 2)),
        a([[-75.7438, 69.9357, 3.2975, -4.1265, -13.9027]]),
        [1j * w for w in free],
        closed,
    )
    for factor, free, closed in (
        (1.0, (38.9023, 2.5705), [-8.0620 + 11.9675j, -13.5952, -5.7727 + 4.0952j]),
        (
            2 / np.pi,
            (38.8396, 2.0543),
            [-6.8103 + 9.9304j, -5.9872, -10.8284 + 6.7034j],
        ),
    )
}
# (4.19), (4.20)
BODY, GAIN = (-30.11, -52.49, 7.133, 110.6), -30.52
# (4.25), D and S as printed: of the right-hand side
M = 1e-6 * a([0.3365, 0.3260, 0.3478, 0.3365])  # times the identity
D = 1e-5 * a([[[-x, x], [0.9024, -0.9024]] for x in (0.5659, 0.5584, 0.5739, 0.5659)])
S = 1e-4 * a([[x, -0.3712] for x in (0.5062, 0.4946, 0.5187, 0.5062)])  # for theta
B = 1e-4 * a(
    [[-0.2324, 0.3706], [-0.2294, 0.3706], [-0.2554, 0.4015], [-0.2518, 0.4015]]
)
LETTERS = dict(a=0.4747e-3, b=0.3482e-3, c=0.9641e-3, d=0.1066, e=(0.0282, 0.0306))
# Tables 4.1, 4.2, 4.3 by R
PD = {
    1: [38.3431, 1.0001, 4.0221, 1.5153],
    2: [29.0634, 0.7072, 2.9553, 1.1669],
    5: [21.2689, 0.4472, 2.0587, 0.8688],
}
PID = {
    1: [41.0411, 1.9873, 4.3391, 1.7000, 0.9997],
    2: [30.8834, 1.4191, 3.1781, 1.2952, 0.7071],
    5: [22.2760, 0.9197, 2.1935, 0.9469, 0.4472],
}
LQE = {1: [34.6136, 3.6216, 1.2728], 2: [26.3376, 2.6619, 0.9914]}
L_2 = 1e3 * a([[-0.0018, -0.0004], [-1.2580, 0.1976], [1.9763, -0.3302]])
# (4.28), (4.29): gain and zeros from theta' and phi', poles; (4.30)
FULL = (-1436.1, [-9.031, -88.33]), (188.18, [232.5, -1.992]), [-1694, -10.45, -5.039]
LESS = (-0.8476, [-9.031, -88.33]), (-25.831, [-1.992]), [-5.039, -10.45]
A_D, B_D = (
    [[0.9008, 0.1481], [0, 0.9509]],
    [[-0.08405, -0.03019], [-0.02148, 0.00599]],
)
C_D, D_D = [[8, 0]], [[-0.8477, 0]]


def poles_of(M, D, S, B, U, K_A, K):
    """Finite poles, open loop (without U) and closed, upper half-plane."""
    n, a = len(M), len(U)
    E = np.zeros((2 * n + a, 2 * n + a))
    E[:n, :n], E[2 * n :, 2 * n :] = np.eye(n), np.eye(a)
    A = np.zeros_like(E)
    A[:n, n : 2 * n], A[2 * n :, :n] = np.eye(n), U
    A[n : 2 * n, : 2 * n] = -np.hstack([S, D])
    found = []
    for size, mass, gain in ((2 * n, M, 0 * K), (2 * n + a, M - B @ K_A, K)):
        E[n : 2 * n, n : 2 * n] = mass
        loop = A.copy()
        loop[n : 2 * n] += B @ gain
        # E may be singular: shift to 1, and drop the poles at infinity
        inverse = np.linalg.eigvals(
            np.linalg.solve(loop[:size, :size] - E[:size, :size], E[:size, :size])
        )
        s = 1 + 1 / inverse[abs(inverse) > 1e-9]
        found.append(s[s.imag >= -1e-9])
    return found


def regulator(A, B, R):
    """The gain of least cost for Q = I, by the Hamiltonian's eigenvectors."""
    n = len(A)
    values, vectors = np.linalg.eig(
        np.block([[A, -np.outer(B, B) / R], [-np.eye(n), -A.T]])
    )
    X = vectors[:, values.real < 0]
    return -(B @ np.linalg.solve(X[:n].T, X[n:].T).T).real / R


def pendulum(k, integral=False):
    """A and B of vertex k of (4.25), with the integral of phi or without."""
    A, b = np.zeros((5, 5)), np.zeros(5)
    A[0, 2] = A[1, 3] = A[4, 1] = 1
    A[2:4, 0], A[2:4, 2:4], b[2:4] = S[k] / M[k], D[k] / M[k], B[k] / M[k]
    size = 4 + integral
    return A[:size, :size], b[:size]


def held(poles, channels, T=0.01):
    """Numerators and denominator of the hold of two transfer functions."""
    den = np.poly(poles)
    A = np.array([[-den[1], -den[2]], [1, 0]])
    tops = []
    values, V = np.linalg.eig(A)
    Phi = (V * np.exp(values * T)) @ np.linalg.inv(V)
    gamma = np.linalg.solve(A, (Phi - np.eye(2))[:, 0]).real
    new = np.poly(np.exp(np.array(poles) * T))
    for gain, zeros in channels:
        num = np.zeros(3)
        num[2 - len(zeros) :] = gain * np.poly(zeros)
        C, direct = num[1:] - num[0] * den[1:], num[0]
        tops.append(np.poly(Phi - np.outer(gamma, C)).real - new + direct * new)
    return tops, new


def checks():
    """(what, largest deviation, tolerance) of each table."""
    for name, (*plant, K, free, closed) in EXAMPLES.items():
        opened, looped = poles_of(*plant, K)
        assert (len(opened), len(looped)) == (len(free), len(closed)), name
        far = max(min(abs(opened - p)) for p in free)
        yield f"{name}, open loop", far, 1e-4
        # the gains are rounded too: that moves a pole by up to 1e-3
        far = max(min(abs(looped - p)) for p in closed)
        yield f"{name}, closed loop", far, 1e-3
    w = np.linspace(1, 30, 200001) * 1j
    shape = abs(w**2 + BODY[2] * w + BODY[3])
    gain = max(abs(BODY[0] * w + BODY[1]) / shape) / max(abs(w) / shape)
    yield "(4.20) from (4.19)", abs(gain + GAIN), 0.005
    x = LETTERS
    yield "M of (4.25)", abs((x["a"] * x["c"] - x["b"] ** 2) / M[0] - 1), 5e-4
    far = (x["a"] + x["b"]) * x["e"][0] / -B[0, 0] - 1
    yield "B of (4.25), vertex 1", abs(far), 2e-3  # e has three digits
    for table, vertex, integral in ((PD, 0, False), (PID, 3, True)):
        for R, K in table.items():
            found = regulator(*pendulum(vertex, integral), R)
            name = f"Table 4.{1 + integral}, R = {R}: regulator of vertex {vertex + 1}"
            yield name, max(abs(found / K - 1)), 1e-3
    keep = [0, 2, 3]
    A, b = pendulum(0)
    for R, K in LQE.items():
        found = regulator(A[np.ix_(keep, keep)], b[keep], R)
        yield f"Table 4.3, K, R = {R}: vertex 1", max(abs(found / K - 1)), 1e-3
    m = M.mean()
    A = np.vstack([[0, 1, 0], np.hstack([S.mean(0)[:, None], D.mean(0)]) / m])
    b = np.append(0, B.mean(0) / m)
    loop = A + np.outer(b, LQE[2]) + L_2 @ np.eye(3)[1:]
    far = np.sort(np.linalg.eigvals(loop).real) / np.sort(FULL[2]) - 1
    yield "(4.28), poles from Table 4.3 and the means of (4.25)", max(abs(far)), 5e-4
    yield "(4.29), first gain", abs(FULL[0][0] / 1694 / LESS[0][0] - 1), 5e-4
    yield "(4.29), second gain", abs(-FULL[1][0] * 232.5 / 1694 / LESS[1][0] - 1), 5e-4
    tops, den = held(LESS[2], LESS[:2])
    yield "(4.30), poles", max(abs(np.poly(A_D) - den)), 2e-4
    for j, top in enumerate(tops):
        direct = (D_D[0] + [0])[j]
        found = np.poly(a(A_D) - np.outer(a(B_D)[:, j], C_D)) - np.poly(A_D)
        far = abs(found + direct * np.poly(A_D) - top)
        yield f"(4.30), channel {j + 1}", max(far), 3e-4


def main():
    """Print what was recomputed; return how many failed."""
    bad = 0
    for what, far, tolerance in checks():
        bad += far > tolerance
        print(f"{'ok ' if far <= tolerance else 'NOT'} {what}: off by {far:.1e}")
    return int(bad)


if __name__ == "__main__":
    raise SystemExit(main())
