"""Other programs, as tests call them."""

import os
import shutil
import subprocess
import sys
from importlib.util import cache_from_source
from pathlib import Path


def process(*command, **more):
    """A finished process, with what it wrote as text."""
    words = [str(word) for word in command]
    options = dict(capture_output=True, encoding="utf-8", check=False) | more
    return subprocess.run(words, **options)


def alone(*words, **more):
    """A finished process of Python without site-packages."""
    return process(sys.executable, "-I", "-S", *words, **more)


def compiled(copy, source, beside=False):
    """Give a ``copy`` of a folder what Python has compiled of its ``source``, which
    takes a process seconds: ``beside`` the files, where ``python -I`` looks for it.
    """
    for path in copy.rglob("*.py"):
        own = source / path.relative_to(copy)
        made, to = Path(cache_from_source(own)), Path(cache_from_source(path))
        if made.exists():
            to = path.parent / "__pycache__" / to.name if beside else to
            to.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(made, to)
            os.utime(path, ns=(own.stat().st_atime_ns, own.stat().st_mtime_ns))
