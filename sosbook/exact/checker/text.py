"""Reading what a file asks, and a text in the making.

What is asked is a dict of words and decimals. A text is written from it alone, so that
a file may hold the text that is written here and no other.
"""

import re
from fractions import Fraction

from .arithmetic import gather, integer, named, need, read
from .language import Reader, parse

NO_SIZE = None, None  # of rows and columns
DECIMAL = re.compile(r"[-+.e0-9]{1,30}", re.ASCII)
RATIO = re.compile(r"0|-?[1-9]\d*(/[1-9]\d*)?", re.ASCII)


def sane(name):
    """A name: one line, and no sentence."""
    sign = r"(?=[\w(])([\w (),#-]|[.](?! ))+(?<! )"
    good = isinstance(name, str) and re.fullmatch(sign, name)
    need(good, f"{name!r:.40} is no name: one line of letters, digits, spaces, hyphens")
    return name


def decimal_text(text):
    """The text of a number: a decimal in its shortest form, in a string."""
    need(is_decimal(text), f"{text!r:.40} isn't a decimal number in a string")
    return text


def is_decimal(text):
    """True of a decimal in its shortest form, in a string."""
    try:
        shortest = repr(float(text) + 0.0) if DECIMAL.fullmatch(text) else ""
    except (TypeError, ValueError):  # no string, or "1e"
        return False
    return text != "" and text == (
        shortest[:-2] if shortest.endswith(".0") else shortest
    )


def number(text):
    """The value of a decimal."""
    return Fraction(decimal_text(text))


def ratio(text):
    """A fraction in lowest terms, in a string."""
    good = isinstance(text, str) and RATIO.fullmatch(text)
    top, under, bottom = text.partition("/") if good else ("0", "", "")
    bottom = integer(bottom or "1")
    value = Fraction(integer(top), bottom)
    good = good and value.denominator == bottom and (bottom > 1 or not under)
    need(good, f"{text!r:.40} isn't a fraction")
    return value


def positive(text):
    need(number(text) > 0, f"{text} must be positive")
    return number(text)


def mat(rows, r, c=None, entry=number, name="a matrix"):
    """A `Mat` with r rows, and c columns if they are told."""
    return gather(*entries(rows, r, c, entry, name))


def entries(rows, r, c, entry, name):
    """Each entry of a matrix as it is read, and how many columns there are."""
    good = isinstance(rows, list) and len(rows) == r
    good = good and all(isinstance(u, list) for u in rows)
    c = len(rows[0]) if good and rows and c is None else c or 0
    good = good and all(len(u) == c for u in rows)
    need(good, f"{name} has a wrong shape: {r} x {c} is needed")
    with named(name):
        return [[entry(e) for e in u] for u in rows], c


def words_of(rows):
    return "[" + ", ".join("[" + ", ".join(row) + "]" for row in rows) + "]"


class Text:
    """A file in the making: lines, data, sets, unknowns, and where data come from."""

    def __init__(self, asked):
        self.asked, self.lines, self.places = asked, [], {}
        self.data, self.sets, self.unknowns, self.found = {}, {}, {}, {}
        self.labels = {}  # from a block's key to its label

    def put(self, name, holder, key, size=NO_SIZE, entry=decimal_text, into=None):
        """A matrix of what is asked becomes data; its rows and columns, if known."""
        x, into = holder[key], self.data if into is None else into
        plain = isinstance(key, int) or key in name
        said = name if plain else f"{key} ({name})"
        need(isinstance(x, list), f"{said} must be a matrix")
        r, c = (k if n is None else n for k, n in zip((len(x), len([*x, ()][0])), size))
        entries(x, r, c, entry, said)
        self._keep(name, holder, key, into, x if r and c else {"zeros": [r, c]})

    def put_number(self, name, holder, key):
        """A number of what is asked becomes data."""
        with named(key):
            number(holder[key])
        self._keep(name, holder, key, self.data, holder[key])

    def _keep(self, name, holder, key, into, value):
        need(name not in into, f"{name} comes twice")
        into[name] = value
        self.places[id(holder), key] = "=" + name

    def point(self, name, key, shape):
        """An unknown, whose values are under ``key``."""
        self.unknowns[name] = shape
        values = self.asked.get("unknowns")
        if values is None:
            return
        need(key in values, f"unknowns: {key} is missing")
        size = (1, 1) if shape == "number" else NO_SIZE
        self.put(name, values, key, size, into=self.found)
        if shape == "number":
            ((self.found[name],),) = values[key]
            self.places[id(values), key] = "#" + name

    def write(self, *lines, loop=None):
        if loop and lines:
            self.lines.append(f"for {loop}:")
        self.lines += ["  " * bool(loop) + x for x in lines]

    def values(self):
        """The values that the lines so far define, by name."""
        data = {k: read(v) for k, v in self.data.items()}
        reader = Reader(data, sets=self.sets)
        for _ in reader.statements(parse("\n".join(self.lines))):
            pass
        return {k: x.v for k, x in reader.env.items()}

    def file(self):
        """The file for the kernel."""
        whole = dict(text=self.lines, data=self.data)
        whole |= dict(sets=self.sets, unknowns=self.unknowns)
        if "multipliers" not in self.asked:
            given = self.asked.get("unknowns", {})
            need(len(given) == len(self.found), "other unknowns")
            return whole | {"point": self.found}
        Z = {}
        for key, z in self.asked["multipliers"]:
            label = self.label(key)
            need(label not in Z, "two multipliers have one key")
            with named(f"multipliers: {label}"):
                good = [ratio(e) for u in z for e in u]
                need(good, "a multiplier is no matrix")
            Z[label] = z
        return whole | {"multipliers": Z}

    def keys(self):
        """The keys of blocks, by their labels."""
        return {label: key for key, label in self.labels.items()}

    def label(self, key):
        key = key if isinstance(key, str) else tuple(key)
        need(key in self.labels, f"multipliers: {key!r:.40} is no block")
        return self.labels[key]
