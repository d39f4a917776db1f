"""Which gains of a law are free, and which of them are one number."""

from dataclasses import dataclass, field
from numbers import Real

import numpy as np

from ..plants.checks import is_word, matrix
from ..runtime.read_only import ReadOnly


@dataclass(frozen=True, eq=False)
class Block(ReadOnly):
    """A part of K with a ``name``, such as K_P, in some ``rows`` and ``columns``;
    ``shares``, (k, rows, columns): the share of each free number in each entry;
    ``first``: the entries that are fixed, zero elsewhere; ``ranges``, (k, 2): the least
    and the largest of each free number, whatever the limits are.
    """

    name: str
    rows: slice
    columns: slice
    shares: np.ndarray
    first: np.ndarray
    ranges: np.ndarray


@dataclass(frozen=True, eq=False)
class Structure(ReadOnly):
    """K = K_0 + sum of kappa_k K_k, with free numbers kappa.

    Parameters
    ----------
    shape : tuple of int
        Of K.
    blocks : tuple of Block
        Its named parts.
    limits : dict
        The largest size of an entry, by the name of the block.
    """

    shape: tuple
    blocks: tuple
    limits: dict = field(default_factory=dict)

    def __post_init__(self):
        if not sum(len(b.shares) for b in self.blocks):
            raise ValueError("structure leaves no gain free: there is nothing to find")
        super().__post_init__()

    @property
    def directions(self):
        """The K_k, (k, rows, columns)."""
        whole = []
        for b in self.blocks:
            for share in b.shares:
                K = np.zeros(self.shape)
                K[b.rows, b.columns] = share
                whole.append(K)
        return np.array(whole)

    @property
    def first(self):
        """K_0, the entries that are fixed."""
        K = np.zeros(self.shape)
        for b in self.blocks:
            K[b.rows, b.columns] = b.first
        return K

    @property
    def ends(self):
        """The least and the largest of each free number, (2, k); infinite without."""
        found = []
        for b in self.blocks:
            most = self.limits.get(b.name, np.inf)
            sizes = [most / np.abs(share).max() for share in b.shares]
            found += [np.clip(ends, -x, x) for ends, x in zip(b.ranges, sizes)]
        return np.array(found).T

    def within(self, largest):
        """The `ends`, with numbers of sizes ``largest``, (k,), where there are none."""
        given = np.where(np.isfinite(self.ends), self.ends, 0.0)
        largest = np.maximum(largest, 2 * np.abs(given).max(axis=0))
        return np.where(np.isfinite(self.ends), self.ends, [-largest, largest])

    def named(self, K):
        """The parts of a gain K by their names."""
        return {b.name: np.array(K[b.rows, b.columns]) for b in self.blocks}

    def matrix(self, gains):
        """K of parts by name, or of a matrix; a ValueError names what is wrong.

        ``gains`` is what `named` returns, or K itself; None stands for K_0.
        """
        if gains is None:
            return self.first
        if not isinstance(gains, dict):
            K = matrix("K", gains, self.shape)
        else:
            K, names = self.first, [b.name for b in self.blocks]
            if not set(gains) <= set(names):
                wrong = sorted(set(gains) - set(names))[0]
                raise ValueError(
                    f"K: the law has no gain {wrong!r}, only {', '.join(names)}"
                )
            for b in self.blocks:
                if b.name in gains:
                    part = K[b.rows, b.columns]
                    part[:] = matrix(b.name, gains[b.name], part.shape)
        first = self.first
        rest = np.where(K == first, 0.0, K - first)
        for b in self.blocks:
            part = rest[b.rows, b.columns]
            for share, (low, high) in zip(b.shares, b.ranges):
                at = tuple(np.argwhere(share != 0)[0])
                size = part[at] / share[at]
                if not low <= size <= high:
                    raise ValueError(
                        f"K: {b.name} has the entry {size:g}, outside of the law's "
                        f"range ({low:g}, {high:g})"
                    )
                part -= size * share
        if rest.any():
            i, j = np.argwhere(rest != 0)[0]
            raise ValueError(
                f"K: entry ({i + 1}, {j + 1}) isn't what the law's structure allows: "
                f"{K[i, j]:g} stands where the structure has a zero, a fixed number or "
                "a number shared with another entry"
            )
        return K


def _shares(name, structure, rows, columns):
    """The shares of a block of this ``name`` and rows x columns, a matrix for each free
    number; the entries that are fixed; and the ends of the free numbers, (k, 2).
    Entries of a ``structure`` are 0 for none, 1 for a number of its own, a word for one
    that others share, "-" before it for minus that, (low, high) for one in this range,
    fixed where both are one number, and open where an end is None. A ``structure`` of
    None leaves all free.
    """
    if structure is None:
        structure = np.ones((rows, columns), int).tolist()
    elif is_word(structure, ("diagonal",)):
        if rows != columns:
            raise ValueError(
                f'structure: "diagonal" needs as many sensors as inputs, but {name} '
                f"is {rows} x {columns}"
            )
        structure = np.eye(rows, dtype=int).tolist()
    entries = [list(row) for row in _nested(structure)]
    if len(entries) != rows or any(len(row) != columns for row in entries):
        raise ValueError(
            f"structure: {name} is {rows} x {columns}; give that many entries, or a "
            "dict of structures by name"
        )
    found, ends, first = {}, {}, np.zeros((rows, columns))
    for i, row in enumerate(entries):
        for j, entry in enumerate(row):
            if isinstance(entry, (tuple, list)):
                low, high = _range(name, entry)
                if low == high:
                    first[i, j] = low
                    continue
                share, key = 1.0, (i, j)
                ends[key] = low, high
            elif isinstance(entry, str) and entry.removeprefix("-")[:1] not in (
                "",
                "-",
            ):
                share = -1.0 if entry.startswith("-") else 1.0
                key = entry.removeprefix("-")
            elif not isinstance(entry, str) and entry == 1:
                share, key = 1.0, (i, j)
            elif not isinstance(entry, str) and entry == 0:
                continue
            else:
                raise ValueError(
                    f"structure: an entry of {name} is {entry!r}; take 0, 1, a word or "
                    "(low, high)"
                )
            found.setdefault(key, np.zeros((rows, columns)))[i, j] = share
    shares = np.array(list(found.values())).reshape(len(found), rows, columns)
    free = [ends.get(key, (-np.inf, np.inf)) for key in found]
    return shares, first, np.array(free).reshape(len(found), 2)


def _range(name, entry):
    """The ends of (low, high), infinite where they are None."""
    open_ends = (-np.inf, np.inf) if len(entry) == 2 else ()
    ends = [end if x is None else x for x, end in zip(entry, open_ends)]
    numbers = all(isinstance(x, Real) and not isinstance(x, bool) for x in ends)
    if ends and numbers and ends[0] <= ends[1] and ends != [ends[0] * np.inf] * 2:
        return tuple(map(float, ends))
    raise ValueError(
        f"structure: an entry of {name} is {entry!r}; a range is (low, high), with "
        "None for an open end, and low = high for a fixed number"
    )


def _nested(structure):
    if isinstance(structure, np.ndarray):
        structure = structure.tolist()
    if not isinstance(structure, (list, tuple)) or not all(
        isinstance(row, (list, tuple, np.ndarray)) for row in structure
    ):
        raise ValueError(
            'structure must be None, "diagonal", or a list of rows of 0, 1, words or '
            f"ranges, got {structure!r}"
        )
    return structure


def placed(shape, places, form, limits):
    """The `Structure` of blocks in a K of this ``shape``; ``places``: rows and columns
    of each block, from where to where, by name; ``form``: which entries are free, for
    all blocks or by name; ``limits``: the largest size of an entry, by name.
    """
    by_name = form if isinstance(form, dict) else dict.fromkeys(places, form)
    for what, given in (("structure", by_name), ("limits", limits)):
        if not set(given) <= set(places):
            wrong = sorted(set(given) - set(places))[0]
            raise ValueError(
                f"{what}: the law has no gain {wrong!r}, only {', '.join(places)}"
            )
    blocks = []
    for name, (rows, columns) in places.items():
        sizes = rows[1] - rows[0], columns[1] - columns[0]
        shares, first, ranges = _shares(name, by_name.get(name), *sizes)
        most, places = limits.get(name, np.inf), (slice(*rows), slice(*columns))
        least = np.maximum(ranges[:, 0], -ranges[:, 1])
        if max(np.abs(first).max(initial=0), least.max(initial=-np.inf)) >= most:
            raise ValueError(
                f"limits: {name} has entries up to {most:g}, but structure asks for "
                "larger ones"
            )
        blocks.append(Block(name, *places, shares, first, ranges))
    return Structure(shape, tuple(blocks), limits)
