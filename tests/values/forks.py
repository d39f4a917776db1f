"""Kernels as forks of one process that has the libraries already.

Each notebook has a kernel of its own, and half of what most kernels do is to import
numpy, scipy, matplotlib and python-control. As a program this file imports them once
and forks for each line that it reads; a fork becomes a kernel as any other, with an
empty namespace and the folder that it is given. A kernel that is wanted in another
environment, such as one with other roundings, is a program of its own.
"""

import contextlib
import gc
import importlib
import io
import json
import os
import runpy
import signal
import subprocess
import sys
import time
from functools import cache

__all__ = ["forked", "server"]

LIBRARIES = ("ipykernel.kernelapp", "matplotlib.pyplot", "control", "sympy")
PACKAGE = ("design_pid", "plots", "widgets", "sampled", "delay", "maps", "reproduction")


def forked(launch):
    """Have jupyter_client's launcher fork kernels of this Python, on Linux."""

    def launch_or_fork(command, *, cwd=None, env=None, **options):
        program, _, module, *words = [x for x in command if not x.startswith("-X")]
        ours = program == sys.executable and module == "ipykernel_launcher"
        if not ours or sys.platform != "linux":
            return launch(command, cwd=cwd, env=env, **options)
        place, names = str(cwd or os.getcwd()), env or {**os.environ}
        parent, began = server()
        if surroundings(names) != began:
            return launch(command, cwd=cwd, env=env, **options)
        parent.stdin.write(json.dumps([words, place, names]) + "\n")
        parent.stdin.flush()
        return Kernel(int(parent.stdout.readline()))

    return launch_or_fork


@cache
def server():
    """This file as a program, which ends when its input does; in which surroundings."""
    pipes = dict(stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    command = (sys.executable, "-P", __file__)
    program = subprocess.Popen(command, **pipes, encoding="utf-8")
    return program, surroundings(os.environ)


def surroundings(environment):
    """What libraries may read as they are imported: all but the tests' own notes."""
    notes = "PYTEST_", "JPY_"
    return {k: v for k, v in environment.items() if not k.startswith(notes)}


class Kernel:
    """What jupyter_client asks of a process that is somebody else's child."""

    stdin = stdout = stderr = None

    def __init__(self, pid):
        self.pid = pid

    def poll(self):
        try:
            os.kill(self.pid, 0)
        except ProcessLookupError:
            return 0

    def wait(self):
        while self.poll() is None:
            time.sleep(0.01)
        return 0

    def send_signal(self, number):
        with contextlib.suppress(ProcessLookupError):
            os.kill(self.pid, number)

    def terminate(self):
        self.send_signal(signal.SIGTERM)

    def kill(self):
        self.send_signal(signal.SIGKILL)


def prepare():
    """Import, as a kernel does; what an import would print in a notebook is a fault."""
    os.environ.setdefault("MPLBACKEND", "module://matplotlib_inline.backend_inline")
    with contextlib.ExitStack() as stack:
        said = io.StringIO()
        stack.enter_context(contextlib.redirect_stdout(said))
        stack.enter_context(contextlib.redirect_stderr(said))
        for name in LIBRARIES:
            importlib.import_module(name)
        sos = importlib.import_module("sosbook")
        for name in PACKAGE:
            getattr(sos, name)
    assert not said.getvalue(), said.getvalue()
    gc.freeze()


def serve():
    """Fork for each line; nobody waits for the children, and ^C is for the tests."""
    prepare()
    ignored = signal.SIGCHLD, signal.SIGINT
    usual = [signal.signal(number, signal.SIG_IGN) for number in ignored]
    for line in sys.stdin:
        if os.fork() == 0:
            for number, handler in zip(ignored, usual):
                signal.signal(number, handler)
            return become_kernel(*json.loads(line))


def become_kernel(words, cwd, env):
    """Run ipykernel's launcher in a session of its own, once its number is told."""
    os.setsid()
    print(os.getpid(), flush=True)
    nothing = os.open(os.devnull, os.O_RDWR)
    for stream in range(3):
        os.dup2(nothing, stream)
    os.chdir(cwd)
    os.environ.clear()
    os.environ.update(env, JPY_PARENT_PID=str(os.getppid()))
    sys.argv = ["ipykernel_launcher", *words]
    runpy.run_module("ipykernel_launcher", run_name="__main__", alter_sys=True)


if __name__ == "__main__":
    serve()
