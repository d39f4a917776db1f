"""Robots by chance, from their logs to ratios: python -m benchmarks.robots [seed ...].

The tests' own simulator records both logs of each, as the recorders do, with play,
dead zone, sag, a gyro that is a little off and samples that a bus lost. What is fitted
is held against the robot's own numbers: which logs are refused and why, how far off
the ratios are, and how often they lie in the 95 % intervals. CPU seconds, into
robots.json; with seeds only these robots are run, and nothing is stored.
"""

import json
import sys
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from time import process_time

from sosbook.pendulum.gate import Inspection, refused, widened
from tests.geared_robots import described, drawn, recorded

from .records import store

RESULTS = Path(__file__).with_name("robots.json")
SEEDS = range(16)
SECONDS = 10.0  # of a sweep, either way: a third of what the recorders take


def fitted(seed):
    """The record of one robot: its findings, and per ratio how far off, and known."""
    machine = drawn(seed)
    logs, started = recorded(machine, SECONDS), process_time()
    seen = Inspection.of(*logs.values(), described(machine))
    record = dict(seed=seed, seconds=round(process_time() - started, 1))
    record["refused"] = [str(x) for x in refused(seen.findings)]
    if seen.identified is None:
        return record
    for (name, value), sd in zip(
        seen.identified.ratios.items(), widened(seen.identified)
    ):
        off, half = value / machine.truth[name] - 1, 1.96 * sd / value
        record[name] = [round(100 * off, 2), round(100 * half, 2)]
    return record


def summary(records):
    """How many robots are fitted, how far off they are, and how often held."""
    fits = [x for x in records if not x["refused"]]
    words = dict(robots=len(records), fitted=len(fits))
    for name in ("e_c", "f_c", "d_c", "e_a", "f_a"):
        pairs = [x[name] for x in fits]
        words[name] = dict(
            worst=float(max(abs(off) for off, _ in pairs)),
            inside=int(sum(abs(off) <= half for off, half in pairs)),
        )
    return words | dict(most_seconds=max(x["seconds"] for x in records))


def main(words):
    records = []
    with ProcessPoolExecutor(2) as pool:
        for record in pool.map(fitted, map(int, words) if words else SEEDS):
            records.append(record)
            print(json.dumps(record), flush=True)
    document = dict(summary=summary(records), records=records)
    print(json.dumps(document["summary"]))
    if not words:
        store(RESULTS, document)


if __name__ == "__main__":
    main(sys.argv[1:])
