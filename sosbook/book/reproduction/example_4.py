"""Example 4, the flexible rotor with an arm."""

import numpy as np

from ...analysis.linear import poles
from ...analysis.nonlinear import arm_gravity, simulate_nonlinear
from ...plants.descriptor import descriptors
from ...plants.second_order import Polytope
from ...plants.signals import Steps
from ...requirements.pole_region import PoleRegion
from ...synthesis.pid import analyse_pid, design_pid
from .. import thesis
from .region_of_attraction import region_of_attraction
from .table import below, evaluate, matched, proven, said

SET_POINTS = np.radians([30, 60, 10, -30, 0])  # rad, three seconds each


def rows():
    """Rows of Example 4, computed."""
    ex = thesis.example_4()
    yield from _tabulated(ex)
    yield from _promises(ex)
    yield _swing(ex)
    yield _tracks(ex)


def _poles(ex, plant, U=None):
    (d,) = descriptors(plant, ex.U if U is None else U)
    return poles(d, ex.K)


def _off(printed, computed):
    """The largest distance of computed poles from the printed ones."""
    return np.abs(printed - matched(printed, computed)).max()


def _tabulated(ex):
    """Table 3.3, and what it tells of U and S2."""
    first, second = ex.closed_loop_poles
    wrong = _off(first, _poles(ex, ex.plant.vertices[0], [[1, 0]]))
    names = ("0", "± pi/2")
    for name, vertex, printed in zip(names, ex.plant.vertices, ex.open_loop_poles):
        # undamped: rounding alone makes a real part
        yield evaluate("example-4-open", printed, 1j * vertex.poles().imag, angle=name)
    for name, vertex, printed in zip(names, ex.plant.vertices, ex.closed_loop_poles):
        ours = _poles(ex, vertex)
        yield evaluate("example-4-poles", printed, ours, angle=name, wrong=wrong)

    def labelled(*angles):
        plants = [thesis.arm(np.sinc(phi / np.pi)) for phi in angles]
        pairs = zip(ex.open_loop_poles, plants)
        return all(_off(printed, arm.poles()) <= 1e-4 for printed, arm in pairs)

    passes = labelled(-np.pi / 2, np.pi / 2), labelled(0.0, np.pi / 2)
    yield evaluate("example-4-labels", *passes)
    S11 = ex.plant.vertices[1].S[0, 0]
    missed = _off(second, _poles(ex, thesis.arm(0.64)))
    yield evaluate("example-4-S11", 50.64, S11, ours=f"{S11:.4f}", missed=missed)


def _promises(ex):
    printed_design = analyse_pid(
        ex.plant, ex.K, ex.U, region=ex.region, coupling="pairs"
    )
    own = design_pid(ex.plant, ex.U, region=ex.region)
    inside = min(
        x.min()
        for vertex in ex.plant.vertices
        for x in ex.region.distances(_poles(ex, vertex)).values()
    )
    proof = proven(printed_design, 8)
    yield evaluate("example-4-region", proof, inside=inside, proof=said(proof))
    yield evaluate("example-4-gains", ex.K, own.K, proof, proven(own, 8))


def _swing(ex):
    asked = dict(row=[1, 0, 0, 0, 0], bound=np.pi / 2, start=[1, 1, 0, 0, 0])
    region = region_of_attraction(ex.plant, ex.K, ex.U, 3.0, **asked)
    words = dict(proof=said(region.proven), reach=np.degrees(region.reach))
    return evaluate("example-4-swing", region.proven, **words)


def _tracks(ex):
    every = Polytope([thesis.arm(-1.0), thesis.arm(1.0)])
    rate = PoleRegion(sigma=2.0)  # the factor moves: one P
    slow = proven(analyse_pid(every, ex.K, ex.U, region=rate, coupling="pairs"), 8)
    t = np.linspace(0, 15, 1501)
    times = [3.0 * k for k in range(len(SET_POINTS))]
    goal = Steps(times, np.stack([SET_POINTS, SET_POINTS], axis=1))
    run = simulate_nonlinear(thesis.arm(0.0), arm_gravity, ex.K, t, ex.U, goal)
    error = np.degrees(max(np.abs(run.e[1, k + 299]) for k in range(0, 1500, 300)))
    widest = np.abs(run.z[0]).max()
    holds = error < 0.06 and widest < np.pi / 2 and slow
    words = dict(error=below(error, 0.06), proof=said(slow), widest=np.degrees(widest))
    return evaluate("example-4-tracks", holds, **words)
