"""The robot, the car seat and the chain of section 3.1."""

import numpy as np

from ...analysis.linear import hinf_norm, peak_input, poles
from ...plants.descriptor import descriptors
from ...plants.response import simulate
from ...plants.second_order import Polytope
from ...requirements.hinf import HInfinity
from ...synthesis.pid import analyse_pid, design_pid
from .. import thesis
from .table import evaluate, proven

READINGS = {"k1 + k2": 4e4 + 5e3, "k1 + b2": 4e4 + 500}  # of S22 of the car seat


def rows(*numbers):
    """Rows of Examples 1, 2 and 3, or of those with some numbers, computed."""
    parts = {1: _robot, 2: _car_seat, 3: _chain}
    for number in numbers or parts:
        yield from parts[number](getattr(thesis, f"example_{number}")())


def _promises(number, ex, digits=4, note=""):
    """The promises of an example of one plant; its norm to some ``digits``, and why."""
    (d,) = descriptors(ex.plant, ex.U, ex.K_A)
    limit, start = ex.saturation.u_max, ex.saturation.x0
    inside = min(x.min() for x in ex.region.distances(poles(d, ex.K)).values())
    yield evaluate(f"example-{number}-region", inside > 0, inside=inside)
    proof = proven(analyse_pid(ex.plant, ex.K, **ex.requirements), 7)
    yield evaluate(f"example-{number}-LMIs", proof)
    own = design_pid(ex.plant, **ex.requirements)
    yield evaluate(f"example-{number}-gains", ex.K, own.K, proof, proven(own, 7))
    norm = hinf_norm(d, ex.K)
    words = dict(gamma=ex.gamma, times=ex.gamma / norm, ours=f"{norm:.{digits}f}")
    yield evaluate(f"example-{number}-norm", norm < ex.gamma, **words, note=note)
    largest = peak_input(d, ex.K, start)
    yield evaluate(f"example-{number}-peak", largest <= limit, limit=limit, u=largest)


def _robot(ex):
    (d,) = descriptors(ex.plant, ex.U)
    yield evaluate("example-1-open", ex.open_loop_poles, ex.plant.poles())
    yield evaluate("example-1-poles", ex.closed_loop_poles, poles(d, ex.K))
    asked = ex.requirements | {"gamma": HInfinity(mu=1.0), "minimize": "gamma"}
    smallest = design_pid(ex.plant, **asked)
    yield from _promises(1, ex, digits=5, note=f"{smallest.gamma:g}")
    t = np.linspace(0, ex.t_end, 3001)
    answer = simulate(d, ex.K, t, r=ex.set_point, w=ex.disturbance)
    limit, largest = ex.saturation.u_max, np.linalg.norm(answer.u, axis=0).max()
    yield evaluate("example-1-input", largest <= limit, limit=limit, u=largest)
    last = np.abs(answer.e[:, -1]).max()
    yield evaluate("example-1-error", last < 1e-3, error=last, end=ex.t_end)


def _car_seat(ex):
    """Rows of example 2, the car seat."""
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
    """Rows of the car seat's motions, for each reading of its stiffness."""
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


def _chain(ex):
    (d,) = descriptors(ex.plant, ex.U, ex.K_A)
    finite = ex.plant.poles()
    infinite = 2 * ex.plant.n - len(finite)
    yield evaluate("example-3-infinity", infinite == 1, infinite=infinite)
    yield evaluate("example-3-open", ex.open_loop_poles, finite)
    yield evaluate("example-3-poles", ex.closed_loop_poles, poles(d, ex.K))
    yield from _promises(3, ex)
    yield from _signals(ex, d)
    yield _complexity(ex)


def _complexity(ex):
    """The number of unknowns that the integrals and K_A add to the design."""
    n, m, a = ex.plant.n, ex.plant.m, len(ex.U)

    def unknowns(states):
        return states * (states + 1) // 2 + m * states  # P and Y

    pd, pid = unknowns(2 * n), unknowns(2 * n + a)
    holds = pid + m * n < 2 * pd
    return evaluate("design-complexity", holds, pd=pd, pid=pid, more=m * n)


def _signals(ex, d):
    """Rows of the inputs and errors of example 3, by simulation."""
    limit, x0 = ex.saturation.u_max, ex.saturation.x0
    t = np.concatenate([np.linspace(0, 0.2, 401), np.linspace(0.21, ex.t_end, 2980)])
    free = simulate(d, ex.K, t, x0=x0, K_A=ex.K_A)
    whole = np.linalg.norm(free.u, axis=0).max()
    yield evaluate("example-3-whole-peak", whole <= limit, limit=limit, peak=whole)
    answer = simulate(d, ex.K, t, ex.set_point, ex.disturbance, K_A=ex.K_A)
    reference = np.concatenate([ex.set_point, np.zeros(d.E.shape[0] - 4)])
    alone = np.linalg.norm(ex.K @ (answer.x.T - reference).T, axis=0).max()
    norms = np.linalg.norm(answer.u, axis=0)
    whole, over = norms.max(), t[norms > limit].max(initial=0.0)
    words = dict(limit=limit, alone=alone, whole=whole, over=over)
    yield evaluate("example-3-input", alone <= limit, whole <= limit, **words)
    last = np.abs(answer.e[:, -1]).max()
    yield evaluate("example-3-error", last < 1e-3, error=last, end=ex.t_end)
