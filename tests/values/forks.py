"""Kernels of tested notebooks, as forks of one process that has the libraries.

Each notebook has a kernel of its own, which takes two seconds to import what all of
them import. As a program this file imports the libraries once, and forks for each line
that it reads. A fork becomes a kernel as any other, with an empty namespace, without
the package, in the folder that it is given.
"""

import atexit
import ctypes
import gc
import importlib
import json
import os
import runpy
import signal
import subprocess
import sys
import time
from functools import cache

LIBRARIES = (
    "ipykernel.kernelapp ipykernel.debugger ipywidgets matplotlib.pyplot "
    "matplotlib.backends.backend_svg control scipy.optimize cvxpy flint joblib "
    "tqdm.auto"
)
SUBREAPER = 36  # of prctl: orphans below this process become its children


def forked(launch):
    """Have jupyter_client's launcher fork kernels of this Python and environment, on
    Linux.
    """

    def launch_or_fork(command, *, cwd=None, env=None, **options):
        program, *words = [x for x in command if not x.startswith("-X")]
        ours = program == sys.executable and words[:2] == ["-m", "ipykernel_launcher"]
        names = {"JPY_PARENT_PID": str(os.getpid()), **(env or os.environ)}
        mine = {x for x, _ in names.items() ^ os.environ.items() if x[:4] != "JPY_"}
        if not ours or mine or sys.platform != "linux":  # libraries read them at start
            return launch(command, cwd=cwd, env=env, **options)
        return Kernel([words[2:], str(cwd or os.getcwd()), names])

    return launch_or_fork


@cache
def server():
    """This file as a program, which ends when its input does."""
    pipes = dict(stdin=subprocess.PIPE, stdout=subprocess.PIPE, encoding="utf-8")
    program = subprocess.Popen([sys.executable, "-P", __file__], **pipes)
    atexit.register(program.__exit__, None, None, None)  # its pipes close, and it ends
    return program


class Kernel:
    """A fork that this process adopted, with what jupyter_client asks of a process."""

    stdin = stdout = stderr = returncode = None

    def __init__(self, asked):
        program, prctl = server(), ctypes.CDLL(None).prctl
        prctl(SUBREAPER, 1, 0, 0, 0)
        program.stdin.write(json.dumps(asked) + "\n")
        program.stdin.flush()
        self.pid = int(program.stdout.readline())
        prctl(SUBREAPER, 0, 0, 0, 0)

    def poll(self, options=os.WNOHANG if sys.platform != "win32" else 0):
        if self.returncode is None:
            pid, status = os.waitpid(self.pid, options)
            if pid:
                self.returncode = os.waitstatus_to_exitcode(status)
        return self.returncode

    def wait(self):
        return self.poll(0)

    def send_signal(self, number):
        if self.poll() is None:
            os.kill(self.pid, number)

    def terminate(self):
        self.send_signal(signal.SIGTERM)

    def kill(self):
        self.send_signal(signal.SIGKILL)


def serve():
    """Import what a kernel does, and fork twice for each line: an orphan is adopted."""
    os.environ["MPLBACKEND"] = "module://matplotlib_inline.backend_inline"
    os.environ["PYDEVD_DISABLE_FILE_VALIDATION"] = "1"  # no word of frozen modules
    for name in LIBRARIES.split():
        importlib.import_module(name)
    begin_letters()
    gc.freeze()
    gc.set_threshold(100_000)  # as in conftest.py
    for line in sys.stdin:
        if os.fork() == 0:
            parent = os.getpid()
            if os.fork():
                os._exit(0)
            while os.getppid() == parent:
                time.sleep(0.001)
            return become_kernel(*json.loads(line))
        os.wait()


def begin_letters():
    """Have matplotlib find its font and make the reader of its formulas: a kernel's
    first figure takes half as long again as the next ones.
    """
    from matplotlib.font_manager import FontProperties
    from matplotlib.mathtext import MathTextParser

    MathTextParser("path").parse("$x_1$", prop=FontProperties(family="DejaVu Sans"))


def become_kernel(words, cwd, env):
    """Run ipykernel's launcher in a session of its own, once its number is told."""
    os.setsid()
    print(os.getpid(), flush=True)
    nothing = os.open(os.devnull, os.O_RDWR)
    for stream in range(3):
        os.dup2(nothing, stream)
    os.chdir(cwd)
    os.environ.clear()
    os.environ.update(env)
    sys.argv = ["ipykernel_launcher", *words]
    runpy.run_module("ipykernel_launcher", run_name="__main__", alter_sys=True)


if __name__ == "__main__":
    serve()
