"""HTML compared as elements, names and addresses to the letter, other text as in
`words`, an svg as in `figures`, data in a script as strings and rounded numbers.
"""

import json
from dataclasses import dataclass
from functools import lru_cache

from sosbook.book.notebooks import without_shared

from . import figures, words
from .trees import parse

RAW = ("script", "style")
NAMES = {"class", "for", "href", "id", "name", "src", "type"}


def differences(stored, now, limit=8):
    """What two HTML fragments don't agree in: a list of str."""
    now = without_shared(now)
    if stored == now:
        return []
    faults = [*_element(_parsed(stored), parse(now), "")]
    return words.first(faults, limit)


_parsed = lru_cache(maxsize=24)(parse)  # of what is compared with several others


def _element(stored, now, place):
    yield from _attributes(stored.attributes, now.attributes, place)
    if stored.tag == "svg":
        for fault in figures.differences(stored, now):
            yield f"{place}: {fault}"
        return
    before, after = _children(stored), _children(now)
    if stored.tag in RAW and before != after:
        yield from _raw(stored, "".join(before), "".join(after), place)
        return
    names = [
        [getattr(child, "tag", "text") for child in side] for side in (before, after)
    ]
    if names[0] != names[1]:
        yield f"{place or 'page'}: stored {_listed(names[0])}, now {_listed(names[1])}"
        return
    counts = {}
    for one, two in zip(before, after):
        name = getattr(one, "tag", "")
        counts[name] = counts.get(name, 0) + 1
        several = f" {counts[name]}" if names[0].count(name) > 1 else ""
        inner = " > ".join(filter(None, (place, name + several)))
        if name:
            yield from _element(one, two, inner)
        else:
            for fault in words.differences(one, two):
                yield f"{place or 'page'}: {fault}"


def _children(node):
    """Its children, without the space between them and in texts."""
    if node.tag in RAW + ("pre",):
        return node.children
    children = []
    for child in node.children:
        if isinstance(child, str):
            child = " ".join(child.split())
        if child:
            children.append(child)
    return children


def _listed(names):
    counts = {}
    for name in names:
        counts[name] = counts.get(name, 0) + 1
    return ", ".join(f"{n} {name}" for name, n in counts.items()) or "nothing"


def _attributes(stored, now, place):
    if stored.keys() != now.keys():
        yield f"{place}: stored attributes {[*stored]}, now {[*now]}"
        return
    for key in stored:
        one, two = stored[key] or "", now[key] or ""
        if key in NAMES and one != two:
            yield f"{place}, {key}: stored {one[:60]!r}, now {two[:60]!r}"
        for fault in words.differences(one, two) if key not in NAMES else ():
            yield f"{place}, {key}: {fault}"


def _raw(node, stored, now, place):
    if node.attributes.get("type") == "application/json":
        for fault in data(_loaded(stored), _loaded(now)):
            yield f"{place}: data{fault}"
    elif stored.split() != now.split():
        yield f"{place}: its text changed"


@dataclass(frozen=True)
class Literal:
    """A number as it is written."""

    text: str

    def __str__(self):
        return self.text


def _loaded(text):
    return json.loads(text, parse_float=Literal, parse_int=Literal, parse_constant=str)


def data(stored, now, limit=5):
    """What two values of JSON don't agree in: a list of str."""
    faults = [*_values(stored, now)]
    return words.first(faults, limit)


def _values(stored, now):
    if stored == now:
        return
    if isinstance(stored, Literal) and isinstance(now, Literal):
        if not words.agree(stored.text, now.text):
            yield f": stored {stored}, now {now}"
    elif isinstance(stored, dict) and isinstance(now, dict):
        if stored.keys() != now.keys():
            yield f": stored keys {[*stored]}, now {[*now]}"
        for key in filter(now.__contains__, stored):
            for fault in _values(stored[key], now[key]):
                yield f".{key}{fault}"
    elif isinstance(stored, list) and isinstance(now, list):
        if len(stored) != len(now):
            yield f": stored {len(stored)} values, now {len(now)}"
            return
        for place, pair in enumerate(zip(stored, now)):
            for fault in _values(*pair):
                yield f"[{place}]{fault}"
    else:
        yield f": stored {str(stored)[:60]!r}, now {str(now)[:60]!r}"
