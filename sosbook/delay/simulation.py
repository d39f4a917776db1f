"""Responses of a closed loop whose control signal comes late."""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm

from ..analysis.response import disturbance, times, vector
from ..plants.checks import matrix

__all__ = ["DelayedResponse", "simulate_delay"]

GAUSS = (1 + np.sqrt(3 / 5) * np.array([-1, 0, 1])) / 2
# column j: coefficients in 1, s, s^2 of the parabola that is 1 at GAUSS[j]
PARABOLAS = np.linalg.inv(np.vander(GAUSS, increasing=True))
ENDS = np.vander([0.0, 1.0], 3, increasing=True) @ PARABOLAS
FINE = 0.04  # default step, as a part of the shortest time scale
STEPS = 1_000_000


@dataclass(frozen=True, eq=False)
class DelayedResponse:
    """Signals of a loop with a delay; columns belong to the times t.

    Parameters
    ----------
    t : (k,) array
        Times, in seconds.
    z, dz, e : (n, k) arrays
        Displacement, velocity, error z - r.
    u : (m, k) array
        What the controller asks for at t.
    applied : (m, k) array
        What reaches the plant at t: u(t - d(t)).
    x, dx : (N, k) arrays
        The state [z; z'; x3] and its derivative, from the right where
        it jumps.
    w : (p, k) array
        The disturbance.
    d : (k,) array
        The delay, in seconds.
    """

    t: np.ndarray
    z: np.ndarray
    dz: np.ndarray
    e: np.ndarray
    u: np.ndarray
    applied: np.ndarray
    x: np.ndarray
    dx: np.ndarray
    w: np.ndarray
    d: np.ndarray


def simulate_delay(d, K, t, delay, r=None, w=None, x0=None, history=None,
                   step=None):
    r"""Simulate one vertex whose input is late: u(t - d(t)).

    Parameters
    ----------
    d : Descriptor
    K : (m, N) array_like
        For t >= 0 the controller asks for u = K (x - [r; 0; 0]).
    t : (k,) array_like
        Increasing times, in seconds, from 0.
    delay : delay signal
        Such as `ConstantDelay`, see `sosbook.delay.profiles`.
    r : (n,) array_like, optional
        Constant set point from t = 0 on. The integrators get it at
        once, the plant late and through u. Its impulse r' is left out.
    w : Sine, optional
        Disturbance; it isn't delayed.
    x0 : (N,) array_like, optional
        State at t = 0; without it history(0), or zero.
    history : callable, optional
        ``history(s)`` is the state, an (N,) array_like, at one time
        s <= 0; then u(s) = K history(s) for s < 0. Without it the
        controller was off: u(s) = 0 for s < 0, also where x0 is given.
    step : float, optional
        Longest step, in seconds. Without it a step that suits the rates
        of loop, delay and disturbance: about eight digits. A plant with
        a very fast mode needs very short ones; give a longer step where
        that mode doesn't matter.

    Returns
    -------
    DelayedResponse

    Raises
    ------
    ValueError
        On wrong shapes, a delay that is none, a step that isn't
        positive or asks for more than a million steps, and where the
        motion runs away to infinity.

    Notes
    -----
    Method of steps with an exponential integrator. In each step a
    parabola through three Gauss points stands for the late input; the
    rest, matrix exponential and disturbance, is exact. The past of u is
    read off cubic Hermite polynomials: order four in the step. Jumps of
    the input, and the times at which these come back late, are ends of
    steps. Where t - d(t) lies within the step, a linear system is
    solved.

    Examples
    --------
    x' = -x(t - 1) from x = 1: the line 1 - t, then a parabola.

    >>> from sosbook.delay.profiles import ConstantDelay
    >>> from sosbook.plants.descriptor import Descriptor
    >>> one, none = np.eye(1), np.zeros((1, 1))
    >>> d = Descriptor(one, none, one, np.zeros((1, 0)), one)
    >>> answer = simulate_delay(d, [[-1.0]], [0, 1, 2], ConstantDelay(1),
    ...                         history=lambda s: [1.0])
    >>> answer.x.round(9) + 0.0
    array([[ 1. ,  0. , -0.5]])
    """
    n, N, p = len(d.C), len(d.E), d.Bw.shape[1]
    K = matrix("K", K, (d.Bu.shape[1], N))
    t = times(t)
    r = vector("r", r, n)
    past = _past(history, N)
    x0 = past(0.0) if x0 is None else vector("x0", x0, N)
    on, off, sine, level = disturbance(w, p)
    omega = 0.0 if w is None else w.omega
    A, B, Bw = d.state_space()
    _check(delay)
    if step is None:
        step = _default_step(A, B @ K, delay, omega, t[-1])
    tolerance = 1e-13 * t[-1]
    nodes, user = _mesh(t, delay, (on, off), step, tolerance)
    h = np.diff(nodes)
    middle = nodes[:-1] + h / 2

    # what isn't fed back in x': columns for 1, sin and cos of omega t
    columns = np.zeros((2, N, 3))
    columns[:, 2 * n:, 0] = -d.A[2 * n:, :n] @ r
    if w is not None:
        columns[1, :, 0] += Bw @ level
        columns[1, :, 1] = Bw @ sine
    active = ((on < middle) & (middle < off)).astype(int)
    waves = np.stack(
        [np.ones(len(nodes)), np.sin(omega * nodes), np.cos(omega * nodes)])
    kinds, kind = _kinds(active, h)
    flow, forced, weights = _exponentials(
        A, B, columns[active[kinds]], omega, h[kinds])
    push = np.einsum("kij,jk->ki", forced[kind], waves[:, :-1])
    outside = np.stack([
        np.einsum("kij,jk->ki", columns[active], waves[:, side])
        for side in (slice(None, -1), slice(1, None))
    ], 1)

    arrival = nodes[:-1, None] + h[:, None] * GAUSS
    asked = arrival - delay(arrival)
    if not (asked <= arrival + tolerance).all():
        raise ValueError("delay must be a number >= 0 at all times")
    record = _Record(nodes, K, K[:, :n] @ r, past, tolerance)
    late = asked[:, 1] >= -tolerance
    with np.errstate(over="ignore", invalid="ignore"):
        x = record.march(A, B, x0, asked, late, h, kind, flow, weights, push,
                         outside)
    if not np.isfinite(x).all():
        raise ValueError("the motion runs away to infinity: end t earlier")

    x, delays = x[user].T, delay(t)
    asked = t - delays
    applied = record(asked, asked >= -tolerance).T
    values = np.zeros((p, len(t)))
    if w is not None:
        values[:] = w(t)
    dx = A @ x + B @ applied + columns[0, :, :1] + Bw @ values
    u, z = K @ x - (K[:, :n] @ r)[:, None], x[:n]
    return DelayedResponse(t, z, x[n:2 * n], z - r[:, None], u, applied, x, dx,
                           values, delays)


def _check(delay):
    names = ("low", "high", "jumps")
    if not callable(delay) or not all(hasattr(delay, s) for s in names):
        raise ValueError(
            "delay must be a delay signal such as ConstantDelay(0.2), "
            f"got {delay!r}"
        )


def _past(history, N):
    """history as a function that checks what it returns."""
    if history is None:
        return lambda s: np.zeros(N)
    if not callable(history):
        raise ValueError("history must be a function of one time s <= 0")

    def past(s):
        x = np.asarray(history(s), float)
        if x.shape != (N,) or not np.isfinite(x).all():
            raise ValueError(f"history(s) must hold {N} finite numbers")
        return x

    return past


def _default_step(A, BK, delay, omega, end):
    """A small part of the shortest time scale.

    Wherever the loop vibrates or diverges, s lies within the spectra of
    A + BK exp(-s d) with modulus <= 1; three of them stand for all.
    """
    spectra = np.linalg.eigvals(np.stack([A, A + BK, A - BK]))
    rate = max(np.abs(spectra).max(), abs(omega))
    own = getattr(delay, "rate", 0.0)
    rate = rate * (1 + own * (delay.high - delay.low) / 2) + own
    return min(FINE / rate, end) if rate > 0 else end


def _mesh(t, delay, switches, step, tolerance):
    """Ends of the steps, and which of them are the times t.

    u jumps at 0, x' where u arrives, x'' where that comes back, and so
    on. Three rounds leave only jumps that the order of the method
    doesn't see.
    """
    if not np.isreal(step) or not np.isfinite(step) or step <= 0:
        raise ValueError(f"step must be a positive time, got {step!r}")
    end = t[-1]
    if end / step > STEPS:
        raise ValueError(
            f"t would take {end / step:.0f} steps: end it earlier, or give "
            "a longer step"
        )
    jumps = np.asarray(delay.jumps(end), float)
    edges = np.unique(np.concatenate([[0.0], jumps, [end]]))
    before = edges[1:] - 2 * tolerance
    even = np.linspace(0, end, int(np.ceil(end / step)) + 1)
    samples = np.unique(np.concatenate([edges, before, even]))
    asked = samples - delay(samples)
    # a time that the delay holds is read often: it ends a step
    held = edges[:-1] - delay(edges[:-1])
    same = np.abs(held - (before - delay(before))) <= 10 * tolerance
    fresh = np.array([s for s in (0.0, *switches) if 0 <= s < end])
    found = [jumps, held[same], fresh]
    for again in range(3):
        fresh = _arrivals(fresh, delay, samples, asked, tolerance)
        if not again:
            fresh = np.concatenate([fresh, jumps])
        fresh = _apart(fresh, tolerance)
        found.append(fresh)
    extra = np.concatenate(found)
    extra = _apart(extra[(extra > 0) & (extra < end)], tolerance)
    near = np.searchsorted(t, extra)
    gap = np.minimum(np.abs(t[near] - extra), np.abs(t[near - 1] - extra))
    nodes = np.sort(np.concatenate([t, extra[gap > 4 * tolerance]]))
    parts = np.ceil(np.diff(nodes) / step - 1e-9).astype(int).clip(1)
    first = np.cumsum(parts) - parts
    part = np.arange(parts.sum()) - np.repeat(first, parts)
    fine = np.repeat(nodes[:-1], parts) + part * np.repeat(
        np.diff(nodes) / parts, parts)
    user = np.append(first, parts.sum())[np.searchsorted(nodes, t)]
    return np.append(fine, end), user


def _apart(s, tolerance):
    """Sorted, and what lies closer than the tolerance only once."""
    s = np.unique(s)
    return s[np.diff(s, prepend=-np.inf) > 4 * tolerance]


def _arrivals(marks, delay, samples, asked, tolerance):
    """The times t at which t - d(t) passes one of the marks."""
    first = np.searchsorted(samples, marks + delay.low - tolerance) - 1
    last = np.searchsorted(samples, marks + delay.high + tolerance)
    first, last = first.clip(0), last.clip(0, len(samples) - 1)
    which = np.repeat(np.arange(len(marks)), last - first)
    begin = np.cumsum(last - first) - (last - first)
    left = np.arange(len(which)) + (first - begin)[which]
    passed = asked[left] >= marks[which] - tolerance
    upward = asked[left + 1] >= marks[which] - tolerance
    changed = passed != upward
    which, left, upward = which[changed], left[changed], upward[changed]
    marks = marks[which] - tolerance
    low, high = samples[left], samples[left + 1]
    while len(low) and (high - low).max() > tolerance / 4:
        middle = (low + high) / 2
        above = (middle - delay(middle) >= marks) == upward
        low, high = np.where(above, low, middle), np.where(above, middle, high)
    return high


def _kinds(active, h):
    """One representative of each kind of step; the kind of each step."""
    mantissa, exponent = np.frexp(h)
    rounded = np.ldexp(np.round(mantissa * 2.0**36), exponent)
    _, kinds, kind = np.unique(
        np.where(active, rounded, -rounded), return_index=True,
        return_inverse=True)
    return kinds, kind


def _exponentials(A, B, columns, omega, h):
    """What a step makes of the state, of [1, sin, cos] and of the input.

    The state is joined by these three and by the input's parabola
    (three values, one after the other, of m entries each); the time is
    measured in steps.
    """
    (N, m), h = B.shape, h[:, None, None]
    joined = np.zeros((len(h), N + 3 + 3 * m, N + 3 + 3 * m))
    joined[:, :N, :N] = A * h
    joined[:, :N, N:N + 3] = columns * h
    joined[:, N + 1, N + 2] = omega * h[:, 0, 0]
    joined[:, N + 2, N + 1] = -omega * h[:, 0, 0]
    joined[:, :N, N + 3:N + 3 + m] = B * h
    ahead = np.arange(N + 3, N + 3 + 2 * m)
    joined[:, ahead, ahead + m] = 1
    done = expm(joined)[:, :N]
    powers = done[:, :, N + 3:].reshape(-1, N, 3, m)
    scaled = np.array([1, 1, 2])[:, None] * PARABOLAS
    weights = np.einsum("knim,ij->knjm", powers, scaled)
    return done[:, :, :N], done[:, :, N:N + 3], weights


def _hermite(s):
    """Weights of [value, slope] at 0 and at 1, last axis."""
    return np.stack([
        (1 + 2 * s) * (1 - s)**2, s * (1 - s)**2,
        s**2 * (3 - 2 * s), s**2 * (s - 1),
    ], -1)


class _Record:
    """The control signal u so far; a step's cubic is a row of ``table``.

    Parameters
    ----------
    nodes : (k + 1,) array
        Ends of the steps.
    K : (m, N) array
    level : (m,) array
        K [r; 0; 0].
    past : callable
        The state before t = 0.
    tolerance : float
        In seconds.
    """

    def __init__(self, nodes, K, level, past, tolerance):
        self.nodes, self.K, self.level = nodes, K, level
        self.past, self.tolerance = past, tolerance
        self.table = np.zeros((len(nodes) - 1, 4, len(K)))

    def __call__(self, s, late):
        """u at the times s, from the controller where ``late``."""
        row, weights, fixed = self.look_up(s, late)
        return fixed + (weights[..., None] * self.table[row]).sum(-2)

    def look_up(self, s, late):
        """Row of the table, weights of its entries, and what is known."""
        # of rounding, and of jumps that a delay doesn't tell
        s = np.where(late, np.maximum(s, 0), np.minimum(s, 0))
        row = np.searchsorted(self.nodes, s - self.tolerance) - 1
        row = row.clip(0, len(self.table) - 1)
        start = self.nodes[row]
        weights = _hermite((s - start) / (self.nodes[row + 1] - start))
        weights[~late] = 0
        fixed = np.zeros((*s.shape, len(self.K)))
        fixed[~late] = np.reshape(
            [self.K @ self.past(one) for one in s[~late]], (-1, len(self.K)))
        return row, weights, fixed

    def march(self, A, B, x0, asked, late, h, kind, flow, weights, push,
              outside):
        """The state at the nodes."""
        K, table, points = self.K, self.table, len(GAUSS)
        (N, m), count = B.shape, len(h)
        row, cubic, fixed = self.look_up(
            asked, np.repeat(late[:, None], points, 1))
        own = np.arange(count)
        inside = late[:, None] & (row >= own[:, None])
        row = np.minimum(row, own[:, None])
        implicit = inside.any(1)
        needs = np.where(late[:, None], row, -1).max(1)

        KA, KB = K @ A, K @ B
        cubic = cubic[:, :, None]
        outside = outside @ K.T
        wide = weights.reshape(-1, N, points * m)
        solve = self.solutions(
            implicit, inside, cubic[:, :, 0], h, KA, KB, weights, kind)

        x = np.empty((count + 1, N))
        x[0] = x0
        pairs = np.lib.stride_tricks.sliding_window_view(x, (2, N))[:, 0]
        both = np.hstack([K.T, KA.T])

        def write(i, j, come=None):
            """Rows i to j of the table, from the states at their ends."""
            ends = pairs[i:j] @ both
            table[i:j, 0::2] = ends[..., :m] - self.level
            slopes = ends[..., m:] + outside[i:j]
            if come is not None:
                slopes += ENDS @ come @ KB.T
            table[i:j, 1::2] = h[i:j, None, None] * slopes

        flows = list(flow)
        kinds, needs = kind.tolist(), needs.tolist()
        i = 0
        while i < count:
            j = i + 1
            if implicit[i]:
                x[j] = flows[kinds[i]] @ x[i] + push[i]
                write(i, j)  # as if the input were zero
            else:
                while j < count and needs[j] < i:
                    j += 1
            come = fixed[i:j] + (cubic[i:j] @ table[row[i:j]])[:, :, 0]
            flat = come.reshape(j - i, -1, 1)
            if implicit[i]:
                flat = solve[i] @ flat
                come = flat.reshape(come.shape)
            new = (wide[kind[i:j]] @ flat)[..., 0] + push[i:j]
            now = x[i]
            for k, change in enumerate(new, i):
                now = flows[kinds[k]] @ now + change
                x[k + 1] = now
            write(i, j, come)
            i = j
        return x

    def solutions(self, implicit, inside, cubic, h, KA, KB, weights, kind):
        """Of an implicit step: from the input's known part to the input.

        The cubic of the step itself depends on the input that it gives:
        its end value on all of it, its slopes also directly.
        """
        steps, m = np.flatnonzero(implicit), len(KB)
        W, size = weights[kind[steps]], h[steps, None, None, None]
        end = np.einsum("mn,knjl->kmjl", self.K, W)
        ends = [size * KB[:, None, :] * side[:, None] for side in ENDS]
        ends[1] = ends[1] + size * np.einsum("mn,kjnl->kmjl", KA,
                                             W.transpose(0, 2, 1, 3))
        c = (cubic * inside[..., None])[steps][..., None, None, None]
        part = (c[:, :, 1] * ends[0][:, None] + c[:, :, 2] * end[:, None]
                + c[:, :, 3] * ends[1][:, None])
        part = part.reshape(len(steps), 3 * m, 3 * m)
        return dict(zip(steps.tolist(), np.linalg.inv(np.eye(3 * m) - part)))
