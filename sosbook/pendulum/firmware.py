"""What runs on the robot at every tick: estimate, law, limits, faults.

The C program that `sosbook.pendulum.c_code` writes does the same operations
in the same order.
"""

from dataclasses import dataclass

import numpy as np

from ..plants.checks import finite, positive
from .law import SampledLaw
from .model import V_MAX

__all__ = ["COUNTERS", "FAULTS", "SOFTNESS", "Controller", "Firmware"]

#: Why the motors are off, by number; 0 is no fault.
FAULTS = ("running", "sensor", "fall", "stall", "command")
#: Counters of ticks in a row, as the state has them: the gyro's bad readings,
#: the encoders', equal ones of the gyro, equal ones of the encoders under
#: voltage, and ticks at the limit.
COUNTERS = ("bad", "lost", "same", "still", "full")
PUSHING_SHARE = 0.25  # of the limit of the voltage: more than friction takes
SOFTNESS = 2.0  # a command of so many times the compensation gets all of it
TRUSTED_VOLTS = 1e6  # V; a larger command means that a number is broken


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
    note : tuple of str
        Where the law comes from; the C program's header carries it.

    Raises
    ------
    ValueError
        If a number is out of its range.

    Notes
    -----
    theta is the gyro's integral by the trapezoidal rule, corrected by
    the accelerometers; phi, the absolute angle of the wheels, is the
    encoders' angle plus theta; its rate is phi's difference over T.

    Examples
    --------
    >>> law = SampledLaw.of_gain([[20, 0.8, 2, 0.9]], 0.01)
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
    note: tuple = ()

    def __post_init__(self):
        if not isinstance(self.law, SampledLaw):
            raise ValueError("law must be a SampledLaw")
        for name in ("limit", "tip", "fastest", "gyro_range"):
            object.__setattr__(self, name, positive(name, getattr(self, name)))
        share("blend", self.blend)
        if not 0 <= finite("compensation", self.compensation) < self.limit:
            raise ValueError(
                "compensation must be 0 or more and below the limit, in V, "
                f"got {self.compensation!r}"
            )
        for name in ("missing", "frozen", "stall", "deaf"):
            value = getattr(self, name)
            if not isinstance(value, int) or isinstance(value, bool) or value < 0:
                raise ValueError(
                    f"{name} must be a number of ticks, 0 or more, got {value!r}"
                )

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
        self.runs = runs
        self.fault = None

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
        self.bias, self.theta, self.wheels = map(self._each, (bias, tilt, wheels))
        self.last = self.bias
        self.gyro, self.increment = self._each(0), self._each(0)
        self.volts = self._each(0)
        self.zero = self.phi = self.wheels + self.theta
        self.x = [self.kind.type(s) * self.theta for s in self.firmware.law.start]
        for name in COUNTERS:
            setattr(self, name, np.zeros(self.runs, int))
        self.fault = np.zeros(self.runs, int)

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
        if self.fault is None:
            raise ValueError("the controller isn't started: call start(tilt)")
        with np.errstate(invalid="ignore", over="ignore"):
            return self._step(*map(self._each, (gyro, wheels, tilt, target, rate)))

    def _step(self, gyro, wheels, tilt, target, rate):
        f, law = self.firmware, self.firmware.law
        _T, half, hertz = map(self.kind.type, (law.T, law.T / 2, 1 / law.T))
        one = self.kind.type(f.fastest * law.T)  # rad in a tick
        limit, tip = self.kind.type(f.limit), self.kind.type(f.tip)
        span, huge = self.kind.type(f.gyro_range), self.kind.type(TRUSTED_VOLTS)
        push = self.kind.type(f.limit * PUSHING_SHARE)
        running = self.fault == 0

        last, equal = gyro, (gyro <= self.last) & (gyro >= self.last)
        same = np.where(equal & (f.frozen > 0), self.same + 1, 0)
        gyro = gyro - self.bias
        turned = wheels - self.wheels
        reach = one * (self.lost + 1).astype(self.kind)
        seen = within(gyro, span), within(turned, reach)
        bad = np.where(seen[0], 0, self.bad + 1)
        lost = np.where(seen[1], 0, self.lost + 1)
        quiet = (wheels <= self.wheels) & (wheels >= self.wheels)
        quiet &= ~within(self.volts, push) & (f.deaf > 0)
        still = np.where(quiet, self.still + 1, 0)
        gyro = np.where(seen[0], gyro, self.gyro)
        wheels = np.where(seen[1], wheels, self.wheels + self.increment)

        theta = self.theta + half * (gyro + self.gyro)
        blended = theta + self.kind.type(f.blend) * (tilt - theta)
        theta = np.where(within(tilt, tip), blended, theta)
        phi = wheels + theta
        y = [theta, phi - self.zero - target, gyro, (phi - self.phi) * hertz - rate]

        u = self._each(law.output(self.x, y))
        if f.compensation:
            c, soft, steep = map(
                self.kind.type,
                (f.compensation, SOFTNESS * f.compensation, 1 / SOFTNESS),
            )
            u = u + np.where(u > soft, c, np.where(u < -soft, -c, steep * u))
        V = np.where(u > limit, limit, np.where(u < -limit, -limit, u))
        full = np.where(V == u, 0, self.full + 1)
        x = law.next(self.x, y, V - u)

        fault = np.select(
            [
                (bad > f.missing)
                | (lost > f.missing)
                | (same > f.frozen)
                | (still > f.deaf),
                ~within(theta, tip),
                ~within(u, huge),
                full > f.stall,
            ],
            [FAULTS.index(w) for w in ("sensor", "fall", "command", "stall")],
            0,
        )
        good = running & (fault == 0)

        def keep(new, old):
            return np.where(good, new, old)

        self.increment = keep(wheels - self.wheels, self.increment)
        self.theta, self.gyro = keep(theta, self.theta), keep(gyro, self.gyro)
        self.wheels, self.phi = keep(wheels, self.wheels), keep(phi, self.phi)
        self.last, self.same = keep(last, self.last), keep(same, self.same)
        self.bad, self.full = keep(bad, self.bad), keep(full, self.full)
        self.lost, self.still = keep(lost, self.lost), keep(still, self.still)
        self.volts = keep(V, self.volts)
        self.x = [keep(new, old) for new, old in zip(x, self.x)]
        self.fault = np.where(running, fault, self.fault)
        return np.where(good, V, self.kind.type(0))

    def _each(self, value):
        return np.broadcast_to(np.asarray(value, self.kind), self.runs)


def share(name, value):
    """A number from 0 to 1, or a ValueError that names it."""
    if not 0 <= finite(name, value) <= 1:
        raise ValueError(f"{name} must lie in [0, 1], got {value!r}")
    return value


def within(value, bound):
    """-bound <= value <= bound; false for what isn't a number."""
    return (value >= -bound) & (value <= bound)
