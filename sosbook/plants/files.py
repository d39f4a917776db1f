"""Plants from files of other programs, and of JSON."""

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import fields
from os import PathLike

from ..runtime.matrix_files import (
    read_harwell,
    read_mat,
    read_mtx,
    read_npy,
    read_npz,
    read_op4,
    read_punch,
    read_sparse,
)
from ..runtime.reading import named, path_of, read_bytes, read_data
from ..runtime.saying import warn_outside
from ..runtime.tables import read_csv, read_dofs, read_entries
from .as_data import ALIASES, NAMES, plant_of
from .descriptor_system import DescriptorSystem
from .matrix_names import ENDS, HARWELL, LETTERS, chosen_names, listed_names
from .second_order import Polytope, SecondOrderSystem
from .state_space import is_step, plant_of_state_space
from .structure import Beside, matrix_of, structure_of
from .suspicions import half_fault, idle_inputs, suspicion
from .uncertain import Uncertain

IN_WORDS = ".json", ".toml"
PLAIN = Beside()
READERS = {
    ".npz": read_npz,
    ".mat": read_mat,
    ".h5": read_mat,
    ".hdf5": read_mat,
    ".op4": read_op4,
    ".pch": read_punch,
}
MARKET = b"%%MatrixMarket"
LETTERS_OF_FILES = (*NAMES, *LETTERS, *ALIASES.values())
CALCULIX = {".sti": "K", ".mas": "M"}  # by the endings of its files
HINTS = dict.fromkeys((*CALCULIX, ".dof"), "; put .sti, .mas and .dof into a folder")
HINTS |= dict.fromkeys(
    (".uff", ".unv"), "; its responses are read by sosbook.plants.MeasuredResponse.read"
)


def load_plant(
    path: str | PathLike,
    names: Mapping[str, str] | None = None,
    *,
    without: Sequence[int] = (),
    condensed: bool = False,
    push: Sequence[str | int] = (),
    rayleigh: tuple[float, float] | None = None,
) -> SecondOrderSystem | Polytope | Uncertain | DescriptorSystem:
    """Read a plant from a file, or from a folder with a file a matrix.

    Parameters
    ----------
    path : str or path
        A folder with ``M.csv``, ``D.csv``, ``S.csv``, ``B.csv`` and perhaps
        ``F.csv``, or .txt (numbers with a point, between commas, semicolons or spaces,
        one of these in a line, or row, column and value below a line of these three
        words; ``#`` begins a comment), or ``M.mtx`` and so on (Matrix Market, or
        Abaqus's lines "node, dof, node, dof, value" or "row column value"), ``M.npy``,
        or ``M.npz`` (scipy.sparse.save_npz), or ``M.rsa``, ``.rua``, ``.rb``, ``.hb``
        (Harwell-Boeing, as Ansys's HBMAT writes it), or ``any.M`` (Matrix Market), or
        CalculiX's ``.sti``, ``.mas`` and
        ``.dof`` of a job. Or one file that holds them all under
        these names: ``.npz``, ``.mat``, ``.h5`` (that and MATLAB 7.3 by h5py),
        ``.op4`` (Nastran's OUTPUT4, ASCII or binary), ``.pch`` (its punch file of
        DMIG), ``.json`` or ``.toml``. The fields of a struct of MATLAB are called
        ``sys.M``, and serve where the file has no plant beside it. Where S
        or D isn't there, ``K`` of the size of M is the stiffness and ``C`` the damping.
        Without M, but with ``A``, or with ``ABCD`` and ``nx`` (Modelica), they are a
        state space E x' = A x + B u + B_w w, y = C x + D u, where only A is needed;
        with ``dt`` or ``Ts`` one of discrete time. Small letters serve where there are
        no large ones. JSON and TOML have M, D, S, B and F
        alone, or a list of such plants under ``"vertices"``, or ranges under
        ``"parameters"``; they may be the file of ``python -m sosbook design``, whose
        ``"plant"`` may be the name of another file, beside it.
    names : dict, optional
        From a matrix to what it is called there: ``{"S": "Kaa"}``.
    without : sequence of int, optional
        Displacements that are held at zero, from 0: their rows and columns are left
        out. For supports that a program writes as penalties.
    condensed : bool, optional
        Whether `condense` solves for the displacements without mass and damping, or
        the states of a state space that have no derivative are solved for as exactly.
    push : sequence of str or int, optional
        B, which no program of finite elements writes: for each actuator the
        displacement that it pushes, "103.2" for node 103 and direction 2 where the
        file names them, or its row, from 0.
    rayleigh : (float, float), optional
        Damping D = a M + b S in the place of a D that isn't there; (0, 0) for none.

    Returns
    -------
    SecondOrderSystem, Polytope, Uncertain or DescriptorSystem
        A polytope where JSON has vertices, a family where it has parameters. Of a
        state space with x = [z; z'] in any order, E = 1 and D = 0 the second-order
        system, else the descriptor system.

    Raises
    ------
    FileNotFoundError
        If there is no such file, or a matrix is missing in a folder.
    ValueError
        If the kind of the file isn't known, or what it holds is no plant, has supports
        by penalties, or is beyond the limits of `sosbook.runtime.reading`. The text
        names the file and the matrix.

    Warns
    -----
    UserWarning
        If a state space is of second order and its C is left out, the file has more
        than the plant, M isn't symmetric or M, D or S is half of a symmetric matrix.

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
    beside = Beside(without, condensed, push, rayleigh)
    plant, _, odd = _read(path, names or {}, beside)
    return _said(path, plant, odd)


def plant_and_asked(path):
    """The plant of a file or folder at ``path``, and what the file asks, a dict or
    None.

    Only JSON or TOML asks: its key "plant" has matrices, the name of a file that
    `load_plant` takes, or ``{"file": "a.mat", "without": [1]}``, with ``names`` and
    the other arguments of `load_plant`; its other keys are what is asked.
    """
    plant, asked, odd = _read(path, {})
    return _said(path, plant, odd), asked


def _said(path, plant, odd):
    """The plant; a warning of what the file at a path says that may be wrong."""
    if odd:
        warn_outside(f"{path}: {odd}")
    return plant


def _read(path, names, beside=PLAIN):
    """The plant, what is asked or None, and what isn't used or may be wrong."""
    place = path_of(path)
    kind = place.suffix.lower()
    chosen, left = {}, []

    def wanted(there):
        chosen.update(chosen_names(place, there, names, beside.made))
        left.extend(x for x in there if x not in chosen.values())
        return [*chosen.values()]

    if place.is_dir():
        files = _folder(place)
        there = {own: _matrix(place, own, files[own]) for own in wanted(files)}
    elif not place.exists():
        raise FileNotFoundError(f"{path}: there is no such file or folder")
    elif kind in IN_WORDS:
        if names or beside:
            raise ValueError(f"{path}: {kind} takes no names or what is beside them")
        return _of_words(place)
    elif kind not in READERS:
        known = ", ".join((*READERS, *IN_WORDS))
        raise ValueError(
            f"{path}: give a file of the kind {known}, or a folder with a file "
            f"for each matrix (M.csv, M.mtx, M.npy, M.npz, ...){HINTS.get(kind, '')}"
        )
    else:
        there = READERS[kind](place, wanted)
    matrices = {n: there[own] for n, own in chosen.items()}
    with named(path):
        if {"A", "ABCD"} & matrices.keys():
            if beside and beside != Beside(condensed=True):
                raise ValueError(
                    "there is A: without, push and rayleigh are for M, D, S"
                )
            for name in itertools.filterfalse(is_step, [*matrices]):
                matrices[name] = matrix_of(name, matrices[name])
            plant = plant_of_state_space(
                path, matrices, asked="A" in names, condensed=beside.condensed
            )
            odd = ""
        else:
            plant = structure_of(matrices, chosen, beside, left)
            odd = suspicion({name: getattr(plant, name) for name in "MDSBF"})
    (first, *_) = plant.vertices
    idle = idle_inputs(getattr(first, "B", getattr(first, "Bu", None)))
    unread = f"left out: {listed_names(left)}" if left else ""
    if {"G", "g"} & {x.rpartition(".")[2] for x in left}:
        unread += "; if G is gyroscopic, add it to D"
    return plant, None, "; ".join(filter(None, (odd, idle, unread)))


def _of_words(place):
    """As `_read`, of JSON or TOML."""
    data = read_data(place)
    with named(place):
        if not isinstance(data, dict) or data.keys() & {*NAMES, "vertices"}:
            return _judged(data, None)
        if "plant" not in data:
            raise ValueError(
                '"plant" is missing: give {"M": .., "D": .., "S": .., "B": ..}, '
                '{"vertices": [..]}, or the name of a file'
            )
        plant = data.pop("plant")
        if isinstance(plant, str):
            plant = {"file": plant}
        with named("plant"):
            other = isinstance(plant, dict) and "file" in plant
            if not other:
                return _judged(plant, data)
            plant, odd = _of_file(place, **plant)
            return plant, data, odd


def _judged(data, asked):
    """The plant of plain data, what is asked, and what may be wrong with it."""
    plant = plant_of(data)
    if isinstance(plant, Uncertain):
        middle = plant.at(
            **{k: (x + y) / 2 for k, (x, y) in data["parameters"].items()}
        )
        own = not plant.rows  # else they are no longer the file's
        return plant, asked, half_fault(vars(middle)) if own else ""
    odd = (suspicion({x: getattr(v, x) for x in "MDSBF"}) for v in plant.vertices)
    return plant, asked, next(filter(None, odd), "")


def _of_file(place, /, file, names=None, **beside):
    """The plant of a ``file`` that is named by the one at a ``place``, and what may be
    wrong with it.
    """
    known = [x.name for x in fields(Beside)]
    if unknown := [x for x in beside if x not in known]:
        raise ValueError(
            f"{unknown[0]!r:.80} isn't known: beside file there may be names, "
            f"{', '.join(known)}"
        )
    own = isinstance(names, dict) and all(isinstance(x, str) for x in names.values())
    if not (names is None or own):
        raise ValueError('names must be like {"S": "Kaa"}')
    other = place.parent / path_of(file)
    if other.suffix.lower() not in IN_WORDS:
        return _read(other, names or {}, Beside(**beside))[::2]
    with named(other):  # one that asks for something would not be heard
        return _judged(read_data(other), None)[::2]


def _folder(path):
    """The files of matrices in a folder, by name."""
    there = {}
    for file in sorted(path.iterdir()):
        if file.suffix.lower() in ENDS:
            name = CALCULIX.get(file.suffix.lower(), file.stem)
        elif (
            file.suffix[1:] in LETTERS_OF_FILES
            and file.is_file()
            and read_bytes(file).startswith(MARKET)
        ):
            name = file.suffix[1:]  # gyro.M beside gyro.K
        else:
            continue
        there.setdefault(name, []).append(file)
    return there


def _matrix(path, own, files):
    """The matrix of a file, or its `Entries`."""
    if len(files) > 1:
        twice = ", ".join(file.name for file in files)
        raise ValueError(f"{path}: {own} is there twice: {twice}")
    (file,) = files
    kind = file.suffix.lower()
    if kind in CALCULIX:
        dofs = file.with_suffix(".dof")
        if not dofs.exists():
            raise FileNotFoundError(f"{dofs} is missing: it names the rows of {file}")
        return read_entries(file, read_dofs(dofs))
    if kind == ".mtx":
        entries = read_entries(file)
        return read_mtx(file) if entries is None else entries
    readers = {".npy": read_npy, ".npz": read_sparse, ".csv": read_csv}
    readers |= {".txt": read_csv} | dict.fromkeys(HARWELL, read_harwell)
    return readers.get(kind, read_mtx)(file)
