"""A C compiler for generated code; standard library only, for ``tasks.py``."""

import os
import shlex
import shutil
import subprocess
import sys

from tests.browser import apt_install, is_root, output
from tests.processes import process

NAMES = ("cc", "gcc", "clang")
CHAPTERS = ("25_program.ipynb",)  # they run a compiler
MISSING = """\
No C compiler was found. The tests of the generated code need one. Any of
these will do:
  apt-get install gcc libc6-dev                (Debian and Ubuntu, as root)
  xcode-select --install                       (macOS)
  .venv/bin/python -m pip install ziglang      (anywhere)
"""


def find(python=sys.executable):
    """Command of a C compiler that runs: ``$CC``, of the PATH, of ziglang, or None."""
    places = [split(os.environ.get("CC", ""))]
    places += [[path] for name in NAMES if (path := shutil.which(name))]
    places.append([python, "-m", "ziglang", "cc"])
    return next((c for c in places if c and output(*c, "--version")), None)


def split(command, system=os.name):
    """Words of a command; Windows writes paths with backslashes."""
    if system != "nt":
        return shlex.split(command)
    return [word.strip('"') for word in shlex.split(command, posix=False)]


def ensure(python=sys.executable):
    """Command of a C compiler, installed if need be, or None."""
    if command := find(python):
        return command
    if is_root() and shutil.which("apt-get"):
        apt_install("gcc")
        apt_install("libc6-dev")
    if command := find(python):
        return command
    subprocess.run([python, "-m", "pip", "install", "ziglang"], check=False)
    return find(python)


def refuse():
    """Skip the test that has no compiler; fail it in CI."""
    import pytest

    (pytest.fail if os.environ.get("CI") else pytest.skip)(MISSING)


def run(*command, timeout=60, **more):
    """What a command that must succeed writes to its output."""
    done = process(*command, timeout=timeout, **more)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout
