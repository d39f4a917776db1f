"""Sections 2.4.6 and 4.3.2: Table 4.3 and (4.27) to (4.30)."""

from functools import cache, partial

import numpy as np

from ...pendulum import Mip, reduced
from ...plants.descriptor import mean_descriptor
from ...plants.descriptor_system import DescriptorSystem
from ...runtime.libraries import library
from ...synthesis.error_loop import observer_loop
from ...synthesis.lqr import design_lqr
from ...synthesis.observer import design_observer
from ...synthesis.pid import analyse_loop
from .. import thesis
from .mip import digits, relative
from .table import Row, below, claim, compare, format_gain, misprint, proven

control = library("control")


__all__ = ["controller", "numbers", "rows"]

control_row = partial(Row, "27_pendulum_control")
observer_row = partial(Row, "24_observer")
T = 0.01  # s


def rows():
    """What is said of the observer, and what became of it."""
    printed = thesis.mip()
    plant = reduced(Mip.printed())
    yield _observable(printed)
    yield _weights(printed)
    yield from numbers(printed)
    loops = [_robust(printed, plant, R) for R in (1, 2)]
    yield from loops
    yield _relaxed(loops)
    yield _stable(printed)


def numbers(printed):
    """Rows that follow from the printed numbers, digit by digit."""
    yield from _reduced(printed)
    for R in (1, 2):
        yield from _gains(printed, R)
    yield from _controller(printed)
    yield from _without_the_fast(printed)


def controller(R, form="natural", printed=None):
    """The controller of Table 4.3, in continuous time, for u = H y.

    Parameters
    ----------
    R : {1, 2}
    form : {"natural", "printed"}
        Whose mean the observer contains: of `sosbook.pendulum.reduced`, or of
        the matrices of (4.25), with their digits. The plants are the
        same, their means aren't.
    printed : sosbook.book.thesis.MipPrint, optional
        The thesis's data.

    Returns
    -------
    control.StateSpace
        The controller.

    Examples
    --------
    >>> np.sort(controller(2, "printed").poles().real).round(2)
    array([-1694.17,   -10.45,    -5.04])
    """
    if form not in ("natural", "printed"):
        raise ValueError(f'form must be "natural" or "printed", got {form!r}')
    printed = printed or thesis.mip()
    K, L = printed.lqe[R]
    if form == "printed":
        M = printed.M.mean(axis=0)[0, 0]  # times the identity
        A = np.vstack(
            [
                [0, 1, 0],
                np.hstack([printed.S.mean(axis=0)[:, :1], printed.D.mean(axis=0)]) / M,
            ]
        )
        B = np.vstack([[0], printed.B.mean(axis=0) / M])
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
    return observer_row(
        "not observable with phi, observable without",
        "Section 4.3.2, (4.27)",
        "yes",
        f"rank {whole} of 4, and {part} of 3",
        claim(whole < 4 and part == 3),
        "vertex 1, both rates measured",
    )


def _weights(printed):
    """Which of two printed weights fits its place in (2.45)."""
    states, outputs = 2 * len(printed.C[0]), len(printed.C)
    stacked, square = (states, 1), (outputs, outputs)  # R_F, Q_F as printed

    def fits(Q_F, R_F):
        return Q_F[0] == states and R_F[0] == outputs

    return observer_row(
        "Q_F and R_F",
        "Section 4.3.2",
        "Q_F = sqrt(diag(0.01, 0.1)), R_F = [2 E^-1 B; 0]",
        "swapped",
        misprint(fits(square, stacked), fits(stacked, square)),
        f"P Q_F of (2.45) needs {states} rows, R_F^T Y {outputs}",
        "Q_F and R_F",
    )


def _reduced(printed):
    M, D, S, B = (getattr(printed, x) for x in "MDSB")
    E = np.diag([1, *M[0].diagonal()])
    A = np.vstack([[0, 1, 0], np.hstack([S[0][:, :1], D[0]])])
    apart = max(np.abs(E - printed.E_1).max(), np.abs(A - printed.A_1).max())
    yield observer_row(
        "E_1 and A_1",
        "(4.27)",
        "numbers of (4.25), vertex 1",
        f"difference {below(apart, 1e-15)}",
        compare(apart, 0, 1e-15)[0],
        "entry by entry",
    )
    first, last = (np.allclose(printed.B_1[1:], B[k], rtol=1e-6) for k in (0, 3))
    yield observer_row(
        "B_1",
        "(4.27)",
        digits(printed.B_1),
        digits(B[0]),
        misprint(first, last),
        "beside E_1 and A_1 it should be vertex 1's; these are the digits "
        "of vertex 4's",
        "B_1 of (4.27)",
    )


@cache
def _design(R):
    plant = reduced(Mip.printed())
    first, mean = plant.vertices[0], mean_descriptor(plant.vertices)
    alone = DescriptorSystem(first.E, first.A, first.Bu)
    noise = 2 * np.linalg.solve(mean.E, mean.Bu)
    return design_observer(
        plant,
        design_lqr(alone, np.eye(3), [[R]]).K,
        np.vstack([noise, 0 * noise]),
        np.sqrt(np.diag([0.01, 0.1])),
    )


def _gains(printed, R):
    K, L = printed.lqe[R]
    observed = _design(R)
    verdict, gap = relative(K, observed.K, 2e-4)
    yield observer_row(
        f"K, R = {R}",
        "Table 4.3",
        format_gain(K),
        format_gain(observed.K),
        verdict,
        f"the regulator (Q = I) of vertex 1 alone, to {gap:.0e}",
    )
    gaps = (observed.L - L) / (1e-3 * np.abs(L) + [[0.055], [0], [0]])
    verdict, _ = compare(0, gaps, 1)
    yield observer_row(
        f"L, R = {R}",
        "Table 4.3",
        "; ".join(digits(row, ".1f") for row in L),
        "; ".join(digits(row, ".3f") for row in observed.L),
        verdict,
        "Theorem 2.5, four vertices, with Q_F and R_F swapped; to 1e-3, and "
        "in the first row to half of the last digit, 0.05",
    )


def _robust(printed, plant, R):
    K, L = printed.lqe[R]
    loop = observer_loop(plant, K, L, printed.C)
    proof = proven(analyse_loop(loop.E, loop.A, coupling="pairs"))
    return observer_row(
        f"robustly stable, R = {R}",
        "Table 4.3",
        "yes",
        ("proven" if proof else "no proof found")
        + " for the printed K and L and every plant",
        claim(proof),
        "pairs of vertices with K and L fixed; Theorem 2.5 itself speaks "
        "of the vertices only",
    )


def _relaxed(loops):
    """The main shortcoming that section 2.4 names, and its cure."""
    holds = [row.verdict == "property holds" for row in loops]
    return observer_row(
        "the assumption of full-state knowledge can be relaxed",
        "Section 2.4",
        "by using state observers",
        f"{sum(holds)} of {len(holds)} loops of Table 4.3 proven, from two "
        "measured rates of four states",
        claim(all(holds)),
        "for the pendulum. The fourth state, phi, can't be observed from "
        "rates; with encoders it is measured, and a PID with the observer "
        "is proven too (an exercise of the chapter)",
    )


def _controller(printed):
    computed = controller(2, "printed", printed)
    theirs = np.sort(printed.controller[2])
    ours = np.sort(computed.poles().real)
    verdict, gap = relative(theirs, ours, 3e-4)
    natural = controller(2, printed=printed).poles().real
    _, natural_gap = relative(theirs, np.sort(natural), 3e-4)
    yield observer_row(
        "poles",
        "(4.28), R = 2",
        digits(theirs),
        digits(ours, ".6g"),
        verdict,
        f"to {gap:.0e}, from the digits of (4.25) and of Table 4.3. With "
        f"the means of the natural form they are {100 * natural_gap:.1f} % off: "
        "a mean depends on the form. (The rounding of L alone may move the "
        "slow ones by 0.6 %)",
    )
    for k, name in enumerate(("theta'", "phi'")):
        gain, zeros = printed.controller[k]
        at = control.ss2tf(computed[0, k]).zeros()
        at = np.sort(at[np.abs(at) < 1e6].real)
        ours = [-(computed.C @ computed.B)[0, k], *at]
        verdict, gap = relative([gain, *np.sort(zeros)], ours, 6e-3)
        yield observer_row(
            f"gain and zeros from {name}",
            "(4.28), R = 2",
            digits([gain, *np.sort(zeros)], ".5g"),
            digits(ours, ".5g"),
            verdict,
            f"to {100 * gap:.1f} %: the rounding of L's first row moves the "
            "zeros by as much; for u = -H y",
        )


def _without_the_fast(printed):
    (g1, z1), (g2, (far, z2)), (fast, *slow) = printed.controller
    (h1, y1), (h2, y2), poles = printed.reduced
    theirs, kept = [*y1, *y2, *sorted(poles)], [*z1, z2, *sorted(slow)]
    yield control_row(
        "poles and zeros without the fast ones",
        "(4.29)",
        digits(theirs),
        digits(kept),
        relative(theirs, kept, 1e-9)[0],
        "those of (4.28) but for the pole at -1694 and the zero at 232.5",
    )
    ours = [g1 / -fast, g2 * far / fast]
    yield control_row(
        "gains without the fast pole and zero",
        "(4.29)",
        f"{h1:.4f}, {h2:.3f}",
        f"{ours[0]:.4f}, {ours[1]:.3f}",
        relative([h1, h2], ours, 2e-4)[0],
        "the gain at s = 0 is kept; to 2e-4, the last digits differ",
    )
    yield _compared(printed)
    verdict, gap = _discrete(printed)
    yield control_row(
        "the controller at 100 Hz",
        "(4.30)",
        "A, B, C, D with four digits",
        f"transfer functions within {gap:.0e}",
        verdict,
        "the zero-order hold of (4.29): numerators and denominators, to 2e-4",
    )


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
    return Row(
        "28_discretisation",
        "both controllers, compared",
        "Fig. 4.12",
        "Bode diagrams of (4.28) and (4.29)",
        f"gains at s = 0 equal to {gap:.0e}; up to {apart(10)} apart at "
        f"10 rad/s, {apart(np.pi / T)} at 50 Hz",
        claim(verdict == "reproduced"),
        "tested: the gain at s = 0, to 5e-4, of what (4.28) and (4.29) print. "
        "The curves themselves aren't in our text; the chapter draws them",
    )


def _discrete(printed):
    """Coefficients of (4.30) against the hold of (4.29)."""
    A, B, C, D = printed.discrete
    *channels, poles = printed.reduced
    gaps = []
    for k, (gain, zeros) in enumerate(channels):
        H = control.zpk(zeros, poles, gain)
        held = control.sample_system(H, T, "zoh")
        ours = control.ss2tf(control.ss(A, B[:, [k]], C, D[:, [k]], T))
        gaps += [
            compare(x[0][0], y[0][0], 2e-4)[1]
            for x, y in ((held.num, ours.num), (held.den, ours.den))
        ]
    return compare(max(gaps), 0, 2e-4)


def _stable(printed):
    right = max(
        controller(R, form).poles().real.max()
        for R in (1, 2)
        for form in ("natural", "printed")
    )
    return observer_row(
        "the controller itself is stable",
        "Section 4.3.2, (4.28)",
        "all poles have a negative real part",
        f"rightmost pole {right:.2f} rad/s",
        claim(right < 0 and max(printed.controller[2]) < 0),
        "both values of R; no theorem promises it",
    )
