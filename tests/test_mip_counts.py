"""Every sketch takes a turn of a wheel for a turn, as each program by its numbers.

An encoder of 374 periods a turn of a wheel; what a description calls its counts
depends on how many edges of a period they are.
"""

import re

import numpy as np
import pytest

from sosbook.pendulum import Firmware, Robot, SampledLaw
from sosbook.pendulum.export import Program
from sosbook.pendulum.recording import recorders
from tests import test_mip_recording as recording
from tests.compiler import run
from tests.gains import named

cpp = recording.cpp
PERIODS, TURNS = 374, 3
LAW = SampledLaw.of_gain(named([[20, 0.8, 2, 0.9, 0.4]]), 0.01)
#: Two wheels that roll forward by so many periods, edge by edge. With its
#: channels swapped an encoder would count down.
WHEELS = """
#include "Arduino.h"
#include "Wire.h"
#include "robot_io.h"
static int level[16], mode[16];
static void (*handler[16])(void);
Bus Wire;
void Bus::begin(void) {} void Bus::setClock(uint32_t) {}
void Bus::beginTransmission(uint8_t) {}
uint8_t Bus::write(uint8_t) { return 1; }
uint8_t Bus::endTransmission(bool) { return 0; }
uint8_t Bus::requestFrom(uint8_t, uint8_t count) { return count; }
int Bus::read(void) { return 0; }
void digitalWrite(uint8_t, uint8_t) {} void analogWrite(uint8_t, int) {}
void pinMode(uint8_t, uint8_t) {} void interrupts(void) {} void noInterrupts(void) {}
int digitalRead(uint8_t pin) { return level[pin]; }
int digitalPinToInterrupt(int pin) { return pin == 2 || pin == 3 ? pin - 2 : -1; }
void attachInterrupt(int number, void (*func)(void), int how)
{ if (number >= 0) { handler[number + 2] = func; mode[number + 2] = how; } }
static void set(int pin, int to)
{
    level[pin] = to;
    if (handler[pin] && (mode[pin] == CHANGE || (mode[pin] == RISING && to)))
        handler[pin]();
}
int main(int argc, char **argv)
{
    if (argc < 2 || !io_begin())
        return 1;
    const int left[2] = {4, 2}, right[2] = {3, 5}; /* which channel is first */
    for (long k = 0; k < atol(argv[1]); k++)
        for (int to = 1; to >= 0; to--)
            for (int one = 0; one < 2; one++) {
                set(left[one], to);
                set(right[one], to);
            }
    printf("%ld %ld\\n", io_encoder(0), io_encoder(1));
    return 0;
}
"""


@pytest.mark.parametrize("edges", [4, 2, 1])
def test_a_sketch_counts_as_the_description_does(edges, cpp, tmp_path):
    robot = Robot.shipped("gearmotors").but(counts=float(PERIODS * edges), edges=edges)
    texts, more = Program(Firmware(LAW), robot=robot).sketch, recorders(robot)
    for name in ("robot_io.h", "robot_io.cpp"):
        text = texts[f"balance_sketch/{name}"]
        (tmp_path / name).write_text(text, "utf-8")
        assert text.split("*/", 1)[1] == more[f"identify/{name}"].split("*/", 1)[1]
    (tmp_path / "wheels.cpp").write_text(WHEELS, "utf-8")
    flags = recording.sketch_flags(tmp_path)
    program, sources = tmp_path / "a", [tmp_path / "robot_io.cpp"]
    run(*cpp, *flags, *sources, tmp_path / "wheels.cpp", "-o", program)
    counted = list(map(int, run(program, str(TURNS * PERIODS)).split()))
    assert counted == 2 * [TURNS * robot.counts]
    code = texts["balance_sketch/balance_sketch.ino"]
    one = eval(re.search(r"TURN = ([\d.]+f / [\d.]+)f", code)[1].replace("f", ""))
    assert counted[0] * one == pytest.approx(2 * np.pi * TURNS)
