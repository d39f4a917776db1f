"""The description of a robot, which no log contains: a TOML file."""

from dataclasses import MISSING, dataclass, field, fields, replace
from difflib import get_close_matches
from math import ceil, isfinite, pi
from sys import float_info

from ..runtime.reading import read_toml
from ..runtime.saying import visible
from .rig import DATA

__all__ = ["BOARDS", "LAWS", "Robot"]

BOARDS = ("beaglebone", "other")
EDGES = (1, 2, 4)  # of an encoder's period, which a counter may count
LAWS = ("gain", "observer")
#: How long a fault is borne, in s: what `timed` says where a robot doesn't.
WAITS = "missing", "frozen", "stall", "deaf", "late"
TILT_MEMORY = 2.0  # s, after which the accelerometers are believed: T / blend
GYRO_TEXT = "full scale of the gyro; 1000 deg/s are 17.45"
#: Keys that only the programs for a known board take.
BOARD_KEYS = (
    *("mount", "nominal", "battery", "motor_channels", "motor_polarities"),
    *("encoder_channels", "encoder_polarities"),
)

#: Keys that a robot with a track takes, and what they are without being given.
STEERING = {"steering": 0.25, "unequal": 0.1, "turning": None}


def key(text, unit="", default=..., low=0.0, high=float("inf")):
    """A key of the description; ``low`` itself isn't allowed."""
    about = {"text": text, "unit": unit, "low": low, "high": high}
    return field(metadata=about, **({} if default is ... else {"default": default}))


@dataclass(frozen=True, kw_only=True)
class Robot:
    """A robot as its owner describes it.

    Everything that a program, a proof or a fit takes for granted about
    a robot stands here. `Robot.read` takes a TOML file with these
    keys; the package ships two, ``Robot.shipped("thesis")`` and
    ``Robot.shipped("gearmotors")``.

    Parameters
    ----------
    name : str
        What the robot is called, in a few words.
    M_b, l, r, M_w, g : float
        As for `Mip.from_ratios`, in SI units.
    counts : float
        An encoder's counts per turn of a wheel against the body.
    edges : {4, 2, 1}
        How many edges of an encoder's period ``counts`` has: all four of both
        channels, both of one channel, or one. A program that sees fewer edges lets
        each stand for several counts; the BeagleBone Blue sees four.
    gyro_range : float
        The gyro's full scale, in rad/s.
    limit : float
        The largest voltage that a program asks for, in V.
    free_rpm : float, optional
        By the motors' sheet, of a wheel that turns freely under ``limit``, in turns a
        minute: logs that say another number are refused.
    ten_swings : float, optional
        By a stopwatch, in s, of the body upside down with held wheels and free motors;
        likewise.
    rotors, friction : bool
        As for `identify`.
    T, delay, jitter : float
        Time between samples, the longest time from a sample to its voltage,
        and the longest by which a tick may come late; in s.
    blend : float, optional
        As in `Firmware`; T / (2 s) without it.
    compensation : float
        As in `Firmware`: the friction that a fit with ``friction`` gives.
    backlash_deg : float
        The gears' play, by which a wheel can be turned while its motor rests, in
        degrees from one end to the other; R is chosen with it.
    tip : float
        Tilt beyond which the motors go off, in rad.
    missing, frozen, stall, deaf, late : float, optional
        As in `Firmware`, but in s; without them a `Deployment` takes them from the
        time in which the robot falls.
    law : {"observer", "gain"}, optional
        The gain of Theorem 2.4, or the `optimal_law`. Without it the observer,
        which is quiet at rest; `recommend` takes the gain where that isn't proven.
    board : {"other", "beaglebone"}
        For the BeagleBone Blue there are complete programs.
    mount : float
        Tilt of the board in the body, in rad.
    nominal : float
        Voltage of a battery that isn't measured, in V.
    battery : (float, float)
        Between these voltages a measured battery lies, in V.
    motor_channels, motor_polarities : (int, int)
        Channels of the left and the right motor; 1 or -1.
    encoder_channels, encoder_polarities : (int, int)
        Channels of the left and the right encoder; 1 or -1.
    track : float, optional
        The distance between the wheels' middles, in m: with it the program
        steers, too.
    steering : float
        The most that steering takes of the limit; 0.25 without it.
    unequal : float
        By this share one motor may be stronger, and the other weaker, than
        their mean; 0.1 without it.
    turning : (float, float), optional
        Bounds of the body's inertia about the vertical, in kg m^2; without
        them it is that of any body within the circle through both wheels.

    Raises
    ------
    ValueError
        That names the key and what it must be.

    Examples
    --------
    >>> robot = Robot.shipped("thesis")
    >>> robot.counts, robot.limit
    (2122.2, 7.4)
    >>> Robot.shipped("gearmotors").blend
    0.0025
    """

    name: str = key("in a few words")
    M_b: float = key("mass of the body without wheels", "kg", high=100.0)
    l: float = key("from the axle to the body's centre of mass", "m", high=2.0)
    r: float = key("radius of the wheels", "m", high=1.0)
    M_w: float = key("mass of one wheel", "kg", high=20.0)
    g: float = key("gravity", "m/s^2", 9.81)
    counts: float = key("of an encoder, per turn of a wheel", "a turn")
    edges: int = key("of an encoder's period, in counts", "", 4)
    gyro_range: float = key(GYRO_TEXT, "rad/s", high=100.0)
    limit: float = key("largest voltage that is asked for", "V")
    free_rpm: float = key("of a free wheel under limit, by the sheet", "rpm", None)
    ten_swings: float = key("by a stopwatch, upside down", "s", None)
    rotors: bool = key("the rotors couple theta and phi")
    friction: bool = key("fit Coulomb friction")
    T: float = key("time between samples", "s", high=0.2)
    delay: float = key("from the sample to the voltage", "s", low=None)
    jitter: float = key("by which a tick may come late", "s", 0.0, None)
    blend: float = key("share of the accelerometers' tilt", "", None, None, 1.0)
    compensation: float = key("of Coulomb friction", "V", 0.0, None)
    backlash_deg: float = key("play of the gears", "degrees", 0.0, None, 20.0)
    tip: float = key("tilt at which the motors go off", "rad", 0.85, high=pi / 2)
    missing: float = key("bad readings in a row, bridged", "s", None, None, 1.0)
    frozen: float = key("equal readings of a gyro that lives", "s", None, None, 2.0)
    stall: float = key("longest time at the limit", "s", None, None, 10.0)
    deaf: float = key("equal encoders under voltage", "s", None, None, 5.0)
    late: float = key("ticks late, more than in time", "s", None, None, 5.0)
    law: str = key("gain or observer", "", None)
    board: str = key("beaglebone or other", "", "other")
    mount: float = key("tilt of the board in the body", "rad", None, low=-pi)
    nominal: float = key("battery that isn't measured", "V", None)
    battery: tuple = key("a measured battery lies between", "V", None)
    motor_channels: tuple = key("left and right", "", None)
    motor_polarities: tuple = key("left and right, 1 or -1", "", None)
    encoder_channels: tuple = key("left and right", "", None)
    encoder_polarities: tuple = key("left and right, 1 or -1", "", None)
    track: float = key("between the wheels' middles", "m", None, high=5.0)
    steering: float = key("share of the limit that steers", "", None, high=0.5)
    unequal: float = key("by which the motors may differ", "", None, None, 0.5)
    turning: tuple = key("inertia about the vertical, bounds", "kg m^2", None)

    def __post_init__(self):
        """Check the words, the numbers, the board and the steering."""
        if not isinstance(self.name, str) or not self.name.strip():
            raise ValueError(f"name must be a few words in quotes, got {self.name!r}")
        for name, known in (("board", BOARDS), ("law", LAWS)):
            value = getattr(self, name)
            if value not in known and (name, value) != ("law", None):
                raise ValueError(f"{name} must be one of {known}, got {value!r}")
        if type(self.edges) is not int or self.edges not in EDGES:
            raise ValueError(
                f"edges (of an encoder's period, in counts) must be one of {EDGES}, "
                f"got {self.edges!r}"
            )
        self._check_board()
        self._check_steering()
        if self.blend is None:
            object.__setattr__(
                self, "blend", round(_number(self, "T") / TILT_MEMORY, 12)
            )
        for x in fields(self):
            value = getattr(self, x.name)
            if x.type is float and value is not None:
                object.__setattr__(self, x.name, _number(self, x.name))
            elif x.type is bool and not isinstance(value, bool):
                raise ValueError(f"{x.name} must be true or false, got {value!r}")
            elif x.type is tuple and value is not None:
                object.__setattr__(self, x.name, _pair(x.name, value))
        if self.board != "other" and not (
            self.battery[0] < self.nominal < self.battery[1]
        ):
            raise ValueError(
                f"nominal = {self.nominal:g} V must lie within battery = "
                f"{list(self.battery)} V"
            )

    def _check_board(self):
        """All keys of a known board, or none of them."""
        present = [k for k in BOARD_KEYS if getattr(self, k) is not None]
        if self.board == "other" and present:
            raise ValueError(
                f'{", ".join(present)}: no program for board = "other" '
                'takes this: leave it out, or set board = "beaglebone"'
            )
        if self.board != "other" and self.edges != 4:
            counts = 4 / self.edges * _number(self, "counts")
            raise ValueError(
                f"edges = {self.edges}: the counters of this board count all four "
                f"edges of a period: set counts = {counts:g} and leave edges out"
            )
        lost = [k for k in BOARD_KEYS if k not in present]
        if self.board != "other" and lost:
            raise ValueError(
                f'{", ".join(lost)} must be given for board = "{self.board}"'
            )

    def _check_steering(self):
        """Steering's keys with a track, and none without."""
        present = [k for k in STEERING if getattr(self, k) is not None]
        if self.track is None and present:
            raise ValueError(
                f"{', '.join(present)}: without track the program doesn't steer: "
                "give track, the distance between the wheels, or leave this out"
            )
        for name, value in STEERING.items() if self.track is not None else ():
            if getattr(self, name) is None and value is not None:
                object.__setattr__(self, name, value)

    @classmethod
    def of(cls, table, source="the description"):
        """A robot from a dict of keys, ``table``; unknown keys are refused.

        Messages name the ``source`` of the description.
        """
        keys = {x.name: x for x in fields(cls)}
        for name in (name for name in table if name not in keys):
            hint = f": the keys are {', '.join(keys)}"
            if near := get_close_matches(name, keys, 1):
                hint = f"; do you mean {near[0]}?"
            raise ValueError(f"{source}: unknown key {visible(name)}{hint}")
        lost = [
            f"{x.name} ({x.metadata['text']}, {x.metadata['unit']}".removesuffix(", ")
            for x in keys.values()
            if x.name not in table and x.default is MISSING
        ]
        if lost:
            raise ValueError(f"{source} lacks {'); '.join(lost)})")
        try:
            return cls(**table)
        except ValueError as error:
            raise ValueError(f"{source}: {error}") from None

    @classmethod
    def read(cls, path):
        """A robot from the TOML file at ``path``."""
        return cls.of(read_toml(path), str(path))

    @classmethod
    def shipped(cls, name):
        """A description that the package ships, by name: thesis or gearmotors."""
        if name not in ("thesis", "gearmotors"):
            raise ValueError(f"name must be 'thesis' or 'gearmotors', got {name!r}")
        return cls.read(DATA / f"{name}.toml")

    def but(self, **changes):
        """The same robot with some ``changes`` of keys, and checked again."""
        if changes.get("T") is not None and "blend" not in changes:
            share = self.blend / self.T  # the same memory in seconds
            changes["blend"] = round(share * changes["T"], 12)
        return replace(self, **changes)

    @property
    def ticks(self):
        """The waits that are given, in ticks: a dict."""
        times = {x: getattr(self, x) for x in WAITS}
        return {x: ceil(s / self.T - 1e-9) for x, s in times.items() if s is not None}

    @property
    def identification(self):
        """The arguments that `identify` takes."""
        return {
            x: getattr(self, x)
            for x in ("M_b", "l", "r", "M_w", "g", "counts", "rotors", "friction")
        }

    @property
    def words(self):
        """Every key, its value and its unit, in one line."""
        said = []
        for x in fields(self):
            value = getattr(self, x.name)
            if value is None:
                continue
            if isinstance(value, bool):
                value = str(value).lower()
            elif isinstance(value, float):
                value = f"{value:.12g}"
            elif isinstance(value, tuple):
                value = " ".join(f"{v:.12g}" for v in value)
            said.append(f"{x.name} = {value} {x.metadata['unit']}".strip())
        return ", ".join(said)


def _number(robot, name):
    """A key's value as a float within its range, or a ValueError."""
    value = getattr(robot, name)
    about = {x.name: x for x in fields(robot)}[name].metadata
    low, high = about["low"], about["high"]
    bounds = "0 or more" if low is None else f"above {low:.4g}"
    if isfinite(high):
        bounds += f" and at most {high:.4g}"
    good = (
        isinstance(value, (int, float))
        and not isinstance(value, bool)
        and abs(value) <= min(high, float_info.max)
        and (value >= 0 if low is None else value > low)
    )
    if not good:
        unit = f" {about['unit']}".rstrip()
        raise ValueError(
            f"{name} ({about['text']}) must be a number {bounds}{unit}, "
            f"got {value!r:.80}"
        )
    return float(value)


#: By the end of a key's name: what its two numbers must be, an example, and their type.
PAIRS = {
    "polarities": ("1 or -1 for left and right", [1, -1], int),
    "channels": ("two different channels from 1 to 4", [3, 2], int),
    "battery": ("two voltages, low and high", [5.0, 9.0], (int, float)),
    "turning": ("two inertias, least and largest", [0.0004, 0.0009], (int, float)),
}


def _pair(name, value):
    """Two numbers: channels, polarities or an interval of volts or inertias."""
    key, most = name.split("_")[-1], float_info.max
    what, example, kind = PAIRS[key]
    good = isinstance(value, (list, tuple)) and len(value) == 2
    if good and all(isinstance(v, kind) and not isinstance(v, bool) for v in value):
        one, other = value
        good = {
            "polarities": {*value} <= {1, -1},
            "channels": {*value} <= {1, 2, 3, 4} and one != other,
            "battery": 0 < one <= most and 0 < other <= most,
            "turning": 0 <= one <= other <= most,
        }[key]
    else:
        good = False
    if not good:
        raise ValueError(f"{name} must be {what}, such as {example}; got {value!r:.80}")
    return tuple(value) if kind is int else tuple(map(float, value))
