"""A plant and what is asked of its loop, as LMI blocks."""

import re
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from ..language import Affine, Unknown
from ..laws.full_state import LATE_SENSORS, NO_MATRICES
from ..laws.taken import law_of
from ..lmi.text import floats
from ..plants.checks import matrix
from ..plants.coupling import Coupling, OneP, VerticesOnly, coupling_of
from ..plants.descriptor import mean_descriptor, twins
from ..plants.descriptor_system import DescriptorSystem
from ..plants.kinds import Prepared, checked_plant, of_floats
from ..requirements.blocks import BlockTable
from ..requirements.in_steps import timed
from ..requirements.posed import PosedLoop
from ..requirements.shorthand import Shorthand, collected, moved, no_requirement
from ..runtime.names import sane_name
from ..runtime.read_only import ReadOnly, put
from ..runtime.time_limit import check_time_of_eigenvalues
from .claims import Claims
from .ground import Ground
from .pair_stacks import blocks_of_pairs
from .sizes import Sizes

ONE_P = OneP()
MADE_AGAIN = "apart", "claims", "sizes"
RESERVED = re.compile(r"P|P \d+|V|Y|size for .*")  # names of a request's unknowns


@dataclass(frozen=True, eq=False, init=False)
class Request(Shorthand, ReadOnly):
    """A plant and what is asked of its loop; makes the LMI blocks. ``plant``, ``U``,
    ``K_A``, ``coupling`` and ``law`` are as in `design_pid`, where "auto" is
    the first that it tries; a `Coupling` is kept, whatever was given, and holds the
    scalar ``slack``, and a `Law`, which holds U; ``asked`` and ``more`` are shorthand
    for requirements, see `collected`. ``gain`` is the K of `analyse_pid`; of a law that
    measures less than the state it is zero where none is given.
    """

    plant: Any
    requirements: tuple = ()
    K_A: np.ndarray | None = None
    coupling: Coupling = ONE_P
    gain: np.ndarray | None = None
    law: Any = None
    applied: Any = field(init=False)
    vertices: tuple = field(init=False)
    ground: Ground = field(init=False)
    pairs: list = field(init=False)

    def __init__(
        self,
        plant,
        U=None,
        *asked,
        K_A=None,
        coupling="pairs",
        gain=None,
        law=None,
        **more,
    ):
        """Check that plant, law, gain, coupling and requirements fit."""
        if isinstance(plant, Prepared):
            plant, K_A = plant.applied(K_A)
        plant = of_floats(checked_plant(plant))
        law = law_of(U, law)
        no_requirement("U", law.U)
        plant, law = law.on(plant)
        if K_A is not None:
            if isinstance(plant, DescriptorSystem):
                raise ValueError(LATE_SENSORS if plant.sensed else NO_MATRICES)
            K_A = matrix("K_A", K_A, (plant.m, plant.n))
        put(self, plant=plant, K_A=K_A, law=law)
        coupling, step = coupling_of(coupling).of_ticks(self.step), self.step
        put(self, applied=law.applied(plant), coupling=coupling)
        wanted = map(self.applied.asked, collected(*asked, **more))
        wanted = tuple(timed(r, step) for r in wanted)
        put(self, requirements=wanted, gain=self.applied.gain(gain))
        put(self, vertices=self.described(plant))
        put(self, ground=Ground.of(self))
        put(self, pairs=tuple(self.pairs_of(coupling)))
        if coupling.chooses:
            coupling = coupling.settled(self).of_ticks(step)
            put(self, coupling=coupling, pairs=tuple(self.pairs_of(coupling)))
        for r in self.requirements:
            sane_name(r.name)
            if not r.owns_its_kind:
                raise ValueError(
                    f"{type(r).__name__} has no kind of its own: write kind = ... into "
                    "the body of its class, and its proofs can be files"
                )
        coupling.check(self.gain)
        for r in self.requirements:
            r.check(self)
        self._check_unknowns()

    def described(self, plant):
        """The `Descriptor` of each vertex of another ``plant`` of these shapes."""
        return self.applied.vertices(plant, self.gain, self.K_A)

    @property
    def step(self):
        """The tick of a plant of discrete time, or None."""
        return getattr(self.plant, "dt", None)

    @property
    def U(self):
        """Which errors are integrated beside the whole state, (a, n), or None."""
        return self.law.U

    @cached_property
    def exact_gain(self):
        """The gain from the state to u in rationals, whatever the law."""
        return self.applied.exact_gain(self.gain)

    @cached_property
    def state_gain(self):
        """The gain from the state to u in floats."""
        return self.applied.state_gain(self.gain)

    @property
    def order(self):
        """2n + a, the number of states."""
        return len(self.vertices[0].E)

    @cached_property
    def apart(self):
        """The same with its vertices as coupling, without a slack matrix."""
        return replace(self, coupling=VerticesOnly())

    @property
    def as_in_files(self):
        """The same with the coupling that files know."""
        known = self.coupling.proof
        return self if known is self.coupling else replace(self, coupling=known)

    def with_slack(self, slack):
        """The same with another scalar of the slack matrix."""
        return replace(self, coupling=replace(self.coupling, slack=slack))

    @cached_property
    def distinct(self):
        """Indices of the vertices, without those that repeat another one."""
        return sorted(set(twins(self.ground.certain)))

    @cached_property
    def mean(self):
        """The mean vertex, or the first one: see `mean_descriptor`."""
        return mean_descriptor([self.vertices[i] for i in self.distinct])

    @cached_property
    def claims(self):
        """The `Claims` of its blocks."""
        return Claims(self)

    @cached_property
    def sizes(self):
        """The `Sizes` of P."""
        return Sizes(self)

    @property
    def at_corners(self):
        """True if the vertices are the corners of ranges, and nothing else is meant."""
        return self.plant.family is not None and self.plant.family.multi_affine

    def pairs_of(self, coupling):
        """Indices of the pairs of vertices whose blocks a ``coupling`` needs here."""
        authors = [r for r in self.requirements if not r.of_package]
        quotient = all(r.affine_in_quotient for r in self.requirements)
        pairs = coupling.pairs(self.ground.certain, quotient, self.at_corners)
        if quotient and authors:  # what is left out must be more than their word
            from .quotient import affine_in_quotient

            every = coupling.pairs(self.ground.certain, False)
            if every != pairs and not all(affine_in_quotient(r, self) for r in authors):
                return every
        return pairs

    @cached_property
    def demands(self):
        """The requirements in the order of their blocks, those with unknowns of their
        own first; stability joins.
        """
        stable, *others = self.claims.owners
        asked = {r.key: r for r in others}
        asked = asked if stable.key in asked else {stable.key: stable} | asked
        return tuple(sorted(asked.values(), key=lambda r: not r.unknowns(self)))

    @property
    def of_poles(self):
        """The `demands` that are regions of the poles, and stability, which all claim,
        where none of them implies it.
        """
        asked = [r for r in self.demands if r.pole_matrices() is not None]
        told = any(r.implies_stability for r in asked)
        return asked if told else [*asked, self.claims.stability]

    def kept_by(self, K, some):
        """True if the loops of the vertices keep ``some`` demands under ``K``."""
        return all(r.kept(r.truth(self.vertices, K, self.K_A)) > 0 for r in some)

    @cached_property
    def typical_rate(self):
        """A typical angular frequency of the closed loop, in rad/s."""
        rates = filter(None, (r.rate() for r in self.requirements))
        rank, rate = min(rates, default=(2, 1.0))
        if rank < 2:
            return rate
        A, _, _ = self.mean.state_space()
        check_time_of_eigenvalues(len(A))
        return np.abs(np.linalg.eigvals(A)).max() or rate

    def blocks(
        self, P, Y, number=floats, frame=None, V=None, levels=(), own=(), pairs=None
    ):
        """All blocks that must be positive definite, from `BlockName` to matrix, at
        ``P``, ``Y``, ``V`` in the coordinates of a ``frame`` (the plant's own without
        it) and in the arithmetic that ``number`` brings floats into. P is as
        `Coupling.given` has it, one for each vertex where there is a slack matrix;
        ``levels`` (see `Parameter`), by their names, take the requirements' places;
        ``own`` holds the requirements' own unknowns and sizes (see
        `Requirement.size_name`) by name, a size that is missing is one; ``pairs`` are
        those of the vertices whose blocks are written, all without it.

        A requirement demands G(P / s, Y / s) > 0, with G affine. Where s is an unknown
        it demands s G(P / s, Y / s) > 0, which is jointly affine in s, P, Y and s times
        its own unknowns: the constant of G is multiplied by s, nothing else changes.
        """
        loops, sizes = self.loops(P, Y, number, frame, V, levels, own)
        pairs, known = self.pairs if pairs is None else pairs, {}
        if isinstance(P, Affine) and number is floats:
            known = blocks_of_pairs(self.demands, loops, pairs)
        table = BlockTable(len(self.vertices) > 1)

        def add(blocks):
            for r, block, vertices, g in blocks:
                s = None if r is None else sizes.get(r.key)
                table.add(r, block, vertices, g if s is None else _times(g, s))

        def once(some):
            return ((r, *block) for r in some for block in r.once(loops[r.key]))

        leading = [r for r in self.demands if r.unknowns(self)]
        add(self.coupling.once(P))
        for r in self.sizes.fixing:
            s = sizes.get(r.key)
            if hasattr(s, "shape"):  # a number is known to be positive
                table.add(r, r.size_name, (), s)
        add(once(leading))
        add(self.coupling.blocks(self.demands, P, loops, pairs, known))
        add(once(r for r in self.demands if r not in leading))
        return table.named()

    def loops(self, P, Y, number, frame, V, levels, own):
        """The loop that each requirement sees and the unknown sizes, both by its key;
        ``P``, ``Y``, ``number``, ``frame``, ``V``, ``levels``, ``own``: see `blocks`.
        """
        own = dict(own)
        fixing = self.sizes.fixing
        sizes = {r.key: own.pop(r.size_name) for r in fixing if r.size_name in own}
        whole = PosedLoop(self, number, frame, P, Y, V, levels, own)
        loops = {
            r.key: _measured(whole.seen_by(r), r, sizes.get(r.key))
            for r in self.demands
        }
        return loops, sizes

    def unknowns(self, levels=()):
        """Unknowns P, Y (P alone if the gain is given), sizes, the own ones, which a
        requirement's size multiplies; with a slack matrix P 1, P 2, ..., V, Y and so
        on. ``levels`` are as in `Sizes.leader`.
        """
        unknowns = self.coupling.unknowns(twins(self.ground.certain), self.order)
        if self.gain is None:
            unknowns.append(Unknown("Y", self.plant.m, self.order))
        for r in self.sizes.followers(self.sizes.leader(levels)):
            unknowns.append(Unknown(r.size_name, 1))
        unknowns.extend(u for _, u in self.owned)
        names = [u.name for u in unknowns]
        if len(set(names)) < len(names):
            raise ValueError(f"two unknowns have one name: {names}")
        return unknowns

    @property
    def owned(self):
        """(r, u) of each own unknown u of a requirement r, as `demands` has them."""
        return [(r, u) for r in self.demands for u in r.unknowns(self)]

    def _check_unknowns(self):
        """A ValueError where a requirement's own unknown has a name that is taken."""
        for r in self.requirements:
            for name in (sane_name(u.name) for u in r.unknowns(self)):
                if RESERVED.fullmatch(name):
                    raise ValueError(
                        f"{r.words}: an unknown of its own is called {name!r}, which "
                        "is one of every problem: give it another name"
                    )

    @cached_property
    def lyapunov(self):
        """Names of the unknown Lyapunov matrices; equal vertices share one."""
        return self.coupling.lyapunov(twins(self.ground.certain))

    def in_unknowns(self, frame, number=floats, levels=(), sizes=(), pairs=None):
        """`blocks` by name in the `unknowns`, which come, too. ``frame``, ``number``,
        ``levels`` and ``pairs`` are as there; ``sizes`` has numbers for some of the
        unknown sizes.
        """
        unknowns = [u for u in self.unknowns(levels) if u.name not in sizes]
        values = {u.name: u for u in unknowns} | dict(sizes)
        return self.blocks_at(values, number, frame, levels, pairs), unknowns

    def blocks_at(self, values, number=floats, frame=None, levels=(), pairs=None):
        """`blocks` for ``values`` of the `unknowns` by name; ``number``, ``frame``,
        ``levels`` and ``pairs`` are as there.
        """
        P, Y, V, own = self.taken_apart(values, number, frame)
        return self.blocks(P, Y, number, frame, V, levels, own, pairs)

    def taken_apart(self, values, number=floats, frame=None):
        """P, Y, V and own of ``values`` by name, as `blocks` takes them with ``number``
        and ``frame``.
        """
        names = self.lyapunov
        P, of_K = [values[name] for name in names], self.coupling.divisor(values)
        values = {name: x for name, x in values.items() if name not in names}
        for name, unit in () if frame is None else frame.own.items():
            if name in values:
                values[name] = values[name] * number(np.array(unit)).item()
        V = values.pop("V", None)
        if self.gain is None:
            Y = values.pop("Y")
        else:
            K = number(self.gain)
            if frame is not None:
                K = K @ number(frame.T) / number(np.array(frame.scale)).item()
            Y = K @ of_K.T
        return self.coupling.given(P), Y, V, values

    def vertices_in(self, number, which=None):
        """Those of the indices ``which``, or all, in the arithmetic of ``number``,
        without a rounding error.
        """
        which = range(len(self.vertices)) if which is None else which
        return [self.vertices[k].map(number) for k in which]

    def __getstate__(self):  # what is made again isn't stored
        return {k: x for k, x in vars(self).items() if k not in MADE_AGAIN}

    def owner(self, name):
        """The requirement that a parameter of this name belongs to."""
        owners = (r for r in self.requirements if r.parameter is not None)
        return next(r for r in owners if r.parameter.key == name)

    def with_bounds(self, values):
        """The request with other bounds, the ``values`` of parameters by name."""
        return replace(self, requirements=moved(self.requirements, values))

    def untied(self):
        """The request in which each requirement's P has its own size."""
        return replace(self, requirements=tuple(r.untied() for r in self.requirements))

    def without(self, one):
        """The request less one requirement: the object or its name."""
        gone = [r for r in self.requirements if r is one or r.name == one]
        if len(gone) > 1:
            raise ValueError(
                f"{len(gone)} requirements are called {one!r}: give the object instead"
            )
        rest = tuple(r for r in self.requirements if r not in gone)
        return replace(self, requirements=rest)

    @property
    def names(self):
        """Names that `without` takes."""
        return [r.name for r in self.requirements]


def _measured(loop, r, size):
    """The loop as a requirement sees it, in coordinates of its own."""
    if size is None:
        return loop
    unit = 1.0 if loop.frame is None else loop.frame.sizes.get(r.size_name, 1.0)
    if isinstance(size, Affine):
        return loop.measured(unit)
    return loop.measured(unit, np.asarray(size).item())


def _times(g, size):
    """s G(X / s) of an affine G(X) in unknowns; G itself where the size is a number."""
    if isinstance(size, Affine):
        return Affine(0 * g.constant, g.terms) + size * g.constant
    return g
