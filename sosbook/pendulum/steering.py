"""The law that holds a robot's heading, at every tick.

The wheels' difference delta = phi_R - phi_L says where the robot heads:
psi = r delta / track, positive to the left. Half the voltages' difference
W = V_R - V_L goes on top on the right and off on the left.
"""

from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np

from ..controllers.estimates import heading
from ..controllers.lanes import Lanes, within
from ..plants.checks import matrix, positive
from .firmware import Firmware
from .law import TRACKING_TIME

__all__ = ["Steered", "Steering"]

MOST_COUNTED = 32766  # ticks: what C promises of an int, less one


@dataclass(frozen=True, eq=False)
class Steering:
    """The law that holds a heading, beside a firmware that balances.

    W = K [delta - target, delta' - rate, sum] with the sum T (delta - target);
    W is cut to what balancing leaves of the limit, and to a share of it.

    ``firmware``: the one that balances: its clock, its limit and its wheels' fastest
    rate; ``K``, (1, 3): the gain, in V per rad, V s per rad and V per rad s; ``share``:
    the most that steering takes of the limit, above 0 and below 1; ``track``: the
    distance between the wheels, in m; ``r``: the wheels' radius, in m. Raises
    ValueError if a number is out of its range.
    """

    firmware: Firmware
    K: np.ndarray
    share: float
    track: float
    r: float

    def __post_init__(self):
        if not isinstance(self.firmware, Firmware):
            raise ValueError(
                f"firmware must be a Firmware, got {type(self.firmware).__name__}"
            )
        object.__setattr__(self, "K", matrix("K", self.K, (1, 3)))
        if self.K[0, 2] == 0:
            raise ValueError("K's last entry, of the sum, is zero: nothing unwinds it")
        for name in ("share", "track", "r"):
            object.__setattr__(self, name, positive(name, getattr(self, name)))
        if self.share >= 1:
            raise ValueError(f"share must be below 1, got {self.share!r}")

    @property
    def per_radian(self):
        """Radians of the wheels' difference per radian of heading."""
        return self.track / self.r

    @property
    def volts(self):
        """The most that one motor gets for steering, in V."""
        return self.share * self.firmware.limit

    @property
    def numbers(self):
        """The program's numbers of it beside its firmware's, by name.

        STEER_REACH: the most by which the difference changes in a tick, in rad; UNWIND:
        how what the limit withheld acts on the sum, in rad s per V.
        """
        T = self.firmware.law.T
        return {
            "SHARE": self.volts,
            "STEER_REACH": 2 * self.firmware.fastest * T,
            "UNWIND": T / (TRACKING_TIME * self.K[0, 2]),
            "PER_RADIAN": self.per_radian,
            "K": self.K[0],
        }

    @property
    def system(self):
        """The `SampledSystem` from the true [delta, delta'] to W."""
        system = heading(self.K[0], self.firmware.law.T)
        return replace(system, inputs=("delta", "delta'"), outputs=("u",))

    def controller(self, runs=1, kind=float):
        """A `Steered` for ``runs`` robots; ``kind`` is float or np.float32."""
        return Steered(self, runs, kind)


class Steered:
    """A `Steering` at work on robots side by side, as the C program does it.

    ``steering``: the law and its limits; ``runs``: how many robots stand side by side;
    ``kind``: the precision of all arithmetic.
    """

    def __init__(self, steering, runs=1, kind=float):
        self.steering, self.runs, self.kind = steering, runs, np.dtype(kind)
        self._lanes = Lanes(runs, kind)
        numbers = steering.firmware.numbers | steering.numbers
        self._n = self._lanes.numbers(numbers)

    def start(self, left=0.0, right=0.0):
        """Forget everything; the wheels rest at the angles left and right, in rad.

        Where one isn't a number the first reading after it counts as the start's.
        """
        each = self._lanes.array
        self.turned = self.zero = each(right) - each(left)
        self.sum = each(0)
        self.lost = np.zeros(self.runs, int)

    def step(self, volts, fault, left, right, target=0.0, rate=0.0):
        """One tick, after the firmware's.

        ``volts``, (runs,): what the firmware answered, in V; ``fault``, (runs,) of int:
        the firmware's fault; with any the motors get nothing; ``left``, ``right``: the
        wheels' angles against the body, in rad; ``target``, ``rate``: set point of
        delta since the start and of its rate, in rad and rad/s. Returns (left, right),
        tuple of (runs,) array: volts for each motor.
        """
        lanes = self._lanes
        read = map(lanes.read, (volts, left, right, target, rate))
        fault = lanes.taken(np.broadcast_to(np.asarray(fault), self.runs))
        now = SimpleNamespace(
            **{x: lanes.taken(getattr(self, x)) for x in ("sum", "turned", "lost")},
            zero=lanes.taken(self.zero),
        )
        with np.errstate(invalid="ignore", over="ignore"):
            found = self._step(now, fault == 0, *read)
        shown = map(lanes.shown, found)
        left, right, self.sum, self.turned, self.lost, self.zero = shown
        return left, right

    def _step(self, now, running, V, left, right, target, rate):
        """Both motors' volts, the sum, the difference and the ticks without one."""
        n, lanes, where = self._n, self._lanes, self._lanes.where
        turned, since = right - left, lanes.counted(now.lost + 1)
        started = within(now.turned, n.TRUSTED)  # with a reading
        zero = where(started, now.zero, turned)
        before = where(started, now.turned, turned)
        seen = lanes.believable(turned - before, n.STEER_REACH, now.lost)
        turning = (turned - before) * n.HERTZ / since
        y = [turned - zero - target, turning - rate, now.sum]
        u = lanes.total((n.K, y))
        rest = n.LIMIT - abs(V)
        W = lanes.cut(u, 2 * where(rest < n.SHARE, rest, n.SHARE))
        good = running & seen & within(u, n.TRUSTED)
        later = now.sum + n.TICK * y[0] + n.UNWIND * (W - u)
        lost = where(now.lost < MOST_COUNTED, now.lost + 1, MOST_COUNTED)
        half = where(good, W / 2, lanes.zero)
        sides = lanes.cut(V - half, n.LIMIT), lanes.cut(V + half, n.LIMIT)
        return (
            *(where(running, side, lanes.zero) for side in sides),
            where(good, later, now.sum),
            where(running, where(good, turned, before), now.turned),
            where(good, 0, where(running, lost, now.lost)),
            where(running, zero, now.zero),
        )
