"""The spread of the vertices moves; verdicts and poles follow."""

import re

import numpy as np
import pytest
from sosbook.widgets.coupling import explore_coupling

import sosbook as sos
from sosbook import counterexamples


@pytest.fixture(scope="module")
def explorer():
    return explore_coupling(
        counterexamples.actuated(), sos.PoleRegion(rho=10), slack=0.1
    )


def words(explorer):
    return re.search("<p role='status'.*?>(.*?)</p>", explorer.picture.value)[1]


def test_it_starts_at_the_polytope_itself(explorer):
    explorer.sliders["spread"].value = 80
    said = words(explorer)
    assert "vertices: <strong>feasible, and UNSTABLE inside" in said
    assert "pairs: infeasible" in said
    assert "slack: feasible, and kept" in said
    assert explorer.picture.value.count("<svg role='img'") == 3


def test_closer_vertices_are_no_trouble(explorer):
    explorer.sliders["spread"].value = 40
    said = words(explorer)
    assert said.count("feasible, and kept at every sampled plant") == 3
    assert "<strong>" not in said
    page = explorer.picture.value
    assert page.count("l8 8m0-8l-8 8") == 3 * 11 * 4  # poles
    explorer.sliders["spread"].value = 80
    assert "UNSTABLE" in words(explorer)


def test_a_pole_that_leaves_the_region_is_named():
    """Seed 6 of the survey: stable, but outside the sector."""
    region = sos.PoleRegion(theta=np.pi / 6, rho=6)
    explorer = explore_coupling(
        counterexamples.random_pair(6, 9), region, count=21, slack=0.1
    )
    said = words(explorer)
    assert "vertices: <strong>feasible, and a" in said


def test_other_requirements_reach_the_design():
    explorer = explore_coupling(
        counterexamples.random_chain(0, box=False),
        slack=0.3,
        saturation=sos.Saturation(0.01, [1, 0, 0, 0]),
        gamma=0.1,
    )
    assert "vertices: infeasible; pairs: infeasible" in words(explorer)


def test_a_certain_mass_is_refused():
    plants = sos.thesis.example_4().plant
    with pytest.raises(ValueError, match="same mass"):
        explore_coupling(plants)


def test_the_slider_is_named(explorer):
    assert "mass spread" in explorer.sliders["spread"].description
