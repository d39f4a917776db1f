"""A sketch for Arduino and PlatformIO around the law in single precision."""

from .c_code import c_header, c_source, provenance
from .recording import board_files
from .spelling import single
from .steering_code import c_steering, motion_values
from .template import fill, written_by

__all__ = ["sketch"]


def sketch(firmware, robot, name="balance", drive=None, steering=None):
    """The files of a sketch that balances a robot.

    Parameters
    ----------
    firmware : Firmware
        The law, its limits and its faults.
    robot : Robot
        Its counts, its gyro's range and its motors' limit.
    name : str
        The name of the law's files; the sketch is <name>_sketch.
    drive : Drive, optional
        How fast it may be told to roll; without it, it stays in place.
    steering : Steering, optional
        What holds its heading; without it both motors get the same voltage.

    Returns
    -------
    dict
        From the files' names to their texts.

    Raises
    ------
    ValueError
        As for `c_source`.

    Examples
    --------
    >>> from sosbook.pendulum import PD_SIGNALS, Firmware, Gain, Robot, SampledLaw
    >>> gain = Gain([[20, 0.8, 2, 0.9]], PD_SIGNALS)
    >>> law = SampledLaw.of_gain(gain, 0.005)
    >>> sorted(sketch(Firmware(law), Robot.shipped("gearmotors")))[0]
    'balance_sketch/balance_single.c'
    """
    folder, law, T = f"{name}_sketch", f"{name}_single", firmware.law.T
    note = provenance(firmware, "single")
    values = {
        "STEERS": int(steering is not None),
        "TICK": f"{round(1e6 * T)}UL",
        "HERTZ": single(1 / T),
        "TURN": f"6.2831853f / {single(robot.counts)}",
        "REST_TICKS": round(1 / T),
        **motion_values(drive, steering, single),
    }
    code = fill("balance_sketch.ino", note, values, name)
    steers = {} if steering is None else c_steering(steering, law, "single")
    return {
        f"{folder}/{folder}.ino": code,
        f"{folder}/{law}.h": c_header(firmware, law, "single"),
        f"{folder}/{law}.c": c_source(firmware, law, "single"),
        f"{folder}/platformio.ini": fill("platformio.ini", [written_by()], {}),
        **{f"{folder}/{file}": text for file, text in steers.items()},
        **board_files(folder, robot, note),
    }
