"""Each theorem in its four readings, and beside the printed matrices."""

import cvxpy
import numpy as np
import pytest

from sosbook import LMIRegion, theorems
from sosbook.exact.definite import exact
from sosbook.lmi import Unknown
from sosbook.plants.coupled import Coupled, SlackVertex
from sosbook.plants.descriptor import Descriptor, descriptors
from tests.cases import random_plant

GAMMA2, U_MAX2 = 1.7, 30.0


def pair(seed):
    """Two descriptors and a symmetric P, a Y; n, m, a, p all differ."""
    rng = np.random.default_rng(seed)
    plants = random_plant(rng, 3, 2, 4, vertices=2, spread=0.3)
    both = descriptors(plants, U=rng.standard_normal((1, 3)))
    P, Y = rng.standard_normal((7, 7)), rng.standard_normal((2, 7))
    return both, P + P.T, Y, rng.standard_normal(7)


def matrices(c, x0, gamma2, u_max2, number=lambda x: x):
    """All theorems of a pair, by name."""
    regions = {
        "half-plane": LMIRegion.half_plane(0.7),
        "disk": LMIRegion.disk(5, -1),
        "sector": LMIRegion.sector(0.6, apex=0.3),
        "ellipse": LMIRegion.ellipse(-3, 2, 1),
    }
    found = {
        name: theorems.pole_region(c, number(r.alpha), number(r.beta))
        for name, r in regions.items()
    }
    found["stability"] = theorems.stability(c)
    found["hinf"] = theorems.bounded_real(c, gamma2)
    found["x0"] = theorems.initial_state(c.P, x0)
    found["u_max"] = theorems.control_bound(c.P, c.Y, u_max2)
    return found


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("j", [0, 1], ids=["vertex", "pair"])
def test_four_readings_agree(seed, j):
    both, P, Y, x0 = pair(seed)
    floats = matrices(Coupled(both[0], both[j], P, Y), x0, GAMMA2, U_MAX2)

    def same(found):
        for name, wanted in floats.items():
            scale = np.abs(wanted).max()
            got = np.asarray(found[name], float)
            assert np.abs(got - wanted).max() < 1e-13 * scale, name

    p, y = Unknown("P", 7, symmetric=True), Unknown("Y", 2, 7)
    symbolic = matrices(Coupled(both[0], both[j], p, y), x0, GAMMA2, U_MAX2)
    same({k: g.value({p: P, y: Y}) for k, g in symbolic.items()})

    rational = [d.map(exact) for d in both]
    c = Coupled(rational[0], rational[j], exact(P), exact(Y))
    same(matrices(c, exact(x0), exact(GAMMA2), exact(U_MAX2), exact))

    p, y = cvxpy.Variable((7, 7), symmetric=True), cvxpy.Variable((2, 7))
    p.value, y.value = P, Y
    convex = matrices(Coupled(both[0], both[j], p, y), x0, GAMMA2, U_MAX2)
    same({k: g.value for k, g in convex.items()})


@pytest.fixture
def vertex():
    """One vertex, its Theta by hand, and E P E'."""
    (d, _), P, Y, x0 = pair(4)
    Theta = d.A @ P @ d.E.T + d.Bu @ Y @ d.E.T
    return d, P, Y, x0, Theta, d.E @ P @ d.E.T


def test_2_15(vertex):
    d, P, Y, _, Theta, _ = vertex
    rows = [
        [Theta + Theta.T, d.E @ P @ d.C.T, d.Bw],
        [d.C @ P @ d.E.T, -GAMMA2 * np.eye(3), np.zeros((3, 4))],
        [d.Bw.T, np.zeros((4, 3)), -np.eye(4)],
    ]
    found = theorems.bounded_real(Coupled(d, d, P, Y), GAMMA2)
    assert np.allclose(found, -np.block(rows), atol=1e-13)


SIN, COS = np.sin(0.6), np.cos(0.6)
REGIONS = {  # a region, and what is printed of Theta and E P E'
    "2.18": (
        LMIRegion.half_plane(0.7),
        lambda Theta, EPE: 2 * 0.7 * EPE + Theta + Theta.T,
    ),
    "2.19": (
        LMIRegion.disk(5),
        lambda Theta, EPE: np.block([[-5 * EPE, Theta], [Theta.T, -5 * EPE]]),
    ),
    "2.20": (
        LMIRegion.sector(0.6),
        lambda Theta, EPE: np.block(
            [
                [SIN * (Theta + Theta.T), COS * (Theta - Theta.T)],
                [COS * (Theta.T - Theta), SIN * (Theta + Theta.T)],
            ]
        ),
    ),
}


@pytest.mark.parametrize("equation", REGIONS)
def test_regions(vertex, equation):
    d, P, Y, _, Theta, EPE = vertex
    part, printed = REGIONS[equation]
    found = theorems.pole_region(Coupled(d, d, P, Y), part.alpha, part.beta)
    assert np.allclose(found, -printed(Theta, EPE), atol=1e-12)


def test_2_18_with_sigma_zero_is_stability(vertex):
    d, P, Y, *_ = vertex
    c, part = Coupled(d, d, P, Y), LMIRegion.half_plane(0)
    found = theorems.pole_region(c, part.alpha, part.beta)
    assert np.allclose(found, theorems.stability(c), atol=1e-14)


def test_2_21(vertex):
    _, P, Y, x0, *_ = vertex
    first = np.block([[np.eye(1), x0[None]], [x0[:, None], P]])
    second = np.block([[P, Y.T], [Y, U_MAX2 * np.eye(2)]])
    assert np.array_equal(theorems.initial_state(P, x0), first)
    assert np.array_equal(theorems.control_bound(P, Y, U_MAX2), second)


def test_pairs_are_the_polar_form_of_the_vertices():
    """With weights a, L(a) = sum over i, j of a_i a_j L_ij."""
    (first, second), P, Y, x0 = pair(5)
    weights = np.array([0.3, 0.7])
    assert first.Du is None and second.Du is None
    mixed = Descriptor(
        **{
            name: weights[0] * x + weights[1] * getattr(second, name)
            for name, x in vars(first).items()
            if x is not None
        }
    )
    whole = matrices(Coupled(mixed, mixed, P, Y), x0, GAMMA2, U_MAX2)
    both = (first, second)
    total = {name: 0 for name in whole}
    for i in range(2):
        for j in range(2):
            part = matrices(Coupled(both[i], both[j], P, Y), x0, GAMMA2, U_MAX2)
            for name, g in part.items():
                total[name] = total[name] + weights[i] * weights[j] * g
    for name, g in whole.items():
        assert np.allclose(total[name], g, atol=1e-12), name


def slack_matrices(c, x0, gamma2, mu, epsilon, number=lambda x: x):
    """All theorems with a slack matrix, by name."""
    regions = {
        "half-plane": LMIRegion.half_plane(0.7),
        "disk": LMIRegion.disk(5, -1),
        "sector": LMIRegion.sector(0.6, apex=0.3),
        "ellipse": LMIRegion.ellipse(-3, 2, 1),
    }
    found = {
        name: theorems.slack_pole_region(c, number(r.alpha), number(r.beta), epsilon)
        for name, r in regions.items()
    }
    found["stability"] = theorems.slack_stability(c, epsilon)
    found["hinf"] = theorems.slack_bounded_real(c, gamma2, mu, epsilon)
    found["x0"] = theorems.slack_initial_state(c.P, c.V, x0)
    return found


def test_four_readings_of_the_slack_theorems_agree():
    (d, other), P, Y, x0 = pair(5)
    V = np.random.default_rng(5).standard_normal((7, 7))
    E0 = (d.E + other.E) / 2
    scalars = GAMMA2, 0.5, 0.25
    floats = slack_matrices(SlackVertex(d, E0, P, V, Y), x0, *scalars)

    def same(found):
        for name, wanted in floats.items():
            scale = np.abs(wanted).max()
            got = np.asarray(found[name], float)
            assert np.abs(got - wanted).max() < 1e-13 * scale, name

    p, v, y = Unknown("P", 7, symmetric=True), Unknown("V", 7), Unknown("Y", 2, 7)
    symbolic = slack_matrices(SlackVertex(d, E0, p, v, y), x0, *scalars)
    same({k: g.value({p: P, v: V, y: Y}) for k, g in symbolic.items()})

    c = SlackVertex(d.map(exact), exact(E0), exact(P), exact(V), exact(Y))
    same(slack_matrices(c, exact(x0), *map(exact, scalars), exact))

    p = cvxpy.Variable((7, 7), symmetric=True)
    v, y = cvxpy.Variable((7, 7)), cvxpy.Variable((2, 7))
    p.value, v.value, y.value = P, V, Y
    convex = slack_matrices(SlackVertex(d, E0, p, v, y), x0, *scalars)
    same({k: g.value for k, g in convex.items()})


@pytest.mark.parametrize(
    "region",
    [
        LMIRegion.half_plane(0.4),
        LMIRegion.sector(0.9),
        LMIRegion.disk(6, -2),
        LMIRegion.strip(-9, -0.2),
    ],
)
def test_slack_blocks_imply_a_lyapunov_inequality(region):
    """On E x' = (A + B K) x the slack drops out and V'^-1 P V^-1 is left."""
    rng = np.random.default_rng(3)
    (d, _), P, Y, _ = pair(3)
    V = rng.standard_normal((7, 7))
    c = SlackVertex(d, np.eye(7), P, V, Y)
    found = theorems.slack_pole_region(c, region.alpha, region.beta, 0.3)
    K = np.linalg.solve(V, Y.T).T
    loop = np.linalg.solve(d.E, d.A + d.Bu @ K)
    rate = np.linalg.solve(V.T, loop @ V.T)  # of V'^-1 x
    k = len(found) // 14
    N = np.hstack([np.eye(7 * k), np.kron(np.eye(k), rate.T)])
    alpha, beta = region.alpha, region.beta
    if k < len(alpha):  # the disk |s - q| < rho as one row
        rho, q = -alpha[0]
        left = rate - q * np.eye(7)
        wanted = rho**2 * P - left.T @ P @ left
    else:
        half = np.kron(beta, P @ rate)
        wanted = -(np.kron(alpha, P) + half + half.T)
    assert np.allclose(N @ found @ N.T, wanted, atol=1e-9 * np.abs(wanted).max())
