"""Dense and sparse matrices are two paths of one verb: the same plant goes along both,
whatever its size, and numpy's eigenvalues are the judge.
"""

import itertools

import numpy as np
import pytest
import scipy.sparse as sp
from numpy.testing import assert_allclose
from scipy.linalg import eigh
from scipy.sparse.csgraph import reverse_cuthill_mckee
from scipy.sparse.linalg import splu

import sosbook as sos
from sosbook.analysis.large import SYMMETRIC, Pencil
from sosbook.plants import sparse
from sosbook.plants.modes import below, symmetric_factor
from sosbook.runtime import time_limit as clock
from sosbook.synthesis.design import Design
from sosbook.synthesis.request import Request
from tests.cases import by_hand, by_turns, campaign
from tests.test_reduction import beam_matrices, rotor


def chain(n, springs=(), at=0, unit=1.0, damping=0.05):
    """Masses between springs of 1, some of them with more ``springs`` to the ground."""
    S = 2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    for k, stiffness in springs:
        S[k, k] += stiffness
    M = np.diag(1 + 0.3 * np.cos(np.arange(n)))
    D = damping * np.eye(n) + 1e-3 * S
    return [unit * x for x in (M, D, S, np.eye(n)[:, [at]])]


def buckled(load):
    """A beam between hinges under an axial load, of its first critical one."""
    M, S = beam_matrices(20, 1.0, 9.81, 0.3)
    h = 1 / 20
    one = np.array(
        [
            [36, 3 * h, -36, 3 * h],
            [3 * h, 4 * h**2, -3 * h, -(h**2)],
            [-36, -3 * h, 36, -3 * h],
            [3 * h, -(h**2), -3 * h, 4 * h**2],
        ]
    ) / (30 * h)
    G = np.zeros_like(S)
    for k in range(0, 40, 2):
        G[k : k + 4, k : k + 4] += one
    S = S - load * 9.81 * np.pi**2 * G
    inside = [k for k in range(42) if k not in (0, 40)]
    M, S = (x[np.ix_(inside, inside)] for x in (M, S))
    return M, 0.3 * M + 1e-6 * abs(S).max() * np.eye(40), S, np.eye(40)[:, [9]]


def turning(bearing):
    plant = rotor(200.0, bearing)
    return plant.M, plant.D, plant.S, plant.B


def circulatory():
    """An unsymmetric S, which makes a pair of modes unstable: flutter."""
    M, D, S, B = chain(30, damping=1e-3)
    for k in range(0, 28, 2):
        S[k, k + 1] += 0.2
        S[k + 1, k] -= 0.2
    return M, D, S, B


PLANTS = {  # matrices, and how many modes hold all that is unstable
    "one negative spring": (chain(40, [(0, -4.0)]), 6),
    "another unit": (chain(40, [(0, -4.0)], unit=0.3), 6),
    "hardly negative": (chain(40, [(7, -0.3)], at=7, unit=9.81), 3),
    "two negative springs": (chain(40, [(0, -4.0), (30, -2.1)]), 6),
    "far apart": (chain(40, [(0, -4e3), (30, -2.1)]), 6),
    "many negative springs": (chain(40, [(k, -3.0) for k in range(0, 40, 4)]), 12),
    "free ends": (chain(40, [(0, -1.0), (39, -1.0)], damping=0.3), 5),
    "damped": (chain(40, [(0, -4.0)], damping=900.0), 4),
    "buckled": (buckled(1.3), 4),
    "buckled twice": (buckled(5.0), 4),
    "not buckled": (buckled(0.7), 4),
    "a magnetic bearing": (turning(-3e5), 8),
    "gyroscopic": (turning(1e6), 6),
    "circulatory": (circulatory(), 5),
}


def both(matrices, monkeypatch):
    """The plant with dense matrices, and with sparse ones."""
    M, D, S, B = matrices
    dense = sos.SecondOrderSystem(M, D, S, B)
    monkeypatch.setattr(sparse, "MOST_DENSE", 5)
    return dense, sos.SecondOrderSystem(*map(sp.csc_array, (M, D, S)), B)


@pytest.mark.parametrize("name", by_turns(PLANTS, 1))
def test_reduce_keeps_the_lowest_squares_of_both(name, monkeypatch):
    matrices, modes = PLANTS[name]
    dense, large = both(matrices, monkeypatch)
    assert sp.issparse(large.S) and not sp.issparse(dense.S)
    S = (dense.S + dense.S.T) / 2
    truth = eigh(S, dense.M, eigvals_only=True)
    size = max(abs(truth[0]), truth[modes])
    rows = [3, 20]
    rest = np.setdiff1d(np.arange(dense.n), rows)
    inner = (x[np.ix_(rest, rest)] for x in (S, dense.M))
    held = eigh(*inner, eigvals_only=True)
    for plant in (dense, large):
        part = plant.reduce(modes=modes)
        squares = np.linalg.eigvalsh((part.S + part.S.T) / 2)
        assert_allclose(squares, truth[:modes], rtol=1e-7, atol=1e-9 * size)
        assert_allclose(part.M, np.eye(modes), atol=1e-9)
        with_rows = plant.reduce(rows=rows, modes=modes)
        fixed = with_rows.S[2:, 2:]
        squares = np.linalg.eigvalsh((fixed + fixed.T) / 2)
        assert_allclose(squares, held[:modes], rtol=1e-7, atol=1e-9 * size)


@pytest.mark.parametrize("name", PLANTS)
def test_reduce_leaves_out_no_negative_square_of_either(name, monkeypatch):
    plants = both(PLANTS[name][0], monkeypatch)
    S = (plants[0].S + plants[0].S.T) / 2
    count = int((eigh(S, plants[0].M, eigvals_only=True) < 0).sum())
    rest = np.arange(1, plants[0].n)
    inner = (x[np.ix_(rest, rest)] for x in (S, plants[0].M))
    held = int((eigh(*inner, eigvals_only=True) < 0).sum())
    for plant in plants:
        if count:
            assert below(plant.M, (plant.S + plant.S.T) / 2, 0.0) == count
        if count > 1:
            with pytest.raises(ValueError, match=f"^{count} modes.*modes={count} or"):
                plant.reduce(modes=count - 1)
        if held:
            with pytest.raises(ValueError, match=f"{held} modes of.*modes={held}, too"):
                plant.reduce(rows=[0])
            plant.reduce(rows=[0], modes=held)
        else:
            plant.reduce(rows=[0])


def test_a_mass_that_isnt_positive_is_refused_by_both(monkeypatch):
    M, D, S, B = chain(20)
    M[4, 4] = -1e-3
    with pytest.warns(sos.MassWarning):
        plants = both((M, D, S, B), monkeypatch)
    for plant in plants:
        with pytest.raises(ValueError, match="M isn't positive definite"):
            plant.reduce(modes=3)


GAINS = 0.0, -1.0, 30.0


def loops(name, monkeypatch):
    """Design, plant, and poles by numpy: the plant's own modes with small gains."""
    matrices, modes = PLANTS[name]
    for plant in both(matrices, monkeypatch):
        part = plant.reduce(modes=modes)
        rng = np.random.default_rng(0)
        for size in GAINS:
            K = size * part.B.T @ np.hstack([np.eye(modes), 0.3 * np.eye(modes)])
            K = K + 0.1 * abs(size) * rng.normal(size=K.shape)
            asked = [sos.LMIRegion.half_plane(1e-4)]
            request = Request(part, gain=K, requirements=asked)
            design = Design(request, "undecided", K)
            dense = sos.SecondOrderSystem(*matrices)
            A, B = by_hand(dense)
            yield plant, design, np.linalg.eigvals(A + B @ part.reduction.lift(K))


@pytest.mark.parametrize("name", by_turns(PLANTS, 0, of=3))
def test_check_on_says_the_same_of_both(name, monkeypatch):
    for plant, design, truth in loops(name, monkeypatch):
        found = design.check_on(plant, time_limit=1e3)
        rightmost = truth.real.max()
        assert found.kept == (rightmost < -1e-4), (str(found), rightmost)
        near = abs(truth - found.pole).min()
        assert near < 1e-6 * max(abs(found.pole), 1e-3), (str(found), rightmost)
        if not sp.issparse(plant.S):
            assert_allclose(found.pole.real, rightmost, rtol=1e-5, atol=1e-9)
        if found.right is not None:
            assert found.right <= (truth.real > 0).sum()
            assert (
                found.right > 0
                or name in ("gyroscopic", "circulatory")
                or (rightmost < 1e-9)
            )


def slowed(monkeypatch, looks):
    """A clock that is over its limit after so many looks of the search."""
    ticks = itertools.count()
    monkeypatch.setattr(
        clock, "monotonic", lambda: 1e9 if next(ticks) > looks else next(ticks) * 1e-9
    )


@pytest.mark.parametrize("looks", [150, 400])
def test_a_search_whose_time_is_over_says_what_it_has_found(looks, monkeypatch):
    matrices, modes = PLANTS["not buckled"]
    _, plant = both(matrices, monkeypatch)
    part = plant.reduce(modes=modes)
    design = sos.analyse_pid(part, np.zeros((1, 2 * modes)))
    assert design.check_on(plant).kept
    truth = np.linalg.eigvals(by_hand(sos.SecondOrderSystem(*matrices))[0])
    slowed(monkeypatch, looks)
    found = design.check_on(plant, time_limit=1e3)
    assert "time was over after" in str(found) and not found.kept and not found.broken
    apart = abs(found.poles[:, None] - truth).min(axis=1)
    assert (apart < 1e-6 * abs(found.poles)).all()


def test_a_search_without_time_for_a_pole_is_an_error(monkeypatch):
    matrices, modes = PLANTS["not buckled"]
    dense, plant = both(matrices, monkeypatch)
    design = sos.analyse_pid(plant.reduce(modes=modes), np.zeros((1, 2 * modes)))
    monkeypatch.setattr(clock, "SECONDS_OF_EIGENVALUES", 1e-3)
    with pytest.raises(clock.OutOfTime, match="takes about 1024 s, of .* raise time"):
        design.check_on(dense)
    slowed(monkeypatch, 3)
    with pytest.raises(clock.OutOfTime, match="over: raise time_limit"):
        design.check_on(plant)


@pytest.mark.parametrize("refined", [1, 3])
def test_poles_of_a_dense_plant_that_are_refined_in_time_are_told(refined, monkeypatch):
    plant = sos.SecondOrderSystem(*PLANTS["not buckled"][0])
    design = sos.analyse_pid(plant.reduce(modes=4), np.zeros((1, 8)))
    truth, kept = np.linalg.eigvals(by_hand(plant)[0]), Pencil.refined

    def late(self, *pole):
        if next(count) >= refined:
            raise clock.OutOfTime
        return kept(self, *pole)

    count = itertools.count()
    monkeypatch.setattr(Pencil, "refined", late)
    found = design.check_on(plant)
    assert len(found.poles) == refined and not found.kept and not found.broken
    assert abs(found.pole.real - truth.real.max()) < 1e-9
    assert "; time was over: the time limit is over" in str(found)


def bars(*size):
    """The stiffness of a grid of points with bars to all neighbours, on a ground."""
    places = np.argwhere(np.ones(size))
    number, parts = np.arange(len(places)).reshape(size), []
    for way in itertools.product((-1, 0, 1), repeat=3):
        ends = places + way
        near = np.flatnonzero(((ends >= 0) & (ends < size)).all(axis=1))
        if way > (0, 0, 0):
            far = number[tuple(ends[near].T)]
            columns = np.hstack(
                [3 * near[:, None] + range(3), 3 * far[:, None] + range(3)]
            )
            values = np.tile([*way, *(-x for x in way)], len(near))
            pointers = np.arange(0, 6 * len(near) + 1, 6)
            shape = len(near), 3 * len(places)
            parts.append(sp.csr_array((values, columns.ravel(), pointers), shape=shape))
    across = sp.vstack(parts).astype(float)
    return sp.csc_array(across.T @ across + 0.3 * sp.eye_array(across.shape[1]))


@pytest.mark.parametrize("size", [(40, 5, 5), (7, 7, 7)])
def test_a_solid_fills_no_more_than_its_band(size):
    """Blocks and slender solids: bars to all neighbours of a grid, held at one end."""
    S = bars(*size)
    order = reverse_cuthill_mckee(S, symmetric_mode=True)
    most = 1.1 * splu(S[order][:, order].tocsc(), permc_spec="NATURAL").L.nnz
    assert symmetric_factor(S).L.nnz < most
    columns = pencil_of(S).columns
    assert splu(S.astype(complex), permc_spec=columns, **SYMMETRIC).L.nnz < most


def pencil_of(S):
    """The loop of a structure without a controller."""
    n, none = S.shape[0], np.zeros((0, 0))
    K, G, C = np.zeros((1, 2 * n)), np.zeros((0, 2 * n)), np.zeros((1, 0))
    one = sp.eye_array(n, format="csc")
    return Pencil(one, 0.01 * one, S, np.eye(n)[:, :1], K, none, G, C)


def joints(*size):
    """A grid of springs that is held all around."""
    rows = (
        sp.diags_array([-1.0, 2, -1], offsets=[-1, 0, 1], shape=(k, k)) for k in size
    )
    return sp.csc_array(sp.kronsum(*rows))


def frame(*size):
    """Three displacements a joint, which all couple."""
    return sp.csc_array(sp.kron(joints(*size), 9.81 * (np.eye(3) + 0.3)))


def plate(*size):
    """The stiffness of a thin plate by finite differences."""
    return sp.csc_array(joints(*size) @ joints(*size))


SHAPES = [frame(40, 12), frame(3, 120), plate(40, 30), bars(40, 5, 5)]


@pytest.mark.parametrize("S", SHAPES, ids=["wide", "tower", "plate", "lattice"])
def test_factors_take_the_order_that_fills_least(S):
    """Of the two that SuperLU has for such a pattern, at a pole as well."""
    at = (1.7 + 9.81j) ** 2 * sp.eye_array(S.shape[0]) + S
    fills = {
        order: splu(sp.csc_array(at), permc_spec=order, **SYMMETRIC).nnz
        for order in sparse.ORDERS
    }
    assert fills[pencil_of(S).columns] < 1.1 * min(fills.values())


def test_a_broken_claim_ends_the_search_of_a_sparse_plant(monkeypatch):
    """Its first place is where the count says that a pole is."""
    _, plant = both(PLANTS["two negative springs"][0], monkeypatch)
    part = plant.reduce(modes=6)
    design = sos.analyse_pid(part, np.zeros((1, 12)))
    found = design.check_on(plant)
    assert found.right == 2 and not found.kept and found.pole.real > 0
    assert "counted right of the imaginary axis: 2 or more" in str(found)
    assert "the search ended there, at 1 of" in str(found)


def test_of_a_sparse_whole_nothing_is_proven_and_it_is_said_at_once(monkeypatch):
    _, plant = both(PLANTS["not buckled"][0], monkeypatch)
    design = sos.analyse_pid(plant.reduce(modes=4), np.zeros((1, 8)))
    search = "sosbook.synthesis.reduced_model.found_on"
    with monkeypatch.context() as without:
        without.delattr(search)
        refused = design.certify(on=plant)
    assert not refused.proven and "too large for LMIs" in str(refused)
    assert "design.check_on(whole)" in str(refused) and design.check_on(plant).kept


def test_the_share_of_a_search_is_shown(monkeypatch, capsys):
    """Of the places where poles are sought; a dense whole has all poles at once."""
    monkeypatch.delenv("TQDM_DISABLE", raising=False)
    for plant in both(PLANTS["not buckled"][0], monkeypatch):
        design = sos.analyse_pid(plant.reduce(modes=4), np.zeros((1, 8)))
        assert design.check_on(plant).kept and not capsys.readouterr().err
        assert design.check_on(plant, progress=True).kept
        shown = capsys.readouterr().err
        assert ("place/s" in shown) == bool(shown) == sp.issparse(plant.S)


def test_a_proof_that_is_stopped_says_which_part_is_done(monkeypatch):
    matrices, modes = PLANTS["not buckled"]
    dense, _ = both(matrices, monkeypatch)
    design = sos.analyse_pid(dense.reduce(modes=modes), np.zeros((1, 2 * modes)))

    def stopped(*_, **__):
        raise clock.OutOfTime

    monkeypatch.setattr("sosbook.synthesis.reduced_model.prove", stopped)
    words = str(design.certify(on=dense, time_limit=9.0))
    assert "stopped after 9 s" in words and "a P is found" in words


@pytest.mark.parametrize("unit", [0.3, 9.81, *campaign([1.0])])
def test_condense_makes_one_plant_of_both(unit, monkeypatch):
    M, D, S, B = chain(24, [(0, 2.0)], unit=unit)
    for k in (3, 4, 15):
        M[k, k], D[k], D[:, k] = 0.0, 0.0, 0.0
    dense = sos.plants.condense(M, D, S, B)
    monkeypatch.setattr(sparse, "MOST_DENSE", 5)
    monkeypatch.setattr("sosbook.plants.condensing.MOST_TOUCHED", 24)
    large = sos.plants.condense(*map(sp.csc_array, (M, D, S)), B)
    assert sp.issparse(large.S)
    for name in "MDS":
        assert_allclose(getattr(large, name).toarray(), getattr(dense, name))
    assert_allclose(large.B, dense.B)


@pytest.mark.parametrize("name", ["two negative springs", *campaign(["free ends"])])
def test_certify_on_proves_nothing_false_of_either(name, monkeypatch):
    matrices, modes = PLANTS[name]
    for plant in both(matrices, monkeypatch):
        part = plant.reduce(modes=modes)
        design = sos.analyse_pid(part, np.zeros((1, 2 * modes)))
        truth = np.linalg.eigvals(by_hand(sos.SecondOrderSystem(*matrices))[0])
        proof = design.certify(on=plant, time_limit=300.0)
        assert not proof.proven or truth.real.max() < 0
