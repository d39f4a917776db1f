"""Matrices of Nastran: files of OUTPUT4, in ASCII or binary, dense or sparse."""

import re
import struct

import numpy as np
from scipy.sparse import coo_array

from .reading import number

HEAD = {24: "i4", 48: "i8"}  # the first record's bytes, and the words of its numbers
REAL = {1: "f4", 2: "f8"}  # by the matrix's type; 3 and 4 are complex
FORM = re.compile(r"(?:1P,)?(\d+)[ED](\d+)\.", re.IGNORECASE)  # 1P,3E23.16
FIELD = 8  # columns of a whole number in ASCII
HALF = 1 << 16  # a string's head is its row and this times its words and one


def matrices_of_op4(content, check_size):
    """The sparse matrices by name in an OUTPUT4 file's ``content``; ``check_size`` sees
    rows and columns before each. A ValueError: it ends early, is none, or is complex.
    """
    for order in "<>":
        if len(content) > 4 and struct.unpack(order + "i", content[:4])[0] in HEAD:
            parts = _of_records(content, order)
            break
    else:
        parts = _of_lines(content.decode("ascii").splitlines())
    found = {}
    for name, rows, columns, entries in parts:
        if name in found:
            raise ValueError(f"{name!r:.20} is there twice")
        check_size(rows, columns, full=False)
        found[name] = _matrix(name, rows, columns, entries, check_size)
    if not found:
        raise ValueError("there is no matrix")
    return found


def _matrix(name, rows, columns, entries, check_size):
    """A sparse matrix of (first row, column, values), from 1."""
    i, j, v, count = [], [], [], 0
    for row, column, values in entries:
        count += len(values)
        check_size(count)
        if not (row >= 1 and row + len(values) - 1 <= rows and 1 <= column <= columns):
            raise ValueError(f"{name} has an entry outside of {rows} x {columns}")
        i.append(np.arange(row - 1, row - 1 + len(values)))
        j.append(np.full(len(values), column - 1))
        v.append(values)
    if not v:
        return coo_array((rows, columns))
    places = np.concatenate(i), np.concatenate(j)
    whole = coo_array((np.concatenate(v), places), shape=(rows, columns))
    if len(np.unique(places[0] * columns + places[1])) < len(places[0]):
        raise ValueError(f"{name} has an entry twice")
    return whole


def _kind(name, kind):
    if kind not in REAL:
        raise ValueError(f"{name} is of type {kind}: only real matrices are read")
    return REAL[kind]


def _of_records(content, order):
    """(name, rows, columns, entries) of each matrix of a binary file."""
    place, records = 0, []
    while place < len(content):
        try:
            (size,) = struct.unpack_from(order + "i", content, place)
            (again,) = struct.unpack_from(order + "i", content, place + 4 + size)
        except struct.error:
            raise ValueError("it ends in the middle of a record") from None
        if size != again or size < 0:
            raise ValueError("a record isn't as long as it says")
        records.append(content[place + 4 : place + 4 + size])
        place += size + 8
    rest = iter(records)
    for head in rest:
        if len(head) not in HEAD:
            raise ValueError("a matrix begins with a record of another size")
        word = np.dtype(order + HEAD[len(head)])
        columns, rows, _, kind = np.frombuffer(head, word, 4).tolist()
        name = head[4 * word.itemsize :].decode("ascii").strip()
        real = np.dtype(order + _kind(name, kind))
        real = max(real, np.dtype(f"{order}f{word.itemsize}"), key=lambda x: x.itemsize)
        entries = _columns(name, rest, columns, rows < 0, word, real)
        yield name, abs(rows), columns, entries


def _columns(name, records, columns, large, word, real):
    """Entries of the columns of a binary matrix."""
    each = real.itemsize // word.itemsize
    for record in records:
        if len(record) < 3 * word.itemsize:
            raise ValueError(f"a column of {name} has no head")
        column, row, words = np.frombuffer(record, word, 3).tolist()
        if column > columns:
            return
        data = record[3 * word.itemsize : (3 + words) * word.itemsize]
        if len(data) != words * word.itemsize:
            raise ValueError(f"column {column} of {name} is shorter than it says")
        if row > 0:
            yield row, column, np.frombuffer(data, real).astype(float)
            continue
        place, heads = 0, 2 if large else 1
        while place < words:
            head = np.frombuffer(data, word, heads, place * word.itemsize).tolist()
            row, many = _string(head)
            start = (place + heads) * word.itemsize
            values = np.frombuffer(data, real, many // each, start)
            yield row, column, values.astype(float)
            place += heads + many
    raise ValueError(f"{name} has no last column")


def _string(head):
    """Row and words of a string of entries, of one number or of two."""
    if len(head) == 2:
        return head[1], head[0] - 1
    many = head[0] // HALF - 1
    return head[0] - (many + 1) * HALF, many


def _of_lines(lines):
    """(name, rows, columns, entries) of each matrix of a file in ASCII."""
    rest = iter(list(enumerate(lines, 1)))
    for place, line in rest:
        if not line.strip():
            continue
        head = [line[k : k + FIELD] for k in range(0, 5 * FIELD, FIELD)]
        try:
            columns, rows, _, kind = map(int, head[:4])
        except ValueError:
            raise ValueError(
                f"line {place}: {line!r:.60} is no head of a matrix: columns, rows, "
                "form, type and name, of 8 places each"
            ) from None
        name, form = head[4].strip(), FORM.search(line[5 * FIELD :])
        width = int(form[2]) if form else 16
        each = int(_kind(name, kind)[1]) // 4
        yield name, abs(rows), columns, _ascii(name, rest, columns, each, width)


def _ascii(name, lines, columns, each, width):
    """Entries of the columns of a matrix in ASCII."""
    column, row, wanted, values, ways = 0, 0, 0, None, set()
    for place, line in lines:
        if "." in line:
            if values is None:
                raise ValueError(f"line {place}: numbers without a head")
            text = line.rstrip().upper().replace("D", "E")
            parts = [text[k : k + width] for k in range(0, len(text), width)]
            values += [number(part.strip()) for part in parts]
            if column > columns:
                return
            continue
        if values is not None:
            ways |= {x for x in (1, each) if x * len(values) == wanted}
            if len(ways) != 1 or wanted != max(ways) * len(values):
                raise ValueError(f"column {column} of {name} is shorter than it says")
            yield row, column, np.array(values)
        head = [int(line[k : k + FIELD]) for k in range(0, len(line.rstrip()), FIELD)]
        values = None
        if len(head) == 3:
            column, row, wanted = head
            values = [] if row > 0 else None
        elif len(head) in (1, 2):
            row, wanted = _string(head)
            values = []
        else:
            raise ValueError(f"line {place}: {line!r:.60} is no head of a column")
    raise ValueError(f"{name} has no last column")
