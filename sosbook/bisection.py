"""Searches in one number: for an edge of what holds, a least or a largest value."""

from math import copysign, sqrt

import numpy as np

__all__ = ["highest", "lowest", "narrowed"]

GOLDEN = (3 - sqrt(5)) / 2  # of an interval
NOISE = sqrt(2.2e-16)  # relative: nearer points have the same value in floats


def narrowed(holds, good, bad, middle):
    """The two sides of an edge, as close as ``middle`` goes.

    ``holds``: whether a value holds; ``good``, ``bad``: one that holds and one that
    doesn't; neither is tried again; ``middle``: from (good, bad) to a value between
    them; one of the two, or None, ends the search. A number asks for halves, until the
    two are no further apart. Returns the last value that held and the last that didn't.

    >>> narrowed(lambda n: n * n < 50, 0, 100, lambda a, b: (a + b) // 2)
    (7, 8)
    >>> good, bad = narrowed(lambda x: x < 2, 1.0, 5.0, 1e-3)
    >>> bad - good <= 1e-3 and good < 2 <= bad
    True
    """
    if not callable(middle):
        width = middle
        if not width > 0:
            raise ValueError(f"the tolerance must be positive, not {width}")

        def middle(good, bad):
            return (good + bad) / 2 if abs(bad - good) > width else None

    while (between := middle(good, bad)) is not None and between not in (good, bad):
        if holds(between):
            good = between
        else:
            bad = between
    return good, bad


def lowest(function, low, high, within):
    """Where a ``function`` is least between ``low`` and ``high``, and its value there.

    Brent's method: a parabola through the best three points where it helps, else a
    golden section. It finds one of several dips, to ``within`` that distance.

    >>> x, value = lowest(lambda x: (x - 2) ** 2 + 1, 0.0, 5.0, 1e-9)
    >>> round(x, 6), round(value, 9)
    (2.0, 1.0)
    """
    best = second = third = low + GOLDEN * (high - low)
    at_best = at_second = at_third = function(best)
    step = before = 0.0
    for _ in range(500):
        middle, least = (low + high) / 2, NOISE * abs(best) + within / 3
        if abs(best - middle) <= 2 * least - (high - low) / 2:
            break
        curved = False
        if abs(before) > least:
            r = (best - second) * (at_best - at_third)
            q = (best - third) * (at_best - at_second)
            p = (best - third) * q - (best - second) * r
            p, q = (-p if q > r else p), abs(2 * (q - r))
            older, before = before, step
            curved = abs(p) < abs(q * older / 2) and (
                q * (low - best) < p < q * (high - best)
            )
        if curved:
            step = p / q
            if min(best + step - low, high - (best + step)) < 2 * least:
                step = copysign(least, middle - best)
        else:
            before = (low if best >= middle else high) - best
            step = GOLDEN * before
        x = best + copysign(max(abs(step), least), step)
        value = function(x)
        if value <= at_best:
            low, high = (best, high) if x >= best else (low, best)
            third, at_third, second, at_second = second, at_second, best, at_best
            best, at_best = x, value
            continue
        low, high = (x, high) if x < best else (low, x)
        if value <= at_second or second == best:
            third, at_third, second, at_second = second, at_second, x, value
        elif value <= at_third or third in (best, second):
            third, at_third = x, value
    return best, at_best


def highest(function, points):
    """Where a concave ``function`` is largest of some rising or falling ``points``, and
    its value there: a third of them is asked for, some at once, none twice.

    >>> import numpy as np
    >>> x, value = highest(lambda x: -((x - 7.2) ** 2), np.arange(50.0))
    >>> x, round(value, 6)
    (7.0, -0.04)
    """
    low, high, known = 0, len(points), {}
    for step in (16, 4, 1):
        few = range(low, min(high, len(points)), step)
        if new := [k for k in few if k not in known]:
            known |= zip(new, function(points[new]))
        best = few[int(np.argmax([known[k] for k in few]))]
        low, high = max(best - step, 0), best + step + 1
    return float(points[best]), float(known[best])
