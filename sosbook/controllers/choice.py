"""An observer that serves every plant: searched here, proven elsewhere."""

from dataclasses import dataclass

import numpy as np

from .loop import Loop
from .memory import assembled, kalman, observed

#: How much more the process is doubted than the sensors, in the order of trial.
DOUBTS = tuple(10.0**k for k in np.arange(-2, 7, 0.5))


@dataclass(frozen=True, eq=False)
class Chosen:
    """An observer's gain ``M``, the ``weights`` of the plant that it knows, and the
    worst of its loops: the ``peak`` sensitivity at the plant's input, the largest
    spectral ``radius``, and the largest rms of u under the sensors' steps, ``noise``.
    """

    M: np.ndarray
    weights: np.ndarray
    peak: float
    radius: float
    noise: float


def chosen_observer(plants, known, timing, rows, steps, names, gains, most, slowest):
    """The quietest Kalman filter whose loops, with all ``plants``, keep their peak
    sensitivity below ``most`` and their radius below ``slowest``; else that of the
    lowest peak.

    ``known``, (weights, Descriptor): plants that it may know; ``timing``; ``rows``, (q,
    N) and ``steps``, (q,): what is measured, how fine; ``names`` of the plant's state;
    ``gains``: K_x, K_I, what is integrated, T and K_r of `assembled`. Returns
    (Estimate, Chosen), or None where no candidate keeps all loops stable.
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
