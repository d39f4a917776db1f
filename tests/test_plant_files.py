"""Plants from files: every kind gives the same plant, and faults have a place."""

import json

import numpy as np
import pytest
import scipy.io
import scipy.sparse

from sosbook import Polytope, SecondOrderSystem, Uncertain, design_pid
from sosbook.plants import load_plant
from sosbook.plants.files import plant_and_asked
from sosbook.proofs.command import main

MATRICES = {
    "M": np.diag([2.0, 1.0]),
    "D": np.array([[0.4, -0.1], [-0.1, 0.2]]),
    "S": np.array([[6.0, -2.0], [-2.0, 4.0]]),
    "B": np.array([[1.0], [0.25]]),
    "F": np.eye(2),
}
PLANT = SecondOrderSystem(**MATRICES)
ONE = {name: [[1]] for name in "MDSB"}


def csv(folder, **matrices):
    for name, matrix in matrices.items():
        np.savetxt(folder / f"{name}.csv", matrix, delimiter=",")
    return folder


def npy(folder):
    for name, matrix in MATRICES.items():
        np.save(folder / f"{name}.npy", matrix)
    return folder


def mtx(folder):
    for name, matrix in MATRICES.items():
        scipy.io.mmwrite(folder / f"{name}.mtx", scipy.sparse.coo_array(matrix))
    return folder


def npz(folder):
    np.savez(folder / "plant.npz", **MATRICES, note=np.zeros(1))
    return folder / "plant.npz"


def mat(folder):
    scipy.io.savemat(folder / "plant.mat", MATRICES)
    return folder / "plant.mat"


def write(folder, data):
    (folder / "plant.json").write_text(json.dumps(data), "utf-8")
    return folder / "plant.json"


def as_json(folder):
    return write(folder, {name: x.tolist() for name, x in MATRICES.items()})


@pytest.mark.filterwarnings("ignore:.*left out")
@pytest.mark.parametrize("save", [npy, mtx, npz, mat, as_json])
def test_what_numpy_scipy_and_json_write_is_read(save, tmp_path):
    """By itself, and where the file of a design names it."""
    there, request = save(tmp_path), tmp_path / "request.toml"
    name = "." if there == tmp_path else there.name
    request.write_text(f'plant = "{name}"\ngamma = 9', "utf-8")
    assert load_plant(there) == load_plant(request) == PLANT
    assert plant_and_asked(request) == (PLANT, {"gamma": 9})


def test_a_design_of_another_program_s_file(tmp_path, capsys):
    """The gain is the package's; its cures stand beside the name of the file."""
    names, S = {"M": "M", "D": "D", "S": "Kaa", "B": "B"}, np.eye(3) * 1e36
    S[:2, :2] = MATRICES["S"]
    wide = {x: np.pad(MATRICES[x], [[0, 1], [0, x != "B"]]) for x in "MDB"}
    scipy.io.savemat(tmp_path / "plant.mat", wide | {"Kaa": S})
    request, proof = tmp_path / "request.json", str(tmp_path / "proof.json")
    asked = {"plant": {"file": "plant.mat", "names": names}, "U": [[1, 0]]}
    verify = ["verify", proof, "--plant", str(request)]
    for more, code, words in (({}, 2, "Pass without="), ({"without": [2]}, 0, "")):
        asked["plant"] |= more
        request.write_text(json.dumps(asked), "utf-8")
        assert main(["design", str(request), "--proof", proof]) == code
        said = capsys.readouterr()
        assert words in said.err and ('{"file": "plant.mat"' in said.err) is bool(code)
    plain = {x: MATRICES[x] for x in "MDSB"}
    theirs = design_pid(SecondOrderSystem(**plain), [[1, 0]]).certify()
    assert json.loads(said.out)["K"] == theirs.K.tolist() and main(verify) == 0
    request.write_text(json.dumps(asked | {"U": [[0, 1]]}), "utf-8")
    assert main(verify) == 1
    assert main(["design", str(tmp_path / "plant.mat"), "--proof", proof]) == 2
    assert (
        "names, without, condensed, push and rayleigh stand in a file"
        in capsys.readouterr().err
    )


def test_csv_of_a_spreadsheet_is_read(tmp_path):
    assert load_plant(csv(tmp_path, **MATRICES)) == PLANT
    text = "\ufeff# masses in kg\r\n2; 0\r\n\r\n0; 1 # the second\r\n"
    (tmp_path / "M.csv").write_text(text, "utf-8", newline="")
    (tmp_path / "F.csv").unlink()
    assert load_plant(str(tmp_path)) == SecondOrderSystem(
        **{name: x for name, x in MATRICES.items() if name != "F"}
    )


def test_vertices_make_a_polytope_and_the_design_command_reads_the_same(tmp_path):
    light = {name: x.tolist() for name, x in MATRICES.items()}
    heavy = light | {"M": (2 * MATRICES["M"]).tolist()}
    plant = load_plant(write(tmp_path, {"plant": {"vertices": [light, heavy]}}))
    other = SecondOrderSystem(**(MATRICES | {"M": 2 * MATRICES["M"]}))
    assert plant == Polytope([PLANT, other])


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(FileNotFoundError, match="no such file"):
        load_plant(tmp_path / "none.npz")
    csv(tmp_path, M=[[1]], D=[[1]], B=[[1]])
    with pytest.raises(FileNotFoundError, match=r"S\.csv.* is missing"):
        load_plant(tmp_path)


@pytest.mark.parametrize(
    "text, words",
    [
        ("mass\n1", r"M\.csv, line 1: 'mass' is no number; write 0.5 with a point"),
        ("1,2\n3", r"M\.csv, line 2: 1 numbers, the first line has 2"),
        ("# nothing\n", r"M\.csv: there are no numbers"),
        ("1,2\n3,4\n5,6", "M has 2 columns"),
        ("nan", "M has NaN"),
        ("0,5;1,5", r"M\.csv, line 1: .* write 0\.5 with a point"),
        ("0,5 1,5", r"M\.csv, line 1: .* write 0\.5 with a point"),
    ],
)
def test_a_fault_of_a_table_has_its_line(tmp_path, text, words):
    csv(tmp_path, D=[[1]], S=[[1]], B=[[1]])
    (tmp_path / "M.csv").write_text(text, "utf-8")
    with pytest.raises(ValueError, match=words):
        load_plant(tmp_path)


def test_json_names_the_coordinates(tmp_path):
    ranges = {"parameters": {"m": [1, 2]}, "M": [["m"]]}
    for more, kind in (({}, SecondOrderSystem), (ranges, Uncertain)):
        plant = load_plant(write(tmp_path, ONE | {"coordinates": ["motor"]} | more))
        assert isinstance(plant, kind)
        assert plant.vertices[0].coordinates == ("motor",)


def test_two_files_for_one_matrix_are_refused(tmp_path):
    npy(tmp_path)
    csv(tmp_path, M=[[1]])
    with pytest.raises(ValueError, match=r"M is there twice: M\.csv, M\.npy"):
        load_plant(tmp_path)


@pytest.mark.parametrize(
    "data, words",
    [
        ([], "M is missing; D is missing; S is missing; B is missing"),
        ({"M": [[1]]}, "D is missing; S is missing; B is missing"),
        ({key: [[1]] for key in "MDSBf"}, '"plant" for them: .f. isn.t known'),
        (ONE | {"coordinates": [1]}, "coordinates must be 1 different names"),
        (ONE | {"coordinates": 1}, "coordinates must be 1 different names"),
        ({"vertices": []}, "vertices is empty"),
        ({"vertices": {}}, "vertices must be a list"),
        ({"vertices": [{"M": [[1]]}]}, r"vertices\[0\] has M, D, S, B"),
        ({"plant": None}, "M is missing"),
        ({"U": [[1]]}, '"plant" is missing: give'),
        ({"plant": "none.mat"}, "none.mat: there is no such file"),
        ({"plant": "plant.json"}, "plant: .*'plant' isn't known"),
        ({"plant": {"file": 3}}, "plant: the name of a file or folder is needed"),
        ({"plant": {"file": "a.mat", "place": 1}}, "plant: 'place' isn't known"),
        ({"plant": {"file": "a.mat", "names": {"S": 1}}}, "plant: names must be like"),
        ({"plant": {"file": "a.mat", "without": 1}}, "plant: without must be a list"),
        ({"plant": {"file": "a.mat", "condensed": 1}}, "condensed must be true"),
    ],
)
def test_json_that_is_no_plant_is_refused(tmp_path, data, words):
    with pytest.raises((ValueError, FileNotFoundError), match=words):
        load_plant(write(tmp_path, data))


def test_a_broken_or_foreign_file_is_refused(tmp_path):
    for name, words in (
        ("plant.json", "is no JSON file"),
        ("plant.mat", "save with the option"),
        ("plant.txt", "give a file of the kind"),
    ):
        (tmp_path / name).write_text("{", "utf-8")
        with pytest.raises(ValueError, match=words):
            load_plant(tmp_path / name)


def test_a_pickle_is_never_opened(tmp_path):
    """It could run a program of its writer."""
    np.savez(tmp_path / "plant.npz", M=np.array([{}], dtype=object))
    with pytest.raises(ValueError, match=r"plant\.npz"):
        load_plant(tmp_path / "plant.npz")


def test_a_small_f_is_not_dropped(tmp_path):
    ones = dict.fromkeys("MDSBf", np.ones((1, 1)))
    np.savez(tmp_path / "plant.npz", **ones)
    scipy.io.savemat(tmp_path / "plant.mat", ones)
    for name in ("plant.npz", "plant.mat"):
        with pytest.raises(ValueError, match=f"{name}: f isn't read: call it F"):
            load_plant(tmp_path / name)
    with pytest.raises(ValueError, match="f isn't read: call it F"):
        load_plant(csv(tmp_path, **ones))
