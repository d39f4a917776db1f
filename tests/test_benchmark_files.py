"""Files of public benchmarks: Harwell-Boeing, descriptor systems, and their letters."""

import re

import numpy as np
import pytest
import scipy.io
import scipy.sparse as sp
from numpy.testing import assert_allclose

from sosbook.plants import load_plant
from sosbook.plants.files import plant_and_asked
from sosbook.runtime.matrix_files import read_harwell
from tests.test_cures import refusal
from tests.test_punch import arguments_in

K3 = np.array([[3.0, -1, 0], [-1, 2, -1], [0, -1, 1]])
M3, C3, B3 = np.diag([1, 2, 1.5]), 0.1 * K3, np.eye(3)[:, 1:2]
OUT = np.array([[0.0, 0, 9.81]])
SHAPES = "(16I5)", "(20I4)", "(1P,3D26.17)"  # of pointers, rows and numbers


def in_fields(values, form):
    """Lines of numbers as Fortran writes them in a format."""
    each, letter, width, _, digits = re.search(
        r"(\d+)([IED])(\d+)(\.(\d+))?", form
    ).groups()
    how = f"{width}d" if letter == "I" else f"{width}.{digits}E"
    words = [format(x, how).replace("E", letter) for x in values]
    return ["".join(words[k : k + int(each)]) for k in range(0, len(words), int(each))]


def harwell(X, kind="RSA", shapes=SHAPES, right=0):
    """A matrix in Harwell and Boeing's layout; with None right sides Rutherford's."""
    X = sp.csc_array(sp.tril(X) if kind[1] in "SZ" else X)
    X.sort_indices()
    data = X.data.astype(int) if shapes[2].count("I") else X.data
    parts = map(in_fields, (X.indptr + 1, X.indices + 1, data), shapes)
    parts = [*parts, ["  1.0"] * (right or 0)]
    counts = [len(x) for x in parts[: 3 if right is None else 4]]
    head = [f"{'a structure':72}KEY     "]
    head += ["".join(f"{x:14d}" for x in (sum(map(len, parts)), *counts))]
    head += [f"{kind:14}" + "".join(f"{x:14d}" for x in (*X.shape, X.nnz, 0))]
    head += ["{:16}{:16}{:20}".format(*shapes)] + ["F"] * bool(right)
    return "\n".join([*head, *sum(parts, [])]) + "\n"


def random(rows, columns, seed=0):
    return sp.csc_array(sp.random(rows, columns, 0.2, random_state=seed))


@pytest.mark.parametrize("kind", ["RSA", "RZA", "RUA", "RRA", "IUA", "rsa"])
@pytest.mark.parametrize("right", [0, None])
def test_matrices_of_harwell_and_boeing(kind, right, tmp_path):
    """Also where numbers fill their fields, so that nothing stands between them."""
    own = kind.upper()
    X = random(40, 30 if own[1] == "R" else 40)
    if own[1] in "SZ":
        X = X + X.T if own[1] == "S" else X - X.T
    X = sp.csc_array(np.rint(50 * X.toarray())) if own[0] == "I" else X
    numbers = "(8I5)" if own[0] == "I" else "(3E24.17)"
    for shapes in (SHAPES[:2] + (numbers,), ("(6I10)", "(40I2)", numbers)):
        text = harwell(X, own, shapes, right).replace(own, kind)
        (tmp_path / "x.rb").write_text(text, "utf-8")
        assert abs(read_harwell(tmp_path / "x.rb") - X).max() < 1e-15
    if own[1] == "U":
        scipy.io.hb_write(tmp_path / "x.rua", X)
        assert abs(read_harwell(tmp_path / "x.rua") - X).max() < 1e-12


def test_a_structure_in_files_of_ansys(tmp_path):
    for name, X in {"bcsstk": K3, "bcsstm": M3}.items():
        (tmp_path / f"{name}.RSA").write_text(harwell(X, right=2), "utf-8")
    more = dict(push=[1], rayleigh=(0, 0.1))
    assert "bcsstk, bcsstm" in refusal_of(tmp_path, **more)
    with pytest.warns(UserWarning, match="right-hand sides are left out"):
        plant = load_plant(tmp_path, {"M": "bcsstm", "S": "bcsstk"}, **more)
    for X, Y in ((plant.M, M3), (plant.D, C3), (plant.S, K3), (plant.B, B3)):
        assert_allclose(X, Y, atol=1e-15)


def refusal_of(path, **more):
    with pytest.raises((ValueError, FileNotFoundError)) as error:
        load_plant(path, **more)
    return str(error.value)


@pytest.mark.parametrize(
    "old, new, words",
    [
        ("RSA", "PSA", "a pattern and no numbers"),
        ("RSA", "CSA", "Matrix Market"),
        ("RSA", "RSE", "real assembled"),
        ("(16I5)", "(16X5)", "isn't that of Harwell"),
        ("    1    3", "    x    3", "line 5: .* no whole number"),
        ("1.00000000000000000D+00", "                  10000", "no point"),
        ("1.00000000000000000D+00", "                   1.25", "no exponent"),
        ("             5  ", "             6  ", "promises 6"),
        ("   3\n", "   4\n", "indices must be < 3"),
    ],
)
def test_a_broken_matrix_of_harwell_is_named(old, new, words, tmp_path):
    text = harwell(K3)
    assert old in text
    (tmp_path / "x.rsa").write_text(text.replace(old, new, 1), "utf-8")
    with pytest.raises(ValueError, match=words):
        read_harwell(tmp_path / "x.rsa")


def test_letters_of_benchmarks(tmp_path):
    """M, E, K, B beside outputs C of another size, as reductions are compared on."""
    given = dict(M=M3, K=K3, B=B3, C=OUT)
    for name, X in given.items():
        scipy.io.mmwrite(tmp_path / "x.mtx", sp.coo_array(X))
        (tmp_path / "x.mtx").rename(tmp_path / f"beam.{name}")
    scipy.io.savemat(tmp_path / "x.mat", given)
    scipy.io.savemat(tmp_path / "E.mat", given | {"E": sp.csc_array(C3)})
    for place in tmp_path, tmp_path / "x.mat":
        assert "C is 1 x 3 and M has 3 rows" in refusal_of(place)
        with pytest.warns(UserWarning, match="left out: C$"):
            plant = load_plant(place, rayleigh=(0, 0))
        assert not plant.D.any() and (plant.S == K3).all()
    asked = eval(f"dict({arguments_in(refusal_of(tmp_path / 'E.mat'))})")
    with pytest.warns(UserWarning, match="left out: C$"):
        assert (load_plant(tmp_path / "E.mat", **asked).D == C3).all()
    scipy.io.savemat(tmp_path / "x.mat", given | {"C": C3})
    assert "C is there: leave rayleigh out" in refusal_of(
        tmp_path / "x.mat", rayleigh=(1, 0)
    )


def response(s, E, A, B, C, D=None):
    D = 0.0 if D is None else D
    return C @ np.linalg.solve(s * E - A, B) + D


@pytest.mark.parametrize("unit", [0.3, 9.81])
@pytest.mark.parametrize("mixed", [False, True])
def test_states_without_a_derivative_are_solved_for(unit, mixed, tmp_path):
    rng = np.random.default_rng(4)
    A, B, C, B_w = (
        rng.normal(size=x).round(2) for x in ((5, 5), (5, 2), (2, 5), (5, 1))
    )
    E = np.diag([1.0, 2, 0, 0, 3])
    if mixed:
        left, right = (rng.integers(-3, 4, x) for x in ((5, 3), (3, 5)))
        E = (left @ right).astype(float)
    given = dict(E=sp.csc_array(E), A=unit * A, B=B, C=C, B_w=B_w)
    scipy.io.savemat(tmp_path / "x.mat", given)
    assert "pass condensed=True" in refusal_of(tmp_path / "x.mat")
    (v,) = load_plant(tmp_path / "x.mat", condensed=True).vertices
    assert len(v.E) == 3
    for s in (0.7 + 0.3j, -2j):
        for given_B, own, through in ((B, v.Bu, v.Du), (B_w, v.Bw, v.Dw)):
            truth = response(s, E, unit * A, given_B, C)
            assert_allclose(response(s, v.E, v.A, own, v.C, through), truth, rtol=1e-9)
    (tmp_path / "p.json").write_text(
        '{"plant": {"file": "x.mat", "condensed": true}}', "utf-8"
    )
    assert plant_and_asked(tmp_path / "p.json")[0].order == 3
    given["A"] = np.diag([1.0, 1, 0, 0, 1])  # of index two or no system at all
    scipy.io.savemat(tmp_path / "x.mat", given)
    if not mixed:
        assert "condensed" not in refusal_of(tmp_path / "x.mat")
        assert "don't follow the others" in refusal_of(
            tmp_path / "x.mat", condensed=True
        )


def test_what_is_empty_in_matlab_is_not_there(tmp_path):
    none, A = np.zeros((0, 0)), np.array([[0.0, 2], [-9.81, -0.3]])
    own = dict(A=A, B=B3[:2], C=np.eye(2), D=np.zeros((2, 1)), E=none)
    scipy.io.savemat(tmp_path / "x.mat", {"sys": own})
    assert load_plant(tmp_path / "x.mat").order == 2
    scipy.io.savemat(tmp_path / "x.mat", dict(M=M3, D=none, S=K3, B=none))
    assert "D, B is missing" in refusal_of(tmp_path / "x.mat")
    assert load_plant(tmp_path / "x.mat", rayleigh=(1, 0), push=[0]).m == 1


def test_shapes_and_numbers_that_need_a_word(tmp_path):
    file = tmp_path / "x.mat"
    own = dict(M=M3, C=C3, K=K3, B=B3)

    def with_(**changed):
        scipy.io.savemat(file, own | changed)
        return file

    assert "give numpy.diag(M)" in refusal(load_plant, with_(M=np.diag(M3)))
    assert "B is 1 x 3: transpose it" in refusal(load_plant, with_(B=B3.T))
    for S in K3 + 0j, sp.csc_array(K3 + 0j):
        assert (load_plant(with_(K=S)).S == K3).all()
    cyclic = K3 + 1j * np.array([[0, 2, 0], [-2, 0, 0], [0, 0, 0]])
    told = refusal(load_plant, with_(K=cyclic))
    both = eval(
        re.search(r"as (np\..*?\]\])\)", told)[1] + ")", {"np": np, "X": cyclic}
    )
    truth = np.linalg.eigvalsh(cyclic)
    assert_allclose(np.linalg.eigvalsh(both), np.repeat(truth, 2))
    with pytest.warns(UserWarning, match="column 1 of B is zero"):
        load_plant(with_(B=np.hstack([B3, 0 * B3])))
    with pytest.warns(UserWarning, match="left out: G; if G is gyroscopic, add it"):
        load_plant(with_(G=cyclic.imag))
    (tmp_path / "packed").mkdir()
    (tmp_path / "packed" / "M.mtx.gz").write_bytes(b"1")
    assert "not read: M.mtx.gz, which are packed" in refusal_of(tmp_path / "packed")
