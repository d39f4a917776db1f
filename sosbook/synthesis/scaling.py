"""Coordinates in which the LMIs of a request are well conditioned."""

from dataclasses import dataclass, field, replace

import numpy as np
from scipy.linalg import matrix_balance

from ..analysis.riccati import balanced_units, lyapunov, riccati
from ..exact.definite import round_digits
from ..plants.checks import inverse_by_rows, logarithmic_scales
from ..plants.descriptor_system import DescriptorSystem
from ..requirements.magnitudes import Magnitudes
from ..runtime.read_only import ReadOnly

LEAST_WEIGHT = 1e-6  # of a state, by its own: no mode is unseen, and X hardly moves


@dataclass(frozen=True, eq=False)
class Frame(ReadOnly):
    """Coordinates x = ``T`` xi, u = ``scale`` v in which the LMIs are solved. The
    blocks only undergo congruences: neither the feasible set nor its centre depends on
    the frame, only the accuracy does.

    Entries are rounded to six digits, which keeps exact arithmetic short. ``left``
    multiplies x' from the left and ``back`` is the inverse of T, to six digits
    (`inward` has all); ``gain`` is that of the Riccati equation, v = gain xi.
    Requirements that fix the size of P may want it larger or smaller by far: those in
    ``sizes``, by their `size_name`, have coordinates x = T c xi. Own unknowns of
    requirements are measured in the units ``own``, by their names.
    """

    left: np.ndarray
    T: np.ndarray
    back: np.ndarray
    scale: float
    gain: np.ndarray | None = None
    sizes: dict = field(default_factory=dict)
    own: dict = field(default_factory=dict)

    def times(self, c):
        """Coordinates x = T c xi."""
        if c == 1.0:
            return self
        moved = self.left / c, self.T * c, self.back / c, self.scale * c
        return Frame(*moved, own=self.own)

    def inward(self, P):
        """T^-1 ``P`` T'^-1 without the rounding of ``back``."""
        return np.linalg.solve(self.T, np.linalg.solve(self.T, P).T).T

    def owned(self, requirement):
        """The coordinates of a requirement."""
        return self.times(self.sizes.get(requirement.size_name, 1.0))

    @classmethod
    def of(cls, request, levels=()):
        """The frame of a ``request``, from the Riccati equation of the mean vertex;
        ``levels`` are as in `Sizes.leader`.
        """
        mean = _typical(request)
        A, B, _ = mean.state_space()
        omega = request.typical_rate
        for r in request.requirements:
            if r.riccati() is not None:
                return cls._of_riccati(request, A, B, *r.riccati(), levels)
        if request.plant.m == 0:
            return cls._of_loop(request, A, levels)
        weight = _energy(request, omega)
        effort = (B.T * weight) @ B / omega**2
        effort = np.diag(np.where(np.diag(effort) > 0, np.diag(effort), 1))
        try:
            # in coordinates in which both weights are I: free of units
            size, force = np.sqrt(weight), np.sqrt(effort.diagonal())
            shift = size[:, None] * A / size / omega + 0.1 * np.eye(len(A))
            push = size[:, None] * B / force / omega
            X = riccati(shift, push, np.eye(len(A)), np.eye(len(force)))
            T = np.linalg.inv(np.linalg.cholesky(X)).T / size[:, None]
            gain = -(push.T @ X * size) / force[:, None]
        except (np.linalg.LinAlgError, ValueError):  # no such solution
            T, gain = np.diag(1 / np.sqrt(weight)), None
        T = T * np.sqrt(_size(request, T, levels))
        push = np.linalg.solve(mean.E @ T, mean.Bu)
        scale = omega / (np.linalg.norm(push, 2) or 1.0)
        gain = None if gain is None else gain @ T / scale
        return cls.at(request, T, scale, gain, levels)

    @classmethod
    def _of_riccati(cls, request, A, B, Q, R, levels):
        """From the equation that a requirement is about: its P is near I."""
        try:
            # what isn't weighed gets a little, in units that balance the equation
            square = balanced_units(A, B, Q, R) ** 2
            weight = Q.diagonal() * square
            floor = np.maximum(weight, LEAST_WEIGHT * weight.max()) / square
            X = riccati(A, B, Q + LEAST_WEIGHT * np.diag(floor), R)
            T = np.linalg.inv(np.linalg.cholesky(X)).T
        except np.linalg.LinAlgError:  # a mode that no weight sees
            return cls.at(request, np.eye(len(A)), 1.0, None, levels)
        if request.sizes.followers(request.sizes.leader(levels)):
            T = T * np.sqrt(_size(request, T, levels))
        gain = -np.linalg.solve(R, B.T @ X)
        scale = np.linalg.norm(gain @ T, 2) or 1.0
        return cls.at(request, T, scale, gain @ T / scale, levels)

    @classmethod
    def _of_loop(cls, request, A, levels):
        """From Lyapunov's equation of the loop, a little faster."""
        rates = np.linalg.eigvals(A).real
        shift = A - min(0.9 * rates.max(), 0.0) * np.eye(len(A))
        try:
            balance = matrix_balance(shift, separate=True)[1][0]
            weight = 1 / balance**2
            X = lyapunov(shift.T, -np.diag(weight))
            T = np.linalg.inv(np.linalg.cholesky(X)).T
        except np.linalg.LinAlgError:
            T = np.eye(len(A))
        return cls.at(request, T, 1.0, None, levels)

    @classmethod
    def of_solution(cls, request, solution, unit=False, levels=()):
        """Coordinates for a ``request`` in which the P of a ``solution`` of the same
        shape (with a slack matrix their mean) is a multiple of I; with ``unit`` the
        unknown P is I itself, and every unknown size one. ``levels`` are as in
        `Frame.of`.
        """
        P = solution.P if np.ndim(solution.P) == 2 else solution.P.mean(axis=0)
        T = np.linalg.cholesky(P)
        top = np.abs(T).max()
        scale = np.linalg.norm(solution.K @ T / top, 2) or 1.0
        frame = cls.at(request, T / top, scale, levels=levels)
        values = in_unknowns_of(request, frame, solution, levels)
        if values is None:
            return frame
        # there P = p I, and a requirement's own is p / size I
        one = np.ones((1, 1))
        p = sum(np.trace(values[x]) for x in request.lyapunov)
        p = p / len(T) / len(request.lyapunov)
        wanted = 1.0 if unit else p
        units = {
            name: float(round_digits(c * np.sqrt(wanted / values[name].item()), 2))
            for name, c in frame.sizes.items()
        }
        if not unit:
            return replace(frame, sizes=units)
        T = frame.T * np.sqrt(p)
        scale = np.linalg.norm(solution.K @ T, 2) or 1.0
        own = {
            u.name: np.abs(values[u.name]).max() / values.get(r.size_name, one).item()
            for r, u in request.owned
            if u.name in frame.own
        }
        own = {
            name: float(round_digits(frame.own[name] * (size or 1.0), 2))
            for name, size in own.items()
        }
        return replace(cls.at(request, T, scale, sizes=units), own=own)

    @classmethod
    def at(cls, request, T, scale, gain=None, levels=(), sizes=None):
        """A frame for a ``request`` with x = ``T`` xi and u = ``scale`` v; ``gain``,
        (m, N), is that of the Riccati equation, if it is known, and ``levels`` are as
        in `Frame.of`. ``sizes`` are estimated without it.
        """
        T = round_digits(T, 6)
        left = inverse_by_rows(request.mean.E @ T)
        return cls(
            round_digits(left, 6),
            T,
            round_digits(inverse_by_rows(T), 6),
            float(round_digits(scale, 6)),
            gain,
            _sizes(request, T, levels) if sizes is None else sizes,
            _own(request, T),
        )


def _plain(request, T):
    """The frame of coordinates T, with all digits and nothing else."""
    left = inverse_by_rows(request.mean.E @ T)
    return Frame(left, T, inverse_by_rows(T), request.typical_rate)


def _reaches(request, T):
    """How large each requirement's P must be in coordinates T, roughly."""
    if not request.sizes.fixing:
        return {}
    frame = _plain(request, T)
    return {r: 2 * Magnitudes(r, request, frame).P or 1.0 for r in request.sizes.fixing}


def _own(request, T):
    """See `Frame.own`."""
    if not request.owned:
        return {}
    plain, own = _plain(request, T), {}
    for r, u in request.owned:
        size = float(round_digits(Magnitudes(r, request, plain).own, 2))
        own[u.name] = size or 1.0
    return own


def _size(request, T, levels):
    """How large the unknown P must be in coordinates T, roughly."""
    reaches, leader = _reaches(request, T), request.sizes.leader(levels)
    if request.sizes.followers(leader):
        return reaches[leader]
    return max(reaches.values(), default=1.0)


def _sizes(request, T, levels):
    """See `Frame.sizes`; two digits keep exact arithmetic short."""
    leader = request.sizes.leader(levels)
    followers = request.sizes.followers(leader)
    if not followers:
        return {}
    reaches = _reaches(request, T)
    return {
        r.size_name: float(round_digits(np.sqrt(reaches[r] / reaches[leader]), 2))
        for r in followers
    }


def _typical(request):
    """The mean vertex; the first one where the mean has hardly an input."""
    mean, vertices = request.mean, request.vertices
    most = max(np.linalg.norm(d.Bu) for d in vertices)
    return mean if np.linalg.norm(mean.Bu) > 0.1 * most else vertices[0]


def _energy(request, omega):
    """Diagonal weights of x that have the unit of energy."""
    if isinstance(request.plant, DescriptorSystem):
        return np.ones(request.order)
    plants = [request.plant.vertices[i] for i in request.distinct]
    n = plants[0].n
    d = request.vertices[0]
    forces = sum(
        np.abs(v.M) + np.abs(v.D) / omega + np.abs(v.S) / omega**2 for v in plants
    ) / len(plants)
    inertia = forces.diagonal()
    if not inertia.all():  # equations in another order than the coordinates
        inertia = np.where(inertia, inertia, logarithmic_scales(forces)[1] ** -2.0)
    U = d.A[2 * n :, :n]  # x3 is of the size of U z / omega
    return np.concatenate(
        [omega**2 * inertia, inertia, omega**4 / (U**2 @ (1 / inertia))]
    )


def in_unknowns_of(request, frame, solution, levels=()):
    """Values of a ``request``'s unknowns in a ``frame``, from a ``solution`` of the
    same shape and unknowns; None if it lacks some. The inverse of
    `ScaledLMIs.in_plant_units`; ``levels`` are as in `Sizes.leader`.
    """
    leader, known = request.sizes.leader(levels), solution.own or {}
    followers = request.sizes.followers(leader)
    if followers:
        known = {request.sizes.fixing[-1].size_name: np.ones((1, 1))} | known
    try:
        first = known[leader.size_name].item() if followers else 1.0
        size = {
            name: known[name].item() / first * frame.sizes.get(name, 1.0) ** 2
            for name in (r.size_name for r in followers)
        }
        values = {
            u.name: known[u.name]
            * size.get(r.size_name, 1.0)
            / frame.own.get(u.name, 1.0)
            for r, u in request.owned
        }
    except KeyError:
        return None
    values.update({name: np.array([[s]]) for name, s in size.items()})
    V = solution.P if solution.V is None else solution.V
    right = frame.inward(V) / first
    gain = solution.K @ frame.T / frame.scale
    P = [frame.inward(p) / first for p in np.atleast_3d(solution.P.T).T]
    values.update(V=right, Y=gain @ right.T)
    values.update(zip(request.lyapunov, P, strict=True))
    return values
