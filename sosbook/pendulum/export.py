"""A `Firmware` as source code for robots: C99, librobotcontrol, pyctrl.

The programs do what `Controller` does, operation by operation. Their
text depends on the firmware and on the package's version alone.
"""

import re

from . import spelling
from .boards import PYCTRL_COUNTS_PER_TURN, dmp_rate, pins, pyctrl_signs, wired
from .drive import Drive
from .firmware import FAULTS, Firmware
from .steering_code import rc_steering, script_steering, steer_files
from .template import comment, fill, python_comment, written_by

__all__ = [
    "c_header",
    "c_source",
    "c_steering",
    "pyctrl_script",
    "rc_balance",
    "serial_main",
]

C_TYPES = {"double": "double", "single": "float"}
TAKEN_NAMES = {"float", "math", "rc", "robotcontrol", "stdint", "stdio"}
MOST_TICKS = 32766  # the least that C promises of an int, 32767, less one


def c_header(firmware, name="balance", precision="double"):
    """The header of the C program.

    Parameters
    ----------
    firmware : Firmware
        The law, its limits and its faults.
    name : str
        The name of the files, which also stands in front of every identifier.
    precision : {"double", "single"}
        The precision of all arithmetic.

    Returns
    -------
    str
        The text of <name>.h.

    Raises
    ------
    ValueError
        If ``name`` can't begin a C identifier, or the firmware's
        numbers don't fit.

    Examples
    --------
    >>> from sosbook.pendulum import SampledLaw
    >>> law = SampledLaw.of_gain([[20, 0.8, 2, 0.9]], 0.01)
    >>> print(c_header(Firmware(law)).splitlines()[0])
    /* balance.h: a control law for a mobile inverted pendulum
    """
    values = _words(firmware, name, precision)
    order = firmware.law.order
    reason = {
        "running": "no fault",
        "sensor": f"over {firmware.missing} bad readings in a row"
        + (f", or over {firmware.frozen} repeated" if firmware.frozen else "")
        + (
            f", or over {firmware.deaf} of still wheels under voltage"
            if firmware.deaf
            else ""
        ),
        "fall": f"the body tilts by more than {firmware.tip:.9g} rad",
        "stall": f"over {firmware.stall} ticks at the voltage's limit",
        "command": "the law's answer is no number to trust",
    }
    faults = [
        f"    {name.upper()}_{fault.upper()} = {k},  /* {reason[fault]} */"
        for k, fault in enumerate(FAULTS)
    ]
    x = f"x[{order}];".ljust(12)
    state = f"    {C_TYPES[precision]} {x}/* the law's state */\n"
    return fill(
        "law.h",
        values,
        faults="\n".join(faults).replace(
            f" = {len(FAULTS) - 1},", f" = {len(FAULTS) - 1} "
        ),
        x=state if order else "",
        T=f"{firmware.law.T:.9g}",
        tip=f"{firmware.tip:.9g} rad",
    )


def c_source(firmware, name="balance", precision="double"):
    """The C program, for a compiler with IEEE numbers; C99, no library.

    Parameters
    ----------
    firmware, name, precision
        As for `c_header`.

    Returns
    -------
    str
        The text of <name>.c, which stands beside <name>.h.

    Raises
    ------
    ValueError
        As for `c_header`, and if the law doesn't use what it measures.

    Notes
    -----
    Compile with -ffp-contract=off: fused operations round once where
    the law's arithmetic rounds twice. Constants are hexadecimal, so
    that no digit is lost; zero coefficients are left out.

    MISRA C:2012, as far as cppcheck's addon looks: of the required rules two are
    not met, 14.4 (``if (!seen)`` asks an int) and 15.6 (a single statement stands
    without braces). Of the advisory ones it doesn't keep 2.4 and 5.9 (the enum has
    no tag, and each file has a ``within`` of its own), 8.9 (constants stand at the
    file's top), 12.1 (no parentheses where precedence decides), 15.5 (it returns
    early after a fault) and 17.8 (a bad reading is replaced in its argument). There
    is no heap, no recursion, no pointer arithmetic and no library.

    Examples
    --------
    >>> from sosbook.pendulum import SampledLaw
    >>> law = SampledLaw.of_gain([[20, 0.8, 2, 0.9]], 0.01)
    >>> text = c_source(Firmware(law))
    >>> print(text[text.index("const double u"):].partition(";")[0])
    const double u =
        D[0] * y[0] + D[1] * y[1] + D[2] * y[2] + D[3] * y[3]
    """
    values = _words(firmware, name, precision)
    law, real = firmware.law, C_TYPES[precision]

    def number(value):
        return spelling.literal(value, precision)

    constants = [
        f"static const {real} {label} = {number(value)};  /* {value:.9g} {unit} */"
        for label, value, unit in spelling.constants(firmware)
    ] + [
        f"static const int {label} = {value};  /* ticks in a row */"
        for label, value in spelling.counts(firmware)
    ]
    matrices = [
        f"static const {real} {label}{spelling.size(value)} = "
        f"{spelling.braces(value, number)};"
        for label, value in spelling.matrices(law)
    ]
    output, following = spelling.output(law), spelling.following(law)
    start = [f"    s->x[{i}] = START[{i}] * tilt;\n" for i in range(law.order)]
    alias = f"    const {real} *x = s->x;\n"
    after = ""
    if law.order:
        rows = "".join(f"        {row},\n" for row in following)
        after = (
            f"    const {real} next[{law.order}] = {{\n{rows}"
            f"    }};\n    for (int i = 0; i < {law.order}; i++)\n"
            "        s->x[i] = next[i];\n"
        )
    uses_x = "x[" in output + "".join(following)
    mantissa, digits = ("FLT", 24) if precision == "single" else ("DBL", 53)
    return fill(
        "law.c",
        values,
        mantissa=mantissa,
        digits=digits,
        constants="\n".join(constants),
        matrices="\n".join(matrices),
        start="".join(start),
        alias=alias if uses_x else "",
        command=_command(firmware, output, real),
        next=after,
    )


def _command(firmware, output, real):
    """The lines of C that make the command u from the law's output."""
    more = spelling.compensated(firmware, "{0} ? {1} : {2}".format)
    if not more:
        return f"    const {real} u =\n        {output};\n"
    return (
        f"    {real} u =\n        {output};\n"
        f"    u = u + ({more}); /* against friction */\n"
    )


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
    >>> from sosbook.pendulum import SampledLaw
    >>> from sosbook.pendulum.steering import Steering
    >>> firmware = Firmware(SampledLaw.of_gain([[20, 0.8, 2, 0.9]], 0.01))
    >>> sorted(c_steering(Steering(firmware, [[-1, -0.1, -0.5]], 0.25, 0.08, 0.034)))
    ['balance_steer.c', 'balance_steer.h']
    """
    words = _words(steering.firmware, name, precision)
    return steer_files(steering, name, words, precision)


def rc_balance(
    firmware, name="balance", precision="double", robot=None, drive=None, steering=None
):
    """A program for librobotcontrol on a BeagleBone Blue.

    Parameters
    ----------
    firmware, name, precision
        As for `c_header`.
    robot : Robot, optional
        Its counts, mount, battery, channels and polarities; the
        thesis's robot without it.
    drive : Drive, optional
        How fast it may be told to roll; without it, it stays in place.
    steering : Steering, optional
        What holds its heading; without it both motors get the same voltage.

    Returns
    -------
    str
        The text of rc_<name>.c, which stands beside <name>.h and <name>.c, and
        with ``steering`` beside the files of `c_steering`.

    Raises
    ------
    ValueError
        As for `c_header`, if the IMU doesn't have the law's rate, or
        if the robot has another board.

    Notes
    -----
    The sensors are read as in the library's example rc_balance; its
    theta, phi and duty have the signs of `Mip`.

    Examples
    --------
    >>> from sosbook.pendulum import SampledLaw
    >>> law = SampledLaw.of_gain([[20, 0.8, 2, 0.9]], 0.01)
    >>> "rc_mpu_set_dmp_callback(tick)" in rc_balance(Firmware(law))
    True
    """
    values = _words(firmware, name, precision)
    hertz = dmp_rate(firmware.law.T)
    robot = wired(robot)
    reasons = ", ".join(f'"{fault}"' for fault in FAULTS)
    low, high = robot.battery
    return fill(
        "rc_balance.c",
        values,
        hertz=hertz,
        reasons=reasons,
        mount=repr(robot.mount),
        counts=repr(robot.counts),
        nominal=repr(robot.nominal),
        low=repr(low),
        high=repr(high),
        **pins(robot),
        **_limits(drive),
        **rc_steering(steering, drive or Drive(), name, values["real"]),
    )


def pyctrl_script(firmware, robot=None, drive=None, name="balance", steering=None):
    """A Python script for pyctrl 0.4.3, the thesis's own software.

    pyctrl's block for sampled systems presets no state and knows no
    limit, so the script has a block of its own with all that
    `Controller` does, in plain Python.

    Parameters
    ----------
    firmware : Firmware
        The law, its limits and its faults.
    robot, drive
        As for `rc_balance`.
    name : str
        The script is pyctrl_<name>.py.
    steering : Steering, optional
        As for `rc_balance`.

    Returns
    -------
    str
        The text of the script.

    Raises
    ------
    ValueError
        As for `c_source`, and if the robot has another board or
        channels that pyctrl doesn't have.

    Examples
    --------
    >>> from sosbook.pendulum import SampledLaw
    >>> law = SampledLaw.of_gain([[20, 0.8, 2, 0.9]], 0.01)
    >>> code = compile(pyctrl_script(Firmware(law)), "balance.py", "exec")
    """
    values = _words(firmware, name, "double")
    law, robot = firmware.law, wired(robot)
    signs = pyctrl_signs(robot)
    constants = [
        f"{label} = {float(value)!r}  # {unit}"
        for label, value, unit in spelling.constants(firmware)
    ]
    constants += [
        f"{label} = {value}  # ticks in a row"
        for label, value in spelling.counts(firmware)
    ]
    matrices = [
        f"{label} = {spelling.nested(value)}" for label, value in spelling.matrices(law)
    ]
    after = "".join(f"\n            {row}," for row in spelling.following(law))
    start = ", ".join(f"START[{i}] * tilt" for i in range(law.order))
    more = spelling.compensated(firmware, "{1} if {0} else {2}".format)
    values["note"] = python_comment(provenance(firmware))
    return fill(
        "pyctrl.txt",
        values,
        constants="\n".join(constants),
        faults=FAULTS,
        matrices="\n".join(matrices),
        start=start,
        output=spelling.output(law),
        more=f"        u = u + ({more})\n" if more else "",
        next=f"{after}\n        " if after else "",
        T=repr(float(law.T)),
        mount=repr(robot.mount),
        nominal=repr(robot.nominal),
        counts=repr(robot.counts),
        theirs=repr(PYCTRL_COUNTS_PER_TURN),
        **signs,
        **_limits(drive),
        **script_steering(steering, drive or Drive()),
    )


def serial_main(firmware, name="balance", precision="double"):
    """A main program for hardware in the loop: lines in, volts out.

    Parameters
    ----------
    firmware, name, precision
        As for `c_header`.

    Returns
    -------
    str
        The text of serial_<name>.c, which stands beside <name>.h and <name>.c.

    Examples
    --------
    >>> from sosbook.pendulum import SampledLaw
    >>> law = SampledLaw.of_gain([[20, 0.8, 2, 0.9]], 0.01)
    >>> "int main(void)" in serial_main(Firmware(law))
    True
    """
    return fill("serial.c", _words(firmware, name, precision))


def _limits(drive):
    """The numbers of a `Drive`, or of none, as programs spell them."""
    drive = drive or Drive()
    return {x: repr(float(getattr(drive, x))) for x in ("speed", "acceleration")}


def _words(firmware, name, precision):
    """What every template needs; checks the arguments."""
    if not isinstance(firmware, Firmware):
        raise ValueError("firmware must be a Firmware")
    if precision not in C_TYPES:
        raise ValueError(f"precision must be 'double' or 'single', got {precision!r}")
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
    for field in ("missing", "frozen", "stall", "deaf"):
        if getattr(firmware, field) > MOST_TICKS:
            raise ValueError(
                f"{field} must be at most {MOST_TICKS}, for C's int, got "
                f"{getattr(firmware, field)}"
            )
    law = firmware.law
    if not (law.D.any() or (law.C.any() and law.B.any())):
        raise ValueError("law doesn't use what it measures: D is zero, and B or C")
    return {
        "name": name,
        "NAME": name.upper(),
        "real": C_TYPES[precision],
        "note": comment(provenance(firmware, precision), " * "),
    }


def provenance(firmware, precision="double"):
    """Where a ``firmware`` in a ``precision`` comes from, line by line."""
    law = firmware.law
    about = firmware.note if not isinstance(firmware.note, str) else (firmware.note,)
    lines = [
        written_by(),
        *(line for text in about for line in str(text).splitlines()),
        *(
            [
                "Every number is rounded to single precision; what is said of "
                "the law is said of its decimals."
            ]
            * (precision == "single")
        ),
        f"T_s = {law.T:.9g} s, at most {firmware.limit:.9g} V, order {law.order}.",
    ]
    return lines
