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

writes a row a tick into log.csv, which sosbook.mip's compare reads, and
obeys the number in speed.txt, the wheels' speed in rad/s,
and with STEERS a second one, the turn rate in rad/s, positive to the left.
A second without such a file stops the wheels.
With p before them the numbers are a place to go to: "p 30 1.57" is where the
wheels have rolled 30 rad since the start, 1.57 rad to its left.
"""

import math
import operator
import sys
import time
from functools import reduce

from pyctrl.block import BufferBlock, Filter

HALF_TICK = 0.005  # s
HERTZ = 100.0  # Hz
LIMIT = 7.4  # V
TIP = 0.85  # rad
BLEND = 0.0  # of each tick's tilt
RANGE = 100.0  # rad/s
PUSH = 1.85  # V
REACH = 1.0  # rad a tick
TRUSTED = 1000000.0  # V
RUB = 0.0  # V, of friction that is compensated
SOFT = 0.0  # V, from which on all of it is
STEEP = 0.5  # V per V below
MOST_LOST = 5  # ticks in a row
FROZEN = 0  # ticks in a row
DEAF = 0  # ticks in a row
MOST_FULL = 50  # ticks in a row
FAULTS = ("running", "sensor", "fall", "stall", "command", "late")
JITTER = 0.0005  # s, by which a tick may come late
LATE = 0  # more late ticks than others; 0: any

# u = C x + D y, then x+ = A x + B y + W (V - u)
A = [[1.0]]
B = [[0.0, 0.01, 0.0, 0.0]]
W = [[0.05]]
C = [[0.4]]
D = [[20.0, 0.8, 2.0, 0.9]]
START = [[0.0, 0.0, 0.0, 0.0]]

STEERS = True  # a heading is held; otherwise both motors get the same
TURN_RATE = 0.0  # rad/s of the heading, at most
TURN_ACCELERATION = 0.0  # rad/s^2
PER_RADIAN = 2.5  # rad right less left, per rad
# W = K [error, its rate, sum], the right motor's volts less the left's
K = [-1.0, -0.1, -0.5]
SHARE = 1.85  # V, for steering
UNWIND = -0.04  # rad s per V

TURN = 6.283185307179586  # rad
MOUNT = 0.49 / TURN  # turns, of the board in the body
BATTERY = 7.4  # V; pyctrl doesn't measure it
THEIRS = 2133.42  # of an encoder, per turn of a wheel, as pyctrl has it
COUNTS = 2122.2  # of an encoder, per turn of a wheel
WHEEL = TURN * THEIRS / COUNTS  # rad, of what pyctrl takes for a turn
MOTOR_POLARITY = (1, 1)  # left and right, times pyctrl's own
ENCODER_POLARITY = (1, 1)  # likewise
SPEED = 0.0  # rad/s, at most, of a set point that moves
ACCELERATION = 0.0  # rad/s^2, by which it moves
GENTLE = 0.3  # of these, on the way to a place: it is hardly passed
SILENCE = 1.0  # s without a command
LOGGED = "t", "gyro", "wheels", "tilt", "target", "rate", "V", "theta"
STEER_LOGGED = "left", "right", "V_left", "V_right", "heading"
REST_TICKS = round(HERTZ)  # at rest near upright so long, within
REST_TILT = 0.2  # rad
REST_GYRO = 0.1  # rad/s
REST_TURN = 0.05  # rad, of the wheels


def within(value, bound):
    """False for what is not a number."""
    return -bound <= value <= bound


def cut(value, bound):
    """The value, or the bound that it is beyond."""
    return min(max(value, -bound), bound)


def stopping(left, most, acceleration):
    """The speed from which it stops just when nothing is left."""
    way, step = abs(left), acceleration / HERTZ
    speed = math.sqrt(step * step / 4 + 2 * acceleration * way) - step / 2
    return cut(left * HERTZ, min(speed, most))


def total(*parts):
    """The sum of factor * value from the left."""
    terms = [k * x for factors, values in parts for k, x in zip(factors, values)]
    return reduce(operator.add, terms, 0.0)


class Law:
    """The law with its estimates, limits and faults."""

    def start(self, tilt, wheels, bias):
        """The robot rests; tilt, wheels in rad, bias in rad/s."""
        self.bias, self.theta, self.wheels = bias, tilt, wheels
        self.last, self.gyro, self.increment = bias, 0.0, 0.0
        self.zero = self.phi = wheels + tilt
        self.x = [total((row, (tilt, 0.0, 0.0, 0.0))) for row in START]
        self.bad = self.lost = self.same = self.still = self.full = 0
        self.volts, self.fault = 0.0, 0

    def step(self, gyro, wheels, tilt, target=0.0, rate=0.0):
        """One tick, in rad/s and rad: the volts, zero after a fault."""
        if self.fault:
            return 0.0

        # A gyro that repeats itself for long is dead.
        last, equal = gyro, self.last <= gyro <= self.last
        same = self.same + 1 if equal and FROZEN > 0 else 0

        # After a bad reading all turns on as in the tick before.
        gyro = gyro - self.bias
        seen = within(gyro, RANGE)
        turned = within(wheels - self.wheels, REACH * (self.lost + 1))
        bad = 0 if seen else self.bad + 1
        lost = 0 if turned else self.lost + 1

        # Wheels that rest under voltage: an encoder that lost its wire.
        rests = self.wheels <= wheels <= self.wheels
        pushed = not within(self.volts, PUSH)
        still = self.still + 1 if DEAF > 0 and pushed and rests else 0
        if not seen:
            gyro = self.gyro
        if not turned:
            wheels = self.wheels + self.increment

        # The gyro's integral by the trapezoidal rule, corrected slowly.
        theta = self.theta + HALF_TICK * (gyro + self.gyro)
        if within(tilt, TIP):
            theta = theta + BLEND * (tilt - theta)
        phi = wheels + theta
        y = [theta, phi - self.zero - target, gyro, (phi - self.phi) * HERTZ - rate]

        # The law and the voltage's limit.
        x = self.x
        u = total((C[0], x), (D[0], y))
        if RUB:
            u = u + (RUB if u > SOFT else -RUB if u < -SOFT else STEEP * u)
        V = cut(u, LIMIT)
        full = self.full + 1 if u > LIMIT or u < -LIMIT else 0

        dead = bad > MOST_LOST or lost > MOST_LOST or same > FROZEN
        fell, broken = not within(theta, TIP), not within(u, TRUSTED)
        reasons = [False, dead or still > DEAF, fell, full > MOST_FULL, broken]
        for fault in (1, 2, 4, 3):
            if reasons[fault]:
                self.fault = fault
                return 0.0

        self.increment = wheels - self.wheels
        self.theta, self.gyro = theta, gyro
        self.wheels, self.phi = wheels, phi
        self.last, self.same = last, same
        self.bad, self.lost, self.still = bad, lost, still
        self.full, self.volts = full, V
        self.x = [total((a, x), (b, y), (w, [V - u])) for a, b, w in zip(A, B, W)]
        return V


class Steering:
    """What holds the heading, beside the law."""

    def start(self, left, right):
        """The robot rests; the wheels' angles in rad."""
        self.turned = self.zero = right - left
        self.sum, self.lost = 0.0, 0

    def step(self, law, left, right, target=0.0, rate=0.0):
        """The volts of both motors, after the law's tick; zero after a fault."""
        if law.fault:
            return 0.0, 0.0
        V, half = law.volts, self.difference(law, right - left, target, rate) / 2
        return cut(V - half, LIMIT), cut(V + half, LIMIT)

    def difference(self, law, turned, target, rate):
        """Right less left, as far as balancing leaves them."""
        if not within(self.turned, TRUSTED):  # a start without a reading
            self.turned = self.zero = turned
        since = self.lost + 1.0
        y = [
            turned - self.zero - target,
            (turned - self.turned) * HERTZ / since - rate,
            self.sum,
        ]
        u = total((K, y))
        W = cut(u, 2 * min(LIMIT - abs(law.volts), SHARE))
        seen = within(turned - self.turned, 2 * REACH * since)
        if not (seen and within(u, TRUSTED)):
            self.lost += 1
            return 0.0
        self.sum = self.sum + 2 * HALF_TICK * y[0] + UNWIND * (W - u)
        self.turned, self.lost = turned, 0
        return W


class Balance(Filter, BufferBlock):
    """From pyctrl's turns to percent of the battery, for both motors."""

    def __init__(self, clock=time.perf_counter, **kwargs):
        super().__init__(**kwargs)
        self.law, self.clock = Law(), clock
        self.wanted, self.rows, self.logging = 0.0, [], False
        self.place = []  # the way to go, and perhaps the heading
        self.heard, self.last, self.waiting = 0.0, 0.0, ""
        self.late = self.overdue = 0
        self.steering, self.wanted_turn = Steering(), 0.0
        self.reset()

    def reset(self):
        """Wait for rest, then balance."""
        self.balancing = False
        self.rest = []

    def write(self, theta, theta_dot, encoder1, encoder2):
        tilt, gyro = TURN * (theta + MOUNT), TURN * theta_dot
        left, right = ENCODER_POLARITY
        wheels = WHEEL * (left * encoder1 + right * encoder2) / 2
        turned = WHEEL * left * encoder1, WHEEL * right * encoder2
        volts, self.motors, now = 0.0, (0.0, 0.0), self.clock()
        if self.balancing:
            self.mind(now)
            self.ramp(now)
            volts = self.law.step(gyro, wheels, tilt, self.target, self.rate)
            if STEERS:
                self.motors = self.steering.step(
                    self.law,
                    *turned,
                    PER_RADIAN * self.heading,
                    PER_RADIAN * self.turn_rate,
                )
            self.note(now, gyro, wheels, tilt, volts, self.law.fault, turned)
        elif self.at_rest(gyro, wheels, tilt):
            tilts, _, gyros = zip(*self.rest)
            self.law.start(sum(tilts) / len(tilts), wheels, sum(gyros) / len(gyros))
            self.target = self.rate = 0.0
            self.heading = self.turn_rate = 0.0
            self.steering.start(*turned)
            self.late = self.overdue = 0
            self.note(now, self.law.bias, wheels, self.law.theta, 0.0, -1, turned)
            self.balancing = True
        self.last = now
        mean, half = 100 * volts / BATTERY, 0.0
        if STEERS:
            mean, half = (
                100 * (self.motors[1] + side * self.motors[0]) / 2 / BATTERY
                for side in (1, -1)
            )
        mean = cut(mean, 100.0)
        half = cut(half, 100.0 - abs(mean))  # balance is first
        left, right = MOTOR_POLARITY
        super().write(left * (mean - half), right * (mean + half))

    def at_rest(self, gyro, wheels, tilt):
        """Whether the last second was calm, near upright."""
        first = self.rest[0][1] if self.rest else wheels
        self.waiting = (
            "hold it upright"
            if not within(tilt, REST_TILT)
            else "hold it still: the gyro turns, or its offset is large"
            if not within(gyro, REST_GYRO)
            else "hold its wheels still"
            if not within(wheels - first, REST_TURN)
            else ""
        )
        if self.waiting:
            self.rest = []
        else:
            self.rest.append((tilt, wheels, gyro))
        return len(self.rest) == REST_TICKS

    def mind(self, now):
        """A tick that comes late makes phi' wrong, and with it the law."""
        by = now - self.last - 1 / HERTZ
        if by > JITTER:
            self.late += 1
            self.overdue += 1 + int(min(by * HERTZ, HERTZ))
        elif self.overdue:
            self.overdue -= 1
        if self.overdue > LATE > 0:
            self.law.fault = FAULTS.index("late")

    def ramp(self, now):
        """Move the set points towards what is wanted; to rest without a command."""
        place = self.place
        if place or now - self.heard > SILENCE:
            self.wanted = self.wanted_turn = 0.0
        share = GENTLE if place else 1.0
        most = share * ACCELERATION, share * TURN_ACCELERATION
        if place:
            self.wanted = stopping(place[0] - self.target, SPEED, most[0])
        if len(place) > 1:
            left = place[1] - self.heading
            self.wanted_turn = stopping(left, share * TURN_RATE, most[1])
        self.rate += cut(self.wanted - self.rate, most[0] / HERTZ)
        self.target += self.rate / HERTZ
        if STEERS:
            more = self.wanted_turn - self.turn_rate
            self.turn_rate += cut(more, most[1] / HERTZ)
            self.heading += self.turn_rate / HERTZ

    def note(self, now, gyro, wheels, tilt, volts, fault, turned):
        """Remember a tick."""
        if self.logging:
            row = [now, gyro, wheels, tilt, self.target, self.rate, volts]
            row += [self.law.theta, BATTERY, fault, self.late]
            if STEERS:
                row += [*turned, *self.motors, self.heading]
            self.rows.append(row)

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
            if all(within(x, 1e6) for x in given):
                self.heard, self.place = self.clock(), given * goes
                speed, turn = [*given, 0.0, 0.0][:2]
                self.wanted = cut(speed, SPEED)
                self.wanted_turn = cut(turn, TURN_RATE)
        except (OSError, ValueError):
            pass  # no file, or one that is being written


def main():
    """Run on the robot until PAUSE, Ctrl-C or a fault."""
    import pyctrl
    from pyctrl.rc.button import Button
    from pyctrl.rc.mip import Controller

    mip, balance, pause = Controller(period=2 * HALF_TICK), Balance(), Button()
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
            if balance.balancing and balance.law.fault:
                print("motors off:", FAULTS[balance.law.fault])
                break
            if speed:
                balance.obey(speed)
            waited = 0 if balance.balancing else waited + 1
            if waited % 60 == 59 and balance.waiting:
                print("waiting:", balance.waiting)
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
