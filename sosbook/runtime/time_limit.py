"""A limit of the time that a solver may take, and a bar of it, at each Newton step."""

from contextlib import contextmanager
from contextvars import ContextVar
from math import ceil, inf
from time import monotonic

import numpy as np

from .progress import bar

LONGEST = 1e9  # seconds, about thirty years
LEAST_TIME = 1e-3  # seconds, where hardly any are left: a limit is positive
SECONDS_OF_EIGENVALUES = 1e-9  # by the cube of the rows; about, on one core

_end = ContextVar("end", default=None)
_tick = ContextVar("tick", default=None)  # moves the bar in force


class OutOfTime(Exception):
    """Raised, with a message, where time is over; ``end`` is when, by `monotonic`,
    ``ahead`` the seconds of a step that wasn't begun, ``share`` which part of the work
    is done, in words.
    """

    def __init__(self, message="the time limit is over", end=inf, ahead=0.0):
        super().__init__(message)
        self.end, self.ahead, self.share = end, ahead, ""

    def words(self, seconds):
        """The words for a stop of a request that was given so many seconds."""
        if monotonic() < self.end < inf:
            longer = f"takes about {self.ahead:.4g} s" if self.ahead else "takes longer"
            text = f"Stopped before {seconds:g} s were over: the next step {longer}"
        else:
            text = f"Stopped after {seconds:g} s"
        return f"{text}: raise time_limit, or ask for less."


@contextmanager
def under_way(words):
    """Let an `OutOfTime` say which part of the work is done, in ``words``.

    >>> with under_way("3 of 7 plants were tried"):
    ...     pass
    """
    try:
        yield
    except OutOfTime as over:
        over.share = over.share or words
        raise


@contextmanager
def time_limit(seconds, progress=False):
    """Let the solver raise `OutOfTime` after so many ``seconds``; None sets no limit.
    An outer limit that ends sooner stays in force; ``progress``: show a bar of the
    seconds.

    >>> with time_limit(60):
    ...     check_time()
    """
    seconds = checked_seconds(seconds)
    outer, end = _end.get(), None if seconds is None else monotonic() + seconds
    total = None if seconds is None else ceil(seconds)
    with bar(total, "s", progress) as passed:
        token = _end.set(min((t for t in (outer, end) if t is not None), default=None))
        shown = _tick.set(_clock(passed)) if progress else None
        try:
            yield
        finally:
            _end.reset(token)
            if shown is not None:
                _tick.reset(shown)


def checked_seconds(time_limit, needed=False):
    """A ``time_limit`` as a float or a ValueError; None if no limit is ``needed``."""
    if time_limit is None and not needed:
        return None
    if isinstance(time_limit, np.ndarray) and time_limit.ndim == 0:
        time_limit = time_limit[()]
    if isinstance(time_limit, np.floating):
        time_limit = float(time_limit)
    real = isinstance(time_limit, (int, float, np.integer))
    if not real or isinstance(time_limit, bool) or not 0 < time_limit <= LONGEST:
        raise ValueError(
            "time_limit must be positive, a number of seconds"
            + (", or None for no limit" * (not needed))
            + f", got {time_limit!r:.80}"
        )
    return float(time_limit)


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


def check_time(ahead=0.0):
    """Raise `OutOfTime` where the limit is over, or will be ``ahead`` of a step of so
    many seconds that nothing can stop; move the bar.
    """
    tick = _tick.get()
    if tick is not None:
        tick()
    end = _end.get()
    left = inf if end is None else end - monotonic()
    if left < ahead:
        words = "the time limit is over"
        if left > 0:
            words = f"the next step takes about {ahead:.4g} s, of {left:.4g} s left"
        raise OutOfTime(f"{words}: raise time_limit", end, ahead)


def time_left():
    """Seconds until the limit in force is over; infinite without one."""
    end = _end.get()
    return inf if end is None else end - monotonic()


def check_time_of_eigenvalues(rows, times=1.0):
    """`check_time` before eigenvalues of so many ``rows``, some ``times`` over."""
    check_time(times * SECONDS_OF_EIGENVALUES * float(rows) ** 3)
