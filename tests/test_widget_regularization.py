"""Moving beta regularises again; an infeasible one is said."""

import numpy as np
import pytest
from sosbook.widgets.regularization import explore_regularization

import sosbook as sos
from sosbook.synthesis.regularization import regularize


@pytest.fixture(scope="module")
def chain():
    return sos.thesis.example_3().plant


@pytest.fixture
def explorer(chain):
    return explore_regularization(chain)


@pytest.mark.parametrize(
    "beta, choose", [(0.1, "centre"), (0.3, "centre"), (0.5, "least norm")]
)
def test_the_page_shows_the_gain(explorer, chain, beta, choose):
    explorer.sliders["choose"].value = choose
    explorer.sliders["beta"].value = beta
    page = explorer.picture.value
    found = regularize(chain, explorer.sliders["beta"].value, choose=choose)
    assert "<strong>feasible</strong>" in page
    for gain in found.K_A.ravel():
        assert f">{gain:.4g}<" in page
    assert f"reached: {found.bound:.3g}" in page
    assert page.count("<circle") == 4 + 7  # masses; finite poles
    crosses = page.count("l8 8m0-8l-8 8") - 4
    assert crosses >= 6  # poles far to the left aren't drawn
    assert f"{np.abs(found.regular.poles()).max():.4g} rad/s" in page


def test_a_beta_too_large_comes_with_advice(explorer):
    before = explorer.picture.value
    explorer.sliders["beta"].value = 1.5
    page = explorer.picture.value
    assert "<strong>infeasible</strong>" in page
    assert "below 1:" in page
    assert "<svg" not in page
    explorer.sliders["beta"].value = 0.1
    assert explorer.picture.value == before


def test_every_slider_and_picture_has_words(explorer):
    assert all(s.description for s in explorer.sliders.values())
    page = explorer.picture.value
    assert page.count("<svg role='img' aria-label='") == 2
    assert "role='status'" in page


def test_a_polytope_and_a_plant_without_poles(chain):
    heavy = sos.SecondOrderSystem(1.2 * chain.M, chain.D, chain.S, chain.B, chain.F)
    both = explore_regularization(sos.Polytope([chain, heavy]))
    assert both.picture.value.count("<circle") == 8 + 14
    still = sos.SecondOrderSystem([[0]], [[0]], [[1]], [[1]])
    assert "feasible" in explore_regularization(still).picture.value
