"""The text of an LMI and its readings: unknowns, floats, rationals, cvxpy."""

from functools import cached_property

import numpy as np
from flint import fmpq, fmpz

from ..exact.definite import exact
from ..language.expression import Affine, Unknown
from ..runtime.names import sane_name
from ..solver.blocks import Blocks
from ..solver.loop import margin


def floats(x):
    """Data x for blocks, in floats."""
    return np.asarray(x, float) if isinstance(x, (list, tuple)) else x


def rationals(x):
    """Data x for blocks, in rationals; floats are read as decimals."""
    return exact(np.asarray(x, float) if isinstance(x, (list, tuple)) else x)


class LMIText:
    """Blocks, affine in some unknowns, written once.

    ``write``: see `LMIProblem`. None where a class has it as a method; ``unknowns``:
    what the blocks are affine in; ``settings``: as for `LMIProblem`.
    """

    trusted = False  # to be affine, symmetric and finite, without a look

    def __init__(self, write, unknowns, settings=None):
        """Check the unknowns and their names."""
        self.settings = settings
        if write is not None:
            self.write = write
        self.unknowns = list(unknowns)
        if not callable(getattr(self, "write", None)):
            raise ValueError("write must be a function of (values, number)")
        if not self.unknowns:
            raise ValueError("unknowns is empty: there is nothing to find")
        for u in self.unknowns:
            if not isinstance(u, Unknown):
                raise ValueError(f"unknowns must hold Unknown, got {u!r}")
            sane_name(u.name)
        names = [u.name for u in self.unknowns]
        if len(set(names)) < len(names):
            raise ValueError(f"two unknowns have one name: {names}")

    def blocks(self, values, number=floats):
        """The blocks by name, for values of the unknowns by name.

        Parameters
        ----------
        values : dict
            A matrix-like for each unknown's name.
        number : callable
            Brings data into the values' arithmetic.

        Returns
        -------
        dict
            A square matrix-like for each block's name.

        Raises
        ------
        ValueError
            If a value is missing, or ``write`` returns no square blocks.
        """
        missing = [u.name for u in self.unknowns if u.name not in values]
        if missing:
            raise ValueError(f"values has no {', '.join(missing)}")
        try:
            written = self.write(values, number)
        except TypeError as error:
            if number is not rationals:
                raise
            raise ValueError(f"{_MIXED} ({error})") from None
        if not isinstance(written, dict) or not written:
            raise ValueError("write must return a dict from names to blocks")
        for name, g in written.items():
            sane_name(name)
            shape = getattr(g, "shape", None)
            if shape is None or len(shape) != 2 or shape[0] != shape[1]:
                raise ValueError(f"block {name!r} must be a square matrix, got {shape}")
            if number is rationals and not _is_rational(g):
                raise ValueError(f"block {name!r}: {_MIXED}")
        return written

    def in_unknowns(self, number=floats):
        """The blocks by name, as `Affine` expressions in the unknowns.

        ``number`` brings other data into an arithmetic.
        """
        written = self.blocks({u.name: u for u in self.unknowns}, number)
        return {
            n: g if isinstance(g, Affine) else Affine(g) for n, g in written.items()
        }

    @cached_property
    def expressions(self):
        """The blocks by name, as `Affine` expressions in floats."""
        return self.in_unknowns()

    @property
    def names(self):
        """Of the blocks, in their order."""
        return list(self.expressions)

    @cached_property
    def compiled(self):
        """The `Blocks` that the solver takes.

        Raises
        ------
        ValueError
            If a block isn't symmetric, real and finite.
        """
        if not self.trusted:
            self._check()
        blocks = Blocks(self.expressions.values(), self.unknowns)
        if self.settings is not None:
            blocks.settings = self.settings
        return blocks

    def _check(self):
        probe = {
            u.name: u.unpack(np.cos(1.0 + k + np.arange(u.size)))
            for k, u in enumerate(self.unknowns)
        }
        for name, g in self.blocks(probe).items():
            if np.asarray(g).dtype.kind not in "fiu":
                raise ValueError(f"block {name!r} must hold real numbers")
            if not np.isfinite(g).all():
                raise ValueError(f"block {name!r} has NaN or infinite entries")
            if np.abs(g - g.T).max() > 1e-9 * np.abs(g).max():
                raise ValueError(f"block {name!r} isn't symmetric: is a .T missing?")

    def margins(self, values):
        """The smallest eigenvalue of each block, its diagonal scaled to one.

        ``values`` are those of the unknowns, by name.
        """
        return {name: margin(g) for name, g in self.blocks(values).items()}

    def packed(self, values):
        """The free entries of the unknowns' values, one after the other."""
        parts = []
        for u in self.unknowns:
            if u.name not in values or np.shape(values[u.name]) != u.shape:
                raise ValueError(f"start needs {u.name} of the shape {u.shape}")
            parts.append(u.pack(np.asarray(values[u.name], float)))
        return np.concatenate(parts)


_MIXED = "floats and rationals are mixed: pass all data but integers to number(...)"


def _is_rational(g):
    entries = np.asarray(g.constant if isinstance(g, Affine) else g).flat
    return all(isinstance(e, (fmpq, fmpz, int, np.integer)) for e in entries)
