"""From two logs to a C program: every number can be traced."""

import hashlib
import json
import re
import shutil
from copy import copy
from dataclasses import replace

import numpy as np
import pytest

import sosbook as sos
from sosbook import pendulum
from sosbook.pendulum import command
from sosbook.pendulum.command import main
from sosbook.pendulum.deployment import recommend
from sosbook.pendulum.rig import DATA
from sosbook.proofs.command import main as verify
from tests.processes import alone
from tests.six_robots import spared
from tests.test_mip_robot import deployed

pytestmark = pytest.mark.slow  # one identification, one design, two proofs


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("robot") / "new"


@pytest.fixture(scope="module")
def found(folder):
    """What comes of the shipped logs; by the command in tests/test_mip_fit_spread."""
    with pytest.MonkeyPatch.context() as patch:  # a minute's rest: tests/test_mip_rest
        patch.setattr("sosbook.pendulum.proven.REST_SECONDS", 6.0)
        found = copy(deployed())
        found.write(folder)
        return found


def test_both_proofs_hold_for_the_gain_that_is_written(found, folder):
    assert found.proven
    K = found.certificate.K
    assert np.array_equal(found.held.K, K)
    assert np.array_equal(np.hstack([found.law.D, found.law.C]), K)
    text = (folder / "balance_gains.h").read_text("utf-8")
    for gain in K[0]:
        assert float(gain).hex() in text


def test_the_facts_name_the_logs_by_their_digests(found, folder):
    facts = json.loads((folder / "provenance_balance.json").read_text("utf-8"))
    assert facts == found.facts
    for name in ("body", "wheels"):
        digest = hashlib.sha256((DATA / f"{name}.csv").read_bytes())
        assert digest.hexdigest() in facts[f"log of the {name}"]
    header = " ".join((folder / "balance_gains.h").read_text("utf-8").split())
    for word in ("identified", "plant", "specification", "gain"):
        assert word in header
    assert facts["gain"] in header
    for name in ("balance.c", "balance_single_gains.h"):
        assert verify(["verify", "--code", str(folder / name)]) == 0
    stand = folder / "balance_stand_gains.h"
    assert verify(["verify", "--code", str(stand)]) == 2  # it doesn't balance


def test_the_proofs_lie_beside_the_programs(found, folder):
    """Each is read again, and plain Python checks each."""
    for proof, file, code in (
        (found.certificate, "proof_balance.json", 0),
        (found.held, "proof_balance_hold.json", 0),
        (found.sampled[0.0][0], "proof_balance_sampled_1.json", 0),
    ):
        assert sos.proofs.load(folder / file) == proof
        done = alone("check_proof.py", file, cwd=folder)
        assert done.returncode == code, done.stdout
    assert len(list(folder.glob("proof_balance_sampled_*.json"))) == 6


def test_the_sampled_proofs_are_held_against_the_program(found, folder, tmp_path):
    """Its law with its estimates and its clock; another of them is refused."""
    text = (folder / "balance_gains.h").read_text("utf-8")
    shutil.copytree(folder, tmp_path, dirs_exist_ok=True)
    file, other = folder / "proof_balance_sampled_6.json", tmp_path / "balance_gains.h"
    record = tmp_path / "program_balance.json"

    def held(text):
        other.write_text(text, "utf-8")
        return verify(["verify", str(file), "--code", str(other)])

    assert held(text) == 0
    assert held(text.replace("BALANCE_LIMIT 0x1.", "BALANCE_LIMIT 0x1.1")) == 1
    record.unlink()  # what follows, the law alone notices
    assert held(text) == 0
    for name, value in (
        ("BLEND", found.robot.blend * 1.01),
        ("TICK", 0.0100001),
        ("DELAY", found.robot.delay - 1e-5),
    ):
        line = re.search(rf"#define BALANCE_{name} \S+", text)[0]
        changed = f"#define BALANCE_{name} {value.hex()}"
        assert held(text.replace(line, changed)) == 1
    k = found.law.D[0, 3]
    assert held(text.replace(k.hex(), np.nextafter(k, 9).hex())) == 0  # not a double's
    assert held(text.replace(k.hex(), (k + 1e-9).hex())) == 1
    plants = re.search(r"plants: sha256((?:[\s*]+[0-9a-f]{16})+)", text)[1]
    assert held(text.replace(plants, re.sub(r"\w{16}", 16 * "0", plants))) == 1
    single = folder / "balance_single.c"
    assert verify(["verify", str(file), "--code", str(single)]) == 1


def test_the_sampled_loops_keep_their_margin(found):
    assert [len(row) for row in found.loops.values()] == [5, 5, 5]
    assert list(found.loops) == [0.0, 0.005, 0.01]
    assert found.radius < 1 and found.sensitivity < 2


def test_the_firmwares_loop_is_proven_over_the_whole_polytope(found):
    assert list(found.sampled) == list(found.loops)
    for late, (first, second) in found.sampled.items():
        assert first.proven and second.proven
        for robot in found.loops[late]:  # what is proven is what runs
            ours = sos.sampled.sampled_loop(
                robot.robot.plant(), first.K, found.law.T, late
            )[0]
            assert np.allclose(np.poly(ours), np.poly(robot.matrix), atol=1e-8)


def test_the_stands_program_knows_the_body_alone(found, folder):
    """In the air the wheels' gains are positive feedback, its aren't."""
    robot = found.mip
    assert found.law.D[0, 3] * robot.e / robot.f > 1  # V to speed to V
    assert found.bench_firmware.law.D[0, [1, 3]].tolist() == [0, 0]
    assert np.array_equal(found.bench_firmware.law.D[0, [0, 2]], found.law.D[0, [0, 2]])
    assert found.bench_firmware.limit == 2.0
    header = (folder / "balance_stand_gains.h").read_text("utf-8")
    assert "It doesn't balance" in header
    assert "balance_stand_run_tick" in (folder / "rc_balance_stand.c").read_text(
        "utf-8"
    )


def test_what_is_not_proven_is_not_written(found, tmp_path):
    # an eigenvalue at one
    forgetless = replace(found, robot=found.robot.but(blend=0.0), cells=1)
    same = "design", "delayed", "certificate", "held"
    spared(forgetless, **{x: getattr(found, x) for x in same})
    assert not forgetless.proven
    assert all("sampled" in words for words in forgetless.lacking)
    with pytest.raises(ValueError, match="isn't proven.* 0 ms late"):
        forgetless.write(tmp_path / "none")
    assert not (tmp_path / "none").exists()


def test_a_second_run_writes_the_same_bytes(found, folder, tmp_path):
    for path in found.write(tmp_path):
        assert path.read_bytes() == (folder / path.name).read_bytes()
        assert not re.search(rb"20\d\d-\d\d|/home|/root", path.read_bytes())


def test_the_command_passes_on_what_is_asked(monkeypatch, found, tmp_path):
    asked = {}

    def listen(*words, **named):
        asked.update(named, words=words)
        return found

    monkeypatch.setattr(command, "deploy", listen)
    monkeypatch.setattr(command, "inspect", lambda *words: None)
    monkeypatch.setattr(command, "write_report", lambda *words: "a page")
    paths = str(DATA / "gearmotors.toml"), "b.csv", "w.csv", str(tmp_path)
    main([*paths, *["--R", "30", "--M_b", "0.3", "--limit", "9", "--no-rotors"]])
    robot = pendulum.Robot.shipped("gearmotors").but(M_b=0.3, limit=9.0, rotors=False)
    assert asked == {"words": ("b.csv", "w.csv", robot), "R": 30.0}


def test_the_command_says_what_is_wrong_in_a_line(tmp_path, capsys):
    with pytest.raises(SystemExit) as ended:
        main([str(tmp_path / "none.csv"), str(DATA / "wheels.csv"), "x"])
    assert ended.value.code == 1
    assert "none.csv" in capsys.readouterr().err


@pytest.mark.parametrize(
    "asked, words", [(dict(R=0), "R must"), (dict(spread=1.2), "spread")]
)
def test_bad_input_is_named(asked, words):
    with pytest.raises(ValueError, match=words):
        recommend(pendulum.Mip.printed(), **asked)
