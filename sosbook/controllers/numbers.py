"""The numbers of a controller's program, for Python, and as C spells them."""

import re

import numpy as np

from .limits import per_signal

NONE = 1e30  # in the place of a limit that there isn't; single precision has it, too
OUT_OF_RANGE = 1e6  # of a reading or set point, in its unit: its wire is broken
BROKEN = 1e9  # of what the law answers: a number in it is broken
FLOAT_TYPES = {"double": float, "single": np.float32}

#: Words of C99, headers of its library and of Arduino, what a sketch defines, and
#: devices of Windows: a file's name, or a function's, would collide with them.
# fmt: off
TAKEN = {
    "arduino", "assert", "auto", "aux", "break", "case", "char", "com0", "com1", "com2",
    "com3", "com4", "com5", "com6", "com7", "com8", "com9", "complex", "con", "const",
    "continue", "ctype", "default", "do", "double", "else", "enum", "errno", "extern",
    "fenv", "float", "for", "goto", "if", "inline", "int", "inttypes", "iso646",
    "limits", "locale", "long", "loop", "lpt0", "lpt1", "lpt2", "lpt3", "lpt4", "lpt5",
    "lpt6", "lpt7", "lpt8", "lpt9", "main", "math", "nul", "prn", "register",
    "restrict", "return", "setjmp", "setup", "short", "signal", "signed", "sizeof",
    "static", "stdarg", "stdbool", "stddef", "stdint", "stdio", "stdlib", "string",
    "struct", "switch", "tgmath", "time", "typedef", "union", "unsigned", "void",
    "volatile", "wchar", "wctype", "while",
}
# fmt: on


def checked_words(name, precision):
    """Raise a ValueError where C can't have this ``name`` or ``precision``."""
    good = isinstance(name, str) and re.fullmatch(r"[a-z][a-z0-9_]{0,30}", name)
    if not good or name in TAKEN:
        raise ValueError(
            "name must begin a C identifier, in lower case with at most 31 "
            f"letters, digits and _, and be no word of C, got {name!r}"
        )
    if precision not in FLOAT_TYPES:
        raise ValueError(f"precision must be 'double' or 'single', got {precision!r}")


def program_numbers(c):
    """Arrays and numbers of a `Controller` c by their names in its program: ints for
    counts of ticks, everything else exactly the floats that it is compiled with.
    """
    fastest = per_signal("fastest", c.faults.fastest, c.readings.signals)
    q, p, m = len(c.readings.signals), len(c.set_points), len(c.outputs)
    limits, ticks = c.limits, c.faults.ticks(c.T)
    predicts = c.estimate.predicts
    guess = np.zeros((q, len(c.A)))
    if predicts is not None:
        guess[:, : predicts.shape[1]] = predicts
    moved = dict(SLEW=limits.slew, RAMP=limits.ramp, JUMP=fastest)  # per second
    bounds = {"LIMIT": limits.u_max} | {k: x * c.T for k, x in moved.items()}
    bounds = {k: np.where(np.isfinite(x), x, NONE) + 0.0 for k, x in bounds.items()}
    return {
        **dict(A=c.A, B=c.B, BR=c.B_r, W=c.W, C=c.C, D=c.D, DR=c.D_r),
        **dict(GUESS=guess, START=c.start, TICK=c.T, SLACK=c.faults.slack * c.T),
        **bounds,
        "RANGE": np.full(q, OUT_OF_RANGE),
        "REACH": np.full(p, OUT_OF_RANGE),
        "TRUSTED": np.full(m, BROKEN),
        "PREDICTS": int(predicts is not None),
        "SLEWS": int(np.isfinite(limits.slew).any()),
        "RAMPS": int(np.isfinite(limits.ramp).any()),
        "MOST_LOST": ticks["lost"],
        "MOST_LATE": ticks["late"],
        "MOST_FULL": ticks["stall"],
        "MOST_SILENT": ticks["silence"],
    }


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
