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
