"""Files as Nastran's OUTPUT4 writes them, for tests of the reader."""

import struct

import numpy as np


def strings(column):
    """(first row, values) of each run of entries that aren't zero, from 1."""
    rows = np.flatnonzero(column)
    runs = np.split(rows, np.flatnonzero(np.diff(rows) > 1) + 1)
    return [(int(r[0]) + 1, column[r]) for r in runs if r.size]


def dense(column):
    """(first row, values) from the first entry that isn't zero to the last."""
    rows = np.flatnonzero(column)
    if not rows.size:
        return []
    return [(int(rows[0]) + 1, column[rows[0] : rows[-1] + 1])]


def binary_op4(matrices, way="dense", order="<", word=4, single=False):
    """The bytes of a binary file; ``way`` is dense, strings or large."""
    number = order + {4: "i", 8: "q"}[word]
    real = "f4" if single and word == 4 else "f8"
    each = int(real[1]) // word

    def whole(*values):
        return b"".join(struct.pack(number, x) for x in values)

    def record(data):
        mark = struct.pack(order + "i", len(data))
        return mark + data + mark

    parts = []
    for name, x in matrices.items():
        rows, columns = x.shape
        high = -rows if way == "large" else rows
        kind = 1 if single else 2
        head = whole(columns, high, 2, kind) + name.ljust(2 * word).encode()
        parts.append(record(head))
        for j, column in enumerate(x.T, 1):
            data, words = b"", 0
            for row, values in (dense if way == "dense" else strings)(column):
                many = len(values) * each
                if way == "strings":
                    data += whole(row + 65536 * (many + 1))
                elif way == "large":
                    data += whole(many + 1, row)
                words += many + {"dense": 0, "strings": 1, "large": 2}[way]
                data += values.astype(order + real).tobytes()
                first = row if way == "dense" else 0
            if data:
                parts.append(record(whole(j, first, words) + data))
        parts.append(record(whole(columns + 1, 1, each) + bytes(each * word)))
    return b"".join(parts)


def ascii_op4(matrices, way="dense", form="1P,3E23.16", counts=1):
    """The text of a file in ASCII; a dense column counts ``counts`` words a value."""
    each, width = int(form[3]), int(form[5:7])
    lines = []

    def numbers(values):
        words = [f"{v:{width}.16E}".replace("E", "D") for v in values]
        for k in range(0, len(words), each):
            lines.append("".join(words[k : k + each]))

    for name, x in matrices.items():
        rows, columns = x.shape
        high = -rows if way == "large" else rows
        lines.append(f"{columns:8d}{high:8d}{2:8d}{2:8d}{name:8s}{form}")
        for j, column in enumerate(x.T, 1):
            parts = (dense if way == "dense" else strings)(column)
            if way == "dense":
                for row, values in parts:
                    lines.append(f"{j:8d}{row:8d}{len(values) * counts:8d}")
                    numbers(values)
            elif parts:
                heads = 1 if way == "strings" else 2
                words = sum(2 * len(v) + heads for _, v in parts)
                lines.append(f"{j:8d}{0:8d}{words:8d}")
                for row, values in parts:
                    many = 2 * len(values)
                    if way == "strings":
                        lines.append(f"{row + 65536 * (many + 1):8d}")
                    else:
                        lines.append(f"{many + 1:8d}{row:8d}")
                    numbers(values)
        lines.append(f"{columns + 1:8d}{1:8d}{1:8d}")
        numbers([1.0])
    return "\n".join(lines) + "\n"
