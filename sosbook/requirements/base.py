"""The protocol that every requirement keeps; consumers ask nothing else.

A requirement is a frozen object: a bound of a norm, a region of the poles. It writes
its own LMI blocks, says in words what a proof of them proves and computes the true
value in a loop. A new one is a new file, here or elsewhere.
"""

import json
from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from dataclasses import fields, replace
from typing import Any

import numpy as np

from ..exact.rational import decimal, decimals, read_array, read_number
from ..plants.checks import positive
from ..plants.coupled import Coupled, SlackVertex
from ..plants.descriptor import Descriptor
from ..plants.outputs import Output
from ..runtime.later import later
from ..runtime.names import OfKind
from ..runtime.read_only import ReadOnly, put
from .known_gain import KnownVertex
from .posed import PosedLoop
from .vocabulary import KINDS, Parameter


class Requirement(OfKind, ABC, ReadOnly):
    """Something that is asked of a loop.

    A theorem needs five of the methods: `unknowns`, the blocks (`once`, `pair` and
    `slack`), `claim`, `truth` and, through ``parameter``, its ``bound``. All else is
    a hook with a default. How large its unknowns are is read from the blocks: see
    `sosbook.requirements.magnitudes`.

    Attributes
    ----------
    kind : str
        What sort of requirement it is: "region", "cost", ... Each class declares
        one of its own, by which proof files find it: see `OfKind`.
    name : str
        Distinguishes it from others of its kind; `Request.without` takes it.
    parameter : Parameter or None
        What its bound is called and which way it tightens; None where
        nothing can be moved.
    bound : float or None
        The bound that is asked for; None without one.
    tied : str
        What holds its P to a given multiple of the others', in words, such
        as "mu = 1"; empty if nothing does.
    implies_stability : bool
        Whether its blocks demand Re s < 0, so that no other need do so. Where the
        class isn't the package's own, stability is demanded all the same.
    needs_disturbance : bool
        Whether it is about w, so that the plant must have F.
    affine_in_quotient : bool
        Whether each `pair` block of a vertex is, after a congruence, affine in
        E^-1 [A B_u B_w], as if the plant were divided by E. Where all
        requirements are, the vertices of some polytopes suffice: see
        `sosbook.studies.polytopes.vertices_suffice`. Where the class isn't the
        package's own, that is probed in rationals: see `sosbook.synthesis.quotient`.
    lossless : bool
        Whether one loop, whose gain is known, keeps it if and only if its blocks with
        one P have a solution.
    rank : int
        Its place among the requirements of a request.
    of_two : str
        What to do where a request has two of its kind with one name.
    promise : str
        Name of the promise that `truth` is compared with.
    titles : dict
        What tables and pages call a block, by its name.
    outputs, inputs : Output and tuple of int, or None
        Which y and which disturbances w it is about, counted from 0; those of the
        plant where they are None.
    """

    homes = KINDS
    kind = name = promise = ""
    parameter: Parameter | None = None
    tied: str = ""
    implies_stability = needs_disturbance = affine_in_quotient = lossless = False
    rank = 50
    of_two = "give one of them another name"
    titles: dict[str, str] = {}
    outputs: Output | None = None
    inputs: tuple | None = None
    step: float | None = None

    def __post_init__(self):
        if self.bound is not None:
            key = self.parameter.key
            put(self, **{key: positive(key, self.bound)})

    # what a theorem needs

    @property
    def bound(self) -> float | None:
        """The bound that is asked for, a float, or None without one."""
        return getattr(self, self.parameter.key) if self.parameter else None

    def unknowns(self, request: Any) -> tuple:
        """The unknowns of its own in a request, a tuple, beside P, V and Y."""
        return ()

    def once(self, loop: PosedLoop) -> Iterable:
        """Blocks of a loop that are demanded once: (name, vertices, matrix) each."""
        return ()

    @abstractmethod
    def pair(self, loop: PosedLoop, c: Coupled) -> Iterable:
        """Blocks of a pair of vertices: (name, matrix) each.

        A plant between has the weights w of the vertices, and its block must be
        sum w_i w_j of these: so a pair whose E are equal needs no block, for its
        block is the mean of the vertices' ones.

        Parameters
        ----------
        loop : PosedLoop
            What the blocks are made of.
        c : Coupled
            The pair of vertices.
        """

    def slack(self, loop: PosedLoop, c: SlackVertex, i: int) -> Iterable:
        """Blocks of a vertex with a slack matrix: (name, matrix) each.

        In a class of the package they imply, with P_i and V, the `once` and `pair`
        blocks of that vertex alone with P = V' P_i^-1 V and Y = K P: then what
        excludes the vertex alone excludes every slack scalar.

        Parameters
        ----------
        loop : PosedLoop
            What the blocks are made of.
        c : SlackVertex
            The vertex.
        i : int
            Which vertex it is.
        """
        raise ValueError(
            f'{self.words} has no LMI with a slack matrix: take coupling="pairs"'
        )

    def known_gain(self, c: KnownVertex) -> Iterable:
        """Blocks of a vertex c where the gain is known: (name, matrix) each.

        They must be affine in the plant, and homogeneous in the unknowns of c. With
        P > 0 they prove what is asked by themselves: nothing else has this P.
        """
        raise ValueError(
            f"{self.words} has no LMI with free multipliers, by which a law's loop is "
            'proven: without a law, take coupling="pairs"'
        )

    def known_gain_unknowns(self, c: KnownVertex) -> dict:
        """Further unknowns of `known_gain` at ``c``, with units, near one for P = I."""
        return {}

    @property
    def takes_slack(self) -> bool:
        """True if the requirement has the blocks of `slack`."""
        return type(self).slack is not Requirement.slack

    @property
    def takes_multipliers(self) -> bool:
        """True if the requirement has the blocks of `known_gain`."""
        return type(self).known_gain is not Requirement.known_gain

    @property
    def multiplier_rows(self) -> int:
        """The k of the multipliers F and G of `known_gain`, (kN, kN)."""
        return 1

    @abstractmethod
    def claim(self) -> str:
        """The statement that its blocks prove, in words; never more."""

    @abstractmethod
    def truth(
        self, loops: Sequence[Descriptor], K: np.ndarray, K_A: np.ndarray | None = None
    ) -> float:
        """The true value of the worst loop, to be compared with the bound.

        Parameters
        ----------
        loops : sequence of Descriptor
            The plants in descriptor form.
        K : (m, N) array
            The gain of u = K x.
        K_A : (m, n) array, optional
            The gain of the accelerations; zero without it.
        """

    @property
    def has_channel(self) -> bool:
        """True if the requirement has outputs or inputs of its own."""
        return self.outputs is not None or self.inputs is not None

    def seen(self, d: Descriptor) -> Descriptor:
        """The plant ``d`` with the outputs and disturbances that it is about."""
        d = d if self.outputs is None else self.outputs.seen(d)
        if self.inputs is None:
            return d
        some = list(self.inputs)
        Dw = None if d.Dw is None else d.Dw[:, some]
        return replace(d, Bw=d.Bw[:, some], Dw=Dw)

    def resized(self, old: int, new: int) -> "Requirement":
        """The same with its output's rows on ``old`` states on ``new`` ones; see
        `Output.resized`.
        """
        if self.outputs is None:
            return self
        return replace(self, outputs=self.outputs.resized(old, new))

    def joined(self, parts: Any) -> "Requirement":
        """The same of a plant to which a law joins its ``parts``: what is about all of
        the plant's states is about those of the loop then.
        """
        N, c = parts.rows.shape[1], len(parts.states)
        return self.resized(N, N + c) if c else self

    def stepped(self, step: float | None) -> "Requirement":
        """The same for the change from tick to tick, ``step`` s, of a plant of discrete
        time: see `DescriptorSystem`; for one of continuous time where it is None.
        """
        return later("requirements.in_steps", "with_step")(self, step)

    def of_plant(self) -> "Requirement":
        """The same of a plant whose output and disturbances are those it is about."""
        return self

    def fits_one_P(self, request: Any) -> bool:
        """True if blocks of ``request`` with one P speak of plants between, too."""
        return True

    # hooks, each with a default

    def check(self, request: Any) -> None:
        """Raise a ValueError, with argument and cure, if a request can't meet it."""
        if self.needs_disturbance and request.plant.p == 0:
            raise ValueError(
                f"{self.name} needs a plant with F, but the plant has no F: say "
                "where the disturbance enters"
            )
        if not self.of_package and any(
            d.Dw is not None or d.Ca is not None for d in request.vertices
        ):
            raise ValueError(
                f"{self.name}: its blocks know y = C x + D_u u, but the plant has D_w "
                "or C_a: leave them out, or make that output a state of a filter"
            )
        if self.parameter is not None and self.bound is None:
            key = self.parameter.key
            raise ValueError(
                f'{key} is None: give a number, or let minimize="{key}" find it'
            )

    @property
    def words(self) -> str:
        """Its name in messages."""
        return self.parameter.words if self.parameter else self.name

    def kept(self, truth: float) -> float:
        """Positive where the promise is kept: the bound less the truth."""
        return self.bound - truth

    def reached(
        self, loops: Sequence[Descriptor], K: np.ndarray, K_A: np.ndarray | None = None
    ) -> float:
        """The bound that the worst of ``loops`` under ``K``, ``K_A`` doesn't keep."""
        return self.truth(loops, K, K_A)

    def slopes(self, d: Descriptor, K: np.ndarray) -> tuple | None:
        """Derivatives of `reached`, for a search of gains; None: it takes differences.

        Of one stable loop ``d`` under u = ``K`` x: in E^-1 (A + B_u K), in K where it
        is weighed itself, and in E^-1 B_w.
        """
        return None

    def with_bound(self, bound: float) -> "Requirement":
        """The same requirement with another bound."""
        if self.parameter is None:
            raise ValueError(f"{self.name} has no bound that can be moved")
        return replace(self, **{self.parameter.key: bound})

    def untied(self) -> "Requirement":
        """The same requirement, whose P may be any multiple of the others'."""
        return self

    def repeats(self, other: Any) -> bool:
        """True if its blocks are, exactly, positive multiples of an ``other`` one's;
        then they are demanded once. It is believed of the package's own classes only.
        """
        return False

    def contradicts(self, other: Any) -> bool:
        """True if no loop at all meets this and an ``other`` one, at sight."""
        return False

    def pole_matrices(self) -> tuple | None:
        """alpha and beta, in rationals; None where it isn't a region of the poles.

        It asks alpha + beta s + beta' conj(s) < 0 of every pole s then.
        """
        return None

    def bounds_input_from(self) -> np.ndarray | None:
        """x0, where it asks |K x| <= bound from x0 by Lemma 2.2; else None."""
        return None

    def of_part(self, rows: np.ndarray) -> "Requirement | None":
        """The same about the states ``rows`` x, (k, N), of a part that moves by itself
        and alone takes u; None where it is about other states, too.
        """
        return None if self.pole_matrices() is None else self

    def bounds_response(self) -> float | None:
        """A number that the H-infinity norm from w to z must stay below, or None."""
        return None

    def rate(self) -> tuple | None:
        """(rank, typical rate in rad/s), of rank 2 for plants without one; or None."""

    def riccati(self) -> Any:
        """(Q, R) of the Riccati equation that it is about, or None."""

    def data(self) -> dict:
        """Its data in a proof file: words, truths and decimals, by field."""
        contents = {"kind": self.kind, "name": self.name}
        for field in fields(self):
            value = getattr(self, field.name)
            contents[field.name] = value
            if isinstance(value, np.ndarray):
                contents[field.name] = decimals(value)
            elif isinstance(value, (int, float)) and not isinstance(value, bool):
                contents[field.name] = decimal(value)
        contents.pop("step", None)  # the plant has it
        return contents

    @classmethod
    def of_data(cls, data: dict) -> "Requirement":
        """The requirement of `data`, of this kind."""
        fixed = "kind", "name"
        return cls(**{k: _value(v) for k, v in data.items() if k not in fixed})

    # what follows

    @property
    def key(self) -> tuple:
        """Distinguishes it from every other requirement of a request."""
        return self.kind, self.name

    @property
    def of_package(self) -> bool:
        """True if its class is the package's own, whose answers are tested there."""
        return type(self).__module__.split(".")[0] == __package__.split(".")[0]

    @property
    def statement(self) -> str:
        """Its claim for a proof's lines: an author's is quoted, and named as theirs."""
        if self.of_package:
            return self.claim()
        return f"{self.name}, by its author's theorem: {json.dumps(self.claim())}"

    @property
    def size_name(self) -> str:
        """Name of the unknown s: the blocks hold P / s and Y / s.

        A request with two requirements that fix the size of P gives one of
        them such a scalar.
        """
        return " ".join(("size for", *dict.fromkeys(self.key)))

    @staticmethod
    def read(data: dict) -> "Requirement":
        """The requirement of `data`, of whatever kind."""
        cls = Requirement.owner(data["kind"])
        if cls is None:
            kind = f"a requirement of the kind {data['kind']!r} isn't known"
            raise ValueError(f"{kind}: import the module that defines it")
        text = "claim", "theorem"  # for those who haven't the class
        return cls.of_data({k: v for k, v in data.items() if k not in text})


def _value(recorded):
    """A word, a truth, a number or an array."""
    if isinstance(recorded, list):
        return read_array(recorded, *[None] * np.ndim(recorded))
    try:
        return read_number(recorded)
    except ValueError:
        return recorded
