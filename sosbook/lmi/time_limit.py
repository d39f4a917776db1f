"""A limit of the time that a solver may take, seen at each Newton step."""

from contextlib import contextmanager
from contextvars import ContextVar
from time import monotonic

__all__ = ["OutOfTime", "check_time", "time_limit"]

_end = ContextVar("end", default=None)


class OutOfTime(Exception):
    """Raised by the solver where the time is over."""


@contextmanager
def time_limit(seconds):
    """Let the solver raise `OutOfTime` after so many seconds.

    Parameters
    ----------
    seconds : float or None
        None sets no limit. An outer limit that ends sooner stays in force.

    Examples
    --------
    >>> with time_limit(60):
    ...     check_time()
    """
    outer, end = _end.get(), None if seconds is None else monotonic() + seconds
    token = _end.set(min((t for t in (outer, end) if t is not None), default=None))
    try:
        yield
    finally:
        _end.reset(token)


def check_time():
    """Raise `OutOfTime` where the limit in force is over."""
    end = _end.get()
    if end is not None and monotonic() > end:
        raise OutOfTime("the time limit is over")
