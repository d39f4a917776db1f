#!/usr/bin/env python3
"""The project's commands. Python 3.11 or newer is all they need.

    python3 tasks.py book     build the book and say where to open it
    python3 tasks.py pdf      print the built book as one PDF; --chapter 7, --textbook
    python3 tasks.py test     run every test (more words go to pytest)
    python3 tasks.py test quick    the package alone, in a few minutes
    python3 tasks.py pythons       the same on each Python from 3.11 on that is here
    python3 tasks.py coverage      which lines of the package its tests reach
    python3 tasks.py campaign      the long tests that `test` leaves out
    python3 tasks.py rehearse      the notebooks on processors that aren't here
    python3 tasks.py hunt          package, checker and page against each other
    python3 tasks.py mutants       changes of the checker that no test notices
    python3 tasks.py formal        the book's proofs by Rocq; see formal/README.md
    python3 tasks.py types         what mypy says of the package's types
    python3 tasks.py lab      open the notebooks in JupyterLab
    python3 tasks.py run      run the notebooks again and store their outputs
    python3 tasks.py bench    time the solver and its peers, for the page on performance
    python3 tasks.py archive  pack tree, pages and proofs, for a repository
    python3 tasks.py clean    remove what these commands made

The first command makes a virtual environment in .venv and fills it from
requirements.txt; later ones find it ready.
"""

import hashlib
import importlib.util
import os
import shutil
import subprocess
import sys
import zipfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parent
VENV = Path(os.environ.get("SOSBOOK_VENV", ROOT / ".venv"))
STAMP = VENV / "ready"
BUILD = ROOT / "_build"
SITE = BUILD / "html"
BYTECODE = BUILD / "bytecode"
QUICK = "not slow and not book and not browser and not live and not compiler"
UNIT = "not book and not browser and not live"
WITHOUT_NBVAL = ("-p", "no:nbval")  # its import takes seconds, in each process

#: The program jupyter-book, whatever the system calls its file. Documents hold
#: millions of objects; to look for garbage among them takes a fifth of a build.
JUPYTER_BOOK = (
    "-c",
    "import gc; gc.set_threshold(100_000); "
    "from jupyter_book.cli.main import main; main()",
)


def interpreter(system=os.name):
    """The environment's Python."""
    return VENV / ("Scripts/python.exe" if system == "nt" else "bin/python")


PYTHON = interpreter()

if __name__ == "__main__":
    sys.dont_write_bytecode = True
sys.path.insert(0, str(ROOT))
from sosbook.runtime.threads import ONE_THREAD  # noqa: E402
from tests import browser, compiler  # noqa: E402


def main():
    name, *words = sys.argv[1:] or [""]
    if name not in TASKS:
        sys.exit(__doc__)
    os.chdir(ROOT)
    sys.exit(TASKS[name](words))


def book(words):
    """Build the book; every warning is an error."""
    prepare()
    if status := build(words):
        return status
    print(f"\nThe book is ready. Open\n  {(SITE / 'index.html').as_uri()}")
    return 0


def pdf(words):
    """Print the book; the pages are built first if there are none."""
    prepare()
    chromium = browser.ensure(str(PYTHON))
    if chromium is None:
        return fail(browser.MISSING)
    if not (SITE / "index.html").exists() and (status := build([])):
        return status
    program = (PYTHON, "-m", "sosbook.book.printing")
    return call(*program, SITE, SITE / "sosbook.pdf", chromium, *words)


def test(words):
    """Run every test and every notebook while the book is built; or `quick`."""
    if words[:1] == ["quick"]:
        prepare()
        return pytest(*WITHOUT_NBVAL, "-m", QUICK, "tests", "sosbook", *words[1:])
    prepare()
    log, outcome = BUILD / "book.log", BUILD / "book.status"
    BUILD.mkdir(exist_ok=True)
    for old in (outcome, *BUILD.glob("gw*.*")):
        old.unlink(missing_ok=True)
    with ThreadPoolExecutor(1) as beside:
        built = beside.submit(build_aside, log, outcome)
        chromium = browser.ensure(str(PYTHON))
        cc = compiler.ensure(str(PYTHON))
        needs = ((browser.MISSING, chromium), (compiler.MISSING, cc))
        missing = "\n".join(text for text, found in needs if found is None)
        if missing and os.environ.get("CI"):
            return fail(missing)
        notebooks = sorted(
            str(path)
            for path in Path("book").glob("*.ipynb")
            if cc or path.name not in compiler.CHAPTERS
        )
        status = pytest(
            "--nbval",
            "tests",
            "sosbook",
            *notebooks,
            *words,
            SOSBOOK_SITE=str(SITE),
            SOSBOOK_BUILT=str(outcome),
        )
    if built.result():
        print(log.read_text("utf-8", errors="replace"), file=sys.stderr)
        status = fail("The book does not build; see above.", status or 1)
    if missing:
        print(f"\nTESTS WERE SKIPPED.\n{missing}", file=sys.stderr)
    return status


def pythons(words):
    """Run the quick lane on each Python that is found, in environments of their own."""
    found = interpreters()
    print("Python", ", ".join(f"3.{minor}" for minor in found))
    bad = []
    for minor, program in found.items():
        own = str(BUILD / "pythons" / f"3.{minor}")
        quick = (program, ROOT / "tasks.py", "test", "quick", *words)
        if call(*quick, SOSBOOK_VENV=own):
            bad.append(f"3.{minor}")
    return fail(f"The quick lane fails on Python {', '.join(bad)}.") if bad else 0


def interpreters():
    """The Pythons of this machine from 3.11 on, by their minor version."""
    said = "import sys; print(*sys.version_info[:2])"
    programs = [sys.executable, *map(shutil.which, ("python3", "python"))]
    programs += [shutil.which(f"python3.{minor}") for minor in range(11, 30)]
    programs += sorted(Path.home().glob(".pyenv/versions/3.*/bin/python"))
    found = {}
    for program in filter(None, programs):
        try:
            run = subprocess.run([program, "-c", said], capture_output=True, check=True)
        except (OSError, subprocess.CalledProcessError):
            continue
        major, minor = map(int, run.stdout.split())
        if (major, minor) >= (3, 11):
            found.setdefault(minor, str(program))
    return dict(sorted(found.items()))


def coverage(words):
    """Measure the package's tests, without pages and notebooks."""
    prepare()
    return pytest(
        *WITHOUT_NBVAL,
        "-m",
        UNIT,
        "--cov",
        "--cov-report=term:skip-covered",
        f"--cov-report=html:{BUILD / 'coverage'}",
        "tests",
        "sosbook",
        *words,
    )


def campaign(words):
    """Run the tests that the gate leaves out, once a week."""
    prepare()
    for tool in (browser, compiler):
        if tool.ensure(str(PYTHON)) is None:
            return fail(tool.MISSING)
    return pytest("--campaign", "-m", "campaign", "tests", *words)


def runs(*module):
    """A task that runs a module, with more words for it."""

    def task(words):
        prepare()
        return call(PYTHON, "-m", *module, *words)

    return task


def lab(words):
    """Open JupyterLab; trusted notebooks show their sliders at once."""
    prepare()
    notebooks = sorted(str(path) for path in Path("book").glob("*.ipynb"))
    call(PYTHON, "-m", "jupyter", "trust", *notebooks)
    first = ["book/intro.ipynb"] if Path("book/intro.ipynb").exists() else []
    root = ["--allow-root"] if browser.is_root() else []
    return call(PYTHON, "-m", "jupyter", "lab", *root, *first, *words)


def bench(words):
    """Measure (everything, or what is named) and run the chapter about it."""
    prepare()
    needs = ("--quiet", "--no-compile", "-r", "benchmarks/requirements.txt")
    if status := call(PYTHON, "-m", "pip", "install", *needs):
        return fail("The solvers to compare with could not be installed.", status)
    programs = ["benchmarks"] if words else ["benchmarks", "benchmarks.waiting"]
    for program in programs:
        if status := call(PYTHON, "-m", program, *words):
            return status
    return TASKS["run"](["book/performance.ipynb"])


#: Makes every row and best known value, and keeps each proof in a folder.
PROOFS = """
import sys
from formal import collect
collect.start(sys.argv[1])
from sosbook.book import reproduction
from sosbook.book import ledger
reproduction.rows(), ledger.entries()
"""


def archive(words):
    """Pack the committed tree, its built pages and the proofs of its rows."""
    prepare()
    if not works("git", "diff", "--quiet", "HEAD"):
        return fail("Commit first: the archive holds the tree as it is committed.")
    proofs = BUILD / "proofs"
    shutil.rmtree(proofs, ignore_errors=True)
    if status := build([]) or call(PYTHON, "-c", PROOFS, proofs):
        return status
    listed = subprocess.run(["git", "ls-files", "-z"], capture_output=True, check=True)
    files = {f"tree/{x}": ROOT / x for x in listed.stdout.decode().split("\0") if x}
    for name, folder in (("pages", SITE), ("proofs", proofs)):
        for path in folder.rglob("*"):
            if path.is_file():
                files[f"{name}/{path.relative_to(folder).as_posix()}"] = path
    print(f"\nThe archive is {pack(files, BUILD / 'sosbook.zip')}")
    return 0


def pack(files, target):
    """A zip of files by their names, and the digest of each in SHA256SUMS.

    The same files make the same bytes. ``sha256sum -c SHA256SUMS`` checks them.
    """
    contents = {name: path.read_bytes() for name, path in sorted(files.items())}
    digests = (f"{hashlib.sha256(x).hexdigest()}  {n}\n" for n, x in contents.items())
    contents["SHA256SUMS"] = "".join(digests).encode()
    with zipfile.ZipFile(target, "w") as packed:
        for name, content in contents.items():
            packed.writestr(zipfile.ZipInfo(name), content, zipfile.ZIP_DEFLATED)
    return target


def clean(words):
    """Remove the environment, the built book and the caches."""
    for name in (".venv", "_build", ".pytest_cache", ".hypothesis"):
        shutil.rmtree(ROOT / name, ignore_errors=True)
    for pattern in ("*.egg-info", "**/__pycache__"):
        for path in ROOT.glob(pattern):
            shutil.rmtree(path, ignore_errors=True)
    return 0


def pytest(*words, **extra):
    """A process for each of two to four cores, a file to a process, in the given
    order; each has a Chromium of its own, which more would leave no memory for. What
    each test took is stored by tests/durations.py.
    """
    count = str(min(max(os.cpu_count() or 2, 2), 4))
    spread = ("-n", count, "--dist", "loadscope", "--no-loadscope-reorder")
    return call(
        PYTHON, "-m", "pytest", *spread, "-p", "tests.durations", *words, **extra
    )


def build(words, log=None):
    """All pages are read again, so that no warning hides in a cache."""
    options = ("--all", "-W", "-n", "--keep-going")
    return call(PYTHON, *JUPYTER_BOOK, "build", ".", *options, *words, log=log)


def build_aside(log, outcome):
    """Build the book into a log; `outcome` appears at the end with the status."""
    with log.open("wb") as file:
        status = build([], log=file)
    part = outcome.with_suffix(".part")
    part.write_text(str(status), "utf-8")
    part.replace(outcome)
    return status


def prepare():
    """Make .venv and install requirements.txt, unless that is done already."""
    wanted = hashlib.sha256()
    for name in ("requirements.txt", "pyproject.toml"):
        wanted.update((ROOT / name).read_bytes())
    if STAMP.exists() and STAMP.read_text("utf-8") == wanted.hexdigest():
        return
    if not works(PYTHON, "-c", "import pip"):
        make_environment()
    print("Installing requirements.txt into .venv; this takes a few minutes.")
    with ThreadPoolExecutor(2) as both:
        if any([*both.map(install, (0, 1))]):
            sys.exit("pip could not install requirements.txt; see its message above.")
    STAMP.write_text(wanted.hexdigest(), "utf-8")


def install(first):
    """Bring every second line of the lock; it is complete: no pip looks for more."""
    half = VENV / f"half-{first}.txt"
    lines = (ROOT / "requirements.txt").read_text("utf-8").splitlines()
    half.write_text("\n".join(lines[first::2]), "utf-8")
    needs = ("--disable-pip-version-check", "--quiet", "--no-compile", "--no-deps")
    return call(PYTHON, "-m", "pip", "install", *needs, "-r", half)


def make_environment():
    if sys.version_info < (3, 11):  # noqa: UP036 -- it says so
        sys.exit(f"Python 3.11 or newer is needed; this is {sys.version.split()[0]}.")
    if importlib.util.find_spec("ensurepip") is None:
        if browser.is_root() and shutil.which("apt-get"):
            browser.apt_install("python3-venv")
        if not works(sys.executable, "-c", "import ensurepip"):
            sys.exit(
                "This Python cannot make virtual environments. On Debian or "
                "Ubuntu:\n  sudo apt-get install python3-venv"
            )
    print("Making the virtual environment .venv")
    if call(sys.executable, "-m", "venv", "--clear", VENV):
        sys.exit("The virtual environment could not be made; see the message above.")


def call(*command, log=None, **extra):
    """Run a command with one thread to a process; return its exit status.

    What Python compiles is kept in _build, whoever forbids it: dozens of
    processes import the same libraries, and compiling them takes half of that.
    """
    environment = dict(os.environ, **extra)
    environment["PATH"] = os.pathsep.join(
        [str(PYTHON.parent), os.environ.get("PATH", "")]
    )
    environment["PYTHONUTF8"] = "1"
    environment["PYTHONPYCACHEPREFIX"] = str(BYTECODE)
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    environment.update(ONE_THREAD)
    sys.stdout.flush()
    return subprocess.run(
        [str(word) for word in command],
        env=environment,
        check=False,
        stdout=log,
        stderr=log and subprocess.STDOUT,
    ).returncode


def works(*command):
    words = [str(word) for word in command]
    try:
        return subprocess.run(words, capture_output=True, check=False).returncode == 0
    except OSError:
        return False


def fail(message, status=1):
    print(message, file=sys.stderr)
    return status


TASKS = {
    task.__name__: task
    for task in (
        book,
        pdf,
        test,
        pythons,
        coverage,
        campaign,
        lab,
        bench,
        archive,
        clean,
    )
} | {
    "rehearse": runs("tests.rehearsal"),
    "hunt": runs("tests.hunt"),
    "mutants": runs("tests.mutants"),
    "formal": runs("formal"),
    "types": runs("mypy", "--cache-dir", BUILD / "mypy"),
    "run": runs("sosbook.book.notebooks", "run"),
}

if __name__ == "__main__":
    main()
