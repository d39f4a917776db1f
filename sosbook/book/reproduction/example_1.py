"""Example 1, the grasping robot."""

from functools import partial

import numpy as np

from ...analysis.linear import poles
from ...plants.descriptor import descriptors
from ...plants.response import simulate
from ...synthesis.pid import design_pid
from .. import thesis
from .examples import pole_row, promises, steady_row
from .table import Row, claim

__all__ = ["numbers", "rows"]

row = partial(Row, "07_grasping_robot")


def rows():
    """Rows of Example 1, computed."""
    ex = thesis.example_1()
    yield from numbers(ex)
    yield from _promises(ex)


def numbers(ex):
    """Rows that follow from the numbers that an example ``ex`` prints."""
    (d,) = descriptors(ex.plant, ex.U)
    yield pole_row(
        row, "open-loop poles", "Table 3.1", ex.open_loop_poles, ex.plant.poles(), 1e-4
    )
    yield pole_row(
        row,
        "closed-loop poles of the printed gains",
        "Table 3.1",
        ex.closed_loop_poles,
        poles(d, ex.K),
        1e-4,
        ", with x3 = + integral of U e",
    )


def _promises(ex):
    (d,) = descriptors(ex.plant, ex.U)
    smallest = design_pid(
        ex.plant,
        ex.U,
        region=ex.region,
        gamma=None,
        saturation=ex.saturation,
        minimize="gamma",
        mu=1.0,
    )
    cause = (
        ": the bound is an artefact of sharing P with Lemma 2.2 "
        f"(smallest bound we reach: {smallest.gamma:g}, 1 % backed off)"
    )
    yield from promises(row, "Example 1", "Fig. 3.1", ex, digits=5, norm_note=cause)
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
    yield steady_row(row, "Fig. 3.3", ex, last, "for constant r")
