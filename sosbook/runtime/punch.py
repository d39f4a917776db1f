"""Matrices of Nastran's punch files: entries DMIG, of 8 or 16 letters a field."""

import re

from .tables import Entries

EXPONENT = re.compile(r"(?<=[0-9.])(?:[dDeE]([+-]?)|([+-]))(?=[0-9])")
MOST_LINES = 5_000_000
SYMMETRIC, SQUARE = 6, 1  # forms of a matrix; only one half of the first is written
REAL = 1, 2  # of single and double precision


def matrices_of_punch(text, whose):
    """The entries by name in a punch file's ``text``: from ((node, direction), (node,
    direction)) to the value, of both halves; ``whose`` is its name, for errors.
    """
    if text.count("\n") > MOST_LINES:
        raise ValueError(f"{whose} has more than {MOST_LINES} lines: write OUTPUT4")
    found, forms = {}, {}
    for where, fields in _cards(text, whose):
        try:
            _card(fields, found, forms)
        except ValueError as error:
            raise ValueError(f"{where}: {error}") from None
    if not found:
        raise ValueError(f"{whose}: there is no DMIG: PARAM,EXTOUT,DMIGPCH writes it")
    return found


def _cards(text, whose):
    """Where each DMIG begins, and its fields in fours, of all its lines."""
    where, card = "", []
    for place, line in enumerate(text.splitlines(), 1):
        line = line.partition("$")[0].rstrip()
        first = line[:8].split(",")[0].strip().upper()
        goes_on = bool(card) and (first[:1] in ("*", "+") or not first)
        if not line or not (goes_on or first.startswith("DMIG")):
            if line and card:
                yield where, card
                card = []
            continue
        if not goes_on:
            if card:
                yield where, card
            where, card = f"{whose}, line {place}", []
        if "," in line:
            words = line.split(",")[1:9]
        else:
            size = 16 if first.endswith("*") or first.startswith("*") else 8
            words = [line[k : k + size] for k in range(8, 72, size)]
        card += [x.strip() for x in words] + [""] * (-len(words) % 4)
    if card:
        yield where, card


def _card(fields, found, forms):
    """Put a card into what is ``found`` of its matrix, of one of the ``forms``."""
    name, node, direction = fields[0].upper(), fields[1], fields[2] or "0"
    if node == "0" and name not in forms:
        form, kind = _whole(direction), _whole(fields[3])
        if form not in (SYMMETRIC, SQUARE) or kind not in REAL:
            raise ValueError(
                f"{name} is of the form {form} and type {kind}: only real square and "
                "symmetric matrices are read (1 or 6, of type 1 or 2)"
            )
        forms[name], found[name] = form, Entries()
        return
    if name not in forms:
        raise ValueError(f"{name} has no head, DMIG with a node 0, before its entries")
    column, entries = (_whole(node), _whole(direction)), found[name]
    for k in range(4, len(fields), 4):
        if not any(fields[k : k + 4]):
            continue
        row = _whole(fields[k]), _whole(fields[k + 1] or "0")
        entries.put(row, column, EXPONENT.sub(r"e\1\2", fields[k + 2]))
        if forms[name] == SYMMETRIC:
            entries[column, row] = entries[row, column]


def _whole(word):
    if not (word.isascii() and word.isdigit()):
        raise ValueError(f"{word!r:.20} is no whole number")
    return int(word)
