"""The channel of a norm in sampled loops: w, held over a tick, and outputs z."""

from dataclasses import replace

import numpy as np

from ..exact.definite import exact
from ..language import block, eye, kron
from .lyapunov import discrete_lyapunov
from .system import SampledSystem

GRID = 200  # frequencies at which a norm is looked at
SMALL = 1e-8  # of the weight, in every direction: so that all states count


def checked_norm(norm):
    """The ``norm``, an `HInfinity`; a ValueError for bounds that authors wrote."""
    own = type(norm).__module__.startswith("sosbook.requirements.")
    if not own or getattr(norm, "bounds_response", lambda: None)() is None:
        raise ValueError(f"norm must be an HInfinity with a bound, got {norm!r}")
    return norm


def check_channel(X, k):
    """Raise unless X is [Y, 0; 0, I] with k channels last."""
    rest = X[len(X) - k :] - np.eye(k, len(X), len(X) - k)
    if k and (rest.any() or X[: len(X) - k, len(X) - k :].any()):
        raise ValueError("a Lyapunov matrix weighs the norm's channels otherwise")


def with_channel(norm, vertices, full, own, read=None):
    """The maps and the vertices of `SampledFamily.of` with w and z, and their number.

    ``norm``: which bound, of which outputs; ``vertices``: the plants; ``full`` and
    ``own``: the maps without w and z; ``read``: see `SampleTiming.read`. Both are as
    many: zeros join the fewer ones.
    """
    seen = [norm.seen(d).map(exact) for d in vertices]
    first, bound = seen[0], exact(norm.bounds_response())
    for name in ("C", "Du", "Dw"):
        x, *others = (getattr(d, name) for d in seen)
        if any(np.shape(x) != np.shape(y) or np.any(x != y) for y in others):
            raise ValueError(f"{norm.name}: its output differs from plant to plant")
    if any(d.Ca is not None for d in seen):
        raise ValueError(
            f"{norm.name}: an acceleration jumps at the ticks; weigh positions, "
            "velocities, integrals or inputs of a sampled loop"
        )
    N, m = first.Bu.shape
    (p, q), order = (first.Bw.shape[1], len(first.C)), full.shape[1]
    k, rest = max(p, q), len(full) - N - m

    def zero(*shape):
        return exact(np.zeros(shape))

    Du = zero(q, m) if first.Du is None else first.Du
    Dw = zero(q, p) if first.Dw is None else first.Dw
    rows = np.hstack([first.C, zero(q, rest), Du, Dw, zero(q, k - p)]) / bound
    full = np.vstack([np.hstack([full, zero(len(full), k)]), zero(k, order + k)])
    full[-k:, order:] = exact(np.eye(k))
    own = np.hstack([own, zero(len(own), k)])
    if read is not None:
        some = slice(None) if norm.inputs is None else list(norm.inputs)
        at_once, later = (x[:, some] for x in read)
        full[-k - m : -k, order : order + p] = at_once
        own[:, order : order + p] = later
    own = np.vstack([own, rows @ full, zero(k - q, order + k)])
    wide = [
        replace(d.map(exact), Bu=np.hstack([s.Bu, s.Bw, zero(N, k - p)]))
        for d, s in zip(vertices, seen)
    ]
    return full, own, wide, k


def too_large(M, k):
    """The words where the norm, by floats, of a loop M with k channels is above one."""
    if not k:
        return ""
    N = len(M) - k
    F, B, C, D = M[:N, :N], M[:N, N:], M[N:, :N], M[N:, N:]
    turns = np.abs(np.angle(np.linalg.eigvals(F)))
    turns = np.concatenate([turns, [0.0], np.geomspace(1e-4, 1, GRID) * np.pi])
    answers = SampledSystem(F, B, C, D, 1.0).at(np.exp(1j * turns))
    peak = np.linalg.norm(answers, 2, axis=(1, 2)).max()
    return "" if peak < 1 else f"its norm is {peak:.6g} times the bound"


def equalled(M, N):
    """Coordinates of a loop M's N states in which w's work is what z sees."""
    F, B, C = M[:N, :N], M[:N, N:], M[N:, :N]
    turn = np.eye(len(M))
    if abs(np.linalg.eigvals(F)).max() < 1:
        X, Y = (
            discrete_lyapunov(A, W + SMALL * (np.trace(W) or 1.0) * np.eye(N))
            for A, W in ((F, C.T @ C), (F.T, B @ B.T))
        )
        R, good = root(X), np.isfinite([X, Y]).all()
        sizes, U = np.linalg.eigh(R @ Y @ R.T) if good else (np.zeros(1), R)
        if sizes[0] > 0:
            turn[:N, :N] = (U / sizes**0.25).T @ R
    return turn


def joined_P(values, name, held):
    """P by its ``name`` among ``values``, and of ``held`` channels, of the size c."""
    P = values[name]
    return block([[P, 0], [0, kron(values["c"], eye(held))]]) if held else P


def root(P):
    """R with R'R = P; the identity where P isn't positive definite, or infinite."""
    if not np.isfinite(P).all():  # too close to the rate
        return np.eye(len(P))
    try:
        return np.linalg.cholesky((P + P.T) / 2).T
    except np.linalg.LinAlgError:
        return np.eye(len(P))
