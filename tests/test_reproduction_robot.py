"""The rows of chapters 23 and 24: the printed laws on a robot."""

import re

import control
import numpy as np
import pytest

from sosbook.book import thesis
from sosbook.book.reproduction import desk
from sosbook.pendulum import Firmware, Mip, SampledLaw, Sensors, simulate, vertices
from tests.gains import named

T = 0.01


@pytest.fixture(scope="module")
def verdicts(rows):
    """The rows of these chapters by their items."""
    return {
        row.item: row
        for row in rows
        if row.chapter in ("23_gains_to_samples", "24_on_the_desk")
    }


@pytest.mark.parametrize("law, R", [("pd", 1), ("pd", 5), ("pid", 2), ("pid", 5)])
def test_what_the_rows_call_unstable_grows_in_the_nonlinear_robot(verdicts, law, R):
    """From a thousandth of a degree, ideal sensors: to the limit or home."""
    K = getattr(thesis.mip(), law)[R]
    firmware = Firmware(SampledLaw.of_gain(named(K), T), stall=10**6)
    run = simulate(
        Mip.printed(), firmware, np.deg2rad(1e-3), 4.0, sensors=Sensors(ideal=True)
    )
    lost = verdicts["the controllers of Tables 4.1, 4.2 run at 100 Hz"].ours
    (lost,) = re.findall(r"wheels by differences, at once: ([^;]*)", lost)
    unstable = f"{law.upper()} R = {R}" in lost
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


def test_where_the_wheels_end(verdicts):
    """In closed form, from the two equations of motion at rest."""
    row = verdicts["PID keeps the wheels' position, PD lets it vary"]
    ends = []
    for v in vertices(Mip.printed()):
        # rest: -d theta = -e V + w and 0 = e V + w
        theta, V = -2e-3 / v.d, -1e-3 / v.e
        K = thesis.mip().pd[5][0]
        ends.append(abs((V - K[0] * theta) / K[1]))
    assert f"PD: {max(ends):.2f} rad, PID: 0.00 rad" in row.ours


@pytest.mark.parametrize(
    "law, R, volts, item",
    [("pd", 1, 7.4, "V doesn't exceed 7.4 V"), ("pid", 5, 3.0, "both stay within 3 V")],
)
def test_up_to_which_tilt_the_voltage_stays_below(verdicts, law, R, volts, item):
    """The peak is at the first tick, K theta."""
    K = getattr(thesis.mip(), law)[R]
    assert f"{np.degrees(volts / K[0, 0]):.1f}° (" in verdicts[item].why


def test_a_limit_cycle_is_named_without_digits(verdicts):
    text = verdicts["PD, half a tick late: noise and effort fall with R"].ours
    assert text.startswith("mean V²: PD 1: chatter, ")
    assert "PD 5: 0." in text
