"""The spread of all five ratios from the fit: a box that holds them."""

import json

import numpy as np
import pytest
from scipy.stats import chi2

from sosbook.pendulum import Mip, Robot, recommend
from sosbook.pendulum.command import main
from sosbook.pendulum.comparison import Comparison
from sosbook.pendulum.deployment import deploy
from sosbook.pendulum.fit_spread import FitSpread
from sosbook.pendulum.gate import widened
from sosbook.pendulum.identify import identify
from sosbook.pendulum.modelled import Model
from sosbook.pendulum.rig import DATA, shipped
from sosbook.pendulum.spread import polytope, triangles, vertices
from sosbook.pendulum.turning import inertia_bounds, turning_plants

LOGS = DATA / "body.csv", DATA / "wheels.csv"


@pytest.fixture(scope="module")
def fit():
    return identify(shipped("body"), shipped("wheels"))


@pytest.fixture(scope="module")
def spread(fit):
    return FitSpread.of(fit, widened(fit))


#: What stays as the masses and lengths say: r^2 (M_b + 2 M_w), and, with rotors on the
#: body, the discs of both wheels, 2 I_w - J = M_w r^2.
ROBOTS_OWN = (
    lambda mip: mip.a - 2 * mip.I_w,
    lambda mip: 2 * mip.I_w - mip.J if mip.J else 0.0,
)


def numbers(mip):
    return np.array([mip.c, mip.e, mip.f, mip.I_w])


@pytest.mark.parametrize("confidence", [0.95, 0.99])
def test_the_box_holds_as_much_as_the_ellipsoid(confidence, spread):
    """Of normal errors: it needn't hold the ellipsoid."""
    found = FitSpread(spread.covariance, confidence)
    random = np.random.default_rng(3)
    drawn = random.multivariate_normal(np.zeros(4), found.covariance, 200_000)
    inside = (abs(found.places(drawn)) <= 1).all(axis=1)
    assert inside.mean() == pytest.approx(confidence, abs=0.002)
    inverse = np.linalg.inv(found.covariance)
    distance = np.einsum("ki,ij,kj->k", drawn, inverse, drawn)
    oval = distance <= chi2.ppf(confidence, 4)
    assert oval.mean() == pytest.approx(confidence, abs=0.002)
    # its corners are nearer than those of the simplex around the ellipsoid
    far = np.einsum("ki,ij,kj->k", found.corners, inverse, found.corners)
    assert far == pytest.approx(16 * [4 * found.radius**2])
    assert 2 * found.radius < 0.5 * 4 * chi2.ppf(confidence, 4) ** 0.5


def test_the_plants_between_the_corners_are_pendulums_of_the_box(fit, spread):
    """M, D, S and B are affine in c, e, f and I_w, with rotors too."""
    random = np.random.default_rng(4)
    rotors = Mip.from_ratios(**fit.ratios, rotors=True)
    for mip in (fit.mip, rotors):
        corners = spread.vertices(mip)
        for known in ROBOTS_OWN:  # whatever its motors are
            same = [known(x) for x in corners]
            assert same == pytest.approx(16 * [known(mip)], rel=1e-12)
        plants = polytope(mip, spread)
        assert plants.N == 16 and plants.coordinates == mip.plant().coordinates
        for corner, plant in zip(corners, plants.vertices):
            for name in "MDSB":
                exact = getattr(corner.plant(), name)
                assert np.allclose(getattr(plant, name), exact, rtol=1e-12)
        for place in random.uniform(-1, 1, (20, 4)):
            moved = spread.axes @ place
            assert spread.places(moved) == pytest.approx(place)
            middle = spread._moved(mip, *moved).plant()
            mixed = plants.family.at(**dict(zip(plants.family.box.names, place)))
            for name in "MDSB":
                found = getattr(mixed, name)
                assert np.allclose(getattr(middle, name), found, rtol=1e-12)


def test_the_four_numbers_follow_from_the_five_ratios(fit, spread):
    """Its covariance is that of `Mip.from_ratios` of ratios that err."""
    random = np.random.default_rng(5)
    value, sd = np.array(list(fit.ratios.values())), widened(fit)
    covariance = fit.covariance.copy()
    np.fill_diagonal(covariance, sd**2)
    drawn = random.multivariate_normal(value, covariance, 8000)
    moved = [
        numbers(Mip.from_ratios(**dict(zip(fit.ratios, x)))) / numbers(fit.mip) - 1
        for x in drawn
    ]
    assert np.cov(np.array(moved).T) == pytest.approx(
        spread.covariance, rel=0.05, abs=0.02 * spread.covariance.max()
    )
    inside = (abs(spread.places(moved)) <= 1).all(axis=1)
    assert inside.mean() == pytest.approx(0.99, abs=0.003)


def test_places_that_take_a_number_take_it(fit, spread):
    assert len(vertices(fit.mip, spread)) == 16
    assert [part.N for part in triangles(fit.mip, spread)] == [16]
    robot = Robot.shipped("thesis").but(track=0.07)
    whole = turning_plants(fit.mip, robot, spread)[0].vertices
    for mip in vertices(fit.mip, spread):
        for inertia in inertia_bounds(mip, robot):
            m, d = inertia / mip.e, mip.f / mip.e
            assert min(p.M[0, 0] for p in whole) <= m <= max(p.M[0, 0] for p in whole)
            assert min(p.D[0, 0] for p in whole) <= d <= max(p.D[0, 0] for p in whole)


@pytest.mark.slow
def test_a_robot_is_proven_within_it_and_says_so(spread, tmp_path, monkeypatch):
    """Its program's loop for no and all delay."""
    monkeypatch.setattr("sosbook.pendulum.proven.REST_SECONDS", 6.0)
    monkeypatch.setattr("sosbook.pendulum.tuning.DELAY_SHARES", (0.0, 1.0))
    found = main([*map(str, LOGS), str(tmp_path), "--confidence", "0.99"])
    assert found.proven and len(found.robots) == 17
    assert np.allclose(found.spread.covariance, spread.covariance)
    assert [len(row) for row in found.sampled.values()] == [1, 1]
    facts = json.loads((tmp_path / "provenance_balance.json").read_text("utf-8"))
    assert "all at once, with 99 %" in facts["spread"]
    assert f"c by {100 * abs(spread.corners[:, 0]).max():.2g} %" in facts["spread"]
    model = Model.read(tmp_path)
    assert np.array_equal(model.spread.covariance, found.spread.covariance)
    assert model.spread.confidence == 0.99 and model.text == Model.of(found).text


@pytest.mark.campaign
def test_steering_is_proven_within_it(fit, spread):
    robot = Robot.shipped("thesis").but(track=0.07)
    design = recommend(fit.mip, spread=spread, robot=robot).steering
    assert design.lacking == () and design.coupled_radius < 1


class Tracked:
    """What `track` found: intervals of e/c and e/a over the model's."""

    def __init__(self, body, wheels):
        self.ends = {"body": body, "wheels": wheels}

    def interval(self, name):
        return self.ends[name]


@pytest.mark.parametrize(
    "body, wheels, verdict",
    [
        ((0.9999, 1.0001), (0.9999, 1.0001), True),
        ((0.9, 1.1), (0.9, 1.1), None),
        ((1.2, 1.3), (0.9, 1.1), False),
        ((0.99, 1.01), (0.7, 0.8), False),
    ],
)
def test_a_running_robot_is_held_against_it(body, wheels, verdict, fit, spread):
    model = Model(fit.mip, Robot.shipped("thesis"), spread, None)
    found = Comparison(model, None, Tracked(body, wheels), ())
    assert found.within is verdict


@pytest.mark.slow
def test_a_refusal_names_the_ratio_that_the_logs_know_least(fit):
    """Not the clock, which is fast enough for the robot in the middle."""
    wide = FitSpread(np.diag([0.01, 0.01, 0.01, 0.2]) ** 2)
    robot = Robot.shipped("thesis").but(law="observer")
    with pytest.raises(ValueError, match="logs allow. Of .* e/a least.* the wheels"):
        recommend(fit.mip, R=None, spread=wide, robot=robot)
    unproven = recommend(fit.mip, spread=FitSpread(0.01**2 * np.eye(4)), robot=robot)
    vars(unproven)["lacking"] = ("sampled, 0 ms late: undecided",)
    with pytest.raises(ValueError, match="undecided. Of the five .* least, to 2.8 %"):
        unproven.write("nowhere")


def test_bad_input_is_named(fit, spread):
    with pytest.raises(ValueError, match="confidence must lie between 0 and 1"):
        FitSpread(spread.covariance, 1.0)
    with pytest.raises(ValueError, match="covariance must be positive definite"):
        FitSpread(np.zeros((4, 4)))
    with pytest.raises(
        ValueError, match="too uncertain: .* reaches c by .* log of the"
    ):
        FitSpread(0.4**2 * np.eye(4))
    with pytest.raises(ValueError, match="give spread or confidence"):
        deploy(*LOGS, confidence=0.9, spread=0.04)
