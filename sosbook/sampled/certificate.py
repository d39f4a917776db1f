"""Proofs in ball arithmetic as files: the matrices that a reader needs."""

import numpy as np
from flint import arb, ctx

from ..exact.definite import exact
from ..exact.proof import Examined, ProofFile
from ..exact.rational import decimal, decimals, fraction, read_array, read_number
from ..plants.as_data import plant_data, read_plant
from ..plants.checks import as_written
from ..plants.kinds import every_plant
from .discretize import SampleTiming, input_vertices, is_controller
from .loops import BALL_BITS, SampledPolytope, halves, pivot
from .system import SampledSystem

__all__ = ["SampledCertificate", "SchurCertificate", "balls_data"]

RATIONALS = (
    "rationals can't redo this proof: it encloses exponentials of matrices in "
    "balls; python -m sosbook verify does"
)


class SampledCertificate(ProofFile):
    """A proof, in ball arithmetic, that sampled loops are stable.

    ``text`` is that of the file.

    ``blocks`` holds, for each cell of plants, the smallest pivot of rate^2 -
    F'F in coordinates where |L x| is the length of x, less a bound of what
    the cell's loops F differ from mixtures of its corners' loops. The cells
    halve the simplex of the vertices' weights, again and again: the
    file holds the tree of these halves, and an L for each leaf.
    """

    kind = "sampled"

    @property
    def rate(self):
        """Every motion decays at least as rate^k."""
        return read_number(self.data["rate"])

    @property
    def K(self):
        """The gain (rounded to the printed digits) or controller."""
        return _read_controller(self.data)

    @property
    def cells(self):
        """(weights, L) of each leaf; empty without a proof.

        For every plant whose weights lie in the simplex with these corners
        (rows), |L x|^2 is a Lyapunov function.
        """
        data = self.data
        if not self.proven:
            return ()
        many = len(data["plant"]["vertices"])
        return tuple(
            (weights.astype(float), L) for weights, L, _ in _leaves(data["cells"], many)
        )

    @classmethod
    @as_written()
    def examine(cls, data):
        plant, U = read_plant(data["plant"]), data["U"]
        U = read_array(U, None, plant.n) if U else None
        T, delay, rate = (read_number(data[x]) for x in ("T", "delay", "rate"))
        K, tree, failed = _read_controller(data), data["cells"], data["undecided"]
        again = cls.contents(plant, U, T, delay, K, rate, tree, failed)
        if not 0 < rate <= 1:
            raise ValueError("rate must be in (0, 1]")
        if tree is None:
            return again, Examined.nothing(str(failed))
        timing, vertices = SampleTiming.of(T, delay), input_vertices(plant, U)
        blocks = {}
        with ctx.workprec(BALL_BITS):
            family = SampledPolytope.of(vertices, timing, K)
            for k, (weights, L, last) in enumerate(_leaves(tree, len(vertices)), 1):
                name = "plant" if len(vertices) == 1 else f"cell {k}"
                blocks[name] = family.least(weights, L, last, rate)
        return again, _examined(blocks, again["claims"])

    @classmethod
    def contents(cls, plant, U, T, delay, K, rate, tree, failed):
        """The data of the file for a plant with a gain or controller K.

        T, delay, U and rate are those of `certify_sampled`; ``tree`` is how
        the weights are halved, and ``failed`` what wasn't proven.
        """
        where = every_plant(plant)
        if plant.family is None and hasattr(plant, "sample"):
            where = "every plant of the polytope"  # also of one vertex
        return {
            "claims": [claim(f"the sampled loop of {where}", rate)],
            "plant": plant_data(plant),
            "U": [] if U is None else decimals(U),
            "T": decimal(T),
            "delay": decimal(delay),
            "K": _controller_data(K),
            "rate": decimal(rate),
            "cells": tree,
            "undecided": failed,
            "note": RATIONALS,
        }


class SchurCertificate(ProofFile):
    """A proof, in ball arithmetic, that eigenvalues have small magnitudes.

    ``text`` is that of the file.

    It has one Lyapunov function |L x|^2 for each matrix.
    """

    kind = "schur"

    @property
    def rate(self):
        """Every motion decays at least as rate^k."""
        return read_number(self.data["rate"])

    @property
    def cells(self):
        """(weights, L) of each matrix; empty without a proof."""
        if not self.proven:
            return ()
        return tuple(
            (np.ones((1, 1)), read_array(L, None, None)) for L in self.data["cells"]
        )

    @classmethod
    def examine(cls, data):
        rate, names = read_number(data["rate"]), data["undecided"]
        if not 0 < rate <= 1:
            raise ValueError("rate must be in (0, 1]")
        with ctx.workprec(BALL_BITS):
            matrices = [_read_balls(rows) for rows in data["matrices"]]
            cells = data["cells"]
            if cells is not None:
                cells = [read_array(L, len(F), len(F)) for L, F in zip(cells, matrices)]
            again = cls.contents(data["matrices"], rate, cells, names)
            if cells is None:
                return again, Examined((), {}, tuple(map(str, names)) or ("nothing",))
            blocks = {
                f"matrix {k}": pivot(F, L, arb(exact(rate)))
                for k, (F, L) in enumerate(zip(matrices, cells, strict=True), 1)
            }
        return again, _examined(blocks, again["claims"])

    @classmethod
    def contents(cls, matrices, rate, cells, failed):
        """The data of the file for some ``matrices`` and a rate.

        ``cells`` are the Lyapunov functions, and ``failed`` what wasn't
        proven.
        """
        return {
            "claims": [claim(f"matrix {k + 1}", rate) for k, _ in enumerate(matrices)],
            "matrices": matrices,
            "rate": decimal(rate),
            "cells": None if cells is None else [decimals(L) for L in cells],
            "undecided": list(failed),
            "note": RATIONALS if any(map(_of_balls, matrices)) else "",
        }


def claim(name, rate):
    """What is proven of a loop, in words."""
    sentence = f"{name} is stable"
    if rate != 1:
        sentence += f": every motion decays at least as {rate!r}^k"
    return sentence


def _examined(blocks, claims):
    failed = tuple(name for name, size in blocks.items() if not size > 0)
    return Examined(() if failed else tuple(claims), blocks, failed)


def _leaves(tree, many):
    """(weights, L, last) of each leaf, in the order of their proof."""
    queue = [(exact(np.eye(many)), tree)]
    while queue:
        weights, node = queue.pop()
        if "halve" not in node:
            if node.keys() != {"L", "last"} or node["last"] not in range(many):
                raise ValueError("a cell needs L and last")
            yield weights, read_array(node["L"], None, None), node["last"]
            continue
        (i, j), parts = node["halve"], node["halves"]
        if node.keys() != {"halve", "halves"} or len(parts) != 2 or i == j:
            raise ValueError("a cell that is halved needs two corners and two halves")
        if not {i, j} <= set(range(many)):
            raise ValueError("halve must name two corners")
        queue += zip(halves(weights, i, j), parts)


def _controller_data(K):
    if not is_controller(K):
        return decimals(K)
    contents = {name: decimals(getattr(K, name)) for name in "ABCD"}
    return contents | {"dt": K.dt if K.dt in (None, True) else decimal(K.dt)}


def _read_controller(data):
    K = data["K"]
    if not isinstance(K, dict):
        return read_array(K, None, None)
    if K.keys() != {"A", "B", "C", "D", "dt"}:
        raise ValueError("a controller needs A, B, C, D and dt")
    order, inputs, outputs = len(K["A"]), len(K["D"][0]), len(K["D"])
    shapes = (order, order), (order, inputs), (outputs, order), (outputs, inputs)
    sizes = (read_array(K[name], *shape) for name, shape in zip("ABCD", shapes))
    dt = K["dt"] if K["dt"] is None or K["dt"] is True else read_number(K["dt"])
    return SampledSystem(*sizes, dt)


def balls_data(F):
    """Rows of F as decimals; as [midpoint, radius], in fractions, for balls."""
    if F.dtype != object:
        return decimals(F)
    return [[[_exactly(e.mid()), _exactly(e.rad())] for e in row] for row in F]


def _of_balls(rows):
    return any(isinstance(e, list) for row in rows for e in row)


def _exactly(x):
    mantissa, exponent = map(int, x.man_exp())
    return str(mantissa * exact(2.0) ** exponent)


def _read_balls(rows):
    """The matrix of `balls_data`: balls that hold the given ones."""
    if not rows or any(len(row) != len(rows) for row in rows):
        raise ValueError("a matrix isn't square")
    matrix = np.empty((len(rows), len(rows)), object)
    for i, row in enumerate(rows):
        for j, e in enumerate(row):
            if isinstance(e, str):
                matrix[i, j] = arb(exact(read_number(e)))
            else:
                mid, rad = map(fraction, e)
                matrix[i, j] = arb(mid, rad)
    return matrix
