"""A loop with a delayed input and what is asked of it, as LMI blocks."""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from flint import arb, fmpq

from ..lmi import Unknown
from ..lmi.exact import exact, inverse
from ..plants.checks import matrix, number, positive
from ..plants.descriptor import Descriptor
from ..plants.second_order import SecondOrderSystem
from ..synthesis.problem import Request
from ..synthesis.scaling import Frame
from ..theorems import (
    MISPRINTS,
    Functional,
    Times,
    delay_decay,
    delay_functional,
    delay_stabilization,
    legendre_decay,
    legendre_functional,
)

__all__ = ["METHODS", "DelayRequest", "DelayedLoop", "exp_bound"]

METHODS = ("functional", "shift", "legendre")


@dataclass(frozen=True, eq=False)
class DelayedLoop:
    """A loop x' = A x + A_d x(t - d(t)) that is given as such.

    Parameters
    ----------
    A, A_d : (N, N) array_like
    """

    A: np.ndarray
    A_d: np.ndarray

    def __post_init__(self):
        A = matrix("A", self.A)
        if len(A) != A.shape[1]:
            raise ValueError(f"A must be square, got {A.shape}")
        object.__setattr__(self, "A", A)
        object.__setattr__(self, "A_d", matrix("A_d", self.A_d, A.shape))

    @property
    def m(self):
        """Number of inputs: A_d = B_u K is read with K = I."""
        return len(self.A)

    @property
    def order(self):
        """Number of states."""
        return len(self.A)

    @property
    def vertices(self):
        """The one vertex, with B_u = A_d."""
        N = len(self.A)
        return (Descriptor(
            np.eye(N), self.A, self.A_d, np.zeros((N, 0)), np.eye(N)),)


@dataclass(frozen=True, eq=False)
class DelayRequest:
    """Parameters are those of `design_delay_pid` and `analyse_delay`.

    The LMIs are written in the coordinates of a `Frame`, with tau as
    the unit of time: only their conditioning depends on that.
    """

    plant: object
    U: np.ndarray = None
    tau: float = None
    mu: float = 0.0
    delta: float = 0.0
    alpha: float = None
    method: str = "functional"
    order: int = 2
    misprints: tuple = ()
    gain: np.ndarray = None
    free: Request = field(init=False)

    def __post_init__(self):
        put = object.__setattr__
        if self.tau is None:
            raise ValueError("tau is missing: give the nominal delay")
        put(self, "tau", positive("tau", self.tau))
        for name in ("mu", "delta"):
            value = number(name, getattr(self, name))
            if value < 0:
                raise ValueError(
                    f"{name} must not be negative, got {value!r}")
            put(self, name, value)
        if self.mu > self.tau:
            raise ValueError(
                f"mu = {self.mu} exceeds tau = {self.tau}: the delay "
                "tau - mu would be negative; take mu <= tau"
            )
        if self.alpha is not None:
            put(self, "alpha", positive("alpha", self.alpha))
        if self.method not in METHODS:
            raise ValueError(
                f"method must be one of {', '.join(METHODS)}, got "
                f"{self.method!r}"
            )
        if not set(self.misprints) <= set(MISPRINTS):
            raise ValueError(f"misprints must be among {MISPRINTS}")
        if self.misprints and self.method != "functional":
            raise ValueError(
                'printed=True reads the thesis: leave method out or '
                '"functional"'
            )
        if isinstance(self.plant, DelayedLoop):
            put(self, "free", self.plant)
            if self.gain is None:
                put(self, "gain", np.eye(self.plant.m))
        else:
            put(self, "free", _free(self.plant, self.U))
        if self.gain is not None:
            shape = self.plant.m, self.free.order
            put(self, "gain", matrix("K", self.gain, shape))
        if self.method != "legendre":
            return
        if self.gain is None:
            raise ValueError(
                'method="legendre" analyses a given gain; design with '
                '"functional" or "shift"'
            )
        if not isinstance(self.plant, (SecondOrderSystem, DelayedLoop)):
            raise ValueError(
                'method="legendre" takes one plant: its blocks are not '
                "affine in M; analyse the vertices one by one, or take "
                'method="shift"'
            )
        integer = isinstance(self.order, (int, np.integer))
        if not integer or isinstance(self.order, bool) or self.order < 0:
            raise ValueError(f"order must be 0, 1, 2, ..., got {self.order!r}")
        put(self, "order", int(self.order))

    @property
    def states(self):
        """2n + a, the number of states."""
        return self.free.order

    @property
    def vertices(self):
        """One `Descriptor` for each vertex of the plant."""
        return self.free.vertices

    @property
    def needs_alpha(self):
        """Whether the LMIs depend on alpha."""
        return self.gain is None or "alpha" in self.misprints

    def at(self, **changes):
        """The request with other parameters."""
        return replace(self, **changes)

    @cached_property
    def frame(self):
        """Coordinates of x and u, from the loop without delay."""
        if isinstance(self.plant, DelayedLoop):
            one = np.eye(self.states)
            return Frame(one, one, one, 1.0)
        return Frame.of(self.free)

    def times(self, number=lambda x: x):
        """`Times` with tau as the unit; exponentials rounded down."""
        tau, mu, delta = map(exact, (self.tau, self.mu, self.delta))
        mu, delta = mu / tau, delta * tau
        if self.method != "functional":
            delta = fmpq(0)
        return Times(*(_read(q, number) for q in (
            fmpq(1), mu, delta, exp_bound(-2 * delta),
            exp_bound(-2 * delta * (1 + mu)),
        )))

    def factors(self, number=lambda x: x):
        """Bounds of e^(delta d), which multiplies the shifted input."""
        if self.method == "functional":
            return [("", 1)]
        delta, tau, mu = map(exact, (self.delta, self.tau, self.mu))
        ends = [exp_bound(delta * (tau - mu)),
                exp_bound(delta * (tau + mu), up=True)]
        if self.delta == 0:
            return [("", 1)]
        names = " shortest", " longest"
        return list(zip(names, (_read(q, number) for q in ends)))

    def unknowns(self):
        """The unknown matrices, the multipliers last."""
        N, m = self.states, self.plant.m

        def symmetric(name, size=N):
            return Unknown(name, size, symmetric=True)

        Z = [symmetric("Z")] if self.mu else []
        if self.method == "legendre":
            P = symmetric("P", (1 + self.order) * N)
            return [P, symmetric("S"), symmetric("R"), *Z]
        found = [
            symmetric("P"), Unknown("Q", N), symmetric("S"),
            symmetric("R1"), Unknown("R2", N), symmetric("R3"), *Z,
            Unknown("F", N),
        ]
        if self.gain is None:
            return [*found, Unknown("X", m, N)]
        return [*found, Unknown("G", N)]

    def blocks(self, values, number=lambda x: x):
        """All blocks that must be positive definite, by name.

        Parameters
        ----------
        values : dict
            From an unknown's name to a matrix-like.
        number : callable
            Brings floats into the arithmetic of the values.
        """
        t = self.times(number)
        v = dict(values)
        v.setdefault("Z", 0 * v["S"])
        if self.method == "legendre":
            found = {"functional": legendre_functional(
                v["P"], v["S"], self.order, t)}
            found |= {name: v[name] for name in ("S", "R")}
        else:
            functional = Functional(*(
                v[name] for name in ("P", "Q", "S", "R1", "R2", "R3", "Z")))
            whole, rates = delay_functional(functional, t)
            found = {"functional": whole, "R": rates}
        if self.mu and "sign" not in self.misprints:
            found["Z"] = v["Z"]
        for tag, d in self._loops(number):
            if self.method == "legendre":
                A, Ad = d.A, d.Bu @ self._gain(number)
                form = legendre_decay(
                    A, Ad, v["P"], v["S"], v["R"], v["Z"], self.order, t)
            elif self.gain is None:
                form = delay_stabilization(
                    d, functional, v["F"], v["X"], t, self._alpha(number),
                    self.misprints)
            else:
                form = delay_decay(
                    d.E, d.A, d.Bu @ self._gain(number), functional,
                    v["F"], v["G"], t, self.misprints,
                    self._alpha(number))
            found["decay" + tag] = form
        return found

    def in_unknowns(self, number=lambda x: x):
        """`blocks` in `unknowns`: a dict of them, and a list."""
        unknowns = self.unknowns()
        return self.blocks({u.name: u for u in unknowns}, number), unknowns

    def _loops(self, number):
        """(tag, Descriptor) in the frame; with the shift, per factor."""
        left, T, scale, tau, delta = (
            number(np.array(x)) for x in (
                self.frame.left, self.frame.T, self.frame.scale, self.tau,
                self.delta)
        )
        scale, tau, delta = scale.item(), tau.item(), delta.item()
        for i, vertex in enumerate(self.vertices):
            d = vertex.map(number).change(left, T, scale)
            E, A, Bu = d.E, tau * d.A, tau * d.Bu
            if self.method != "functional":
                A = A + tau * delta * E
            if self.method == "legendre":
                back = inverse(E)
                E, A, Bu = back @ E, back @ A, back @ Bu
            index = f" {i + 1}" if len(self.vertices) > 1 else ""
            for tag, factor in self.factors(number):
                yield index + tag, Descriptor(
                    E, A, Bu * factor, d.Bw, d.C)

    def _gain(self, number):
        scale = number(np.array(self.frame.scale)).item()
        return number(self.gain) @ number(self.frame.T) / scale

    def _alpha(self, number):
        if self.alpha is None:
            return 1
        return _read(exact(self.alpha) / exact(self.tau), number)


def check_loop(plant, K, U):
    """Refuse K and U beside a `DelayedLoop`."""
    if isinstance(plant, DelayedLoop) and (K is not None or U is not None):
        raise ValueError(
            "a DelayedLoop has its controller inside: leave K and U out")


def _free(plant, U):
    """The request without delay: checks the plant and U."""
    try:
        return Request(plant, U)
    except ValueError as error:
        if "is singular" not in str(error):
            raise
        raise ValueError(
            "M is singular: an acceleration gain that mends it would act "
            "through the delay and make the loop neutral, E z''(t) - B K_A "
            "z''(t - d); the theorems with delay don't cover that"
        ) from None


def _read(q, number):
    """A rational in the arithmetic of ``number``."""
    if isinstance(number(np.array([1.0]))[0], fmpq):
        return q
    return int(q.p) / int(q.q)


def exp_bound(x, up=False, digits=12):
    """A rational just below (or above) e^x.

    Parameters
    ----------
    x : fmpq
    up : bool
    digits : int
        Significant decimal digits.

    Returns
    -------
    fmpq
        Certified by ball arithmetic; 1 for x = 0.

    Examples
    --------
    >>> exp_bound(fmpq(1), digits=4), exp_bound(fmpq(1), True, digits=4)
    (1359/500, 2719/1000)
    """
    if x == 0:
        return fmpq(1)
    ball = arb(x).exp()
    mantissa, exponent = f"{float(ball.mid()):.{digits - 1}e}".split("e")
    power = fmpq(10) ** int(exponent)
    near, unit = exact(float(mantissa)) * power, power / 10 ** (digits - 1)
    for step in (-unit, fmpq(0), unit):
        bound = near + step if up else near - step
        if ball < bound if up else ball > bound:
            return bound
    raise ArithmeticError(f"e^{x} can't be bounded to {digits} digits")
