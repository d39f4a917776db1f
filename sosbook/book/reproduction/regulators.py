"""Sections 2.4.5 and 4.3.1: Lemma 2.3, Theorem 2.4, Tables 4.1 and 4.2."""

from functools import cache, partial

import numpy as np
from scipy.linalg import solve_continuous_lyapunov

from ...pendulum import Mip, polytope, vertices
from ...plants.second_order import Polytope
from ...requirements.cost import QuadraticCost
from ...synthesis.lqr import design_lqr
from ...synthesis.pid import analyse_pid
from .. import thesis
from .mip import relative
from .table import Row, claim, format_gain, misprint, proven

__all__ = ["numbers", "rows"]

control_row = partial(Row, "27_pendulum_control")
lqr_row = partial(Row, "23_lqr")
LAWS = {
    "PD": ("Table 4.1", "pd", None, 4, 0),
    "PID": ("Table 4.2", "pid", [[0, 1]], 5, 3),
}  # place, field, U, states, vertex from 0


def rows():
    """What is said of the regulators, and what became of it."""
    printed, plants = thesis.mip(), polytope(Mip.printed())
    yield from numbers(printed)
    yield _values_of_R(printed)
    for law in LAWS:
        for R in (1, 2, 5):
            yield _theorem(printed, plants, law, R)
            yield _robust(printed, plants, law, R)
    yield _root(plants)
    yield _size_of_W()


def numbers(printed):
    """Rows that follow from the printed numbers, digit by digit."""
    for law, (place, name, _, _, vertex) in LAWS.items():
        for R, K in getattr(printed, name).items():
            ours = _of_one_vertex(law, R)
            verdict, gap = relative(K, ours, 6e-4)
            yield control_row(
                f"{law} gains, R = {R}",
                place,
                format_gain(K),
                format_gain(ours),
                verdict,
                f"the regulator (Q = I) of vertex {vertex + 1} alone, to {gap:.0e}",
            )


@cache
def _of_one_vertex(law, R):
    _, _, U, N, vertex = LAWS[law]
    alone = vertices(Mip.printed())[vertex].plant()
    return design_lqr(alone, np.eye(N), [[R]], U).K


def _values_of_R(printed):
    """The values of R that the gain of phi, 1 / sqrt(R), tells."""
    gains = [K[0, 1] for K in printed.pd.values()]

    def fits(values):
        return relative(gains, 1 / np.sqrt(values), 6e-4)[0] == "reproduced"

    return control_row(
        "values of R",
        "Section 4.3.1",
        "R = 2, 3 and 5",
        "R = " + ", ".join(f"{g**-2:.2f}" for g in gains),
        misprint(fits([2, 3, 5]), fits(list(printed.pd))),
        "with Q = I the gain of phi is 1 / sqrt(R), for each plant; the "
        "tables have R = 1, 2, 5",
        "values of R",
    )


def _theorem(printed, plants, law, R):
    """Theorem 2.4 as printed, and its readings that differ from the text."""
    place, name, U, N, _ = LAWS[law]
    K, forms = getattr(printed, name)[R], []
    for noise, of in (("F", _as_printed()), ("states", plants)):
        for coupling in ("vertices", "pairs"):
            asked = dict(noise=noise, coupling=coupling)
            forms.append(design_lqr(of, np.eye(N), [[R]], U, **asked).K)
    verdicts, gaps = zip(*(relative(K, ours, 6e-4) for ours in forms))
    first, *others = (100 * gap for gap in gaps)
    return control_row(
        f"{law} gains, R = {R}, by Theorem 2.4",
        place,
        format_gain(K),
        format_gain(forms[0]),
        claim(*(verdict == "reproduced" for verdict in verdicts)),
        "ours: the LMIs of the four vertices, as printed, M, D, S, B and F of "
        f"(4.25); the table is up to {first:.0f} % off. With the pairs of "
        "vertices too, or if the noise enters each state, it is up to "
        f"{min(others):.0f} to {max(others):.0f} % off",
        "Tables 4.1 and 4.2 solve Theorem 2.4",
    )


def _as_printed():
    """The vertices in the form of (4.25), with its F."""
    return Polytope([v.printed_form() for v in vertices(Mip.printed())])


def _robust(printed, plants, law, R):
    _, name, U, N, _ = LAWS[law]
    K = getattr(printed, name)[R]
    printed_design = analyse_pid(
        plants,
        K,
        U,
        coupling="slack",
        slack=0.003,
        minimize="cost",
        cost=QuadraticCost(np.eye(N), [[R]]),
        backoff=1e-3,
    )
    proof = proven(printed_design)
    ours = "no proof found"
    if proof:
        ours = (
            f"proven, cost below {printed_design.request.cost.bound:.4g}; true "
            f"worst of 54 plants {printed_design.noise_cost(samples=50):.4g}"
        )
    return control_row(
        f"{law}, R = {R}: robustly stable",
        LAWS[law][0],
        "yes",
        ours,
        claim(proof),
        "the printed digits, every plant of the polytope, exactly; "
        "noise of intensity one on each state",
    )


def _root(plants):
    robust = design_lqr(plants, np.eye(4), [[1]])
    bound, cost = robust.request.cost.bound, robust.noise_cost()
    return lqr_row(
        "the root of tr J bounds the cost",
        "Theorem 2.4",
        "sqrt(tr J)",
        f"tr J = {bound:.2f}, its root {bound**0.5:.2f}; the "
        f"true worst cost is {cost:.2f}",
        claim(cost <= bound**0.5),
        "the pendulum, Q = I, R = 1: tr J itself bounds it, as (2.30) has it",
        "the root of tr J",
    )


def _size_of_W():
    """Whether tr(W Omega' Psi Omega) <= |W| tr(Omega' Psi Omega)."""
    rng, holds = np.random.default_rng(0), {"norm": True, "determinant": True}
    for _ in range(100):
        root, A = rng.normal(size=(2, 2)), rng.normal(size=(2, 2))
        A -= (np.linalg.eigvals(A).real.max() + 1) * np.eye(2)
        W, psi = root @ root.T, solve_continuous_lyapunov(A.T, -np.eye(2))
        cost = np.trace(W @ psi)
        for name, factor in (
            ("norm", np.linalg.norm(W, 2)),
            ("determinant", np.linalg.det(W)),
        ):
            holds[name] &= bool(cost <= factor * np.trace(psi) * (1 + 1e-9))
    return lqr_row(
        "|W| tr(...) bounds the cost",
        "Lemma 2.3",
        "|W|",
        "; ".join(
            f"with the {name}: {'yes' if ok else 'no'}" for name, ok in holds.items()
        ),
        claim(*holds.values()),
        "|W| isn't defined; 100 random stable systems of order two",
        "|W| in Lemma 2.3",
    )
