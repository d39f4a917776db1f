"""Records of a machine: what went in, and what its sensors said."""

from collections.abc import Sequence
from dataclasses import dataclass
from os import PathLike

import numpy as np

from ..plants.checks import checked_names, numbers
from ..runtime.array_like import ArrayLike
from ..runtime.reading import named, numbers_of, read_rows

__all__ = ["Record"]

ON_TIME = 0.01  # share of a period; a sample this near its time is on time
MISSING_AFTER = 1.75  # periods between two samples; from here on one is missing


class Ticks:
    """The clock of a log, by its times t."""

    t: np.ndarray

    @property
    def T(self) -> float:
        """Sampling time in s."""
        span = float(self.t[-1] - self.t[0])
        return float(f"{span / (len(self.t) - 1):.9g}")

    @property
    def steps(self) -> np.ndarray:
        """(N,) array: the time from each sample to the next, in s.

        The mean where they are even, to a hundredth of it; else what
        the time stamps say. After the last one comes another mean.
        """
        steps = np.append(np.diff(self.t), self.T)
        if abs(steps / self.T - 1).max() <= ON_TIME:
            steps[:] = self.T
        return steps

    @property
    def even(self) -> bool:
        """True if the samples are equally far apart."""
        return bool(np.ptp(self.steps) == 0)


@dataclass(frozen=True, eq=False)
class Record(Ticks):
    """A log of a machine, for `sosbook.identify`.

    Parameters
    ----------
    t : (N,) array_like
        The times of the samples in s. They needn't be equally far apart.
    u : (N,) or (N, m) array_like
        The inputs, each held from its sample to the next.
    y : (N,) or (N, q) array_like
        What the sensors said, read before u acts: in the units of the plant's outputs,
        so counts of an encoder times its step.
    inputs, outputs : sequence of str, optional
        Names of the columns of u and y; they are numbered without them.

    Raises
    ------
    ValueError
        If lengths differ, a number isn't finite, t doesn't increase, or samples are
        missing.

    Examples
    --------
    >>> Record([0, 0.01, 0.02], u=[1, 1, 0], y=[0, 0, 0.1])
    <Record: 3 samples, 0.01 s apart; u1 to y1>
    """

    t: np.ndarray
    u: np.ndarray
    y: np.ndarray
    inputs: tuple = ()
    outputs: tuple = ()

    def __init__(
        self,
        t: ArrayLike,
        u: ArrayLike,
        y: ArrayLike,
        inputs: tuple = (),
        outputs: tuple = (),
    ) -> None:
        """Check the columns, and name them."""
        object.__setattr__(self, "t", column("t", t))
        gapless(self.t)
        for of, key, value, names in (("inputs", "u", u, inputs),
                                      ("outputs", "y", y, outputs)):  # fmt: skip
            array = numbers(key, value)
            array = array[:, None] if array.ndim == 1 else array
            if array.ndim != 2 or len(array) != len(self.t) or not array.shape[1]:
                raise ValueError(
                    f"{key} must have a row for each of the {len(self.t)} times, got "
                    f"shape {array.shape}"
                )
            count = array.shape[1]
            names = tuple(names) or tuple(f"{key}{k + 1}" for k in range(count))
            object.__setattr__(self, of, checked_names(names, count, of))
            whole = [column(name, x) for name, x in zip(names, array.T)]
            object.__setattr__(self, key, np.array(whole).T)

    def __repr__(self):
        names = ", ".join(self.inputs), ", ".join(self.outputs)
        apart = f"{self.T:.6g} s apart{'' if self.even else ' in the mean'}"
        return f"<Record: {len(self.t)} samples, {apart}; {' to '.join(names)}>"

    @classmethod
    def read(
        cls,
        path: str | PathLike,
        inputs: Sequence[str],
        outputs: Sequence[str],
        time: str = "t",
        **units: float,
    ) -> "Record":
        """The record in a CSV file, whose first row has names.

        Parameters
        ----------
        path : str or Path
            The file.
        inputs, outputs : sequence of str
            The columns of the inputs and of the sensors; others are left out.
        time : str
            The column of the times.
        **units : float
            What one unit of a column is, by its name, in the plant's units:
            ``motor=2 * np.pi / 4096`` for an encoder's counts, ``t=1e-3`` for ms.

        Raises
        ------
        ValueError
            If a column is missing, or as for `Record`.
        OSError
            If there is no such file.
        """
        rows = read_rows(path)
        names = [name.strip() for name in rows[0]] if rows else []
        asked = time, *inputs, *outputs
        lost = [name for name in (*asked, *units) if names.count(name) != 1]
        if lost:
            raise ValueError(
                f"{path}: the first row must name {lost[0]} once; it is "
                f"{','.join(names)!r:.80}"
            )
        table = dict(zip(names, numbers_of(path, rows, names).T))
        t, *others = (table[name] * units.get(name, 1.0) for name in asked)
        u, y = others[: len(inputs)], others[len(inputs) :]
        with named(path):
            return cls(t, np.array(u).T, np.array(y).T, tuple(inputs), tuple(outputs))


def column(name, value):
    """A read-only float vector, or a ValueError that names it."""
    array = numbers(name, value)
    if array.ndim != 1:
        raise ValueError(
            f"{name} must be a list of numbers, got {array.ndim} dimensions"
        )
    wrong = np.flatnonzero(~np.isfinite(array))
    if wrong.size:
        raise ValueError(
            f"{name} isn't finite at row {wrong[0] + 1}: a "
            "missing sample? cut the log there or fill it in"
        )
    array.flags.writeable = False
    return array


def gapless(t):
    """A ValueError if t doesn't increase or samples are missing."""
    if len(t) < 3:
        raise ValueError(f"t has {len(t)} samples; a log needs at least 3")
    step = np.diff(t)
    if (step <= 0).any():
        raise ValueError(
            f"t must increase; it doesn't after row {np.flatnonzero(step <= 0)[0] + 1}"
        )
    T = np.median(step)
    for k in np.flatnonzero(step > MISSING_AFTER * T)[:1]:
        gone = max(round(step[k] / T) - 1, 1)
        raise ValueError(
            f"t: {gone} sample{'s' * (gone > 1)} missing after "
            f"t = {t[k]:g} s (row {k + 1}); cut the log there or fill it in"
        )
