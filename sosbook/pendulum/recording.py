"""Programs that record the logs of the two experiments.

They come before any fit, so they take nothing but the robot's description.
"""

from math import pi, radians, sqrt

from ..plants.checks import positive
from ..runtime.reading import path_of
from ..runtime.writing import may_replace, write_file
from .boards import (
    PYCTRL_COUNTS_PER_TURN,
    dmp_rate,
    pins,
    pyctrl_signs,
    wired,
    wired_as_pyctrl,
)
from .robot import Robot
from .template import comment, fill, python_comment, written_by

__all__ = ["BAUD", "board_files", "recorders", "sweeps", "write_recorders"]

BAUD = 500000  # an AVR of 16 MHz and an ESP32 have it exactly
AMPLITUDE_SHARE = 0.25  # of the limit: the thesis's 1.85 V of 7.4 V
SWEEP_SECONDS = 30.0  # either way, as in the thesis
INERTIA_GUESS = 1.4  # of the body about the axle, over M_b l^2
BODY_SWEEP = 0.5, 10.0  # times the frequency at which the body swings
WHEELS_FIRST = 0.3  # Hz, as in the thesis
HIGHEST_SHARE = 0.3  # of the sampling rate, the sweep's highest frequency
GYRO_RANGES = 250, 500, 1000, 2000  # deg/s, of the MPU-6050's four settings


def sweeps(robot):
    """The frequencies between which the two sines sweep.

    Parameters
    ----------
    robot : Robot
        Its l and g say about how fast its body swings, its T which
        frequencies the samples can show.

    Returns
    -------
    dict
        Two frequencies in Hz for "body" and for "wheels".

    Examples
    --------
    >>> {name: [round(x, 1) for x in ends]
    ...  for name, ends in sweeps(Robot.shipped("thesis")).items()}
    {'body': [1.1, 21.1], 'wheels': [0.3, 30.0]}
    """
    swing = sqrt(robot.g / robot.l / INERTIA_GUESS) / (2 * pi)
    highest = HIGHEST_SHARE / robot.T
    low, high = BODY_SWEEP
    return {
        "body": (low * swing, min(high * swing, highest)),
        "wheels": (WHEELS_FIRST, highest),
    }


def recorders(robot, amplitude=None, seconds=SWEEP_SECONDS):
    """The programs that record the logs, for every board that has one.

    Parameters
    ----------
    robot : Robot
        Its clock, limit, board and channels.
    amplitude : float, optional
        The sines' amplitude, in V; a quarter of the limit without it.
    seconds : float
        How long a sweep takes, either way, in s.

    Returns
    -------
    dict
        From the files' names to their texts: a sketch for Arduino, with
        what it asks of a board; for a BeagleBone Blue also programs for
        librobotcontrol and, where its channels are pyctrl's, for pyctrl.

    Raises
    ------
    ValueError
        If a number isn't positive, or the amplitude is above the limit.

    Examples
    --------
    >>> list(recorders(Robot.shipped("gearmotors")))[0]
    'identify/identify.ino'
    >>> "rc_identify.c" in recorders(Robot.shipped("thesis"))
    True
    """
    amplitude = AMPLITUDE_SHARE * robot.limit if amplitude is None else amplitude
    if positive("amplitude", amplitude) > robot.limit:
        raise ValueError(
            f"amplitude must be at most limit = {robot.limit:g} V, got {amplitude!r}"
        )
    note = [
        written_by(),
        f"robot: {robot.words}",
        f"sweep: {amplitude:g} V for {seconds:g} s either way",
    ]
    values = {
        "note": comment(note, " * "),
        "hertz": f"{1 / robot.T:.12g}",
        "amplitude": repr(float(amplitude)),
        "seconds": repr(float(positive("seconds", seconds))),
        "rows": round(2 * seconds / robot.T),
    } | {
        name: ", ".join(repr(float(f"{x:.6g}")) for x in ends)
        for name, ends in sweeps(robot).items()
    }
    single = {
        word: f"{float(values[word])!r}f" for word in ("hertz", "amplitude", "seconds")
    }
    single |= {x: values[x].replace(", ", "f, ") + "f" for x in ("body", "wheels")}
    sketch = values | single | {"micros": f"{round(1e6 * robot.T)}UL", "baud": BAUD}
    files = {"identify/identify.ino": fill("identify.ino", sketch)}
    files |= board_files("identify", robot, note)
    if robot.board != "beaglebone":
        return files
    robot, (low, high) = wired(robot), robot.battery
    board = {"nominal": repr(robot.nominal)}
    files["rc_identify.c"] = fill(
        "rc_identify.c", values | board | pins(robot), low=repr(low), high=repr(high)
    ).replace(f"RATE_HZ {values['hertz']}", f"RATE_HZ {dmp_rate(robot.T)}")
    if wired_as_pyctrl(robot):
        files["pyctrl_identify.py"] = fill(
            "pyctrl_identify.txt",
            values | board | {"note": python_comment(note)},
            theirs=repr(PYCTRL_COUNTS_PER_TURN),
            **pyctrl_signs(robot),
        )
    return files


def board_files(folder, robot, note):
    """What a sketch in a ``folder`` asks of a board, with an example's answers.

    The ``robot`` has the gyro's range and the motors' limit; the lines of
    the ``note`` say where they come from. It returns a dict from the files'
    names to their texts.
    """
    setting = next(
        (
            k
            for k, full in enumerate(GYRO_RANGES)
            if radians(full) > 0.99 * robot.gyro_range
        ),
        len(GYRO_RANGES) - 1,
    )
    seen = min(robot.edges, 2)  # of a period, with an interrupt on one channel
    values = {
        "note": comment(note, " * "),
        "counts": f"{robot.counts:.12g}",
        "edges": robot.edges,
        "seen": seen,
        "worth": robot.edges // seen,
        "mode": "CHANGE" if seen == 2 else "RISING",
        "limit": f"{robot.limit!r}f",
        "gyro_step": f"{radians(GYRO_RANGES[setting]) / 2**15:.9g}f",
        "gyro_bits": f"0x{setting << 3:02X}",
    }
    return {
        f"{folder}/robot_io.h": fill("robot_io.h", {}),
        f"{folder}/robot_io.cpp": fill("robot_io.cpp", values),
    }


def write_recorders(robot, folder, replace=False, **asked):
    """Write the `recorders` into a folder.

    Parameters
    ----------
    robot : Robot or path_like
        The robot's description, or the file that holds it.
    folder : str or Path
        Made if it doesn't exist.
    replace : bool
        As for `write_texts`.
    **asked
        As for `recorders`.

    Returns
    -------
    list of Path
        Where the files stand.
    """
    robot = robot if isinstance(robot, Robot) else Robot.read(robot)
    return write_texts(folder, recorders(robot, **asked), replace)


def write_texts(folder, texts, replace=False):
    """Write files into a folder: all of them, or none.

    Parameters
    ----------
    folder : str or Path
        Made if it doesn't exist.
    texts : dict
        From the files' names to their texts.
    replace : bool
        Replace files that are there with another text. Else they stop everything: a
        ``robot_io.cpp``, for example, may hold its owner's pins.

    Returns
    -------
    list of Path
        Where the files stand.

    Raises
    ------
    FileExistsError
        If a file is there that may not be replaced.
    """
    files = {path_of(folder) / name: text.encode() for name, text in texts.items()}
    for path, text in files.items():
        if not replace:
            may_replace(
                path,
                lambda old, text=text: old == text,
                "give another folder, or --replace (replace=True)",
            )
    for path in files:
        path.parent.mkdir(parents=True, exist_ok=True)
    return [write_file(path, text) for path, text in files.items()]
