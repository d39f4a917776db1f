"""What a reader waits for: python -m benchmarks.waiting [starts] [sliders] [pages] ...

The first answer of a process in CPU seconds; slider moves in Jupyter and in the page,
refusals, exact proofs, maps and many designs, in seconds that pass, one call after the
other; into waiting.json.
"""

import argparse
import json
import os
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from . import maps, pages, sliders, verdicts
from .clock import cpu
from .records import FIELDS, record, store, summary
from .run import machine

RESULTS = Path(__file__).with_name("waiting.json")
PARTS = {
    "starts": ("start",),
    "sliders": ("slider",),
    "answers": ("answers",),
    "pages": ("page",),
    "map": ("map", "designs"),
}


def measure(parts=(), quick=False, old=None):
    """The document of the parts, all of them if none is named.

    Of ``old``, a document, the records of the other parts are kept, and the machine;
    a page's records say their own.
    """
    parts, records = list(parts) or list(PARTS), []
    if "starts" in parts:
        records += starts(5 if quick else 25)
    if "sliders" in parts:
        for k in (1, 2, 3):
            records += sliders.moves(k, 12 if quick else 60)
    if "answers" in parts:
        records += verdicts.answers(3 if quick else 15)
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


VERIFY = "from sosbook.__main__ import main; assert main(['verify', 'p.json']) == 0"
STARTS = {  # each is a process
    "numpy, scipy.linalg and flint": "import numpy, scipy.linalg, flint",
    "a first design": """
import sys, numpy as np, sosbook as sos
plant = sos.SecondOrderSystem([[2, 0], [0, 1]], np.eye(2), np.eye(2), [[1], [0]])
design = sos.design_pid(plant, region=sos.PoleRegion(sigma=0.1, rho=20))
sys.argv[1:] and design.certify().save(sys.argv[1])""",
    "verify": VERIFY,
}


def starts(rounds):
    """Records of processes that answer once, in turns; all byte code is stored."""
    times = {name: [] for name in STARTS}
    with TemporaryDirectory() as folder:
        env = os.environ | {"PYTHONPYCACHEPREFIX": folder, "PYTHONPATH": os.getcwd()}
        env.pop("PYTHONDONTWRITEBYTECODE", None)
        for k in range(-1, rounds):  # one to warm up
            for name, code in STARTS.items():
                words, begin = [sys.executable, "-c", code], cpu()
                words += ["p.json"] if k < 0 else []
                subprocess.run(words, check=True, cwd=folder, env=env, stdout=-3)
                times[name] += [cpu() - begin] if k >= 0 else []
    known = dict(family="start", competitor="sosbook", status="right")
    known["clock"] = "CPU seconds of a process"
    return [record(case=x, **known, **summary(t)) for x, t in times.items()]


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
