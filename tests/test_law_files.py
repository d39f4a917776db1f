"""A law as a field of a plant file: the words and verdicts are those of the package."""

import json
from inspect import signature
from pathlib import Path

import numpy as np
import pytest

import sosbook as sos
from sosbook.proofs.command import main
from tests.cases import campaign

PAGE = Path(__file__).parents[1] / "book" / "api" / "proofs.md"
CARTS = {
    "vertices": [
        {"M": [[0.3, 0], [0, m]], "D": [[0.2, -0.1], [-0.1, 0.1]],
         "S": [[9.81, -9.81], [-9.81, 9.81]], "B": [[1], [0]], "F": [[0], [1]]}
        for m in (0.5, 0.7)
    ]
}  # fmt: skip
plants = sos.Polytope([sos.SecondOrderSystem(**v) for v in CARTS["vertices"]])


@pytest.fixture
def ask(tmp_path, capsys):
    """Design for a file's text or data: the exit code, the answer, errors and files."""

    def ask(asked, name="plant.json"):
        file, proof = tmp_path / name, tmp_path / "proof.json"
        file.write_text(asked if isinstance(asked, str) else json.dumps(asked), "utf-8")
        code = main(["design", str(file), "--proof", str(proof), "--force"])
        out, err = capsys.readouterr()
        return code, json.loads(out) if out else None, err, file, proof

    return ask


def test_the_manual_s_file_is_the_package_s_design(ask):
    text = PAGE.read_text("utf-8").split("```toml\n")[1].split("```")[0]
    code, answer, _, file, proof = ask(text, "plant.toml")
    drive = sos.plants.load_plant(file)
    sensors = {"position": [[1, 0]], "filter": 0.01, "integrate": True}
    law = sos.PIDLaw(**sensors, limits={"K_P": 20, "K_D": 1})
    seen = sos.Output(position=[[0, 1]]) & sos.Output(input=0.01)
    theirs = sos.design_pid(
        drive, law=law, maximize="sigma", requirements=[sos.HInfinity(1, outputs=seen)]
    )
    assert code == 0 and answer["claims"] == list(theirs.certify().claims)
    for name, gain in theirs.gains.items():
        assert answer[name] == gain.tolist()
    verify = ["verify", str(proof), "--plant", str(file)]
    assert main(verify) == 0
    file.write_text(text.replace("0.01   ", "0.02   "), "utf-8")
    assert main(verify) == 1
    file.write_text(text.replace("[law]", "[other]"), "utf-8")
    assert main(verify) == 1


@pytest.mark.parametrize("memory", [{"filter": 0.05}, {"order": 1}])
def test_the_plant_of_a_law_s_proof_may_have_ranges(ask, memory):
    plant = {"parameters": {"m": [1, 2]}, "M": [["m"]], "D": [[0.5]], "S": [[1]]}
    asked = {"plant": plant | {"B": [[1]]}, "law": {"position": [[1]]} | memory}
    code, answer, _, file, proof = ask(
        asked | {"region": {"sigma": 0.1}, "search": {"starts": 2}}
    )
    assert code == 0 and "every constant plant with m in [1, 2]" in answer["claims"][0]
    verify = ["verify", str(proof), "--plant", str(file)]
    assert main(verify) == 0
    file.write_text(file.read_text("utf-8").replace("[1, 2]", "[1, 3]"), "utf-8")
    assert main(verify) == 1


VERDICTS = {  # rows, memory, decay
    "feasible": (dict(position=[[1, 0]], filter=0.02), 0.3),
    "infeasible": (dict(position=[[0, 1]], velocity=[[0, 1]]), 0.5),
    "undecided": (dict(position=[[0, 1]], velocity=[[0, 1]]), 0.2),
}


@pytest.mark.parametrize(  # test_command has an undecided request
    "status", ["feasible", "infeasible", *campaign(["undecided"])]
)
def test_the_three_verdicts_are_those_of_the_package(ask, status):
    law, sigma = VERDICTS[status]
    asked = {
        "plant": CARTS,
        "law": law,
        "region": {"sigma": sigma},
        "search": {"starts": 1},
    }
    code, answer, _, _, proof = ask(asked)
    region = sos.PoleRegion(sigma=sigma)
    theirs = sos.design_pid(
        plants, law=sos.PIDLaw(**law), region=region, search=sos.Search(starts=1)
    )
    assert answer["status"] == theirs.status == status
    assert answer["reason"] == theirs.reason and code == (status != "feasible")
    assert answer["proven"] is (status != "undecided") is proof.exists()
    if status != "feasible":
        assert answer["advice"] == theirs.advice
        assert answer["advice"].endswith("Measure more, or ask for less.")
    else:
        K = (
            sos.PIDLaw(**law)
            .applied(plants)
            .gain({k: answer[k] for k in ("K_P", "K_D")})
        )
        loop = sos.analyse_pid(plants, K, law=sos.PIDLaw(**law))
        assert np.real(np.ravel(loop.poles())).max() < -sigma


def test_memory_of_its_own_and_shared_gains(ask):
    law = {"order": 1, "position": [[1, 0]], "velocity": [[1, 0]]}
    code, answer, _, _, _ = ask({"plant": CARTS, "law": law, "search": {"starts": 2}})
    assert code == 0 and len(answer["A_c"]) == 1 and len(answer["B_c"][0]) == 2
    law = {"position": [[1, 0], [0, 1]], "velocity": [[1, 0]]}
    law["structure"] = {"K_P": [["a", "a"]]}
    code, answer, _, _, _ = ask({"plant": CARTS, "law": law, "search": {"starts": 2}})
    assert code == 0 and answer["K_P"][0][0] == answer["K_P"][0][1] != 0


SEEN = {"position": [[1, 0]]}
WRONG = {  # what is given, and the words of the error
    "no object": ({"law": 3}, "law must be an object"),
    "no sensor": ({"law": {"filter": 1}}, "law: position is missing: say what is"),
    "misspelt": ({"law": {"positon": [[1, 0]]}}, "law: 'positon' isn't known: its"),
    "no row": ({"law": {"position": []}}, "law: position"),
    "blind": ({"law": {"position": [[0, 0]]}}, "law: position: row 1 is zero"),
    "too wide": ({"law": {"position": [[1, 0, 0]]}}, "position has rows of width 3"),
    "a word": ({"law": {"position": "z1"}}, "law: position"),
    "no time": ({"law": SEEN | {"filter": 0}}, "law: filter must be"),
    "no truth": ({"law": SEEN | {"integrate": None}}, "law: integrate must be"),
    "nothing free": ({"law": SEEN | {"structure": [[0]]}}, "no gain free"),
    "its shape": ({"law": SEEN | {"structure": [[1, 1]]}}, "law: structure: K_P is"),
    "no such gain": ({"law": SEEN | {"limits": {"K_I": 1}}}, "law: limits: the law"),
    "no limit": ({"law": SEEN | {"limits": {"K_P": -1}}}, "law: limits['K_P'] must"),
    "limits": ({"law": SEEN | {"limits": [1]}}, "law: limits must be a dict"),
    "noise": ({"law": SEEN | {"noise": [[1, 2]]}}, "law: noise has 2 columns"),
    "order": ({"law": SEEN | {"order": 0}}, "law: order is 0: a DynamicLaw"),
    "order's word": ({"law": SEEN | {"order": "two"}}, "law: order must be"),
    "filter of memory": ({"law": SEEN | {"order": 1, "filter": 1}}, "law: 'filter'"),
    "both": ({"law": SEEN, "U": [[1, 0]]}, "law and U are given: say in the law"),
    "what is sought": ({"law": SEEN, "maximize": "rho"}, "maximize"),
    "starts": ({"law": SEEN, "search": {"starts": 0}}, "starts must be"),
    "no law": ({"maximize": "sigma"}, "maximize needs a law: say what is measured"),
}  # fmt: skip


@pytest.mark.parametrize("what", WRONG)
def test_a_wrong_field_is_named_with_its_cure(ask, what):
    asked, words = WRONG[what]
    code, answer, err, file, _ = ask({"plant": CARTS, **asked})
    assert (code, answer) == (2, None) and err.startswith(f"error: {file}: ")
    assert words in err


def test_the_schema_has_the_words_of_both_laws():
    path = Path(sos.proofs.__file__).with_name("plant.schema.json")
    there = json.loads(path.read_text("utf-8"))["properties"]["law"]["properties"]
    laws = (signature(kind).parameters for kind in (sos.PIDLaw, sos.DynamicLaw))
    assert there.keys() == {name for names in laws for name in names}
