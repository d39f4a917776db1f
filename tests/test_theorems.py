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


FORMS = {
    "half-plane": LMIRegion.half_plane(0.7),
    "disk": LMIRegion.disk(5, -1),
    "sector": LMIRegion.sector(0.6, apex=0.3),
    "ellipse": LMIRegion.ellipse(-3, 2, 1),
}


def matrices(c, x0, number=lambda x: x):
    """All theorems of a pair, by name."""
    found = {
        name: theorems.pole_region(c, number(r.alpha), number(r.beta))
        for name, r in FORMS.items()
    }
    found["stability"] = theorems.stability(c)
    found["hinf"] = theorems.bounded_real(c, number(GAMMA2))
    found["x0"] = theorems.initial_state(c.P, number(x0))
    found["u_max"] = theorems.control_bound(c.P, c.Y, number(U_MAX2))
    return found


def slack_matrices(c, x0, number=lambda x: x):
    """All theorems with a slack matrix, by name."""
    gamma2, mu, epsilon = map(number, (GAMMA2, 0.5, 0.25))
    found = {
        name: theorems.slack_pole_region(c, number(r.alpha), number(r.beta), epsilon)
        for name, r in FORMS.items()
    }
    found["stability"] = theorems.slack_stability(c, epsilon)
    found["hinf"] = theorems.slack_bounded_real(c, gamma2, mu, epsilon)
    found["x0"] = theorems.slack_initial_state(c.P, c.V, number(x0))
    return found


def readings(write, plants, values):
    """What is written in floats; of unknowns, in rationals and by cvxpy."""
    yield write(plants, values, lambda x: x)
    unknowns = {k: Unknown(k, *x.shape, symmetric=k == "P") for k, x in values.items()}
    at = {unknowns[k]: x for k, x in values.items()}
    symbolic = write(plants, unknowns, lambda x: x)
    yield {name: g.value(at) for name, g in symbolic.items()}
    rational = {k: exact(x) for k, x in values.items()}
    yield write([d.map(exact) for d in plants], rational, exact)
    free = {k: cvxpy.Variable(x.shape, symmetric=k == "P") for k, x in values.items()}
    for k, x in values.items():
        free[k].value = x
    convex = write(plants, free, lambda x: x)
    yield {name: g.value for name, g in convex.items()}


def assert_same(floats, *others):
    for found in others:
        for name, wanted in floats.items():
            apart = np.abs(np.asarray(found[name], float) - wanted).max()
            assert apart < 1e-13 * np.abs(wanted).max(), name


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("j", [0, 1], ids=["vertex", "pair"])
def test_four_readings_agree(seed, j):
    both, P, Y, x0 = pair(seed)

    def write(d, v, number):
        return matrices(Coupled(d[0], d[j], v["P"], v["Y"]), x0, number)

    assert_same(*readings(write, both, {"P": P, "Y": Y}))


def test_four_readings_of_the_slack_theorems_agree():
    both, P, Y, x0 = pair(5)
    V = np.random.default_rng(5).standard_normal((7, 7))
    E0 = (both[0].E + both[1].E) / 2

    def write(d, v, number):
        c = SlackVertex(d[0], number(E0), v["P"], v["V"], v["Y"])
        return slack_matrices(c, x0, number)

    assert_same(*readings(write, both, {"P": P, "V": V, "Y": Y}))


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
    whole = matrices(Coupled(mixed, mixed, P, Y), x0)
    both = (first, second)
    total = {name: 0 for name in whole}
    for i in range(2):
        for j in range(2):
            part = matrices(Coupled(both[i], both[j], P, Y), x0)
            for name, g in part.items():
                total[name] = total[name] + weights[i] * weights[j] * g
    for name, g in whole.items():
        assert np.allclose(total[name], g, atol=1e-12), name
