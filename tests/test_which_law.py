"""The manual's table of two laws for one encoder, computed again."""

import re
from pathlib import Path

import pytest

import sosbook as sos

BOOK = Path(__file__).parents[1] / "book"
K = 20.0  # N m/rad
ASKED = dict(region=sos.PoleRegion(sigma=8))
CLOCK = dict(T=0.001, delay=0.001, counts=4096)


def drive(J):
    return sos.SecondOrderSystem(
        [[0.0025, 0], [0, J]],
        [[0.01, -0.01], [-0.01, 0.01]],
        [[K, -K], [-K, K]],
        [[1], [0]],
        [[0], [1]],
        coordinates=["motor", "load"],
    )


def figures(controller):
    """What the rows of the table are about."""
    assert controller.certify().proven
    z = controller.simulate(3, r=[1]).x[:, :, 1]
    return (
        controller.bounds.noise().proven,
        controller.bounds.step().proven,
        controller.bounds.ramp_for(1.8),
        controller.limit(2.0).bounds.reach().step,
        100 * (z.max() - 1),
    )


@pytest.mark.slow
def test_two_laws_for_one_encoder_differ_as_the_manual_says():
    plants = sos.Uncertain(drive, J=(0.003, 0.006))
    law = sos.PIDLaw(position=[[1, 0]], filter=0.004, integrate=True)
    pid = sos.design_pid(plants, law=law, **ASKED).controller(**CLOCK)
    start = sos.Saturation(None, [1, 1, 0, 0, 0])
    whole = sos.design_pid(
        plants, U=[[1, 0]], saturation=start, minimize="u_max", **ASKED
    ).controller(["motor"], **CLOCK)
    rows = re.findall(
        r"^\| .* \| ([\d.]+) (?:N m|rad|rad/s|%) \| ([\d.]+) (?:N m|rad|rad/s|%) \|$",
        (BOOK / "api" / "laws.md").read_text("utf-8"),
        re.MULTILINE,
    )
    typed = [tuple(map(float, column)) for column in zip(*rows, strict=True)]
    assert figures(pid) == pytest.approx(typed[0], rel=0.06)
    assert figures(whole) == pytest.approx(typed[1], rel=0.06)
