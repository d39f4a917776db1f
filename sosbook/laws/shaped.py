"""Fixed filters before a law, and models of what it shall follow."""

from copy import copy
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..exact.rational import exact, inverse
from ..plants.checks import not_negative, numbers, positive
from ..plants.descriptor_system import OF_TICKS
from ..runtime.read_only import ReadOnly, put
from .base import MODELS, Law, Parts
from .structure import Block, Structure


@dataclass(frozen=True, eq=False)
class Filter(ReadOnly):
    """A fixed filter of one reading, ``numerator`` / ``denominator``, the highest power
    of s first, with a ``name`` in words.

    Examples
    --------
    >>> Filter.notch(60, 0.05, 0.5).numerator.tolist()
    [1.0, 6.0, 3600.0]
    """

    numerator: np.ndarray
    denominator: np.ndarray
    name: str

    def __post_init__(self):
        """Check that it is proper and stable, and scale the first power to one."""
        num, den = (
            numbers(name, getattr(self, name)) for name in ("numerator", "denominator")
        )
        if num.ndim != 1 or den.ndim != 1 or not 1 <= len(num) <= len(den):
            raise ValueError(
                "numerator and denominator must be lists of numbers, the highest "
                "power first, the denominator's as high as the numerator's"
            )
        if not den[0] or (len(den) > 1 and np.roots(den).real.max() >= 0):
            raise ValueError("the filter isn't stable: its poles must lie in Re s < 0")
        put(self, numerator=num, denominator=den)
        super().__post_init__()

    @classmethod
    def notch(cls, frequency: float, zero: float, pole: float) -> "Filter":
        """A notch at a ``frequency`` in rad/s, with the damping ratios of its zeros and
        of its poles: (s^2 + 2 zero w s + w^2) / (s^2 + 2 pole w s + w^2).
        """
        w, zero = positive("frequency", frequency), not_negative("zero", zero)
        pole = positive("pole", pole)
        num, den = (np.array([1, 2 * x * w, w * w]) for x in (zero, pole))
        return cls(num, den, f"notch at {w:g} rad/s")

    @classmethod
    def lead(cls, zero: float, pole: float) -> "Filter":
        """(s / zero + 1) / (s / pole + 1), both in rad/s: a lead where the zero is
        slower, a lag where the pole is.
        """
        zero, pole = positive("zero", zero), positive("pole", pole)
        kind = "lead" if zero < pole else "lag"
        num, den = np.array([1 / zero, 1]), np.array([1 / pole, 1])
        return cls(num, den, f"{kind} from {zero:g} to {pole:g} rad/s")

    @classmethod
    def resonance(cls, frequency: float, damping: float) -> "Filter":
        """w^2 / (s^2 + 2 damping w s + w^2), as of positive position feedback, with the
        ``frequency`` w in rad/s.
        """
        w, damping = positive("frequency", frequency), positive("damping", damping)
        den = np.array([1, 2 * damping * w, w * w])
        return cls(np.array([w * w]), den, f"resonance at {w:g} rad/s")

    @property
    def system(self):
        """A, B, C and D of x' = A x + B y, C x + D y, in rationals."""
        num, den = exact(self.numerator), exact(self.denominator)
        num, den, k = num / den[0], den / den[0], len(den) - 1
        num = np.concatenate([exact(np.zeros(k + 1 - len(num))), num])
        A, B = exact(np.eye(k, k=1)), exact(np.zeros((k, 1)))
        if k:
            A[-1], B[-1] = -den[:0:-1], exact(1.0)
        C = (num - num[0] * den)[:0:-1][None]
        return A, B, C, num[:1][None]


@dataclass(frozen=True, eq=False)
class Shaped(Parts):
    """Parts with internal ``models`` among the states: these begin at zero."""

    models: Any = ()

    @cached_property
    def rest(self):
        """The matrix from x(0) to [x(0); x_c(0)], as of `Parts`."""
        N, c = self.rows.shape[1], len(self.states)
        whole = exact(np.eye(N + c, N))
        some = [k for k in range(self.integrals, c) if k not in self.models]
        if some and not self.free:
            inner = inverse(self.A[np.ix_(some, some)])
            whole[[N + k for k in some]] = -inner @ self.B[some] @ self.rows
        return whole


@dataclass(frozen=True, eq=False)
class ShapedLaw(Law):
    """A ``law`` of readings that pass fixed filters, with internal models.

    Parameters
    ----------
    law : PIDLaw or DynamicLaw
        What multiplies the filtered readings; its gains are free as before.
    through : sequence of Filter
        Which each reading passes, one after the other: notches, leads, lags.
    ramp : bool
        Whether it has the integral of the integral, so that ramps leave no error; with
        a PIDLaw that integrates.
    sines : sequence of float
        Frequencies in rad/s of sines that leave no error: two states for each reading,
        which grow while it has that frequency. Their gains are ``K_R``, which the
        law's ``limits`` may name, with the zeros and the words of the law's structure:
        of K_I for a ramp, of K_P (and K_D, where rates are measured) for a sine, so
        that a decentralised law stays one.

    Notes
    -----
    Source: B. A. Francis and W. M. Wonham, Automatica 12, 1976: a stable loop leaves no
    error of what its controller has a model of, whatever the plant is near it.

    Examples
    --------
    >>> import sosbook as sos
    >>> arm = sos.SecondOrderSystem(1, 0.2, 3600, 3600)
    >>> inner = sos.PIDLaw(position=[[1]], integrate=True)
    >>> law = ShapedLaw(inner, [Filter.notch(60, 0.05, 0.5)])
    >>> law.words(arm)
    'u depends on z1 alone: PI, through a notch at 60 rad/s'
    """

    law: Any
    through: Any = ()
    ramp: bool = False
    sines: Any = ()

    def __post_init__(self):
        """Check the filters and the frequencies."""
        through = tuple(self.through)
        if not all(isinstance(x, Filter) for x in through):
            raise ValueError("through must be a list of Filter, such as Filter.notch")
        if not isinstance(self.law, Law) or not self.law.searched:
            raise ValueError("law must be a PIDLaw or a DynamicLaw")
        if not isinstance(self.ramp, bool):
            raise ValueError(f"ramp must be True or False, got {self.ramp!r}")
        sines = tuple(positive("sines", x) for x in self.sines)
        if not through and not sines and not self.ramp:
            raise ValueError("give through, ramp or sines: else it is the law itself")
        put(self, through=through, sines=sines)
        for name in ("sensors", "rates", "noise", "lag", "places", "filter"):
            put(self, **{name: getattr(self.law, name, None)})
        super().__post_init__()

    def readings(self, plant: Any) -> Any:
        return self.law.readings(plant)

    def on(self, plant: Any) -> tuple:
        plant, inner = self.law.on(plant)
        if inner is self.law:
            return plant, self
        new = copy(self)
        put(new, law=inner, given=self.given or self)
        for name in ("sensors", "rates", "noise", "lag", "places"):
            put(new, **{name: getattr(inner, name)})
        return plant, new

    def _filter(self):
        """The filters of one reading in a row: A, B, C and D, in rationals."""
        A, B, C, D = (exact(np.zeros(x)) for x in ((0, 0), (0, 1), (1, 0), (1, 1)))
        D[0, 0] = exact(1.0)
        for one in self.through:
            a, b, c, d = one.system
            none = exact(np.zeros((len(A), len(a))))
            A = np.vstack([np.hstack([A, none]), np.hstack([b @ C, a])])
            B, C, D = np.vstack([B, b @ D]), np.hstack([d @ C, c]), d @ D
        return A, B, C, D

    def _models(self, p):
        """A, B and names of the models of what the parts ``p`` integrate and measure:
        A on the integrals and their own states, B on the filtered readings.
        """
        a, s = p.integrals, len(p.sensors)
        if self.ramp and not a:
            raise ValueError("ramp needs a law that integrates: integrate=True")
        if p.free and self.sines:
            raise ValueError("sines are for a PIDLaw: a DynamicLaw has its own A_c")
        first = a if self.ramp else 0
        count = first + 2 * s * len(self.sines)
        A, B = exact(np.zeros((count, a + count))), exact(np.zeros((count, s)))
        A[:first, :first] = exact(np.eye(first))
        names = [f"integral of {x}" for x in p.states[:first]]
        for j, w in enumerate(self.sines):
            k = first + 2 * s * j
            turn = exact(np.kron([[0, 1], [-1, 0]], np.eye(s))) * exact(w)
            A[k : k + 2 * s, a + k : a + k + 2 * s] = turn
            B[k : k + s] = exact(np.eye(s))
            names += [f"sine of {x} at {w:g} rad/s" for x in p.sensors]
            names += [f"cosine of {x} at {w:g} rad/s" for x in p.sensors]
        return A, B, names

    def parts(self, plant: Any) -> Parts:
        """The integrals, the states of the filters and of the models, and the law's
        other states, in this order, joined to a ``plant``.
        """
        plant, law = self.on(plant)
        if law is not self:
            return law.parts(plant)
        if getattr(plant, "dt", None) is not None:
            raise ValueError(OF_TICKS.format("a ShapedLaw"))
        p = self.law.parts(plant)
        s, a, f = len(p.sensors), p.integrals, len(p.states)
        F, G, H, J = (np.kron(exact(np.eye(s)), x) for x in self._filter())
        M, N, names = self._models(p)
        k, r, q = len(F), len(M), len(p.signals)
        old = [*range(a), *range(a + k + r, f + k + r)]  # the law's own states
        mine, model = slice(a, a + k), slice(a + k, a + k + r)
        E, A = exact(np.eye(f + k + r)), exact(np.zeros((f + k + r,) * 2))
        B, stay = exact(np.zeros((len(E), s))), exact(np.zeros((q + r, len(E))))
        E[np.ix_(old, old)], A[np.ix_(old, old)] = p.E, p.A
        A[old, mine], B[old] = p.B @ H, p.B @ J
        A[mine, mine], B[mine] = F, G
        A[model, :a], A[model, model], A[model, mine] = M[:, :a], M[:, a:], N @ H
        B[model] = N @ J
        stay[:q, old], stay[:q, mine] = p.of_states, p.of_sensors @ H
        stay[q:, model] = exact(np.eye(r))
        take = np.vstack([p.of_sensors @ J, exact(np.zeros((r, s)))])
        passed = [f"filter {j + 1} of {x}" for x in p.sensors for j in range(k // s)]
        states = (*p.states[:a], *passed, *names, *p.states[a:])
        said = p.sensors, states, (*p.signals, *names)
        models = range(a + k, a + k + r)
        known = E, A, B, take, stay, p.free, *said, a, models
        return Shaped(p.rows, p.noise, *known)

    def structure(self, plant: Any) -> Structure:
        """That of the law at a ``plant``, and of its models' gains."""
        p, law, limits = self.parts(plant), self.law, dict(self.law.limits or {})
        if len(p.signals) > len(law.parts(plant).signals):  # it has models
            law = copy(law)
            put(law, limits={k: x for k, x in limits.items() if k != MODELS})
        inner = law.structure(plant)
        (rows, width), whole = inner.shape, len(p.signals)
        if whole == width:
            return inner
        known, seen, groups = {b.name: _tied(b) for b in inner.blocks}, 0, []
        for name in ("K_P", "K_D"):  # of what is measured, and not of filtered rates
            if name in known and seen < len(p.sensors):
                groups.append(known[name])
                seen += known[name].shape[2]
        both = _beside(groups)
        several = [known["K_I"]] if self.ramp else []
        several += [both, both] * len(self.sines)
        shares = _beside(several)
        ends = np.tile([-np.inf, np.inf], (len(shares), 1))
        place = slice(0, rows), slice(width, whole)
        more = Block(MODELS, *place, shares, np.zeros(shares.shape[1:]), ends)
        return Structure((rows, whole), (*inner.blocks, more), limits)

    def words(self, plant: Any) -> str:
        """The law's words at a ``plant``, and the filters of its readings."""
        words = self.law.words(plant)
        if self.through:
            words += f", through a {', a '.join(x.name for x in self.through)}"
        models = ["ramps"] * self.ramp + [f"sines of {w:g} rad/s" for w in self.sines]
        return words + (f", with models of {' and '.join(models)}" if models else "")


def _tied(block):
    """The shares of a ``block``, those of its fixed entries that aren't zero free."""
    fixed = [np.zeros_like(block.first) for _ in range(np.count_nonzero(block.first))]
    for share, place in zip(fixed, np.argwhere(block.first)):
        share[tuple(place)] = 1.0
    return np.concatenate([block.shares, np.reshape(fixed, (-1, *block.first.shape))])


def _beside(several):
    """Shares of blocks side by side, from those of each."""
    width, found, at = sum(x.shape[2] for x in several), [], 0
    for x in several:
        found.append(np.pad(x, ((0, 0), (0, 0), (at, width - at - x.shape[2]))))
        at += x.shape[2]
    return np.concatenate(found)
