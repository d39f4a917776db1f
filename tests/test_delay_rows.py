"""Section 3.2: its rows, its errata, and what chapter 17 says of a mode."""

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import null_space
from scipy.optimize import newton

import sosbook as sos
from sosbook import delay
from sosbook.book import thesis
from sosbook.plants.descriptor import Descriptor, descriptors
from sosbook.theorems import Functional, Times, delay_stabilization
from tests.test_delay_theorems import NAMES, random_functional

HERE = ("16_delay_theorem", "17_wing_and_two_masses")
M = [[17.6, 1.28, 2.89], [1.28, 0.824, 0.413], [2.89, 0.413, 0.725]]


@pytest.fixture(scope="module")
def here(rows):
    """The rows of these chapters."""
    return [r for r in rows if r.chapter in HERE]


def row(here, item):
    found = [r for r in here if r.item.startswith(item)]
    exact = [r for r in found if r.item == item]
    (found,) = exact or found
    return found


def wing(D12, S22):
    """D and S of the wing, typed from the page."""
    D = [[7.66, D12, 2.1], [0.23, 1.04, 0.223], [0.6, 0.756, 0.658]]
    S = [[121, 18.9, 15.9], [0, S22, 0.145], [11.9, 3.64, 15.5]]
    return np.array(D), np.array(S)


@pytest.mark.parametrize(
    "D12, S22, delay, real, item",
    [
        (2.5, 27, 0.3, 0.740, "decay under the printed gains"),
        (2.45, 2.7, 0.3, 0.102, "decay under the printed gains"),
        (2.45, 27, 0.2, 0.152, "S22"),
        (2.5, 2.7, 0.2, -0.733, "D12"),
        (2.45, 2.7, 0.2, -0.733, "rate at the nominal delay"),
    ],
)
def test_rightmost_root_by_newton_on_the_determinant(here, D12, S22, delay, real, item):
    """det(s^2 M + s D + S - B (K_P + s K_D + K_I U / s) e^(-s d))."""
    D, S = wing(D12, S22)
    gains = np.array(
        [[-7.7475, 15.5212, 0.9003], [-75.0955, -4.6038, -12.3270], [-66.2748, 0, 0]]
    )

    def characteristic(s):
        matrix = s * s * np.array(M) + s * D + S
        late = gains[0] + s * gains[1] + gains[2] / s
        matrix[0] -= late * np.exp(-s * delay)
        return np.linalg.det(matrix)

    starts = [complex(a, b) for a in (-0.8, 0, 0.8) for b in (0.7, 2.5, 5.5, 8.5)]
    roots = []
    for start in starts:
        s, done = newton(
            characteristic, start, maxiter=100, full_output=True, disp=False
        )
        if done.converged and abs(characteristic(s)) < 1e-6:
            roots.append(s)
    assert abs(max(s.real for s in roots) - real) < 1e-3
    assert f"{abs(real):.3f}" in row(here, item).ours + row(here, item).why


def test_the_lost_point_hides_the_flutter():
    """Open loop, by the companion matrix; the other misprint doesn't matter."""
    poles = {
        (2.5, 27): -0.2560,
        (2.45, 27): -0.2553,
        (2.5, 2.7): 0.0964,
        (2.45, 2.7): 0.0947,
    }
    for (D12, S22), real in poles.items():
        D, S = wing(D12, S22)
        A = np.block(
            [
                [np.zeros((3, 3)), np.eye(3)],
                [-np.linalg.solve(M, S), -np.linalg.solve(M, D)],
            ]
        )
        assert abs(np.linalg.eigvals(A).real.max() - real) < 1e-4


def test_positions_at_rest_follow_from_the_stiffness(here):
    z = np.linalg.solve(wing(2.45, 2.7)[1], [1, 0, 0])
    (tracked,) = (r for r in here if r.place == "Fig. 3.18")
    printed = re.findall(r"-?\d+\.\d{3}", tracked.why)
    np.testing.assert_allclose(list(map(float, printed)), z / z[0], atol=1e-3)


def test_why_there_are_no_gains(here):
    """Its words follow from multipliers that are exact."""
    found = row(here, "Theorem 2.3 yields gains")
    assert found.ours == ("infeasible (printed data); infeasible (published data)")
    assert "infeasibility is proven on both data sets" in found.why
    for published in (False, True):
        poles = thesis.delay_example_1(published).plant.poles()
        slowest = max(poles, key=lambda s: s.real)
        assert f"the modes {slowest.real:.4g}" in found.why


def test_a_certificate_contains_one_of_the_flutter_mode():
    """The proposition of chapter 17, on a design for the wing."""
    ex = thesis.delay_example_1(published=True)
    found = sos.design_delay_pid(ex.plant, ex.U, tau=0.2, mu=0.1, delta=0.05, alpha=0.6)
    frame = found.request.frame
    (d,) = descriptors(ex.plant, ex.U)
    d = d.change(frame.left, frame.T, frame.scale)
    back = np.linalg.inv(d.E)
    A, Bu = 0.2 * back @ d.A, 0.2 * back @ d.Bu  # tau is the unit of time
    poles = ex.plant.poles() * 0.2
    slow = poles[poles.real.argmax()]
    square = (A @ A - 2 * slow.real * A + abs(slow) ** 2 * np.eye(7)) @ A
    W = null_space(square.T, rcond=1e-9)
    assert W.shape == (7, 3)
    values = {
        name: W.T @ back @ v @ back.T @ W
        for name, v in found.values.items()
        if name not in "FX"
    }
    F = W.T @ back @ found.values["F"] @ W
    X = found.values["X"] @ W
    Lambda = np.linalg.lstsq(W, A.T @ W)[0].T
    np.testing.assert_allclose(W.T @ A, Lambda @ W.T, atol=1e-9)
    np.testing.assert_allclose(
        np.poly(Lambda), [1, -2 * slow.real, abs(slow) ** 2, 0], atol=1e-9
    )
    mode = Descriptor(np.eye(3), Lambda, W.T @ Bu, np.zeros((3, 0)), None)
    delta = 0.05 * 0.2
    t = Times(1, 0.5, delta, np.exp(-2 * delta), np.exp(-3 * delta))
    v = Functional(*(values[name] for name in NAMES))
    block = delay_stabilization(mode, v, F, X, t, 0.6 / 0.2)
    assert np.linalg.eigvalsh(block)[0] > 0
    for whole in (
        np.block([[v.P, v.Q], [v.Q.T, t.epsilon1 * v.S]]),
        np.block([[v.R1, v.R2.T], [v.R2, v.R3]]),
    ):
        assert np.linalg.eigvalsh(whole)[0] > 0


@pytest.mark.parametrize("alpha", [-0.7, 0.4, 3.0])
def test_alpha_must_be_positive(alpha):
    """Along (alpha v, -v, alpha v, 0, 0) only the functional is left."""
    rng = np.random.default_rng(3)
    N, tau, mu, delta = 3, 0.7, 0.2, 0.3
    v = random_functional(rng, N)
    v = replace(v, P=random_functional(rng, N).S)  # this one positive, too
    E, A, F = rng.standard_normal((3, N, N))
    B, X = rng.standard_normal((2, N))
    plant = Descriptor(E, A, B[:, None], None, None)
    t = Times(
        tau, mu, delta, np.exp(-2 * delta * tau) / tau, np.exp(-2 * delta * (tau + mu))
    )
    form = -delay_stabilization(plant, v, F, X[None], t, alpha)
    R = np.block([[v.R1, v.R2.T], [v.R2, v.R3]])
    y = rng.standard_normal(N)
    along = np.r_[alpha * y, -y, alpha * y, np.zeros(2 * N)]
    pair = np.r_[alpha * y, -y]
    left = (
        2 * alpha * (alpha * delta - 1) * y @ v.P @ y
        + alpha**2 * (1 - np.exp(-2 * delta * tau)) * y @ v.S @ y
        + tau * pair @ R @ pair
        + 2 * mu * y @ v.Z @ y
    )
    assert along @ form @ along == pytest.approx(left, rel=1e-9)
    assert alpha > 0 or left > 0


def test_a_constant_delay_needs_no_last_block():
    """The erratum on mu = 0: with four block rows there is a proof."""
    loop = delay.DelayedLoop([[-1]], [[0.5]])
    found = sos.analyse_delay(loop, tau=1.0, mu=0.0)
    assert "Z" not in found.margins
    assert found.certify().proven
    blocks, _ = found.request.in_unknowns()
    assert blocks["decay"].constant.shape == (4, 4)
