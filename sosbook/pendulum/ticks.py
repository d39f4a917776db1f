"""The log of a running program, a row at every tick."""

from dataclasses import dataclass, fields

import numpy as np

from ..runtime.reading import named, numbers_of, read_rows
from ..runtime.writing import write_file

__all__ = ["START", "STEER_COLUMNS", "TickLog"]

START = -1  # in the column fault: the row in which the robot was at rest
FORMATS = {
    "t": "{:.6f}",
    "gyro": "{:.7g}",
    "wheels": "{:.9g}",
    "tilt": "{:.6g}",
    "target": "{:.9g}",
    "rate": "{:.6g}",
    "V": "{:.9g}",
    "theta": "{:.9g}",
    "battery": "{:.5g}",
    "fault": "{:.0f}",
}
LATE = "late"  # ticks that came late so far: what the newer programs log
#: What a program that steers logs besides: the wheels' angles in rad, the motors'
#: volts, and the set point of the heading in rad.
STEER_COLUMNS = "left", "right", "V_left", "V_right", "heading"
HEADER = (
    f"the first line of a log is {','.join(FORMATS)}, of a program that steers also "
    f"{','.join(STEER_COLUMNS)}; the second one, at rest, has fault = {START}"
)


@dataclass(frozen=True, eq=False)
class TickLog:
    """The ticks of a program from one start to its end.

    Each is (N,): ``t`` in s; ``gyro``, ``wheels``, ``tilt``: what the program was
    given, in rad/s and rad, not a number where a sensor said nothing; ``target``,
    ``rate``: set points of phi and phi', in rad and rad/s; ``V``: what it answered;
    ``theta``: its estimate; ``battery`` in V, not a number where it isn't measured;
    ``fault``: `START` in the first row, which has the gyro's offset, the wheels and the
    tilt at rest, then the index in `FAULTS`. A program that steers has all of ``left``,
    ``right``: the wheels' angles against the body; ``V_left``, ``V_right``: what the
    motors were to get; ``heading``: its set point, positive to the left. ``late``: how
    many ticks came later than the clock may, so far. A ValueError if a column has
    another length, or time doesn't grow.
    """

    t: np.ndarray
    gyro: np.ndarray
    wheels: np.ndarray
    tilt: np.ndarray
    target: np.ndarray
    rate: np.ndarray
    V: np.ndarray
    theta: np.ndarray
    battery: np.ndarray
    fault: np.ndarray
    left: np.ndarray | None = None
    right: np.ndarray | None = None
    V_left: np.ndarray | None = None
    V_right: np.ndarray | None = None
    heading: np.ndarray | None = None
    late: np.ndarray | None = None

    def __post_init__(self):
        """Check the columns and the clock, and keep them read-only."""
        lost = [name for name in STEER_COLUMNS if getattr(self, name) is None]
        if 0 < len(lost) < len(STEER_COLUMNS):
            raise ValueError(f"a log of steering lacks {', '.join(lost)}")
        for x in fields(self):
            if getattr(self, x.name) is None:
                continue
            value = np.array(getattr(self, x.name), float)
            if value.ndim != 1 or len(value) != len(self.t):
                raise ValueError(f"{x.name} must have {len(self.t)} entries, as t has")
            value.flags.writeable = False
            object.__setattr__(self, x.name, value)
        if len(self.t) < 3 or not (np.diff(self.t) > 0).all():
            raise ValueError("t must increase, in at least 3 rows")
        if self.fault[0] != START:
            raise ValueError(
                f"the first row must be a start (fault = {START}), which has the "
                "gyro's offset: log from the program's start"
            )

    @classmethod
    def read(cls, path):
        """The longest run in a CSV file that a program wrote, at ``path``.

        ``path``: a file with the columns t, gyro, wheels, tilt, target, rate, V, theta,
        battery and fault in any order, and perhaps `LATE` and `STEER_COLUMNS`; a
        program that was started several times has several runs. Returns the longest run
        from a start to the next. Raises ValueError: that names the column or the row.
        """
        rows = read_rows(path)
        names = [name.strip() for name in rows[0]] if rows else []
        lost = [name for name in FORMATS if name not in names]
        if lost:
            raise ValueError(f"{path} lacks the column(s) {', '.join(lost)}: {HEADER}")
        if len(set(names)) < len(names):
            raise ValueError(f"{path} has a column twice: {','.join(names)!r:.80}")
        if len(rows[-1]) != len(names):
            del rows[-1]  # power went off while it was written
        table = numbers_of(path, rows, names)
        columns = {
            name: table[:, names.index(name)]
            for name in (*FORMATS, LATE, *STEER_COLUMNS)
            if name in names
        }
        starts = np.flatnonzero(columns["fault"] == START)
        if not len(starts):
            raise ValueError(f"{path} has no start (fault = {START}): {HEADER}")
        ends = np.append(starts[1:], len(table))
        k = int(np.argmax(ends - starts))
        run = slice(starts[k], ends[k])
        with named(path):
            return cls(**{name: column[run] for name, column in columns.items()})

    def write(self, path):
        """Write the CSV file at ``path`` that `read` reads."""
        more = {LATE: "{:.0f}"} | dict.fromkeys(STEER_COLUMNS, "{:.9g}")
        has = {x: form for x, form in more.items() if getattr(self, x) is not None}
        formats = FORMATS | has
        form = ",".join(formats.values())
        rows = zip(*(getattr(self, name).tolist() for name in formats))
        lines = [",".join(formats), *(form.format(*row) for row in rows)]
        write_file(path, "\n".join(lines) + "\n")

    @property
    def steers(self):
        """True if the program held a heading."""
        return self.heading is not None

    @property
    def turned(self):
        """(N,) array: the right wheel's angle less the left's, since the start."""
        turned = self.right - self.left
        return turned - turned[0]

    @property
    def running(self):
        """(N,) bool: the ticks at which the program balanced."""
        return self.fault == 0

    def replayed(self, firmware):
        """The volts that a ``firmware`` answers to these readings.

        ``firmware``: the one that is said to have run. Returns (N,): in V; the first
        entry, at the start, is zero.
        """
        controller = firmware.controller()
        controller.start(self.theta[0], self.wheels[0], self.gyro[0])
        volts = [0.0]
        for row in zip(*(getattr(self, name)[1:] for name in READ)):
            volts.append(float(controller.step(*row)[0]))
        return np.array(volts)

    def replayed_motors(self, steering):
        """The volts of both motors that a ``steering`` answers to these readings.

        ``steering``: the one that is said to have run. Returns (N, 2): in V, left and
        right; at the start zero.
        """
        steered, per = steering.controller(), steering.per_radian
        steered.start(self.left[0], self.right[0])
        turn = np.diff(self.heading, prepend=0.0) / steering.firmware.law.T
        volts = [(0.0, 0.0)]
        for k in range(1, len(self.t)):
            seen = self.V[k], self.fault[k], self.left[k], self.right[k]
            left, right = steered.step(*seen, per * self.heading[k], per * turn[k])
            volts.append((float(left[0]), float(right[0])))
        return np.array(volts)


READ = "gyro", "wheels", "tilt", "target", "rate"  # what a controller's step takes
