"""How much of what is true of a known gain is proven, and at what price.

``python -m benchmarks.verify [word ...]`` takes the families of
`benchmarks.verify_plants` (those whose names hold a word), and writes ``verify.json``.

The true decay and the true H-infinity norm are those of numpy and of
`sosbook.analysis`, at a grid of the parameters, at random plants and at the worst of
them moved along each parameter. A claim is asked at some fractions of the truth, the
boldest first, until one is proven. Then 0.1 % more than the truth is claimed: the plant
that `sosbook` names is looked at by numpy's eigenvalues. At last 50 random plants of
each family are held against each claim that was proven.

``python -m benchmarks.verify units`` asks for a little less than the true decay of each
family, and for a little more, in other units of force, length and time, and with gains
that are moved by their last bit. It writes how many verdicts change.
"""

import json
import re
import sys
from dataclasses import replace
from fractions import Fraction
from itertools import product
from pathlib import Path
from time import process_time

import numpy as np

import sosbook as sos
from sosbook.analysis.linear import peak_gain

from .records import store
from .verify_plants import FAMILIES

TARGET = Path(__file__).with_name("verify.json")
DECAYS = 0.999, 0.995, 0.99, 0.98, 0.95, 0.9, 0.8, 0.5
NORMS = 1.003, 1.01, 1.02, 1.05, 1.1, 1.3, 2.0
BROKEN = 1.001
# where squares pull the hull away the two boldest are left out, for the time they take
UNITS = 0.3, 1 / 9.81, 2.2046, 1e-9, 1e9
ASKED = 0.98, 1.01  # of the true decay, in these units
SAMPLES = 50  # plants of each family that each proof is held against
TIME = 60.0  # CPU seconds for a claim, about


def loop(plant, K):
    """E^-1 (A + B K) and E^-1 B_w of a plant."""
    (d,) = plant.vertices
    solved = np.linalg.solve(d.E, np.hstack([d.A + d.Bu @ K, d.Bw]))
    return solved[:, : len(d.E)], solved[:, len(d.E) :], d.C


def rightmost(plant, K):
    """The largest real part of the loop's poles, by numpy."""
    return np.linalg.eigvals(loop(plant, K)[0]).real.max()


def norm(plant, K):
    """The H-infinity norm from w to the outputs."""
    return peak_gain(*loop(plant, K))


def worst(case, value, seed=3):
    """The largest value over the family, by search: a lower bound of the truth."""
    plant, K = case.plant, np.array(case.K, float)
    if not isinstance(plant, sos.Uncertain):
        return value(plant, K)
    low, high = (np.array([float(Fraction(str(x))) for x in ends])
                 for ends in (plant.box.low, plant.box.high))  # fmt: skip

    def at(shares):
        point = low + (high - low) * shares
        return value(plant.at(**dict(zip(plant.box.names, point.round(12)))), K)

    q, rng = len(low), np.random.default_rng(seed)
    steps = {1: 41, 2: 9, 3: 5}.get(q, 2)
    points = [np.array(p) for p in product(np.linspace(0, 1, steps), repeat=q)]
    points += [rng.random(q) for _ in range(60)]
    found = [at(p) for p in points]
    best, top, size = points[int(np.argmax(found))], max(found), 0.1
    while size > 1e-4:
        moves = [np.clip(best + size * s * e, 0, 1) for e in np.eye(q) for s in (1, -1)]
        there = [at(p) for p in moves]
        if max(there) > top:
            best, top = moves[int(np.argmax(there))], max(there)
        else:
            size /= 2
    return top


def claim(case, bound, what):
    """The answer to a claim, and the CPU seconds of answer and proof."""
    asked = (
        dict(region=sos.PoleRegion(float(f"{bound:.6g}")))
        if what == "decay"
        else dict(gamma=float(f"{bound:.6g}"))
    )
    begun = process_time()
    found = sos.analyse_pid(
        case.plant, case.K, coupling="multipliers", time_limit=8 * TIME, **asked
    )
    proven = found.status == "feasible" and found.certify().proven
    return found, proven, process_time() - begun


def confirmed(case, found, bound, what):
    """Whether numpy finds that the plant which is named breaks the claim."""
    if found.status != "infeasible" or not found.infeasibility.proven:
        return False
    plant, K = case.plant, np.array(case.K, float)
    if isinstance(plant, sos.Uncertain):
        values = dict(re.findall(r"(\w+) = ([-\d./e]+)", found.reason.split(":")[1]))
        values = {k: Fraction(values[k].rstrip(".")) for k in plant.box.names}
        plant = plant.at(**{k: float(x) for k, x in values.items()})
    if what == "decay":
        return bool(rightmost(plant, K) > -bound)
    return bool(norm(plant, K) > bound)


def held(case, bound, what):
    """Whether random plants keep a claim."""
    K = np.array(case.K, float)
    if not isinstance(case.plant, sos.Uncertain):
        return True
    plants = case.plant.sample(SAMPLES, 11)
    if what == "decay":
        return all(rightmost(p, K) < -bound for p in plants)
    return all(norm(p, K) < bound for p in plants)


def measured(case, what):
    """A record of one family: what is true, proven and broken, and the price."""
    value = rightmost if what == "decay" else norm
    true = worst(case, value)
    record = {"family": case.name, "of": what, "squares": case.squares}
    if what == "decay":
        true = -true
    record |= {"truth": float(f"{true:.6g}"), "proven": None}
    if not np.isfinite(true) or true <= 0:
        return record | {"note": "unstable"}
    spent = 0.0
    shares = DECAYS if what == "decay" else NORMS
    for share in shares[2 * case.squares :]:
        found, proven, seconds = claim(case, share * true, what)
        spent += seconds
        if proven:
            (part,) = (p for p in found.parts if p.requirement.parameter)
            record |= {
                "proven": share,
                "seconds": round(seconds, 2),
                "cells": part.cells,
                "held": held(case, share * true, what),
            }
            break
        if spent > TIME:
            break
    bound = true * (BROKEN if what == "decay" else 2 - BROKEN)
    found, _, seconds = claim(case, bound, what)
    return record | {
        "broken": confirmed(case, found, bound, what),
        "broken seconds": round(seconds, 2),
    }


def summary(records):
    """The figures of all records."""
    plain = [r for r in records if not r["squares"] and "note" not in r]
    decays = [r for r in plain if r["of"] == "decay"]
    norms = [r for r in plain if r["of"] == "norm"]
    done = [r for r in records if r["proven"]]
    return {
        "decay, 98 % proven": f"{sum((r['proven'] or 0) >= 0.98 for r in decays)} of "
        f"{len(decays)}",
        "norm, 2 % above": f"{sum((r['proven'] or 9) <= 1.02 for r in norms)} of "
        f"{len(norms)}",
        "broken, 0.1 % beyond": f"{sum(r.get('broken', False) for r in records)} of "
        f"{sum('broken' in r for r in records)}",
        "most CPU seconds": max(
            (r["seconds"] for r in done if not r["squares"]), default=None
        ),
        "most CPU seconds, squares": max(
            (r["seconds"] for r in done if r["squares"]), default=None
        ),
        "proofs that a sample breaks": sum(not r["held"] for r in done),
    }


def in_units():
    """How many verdicts of the plain families change in other units, and which."""
    tally = {"requests": 0, "families": 0, "another verdict": []}
    changes = [{name: x} for name in ("force", "length", "time") for x in UNITS]
    for case in FAMILIES:
        if case.squares:
            continue
        truth, first = -worst(case, rightmost), None
        for how in ({}, *changes, None):  # None: the last bit of the gain
            other = case.in_units(**(how or {}))
            if how is None:
                other = replace(case, K=np.nextafter(np.array(case.K, float), np.inf))
            bounds = (x * truth / (how or {}).get("time", 1.0) for x in ASKED)
            verdicts = [
                (found.status, proven)
                for found, proven, _ in (claim(other, b, "decay") for b in bounds)
            ]
            first = first or verdicts
            tally["requests"] += len(verdicts)
            if verdicts != first:
                words = f"{case.name}: {how or 'last bit'}: {verdicts}, not {first}"
                tally["another verdict"].append(words)
        tally["families"] += 1
        print(json.dumps(tally), first, flush=True)
    return tally


def main(words):
    """Measure the families whose names hold one of some words, or all."""
    records, stored = [], json.loads(TARGET.read_text("utf8"))
    if words == ["units"]:
        return store(TARGET, stored | {"in other units": in_units()})
    for case in FAMILIES:
        if words and not any(word in case.name for word in words):
            continue
        for what in ("decay", "norm"):
            records.append(measured(case, what))
            print(json.dumps(records[-1]), flush=True)
    print(json.dumps(summary(records), indent=1))
    if not words:
        store(TARGET, stored | {"summary": summary(records), "records": records})


if __name__ == "__main__":
    main(sys.argv[1:])
