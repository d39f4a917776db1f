"""Advice names the region that gives way, and a number that works."""

import re

import numpy as np
import pytest

import sosbook as sos
from tests.cases import later

DISK = sos.LMIRegion.disk
CARTS = sos.Polytope([sos.SecondOrderSystem(m, 0.1, 9.81, 1) for m in (0.3, 3)])


def ticking(a):
    return sos.DescriptorSystem(
        np.eye(2), [[a, 0.9], [-0.3, 1.1]], [[0.2], [1]], dt=0.1
    )


@pytest.mark.parametrize(
    "plant, asked, eased",
    [
        (sos.Uncertain(ticking, a=(0.4, 1.4)), DISK, 0.2),
        *later((CARTS, lambda x: sos.PoleRegion(sigma=1, theta_deg=50, rho=x), 4.0)),
    ],
)
def test_the_number_of_the_advice_has_a_design_and_a_harder_one_none(
    plant, asked, eased
):
    d = sos.design_pid(plant, region=asked(eased))
    assert d.status == "infeasible"
    told = float(re.search(r"rho = ([\d.]+) there is a design", d.advice)[1])
    assert sos.design_pid(plant, region=asked(told)).certify().proven
    hard = float(eased + 0.7 * (told - eased))
    assert sos.design_pid(plant, region=asked(hard)).status != "feasible"


def test_the_angle_that_a_law_reaches_is_told():
    """Two inertias and a PI of the motor: theory has 78.9 degrees for the worst."""

    def drive(J):
        A = [[0, -3.6, 0], [1, 0, -1], [0, 3.6, 0]]
        return sos.DescriptorSystem(np.diag([1e-3, 1, J * 1e-3]), A, [[1], [0], [0]])

    law = sos.PIDLaw(position=[[1, 0, 0]], integrate=True)
    plants = sos.Uncertain(drive, J=(0.5, 2))

    def asked(degrees):
        region = sos.LMIRegion.sector(np.radians(degrees))
        few = sos.Search(starts=2)
        return sos.design_pid(plants, law=law, region=region, search=few)

    told = re.search(r"sector angle theta that was found is ([\d.]+)", asked(75).advice)
    assert 78.9 < float(told[1]) < 80
    assert asked(float(told[1]) + 0.1).certify().proven


FLYWHEEL = sos.SecondOrderSystem([[0.3]], [[0.02]], [[0]], [[9.81]])
BRIDGE = sos.SecondOrderSystem(  # hardly damped, unsymmetric; the deck alone is pushed
    np.diag([9.81, 0.3]), [[0.03, -0.01], [-0.02, 0.01]], [[30, -3], [-3, 3]],
    [[1], [0]], [[0], [1]],
)  # fmt: skip
VALVE = sos.DescriptorSystem(  # its force is late
    np.diag([1.0, 1, 0.3]), [[0, 1, 0], [-3, -0.03, 9.81], [0, 0, -1]], [[0], [0], [1]]
)


@pytest.mark.parametrize(
    "plant, sigma, rho, u_max, x0",
    [(BRIDGE, 0.3, 9, 1, [0, 0.3, 0, 0]),
     *later((FLYWHEEL, 9, 30, 1, [0.3, 0]), (VALVE, 3, 30, 0.3, [1, 0, 0]))],
)  # fmt: skip
def test_each_bound_that_gives_way_has_a_number(plant, sigma, rho, u_max, x0):
    """What is told has a design, and what is a third nearer to what was asked none."""

    def made(sigma, u_max):
        most = sos.Saturation(u_max, x0)
        return sos.design_pid(plant, region=sos.PoleRegion(sigma, rho=rho),
                              saturation=most)  # fmt: skip

    refused = made(sigma, u_max)
    assert refused.status == "infeasible"
    assert "advice says what to change" in str(refused.certify())
    most, fast = (
        float(re.search(rf"With .*?{name} = ([\d.]+) there is", refused.advice)[1])
        for name in ("u_max", "sigma")
    )
    assert made(sigma, most).certify().proven
    assert made(fast, u_max).certify().proven
    assert made(sigma, most ** (2 / 3) * u_max ** (1 / 3)).status != "feasible"
    assert made(fast ** (2 / 3) * sigma ** (1 / 3), u_max).status != "feasible"


def test_where_no_bound_gives_way_alone_all_do_together():
    def made(sigma, u_max, gamma):
        most = sos.Saturation(u_max, [0, 0.3, 0, 0])
        region = sos.PoleRegion(sigma, rho=9)
        return sos.design_pid(BRIDGE, region=region, saturation=most, gamma=gamma)

    refused = made(0.3, 1.0, 0.3)
    assert refused.status == "infeasible"
    told = re.search(r"With (.*) there is a design \(asked", refused.advice)[1]
    several = {x.split()[-3]: float(x.split()[-1]) for x in told.split(" and ")}
    assert set(several) == {"sigma", "u_max", "gamma"}
    assert made(**several).certify().proven


def test_a_stiff_pair_is_refused_by_its_lmis_and_a_gain_of_it_is_proven():
    """The word is of what was asked: the LMIs of the family, and not of every gain."""
    springs = 9.81, 98.1
    plants = sos.Polytope([sos.SecondOrderSystem(0.3, 0.02, k, 1) for k in springs])
    poles = np.array([np.roots([0.3, 3.02, k + 3]) for k in springs])  # u = -3 z - 3 z'
    theta = np.arctan2(abs(poles.imag), -poles.real).max()
    room = 1.03
    region = sos.PoleRegion(
        -poles.real.max() / room, theta=room * theta, rho=room * abs(poles).max()
    )
    assert sos.analyse_pid(plants, [[-3, -3]], region=region).certify().proven
    refused = sos.design_pid(plants, region=region)
    assert refused.status == "infeasible"
    assert "these LMIs of the family, not every gain" in refused.reason
