"""A gain that knows what it multiplies."""

import re
from dataclasses import dataclass

import numpy as np

from ..exact.rational import decimal
from ..runtime.array_like import ArrayLike
from ..runtime.names import claimed
from ..runtime.read_only import ReadOnly
from .checks import matrix

OF_A_LAW = (
    "K has gains of a law, or of accelerations: K x isn't all of u. Give law=, or K "
    "and K_A, where these are arguments; what is sampled takes design.controller(T=...)"
)
LATE = re.compile(r"\(k-\d+\)$")  # in the name of an older input


@dataclass(frozen=True, eq=False)
class Gain(ReadOnly):
    """u = K s: a gain, and the names of the signals s that it multiplies.

    Parameters
    ----------
    K : (m, N) array_like
        The gain.
    signals : sequence of str
        What its N columns multiply, in their order, each named once.

    Raises
    ------
    ValueError
        If K isn't a matrix of finite numbers, or there isn't a name for each
        column.

    Examples
    --------
    >>> gain = Gain([[20, 2]], ("theta", "theta'"))
    >>> gain.columns(("theta'", "theta"))
    array([[ 2., 20.]])
    """

    K: np.ndarray
    signals: tuple

    def __post_init__(self):
        object.__setattr__(self, "K", matrix("K", np.atleast_2d(self.K)))
        names = self.signals
        words = () if isinstance(names, str) else tuple(names)
        if not all(isinstance(x, str) and x for x in words) or (
            len(set(words)) < len(words) or len(words) != self.K.shape[1]
        ):
            raise ValueError(
                f"signals must name each of K's {self.K.shape[1]} columns once, "
                f"got {names!r}"
            )
        object.__setattr__(self, "signals", words)
        super().__post_init__()

    def __eq__(self, other):
        if not isinstance(other, Gain):
            return NotImplemented
        return self.signals == other.signals and np.array_equal(self.K, other.K)

    __hash__ = None  # type: ignore[assignment]

    def but(self, K: ArrayLike) -> "Gain":
        """Another ``K`` of the same signals, such as ``design.certify().K``."""
        return Gain(np.asarray(K), self.signals)

    def columns(self, signals: tuple) -> np.ndarray:
        """K with its columns in the order of these ``signals``, which are its own."""
        return self.K[:, [self.signals.index(name) for name in signals]]


class GainParts(dict):
    """The parts of a gain by name; side by side they multiply what ``signals`` names.

    Without ``signals`` they are a law's, or have K_A: then K x isn't all of u.
    """

    def __init__(self, parts, signals=()):
        super().__init__(parts)
        self.signals = tuple(signals)

    @property
    def gain(self):
        """All parts as one `Gain`."""
        if not self.signals:
            raise ValueError(OF_A_LAW)
        return Gain(np.hstack(list(self.values())), self.signals)


def named(K):
    """The `Gain` of a design or its ``gains``; other numbers K as they are."""
    if hasattr(K, "of_state"):
        raise ValueError(
            "K is a Controller, which has a clock and a memory: its own loop is proven "
            "by controller.certify(...), and by certify_sampled and furthest_sampled"
        )
    K_A = getattr(getattr(K, "request", None), "K_A", None)
    if K_A is not None and np.any(K_A):
        raise ValueError("the design has an acceleration gain: give design.K and K_A")
    return getattr(K, "gain", K)


def gain_of(K, plant, U=None):
    """K as a matrix whose columns multiply what `signals` names, in this order.

    A matrix is taken as it is; a `Gain`, a design, or its ``gains``, by names. Raises
    ValueError where they aren't those of the ``plant`` with ``U``.

    >>> from sosbook import SecondOrderSystem
    >>> gain_of(Gain([[2, 20]], ("z1'", "z1")), SecondOrderSystem(1, 0, 0, 1))
    array([[20.,  2.]])
    """
    law = getattr(getattr(K, "request", None), "law", None)
    if not getattr(law, "whole", True):
        raise ValueError(OF_A_LAW)
    gain = named(K)
    if isinstance(gain, dict):
        raise ValueError(
            "K is a dict of gains by name, which a law has: give law=, too, or the "
            "design, its gains, or K as one matrix, [K_P K_D K_I]"
        )
    if not isinstance(gain, Gain):
        return gain
    older = sum(bool(LATE.search(name)) for name in gain.signals) // plant.m
    names = signals(plant, U, older)
    if sorted(names) != sorted(gain.signals):
        raise ValueError(
            f"K is a gain of {', '.join(gain.signals)}, but this plant's is of "
            f"{', '.join(names)}: give the same coordinates and U, or a plain matrix "
            "in this order"
        )
    return gain.columns(names)


def input_names(m):
    """The names of the m inputs of a plant: u, or u1, u2, ..."""
    return ("u",) if m == 1 else tuple(f"u{k + 1}" for k in range(m))


def signals(plant, U=None, older=0):
    """The signals that the columns of a gain of this ``plant`` multiply: [z; z'; x3] by
    name.

    Without ``coordinates`` z are z1, z2, ..., the state of a DescriptorSystem x1, x2,
    ...; x3 is the integral of U z; ``older`` inputs of a sampled gain are last.

    >>> from sosbook import SecondOrderSystem
    >>> cart = SecondOrderSystem(1, 0, 0, 1, coordinates=("place",))
    >>> signals(cart, [[1]], older=1)
    ('place', "place'", 'integral of place', 'u(k-1)')
    """
    late = [f"{u}(k-{k + 1})" for k in range(older) for u in input_names(plant.m)]
    if not hasattr(plant, "coordinates"):
        if plant.states is not None:
            return (*plant.states, *late)
        return (*(f"x{k + 1}" for k in range(plant.order)), *late)
    z = plant.coordinates or tuple(f"z{k + 1}" for k in range(plant.n))
    rows = () if U is None else np.atleast_2d(np.asarray(U, float))

    def mixed(row):
        there = [(share, name) for share, name in zip(row, z) if share]
        return " + ".join(name if x == 1 else f"{x:g} {name}" for x, name in there)

    sums = (f"integral of {mixed(row)}" for row in rows)
    return (*z, *(f"{x}'" for x in z), *sums, *late)


def states_data(plant):
    """The names of the states of a ``plant`` that has some, and its tick."""
    names, dt = getattr(plant, "states", None), getattr(plant, "dt", None)
    found = {} if names is None else {"states": claimed(names)}
    return found if dt is None else found | {"dt": decimal(dt)}
