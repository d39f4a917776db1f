"""What multipliers exclude for every controller: against Riccati equations."""

import numpy as np
import pytest

import sosbook as sos
from sosbook.exact.rational import exact
from sosbook.synthesis.structured.any_order import best_excluded, unseen_motions

from .test_structured_search import best_of_any_order


def plant(seed, time=1.0):
    """A plant of three states, one input, a force and noise; time in other units."""
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(3, 3)) / time
    B, b = (rng.normal(size=(3, 1)) / time for _ in range(2))
    c = rng.normal(size=(1, 3))
    parts = (A, B, np.hstack([b, 0 * b]), np.vstack([c, 0 * c]))
    A, B, Bw, C = (x.round(6) for x in parts)
    C_y = rng.normal(size=(1, 3)).round(2)
    return sos.DescriptorSystem(np.eye(3), A, B, Bw, C, [[0], [0.3]]), C_y


def bound(known, law, reached):
    """The largest norm that is excluded below ``reached``, and its refusal."""
    zero = np.zeros(law.structure(known).shape)
    request = sos.analyse_pid(known, zero, law=law, gamma=1.0).request
    return best_excluded(request, request.owner("gamma"), reached)


@pytest.mark.parametrize("time", [1.0, 0.3e-3, 9.81])
@pytest.mark.parametrize("seed", range(4))
def test_with_noise_and_weight_the_best_of_all_is_met(seed, time):
    """Unstable ones among them, by the two Riccati equations."""
    known, C_y = plant(seed, time)
    (d,) = known.vertices
    best = best_of_any_order(d, C_y, 0.3, 0.5)
    law = sos.DynamicLaw(1, C_y, noise=[[0, 0.5]])
    gamma, proof = bound(known, law, 1.5 * best)
    assert 0.98 * best < gamma < best and proof.verify()


@pytest.mark.parametrize("seed", [0, 1, 2, 3, 4, 8])
def test_without_noise_no_more_is_excluded_than_little_noise_allows(seed):
    """Noise can only make the norm larger: less and less of it comes down to it.

    Where both inequalities matter and motions that aren't seen partly decay (2 and 8)
    the multipliers aren't rational, and what is excluded is far below.
    """
    known, C_y = plant(seed)
    little = best_of_any_order(known.vertices[0], C_y, 0.3, 1e-3)
    gamma, proof = bound(known, sos.DynamicLaw(1, C_y), 1.5 * little)
    near = 0.2 if seed in (2, 8) else 0.98
    assert near * little < gamma < little and proof.verify()


def test_free_masses_have_a_bound():
    """Undamped, so multipliers of both sides together aren't rational."""
    A = np.array([[0, 1, 0, 0], [-1, 0, 1, 0], [0, 0, 0, 1], [1, 0, -1, 0]])
    one = np.eye(4)
    C, D = np.vstack([one, np.zeros((1, 4))]), [[0], [0], [0], [0], [1]]
    known = sos.DescriptorSystem(one, A, one[:, 1:2], one[:, 3:], C, D)
    gamma, proof = bound(known, sos.DynamicLaw(1, one[2:3], noise=[[1]]), 5.0)
    assert 2.1 < gamma < 5**0.5 and proof.verify()  # a law of order 4 has 2.281


def test_motions_that_sensors_do_not_see_are_the_largest_subspace():
    """A chain of springs, pushed at its end and seen at its start: nothing hides.

    Seen at the end that is pushed the other masses move as if it stood still.
    """
    S = 2 * np.eye(3) - np.eye(3, k=1) - np.eye(3, k=-1)
    A = exact(np.block([[np.zeros((3, 3)), np.eye(3)], [-S, -0.1 * np.eye(3)]]))
    B = exact(np.eye(6)[:, 5:])
    none = exact(np.zeros((1, 1)))
    far, near = (exact(np.eye(6)[k : k + 1]) for k in (0, 2))
    V, here, rate, push = unseen_motions(A, B, far, none)
    assert V.shape == (6, 0) and push.shape == (1, 0)
    V, here, rate, push = unseen_motions(A, B, near, none)
    assert V.shape == (6, 4) and here.shape == rate.shape == (4, 4)
    assert (near @ V == 0).all() and (A @ V @ here + B @ push == V @ rate).all()
    free = np.linalg.eigvals(rate.astype(float) @ np.linalg.inv(here.astype(float)))
    two = np.block([[np.zeros((2, 2)), np.eye(2)], [-S[:2, :2], -0.1 * np.eye(2)]])
    assert np.allclose(np.poly(free), np.poly(two))


def test_what_is_sought_has_no_bound_that_is_refused():
    """A free cart that a law of order one can't hold: the least norm isn't below 1."""
    one = np.eye(2)
    cart = sos.DescriptorSystem(one, [[0, 1], [0, 0]], one[:, 1:], one, one)
    law = sos.DynamicLaw(1, [[0, 1]])  # its place isn't seen
    for asked in (dict(minimize="gamma"), dict(maximize="sigma")):
        design = sos.design_pid(cart, law=law, **asked, starts=2)
        assert design.status == "undecided", design.reason
