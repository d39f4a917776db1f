"""Laws: what they join to a plant is the loop that their controller makes."""

import re
from functools import partial
from pathlib import Path

import control
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import sosbook as sos
from sosbook.exact.rational import exact
from sosbook.studies import maps
from tests.cases import by_hand, seeds


def joint(J, k):
    """A motor and a load, of inertia J, on a shaft."""
    return sos.SecondOrderSystem(
        np.diag([1.0, J]), [[0.15, -0.05], [-0.05, 0.05]], [[k, -k], [-k, k]],
        [[1], [0]], [[0], [1]],
    )  # fmt: skip


ARM = sos.Polytope([joint(J, k) for J in (1, 2) for k in (8, 12)])
PID = sos.PIDLaw(position=[[1, 0]], integrate=True, filter=0.02)
GAINS = {"K_P": [[-8.0]], "K_D": [[-3.0]], "K_I": [[-2.0]]}


def joined(plant, rows, c):
    """The poles of a plant and a controller, joined by python-control."""
    G = control.ss(*by_hand(plant), rows, np.zeros((len(rows), plant.m)))
    C = control.ss(c.A, c.B, c.C, c.D)
    return np.sort_complex(control.feedback(G, C, sign=1).poles())


def same(poles, others):
    assert np.allclose(np.sort_complex(poles), np.sort_complex(others), atol=1e-6)


def random_plants(seed, n, m):
    rng = np.random.default_rng(seed)
    M, D, S = np.eye(n), *(rng.normal(size=(2, n, n)))  # unsymmetric
    B, F = rng.normal(size=(n, m)), rng.normal(size=(n, 1))
    return [sos.SecondOrderSystem(k * M, D, S, B, F) for k in (1, 1.3)], rng


@pytest.mark.parametrize("seed", seeds(6))
def test_a_law_makes_the_loop_that_python_control_makes(seed):
    plants, rng = random_plants(seed, 3, 2)
    C = rng.normal(size=(2, 3)).round(2)
    laws = [
        sos.PIDLaw(position=C, integrate=True, filter=0.3),
        sos.PIDLaw(position=C, velocity=C[:1], integrate=[[1, -2.0]]),
        sos.PIDLaw(position=C),
        sos.DynamicLaw(order=2, position=C, velocity=C[:1]),
        sos.DynamicLaw(order=1, position=C, strictly_proper=False),
    ]
    zero = np.zeros_like(C)
    for law in laws:
        form = law.structure(plants[0])
        share = rng.normal(size=len(form.directions)).round(1)
        K = np.tensordot(share, form.directions, 1)
        d = sos.analyse_pid(sos.Polytope(plants), K, law=law)
        rows = np.block([[C, zero]])
        if law.rates is not None:
            rows = np.vstack([rows, np.hstack([zero[:1], C[:1]])])
        for plant, poles in zip(plants, d.poles()):
            same(joined(plant, rows, sos.Loop(plant, law, K).to_ss()), poles)
        assert (law.applied(plants[0]).gain(form.named(K)) == K).all()


@pytest.mark.parametrize("tau", [0.3, 9.81e-3])
@pytest.mark.parametrize("integrate", [False, True])
def test_a_set_point_is_what_the_law_sees_as_its_error(tau, integrate):
    """Against the equations, integrated by scipy: the filter sees z - r."""
    plant = sos.SecondOrderSystem([[0.3]], [[0.981]], [[0]], [[2]])
    law = sos.PIDLaw(position=[[1]], filter=tau, integrate=integrate)
    gains = {"K_P": -1.3, "K_D": -0.2} | ({"K_I": -0.3} if integrate else {})
    loop = sos.analyse_pid(plant, {k: [[x]] for k, x in gains.items()}, law=law)
    t = np.linspace(0, 9, 91)

    def rate(_, x):
        z, dz, total, slow = x
        error = z - 0.7
        u = gains["K_P"] * error + gains["K_D"] * (error - slow) / tau
        u += gains.get("K_I", 0) * total
        return [dz, (2 * u - 0.981 * dz) / 0.3, error, (error - slow) / tau]

    true = solve_ivp(rate, (0, 9), np.zeros(4), "LSODA", t, rtol=1e-10, atol=1e-12)
    assert np.allclose(loop.simulate(t, r=[0.7]).z[0], true.y[0], atol=1e-7)


def test_a_loop_is_proven_and_a_plant_that_breaks_it_named():
    kept = sos.analyse_pid(ARM, GAINS, law=PID, region=sos.PoleRegion(sigma=0.14))
    assert kept.status == "feasible" and kept.certify().proven
    assert "under u = K y with y = [" in str(kept.certify())
    (words, _), *_ = kept.request.claims.statements()
    assert "and the memory [integral of z1, filtered z1], is stable" in words
    true = -kept.poles(samples=200).real.max()
    bound = kept.bounds()["sigma"]
    assert 0.998 * true < bound.proven < true * (1 + 1e-9)
    broken = sos.analyse_pid(ARM, GAINS, law=PID, region=sos.PoleRegion(sigma=0.145))
    assert broken.status == "infeasible" and broken.infeasibility.proven
    assert broken.infeasibility.verify()


def test_ranges_of_parameters_are_named_in_the_proof():
    plant = sos.Uncertain(joint, J=(1, 2), k=(8, 12))
    d = sos.analyse_pid(plant, GAINS, law=PID, region=sos.PoleRegion(sigma=0.14))
    assert "every constant plant with J in [1, 2] and k in [8, 12]" in str(d.certify())
    broken = sos.analyse_pid(plant, GAINS, law=PID, region=sos.PoleRegion(sigma=0.2))
    assert broken.infeasibility.proven and "J = 2" in broken.reason


def test_the_norm_is_that_of_python_control():
    d = sos.analyse_pid(ARM, GAINS, law=PID, minimize="gamma")
    true = 0.0
    for v, loop in zip(ARM.vertices, d.closed_loop()):
        w = np.linspace(0, 20, 1001)
        for _ in range(2):  # again between the neighbours of the highest
            sizes = np.linalg.norm(loop(1j * w)[:2, 0], axis=0)
            k = sizes.argmax()
            w = np.linspace(w[max(k - 1, 0)], w[k + 1], 200)
        true = max(true, sizes.max())
        assert loop.nstates == 6 and v.n == 2
    assert d.hinf() == pytest.approx(true, rel=1e-4)
    assert true < d.gamma < 1.02 * true and d.certify().proven


def test_margins_are_those_where_u_enters_the_plant():
    plant = joint(1, 8)
    d = sos.analyse_pid(plant, GAINS, law=PID)
    c = d.loop.to_ss()
    G = control.ss(*by_hand(plant), [[1, 0, 0, 0]], 0)
    C = control.ss(c.A, c.B, c.C, c.D)
    S = control.feedback(control.ss([], [], [], [[1]]), -C * G)
    assert d.sensitivity_peak() == pytest.approx(control.system_norm(S, "inf"), 1e-3)


def test_products_are_of_rationals():
    """0.3 is no product of floats: 1/tau and K C_y are exact."""
    law = sos.PIDLaw(position=[[0.1, 0.3]], filter=0.03)
    d = sos.analyse_pid(joint(1, 8), {"K_P": [[-7.0]], "K_D": [[-0.1]]}, law=law)
    K = d.request.exact_gain
    assert K[0, 4] == exact(0.1) / exact(0.03)
    assert K[0, 1] == -exact(0.3) * (7 + exact(0.1) / exact(0.03))
    assert d.request.vertices_in(exact)[0].A[4, 1] == exact(0.3)


def test_an_observer_with_a_state_feedback_is_a_dynamic_law():
    plant = joint(1.5, 10)
    (A, B), C = by_hand(plant), np.array([[1.0, 0, 0, 0]])
    K, _, _ = control.lqr(A, B, np.eye(4), [[1]])
    L = control.lqr(A.T, C.T, np.eye(4), [[1]])[0].T
    K, L = -K.round(6), L.round(6)
    law = sos.DynamicLaw(order=4, position=[[1, 0]])
    gains = {"A_c": A + B @ K - L @ C, "B_c": L, "C_c": K}
    d = sos.analyse_pid(ARM, gains, law=law)
    assert d.status == "feasible" and d.certify().proven
    one = sos.analyse_pid(plant, gains, law=law)
    wanted = [*np.linalg.eigvals(A + B @ K), *np.linalg.eigvals(A - L @ C)]
    same(one.poles(), wanted)


def test_full_state_is_the_design_without_a_law():
    """To the last bit, and with z as the output by name as well."""
    plain, law = dict(U=[[1, 0]]), dict(law=sos.FullState([[1, 0]]))
    z = sos.HInfinity(3.0, outputs=sos.Output(position=np.eye(2)))
    for coupling in ("pairs", "slack"):
        asked = dict(region=sos.PoleRegion(sigma=0.2), coupling=coupling)
        first = sos.design_pid(ARM, gamma=3.0, **plain, **asked)
        assert first.status == "feasible"
        for given in (dict(gamma=3.0), dict(requirements=[z])):
            for how in (plain, law):
                again = sos.design_pid(ARM, **given, **how, **asked)
                assert (first.K == again.K).all()


def test_a_law_that_measures_the_whole_state_is_the_feedback_of_it():
    """The same gains by both: poles, norm, bounds, motion, ticks and program."""
    plants = sos.Polytope(
        sos.SecondOrderSystem(
            [[0.3, 0.1], [0.1, 9.81]], [[0.2, -0.3], [0.1, 0.4]],
            [[2 * k, -1], [-1.3, 3]], [[1, 0.3], [-0.7, 2]], [[1], [0.3]],
        )
        for k in (1, 1.2)
    )  # fmt: skip
    one, region = np.eye(2), sos.PoleRegion(sigma=0.3, rho=20)
    asked = dict(region=region, gamma=0.05)
    K = sos.design_pid(plants, one, **asked).certify().K
    first = sos.analyse_pid(plants, K, one, **asked)
    law = sos.PIDLaw(one, one, integrate=True)
    gains = {name: first.gains[name] for name in ("K_P", "K_D", "K_I")}
    other = sos.analyse_pid(plants, gains, law=law, **asked)
    assert first.status == other.status == "feasible" and (first.K == other.K).all()
    assert (first.poles() == other.poles()).all() and first.hinf() == other.hinf()
    assert str(first.bounds()) == str(other.bounds())
    signals = dict(r=[1, -0.3], w=sos.Sine(0.3, 2.0))
    t = np.linspace(0, 5, 40)
    pairs = zip(first.simulate(t, **signals), other.simulate(t, **signals))
    controllers = [d.controller(T=0.02) for d in (first, other)]
    ticks = [c.simulate(2.0, r=[1, -0.3]) for c in controllers]
    for x, y in (*pairs, ticks):
        assert np.array_equal(x.x, y.x) and np.array_equal(x.u, y.u)
    own, same_program = (c.to_c("pid").texts["pid.c"] for c in controllers)
    assert own == same_program


def test_full_state_is_a_law_like_the_others():
    """What it joins are the integrals, and its loop is that of K x."""
    U, K = [[0.3, 1]], np.array([[-1, -2, 0.3, -1, -9.81]])
    law = sos.FullState(U)
    parts, names = law.parts(ARM), ("z1", "z2", "z1'", "z2'", "integral of 0.3 z1 + z2")
    assert parts.signals == names and law.readings(ARM).names == names[:4]
    asked = sos.analyse_pid(ARM, K, U)
    assert (law.applied(ARM).gain(asked.gains) == K).all()
    assert law.structure(ARM).named(K).keys() == asked.gains.keys()
    for one, d in zip(parts.vertices(ARM, K), asked.request.vertices):
        assert all((getattr(one, x) == getattr(d, x)).all() for x in ("E", "A", "Bu"))
        same(np.linalg.eigvals(np.linalg.solve(one.E, one.A + one.Bu @ K)),
             np.linalg.eigvals(np.linalg.solve(d.E, d.A + d.Bu @ K)))  # fmt: skip


def test_no_place_asks_whether_there_is_a_law():
    """There is a law always, `FullState` where none is given."""
    package = Path(sos.__file__).parent
    asked = {r"law is (not )?None": 0, r"hasattr\(plant, .order.\)": 0}
    own = {"laws", "pendulum", "book", "checker"}
    texts = [
        file.read_text("utf-8")
        for file in package.rglob("*.py")
        if not own & set(file.relative_to(package).parts)
    ]
    for words, most in asked.items():
        assert sum(len(re.findall(words, text)) for text in texts) <= most, words


def test_an_edge_of_a_full_state_is_that_without_a_law():
    cart, edge = sos.SecondOrderSystem(1, 0.3, 2, 1, [[1]]), maps.edge
    asked = dict(region=sos.PoleRegion(sigma=1, rho=9.81), digits=1)
    plain = edge("sigma", cart, [[1]], **asked)
    law = edge("sigma", cart, law=sos.FullState([[1]]), **asked)
    assert plain.feasible == law.feasible > 1
    assert plain.infeasible == law.infeasible


def test_rows_of_a_descriptor_system():
    A = [[[-1.0, 2, 0], [0, -a, 1], [0, 0, -14]] for a in (0.5, 1.0)]
    plant = sos.DescriptorSystem(np.eye(3), A, [[0], [1], [14]], np.eye(3))
    law = sos.PIDLaw(position=[[1, 0, 0], [0, 1, 0]], integrate=[[1, 0]])
    K = [[-1.0, -2.0, -0.3]]
    d = sos.analyse_pid(plant, K, law=law)
    loop = np.zeros((4, 4))
    loop[:3, :3], loop[3, 0] = A[0], 1
    loop[:3] += np.array([[0], [1], [14]]) @ [[-1, -2, 0, -0.3]]
    same(d.poles()[0], np.linalg.eigvals(loop))
    with pytest.raises(ValueError, match="velocity: a DescriptorSystem"):
        sos.analyse_pid(plant, K, law=sos.PIDLaw(velocity=np.eye(3)))


def test_the_page_of_laws_does_what_it_says(monkeypatch):
    """By few starts; the search has tests of its own."""
    few = partial(sos.design_pid, search=sos.Search(starts=3))
    monkeypatch.setattr(sos, "design_pid", few)
    page = Path(__file__).parents[1] / "book" / "api" / "laws.md"
    text, asked = page.read_text("utf8"), []
    first, second = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    two = sos.Polytope(ARM.vertices[1:3])
    names = {"arm": two, "print": lambda *words: asked.append(words)}
    exec(first, names)
    d = names["d"]
    assert d.status == "feasible" and d.certify().proven and d.gamma > d.hinf()
    assert "starts with the seed 0, K_P up to" in str(*asked.pop())
    exec(second, names)
    assert "every constant plant of the polytope" in str(*asked.pop())
    assert {"K_P", "K_D", "K_I"} == names["d"].gains.keys()


BAD = {
    "position is missing": lambda: sos.PIDLaw(),
    "position: row 2 is zero, a sensor": lambda: sos.PIDLaw([[1, 0], [0, 0]]),
    "velocity: row 1 is zero": lambda: sos.DynamicLaw(2, velocity=[[0, 0]]),
    "filter must be": lambda: sos.PIDLaw([[1, 0]], filter=0),
    "filter and velocity are given": lambda: sos.PIDLaw([[1]], [[1]], filter=1),
    "integrate must": lambda: sos.PIDLaw([[1, 0]], integrate=None),
    "strictly_proper must": lambda: sos.DynamicLaw(1, [[1]], strictly_proper="no"),
    "order is 0": lambda: sos.DynamicLaw(0, [[1, 0]]),
    "order must be 0, 1": lambda: sos.DynamicLaw(-1, [[1, 0]]),
    "order must be 100 or less": lambda: sos.DynamicLaw(10**9, [[1, 0]]),
    "limits must be a dict": lambda: sos.PIDLaw([[1, 0]], limits={"K": 3}),
    "structure must be a dict": lambda: sos.DynamicLaw(1, [[1, 0]], structure="a"),
    "law and U are given": lambda: sos.design_pid(ARM, [[1, 0]], law=PID),
    "law must be": lambda: sos.analyse_pid(ARM, GAINS, law="PID"),
    "no gain 'K_X'": lambda: sos.analyse_pid(ARM, {"K_X": [[1]]}, law=PID),
    "coupling='pairs'": lambda: sos.analyse_pid(ARM, GAINS, law=PID, coupling="pairs"),
    "mu = 1 is given": lambda: sos.analyse_pid(
        ARM, GAINS, law=PID, gamma=sos.HInfinity(1, mu=1)
    ),
    "leaves no gain free": lambda: sos.analyse_pid(
        ARM, [[0]], law=sos.PIDLaw([[1, 0]], structure=[[0]])
    ),
    "an entry of K_P is '--a'": lambda: sos.analyse_pid(
        ARM, [[0]], law=sos.PIDLaw([[1, 0]], structure=[["--a"]])
    ),
    '"diagonal" needs as many': lambda: sos.analyse_pid(
        ARM, [[0, 0]], law=sos.PIDLaw(np.eye(2), structure="diagonal")
    ),
    "isn't what the law's structure allows": lambda: sos.analyse_pid(
        ARM, [[1.0, 2.0]], law=sos.PIDLaw(np.eye(2), structure=[["a", "-a"]])
    ),
    "two sensors measure z1": lambda: sos.analyse_pid(
        ARM, [[1.0, 2.0]], law=sos.PIDLaw([[1, 0], [1, 0]])
    ),
    "position has rows of width 1, but the plant has 2": lambda: sos.analyse_pid(
        ARM, [[1.0]], law=sos.PIDLaw([[1]])
    ),
}


@pytest.mark.parametrize("words", BAD)
def test_bad_input_is_named(words):
    with pytest.raises(ValueError) as told:
        BAD[words]()
    assert words in str(told.value)


def test_sensors_that_differ_in_the_last_digits_are_two():
    rows = [[1, 0.12345678], [1, 0.12345679]]
    d = sos.analyse_pid(joint(1, 8), [[-1.0, 0]], law=sos.PIDLaw(rows))
    assert (d.request.applied.parts.rows == exact(np.pad(rows, ((0, 0), (0, 2))))).all()


def test_a_bound_that_is_none_is_named():
    d = sos.analyse_pid(ARM, GAINS, law=PID, region=sos.PoleRegion(sigma=0.1))
    with pytest.raises(KeyError, match="no bound is called 'gamma'.*sigma"):
        d.bounds()["gamma"]


def test_one_letter_is_one_number():
    law = sos.PIDLaw(np.eye(2), structure=[["a", 0], [0, "-a"]])
    plant = sos.SecondOrderSystem(np.eye(2), np.eye(2), np.eye(2), np.eye(2))
    assert law.structure(plant).directions.tolist() == [[[1, 0], [0, -1]]]
