"""A structure of a program of finite elements, and what no such program says of it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array, csc_array, issparse

from ..runtime.matrix_files import check_size
from ..runtime.tables import TABLE, Entries
from .as_data import ALIASES
from .checks import matrix
from .condensing import condense
from .massless import empty_rows, listed
from .matrix_names import cure_by_name, listed_names
from .second_order import SecondOrderSystem
from .sparse import MOST_DENSE

PENALTY = 1e30  # on a diagonal: supports of Abaqus have 1e36, no structure has so much


@dataclass(frozen=True)
class Beside:
    """Arguments of `load_plant` beside a file: ``without``, ``condensed``, ``push`` and
    ``rayleigh``, as there.
    """

    without: Sequence[int] = ()
    condensed: bool = False
    push: Sequence[str | int] = ()
    rayleigh: Sequence[float] | None = None

    def __post_init__(self):
        if not isinstance(self.condensed, bool):
            raise ValueError("condensed must be true or false")
        for name in ("without", "push"):
            if isinstance(getattr(self, name), (str, int, dict)):
                raise ValueError(f"{name} must be a list of rows, from 0")
        if self.rayleigh is not None:
            a, b = matrix("rayleigh", [self.rayleigh], (1, 2))[0]
            if min(a, b) < 0:
                raise ValueError("rayleigh must be (a, b), not below 0")

    @property
    def made(self):
        """From a matrix that these make to the argument that does."""
        made = {"B": "push"} if len(self.push) else {}
        return made | ({} if self.rayleigh is None else {"D": "rayleigh"})

    def __bool__(self):
        return bool(len(self.without) or self.condensed or self.made)


def structure_of(matrices, chosen, beside, spare):
    """The plant of ``matrices`` M, D, S, B and perhaps F, some may be `Entries`,
    ``chosen`` by name, and of what is said ``beside`` them; others are ``spare``, a
    list that gets a C which is no damping.
    """
    dofs = _assemble(matrices)
    if missing := [x for x in "DB" if x not in (*matrices, *beside.made)]:
        raise ValueError(
            f"{', '.join(missing)} is missing{cure_by_name(missing, spare)}"
            + "".join(_cure(x, matrices["M"].shape[0], dofs) for x in missing)
        )
    matrices = {name: matrix_of(name, x, name in "MDS") for name, x in matrices.items()}
    n, without = matrices["M"].shape[0], beside.without
    _check_turned(matrices, n)
    if beside.rayleigh is not None:
        if "D" in matrices and matrices["D"].shape == (n, n):
            raise ValueError(f"{chosen['D']} is there: leave rayleigh out")
        spare += [chosen["D"]] if "D" in matrices else []
        a, b = beside.rayleigh
        matrices["D"] = a * matrices["M"] + b * matrices["S"]
    if len(beside.push):
        matrices["B"] = _pushed(beside.push, n, dofs)
    for name, alias in ALIASES.items():
        own = chosen.get(name, "").rpartition(".")[2]
        if name == "D" and beside.rayleigh is not None:
            continue
        if own in (alias, alias.lower()) and matrices[name].shape != (n, n):
            size = " x ".join(map(str, matrices[name].shape))
            raise ValueError(
                f"{alias} is {size} and M has {n} rows, so it isn't taken for "
                f"{name}, which is missing"
                + (cure_by_name([name], spare) or f": call that {name}, or pass names=")
                + ", or rayleigh=(a, b), (0, 0) for no damping" * (name == "D")
                + "; a table of entries begins with the line row,column,value"
                * (matrices[name].shape[1] == len(TABLE))
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
    if beside.condensed:
        return condense(**matrices, coordinates=dofs)
    try:
        return SecondOrderSystem(**matrices, coordinates=dofs)
    except ValueError as error:
        cure = "; or pass condensed=True" if "plants.condense" in str(error) else ""
        raise ValueError(f"{error}{cure}") from None


def _check_turned(matrices, n):
    """Raise where M is a row or column of masses, or B or F has its rows as columns."""
    rows, columns = matrices["M"].shape
    if 1 in (rows, columns) and rows != columns:
        raise ValueError(
            f"M is {rows} x {columns}: of masses on the diagonal give numpy.diag(M)"
        )
    for name in {"B", "F"} & matrices.keys():
        rows, columns = matrices[name].shape
        if rows != n == columns:
            raise ValueError(f"{name} is {rows} x {columns}: transpose it")


def _cure(name, n, dofs):
    """The cure where a ``name``, B or D, is missing: no such program writes them."""
    if name == "D":
        return (
            "; add D, or pass rayleigh=(a, b) for a M + b S, rayleigh=(0, 0) for none"
        )
    first = [dofs[0]] if dofs else [0]
    which = listed_names(dofs) if dofs else f"the rows 0 to {n - 1}"
    return (
        "; add B, a column for each actuator with ones in the rows that it pushes, or "
        f"pass push={first}, one for each actuator, of {which}"
    )


def _pushed(push, n, dofs):
    """B with a column for each actuator, a one in the row that it pushes."""
    B = np.zeros((n, len(push)))
    for column, place in enumerate(push):
        row = place
        if dofs and place in dofs:
            row = dofs.index(place)
        if isinstance(row, (str, bool)) or row not in range(n):
            some = f" or of {listed_names(dofs)}" if dofs else ""
            raise ValueError(f"push: {place!r:.40} is none of 0 to {n - 1}{some}")
        B[row, column] = 1.0
    return B


def matrix_of(name, x, large=False):
    """The matrix ``x`` of this ``name``; one that may be ``large`` stays sparse."""
    kind = getattr(getattr(x, "dtype", None), "kind", "")
    if kind == "c" and not (x.data if issparse(x) else x).imag.any():
        x = x.real
    if issparse(x):
        if large and max(x.shape) > MOST_DENSE:
            return csc_array(x)
        check_size(*x.shape)
    return matrix(name, x)


def _assemble(matrices):
    """Make `Entries` matrices, of all nodes' dofs or numbered rows; names of dofs, or
    None.
    """
    tables = {name: x for name, x in matrices.items() if isinstance(x, Entries)}
    if not tables:
        return None
    numbered = {x.numbered for x in tables.values() if x}
    if len(numbered) > 1:
        raise ValueError(
            f"of {', '.join(tables)} some have nodes, some numbers of rows"
        )
    square = [x for name, x in tables.items() if name in "MDS"]
    dofs = {row for x in tables.values() for row, _ in x}
    dofs = sorted(dofs.union(column for x in square for _, column in x))
    numbered = True in numbered
    if numbered:
        sizes = [x.shape[0] for x in matrices.values() if not isinstance(x, Entries)]
        dofs = [(k + 1, 0) for k in range(max([dofs[-1][0], *sizes]))]
    order = {dof: k for k, dof in enumerate(dofs)}
    for name, entries in tables.items():
        across = order
        if name not in "MDS":
            columns = sorted({column for _, column in entries})
            across = {column: k for k, column in enumerate(columns)}
        elif entries.half and not any((j, i) in entries for i, j in entries if i != j):
            entries |= {(j, i): value for (i, j), value in entries.items()}
        places = [[order[i] for i, _ in entries], [across[j] for _, j in entries]]
        values = np.array([*entries.values()], float)
        shape = len(order), len(across)
        matrices[name] = coo_array((values, np.array(places, int)), shape=shape)
    return None if numbered else [f"{node}.{dof}" for node, dof in dofs]
