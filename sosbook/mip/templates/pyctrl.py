#!/usr/bin/env python3
"""Balance a mobile inverted pendulum with pyctrl.

$note

FIRST check the signs on a stand, wheels in the air: tip the robot
forward by hand while this runs. Both wheels must run forward, as if to
catch it; otherwise stop and change POLARITY.

The robot waits until it is held still near upright for a second, takes
the gyro's mean as its offset, and balances. PAUSE or Ctrl-C ends it.
"""

import time

from pyctrl.block import BufferBlock, Filter

$constants
FAULTS = $faults

# u = C x + D y, then x+ = A x + B y + W (V - u)
$matrices

MOUNT = 0.07  # turns, of the board in the body
BATTERY = 7.4  # V; pyctrl doesn't measure it
POLARITY = 1  # of both motors
TURN = 6.283185307179586  # rad
REST_TICKS = round(HERTZ)  # at rest near upright so long, within
REST_TILT = 0.2  # rad
REST_GYRO = 0.1  # rad/s
REST_TURN = 0.05  # rad, of the wheels


def within(value, bound):
    """False for what is not a number."""
    return -bound <= value <= bound


class Law:
    """The law with its estimates, limits and faults."""

    def start(self, tilt, wheels, bias):
        """The robot rests; tilt, wheels in rad, bias in rad/s."""
        self.bias, self.theta, self.wheels = bias, tilt, wheels
        self.gyro = self.increment = 0.0
        self.zero = self.phi = wheels + tilt
        self.x = [$start]
        self.bad = self.full = self.fault = 0

    def step(self, gyro, wheels, tilt, target=0.0, rate=0.0):
        """One tick, in rad/s and rad: the volts, zero after a fault."""
        if self.fault:
            return 0.0

        # After a bad reading all turns on as in the tick before.
        gyro = gyro - self.bias
        seen = within(gyro, FASTEST)
        turned = within(wheels - self.wheels, REACH * (self.bad + 1))
        bad = 0 if seen and turned else self.bad + 1
        if not seen:
            gyro = self.gyro
        if not turned:
            wheels = self.wheels + self.increment

        # The gyro's integral by the trapezoidal rule, corrected slowly.
        theta = self.theta + HALF_TICK * (gyro + self.gyro)
        if within(tilt, TIP):
            theta = theta + BLEND * (tilt - theta)
        phi = wheels + theta
        y = [theta, phi - self.zero - target, gyro,
             (phi - self.phi) * HERTZ - rate]

        # The law and the voltage's limit.
        x = self.x
        u = (
            $output
        )
        V = LIMIT if u > LIMIT else -LIMIT if u < -LIMIT else u
        full = self.full + 1 if u > LIMIT or u < -LIMIT else 0

        reasons = [False, bad > MISSING, not within(theta, TIP),
                   full > STALL, not within(u, TRUSTED)]
        for fault in (1, 2, 4, 3):
            if reasons[fault]:
                self.fault = fault
                return 0.0

        self.increment = wheels - self.wheels
        self.theta, self.gyro = theta, gyro
        self.wheels, self.phi = wheels, phi
        self.bad, self.full = bad, full
        self.x = [$next]
        return V


class Balance(Filter, BufferBlock):
    """From pyctrl's turns to percent of the battery, for both motors."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.law = Law()
        self.reset()

    def reset(self):
        """Wait for rest, then balance."""
        self.balancing = False
        self.rest = []

    def write(self, theta, theta_dot, encoder1, encoder2):
        tilt, gyro = TURN * (theta + MOUNT), TURN * theta_dot
        wheels = TURN * (encoder1 + encoder2) / 2
        volts = 0.0
        if self.balancing:
            volts = self.law.step(gyro, wheels, tilt)
        elif self.at_rest(gyro, wheels, tilt):
            tilts, _, gyros = zip(*self.rest)
            self.law.start(sum(tilts) / len(tilts), wheels,
                           sum(gyros) / len(gyros))
            self.balancing = True
        percent = 100 * POLARITY * volts / BATTERY
        percent = 100.0 if percent > 100 else max(percent, -100.0)
        super().write(percent, percent)

    def at_rest(self, gyro, wheels, tilt):
        """Whether the last second was calm, near upright."""
        first = self.rest[0][1] if self.rest else wheels
        if (within(tilt, REST_TILT) and within(gyro, REST_GYRO)
                and within(wheels - first, REST_TURN)):
            self.rest.append((tilt, wheels, gyro))
        else:
            self.rest = []
        return len(self.rest) == REST_TICKS


def main():
    """Run on the robot until PAUSE, Ctrl-C or a fault."""
    import pyctrl
    from pyctrl.rc.button import Button
    from pyctrl.rc.mip import Controller

    mip, balance, pause = Controller(period=$T), Balance(), Button()
    mip.add_filter("balance", balance,
                   ["theta", "theta_dot", "encoder1", "encoder2"],
                   ["pwm1", "pwm2"])
    for encoder in ("encoder1", "encoder2"):
        mip.set_source(encoder, reset=True)
    print("Hold the robot upright and still; PAUSE or Ctrl-C ends.")
    try:
        mip.start()
        while not pause.read()[0]:
            if balance.balancing and balance.law.fault:
                print("motors off:", FAULTS[balance.law.fault])
                break
            time.sleep(0.05)
    except KeyboardInterrupt:
        pass
    finally:
        mip.set_state(pyctrl.EXITING)
        mip.join()


if __name__ == "__main__":
    main()
