"""The unit of w moves; gamma follows, the norm stays."""

import pytest
from sosbook.widgets.gamma import explore_mu

import sosbook as sos
from sosbook.studies.gamma_bounds import gamma_lower_bounds

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def robot():
    return sos.thesis.example_1()


@pytest.fixture(scope="module")
def explorer(robot):
    return explore_mu(robot.plant, robot.K, robot.U, robot.region, robot.saturation)


@pytest.mark.parametrize("mu", [0.0, -1.5, -3.5])
def test_the_smallest_gamma_of_this_mu_is_shown(explorer, robot, mu):
    explorer.sliders["mu"].value = mu
    mu = explorer.sliders["mu"].value
    found = sos.analyse_pid(
        robot.plant,
        robot.K,
        robot.U,
        region=robot.region,
        saturation=robot.saturation,
        mu=10**mu,
        minimize="gamma",
        backoff=1e-3,
    )
    page = explorer.picture.value
    assert f"<strong>{found.gamma:.3g}</strong>" in page
    assert f"energy up to {10**-mu:.3g}" in page
    assert "role='status'" in page
    assert page.count("<svg role='img' aria-label='") == 1


def test_behind_the_wall_there_is_no_gamma(explorer, robot):
    walls = gamma_lower_bounds(robot.plant, robot.K, robot.U, robot.saturation)
    explorer.sliders["mu"].value = explorer.sliders["mu"].min
    assert 10 ** explorer.sliders["mu"].value < walls.mu
    page = explorer.picture.value
    assert "<strong>infeasible</strong>" in page  # for this mu and every gamma
    assert "gamma = <strong>" not in page
    given = sos.analyse_pid(
        robot.plant,
        robot.K,
        robot.U,
        region=robot.region,
        gamma=1e4,
        saturation=robot.saturation,
        mu=10 ** explorer.sliders["mu"].value,
    )
    assert given.status == "infeasible"
    assert given.infeasibility.proven


def test_it_needs_an_initial_state(robot):
    with pytest.raises(ValueError, match="saturation must be"):
        explore_mu(robot.plant, robot.K, robot.U, robot.region)
