"""A firmware's numbers and sums, as C and Python spell them."""

import re

import numpy as np

from .firmware import PUSHING_SHARE, SOFTNESS, TRUSTED_VOLTS

__all__ = [
    "FLOAT_TYPES",
    "braces",
    "c_constants",
    "compensated",
    "constants",
    "counts",
    "following",
    "literal",
    "matrices",
    "nested",
    "output",
    "plain",
    "python_constants",
    "size",
    "total",
]

FLOAT_TYPES = {"double": float, "single": np.float32}


def constants(firmware):
    """Name, value and unit of the numbers of a firmware outside its law."""
    T, fastest, rub = firmware.law.T, firmware.fastest, firmware.compensation
    friction = [
        ("RUB", rub, "V, of friction that is compensated"),
        ("SOFT", SOFTNESS * rub, "V, from which on all of it is"),
        ("STEEP", 1 / SOFTNESS, "V per V below"),
    ]
    return friction * bool(rub) + [
        ("HALF_TICK", T / 2, "s"),
        ("HERTZ", 1 / T, "Hz"),
        ("LIMIT", firmware.limit, "V"),
        ("TIP", firmware.tip, "rad"),
        ("BLEND", firmware.blend, "of each tick's tilt"),
        ("RANGE", firmware.gyro_range, "rad/s"),
        ("PUSH", firmware.limit * PUSHING_SHARE, "V"),
        ("REACH", fastest * T, "rad a tick"),
        ("TRUSTED", TRUSTED_VOLTS, "V"),
    ]


def c_constants(rows, real, number):
    """Lines of C for ``rows`` of a name, a value and a unit.

    The type of a number is ``real``, and ``number`` spells it.
    """
    return [
        f"static const {real} {label} = {number(value)};  /* {value:.9g} {unit} */"
        for label, value, unit in rows
    ]


def python_constants(rows):
    """Lines of Python for ``rows`` of a name, a value and a unit."""
    return [f"{label} = {float(value)!r}  # {unit}" for label, value, unit in rows]


def counts(firmware):
    """Name and value of a firmware's numbers of ticks."""
    return [
        ("MISSING", firmware.missing),
        ("FROZEN", firmware.frozen),
        ("DEAF", firmware.deaf),
        ("STALL", firmware.stall),
    ]


def matrices(law):
    """Name and value of those matrices of a law that aren't zero."""
    both = [
        ("A", law.A),
        ("B", law.B),
        ("W", law.W[:, 0]),
        ("C", law.C[0]),
        ("D", law.D[0]),
    ]
    used = [
        (label, value + 0.0)  # no -0
        for label, value in both
        if value.any()
    ]
    return used + [("START", law.start)] * bool(law.order)


def compensated(firmware, choice):
    """What a ``firmware`` adds to the law's u against friction; empty without.

    The ``choice`` of C or Python takes a condition and two values.
    """
    if not firmware.compensation:
        return ""
    return choice("u > SOFT", "RUB", choice("u < -SOFT", "-RUB", "STEEP * u"))


def output(law):
    """u of a law, in the words of C and of Python."""
    return total([("C", law.C[0], "x[{}]"), ("D", law.D[0], "y[{}]")])


def following(law):
    """The rows of x(k + 1) of a law, in the words of C and of Python.

    A row of zeros is 0.
    """
    return [
        total(
            [
                (f"A[{i}]", law.A[i], "x[{}]"),
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


def braces(value, number):
    """An array ``value`` of C, spelled by ``number``, with the decimals beside it."""
    if value.ndim == 1:
        rows = [f"    {number(x)},  /* {x:.9g} */\n" for x in value]
    else:
        rows = [
            f"    {{{', '.join(map(number, row))}}},\n"
            f"    /* {', '.join(f'{x:.9g}' for x in row)} */\n"
            for row in value
        ]
    return "{\n" + "".join(rows) + "}"


def nested(value):
    """An array ``value`` as lists of Python."""
    if value.ndim == 1:
        return repr(value.tolist())
    rows = "".join(f"    {row},\n" for row in value.tolist())
    return f"[\n{rows}]"


def size(value):
    """The brackets of an array's declaration in C, for an array ``value``."""
    return "".join(f"[{n}]" for n in value.shape)


def plain(text):
    """A text in printable ASCII, without what begins or ends a comment of C."""
    text = text.encode("ascii", "backslashreplace").decode()
    text = "".join(c if c.isprintable() else " " for c in text)
    for pair in ("*/", "/*", "??"):
        while pair in text:
            text = text.replace(pair, " ".join(pair))
    return text
