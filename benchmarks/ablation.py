"""What each path of the solver is worth: python -m benchmarks.ablation.

One path is switched off at a time, and requests are solved with and without it, in
turns and in one process: small ones at random, and all plants of the catalogue's
held-back half. The rule is that a path stays if, switched off alone, it costs a
factor of 1.3 on a held-back family or changes a verdict.

``--paths`` names some of them, ``--table`` prints what ``ablation.json`` holds. What
was measured of paths that are gone stays in that file.
"""

import argparse
import json
from contextlib import ExitStack
from datetime import date
from importlib import import_module
from math import inf
from pathlib import Path
from statistics import geometric_mean
from time import process_time
from unittest.mock import patch

import numpy as np

import sosbook as sos
from benchmarks.catalogue import FAMILIES, HELD_BACK, case
from benchmarks.questions import NoAnswer
from benchmarks.records import store
from benchmarks.run import machine
from sosbook.solver.settings import Settings

RESULTS = Path(__file__).with_name("ablation.json")
SMALL = 30  # random requests
TOO_LONG = {("modes", 24)}  # as long as all others together
WORTH = 1.3  # a factor of time on a held-back family, for which a path stays
SAME_GAIN = 1e-5  # relative; a larger difference is counted
SHORT, REPEATS = 0.1, 3  # a call of fewer seconds is timed so often, others once
RANDOM = "random requests"

FIELDS = {
    "path": "what was switched off",
    "family": "of the catalogue's held-back half, or random requests",
    "size": "of the family's plant, or the seed of the request",
    "with_s": "shortest CPU seconds of a call with the path",
    "without_s": "without it",
    "verdicts": "with and without, where they differ",
    "gain": "largest difference of the gains by their largest entry",
    "beside": "whether the family isn't held back, and shows what the path is for",
}


def _settings(**changed):
    """Other numbers for all blocks."""
    return "sosbook.solver.blocks", "Blocks.settings", Settings(**changed)


def _synthesis(module, name, value):
    return f"sosbook.synthesis.{module}", name, value


def _none(*args, **hints):
    return None


#: From a path to (what it does, [(module, name, what takes its place), ..]).
PATHS = {
    "curves": ("Newton's steps are bent", [_settings(straight_below=inf)]),
    "steps near a centre": (
        "S and Z step where Newton's method is slow",
        [("sosbook.solver.loop", "near_centre", _none)],
    ),
    "table of slopes": (
        "blocks of few variables from one dense table",
        [_settings(table_per_product=0)],
    ),
    "slabs": (
        "large symmetric unknowns by slabs of the Kronecker product",
        [_settings(slabs_from_rows=10**9)],
    ),
    "arrow": (
        "Newton's matrix as an arrow where vertices have a P each",
        [_settings(arrow_from_variables=10**9)],
    ),
    "conjugate gradients": (
        "instead of a dense matrix of many variables",
        [_settings(iterations_per_variable=0.0)],
    ),
    "pairs read at once": (
        "blocks of many pairs of vertices from one reading",
        [_synthesis("request", "blocks_of_pairs", lambda *args: {})],
    ),
    "a frame's gain": (
        "phase one begins at the gain of a Riccati equation",
        [_synthesis("scaled_lmis", "ScaledLMIs.guess", _none)],
    ),
    "cuts": (
        "of many pairs of vertices a few decide",
        [
            _synthesis("cutting", "PAIRS_PER_CUT", 10**9),
            _synthesis("cutting", "CUTTING_PLANE_ABOVE_PAIRS", 10**9),
        ],
    ),
    "Riccati points": (
        "a minimum begins at a Riccati equation's gain",
        [
            _synthesis("lqr", "riccati_point", _none),
            _synthesis("observer", "riccati_observer", _none),
        ],
    ),
}

#: Why a path stays that the rule would strike; the time is that of `BESIDE`.
KEPT = {
    "cuts": "256 uncertain springs, which aren't held back, take {:.1f} times as long; "
    "and more than a thousand pairs aren't written at once",
    "steps near a centre": "with curves off as well some sets are taken for ones "
    "without a centre, and gains change",
    "arrow": "no held-back family has many vertices and a slack matrix; 32 vertices "
    "of five masses take {:.1f} times as long, and a given gain at 128 of seven "
    "masses, a P for each, isn't proven in time",
}


def _slack():
    """32 vertices of five masses, a P for each."""
    from tests.cases import chain

    rng, plants = np.random.default_rng(0), []
    for _ in range(32):
        v = chain(5)
        k = rng.uniform(0.9, 1.1, 5)
        plants.append(sos.SecondOrderSystem(np.diag(k), v.D, k[0] * v.S, v.B, v.F))
    found = sos.design_pid(
        sos.Polytope(plants), region=sos.PoleRegion(0.1), gamma=10.0, coupling="slack"
    )
    return found.status, found.K


#: What isn't held back, but shows what a path is for: (its name, its size).
BESIDE = {
    "conjugate gradients": ("grounded chain", 40),
    "cuts": ("uncertain springs", 256),
    "arrow": ("slack", 32),
}


class without(ExitStack):
    """A context in which something else stands in the places of a ``path``."""

    def __init__(self, path):
        super().__init__()
        self.places = PATHS[path][1]

    def __enter__(self):
        for module, name, value in self.places:
            home, (*classes, name) = import_module(module), name.split(".")
            for c in classes:
                home = getattr(home, c)
            self.enter_context(patch.object(home, name, value))
        return self


def requests(quick=False):
    """What is solved: from (family, size) to a function that returns (status, K)."""
    from tests.cases import random_request

    def small(seed):
        found = sos.design_pid(**random_request(seed), search=sos.Search(time_limit=60))
        return found.status, found.K

    return {
        (RANDOM, seed): lambda seed=seed: small(seed)
        for seed in range(4 if quick else SMALL)
    } | {
        (name, size): of_family(name, size)
        for name, family in FAMILIES.items()
        for size in family.sizes[: 1 if quick else None]
        if family.half == HELD_BACK and (name, size) not in TOO_LONG
    }


def of_family(name, size):
    """The work on a plant of the catalogue: returns (status, K)."""
    question = case(name, size)

    def work():
        try:
            answer = question.design()
        except NoAnswer as failure:
            return str(failure).split(":")[0], None
        if "P" in answer:
            right = answer["P"] if answer["V"] is None else answer["V"]
            return "feasible", np.linalg.solve(right, answer["Y"].T).T
        gain = answer.get("K", answer.get("L"))
        return "feasible", answer["values"]["X"] if gain is None else gain

    return work


def compared(work, path):
    """A record's times, verdicts and gains of some ``work`` with and without a path."""
    times, answers, count = ([], []), [None, None], 0
    while count < 1 or (count < REPEATS and max(map(max, times)) < SHORT):
        for k in (0, 1):
            with ExitStack() if k == 0 else without(path):
                begun = process_time()
                answers[k] = work()
                times[k].append(process_time() - begun)
        count += 1
    (before, K), (after, other) = answers
    gain = None
    if K is not None and other is not None:
        gain = float(np.abs(K - other).max() / (np.abs(K).max() or 1.0))
    return dict(
        with_s=min(times[0]),
        without_s=min(times[1]),
        verdicts=None if before == after else [before, after],
        gain=gain,
    )


def measured(paths=(), quick=False, log=print):
    """A document with the records of some ``paths``, or of all."""
    records = []
    some = requests(quick)
    for work in some.values():  # what is kept for later requests, kept by all
        work()
    for path in paths or PATHS:
        beside = {} if quick or path not in BESIDE else _beside(path)
        for (family, size), work in [*some.items(), *beside.items()]:
            found = compared(work, path)
            which = dict(path=path, family=family, size=size)
            records.append(which | found | {"beside": (family, size) in beside})
        log(row(path, records))
    does = {path: PATHS[path][0] for path in paths or PATHS}
    return dict(
        fields=FIELDS,
        machine=machine(),
        measured=dict.fromkeys(does, date.today().isoformat()),
        paths=does,
        records=records,
    )


def _beside(path):
    """The work that shows what a path is for."""
    where = BESIDE[path]
    work = _slack if where[0] == "slack" else of_family(*where)
    work()
    return {(f"{where[0]}, beside", where[1]): work}


def summary(path, records):
    """What the records of a path say.

    Returns
    -------
    dict
        Geometric means of without_s / with_s: ``random``, ``held_back``, and of the
        families the largest, ``worst``, with its name, ``where``; how many
        ``verdicts`` and ``gains`` differ; whether the path ``stays`` by the rule; and
        the ratio ``beside`` it, of what isn't held back, or None.
    """
    ratios, own, beside = {}, [], None
    for r in (r for r in records if r["path"] == path):
        if r.get("beside"):
            beside = r["without_s"] / r["with_s"]
        else:
            own.append(r)
    for r in own:
        ratios.setdefault(r["family"], []).append(r["without_s"] / r["with_s"])
    small = ratios.pop(RANDOM, [1.0])
    means = {family: _mean(some) for family, some in ratios.items()}
    where = max(means, key=means.get)
    verdicts = sum(r["verdicts"] is not None for r in own)
    return dict(
        random=_mean(small),
        held_back=_mean([x for some in ratios.values() for x in some]),
        worst=means[where],
        where=where,
        verdicts=verdicts,
        gains=sum((r["gain"] or 0) > SAME_GAIN for r in own),
        stays=bool(means[where] >= WORTH or verdicts),
        beside=beside,
    )


def _mean(ratios):
    """The geometric mean, in digits that any processor gives."""
    return round(geometric_mean(ratios), 6)


HEAD = (
    f"{'switched off alone':24} {'random':>6} {'held back':>9}  {'worst family':21} "
    f"{'verdicts':>8} {'gains':>5}"
)


def row(path, records):
    """A line of the table."""
    s = summary(path, records)
    return (
        f"{path:24} {s['random']:6.2f} {s['held_back']:9.2f}  "
        f"{s['worst']:5.2f} {s['where']:15} {s['verdicts']:8} {s['gains']:5}"
    )


def table(document):
    """The table of a ``document``, as text: what stays, and what is gone."""
    gone = [p for p in document["paths"] if p not in PATHS]
    lines = [HEAD]
    lines += [row(p, document["records"]) for p in document["paths"] if p in PATHS]
    if gone:
        lines += ["gone since", *(row(p, document["records"]) for p in gone)]
    return "\n".join(lines)


def joined(old, new):
    """The ``old`` document with what is ``new`` in it."""
    kept = [r for r in old["records"] if r["path"] not in new["paths"]]
    return new | {
        "measured": old["measured"] | new["measured"],
        "paths": old["paths"] | new["paths"],
        "records": kept + new["records"],
    }


def told(document):
    """A ``document`` with what its records say: ``summaries``, and why paths ``stay``.

    The page on performance reads them, for it runs where this folder is no package.
    """
    records = document["records"]
    summaries = {
        path: summary(path, records) | {"in_use": path in PATHS}
        for path in document["paths"]
    }
    stay = {
        path: why.format(summaries[path]["beside"])
        for path, why in KEPT.items()
        if path in summaries and ("{" not in why or summaries[path]["beside"])
    }
    return document | {"summaries": summaries, "stay": stay}


def main(words=None):
    parser = argparse.ArgumentParser(
        "python -m benchmarks.ablation",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--paths", nargs="+", choices=PATHS, default=[], metavar="PATH")
    parser.add_argument("--quick", action="store_true", help="a few requests")
    parser.add_argument("--table", action="store_true", help="print, measure nothing")
    parser.add_argument("--output", type=Path, default=RESULTS)
    asked = parser.parse_args(words)
    old = None
    if asked.output.exists():
        old = json.loads(asked.output.read_text("utf-8"))
    if asked.table:
        print(table(old))
        return
    print(HEAD)
    new = measured(asked.paths, asked.quick, lambda line: print(line, flush=True))
    new = told(new if old is None else joined(old, new))
    store(asked.output, new)


if __name__ == "__main__":
    main()
