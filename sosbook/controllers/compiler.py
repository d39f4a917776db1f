"""The C compiler of the machine, for programs that are tried here."""

import ctypes
import importlib.util
import os
import shlex
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from ..runtime.writing import write_texts

#: Flags of the compiler: strict C99, without warnings or fused operations.
FLAGS = (
    "-std=c99",
    "-O2",
    "-ffp-contract=off",
    "-pedantic",
    "-Wall",
    "-Wextra",
    "-Werror",
)
NO_COMPILER = """\
no C compiler was found. Any of these will do:
  apt-get install gcc libc6-dev     (Debian and Ubuntu, as root)
  xcode-select --install            (macOS)
  python -m pip install ziglang     (anywhere)
or set the environment variable CC to a compiler's command"""


def compiler():
    """The command of a C compiler: $CC; else cc, gcc or clang on the PATH; else
    ziglang's. A RuntimeError without one names the ways to get it.
    """
    command = shlex.split(os.environ.get("CC", ""), posix=os.name != "nt")
    command = [word.strip('"') for word in command]
    if command and shutil.which(command[0]):
        return command
    if command:
        raise RuntimeError(
            f"CC is set to {command[0]!r}, which isn't there: {NO_COMPILER}"
        )
    for name in ("cc", "gcc", "clang"):
        if path := shutil.which(name):
            return [path]
    if importlib.util.find_spec("ziglang"):
        return [sys.executable, "-m", "ziglang", "cc"]
    raise RuntimeError(NO_COMPILER)


def build(folder, name, flags=FLAGS):
    """The shared library of <name>.c in a folder by ``flags``; a RuntimeError."""
    library = folder / f"{name}.so"
    command = [
        *compiler(),
        *flags,
        "-shared",
        "-fPIC",
        "-o",
        str(library),
        str(folder / f"{name}.c"),
    ]
    done = subprocess.run(
        command, capture_output=True, text=True, encoding="utf-8", check=False
    )
    if done.returncode:
        raise RuntimeError(
            f"the compiler refused: {shlex.join(command)}\n{done.stderr}"
        )
    return library


def loaded(name, texts, folder=None, flags=FLAGS):
    """The library of <name>.c among some ``texts``, made with ``flags`` and loaded.
    Without a ``folder`` its files are gone again at once; on Windows with the library.
    """
    place = None
    if folder is None:
        place = tempfile.TemporaryDirectory(prefix=name, ignore_cleanup_errors=True)
    try:
        write_texts(folder or place.name, texts)
        library = ctypes.CDLL(str(build(Path(folder or place.name), name, flags)))
        library.folder = place
        return library
    finally:
        if place and os.name != "nt":
            place.cleanup()
