"""Remarks of sections 2.2 and 2.4 and appendix A that the thesis doesn't show."""

import numpy as np

from ...analysis.margins import disk_margin
from ...delay import delayed_loop, stable_delays
from ...plants.descriptor import descriptors
from .. import thesis
from .table import evaluate

SAMPLING = 0.1  # s, of the two masses; less than a quarter of their fastest period


def rows():
    """The remarks, computed."""
    examples = thesis.example_1(), thesis.example_2()
    loops = [(d, x.K) for x in examples for d in descriptors(x.plant, x.U)]
    radius = min(disk_margin(d, K).radius for d, K in loops)
    delay = min(stable_delays(*delayed_loop(d, K), 1.0)[0][1] for d, K in loops)
    yield evaluate("afterwards", radius > 0 < delay, radius=radius, ms=1000 * delay)
    yield _inclusion(thesis.delay_example_2().plant)
    yield _estimated(examples[0])
    yield _structured()


def _inclusion(plant):
    """A varying delay as a polytope: each mode's share in the last input.

    The share of the last input u(k - 1) in a step is the integral of e^(l s) from
    h - d to h for a mode l. Its real and imaginary parts grow with d, for s times
    the imaginary part of l stays below pi/2: so the delays 0 and h bound them.
    """
    (d,) = descriptors(plant)
    modes = np.linalg.eigvals(np.linalg.solve(d.E, d.A))
    modes, h = modes[modes.imag > 0], SAMPLING
    delays = np.linspace(0, h, 1001)[:, None]
    share = (np.exp(modes * h) - np.exp(modes * (h - delays))) / modes
    parts = np.hstack([share.real, share.imag])
    grows = (modes.imag * h < np.pi / 2).all() and (np.diff(parts, axis=0) > 0).all()
    return evaluate("inclusion", grows, vertices=2 ** parts.shape[1], h=h)


def _estimated(ex):
    """z' by a filter s / (1 + T s) of z: how slow it may be."""
    (d,) = descriptors(ex.plant, ex.U)
    n, I = ex.plant.n, np.eye(ex.plant.n)

    def rate(T):
        A, B = np.linalg.solve(d.E, d.A), np.linalg.solve(d.E, d.Bu)
        K = np.hstack([ex.K_P + ex.K_D / T, 0 * ex.K_D, ex.K_I])
        late = np.hstack([I / T, np.zeros((n, len(A) - n)), -I / T])
        loop = np.vstack([np.hstack([A + B @ K, -B @ ex.K_D / T]), late])
        return -np.linalg.eigvals(loop).real.max()

    lags = np.geomspace(1e-3, 1, 61)  # s
    kept = [rate(T) >= ex.region.sigma for T in lags]
    ms = 1000 * lags[: [*kept, False].index(False)].max(initial=0)
    return evaluate("estimated", kept[0], rate=ex.region.sigma, ms=ms)


def _structured():
    """The unknowns that the structure of (A.17) saves."""

    def free(n):
        return n * (n + 1) // 2  # of a symmetric matrix

    sizes = (2, 6, 100, 1000)
    ratios = [free(2 * n) / free(n) for n in sizes]
    words = ", ".join(f"{ratio:.2f} for n = {n}" for n, ratio in zip(sizes, ratios))
    return evaluate("diag-variables", abs(ratios[-1] - 4) < 0.01, ours=words)
