"""The README's program runs, and its files are there."""

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
README = (ROOT / "README.md").read_text()


def test_the_program_in_the_readme_designs_a_proven_controller():
    (program,) = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    names = {}
    exec(program, names)
    assert names["design"].status == "feasible"
    assert names["design"].certify().proven


def test_files_that_the_readme_names_exist():
    targets = re.findall(r"\]\(([\w./-]+)\)", README)
    assert len(targets) >= 5
    for target in targets:
        assert (ROOT / target).exists(), target


def test_the_readme_names_the_two_commands():
    assert "python3 tasks.py book" in README
    assert "python3 tasks.py test" in README
