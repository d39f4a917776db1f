"""The manual's table of two laws for one encoder, computed again."""

import re
from pathlib import Path

import numpy as np
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
    z = controller.simulate(1, r=[1]).x[:, :, 1]
    return (
        controller.bounds.noise().proven,
        controller.bounds.step().proven,
        controller.bounds.ramp_for(1.8),
        controller.limit(2.0).bounds.reach().step,
        100 * (z.max() - 1),
    )


def test_the_readme_has_the_figures_of_the_manual_s_table():
    table = (BOOK / "api" / "laws.md").read_text("utf-8")
    readme = (BOOK.parent / "README.md").read_text("utf-8")
    row = r"a step of 1 rad asks at most \| (.*) N m \| (.*) N m"
    law, whole = re.search(row, table).groups()
    words = " ".join(readme.split())
    assert f"asks {whole} N m for a step of 1 rad" in words
    assert f"of the same decay asks {law} (" in words


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
    weighed = pid.bounds.weights(overshoot=0.05, output="load")
    said = (BOOK / "api" / "controllers.md").read_text("utf-8")
    assert f"5 % with $b = {weighed.R.item():.2f}$" in " ".join(said.split())
    assert 0.03 < weighed.bounds.step_response(output="load").overshoot.proven < 0.05


def cart(m):
    return sos.SecondOrderSystem(m, 0.1, 1, 1)


CARTS = sos.Uncertain(cart, m=(1, 1.5))
SLOW, FAST = sos.PoleRegion(sigma=0.5), sos.PoleRegion(sigma=3)
ONE = dict(position=[[1]])
PID = sos.PIDLaw(**ONE, filter=0.05)


def observed(**more):
    whole = sos.design_pid(CARTS, region=SLOW)
    return sos.design_observer(CARTS, whole.K, C=[[1, 0]], region=FAST, **more)


def at_ticks():
    A, B = np.array([[1, 0.1], [-0.1, 0.98]]), np.array([[0], [0.1]])
    axis = sos.DescriptorSystem(np.eye(2), A, B, C=[[1, 0]], dt=0.1)
    law = sos.DynamicLaw(1, position=[[1, 0]])
    return sos.design_pid(axis, law=law, region=sos.LMIRegion.disk(0.99))


ROWS = {  # the last words of a row's second column, and what it says is designed
    "`FullState(U)`": lambda: sos.design_pid(CARTS, region=SLOW),
    "an observer": lambda: sos.design_pid(CARTS, region=SLOW).controller(
        ["z1"], T=0.01
    ),
    "`design_observer(plant, K, region=...)`": observed,
    "or where it pushes": lambda: observed(disturbance=True),
    "`reduced=True`": lambda: observed(reduced=True),
    "`PIDLaw`": lambda: sos.design_pid(CARTS, law=PID, region=SLOW),
    "0 beside it": lambda: sos.design_pid(
        CARTS, law=sos.PIDLaw(velocity=[[1]], structure=[[(None, 0)]])
    ),
    "`DynamicLaw`": lambda: sos.design_pid(
        CARTS, law=sos.DynamicLaw(1, **ONE), region=sos.PoleRegion(sigma=0.1)
    ),
    "around no law or a `PIDLaw`": lambda: sos.design_pid(
        CARTS, law=sos.Scheduled("m"), region=SLOW
    ),
    "and the same laws": at_ticks,
    "`design_delay_pid(plant, tau=..., law=...)`": lambda: sos.design_delay_pid(
        CARTS, tau=0.1, mu=0.01, delta=0.1, law=PID
    ),
    "one of these two laws": lambda: sos.design_sampled(
        CARTS, PID, T=0.02, sigma=0.3, search=sos.Search(starts=2)
    ),
}


def test_each_row_of_the_manual_s_table_is_designed_and_proven():
    text = (BOOK / "api" / "laws.md").read_text("utf-8")
    table = text[text.index("| You measure") :].split("\n\n")[0].splitlines()[2:]
    taken = [line.split(" | ")[1] for line in table]
    assert len(taken) == len(ROWS)
    for said, (words, designed) in zip(taken, ROWS.items()):
        assert said.endswith(words), said
        assert designed().certify().proven, words


@pytest.mark.parametrize("unit, lag", [(1.0, 0.01), (0.3, 9.81e-3)])
def test_a_cascade_is_one_law_with_one_proof(unit, lag):
    """Place, speed and current, each loop written out, against the manual's gains."""
    k_p, k_v, k_i = 4.0, 6.0 * unit, 9.0 * unit

    def motor(tau):  # tau c' = u - c; m z'' = c - 0.1 z'
        return sos.DescriptorSystem(
            np.diag([1, unit, tau]),
            [[0, 1, 0], [0, -0.1, 1], [0, 0, -1]],
            [[0], [0], [1]],
            C=[[1, 0, 0]],
        )

    motors = sos.Uncertain(motor, tau=(lag / 2, lag))
    law = sos.PIDLaw(position=np.eye(2, 3), integrate=[[1, 0]])
    gains = {"K_P": [[-(k_v * k_p + k_i), -k_v]], "K_I": [[-k_i * k_p]]}
    proven = sos.analyse_pid(motors, gains, law=law, region=sos.PoleRegion(sigma=1))
    assert proven.certify().proven
    own = np.zeros((4, 4))  # z, z', c, and the integral of v
    own[0, 1], own[3, :2] = 1, (-k_p, -1)
    own[1, 1:3] = np.array([-0.1, 1]) / unit
    own[2] = np.array([-k_v * k_p, -k_v, -1, k_i]) / lag
    found = np.ravel(sos.Loop(motors.at(tau=lag), law, gains).poles())
    np.testing.assert_allclose(
        np.sort_complex(found), np.sort_complex(np.linalg.eigvals(own)), atol=1e-6
    )


def test_collocated_rates_never_put_energy_into_a_machine():
    """A row of the table, by eigenvalues."""
    rng, B = np.random.default_rng(9), np.array([[1, 0], [0, 2], [1, 1]])
    brake = (None, 0)
    law = sos.PIDLaw(velocity=B.T, structure=[[brake, 0], [0, brake]])

    def machine():
        M, S = (x @ x.T for x in rng.standard_normal((2, 3, 3)))
        return sos.SecondOrderSystem(M + np.eye(3), np.zeros((3, 3)), S, B)

    for plant in (machine() for _ in range(30)):
        K_D, M = (
            law.structure(plant).matrix(np.diag(-(10 ** rng.normal(size=2)))),
            plant.M,
        )
        D = -B @ K_D @ B.T
        A = np.zeros((6, 6))
        A[:3, 3:] = np.eye(3)
        A[3:] = -np.linalg.solve(M, np.hstack([plant.S, D]))
        assert np.linalg.eigvals(A).real.max() < 1e-9
    with pytest.raises(ValueError, match="outside of the law's range"):
        sos.analyse_pid(machine(), {"K_D": [[1, 0], [0, -1]]}, law=law)
