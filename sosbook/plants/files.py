"""Plants from files: CSV, NumPy, Matrix Market, MATLAB and JSON."""

from os import PathLike

import numpy as np

from ..runtime.reading import (
    named,
    number,
    path_of,
    read_json,
    read_mat,
    read_mtx,
    read_npy,
    read_npz,
    read_text,
)
from .second_order import Polytope, SecondOrderSystem
from .uncertain import Uncertain

__all__ = ["load_plant", "plant_of"]

NAMES, OPTIONAL = "MDSBF", "F"
ENDS = ".csv", ".mtx", ".npy"


def load_plant(path: str | PathLike) -> SecondOrderSystem | Polytope | Uncertain:
    """Read a plant from a file, or from a folder with a file a matrix.

    Parameters
    ----------
    path : str or path
        A folder with ``M.csv``, ``D.csv``, ``S.csv``, ``B.csv`` and perhaps
        ``F.csv`` (numbers with a point, between commas, semicolons or spaces,
        one of these in a line; ``#`` begins a comment), or ``M.mtx`` and so on
        (Matrix Market), or ``M.npy``. Or one file that holds them all under
        these names: ``.npz``, ``.mat`` (up to MATLAB 7.2) or ``.json``. JSON
        may have a list of such plants under ``"vertices"``, or ranges under
        ``"parameters"``, and be the file of ``python -m sosbook design``.

    Returns
    -------
    SecondOrderSystem, Polytope or Uncertain
        A polytope where JSON has vertices, a family where it has parameters.

    Raises
    ------
    FileNotFoundError
        If there is no such file, or a matrix is missing in a folder.
    ValueError
        If the kind of the file isn't known, or what it holds is no plant, or it is
        beyond the limits of `sosbook.runtime.reading`. The text names the file and
        the matrix.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     for name, text in dict(M="2", D="3", S="1", B="1").items():
    ...         _ = (Path(folder) / f"{name}.csv").write_text(text)
    ...     load_plant(folder).poles()
    array([-1. , -0.5])
    """
    place = path_of(path)
    kind = place.suffix.lower()
    if place.is_dir():
        return _plant(place, _folder(place))
    if not place.exists():
        raise FileNotFoundError(f"{path}: there is no such file or folder")
    readers = {".npz": read_npz, ".mat": _mat, ".json": read_json}
    if kind not in readers:
        known = ", ".join(readers)
        raise ValueError(
            f"{path}: give a file of the kind {known}, or a folder with a file "
            "for each matrix (M.csv, M.mtx or M.npy, ...)"
        )
    data = readers[kind](place)
    if kind != ".json":
        return _plant(place, data)
    if isinstance(data, dict) and "plant" in data:
        data = data["plant"]
    with named(path):
        return plant_of(data)


def plant_of(data, where="plant"):
    """The plant of plain data: its matrices by name, or vertices.

    Parameters
    ----------
    data : dict
        M, D, S, B and perhaps F; or a list of such under ``"vertices"``; or with
        ranges under ``"parameters"``, ``{"m": [1, 2]}``, and entries that may be
        polynomials in words, ``"0.5*m + 1"``.
    where : str
        What errors call it.

    Returns
    -------
    SecondOrderSystem, Polytope or Uncertain
        A polytope where there are vertices, a family where there are parameters.

    Raises
    ------
    ValueError
        If a key is missing or too many, or the matrices are no plant.
    """
    if isinstance(data, dict) and "parameters" in data:
        return _family(where, data)
    if not isinstance(data, dict) or "vertices" not in data:
        return _vertex(where, data)
    several = data["vertices"]
    if not isinstance(several, list) or len(data) > 1:
        raise ValueError(f"{where}: vertices must be a list, and the only key")
    if not several:
        raise ValueError(f"{where}: vertices is empty")
    plants = [_vertex(f"{where}.vertices[{k}]", v) for k, v in enumerate(several)]
    return Polytope(plants)


def _family(where, data):
    """Matrices whose entries are numbers or polynomials in words, and ranges."""
    matrices = {name: rows for name, rows in data.items() if name != "parameters"}
    ranges = data["parameters"]
    if not {*"MDSB"} <= matrices.keys() <= {*NAMES}:
        raise ValueError(f"{where} needs the keys M, D, S, B and may have F")
    if not isinstance(ranges, dict) or not all(
        isinstance(x, list) and len(x) == 2 for x in ranges.values()
    ):
        raise ValueError(f'{where}: parameters must be like {{"m": [1, 2]}}')
    several = [[name, *ends] for name, ends in ranges.items()]
    try:
        return Uncertain.read(
            SecondOrderSystem, {"parameters": several, **matrices}, rows=True
        )
    except (TypeError, AttributeError):
        raise ValueError(f"{where}: a matrix must be a list of rows") from None
    except ValueError as error:
        raise ValueError(f"{where}: {error}") from None


def _vertex(where, data):
    if not isinstance(data, dict) or not {*"MDSB"} <= data.keys() <= {*NAMES}:
        raise ValueError(f"{where} needs the keys M, D, S, B and may have F")
    return _plant(where, data)


def _plant(where, matrices):
    """The plant of some matrices by name; ``where`` they are from."""
    missing = [n for n in NAMES if n not in matrices and n not in OPTIONAL]
    if missing:
        raise ValueError(f"{where}: {', '.join(missing)} is missing")
    _refuse_small_letters(where, matrices)
    try:
        return SecondOrderSystem(**{n: matrices[n] for n in NAMES if n in matrices})
    except ValueError as error:
        raise ValueError(f"{where}: {error}") from None


def _refuse_small_letters(where, names):
    """An f isn't dropped as if no F were meant."""
    for name in OPTIONAL:
        if name not in names and name.lower() in names:
            raise ValueError(f"{where}: {name.lower()} isn't read: call it {name}")


def _folder(path):
    """The matrices of a folder."""
    matrices = {}
    for name in NAMES:
        files = [
            path / f"{name}{end}" for end in ENDS if (path / f"{name}{end}").exists()
        ]
        if len(files) > 1:
            raise ValueError(
                f"{path}: {name} is there twice: {files[0].name}, {files[1].name}"
            )
        if files:
            matrices[name] = _matrix(files[0])
        elif name not in OPTIONAL:
            raise FileNotFoundError(
                f"{path}: {name}.csv, {name}.mtx or {name}.npy is missing"
            )
    there = {*matrices, *(x.stem for x in path.iterdir() if x.suffix in ENDS)}
    _refuse_small_letters(path, there)
    return matrices


def _matrix(file):
    return {".csv": _csv, ".npy": read_npy, ".mtx": read_mtx}[file.suffix](file)


def _csv(file):
    """A matrix of text, with the line of what is no number."""
    rows = []
    for place, line in enumerate(read_text(file, bom=True).splitlines(), 1):
        line = line.partition("#")[0].strip()
        if not line:
            continue
        between = next((x for x in ";," if x in line), None)
        try:
            rows.append([number(word.strip()) for word in line.split(between)])
        except ValueError as error:
            raise ValueError(
                f"{file}, line {place}: {error}, and no headings"
            ) from None
        if len(rows[-1]) != len(rows[0]):
            raise ValueError(
                f"{file}, line {place}: {len(rows[-1])} numbers, "
                f"the first line has {len(rows[0])}"
            )
    if not rows:
        raise ValueError(f"{file}: there are no numbers")
    return np.array(rows)


def _mat(path):
    return read_mat(path, [*NAMES, *OPTIONAL.lower()])
