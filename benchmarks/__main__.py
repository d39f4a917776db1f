"""Measure sosbook against its peers; write benchmarks/profile.json.

python -m benchmarks            everything
python -m benchmarks --quick    a minute: small sizes of three families
python -m benchmarks --competitors sosbook     these anew, the rest is kept
python -m benchmarks --families tree+grid --sections profile     the same
python -m benchmarks --list     the families, and which half is held back
python -m benchmarks --families tree --sizes 2 4     printed, nothing is stored;
    sosbook alone is asked unless --competitors names others
"""

import argparse
import json
from pathlib import Path

from . import run
from .catalogue import FAMILIES
from .clock import SECONDS, Job, trial
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
    parser.add_argument("--list", action="store_true")
    parser.add_argument("--sizes", nargs="+", type=int, default=[])
    parser.add_argument("--seconds", type=float, default=SECONDS, help="CPU, of a call")
    parser.add_argument("--output", type=Path, default=RESULTS)
    asked = parser.parse_args(words)
    chosen = {option: getattr(asked, option) for option in known}
    if asked.list:
        for name, f in FAMILIES.items():
            sizes = ", ".join(map(str, f.sizes))
            print(f"{name:18} {f.half:10} {f.asks:12} {f.size}: {sizes}; {f.why}")
        return
    if asked.sizes:
        for name in asked.families or FAMILIES:
            for size in asked.sizes:
                for peer in asked.competitors or ["sosbook"]:
                    found = trial(Job(name, size, peer, asked.seconds))
                    print(f"{name:18} {size:4} {peer:22} {line(found)}", flush=True)
        return

    def save(document):
        store(asked.output, document)

    old = None
    if any(chosen.values()) and asked.output.exists():
        old = json.loads(asked.output.read_text("utf-8"))
    save(run.measure(**chosen, old=old, quick=asked.quick, save=save))


def line(found):
    """What a trial found, in a line."""
    words = [found["status"]]
    if found.get("cpu_s") is not None:
        words.append(f"{found['cpu_s']:.4g} CPU s ({found['calls']} calls)")
    for key in ("margin", "excess"):
        if found.get(key) is not None:
            words.append(f"{key} {found[key]:.1e}")
    if found.get("peak_mb"):
        words.append(f"peak {found['peak_mb']:.0f} MB, before {found['base_mb']:.0f}")
    return "; ".join([*words, *filter(None, map(found.get, ("coordinates", "why")))])


if __name__ == "__main__":
    main()
