"""Tie the numbers of a page, and report those that hang loose."""

import re
import tomllib
from dataclasses import dataclass
from functools import cache

from . import numerals, pages

GIVEN = pages.ROOT / "tests" / "given"
NEAR = 2  # digits; a number of so few must be witnessed in its own section,
CELLS = 1  # or within so many cells


@dataclass(frozen=True)
class Loose:
    """A number that nothing ties, with the nearest numbers of its page."""

    passage: pages.Passage
    number: numerals.Number
    nearest: tuple

    def __str__(self):
        where = f"{self.passage.page}, cell {self.passage.cell}"
        kind = self.passage.kind
        what = f" ({kind})" if kind in {"alt", "caption", "formal"} else ""
        near = (
            ", ".join(f"{w.number.written} (cell {w.cell})" for w in self.nearest)
            or "none"
        )
        return (
            f"{where}, line {self.passage.line_of(self.number.start)}{what}: "
            f"{self.passage.around(self.number)}\n    nearest outputs: {near}"
        )


def witness(page, passage, number):
    """What ties a number, or None: many digits from afar, few from nearby."""
    for found in page.witnesses:
        if number.agrees(found.number) and _near(passage, found, number):
            return found
    return None


def _near(passage, found, number):
    if found.kind == "thesis":
        return not number.percent and (
            number.digits > 1 or not number.whole or number.value > 12
        )
    if number.digits == 2 and found.number.written.lstrip("-") == number.written:
        return True
    return (
        number.digits > NEAR
        or not passage.section
        or found.section == passage.section
        or abs(found.cell - passage.cell) <= CELLS
    )


def nearest(page, section, number, count=3):
    """The outputs of the page that come closest to a number."""

    def distance(found):
        return min(
            abs(value - mine) for value in found.number.scaled for mine in number.scaled
        )

    outputs = [w for w in page.witnesses if w.kind == "output"]
    best = {}
    for found in sorted(outputs, key=distance):
        best.setdefault(found.number.written, found)
    return tuple(best.values())[:count]


@cache
def read(path):
    """`pages.read`, once a run."""
    return pages.read(path)


@cache
def given(name):
    """The given data of a page: {phrase: where it comes from}."""
    path = GIVEN / f"{name}.toml"
    if not path.exists():
        return {}
    return tomllib.loads(path.read_text(encoding="utf-8"))


def phrase_of(entries, passage, number):
    """The phrase of the list of given data that a number stands in."""
    start, end = number.start, number.start + len(number.written)
    for phrase in entries:
        pattern = r"\s+".join(map(re.escape, phrase.split()))
        for match in re.finditer(rf"(?<![\d.]){pattern}(?!\d|\.\d)", passage.source):
            if match.start() <= start and end <= match.end():
                return phrase
    return None


def loose(path, entries=None):
    """The numbers of a page without a tie, and the entries that tie nothing."""
    page = read(path)
    entries = given(page.name) if entries is None else entries
    used, found = set(), []
    for passage in page.passages:
        for number in passage.numbers():
            phrase = phrase_of(entries, passage, number)
            if phrase is not None:
                used.add(phrase)
                fault = unsupported(entries[phrase], number)
                if not fault:
                    continue
            elif witness(page, passage, number):
                continue
            found.append(Loose(passage, number, nearest(page, passage.section, number)))
    return found, sorted(set(entries) - used)


def unsupported(reason, number):
    """What is wrong with a reason (see PAGE, in FILE, cite KEY, words), or None."""
    word, _, rest = reason.partition(" ")
    target = rest.split(":")[0].split(",")[0].strip()
    if word == "see":
        path = next((p for p in pages.all_pages() if p.stem == target), None)
        if path is None:
            return f"there is no page {target}"
        if not any(
            w.kind != "thesis" and number.agrees(w.number) for w in read(path).witnesses
        ):
            return f"{target} doesn't print {number.written}"
    elif word == "in":
        path = pages.ROOT / target
        if not path.is_file():
            return f"there is no file {target}"
        source = path.read_text(encoding="utf-8")
        if not any(number.agrees(n) for n in numerals.literals(source)):
            return f"{target} doesn't set {number.written}"
    elif word == "cite":
        source = (pages.BOOK / "references.bib").read_text(encoding="utf-8")
        if f"{{{target}," not in source:
            return f"the bibliography has no {target}"
    elif len(reason.split()) < 3:
        return "say where it comes from"
    return None
