"""Advice names the region that gives way, and a number that works."""

import re

import numpy as np
import pytest

import sosbook as sos

DISK = sos.LMIRegion.disk
CARTS = sos.Polytope([sos.SecondOrderSystem(m, 0.1, 9.81, 1) for m in (0.3, 3)])


def ticking(a):
    return sos.DescriptorSystem(
        np.eye(2), [[a, 0.9], [-0.3, 1.1]], [[0.2], [1]], dt=0.1
    )


@pytest.mark.parametrize(
    "plant, asked, eased",
    [
        (CARTS, lambda rho: sos.PoleRegion(sigma=1, theta_deg=50, rho=rho), 4.0),
        (sos.Uncertain(ticking, a=(0.4, 1.4)), DISK, 0.2),
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
        return sos.design_pid(plants, law=law, region=region)

    told = re.search(r"sector angle theta that was found is ([\d.]+)", asked(75).advice)
    assert 78.9 < float(told[1]) < 80
    assert asked(float(told[1]) + 0.1).certify().proven
