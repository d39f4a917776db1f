"""Signals of a controller: what they are called here and in C, and their units."""

import re
from dataclasses import dataclass

import numpy as np

from ..plants.response import vector
from ..runtime.read_only import ReadOnly

NOTHING_TO_SET = (
    "this controller has no set point: set points are of positions, and what it feeds "
    "back has none; measure a position"
)

#: How a name's marks are spelled in C.
SPELLED = (("integral of ", "sum_"), ("set point of ", "ref_"), ("'", "_rate"))


@dataclass(frozen=True)
class Signal:
    """A quantity that goes into a controller or comes out of it.

    Parameters
    ----------
    name : str
        As the plant calls it: ``q1``, or ``q1'`` for its rate.
    unit : str
        Such as "rad"; empty where nobody said.

    Examples
    --------
    >>> print(Signal("q1'", "rad/s"))
    q1' (rad/s)
    """

    name: str
    unit: str = ""

    def __str__(self):
        return f"{self.name} ({self.unit})" if self.unit else self.name


@dataclass(frozen=True, eq=False)
class Readings(ReadOnly):
    """The readings of a controller: y = rows x + noise w.

    Parameters
    ----------
    signals : tuple of Signal
        What they are called.
    rows, noise : (q, N) and (q, p_w) arrays
        Of the plant's state and of its disturbances.
    steps : (q,) array
        How fine each is measured, in its unit; zero where nobody said.
    """

    signals: tuple
    rows: np.ndarray
    noise: np.ndarray
    steps: np.ndarray


def unit_of(name, units):
    """The unit of a signal of this ``name``, from the ``units`` of coordinates and
    inputs.

    >>> [unit_of(name, {"q1": "rad"}) for name in ("q1", "q1'", "integral of q1")]
    ['rad', 'rad/s', 'rad s']
    """
    bare = name.removeprefix("set point of ")
    if bare in units:
        return units[bare]
    if bare.endswith("'") and bare[:-1] in units:
        return f"{units[bare[:-1]]}/s"
    summed = bare.removeprefix("integral of ")
    if summed != bare and summed in units:
        return f"{units[summed]} s"
    return ""


def signals_of(names, units):
    """A `Signal` for each of some names, with the units that are known."""
    return tuple(Signal(name, unit_of(name, units)) for name in names)


def identifiers(names):
    """The end of a macro of C for each of some ``names``; a ValueError if one can't be
    spelled, or two are spelled alike.

    >>> identifiers(["q1", "q1'", "set point of q1"])
    ['Q1', 'Q1_RATE', 'REF_Q1']
    """
    words = []
    for name in names:
        word = name
        for mark, spelled in SPELLED:
            word = word.replace(mark, spelled)
        word = re.sub(r"[ +().-]+", "_", word).strip("_").upper()
        if not re.fullmatch(r"[A-Z0-9][A-Z0-9_]{0,30}", word):
            raise ValueError(
                f"the signal {name!r} can't be a name of C: give the plant coordinates "
                "of letters, digits and _, at most 31"
            )
        if word in words:
            raise ValueError(f"two signals would be {word} in C: rename {name!r}")
        words.append(word)
    return words


def known_index(name, k, signals):
    """A ValueError with the ``name`` unless k is the index of one of the signals."""
    if name == "set_point" and not signals:
        raise ValueError(NOTHING_TO_SET)
    if k not in range(len(signals)):
        known = ", ".join(f"{i}: {s.name}" for i, s in enumerate(signals))
        raise ValueError(f"{name} must be one of {known}; got {k!r}")


def vector_of(name, value, size):
    """A ``value`` called ``name``, of ``size`` set points or disturbances; or zeros."""
    if value is None:
        return np.zeros(size)
    if name == "r" and not size:
        raise ValueError(NOTHING_TO_SET)
    return vector(name, np.atleast_1d(value), size)
