"""A `Steering` as C, and its numbers in the programs around it."""

from . import spelling
from .c_code import check, law_file, with_numbers
from .drive import Drive
from .steering import Steering
from .template import replaced

__all__ = ["c_steering", "motion_values"]


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
    check(steering.firmware, name, precision)
    header, source = (
        law_file(f"balance_steer.{x}", steering.firmware, name, precision, {})
        for x in "hc"
    )
    of = spelling.constants(steering.firmware)
    numbers = {label: of[label] for label in ("HERTZ", "LIMIT", "TRUSTED")}
    numbers |= {"REACH": steering.reach, "TICK": steering.firmware.law.T}
    numbers |= {"SHARE": steering.volts, "UNWIND": steering.unwinding}
    source = with_numbers(source, numbers, precision)
    gain = spelling.braces(steering.K[0], precision)
    return {
        f"{name}_steer.h": replaced(
            r"( is )2\.5(?= rad of)", header, f"{steering.per_radian:.9g}"
        ),
        f"{name}_steer.c": replaced(r"(K\[3\] = )[^;]*(?=;)", source, gain),
    }


def motion_values(drive, steering, number=repr):
    """What a program around the law is told of a robot's motion.

    The ``drive`` says how fast it may roll and turn, the ``steering`` or None
    whether it holds its heading, and ``number`` spells a number.
    """
    if not isinstance(steering, Steering | None):
        raise ValueError("steering must be a Steering, or left out")
    drive = drive or Drive()
    values = {
        "SPEED": drive.speed,
        "ACCELERATION": drive.acceleration,
        "TURN_RATE": drive.turn,
        "TURN_ACCELERATION": drive.turn_acceleration,
        "PER_RADIAN": steering.per_radian if steering else 0,
    }
    return {label: number(float(value)) for label, value in values.items()}
