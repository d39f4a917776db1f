"""A gain that knows what it multiplies."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..runtime.read_only import ReadOnly
from .checks import matrix


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


def input_names(m):
    """What the m inputs of a plant are called: u, or u1, u2, ..."""
    return ("u",) if m == 1 else tuple(f"u{k + 1}" for k in range(m))


def signals(plant, U=None, older=0):
    """What the columns of a gain of this ``plant`` multiply: [z; z'; x3] by name.

    Without ``coordinates`` z are z1, z2, ..., the state of a DescriptorSystem x1, x2,
    ...; x3 is the integral of U z; ``older`` inputs of a sampled gain are last.

    >>> from sosbook import SecondOrderSystem
    >>> cart = SecondOrderSystem(1, 0, 0, 1, coordinates=("place",))
    >>> signals(cart, [[1]], older=1)
    ('place', "place'", 'integral of place', 'u(k-1)')
    """
    late = [f"{u}(k-{k + 1})" for k in range(older) for u in input_names(plant.m)]
    if not hasattr(plant, "coordinates"):
        return (*(f"x{k + 1}" for k in range(plant.order)), *late)
    z = plant.coordinates or tuple(f"z{k + 1}" for k in range(plant.n))
    rows = () if U is None else np.atleast_2d(np.asarray(U, float))

    def mixed(row):
        there = [(share, name) for share, name in zip(row, z) if share]
        return " + ".join(name if x == 1 else f"{x:g} {name}" for x, name in there)

    sums = (f"integral of {mixed(row)}" for row in rows)
    return (*z, *(f"{x}'" for x in z), *sums, *late)
