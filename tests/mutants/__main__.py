"""Change the checker by rule, and say which changes no input of the tests notices.

    python3 tasks.py mutants                   all changes, some forty minutes
    python3 tasks.py mutants --seconds 600     as many as fit, by chance

A change exchanges a comparison, a sign, "and" with "or", a constant or a digit of a
theorem's text, or leaves a `need` out. The tests of the checker run first, and what
they ask is kept. `survivors.txt` lists the changes that nothing notices: it may only
shrink.
Exit code: 0; 1 where a change survives that isn't listed (`--write` adds it).
"""

import argparse
import json
import random
import sys
import time
from collections import Counter
from pathlib import Path

import pytest

from sosbook.exact.checker import CHECKER, MODULES
from tests.mutants.changes import mutants
from tests.mutants.judge import FILES, Inputs, Recorder, recorded

ROOT = Path(__file__).resolve().parents[2]
KEPT = ROOT / "_build" / "mutants.json"
LIST = Path(__file__).with_name("survivors.txt")
SECONDS = 6.0  # for one change


def main(words=None):
    """What survives, and whether that is what is listed."""
    parser = argparse.ArgumentParser(
        prog="tasks.py mutants",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add = parser.add_argument
    add("--seconds", type=float, default=1e9, help="of CPU; as many as it takes")
    add("--seed", type=int, default=int(time.time()) // 86400, help="of the order")
    add("--module", choices=MODULES, help="one module alone")
    add("--tests", nargs="+", default=FILES, metavar="NAME", help="whose inputs")
    add("--again", action="store_true", help="with the inputs of the last run")
    add("--write", action="store_true", help="add what survives to the list")
    asked = parser.parse_args(words)
    kept = json.loads(KEPT.read_text("utf-8")) if asked.again else record(asked.tests)
    inputs = Inputs(kept)
    print(f"{len(inputs.all)} inputs", flush=True)
    modules = [asked.module] if asked.module else MODULES
    every = [
        (name, *change)
        for name in modules
        for change in mutants((CHECKER / f"{name}.py").read_text("utf-8"))
    ]
    random.Random(asked.seed).shuffle(every)
    listed = {*LIST.read_text("utf-8").splitlines()}
    counts, fresh, noticed = Counter(), [], []
    end = time.process_time() + asked.seconds
    for name, owner, words, source in every:
        if time.process_time() > end:
            break
        found, line = inputs.notices(name, owner, source, SECONDS), f"{name} {words}"
        counts["changes"] += 1
        kind = {True: "noticed", None: "not decided in time", False: "survive"}[found]
        counts[kind] += 1
        if found and line in listed:
            noticed.append(line)
        if found is False and line not in listed:
            fresh.append(line)
            print("SURVIVES", line, flush=True)
    print(*(f"{n:6d}  {what}" for what, n in counts.items()), sep="\n")
    if asked.write:
        LIST.write_text("\n".join(sorted(listed | {*fresh})) + "\n", "utf-8")
        return 0
    for line in noticed:
        print("NOTICED NOW, take it from survivors.txt:", line)
    return int(bool(fresh))


def record(names):
    """What the tests of the checker ask of it; kept for a run --again."""
    recorder = Recorder()
    files = [str(ROOT / "tests" / f"{name}.py") for name in names]
    quiet = ["-q", "-p", "no:nbval", "-p", "no:cacheprovider", "-p", "no:xdist"]
    with recorded(recorder):
        code = pytest.main([*quiet, "-m", "not slow", *files], plugins=[recorder])
    if code:
        sys.exit("the tests fail as they are")
    KEPT.parent.mkdir(exist_ok=True)
    KEPT.write_text(json.dumps([*recorder.inputs]), "utf-8")
    return [*recorder.inputs]


if __name__ == "__main__":
    sys.exit(main())
