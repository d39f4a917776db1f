"""Plants from files of other programs, and of JSON."""

from collections.abc import Mapping, Sequence
from os import PathLike

import numpy as np
from scipy.sparse import coo_array, csc_array, issparse

from ..runtime.matrix_files import (
    COORDINATES,
    check_size,
    read_csv,
    read_entries,
    read_mat,
    read_mtx,
    read_npy,
    read_npz,
    read_op4,
    read_sparse,
)
from ..runtime.reading import named, path_of, read_data
from ..runtime.saying import warn_outside
from .as_data import ALIASES, NAMES, OPTIONAL, plant_of
from .checks import matrix
from .condensing import condense
from .descriptor_system import DescriptorSystem
from .massless import empty_rows, listed
from .second_order import Polytope, SecondOrderSystem
from .sparse import MOST_DENSE
from .state_space import BLOCK, LETTERS, STEPS, plant_of_state_space
from .suspicions import half_fault, suspicion
from .uncertain import Uncertain

FROM_ELSEWHERE = {  # what a program of finite elements hasn't
    "B": "add B, a column for each actuator with ones in the rows that it pushes",
    "D": "add D, zeros or a M + b S (Rayleigh)",
}
ENDS = ".csv", ".mtx", ".npy", ".npz"
IN_WORDS = ".json", ".toml"
HINTS = {  # by endings of files that hold plants, and aren't read
    ".pch": "; a punch file of Nastran isn't read: write OUTPUT4 (.op4)",
    ".sti": COORDINATES,
}
PENALTY = 1e30  # on a diagonal: supports of Abaqus have 1e36, no structure has so much


def load_plant(
    path: str | PathLike,
    names: Mapping[str, str] | None = None,
    *,
    without: Sequence[int] = (),
    condensed: bool = False,
) -> SecondOrderSystem | Polytope | Uncertain | DescriptorSystem:
    """Read a plant from a file, or from a folder with a file a matrix.

    Parameters
    ----------
    path : str or path
        A folder with ``M.csv``, ``D.csv``, ``S.csv``, ``B.csv`` and perhaps
        ``F.csv`` (numbers with a point, between commas, semicolons or spaces,
        one of these in a line; ``#`` begins a comment), or ``M.mtx`` and so on
        (Matrix Market, or Abaqus's lines "node, dof, node, dof, value"), ``M.npy``,
        or ``M.npz`` (scipy.sparse.save_npz). Or one file that holds them all under
        these names: ``.npz``, ``.mat``, ``.h5`` (that and MATLAB 7.3 by h5py),
        ``.op4`` (Nastran's OUTPUT4, ASCII or binary), ``.json`` or ``.toml``. Where S
        or D isn't there, ``K`` of the size of M is the stiffness and ``C`` the damping.
        Without M, but with ``A``, or with ``ABCD`` and ``nx`` (Modelica), they are a
        state space E x' = A x + B u + B_w w, y = C x + D u, where only A is needed; one
        of discrete time (``dt``, ``Ts`` or ``T``) is refused. Small letters serve where
        there are no large ones. JSON and TOML have M, D, S, B and F
        alone, or a list of such plants under ``"vertices"``, or ranges under
        ``"parameters"``; they may be the file of ``python -m sosbook design``, whose
        ``"plant"`` may be the name of another file, beside it.
    names : dict, optional
        From a matrix to what it is called there: ``{"S": "Kaa"}``.
    without : sequence of int, optional
        Displacements that are held at zero, from 0: their rows and columns are left
        out. For supports that a program writes as penalties.
    condensed : bool, optional
        Whether `condense` solves for the displacements without mass and damping.

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
    plant, _, odd = _read(path, names or {}, without, condensed)
    return _said(path, plant, odd)


def plant_and_asked(path):
    """The plant of a file or folder at ``path``, and what the file asks, a dict or
    None.

    Only JSON or TOML asks: its key "plant" has matrices, the name of a file that
    `load_plant` takes, or ``{"file": "a.mat", "without": [1]}``, with ``names``,
    ``without`` or ``condensed``; its other keys are what is asked.
    """
    plant, asked, odd = _read(path, {})
    return _said(path, plant, odd), asked


def _said(path, plant, odd):
    """The plant; a warning of what the file at a path says that may be wrong."""
    if odd:
        warn_outside(f"{path}: {odd}")
    return plant


def _read(path, names, without=(), condensed=False):
    """The plant, what is asked or None, and what isn't used or may be wrong."""
    place = path_of(path)
    kind = place.suffix.lower()
    arrays = {".npz": read_npz, ".mat": read_mat, ".h5": read_mat, ".op4": read_op4}
    chosen, left = {}, []

    def wanted(there):
        chosen.update(_chosen(place, there, names))
        left.extend(x for x in there if x not in chosen.values())
        return [*chosen.values()]

    if place.is_dir():
        files = _folder(place)
        there = {own: _matrix(place, files[own]) for own in wanted(files)}
    elif not place.exists():
        raise FileNotFoundError(f"{path}: there is no such file or folder")
    elif kind in IN_WORDS:
        if names or len(without) or condensed:
            raise ValueError(f"{path}: {kind} takes no names, without or condensed")
        return _of_words(place)
    elif kind not in arrays:
        known = ", ".join((*arrays, *IN_WORDS))
        raise ValueError(
            f"{path}: give a file of the kind {known}, or a folder with a file "
            f"for each matrix (M.csv, M.mtx, M.npy, M.npz, ...){HINTS.get(kind, '')}"
        )
    else:
        there = arrays[kind](place, wanted)
    matrices = {n: there[own] for n, own in chosen.items()}
    with named(path):
        if {"A", "ABCD"} & matrices.keys():
            if len(without) or condensed:
                raise ValueError("there is A: without and condensed are for M, D, S")
            for name in matrices.keys() - {*STEPS}:
                matrices[name] = _matrix_of(name, matrices[name])
            plant = plant_of_state_space(path, matrices, asked="A" in names)
            odd = ""
        else:
            plant = _of_structure(matrices, chosen, without, condensed)
            odd = suspicion({name: getattr(plant, name) for name in "MDSBF"})
    unread = f"left out: {_listed(left)}" if left else ""
    return plant, None, "; ".join(filter(None, (odd, unread)))


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


def _of_file(place, /, file, names=None, without=(), condensed=False, **unknown):
    """The plant of a ``file`` that is named by the one at a ``place``, and what may be
    wrong with it.
    """
    if unknown:
        raise ValueError(
            f"{next(iter(unknown))!r:.80} isn't known: beside file there may be "
            "names, without, condensed"
        )
    own = isinstance(names, dict) and all(isinstance(x, str) for x in names.values())
    if not (names is None or own) or not isinstance(condensed, bool):
        raise ValueError('names must be like {"S": "Kaa"}, and condensed true or false')
    if not isinstance(without, (list, tuple)):
        raise ValueError("without must be a list of rows, from 0")
    other = place.parent / path_of(file)
    if other.suffix.lower() not in IN_WORDS:
        return _read(other, names or {}, without, condensed)[::2]
    with named(other):  # one that asks for something would not be heard
        return _judged(read_data(other), None)[::2]


def _chosen(place, there, names):
    """From each matrix to what it is called among the names that are there."""
    for name, own in names.items():
        if name not in (*NAMES, *LETTERS):
            raise ValueError(f"names: {name!r:.40} is none of M, D, S, B, F, {LETTERS}")
        if own not in there:
            raise ValueError(f"{place}: {own} isn't there, but {_listed(there)}")
    letters = _letters(there)
    own = {n: x for n, x in letters.items() if n in (*NAMES, *LETTERS)}
    chosen = {n: x for n, x in own.items() if x not in names.values()} | dict(names)
    if "A" not in chosen and "M" not in chosen and {*BLOCK} <= {*there}:
        return {n: n for n in (*BLOCK, *STEPS) if n in there}
    if "A" in chosen and "M" not in chosen:
        steps = {n: n for n in STEPS if n in there}
        return {n: own for n, own in chosen.items() if n in LETTERS} | steps
    chosen = {n: own for n, own in chosen.items() if n in NAMES}
    if "S" not in chosen and {"C", "D", "K"} <= letters.keys() and "D" not in names:
        raise ValueError(
            f"{place}: beside K, is C or D the damping? Pass names={{'D': 'C'}} or "
            "names={'D': 'D'}"
        )
    for name, alias in ALIASES.items():
        if name not in chosen and alias in letters:
            chosen[name] = letters[alias]
    _refuse_small_letters(place, there, chosen)
    if missing := [n for n in NAMES if n not in chosen and n not in OPTIONAL]:
        cure = _cure_of(missing, there)
        if place.is_dir():
            *some, last = (f"{missing[0]}{end}" for end in ENDS)
            raise FileNotFoundError(
                f"{place}: {', '.join(some)} or {last} is missing; {cure}"
            )
        raise ValueError(f"{place}: {', '.join(missing)} is missing; {cure}")
    return chosen


def _letters(there):
    """The names of the matrices: capital letters, or all of them small ones."""
    known = *NAMES, *LETTERS, *ALIASES.values()
    large = {n: n for n in known if n in there}
    return large or {n: n.lower() for n in known if n.lower() in there}


def _cure_of(missing, there):
    """The cure for missing matrices, where others are there."""
    pass_on = ", ".join(f"{n!r}: '...'" for n in missing)
    strange = [(n, what) for n, what in there.items() if what and isinstance(what, str)]
    for name, what in strange:
        if what == "a struct":
            return (
                f"{name} is a struct: save('plant.mat', '-struct', '{name}') writes it"
            )
        return f"{name} is {what}, which only MATLAB opens: save its matrices by names"
    spare = there.keys() - {*_letters(there).values()}
    cure = f"{_listed(there)} is there"
    if len(spare) >= len(missing):
        cure += f": pass names={{{pass_on}}} for other names"
    if len(missing) < len(NAMES) - len(OPTIONAL):
        cure += "".join(
            f"; {words}" for n, words in FROM_ELSEWHERE.items() if n in missing
        )
    return cure


def _listed(there):
    """Some names in words."""
    return f"{', '.join(there) or 'nothing':.200}"


def _of_structure(matrices, chosen, without, condensed):
    """The plant of M, D, S, B and perhaps F, some of which may be Abaqus's."""
    dofs = _assemble(matrices)
    matrices = {
        name: _matrix_of(name, x, name in "MDS") for name, x in matrices.items()
    }
    n = matrices["M"].shape[0]
    for name, alias in ALIASES.items():
        if chosen[name] in (alias, alias.lower()) and matrices[name].shape != (n, n):
            size = " x ".join(map(str, matrices[name].shape))
            raise ValueError(
                f"{alias} is {size} and M has {n} rows, so it isn't taken for "
                f"{name}, which is missing: call that {name}, or pass names="
            )
    if len(without):
        cut = np.asarray(without)
        if cut.dtype.kind not in "iu" or cut.min() < 0 or cut.max() >= n:
            raise ValueError(f"without must be rows from 0 to {n - 1}, got {without}")
        keep = np.setdiff1d(np.arange(n), cut)
        for name, x in matrices.items():
            if x.shape[0] == n:  # a wrong size is an error of its own
                matrices[name] = x[keep][:, keep] if name in "MDS" else x[keep]
        dofs = dofs and [dofs[k] for k in keep]
    for name in "MDS":
        if len(held := np.flatnonzero(abs(matrices[name].diagonal()) >= PENALTY)):
            where = f" ({', '.join(dofs[k] for k in held)})" if dofs else ""
            raise ValueError(
                f"{name} has {matrices[name][held[0], held[0]]:g} on its diagonal: "
                f"penalties instead of supports. Pass without={held.tolist()}{where}"
            )
    fit = all(x.shape[0] == n for x in matrices.values())
    if fit and (empty := empty_rows(matrices)):
        where = f" ({listed([dofs[k] for k in empty])})" if dofs else ""
        some = ", ".join(matrices)
        raise ValueError(f"rows are empty in {some}: pass without={empty}{where}")
    if condensed:
        return condense(**matrices, coordinates=dofs)
    try:
        return SecondOrderSystem(**matrices, coordinates=dofs)
    except ValueError as error:
        cure = "; or pass condensed=True" if "plants.condense" in str(error) else ""
        raise ValueError(f"{error}{cure}") from None


def _matrix_of(name, x, large=False):
    """A matrix of a file; one that may be ``large`` stays sparse then."""
    if issparse(x):
        if large and max(x.shape) > MOST_DENSE:
            return csc_array(x)
        check_size(*x.shape)
    return matrix(name, x)


def _assemble(matrices):
    """Make Abaqus's entries matrices, of all nodes' dofs; their names, or None."""
    tables = {name: x for name, x in matrices.items() if isinstance(x, dict)}
    dofs = sorted({dof for x in tables.values() for pair in x for dof in pair})
    order = {dof: k for k, dof in enumerate(dofs)}
    for name, entries in tables.items():
        rows = [order[row] for row, _ in entries]
        columns = [order[column] for _, column in entries]
        places = np.array([rows, columns], int)
        values = np.array([*entries.values()], float)
        matrices[name] = coo_array((values, places), shape=(len(dofs),) * 2)
    return [f"{node}.{dof}" for node, dof in dofs] or None


def _refuse_small_letters(where, names, chosen):
    """An f isn't dropped as if no F were meant."""
    for name in OPTIONAL:
        if name not in chosen and name.lower() in names:
            raise ValueError(f"{where}: {name.lower()} isn't read: call it {name}")


def _folder(path):
    """The files of matrices in a folder, by name."""
    there = {}
    for file in sorted(path.iterdir()):
        if file.suffix in ENDS:
            there.setdefault(file.stem, []).append(file)
    return there


def _matrix(path, files):
    """The matrix of a file; or entries of Abaqus, a dict."""
    if len(files) > 1:
        twice = ", ".join(file.name for file in files)
        raise ValueError(f"{path}: {files[0].stem} is there twice: {twice}")
    (file,) = files
    if file.suffix == ".mtx":
        entries = read_entries(file)
        return read_mtx(file) if entries is None else entries
    return {".csv": read_csv, ".npy": read_npy, ".npz": read_sparse}[file.suffix](file)
