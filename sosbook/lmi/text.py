"""The text of LMIs and its readings: unknowns, floats, rationals, cvxpy."""

from functools import cached_property

import numpy as np

from ..exact.definite import exact
from ..language.expression import Affine
from ..runtime.names import sane_name
from ..solver.blocks import Blocks
from ..solver.loop import margin
from .written import Expression, floats


def rationals(x):
    """Data x for blocks, in rationals; floats are read as decimals."""
    return exact(np.asarray(x, float) if isinstance(x, (list, tuple)) else x)


class LMIText:
    """Blocks, affine in some unknowns, written once.

    ``write(values, number)`` returns them by name, for the unknowns' values by name:
    unknowns, floats, rationals or cvxpy variables; ``number`` brings data into that
    arithmetic, which integers don't need. ``unknowns``: what the blocks are affine in.
    """

    def __init__(self, write, unknowns):
        self.write, self.unknowns = write, list(unknowns)

    def blocks(self, values, number=floats):
        """The blocks by name for ``values`` of all unknowns, data by ``number``."""
        missing = [u.name for u in self.unknowns if u.name not in values]
        if missing:
            raise ValueError(f"values has no {', '.join(missing)}")
        return self.write(values, number)

    def in_unknowns(self, number=floats):
        """The blocks by name, as `Affine` expressions in the unknowns.

        ``number`` brings other data into an arithmetic.
        """
        written = self.blocks({u.name: u for u in self.unknowns}, number)
        return {
            n: g if isinstance(g, Affine) else Affine(g) for n, g in written.items()
        }

    def value(self, expression, values):
        """An ``expression`` in the unknowns at their ``values`` by name, in floats.

        Raises ValueError if it is none, or has an unknown that the blocks don't have.
        """
        if not isinstance(expression, Affine):
            raise ValueError(
                "an expression in the unknowns has a value, as solution[P]; "
                f"got {expression!r}"
            )
        self.held(expression)
        read = expression.in_floats() if expression.decimals else expression
        return read.value({u: values[u.name] for u in self.unknowns})

    def held(self, expression):
        """Raise ValueError if an ``expression`` has an unknown that no block has."""
        for t in expression.terms:
            if t.unknown not in self.unknowns:
                raise ValueError(
                    f"no block has the unknown {t.unknown.name} of this expression; "
                    f"they have {', '.join(u.name for u in self.unknowns)}"
                )

    @cached_property
    def expressions(self):
        """The blocks by name, as `Affine` expressions in floats."""
        return self.in_unknowns()

    def compiled(self):
        """The `Blocks` that the solver takes."""
        return Blocks(self.expressions.values(), self.unknowns)

    def margins(self, values):
        """The smallest eigenvalue of each block, its diagonal scaled to one, at
        ``values`` of the unknowns, by name.
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


class WrittenText(LMIText):
    """The ``blocks`` by name that a reader wrote as expressions in the unknowns.

    Raises ValueError if they aren't a dict, have no unknown, or two unknowns of one
    name; if a block isn't square, symmetric and finite.
    """

    def __init__(self, blocks):
        """Find the unknowns in the ``blocks``, and check all of them."""
        if not isinstance(blocks, dict) or not blocks:
            raise ValueError(
                'blocks must be a dict from names to expressions, as {"P": P}; '
                f"got {blocks!r}"
            )
        self.exactly = {sane_name(name): _square(name, g) for name, g in blocks.items()}
        terms = [t for g in self.exactly.values() for t in g.terms]
        super().__init__(self._at, dict.fromkeys(t.unknown for t in terms))
        names = [sane_name(u.name) for u in self.unknowns]
        if not names:
            raise ValueError("no block has an unknown: there is nothing to find")
        if len(set(names)) < len(names):
            raise ValueError(
                f"two unknowns have one name: {names}; give each a name of its own"
            )
        self._check()

    def in_unknowns(self, number=floats):
        if number is rationals:
            return self.exactly
        return {name: g.in_floats() for name, g in self.exactly.items()}

    def _at(self, values, number):
        read = self.exactly if number is rationals else self.expressions
        known = {u: values[u.name] for u in self.unknowns}
        return {name: g.value(known) for name, g in read.items()}

    def _check(self):
        probe = {
            u.name: u.unpack(np.cos(1.0 + k + np.arange(u.size)))
            for k, u in enumerate(self.unknowns)
        }
        for name, g in self.blocks(probe).items():
            if np.abs(g - g.T).max() > 1e-9 * np.abs(g).max():
                raise ValueError(f"block {name!r} isn't symmetric: is a .T missing?")


def _square(name, g):
    """Block ``g`` as a `Expression` expression."""
    shape = np.shape(g) if not isinstance(g, Affine) else g.shape
    if len(shape) != 2 or shape[0] != shape[1]:
        raise ValueError(f"block {name!r} must be a square matrix, got {shape}")
    try:
        return Expression([[0]])._read(g)
    except (TypeError, ValueError) as error:
        raise ValueError(f"block {name!r}: {error}") from None
