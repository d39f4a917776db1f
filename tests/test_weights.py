"""The weight of a set point: own simulations keep to what is proven of it."""

import numpy as np
import pytest

import sosbook as sos
from tests.axis import drive
from tests.test_tubes import steps

LAW = sos.PIDLaw(position=[[1, 0]], integrate=True, filter=0.004)
GAINS = {"K_P": [[-4.0129]], "K_D": [[-0.199962]], "K_I": [[-23.2486]]}


def stiff(J2):
    return drive(J2, k=20)


@pytest.fixture(scope="module")
def encoder():
    """A motor's encoder, a load behind a shaft, a tick late: it overshoots by half."""
    plants = sos.Uncertain(stiff, J2=(0.003, 0.006))
    region = sos.PoleRegion(sigma=7.9)
    found = sos.analyse_pid(plants, GAINS, law=LAW, region=region)
    return found.controller(T=0.001, delay=0.001)


def loads(c, row=1):
    plants = [stiff(J2) for J2 in np.linspace(0.003, 0.006, 5)]
    return np.array([steps(c, plant, 0, 1.2, row) for plant in plants])


def test_the_step_of_a_drive_as_its_simulations_have_it(encoder):
    found, y = encoder.bounds.step_response(output="load"), loads(encoder)
    over = y.max() - 1
    late = max(np.flatnonzero(abs(one - 1) > 0.02)[-1] + 1 for one in y)
    u = abs(loads(encoder, None)).max()
    pairs = (found.overshoot, over), (found.effort[0], u), (found.peak, y.max())
    for bound, true in pairs:
        assert true <= bound.proven <= 1.005 * true
    assert late * encoder.T <= found.settling_time.proven <= (late + 2) * encoder.T
    assert 0.509 < found.overshoot.proven < 0.511
    assert "J2 = 0.006" in repr(found) and "overshoots by 46.3 %" in repr(encoder)
    info = pytest.importorskip("control").step_info
    times = encoder.T * np.arange(y.shape[1])
    for one in (info(y[0], times), info(y[-1], times)):
        assert one["Overshoot"] <= 100 * found.overshoot.proven + 0.1
        assert one["RiseTime"] <= found.rise_time.proven + encoder.T
        assert one["SettlingTime"] <= found.settling_time.proven + encoder.T


def test_a_weight_keeps_what_was_asked_of_every_plant(encoder):
    c = encoder.bounds.weights(0.05, 2.0, output="load")
    assert loads(c).max() <= 1.05 and abs(loads(c, None)).max() <= 2
    assert 0.3 < c.R[0, 0] < 0.5
    slower = encoder.set_point(b=c.R[0, 0] - 0.1)
    ends = [one.bounds.step_response(output="load") for one in (c, slower)]
    assert ends[0].settling_time.proven < ends[1].settling_time.proven
    assert (c.B == encoder.B).all() and c.D_r == pytest.approx(encoder.D_r * c.R)


def test_what_no_weight_does_is_refuted_and_no_other_one_is_found(encoder):
    with pytest.raises(ValueError, match="no b keeps to it.*J2 = .*by one program"):
        encoder.bounds.weights(0.05, 0.3, output="load")
    for b in np.linspace(-0.6, 1.2, 3):
        c = encoder.set_point(b=b)
        assert loads(c).max() > 1.05 or abs(loads(c, None)).max() > 0.3
    with pytest.raises(ValueError, match="overshoot must"):
        encoder.bounds.weights(-0.1)


def second_order(zeta):
    """A cart whose loop is nearly one of second order: with a fine clock."""
    cart = sos.SecondOrderSystem(0.3, 0.3 * 2 * zeta * 9.81, 0, 0.3)
    law = sos.PIDLaw(position=[[1]])
    found = sos.analyse_pid(
        cart, {"K_P": [[-(9.81**2)]]}, law=law, region=sos.PoleRegion(0.1)
    )
    return found.controller(T=1e-4)


@pytest.mark.parametrize("masses", [(1, 1 - 1e-9), (1 - 1e-9, 1)])
def test_of_plants_that_are_alike_the_first_is_named(masses):
    """Roundings of a processor would choose among them."""
    several = sos.Polytope(
        sos.SecondOrderSystem([[m]], [[0.3]], [[0]], [[1]]) for m in masses
    )
    law = sos.PIDLaw(position=[[1]], velocity=[[1]])
    found = sos.analyse_pid(
        several, {"K_P": [[-3]], "K_D": [[-1]]}, law=law, region=sos.PoleRegion(0.1)
    )
    bounds = found.controller(T=0.01).bounds.step_response()
    assert set(bounds.plants.values()) == {"vertex 1"}


@pytest.mark.parametrize("zeta", [0.3, 0.7])
def test_the_closed_form_of_a_second_order_step(zeta):
    found = second_order(zeta).bounds.step_response()
    over = np.exp(-np.pi * zeta / np.sqrt(1 - zeta**2))
    assert found.overshoot.proven == pytest.approx(over, rel=5e-3)
    assert found.overshoot.seen == pytest.approx(over, rel=5e-3)
    # it goes one way first: floats see none, and a proof can't tell it from none
    assert found.undershoot.seen < 1e-12 and "e-" not in repr(found)
    assert ", at the ticks, in 1 cells:" in repr(found)
    assert "undershoot: less than 0.001 % (0 but for rounding)\n" in repr(found)
    with pytest.raises(ValueError, match="nothing is integrated"):
        second_order(zeta).set_point(b=0.5)


def test_every_input_keeps_to_the_effort():
    """The second pushes three times as hard as the first one."""
    carts = sos.Uncertain(lambda m: sos.SecondOrderSystem(m, 0, 0, [[1, 1]]), m=(1, 2))
    K = np.outer([1, 3], [-3.0, -2.0, -1.0])
    design = sos.analyse_pid(carts, K, U=[[1]], region=sos.PoleRegion(sigma=0.1))
    c = design.controller(T=0.01)
    found = c.bounds.weights(0.5, 4.0).bounds.step_response()
    first, second = (bound.proven for bound in found.effort)
    assert 3 * first == pytest.approx(second, rel=1e-3) and second <= 4.0
    assert c.bounds.step(output=1).proven > 4.0  # with b = 1
