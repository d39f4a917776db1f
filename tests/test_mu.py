"""The free scalar mu of Theorem 2.1."""

import numpy as np
import pytest

import sosbook as sos
from sosbook.plants.descriptor import Coupled, descriptors
from sosbook.theorems import bounded_real


@pytest.fixture(scope="module")
def robot():
    return sos.thesis.example_1()


def test_mu_is_the_size_of_P():
    """P / mu with mu is P with 1, after a congruence."""
    d, = descriptors(sos.thesis.example_1().plant, np.eye(2))
    rng = np.random.default_rng(1)
    P, Y, mu = rng.standard_normal((6, 6)), rng.standard_normal((2, 6)), 0.01
    P = P + P.T
    one = bounded_real(Coupled(d, d, P, Y), 1.7)
    other = bounded_real(Coupled(d, d, P / mu, Y / mu), 1.7, mu)
    size = np.repeat([np.sqrt(mu), np.sqrt(mu), 1 / np.sqrt(mu)], [6, 2, 2])
    assert np.allclose(other * np.outer(size, size), one)


@pytest.mark.parametrize("mu", [0.01, 1, 100])
def test_alone_gamma_does_not_depend_on_mu(robot, mu):
    """Without a block that fixes the size of P."""
    d = sos.design_pid(
        robot.plant, robot.U, robot.region, mu=mu, minimize="gamma"
    )
    wanted = sos.design_pid(
        robot.plant, robot.U, robot.region, minimize="gamma"
    )
    assert d.gamma == wanted.gamma
    assert np.allclose(d.K, wanted.K, rtol=1e-4)


def test_mu_is_a_unit_of_w(robot):
    """-mu I and -(gamma^2/mu) I are F / sqrt(mu) and gamma / sqrt(mu)."""
    plant, mu = robot.plant, 0.04
    other = sos.SecondOrderSystem(
        plant.M, plant.D, plant.S, plant.B, plant.F / np.sqrt(mu)
    )
    asked = dict(U=robot.U, region=robot.region, saturation=robot.saturation)
    first = sos.design_pid(plant, gamma=0.3, mu=mu, **asked)
    second = sos.design_pid(other, gamma=0.3 / np.sqrt(mu), **asked)
    assert np.allclose(first.K, second.K, rtol=1e-5)


@pytest.mark.slow
def test_free_mu_proves_what_one_cannot(robot):
    """A bound near the true norm, over the other requirements."""
    asked = dict(U=robot.U, region=robot.region, saturation=robot.saturation)
    fixed = sos.design_pid(robot.plant, minimize="gamma", **asked)
    free = sos.design_pid(robot.plant, minimize="gamma", mu="free", **asked)
    assert free.gamma < fixed.gamma / 10
    assert free.hinf() < free.gamma < 2 * free.hinf()
    assert free.certify().proven
    tight = sos.design_pid(robot.plant, gamma=0.02, mu="free", **asked)
    assert tight.status == "feasible" and tight.certify().proven
    assert sos.design_pid(robot.plant, gamma=0.02, **asked).status == "infeasible"


@pytest.mark.slow
def test_free_mu_that_finds_nothing_is_undecided(robot):
    asked = dict(U=robot.U, region=robot.region, saturation=robot.saturation)
    d = sos.design_pid(robot.plant, gamma=0.001, mu="free", **asked)
    assert d.status == "undecided"
    with pytest.raises(ValueError, match="undecided"):
        d.certify()


@pytest.mark.parametrize("asked, words", [
    (dict(mu=0), "mu must be positive"),
    (dict(mu="best"), "mu must be a number or \"free\""),
    (dict(mu="free"), "needs gamma"),
    (dict(mu="free", gamma=1, coupling="slack"), "two searches"),
    (dict(slack=0.1), "slack is given"),
    (dict(slack=-1, coupling="slack"), "slack must be positive"),
    (dict(coupling="loose"), "coupling must be"),
])
def test_bad_input(robot, asked, words):
    with pytest.raises(ValueError, match=words):
        sos.design_pid(robot.plant, robot.U, robot.region, **asked)
