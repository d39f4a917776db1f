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
    return replace(
        log,
        **{
            k: f(getattr(log, k))
            for k, f in columns.items()
            if getattr(log, k) is not None
        },
    )


def both(log, f):
    return rewritten(log, encoder1=f, encoder2=f)


#: From a name to what it makes of (body, wheels), and what the refusal
#: must name.
SPOILT = {
    "gyro in deg/s": (
        lambda b, w: (rewritten(b, gyro=np.rad2deg), w),
        "deg/s|times e/f",
    ),
    "t in ms": (
        lambda b, w: (
            rewritten(b, t=lambda t: 1000 * t),
            rewritten(w, t=lambda t: 1000 * t),
        ),
        "not in ms",
    ),
    "V a duty in the body's log": (
        lambda b, w: (rewritten(b, V=lambda V: V / 12), w),
        "duty|times e/f",
    ),
    "V a duty in both": (
        lambda b, w: (
            rewritten(b, V=lambda V: V / 40),
            rewritten(w, V=lambda V: V / 40),
        ),
        "duty",
    ),
    "V a duty of 7.4 V in both": (
        lambda b, w: (
            rewritten(b, V=lambda V: V / 7.4),
            rewritten(w, V=lambda V: V / 7.4),
        ),
        "duty in both",
    ),
    "V in mV": (
        lambda b, w: (
            rewritten(b, V=lambda V: 1e3 * V),
            rewritten(w, V=lambda V: 1e3 * V),
        ),
        "mV",
    ),
    "encoders in rad": (
        lambda b, w: (b, both(w, lambda n: 2 * np.pi * n / 2000)),
        "counts",
    ),
    "encoders in degrees": (
        lambda b, w: (b, both(w, lambda n: 360 * n / 2122.2)),
        "counts",
    ),
    "angle for rate": (
        lambda b, w: (rewritten(b, gyro=lambda g: np.cumsum(g - g.mean()) * b.T), w),
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
    "gyro clipped": (lambda b, w: (rewritten(b, gyro=clipped), w), "clipped"),
    "three spikes": (
        lambda b, w: (rewritten(b, gyro=lambda g: spikes(g, 30.0)), w),
        "spike",
    ),
    "an encoder's glitches": (
        lambda b, w: (b, rewritten(w, encoder1=lambda n: spikes(n, 500.0))),
        "spike",
    ),
    "a gyro that goes over its end": (
        lambda b, w: (rewritten(b, gyro=lambda g: wrapped(g, 1.2 * abs(g).max())), w),
        "goes on at the other end",
    ),
    "a counter that goes over its end too fast": (
        lambda b, w: (b, both(w, lambda n: wrapped(16 * n, 2**8))),
        "counter of 8 bits, .* by too much between two samples",
    ),
    "gyro two samples late": (
        lambda b, w: (rewritten(b, gyro=lambda g: late(g, 2)), w),
        "late",
    ),
    "gyro one sample late": (
        lambda b, w: (rewritten(b, gyro=lambda g: late(g, 1)), w),
        "late",
    ),
    "encoders two samples late": (
        lambda b, w: (b, both(w, lambda n: late(n, 2))),
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
    "gyro reversed": (
        lambda b, w: (rewritten(b, gyro=np.negative), w),
        "must be positive",
    ),
    "V zero": (lambda b, w: (rewritten(b, V=np.zeros_like), w), "V reaches 0"),
    "a dead encoder": (
        lambda b, w: (b, both(w, np.zeros_like)),
        "says the same all the time",
    ),
    "not at rest": (lambda b, w: (cut(b, 33), w), "rest"),
}
