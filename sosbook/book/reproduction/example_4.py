"""Example 4, the flexible rotor with an arm."""

from functools import partial

import numpy as np

from ...analysis.linear import poles
from ...analysis.nonlinear import arm_gravity, simulate_nonlinear
from ...plants.descriptor import descriptors
from ...plants.second_order import Polytope
from ...plants.signals import Steps
from ...requirements.pole_region import PoleRegion
from ...studies.region_of_attraction import region_of_attraction
from ...synthesis.pid import analyse_pid, design_pid
from .. import thesis
from .examples import gains_row, pole_row
from .table import Row, below, claim, compare, format_poles, matched, misprint, proven

__all__ = ["numbers", "rows"]

row = partial(Row, "13_flexible_arm")
SET_POINTS = np.radians([30, 60, 10, -30, 0])  # rad, three seconds each


def rows():
    """Rows of Example 4, computed."""
    ex = thesis.example_4()
    yield from numbers(ex)
    yield from _promises(ex)
    yield from _motions(ex)


def _poles(ex, plant, U=None):
    (d,) = descriptors(plant, ex.U if U is None else U)
    return poles(d, ex.K)


def numbers(ex):
    """Rows that follow from the numbers that an example ``ex`` prints."""
    other_U = matched(
        ex.closed_loop_poles[0], _poles(ex, ex.plant.vertices[0], [[1, 0]])
    )
    wrong = np.abs(ex.closed_loop_poles[0] - other_U).max()
    names = ("0", "± pi/2")
    for name, vertex, printed in zip(names, ex.plant.vertices, ex.open_loop_poles):
        computed = matched(printed, vertex.poles())
        verdict, gap = compare(printed, computed, 1e-4)
        yield row(
            f"open-loop poles for phi1 = {name}",
            "Table 3.3",
            format_poles(printed),
            format_poles(1j * computed.imag),
            verdict,
            f"largest difference {gap:.0e} rad/s",
        )
    for name, vertex, printed in zip(names, ex.plant.vertices, ex.closed_loop_poles):
        yield pole_row(
            row,
            f"closed-loop poles for phi1 = {name}",
            "Table 3.3",
            printed,
            _poles(ex, vertex),
            1e-3,
            ", with U = [0 1], the motor's angle. U isn't printed; [1 0] misses "
            f"the first row by {wrong:.1f} rad/s",
        )
    (first, second) = ex.open_loop_poles
    as_labelled = [
        thesis.arm(np.sinc(phi / np.pi)).poles() for phi in (-np.pi / 2, np.pi / 2)
    ]
    as_meant = [thesis.arm(np.sinc(phi / np.pi)).poles() for phi in (0.0, np.pi / 2)]
    yield row(
        "labels of the rows",
        "Table 3.3",
        "-pi/2 and pi/2",
        "0 and ± pi/2",
        misprint(
            *(
                all(
                    compare(p, matched(p, q), 1e-4)[0] == "reproduced"
                    for p, q in zip((first, second), pair)
                )
                for pair in (as_labelled, as_meant)
            )
        ),
        "sinc is even: -pi/2 and pi/2 are one and the same vertex; the "
        "first row has the poles of sinc = 1",
        "labels of Table 3.3",
    )
    S11 = ex.plant.vertices[1].S[0, 0]
    rounded = matched(ex.closed_loop_poles[1], _poles(ex, thesis.arm(0.64)))
    missed = np.abs(ex.closed_loop_poles[1] - rounded).max()
    yield row(
        "upper left entry of S2",
        "Example 4",
        "50.64",
        f"{S11:.4f}",
        compare(50.64, S11, 0.005)[0],
        "a correct rounding; Table 3.3 was computed with 50 + 2/pi (with "
        f"50.64 its poles are missed by {missed:.2f} rad/s)",
    )


def _promises(ex):
    one_P = {"coupling": "pairs"}
    printed_design = analyse_pid(ex.plant, ex.K, ex.U, region=ex.region, **one_P)
    own = design_pid(ex.plant, ex.U, region=ex.region)

    inside = min(
        x.min()
        for vertex in ex.plant.vertices
        for x in ex.region.distances(_poles(ex, vertex)).values()
    )
    proof = proven(printed_design, 8)
    yield row(
        "all closed-loop poles lie in the D-region",
        "Fig. 3.14",
        "inside, at the vertices",
        f"{inside:.2f} rad/s from the "
        "boundary at the vertices; for every factor between "
        + ("proven" if proof else "not proven"),
        claim(proof),
        "a common P in exact arithmetic",
    )
    yield gains_row(row, "Example 4", ex.K, own, 1e-4, proof, 8)


def _motions(ex):
    region = region_of_attraction(
        ex.plant,
        ex.K,
        ex.U,
        3.0,
        row=[1, 0, 0, 0, 0],
        bound=np.pi / 2,
        start=[1, 1, 0, 0, 0],
    )
    yield row(
        "the swing stays in [-pi/2, pi/2]",
        "Example 4",
        "assumed",
        f"{'proven' if region.proven else 'not proven'} for a release from up "
        f"to {np.degrees(region.reach):.0f} degrees, with decay rate 3",
        claim(region.proven),
        "a condition on the start, not on the plant: the ellipsoid of "
        "one P, see the chapter",
    )
    every = Polytope([thesis.arm(-1.0), thesis.arm(1.0)])
    rate = PoleRegion(sigma=2.0)  # the factor moves: one P
    slow = proven(analyse_pid(every, ex.K, ex.U, region=rate, coupling="pairs"), 8)
    t = np.linspace(0, 15, 1501)
    times = [3.0 * k for k in range(len(SET_POINTS))]
    run = simulate_nonlinear(
        thesis.arm(0.0),
        arm_gravity,
        ex.K,
        t,
        ex.U,
        Steps(times, np.stack([SET_POINTS, SET_POINTS], axis=1)),
    )
    ends = [np.abs(run.e[1, k + 299]) for k in range(0, 1500, 300)]
    widest = np.abs(run.z[0]).max()
    yield row(
        "the reference is tracked as expected, far from rest",
        "Figs 3.15, 3.16",
        "expected response",
        f"e_a = phi2 - r2 {below(np.degrees(max(ends)), 0.06)} degrees three "
        "seconds after each step; for all set points and starts, rate 2 "
        + ("proven" if slow else "not proven"),
        claim(np.degrees(max(ends)) < 0.06 and widest < np.pi / 2 and slow),
        "the nonlinear arm, set points of 30, 60, 10, -30 and 0 degrees, "
        f"which swing it to {np.degrees(widest):.0f}; the proof takes "
        "factors in [-1, 1], not the example's polytope. phi1, which isn't "
        "integrated, keeps (m g l / k) sin(phi1)",
    )
