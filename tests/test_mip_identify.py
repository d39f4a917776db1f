"""Identification: the truth is found again, and shortcuts are measured."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.signal

from sosbook.pendulum import Mip, log_fits
from sosbook.pendulum.experiments import chirp, motion, motion_slopes
from sosbook.pendulum.fit import output_error
from sosbook.pendulum.identify import fit_body, fit_wheel, identify, speed
from sosbook.pendulum.log import Log
from sosbook.pendulum.rig import Rig, shipped
from sosbook.pendulum.srivc import respond, srivc
from sosbook.pendulum.transfer import bode_band, constrained, equal_peaks

ORIGINAL = [-30.11, -52.49], [1, 7.133, 110.6]  # (4.19)


@pytest.fixture(scope="module")
def ideal():
    rig = Rig(ideal=True)
    return rig.ratios, rig.body(), rig.wheels()


@pytest.fixture(scope="module")
def found():
    return identify(shipped("body"), shipped("wheels"))


def head(log, seconds):
    """The first seconds of a log."""
    return log.part(slice(round(seconds / log.T)))


def bias(fit, truth):
    """In percent, of what both have."""
    return {x: 100 * (fit[x] / truth[x] - 1) for x in fit.names if x in truth}


def test_the_pendulum_is_found_exactly_without_noise(ideal):
    truth, body, _ = ideal
    assert max(map(abs, bias(fit_body(body), truth).values())) < 1e-3


def test_both_wheels_are_found_exactly_without_noise(ideal):
    truth, _, wheels = ideal
    first, second = fit_wheel(wheels, 1), fit_wheel(wheels, 2)
    assert max(map(abs, bias(first, truth).values())) < 1e-4
    assert second["e_a"] / first["e_a"] == pytest.approx(208.5 / 208.8)
    assert second["f_a"] / first["f_a"] == pytest.approx(33.32 / 33.02)


def test_shipped_logs_give_the_truth_within_their_confidence(found, ideal):
    truth = ideal[0]
    second = {"e_a": truth["e_a"] * 208.5 / 208.8, "f_a": truth["f_a"] * 33.32 / 33.02}
    fits = (found.body, truth), *zip(found.wheels, (truth, second))
    for fit, real in fits:
        for name in bias(fit, real):
            low, high = fit.interval(name, 0.99)
            assert low < real[name] < high
            assert (high - low) / real[name] < 0.005
    low, high = found.body.interval("offset", 0.99)
    assert low < np.deg2rad(0.5) < high


def test_the_pendulum_of_the_shipped_logs(found):
    """The two wheels' mean, so one part in a thousand off wheel 1."""
    truth = Mip.printed()
    for x in "abcdef":
        assert getattr(found.mip, x) == pytest.approx(getattr(truth, x), rel=3e-3)
    assert found.contradiction == pytest.approx(1, abs=0.006)
    assert found.polytope(0.04).N == 4
    assert found.polytope().vertices[0].M[0, 0] == found.mip.c
    C = found.covariance
    assert list(found.ratios) == ["e_c", "f_c", "d_c", "e_a", "f_a"]
    assert np.allclose(C, C.T) and (np.linalg.eigvalsh(C) > 0).all()
    assert not C[:3, 3:].any()
    assert C[4, 4] == pytest.approx(sum(wheel.sd[1] ** 2 for wheel in found.wheels) / 4)


def test_own_masses_reach_the_pendulum(found):
    body, wheels = head(shipped("body"), 10), head(shipped("wheels"), 10)
    other = identify(body, replace(wheels, encoder2=None), M_b=0.3)
    assert len(other.wheels) == 1
    assert other.mip.d == pytest.approx(0.3 / 0.272 * found.mip.d)


def test_linear_fits_are_biased_at_the_text_s_voltage(ideal):
    """A swing of 49 degrees; d/c suffers most, and 4 % don't hold it."""
    truth, body, _ = ideal
    off = bias(fit_body(body, "linear"), truth)
    assert off["d_c"] == pytest.approx(-6.2, abs=0.1)
    assert off["e_c"] == pytest.approx(2.0, abs=0.1)
    assert off["f_c"] == pytest.approx(2.4, abs=0.1)
    off = bias(fit_body(body, "free zero"), truth)
    assert off["d_c"] == pytest.approx(-5.8, abs=0.1)


def test_plain_differencing_biases_the_wheels(ideal):
    """Exact encoders, and yet: half a period of delay is the cause."""
    truth, _, wheels = ideal
    off = bias(fit_wheel(wheels, differencing="plain"), truth)
    assert off["e_a"] == pytest.approx(-26.4, abs=0.2)
    assert off["f_a"] == pytest.approx(-33.6, abs=0.2)


@pytest.mark.slow
def test_friction_is_found_and_not_taken_for_damping(ideal):
    truth, rig = ideal[0], Rig(friction=0.3)
    body, wheels = head(rig.body(), 12), head(rig.wheels(), 12)
    plain, rubbing = fit_wheel(wheels), fit_wheel(wheels, friction=True)
    assert plain["f_a"] > 1.2 * truth["f_a"]
    assert rubbing["friction"] == pytest.approx(0.3, rel=0.02)
    assert max(map(abs, bias(rubbing, truth).values())) < 0.5
    fit = fit_body(body, friction=True)
    assert fit["friction"] == pytest.approx(0.3, rel=0.02)
    assert max(map(abs, bias(fit, truth).values())) < 0.1


def test_confidence_is_neither_boast_nor_modesty(ideal):
    """Where the encoder starts between two counts is its only noise."""
    truth, _, wheels = ideal
    random, z = np.random.default_rng(1), []
    for _ in range(12):
        count = np.floor(wheels.encoder1 + random.random())
        fit = fit_wheel(Log(wheels.t, wheels.V, encoder1=count))
        z.append(
            [(fit[x] - truth[x]) / fit.sd[i] for i, x in enumerate(("e_a", "f_a"))]
        )
    assert 0.4 < np.sqrt(np.mean(np.square(z))) < 1.6


def test_coloured_residuals_count_as_such():
    """A mean of differenced noise is known far better than of white."""
    random = np.random.default_rng(0)
    white = random.standard_normal(4001)
    ones = np.ones(4000)
    fits = [
        output_error(lambda x: x * ones, y, {"mean": 0.1})
        for y in (white[1:], np.diff(white))
    ]
    assert fits[0].sd[0] == pytest.approx(4000**-0.5, rel=0.25)
    assert fits[1].sd[0] < 0.2 * fits[0].sd[0]


def test_the_gain_of_4_20_follows_from_equal_peaks():
    k = equal_peaks(*ORIGINAL)
    assert round(k, 2) == -30.52
    s = 1j * np.linspace(5, 20, 100_000)
    peaks = [
        abs(np.polyval(b, s) / np.polyval(ORIGINAL[1], s)).max()
        for b in (ORIGINAL[0], [k, 0])
    ]
    assert peaks[0] == pytest.approx(peaks[1], rel=1e-8)


def test_a_peak_at_zero_frequency_counts():
    assert equal_peaks([0.1, 50], [1, 30, 100]) == pytest.approx(50 / 100 * 30)
    assert equal_peaks([1, 1], [1, 10, 1]) == pytest.approx(10)


def test_the_refit_of_4_19_moves_the_stiffness():
    """With the same answer to the chirp, d/c is 12 % less than (4.20)."""
    t, V = chirp(1, 20)
    fit = constrained(*ORIGINAL, V, t[1])
    assert fit["d_c"] / 110.6 == pytest.approx(0.88, abs=0.005)
    answer = respond(*ORIGINAL, V, t[1])
    moved = respond([equal_peaks(*ORIGINAL), 0], ORIGINAL[1], V, t[1])
    assert fit.rms < np.sqrt(np.mean((answer - moved) ** 2))
    same = constrained([-30.52, 0], ORIGINAL[1], V, t[1])
    assert np.allclose(same.values, [30.52, 7.133, 110.6], rtol=1e-6)


def test_the_band_of_figure_4_4():
    """Against scipy's bode; +-4 % is a third of a decibel."""
    H = [-30.52, 0], [1, 7.133, 110.6]
    omega = np.geomspace(1, 200, 30)
    low, middle, high = bode_band(*H, omega)
    assert np.allclose(middle, scipy.signal.bode(H, omega)[1])
    assert np.allclose(high - middle, 20 * np.log10(1.04))
    assert np.allclose(low - middle, 20 * np.log10(0.96))


@pytest.mark.parametrize(
    "numerator, denominator",
    [([2.0], [1, 3.0]), ([5, 1.0], [1, 7, 110.0]), ([3.0], [1, 4, 0.0])],
)
def test_responses_are_scipy_s(numerator, denominator):
    t, V = chirp(1, 20, seconds=1)
    _, y, _ = scipy.signal.lsim((numerator, denominator), V, t, interp=False)
    assert np.allclose(respond(numerator, denominator, V, t[1]), y)


def test_srivc_has_no_bias_from_noise():
    """20 % of noise; least squares on the same filters are far off."""
    random = np.random.default_rng(5)
    t, V = chirp(1, 20)
    y = respond([-30, 0], [1, 7, 110], V, t[1])
    y = y + 0.2 * y.std() * random.standard_normal(len(t))
    B, A = srivc(V, y, t[1], [1], 2, cutoff=40.0)
    assert np.allclose([-B[0], *A], [30, 7, 110], rtol=0.02)
    B, A = srivc(V, y, t[1], [1], 2, cutoff=40.0, rounds=1)
    assert abs(A[0] / 7 - 1) > 0.05  # one round is least squares


def test_speed_is_in_radians_per_second():
    log = Log([0, 0.1, 0.2], [0, 0, 0], encoder1=[0, 50, 150])
    assert np.allclose(speed(log, counts=100), [10 * np.pi, 20 * np.pi])


def test_errors(ideal):
    body, wheels = head(ideal[1], 3), head(ideal[2], 3)
    still = replace(body, V=0 * body.V)
    asleep = replace(wheels, encoder1=0 * wheels.t)
    for log, message in [
        (wheels, "no column gyro; it needs t, V, gyro"),
        (replace(body, gyro=-body.gyro), "e_c = .* sign of the gyro"),
        (still, "no motion, or no voltage"),
    ]:
        with pytest.raises(ValueError, match=message):
            fit_body(log)
    for log, message in [
        (body, "no column encoder1"),
        (replace(wheels, V=-wheels.V), "e_a = .* sign of encoder1"),
        (asleep, "no motion, or no voltage"),
    ]:
        with pytest.raises(ValueError, match=message):
            fit_wheel(log)
    for call, message in [
        (lambda: fit_body(body, "gray"), "model must be one of"),
        (lambda: fit_body(body, "linear", friction=True), "pendulum"),
        (lambda: fit_wheel(wheels, 3), "wheel must be 1 or 2"),
        (lambda: fit_wheel(wheels, differencing="no"), "differencing must"),
        (lambda: fit_wheel(wheels, 1, "plain", friction=True), "modelled"),
        (lambda: identify("body.csv", wheels), r"log_body must be a Log"),
        (lambda: identify(body, None), r"log_wheels must be a Log"),
        (lambda: equal_peaks([1, 0], [2, 1, 1]), "denominator must be"),
    ]:
        with pytest.raises(ValueError, match=message):
            call()


def test_a_fit_that_the_log_cannot_tell_apart():
    ones = np.ones(10)
    with pytest.raises(ValueError, match="doesn't determine first, second"):
        output_error(lambda x, y: (x + y) * ones, ones, {"first": 1.0, "second": 2.0})


@pytest.mark.parametrize(
    "at, steps, stick",
    [
        ((-40.0, 3.0, 60.0, 0.3), 4, 0.1),
        ((200.0, 30.0, 0.0, 0.2), 4, 0.05),
        ((12.0, 0.2, 9.81, 0.0), 1, 0.5),
    ],
    ids=["body", "wheels", "light"],
)
def test_the_slopes_of_a_motion_are_those_of_moved_numbers(at, steps, stick):
    """Uneven samples, in central differences of whole motions; lightly damped, too."""
    rng, (_, V) = np.random.default_rng(0), chirp(0.3, 8, 5)
    spans = 0.01 * (1 + 0.3 * rng.random(len(V)))

    def moved(at):
        return np.array(motion(*at[:3], V, spans, at[3], steps, stick))

    given = *moved(at), *at[:3], V, spans, at[3], steps, stick
    for k, found in enumerate(np.array(motion_slopes(*given)).transpose(2, 0, 1)):
        by = 1e-5 * (abs(at[k]) or 1) * np.eye(4)[k]
        true = (moved(at + by) - moved(at - by)) / (2 * by[k])
        if at[k]:  # friction has a corner at zero
            assert abs(found - true).max() < 2e-4 * abs(true).max()


def test_a_fit_by_slopes_is_that_by_differences(monkeypatch):
    """Of the body and the wheels, with friction."""
    body, wheels = (head(shipped(name), 5.0) for name in ("body", "wheels"))

    def fits():
        return fit_body(body, friction=True), fit_wheel(wheels, friction=True)

    def by_differences(*args, slopes=None, **how):
        return output_error(*args, **how)

    found = fits()
    monkeypatch.setattr(log_fits, "output_error", by_differences)
    for one, other in zip(found, fits()):
        assert (abs(one.values - other.values) < 1e-3 * other.sd).all()
        assert one.rms == pytest.approx(other.rms, rel=1e-9)
        assert one.sd == pytest.approx(other.sd, rel=1e-4)
