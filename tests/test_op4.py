"""Nastran's OUTPUT4 is read in all its forms, and broken files are named."""

import numpy as np
import pytest

from sosbook import SecondOrderSystem
from sosbook.plants import load_plant
from sosbook.runtime.matrix_files import read_op4
from tests.op4_files import ascii_op4, binary_op4

WAYS = "dense", "strings", "large"


def matrices(seed=0):
    """Some with gaps, columns of zeros and sizes by .3 and 9.81."""
    rng = np.random.default_rng(seed)
    x = 9.81 * rng.normal(size=(7, 5)) * (rng.uniform(size=(7, 5)) < 0.6)
    x[:, 2] = 0.0
    return {"KAA": x, "M": 0.3 * np.eye(4), "NULL": np.zeros((2, 3))}


def check(path, tolerance=0.0):
    found = read_op4(path)
    assert list(found) == ["KAA", "M", "NULL"]
    for name, x in matrices().items():
        assert found[name].shape == x.shape
        assert abs(found[name].toarray() - x).max() <= tolerance * 20


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("order", "<>")
@pytest.mark.parametrize("word, single", [(4, False), (4, True), (8, False), (8, True)])
def test_binary_files(tmp_path, way, order, word, single):
    (tmp_path / "x.op4").write_bytes(binary_op4(matrices(), way, order, word, single))
    check(tmp_path / "x.op4", 1e-6 if single and word == 4 else 0.0)


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("form", ["1P,3E23.16", "1P,2E26.16"])
@pytest.mark.parametrize("counts", [1, 2])
def test_files_in_ascii(tmp_path, way, form, counts):
    (tmp_path / "x.op4").write_text(ascii_op4(matrices(), way, form, counts), "utf-8")
    check(tmp_path / "x.op4")


def test_a_plant_of_nastran(tmp_path):
    K = np.array([[3.0, -1], [-1, 2]])
    given = dict(MAA=np.diag([2.0, 0.3]), BAA=0.01 * K, KAA=K, PA=np.eye(2)[:, :1])
    (tmp_path / "x.op4").write_bytes(binary_op4(given, "strings"))
    names = {"M": "MAA", "D": "BAA", "S": "KAA", "B": "PA"}
    assert load_plant(tmp_path / "x.op4", names) == SecondOrderSystem(*given.values())
    with pytest.raises(ValueError, match="MAA, BAA, KAA, PA is there: pass names="):
        load_plant(tmp_path / "x.op4")


def test_broken_files_are_named(tmp_path):
    good, text = binary_op4(matrices()), ascii_op4(matrices())
    cut = text.splitlines(keepends=True)
    broken = {
        good[:-3]: "ends in the middle",
        good[: 24 + 8]: "has no last column",
        good[:28] + b"abcd" + good[32:]: "isn't as long",
        binary_op4({"A": np.eye(2)}) * 2: "'A' is there twice",
        good[:16] + b"\x04" + good[17:]: "only real matrices",
        good[:4] + b"\x02" + good[5:]: "",
        text.encode() * 2: "'KAA' is there twice",
        "".join(cut[:4]).encode(): "has no last column",
        "".join([cut[0], *cut[2:]]).encode(): "numbers without a head",
        "".join([*cut[:2], *cut[3:]]).encode(): "column . of KAA is shorter",
        text.replace("       2KAA", "       3KAA").encode(): "only real matrices",
        b"some words": "no head of a matrix",
        "é".encode(): "",
        text.replace("       5       7", "      -5       7").encode(): "",
        text.replace("       5       7", "99999999       7").encode(): "too large",
    }
    for content, words in broken.items():
        (tmp_path / "x.op4").write_bytes(content)
        with pytest.raises(ValueError, match=f"x.op4 can't be read as .*{words}"):
            read_op4(tmp_path / "x.op4")
