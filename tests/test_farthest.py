"""How far a parameter may go, against closed forms."""

import numpy as np
import pytest

import sosbook as sos
from sosbook.plants import descriptors
from sosbook.studies import maps

KEPT = dict(region=sos.PoleRegion(sigma=0.25))


def cart(m):
    return sos.SecondOrderSystem(m, 0.1, 1, 1)


def worst(m, K=((-3, -2),)):
    """The decay rate of the slowest pole."""
    (d,) = descriptors(cart(m))
    return -np.linalg.eigvals(np.linalg.solve(d.E, d.A + d.Bu @ np.array(K))).real.max()


def test_a_known_gain_reaches_its_true_end():
    plants = sos.Uncertain(cart, m=(0.5, 1))
    found = maps.farthest(plants, "m", [[-3, -2]], **KEPT)
    assert worst(found.reached) > 0.25 >= worst(found.beyond) - 1e-12
    assert found.beyond - found.reached < 0.011 and found.design.certify().proven
    assert found.refused.infeasibility.proven and not found.reason


def test_the_low_end_is_moved_too():
    """m s^2 + 2.1 s + 4: from 2 s on the fast pole of a light cart is in the disk."""
    plants = sos.Uncertain(cart, m=(0.5, 1))
    disk = dict(region=sos.PoleRegion(rho=6))
    found = maps.farthest(plants, "m", [[-3, -2]], end="low", **disk)
    sizes = [np.abs(np.roots([m, 2.1, 4])).max() for m in (found.reached, found.beyond)]
    assert sizes[0] < 6 <= sizes[1] + 1e-12 and found.beyond < found.reached


def test_a_design_goes_farther_than_a_gain():
    plants = sos.Uncertain(cart, m=(0.5, 1))
    limit = sos.Saturation(4.0, [1, 0])
    found = maps.farthest(plants, "m", digits=2, **KEPT, saturation=limit)
    assert found.reached > 1 and found.design.certify().proven
    assert found.design.request.plant.family.box.high[0] > 1
    assert found.refused.status == "infeasible"


def test_what_has_no_end_says_so():
    plants = sos.Uncertain(lambda k: sos.SecondOrderSystem(1, 1, k, 1), k=(1, 2))
    found = maps.farthest(plants, "k", [[0, 0]])
    assert found.beyond is None and found.reached > 1000 and found.reason


def test_a_mass_that_vanishes_is_an_end():
    plants = sos.Uncertain(lambda m: sos.SecondOrderSystem(2 - m, 1, 1, 1), m=(0, 1))
    found = maps.farthest(plants, "m", [[0, 0]], digits=2)
    assert 1 < found.reached < found.beyond <= 2.01 and found.design is not None


@pytest.mark.parametrize(
    "more, words",
    [
        (dict(name="q"), "no parameter"),
        (dict(end="up"), "end must be"),
        (dict(plants=cart(1)), "must be an Uncertain"),
    ],
)
def test_bad_words_are_named(more, words):
    asked = dict(plants=sos.Uncertain(cart, m=(0.5, 1)), name="m") | KEPT
    with pytest.raises(ValueError, match=words):
        maps.farthest(**asked | more)


def test_the_time_is_kept():
    plants = sos.Uncertain(cart, m=(0.5, 1))
    found = maps.farthest(plants, "m", [[-3, -2]], time_limit=1e-6, **KEPT)
    assert "stopped" in found.reason and found.reached is None
