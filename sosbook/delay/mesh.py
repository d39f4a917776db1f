"""The steps of a delayed motion: their ends are where it isn't smooth."""

import numpy as np

MOST_STEPS = 1_000_000  # of one simulation


def time_mesh(t, delay, switches, step, tolerance):
    """Ends of the steps under a ``delay``, and which of them are the times t.

    The input jumps at ``switches``, ``step`` is the longest, and times within
    ``tolerance`` are one. u jumps at 0, x' where u arrives, x'' where that comes back,
    and so on: three rounds leave only jumps that the order of the method doesn't see.
    """
    if not np.isreal(step) or not np.isfinite(step) or step <= 0:
        raise ValueError(f"step must be a positive time, got {step!r}")
    end = t[-1]
    if end / step > MOST_STEPS:
        raise ValueError(
            f"t would take {end / step:.0f} steps: end it earlier, or give "
            "a longer step"
        )
    jumps = np.asarray(delay.jumps(end), float)
    edges = np.unique(np.concatenate([[0.0], jumps, [end]]))
    before = edges[1:] - 2 * tolerance
    even = np.linspace(0, end, int(np.ceil(end / step)) + 1)
    samples = np.unique(np.concatenate([edges, before, even]))
    asked = samples - delay(samples)
    # a time that the delay holds is read often: it ends a step
    held = edges[:-1] - delay(edges[:-1])
    same = np.abs(held - (before - delay(before))) <= 10 * tolerance
    fresh = np.array([s for s in (0.0, *switches) if 0 <= s < end])
    times = [jumps, held[same], fresh]
    for again in range(3):
        fresh = _arrivals(fresh, delay, samples, asked, tolerance)
        if not again:
            fresh = np.concatenate([fresh, jumps])
        fresh = _apart(fresh, tolerance)
        times.append(fresh)
    extra = np.concatenate(times)
    extra = _apart(extra[(extra > 0) & (extra < end)], tolerance)
    near = np.searchsorted(t, extra)
    gap = np.minimum(np.abs(t[near] - extra), np.abs(t[near - 1] - extra))
    nodes = np.sort(np.concatenate([t, extra[gap > 4 * tolerance]]))
    parts = np.ceil(np.diff(nodes) / step - 1e-9).astype(int).clip(1)
    first = np.cumsum(parts) - parts
    part = np.arange(parts.sum()) - np.repeat(first, parts)
    fine = np.repeat(nodes[:-1], parts) + part * np.repeat(
        np.diff(nodes) / parts, parts
    )
    user = np.append(first, parts.sum())[np.searchsorted(nodes, t)]
    return np.append(fine, end), user


def _apart(s, tolerance):
    """Sorted, and what lies closer than the tolerance only once."""
    s = np.unique(s)
    return s[np.diff(s, prepend=-np.inf) > 4 * tolerance]


def _arrivals(marks, delay, samples, asked, tolerance):
    """The times t at which t - d(t) passes one of the marks."""
    first = np.searchsorted(samples, marks + delay.low - tolerance) - 1
    last = np.searchsorted(samples, marks + delay.high + tolerance)
    first, last = first.clip(0), last.clip(0, len(samples) - 1)
    which = np.repeat(np.arange(len(marks)), last - first)
    begin = np.cumsum(last - first) - (last - first)
    left = np.arange(len(which)) + (first - begin)[which]
    passed = asked[left] >= marks[which] - tolerance
    upward = asked[left + 1] >= marks[which] - tolerance
    changed = passed != upward
    which, left, upward = which[changed], left[changed], upward[changed]
    marks = marks[which] - tolerance
    low, high = samples[left], samples[left + 1]
    while len(low) and (high - low).max() > tolerance / 4:
        middle = (low + high) / 2
        above = (middle - delay(middle) >= marks) == upward
        low, high = np.where(above, low, middle), np.where(above, middle, high)
    return high


def step_kinds(active, h):
    """One representative of each kind of step; the kind of each step.

    One kind has one length h and the same ``active`` jumps.
    """
    mantissa, exponent = np.frexp(h)
    rounded = np.ldexp(np.round(mantissa * 2.0**36), exponent)
    _, kinds, kind = np.unique(
        np.where(active, rounded, -rounded), return_index=True, return_inverse=True
    )
    return kinds, kind
