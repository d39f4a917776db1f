"""All cases, one after the other; what they give as one document."""

import importlib.metadata
import os
import platform
import time
from concurrent.futures import ThreadPoolExecutor
from datetime import date
from pathlib import Path

import numpy as np

from . import maps, sliders
from .cases import CASES
from .measure import FIELDS, Job, rounds, summary, trial
from .peers import PEERS

__all__ = ["SPECIAL", "growth", "machine", "measure"]

SPECIAL = ("sliders", "map")
REFERENCE = "sosbook"  # the ratios' denominator
ALONE = 2.0  # seconds from which a call is timed in its own process, once


def measure(names=(), quick=False, old=None, log=print):
    """Measure the named cases, or all.

    Parameters
    ----------
    names : sequence of str
    quick : bool
        The small cases, fewer repeats, shorter limits.
    old : dict, optional
        A document whose other cases are kept.

    Returns
    -------
    dict
        machine, fields, records, growth: see README.md.
    """
    begin = time.perf_counter()
    budget = 2.0 if quick else 6.0
    chosen = [
        c
        for c in CASES.values()
        if (c.name in names if names else c.quick or not quick)
    ]
    special = [s for s in SPECIAL if not names or s in names]
    records, last = [], {}
    for case in chosen:
        fresh = case_records(case, limit(case, quick), budget, last)
        records += fresh
        right = sum(r["status"] == "right" for r in fresh)
        log(
            f"{time.perf_counter() - begin:6.0f} s  {case.name}: {right} of "
            f"{len(fresh)} records are right",
            flush=True,
        )
    if "sliders" in special:
        for k in (1, 2, 3):
            records += sliders.moves(k, 12 if quick else 60)
            records += sliders.answers(k, 3 if quick else 15)
        log(f"{time.perf_counter() - begin:6.0f} s  sliders", flush=True)
    if "map" in special:
        records += maps.records(quick)
        log(f"{time.perf_counter() - begin:6.0f} s  map", flush=True)
    if old is not None:
        again = {(r["family"], r["case"]) for r in records}
        kept = [r for r in old["records"] if (r["family"], r["case"]) not in again]
        records = kept + records
        begin -= old["seconds"]
    return dict(
        about="Times of sosbook and its peers. One thread, calls in turns, "
        "medians; every answer judged by the eigenvalues of its LMIs. "
        "Compare ratios, not seconds.",
        quick=quick,
        seconds=time.perf_counter() - begin,
        machine=machine(),
        fields=FIELDS,
        records=records,
        growth=growth(records),
    )


def limit(case, quick):
    """Seconds that a call may take."""
    if quick or case.family == "vertices":
        return 60.0
    return 300.0 if case.size >= 200 else 200.0


def case_records(case, most, budget, last):
    """Records of one case.

    Parameters
    ----------
    most : float
        Seconds that a call may take.
    budget : float
        Seconds for all the calls in turns.
    last : dict
        From (family, peer) to the previous size and its seconds, None if
        over the limit; updated.
    """
    sizes = Job(case.name, REFERENCE, "frame").sizes() | dict(limit_s=most)
    found, idle, calls = {}, [], []
    for name, peer in PEERS.items():
        if not peer.suits(case):
            continue
        job = Job(case.name, name, peer.coordinates)
        before = last.get((case.family, name), (case.size, 0.0))
        if not peer.installed():
            idle.append((job, "not installed"))
        elif not peer.reaches(case) or before[1] is None:
            idle.append((job, "not tried"))
        else:
            calls.append((job, expected(before, case)))
    again = budget > 2  # in the full run
    found |= trials(calls, most, again)
    framed = [
        (Job(case.name, job.peer, "frame"), seconds)
        for job, seconds in calls
        if PEERS[job.peer].framed and found[job]["status"] in ("wrong", "no answer")
    ]
    found |= trials(framed, most, again)
    quick = {}
    for job, one in found.items():
        seconds = max(one.get("times", {}).values(), default=None)
        if one["status"] == "over the limit" and case.size:
            last[case.family, job.peer] = (case.size, None)
        if seconds is not None:
            if case.size:
                last[case.family, job.peer] = (case.size, seconds)
            if one["status"] == "right" and seconds < ALONE:
                quick[job] = seconds
    timed = rounds(quick, budget)
    records = [job.record(status=word, **sizes) for job, word in idle]
    for job, one in found.items():
        records += clocks(job, one, timed.get(job), sizes)
    ours = {r["clock"]: r["median_s"] for r in records if r["competitor"] == REFERENCE}
    for r in records:
        if r["median_s"] is not None and ours.get(r["clock"]):
            r["ratio"] = r["median_s"] / ours[r["clock"]]
    return records


def clocks(job, one, timed, sizes):
    """One record for each clock, or one that says why there is none."""
    known = {
        k: one.get(k) for k in ("status", "margin", "excess", "base_mb", "peak_mb")
    }
    if known["excess"] == float("inf"):
        known["excess"] = None
    if one["status"] != "right":
        made = job.record(**sizes, **known)
        more = [one["why"]] if "why" in one else []
        if one.get("times"):
            more.append(f"after {max(one['times'].values()):.3g} s")
        made["note"] = "; ".join(filter(None, [made["note"], *more]))
        return [made]
    times = timed or {c: [s] for c, s in one["times"].items()}
    return [
        job.record(clock=clock, **sizes, **known, **summary(seconds))
        for clock, seconds in times.items()
    ]


def trials(calls, most, again):
    """Trials of (job, expected seconds); the short ones two at a time."""
    short = [job for job, seconds in calls if seconds < ALONE]
    long = [job for job, seconds in calls if seconds >= ALONE]
    with ThreadPoolExecutor(2) as pool:
        found = dict(zip(short, pool.map(lambda j: trial(j, most), short)))
    for job in short:  # longer than expected: again, alone
        seconds = max(found[job].get("times", {}).values(), default=0)
        if again and seconds >= ALONE:
            long.append(job)
    return found | {job: trial(job, most) for job in long}


def expected(before, case):
    """Seconds, from those of the size before: like n^5, like vertices."""
    size, seconds = before
    power = 1 if case.family == "vertices" else 5
    return seconds * (case.size / size) ** power if size else seconds


def growth(records):
    """Exponents of time against n between a chain's two largest sizes.

    For sosbook between 40 and 100, where both were measured.
    """
    found = []
    chains = [
        r
        for r in records
        if r["family"] == "chain" and r["median_s"] and r["status"] == "right"
    ]
    keys = {(r["competitor"], r["coordinates"], r["clock"]) for r in chains}
    for key in sorted(keys):
        times = {
            r["n"]: r["median_s"]
            for r in chains
            if key == (r["competitor"], r["coordinates"], r["clock"])
        }
        ends = [40, 100] if {40, 100} <= set(times) else sorted(times)[-2:]
        if len(ends) < 2:
            continue
        small, large = ends
        exponent = np.log(times[large] / times[small]) / np.log(large / small)
        found.append(
            dict(
                competitor=key[0],
                coordinates=key[1],
                clock=key[2],
                from_n=small,
                to_n=large,
                exponent=float(exponent),
            )
        )
    return found


def machine():
    """What the times depend on."""
    packages = (
        "sosbook",
        "numpy",
        "scipy",
        "cvxpy",
        "clarabel",
        "cvxopt",
        "sdpa-python",
        "scs",
        "picos",
    )
    versions = {}
    for name in packages:
        try:
            versions[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            versions[name] = None
    memory = None
    if hasattr(os, "sysconf") and "SC_PHYS_PAGES" in os.sysconf_names:
        memory = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    return dict(
        cpu=_cpu(),
        cores=os.cpu_count(),
        threads=1,
        memory_gb=memory and round(memory / 2**30, 1),
        system=f"{platform.system()} {platform.machine()}",
        python=platform.python_version(),
        packages=versions,
        date=date.today().isoformat(),
    )


def _cpu():
    try:
        for line in Path("/proc/cpuinfo").read_text("utf-8").splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()
