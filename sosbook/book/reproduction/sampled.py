"""Section 4.3 at 100 Hz: what a computer makes of the printed laws."""

import numpy as np

from ...pendulum import Mip, SampledLaw, SampledLoop, vertices
from ...runtime.libraries import library
from .. import thesis
from .observer import controller
from .table import below, evaluate

control = library("control")


T = 0.01
WAYS = (
    ("exact rates, at once", SampledLaw.of_gain, 0, "exact"),
    ("exact rates, one tick late", SampledLaw.of_gain, 1, "exact"),
    ("wheels by differences, at once", SampledLaw.of_gain, 0, "firmware"),
    ("wheels by differences, late", SampledLaw.of_gain, 1, "firmware"),
    ("(4.26), wheels by differences", SampledLaw.appendix_b, 0, "firmware"),
    ("(4.26), the same, one tick late", SampledLaw.appendix_b, 1, "firmware"),
)  # words, law of a gain, ticks of delay, sensing


def rows():
    """Which of the printed controllers a 100 Hz computer can run."""
    printed, robot = thesis.mip(), Mip.printed()
    robots = (robot, *vertices(robot))

    def worst(law, ticks, sensing):
        return max(SampledLoop(r, law, ticks * T, sensing).radius for r in robots)

    tables = printed.gains.items()
    gains = {f"{law} R = {R}": K for law, table in tables for R, K in table.items()}
    rates = np.random.default_rng(0).normal(size=(50, 2))
    gap = max(_gap(gain, rates) for gain in gains.values())
    yield evaluate("sampled-program", gap < 1e-9, gap=below(gap, 1e-9))
    lost = {
        way: [x for x, K in gains.items() if worst(law_of(K, T), ticks, sensing) >= 1]
        for way, law_of, ticks, sensing in WAYS
    }
    ours = "; ".join(f"{way}: {', '.join(x) or 'none'}" for way, x in lost.items())
    yield evaluate("sampled-gains", *(not x for x in lost.values()), lost=ours)
    A, B, C, D = printed.discrete
    law = SampledLaw.of_controller(control.ss(A, -B, C, -D, T), T)
    radii = [worst(law, n, s) for n in (0, 1) for s in ("exact", "firmware")]
    yield evaluate("sampled-observer", max(radii) < 1, radius=max(radii))
    yield _random(printed)


def _gap(gain, rates):
    """The difference between (4.26), mended, and a PID of Euler sums."""
    law, z, s = SampledLaw.appendix_b(gain, T), np.array([0.1, 0.0]), 0.0
    K = gain.K
    x, gap = law.start * z[0], 0.0
    for e in rates:
        y = np.array([0, 0, *e])
        V = K[0, :2] @ z + K[0, 2:4] @ e + (K[0, 4] * s if K.size > 4 else 0)
        gap = max(gap, abs((law.C @ x + law.D @ y)[0] - V))
        x, s, z = law.A @ x + law.B @ y, s + T * z[1], z + T * e
    return gap


def _random(printed):
    """Judge if a fast pole makes the sampled controller random."""
    held = control.sample_system(controller(2, "printed"), T, "zoh")
    (_, (far, _)), (fast, *_) = printed.controller[1:]
    w = 1j * np.pi / T  # half of the sampling rate
    lag = -np.degrees(np.angle((1 - w / far) / (1 - w / fast)))
    ours = np.exp(T * controller(2, "printed").poles().real)
    gap = np.abs(np.sort(held.poles().real) - np.sort(ours)).max()
    words = dict(gap=below(gap, 1e-6), fast=fast, hold=np.exp(fast * T))
    return evaluate("sampled-random", gap > 1e-6, lag > 0, **words, far=far, lag=lag)
