"""Counters that go over their end: read as ones that go on, and said."""

from dataclasses import replace

import numpy as np
import pytest

from sosbook.pendulum import Robot
from sosbook.pendulum.counters import Counter
from sosbook.pendulum.identify import speed
from sosbook.pendulum.log import Log
from sosbook.pendulum.log_checks import check_log
from sosbook.pendulum.recorded import check_recording
from sosbook.pendulum.rig import shipped
from tests.corrupted import both, rewritten, spikes, wrapped
from tests.six_robots import SIX
from tests.six_robots import logs as record

WHEELS, BODY = shipped("wheels"), shipped("body")
THESIS = Robot.shipped("thesis")
BITS = (8, 12, 16, 24, 32)


def of_bits(bits, signed, start, turn=1):
    """The shipped wheels by such counters; the wheels begin at ``start``."""
    size = 2**bits
    least = -size // 2 if signed else 0
    return both(WHEELS, lambda n: wrapped(turn * n + start, size, least))


def texts(findings, severity):
    return " ".join(str(f) for f in findings if f.severity == severity)


@pytest.mark.parametrize("turn", [1, -1])
@pytest.mark.parametrize("signed", [True, False])
@pytest.mark.parametrize("bits", BITS)
def test_a_counter_that_goes_over_its_end_goes_on(bits, signed, turn):
    """Forward and backward, over the end once, or many times on its way."""
    end = 2 ** (bits - 1) if signed else 2**bits
    for start in (end - 5, end - 600, -end + 5 if signed else 3, end - 1200):
        log = of_bits(bits, signed, start, turn)
        for wheel in (1, 2):
            assert np.array_equal(speed(log, wheel), turn * speed(WHEELS, wheel))
        given = wrapped(turn * WHEELS.encoder1 + start, 2**bits, end - 2**bits)
        wraps = np.flatnonzero(abs(np.diff(given)) > 2 ** (bits - 1)) + 1
        findings = check_log("wheels", log)
        assert not texts(findings, "refused")
        assert ("encoder1" in log.unwrapped) == bool(len(wraps))
        if not len(wraps):  # it never came to its end
            assert not texts(findings, "warning")
            continue
        assert log.unwrapped["encoder1"].bits == bits
        assert np.array_equal(log.unwrapped["encoder1"].wraps, wraps)
        row, t = wraps[0] + 2, log.t[wraps[0]]
        assert (
            f"encoder1 is of a counter of {bits} bits, which goes over its end "
            f"{len(wraps)} time(s), first in row {row} (t = {t:g} s)"
        ) in texts(findings, "warning")


def test_a_file_of_such_a_counter_gives_the_same_robot(tmp_path):
    rows = zip(WHEELS.t, WHEELS.V, wrapped(WHEELS.encoder1 - 40, 2**32, 0))
    lines = ["t,V,encoder1", *(f"{t:.3f},{V:.3f},{n:.0f}" for t, V, n in rows)]
    (tmp_path / "wheels.csv").write_text("\n".join(lines), "utf-8")
    seen = check_recording(tmp_path / "wheels.csv", THESIS)
    plain = replace(WHEELS, encoder2=None)
    plain.write(tmp_path / "plain.csv")
    same = check_recording(tmp_path / "plain.csv", THESIS)
    assert seen.usable and "counter of 32 bits" in seen.report
    assert seen.fits[0].values == pytest.approx(same.fits[0].values, rel=1e-9)
    # what is written again goes on, in as many digits as it needs
    seen.log.write(tmp_path / "again.csv")
    again = Log.read(tmp_path / "again.csv")
    assert np.array_equal(again.encoder1, WHEELS.encoder1 - 40) and not again.unwrapped


@pytest.mark.parametrize("bits", BITS)
def test_random_ways_are_found_again(bits):
    """Of as much as a quarter of all numbers between two samples."""
    random = np.random.default_rng(bits)
    size, found = 2**bits, 0
    for _ in range(30):
        most = int(size * random.uniform(0.01, 0.24))
        way = np.cumsum(random.integers(-most, most + 1, 600)) + size // 2
        counter = Counter.of(way % size)
        if counter is None:  # it stayed within
            assert np.array_equal(way % size, way)
            continue
        found += 1
        assert counter.bits == bits and not len(counter.wild)
        assert np.array_equal(np.diff(counter.counts), np.diff(way))
    assert found > 20


def test_counts_that_nobody_wraps_stay_as_they_are():
    assert WHEELS.unwrapped == {}
    for machine in SIX[1::2]:
        _, (t, V, *counts) = record(machine, seconds=5.0)
        assert Log(t, V, None, *counts).unwrapped == {}
    t = np.arange(3000) * 0.01
    for top in (90, 120, 127):  # fast, and almost as wide as 8 bits
        wave = np.round(top * np.sin(2 * np.pi * (t + 0.7 * t**2)))
        counter = Counter.of(wave)
        assert len(counter.wild) and np.array_equal(counter.counts, wave)
    assert Counter.of([0.5, 250.0]) is None and Counter.of([0, 2.0**33]) is None


def farthest(n, value, size):
    """Three samples of numbers n, apart, at which a value is farthest off."""
    off = abs((n - value + size / 2) % size - size / 2)
    places = []
    for k in np.argsort(-off):
        if all(abs(k - other) > 50 for other in places) and 0 < k < len(n) - 1:
            places.append(k)
        if len(places) == 3:
            return places
    raise AssertionError


@pytest.mark.parametrize("start", [-700, -300])
@pytest.mark.parametrize(
    "value", [-1, 0, 0.5], ids=["all ones", "all zeros", "one bit"]
)
@pytest.mark.parametrize("bits", [8, 16, 32])
def test_glitches_are_refused_of_a_counter_that_goes_over_its_end(bits, value, start):
    """A reading that is wrong by itself is no end of a counter."""
    size = 2**bits

    def spoilt(n):
        n = (n + start) % size
        wrong = value % size if isinstance(value, int) else size // 2
        places = farthest(n, wrong, size)
        assert len(np.flatnonzero(abs(np.diff(n)) > size / 2))  # it goes over it
        n[places] = wrong
        return n

    text = texts(check_log("wheels", rewritten(WHEELS, encoder1=spoilt)), "refused")
    assert "encoder1 has" in text and "spike(s)" in text, text


@pytest.mark.parametrize("bits", [8, 12, 16])
def test_spikes_of_any_size_are_refused(bits):
    log = rewritten(WHEELS, encoder1=lambda n: spikes(n % 2**bits, 2 ** (bits - 1)))
    assert "spike(s)" in texts(check_log("wheels", log), "refused")


def test_a_counter_that_is_too_small_for_its_speed_is_named():
    log = both(WHEELS, lambda n: wrapped(16 * n, 256, 0))
    text = texts(check_log("wheels", log), "refused")
    assert "encoder1 seems to be of a counter of 8 bits" in text
    assert "count in more bits" in text and "spike" not in text


@pytest.mark.parametrize("span", [1.9, 1.5, 1.0])
def test_a_gyro_that_goes_over_its_end_is_named(span):
    """Its number begins anew at the other end: an int16 that overflows."""
    numbers = span * abs(BODY.gyro).max()
    log = rewritten(BODY, gyro=lambda g: wrapped(g, numbers))
    text = texts(check_log("body", log), "refused")
    assert "goes on at the other end. Widen the gyro's range" in text
    assert "glitch" not in text
    assert "glitch" in texts(
        check_log("body", rewritten(BODY, gyro=lambda g: spikes(g, 30.0))), "refused"
    )
