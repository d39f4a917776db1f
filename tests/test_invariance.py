"""Units and coordinates don't change a design: its gain transforms as a gain must.

A region alone leaves the set without a bound: there only units are tested.
"""

from functools import cache

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import sosbook as sos
from benchmarks.robustness import SYSTEMS, in_units
from tests.cases import by_turns, examples
from tests.random_plants import ODD, ODD_POWERS, Units, as_units, random_case

some = settings(max_examples=examples(2, 5), derandomize=True, deadline=None)
powers = st.floats(-6, 6)
seeds = st.integers(0, 10**6)

ROBOT = sos.SecondOrderSystem(
    M=np.diag([10, 11]),
    D=[[4, 1], [1, 5]],
    S=[[8, 4], [-4, 9]],
    B=np.eye(2),
    F=np.eye(2),
)
STIFFER = sos.SecondOrderSystem(
    M=ROBOT.M, D=1.2 * ROBOT.D, S=1.3 * ROBOT.S, B=ROBOT.B, F=ROBOT.F
)
HEAVIER = sos.SecondOrderSystem(
    M=1.2 * ROBOT.M, D=ROBOT.D, S=ROBOT.S, B=ROBOT.B, F=ROBOT.F
)
CART = sos.SecondOrderSystem(  # one input, unstable
    M=[[2, 1], [1, 1]],
    D=np.diag([0.1, 0]),
    S=np.diag([0, -3]),
    B=[[1], [0]],
    F=[[1], [0]],
)
LIGHT = sos.SecondOrderSystem(  # no mass in the second coordinate
    M=np.diag([2, 0]), D=np.eye(2), S=[[2, -1], [-1, 1]], B=[[0], [1]], F=[[1], [0]]
)
REGION = sos.PoleRegion(sigma=0.5, theta=np.pi / 3, rho=6)
START = [0.2, 0.1, 0, 0, 0, 0]

REQUESTS = {
    "gamma": (ROBOT, dict(U=np.eye(2), region=REGION, gamma=0.5)),
    "saturation": (
        ROBOT,
        dict(
            U=np.eye(2), region=REGION, gamma=0.5, saturation=sos.Saturation(60, START)
        ),
    ),
    "saturation without gamma": (
        ROBOT,
        dict(region=REGION, saturation=sos.Saturation(60, START[:4])),
    ),
    "polytope": (
        sos.Polytope([ROBOT, STIFFER]),
        dict(U=np.eye(2), region=REGION, gamma=0.5),
    ),
    "uncertain mass": (
        sos.Polytope([ROBOT, HEAVIER]),
        dict(region=REGION, gamma=0.5, saturation=sos.Saturation(90, START[:4])),
    ),
    "one input": (CART, dict(U=[[1, 0]], region=sos.PoleRegion(0.2, None, 8), gamma=8)),
    "singular mass": (
        LIGHT,
        dict(K_A=np.array([[0, -2.0]]), region=sos.PoleRegion(0.3, None, 8), gamma=5),
    ),
}
ENDLESS = {
    "region": (ROBOT, dict(region=REGION)),
    "region and integrators": (ROBOT, dict(U=np.eye(2), region=REGION)),
    "region of a polytope": (sos.Polytope([ROBOT, HEAVIER]), dict(region=REGION)),
}
UNPROVEN = {  # multipliers exclude all but enormous P, Y; none are exact
    "too little force": (
        CART,
        dict(
            region=sos.PoleRegion(0.2, None, 8),
            saturation=sos.Saturation(0.1, [0, 1, 0, 0]),
        ),
    )
}


def size(plant, asked):
    return plant.n, plant.m, len(asked.get("U", ()))


@cache
def plain(name):
    plant, asked = (REQUESTS | ENDLESS | UNPROVEN)[name]
    return sos.design_pid(plant, **asked)


def same_design(name, units, tolerance=1e-6):
    """The design in these units is the one in plain units."""
    plant, asked = (REQUESTS | ENDLESS)[name]
    here = plain(name)
    there = sos.design_pid(units.plant(plant), **units.requirements(asked))
    assert here.status == there.status == "feasible"
    back = units.Q @ there.K @ units.state
    assert np.abs(back - here.K).max() <= tolerance * np.abs(here.K).max()
    assert there.certify(9).proven


@pytest.mark.slow
@pytest.mark.parametrize("name", by_turns(REQUESTS | ENDLESS, 0))
@some
@example(*ODD_POWERS)
@given(powers, powers, powers, powers, powers)
def test_units(name, time, length, force, signal, integral):
    """Seconds, metres, newtons, volts, and those of the integrators."""
    plant, asked = (REQUESTS | ENDLESS)[name]
    there = as_units(
        plant, (time, length, force, signal, integral), len(asked.get("U", ()))
    )
    same_design(name, there, 1e-6 if name in REQUESTS else 1e-4)


@pytest.mark.slow
@pytest.mark.parametrize("name", by_turns(REQUESTS, 1))
@some
@given(seeds)
def test_coordinates(name, seed):
    """z -> T z, rows, inputs mixed; T turns where gamma measures, Q where u_max."""
    plant, asked = REQUESTS[name]
    n, m, a = size(plant, asked)
    rng = np.random.default_rng(seed)

    def rotation(k):
        return np.linalg.qr(rng.standard_normal((k, k)))[0]

    def regular(k):
        return rotation(k) * 10 ** rng.uniform(-1, 1, k) @ rotation(k)

    T = rotation(n) if "gamma" in asked else regular(n)
    Q = rotation(m) if "saturation" in asked else regular(m)
    same_design(name, Units(1.0, T, regular(n), Q, regular(a)))


@pytest.mark.slow
@pytest.mark.parametrize("name", UNPROVEN)
@some
@example(*ODD_POWERS[:4])
@given(powers, powers, powers, powers)
def test_what_is_not_proven_infeasible_is_feasible_in_no_units(
    name, time, length, force, signal
):
    """Each verdict says "infeasible" with a proof, else what is excluded."""
    plant, asked = UNPROVEN[name]
    units = as_units(plant, (time, length, force, signal, 0), 0)
    there = sos.design_pid(units.plant(plant), **units.requirements(asked))
    for design in (plain(name), there):
        assert design.status in ("infeasible", "undecided")
        assert design.K is None
        proven = design.infeasibility is not None and design.infeasibility.proven
        assert proven == (design.status == "infeasible")
        assert proven or "Exact multipliers exclude all P, Y" in design.reason


def test_only_a_fixed_mu_knows_the_unit_of_w():
    """With mu = 1, P is only the same if w keeps its energy: F sqrt(w0)."""
    plant, asked = REQUESTS["saturation"]
    units = Units(0.5, np.eye(2), np.eye(2), np.eye(2), np.eye(2))
    slow = units.plant(plant)
    careless = sos.SecondOrderSystem(slow.M, slow.D, slow.S, slow.B, plant.F)
    there = units.requirements(asked)
    louder = there | {"gamma": asked["gamma"]}
    for mu in (None, 1.0):

        def gain(plant, asked, mu=mu):
            bound = sos.HInfinity(asked["gamma"], mu=mu)
            return sos.design_pid(plant, **asked | {"gamma": bound}).K

        K, other, good = gain(plant, asked), gain(careless, louder), gain(slow, there)
        assert np.allclose(units.Q @ good @ units.state, K, rtol=1e-6)
        same = np.allclose(units.Q @ other @ units.state, K, rtol=1e-6)
        assert same == (mu is None)


@pytest.mark.parametrize("name", ["odd", *SYSTEMS])
def test_equations_in_another_order_than_the_coordinates(name):
    """M has a zero on its diagonal: no unit takes the place of that inertia."""
    case = random_case(12002, 6)
    assert (case.plant.M.diagonal() == 0).any()
    units = SYSTEMS.get(name, ODD)
    plant, asked = in_units(case, *units)
    here = sos.design_pid(case.plant, **case.requirements).poles()
    there = sos.design_pid(plant, **asked).poles() * units[0]
    assert np.abs(there - here).max() < 1e-4 * np.abs(here).max()
