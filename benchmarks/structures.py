"""Large structures of many lightly damped modes: python -m benchmarks.structures.

What is answered by an equation and then proven exactly, and a whole of 20,000 sparse
displacements that is reduced, designed for and looked at. CPU seconds, into
structures.json; names of kinds measure these again and keep the rest, with the computer
and the day of theirs. All are held back, as in `catalogue`: no constant of the
equations is chosen by them.
"""

import json
import sys
from pathlib import Path
from resource import RUSAGE_SELF, getrusage
from time import process_time

import numpy as np
import scipy.sparse as sp

import sosbook as sos
from sosbook.book.turntable import arm, arm_row

from .masses import stations
from .records import store
from .run import machine

RESULTS = Path(__file__).with_name("structures.json")
LONGEST = 1e4  # seconds by the clock, of a busy machine
MOST_FOR_COST = 135  # modes; the exact proof of a cost takes minutes beyond


def player(modes, seed=5, damping=0.002):
    """Modes of an arm of a disc player: frequencies over more than four decades."""
    rng = np.random.default_rng(seed)
    w = np.sort(10 ** rng.uniform(0.4, 4.6, modes))
    B = w[:, None] * rng.normal(size=(modes, 2))
    return sos.SecondOrderSystem(
        np.eye(modes), np.diag(2 * damping * w), np.diag(w**2), B, B
    )


def building(modes, damping=0.023):
    """Storeys on columns, Rayleigh's damping, a force at the roof and the ground."""
    spring = 2 * np.eye(modes) - np.eye(modes, k=1) - np.eye(modes, k=-1)
    spring[-1, -1] = 1.0
    S = 2500.0 * spring
    w = np.sqrt(np.linalg.eigvalsh(S)[[0, -1]])
    weights = 2 * damping * np.array([w[0] * w[1], 1.0]) / w.sum()
    D = weights[0] * np.eye(modes) + weights[1] * S
    B, F = np.eye(modes)[:, -1:], np.ones((modes, 1))
    return sos.SecondOrderSystem(np.eye(modes), D, S, B, F)


def whole(n):
    """A sparse bar of n / 64 layers of 8 x 8 masses, damped in proportion to its
    springs, held at both ends, a force on one mass.
    """
    layers, wide = n // 64, 8
    along, across = (
        sp.diags([-np.ones(k - 1), 2 * np.ones(k), -np.ones(k - 1)], [-1, 0, 1])
        for k in (layers, wide)
    )
    across = across - sp.diags([1.0, *np.zeros(wide - 2), 1.0])  # free sides
    T = sp.kronsum(sp.kronsum(across, across), along, "csc")
    B = np.zeros((n, 1))
    B[64 * (2 * layers // 5)] = 1.0
    return sos.SecondOrderSystem(sp.identity(n), T, 1e4 * T, B)


def on_the_table(n):
    """The arm of chapter 38, which is pushed where its rate is measured."""
    M, S = arm()
    B = np.zeros((n, 1))
    B[arm_row(1.0)] = 1.0
    return sos.SecondOrderSystem(M, 0.2 * M + 5e-8 * S, S, B)


#: From a kind to what makes it, its sizes, and a decay that some modes lack.
KINDS = {
    "station": (lambda modes: stations(modes)[0], (60, 135, 200), 0.02),
    "player": (player, (60,), 0.05),
    "building": (building, (24,), 0.2),
    "whole": (whole, (4992, 19968), 1e-3),
    "arm": (on_the_table, (20_000,), 0.2),
}
WHOLE = "whole", "arm"  # are reduced, and looked at afterwards


def questions(kind, plant, decay):
    """(What is asked, the call) of a kind of plant."""
    N, m = 2 * plant.n, plant.m
    region = sos.PoleRegion(decay)
    asked = f"decay {decay:g}"
    if kind == "arm":
        part = plant.reduce(rows=[arm_row(1.0)], modes=4)
        law = sos.PIDLaw(sensors=sos.Output(velocity=np.eye(1, 5), name="rate"))
        yield (
            f"the tip and 4 modes, its rate, {asked}",
            lambda: sos.analyse_pid(part, {"K_P": [[-1.5]]}, law=law, region=region),
        )
        return
    if kind == "whole":
        part = plant.reduce(modes=12)
        yield f"12 modes, {asked}", lambda: sos.design_pid(part, region=region)
        return
    yield "stable", lambda: sos.design_pid(plant)
    yield asked, lambda: sos.design_pid(plant, region=region)
    if plant.n <= MOST_FOR_COST and kind != "player":
        yield (
            "gamma 0.2",
            lambda: sos.design_pid(plant, gamma=0.2, search=sos.Search(prefer="least")),
        )
    if plant.n <= MOST_FOR_COST:
        yield "least cost", lambda: sos.design_lqr(plant, np.eye(N), np.eye(m))


def measured(kinds=tuple(KINDS), log=print, sizes=None):
    """Records of some kinds: what was asked, the answer, and CPU seconds.

    Without ``sizes`` each kind has its own.
    """
    records = []
    for kind in kinds:
        make, own, decay = KINDS[kind]
        for modes in sizes or own:
            made = process_time()
            plant = make(modes)
            for asked, work in questions(kind, plant, decay):
                record = dict(kind=kind, modes=modes, asked=asked)
                record |= _record(plant, work, made if kind in WHOLE else None)
                log(record)
                records.append(record)
    return dict(machine=machine(), records=records)


def _record(plant, work, begun):
    """What came out of one question; ``begun`` is when its plant was made, if told."""
    begun = process_time() if begun is None else begun
    design = work()
    answered = process_time()
    record = dict(
        status=design.status,
        proven=design.certify().proven,
        largest_gain=float(f"{np.abs(design.K).max():.3g}"),
        moved=design.effort and design.effort.moved,
        answer_s=round(answered - begun, 2),
        proof_s=round(process_time() - answered, 2),
    )
    if design.request.plant is not plant:
        checked = process_time()
        record["whole"] = str(design.check_on(plant, time_limit=LONGEST))
        record["check_s"] = round(process_time() - checked, 2)
        record["peak_mb"] = round(getrusage(RUSAGE_SELF).ru_maxrss / 1e3)
    return record


if __name__ == "__main__":
    wanted = sys.argv[1:] or list(KINDS)
    new = measured(wanted)
    if RESULTS.exists():
        old = json.loads(RESULTS.read_text("utf-8"))
        other = {x: old["machine"][x] for x in ("cpu", "date")}
        kept = [other | r for r in old["records"] if r["kind"] not in wanted]
        new["records"] = kept + new["records"]
    store(RESULTS, new)
