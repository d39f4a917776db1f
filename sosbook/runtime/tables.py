"""Matrices in texts: tables of numbers, and entries as Abaqus or CalculiX have them."""

import numpy as np

from .reading import number, read_text

MOST_WORDS = 5_000_000  # numbers of a table, lines of entries: each is an object
MOST_ROWS = 20_000_000
TABLE = "row", "column", "value"  # the heading of a table of entries


class Entries(dict):
    """Numbers of a matrix by (row, column): each a node and a direction, or where they
    are ``numbered`` a number from 1, and 0. ``half``: one triangle may stand for both.
    """

    half, numbered = False, False

    def put(self, row, column, word):
        """Put the number of a ``word`` into a ``row`` and ``column`` once."""
        if (row, column) in self:
            raise ValueError(
                f"the entry of {_spot(row)} and {_spot(column)} is there twice"
            )
        self[row, column] = number(word)


def _spot(dof):
    return f"{dof[0]}.{dof[1]}" if dof[1] else f"{dof[0]}"


def read_csv(path):
    """The matrix in the text file at ``path`` of `load_plant`, or its `Entries` below
    the heading row, column, value; errors name a line.
    """
    rows, text, table = [], read_text(path, bom=True), None
    if sum(map(text.count, ";, \t")) > MOST_WORDS:
        raise ValueError(f"{path} has more than {MOST_WORDS} numbers: save it as .npy")
    for place, line in enumerate(text.splitlines(), 1):
        line = line.partition("#")[0].strip()
        if not line:
            continue
        between = next((x for x in ";," if x in line), None)
        words = [word.strip() for word in line.split(between)]
        if table is None and not rows and (*map(str.lower, words),) == TABLE:
            table = Entries()
            continue
        try:
            if table is not None:
                _put(table, words)
                continue
            rows.append(list(map(number, words)))
        except ValueError as error:
            more = (
                ""
                if rows or table is not None
                else (f", and no headings but {', '.join(TABLE)} of a table of entries")
            )
            raise ValueError(f"{path}, line {place}: {error}{more}") from None
        if len(rows[-1]) != len(rows[0]):
            raise ValueError(
                f"{path}, line {place}: {len(rows[-1])} numbers, "
                f"the first line has {len(rows[0])}"
            )
    if not rows and not table:
        raise ValueError(f"{path}: there are no numbers")
    return np.array(rows) if table is None else table


def _put(entries, words, dofs=None):
    """Put a line's ``words``, row, column and value, into ``entries``; ``dofs`` are the
    rows' names.
    """
    places = [int(x) if x.isascii() and x.isdigit() else 0 for x in words[:2]]
    most = MOST_ROWS if dofs is None else len(dofs)
    if len(words) != 3 or not 1 <= min(places) <= max(places) <= most:
        raise ValueError(
            f"{' '.join(words)!r:.60} isn't row, column (from 1 to {most}) and value"
        )
    if entries and entries.numbered != (dofs is None):
        raise ValueError("some lines have nodes, and some numbers of rows")
    entries.numbered = dofs is None
    row, column = ((k, 0) if dofs is None else dofs[k - 1] for k in places)
    entries.put(row, column, words[2])


def read_entries(path, dofs=None):
    """The `Entries` in a matrix file of Abaqus or CalculiX at ``path``, of lines "node,
    dof, node, dof, value" or "row column value", whose rows may be called ``dofs``;
    None of a Matrix Market file. A ValueError has the line that is neither.
    """
    entries, text = Entries(), read_text(path)
    entries.half = True
    if not text.startswith("%%MatrixMarket") and text.count("\n") > MOST_WORDS:
        raise ValueError(f"{path} has more than {MOST_WORDS} lines: save it as .mat")
    for place, line in enumerate(text.splitlines(), 1):
        if line.startswith("%%MatrixMarket"):
            return None
        words = [word.strip() for word in line.split("," if "," in line else None)]
        if line.startswith("*") or words in ([""], []):  # keywords, comments
            continue
        where = f"{path}, line {place}"
        try:
            if len(words) == 3:
                _put(entries, words, dofs)
                continue
            if len(words) != 5 or not all(
                w.isascii() and w.isdigit() for w in words[:4]
            ):
                raise ValueError(
                    f"{line!r:.60} is neither 'node, dof, node, dof, value' nor 'row "
                    "column value' of Abaqus nor has the file Matrix Market's first "
                    "line, %%MatrixMarket"
                )
            if entries.numbered:
                raise ValueError("some lines have nodes, and some numbers of rows")
            row, column = tuple(map(int, words[:2])), tuple(map(int, words[2:4]))
            entries.put(row, column, words[4])
        except ValueError as error:
            raise ValueError(f"{where}: {error}") from None
    return entries


def read_dofs(path):
    """The rows of CalculiX's matrices, (node, direction), of the file at ``path``."""
    words = read_text(path).split()
    parts = [word.split(".") for word in words]
    if bad := [
        w for w, x in zip(words, parts) if not (len(x) == 2 and "".join(x).isdigit())
    ]:
        raise ValueError(f"{path}: {bad[0]!r:.40} is no node.direction")
    return [tuple(map(int, x)) for x in parts]
