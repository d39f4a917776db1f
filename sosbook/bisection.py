"""Bisection between something that holds and something that doesn't."""

__all__ = ["narrowed"]


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
