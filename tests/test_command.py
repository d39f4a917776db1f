"""The command line: python -m sosbook verify and design."""

import json
import os
import re
import sys
from inspect import signature
from pathlib import Path
from subprocess import PIPE

import numpy as np
import pytest

import sosbook
import sosbook as sos
from sosbook import proofs
from sosbook.controllers import Controller
from sosbook.exact.checker import verdict as checker
from sosbook.plants.outputs import Output
from sosbook.proofs.command import main
from sosbook.proofs.folder import CONTROLLER
from sosbook.proofs.subject import subject
from sosbook.requirements.in_files import KEYS, OBJECTS, SEVERAL
from sosbook.runtime.digests import digest
from tests.asking import asked_by, asking, in_place
from tests.hunt.tampering import put
from tests.processes import process

FOLDER = Path(proofs.__file__).parent
EXAMPLE = FOLDER / "plant.example.json"


VERIFY = {
    "package": lambda *x: main(["verify", *x]),
    "checker": lambda *x: checker.main(x),
}


PROGRAMS = {
    "package": [sys.executable, "-m", "sosbook", "verify"],
    "checker": [sys.executable, proofs.CHECKER],
}


def run(*arguments):
    return process(sys.executable, "-m", "sosbook", *arguments, timeout=120)


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
    assert (done.returncode, done.stdout) == (1, "not proven: hinf\n")


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


def test_what_is_undecided_has_no_proof(tmp_path, capsys):
    proof, search = tmp_path / "none.json", {"time_limit": 1e-9}
    file = plant_file(tmp_path, search=search, region={"sigma": 0.01})
    assert main(["design", str(file), "--proof", str(proof)]) == 1
    answer = json.loads(capsys.readouterr().out)
    assert answer["status"] == "undecided" and answer["proven"] is False
    assert answer["reason"].startswith("Stopped after") and "K" not in answer
    assert not proof.exists()


WRONG = {
    "no plant": (dict(plant=...), '"plant" is missing'),
    "another key": (dict(gama=2), "'gama' isn't known"),
    "no mass": (dict(plant={"D": [[1]]}), "plant has M, D, S, B.* M is missing; S is"),
    "an empty polytope": (dict(plant={"vertices": []}), "vertices is empty"),
    "a bad vertex": (
        dict(plant={"vertices": [{k: [[1]] for k in "MDSB"}, {}]}),
        r"plant.vertices\[1\] has M, D, S, B",
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


# ------------------------------------------- which plant and gain a proof is about
@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """A folder with a plant of one mass, its proof and what `design` printed."""
    folder = tmp_path_factory.mktemp("small")
    data = {"plant": {k: [[x]] for k, x in zip("MDSB", (0.3, 0.1, 1 / 9.81, 2.2046))}}
    data |= {"U": [[1]], "saturation": {"u_max": 50, "x0": [0.5, 0, 0]}}
    (folder / "plant.json").write_text(json.dumps(data), "utf-8")
    done = run("design", folder / "plant.json", "--proof", folder / "proof.json")
    assert done.returncode == 0, done.stderr
    (folder / "gain.json").write_text(done.stdout, "utf-8")
    return folder


def test_a_verdict_names_plant_gain_and_start(small, capsys):
    """In both programs with the same words."""
    said = []
    for verify in VERIFY.values():
        assert verify(str(small / "proof.json")) == 0
        said.append(capsys.readouterr().out)
    assert said[0] == said[1]
    first = said[0].splitlines()[0]
    data = proofs.load(small / "proof.json").data
    for name, part in (
        ("plant", data["plant"]),
        ("U", data["U"]),
        ("K", data["K"]),
        ("x0", data["requirements"][0]["x0"]),
    ):
        numbers = json.dumps(part).replace('"', "")
        assert f"{name} {digest(part)[:12]} = {numbers}" in first
    for path, value in (
        (("plant", "vertices", 0, "M", 0, 0), "0.29"),
        (("K", 0, 0), "-100"),
        (("requirements", 0, "x0", 0), "0.4"),
    ):
        other = put(asked_by(proofs.load(small / "proof.json")), path, value)
        assert subject(other) == checker.subject(other) not in first


@pytest.mark.parametrize("program", VERIFY)
def test_a_proof_is_held_against_plant_and_gain(small, tmp_path, capsys, program):
    verify = VERIFY[program]
    proof, plant, gain = (str(small / f"{x}.json") for x in ("proof", "plant", "gain"))
    assert verify(proof, "--plant", plant, "--gain", gain) == 0
    data = json.loads((small / "plant.json").read_text("utf-8"))
    bare, other = tmp_path / "bare.json", tmp_path / "other.json"
    for same in (
        data["plant"],
        data["plant"] | {"F": [[]]},
        {"vertices": [data["plant"]]},
    ):
        bare.write_text(json.dumps(same), "utf-8")
        assert verify(proof, "--plant", str(bare)) == 0
    capsys.readouterr()
    wrong = {
        "another plant .*S of vertex 1": ("plant", "S", [[np.nextafter(1 / 9.81, 1)]]),
        "another plant .*F of vertex 1": ("plant", "F", [[1]]),
        "another plant": (None, "plant", {"vertices": 2 * [data["plant"]]}),
        "another U": (None, "U", [[2]]),
        "another K_A": (None, "K_A", [[0.5]]),
    }
    for words, (part, key, value) in wrong.items():
        changed = json.loads(json.dumps(data))
        (changed if part is None else changed[part])[key] = value
        other.write_text(json.dumps(changed), "utf-8")
        assert verify(proof, "--plant", str(other)) == 1
        said = capsys.readouterr().out
        words = words.partition(" .*")[0] if program == "checker" else words
        assert said.startswith("refused: ") and re.search(words, said), said
        assert "proven" not in said
    K = json.loads((small / "gain.json").read_text("utf-8"))["K"]
    for given, code in ((K, 0), ([[*K[0][:2], K[0][2] + 1e-9]], 1), ([K[0][:2]], 1)):
        other.write_text(json.dumps(given), "utf-8")
        assert verify(proof, "--gain", str(other)) == code
    assert "another K" in capsys.readouterr().out
    for broken in ("", "{", '{"M": 1, "M": 2}', "[[true]]", '{"L": [[1]]}'):
        other.write_text(broken, "utf-8")
        for option in ("--plant", "--gain"):
            assert verify(proof, option, str(other)) == 2
            said = capsys.readouterr()
            assert str(other) in said.out + said.err


def test_a_proof_is_held_against_a_program(tmp_path, capsys):
    """Each way to be another program has its words; the right one has none."""
    mine = controller(0.3)
    mine.to_c("cart").write(tmp_path)
    proof, gains = (tmp_path / x for x in ("proof_cart_sampled.json", "cart_gains.h"))
    good = gains.read_text("utf-8")

    def verify(text=good, proof=proof, code=gains):
        gains.write_text(text, "utf-8")
        return main(["verify", str(proof), "--code", str(code)])

    assert verify() == verify(code=tmp_path / "cart.c") == 0  # beside it
    assert main(["verify", "--code", str(gains)]) == 0  # alone
    lost = tmp_path / "alone" / "cart_gains.h"
    lost.parent.mkdir()
    lost.write_text(good, "utf-8")
    assert main(["verify", "--code", str(lost)]) == main(["verify"]) == 2
    assert "give the file of one" in capsys.readouterr().err
    assert verify() == 0
    assert capsys.readouterr().out.startswith(f"of {gains}, compared: its law")
    other = controller(0.31)
    other.certify(time_limit=60).save(tmp_path / "other.json")
    softer = other.to_c("cart").gains
    capsys.readouterr()
    assert verify() == 0 and "compared: all other files" in capsys.readouterr().out
    digit = re.search(r"(?s)CART_D .*?(0x1\.[0-9a-f]+)", good)[1]
    changed = digit[:-1] + ("1" if digit[-1] != "1" else "2")
    wrong = {
        "another plant": (good, tmp_path / "other.json"),
        "another plant, sha256": (softer, proof),
        "its [AC] isn't the proof's": (
            controller(0.3, rho=25).to_c("cart").gains,
            proof,
        ),
        "its .* the proof's": (good.replace(digit, changed), proof),
        "its TICK isn't": (good.replace("CART_TICK 0x1.", "CART_TICK 0x1.1"), proof),
        "names other proof files": (
            re.sub(r"[0-9a-f]{63}\)", "f" * 63 + ")", good),
            proof,
        ),
        "no gain and no sampled": (good, tmp_path / "none.json"),
    }
    heavy = sos.SecondOrderSystem(*([[x]] for x in (0.3, -1, 1, 1)))
    least = sos.Saturation(0.5, [1, 0])
    refused = sos.design_pid(heavy, saturation=least).infeasibility
    refused.save(tmp_path / "none.json")
    for words, (text, file) in wrong.items():
        assert verify(text, file) == 1, words
        said = capsys.readouterr().out
        assert said.startswith("refused: ") and re.search(words, said), said
        assert "proven" not in said and str(gains) in said
    for broken in ("", "int main(void) { return 0; }", "[[1]]", good[:2500]):
        assert verify(broken) == 2
        assert str(gains) in capsys.readouterr().err
    assert verify(code=tmp_path / "no.h") == 2
    assert "no.h" in capsys.readouterr().err


def controller(mass, rho=30):
    """Of a cart whose place is measured alone."""
    cart = sos.SecondOrderSystem(*([[x]] for x in (mass, 0.1, 1 / 9.81, 2.2046)))
    design = sos.design_pid(cart, [[1]], region=sos.PoleRegion(1, rho=rho))
    return design.controller(["z1"], T=0.01, delay=0.004)


# ------------------------------------------------- nothing is lost, nothing is stale
def test_only_a_proof_about_the_same_plant_is_replaced(small, tmp_path, capsys):
    plant, proof = tmp_path / "plant.json", tmp_path / "proof.json"
    text = (small / "plant.json").read_text("utf-8")
    plant.write_text(text, "utf-8")
    assert main(["design", str(plant), "--proof", str(plant)]) == 2
    assert plant.read_text("utf-8") == text
    assert "holds something else: give --proof another name" in capsys.readouterr().err
    design = ["design", str(plant), "--proof", str(proof)]
    assert main(design) == main(design) == 0
    capsys.readouterr()
    plant.write_text(text.replace("0.3", "0.4"), "utf-8")
    before = proof.read_bytes()
    assert main(design) == 2 and proof.read_bytes() == before
    assert "about another plant; give --proof" in capsys.readouterr().err
    assert main([*design, "--force"]) == 0 and proof.read_bytes() != before
    proof.write_bytes(before[:500])  # cut, as on a full disk
    assert main(design) == 2 and main([*design, "--force"]) == 0
    assert main(["design", str(plant), "--proof", str(tmp_path / "no" / "p.json")]) == 2


def test_no_stale_proof_is_left(small, tmp_path, capsys):
    plant, proof = tmp_path / "plant.json", tmp_path / "proof.json"
    data = json.loads((small / "plant.json").read_text("utf-8"))
    plant.write_text(json.dumps(data), "utf-8")
    design = ["design", str(plant), "--proof", str(proof)]
    assert main(design) == 0
    plant.write_text(json.dumps(data | {"gama": 1}), "utf-8")
    capsys.readouterr()
    assert main(design) == 2 and proof.exists()
    assert "is still the answer to an earlier request" in capsys.readouterr().err
    tiny = data | {"saturation": {"u_max": 1e-9, "x0": [0.5, 0, 0]}}
    tiny |= {"region": {"sigma": 5.0}, "coupling": ["slack", 1e-9]}
    plant.write_text(json.dumps(tiny), "utf-8")
    code, said = main(design), capsys.readouterr()
    answer = json.loads(said.out)
    assert code == 1
    if answer["proven"]:
        assert proofs.load(proof).proven and "no gain" in answer["claims"][0]
    else:
        assert not proof.exists() and "is removed" in said.err


def test_a_design_without_proof_removes_the_old_one(
    small, tmp_path, capsys, monkeypatch
):
    """Whatever the reason is that there is none."""
    proof = tmp_path / "proof.json"
    design = ["design", str(small / "plant.json"), "--proof", str(proof)]
    assert main(design) == 0
    whole = put(asked_by(proofs.load(proof)), ("K", 0, 0), "1000")
    failed = proofs.DesignProof(json.dumps(asking(whole)))
    monkeypatch.setattr(sosbook.Design, "certify", lambda self: failed)
    capsys.readouterr()
    assert main(design) == 1
    assert not proof.exists() and "is removed" in capsys.readouterr().err


# ------------------------------------------------------------------ a folder

COMPUTER = {"measured": ["z1"], "T": 0.02, "delay": 0.005, "counts": 40000}
TOML = """
U = [[1]]
[plant]
M = [[0.3]]
D = [[0.1]]
S = [[0.1019367991845056]]
B = [[2.2046]]
[saturation]
u_max = 50
x0 = [0.5, 0, 0]
[controller]
measured = ["z1"]
T = 0.02
delay = 0.005
counts = 40_000
u_max = 60.0
"""


@pytest.fixture
def designed(small, tmp_path, capsys):
    """Design into the folder "out" for the small plant and some changes."""

    def design(*options, name="plant.json", text=None, **changes):
        data = json.loads((small / "plant.json").read_text("utf-8")) | changes
        (tmp_path / name).write_text(text or json.dumps(data), "utf-8")
        code = main(
            ["design", str(tmp_path / name), "--out", str(tmp_path / "out"), *options]
        )
        return code, *capsys.readouterr()

    return design


def names_in(folder):
    there = {p.relative_to(folder).as_posix() for p in folder.rglob("*")}
    return {name for name in there if (folder / name).is_file()}


def test_a_folder_has_gains_proof_and_page(small, designed, tmp_path):
    code, out, _ = designed()
    folder, answer = tmp_path / "out", json.loads(out)
    assert code == 0 and (folder / "gains.json").read_text("utf-8") == out
    mine = {"gains.json", "proof.json", "index.html"}
    assert names_in(folder) == {*answer["files"]} == mine
    gain, proof = folder / "gains.json", folder / "proof.json"
    verify = ["verify", str(proof), "--plant", str(tmp_path / "plant.json"), "--gain"]
    assert main([*verify, str(gain)]) == 0
    page = (folder / "index.html").read_text("utf-8")
    assert "feasible" in page and "every constant" not in page
    for claim in answer["claims"]:
        assert claim.replace("<", "&lt;") in page
    plain_run = json.loads((small / "gain.json").read_text("utf-8"))
    del plain_run["proof"]
    assert plain_run.items() <= answer.items()


@pytest.mark.usefixtures("without_bounds")
def test_a_controller_is_the_package_s(designed, tmp_path, monkeypatch):
    """Its program to the letter, and the proofs that belong to it."""
    monkeypatch.setattr("sosbook.controllers.report.FOR_MARGINS", 600)  # by no clock
    folder = tmp_path / "out"
    code, out, _ = designed(controller=COMPUTER | {"u_max": {"u": 60}})
    assert code == 0 and json.loads(out)["controller_proven"] is True
    assert names_in(folder) == {*json.loads(out)["files"]}
    cart = sos.SecondOrderSystem(*([[x]] for x in (0.3, 0.1, 1 / 9.81, 2.2046)))
    design = sos.design_pid(cart, [[1]], saturation=sos.Saturation(50, [0.5, 0, 0]))
    theirs = tmp_path / "theirs"
    design.report(theirs, controller=design.controller(**COMPUTER).limit(60))
    mine = names_in(folder) - {"gains.json", "proof.json"}
    assert names_in(theirs) == mine and "axis/axis_sketch/axis_sketch.ino" in mine
    for name in mine:
        assert (folder / name).read_bytes() == (theirs / name).read_bytes(), name
    program = folder / "axis"
    sampled, c = program / "proof_axis_sampled.json", program / "axis.c"
    assert main(["verify", str(sampled), "--code", str(c)]) == 0
    toml, gain = tmp_path / "plant.toml", folder / "gains.json"
    toml.write_text(TOML, "utf-8")
    verify = ["verify", str(folder / "proof.json"), "--plant", str(toml)]
    assert main([*verify, "--gain", str(gain)]) == 0
    toml.write_text(TOML.replace("0.3", "0.31"), "utf-8")
    assert main(verify) == 1
    toml.write_text(TOML.replace("U = [[1]]", "U = [[2]]"), "utf-8")
    assert main(verify) == 1


@pytest.mark.usefixtures("without_bounds")
def test_toml_is_json_and_leaves_out_what_that_calls_null(designed):
    text = TOML.replace("u_max = 50", "").replace("U =", 'minimize = "u_max"\nU =')
    text += "[region]\nsigma = 1\nrho = 9\n"
    code, out, _ = designed(name="plant.toml", text=text)
    given = {"minimize": "u_max", "saturation": {"u_max": None, "x0": [0.5, 0, 0]}}
    given["region"] = {"sigma": 1, "rho": 9}
    assert code == 0
    assert (code, out) == designed(controller=COMPUTER | {"u_max": 60}, **given)[:2]


@pytest.mark.usefixtures("without_bounds")
def test_what_is_in_a_folder_is_not_lost(designed, tmp_path):
    folder, heavier = tmp_path / "out", {k: [[x]] for k, x in zip("MDSB", (2, 1, 1, 1))}
    folder.mkdir()
    own = folder / "thesis.txt"
    own.write_text("years", "utf-8")
    for options in ((), ("--force",)):  # a folder of something else, never
        code, out, err = designed(*options)
        assert (code, out) == (2, "") and "holds something else: give --out" in err
        assert names_in(folder) == {"thesis.txt"}
    own.unlink()
    assert designed(controller=COMPUTER)[0] == 0
    before = (folder / "gains.json").read_bytes()
    code, out, err = designed(plant=heavier)
    assert (code, out) == (2, "") and "about another plant: give --out" in err
    sketch = folder / "axis" / "axis_sketch" / "axis_sketch.ino"
    written = sketch.read_bytes()
    sketch.write_bytes(written + b"/* my pins */")
    code, out, err = designed()
    assert (
        (code, out) == (2, "") and f"{sketch} was changed" in err and "--force" in err
    )
    sketch.write_bytes(written)
    gains = folder / "gains.json"
    gains.write_bytes(before.replace(b'"digits": ', b'"digits": 1'))
    assert f"{gains} was changed" in designed()[2]
    gains.write_bytes(before)
    own.write_text("years", "utf-8")  # beside an answer it is left alone
    code, out, err = designed()  # the same plant: no program stays beside new gains
    assert code == 0 and err.count("is removed") == 16
    mine = {"gains.json", "proof.json", "index.html"}
    assert names_in(folder) == mine | {"thesis.txt"}
    (folder / "axis" / "axis.c").write_text("mine", "utf-8")
    for options in ((), ("--force",)):
        code, out, err = designed(*options, controller=COMPUTER)
        assert (code, out) == (2, "") and "axis.c is there already" in err
        assert names_in(folder) == mine | {"thesis.txt", "axis/axis.c"}
    code, out, _ = designed("--force", plant=heavier)
    assert code == 0 and gains.read_bytes() != before
    assert names_in(folder) == mine | {"thesis.txt", "axis/axis.c"}


def test_a_record_names_no_file_elsewhere(designed, tmp_path):
    assert designed()[0] == 0
    gains, other = tmp_path / "out" / "gains.json", tmp_path / "other.txt"
    other.write_text("mine", "utf-8")
    data = json.loads(gains.read_text("utf-8"))
    data["files"] |= {"../other.txt": "0", str(other): "0"}
    gains.write_text(json.dumps(data), "utf-8")
    assert designed("--force")[0] == 0 and other.read_text("utf-8") == "mine"


@pytest.mark.usefixtures("without_bounds")
def test_a_folder_of_a_request_without_gain_has_no_program(designed, tmp_path):
    one, folder = [[1]], tmp_path / "out"
    unstable = {"M": one, "D": [[-1]], "S": one, "B": one}
    refused = dict(plant=unstable, saturation={"u_max": 0.5, "x0": [1, 0]}, U=None)
    assert designed(controller=COMPUTER)[0] == 0
    code, out, err = designed("--force", **refused, controller=COMPUTER)
    answer = json.loads(out)
    assert code == 1 and answer["proven"] and not answer["controller_proven"]
    assert "no program is written" in err and "axis.c is removed" in err
    assert names_in(folder) == {"gains.json", "proof.json", "index.html"}
    page = (folder / "index.html").read_text("utf-8")
    assert "infeasible" in page and "no gain" in page
    assert main(["verify", str(folder / "proof.json")]) == 0


NO_CLOCK = {
    "a number": (3, "controller must be an object"),
    "another key": (
        COMPUTER | {"dealy": 0},
        "controller: 'dealy' isn't known: its keys",
    ),
    "no T": ({"measured": ["z1"]}, "controller: T is missing: give the seconds"),
    "no time": (COMPUTER | {"T": 0}, "controller: T must be"),
    "a word": (COMPUTER | {"T": "fast"}, "controller: T must be"),
    "the past": (COMPUTER | {"delay": -1}, "controller: delay must be 0 or more"),
    "no sensor": (COMPUTER | {"measured": ["z2"]}, "controller: measured names 'z2'"),
    "no list": (COMPUTER | {"measured": 1}, "controller: measured must be"),
    "no count": (COMPUTER | {"counts": {"z3": 9}}, "controller: counts names 'z3'"),
    "no input": (COMPUTER | {"u_max": {"v": 9}}, "controller: u_max names 'v'"),
    "no limit": (COMPUTER | {"u_max": -3}, "controller: u_max must be"),
    "an unseen error": (
        COMPUTER | {"measured": ["z1'"]},
        "isn't measured: .* measure z1",
    ),
    "one count": (
        COMPUTER | {"counts": 4, "u_max": 0.01},
        "controller: counts are too",
    ),
}


@pytest.mark.parametrize("what", NO_CLOCK)
def test_a_bad_controller_is_named(designed, tmp_path, what):
    asked, words = NO_CLOCK[what]
    code, out, err = designed(controller=asked)
    assert (code, out) == (2, "") and not (tmp_path / "out").exists()
    assert err.startswith(f"error: {tmp_path / 'plant.json'}: controller")
    assert re.search(words, err), err


def test_a_controller_needs_a_folder(small, tmp_path, capsys):
    data = json.loads((small / "plant.json").read_text("utf-8"))
    file = tmp_path / "plant.json"
    file.write_text(json.dumps(data | {"controller": COMPUTER}), "utf-8")
    assert main(["design", str(file), "--proof", str(tmp_path / "p.json")]) == 2
    assert "give --out FOLDER for its program" in capsys.readouterr().err
    assert not (tmp_path / "p.json").exists()
    with pytest.raises(SystemExit):
        main(["design", str(file), "--proof", "p.json", "--out", str(tmp_path / "out")])


# ------------------------------------------------------------------ limits
def spoilt(small, **changes):
    return json.dumps(in_place(asked_by(proofs.load(small / "proof.json")) | changes))


@pytest.fixture(scope="module")
def heavy(small):
    """From a name to the text of a proof that takes for ever, and where it ends."""
    n, one = 150, "1"
    eye = [[str(int(i == j)) for j in range(n)] for i in range(n)]
    full, column = [[one] * n] * n, [[one]] * n
    large = {"M": eye, "D": full, "S": full, "B": column, "F": [[]] * n}
    P = [["1.5" if i == j else "0.1" for j in range(2 * n)] for i in range(2 * n)]
    (vertex,) = proofs.load(small / "proof.json").data["plant"]["vertices"]
    several = [vertex | {"M": [[str(k + 1)]]} for k in range(400)]
    kind = "second order"
    return {
        "a version of 4e6 digits": (
            (small / "proof.json")
            .read_text("utf-8")
            .replace('"version":2', f'"version":{"9" * 4_000_000}')
        ),
        "a number of 4e6 digits": spoilt(small, K=[["1" * 4_000_000]]),
        "20000 equal vertices": spoilt(
            small, plant={"kind": kind, "vertices": [vertex] * 20_000}
        ),
        "400 vertices": spoilt(small, plant={"kind": kind, "vertices": several}),
        "150 masses": spoilt(
            small,
            plant={"kind": kind, "vertices": [large]},
            U=[],
            K=[[one] * 2 * n],
            requirements=[],
            unknowns={"P": P},
        ),
        "lists in lists": spoilt(small, K="@").replace('"@"', "[" * 9000 + "]" * 9000),
    }


@pytest.mark.slow
@pytest.mark.parametrize("program", PROGRAMS)
def test_what_takes_for_ever_ends_within_the_limit(
    heavy, tmp_path, program, pytestconfig
):
    """Undecided has an exit code of its own: it is never "not proven"."""
    command, some = PROGRAMS[program], [*heavy.items()]
    if program == "package" and not pytestconfig.getoption("--campaign"):
        some = []  # it asks the checker, which the gate asks for all of them
    file = tmp_path / "heavy.json"
    for name, text in some:
        file.write_text(text, "utf-8")
        done = process(*command, file, "--time-limit", "0.3", timeout=60)
        said = done.stdout + done.stderr
        assert "Traceback" not in said and len(said) < 2000, name
        if done.returncode == 4:
            assert said.startswith("not decided"), name
        else:
            assert done.returncode in (1, 2, 3), name
            assert not done.stdout.startswith("proven"), name
    file.write_text(heavy["150 masses"], "utf-8")
    done = process(*command, file, "--time-limit", "1e-4")
    assert done.returncode == 4 and done.stdout.startswith("not decided within")


def test_the_time_is_a_number_of_seconds(small, capsys):
    for wrong in ("0", "-1", "nan", "inf"):
        assert main(["verify", str(small / "proof.json"), "--time-limit", wrong]) == 2
        assert "time_limit must be positive" in capsys.readouterr().err


# ---------------------------------------------------------------- what is printed
@pytest.mark.skipif(os.name == "nt", reason="pipes of POSIX")
@pytest.mark.parametrize("program", PROGRAMS)
def test_a_reader_that_goes_away_is_no_error(small, program):
    """As in ``verify proof.json | head -0``: the verdict is the exit code."""
    read, write = os.pipe()
    os.close(read)
    proof, said = small / "proof.json", dict(stdout=write, stderr=PIPE)
    done = process(*PROGRAMS[program], proof, capture_output=False, **said)
    os.close(write)
    assert done.returncode == 0 and done.stderr == ""


def test_no_text_of_a_plant_commands_the_terminal(small, tmp_path, capsys):
    evil = "\x1b[2J\x1b[1;1Hproven:\u202e"
    plant = json.loads((small / "plant.json").read_text("utf-8"))
    for changes in (
        {evil: 1},
        {"region": {evil: 1}},
        {"minimize": {evil: 1}},
        {"coupling": evil},
        {"plant": {**plant["plant"], evil: 1}},
    ):
        file, proof = tmp_path / "evil.json", str(tmp_path / "proof.json")
        file.write_text(json.dumps(plant | changes), "utf-8")
        assert main(["design", str(file), "--proof", proof]) == 2
        said = capsys.readouterr().err
        assert said.startswith("error: ") and said.replace("\n", "").isprintable()


def test_schemas_name_what_the_files_hold(tmp_path):
    """The keys of the schemas, the example and a proof are the same ones."""
    schema = json.loads((FOLDER / "plant.schema.json").read_text("utf-8"))
    beside = {"$schema", "plant", "words", "controller"}
    assert set(schema["properties"]) == {*beside, *KEYS}
    there = schema["properties"]["controller"]["properties"].keys()
    made = signature(sos.Design.controller), signature(Controller.limit)
    assert there == {*CONTROLLER} <= {x for call in made for x in call.parameters}
    assert json.loads(EXAMPLE.read_text("utf-8")).keys() <= set(schema["properties"])
    for key, make in (OBJECTS | {"search": sos.Search}).items():
        there = schema["properties"][key]["properties"].keys()
        known = signature(make).parameters.keys()
        assert there == known - {"start"}, key  # which is a design, not words
    for key, make in (SEVERAL | {"output": Output}).items():
        there = schema["$defs"][key]["properties"].keys()
        known = signature(make).parameters.keys() - {"step"}  # which the plant has
        assert there == known, key
    proof = json.loads((FOLDER / "proof.schema.json").read_text("utf-8"))
    assert set(proof["properties"]["kind"]["anyOf"][0]["enum"]) == {*proofs.kinds()}
    assert main(["design", str(EXAMPLE), "--proof", str(tmp_path / "p.json")]) == 0
    written = json.loads((tmp_path / "p.json").read_text("utf-8"))
    assert written.keys() <= set(proof["properties"])
