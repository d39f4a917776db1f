"""Vertices that are a box but for rounding: what is read, what it costs, who pays."""

import json
from dataclasses import replace
from fractions import Fraction
from itertools import product

import numpy as np
import pytest
from scipy.linalg import solve_continuous_lyapunov

import sosbook as sos
from sosbook.book import thesis
from sosbook.exact.checker import payment, subject, verdict
from sosbook.plants import descriptors, near_box
from sosbook.plants.as_data import plant_data
from sosbook.proofs import load
from sosbook.requirements.cost import QuadraticCost
from sosbook.studies import polytopes
from sosbook.synthesis.payments import NOT_PAID
from tests.cases import by_hand, by_turns, campaign, examples

I2 = np.eye(2)
UNITS = (1.0, 0.3, 1 / 9.81, 2.2046, 1e-9 / 0.3, 0.7e9)
REGION = sos.PoleRegion(sigma=0.1, rho=20)


def levers(seed, unit=1.0, time=1.0, length=1.0, moved=None):
    """Two masses on levers: the corners as floats have them, in other units.

    That of length is the second coordinate's alone, as of an angle beside a way.
    """
    rng = np.random.default_rng(seed)
    D, S = rng.uniform(-1, 1, (2, 2)).round(1), rng.uniform(-3, 3, (2, 2)).round(1)
    tops = rng.choice([1, 2, 4], 2)
    arms = [np.array([1, 0.5]), np.array([-0.5, 1])]
    turn = np.diag([1, length])
    masses = [
        unit
        * time**2
        * (
            turn
            @ (
                np.diag([0.5, 0.25])
                + sum(on * x * np.outer(j, j) for on, x, j in zip(place, tops, arms))
            )
            @ turn
        )
        for place in product((0, 1), repeat=2)
    ]
    if moved is not None:
        masses[moved] = np.nextafter(masses[moved], np.inf)
    D, S = unit * time * turn @ D @ turn, unit * turn @ S @ turn
    B = turn @ [[1.0], [0.0]]
    return sos.Polytope(sos.SecondOrderSystem(M, D, S, B) for M in masses)


def requests(units=UNITS, times=(0.3, 2.2046), lengths=(0.3, 1 / 9.81)):
    """What is changed, and how much faster time runs then."""
    yield from ((dict(unit=unit), 1.0) for unit in units)
    yield from ((dict(unit=0.3, time=time), time) for time in times)
    yield from ((dict(unit=2.2046, length=x), 1.0) for x in lengths)
    yield from ((dict(moved=k), 1.0) for k in range(4))


def verdict_of(plants, pace=1.0):
    region = sos.PoleRegion(sigma=0.1 / pace, rho=20 / pace)
    design = sos.design_pid(plants, region=region, coupling="pairs")
    proof = design.certify() if design.K is not None else design.infeasibility
    return design.status, proof.proven, len(design.request.pairs)


@pytest.mark.parametrize("seed", [1, *campaign([0, 2, 8])])
def test_no_unit_and_no_last_bit_changes_a_verdict(seed):
    """Of boxes whose corners are sums and products of floats."""
    some = [*requests()][:: examples(2, 1)]
    verdicts = {verdict_of(levers(seed, **how), pace) for how, pace in some}
    assert len(verdicts) == 1 and verdicts.pop()[1:] == (True, 4)


def test_a_block_that_no_plant_moves_has_nothing_to_pay():
    """An H2 norm has one: its bound, less a trace."""
    vertices = [replace(v, F=I2[:, :1]) for v in levers(1, moved=0).vertices]
    asked = dict(requirements=[sos.H2(3.0)], coupling="pairs")
    design = sos.design_pid(sos.Polytope(vertices), **asked)
    assert design.request.ground.near is not None and len(design.request.pairs) == 4
    assert design.certify().proven
    for v in vertices:
        A, B = by_hand(v)
        A, push = (
            A + B @ design.K,
            np.vstack([0 * I2[:, :1], np.linalg.solve(v.M, v.F)]),
        )
        X = solve_continuous_lyapunov(A, -push @ push.T)
        assert np.sqrt(np.trace(X[:2, :2])) < 3.0


def test_a_refusal_is_of_vertices_that_are_its_box_s_corners(tmp_path):
    """Its blocks are the corners': of a plant with more force they say nothing."""
    asked = dict(region=REGION, saturation=sos.Saturation(17.9, [1, 0, 0, 0]))
    plants, file = levers(8, 0.3), tmp_path / "proof.json"
    proof = sos.design_pid(plants, coupling="pairs", **asked).infeasibility
    assert "at the corners of a box" in verdict.check(proof.text)[0]
    easy = sos.Polytope(replace(v, B=1000 * v.B) for v in plants.vertices)
    assert sos.design_pid(easy, coupling="pairs", **asked).K is not None
    other = json.loads(proof.text)
    for strong, of in ((False, plants), (True, easy)):
        other["asks"]["plant"] = plant_data(of)
        other["about"] = subject.about(verdict.asked_of(other))
        file.write_text(json.dumps(other), "utf-8")
        assert load(file).proven is not strong
    with pytest.raises(verdict.Refused, match="far from the vertices"):
        verdict.check(file.read_text("utf-8"))


@pytest.mark.parametrize("share, status", [(0.8, "feasible"), (1.02, "infeasible")])
def test_free_multipliers_need_no_box(share, status):
    """Their blocks are affine in E and A: no quotient moves out of a hull."""
    plants = levers(1)
    K = sos.design_pid(plants, region=REGION, coupling="pairs").certify().K
    sigma = share * min(decay(p, K) for p in (*plants.vertices, *plants.sample(200, 1)))
    verdicts = set()
    for how, pace in [*requests()][1 :: examples(3, 1)]:
        turn = np.diag([1, how.get("length", 1.0)])
        gain = how.get("unit", 1.0) * np.hstack(
            [K[:, :2] @ turn, pace * K[:, 2:] @ turn]
        )
        region = sos.PoleRegion(sigma=sigma / pace)
        found = sos.analyse_pid(
            levers(1, **how), gain, coupling="multipliers", region=region
        )
        proof = found.infeasibility or found.certify()
        verdicts.add((found.status, proof.proven))
    assert verdicts == {(status, True)}


def decay(plant, K):
    A, B = by_hand(plant)
    return -np.linalg.eigvals(A + B @ K).real.max()


@pytest.mark.campaign
def test_four_hundred_requests_keep_their_verdicts():
    units = (*UNITS, 1e9, 1e-9)
    several = list(requests(units, (0.3, 2.2046, 1 / 9.81), (0.3, 2.2046, 1e-3)))
    for seed in range(24):
        verdicts = {verdict_of(levers(seed, **how), pace) for how, pace in several}
        assert len(verdicts) == 1, (seed, verdicts)


def rounded(digits, levers, rng, n=3):
    """The corners of a random box, rounded: they are no box, but near one."""
    arms = [rng.uniform(-1, 1, n).round(2) for _ in range(levers)]
    tops = rng.uniform(0.3, 3, levers).round(1)
    damping = 0.3 * np.eye(n) + rng.uniform(-0.1, 0.1, (n, n)).round(2)
    stiff, base = np.diag(rng.uniform(1, 4, n).round(2)), np.diag([1.0, 2, 1.5])

    def entries(x):
        return np.array([float(f"{e:.{digits - 1}e}") for e in x.flat]).reshape(x.shape)

    return sos.Polytope(
        sos.SecondOrderSystem(
            entries(base + sum(t * m * np.outer(j, j) for t, m, j in zip(*x))),
            damping, stiff, np.eye(n), np.eye(n)[:, :1],
        )
        for on in product((0, 1), repeat=levers)
        for x in [(on, tops, arms)]
    )  # fmt: skip


@pytest.mark.parametrize("digits", by_turns([3, 4, 5], 0))
def test_no_plant_lies_farther_from_the_box_than_is_said(digits, monkeypatch):
    """Its quotient from that of the plant of the box with the same weights."""
    monkeypatch.setattr(near_box, "ROUNDING", 10.0 ** (2 - digits))
    rng, seen, share = np.random.default_rng(digits), 0, 0.0
    for k in range(30):
        plants = rounded(digits, 1 + k % 2, rng)
        near = near_box.NearBox.of(plants)
        if near is None:
            continue
        given = descriptors(plants)
        corners, far = near.ground(given, descriptors) or (None, None)
        if corners is None:
            continue
        seen += 1
        for weights in [*np.eye(len(given)), *rng.dirichlet(np.ones(len(given)), 50)]:
            X, Xt = (
                np.linalg.solve(w[:, :6], w[:, 6:])
                for w in (
                    sum(
                        w * np.hstack([d.E, d.A, d.Bu, d.Bw])
                        for w, d in zip(weights, several)
                    )
                    for several in (given, corners)
                )
            )
            assert (np.abs(X - Xt) <= far * (1 + 1e-9) + 1e-13).all()
            share = max(share, (np.abs(X - Xt)[far > 0] / far[far > 0]).max())
    assert seen >= 10 and 0.05 < share <= 1


ASKED = {
    "poles": dict(region=sos.PoleRegion(sigma=0.2, theta=1.2, rho=30)),
    "norm": dict(gamma=3.0),
    "input": dict(
        region=sos.PoleRegion(sigma=0.1),
        saturation=sos.Saturation(30.0, [0.1, 0, 0, 0, 0, 0]),
        gamma=6.0,
    ),
    "noise": dict(
        requirements=[QuadraticCost(np.eye(6), np.eye(3), noise="F", bound=60.0)]
    ),
    "states": dict(requirements=[QuadraticCost(np.eye(6), np.eye(3), bound=500.0)]),
}


def kept(plants, K, asked, seed=3):
    """Whether random plants of the polytope are what is asked, by eigenvalues."""
    gains = sos.design_pid(plants, coupling="vertices", **asked).request.demands
    loops = [d for p in plants.sample(20, seed) for d in descriptors(p)]
    loops += descriptors(plants)
    return all(r.kept(r.truth(loops, K)) > 0 for r in gains)


@pytest.mark.parametrize("name", ASKED)
def test_two_readers_take_what_is_paid(name, monkeypatch):
    """Corners with four digits, where the payment is no rounding error."""
    monkeypatch.setattr(near_box, "ROUNDING", 1e-2)
    plants = rounded(4, 1, np.random.default_rng(5))
    design = sos.design_pid(plants, coupling="pairs", **ASKED[name])
    assert design.request.ground.near is not None and design.status == "feasible"
    proof = design.certify()
    assert proof.claims[0].startswith("every constant or changing plant of")
    assert list(verdict.check(proof.text)) == list(proof.claims)
    prices = [x for k, x in json.loads(proof.text)["data"].items() if "pay." in k]
    assert prices and max(eval(e) for x in prices for r in x for e in r) > 1e-7
    assert kept(plants, proof.K, ASKED[name])


@pytest.mark.parametrize("kind", ["second order", "first order"])
def test_a_spoilt_payment_is_refused(kind, tmp_path):
    plants = levers(8, 0.3)
    if kind == "first order":
        plants = sos.DescriptorSystem.of(descriptors(plants))
    design = sos.design_pid(plants, region=REGION, coupling="pairs")
    proof = design.certify()
    assert design.request.ground.near is not None and proof.proven
    whole = json.loads(proof.text)

    def spoilt(change):
        file = tmp_path / "proof.json"
        other = json.loads(proof.text)
        change(other)
        assert other != whole
        file.write_text(json.dumps(other), "utf-8")
        with pytest.raises((verdict.Refused, *verdict.MALFORMED, verdict.Beyond)):
            verdict.check(file.read_text("utf-8"))
        return load(file).proven

    price = next(k for k in whole["data"] if k.startswith("pay."))
    lines = [k for k, x in enumerate(whole["text"]) if "pay." in x]
    where = "M" if kind == "second order" else "E"

    def no_price(file):
        file["data"][price][2][2] = "0"

    def no_word(file):
        for k in lines:
            file["text"][k] = file["text"][k].split(" - pay.")[0] + " > 0"
        file["data"] = {k: x for k, x in file["data"].items() if "pay." not in k}

    def no_box(file):
        del file["asks"]["box"]

    def other_box(file):
        file["asks"]["box"]["parameters"][0][2] = "2"

    def other_corners(file):
        file["asks"]["box"]["corners"].reverse()

    def other_plant(file):
        file["asks"]["plant"]["vertices"][1][where][-1][-1] = "0.3"

    for change in (no_price, no_word, no_box, other_box, other_corners, other_plant):
        assert not spoilt(change)


def test_the_vertices_come_in_any_order():
    plants = sos.Polytope(levers(8, 0.3).vertices[::-1])
    design = sos.design_pid(plants, region=REGION, coupling="pairs")
    near, ground = design.request.ground.near, design.request.ground.vertices
    assert str(near.family.box) == (
        "near_vertex_2 in [0, 1] and near_vertex_3 in [0, 1]"
    )
    for d, c in zip(design.request.vertices, ground):
        assert d is not c and np.abs(d.E - c.E).max() < 1e-15
    proof = design.certify()
    assert verdict.check(proof.text) == list(proof.claims)
    for plant in [*plants.sample(30, 2), *plants.vertices]:
        d = descriptors(plant)[0]
        poles = np.linalg.eigvals(np.linalg.solve(d.E, d.A + d.Bu @ proof.K))
        assert poles.real.max() < -0.1


def hidden():
    """One vertex is unstable by a millionth of a millionth of its stiffness."""
    stiff = 2e12
    return sos.Polytope(
        sos.SecondOrderSystem(
            np.diag([1 + a, 1]), 1e6 * I2, stiff + (1 - 3 * a) * I2, I2
        )
        for a in (0, 0.5)
    )


@pytest.mark.parametrize("coupling", ["pairs", "vertices", "auto"])
def test_no_box_hides_an_unstable_plant(coupling):
    plants = hidden()
    assert np.linalg.det(plants.vertices[1].S) < 0
    assert near_box.NearBox.of(plants) is not None
    loop = sos.analyse_pid(plants, np.zeros((2, 4)), coupling=coupling)
    assert loop.status != "feasible" and not loop.certify().proven


def test_what_doesnt_pay_is_undecided(monkeypatch):
    """At a distance that no margin pays; and the words say what to give."""
    monkeypatch.setattr(near_box, "ROUNDING", 1e-2)
    plants = rounded(4, 1, np.random.default_rng(5))
    ground, statuses = near_box.NearBox.ground, []
    honest = payment.reach
    for far in (1.0, 1e4):

        def farther(self, *given, far=far):
            corners, reach = ground(self, *given)
            return corners, far * reach

        monkeypatch.setattr(near_box.NearBox, "ground", farther)
        times = [Fraction(far)]
        monkeypatch.setattr(payment, "reach", lambda *x: honest(*x).times(*times))
        design = sos.design_pid(plants, **ASKED["norm"], coupling="pairs")
        statuses.append(design.status)
    assert statuses == ["feasible", "undecided"] and NOT_PAID in design.reason
    assert not design.certify().proven


def test_what_is_no_box_is_left_alone():
    rng, box = np.random.default_rng(1), levers(7, 0.3)
    typed = [
        sos.SecondOrderSystem(v.M.round(3), v.D, v.S, v.B) for v in levers(3).vertices
    ]
    typed[1] = sos.SecondOrderSystem(
        typed[1].M + [[0, 1e-6], [0, 0]], 0 * I2, I2, I2[:, :1]
    )
    others = [
        sos.Polytope(box.vertices[:3] + box.vertices[:1]),
        sos.Polytope([sos.SecondOrderSystem(m, 1, 1, 1) for m in (1, 2)]),  # exactly
        sos.Polytope([sos.SecondOrderSystem(m, 1, 1, 1) for m in (0.3, 0.1 + 0.2)]),
        sos.Polytope(typed),
        sos.Polytope(
            sos.SecondOrderSystem(x @ x.T + I2, I2, I2, I2)
            for x in rng.normal(size=(4, 2, 2))
        ),
    ]
    for plants in others:
        assert near_box.NearBox.of(plants) is None
    near = near_box.NearBox.of(box)
    assert near is not None and near_box.NearBox.of(box) is near


def test_a_certain_mass_with_a_rounding_is_one():
    """0.1 + 0.2 and 0.3 are one mass: no pair of vertices is asked."""
    plants = sos.Polytope(
        sos.SecondOrderSystem(m, d, 1, 1) for m, d in ((0.3, 1), (0.1 + 0.2, 2))
    )
    assert polytopes.vertices_suffice(plants)
    design = sos.design_pid(plants, region=REGION, coupling="pairs")
    assert len(design.request.pairs) == 2 and design.certify().proven


@pytest.mark.parametrize("turned, known, status", [
    (0.0, False, "feasible"), (0.3, True, "feasible"), (0.3, False, "infeasible"),
])  # fmt: skip
def test_what_the_box_buys_in_turned_coordinates(turned, known, status, monkeypatch):
    """The seat of Example 2 for drivers of 70 to 400 kg, which its pair refuses."""
    c, s = np.cos(turned), np.sin(turned)
    example, T = thesis.example_2(), np.array([[c, -s], [s, c]])
    v = example.plant.vertices[0]
    drivers = [
        sos.SecondOrderSystem(
            T.T @ np.diag([m, v.M[1, 1]]) @ T,
            *(T.T @ x @ T for x in (v.D, v.S)), T.T @ v.B, T.T @ v.F,
        )
        for m in (70, 400)
    ]  # fmt: skip
    start = example.saturation.x0
    start = [*(T.T @ start[:2]), *(T.T @ start[2:4]), *start[4:]]
    asked = {k: x for k, x in example.requirements.items() if x is not None}
    limit = sos.Saturation(example.saturation.u_max, start)
    asked |= {"U": example.U @ T, "saturation": limit}
    if not known:
        monkeypatch.setattr(near_box.NearBox, "of", lambda plant: None)
    design = sos.design_pid(sos.Polytope(drivers), **asked, coupling="pairs")
    assert design.status == status
    proof = design.certify() if status == "feasible" else design.infeasibility
    assert proof.proven
