"""A firmware's numbers and sums, as C and Python spell them."""

import re

import numpy as np

from .firmware import PUSHING_SHARE, SOFTNESS, TRUSTED_VOLTS

__all__ = [
    "FLOAT_TYPES",
    "TICKS",
    "braces",
    "constants",
    "following",
    "literal",
    "matrices",
    "output",
    "single",
    "ticks",
]

#: The fields of `Firmware` that count ticks.
TICKS = "missing", "frozen", "deaf", "stall"
FLOAT_TYPES = {"double": float, "single": np.float32}


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


def literal(value, precision):
    """The exact hexadecimal literal of C for a value in double or single precision."""
    with np.errstate(over="ignore"):
        rounded = float(FLOAT_TYPES[precision](value))
    if not np.isfinite(rounded):
        raise ValueError(
            f"{value:.9g} is too large for {precision} precision: scale "
            "the law's states"
        )
    text = re.sub(r"\.?0*p", "p", rounded.hex())
    return text + ("f" if precision == "single" else "")


def single(value):
    """A ``value`` as a decimal literal of C in single precision."""
    return f"{float(value)!r}f"


def braces(value, precision):
    """An array ``value`` of C in a ``precision``, with the decimals beside it."""
    if value.ndim == 1:
        rows = [f"    {literal(x, precision)},  /* {x:.9g} */\n" for x in value]
    else:
        rows = [
            f"    {{{', '.join(literal(x, precision) for x in row)}}},\n"
            f"    /* {', '.join(f'{x:.9g}' for x in row)} */\n"
            for row in value
        ]
    return "{\n" + "".join(rows) + "}"
