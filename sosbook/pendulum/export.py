"""A `Firmware` as source code for robots: C99, librobotcontrol, pyctrl.

The programs do what `Controller` does, operation by operation. Their
text depends on the firmware and on the package's version alone.
"""

from . import spelling
from .boards import PYCTRL_COUNTS_PER_TURN, dmp_rate, pins, pyctrl_signs, wired
from .c_code import c_header, c_source, provenance, serial_main, words
from .drive import Drive
from .firmware import FAULTS
from .steering_code import c_steering, rc_steering, script_steering
from .template import fill, python_comment

__all__ = [
    "c_header",
    "c_source",
    "c_steering",
    "pyctrl_script",
    "rc_balance",
    "serial_main",
]


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
    >>> from sosbook.pendulum import PD_SIGNALS, Firmware, Gain, SampledLaw
    >>> gain = Gain([[20, 0.8, 2, 0.9]], PD_SIGNALS)
    >>> law = SampledLaw.of_gain(gain, 0.01)
    >>> "rc_mpu_set_dmp_callback(tick)" in rc_balance(Firmware(law))
    True
    """
    values = words(firmware, name, precision)
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
    >>> from sosbook.pendulum import PD_SIGNALS, Firmware, Gain, SampledLaw
    >>> gain = Gain([[20, 0.8, 2, 0.9]], PD_SIGNALS)
    >>> law = SampledLaw.of_gain(gain, 0.01)
    >>> code = compile(pyctrl_script(Firmware(law)), "balance.py", "exec")
    """
    values = words(firmware, name, "double")
    law, robot = firmware.law, wired(robot)
    signs = pyctrl_signs(robot)
    constants = spelling.python_constants(spelling.constants(firmware))
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


def _limits(drive):
    """The numbers of a `Drive`, or of none, as programs spell them."""
    drive = drive or Drive()
    return {x: repr(float(getattr(drive, x))) for x in ("speed", "acceleration")}
