"""Run the notebooks, and the unit tests if asked, in other numerical worlds.

    python3 tasks.py rehearse                      every notebook in every world
    python3 tasks.py rehearse 03 21                chapters 3 and 21
    python3 tasks.py rehearse --worlds noise-1 Haswell -- 03
    python3 tasks.py rehearse --unit               the unit tests as well
    python3 tasks.py rehearse --only-unit tests/test_regions.py
    python3 tasks.py rehearse --list               the worlds of this machine

A world is a name or a kind: noise, kernels or simd. The stored outputs are
compared as in the tests. What fails in any world depends on the processor:
print it with fewer digits or say it in another way. Logs and results are left
in _build/rehearsal.
"""

import argparse
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from collections import defaultdict
from pathlib import Path

from tests.rehearsal import worlds

ROOT = Path(__file__).resolve().parents[2]
BUILD = ROOT / "_build" / "rehearsal"
PYTEST = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider"]


def main(words=None):
    asked = arguments(words)
    try:
        chosen = worlds.choose(asked.worlds, asked.seeds)
        runs = {world.kind: lanes(asked, world.kind) for world in chosen}
    except KeyError as error:
        sys.exit(error.args[0])
    if asked.list:
        print(*(f"{world.name:12}  {world.variables}" for world in chosen), sep="\n")
        return 0
    results, broken = {world.name: {} for world in chosen}, []
    for world in chosen:
        for name, words in runs[world.kind].items():
            status, outcome = run(world, name, words, asked.n)
            results[world.name] |= outcome
            broken += [world.name] * (status not in (0, 1))
    print(failures(results))
    for name in broken:
        print(f"pytest itself failed in {name}; see {BUILD / name}-*.log")
    return int(bool(broken or any(map(failed, results.values()))))


def arguments(words):
    parser = argparse.ArgumentParser(
        prog="tasks.py rehearse",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add = parser.add_argument
    add("names", nargs="*", help="notebooks, by the start of their names")
    add("--worlds", nargs="+", default=[], help="names or kinds of worlds")
    add("--seeds", nargs="+", type=int, default=[1, 2, 3])
    add("--unit", action="store_true", help="run the unit tests as well")
    add("--only-unit", action="store_true", help="names are files of tests")
    add("--list", action="store_true", help="print the worlds and stop")
    add("-n", default="2", help="processes; 2 unless told")
    return parser.parse_args(words)


def lanes(asked, kind):
    """{name: pytest's words} of the runs in a world of this kind."""
    less = " and not last_digits" if kind == "noise" else ""
    units = ["-m", f"not book and not browser and not live{less}"]
    if asked.only_unit:
        return {"unit": [*units, *(asked.names or ["tests", "sosbook"])]}
    runs = {"notebooks": ["--nbval", *notebooks(asked.names)]}
    return runs | ({"unit": [*units, "tests", "sosbook"]} if asked.unit else {})


def notebooks(names):
    """Paths of the notebooks whose names start so; all if there are no names."""
    every = sorted((ROOT / "book").glob("*.ipynb"))
    starts = [Path(name).stem for name in names]
    for start in starts:
        if not any(path.stem.startswith(start) for path in every):
            raise KeyError(f"no notebook's name starts with {start}")
    chosen = [p for p in every if not starts or p.stem.startswith(tuple(starts))]
    return [str(path.relative_to(ROOT)) for path in chosen]


def run(world, name, words, processes):
    """pytest's status, and {file: {test: passed?}} of what it ran."""
    BUILD.mkdir(parents=True, exist_ok=True)
    log, report = (BUILD / f"{world.name}-{name}.{end}" for end in ("log", "xml"))
    report.unlink(missing_ok=True)
    spread = ["-n", processes, "--dist", "loadscope"] if processes != "0" else []
    print(f"{world.name}: {name} ...", flush=True)
    with log.open("w", encoding="utf-8") as file:
        status = subprocess.run(
            [*PYTEST, *spread, f"--junitxml={report}", *words],
            cwd=ROOT,
            stdout=file,
            stderr=subprocess.STDOUT,
            env=world.environment(),
            check=False,
        ).returncode
    outcome = read(report) if report.exists() else {}
    print(
        f"{world.name}: {sum(map(len, outcome.values()))} ran, "
        f"{len(failed(outcome))} failed",
        flush=True,
    )
    return status, outcome


def read(report):
    """{file: {test: passed?}} of a JUnit report."""
    outcome = defaultdict(dict)
    for case in ElementTree.parse(report).iter("testcase"):
        if case.find("skipped") is None:
            bad = case.find("failure") is not None or case.find("error") is not None
            outcome[case.get("classname")][case.get("name")] = not bad
    return dict(outcome)


def failed(outcome):
    """(file, test) of what failed."""
    return [
        (file, test)
        for file, tests in outcome.items()
        for test, passed in tests.items()
        if not passed
    ]


def short(file):
    return file.removeprefix("book.").removesuffix(".ipynb")


def failures(results):
    """What failed in any world, and in which."""
    where = defaultdict(list)
    for name, outcome in results.items():
        for place in failed(outcome):
            where[place].append(name)
    lines = [
        f"  {short(file)}  {test}:  {', '.join(names)}"
        for (file, test), names in sorted(where.items())
    ]
    return "\n".join(
        ["", "Depends on the processor:", *lines]
        if lines
        else ["", "Nothing depends on the processor."]
    )


if __name__ == "__main__":
    sys.exit(main())
