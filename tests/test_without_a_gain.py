"""What is asked of a design that found no gain, and of proofs that weren't made."""

import inspect

import numpy as np
import pytest

import sosbook as sos
from sosbook.sampled import sampled_loop
from sosbook.sampled.lyapunov import discrete_lyapunov

CART = sos.SecondOrderSystem(1, 0, 0, 1)
PUSHED = sos.SecondOrderSystem(1, 0.3, -9.81, 1, F=[[1]])
P_ALONE = sos.PIDLaw(position=[[1]])
NARROW = dict(region=sos.PoleRegion(5, rho=9), saturation=sos.Saturation(1e-3, [1, 0]))
WITHOUT = {
    "law": lambda: sos.design_pid(CART, law=P_ALONE, region=sos.PoleRegion(1)),
    "law in time": lambda: sos.design_pid(
        PUSHED, law=sos.DynamicLaw(1, position=[[1]]), gamma=1e-3,
        search=sos.Search(time_limit=1e-3),
    ),
    "states": lambda: sos.design_pid(CART, **NARROW),
    "descriptor": lambda: sos.design_pid(
        sos.DescriptorSystem(np.eye(1), [[1]], [[1]]),
        saturation=sos.Saturation(1e-3, [1]), region=sos.PoleRegion(5),
    ),
    "cost": lambda: sos.design_lqr(
        CART, np.eye(2), [[1]], search=sos.Search(time_limit=1e-6)),
    "delay": lambda: sos.design_delay_pid(CART, tau=3.0, delta=5.0),
    "ticks": lambda: sos.design_sampled(
        CART, P_ALONE, T=0.1, sigma=2.0, search=sos.Search(starts=1)),
}  # fmt: skip
GIVEN = dict(
    t=[0, 1], T=0.01, whole=CART, folder="nowhere", delay=0.1, longest=1.0, w=None
)


@pytest.mark.parametrize("name", WITHOUT)
def test_each_question_to_a_design_without_a_gain_has_an_answer_in_words(name):
    design = WITHOUT[name]()
    assert design.K is None and design.gains == {} and not design.certify()
    assert design.reason
    refused = []
    for word in dir(type(design)):
        if word.startswith("_") or word == "to_cvxpy":
            continue
        try:
            found = getattr(design, word)
            if inspect.ismethod(found):
                needed = inspect.signature(found).parameters.values()
                needed = [p for p in needed if p.kind < 4 and p.kind != 2]
                needed = [p.name for p in needed if p.default is p.empty]
                found(**{x: GIVEN[x] for x in needed})
        except ValueError as error:  # nothing else is raised
            refused += [word] * ("there is no gain" in str(error))
            assert "nan" not in str(error), (word, str(error))
    for word in ("controller", "report", "simulate", "poles", "gain"):
        assert word in refused or not hasattr(type(design), word), (word, refused)
    clock = {} if name == "ticks" else dict(T=0.01)
    with pytest.raises(ValueError, match=f"{design.status}: there is no gain") as said:
        design.controller(**clock)
    assert design.reason in str(said.value)


def test_a_design_with_delay_has_a_controller():
    design = sos.design_delay_pid(CART, tau=0.2, delta=0.1)
    c = design.controller(T=0.05, delay=0.2)
    (F,) = sampled_loop(CART, design.K, 0.05, 0.2)
    seen = abs(np.linalg.eigvals(F)).max()
    assert c.radius == pytest.approx(seen, rel=1e-6) and c.certify().proven
    np.testing.assert_allclose(design.gains.gain.K, design.K)


@pytest.mark.parametrize("ask", [
    lambda: sos.certify_sampled(CART, [[-1, -1.5]], (0.2, 0.3), time_limit=1e-9),
    lambda: sos.furthest_sampled(CART, [[-1, -1.5]], (0.2, 0.3), time_limit=1e-9),
    lambda: sos.furthest_sampled(
        CART, [[-1, -1.5]], (0.2, 0.3), rate=0.99, find="rate", time_limit=1e-9
    ),
])  # fmt: skip
def test_what_the_time_ended_answers_as_any_other_proof(ask):
    late = ask()
    again = sos.sampled.SampledProof.of(late.data)
    for proof in (late, again):
        assert not proof.proven and "time_limit" in str(proof)
        assert proof.cells == () and proof.rate in (1.0, 0.99) and proof.norm is None
        assert proof.T == (0.2, 0.3) and proof.delay == 0 and proof.centre == 0
        assert np.array_equal(proof.K, [[-1, -1.5]])


def test_a_rate_at_the_very_edge_is_undecided_in_words():
    """The radius meets the rate to a billionth: sums of powers overflow."""
    drive = sos.DescriptorSystem([[1.0]], [[-1.0]], [[500.0]])
    law = sos.PIDLaw(position=[[1]], integrate=True)
    design = sos.design_sampled(drive, law, 1e-3, 1e-3, sigma=405.3118960206424)
    assert design.status == "undecided" and design.reason
    for radius in (0.5, 1 - 1e-12):
        plant = sos.DescriptorSystem([[1]], [[0]], [[1]])
        K = [[radius - 1]]  # at T = 1 the loop is x(k+1) = radius x(k)
        for rate in (np.nextafter(radius, 0), radius, np.nextafter(radius, 1)):
            proof = sos.certify_sampled(plant, K, 1.0, rate=rate, digits=17)
            assert not proof.proven or rate >= radius, (radius, rate)


def test_powers_that_overflow_are_infinite_and_no_warning():
    for F in ([[1.0, 1], [0, 1]], [[2.0]], [[1 + 1e-9]], [[1e200]]):
        X = discrete_lyapunov(np.array(F), np.eye(len(F)))
        assert np.isinf(X).all() or abs(X).max() > 1e15
    for F in ([[0.5]], [[0.9, 1e8], [0, 0.9]], [[0.999999]]):
        F = np.array(F)
        X = discrete_lyapunov(F, np.eye(len(F)))
        gap = F.T @ X @ F - X + np.eye(len(F))
        assert abs(gap).max() < 1e-9 * abs(X).max()
