"""Sections 2.4.5 and 4.3.1: Lemma 2.3, Theorem 2.4, Tables 4.1 and 4.2."""

from functools import cache

import numpy as np
from scipy.linalg import solve_continuous_lyapunov

from ...pendulum import Mip, polytope, vertices
from ...plants.second_order import Polytope
from ...requirements.cost import QuadraticCost
from ...synthesis.lqr import design_lqr
from ...synthesis.pid import analyse_pid
from ...synthesis.search import Search
from .. import thesis
from .table import evaluate, proven, shown

LAWS = {
    "PD": ("4.1", "pd", None, 4, 0),
    "PID": ("4.2", "pid", [[0, 1]], 5, 3),
}  # table, field, U, states, vertex from 0
DIGITS = 6e-4  # of the printed gains, which have four decimals


def rows():
    """The statements about the regulators, recomputed."""
    printed, plants = thesis.mip(), polytope(Mip.printed())
    for law, (table, name, _, _, vertex) in LAWS.items():
        for R, K in getattr(printed, name).items():
            words = dict(law=law, R=R, table=table, vertex=vertex + 1)
            yield evaluate("regulator-gains", K, _of_one_vertex(law, R), **words)
    yield _values_of_R(printed)
    for law in LAWS:
        for R in (1, 2, 5):
            yield _theorem(printed, plants, law, R)
            yield _robust(printed, plants, law, R)
    yield _root(plants)
    yield _size_of_W()


def _off(printed, ours):
    """The largest gap, relative to each printed number."""
    return np.abs(np.asarray(ours) / printed - 1).max()


@cache
def _of_one_vertex(law, R):
    _, _, U, N, vertex = LAWS[law]
    alone = vertices(Mip.printed())[vertex].plant()
    return design_lqr(alone, np.eye(N), [[R]], U).K


def _values_of_R(printed):
    """The values of R that the gain of phi, 1 / sqrt(R), tells."""
    gains = np.array([K[0, 1] for K in printed.pd.values()])
    values = [2, 3, 5], list(printed.pd)
    fits = (_off(gains, 1 / np.sqrt(R)) <= DIGITS for R in values)
    return evaluate("values-of-R", *fits, R=", ".join(f"{g**-2:.2f}" for g in gains))


def _theorem(printed, plants, law, R):
    """Theorem 2.4 as printed, and its readings that differ from the text."""
    table, name, U, N, _ = LAWS[law]
    K, forms = getattr(printed, name)[R], []
    # the vertices in the form of (4.25), with its F
    as_printed = Polytope([v.printed_form() for v in vertices(Mip.printed())])
    for noise, of in (("F", as_printed), ("states", plants)):
        for coupling in ("vertices", "pairs"):
            asked = dict(noise=noise, coupling=coupling)
            forms.append(design_lqr(of, np.eye(N), [[R]], U, **asked).K)
    first, *others = (_off(K, ours) for ours in forms)
    holds = (gap <= DIGITS for gap in (first, *others))
    words = dict(law=law, R=R, table=table, printed=shown(K), ours=shown(forms[0]))
    gaps = dict(first=100 * first, least=100 * min(others), most=100 * max(others))
    return evaluate("regulator-theorem", *holds, **words, **gaps)


def _robust(printed, plants, law, R):
    table, name, U, N, _ = LAWS[law]
    asked = dict(
        requirements=[QuadraticCost(np.eye(N), [[R]])],
        minimize="cost",
        search=Search(backoff=1e-3),
    )
    asked |= dict(coupling=("slack", 0.003))
    found = analyse_pid(plants, getattr(printed, name)[R], U, **asked)
    proof, words = proven(found), dict(law=law, R=R, table=table, bound=0, worst=0)
    if proof:
        words["bound"] = found.request.cost.bound
        words["worst"] = found.noise_cost(samples=50)
    return evaluate("regulator-robust", proof, **words)


def _root(plants):
    robust = design_lqr(plants, np.eye(4), [[1]])
    bound, cost = robust.request.cost.bound, robust.noise_cost()
    root = bound**0.5
    return evaluate("root-of-trace", cost <= root, bound=bound, root=root, cost=cost)


def _size_of_W():
    """Judge if tr(W Omega' Psi Omega) <= |W| tr(Omega' Psi Omega)."""
    rng, holds = np.random.default_rng(0), {"norm": True, "determinant": True}
    for _ in range(100):
        root, A = rng.normal(size=(2, 2)), rng.normal(size=(2, 2))
        A -= (np.linalg.eigvals(A).real.max() + 1) * np.eye(2)
        W, psi = root @ root.T, solve_continuous_lyapunov(A.T, -np.eye(2))
        cost = np.trace(W @ psi)
        sizes = dict(norm=np.linalg.norm(W, 2), determinant=np.linalg.det(W))
        for name, factor in sizes.items():
            holds[name] &= bool(cost <= factor * np.trace(psi) * (1 + 1e-9))
    words = (f"with the {name}: {'yes' if ok else 'no'}" for name, ok in holds.items())
    return evaluate("size-of-W", *holds.values(), ours="; ".join(words))
