"""A Chromium for the browser tests: find one that runs, or get one.

Standard library only, because ``tasks.py`` uses it before the project's
environment is ready.
"""

import os
import shutil
import subprocess
import sys

NAMES = ("chromium", "chromium-browser", "google-chrome", "chrome")
MISSING = """\
No Chromium was found. The browser tests need one. Any of these will do:
  apt-get install chromium                     (Debian, as root)
  snap install chromium                        (Ubuntu)
  .venv/bin/playwright install chromium        (anywhere)
"""
ASK = """
from playwright.sync_api import sync_playwright
with sync_playwright() as playwright:
    print(playwright.chromium.executable_path)
"""


def find(python=sys.executable, system=os.name):
    """Path of a Chromium on the PATH or of playwright's own, or None."""
    own = output(python, "-c", ASK)
    if system == "nt":  # there a Chromium that is asked for its version opens a window
        return own if own and os.path.isfile(own) else None
    places = [path for name in NAMES if (path := shutil.which(name))]
    return next(
        (path for path in [*places, own] if path and output(path, "--version")), None
    )


def output(*command):
    """What a command prints, or None where it fails or does not exist."""
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, encoding="utf-8", check=True
        )
    except (OSError, subprocess.CalledProcessError):
        return None
    return done.stdout.strip()


def is_root():
    return hasattr(os, "geteuid") and os.geteuid() == 0


def ensure(python=sys.executable):
    """Path of a Chromium, installed if need be, or None."""
    if path := find(python):
        return path
    if is_root() and shutil.which("apt-get"):
        apt_install("chromium")
    if path := find(python):
        return path
    extra = ["--with-deps"] if is_root() else []
    subprocess.run(
        [python, "-m", "playwright", "install", *extra, "chromium"], check=False
    )
    return find(python)


def apt_install(package):
    """Install a Debian package; silent about failure, the caller looks."""
    quiet = dict(os.environ, DEBIAN_FRONTEND="noninteractive")
    for words in (["update"], ["install", "-y", "--no-install-recommends", package]):
        subprocess.run(["apt-get", *words], env=quiet, check=False)


def options(path):
    """Keyword arguments for ``playwright.chromium.launch``."""
    sandbox = ["--no-sandbox"] if is_root() else []
    return {"executable_path": path, "args": [*sandbox, "--disable-dev-shm-usage"]}
