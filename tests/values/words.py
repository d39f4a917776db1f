"""Text compared as words, letter by letter, and numbers, to one unit of the last digit.

Of two numbers the finer counts (formats drop zeros: 1.0 and 0.99999 agree). A whole
number below 10000 agrees only with itself. The sign of a zero is ignored. Digits in a
word, a version, a date, a colour, a reference (2.15) are letters. Lines are compared
one by one, spaces are not; a row of an array, from [ to ], is one line.
"""

import re
from decimal import Decimal
from functools import lru_cache
from os.path import commonprefix

REFERENCE = (
    r"(?:Tables?|Figs?\.?|Figures?|Sections?|Theorems?|Lemmas?|Eqs?\.?|"
    r"Chapters?|Corollary|Remark|Example)[ ]\d+(?:\.\d+)*"
)
TOKEN = re.compile(
    rf"""
    (?P<word> {REFERENCE}
            | \([1-9]\.\d{{1,2}}\)
            | 0x[0-9a-fA-F.]+(?:p[+-]?\d+)?
            | \#[0-9a-fA-F]{{3,8}}(?!\w)
            | \d{{4}}-\d\d-\d\d
            | (?<!\w)[0-9a-f]{{16,}}(?!\w)
            | \d+(?:\.\d+){{2,}}
            | [^\W\d]\w* )
  | (?P<number> (?:[-+−][ ]?)?
                (?:\d+\.?\d*|(?<!\w)\.\d+)
                (?:[eE][-+]?\d+)? )
  | (?P<mark> \S )
""",
    re.X,
)
ROW = re.compile(r"\[[^\[\]]*\]")
WHOLE = 10000
SHOWN = 100


def differences(stored, now, limit=5):
    """What two texts don't agree in: at most `limit` sentences."""
    if stored == now:
        return []
    before, after = _lines(stored), _lines(now)
    faults = []
    for line, pair in enumerate(zip(before, after), 1):
        faults += (f"line {line}{fault}" for fault in _line(*pair))
    if len(before) != len(after):
        faults.append(f"stored {len(before)} lines, now {len(after)}")
    return first(faults, limit)


def first(faults, limit):
    """So many of some faults, and how many more there are."""
    rest = [f"... and {len(faults) - limit} more"] if len(faults) > limit else []
    return faults[:limit] + rest


def _lines(text):
    text = ROW.sub(lambda row: row[0].replace("\n", " "), text)
    return [line for line in text.splitlines() if line.strip()]


def _line(stored, now):
    if stored == now:
        return
    before, after = tokens(stored), tokens(now)
    if [kind for kind, _ in before] != [kind for kind, _ in after]:
        start = max(0, len(commonprefix([stored, now])) - SHOWN // 3)
        yield (
            f": stored {stored[start:][:SHOWN].strip()!r}, "
            f"now {now[start:][:SHOWN].strip()!r}"
        )
        return
    numbers = 0
    for (kind, old), (_, new) in zip(before, after):
        numbers += kind == "number"
        if kind == "number" and not agree(old, new):
            yield (
                f", number {numbers}: stored {old}, now {new} "
                f"(tolerance {_tolerance(old, new):g})"
            )
        elif kind != "number" and old != new:
            yield f": {kind} {old!r} became {new!r}"


def tokens(text):
    """The words, numbers and other marks of a text, with their kinds."""
    return [(token.lastgroup, token[0]) for token in TOKEN.finditer(text)]


def agree(stored, now):
    """Whether two printed numbers may be roundings of the same value."""
    if stored == now:
        return True
    a, b = _value(stored), _value(now)
    if ("+" == stored[0]) != ("+" == now[0]) and min(a, b) > 0:
        return False
    return abs(a - b) <= _tolerance(stored, now)


def _tolerance(stored, now):
    """One unit of the last digit; none if both are small whole numbers."""
    smaller = min(abs(_value(stored)), abs(_value(now)))
    if _is_whole(stored) and _is_whole(now) and smaller < WHOLE:
        return 0
    return min(_unit(stored), _unit(now))


@lru_cache(maxsize=65536)
def _value(number):
    return Decimal(number.replace("−", "-").replace(" ", ""))


def _unit(number):
    mantissa, _, power = number.lower().partition("e")
    return Decimal(10) ** (int(power or 0) - len(mantissa.partition(".")[2]))


def _is_whole(number):
    return "e" not in number.lower() and not number.partition(".")[2]
