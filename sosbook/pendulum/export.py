"""A `Firmware` as source code for robots: C99, librobotcontrol, pyctrl, Arduino.

The programs do what `Controller` does, operation by operation. Their text depends
on the firmware, the robot and the package's version alone.
"""

import re
from dataclasses import dataclass, replace

from ..controllers.gains import Gains
from ..controllers.numbers import FLOAT_TYPES, TAKEN, single
from ..controllers.program import MATRICES, SINGLE
from ..controllers.template import written_by
from ..controllers.written import ROBOT, STEERING, law_texts
from .boards import PYCTRL_COUNTS_PER_TURN, fill, pyctrl_signs, rc_robot, wired
from .drive import Drive
from .firmware import Firmware
from .law import PD_SIGNALS
from .recording import board_files
from .robot import Robot
from .steering import Steering

__all__ = ["Program"]

TAKEN_NAMES = TAKEN | {"rc", "robotcontrol"}
CLOCK_SHARE = 0.05  # of T, by which any clock's ticks may be late: its own steps
MOST_TICKS = 32766  # the least that C promises of an int, 32767, less one
TICKS = "missing", "frozen", "deaf", "stall"  # the fields of `Firmware` that count them
#: What a firmware's numbers are, or their units.
UNITS = {x: MATRICES[x] for x in ("A", "B", "BR", "W", "C", "D", "DR", "START")} | {
    "TICK": "s between samples",
    "HALF_TICK": "s",
    "HERTZ": "Hz",
    "LIMIT": "V, at most",
    "TIP": "rad, beyond which it falls",
    "BLEND": "of each tick's tilt",
    "RANGE": "rad/s, the gyro's full scale",
    "PUSH": "V, which turn wheels",
    "REACH": "rad a tick, at most",
    "TRUSTED": "V, or a number is broken",
    "RUB": "V, of friction that is compensated",
    "SOFT": "V, from which on all of it is",
    "STEEP": "V per V below",
    "MOST_LOST": "ticks in a row without a reading to believe",
    "FROZEN": "ticks in a row with one reading of the gyro; 0: any",
    "DEAF": "ticks in a row under voltage with the wheels at rest; 0: any",
    "MOST_FULL": "ticks in a row at the limit",
    "DELAY": "s, at most, from the readings to the volts: for a checker",
    "SLACK": "s, by which a tick may come late",
    "MOST_LATE": "more ticks late than in time; 0: any",
    "REST_TICKS": "of a second at rest before the start",
    "SPEED": "rad/s, of a set point that moves",
    "ACCELERATION": "rad/s^2 of it",
    "TURN_RATE": "rad/s, of a heading that moves",
    "TURN_ACCELERATION": "rad/s^2 of it",
    "SHARE": "V, for steering",
    "STEER_REACH": "rad a tick, right less left, at most",
    "UNWIND": "rad s per V, of what the limit withheld",
    "PER_RADIAN": "rad, right less left, a radian of heading",
    "K": "error of right less left, its rate, its sum to right less left, in V",
}


@dataclass(frozen=True)
class Program:
    """A firmware, and what its programs are told of the robot.

    Parameters
    ----------
    firmware : Firmware
        The law, its limits and its faults.
    name : str
        The name of the files, which also stands in front of every identifier of C.
    precision : {"double", "single"}
        The precision of all arithmetic in C.
    robot : Robot, optional
        Its counts, mount, battery, channels and polarities; the thesis's robot
        without it.
    drive : Drive, optional
        How fast it may be told to roll; without it, it stays in place.
    steering : Steering, optional
        What holds its heading; without it both motors get the same voltage.

    Raises
    ------
    ValueError
        If ``name`` can't begin a C identifier, the firmware's numbers don't fit, or
        the law doesn't use what it measures. A program raises it, too, if the robot
        has another board than the program's, if its IMU doesn't have the law's
        rate, or if it has channels that pyctrl hasn't.

    Notes
    -----
    Compile with -ffp-contract=off: fused operations round once where the law's
    arithmetic rounds twice. Constants are hexadecimal, so that no digit is lost;
    all of them stand in <name>_gains.h, and the law's sums in <name>_tick.h, as in the
    program of any `sosbook.controllers.Controller`.

    MISRA C:2012, as far as cppcheck's addon looks: of the required rules two are
    not met, 14.4 (``if (!seen)`` asks an int) and 15.6 (a single statement stands
    without braces). Of the advisory ones it doesn't keep 2.4 and 5.9 (the enum has
    no tag, and each file has a ``within`` of its own), 8.9 (constants stand at the
    file's top), 12.1 (no parentheses where precedence decides), 15.5 (it returns
    early after a fault) and 17.8 (a bad reading is replaced in its argument). The
    steering doesn't meet 10.4 and 10.8 either (a sum of ints becomes a float, and is
    divided by 2). There is no heap, no recursion, no pointer arithmetic and no
    library.

    Examples
    --------
    >>> from sosbook.controllers import read_gains
    >>> from sosbook.pendulum import PD_SIGNALS, Gain, SampledLaw
    >>> gain = Gain([[20, 0.8, 2, 0.9]], PD_SIGNALS)
    >>> program = Program(Firmware(SampledLaw.of_gain(gain, 0.01)))
    >>> print(program.law["balance.h"].splitlines()[0])
    /* balance.h: a control law for a mobile inverted pendulum
    >>> read_gains(program.gains)["D"]
    array([[20. ,  0.8,  2. ,  0.9]])
    >>> code = compile(program.pyctrl, "pyctrl_balance.py", "exec")
    """

    firmware: Firmware
    name: str = "balance"
    precision: str = "double"
    robot: Robot | None = None
    drive: Drive | None = None
    steering: Steering | None = None

    def __post_init__(self):
        """Check the firmware, the precision, the name and the steering."""
        firmware, name = self.firmware, self.name
        if not isinstance(firmware, Firmware):
            raise ValueError(
                f"firmware must be a Firmware, got {type(firmware).__name__}"
            )
        if self.precision not in FLOAT_TYPES:
            raise ValueError(
                f"precision must be 'double' or 'single', got {self.precision!r}"
            )
        if (
            not isinstance(name, str)
            or name in TAKEN_NAMES
            or name[:3] == "rc_"
            or not re.fullmatch(r"[a-z][a-z0-9_]{0,30}", name)
        ):
            raise ValueError(
                "name must begin a C identifier, in lower case, and be no "
                f"name that C or the robot's library has, got {name!r}"
            )
        for label in TICKS:
            if (ticks := getattr(firmware, label)) > MOST_TICKS:
                raise ValueError(
                    f"{label} must be at most {MOST_TICKS}, for C's int, got {ticks}"
                )
        law = firmware.law
        if not (law.D.any() or (law.C.any() and law.B.any())):
            raise ValueError(
                "law doesn't use what it measures: D is zero, and B or C; give a law "
                "whose output depends on y"
            )
        if not isinstance(self.steering, Steering | None):
            raise ValueError("steering must be a Steering, or left out")

    @property
    def gains(self):
        """The text of <name>_gains.h: all numbers, and what is known of them."""
        law = self.firmware.law
        written = Gains(self.name, self.precision, self._provenance)
        written.define("SINGLE", int(self.precision == "single"), SINGLE)
        written.define("STATES", law.order, "numbers that it remembers")
        written.define("MEASURED", len(PD_SIGNALS))
        written.define("SET_POINTS", 0, "they are subtracted from what is measured")
        written.define("OUTPUTS", 1)
        written.define("TICK_US", f"{round(1e6 * law.T)}UL", f"{law.T:.9g} s")
        written.define("COMPENSATES", int(self.firmware.compensation > 0))
        written.define("STEERS", int(self.steering is not None), "1: a heading is held")
        y = ", ".join(PD_SIGNALS)
        numbers = self.firmware.numbers
        if self.steering is not None:
            numbers |= self.steering.numbers
        numbers |= self._around
        for label, value in numbers.items():
            said = UNITS[label].format(y=y)
            if isinstance(value, int):
                written.define(label, value, said)
            elif isinstance(value, float):
                written.number(label, value, said)
            elif value.ndim == 1:
                written.vector(label, value, said)
            else:
                written.matrix(label, value, said)
        return written.text

    @property
    def law(self):
        """The files of the law in C: a dict from their names to their texts.

        <name>_run.h and <name>_run.c are what every program does around it. With a
        steering two more hold the heading: they add and take as much voltage on either
        side, of what the limit leaves, and <name>.c stays as it is.
        """
        files = ROBOT | (STEERING if self.steering else {})
        texts = law_texts(files, self.name)
        texts = {f"{self.name}{end}": text for end, text in texts.items()}
        return texts | {f"{self.name}_gains.h": self.gains}

    @property
    def rc_balance(self):
        """Files for librobotcontrol on a BeagleBone Blue: a dict to their texts.

        rc_<name>.c and rc_robot.h stand beside the files of `law`. The sensors are
        read as in the library's example rc_balance; its theta, phi and duty have the
        signs of `Mip`.
        """
        robot = wired(self.robot)
        values = {"BOARD_MOUNT_ANGLE": robot.mount, "COUNTS": robot.counts}
        text = fill("rc_balance.c", self._provenance, values, self.name)
        return {f"rc_{self.name}.c": text, **rc_robot(robot, self.firmware.law.T)}

    @property
    def pyctrl(self):
        """The text of pyctrl_<name>.py, for pyctrl 0.4.3, the thesis's own software.

        pyctrl's block for sampled systems presets no state and knows no limit, so the
        script compiles the files of `law`, which lie beside it, and has a block that
        calls them.
        """
        robot = wired(self.robot)
        signs = pyctrl_signs(robot)
        values = {
            "T": self.firmware.law.T,
            "STEERS": self.steering is not None,
            "MOUNT": f"{robot.mount!r} / TURN",
            "BATTERY": robot.nominal,
            "COUNTS": robot.counts,
            "THEIRS": PYCTRL_COUNTS_PER_TURN,
            "MOTOR_POLARITY": signs["motor"],
            "ENCODER_POLARITY": signs["encoder"],
        }
        note = replace(self, precision="double")._provenance
        return fill("pyctrl_balance.py", note, values, self.name)

    @property
    def ros(self):
        """A package of ROS 2 around rc_<name>: a dict from files to their texts.

        Its node passes orders on, says odometry, joints, battery and faults, and takes
        part in no tick: ROS keeps no clock.
        """
        if self.steering is None:
            raise ValueError("a robot without track has no heading: ROS 2 turns it")
        values = {"NODE": f'"{self.name}"', "RADIUS": wired(self.robot).r}
        values["PER_RADIAN"] = self.steering.per_radian
        note, folder = self._provenance, f"ros_{self.name}"
        files = {f"{folder}.py": fill("ros_balance.py", note, values, self.name)}
        for name in ("package.xml", "CMakeLists.txt"):
            files[name] = fill(name, note, {}, self.name)
        return {f"{folder}/{file}": text for file, text in files.items()}

    @property
    def sketch(self):
        """A sketch for Arduino and PlatformIO: a dict from files to their texts.

        The law is in single precision, in files named <name>_single; the robot must
        be given, for its counts, its gyro's range and its motors' limit.
        """
        folder, robot = f"{self.name}_sketch", self.robot
        law = replace(self, name=f"{self.name}_single", precision="single")
        values = {"TURN": f"6.2831853f / {single(robot.counts)}"}
        note = law._provenance
        files = {
            f"{folder}.ino": fill("balance_sketch.ino", note, values, self.name),
            "platformio.ini": fill("platformio.ini", [written_by()], {}),
            **law.law,
        }
        files = {f"{folder}/{file}": text for file, text in files.items()}
        return files | board_files(folder, robot, note)

    @property
    def _provenance(self):
        """Where the program comes from, line by line."""
        firmware, law = self.firmware, self.firmware.law
        rounded = (
            "Every number is rounded to single precision; what is said of the law is "
            "said of its decimals."
        )
        return [
            written_by(),
            *(line for text in law.note for line in str(text).splitlines()),
            *[rounded] * (self.precision == "single"),
            f"T_s = {law.T:.9g} s, at most {firmware.limit:.9g} V, order {law.order}.",
        ]

    @property
    def _around(self):
        """The program's numbers for its clock and for set points that move."""
        drive, T = self.drive or Drive(), self.firmware.law.T
        jitter = self.robot.jitter if self.robot else 0.0
        return {
            "DELAY": float(self.robot.delay) if self.robot else 0.0,
            "SLACK": max(round(jitter, 9), CLOCK_SHARE * T),
            "MOST_LATE": self.firmware.late,
            "REST_TICKS": round(1 / T),
            "SPEED": float(drive.speed),
            "ACCELERATION": float(drive.acceleration),
            "TURN_RATE": float(drive.turn),
            "TURN_ACCELERATION": float(drive.turn_acceleration),
        }
