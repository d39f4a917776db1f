"""The generated programs: their text, their warnings, their behaviour."""

import ast
import re
import shutil
import sys
from functools import reduce
from operator import add
from unittest.mock import MagicMock

import numpy as np
import pytest

from sosbook.book import thesis
from sosbook.pendulum import FAULTS, Firmware, SampledLaw
from sosbook.pendulum.compiled import FLAGS
from sosbook.pendulum.export import Program
from sosbook.pendulum.rig import COUNTS_PER_TURN
from sosbook.pendulum.steering import Steering
from sosbook.pendulum.ticks import TickLog
from tests.cases import crossed
from tests.compiler import run
from tests.gains import named
from tests.processes import process
from tests.test_mip_compiled import LAWS

T = 0.01
PRINTED = thesis.mip()
STRICT = ["-Wconversion", "-Wdouble-promotion", "-Wfloat-equal", "-Wshadow",
          "-Wmissing-prototypes", "-Wundef"]  # fmt: skip
# some compilers add calls of their own, as Ubuntu's and zig's
PLAIN = ["-fno-sanitize=all", "-fno-stack-protector"]
HOSTILE = ("ends */ int a = 1; /* here", "a\nb\\", "??/", '"""', "\u202e\0",
           "*" * 3 + "/" * 3, "/*/", "x" * 300)  # fmt: skip


LAWS = LAWS | {
    "PID": SampledLaw.of_gain(named(PRINTED.pid[5]), T),
    "Appendix B": SampledLaw.appendix_b(named(PRINTED.pid[5]), T),
}


def write(folder, program):
    """The path of a program's law."""
    for name, text in program.law.items():
        (folder / name).write_text(text, "utf-8")
    return folder / f"{program.name}.c"


# The text


def test_no_note_ends_the_comment_that_holds_it(gcc, tmp_path):
    firmware = Firmware(LAWS["PD"].noted(*HOSTILE))
    text = Program(firmware).gains
    assert text.index("*/") > text.index("xxx")
    assert text[: text.index("*/")].count("/*") == 1
    source = write(tmp_path, Program(firmware))
    run(*gcc, *FLAGS, *STRICT, "-c", source, "-o", tmp_path / "a.o")
    assert ast.get_docstring(ast.parse(Program(firmware).pyctrl))
    assert " * one\n" in Program(Firmware(LAWS["PD"].noted("one"))).gains


def test_what_gives_no_program():
    firmware = Firmware(LAWS["PD"])
    for name in ("", "Balance", "9lives", "a-b", "x" * 40, "float", None, "na\nme"):
        with pytest.raises(ValueError, match="name must begin"):
            Program(firmware, name)
    with pytest.raises(ValueError, match="precision must be"):
        Program(firmware, precision="half")
    with pytest.raises(ValueError, match="must be a Firmware"):
        Program(LAWS["PD"])
    with pytest.raises(ValueError, match="stall must be at most"):
        Program(Firmware(LAWS["PD"], stall=10**6))
    with pytest.raises(ValueError, match="doesn't use what it measures"):
        Program(Firmware(SampledLaw.of_gain(named([[0, 0, 0, 0]]), T)))
    big = Firmware(SampledLaw.of_gain(named([[1e39, 0, 0, 0]]), T))
    assert "e+39" in Program(big).gains
    with pytest.raises(ValueError, match="too large for single"):
        Program(big, precision="single").gains
    with pytest.raises(ValueError, match="the IMU's rates"):
        Program(Firmware(SampledLaw.of_gain(named(PRINTED.pd[5]), 0.003))).rc_balance


# The C program


@pytest.mark.parametrize(
    "precision, name", crossed(["double", "single"], ["PID", "(4.30)"])
)
def test_no_compiler_warns_and_nothing_is_linked(name, precision, gcc, tmp_path):
    """Also its objects hold no variable and ask for no function."""
    source = write(tmp_path, Program(Firmware(LAWS[name]), "up", precision))
    others = [[path]] if (path := shutil.which("clang")) else []
    for command in [gcc, *others]:
        for level in ("-O0", "-O2"):
            out = tmp_path / "up.o"
            run(*command, *FLAGS, *STRICT, level, *PLAIN, "-c", source, "-o", out)
            if sys.platform != "linux" or not shutil.which("nm"):
                continue
            symbols = [line.split()[-2:] for line in run("nm", out).splitlines()]
            kinds = {kind for kind, _ in symbols}
            assert kinds <= {"T", "t", "r", "n", "N"}, symbols
            assert {x for kind, x in symbols if kind == "T"} == {"up_start", "up_step"}


def test_the_header_stands_alone_and_may_come_twice(gcc, tmp_path):
    write(tmp_path, Program(Firmware(LAWS["PID"])))
    text = '#include "balance.h"\n#include "balance.h"\nint a = BALANCE_FALL;'
    (tmp_path / "a.c").write_text(text + "\n", "utf-8")
    run(*gcc, *FLAGS, "-c", tmp_path / "a.c", "-o", tmp_path / "a.o")
    header = (tmp_path / "balance.h").read_text("utf-8")
    found = re.findall(r"BALANCE_(\w+) = (\d)", header)
    assert [(x.upper(), str(k)) for k, x in enumerate(FAULTS)] == found


@pytest.mark.parametrize("precision, kind", [("double", "DBL"), ("single", "FLT")])
def test_a_compiler_with_other_digits_is_refused(precision, kind, gcc, tmp_path):
    """As on AVR, where double is float and the proof isn't of it."""
    source = write(tmp_path, Program(Firmware(LAWS["PD"]), precision=precision))
    tick, include = tmp_path / "balance_tick.h", '#include "balance.h"\n'
    eleven = f"{include}#undef {kind}_MANT_DIG\n#define {kind}_MANT_DIG 11\n"
    tick.write_text(tick.read_text("utf-8").replace(include, eleven), "utf-8")
    done = process(*gcc, "-std=c99", "-c", source, "-o", tmp_path / "a.o")
    assert done.returncode and "other digits" in done.stderr


#: Compiler, flags, and the precision whose digits it has.
CROSS = {
    "Cortex-M0": ("arm-none-eabi-gcc", ["-mcpu=cortex-m0", "-mthumb"], "single"),
    "Cortex-M4": (
        "arm-none-eabi-gcc",
        ["-mcpu=cortex-m4", "-mthumb", "-mfpu=fpv4-sp-d16", "-mfloat-abi=hard"],
        "single",
    ),
    "Cortex-M7": (
        "arm-none-eabi-gcc",
        ["-mcpu=cortex-m7", "-mthumb", "-mfpu=fpv5-d16", "-mfloat-abi=hard"],
        "double",
    ),
    "AVR": ("avr-gcc", ["-mmcu=atmega328p"], "single"),
}


@pytest.mark.parametrize("target", CROSS)
def test_compilers_of_microcontrollers_take_it_without_a_warning(target, tmp_path):
    compiler, flags, precision = CROSS[target]
    if shutil.which(compiler) is None:
        pytest.skip(f"NO {compiler}: apt-get install gcc-{compiler[:-4]} brings it")
    firmware = Firmware(LAWS["PID"], blend=0.005, frozen=12, deaf=25, compensation=0.1)
    steering = Steering(firmware, [[-0.93, -0.29, -0.52]], 0.25, 0.07, 0.034)
    law = write(tmp_path, Program(firmware, precision=precision, steering=steering))
    strict = [*FLAGS, *(word for word in STRICT if word != "-Wfloat-equal"), *flags]
    for path in (tmp_path / "balance_run.c", tmp_path / "balance_steer.c", law):
        run(compiler, *strict, "-c", path, "-o", tmp_path / "a.o")
    names = run(compiler.replace("gcc", "nm"), "--undefined-only", tmp_path / "a.o")
    # arithmetic of the compiler's own and copies, and nothing of a library
    assert all(
        word.split()[-1].startswith("__") or word.split()[-1] in ("memcpy", "memset")
        for word in names.splitlines()
    ), names


DRIVER = """\
#include <stdio.h>
#include "balance.h"
int main(void)
{
    balance_state s;
    double r[5], tilt;
    if (scanf("%lf", &tilt) != 1)
        return 1;
    balance_start(&s, tilt, 0, 0);
    while (scanf("%lf %lf %lf %lf %lf", r, r + 1, r + 2, r + 3, r + 4) == 5)
        printf("%a\\n", balance_step(&s, r[0], r[1], r[2], r[3], r[4]));
    printf("%d\\n", s.fault);
    return 0;
}
"""


def test_sanitizers_find_nothing_undefined(gcc, tmp_path):
    """A program of its own reads wild readings; also Python's volts."""
    firmware = Firmware(LAWS["Appendix B"], blend=0.1, stall=3)
    source, main = write(tmp_path, Program(firmware)), tmp_path / "main.c"
    main.write_text(DRIVER, "utf-8")
    program = tmp_path / "main"
    build = [*gcc, "-std=c99", "-O1", "-ffp-contract=off", "-g"]
    checks = ["-fsanitize=undefined,address", "-fno-sanitize-recover=all"]
    checks += ["-fsanitize=float-divide-by-zero"]
    done = process(*build, *checks, source, main, "-o", program)
    if done.returncode or process(program, input="0\n").returncode:
        pytest.skip("the compiler has no sanitizers")
    random = np.random.default_rng(0)
    rows = random.normal(0, 0.02, (60, 5))
    rows[5, 0] = rows[9, 2] = np.nan
    rows[20, 1], rows[30, 0], rows[58, 3] = 1e308, -np.inf, np.inf
    text = "\n".join(" ".join(map(repr, row)) for row in rows.tolist())
    *volts, fault = run(program, input=f"0.05\n{text}\n").split()
    controller = firmware.controller()
    controller.start(0.05)
    ours = [float(controller.step(*row)[0]) for row in rows]
    assert list(map(float.fromhex, volts)) == ours
    assert int(fault) == controller.fault[0]
    assert sum(v != 0 for v in ours) > 20


# librobotcontrol; the prototypes are those of its public headers

HEADER = """\
#include <stdint.h>
#include <stddef.h>
#define TB_PITCH_X 0
#define DEG_TO_RAD 0.0174532925199
#define RC_BTN_PIN_PAUSE 2,5
#define RC_BTN_STATE_RELEASED 0
#define RC_BTN_POLARITY_NORM_HIGH 1
#define RC_BTN_DEBOUNCE_DEFAULT_US 2000
typedef enum { ORIENTATION_Y_UP = 112 } rc_mpu_orientation_t;
typedef enum { RC_LED_GREEN, RC_LED_RED } rc_led_t;
typedef enum { UNINITIALIZED, RUNNING, PAUSED, EXITING } rc_state_t;
typedef struct {
    int dmp_sample_rate;
    int dmp_fetch_accel_gyro;
    rc_mpu_orientation_t orient;
} rc_mpu_config_t;
typedef struct {
    double accel[3];
    double gyro[3];
    double dmp_TaitBryan[3];
} rc_mpu_data_t;
typedef unsigned long pthread_t;
#define SCHED_OTHER 0
int rc_pthread_create(pthread_t *thread, void *(*func)(void *), void *arg,
                      int policy, int priority);
int rc_pthread_timed_join(pthread_t thread, void **retval, float timeout_sec);
rc_mpu_config_t rc_mpu_default_config(void);
int rc_mpu_initialize_dmp(rc_mpu_data_t *data, rc_mpu_config_t conf);
int rc_mpu_set_dmp_callback(void (*func)(void));
int rc_mpu_power_off(void);
int rc_motor_init(void);
int rc_motor_cleanup(void);
int rc_motor_standby(int standby_en);
int rc_motor_set(int ch, double duty);
int rc_encoder_eqep_init(void);
int rc_encoder_eqep_cleanup(void);
int rc_encoder_eqep_read(int ch);
int rc_adc_init(void);
int rc_adc_cleanup(void);
double rc_adc_batt(void);
int rc_button_init(int chip, int pin, char polarity, int debounce_us);
void rc_button_cleanup(void);
int rc_button_set_callbacks(int chip, int pin, void (*press_func)(void),
                            void (*release_func)(void));
int rc_button_get_state(int chip, int pin);
int rc_led_set(rc_led_t led, int value);
void rc_led_cleanup(void);
rc_state_t rc_get_state(void);
void rc_set_state(rc_state_t new_state);
int rc_make_pid_file(void);
int rc_kill_existing_process(float timeout_s);
int rc_remove_pid_file(void);
int rc_enable_signal_handler(void);
void rc_usleep(unsigned int us);
uint64_t rc_nanos_since_boot(void);
int rc_mpu_is_gyro_calibrated(void);
int rc_dsm_init(void);
int rc_dsm_cleanup(void);
int rc_dsm_is_new_data(void);
double rc_dsm_ch_normalized(int ch);
"""
#: For systems that have none: there is always something to read, or the end.
POLL = """\
#define POLLIN 1
struct pollfd { int fd; short events, revents; };
static inline int poll(struct pollfd *f, unsigned long n, int t)
{ f->revents = POLLIN; return n == 1 && t == 0; }
"""

# Time passes in rc_usleep alone. Each line of input is a tick: a word
# (t tick, p tick after PAUSE, s a silent IMU), pitch, gyro, encoders at
# channels 3 and 2, battery. Each tick's duties go out. The word d is no
# tick: the radio's channels 3 and 2. A tick l is late, by 7 ms. The card is so slow
# that what writes it does nothing before the end.
STUB = """\
#include <stdio.h>
#include "robotcontrol.h"
static rc_mpu_data_t *imu;
static rc_mpu_config_t asked;
static void (*callback)(void), (*pressed)(void);
static int encoder[5], standby = -1, pid, off;
static double duty[5], battery = 8.0;
static rc_state_t state;
static uint64_t now = 5000000000;
static double sticks[10];
static int fresh;
static void *(*writer)(void *), *written;
int rc_pthread_create(pthread_t *thread, void *(*func)(void *), void *arg,
                      int policy, int priority)
{ *thread = 1; writer = func; written = arg; return policy + priority; }
int rc_pthread_timed_join(pthread_t thread, void **retval, float s)
{ writer(written); return (thread != 1) + (retval != NULL) + (s < 1); }
int rc_dsm_init(void) { return 0; }
int rc_dsm_cleanup(void) { return 0; }
int rc_dsm_is_new_data(void) { return fresh; }
double rc_dsm_ch_normalized(int ch) { fresh = 0; return sticks[ch]; }
rc_mpu_config_t rc_mpu_default_config(void)
{ rc_mpu_config_t c = {0, 0, 0}; return c; }
int rc_mpu_initialize_dmp(rc_mpu_data_t *data, rc_mpu_config_t conf)
{ imu = data; asked = conf; return 0; }
int rc_mpu_set_dmp_callback(void (*func)(void)) { callback = func; return 0; }
int rc_mpu_power_off(void) { off = 1; return 0; }
int rc_motor_init(void) { return 0; }
int rc_motor_cleanup(void)
{ printf("end %d %d %g %g\\n", off, standby, duty[2], duty[3]); return 0; }
int rc_motor_standby(int standby_en) { standby = standby_en; return 0; }
int rc_motor_set(int ch, double d)
{ if (ch) duty[ch] = d; else duty[2] = duty[3] = d; return 0; }
int rc_encoder_eqep_init(void) { return 0; }
int rc_encoder_eqep_cleanup(void) { return 0; }
int rc_encoder_eqep_read(int ch) { return encoder[ch]; }
int rc_adc_init(void) { return 0; }
int rc_adc_cleanup(void) { return 0; }
double rc_adc_batt(void) { return battery; }
int rc_button_init(int chip, int pin, char polarity, int us)
{ return !(chip == 2 && pin == 5 && polarity == 1 && us == 2000); }
void rc_button_cleanup(void) {}
int rc_button_set_callbacks(int chip, int pin, void (*p)(void),
                            void (*r)(void))
{ pressed = p; return chip + pin - 7 + (r != NULL); }
int rc_button_get_state(int chip, int pin)
{ return chip + pin == 0; }
int rc_led_set(rc_led_t led, int value) { return led + value < 0; }
void rc_led_cleanup(void) {}
rc_state_t rc_get_state(void) { return state; }
void rc_set_state(rc_state_t s) { state = s; }
int rc_make_pid_file(void) { pid = 1; return 0; }
int rc_kill_existing_process(float s) { return s < 0; }
int rc_remove_pid_file(void) { pid = 0; return 0; }
int rc_enable_signal_handler(void) { return 0; }
int rc_mpu_is_gyro_calibrated(void) { return battery > 0; }
uint64_t rc_nanos_since_boot(void) { return now; }
void rc_usleep(unsigned int us)
{
    char word;
    double pitch, rate, volts;
    if (us < 50000) /* while PAUSE is held */
        return;
    if (scanf(" %c %lf %lf %d %d %lf", &word, &pitch, &rate, encoder + 3,
              encoder + 2, &volts) != 6) {
        printf("asked %d %d %d %d\\n", asked.dmp_sample_rate,
               asked.dmp_fetch_accel_gyro, (int)asked.orient, pid);
        state = EXITING;
        return;
    }
    if (word == 'd') {
        sticks[3] = pitch;
        sticks[2] = rate;
        fresh = 1;
        return;
    }
    if (word == 's')
        return;
    now += word == 'l' ? 17000000 : 10000000;
    if (word == 'p' && pressed)
        pressed();
    imu->dmp_TaitBryan[TB_PITCH_X] = pitch;
    imu->gyro[0] = rate;
    callback();
    printf("tick %a %a %d\\n", duty[3], duty[2], standby);
    battery = volts;
}
"""


class Robot:
    """The program against stubs of the library."""

    def __init__(self, compiler, folder, firmware, kind="double", stub=STUB, **more):
        self.folder, self.command = folder, compiler
        program = Program(firmware, precision=kind, **more)
        write(folder, program)
        sources = [folder / name for name in program.law if name.endswith(".c")]
        main = folder / "rc_balance.c"
        for name, text in program.rc_balance.items():
            (folder / name).write_text(text, "utf-8")
        (folder / "robotcontrol.h").write_text(HEADER, "utf-8")
        (folder / "stub.c").write_text(stub, "utf-8")
        if sys.platform == "win32":
            (folder / "poll.h").write_text(POLL, "utf-8")
        out, sources = folder / "main.o", [folder / "stub.c", *sources]
        run(*compiler, *FLAGS, *STRICT, "-I", folder, "-c", main, "-o", out)
        flags = ["-std=c99", "-ffp-contract=off", *sources, out, "-lm"]
        run(*compiler, *flags, "-o", folder / "rc_balance")

    def live(self, rows, *words):
        """Duties left and right and standby at each tick, all output."""
        text = "\n".join(
            " ".join(x if isinstance(x, str) else repr(x) for x in row) for row in rows
        )
        output = run(self.folder / "rc_balance", *words, input=text + "\n")
        lines = (x.split() for x in output.splitlines() if x.startswith("tick"))
        both = float.fromhex
        return [(both(a), both(b), int(c)) for _, a, b, c in lines], output


REST = [("t", -0.45, 0.5, 100, -140, 8.0)] * 101  # upright is pitch -0.49


def moves(count, seed=3):
    """Ticks of a robot that moves a little; battery voltages."""
    random = np.random.default_rng(seed)
    counts = np.cumsum(random.integers(-9, 9, (count, 2)), axis=0)
    pitch, rate = random.normal(-0.45, 0.05, count), random.normal(0, 9, count)
    rows = zip(pitch, rate, counts.tolist(), random.uniform(6, 8.4, count))
    return [
        ("t", float(p), float(w), 100 + a, -140 - b, float(v))
        for p, w, (a, b), v in rows
    ]


def readings(row, kind=float):
    """gyro, wheels, tilt in our units, as librobotcontrol has signs."""
    _, pitch, rate, left, right, _ = row
    one = 6.283185307179586
    left, right = left * one / (1 * COUNTS_PER_TURN), right * one / -COUNTS_PER_TURN
    return rate * 0.0174532925199, (kind(left) + kind(right)) / 2, pitch + 0.49


def expected(firmware, rest, rows, kind=float):
    """The duties of Python's controller; the battery is a tick old."""
    gyro, wheels, tilt = zip(*(readings(row, kind) for row in rest[1:]))
    mean = [reduce(add, map(kind, x), kind(0)) / kind(len(x)) for x in (tilt, gyro)]
    controller = firmware.controller(kind=kind)
    controller.start(mean[0], wheels[-1], mean[1])
    duties, battery = [], rest[-1][-1]
    for row in rows:
        volts = float(controller.step(*readings(row, kind))[0])
        sane = battery if 5 < battery < 9 else 7.4
        duty = 1000 * volts / int(1000 * sane)
        duties.append(min(max(duty, -1.0), 1.0))
        battery = row[-1]
    return duties, controller


@pytest.mark.parametrize("precision, kind", [("double", float), ("single", np.float32)])
def test_the_robots_duty_is_the_controllers_volts(precision, kind, gcc, tmp_path):
    firmware = Firmware(LAWS["PID"], blend=0.02)
    robot = Robot(gcc, tmp_path, firmware, precision)
    rows = moves(200)
    rows[50] = ("t", -0.45, float("nan"), *rows[49][3:])
    rows[60] = (*rows[60][:5], 0.3)  # a battery that isn't measured
    rows[99] = (*rows[99][:5], 6.0)  # less than the law asks for next
    rows[100] = ("t", -0.45, 800.0, *rows[99][3:])
    ticks, output = robot.live([*REST, *rows])
    assert ticks[:101] == 100 * [(0.0, 0.0, 1)] + [(0.0, 0.0, 0)]
    duties, controller = expected(firmware, REST, rows, kind)
    found = np.array([(left, -right) for left, right, _ in ticks[101:]])
    assert (found[:, 0] == found[:, 1]).all()
    assert found[:, 0] == pytest.approx(duties, rel=4 * float(np.finfo(kind).eps))
    assert controller.fault[0] == 0 and max(map(abs, duties)) == 1.0
    assert output.splitlines()[-2:] == ["asked 100 1 112 1", "end 1 1 0 0"]


@pytest.fixture(scope="module")
def robot(gcc, tmp_path_factory):
    """A robot's program, compiled once."""
    return Robot(gcc, tmp_path_factory.mktemp("robot"), Firmware(LAWS["PD"]))


def test_it_waits_for_rest_near_upright_and_says_why(robot):
    good = REST[0]
    for restless, words in (
        (("t", -0.1, 0.5, *good[3:]), "hold it upright"),
        (("t", -0.45, 7.0, *good[3:]), "its offset is large"),
        (("t", -0.45, 0.5, 160, -140, 8.0), ""),
        (("t", float("nan"), 0.5, *good[3:]), ""),
    ):
        ticks, _ = robot.live([*REST[:90], restless, *REST[:90], restless])
        assert {standby for *_, standby in ticks} == {1}
        assert words in robot.live(130 * [restless])[1]
    rolls = [(*good[:3], 100 + 20 * k, -140 - 20 * k, 8.0) for k in range(130)]
    assert "hold its wheels still" in robot.live(rolls)[1]
    ticks, _ = robot.live([*REST[:40], restless, *REST[:102]])
    assert [standby for *_, standby in ticks].index(0) == 140


def test_a_fault_stops_the_motors_until_pause_and_rest(gcc, tmp_path):
    robot = Robot(gcc, tmp_path, Firmware(LAWS["PD"], blend=0.02))
    fall = [("t", -0.45, 1900.0, 100, -140, 8.0)] * 3
    silent = [("t", -0.45, float("nan"), 100, -140, 8.0)] * 6
    again = [("p", *REST[0][1:]), *REST]
    rows = [*REST, *moves(4), *fall, *REST, *again, *moves(4), *silent, *REST]
    ticks, output = robot.live(rows)
    standby = [s for *_, s in ticks]
    first, second = 101, 101 + 4 + 3 + 101 + 1 + 101
    assert standby[first : first + 4] == [0] * 4
    assert set(standby[first + 7 : second - 2]) == {1}
    assert standby[second : second + 9] == [0] * 9
    assert set(standby[second + 9 :]) == {1}
    assert all(a == b == 0 for a, b, s in ticks if s)
    assert "motors off: fall" in output
    assert "motors off: sensor" in output


def test_late_ticks_are_counted_and_too_many_of_them_stop_it(gcc, tmp_path):
    """Every third one may be late; all of them may not."""
    robot = Robot(gcc, tmp_path, Firmware(LAWS["PID"], blend=0.02, late=8))
    rows = moves(90)
    rows = [("t" if k < 60 and k % 3 else "l", *row[1:]) for k, row in enumerate(rows)]
    ticks, output = robot.live([*REST, *rows], str(tmp_path / "log.csv"))
    log = TickLog.read(tmp_path / "log.csv")
    assert log.late[60] == 20 and log.late[-1] == 29
    assert log.fault[-1] == FAULTS.index("late") and set(log.fault[1:-1]) == {0}
    assert [standby for *_, standby in ticks[101:]] == [0] * 68 + [1] * 22
    assert "motors off: late" in output
    long = ("t", *rows[0][1:])  # a single tick that comes after so many others should
    slow = STUB.replace("17000000", "110000000")
    (tmp_path / "slow").mkdir()
    robot = Robot(gcc, tmp_path / "slow", Firmware(LAWS["PID"], late=8), stub=slow)
    ticks, output = robot.live([*REST, *moves(3), ("l", *long[1:]), *moves(3)])
    assert [standby for *_, standby in ticks[101:]] == [0] * 3 + [1] * 4


def test_pause_stops_a_running_robot(robot):
    ticks, _ = robot.live([*REST, *moves(2), ("p", *REST[0][1:]), *REST])
    assert [s for *_, s in ticks[101:]] == [0, 0, *[1] * 102]


def test_a_silent_imu_ends_the_program_with_the_motors_off(robot):
    quiet = [("s", *REST[0][1:])] * 9
    ticks, output = robot.live([*REST, *moves(3), *quiet, *moves(50)])
    assert ticks[-1][2] == 0 and len(ticks) == 104
    assert output.splitlines()[-1] == "end 1 1 0 0"


def test_the_check_of_signs_never_moves_a_motor(robot):
    press = ("p", *REST[0][1:])
    ticks, output = robot.live([*REST, press, *REST, *moves(9)], "check")
    assert set(ticks) == {(0.0, 0.0, 1)}
    assert "tilt  0.040 rad, gyro   0.01 rad/s, wheels    0.30 and" in output


# pyctrl


@pytest.fixture
def fake_pyctrl(monkeypatch):
    """As much of pyctrl 0.4.3 as the script needs; what makes its controllers."""
    pyctrl = MagicMock()

    class BufferBlock:
        def __init__(self, **kwargs):
            self.buffer = ()

        def write(self, *values):
            self.buffer = values

        def read(self):
            return self.buffer

    pyctrl.Filter, pyctrl.BufferBlock = type("Filter", (), {}), BufferBlock
    pyctrl.Button.return_value.read.return_value = (1,)
    for name in ("", ".block", ".rc", ".rc.mip", ".rc.button"):
        monkeypatch.setitem(sys.modules, f"pyctrl{name}", pyctrl)
    return pyctrl.Controller


def script(gcc, folder, firmware, clock=None, **more):
    """The script's names, and its block with the law that it compiles itself."""
    program = Program(firmware, **more)
    write(folder, program)
    space = {"__name__": "script", "__file__": str(folder / "pyctrl_balance.py")}
    exec(compile(program.pyctrl, "balance.py", "exec"), space)
    ticks = (0.01 * k for k in range(9999))
    return space, space["Balance"](space["library"](*gcc), clock or ticks.__next__)


def test_the_scripts_block_has_pyctrls_turns_and_percent(fake_pyctrl, gcc, tmp_path):
    firmware = Firmware(LAWS["PID"], blend=0.02)
    _, block = script(gcc, tmp_path, firmware)
    turn = 6.283185307179586
    mount, theirs = 0.49 / turn, 60 * 35.557  # pyctrl's gears and counts
    wheel = turn * theirs / COUNTS_PER_TURN
    rest = [(-0.065, 0.001, 0.2, 0.3)] * 101
    for row in rest:
        block.write(*row)
        assert block.read() == (0.0, 0.0)
    assert block.run.balancing
    ours = firmware.controller()
    ours.start(turn * (mount - 0.065), wheel * 0.25, turn * 0.001)
    random = np.random.default_rng(1)
    for row in random.normal(0, 0.003, (60, 4)) + rest[0]:
        block.write(*row)
        gyro, tilt = turn * row[1], turn * (row[0] + mount)
        volts = float(ours.step(gyro, wheel * (row[2] + row[3]) / 2, tilt)[0])
        percent = np.clip(100 * volts / 7.4, -100, 100)
        assert block.read() == pytest.approx((percent, percent), abs=1e-9)
    assert ours.fault[0] == 0 and abs(volts) > 0.01
    for row in 9 * [(0.3, 2.0, 0.0, 0.0)]:
        block.write(*row)
    assert FAULTS[block.run.fault] == "fall" and block.read() == (0.0, 0.0)
    block.reset()
    block.write(-0.3, 0.0, 0.0, 0.0)
    assert block.read() == (0.0, 0.0) and block.run.waiting == b"hold it upright"


def test_the_script_sets_pyctrl_up(fake_pyctrl, monkeypatch, gcc, tmp_path):
    monkeypatch.setattr(sys, "argv", ["pyctrl_balance.py"])
    space, _ = script(gcc, tmp_path, Firmware(LAWS["PD"]))
    made = space["library"]
    space["library"] = lambda cc: made(*gcc)
    space["main"]()
    fake_pyctrl.assert_called_once_with(period=T)
    calls = fake_pyctrl.return_value.method_calls
    _, block, inputs, outputs = calls[0].args
    assert inputs == ["theta", "theta_dot", "encoder1", "encoder2"]
    assert outputs == ["pwm1", "pwm2"]
    rest = ["set_source", "set_source", "start", "set_state", "join"]
    assert [name for name, *_ in calls[1:]] == rest
