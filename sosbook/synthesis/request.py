"""A plant and what is asked of its loop, as LMI blocks."""

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from ..exact.definite import exact
from ..language import Affine
from ..lmi.text import floats
from ..plants.checks import matrix
from ..plants.coupling import Coupling, OneP, VerticesOnly, coupling_of
from ..plants.descriptor import Descriptor, descriptors, mean_descriptor, twins
from ..plants.descriptor_system import DescriptorSystem
from ..plants.gain import gain_of
from ..plants.kinds import Prepared, checked_plant
from ..plants.near_box import NearBox
from ..requirements.blocks import BlockTable
from ..requirements.posed import OnDemand, PosedLoop
from ..requirements.shorthand import Shorthand, collected, moved, no_requirement
from ..runtime.names import sane_name
from ..runtime.read_only import ReadOnly, put
from .derived import Derived
from .pair_stacks import blocks_of_pairs

ONE_P = OneP()


@dataclass(frozen=True, eq=False, init=False)
class Request(Shorthand, Derived, ReadOnly):
    """A plant and what is asked of its loop; makes the LMI blocks. ``plant``, ``U``,
    ``K_A``, ``coupling``, ``slack`` and ``law`` are as in `design_pid`, where "auto" is
    the first that it tries; a `Coupling` is kept, whatever was given, and holds the
    scalar ``slack``; ``asked`` and ``more`` are shorthand for requirements, see
    `collected`. ``gain``, (m, N), is the K of `analyse_pid`; with a law it is what
    multiplies its signals, zero where none is given.
    """

    plant: Any
    U: np.ndarray | None = None
    requirements: tuple = ()
    K_A: np.ndarray | None = None
    coupling: Coupling = ONE_P
    gain: np.ndarray | None = None
    law: Any = None
    vertices: tuple = field(init=False)
    near: NearBox | None = field(init=False)
    pairs: list = field(init=False)

    def __init__(
        self,
        plant,
        U=None,
        *asked,
        K_A=None,
        coupling="pairs",
        slack=None,
        gain=None,
        law=None,
        **more,
    ):
        """Check that plant, law, gain, coupling and requirements fit."""
        if isinstance(plant, Prepared):
            plant, K_A = plant.applied(K_A)
        plant = checked_plant(plant)
        no_requirement("U", U)
        if not isinstance(plant, DescriptorSystem):  # which takes neither
            U = None if U is None else matrix("U", U, (None, plant.n))
            K_A = None if K_A is None else matrix("K_A", K_A, (plant.m, plant.n))
        coupling = coupling_of(coupling, slack)
        wanted = collected(*asked, **more)
        if law is not None:
            plant, law = law.on(plant)
            if K_A is not None and isinstance(plant, DescriptorSystem):
                raise ValueError(
                    "K_A is given with a law of late sensors: leave one out"
                )
        put(self, plant=plant, U=U, K_A=K_A, coupling=coupling, law=law)
        if law is not None:
            wanted = tuple(map(self.of_loop, wanted))
        put(self, requirements=wanted)
        if law is not None:
            gain = law.gain(plant, gain)
        elif isinstance(plant, DescriptorSystem):
            self._check_system(gain)
        put(self, gain=gain)
        put(self, vertices=self.described(plant))
        put(self, near=self._near_box())
        put(self, pairs=tuple(self._pairs_of(coupling)))
        if coupling.chooses:
            coupling = coupling.settled(self)
            put(self, coupling=coupling, pairs=tuple(self._pairs_of(coupling)))
        for r in self.requirements:
            sane_name(r.name)
            if not r.owns_its_kind:
                raise ValueError(
                    f"{type(r).__name__} has no kind of its own: write kind = ... into "
                    "the body of its class, and its proofs can be files"
                )
        if law is None and gain is not None:
            gain = matrix("K", gain_of(gain, plant, U), (plant.m, self.order))
        coupling.check(gain)
        put(self, gain=gain)
        for r in self.requirements:
            r.check(self)
        self._check_unknowns()

    def _check_system(self, gain):
        if self.U is not None or self.K_A is not None:
            raise ValueError(
                "a DescriptorSystem takes no U and no K_A: put them into its matrices"
            )
        if self.plant.m == 0 and gain is None:
            raise ValueError(
                "plant has no B, so there is nothing to design: give B, "
                "or analyse the loop as it is, analyse_pid(plant)"
            )

    def described(self, plant):
        """The `Descriptor` of each vertex of another ``plant`` of these shapes."""
        if self.law is not None:
            return self.law_parts.vertices(plant, self.gain, self.K_A)
        if isinstance(plant, Descriptor):
            return (plant,)
        if isinstance(plant, DescriptorSystem):
            return plant.vertices
        return descriptors(plant, self.U, self.K_A)

    @cached_property
    def law_parts(self):
        """The matrices that the law joins to the plant."""
        return self.law.parts(self.plant)

    def of_loop(self, r):
        """The requirement on the loop with the law that a requirement ``r`` of the
        plant makes.
        """
        from ..plants.sensed import asked_of

        return asked_of(self.plant, r).joined(self.law_parts)

    @cached_property
    def exact_gain(self):
        """The gain from the state to u in rationals, whatever the law."""
        K = exact(self.gain)
        return K if self.law is None else self.law_parts.state_gain(K)

    @cached_property
    def state_gain(self):
        """The gain from the state to u in floats."""
        return self.gain if self.law is None else self.exact_gain.astype(float)

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
        return sorted(set(twins(self.certain)))

    @cached_property
    def mean(self):
        """The mean vertex, or the first one: see `mean_descriptor`."""
        return mean_descriptor([self.vertices[i] for i in self.distinct])

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
        for r in self.sized:
            s = sizes.get(r.key)
            if hasattr(s, "shape"):  # a number is known to be positive
                table.add(r, r.size_name, (), s)
        add(once(leading))
        add(self.coupling.blocks(self.demands, P, loops, pairs, known))
        add(once(r for r in self.demands if r not in leading))
        return table.named()

    def loops(self, P, Y, number, frame, V, levels, own):
        """The loop that each requirement sees and the unknown sizes in ``own``, both by
        the requirement's key. ``P``, ``Y``,
        ``number``, ``frame``, ``V``, ``levels`` and ``own`` are as in `blocks`.
        """
        own = dict(own)
        sizes = {r.key: own.pop(r.size_name) for r in self.sized if r.size_name in own}
        whole = PosedLoop(self, number, frame, P, Y, V, levels, own)
        loops = {
            r.key: _measured(whole.seen_by(r), r, sizes.get(r.key))
            for r in self.demands
        }
        return loops, sizes

    def vertices_in(self, number, which=None):
        """Those of the indices ``which``, or all, in the arithmetic of ``number``,
        without a rounding error.
        """
        which = range(len(self.vertices)) if which is None else which
        return [self.vertices[k].map(number) for k in which]

    def vertices_at(self, frame, number=floats):
        """The vertices in the coordinates of a ``frame``, or in the plant's own: in
        floats made once for each frame, in another arithmetic of ``number`` those that
        are asked for.
        """
        if number is floats and frame in self._moved:
            return self._moved[frame]
        factors = () if frame is None else (frame.left, frame.T, frame.scale)
        factors = [number(np.array(f)) for f in factors]

        def make(k):
            d = self.ground[k].map(number)
            if frame is None:
                return d
            left, T, scale = factors
            return d.change(left, T, scale.item())

        made = OnDemand(make, len(self.vertices))
        return self._moved.setdefault(frame, list(made)) if number is floats else made

    @cached_property
    def _moved(self):
        return {}

    def __getstate__(self):  # what is made again isn't stored
        return {k: x for k, x in vars(self).items() if k not in ("_moved", "apart")}

    def owner(self, name):
        """The requirement that a parameter of this name belongs to."""
        owners = (r for r in self.requirements if r.parameter is not None)
        return next(r for r in owners if r.parameter.key == name)

    def with_bounds(self, values):
        """The request with other bounds, the ``values`` of parameters by name."""
        return replace(self, requirements=moved(self.requirements, values))

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
