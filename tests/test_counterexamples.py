"""Both vertices pass, a plant between them is unstable, pairs refuse."""

from dataclasses import replace

import numpy as np

import sosbook as sos
from sosbook import counterexamples, theorems
from sosbook.descriptor import Coupled, Descriptor
from sosbook.lmi.certificate import exact, pivots
from sosbook.request import Request
from tests.test_certificate import positive_definite


def test_rotation():
    (first, second), P = counterexamples.rotation()
    Y = np.zeros((1, 2))
    for v in (first, second):
        g = theorems.stability(Coupled(v, v, P, Y))
        assert np.allclose(g, 0.2 * np.eye(2))
    halfway = Descriptor(*(
        (x + y) / 2
        for x, y in zip(vars(first).values(), vars(second).values())))
    poles = np.linalg.eigvals(np.linalg.solve(halfway.E, halfway.A))
    assert np.allclose(poles, [4.9 + 5j, 4.9 - 5j])
    pair = theorems.stability(Coupled(first, second, P, Y))
    assert np.linalg.eigvalsh(pair)[0] < 0


def test_mechanical_vertices_hold_exactly():
    plants, P = counterexamples.mechanical()
    request = Request(plants, coupling="vertices", gain=np.zeros((1, 4)))
    P, Y = exact(P), exact(np.zeros((1, 4)))
    blocks = request.blocks(P, Y, None, exact)
    assert set(blocks) == {"P", "stability 1", "stability 2"}
    assert all(positive_definite(g) for g in blocks.values())
    whole = replace(request, coupling="pairs").blocks(P, Y, None, exact)
    assert pivots(whole["stability 1,2"])[-1] < 0


def test_mechanical_masses_are_positive_and_the_middle_is_unstable():
    plants, _ = counterexamples.mechanical()
    for v in plants.vertices:
        assert np.linalg.eigvalsh(v.M)[0] > 0
        assert v.poles().real.max() < 0
    assert np.isclose(plants.mean.poles().real.max(), 3.91, atol=0.005)


def test_mechanical_verdicts():
    plants, _ = counterexamples.mechanical()
    K = np.zeros((1, 4))
    vertices = sos.analyse_pid(plants, K, coupling="vertices")
    pairs = sos.analyse_pid(plants, K, coupling="pairs")
    assert vertices.certify().proven
    assert "not the plants between" in vertices.certify().claims[0]
    assert pairs.status == "infeasible"
