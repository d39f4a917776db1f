"""The H-infinity norm from a held w to the ticks, against frequencies and motions."""

import copy
import functools

import control
import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import minimize_scalar

import sosbook as sos
from sosbook.sampled import SampledProof
from tests.test_sampled_design import FEW, T, held_loop, pair, several

FELT = sos.Output(position=[[0, 1]]) & sos.Output(velocity=[[0.5, 0]], input=[[0.3]])


def peak(F, B, C, D):
    """By python-control's answers on a grid, and a search around the best."""
    system = control.ss(F, B, C, D, T)

    def gain(w):
        answers = system(np.exp(1j * np.atleast_1d(w) * T), squeeze=False)
        return np.linalg.norm(answers, 2, (0, 1))

    grid = np.linspace(0, np.pi / T, 4001)
    k = int(np.argmax(gain(grid)))
    ends = max(grid[k] - grid[1], 0), min(grid[k] + grid[1], np.pi / T)
    options = dict(xatol=1e-12)
    return -minimize_scalar(lambda w: -gain(w)[0], bounds=ends, options=options).fun


def channel(design, plant):
    """F, B, C, D from w to FELT by scipy: [z; z'; u before; x_c]."""
    F, C_c, B = held_loop(design, plant)
    C = np.zeros((2, len(F)))
    C[0, 1], C[1, 2], C[1, 5:] = 1, 0.5, 0.3 * C_c[0]
    return F, B, C, np.zeros((2, 1))


@functools.cache
def single():
    return sos.design_sampled(pair(), several().request.law, T, T, search=FEW)


def test_one_loop_loses_nothing_to_its_norm():
    true, c = peak(*channel(single(), pair())), single().controller()
    kept = c.certify(norm=sos.HInfinity(1.001 * true, outputs=FELT))
    assert kept.proven and kept.verify() and "held from tick to tick" in str(kept)
    broken = c.certify(norm=sos.HInfinity(0.99 * true, outputs=FELT))
    assert not broken.proven and "its norm is 1.0" in broken.failed[0]
    tight = sos.furthest_sampled(
        pair(), kept.K, T, T, "norm", norm=sos.HInfinity(3 * true, outputs=FELT)
    )
    assert true < tight.norm.gamma < 1.005 * true


def test_no_plant_between_exceeds_what_is_proven():
    c, some = several().controller(), np.linspace(1, 1.5, 5)
    true = max(peak(*channel(several(), pair(m))) for m in some)
    proof = c.certify(norm=sos.HInfinity(1.03 * true, outputs=FELT))
    assert proof.proven and "every constant plant of the polytope" in str(proof)
    assert not c.certify(norm=sos.HInfinity(0.99 * true, outputs=FELT)).proven
    path = SampledProof.of(copy.deepcopy(proof.data))
    assert path.proven and path.claims == proof.claims


def test_sums_of_a_clock_that_jitters_stay_below():
    """By pieces of constant input, with the worst of many random sequences."""
    c, rng = single().controller(), np.random.default_rng(0)
    norm = sos.HInfinity(20.0)
    T_range, late = (0.36, 0.44), (0.3, 0.36)
    proof = c.certify(T=T_range, delay=late, norm=norm)
    assert proof.proven and "for every sequence of" in str(proof)
    p = pair()
    n, back = 2, np.linalg.inv(p.M)
    whole = np.zeros((6, 6))
    whole[:4] = np.block([
        [np.zeros((n, n + 4))],
        [-back @ p.S, -back @ p.D, back @ p.B, back @ p.F],
    ])  # fmt: skip
    whole[:n, n : 2 * n] = np.eye(n)
    worst = 0.0
    for turn in np.linspace(0.1, 2.2, 15):
        x, own, acting, sums = np.zeros(4), np.zeros(c.order), 0.0, np.zeros(2)
        for k in range(300):
            w = np.sin(turn * k)
            step, wait = rng.uniform(*T_range), rng.uniform(*late)
            y = np.array([x[1]])
            sums += x[:2] @ x[:2], w * w
            u, own = (c.C @ own + c.D @ y).item(), c.A @ own + c.B @ y
            for now, span in ((acting, wait), (u, step - wait)):
                x = (expm(whole * span) @ np.r_[x, now, w])[:4]
            acting = u
        worst = max(worst, np.sqrt(sums[0] / sums[1]))
    assert 2 < worst < 20


def test_forged_norms_prove_nothing():
    proof = several().controller().certify(norm=sos.HInfinity(8.0))
    assert proof.proven

    def forged(change):
        data = copy.deepcopy(proof.data)
        change(data)
        return SampledProof.of(data)

    def lighter(data):
        data["frames"][0]["L"][-1][-1] = "0.5"

    def mixed(data):
        data["frames"][0]["L"][-1][0] = "0.01"

    smaller = forged(lambda data: data["norm"].update(gamma="4.5"))
    assert not smaller.proven
    for change in (lighter, mixed, lambda d: d.update(rate="0.99"),
                   lambda d: d["norm"].update(kind="region")):  # fmt: skip
        assert not forged(change).proven, change


def test_bad_norms_are_named():
    c = single().controller()
    for norm, words in (
        (3.0, "norm must be an HInfinity with a bound"),
        (sos.HInfinity(), "norm must be an HInfinity with a bound"),
        (sos.PoleRegion(1), "norm must be an HInfinity"),
        (sos.HInfinity(3, outputs=sos.Output(acceleration=1)), "jumps at the ticks"),
        (sos.HInfinity(3, inputs=[1]), "no disturbance 1"),
    ):
        with pytest.raises(ValueError, match=words):
            c.certify(norm=norm)
    ends = [[[0, 1], [-1, -k]] for k in (1, 2)]
    seen = sos.DescriptorSystem(
        np.eye(2), ends, [[0], [1]], [[0], [1]], [[[1, 0]], [[2, 0]]]
    )
    with pytest.raises(ValueError, match="differs from plant to plant"):
        sos.certify_sampled(seen, [[0, 0]], 0.1, norm=sos.HInfinity(9))
    with pytest.raises(ValueError, match="rate=1"):
        c.certify(norm=sos.HInfinity(3), rate=0.99)
