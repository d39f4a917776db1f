"""A sketch for Arduino and PlatformIO around the law in single precision."""

from .c_code import c_header, c_source, provenance
from .drive import Drive
from .firmware import FAULTS
from .recording import BAUD, board_files
from .steering_code import c_steering, sketch_steering
from .template import comment, fill, written_by

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
    folder, single, T = f"{name}_sketch", f"{name}_single", firmware.law.T
    drive, note = drive or Drive(), provenance(firmware, "single")
    code = fill(
        "balance.ino",
        {"note": comment(note, " * "), "name": name},
        micros=f"{round(1e6 * T)}UL",
        hertz=f"{1 / T:.9g}f" if "." in f"{1 / T:.9g}" else f"{1 / T:.9g}.0f",
        counts=f"{float(robot.counts)!r}f",
        speed=f"{float(drive.speed)!r}f",
        acceleration=f"{float(drive.acceleration)!r}f",
        rest=round(1 / T),
        reasons=", ".join(f'"{fault}"' for fault in FAULTS),
        baud=BAUD,
        **sketch_steering(steering, drive, single),
    )
    steers = {} if steering is None else c_steering(steering, single, "single")
    return {
        f"{folder}/{folder}.ino": code,
        f"{folder}/{single}.h": c_header(firmware, single, "single"),
        f"{folder}/{single}.c": c_source(firmware, single, "single"),
        f"{folder}/platformio.ini": fill(
            "platformio.ini", {"note": written_by(), "baud": BAUD}
        ),
        **{f"{folder}/{file}": text for file, text in steers.items()},
        **board_files(folder, robot, note),
    }
