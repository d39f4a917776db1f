"""A plant and what is asked of its loop, as LMI blocks."""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from ..lmi import Unknown
from ..plants.checks import matrix, positive, rank_deficient
from ..plants.descriptor import (
    Coupled,
    SlackVertex,
    coupled_pairs,
    descriptors,
    mean_descriptor,
)
from ..plants.descriptor_system import DescriptorSystem
from ..plants.second_order import Polytope, SecondOrderSystem
from ..requirements.base import BlockTable
from ..requirements.loop import Loop
from ..requirements.shorthand import Shorthand, collected, moved
from ..requirements.stability import Stability

__all__ = ["Request"]


@dataclass(frozen=True, eq=False, init=False)
class Request(Shorthand):
    """A plant and what is asked of its loop; makes the LMI blocks.

    Parameters
    ----------
    plant, U, K_A, coupling, slack
        As in `design_pid`.
    requirements : sequence of Requirement
    gain : (m, N) array_like, optional
        The K of `analyse_pid`.
    asked, more
        The other keywords of `design_pid` that ask something: shorthand
        for requirements, see `collected`.
    """

    plant: object
    U: np.ndarray = None
    requirements: tuple = ()
    K_A: np.ndarray = None
    coupling: str = "pairs"
    slack: float = None
    gain: np.ndarray = None
    vertices: tuple = field(init=False)
    pairs: list = field(init=False)

    def __init__(self, plant, U=None, *asked, K_A=None, coupling="pairs",
                 slack=None, gain=None, **more):
        if not isinstance(plant, (SecondOrderSystem, Polytope, DescriptorSystem)):
            raise ValueError(
                "plant must be a SecondOrderSystem, a Polytope of them or "
                f"a DescriptorSystem, got {type(plant).__name__}"
            )
        for name, value in dict(
                plant=plant, U=U, requirements=collected(*asked, **more),
                K_A=K_A, coupling=coupling).items():
            object.__setattr__(self, name, value)
        vertices = self._descriptors(gain)
        pairs = coupled_pairs(vertices, coupling)
        object.__setattr__(self, "vertices", vertices)
        object.__setattr__(self, "pairs", pairs)
        if slack is not None:
            slack = positive("slack", slack)
            if coupling != "slack":
                raise ValueError(
                    'slack is given, but coupling is not "slack": leave one '
                    "out"
                )
        for r in self.requirements:
            r.check(self)
        if gain is not None:
            gain = matrix("K", gain, (plant.m, self.order))
        object.__setattr__(self, "slack", slack)
        object.__setattr__(self, "gain", gain)

    def _descriptors(self, gain):
        plant = self.plant
        if not isinstance(plant, DescriptorSystem):
            return descriptors(plant, self.U, self.K_A)
        if self.U is not None or self.K_A is not None:
            raise ValueError(
                "a DescriptorSystem takes no U and no K_A: put them "
                "into its matrices"
            )
        if plant.m == 0 and gain is None:
            raise ValueError(
                "plant has no B, so there is nothing to design: give B, "
                "or analyse the loop with analyse_loop(E, A)"
            )
        return plant.vertices

    @property
    def order(self):
        """2n + a, the number of states."""
        return len(self.vertices[0].E)

    @cached_property
    def mean(self):
        """The mean vertex, or the first one: see `mean_descriptor`."""
        return mean_descriptor(self.vertices)

    @property
    def covers_polytope(self):
        """Whether the blocks say something about the whole polytope."""
        if self.coupling == "slack":
            return True
        whole = coupled_pairs(self.vertices, "pairs")
        return len(self.pairs) == len(whole)

    def fixed_modes(self):
        """Modes that no gain moves and that break a requirement.

        Returns
        -------
        array of complex
            Uncontrollable eigenvalues of a vertex, in rad/s, that lie
            right of or on the imaginary axis or outside the region.
        """
        bad = []
        for d in self.vertices if self.gain is None else ():
            A, B, _ = d.state_space()
            for s in np.linalg.eigvals(A):
                pencil = np.hstack([A - s * np.eye(len(A)), B])
                inside = all(r.admits(s) for r in self.requirements)
                if rank_deficient(pencil) and not (inside and s.real < 0):
                    bad.append(s)
        return np.array(bad)

    @cached_property
    def demands(self):
        """The requirements in the order of their blocks; stability joins.

        Those with unknowns of their own come first.
        """
        asked = sorted(self.requirements, key=lambda r: not r.unknowns(self))
        if not any(r.implies_stability for r in asked):
            leading = sum(bool(r.unknowns(self)) for r in asked)
            asked.insert(leading, Stability())
        return tuple(asked)

    def blocks(self, P, Y, number=lambda x: x, frame=None, V=None, levels=(),
               own=()):
        """All blocks that must be positive definite, by name.

        Parameters
        ----------
        P, Y : matrix-like
            In any arithmetic that the theorems can be read in. With
            ``coupling="slack"`` P is a sequence, one for each vertex.
        number : callable
            Brings floats into that arithmetic.
        frame : Frame, optional
            Coordinates of P, V and Y; the plant's own without it.
        V : matrix-like, optional
            The slack matrix.
        levels : dict, optional
            Levels (see `Parameter`) by the parameter's name that take the
            place of the requirements', scalars or 1 x 1 matrix-like.
        own : dict, optional
            The requirements' own unknowns by name.

        Returns
        -------
        dict
            From `BlockName` to matrix.
        """
        loop = Loop(self, number, frame, P, Y, V, levels, own)
        table = BlockTable(len(self.vertices) > 1)
        leading = [r for r in self.demands if r.unknowns(self)]
        slack = self.coupling == "slack"
        if not slack:
            table.add(None, "P", (), P)
        self._once(table, loop, leading)
        for i, j in self.pairs:
            if slack:
                c = SlackVertex(loop.vertices[i], loop.E0, P[i], V, Y)
                table.add(None, "P", (i,), P[i])
            else:
                c = Coupled(loop.vertices[i], loop.vertices[j], P, Y)
            for r in self.demands:
                made = r.slack(loop, c, i) if slack else r.pair(loop, c)
                for block, g in made:
                    table.add(r, block, (i, j), g)
        self._once(table, loop, [r for r in self.demands if r not in leading])
        return table.named()

    def _once(self, table, loop, requirements):
        for r in requirements:
            for block, vertices, g in r.once(loop):
                table.add(r, block, vertices, g)

    def vertices_in(self, number):
        """The vertices in an arithmetic, without a rounding error."""
        vertices = [d.map(number) for d in self.vertices]
        if self.K_A is not None:
            K_A, n = number(np.array(self.K_A, float)), self.plant.n
            for d, v in zip(vertices, self.plant.vertices):
                inertia = number(v.M) - number(v.B) @ K_A
                d.E[n:2 * n, n:2 * n] = inertia
        return vertices

    def unknowns(self):
        """Unknowns P, Y (P alone if the gain is given) and the own ones.

        With ``coupling="slack"`` P 1, P 2, ..., V, Y and the own ones.
        """
        N, q = self.order, len(self.vertices)
        found = [Unknown(name, N, symmetric=True) for name in self.lyapunov]
        if self.coupling == "slack":
            found.append(Unknown("V", N, N))
        if self.gain is None:
            found.append(Unknown("Y", self.plant.m, N))
        for r in self.demands:
            found.extend(r.unknowns(self))
        names = [u.name for u in found]
        if len(set(names)) < len(names):
            raise ValueError(f"two unknowns have one name: {names}")
        return found

    @property
    def lyapunov(self):
        """Names of the unknown Lyapunov matrices."""
        if self.coupling != "slack":
            return ("P",)
        return tuple(f"P {i + 1}" for i in range(len(self.vertices)))

    def in_unknowns(self, frame, number=lambda x: x, levels=()):
        """`blocks` in the `unknowns`.

        Returns
        -------
        dict, list of Unknown
        """
        unknowns = self.unknowns()
        values = {u.name: u for u in unknowns}
        return self.blocks_at(values, number, frame, levels), unknowns

    def blocks_at(self, values, number=lambda x: x, frame=None, levels=()):
        """`blocks` for values of the `unknowns`, by name."""
        values = dict(values)
        P = [values.pop(name) for name in self.lyapunov]
        V = values.pop("V", None)
        if self.coupling != "slack":
            (P,) = P
        if self.gain is None:
            Y = values.pop("Y")
        else:
            K = number(self.gain)
            if frame is not None:
                scale = number(np.array(frame.scale)).item()
                K = K @ number(frame.T) / scale
            Y = K @ (P if V is None else V).T
        return self.blocks(P, Y, number, frame, V, levels, values)

    def own_units(self, frame):
        """In which the requirements' own unknowns are measured, by name."""
        return {u.name: r.own_unit(self, frame)
                for r in self.demands for u in r.unknowns(self)}

    def with_bounds(self, values):
        """The request with other bounds, by the parameters' names."""
        return replace(self, requirements=moved(self.requirements, values))

    def without(self, one):
        """The request less one requirement: the object or its name."""
        gone = [r for r in self.requirements if r is one or r.name == one]
        if len(gone) > 1:
            raise ValueError(
                f"{len(gone)} requirements are called {one!r}: give the "
                "object instead")
        return replace(self, requirements=tuple(
            r for r in self.requirements if r not in gone))

    @property
    def names(self):
        """Names that `without` takes."""
        return [r.name for r in self.requirements]
