"""A room can be taken away: the core needs none of those that are optional."""

import os
import shutil
import sys
from pathlib import Path

import flint
import numpy as np
import pytest
import scipy

import sosbook as sos
from tests.processes import process

PACKAGE = Path(sos.__file__).parent
LIBRARIES = {str(Path(m.__file__).parents[1]) for m in (np, scipy, flint)}
# What a room is, and what misses it: a line of code, or a command's proof file.
OPTIONAL = {
    "delay": (["delay"], "sos.design_delay_pid(one, tau=1)"),
    "law": (["synthesis/structured"], "sos.design_pid(one, law=law, gamma=9)"),
    "run": (["sampled", "controllers"], "d.controller(T=0.1)"),
    "robot": (["pendulum"], "sos.pendulum.Mip"),
    "book": (["book"], "sos.book.plots"),
}
ALL = "all of them"
CORE = """
import sys, numpy as np, sosbook as sos
from sosbook.proofs import command, load

def proven(proof, file):
    proof.save(file)
    again = load(file)
    assert again.verify() and again.claims == proof.claims and again.claims
    assert command.main(["verify", file]) == 0

def modules():
    return {m for m in sys.modules if m.partition(".")[0] == "sosbook"}

# Example 1, with masses of 1 to 2, and a regulator of it
example = sos.Polytope([
    sos.SecondOrderSystem([[m, 0], [0, 1]], [[1, -1], [-1, 1]], [[2, -1], [-1, 1]],
                          np.eye(2), np.eye(2)) for m in (1, 2)])
first = sos.design_pid(example, gamma=0.5)
proven(first.certify(), "first.json")
counted = sorted(modules()), sorted(m for m in sys.modules if m.startswith("scipy."))
d = sos.design_pid(example, gamma=0.5, U=[[1, 0], [0, 1]],
                   region=sos.PoleRegion(sigma=0.5, theta_deg=60, rho=20))
proven(d.certify(), "design.json")
zero, one = np.zeros((2, 2)), np.eye(2)
for p in example.vertices:  # u = K_P z + K_D z' + K_I x3, x3' = z
    accelerated = np.linalg.solve(
        p.M, np.hstack([d.K_P - p.S, d.K_D - p.D, d.K_I]))
    loop = np.block([[zero, one, zero], [accelerated], [one, zero, zero]])
    assert (np.linalg.eigvals(loop).real < -0.5).all()
kept = sos.analyse_pid(example, d.K, U=[[1, 0], [0, 1]], requirements=[sos.H2(5.0)])
proven(kept.certify(), "kept.json")
none = sos.design_pid(example, gamma=1e-9, saturation=sos.Saturation(1, [1, 0, 0, 0]))
assert none.status == "infeasible"
proven(none.infeasibility, "none.json")
one = example.vertices[0]
law = sos.PIDLaw(position=[[1, 0], [0, 1]], filter=0.1)
"""


def copied(folder, without):
    """The package in a ``folder``, but for some of its folders."""
    gone = {PACKAGE / path for path in without}
    shutil.copytree(
        PACKAGE,
        folder / "sosbook",
        ignore=lambda place, names: [
            x for x in names if x == "__pycache__" or Path(place, x) in gone
        ],
    )
    return folder


def run(folder, code):
    """What Python prints that finds the package in a ``folder`` and nowhere else."""
    paths = os.pathsep.join([str(folder), *LIBRARIES])
    env = os.environ | {"PYTHONPATH": paths, "PYTHONDONTWRITEBYTECODE": "1"}
    words = [sys.executable, "-S", "-W", "error", "-c", code]  # -S: no editable install
    done = process(*words, env=env, cwd=folder)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.slow
@pytest.mark.parametrize("name", [*OPTIONAL, ALL])
def test_the_core_needs_no_optional_room(name, tmp_path):
    away = [*OPTIONAL] if name == ALL else [name]
    missed = [OPTIONAL[room] for room in away]
    code = CORE
    for _, call in missed:
        code += f"""
try:
    {call}
except ModuleNotFoundError as missing:
    print("missed:", missing.name, missing)
"""
    printed = run(copied(tmp_path, [x for folders, _ in missed for x in folders]), code)
    words = [x for x in printed.splitlines() if x.startswith("missed:")]
    assert len(words) == len(missed), printed
    for line, (folders, _) in zip(words, missed, strict=True):
        rooms = ["sosbook." + x.replace("/", ".") for x in folders]
        assert any(line.split()[1].startswith(room) for room in rooms), line
        assert "isn't there" in line
