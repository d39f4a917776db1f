"""Families by columns and rows: a base, and multiples of u w' that join it."""

import numpy as np
import pytest

import sosbook as sos
from sosbook.studies import polytopes

LEVERS = (np.array([1, 0.7]), np.array([-0.3, 1]))


def cart():
    return sos.SecondOrderSystem(
        np.diag([1.3, 2]), [[0.2, 0.1], [0, 0.3]], [[3, -1], [-1, 2]], [[1], [0]]
    )


def row(n, wide, **parts):
    """A row of [M D S B F] whose entries from a place on are given."""
    w = np.zeros(wide)
    for place, values in parts.items():
        k = n * "MDSB".index(place)
        w[k : k + len(values)] = values
    return w


def test_levers_are_masses_of_one_column_each():
    arms = {f"m{k}": (0, 1 / 3, [(j, row(2, 7, M=j))]) for k, j in enumerate(LEVERS)}
    plants = sos.Uncertain.of(cart(), **arms)
    for given in ({"m0": 0.1, "m1": 0.2}, {"m0": 0.3, "m1": 0}):
        M = cart().M + sum(
            given[f"m{k}"] * np.outer(j, j) for k, j in enumerate(LEVERS)
        )
        assert np.allclose(plants.at(**given).M, M, rtol=1e-15)
    assert plants.multi_affine and len(plants.vertices) == 4
    assert polytopes.vertices_suffice(plants)
    design = sos.design_pid(plants, region=sos.PoleRegion(sigma=0.1))
    assert design.status == "feasible" and design.certify().proven
    assert len(design.request.pairs) == 4


def test_it_is_the_family_that_a_builder_makes():
    def builder(k):
        base = cart()
        S = base.S + k * np.array([[1, -1], [-1, 1]])
        return sos.SecondOrderSystem(base.M, base.D + 0.1 * k * np.eye(2), S, base.B)

    u = np.array([1, -1])
    pairs = [(u, row(2, 7, S=u))]
    pairs += [(e, row(2, 7, D=0.1 * e)) for e in np.eye(2)]
    plants = sos.Uncertain.of(cart(), k=(0, 2, pairs))
    assert plants == sos.Uncertain(builder, k=(0, 2))


def test_a_plant_keeps_its_coordinates():
    named = sos.SecondOrderSystem(1, 0, 0, 1, coordinates=("phi",))
    plants = sos.Uncertain.of(named, k=(0, 1, [([1], [0, 0, 1, 0])]))
    assert plants.polytope().coordinates == ("phi",) == plants.nominal.coordinates


def test_a_plant_of_first_order_keeps_its_outputs():
    base = sos.DescriptorSystem(
        np.eye(2), [[0, 1], [-2, -1]], [[0], [1]], None, [[1, 0]]
    )
    plants = sos.Uncertain.of(base, k=(0, 1, [([0, 1], [0, 0, -1, 0, 0])]))
    assert plants.at(k=0.5).vertices[0].A.tolist() == [[0, 1], [-2.5, -1]]
    assert plants.nominal.vertices[0].C.tolist() == [[1, 0]]


@pytest.mark.parametrize(
    "given, words",
    [
        ((0, 1), r"m must be \(low, high"),
        ((0, 1, [([1], [1])]), "a u with 2 entries and a w with 7"),
        ((0, 1, []), "m needs pairs"),
        ((1, 0, [([1, 0], [0] * 6 + [1])]), "the range of m is empty"),
        ((0, 1, [([1, "x"], [0] * 7)]), "m must be"),
    ],
)
def test_what_is_no_change_is_named(given, words):
    with pytest.raises(ValueError, match=words):
        sos.Uncertain.of(cart(), m=given)


def test_the_base_is_one_plant():
    with pytest.raises(ValueError, match="base must be one"):
        sos.Uncertain.of(sos.Polytope([cart(), cart()]), m=(0, 1, []))
