"""Compilers of other processors."""

import shutil
import subprocess

import pytest
from sosbook.mip import Firmware
from sosbook.mip.compiled import FLAGS
from sosbook.mip.export import Program

from sosbook.pendulum.steering import Steering
from tests.compiler import run
from tests.test_mip_export import LAWS, STRICT, write

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


@pytest.mark.parametrize("target", CROSS)
def test_compilers_of_microcontrollers_take_it_without_a_warning(target, tmp_path):
    compiler, flags, precision = CROSS[target]
    if shutil.which(compiler) is None:
        pytest.skip(f"NO {compiler}: apt-get install gcc-{compiler[:-4]} brings it")
    found = [word for word in STRICT if word != "-Wfloat-equal"]
    strict = [*FLAGS, *found, *flags]
    program = Program(FIRMWARE, precision=precision, steering=STEERING)
    law, out = write(tmp_path, program), tmp_path / "a.o"
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
    command = ["avr-gcc", "-mmcu=atmega328p", "-std=c99", "-c"]
    command.append(write(tmp_path, Program(FIRMWARE)))
    done = subprocess.run(
        command,
        capture_output=True,
        text=True,
        encoding="utf-8",
        cwd=tmp_path,
        check=False,
    )
    assert done.returncode and "other digits" in done.stderr
