"""Gains and Lyapunov matrices of one loop by equations, where a search is too long.

Lightly damped modes with frequencies far apart kill the conjugate gradients that large
blocks need. An equation gives a point at once, in coordinates in which every mode has
the size one; whether it is one is judged by the blocks.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import eigh, matrix_balance, schur, solve_discrete_are

from ..analysis.riccati import lyapunov
from ..plants.descriptor_system import DescriptorSystem
from ..plants.second_order import SecondOrderSystem
from ..runtime.read_only import ReadOnly
from ..runtime.time_limit import check_time_of_eigenvalues

SLOWEST = 1e-6  # of the median frequency: rigid modes have none of their own
SHARES = 10.0 ** -np.arange(14)  # of room in a bounded real equation
DEFECTIVE = 1e5  # condition of eigenvectors; its square is that of P
NUDGE = 1e-5  # of the fastest mode: two equal ones are apart by its root then
RESIDUAL = 1e-6  # relative; a larger one is no solution's
NEWTON_STEPS = 4  # they square the residual, which begins near 1e-8
SCHUR = 4.0  # times as long as the eigenvalues


def balanced(plant, descriptor):
    """T in x = T xi in which every mode of an undamped ``plant`` has the size one: V /
    w and V, with V' M V = I and V' S V = w^2; the states of ``descriptor`` are [z; z';
    x3]. A `Descriptor` is balanced by powers of two; None where M isn't positive
    definite.
    """
    N = len(descriptor.E)
    check_time_of_eigenvalues(N)
    if not isinstance(plant, SecondOrderSystem):
        scales = matrix_balance(descriptor.state_space()[0], separate=True)[1][0]
        return np.diag(scales)
    n = plant.n
    try:
        squares, V = eigh(plant.S + plant.S.T, plant.M + plant.M.T)
    except np.linalg.LinAlgError:
        return None
    w = np.sqrt(np.abs(squares))
    w = np.maximum(w, SLOWEST * np.median(w) or 1.0)
    T = np.eye(N)
    T[:n, :n], T[n : 2 * n, n : 2 * n] = V / w, V
    integrated = descriptor.A[2 * n :, :n] @ V / w**2  # x3' = U z
    T[2 * n :, 2 * n :] *= np.linalg.norm(integrated, axis=1)[:, None]
    return T


def of_modes(A):
    """P > 0 that keeps every region of the poles which the eigenvalues of ``A`` keep.
    With A V = V L the block of the region alpha, beta is (I x V) [alpha x I + beta x L
    + beta' x L*] (I x V*), and the bracket is diagonal but for order: so P = V V* keeps
    all regions at once. Columns of V have length one. Of a defective A they would make
    P singular: then they are those of an A whose diagonal has moved by next to nothing.
    """
    check_time_of_eigenvalues(len(A))
    modes, V = np.linalg.eig(A)
    if np.linalg.cond(V) > DEFECTIVE:
        size = NUDGE * np.abs(modes).max()
        V = np.linalg.eig(A + size * np.diag(np.linspace(-1, 1, len(A))))[1]
    P = (V @ V.conj().T).real
    return (P + P.T) / 2


def deflated(A, B, out, design):
    """K, (m, N), that moves the modes of x' = ``A`` x + ``B`` u that are ``out`` (of
    pairs it says the same) and no others, and how many these are. W' A = A_b W' with
    orthonormal columns W, the ordered Schur vectors of A'; with K = K_b W' the loop is
    block triangular in [W, its complement], with A_b + W'B K_b and the modes that stay
    on its diagonal. ``design`` makes K_b of A_b and W'B.
    """
    check_time_of_eigenvalues(len(A), SCHUR)
    T, Q, count = schur(A.T, sort=lambda re, im: out(complex(re, im)))
    W = Q[:, :count]
    if not count:
        return np.zeros(B.T.shape), 0
    return design(T[:count, :count].T, W.T @ B) @ W.T, count


def least_effort(sigma):
    """A design for `deflated`: of all gains the least that makes the decay ``sigma``.
    What is right of -sigma is mirrored there: F Y + Y F' = B B' with F = A + sigma I, K
    = -B' Y^-1, and F + B K = -Y F' Y^-1. It minimises the integral of |u|^2 exp(2 sigma
    t) from the worst state, whatever the units of x.
    """

    def design(A, B):
        Y = lyapunov(A + sigma * np.eye(len(A)), B @ B.T)
        return -np.linalg.solve(Y.T, B).T

    return design


def in_disk(centre, radius):
    """A design for `deflated` into the disk of a ``radius`` about -``centre``, in
    rad/s: the discrete Riccati equation without a weight of the state mirrors what is
    outside at the circle. Source: K. Furuta and S. B. Kim, IEEE Trans. Automatic
    Control 32, 1987.
    """

    def design(A, B):
        F, G = (A + centre * np.eye(len(A))) / radius, B / radius
        one = np.eye(B.shape[1])
        X = solve_discrete_are(F, G, np.zeros_like(F), one)
        return -np.linalg.solve(one + G.T @ X @ G, G.T @ X @ F)

    return design


def bounded_real(A, Bw, C, gamma):
    """P of the bounded real lemma for ``A``, ``Bw``, ``C`` and a ``gamma`` above the
    norm, well inside its block; None where there is none. A P + P A' + Bw Bw' + P C'C P
    / gamma^2 = -e R with the largest power of ten e that has a solution. R is what
    `of_modes` leaves of Lyapunov's equation, so that every mode has room at its own
    rate.
    """
    P = of_modes(A)
    room = -(A @ P + P @ A.T)
    noise, bent = Bw @ Bw.T, C.T @ C / gamma**2
    most = np.linalg.norm(noise, 2) / np.linalg.norm(room, 2)
    for share in most * SHARES:
        P = _riccati(A.T, -bent, noise + share * room)
        if P is not None and np.linalg.eigvalsh(P)[0] > 0:
            return P
    return None


def _riccati(A, G, Q):
    """The stabilising X of A'X + X A - X G X + Q = 0 for any symmetric G; or None."""
    N = len(A)
    check_time_of_eigenvalues(2 * N, SCHUR)
    H = np.block([[A, -G], [-Q, -A.T]])
    try:
        _, U, count = schur(H, sort="lhp")
        if count != N:
            return None
        X = np.linalg.solve(U[:N, :N].T, U[N:, :N].T)
        for _ in range(NEWTON_STEPS):
            X = (X + X.T) / 2
            left = A.T @ X + X @ A - X @ G @ X + Q
            X = X + lyapunov((A - G @ X).T, -left)
    except (np.linalg.LinAlgError, ValueError):
        return None
    X = (X + X.T) / 2
    left, bent = A.T @ X + X @ A - X @ G @ X + Q, X @ G @ X
    size = max(np.abs(x).max() for x in (X @ A, bent, Q))
    return X if np.abs(left).max() < RESIDUAL * size else None


SAME_POLE = 1e-6  # of its size; what is nearer to an open-loop pole hasn't moved
ROUNDING = 1e-11  # of the largest pole's size
FAR_TOO_STIFF = 1e6  # times the plant's own stiffness: no actuator's, or a unit's slip
MOST_FORCE = 0.9  # of the squares of K's rows: then one mode is the reason
STRONG = 100.0  # times the plant's own stiffness; the reason of less isn't sought


@dataclass(frozen=True, eq=False)
class Effort(ReadOnly):
    """The effort of a gain; see `Design.effort`.

    ``needless``: whether K = 0 keeps all that is asked, in floats and at the vertices;
    ``moved``, ``modes``: how many poles of the mean vertex move, and how many there
    are; ``stiffness``: the largest entry of B K_P over the largest one of S; None where
    the plant has no S; ``costly``: the frequency in rad/s of a mode that takes nearly
    all of a strong gain, because the inputs hardly reach it; None where no mode does;
    ``vertices``: how many plants were looked at: those between them weren't.
    """

    needless: bool
    moved: int
    modes: int
    stiffness: float | None
    costly: float | None
    vertices: int = 1

    @property
    def where(self) -> str:
        """Of which plants it is said, in words: of vertices, and not between them."""
        return " at each vertex" if self.vertices > 1 else ""

    def __str__(self):
        words = [f"{self.moved} of {self.modes} poles are moved"]
        if self.needless:
            words.append(f"K = 0 keeps all that is asked already{self.where}")
        if self.stiffness is not None:
            words.append(
                f"the force at one unit is {self.stiffness:.2g} of the stiffness's"
            )
        if self.costly is not None:
            words.append(f"the mode at {self.costly:.4g} rad/s takes nearly all of it")
        text = "; ".join(words)
        if self.stiffness is not None and self.stiffness > FAR_TOO_STIFF:
            text += ": no actuator gives that. Ask for less, or bound the input"
        return text


def effort_of(solution):
    """The `Effort` of a ``solution`` with a gain."""
    request, K = solution.request, solution.K
    A, B, _ = request.mean.state_space()
    check_time_of_eigenvalues(len(A), 3)
    before, V = np.linalg.eig(A)
    after = np.linalg.eigvals(A + B @ K)
    same = np.maximum(SAME_POLE * np.abs(after), ROUNDING * np.abs(before).max())
    apart = np.abs(after[:, None] - before).min(axis=1)
    T = balanced(request.plant.vertices[0], request.mean)
    V = V if T is None else np.linalg.solve(T, V)  # in which each mode counts alike
    V = V / np.linalg.norm(V, axis=0)
    stiffness, plant = None, request.plant
    if not isinstance(plant, DescriptorSystem):
        force = max(np.abs(v.B @ K[:, : v.n]).max(initial=0) for v in plant.vertices)
        own = max(np.abs(v.S).max() for v in plant.vertices)
        stiffness = float(force / own) if own else None
    shares = (np.abs(K @ V if T is None else K @ T @ V) ** 2).sum(axis=0)
    worst = int(shares.argmax())
    pair = np.isclose(np.abs(before.imag), abs(before[worst].imag)) & np.isclose(
        before.real, before[worst].real
    )
    alone = shares.sum() > 0 and shares[pair].sum() > MOST_FORCE * shares.sum()
    return Effort(
        request.kept_by(np.zeros_like(K), request.demands),
        int((apart > same).sum()),
        len(A),
        stiffness,
        float(abs(before[worst])) if alone and (stiffness or 0) > STRONG else None,
        len(request.distinct),
    )
