"""A `Firmware` as source code for robots: C99, librobotcontrol, pyctrl.

The programs do what `Controller` does, operation by operation. Their
text depends on the firmware and on the package's version alone.
"""

from . import spelling
from .boards import PYCTRL_COUNTS_PER_TURN, dmp_rate, pins, pyctrl_signs, wired
from .c_code import c_header, c_source, check, main_file, provenance, serial_main
from .steering_code import c_steering, motion_values
from .template import fill

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
    check(firmware, name, precision)
    robot = wired(robot)
    low, high = robot.battery
    values = {
        "STEERS": int(steering is not None),
        "RATE_HZ": dmp_rate(firmware.law.T),
        "BOARD_MOUNT_ANGLE": robot.mount,
        "COUNTS": robot.counts,
        "V_NOMINAL": robot.nominal,
        "V_LOW": low,
        "V_HIGH": high,
        **motion_values(drive, steering),
        **pins(robot),
    }
    return main_file("rc_balance.c", firmware, name, precision, values)


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
    check(firmware, name, "double")
    robot = wired(robot)
    signs = pyctrl_signs(robot)
    values = spelling.constants(firmware) | spelling.ticks(firmware)
    values |= {x: m.tolist() for x, m in spelling.matrices(firmware.law).items()}
    values |= motion_values(drive, steering)
    values |= {
        "STEERS": steering is not None,
        "MOUNT": f"{robot.mount!r} / TURN",
        "BATTERY": robot.nominal,
        "COUNTS": robot.counts,
        "THEIRS": PYCTRL_COUNTS_PER_TURN,
        "MOTOR_POLARITY": signs["motor"],
        "ENCODER_POLARITY": signs["encoder"],
        "K": steering.K[0].tolist() if steering else [0.0] * 3,
        "SHARE": steering.volts if steering else 0.0,
        "UNWIND": steering.unwinding if steering else 0.0,
    }
    return fill("pyctrl_balance.py", provenance(firmware), values, name)
