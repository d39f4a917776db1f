"""Which plant, gain and start a proof file is about, and whether they are the wanted.

A checksum can be mended, and a proof of an easier plant is a proof. So a verdict names
what it is about, and `compare` holds it against the reader's own files.
"""

import json

from ..exact.rational import decimals
from ..plants.as_data import plant_data
from ..plants.checks import matrix
from ..plants.files import load_plant
from ..runtime.digests import short_digest
from ..runtime.reading import named, path_of, read_json

__all__ = ["compare_gain", "compare_plant", "subject"]

SHOWN = 120  # characters of what is printed as it is; of more the sizes are
PARTS = "plant", "U", "K_A", "K", "L"  # keys of a proof file


def subject(data):
    """What a proof is about: each part with its digest, and its numbers if few.

    Parameters
    ----------
    data : dict
        Those of a proof file, see `ProofFile.data`.

    Returns
    -------
    str
        The plant, U, K_A, the gains and the starts x0 that there are, in a line; the
        digests are `short_digest` of their data. Empty for a proof about other things.

    Examples
    --------
    >>> subject({"K": [["1", "-2"]], "U": []})
    'K e31ba7a7b60d = [[1, -2]]'
    """
    parts = [(name, data[name]) for name in PARTS if data.get(name)]
    parts += [("x0", r["x0"]) for r in data.get("requirements", []) if "x0" in r]
    return ", ".join(
        f"{name} {short_digest(value)} {shown(value)}" for name, value in parts
    )


def shown(value):
    """A part of a proof file in a few words: its numbers, or its sizes."""
    text = json.dumps(value).replace('"', "")
    return f"= {text}" if len(text) <= SHOWN else f"({size(value)})"


def size(value):
    """The sizes of matrices, and of lists of them."""
    if isinstance(value, dict):
        return ", ".join(f"{key} {size(inner)}" for key, inner in value.items())
    if not isinstance(value, list) or not value:
        return json.dumps(value).replace('"', "")[:SHOWN]
    if isinstance(value[0], dict):
        return f"{len(value)} with {size(value[0])}"
    if isinstance(value[0], list):
        return f"{len(value)} x {len(value[0])}"
    return f"{len(value)} numbers"


def compare_plant(data, path):
    """What keeps the data of a proof from being about the plant of a file; or "".

    Parameters
    ----------
    data : dict
        Those of a proof file.
    path : str or Path
        As `load_plant` takes it. Where it is a file of ``python -m sosbook design``,
        its U and K_A must be the proof's, too.
    """
    wanted = {"plant": plant_data(load_plant(path))}
    if path_of(path).suffix.lower() == ".json" and "plant" in (file := read_json(path)):
        with named(path):
            for name, none in (("U", []), ("K_A", None)):
                given = file.get(name)
                wanted[name] = none if given is None else decimals(matrix(name, given))
    for name, value in wanted.items():
        if name == "plant" or name in data:
            if data.get(name) != value:
                return f"it is about another {name} than {path}{_where(data, wanted)}"
    return ""


def _where(data, wanted):
    """The first matrix that differs, if the plants have one shape."""
    mine, yours = (x.get("plant") or {} for x in (data, wanted))
    pairs = zip(mine.get("vertices", ()), yours.get("vertices", ()))
    for k, (a, b) in enumerate(pairs, 1):
        for name in a:
            if a[name] != b.get(name):
                return f": {name} of vertex {k} differs"
    return ""


def compare_gain(data, path):
    """What keeps the data of a proof from being about the gain of a file; or "".

    Parameters
    ----------
    data : dict
        Those of a proof file.
    path : str or Path
        JSON: a matrix, or an object with one under "K", as ``design`` prints it.
    """
    given = read_json(path)
    if isinstance(given, dict):
        given = given.get("K")
    with named(path):
        wanted = decimals(matrix("K", given))
    if data.get("K") == wanted:
        return ""
    return f"it is about another K than {path}"
