"""Files around a robot's law, held to their templates with a robot's numbers."""

import re

from ..controllers.code import value_of
from ..controllers.template import MARK
from ..runtime.reading import read_bytes
from .boards import fill, place

#: The template of each file, and its numbers, which are a robot's.
FILES = {
    "rc_{0}.c": ("rc_balance.c", "BOARD_MOUNT_ANGLE COUNTS"),
    "rc_robot.h": ("rc_robot.h", "V_NOMINAL V_LOW V_HIGH RATE_HZ MOTOR_CHANNEL "
                   "MOTOR_POLARITY ENCODER_CHANNEL ENCODER_POLARITY"),
    "pyctrl_{0}.py": ("pyctrl_balance.py", "T STEERS MOUNT BATTERY COUNTS THEIRS "
                      "MOTOR_POLARITY ENCODER_POLARITY"),
    "ros_{0}/ros_{0}.py": ("ros_balance.py", "NODE RADIUS PER_RADIAN"),
    "ros_{0}/package.xml": ("package.xml", ""),
    "ros_{0}/CMakeLists.txt": ("CMakeLists.txt", ""),
    "{0}_sketch/{0}_sketch.ino": ("balance_sketch.ino", "TURN"),
    "{0}_sketch/platformio.ini": ("platformio.ini", ""),
    "{0}_sketch/robot_io.h": ("robot_io.h", ""),
    "{0}_sketch/robot_io.cpp": ("robot_io.cpp", "COUNTS EDGES SEEN SUPPLY GYRO_STEP "
                                "GYRO_RANGE"),
}  # fmt: skip
VALUE = re.compile(r'(?:[-+0-9.eEfFxXABCD{}(), /]|TURN|"[a-z]\w*")+')


def around(where, name, numbers):
    """(path, what sosbook writes there) of each file around a robot's law.

    ``where``: its folder; ``name``: of the program; ``numbers``: definitions of its
    <name>_gains.h. A robot's own numbers are those of the file, for nothing else has
    them; the clock, the steering and its ratio are those of the law. Lines that say
    where a file comes from have a `MARK` in their place.
    """
    tick = value_of(numbers["TICK"])
    tied = {"T": tick, "RATE_HZ": round(1 / tick), "STEERS": numbers["STEERS"] == "1"}
    if "PER_RADIAN" in numbers:
        tied["PER_RADIAN"] = value_of(numbers["PER_RADIAN"])
    for file, (template, labels) in FILES.items():
        path = where / file.format(name)
        if path.is_file():
            text, values = read_bytes(path).decode("utf-8", "replace"), {}
            for label in labels.split():
                found = re.search(place(label), text.replace("\r\n", "\n"), re.M)
                if found and VALUE.fullmatch(found[2]):
                    values[label] = found[2]
            values |= {x: y for x, y in tied.items() if x in labels.split()}
            yield path, fill(template, [MARK], values, name)
