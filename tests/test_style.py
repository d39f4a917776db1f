"""One style for all: what ruff says of Python, Deno and clang-format of JavaScript."""

import os
import shutil
import sys
from pathlib import Path

import pytest

from tests.processes import process

ROOT = Path(__file__).resolve().parent.parent
SCRIPTS = [
    path.relative_to(ROOT).as_posix()
    for folder in ("sosbook/book", "book/_static", "book/_ext")
    for path in sorted((ROOT / folder).rglob("*.js"))
    if "mathjax" not in path.parts
]


def run(*words):
    """What a program of the environment says of the checkout."""
    quiet = {"DENO_DIR": str(ROOT / "_build" / "deno"), "DENO_NO_UPDATE_CHECK": "1"}
    return process(*words, cwd=ROOT, env=os.environ | quiet | {"NO_COLOR": "1"})


@pytest.mark.parametrize("words", [("check",), ("format", "--check")])
def test_ruff_has_nothing_to_say(words):
    done = run(sys.executable, "-m", "ruff", *words, "--no-cache", ".")
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize(
    "words",
    [("deno", "lint"), ("deno", "check"), ("clang-format", "--dry-run", "--Werror")],
)
def test_the_scripts_have_no_fault(words):
    program = shutil.which(words[0], path=Path(sys.executable).parent)
    if program is None and not os.environ.get("CI"):
        pytest.skip(f"{words[0]} isn't installed: pip install {words[0]}")
    assert program, f"{words[0]} belongs to requirements.txt"
    done = run(program, *words[1:], *SCRIPTS)
    assert done.returncode == 0, done.stdout + done.stderr
