"""Example 1, the grasping robot."""

import numpy as np

from ...analysis.linear import poles
from ...plants.descriptor import descriptors
from ...plants.response import simulate
from ...synthesis.pid import design_pid
from .. import thesis
from .examples import promises
from .table import evaluate


def rows():
    """Rows of Example 1, computed."""
    ex = thesis.example_1()
    (d,) = descriptors(ex.plant, ex.U)
    yield evaluate("example-1-open", ex.open_loop_poles, ex.plant.poles())
    yield evaluate("example-1-poles", ex.closed_loop_poles, poles(d, ex.K))
    smallest = design_pid(
        ex.plant,
        ex.U,
        region=ex.region,
        gamma=None,
        saturation=ex.saturation,
        minimize="gamma",
        mu=1.0,
    )
    yield from promises(1, ex, digits=5, note=f"{smallest.gamma:g}")
    t = np.linspace(0, ex.t_end, 3001)
    answer = simulate(d, ex.K, t, r=ex.set_point, w=ex.disturbance)
    limit, largest = ex.saturation.u_max, np.linalg.norm(answer.u, axis=0).max()
    yield evaluate("example-1-input", largest <= limit, limit=limit, u=largest)
    last = np.abs(answer.e[:, -1]).max()
    yield evaluate("example-1-error", last < 1e-3, error=last, end=ex.t_end)
