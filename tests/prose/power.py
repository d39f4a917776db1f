"""How many changes of typed numbers are noticed?"""

import math
from collections import Counter
from functools import cache

from . import check


def changes(number):
    """Two wrong values: the last digit two up or down, and 30 % more."""
    step = 10 ** round(_exponent(number))
    up = round(number.value / step) % 10 < 8
    yield number.moved(2 * step if up else -2 * step)
    more = max(1, round(0.3 * number.value / number.step)) * number.step
    yield number.moved(more)


def _exponent(number):
    """The place of the last digit that counts."""
    if number.value == 0:
        return math.log10(number.step)
    return math.floor(math.log10(number.value) + 1e-9) - number.digits + 1


@cache
def survey(path):
    """Noticed and tried changes, by significant digits, and what slips by."""
    page = check.read(path)
    entries = check.given(page.name)
    noticed, tried, missed = Counter(), Counter(), []
    for passage in page.passages:
        for number in passage.numbers():
            digits = min(number.digits, 4)
            listed = check.phrase_of(entries, passage, number)
            if not listed and not check.witness(page, passage, number):
                continue  # loose already
            for wrong in changes(number):
                tried[digits] += 1
                slip = None if listed else check.witness(page, passage, wrong)
                if slip is None:
                    noticed[digits] += 1
                else:
                    missed.append((passage, number, wrong, slip))
    return noticed, tried, missed
