"""A loop is closed by names, in whatever order they come, never by widths alone."""

import re
from itertools import permutations

import control
import numpy as np
import pytest

import sosbook as sos
from sosbook import pendulum
from sosbook.book.reproduction.gamma_bounds import gamma_lower_bounds
from sosbook.exact.checker import verdict
from sosbook.plants.gain import Gain
from sosbook.sampled import certify_sampled, furthest_sampled, sampled_loop
from sosbook.sampled.proof import by_balls
from tests.asking import asked_by, asking
from tests.hunt.tampering import verdicts

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
        words = "where K makes u1, u2 of z1, z2, z1', z2', in this order, with a tick"
        assert proof.proven and words in proof.claims[0]
        assert sos.sampled.SampledProof.of(proof.data).claims == proof.claims
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


ARMS = sos.SecondOrderSystem(
    PAIR.M, PAIR.D, PAIR.S, PAIR.B, coordinates=["arm", "a; b"]
)
FORGED = {  # names of K's signals that the plant hasn't, or not in this order
    "in another order": (["z2", "z1", "z1'", "z2'"], ["u1", "u2"]),
    "of nothing": (["speed", "torque", "x", "y"], ["u1", "u2"]),
    "twice": (["z1", "z1", "z1'", "z1'"], ["u1", "u2"]),
    "the outputs turned": ([*STATES], ["u2", "u1"]),
    "too few": (["z1"], ["u1", "u2"]),
    "no inputs": ([], ["u1", "u2"]),
    "no outputs": ([*STATES], []),
    "no sentence": (["z1. And", "z2", "z1. And'", "z2'"], ["u1", "u2"]),
}


@pytest.mark.parametrize("name", FORGED)
@pytest.mark.parametrize("certify", [certify_sampled, by_balls])
def test_names_of_a_file_are_the_plant_s(certify, name):
    """They were matched with nothing, and the words of an order were left out."""
    whole = asked_by(certify(PAIR, of_pair(), T=0.1))
    assert any(verdicts(asking(whole)))
    inputs, outputs = FORGED[name]
    whole["K"] = whole["K"] | dict(inputs=inputs, outputs=outputs)
    assert verdicts(asking(whole)) == (False, False)


def test_a_claim_says_what_the_coordinates_are_called():
    """So names that are exchanged throughout are another claim."""
    states = ["arm", "a; b", "arm'", "a; b'"]
    K = of_pair()
    K = control.ss(K.A, K.B, K.C, K.D, 0.1, inputs=states, outputs=list(INPUTS))
    proof = certify_sampled(ARMS, K, 0.1)
    assert proof.proven and proof.data["K"]["inputs"][1] == "a_ b"
    assert ", with z = [arm, a_ b], with a tick" in proof.claims[0]
    assert verdict.check(proof.text) == list(proof.claims)
    assert "with z" not in certify_sampled(PAIR, of_pair(), 0.1).claims[0]


REGION = dict(region=sos.PoleRegion(0.2))
NAMED = sos.SecondOrderSystem(
    np.diag([1, 2.2046]), 9.81 * np.eye(2), [[2, -0.5], [0.3, 1]], np.eye(2),
    F=[[1], [0]], coordinates=["arm", "tip"],
)  # fmt: skip
ROWS = [[1, 0], [0, 1], [0, 0], [0, 0]]
TAKERS = {
    "analyse_pid": lambda p, K: sos.analyse_pid(p, K, **REGION).K,
    "analyse_delay": lambda p, K: sos.analyse_delay(p, K, tau=0.01, delta=0.1).K,
    "certify_sampled": lambda p, K: certify_sampled(p, K, 0.01, digits=17).K,
    "sampled_loop": lambda p, K: sampled_loop(p, K, 0.01)[0],
    "sampled_cost": lambda p, K: sos.sampled.sampled_cost(
        p, K, np.eye(4), np.eye(2), 0.01
    ),
    "design_observer": lambda p, K: sos.design_observer(
        p, K, Q_F=np.eye(8, 4), R_F=np.eye(2), C=np.eye(2, 4)
    ).L,
    "observer_loop": lambda p, K: sos.observer_loop(
        p, K, np.eye(4, 2), np.eye(2, 4)
    ).vertices[0].A,
    "gamma_lower_bounds": lambda p, K: np.array(
        gamma_lower_bounds(p, K, saturation=sos.Saturation(1e4, [1, 0, 0, 0])).norm
    ),
    "simulate_nonlinear": lambda p, K: sos.simulate_nonlinear(
        p, lambda z, dz: 0 * z, K, [0, 0.5], x0=[1, 0, 0, 0]
    ).z,
}  # fmt: skip

OF_EVERY_LAW = dict(analyse_pid=4, analyse_delay=6, certify_sampled=4, sampled_loop=6)


@pytest.mark.parametrize("name", TAKERS)
def test_a_gain_that_knows_its_signals_is_taken_by_their_names(name):
    take, design = TAKERS[name], sos.design_pid(NAMED, **REGION)
    want = take(NAMED, design.K)
    order = [3, 1, 0, 2]
    names = [design.gain.signals[k] for k in order]
    shuffled = Gain(design.K[:, order], names)
    for K in (design, design.gain, design.gains, shuffled):
        np.testing.assert_array_equal(take(NAMED, K), want)
    other = Gain(design.K, ("arm", "tip", "arm'", "speed"))
    of_law = sos.design_pid(
        NAMED, law=sos.PIDLaw(np.eye(2), filter=0.1), region=sos.PoleRegion(0.05)
    )
    if name in OF_EVERY_LAW:  # its law comes along
        found = take(NAMED, of_law)
        assert np.shape(getattr(found, "D", found))[-1] == OF_EVERY_LAW[name]
    else:
        with pytest.raises(ValueError, match="Give law=.*design.controller"):
            take(NAMED, of_law)
    for K, words in (
        (other, "K is a gain of arm, tip, arm', speed, but this plant's is of arm,"),
        (Gain(np.eye(2), ["arm", "tip"]), "K is a gain of arm, tip"),
        (of_law.gains, "Give law="),
        (dict(design.gains), "K is a dict of gains by name"),
        (dict(K_P=np.eye(2), K_D=np.eye(2)), "K is a dict of gains by name"),
    ):
        with pytest.raises(ValueError, match=words):
            take(NAMED, K)
    controller = design.controller(T=0.01)
    if not name.startswith(("certify", "sampled_loop")):
        with pytest.raises(ValueError, match="K is a Controller"):
            take(NAMED, controller)


def test_a_laws_gain_is_taken_by_its_names_too():
    law = sos.PIDLaw(np.eye(2), filter=0.1)
    design = sos.design_pid(NAMED, law=law, region=sos.PoleRegion(0.05))
    want = sos.analyse_pid(NAMED, design.K, law=law, region=sos.PoleRegion(0.05))
    order = list(np.random.default_rng(1).permutation(design.K.shape[1]))
    parts = law.parts(NAMED).signals
    shuffled = Gain(design.K[:, order], [parts[k] for k in order])
    for K in (design.gains, dict(design.gains), shuffled):
        found = sos.analyse_pid(NAMED, K, law=law, region=sos.PoleRegion(0.05))
        assert found.status == want.status and np.array_equal(found.K, want.K)
    with pytest.raises(ValueError, match="but the law's is of"):
        full = sos.design_pid(NAMED, **REGION).gain
        sos.analyse_pid(NAMED, full, law=law, region=sos.PoleRegion(0.05))


def test_an_acceleration_gain_isnt_lost_on_the_way():
    light = sos.SecondOrderSystem(np.diag([1, 0]), np.eye(2), np.eye(2), np.eye(2))
    design = sos.design_pid(light, K_A=[[0, 0], [0, -1]], **REGION)
    for K in (design, design.gains):
        with pytest.raises(ValueError, match="acceleration gain|Give law="):
            certify_sampled(SPRUNG, K, 0.1)


def test_a_robots_controller_is_taken_by_its_rates():
    one = [[0.5]], [[0.2, 0.1]], [[-0.4]], [[-1.0, -1.2]], 0.1
    turned = [[0.5]], [[0.1, 0.2]], [[-0.4]], [[-1.2, -1.0]], 0.1
    law = pendulum.SampledLaw.of_controller
    first = law(control.ss(*one), 0.1)
    second = law(control.ss(*turned, inputs=["phi'", "theta'"]), 0.1)
    assert np.array_equal(first.B, second.B) and np.array_equal(first.D, second.D)
    with pytest.raises(ValueError, match="closed by the names theta', phi'"):
        law(control.ss(*one, inputs=["theta", "phi"]), 0.1)
