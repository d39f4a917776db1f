"""Every design function's result keeps one protocol."""

import html
import inspect
import traceback

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import sosbook as sos
from sosbook.plants.response import Response
from sosbook.synthesis.result import Result
from tests.cases import crossed
from tests.closed import analyse_loop

CART = sos.SecondOrderSystem(M=1, D=0.1, S=2, B=1, F=1)
STIFF = sos.SecondOrderSystem(M=1.2, D=0.1, S=3, B=1, F=1)
PAIR = sos.Polytope([CART, STIFF])
LIGHT = sos.SecondOrderSystem(np.diag([1e-4, 1]), np.eye(2), np.eye(2), [[0], [1]])


def observer(plant):
    K = sos.design_lqr(plant, np.eye(2 * plant.n), np.eye(plant.m)).K
    Q_F = np.zeros((4 * plant.n, plant.n))
    Q_F[plant.n : 2 * plant.n] = np.eye(plant.n)
    return sos.design_observer(plant, K, Q_F, 0.1 * np.eye(plant.n))


MAKE = {
    "Design": lambda plant: sos.design_pid(plant, region=sos.PoleRegion(sigma=0.5)),
    "DelayDesign": lambda plant: sos.design_delay_pid(plant, tau=0.1, delta=0.01),
    "ObserverDesign": observer,
    "SampledLQR": lambda plant: sos.design_sampled_lqr(plant, np.eye(2), [[1]], T=0.1),
    "Regularization": lambda plant: sos.regularize(plant, 0.5),
}
REFUSED = {
    "Design": lambda: sos.design_pid(
        CART, region=sos.PoleRegion(sigma=1), saturation=sos.Saturation(0.01, x0=[1, 0])
    ),
    "DelayDesign": lambda: sos.design_delay_pid(CART, tau=9.0, delta=3.0, alpha=9.0),
    "ObserverDesign": lambda: unstable_vertex(),
    "Regularization": lambda: sos.regularize(LIGHT, 1.0),
}


def unstable_vertex():
    """K stabilises the mean plant but not the first vertex."""
    ends = [sos.SecondOrderSystem(1, 0.1, s, 1, 1) for s in (-5.0, 6.0)]
    Q_F = [[0], [1], [0], [0]]
    return sos.design_observer(sos.Polytope(ends), [[-1.0, -2.0]], Q_F, [[1.0]])


@pytest.fixture(scope="module")
def results():
    return {
        (name, plant): make(plant)
        for name, make in MAKE.items()
        for plant in (CART, PAIR)
        if (name, plant) != ("SampledLQR", PAIR)  # refused: no Riccati equation
    }


def test_every_result_of_the_package_is_walked():
    kinds = {
        name
        for name in sos.__all__
        if inspect.isclass(getattr(sos, name))
        and issubclass(getattr(sos, name), Result)
        and getattr(sos, name) is not Result
    }
    assert kinds == set(MAKE)


@pytest.mark.parametrize("name", MAKE)
@pytest.mark.parametrize("plant", [CART, PAIR], ids=["plant", "polytope"])
def test_a_feasible_result(results, name, plant):
    if (name, plant) not in results:
        pytest.skip("a sampled LQR is of one plant")
    found = results[name, plant]
    assert type(found).__name__ == name and isinstance(found, Result)
    assert found.status == "feasible"
    assert found.K.ndim == 2 and len(found.K) == plant.m
    assert min(found.margins.values()) > 0
    assert found.infeasibility is None and found.advice == ""
    proof = found.certify()
    assert proof.proven and proof.claims
    assert repr(found).startswith(f"<{name}: feasible") and len(repr(found)) < 90

    rows = 1 if plant is CART else plant.N
    poles = found.poles()
    assert poles.ndim == (1 if plant is CART else 2)
    assert len(np.atleast_2d(poles)) == rows

    t = np.linspace(0, 0.5, 6)
    answer = found.simulate(t)
    several = answer if plant is PAIR else [answer]
    assert isinstance(several, list) and len(several) == rows
    for response in several:
        assert response.z.shape == (plant.n, 6) and not response.z.any()
        assert response.u.shape == (plant.m, 6)
        assert isinstance(response, Response)


def sampled(plant):
    return sos.design_sampled(plant, sos.PIDLaw([[1]], filter=0.3), 0.1)


PAGES = {
    "Design": "poles lie",
    "DelayDesign": "behind a delay",
    "SampledDesign": "ticks",
}


@pytest.mark.parametrize("name, plant", crossed(PAGES, [CART, PAIR]))
def test_each_design_of_a_gain_has_a_page(results, name, plant, tmp_path):
    found = results.get((name, plant)) or sampled(plant)
    clock = {} if name == "SampledDesign" else {"T": 0.1}
    page = found.report(tmp_path, **clock).read_text("utf-8")
    (asked,) = found.statements()
    assert PAGES[name] in asked and f"<li>{html.escape(asked)}</li>" in page
    assert found.pole_axis in page
    assert ("asked, proven and true" in page.lower()) == (name == "Design")


def test_a_design_without_requirements_asks_for_stability():
    """Of an infeasible one it was said that nothing was asked."""
    assert sos.design_pid(CART).statements() == ["it is stable"]
    free = sos.SecondOrderSystem(np.eye(2), 0 * np.eye(2), np.diag([1, -1]), [[1], [0]])
    for found in (sos.design_pid(free), sos.analyse_pid(CART, [[100.0, -2.0]])):
        assert found.status == "infeasible" and found.infeasibility.proven
        assert found.certify().why.startswith("the design is infeasible.")
    loop = sos.Loop(CART, sos.FullState(), [[-1.0, -2.0]])
    assert loop.design.statements() == ["nothing was asked"]


def test_those_are_all_designs_with_a_page():
    made = {name for name in sos.__all__ if hasattr(getattr(sos, name), "report")}
    assert made - {"Loop"} == set(PAGES)


@pytest.mark.parametrize("name", REFUSED)
def test_a_refused_result(name):
    found = REFUSED[name]()
    assert type(found).__name__ == name
    assert found.status in ("infeasible", "undecided")
    assert found.advice.endswith(".")
    if found.status == "infeasible":
        assert found.infeasibility.proven
    assert found.margins is None
    assert repr(found) == f"<{name}: {found.status}>"
    for ask in (found.poles, lambda: found.simulate([0, 1])):
        with pytest.raises(ValueError, match=f"is {found.status}"):
            ask()


@pytest.mark.parametrize("name", REFUSED)
def test_the_proof_of_a_refused_result_is_words(name, tmp_path):
    """A script that prints it goes on; one that uses it as a proof doesn't."""
    found = REFUSED[name]()
    proof = found.certify()
    assert not proof and not proof.proven and not proof.verify() and not proof.claims
    assert str(proof).startswith(f"not proven: the {found.noun} is {found.status}. ")
    assert ("see its infeasibility" in str(proof)) == (found.status == "infeasible")
    with pytest.raises(ValueError, match=f"no gain is proven: .* is {found.status}"):
        proof.K
    with pytest.raises(ValueError, match="no proof to save"):
        proof.save(tmp_path / "proof.json")
    assert not list(tmp_path.iterdir())


ONE, PUSHED = sos.DescriptorSystem(1, 1, 1), sos.DescriptorSystem(1, 1, 1, 1)
SEEN = sos.DescriptorSystem(1, 1, 1, None, 1)
SMALLEST = {  # one state, no disturbance, no output or no input
    "no F": lambda: sos.design_pid(sos.SecondOrderSystem(1, 0.1, 1, 1)),
    "U without rows": lambda: sos.design_pid(CART, np.zeros((0, 1)), gamma=2),
    "one vertex": lambda: sos.design_pid(sos.Polytope([CART]), gamma=2),
    "B = 0": lambda: sos.analyse_pid(sos.SecondOrderSystem(1, 1, 1, 0), [[0, 0]]),
    "one state": lambda: sos.design_pid(ONE),
    "one state, F": lambda: sos.design_pid(PUSHED),
    "one state, C": lambda: sos.design_pid(SEEN),
    "bare loop": lambda: analyse_loop(1, -1),
    "loop": lambda: analyse_loop(1, -1, 1, 1, gamma=2),
    "loop, slack": lambda: analyse_loop(1, [[[-1]], [[-2]]], coupling="slack"),
    "unstable loop": lambda: analyse_loop(1, 1),
    "loop's cost": lambda: analyse_loop(
        1, -1, requirements=[sos.QuadraticCost(1, [], bound=3)]
    ),
    "cost": lambda: sos.design_lqr(ONE, 1, 1),
    "observer": lambda: sos.design_observer(SEEN, [[-2]], [[1], [0]], 1),
    "observer, quiet": lambda: sos.design_observer(SEEN, [[-2]], np.zeros((2, 0)), 1),
    "observer alone": lambda: sos.design_observer(
        sos.DescriptorSystem(1, -1, None, None, 1), np.zeros((0, 1)), [[1], [0]], 1
    ),
    "delay": lambda: sos.design_delay_pid(CART, tau=0.1, delta=0.01),
    "sampled": lambda: sos.design_sampled_lqr(ONE, 1, 1, T=0.1),
    "mass": lambda: sos.regularize(sos.SecondOrderSystem(1, 0.1, 1, 1), 0.1),
    "U": lambda: sos.admissible_U(CART)[0],
    "modes": lambda: sos.infinite_modes(CART),
}


def asked_of(thing):
    """Public attributes, and methods that need no argument but times, with these."""
    for name in dir(type(thing)):
        if name.startswith("_"):
            continue
        method = inspect.getattr_static(type(thing), name)
        if inspect.isfunction(method):
            needed = [
                p.name
                for p in list(inspect.signature(method).parameters.values())[1:]
                if p.default is p.empty and p.kind is not p.VAR_KEYWORD
            ]
            if not set(needed) <= {"t"}:
                continue
        yield name, [[0, 0.5, 1]] * (inspect.isfunction(method) and len(needed))


@pytest.mark.parametrize("name", SMALLEST)
def test_the_smallest_result_answers_or_says_what_is_missing(name):
    """Nothing is the maximum over nothing: no zero, no infinity, no error of numpy."""
    thing = SMALLEST[name]()
    numbers = {}
    for key, given in asked_of(thing):
        try:
            value = getattr(thing, key)
            numbers[key] = value(*given) if callable(value) else value
        except ValueError as error:
            *_, last = traceback.extract_tb(error.__traceback__)
            assert "sosbook" in last.filename, (key, error)
    for key in ("hinf", "sensitivity_peak", "noise_cost", "peak_input"):
        if key in numbers:
            assert 0 < numbers[key] < np.inf or name in ("B = 0",), key
    plant = getattr(getattr(thing, "request", thing), "plant", None)
    if plant is not None:
        bare = plant.m == 0
        assert ("sensitivity_peak" in numbers) <= (not bare)
        assert ("disk_margin" in numbers) == ("sensitivity_peak" in numbers)
        assert ("hinf" in numbers) <= (plant.p > 0 and plant.n > 0)


@pytest.mark.parametrize(
    "ask, words",
    [
        (lambda: analyse_loop(1, -1, 1, gamma=1), "gamma needs .* outputs"),
        (lambda: analyse_loop(1, -1, 1, minimize="gamma"), "gamma needs .* outputs"),
        (lambda: analyse_loop(1, -1, None, 1, gamma=1), "gamma needs .* F"),
        (lambda: sos.design_pid(PUSHED, gamma=1), "gamma needs a plant with outputs"),
        (
            lambda: analyse_loop(1, -1, requirements=[sos.Saturation(1, [1])]),
            "saturation bounds the input, but the plant has no B",
        ),
        (
            lambda: sos.DescriptorSystem(1, 1, 1, D_u=np.zeros((0, 1))),
            "D_u is given without C",
        ),
    ],
)
def test_a_bound_of_nothing_is_refused(ask, words):
    """It would be "proven" whatever its number is."""
    with pytest.raises(ValueError, match=words):
        ask()


def test_a_loop_has_its_pole_by_itself():
    """No gain is blamed where none was given."""
    refused = analyse_loop(1, 1)
    assert refused.reason.startswith("This loop has a pole at 1")
    assert "Change the loop" in refused.advice and "gain" not in refused.advice


def test_one_vertex_is_a_polytope_all_the_same():
    one = sos.Polytope([CART])
    design = sos.design_pid(one)
    assert design.poles().shape == (1, 2)
    assert len(design.simulate([0, 1])) == 1
    assert len(one.simulate([0, 1])) == 1
    sampled = sos.design_sampled_lqr(one, np.eye(2), [[1]], T=0.1)
    assert sampled.poles().shape == (1, 2) and sampled.radius < 1


def test_a_first_order_plant_is_one_plant():
    system = sos.DescriptorSystem(1, 1, 1)
    assert sos.design_pid(system).poles().shape == (1,)
    pair = sos.DescriptorSystem(1, [[[1]], [[2]]], 1)
    assert sos.design_pid(pair).poles().shape == (2, 1)
    with pytest.raises(ValueError, match="no displacement z"):
        sos.design_pid(system).simulate([0, 1])


def test_a_sampled_loop_between_its_samples():
    """At the ticks it is the matrix of the loop; between them, held inputs."""
    for delay in (0.0, 0.03, 0.1, 0.25):
        found = sos.design_sampled_lqr(CART, np.eye(2), [[1]], T=0.1, delay=delay)
        order = found.K.shape[1]
        state = np.zeros(order)
        state[:2] = [0.3, -0.2]
        t = np.arange(41) * 0.025
        answer = found.simulate(t, x0=state[:2])
        for k in range(10):
            assert answer.x[:, 4 * k] == pytest.approx(state[:2], abs=1e-10)
            assert answer.u[:, 4 * k] == pytest.approx(found.K @ state)
            state = found.loop() @ state
        late = found.simulate(np.linspace(0, 2, 2001), x0=[1, 0])
        begin = int(np.ceil(delay / 0.001 - 1e-9))
        assert not late.applied[:, :begin].any() and late.applied[:, begin].any()


def test_a_sampled_loop_follows_its_set_point():
    U = [[1]]
    found = sos.design_sampled_lqr(CART, np.diag([1, 1, 5]), [[1]], T=0.1, U=U)
    answer = found.simulate(np.linspace(0, 60, 61), r=[2.0], w=sos.Step(3.0))
    assert answer.z[:, -1] == pytest.approx([2.0], abs=1e-6)
    assert answer.e[:, -1] == pytest.approx([0.0], abs=1e-6)
    # at rest the springs' force less the disturbance
    assert answer.u[:, -1] == pytest.approx([2 * 2.0 - 3.0], abs=1e-5)


def test_an_observed_loop(results):
    """Against the controller put in a loop with the plant by hand."""
    found = results["ObserverDesign", CART]
    push = sos.Step(0.5, start=0.2)
    t = np.linspace(0, 3, 31)
    answer = found.simulate(t, x0=[1, 0], w=push, estimate=[0.2, -0.1])
    controller = found.controller()
    A = np.array([[0, 1], [-2.0, -0.1]])
    B = np.array([[0], [1.0]])

    def rate(now, s):
        x, x_hat = s[:2], s[2:]
        u = controller.C @ x_hat
        return np.concatenate(
            [
                A @ x + B[:, 0] * (u + push([now])[0]),
                controller.A @ x_hat + controller.B @ (found.C @ x),
            ]
        )

    s = np.array([1, 0, 0.2, -0.1])
    both = [s]
    for now, then in zip(t, t[1:]):
        s = solve_ivp(rate, (now, then), s, rtol=1e-10, atol=1e-12).y[:, -1]
        both.append(s)
    both = np.transpose(both)
    assert answer.x == pytest.approx(both[:2], abs=1e-7)
    assert answer.estimate == pytest.approx(both[2:], abs=1e-7)
    assert answer.dz[0] == pytest.approx(both[1], abs=1e-7)
    free = found.simulate(t, x0=[1, 0], estimate=[1, 0])
    state_feedback = sos.analyse_pid(CART, found.K).simulate(t, x0=[1, 0])
    assert free.x == pytest.approx(state_feedback.x, abs=1e-9)  # no error at all


def test_poles_of_the_observed_loop_are_those_of_both(results):
    """For one plant: the regulator's and the observer's (separation)."""
    found = results["ObserverDesign", CART]
    d_hat = np.array([[0, 1], [-2.0, -0.1]]) + found.L @ found.C
    expected = np.concatenate(
        [sos.analyse_pid(CART, found.K).poles(), np.linalg.eigvals(d_hat)]
    )
    assert np.sort_complex(found.poles()) == pytest.approx(np.sort_complex(expected))


def test_poles_under_delay_are_the_rightmost_roots(results):
    found = results["DelayDesign", PAIR]
    assert found.poles(count=4).shape[0] == 2
    for row, roots in zip(found.poles(0.05, 4), found.roots(0.05, 4)):
        assert np.array_equal(row, roots[: len(row)])
    single = results["DelayDesign", CART]
    assert np.array_equal(single.poles(), single.roots(0.1))


def test_without_a_delay_it_is_the_nominal_one(results):
    found = results["DelayDesign", CART]
    t = np.linspace(0, 1, 5)
    a = found.simulate(t, x0=[1, 0])
    b = found.simulate(t, sos.delay.profiles.ConstantDelay(0.1), x0=[1, 0])
    assert np.array_equal(a.z, b.z) and a.applied[0, 0] == 0


def test_a_regularized_plant(results):
    found = results["Regularization", PAIR]
    assert np.array_equal(found.K, found.K_A)
    for row, v in zip(found.poles(), found.regular.vertices):
        assert np.array_equal(row, v.poles())
    t, x0 = np.linspace(0, 1, 5), [1, 0]
    for a, v in zip(found.simulate(t, x0=x0), found.regular.vertices):
        assert np.array_equal(a.z, v.simulate(t, x0=x0).z)
