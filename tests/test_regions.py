"""Pole regions: what they contain, and what they refuse."""

import re
from fractions import Fraction

import numpy as np
import pytest
from flint import arb, ctx

import sosbook as sos
from sosbook import LMIRegion, PoleRegion, Region
from tests.cases import by_turns
from tests.random_plants import ODD

DEFINITIONS = {
    "half-plane": (LMIRegion.half_plane(1), lambda x, y: -1 - x),
    "right boundary": (LMIRegion.half_plane(-2), lambda x, y: 2 - x),
    "sector": (
        LMIRegion.sector(0.6),
        lambda x, y: -x * np.sin(0.6) - abs(y) * np.cos(0.6),
    ),
    "sector with apex": (
        LMIRegion.sector(0.6, apex=-1),
        lambda x, y: (-1 - x) * np.sin(0.6) - abs(y) * np.cos(0.6),
    ),
    "disk": (LMIRegion.disk(3), lambda x, y: 3 - np.hypot(x, y)),
    "shifted disk": (LMIRegion.disk(2, -3), lambda x, y: 2 - np.hypot(x + 3, y)),
    "strip": (LMIRegion.strip(-4, -1), lambda x, y: np.minimum(x + 4, -1 - x)),
    "horizontal strip": (LMIRegion.horizontal_strip(2), lambda x, y: 2 - abs(y)),
}
RNG = np.random.default_rng(3)
POINTS = RNG.uniform(-6, 4, 2000) + 1j * RNG.uniform(-5, 5, 2000)


@pytest.mark.parametrize("name", DEFINITIONS)
def test_distance_is_the_geometric_one(name):
    region, formula = DEFINITIONS[name]
    (found,) = region.distances(POINTS).values()
    wanted = formula(POINTS.real, POINTS.imag)
    assert np.allclose(found[wanted > 0], wanted[wanted > 0], atol=1e-9)
    assert np.array_equal(found > 0, wanted > 0)


ANGLES = [*np.linspace(0.01, 1.57, 200), 1e-8, np.pi / 4, np.pi / 3, np.pi / 2]
SIZES = [*10 ** RNG.uniform(-4, 4, 30), 1 / 3, 0.1, 7.0]


def exact(array):
    """The rational numbers that floats are."""
    return np.vectorize(Fraction, otypes=[object])(array)


@pytest.mark.parametrize("apex", [0.0, 0.1, -0.1, 1 / 3, -7.3e5, 2.0])
def test_the_proven_sector_lies_inside_the_named_one(apex):
    for theta in ANGLES:
        region = LMIRegion.sector(theta, apex)
        (sin, cos), (minus_cos, again) = region.beta
        assert (sin, cos) == (again, -minus_cos) and region.alpha[0, 1] == 0
        with ctx.workprec(300):
            proven, named = arb(sin) / arb(cos), arb(theta).tan()
            assert proven <= named, theta
            assert proven >= named * (1 - 1e-14 * (1 + named)), "needlessly small"
        for alpha in np.diag(exact(region.alpha)):
            tip = -alpha / (2 * Fraction(sin))
            assert Fraction(apex) * (1 - Fraction(np.sign(apex)) * 10**-15) <= tip
            assert tip <= Fraction(apex)


def test_the_proven_ellipse_lies_inside_the_named_one():
    for a, b, centre in zip(SIZES, SIZES[::-1], RNG.normal(0, 10, len(SIZES))):
        region = LMIRegion.ellipse(centre, a, b)
        a, b, centre = map(Fraction, (a, b, centre))
        (r, k), (_, again) = -exact(region.alpha)
        (_, plus), (minus, _) = exact(region.beta)
        x, y = plus + minus, plus - minus  # (x Re s - k)^2 + (y Im s)^2 < r^2
        assert r == again
        assert centre - a <= (k - r) / x and (k + r) / x <= centre + a
        assert b * (1 - Fraction(1, 10**6)) <= r / y <= b


def test_other_regions_are_proven_as_named():
    for x in SIZES:
        for region, alpha, beta in [
            (LMIRegion.half_plane(x), [[two(x)]], [[1]]),
            (
                LMIRegion.disk(x, -x / 3),
                -decimal([[x, -x / 3], [-x / 3, x]]),
                [[0, 1], [0, 0]],
            ),
            (
                LMIRegion.strip(-x, -x / 3),
                [[-two(x), 0], [0, two(x / 3)]],
                [[-1, 0], [0, 1]],
            ),
            (
                LMIRegion.horizontal_strip(x),
                [[-two(x), 0], [0, -two(x)]],
                [[0, 1], [-1, 0]],
            ),
        ]:
            assert np.allclose(region.alpha, np.array(alpha, float), rtol=1e-15)
            assert (decimal(region.alpha) >= np.array(alpha)).all()
            assert np.array_equal(region.beta, beta)


def decimal(array):
    """The rational numbers that proofs read: 0.1 is 1/10."""
    return np.vectorize(lambda x: Fraction(repr(float(x))), otypes=[object])(array)


def two(x):
    return 2 * Fraction(repr(float(x)))


@pytest.mark.parametrize("theta", [np.pi / 4 + 4e-13, np.pi / 4 + 1e-9, 1.0, 1e-8])
def test_an_angle_above_a_round_one_is_rounded_up(theta):
    """The words may only say an angle that isn't below the proven one."""
    claim = LMIRegion.sector(theta).claim()
    degrees = float(re.search(r"half-angle ([\d.]+) degrees", claim)[1])
    assert np.radians(degrees) >= theta * (1 - 1e-15)
    assert degrees - np.degrees(theta) < 0.0101
    assert "half-angle 45 degrees" in LMIRegion.sector(np.pi / 4).claim()


def test_a_region_of_ones_own_is_claimed_by_its_matrices():
    """Words that a user chose are no claim."""
    region = LMIRegion([[-20]], [[1]], "fast", "half-plane Re s < -100")
    assert region.claim() == (
        "its poles lie in the region alpha + beta s + beta' s* < 0, "
        "with alpha = [[-20]] and beta = [[1]]"
    )


@pytest.mark.parametrize("theta", RNG.uniform(0.01, 1.57, 50))
def test_the_angle_in_words_is_never_smaller_than_the_proven_one(theta):
    degrees = float(
        re.search(r"half-angle ([\d.]+) degrees", LMIRegion.sector(theta).text)[1]
    )
    assert -1e-9 <= degrees - np.degrees(theta) < 0.0101


def test_ellipse():
    region = LMIRegion.ellipse(-3, 2, 0.5)
    (found,) = region.distances(POINTS).values()
    x, y = POINTS.real, POINTS.imag
    assert np.array_equal(found > 0, ((x + 3) / 2) ** 2 + (2 * y) ** 2 < 1)
    for s, d in zip(POINTS[found > 0], found[found > 0]):
        circle = s + 0.999 * d * np.exp(1j * np.linspace(0, 6.3, 50))
        assert region.contains(circle)


@pytest.mark.slow
def test_intersection():
    region = PoleRegion(0.7, np.pi / 4, 5) & LMIRegion.strip(-3, -1)
    points = POINTS[:300]
    x, y = points.real, abs(points.imag)
    wanted = (x < -1) & (x > -3) & (y < -x) & (abs(points) < 5)
    assert np.array_equal(wanted, [region.contains(s) for s in points])
    assert 0 < wanted.sum() < len(points)


def test_parts_with_one_name_are_all_kept():
    region = LMIRegion.disk(5) & LMIRegion.disk(2, -3) & PoleRegion(rho=9)
    assert len(region.distances([-3])) == 3
    assert not region.contains([0])
    d = sos.design_pid(sos.SecondOrderSystem([[1]], [[1]], [[1]], [[1]]), region=region)
    assert len(d.margins) == 5
    assert region.contains(d.poles())


def test_every_part_binds_in_a_design():
    """One more half-plane moves the poles behind both."""
    plant = sos.SecondOrderSystem([[1]], [[1]], [[1]], [[1]])
    near, far = LMIRegion.half_plane(1), LMIRegion.half_plane(30)
    for region in (near & far, far & near):
        poles = sos.design_pid(plant, region=region).poles()
        assert poles.real.max() < -30


@pytest.mark.parametrize(
    "region",
    [
        LMIRegion([[2]], [[-1]], "half-plane"),  # Re s > 1
        LMIRegion.strip(1, 2),
        LMIRegion.disk(1, 3),
    ],
)
def test_right_half_plane_regions_are_infeasible(region):
    """Stability is demanded whatever a region is called."""
    plant = sos.SecondOrderSystem([[1]], [[1]], [[1]], [[1]])
    assert sos.design_pid(plant, region=region).status == "infeasible"


@pytest.mark.parametrize(
    "region",
    [
        LMIRegion.horizontal_strip(0.1),
        LMIRegion.half_plane(-5),
        LMIRegion.sector(0.3, apex=2),
        LMIRegion.disk(5, 3),
    ],
)
def test_regions_that_reach_right_still_give_stable_loops(region):
    plant = sos.SecondOrderSystem([[1]], [[-1]], [[1]], [[1]])
    d = sos.design_pid(plant, region=region)
    assert d.poles().real.max() < 0
    assert region.contains(d.poles())
    assert d.certify().proven


@pytest.mark.parametrize(
    "region",
    [
        LMIRegion.disk(1, -100),
        LMIRegion.disk(0.01, -1),
        LMIRegion.sector(0.01),
        LMIRegion.ellipse(-50, 1, 5),
        PoleRegion(sigma=1000),
        PoleRegion(sigma=1e-6),
        PoleRegion(theta=np.pi / 2),
        PoleRegion(rho=1e4, theta=0.1),
    ],
)
def test_small_and_far_regions(region):
    plant = sos.SecondOrderSystem([[1]], [[1]], [[1]], [[1]])
    d = sos.design_pid(plant, region=region)
    assert region.contains(d.poles())
    assert d.certify(12).proven


@pytest.mark.parametrize(
    "make, words",
    [
        (lambda: PoleRegion(), "needs sigma, theta or rho"),
        (lambda: PoleRegion(sigma=-1), "sigma = -1 is negative"),
        (lambda: PoleRegion(sigma=np.nan), "sigma must be a finite"),
        (lambda: PoleRegion(theta=45), "half-angle of the sector, in radians"),
        (lambda: PoleRegion(theta=0), "theta = 0.0 is outside"),
        (lambda: PoleRegion(rho=0), "rho must be positive"),
        (lambda: PoleRegion(rho="5"), "rho must be a finite number"),
        (lambda: PoleRegion(rho=1j), "rho must be a finite number"),
        (lambda: PoleRegion(sigma=5, rho=5), "the region is empty"),
        (lambda: LMIRegion.strip(-1, -2), "left = -1.0 must be below"),
        (lambda: LMIRegion.horizontal_strip(-1), "omega must be positive"),
        (lambda: LMIRegion.ellipse(0, 0, 1), "a must be positive"),
        (lambda: LMIRegion.ellipse(-1, 1e-12, 1), "too thin, or too small"),
        (lambda: LMIRegion.disk(1, np.inf), "centre must be a finite"),
        (lambda: LMIRegion([[0, 1], [0, 0]], np.eye(2), "r"), "alpha must be sym"),
        (lambda: LMIRegion([[0]], np.eye(2), "r"), "beta has 2 rows"),
        (lambda: LMIRegion([[-1]], [[0]], "r"), "beta is zero"),
        (lambda: LMIRegion([[-1]], [[1]], "<b>"), "name = '<b>'"),
        (lambda: LMIRegion([[-1]], [[1]], ""), "name = ''"),
        (lambda: Region(()), "parts is empty"),
        (lambda: Region(["disk"]), "parts must be LMIRegion"),
    ],
)
def test_bad_regions_are_refused(make, words):
    with pytest.raises(ValueError, match=words):
        make()


def test_intersection_with_something_else_is_refused():
    with pytest.raises(TypeError):
        LMIRegion.disk(1) & 3


@pytest.mark.parametrize("w", [1e-6, 1e-3, 1e3, 1e6, *ODD])
def test_an_ellipse_has_its_unit_in_alpha_alone(w):
    """The scalar of the slack LMIs is shared by all blocks, which have none."""
    one, other = LMIRegion.ellipse(-3, 2, 0.5), LMIRegion.ellipse(-3 * w, 2 * w, w / 2)
    np.testing.assert_allclose(other.beta, one.beta, rtol=1e-12)
    np.testing.assert_allclose(other.alpha, w * one.alpha, rtol=1e-12)
    assert abs(one.beta).max() == 1
    circle, disk = LMIRegion.ellipse(-3, 2, 2), LMIRegion.disk(2, -3)
    np.testing.assert_allclose(circle.alpha, disk.alpha, rtol=1e-13)
    assert np.array_equal(circle.beta, disk.beta)


@pytest.mark.parametrize("w", by_turns([1e-3, 1.0, 1e3, *ODD], 0, of=3))
def test_an_ellipse_with_a_slack_matrix_is_judged_alike_in_any_unit(w):
    plants = sos.Polytope(
        [
            sos.SecondOrderSystem(1 / w**2, d / w, s, 1)
            for d, s in ((0.4, 0.7), (0.5, 0.7), (0.4, 0.8))
        ]
    )
    region = LMIRegion.ellipse(-12.6 * w, 10 * w, 5 * w)
    design = sos.design_pid(plants, coupling="slack", region=region)
    assert design.status == "feasible" and design.certify().proven
