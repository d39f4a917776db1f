"""A limit of the time that a solver may take, and a bar of it, at each Newton step."""

from contextlib import contextmanager
from contextvars import ContextVar
from math import ceil
from time import monotonic

from ..runtime.progress import bar

__all__ = ["OutOfTime", "check_time", "time_limit"]

_end = ContextVar("end", default=None)
_tick = ContextVar("tick", default=None)  # moves the bar in force


class OutOfTime(Exception):
    """Raised by the solver where the time is over."""


@contextmanager
def time_limit(seconds, progress=False):
    """Let the solver raise `OutOfTime` after so many seconds.

    Parameters
    ----------
    seconds : float or None
        None sets no limit. An outer limit that ends sooner stays in force.
    progress : bool
        Show a bar of the seconds that have passed.

    Examples
    --------
    >>> with time_limit(60):
    ...     check_time()
    """
    outer, end = _end.get(), None if seconds is None else monotonic() + seconds
    token = _end.set(min((t for t in (outer, end) if t is not None), default=None))
    total = None if seconds is None else ceil(seconds)
    with bar(total, "s", progress) as passed:
        shown = _tick.set(_clock(passed)) if progress else None
        try:
            yield
        finally:
            _end.reset(token)
            if shown is not None:
                _tick.reset(shown)


def _clock(passed):
    """Moves a bar on by the whole seconds since the last call."""
    begun, seen = monotonic(), 0

    def tick():
        nonlocal seen
        now = int(monotonic() - begun)
        if now > seen:
            passed.update(now - seen)
            seen = now

    return tick


def check_time():
    """Raise `OutOfTime` where the limit in force is over; move the bar."""
    tick = _tick.get()
    if tick is not None:
        tick()
    end = _end.get()
    if end is not None and monotonic() > end:
        raise OutOfTime("the time limit is over")
