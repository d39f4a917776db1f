"""The matrices of a controller from tick to tick, and where its memory starts."""

import numpy as np

from ..exact.rational import exact, round_digits
from ..plants.gain import signals
from ..runtime.libraries import library
from ..sampled.system import SampledSystem
from .memory import DIGITS, ROUNDING, assembled, forgetting, shifted


def matrices_of(c):
    """The matrices of a controller c by name, and its memory's ``states`` in words."""
    e, T, tracking_time = c.estimate, c.T, c.limits.tracking_time
    K_P = c.gains[0][:, : len(c.R)]
    K_r, size = -K_P @ c.R, abs(K_P) @ abs(c.R)
    K_r = np.where(abs(K_r) <= ROUNDING * size, 0.0, K_r) + 0.0
    parts, words = assembled(e, c.timing, c.gains[0], c.gains[1], c.sums, T, K_r)
    if e.errors:
        parts = shifted(parts, e.start, c.R)
    a, W = c.gains[1].shape[1], parts["W"].copy()
    if a and tracking_time:
        back = np.linalg.pinv(c.gains[1]) * (T / tracking_time)
        W[len(W) - a :] = round_digits(back, DIGITS)
    elif e.winds_up and tracking_time:
        W = forgetting(parts["A"], parts["C"], np.exp(-T / tracking_time))
    return parts | {"W": W, "states": words}


def start_of(c):
    """(l, q): the memory of a controller c at the start, of what is measured there."""
    e, q = c.estimate, len(c.readings.signals)
    found = np.zeros((len(c.A), q))
    found[: len(e.start)] = e.start
    a = c.gains[1].shape[1]
    if a:
        r = np.zeros((len(c.set_points), q))
        for j, k in enumerate(c.followed):
            r[j, q if k is None else k :][:1] = 1
        asked = c.gains[0] @ (e.stay @ e.start + e.take) + c.D_r @ r
        back = -np.linalg.pinv(c.gains[1]) @ asked
        found[len(found) - a :] = round_digits(back, DIGITS)
    return found + 0.0


def from_state(c):
    """The system of a controller c from the plant's state, and from w by what is read,
    to u, rounded to doubles.
    """

    def of(rows):
        return (np.asarray(exact(M) @ exact(rows), float) for M in (c.B, c.D))

    (B, D), noise = of(c.readings.rows), c.readings.noise
    B_w, D_w = of(noise) if noise.any() else (None, None)
    names = signals(c.plant), tuple(s.name for s in c.outputs)
    return SampledSystem(c.A, B, c.C, D, c.T, B_w, D_w, *names)


def state_space(c):
    """A controller c as python-control's StateSpace from [y; r] to u, with names."""
    inputs = [s.name.replace(".", "_") for s in (*c.readings.signals, *c.set_points)]
    names = dict(inputs=inputs, outputs=[s.name for s in c.outputs])
    B, D = np.hstack([c.B, c.B_r]), np.hstack([c.D, c.D_r])
    return library("control").ss(c.A, B, c.C, D, c.T, **names)
