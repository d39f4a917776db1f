"""Other programs, as tests call them."""

import subprocess
import sys


def process(*command, **more):
    """A finished process, with what it wrote as text."""
    words = [str(word) for word in command]
    options = dict(capture_output=True, encoding="utf-8", check=False) | more
    return subprocess.run(words, **options)


def alone(*words, **more):
    """A finished process of Python without site-packages."""
    return process(sys.executable, "-I", "-S", *words, **more)
