"""The programs that record the two logs, on a simulated robot of their own."""

import contextlib
import re
import shutil
import subprocess

import numpy as np
import pytest

import tests.test_mip_export as programs
from sosbook.pendulum import Robot
from sosbook.pendulum.command import main
from sosbook.pendulum.compiled import FLAGS
from sosbook.pendulum.gate import Inspection
from sosbook.pendulum.identify import identify
from sosbook.pendulum.log import Log
from sosbook.pendulum.recorded import check_recording
from sosbook.pendulum.recording import recorders, sweeps, write_recorders
from sosbook.pendulum.rig import DATA
from tests.compiler import run
from tests.corrupted import SPOILT
from tests.processes import process
from tests.six_robots import SIX, advance, wired
from tests.test_mip_robot import THESIS, text

MACHINE = SIX[0]
WIRED = wired(MACHINE)
SECONDS = 6.0
LOGS = "body", "wheels"


class Bench:
    """A machine in an experiment: what its sensors read, volts in."""

    def __init__(self, machine, experiment):
        self.machine, self.x = machine, np.zeros(2)
        self.body = experiment == "body"
        self.rate = machine.hanging if self.body else machine.spinning

    @property
    def gyro(self):
        return float(self.x[1]) + 0.004 if self.body else 0.0

    @property
    def counts(self):
        angle = -self.x[0] if self.body else self.x[0]
        return int(np.floor(angle * self.machine.counts / (2 * np.pi) + 0.4))

    def turn(self, volts, time):
        self.x = advance(self.rate, self.x, volts, time, 6)


def good(folder, robot):
    """Both logs of a folder identify the machine."""
    paths = [folder / f"{name}.csv" for name in ("body", "wheels")]
    for path in paths:
        recording = check_recording(path, robot)
        assert recording.usable, recording.report
    found = identify(*map(Log.read, paths), **robot.identification)
    assert found.ratios == pytest.approx(MACHINE.truth, rel=0.01)
    return Log.read(paths[0]), Log.read(paths[1])


# librobotcontrol: each line of input is a tick, each line of output its
# duties; time goes on by 10.3 ms, a little slower than asked.
STUB = (
    programs.STUB[: programs.STUB.index("void rc_usleep")]
    + """\
void rc_usleep(unsigned int us)
{
    (void)us;
    double rate;
    char word;
    if (scanf(" %c %lf %d %d", &word, &rate, encoder + 3, encoder + 2) != 4) {
        state = EXITING;
        return;
    }
    now += 10300000;
    imu->gyro[0] = rate;
    if (word == 't')
        callback();
    printf("%.17g %.17g\\n", duty[3], duty[2]);
    fflush(stdout);
}
"""
)


@pytest.fixture(scope="module")
def rc_identify(gcc, tmp_path_factory):
    folder = tmp_path_factory.mktemp("rc")
    write_recorders(WIRED, folder, seconds=SECONDS)
    (folder / "robotcontrol.h").write_text(programs.HEADER, "utf-8")
    (folder / "stub.c").write_text(STUB, "utf-8")
    flags = [*FLAGS, *programs.STRICT, "-I", folder]
    run(*gcc, *flags, "-c", folder / "rc_identify.c", "-o", folder / "rc_identify.o")
    files = folder / "stub.c", folder / "rc_identify.o"
    run(*gcc, "-std=c99", *files, "-lm", "-o", folder / "rc_identify")
    return folder / "rc_identify"


def live(program, experiment, path, machine=MACHINE, ticks=2000, word="t"):
    """Run it on a bench; the last line that it says."""
    bench = Bench(machine, experiment)
    pipe = dict(stdin=subprocess.PIPE, text=True, encoding="utf-8")
    words = [str(program), experiment, str(path)]
    with subprocess.Popen(words, stdout=subprocess.PIPE, **pipe) as process:
        for _ in range(ticks):
            degrees, n = float(np.rad2deg(bench.gyro)), bench.counts
            if process.poll() is not None:
                break
            try:
                process.stdin.write(f"{word} {degrees!r} {n} {-n}\n")
                process.stdin.flush()
            except BrokenPipeError:
                break
            line = process.stdout.readline()
            if len(line.split()) != 2:
                break
            left, right = map(float, line.split())
            bench.turn(8.0 * (left - right) / 2, 0.0103)  # the right one's polarity
        with contextlib.suppress(BrokenPipeError):  # what it didn't wait for
            process.stdin.close()
        return line + process.stdout.read()


@pytest.mark.slow
def test_librobotcontrols_recorder_records_what_identifies(rc_identify, tmp_path):
    for experiment in ("body", "wheels"):
        said = live(rc_identify, experiment, tmp_path / f"{experiment}.csv")
        assert "end 1 1 0 0" in said and "wrote 1200 rows" in said
    body, wheels = good(tmp_path, WIRED)
    assert body.T == pytest.approx(0.0103)
    assert abs(body.V).max() == pytest.approx(1.85, rel=0.01)
    assert abs(wheels.V).max() == pytest.approx(5.92, rel=0.01)


def test_a_silent_imu_ends_the_recorder_and_keeps_its_rows(rc_identify, tmp_path):
    said = live(rc_identify, "body", tmp_path / "body.csv", word="s")
    assert "end 1 1 0 0" in said and "wrote 0 rows" in said
    done = process(rc_identify)
    assert done.returncode and "body|wheels" in done.stderr


# pyctrl


@pytest.mark.slow
@pytest.mark.usefixtures("fake_pyctrl")
@pytest.mark.parametrize("acts", [True, False])
def test_pyctrls_recorder_records_what_identifies(acts, tmp_path):
    """A left motor that doesn't act halves e/c and f/c, which no shape tells."""
    both = []
    space = {"__name__": "script"}
    exec(recorders(WIRED, seconds=SECONDS)["pyctrl_identify.py"], space)
    turn, theirs = 2 * np.pi, 60 * 35.557
    for experiment in LOGS:
        bench, now = Bench(MACHINE, experiment), 5.0
        record = space["Record"](experiment, clock=lambda: now)
        while len(record.rows) < space["ROWS"]:
            count = bench.counts / theirs
            record.write(bench.gyro / turn, count, count)
            left, right = record.buffer
            both.append(left == right)
            bench.turn(7.4 * (acts * left + right) / 200, 0.01)
            now += 0.01
        record.write(0.0, 0.0, 0.0)
        assert record.buffer == (0.0, 0.0)
        record.save(tmp_path / f"{experiment}.csv")
    assert np.mean(both) == pytest.approx(0.75, abs=0.02)  # the rest of the body's log
    if acts:
        good(tmp_path, WIRED)
        return
    seen = Inspection.of(*(Log.read(tmp_path / f"{x}.csv") for x in LOGS), WIRED)
    assert re.search("alone, the left motor moves the body .* dead", seen.refusal)


# A sketch: the board is a pipe

ARDUINO = """\
#include <stdlib.h>
#include <stdint.h>
#include <stdio.h>
#include <math.h>
#define HIGH 1
#define LOW 0
#define INPUT_PULLUP 2
#define OUTPUT 1
#define CHANGE 1
#define RISING 3
int digitalRead(uint8_t pin);
void digitalWrite(uint8_t pin, uint8_t level);
void analogWrite(uint8_t pin, int duty);
void pinMode(uint8_t pin, uint8_t mode);
int digitalPinToInterrupt(int pin);
void attachInterrupt(int number, void (*func)(void), int mode);
void interrupts(void);
void noInterrupts(void);
unsigned long micros(void);
struct Port {
    void begin(unsigned long baud);
    int available(void);
    int read(void);
    void print(const char *s) { printf("%s", s); }
    void print(char c) { printf("%c", c); }
    void print(int n) { printf("%d", n); }
    void print(long n) { printf("%ld", n); }
    void print(unsigned long n) { printf("%lu", n); }
    void print(double x, int digits = 2) { printf("%.*f", digits, x); }
    template <class T> void println(T x) { print(x); print("\\n"); }
    void println(double x, int digits) { print(x, digits); print("\\n"); }
};
extern Port Serial;
"""
WIRE = """\
#include <stdint.h>
struct Bus {
    void begin(void);
    void setClock(uint32_t hertz);
    void beginTransmission(uint8_t address);
    uint8_t write(uint8_t byte);
    uint8_t endTransmission(bool stop = true);
    uint8_t requestFrom(uint8_t address, uint8_t count);
    int read(void);
};
extern Bus Wire;
"""
PIPE = """\
#include "Arduino.h"
#include "robot_io.h"
static unsigned long now;
static int letter;
static double rate, volts[2];
static long count;
Port Serial;
void Port::begin(unsigned long baud) { if (baud < 9600) letter = 0; }
int Port::available(void) { return letter != 0; }
int Port::read(void) { int c = letter; letter = 0; return c; }
unsigned long micros(void) { return now; }
bool io_begin(void) { return true; }
float io_gyro(void) { return (float)rate; }
float io_tilt(void) { return 0; }
long io_encoder(int side) { return side ? count : count; }
float io_supply(void) { return 7.4f; }
void io_drive(int side, float v) { volts[side] = v; }
bool io_read(void)
{
    fprintf(stderr, "%.9g %.9g %lu\\n", volts[0], volts[1], now);
    return scanf("%lf %ld", &rate, &count) == 2;
}
void setup(void);
void loop(void);
int main(int argc, char **argv)
{
    if (argc < 2)
        return 1;
    setup();
    letter = argv[1][0];
    for (long k = 0; k < 1400000; k++) {
        now += 97; /* never just on time */
        loop();
    }
    return 0;
}
"""


fake_pyctrl = programs.fake_pyctrl


@pytest.fixture(scope="module")
def cpp(gcc):
    """A C++ compiler's command."""
    command = [shutil.which("g++") or shutil.which("c++")]
    if "ziglang" in gcc:
        command = [*gcc[:-1], "c++"]
    if not command[0]:
        pytest.skip("no C++ compiler")
    return command


def sketch_flags(folder):
    (folder / "Arduino.h").write_text(ARDUINO, "utf-8")
    (folder / "Wire.h").write_text(WIRE, "utf-8")
    warnings = ["-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-Werror"]
    return ["-std=c++11", "-pedantic", *warnings, "-I", folder]


def sketch_program(gcc, cpp, folder, texts, pipe):
    """The sketch among the ``texts`` on a board that is a ``pipe``, as a program."""
    for name, program in texts.items():
        path = folder / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(program, "utf-8")
    folder = path.parent
    (ino,) = folder.glob("*.ino")
    source = '#include "Arduino.h"\n' + ino.read_text("utf-8")
    (folder / "sketch.cpp").write_text(source, "utf-8")
    (folder / "pipe.cpp").write_text(pipe, "utf-8")
    flags, objects = sketch_flags(folder), [folder / "sketch.o"]
    for name in ("robot_io", "sketch"):
        out = folder / f"{name}.o"
        run(*cpp, *flags, "-c", folder / f"{name}.cpp", "-o", out)
    for law in folder.glob("*.c"):
        objects.append(law.with_suffix(".o"))
        run(*gcc, *FLAGS, *programs.STRICT, "-c", law, "-o", objects[-1])
    run(*cpp, "-I", folder, folder / "pipe.cpp", *objects, "-o", folder / "program")
    return folder / "program"


def live_sketch(program, word, answer):
    """What a `sketch_program` says.

    At each tick ``answer`` takes the motors' volts and the time in s, and gives what
    the sensors say.
    """
    serial = program.parent / "serial.txt"
    pipes = dict(stdin=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    with (
        open(serial, "w", encoding="utf-8") as file,
        subprocess.Popen([str(program), word], stdout=file, **pipes) as process,
    ):
        for line in process.stderr:
            *volts, now = map(float, line.split())
            process.stdin.write(answer(volts, now * 1e-6) + "\n")
            process.stdin.flush()
        process.stdin.close()
    return serial.read_text("utf-8")


@pytest.mark.slow
def test_the_sketch_records_what_identifies(gcc, cpp, tmp_path):
    texts = recorders(WIRED, seconds=SECONDS)
    texts = {x: text for x, text in texts.items() if x.startswith("identify/")}
    program = sketch_program(gcc, cpp, tmp_path, texts, PIPE)
    for experiment in ("body", "wheels"):
        bench, times = Bench(MACHINE, experiment), []

        def answer(volts, now, bench=bench, times=times):
            if times:
                bench.turn(sum(volts) / 2, now - times[-1])
            times.append(now)
            return f"{bench.gyro!r} {bench.counts}"

        said = live_sketch(program, experiment[0], answer)
        assert said.endswith("end\n")
        log = said[said.index("t,V") : -len("end\n")]
        (tmp_path / f"{experiment}.csv").write_text(log, "utf-8")
    body, _ = good(tmp_path, WIRED)
    assert len(body.t) == 1200 and body.T == pytest.approx(0.01, rel=1e-3)


# The command


def test_each_boards_recorders(tmp_path, capsys):
    (tmp_path / "robot.toml").write_text(text(WIRED), "utf-8")
    paths = main(["record", str(tmp_path / "robot.toml"), str(tmp_path / "out")])
    names = [path.relative_to(tmp_path / "out").as_posix() for path in paths]
    sketch = ["identify/identify.ino", "identify/robot_io.h", "identify/robot_io.cpp"]
    assert names == [*sketch, "rc_robot.h", "rc_identify.c", "pyctrl_identify.py"]
    for path in paths:
        if path.name != "robot_io.h":
            words = path.read_text("utf-8")
            assert "counts = 2134 a turn" in " ".join(words.replace("\n *", "").split())
    assert list(recorders(Robot.shipped("gearmotors"))) == sketch
    elsewhere = WIRED.but(motor_channels=(1, 4))
    assert "pyctrl_identify.py" not in recorders(elsewhere)
    code = recorders(elsewhere)["rc_robot.h"]
    assert "MOTOR_CHANNEL[2] = {1, 4}" in code and "RATE_HZ 100\n" in code


@pytest.mark.parametrize("amplitude", [-1.0, 0.0, 9.0, float("nan")])
def test_an_amplitude_beyond_the_motors_is_refused(amplitude):
    with pytest.raises(ValueError, match="amplitude"):
        recorders(WIRED, amplitude=amplitude)


def test_the_sweep_holds_the_bodys_own_frequency():
    for robot in (THESIS, Robot.shipped("gearmotors"), THESIS.but(l=0.3)):
        low, high = sweeps(robot)["body"]
        true = np.sqrt(robot.g / robot.l) / 2 / np.pi
        assert low < 0.8 * true and high > 1.2 * true
        assert high < 0.5 / robot.T


@pytest.mark.slow
def test_the_check_of_one_log_names_what_is_wrong(tmp_path, capsys):
    whole = [Log.read(DATA / f"{name}.csv") for name in ("body", "wheels")]
    bodies = [log.part(slice(len(log.t) // 2)) for log in whole]
    for name in ("gyro one sample late", "gyro clipped"):
        spoil, _ = SPOILT[name]
        spoil(*bodies)[0].write(tmp_path / "body.csv")
        with pytest.raises(SystemExit) as ended:
            main(["check", str(tmp_path / "body.csv")])
        assert ended.value.code == 1
        said = capsys.readouterr().out
        assert "not usable" in said and "refused" in said
        assert re.search(name.split()[-1], said), said
    bodies[1].write(tmp_path / "wheels.csv")
    paths = str(tmp_path / "wheels.csv"), "--robot", str(DATA / "thesis.toml")
    found = main(["check", *paths])
    assert found[0].usable and not found[0].findings
    assert len(found[0].fits) == 2


def test_a_short_or_faint_log_is_vague(tmp_path):
    body = Log.read(DATA / "body.csv")
    noise = np.random.default_rng(1).normal(0, 1.0, len(body.t))
    loud = Log(body.t, body.V, gyro=body.gyro + noise)
    loud.write(tmp_path / "body.csv")
    said = check_recording(tmp_path / "body.csv").report
    assert "sweep longer" in said


def test_a_log_of_neither_experiment_or_of_both_is_refused(tmp_path):
    (tmp_path / "none.csv").write_text("t,V\n0,0\n0.01,1\n0.02,1\n", "utf-8")
    both = "t,V,gyro,encoder1\n0,0,0,0\n0.01,1,0,0\n0.02,1,0,0\n"
    (tmp_path / "both.csv").write_text(both, "utf-8")
    for name, words in (("none", "no sensor"), ("both", "both a gyro")):
        with pytest.raises(ValueError, match=words):
            check_recording(tmp_path / f"{name}.csv")
    with pytest.raises(ValueError, match="experiment must"):
        check_recording(DATA / "body.csv", experiment="arms")
