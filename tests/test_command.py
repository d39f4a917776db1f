"""The command line: python -m sosbook verify and design."""

import json
import re
import subprocess
import sys

import pytest

from sosbook import proofs
from sosbook.proofs.command import main
from sosbook.requirements.in_files import KEYS

FOLDER = proofs.CHECKER.parent
EXAMPLE = FOLDER / "plant.example.json"


def run(*arguments):
    return subprocess.run(
        [sys.executable, "-m", "sosbook", *map(str, arguments)],
        capture_output=True,
        encoding="utf-8",
        timeout=120,
    )


@pytest.mark.slow
def test_the_example_is_designed_verified_and_checked(tmp_path):
    """Three programs, one after the other, by their exit codes."""
    file = tmp_path / "proof.json"
    done = run("design", EXAMPLE, "--proof", file)
    assert done.returncode == 0, done.stderr
    answer = json.loads(done.stdout)
    assert answer["status"] == "feasible" and answer["proven"] is True
    assert [len(answer[k][0]) for k in ("K", "K_P", "K_D", "K_I")] == [6, 2, 2, 2]
    assert min(answer["margins"].values()) > 0
    assert answer["proof"] == str(file)
    done = run("verify", file)
    assert done.returncode == 0
    assert done.stdout.splitlines()[1:] == [f"- {c}" for c in answer["claims"]]
    assert proofs.load(file).K.tolist() == answer["K"]
    file.write_text(file.read_text("utf-8").replace("1.257", "0.5"), "utf-8")
    done = run("verify", file)
    assert done.returncode == 2 and "checksum" in done.stderr


@pytest.mark.slow
def test_it_needs_no_pictures_and_no_widgets():
    code = (
        "import sys; from sosbook.proofs.command import main; "
        "print([m for m in ('matplotlib', 'ipywidgets', 'IPython', 'control', 'cvxpy')"
        " if m in sys.modules])"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, encoding="utf-8", check=True
    )
    assert done.stdout.strip() == "[]"


def plant_file(tmp_path, **changes):
    data = json.loads(EXAMPLE.read_text("utf-8")) | changes
    data = {key: value for key, value in data.items() if value is not ...}
    file = tmp_path / "plant.json"
    file.write_text(json.dumps(data), "utf-8")
    return file


def test_what_is_refused_comes_with_a_proof_too(tmp_path, capsys):
    one, proof = [[1]], tmp_path / "none.json"
    file = plant_file(
        tmp_path,
        plant={"M": one, "D": [[-1]], "S": one, "B": one},
        saturation={"u_max": 0.5, "x0": [1, 0]},
        **dict.fromkeys(("U", "region", "gamma"), ...),
    )
    assert main(["design", str(file), "--proof", str(proof)]) == 1
    answer = json.loads(capsys.readouterr().out)
    assert answer["status"] == "infeasible" and answer["proven"] is True
    assert "input bound" in answer["advice"]
    assert main(["verify", str(proof)]) == 0
    assert "no gain" in capsys.readouterr().out


WRONG = {
    "no plant": (dict(plant=...), '"plant" is missing'),
    "another key": (dict(gama=2), "'gama' isn't known"),
    "no mass": (dict(plant={"D": [[1]]}), "plant needs the keys M, D, S, B"),
    "an empty polytope": (dict(plant={"vertices": []}), "vertices is empty"),
    "a bad vertex": (
        dict(plant={"vertices": [{k: [[1]] for k in "MDSB"}, {}]}),
        r"plant.vertices\[1\] needs",
    ),
    "a bad shape": (
        dict(plant={k: [[1, 0]] for k in "MDS"} | {"B": [[1]]}),
        "plant: .* needs 1",
    ),
    "a word for a number": (dict(gamma="small"), "gamma must be"),
    "a bad region": (dict(region={"sigmma": 1}), "region: .*sigmma"),
    "an empty region": (dict(region={"sigma": 9, "rho": 1}), "region: .*empty"),
    "a number for an object": (dict(saturation=3), "saturation must be an object"),
    "a bad x0": (dict(saturation={"u_max": 1, "x0": [1]}), "x0 has 1 entries"),
    "no x0": (dict(saturation={"u_max": 1}), "saturation: .*x0"),
    "a bad coupling": (dict(coupling="all"), "coupling must be"),
}


@pytest.mark.parametrize("what", WRONG)
def test_bad_input_is_named(tmp_path, capsys, what):
    changes, words = WRONG[what]
    file = plant_file(tmp_path, **changes)
    assert main(["design", str(file), "--proof", str(tmp_path / "x")]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.startswith(f"error: {file}: ")
    assert re.search(words, said.err), said.err
    assert not (tmp_path / "x").exists()


@pytest.mark.parametrize("text", ["", "[", "[1]", "\xff"])
def test_what_is_no_json_is_said(tmp_path, capsys, text):
    file = tmp_path / "x.json"
    file.write_bytes(text.encode("latin-1"))
    assert main(["design", str(file)]) == main(["verify", str(file)]) == 2
    assert str(file) in capsys.readouterr().err
    assert main(["verify", str(tmp_path / "none.json")]) == 2


def test_schemas_name_what_the_files_hold(tmp_path):
    """The keys of the schemas, the example and a proof are the same ones."""
    schema = json.loads((FOLDER / "plant.schema.json").read_text("utf-8"))
    assert set(schema["properties"]) == {"$schema", "plant", *KEYS}
    assert json.loads(EXAMPLE.read_text("utf-8")).keys() <= set(schema["properties"])
    proof = json.loads((FOLDER / "proof.schema.json").read_text("utf-8"))
    kinds = {cls.kind for cls in proofs.kinds()}
    assert set(proof["properties"]["kind"]["enum"]) == kinds
    assert main(["design", str(EXAMPLE), "--proof", str(tmp_path / "p.json")]) == 0
    written = json.loads((tmp_path / "p.json").read_text("utf-8"))
    assert written.keys() <= set(proof["properties"])
