"""An observer that serves every plant: searched here, proven elsewhere."""

from dataclasses import dataclass

import numpy as np

from .loop import Loop
from .memory import assembled, kalman, observed

#: How much more the process is doubted than the sensors, in the order of trial.
DOUBTS = tuple(10.0**k for k in np.arange(-2, 7, 0.5))


@dataclass(frozen=True, eq=False)
class Chosen:
    """An observer, and the worst that its loops do.

    ``M``, (N, q): its gain; ``weights``, (vertices,): of the plant that it knows;
    ``peak``: the largest sensitivity at the plant's input; ``radius``: the largest
    spectral radius; ``noise``: the largest rms of u under the sensors' steps.
    """

    M: np.ndarray
    weights: np.ndarray
    peak: float
    radius: float
    noise: float


def chosen_observer(plants, known, timing, rows, steps, names, gains, most, slowest):
    """The quietest Kalman filter whose loops keep their sensitivity low, and decay.

    ``plants``: all loops are looked at; ``known``, (weights, Descriptor): plants that
    the observer may know; ``timing``: when it samples and acts; ``rows``, (q, N): what
    is measured; ``steps``, (q,): how fine it is measured; ``names``: of the plant's
    state; ``gains``: K_x, K_I, what is integrated, T and K_r of `assembled`; ``most``:
    the sensitivity may have this peak. If none keeps it, the one with the lowest peak
    is taken; ``slowest``: and the loops this radius. Returns (Estimate, Chosen) or
    None: none where no candidate keeps all loops stable.
    """
    found = []
    for doubt in DOUBTS:
        for weights, d in known:
            try:
                M = kalman(d, float(timing.T), rows, steps, doubt * steps.max())
            except (np.linalg.LinAlgError, ValueError):
                continue
            estimate = observed(d, timing, rows, M, names)
            parts, _ = assembled(estimate, timing, *gains)
            loops = [Loop.of(parts, rows, timing, one) for one in plants]
            radius = max(loop.radius for loop in loops)
            if not radius < 1:
                continue
            peak = max(loop.sensitivity_peak for loop in loops)
            noise = max(loop.noise_rms(steps).max() for loop in loops)
            found.append((estimate, Chosen(M, weights, peak, radius, noise)))
        if any(c.peak <= most and c.radius <= slowest for _, c in found):
            break  # those that follow are louder
    if not found:
        return None
    good = [x for x in found if x[1].peak <= most and x[1].radius <= slowest]
    if good:
        return min(good, key=lambda pair: pair[1].noise)
    return min(found, key=lambda pair: pair[1].peak)
