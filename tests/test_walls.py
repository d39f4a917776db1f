"""Lower bounds of gamma and mu in a joint request."""

import numpy as np
import pytest

import sosbook as sos
from sosbook.book import thesis
from sosbook.book.reproduction.gamma_bounds import GammaLowerBounds, gamma_lower_bounds
from tests.cases import campaign

EXAMPLES = [thesis.example_1, thesis.example_2, thesis.example_3]


def smallest(example, mu, region=None, u_max=None):
    limit = sos.Saturation(u_max or example.saturation.u_max, example.saturation.x0)
    return sos.analyse_pid(
        example.plant,
        example.K,
        example.U,
        region=region,
        saturation=limit,
        K_A=example.K_A,
        gamma=sos.HInfinity(mu=mu),
        minimize="gamma",
        search=sos.Search(backoff=1e-3),
    )


@pytest.mark.slow
@pytest.mark.parametrize("make", [EXAMPLES[1], *campaign(EXAMPLES[::2])])
def test_no_certificate_lies_below_the_walls(make):
    example = make()
    walls = gamma_lower_bounds(
        example.plant, example.K, example.U, example.saturation, example.K_A
    )
    for mu in (3 * walls.mu, walls.corner, 100.0):
        found = smallest(example, mu, example.region)
        assert found.status == "feasible" or mu < walls.corner
        if found.status == "feasible":
            assert found.gamma > walls.gamma(mu)
    assert smallest(example, 0.99 * walls.mu, example.region).gamma is None


@pytest.mark.parametrize("make", EXAMPLES[:2])
def test_without_a_region_the_walls_are_all_there_is(make):
    example = make()
    walls = gamma_lower_bounds(example.plant, example.K, example.U, example.saturation)
    for mu in (2 * walls.corner, 1.0, 100.0):
        found = smallest(example, mu)
        assert 1 < found.gamma / walls.gamma(mu) < 1.25
    found = smallest(example, 0.2 * walls.corner)
    assert 1 < found.gamma / walls.norm < 1.02


def test_with_a_large_u_max_the_second_wall_is_exact():
    example = EXAMPLES[0]()
    walls = gamma_lower_bounds(example.plant, example.K, example.U, example.saturation)
    found = smallest(example, 10.0, u_max=1e5)
    assert 1 < found.gamma / walls.gamma(10.0) < 1.015


def test_energy_is_that_of_the_simulated_free_motion():
    example = EXAMPLES[0]()
    design = sos.analyse_pid(example.plant, example.K, **example.requirements)
    t = np.linspace(0, 30, 30001)
    z = design.simulate(t, x0=example.saturation.x0).z
    walls = gamma_lower_bounds(example.plant, example.K, example.U, example.saturation)
    assert walls.energy == pytest.approx(np.trapezoid((z**2).sum(axis=0), t), rel=1e-4)


def test_below_the_third_wall_a_disturbance_breaks_the_bound():
    """The worst w of unit energy is B' exp(A'(T - t)) K' g, scaled."""
    from scipy.linalg import expm, solve_continuous_lyapunov

    example = EXAMPLES[0]()
    (d,) = sos.plants.descriptors(example.plant, example.U)
    A = sos.analysis.loop_matrix(d, example.K)
    B = d.state_space()[2]
    W = solve_continuous_lyapunov(A, -B @ B.T)
    size, g = np.linalg.eigh(example.K @ W @ example.K.T)
    T, steps = 12.0, 4000
    h = T / steps
    forward = expm(A * h)
    x, energy, kernel = np.zeros(6), 0.0, []
    costate = example.K.T @ g[:, -1]
    for _ in range(steps):
        kernel.append(B.T @ costate)
        costate = forward.T @ costate
    for w in reversed(kernel):
        x = forward @ x + h * B @ w
        energy += h * w @ w
    walls = gamma_lower_bounds(example.plant, example.K, example.U, example.saturation)
    peak = np.linalg.norm(example.K @ x) / np.sqrt(energy)
    assert peak == pytest.approx(150 * np.sqrt(walls.mu), rel=1e-2)
    assert peak**2 == pytest.approx(size[-1], rel=2e-2)


def test_corner_and_infinite_wall():
    walls = GammaLowerBounds(2.0, 4.0, 0.5)
    assert walls.corner == 1.0
    assert walls.gamma(0.4) == np.inf
    assert GammaLowerBounds(2.0, 0.0, 0.5).corner == np.inf


@pytest.mark.parametrize(
    "change, message",
    [
        (dict(plant=1.0), "plant must be a"),
        (dict(saturation=None), "saturation must be"),
        (dict(saturation=sos.Saturation(None, np.ones(6))), "u_max is None"),
        (dict(saturation=sos.Saturation(1, np.ones(6), True)), "acceleration"),
        (dict(saturation=sos.Saturation(1, np.ones(5))), "5 entries, needs 2n"),
        (dict(K=np.zeros((2, 6))), "doesn't stabilise"),
        (dict(K=np.zeros((2, 5))), "K has 5 columns"),
    ],
)
def test_bad_input_is_named(change, message):
    example = EXAMPLES[0]()
    asked = dict(plant=example.plant, K=example.K, U=example.U)
    with pytest.raises(ValueError, match=message):
        gamma_lower_bounds(**asked | dict(saturation=example.saturation) | change)


def test_a_plant_without_disturbance_is_named():
    example = EXAMPLES[0]()
    p = example.plant
    bare = sos.SecondOrderSystem(p.M, p.D, p.S, p.B)
    with pytest.raises(ValueError, match="no F"):
        gamma_lower_bounds(bare, example.K, example.U, example.saturation)
    with pytest.raises(ValueError, match="mu must be positive"):
        GammaLowerBounds(1.0, 1.0, 1.0).gamma(0)
