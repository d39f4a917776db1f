"""Sliders solve again: the picture follows, infeasible is said."""

import asyncio

import numpy as np
import pytest

import sosbook as sos
from sosbook import widgets


@pytest.fixture(scope="module")
def robot():
    return sos.thesis.example_1()


@pytest.fixture
def explorer(robot):
    return widgets.explore_design(robot.plant, **robot.requirements)


@pytest.mark.parametrize(
    "name, value",
    [("sigma", 0.5), ("theta", 40), ("rho", 7), ("gamma", 2), ("u_max", 200)],
)
def test_each_slider_shows_the_gains_of_a_new_design(explorer, robot, name, value):
    before = explorer.picture.value
    explorer.sliders[name].value = value
    moved = {key: s.value for key, s in explorer.sliders.items()}
    design = sos.design_pid(
        robot.plant,
        robot.U,
        region=sos.PoleRegion(moved["sigma"], np.radians(moved["theta"]), moved["rho"]),
        gamma=moved["gamma"],
        saturation=sos.Saturation(moved["u_max"], robot.saturation.x0),
        mu=robot.requirements["mu"],
    )
    after = explorer.picture.value
    assert after != before
    for gain in design.K.ravel():
        assert f">{gain:.4g}<" in after


def test_an_infeasible_request_is_drawn_as_such_with_advice(explorer):
    explorer.sliders["gamma"].value = 0.2
    page = explorer.picture.value
    assert "<strong>infeasible</strong>" in page
    assert "Leave out mu = 1 first" in page
    assert "K_P" not in page
    assert "url(#sos-hatch)" in page


def test_advice_waits_until_the_sliders_rest(explorer, monkeypatch):
    asked = []
    true = sos.Design.advice.func
    monkeypatch.setattr(
        sos.Design,
        "advice",
        property(lambda design: asked.append(design) or true(design)),
    )

    async def drag():
        for gamma in (0.3, 0.25, 0.2):
            explorer.sliders["gamma"].value = gamma
            assert "<strong>infeasible</strong>" in explorer.picture.value
            assert "Leave out" not in explorer.picture.value
        await asyncio.sleep(1)

    asyncio.run(drag())
    assert len(asked) == 1
    assert "Leave out mu = 1 first" in explorer.picture.value


def test_a_polytope_shows_every_vertex(robot):
    plant = robot.plant
    heavy = sos.SecondOrderSystem(1.1 * plant.M, plant.D, plant.S, plant.B, plant.F)
    pair = sos.Polytope([plant, heavy])
    region = sos.PoleRegion(sigma=0.5, rho=6)
    explorer = widgets.explore_design(pair, robot.U, region)
    page = explorer.picture.value
    assert page.count("l8 8m0-8l-8 8") == 12  # closed-loop poles
    assert page.count("<circle") == 8  # poles of the two plants
    assert page.count("<polyline") == 5  # the set point, z1, z2 twice
    explorer.sliders["rho"].value = 5
    design = sos.design_pid(pair, robot.U, region=sos.PoleRegion(0.5, rho=5))
    for gain in design.K.ravel():
        assert f">{gain:.4g}<" in explorer.picture.value


@pytest.mark.slow
def test_an_empty_region_is_explained(explorer):
    explorer.sliders["rho"].value = 1
    explorer.sliders["sigma"].value = 1.5
    assert "the region is empty" in explorer.picture.value


def test_the_way_back_shows_the_first_picture_again(explorer):
    before = explorer.picture.value
    explorer.sliders["rho"].value = 8
    explorer.sliders["rho"].value = 5
    assert explorer.picture.value == before


def test_region_explorer_says_which_part_is_violated():
    explorer = widgets.explore_region()
    assert "The poles are inside" in explorer.picture.value
    explorer.sliders["rho"].value = 2
    assert "disk: -0.50 rad/s OUTSIDE" in explorer.picture.value


def test_hinf_explorer_turns_infeasible_below_the_norm(robot):
    explorer = widgets.explore_hinf(robot.plant, robot.K, robot.U)
    norm = sos.analyse_pid(robot.plant, robot.K, robot.U).hinf()
    explorer.sliders["gamma"].value = 1.1 * norm
    assert "<strong>feasible</strong>" in explorer.picture.value
    explorer.sliders["gamma"].value = 0.9 * norm
    assert "<strong>infeasible</strong>" in explorer.picture.value


def test_saturation_explorer_follows_x0(robot):
    explorer = widgets.explore_saturation(
        robot.plant, robot.U, robot.region, robot.saturation, robot.gamma
    )
    before = explorer.picture.value
    explorer.sliders["scale"].value = 1.2
    assert "svg" in explorer.picture.value != before
    explorer.sliders["u_max"].value = 40
    assert "<strong>infeasible</strong>" in explorer.picture.value


def test_every_slider_has_a_label_and_every_picture_an_alternative(explorer):
    assert all(s.description for s in explorer.sliders.values())
    page = explorer.picture.value
    assert page.count("<svg role='img' aria-label='") == 2
    assert "role='status'" in page


def test_segment_explorer_finds_the_unstable_middle():
    plants, P = sos.counterexamples.mechanical()
    explorer = widgets.explore_segment(plants, P)
    assert "<strong>stable</strong>" in explorer.picture.value
    explorer.sliders["weight"].value = 0.5
    assert "<strong>UNSTABLE</strong>" in explorer.picture.value
    assert "+3.91" in explorer.picture.value
    explorer.sliders["weight"].value = 1
    assert "<strong>stable</strong>" in explorer.picture.value


def test_segment_explorer_wants_two_vertices(robot):
    with pytest.raises(ValueError, match="needs two"):
        widgets.explore_segment(sos.Polytope([robot.plant]), np.eye(4))


def family(s22):
    return sos.SecondOrderSystem(np.eye(2), np.eye(2), [[2, -1], [-1, s22]], [[1], [0]])


def explorers():
    robot, arm = sos.thesis.example_1(), widgets.explore_swing
    pair = sos.counterexamples.actuated()
    return {
        "design": (
            lambda: widgets.explore_design(robot.plant, **robot.requirements),
            "sigma",
            (0.9, 3, 0.5),
        ),
        "saturation": (
            lambda: widgets.explore_saturation(
                robot.plant, robot.U, robot.region, robot.saturation, robot.gamma
            ),
            "u_max",
            (200, 20, 120),
        ),
        "mass range": (widgets.explore_mass_range, "high", (150, 390, 110)),
        "swing": (arm, "phi_max", (60, 175, 100)),
        "coupling": (
            lambda: widgets.explore_coupling(pair, sos.PoleRegion(rho=10), slack=0.1),
            "spread",
            (60, 90, 40),
        ),
        "integrators": (
            lambda: widgets.explore_integrators(
                family, 1.0, -1.0, 2.0, sos.PoleRegion(sigma=0.3, rho=6)
            ),
            "value",
            (0.5, -1.0, 1.5),
        ),
    }


@pytest.mark.slow
@pytest.mark.parametrize("name", explorers())
def test_the_picture_does_not_depend_on_the_way(name, monkeypatch):
    """Designs start from the last one; what is shown doesn't tell."""
    starts = []

    def spy(*asked, start=None, **more):
        starts.append(start)
        return sos.design_pid(*asked, start=start, **more)

    monkeypatch.setattr(widgets.explorer, "design_pid", spy)
    make, slider, values = explorers()[name]
    travelled, target = make(), values[-1]
    first = travelled.picture.value
    home = travelled.sliders[slider].value
    for value in values:
        travelled.sliders[slider].value = value
    assert any(start is not None for start in starts)
    assert all(s is None or s.status == "feasible" for s in starts)
    direct = make()
    direct.sliders[slider].value = target
    assert travelled.picture.value == direct.picture.value != first
    travelled.sliders[slider].value = home
    assert travelled.picture.value == first


@pytest.mark.slow
@pytest.mark.parametrize("name", explorers())
def test_no_explorer_draws_a_matplotlib_figure(name, monkeypatch):
    from matplotlib.figure import Figure

    def refuse(*words, **more):
        raise AssertionError("a live picture is no matplotlib figure")

    monkeypatch.setattr(Figure, "__init__", refuse)
    make, slider, values = explorers()[name]
    explorer = make()
    explorer.sliders[slider].value = values[0]
    assert "<svg" in explorer.picture.value
