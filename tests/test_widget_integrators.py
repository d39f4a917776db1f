"""The channels and a stiffness move; the verdict follows."""

import numpy as np
import pytest
from sosbook.widgets.integrators import explore_integrators

import sosbook as sos
from sosbook.synthesis.integrators import admissible_U

REGION = sos.PoleRegion(sigma=0.3, rho=6)


def family(s22):
    return sos.SecondOrderSystem(np.eye(2), np.eye(2), [[2, -1], [-1, s22]], [[1], [0]])


@pytest.fixture
def explorer():
    return explore_integrators(family, 1.0, -1.0, 2.0, REGION, "s22")


def test_each_choice_shows_the_gains_of_its_design(explorer):
    for channels in ((0,), (1,)):
        explorer.sliders["channels"].value = channels
        page = explorer.picture.value
        design = sos.design_pid(family(1.0), np.eye(2)[list(channels)], region=REGION)
        assert "<strong>admissible</strong>" in page
        for gain in design.K.ravel():
            assert f">{gain:.4g}<" in page


def test_the_zero_at_the_origin_is_said_and_passes(explorer):
    explorer.sliders["value"].value = 0.0
    page = explorer.picture.value
    assert "<strong>inadmissible</strong>" in page
    assert "transmission zero at s = 0" in page
    assert "gains" not in page
    explorer.sliders["channels"].value = (1,)
    assert "<strong>admissible</strong>" in explorer.picture.value
    explorer.sliders["channels"].value = (0,)
    explorer.sliders["value"].value = -0.5
    page = explorer.picture.value
    (choice,) = admissible_U(family(-0.5), [[[1, 0]]])
    assert f"distance {choice.distance:.3g}" in page


def test_sliders_and_pictures_have_words(explorer):
    assert [s.description for s in explorer.sliders.values()] == ["integrate", "s22"]
    page = explorer.picture.value
    assert page.count("<svg role='img' aria-label='") == 2
    assert "role='status'" in page


def test_an_unstabilisable_plant_in_the_range_is_refused():
    def stuck(s22):
        return sos.SecondOrderSystem(
            np.eye(2), np.eye(2), np.diag([1, s22]), [[1], [0]]
        )

    with pytest.raises(ValueError, match="can't be stabilised"):
        explore_integrators(stuck, 1.0, -1.0, 2.0)
