"""The checker alone, in a process of its own, decides every file of book and README.

Each proof that a program makes is kept, and ``python -I checker`` is asked. The claim
of what it passes on says so: one program proves it, by an enclosure. A refusal by a
theorem that a chapter's reader writes needs the reader's module, in any program.
"""

import json
import re
from collections import Counter
from pathlib import Path

import pytest

from formal import __main__ as formal
from formal import collect
from sosbook.exact.checker import CHECKER, verdict
from sosbook.exact.proof_file import ProofFile, load
from tests.processes import alone
from tests.test_proof_files import proof_of

ROOT = Path(__file__).resolve().parent.parent
BOOK = sorted(p.stem for p in (ROOT / "book").glob("*.ipynb"))
BY_ONE = "by an enclosure of one program:"


CLOCK = "T", "delay"


def subject(path, *also):
    """Of which loop a file is, and of which clock, if it is ``also`` asked: a search
    makes several of one, with other clocks, too, before the file that it gives.
    """
    asked = verdict.asked_of(json.loads(path.read_text("utf-8")))
    return json.dumps([asked.get(x) for x in ("kind", "plant", "U", "K", *also)])


def decided(path):
    """Whether the checker alone decides a file, and says what the package says; None of
    an author's theorem, which neither knows here.
    """
    proof, done = load(path), alone(CHECKER, path)
    said = done.stdout.splitlines()
    theirs = said[0].startswith("not checked: the theorem of ")
    if theirs and not proof.proven:
        assert "import the module that defines it" in str(proof)
        return None
    if done.returncode == 3:  # of no other is a claim worded so
        assert said[0].startswith("not checked: ")
        assert BY_ONE in str(proof) and proof.examined.alone
        return False
    assert done.returncode in (0, verdict.AUTHOR), (path, done.stdout, done.stderr)
    assert BY_ONE not in str(proof) and not proof.examined.alone
    assert all(any(claim in line for line in said) for claim in proof.claims)
    return True


@pytest.fixture
def kept(tmp_path, monkeypatch):
    """A folder of all proofs that are made from now on."""
    monkeypatch.setattr(ProofFile, "of", ProofFile.of)
    collect.start(tmp_path)
    return tmp_path


@pytest.mark.slow
def test_each_file_of_the_readme_is_decided_alone(kept, capsys):
    """Its programs run, their controllers are proven, and their files are proofs."""
    names, readme = {}, (ROOT / "README.md").read_text("utf-8")
    for program in re.findall(r"```python\n(.*?)```", readme, re.DOTALL):
        exec(program, names)
    assert names["energy"].prove().proven
    for name in ("design", "robust", "sharp"):
        assert names[name].status == "feasible"
        assert names[name].certify().proven
    assert "admissible" in capsys.readouterr().out
    files = sorted(kept.glob("*.json"))
    assert {"design", "known gain", "lmi", "sampled", "delay"} <= {
        load(x).kind for x in files
    }
    alone = {x: decided(x) for x in files}
    by_one = {subject(x, *CLOCK) for x in files if not alone[x]}  # on the way
    assert by_one <= {subject(x, *CLOCK) for x in files if alone[x]}


@pytest.mark.slow
@pytest.mark.timeout(1800)
@pytest.mark.campaign  # the gate decides those of the README
@pytest.mark.parametrize("name", BOOK)
def test_each_file_of_a_chapter_is_decided_alone(name, tmp_path, monkeypatch):
    monkeypatch.setattr(formal, "BUILD", tmp_path)
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    files = formal.proofs_of(ROOT / "book" / f"{name}.ipynb")
    kept = {x: (load(x).kind, decided(x)) for x in files}
    print(f"{name}, of each kind, alone or by one program:", Counter(kept.values()))
    assert files or name != "own_plant"  # which saves one
    by_one = {subject(x) for x, (_, alone) in kept.items() if alone is False}
    assert by_one <= {subject(x) for x, (_, alone) in kept.items() if alone}


def test_a_file_that_the_checker_passes_on_is_claimed_by_one_program(tmp_path):
    """And what it refuses is no file that a test here passes over."""
    balls, own = tmp_path / "balls.json", tmp_path / "own.json"
    proof_of("by balls").save(balls)
    assert decided(balls) is False
    proof_of("an LMI of one's own").save(own)
    assert decided(own) is True
    whole = json.loads(own.read_text("utf-8"))
    row = whole["point"]["X.1"][0]
    row[0] = f"-{row[0]}"
    own.write_text(json.dumps(whole), "utf-8")
    with pytest.raises(AssertionError):
        decided(own)
