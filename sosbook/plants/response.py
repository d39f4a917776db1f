"""Exact responses of a loop to set points and disturbances."""

from dataclasses import dataclass, replace

import numpy as np
from flint import arb, arb_mat, ctx
from scipy.linalg import expm

from ..exact.definite import exact
from ..exact.rational import inverse
from .checks import numbers
from .signals import signal_parts, steps

RESPONSES = ("z", "dz", "e", "x")  # what superposition adds
BITS = 256, 1024, 4096  # of the balls, until they are small enough
SMALL = 1e-17  # radius of the balls, by the largest entry


@dataclass(frozen=True, eq=False)
class Response:
    """Signals of a simulated loop; columns belong to the times t.

    Parameters
    ----------
    t : (k,) array
        Times, in seconds.
    z, dz, e : (n, k) arrays
        Displacement, velocity, error z - r.
    u : (m, k) array
        The whole control signal, with K_A e'' where there is one.
    x : (N, k) array
        The state [z; z'; x3].
    w : (p, k) array
        The disturbance.
    """

    t: np.ndarray
    z: np.ndarray
    dz: np.ndarray
    e: np.ndarray
    u: np.ndarray
    x: np.ndarray
    w: np.ndarray


def simulate(d, K, t, r=None, w=None, x0=None, K_A=None, precise=False):
    """Simulate one vertex exactly (matrix exponentials, no ODE solver).

    Parameters
    ----------
    d : Descriptor
        The plant in descriptor form.
    K : (m, N) array
        The gain of u = K x.
    t : (k,) array_like
        Increasing times, in seconds, from 0.
    r : (n,) array_like, Step, Steps or Ramps, optional
        Set point; an array holds from t = 0 on. K_D sees its slope r', but no
        impulse of a jump, and K_A no r''. At a jump e and u have the value after it.
    w : Sine, Step, Steps or Ramps, optional
        Disturbance.
    x0 : (N,) array_like, optional
        Initial state; zero without it.
    K_A : (m, n) array, optional
        Acceleration gain, to be counted in u.
    precise : bool
        Take the exponentials of exact matrices: for loops whose poles are lost
        in the rounding errors of A + B K.

    Returns
    -------
    Response
        The motion at the times t.
    """
    n, N, p = len(d.C), len(d.E), d.Bw.shape[1]
    t = times(t)
    r = steps(r, n)
    x0 = vector("x0", x0, N)
    A = np.linalg.solve(d.E, d.A + d.Bu @ K)
    _, B, Bw = d.state_space()
    on, off, sine, level, pieces = signal_parts("w", w, p, "F")
    number, flow, forms = np.asarray, _flow, (A, B, Bw)
    if precise:
        number, flow, forms = exact, exact_flow, exact_forms(d, K)
    corners = [s for s in (on, off, *r.times) if 0 < s < t[-1]]
    corners += [] if pieces is None else [s for s in pieces.times if s < t[-1]]
    nodes = np.unique(np.concatenate([t, corners]))
    E, A_d = number(d.E[2 * n :, 2 * n :]), number(d.A[2 * n :, : 2 * n])
    where = -forms[1] @ number(K[:, : 2 * n])  # how [r; r'] enters: K may cancel there
    where[2 * n :] -= (inverse(E) if precise else np.linalg.inv(E)) @ A_d
    where = where if pieces is None else np.hstack([where, forms[2]])
    inward, chain, v = entering(-np.eye(2 * n), r, pieces, nodes)
    # the state joined by v and [1, sin(omega t), cos(omega t)]
    L = N + len(v)
    quiet = number(np.zeros((L + 3, L + 3)))
    quiet[:N, :N], quiet[:N, N : N + len(inward)] = forms[0], where[:, inward]
    quiet[N:L, N:L] = number(chain)
    loud = quiet.copy()
    if sine is not None:
        omega = number(np.array(w.omega, float)).item()
        loud[:N, L] += forms[2] @ number(level)
        loud[:N, L + 1] = forms[2] @ number(sine)
        loud[L + 1, L + 2], loud[L + 2, L + 1] = omega, -omega
    active = (on <= nodes) & (nodes < off)
    phase = (0.0 if sine is None else w.omega) * nodes
    joined = np.vstack(
        [np.empty((N, len(nodes))), v, nodes**0, np.sin(phase), np.cos(phase)]
    )
    joined[:N, 0] = x0
    spans, cache = np.diff(nodes), {}
    rounded = {span: f"{span:.11e}" for span in np.unique(spans)}
    for k, span in enumerate(spans.tolist()):
        key = (active[k], rounded[span])
        if key not in cache:
            cache[key] = flow(loud if active[k] else quiet, span)
        joined[:N, k + 1] = (cache[key] @ joined[:, k])[:N]
    here = np.searchsorted(nodes, t)
    x, goal = joined[:N, here], r(t)
    values = np.zeros((p, len(t)))
    if w is not None:
        values[:] = w(t)
    u = K @ (x - np.vstack([goal, r.slope(t), np.zeros((N - 2 * n, len(t)))]))
    if K_A is not None and np.any(K_A):
        rate = A @ x + quiet[:N, N:L].astype(float) @ v[:, here]
        rate += 0 if sine is None else Bw @ values
        u = u + K_A @ rate[n : 2 * n]
    z = x[:n]
    return Response(t, z, x[n : 2 * n], z - goal, u, x, values)


def simulate_open(d, t, x0=None, u=None, w=None):
    """Simulate a vertex d without a controller at times ``t`` from ``x0`` under an
    input ``u`` and a disturbance ``w``, as in `SecondOrderSystem.simulate`.
    """
    m, N = d.Bu.shape[1], len(d.E)
    signal_parts("u", u, m, "B")
    free = simulate(d, np.zeros((m, N)), t, w=w, x0=x0)
    if u is None:
        return free
    pushed = simulate(replace(d, Bw=d.Bu), np.zeros((m, N)), t, w=u)
    sums = {name: getattr(free, name) + getattr(pushed, name) for name in RESPONSES}
    return replace(free, **sums, u=pushed.w)


def _flow(generator, span):
    return expm(generator * span)


def entering(rows, r, pieces, nodes):
    """The signals v that enter a loop, -rows [r; r'] and the ``pieces`` of a force:
    which of them aren't zero, the matrix of d/dt [v; v'], and [v; v'] at ``nodes``.
    """
    slope = r.slope(nodes)
    v, dv = -rows @ np.vstack([r(nodes), slope]), -rows[:, : len(slope)] @ slope
    if pieces is not None:
        v, dv = np.vstack([v, pieces(nodes)]), np.vstack([dv, pieces.slope(nodes)])
    rising = dv.any(axis=1)
    inward = np.flatnonzero(v.any(axis=1) | rising)
    slopes = np.flatnonzero(rising)
    chain = np.zeros((len(inward) + len(slopes),) * 2)
    chain[np.searchsorted(inward, slopes), len(inward) + np.arange(len(slopes))] = 1
    return inward, chain, np.vstack([v[inward], dv[slopes]])


def times(t):
    """The times t as an array, which must increase from 0."""
    t = numbers("t", t)
    good = t.ndim == 1 and len(t) > 1 and np.isfinite(t).all()
    if not good or t[0] != 0 or (np.diff(t) <= 0).any():
        raise ValueError("t must increase from 0 and hold two times or more")
    return t


def vector(name, value, size):
    """A value as ``size`` finite numbers, zero for None; its name is for a refusal."""
    vector = np.zeros(size) if value is None else numbers(name, value)
    if vector.shape != (size,) or not np.isfinite(vector).all():
        raise ValueError(
            f"{name} must hold {size} finite numbers, got the shape {vector.shape}"
            if vector.shape != (size,)
            else f"{name} must hold {size} finite numbers, got {vector.tolist()}"
        )
    return vector


def sort_poles(poles):
    """The poles sorted by real part, then imaginary part; floats if all are real."""
    poles = np.asarray(poles)
    if np.abs(np.imag(poles)).max(initial=0) == 0:
        return np.sort(poles.real)
    order = np.lexsort((poles.imag, np.round(poles.real, 9)))
    return poles[order]


def exact_forms(d, K):
    """A + B K, B and B_w of a loop x' = A x + B u + B_w w, u = K x, without a rounding
    error, of a ``Descriptor`` d in floats that are read as decimals.
    """
    d, K = d.map(exact), exact(K)
    back = inverse(d.E)
    return back @ (d.A + d.Bu @ K), back @ d.Bu, back @ d.Bw


def exact_flow(generator, span):
    """e^(generator span) of a rational ``generator``, ``span`` in s, in floats."""
    rows = (generator * exact(float(span))).tolist()
    for bits in BITS:
        with ctx.workprec(bits):
            power = arb_mat([[arb(e) for e in row] for row in rows]).exp().table()
            middle = np.array([[float(e.mid()) for e in row] for row in power])
            radius = max(float(e.rad()) for row in power for e in row)
        if radius <= SMALL * np.abs(middle).max():
            break
    return middle
