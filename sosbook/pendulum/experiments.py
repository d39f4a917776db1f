"""The two experiments of the identification, as equations of motion.

The body swings under held wheels (4.16); the wheels turn on a body that
lies still (4.21). The second is the first without gravity.
"""

from math import sin, tanh

import numpy as np

from ..plants.checks import finite, positive

__all__ = ["chirp", "motion"]

STICTION_SPEED = 0.5  # rad/s, below which Coulomb friction fades: smooth, not stiff


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
