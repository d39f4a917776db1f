"""A loop has one answer: at fine ticks the continuous one, channel by channel.

The sampled loop is written here by hand, from the plant's matrices, the controller's
and the noise that the law was given; no row of it comes from the package's own loop.
"""

import functools
from itertools import product

import numpy as np
import pytest
from scipy.linalg import expm

import sosbook as sos
from sosbook.plants.descriptor import descriptors
from tests.cases import by_turns, campaign

CART = sos.SecondOrderSystem(1, 0.2, 1, 1, F=[[1, 0]])


def some(m):
    return sos.SecondOrderSystem(m, 0.4, 1, 1, F=[[1, 0]])


FAMILY = sos.Uncertain(some, m=(1, 1.5))
ROUGH = sos.SecondOrderSystem(  # unsymmetric, with two inputs, by .3 and 9.81
    0.3 * np.eye(2), 9.81 * np.array([[1, 0.2], [0.1, 1]]), [[3, 0.3], [0.1, 2]],
    [[1, 0.3], [0.2, 1]], [[1, 0], [0.3, 0]],
)  # fmt: skip
NOISE = np.array([[0, 0.7]])
PD = {"K_P": [[-1.0]], "K_D": [[-2.0]]}
SIMPLE = dict(position=[[1]], noise=NOISE)
HELD = sos.PIDLaw(**SIMPLE, filter=0.05, integrate=True), PD | {"K_I": [[-0.5]]}
FREE = sos.DynamicLaw(1, **SIMPLE, strictly_proper=False)
OWN = dict(A_c=[[-30.0]], B_c=[[30.0]], C_c=[[30.0]], D_c=[[-32.0]])
BOTH = sos.PIDLaw([[1, -0.5]], [[0, 1]], noise=NOISE)
LAWS = {  # law, its gains, plant, how w enters its readings
    "PID": (*HELD, CART, NOISE),
    "dynamic": (FREE, OWN, CART, NOISE),
    "P": (sos.PIDLaw(**SIMPLE), {"K_P": [[-1.0]]}, CART, NOISE),
    "PD": (sos.PIDLaw(**SIMPLE, filter=0.05), PD, CART, NOISE),
    "two inputs": (
        BOTH, {"K_P": [[-1], [0.3]], "K_D": [[0.2], [-2]]}, ROUGH,
        np.vstack([NOISE, 0 * NOISE]),
    ),
    "PID of a family": (*HELD, FAMILY, NOISE),
    "dynamic of a family": (FREE, OWN, FAMILY, NOISE),
    "states": (None, [[-1.0, -2.0]], CART, np.zeros((2, 2))),
    "states of a family": (None, [[-1.0, -2.0]], FAMILY, np.zeros((2, 2))),
}  # fmt: skip
IN_THE_GATE = "PID", "dynamic"
OUTPUTS = dict(position=1), dict(velocity=1), dict(input=1)
MARKED = [
    pytest.param(x, marks=() if x in IN_THE_GATE else pytest.mark.campaign)
    for x in LAWS
]
some_laws = pytest.mark.parametrize("name", MARKED)


@functools.cache
def analysed(name, *asked):
    law, gains, plant, _ = LAWS[name]
    return sos.analyse_pid(plant, gains, law=law, requirements=list(asked))


@functools.cache
def controller(name, T, delay=0.0):
    return analysed(name).controller(T=T, delay=delay)


def vertices(name):
    plant = LAWS[name][2]
    return [some(1), some(1.5)] if plant is FAMILY else [plant]


def loops(name, c, late=0):
    """(F, G, H, J) of each plant at c's ticks, from w to [x; u]; u is so ``late``."""
    read = LAWS[name][3]
    for p in vertices(name):
        n, m, q = p.n, p.m, p.p
        back, N = np.linalg.inv(p.M), 2 * p.n
        whole = np.zeros((N + m + q,) * 2)
        whole[:n, n:N] = np.eye(n)
        whole[n:N] = np.hstack([-back @ p.S, -back @ p.D, back @ p.B, back @ p.F])
        Phi, G_u, G_w = np.split(expm(whole * c.T)[:N], [N, N + m], axis=1)
        U = np.hstack(
            [c.D @ c.readings.rows, np.zeros((m, late * m)), c.C]
        )  # of x, older, own
        moves = np.hstack(
            [Phi, G_u if late else np.zeros((N, 0)), np.zeros((N, c.order))]
        )
        moves = moves if late else moves + G_u @ U
        own = np.hstack([c.B @ c.readings.rows, np.zeros((c.order, late * m)), c.A])
        F = np.vstack([moves, *[U] * late, own])
        through = c.D @ read
        G = np.vstack(
            [G_w if late else G_w + G_u @ through, *[through] * late, c.B @ read]
        )
        H = np.vstack([np.eye(N, len(F)), U])
        yield F, G, H, np.vstack([np.zeros((N, q)), through])


def rows(output, p):
    """The output's rows on [x; u]."""
    C = np.zeros((dict(input=p.m).get(*output, p.n), 2 * p.n + p.m))
    first = dict(position=0, velocity=p.n, input=2 * p.n)[next(iter(output))]
    C[:, first : first + len(C)] = np.eye(len(C))
    return C


def answers(loop, z):
    F, G, H, J = loop
    return H @ np.linalg.solve(z[:, None, None] * np.eye(len(F)) - F, G + 0j) + J


def norm(name, output, w, c, late=0):
    """The largest gain over the plants from w to an output, on a grid that narrows."""
    worst = 0.0
    for loop, p in zip(loops(name, c, late), vertices(name)):
        turns = abs(np.angle(np.linalg.eigvals(loop[0])))
        grid = np.r_[0, np.geomspace(1e-6, 1, 300) * np.pi, turns]
        for _ in range(4):
            seen = (rows(output, p) @ answers(loop, np.exp(1j * grid)))[:, :, [w]]
            sizes = np.linalg.norm(seen, 2, axis=(1, 2))
            top, order = grid[sizes.argmax()], np.sort(grid)
            k = int(np.searchsorted(order, top))
            ends = order[max(k - 2, 0)], order[min(k + 2, len(order) - 1)]
            grid = np.r_[np.linspace(*ends, 100), top]
        worst = max(worst, sizes.max())
    return worst


@some_laws
def test_fine_ticks_are_the_continuous_loop_channel_by_channel(name):
    for output, w in product(OUTPUTS, (0, 1)):
        asked = sos.HInfinity(1e90, outputs=sos.Output(**output), inputs=[w])
        request = analysed(name, asked).request
        whole = float(asked.truth(request.vertices, request.state_gain))
        far, near = (
            abs(norm(name, output, w, controller(name, T)) - whole)
            for T in (2e-3, 1e-3)
        )
        assert near <= 0.02 * whole and (near < 0.7 * far or near <= 1e-4 * whole)


@some_laws
@pytest.mark.parametrize("late", by_turns([0, 1], 1))
def test_a_proof_brackets_what_is_true_of_a_channel(name, late):
    c = controller(name, 0.02, 0.02 * late)
    for output, w in product(OUTPUTS, (0, 1)):
        true = norm(name, output, w, c, late)
        for size, kept in ((1.05, True), (0.99, False)):
            asked = sos.HInfinity(
                size * true or 1e-3, outputs=sos.Output(**output), inputs=[w]
            )
            proof = c.certify(norm=asked)
            assert proof.proven is (kept or not true), (output, w, true, str(proof))


@pytest.mark.parametrize("name", ["PID", *campaign(x for x in LAWS if x != "PID")])
def test_rest_is_where_a_simulation_ends(name):
    c = controller(name, 0.02)
    ones = [dict(w=w) for w in np.eye(2)]
    ones += [dict(r=r) for r in np.eye(len(c.set_points))]
    for one in ones:
        (x, u), run = c.static(**one), c.simulate(17 * c.T / (1 - c.radius), **one)
        for there, end in ((x, run.x[:, -1]), (u, run.u[:, -1])):
            np.testing.assert_allclose(end, there, atol=1e-7)
    assert abs(c.static(w=[0, 1])[1]).max() > 1e-3 or LAWS[name][0] is None


@pytest.mark.parametrize(
    "name", ["dynamic", *campaign(x for x in LAWS if x != "dynamic")]
)
def test_a_simulation_answers_each_disturbance_as_its_frequency_response(name):
    c, turn = controller(name, 0.02, 0.02), 0.3  # a tick
    ticks = int(17 / (1 - c.radius)) + 200
    for w in (0, 1):
        run = c.simulate(
            ticks * c.T, w=lambda t, w=w: np.eye(2)[w] * np.cos(turn * t / c.T)
        )
        t = np.arange(len(run.t))[-200:]
        wave = np.stack([np.cos(turn * t), -np.sin(turn * t)], axis=1)
        for k, loop in enumerate(loops(name, c, 1)):
            seen = np.hstack([run.x[k], run.u[k]])[-200:]
            fit, left, *_ = np.linalg.lstsq(wave, seen)
            gain = answers(loop, np.exp([1j * turn]))[0][:, w]
            np.testing.assert_allclose(fit[0] + 1j * fit[1], gain, atol=1e-6)


def test_an_observer_knows_no_noise_and_says_where_it_rests():
    """A gain of all states has readings without noise: the second w pushes nothing."""
    c = analysed("states").controller(["z1"], T=0.02)
    assert not c.readings.noise.any() and c.readings.noise.shape == (1, 2)
    for w in np.eye(2):
        (x, u), run = c.static(w=w), c.simulate(20.0, w=w)
        np.testing.assert_allclose(run.x[:, -1], x, atol=1e-7)
        np.testing.assert_allclose(run.u[:, -1], u, atol=1e-7)


def test_other_plants_may_have_other_disturbances_but_no_other_noise():
    more = descriptors(sos.SecondOrderSystem(1, 0.2, 1, 1, F=[[1, 0, 2]]))
    c = analysed("states").controller(T=0.02)
    first, second = (c.simulate(1.0, w=w, plants=more) for w in ([0, 0, 1], [2, 0, 0]))
    np.testing.assert_allclose(first.x, second.x, atol=1e-12)
    with pytest.raises(ValueError, match="plants have 3 disturbances"):
        controller("PID", 0.02).simulate(1.0, plants=more)


def test_searched_at_the_ticks_the_noise_is_proven_too():
    law = sos.DynamicLaw(1, **SIMPLE, strictly_proper=False)
    c = sos.design_sampled(CART, law, T=0.05, search=sos.Search(starts=1)).controller()
    LAWS["found"] = (law, None, CART, NOISE)
    true = norm("found", dict(input=1), 1, c)
    assert true > abs(c.D @ NOISE).max()  # what the first sample does
    for size, kept in ((1.02, True), (0.99, False)):
        asked = sos.HInfinity(size * true, outputs=sos.Output(input=1), inputs=[1])
        assert c.certify(norm=asked).proven is kept


def test_a_proof_file_keeps_how_noise_is_read():
    c = controller("PID", 0.02)
    asked = sos.HInfinity(200.0, outputs=sos.Output(input=1), inputs=[1])
    proof = c.certify(norm=asked)
    assert proof.proven and proof.verify() and "read" in proof.claims[1]
    assert np.array_equal(proof.K.D_w, c.D @ NOISE)
    for change in (
        lambda K: K.pop("D_w"),
        lambda K: K.update(D_w=[["0"]]),
        lambda K: K.update(D_w=[["0", "1e3"]]),
        lambda K: [K.pop("B_w"), K.pop("D_w")],
    ):
        data = proof.data | {"K": dict(proof.data["K"])}
        change(data["K"])
        forged = sos.sampled.SampledProof.of(data)
        assert not forged.proven or forged.claims != proof.claims
