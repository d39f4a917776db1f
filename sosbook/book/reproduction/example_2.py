"""Example 2, the seat of a car."""

import numpy as np

from ...analysis.linear import hinf_norm, peak_input, poles
from ...plants.descriptor import descriptors
from ...plants.response import simulate
from ...plants.second_order import Polytope
from ...synthesis.pid import analyse_pid, design_pid
from .. import thesis
from .table import evaluate, proven

READINGS = {"k1 + k2": 4e4 + 5e3, "k1 + b2": 4e4 + 500}  # of S22


def rows():
    """Rows of Example 2, computed."""
    ex = thesis.example_2()
    loops = descriptors(Polytope([thesis.car_seat(m) for m in range(70, 121)]), ex.U)

    def inside(points):
        return min(x.min() for x in ex.region.distances(points).values())

    gap = inside(np.array([poles(d, ex.K) for d in loops]))
    yield evaluate("example-2-region", gap > 0, gap=gap)
    proof = proven(analyse_pid(ex.plant, ex.K, coupling="pairs", **ex.requirements), 7)
    yield evaluate("example-2-LMIs", proof)
    yield _stiffness(ex, proof)
    own = design_pid(ex.plant, **ex.requirements)
    yield evaluate("example-2-gains", ex.K, own.K, proof, proven(own, 7))
    norm = max(hinf_norm(d, ex.K) for d in loops)
    yield evaluate(
        "example-2-norm", norm < ex.gamma, gamma=ex.gamma, norm=norm, n=ex.gamma / norm
    )
    limit = ex.saturation.u_max
    peak = max(peak_input(d, ex.K, ex.saturation.x0) for d in loops)
    yield evaluate("example-2-peak", peak <= limit, limit=limit, peak=peak)
    yield from _motions(ex, loops)


def _stiffness(ex, proof):
    """S22: a common displacement by 1 m must stretch k1 alone."""
    shift = {x: (thesis.car_seat(100, k).S @ [1, 1]) for x, k in READINGS.items()}
    misprinted = Polytope([thesis.car_seat(m, READINGS["k1 + b2"]) for m in (70, 120)])
    both = proof and proven(analyse_pid(misprinted, ex.K, **ex.requirements), 7)
    return evaluate(
        "example-2-S22",
        *(np.array_equal(shift[x], [0, 4e4]) for x in ("k1 + b2", "k1 + k2")),
        force=shift["k1 + b2"][1],
        which="either reading, so poles can't decide" if both else "one reading only",
    )


def _motions(ex, loops):
    t = np.linspace(0, ex.t_end, 2001)

    def answer(loop):
        return simulate(loop, ex.K, t, ex.set_point, ex.disturbance)

    runs = {}
    for name, k in READINGS.items():
        (loop,) = descriptors(thesis.car_seat(100, k), ex.U)
        runs[name] = answer(loop)
    limit = ex.saturation.u_max
    peaks = {x: np.linalg.norm(run.u, axis=0).max() for x, run in runs.items()}
    ends = {x: abs(run.u[1, -1]) / 1000 for x, run in runs.items()}
    yield evaluate(
        "example-2-input",
        *(p <= limit for p in peaks.values()),
        limit=limit,
        ours="; ".join(f"{p:.7g} with {name}" for name, p in peaks.items()),
        ends=" or ".join(f"{end:.1f} kN ({name})" for name, end in ends.items()),
    )
    printed = [answer(loop) for loop in loops[::10]]
    last = max(np.abs(a.e[:, -1]).max() for a in printed)
    yield evaluate("example-2-error", last < 1e-3, error=last, end=ex.t_end)
    spread = np.ptp([a.z[0] for a in printed], axis=0).max()
    yield evaluate("example-2-spread", spread < 0.1, mm=1000 * spread)
