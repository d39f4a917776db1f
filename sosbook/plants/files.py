"""Plants from files of other programs, and of JSON."""

import warnings
from collections.abc import Mapping, Sequence
from os import PathLike

import numpy as np
from scipy.sparse import coo_array, csc_array, issparse

from ..runtime.matrix_files import (
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
from .as_data import ALIASES, NAMES, OPTIONAL, plant_of
from .checks import matrix
from .condensing import condense
from .descriptor_system import DescriptorSystem
from .second_order import Polytope, SecondOrderSystem
from .sparse import MOST_DENSE
from .uncertain import Uncertain

STATE = "E", "A", "B", "B_w", "C", "D"  # of a state space
ENDS = ".csv", ".mtx", ".npy", ".npz"
IN_WORDS = ".json", ".toml"
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
        Without M, but with ``A``, they are a state space E x' = A x + B u + B_w w,
        y = C x + D u, where only A is needed. JSON and TOML have M, D, S, B and F
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
        If a state space is of second order and its C is left out.

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
    arrays = {".npz": read_npz, ".mat": read_mat, ".h5": read_mat, ".op4": read_op4}
    if place.is_dir():
        there = _folder(place)
        chosen = _chosen(place, there, names or {})
        matrices = {n: _matrix(place, there[own]) for n, own in chosen.items()}
    elif not place.exists():
        raise FileNotFoundError(f"{path}: there is no such file or folder")
    elif kind in IN_WORDS:
        if names or len(without) or condensed:
            raise ValueError(f"{path}: {kind} takes no names, without or condensed")
        return plant_and_asked(place)[0]
    elif kind not in arrays:
        known = ", ".join((*arrays, *IN_WORDS))
        raise ValueError(
            f"{path}: give a file of the kind {known}, or a folder with a file "
            "for each matrix (M.csv, M.mtx, M.npy, M.npz, ...)"
        )
    else:
        there = arrays[kind](place, lambda t: _chosen(place, t, names or {}).values())
        chosen = _chosen(place, there, names or {})
        matrices = {n: there[own] for n, own in chosen.items()}
    with named(path):
        if "A" in matrices:
            if len(without) or condensed:
                raise ValueError("there is A: without and condensed are for M, D, S")
            return _of_state_space(path, matrices, asked="A" in (names or {}))
        return _of_structure(matrices, chosen, without, condensed)


def plant_and_asked(path):
    """The plant of a file or folder at ``path``, and what the file asks, a dict or
    None.

    Only JSON or TOML asks: its key "plant" has matrices, the name of a file that
    `load_plant` takes, or ``{"file": "a.mat", "without": [1]}``, with ``names``,
    ``without`` or ``condensed``; its other keys are what is asked.
    """
    place = path_of(path)
    if place.is_dir() or place.suffix.lower() not in IN_WORDS:
        return load_plant(path), None
    data = read_data(place)
    with named(path):
        if not isinstance(data, dict) or data.keys() & {*NAMES, "vertices"}:
            return plant_of(data), None
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
            return _of_file(place, **plant) if other else plant_of(plant), data


def _of_file(place, /, file, names=None, without=(), condensed=False, **unknown):
    """The plant of a ``file`` that is named by the one at a ``place``."""
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
        return load_plant(other, names, without=without, condensed=condensed)
    with named(other):  # one that asks for something would not be heard
        return plant_of(read_data(other))


def _chosen(place, there, names):
    """From each matrix to what it is called among the names that are there."""
    for name, own in names.items():
        if name not in (*NAMES, *STATE):
            raise ValueError(f"names: {name!r:.40} is none of M, D, S, B, F, {STATE}")
        if own not in there:
            raise ValueError(f"{place}: {own} isn't there, but {_listed(there)}")
    own = {n: n for n in (*NAMES, *STATE) if n in there and n not in names.values()}
    chosen = own | dict(names)
    if "A" in chosen and "M" not in chosen:
        return {n: own for n, own in chosen.items() if n in STATE}
    chosen = {n: own for n, own in chosen.items() if n in NAMES}
    if "S" not in chosen and {"C", "D", "K"} <= {*there} and "D" not in names:
        raise ValueError(
            f"{place}: beside K, is C or D the damping? Pass names={{'D': 'C'}} or "
            "names={'D': 'D'}"
        )
    for name, alias in ALIASES.items():
        if name not in chosen and alias in there:
            chosen[name] = alias
    _refuse_small_letters(place, there)
    if missing := [n for n in NAMES if n not in chosen and n not in OPTIONAL]:
        pass_on = ", ".join(f"{n!r}: '...'" for n in missing)
        cure = f"{_listed(there)} is there: pass names={{{pass_on}}} for other names"
        if place.is_dir():
            *some, last = (f"{missing[0]}{end}" for end in ENDS)
            raise FileNotFoundError(
                f"{place}: {', '.join(some)} or {last} is missing; {cure}"
            )
        raise ValueError(f"{place}: {', '.join(missing)} is missing; {cure}")
    return chosen


def _listed(there):
    """Some names in words."""
    return f"{', '.join(there) or 'nothing':.200}"


def _of_structure(matrices, chosen, without, condensed):
    """The plant of M, D, S, B and perhaps F, some of which may be Abaqus's."""
    dofs = _assemble(matrices)
    matrices = {name: _read(name, x, name in "MDS") for name, x in matrices.items()}
    n = matrices["M"].shape[0]
    for name, alias in ALIASES.items():
        if chosen[name] == alias and matrices[name].shape != (n, n):
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
    if condensed:
        return condense(**matrices, coordinates=dofs)
    try:
        return SecondOrderSystem(**matrices, coordinates=dofs)
    except ValueError as error:
        cure = "; or pass condensed=True" if "plants.condense" in str(error) else ""
        raise ValueError(f"{error}{cure}") from None


def _read(name, x, large=False):
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


def _of_state_space(path, matrices, asked):
    """The plant of A and others; of second order where it can be."""
    read = {name: _read(name, x) for name, x in matrices.items()}
    A, D_u = read["A"], read.get("D")
    E, B, B_w, C = (read.get(name) for name in ("E", "B", "B_w", "C"))
    if D_u is not None and not D_u.any():
        D_u = None
    E = np.eye(len(A)) if E is None else E
    system = DescriptorSystem(E, A, B, B_w, C, D_u)
    alike = len({np.shape(x) for x in (A, B, C)}) == 1 and len(A) > 1
    if alike and not asked and (system.C != np.eye(len(A))).any():
        raise ValueError(
            f"A, B and C are all {len(A)} x {len(A)}: for A z'' + B z' + C z pass "
            "names={'M': 'A', 'D': 'B', 'S': 'C'}, for a state space names={'A': 'A'}"
        )
    plant = _second_order(*system.vertices)
    if plant is None:
        return system
    if C is not None:
        warnings.warn(
            f"{path} is of second order, and its C is left out: outputs are z; "
            "design_observer takes another as C=",
            stacklevel=3,
        )
    return plant


def _second_order(d):
    """The plant with x = [z; z'] in any order, or None."""
    N, half = len(d.A), len(d.A) // 2
    inputs = np.hstack([d.Bu, d.Bw])
    if d.Du is not None or not d.Bu.size or (d.E != np.eye(N)).any():
        return None
    target = {  # rows x_i' = x_j
        i: int(row.argmax())
        for i, row in enumerate(d.A)
        if not inputs[i].any() and np.count_nonzero(row) == 1 and row.max() == 1
    }
    other = [i for i, j in target.items() if j not in target]
    for z in list(range(half)), list(range(0, N, 2)), other:
        v = [target.get(i, -1) for i in z]
        if sorted(z + v) == list(range(N)):
            D, S = (0.0 - d.A[np.ix_(v, x)] for x in (v, z))
            F = d.Bw[v] if d.Bw.size else None
            return SecondOrderSystem(np.eye(half), D, S, d.Bu[v], F)
    return None


def _refuse_small_letters(where, names):
    """An f isn't dropped as if no F were meant."""
    for name in OPTIONAL:
        if name not in names and name.lower() in names:
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
