"""Discs on a shaft, moved as the package computed it for each setting."""

from itertools import product

import numpy as np

from ..page import significant
from .mover import Mover, choice, slider

DIGITS = 3  # of the largest value: what is zero but for rounding is stored as 0


def shaft(title, hint, says, controls, move, *, captions, names, seconds, **given):
    """Discs on a shaft that turn as they do where the controls stand.

    Every setting is computed here. The page draws it, its largest angle at one size.

    Parameters
    ----------
    title, hint : str
        The heading, and what to try.
    says : str
        A sentence with each control's name in braces, where its value stands.
    controls : dict
        By name: a label, a unit, the values (words, or positive numbers, evenly spaced
        or evenly in their logarithms) and the value at first.
    move : callable
        Takes a value of each control by its name, and returns a dict: ``state``
        ("feasible", "infeasible" or "undecided"), ``words`` (a verdict and more
        lines), ``turns`` (discs, instants), the angles; and if wanted ``pale``, others
        beside them, ``line``, values over the same time, and ``rules``, levels.
    captions : dict
        Of "scene" and, where there is a line, "curve".
    names : dict
        What stands below a disc, by its place from 0.
    seconds : float
        The time that is shown, in which a motion without a line goes round.
    **given
        ``pace``: seconds a second; ``axis``: the label of the line and both ends of
        its axis; ``sizes``: of the discs, at most 1; ``answer``: as for `task`.

    Raises
    ------
    ValueError
        If the values of a control aren't evenly spaced.

    Examples
    --------
    >>> def turn(k):
    ...     return {"state": "feasible", "words": [f"{k} rad"],
    ...             "turns": [[0, 1, 0], [0, k, 0]]}
    >>> shaft("Two discs", "Turn.", "A disc turns by {k}.",
    ...       {"k": ("Angle", " rad", [1, 2, 3], 1)}, turn,
    ...       captions={"scene": "Discs."}, names={}, seconds=2)
    Shaft: k
    """
    grids = {key: list(values) for key, (_, _, values, _) in controls.items()}
    settings = []
    for place in product(*grids.values()):
        result = move(**dict(zip(grids, place)))
        for key in {"turns", "pale", "line", "rules"} & set(result):
            result[key] = _rounded(result[key])
        settings.append(result)
    discs = len(settings[0]["turns"])
    return Mover(
        "shaft",
        title,
        hint,
        [_control(key, *control) for key, control in controls.items()],
        says=says,
        captions=captions,
        names=list(names.items()),
        seconds=seconds,
        grids=grids,
        settings=settings,
        **{"pace": 1, "axis": None, "sizes": [0.7] + [1] * (discs - 1)} | given,
    )


def _rounded(values):
    """As lists, to `DIGITS` of the largest."""
    largest = significant(abs(np.asarray(values)).max(), DIGITS)
    place = int(np.floor(np.log10(largest))) if largest else 0
    return (np.round(values, DIGITS - 1 - place) + 0.0).tolist()


def _control(key, label, unit, values, start):
    """A list of words, or a slider over numbers."""
    if isinstance(values[0], str):
        return choice(key, label, values, values.index(start))
    even = [np.allclose(x, x[0]) for x in map(np.diff, (values, np.log10(values)))]
    if not any(even):
        raise ValueError(
            f"{key}: the values must be evenly spaced, or in their logarithms; "
            f"got {values}"
        )
    ends = [float(x) for x in (values[0], values[-1])]
    ends = ends if even[0] else [float(x) for x in np.log10(ends)]
    step = (ends[1] - ends[0]) / (len(values) - 1)
    scale = "linear" if even[0] else "log"
    return slider(key, label, unit, ends, step, start, scale)
