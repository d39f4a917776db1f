"""An entry of a law's gain is free, zero, shared, in a range, or a number."""

import re

import numpy as np
import pytest

import sosbook as sos
from tests.cases import later

LIGHT = sos.SecondOrderSystem(0.3, 0.02, 9.81, 1, [[1]])


def law(P, D, **more):
    return sos.PIDLaw([[1]], [[1]], structure={"K_P": [[P]], "K_D": [[D]]}, **more)


def norm(P, D):
    """The largest size of 1 / (.3 s^2 + (.02 - D) s + 9.81 - P) on the axis: with v for
    w^2 its inverse square is (k - .3 v)^2 + d^2 v, a parabola.
    """
    k, d = 9.81 - P, 0.02 - D
    v = max(0.0, (2 * 0.3 * k - d**2) / (2 * 0.3**2))
    return 1 / np.sqrt((k - 0.3 * v) ** 2 + d**2 * v)


@pytest.mark.parametrize(
    "P, D",
    [((-2, 3), (-0.5, 0)), ((7.5, 7.5), (None, -0.2)),
     *later(((None, 0), (-0.1, -0.1)), ((0, None), (-1, 1)), ((200, None), (None, 0)))],
)  # fmt: skip
def test_a_searched_gain_is_in_its_range_and_as_good_as_there_is(P, D):
    most = dict(K_P=300, K_D=1)
    d = sos.design_pid(
        LIGHT, law=law(P, D, limits=most), minimize="gamma", search=sos.Search(starts=3)
    )
    ends = [
        np.clip([-m if low is None else low, m if high is None else high], -m, m)
        for (low, high), m in zip((P, D), most.values())
    ]
    if P[0] == 200:  # negative stiffness: nothing there is stable
        assert d.status != "feasible"
        return
    grid = [np.linspace(*e, 41) for e in ends]
    stable = [(p, q) for p in grid[0] for q in grid[1] if p < 9.81 and q < 0.02]
    best = min(norm(p, q) for p, q in stable)
    (p,), (q,) = (np.ravel(d.gains[x]) for x in ("K_P", "K_D"))
    assert ends[0][0] <= p <= ends[0][1] and ends[1][0] <= q <= ends[1][1]
    assert d.certify().proven and norm(p, q) <= d.gamma <= 1.03 * best


def test_a_fixed_entry_is_no_reason_to_refuse_a_decay():
    """The poles' sum of z'' = u is moved by no K_P; by the fixed K_D it is."""
    cart = sos.SecondOrderSystem(1, 0, 0, 1)
    asked = dict(region=sos.PoleRegion(sigma=0.9))
    d = sos.design_pid(cart, law=law(1, (-2, -2)), **asked)
    assert d.status == "feasible" and d.gains["K_D"].tolist() == [[-2.0]]
    d = sos.design_pid(cart, law=law(1, 0), **asked)
    assert d.status == "infeasible" and d.infeasibility.proven


def test_ranges_hold_between_the_vertices_too():
    """A worst plant between the vertices joins the search, at no gain of the law."""

    def pendulum(a):
        return sos.SecondOrderSystem(1, 0.3, 1 + a**2, 1, [[1 - a]])

    plants = sos.Uncertain(pendulum, a=(-1, 1))
    d = sos.design_pid(
        plants,
        law=law((-3, -0.3), (-2, -2)),
        minimize="gamma",
        search=sos.Search(starts=2),
    )
    assert d.status == "feasible" and d.gains["K_D"].tolist() == [[-2.0]]
    assert -3 <= d.gains["K_P"].item() <= -0.3


@pytest.mark.parametrize("memory", ["filter", "order"])
def test_entries_hold_at_the_ticks(memory):
    if memory == "filter":
        form = {"K_P": [[(0.3, 0.3)]], "K_D": [[(None, 0)]]}
        one = sos.PIDLaw([[1]], filter=0.05, structure=form)
    else:
        form = {"A_c": [[(0.2, 0.4)]], "B_c": [[(1, 1)]]}
        one = sos.DynamicLaw(1, [[1]], structure=form)
    d = sos.design_sampled(LIGHT, one, T=0.02, search=sos.Search(starts=4))
    assert d.status == "feasible" and d.certify().proven
    for name, ((entry,),) in form.items():
        low, high = entry
        x = d.gains[name].item()
        assert (low is None or x >= low) and (high is None or x <= high)


def test_a_given_gain_is_one_of_the_law():
    some = law((-2, 3), (-0.1, -0.1))
    for gains in ([[1.0, -0.1]], {"K_P": [[1.0]]}):
        d = sos.analyse_pid(LIGHT, gains, law=some)
        assert d.gains["K_D"].tolist() == [[-0.1]] and d.status == "feasible"


WRONG = {
    "K_P has the entry 4, outside of the law's range": ((-2, 3), 1, [[4.0, 0]]),
    "isn't what the law's structure allows": (1, (0.3, 0.3), [[1.0, 0.2]]),
    "a range is .low, high.": ((3, -2), 1, None),
    "is .None, None.*take|a range is": ((np.nan, 2), 1, None),
    "a range is .low": ((1, 2, 3), 1, None),
    "up to 0.5, but structure asks": ((1, 2), 1, None),
}


@pytest.mark.parametrize("words", WRONG)
def test_wrong_entries_are_named(words):
    P, D, K = WRONG[words]
    with pytest.raises(ValueError, match=words):
        sos.analyse_pid(
            LIGHT,
            K or [[0, 0]],
            law=law(P, D, limits={"K_P": 0.5} if "up" in words else None),
        )


def test_the_nearest_gain_lies_in_its_ranges_and_says_what_it_reaches():
    """u = K y with K >= 0 only takes damping away; the nearest gain that a search saw
    was negative, and its decay of 0.24 was told as if the law allowed it.
    """
    plant = sos.SecondOrderSystem(
        np.diag([9.81, 0.3]), [[0.03, -0.02], [0.01, 0.01]], [[30, -3], [-2, 3]],
        [[1], [0]],
    )  # fmt: skip
    law = sos.PIDLaw(position=[[1, 0]], velocity=[[1, 0]], structure=[[(0, None)]])
    d = sos.design_pid(plant, law=law, region=sos.PoleRegion(sigma=0.1))
    assert d.status == "undecided"
    assert "an entry of K_D is 0, and may be 0 at least" in d.reason
    assert "structure= moves it" in d.reason
    (said,) = re.findall(r"sigma (\S+) \(asked", d.reason)
    best = -plant.poles().real.max()
    for k in np.geomspace(1e-4, 1e2, 25):
        for gains in ({"K_P": [[k]], "K_D": [[0]]}, {"K_P": [[0]], "K_D": [[k]]}):
            best = max(best, -sos.Loop(plant, law, gains).poles().real.max())
    assert 0 < float(said) < best + 0.01


def test_a_search_keeps_to_a_range_that_is_open_at_one_end():
    """A range from 0 was as wide as all gains, so that -43 was hardly beyond it: the
    search ended there, and 0 in its place broke what was asked.
    """
    plant = sos.SecondOrderSystem(
        [[0.9, 0.1], [0.1, 0.33]], [[0.02, 0.05], [-0.05, 0.01]],
        [[9.81, -2], [-1, 3.2373]], [[1, 0.2], [0, 0.7]],
    )  # fmt: skip
    positive, brake = (0, None), (None, 0)
    law = sos.PIDLaw(
        position=np.eye(2),
        filter=0.02,
        structure={"K_P": [[positive] * 2] * 2, "K_D": [[positive, 0], [0, brake]]},
    )
    d = sos.design_pid(plant, law=law, region=sos.PoleRegion(sigma=0.1))
    assert d.status == "feasible" and d.certify().proven
    assert (d.gains["K_P"] >= 0).all() and d.gains["K_D"][0, 0] >= 0
    assert d.gains["K_D"][1, 1] <= 0 and d.poles().real.max() < -0.1
