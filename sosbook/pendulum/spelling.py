"""A firmware's numbers and sums, as C and Python spell them."""

import numpy as np

from .firmware import PUSHING_SHARE, SOFTNESS, TRUSTED_VOLTS

__all__ = ["TICKS", "constants", "following", "matrices", "output", "ticks"]

#: The fields of `Firmware` that count ticks.
TICKS = "missing", "frozen", "deaf", "stall"


def constants(firmware):
    """The numbers of a firmware outside its law, by their names in its programs."""
    T, rub = firmware.law.T, firmware.compensation
    return {
        "HALF_TICK": T / 2,
        "HERTZ": 1 / T,
        "LIMIT": firmware.limit,
        "TIP": firmware.tip,
        "BLEND": firmware.blend,
        "RANGE": firmware.gyro_range,
        "PUSH": firmware.limit * PUSHING_SHARE,
        "REACH": firmware.fastest * T,
        "TRUSTED": TRUSTED_VOLTS,
        "RUB": rub,
        "SOFT": SOFTNESS * rub,
        "STEEP": 1 / SOFTNESS,
    }


def ticks(firmware):
    """A firmware's numbers of ticks, by their names in its programs."""
    return {x.upper(): getattr(firmware, x) for x in TICKS}


def matrices(law):
    """The matrices of a law, by their names in its programs."""
    return {
        label: value + 0.0  # no -0
        for label, value in (
            ("A", law.A),
            ("B", law.B),
            ("W", law.W[:, 0]),
            ("C", law.C[0]),
            ("D", law.D[0]),
            ("START", law.start),
        )
    }


def output(law):
    """u of a law as a sum of C."""
    return total([("C", law.C[0], "s->x[{}]"), ("D", law.D[0], "y[{}]")])


def following(law):
    """The rows of x(k + 1) of a law as sums of C; a row of zeros is 0."""
    return [
        total(
            [
                (f"A[{i}]", law.A[i], "s->x[{}]"),
                (f"B[{i}]", law.B[i], "y[{}]"),
                ("W", law.W[:, 0] * (np.arange(law.order) == i), "(V - u)"),
            ]
        )
        for i in range(law.order)
    ]


def total(parts):
    """The sum factor * value + ... of all parts, from the left; no zeros."""
    terms = [
        f"{label}[{i}] * {value.format(i)}"
        for label, factors, value in parts
        for i, factor in enumerate(factors)
        if factor != 0
    ]
    lines = [terms[i : i + 4] for i in range(0, len(terms), 4)]
    return " +\n            ".join(map(" + ".join, lines)) or "0"
