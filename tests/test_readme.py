"""The README's program runs, and its files are there."""

import re
from operator import attrgetter
from pathlib import Path

import pytest

import sosbook as sos

ROOT = Path(__file__).resolve().parent.parent
README = (ROOT / "README.md").read_text("utf-8")


@pytest.mark.slow
def test_the_programs_in_the_readme_design_proven_controllers(capsys):
    names = {}
    for program in re.findall(r"```python\n(.*?)```", README, re.DOTALL):
        exec(program, names)
    assert names["energy"].prove().proven
    for name in ("design", "robust", "sharp"):
        assert names[name].status == "feasible"
        assert names[name].certify().proven
    assert "admissible" in capsys.readouterr().out


def test_what_the_readme_names_is_there():
    named = set(re.findall(r"\bsos\.([a-zA-Z_.]+[a-zA-Z_])", README))
    assert {"Uncertain", "plants.load_plant"} <= named
    for name in named:
        attrgetter(name)(sos)
