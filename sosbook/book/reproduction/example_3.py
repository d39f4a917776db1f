"""Example 3, a chain whose last mass weighs nothing."""

from functools import partial

import numpy as np

from ...analysis.linear import poles
from ...plants.descriptor import descriptors
from ...plants.response import simulate
from .. import thesis
from .examples import pole_row, promises, steady_row
from .table import Row, claim

__all__ = ["numbers", "rows"]

row = partial(Row, "12_singular_chain")


def rows():
    """Rows of Example 3, computed."""
    ex = thesis.example_3()
    yield from numbers(ex)
    yield from promises(
        row,
        "Example 3",
        "Fig. 3.10",
        ex,
        gains_note="for the printed K_A; ",
        peak_note="what Lemma 2.2 bounds, ",
    )
    yield from _signals(ex)
    yield _complexity(ex)


def numbers(ex):
    """Rows that follow from the numbers that an example ``ex`` prints."""
    (d,) = descriptors(ex.plant, ex.U, ex.K_A)
    finite = ex.plant.poles()
    infinite = 2 * ex.plant.n - len(finite)
    yield row(
        "open-loop pole at infinity",
        "Table 3.2",
        "one, -inf",
        f"{infinite} at infinity",
        claim(infinite == 1),
        "det(M s^2 + D s + S) has degree 7, not 8; -inf is the limit as m4 "
        "falls to zero",
    )
    yield pole_row(
        row, "finite open-loop poles", "Table 3.2", ex.open_loop_poles, finite, 1e-4
    )
    yield pole_row(
        row,
        "closed-loop poles of the printed gains",
        "Table 3.2",
        ex.closed_loop_poles,
        poles(d, ex.K),
        5e-4,
        ": the rounding of the gains",
    )


def _complexity(ex):
    """What the integrals and K_A add to the unknowns of the design."""
    n, m, a = ex.plant.n, ex.plant.m, len(ex.U)

    def unknowns(states):
        return states * (states + 1) // 2 + m * states  # P and Y

    pd, pid = unknowns(2 * n), unknowns(2 * n + a)
    return row(
        "integral and acceleration gains make the design no harder",
        "Chapter 5",
        "no relevant drawback with respect to design complexity",
        f"{pd} unknowns for a PD, {pid} with the integrals; K_A has {m * n} "
        "more in an LMI of its own",
        claim(pid + m * n < 2 * pd),
        "threshold: less than twice the unknowns. The LMIs stay of the same kind",
    )


def _signals(ex):
    (d,) = descriptors(ex.plant, ex.U, ex.K_A)
    limit, x0 = ex.saturation.u_max, ex.saturation.x0
    t = np.concatenate([np.linspace(0, 0.2, 401), np.linspace(0.21, ex.t_end, 2980)])
    free = simulate(d, ex.K, t, x0=x0, K_A=ex.K_A)
    whole = np.linalg.norm(free.u, axis=0).max()
    yield row(
        "the control signal at most 120 from x(0)",
        "Example 3, (2.14)",
        f"<= {limit:g}",
        f"{whole:.1f}",
        claim(whole <= limit),
        "with K_A e'', which Lemma 2.2 leaves out: true, by simulation",
    )
    answer = simulate(d, ex.K, t, ex.set_point, ex.disturbance, K_A=ex.K_A)
    reference = np.concatenate([ex.set_point, np.zeros(d.E.shape[0] - 4)])
    partial = np.linalg.norm(ex.K @ (answer.x.T - reference).T, axis=0)
    norms = np.linalg.norm(answer.u, axis=0)
    over = t[norms > limit].max() if (norms > limit).any() else 0.0
    yield row(
        "u stays below u_max",
        "Fig. 3.12",
        f"<= {limit:g}",
        f"K x alone {partial.max():.1f}; with K_A e'', as (2.6) defines u, "
        f"{norms.max():.1f}, above {limit:g} until t = {over:.3f} s",
        claim(partial.max() <= limit, norms.max() <= limit),
        "from x(0) = 0 with a unit set point. Which of the two signals the "
        "figure shows, and from which x(0), isn't said; Lemma 2.2 bounds "
        "K x alone, and no set point",
        "u_max in Fig. 3.12",
    )
    last = np.abs(answer.e[:, -1]).max()
    yield steady_row(
        row,
        "Fig. 3.12",
        ex,
        last,
        "all four: r = (1, 1, 1, 1) only stretches the spring at the "
        "wall, where u1 acts",
    )
