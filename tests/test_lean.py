"""The wheel in an environment of numpy, scipy and python-flint alone."""

import importlib.metadata
import json
import os
import re
import shutil
import sys
import zipfile
from pathlib import Path

import pytest

import sosbook
from sosbook.pendulum.rig import DATA, shipped
from sosbook.runtime.libraries import EXTRAS
from tasks import interpreter
from tests.processes import compiled, process

ROOT = Path(__file__).resolve().parent.parent
CORE = ("numpy", "scipy", "python-flint")
SOURCES = ("pyproject.toml", "README.md", "LICENSE", "LICENSE-TEXT")

#: What pip asks for after half a second of its own and a third build of the metadata.
BUILD = """
import sys
from setuptools.build_meta import build_wheel
build_wheel(sys.argv[1])
"""
pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def wheels(tmp_path_factory):
    """The package's and the book's, built from a copy, so that nothing is left in the
    tree; no network.
    """
    source = tmp_path_factory.mktemp("source")
    for name in SOURCES:
        shutil.copy(ROOT / name, source)
    leave = shutil.ignore_patterns("__pycache__", "*.egg-info")
    shutil.copytree(ROOT / "sosbook", source / "sosbook", ignore=leave)
    made = []
    for project in source, source / "sosbook" / "book":
        out = source / f"wheel {len(made)}"
        run(sys.executable, "-c", BUILD, out, cwd=project)
        made += out.glob("*.whl")
    return made


@pytest.fixture(scope="module")
def lean(wheels, tmp_path_factory):
    """The Python of an environment with the package and the core's libraries."""
    return environment(tmp_path_factory.mktemp("lean"), wheels[:1])


@pytest.fixture(scope="module")
def booked(wheels, tmp_path_factory):
    """The same with the book's wheel."""
    return environment(tmp_path_factory.mktemp("booked"), wheels)


def environment(folder, wheels):
    """The Python of a new environment in a ``folder``."""
    run(sys.executable, "-m", "venv", "--without-pip", folder / "env")
    python = folder / "env" / interpreter().relative_to(interpreter().parents[1])
    shown = folder / "libraries"
    shown.mkdir()
    for name in CORE:
        expose(importlib.metadata.distribution(name), shown)
    site = run(python, "-c", "import sysconfig; print(sysconfig.get_path('purelib'))")
    (Path(site.strip()) / "libraries.pth").write_text(f"{shown}\n", "utf-8")
    for wheel in wheels:  # as pip does, but for a second of its own
        with zipfile.ZipFile(wheel) as archive:
            archive.extractall(site.strip())
    compiled(Path(site.strip(), "sosbook"), ROOT / "sosbook", beside=True)
    return python


def expose(distribution, folder):
    """Link the files of an installed distribution into a folder."""
    tops = {f.parts[0] for f in distribution.files} - {"..", "__pycache__"}
    for name in sorted(tops):
        path = Path(distribution.locate_file(name))
        try:
            os.symlink(path, folder / name)
        except OSError:  # Windows lets few users do so
            copy = shutil.copytree if path.is_dir() else shutil.copy
            copy(path, folder / name)


def run(*command, status=0, **more):
    """The output of a command, in UTF-8, away from the project's folder."""
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
    done = process(
        *command,
        env=environment | {"PYTHONUTF8": "1"},
        cwd=more.get("cwd", Path(sys.prefix)),
    )
    assert done.returncode == status, done.stdout + done.stderr
    return done.stdout + done.stderr * (status != 0)


def contents(wheel):
    """The files of a wheel, and what it needs without extras."""
    with zipfile.ZipFile(wheel) as archive:
        names = set(archive.namelist())
        (meta,) = (n for n in names if n.endswith(".dist-info/METADATA"))
        lines = archive.read(meta).decode().splitlines()
    needs = [line.split(": ")[1] for line in lines if line.startswith("Requires-Dist")]
    core = [re.match("[a-z-]+", line)[0] for line in needs if "extra ==" not in line]
    return {n for n in names if ".dist-info/" not in n}, sorted(core)


def test_each_file_is_in_one_wheel_and_the_package_has_none_of_the_book(wheels):
    files = {
        p.relative_to(ROOT).as_posix()
        for p in (ROOT / "sosbook").rglob("*")
        if p.is_file() and "__pycache__" not in p.parts
    }
    book = {name for name in files if name.startswith("sosbook/book/")}
    (ours, core), (its, more) = map(contents, wheels)
    assert core == sorted(CORE) and more == ["sosbook"]
    assert ours == files - book and "sosbook/py.typed" in ours
    assert its == book - {"sosbook/book/pyproject.toml"}


def test_both_wheels_have_the_version_that_the_package_says(wheels):
    assert [wheel.name.split("-")[1] for wheel in wheels] == [sosbook.__version__] * 2


def first_block():
    """The README's first program."""
    text = (ROOT / "README.md").read_text("utf-8")
    return re.search("```python\n(.*?)```", text, re.S)[1]


WATCH = """
import importlib.metadata, json, os, sys, sysconfig
owners = importlib.metadata.packages_distributions()
standard = os.path.realpath(sysconfig.get_path("stdlib"))
print(json.dumps(dict(
    proven=design.certify().proven, status=design.status,
    where=sos.__file__, others=sum(not m.startswith("sosbook") for m in sys.modules),
    owners=sorted({o for m in sys.modules for o in owners.get(m.split(".")[0], ())}),
    rooms=sorted({m.split(".")[1] for m in sys.modules
                  if m.startswith("sosbook.") and m.count(".") > 1}))))
"""


EACH = "[getattr(sos, name) for name in sos.__all__]"


def test_the_first_program_of_the_readme_runs_and_is_proven(lean):
    """And all names are there, without the book."""
    program = first_block() + WATCH + EACH
    found = json.loads(run(lean, "-I", "-c", program).splitlines()[-1])
    assert found["proven"] is True and found["status"] == "feasible"
    assert str(ROOT) not in found["where"]
    assert set(found["owners"]) == {"sosbook", *CORE}
    assert not {"book", "pendulum", "delay", "sampled", "studies"} & set(found["rooms"])
    assert found["others"] < 750  # modules of the libraries and of Python


ABSENT = """
import importlib, json
import sosbook as sos
plant = sos.SecondOrderSystem([[1]], [[1]], [[2]], [[1]], [[1]])
design = sos.design_pid(plant)
observer = sos.design_observer(plant, [[-1, -1]], [[1, 0, 0, 0], [0, 1, 0, 0],
    [0, 0, 1, 0], [0, 0, 0, 1]], [[1]])
uses = dict(
    control=[design.closed_loop, design.open_loop, observer.controller,
             lambda: sos.sampled.c2d(plant, 0.1)],
    matplotlib=[lambda: importlib.import_module("sosbook.book.plots")],
    ipywidgets=[lambda: importlib.import_module("sosbook.book.widgets")],
    nbformat=[lambda: importlib.import_module("sosbook.book.notebooks")],
    cvxpy=[design.to_cvxpy])
said = {name: [] for name in uses}
for name, calls in uses.items():
    for call in calls:
        try:
            call()
        except ImportError as error:
            said[name].append(str(error))
print(json.dumps(said))
"""


def test_what_is_missing_is_named_with_the_command_that_installs_it(booked):
    said = json.loads(run(booked, "-I", "-c", ABSENT).splitlines()[-1])
    assert [len(texts) for texts in said.values()] == [4, 1, 1, 1, 1]
    for name, texts in said.items():
        (extra,) = (e for e, names in EXTRAS.items() if name in names)
        for text in texts:
            assert text.startswith(f"{name} is needed")
            assert text.endswith(f'pip install "sosbook[{extra}]"')


def test_the_command_installs_onto_what_is_there(lean):
    """pip takes the installed package and looks for the library, in vain here."""
    pip = (sys.executable, "-m", "pip", "--python", lean, "install", "--dry-run")
    said = run(*pip, "--no-index", "sosbook[plot]", status=1)
    assert "No matching distribution found for matplotlib" in said


EVERY = """
import importlib, pkgutil
import sosbook as sos
absent = []
for name in sos.__all__:
    getattr(sos, name)
for room in ("book", "studies"):
    for _, name, _ in pkgutil.iter_modules(getattr(sos, room).__path__):
        try:
            importlib.import_module(f"sosbook.{room}.{name}")
        except ImportError as error:
            absent.append(name)
print(*absent)
from sosbook.book import reproduction
reproduction.rows()
"""


def test_only_pictures_sliders_and_the_books_tables_need_more(booked):
    absent, said = run(booked, "-I", "-c", EVERY, status=1).split("\n", 1)
    absent = absent.split()
    assert set(absent) >= {"plots", "widgets"}
    there = {"thesis", "elements", "counterexamples", "tables", "maps", "polytopes"}
    assert there.isdisjoint(absent)
    assert "pip install" in said


def test_without_the_book_its_lack_is_said(lean):
    said = run(lean, "-I", "-c", "import sosbook as sos; sos.book.thesis", status=1)
    assert "book needs sosbook.book, which isn't there" in said


#: python -m sosbook.pendulum, with less than a minute's rest before it writes, and with
#: sampled loops for one of three delays.
BRIEFLY = """
import runpy
from sosbook.pendulum import proven, tuning
proven.REST_SECONDS, tuning.DELAY_SHARES = 6.0, (0.0,)
runpy.run_module("sosbook.pendulum", run_name="__main__", alter_sys=True)
"""


def test_the_robots_command_needs_nothing_else(lean, tmp_path):
    for name in ("body", "wheels"):
        shipped(name).part(slice(2000)).write(tmp_path / f"{name}.csv")
    names = DATA / "thesis.toml", "body.csv", "wheels.csv", "new"
    command = (lean, "-I", "-c", BRIEFLY, *names)
    said = run(*command, "--cells", 200, "--R", 20, cwd=tmp_path)
    written = sorted(p.name for p in (tmp_path / "new").iterdir())
    assert "identification.html" in written
    assert {Path(name).suffix for name in written} >= {".c", ".h", ".html", ".py"}
    assert "proven" in said
