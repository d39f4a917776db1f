"""A log of one experiment: time, voltage and what the sensors said."""

from dataclasses import dataclass, fields

import numpy as np

from ..analysis.records import Ticks, column, gapless
from ..plants.checks import numbers
from ..runtime.reading import named, numbers_of, read_rows
from ..runtime.writing import write_file
from .counters import Counter

__all__ = ["Log"]

FORMATS = {
    "t": "{:.9g}",
    "V": "{:.6g}",
    "gyro": "{:.5g}",
    "encoder1": "{:.9g}",
    "encoder2": "{:.9g}",
    "alone": "{:.0f}",
}
SENSORS = "gyro", "encoder1", "encoder2"
MOST_LOST = 3  # samples in a row that lines may fill
LOST_SHARE = 0.02  # of all samples, that may be filled


@dataclass(frozen=True, eq=False)
class Log(Ticks):
    """Samples of an experiment, one after the other in time.

    ``t``, (N,): time in s; ``V``, (N,): mean motor voltage, held from this sample to
    the next one; ``gyro``, (N,): the body's speed theta' in rad/s, read before V acts;
    ``encoder1``, ``encoder2``, (N,): counts of the wheels against the body, read before
    V acts. Those of a counter of 8 to 32 bits that goes over its end are unwrapped;
    ``alone``, (N,): 1 or 2 where the left or the right motor alone makes V, else 0.
    Raises ValueError if a column has another length or entries that aren't finite, or
    if samples are missing.

    Where a sensor said nothing, nan, for up to three samples, and for a fiftieth of
    them in all, the lines between its neighbours are put in; ``filled`` says how many.

    >>> log = Log(t=[0, 0.01, 0.02], V=[0, 1, 1], gyro=[0, 0, -0.3])
    >>> log.T
    0.01
    >>> Log(t=[0, 0.01, 0.03, 0.04], V=[0, 1, 1, 1])
    Traceback (most recent call last):
        ...
    ValueError: t: 1 sample missing after t = 0.01 s (row 2); cut the log
    there or fill it in
    """

    t: np.ndarray
    V: np.ndarray
    gyro: np.ndarray | None = None
    encoder1: np.ndarray | None = None
    encoder2: np.ndarray | None = None
    alone: np.ndarray | None = None

    def __post_init__(self):
        """Bridge lost readings, unwrap angles, check lengths and the clock."""
        lost = {}
        for x in fields(self):
            value = getattr(self, x.name)
            if value is None and x.name not in ("t", "V"):
                continue
            if x.name in SENSORS:
                value, lost[x.name] = bridged(x.name, value)
            object.__setattr__(self, x.name, column(x.name, value))
        object.__setattr__(self, "filled", {x: n for x, n in lost.items() if n})
        object.__setattr__(self, "unwrapped", self._unwrap())
        for x in fields(self):
            value = getattr(self, x.name)
            if value is not None and len(value) != len(self.t):
                raise ValueError(
                    f"{x.name} has {len(value)} samples, t has {len(self.t)}"
                )
        if self.alone is not None and not np.isin(self.alone, (0, 1, 2)).all():
            raise ValueError("alone must be 0, 1 (left) or 2 (right) in every row")
        gapless(self.t)

    def _unwrap(self):
        """Let counters go on; for each of them its name and its `Counter`."""
        found = {}
        for name in ("encoder1", "encoder2"):
            given = getattr(self, name)
            counter = None if given is None else Counter.of(given)
            if counter is not None and not len(counter.wild):
                object.__setattr__(self, name, column(name, counter.counts))
                found[name] = counter
        return found

    def evenly(self, *columns):
        """Columns at even times: V as it is held, others by lines.

        Returns list of (N,) array: V, and the columns.
        """
        t = self.t[0] + self.T * np.arange(len(self.t))
        held = np.searchsorted(self.t, t + 1e-9 * self.T, "right") - 1
        return [self.V[held], *(np.interp(t, self.t, y) for y in columns)]

    def part(self, rows):
        """The log of some ``rows``, a slice."""
        columns = {x.name: getattr(self, x.name) for x in fields(self)}
        return Log(**{x: None if y is None else y[rows] for x, y in columns.items()})

    def need(self, *names):
        """The columns of these names; a ValueError says which is missing."""
        for name in names:
            if getattr(self, name) is None:
                raise ValueError(
                    f"the log has no column {name}; it needs "
                    f"{', '.join(('t', 'V', *names))}"
                )
        return [getattr(self, name) for name in names]

    @classmethod
    def read(cls, path):
        """A log from the CSV file at ``path``, which has a row of names first.

        The names are t, V and those of gyro, encoder1, encoder2, alone that
        were recorded; other columns are refused.
        """
        rows = read_rows(path)
        names = [name.strip() for name in rows[0]] if rows else []
        columns = [x.name for x in fields(cls)]
        unknown = [name for name in names if name not in columns]
        lost = [name for name in ("t", "V") if name not in names]
        if unknown or lost or len(set(names)) < len(names):
            raise ValueError(
                f"{path}: the first row must name t, V and some of gyro, "
                f"encoder1, encoder2, alone, each once; it is {','.join(names)!r:.80}"
            )
        table = numbers_of(path, rows, names)
        with named(path):
            return cls(**dict(zip(names, table.T)))

    def write(self, path):
        """Write the CSV file at ``path`` that `read` reads."""
        names = [x for x in FORMATS if getattr(self, x) is not None]
        form = ",".join(FORMATS[x] for x in names) + "\n"
        rows = zip(*(getattr(self, x).tolist() for x in names))
        text = ",".join(names) + "\n" + "".join(form.format(*x) for x in rows)
        write_file(path, text)


def bridged(name, value):
    """A sensor's column with lines where it said nothing shortly, and how many."""
    array = numbers(name, value)
    lost = np.isnan(array)
    if array.ndim != 1 or not lost.any() or lost[[0, -1]].any():
        return array, 0
    said = np.flatnonzero(~lost)
    if np.diff(said).max() > MOST_LOST + 1 or lost.mean() > LOST_SHARE:
        return array, 0
    array = np.interp(np.arange(len(array)), said, array[said])
    return np.round(array) if "encoder" in name else array, int(lost.sum())
