"""A board in the simulator's loop, and compilers of other processors."""

import os
import shutil
import subprocess

import numpy as np
import pytest
from sosbook.mip import Firmware, Mip, simulate
from sosbook.mip.compiled import FLAGS
from sosbook.mip.export import c_header, c_source, c_steering, serial_main

from sosbook.pendulum.hardware import Board
from sosbook.pendulum.steering import Steering
from tests.compiler import find, refuse, run
from tests.test_mip_export import LAWS, STRICT

FIRMWARE = Firmware(LAWS["PID"], blend=0.005, frozen=12, deaf=25, compensation=0.1)
STEERING = Steering(FIRMWARE, [[-0.93, -0.29, -0.52]], 0.25, 0.07, 0.034)
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


def source(folder, precision="double"):
    (folder / "balance.h").write_text(c_header(FIRMWARE, precision=precision), "utf-8")
    path = folder / "balance.c"
    path.write_text(c_source(FIRMWARE, precision=precision), "utf-8")
    return path


@pytest.fixture
def board(tmp_path):
    """The compiled program behind a pseudo-terminal."""
    pty, tty = pytest.importorskip("pty"), pytest.importorskip("tty")
    command = find()
    if command is None:
        refuse()
    main = tmp_path / "serial_balance.c"
    main.write_text(serial_main(FIRMWARE), "utf-8")
    program = tmp_path / "board"
    run(*command, *FLAGS, *STRICT, main, source(tmp_path), "-o", program)
    ours, theirs = pty.openpty()
    tty.setraw(theirs)
    process = subprocess.Popen([program], stdin=theirs, stdout=theirs)
    yield Board(ours, FIRMWARE)
    process.kill()
    process.wait()
    os.close(ours)
    os.close(theirs)


def test_a_robot_in_the_simulator_stands_by_the_board(board):
    """Each voltage is that of the Python controller, to the last bit."""
    asked = dict(delay=0.005, seed=3, dropouts=lambda k: k % 50 == 7)
    by_board = simulate(Mip.printed(), board, 0.1, 2.0, **asked)
    by_python = simulate(Mip.printed(), FIRMWARE, 0.1, 2.0, **asked)
    assert np.array_equal(by_board.V, by_python.V)
    assert by_board.settled.all()


def test_its_faults_come_over_the_line(board):
    board.start(0.0)
    assert [float(board.step(0.0, 0.0, 1.2)[0]), int(board.fault[0])] == [0.0, 0]
    for _ in range(8):
        board.step(np.nan, 0.0)
    assert board.fault[0] == 1


def test_a_silent_board_is_named(monkeypatch):
    pty, tty = pytest.importorskip("pty"), pytest.importorskip("tty")
    monkeypatch.setattr("sosbook.pendulum.hardware.LONGEST_WAIT", 0.05)
    ours, theirs = pty.openpty()
    with pytest.raises(ValueError, match="does its port echo"):
        Board(ours, FIRMWARE).start(0.1)
    tty.setraw(theirs)
    os.set_blocking(ours, False)
    while True:  # what the echo left
        try:
            os.read(ours, 4096)
        except BlockingIOError:
            break
    os.set_blocking(ours, True)
    with pytest.raises(TimeoutError, match="serial_<name>.c"):
        Board(ours, FIRMWARE).start(0.1)
    with pytest.raises(ValueError, match="baud must be"):
        Board(os.ttyname(theirs), FIRMWARE, baud=1234)
    with pytest.raises(ValueError, match="firmware must be"):
        Board(ours, None)
    os.close(ours)
    os.close(theirs)


@pytest.mark.parametrize("target", CROSS)
def test_compilers_of_microcontrollers_take_it_without_a_warning(target, tmp_path):
    compiler, flags, precision = CROSS[target]
    if shutil.which(compiler) is None:
        pytest.skip(f"NO {compiler}: apt-get install gcc-{compiler[:-4]} brings it")
    found = [word for word in STRICT if word != "-Wfloat-equal"]
    strict = [*FLAGS, *found, *flags]
    for name, text in c_steering(STEERING, precision=precision).items():
        (tmp_path / name).write_text(text, "utf-8")
    law, out = source(tmp_path, precision), tmp_path / "a.o"
    for path in (tmp_path / "balance_steer.c", law):
        run(compiler, *strict, "-c", path, "-o", out)
    names = run(compiler.replace("gcc", "nm"), "--undefined-only", tmp_path / "a.o")
    # arithmetic of the compiler's own and copies, and nothing of a library
    assert all(
        word.split()[-1].startswith("__") or word.split()[-1] in ("memcpy", "memset")
        for word in names.splitlines()
    ), names


def test_an_avr_refuses_doubles_that_it_doesnt_have(tmp_path):
    if shutil.which("avr-gcc") is None:
        pytest.skip("NO avr-gcc: apt-get install gcc-avr brings it")
    command = ["avr-gcc", "-mmcu=atmega328p", "-std=c99", "-c", source(tmp_path)]
    done = subprocess.run(
        command,
        capture_output=True,
        text=True,
        encoding="utf-8",
        cwd=tmp_path,
        check=False,
    )
    assert done.returncode and "other digits" in done.stderr
