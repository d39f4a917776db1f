"""A loop with a delayed input and what is asked of it, as LMI blocks."""

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from flint import arb, fmpq

from ..exact.definite import exact, inverse
from ..laws import FullState
from ..loops.clock import one_delay
from ..plants.checks import is_word, matrix, not_negative, positive
from ..plants.descriptor import Descriptor, twins
from ..plants.gain import gain_of
from ..plants.kinds import checked_plant
from ..runtime.array_like import ArrayLike
from ..runtime.read_only import ReadOnly
from ..synthesis.request import Request
from ..synthesis.scaling import Frame
from .forms import FORMS
from .theorems import MISPRINTS, Times

METHODS = tuple(FORMS)


@dataclass(frozen=True, eq=False)
class DelayedLoop(ReadOnly):
    """A loop x' = A x + A_d x(t - d(t)) that is given as such.

    Parameters
    ----------
    A, A_d : (N, N) array_like
        The matrices of x' = A x + A_d x(t - d).
    """

    A: np.ndarray
    A_d: np.ndarray
    family = None  # as of a plant without parameters

    def __post_init__(self):
        A = matrix("A", self.A)
        if len(A) != A.shape[1]:
            raise ValueError(f"A must be square, got {A.shape}")
        object.__setattr__(self, "A", A)
        object.__setattr__(self, "A_d", matrix("A_d", self.A_d, A.shape))

    def per_vertex(self, values):
        """The one value of the one vertex, of a sequence ``values``."""
        return values[0]

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
        return (Descriptor(np.eye(N), self.A, self.A_d, np.zeros((N, 0)), np.eye(N)),)


@dataclass(frozen=True, eq=False)
class DelayRequest(ReadOnly):
    """A request: a loop with a delayed input and its requirements.

    The parameters plant, U, tau, mu, delta, alpha, method and order are those
    of `design_delay_pid` and `analyse_delay`; ``gain`` is the K that is
    analysed, and ``misprints`` says what to read as printed.

    The LMIs are written in the coordinates of a `Frame`, with tau as
    the unit of time: only their conditioning depends on that.
    """

    plant: Any
    U: ArrayLike | None = None
    tau: float | None = None
    mu: float = 0.0
    delta: float = 0.0
    alpha: float | None = None
    method: str = "functional"
    order: int | None = None
    misprints: tuple = ()
    gain: ArrayLike | None = None
    free: Request = field(init=False)

    def __post_init__(self):
        """Check the numbers, the method and the gain."""
        put = object.__setattr__
        if self.tau is None:
            raise ValueError("tau is missing: give the nominal delay")
        one_delay(self.tau)
        put(self, "tau", positive("tau", self.tau))
        for name in ("mu", "delta"):
            put(self, name, not_negative(name, getattr(self, name)))
        if self.mu > self.tau:
            raise ValueError(
                f"mu = {self.mu} exceeds tau = {self.tau}: the delay "
                "tau - mu would be negative; take mu <= tau"
            )
        if self.alpha is not None:
            put(self, "alpha", positive("alpha", self.alpha))
        if not is_word(self.method, METHODS):
            raise ValueError(
                f"method must be one of {', '.join(METHODS)}, got {self.method!r}"
            )
        if not set(self.misprints) <= set(MISPRINTS):
            raise ValueError(f"misprints must be among {MISPRINTS}")
        if self.misprints and self.method != "functional":
            raise ValueError(
                'printed=True reads the thesis: leave method out or "functional"'
            )
        if isinstance(self.plant, DelayedLoop):
            put(self, "free", self.plant)
            if self.gain is None:
                put(self, "gain", np.eye(self.plant.m))
        else:
            put(self, "plant", checked_plant(self.plant, of="a late input"))
            put(self, "free", _free(self.plant, self.U))
        if self.gain is not None:
            K, shape = self.gain, (self.plant.m, self.free.order)
            if not isinstance(self.plant, DelayedLoop):
                K = gain_of(K, self.plant, self.U)
            put(self, "gain", matrix("K", K, shape))
        self._check_form()

    def _check_form(self):
        """Check the plant, the gain and the order that a method needs."""
        form = FORMS[self.method]
        if not form.first_order:
            return
        if self.gain is None:
            raise ValueError(
                f'method="{self.method}" analyses a given gain; design with '
                '"functional" or "shift"'
            )
        if len(self.vertices) > 1:
            raise ValueError(
                f'method="{self.method}" takes one plant: its blocks are not '
                "affine in M; analyse the vertices one by one, or take "
                'method="shift"'
            )
        order = form.order if self.order is None else self.order
        integer = isinstance(order, (int, np.integer)) and not isinstance(order, bool)
        if not integer or order not in form.orders:
            raise ValueError(f"order must be {form.orders_in_words}, got {order!r}")
        object.__setattr__(self, "order", int(order))

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
        """True if the LMIs depend on alpha."""
        return self.gain is None or "alpha" in self.misprints

    def at(self, **changes):
        """The request with some ``changes`` of its parameters."""
        return replace(self, **changes)

    @cached_property
    def frame(self):
        """Coordinates of x and u, from the loop without delay."""
        if isinstance(self.plant, DelayedLoop):
            one = np.eye(self.states)
            return Frame(one, one, one, 1.0)
        return Frame.of(self.free)

    def times(self, number=lambda x: x):
        """`Times` in units of tau, read by ``number``; exponentials round down."""
        return Times(*(_read(q, number) for q in self._rational_times))

    @cached_property
    def _rational_times(self):
        tau, mu, delta = map(exact, (self.tau, self.mu, self.delta))
        mu, delta = mu / tau, delta * tau
        if FORMS[self.method].shifted:
            delta = fmpq(0)
        decays = [exp_bound(-2 * delta), exp_bound(-2 * delta * (1 + mu))]
        return fmpq(1), mu, delta, *decays

    def factors(self, number=lambda x: x):
        """Bounds of e^(delta d), the input's factor, read by ``number``."""
        if not FORMS[self.method].shifted:
            return [("", 1)]
        delta, tau, mu = map(exact, (self.delta, self.tau, self.mu))
        ends = [exp_bound(delta * (tau - mu)), exp_bound(delta * (tau + mu), up=True)]
        if self.delta == 0:
            return [("", 1)]
        names = " shortest", " longest"
        return list(zip(names, (_read(q, number) for q in ends)))

    def unknowns(self):
        """The unknown matrices, the multipliers last."""
        return FORMS[self.method].unknowns(self)

    def blocks(self, values, number=lambda x: x, vertices=None):
        """All blocks that must be positive, by name, for ``values`` of the unknowns.

        ``number`` brings floats into their arithmetic; ``vertices`` stand for the
        plant's.
        """
        loops = self.loops(number, vertices)
        return FORMS[self.method].blocks(self, values, number, loops)

    def in_unknowns(self, number=lambda x: x, vertices=None):
        """`blocks` in `unknowns`, and these; ``number``, ``vertices`` as there."""
        unknowns = self.unknowns()
        values = {u.name: u for u in unknowns}
        return self.blocks(values, number, vertices), unknowns

    def closed_loops(self, number=lambda x: x):
        """(block's name, (E, A, A_d)) of each loop, read by ``number``."""
        K = self.scaled_gain(number)
        for tag, d in self.loops(number):
            yield "decay" + tag, (d.E, d.A, d.Bu @ K)

    def loops(self, number, vertices=None):
        """(tag, Descriptor) in the frame, per factor; read by ``number``.

        A vertex of the plant that repeats an earlier one has no loop; ``vertices``
        stand for those of the plant.
        """
        left, T = number(self.frame.left), number(self.frame.T)
        numbers = self.frame.scale, self.tau, self.delta
        scale, tau, delta = (number(np.array(x)).item() for x in numbers)
        if vertices is None:
            vertices = self.vertices
            few = sorted(set(twins(vertices)))
        else:
            few = range(len(vertices))
        for i in few:
            d = vertices[i].map(number).change(left, T, scale)
            E, A, Bu = d.E, tau * d.A, tau * d.Bu
            if FORMS[self.method].shifted:
                A = A + tau * delta * E
            if FORMS[self.method].first_order:
                back = inverse(E)
                E, A, Bu = back @ E, back @ A, back @ Bu
            index = f" {i + 1}" if len(vertices) > 1 else ""
            for tag, factor in self.factors(number):
                yield index + tag, Descriptor(E, A, Bu * factor, d.Bw, d.C, d.Du)

    def scaled_gain(self, number):
        """K in the frame, in the arithmetic of ``number``."""
        scale = number(np.array(self.frame.scale)).item()
        return number(self.gain) @ number(self.frame.T) / scale

    @property
    def law(self):
        """Every gain is one of the whole state."""
        return FullState(self.U)

    @property
    def applied(self):
        """The law on the plant."""
        return self.law.applied(self.plant)

    def relative_alpha(self, number):
        """alpha in units of tau, in the arithmetic of ``number``; 1 without one."""
        if self.alpha is None:
            return 1
        return _read(exact(self.alpha) / exact(self.tau), number)


def check_loop(plant, K, U):
    """Refuse K and U beside a plant that is a `DelayedLoop`."""
    if isinstance(plant, DelayedLoop) and (K is not None or U is not None):
        raise ValueError("a DelayedLoop has its controller inside: leave K and U out")


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
    """A rational just below e^x, or above if ``up``, of so many ``digits``: by balls.

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
