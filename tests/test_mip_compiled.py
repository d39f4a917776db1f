"""The compiled C program against `Controller`: every bit of every tick."""

import os
import sys
import tempfile
from functools import cache

import control
import numpy as np
import pytest

from sosbook.book import thesis
from sosbook.controllers import compiler as module
from sosbook.pendulum import FAULTS, Firmware, Mip, SampledLaw
from sosbook.pendulum.compiled import FLAGS, Compiled, compiler
from sosbook.pendulum.firmware import COUNTERS, NUMBERS
from sosbook.pendulum.simulator import Sensors, simulate
from tests.cases import by_turns, later
from tests.compiler import find, refuse
from tests.gains import named

T = 0.01
PRINTED = thesis.mip()
ROBUST = [[15.78, 0.49, 1.42, 0.69, 0.22]]
BLEND = 0.01
KINDS = {"double": float, "single": np.float32}


def observer():
    """(4.30), which is for u = -H y."""
    A, B, C, D = map(np.atleast_2d, PRINTED.discrete)
    return SampledLaw.of_controller(control.ss(A, B, -C, -D, T), T)


LAWS = {
    "PD": SampledLaw.of_gain(named(PRINTED.pd[5]), T),
    "PID": SampledLaw.of_gain(named(ROBUST), T),
    "Appendix B": SampledLaw.appendix_b(named(ROBUST), T),
    "(4.30)": observer(),
}


@pytest.fixture(scope="module", autouse=True)
def a_compiler():
    """Skipped where there is none, failed in CI."""
    if find() is None:
        refuse()


@cache
def program(name, precision="double", **numbers):
    """A law's compiled firmware, with these numbers of `Firmware`."""
    return Compiled(Firmware(LAWS[name], **numbers), precision)


def bits(value, kind=float):
    """Bytes of an array; -0.0 isn't 0.0."""
    return np.asarray(value, kind).tobytes()


class Twins:
    """Python and C side by side; each step compares all bits."""

    def __init__(self, python, c):
        self.python, self.c = python, c

    @classmethod
    def of(cls, name, precision="double", **numbers):
        c = program(name, precision, **numbers)
        return cls(c.firmware.controller(kind=KINDS[precision]), c)

    def start(self, *values, **named):
        self.python.start(*values, **named)
        self.c.start(*values, **named)
        self.compare()

    def step(self, *values, **named):
        with np.errstate(all="ignore"):
            V = self.python.step(*values, **named)
        assert bits(V, V.dtype) == bits(self.c.step(*values, **named), V.dtype)
        self.compare()
        return float(V[0])

    def compare(self):
        """All that both remember."""
        (state,), kind = self.c.states, self.python.kind
        numbers = [getattr(state, name) for name in NUMBERS]
        ours = np.array([getattr(self.python, name)[0] for name in NUMBERS])
        same(numbers, ours, kind)
        if self.python.x:
            same(state.x[:], [float(np.ravel(x)[0]) for x in self.python.x], kind)
        for name in (*COUNTERS, "fault"):
            assert getattr(state, name) == getattr(self.python, name)[0]

    @property
    def fault(self):
        return int(self.c.fault[0])


def same(one, other, kind):
    """The same bits, but for the sign of what isn't a number."""
    one, other = (
        np.where(np.isnan(x), np.nan, x).astype(kind)
        for x in map(np.asarray, (one, other))
    )
    assert one.tobytes() == other.tobytes()


@pytest.mark.parametrize("precision", KINDS)
@pytest.mark.parametrize("name", by_turns(LAWS, 0))
def test_the_simulator_cannot_tell_them_apart(name, precision):
    """Four seconds in the loop, against noise, are the same to the last bit."""
    c = program(name, precision, blend=BLEND)
    python = c.firmware.controller(kind=KINDS[precision])
    sensors = Sensors(accelerometer=0.05)
    asked = dict(tilt=0.1, t_end=4.0, sensors=sensors, substeps=2)
    runs = [simulate(Mip.printed(), controller, **asked) for controller in (python, c)]
    for what in ("x", "V", "estimate"):
        assert bits(getattr(runs[0], what)) == bits(getattr(runs[1], what))
    assert not runs[0].fell[0] and np.ptp(runs[0].V[0, -200:]) > 0.01


def test_robots_side_by_side():
    firmware = Firmware(LAWS["PID"])
    python = firmware.controller(runs=3)
    c = Compiled(firmware, runs=3)
    assert c.fault is None and c.theta is None
    for controller in (python, c):
        controller.start([0.1, 0.2, np.nan], wheels=[1, 2, 3])
    gyro, wheels = np.array([0, 0.5, 0]), np.array([1, 2.2, 3])
    for _ in range(3):
        assert bits(python.step(gyro, wheels)) == bits(c.step(gyro, wheels))
    assert c.fault.tolist() == [0, 0, FAULTS.index("fall")] == python.fault.tolist()
    assert bits(c.theta[:2]) == bits(python.theta[:2])


def test_what_is_compiled_leaves_no_folder_behind(monkeypatch, tmp_path):
    """A process that is killed, as tests' workers are, left one for each program."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    program = Compiled(Firmware(LAWS["PD"]))
    with pytest.raises(RuntimeError, match="breaks the checks"):
        Compiled(Firmware(LAWS["PD"]), flags=[*FLAGS, "-ffast-math"])
    assert os.name == "nt" or not list(tmp_path.iterdir())
    program.start(tilt=0.1)
    assert program.step(0.0, 0.0)


def test_a_step_before_the_start_is_refused():
    with pytest.raises(ValueError, match="call start"):
        Compiled(Firmware(LAWS["PD"])).step(0.0, 0.0)


#: Numbers of a firmware whose faults come soon. What each is for is stated in
#: test_mip_constants.
TOUCHY = dict(
    limit=2.0, stall=7, frozen=3, fastest=10.0, deaf=6, missing=3, gyro_range=17.0
)
ODD = [np.nan, np.inf, -np.inf, 1e300, 50.0, 0.02, 0.02, -0.0, 0.0, 17.4, 5.0, 5e-324]


@pytest.mark.parametrize(
    "name, precision",
    [
        *(("PID", "single"), ("(4.30)", "double")),
        *later(("PID", "double"), ("(4.30)", "single")),
    ],
)
def test_what_goes_wrong_goes_the_same_way(name, precision):
    """A fault lasts until the start, after which all is as at the first time."""
    random, faults = np.random.default_rng(1), set()
    rubs = 0.0 if name == "(4.30)" else 0.3
    twins = Twins.of(name, precision, blend=BLEND, compensation=rubs, **TOUCHY)
    for start in range(60):
        rows = random.normal(0, [0.01, 0.005, 0.05, 0.1, 0.1], (40, 5))
        rows[:, 1] = np.cumsum(rows[:, 1])
        odd = random.random(rows.shape) < [0.0, 0.05, 0.3][start % 3]
        odd[:, 3:] &= start % 5 == 0
        rows[odd] = random.choice(ODD, odd.sum())
        rows[20:, start % 2] = rows[20, start % 2]  # one that repeats itself
        tilt, told = random.choice([0.0, -0.0, 0.05, 0.2, -0.6, 0.84, -0.86]), []
        for _ in range(2):
            twins.start(tilt=tilt)
            told.append([twins.step(*row) for row in rows])
        assert told[0] == told[1]
        assert not twins.fault or told[0][-1] == 0
        faults.add(FAULTS[twins.fault])
    assert faults == {"running", "sensor", "stall", "fall", "command"}


@pytest.mark.parametrize("seed", range(3))
def test_random_laws_of_any_order(seed):
    """Full matrices with zeros strewn in, windup's among them."""
    random = np.random.default_rng(seed)
    N = 2 + seed

    def some(*shape):
        return random.normal(0, 0.4, shape) * (random.random(shape) < 0.7)

    parts = some(N, N), some(N, 4), some(1, N), some(1, 4) + 0.1
    law = SampledLaw(*parts, 0.02, W=some(N, 1), start=some(N))
    firmware = Firmware(law, limit=0.05, blend=0.3, stall=10**4)
    for precision in KINDS:
        c = Compiled(firmware, precision)
        twins = Twins(firmware.controller(kind=KINDS[precision]), c)
        twins.start(*random.normal(0, 0.05, 3))
        for _ in range(100):
            twins.step(*random.normal(0, 0.05, 5))
        assert twins.fault == 0


def test_the_compiler_is_cc_or_one_on_the_path_or_zig(monkeypatch, tmp_path):
    monkeypatch.setenv("CC", f"'{sys.executable}' -O2")
    assert compiler() == [sys.executable, "-O2"]
    monkeypatch.setenv("CC", "no-such-compiler")
    with pytest.raises(RuntimeError, match="CC is set to 'no-such-compiler'"):
        compiler()
    monkeypatch.delenv("CC")
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr(module.importlib.util, "find_spec", lambda name: 1)
    assert compiler() == [sys.executable, "-m", "ziglang", "cc"]
    monkeypatch.setattr(module.importlib.util, "find_spec", lambda name: None)
    with pytest.raises(RuntimeError, match="apt-get install gcc"):
        compiler()
    gcc = tmp_path / "gcc"
    gcc.touch(mode=0o755)
    assert compiler() == [str(gcc)]
