"""Space structures of many lightly damped modes: python -m benchmarks.structures.

Frequencies from 2 to 400 rad/s, damping of half a per cent, three inputs: what is
answered by an equation and then proven exactly. CPU seconds, into structures.json.
"""

import os

from sosbook.runtime.progress import WITHOUT_BARS
from sosbook.runtime.threads import ONE_THREAD

os.environ.update(ONE_THREAD | WITHOUT_BARS)  # before numpy is imported

import json
from pathlib import Path
from time import process_time

import numpy as np

import sosbook as sos

from .run import machine

__all__ = ["RESULTS", "measured", "structure"]

RESULTS = Path(__file__).with_name("structures.json")
SIZES = 60, 135, 200
MOST_FOR_COST = 60  # modes; the exact proof of a cost takes long beyond


def structure(modes, seed=3, damping=0.005):
    """A `SecondOrderSystem` of some modes, in coordinates that mix them."""
    rng = np.random.default_rng(seed)
    w = np.sort(10 ** rng.uniform(0.3, 2.6, modes))
    V = np.linalg.qr(rng.normal(size=(modes, modes)))[0]
    D, S = (V * (2 * damping * w)) @ V.T, (V * w**2) @ V.T
    B, F = 0.01 * rng.normal(size=(modes, 3)), 0.01 * rng.normal(size=(modes, 1))
    return sos.SecondOrderSystem(np.eye(modes), (D + D.T) / 2, (S + S.T) / 2, B, F)


def questions(plant):
    """(What is asked, the call)."""
    N, m = 2 * plant.n, plant.m
    yield "stable", lambda: sos.design_pid(plant)
    yield "decay 0.02", lambda: sos.design_pid(plant, region=sos.PoleRegion(0.02))
    if plant.n <= MOST_FOR_COST:
        yield "gamma 0.2", lambda: sos.design_pid(plant, gamma=0.2, prefer="least")
        yield "least cost", lambda: sos.design_lqr(plant, np.eye(N), np.eye(m))


def measured(sizes=SIZES, log=print):
    """Records of all sizes: what was asked, the answer, and CPU seconds."""
    records = []
    for modes in sizes:
        plant = structure(modes)
        for asked, work in questions(plant):
            begun = process_time()
            design = work()
            answered = process_time()
            record = dict(
                modes=modes,
                asked=asked,
                status=design.status,
                proven=design.certify().proven,
                largest_gain=float(f"{np.abs(design.K).max():.3g}"),
                moved=design.effort.moved,
                answer_s=round(answered - begun, 2),
                proof_s=round(process_time() - answered, 2),
            )
            log(record)
            records.append(record)
    return dict(machine=machine(), records=records)


if __name__ == "__main__":
    RESULTS.write_text(json.dumps(measured(), indent=1) + "\n", "utf-8")
