"""The numbers of a controller's program, for Python, and as C spells them."""

import re

import numpy as np

from .limits import per_signal

NONE = 1e30  # in the place of a limit that there isn't; single precision has it, too
OUT_OF_RANGE = 1e6  # of a reading or set point, in its unit: its wire is broken
BROKEN = 1e9  # of what the law answers: a number in it is broken
FLOAT_TYPES = {"double": float, "single": np.float32}


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
