"""Measure sosbook against its peers; write benchmarks/results.json.

python -m benchmarks            everything, half an hour or more
python -m benchmarks --quick    the small cases
python -m benchmarks "chain 8" map    these only, the others are kept
python -m benchmarks --table    print the file as tables, measure nothing
"""

import os

from sosbook.runtime.progress import WITHOUT_BARS
from sosbook.runtime.threads import ONE_THREAD

os.environ.update(ONE_THREAD | WITHOUT_BARS)  # before numpy is imported

import argparse
import json
import sys
from pathlib import Path

from . import report, run
from .cases import CASES

RESULTS = Path(__file__).with_name("results.json")


def main(words=None):
    names = [*CASES, *run.SPECIAL]
    parser = argparse.ArgumentParser(
        "python -m benchmarks",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "cases", nargs="*", metavar="case", help="one of: " + ", ".join(names)
    )
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--table", action="store_true")
    parser.add_argument("--output", type=Path, default=RESULTS)
    asked = parser.parse_args(words)
    if asked.table:
        if not asked.output.exists():
            sys.exit(f"{asked.output.name} isn't there: measure first")
        print(report.table(json.loads(asked.output.read_text("utf8"))))
        return
    if wrong := set(asked.cases) - set(names):
        sys.exit(
            f"no such case: {', '.join(sorted(wrong))}. There are: " + ", ".join(names)
        )
    old = None
    if asked.cases and asked.output.exists():
        old = json.loads(asked.output.read_text("utf8"))
    found = run.measure(asked.cases, asked.quick, old)
    text = json.dumps(found, indent=1, ensure_ascii=False, allow_nan=False)
    asked.output.write_text(text + "\n", "utf8")
    print(report.table(found))


if __name__ == "__main__":
    main()
