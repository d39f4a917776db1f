"""Plants in the files that other programs write: what is read is what was meant."""

import re
import sys
import tracemalloc
import warnings
from pathlib import Path
from types import SimpleNamespace

import control
import numpy as np
import pytest
import scipy.io
import scipy.linalg
import scipy.sparse
from numpy.testing import assert_allclose

import sosbook
from sosbook import SecondOrderSystem
from sosbook.plants import DescriptorSystem, load_plant
from sosbook.runtime import matrix_files, reading
from tests.cases import campaign, seeds
from tests.op4_files import binary_op4
from tests.test_benchmark_files import harwell
from tests.test_punch import model

ONE = np.eye(4)
MANUAL = Path(__file__).parents[1] / "book" / "api" / "from_your_program.md"


def frame(n=4, seed=3):
    """A sparse structure: M diagonal, C and K symmetric, a force, a gust."""
    rng = np.random.default_rng(seed)
    K = 9.81 * (2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1))
    C = 0.003 * K + 0.3 * np.diag(rng.uniform(size=n))
    M = np.diag(rng.uniform(1, 3, n).round(3))
    return dict(M=M, C=C, K=K, B=np.eye(n)[:, :1], F=np.eye(n)[:, -1:])


def ordered(poles):
    """By frequency, whatever the last digits are."""
    return poles[np.lexsort((poles.real.round(8), poles.imag.round(8)))]


def poles(M, C, K, **_):
    """By a linearisation of its own, of [z'; z]."""
    n = len(M)
    A = np.block([[-C, -K], [np.eye(n), np.zeros((n, n))]])
    E = scipy.linalg.block_diag(M, np.eye(n))
    return ordered(scipy.linalg.eigvals(A, E))


def same(plant, given):
    """Whether a plant is the one of some M, C, K, B and F."""
    assert ordered(plant.poles()) == pytest.approx(poles(**given), abs=1e-9)
    renamed = {"D": given["C"], "S": given["K"], **given}
    return plant == SecondOrderSystem(**{x: renamed[x] for x in "MDSBF"})


def into_mat(path, **matrices):
    scipy.io.savemat(path / "plant.mat", matrices)
    return path / "plant.mat"


# ------------------------------------------------------------- matrices by name
def sparse(given):
    return {name: scipy.sparse.csr_array(x) for name, x in given.items()}


def mat(path, given):
    return into_mat(path, **sparse(given))


def npz(path, given):
    np.savez(path / "plant.npz", **given, title=np.zeros(3))
    return path / "plant.npz"


def save_npz(path, given):
    for k, (name, x) in enumerate(sparse(given).items()):
        scipy.sparse.save_npz(path / name, x.asformat(["csr", "csc", "coo"][k % 3]))
    return path


def mtx(path, given):
    for name, x in sparse(given).items():
        kind = "symmetric" if name in "MCK" else "general"
        scipy.io.mmwrite(path / f"{name}.mtx", x, symmetry=kind)
    return path


@pytest.mark.filterwarnings("ignore:.*left out")
@pytest.mark.parametrize("write", [mat, npz, save_npz, mtx])
def test_k_is_the_stiffness_and_c_the_damping(write, tmp_path):
    given = frame()
    assert same(load_plant(write(tmp_path, given)), given)


def test_names_of_your_own(tmp_path):
    given = frame()
    K, C = given.pop("K"), given.pop("C")
    file = into_mat(tmp_path, **given, Kaa=K, Daa=C)
    with pytest.raises(
        ValueError, match=r"D, S is missing; M, B, F, Kaa, Daa is there"
    ):
        load_plant(file)
    plant = load_plant(file, {"S": "Kaa", "D": "Daa"})
    assert same(plant, {**given, "K": K, "C": C})
    for names, words in (({"S": "Kbb"}, "Kbb isn't there"), ({"Q": "M"}, "'Q'")):
        with pytest.raises(ValueError, match=words):
            load_plant(file, names)


@pytest.mark.filterwarnings("ignore:.*left out")
def test_a_gain_is_no_stiffness(tmp_path):
    given = frame() | {"K": np.ones((1, 8))}
    with pytest.raises(ValueError, match=r"plant\.mat: K is 1 x 8 .* call that S"):
        load_plant(into_mat(tmp_path, **given))
    right = frame()
    both = right | {"D": right["C"], "S": right["K"], "K": np.ones((4, 4))}
    assert same(load_plant(into_mat(tmp_path, **both)), right)  # S wins


@pytest.mark.filterwarnings("ignore:.*left out")
def test_two_dampings_are_asked_about(tmp_path):
    given = frame()
    file = into_mat(tmp_path, **given, D=np.zeros((4, 4)))
    with pytest.raises(ValueError, match="is C or D the damping"):
        load_plant(file)
    assert same(load_plant(file, {"D": "C"}), given)
    assert load_plant(file, {"D": "D"}).D.any() == 0


def test_json_has_one_set_of_names(tmp_path):
    (tmp_path / "plant.json").write_text(
        '{"M": [[1]], "C": [[1]], "K": [[1]]}', "utf-8"
    )
    words = r"plant\.json: .* 'C' isn't known, call it D; 'K' isn't known, call it S"
    with pytest.raises(ValueError, match=words):
        load_plant(tmp_path / "plant.json")
    with pytest.raises(ValueError, match=".json takes no names"):
        load_plant(tmp_path / "plant.json", {"S": "K"})


def test_one_sparse_matrix_is_no_plant(tmp_path):
    scipy.sparse.save_npz(tmp_path / "M", scipy.sparse.csr_array(ONE))
    with pytest.raises(ValueError, match=r"M\.npz: M, D, S, B is missing"):
        load_plant(tmp_path / "M.npz")
    np.savez(tmp_path / "S.npz", S=ONE)
    with pytest.raises(ValueError, match=r"S\.npz can't be read .*: it holds S"):
        matrix_files.read_sparse(tmp_path / "S.npz")


# ------------------------------------------------------------------ state space
@pytest.mark.parametrize("seed", seeds(6))
def test_second_order_is_recognised_in_any_order_of_rows(seed, tmp_path):
    given = frame(3, seed)
    M = given["M"]
    S, D, B, F = (np.linalg.solve(M, given[x]) for x in "KCBF")
    Z = np.zeros((3, 3))
    A = np.block([[Z, np.eye(3)], [-S, -D]])
    order = [np.arange(6), np.arange(6).reshape(2, 3).T.ravel(), np.roll(range(6), 3)]
    p = [*order, *(np.random.default_rng(seed).permutation(6) for _ in range(3))][seed]
    matrices = {"A": A[np.ix_(p, p)], "B_w": np.vstack([0 * F, F])[p]}
    matrices["B"] = np.vstack([0 * B, B])[p]
    plant = load_plant(into_mat(tmp_path, **sparse(matrices)))
    assert isinstance(plant, SecondOrderSystem)
    found = ordered(plant.poles())
    assert found == pytest.approx(ordered(np.linalg.eigvals(A)), abs=1e-9)
    rows = [i for i in p if i < 3]  # z in the order of the file
    if seed < 3:
        assert rows == [0, 1, 2] and (plant.S == S).all() and (plant.B == B).all()
    with pytest.warns(UserWarning, match="its C is left out"):
        assert load_plant(into_mat(tmp_path, **matrices, C=np.eye(6)[:1])) == plant


def test_an_acceleration_that_is_one_displacement_is_no_velocity(tmp_path):
    """z1'' = z2 looks like z' = x."""
    A = np.array([[0, 0, 1, 0], [0, 0, 0, 1], [0, 1, 0, 0], [-2, 0, 0, -0.3]])
    plant = load_plant(into_mat(tmp_path, A=A, B=np.eye(4)[:, 3:]))
    assert plant.S.tolist() == [[0, -1], [2, 0]]


@pytest.mark.parametrize(
    "changed",
    [
        {"A": np.array([[-1.0, 2.0], [-2.0, -1.0]])},  # modes in blocks
        {"E": np.diag([1.0, 2.0])},
        {"D": np.ones((1, 1))},
        {"B": np.ones((2, 1))},
        {"A": np.diag([-1.0, -2, -3]), "B": np.ones((3, 1)), "C": np.ones((1, 3))},
    ],
)
@pytest.mark.filterwarnings("ignore:.*left out")
def test_what_is_no_second_order_system_stays_a_state_space(changed, tmp_path):
    given = {"A": np.array([[0, 1], [-2, -0.3]]), "B": np.eye(2)[:, 1:]}
    given |= {"C": np.eye(2)[:1], "K": np.ones((1, 2))} | changed
    d = load_plant(into_mat(tmp_path, **given))
    assert isinstance(d, DescriptorSystem)
    (v,) = d.vertices
    assert (v.A == given["A"]).all() and (v.Bu == given["B"]).all()
    assert (v.C == given["C"]).all() and (v.E == given.get("E", np.eye(len(v.A)))).all()
    assert (v.Du is not None) == ("D" in given)


@pytest.mark.filterwarnings("ignore:.*left out")
def test_a_quadratic_pencil_is_asked_about(tmp_path):
    """Collections of eigenvalue problems call M, D and S so."""
    given = frame()
    pencil = {"A": given["M"], "B": given["C"], "C": given["K"]}
    file = into_mat(tmp_path, **sparse(pencil), G=given["B"], F=given["F"])
    with pytest.raises(
        ValueError, match=r"A, B and C are all 4 x 4: for A z'' \+ B z'"
    ):
        load_plant(file)
    names = {"M": "A", "D": "B", "S": "C"}
    with pytest.raises(ValueError, match=r"plant\.mat: B is missing"):
        load_plant(file, names)
    assert same(load_plant(file, names | {"B": "G"}), given)
    assert isinstance(load_plant(file, {"A": "A"}), DescriptorSystem)


@pytest.mark.parametrize(
    "given, words",
    [
        ({"A": np.ones((2, 3))}, "A has 3 columns|E has"),
        ({"A": np.eye(2), "B": np.ones((3, 1))}, "B has 3 rows, needs 2"),
        ({"A": np.eye(2), "E": np.ones((2, 2))}, "E is singular"),
        ({"A": np.eye(2), "D": np.ones((1, 1))}, "D_u is given without C"),
        ({"B": np.eye(2), "C": np.eye(2)}, "M, D, S is missing|M, S is missing"),
        ({"A": 1j * np.eye(2)}, "A must be a real matrix: it has complex entries"),
    ],
)
def test_a_state_space_that_is_none_is_named(given, words, tmp_path):
    with pytest.raises(ValueError, match=rf"plant\.mat: ({words})"):
        load_plant(into_mat(tmp_path, **given))


# ----------------------------------------------------------------------- Abaqus
def abaqus(path, name, x, half=True, head=""):
    """Node 7 before node 40, each with the dofs 1 and 2; zeros aren't written."""
    dofs = [(7, 1), (7, 2), (40, 1), (40, 2)]
    lines = [
        f"{dofs[i][0]},{dofs[i][1]}, {dofs[j][0]},{dofs[j][1]}, {x[i, j]:.16e}"
        for j in reversed(range(4))
        for i in range(4)
        if x[i, j] and (i >= j or not half)
    ]
    (path / f"{name}.mtx").write_text(head + "\n".join(lines) + "\n", "utf-8")


def elements(path, **changed):
    given = frame() | {"F": np.zeros((4, 0))} | changed
    for name in "MCK":
        abaqus(path, name, given[name], head="** MATRIX\n*MATRIX, TYPE=STIFFNESS\n")
    np.save(path / "B.npy", given["B"])
    return given


def test_abaqus_writes_half_of_a_symmetric_matrix(tmp_path):
    given = elements(tmp_path)
    plant = load_plant(tmp_path)
    assert same(plant, given)
    assert plant.coordinates == ("7.1", "7.2", "40.1", "40.2")
    skew = given["C"] + np.eye(4, k=1) - np.eye(4, k=-1)  # gyroscopic: both halves
    abaqus(tmp_path, "C", skew, half=False)
    assert (load_plant(tmp_path).D == skew).all()


def test_supports_by_penalties_are_named_and_left_out(tmp_path):
    K = frame()["K"] + np.diag([0, 1e36, 0, 1e36])
    given = elements(tmp_path, K=K)
    with pytest.raises(
        ValueError, match=r"S has 1e\+36 .*without=\[1, 3\] \(7\.2, 40\.2"
    ):
        load_plant(tmp_path)
    keep = [0, 2]
    left = {x: given[x][np.ix_(keep, keep)] for x in "MCK"}
    plant = load_plant(tmp_path, without=[1, 3])
    assert same(plant, left | {x: given[x][keep] for x in "BF"})
    assert plant.coordinates == ("7.1", "40.1")
    for wrong in ([4], [-1], [0.5]):
        with pytest.raises(ValueError, match="without must be rows from 0 to 3"):
            load_plant(tmp_path, without=wrong)


@pytest.mark.parametrize(
    "text, words",
    [
        ("1,1, 1,1", r"M\.mtx, line 1: .* is neither 'node, dof"),
        ("1,1, 1,1, 1\n\n1,1, 1,1, 2", r"line 3: .* is there twice"),
        ("1,1, 1,1, 1f5", r"line 1: '1f5' is no number"),
        ("1,1, 1,-1, 1", r"line 1: .* is neither"),
        ("1 2 3 2.0", r"line 1: .* is neither"),
        ("1 1 2.0\n1,1, 1,1, 1", r"line 2: some lines have nodes"),
        ("", r"M is empty|M has 0 rows|S has 4 rows, needs"),
    ],
)
def test_a_broken_file_of_abaqus_has_its_line(text, words, tmp_path):
    elements(tmp_path)
    (tmp_path / "M.mtx").write_text(text, "utf-8")
    for name in "CK":
        (tmp_path / f"{name}.mtx").unlink()
        np.save(tmp_path / f"{name}.npy", ONE)
    with pytest.raises(ValueError, match=words):
        load_plant(tmp_path)


def bar(n):
    """A sparse bar with dampers and a force in the middle."""
    T = scipy.sparse.diags(
        [-np.ones(n - 1), 2 * np.ones(n), -np.ones(n - 1)], [-1, 0, 1]
    )
    one = scipy.sparse.identity(n)
    return {
        "M": 0.3 * one,
        "C": 1e-3 * T + one,
        "K": 9.81 * T,
        "B": one.tocsc()[:, [7]],
    }


def abaqus_of_sparse(path, given):
    for name in "MCK":
        x = given[name].tocoo()
        entries = zip(x.row.tolist(), x.col.tolist(), x.data.tolist())
        lines = [f"{i + 1},1, {j + 1},1, {v!r}" for i, j, v in entries]
        (path / f"{name}.mtx").write_text("\n".join(lines) + "\n", "utf-8")
    np.save(path / "B.npy", given["B"].toarray())
    return path


@pytest.mark.parametrize("write", [mat, abaqus_of_sparse, *campaign([save_npz, mtx])])
def test_large_sparse_matrices_stay_sparse(write, tmp_path, monkeypatch):
    """A full matrix of these would take 32 MB, and was refused as too large."""
    n, given = 2000, bar(2000)
    path = write(tmp_path, given)
    monkeypatch.setattr(reading, "MOST_BYTES", 2_000_000)  # else room for so much
    tracemalloc.start()
    plant = load_plant(path)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 16e6
    for name, own in zip("MDS", "MCK"):
        kept = getattr(plant, name)
        assert scipy.sparse.issparse(kept) and (kept != given[own]).nnz == 0
    assert (plant.B == given["B"].toarray()).all()
    held = load_plant(path, without=[0, n - 1])
    assert held.n == n - 2 and (held.S != given["K"].tocsc()[1:-1][:, 1:-1]).nnz == 0


def test_what_unpacks_to_too_much_is_refused(tmp_path, monkeypatch):
    file = tmp_path / "plant.mat"
    scipy.io.savemat(file, sparse(bar(1200)), do_compression=True)
    assert load_plant(tmp_path / "plant.mat").n == 1200
    monkeypatch.setattr(matrix_files, "MOST_BYTES", 80_000)
    with pytest.raises(ValueError, match="unpacks to more than 80000 bytes"):
        load_plant(tmp_path / "plant.mat")
    for kind in ("B", "F"):  # never sparse in a plant
        monkeypatch.undo()
        mat(tmp_path, bar(1200) | {kind: scipy.sparse.csc_array((1200, 19_000))})
        with pytest.raises(ValueError, match="1200 x 19000, too large"):
            load_plant(tmp_path / "plant.mat")


# ------------------------------------------------------------------------- HDF5
def hdf5(path, given, h5py, matlab):
    """As MATLAB 7.3 lays matrices out, or as h5py does."""
    with h5py.File(path, "w", userblock_size=512 if matlab else 0) as file:
        for name, x in given.items():
            if matlab and name == "K":
                x = scipy.sparse.csc_array(x)
                group = file.create_group(name)
                group.attrs["MATLAB_sparse"] = np.uint64(x.shape[0])
                for key, part in (
                    ("data", x.data),
                    ("ir", x.indices),
                    ("jc", x.indptr),
                ):
                    group[key] = part
            else:
                file[name] = x.T if matlab else x
            if matlab:
                file[name].attrs["MATLAB_class"] = np.bytes_("double")
        file["elsewhere"] = h5py.ExternalLink("other.h5", "/x")


@pytest.mark.parametrize("matlab", [True, False])
def test_hdf5_is_read(matlab, tmp_path):
    h5py = pytest.importorskip("h5py")
    given = frame() | {"K": frame()["K"] + np.eye(4, k=1)}  # K' isn't K
    file = tmp_path / ("plant.mat" if matlab else "plant.h5")
    hdf5(file, given, h5py, matlab)
    assert same(load_plant(file), given)


@pytest.mark.parametrize("part", ["data", "ir", "jc", "S"])
def test_no_dataset_of_hdf5_reads_another_file(part, tmp_path):
    h5py = pytest.importorskip("h5py")
    x = scipy.sparse.csc_array(np.diag([2.0, 9.81]))
    parts = {"data": x.data, "ir": x.indices, "jc": x.indptr, "S": x.toarray()}
    secret = tmp_path / "secret.bin"
    secret.write_bytes(parts[part].tobytes())
    place, kind = [(str(secret), 0, h5py.h5f.UNLIMITED)], dict(dtype=parts[part].dtype)
    with h5py.File(tmp_path / "x.h5", "w") as file:
        for name in "MDB":
            file[name] = np.eye(2)
        home = file if part == "S" else file.create_group("S")
        home.attrs["MATLAB_sparse"] = 2
        for key in parts.keys() - {part, "S"} if part != "S" else ():
            home[key] = parts[key]
        home.create_dataset(part, parts[part].shape, external=place, **kind)
    with pytest.raises(ValueError, match=f"numbers of {part} are in another file"):
        load_plant(tmp_path / "x.h5")


def test_of_a_file_only_the_plant_is_read_within_a_budget(tmp_path, monkeypatch):
    """Of datasets without numbers a few bytes promise gigabytes."""
    h5py = pytest.importorskip("h5py")
    for name, more in (("x", ()), ("y", "MDS")):
        with h5py.File(tmp_path / f"{name}.h5", "w") as file:
            for key in "MDSB":
                large = (5000, 4000) if key in more else (1, 1)
                file.create_dataset(key, large, dtype="f4", fillvalue=1)
            for k in range(3):
                file.create_dataset(f"unused {k}", 20_000_000, dtype="S200")
    with pytest.raises(ValueError, match="unpacks to 48000000. bytes"):
        load_plant(tmp_path / "y.h5")
    monkeypatch.setattr(reading, "MOST_BYTES", 5_000_000)  # else room for so much
    tracemalloc.start()
    with pytest.warns(UserWarning, match="left out: unused 0"):
        assert load_plant(tmp_path / "x.h5").n == 1
    assert tracemalloc.get_traced_memory()[1] < 2e7
    tracemalloc.stop()
    np.savez_compressed(tmp_path / "x.npz", **frame(), unused=np.zeros(26_000_000))
    with pytest.warns(UserWarning, match="left out: unused"):
        assert load_plant(tmp_path / "x.npz").n == 4
    for name in "MDB":
        np.save(tmp_path / f"{name}.npy", ONE)
    for head, words in {
        "2 2 4000000000\n1 1 1": "promises 4000000000 entries and has",
        "2 2 2\n1 1 1\n1 1 5": "row 1, column 1 is there twice",
    }.items():
        text = f"%%MatrixMarket matrix coordinate real general\n{head}\n"
        (tmp_path / "S.mtx").write_text(text, "utf-8")
        with pytest.raises(ValueError, match=words):
            load_plant(tmp_path)


@pytest.mark.parametrize("index", [10**6, -7])
def test_an_index_outside_of_a_sparse_matrix_is_refused(index, tmp_path):
    """Compiled code read and wrote there, which ended Python."""
    x = scipy.sparse.csc_array(ONE)
    x.indices[1] = index
    scipy.sparse.save_npz(tmp_path / "x.npz", x)
    into_mat(tmp_path, M=x)
    for name, read in (("x.npz", "read_sparse"), ("plant.mat", "read_mat")):
        with pytest.raises(ValueError, match="indices must be"):
            getattr(matrix_files, read)(tmp_path / name)


def test_without_h5py_the_cure_is_named(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "h5py", None)
    for name in ("plant.mat", "plant.h5"):
        (tmp_path / name).write_bytes(b"\x89HDF\r\n\x1a\n" + bytes(600))
        words = rf"{name} can't be read .*save with '-v7'.*sosbook\[hdf5\]"
        with pytest.raises(ValueError, match=words):
            load_plant(tmp_path / name)


# --------------------------------------------------------------- the manual's page
def coordinates(x, between):
    return "\n".join(
        f"{i + 1}{between}{j + 1}{between}{float(x[i, j])!r}" for i, j in np.argwhere(x)
    )


def test_the_lines_of_the_manual_run(tmp_path, monkeypatch):
    given, B = frame(), np.eye(4)[:, :1]
    massless = given | {"M": np.diag([1.0, 0, 1, 0]), "C": np.zeros((4, 4))}
    own = {"M": given["M"], "Daa": given["C"], "Kaa": given["K"], "B": B}
    A = np.block([[np.zeros((4, 4)), ONE], [-given["K"], -given["C"]]])
    folders = "sparse market abaqus penalties calculix entries harwell gyro"
    for folder in folders.split():
        (tmp_path / folder).mkdir()
    for name, x in {
        "plant": given,
        "struct": {"sys": given},
        "slicot": {"A": A, "B": np.vstack([0 * B, B]), "C": np.eye(8)[:1]},
        "dslin": {"ABCD": np.block([[A, np.vstack([0 * B, B])]]), "nx": 8},
        "massless": massless,
        "own": own,
        "circuit": {"E": np.diag([1.0, 2, 0]), "A": -np.eye(3), "B": np.ones((3, 1))},
    }.items():
        scipy.io.savemat(tmp_path / f"{name}.mat", x)
    npz(tmp_path, given)
    aset = dict(MAA=given["M"], BAA=given["C"], KAA=given["K"], PA=B)
    (tmp_path / "plant.op4").write_bytes(binary_op4(aset))
    model(tmp_path).rename(tmp_path / "wing.pch")
    save_npz(tmp_path / "sparse", given)
    mtx(tmp_path / "market", given)
    elements(tmp_path / "abaqus")
    for end, name in ((".sti", "K"), (".mas", "M")):
        lines = coordinates(given[name], " ")
        (tmp_path / "calculix" / f"job{end}").write_text(lines, "utf-8")
    (tmp_path / "calculix" / "job.dof").write_text("7.1\n7.2\n9.1\n9.2", "utf-8")
    for name, x in given.items():
        text = "row,column,value\n" + coordinates(x, ",")
        (tmp_path / "entries" / f"{name}.csv").write_text(text, "utf-8")
    for name in "MK":
        text = harwell(scipy.sparse.csc_array(given[name]))
        (tmp_path / "harwell" / f"{name}.rsa").write_text(text, "utf-8")
    for name, x in given.items():
        scipy.io.mmwrite(tmp_path / "x.mtx", x)
        as_E = name.replace("C", "E")
        (tmp_path / "x.mtx").rename(tmp_path / "gyro" / f"gyro.{as_E}")
    elements(tmp_path / "penalties", K=given["K"] + np.diag([0, 1e36, 0, 1e36]))
    import sympy  # takes two seconds

    names = {"load_plant": load_plant, "np": np, "sos": sosbook, "sympy": sympy}
    names |= dict(w=np.arange(1, 4), zeta=0.01, Phi=np.ones((4, 3)), B=B)
    names["system"] = control.ss(A, np.vstack([0 * B, B]), np.eye(8)[:1], 0)
    orders, page = [], MANUAL.read_text("utf-8")
    lines = re.findall(r"\| `((?:load_plant|sos\.).*)` \|$", page, re.M)
    assert len(lines) == page.count("\n| ") - 2
    monkeypatch.chdir(tmp_path)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # SLICOT's C
        for line in lines:
            if ".h5" not in line:  # `test_hdf5_is_read`
                plant = eval(line, names)
                orders.append(getattr(plant, "order", plant.n))
    assert orders == [*[4] * 10, 2, 2, *[4] * 5, 2, 3, 8, 2]


def blocks_of_the_manual():
    return re.findall(r"^```python\n(.*?)^```", MANUAL.read_text("utf-8"), re.M | re.S)


def test_the_equations_with_symbols_of_the_manual_become_a_family():
    names, blocks = {}, blocks_of_the_manual()
    exec(blocks[0], names)
    plants = names["plants"]
    assert plants.degree == {"m": 1, "k": 1} and len(plants.vertices) == 4
    one = plants.at(m=1.5, k=3.25)
    assert (one.M == np.diag([1.5, 1])).all()
    assert (one.S == [[5.25, -2], [-2, 2]]).all()
    exec(blocks[1], names)
    (cart,) = names["cart"].vertices
    assert (cart.A == [[0, 1], [-4, 0]]).all() and (cart.Bu == [[0], [0.5]]).all()


class Data:
    """What views live in: they hold nothing once it is gone, as in Pinocchio."""

    def __init__(self, matrices):
        self.views = [x.copy() for x in matrices]

    def __del__(self):
        for x in self.views:
            x[:] = np.nan


def test_the_lines_for_simulators_run_on_stand_ins():
    given = [frame()[x] + (x == "C") * np.eye(4, k=1) for x in "KCM"]

    def derivatives(model, data, q, v, a):
        assert len(q) == 5 and not np.any(v) and not np.any(a)
        return tuple(data.views)

    def inverse(model, data, eps, centered, DfDq, DfDv, DfDa, *rest):
        assert (eps, centered, rest) == (1e-6, 1, (None,) * 4)
        DfDq[:], DfDv[:], DfDa[:] = (x.T for x in given)
        DfDa[0, 1] += 1e-9  # a finite difference

    model = SimpleNamespace(nv=4, createData=lambda: Data(given))
    names = {"np": np, "sos": sosbook, "q": np.zeros(5), "selection": np.eye(4)}
    names |= {"model": model, "data": None}
    names["pinocchio"] = SimpleNamespace(computeRNEADerivatives=derivatives)
    names["mujoco"] = SimpleNamespace(mjd_inverseFD=inverse)
    blocks = blocks_of_the_manual()
    assert len(blocks) == 4
    for code in blocks[2:]:
        exec(code, names)
        plant = names["plant"]
        for x, own in zip("SDM", given):
            assert_allclose(getattr(plant, x), own, atol=1e-8)
