"""What is odd about a plant is said, and the cure that is named works on that plant."""

import re
import warnings

import numpy as np
import pytest
import scipy.io
import scipy.linalg
import scipy.sparse as sp
from numpy.testing import assert_allclose

import sosbook as sos
from sosbook.plants import condense, load_plant
from tests.test_condensing import finite_poles

PUSH = np.array([[1.0], [0]])
K3 = np.array([[3.0, -1, 0], [-1, 2, -1], [0, -1, 1]])  # frequencies .403, 1.126, 1.799
M3, C3 = np.diag([1, 2, 1.5]), 0.1 * np.eye(3)
THIRDS = np.array([[1, 0.6666666667], [0.6666666667, 0.4444444444]])  # of rank one
SPRINGS = np.array([[2.0, -1], [-1, 2]])


def refusal(do, *given, **more):
    with pytest.raises(ValueError) as error:
        do(*given, **more)
    return str(error.value)


def sizes(poles):
    return np.sort(abs(poles))


@pytest.mark.parametrize("key", ["dt", "Ts", "ts", "T", "sampling_time"])
@pytest.mark.parametrize("save", [scipy.io.savemat, lambda x, y: np.savez(x, **y)])
def test_a_state_space_of_discrete_time_keeps_its_tick(key, save, tmp_path):
    """The file's A is of x(k+1); a gain is judged by the poles z."""
    A, B = np.array([[0, 1], [-4, -0.4]]), np.array([[0.0], [9.81]])
    held = scipy.linalg.expm(0.05 * np.block([[A, B], [np.zeros((1, 3))]]))[:2]
    file = tmp_path / ("x.mat" if save is scipy.io.savemat else "x.npz")
    given = {"A": held[:, :2], "B": held[:, 2:]}
    save(file, given | {key: 0.0})
    assert getattr(load_plant(file), "dt", None) is None
    save(file, given | {key: 0.05})
    if key in ("T", "sampling_time"):
        assert f"{key} = 0.05 beside A" in refusal(load_plant, file)
        return
    plant = load_plant(file)
    assert plant.dt == 0.05
    still = sos.analyse_pid(plant, [[0, 0]]).poles()
    assert_allclose(sizes(still), sizes(np.linalg.eigvals(held[:, :2])))
    design = sos.design_pid(plant)
    loop = np.linalg.eigvals(given["A"] + given["B"] @ design.K)
    assert abs(loop).max() < 1 and design.certify().proven
    for unknown in (-1.0,) if file.suffix == ".mat" else (-1.0, True):
        save(file, given | {key: unknown})
        assert "call it dt, in seconds" in refusal(load_plant, file)


def test_a_block_and_small_letters_are_read(tmp_path):
    A, B, C = np.array([[0.0, 2], [-9.81, -0.3]]), np.array([[0.0], [1]]), np.eye(2)
    block = np.block([[A, B], [C, np.zeros((2, 1))]])
    scipy.io.savemat(tmp_path / "x.mat", {"ABCD": block, "nx": 2.0}, format="4")
    (v,) = load_plant(tmp_path / "x.mat").vertices
    assert (v.A == A).all() and (v.Bu == B).all() and (v.C == C).all()
    scipy.io.savemat(tmp_path / "x.mat", {"ABCD": block, "nx": 2, "Ts": 0.1})
    assert load_plant(tmp_path / "x.mat").dt == 0.1
    for nx in (0, 5, 1.5):
        scipy.io.savemat(tmp_path / "x.mat", {"ABCD": block, "nx": nx})
        assert "nx must say" in refusal(load_plant, tmp_path / "x.mat")
    scipy.io.savemat(
        tmp_path / "x.mat", {"m": M3, "c": C3, "k": K3, "b": PUSH[[0, 1, 1]]}
    )
    assert load_plant(tmp_path / "x.mat") == sos.SecondOrderSystem(
        M3, C3, K3, PUSH[[0, 1, 1]]
    )


@pytest.mark.parametrize("side", [np.triu, np.tril])
def test_half_of_a_symmetric_matrix_is_named(side, tmp_path):
    given = dict(M=M3, D=C3, S=side(K3), B=np.eye(3)[:, :1])
    with pytest.warns(sos.MassWarning, match="half of a symmetric matrix") as said:
        sos.SecondOrderSystem(**given)
    sum_ = re.search(r"S \+ (\w+)(\(.*\)\.T)", str(said[0].message))
    whole = eval(f"S + np.{sum_[1]}{sum_[2]}", {"np": np, **given})
    assert_allclose(
        np.sqrt(scipy.linalg.eigvalsh(whole, M3)), [0.403, 1.126, 1.799], atol=1e-3
    )
    scipy.io.savemat(tmp_path / "x.mat", {**given, "G": 1})
    with pytest.warns(UserWarning, match="x.mat: all entries of S .* left out: G"):
        load_plant(tmp_path / "x.mat")
    for x in "MDS":
        scipy.io.mmwrite(
            tmp_path / f"{x}.mtx", sp.coo_array(given[x]), symmetry="general"
        )
    np.save(tmp_path / "B.npy", given["B"])
    with pytest.warns(UserWarning, match="half of a symmetric"):
        load_plant(tmp_path)
    large = {x: sp.block_diag([given[x]] * 400) for x in "MDS"}
    with pytest.warns(sos.MassWarning, match="half of a symmetric"):
        sos.SecondOrderSystem(**large, B=np.eye(1200)[:, :1])
    masses = side(np.eye(1001) + 0.3 * np.eye(1001, k=1) + 0.3 * np.eye(1001, k=-1))
    with pytest.warns(sos.MassWarning, match="half of a symmetric"):
        sos.SecondOrderSystem(masses, np.eye(1001), masses, np.eye(1001)[:, :1])
    follower = dict(M=np.eye(2), D=np.eye(2), S=side([[2, 1], [1, 2]]), B=np.eye(2))
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # one of two rows may push in one direction
        sos.SecondOrderSystem(**follower)
    with pytest.warns(sos.MassWarning, match="half of a symmetric"):
        sos.SecondOrderSystem(**follower | {"D": side([[2, 1], [1, 2]])})


def test_empty_rows_are_left_out(tmp_path):
    given = dict(M=np.diag([2.0, 0]), D=np.diag([0.3, 0]), S=np.diag([9.81, 0]), B=PUSH)
    assert "row 1 is empty in M, D, S, B" in refusal(sos.SecondOrderSystem, **given)
    scipy.io.savemat(tmp_path / "x.mat", given)
    for condensed in (False, True):
        text = refusal(load_plant, tmp_path / "x.mat", condensed=condensed)
        without = eval(re.search(r"without=(\[.*?\])", text)[1])
        plant = load_plant(tmp_path / "x.mat", without=without, condensed=condensed)
        assert_allclose(sizes(plant.poles()), sizes(np.roots([2, 0.3, 9.81])))


def test_constraints_are_kept_by_the_coordinates_that_are_named():
    """Two masses that move alike, and a third: rows of multipliers say so."""
    G = np.array([[1.0, -1, 0]])
    S = np.block([[K3, G.T], [G, np.zeros((1, 1))]])
    M, D = (scipy.linalg.block_diag(x, 0) for x in (M3, C3))
    B, names = (
        np.eye(4)[:, :1],
        {"scipy": scipy, "M": M, "D": D, "S": S, "r": [3], "k": [0, 1, 2]},
    )
    for do in (sos.SecondOrderSystem, condense):
        text = refusal(do, M, D, S, B)
        assert "rows r = [3] are constraints" in text and "condense solves" not in text
    names["Q"] = eval(re.search(r"Q = (scipy.*?\]\))", text)[1], names)
    call = re.search(r"(Q\.T @ )M(\[k\]\[:, k\] @ Q)", text)
    parts = [eval(call[1] + x + call[2], names) for x in "MDS"]
    plant = sos.SecondOrderSystem(*parts, names["Q"].T @ B[:3])
    rigid = np.array([[1.0, 0], [1, 0], [0, 1]])  # by hand
    by_hand = [rigid.T @ x @ rigid for x in (M3, C3, K3)]
    assert_allclose(sizes(plant.poles()), finite_poles(*by_hand, None), rtol=1e-9)
    S[0, 3] += 1  # the multiplier pushes along the motion that is left
    assert "constraints" not in refusal(sos.SecondOrderSystem, M, D, S, B)


@pytest.mark.parametrize("large", [False, True])
def test_rayleigh_damping_goes_with_what_has_no_mass(large):
    """What is left out has the poles -1 / beta, and the rest keeps its own."""
    n, beta = (1202, 0.03) if large else (4, 0.01)
    S = 9.81 * (2.2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1))
    gone = [1, n - 1]
    mass = np.ones(n)
    mass[gone] = 0
    M = np.diag(mass)
    D = 0.3 * M + beta * S
    B = np.eye(n)[:, :1]
    store = sp.csc_array if large else np.asarray
    given = [store(x) for x in (M, D, S)]
    assert f"condense solves for z[{', '.join(map(str, gone))}]" in refusal(
        sos.SecondOrderSystem, *given, B
    )
    plant, undamped = condense(*given, B), condense(given[0], 0 * given[0], given[2], B)
    left = np.setdiff1d(np.arange(n), gone)
    schur = S[np.ix_(left, left)] - S[np.ix_(left, gone)] @ np.linalg.solve(
        S[np.ix_(gone, gone)], S[np.ix_(gone, left)]
    )
    dense = [x.toarray() if large else x for x in (plant.D, plant.S, undamped.S)]
    assert_allclose(dense[1], schur, atol=1e-12)
    assert_allclose(dense[0], 0.3 * np.eye(len(left)) + beta * schur, atol=1e-12)
    assert (dense[1] == dense[2]).all()
    pushed = B + np.eye(n)[:, [1]]
    for wrong in (
        {"D": given[1] - 0.02 * given[2] * 5},
        {"B": B + 1},
        {"B": pushed},
        {"B": pushed, "D": given[1] - 0.02 * given[2] * 5},
    ):
        words = dict(zip("MDS", given)) | {"B": B} | wrong
        try:
            assert condense(**words).n == n  # it is a plant as it is
        except ValueError as error:
            assert "condense solves" not in str(error)
            assert ("add it to what is left" in str(error)) == ("D" not in wrong)


@pytest.mark.parametrize("unit, alpha", [(1.0, 0.0), (0.3, 0.3), (9810.0, 0.0)])
def test_rayleigh_damping_goes_with_a_mass_of_ten_digits(unit, alpha):
    """Mixtures of rows without mass, as a file prints them: B pushes them by its last
    digit, too.
    """
    n, rank, beta = 6, 4, 0.01
    X = np.cos(np.outer(np.arange(n), np.arange(1.0, rank + 1)) ** 1.5)
    turn = np.eye(n) - 0.2 * np.eye(n, k=2)
    S = 9.81 * unit * turn @ turn.T
    printed = np.vectorize(lambda x: float(f"{x:.10g}"))
    M, B = printed(unit * X @ X.T), printed(X[:, :1])
    D = alpha * M + beta * S
    with pytest.warns(sos.MassWarning, match=r"tolerance=1e-09\) of sosbook.plants"):
        whole = sos.SecondOrderSystem(M, D, S, B)
    assert "tolerance=1e-09" in refusal(whole.reduce, modes=1)
    with pytest.warns(UserWarning, match="leaves out .* of B in 2 directions") as said:
        part = condense(M, D, S, B, tolerance=1e-9)
    sizes_left = [float(str(x.message).split()[3]) for x in said]
    assert part.n == rank and max(sizes_left) < 1e-8
    own = np.linalg.inv(X.T @ np.linalg.solve(S, X))  # of X' z, what has mass
    first = np.block(
        [
            [np.zeros((rank, rank)), np.eye(rank)],
            [-own / unit, -alpha * np.eye(rank) - beta * own / unit],
        ]
    )
    truth = np.sort_complex(np.linalg.eigvals(first))
    assert_allclose(np.sort_complex(part.poles()), truth, rtol=1e-6)


@pytest.mark.parametrize("digits, tolerance", [(8, "1e-07"), (6, "1e-05")])
def test_a_negative_mass_of_few_digits_has_a_cure_that_works(digits, tolerance):
    X = 3 * np.cos(np.outer(np.arange(1, 5), [1.0, 2.3]))
    M = np.vectorize(lambda x: float(f"{x:.{digits}g}"))(X @ X.T)
    given = M, 0 * M, 9.81 * np.eye(4) - np.eye(4, k=1) - np.eye(4, k=-1), np.eye(4)
    assert -1e-5 < np.linalg.eigvalsh(M)[0] / M.max() < -1e-9
    with pytest.warns(sos.MassWarning, match="are the digits of a file few") as said:
        whole = sos.SecondOrderSystem(*given)
    assert f"tolerance={tolerance}" in str(said[0].message)
    assert f"tolerance={tolerance}" in refusal(whole.reduce, modes=1)
    with pytest.warns(UserWarning, match="leaves out .* of M in 2 directions"):
        assert condense(*given, tolerance=float(tolerance)).reduce(modes=1).n == 1
    wrong = given[0] - 2 * np.diag([0, 0, 0, 1])  # a sign that is wrong has none
    with pytest.warns(sos.MassWarning, match=r"is a sign wrong\?$"):
        sos.SecondOrderSystem(wrong, *given[1:])


def test_light_rows_of_a_large_plant_are_named():
    n = 1200
    S = sp.diags_array(
        [-np.ones(n - 1), 2.3 * np.ones(n), -np.ones(n - 1)], offsets=(-1, 0, 1)
    )
    mass = np.where(np.arange(n) % 400 == 7, 1e-11, 0.3)
    M = sp.diags_array(mass)
    with pytest.warns(UserWarning, match="leaves out 3e-11 of M in 3 directions"):
        part = condense(M, 0 * M, S, np.eye(n)[:, :1], tolerance=1e-9)
    assert part.n == n - 3


def test_a_mass_of_ten_digits_is_named_and_rounded():
    true = np.array([[1, 2 / 3], [2 / 3, 4 / 9]])
    B = np.eye(2)
    with pytest.warns(sos.MassWarning, match="a direction has next to no mass") as said:
        plant = sos.SecondOrderSystem(THIRDS, 0 * B, SPRINGS, B)
    more = eval(
        re.search(r"condense\(\.\.\., (.*?)\)", str(said[0].message))[1].join(
            ["dict(", ")"]
        )
    )
    text = refusal(plant.reduce, modes=1)
    assert "condense(..., tolerance=1e-09)" in text
    assert condense(THIRDS, 0 * B, SPRINGS, B) == plant  # no mass is lost exactly
    with pytest.warns(UserWarning, match="leaves out .* of M in 1 direction"):
        part = condense(THIRDS, 0 * B, SPRINGS, B, **more)
    frequency = 1 / np.sqrt(np.linalg.eigvals(np.linalg.solve(SPRINGS, true)).max())
    assert_allclose(abs(part.poles()), 2 * [frequency], rtol=1e-8)
    with pytest.warns(sos.MassWarning, match="next to no mass") as said:
        sos.SecondOrderSystem(THIRDS, 0.05 * B, SPRINGS, B)
    assert "condense" not in str(said[0].message)  # its damping stays
    units = np.diag([1e-7, 1e7])  # no matter of size
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sos.SecondOrderSystem(units @ M3[:2, :2] @ units, B, SPRINGS, B)
        sos.SecondOrderSystem(true.round(1) * 0 + np.diag([1, 0]), B, SPRINGS, B)


@pytest.mark.parametrize("D, cure", [(1, r"rows=\[0, 1\]"), (0, r"z\[2\]")])
def test_where_there_are_no_modes_the_cure_is_tried(D, cure):
    given = [np.diag([1, 2, 0.0]), np.diag([0.1, 0.1, D]), K3 + np.eye(3), np.eye(3)]
    whole = sos.SecondOrderSystem(*given)
    assert re.search(cure, refusal(whole.reduce, modes=1))
    part = whole.reduce(rows=[0, 1]) if D else condense(*given)
    assert part.n == 2 and (D or part.reduce(modes=1).n == 1)
    given[2] = given[2] - 9 * np.diag([0, 0, 1])  # such rows don't follow at rest
    assert "rows=" not in refusal(sos.SecondOrderSystem(*given).reduce, modes=1)


def test_floats_condense_what_would_fill_a_large_plant():
    n = 2502
    T = (
        sp.diags([-np.ones(n - 1), 2.2 * np.ones(n), -np.ones(n - 1)], [-1, 0, 1])
        * 9.81
    )
    mass, B = sp.diags(np.arange(n) % 2 * 0.3), np.eye(n)[:, :1]
    more = re.search(
        r"With (\w+)=(\S+) floats", refusal(condense, mass, 0 * mass, T, B)
    )
    plant = condense(mass, 0 * mass, T, B, **{more[1]: float(more[2])})
    whole = sp.linalg.spsolve(T.tocsc(), B)
    assert plant.n == n // 2
    assert_allclose(plant.S @ whole[1::2], plant.B[:, 0], atol=1e-12)
    loose = sp.block_diag([[[2.0, -1], [-1, 0.5]]] * (n // 2)).tolil()
    loose[0, 0] = 0
    assert "S is singular" in refusal(
        condense, mass, 0 * mass, loose, B, tolerance=1e-9
    )
    assert "tolerance" not in refusal(condense, mass, 0 * mass, loose, B)


@pytest.mark.parametrize("unit", [0.3, 9.81e3])
def test_hysteretic_damping_is_asked_in_a_range_of_frequencies(unit, tmp_path):
    """The call of the error makes plants whose bound the complex stiffness keeps at
    each frequency of the range, under the gain as well.
    """
    M, D, S, B = unit * M3, 0.01 * unit * C3, unit * (K3 + 0.05j * K3), M3[:, :1]
    scipy.io.savemat(tmp_path / "x.mat", dict(M=M, D=D, K=S, B=B))
    texts = [
        refusal(sos.SecondOrderSystem, M, D, S, B),
        refusal(sos.SecondOrderSystem, *map(sp.csc_array, (M, D, S)), B),
        refusal(load_plant, tmp_path / "x.mat"),
    ]
    given = dict(M=M, D=D, S=S, B=B, low=0.3, high=2.5, sosbook=sos)
    for text in texts:
        plants = eval(re.search(r"sosbook\.Polytope\(.*\)", text)[0], given)
    plants = sos.Polytope(
        [sos.SecondOrderSystem(v.M, v.D, v.S, v.B, B) for v in plants.vertices]
    )

    def peak(K):
        K_P, K_D = np.hsplit(K, 2)
        w = np.linspace(0.3, 2.5, 300)[:, None, None]
        loop = S - w**2 * M + 1j * w * D - B @ (K_P + 1j * w * K_D)
        return np.linalg.norm(np.linalg.solve(loop, B + 0j), axis=(1, 2)).max()

    gamma = 0.3 * peak(np.zeros((1, 6)))
    design = sos.design_pid(plants, gamma=gamma)
    assert design.certify().proven and peak(design.K) < gamma


def test_what_a_program_calls_otherwise_has_its_own_words(tmp_path):
    scipy.io.savemat(tmp_path / "x.mat", {"M": M3, "C": C3, "K": K3})
    text = refusal(load_plant, tmp_path / "x.mat")
    assert "add B, a column for each actuator" in text and "names=" not in text
    assert "pass push=[0], one for each actuator" in text
    assert (load_plant(tmp_path / "x.mat", push=[2]).B == [[0], [0], [1]]).all()
    for kind, words in ((".pch", "DMIGPCH"), (".sti", "into a folder")):
        (tmp_path / f"x{kind}").touch()
        assert words in refusal(load_plant, tmp_path / f"x{kind}")
