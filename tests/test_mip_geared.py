"""Robots as shops sell them, by a simulator of their own, from logs to programs."""

from dataclasses import replace

import numpy as np
import pytest
from sosbook.mip import Robot
from sosbook.mip.gate import Inspection, refused
from sosbook.mip.log import Log

from sosbook.pendulum.log_fits import fit_wheel
from sosbook.pendulum.recording import AMPLITUDE_SHARES, sweeps
from tests.geared_robots import ALL, experiment, sine

SECONDS = 10.0  # either way: a third of what the recorders take


def described(machine, **changes):
    """As its owner describes it: the sheet's numbers, and a pair of scales."""
    return Robot(
        name=machine.name,
        M_b=machine.M_b,
        l=machine.l,
        r=machine.r,
        M_w=machine.M_w,
        counts=machine.counts,
        gyro_range=34.9,
        limit=machine.V_n,
        rotors=True,
        friction=True,
        T=machine.T,
        delay=machine.delay,
        jitter=machine.jitter,
        law="observer",
    ).but(**changes)


def recorded(machine, shares=AMPLITUDE_SHARES, seconds=SECONDS, seed=0):
    """Both logs, with the sweeps that the recorders make."""
    ends = sweeps(described(machine))
    return {
        name: Log(
            **experiment(
                machine,
                name,
                sine(ends[name], seconds, machine.T, share * machine.V_n),
                seed,
            )
        )
        for name, share in shares.items()
    }


def off(fit, machine):
    """How far each of a fit's ratios is from the machine's, relatively."""
    return {x: v / machine.truth[x] - 1 for x, v in fit.ratios.items()}


@pytest.mark.slow
@pytest.mark.parametrize("name", ALL)
def test_a_robot_with_play_and_coarse_counts_is_fitted(name):
    """Its logs were refused, with wrong causes, before a play was fitted."""
    machine = ALL[name]
    seen = Inspection.of(*recorded(machine).values(), described(machine))
    assert not refused(seen.findings), seen.refusal
    identified = seen.identified
    errors = off(identified, machine)
    print(name, {x: f"{100 * v:+.1f} %" for x, v in errors.items()}, seen.findings)
    assert max(map(abs, errors.values())) < 0.1, errors
    if machine.play:
        found = np.degrees(identified.body["play"])
        assert 0.2 * machine.play < found < 1.5 * machine.play


@pytest.mark.slow
def test_without_play_none_is_found():
    machine = replace(ALL["n20"], play=0.0)
    seen = Inspection.of(*recorded(machine).values(), described(machine))
    assert "play" not in seen.identified.body.names
    assert max(map(abs, off(seen.identified, machine).values())) < 0.04


@pytest.mark.parametrize("share", [0.5, 0.8])
def test_counts_that_come_seldom_are_fitted_as_angles(share):
    """Ninety a turn: of the differenced speeds nine of ten are nothing."""
    machine = ALL["hub"]
    log = recorded(machine, {"wheels": share})["wheels"]
    assert np.mean(np.diff(log.encoder1) != 0) < 0.3
    fit = fit_wheel(log, counts=machine.counts, friction=True)
    for name in ("e_a", "f_a"):
        assert fit[name] == pytest.approx(machine.truth[name], rel=0.12), name
    assert len(fit.residuals) == len(log.t) - 1
