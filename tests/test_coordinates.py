"""What is a coordinate is known from the plant, never from half of a state's length."""

import re
from functools import partial
from pathlib import Path

import numpy as np
import pytest

import sosbook as sos
from sosbook.controllers import Backlash, predicted_cycles
from sosbook.controllers.bounds import rest
from sosbook.controllers.memory import kalman
from sosbook.sampled.discretize import SampleTiming, input_vertices

ROOMS = Path(sos.__file__).parent
PAIR = sos.SecondOrderSystem(
    np.diag([1, 0.3]), [[0.5, -0.1], [-0.1, 0.2]], np.zeros((2, 2)), np.eye(2)
)
M = np.linalg.inv(PAIR.M)
SAME = sos.DescriptorSystem(
    np.eye(4),
    np.block([[np.zeros((2, 2)), np.eye(2)], [-M @ PAIR.S, -M @ PAIR.D]]),
    np.vstack([np.zeros((2, 2)), M @ PAIR.B]),
)
ODD = sos.DescriptorSystem(  # a motor: its current, its speed, its place
    np.eye(3), [[-20, -0.5, 0], [9.81, -0.3, 0], [0, 1, 0]], [[1], [0], [0]]
)
LAW = dict(integrate=True, filter=0.3)
GAINS = {"K_P": -np.eye(2), "K_D": -2 * np.eye(2), "K_I": -0.3 * np.eye(2)}


def both(T=0.05):
    for plant, rows in ((PAIR, np.eye(2)), (SAME, np.eye(2, 4))):
        law = sos.PIDLaw(position=rows, **LAW)
        yield sos.analyse_pid(plant, GAINS, law=law).controller(T=T, units={"u1": "N"})


def motor(**more):
    design = sos.design_pid(ODD, region=sos.PoleRegion(1, rho=60))
    return design.controller(T=0.01, **more)


@pytest.mark.parametrize("room", ["controllers", "sampled"])
def test_no_half_of_a_states_length_is_taken(room):
    for path in (ROOMS / room).rglob("*.py"):
        assert not re.search(r"// *2\b", path.read_text("utf-8")), path.name


@pytest.mark.slow
def test_a_plant_in_first_order_form_has_the_same_bounds():
    """Where it rests, what a step and a ramp ask: of either form of one plant."""
    first, second = both()
    for j in range(2):
        np.testing.assert_array_equal(rest(first, j), rest(second, j))
    step = [c.bounds.step(1.0, 1, 0).proven for c in (first, second)]
    assert step[0] == pytest.approx(step[1], rel=1e-6)
    for c in (first, second):
        run = c.simulate(1.0, r=[0, 1])
        assert abs(run.u[:, :, 0]).max() <= step[0]


def test_a_state_of_three_has_a_rest():
    c = sos.analyse_pid(
        ODD, {"K_P": [[-1.0]], "K_D": [[-0.1]], "K_I": [[-0.2]]},
        law=sos.PIDLaw(position=[[0, 0, 1]], **LAW),
    ).controller(T=0.02)  # fmt: skip
    x = rest(c, 0).astype(float)[:, 0]
    np.testing.assert_array_equal(x[:3], [0, 0, 1])
    F, r = c.loops[0].F, c.loops[0].set_point[:, 0]
    np.testing.assert_allclose(F @ x + r, x, atol=1e-12)
    assert c.bounds.step().proven is not None


def test_forces_act_on_coordinates_or_are_refused():
    c = motor()
    for ask in (lambda **f: c.simulate(0.1, **f), partial(predicted_cycles, c)):
        for name, value in (("friction", [0.5]), ("backlash", Backlash(0, 1, 0.1))):
            with pytest.raises(ValueError, match=f"{name} is a force .* has none"):
                ask(**{name: value})
    first, second = both()
    with pytest.raises(ValueError, match="a DescriptorSystem has none"):
        second.simulate(0.1, friction=[0.1, 0.1])
    for ask in (lambda **f: first.simulate(0.1, **f), partial(predicted_cycles, first)):
        with pytest.raises(ValueError, match="one for each of 2 coordinates"):
            ask(friction=[0.1, 0.1, 0.1])
        for ends in ((0, 2), (-1, 0)):
            with pytest.raises(ValueError, match="must be a coordinate's index below"):
                ask(backlash=Backlash(*ends, 0.1))


def test_unknown_forces_push_every_equation_of_a_first_order_plant():
    """By Riccati's own equation: what isn't measured is doubted, in every state."""
    (d,), rows = input_vertices(ODD, None), np.eye(1, 3, 2)
    tick = SampleTiming.of(0.01, 0.0)
    few, many = (kalman(d, tick, rows, np.array([1e-3]), x) for x in (1e-4, 1e2))
    assert (abs(many) > abs(few)).all()
    mixed = motor(measured=["x3"])
    assert mixed.radius < 1 and mixed.certify().proven


def test_a_report_draws_every_state_of_a_first_order_plant(tmp_path):
    pushed = sos.DescriptorSystem(ODD.E, ODD.A, ODD.B, [[0], [1], [0]])
    design = sos.design_pid(pushed, region=sos.PoleRegion(1, rho=60))
    text = design.report(tmp_path / "motor", T=0.01).read_text("utf-8")
    drawn = {name for name in ("x1", "x2", "x3") if f'"{name} over time' in text}
    assert len(drawn) == 3


@pytest.mark.parametrize(
    "names",
    [
        *(("b", x + "b") for x in ("2 ", "-", "0.5 ", "rate of ", "integral of ")),
        *(("b", x) for x in ("b'", "filtered b", "set point of b", "a - b", "u", "u2")),
        *(("xc1", "b"), ("a_b", "a.b"), ("a", "-2e-3 integral of a'")),
    ],
)
def test_no_coordinate_is_called_like_what_is_made_of_another(names):
    """Loops are closed by names: "2 b" was taken for twice b, "u1" had u1's unit."""
    for order in (names, names[::-1]):
        with pytest.raises(ValueError, match="coordinates: .*another name"):
            sos.SecondOrderSystem(PAIR.M, PAIR.D, PAIR.S, PAIR.B, coordinates=order)


def test_a_name_that_could_be_a_mixture_is_a_name_first():
    """States and lone coordinates may have such names: their loop comes back."""
    named = sos.DescriptorSystem(ODD.E, ODD.A, ODD.B, states=("2 b", "b", "a - b"))
    lone = sos.SecondOrderSystem(0.3, 0.2, 9.81, 1, coordinates=["2 arms"])
    for plant, size in ((named, 3), (lone, 1)):
        law = sos.PIDLaw(position=np.eye(size), filter=0.3, integrate=True)
        gains = {k: [[-0.3, -0.4, 0.7][:size]] for k in ("K_P", "K_D", "K_I")}
        loop = sos.Loop(plant, law, gains)
        again = sos.Loop(plant, loop.to_ss())
        assert np.allclose(*(np.sort_complex(x.poles()) for x in (loop, again)))
    plant = sos.DescriptorSystem(ODD.E, ODD.A, ODD.B, states=("a.b", "a_b", "c"))
    with pytest.raises(ValueError, match="alike: a_b, a_b, c"):
        sos.Loop(plant, sos.PIDLaw(position=np.eye(3)), {"K_P": [[0, 0, 0]]}).to_ss()
