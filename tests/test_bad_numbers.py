"""Bad numbers are named, and what floats can't do is undecided."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import sosbook as sos
from sosbook.plants.checks import SizeError
from sosbook.plants.measured import MeasuredResponse
from sosbook.plants.second_order import MassWarning
from sosbook.runtime.time_limit import OutOfTime
from tests.cases import examples

I = np.eye(2)
OURS = ValueError, SizeError  # not numpy's LinAlgError, which is a ValueError, too


def mass(M=1.0):
    return sos.SecondOrderSystem([[M]], [[0.0]], [[0.0]], [[1.0]], [[1.0]])


def refused(words, ask):
    with pytest.raises(ValueError, match=words) as caught:
        ask()
    assert type(caught.value) in OURS


@pytest.mark.parametrize(
    "words, ask",
    [
        ("M must be", lambda: sos.SecondOrderSystem([[10**400]], [[0]], [[0]], [[1]])),
        ("entry of M = 1e.150", lambda: mass(1e150)),
        ("entry of M = 1e-150 is below", lambda: mass(1e-150)),
        ("gamma = 1e.300", lambda: sos.design_pid(mass(), gamma=1e300)),
        ("gamma = 1e-300", lambda: sos.design_pid(mass(), gamma=1e-300)),
        ("gamma must be a finite", lambda: sos.design_pid(mass(), gamma=10**400)),
        ("u_max = 1e.300", lambda: sos.Saturation(1e300, [1, 0])),
        ("x0 = 1e.300", lambda: sos.Saturation(1, [1e300, 0])),
        ("rho = 1e.300", lambda: sos.PoleRegion(rho=1e300)),
        ("sigma = 1e.300", lambda: sos.PoleRegion(sigma=1e300)),
        ("theta = 1e-300", lambda: sos.PoleRegion(theta=1e-300)),
        ("entry of K = 1e.300", lambda: sos.analyse_pid(mass(), [[1e300, 0]])),
        ("entry of Q = 1e.200", lambda: sos.design_lqr(mass(), 1e200 * I, [[1]])),
    ],
)
def test_a_number_out_of_bounds_is_named(words, ask):
    refused(words, ask)


def polytope(**asked):
    plants = sos.Polytope([mass(), mass(1.5)])
    return sos.design_pid(plants, region=sos.PoleRegion(0.1), **asked)


@pytest.mark.parametrize("wrong", [-1, 1.5, "two", True, None])
def test_samples_are_counted(wrong):
    d = polytope()
    for ask in (d.poles, d.hinf):
        refused("samples must be 0, 1, ...", lambda ask=ask: ask(samples=wrong))
    refused("seed must be", lambda: d.poles(samples=2, seed=-1))


def test_fields_that_were_tampered_with_are_named():
    d = polytope(coupling="slack")
    refused("P has 1 matrices, needs 2", replace(d, P=d.P[:1]).certify)
    refused("V is missing", replace(d, V=None).certify)


SIZES = st.sampled_from([0.0, 1e-99, 1e-30, 1e-9, 1.0, 3.7, 1e9, 1e30, 1e99, -1.0])


@pytest.mark.slow
@settings(
    max_examples=examples(3, 8),
    deadline=None,
    derandomize=True,
    suppress_health_check=list(HealthCheck),
)
@given(
    entries=st.lists(SIZES, min_size=5, max_size=5),
    sigma=st.sampled_from([None, 1e-9, 1.0, 1e9]),
    gamma=st.sampled_from([None, 1e-9, 1.0, 1e9]),
    u_max=st.sampled_from([None, 1e-9, 1.0, 1e9]),
    K=st.one_of(st.none(), st.lists(SIZES, min_size=2, max_size=2)),
)
def test_whatever_is_asked_gets_an_answer(entries, sigma, gamma, u_max, K):
    """A verdict with its reason, or a ValueError of ours; no warning."""
    asked = dict(
        region=sigma and sos.PoleRegion(sigma),
        gamma=gamma,
        saturation=u_max and sos.Saturation(u_max, [1, 0]),
        search=sos.Search(time_limit=0.3),
    )
    M, D, S, B, F = ([[x]] for x in entries)
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", MassWarning)
                plant = sos.SecondOrderSystem(M, D, S, B, F)
            if K is None:
                d = sos.design_pid(plant, **asked)
            else:
                d = sos.analyse_pid(plant, [K], **asked)
        except ValueError as error:
            assert type(error) in OURS, error
            return
        # a gain that is no centre has a reason, too: which one it is
        all_of_it = d.status == "feasible" and d.central is not False
        assert all_of_it == (d.reason == "")
        if d.status == "feasible":
            assert d.K is not None
            assert min(d.margins.values()) > 0 or d.certify(17).proven
        if d.status == "infeasible":
            assert d.infeasibility.proven
        assert isinstance(d.advice, str)


def test_a_gain_that_time_kept_from_the_centre_is_called_no_centre(monkeypatch):
    def late(*_):
        raise OutOfTime

    monkeypatch.setattr("sosbook.synthesis.feasibility.finish", late)
    design = sos.design_pid(mass(), region=sos.PoleRegion(1, rho=3))
    assert design.status == "feasible" and "Stopped" in design.reason
    assert design.central is False


def test_advice_ends_where_no_file_holds_the_neighbours_numbers():
    bead = sos.SecondOrderSystem(1e-99, 0, 0, 1e-99, 0)
    design = sos.design_pid(bead, gamma=1e-9, saturation=sos.Saturation(1e-9, [1, 0]))
    assert design.status == "undecided" and design.advice


ONE = sos.SecondOrderSystem(1, 1, 1, 1, 1)
ROW = [[-1.0, -1.0]]
PAIR = sos.Polytope([ONE, mass(2.0)])
NO_NUMBERS = {
    "text": "abc",
    "quoted": ["1", "2"],
    "complex": [1j, 0],
    "array of complex": np.array([1j, 0]),
    "ragged": [[1, 2], [3]],
    "none inside": [None, 1.0],
    "an object": object(),
    "true": np.array([True, False]),
    "dates": np.array(["2020-01-01", "2020-01-02"], dtype="M8[D]"),
    "masked": np.ma.array([0.0, 1.0], mask=[False, True]),
    "beyond floats": [10**400, 0],
    "beyond squares": [0.0, 1e200],
}
VECTORS = {
    "weights": PAIR.at,
    "t": ONE.simulate,
    "x0": lambda x: ONE.simulate([0, 1], x0=x),
    "amplitude": lambda x: sos.Sine(x, 1.0),
    "offset": lambda x: sos.Sine(1.0, 1.0, offset=x),
    "height": lambda x: sos.Step(x),
    "levels": lambda x: sos.Steps([0, 1], x),
    "r": lambda x: sos.analyse_pid(ONE, ROW).simulate([0, 1], r=x),
    "x0 ": lambda x: sos.Saturation(1.0, x),
    " x0": lambda x: sos.sampled.sampled_cost(ONE, ROW, I, [[1]], 0.1, x0=x),
    "B_w": lambda x: sos.design_observer(ONE, ROW, np.eye(4), I, C=I, B_w=x),
    "candidates": lambda x: sos.admissible_U(PAIR, x),
}


@pytest.mark.parametrize("wrong", NO_NUMBERS)
@pytest.mark.parametrize("name", VECTORS)
def test_a_vector_of_no_numbers_is_named(name, wrong):
    """Neither numpy's words nor a TypeError; no imaginary part is dropped."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        refused(name.strip(), lambda: VECTORS[name](NO_NUMBERS[wrong]))


@pytest.mark.parametrize("wrong", [None, "1", 1j, [1.0], np.nan, 10**400, object()])
def test_a_signal_of_no_numbers_is_named_where_it_is_written(wrong):
    for name in ("omega", "start", "stop"):
        refused(
            name,
            lambda name=name: sos.Sine(**{"amplitude": 1, "omega": 1, name: wrong}),
        )
    for name in ("start", "stop"):
        refused(name, lambda name=name: sos.Step(1.0, **{name: wrong}))
    refused("amplitude", lambda: sos.Sine(np.inf, 1.0))


def test_other_things_in_the_place_of_objects_are_named():
    design = sos.analyse_pid(ONE, ROW)
    for wrong in (0, 1.0, "cost", [[1.0]], np.eye(2), ONE):
        refused("cost must be", lambda wrong=wrong: design.noise_cost(wrong))
    for wrong in (None, 1.0, ONE):
        refused("parts must be", lambda wrong=wrong: sos.Region(wrong))
    for wrong in (1.0, ONE, object()):
        refused("candidates must be", lambda w=wrong: sos.admissible_U(PAIR, w))
    for wrong in ("pole", object(), [[1], [1, 2]]):
        refused("poles must be", lambda w=wrong: sos.PoleRegion(1).contains(w))
    three = [[[0], [1]]] * 3
    refused(
        "B_w has 3 matrices, needs 1 or one",
        lambda: sos.design_observer(ONE, ROW, np.eye(4), I, C=I, B_w=three),
    )


@pytest.mark.parametrize("wrong, words", [
    (lambda: sos.read_wish(3, mass()), "text must be a sentence, got int"),
    (lambda: sos.plants.filtered(mass(), [[1]], [1], [1, 2]), "output must be an O"),
    (lambda: sos.delay.simulate_delay(mass(), [[-1, -1]], [0, 1], 0.1),
     "d must be a Descriptor, got SecondOrderSystem"),
    (lambda: MeasuredResponse([2, 1], np.ones((2, 1, 1))), r"\(2,\) and \(2, 1, 1\)"),
])  # fmt: skip
def test_what_is_of_another_kind_is_named(wrong, words):
    with pytest.raises(ValueError, match=words):
        wrong()


def test_a_late_loop_is_simulated_as_the_error_says():
    seen = sos.Loop(mass(), None, [[-1, -1]]).late(0.1).simulate([0, 1], x0=[1, 0])
    assert abs(seen.z[0, 1]) < 1
