"""How far the range of a parameter may go."""

from dataclasses import dataclass, replace
from typing import Any

from ...bisection import narrowed
from ...exact.rational import exact, round_digits
from ...plants.checks import is_word
from ...plants.uncertain import Uncertain
from ...runtime.read_only import ReadOnly
from ...runtime.time_limit import OutOfTime, check_time, checked_seconds
from ...runtime.time_limit import time_limit as limited
from ...synthesis.pid import analyse_pid, design_pid

TIME_LIMIT = 1800.0  # seconds
MOST = 2.0**10  # times the width that is given, and a part of it


@dataclass(frozen=True, eq=False)
class Farthest(ReadOnly):
    """How far the range of a parameter goes, the others held.

    Parameters
    ----------
    name, end : str
        The parameter, and which end of its range is moved, "low" or "high".
    reached : float or None
        The farthest value that has a design; None where none was found.
    beyond : float or None
        The nearest value that was tried in vain; None where there was none.
    design, refused : Design or None
        For these two ranges. ``refused.status`` says if it is proven that there is
        no design by its LMIs, or, for a known gain, that a plant breaks what is asked.
    reason : str
        Why a side is missing; else empty.
    """

    name: str
    end: str
    reached: float | None = None
    beyond: float | None = None
    design: Any = None
    refused: Any = None
    reason: str = ""


def farthest(
    plants, name, K=None, *, end="high", digits=3, time_limit=TIME_LIMIT, **asked
):
    """Find how far a parameter's range may go with a design, or with a known gain.

    Parameters
    ----------
    plants : Uncertain
        The family; the other end of the range, and the other ranges, are held.
    name : str
        The parameter.
    K : (m, N) array_like, optional
        A gain that is to keep what is asked; one is designed without it.
    end : {"high", "low"}
        Which end is moved.
    digits : int
        The values have so many significant digits.
    time_limit : float
        Seconds after which the search stops with what is known by then.
    **asked
        Keywords of `design_pid`, or of `analyse_pid`.

    Returns
    -------
    Farthest
        Two neighbours of so many digits, where both sides are found.

    Examples
    --------
    >>> import sosbook as sos
    >>> carts = sos.Uncertain(
    ...     lambda m: sos.SecondOrderSystem(m, 0.1, 1, 1), m=(0.5, 1))
    >>> found = farthest(carts, "m", [[-3, -2]], region=sos.PoleRegion(sigma=0.25))
    >>> found.reached, found.beyond, found.refused.status
    (4.19, 4.2, 'infeasible')
    """
    if not isinstance(plants, Uncertain):
        raise ValueError(f"plants must be an Uncertain, got {type(plants).__name__}")
    if name not in plants.box.names:
        raise ValueError(f"{name!r} is no parameter: {', '.join(plants.box.names)} are")
    if not is_word(end, ("high", "low")):
        raise ValueError(f'end must be "high" or "low", got {end!r}')
    seconds, answers = checked_seconds(time_limit, needed=True), {}
    k = plants.box.names.index(name)
    low, high = float(plants.box.low[k]), float(plants.box.high[k])
    held, first = (low, high) if end == "high" else (high, low)

    def holds(value):
        """True if the family up to ``value`` is feasible; keeps the design."""
        check_time()
        design, singular = None, ""
        ends = list(getattr(plants.box, end))
        ends[k] = exact(value)
        try:
            family = plants.within(replace(plants.box, **{end: tuple(ends)}))
            some = (family,) if K is None else (family, K)
            design = (design_pid if K is None else analyse_pid)(*some, **asked)
        except ValueError as error:
            if "singular" not in str(error):
                raise
            singular = str(error)
        answers[value] = design, singular
        return design is not None and design.status == "feasible"

    def at(width):
        return float(round_digits(held + width * (first - held), digits))

    good = bad = None
    reason = ""
    try:
        with limited(seconds):
            width = 1.0
            while None in (good, bad) and 1 / MOST <= width <= MOST:
                value = at(width)
                if holds(value):
                    good, width = value, 2 * width
                else:
                    bad, width = value, width / 2
            if None not in (good, bad):
                good, bad = narrowed(holds, good, bad, _between(digits))
            else:
                reason = f"no other was found within {MOST:g} times the width"
    except OutOfTime:
        reason = f"stopped after {seconds:g} s"
        kept = [v for v, (d, _) in answers.items() if d and d.status == "feasible"]
        lost = [v for v in answers if v not in kept]
        good = max(kept, key=lambda v: abs(v - held), default=None)
        bad = min(lost, key=lambda v: abs(v - held), default=None)
    design, _ = answers.get(good, (None, ""))
    refused, singular = answers.get(bad, (None, ""))
    return Farthest(name, end, good, bad, design, refused, singular or reason)


def _between(digits):
    """From two values to one of so many digits in the middle."""
    return lambda good, bad: float(round_digits((good + bad) / 2, digits))
