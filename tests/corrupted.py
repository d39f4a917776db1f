"""Logs that were spoilt on their way from the robot to the file."""

from dataclasses import replace

import numpy as np


def late(y, k):
    """k samples late, the first one repeated."""
    return np.concatenate([np.full(k, y[0]), y[:-k]])


def spikes(y, size, count=3):
    y = y.copy()
    y[np.linspace(100, len(y) - 100, count).astype(int)] += size
    return y


def wrapped(y, numbers, least=None):
    """A number that has so many values, and begins anew behind the largest one."""
    least = -numbers / 2 if least is None else least
    return (y - least) % numbers + least


def clipped(y, share=0.6):
    top = share * abs(y).max()
    return np.clip(y, -top, top)


def cut(log, start):
    """Without its first samples: it doesn't begin at rest."""
    return log.part(slice(start, None))


def rewritten(log, **columns):
    here = {k: f for k, f in columns.items() if getattr(log, k) is not None}
    return replace(log, **{k: f(getattr(log, k)) for k, f in here.items()})


def both(log, f):
    return rewritten(log, encoder1=f, encoder2=f)


def of_body(**columns):
    """What rewrites the body's log alone; below of the wheels', and of both logs."""
    return lambda b, w: (rewritten(b, **columns), w)


def of_wheels(f):
    return lambda b, w: (b, both(w, f))


def of_all(**columns):
    return lambda b, w: (rewritten(b, **columns), rewritten(w, **columns))


def over(number):
    return lambda y: y / number


#: From a name to what it makes of (body, wheels), and what the refusal must name.
SPOILT = {
    "gyro in deg/s": (of_body(gyro=np.rad2deg), "deg/s|times e/f"),
    "t in ms": (of_all(t=over(1e-3)), "not in ms"),
    "V a duty in the body's log": (of_body(V=over(12)), "duty|times e/f"),
    "V a duty in both": (of_all(V=over(40)), "duty"),
    "V a duty of 7.4 V in both": (of_all(V=over(7.4)), "duty in both"),
    "V in mV": (of_all(V=over(1e-3)), "mV"),
    "encoders in rad": (of_wheels(over(2000 / 2 / np.pi)), "counts"),
    "encoders in degrees": (of_wheels(over(2122.2 / 360)), "counts"),
    "angle for rate": (
        lambda b, w: (replace(b, gyro=np.cumsum(b.gyro - b.gyro.mean()) * b.T), w),
        "e/f|model|ran away|positive",
    ),
    "an encoder's column for the gyro's": (
        lambda b, w: (replace(b, gyro=w.encoder1[: len(b.t)]), w),
        "encoder's|faster",
    ),
    "the gyro's column for an encoder's": (
        lambda b, w: (b, replace(w, encoder1=b.gyro[: len(w.t)], encoder2=None)),
        "fractions",
    ),
    "gyro clipped": (of_body(gyro=clipped), "clipped"),
    "three spikes": (of_body(gyro=lambda g: spikes(g, 30.0)), "spike"),
    "an encoder's glitches": (
        lambda b, w: (b, rewritten(w, encoder1=lambda n: spikes(n, 500.0))),
        "spike",
    ),
    "a gyro that goes over its end": (
        of_body(gyro=lambda g: wrapped(g, 1.2 * abs(g).max())),
        "goes on at the other end",
    ),
    "a counter that goes over its end too fast": (
        of_wheels(lambda n: wrapped(16 * n, 2**8)),
        "counter of 8 bits, .* by too much between two samples",
    ),
    "gyro two samples late": (of_body(gyro=lambda g: late(g, 2)), "late"),
    "gyro one sample late": (of_body(gyro=lambda g: late(g, 1)), "late"),
    "encoders two samples late": (
        of_wheels(lambda n: late(n, 2)),
        "encoder1 seems to be 2 sample.s. late",
    ),
    "one encoder lost a channel": (
        lambda b, w: (b, rewritten(w, encoder2=lambda n: np.floor(n / 2))),
        "encoder1 moves .* times as much as encoder2",
    ),
    "the gyro's column for V's": (
        lambda b, w: (replace(b, V=b.gyro, gyro=b.V), w),
        "another's place|motors|positive|model",
    ),
    "gyro reversed": (of_body(gyro=np.negative), "must be positive"),
    "V zero": (of_body(V=np.zeros_like), "V reaches 0"),
    "a dead encoder": (of_wheels(np.zeros_like), "says the same all the time"),
    "not at rest": (lambda b, w: (cut(b, 33), w), "rest"),
}
