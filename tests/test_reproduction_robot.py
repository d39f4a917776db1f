"""The rows of chapters 28 and 29: the printed laws on a robot."""

import control
import numpy as np
import pytest

from sosbook import thesis
from sosbook.mip import Firmware, Mip, SampledLaw, Sensors, simulate
from sosbook.reproduction import desk

T = 0.01


@pytest.fixture(scope="module")
def verdicts(rows):
    """The rows of these chapters by their items."""
    return {row.item: row for row in rows
            if row.chapter in ("28_discretisation", "29_on_the_desk")}


@pytest.mark.parametrize("item, verdict", [
    ("the PID's program", "property holds"),
    ("Tables 4.1, 4.2 at 100 Hz: exact state, at once", "property holds"),
    ("Tables 4.1, 4.2 at 100 Hz: exact state, one tick late", "differs"),
    ("Tables 4.1, 4.2 at 100 Hz: wheels by differences, at once", "differs"),
    ("Tables 4.1, 4.2 at 100 Hz: wheels by differences, late", "differs"),
    ("the observer's controller at 100 Hz", "property holds"),
    ("PD: noise and effort fall with R", "property holds"),
    ("V doesn't exceed 7.4 V", "differs"),
    ("PD and PID stabilise quickly", "property holds"),
    ("both stay within 3 V", "differs"),
    ("PID keeps the wheels, PD/LQE less", "property holds"),
    ("PD's wheels wander, PID's stay", "property holds"),
])
def test_verdicts(verdicts, item, verdict):
    assert verdicts[item].verdict == verdict


@pytest.mark.parametrize("law, R", [("pd", 1), ("pd", 5), ("pid", 2),
                                    ("pid", 5)])
def test_what_the_rows_call_unstable_grows_in_the_nonlinear_robot(
        verdicts, law, R):
    """From a thousandth of a degree, ideal sensors: to the limit or home."""
    K = getattr(thesis.mip(), law)[R]
    firmware = Firmware(SampledLaw.of_gain(K, T), stall=10**6)
    run = simulate(Mip.printed(), firmware, np.deg2rad(1e-3), 4.0,
                   sensors=Sensors(ideal=True))
    unstable = f"{law.upper()} R = {R}" in verdicts[
        "Tables 4.1, 4.2 at 100 Hz: wheels by differences, at once"].ours
    late = np.abs(run.V[0, -100:]).max()
    assert late == 7.4 if unstable else late < 1e-3


def test_the_held_controller_without_its_fast_pole_is_printed(verdicts):
    """Our (4.29), from Table 4.3's rounded K and L, against print."""
    ours = desk.without_the_fast(desk.observer_controller(2))
    *channels, poles = thesis.mip().reduced
    assert np.allclose(np.sort(ours.poles().real), np.sort(poles), rtol=0.04)
    for k, (gain, zeros) in enumerate(channels):
        printed = control.zpk(zeros, poles, -gain)
        for s in (0.0, 5j, 50j):
            assert np.isclose(ours(s)[0, k], printed(s), rtol=0.05)


def test_a_limit_cycle_is_named_without_digits(verdicts):
    text = verdicts["PD: noise and effort fall with R"].ours
    assert text.startswith("mean V²: PD 1: chatter, ")
    assert "PD 5: 0." in text
