"""What a closed loop really does: poles, norms, peaks."""

import control
import numpy as np
from scipy.linalg import expm
from scipy.optimize import minimize_scalar

from .system import sort_poles

__all__ = ["closed_loop", "hinf_norm", "loop_matrix", "peak_input"]


def loop_matrix(d, K):
    """E^-1 (A + B_u K) of one vertex."""
    return np.linalg.solve(d.E, d.A + d.Bu @ K)


def poles(d, K):
    """Closed-loop poles of one vertex, in rad/s, sorted."""
    return sort_poles(np.linalg.eigvals(loop_matrix(d, K)))


def closed_loop(d, K):
    """The loop as python-control's StateSpace.

    Parameters
    ----------
    d : Descriptor
    K : (m, N) array

    Returns
    -------
    control.StateSpace
        Inputs w (p of them), then r (n). Outputs z (n), then u = K_P e
        + K_D e' + K_I x3 (m), for r constant (r' = 0); an acceleration
        term K_A e'' is inside the loop but not in this u.

    Notes
    -----
    Source: thesis (2.8), with x3 = + integral of U e.
    """
    n, N = len(d.C), len(d.E)
    _, B, Bw = d.state_space()
    A = loop_matrix(d, K)
    set_point = np.zeros((N, n))
    set_point[2 * n:] = -d.A[2 * n:, :n]
    K_P = K[:, :n]
    D = np.zeros((n + len(K), d.Bw.shape[1] + n))
    D[n:, d.Bw.shape[1]:] = -K_P
    names = {
        "inputs": [f"w{k + 1}" for k in range(d.Bw.shape[1])]
        + [f"r{k + 1}" for k in range(n)],
        "outputs": [f"z{k + 1}" for k in range(n)]
        + [f"u{k + 1}" for k in range(len(K))],
    }
    return control.ss(
        A, np.hstack([Bw, set_point - B @ K_P]),
        np.vstack([d.C, K]), D, **names,
    )


def hinf_norm(d, K):
    """H-infinity norm from w to z; infinite for an unstable loop."""
    _, _, Bw = d.state_space()
    A = loop_matrix(d, K)
    if np.linalg.eigvals(A).real.max() >= 0:
        return np.inf
    zero = np.zeros((len(d.C), Bw.shape[1]))
    norm = control.system_norm(
        control.ss(A, Bw, d.C, zero), p="inf", print_warning=False
    )
    return float(norm)


def peak_input(d, K, x0):
    """The largest |K x(t)| of the free response from x0.

    Infinite for an unstable loop.
    """
    A = loop_matrix(d, K)
    poles = np.linalg.eigvals(A)
    if poles.real.max() >= 0:
        return np.inf
    step = 0.05 / np.abs(poles).max()
    count = min(int(np.ceil(8 / -poles.real.max() / step)), 20000)
    forward = expm(A * step)
    states = np.empty((count + 1, len(A)))
    states[0] = x0
    for k in range(count):
        states[k + 1] = forward @ states[k]
    sizes = np.linalg.norm(states @ K.T, axis=1)
    top = int(sizes.argmax())
    start = states[max(top - 1, 0)]
    near = minimize_scalar(
        lambda t: -np.linalg.norm(K @ expm(A * t) @ start),
        bounds=(0, 2 * step), method="bounded",
    )
    return float(max(sizes[top], -near.fun))
