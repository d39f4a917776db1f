"""Hardware in the loop: a board computes, the robot is simulated.

The board runs the generated serial_<name>.c, and this computer is its
robot, line by line over a serial port.
"""

import os
import select

import numpy as np

from .firmware import Firmware

__all__ = ["Board"]

LONGEST_WAIT = 2.0  # s, for an answer


class Board:
    """A board behind a serial port, in place of a `Controller`.

    `simulate` takes it as its controller, for one robot.

    Parameters
    ----------
    port : str or int
        The port's path, such as /dev/ttyACM0, or an open file's number.
    firmware : Firmware
        What the board was compiled from: its T and its limit.
    baud : int
        The port's speed.

    Raises
    ------
    ValueError
        If ``firmware`` isn't one, or the port can't have this speed.
    TimeoutError
        If the board doesn't answer; also later, at each tick.

    Examples
    --------
    >>> board = Board("/dev/ttyACM0", firmware)                # doctest: +SKIP
    >>> run = simulate(mip, board, tilt=0.1, t_end=10.0)       # doctest: +SKIP
    """

    def __init__(self, port, firmware, baud=115200):
        if not isinstance(firmware, Firmware):
            raise ValueError("firmware must be a Firmware")
        self.firmware, self.runs, self.fault = firmware, 1, np.zeros(1, int)
        self.owned = not isinstance(port, int)
        self.port = os.open(port, os.O_RDWR | os.O_NOCTTY) if self.owned else port
        self.rest = b""
        try:
            if self.owned:
                _set_raw(self.port, baud)
        except ValueError:
            self.close()
            raise

    def close(self):
        """Close the port, if this object has opened it."""
        if self.owned:
            os.close(self.port)

    def start(self, tilt, wheels=0.0, bias=0.0):
        """As `Controller.start`, with one tilt, angle of the wheels and bias."""
        self._ask("s", tilt, wheels, bias)

    def step(self, gyro, wheels, tilt=np.nan, target=0.0, rate=0.0):
        """As `Controller.step`: gyro, wheels, tilt, target and its rate."""
        return np.array([self._ask("t", gyro, wheels, tilt, target, rate)])

    def _ask(self, letter, *values):
        """Send a line; the volts of the answer."""
        numbers = " ".join(repr(float(np.ravel(v)[0])) for v in values)
        os.write(self.port, f"{letter} {numbers}\n".encode())
        while b"\n" not in self.rest:
            ready, _, _ = select.select([self.port], [], [], LONGEST_WAIT)
            if not ready:
                raise TimeoutError(
                    f"the board didn't answer within {LONGEST_WAIT:g} s: is "
                    "serial_<name>.c on it, and is this its port and speed?"
                )
            self.rest += os.read(self.port, 4096)
        line, self.rest = self.rest.split(b"\n", 1)
        try:
            volts, fault = line.split()
            self.fault = np.array([int(fault)])
            return float(volts)
        except ValueError:
            raise ValueError(
                f"the board answered {line!r} and not volts and a fault: is "
                "serial_<name>.c on it, and does its port echo?"
            ) from None


def _set_raw(port, baud):
    """No echo, no letters changed, this speed."""
    import termios
    import tty

    speed = getattr(termios, f"B{baud}", None)
    if speed is None:
        raise ValueError(f"baud must be a speed of serial ports, got {baud!r}")
    tty.setraw(port)
    settings = termios.tcgetattr(port)
    settings[4] = settings[5] = speed
    termios.tcsetattr(port, termios.TCSANOW, settings)
