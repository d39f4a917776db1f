"""The boards that there are whole programs for: their pins, clocks and signs."""

import re
from itertools import product

import numpy as np

from ..controllers.template import noted, read, replaced, written_by
from .robot import Robot

__all__ = ["dmp_rate", "fill", "pyctrl_signs", "rc_robot", "wired", "wired_as_pyctrl"]

PYCTRL_COUNTS_PER_TURN = 60 * 35.557  # of a wheel, as pyctrl has it
PYCTRL_WIRING = {  # which can't be changed from outside
    "motor_channels": (3, 2),
    "motor_polarities": (1, -1),
    "encoder_channels": (3, 2),
    "encoder_polarities": (1, -1),
}
#: Rates in Hz of the motion processor in the IMU.
DMP_RATES = (200, 100, 50, 40, 25, 20, 10, 8, 5, 4)


def fill(template, note, values, name="balance"):
    """The program of a robot from a ``template``, a file of the folder templates.

    It runs as it stands, with an example's numbers. In ``#define NAME 0``, ``static
    const int NAME = 0;`` or ``NAME = 0`` the value is replaced by that of ``values``.
    ``note``: lines that say where the program comes from; ``name``: what stands for
    "balance" in the names of files and of functions.
    """
    text = read("sosbook.pendulum", template)
    for label, value in values.items():
        text = replaced(place(label), text, str(value))
    text = re.sub(r"\bbalance(?=_|\.(?:c|h|py|ino)\b)|(?<=_)balance\b", name, text)
    text = re.sub(r"\bBALANCE(?=_)", name.upper(), text)
    return noted(text, note)


def place(label):
    """The pattern of a ``label`` in a template, and of its value."""
    defines = rf"^(#define {label} |(?:static .*\b)?{label}(?:\[\w*\])* = )"
    return rf"{defines}([^;\n]*?)(?=;|  ?/\*|  #|$)"


def wired(robot):
    """The ``robot`` itself, if its board is the one these programs are for."""
    robot = robot or Robot.shipped("thesis")
    if robot.board != "beaglebone":
        raise ValueError(
            f'the robot\'s board is "{robot.board}": this program is for '
            "a BeagleBone Blue"
        )
    return robot


def wired_as_pyctrl(robot):
    """True if a ``robot`` has the channels that pyctrl knows."""
    return all(
        getattr(robot, word) == PYCTRL_WIRING[word]
        for word in PYCTRL_WIRING
        if "channels" in word
    )


def pyctrl_signs(robot):
    """The polarities of a ``robot`` over those that pyctrl has itself.

    It is a dict; other channels than pyctrl's are a ValueError.
    """
    for word in ("motor_channels", "encoder_channels"):
        if getattr(robot, word) != PYCTRL_WIRING[word]:
            raise ValueError(
                f"{word} = {list(getattr(robot, word))}: pyctrl has "
                f"{list(PYCTRL_WIRING[word])} and no others"
            )
    return {
        word: tuple(
            ours * theirs
            for ours, theirs in zip(
                getattr(robot, f"{word}_polarities"),
                PYCTRL_WIRING[f"{word}_polarities"],
            )
        )
        for word in ("motor", "encoder")
    }


def _pins(robot):
    """The channels and polarities of a robot as C names and spells them."""
    words, found = {"channels": "CHANNEL", "polarities": "POLARITY"}, {}
    for part, plural in product(("motor", "encoder"), words):
        pair = getattr(robot, f"{part}_{plural}")
        found[f"{part}_{words[plural]}".upper()] = "{{{}, {}}}".format(*pair)
    return found


def rc_robot(robot, T):
    """The file that programs for librobotcontrol share: its name and its text.

    It is of a ``robot`` whose samples are T apart.
    """
    low, high = robot.battery
    values = {"V_NOMINAL": robot.nominal, "V_LOW": low, "V_HIGH": high, **_pins(robot)}
    values["RATE_HZ"] = dmp_rate(T)
    note = [written_by(), f"robot: {robot.words}"]
    return {"rc_robot.h": fill("rc_robot.h", note, values)}


def dmp_rate(T):
    """The rate in Hz of samples T apart, or a ValueError if the IMU hasn't it."""
    hertz = round(1 / T)
    if hertz not in DMP_RATES or not np.isclose(hertz * T, 1):
        raise ValueError(
            f"law runs every {T:.9g} s, but the IMU's rates "
            f"are {', '.join(map(str, DMP_RATES))} Hz: sample the law anew"
        )
    return hertz
