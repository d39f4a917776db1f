"""Delays of several ticks that change at each one: the newest command is held."""

import json
import re
from itertools import product

import numpy as np
import pytest
from scipy.linalg import expm

import sosbook as sos
from sosbook.exact.proof_file import load

SWITCHED = [[0.09, 1], [-53.6, -2.77]], [[0.0], [9.81]], [[-2.19, 0.031]], 0.3


def moved(A, B, T, k, x, u, delay, oldest):
    """x(k + 1): event by event, of the commands u[j] that came delay[j] s late."""
    now, n = k * T, len(A)
    times = [j * T + delay[j] - now for j in range(k - oldest, k + 1)]
    cuts = sorted({0.0, T, *(t for t in times if 0 < t < T)})
    for a, b in zip(cuts, cuts[1:]):
        middle = now + (a + b) / 2
        come = [j for j in range(k - oldest, k + 1) if j * T + delay[j] <= middle]
        M = np.zeros((n + B.shape[1],) * 2)
        M[:n] = np.hstack([A, B]) * (b - a)
        x = (expm(M) @ np.concatenate([x, u[max(come)]]))[:n]
    return x


def growth(A, B, K, T, delays):
    """The largest eigenvalue, per tick, of a sequence of ``delays`` that repeats."""
    A, B, K = map(np.array, (A, B, K))
    (n, m), many = B.shape, len(delays)
    oldest = int(np.ceil(max(delays) / T)) + 1
    columns = []
    for e in np.eye(n + m * oldest):
        x, u = e[:n], {-1 - i: e[n + i * m :][:m] for i in range(oldest)}
        late = {j: delays[j % many] for j in range(-oldest, many)}
        for k in range(many):
            u[k] = K @ x
            x = moved(A, B, T, k, x, u, late, oldest)
        columns.append(np.concatenate([x, *(u[many - 1 - i] for i in range(oldest))]))
    return abs(np.linalg.eigvals(np.array(columns).T)).max() ** (1 / many)


def test_delays_that_are_stable_each_and_unstable_in_turn_are_not_proven():
    A, B, K, T = SWITCHED
    assert max(growth(A, B, K, T, (d,)) for d in np.linspace(0, 0.6, 25)) < 0.97
    assert growth(A, B, K, T, (0, 0, T)) > 1.01
    plant = sos.DescriptorSystem(np.eye(2), A, B)
    for delay in ((0, 0.45), (0.0, 0.6)):
        proof = sos.certify_sampled(plant, K, T, delay)
        assert not proof.proven and proof.claims == ()
    assert sos.certify_sampled(plant, K, T, (0.3, 0.6)).proven


CASES = {
    "light": ([[0, 1], [-9, -0.1]], [[0], [1]], [[1.5, -0.9]], 0.05, (0, 0.12)),
    "rough": ([[0.2, 1, 0], [-4, -0.3, 0.3], [0, 0, -9.81]],
              [[0, 0.3], [1, 0], [9.81, 1]],
              [[-0.5, -1.2, -0.1], [0.2, -0.3, -0.2]], 0.03, (0.011, 0.1)),
    "mass": ([[0, 1], [0, 0]], [[0], [1]], [[-1, -1.5]], 0.1, (0.05, 0.4)),
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_the_proven_matrix_falls_at_each_tick_of_any_sequence(case):
    """x'Px of the file, at the ticks of a simulation that knows arrivals alone."""
    A, B, K, T, (early, late) = CASES[case]
    A, B, K = map(np.array, (A, B, K))
    plant = sos.DescriptorSystem(np.eye(len(A)), A, B)
    rate = 0.999
    proof = sos.certify_sampled(plant, K, T, (early, late), rate=rate)
    assert proof.proven and "the newest command that has arrived" in proof.claims[0]
    assert proof.verify() and proof.examined.alone
    _, found = type(proof).examine(proof.data | {"rate": "0.5"})
    assert not found.proven and not found.claims
    (_, (P,)), oldest = *proof.cells, int(np.ceil(late / T))
    rng, worst = np.random.default_rng(3), 0.0
    u = {j: rng.normal(size=B.shape[1]) for j in range(-oldest - 1, 0)}
    x, delay = rng.normal(size=len(A)), dict.fromkeys(range(-oldest - 1, 0), late)
    for k in range(400):
        u[k] = K @ x
        ends = rng.random() < 0.5
        delay[k] = rng.choice([early, late]) if ends else rng.uniform(early, late)
        state = np.concatenate([x, *(u[k - 1 - i] for i in range(oldest))])
        x = moved(A, B, T, k, x, u, delay, oldest)
        after = np.concatenate([x, *(u[k - i] for i in range(oldest))])
        worst = max(worst, (after @ P @ after) / (state @ P @ state))
        if np.linalg.norm(x) < 1e-6:
            x = rng.normal(size=len(A))
            u = {j: rng.normal(size=B.shape[1]) for j in u}
    assert 0.5 < worst < rate**2
    for delays in product((early, (early + late) / 2, late), repeat=3):
        assert growth(A, B, K, T, delays) < rate


def test_a_rate_that_one_constant_delay_breaks_is_refused_by_its_name():
    A, B, K, T, delay = CASES["light"]
    plant = sos.DescriptorSystem(np.eye(2), A, B)
    true = max(growth(A, B, K, T, (d,)) for d in np.linspace(*delay, 25))
    proof = sos.certify_sampled(plant, K, T, delay, rate=float(f"{true - 2e-3:.6f}"))
    assert "ticks ago" in str(proof) and "spectral radius" in str(proof)


def test_a_controller_with_an_observer_is_proven_for_a_range_of_ticks(tmp_path):
    def drive(m):
        return sos.SecondOrderSystem(m, 0.4, 2, 1, 1)

    family = sos.Uncertain(drive, m=(0.9, 1.1))
    d = sos.design_pid(family, region=sos.PoleRegion(1, rho=9))
    c = d.controller(["z1"], T=0.01, delay=(0, 0.025))
    proof = c.certify()
    assert proof.proven and c.timing.whole_samples == 2
    assert "every constant plant with m in [0.9, 1.1]" in proof.claims[0]
    still, place = abs(c.static(w=[1])[0][:, 0]).max(), sos.Output(position=[[1]])
    for share, good in ((1.5, True), (0.98, False)):  # a load that stays
        asked = sos.HInfinity(float(share * still), outputs=place)
        assert c.certify(norm=asked).proven == good
    said = re.sub(r"\s+\*?\s*", " ", c.to_c().gains)
    assert "by an enclosure of one program: the sampled loop" in said
    assert "ticks 0.01 s apart, acting 0 to 0.025 s late" in said
    path = tmp_path / "proof.json"
    proof.save(path)
    again = load(path)
    assert again.claims == proof.claims
    data = json.loads(json.dumps(again.data))
    for parts in (0, 5, "1", None):  # a tick has no such parts
        data["cells"] = {**again.data["cells"], "parts": parts}
        with pytest.raises(ValueError):
            type(proof).examine(data)


def test_no_range_and_no_jitter_beside_it_is_taken_for_one():
    plant = sos.SecondOrderSystem(1, 1, 1, 1)
    with pytest.raises(ValueError, match="over 9 ticks"):
        sos.certify_sampled(plant, [[-1, -1]], 0.1, (0, 0.9))
    with pytest.raises(ValueError, match="isn't always within one interval"):
        sos.certify_sampled(plant, [[-1, -1]], (0.1, 0.2), (0, 0.3))
