"""Exact proofs of what is asked of a known gain, by free multipliers, as files."""

from dataclasses import replace
from itertools import product

import numpy as np

from ..exact.definite import exact, round_digits
from ..exact.proof import Examined
from ..exact.proof_file import GainProof
from ..exact.rational import decimals, read_array, read_fractions
from ..laws.base import Law, Parts
from ..laws.structure import placed
from ..runtime.read_only import put
from .cells import Box, Mixtures, known_loops
from .fixed_mode import LAW, parts_data
from .known_gain import kept_or_broken
from .known_lmis import rational_blocks
from .ranges import Ranges, family
from .request_as_data import loop_data, read_request


class KnownGainProof(GainProof):
    """An exact proof that a known gain does what was asked, by free multipliers.

    Its ``text`` is a file with the plant, the requirements, the gain, and for each
    requirement the cells that cover the plants, with P at their corners, F and G. See
    `ProofFile` for `verify`, `save` and `load`.

    Examples
    --------
    >>> import sosbook as sos
    >>> carts = sos.Polytope([sos.SecondOrderSystem(m, 1, 1, 1) for m in (1, 2)])
    >>> proof = sos.analyse_pid(carts, [[-1, -1]], coupling="multipliers").certify()
    >>> proof.proven, proof.kind
    (True, 'known gain')
    """

    kind = "known gain"

    @classmethod
    def examine(cls, data):
        # by the functions of an author's theorem
        request, names, blocks = known_by_theorems(data)
        claims = [(words, names[r.key]) for words, r in _statements(request)]
        again = cls.contents(request, data["corners"], data["cells"])
        again["unknowns"] = data["unknowns"]
        return again, Examined.of(blocks, claims)

    @classmethod
    def contents(cls, request, box, cells):
        """The data of the file of a ``request``, without the unknowns: ``box``, the
        vertices, from 1, as corners of a box, or None; ``cells``, kind, name and cuts
        of each requirement.
        """
        law = None if request.law.whole else parts_data(request.applied.parts)
        return {
            **loop_data(request),
            "requirements": [r.untied().data() for r in request.requirements],
            "K": decimals(request.gain),
            "law": law,
            "corners": box,
            "cells": cells,
        }


def known_by_theorems(data):
    """The request of a file's data, its blocks, and their names by requirement."""
    law = data["law"] and Joined(data["law"], len(data["K"]))
    asked = data | dict(coupling="multipliers", epsilon=None, E0=None)
    request = read_request(asked, gain=data["K"], law=law)
    plants = _family(request, data["corners"])
    asked = {r.key: r for r in request.demands}
    blocks, names, left = {}, {}, dict(data["unknowns"])
    for q, (kind, name, cuts) in enumerate(data["cells"], 1):
        r = asked.pop((kind, name))
        several = {}
        for c, cell in enumerate(_leaves(plants.whole, cuts), 1):
            loops = [loop.seen_by(r) for loop in cell.loops]
            values = _values(left, f"{q}.{c}", len(loops))
            for block, g in rational_blocks(r, loops, values).items():
                several[f"{r.name} cell {c} {block}"] = g
        names[r.key] = tuple(several)
        blocks |= several
    if asked or left:
        raise ValueError("cells or unknowns are missing, or too many")
    return request, names, blocks


class Joined(Law):
    """The law of a file's ``data``, whose K has ``rows``; without words."""

    def __init__(self, data, rows):
        wide = dict.fromkeys(LAW, 0) | {"B": len(data["rows"])}
        parts = {name: read_fractions(data[name], wide[name]) for name in LAW}
        names = {k: tuple(data[k]) for k in ("states", "signals")}
        put(self, known=parts, names=names, rows=rows)

    def parts(self, plant):
        shapes = {name: x.shape for name, x in self.known.items()}
        (s, N), (c, _), (q, _) = (shapes[x] for x in ("rows", "E", "of_sensors"))
        wanted = dict(rows=(s, N), noise=(s, plant.p), E=(c, c), A=(c, c), B=(c, s))
        wanted |= dict(of_sensors=(q, s), of_states=(q, c))
        if shapes != wanted:
            raise ValueError("the parts of the law don't fit")
        known = self.known | self.names | {"sensors": ("",) * s}
        return Parts(**known, free=self.rows - plant.m)

    def structure(self, plant):
        q = len(self.known["of_sensors"])
        return placed((self.rows, q), {"K": ((0, self.rows), (0, q))}, None, {})

    def words(self, plant):
        return ""


def _statements(request):
    """The claims beside the requirements."""
    part = request.plant.reduction
    for words, r in request.claims.statements():
        words = words if part is None else part.words + words
        if not request.law.whole:
            words = words.replace("|K x(t)|", "|u(t)|")
        yield words, r


def _family(request, box):
    """The loops as a file says that they lie: a box is made of vertices, from 1."""
    if request.plant.family is not None and box is None:
        return Ranges(request)
    loops = known_loops(request)
    if box is None:
        return Mixtures(loops)
    corners = list(product((0, 1), repeat=len(box).bit_length() - 1))
    numbers = {i + 1: loop for i, loop in zip(request.distinct, loops)}
    if sorted(box) != sorted(numbers) or len(box) != len(corners):
        raise ValueError("the box isn't made of the vertices")
    loops = {corner: numbers[i] for corner, i in zip(corners, box)}
    found = Box(loops, corners)
    if not found.straight:
        raise ValueError("the vertices aren't a box")
    return found


def _leaves(whole, cuts):
    """The cells that aren't cut, in the order of a file."""
    waiting, leaves = [whole], []
    for way in cuts:
        cell = waiting.pop()
        if way is None:
            leaves.append(cell)
        else:
            way = tuple(way) if isinstance(way, list) else way
            waiting += reversed(cell.cut(way))
    if waiting:
        raise ValueError("a cell is missing")
    return leaves


def _values(left, place, corners):
    """The unknowns of a cell, which are taken out of what is left of a file's."""
    names = {f"P {i}": f"P.{place}.{i}" for i in range(1, corners + 1)}
    names |= {x: f"{x}.{place}" for x in ("F", "G", "mu", "J", "H")}
    found = {x: left.pop(name) for x, name in names.items() if name in left}
    values = {x: exact(read_array(rows, None, None)) for x, rows in found.items()}
    for x in values:
        if x[0] in "PJ" and not (values[x] == values[x].T).all():
            raise ValueError(f"{x} isn't symmetric")
    return values


def known_proof(request, parts, digits=None):
    """The `KnownGainProof` of a ``request`` from its ``parts``, the `Kept` of each
    demand; with ``digits`` that of the rounded gain, for which all is done again.
    """
    if digits is not None:
        K = round_digits(request.gain, digits)
        if (K != request.gain).any():
            request = replace(request, gain=K)
            parts = kept_or_broken(request).parts
    plants = family(request)
    box, cells, unknowns = None, [], {}
    if type(plants) is Box:
        order = plants.order
        box = [request.distinct[order.index(c)] + 1 for c in sorted(order)]
    for q, part in enumerate(parts, 1):
        cells.append([*part.requirement.key, [_way(x) for x in part.cuts]])
        for c, values in enumerate(part.values, 1):
            for name, x in values.items():
                head, _, corner = name.partition(" ")
                name = f"{head}.{q}.{c}" + (f".{corner}" if corner else "")
                unknowns[name] = decimals(np.atleast_2d(x))
    data = KnownGainProof.contents(request, box, cells)
    return KnownGainProof.of(data | {"unknowns": unknowns})


def _way(way):
    return [int(i) for i in way] if isinstance(way, tuple) else way
