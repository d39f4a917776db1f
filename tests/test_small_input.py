"""An input bound that is too small for the modes that must be moved."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import sosbook as sos
from sosbook.exact.checker import verdict
from sosbook.plants.descriptor import descriptors
from sosbook.proofs import SmallInputRefusal
from sosbook.synthesis.feasibility import search
from sosbook.synthesis.request import Request
from sosbook.synthesis.small_input import refuse_by_input
from tests.cases import campaign, examples, later, seeds
from tests.least_input import least_input
from tests.random_plants import ODD, ODD_POWERS, as_units
from tests.test_near_box import levers

HERE = [1, 0.3, 0.2, 0.1]  # a state of two masses


def one_mass(M, D, S, B):
    return sos.SecondOrderSystem(*([[float(x)]] for x in (M, D, S, B)))


def of_one_mode(plant, sigma, x0):
    """dist(s) |w E x0| / |w B| of the mode right of -sigma, and of it alone."""
    M, D, S, B = (x.item() for x in (plant.M, plant.D, plant.S, plant.B))
    slow, fast = sorted(np.roots([M, D, S]).real, reverse=True)
    assert fast < -sigma < slow
    w = np.array([M * slow + D, 1.0])  # w A = slow w E
    return (slow + sigma) * abs(w @ np.diag([1, M]) @ x0 / (w[1] * B))


@pytest.mark.parametrize("unit", [ODD[0], *campaign([1e-6, 1.0, 1e6, *ODD[1:]])])
@pytest.mark.parametrize(
    ("M", "D", "S", "B", "sigma", "x0"),
    [
        (2, 0.3, -7, 3, 0.5, [0.2, -0.1]),
        (1, 1e3, 1, 1, 1.0, [1, 0]),
        *later((1, 0, -2, 1, 0.0, [1, 0]), (0.5, 4, 1, 0.1, 1.0, [1, 1])),
    ],
)
def test_one_degree_of_freedom(M, D, S, B, sigma, x0, unit):
    """The least bound of the LMIs is the formula for one mode."""
    plant = one_mass(unit * M, unit * D, unit * S, B)
    asked = {"region": sos.PoleRegion(sigma=sigma)} if sigma else {}
    least = of_one_mode(plant, sigma, np.array(x0, float))
    for share, status in (
        (0.1, "infeasible"),
        (0.999, "infeasible"),
        (1.01, "feasible"),
    ):
        bound = sos.Saturation(share * least, x0)
        design = sos.design_pid(plant, saturation=bound, **asked)
        assert design.status == status, design.reason
        if status == "infeasible":
            assert design.infeasibility.proven and design.infeasibility.verify()
            assert f"u_max = {share * least:g}" in design.reason


def random_request(seed, u_max=1.0):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 4))
    m = int(rng.integers(1, n + 1))

    def gram(size):
        x = size * rng.normal(size=(n, n))
        return x @ x.T

    plant = sos.SecondOrderSystem(
        np.eye(n) + gram(0.5),
        gram(0.5),
        gram(1) - rng.uniform(0, 2) * np.eye(n),
        rng.normal(size=(n, m)),
    )
    U = np.eye(n)[:m] if rng.random() < 0.5 else None
    region = [
        sos.PoleRegion(sigma=rng.uniform(0.1, 1)),
        sos.PoleRegion(sigma=rng.uniform(0.1, 1), theta=np.pi / 4),
        sos.PoleRegion(rho=3),
        sos.PoleRegion(sigma=0.4, theta=1.0, rho=6),
        None,
    ][seed % 5]
    x0 = rng.normal(size=2 * n + (0 if U is None else m))
    asked = {} if region is None else {"region": region}
    return Request(plant, U, saturation=sos.Saturation(u_max, x0), **asked)


SEEDS = [1, *campaign([0, *range(2, 16)])]


@pytest.mark.parametrize("seed", SEEDS)
def test_one_plant_is_decided_on_both_sides_of_its_least_bound(seed):
    """Clarabel's least bound, of LMIs written again, is possible and nearly least."""
    least = least_input(random_request(seed))
    if least is None or least < 1e-3:  # nothing has to be moved
        pytest.skip("no figure to compare with")
    verdicts = []
    for share in (0.2, 0.97, 1.03):
        r = random_request(seed, share * least)
        design = sos.design_pid(r.plant, r.U, requirements=r.requirements)
        verdicts.append(design.status)
        assert design.status != "undecided", (share, design.reason)
    assert (verdicts[0], verdicts[2]) == ("infeasible", "feasible")


@pytest.mark.parametrize("seed", range(0, 20, 3))
def test_a_part_excludes_nothing_that_is_possible(seed):
    r = random_request(seed)
    least = least_input(r)
    if least is None:
        pytest.skip("no figure to compare with")
    for share in (1.0001, 5):
        easy = random_request(seed, share * max(least, 1e-6))
        assert refuse_by_input(easy, search) is None


@pytest.mark.slow
@pytest.mark.parametrize("more", [dict(gamma=5.0), *campaign([{}])])
def test_several_plants_and_more_requirements(more):
    plants = sos.Polytope([one_mass(1, 0, -2, 1), one_mass(1, 0, -2, 5)])
    plants = sos.Polytope(
        [sos.SecondOrderSystem(v.M, v.D, v.S, v.B, F=[[1.0]]) for v in plants.vertices]
    )
    bound = sos.Saturation(1.9, [1, 0])
    for coupling in ("pairs", "vertices", "slack"):
        design = sos.design_pid(plants, saturation=bound, coupling=coupling, **more)
        assert design.status == "infeasible", design.reason
        assert design.infeasibility.verify()


def test_what_the_proof_does_not_cover_stays_without_it():
    plant = one_mass(1, 0, -2, 1)
    whole = sos.Saturation(1.0, [1, 0], acceleration=True)
    assert refuse_by_input(Request(plant, saturation=whole), search) is None
    given = Request(plant, saturation=sos.Saturation(1.0, [1, 0]), gain=[[-4, -1]])
    assert refuse_by_input(given, search) is None
    free = Request(plant, region=sos.PoleRegion(sigma=1))
    assert refuse_by_input(free, search) is None


def test_the_file_says_which_modes():
    design = sos.design_pid(one_mass(1, 0, -2, 1), saturation=sos.Saturation(1, [1, 0]))
    proof = design.infeasibility
    assert isinstance(proof, SmallInputRefusal) and proof.place == 0
    assert proof.modes == pytest.approx([np.sqrt(2)])
    assert "1.414 rad/s" in design.reason
    again = proof.data
    assert again["vertex"] == 0 and len(again["spread"]) == 1


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("seed", seeds(3))
def test_vertices_near_a_box_are_refused_in_a_text(seed):
    asked = Request(levers(seed, unit=0.3), saturation=sos.Saturation(1e-3, HERE))
    proof = refuse_by_input(asked, search)
    assert asked.ground.near is not None and proof.proven
    assert verdict.check(proof.text) == list(proof.claims)


def moved(seed, share):
    """A chain of masses that falls, and an input bound below what a mode needs."""
    rng = np.random.default_rng([seed, 7])
    n = int(rng.integers(2, 5))
    springs = np.diff(np.eye(n + 1), axis=0)[:, 1:]
    S = springs.T * rng.uniform(0.5, 2, n) @ springs - rng.uniform(1, 3) * np.eye(n)
    M, D = np.diag(rng.uniform(0.5, 2, n)), 0.05 * np.diag(rng.uniform(0.5, 2, n))
    plant = sos.SecondOrderSystem(M, D, S, rng.normal(size=(n, n - 1)))
    sigma, x0 = 0.4, rng.normal(size=2 * n)
    A, B, _ = descriptors(plant)[0].state_space()
    modes, rows = np.linalg.eig(A.T)
    reach = np.maximum(modes.real + sigma, 0) * np.abs(rows.T @ x0)
    need = max(reach / np.linalg.norm(rows.T @ B, axis=1))
    bound = sos.Saturation(share * need, x0)
    return plant, {"region": sos.PoleRegion(sigma), "saturation": bound}


@settings(max_examples=examples(2, 6), deadline=None, derandomize=True, database=None)
@example(0, (8.0, -8.0, 0.0, 0.0, 0.0))  # rows of E T that differ by 1e16
@example(11, ODD_POWERS)
@given(st.integers(0, 10**6), st.tuples(*5 * [st.floats(-9, 9)]))
def test_no_units_hide_the_mode_that_asks_for_most(seed, powers):
    plant, asked = moved(seed, 0.99)
    there = as_units(plant, powers, 0)
    here = refuse_by_input(Request(plant, **asked), search)
    request = Request(there.plant(plant), **there.requirements(asked))
    other = refuse_by_input(request, search)
    assert here.proven and other.proven
    mine, theirs = (
        np.sort_complex(np.round(x, 6)) for x in (here.modes, other.modes * there.w0)
    )
    assert theirs == pytest.approx(mine, abs=1e-5)


def test_one_unstable_mode_of_a_large_plant_is_refused_before_a_search():
    """The force that just holds one unstable mode, among 20 others, is known."""
    n, a = 21, 0.5
    S, D, B = np.diag(np.linspace(1, 9.81, n) ** 2), 0.1 * np.eye(n), np.ones((n, 1))
    S[0, 0] = -a * (a + D[0, 0])  # z'' + .1 z' - .3 z: a pole at .5
    x0 = np.eye(2 * n)[0]
    # of its left vector (a + .1, 1): (a + .1) a is the force that only just holds it
    needed = a * (a + D[0, 0])
    plant = sos.SecondOrderSystem(np.eye(n), D, S, B)
    d = sos.design_pid(plant, saturation=sos.Saturation(0.99 * needed, x0))
    assert d.status == "infeasible" and isinstance(d.infeasibility, SmallInputRefusal)
    assert d.infeasibility.modes.real == pytest.approx([a]) and "0.5" in d.reason
    request = Request(plant, requirements=[sos.Saturation(1.01 * needed, x0)])
    assert refuse_by_input(request, search) is None
