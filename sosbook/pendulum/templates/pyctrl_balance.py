#!/usr/bin/env python3
"""Balance a mobile inverted pendulum with pyctrl.

(Where this comes from.)

FIRST check the signs on a stand, wheels in the air, with the stand's
program (the body's gains alone and 2 V): tip the robot forward by hand.
Both wheels must run forward, as if to catch it; otherwise stop and change
motor_polarities in the robot's description. Don't try it with a program
that balances: its wheels race.

The robot waits until it is held still near upright for a second, takes
the gyro's mean as its offset, and balances. PAUSE or Ctrl-C ends it.

    python3 pyctrl_balance.py [log.csv [speed.txt]]

compiles the law's files in C, which lie beside it, with the command cc; it
writes a row a tick into log.csv, which sosbook.pendulum's compare reads, and
obeys the number in speed.txt, the wheels' speed in rad/s,
and with STEERS a second one, the turn rate in rad/s, positive to the left.
A second without such a file stops the wheels.
With p before them the numbers are a place to go to: "p 30 1.57" is where the
wheels have rolled 30 rad since the start, 1.57 rad to its left.
"""

import ctypes
import math
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from pyctrl.block import BufferBlock, Filter

T = 0.01  # s
BALANCED = 2  # what balance_run_tick says of a tick that balances
FAULTS = ("running", "sensor", "fall", "stall", "command", "late")
STEERS = True  # a heading is held; otherwise both motors get the same

TURN = 6.283185307179586  # rad
MOUNT = 0.49 / TURN  # turns, of the board in the body
BATTERY = 7.4  # V; pyctrl doesn't measure it
THEIRS = 2133.42  # of an encoder, per turn of a wheel, as pyctrl has it
COUNTS = 2122.2  # of an encoder, per turn of a wheel
WHEEL = TURN * THEIRS / COUNTS  # rad, of what pyctrl takes for a turn
MOTOR_POLARITY = (1, 1)  # left and right, times pyctrl's own
ENCODER_POLARITY = (1, 1)  # likewise
SILENCE = 1.0  # s without a command
LOGGED = "t", "gyro", "wheels", "tilt", "target", "rate", "V", "theta"
STEER_LOGGED = "left", "right", "V_left", "V_right", "heading"


class Run(ctypes.Structure):
    """A balance_run of balance_run.h, as far as Python looks into it."""

    _fields_ = [
        *((x, ctypes.c_double) for x in ("speed", "turn", "place", "bearing")),
        *((x, ctypes.c_int) for x in ("going", "balancing")),
        ("late", ctypes.c_long),
        ("waiting", ctypes.c_char_p),
        ("volts", ctypes.c_double),
        ("motor", ctypes.c_double * 2),
        *((x, ctypes.c_double) for x in ("target", "rate", "heading", "turn_rate")),
        *((x, ctypes.c_double) for x in ("theta", "bias")),
        ("fault", ctypes.c_int),
        ("more", ctypes.c_char * 8192),
    ]


def library(*compiler):
    """The law and what is around it, compiled."""
    here = Path(__file__).resolve().parent
    parts = ["balance_run.c", "balance.c", *["balance_steer.c"] * STEERS]
    flags = ["-std=c99", "-O2", "-ffp-contract=off", "-shared", "-fPIC"]
    with tempfile.TemporaryDirectory() as folder:
        made = Path(folder, "balance.so")
        sources = [here / part for part in parts]
        subprocess.run([*compiler, *flags, *sources, "-o", made, "-lm"], check=True)
        return ctypes.CDLL(str(made))


class Balance(Filter, BufferBlock):
    """From pyctrl's turns to percent of the battery, for both motors."""

    def __init__(self, law, clock=time.perf_counter, **kwargs):
        super().__init__(**kwargs)
        real, run = ctypes.c_double, ctypes.POINTER(Run)
        self.tick, self.stop = law.balance_run_tick, law.balance_run_stop
        self.tick.argtypes = [run, *5 * [real]]
        self.stop.argtypes = [run]
        self.share = law.balance_run_volts
        self.share.argtypes = [run, real, ctypes.POINTER(real)]
        self.run, self.clock = Run(), clock
        self.rows, self.logging, self.heard, self.last = [], False, 0.0, 0.0

    def write(self, theta, theta_dot, encoder1, encoder2):
        """One tick: read the sensors, run the law, set the motors, log a row."""
        run, now = self.run, self.clock()
        tilt, gyro = TURN * (theta + MOUNT), TURN * theta_dot
        left, right = ENCODER_POLARITY
        wheel = WHEEL * left * encoder1, WHEEL * right * encoder2
        if now - self.heard > SILENCE:
            run.speed = run.turn = 0.0
        done = self.tick(run, gyro, *wheel, tilt, now - self.last)
        self.last = now
        if self.logging and done:
            seen = (
                [gyro, sum(wheel) / 2, tilt]
                if done == BALANCED
                else [run.bias, sum(wheel) / 2, run.theta]
            )
            row = [now, *seen, run.target, run.rate, run.volts, run.theta, BATTERY]
            row += [run.fault if done == BALANCED else -1, run.late]
            self.rows.append(row + [*wheel, *run.motor, run.heading] * STEERS)
        volts = (ctypes.c_double * 2)()
        self.share(run, BATTERY, volts)
        super().write(
            *(
                100 * k * v * run.balancing / BATTERY
                for k, v in zip(MOTOR_POLARITY, volts)
            )
        )

    def reset(self):
        """Wait for rest, then balance."""
        self.stop(self.run)

    def save(self, path):
        """Write the ticks."""
        with open(path, "w", encoding="utf-8") as file:
            names = *LOGGED, "battery", "fault", "late", *STEER_LOGGED * STEERS
            print(*names, sep=",", file=file)
            for row in self.rows:
                print(*row, sep=",", file=file)

    def obey(self, path):
        """Take the numbers in a file."""
        try:
            with open(path, encoding="utf-8") as file:
                words = file.read().split()
            goes = words[:1] == ["p"]
            given = [float(x) for x in words[goes:][:2]]
            first, second = [*given, 0.0][:2]
            if all(map(math.isfinite, given)):
                run, self.heard = self.run, self.clock()
                run.place, run.bearing = first, second
                run.speed, run.turn = (0.0, 0.0) if goes else (first, second)
                run.going = len(given) * goes
        except (OSError, ValueError):
            pass  # no file, or one that is being written


def main():
    """Run on the robot until PAUSE, Ctrl-C or a fault."""
    import pyctrl
    from pyctrl.rc.button import Button
    from pyctrl.rc.mip import Controller

    mip, balance, pause = Controller(period=T), Balance(library("cc")), Button()
    log, speed = [*sys.argv[1:], None, None][:2]
    balance.logging, waited = log is not None, 0
    mip.add_filter(
        "balance",
        balance,
        ["theta", "theta_dot", "encoder1", "encoder2"],
        ["pwm1", "pwm2"],
    )
    for encoder in ("encoder1", "encoder2"):
        mip.set_source(encoder, reset=True)
    print("Hold the robot upright and still; PAUSE or Ctrl-C ends.")
    try:
        mip.start()
        while not pause.read()[0]:
            run = balance.run
            if run.balancing and run.fault:
                print("motors off:", FAULTS[run.fault])
                break
            if speed:
                balance.obey(speed)
            waited = 0 if run.balancing else waited + 1
            if waited % 60 == 59 and run.waiting:
                print("waiting:", run.waiting.decode())
            time.sleep(0.05)
    except KeyboardInterrupt:
        pass
    finally:
        mip.set_state(pyctrl.EXITING)
        mip.join()
        if log:
            balance.save(log)


if __name__ == "__main__":
    main()
