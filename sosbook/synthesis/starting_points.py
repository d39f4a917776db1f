"""Points of a large plant's LMIs by equations, before anything is searched: K = 0 where
that will do, else the least effort that moves what must be moved, else a Riccati
equation. Each is judged by the blocks, in coordinates in which every mode has the size
one. Lightly damped modes with frequencies far apart kill the conjugate gradients that
large blocks need; an equation gives a point at once.
"""

from dataclasses import replace

import numpy as np
from scipy.linalg import (
    LinAlgError,
    block_diag,
    eigh,
    matrix_balance,
    schur,
    solve_discrete_are,
)

from ..analysis.riccati import lyapunov, riccati
from ..lmi.solution import CLEAR_MARGIN
from ..plants.descriptor import mean_descriptor
from ..plants.descriptor_system import DescriptorSystem
from ..plants.second_order import SecondOrderSystem
from ..runtime.time_limit import check_time, check_time_of_eigenvalues
from ..solver.loop import margin
from .scaled_lmis import ScaledLMIs
from .scaling import Frame
from .solution import Solution

MOST_PAIRS = 21  # of six vertices; of more Cuts look at few
ROUNDING = 1e-12  # of the largest entry of M
# of the input in the Riccati equation of a bounded response
WEIGHTS = 10.0 ** np.arange(4, -9, -1)
INSIDE = 1.01, 1.1, 1.5  # decays asked of the modes that move, relative to sigma
ONE, SEVERAL = 1e-3, 0.2  # of a mode's place, to the edge: nearer ones move, too
SLOWEST = 1e-6  # of the median frequency: rigid modes have none of their own
SHARES = 10.0 ** -np.arange(14)  # of room in a bounded real equation
DEFECTIVE = 1e5  # condition of eigenvectors; its square is that of P
NUDGE = 1e-5  # of the fastest mode: two equal ones are apart by its root then
RESIDUAL = 1e-6  # relative; a larger one is no solution's
FLOOR, ROOM = 1e-5, 0.99  # of the largest mode's start or push; of x0' P^-1 x0
NEWTON_STEPS = 4  # they square the residual, which begins near 1e-8
SCHUR = 4.0  # times as long as the eigenvalues
DISKS = 6  # centres that are tried, where a decay alone won't do

NOT_CENTRAL = "K is no analytic centre but found by an equation: {how}."


def point(request):
    """The Solution of a ``request`` by an equation; None where no candidate is one. Of
    several vertices the mean's is tried at all pairs; of many, or with a slack matrix,
    nothing is.
    """
    if len(request.pairs) > MOST_PAIRS or request.coupling.own_P:
        return None
    lmis = units_of_modes(request)
    if lmis is None or {u.name for u in lmis.unknowns} - {"P", "Y"}:
        return None
    loop = InFrame(request, lmis.frame)
    for how, K in loop.gains():
        for P in loop.lyapunov_matrices(K):
            check_time()
            found = at(lmis, {"P": P, "Y": K @ P})
            if found is None:
                continue
            if request.gain is not None:
                return found
            return replace(found, central=False, reason=NOT_CENTRAL.format(how=how))
    return None


def units_of_modes(request):
    """The `ScaledLMIs` of a ``request`` where every mode has the size one; None where M
    isn't positive definite.
    """
    T = balanced(request.plant.vertices[0], request.vertices[0])
    if T is None:
        return None
    push = np.linalg.solve(T, request.vertices[0].state_space()[1])
    unit_of_input = request.typical_rate / (np.linalg.norm(push, 2) or 1.0)
    return ScaledLMIs(request, Frame.at(request, T, unit_of_input))


def odd_mass(request):
    """True if the M of a request's plant is symmetric with a negative eigenvalue."""
    if isinstance(request.plant, DescriptorSystem):
        return False
    M = request.plant.vertices[0].M
    if np.abs(M - M.T).max() > ROUNDING * np.abs(M).max():
        return False
    sizes = np.linalg.eigvalsh(M)
    return bool(sizes[0] < -ROUNDING * sizes[-1])


def at(lmis, values):
    """The Solution at ``values`` by name, judged by the blocks ``lmis`` in their frame,
    for in the plant's units fast modes hide what slow ones keep; None outside.
    """
    margins = {name: margin(g) for name, g in lmis.text.blocks(values).items()}
    if not min(margins.values()) > CLEAR_MARGIN:
        return None
    natural = lmis.in_plant_units(values)
    K, P, Y, own = (natural[name] for name in ("K", "P", "Y", "own"))
    return Solution(
        lmis.request, "feasible", K, P, Y, None, margins, lmis.frame, own=own
    )


class InFrame:
    """The plant of a ``request`` in a ``frame``, and what may do for it."""

    def __init__(self, request, frame):
        there = request.ground.at(frame)
        self.d = mean_descriptor([there[i] for i in request.distinct])
        self.A, self.B, self.Bw = self.d.state_space()
        self.request, self.frame = request, frame
        self.reserve = ONE if len(request.distinct) == 1 else SEVERAL
        self.forms = [
            tuple(np.array(x, float) for x in r.pole_matrices())
            for r in request.demands
            if r.pole_matrices() is not None
        ]
        responses = [r.bounds_response() for r in request.demands]
        self.response = min((g for g in responses if g is not None), default=None)
        self.poles = np.linalg.eigvals(self.A)

    def gains(self):
        """(How it was made, gain) in the frame, the smallest first."""
        request, zero = self.request, np.zeros((self.request.plant.m, len(self.A)))
        if request.gain is not None:
            yield "", request.gain @ self.frame.T / self.frame.scale
            return
        yield "K = 0 keeps what is asked", zero
        if self.response is None:
            yield from self._moved()
        else:
            yield from self._of_riccati()

    def _moved(self):
        """Those that move the poles outside of the regions, and no others."""
        words = "the least effort moves {} of {} modes, and no other"
        sigma = self.decay()
        slowest = np.abs(self.poles).min() or np.median(np.abs(self.poles))
        for s in sigma * np.array(INSIDE) if sigma else [slowest / 10]:
            yield from self._deflated(least_effort(s), words)
        sizes = np.abs(self.poles)
        words = "a disk takes in {} of {} modes, and no other moves"
        for c in np.geomspace(max(sigma, sizes.min()), sizes.max(), DISKS):
            radius = self._radius(c)
            if radius is not None:
                yield from self._deflated(in_disk(c, radius), words)

    def moves(self, s):
        """True if a mode ``s`` must move."""
        return not self._keeps(s, self.reserve)

    def _deflated(self, design, words):
        try:
            K, count = deflated(self.A, self.B, self.moves, design)
        except (LinAlgError, ValueError):  # a mode that the inputs hardly reach
            return
        if np.isfinite(K).all():
            yield words.format(count, len(self.A)), K

    def _keeps(self, s, reserve):
        """True if a pole lies in all regions, and not at an edge."""
        return all(
            np.linalg.eigvalsh(a + s * b + np.conj(s) * b.T)[-1]
            < -reserve * max(np.abs(a).max(), 2 * abs(s.real) * np.abs(b).max())
            for a, b in self.forms
        )

    def decay(self):
        """The largest sigma of half-planes Re s < -sigma that the regions demand."""
        sigmas = [
            a[i, i] / (2 * b[i, i])
            for a, b in self.forms
            for i in range(len(a))
            if b[i, i] > 0
            and not (np.delete(b[i], i).any() or np.delete(a[i], i).any())
        ]
        return max(sigmas, default=0.0)

    def _radius(self, c):
        """The largest radius of a disk about -c in all regions; None if it is tiny."""
        angles = np.exp(1j * np.linspace(0, np.pi, 60))
        for radius in c * 0.99 * np.geomspace(1, 1e-3, 60):
            if all(self._keeps(-c + radius * z, 0.0) for z in angles):
                return 0.99 * radius
        return None

    def _of_riccati(self):
        """Those of the H-infinity Riccati equation with less and less weight of u."""
        d, one = self.d, np.eye(self.B.shape[1])
        words = "of the H-infinity Riccati equation"
        output = d.C.T @ d.C
        for weight in WEIGHTS:
            size = weight * np.linalg.norm(d.C, 2) ** 2
            signs = block_diag(
                size * one, -(self.response**2) * np.eye(self.Bw.shape[1])
            )  # of [u; w]
            try:
                X = riccati(self.A, np.hstack([self.B, self.Bw]), output, signs)
            except (LinAlgError, ValueError):
                continue
            yield words, -(self.B.T @ X) / size

    def lyapunov_matrices(self, K):
        """Lyapunov matrices that may prove a gain ``K``, in the frame."""
        A = self.A + self.B @ K
        if not np.linalg.eigvals(A).real.max() < 0:
            return
        if self.response is None:
            yield of_modes(A)
            starts = (r.bounds_input_from() for r in self.request.requirements)
            for x0 in (x for x in starts if x is not None):
                yield of_modes(A, K, np.linalg.solve(self.frame.T, x0))
            return
        P = bounded_real(A, self.Bw, self.d.output(K), self.response)
        if P is not None:
            yield P


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


def of_modes(A, K=None, x0=None):
    """P > 0 that keeps every region of the poles which the eigenvalues of ``A`` keep.
    With A V = V L the block of the region alpha, beta is (I x V) [alpha x I + beta x L
    + beta' x L*] (I x V*), and the bracket is diagonal but for order: so P = V V* keeps
    all regions at once. Columns of V have length one. Of a defective A they would make
    P singular: then they are those of an A whose diagonal has moved by next to nothing.

    With ``K`` and ``x0`` the columns' squares are weighted so that x0' P^-1 x0 < 1 and
    the trace of K P K' is the least: the sum over the modes of |w x0| |K v|, squared.
    """
    check_time_of_eigenvalues(len(A))
    modes, V = np.linalg.eig(A)
    if np.linalg.cond(V) > DEFECTIVE:
        size = NUDGE * np.abs(modes).max()
        V = np.linalg.eig(A + size * np.diag(np.linspace(-1, 1, len(A))))[1]
    if K is not None:
        starts, pushes = abs(np.linalg.solve(V, x0)), np.linalg.norm(K @ V, axis=0)
        starts, pushes = (x + FLOOR * (x.max() or 1.0) for x in (starts, pushes))
        weights = starts / pushes
        V = V * np.sqrt(weights * (starts @ (starts / weights)) / ROOM)
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
