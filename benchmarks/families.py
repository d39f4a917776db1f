"""Time one family of plants: python -m benchmarks.families --family "free chain".

Without ``--family`` the families are listed, and which half is held back.
``--sizes 2,4,8`` chooses sizes, any that the family can make. sosbook alone is
timed unless ``--peers`` names others: ``--peers clarabel sdpa``, or ``all``.
"""

import argparse
import sys

from .catalogue import FAMILIES
from .clock import SECONDS, Job, trial
from .competitors import COMPETITORS


def main(words=None):
    """Time one family, or list them."""
    parser = argparse.ArgumentParser(
        "python -m benchmarks.families",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--family", help="one of those that are listed without it")
    parser.add_argument("--sizes", help="such as 2,4,8; else those of the profile")
    parser.add_argument(
        "--peers", nargs="+", default=["sosbook"], choices=["all", *COMPETITORS]
    )
    parser.add_argument(
        "--seconds", type=float, default=SECONDS, help="CPU time of a call"
    )
    asked = parser.parse_args(words)
    if asked.family is None:
        for name, f in FAMILIES.items():
            sizes = ", ".join(map(str, f.sizes))
            print(f"{name:18} {f.half:10} {f.asks:12} {f.size}: {sizes}; {f.why}")
        return
    if asked.family not in FAMILIES:
        sys.exit(f"no such family: {asked.family}. There are: {', '.join(FAMILIES)}")
    peers = COMPETITORS if "all" in asked.peers else asked.peers
    family = FAMILIES[asked.family]
    sizes = family.sizes
    if asked.sizes is not None:
        sizes = [int(size) for size in asked.sizes.split(",")]
    print(f"{asked.family} ({family.half}), {family.asks}; size: {family.size}")
    for size in sizes:
        for peer in peers:
            found = trial(Job(asked.family, size, peer, asked.seconds))
            print(f"{size:4} {peer:22} {line(found)}", flush=True)


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
    if found.get("coordinates"):
        words.append(found["coordinates"])
    return "; ".join([*words, *([found["why"]] if found.get("why") else [])])


if __name__ == "__main__":
    main()
