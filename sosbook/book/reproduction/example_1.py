"""Example 1, the grasping robot."""

import numpy as np

from ...analysis.linear import hinf_norm, peak_input, poles
from ...plants.descriptor import descriptors
from ...plants.response import simulate
from ...synthesis.pid import analyse_pid, design_pid
from .. import thesis
from .table import (
    Row,
    claim,
    compare,
    format_gain,
    format_poles,
    matched,
    proven,
    solution,
)

__all__ = ["numbers", "rows"]


def rows():
    """Rows of Example 1, computed."""
    ex = thesis.example_1()
    yield from numbers(ex)
    yield from _promises(ex)


def row(item, place, printed, ours, verdict, why):
    return Row("07_grasping_robot", item, place, printed, ours, verdict, why)


def numbers(ex):
    """Rows that follow from the numbers that an example ``ex`` prints."""
    (d,) = descriptors(ex.plant, ex.U)
    computed = matched(ex.open_loop_poles, ex.plant.poles())
    verdict, gap = compare(ex.open_loop_poles, computed, 1e-4)
    yield row(
        "open-loop poles",
        "Table 3.1",
        format_poles(ex.open_loop_poles),
        format_poles(computed),
        verdict,
        f"largest difference {gap:.0e} rad/s",
    )
    computed = matched(ex.closed_loop_poles, poles(d, ex.K))
    verdict, gap = compare(ex.closed_loop_poles, computed, 1e-4)
    yield row(
        "closed-loop poles of the printed gains",
        "Table 3.1",
        format_poles(ex.closed_loop_poles),
        format_poles(computed),
        verdict,
        f"largest difference {gap:.0e} rad/s, with x3 = + integral of U e",
    )


def _promises(ex):
    (d,) = descriptors(ex.plant, ex.U)
    printed_design = analyse_pid(ex.plant, ex.K, **ex.requirements)
    own = design_pid(ex.plant, **ex.requirements)
    smallest = design_pid(
        ex.plant,
        ex.U,
        region=ex.region,
        gamma=None,
        saturation=ex.saturation,
        minimize="gamma",
        mu=1.0,
    )
    inside = min(x.min() for x in ex.region.distances(poles(d, ex.K)).values())
    yield row(
        "all closed-loop poles lie in the D-region",
        "Fig. 3.1",
        "inside",
        f"{inside:.3f} rad/s from the boundary",
        claim(inside > 0),
        "for the printed gains",
    )
    proof = proven(printed_design, 7)
    yield row(
        "the printed gains satisfy (2.15), (2.18)-(2.21)",
        "Example 1",
        "designed to",
        "proven" if proof else "no proof found",
        claim(proof),
        "a common P, checked in exact rational arithmetic",
    )
    verdict, reason = solution(ex.K, own.K, 1e-4, proof, proven(own, 7))
    yield row(
        "K_P, K_D, K_I",
        "Example 1",
        format_gain(ex.K),
        format_gain(own.K),
        verdict,
        reason,
    )
    norm = hinf_norm(d, ex.K)
    yield row(
        "H-infinity norm from w to z below 1.2570",
        "Example 1",
        f"< {ex.gamma}",
        f"{norm:.5f}",
        claim(norm < ex.gamma),
        f"{ex.gamma / norm:.0f} times below the bound: the bound is an "
        "artefact of sharing P with Lemma 2.2 "
        f"(smallest bound we reach: {smallest.gamma:g}, 1 % backed off)",
    )
    peak = peak_input(d, ex.K, ex.saturation.x0)
    yield row(
        "|K x(t)| at most 150 from x(0)",
        "Example 1",
        f"<= {ex.saturation.u_max:g}",
        f"{peak:.1f}",
        claim(peak <= ex.saturation.u_max),
        "with r = 0, w = 0",
    )
    t = np.linspace(0, ex.t_end, 3001)
    answer = simulate(d, ex.K, t, r=ex.set_point, w=ex.disturbance)
    largest = np.linalg.norm(answer.u, axis=0).max()
    yield row(
        "u(t) stays below u_max in Fig. 3.3",
        "Fig. 3.3",
        f"<= {ex.saturation.u_max:g}",
        f"{largest:.1f}",
        claim(largest <= ex.saturation.u_max),
        "from x(0) = 0, w on both channels; Lemma 2.2 says nothing about "
        "set points or disturbances, so this is luck, not a guarantee",
    )
    last = np.abs(answer.e[:, -1]).max()
    yield row(
        "the error goes to zero in steady state",
        "Fig. 3.3",
        "0",
        f"{last:.0e} at t = {ex.t_end:g} s",
        claim(last < 1e-3),
        "for constant r",
    )
