"""Files of other people, read here or in `matrix_files`: nothing in them is executed,
and what is beyond `MOST_BYTES`, `DEEPEST` or `LONGEST_TEXT`, or is no file of its kind,
is a ValueError that names the file.
"""

import csv
import json
import re
from contextlib import contextmanager
from io import StringIO
from math import isinf
from os import PathLike
from pathlib import Path

import numpy as np

MOST_BYTES = 200_000_000  # of a file, and of what an archive unpacks
MOST_DIGITS = 100_000  # of a whole number that is written in a text
LONGEST_TEXT = 2 * MOST_DIGITS + 2  # of one text in JSON: a fraction with its sign
MOST_ITEMS = 10_000_000  # of lists and objects in one file: each takes 60 bytes
LONGEST_INTEGER = 400  # digits of one in JSON; a float has at most 309
DEEPEST = 200  # lists in lists
FORTRAN = re.compile(r"(?<=[0-9.])[dD](?=[+-]?[0-9]+$)")  # an exponent's letter


@contextmanager
def named(path):
    """Let each ValueError inside begin with the name of the file at ``path``."""
    try:
        yield
    except ValueError as error:
        before = "" if str(error).startswith(str(path)) else f"{path}: "
        raise ValueError(f"{before}{error}") from None


def path_of(path):
    """A ``path``, a str or Path, as a Path; or a ValueError."""
    if not isinstance(path, (str, PathLike)) or "\0" in str(path):
        raise ValueError(f"the name of a file or folder is needed, got {path!r:.80}")
    return Path(path)


def read_bytes(path):
    """All bytes of the file at ``path``; an OSError names the file; ValueError if it
    has more than `MOST_BYTES` bytes, or ``path`` is no path.
    """
    path = path_of(path)
    if path.is_dir():
        raise IsADirectoryError(f"{path} is a folder: give the name of a file in it")
    with path.open("rb") as file:
        content = file.read(MOST_BYTES + 1)
    if len(content) > MOST_BYTES:
        raise ValueError(f"{path} has more than {MOST_BYTES} bytes: too large to read")
    return content


def read_text(path, bom=False):
    """The text of `read_bytes` (a ``path``), less a byte order mark (``bom``)."""
    content = read_bytes(path)
    try:
        return content.decode("utf-8-sig" if bom else "utf-8")
    except UnicodeDecodeError as error:
        raise ValueError(
            f"{path} is no text in UTF-8: byte {error.start + 1} is "
            f"0x{content[error.start]:02x}; save it in UTF-8"
        ) from None


def read_json(path):
    """The content of the JSON file at ``path``; see `parse_json` and `read_bytes`."""
    try:
        return parse_json(read_text(path))
    except ValueError as error:
        text = str(error)
        if text.startswith(str(path)):
            raise
        raise ValueError(f"{path} is no JSON file: {text}") from None


def parse_json(text):
    """The content of a ``text`` in JSON; a ValueError also for a key that comes twice,
    for NaN and Infinity, for numbers that no float is near, and beyond the limits of
    this module.

    >>> parse_json('{"M": [[1]], "M": [[2]]}')
    Traceback (most recent call last):
        ...
    ValueError: the key 'M' comes twice
    """
    _check_items(text)
    try:
        hooks = dict(object_pairs_hook=_unique, parse_constant=_refused)
        content = json.loads(text, **hooks, parse_int=_integer, parse_float=number)
    except RecursionError:
        raise ValueError("its lists are nested too deeply") from None
    _check_limits(content)
    return content


def _check_items(text):
    """A ValueError for so many lists and numbers that they fill the memory."""
    if sum(map(text.count, ",[{")) > MOST_ITEMS:
        raise ValueError(f"it has more than {MOST_ITEMS} items: too large to read")


def _unique(pairs):
    content = dict(pairs)
    if len(content) < len(pairs):
        names = [key for key, _ in pairs]
        twice = next(key for key in names if names.count(key) > 1)
        raise ValueError(f"the key {twice!r:.80} comes twice")
    return content


def _refused(word):
    raise ValueError(f"{word} is no number of JSON")


def _integer(word):
    if len(word) > LONGEST_INTEGER:
        raise ValueError(f"a whole number has {len(word)} digits, too many to read")
    return int(word)


def _check_limits(content):
    """A ValueError for what is nested too deeply, or a text that is too long."""
    level = [content]
    for _ in range(DEEPEST):
        inside = []
        for value in level:
            if isinstance(value, dict):
                inside += value.values()
            elif isinstance(value, list):
                inside += value
            elif isinstance(value, str) and len(value) > LONGEST_TEXT:
                raise ValueError(
                    f"{value[:20]!r}... has {len(value)} characters, more than "
                    f"{LONGEST_TEXT}"
                )
        level = inside
        if not level:
            return
    raise ValueError("its lists are nested too deeply")


def number(word):
    """The float nearest to the decimal that a ``word`` spells, with Fortran's exponent,
    too, such as 1.5D+00; also nan and inf. A ValueError if it is no number in ASCII, or
    so large or so small that no float is near.

    >>> number("1_0")
    Traceback (most recent call last):
        ...
    ValueError: '1_0' is no number; write 0.5 with a point
    """
    word = FORTRAN.sub("e", word) if "D" in word or "d" in word else word
    try:
        if not word.isascii() or "_" in word:
            raise ValueError
        value = float(word)
    except ValueError:
        raise ValueError(f"{word!r:.60} is no number; write 0.5 with a point") from None
    if isinf(value) and "n" not in word.lower():
        raise ValueError(f"{word:.60} is too large: choose other units")
    if value == 0 and re.search("[1-9]", re.split("[eE]", word)[0]):
        raise ValueError(f"{word:.60} is too small: write 0, or choose other units")
    return value


def read_data(path):
    """The content of the file at ``path``: TOML by its ending, else JSON."""
    toml = path_of(path).suffix.lower() == ".toml"
    return (read_toml if toml else read_json)(path)


def read_toml(path):
    """The content of the TOML file at ``path``, a dict; see `read_bytes`."""
    import tomllib  # a plant needs no TOML

    text = read_text(path)
    try:
        _check_items(text)
        content = tomllib.loads(text, parse_float=_toml_float)
        _check_limits(content)
    except RecursionError:
        raise ValueError(f"{path} isn't TOML: nested too deeply") from None
    except ValueError as error:
        raise ValueError(f"{path} isn't TOML: {error}") from None
    return content


def _toml_float(word):
    return number(word.replace("_", ""))  # TOML parts digits so


def read_rows(path):
    """The rows of a CSV file at ``path``: lists of words, between commas, semicolons or
    tabs, as its first line has them; see `read_bytes`.
    """
    text, rows = read_text(path, bom=True), []
    first = text.partition("\n")[0]
    between = next((x for x in ",;\t" if x in first), ",")
    try:
        rows.extend(csv.reader(StringIO(text, newline=""), delimiter=between))
    except csv.Error as error:
        raise ValueError(f"{path}: line {len(rows) + 1}: {error}") from None
    return rows


def numbers_of(path, rows, names):
    """The numbers below the first of the ``rows`` of a CSV file at ``path``, (N, k)
    with k ``names``; a ValueError has the line that isn't so.
    """
    table = []
    for line, row in enumerate(rows[1:], 2):
        if len(row) != len(names) or not all(word.strip() for word in row):
            raise ValueError(
                f"{path}: line {line} lacks a value or has one too many: "
                f"{','.join(row)!r:.80}"
            )
        try:
            table.append([number(word) for word in row])
        except ValueError as error:
            raise ValueError(f"{path}: line {line}: {error}") from None
    return np.array(table).reshape(-1, len(names))
