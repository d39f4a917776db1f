"""Observers by where the poles of their error lie, and norms of their loops."""

import control
import numpy as np
import pytest

import sosbook as sos

A = np.array([[0, 1, 0], [0, -1, 1], [0, 0, -20.0]])
SEEN = np.eye(2, 3)
REGION = sos.PoleRegion(sigma=39, rho=60)


def loop_poles(A, B, K, L, C):
    """Of x and x^, written out."""
    return np.linalg.eigvals(np.block([[A, B @ K], [-L @ C, A + B @ K + L @ C]]))


def test_the_error_s_poles_lie_where_they_are_asked():
    """scipy's place has them there, and noise leaves one at a zero, -20."""
    B = np.array([[0], [0], [1.0]])
    plant = sos.DescriptorSystem(np.eye(3), A, B, B, C=SEEN)
    K = -control.place(A, B, [-3, -4, -30])
    found = sos.design_observer(plant, K, region=REGION)
    error = np.linalg.eigvals(A + found.L @ SEEN)
    assert found.status == "feasible" and REGION.contains(error)
    assert found.certify().proven and "memory" in found.certify().claims[0]
    both = np.sort(loop_poles(A, B, K, found.L, SEEN).real)
    assert np.allclose(np.sort(found.poles().real), both, atol=1e-5)
    assert np.allclose(both, np.sort([*error.real, -3, -4, -30]), atol=1e-4)
    true = found.loop.norm()
    for share in (1.02, 0.98):  # a norm of the loop with the observer
        proof = found.loop.prove(sos.HInfinity(float(share * true)))
        assert proof.proven == (share > 1)


def test_a_motor_whose_load_nobody_sees_keeps_what_is_asked():
    plants = sos.Polytope(
        sos.SecondOrderSystem(
            np.diag([1, J]), 0.1 * np.eye(2), [[9.81, -9.81], [-9.81, 9.81]], [[1], [0]]
        )
        for J in (0.9, 1.1)
    )
    K = sos.design_pid(plants, region=sos.PoleRegion(0.2, rho=20)).K
    C = [[1, 0, 0, 0]]
    asked = sos.PoleRegion(sigma=2, rho=60)
    found = sos.design_observer(plants, K, region=asked, C=C)
    for d in [p for one in plants.vertices for p in sos.plants.descriptors(one)]:
        flow = np.linalg.solve(d.E, d.A)
        assert asked.contains(np.linalg.eigvals(flow + found.L @ np.array(C)))
    assert found.certify().proven


def test_an_observer_at_ticks_is_one_of_its_clock():
    F = np.array([[1, 0.05], [0, 0.98]])
    G = np.array([[0], [0.05]])
    axis = sos.DescriptorSystem(np.eye(2), F, G, G, C=[[1, 0]], dt=0.05)
    K = sos.design_lqr(axis, np.eye(2), [[0.1]]).K
    disk = sos.LMIRegion.disk(0.4)
    found = sos.design_observer(axis, K, region=disk)
    c = found.controller()
    assert c.dt == 0.05 and found.certify().proven
    loop = np.block([[F, G @ c.C], [c.B @ axis.C, c.A]])
    z = np.linalg.eigvals(loop)
    own = np.linalg.eigvals(F + G @ K)
    rest = [x for x in z if abs(own - x).min() > 1e-6]
    assert len(rest) == 2 and disk.contains(rest)
    assert np.allclose(np.sort(abs(found.poles())), np.sort(abs(z)), atol=1e-6)
    again = sos.Loop(axis, c)
    assert np.allclose(np.sort(abs(again.poles())), np.sort(abs(z)), atol=1e-6)
    with pytest.raises(ValueError, match="ticks are of 0.05 s"):
        sos.Loop(axis, control.ss(c.A, c.B, c.C, c.D, 0.1, inputs=["x1"], outputs="u"))


def test_what_is_not_seen_and_what_is_missing_is_said():
    blind = sos.DescriptorSystem(
        np.eye(2), [[-1, 0], [0, 1]], [[1], [1]], C=[[1, 0]], dt=None
    )
    found = sos.design_observer(blind, [[0, -2]], region=sos.PoleRegion(0.1))
    assert found.status == "infeasible" and "transposed" in found.reason
    for given in (dict(), dict(Q_F=np.eye(4), region=REGION)):
        with pytest.raises(ValueError, match="give"):
            sos.design_observer(blind, [[0, -2]], **given)


def drive(unit, force):
    """A motor, a shaft and a load that is known to 30 %; one encoder, on the motor."""

    def builder(J):
        M, D = np.diag([0.0025, J]) * unit, [[0.011, -0.01], [-0.01, 0.01]]
        S = [[20, -20], [-20, 20]]
        return sos.SecondOrderSystem(M, D, S, [[force], [0]], np.eye(2))

    return sos.Uncertain(builder, J=(0.003 / unit, 0.0045 / unit))


@pytest.mark.parametrize("reduced", [False, True])
@pytest.mark.parametrize(
    "unit, force, load", [(1, 1, True), (0.3, 9.81, [[0], [0], [0.3], [9.81]])]
)
def test_a_load_that_stays_is_estimated_and_leaves_no_error(unit, force, load, reduced):
    """Rest: x = -A^-1 B_d d of plant and observer, written out for other loads J."""
    plants = drive(unit, force)
    large = sos.Saturation(20 / force, [1, 1, 0, 0])
    K = sos.design_pid(plants, region=sos.PoleRegion(8), saturation=large).K
    seen = np.array([[1.0, 0, 0, 0]])
    ask = dict(region=sos.PoleRegion(sigma=15), C=seen, reduced=reduced)
    for given, q in ((load, 5), (None, 4)):
        found = sos.design_observer(plants, K, disturbance=given, **ask)
        assert found.status == "feasible" and found.certify().proven
        c = found.controller()
        assert c.nstates == q - reduced and bool(np.any(c.D)) == reduced
        for J in np.linspace(
            *(float(x[0]) for x in (plants.box.low, plants.box.high)), 5
        ):
            (d,) = sos.plants.descriptors(plants.at(J=J))
            A, B, W = d.state_space()
            rows = [[A + B @ c.D @ seen, B @ c.C], [c.B @ seen, c.A]]
            loop = np.block(rows)
            assert np.linalg.eigvals(loop).real.max() < 0
            push = np.vstack([W @ [[0.3], [1]], np.zeros((len(c.A), 1))])
            rest = -np.linalg.solve(loop, push)
            still = abs(rest[0, 0]) < 1e-7 * abs(rest[:4]).max()
            assert still == (given is not None)


def test_the_poles_of_an_observer_of_loads_are_apart():
    """Of one plant: those of A + B K, and those of the error, where they were asked."""
    plant = drive(0.3, 9.81).at(J=0.011)
    K = sos.design_lqr(plant, np.eye(4), [[0.1]]).K
    (d,) = sos.plants.descriptors(plant)
    A, B, _ = d.state_space()
    region = sos.PoleRegion(sigma=12, rho=300)
    for reduced in (False, True):
        found = sos.design_observer(
            plant, K, region=region, C=[[1, 0, 0, 0]], disturbance=True, reduced=reduced
        )
        rest = list(found.poles())
        for s in np.linalg.eigvals(A + B @ K):
            rest.remove(min(rest, key=lambda x: abs(x - s)))
        assert len(rest) == len(found.L) and region.contains(np.array(rest))
    r = found.simulate(np.linspace(0, 60, 4), w=sos.Step([2.0, 0]))
    assert abs(r.z[0, -1]) < 1e-6 and np.isclose(r.estimate[-1, -1] * 9.81, 2)
    assert np.allclose(r.estimate[:4, -1], r.x[:, -1], atol=1e-6)
    code = found.loop.at(T=1e-3).controller
    assert code.certify().proven and len(code.A) == 4


def test_a_load_at_ticks_leaves_no_error():
    F, G = np.array([[1, 0.05], [0, 0.98]]), np.array([[0], [0.05]])
    axis = sos.DescriptorSystem(np.eye(2), F, G, G, C=[[1, 0]], dt=0.05)
    K = sos.design_lqr(axis, np.eye(2), [[0.1]]).K
    disk = sos.LMIRegion.disk(0.6)
    found = sos.design_observer(axis, K, region=disk, disturbance=True)
    c, x, s = found.controller(), np.zeros((2, 1)), np.zeros((3, 1))
    assert found.certify().proven and c.dt == 0.05
    for _ in range(600):
        u, s, y = c.C @ s, c.A @ s + c.B @ (axis.C @ x), axis.C @ x
        x = F @ x + G @ (u + 9.81)
    assert abs(y) < 1e-9 and np.isclose(s[-1], 9.81)


@pytest.mark.parametrize(
    "more, words",
    [
        (dict(region=REGION, disturbance=np.zeros((3, 0))), "has no column"),
        (dict(region=REGION, disturbance=[[1], [0]]), "disturbance has 2 rows"),
        (dict(region=REGION, disturbance=[[1], [0], [0]]), "no u keeps what"),
        (dict(region=REGION, reduced=1), "reduced must be True or False"),
        (dict(region=REGION, C=np.eye(3), reduced=True), "all of the state"),
        (dict(region=REGION, C=np.ones((2, 3)), reduced=True), "depend on each other"),
        (dict(Q_F=np.eye(6), R_F=np.eye(2), reduced=True), "need a region"),
    ],
)
def test_what_an_observer_of_loads_cannot_do_is_said(more, words):
    B = np.array([[0], [0], [1.0]])
    plant = sos.DescriptorSystem(np.eye(3), A, B, B, C=SEEN)
    with pytest.raises(ValueError, match=words):
        sos.design_observer(plant, [[0, 0, -1]], **more)
    if words.endswith("region"):
        found = sos.design_observer(plant, [[0, 0, -1]], region=REGION, reduced=True)
        with pytest.raises(ValueError, match="observer of x alone"):
            found.analyse()


def test_more_loads_than_sensors_are_not_told_apart():
    gantry = sos.SecondOrderSystem(
        [[1.7, 0.25], [0.25, 0.42]], [[0.03, 0.2], [-0.2, 0.02]],
        [[3.1, -1.2], [-0.8, 4.1]], [[1, 0.1], [0, 0.6]],
    )  # fmt: skip
    K = sos.design_pid(gantry, region=sos.PoleRegion(sigma=1)).K
    asked = dict(region=sos.PoleRegion(sigma=2), disturbance=True)
    blind = sos.design_observer(gantry, K, C=[[1, 0, 0, 0]], **asked)
    assert blind.status == "infeasible" and blind.infeasibility is None
    assert "2 loads that stay aren't told apart by 1 of the readings" in blind.reason
    both = sos.design_observer(gantry, K, C=np.eye(2, 4), **asked)
    assert both.certify().proven and both.reason == ""
