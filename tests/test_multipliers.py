"""A known gain: kept with a proof, or broken by a plant, compared with the truth:
numpy's eigenvalues, grids of frequencies, Lyapunov's equation, scipy's exponential.
"""

import contextlib
import itertools
import re

import numpy as np
import pytest
from scipy.linalg import expm, solve_continuous_lyapunov

import sosbook as sos
from sosbook import theorems
from sosbook.analysis import precise
from sosbook.exact.checker import verdict
from sosbook.exact.definite import exact
from sosbook.plants.descriptor import Descriptor, descriptors
from sosbook.requirements.known_gain import KnownLoop, KnownVertex
from sosbook.synthesis import known_gain
from sosbook.synthesis.cells import Mixtures
from sosbook.synthesis.ranges import family
from sosbook.synthesis.request import Request
from tests.cases import campaign, norm_on_a_grid, seeds
from tests.closed import analyse_loop


def loops(seed, vertices=2, order=4, spread=0.2):
    """Random stable loops with an uncertain E: lists E, A, B and one C."""
    rng = np.random.default_rng(seed)
    A0 = rng.standard_normal((order, order))
    A0 -= (np.linalg.eigvals(A0).real.max() + rng.uniform(0.2, 1)) * np.eye(order)
    E, A, B = [], [], []
    for _ in range(vertices):
        e = np.eye(order) + spread * rng.uniform(-1, 1, (order, order)) / order
        E.append(e.round(3))
        A.append((e @ A0 + spread * rng.uniform(-1, 1, A0.shape) / order).round(3))
        B.append(rng.standard_normal((order, 2)).round(2))
    return E, A, B, rng.standard_normal((2, order)).round(2)


def between(E, A, B, count=25, seed=0):
    """E^-1 A and E^-1 B at the vertices and at random mixtures of them."""
    rng = np.random.default_rng(seed)
    weights = [*np.eye(len(E)), *rng.dirichlet(np.full(len(E), 0.5), count)]
    for w in weights:
        e, a, b = (np.tensordot(w, x, 1) for x in (E, A, B))
        yield np.linalg.solve(e, a), np.linalg.solve(e, b)


def peak(A, x0, row):
    t = np.linspace(0, 8 / -np.linalg.eigvals(A).real.max(), 3000)
    step, x, most = expm(A * t[1]), x0, 0.0
    for _ in t:
        most, x = max(most, np.linalg.norm(row @ x)), step @ x
    return most


REGIONS = {
    "half-plane": lambda s: (-s.real.max(), lambda x: sos.LMIRegion.half_plane(x), -1),
    "disk": lambda s: (abs(s + 1).max(), lambda x: sos.LMIRegion.disk(x, -1), 1),
    "sector": lambda s: (
        np.arctan2(abs(s.imag), -s.real).max(),
        lambda x: sos.LMIRegion.sector(x),
        1,
    ),
    "strip": lambda s: (
        abs(s.imag).max(), lambda x: sos.LMIRegion.horizontal_strip(x), 1
    ),
}  # fmt: skip


@pytest.mark.parametrize("seed", seeds(3))
@pytest.mark.parametrize("name", REGIONS)
def test_at_one_plant_nothing_is_lost(name, seed):
    E, A, B, C = loops(seed, vertices=1)
    poles = np.linalg.eigvals(np.linalg.solve(E[0], A[0]))
    edge, region, easier = REGIONS[name](poles)
    asked = dict(coupling="multipliers")
    good = analyse_loop(E, A, region=region(edge * (1 + easier * 0.005)), **asked)
    assert good.status == "feasible" and good.certify().proven
    bad = analyse_loop(E, A, region=region(edge * (1 - easier * 0.001)), **asked)
    assert bad.status == "infeasible" and bad.infeasibility.proven


@pytest.mark.parametrize("seed", seeds(3))
def test_norm_cost_and_peak_of_one_plant(seed):
    E, A, B, C = (x[0] if len(x) == 1 else x for x in loops(seed, vertices=1))
    A_, B_ = np.linalg.solve(E, A), np.linalg.solve(E, B)
    asked = dict(coupling="multipliers")
    norm = norm_on_a_grid(A_, B_, C)
    for share, status in ((1.005, "feasible"), (0.999, "infeasible")):
        found = analyse_loop(E, A, B, C, gamma=share * norm, **asked)
        assert found.status == status
    X = solve_continuous_lyapunov(A_.T, -C.T @ C)
    for noise, where in (("F", B_), ("states", np.eye(4))):
        true = np.trace(where.T @ X @ where)
        for share, status in ((1.005, "feasible"), (0.999, "infeasible")):
            cost = sos.QuadraticCost(R=[], C=C, noise=noise, bound=share * true)
            assert (
                analyse_loop(E, A, B, C, requirements=[cost], **asked).status == status
            )
    system = sos.DescriptorSystem(E, A - B @ C, B, B, C)
    x0 = np.array([1.0, -1, 0.5, 0])
    least = sos.analyse_pid(
        system, C, saturation=sos.Saturation(None, x0), minimize="u_max", **asked
    )
    u_max = least.request.saturation.u_max
    assert least.certify().proven and u_max >= peak(A_, x0, C)
    printed = sos.analyse_pid(
        system, C, saturation=sos.Saturation(None, x0), minimize="u_max"
    )
    assert u_max < 1.06 * printed.request.saturation.u_max


@pytest.mark.parametrize("seed", [1, 2, *campaign([0, *range(3, 12)])])
def test_what_is_proven_holds_for_every_plant_that_is_tried(seed):
    E, A, B, C = loops(seed, vertices=2 + seed % 3, order=3 + seed % 2, spread=0.8)
    every = list(between(E, A, B))
    slowest = max(np.linalg.eigvals(a).real.max() for a, _ in every)
    if slowest >= 0:
        found = analyse_loop(E, A)
        assert found.status == "infeasible" and found.infeasibility.proven
        return
    sigma = float(f"{-0.97 * slowest:.4g}")
    norm = max(norm_on_a_grid(a, b, C) for a, b in every)
    gamma = float(f"{1.05 * norm:.4g}")
    found = analyse_loop(E, A, B, C, region=sos.PoleRegion(sigma), gamma=gamma)
    assert found.status == "feasible"
    proof = found.certify()
    assert proof.verify() and len(proof.claims) == 3
    for a, b in between(E, A, B, seed=seed + 1):
        assert np.linalg.eigvals(a).real.max() < -sigma
        assert norm_on_a_grid(a, b, C) < gamma


@pytest.mark.parametrize("unit", [0.3, 2.2046e3, *campaign([1.0, 1 / 9.81])])
def test_units_of_force_and_time_change_no_verdict(unit):
    E, A, B, C = loops(5, vertices=4, spread=0.6)
    slowest = max(np.linalg.eigvals(a).real.max() for a, _ in between(E, A, B, 400))
    for share, status in ((0.98, "feasible"), (1.01, "infeasible")):
        region = sos.PoleRegion(-share * slowest * unit)
        force = [unit * x for x in E], [unit**2 * x for x in A]
        assert analyse_loop(*force, region=region).status == status


def parameters(m, k, d):
    return sos.SecondOrderSystem(
        np.diag([1, m]), [[0.1 + d, -d], [-d, d]], [[1 + k, -k], [-k, k]], [[1], [0]]
    )


def test_a_box_of_vertices_is_halved_by_its_parameters():
    """Eight vertices: simplices take many more cells than two boxes do."""
    corners = [(0.7, 1.4), (0.7, 1.4), (0.02, 0.1)]
    plants = sos.Polytope([parameters(*x) for x in itertools.product(*corners)])
    K, U = np.array([[-0.3, 0.1, -0.9, 0.05, -0.12]]), [[1, 0]]
    inside = np.random.default_rng(1).uniform(*zip(*corners), (300, 3))
    slowest = -np.inf
    for x in [*itertools.product(*corners), *inside]:
        (d,) = descriptors(parameters(*x), U)
        loop = np.linalg.solve(d.E, d.A + d.Bu @ K)
        slowest = max(slowest, np.linalg.eigvals(loop).real.max())
    kept = sos.analyse_pid(plants, K, U, region=sos.PoleRegion(-0.99 * slowest))
    assert kept.status == "feasible" and kept.parts[0].cells <= 4
    broken = sos.analyse_pid(plants, K, U, region=sos.PoleRegion(-1.002 * slowest))
    assert broken.status == "infeasible" and broken.infeasibility.proven


def test_what_a_plant_between_breaks_is_named():
    """Both vertices are stable; the stiffness between them isn't."""
    A = [[[-1, 3], [0, -1]], [[-1, 0], [3, -1]]]
    found = analyse_loop(np.eye(2), A)
    assert found.status == "infeasible" and "weights 1/2, 1/2" in found.reason
    assert found.infeasibility.proven and found.advice.endswith("ask for less.")
    assert np.linalg.eigvals(np.mean(A, axis=0)).max() == pytest.approx(0.5)


def test_auto_takes_multipliers_where_they_are_to_be_had():
    m = [sos.SecondOrderSystem(m, 0.1, 1, 1, 1) for m in (1, 2)]
    plants, K = sos.Polytope(m), [[-1, -1]]
    x0 = [1, 0]

    def coupling(plant=plants, **asked):
        return sos.analyse_pid(plant, K, **asked).request.coupling.word

    far = sos.Polytope([sos.SecondOrderSystem(m, 0.1, 1, 1, 1) for m in (0.1, 20)])
    assert coupling() == coupling(gamma=9) == coupling(m[0]) == "pairs"
    assert coupling(minimize="gamma") == coupling(far) == "multipliers"
    assert coupling(sos.Polytope([m[0], m[0]]), minimize="gamma") == "pairs"
    u = dict(saturation=sos.Saturation(None, x0), minimize="u_max")
    assert coupling(gamma=9, **u) == "multipliers"
    assert coupling(gamma=sos.HInfinity(9, mu=1.0), **u) == "pairs"
    same = sos.Polytope([sos.SecondOrderSystem(1, d, 1, 1) for d in (0.1, 1)])
    whole = sos.Saturation(None, x0, acceleration=True)
    assert coupling(same, saturation=whole, minimize="u_max") == "pairs"
    with pytest.raises(ValueError, match="for a given gain"):
        sos.design_pid(plants, coupling="multipliers")


def test_a_proof_is_a_file_about_the_gain_as_it_is_printed(tmp_path):
    plants = sos.Polytope([sos.SecondOrderSystem(m, 0.1, 1, 1) for m in (1, 2)])
    known = sos.analyse_pid(plants, [[-1 / 3, -1]], coupling="multipliers")
    for proof, K in (
        (known.certify(), [[-1 / 3, -1]]),
        (known.certify(3), [[-0.333, -1]]),
    ):
        assert proof.proven and proof.K.tolist() == K
        proof.save(tmp_path / "proof.json")
        again = sos.proofs.load(tmp_path / "proof.json")
        assert again.verify() and again.K.tolist() == K
        assert verdict.check(again.text) == list(proof.claims)


def test_the_time_ends():
    E, A, B, C = loops(3, vertices=4, order=8, spread=0.3)
    found = analyse_loop(E, A, B, C, gamma=1.0, search=sos.Search(time_limit=1e-3))
    assert found.status == "undecided" and "time_limit" in found.reason


def vertex(number=exact):
    """A vertex with random P, F, G and J, H: the values in floats, too."""
    rng = np.random.default_rng(4)
    N, m, p, q = 3, 1, 2, 2
    shapes = dict(E=(N, N), A=(N, N), Bu=(N, m), Bw=(N, p), C=(q, N), Du=(q, m))
    plant = Descriptor(*(rng.standard_normal(s).round(3) for s in shapes.values()))
    K = rng.standard_normal((m, N)).round(3)
    sizes = dict(P=(N, N), F=(N, N), G=(N, N), mu=(1, 1), J=(p, p), H=(N, N))
    values = {n: rng.standard_normal(s).round(3) for n, s in sizes.items()}
    for n in "PJ":
        values[n] = values[n] + values[n].T
    return KnownLoop(plant.map(exact), exact(K)), values


def texts(loop, values, number):
    own = {n: values[n] for n in ("mu", "J", "H")}
    c = KnownVertex(loop, values["P"], values["F"], values["G"], own, number)
    one = np.eye(1, dtype=int)
    return {
        "disk": theorems.free_pole_region(c, -3 * one, -2 * one, one),
        "stability": theorems.free_stability(c),
        "hinf": theorems.free_bounded_real(c, number(np.array([[2.5]]))[0, 0]),
        "lqr": theorems.free_lqr_decay(c, np.eye(3, dtype=int)),
        "noise": theorems.free_gramian(c, values["J"], values["H"]),
    }


@pytest.mark.parametrize("seed", seeds(5))
def test_along_a_motion_the_multipliers_vanish(seed):
    """The blocks at [x, x'], [x, x', w]: what is left is what they are about."""
    loop, v = vertex()
    rng = np.random.default_rng(seed)
    E, A, B, C, *_ = loop.in_floats
    x, w = rng.standard_normal(3), rng.standard_normal(2)
    rate = np.linalg.solve(E, A @ x + B @ w)
    g = texts(loop, v, lambda x: x)["hinf"][:8, :8]
    there = np.concatenate([x, rate, w])
    left = 2 * x @ v["P"] @ rate - v["mu"].item() * w @ w
    assert -there @ g @ there == pytest.approx(left, rel=1e-9)
    at = np.concatenate([x, np.linalg.solve(E, A @ x)])
    lqr = texts(loop, v, lambda x: x)["lqr"]
    left = 2 * x @ v["P"] @ at[3:] + v["mu"].item() * x @ x
    assert -at @ lqr @ at == pytest.approx(left, rel=1e-9)


def softening(v, m):
    """Least damped inside the range of v, which comes in its square."""
    d = 0.05 + (v - 0.4) ** 2
    return sos.SecondOrderSystem([[m]], [[d]], [[2 * m]], [[1]], [[1]])


def test_a_family_is_halved_by_its_ranges_and_broken_by_its_parameters():
    plants, K = sos.Uncertain(softening, v=(0, 1), m=(0.3, 9.81)), [[0, 0]]
    true = 0.05 / 9.81 / 2  # at v = 0.4, of the heaviest
    corners = [-p.poles().real.max() for p in plants.vertices]
    assert min(corners) < 0 < true  # of Bernstein's form, which aren't plants
    kept = sos.analyse_pid(plants, K, region=sos.PoleRegion(0.99 * true))
    assert kept.certify().proven and kept.parts[-1].cells > 1
    assert kept.certify().claims[0].startswith("every constant plant with v in")
    broken = sos.analyse_pid(plants, K, region=sos.PoleRegion(1.001 * true))
    assert breaks(broken, plants, 1.001 * true)
    assert "The plant with v = 0.4" in broken.reason and "vertex" not in broken.reason
    table = sos.analyse_pid(plants, K, region=sos.PoleRegion(0.9 * true)).bounds()
    assert table["sigma"].true == pytest.approx(true)
    assert 0.99 * true < table["sigma"].proven < true


def breaks(found, plants, sigma):
    """Whether the plant that is named has a pole right of -sigma."""
    assert found.status == "infeasible" and found.infeasibility.proven
    assert found.reason.count("with v") == 1
    v, m = re.search("v = ([0-9.]+), m = ([0-9.]+) has", found.reason).groups()
    return plants.at(v=float(v), m=float(m)).poles().real.max() > -sigma


def test_a_plant_that_breaks_a_claim_ends_the_search(monkeypatch):
    plants, K, seen = sos.Uncertain(softening, v=(0, 1), m=(0.3, 9.81)), [[0, 0]], []
    exactly = Mixtures.near
    monkeypatch.setattr(
        Mixtures, "near", lambda self, x: seen.append(x) or exactly(self, x)
    )
    for sigma, most in (0.06, 9), (0.051 / 9.81 / 2, 40), (0.049 / 9.81 / 2, 200):
        found = sos.analyse_pid(plants, K, region=sos.PoleRegion(sigma))
        assert (found.status == "feasible") == (most == 200)
        assert len(seen) <= most and (most == 200 or breaks(found, plants, sigma))
        seen.clear()


@pytest.mark.parametrize("doubtful", [False, True])
def test_a_search_asks_each_plant_what_is_sensitive_only_where_that_shows(
    monkeypatch, doubtful
):
    def asked(d, K):
        seen.append(d)
        return doubtful and exactly(d, K)

    exactly, seen = precise.sensitive, []
    monkeypatch.setattr(precise, "sensitive", asked)
    drive = (lambda k: sos.SecondOrderSystem(1, 2 * k, k**2, 1)) if doubtful else None
    plants = sos.Uncertain(drive or sunk, k=(0.3, 9.81))  # double poles are sensitive
    request = Request(plants, gain=[[0, 0]], region=sos.PoleRegion(sigma=0.01))
    (r,), there = request.demands, family(request)
    found = known_gain.worst(request, r, there)
    many = len(seen)
    monkeypatch.setattr(known_gain, "floats_alone", contextlib.nullcontext)
    again = known_gain.worst(request, r, there)
    assert found.kept == again.kept and (found.point == again.point).all()
    assert many < (1.1 if doubtful else 0.5) * (len(seen) - many)


def sunk(k):
    return sos.SecondOrderSystem([[1]], [[0.2 * (1 + (k - 3) ** 2)]], [[k]], [[1]])


def test_plants_of_the_search_are_those_of_the_family_to_rounding():
    plants = sos.Uncertain(softening, v=(0, 1), m=(0.3, 9.81))
    corners = sos.Polytope([softening(v, m) for v in (0, 1) for m in (0.3, 9.81)])
    for some in (plants, corners, sos.Polytope(corners.vertices[:3])):
        request = Request(some.polytope() if some is plants else some, gain=[[0, 0]])
        there = family(request)
        random = there.random(np.random.default_rng(1), 9)
        for point in np.vstack([*there.points(), random]):
            near, loop = there.near(point), there.at(there.exactly(point))
            for x, y in zip(vars(near).values(), vars(loop.plant_in_floats).values()):
                assert x is y or np.allclose(x, y, rtol=1e-13, atol=1e-14)


def test_the_halvings_reach_a_plant_that_the_search_has_missed(monkeypatch):
    plants, true = sos.Uncertain(softening, v=(0, 1), m=(0.3, 9.81)), 0.05 / 9.81 / 2
    blind = known_gain.Worst(np.array([1.0, 0.5]), 1.0, 1.0)
    monkeypatch.setattr(known_gain, "worst", lambda *_: blind)
    broken = sos.analyse_pid(plants, [[0, 0]], region=sos.PoleRegion(1.01 * true))
    assert breaks(broken, plants, 1.01 * true)


@pytest.mark.parametrize("count", [3, 18, 300])
def test_a_rounded_point_stays_in_the_polytope(count):
    """18 weights of 1/18, each rounded up, would leave -0.02 for the last."""
    loop, _ = vertex()
    family = Mixtures([loop] * count)
    rng = np.random.default_rng(count)
    for point in (np.full(count, 1 / count), *family.random(rng, 20)):
        for digits in (2, 3, 9):
            weights = family.rounded(point, digits)
            assert min(weights) >= 0 and sum(weights) == 1
            assert max(abs(float(w) - x) for w, x in zip(weights, point)) < (
                count * 10.0**-digits
            )


def test_what_is_proven_without_a_common_p_is_no_start_and_has_no_lmis_to_copy():
    carts = sos.Polytope([sos.SecondOrderSystem(m, 0.1, 1, 1) for m in (0.5, 2)])
    region = sos.PoleRegion(sigma=0.52)
    kept = sos.analyse_pid(carts, [[-3, -2]], region=region)
    assert kept.request.coupling.word == "multipliers" and kept.status == "feasible"
    started = sos.design_pid(carts, region=region, search=sos.Search(start=kept))
    assert (started.K == sos.design_pid(carts, region=region).K).all()
    with pytest.raises(ValueError, match='take coupling="pairs"'):
        kept.to_cvxpy()
