"""What each reading of the vertices proves, and what is true inside."""

import numpy as np
import pytest

import sosbook as sos
from sosbook.analysis.linear import poles
from sosbook.book import counterexamples, thesis
from sosbook.book.reproduction import vertices
from sosbook.plants.descriptor import descriptors
from sosbook.studies import polytopes
from tests.cases import campaign


def single(mass, stiffness=1.0):
    return sos.SecondOrderSystem([[mass]], [[1]], [[stiffness]], [[1]])


def test_pairs_and_slack_do_not_contain_each_other():
    region = sos.PoleRegion(rho=3.5)
    plants = counterexamples.random_pair(3, ratio=9)
    assert sos.design_pid(plants, region=region).certify().proven
    for slack in (0.05, 0.5):
        refused = sos.design_pid(plants, region=region, coupling=("slack", slack))
        assert refused.status == "infeasible"
        assert refused.infeasibility.proven


@pytest.mark.parametrize("example", [2, 4])
def test_vertices_suffice_for_the_examples_of_the_thesis(example):
    ex = getattr(thesis, f"example_{example}")()
    assert polytopes.hull_gap(ex.plant, ex.U) < 1e-9


@pytest.mark.parametrize(
    "plants, suffices",
    [
        (counterexamples.random_chain(0), True),
        (counterexamples.random_chain(3, masses=3), True),
        (counterexamples.random_chain(0, box=False), False),
        (counterexamples.actuated(), False),
        (counterexamples.slower_corners(), False),
        (sos.Polytope([single(1), single(4, 7.0)]), True),
    ],
)
def test_hull_gap(plants, suffices):
    assert (polytopes.hull_gap(plants) < 1e-9) == suffices


def test_hull_gap_sees_a_disturbance_that_leaves_the_hull():
    def plant(masses, F):
        return sos.SecondOrderSystem(
            np.diag(masses), np.eye(2), np.eye(2), np.eye(2), F
        )

    same, other = np.ones((2, 1)), np.array([[5.0], [-3.0]])
    fixed = [plant([1, 2], same), plant([1, 2], other)]
    assert polytopes.hull_gap(sos.Polytope(fixed)) < 1e-9
    moving = [plant([1, 2], same), plant([3, 2], same)]
    assert polytopes.hull_gap(sos.Polytope(moving)) < 1e-9
    twisted = [plant([1, 2], same), plant([3, 1], other)]
    assert polytopes.hull_gap(sos.Polytope(twisted)) > 1e-3


@pytest.mark.parametrize(
    "count, blocks", [(1, (1, 1, 1)), (2, (2, 3, 2)), (8, (8, 36, 8))]
)
def test_a_coupling_has_so_many_blocks(count, blocks):
    masses = [np.diag([1.0 + k, 1.0 + k**2]) for k in range(count)]
    one = np.eye(2)
    plants = sos.Polytope([sos.SecondOrderSystem(M, one, one, one) for M in masses])
    for name, number in zip(polytopes.COUPLINGS, blocks):
        design = sos.design_pid(
            plants, coupling=("slack", 0.1) if name == "slack" else name
        )
        made = [x for x in design.margins if x.startswith("stability")]
        assert len(made) == number


def test_widen():
    plants = counterexamples.actuated()
    same = polytopes.scale_polytope(plants, 1)
    for v, w in zip(plants.vertices, same.vertices):
        for x in "MDSBF":
            assert np.allclose(getattr(v, x), getattr(w, x))
    none = polytopes.scale_polytope(plants, 0)
    assert np.allclose(none.vertices[0].S, none.vertices[1].S)
    half = polytopes.scale_polytope(plants, 0.5)
    assert np.allclose(half.mean.D, plants.mean.D)
    assert np.allclose(half.vertices[0].M, np.diag([1.4, 0.6]))


def test_inside_walks_all_edges():
    box = counterexamples.random_chain(1)
    plants = polytopes.sample_plants(box, 5)
    assert len(plants) == 6 * 5 + 5
    pair = polytopes.sample_plants(counterexamples.actuated(), 3)
    assert [p.M[0, 0] for p in pair] == pytest.approx([1.8, 1.0, 0.2])
    assert polytopes.sample_plants(sos.Polytope([single(2)])) != []


def test_promises_are_those_of_the_worst_plant():
    chain = counterexamples.random_chain(2, spread=0.5)
    limit = sos.Saturation(20, [1, 0, 0, 0])
    design = sos.design_pid(
        chain, gamma=1.5, saturation=limit, region=sos.PoleRegion(sigma=0.3)
    )
    kept = polytopes.verify_on_samples(design, 5)
    assert set(kept) == {"poles", "gamma", "u_max"}
    assert all(value > 0 for value in kept.values())
    worst = [
        (d, poles(d, design.K).real.max())
        for v in polytopes.sample_plants(chain, 5)
        for d in descriptors(v)
    ]
    assert kept["poles"] == pytest.approx(-0.3 - max(rate for _, rate in worst))
    assert kept["u_max"] <= limit.u_max - design.peak_input() + 1e-9
    assert kept["gamma"] <= 1.5 - design.hinf() + 1e-9


def test_promises_want_a_gain():
    asked = dict(region=sos.PoleRegion(rho=10), coupling="pairs")
    refused = sos.design_pid(counterexamples.actuated(), **asked)
    with pytest.raises(ValueError, match="nothing to keep"):
        polytopes.verify_on_samples(refused)


def test_survey_counts_what_pairs_and_slack_never_do():
    plants = [
        polytopes.scale_polytope(counterexamples.random_pair(k, 9), 1) for k in (9,)
    ]
    kinds = "vertices", "pairs", ("slack", 0.1)
    found = polytopes.verify_many(
        plants, kinds, region=sos.PoleRegion(theta=np.pi / 6, rho=6)
    )
    assert (found["vertices"] < 0).all()
    for name in ("pairs", "slack"):
        assert not (found[name] <= 0).any()


@pytest.mark.campaign  # chapter 09 shows these rows
def test_rows_on_the_vertices():
    verdicts = [row.verdict for row in vertices.rows()]
    assert verdicts == [*5 * ["claim refuted"], *2 * ["property holds"]]


def test_what_is_no_polytope_or_no_name_is_named():
    one = sos.SecondOrderSystem(1, 1, 1, 1, 1)
    pair = sos.Polytope([one, sos.SecondOrderSystem(2, 1, 1, 1, 1)])
    for ask in (
        lambda x: polytopes.scale_polytope(x, 0.5),
        polytopes.sample_plants,
        polytopes.hull_gap,
        lambda x: polytopes.verify_many([x]),
    ):
        for wrong in (one, None, [one], 1.0, np.eye(2)):
            with pytest.raises(ValueError, match="plants must be a Polytope, got"):
                ask(wrong)
    design = sos.design_pid(pair)
    for wrong in (None, pair, 1.0):
        with pytest.raises(ValueError, match="design must be a Design"):
            polytopes.verify_on_samples(wrong)
    with pytest.raises(ValueError, match="plants must be a Polytope"):
        polytopes.verify_on_samples(sos.design_pid(one))
    for wrong in (None, 1, 0, -1, 2.5, "3", 1j):
        for ask in (polytopes.sample_plants, polytopes.hull_gap):
            with pytest.raises(ValueError, match="count must be 2, 3"):
                ask(pair, count=wrong)
        with pytest.raises(ValueError, match="count must be 2, 3"):
            polytopes.verify_on_samples(design, count=wrong)
    with pytest.raises(ValueError, match="factor"):
        polytopes.scale_polytope(pair, np.nan)
    for wrong in (None, 3, "pairs", ["edges"], [["pairs"]], [np.array([1, 2])]):
        with pytest.raises(ValueError, match="coupling"):
            polytopes.compare(pair, wrong)


@pytest.mark.parametrize("seed", [0, *campaign([1, 2])])
def test_a_polytope_of_first_order_is_one_too(seed):
    """Each study says of it what it says of the same plants in second order."""
    plants = counterexamples.random_chain(seed)
    parts = descriptors(plants)
    system = sos.DescriptorSystem(
        *([getattr(d, x) for d in parts] for x in ("E", "A", "Bu", "Bw")), C=parts[0].C
    )
    assert polytopes.vertices_suffice(system) == polytopes.vertices_suffice(plants)
    assert polytopes.hull_gap(system) == pytest.approx(
        polytopes.hull_gap(plants), abs=1e-9
    )
    kept = polytopes.verify_many([system], region=sos.PoleRegion(rho=20))
    assert kept["pairs"] > 0 and kept["slack"] > 0
    with pytest.raises(ValueError, match="plants must be a Polytope, got Descriptor"):
        polytopes.scale_polytope(system, 0.5)
