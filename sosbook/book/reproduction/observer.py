"""Sections 2.4.6 and 4.3.2: Table 4.3 and (4.27) to (4.30)."""

from functools import cache

import numpy as np

from ...pendulum import Mip, reduced
from ...plants.descriptor import mean_descriptor
from ...plants.descriptor_system import DescriptorSystem
from ...runtime.libraries import library
from ...synthesis.error_loop import observer_loop
from ...synthesis.lqr import design_lqr
from ...synthesis.observer import design_observer
from ...synthesis.pid import analyse_pid
from .. import thesis
from .table import below, compare, evaluate, proven, shown

control = library("control")


T = 0.01  # s


def rows():
    """The statements about the observer, recomputed."""
    printed = thesis.mip()
    plant = reduced(Mip.printed())
    yield _observable(printed)
    yield _weights(printed)
    yield from _reduced(printed)
    for R in (1, 2):
        yield from _gains(printed, R)
    yield from _controller(printed)
    yield from _without_the_fast(printed)
    loops = [_robust(printed, plant, R) for R in (1, 2)]
    yield from loops
    # the main shortcoming that section 2.4 names, and its cure
    holds = [row.verdict == "property holds" for row in loops]
    yield evaluate("observer-relaxed", all(holds), holds=sum(holds), n=len(holds))
    right = max(
        controller(R, form).poles().real.max()
        for R in (1, 2)
        for form in ("natural", "printed")
    )
    stable = right < 0 and max(printed.controller[2]) < 0
    yield evaluate("observer-stable", stable, right=right)


def controller(R, form="natural", printed=None):
    """The controller of Table 4.3 for ``R``, 1 or 2, a StateSpace for u = H y. Its
    observer contains the mean of the ``form``: "natural", of
    `sosbook.pendulum.reduced`, or "printed", of (4.25) with its digits, of ``printed``
    data, a `MipPrint`.

    >>> np.sort(controller(2, "printed").poles().real).round(2)
    array([-1694.17,   -10.45,    -5.04])
    """
    if form not in ("natural", "printed"):
        raise ValueError(f'form must be "natural" or "printed", got {form!r}')
    printed = printed or thesis.mip()
    K, L = printed.lqe[R]
    if form == "printed":
        M = printed.M.mean(axis=0)[0, 0]  # times the identity
        S, D, B = (getattr(printed, x).mean(axis=0) for x in "SDB")
        A = np.vstack([[0, 1, 0], np.hstack([S[:, :1], D]) / M])
        B = np.vstack([[0], B / M])
    else:
        A, B, _ = mean_descriptor(reduced(Mip.printed()).vertices).state_space()
    return control.ss(A + B @ K + L @ np.array(printed.C), -L, K, np.zeros((1, 2)))


def _rank(A, C):
    return np.linalg.matrix_rank(
        np.vstack([C @ np.linalg.matrix_power(A, k) for k in range(len(A))])
    )


def _observable(printed):
    """From both rates (4.27) is observable, and (4.25) isn't."""
    A = np.zeros((4, 4))
    A[:2, 2:] = np.eye(2)
    A[2:] = np.hstack([printed.S[0], printed.D[0]]) / printed.M[0, 0, 0]
    C = np.hstack([np.zeros((2, 2)), np.eye(2)])
    small = A[np.ix_([0, 2, 3], [0, 2, 3])]
    whole, part = _rank(A, C), _rank(small, printed.C)
    return evaluate("observable", whole < 4 and part == 3, whole=whole, part=part)


def _weights(printed):
    """Which of two printed weights fits its place in (2.45)."""
    states, outputs = 2 * len(printed.C[0]), len(printed.C)
    stacked, square = (states, 1), (outputs, outputs)  # R_F, Q_F as printed

    def fits(Q_F, R_F):
        return Q_F[0] == states and R_F[0] == outputs

    passes = fits(square, stacked), fits(stacked, square)
    return evaluate("observer-weights", *passes, states=states, outputs=outputs)


def _reduced(printed):
    M, D, S, B = (getattr(printed, x) for x in "MDSB")
    E = np.diag([1, *M[0].diagonal()])
    A = np.vstack([[0, 1, 0], np.hstack([S[0][:, :1], D[0]])])
    apart = max(np.abs(E - printed.E_1).max(), np.abs(A - printed.A_1).max())
    yield evaluate("observer-E_1", 0.0, apart, ours=below(apart, 1e-15))
    passes = (np.allclose(printed.B_1[1:], B[k], rtol=1e-6) for k in (0, 3))
    shows = dict(printed=shown(printed.B_1.T, ".4g"), ours=shown(B[0].T, ".4g"))
    yield evaluate("observer-B_1", *passes, **shows)


@cache
def _design(R):
    plant = reduced(Mip.printed())
    first, mean = plant.vertices[0], mean_descriptor(plant.vertices)
    alone = DescriptorSystem(first.E, first.A, first.Bu)
    noise = 2 * np.linalg.solve(mean.E, mean.Bu)
    K = design_lqr(alone, np.eye(3), [[R]]).K
    weights = np.vstack([noise, 0 * noise]), np.sqrt(np.diag([0.01, 0.1]))
    return design_observer(plant, K, *weights)


def _gains(printed, R):
    K, L = printed.lqe[R]
    observed = _design(R)
    yield evaluate("observer-K", K, observed.K, R=R)
    # to 1e-3, and in the first row to half of the last digit, 0.05
    gaps = (observed.L - L) / (1e-3 * np.abs(L) + [[0.055], [0], [0]])
    shows = dict(printed=shown(L, ".1f"), ours=shown(observed.L, ".3f"))
    yield evaluate("observer-L", 0.0, gaps, R=R, **shows)


def _robust(printed, plant, R):
    K, L = printed.lqe[R]
    loop = observer_loop(plant, K, L, printed.C)
    proof = proven(analyse_pid(loop, coupling="pairs"))
    return evaluate("observer-robust", proof, R=R)


def _controller(printed):
    computed = controller(2, "printed", printed)
    theirs = np.sort(printed.controller[2])
    ours = np.sort(computed.poles().real)
    natural = np.sort(controller(2, printed=printed).poles().real)
    off = 100 * np.abs(natural / theirs - 1).max()
    yield evaluate("observer-poles", theirs, ours, ours=shown(ours, ".6g"), natural=off)
    for k, name in enumerate(("theta'", "phi'")):
        gain, zeros = printed.controller[k]
        at = control.ss2tf(computed[0, k]).zeros()
        at = np.sort(at[np.abs(at) < 1e6].real)
        ours = [-(computed.C @ computed.B)[0, k], *at]
        yield evaluate("observer-zeros", [gain, *np.sort(zeros)], ours, rate=name)


def _without_the_fast(printed):
    (g1, z1), (g2, (far, z2)), (fast, *slow) = printed.controller
    (h1, y1), (h2, y2), poles = printed.reduced
    theirs, kept = [*y1, *y2, *sorted(poles)], [*z1, z2, *sorted(slow)]
    yield evaluate("reduced-poles", theirs, kept)
    ours = [g1 / -fast, g2 * far / fast]
    words = (f"{a:.4f}, {b:.3f}" for a, b in ((h1, h2), ours))
    yield evaluate(
        "reduced-gains", [h1, h2], ours, printed=next(words), ours=next(words)
    )
    yield _compared(printed)
    gap = _discrete(printed)
    yield evaluate("discrete-controller", 0.0, gap)


def _compared(printed):
    """The Bode diagrams of (4.28) and (4.29)."""

    def ratios(s):
        """(4.29) over (4.28), from either rate."""
        quotients = []
        for full, less in zip(printed.controller[:2], printed.reduced[:2]):
            values = [
                gain * np.prod(s - np.array(zeros)) / np.prod(s - np.array(poles))
                for (gain, zeros), poles in (
                    (full, printed.controller[2]),
                    (less, printed.reduced[2]),
                )
            ]
            quotients.append(values[1] / values[0])
        return np.array(quotients)

    def apart(w):
        H = ratios(1j * w)
        dB, degrees = 20 * np.log10(abs(H)), np.degrees(np.angle(H))
        return f"{abs(dB).max():.2g} dB and {abs(degrees).max():.2g} degrees"

    verdict, gap = compare(np.ones(2), ratios(0).real, 5e-4)
    words = dict(gap=gap, slow=apart(10), fast=apart(np.pi / T))
    return evaluate("reduced-bode", verdict == "reproduced", **words)


def _discrete(printed):
    """The largest gap between coefficients of (4.30) and of the hold of (4.29)."""
    A, B, C, D = printed.discrete
    *channels, poles = printed.reduced
    gaps = []
    for k, (gain, zeros) in enumerate(channels):
        H = control.zpk(zeros, poles, gain)
        held = control.sample_system(H, T, "zoh")
        ours = control.ss2tf(control.ss(A, B[:, [k]], C, D[:, [k]], T))
        gaps += [
            np.abs(np.subtract(x[0][0], y[0][0])).max()
            for x, y in ((held.num, ours.num), (held.den, ours.den))
        ]
    return max(gaps)
