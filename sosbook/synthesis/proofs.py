"""Proofs in exact rational arithmetic, of a loop or of its absence."""

from types import SimpleNamespace

import numpy as np

from ..exact.checker import payment
from ..exact.checker.families import given_vertices
from ..exact.definite import exact, round_digits
from ..exact.proof import Examined, first_proven
from ..exact.proof_file import GainProof, given_gain
from ..exact.rational import (
    decimal,
    decimals,
    exact_margin,
    read_array,
    read_number,
    read_regular,
)
from ..exact.refusal import MultiplierRefusal
from ..plants.checks import matrix
from ..plants.descriptor import MATRICES
from ..requirements.blocks import BlockTable
from .request_as_data import read_request, request_data
from .scaling import Frame


class Blocks:
    """The common base of the proof files of a request's blocks."""

    @classmethod
    def named(cls, data, keys):
        """Names of the blocks of a file's ``data`` that have these ``keys``."""
        table = BlockTable(len(given_vertices(data["plant"])) > 1)
        for kind, name, block, *vertices in keys:
            owner = SimpleNamespace(kind=kind, name=name, key=(kind, name))
            table.add(owner if kind else None, block, vertices, None)
        return list(table.named())


class DesignProof(Blocks, GainProof):
    """An exact proof that a gain does what was asked, or its failure.

    Its ``text`` is a file with the plant, the requirements, the gain and the
    matrices P, V, ... as decimals; ``proven`` is computed from it. See
    `ProofFile` for `verify`, `save` and `load`.

    Examples
    --------
    >>> from sosbook import SecondOrderSystem, design_pid
    >>> proof = design_pid(SecondOrderSystem([[1]], [[1]], [[1]], [[1]])).certify()
    >>> proof.proven, DesignProof(proof.text.replace('"K"', '"k"')).proven
    (True, False)
    """

    kind = "design"

    @property
    def P(self):
        """The rational Lyapunov matrix, (N, N), as decimal floats.

        With a slack matrix one for each vertex, (vertices, N, N).
        """
        unknowns = self.data["unknowns"]
        if "P" in unknowns:
            return _floats(unknowns["P"])
        names = read_request(self.data).lyapunov
        return np.array([_floats(unknowns[name]) for name in names])

    @property
    def V(self):
        """The rational slack matrix, or None."""
        V = self.data["unknowns"].get("V")
        return None if V is None else _floats(V)

    def margins(self):
        """The smallest eigenvalue of each block, a dict from names to floats.

        Of blocks in rationals, with their diagonals scaled to about one: however
        small, it is no rounding error. None where nothing is proven.
        """
        return self.measured(exact_margin) if self.proven else None

    @classmethod
    def examine(cls, data):
        # by the functions of an author's theorem, which can't be traced
        request, K, values, blocks = by_theorems(data)
        again = data | cls.contents(request, K, values)
        if any((values[name] != values[name].T).any() for name in request.lyapunov):
            return again, Examined.nothing("P isn't symmetric")
        owned = {}
        for name in blocks:
            owned.setdefault(name.requirement, []).append(name)
        said = [
            (words, owned.get(r.key, ())) for words, r in request.claims.statements()
        ]
        return again, Examined.of(blocks, said)

    @classmethod
    def contents(cls, request, K, values):
        """The data of the file for a request, a rounded K and exact values."""
        return {
            **request_data(request),
            "requirements": [
                r.data() | _theorem(r, request, place, values)
                for place, r in enumerate(request.requirements, 1)
            ],
            "K": decimals(K),
            "unknowns": {name: decimals(x) for name, x in values.items()},
        }


def by_theorems(data):
    """The request, K, the exact unknowns and the blocks of a file's ``data``, by the
    functions of the theorems, beside which the texts of files are written.
    """
    request = read_request(data)
    K = read_array(data["K"], request.plant.m, request.order)
    values = {name: exact(_floats(x)) for name, x in data["unknowns"].items()}
    P = request.coupling.given([values[name] for name in request.lyapunov])
    Y = exact(K) @ request.coupling.divisor(values).T
    blocks = request.blocks(P, Y, exact, V=values.get("V"), own=values)
    return request, K, values, blocks


def _theorem(requirement, request, place, unknowns):
    """An author's words and blocks as text, for readers who haven't the class."""
    if requirement.of_package:
        return {}
    from ..requirements.in_text import theorem_data

    sized = requirement.size_name in unknowns
    theorem = theorem_data(requirement, request, place, sized)
    return {} if theorem is None else {"claim": requirement.claim(), "theorem": theorem}


def _floats(rows):
    return read_array(rows, None, None)


def _shapes(request, known):
    """Shapes of a proof's matrices: P, V, the own ones, and sizes that it knows;
    whatever its size is, a requirement's P proves it: see `Request.blocks`.
    """
    sizes = {r.size_name: (1, 1) for r in request.sizes.fixing}
    shapes = {u.name: u.shape for u in request.unknowns() if u.name != "Y"}
    shapes = {name: shape for name, shape in shapes.items() if name not in sizes}
    return shapes | {name: shape for name, shape in sizes.items() if name in known}


def _key(name):
    """A block's key as a list: kind and name of its requirement, block, vertices."""
    return [*(name.requirement or ("", "")), name.block, *name.vertices]


def prove(request, K, P, digits=6, V=None, own=None):
    """Check every block of a ``request`` in exact arithmetic, built again from the
    primary data, where floats are read as decimals: 0.1 is 1/10. ``K``, (m, N), is
    rounded to so many ``digits`` first (6, 8, 10, 12 and 17 are tried for None; a given
    gain stays), and so are the symmetric ``P``, (N, N) (one for each vertex with
    a slack matrix), the slack matrix ``V`` and, by name, the requirements'
    ``own`` unknowns.
    """
    asked = _recorded(request)
    shape, names = (request.order, request.order), asked.lyapunov
    K = matrix("K", K, (request.plant.m, request.order))
    P = [matrix("P", p, shape) for p in (P if request.coupling.own_P else [P])]
    if len(P) != len(names):
        raise ValueError(f"P has {len(P)} matrices, needs {len(names)}")
    values = dict(zip(names, P))
    own = {**(own or {}), "V": V}
    for name, size in _shapes(asked, own).items():
        if name not in values:
            if name not in own:
                raise ValueError(f"own lacks {name}, an unknown of a requirement")
            values[name] = matrix(name, own[name], size)

    def attempt(digits, places):
        rounded = {name: round_digits(x, places) for name, x in values.items()}
        K_rounded = round_digits(K, digits)
        return DesignProof.of(DesignProof.contents(asked, K_rounded, rounded))

    return first_proven(attempt, digits, **given_gain(request.gain))


def _recorded(request):
    """The request as a file holds it, built again from the primary data."""
    again = read_request(request_data(request))
    for mine, read in zip(request.ground.certain, again.ground.certain, strict=True):
        for name in MATRICES:
            if not np.array_equal(getattr(mine, name), getattr(read, name)):
                raise ValueError(f"a proof file can't hold {name} of this plant")
    return again


def claims(request):
    """The claims that positive definite blocks of a request prove, in words."""
    return tuple(words for words, _ in request.claims.statements())


class DesignRefusal(Blocks, MultiplierRefusal):
    """Multipliers that exclude every design; see `MultiplierRefusal` for the text."""

    kind = "infeasible design"

    @property
    def condition(self):
        """The condition of the refusal: "for mu = 1"; else empty."""
        return read_request(self.data, gain=self.data["K"]).sizes.condition

    @classmethod
    def rebuilt(cls, data):
        request = read_request(data, gain=data["K"])
        if "box" in data:
            given = given_vertices(data["plant"])
            corners = payment.corners(data["box"], data["plant"]["kind"], len(given))
            if not payment.close(given, corners):
                raise ValueError("the box is far from the vertices")
        frame = read_frame(data["coordinates"], request.order)
        named = {tuple(key[3:] * 2)[:2] for key, _ in data["multipliers"]}
        pairs = [pair for pair in request.pairs if pair in named]
        expressions, unknowns = request.in_unknowns(frame, exact, pairs=pairs)
        return cls.contents(request, frame), expressions, unknowns, _key

    @classmethod
    def contents(cls, request, frame):
        """The data of the file for a request in a frame, without the multipliers."""
        free = request.gain is None
        near = payment.AT_CORNERS if request.ground.near is not None else ""
        return {
            "claims": [excluding(free, claims(request), request.sizes.condition, near)],
            **request_data(request),
            "K": None if free else decimals(request.gain),
            "coordinates": frame_data(frame),
        }


def excluding(free, claims, condition="", near=""):
    """The refusal of ``claims`` by multipliers under a ``condition``, in words;
    ``free`` says whether the gain was sought, too, ``near`` where the LMIs are asked.
    """
    who = "no gain and no matrices prove" if free else "no matrices prove"
    which = "by these LMIs" + (f" {condition}" if condition else "") + near
    return f"{who} {which}: " + "; ".join(claims)


def frame_data(frame):
    """The coordinates of a ``frame``, as decimals; "sizes" are lengths, in which the
    requirements measure their own P.
    """
    return {
        **{name: decimals(getattr(frame, name)) for name in ("left", "T", "back")},
        "scale": decimal(frame.scale),
        "sizes": {name: decimal(c) for name, c in frame.sizes.items()},
    }


def read_frame(data, N):
    """The `Frame` for N states of the ``data`` that `frame_data` writes."""
    return Frame(
        *(read_regular(data[name], N) for name in ("left", "T", "back")),
        read_number(data["scale"]),
        sizes={name: read_number(c) for name, c in data["sizes"].items()},
    )


def exclude_design(request, frame, key, Z):
    """The file of one exact multiplier ``Z`` of a ``request`` in a ``frame``: that of
    the block with this ``key``, of a requirement and of the vertices.
    """
    ((k,),), request = key[1:], request.as_in_files
    expressions, _ = request.in_unknowns(frame, exact, pairs=[(k, k)])
    every = {
        name: Z
        if (name.requirement, name.vertices) == key
        else exact(0 * np.eye(len(g.constant)))
        for name, g in expressions.items()
    }
    data = DesignRefusal.contents(request, frame)
    return DesignRefusal.of(DesignRefusal.written_from(data, every, _key))


def refuse_design(request, frame, Z, pairs=None):
    """Exact multipliers of a ``request`` from float ones, ``Z``, of the blocks in a
    ``frame``, for some ``pairs`` of vertices or all, where the repair succeeds. They
    exclude what a file's coupling allows, which may be more than the request's.
    """
    request = request.as_in_files
    expressions, unknowns = request.in_unknowns(frame, exact, pairs=pairs)
    data = DesignRefusal.contents(request, frame)
    return DesignRefusal.mended(data, expressions, unknowns, Z, _key)
