"""Measure sosbook against its peers; write benchmarks/profile.json.

python -m benchmarks            everything
python -m benchmarks --quick    a minute: small sizes of three families
python -m benchmarks --competitors sosbook     these anew, the rest is kept
python -m benchmarks --families tree+grid --sections profile     the same
"""

import argparse
import json
from pathlib import Path

from . import run
from .catalogue import FAMILIES
from .competitors import COMPETITORS
from .records import store

RESULTS = Path(__file__).with_name("profile.json")


def main(words=None):
    parser = argparse.ArgumentParser(
        "python -m benchmarks",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    known = dict(
        families=FAMILIES, competitors=COMPETITORS, sections=["profile", *run.SECTIONS]
    )
    for option, names in known.items():
        parser.add_argument(
            f"--{option}", nargs="+", default=[], choices=[*names], metavar="NAME"
        )
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--output", type=Path, default=RESULTS)
    asked = parser.parse_args(words)
    chosen = {option: getattr(asked, option) for option in known}

    def save(document):
        store(asked.output, document)

    old = None
    if any(chosen.values()) and asked.output.exists():
        old = json.loads(asked.output.read_text("utf-8"))
    save(run.measure(**chosen, old=old, quick=asked.quick, save=save))


if __name__ == "__main__":
    main()
