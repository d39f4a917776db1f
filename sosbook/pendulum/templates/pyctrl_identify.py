#!/usr/bin/env python3
"""Record the log of an experiment with pyctrl.

(Where this comes from.)

    python3 pyctrl_identify.py body body.csv
        the robot is held by its wheels, upside down, its body at rest
    python3 pyctrl_identify.py wheels wheels.csv
        it lies on its back, wheels in the air

The motors get a sine that sweeps up and down. In each row of the file
the sensors were read before the row's V began to act. PAUSE or Ctrl-C
ends it early; what was recorded is written.
"""

import math
import sys
import time

from pyctrl.block import BufferBlock, Filter

TURN = 6.283185307179586  # rad
HERTZ = 100.0
SECONDS = 30.0  # s, of the sweep, either way
ROWS = 6000
BODY = 1.1, 21.0, 1.85  # the sweep's ends in Hz, and the sine's amplitude in V
WHEELS = 0.3, 30.0, 5.92
ALONE = 2.0  # of that, for a motor that drives the body alone, on the sweep's way back
BATTERY = 7.4  # V; pyctrl doesn't measure it
COUNTS_PER_TURN = 2133.42  # of a wheel, as pyctrl has it
MOTOR_POLARITY = (1, 1)  # left and right, times pyctrl's own
ENCODER_POLARITY = (1, 1)  # likewise


class Record(Filter, BufferBlock):
    """The sine to the motors, the sensors to rows."""

    def __init__(self, experiment, clock=time.perf_counter, **kwargs):
        super().__init__(**kwargs)
        self.experiment, self.clock = experiment, clock
        self.rows, self.turns, self.first = [], 0.0, None

    def write(self, theta_dot, encoder1, encoder2):
        """One tick: set the motors by the chirp and keep a row of the log."""
        now = self.clock()
        volts, sides = 0.0, (1, 1)
        if len(self.rows) < ROWS:
            self.first = now if self.first is None else self.first
            t = len(self.rows) / HERTZ
            volts, alone = self.chirp(t), 0
            if self.experiment == "body" and t >= SECONDS:
                alone = 1 + int(t) % 2
                sides = (ALONE * (alone == 1), ALONE * (alone == 2))
            sensors = [f"{TURN * theta_dot:.6g}", str(alone)]
            if self.experiment == "wheels":
                sensors = [
                    str(round(sign * COUNTS_PER_TURN * angle))
                    for sign, angle in zip(ENCODER_POLARITY, (encoder1, encoder2))
                ]
            mean = volts * sum(sides) / 2
            self.rows.append([f"{now - self.first:.6f}", f"{mean:.5f}", *sensors])
        percent = 100 * volts / BATTERY
        super().write(*(x * y * percent for x, y in zip(MOTOR_POLARITY, sides)))

    def chirp(self, t):
        """The sine's next value; its frequency goes up and comes back."""
        low, high, top = BODY if self.experiment == "body" else WHEELS
        s = t if t < SECONDS else 2 * SECONDS - t
        volts = round(top * math.sin(TURN * self.turns), 5)
        self.turns = (self.turns + (low + (high - low) * s / SECONDS) / HERTZ) % 1.0
        return volts

    def save(self, path):
        names = {"body": "t,V,gyro,alone", "wheels": "t,V,encoder1,encoder2"}
        with open(path, "w", encoding="utf-8") as file:
            for row in [[names[self.experiment]], *self.rows]:
                print(",".join(row), file=file)
        print("wrote", len(self.rows), "rows of", path)


def main(words):
    """Record until the sweep's end, PAUSE or Ctrl-C."""
    if len(words) != 2 or words[0] not in ("body", "wheels"):
        sys.exit("say: pyctrl_identify.py body|wheels file.csv")
    import pyctrl
    from pyctrl.rc.button import Button
    from pyctrl.rc.mip import Controller

    mip, record, pause = Controller(period=1 / HERTZ), Record(words[0]), Button()
    mip.add_filter(
        "record", record, ["theta_dot", "encoder1", "encoder2"], ["pwm1", "pwm2"]
    )
    for encoder in ("encoder1", "encoder2"):
        mip.set_source(encoder, reset=True)
    try:
        mip.start()
        while not pause.read()[0] and len(record.rows) < ROWS:
            time.sleep(0.05)
    except KeyboardInterrupt:
        pass
    finally:
        mip.set_state(pyctrl.EXITING)
        mip.join()
        record.save(words[1])


if __name__ == "__main__":
    main(sys.argv[1:])
