"""What a program in C has for numbers, read back and held to what was proven."""

import re

import numpy as np

from ..exact.rational import read_number

__all__ = ["code_fault", "read_gains"]

DEFINED = re.compile(
    r"#define [A-Z][A-Z0-9_]*?_(A|B|C|D|TICK|SINGLE) (.*?)(?<!\\)\n", re.S
)
NUMBER = re.compile(r"-?0x[0-9a-f.]+p[+-]?\d+|-?\d+(?:\.\d*)?")


def read_gains(text):
    """A, B, C, D, TICK and SINGLE of the text of a <name>_gains.h.

    Parameters
    ----------
    text : str
        Of the file.

    Returns
    -------
    dict
        Arrays, and numbers.

    Raises
    ------
    ValueError
        If one is missing or can't be read.
    """
    plain = re.sub(r"/\*.*?\*/", "", text, flags=re.S).replace("\r", "")
    found = {}
    for label, value in DEFINED.findall(plain):
        if label in found:
            raise ValueError(f"{label} is defined twice")
        rows = re.findall(r"\{([^{}]*)\}", value)
        numbers = [[_value(x) for x in NUMBER.findall(row)] for row in rows or [value]]
        found[label] = np.array(numbers) if rows else numbers[0][0]
    if lost := {"A", "B", "C", "D", "TICK", "SINGLE"} - found.keys():
        raise ValueError(f"the text defines no {', '.join(sorted(lost))}")
    return found


def _value(text):
    return float.fromhex(text) if "x" in text else float(text)


def code_fault(data, text):
    """What keeps a program from being that of a proof; empty if nothing does.

    Parameters
    ----------
    data : dict
        Of a proof file of the kind "sampled", of a controller.
    text : str
        Of the program's <name>_gains.h.
    """
    law = data.get("K")
    if not isinstance(law, dict):
        return "the proof is about no sampled controller"
    try:
        mine = read_gains(text)
    except ValueError as error:
        return str(error)
    kind = np.float32 if mine["SINGLE"] else float
    if mine["TICK"] != float(kind(read_number(data["T"]))):
        return "its TICK isn't the proof's T"
    law = {name: _read(law[name], kind) for name in "ABCD"}
    for name in "AC":
        if not _same(law[name], mine[name]):
            return f"its {name} isn't the proof's"
    # the proof has a column of B and D for each state, and those that aren't measured
    # are zero; in which order a program measures is no part of a proof
    columns = [_columns(law), _columns(mine)]
    if columns[0] != columns[1]:
        return "its B and D aren't the proof's"
    return ""


def _read(rows, kind):
    """A matrix of decimals as floats, rounded as the program has them."""
    if not rows:
        return np.zeros((0, 0))
    numbers = [[read_number(x) for x in row] for row in rows]
    return np.array(numbers, float).astype(kind).astype(float)


def _same(a, b):
    """Whether they are equal; nothing is a zero, which C needs."""
    return (a.shape == b.shape and (a == b).all()) or (not a.size and not b.any())


def _columns(law):
    """The columns of B and D that aren't zero, sorted."""
    D = law["D"]
    B = law["B"] if law["B"].shape[1:] == D.shape[1:] else np.zeros((0, D.shape[1]))
    both = np.vstack([B if B.any() else B[:0], D])
    return sorted(column.tolist() for column in both.T if column.any())
