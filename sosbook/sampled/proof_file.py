"""Proofs in ball arithmetic as files: the matrices that a reader needs."""

from dataclasses import dataclass

import numpy as np
from flint import ctx

from ..exact.checker.ticks import said
from ..exact.checker.ticks import signals as written_signals
from ..exact.proof import Examined
from ..exact.proof_file import ProofFile
from ..exact.rational import decimal, decimals, read_array, read_number
from ..laws.taken import is_controller
from ..plants.as_data import plant_data, read_plant
from ..plants.checks import as_written
from ..plants.gain import signals
from ..requirements.base import Requirement
from ..runtime.names import claimed
from ..runtime.time_limit import OutOfTime, time_limit
from .cells import PlantCell
from .channel import check_channel, checked_norm
from .discretize import input_vertices
from .frames import with_frames
from .loops import BALL_BITS, SampledFamily
from .shapes import PlantShape
from .system import SampledSystem
from .timing import TimeBox

__all__ = ["SampledProof"]

MORE = 4  # times the cells, where those that were given were too few
NAMES = "inputs", "outputs"  # of a controller: the plant's states, and its inputs
PARTS = "parts"  # of a tick, where delays last several
OF_READINGS = "B_w", "D_w"  # how w enters a controller by what it reads


class SampledProof(ProofFile):
    """A proof, or an enclosure of one program, that sampled loops are stable.

    ``text`` is that of the file.

    It holds a tree of cells: halves of the simplex, or the box, of the plants'
    vertices. A leaf has coordinates L x and in them a Lyapunov matrix P for each of
    its corners, the identity without it, and a tree of its own, of halves of the
    intervals and of the delays, whose leaves may have a multiplier G. Its text is
    that of `sosbook.exact.checker.sampled`, and the stand-alone checker decides it.
    Where the search for what the text needs gives up, balls decide instead (see
    `sosbook.sampled.cells`), and ``examined.alone`` says so. ``blocks`` has the
    smallest pivot of each block.
    """

    kind = "sampled"

    @property
    def rate(self):
        """Every motion decays at least as rate^k."""
        return read_number(self.data["rate"])

    @property
    def centre(self):
        """Of the disk of radius ``rate`` that has all eigenvalues."""
        return read_number(self.data["centre"])

    @property
    def T(self):
        """The time between samples, in s, or the two ends of its range."""
        return _read_range(self.data["T"])

    @property
    def delay(self):
        """The delay, in s, or the two ends of its range."""
        return _read_range(self.data["delay"])

    @property
    def K(self):
        """The gain (rounded to the printed digits) or controller."""
        return _read_controller(self.data, self._plant()[0].p)

    @property
    def norm(self):
        """The bound of H-infinity that is proven, too; None without."""
        return _read_norm(self.data)

    @property
    def cells(self):
        """(weights, P) of each cell of plants; empty without a proof.

        The rows of ``weights`` are the cell's corners. A plant whose [E A B] is a
        mixture of theirs, or whose E^-1 [A B] is, where those of all plants are, has
        the Lyapunov matrix that mixes the P in the same way.
        """
        if not self.proven:
            return ()
        plant, U = self._plant()
        shape = PlantShape.of(plant, input_vertices(plant, U))
        leaves = _leaves(self.data["cells"], shape)
        if "frames" in self.data:
            leaves = _framed(self.data, shape)
        found = []
        for weights, L, _, P, _ in leaves:
            rows = np.zeros(weights.shape)
            rows[:, shape.order] = weights.astype(float)
            P = np.array([np.eye(len(L))] * len(rows) if P is None else P)
            found.append((rows, L.T @ P @ L))
        return tuple(found)

    def _plant(self):
        return _read_plant(self.data)

    @classmethod
    @as_written()
    def examine(cls, data):
        """Prove the loops of a file's ``data`` again, in balls, cell by cell."""
        plant, U = _read_plant(data)
        T, delay = (_read_range(data[x]) for x in ("T", "delay"))
        rate, K = read_number(data["rate"]), _read_controller(data, plant.p)
        tree, failed = data["cells"], data.get("undecided", "")
        centre = read_number(data["centre"])
        norm = _read_norm(data)
        again = cls.contents(plant, U, T, delay, K, rate, tree, failed, centre, norm)
        if not (rate > 0 and abs(centre) + rate <= 1):
            raise ValueError("rate must be in (0, 1], and its disk in the unit disk")
        if tree is None:
            return again, Examined.nothing(str(failed))
        clocks, vertices = TimeBox.of(T, delay), input_vertices(plant, U)
        if not clocks.cuts:
            clocks = clocks.cut(tree.get(PARTS))
        if centre and clocks.varies:
            raise ValueError("a disk is of one clock")
        if norm is not None and (rate != 1 or centre):
            raise ValueError("a norm is proven with a rate of one")
        blocks = {}
        with ctx.workprec(BALL_BITS):
            family = _family(plant, vertices, clocks, K, centre, norm)
            leaves = _leaves(tree, family.shape)
            for k, (weights, L, last, P, times) in enumerate(leaves, 1):
                for matrix in (L, *(() if P is None else P)):
                    check_channel(matrix, family.held)
                name = "plant" if len(vertices) == 1 else f"cell {k}"
                cell = PlantCell(family, weights, L, clocks, last, P)
                for j, (box, G) in enumerate(_boxes(times, clocks, len(L)), 1):
                    of = f", clocks {j}" if clocks.varies else ""
                    blocks[name + of] = cell.least(box, rate, G)
        return again, _examined(blocks, said(data, len(vertices)))

    @classmethod
    def contents(cls, plant, U, T, delay, K, rate, tree, failed, centre=0.0, norm=None):
        """The data of the file for a plant with a gain or controller K.

        T, delay, U, rate, centre and norm are those of `certify_sampled`; ``tree`` is
        how the weights are halved, and ``failed`` what wasn't proven.
        """
        ends = TimeBox.of(T, delay).written(delay)
        data = {
            "plant": plant_data(plant),
            "U": [] if U is None else decimals(U),
            **{name: decimals(x) for name, x in zip(("T", "delay"), ends)},
            "K": _controller_data(K),
            "rate": decimal(rate),
            "centre": decimal(centre),
            "norm": None if norm is None else norm.data(),
            "cells": tree,
        }
        _call(data["K"], data, plant, U)
        return data | ({"undecided": failed} if tree is None else {})


@dataclass(frozen=True, eq=False)
class Found:
    """The result of a search in balls: the ``data`` of a file without a text.

    ``shape`` is the `PlantShape` of its cells; None where no text says the proof.
    """

    data: dict
    shape: PlantShape | None = None

    @property
    def proven(self):
        """True if balls decided all cells that were found; the file decides again."""
        return self.data["cells"] is not None

    @property
    def failed(self):
        """The words for what wasn't proven."""
        return self.data.get("undecided", "")

    @property
    def by_balls(self):
        """The proof that balls decide."""
        return SampledProof.of(self.data)

    def in_text(self, seconds=None):
        """The proof with a text; by balls where none is found in some ``seconds``."""
        try:
            with time_limit(seconds):
                framed = self.shape and with_frames(self.data, self.shape)
                if framed and (proof := SampledProof.of(framed)):
                    return proof
        except OutOfTime:
            pass
        return self.by_balls


def _family(plant, vertices, clocks, K, centre, norm):
    """The loops of a file's plant and K."""
    timing = clocks.of_controller(K)
    return SampledFamily.of(plant, vertices, timing, K, centre, norm)


def undecided(few):
    """Words where nothing was proven; ``few`` cells were too few, or zero."""
    words = f" after {few} cell{'s' * (few > 1)}; cells={MORE * few} goes on"
    return f"undecided{words if few else ''}"


def _examined(blocks, claims):
    failed = tuple(name for name, size in blocks.items() if not size > 0)
    return Examined(() if failed else tuple(claims), blocks, failed)


def _leaves(tree, shape):
    """(weights, L, last, P, times) of each cell of plants, as they are proven."""
    tree = {key: x for key, x in tree.items() if key != PARTS}
    queue = [(shape.whole(), tree, None)]
    while queue:
        weights, node, above = queue.pop()
        many = len(weights)
        own = {key: node[key] for key in node.keys() - {"halve", "halves"}}
        if above is None and ("L" in own or "halve" not in node):
            if not {"L", "last"} <= own.keys() <= {"L", "last", "P", "times"}:
                raise ValueError("a cell needs L and last, and may have P and times")
            if own["last"] not in range(many):
                raise ValueError("last must be a corner")
            L, P = read_array(own["L"], None, None), None
            if "P" in own:
                P = read_array(own["P"], many, len(L), len(L))
                if (P != P.transpose(0, 2, 1)).any():
                    raise ValueError("a Lyapunov matrix P isn't symmetric")
            above = L, own["last"], P
        elif not own.keys() <= ({"times"} if above else set()):
            raise ValueError("a part of a cell with L may have times alone")
        if "halve" not in node:
            yield weights, *above, own.get("times", {})
            continue
        if "times" in own or (above and above[2] is None):
            raise ValueError("a cell whose L is its halves' needs P, and no times")
        cut, both = shape.checked_cut(node["halve"]), [above, above]
        halves = _halves({key: node[key] for key in node.keys() - own.keys()})
        if above:
            both = [(*above[:2], P) for P in shape.halves(above[2], cut)]
        queue += zip(shape.halves(weights, cut), halves, both)


def _framed(data, shape):
    """(weights, L, 0, P, times) of each cell of plants of a file with a text."""
    queue = [(shape.whole(), data["cells"])]
    while queue:
        weights, node = queue.pop()
        if "halve" in node:
            queue += zip(shape.halves(weights, node["halve"]), node["halves"])
            continue
        L, P = read_array(data["frames"][node["frame"]]["L"], None, None), node.get("P")
        P = None if P is None else read_array(P, len(weights), len(L), len(L))
        yield weights, L, 0, P, node["times"]


def _halves(node):
    if node.keys() != {"halve", "halves"} or len(node["halves"]) != 2:
        raise ValueError("a cell that is halved needs a cut and two halves")
    return node["halves"]


def _boxes(tree, clocks, N):
    """(box, G) of each cell of clocks."""
    queue = [(clocks, tree)]
    while queue:
        box, node = queue.pop()
        if box.empty:
            continue
        if "halve" not in node:
            if not node.keys() <= {"G"}:
                raise ValueError("a cell of clocks may have G")
            yield box, read_array(node["G"], N, N) if "G" in node else None
            continue
        if node["halve"] not in ("T", "delay"):
            raise ValueError("clocks are halved by T or by the delay")
        queue += zip(box.halves(node["halve"]), _halves(node))


def _read_norm(data):
    return (
        None if data["norm"] is None else checked_norm(Requirement.read(data["norm"]))
    )


def _read_plant(data):
    plant, U = read_plant(data["plant"]), data["U"]
    return plant, read_array(U, None, plant.n) if U else None


def _read_range(x):
    low, high = read_array(x, 2).tolist()
    return (low, high) if low < high else low


def _controller_data(K):
    if not is_controller(K):
        return decimals(K)
    contents = {name: decimals(getattr(K, name)) for name in "ABCD"}
    contents |= {x: list(getattr(K, x)) for x in NAMES if getattr(K, x, ())}
    if getattr(K, "D_w", None) is not None:
        contents |= {name: decimals(getattr(K, name)) for name in OF_READINGS}
    return contents | {"dt": K.dt if K.dt in (None, True) else decimal(K.dt)}


def _call(K, data, plant, U):
    """Have a controller's signals called as files and claims may call them."""
    z = getattr(plant, "coordinates", None) or ()
    if z and isinstance(K, dict) and K.get("inputs") == list(signals(plant, U)):
        K["outputs"], K["inputs"], _ = written_signals(data, claimed(z))


def _read_controller(data, p):
    """The gain or the `SampledSystem` of a file's ``data``."""
    K = data["K"]
    if not isinstance(K, dict):
        return read_array(K, None, None)
    if K.keys() - {*NAMES, *OF_READINGS} != {"A", "B", "C", "D", "dt"}:
        raise ValueError("a controller needs A, B, C, D and dt")
    order, inputs, outputs = len(K["A"]), len(K["D"][0]), len(K["D"])
    shapes = (order, order), (order, inputs), (outputs, order), (outputs, inputs)
    sizes = (read_array(K[name], *shape) for name, shape in zip("ABCD", shapes))
    dt = K["dt"] if K["dt"] is None or K["dt"] is True else read_number(K["dt"])
    read = None, None
    if K.keys() & set(OF_READINGS):
        shapes = (order, p), (outputs, p)
        read = (read_array(K[name], *shape) for name, shape in zip(OF_READINGS, shapes))
    return SampledSystem(*sizes, dt, *read, *(K.get(name, ()) for name in NAMES))
