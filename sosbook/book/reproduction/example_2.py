"""Example 2, the seat of a car."""

from functools import partial

import numpy as np

from ...analysis.linear import hinf_norm, peak_input, poles
from ...plants.descriptor import descriptors
from ...plants.response import simulate
from ...plants.second_order import Polytope
from ...synthesis.pid import analyse_pid, design_pid
from .. import thesis
from .examples import gains_row, steady_row
from .table import Row, claim, misprint, proven

__all__ = ["rows"]

row = partial(Row, "11_car_seat")


def rows():
    """Rows of Example 2, computed."""
    ex = thesis.example_2()
    masses = np.arange(70, 121)
    cars = [thesis.car_seat(m) for m in masses]
    loops = descriptors(Polytope(cars), ex.U)
    printed_design = analyse_pid(ex.plant, ex.K, coupling="pairs", **ex.requirements)
    own = design_pid(ex.plant, **ex.requirements)

    def inside(points):
        return min(x.min() for x in ex.region.distances(points).values())

    gap = inside(np.array([poles(d, ex.K) for d in loops]))
    yield row(
        "all closed-loop poles lie in the D-region, for all integer m_s",
        "Fig. 3.5",
        "inside",
        f"{gap:.3f} rad/s from the boundary",
        claim(gap > 0),
        "for the printed gains, 51 masses",
    )
    proof = proven(printed_design, 7)
    yield row(
        "the printed gains satisfy (2.15), (2.18)-(2.21)",
        "Example 2",
        "designed to, at the vertices",
        "proven for every m_s" if proof else "no proof found",
        claim(proof),
        "a common P for both vertices and the pair, in exact rational arithmetic",
    )
    readings = {"k1 + k2": 4e4 + 5e3, "k1 + b2": 4e4 + 500}
    read = {name: thesis.car_seat(100, k) for name, k in readings.items()}
    shift = {name: car.S @ [1, 1] for name, car in read.items()}
    misprinted = analyse_pid(
        Polytope([thesis.car_seat(m, 4e4 + 500) for m in (70, 120)]),
        ex.K,
        **ex.requirements,
    )
    both = proof and proven(misprinted, 7)
    yield row(
        "lower right entry of S",
        "Example 2",
        "k1 + b2",
        "k1 + k2",
        misprint(
            *(np.array_equal(shift[name], [0, 4e4]) for name in ("k1 + b2", "k1 + k2"))
        ),
        "a common displacement by 1 m must stretch k1 alone, 40000 N; as "
        f"printed it takes {shift['k1 + b2'][1]:.0f} N. The printed gains "
        "are proven with "
        + ("either reading, so poles can't decide" if both else "one reading only"),
        "S of Example 2",
    )
    yield gains_row(row, "Example 2", ex.K, own, 1, proof, 7, decimals=0)
    norm = max(hinf_norm(d, ex.K) for d in loops)
    yield row(
        "H-infinity norm from w to z below 0.1732",
        "Example 2",
        f"< {ex.gamma}",
        f"{norm:.3g} m/N",
        claim(norm < ex.gamma),
        f"{ex.gamma / norm:.0f} times below the bound, the largest of 51 masses",
    )
    peak = max(peak_input(d, ex.K, ex.saturation.x0) for d in loops)
    yield row(
        "|K x(t)| at most 40000 from x(0)",
        "Example 2",
        f"<= {ex.saturation.u_max:g}",
        f"{peak:.0f}",
        claim(peak <= ex.saturation.u_max),
        "with r = 0, w = 0, the largest of 51 masses",
    )
    t = np.linspace(0, ex.t_end, 2001)

    def answers(w):
        return [simulate(d, ex.K, t, ex.set_point, w) for d in loops[::10]]

    def largest(responses):
        return max(np.linalg.norm(a.u, axis=0).max() for a in responses)

    printed = answers(ex.disturbance)
    runs = {}
    for name, car in read.items():
        (d,) = descriptors(car, ex.U)
        runs[name] = simulate(d, ex.K, t, ex.set_point, ex.disturbance)
    peaks = {name: largest([run]) for name, run in runs.items()}
    ends = {name: abs(run.u[1, -1]) for name, run in runs.items()}
    yield row(
        "u(t) doesn't exceed u_max for m_s = 100",
        "Fig. 3.8",
        f"<= {ex.saturation.u_max:g}",
        "; ".join(f"{p:.7g} with {name}" for name, p in peaks.items()),
        claim(*(p <= ex.saturation.u_max for p in peaks.values())),
        "whichever S22 was used: the steady effort |S r| is 40000 N with "
        "k1 + k2, just the limit, and 35500 N with k1 + b2. The figure "
        "can tell: u2 ends at "
        + " or ".join(f"{end / 1000:.1f} kN ({name})" for name, end in ends.items()),
    )
    last = max(np.abs(a.e[:, -1]).max() for a in printed)
    why = "for constant r, six masses from 70 to 120 kg"
    yield steady_row(row, "Fig. 3.8", ex, last, why, " m")
    z = np.array([a.z[0] for a in printed])
    spread = np.ptp(z, axis=0).max()
    yield row(
        "m_s has a small impact on the response",
        "Fig. 3.7",
        "small",
        f"z1 differs by at most {1000 * spread:.0f} mm of a step of 1 m",
        claim(spread < 0.1),
        "threshold: a tenth of the step; six masses from 70 to 120 kg",
    )
