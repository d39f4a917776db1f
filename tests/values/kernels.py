"""Kernels that don't answer are started again."""

import functools

__all__ = ["started_again"]

ATTEMPTS = 3


def started_again(start):
    """Start nbval's kernels up to three times, each time with twice the patience.

    A kernel on a busy machine may not answer within nbval's minute; and another
    program may have taken one of its ports between the choice and the start. Then
    all cells of a notebook would fail for a reason that isn't theirs.
    """

    @functools.wraps(start)
    def again(startup_timeout=60, **options):
        for k in range(ATTEMPTS):
            try:
                return start(startup_timeout=startup_timeout * 2**k, **options)
            except RuntimeError:
                if k + 1 == ATTEMPTS:
                    raise

    return again
