"""A plant and what is asked of its loop, as LMI blocks."""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from ..lmi import Unknown, eye, he
from ..lmi.exact import inverse
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
from ..requirements.cost import QuadraticCost, noise_input
from ..requirements.input_bound import Saturation
from ..requirements.pole_region import Region
from ..theorems import (
    bounded_real,
    control_bound,
    initial_state,
    lqr_cost,
    lqr_decay,
    pole_region,
    slack_bounded_real,
    slack_initial_state,
    slack_lqr_decay,
    slack_pole_region,
    slack_stability,
    stability,
)
from ..theorems.lqr import trace_bound

__all__ = ["Request"]


@dataclass(frozen=True, eq=False)
class Request:
    """A plant and what is asked of its loop; makes the LMI blocks.

    Parameters are those of `design_pid`; ``gain`` is the K of
    `analyse_pid`, or None.
    """

    plant: object
    U: np.ndarray = None
    region: Region = None
    gamma: float = None
    saturation: Saturation = None
    K_A: np.ndarray = None
    coupling: str = "pairs"
    mu: float = 1.0
    slack: float = None
    gain: np.ndarray = None
    cost: QuadraticCost = None
    vertices: tuple = field(init=False)
    pairs: list = field(init=False)

    def __post_init__(self):
        if not isinstance(self.plant, (SecondOrderSystem, Polytope, DescriptorSystem)):
            raise ValueError(
                "plant must be a SecondOrderSystem, a Polytope of them or "
                "a DescriptorSystem, got "
                f"{type(self.plant).__name__}"
            )
        if not isinstance(self.region, (Region, type(None))):
            raise ValueError(
                "region must be a PoleRegion or an LMIRegion, got "
                f"{type(self.region).__name__}"
            )
        if not isinstance(self.saturation, (Saturation, type(None))):
            raise ValueError("saturation must be a Saturation(u_max, x0)")
        if self.saturation is not None and self.saturation.u_max is None:
            raise ValueError(
                "saturation: u_max is None: give a number, or let "
                'minimize="u_max" find it'
            )
        if self.gamma is not None:
            gamma = positive("gamma", self.gamma)
            object.__setattr__(self, "gamma", gamma)
            if self.plant.p == 0:
                raise ValueError(
                    "gamma is given but the plant has no F: say where "
                    "the disturbance enters"
                )
        if not isinstance(self.cost, (QuadraticCost, type(None))):
            raise ValueError("cost must be a QuadraticCost(Q, R)")
        if isinstance(self.plant, DescriptorSystem):
            if self.U is not None or self.K_A is not None:
                raise ValueError(
                    "a DescriptorSystem takes no U and no K_A: put them "
                    "into its matrices"
                )
            vertices = self.plant.vertices
            if self.plant.m == 0 and self.gain is None:
                raise ValueError(
                    "plant has no B, so there is nothing to design: give B, "
                    "or analyse the loop with analyse_loop(E, A)"
                )
        else:
            vertices = descriptors(self.plant, self.U, self.K_A)
        object.__setattr__(self, "vertices", vertices)
        object.__setattr__(
            self, "pairs", coupled_pairs(vertices, self.coupling)
        )
        object.__setattr__(self, "mu", positive("mu", self.mu))
        if self.slack is not None:
            object.__setattr__(self, "slack", positive("slack", self.slack))
            if self.coupling != "slack":
                raise ValueError(
                    'slack is given, but coupling is not "slack": leave one '
                    "out"
                )
        if self.saturation is not None and self.saturation.acceleration:
            first = vertices[0].E
            if any(not np.array_equal(d.E, first) for d in vertices):
                raise ValueError(
                    "saturation: acceleration=True needs the same M - B K_A "
                    "at every vertex; bound K x only"
                )
        if self.saturation is not None and len(
            self.saturation.x0
        ) != self.order:
            raise ValueError(
                f"x0 has {len(self.saturation.x0)} entries, needs "
                f"2n + a = {self.order}: [z(0); z'(0); x3(0)]"
            )
        if self.cost is not None:
            matrix("Q", self.cost.Q, (self.order, self.order))
            matrix("R", self.cost.R, (self.plant.m, self.plant.m))
            if self.cost.noise == "F" and self.plant.p == 0:
                raise ValueError(
                    'noise="F", but the plant has no F: take "states"')
            if self.cost.bound is None:
                raise ValueError(
                    "cost: bound is None: give a number, or let "
                    'minimize="cost" or design_lqr find it'
                )
        if self.gain is not None:
            shape = (self.plant.m, self.order)
            object.__setattr__(self, "gain", matrix("K", self.gain, shape))

    @property
    def order(self):
        """2n + a, the number of states."""
        return len(self.vertices[0].E)

    @cached_property
    def mean(self):
        """The mean vertex, or the first one: see `mean_descriptor`."""
        return mean_descriptor(self.vertices)

    @property
    def parts(self):
        """The parts of the region."""
        return () if self.region is None else self.region.parts

    @property
    def covers_polytope(self):
        """Whether the blocks say something about the whole polytope."""
        if self.coupling == "slack":
            return True
        whole = coupled_pairs(self.vertices, "pairs")
        return len(self.pairs) == len(whole)

    @property
    def tags(self):
        """The ends of block names, one for each pair of vertices."""
        return [self._tag(i, j) for i, j in self.pairs]

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
                inside = self.region is None or self.region.contains(s)
                if rank_deficient(pencil) and not (inside and s.real < 0):
                    bad.append(s)
        return np.array(bad)

    @property
    def needs_stability(self):
        """Whether no other block already demands Re s < 0."""
        return self.gamma is None and self.cost is None and not any(
            part.implies_stability for part in self.parts
        )

    def blocks(self, P, Y, gamma2, number=lambda x: x, frame=None, V=None,
               squares=(), J=None):
        """All blocks that must be positive definite, by name.

        Parameters
        ----------
        P, Y : matrix-like
            In any arithmetic that the theorems can be read in. With
            ``coupling="slack"`` P is a sequence, one for each vertex.
        gamma2 : scalar or 1 x 1 matrix-like
            Square of the H-infinity bound; unused without one.
        number : callable
            Brings floats into that arithmetic.
        frame : Frame, optional
            Coordinates of P, V and Y; the plant's own without it.
        V : matrix-like, optional
            The slack matrix.
        squares : dict, optional
            Squares of "gamma" and "u_max", and the bound of "cost", that
            take the place of those in the request, scalars or 1 x 1
            matrix-like.
        J : matrix-like, optional
            Of Theorem 2.4, where there is a cost.
        """
        squares = dict(squares)
        gamma2 = squares.get("gamma", gamma2)
        data = self._data(number, frame, squares.get("u_max"))
        if self.cost is not None:
            data.J, data.bound = J, squares.get("cost", data.bound)
        if self.coupling == "slack":
            return self._slack_blocks(data, P, V, Y, gamma2, number)
        found = {"P": P}
        if self.cost is not None:
            found["trace"] = trace_bound(J, data.bound)
            if self.cost.noise == "states":
                found["cost"] = lqr_cost(data.near(P), data.one, J)
        for i, j in self.pairs:
            c = Coupled(data.vertices[i], data.vertices[j], P, Y)
            tag = self._tag(i, j)
            if self.cost is not None:
                found["lqr" + tag] = lqr_decay(c, *data.weights)
                if self.cost.noise == "F":
                    found["cost" + tag] = lqr_cost(
                        c.EPE, c.Bw / data.unit, J)
            if self.needs_stability:
                found["stability" + tag] = stability(c)
            for part in self.parts:
                found[part.name + tag] = pole_region(
                    c, number(part.alpha), number(part.beta)
                )
            if self.gamma is not None:
                found["hinf" + tag] = bounded_real(c, gamma2, data.mu)
        if self.saturation is not None:
            found["x0"] = initial_state(data.near(P), data.x0)
            for tag, of_x, of_v in data.signals:
                found["u_max" + tag] = control_bound(
                    P, of_x @ P + of_v @ Y, data.u_max2
                )
        return found

    def _slack_blocks(self, data, P, V, Y, gamma2, number):
        found = {}
        if self.cost is not None:
            found["trace"] = trace_bound(data.J, data.bound)
        epsilon = number(np.array(self.slack)).item()
        for i, d in enumerate(data.vertices):
            c = SlackVertex(d, data.E0, P[i], V, Y)
            tag = self._tag(i, i)
            found["P" + tag] = P[i]
            if self.cost is not None:
                inner, noise = he(c.EVE) - c.EPE, c.Bw / data.unit
                if self.cost.noise == "states":
                    inner = he(data.near(V)) - data.near(P[i])
                    noise = data.one
                found["cost" + tag] = lqr_cost(inner, noise, data.J)
                found["lqr" + tag] = slack_lqr_decay(
                    c, *data.weights, epsilon)
            if self.needs_stability:
                found["stability" + tag] = slack_stability(c, epsilon)
            for part in self.parts:
                found[part.name + tag] = slack_pole_region(
                    c, number(part.alpha), number(part.beta), epsilon
                )
            if self.gamma is not None:
                found["hinf" + tag] = slack_bounded_real(
                    c, gamma2, data.mu, epsilon
                )
            if self.saturation is not None:
                found["x0" + tag] = slack_initial_state(
                    data.near(P[i]), data.near(V), data.x0
                )
                _, of_x, of_v = data.signals[i % len(data.signals)]
                found["u_max" + tag] = control_bound(
                    P[i], of_x @ V.T + of_v @ Y, data.u_max2
                )
        return found

    def _data(self, number, frame, u_max2=None):
        """The plant and the bounds in an arithmetic and a frame."""
        vertices = [d.map(number) for d in self.vertices]
        if self.K_A is not None:  # M - B K_A without a rounding error
            K_A, n = number(np.array(self.K_A, float)), self.plant.n
            for d, v in zip(vertices, self.plant.vertices):
                inertia = number(v.M) - number(v.B) @ K_A
                d.E[n:2 * n, n:2 * n] = inertia
        data = _Data(vertices, number(self.mean.E))
        if self.cost is not None:
            data.one = eye(self.order)
            data.weights = self.cost.factors()
            if number(np.array([1.0])).dtype != object:
                data.weights = [w.astype(float) for w in data.weights]
            if self.cost.bound is not None:
                data.bound = number(np.array(self.cost.bound)).item()
        data.mu = number(np.array(self.mu)).item()
        if self.saturation is not None:
            data.x0 = number(self.saturation.x0)
            if u_max2 is None:
                bound = number(np.array(self.saturation.u_max))
                u_max2 = bound.item() ** 2
            data.u_max2 = u_max2
            data.signals = self._signals(vertices, number)
        if frame is not None:
            data.change(*(
                number(np.array(f))
                for f in (frame.left, frame.T, frame.back, frame.scale)
            ))
            if self.cost is not None:
                unit = self.noise_unit(frame)
                data.measure(number(np.array(unit)).item())
        return data

    def noise_unit(self, frame):
        """A power of two near the size of the noise in a frame.

        There J is measured in its square.
        """
        size = np.linalg.norm(
            frame.back @ noise_input(self.mean, self.cost), 2)
        return float(2.0 ** np.round(np.log2(size or 1.0)))

    def _signals(self, vertices, number):
        """(tag, G_x, G_v): the bounded signal is G_x x + G_v K x."""
        n, m = self.plant.n, self.plant.m
        if self.K_A is None or not self.saturation.acceleration:
            return [("", np.zeros((m, self.order), int), eye(m))]
        K_A, found = number(np.array(self.K_A, float)), []
        for i, d in enumerate(vertices):  # z'' = E2^-1 (.. x + B K x)
            answer = K_A @ inverse(d.E[n:2 * n, n:2 * n])
            found.append((
                self._tag(i, i), answer @ d.A[n:2 * n],
                answer @ d.Bu[n:2 * n] + eye(m),
            ))
        return found

    def in_unknowns(self, frame, gamma2, number=lambda x: x, squares=()):
        """`blocks` in unknowns P, Y (P alone if the gain is given).

        With ``coupling="slack"`` in P 1, P 2, ..., V, Y.

        Returns
        -------
        dict, list of Unknown
        """
        N, q = self.order, len(self.vertices)
        if self.coupling == "slack":
            P = [Unknown(f"P {i + 1}", N, symmetric=True) for i in range(q)]
            V = Unknown("V", N, N)
            unknowns = [*P, V]
        else:
            P = V = Unknown("P", N, symmetric=True)
            unknowns = [P]
        if self.gain is None:
            Y = Unknown("Y", self.plant.m, N)
            unknowns.append(Y)
        else:
            scale = number(np.array(frame.scale)).item()
            Y = (number(self.gain) @ number(frame.T) / scale) @ V.T
        J = None
        if self.cost is not None:
            channels = self.order if self.cost.noise == "states" else (
                self.plant.p)
            J = Unknown("J", channels, symmetric=True)
            unknowns.append(J)
        blocks = self.blocks(P, Y, gamma2, number, frame, V, squares, J)
        return blocks, unknowns

    def _tag(self, i, j):
        if len(self.vertices) == 1:
            return ""
        return f" {i + 1}" if i == j else f" {i + 1},{j + 1}"

    def without(self, name):
        """The request less one requirement."""
        if name == "gamma":
            return replace(self, gamma=None)
        if name == "saturation":
            return replace(self, saturation=None)
        if name == "cost":
            return replace(self, cost=None)
        rest = tuple(p for p in self.parts if p.name != name)
        return replace(self, region=Region(rest) if rest else None)

    @property
    def requirements(self):
        """Names that `without` takes."""
        names = [part.name for part in self.parts]
        if self.gamma is not None:
            names.append("gamma")
        if self.saturation is not None:
            names.append("saturation")
        if self.cost is not None:
            names.append("cost")
        return names


class _Data:
    """Vertices and bounds in one arithmetic and one frame."""

    def __init__(self, vertices, E0):
        self.vertices, self.E0 = vertices, E0
        self.mu = self.x0 = self.u_max2 = self.signals = self.back = None
        self.one = self.weights = self.bound = self.J = None
        self.unit = 1

    def change(self, left, T, back, scale):
        scale = scale.item()
        self.vertices = [d.change(left, T, scale) for d in self.vertices]
        self.E0 = left @ self.E0 @ T
        if self.weights is not None:
            L, W, V = self.weights
            self.one, self.back = back, back @ T
            self.weights = T.T @ L, W, V / scale**2
        if self.signals is not None:
            self.signals = [
                (tag, of_x @ T / scale, of_v) for tag, of_x, of_v in self.signals
            ]
            self.u_max2 = self.u_max2 / scale**2
            self.x0 = back @ self.x0
            self.back = back @ T  # back is T's inverse, up to rounding

    def measure(self, unit):
        """Measure the noise in a unit."""
        self.unit = unit
        if self.bound is not None:
            self.bound = self.bound / unit**2
        self.one = self.one / unit

    def near(self, P):
        """P where x0 is compared with it."""
        return P if self.back is None else self.back @ P @ self.back.T
