"""What is asked of the plant's own states stays so, whatever a law remembers."""

import numpy as np
import pytest

import sosbook as sos
from sosbook.synthesis.request import Request
from sosbook.synthesis.structured.any_order import of_plant_alone
from sosbook.synthesis.structured.moving_gain import loops_of
from sosbook.synthesis.structured.objective import Objective, Task
from tests.cases import campaign

A = np.array([[-0.3, 9.81, 0.2], [-1, 0.1, 0], [0, 2, -5]])
C, D_u = np.array([[0, 0.7, 0], [0.3, 0, 1], [0, 0, 0]]), [[0], [0], [0.3]]
LAWS = {
    "dynamic": sos.DynamicLaw(2, position=[[0, 1, 0]], noise=[[0.3]]),
    "filtered": sos.PIDLaw(position=[[0, 1, 0]], filter=0.3, integrate=True),
    "without memory": sos.PIDLaw(position=[[1, 0, 0]]),
}


def plant(**output):
    return sos.DescriptorSystem(
        np.eye(3), A, [[0], [1], [0.3]], [[1], [0], [1]], **output
    )


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
@pytest.mark.parametrize("kind", [sos.HInfinity, sos.H2])
def test_an_output_is_that_of_the_plant_in_each_spelling(law, kind):
    c, found = len(law.parts(plant()).states), []
    for x in (C, np.hstack([C, np.zeros((3, c))])):
        asked = kind(50.0, outputs=sos.Output(state=x, input=D_u))
        (r,) = Request(plant(), requirements=[asked], law=law).requirements
        found.append(r.data())
    assert found[0] == found[1]


def test_what_no_controller_keeps_is_refused_in_each_spelling():
    """Of a gain, too; one whose loop is unstable is below nothing."""
    law, floor = sos.DynamicLaw(1, position=[[0, 1, 0]], noise=[[0.3]]), {}
    wide = np.hstack([C, np.zeros((3, 1))])
    for name, own, output in (  # a short output asks for what a padded one does
        ("plant's", plant(C=C, D_u=D_u), None),
        ("padded", plant(), sos.Output(state=wide, input=D_u)),
    ):
        asked = dict(law=law, requirements=[sos.HInfinity(0.05, outputs=output)])
        floor[name] = str(sos.analyse_pid(own, np.diag([0, -1]), **asked).bounds())
    design = sos.design_pid(own, **asked, search=sos.Search(starts=1))
    assert design.status == "infeasible" and design.infeasibility.proven
    unstable = sos.analyse_pid(own, np.diag([0, 1]), **asked)
    assert unstable.bounds()["gamma"].excluded is None
    assert "no linear controller keeps" in floor["padded"]
    assert floor["padded"] == floor["plant's"]


def test_rows_on_what_the_law_remembers_are_of_the_loop():
    """No door, which knows the plant alone, may speak of them."""
    law = LAWS["dynamic"]
    asked = sos.HInfinity(1e-3, outputs=sos.Output(state=[[0, 1, 0, 0, 0.3]]))
    request = Request(plant(), requirements=[asked], law=law)
    assert request.requirements[0].data() == asked.data()
    bare = plant().vertices[0]
    assert of_plant_alone(asked, bare, request.applied.parts) == (None, None)


def test_rows_of_another_width_are_refused():
    asked = sos.HInfinity(1.0, outputs=sos.Output(state=[[0, 1, 0, 0]]))
    with pytest.raises(ValueError, match="state has rows of width 4"):
        sos.design_pid(plant(), law=LAWS["dynamic"], requirements=[asked])


def test_the_weight_of_a_cost_is_that_of_the_plants_states():
    law, Q = LAWS["filtered"], np.diag([1, 0.3, 9.81])
    for short in (dict(Q=Q, N=[[0.1], [0], [0]]), dict(C=[[1, 0.3, 0]])):
        cost = sos.QuadraticCost(R=[[0.3]], bound=1e6, **short)
        (r,) = Request(plant(), requirements=[cost], law=law).requirements
        for name, x in short.items():
            x, found = np.array(x, float), getattr(r, name)
            assert (found[: len(x), : x.shape[1]] == x).all()
            assert abs(found).sum() == abs(x).sum()


DRIVE = sos.SecondOrderSystem(
    [[0.0025, 0], [0, 0.0045]],
    [[0.004, -0.004], [-0.004, 0.004]],
    [[1.9, -1.9], [-1.9, 1.9]],
    [[1], [0]],
    [[0], [1]],
)  # fmt: skip
ENCODER = sos.PIDLaw(position=[[1, 0]], filter=0.002, integrate=[[1]])


def test_a_filter_rests_on_what_is_measured_at_the_start():
    gains = {"K_P": [[-1.23]], "K_D": [[-0.146]], "K_I": [[-3.71]]}
    start = np.array([-0.3, 9.81, 2.0, -1.0])
    asked = [sos.Saturation(200.0, x) for x in (start, [*start, 0, -0.3])]
    made = [sos.analyse_pid(DRIVE, gains, law=ENCODER, requirements=[r]) for r in asked]
    short, whole = (d.request.requirements[0].x0 for d in made)
    assert short.tolist() == whole.tolist() == [*start, 0, -0.3]
    t = np.linspace(0, 0.5, 50)
    one, other = (d.simulate(t, x0=x) for d, x in zip(made, (start, [*start, 0, -0.3])))
    assert np.array_equal(one.u, other.u)
    # in the first moment the derivative sees the speed alone, not the place
    assert one.u[0, 0] == pytest.approx(0.3 * 1.23)


def test_a_dynamic_law_starts_at_zero():
    x0 = sos.Saturation(9.0, [1, 0.3, 0])
    (r,) = Request(plant(), requirements=[x0], law=LAWS["dynamic"]).requirements
    assert r.x0.tolist() == [1, 0.3, 0, 0, 0]


@pytest.mark.parametrize("x0", [[-1, -1, 0, 0, 0, 0], *campaign([[-1, -1, 0, 0]])])
def test_a_bound_of_the_input_beside_the_edge_of_stability_ends_in_words(x0):
    design = sos.design_pid(
        DRIVE,
        law=ENCODER,
        region=sos.PoleRegion(sigma=3, theta_deg=70, rho=1000),
        saturation=sos.Saturation(2, x0),
        search=sos.Search(starts=2),
    )
    assert design.status == "undecided" and "input bound u_max" in design.reason.lower()


@pytest.mark.parametrize("goal", [None, "u_max"])
def test_a_value_comes_with_a_slope_or_not_at_all(goal):
    """Beside the edge of stability a difference may be infinite, the value isn't."""
    saturation = sos.Saturation(2, [-1, -1, 0, 0, 0, 0])
    request = Request(DRIVE, law=ENCODER, saturation=saturation)
    loops = loops_of(request)
    task = Task.of(request, loops, goal and request.requirements[0])
    f = Objective(task, loops, loops.units(task.rate), True)
    rng, finite = np.random.default_rng(0), 0
    edge = [-1.23, -0.146, -3.71] / f.unit
    for share in np.linspace(0, 40, 200):
        value, slope = f(edge * [1, 1, share * (1 + 1e-6 * rng.normal())])
        finite += np.isfinite(value)
        assert np.isfinite(slope).all()
    assert 5 < finite < 200
