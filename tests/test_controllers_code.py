"""The program in C: its numbers, its bits, its faults, and what a compiler says."""

import functools
import itertools
import re
import shutil
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import sosbook as sos
from sosbook.controllers import (
    FAULTS,
    Code,
    CompiledCode,
    Faults,
    Replay,
    code_fault,
    read_gains,
)
from sosbook.controllers.compiler import FLAGS
from sosbook.controllers.facts import bounded, facts_of, law_lines
from sosbook.controllers.output_bounds import OutputBounds
from sosbook.pendulum import Firmware, SampledLaw
from sosbook.pendulum.export import Program
from tests.axis import T, axis, rubbed
from tests.cases import campaign, later
from tests.processes import process

TARGETS = "arm-linux-gnueabihf", "arm-linux-gnueabi"
KINDS = {"double": float, "single": np.float32}
STRICT = (
    *("-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-ffp-contract=off"),
    *("-Wconversion", "-Wshadow", "-Wsign-conversion", "-Wdouble-promotion"),
)
SANITIZED = "-fsanitize=address,undefined,float-cast-overflow"


def limited():
    return axis().set_point(ramp=6).limit(2.0, slew=200).watch(stall=20, fastest=350.0)


def compilers():
    return [path for name in ("gcc", "clang") if (path := shutil.which(name))]


def ran(*command, **more):
    done = process(*command, **more)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def some_controllers():
    """Of several inputs and set points, with filters, without memory, in odd units."""
    rng = np.random.default_rng(5)
    plant = sos.SecondOrderSystem(
        0.3 * np.eye(2), 9.81 * np.eye(2), [[1, 0.3], [0, 2]], rng.normal(size=(2, 2))
    )
    region = dict(region=sos.PoleRegion(0.5, rho=300))
    pid = sos.design_pid(plant, [[1, 0]], **region)
    pd = sos.design_pid(plant, **region)
    filtered = dict(T=1e-3, delay=3e-4, filter_time=4e-3)
    return [
        pd.controller(T=0.001),
        pid.controller(["z1", "z2"], **filtered).limit(3.0, slew={"u1": 50}),
        pid.controller(["z1", "z2"], T=1e-3, delay=2.4e-3).limit({"u2": 4.0}),
    ]


def same(c, precision, flags, ticks=400, seed=0):
    """Whether C and Python agree in each bit, with readings that nobody believes."""
    rng = np.random.default_rng(seed)
    theirs = CompiledCode(c, precision=precision, flags=flags)
    ours = Replay(c, kind=KINDS[precision])
    q, p = len(c.readings.signals), len(c.set_points)
    y = rng.normal(0, 0.1, q)
    ours.start(y), theirs.start(y)
    for _ in range(ticks):
        y = y + rng.normal(0, 0.002, q)
        seen = np.where(rng.random(q) < 0.05, rng.choice(STRANGE, q), y)
        r = np.where(rng.random(p) < 0.1, rng.choice(STRANGE, p), rng.normal(0, 1, p))
        elapsed = c.T * (1 if rng.random() < 0.9 else rng.choice([0.5, 2, np.nan]))
        u, v = (x.step(seen, r, elapsed) for x in (ours, theirs))
        assert u.tobytes() == v.tobytes()
        assert ours.fault[0] == theirs.fault[0]
    return ours.fault[0]


STRANGE = [np.nan, np.inf, -np.inf, 1e300, 5e-324, -0.0, 1e6]
WAYS = list(itertools.product(KINDS, ("-O0", "-O2")))


@pytest.mark.parametrize("precision, optimised", [*WAYS[1:3], *later(WAYS[0], WAYS[3])])
def test_c_is_python_bit_for_bit(gcc, precision, optimised):
    flags = [x for x in FLAGS if x != "-O2"] + [optimised]
    patient = limited().watch(lost=0.05)
    assert same(patient, precision, flags) == 0
    for k, c in enumerate(some_controllers()):
        same(c.watch(lost=0.05), precision, flags, seed=k)


@pytest.mark.parametrize("precision", ["single", *campaign(["double"])])
def test_faults_come_at_the_same_tick(gcc, precision):
    found = {
        same(limited().watch(lost=lost, late=late), precision, FLAGS, 200, seed)
        for seed, lost, late in ((1, 0.0, 1), (2, 0.01, 0.0), (3, 0.002, 0.001))
    }
    assert found >= {1, 2}


@pytest.mark.slow
@pytest.mark.parametrize("path", compilers())
@pytest.mark.parametrize("precision", KINDS)
def test_the_files_compile_without_a_warning_and_the_bench_rests(
    gcc, tmp_path, path, precision
):
    others = [c.limit(1e4) for c in some_controllers()]  # what a step needs
    taken = slice(None, None, 2) if precision == "double" else slice(1, None, 2)
    for k, c in enumerate([limited(), *others][taken]):
        folder = tmp_path / str(k)
        Code(c, "axis", precision).write(folder)
        bench = folder / "bench"
        sources = [str(folder / x) for x in ("axis.c", "axis_bench.c")]
        ran(path, *STRICT, "-O2", "-o", str(bench), *sources)
        rows = ran(str(bench)).splitlines()
        assert len(rows) == len(c.vertices)
        assert all("fault 0" in row for row in rows)


def test_the_sketch_is_c_plus_plus(gcc, tmp_path):
    compiler = shutil.which("g++") or shutil.which("clang++")
    if compiler is None:
        pytest.skip("NO C++ compiler: apt-get install g++ brings one")
    Code(limited(), "axis", "single").write(tmp_path)
    (tmp_path / "Arduino.h").write_text(
        "#include <math.h>\nextern unsigned long micros(void);\n"
        "extern void delay(unsigned long);\n"
        "struct Port { void begin(long); }; extern Port Serial;\n",
        "utf-8",
    )
    sketch = tmp_path / "axis_sketch" / "axis_sketch.ino"
    flags = ("-std=gnu++17", "-Wall", "-Wextra", "-Werror", "-fsyntax-only")
    ran(compiler, *flags, "-include", str(tmp_path / "Arduino.h"), "-x", "c++", sketch)


def test_the_numbers_are_those_that_were_proven():
    c = limited()
    proof = c.certify(time_limit=60)
    for precision in KINDS:
        text = Code(c, "axis", precision).gains
        assert code_fault(proof.data, text) == ""
        read, kind = read_gains(text), KINDS[precision]
        for name in "ABCD":
            assert (read[name] == getattr(c, name).astype(kind)).all(), name
    text = Code(c, "axis").gains
    digit = re.search(r"0x1\.[0-9a-f]{13}p-1", text).group()
    other = digit[:-5] + ("0" if digit[-5] != "0" else "1") + digit[-4:]
    assert "isn't the proof's" in code_fault(proof.data, text.replace(digit, other))
    slower = text.replace("AXIS_TICK 0x1.", "AXIS_TICK 0x1.1")
    assert "TICK" in code_fault(proof.data, slower)
    assert "defines no A" in code_fault(proof.data, text.replace("AXIS_A ", "AXIS_X "))
    other = axis().set_point().certify(time_limit=60)
    assert code_fault(other.data, text) == ""  # a set point is no part of the loop
    assert "an estimate" in code_fault(c.certificate.data, text)
    assert "no gain" in code_fault({"K": None}, text)


@pytest.mark.parametrize("precision", KINDS)
def test_a_gain_is_read_back_where_a_program_applies_it_at_once(precision):
    """Of a pendulum, whose program leaves out zeros, and of a law without memory."""
    region = sos.PoleRegion(0.5, rho=300)
    for U in (None, [[0, 0.3]]):
        proof = sos.design_pid(pendulum(), U, region=region).certify()
        law = applied(proof.K, 0.013, U)
        text = Program(Firmware(law), precision=precision).gains
        assert code_fault(proof.data, text) == ""
        assert read_gains(text)["SINGLE"] == (precision == "single")
        assert (read_gains(text)["D"] == law.D.astype(KINDS[precision])).all()
        softer = Program(Firmware(applied(proof.K * 0.999, 0.013, U)))
        assert "its C and D aren't" in code_fault(proof.data, softer.gains)
        if U:
            other = Program(Firmware(applied(proof.K, 0.013, [[0, 0.31]])))
            assert "don't sum" in code_fault(proof.data, other.gains)
    pd = some_controllers()[0]
    text = Code(pd, "axis", precision).gains
    assert code_fault(pd.certificate.data, text) == ""
    swapped = pd.certificate.data | {"K": pd.certificate.data["K"][::-1]}
    assert "its C and D aren't" in code_fault(swapped, text)


def pendulum():
    """Two coordinates, one of them unstable, in units with 0.3 and 9.81."""
    return sos.SecondOrderSystem(
        [[0.3, 0.05], [0.05, 0.1]],
        [[0.02, -0.02], [-0.02, 0.02]],
        [[-9.81 * 0.3, 0], [0, 0]],
        [[-1], [1]],
    )


def applied(K, T, U):
    """What a robot's computer does with a gain; U has one row, or is None."""
    if U is None:
        none = np.zeros((0, 4))
        return SampledLaw(none[:, :0], none, none[:, :1].T, K, T)
    B = np.hstack([T * np.array(U), [[0, 0]]])
    return SampledLaw([[1]], B, K[:, 4:], K[:, :4], T)


def redefined(text, label, value):
    """A header's text with another value of a macro."""
    return re.sub(rf"(?<=AXIS_{label} )\S+", value, text, count=1)


@pytest.mark.parametrize(
    "change, words",
    [
        (lambda t, d: t.replace(f"{{{d}}}", f"{{-({d})}}"), "is no number"),
        (lambda t, d: t.replace(f"{{{d}}}", f"{{- {d}}}"), "is no number"),
        (lambda t, d: t.replace(f"{{{d}}}", f"{{{d} + X}}"), "is no number"),
        (lambda t, d: t.replace(f"{{{d}}}", f"{{{d}f}}"), "ROWS isn't"),
        (lambda t, d: t.replace("#endif", "#undef AXIS_D\n#endif"), "more than def"),
        (lambda t, d: t.replace("#endif", "# define AXIS_D {{1}}\n#endif"), "more"),
        (lambda t, d: t.replace("#endif", "#define AXIS_D {{1}}\n#endif"), "more"),
        (lambda t, d: t.replace("#endif", "#include <x.h>\n#endif"), "more than def"),
        (lambda t, d: t + "#undef AXIS_D\n", "more than definitions"),
        (lambda t, d: t.replace("#define AXIS_D", "// \\\n#define AXIS_D"), "more"),
        (lambda t, d: t.replace("#define AXIS_D ", "??=define AXIS_D "), "more than"),
        (lambda t, d: t.replace("#endif", '#define X "/*"\n#endif'), "more than"),
        (lambda t, d: t.replace("#endif", "#define double float\n#endif"), "more"),
        (lambda t, d: t.replace("AXIS_ROWS", "AXIS_X"), "defines no ROWS"),
        (lambda t, d: t.replace("AXIS_IN_", "AXIS_ON_"), "IN_ numbers aren't"),
        (lambda t, d: redefined(t, "DELAY_TICKS", "3"), "delay"),
        (lambda t, d: redefined(t, "DELAY_REST_US", "900UL"), "delay"),
        (lambda t, d: redefined(t, "TICK_US", "9000UL"), "TICK_US"),
        (lambda t, d: redefined(t, "MEASURED", "0"), "of its sizes"),
        (lambda t, d: redefined(t, "STATES", "2"), "of its sizes"),
        (lambda t, d: "", "defines nothing"),
        (lambda t, d: None, "text must be"),
    ],
)
def test_no_change_of_a_header_is_taken_for_what_was_proven(change, words):
    """Whatever a compiler would read in another way."""
    proof, text = proven_header()
    (number,) = re.search(r"AXIS_D \{ \\\n    \{([^}]*)\}", text).groups()
    assert words in code_fault(proof, change(text, number))


@functools.cache
def proven_header():
    """The data of a proof, and the text of the header that belongs to it."""
    c = limited()
    proof, text = c.certify(time_limit=60), Code(c, "axis").gains
    assert code_fault(proof.data, text) == ""
    return proof.data, text


def test_a_program_is_held_to_the_clocks_of_its_proof():
    """Its tick and its delay are among those that were proven."""
    c = replace(limited(), clock=sos.Clock(limited().T))
    text = Code(c, "axis").gains
    proof = c.certify(T=(0.0009, 0.0011), delay=(0.0, 0.0002)).data
    assert code_fault(proof, text) == ""
    late = redefined(text, "DELAY_REST_US", "400UL")
    assert "delay" in code_fault(proof, late)


@pytest.mark.parametrize("T, fits", [(1e-9, 0), (1.3e-6, 0), (1 / 3000, 1), (3e3, 0)])
def test_a_clock_that_no_board_has_is_named(T, fits):
    """Zero microseconds, and such as no 32 bits can tell from those before."""
    law = replace(limited(), clock=sos.Clock(T), faults=Faults(stall=0, lost=0, late=0))
    if fits:
        assert f"AXIS_TICK_US {round(1e6 * T)}UL" in Code(law, "axis").gains
    else:
        with pytest.raises(ValueError, match="can't be the clock of a board"):
            Code(law, "axis")


def test_a_set_point_that_nobody_gives_fills_no_counter(gcc):
    """Where nobody watches for it, for any number of ticks: an int may end at 32767."""
    c = limited()
    theirs, ours = CompiledCode(c), Replay(c, runs=2)
    for program in (theirs, ours):
        program.start([0.0])
    theirs.states[0].silent = 2**31 - 1
    for _ in range(3):
        u = theirs.step([0.0], [np.nan])
        assert (ours.step([0.0], [np.nan]) == u).all()
    assert theirs.states[0].silent == 0 and (ours._now.silent == 0).all()
    watched = c.watch(silence=0.003)
    for program in (CompiledCode(watched), Replay(watched)):
        program.start([0.0])
        faults = [(program.step([0.0], [np.nan]), program.fault)[1] for _ in range(5)]
        assert [FAULTS[int(f[0])] for f in faults] == ["running"] * 3 + ["silent"] * 2


def test_a_header_says_what_is_proven_bounded_and_simulated():
    code = limited().to_c("axis")
    head = re.sub(r"\n \* +", " ", code.gains[: code.gains.index("#ifndef")])
    columns = [head.index(x) for x in ("PROVEN", "BOUNDED", "SIMULATED ONLY")]
    assert columns == sorted(columns)
    of = "loop of every constant plant with J2 in [0.003, 0.006], "
    assert of + "with z = [motor, load], with a tick" in head
    assert "jitter, friction, backlash: not looked at" in head
    assert "a lasting oscillation, which no proof here covers" in head
    assert {"proof_axis.json", "proof_axis_sampled.json"} <= set(code.texts)
    assert "(Where this comes from.)" not in "".join(code.texts.values())


def test_a_program_is_named_after_its_owner(tmp_path):
    code = Code(limited(), "arm_2")
    text = "".join(code.texts[x] for x in ("arm_2.h", "arm_2.c", "arm_2_bench.c"))
    assert "arm_2_step(" in text and "ARM_2_STATES" in text
    assert not re.search("axis", text, re.I)
    assert "project(arm_2 C)" in code.texts["CMakeLists.txt"]
    code.write(tmp_path)
    (tmp_path / "arm_2.c").write_text("mine", "utf-8")
    with pytest.raises(FileExistsError):
        code.write(tmp_path)
    code.write(tmp_path, replace=True)
    assert (tmp_path / "arm_2.c").read_text("utf-8") == code.texts["arm_2.c"]


@pytest.mark.slow
def test_the_compiled_program_moves_the_drive(gcc):
    angle, torque = rubbed(CompiledCode(limited()), 0.006, 6.0, 4, lose=97)
    again, _ = rubbed(Replay(limited()), 0.006, 6.0, 1, lose=97)
    assert angle[: len(again)].tobytes() == again.tobytes()
    assert abs(angle[-1] - 6) < 0.05 and abs(torque).max() < 2


FUZZ = """
#include <math.h>
#include <stdio.h>
#include <string.h>
#include "axis.h"
static unsigned long long seed = 88172645463325252ULL;
static double random_bits(void)
{
    double value;
    seed ^= seed << 13;
    seed ^= seed >> 7;
    seed ^= seed << 17;
    memcpy(&value, &seed, sizeof value);
    return value;
}
static axis_real strange(axis_real tame)
{
    const double odd[] = {NAN, INFINITY, -INFINITY, 5e-324, 1e300, -0.0, 1e-310};
    const unsigned pick = (unsigned)(seed >> 20) % 100;
    const double any = random_bits();
    return pick < 7 ? (axis_real)odd[pick] : pick < 9 ? (axis_real)any : tame;
}
int main(void)
{
    axis_state s;
    axis_real y[AXIS_MEASURED], r[AXIS_ROOM(AXIS_SET_POINTS)], u[AXIS_OUTPUTS];
    const axis_real limit[] = AXIS_LIMIT;
    unsigned char bytes[sizeof u];
    unsigned long hash = 0, starts = 0;
    s.fault = AXIS_SENSOR;
    for (long tick = 0; tick < 1000000; tick++) {
        for (int i = 0; i < AXIS_MEASURED; i++)
            y[i] = strange((axis_real)(0.001 * (double)(seed % 100)));
        for (int j = 0; j < AXIS_SET_POINTS; j++)
            r[j] = strange(1);
        if (s.fault != AXIS_RUNNING) {
            axis_start(&s, y);
            starts++;
        }
        axis_step(&s, y, r, strange((axis_real)AXIS_TICK), u);
        for (int k = 0; k < AXIS_OUTPUTS; k++)
            if (!(u[k] >= -limit[k] && u[k] <= limit[k]))
                return 1;
        for (int i = 0; i < AXIS_STATES; i++)
            if (!isfinite(s.x[i]))
                return 2;
        memcpy(bytes, u, sizeof u);
        for (unsigned i = 0; i < sizeof u; i++)
            hash = (31 * hash + bytes[i]) & 0xffffffffUL;
    }
    printf("%lu %lu\\n", starts, hash);
    return 0;
}
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    "precision, lost", [("single", 0.0), *later(("double", 0.0), ("single", 0.004))]
)
def test_a_million_strange_ticks_under_sanitizers(gcc, tmp_path, precision, lost):
    Code(limited().watch(lost=lost), "axis", precision).write(tmp_path)
    (tmp_path / "fuzz.c").write_text(FUZZ, "utf-8")
    build = ("-std=c99", "-O1", "-g", "-ffp-contract=off", "-o", "fuzz")
    build += ("axis.c", "fuzz.c")
    trap = ("-fno-sanitize-recover=all", SANITIZED)
    tried = process(*gcc, *trap, *build, cwd=tmp_path)
    if tried.returncode:
        ran(*gcc, *build, cwd=tmp_path)  # this compiler has no sanitizer
    starts, _ = ran(str(tmp_path / "fuzz")).split()
    assert int(starts) > 1000 or lost


#: What a Cortex-M begins with; its input and output are the emulator's.
VECTORS = """
extern void _start(void);
static void reset(void)
{
    *(volatile unsigned *)0xE000ED88 |= 0xFu << 20; /* the FPU is on */
    __asm volatile("dsb; isb");
    _start();
}
__attribute__((section(".vectors"), used))
static void *const vectors[] = {(void *)0x20400000, (void *)reset};
"""
BARE = "arm-none-eabi-gcc -mthumb --specs=rdimon.specs -Wl,--section-start=.vectors=0"
BOARD = "qemu-system-arm -nographic -monitor none -serial none -semihosting -M"
#: Compiler and emulator of each processor, and the packages that bring them.
ARMS = {
    target: (f"{target}-gcc -static", "qemu-arm", f"gcc-{target} qemu-user")
    for target in TARGETS
} | {
    cpu: (
        f"{BARE} -mcpu={cpu} {unit} vectors.c",
        f"{BOARD} {board} -kernel",
        "gcc-arm-none-eabi libnewlib-arm-none-eabi qemu-system-arm",
    )
    for cpu, board, unit in (
        ("cortex-m3", "mps2-an385", ""),
        ("cortex-m4", "mps2-an386", "-mfpu=fpv4-sp-d16 -mfloat-abi=hard"),
        ("cortex-m7", "mps2-an500", "-mfpu=fpv5-d16 -mfloat-abi=hard"),
    )
}


@pytest.mark.campaign
@pytest.mark.parametrize("arm", ARMS)
@pytest.mark.parametrize("precision", KINDS)
def test_a_million_strange_ticks_are_the_same_on_an_arm(arm, precision, gcc, tmp_path):
    """With units for floating point of either precision, and without one."""
    compiler, qemu, packages = ARMS[arm]
    compiler, qemu = compiler.split(), qemu.split()
    if lost := [x for x in (compiler[0], qemu[0]) if not shutil.which(x)]:
        pytest.skip(f"NO {', '.join(lost)}: apt-get install {packages} brings it")
    Code(limited().watch(lost=0.004), "axis", precision).write(tmp_path)
    (tmp_path / "fuzz.c").write_text(FUZZ, "utf-8")
    (tmp_path / "vectors.c").write_text(VECTORS, "utf-8")
    told = set()
    for build, runs in ((gcc, ()), (compiler, qemu)):
        ran(*build, *FLAGS[:3], "axis.c", "fuzz.c", "-o", "fuzz", cwd=tmp_path)
        told.add(ran(*runs, str(tmp_path / "fuzz")))
    assert len(told) == 1


@pytest.mark.parametrize("flag", ["-ffast-math", "-ffinite-math-only"])
def test_what_the_program_refuses_to_be_compiled_with(gcc, flag):
    with pytest.raises(RuntimeError, match="breaks the checks"):
        CompiledCode(limited(), flags=[*FLAGS, flag])


@pytest.mark.parametrize("runs", ["no such word", 0, True, 1.5])
@pytest.mark.parametrize("program", [CompiledCode, Replay])
def test_how_many_machines_is_a_number(program, runs):
    with pytest.raises(ValueError, match="runs must be 1, 2"):
        program(limited(), runs=runs)


def test_a_number_that_single_precision_lacks_is_named():
    scaled = sos.design_pid(
        sos.SecondOrderSystem([[1]], [[1]], [[1]], [[1e-42]]),
        region=sos.PoleRegion(1, rho=9),
    )
    with pytest.raises(ValueError, match="too large for single precision"):
        Code(scaled.controller(T=0.01), "one", "single").gains


def test_ticks_are_seconds():
    slow = limited()
    assert "MOST_LOST 5 " in Code(slow, "axis").gains and slow.T == T


@pytest.mark.usefixtures("without_bounds")
def test_what_is_not_proven_is_said():
    (_, proven), *_ = facts_of(axis(), 1e-9)[0]
    assert any("sampled loop: NOT PROVEN, stopped after" in line for line in proven)


@pytest.mark.slow
def test_cmake_builds_it_and_its_bench_passes(gcc, tmp_path):
    cmake = shutil.which("cmake")
    if cmake is None:
        pytest.skip("NO cmake: apt-get install cmake brings it")
    Code(limited(), "axis").write(tmp_path)
    build = str(tmp_path / "build")
    ran(cmake, "-S", str(tmp_path), "-B", build)
    ran(cmake, "--build", build)
    assert "100% tests passed" in ran("ctest", "--test-dir", build)


def test_a_loop_of_which_nothing_is_asked_says_so_in_its_header():
    """It said that an undecided design isn't proven."""
    plant = sos.SecondOrderSystem(0.3, 0.2, 9.81, 1)
    loop = sos.Loop(plant, sos.FullState(), [[-1.0, -2.0]]).at(T=0.01)
    (_, proven), *_ = facts_of(loop.controller, None)[0]
    assert "in continuous time nothing was asked" in proven
    assert not any("NOT PROVEN" in line or "undecided" in line for line in proven)
    assert str(loop.design.certify()) == "not proven: nothing was asked"


def test_the_facts_of_several_outputs_name_each(monkeypatch):
    """One list of both rows of a gain was u, and two reaches were of no set point."""
    monkeypatch.setattr(OutputBounds, "reach", lambda self, j: f"reach {j}")
    one = np.eye(2)
    plant = sos.SecondOrderSystem(np.diag([2, 0.3]), 0.2 * one, 9.81 * one, one)
    K = [[-1, 0.5, -2, 0, -3, 0], [0.25, -3, 0, -1, 0, -2]]
    c = sos.analyse_pid(plant, K, U=one).controller(T=0.02).limit({"u1": 5, "u2": 7})
    names = "z1", "z2", "z1'", "z2'", "integral of z1", "integral of z2"
    for line, u, row in zip(law_lines(c), ("u1", "u2"), K, strict=True):
        assert line == f"{u} = " + ", ".join(f"{k:g} {x}" for k, x in zip(row, names))
    found = bounded(c, [SimpleNamespace(asks=None)] * 2)
    assert found[-2:] == ["set point of z1: reach 0", "set point of z2: reach 1"]
