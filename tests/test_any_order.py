"""What multipliers exclude for every controller: against Riccati equations."""

from fractions import Fraction

import numpy as np
import pytest
from scipy.linalg import solve_continuous_are

import sosbook as sos
from sosbook.exact.rational import exact
from sosbook.synthesis.structured.any_order import (
    AnyOrder,
    best_excluded,
    unseen_motions,
)

from .test_structured_search import best_of_any_order


def plant(seed, time=1.0):
    """A plant of three states, one input, a force and noise; time in other units."""
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(3, 3)) / time
    B, b = (rng.normal(size=(3, 1)) / time for _ in range(2))
    c = rng.normal(size=(1, 3))
    parts = (A, B, np.hstack([b, 0 * b]), np.vstack([c, 0 * c]))
    A, B, Bw, C = (x.round(6) for x in parts)
    C_y = rng.normal(size=(1, 3)).round(2)
    return sos.DescriptorSystem(np.eye(3), A, B, Bw, C, [[0], [0.3]]), C_y


def bound(known, law, reached):
    """The largest norm that is excluded below ``reached``, and its refusal."""
    zero = np.zeros(law.structure(known).shape)
    request = sos.analyse_pid(known, zero, law=law, gamma=1.0).request
    return best_excluded(request, request.owner("gamma"), reached)


@pytest.mark.parametrize("time", [1.0, 0.3e-3, 9.81])
@pytest.mark.parametrize("seed", range(4))
def test_with_noise_and_weight_the_best_of_all_is_met(seed, time):
    """Unstable ones among them, by the two Riccati equations."""
    known, C_y = plant(seed, time)
    (d,) = known.vertices
    best = best_of_any_order(d, C_y, 0.3, 0.5)
    law = sos.DynamicLaw(1, C_y, noise=[[0, 0.5]])
    gamma, proof = bound(known, law, 1.5 * best)
    assert 0.98 * best < gamma < best and proof.verify()


@pytest.mark.parametrize("seed", [0, 1, 2, 3, 4, 8])
def test_without_noise_no_more_is_excluded_than_little_noise_allows(seed):
    """Noise can only make the norm larger: less and less of it comes down to it.

    Where both inequalities matter and motions that aren't seen partly decay (2 and 8)
    the multipliers aren't rational, and what is excluded is far below.
    """
    known, C_y = plant(seed)
    little = best_of_any_order(known.vertices[0], C_y, 0.3, 1e-3)
    gamma, proof = bound(known, sos.DynamicLaw(1, C_y), 1.5 * little)
    near = 0.2 if seed in (2, 8) else 0.98
    assert near * little < gamma < little and proof.verify()


def central(d, C_y, noise, gamma):
    """The controller of the two Riccati equations (DGKF 1989), as (A, B, C)."""
    ones, no = np.eye(len(d.A)), np.zeros((1, len(d.A)))

    def solved(A, B, small, C):
        """A'X + XA + X(B1 B1' / gamma^2 - B2 B2' / small^2)X + C'C = 0."""
        R = np.diag(np.repeat([-(gamma**2), small**2], [B[0].shape[1], B[1].shape[1]]))
        return solve_continuous_are(A, np.hstack(B), C.T @ C, R)

    X = solved(d.A, (d.Bw, d.Bu), 0.3, np.vstack([d.C, no]))
    Y = solved(d.A.T, (d.C.T, C_y.T), noise, np.vstack([d.Bw.T, no]))
    F, L = -d.Bu.T @ X / 0.3**2, -Y @ C_y.T / noise**2
    Z = np.linalg.inv(ones - Y @ X / gamma**2)
    A = d.A + d.Bw @ d.Bw.T @ X / gamma**2 + d.Bu @ F + Z @ L @ C_y
    return A, -Z @ L, F


def strange(kind, seed):
    """A plant of some kind, seen by one sensor without noise."""
    rng = np.random.default_rng(seed)
    A, (B, b) = rng.normal(size=(3, 3)).round(4), rng.normal(size=(2, 3, 1)).round(4)
    c, C_y = rng.normal(size=(2, 1, 3)).round(2)
    if kind == "undamped":
        A = A - A.T
    if kind == "a mode alone":
        A[0] = [-0.3, 0, 0]
    B, Bw, C = (
        b if kind == "matched" else B,
        np.hstack([b, 0 * b]),
        np.vstack([c, 0 * c]),
    )
    return sos.DescriptorSystem(np.eye(3), A, B, Bw, C, [[0], [0.3]]), C_y


@pytest.mark.parametrize("kind", ["any", "undamped", "a mode alone", "matched"])
def test_no_controller_that_is_built_does_what_is_excluded(kind):
    """Its norm without noise is read from its response; Riccati only builds it.

    Rational multipliers aren't found for each of the plants.
    """
    found, s = 0, 1j * np.append(np.geomspace(1e-3, 1e3, 6000), 0)[:, None, None]
    for seed in range(8):
        known, C_y = strange(kind, seed)
        (d,) = known.vertices
        best, norms = best_of_any_order(d, C_y, 0.3, 1e-2), []
        if np.isinf(best):  # more than ten: the search by Riccati ends there
            continue
        for gamma in best * np.array([1.01, 1.1, 1.5]):
            try:
                F, L, K = central(d, C_y, 1e-2, gamma)
            except np.linalg.LinAlgError:  # too close to the best, on some processors
                continue
            whole = np.block([[d.A, d.Bu @ K], [L @ C_y, F]])
            if np.linalg.eigvals(whole).real.max() < 0:
                out = np.block([[d.C[:1], 0 * K], [0 * K, 0.3 * K]])
                force = np.vstack([d.Bw[:, :1], 0 * L])
                answers = out @ np.linalg.solve(s * np.eye(6) - whole, force[None])
                norms.append(np.linalg.norm(answers, axis=1).max())
        gamma, proof = bound(known, sos.DynamicLaw(1, C_y), 2 * best)
        if proof is not None and norms:
            assert proof.verify() and gamma < min(norms), seed
            found += 1
    assert found >= 2


@pytest.mark.parametrize("kind", ["nothing moves", "twice the same", "another rate"])
def test_a_file_whose_motions_are_none_proves_nothing(kind):
    """A push of zero would exclude every controller, of every plant."""
    known, C_y = plant(0)
    _, proof = bound(known, sos.DynamicLaw(1, C_y, noise=[[0, 0.5]]), 10.0)
    data = proof.data
    motions = dict(data["sides"]["Y"])
    if kind == "twice the same":
        motions["V"] = [[*row, row[0]] for row in motions["V"]]
        for name in ("here", "rate"):
            motions[name] = [*motions[name], ["0"] * len(motions["push"][0])]
    elif kind == "another rate":
        (first, *row), *rows = motions["rate"]
        motions["rate"] = [[str(Fraction(first) + 1), *row], *rows]
    else:
        motions = dict(V=[[]] * 3, here=[], rate=[], push=[["0"], ["0"]])
    size = len(motions["push"][0]) + len(known.vertices[0].C)
    Z = [["1" if i == j == 0 else "0" for j in range(size)] for i in range(size)]
    sides = {"Y": motions}
    false = AnyOrder.of(data | {"sides": sides, "multipliers": [["not seen", Z]]})
    said = {"nothing moves": "different", "twice the same": "independent",
            "another rate": "rate"}[kind]  # fmt: skip
    assert not false.proven and said in str(false)
    assert proof.proven and "of any order with these sensors" in proof.claims[0]


def test_free_masses_have_a_bound():
    """Undamped, so multipliers of both sides together aren't rational."""
    A = np.array([[0, 1, 0, 0], [-1, 0, 1, 0], [0, 0, 0, 1], [1, 0, -1, 0]])
    one = np.eye(4)
    C, D = np.vstack([one, np.zeros((1, 4))]), [[0], [0], [0], [0], [1]]
    known = sos.DescriptorSystem(one, A, one[:, 1:2], one[:, 3:], C, D)
    gamma, proof = bound(known, sos.DynamicLaw(1, one[2:3], noise=[[1]]), 5.0)
    assert 2.1 < gamma < 5**0.5 and proof.verify()  # a law of order 4 has 2.281


def test_motions_that_sensors_do_not_see_are_the_largest_subspace():
    """A chain of springs, pushed at its end and seen at its start: nothing hides.

    Seen at the end that is pushed the other masses move as if it stood still.
    """
    S = 2 * np.eye(3) - np.eye(3, k=1) - np.eye(3, k=-1)
    A = exact(np.block([[np.zeros((3, 3)), np.eye(3)], [-S, -0.1 * np.eye(3)]]))
    B = exact(np.eye(6)[:, 5:])
    none = exact(np.zeros((1, 1)))
    far, near = (exact(np.eye(6)[k : k + 1]) for k in (0, 2))
    V, here, rate, push = unseen_motions(A, B, far, none)
    assert V.shape == (6, 0) and push.shape == (1, 0)
    V, here, rate, push = unseen_motions(A, B, near, none)
    assert V.shape == (6, 4) and here.shape == rate.shape == (4, 4)
    assert (near @ V == 0).all() and (A @ V @ here + B @ push == V @ rate).all()
    free = np.linalg.eigvals(rate.astype(float) @ np.linalg.inv(here.astype(float)))
    two = np.block([[np.zeros((2, 2)), np.eye(2)], [-S[:2, :2], -0.1 * np.eye(2)]])
    assert np.allclose(np.poly(free), np.poly(two))


def test_what_is_sought_has_no_bound_that_is_refused():
    """Three integrators, too many for order one: the least norm isn't below 1.

    The loop's polynomial has no s^2. All is seen of x alone, so no mode is fixed; of a
    place that isn't seen one is, which no controller moves.
    """
    one = np.eye(3)
    chain = sos.DescriptorSystem(one, np.eye(3, k=1), one[:, 2:], one, one)
    for asked in (dict(minimize="gamma"), dict(maximize="sigma")):
        design = sos.design_pid(
            chain, law=sos.DynamicLaw(1, one[:1]), **asked, starts=2
        )
        assert design.status == "undecided", design.reason
        design = sos.design_pid(chain, law=sos.DynamicLaw(1, one[1:2]), **asked)
        assert design.status == "infeasible" and design.infeasibility.verify()
        assert "these sensors don't see it. It violates stability" in design.reason
