"""What the README names is there; `test_alone` runs its programs."""

import re
from operator import attrgetter
from pathlib import Path

import sosbook as sos

ROOT = Path(__file__).resolve().parent.parent
README = (ROOT / "README.md").read_text("utf-8")


def test_what_the_readme_names_is_there():
    named = set(re.findall(r"\bsos\.([a-zA-Z_.]+[a-zA-Z_])", README))
    assert {"Uncertain", "plants.load_plant"} <= named
    for name in named:
        attrgetter(name)(sos)
