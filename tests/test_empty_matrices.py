"""Zero and empty matrices are plants like others, below and above CG's twenty DOF."""

from itertools import product

import numpy as np
import pytest

import sosbook as sos
from tests.cases import campaign, crossed, later
from tests.closed import analyse_loop

NO_INPUT = {
    "one": np.zeros((1, 1)),
    "two": np.zeros((1, 2)),
    "one of two": np.array([[1.0, 0.0]]),
    "two alike": np.array([[1.0, 1.0]]),
    "two that differ by a factor": np.array([[0.3, 1 / 9.81]]),
}


def still(n, B=None, F=None, damping=0.1):
    """Masses on springs of their own, which come to rest without any input."""
    B = np.zeros((n, 1)) if B is None else B
    return sos.SecondOrderSystem(
        np.eye(n), damping * np.eye(n), np.diag(np.arange(1.0, n + 1)), B, F
    )


def proven(design):
    assert design.status == "feasible", design.reason
    assert design.certify().proven
    return design


@pytest.mark.parametrize(
    "n, name",
    [*crossed([1, 9, 11, 22], NO_INPUT), *later(*product([3, 19, 20], NO_INPUT))],
)
def test_inputs_that_move_nothing_or_the_same(n, name):
    B = np.ones((n, 1)) @ NO_INPUT[name]
    design = proven(sos.design_pid(still(n, B)))
    if not B.any():
        assert not design.K.any()
    if name == "one of two":
        assert np.abs(design.K[1]).max() <= 1e-9 * np.abs(design.K[0]).max()


ASKED = {
    "a region": dict(region=sos.PoleRegion(sigma=0.02, rho=30)),
    "an input": dict(saturation=sos.Saturation(1, [1.0])),
    "the least input": dict(saturation=sos.Saturation(None, [1.0]), minimize="u_max"),
    "the least norm": dict(minimize="gamma"),
    "nothing to integrate": dict(U=np.zeros((0, 1))),
    "a norm": dict(gamma=1e3),
    "slack": dict(coupling="slack"),
}
LARGE = ("slack", 20), ("the least norm", 20)


@pytest.mark.parametrize(
    "name, n",
    [
        *(x for x in product(ASKED, (1, 20)) if x not in LARGE),
        *later(*LARGE, *product(ASKED, (19,))),
    ],
)
def test_nothing_can_be_moved_and_nothing_need_be(name, n):
    asked = dict(ASKED[name])
    if "saturation" in asked:
        start = sos.Saturation(asked["saturation"].u_max, np.ones(2 * n))
        asked["saturation"] = start
    if "U" in asked:
        asked["U"] = np.zeros((0, n))
    design = proven(sos.design_pid(still(n, F=np.eye(n)[:, :1]), **asked))
    assert not design.K.any()


@pytest.mark.parametrize("n", [1, 19, 20])
def test_a_mode_that_nothing_moves_is_a_refusal(n):
    design = sos.design_pid(still(n), region=sos.PoleRegion(sigma=0.2))
    assert design.status == "infeasible" and design.infeasibility.proven


@pytest.mark.parametrize("n", [1, 20, *campaign([19])])
def test_several_plants_regulators_and_loops_without_an_input(n):
    plants = sos.Polytope([still(n), still(n, damping=0.2)])
    for coupling in ("pairs", "vertices"):
        assert not proven(sos.design_pid(plants, coupling=coupling)).K.any()
    proven(sos.analyse_pid(still(n), np.zeros((1, 2 * n))))
    assert not proven(sos.design_lqr(still(n), np.eye(2 * n), [[1]])).K.any()
    decay = -np.diag(np.arange(1.0, n + 1))
    proven(analyse_loop(np.eye(n), decay))
    proven(sos.design_pid(sos.DescriptorSystem(np.eye(n), decay, np.zeros((n, 1)))))


@pytest.mark.parametrize("n", [1, 20, *campaign([19])])
def test_a_disturbance_that_enters_nowhere_or_is_not_there(n):
    B, nowhere = np.eye(n)[:, :1], np.zeros((n, 1))
    assert proven(sos.design_pid(still(n, B, nowhere), gamma=1.0)).hinf() == 0
    proven(sos.design_pid(still(n, B, np.zeros((n, 0)))))
    with pytest.raises(ValueError, match="no F"):
        sos.design_pid(still(n, B, np.zeros((n, 0))), gamma=1.0)
    unseen = sos.DescriptorSystem(
        np.eye(n), -np.eye(n), B, np.eye(n)[:, :1], np.zeros((1, n))
    )
    assert proven(sos.design_pid(unseen, gamma=1.0)).hinf() == 0


def test_a_disturbance_that_enters_nowhere_has_the_least_norm_zero():
    design = sos.design_pid(still(2, np.eye(2), np.zeros((2, 1))), minimize="gamma")
    assert proven(design).hinf() == 0 and "least gamma is zero" in design.reason
