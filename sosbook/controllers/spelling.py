"""Numbers as C spells them."""

import re

import numpy as np

FLOAT_TYPES = {"double": float, "single": np.float32}


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
