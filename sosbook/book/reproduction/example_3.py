"""Example 3, a chain whose last mass weighs nothing."""

import numpy as np

from ...analysis.linear import poles
from ...plants.descriptor import descriptors
from ...plants.response import simulate
from .. import thesis
from .examples import promises
from .table import evaluate


def rows():
    """Rows of Example 3, computed."""
    ex = thesis.example_3()
    (d,) = descriptors(ex.plant, ex.U, ex.K_A)
    finite = ex.plant.poles()
    infinite = 2 * ex.plant.n - len(finite)
    yield evaluate("example-3-infinity", infinite == 1, infinite=infinite)
    yield evaluate("example-3-open", ex.open_loop_poles, finite)
    yield evaluate("example-3-poles", ex.closed_loop_poles, poles(d, ex.K))
    yield from promises(3, ex)
    yield from _signals(ex, d)
    yield _complexity(ex)


def _complexity(ex):
    """What the integrals and K_A add to the unknowns of the design."""
    n, m, a = ex.plant.n, ex.plant.m, len(ex.U)

    def unknowns(states):
        return states * (states + 1) // 2 + m * states  # P and Y

    pd, pid = unknowns(2 * n), unknowns(2 * n + a)
    holds = pid + m * n < 2 * pd
    return evaluate("design-complexity", holds, pd=pd, pid=pid, more=m * n)


def _signals(ex, d):
    limit, x0 = ex.saturation.u_max, ex.saturation.x0
    t = np.concatenate([np.linspace(0, 0.2, 401), np.linspace(0.21, ex.t_end, 2980)])
    free = simulate(d, ex.K, t, x0=x0, K_A=ex.K_A)
    whole = np.linalg.norm(free.u, axis=0).max()
    yield evaluate("example-3-whole-peak", whole <= limit, limit=limit, peak=whole)
    answer = simulate(d, ex.K, t, ex.set_point, ex.disturbance, K_A=ex.K_A)
    reference = np.concatenate([ex.set_point, np.zeros(d.E.shape[0] - 4)])
    alone = np.linalg.norm(ex.K @ (answer.x.T - reference).T, axis=0).max()
    norms = np.linalg.norm(answer.u, axis=0)
    yield evaluate(
        "example-3-input",
        alone <= limit,
        norms.max() <= limit,
        limit=limit,
        alone=alone,
        whole=norms.max(),
        over=t[norms > limit].max() if (norms > limit).any() else 0.0,
    )
    last = np.abs(answer.e[:, -1]).max()
    yield evaluate("example-3-error", last < 1e-3, error=last, end=ex.t_end)
