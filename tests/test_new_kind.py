"""The recipe of CONTRIBUTING for a kind of proof, run as it stands there."""

import re
import sys

import numpy as np
import pytest

from sosbook import proofs
from sosbook.__main__ import main as program
from sosbook.exact.checker.verdict import AUTHOR
from sosbook.proofs import ProofFile, command
from tests.processes import alone, process
from tests.test_rooms import CONTRIBUTING

RECIPE = CONTRIBUTING.partition("## A new kind of proof")[2]
CODE = re.search(r"```python\n(.*?)```", RECIPE, re.S)[1]


@pytest.fixture
def recipe(tmp_path, monkeypatch):
    """What the recipe defines; its file lies in ``tmp_path``."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(ProofFile, "_owners", {**ProofFile._owners})
    names = {"__name__": "recipe"}
    exec(CODE, names)
    return names


def test_its_file_is_read_again(recipe, tmp_path):
    proof, again = recipe["proof"], proofs.load(tmp_path / "falling.json")
    assert type(again) is recipe["FallingProof"] and again == proof and again.verify()
    assert again.statement == ("x+ = [[0.5, 1.0], [0.0, -0.5]] x ends at zero",)
    A, P = np.array([[0.5, 1.0], [0.0, -0.5]]), again.values["P"]
    assert min(map(np.min, map(np.linalg.eigvalsh, (P, P - A.T @ P @ A)))) > 0
    assert "lmi, falling" in proofs.kinds()


@pytest.mark.parametrize("rho", [0.99, 1.01])
def test_it_proves_what_eigenvalues_say(recipe, rho):
    A = rho * np.array([[0.6, -0.8], [0.8, 0.6]])  # all |s| = rho
    proof = recipe["falling"](A)
    assert proof is None if rho > 1 else proof.proven


def test_the_checker_says_whose_word_it_is(recipe, tmp_path, capsys):
    file = tmp_path / "falling.json"
    words = "which say, by their author's word alone: \"x+ = [[0.5, 1.0]"
    done = alone(proofs.CHECKER, file)
    assert done.returncode == AUTHOR and words in done.stdout
    for verify in program, command.main:
        assert verify(["verify", str(file)]) == AUTHOR
        assert words in capsys.readouterr().out


@pytest.mark.parametrize("old, new", [(" > 0", " >= 0"), ('X.1":[["', 'X.1":[["-')])
def test_a_changed_file_proves_nothing(old, new, recipe, tmp_path):
    file, text = tmp_path / "falling.json", recipe["proof"].text
    assert old in text
    file.write_text(text.replace(old, new), "utf-8")
    assert not proofs.load(file).proven
    assert alone(proofs.CHECKER, file).returncode == 1


def test_nobody_takes_a_kind_of_another(recipe):
    mine = recipe["FallingProof"]
    for kind in ("design", "lmi", "infeasible delay", "lmi, falling"):
        with pytest.raises(ValueError, match="kind = .* is that of"):
            type("Mine", (mine,), {"kind": kind})


@pytest.mark.parametrize("options", [(), ("--time-limit", "20")])
def test_both_ways_of_verify_say_the_same_without_the_authors_module(
    options, recipe, tmp_path
):
    """A long file, or an option, has the package decide in place of the kernel."""
    words = [sys.executable, "-m", "sosbook", "verify", tmp_path / "falling.json"]
    done = process(*words, *options)
    assert done.returncode == AUTHOR and "by their author's word alone" in done.stdout
    text = recipe["proof"].text.replace("lmi, falling", "lmy, falling")
    (tmp_path / "falling.json").write_text(text, "utf-8")
    assert program(["verify", str(tmp_path / "falling.json"), *options]) == 2
