"""Disks, norms and steps that a search asks of sampled loops, at the ticks."""

import numpy as np

from ..plants.sensed import asked_of
from ..sampled.balls import middle
from ..sampled.channel import checked_norm
from ..sampled.discretize import by_name
from ..sampled.loops import SampledFamily
from .bounds import rest
from .cells import work
from .signals import known_index
from .step_bounds import Row
from .step_limits import StepLimits
from .tick_loops import Radius

GRID = 160  # frequencies at which a norm is looked at
LONGEST = 4096  # ticks of a step that a search looks at
LEFT = 1e-3  # of a motion: then it has come to rest
SAME = 1e-9  # but for roundings
NEAR = 0.95  # of what is asked: such a demand is at its bound


def checked(requirements, plant):
    """The ``requirements`` of a ``plant`` as a tuple; a ValueError for those of
    another kind.
    """
    found = []
    for r in requirements:
        circle = getattr(r, "circle", None)
        if circle is None and not isinstance(r, StepLimits):
            try:
                asked_of(plant, checked_norm(r))
            except ValueError as error:
                raise ValueError(
                    "requirements: at the ticks an HInfinity with a bound, an "
                    "LMIRegion.disk of z and a StepLimits are searched and proven; "
                    f"got {r!r}"
                ) from error
        if circle and abs(circle[0]) + circle[1] > 1:
            raise ValueError(f"requirements: {r.text} leaves the unit disk of z")
        found.append(r)
    return tuple(found)


def statement(r):
    """A requirement ``r`` at the ticks, in words."""
    if isinstance(r, StepLimits):
        return r.words
    return f"{r.statement}, from tick to tick"


def proven(r, c, cells):
    """(proof, what is missing, in words) of a requirement ``r`` of a controller ``c``,
    in ``cells``.
    """
    if isinstance(r, StepLimits):
        bounds = c.bounds.step_response(r.size, r.set_point, r.output, r.band)
        return bounds, r.missing(bounds)
    if circle := getattr(r, "circle", None):
        proof = c.certify(cells=cells, centre=circle[0], rate=circle[1])
    else:
        proof = c.certify(cells=cells, norm=r)
    return proof, [] if proof.proven else [", ".join(proof.failed)]


class _Disk:
    """The largest distance of an eigenvalue from a centre, over what is asked."""

    def __init__(self, r, loops, share):
        self.loops, self.name = loops, r.text
        self.centre, self.asked = r.circle
        self.most = share * self.asked

    def levels(self, kappa):
        """(name, reached, asked, level, slope) for free numbers ``kappa``."""
        F = self.loops.at(kappa)
        z, V = np.linalg.eig(F)
        far = abs(z - self.centre)
        i, j = divmod(int(far.argmax()), z.shape[1])
        one = np.eye(len(V[i]))[j] + 0j
        left = np.linalg.lstsq(V[i].T, one, rcond=None)[0]
        turned = self.loops.slopes[:, i] @ V[i, :, j] @ left
        away = (z[i, j] - self.centre).conj() / max(far[i, j], 1e-12)
        slope = (turned * away).real / self.most
        yield self.name, far[i, j], self.asked, far[i, j] / self.most - 1, slope


class _Norm:
    """The H-infinity norm of a channel from tick to tick, over what is asked."""

    def __init__(self, r, loops, share):
        self.name, self.asked = r.name, float(r.bounds_response())
        self.room = np.log(share)
        with_channel = work(lambda c: _of_channel(c, r))
        self.whole, self.slopes = loops.affine(with_channel)
        self.N = loops.first.shape[1]
        self.z = np.exp(1j * np.pi * np.r_[0, np.geomspace(1e-4, 1, GRID)])

    def levels(self, kappa):
        """(name, reached, asked, level, slope) for free numbers ``kappa``."""
        M, N = self.whole + np.tensordot(kappa, self.slopes, 1), self.N
        turns = np.exp(1j * abs(np.angle(np.linalg.eigvals(M[:, :N, :N]))))
        z = np.hstack([np.tile(self.z, (len(M), 1)), turns])[..., None, None]
        F, B, C, D = (M[:, None, a, b] for a in (slice(N), slice(N, None))
                      for b in (slice(N), slice(N, None)))  # fmt: skip
        inside = np.linalg.solve(z * np.eye(N) - F, B + 0j)
        answers = C @ inside + D
        sizes = np.linalg.norm(answers, 2, axis=(2, 3))
        i, k = np.unravel_index(int(sizes.argmax()), sizes.shape)
        U, (peak, *_), V = np.linalg.svd(answers[i, k])
        one = z[i, k, 0, 0] * np.eye(N) - F[i, 0]
        left = np.linalg.solve(one.T, C[i, 0].T @ U[:, 0].conj())
        left = np.concatenate([left, U[:, 0].conj()])
        right = np.vstack([inside[i, k], np.eye(M.shape[2] - N)]) @ V[0].conj()
        slope = ((self.slopes[:, i] @ right) @ left).real / peak
        level = np.log(peak) - self.room
        yield self.name, peak * self.asked, self.asked, level, slope


def _of_channel(c, r):
    """The loops of c with the channel of r at each vertex, in floats."""
    K = by_name(c.of_state, c.plant, None, c.T, c.delay)
    norm = asked_of(c.plant, checked_norm(r))
    family = SampledFamily.of(c.plant, c.vertices, c.timing, K, 0.0, norm)
    ends = np.eye(len(c.vertices), dtype=int)
    return np.array([middle(family.loop(w, c.timing)) for w in ends])


class _Step:
    """The numbers of a step at the ticks, over what is asked; each with its slope."""

    def __init__(self, r, loops, share):
        """Find the output's row, and the loops with it, as they move with numbers."""
        self.r, self.share, j = r, share, r.set_point
        c = loops.some
        known_index("set_point", j, c.set_points)
        row = Row.of(c, j, rest(c, j), r.output)
        if row.ends is None or abs(float(row.ends) - 1) > SAME:
            raise ValueError(
                f"StepLimits: {row.name} ends where gains say, not at the set point: "
                "take an output that is integrated, or a law that integrates it"
            )
        self.row, self.end = row.row.astype(float), float(row.ends)
        plants = loops.plants

        def parts(c):
            several = [c.loop(d) for d in plants]
            return np.array([
                np.block([[s.F, s.set_point[:, [j]]], [s.H, s.direct_r[:, [j]]]])
                for s in several])  # fmt: skip

        self.whole, self.slopes = loops.affine(parts)
        self.late = 0
        if r.settling_time is not None:
            self.late = int(np.ceil(r.settling_time / float(c.T) - 1e-9))

    def levels(self, kappa):
        """(name, reached, asked, level, slope) of each, for free numbers ``kappa``."""
        r, N = self.r, len(self.row)
        M = self.whole + np.tensordot(kappa, self.slopes, 1)
        radius = abs(np.linalg.eigvals(M[:, :N, :N])).max()
        rest = np.log(LEFT) / np.log(min(max(radius, 0.1), 1 - 1e-9))
        ticks = int(min(max(rest, self.late + 2, 8), LONGEST))
        A = np.zeros((len(M), N + 1, N + 1))
        A[:, :N], A[:, N, N] = M[:, :N], 1.0
        X = powers(A, np.eye(N + 1)[:, -1], ticks)  # plants, N + 1, ticks
        y = np.tensordot(self.row, X[:, :N], (0, 1)) / self.end
        if r.overshoot is not None:
            i, k = np.unravel_index(int(y.argmax()), y.shape)
            slope = self._slope(A[i], X[i], self.row, k, i) / self.end
            over, most = y[i, k] - 1, self.share * r.overshoot
            yield "overshoot", over, r.overshoot, over / most - 1, slope / most
        if r.settling_time is not None:
            off = np.where(np.arange(ticks) < self.late, 0.0, abs(y - 1))
            i, k = np.unravel_index(int(off.argmax()), off.shape)
            slope = self._slope(A[i], X[i], self.row, k, i) / self.end
            slope, most = slope * np.sign(y[i, k] - 1), max(off[i, k], 1e-9)
            name = f"distance from rest after {r.settling_time:g} s"
            level = np.log(most / (self.share * r.band))
            yield name, most, r.band, level, slope / most
        if r.effort is not None:
            u = M[:, N:] @ X
            i, h, k = np.unravel_index(int(abs(u).argmax()), u.shape)
            most = abs(u[i, h, k])
            slope = self._slope(A[i], X[i], M[i, N + h, :N], k, i)
            slope = slope + self.slopes[:, i, N + h] @ X[i, :, k]
            slope = slope * np.sign(u[i, h, k]) / max(most, 1e-300)
            reached = max(most * r.size, 1e-300)
            level = np.log(reached / (self.share * r.effort))
            yield "effort", reached, r.effort, level, slope

    def _slope(self, A, X, h, k, i):
        """Of h x at tick k of plant i in each free number, by the adjoint motion."""
        if k == 0:
            return np.zeros(len(self.slopes))
        N = len(h)
        back = powers(A[None, :N, :N].swapaxes(1, 2), h, k)[0, :, ::-1]
        both = back @ X[:, :k].T  # N, N + 1
        return np.tensordot(self.slopes[:, i, :N], both, 2)


def powers(A, x, count):
    """(plants, N, count): x, A x, A^2 x, and so on, for ``A``, (plants, N, N)."""
    X = np.repeat(x[None, :, None], len(A), axis=0)
    while X.shape[2] < count:
        X, A = np.concatenate([X, A @ X], axis=2), A @ A
    return X[:, :, :count]


class Demands:
    """Some ``requirements`` of sampled ``loops``, a `TickLoops`, in floats, each of
    which a search shall keep to a ``share`` of what is asked.
    """

    def __init__(self, requirements, loops, share):
        self.parts = []
        for r in requirements:
            kind = _Disk if getattr(r, "circle", None) else _Norm
            kind = _Step if isinstance(r, StepLimits) else kind
            self.parts.append(kind(r, loops, share))

    def levels(self, kappa):
        """(name, reached, asked, level, slope) of each for free numbers ``kappa``; a
        level is below zero where it is kept.
        """
        return [x for part in self.parts for x in part.levels(kappa)]

    def words(self, kappa, bounds=False):
        """Those that free numbers ``kappa`` don't keep, in words; with ``bounds`` those
        that are just kept.
        """
        if kappa is None:
            return ""
        return " and ".join(
            f"{name} {reached:.4g} (asked: at most {asked:.4g})"
            for name, reached, asked, *_ in self.levels(kappa)
            if (NEAR if bounds else 1) * asked < reached
            and (reached <= asked) == bounds
        )


class Demanded(Radius):
    """The worst of a `Radius` and of some ``demands`` of a ``task``, for its ``loops``,
    ``unit``, ``radius`` and ``size``; without ``norms`` the radius alone.
    """

    def __init__(self, task, loops, unit, norms, radius, size, demands):
        super().__init__(task, loops, unit, radius, size)
        self.norms, self.demands = norms, demands

    def _of(self, kappa, most):
        value, slope = super()._of(kappa, most)
        if not self.norms or not np.isfinite(value):
            return value, slope
        if value * self.size + self.radius >= 1:
            return np.inf, None
        for *_, level, one in self.demands.levels(kappa):
            if level > value:
                value, slope = level, lambda one=one: one
        return value, slope
