"""A plant and what is asked of its loop, as LMI blocks."""

from dataclasses import dataclass, field, replace

import numpy as np
from scipy.linalg import cholesky, solve_continuous_are

from .descriptor import Coupled, Descriptor, coupled_pairs, descriptors
from .lmi import Unknown
from .lmi.certificate import round_digits
from .regions import Region
from .system import (
    Polytope,
    SecondOrderSystem,
    matrix,
    positive,
    rank_deficient,
)
from .theorems import (
    bounded_real,
    control_bound,
    initial_state,
    pole_region,
    stability,
)

__all__ = ["Frame", "Request", "Saturation"]


@dataclass(frozen=True, eq=False)
class Saturation:
    """The requirement |K x(t)| <= u_max from x(0) = x0 (Lemma 2.2).

    Parameters
    ----------
    u_max : float
        Bound of the Euclidean norm of K x, in the unit of u.
    x0 : (N,) array_like
        Initial state [z(0); z'(0); x3(0)].
    """

    u_max: float
    x0: np.ndarray

    def __post_init__(self):
        u_max = positive("u_max", self.u_max)
        if np.ndim(self.x0) != 1:
            raise ValueError("x0 must be a vector of finite numbers")
        x0 = matrix("x0", [self.x0])[0]
        object.__setattr__(self, "x0", x0)
        object.__setattr__(self, "u_max", u_max)


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
    gain: np.ndarray = None
    vertices: tuple = field(init=False)
    pairs: list = field(init=False)

    def __post_init__(self):
        if not isinstance(self.plant, (SecondOrderSystem, Polytope)):
            raise ValueError(
                "plant must be a SecondOrderSystem or a Polytope, got "
                f"{type(self.plant).__name__}"
            )
        if not isinstance(self.region, (Region, type(None))):
            raise ValueError(
                "region must be a PoleRegion or an LMIRegion, got "
                f"{type(self.region).__name__}"
            )
        if not isinstance(self.saturation, (Saturation, type(None))):
            raise ValueError("saturation must be a Saturation(u_max, x0)")
        if self.gamma is not None:
            gamma = positive("gamma", self.gamma)
            object.__setattr__(self, "gamma", gamma)
            if self.plant.p == 0:
                raise ValueError(
                    "gamma is given but the plant has no F: say where "
                    "the disturbance enters"
                )
        vertices = descriptors(self.plant, self.U, self.K_A)
        object.__setattr__(self, "vertices", vertices)
        object.__setattr__(
            self, "pairs", coupled_pairs(vertices, self.coupling)
        )
        if self.saturation is not None and len(
            self.saturation.x0
        ) != self.order:
            raise ValueError(
                f"x0 has {len(self.saturation.x0)} entries, needs "
                f"2n + a = {self.order}: [z(0); z'(0); x3(0)]"
            )
        if self.gain is not None:
            shape = (self.plant.m, self.order)
            object.__setattr__(self, "gain", matrix("K", self.gain, shape))

    @property
    def order(self):
        """2n + a, the number of states."""
        return len(self.vertices[0].E)

    @property
    def parts(self):
        """The parts of the region."""
        return () if self.region is None else self.region.parts

    @property
    def covers_polytope(self):
        """Whether the blocks say something about the whole polytope."""
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
                inside = self.region is None or self.region.contains(s)
                if rank_deficient(pencil) and not (inside and s.real < 0):
                    bad.append(s)
        return np.array(bad)

    @property
    def needs_stability(self):
        """Whether no other block already demands Re s < 0."""
        return self.gamma is None and not any(
            part.implies_stability for part in self.parts
        )

    def blocks(self, P, Y, gamma2, number=lambda x: x, frame=None):
        """All blocks that must be positive definite, by name.

        Parameters
        ----------
        P, Y : matrix-like
            In any arithmetic that the theorems can be read in.
        gamma2 : scalar or 1 x 1 matrix-like
            Square of the H-infinity bound; unused without one.
        number : callable
            Brings floats into that arithmetic.
        frame : Frame, optional
            Coordinates of P and Y; the plant's own without it.
        """
        vertices = [d.map(number) for d in self.vertices]
        if self.K_A is not None:  # M - B K_A without a rounding error
            K_A, n = number(np.array(self.K_A, float)), self.plant.n
            for d, v in zip(vertices, self.plant.vertices):
                inertia = number(v.M) - number(v.B) @ K_A
                d.E[n:2 * n, n:2 * n] = inertia
        scale, x0 = 1, None
        if self.saturation is not None:
            x0 = number(self.saturation.x0)
            u_max = number(np.array(self.saturation.u_max)).item()
        if frame is not None:
            left, T, back = (
                number(f) for f in (frame.left, frame.T, frame.back)
            )
            scale = number(np.array(frame.scale)).item()
            vertices = [d.change(left, T, scale) for d in vertices]
        found = {"P": P}
        for i, j in self.pairs:
            c = Coupled(vertices[i], vertices[j], P, Y)
            tag = self._tag(i, j)
            if self.needs_stability:
                found["stability" + tag] = stability(c)
            for part in self.parts:
                found[part.name + tag] = pole_region(
                    c, number(part.alpha), number(part.beta)
                )
            if self.gamma is not None:
                found["hinf" + tag] = bounded_real(c, gamma2)
        if self.saturation is not None:
            if frame is None:
                found["x0"] = initial_state(P, x0)
            else:  # back is T's inverse, up to rounding
                near = back @ T
                found["x0"] = initial_state(near @ P @ near.T, back @ x0)
            found["u_max"] = control_bound(P, Y, (u_max / scale) ** 2)
        return found

    def in_unknowns(self, frame, gamma2, number=lambda x: x):
        """`blocks` in unknowns P, Y (P alone if the gain is given).

        Returns
        -------
        dict, list of Unknown
        """
        P = Unknown("P", self.order, symmetric=True)
        if self.gain is None:
            Y = Unknown("Y", self.plant.m, self.order)
            unknowns = [P, Y]
        else:
            scale = number(np.array(frame.scale)).item()
            Y = (number(self.gain) @ number(frame.T) / scale) @ P
            unknowns = [P]
        return self.blocks(P, Y, gamma2, number, frame), unknowns

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
        return names


@dataclass(frozen=True, eq=False)
class Frame:
    """Coordinates x = T xi, u = scale v in which the LMIs are solved.

    The blocks only undergo congruences: neither the feasible set nor
    its centre depends on the frame, only the accuracy does. Entries
    are rounded to six digits, which keeps exact arithmetic short.
    """

    left: np.ndarray
    T: np.ndarray
    back: np.ndarray
    scale: float

    @classmethod
    def of(cls, request):
        """From the Riccati equation of the mean vertex."""
        mean = _mean(request.vertices)
        if rank_deficient(mean.E, 1e-6):  # between regular vertices
            mean = request.vertices[0]
        A, B, Bw = mean.state_space()
        omega = _rate(request, A)
        weight = _energy(request, omega)
        effort = (B.T * weight) @ B / omega**2
        effort = np.diag(np.where(np.diag(effort) > 0, np.diag(effort), 1))
        try:
            shift = A + 0.1 * omega * np.eye(len(A))
            X = solve_continuous_are(
                shift / omega, B / omega, np.diag(weight), effort
            )
            T = np.linalg.inv(cholesky(X, lower=True)).T
        except (np.linalg.LinAlgError, ValueError):  # no such solution
            T = np.diag(1 / np.sqrt(weight))
        size = 0.0
        if request.saturation is not None:
            start = np.linalg.solve(T, request.saturation.x0)
            size = max(size, 2 * start @ start)
        if request.gamma is not None:
            push = np.linalg.solve(T, Bw)
            size = max(size, np.linalg.norm(push, 2) ** 2 / omega)
        T = round_digits(T * np.sqrt(size or 1.0), 6)
        left = round_digits(np.linalg.inv(mean.E @ T), 6)
        scale = omega / (np.linalg.norm(left @ mean.Bu, 2) or 1.0)
        return cls(
            left, T, round_digits(np.linalg.inv(T), 6), float(round_digits(scale, 6))
        )


def _mean(vertices):
    return Descriptor(**{
        name: sum(getattr(d, name) for d in vertices) / len(vertices)
        for name in ("E", "A", "Bu", "Bw", "C")
    })


def _rate(request, A):
    """A typical angular frequency of the closed loop, in rad/s."""
    for part in request.parts:
        if np.array_equal(part.beta, [[0, 1], [0, 0]]):  # disk
            rho, shift = -part.alpha[0]
            return rho / 2 + abs(shift)
    for part in request.parts:
        if part.implies_stability and part.alpha[0, 0] > 0:
            return 2 * part.alpha[0, 0] / part.beta[0, 0]
    return np.abs(np.linalg.eigvals(A)).max() or 1.0


def _energy(request, omega):
    """Diagonal weights of x that have the unit of energy."""
    plants = request.plant.vertices
    n = plants[0].n
    d = request.vertices[0]
    inertia = sum(
        np.abs(v.M) + np.abs(v.D) / omega + np.abs(v.S) / omega**2
        for v in plants
    ).diagonal() / len(plants)
    inertia = np.where(inertia > 0, inertia, 1.0)
    U = np.abs(d.A[2 * n:, :n])
    return np.concatenate(
        [omega**2 * inertia, inertia, omega**4 * (U @ inertia)]
    )
