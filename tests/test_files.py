"""Files: one reader, one writer, and a named error for whatever is broken."""

import ast
import importlib
import inspect
import json
import pkgutil
import re
import sys
import textwrap
from pathlib import Path

import numpy as np
import pytest

import sosbook
from sosbook import proofs
from sosbook.analysis.records import Record
from sosbook.controllers import Code
from sosbook.controllers.written import changes
from sosbook.pendulum import comparison, deployment, recorded, recording
from sosbook.pendulum.command import main
from sosbook.pendulum.log import Log
from sosbook.pendulum.modelled import Model
from sosbook.pendulum.rig import DATA
from sosbook.pendulum.robot import Robot
from sosbook.pendulum.ticks import FORMATS, TickLog
from sosbook.plants import MeasuredResponse
from sosbook.plants.files import load_plant, plant_and_asked
from sosbook.proofs.command import read_plant_file
from sosbook.proofs.subject import (
    compare_code,
    compare_gain,
    compare_plant,
    proofs_beside,
)
from sosbook.requirements.wish import wish_in
from sosbook.runtime import matrix_files, reading, tables
from sosbook.runtime.saying import visible
from sosbook.runtime.writing import write_file, write_texts
from tests.axis import axis
from tests.broken_files import BROKEN, ESC
from tests.cases import by_turns
from tests.processes import process

PACKAGE = Path(sosbook.__file__).parent
ONE = "1\n"


def in_folder(ending):
    """Read a plant whose M is in a file of this ending."""

    def read(path):
        for name in "DSB":
            (path.parent / f"{name}.csv").write_text(ONE, "utf-8")
        path.rename(path.with_name(f"M.{ending}"))
        return load_plant(path.parent)

    return read


def as_gains(ask):
    """Ask about the program whose numbers are in this file."""

    def read(path):
        return ask(path.rename(path.with_name("axis_gains.h")))

    return read


def as_record(path):
    """Ask whether a program was changed since this record of it was written."""
    texts = Code(axis(), "axis").texts
    write_texts(path.parent, {k: t for k, t in texts.items() if "program" not in k})
    return changes(path.rename(path.with_name("program_axis.json")).parent, "axis")


def body(path):
    """The beginning of a log, in a folder above that of a broken file."""
    log = path.parent.parent / "body.csv"
    if not log.exists():
        lines = (DATA / "body.csv").read_text("utf-8").splitlines(keepends=True)
        log.write_text("".join(lines[:60]), "utf-8")
    return log


def numbers_in(path):
    return reading.numbers_of(path, reading.read_rows(path), ["t", "V"])


MATRIX_READERS = {
    f"runtime.{module.__name__.rpartition('.')[2]}.{name}": (
        ending,
        getattr(module, name),
    )
    for module, names in {
        matrix_files: {
            "read_npy": "npy",
            "read_npz": "npz",
            "read_sparse": "npz",
            "read_mtx": "mtx",
            "read_harwell": "rsa",
            "read_mat": "mat",
            "read_op4": "op4",
            "read_punch": "pch",
        },
        tables: {"read_csv": "csv", "read_entries": "mtx", "read_dofs": "dof"},
    }.items()
    for name, ending in names.items()
}
#: From a function that takes a file, to the endings of files and how it reads them.
READERS = {
    "plants.files.load_plant": [
        *((ending, load_plant) for ending in ("json", "toml", "npz", "mat", "op4")),
        *((ending, in_folder(ending)) for ending in ("csv", "npy", "mtx", "npz", "rb")),
    ],
    "plants.files.plant_and_asked": [("json", plant_and_asked)],
    "plants.measured.MeasuredResponse.read": [("csv", MeasuredResponse.read)],
    "proofs.command.read_plant_file": [
        (ending, read_plant_file) for ending in ("json", "toml", "op4")
    ],
    "requirements.wish.wish_in": [("json", wish_in)],
    "requirements.wish.read_wish": [
        ("json", lambda x: sosbook.read_wish("The loop settles every mode in 1 s", x))
    ],
    "proofs.subject.compare_plant": [
        *(
            (ending, lambda x: compare_plant({}, x))
            for ending in ("json", "toml", "npz", "mat")
        )
    ],
    "proofs.subject.compare_gain": [("json", lambda x: compare_gain({}, x))],
    "proofs.subject.compare_code": [("h", as_gains(lambda x: compare_code(None, x)))],
    "proofs.subject.proofs_beside": [("h", as_gains(proofs_beside))],
    "controllers.written.changes": [
        ("h", as_gains(lambda x: changes(x.parent, "axis"))),
        ("json", as_record),
    ],
    "exact.proof_file.load": [("json", proofs.load)],
    "exact.proof_file.ProofFile.load": [("json", proofs.DesignProof.load)],
    "analysis.records.Record.read": [
        ("csv", lambda x: sosbook.Record.read(x, ["V"], ["gyro"]))
    ],
    "pendulum.log.Log.read": [("csv", Log.read)],
    "pendulum.ticks.TickLog.read": [("csv", TickLog.read)],
    "pendulum.robot.Robot.read": [("toml", Robot.read)],
    "pendulum.modelled.Model.read": [("json", Model.read)],
    "pendulum.recorded.check_recording": [
        ("csv", recorded.check_recording),
        ("toml", lambda x: recorded.check_recording(body(x), x)),
    ],
    "pendulum.comparison.compare": [
        ("csv", lambda x: comparison.compare(x, DATA)),
        ("json", lambda x: comparison.compare(ticks(x.parent), x)),
    ],
    "pendulum.deployment.deploy": [
        ("csv", lambda x: deployment.deploy(x, DATA / "wheels.csv", ROBOT)),
        ("csv", lambda x: deployment.deploy(body(x), x, ROBOT)),
        ("toml", lambda x: deployment.deploy(*LOGS, x)),
    ],
    "pendulum.recording.write_recorders": [
        ("toml", lambda x: recording.write_recorders(x, x.parent / "out"))
    ],
    "runtime.reading.read_json": [("json", reading.read_json)],
    "runtime.reading.read_toml": [("toml", reading.read_toml)],
    "runtime.reading.read_data": [
        (ending, reading.read_data) for ending in ("json", "toml")
    ],
    "runtime.reading.read_rows": [("csv", reading.read_rows)],
    "runtime.reading.numbers_of": [("csv", numbers_in)],
    "runtime.reading.read_text": [("txt", reading.read_text)],
    "runtime.reading.read_bytes": [("txt", reading.read_bytes)],
    **{name: [case] for name, case in MATRIX_READERS.items()},
}
#: Readers of contents of which some of the files are right.
TAKES = {
    "runtime.reading.numbers_of",  # its caller looks at the names
    "runtime.reading.read_bytes",
    "runtime.reading.read_text",
    "runtime.reading.read_rows",
    "runtime.reading.read_json",
    "runtime.reading.read_toml",
    "runtime.reading.read_data",
    *MATRIX_READERS,
}
#: What takes a path and reads no file of others.
WRITERS = {
    "exact.proof_file.ProofFile.save",
    "exact.proof.Unproven.save",  # always an error
    "proofs.command.check_place",
    "proofs.folder.check_folder",  # reads its own record, tried in test_command
    "proofs.folder.write_folder",
    "pendulum.comparison.write_comparison",
    "controllers.compiler.build",
    "controllers.compiler.loaded",
    "controllers.program.Code.write",
    "controllers.report.write_report",
    "controllers.sampled_design.SampledDesign.report",
    "exact.quick.verify",  # the package reads whatever this leaves
    "loops.loop.Loop.report",
    "synthesis.gains.Gains.report",
    "pendulum.compiled.Compiled.__init__",
    "pendulum.log.Log.write",
    "pendulum.proven.Deployment.write",
    "pendulum.recording.board_files",  # a name in texts
    "runtime.writing.write_texts",
    "pendulum.report.write_page",
    "pendulum.report.write_report",
    "pendulum.rig.main",
    "pendulum.ticks.TickLog.write",
    "runtime.reading.named",
    "runtime.reading.path_of",
    "runtime.writing.may_replace",
    "runtime.writing.write_file",
}
ROBOT, LOGS = DATA / "gearmotors.toml", (DATA / "body.csv", DATA / "wheels.csv")


def ticks(folder):
    """A file of three ticks."""
    rows = [[k, 0, 0, 0, 0, 0, 0, 0, 8, -1 if k == 0 else 0] for k in range(3)]
    TickLog(**dict(zip(FORMATS, np.array(rows, float).T))).write(folder / "ticks.csv")
    return folder / "ticks.csv"


def functions():
    """Public functions and methods of the package, by name, with their docstrings."""
    for found in pkgutil.walk_packages(sosbook.__path__, "sosbook."):
        if re.search(r"\.(book|checker)\b|__main__$", found.name):
            continue  # the checker has no path but its program's
        module = importlib.import_module(found.name)
        for name, thing in vars(module).items():
            if name.startswith("_") or getattr(thing, "__module__", "") != found.name:
                continue
            home = f"{found.name}.{name}".removeprefix("sosbook.")
            if inspect.isfunction(thing):
                yield home, thing, inspect.getdoc(thing) or ""
            for key, member in vars(thing).items() if inspect.isclass(thing) else ():
                member = getattr(member, "__func__", member)
                if not inspect.isfunction(member):
                    continue
                about = inspect.getdoc(thing if key == "__init__" else member) or ""
                if key == "__init__" or not key.startswith("_"):
                    yield f"{home}.{key}", member, about


def test_every_function_that_takes_a_path_is_tried():
    """Found by the names of parameters, and by their kinds in docstrings."""
    found = set()
    for name, function, text in functions():
        taken = inspect.signature(function).parameters
        documented = re.findall(r"^(\w[\w, ]*) : .*\b[Pp]ath(?:_like)?\b", text, re.M)
        paths = {x for words in documented for x in words.split(", ")} & taken.keys()
        if paths or any(re.search(r"path|folder|(?<!pro)file", x) for x in taken):
            found.add(name)
    assert found == READERS.keys() | WRITERS


CASES = [
    (name, ending, read) for name, cases in READERS.items() for ending, read in cases
]


@pytest.mark.parametrize("what", by_turns(BROKEN, 0))
def test_a_broken_file_is_named(what, tmp_path):
    """By every reader, in one line that commands no terminal."""
    for k, (name, ending, read) in enumerate(CASES):
        path = tmp_path / str(k) / f"broken.{ending}"
        path.parent.mkdir()
        path.write_bytes(BROKEN[what])
        try:
            read(path)
        except (ValueError, OSError) as error:
            text = str(error)
            assert str(path.parent) in text, (name, ending, text)
            assert len(text) < 1000 + 4 * len(str(path)), (name, ending)
            assert visible(text) == text, (name, ending)
        else:
            assert name in TAKES, (name, ending)


@pytest.mark.parametrize("name, ending, read", CASES)
def test_what_is_no_file_is_named(name, ending, read, tmp_path):
    if name != "plants.files.load_plant" or ending in ("json", "npz", "mat"):
        with pytest.raises(OSError, match="none"):
            read(tmp_path / "none" / f"none.{ending}")


@pytest.mark.parametrize("between", [";", "\t", " ; "])
def test_columns_of_a_record_may_have_other_separators(between, tmp_path):
    """Those of its first row; a decimal comma is named, and nothing is guessed."""
    file = tmp_path / "log.csv"
    readers = [
        (["t", "V", "gyro"], lambda: Log.read(file).gyro),
        (["t", "V", "gyro"], lambda: Record.read(file, ["V"], ["gyro"]).y[:, 0]),
        (["Hz", "re", "im"], lambda: MeasuredResponse.read(file).H.imag),
    ]
    rows = [[f"{0.01 * k:.3f}", "1", f"{9.81e-3 * k * k:.6f}"] for k in range(1, 9)]
    for names, read in readers:
        text = "\r\n".join(between.join(row) for row in [names, *rows])
        file.write_text("\ufeff" + text, "utf-8", newline="")
        assert read() == pytest.approx([float(x) for *_, x in rows], abs=0)
        file.write_text(text.replace(".", ","), "utf-8")
        with pytest.raises(ValueError, match=r"csv: line 2: '\s*0,0.* with a point"):
            read()


@pytest.mark.parametrize("read", [load_plant, proofs.load, Log.read, Model.read])
@pytest.mark.parametrize("wrong", [None, 0, b"x", "a\0b", ["x"]])
def test_what_is_no_path_is_named(read, wrong):
    with pytest.raises(ValueError, match="the name of a file or folder is needed"):
        read(wrong)


def test_a_file_beyond_the_limit_is_not_read(tmp_path, monkeypatch):
    monkeypatch.setattr(reading, "MOST_BYTES", 1000)
    (tmp_path / "x.json").write_bytes(b" " * 1001)
    with pytest.raises(ValueError, match=r"x\.json has more than 1000 bytes"):
        proofs.load(tmp_path / "x.json")


def damaged(value):
    """Contents of JSON with one thing changed, everywhere in turn."""
    wrong = None, 3, "1_0", [], {}, True, [[[0.5]]], 10**300, ESC
    yield from wrong
    items = ()
    if isinstance(value, dict):
        items = value.items()
        for key in value:
            yield {k: v for k, v in value.items() if k != key}
    elif isinstance(value, list):
        items = list(enumerate(value))[:2]
    for key, inner in items:
        for other in damaged(inner):
            changed = value.copy()
            changed[key] = other
            yield changed


def test_a_model_that_lacks_something_is_named(tmp_path):
    from tests.test_mip_compare import MODEL

    path = tmp_path / "model_x.json"
    tried = 0
    for table in damaged(json.loads(MODEL.text)):
        path.write_text(json.dumps(table), "utf-8")
        try:
            Model.read(path)
        except ValueError as error:
            assert str(path) in str(error)
            tried += 1
    assert tried > 500


# ---------------------------------------------------------------- one home each

#: What reads or writes by itself, and why.
OWN = {
    "runtime/matrix_files.py": "reads",
    "runtime/reading.py": "reads",
    "runtime/writing.py": "writes",
    "display/card.py": "a file of the package",
    "book/elements/scripts.py": "files of the package",
    "book/printing/printing.py": "the book's own pages",
    "book/printing/contents.py": "the book's own pages",
    "book/printing/__main__.py": "the book's own pages",
    "book/notebooks.py": "the book's own notebooks",
    "book/widgets/live.py": "messages of the browser",
    "controllers/template.py": "files of the package",
    "pendulum/written.py": "a file of the package",
    "exact/checker/kernel.py": "stands alone",
    "exact/checker/verdict.py": "stands alone",
    "exact/checker/__init__.py": "its own files",
}
METHODS = {"read_text", "read_bytes", "write_text", "write_bytes"}
LIBRARIES = {"json": ("load", "loads"), "tomllib": ("load", "loads")}
LIBRARIES |= {"csv": ("reader", "DictReader", "writer")}
LIBRARIES |= {"np": ("load", "save", "savez", "loadtxt", "savetxt", "fromfile")}
LIBRARIES |= {"sio": ("loadmat", "savemat", "mmread", "mmwrite")}


def opened(file):
    """Names of functions that read or write files and that a module calls."""
    text = file.read_text("utf-8")
    names = {"open", *METHODS}.union(*LIBRARIES.values())
    mentioned = names & {*re.findall(r"\w+(?=\()", text)}
    for node in ast.walk(ast.parse(text)) if mentioned else ():
        if not isinstance(node, ast.Call):
            continue
        if isinstance(node.func, ast.Name):
            if node.func.id in {"open", *LIBRARIES["sio"]}:
                yield node.func.id
        elif isinstance(node.func, ast.Attribute):
            name, owner = node.func.attr, getattr(node.func.value, "id", "")
            opens = name == "open" and node.args and owner != "os"
            if opens or name in METHODS or name in LIBRARIES.get(owner, ()):
                yield name


def test_files_are_read_and_written_in_one_place_each():
    for file in PACKAGE.rglob("*.py"):
        name = file.relative_to(PACKAGE).as_posix()
        if name not in OWN and file.parent.name != "templates":  # a user's programs
            assert not list(opened(file)), f"{name}: use sosbook.runtime.reading"


# ------------------------------------------------------------------- writing
def test_a_full_disk_leaves_the_old_file_whole(tmp_path):
    """Under a limit of the size of files; nothing is left beside it."""
    pytest.importorskip("resource")
    program = textwrap.dedent(
        """
        import resource, sys
        from sosbook.runtime.writing import write_file
        write_file(sys.argv[1], "old")
        resource.setrlimit(resource.RLIMIT_FSIZE, (500, 500))
        try:
            write_file(sys.argv[1], "new" * 1000)
        except OSError as error:
            print(error)
        """
    )
    path = tmp_path / "proof.json"
    done = process(sys.executable, "-c", program, path, check=True)
    assert str(path) in done.stdout
    assert path.read_text("utf-8") == "old"
    assert [x.name for x in tmp_path.iterdir()] == ["proof.json"]


def test_a_link_and_permissions_stay(tmp_path):
    real, link = tmp_path / "real", tmp_path / "link"
    real.write_text("old", "utf-8")
    real.chmod(0o640)
    link.symlink_to(real)
    write_file(link, "new")
    assert link.is_symlink() and real.read_text("utf-8") == "new"
    assert real.stat().st_mode & 0o777 == 0o640
    write_file(tmp_path / "new", b"new")
    (tmp_path / "plain").write_text("", "utf-8")
    plain, new = (tmp_path / "plain").stat(), (tmp_path / "new").stat()
    assert plain.st_mode == new.st_mode
    with pytest.raises(OSError, match="real"):
        write_file(real / "b", "in a file")
    with pytest.raises(IsADirectoryError):
        write_file(tmp_path, "a folder")


def test_a_proof_replaces_nothing_but_a_proof(tmp_path):
    one = sosbook.SecondOrderSystem([[1]], [[1]], [[1]], [[1]])
    proof, path = sosbook.design_pid(one).certify(), tmp_path / "plant.json"
    path.write_text(json.dumps({"plant": {}}), "utf-8")
    with pytest.raises(FileExistsError, match=r"plant\.json is there already"):
        proof.save(path)
    assert path.read_text("utf-8") == '{"plant": {}}'
    proof.save(tmp_path / "proof.json")
    proof.save(tmp_path / "proof.json")
    assert proofs.load(tmp_path / "proof.json").proven


def test_programs_replace_nothing_unasked(tmp_path, capsys):
    robot = Robot.read(ROBOT)
    paths = recording.write_recorders(robot, tmp_path)
    assert recording.write_recorders(robot, tmp_path) == paths  # the same texts
    (pins,) = (x for x in paths if x.name == "robot_io.cpp")
    pins.write_text("// my pins\n", "utf-8")
    before = {x: x.read_bytes() for x in paths}
    with pytest.raises(FileExistsError, match=r"robot_io\.cpp is there already"):
        recording.write_recorders(robot, tmp_path)
    with pytest.raises(FileExistsError):
        recording.write_recorders(robot.but(T=0.02), tmp_path)
    assert before == {x: x.read_bytes() for x in paths}  # all or nothing
    recording.write_recorders(robot, tmp_path, replace=True)
    assert "my pins" not in pins.read_text("utf-8")
    pins.write_text("// my pins\n", "utf-8")
    with pytest.raises(SystemExit):
        main(["record", str(ROBOT), str(tmp_path)])
    assert "or --replace" in capsys.readouterr().err
    assert main(["record", str(ROBOT), str(tmp_path), "--replace"]) == paths
    (tmp_path / "balance.c").write_text("mine", "utf-8")
    with pytest.raises(FileExistsError):
        write_texts(tmp_path, {"balance.c": "other"})
