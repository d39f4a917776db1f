"""The robot's program at every tick: estimate, law, limits, faults.

The C program that `sosbook.pendulum.export` writes does the same operations
in the same order.
"""

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np

from ..controllers.lanes import Lanes, within
from ..plants.checks import finite, positive
from .law import PD_SIGNALS, SampledLaw
from .model import V_MAX

__all__ = ["COUNTERS", "FAULTS", "NUMBERS", "SOFTNESS", "Controller", "Firmware"]

#: Why the motors are off, by number; 0 is no fault.
FAULTS = ("running", "sensor", "fall", "stall", "command", "late")
#: Counters of ticks in a row, as the state has them: the gyro's bad readings,
#: the encoders', equal ones of the gyro, equal ones of the encoders under
#: voltage, and ticks at the limit.
COUNTERS = ("bad", "lost", "same", "still", "full")
#: What else a controller knows, as the state has it in C, besides x of its law.
NUMBERS = (
    *("bias", "last", "gyro", "theta", "wheels", "increment", "zero", "phi"),
    "volts",
)
STATE = frozenset((*NUMBERS, *COUNTERS, "fault", "x"))
SENSOR, FALL, STALL, COMMAND = range(1, 5)  # who calls the law knows the last one
PUSHING_SHARE = 0.25  # of the limit of the voltage: more than friction takes
SOFTNESS = 2.0  # a command of so many times the compensation gets all of it
TRUSTED_VOLTS = 1e6  # V; a larger command means that a number is broken


#: What a `Robot` says of its firmware.
DESCRIBED = "limit", "tip", "blend", "gyro_range", "compensation"


@dataclass(frozen=True, eq=False)
class Firmware:
    """A sampled law with all that a real robot needs around it.

    Parameters
    ----------
    law : SampledLaw
        The control law, which sees samples and gives a voltage.
    limit : float
        The largest voltage, in V.
    tip : float
        Beyond this tilt the motors go off for good, in rad.
    blend : float
        Share of the accelerometers' tilt in every estimate, 0 to 1:
        T / (time constant). Zero integrates the gyro alone.
    missing : int
        So many ticks in a row without a good reading of the gyro, or of
        the encoders, are bridged; each sensor has its own count.
    frozen : int
        For so many ticks in a row the gyro may repeat itself to the last bit,
        which the noise of a working one prevents. With zero it isn't checked.
    stall : int
        After so many ticks in a row at the voltage's limit, of either
        sign, the motors go off.
    fastest : float
        The wheels never turn faster against the body, in rad/s: a
        reading beyond it is a bad one.
    gyro_range : float
        The gyro's full scale, in rad/s: a reading at it or beyond is a bad
        one.
    deaf : int
        For so many ticks in a row the encoders may read the same while the
        motors get a quarter of the limit. With zero it isn't checked.
    compensation : float
        Of the gears' Coulomb friction, in V, added in the command's sense: c
        from 2 c on, and half of a smaller command. The gain from the law to
        the voltage then lies between 1 and 1.5. Zero adds nothing.
    late : int
        So many more ticks may come late, or not at all, than come in time; then the
        programs, which know the time, switch the motors off. With zero they don't.

    Notes
    -----
    theta is the gyro's integral by the trapezoidal rule, corrected by
    the accelerometers; phi, the absolute angle of the wheels, is the
    encoders' angle plus theta; its rate is phi's difference over T.

    Examples
    --------
    >>> from sosbook.pendulum import PD_SIGNALS, Gain
    >>> gain = Gain([[20, 0.8, 2, 0.9]], PD_SIGNALS)
    >>> law = SampledLaw.of_gain(gain, 0.01)
    >>> controller = Firmware(law).controller()
    >>> controller.start(tilt=0.1)
    >>> controller.step(gyro=0.0, wheels=0.0).round(3)
    array([2.])
    >>> controller.step(gyro=np.nan, wheels=0.0).round(3)
    array([2.])
    >>> [FAULTS[k] for k in controller.fault]
    ['running']
    """

    law: SampledLaw
    limit: float = V_MAX
    tip: float = 0.85
    blend: float = 0.0
    missing: int = 5
    frozen: int = 0
    stall: int = 50
    fastest: float = 100.0
    gyro_range: float = 100.0
    deaf: int = 0
    compensation: float = 0.0
    late: int = 0

    def __post_init__(self):
        """Check the law and the limits."""
        if not isinstance(self.law, SampledLaw):
            raise ValueError(
                "law must be a SampledLaw, such as SampledLaw.of_gain(gain, T), got "
                f"{type(self.law).__name__}"
            )
        for name in ("limit", "tip", "fastest", "gyro_range"):
            object.__setattr__(self, name, positive(name, getattr(self, name)))
        share("blend", self.blend)
        if not 0 <= finite("compensation", self.compensation) < self.limit:
            raise ValueError(
                "compensation must be 0 or more and below the limit, in V, "
                f"got {self.compensation!r}"
            )
        for name in ("missing", "frozen", "stall", "deaf", "late"):
            value = getattr(self, name)
            if not isinstance(value, int) or isinstance(value, bool) or value < 0:
                raise ValueError(
                    f"{name} must be a number of ticks, 0 or more, got {value!r}"
                )

    @property
    def numbers(self):
        """Arrays and numbers by their names in its programs; counts of ticks are ints.

        They are all that a program is told of the firmware.
        """
        law, T, rub = self.law, self.law.T, float(self.compensation)
        measured, none = len(PD_SIGNALS), np.zeros((law.order, 0))
        start = np.outer(law.start, np.eye(measured)[0])
        return {
            "TICK": T,
            "HALF_TICK": T / 2,
            "HERTZ": 1 / T,
            "LIMIT": self.limit,
            "TIP": self.tip,
            "BLEND": float(self.blend),
            "RANGE": self.gyro_range,
            "PUSH": self.limit * PUSHING_SHARE,
            "REACH": self.fastest * T,  # rad in a tick
            "TRUSTED": TRUSTED_VOLTS,
            "RUB": rub,
            "SOFT": SOFTNESS * rub,
            "STEEP": 1 / SOFTNESS,
            "MOST_LOST": self.missing,
            "FROZEN": self.frozen,
            "DEAF": self.deaf,
            "MOST_FULL": self.stall,
            **{x: getattr(law, x) + 0.0 for x in "ABCDW"},  # no -0
            "BR": none,
            "DR": np.zeros((1, 0)),
            "START": start + 0.0,
        }

    @classmethod
    def of(cls, law, robot, **changes):
        """That of a ``law`` and a described ``robot``, with some ``changes``."""
        described = {x: getattr(robot, x) for x in DESCRIBED}
        return cls(law, **(described | robot.ticks | changes))

    def controller(self, runs=1, kind=float):
        """A `Controller` for ``runs`` robots; ``kind`` is float or np.float32."""
        return Controller(self, runs, kind)


class Controller:
    """A `Firmware` at work on robots side by side.

    Every value is an array with an entry for each robot. Call `start`
    with the robot at rest, then `step` at every tick.

    Parameters
    ----------
    firmware : Firmware
        The law, its limits and its faults.
    runs : int
        How many robots stand side by side.
    kind : float or np.float32
        The precision of all arithmetic.
    """

    def __init__(self, firmware, runs=1, kind=float):
        self.firmware, self.kind = firmware, np.dtype(kind)
        self.runs, self._now = runs, None
        self._lanes = Lanes(runs, kind)
        self._n = self._lanes.numbers(firmware.numbers)

    def start(self, tilt, wheels=0.0, bias=0.0):
        """Forget everything; the robot rests.

        Parameters
        ----------
        tilt : float or (runs,) array
            theta, from the accelerometers, in rad.
        wheels : float or (runs,) array
            The encoders' mean angle, wheels against body, in rad.
        bias : float or (runs,) array
            What the gyro says at rest, in rad/s.
        """
        lanes = self._lanes
        none = lanes.zero
        bias, theta, wheels = (
            lanes.taken(lanes.array(value).copy()) for value in (bias, tilt, wheels)
        )
        phi, no_ticks = wheels + theta, lanes.taken(np.zeros(self.runs, int))
        numbers = bias, bias, none, theta, wheels, none, phi, phi, none
        self._now = SimpleNamespace(
            **dict(zip(NUMBERS, numbers, strict=True)),
            **dict.fromkeys((*COUNTERS, "fault"), no_ticks),
            x=lanes.begun(self._n, [theta, none, none, none]),
        )

    def __getattr__(self, name):
        """The program's variable, an array with an entry for each robot; x is a list of
        them.
        """
        if name not in STATE:
            raise AttributeError(f"Controller has no {name}")
        if self._now is None:
            return None
        value, shown = getattr(self._now, name), self._lanes.shown
        return [shown(entry) for entry in value] if name == "x" else shown(value)

    def step(self, gyro, wheels, tilt=np.nan, target=0.0, rate=0.0):
        """One tick.

        Parameters
        ----------
        gyro : float or (runs,) array
            The gyro's reading, in rad/s. One that isn't a number, or is out of
            range, is a bad one.
        wheels : float or (runs,) array
            The encoders' mean angle, in rad; it may be bad likewise.
        tilt : float or (runs,) array
            The accelerometers' tilt, in rad; not a number where there is none,
            which is no fault.
        target, rate : float or (runs,) array
            Set point of phi since the start and of phi', in rad and
            rad/s.

        Returns
        -------
        (runs,) array
            Volts for the motors; zero after a fault.
        """
        if self._now is None:
            raise ValueError("the controller isn't started: call start(tilt)")
        lanes = self._lanes
        seen = map(lanes.read, (gyro, wheels, tilt, target, rate))
        with lanes.silent():
            V, self._now = self._step(self._now, *seen)
        return lanes.shown(V)

    def _step(self, now, gyro, wheels, tilt, target, rate):
        """The volts, and what is known later."""
        n, lanes, where = self._n, self._lanes, self._lanes.where
        running = now.fault == 0

        last, equal = gyro, (gyro <= now.last) & (gyro >= now.last)
        same = where(equal & (n.FROZEN > 0), now.same + 1, 0)
        gyro = gyro - now.bias
        turned = wheels - now.wheels
        near = lanes.believable(turned, n.REACH, now.lost)
        seen = within(gyro, n.RANGE), near
        bad = where(seen[0], 0, now.bad + 1)
        lost = where(seen[1], 0, now.lost + 1)
        quiet = (wheels <= now.wheels) & (wheels >= now.wheels) & (n.DEAF > 0)
        still = where(within(now.volts, n.PUSH), 0, where(quiet, now.still + 1, 0))
        gyro = where(seen[0], gyro, now.gyro)
        wheels = where(seen[1], wheels, now.wheels + now.increment)

        theta = now.theta + n.HALF_TICK * (gyro + now.gyro)
        blended = theta + n.BLEND * (tilt - theta)
        theta = where(within(tilt, n.TIP), blended, theta)
        phi = wheels + theta
        y = [theta, phi - now.zero - target, gyro, (phi - now.phi) * n.HERTZ - rate]

        u = lanes.answered(n, 0, now.x, y)
        if n.RUB:
            soft = where(u < -n.SOFT, -n.RUB, n.STEEP * u)
            u = u + where(u > n.SOFT, n.RUB, soft)
        V = lanes.cut(u, n.LIMIT)
        full = where((u > n.LIMIT) | (u < -n.LIMIT), now.full + 1, 0)
        x = lanes.remembered(n, now.x, y, (), [V - u])

        fault = where(full > n.MOST_FULL, STALL, 0)  # the last that is said counts
        fault = where(within(u, n.TRUSTED), fault, COMMAND)
        fault = where(within(theta, n.TIP), fault, FALL)
        silent = (bad > n.MOST_LOST) | (lost > n.MOST_LOST)
        silent = silent | (same > n.FROZEN) | (still > n.DEAF)
        fault = where(silent, SENSOR, fault)
        good = running & (fault == 0)

        keep = lanes.keeper(good)
        return keep(V, lanes.zero), SimpleNamespace(
            theta=keep(theta, now.theta),
            gyro=keep(gyro, now.gyro),
            wheels=keep(wheels, now.wheels),
            phi=keep(phi, now.phi),
            last=keep(last, now.last),
            increment=keep(wheels - now.wheels, now.increment),
            volts=keep(V, now.volts),
            fault=where(running, fault, now.fault),
            bad=keep(bad, now.bad),
            lost=keep(lost, now.lost),
            same=keep(same, now.same),
            still=keep(still, now.still),
            full=keep(full, now.full),
            bias=now.bias,
            zero=now.zero,
            x=[keep(new, old) for new, old in zip(x, now.x)],
        )


def share(name, value):
    """A number from 0 to 1, or a ValueError that names it."""
    if not 0 <= finite(name, value) <= 1:
        raise ValueError(f"{name} must lie in [0, 1], got {value!r}")
    return value
