"""Input shapers: a few impulses that let a set point arrive in parts, so that the
vibrations that the parts excite cancel.
"""

from dataclasses import dataclass
from decimal import ROUND_CEILING, Context
from math import ceil
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import acb, arb, fmpq

from ..exact.rational import exact
from ..runtime.array_like import ArrayLike
from .checks import matrix, numbers, positive
from .signals import Ramps, Steps, steps

MOST = 8  # half periods that a shaper lasts
FINE = 1e-5  # of the vibration: what the chords of a proof leave between two points
POINTS = 4096  # of an edge, at most


@dataclass(frozen=True)
class Residual:
    """The share of a vibration that an `InputShaper` leaves, at most.

    The bound is an enclosure of one program, this package: no file holds it.

    Parameters
    ----------
    proven : float
        No mode of the ranges keeps more; 0.05 prints as 5 %.
    seen : float
        The largest that was met.
    omega, zeta : (float, float)
        The ranges, in rad/s and as a share of critical damping.
    at : (float, float)
        The omega and zeta of ``seen``.
    """

    proven: float
    seen: float
    omega: tuple[float, float]
    zeta: tuple[float, float]
    at: tuple[float, float]

    def __str__(self):
        most = Context(prec=3, rounding=ROUND_CEILING).create_decimal(self.proven)
        ranges = " and ".join(
            f"{name} = {low:g}"
            if low == high
            else f"every {name} in [{low:g}, {high:g}]"
            for name, (low, high) in (("omega", self.omega), ("zeta", self.zeta))
        )
        omega, zeta = self.at
        return (
            f"leaves at most {100 * float(most):.3g} % of the vibration for {ranges}, "
            f"by an enclosure of one program ({100 * self.seen:.3g} % at "
            f"omega = {omega:.4g}, zeta = {zeta:.4g})"
        )


@dataclass(frozen=True, eq=False)
class InputShaper:
    r"""Impulses :math:`A_i` at times :math:`t_i` that a set point is convolved with.

    Parameters
    ----------
    amplitudes : (k,) array_like
        The impulses, which add up to 1.
    times : (k,) array_like
        When they come, in seconds: increasing, the first is 0.

    Raises
    ------
    ValueError
        If they don't.

    Notes
    -----
    Source: Singer and Seering, Journal of Dynamic Systems, Measurement, and Control
    112, 1990; EI: Singhose, Seering and Singer, Journal of Mechanical Design 116,
    1994. What poles p = omega (-zeta + j sqrt(1 - zeta^2)) keep of their vibration is
    :math:`V(p) = |\sum_i A_i e^{p (t_k - t_i)}|`: the amplitude after the last impulse,
    by that with which the response to a step begins. A shaper of discrete time has the
    poles z = e^(p T).

    Examples
    --------
    >>> shaper = InputShaper.zv(omega=np.pi)
    >>> shaper([1.0]).times, shaper([1.0]).levels.T
    (array([0., 1.]), array([[0.5, 1. ]]))
    >>> shaper = InputShaper.ei((0.7, 1.3))
    >>> len(shaper.times), round(shaper.residual((0.7, 1.3)).proven, 3)
    (4, 0.028)
    """

    amplitudes: np.ndarray
    times: np.ndarray

    if TYPE_CHECKING:  # what the constructor takes

        def __init__(self, amplitudes: ArrayLike, times: ArrayLike) -> None: ...

    def __post_init__(self):
        both = matrix("amplitudes, times", [self.amplitudes, self.times])
        amplitudes, times = both
        if len(times) == 0 or times[0] != 0 or (np.diff(times) <= 0).any():
            raise ValueError("times must increase from 0")
        if abs(amplitudes.sum() - 1) > 1e-9:
            raise ValueError("amplitudes must add up to 1: else a step ends elsewhere")
        object.__setattr__(self, "amplitudes", amplitudes)
        object.__setattr__(self, "times", times)

    @classmethod
    def zv(cls, omega: ArrayLike, zeta: ArrayLike = 0.0) -> "InputShaper":
        """Zero vibration: two impulses, half a period apart.

        Parameters
        ----------
        omega, zeta : float or (low, high)
            The mode, in rad/s and as a share of critical damping; of a range its
            middle is taken, and `residual` says what the rest of it keeps.
        """
        return cls._of(omega, zeta, 1, np.inf)

    @classmethod
    def zvd(cls, omega: ArrayLike, zeta: ArrayLike = 0.0) -> "InputShaper":
        """Zero vibration and derivative: three impulses; ``omega``, ``zeta``: `zv`."""
        return cls._of(omega, zeta, 2, np.inf)

    @classmethod
    def ei(
        cls, omega: ArrayLike, zeta: ArrayLike = 0.0, residual: float = 0.05
    ) -> "InputShaper":
        r"""Extra-insensitive: a share of the vibration is left, over a wider range.

        Parameters
        ----------
        omega, zeta : float or (low, high)
            The mode, in rad/s and as a share of critical damping. For one mode these
            are three impulses which leave the ``residual`` there and as much at each
            side. For a range they are as few as do.
        residual : float
            The share that may be left, from 0 to 1.

        Raises
        ------
        ValueError
            If nine impulses leave more: it says how much.

        Notes
        -----
        With n half periods :math:`V = T_n(x_0 \cos(\omega \tau / 2)) / T_n(x_0)` if
        nothing damps: Chebyshev's polynomial, so no n + 1 impulses at these times leave
        less over a range (Dolph, Proceedings of the IRE 34, 1946). n = 1 is `zv`, n =
        2 Singhose's EI, n = 3 and 4 are EI with two humps and with three.
        """
        share = positive("residual", residual)
        if share >= 1:
            raise ValueError(f"residual must be below 1, got {residual!r}")
        (low, high), ranges = _range("omega", omega), np.ndim(omega) or np.ndim(zeta)
        if not ranges:
            return cls._of(omega, zeta, 2, np.cosh(np.arccosh(1 / share) / 2))
        x0 = 1 / np.cos(np.pi * low / (low + high))
        best = None
        for n in range(1, MOST + 1):
            shaper = cls._of(omega, zeta, n, x0)
            left = shaper.residual(omega, zeta)
            if left.proven <= share:
                return shaper
            best = min(best or left, left, key=lambda x: x.proven)
        raise ValueError(
            f"no shaper of up to {MOST} half periods leaves at most {100 * share:.3g} "
            f"%: the best one {best}; narrow the ranges, or let it leave more"
        )

    @classmethod
    def _of(cls, omega, zeta, n, x0):
        """n half periods whose zeros are those of T_n(x0 cos)."""
        omega, zeta = np.mean(_range("omega", omega)), np.mean(_range("zeta", zeta))
        half = np.pi / (omega * np.sqrt(1 - zeta**2))
        zeros = np.arccos(np.cos(np.pi * (np.arange(n) + 0.5) / n) / x0)
        A = np.poly(np.exp(2j * zeros)).real * np.exp(
            -zeta * omega * half * np.arange(n + 1)
        )
        return cls(A / A.sum(), half * np.arange(n + 1))

    def __call__(self, r: Any) -> Steps:
        """The shaped set point: `Steps` of steps, `Ramps` of a record.

        Parameters
        ----------
        r : (n,) array_like, Step, Steps or Ramps
            The set point; before 0 it is zero.
        """
        first = r.levels[0] if isinstance(r, Steps) else getattr(r, "height", r)
        r = steps(r, np.size(first))
        jumps = np.diff(r.levels, axis=0, prepend=0 * r.levels[:1])
        bends = np.diff(r.slopes, axis=0, prepend=0 * r.levels[:1])
        if isinstance(r, Ramps):
            jumps[1:][np.diff(r.times) > 0] = 0
        times, where = np.unique(
            np.add.outer(self.times, r.times).ravel(), return_inverse=True
        )
        jump, bend = np.zeros((2, len(times), r.levels.shape[1]))
        for found, of in ((jump, jumps), (bend, bends)):
            parts = np.multiply.outer(self.amplitudes, of).reshape(-1, of.shape[1])
            np.add.at(found, where, parts)
        slopes = np.cumsum(bend, axis=0)
        rises = slopes[:-1] * np.diff(times)[:, None]
        after = np.cumsum(jump + np.vstack([0 * rises[:1], rises]), axis=0)
        if not isinstance(r, Ramps):
            return Steps(times, after)
        before = after - jump
        twice = np.flatnonzero(jump[1:].any(axis=1)) + 1
        return Ramps(
            np.insert(times, twice, times[twice]),
            np.insert(after, twice, before[twice], axis=0),
        )

    def __mul__(self, other: "InputShaper") -> "InputShaper":
        """One after the other: for two modes."""
        step = self(Steps(other.times, np.cumsum(other.amplitudes)[:, None]))
        return InputShaper(np.diff(step.levels[:, 0], prepend=0.0), step.times)

    def at(self, T: float) -> "InputShaper":
        r"""The same for a clock: each impulse is split between two ticks.

        A program that reads a shaped set point at its ticks lets each impulse wait for
        the next one. A split one keeps its mean time, which adds at most
        :math:`(\omega T)^2 / 8` times the sum of :math:`|A_i|` to what is left.

        Parameters
        ----------
        T : float
            Between ticks, in seconds.
        """
        positive("T", T)
        ticks = (self.times / T).round(9)
        first = np.floor(ticks).astype(int)
        A = np.bincount(first, self.amplitudes * (1 - ticks + first), first[-1] + 2)
        A += np.bincount(first + 1, self.amplitudes * (ticks - first), first[-1] + 2)
        kept = np.flatnonzero(A)
        return InputShaper(
            A[kept], [min(k * T, float(exact(T) * int(k))) for k in kept]
        )

    def residual(self, omega: ArrayLike, zeta: ArrayLike = 0.0) -> Residual:
        r"""The share of a vibration that is left, proven for all modes of a range.

        Parameters
        ----------
        omega, zeta : float or (low, high)
            The modes, in rad/s and as a share of critical damping: of the poles p of a
            loop abs(p) and -p.real / abs(p), which are floats.

        Returns
        -------
        Residual
            The bound, in words.

        Notes
        -----
        V is the modulus of an analytic function, so its largest value lies on the edge
        of the range. There points lie so densely that a chord between two of them is
        nearly the function: the difference is at most its second derivative, enclosed,
        times an eighth of the square of their distance. All values are balls.
        """
        return _enclosed(self, _range("omega", omega), _range("zeta", zeta))


def _enclosed(shaper, omegas, zetas):
    """The `Residual` of a ``shaper`` on these ranges."""
    low, high = (arb(exact(x)) for x in omegas)
    one, two = (arb(exact(x)).asin() for x in zetas)
    left = [arb(shaper.times[-1]) - arb(t) for t in shaper.times.tolist()]
    A = [arb(a) for a in shaper.amplitudes.tolist()]
    slope = sum((abs(a) * t for a, t in zip(A, left)), arb(0))
    bend = sum((abs(a) * t * t for a, t in zip(A, left)), arb(0))
    wide, turn = high - low, two - one
    edges = [(low, high, x, x, bend * wide * wide) for x in (one, two)]
    for w in (low, high):
        edges.append((w, w, one, two, (bend * w + slope) * w * turn * turn))
    proven, seen, at = arb(0), -1.0, (0.0, 0.0)
    for w, end, angle, last, curve in edges:
        curve = curve.abs_upper() / 8
        count = max(1, ceil(min(POINTS, float((curve / FINE).sqrt()))))
        for k in range(count + 1):
            share = arb(fmpq(k, count))
            omega, phi = w + (end - w) * share, angle + (last - angle) * share
            p = acb(-omega * phi.sin(), omega * phi.cos())
            value = abs(sum((a * (p * t).exp() for a, t in zip(A, left)), acb(0)))
            proven = proven.max(value + curve / count**2)
            if float(value.mid()) > seen:
                seen = float(value.mid())
                at = float(omega.mid()), float(phi.sin().mid())
    most = float(np.nextafter(float(proven.upper()), np.inf))
    return Residual(most, seen, omegas, zetas, at)


def _range(name, value):
    """The ends of a range, or one number twice: rad/s, or shares below 1."""
    ends = numbers(name, value)
    zeta = name == "zeta"
    low, high = ends.tolist() if ends.shape == (2,) else [ends.ravel()[0]] * 2
    fine = 0 <= low <= high < 1 if zeta else 0 < low <= high < np.inf
    if ends.shape not in ((), (2,)) or not fine:
        kind = "from 0, below 1," if zeta else "above 0"
        raise ValueError(
            f"{name} must be one number {kind} or (low, high), got {value!r}"
        )
    return float(low), float(high)
