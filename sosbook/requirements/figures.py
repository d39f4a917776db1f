"""Numbers in a sentence: decimals that lead back to the very float.

They are printed as JavaScript prints numbers, with the sign that print has.
"""

import re

FIGURE = r"[-+−]?(?:\d+(?:\.\d*|,\d+)?|[.,]\d+)(?:e[-+−]?\d+)?"
DIGITS = 6  # of a number that is another one's inverse
WIDEST = 21  # digits before the point


def _digits(text):
    """(sign, digits, place of the point) of a decimal."""
    sign, whole, part, power = re.fullmatch(
        r"([-+]?)(\d*)\.?(\d*)(?:e([-+]?\d+))?", text
    ).groups()
    return sign, whole + part, len(whole) + int(power or 0)


def show(text, power=0):
    """The decimal ``text`` times ten to the ``power``, as JavaScript prints numbers."""
    sign, digits, point = _digits(text)
    n = point + power - len(digits) + len(digits.lstrip("0"))
    digits = digits.strip("0")
    k = len(digits)
    if not digits:
        return "0"
    if k <= n <= WIDEST:
        shown = digits + "0" * (n - k)
    elif 0 < n <= WIDEST:
        shown = f"{digits[:n]}.{digits[n:]}"
    elif -6 < n <= 0:
        shown = f"0.{'0' * -n}{digits}"
    else:
        shown = f"{digits[0]}{'.' * (k > 1)}{digits[1:]}e{n - 1:+d}"
    return ("−" if sign == "-" else "") + shown.replace("-", "−")


def _plain(text):
    text = text.strip().lower().replace("−", "-")
    return text if "." in text else text.replace(",", ".")


def number(text):
    """The number of a ``text`` that a reader wrote, perhaps with a decimal comma."""
    return float(_plain(text))


def value_of(clause, text):
    """The number of the file that a ``text`` in a ``clause`` means."""
    sign, digits, point = _digits(_plain(text))
    x = float(f"{sign}0.{digits}e{point + clause.get('shift', 0)}")
    if "over" not in clause:
        return x
    return clause["over"] / x if x else float("inf")


def shown_of(clause, x):
    """The shortest text that means the number ``x`` in a ``clause``, or None."""
    shift = -clause.get("shift", 0)
    if "over" not in clause:
        return show(repr(float(x)), shift)
    for digits in range(DIGITS if x > 0 else 0):
        text = show(f"{clause['over'] / x:.{digits}e}", shift)
        if value_of(clause, text) == x:
            return text
    return None
