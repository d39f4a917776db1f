"""A `Steering` as source code, and what the programs with it have more."""

from . import spelling
from .c_code import DIGITS, guards, words
from .firmware import TRUSTED_VOLTS
from .steering import MOST_LOST, Steering
from .template import fill
from .ticks import STEER_COLUMNS

__all__ = ["c_steering", "rc_steering", "script_steering", "sketch_steering"]


def constants(steering):
    """Name, value and unit of the numbers of a ``steering`` outside its gain."""
    T = steering.firmware.law.T
    return [
        ("TICK", T, "s"),
        ("HERTZ", 1 / T, "Hz"),
        ("LIMIT", steering.firmware.limit, "V"),
        ("SHARE", steering.volts, "V, for steering"),
        ("REACH", steering.reach, "rad a tick"),
        ("UNWIND", steering.unwinding, "rad s per V"),
        ("TRUSTED", TRUSTED_VOLTS, "V"),
    ]


def gained(steering):
    """u of a ``steering``, in the words of C and of Python."""
    return spelling.total([("K", steering.K[0], "y[{}]")])


def c_steering(steering, name="balance", precision="double"):
    """The C program that holds a heading beside the one that balances.

    Parameters
    ----------
    steering : Steering
        The law, with the firmware beside which it runs.
    name, precision
        As for `c_header`.

    Returns
    -------
    dict
        From <name>_steer.h and <name>_steer.c to their texts.

    Raises
    ------
    ValueError
        As for `c_header`.

    Notes
    -----
    It adds and takes as much voltage on either side, of what the limit leaves:
    <name>.c, and what is proven of it, stays as it is. Of MISRA C:2012 it doesn't
    meet 10.4 and 10.8 either (a sum of ints becomes a float, and is divided by 2).

    Examples
    --------
    >>> from sosbook.pendulum import PD_SIGNALS, Firmware, Gain, SampledLaw
    >>> from sosbook.pendulum.steering import Steering
    >>> gain = Gain([[20, 0.8, 2, 0.9]], PD_SIGNALS)
    >>> firmware = Firmware(SampledLaw.of_gain(gain, 0.01))
    >>> sorted(c_steering(Steering(firmware, [[-1, -0.1, -0.5]], 0.25, 0.08, 0.034)))
    ['balance_steer.c', 'balance_steer.h']
    """
    values = words(steering.firmware, name, precision)

    def number(value):
        return spelling.literal(value, precision)

    source = fill(
        "steer.c",
        values,
        guards=guards(precision),
        constants="\n".join(
            spelling.c_constants(constants(steering), values["real"], number)
        ),
        gain=spelling.braces(steering.K[0], number),
        output=gained(steering),
        most=MOST_LOST,
        largest=f"{DIGITS[precision][0]}_MAX",
    )
    header = fill("steer.h", values, per_radian=f"{steering.per_radian:.9g}")
    return {f"{name}_steer.h": header, f"{name}_steer.c": source}


def _kept(steering, places):
    """The texts at the ``places`` of a program that steers, or nothing."""
    return places if steering is not None else dict.fromkeys(places, "")


def rc_steering(steering, drive, name, real):
    """The places of rc_balance.c for a steering or None.

    The ``drive`` says how fast it may turn; ``name`` and ``real`` are the files'
    and the type of a number.
    """
    columns = STEER_COLUMNS
    texts = dict(
        file=f" {name}_steer.c",
        include=f'\n#include "{name}_steer.h"',
        use="""
 * A second number, in the file or in the line, is the turn rate in rad/s,
 * positive to the left: v 2 0.5. Without one the robot keeps its heading.
 *""",
        stick=" and left",
        dsm="#define DSM_TURN 2 /* channel */\n#define DSM_TURN_POLARITY 1\n",
        limits=_limits(steering, drive, "#define {} {} /* {} */\n", repr),
        state=f"""static double heading, turn_rate; /* rad and rad/s, set points */
static {name}_steering steering;
static double wheel[2]; /* rad, left and right */
static {real} motor[2]; /* V, left and right */
""",
        wanted="static volatile int wanted_turn;\n",
        row="    double " + ", ".join(columns) + ";\n",
        note="".join(
            f"    row[n].{name} = {value};\n"
            for name, value in zip(
                columns,
                (
                    "wheel[0]",
                    "wheel[1]",
                    "(double)motor[0]",
                    "(double)motor[1]",
                    "heading",
                ),
            )
        ),
        drive=f"""\
/* Each motor its volts; with a battery that hasn't them, balance is first. */
static void drive(const {real} volts[2])
{{
    const double most = battery / 1000.0;
    const double left = (double)volts[0], right = (double)volts[1];
    const double mean = cut((left + right) / 2, most);
    const double half = cut((right - left) / 2, most - (mean < 0 ? -mean : mean));
    rc_motor_set(MOTOR_CHANNEL[0], MOTOR_POLARITY[0] * (mean - half) / most);
    rc_motor_set(MOTOR_CHANNEL[1], MOTOR_POLARITY[1] * (mean + half) / most);
}}

""",
        ramp="""\
    turn_rate += cut(wanted_turn / 1000.0 - turn_rate,
        TURN_ACCELERATION / RATE_HZ);
    heading += turn_rate / RATE_HZ;
""",
        wheels="""\
    wheel[0] = read_wheel(0);
    wheel[1] = read_wheel(1);
    const double wheels = (wheel[0] + wheel[1]) / 2;
""",
        tick=f"""\
        {name}_steer(&steering, &robot, ({real})wheel[0], ({real})wheel[1],
            ({real})(PER_RADIAN * heading), ({real})(PER_RADIAN * turn_rate),
            motor);
""",
        volts="motor",
        start=f"""\
        heading = turn_rate = 0;
        motor[0] = motor[1] = 0;
        {name}_steer_start(&steering, ({real})wheel[0], ({real})wheel[1]);
""",
        want="    wanted_turn = (int)(1000 * cut(turn, TURN_RATE));\n",
        radio="\n            TURN_RATE * stick(DSM_TURN, DSM_TURN_POLARITY)",
        format=',%.17g"\n                ",%.17g,%.17g,%.17g,%.17g',
        save="".join(
            f",\n                row[n].{a}, row[n].{b}"
            for a, b in zip(columns[::2], columns[1::2])
        )
        + f", row[n].{columns[-1]}",
        columns="".join(f",{word}" for word in columns),
    )
    texts = _kept(steering, texts)
    if steering is None:
        texts |= dict(
            drive="""\
/* Both motors get the same voltage, as far as the battery has it. */
static void drive(double volts)
{
    double duty = 1000 * volts / battery;
    duty = duty > 1 ? 1 : duty < -1 ? -1 : duty;
    for (int side = 0; side < 2; side++)
        rc_motor_set(MOTOR_CHANNEL[side], MOTOR_POLARITY[side] * duty);
}

""",
            wheels="    const double wheels = (read_wheel(0) + read_wheel(1)) / 2;\n",
            volts="volts",
            radio="0",
        )
    return {f"steer_{key}": text for key, text in texts.items()}


def script_steering(steering, drive):
    """The places of pyctrl_balance.py for a ``steering`` or None, and a ``drive``."""
    texts = dict(
        use=",\nand a second one, the turn rate in rad/s, positive to the left",
        limits=_limits(steering, drive, "{} = {}  # {}\n", repr),
        law="" if steering is None else _script_law(steering),
        made="\n        self.steering, self.wanted_turn = Steering(), 0.0",
        turned="        turned = WHEEL * left * encoder1, WHEEL * right * encoder2\n",
        volts="        self.motors = 0.0, 0.0\n",
        tick="""\
            self.motors = self.steering.step(
                self.law, *turned, PER_RADIAN * self.heading,
                PER_RADIAN * self.turn_rate)
""",
        start="""\
            self.heading = self.turn_rate = 0.0
            self.steering.start(*turned)
""",
        write="""\
        mean, half = (100 * (self.motors[1] + side * self.motors[0]) / 2 / BATTERY
                      for side in (1, -1))
        mean = cut(mean, 100.0)
        half = cut(half, 100.0 - abs(mean))  # balance is first
        left, right = MOTOR_POLARITY
        super().write(left * (mean - half), right * (mean + half))
""",
        ramp="""
        more = self.wanted_turn - self.turn_rate
        self.turn_rate += cut(more, TURN_ACCELERATION / HERTZ)
        self.heading += self.turn_rate / HERTZ""",
        note=",\n                              *turned, *self.motors, self.heading",
        given=", turned=()",
        pass_=", turned",
        columns="".join(f', "{word}"' for word in STEER_COLUMNS),
        obey="\n                self.wanted_turn = cut(turn, TURN_RATE)",
        stop="\n            self.wanted_turn = 0.0",
    )
    texts = _kept(steering, texts)
    if steering is None:
        texts["write"] = """\
        percent = 100 * volts / BATTERY
        percent = 100.0 if percent > 100 else max(percent, -100.0)
        left, right = MOTOR_POLARITY
        super().write(left * percent, right * percent)
"""
    return {f"steer_{key}": text for key, text in texts.items()}


def _script_law(steering):
    """The class of Python that does what `Steered` does for one robot."""
    own = [x for x in constants(steering) if x[0] not in ("HERTZ", "LIMIT", "TRUSTED")]
    lines = "".join(f"    {line}\n" for line in spelling.python_constants(own))
    return f'''
class Steering:
    """What holds the heading, beside the law."""

{lines}    K = {steering.K[0].tolist()!r}

    def start(self, left, right):
        """The robot rests; the wheels' angles in rad."""
        self.turned = self.zero = right - left
        self.sum, self.lost = 0.0, 0

    def step(self, law, left, right, target=0.0, rate=0.0):
        """The volts of both motors, after the law's tick; zero after a fault."""
        if law.fault:
            return 0.0, 0.0
        V, half = law.volts, self.difference(law, right - left, target, rate) / 2
        return cut(V - half, LIMIT), cut(V + half, LIMIT)

    def difference(self, law, turned, target, rate):
        """Right less left, as far as balancing leaves them."""
        if not within(self.turned, sys.float_info.max):  # a start without a reading
            self.turned = self.zero = turned
        K, since = self.K, self.lost + 1.0
        y = [turned - self.zero - target,
             (turned - self.turned) * HERTZ / since - rate, self.sum]
        u = {gained(steering)}
        W = cut(u, 2 * min(LIMIT - abs(law.volts), self.SHARE))
        seen = within(turned - self.turned, self.REACH * since)
        if not (seen and within(u, TRUSTED)):
            self.lost += 1
            return 0.0
        self.sum = self.sum + self.TICK * y[0] + self.UNWIND * (W - u)
        self.turned, self.lost = turned, 0
        return W

'''


def sketch_steering(steering, drive, single):
    """The places of balance.ino for a steering or None.

    The ``drive`` says how fast it may turn, and ``single`` is the law's name.
    """
    columns = "".join(f",{word}" for word in STEER_COLUMNS)
    texts = dict(
        include=f'\n#include "{single}_steer.h"',
        use=" 0.5",
        turns=", and turn left with 0.5 rad/s",
        limits=_limits(
            steering,
            drive,
            "static const float {} = {}; /* {} */\n",
            lambda x: f"{x!r}f",
        ),
        state=f"""static {single}_steering steering;
static float wheel[2], motor[2]; /* left and right: rad, V */
static float heading, turn_rate, wanted_turn; /* rad, rad/s */
""",
        drive="""\
static float cut(float x, float bound)
{
    return x > bound ? bound : x < -bound ? -bound : x;
}

/* With a battery that hasn't the volts, balance is first. */
static void drive_both(void)
{
    const float most = io_supply();
    const float mean = cut((motor[0] + motor[1]) / 2, most);
    const float half = cut((motor[1] - motor[0]) / 2,
        most - (mean < 0 ? -mean : mean));
    io_drive(0, mean - half);
    io_drive(1, mean + half);
}

""",
        wheels="""\
    wheel[0] = TURN * (float)io_encoder(0);
    wheel[1] = TURN * (float)io_encoder(1);
    const float wheels = (wheel[0] + wheel[1]) / 2;
""",
        ramp="""\
    turn_rate += cut(wanted_turn - turn_rate, TURN_ACCELERATION / HERTZ);
    heading += turn_rate / HERTZ;
""",
        tick=f"""\
        {single}_steer(&steering, &robot, wheel[0], wheel[1],
            PER_RADIAN * heading, PER_RADIAN * turn_rate, motor);
        drive_both();
""",
        start=f"""\
        heading = turn_rate = wanted_turn = motor[0] = motor[1] = 0;
        {single}_steer_start(&steering, wheel[0], wheel[1]);
""",
        fault="    Serial.print(fault);\n    print(wheel[0]);\n    print(wheel[1]);\n"
        "    print(motor[0]);\n    print(motor[1]);\n    print(heading);\n"
        '    Serial.println("");\n',
        want="        wanted_turn = cut(turn, TURN_RATE);\n",
        stop="        wanted_turn = 0;\n",
        columns=f'\n                "{columns}"',
    )
    texts = _kept(steering, texts)
    if steering is None:
        texts |= dict(
            wheels="""\
    const float wheels = TURN * (float)(io_encoder(0) + io_encoder(1)) / 2;
""",
            tick="        drive(volts);\n",
            want="        (void)turn;\n",
            fault="    Serial.println(fault);\n",
        )
    return {f"steer_{key}": text for key, text in texts.items()}


def _limits(steering, drive, line, number):
    """The lines that say how fast a program may turn, spelled by ``number``."""
    if steering is None:
        return ""
    if not isinstance(steering, Steering):
        raise ValueError("steering must be a Steering, or left out")
    return "".join(
        line.format(name, number(float(value)), unit)
        for name, value, unit in (
            ("TURN_RATE", drive.turn, "rad/s of the heading, at most"),
            ("TURN_ACCELERATION", drive.turn_acceleration, "rad/s^2"),
            ("PER_RADIAN", steering.per_radian, "rad right less left, per rad"),
        )
    )
