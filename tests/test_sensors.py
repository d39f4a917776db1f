"""Any row on what a plant does is a sensor. The truth is computed here, by hand: the
loop from the plant's M, D, S, B and F, its norms on a grid, and its ticks by expm.
"""

import json
import re
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import expm

import sosbook as sos
from sosbook.controllers.compiled import CompiledCode
from sosbook.proofs.command import main
from tests.cases import later

LAG = 0.03


def tower(k, m):
    return sos.SecondOrderSystem(
        [[1, 0], [0, m]], [[0.3, -0.1], [-0.1, 0.2]], [[9.81 + k, -k], [-k, k]],
        [[1, 0.3], [0, 1]], [[0, 0, 0], [1, 0, 0]], coordinates=["floor", "top"],
    )  # fmt: skip


FAMILY = sos.Uncertain(tower, k=(3, 5), m=(0.9, 1.1))
#: The readings: place of the floor, speed, acceleration, and a force in a spring.
SEEN = (
    sos.Output(position=[[1, 0]])
    & sos.Output(acceleration=[[0, 1]], name="acc")
    & sos.Output(position=[[0.3, -1]], input=[[0.2, -0.7]], name="force")
)
N = np.array([[0, 0.3, 0], [0, 0, 0.9], [0, 0.1, -0.2]])
LAW = sos.DynamicLaw(1, sensors=SEEN, lag=LAG, noise=N, strictly_proper=False)
GAINS = dict(
    A_c=[[-3.0]],
    B_c=[[0.3, 0.2, -0.1]],
    C_c=[[0.4], [-0.3]],
    D_c=[[-0.6, -0.11, 0.1], [0.1, -0.2, 0.07]],
)


def first_order(p):
    """A, B_u and B_w of z, z'."""
    n, back = p.n, np.linalg.inv(p.M)
    A = np.block([[np.zeros((n, n)), np.eye(n)], [-back @ p.S, -back @ p.D]])
    return A, *(np.vstack([np.zeros_like(x), back @ x]) for x in (p.B, p.F))


def sensed(p, C, Ca, Du, Dw, late, lag):
    """A, B_u, B_w of [z; z'; late readings], rows and noise of all readings."""
    A, Bu, Bw = first_order(p)
    s = np.hstack([C + Ca @ A, Ca @ Bu + Du, Ca @ Bw + Dw])[late] / lag
    n, m, c = len(A), Bu.shape[1], len(late)
    whole = np.zeros((n + c, n + c))
    whole[:n, :n], whole[n:, :n] = A, s[:, :n]
    whole[n:, n:] = -np.eye(c) / lag
    rows, read = np.hstack([C, np.zeros((len(C), c))]), Dw.copy()
    rows[late] = np.eye(n + c)[n:]
    read[late] = 0
    Bu, Bw = np.vstack([Bu, s[:, n : n + m]]), np.vstack([Bw, s[:, n + m :]])
    return whole, Bu, Bw, rows, read


def of_tower(k, m):
    C = np.array([[1, 0, 0, 0], [0, 0, 0, 0], [0.3, -1, 0, 0.0]])
    Ca = np.array([[0, 0, 0, 0], [0, 0, 0, 1], [0, 0, 0, 0.0]])
    Du = np.array([[0, 0], [0, 0], [0.2, -0.7]])
    return sensed(tower(k, m), C, Ca, Du, N, [1, 2], LAG)


def closed(k, m):
    """The loop [z; z'; late; x_c] from w to [top; u], in continuous time."""
    A, Bu, Bw, rows, read = of_tower(k, m)
    A_c, B_c, C_c, D_c = (np.array(GAINS[x]) for x in ("A_c", "B_c", "C_c", "D_c"))
    F = np.block([[A + Bu @ D_c @ rows, Bu @ C_c], [B_c @ rows, A_c]])
    G = np.vstack([Bw + Bu @ D_c @ read, B_c @ read])
    H = np.vstack([np.eye(1, len(F), 1), np.hstack([D_c @ rows, C_c])])
    return F, G, H, np.vstack([np.zeros((1, 3)), D_c @ read])


def norm(F, G, H, J, discrete=False):
    turns = np.linalg.eigvals(F)
    turns = abs(np.angle(turns)) if discrete else abs(turns.imag)
    grid = np.r_[0, np.geomspace(1e-3, np.pi if discrete else 1e3, 3000), turns]
    grid = grid[grid <= np.pi] if discrete else grid
    z = np.exp(1j * grid) if discrete else 1j * grid
    at = H @ np.linalg.solve(z[:, None, None] * np.eye(len(F)) - F, G + 0j) + J
    return np.linalg.norm(at, 2, axis=(1, 2)).max()


@pytest.mark.parametrize(
    "rows, w", [([0], 0), ([1, 2], 2), *later(([0], 2), ([1, 2], 1))]
)
def test_norms_with_late_sensors_are_what_they_are_for_masses_in_ranges(rows, w):
    true = 0.0
    for k in np.linspace(3, 5, 5):
        for m in np.linspace(0.9, 1.1, 5):
            F, G, H, J = closed(k, m)
            assert np.linalg.eigvals(F).real.max() < 0
            true = max(true, norm(F, G[:, [w]], H[rows], J[rows][:, [w]]))
    seen = sos.Output(position=[[0, 1]]) if rows == [0] else sos.Output(input=1)
    for size, status in ((1.03, "feasible"), (0.995, "infeasible")):
        asked = sos.HInfinity(size * true, outputs=seen, inputs=[w])
        d = sos.analyse_pid(FAMILY, GAINS, law=LAW, requirements=[asked])
        assert d.status == status, (size, d.reason)


def test_the_file_of_an_accelerometer_s_loop_is_taken_by_the_checker(tmp_path):
    """One that knows nothing of sensors: the sensed plant is a plant."""
    proof = sos.analyse_pid(FAMILY, GAINS, law=LAW).certify()
    assert proof.proven and "k in [3, 5] and m in [0.9, 1.1]" in proof.claims[0]
    assert LAW.words(tower(3, 1)).startswith("u depends on floor, acc and force: a con")
    file = tmp_path / "proof.json"
    file.write_text(proof.text, "utf-8")
    assert main(["verify", str(file)]) == 0


def random_channel(rng):
    """A plant, an Output and its matrices, noise, lag, T and delay, in odd units."""
    n, m = rng.integers(1, 3, 2)
    M = np.diag(rng.uniform(0.3, 2, n)) * 9.81
    D, S = rng.uniform(0, 1, (n, n)), 3 * rng.uniform(0.5, 2) * np.eye(n)
    D, S = (x + 1.5 * n * np.eye(n) for x in (D, S))
    B, F = rng.normal(size=(n, m)), np.pad(rng.normal(size=(n, 1)), ((0, 0), (0, 1)))
    p = sos.SecondOrderSystem(*(x.round(3) for x in (M, D, S, B, F)))
    C, V, Ca = rng.normal(size=(3, 3, n)).round(2)
    Du, Nw = rng.normal(size=(3, m)).round(2), rng.normal(size=(3, 2)).round(2)
    Ca[[0, 2]], Du[:2], V[0] = 0, 0, 0
    parts = [sos.Output(position=C[:1], disturbance=Nw[:1])]
    parts += [sos.Output(C[1:2], V[1:2], Ca[1:2], disturbance=Nw[1:2], name="acc")]
    parts += [sos.Output(C[2:], V[2:], input=Du[2:], name="force")]
    lag, T = rng.uniform(0.03, 0.2), rng.uniform(0.02, 0.2)
    delay = rng.choice([0, 0.5, 1]) * T
    noise = np.vstack([0 * Nw[:2], Nw[2:]])  # half of it is in the Output
    given = np.hstack([C, V]), np.hstack([0 * Ca, Ca]), Du, Nw, [1, 2], round(lag, 3)
    output = parts[0] & parts[1] & parts[2]
    return p, output, noise, given, round(T, 4), round(delay, 4)


def ticks(p, given, K, T, delay):
    """The loop [x; u held before] from w, held over a tick, to u = K y, by expm."""
    A, Bu, Bw, rows, read = sensed(p, *given)
    (N, m), q = Bu.shape, Bw.shape[1]
    whole = np.zeros((N + m + q,) * 2)
    whole[:N] = np.hstack([A, Bu, Bw])

    def flow(span):
        return np.split(expm(whole * span)[:N], [N, N + m], axis=1)

    (P1, U1, W1), (P2, U2, W2) = flow(delay), flow(T - delay)
    F = np.block([[P2 @ P1 + U2 @ K @ rows, P2 @ U1], [K @ rows, np.zeros((m, m))]])
    G = np.vstack([P2 @ W1 + W2 + U2 @ K @ read, K @ read])
    return F, G, np.hstack([K @ rows, np.zeros((m, m))]), K @ read


@pytest.mark.parametrize("seed", [5, *(pytest.param(k, marks=pytest.mark.campaign)
                                       for k in range(20))])  # fmt: skip
def test_sampled_norms_of_random_sensors_are_bracketed(seed):
    rng, tried = np.random.default_rng(seed), 0
    while tried < 2:
        p, output, noise, given, T, delay = random_channel(rng)
        law = sos.PIDLaw(sensors=output, lag=given[-1], noise=noise)
        K = (0.5 * rng.normal(size=(p.m, 3))).round(3)
        loop = ticks(p, given, K, T, delay)
        A, Bu, _, rows, _ = sensed(p, *given)
        slow = np.linalg.eigvals(A + Bu @ K @ rows).real.max()
        if abs(np.linalg.eigvals(loop[0])).max() > 0.999 or slow > -1e-3:
            continue
        tried += 1
        c = sos.analyse_pid(p, {"K_P": K}, law=law).controller(T=T, delay=delay)
        place = np.eye(p.n, len(loop[0])), np.zeros((p.n, 2))
        for w, (name, H, J) in product(
            (0, 1), (("input", *loop[2:]), ("position", *place))
        ):
            F, G, *_ = loop
            true = norm(F, G[:, [w]], H, J[:, [w]], discrete=True)
            seen = sos.Output(**{name: 1})
            again = sos.Loop(p, law, {"K_P": K}).at(T, delay).norm(seen, [w])
            assert abs(again / true - 1) < 1e-3
            for size, kept in ((1.03, True), (0.995, False)):
                asked = sos.HInfinity(size * true, outputs=seen, inputs=[w])
                assert c.certify(norm=asked).proven == kept, (w, size)


def test_sensors_are_at_rest_where_the_plant_is():
    """x(0) of the plant is enough: a late place has long stood at what it sees."""
    p, x0 = sos.SecondOrderSystem(0.3, 9.81, 2, 1, [[1]]), [0.7, 0]
    seen = sos.Output(position=1, input=0.3, name="seen")
    law, gains = sos.PIDLaw(sensors=seen, lag=0.05, filter=0.1), {"K_P": [[-2.0]]}
    asked = sos.Saturation(90.0, x0)
    d = sos.analyse_pid(p, gains, law=law, requirements=[asked])
    assert d.request.requirements[0].x0.tolist() == [0.7, 0, 0.7, 0.7]
    for c in (d.controller(T=0.02), d.controller(T=0.02, delay=0.02)):
        runs = [c.simulate(0.5, x0=x, program=r) for x, r in (
            (x0, None), ([*x0, 0.7], None), (x0, CompiledCode(c)))]  # fmt: skip
        assert all(np.allclose(runs[0].u, run.u, atol=1e-6) for run in runs)
        assert runs[0].y[0, 0] == 0.7
    A, Bu, _, rows, _ = sensed(
        p, np.array([[1, 0.0]]), np.zeros((1, 2)), np.array([[0.3]]),
        np.zeros((1, 1)), [0], 0.05,
    )  # fmt: skip
    wide = np.zeros((4, 4))
    wide[:3] = np.hstack([A, Bu])
    x, flow = np.array([*x0, 0.7]), expm(wide * 0.02)[:3]
    run = d.controller(T=0.02).simulate(0.5, x0=x0)
    for u, y in zip(run.u[0], run.y[0]):
        assert np.allclose(y, rows @ x) and np.allclose(u, -2 * y)
        x = flow @ [*x, *u]


def test_sensors_that_arent_late_leave_the_plant_as_it_is():
    """To the last byte, position= is sensors=Output(position=...)."""
    noise = [[0, 0.3, 0]]
    gains = {"K_P": [[-0.3], [0]], "K_I": [[-0.3], [0]]}
    texts = {
        sos.analyse_pid(
            FAMILY, gains, law=sos.PIDLaw(integrate=True, **how)
        ).certify().text
        for how in (
            dict(position=[[1, 0]], noise=noise),
            dict(sensors=sos.Output(position=[[1, 0]]), noise=noise),
            dict(sensors=sos.Output(position=[[1, 0]], disturbance=noise), lag=0.3),
            dict(sensors=sos.Output(state=[[1, 0, 0, 0]]), noise=noise),
        )
    }  # fmt: skip
    assert len(texts) == 1


def test_a_design_with_an_accelerometer_in_a_file(tmp_path, capsys):
    """Searched, proven, and about the plant of the file, whose sensors are its own."""
    plant = {"parameters": {"m": [1, 1.3]}, "M": [["m"]], "D": [[0.05]], "S": [[3]]}
    law = {
        "sensors": [{"position": [[1]], "acceleration": [[0.3]], "name": "acc"}],
        "lag": 0.02,
        "structure": {"K_P": [[[-20, 0.5]]], "K_D": [[[None, 0]]]},
        "filter": 0.05,
    }
    asked = {
        "plant": plant | {"B": [[1]], "F": [[1]]},
        "law": law,
        "search": {"starts": 3},
    }
    file, proof = tmp_path / "plant.json", tmp_path / "proof.json"
    file.write_text(json.dumps(asked | {"region": {"sigma": 0.06}}), "utf-8")
    assert main(["design", str(file), "--proof", str(proof)]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert -20 <= answer["K_P"][0][0] <= 0.5 and answer["K_D"][0][0] <= 0
    assert main(["design", str(file), "--proof", str(proof)]) == 0  # it may replace it
    assert main(["verify", str(proof), "--plant", str(file)]) == 0
    for name, other in (("0.02", "0.03"), ("0.3]]", "0.4]]"), ("1.3", "1.4")):
        file.write_text(file.read_text("utf-8").replace(name, other), "utf-8")
        assert main(["verify", str(proof), "--plant", str(file)]) == 1


CART = sos.SecondOrderSystem(1, 0.3, 1, 1, [[1]])
JUMPS = sos.Output(acceleration=1)


def asked(plant=CART, **how):
    return lambda: sos.analyse_pid(
        plant, None or np.zeros((1, 1)), law=sos.PIDLaw(**how)
    )


@pytest.mark.parametrize(
    "words, wrong",
    {
        "lag is missing: z1'' jumps with u": asked(sensors=JUMPS),
        "lag is missing: force jumps": asked(sensors=sos.Output(input=1, name="force")),
        "lag must be": asked(sensors=JUMPS, lag=0),
        "position and sensors are given": asked(position=[[1]], sensors=JUMPS),
        "sensors must be an Output": asked(sensors=[[1]]),
        "sensors: row 1 is zero": asked(sensors=sos.Output(position=[[0]])),
        "two sensors are called a": asked(
            sensors=sos.Output(1, name="a") & sos.Output(velocity=1, name="a")
        ),
        "noise has shape|noise has 2 rows|noise": asked(
            sensors=sos.Output(1), noise=[[1], [1]]
        ),
        "integral is weighed": asked(sensors=sos.Output(integral=[[1]])),
        "position is missing": lambda: sos.PIDLaw(),
    }.items(),
)
def test_wrong_sensors_are_named(words, wrong):
    with pytest.raises(ValueError, match=words):
        wrong()


def test_set_points_are_of_places_that_come_first():
    place, speed = sos.Output(position=1), sos.Output(velocity=1)
    K = np.array([[-1.0, -0.5]])
    good = sos.analyse_pid(CART, K, law=sos.PIDLaw(sensors=place & speed))
    assert [s.name for s in good.controller(T=0.1).set_points] == ["set point of z1"]
    other = sos.analyse_pid(CART, K[:, ::-1], law=sos.PIDLaw(sensors=speed & place))
    with pytest.raises(ValueError, match="set points are of places"):
        other.controller(T=0.1)
    law = sos.PIDLaw(sensors=JUMPS, lag=0.1)
    alone = sos.analyse_pid(CART, [[-0.3]], law=law).controller(T=0.05)
    assert not alone.set_points


def test_the_recipe_of_a_new_sensor_is_true():
    """The code of CONTRIBUTING.md, and the loops of its gains by hand."""
    text = (Path(__file__).parents[1] / "CONTRIBUTING.md").read_text("utf-8")
    (code,) = re.findall(r"## A new sensor.*?```python\n(.*?)```", text, re.DOTALL)
    names = {}
    exec(code, names)
    assert names["proof"].proven and names["controller"].certify().proven
    K_P, K_D = (names["design"].gains[x] for x in ("K_P", "K_D"))
    C, Ca = np.array([[1, -1, 0, 0], [0, 0, 0, 0.0]]), np.eye(4)[[0, 3]]
    N, none, two = np.array([[0, 0.01], [0, 0.1]]), np.zeros((2, 1)), np.eye(2)
    Ca[0] = 0
    for k, m in np.random.default_rng(3).uniform([3, 0.9], [5, 1.1], (20, 2)):
        A, B, _, rows, _ = sensed(names["tower"](k, m), C, Ca, none, N, [1], 0.01)
        K = K_P + K_D / 0.05  # K_D multiplies (y - its filter) / .05
        F = np.block([[A + B @ K @ rows, -B @ K_D / 0.05], [rows / 0.05, -two / 0.05]])
        assert np.linalg.eigvals(F).real.max() < -0.1


def test_a_loop_with_late_sensors_is_one_object():
    loop = sos.Loop(tower(3, 1), LAW, GAINS)
    again = sos.Loop.read(json.loads(json.dumps(loop.data())))
    F, G, H, J = closed(3, 1)
    for one in (loop, again):
        same = sorted(one.poles()[0], key=lambda s: (s.real, s.imag))
        assert np.allclose(
            same, sorted(np.linalg.eigvals(F), key=lambda s: (s.real, s.imag))
        )
        top = one.norm(sos.Output(position=[[0, 1]]), [0])
        assert abs(top / norm(F, G[:, :1], H[:1], J[:1, :1]) - 1) < 1e-3
    plant, K = loop.opened
    d = plant.vertices[0]
    assert np.allclose(
        np.sort_complex(np.linalg.eigvals(np.linalg.solve(d.E, d.A + d.Bu @ K))),
        np.sort_complex(np.linalg.eigvals(F)),
    )
    states = [x.name for x in loop.signals if x.role == "state"]
    assert states == ["floor", "top", "floor'", "top'", "acc", "force"]
    asked = sos.Output(position=[[0, 1]]) & sos.Output(input=0.1)
    assert loop.prove(sos.HInfinity(9.0, outputs=asked)).proven


def test_every_door_takes_a_plant_and_what_reads_it():
    """A design and a controller are of the plant that was given, sensors or not."""
    pair = sos.Polytope([tower(3, 1), tower(4, 1)])
    d = sos.analyse_pid(pair, GAINS, law=LAW)
    assert d.its_law()[0].readings(pair).names == ("floor", "acc", "force")
    again = sos.analyse_pid(pair, d)
    assert (again.poles() == d.poles()).all()
    written = sos.Loop.read(json.loads(json.dumps(d.loop.data())))
    assert d.loop.plant is pair and np.allclose(written.poles(), d.poles())
    assert sos.analyse_delay(pair, d, tau=0.01, mu=0).status == "feasible"
    c = d.controller(T=0.02, delay=0.02)
    assert sos.furthest_sampled(pair, c, T=(0.019, 0.02)).proven
    assert sos.certify_sampled(pair, c, T=0.02, delay=0.02).proven
    with pytest.raises(ValueError, match="closed by the names"):
        sos.certify_sampled(tower(5, 1), c, T=0.02, delay=0.02)


def test_K_A_beside_late_sensors_is_in_the_mass():
    """What the error says instead is the loop of K_A, by its polynomial matrix."""
    plant, K_A = tower(3, 1), np.array([[0, 0.2], [0.1, 0]])
    acc = sos.Output(acceleration=[[0, 1]], name="acc")
    law = sos.PIDLaw(sensors=sos.Output(position=[[1, 0]]) & acc, lag=0.1)
    with pytest.raises(ValueError, match="give it the mass M - B K_A and add K_A z''"):
        sos.analyse_pid(plant, np.zeros((2, 2)), law=law, K_A=K_A)
    M, D, S, B = plant.M - plant.B @ K_A, plant.D, plant.S, plant.B
    K = np.array([[0.3, 0.1], [-0.2, 0.2]])
    loop = sos.Loop(sos.SecondOrderSystem(M, D, S, B, plant.F), law, K)
    for s in loop.poles()[0]:
        seen = np.array([[1, 0], [0, s**2 / (1 + 0.1 * s)]])
        whole = M * s**2 + D * s + S - B @ K @ seen
        assert np.linalg.svd(whole, compute_uv=False)[-1] < 1e-6


def test_modes_that_late_sensors_dont_see_are_refused():
    """An accelerometer sees no cart at rest, wherever it is; nor another's motion."""
    law = sos.DynamicLaw(1, sensors=sos.Output(acceleration=[[1, 0]]), lag=0.02)
    two = sos.SecondOrderSystem(np.eye(2), 0 * np.eye(2), np.diag([0, 4]), [[1], [1]])
    d = sos.design_pid(two, law=law, search=sos.Search(starts=1))
    assert d.status == "infeasible" and d.infeasibility.proven
    whole = sos.DynamicLaw(1, sensors=sos.Output(position=[[1, 1]]))
    assert (
        sos.design_pid(two, law=whole, search=sos.Search(starts=1)).status
        != "infeasible"
    )
