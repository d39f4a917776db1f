"""A Chromium for the browser tests; standard library only, for ``tasks.py``."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

#: The shell is Chromium without windows: it takes a quarter less of the processor.
SHELL = "chromium-headless-shell"
NAMES = (SHELL, "chromium", "chromium-browser", "google-chrome", "chrome")
MISSING = """\
No Chromium was found. The browser tests need one. Any of these will do:
  apt-get install chromium-headless-shell                 (Debian, as root)
  snap install chromium                                   (Ubuntu)
  .venv/bin/playwright install --only-shell chromium      (anywhere)
"""
ASK = """
from playwright.sync_api import sync_playwright
with sync_playwright() as playwright:
    print(playwright.chromium.executable_path)
"""


def find(python=sys.executable, system=os.name):
    """Path of a Chromium on the PATH or of playwright's own, or None."""
    if system == "nt":  # there a Chromium that is asked for its version opens a window
        return next(filter(os.path.isfile, owned(python)), None)
    for name in NAMES:
        if (path := shutil.which(name)) and output(path, "--version"):
            return path
    return next((path for path in owned(python) if output(path, "--version")), None)


def owned(python):
    """Where playwright keeps a headless shell of its own, and its Chromium."""
    if not (path := output(python, "-c", ASK)):
        return []
    versions = [p for p in Path(path).parents if p.name.startswith("chromium-")]
    shells = [p.with_name(p.name.replace("-", "_headless_shell-")) for p in versions]
    found = [str(x) for p in shells for x in p.glob("*/chrome-headless-shell*")]
    return [*found, path]


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
        for package in (SHELL, "chromium"):  # Ubuntu has only the second
            apt_install(package)
            if path := find(python):
                return path
    extra = ["--with-deps"] if is_root() else []
    words = ["install", *extra, "--only-shell", "chromium"]
    subprocess.run([python, "-m", "playwright", *words], check=False)
    return find(python)


def apt_install(package):
    """Install a Debian package; silent about failure, the caller looks."""
    quiet = dict(os.environ, DEBIAN_FRONTEND="noninteractive")
    for words in (["update"], ["install", "-y", "--no-install-recommends", package]):
        subprocess.run(["apt-get", *words], env=quiet, check=False)


#: It reaches no network but this machine, whose Lab the tests open. To stop each
#: request in playwright instead takes a tenth of what a page takes to load.
AWAY = "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1, EXCLUDE localhost"

#: A test's page is new, and left when most of its code has run a few hundred times:
#: to have V8 optimize it so soon takes a quarter of what a small page takes. What runs
#: much longer, as solvers do, is optimized as before.
UNHURRIED = "--js-flags=" + " ".join(
    f"--invocation-count-for-{tier}={count}"
    for tier, count in {"maglev": 3000, "turbofan": 20000}.items()
)


def options(path):
    """Keyword arguments for ``playwright.chromium.launch``."""
    sandbox = ["--no-sandbox"] if is_root() else []
    words = [*sandbox, "--disable-dev-shm-usage", AWAY, UNHURRIED]
    return {"executable_path": path, "args": words}
