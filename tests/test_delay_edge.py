"""Close to the edge of feasibility: answers, proofs, and what gave up."""

import pickle
import sys
from fractions import Fraction

import numpy as np
import pytest

import sosbook as sos
from sosbook.book import thesis
from sosbook.delay import DelayedLoop, DelayRequest, analyse_delay, largest, solve_delay
from sosbook.exact.checker import verdict
from sosbook.lmi import Unknown, block, he
from sosbook.pendulum import Mip, polytope
from sosbook.solver.blocks import Blocks
from sosbook.solver.deepest import deepest
from tests.cases import campaign, later

PUBLISHED = thesis.delay_example_1(published=True)
PRINTED = thesis.delay_example_1()
SCALAR = DelayedLoop([[0]], [[-1]])


def wing(example, delta, method="functional", **changes):
    asked = dict(U=example.U, tau=0.2, mu=0.1, alpha=0.6, method=method)
    return sos.design_delay_pid(example.plant, delta=delta, **asked | changes)


@pytest.mark.parametrize(
    "example, delta, changes",
    [
        (PUBLISHED, 0.115, {}),
        (PRINTED, 0.30, {}),
        (PUBLISHED, 0.15, dict(method="shift", alpha=0.8)),
        *later((PUBLISHED, 0.11, {}), (PUBLISHED, 0.14, dict(method="shift"))),
    ],
    ids=["narrow", "printed", "wider alpha", "published", "shift"],
)
def test_a_wing_close_to_its_edge_is_designed_proven_and_analysed(
    example, delta, changes
):
    made = wing(example, delta, **changes)
    assert made.status == "feasible"
    assert min(made.margins.values()) > 0
    blocks = made.request.blocks(made.values)
    assert all(np.linalg.eigvalsh(g)[0] > 0 for g in blocks.values())
    certificate = made.certify(8)
    assert certificate.proven
    again = analyse_delay(
        example.plant,
        certificate.K,
        example.U,
        0.2,
        0.1,
        delta,
        method=changes.get("method", "functional"),
    )
    assert again.status == "feasible"
    assert again.certify(8).proven


@pytest.mark.parametrize(
    "example, delta, changes",
    [
        (PUBLISHED, 0.12, {}),
        (PUBLISHED, 0.16, dict(method="shift", alpha=0.8)),
        *later((PRINTED, 0.31, {}), (PUBLISHED, 0.6, {}), (PRINTED, 0.6, {})),
    ],
    ids=["published", "shift", "printed", "promise", "printed promise"],
)
def test_a_wing_beyond_its_edge_is_refuted_by_its_slowest_mode(example, delta, changes):
    refused = wing(example, delta, **changes)
    assert refused.status == "infeasible"
    assert refused.infeasibility.proven
    slowest = max(example.plant.poles(), key=lambda s: s.real)
    assert f"{slowest.real:.4g}" in refused.infeasibility.part
    back = pickle.loads(pickle.dumps(refused.infeasibility))  # as another process does
    assert back.verify() and back.part == refused.infeasibility.part


@pytest.mark.slow
@pytest.mark.campaign  # in the gate chapter 17 prints the first and the third of them
@pytest.mark.parametrize(
    "example, start, changes, value",
    [
        (PRINTED, 0.3, {}, 0.30),
        (PUBLISHED, 0.1, dict(method="shift", alpha=0.8), 0.15),
        (PUBLISHED, 0.1, {}, 0.11),
        (PUBLISHED, 0.1, dict(method="shift"), 0.14),
    ],
    ids=["printed", "wider alpha", "published", "shift"],
)
def test_largest_finds_the_edge_and_proves_it(example, start, changes, value):
    asked = dict(U=example.U, tau=0.2, mu=0.1, delta=start, alpha=0.6) | changes
    found = largest("delta", example.plant, **asked)
    assert found.value == value
    assert found.proven
    assert "is proven to have none" in repr(found)


@pytest.mark.parametrize(
    "method, bad", [("functional", "rounded"), ("shift", "factor")]
)
@pytest.mark.parametrize("k, off", [(0, 2), (1, 0.5)])
def test_an_exponential_on_the_wrong_side_is_refused(method, bad, k, off):
    proof = analyse_delay(SCALAR, tau=1.0, delta=0.1, method=method).certify()
    asked = {"kind": proof.kind, **proof.data}
    assert verdict.text_of(asked)[1] == list(proof.claims)
    given = list(asked["exponentials"])
    given[k] = str(Fraction(given[k]) * (Fraction(off) if method == "shift" else 2))
    with pytest.raises(verdict.Refused, match=bad):
        verdict.text_of(asked | {"exponentials": given})


@pytest.mark.parametrize("method", ["functional", *campaign(["shift"])])
def test_one_vertex_alone_refuses_a_family(method):
    """The multipliers of the other loops are zero, and the checker decides the file."""
    family = polytope(Mip.printed(), 0.04)
    K, asked = [[20.58, 0.84, 1.97, 0.9, 0.41]], dict(tau=0.015, mu=0.015, delta=0.2)
    found = analyse_delay(family, K, [[0, 1]], **asked, method=method)
    assert found.status == "infeasible" and found.infeasibility.proven
    used = [name for name, z in found.infeasibility.multipliers.items() if z.any()]
    assert sum(name.startswith("decay") for name in used) == 1


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, *campaign([1, 2, 3])])
def test_infeasible_is_always_proven_and_never_wrong(seed):
    """Along the rate: feasible, then not; what is infeasible is proven."""
    rng = np.random.default_rng(seed)
    n = 1 + seed % 2
    M = np.eye(n) + 0.2 * np.ones((n, n))
    plant = sos.SecondOrderSystem(
        M, 0.2 * np.eye(n), np.diag(1 + rng.random(n)), np.ones((n, 1))
    )
    U = np.eye(n)[:1]
    asked = dict(U=U, tau=0.2, mu=0.1, alpha=0.4)
    made = sos.design_delay_pid(plant, delta=0.1, **asked)
    assert made.status == "feasible"
    K = made.certify(6).K
    seen = []
    for delta in (0.02, 0.5, 1.0, 4.0):
        both = (
            sos.design_delay_pid(plant, delta=delta, **asked),
            analyse_delay(plant, K, U, 0.2, 0.1, delta),
        )
        for found in both:
            if found.status == "infeasible":
                assert found.infeasibility.proven
            elif found.status == "undecided":
                assert found.reason
            else:
                assert found.certify(8).proven
        seen.append([found.status == "feasible" for found in both])
    for column in np.array(seen).T:  # no gap
        assert (np.diff(column.astype(int)) <= 0).all()


@pytest.mark.slow
def test_infeasible_rates_of_a_polytope_stay_infeasible():
    """What is refuted at a rate isn't "undecided" at twice the rate."""
    plants = sos.Polytope(
        [sos.SecondOrderSystem([[m]], [[0.1]], [[1.0]], [[1.0]]) for m in (1.0, 1.3)]
    )
    K = sos.design_delay_pid(plants, [[1.0]], 0.1, 0.1, 0.05, alpha=0.4).K
    verdicts = [
        analyse_delay(plants, K, [[1.0]], 0.1, 0.1, delta).status
        for delta in (0.01, 0.2, 1.6, 3.2)
    ]
    order = {"feasible": 0, "undecided": 1, "infeasible": 2}
    ranks = [order[v] for v in verdicts]
    assert ranks == sorted(ranks)
    assert verdicts[0] == "feasible"
    assert verdicts[-1] == "infeasible"


@pytest.mark.parametrize("published, rate", [(False, 0.61), *later((True, 0.71))])
def test_without_its_modes_a_wing_is_undecided(published, rate, monkeypatch):
    """As chapter 17 says; Theorem 2.3 has no regular multipliers there."""
    wing = thesis.delay_example_1(published)
    asked = wing.plant, wing.U, 0.2, 0.0, rate
    found = sos.design_delay_pid(*asked, alpha=0.6)
    assert found.infeasibility.kind == "infeasible delay modes"
    monkeypatch.setattr("sosbook.delay.refusal._by_modes", lambda request: None)
    assert sos.design_delay_pid(*asked, alpha=0.6).status == "undecided"


def test_largest_tells_what_is_proven_from_what_gave_up():
    proven = largest("tau", SCALAR, tau=1)
    assert proven.proven
    assert proven.refused.infeasibility.proven
    assert repr(proven).endswith(f"{proven.beyond} is proven to have none>")

    hasty = largest("tau", SCALAR, tau=1, time_limit=1e-6)
    assert not hasty.proven
    assert hasty.refused.status == "undecided"
    assert "gave up at" in repr(hasty)
    assert "stopped after 1e-06 s" in repr(hasty)


def test_a_search_over_alpha_excludes_nothing():
    plant = sos.SecondOrderSystem([[1.0]], [[0.1]], [[-1.0]], [[1.0]])
    found = sos.design_delay_pid(plant, [[1.0]], tau=0.2, mu=0.1, delta=4.0)
    assert found.status == "undecided"
    assert "other values of alpha aren't excluded" in found.reason


def test_the_deepest_ray_of_a_narrow_cone():
    """[[x, e y], [e y, x]] > 0, y > x: narrow as e nears 1."""
    x, y = Unknown("x", 1), Unknown("y", 1)
    for e, room in ((0.5, True), (1 - 1e-9, True), (1.0, False), (2.0, False)):
        cone = [block([[x, e * y], [e * y, x]]), y - x]
        found = deepest(Blocks(cone, [x, y]))
        assert (found.depth > 0) == room
        assert found.gap < max(found.depth, 1e-12)


@pytest.mark.last_digits
def test_a_cone_without_inside_is_left_as_soon_as_multipliers_exclude_it():
    """A P + P A' < 0 and P > 0, where every mode of A grows."""
    P, steps = Unknown("P", 3, symmetric=True), []
    A = np.array([[0, 1, 0], [0, 0, 1], [1, -2, 1]])
    found = deepest(blocks := Blocks([P, -he(A @ P)], [P]), watch=steps.append)
    assert found.depth == found.gap == 0 and not found.x.any()
    assert min(np.linalg.eigvalsh(z)[0] for z in found.Z) > 1e-6
    assert np.abs(blocks.adjoint(found.Z)).max() < 1e-13
    assert steps[-1]["gap"] > 1e-5  # the depth itself isn't known that well


def test_the_deepest_ray_needs_a_cone():
    x = Unknown("x", 1)
    with pytest.raises(ValueError, match="homogeneous"):
        deepest(Blocks([x - np.ones((1, 1))], [x]))


def test_states_that_nothing_drives_decide_alone():
    loop = DelayedLoop([[-2, 0], [0, -0.9]], [[-1, 0], [-1, -1]])
    for method in ("functional", "shift", "legendre"):
        found = solve_delay(DelayRequest(loop, tau=6.3, method=method))
        assert found.status == "infeasible"
        assert found.infeasibility.part == "the states 2 alone"


def test_a_bar_shows_the_seconds(monkeypatch):
    """Whole seconds, at the Newton steps; none without being asked."""
    from sosbook.runtime import time_limit as module

    moved, totals, now = [], [], iter(np.arange(0.0, 1e6, 0.7))

    class Bar:
        def __enter__(self):
            return self

        def __exit__(self, *error):
            return None

        def update(self, count):
            moved.append(count)

    def bar(total, unit, progress):
        totals.append((total, unit, progress))
        return Bar()

    monkeypatch.setattr(module, "bar", bar)
    monkeypatch.setattr(module, "monotonic", lambda: next(now))
    analyse_delay(SCALAR, tau=1.0, time_limit=1e5)
    assert not moved and totals == [(100000, "s", False)]
    found = analyse_delay(SCALAR, tau=1.0, time_limit=1e5, progress=True)
    assert found.status == "feasible" and totals[-1] == (100000, "s", True)
    assert sum(moved) > 3 and set(moved) <= {1, 2}


def test_a_value_alone_asks_for_no_centre(monkeypatch):
    """A seventh of a search that is read for its number."""

    def never(*_):
        raise AssertionError("a centre is looked for")

    with monkeypatch.context() as patched:
        search = sys.modules["sosbook.delay.largest"]
        patched.setattr(search, "centred_design", never)
        found = largest("tau", SCALAR, tau=1, refuse=False)
        assert found.found.status == "feasible" and str(found.value) in repr(found)
    copy = pickle.loads(pickle.dumps(found))
    for each in (found, copy):
        assert each.design is each.design and each.design.certify().proven
        assert each.design.request.tau == found.value
    assert sos.delay.Largest("tau", beyond=0.1, refused=found.refused).design is None


def test_the_largest_value_comes_with_the_centre():
    """The search stops at any point inside; the answer is the centre."""
    loop = DelayedLoop([[-2, 0], [0, -0.9]], [[-1, 0], [-1, -1]])
    found = largest("tau", loop, tau=4, method="legendre", order=0, refuse=False)
    wanted = solve_delay(found.design.request)
    for name, margin in wanted.margins.items():
        assert found.design.margins[name] == pytest.approx(margin, rel=1e-3)


def test_the_lmis_are_not_asked_what_the_roots_answer(monkeypatch):
    """Beyond the true limit, 6.1726 s, only the end of the search is solved."""
    search, taus = sys.modules["sosbook.delay.largest"], []
    solved = search.first_design

    def first_design(request, **more):
        taus.append(request.tau)
        return solved(request, **more)

    monkeypatch.setattr(search, "first_design", first_design)
    loop = DelayedLoop([[-2, 0], [0, -0.9]], [[-1, 0], [-1, -1]])
    found = largest("tau", loop, tau=4, method="legendre", order=2, refuse=False)
    assert (found.value, found.beyond) == (6.1, 6.2)
    assert found.refused.status == "undecided"
    assert [tau for tau in taus if tau > 6.1726] == [6.2]
