"""A room can be taken away: the core needs none of those that are optional."""

import json
import os
import shutil
import sys
from pathlib import Path

import flint
import numpy as np
import pytest
import scipy

import sosbook as sos
from tests.cases import campaign, later
from tests.processes import compiled, process
from tests.test_rooms import OPTIONAL

PACKAGE = Path(sos.__file__).parent
LIBRARIES = {str(Path(m.__file__).parents[1]) for m in (np, scipy, flint)}
ALL = "all of them"
CART = sos.SecondOrderSystem(1, 1, 1, 1)
MISSES = {  # a line that needs the room
    "delay": "sos.design_delay_pid(one, tau=1)",
    "structured": "sos.design_pid(one, law=law, gamma=9)",
    "sampled": "d.controller(T=0.1)",
    "controllers": "d.controller(T=0.1)",
    "pendulum": "sos.pendulum.Mip",
    "book": "sos.book.plots",
}
FILES = {  # a proof that only the room reads
    "delay": lambda: sos.design_delay_pid(CART, tau=0.1).certify(),
    "structured": lambda: (
        sos.design_pid(
            CART, law=sos.PIDLaw(position=[[1]]), region=sos.PoleRegion(sigma=1)
        ).infeasibility
    ),
    "sampled": lambda: sos.certify_sampled(CART, [[-1, -1]], T=0.1),
}
CORE = """
import json, sys, numpy as np, sosbook as sos
from sosbook.proofs import ProofFile, command, load
from sosbook.requirements import Requirement

for base, kind in ((ProofFile, "delay"), (ProofFile, "sum of poles"),
                   (ProofFile, "sampled"), (Requirement, "h2")):
    try:  # its owner isn't imported yet, or isn't there
        type("Mine", (base,), {"kind": kind})
    except ValueError as fault:
        assert f"kind = {kind!r} is that of sosbook." in str(fault)
    else:
        raise AssertionError(kind)

def proven(proof, file):
    proof.save(file)
    again = load(file)
    assert again.verify() and again.claims == proof.claims and again.claims
    assert command.main(["verify", file]) == 0

# Example 1, with masses of 1 to 2, and a regulator of it
example = sos.Polytope([
    sos.SecondOrderSystem([[m, 0], [0, 1]], [[1, -1], [-1, 1]], [[2, -1], [-1, 1]],
                          np.eye(2), np.eye(2)) for m in (1, 2)])
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
MISSED = """
try:
    {}
except ModuleNotFoundError as missing:
    print("missed:", missing.name, "by", missing)
"""
ASKED = """
code = command.main(["design", "asked.json", "--out", "folder"])
print("asked:", code)
"""
STARTS = {  # a process, and how many modules of the package it may load
    "import sosbook": 1,
    """
from sosbook.__main__ import main
assert main(["verify", "proof.json"]) == 0
""": 21,
    """
import numpy, scipy.linalg, flint
before = {*sys.modules}
import sosbook as sos
M, D, S = ([[m, 0], [0, 1]] for m in (1, 2)), [[1, -1], [-1, 1]], [[2, -1], [-1, 1]]
I = [[1, 0], [0, 1]]
example = sos.Polytope([sos.SecondOrderSystem(m, D, S, I, I) for m in M])
assert sos.design_pid(example, gamma=0.5).K is not None
""": 121,
}
COUNTED = """
new = {m for m in {*sys.modules} - before if m.partition(".")[0] not in ready}
own = {m for m in new if f"{m}.".startswith("sosbook.")}
print(len(own), *sorted(new - own))
"""


def copied(folder, without):
    """The package in a ``folder``, but for some of its files and folders."""
    gone = {PACKAGE / path for path in without}
    shutil.copytree(
        PACKAGE,
        folder / "sosbook",
        ignore=lambda place, names: [
            x for x in names if x == "__pycache__" or Path(place, x) in gone
        ],
    )
    compiled(folder / "sosbook", PACKAGE)
    return folder


def run(folder, code, find=None):
    """What Python prints that finds the package in a ``folder`` and nowhere else."""
    paths = os.pathsep.join([str(find or folder), *LIBRARIES])
    env = os.environ | {"PYTHONPATH": paths, "PYTHONDONTWRITEBYTECODE": "1"}
    words = [sys.executable, "-S", "-W", "error", "-c", code]  # -S: no editable install
    done = process(*words, env=env, cwd=folder)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.slow
@pytest.mark.parametrize("name", [ALL, *campaign(OPTIONAL)])
def test_the_core_needs_no_optional_room(name, tmp_path):
    away = [*OPTIONAL] if name == ALL else [name]
    folder = copied(tmp_path, [x for room in away for x in OPTIONAL[room]])
    code = CORE
    for room in away:
        code += MISSED.format(MISSES[room])
        if room in FILES:
            FILES[room]().save(folder / f"{room}.json")
            code += f'print("read:", command.main(["verify", "{room}.json"]))\n'
    if {"sampled", "controllers"} & {*away}:
        plant = {"M": [[1]], "D": [[1]], "S": [[1]], "B": [[1]]}
        asked = {"plant": plant, "region": {"sigma": 1}, "controller": {"T": 0.01}}
        (folder / "asked.json").write_text(json.dumps(asked), "utf-8")
        code += ASKED
    printed = run(folder, code).splitlines()
    missed = [line.split(" ", 3) for line in printed if line.startswith("missed:")]
    assert len(missed) == len(away), printed
    homes = [f"sosbook.{x}".replace("/", ".") for r in away for x in OPTIONAL[r]]
    for _, module, _, words in missed:
        assert any(f"{module}.".startswith(f"{home}.") for home in homes)
        assert f"needs {module}, which isn't there" in words
    codes = [line.split()[1] for line in printed if line[:6] in ("read: ", "asked:")]
    assert {*codes} <= {"3"} and len(codes) == code.count("command.main") - 1, printed


@pytest.mark.slow
@pytest.mark.parametrize("start", STARTS, ids=("import", "verify", "first design"))
def test_a_start_loads_few_modules_and_no_library_that_it_does_without(start, tmp_path):
    proof = sos.design_pid(CART, region=sos.PoleRegion(sigma=0.1)).certify()
    proof.save(tmp_path / "proof.json")
    code = "import sys; ready, before = sys.stdlib_module_names, {*sys.modules}\n"
    told = run(tmp_path, code + start + COUNTED, PACKAGE.parent).splitlines()
    count, *libraries = told[-1].split()
    assert int(count) <= STARTS[start] and not libraries, told[-1]


@pytest.mark.parametrize(
    ("program", "away"),
    [
        ("pendulum", "pendulum"),
        *later(("pendulum", "sampled/system.py")),
        ("book.notebooks", "book"),
    ],
)
def test_a_program_says_which_room_is_missing(program, away, tmp_path):
    """All of the room, or another that it needs."""
    folder = copied(tmp_path, [away])
    paths = os.pathsep.join([str(folder), *LIBRARIES])
    words = sys.executable, "-S", "-m", f"sosbook.{program}", "--help"
    done = process(*words, env=os.environ | {"PYTHONPATH": paths}, cwd=folder)
    module = f"sosbook.{away.removesuffix('.py').replace('/', '.')}"
    assert done.returncode == 3, done.stderr
    assert f"needs {module}, which isn't there" in done.stderr
    assert "Traceback" not in done.stderr


PAGES = """
from sosbook.book import counterexamples, elements, plots, reproduction, tables, thesis
from sosbook.book.elements import movers
assert plots.pole_map and elements.bench and movers.centre and thesis.example_1
for index, name in (
    (plots, "root_map"), (elements, "delay_atlas"), (movers, "fall"),
    (reproduction, "errata"), (sos, "design_sampled"), (sos.theorems, "unseen"),
):
    try:
        getattr(index, name)
    except ModuleNotFoundError as missing:
        print(missing.name)
"""


@pytest.mark.slow
def test_pages_of_other_rooms_need_no_optional_one(tmp_path):
    gone = [x for room, paths in OPTIONAL.items() if room != "book" for x in paths]
    printed = run(copied(tmp_path, gone), "import sosbook as sos" + PAGES).split()
    rooms = "delay", "delay", "pendulum", "delay", "controllers", "synthesis.structured"
    assert printed == [f"sosbook.{room}" for room in rooms]
