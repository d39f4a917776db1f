"""Plants of discrete time: dt, poles z, norms and costs at the ticks."""

import json
import re

import numpy as np
import pytest
from scipy.linalg import solve_discrete_are, solve_discrete_lyapunov

import sosbook as sos
from sosbook.exact.checker import verdict as checker
from sosbook.plants.filters import filtered
from tests.asking import asked_by, asking
from tests.cases import later

DISK = sos.LMIRegion.disk


def plant(seed, dt, direct=0.1):
    """An unstable plant of no symmetry, as A, B, B_w, C, D_u, D_w and with its dt."""
    rng = np.random.default_rng(seed)
    N, m = 3 + seed % 2, 1 + seed % 2
    A = rng.normal(size=(N, N))
    A = (1.1 * A / abs(np.linalg.eigvals(A)).max()).round(4)
    B, Bw = rng.normal(size=(N, m)).round(3), rng.normal(size=(N, 2)).round(3)
    C, Du = rng.normal(size=(2, N)).round(3), rng.normal(size=(2, m)).round(2)
    Dw = direct * rng.normal(size=(2, 2)).round(2)
    rest = A, B, Bw, C, Du, Dw if direct else None
    return rest, sos.DescriptorSystem(np.eye(N), *rest, dt=dt)


def norm(F, G, C, D):
    """The H-infinity norm of x(k+1) = F x + G w, C x + D w, by many frequencies."""
    z = np.exp(1j * np.linspace(0, np.pi, 20001))[:, None, None]
    answers = C @ np.linalg.solve(z * np.eye(len(F)) - F, G + 0j) + D
    return np.linalg.norm(answers, 2, axis=(1, 2)).max()


@pytest.mark.parametrize(
    "seed, dt, noise",
    [
        *((0, 0.05, "states"), (1, 9.81, "F"), (3, 1e-3, "states")),
        *later((0, 0.05, "F"), (1, 9.81, "states"), (3, 1e-3, "F")),
    ],
)
def test_the_least_cost_is_that_of_the_riccati_equation(seed, dt, noise):
    (A, B, Bw, *_), p = plant(seed, dt)
    Q, R = np.diag(np.arange(1.0, len(A) + 1)), 0.3 * np.eye(B.shape[1])
    X = solve_discrete_are(A, B, Q, R)
    K = -np.linalg.solve(R + B.T @ X @ B, B.T @ X @ A)
    least = np.trace(X if noise == "states" else Bw.T @ X @ Bw)
    d = sos.design_lqr(p, Q, R, noise=noise)
    assert d.certify().proven and np.allclose(d.K, K, rtol=1e-6, atol=1e-6)
    assert 0 < d.request.cost.bound / least - 1 < 3e-4
    assert abs(d.noise_cost() / least - 1) < 1e-9
    asked = [sos.QuadraticCost(Q, R, noise, bound=0.99 * least)]
    assert sos.design_pid(p, requirements=asked).status == "infeasible"


@pytest.mark.parametrize("seed, dt", [(0, 0.3), (1, 9.81)])
def test_a_norm_is_proven_just_above_the_true_one_and_refused_below(seed, dt):
    for kind, direct in ((sos.HInfinity, 0.1), (sos.H2, 0.0)):
        (A, B, Bw, C, Du, Dw), p = plant(seed, dt, direct)
        d = sos.design_pid(p, requirements=[kind()], minimize=kind().name)
        F, out = A + B @ d.K, C + Du @ d.K
        if kind is sos.H2:
            X = solve_discrete_lyapunov(F, Bw @ Bw.T)
            true = np.sqrt(np.trace(out @ X @ out.T))
        else:
            true = norm(F, Bw, out, Dw)
            assert abs(d.hinf() / true - 1) < 1e-6
        assert true < d.request.requirements[0].bound < 1.03 * true
        for share, word in ((1.01, "feasible"), (0.98, "infeasible")):
            for coupling in ("pairs", "multipliers")[: 1 + (share > 1)]:
                asked = [kind(share * true)]
                found = sos.analyse_pid(p, d.K, requirements=asked, coupling=coupling)
                assert found.status in (word, "undecided"[: 9 * (share < 1)])
                assert found.certify().proven == (share > 1)


def test_poles_go_into_disks_and_other_regions_of_z():
    p = sos.DescriptorSystem(np.eye(2), [[1.2, 0.9], [-0.3, 1.1]], [[0.2], [1]], dt=0.1)
    fan = sos.LMIRegion([[0, 0], [0, 0]], [[-0.6, -0.8], [0.8, -0.6]], "fan")
    for region in (
        DISK(0.5, 0.3),
        sos.LMIRegion.strip(0.2, 0.6),
        fan & DISK(0.9),
        sos.PoleRegion(rho=0.7),
        sos.LMIRegion.horizontal_strip(0.05) & DISK(0.8),
    ):
        d = sos.design_pid(p, region=region)
        z = np.linalg.eigvals(p.A + p.B @ d.K)
        assert region.contains(z) and abs(z).max() < 1 and d.certify().proven
        assert np.allclose(np.sort_complex(d.poles()), np.sort_complex(z))
        assert d.request.region.contains(z) and "its poles z" in str(d.certify())
    assert "Re z < 0.6" in str(
        sos.design_pid(p, region=sos.LMIRegion.strip(0.2, 0.6)).certify()
    )


def test_a_decay_of_continuous_time_names_the_disk_of_z():
    p = sos.DescriptorSystem(np.eye(2), [[1.02, 0.3], [-0.2, 1]], [[0], [1]], dt=0.03)
    for region in (sos.PoleRegion(sigma=2.0, rho=9), sos.PoleRegion(settling_time=2)):
        with pytest.raises(ValueError, match="one with dt = 0.03 s") as error:
            sos.design_pid(p, region=region)
        radius = float(re.findall(r"disk\((\S+)\)", str(error.value))[0])
        d = sos.design_pid(p, region=DISK(radius))
        decay = -np.log(abs(np.linalg.eigvals(p.A + p.B @ d.K)).max()) / 0.03
        assert decay > region.sigma * (1 - 1e-4)


@pytest.mark.parametrize("region", [DISK(0.9), DISK(0.5, 0.3), sos.PoleRegion(rho=0.9)])
def test_a_sentence_says_nothing_of_continuous_time(region):
    p = sos.DescriptorSystem(np.eye(2), [[1.02, 0.3], [-0.2, 1]], [[0], [1]], dt=0.03)
    assert sos.design_pid(p, region=region).sentence == (
        "The loop and disk as given: feasible."
    )


def test_a_program_of_a_plant_with_ticks_is_named_and_runs():
    p = sos.DescriptorSystem(
        np.eye(3),
        [[1.02, 0.3, 0], [-0.2, 1, 0.1], [0, 0, 0.7]],
        [[0], [1], [0.3]],
        dt=0.03,
    )
    law = sos.DynamicLaw(2, position=[[1, 0, 0]])
    d = sos.design_pid(p, law=law, region=DISK(0.97))
    program, c = d.loop.to_ss(), d.controller(T=0.03)
    assert all(np.allclose(getattr(program, x), getattr(c, x)) for x in "ABCD")
    x, memory, seen = np.array([1.0, -2, 0.3]), np.zeros(2), []
    for _ in range(400):  # the program's two lines, and the plant
        y = x[:1]
        u, memory = (
            program.C @ memory + program.D @ y,
            program.A @ memory + program.B @ y,
        )
        x = p.A @ x + p.B @ u
        seen.append(np.linalg.norm(x))
    assert program.dt == 0.03 and d.certify().proven
    assert seen[-1] < 1e-3 * max(seen[:50])


def builder(a, e):
    E, A = [[e, 0.1], [0, 1]], [[a, 0.981], [-0.3, 1.1]]
    return sos.DescriptorSystem(E, A, [[0.2], [1]], [[1], [0.5]], C=[[1, 0]], dt=0.1)


@pytest.mark.parametrize("coupling", ["pairs", "slack", "multipliers"])
def test_a_family_keeps_what_is_proven_and_a_stranger_decides(coupling):
    family = sos.Uncertain(builder, a=(0.5, 1.3), e=(0.9, 1.2))
    asked = dict(region=DISK(0.95), gamma=40.0)
    if coupling == "multipliers":
        K = sos.design_pid(family, **asked).K
        d = sos.analyse_pid(family, K, coupling=coupling, **asked)
    else:
        d = sos.design_pid(family, coupling=coupling, **asked)
    proof = d.certify()
    assert proof.proven and "from tick to tick of 0.1 s" in proof.claims[0]
    assert checker.check(proof.text) == list(proof.claims)
    for one in family.sample(30, 1):
        E, A, B = one.E, one.A, one.B
        F, G = np.linalg.solve(E, A + B @ proof.K), np.linalg.solve(E, one.B_w)
        assert abs(np.linalg.eigvals(F)).max() < 0.95
        assert norm(F, G, one.C, 0) < 40
    data = asked_by(proof)
    for change in ({"dt": "-0.1"}, {"dt": "0"}, {}):  # no tick
        plant = {k: x for k, x in data["plant"].items() if k != "dt"} | change
        with pytest.raises((checker.Refused, *checker.MALFORMED)):
            checker.check(json.dumps(asking(data | {"plant": plant})))


def test_a_vertex_is_refused_where_its_poles_are_and_between():
    family = sos.Uncertain(builder, a=(0.5, 1.3), e=(0.9, 1.2))
    K = sos.design_pid(family, region=DISK(0.95)).K
    reach = max(
        abs(np.linalg.eigvals(np.linalg.solve(p.E, p.A + p.B @ K))).max()
        for p in [family.at(a=a, e=e) for a in (0.5, 1.3) for e in (0.9, 1.2)]
    )
    for share, word in ((1.001, "feasible"), (0.99, "infeasible")):
        d = sos.analyse_pid(family, K, region=DISK(float(share * reach)))
        assert d.status == word
    assert d.infeasibility.proven and "near z = " in d.infeasibility.claims[0]


def arx():
    """Two lightly damped pairs, and an input that comes two ticks late."""
    poles = np.r_[0.98 * np.exp([0.6j, -0.6j]), 0.97 * np.exp([1.6j, -1.6j])]
    A = np.eye(4, k=1)
    A[:, 0] = -np.poly(poles).real.round(6)[1:]
    B = np.array([[0], [0.3], [0.25], [0.0]])
    return sos.DescriptorSystem(np.eye(4), A, B, np.eye(4, 1), C=np.eye(1, 4), dt=0.05)


def test_a_dynamic_law_of_an_identified_model_is_one_of_its_clock():
    p = arx()
    law = sos.DynamicLaw(2, position=[[1, 0, 0, 0]])
    d = sos.design_pid(p, law=law, region=DISK(0.95))
    assert d.certify().proven and checker.check(d.certify().text)
    c = d.loop.to_ss()
    assert c.dt == 0.05
    loop = np.block([[p.A + p.B @ c.D @ p.C, p.B @ c.C], [c.B @ p.C, c.A]])
    z = np.linalg.eigvals(loop)
    assert abs(z).max() < 0.95
    assert np.allclose(np.sort(abs(z)), np.sort(abs(d.poles())), atol=1e-6)
    assert abs(d.loop.norm() / norm(loop, np.eye(6, 1), np.eye(1, 6), 0) - 1) < 1e-6


def test_a_pid_law_sums_and_filters_at_the_ticks():
    def axis(b):
        A, w = [[1, 0.05], [0, 0.98]], [[0], [0.05]]
        return sos.DescriptorSystem(np.eye(2), A, [[0], [b]], w, C=[[1, 0]], dt=0.05)

    law = sos.PIDLaw(position=[[1, 0]], integrate=True, filter=0.1)
    family = sos.Uncertain(axis, b=(0.03, 0.06))
    d = sos.design_pid(family, law=law, region=DISK(0.99))
    assert d.certify().proven and checker.check(d.certify().text)
    P, D, sums = (d.gains[x].item() for x in ("K_P", "K_D", "K_I"))
    for b in (0.03, 0.047, 0.06):
        # x, v, i(k+1) = i + dt x, f(k+1) = f + dt (x - f) / 0.1; rate (x - f) / 0.1
        u = np.array([P + D / 0.1, 0, sums, -D / 0.1])
        F = np.array([[1, 0.05, 0, 0], b * u + [0, 0.98, 0, 0], [0.05, 0, 1, 0],
                      [0.5, 0, 0, 0.5]])  # fmt: skip
        assert abs(np.linalg.eigvals(F)).max() < 0.99


def test_what_no_gain_moves_is_named_as_z():
    p = sos.DescriptorSystem(np.eye(2), [[0.5, 1], [0, 1.2]], [[1], [0]], dt=0.1)
    d = sos.design_pid(p)
    assert d.status == "infeasible" and d.infeasibility.proven
    assert "z = 1.2" in d.reason and checker.check(d.infeasibility.text)
    axis = sos.DescriptorSystem(np.eye(2), [[0.5, 1], [0, -1]], [[1], [0]], dt=0.1)
    assert sos.design_pid(axis).status == "infeasible"
    inside = sos.DescriptorSystem(np.eye(2), [[0.5, 1], [0, 0.99]], [[1], [0]], dt=0.1)
    assert sos.design_pid(inside).certify().proven
    loop = sos.DescriptorSystem(np.eye(1), [[-1.01]], dt=0.1)
    assert sos.analyse_pid(loop).status == "infeasible"


def test_a_short_tick_is_continuous_time():
    A, B = np.array([[0, 1], [-9.81, -0.3]]), np.array([[0], [2.0]])
    bounds = []
    for dt in (1e-3, None):
        step = 1.0 if dt is None else dt
        E, shift = np.eye(2) / step, np.eye(2) / step if dt else 0
        how = dict(C=[[1, 0], [0, 0]], D_u=[[0], [0.1]], dt=dt)
        p = sos.DescriptorSystem(E, A + shift, B, B, **how)
        bounds.append(sos.design_pid(p, minimize="gamma").hinf())
    assert abs(bounds[0] / bounds[1] - 1) < 0.02


def test_what_takes_continuous_time_alone_says_so():
    p = arx()
    d = sos.design_pid(p, region=DISK(0.95))
    still = sos.DescriptorSystem(np.eye(4), -np.eye(4), p.B)
    law = sos.PIDLaw(position=[[1, 0, 0, 0]], filter=1.0)
    for call in (
        lambda: sos.design_observer(p, d.K, Q_F=np.eye(8), R_F=[[1]]),
        lambda: sos.analyse_delay(p, d.K, tau=0.1),
        lambda: sos.certify_sampled(p, d.K, 0.05),
        lambda: d.controller(T=0.06),
        lambda: d.disk_margin(),
        lambda: d.check_on(p),
        lambda: sos.design_pid(still).check_on(p),
        lambda: sos.design_pid(still).certify(on=p),
        lambda: sos.Loop(p, d.K).late(0.1).poles(),
        lambda: p.reduce(2),
        lambda: sos.design_pid(p, search=sos.Search(prefer="least")),
        lambda: filtered(p, sos.Output(state=np.eye(1, 4)), [1], [1, 1]),
        lambda: sos.design_pid(p, law=law, maximize="sigma"),
    ):
        with pytest.raises(ValueError, match="discrete time|one with dt"):
            call()
    with pytest.raises(ValueError, match="continuous time"):
        sos.design_pid(p, saturation=sos.Saturation(1.0, np.ones(4)))
    with pytest.raises(ValueError, match="C_a weighs x'"):
        sos.DescriptorSystem(1, 1, C=[[1]], C_a=[[1]], dt=0.1)
    with pytest.raises(ValueError, match="dt"):
        sos.DescriptorSystem(1, 1, dt=0)
    with pytest.raises(ValueError, match="make the requirement again"):
        still = sos.SecondOrderSystem(1, 1, 1, 1)
        sos.design_pid(still, requirements=d.request.requirements)


def test_systems_of_different_ticks_differ():
    one, two, still = (sos.DescriptorSystem(1, 0.5, 1, dt=x) for x in (0.1, 0.2, None))
    assert one != two != still != one and "ticks of 0.1 s" in repr(one)
    both = sos.DescriptorSystem(1, [[[0.5]], [[0.9]]], 1, dt=0.3)
    middle = both.at([0.5, 0.5])
    assert middle.dt == 0.3 and abs(middle.A.item() - 0.7) < 1e-12
    assert all(x.dt == 0.3 for x in both.sample(2, 0))


@pytest.mark.parametrize("law", ["states", "memory", "sums"])
def test_a_loop_that_is_opened_again_keeps_its_ticks(law):
    """Its matrices are of a change: read as of x' they were another plant's."""
    one, B = np.eye(2), [[0.3], [0.05]]
    family = sos.Uncertain(
        lambda k: sos.DescriptorSystem(one, [[0.97, 0.049], [-k, 0.9]], B, dt=0.3),
        k=(0.1, 9.81),
    )
    law, K = {
        "states": (None, [[-5.0, -1.0]]),
        "memory": (
            sos.DynamicLaw(1, position=[[1, 0]]),
            {"A_c": [[-3.0]], "B_c": [[1.0]], "C_c": [[-1.0]]},
        ),
        "sums": (
            sos.PIDLaw(position=[[1, 0]], integrate=True),
            {"K_P": [[-2.0]], "K_I": [[-0.3]]},
        ),
    }[law]
    for plant in (family, sos.DescriptorSystem(one, [[0.3, 1], [-1, 0.4]], B, dt=0.3)):
        loop = sos.Loop(plant, law, K)
        again = sos.Loop(*loop.opened)
        assert loop.open.dt == again.plant.dt == 0.3
        assert np.allclose(np.sort(loop.poles()), np.sort(again.poles()))
        if law is None:
            A = again.plant.vertices[0]
            F = np.linalg.solve(A.E, A.A) * 0.3 + one + B @ np.array(K)
            assert np.allclose(*map(np.sort, (np.linalg.eigvals(F), loop.poles()[0])))
