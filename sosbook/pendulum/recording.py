"""Programs that record the logs of the two experiments.

They come before any fit, so they take nothing but the robot's description.
"""

from math import pi, radians, sqrt

from ..controllers.numbers import single
from ..controllers.template import written_by
from ..plants.checks import positive
from ..runtime.writing import write_texts
from .boards import (
    PYCTRL_COUNTS_PER_TURN,
    fill,
    pyctrl_signs,
    rc_robot,
    wired_as_pyctrl,
)
from .robot import Robot

__all__ = ["board_files", "recorders", "sweeps", "write_recorders"]

#: Of the limit, the sines' amplitudes: the thesis's 1.85 V of 7.4 V, with which no
#: body swings over; free wheels may get most, beside which friction and play are small.
AMPLITUDE_SHARES = {"body": 0.25, "wheels": 0.8}
SWEEP_SECONDS = 30.0  # either way, as in the thesis
INERTIA_GUESS = 1.4  # of the body about the axle, over M_b l^2
BODY_SWEEP = 0.5, 10.0  # times the frequency at which the body swings
#: Hz, as in the thesis: wheels tell their numbers below 20 Hz, and beyond the end
#: gears' teeth swing.
WHEELS_SWEEP = 0.3, 30.0
HIGHEST_SHARE = 0.3  # of the sampling rate, the sweep's highest frequency
GYRO_RANGES = 250, 500, 1000, 2000  # deg/s, of the MPU-6050's four settings


def sweeps(robot):
    """The ends in Hz between which each experiment's sine sweeps: body, wheels.

    A ``robot``'s l and g say about how fast its body swings, its T which frequencies
    the samples can show.
    """
    swing = sqrt(robot.g / robot.l / INERTIA_GUESS) / (2 * pi)
    highest = HIGHEST_SHARE / robot.T
    low, high = BODY_SWEEP
    first, last = WHEELS_SWEEP
    return {
        "body": (low * swing, min(high * swing, highest)),
        "wheels": (first, min(last, highest)),
    }


def recorders(robot, amplitude=None, seconds=SWEEP_SECONDS):
    """The programs that record the logs of a ``robot``: from files' names to texts.

    A sketch for Arduino, with what it asks of a board; for a BeagleBone Blue also
    programs for librobotcontrol and, where its channels are pyctrl's, for pyctrl.
    ``amplitude``: of both sines, in V; without it `AMPLITUDE_SHARES` of the limit;
    ``seconds``: of a sweep, either way. A ValueError if a number isn't positive, or the
    amplitude is above the limit.
    """
    if amplitude is not None and positive("amplitude", amplitude) > robot.limit:
        raise ValueError(
            f"amplitude must be at most limit = {robot.limit:g} V, got {amplitude!r}"
        )
    volts = {
        name: float(share * robot.limit if amplitude is None else amplitude)
        for name, share in AMPLITUDE_SHARES.items()
    }
    note = [
        written_by(),
        f"robot: {robot.words}",
        f"sweeps: {volts['body']:g} V for the body, {volts['wheels']:g} V for the "
        f"wheels, for {seconds:g} s either way; on the body's way back each motor is "
        "driven alone, every other second",
    ]
    ends = {
        name.upper(): [float(f"{x:.6g}") for x in (*pair, volts[name])]
        for name, pair in sweeps(robot).items()
    }
    values = {"HERTZ": 1 / robot.T, "SECONDS": float(positive("seconds", seconds))}
    values["ALONE"] = float(min(2, robot.limit / volts["body"]))
    rows = {"ROWS": round(2 * seconds / robot.T)}
    sketch = {x: single(value) for x, value in values.items()} | rows
    sketch |= {x: f"{{{', '.join(map(single, sweep))}}}" for x, sweep in ends.items()}
    sketch["TICK"] = f"{round(1e6 * robot.T)}UL"
    files = {"identify/identify.ino": fill("identify.ino", note, sketch)}
    files |= board_files("identify", robot, note)
    if robot.board != "beaglebone":
        return files
    board = {x: values[x] for x in ("SECONDS", "ALONE")} | rows
    board |= {x: "{{{}, {}, {}}}".format(*sweep) for x, sweep in ends.items()}
    files |= rc_robot(robot, robot.T)
    files["rc_identify.c"] = fill("rc_identify.c", note, board)
    if wired_as_pyctrl(robot):
        signs = pyctrl_signs(robot)
        script = {x: "{}, {}, {}".format(*sweep) for x, sweep in ends.items()}
        script |= {
            "BATTERY": robot.nominal,
            "COUNTS_PER_TURN": PYCTRL_COUNTS_PER_TURN,
            "MOTOR_POLARITY": signs["motor"],
            "ENCODER_POLARITY": signs["encoder"],
        }
        files["pyctrl_identify.py"] = fill(
            "pyctrl_identify.py", note, values | rows | script
        )
    return files


def board_files(folder, robot, note):
    """The files that a sketch in a ``folder`` needs from a board, with an example's
    answers.

    The ``robot`` has the gyro's range and the motors' limit; the lines of
    the ``note`` say where they come from. It returns a dict from the files'
    names to their texts.
    """
    enough = [radians(full) > 0.99 * robot.gyro_range for full in GYRO_RANGES]
    setting = [*enough[:-1], True].index(True)
    seen = min(robot.edges, 2)  # of a period, with an interrupt on one channel
    values = {
        "COUNTS": f"{robot.counts:.12g}",
        "EDGES": robot.edges,
        "SEEN": seen,
        "SUPPLY": single(robot.limit),
        "GYRO_STEP": f"{radians(GYRO_RANGES[setting]) / 2**15:.9g}f",
        "GYRO_RANGE": f"0x{setting << 3:02X}",
    }
    return {
        f"{folder}/robot_io.h": fill("robot_io.h", note, {}),
        f"{folder}/robot_io.cpp": fill("robot_io.cpp", note, values),
    }


def write_recorders(robot, folder, replace=False, **asked):
    """Write the `recorders` into a folder.

    ``robot``: the robot's description, or the file that holds it; ``folder``: made if
    it doesn't exist; ``replace``: as for `write_texts`; ``**asked``: as for
    `recorders`. Returns list of Path: where the files stand.
    """
    robot = robot if isinstance(robot, Robot) else Robot.read(robot)
    return write_texts(folder, recorders(robot, **asked), replace)
