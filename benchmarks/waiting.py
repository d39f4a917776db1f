"""What a reader waits for: python -m benchmarks.waiting [sliders] [pages] [map].

Slider moves in Jupyter and in the page, refusals, exact proofs, maps and many
designs, in seconds that pass, one call after the other; into waiting.json.
"""

import argparse
import json
from pathlib import Path

from . import maps, pages, sliders
from .records import FIELDS, store
from .run import machine

RESULTS = Path(__file__).with_name("waiting.json")
PARTS = {
    "sliders": ("slider", "answers"),
    "pages": ("page",),
    "map": ("map", "designs"),
}


def measure(parts=(), quick=False, old=None):
    """The document of the parts, all of them if none is named.

    Of ``old``, a document, the records of the other parts are kept, and the machine;
    a page's records say their own.
    """
    parts, records = list(parts) or list(PARTS), []
    if "sliders" in parts:
        for k in (1, 2, 3):
            records += sliders.moves(k, 12 if quick else 60)
            records += sliders.answers(k, 3 if quick else 15)
    if "pages" in parts:
        records += pages.moves()
    if "map" in parts:
        records += maps.records(quick)
    again = {family for part in parts for family in PARTS[part]}
    kept = [] if old is None else old["records"]
    records += [r for r in kept if r["family"] not in again]
    return dict(
        about="Seconds that a reader waits. One thread; medians.",
        quick=quick,
        machine=old["machine"] if kept else machine(),
        fields=FIELDS,
        records=records,
    )


def main(words=None):
    parser = argparse.ArgumentParser("python -m benchmarks.waiting")
    parser.add_argument("parts", nargs="*", help=" or ".join(PARTS))
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--output", type=Path, default=RESULTS)
    asked = parser.parse_args(words)
    if wrong := set(asked.parts) - set(PARTS):
        parser.error(f"no such part: {', '.join(sorted(wrong))}")
    old = None
    if asked.parts and asked.output.exists():
        old = json.loads(asked.output.read_text("utf-8"))
    store(asked.output, measure(asked.parts, asked.quick, old))


if __name__ == "__main__":
    main()
