"""Change the checker by rule, and say which changes no input of the tests notices.

    python3 tasks.py mutants                   all changes, some forty minutes
    python3 tasks.py mutants --seconds 600     as many functions as fit
    python3 tasks.py mutants --write --again   go on where the last run ended
    python3 tasks.py mutants page --help       the same of the page's reader

A change exchanges a comparison, a sign, "and" with "or", a constant or a digit of a
theorem's text, or leaves a `need` out. The tests of the checker run first, and what
they ask is kept. `survivors.txt` lists the changes that nothing notices: it may only
shrink. `asked.txt` names the functions all of whose changes were asked for that list,
each with a digest of its changes; those that it doesn't name come first. A survivor
that was thought about ends with a word, and why: the changed checker answers alike
("equal"), refuses more ("stricter"), says or exits otherwise ("words"), gives up
elsewhere ("limit"), or a test that calls the function notices it ("tested").
Exit code: 0; 1 where a change of a function in `asked.txt` survives and isn't listed;
3 where none does, and some functions were never asked.
"""

import argparse
import json
import random
import sys
import time
from collections import Counter
from hashlib import sha256
from pathlib import Path

import pytest

from sosbook.exact.checker import CHECKER, MODULES
from tests.mutants import page
from tests.mutants.changes import mutants
from tests.mutants.judge import FILES, Inputs, Recorder, recorded
from tests.mutants.lists import keep, listed

ROOT = Path(__file__).resolve().parents[2]
KEPT = ROOT / "_build" / "mutants.json"
LIST, ASKED = (Path(__file__).with_name(f"{x}.txt") for x in ("survivors", "asked"))
SECONDS = 6.0  # for one change
SURVIVES, NOT_ASKED = 1, 3


def main(words=None):
    """What survives, and whether that is what is listed."""
    words = sys.argv[1:] if words is None else words
    if words[:1] == ["page"]:
        return page.main(words[1:])
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
    add("--write", action="store_true", help="keep what was found in both lists")
    asked = parser.parse_args(words)
    kept = json.loads(KEPT.read_text("utf-8")) if asked.again else record(asked.tests)
    inputs = Inputs(kept)
    print(f"{len(inputs.all)} inputs", flush=True)
    every = functions()
    lists = Lists(every)
    order = [mark for mark in every if asked.module in (None, mark.split()[0])]
    random.Random(asked.seed).shuffle(order)
    order.sort(key=lists.asked.__contains__)
    counts, end = Counter(), time.process_time() + asked.seconds
    for mark in order:
        name, owner, _ = mark.split()
        for line, (lines, changed) in every[mark].items():
            if time.process_time() > end:
                break
            found = inputs.notices(name, owner, lines, changed, SECONDS)
            kind = {True: "noticed", None: "not decided in time", False: "survive"}
            counts[kind[found]] += 1
            lists.hear(mark, line, found)
        else:
            lists.done.add(mark)
            if asked.write:
                lists.write()
    print(*(f"{n:6d}  {what}" for what, n in counts.items()), sep="\n")
    for line in lists.noticed:
        print("NOTICED NOW, take it from survivors.txt:", line)
    missing = every.keys() - lists.asked - (lists.done if asked.write else set())
    print(f"{len(missing):6d}  of {len(every)} functions were never asked")
    if lists.unlisted and not asked.write:
        return SURVIVES
    return NOT_ASKED if missing else 0


def functions():
    """The changes of each function by their words, by "module function digest"."""
    found = {}
    for name in MODULES:
        source = (CHECKER / f"{name}.py").read_text("utf-8")
        for owner, words, *changed in mutants(source):
            found.setdefault((name, owner), {})[f"{name} {words}"] = changed
    return {
        f"{name} {owner} {sha256('|'.join(changes).encode()).hexdigest()[:12]}": changes
        for (name, owner), changes in found.items()
    }


class Lists:
    """What the two files hold, and what a run finds beside it."""

    def __init__(self, every):
        self.every = every
        self.why = listed(LIST)
        self.listed = set(self.why)
        self.asked = (
            {*ASKED.read_text("utf-8").splitlines()} if ASKED.is_file() else set()
        )
        self.asked &= every.keys()
        self.done, self.fresh, self.noticed, self.unlisted = set(), set(), [], []

    def hear(self, mark, line, found):
        """What became of a change: noticed, or not, or not in time (None)."""
        if found and line in self.listed:
            self.noticed.append(line)
        if found is False and line not in self.listed:
            self.fresh.add(line)
            if mark in self.asked:
                self.unlisted.append(line)
            before = "SURVIVES" if mark in self.asked else "SURVIVES, NOT ASKED BEFORE"
            print(f"{before}: {line}", flush=True)

    def write(self):
        """Keep both lists; what is noticed or isn't a change any more leaves them."""
        changes = {line for several in self.every.values() for line in several}
        survive = ((self.listed & changes) - {*self.noticed}) | self.fresh
        keep(LIST, {line: self.why.get(line, "") for line in survive})
        ASKED.write_text("\n".join(sorted(self.asked | self.done)) + "\n", "utf-8")


def record(names):
    """What the tests of the checker ask of it; kept for a run --again."""
    recorder = Recorder()
    files = [str(ROOT / "tests" / f"{name}.py") for name in names]
    quiet = ["-q", "-p", "no:nbval", "-p", "no:cacheprovider", "-p", "no:xdist"]
    with recorded(recorder):
        every = ["--campaign", "-m", "not browser and not live"]
        code = pytest.main([*quiet, *every, *files], plugins=[recorder])
    if code:
        sys.exit("the tests fail as they are")
    KEPT.parent.mkdir(exist_ok=True)
    KEPT.write_text(json.dumps([*recorder.inputs]), "utf-8")
    return [*recorder.inputs]


if __name__ == "__main__":
    sys.exit(main())
