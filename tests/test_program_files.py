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
from sosbook.controllers import written as written_files
from sosbook.controllers.written import changes, record
from sosbook.pendulum import PD_SIGNALS, Firmware, Gain, Robot, SampledLaw, around
from sosbook.pendulum.export import Program
from sosbook.pendulum.steering import Steering
from sosbook.proofs.command import main
from sosbook.runtime.writing import write_texts
from tests.axis import axis

GAIN = Gain([[20, 0.8, 2, 0.9]], PD_SIGNALS)


def once(function):
    """The function, asked once for each question."""
    answers = {}

    def asked(*given):
        key = repr(given)
        if key not in answers:
            answers[key] = function(*given)
        return answers[key]

    return asked


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
    R, l = c.readings.rows, len(c.A)
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
    q, m = len(c.readings.signals), len(c.outputs)
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


@pytest.fixture(scope="module", params=["axis", "steered", "sketch"])
def program(request, tmp_path_factory):
    """Each family of programs, without a record: folder, name, its own numbers."""
    folder = tmp_path_factory.mktemp(request.param)
    if request.param == "axis":
        Code(hanging_and_falling()[1], "axis").write(folder)
        (folder / "program_axis.json").unlink()
        return folder, "axis"
    if request.param == "steered":
        robot, more = Robot.shipped("thesis"), ("rc_balance", "ros")
        firmware = Firmware(SampledLaw.of_gain(GAIN, 0.01), blend=0.005)
        steering = Steering(firmware, [[-0.93, -0.29, -0.52]], 0.25, 0.07, 0.034)
        written = Program(firmware, "mip", robot=robot, steering=steering)
        texts = {"pyctrl_mip.py": written.pyctrl}
    else:
        robot, more, texts = Robot.shipped("gearmotors"), ("sketch",), {}
        firmware = Firmware(SampledLaw.of_gain(GAIN, robot.T), blend=0.005)
        written = Program(firmware, "mip", robot=robot)
        texts |= Program(firmware, "mip_single", "single", robot=robot).law
    for name in ("law", *more):
        texts |= getattr(written, name)
    write_texts(folder, texts)
    return folder, "mip"


def test_each_changed_line_of_each_template_is_named(
    program, monkeypatch, pytestconfig
):
    """The k-th line of every file is left out, for all k; for each third in the gate,
    where another program begins elsewhere.
    """
    step = 1 if pytestconfig.getoption("--campaign") else 3
    folder, name = program
    for module, asked in (
        (written_files, "law_texts"),
        (written_files, "around_texts"),
        (around, "fill"),
    ):
        monkeypatch.setattr(module, asked, once(getattr(module, asked)))
    assert changes(folder, name)[0] == []
    files = {
        path: path.read_text("utf-8").split("\n")
        for path in sorted(folder.rglob("*.*"))
        if not path.name.endswith(("_gains.h", "_plants.h", ".json"))
        and path != folder / "CMakeLists.txt"
        and not (path.parent == folder and "_single" in path.name)
    }
    assert len(files) == {"mip": len(files), "axis": 9}[name] >= 9
    told = {}
    for path, lines in files.items():
        first = next((k for k, x in enumerate(lines) if "Written by" in x), 0)
        ends = (k for k in range(first, len(lines)) if not lines[k].strip(" *;"))
        told[path] = range(first, next(ends) if first else 0)  # who wrote it
    for k in range(len(files) % step, max(map(len, files.values())), step):
        changed = {p: x for p, x in files.items() if k < len(x) and x[k].strip()}
        changed = {p: x for p, x in changed.items() if k not in told[p]}
        for path, lines in changed.items():
            path.write_text("\n".join([*lines[:k], *lines[k + 1 :]]), "utf-8")
        faults = changes(folder, name)[0]
        for path, lines in changed.items():
            assert any(f"{path.name} isn't what" in fault for fault in faults), k
            path.write_text("\n".join(lines), "utf-8")
    for path, lines in files.items():
        for text in ("int main(void) { return 0; }\n", ""):
            path.write_text(text, "utf-8")
            assert f"{path.name} isn't what" in str(changes(folder, name)[0])
        path.write_bytes("\r\n".join(lines).encode())
        assert changes(folder, name)[0] == []


FORGED = {  # file, what it says, what it says then
    "lateness is never counted": ("{}.c", "s->late + 1", "s->late - 1"),
    "a line in the header": ("{}.h", "#endif", "#define CLAIM 1\n#endif"),
    "another sum": ("{}_tick.h", "total + row", "total - row"),
    "doubles are floats": ("{}_gains.h", "#define {}_SINGLE", "#define double float"),
    "one definition more": ("{}_gains.h", "#endif", "#define {}_STALL 9\n#endif"),
    "one less": ("{}_gains.h", "#define {}_SLACK", "/* */ // {}_SLACK"),
    "another order": ("{}_gains.h", "#define {}_TICK ", "#define {}_SLACK 0\n#define "),
    "another program": ("{}_gains.h", "{}_", "OTHER_"),
    "the sketch's copy": ("{0}_sketch/{0}{1}.c", "return", "abort(); return"),
    "a robot's clock": ("rc_robot.h", "#define RATE_HZ 100", "#define RATE_HZ 50"),
    "pyctrl's clock": ("pyctrl_{}.py", "\nT = 0.01 ", "\nT = 0.02 "),
    "pyctrl's steering": ("pyctrl_{}.py", "\nSTEERS = True", "\nSTEERS = False"),
    "a number that acts": ("pyctrl_{}.py", "COUNTS = ", "COUNTS = exit() or "),
    "a note that acts": ("pyctrl_{}.py", "Written by", '"""\nexit()\n"""Written by'),
    "a note of C that acts": ("rc_{}.c", "Written by", "*/ int x; /* Written by"),
    "the ratio of ROS": ("ros_{0}/ros_{0}.py", "PER_RADIAN = ", "PER_RADIAN = 1"),
}


def test_no_forged_program_needs_a_record_to_be_found(program):
    folder, name = program
    single, tried = "_single" * (folder / f"{name}_single.c").is_file(), 0
    for what, (file, old, new) in FORGED.items():
        path = folder / file.format(name, single)
        old, new = (x.replace("{}", name.upper()) for x in (old, new))
        whole = path.read_text("utf-8") if path.is_file() else ""
        if old not in whole:
            continue  # a file, or a count, of another family
        tried += 1
        path.write_text(whole.replace(old, new), "utf-8")
        try:
            assert changes(folder, name)[0], what
        except ValueError as fault:
            assert "more than definitions" in str(fault)
        path.write_text(whole, "utf-8")
    assert changes(folder, name)[0] == []
    assert tried == {"mip": 8 if single else 14, "axis": 9}[name]


def test_a_robots_own_numbers_are_held_to_the_record_alone(program):
    folder, name = program
    texts = {
        str(path.relative_to(folder)): path.read_text("utf-8")
        for path in sorted(folder.rglob("*.*"))
    }
    file = folder / f"program_{name}.json"
    file.write_text(record(texts, name), "utf-8")
    said = changes(folder, name)
    assert said[0] == [] and "no proof is of them" in said[1][-1]
    tried = 0
    for path, text in texts.items():
        if not path.startswith(("rc_", "pyctrl_", "ros_")):
            continue
        for found in re.finditer(r"(?m)^(?:#define )?[A-Z_]+ (?:= )?-?(\d)", text):
            other = text[: found.start(1)] + "7" + text[found.end(1) :]
            (folder / path).write_text(other, "utf-8")
            assert (changes(folder, name)[0] == []) == (other == text), found[0]
            tried += 1
        (folder / path).write_text(text, "utf-8")
    file.unlink()
    assert tried == 24 or name == "axis" or "mip_single.c" in texts


def test_names_and_their_words_exchanged_are_refused(tmp_path, capsys):
    """They stand in the proof, and in the file of a plant."""
    plant, c = hanging_and_falling()
    plant = sos.SecondOrderSystem(
        plant.M, plant.D, plant.S, plant.B, coordinates=["top", "foot"]
    )
    c = sos.analyse_pid(plant, c.gain.K, region=sos.PoleRegion(sigma=0.1))
    c = c.controller(T=0.01)
    Code(c, "axis").write(tmp_path)
    proof = c.certify(time_limit=60)
    proof.save(tmp_path / "sampled.json")
    (tmp_path / "program_axis.json").unlink()
    assert proof.data["K"]["inputs"] == ["top", "foot", "top'", "foot'"]
    gains = tmp_path / "axis_gains.h"
    good = gains.read_text("utf-8")
    assert verify(tmp_path, capsys)[0] == 0
    for a, b in (("TOP", "FOOT"), ("TOP", "TOP_RATE"), ("U1", "U2")):
        words = (a, b), [x.lower().replace("_rate", "'") for x in (a, b)]
        text = good
        for one, other in words:  # of C, and of the comments
            places = rf"(?<=IN_){one}(?= )|(?<=OUT_){one}(?= )|(?<=/\* ){one}(?=:)"
            others = places.replace(one, other)
            text = re.sub(f"({places})|{others}",
                          lambda m: other if m[1] else one, text)  # fmt: skip
        assert text != good
        gains.write_text(text, "utf-8")
        assert verify(tmp_path, capsys)[0] == 1, (a, b)
    gains.write_text(good, "utf-8")
    told = {x: getattr(plant, x).tolist() for x in "MDSB"}
    for names, code in ((["top", "foot"], 0), (["foot", "top"], 1)):
        file = tmp_path / "plant.json"
        file.write_text(json.dumps(told | {"coordinates": names}), "utf-8")
        status = main(["verify", str(tmp_path / "sampled.json"), "--plant", str(file)])
        assert status == code


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


def test_a_file_that_nothing_was_said_of_is_named(folder, capsys):
    """A profile of moves, or a bench's plants without the record, is no part of it."""
    for path in (folder / "axis_move.h", folder / "axis_sketch" / "axis_more.c"):
        path.write_text("int x;\n", "utf-8")
    status, said = verify(folder, capsys)
    assert status == 0
    assert "axis_move.h, axis_more.c: NOT compared, since nothing" in said
    (folder / "program_axis.json").unlink()
    status, said = verify(folder, capsys)
    assert status == 0
    assert "axis_move.h, axis_plants.h, axis_more.c: NOT compared, since" in said


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
