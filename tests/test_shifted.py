"""From the centre of some blocks into all of them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import sosbook as sos
from benchmarks.catalogue import FAMILIES, case
from sosbook.solver.barrier import Barrier
from sosbook.solver.blocks import Blocks
from sosbook.solver.centre import centre
from sosbook.solver.newton import newton_of
from sosbook.solver.shifted import enter
from sosbook.synthesis import cutting

from .test_many_pairs import ASKED, plants


def balls(centres, radii):
    """Blocks [[r, (x - c)'], [x - c, r I]], positive definite where |x - c| < r."""
    constants, slopes = [], []
    for c, r in zip(np.atleast_2d(centres), radii):
        k = len(c)
        constants.append(r * np.eye(k + 1))
        constants[-1][0, 1:] = constants[-1][1:, 0] = -c
        slope = np.zeros((k, k + 1, k + 1))
        slope[range(k), 0, range(1, k + 1)] = 1
        slope[range(k), range(1, k + 1), 0] = 1
        slopes.append(slope)
    return Blocks(constants, slopes)


def decrement(blocks, x):
    return Barrier(newton_of(blocks)).step(x, np.zeros(len(x)))[1]


def test_a_lens_of_two_disks_is_entered_at_its_middle():
    """From the centre of one of two equal disks; by symmetry it ends on their axis."""
    blocks = balls([[0.0, 0.0], [1.2, 0.0]], [1.0, 1.0])
    x = enter(blocks, np.zeros(2))
    assert blocks.contain(x) and abs(x[1]) < 1e-12
    assert decrement(blocks, x) < 0.5
    np.testing.assert_allclose(centre(blocks, x), [0.6, 0.0], atol=1e-6)


@given(
    st.lists(st.floats(-3.0, 3.0), min_size=1, max_size=4),
    st.lists(st.floats(0.5, 2.0), min_size=4, max_size=4),
)
def test_only_what_intervals_have_in_common_is_entered(middles, radii):
    """From the middle of the first interval; what all have in common is known."""
    middles = np.array([0.0, *middles])
    radii = np.array([1.0, *radii])[: len(middles)]
    low, high = (middles - radii).max(), (middles + radii).min()
    blocks = balls(middles[:, None], radii)
    x = enter(blocks, np.zeros(1))
    assert x is None or low < x[0] < high


def test_a_point_on_the_edge_is_no_point_inside():
    blocks = balls([[0.0], [1.0]], [1.0, 1.0])
    assert 0.0 < enter(blocks, np.zeros(1))[0] < 1.0
    x = np.array([0.3])
    assert enter(blocks, x) is x


@pytest.mark.parametrize("units", [2.0**-20, 2.0**20])
def test_units_of_a_block_change_nothing(units):
    """The shift is measured by a block's diagonal, in powers of two."""
    blocks = balls([[0.0, 0.0], [1.5, 0.3], [0.5, 0.9]], [1.0, 1.0, 0.8])
    T = np.diag([units, 1.0, 1.0])
    other = Blocks(
        [T @ c @ T if k else c for k, c in enumerate(blocks.constants)],
        [T @ s @ T if k else s for k, s in enumerate(blocks.slopes)],
    )
    plain, changed = (enter(b, np.zeros(2)) for b in (blocks, other))
    np.testing.assert_allclose(changed, plain, rtol=1e-9)


def test_what_has_no_point_is_not_entered():
    blocks = balls([[0.0, 0.0], [2.5, 0.0]], [1.0, 1.0])
    assert enter(blocks, np.zeros(2)) is None


def some_centre(lmis, count):
    """The centre of the blocks of the first ``count`` pairs."""
    few = lmis.of_pairs(lmis.request.pairs[:count])
    return lmis.packed(few.solve().values)


@pytest.mark.parametrize(
    "family, size, count", [("uncertain springs", 16, 3), ("tied masses", 4, 2)]
)
def test_the_blocks_of_all_vertices_are_entered_near_their_centre(family, size, count):
    lmis = case(family, size, framed=True).lmis
    blocks, x = lmis.compiled, some_centre(lmis, count)
    assert newton_of(blocks).least(x).min() < 0  # there is something to enter
    entered = enter(blocks, x)
    assert newton_of(blocks).least(entered).min() > 0
    assert decrement(blocks, entered) < 3.0


@pytest.fixture
def asked(monkeypatch):
    """How often phase one and `enter` are asked, and what `enter` said."""
    said = {"phase_one": [], "enter": []}
    for name, outcomes in said.items():
        true = getattr(cutting, name)

        def noted(*args, true=true, outcomes=outcomes, **words):
            outcome = true(*args, **words)
            outcomes.append(outcome is not None)
            return outcome

        monkeypatch.setattr(cutting, name, noted)
    return said


@pytest.mark.parametrize("kind", ["springs", "masses"])
def test_pairs_that_join_are_entered_without_phase_one(kind, asked):
    """The answer is that of all pairs at once."""
    if kind == "springs":
        plant, words = FAMILIES["uncertain springs"].make(64)
    else:
        plant, words = plants(7, 4), ASKED["gamma"]
    design = sos.design_pid(plant, **words)
    assert design.status == "feasible" and design.certify().proven
    assert asked["phase_one"] == [True] and all(asked["enter"]) and asked["enter"]


def test_after_a_long_way_phase_one_leads(monkeypatch):
    plant, words = FAMILIES["uncertain springs"].make(64)
    design, asked = sos.design_pid(plant, **words), []
    monkeypatch.setattr(cutting, "enter", lambda *of: asked.append(of))
    again = sos.design_pid(plant, **words)
    assert len(asked) == 1
    np.testing.assert_allclose(again.K, design.K, rtol=1e-6)


def test_conjugate_gradients_leave_it_to_phase_one():
    lmis = case("uncertain springs", 16, framed=True).lmis
    blocks, x = lmis.compiled, some_centre(lmis, 3)
    newton_of(blocks).iterative = True
    assert enter(blocks, x) is None
