"""A clock that varies, from its proof to the program; and one that is far too slow."""

import warnings

import numpy as np
import pytest
from scipy.linalg import expm

import sosbook as sos
from sosbook.controllers import Replay

T, JITTER, LATE = 0.01, 0.002, (0.001, 0.006)
ARM = sos.SecondOrderSystem(0.3, 0.05, -9.81, 1, F=[[1]], coordinates=["arm"])
DESIGN = sos.design_pid(ARM, region=sos.PoleRegion(3, rho=30))


def varying(**more):
    return DESIGN.controller(T=T, delay=LATE, jitter=JITTER, **more)


def test_the_range_is_proven_and_stands_in_header_report_and_file(tmp_path):
    c = varying()
    proof = c.certify()
    assert proof.proven and proof.T == (0.008, 0.012) and proof.delay == LATE
    code = c.to_c("arm")
    said = "sampling intervals in [0.008, 0.012] s and delays in [0.001, 0.006] s"
    lines = dict(code.facts)["proven"]
    assert any(said in line for line in lines)
    assert any("more than 0.002 s off" in line for line in lines)
    report = DESIGN.report(tmp_path / "arm", controller=c).read_text("utf-8")
    assert said in report and "0.008 to 0.012 s apart" in report
    plain = DESIGN.controller(T=T, delay=LATE[1])
    assert not plain.clock.varies and "apart" not in str(plain.to_c("arm").facts)


def test_the_program_takes_each_tick_that_is_proven():
    """Against the plant between its ticks by expm, at the ends of both ranges too."""
    c, rng = varying(), np.random.default_rng(3)
    whole = np.zeros((3, 3))
    back = np.linalg.inv(ARM.M)
    whole[:2] = np.block([[np.zeros((1, 1)), np.eye(1), np.zeros((1, 1))],
                          [-back @ ARM.S, -back @ ARM.D, back @ ARM.B]])  # fmt: skip
    for ends in (True, False):
        program, x, acting, elapsed = Replay(c), np.array([0.2, 0.0]), 0.0, None
        program.start(c.readings.rows @ x)
        for _ in range(400):
            u = program.step(
                c.readings.rows @ x, np.zeros(len(c.set_points)), elapsed
            ).item()
            assert not program.fault.any()
            pick = rng.choice if ends else lambda pair: rng.uniform(*pair)
            elapsed, wait = pick((T - JITTER, T + JITTER)), pick(LATE)
            for now, span in ((acting, wait), (u, elapsed - wait)):
                x = (expm(whole * span) @ np.r_[x, now])[:2]
            acting = u
        assert abs(x).max() < 1e-6


def test_a_watch_that_faults_at_proven_ticks_is_refused():
    c = varying()
    assert c.watch(lost=0.02).faults.slack == c.faults.slack >= JITTER / T
    assert c.watch(slack=0.2).faults.slack == c.faults.slack
    assert c.watch(slack=0.5).faults.slack == 0.5
    with pytest.raises(ValueError, match=r"slack = 0.1 is below 0.2: .* 0.002 s early"):
        c.watch(slack=0.1)
    steady = DESIGN.controller(T=T)
    assert steady.faults.slack == 0.1 == steady.watch(slack=0.1).faults.slack
    assert DESIGN.controller(T=T, jitter=0.0005).faults.slack == 0.1


def test_clocks_that_cant_be_are_named():
    for asked, words in (
        (dict(jitter=-0.1), "jitter must"),
        (dict(jitter=T), "jitter = 0.01 s must be below T"),
        (dict(delay=(0.01, 0)), r"delay must be a number or \(low, high\)"),
        (dict(delay=(0, 1, 2)), r"delay must be a number or \(low, high\)"),
        (dict(delay=0.02, jitter=0.001), "isn't always within one interval"),
    ):
        with pytest.raises(ValueError, match=words):
            DESIGN.controller(T=T, **asked)


def test_a_searched_law_has_a_clock_that_varies_too():
    cart = sos.SecondOrderSystem(1, 0, 0, 1)
    law = sos.PIDLaw(position=[[1]], filter=0.5)
    c = sos.design_sampled(cart, law, T=0.5, search=sos.Search(starts=2)).controller(
        jitter=0.01
    )
    assert c.certify().proven and c.certify().T == (0.49, 0.51)


def test_milliseconds_taken_for_seconds_are_warned_of_by_both_numbers():
    pole = abs(DESIGN.poles()).min()
    damped = sos.SecondOrderSystem(1, 2, 1.5, 1)
    slow = sos.analyse_pid(damped, [[-0.1, 0]])
    for design, late in ((slow, 10.0), (DESIGN, 1.01 / pole)):
        with pytest.warns(UserWarning) as seen:
            design.controller(T=late)
        (words,) = {str(w.message) for w in seen}
        assert f"sampled {1 / late:.3g} times" in words
        assert f"{abs(design.poles()).min():.3g} rad/s" in words
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for quick in (0.99 / pole, 0.01):
            DESIGN.controller(T=quick)
