"""Matrices of Harwell-Boeing and Rutherford-Boeing files: fields of a fixed width.

scipy's reader knows no symmetric matrix, and structures have no other.
"""

import re

import numpy as np

from .reading import number

FORMAT = re.compile(r"\(([+-]?\d+P,?)?(\d*)([IEDFG])(\d+)(\.\d+(E\d+)?)?\)")
EXPONENT = re.compile(r"(?<=[0-9.])(?=[+-])")  # whose letter had no place: 0.5-101
MIRRORED = {"S": 1.0, "Z": -1.0, "U": 0.0, "R": 0.0}  # of the half that isn't written
FIELDS = "pointers", "rows of entries", "numbers"
MOST_LINES = 20_000_000


def matrix_of_harwell(text, check_size):
    """The data, rows, pointers and shape of the matrix in a file's ``text`` (as a
    csc_array takes them), the factor of its other half, and whether right sides follow;
    ``check_size`` is as in `matrix_files`.
    """
    if text.count("\n") > MOST_LINES:
        raise ValueError(f"it has more than {MOST_LINES} lines")
    lines = text.splitlines()
    if len(lines) < 4:
        raise ValueError("its head has less than four lines")
    _, *counts = _whole(lines[1].split())
    kind, sizes = lines[2][:3].upper(), _whole(lines[2][3:].split())
    formats = [FORMAT.fullmatch(x) for x in _formats(lines[3])]
    if len(counts) < 3 or len(sizes) < 3 or len(formats) < 3 or None in formats[:3]:
        raise ValueError("its head isn't that of Harwell and Boeing")
    if kind[:1] == "P":
        raise ValueError("it has a pattern and no numbers: save it with its numbers")
    if kind[:1] not in ("R", "I") or kind[1:2] not in MIRRORED or kind[2:] != "A":
        raise ValueError(
            f"it is of the kind {kind}, and real assembled ones are read: RSA, RUA, "
            "RZA. Save it as Matrix Market by the program that it is from"
        )
    rows, columns, entries, *_ = sizes
    check_size(rows, columns, full=False)
    check_size(entries)
    right = sum(counts[3:4])
    place, parts = 4 + (right > 0), []
    for what, form, many, size in zip(
        FIELDS, formats, counts, (columns + 1, entries, entries)
    ):
        read = _number if what == "numbers" and kind[0] == "R" else _count
        parts.append(_fields(lines, place, many, form, size, what, read))
        place += many
    pointers, places, data = parts
    found = np.array(data, float), np.array(places) - 1, np.array(pointers) - 1
    return *found, (rows, columns), MIRRORED[kind[1]], bool(right)


def _formats(line):
    return re.findall(r"\([^()]*\)", line.upper().replace(" ", ""))


def _whole(words):
    return [_count(x, None) for x in words]


def _count(word, _):
    if not re.fullmatch(r" *[+-]?\d+ *", word, re.ASCII):
        raise ValueError(f"{word!r:.30} is no whole number")
    return int(word)


def _number(word, form):
    """The number of a ``word``; without a point or, where the format ``form`` shifts
    it, without an exponent Fortran reads another one.
    """
    word = EXPONENT.sub("e", word.strip())
    if "." not in word or (form[1] and not re.search("[dDeE]", word)):
        raise ValueError(f"{word!r:.30} has no point, or no exponent")
    return number(word)


def _fields(lines, place, many, form, size, what, read):
    """So many numbers (``size``) from ``many`` lines, in fields of one width."""
    width, found = int(form[4]), []
    each = int(form[2] or 1)
    for k, line in enumerate(lines[place : place + many], place + 1):
        line = line.rstrip()
        try:
            for at in range(0, min(len(line), each * width), width):
                found.append(read(line[at : at + width], form))
        except ValueError as error:
            raise ValueError(f"line {k}: {error}") from None
    if len(found) != size:
        raise ValueError(f"its head promises {size} {what}, and {len(found)} are there")
    return found
