"""What static analysers say of every generated C program: once a week."""

import shutil

import pytest

from sosbook.pendulum import Firmware
from sosbook.pendulum.drive import Drive
from sosbook.pendulum.export import Program
from sosbook.pendulum.recording import recorders
from sosbook.pendulum.steering import Steering
from tests.processes import process
from tests.test_mip_export import HEADER, LAWS, STRICT, write
from tests.test_mip_robot import THESIS

pytestmark = pytest.mark.campaign


@pytest.fixture
def folder(tmp_path):
    """All C programs of a robot, with the library's header."""
    firmware = Firmware(LAWS["PID"], blend=0.02, frozen=12, deaf=25)
    drive = Drive(3.0, 5.0, 2.0, 8.0)
    steering = Steering(firmware, [[-0.93, -0.29, -0.52]], 0.25, 0.07, 0.034)
    for name, more in (("rc_balance", None), ("rc_steers", steering)):
        written = Program(firmware, robot=THESIS, drive=drive, steering=more)
        main, header = written.rc_balance.values()
        (tmp_path / f"{name}.c").write_text(main, "utf-8")
        (tmp_path / "rc_robot.h").write_text(header, "utf-8")
    for name, precision in (("balance", "double"), ("single", "single")):
        write(tmp_path, Program(firmware, name, precision, steering=steering))
    recorder = recorders(THESIS)["rc_identify.c"]
    (tmp_path / "rc_identify.c").write_text(recorder, "utf-8")
    (tmp_path / "robotcontrol.h").write_text(HEADER, "utf-8")
    return tmp_path


def silent(*command):
    done = process(*command, timeout=200)
    assert done.returncode == 0 and not done.stderr.strip(), done.stderr


def test_gccs_analyser_finds_nothing(folder):
    gcc = shutil.which("gcc")
    if gcc is None:
        pytest.skip("no gcc")
    flags = ["-std=c99", "-O2", "-fanalyzer", "-Wall", "-Wextra", "-Werror", *STRICT]
    for source in sorted(folder.glob("*.c")):
        silent(gcc, *flags, "-I", folder, "-c", source, "-o", folder / "a.o")


@pytest.fixture
def cppcheck():
    """It reads no float.h, and would stop at the first #error without a word."""
    path = shutil.which("cppcheck")
    if path is None:
        pytest.skip("no cppcheck")
    return path, "-q", "-DFLT_EVAL_METHOD=0", "-DDBL_MANT_DIG=53", "-DFLT_MANT_DIG=24"


def test_cppcheck_finds_nothing(folder, cppcheck):
    checks = "--enable=warning,performance,portability", "--error-exitcode=1"
    silent(*cppcheck, *checks, *sorted(folder.glob("*.c")))
