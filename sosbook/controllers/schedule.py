"""The mean of what the corners' gains say, in C: the operations of `Schedule`."""

from .numbers import FLOAT_TYPES, checked_words, literal
from .template import written_by

TEXT = """\
/* axis_schedule.h: one gain from those at the corners of what is measured.
 *
 * @WRITTEN@
 *
 * The outputs of axis_step are those of each corner of @NAMES@,
 * one corner after the other; the last of what is measured changes first. The input
 * of the machine is their mean by weights: axis_mixed(p, u, mixed).
 */
#ifndef AXIS_SCHEDULE_H
#define AXIS_SCHEDULE_H

#define AXIS_FOLLOWS @MANY@ /* @NAMES@ */
#define AXIS_CORNERS @CORNERS@
#define AXIS_INPUTS @INPUTS@

/* 0: p is out of the ranges of the proof, and the nearest values were taken. */
static inline int axis_mixed(const @REAL@ p[], const @REAL@ u[], @REAL@ mixed[])
{
    static const @REAL@ low[AXIS_FOLLOWS] = {@LOW@};
    static const @REAL@ high[AXIS_FOLLOWS] = {@HIGH@};
    @REAL@ weights[AXIS_CORNERS];
    int inside = 1, i, j, k, many = 1;
    weights[0] = 1;
    for (k = 0; k < AXIS_FOLLOWS; k++) {
        const int above = p[k] > high[k], good = p[k] >= low[k] && !above;
        const @REAL@ x = good ? p[k] : above ? high[k] : low[k];
        const @REAL@ up = (x - low[k]) / (high[k] - low[k]);
        for (i = many - 1; i >= 0; i--) {
            const @REAL@ w = weights[i];
            weights[2 * i] = w * (1 - up);
            weights[2 * i + 1] = w * up;
        }
        inside = inside && good;
        many *= 2;
    }
    for (j = 0; j < AXIS_INPUTS; j++) {
        mixed[j] = 0;
        for (i = 0; i < AXIS_CORNERS; i++)
            mixed[j] = mixed[j] + weights[i] * u[i * AXIS_INPUTS + j];
    }
    return inside;
}

#endif
"""


def schedule_text(schedule, outputs, name="axis", precision="double"):
    """The text of <name>_schedule.h, of a ``precision``, for a ``schedule``, a
    `Schedule`, and so many ``outputs`` of all corners.
    """
    checked_words(name, precision)
    corners, ends = len(schedule.corners), zip(*schedule.ends)
    low, high = (", ".join(literal(x, precision) for x in some) for some in ends)
    real = "float" if FLOAT_TYPES[precision] is not float else "double"
    text = TEXT
    for mark, value in (
        ("@NAMES@", ", ".join(schedule.names)), ("@MANY@", len(schedule.names)),
        ("@CORNERS@", corners), ("@INPUTS@", outputs // corners), ("@REAL@", real),
        ("@LOW@", low), ("@HIGH@", high), ("@WRITTEN@", written_by()),
    ):  # fmt: skip
        text = text.replace(mark, str(value))
    return text.replace("AXIS", name.upper()).replace("axis", name)
