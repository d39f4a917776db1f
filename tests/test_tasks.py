"""The commands: what they call, on this system and on others, and in CI."""

import os
import re
import subprocess
import sys
import threading
import tomllib
from importlib import metadata
from pathlib import Path

import pytest
import yaml
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from packaging.version import Version

import tasks
from tests import browser, compiler, conftest

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
    monkeypatch.setattr(tasks, "prepare", lambda *beside: None)
    return calls


def test_the_help_names_every_command_and_only_these():
    named = re.findall(r"python3 tasks\.py (\w+)", tasks.__doc__)
    assert set(named) == set(tasks.TASKS)
    done = subprocess.run(
        [sys.executable, ROOT / "tasks.py", "nonsense"],
        capture_output=True,
        text=True,
        encoding="utf-8",
        check=False,
    )
    assert done.returncode and done.stderr.strip() == tasks.__doc__.strip()


@pytest.mark.parametrize(
    "system, path", [("nt", ("Scripts", "python.exe")), ("posix", ("bin", "python"))]
)
def test_the_interpreter_lies_where_each_system_puts_it(system, path):
    assert tasks.interpreter(system).relative_to(tasks.VENV).parts == path
    assert tasks.PYTHON == tasks.interpreter(os.name)


def test_the_quick_lane_has_no_pages_and_no_notebooks(called):
    assert tasks.test(["quick", "-x"]) == 0
    ((command, extra),) = called
    assert command[-3:] == ["tests", "sosbook", "-x"]
    assert command[command.index("-m", 3) + 1] == tasks.QUICK
    assert "--nbval" not in command and "SOSBOOK_SITE" not in extra


COLLECT_TWICE = """
import pytest, sys
for more in ([], ["--campaign"]):
    if status := pytest.main([*sys.argv[1:], *more]):
        sys.exit(status)
"""


@pytest.mark.slow
def test_the_campaigns_run_when_they_are_called_and_never_else(called, monkeypatch):
    monkeypatch.setattr(tasks.compiler, "ensure", lambda python: ["cc"])
    assert tasks.campaign(["-x"]) == 0
    ((command, _),) = called
    assert command[-5:] == ["--campaign", "-m", "campaign", "tests", "-x"]
    listed = subprocess.run(
        [
            sys.executable,
            "-c",
            COLLECT_TWICE,
            "--collect-only",
            "-qq",
            "-p",
            "no:cacheprovider",
            *tasks.WITHOUT_NBVAL,
            "tests/test_mip_six_robots.py",
        ],
        cwd=ROOT,
        capture_output=True,
        text=True,
        encoding="utf-8",
        check=True,
    ).stdout
    few, all_of_them = map(int, re.findall(r"\.py: (\d+)", listed))
    assert 0 < few < all_of_them


def test_types_are_checked_by_the_mypy_that_is_named(called):
    assert tasks.types(["--verbose"]) == 0
    ((check, _),) = called
    assert re.search(
        r"^mypy==[\d.]+$", (ROOT / "requirements.in").read_text("utf-8"), re.M
    )
    assert check[:3] == [str(tasks.PYTHON), "-m", "mypy"] and check[-1] == "--verbose"
    listed = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
    assert all((ROOT / name).exists() for name in listed["tool"]["mypy"]["files"])


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
    assert bool(called) == (status == 0)
    if not status:
        assert not any(name in " ".join(called[0][0]) for name in compiler.CHAPTERS)


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


def test_a_build_that_never_ends_is_not_awaited_for_ever(tmp_path):
    with pytest.raises(AssertionError, match="not built in time"):
        conftest.wait_for(tmp_path / "book.status", seconds=0)


class Config:
    """What the hook sees of the command line; it has no --campaign."""

    def __init__(self):
        self.hook, self.gone = self, []

    def getoption(self, name, default):
        return default

    def pytest_deselected(self, items):
        self.gone += items


class Item:
    """What the hook sees of a test."""

    def __init__(self, path, *fixtures):
        self.path, self.fixturenames, self.marks = Path(path), fixtures, {}

    def get_closest_marker(self, name):
        return name in self.marks

    def add_marker(self, mark):
        self.marks[mark.mark.name] = mark.mark.args


def test_pages_are_marked_and_long_files_come_first():
    plain, table = Item("tests/test_design.py"), Item("tests/test_tables.py", "rows")
    page = Item("tests/test_maps.py", "visit", "browser")
    beside = Item("tests/test_maps.py")
    doctest = Item("sosbook/synthesis/rounding.py")
    site = Item("tests/test_site.py", "site", "browser")
    cell = Item("book/01_first.ipynb")
    slowest = Item(f"book/{conftest.LONGEST[0]}.ipynb")
    campaign = Item("tests/test_design.py")
    campaign.add_marker(pytest.mark.campaign)
    items, config = [plain, campaign, table, page, cell], Config()
    items += [beside, site, doctest, slowest]
    conftest.pytest_collection_modifyitems(config, items)
    assert config.gone == [campaign]
    assert items == [slowest, cell, plain, table, doctest, site, page, beside]
    assert "browser" in page.marks and "browser" in site.marks
    assert "slow" in table.marks
    assert plain.marks == {} and cell.marks == {"timeout": (conftest.CELL,)}


def test_files_that_start_first_exist():
    there = {
        path.stem for folder in ("tests", "book") for path in (ROOT / folder).iterdir()
    }
    assert set(conftest.LONGEST) <= there


@pytest.mark.slow
def test_a_test_that_hangs_fails(tmp_path):
    path = tmp_path / "test_hanging.py"
    path.write_text("def test_bisection():\n    while True:\n        pass\n", "utf-8")
    done = subprocess.run(
        [
            sys.executable,
            "-m",
            "pytest",
            "-q",
            "-p",
            "no:cacheprovider",
            *tasks.WITHOUT_NBVAL,
            "-o",
            "timeout=1",
            "--rootdir",
            tmp_path,
            path,
        ],
        capture_output=True,
        text=True,
        encoding="utf-8",
        check=False,
        timeout=120,
    )
    assert done.returncode and "Timeout" in done.stdout + done.stderr


def test_every_test_has_a_timeout(pytestconfig):
    assert float(pytestconfig.getini("timeout")) == 300


def test_of_several_processes_one_computes(tmp_path):
    calls = []

    def compute():
        calls.append(1)
        return 7

    path = tmp_path / "seven.pickle"
    assert [conftest.once(path, compute) for _ in range(3)] == [7, 7, 7]
    assert calls == [1]


def test_a_process_that_fails_is_not_awaited(tmp_path):
    path = tmp_path / "none.pickle"
    with pytest.raises(ZeroDivisionError):
        conftest.once(path, lambda: 1 / 0)
    with pytest.raises(AssertionError, match="failed to compute"):
        conftest.once(path, lambda: 7)
    (tmp_path / "late.claim").touch()
    with pytest.raises(AssertionError, match="not made in time"):
        conftest.once(tmp_path / "late.pickle", lambda: 7, seconds=0)


def test_processes_run_one_thread_and_speak_utf_8(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "7")
    program = (
        "import os, sys; sys.exit(not (os.environ['OMP_NUM_THREADS'] == '1'"
        " and sys.flags.utf8_mode and os.environ['WORD'] == 'x'))"
    )
    assert tasks.call(sys.executable, "-c", program, WORD="x") == 0
    assert tasks.call(sys.executable, "-c", "raise SystemExit(3)") == 3


def test_what_is_compiled_once_is_kept_outside_the_sources(monkeypatch, tmp_path):
    monkeypatch.setattr(tasks, "BYTECODE", tmp_path / "bytecode")
    monkeypatch.setenv("PYTHONDONTWRITEBYTECODE", "1")
    (tmp_path / "module.py").write_text("x = 1", "utf-8")
    words, path = (sys.executable, "-c", "import module"), str(tmp_path)
    assert tasks.call(*words, PYTHONPATH=path) == 0
    assert [p.name for p in tmp_path.iterdir() if p.name != "bytecode"] == ["module.py"]
    assert len([*(tmp_path / "bytecode").rglob("module.*.pyc")]) == 1


# Tools on other systems


def test_windows_takes_the_browser_of_playwright_without_asking_it(
    monkeypatch, tmp_path
):
    """There, asking Chromium for its version opens a window."""
    asked = []
    own = tmp_path / "chrome.exe"

    def output(*command):
        asked.append(command)
        return str(own)

    monkeypatch.setattr(browser, "output", output)
    assert browser.find("python", system="nt") is None
    own.touch()
    assert browser.find("python", system="nt") == str(own)
    assert asked == 2 * [("python", "-c", browser.ASK)]


def test_a_headless_shell_comes_before_a_chromium_with_windows(monkeypatch, tmp_path):
    """On the PATH, then of playwright, which knows its own Chromium alone."""
    folder, there, dead = tmp_path / "chromium-12" / "linux", {"chromium"}, set()
    own = str(folder / "chrome")
    shell = tmp_path / "chromium_headless_shell-12" / "x" / "chrome-headless-shell"

    def output(*command):
        return own if command[0] == "python" else command[0] not in dead

    monkeypatch.setattr(browser, "output", output)
    monkeypatch.setattr(browser.shutil, "which", lambda name: name in there and name)
    assert browser.find("python", system="posix") == "chromium"
    there.add("chromium-headless-shell")
    assert browser.find("python", system="posix") == "chromium-headless-shell"
    dead |= there
    assert browser.find("python", system="posix") == own
    shell.parent.mkdir(parents=True)
    shell.touch()
    for system in ("posix", "nt"):
        assert browser.find("python", system=system) == str(shell)


def test_the_browser_comes_while_the_packages_come(monkeypatch, tmp_path):
    """Whoever waits for another in this test waits for ever."""
    all_three, ran = threading.Barrier(3, timeout=60), []
    monkeypatch.setattr(tasks, "VENV", tmp_path)
    monkeypatch.setattr(tasks, "STAMP", tmp_path / "ready")
    monkeypatch.setattr(tasks, "works", lambda *command: True)

    def call(*command):
        ran.append(command)
        return all_three.wait() and 0

    monkeypatch.setattr(tasks, "call", call)
    asked = []
    tasks.prepare(lambda python: asked.append(python) or all_three.wait())
    assert asked == [str(tasks.PYTHON)] and tasks.STAMP.exists()
    assert all("--no-deps" in command for command in ran)
    halves = [command[-1].read_text("utf-8").splitlines() for command in ran]
    lock = (ROOT / "requirements.txt").read_text("utf-8").splitlines()
    assert sorted(halves[0] + halves[1]) == sorted(lock)
    tasks.prepare(asked.append)  # all is there
    assert len(asked) == 1
    monkeypatch.setattr(tasks, "prepare", lambda *beside: asked.extend(beside))
    monkeypatch.setattr(tasks, "pytest", lambda *words, **extra: 0)
    tasks.test(["quick"])
    assert len(asked) == 1
    monkeypatch.setattr(tasks.browser, "ensure", lambda python: None)
    monkeypatch.setattr(tasks.compiler, "ensure", lambda python: None)
    monkeypatch.setenv("CI", "1")
    assert tasks.test([]) == 1 and asked[1:] == [browser.from_debian]


def test_nothing_is_installed_by_apt_where_there_is_none(monkeypatch):
    ran = []
    monkeypatch.setattr(browser.shutil, "which", lambda name: None)
    monkeypatch.setattr(browser, "output", lambda *command: None)
    monkeypatch.setattr(compiler, "output", lambda *command: None)
    monkeypatch.setattr(
        browser.subprocess, "run", lambda words, **more: ran.append(words)
    )
    for is_root in (True, False):
        for module in (browser, compiler):
            monkeypatch.setattr(module, "is_root", lambda: is_root)
        assert browser.ensure("python") is None
        assert compiler.ensure("python") is None
    assert [words[:4] for words in ran] == 2 * [
        ["python", "-m", "playwright", "install"],
        ["python", "-m", "pip", "install"],
    ]


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


def test_the_three_lanes_run_where_they_should():
    names = ("tests-quick", "tests-full", "tests-rehearsal")
    quick, full, rehearsal = (versions(JOBS[name]) for name in names)
    assert [word.split("-")[0] for word in quick["os"]] == [
        "ubuntu",
        "macos",
        "windows",
    ]
    assert quick["python"] == ["3.11", "3.12", "3.13", "3.14"]
    assert full["python"] == ["3.11", "3.14"]
    assert rehearsal["worlds"] == ["noise", "kernels", "simd"]
    for weekly in ("tests-rehearsal", "tests-campaign"):
        assert "== 'schedule'" in JOBS[weekly]["if"]
    assert "cron" in WORKFLOWS[0].read_text("utf-8")


def test_ci_runs_the_test_command_of_the_readme():
    text = (ROOT / ".ci" / "run").read_text("utf-8")
    assert text.splitlines()[-1] == "exec python3 tasks.py test"
    assert "python3 tasks.py test " in (ROOT / "README.md").read_text("utf-8")


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
    assert cited["version"] == PROJECT["version"]
    assert [a["name"] for a in cited["authors"]] == [
        a["name"] for a in PROJECT["authors"]
    ]
    log = (ROOT / "CHANGELOG.md").read_text("utf-8")
    first = re.search(r"^## (\S+)", log, re.M)[1]
    assert first == Version(PROJECT["version"]).base_version
    for path in (ROOT / "sosbook").rglob("*.py"):
        assert PROJECT["version"] not in path.read_text("utf-8"), path


def test_what_contributors_read_names_files_and_commands_that_exist():
    for path in (ROOT / "CONTRIBUTING.md", *(ROOT / ".github").rglob("*.md")):
        text = path.read_text("utf-8")
        for target in re.findall(r"\]\(([\w./-]+)\)", text):
            assert (ROOT / target).exists(), target
        for name in re.findall(r"tasks\.py (\w+)", text):
            assert name in tasks.TASKS, name


def test_the_commands_need_nothing_but_python():
    done = subprocess.run(
        [sys.executable, "-S", "-E", ROOT / "tasks.py", "nonsense"],
        capture_output=True,
        text=True,
        encoding="utf-8",
        check=False,
    )
    assert done.stderr.strip() == tasks.__doc__.strip()
