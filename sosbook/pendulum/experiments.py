"""The two experiments of the identification, as equations of motion.

The body swings under held wheels (4.16); the wheels turn on a body that
lies still (4.21). The second is the first without gravity.
"""

from math import sin, tanh

import numpy as np
from scipy.linalg import solve_banded

from ..plants.checks import finite, positive

__all__ = ["chirp", "motion", "motion_slopes"]

STICTION_SPEED = 0.5  # rad/s, below which Coulomb friction fades: smooth, not stiff
NEAR = 1e-7  # of a number, by which it is moved for a slope; roundings are 1e-16


def chirp(first, last, seconds=30.0, rate=100.0, amplitude=1.85):
    """A sine that sweeps from one frequency to another and back.

    ``first``, ``last``: frequencies in Hz. The frequency changes linearly; ``seconds``:
    how long the sweep takes, either way; ``rate``: samples per second; ``amplitude``:
    the largest voltage, in V. A quarter of 7.4 V, as in the thesis, is 1.85 V. Returns
    t, V, (N,): time in s, voltage in V, rounded to the millivolt: the step of the pulse
    width. Raises ValueError if a number isn't positive.

    Source: thesis sections 4.2.1 (1 Hz to 20 Hz) and 4.2.2 (0.3 Hz to
    30 Hz). That it is a sine, and linear, is our reading.
    """
    asked = dict(first=first, last=last, seconds=seconds, rate=rate)
    for name, value in (asked | dict(amplitude=amplitude)).items():
        positive(name, value)
    t = np.arange(round(2 * seconds * rate)) / rate
    s = np.minimum(t, 2 * seconds - t)  # mirrored in time
    turns = first * s + (last - first) * s**2 / (2 * seconds)
    back = t > seconds
    top = (first + last) * seconds / 2  # turns made at the far end
    turns[back] = 2 * top - turns[back]
    V = np.round(amplitude * np.sin(2 * np.pi * turns), 3)
    return t, V + 0.0  # no minus zero


def motion(e, f, d, V, T, friction=0.0, steps=2, stick=STICTION_SPEED):
    r"""Angle and speed of q'' = e V - f q' - d sin q, from rest.

    ``e``, ``f``, ``d``: divided by the inertia: rad/s^2/V, 1/s, 1/s^2. With d = 0 it is
    the wheels' experiment; with -e/c, f/c, d/c it is the body's, and q = theta - pi;
    ``V``, (N,): voltage, held from one sample to the next; ``T``: sampling time in s,
    or the time from each sample to the next; ``friction``: coulomb friction: the
    voltage that just overcomes it; ``steps``: Runge-Kutta steps per sample; ``stick``:
    the speed in rad/s below which the friction fades. Returns q, w, (N,): angle and
    speed before V[k] acts. Raises ValueError if a number isn't finite, or T or
    ``steps`` isn't positive.

    Source: thesis (4.16) without linearisation, and (4.21).
    """
    e, f, d = finite("e", e), finite("f", f), finite("d", d)
    V = np.asarray(V, dtype=float)
    spans = np.broadcast_to(np.asarray(T, float), V.shape)
    positive("T", float(spans.min()))
    spans = (spans / positive("steps", steps)).tolist()
    held = abs(e) * finite("friction", friction)
    q = w = 0.0
    path, rounds = [], range(steps)
    for volt, h in zip(V.tolist(), spans):
        path.append((q, w))
        force, half, sixth = e * volt, h / 2, h / 6
        for _ in rounds:  # written out: calls of a function take as long
            pull = held * tanh(w / stick) if held else 0.0
            a1 = force - f * w - (d * sin(q) if d else 0.0) - pull
            w2 = w + half * a1
            pull = held * tanh(w2 / stick) if held else 0.0
            a2 = force - f * w2 - (d * sin(q + half * w) if d else 0.0) - pull
            w3 = w + half * a2
            pull = held * tanh(w3 / stick) if held else 0.0
            a3 = force - f * w3 - (d * sin(q + half * w2) if d else 0.0) - pull
            w4 = w + h * a3
            pull = held * tanh(w4 / stick) if held else 0.0
            a4 = force - f * w4 - (d * sin(q + h * w3) if d else 0.0) - pull
            q += sixth * (w + 2 * w2 + 2 * w3 + w4)
            w += sixth * (a1 + 2 * a2 + 2 * a3 + a4)
    q, w = np.array(path).T
    return q, w


def motion_slopes(q, w, e, f, d, V, T, friction=0.0, steps=2, stick=STICTION_SPEED):
    r"""The derivatives of a `motion` q, w to e, f, d and the friction.

    Each step is differentiated for itself, all at once; then the changes are followed,
    x_k' = A_k x_{k-1}' + b_k. The arguments V, T, ``steps`` and ``stick`` are those of
    the `motion`. Returns dq, dw, (N, 4), in the order of the arguments.
    """
    V = np.asarray(V, float)
    h = np.broadcast_to(np.asarray(T, float), V.shape)[:-1] / steps
    at = np.array([0.0, 0.0, e, f, d, friction])
    size = np.where(at == 0, 1.0, abs(at))
    size[:2] = 1 + abs(q).max(), 1 + abs(w).max()
    moved = NEAR * np.vstack([np.zeros(6), np.diag(size)])[:, :, None]
    e, f, d, rub = (at[2:, None] + moved[:, 2:]).swapaxes(0, 1)
    x, v, held = q[:-1] + moved[:, 0], w[:-1] + moved[:, 1], abs(e) * rub

    def rate(q, w):
        pull = held * np.tanh(w / stick) if held.any() else 0.0
        return e * V[:-1] - f * w - d * np.sin(q) - pull

    for _ in range(steps):  # as in `motion`
        a1 = rate(x, v)
        v2 = v + h / 2 * a1
        a2 = rate(x + h / 2 * v, v2)
        v3 = v + h / 2 * a2
        a3 = rate(x + h / 2 * v2, v3)
        v4 = v + h * a3
        a4 = rate(x + h * v3, v4)
        x = x + h / 6 * (v + 2 * v2 + 2 * v3 + v4)
        v = v + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
    by = (np.array([x, v])[:, 1:] - np.array([x, v])[:, :1]) / (NEAR * size)[:, None]
    bands = np.zeros((4, 2 * len(q)))  # of [q_0, w_0, q_1, w_1, ...], below the ones
    bands[0] = 1.0
    bands[1, 1:-2:2] = -by[0, 1]
    bands[2, :-2:2], bands[2, 1:-2:2] = -by[0, 0], -by[1, 1]
    bands[3, :-2:2] = -by[1, 0]
    given = np.zeros((len(q), 2, 4))
    given[1:] = by[:, 2:].transpose(2, 0, 1)
    found = solve_banded((3, 0), bands, given.reshape(-1, 4)).reshape(given.shape)
    return found[:, 0], found[:, 1]
