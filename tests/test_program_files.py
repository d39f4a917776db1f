"""Each file of a program, and each number in it, is held to what was written."""

import itertools
import json
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import expm

import sosbook as sos
from sosbook.controllers import Code, code_fault, read_gains
from sosbook.controllers.written import changes
from sosbook.proofs.command import main
from tests.axis import axis


def hanging_and_falling():
    """Two equal masses; one hangs, the other falls, and each has a gain of its own."""
    S = [[0.3, 0], [0, -9.81]]
    plant = sos.SecondOrderSystem(np.eye(2), 0.1 * np.eye(2), S, np.eye(2))
    K = [[-1, 0, -1, 0], [0, -25, 0, -7]]
    design = sos.analyse_pid(plant, K, region=sos.PoleRegion(sigma=0.1))
    return plant, design.controller(T=0.01).limit(20)


def mixed():
    """A sensor that mixes coordinates, with a filter."""
    S = [[9.81, -1], [-1, 2]]
    plant = sos.SecondOrderSystem(np.diag([0.3, 2]), 0.3 * np.eye(2), S, [[1], [0]])
    law = sos.PIDLaw(position=[[1, -0.5], [0, 1]], filter=0.05)
    gains = {"K_P": [[-0.3, 0.1]], "K_D": [[-0.7, 0.05]]}
    return plant, sos.analyse_pid(plant, gains, law=law).controller(T=0.01)


@pytest.fixture(scope="module", params=[hanging_and_falling, mixed])
def written(request, tmp_path_factory):
    plant, c = request.param()
    folder = tmp_path_factory.mktemp("program")
    Code(c, "axis").write(folder)
    c.certify(time_limit=60).save(folder / "sampled.json")
    return plant, c, folder


@pytest.fixture
def folder(written, tmp_path):
    return Path(shutil.copytree(written[2], tmp_path / "copy"))


def verify(folder, capsys, code="axis.c"):
    status = main(
        ["verify", str(folder / "sampled.json"), "--code", str(folder / code)]
    )
    said = capsys.readouterr()
    return status, said.out + said.err


def radius(plant, c, numbers):
    """Of the loop that a program's numbers close, by the plant's own exponential."""
    read = read_gains(numbers)
    M = np.linalg.inv(plant.M)
    zero, n = np.zeros((2, 2)), 4
    A = np.block([[zero, np.eye(2)], [-M @ plant.S, -M @ plant.D]])
    B = np.vstack([np.zeros((2, plant.B.shape[1])), M @ plant.B])
    m = B.shape[1]
    both = expm(c.T * np.block([[A, B], [np.zeros((m, n + m))]]))
    F, G = both[:n, :n], both[:n, n:]
    R, l = c.rows, len(c.A)
    top = F + G @ read["D"] @ R
    if not l:
        return max(abs(np.linalg.eigvals(top)))
    loop = np.block([[top, G @ read["C"]], [read["B"] @ R, read["A"]]])
    return max(abs(np.linalg.eigvals(loop)))


def test_what_was_written_is_accepted_and_the_words_say_what_was_compared(
    folder, capsys
):
    for name in ("axis.c", "axis.h", "axis_tick.h", "axis_gains.h"):
        status, said = verify(folder, capsys, name)
        assert status == 0 and said.count("compared: ") == 3
    (folder / "program_axis.json").unlink()
    status, said = verify(folder, capsys)
    assert status == 0 and "NOT compared" in said
    for path in folder.glob("axis*.[ch]"):  # another system's ends of lines
        path.write_bytes(path.read_bytes().replace(b"\n", b"\r\n"))
    assert verify(folder, capsys)[0] == 0


def exchanged(text, label, a, b):
    """The columns a and b of a matrix exchanged in the text of a header."""

    def swap(match):
        rows = []
        for line in match[0].split("\n"):
            if row := re.match(r"(\s*\{)([^}]*)(\}.*)", line):
                x = row[2].split(", ")
                x[a], x[b] = x[b], x[a]
                line = row[1] + ", ".join(x) + row[3]
            rows.append(line)
        return "\n".join(rows)

    return re.sub(rf"#define AXIS_{label} \{{ \\\n(?:    .*\n)*", swap, text)


def test_exchanged_sensors_outputs_and_names_are_refused(written, folder, capsys):
    plant, c, _ = written
    (folder / "program_axis.json").unlink()  # nothing but the proof decides
    gains = folder / "axis_gains.h"
    good = gains.read_text("utf-8")
    assert radius(plant, c, good) < 1
    worst = 0
    q, m = len(c.measured), len(c.outputs)
    for a, b in itertools.combinations(range(q), 2):
        changed = exchanged(exchanged(good, "D", a, b), "B", a, b)
        if (read_gains(changed)["D"] == read_gains(good)["D"]).all():
            continue
        worst = max(worst, radius(plant, c, changed))
        for text in (changed, exchanged(good, "D", a, b)):
            gains.write_text(text, "utf-8")
            assert verify(folder, capsys)[0] == 1, (a, b)
    if q == 4:
        assert worst > 1  # such a program falls
    for kind, signals in (("IN", q), ("OUT", m)):
        for a, b in itertools.combinations(range(signals), 2):
            lines = re.findall(rf"#define AXIS_{kind}_\w+ \d+", good)
            one, other = lines[a], lines[b]
            numbers = good.replace(one, one.rsplit(" ", 1)[0] + f" {b}")
            numbers = numbers.replace(other, other.rsplit(" ", 1)[0] + f" {a}")
            gains.write_text(numbers, "utf-8")
            status, said = verify(folder, capsys)
            assert status == 1 and f"{kind}_ numbers" in said
    names = re.findall(r"AXIS_IN_(\w+)", good)
    swapped = re.sub(rf"IN_{names[0]}\b", "IN_OTHER", good)
    gains.write_text(swapped, "utf-8")
    assert "names aren't those of its ROWS" in verify(folder, capsys)[1]


def test_each_changed_number_is_named(written, folder, capsys):
    """One edit for each definition; without a proof's help the record notices it."""
    gains = folder / "axis_gains.h"
    good = gains.read_text("utf-8")
    labels = re.findall(r"#define AXIS_(\w+) ", good)
    assert len(labels) > 30
    for label in labels:
        text = re.sub(
            rf"(#define AXIS_{label} (?:\{{ \\\n    )?[^0-9]*)(0x\d|\d)",
            lambda m: m[1] + m[2][:-1] + str((int(m[2][-1]) + 1) % 10),
            good,
            count=1,
        )
        assert text != good, label
        gains.write_text(text, "utf-8")
        status, said = verify(folder, capsys)
        assert status in (1, 2), label
        try:
            faults, _ = changes(folder, "axis")
        except ValueError:
            continue
        assert any(fault.startswith(f"{label} is ") for fault in faults), label
    gains.write_text(good.replace("the numbers", "all numbers"), "utf-8")
    assert "axis_gains.h was changed" in verify(folder, capsys)[1]


@pytest.mark.parametrize("file", ["axis.c", "axis.h", "axis_tick.h"])
def test_each_changed_line_of_the_law_is_named(folder, capsys, file):
    (folder / "program_axis.json").unlink()
    path = folder / file
    lines = path.read_text("utf-8").split("\n")
    for k, line in enumerate(lines):
        if not line.strip() or "Written by" in line:
            continue
        path.write_text("\n".join([*lines[:k], *lines[k + 1 :]]), "utf-8")
        faults, _ = changes(folder, "axis")
        assert faults and faults[0].startswith(f"{file} isn't what sosbook writes")
    path.write_text("int main(void) { return 0; }\n", "utf-8")
    assert verify(folder, capsys, "axis_gains.h")[0] == 1
    path.unlink()
    assert "isn't there" in verify(folder, capsys, "axis_gains.h")[1]


def test_every_other_file_is_held_to_the_record(folder, capsys):
    record = json.loads((folder / "program_axis.json").read_text("utf-8"))
    assert {"axis_sketch/axis_gains.h", "axis_bench.c", "CMakeLists.txt"} <= {
        *record["files"]
    }
    for file in record["files"]:
        path = folder / file
        whole = path.read_bytes()
        path.write_bytes(whole + b"/* */")
        status, said = verify(folder, capsys)
        assert status == 1 and file in said, file
        path.write_bytes(whole)
    assert verify(folder, capsys)[0] == 0


def test_a_file_that_is_none_of_the_program_is_refused(folder, capsys):
    for name in ("axis_bench.c", "other.c", "axis_plants.h"):
        (folder / name).write_text("int x;\n", "utf-8")
        assert verify(folder, capsys, name)[0] == 2


@pytest.mark.parametrize("name", ["con", "nul", "com1", "errno", "arduino", "setup"])
def test_a_name_that_a_system_or_a_library_has_is_refused(name):
    with pytest.raises(ValueError, match="no word of C"):
        axis().to_c(name)


def test_a_gain_applied_at_once_is_held_in_place():
    _, c = hanging_and_falling()
    text = Code(c, "axis").gains
    assert code_fault(c.certificate.data, text) == ""
    changed = exchanged(text, "D", 0, 1)
    assert "aren't the proof's K" in code_fault(c.certificate.data, changed)
    assert "aren't the proof's K" in code_fault(
        c.certificate.data, exchanged(text, "ROWS", 0, 1)
    )
