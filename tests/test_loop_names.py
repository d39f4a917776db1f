"""A loop is closed by names, in whatever order they come, never by widths alone."""

import re
from itertools import permutations

import control
import numpy as np
import pytest

import sosbook as sos
from sosbook.sampled import certify_sampled, furthest_sampled, sampled_loop

SPRUNG = sos.SecondOrderSystem(1, 0.05, 4, 1)
PID = sos.PIDLaw(position=[[1]], filter=0.3, integrate=True)
GAINS = {"K_P": [[2.0]], "K_D": [[-2.1]], "K_I": [[-0.7]]}
PAIR = sos.SecondOrderSystem(
    np.diag([1, 2.2046]), 0.3 * np.eye(2), [[2, -0.5], [0.3, 1]], np.eye(2)
)
STATES, INPUTS = ("z1", "z2", "z1'", "z2'"), ("u1", "u2")
ASKED = certify_sampled, furthest_sampled, sampled_loop


def answer(ask, plant, K, T=0.1):
    if ask is furthest_sampled:
        return ask(plant, K, T=(T, 2 * T), tolerance=0.2)
    return ask(plant, K, T)


def program(T=0.1):
    return sos.analyse_pid(SPRUNG, GAINS, law=PID).controller(T=T)


@pytest.mark.parametrize("ask", ASKED)
def test_a_set_point_is_no_velocity(ask):
    with pytest.raises(ValueError, match=r"set point of z1.*controller.certify"):
        answer(ask, SPRUNG, program().to_ss())


def test_a_controller_is_taken_where_a_controller_is():
    c = program()
    assert certify_sampled(SPRUNG, c, 0.1).text == c.certify().text
    (F,) = sampled_loop(SPRUNG, c, 0.1)
    assert np.allclose(F, c.loops[0].F)
    furthest = furthest_sampled(SPRUNG, c, T=(0.1, 0.6), tolerance=0.02)
    assert 0.25 < furthest.T[1] < 0.35
    unstable = [certify_sampled(SPRUNG, c, T=(0.1, high)) for high in (0.35, 0.5)]
    assert "spectral radius is 1." in unstable[1].failed[0]
    assert not any(unstable)


def of_pair(states=STATES, inputs=INPUTS):
    """One controller with a memory, its signals in another order."""
    B = np.array([[0.3, -0.1, 0.2, 0.0]])
    D = np.array([[-1, 0.3, -0.8, 0.1], [0.2, -1, 0, -0.9]])
    C = np.array([[0.2], [-0.3]])
    columns, rows = [STATES.index(x) for x in states], [INPUTS.index(x) for x in inputs]
    at = [[0.4]], B[:, columns], C[rows], D[np.ix_(rows, columns)], 0.1
    return control.ss(*at, inputs=list(states), outputs=list(inputs))


@pytest.mark.parametrize("ask", ASKED)
def test_order_is_nothing_and_names_are_all(ask):
    known = answer(ask, PAIR, of_pair())
    for states in list(permutations(STATES))[1::5]:
        for inputs in permutations(INPUTS):
            found = answer(ask, PAIR, of_pair(states, inputs))
            if ask is sampled_loop:
                np.testing.assert_array_equal(found[0], known[0])
            else:
                assert found.text == known.text and known.proven
    for other in (
        dict(inputs=["z1", "z2", "z1'", "speed"], outputs=list(INPUTS)),
        dict(inputs=["z1", "z2", "z1'", "u[3]"], outputs=list(INPUTS)),
        dict(inputs=list(STATES), outputs=["u1", "y[1]"]),
        dict(inputs=list(STATES), outputs=["torque", "force"]),
    ):
        K = of_pair()
        with pytest.raises(ValueError, match="closed by the names"):
            answer(ask, PAIR, control.ss(K.A, K.B, K.C, K.D, 0.1, **other))


def test_what_nobody_named_is_taken_in_order_and_the_claim_says_which():
    K = of_pair()
    for names in ({}, dict(inputs=list(STATES)), dict(outputs=list(INPUTS))):
        proof = certify_sampled(PAIR, control.ss(K.A, K.B, K.C, K.D, 0.1, **names), 0.1)
        words = "where K makes u1, u2 of z1, z2, z1', z2', in this order, is stable"
        assert proof.proven and words in proof.claims[0]
        assert sos.sampled.SampledCertificate.of(proof.data).claims == proof.claims
    assert "order" not in certify_sampled(PAIR, K, 0.1).claims[0]


def test_a_point_in_a_name_is_python_controls_line():
    plant = sos.SecondOrderSystem(1, 0.2, 1, 1, coordinates=["z.1"])
    parts = [], [], [], [[-0.8, -1]], 0.1
    for inputs in (["z_1'", "z_1"], ["z_1", "z_1'"]):
        proof = certify_sampled(plant, control.ss(*parts, inputs=inputs), 0.1)
        assert proof.proven and "order" not in str(proof)
        assert proof.K.D[0, inputs.index("z_1")] == -0.8


def test_names_are_of_each_signal_or_none():
    for name in ("inputs", "outputs"):
        with pytest.raises(ValueError, match=re.escape(f"{name} must name each")):
            sos.sampled.SampledSystem([], [], [], [[1.0]], 0.1, **{name: ("a", "b")})
