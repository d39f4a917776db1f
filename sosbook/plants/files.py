"""Plants from files: CSV, NumPy, Matrix Market, MATLAB and JSON."""

import json
from os import PathLike
from pathlib import Path

import numpy as np

from .second_order import Polytope, SecondOrderSystem

__all__ = ["load_plant"]

NAMES, OPTIONAL = "MDSBF", "F"


def load_plant(path: str | PathLike) -> SecondOrderSystem | Polytope:
    """Read a plant from a file, or from a folder with a file a matrix.

    Parameters
    ----------
    path : str or path
        A folder with ``M.csv``, ``D.csv``, ``S.csv``, ``B.csv`` and perhaps
        ``F.csv`` (numbers between commas, semicolons or spaces; ``#`` begins
        a comment), or ``M.mtx`` and so on (Matrix Market), or ``M.npy``. Or
        one file that holds them all under these names: ``.npz``, ``.mat``
        (up to MATLAB 7.2) or ``.json``. JSON may have a list of such plants
        under ``"vertices"``, and be the file of ``python -m sosbook design``.

    Returns
    -------
    SecondOrderSystem or Polytope
        A polytope where JSON has vertices.

    Raises
    ------
    FileNotFoundError
        If there is no such file, or a matrix is missing in a folder.
    ValueError
        If the kind of the file isn't known, or what it holds is no plant. The
        text names the file and the matrix.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     for name, text in dict(M="2", D="3", S="1", B="1").items():
    ...         _ = (Path(folder) / f"{name}.csv").write_text(text)
    ...     load_plant(folder).poles()
    array([-1. , -0.5])
    """
    path = Path(path)
    if path.is_dir():
        return _plant(path, _folder(path))
    if not path.exists():
        raise FileNotFoundError(f"{path}: there is no such file or folder")
    readers = {".npz": _npz, ".mat": _mat, ".json": _json}
    if path.suffix.lower() not in readers:
        known = ", ".join(readers)
        raise ValueError(
            f"{path}: give a file of the kind {known}, or a folder with a file "
            "for each matrix (M.csv, M.mtx or M.npy, ...)"
        )
    return readers[path.suffix.lower()](path)


def _plant(where, matrices):
    """The plant of some matrices by name; ``where`` they are from."""
    missing = [n for n in NAMES if n not in matrices and n not in OPTIONAL]
    if missing:
        raise ValueError(f"{where}: {', '.join(missing)} is missing")
    try:
        return SecondOrderSystem(**{n: matrices[n] for n in NAMES if n in matrices})
    except ValueError as error:
        raise ValueError(f"{where}: {error}") from None


def _folder(path):
    """The matrices of a folder."""
    matrices = {}
    for name in NAMES:
        files = [
            path / f"{name}{end}"
            for end in (".csv", ".mtx", ".npy")
            if (path / f"{name}{end}").exists()
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
    return matrices


def _matrix(file):
    if file.suffix == ".csv":
        return _csv(file)
    try:
        if file.suffix == ".npy":
            return np.load(file, allow_pickle=False)
        from scipy.io import mmread

        return mmread(file)
    except ValueError as error:
        raise ValueError(f"{file}: {error}") from None


def _csv(file):
    """A matrix of text, with the line of what is no number."""
    rows = []
    text = file.read_text("utf-8-sig")
    for number, line in enumerate(text.splitlines(), 1):
        words = line.partition("#")[0].replace(";", " ").replace(",", " ").split()
        if not words:
            continue
        try:
            rows.append([float(word) for word in words])
        except ValueError:
            raise ValueError(
                f"{file}, line {number}: {line.strip()!r:.60} has something that is "
                "no number; write 0.5 with a point, and no headings"
            ) from None
        if len(rows[-1]) != len(rows[0]):
            raise ValueError(
                f"{file}, line {number}: {len(rows[-1])} numbers, "
                f"the first line has {len(rows[0])}"
            )
    if not rows:
        raise ValueError(f"{file}: there are no numbers")
    return np.array(rows)


def _npz(path):
    with np.load(path, allow_pickle=False) as data:
        try:
            return _plant(path, {name: data[name] for name in data.files})
        except ValueError as error:
            raise ValueError(_named(path, error)) from None


def _mat(path):
    from scipy.io import loadmat
    from scipy.io.matlab import MatReadError

    try:
        data = loadmat(path)
    except (MatReadError, NotImplementedError, ValueError) as error:
        raise ValueError(
            f"{path}: {error}; in MATLAB, save with the option '-v7'"
        ) from None
    return _plant(path, {n: x for n, x in data.items() if not n.startswith("__")})


def _json(path):
    try:
        data = json.loads(path.read_bytes().decode("utf-8"))
    except ValueError as error:
        raise ValueError(f"{path} is no JSON file: {error}") from None
    if isinstance(data, dict) and isinstance(data.get("plant"), dict):
        data = data["plant"]
    if not isinstance(data, dict):
        raise ValueError(f'{path}: give {{"M": .., "D": .., "S": .., "B": ..}}')
    if "vertices" not in data:
        return _plant(path, data)
    vertices = data["vertices"]
    if not isinstance(vertices, list) or not vertices:
        raise ValueError(f"{path}: vertices must be a list of plants")
    plants = [_plant(f"{path}, vertices[{k}]", v) for k, v in enumerate(vertices)]
    try:
        return Polytope(plants)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None


def _named(path, error):
    text = str(error)
    return text if text.startswith(str(path)) else f"{path}: {text}"
