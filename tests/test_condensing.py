"""Displacements without mass and damping are solved for, and nothing else changes."""

from fractions import Fraction

import numpy as np
import pytest
import scipy.io
import scipy.linalg
import scipy.sparse as sp
import scipy.sparse.linalg

from sosbook import SecondOrderSystem, design_pid
from sosbook.plants import condense, load_plant
from sosbook.plants.massless import massless
from tests.cases import campaign


def beam(elements, E=9.81e7, length=0.3):
    """Clamped, of Euler's elements whose mass is lumped: rotations have none."""
    L, size = length, 2 * elements + 2
    element = np.array(
        [
            [12, 6 * L, -12, 6 * L],
            [6 * L, 4 * L**2, -6 * L, 2 * L**2],
            [-12, -6 * L, 12, -6 * L],
            [6 * L, 2 * L**2, -6 * L, 4 * L**2],
        ]
    )
    S = np.zeros((size, size))
    for k in range(0, size - 2, 2):
        S[k : k + 4, k : k + 4] += E * 1e-6 / L**3 * element
    M = np.diag(np.tile([0.7, 0.0], elements))
    D = np.diag(np.tile([0.03, 0.0], elements))
    return dict(M=M, D=D, S=S[2:, 2:], B=np.eye(2 * elements)[:, -2:-1])


def finite_poles(M, D, S, B, **_):
    """Of the pencil of all rows: its finite eigenvalues."""
    n = len(M)
    one, zero = np.eye(n), np.zeros((n, n))
    A, E = np.block([[zero, one], [-S, -D]]), scipy.linalg.block_diag(one, M)
    alpha, beta = scipy.linalg.eigvals(A, E, homogeneous_eigvals=True)
    # a massless row makes a double pole at infinity: beta is the root of rounding
    some = abs(beta) > 1e-6 * abs(alpha)
    return np.sort(abs(alpha[some] / beta[some]))


def steady(S, B, **_):
    return np.linalg.solve(S, B)


@pytest.mark.parametrize("skew", [0.4, *campaign([0])])
def test_poles_and_static_response_stay(skew):
    given = beam(5)
    S = given["S"]
    given["S"] = S + skew * np.triu(S, 1)  # follower forces
    given["B"] = np.column_stack([given["B"], np.eye(10)[:, 3]])  # a moment, too
    plant = condense(**given, F=np.eye(10)[:, [5]])
    assert (plant.n, plant.m, plant.p) == (5, 2, 1)
    assert np.sort(abs(plant.poles())) == pytest.approx(finite_poles(**given), rel=1e-6)
    whole = steady(S=given["S"], B=np.column_stack([given["B"], np.eye(10)[:, [5]]]))
    found = steady(S=plant.S, B=np.hstack([plant.B, plant.F]))
    assert found == pytest.approx(whole[::2], rel=1e-9)
    assert (plant.S == plant.S.T).all() == (skew == 0)
    long = condense(**beam(100)).S  # its corners are 1e-57 of the largest
    assert (long == long.T).all()


@pytest.mark.parametrize("skew", [0.4, *campaign([0])])
def test_directions_without_mass_are_condensed(skew):
    """The same rows and columns in other coordinates, which mix them."""
    given = beam(4)
    given["S"] = given["S"] + skew * np.triu(given["S"], 1)
    plain = condense(**given)
    low = np.eye(8) + np.tril(np.random.default_rng(2).integers(1, 3, (8, 8)), -1)
    T = low @ low.T  # of determinant one
    turned = {x: T.T @ given[x] @ T for x in "MDS"} | {"B": T.T @ given["B"]}
    turned = {name: x.round(12) for name, x in turned.items()}
    assert not massless(turned["M"], turned["D"]).size
    with pytest.raises(ValueError, match="for the 4 directions without mass exactly"):
        SecondOrderSystem(**turned)
    plant = condense(**turned)
    assert plant.n == 4 and (plant.S == plant.S.T).all() == (skew == 0)
    assert np.sort(abs(plant.poles())) == pytest.approx(
        np.sort(abs(plain.poles())), rel=1e-6
    )
    assert condense(**turned, coordinates=list("abcdefgh")).coordinates is None
    gains = [p.B.T @ np.linalg.solve(p.S, p.B) for p in (plant, plain)]
    assert gains[0] == pytest.approx(gains[1], rel=1e-9)  # of the same force there


def test_a_chain_of_springs_by_fractions():
    """Springs 0.1, 0.2, 0.3 in series between two masses: 1/(10 + 5 + 10/3)."""
    k = [Fraction(x) / 10 for x in (1, 2, 3)]
    S = np.zeros((4, 4))
    for i, x in enumerate(k):
        S[i : i + 2, i : i + 2] += float(x) * np.array([[1, -1], [-1, 1]])
    S[1, 1], S[2, 2] = 0.3, 0.5  # as decimals
    plant = condense(np.diag([1, 0, 0, 1]), np.zeros((4, 4)), S, np.eye(4)[:, :1], None)
    one = float(1 / sum(1 / x for x in k))
    assert (plant.S == [[one, -one], [-one, one]]).all()
    assert plant.B.tolist() == [[1], [0]]


def test_what_a_row_does_not_reach_is_zero():
    """By balls it would be 1e-80."""
    S = np.diag([3.0, 0.7, 5.0]) + 0.1 * (np.eye(3, k=1) + np.eye(3, k=-1))
    S[1, 2] = S[2, 1] = 0
    plant = condense(np.diag([1, 0, 1]), np.zeros((3, 3)), S, np.eye(3))
    assert plant.S[0, 1] == plant.S[1, 0] == 0 and plant.S[1, 1] == 5
    cancels = np.array([[2.0, 0.3, 0.7], [0.3, 0.3, 0.7], [0.7, 0.7, 0.1]])
    cancels[0, 2] = cancels[2, 0] = 0.7  # S_02 - S_01 S_11^-1 S_12 = 0
    plant = condense(np.diag([1, 0, 1]), np.zeros((3, 3)), cancels, np.eye(3))
    assert plant.S[0, 1] == 0


def test_the_error_names_the_cure_and_the_cure_works(tmp_path):
    given = beam(3)
    cure = r"nor input; sosbook\.plants\.condense solves for z\[1, 3, 5\]"
    with pytest.raises(ValueError, match=cure):
        SecondOrderSystem(**given)
    with pytest.raises(ValueError, match=r"z\[1, 3, .*, 23, \.\.\.\] exactly"):
        SecondOrderSystem(**beam(13))
    scipy.io.savemat(tmp_path / "beam.mat", given)
    with pytest.raises(ValueError, match=f"{cure} exactly; or pass condensed=True"):
        load_plant(tmp_path / "beam.mat")
    plant = load_plant(tmp_path / "beam.mat", condensed=True)
    assert plant == condense(**given)
    assert design_pid(plant).certify().proven


def test_names_of_the_rest_are_kept():
    plant = condense(**beam(2), coordinates=["w1", "t1", "w2", "t2"])
    assert plant.coordinates == ("w1", "w2")
    for names in (["w1"], "w1"):
        with pytest.raises(ValueError, match="coordinates must be 4 different names"):
            condense(**beam(2), coordinates=names)


def test_where_there_is_damping_or_nothing_to_condense():
    one = SecondOrderSystem([[2]], [[3]], [[1]], [[1]])
    assert condense(one.M, one.D, one.S, one.B) == one
    with pytest.raises(ValueError, match="DescriptorSystem without that velocity") as e:
        condense(np.diag([1, 0]), np.eye(2), [[2, 1], [1, 2]], [[1], [0]])
    assert "condense" not in str(e.value)


@pytest.mark.parametrize(
    "changed, words",
    [
        ({"S": np.diag([1.0, 0, 1, 1])}, "row 1 is empty in M, D and S"),
        ({"M": np.zeros((4, 4)), "D": np.zeros((4, 4))}, "M and D are zero"),
        ({"D": np.eye(3)}, "D has 3 rows, needs 4"),
        ({"S": np.full((4, 4), np.nan)}, "S has NaN"),
        ({"F": np.eye(3)}, "F has 3 rows"),
    ],
)
def test_bad_input_is_named(changed, words):
    with pytest.raises(ValueError, match=words):
        condense(**beam(2) | changed)


@pytest.mark.parametrize("unit", [1.0, 0.3 / 9.81])
def test_a_large_sparse_plant_is_condensed_where_it_has_no_mass(unit, tmp_path):
    """Only the rows beside the massless ones are touched; the rest stays sparse."""
    n, gone = 1500, [0, 7, 8, 700, 1499]
    T = sp.diags([-np.ones(n - 1), 2.5 * np.ones(n), -np.ones(n - 1)], [-1, 0, 1])
    S = unit * (T + 0.3 * sp.eye(n, k=1))
    mass = np.ones(n)
    mass[gone] = 0
    B = np.zeros((n, 2))
    B[[8, 40], [0, 1]] = unit
    given = dict(M=sp.diags(mass), D=0.1 * sp.diags(mass), S=S, B=B)
    plant = condense(**given, coordinates=[f"z{k}" for k in range(n)])
    left = np.setdiff1d(np.arange(n), gone)
    assert sp.issparse(plant.S) and plant.S.nnz < 4 * n
    assert plant.coordinates == tuple(f"z{k}" for k in left)
    whole = scipy.sparse.linalg.spsolve(S.tocsc(), B)
    assert plant.S @ whole[left] == pytest.approx(plant.B, abs=1e-12 * unit)
    for name, x in given.items():
        sp.save_npz(tmp_path / f"{name}.npz", sp.csc_array(x))
    assert load_plant(tmp_path, condensed=True) == condense(**given)
    loose = S.tolil()
    loose[7, :], loose[:, 7] = 0, 0
    with pytest.raises(ValueError, match="row 7 is empty in M, D and S: leave it"):
        condense(**given | dict(S=loose))
    with pytest.raises(ValueError, match="no displacement has a mass"):
        condense(**given | dict(M=0 * S, D=0 * S))
    assert condense(**given | dict(M=sp.eye(n))).n == n


def test_massless_rows_that_would_fill_a_large_plant_are_refused():
    n = 2500
    T = sp.diags([-np.ones(n - 1), 2 * np.ones(n), -np.ones(n - 1)], [-1, 0, 1])
    mass = sp.diags(np.arange(n) % 2 * 1.0)
    with pytest.raises(ValueError, match="1250 displacements .* touch 2500 rows"):
        condense(mass, mass, T, np.eye(n)[:, :1])
