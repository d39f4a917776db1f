"""Bounds of each input, from several initial states: simulations that stay inside."""

import re
from itertools import product

import numpy as np
import pytest
from scipy.linalg import expm

import sosbook as sos

TRACKS = sos.SecondOrderSystem(
    np.eye(2), 0.1 * np.eye(2), [[1, -0.5], [-0.5, 1]], np.eye(2)
)
START = [0.5, 0.5, 0, 0]
BOX = sos.Saturation.box([0.5, 0.5, 0, 0])


def peaks(plant, K, starts, seconds=20.0, steps=4000):
    """The largest |u_k| of each input: by my own exponentials, from each start."""
    n = plant.n
    inverse = np.linalg.inv(plant.M)
    A = np.block(
        [[np.zeros((n, n)), np.eye(n)], [-inverse @ plant.S, -inverse @ plant.D]]
    )
    A[n:] += inverse @ plant.B @ K
    step, X, most = expm(A * seconds / steps), np.array(starts, float).T, 0.0
    for _ in range(steps):
        most = np.maximum(most, abs(K @ X).max(axis=1))
        X = step @ X
    return most


def decay(sigma, saturation):
    return sos.design_pid(TRACKS, region=sos.PoleRegion(sigma), saturation=saturation)


@pytest.mark.parametrize(
    ("saturation", "below", "above"),
    [  # a program of one's own on these LMIs has .849, .627, and .698 of the norm
        (sos.Saturation([1, 1], START), 0.845, 0.855),
        (sos.Saturation([1, 1], BOX), 0.62, 0.635),
        (sos.Saturation([1e9, 1], START), None, None),
        (sos.Saturation(1, START), 0.69, 0.705),
    ],
)
def test_limits_of_each_input_are_as_sharp_as_the_lemma(saturation, below, above):
    if below is None:  # no limit of the first input: as one bound of the second
        for sigma in (0.7, 2.0, 6.0):
            alone = decay(sigma, sos.Saturation(1, START, u=[1]))
            assert decay(sigma, saturation).status == alone.status
        return
    assert decay(above, saturation).status == "infeasible"
    design = decay(below, saturation)
    assert design.status == "feasible" and design.certify().proven
    starts = np.atleast_2d(saturation.x0)
    rng = np.random.default_rng(1)
    inside = rng.uniform(-1, 1, (40, len(starts)))
    inside /= np.maximum(abs(inside).sum(axis=1, keepdims=True), 1)
    found = peaks(TRACKS, design.K, np.vstack([starts, inside @ starts]))
    whole = [x for x in design.request.requirements if x.kind == "input"]
    if len(whole) == 1:
        assert np.linalg.norm(found) > 0.3 and found.max() <= 1
    else:
        assert (found <= [x.u_max for x in whole]).all()


def test_signs_and_the_order_of_inputs_make_no_difference():
    swap, moved = np.array([[0, 1], [1, 0.0]]), {}
    for name, plant, saturation in [
        ("as it is", TRACKS, sos.Saturation([1, 0.7], BOX)),
        ("turned", TRACKS, sos.Saturation([1, 0.7], -BOX)),
        ("swapped", sos.SecondOrderSystem(TRACKS.M, TRACKS.D, TRACKS.S, swap),
         sos.Saturation([0.7, 1], BOX)),
    ]:  # fmt: skip
        moved[name] = [
            sos.design_pid(
                plant, region=sos.PoleRegion(s), saturation=saturation
            ).status
            for s in (0.45, 0.5, 0.55, 0.6)
        ]
    assert len({tuple(x) for x in moved.values()}) == 1
    assert {"feasible", "infeasible"} == set(moved["as it is"])


@pytest.mark.parametrize("coupling", ["pairs", "slack", "multipliers"])
def test_units_odd_plants_and_three_inputs_keep_their_limits(coupling):
    rng, n = np.random.default_rng(4), 3
    stiff = rng.normal(size=(n, n))
    plant = sos.SecondOrderSystem(
        np.diag([0.3, 9.81, 2]), 0.02 * np.eye(n), stiff @ stiff.T + stiff - stiff.T,
        rng.normal(size=(n, n)),
    )  # fmt: skip
    sizes = [0.01, 0.003, 0, 0, 0.2, 0]
    starts, limits = sos.Saturation.box(sizes), [40.0, 60.0, 50.0]
    asked = dict(saturation=sos.Saturation(limits, starts, name="cap"))
    if coupling == "multipliers":
        K = sos.design_pid(plant, region=sos.PoleRegion(0.2), **asked).K
        design = sos.analyse_pid(plant, K, coupling=coupling, **asked)
    else:
        region = sos.PoleRegion(0.2)
        design = sos.design_pid(plant, region=region, coupling=coupling, **asked)
    assert design.status == "feasible"
    said = [x for x in design.certify().claims if x.startswith("cap")]
    assert len(said) == 3 and "between 4 states and their negatives" in said[0]
    corners = np.array(list(product((-1, 1), repeat=6))) * sizes
    found = peaks(plant, design.K, corners)
    assert (found <= limits).all() and found.min() > 0
    table = {r.name: r for r in design.request.requirements if r.kind == "input"}
    truths = [table[f"cap of u{k}"].truth([plant_of(plant)], design.K) for k in (1, 2)]
    assert np.allclose(truths, found[:2], rtol=1e-3)


def plant_of(plant):
    from sosbook.plants import descriptors

    return descriptors(plant)[0]


def test_a_named_limit_is_minimised_by_its_name_and_a_file_asks_for_all(tmp_path):
    least = sos.design_pid(
        TRACKS,
        region=sos.PoleRegion(0.5),
        requirements=[
            sos.Saturation(None, START, name="right", u=[1]),
            sos.Saturation(0.5, START, name="left", u=[0]),
        ],
        minimize="right",
    )
    found = peaks(TRACKS, least.K, [START])
    assert found[0] <= 0.5 and found[1] <= least.request.owner("right").bound
    from sosbook.requirements.in_files import asked_in_file

    one = asked_in_file({"saturation": {"u_max": [1, 1], "x0": BOX.tolist()}})
    design = sos.design_pid(TRACKS, region=sos.PoleRegion(0.5), **one)
    assert design.status == "feasible"
    design.certify().save(tmp_path / "two.json")
    assert sos.proofs.load(tmp_path / "two.json").verify()


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: sos.Saturation([1, -1], START), r"u_max\[1\]"),
        (lambda: sos.Saturation([], START), "u_max must be a number, or a list"),
        (lambda: sos.Saturation([1], START, u=[0]), "without u"),
        (lambda: sos.Saturation(1, START, u=[0, 0]), "u must name"),
        (lambda: sos.Saturation(1, [[[1]]]), "x0 must be a vector"),
        (lambda: sos.Saturation(1, START, name="gamma"), "that of another bound"),
        (lambda: sos.Saturation.box([0, 0]), "sizes"),
        (lambda: decay(0.3, sos.Saturation([1], START)), r"1, and the plant has 2"),
        (lambda: decay(0.3, sos.Saturation(1, START, u=[2])), "no input 2"),
    ],
)
def test_what_does_not_fit_is_said(make, words):
    with pytest.raises(ValueError, match=words) as said:
        make()
    if "u=[0]" in (cure := str(said.value)) and re.search("give a number", cure):
        assert decay(0.3, sos.Saturation(1, START, u=[0])).status == "feasible"
