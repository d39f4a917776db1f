"""The commands: what they call, on this system and on others, and in CI."""

import hashlib
import json
import re
import sys
import tomllib
import zipfile
from importlib import metadata
from pathlib import Path
from types import SimpleNamespace

import pytest
import yaml
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

import sosbook
import tasks
from tests import browser, compiler, conftest
from tests.processes import process

ROOT = Path(__file__).resolve().parent.parent
WORKFLOWS = sorted((ROOT / ".github" / "workflows").glob("*.yml"))


@pytest.fixture
def called(monkeypatch):
    """What `tasks` would call, with its environment; nothing is run."""
    calls = []

    def call(*command, log=None, **extra):
        calls.append(([str(word) for word in command], extra))
        return 0

    monkeypatch.setattr(tasks, "call", call)
    monkeypatch.setattr(tasks, "prepare", lambda: None)
    return calls


def test_the_help_names_every_command_and_only_these():
    named = re.findall(r"python3 tasks\.py (\w+)", tasks.__doc__)
    assert set(named) == set(tasks.TASKS)


def test_the_commands_need_nothing_but_python():
    done = process(sys.executable, "-S", "-E", ROOT / "tasks.py", "nonsense")
    assert done.returncode and done.stderr.strip() == tasks.__doc__.strip()


SOME = "tests/test_empty_matrices.py"
COLLECT_TWICE = """
import pytest, sys
for more in ([], ["--campaign"]):
    if status := pytest.main([*sys.argv[1:], *more]):
        sys.exit(status)
"""


@pytest.mark.slow
def test_the_campaigns_run_when_they_are_called_and_never_else():
    words = "--collect-only", "-qq", "-p", "no:cacheprovider", *tasks.WITHOUT_NBVAL
    command = sys.executable, "-c", COLLECT_TWICE, *words, SOME
    listed = process(*command, cwd=ROOT, check=True).stdout
    few, all_of_them = map(int, re.findall(r"\.py: (\d+)", listed))
    assert 0 < few < all_of_them


@pytest.mark.parametrize("cores, count", [(None, 2), (1, 2), (2, 2), (3, 3), (64, 4)])
def test_as_many_processes_as_cores_and_two_to_four(called, monkeypatch, cores, count):
    monkeypatch.setattr(tasks.os, "cpu_count", lambda: cores)
    tasks.pytest("tests")
    ((words, _),) = called
    assert words[words.index("-n") + 1] == str(count)


TAKES = r"""
import subprocess, sys, time
import pytest

BUSY = "import time; to = time.process_time() + 0.2\nwhile time.process_time() < to: 0"
SERVE = f"import sys\nfor line in sys.stdin: exec({BUSY!r}); print(line)"

@pytest.fixture(scope="module")
def server():
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
    with subprocess.Popen([sys.executable, "-uc", SERVE], **pipes) as server:
        yield server

@pytest.fixture
def slow():
    exec(BUSY)

def test_served(server):
    print("now", file=server.stdin, flush=True)
    assert server.stdout.readline()

def test_short(server):
    pass

def test_long(slow):
    subprocess.run([sys.executable, "-c", BUSY], check=True)
"""


def test_what_each_test_takes_is_stored(tmp_path):
    """By itself and in processes, of fixtures, too, from workers, and, on Linux, in a
    process that goes on, as a browser does.
    """
    (tmp_path / "test_one.py").write_text(TAKES, "utf-8")
    words = "-n", "1", "-p", "tests.durations", *tasks.WITHOUT_NBVAL
    command = sys.executable, "-m", "pytest", "--rootdir", tmp_path, *words, tmp_path
    done = process(*command, cwd=ROOT)
    stored = json.loads((tmp_path / "_build" / "durations.json").read_text("utf-8"))
    taken = {name.split("test_")[-1]: seconds for name, seconds in stored}
    assert list(taken) == sorted(taken, key=taken.get, reverse=True)
    # A clock counts in hundredths.
    assert 0.3 < taken["long"] < 3 and 0 <= taken["short"] < 0.2
    assert taken["served"] > 0.15 or sys.platform != "linux"
    assert "3 passed" in done.stdout and "CPU seconds; each test" in done.stdout


def test_a_pull_of_tests_runs_them_all_beside_the_build(called, monkeypatch, tmp_path):
    monkeypatch.chdir(ROOT)
    monkeypatch.setattr(tasks, "BUILD", tmp_path)
    monkeypatch.setattr(tasks.browser, "ensure", lambda python: "chromium")
    monkeypatch.setattr(tasks.compiler, "ensure", lambda python: ["cc"])
    assert tasks.test(["-k", "word"]) == 0
    (test, extra), (build, _) = sorted(called, key=lambda call: "build" in call[0])
    assert build[:3] == [str(tasks.PYTHON), *tasks.JUPYTER_BOOK]
    assert "-W" in build and "-n" in build and "--all" in build
    assert {
        str(path.relative_to(ROOT)) for path in (ROOT / "book").glob("*.ipynb")
    } <= {*test}
    assert test[-2:] == ["-k", "word"] and "-m" not in test[3:]
    assert Path(extra["SOSBOOK_BUILT"]).read_text("utf-8") == "0"


@pytest.mark.parametrize(
    "chromium, cc, continuous, status",
    [(None, ["cc"], "1", 1), ("chromium", None, "1", 1), (None, None, "", 0)],
)
def test_what_is_missing_is_a_failure_in_ci_and_said_elsewhere(
    called, monkeypatch, capsys, tmp_path, chromium, cc, continuous, status
):
    monkeypatch.chdir(ROOT)
    monkeypatch.setattr(tasks, "BUILD", tmp_path)
    monkeypatch.setenv("CI", continuous)
    monkeypatch.setattr(tasks.browser, "ensure", lambda python: chromium)
    monkeypatch.setattr(tasks.compiler, "ensure", lambda python: cc)
    assert tasks.test([]) == status
    said = capsys.readouterr().err
    assert (browser.MISSING in said) == (chromium is None)
    assert (compiler.MISSING in said) == (cc is None)
    tested = [" ".join(words) for words, _ in called if "--nbval" in words]
    assert len(tested) == (status == 0)
    assert not any(name in x for x in tested for name in compiler.CHAPTERS)


def test_the_quick_lane_runs_on_each_python_that_is_here(called, monkeypatch, capsys):
    """A script that calls itself Python 3.10, or is none, isn't taken."""
    here = tasks.interpreters()
    assert min(here) >= 11 and sys.version_info.minor in here
    for minor, program in here.items():
        done = process(program, "-c", "import sys; print(sys.version_info.minor)")
        assert done.stdout.split() == [str(minor)]
    monkeypatch.setattr(tasks, "interpreters", lambda: {11: "one", 13: "other"})
    assert tasks.pythons(["-k", "regions"]) == 0
    for (words, extra), (program, version) in zip(
        called, (("one", "3.11"), ("other", "3.13")), strict=True
    ):
        assert words == [
            program,
            str(ROOT / "tasks.py"),
            "test",
            "quick",
            "-k",
            "regions",
        ]
        assert Path(extra["SOSBOOK_VENV"]).parts[-2:] == ("pythons", version)
    monkeypatch.setattr(tasks, "call", lambda *words, **_: words[0] == "other")
    assert tasks.pythons([]) == 1
    assert "fails on Python 3.13." in capsys.readouterr().err


def test_a_book_that_does_not_build_fails_the_tests(
    called, monkeypatch, capsys, tmp_path
):
    monkeypatch.chdir(ROOT)
    monkeypatch.setattr(tasks, "BUILD", tmp_path)
    monkeypatch.setattr(tasks.browser, "ensure", lambda python: "chromium")
    monkeypatch.setattr(tasks.compiler, "ensure", lambda python: ["cc"])

    def call(*command, log=None, **extra):
        if log:
            log.write("WARNING: a é label twice".encode())
        return 2 if log else 0

    monkeypatch.setattr(tasks, "call", call)
    assert tasks.test([]) == 1
    assert "a é label twice" in capsys.readouterr().err
    with pytest.raises(AssertionError, match="does not build"):
        conftest.wait_for(tmp_path / "book.status")


def test_the_second_worker_collects_what_the_first_has_compiled(monkeypatch, tmp_path):
    """Beside a build; alone, or in the first worker, nobody is awaited."""
    config, asked = SimpleNamespace(), []
    session = SimpleNamespace(config=config)
    monkeypatch.setattr(conftest.time, "sleep", lambda s: asked.append(s) or first())

    def first():
        config.workerinput = dict(workerid="gw0", testrunuid="run")
        conftest.pytest_collection(session)
        conftest.pytest_collection_finish(session)

    conftest.pytest_collection(session)
    conftest.pytest_collection_finish(session)
    monkeypatch.setenv("SOSBOOK_BUILT", str(tmp_path / "book.status"))
    conftest.pytest_collection(session)
    assert not asked and not [*tmp_path.iterdir()]
    config.workerinput = dict(workerid="gw1", testrunuid="run")
    conftest.pytest_collection(session)
    assert len(asked) == 1


# Tools on other systems


def test_packages_come_once_and_without_them_nothing_runs(monkeypatch, tmp_path):
    ran, status = [], 1
    monkeypatch.setattr(tasks, "VENV", tmp_path)
    monkeypatch.setattr(tasks, "STAMP", tmp_path / "ready")
    monkeypatch.setattr(tasks, "works", lambda *command: True)
    monkeypatch.setattr(tasks, "call", lambda *words: ran.append(words) or status)
    with pytest.raises(SystemExit, match="pip could not install requirements.txt"):
        tasks.prepare()
    status = 0
    for _ in range(2):
        tasks.prepare()
    assert len(ran) == 4 and tasks.STAMP.exists()
    halves = [Path(x).read_text("utf-8").splitlines() for *_, x in ran[2:]]
    lock = (ROOT / "requirements.txt").read_text("utf-8").splitlines()
    assert sorted(halves[0] + halves[1]) == sorted(lock) and all(halves)


@pytest.mark.parametrize(
    "command, system, words",
    [
        (
            r'"C:\Program Files\LLVM\bin\clang.exe" -O2',
            "nt",
            [r"C:\Program Files\LLVM\bin\clang.exe", "-O2"],
        ),
        (r"C:\mingw64\bin\gcc.exe", "nt", [r"C:\mingw64\bin\gcc.exe"]),
        ("'/opt/my tools/cc' -m64", "posix", ["/opt/my tools/cc", "-m64"]),
        ("", "nt", []),
        ("", "posix", []),
    ],
)
def test_a_compiler_may_have_options_and_a_path_with_spaces(command, system, words):
    assert compiler.split(command, system) == words


# Continuous integration

JOBS = {
    f"{path.stem}-{name}": job
    for path in WORKFLOWS
    for name, job in yaml.safe_load(path.read_text("utf-8"))["jobs"].items()
}


def versions(job):
    """Values of the matrix by which a job is repeated."""
    return job.get("strategy", {}).get("matrix", {})


@pytest.mark.parametrize("job", JOBS.values(), ids=JOBS)
def test_each_job_calls_commands_that_exist(job, called, monkeypatch):
    assert 0 < job["timeout-minutes"] <= 180
    ran = []
    for step in job["steps"]:
        if "uses" in step:
            assert re.fullmatch(r"actions/(checkout|setup-python)@v\d+", step["uses"])
            continue
        program, script, name, *words = step["run"].split()
        assert (program, script) == ("python", "tasks.py") and name in tasks.TASKS
        ran.append((name, words))
    assert len(ran) == 1
    for text in re.findall(r"matrix\.(\w+)", str(job)):
        assert versions(job)[text]


def test_ci_runs_the_test_command_of_the_readme():
    text = (ROOT / ".ci" / "run").read_text("utf-8")
    assert text.splitlines()[-1] == "exec python3 tasks.py test"
    readme = (ROOT / "README.md").read_text("utf-8")
    assert "python3 tasks.py test " in readme and "python3 tasks.py book" in readme


def test_the_lock_ends_in_the_project_and_names_no_index():
    lines = (ROOT / "requirements.txt").read_text("utf-8").splitlines()
    assert lines[-1] == "-e ."
    assert all(re.match(r"[a-z0-9.-]+==\S+( ; .+)?$", line) for line in lines[:-1])
    pins = {line.split("==")[0] for line in lines[:-1]}
    wanted = (ROOT / "requirements.in").read_text("utf-8").splitlines()
    asked = {re.split("[=<>]", line)[0] for line in wanted if line[:1] not in ("#", "")}
    assert asked <= pins


PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]


def wanted(extras=("control", "plot", "cones", "parallel", "notebook", "book", "test")):
    """What the package and its extras ask for; the robot's compiler is no part."""
    listed = PROJECT["optional-dependencies"]
    asked = [*PROJECT["dependencies"], *(line for e in extras for line in listed[e])]
    needs = [Requirement(text) for text in asked]
    return [need for need in needs if need.name != "sosbook"]


def test_the_lock_has_what_the_package_and_its_extras_need():
    lines = (ROOT / "requirements.txt").read_text("utf-8").splitlines()[:-1]
    pins = {}
    for line in lines:
        pin = Requirement(line)
        pins.setdefault(pin.name, []).append(str(pin.specifier).strip("="))
    for need in wanted():
        assert need.name in pins, need
        assert all(need.specifier.contains(v) for v in pins[need.name]), need


def test_the_lock_has_what_its_packages_need():
    """Pip isn't asked to look for it."""
    lines = (ROOT / "requirements.txt").read_text("utf-8").splitlines()[:-1]
    pins = [pin for pin in map(Requirement, lines) if here(pin)]
    names = {canonicalize_name(pin.name) for pin in pins}
    for pin in pins:
        try:
            needs = map(Requirement, metadata.requires(pin.name) or ())
        except metadata.PackageNotFoundError:
            continue  # another version of the lock made this environment
        missing = {canonicalize_name(need.name) for need in needs if here(need)} - names
        assert not missing, pin


def here(need):
    """Does this system want it, without extras?"""
    return need.marker is None or need.marker.evaluate({"extra": ""})


def test_the_version_is_written_once_and_cited():
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text("utf-8"))
    meta = json.loads((ROOT / "codemeta.json").read_text("utf-8"))
    for authors, version, words in (
        (cited["authors"], cited["version"], cited["keywords"]),
        (meta["author"], meta["version"], meta["keywords"]),
    ):
        assert version == sosbook.__version__ and words == cited["keywords"]
        assert [a["name"] for a in authors] == [a["name"] for a in PROJECT["authors"]]
    needs = [Requirement(need).name for need in PROJECT["dependencies"]]
    assert meta["softwareRequirements"] == needs
    log = (ROOT / "CHANGELOG.md").read_text("utf-8")
    first = re.search(r"^## (\S+)", log, re.M)[1]
    assert first == sosbook.__version__ and "version" in PROJECT["dynamic"]
    written = [*(ROOT / "sosbook").rglob("*.py")]
    said = [p.name for p in written if first in p.read_text("utf-8")]
    assert said == ["__init__.py"]


def test_what_contributors_read_names_files_and_commands_that_exist():
    pages = (ROOT / "README.md", ROOT / "CONTRIBUTING.md")
    for path in (*pages, *(ROOT / ".github").rglob("*.md")):
        text = path.read_text("utf-8")
        for target in re.findall(r"\]\(([\w./-]+)\)", text):
            assert (ROOT / target).exists(), target
        for name in re.findall(r"tasks\.py (\w+)", text):
            assert name in tasks.TASKS, name


def test_an_archive_holds_what_is_committed_and_a_digest_of_each(
    called, monkeypatch, tmp_path
):
    """The tree, the pages and the proofs; the same bytes each time."""
    monkeypatch.setattr(tasks, "BUILD", tmp_path)
    monkeypatch.setattr(tasks, "SITE", tmp_path / "html")
    monkeypatch.setattr(tasks, "works", lambda *command: False)
    assert tasks.archive([]) and not called
    monkeypatch.setattr(tasks, "works", lambda *command: True)
    (tmp_path / "html").mkdir()
    (tmp_path / "html" / "index.html").write_text("a page", "utf-8")
    packed = []
    for _ in range(2):
        assert tasks.archive([]) == 0
        packed.append((tmp_path / "sosbook.zip").read_bytes())
    assert packed[0] == packed[1]
    with zipfile.ZipFile(tmp_path / "sosbook.zip") as archive:
        names = archive.namelist()
        sums = archive.read("SHA256SUMS").decode().splitlines()
        digests = dict(line.split("  ", 1)[::-1] for line in sums)
        assert names == [*digests, "SHA256SUMS"] and "pages/index.html" in names
        for name, digest in digests.items():
            assert hashlib.sha256(archive.read(name)).hexdigest() == digest
        assert archive.read("tree/tasks.py") == (ROOT / "tasks.py").read_bytes()
    assert [words[1] for words, _ in called].count("-c") == 4  # builds and proofs
