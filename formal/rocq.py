"""Rocq with Mathematical Components: find it, get it, let it check a file.

Standard library only.
"""

import os
import re
import shutil
import subprocess
from pathlib import Path

from formal import gen

HERE = Path(__file__).resolve().parent
THEORY = (
    "integers",
    "definite",
    "region",
    "numbers",
    "mechanics",
    "descriptor",
    "forms",
    "multipliers",
    "laws",
    "sampled",
)

PACKAGES = ("coq", "libcoq-mathcomp-algebra", "libcoq-mathcomp-algebra-tactics")
MISSING = f"""\
NOTHING WAS PROVEN BY ROCQ. It isn't here, with Mathematical Components 1.15:
  apt-get install {" ".join(PACKAGES)}      (Debian 12, as root)
"""
CLOSED = "Closed under the global context"
QUIET = ("-q", "-w", "-notation-overridden,-ambiguous-paths")
SECONDS = 1800  # for one chapter: the largest takes a tenth of it


class Failed(Exception):
    """What Rocq doesn't accept."""


def find():
    """Whether there is a Rocq with Mathematical Components."""
    coqc = shutil.which("coqc")
    done = coqc and subprocess.run([coqc, "-where"], capture_output=True, text=True)
    if not done or done.returncode:
        return False
    return (
        Path(done.stdout.strip()) / "user-contrib/mathcomp/algebra_tactics"
    ).is_dir()


def ensure():
    """Whether it is there, installed if need be."""
    if not find() and shutil.which("apt-get") and os.geteuid() == 0:
        quiet = dict(os.environ, DEBIAN_FRONTEND="noninteractive")
        install = ["install", "-y", "--no-install-recommends", *PACKAGES]
        for words in (["update"], install):
            subprocess.run(["apt-get", *words], env=quiet, check=False)
    return find()


def theory(folder):
    """Compile the theorems into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in THEORY:
        shutil.copy(HERE / f"{name}.v", folder)
        compiled(folder, name)


def prove(folder, name, texts):
    """Let Rocq check what gen.py wrote, in one go; return the number of theorems.

    Raises
    ------
    Failed
        If one isn't proven, or rests on an axiom.
    """
    modules, count = [], 0
    for k, text in enumerate(texts):
        names = re.findall(r"^Theorem (\w+)", text, re.MULTILINE)
        if not names or not text.endswith(gen.END.format(", ".join(names))):
            raise Failed("a file doesn't end with all of its theorems")
        count += len(names)
        body = text.removesuffix("Print Assumptions proven.\n")
        modules.append(f"Module file_{k}.\n{body}End file_{k}.\n")
    every = ", ".join(f"file_{k}.proven" for k in range(len(texts)))
    whole = "".join(modules) + gen.END.format(every)
    (folder / f"{name}.v").write_text(whole, "utf-8")
    if compiled(folder, name).splitlines() != [CLOSED]:
        raise Failed(f"{name} rests on axioms")
    return count


def compiled(folder, name):
    """What Rocq prints of a file."""
    words = ["coqc", *QUIET, "-Q", ".", "formal", f"{name}.v"]
    try:
        done = subprocess.run(
            words, cwd=folder, capture_output=True, text=True, timeout=SECONDS
        )
    except subprocess.TimeoutExpired:
        raise Failed(f"{name}: not done within {SECONDS} s") from None
    if done.returncode:
        raise Failed(f"{name}: {done.stdout}{done.stderr}")
    return done.stdout
