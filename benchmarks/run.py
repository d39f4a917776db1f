"""All families and competitors; what they give as one document."""

import importlib.metadata
import os
import platform
import subprocess
import time
from dataclasses import asdict
from datetime import date
from pathlib import Path

from .catalogue import FAMILIES
from .clock import MEMORY, SECONDS, Job, trial
from .clock import sizes as sizes_of
from .competitors import COMPETITORS, Direct, Sosbook

#: What is measured besides the profile, of sosbook alone: families and sizes.
SECTIONS = {
    "growth": {"free chain": (40, 60, 100, 200), "grid": (40, 60, 100, 200)},
    "monotony": {
        "grounded chain": range(2, 25),
        # with others all forces stand where some mode has no motion
        "free chain": (2, 4, 6, 8, 9, *range(11, 15), *range(16, 25)),
        "grid": range(2, 25),
    },
    "small": {  # with those who take finished data
        **dict.fromkeys(("tree", "grid", "modes"), range(1, 7)),
        "free chain": (1, 2, 4, 6),
        **dict.fromkeys(("delayed chain", "delayed modes"), range(1, 5)),
        "grounded chain": range(2, 7),
        "arm": (1, 2, 3),
        "published": range(1, 9),
        "foreign": range(1, 19),
    },
}
LONG = 60.0  # CPU seconds of a call of those
QUICK = dict(families=("free chain", "bicycles", "arm"), largest=4)

FIELDS = {
    "section": "profile, growth, monotony or small",
    "family": "see families",
    "size": "what it counts stands there",
    "n": "degrees of freedom",
    "m": "inputs",
    "unknowns": "free numbers in all unknowns",
    "vertices": "of the polytope",
    "competitor": "see competitors",
    "status": "right; wrong: the answer breaks a block or isn't the optimum; no "
    "answer; over the limit; not tried: over the limit at a smaller size, or by "
    "extrapolation; not installed",
    "coordinates": "raw: the plant's own; frame: sosbook's well conditioned ones, "
    "the second try",
    "cpu_s": "median CPU seconds of a call, from the plant to the answer",
    "data_s": "the part of it in which the benchmark makes a solver's data; None where "
    "it wasn't looked at",
    "calls": "how many",
    "margin": "smallest eigenvalue of all blocks at the answer, each diagonal "
    "scaled to one, in the plant's own coordinates; right demands more than 1e-9",
    "excess": "of an optimum: true cost of the loop over the Riccati equation's, "
    "relative; right demands less than 1e-3",
    "base_mb": "resident memory before the call, MB",
    "peak_mb": "the largest during the calls",
    "why": "there is no right answer",
    "measured": "date, processor (that of the machine where none is named), and git's "
    "names of the source that was measured",
}


def measure(
    families=(),
    competitors=(),
    sections=(),
    old=None,
    quick=False,
    log=print,
    save=None,
):
    """Measure the named ones, or all; of ``old`` the others are kept.

    Parameters
    ----------
    families, competitors, sections : sequences of str
        Empty for all.
    old : dict, optional
        A document whose other records are kept.
    quick : bool
        Small sizes of three families.
    save : callable, optional
        Is given the document after each family.

    Returns
    -------
    dict
        machine, families, fields, records and so on: see README.md.
    """
    begin, records = time.perf_counter(), []
    chosen = list(families) or (QUICK["families"] if quick else list(FAMILIES))
    who = list(competitors) or list(COMPETITORS)
    parts = list(sections) or ["profile", *([] if quick else SECTIONS)]

    def document():
        return gathered(records, old, quick)

    for section in parts:
        for name in chosen:
            if section == "profile":
                sizes = FAMILIES[name].sizes
                if quick:
                    sizes = [s for s in sizes if s <= QUICK["largest"]]
                fresh = of_family(name, sizes, who, SECONDS)
            elif name in SECTIONS[section]:
                others, limit = ((), LONG) if section != "small" else (Direct, SECONDS)
                kinds = Sosbook, others
                asked = [c for c in who if issubclass(COMPETITORS[c], kinds)]
                fresh = of_family(name, SECTIONS[section][name], asked, limit)
            else:
                continue
            fresh = [dict.fromkeys(FIELDS) | r | dict(section=section) for r in fresh]
            records += fresh
            right = sum(r["status"] == "right" for r in fresh)
            passed = time.perf_counter() - begin
            log(
                f"{passed:6.0f} s  {section}, {name}: {right} of {len(fresh)} right",
                flush=True,
            )
            if save is not None:
                save(document())
    return document()


def gathered(records, old, quick=False):
    """The document of some records and of an old one's others."""
    kept = []
    if old is not None:
        again = {_key(r) for r in records}
        kept = [r for r in old["records"] if _key(r) not in again]
    order = list(FAMILIES)
    both = [r for r in kept + records if _wanted(r)]
    both.sort(key=lambda r: (r["section"], order.index(r["family"]), r["size"]))
    return dict(
        about="CPU seconds of sosbook and its peers on families of plants. One "
        "thread; every answer judged by the eigenvalues of its LMIs.",
        quick=quick,
        machine=machine() if old is None else old["machine"],
        seconds=SECONDS,
        memory_mb=MEMORY,
        fields=FIELDS,
        competitors={
            c.name: dict(asked=c.asked, note=c.__doc__) for c in COMPETITORS.values()
        },
        families={
            name: {k: v for k, v in asdict(f).items() if k != "make"}
            for name, f in FAMILIES.items()
        },
        records=both,
    )


def _wanted(r):
    """Whether a record's family and size are still those of the table."""
    name, section = r["family"], r["section"]
    if section == "profile":
        return name in FAMILIES and r["size"] in FAMILIES[name].sizes
    return r["size"] in SECTIONS.get(section, {}).get(name, ())


def _key(r):
    return tuple(r[k] for k in ("section", "family", "size", "competitor"))


def of_family(name, sizes, competitors, seconds):
    """Records of a family; whoever exceeds the limit isn't asked larger sizes."""
    last, records, state = {}, [], source()
    for size in sizes:
        known = dict(family=name, size=size, measured=state) | sizes_of(name, size)
        for competitor in competitors:
            why = not_tried(name, size, competitor, last.get(competitor), seconds)
            if why is None:
                found = trial(Job(name, size, competitor, seconds))
                last[competitor] = (size, found)
            else:
                found = why
            records.append(known | dict(competitor=competitor) | found)
    return records


def not_tried(family, size, competitor, last, seconds):
    """Why it isn't asked, as a record's fields; None if it is.

    Parameters
    ----------
    last : (int, dict) or None
        The size before and what was found there.
    """
    peer, counts = COMPETITORS[competitor], FAMILIES[family].size
    if not peer.installed():
        return dict(status="not installed")
    if last is None or counts == "in the collection":
        return None
    before, found = last
    if found["status"] == "over the limit":
        return dict(status="not tried", why=f"over the limit at {before}")
    if found.get("cpu_s") is None:
        return None
    power = peer.growth if counts == "degrees of freedom" else 1
    least = found["cpu_s"] * (size / before) ** power
    if competitor != "sosbook" and least > seconds:
        return dict(
            status="not tried",
            why=f"{least:.0f} s or more, by its {found['cpu_s']:.3g} s at {before}",
        )
    return None


def source():
    """The date, the processor, and git's names for the solver's rooms at that time."""
    folder = Path(__file__).parents[1]
    rooms = [f"sosbook/{room}" for room in ("lmi", "synthesis", "delay")]

    def git(*words):
        ran = subprocess.run(
            ["git", *words], cwd=folder, capture_output=True, check=True
        )
        return ran.stdout.decode("utf-8").split()

    try:
        trees = git("rev-parse", *(f"HEAD:{room}" for room in rooms))
        trees = " ".join(tree[:10] for tree in trees)
        trees += " and changes" if git("status", "--porcelain", *rooms) else ""
    except (OSError, subprocess.CalledProcessError):
        trees = "unknown"
    return f"{date.today().isoformat()}, {_cpu()}, {trees}"


def machine():
    """What the times depend on."""
    versions = {}
    peers = ["cvxpy", "clarabel", "cvxopt", "sdpa-python", "scs"]
    for name in ["sosbook", "numpy", "scipy", *peers]:
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
