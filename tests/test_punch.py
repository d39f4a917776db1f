"""Nastran's punch files, and what no program of finite elements writes."""

import re

import numpy as np
import pytest
import scipy.io

import sosbook as sos
from sosbook.plants.files import load_plant

NODES = [(7, 3), (21, 1), (21, 3), (103, 5)]
M = np.diag([2.0, 1.0, 0.3, 9.81e-4])
S = np.diag([3.0, 2.5e3, 4, 9e5])
S[[0, 1, 1, 2, 2, 3], [1, 0, 2, 1, 3, 2]] = -1, -1, -1.25, -1.25, -7, -7
NAMES = {"M": "MAAX", "S": "KAAX"}


def real(x, size):
    """A number as Nastran writes it: an exponent without its letter, if it is short."""
    return f"{x:.9E}".replace("E", "D") if size == 16 else f"{x:.2E}".replace("E", "")


def punched(name, X, size=16, form=6, between=None):
    """A matrix by columns, in fields of 8 or 16 letters, or with commas."""
    star = "*" * (size == 16)

    def line(first, *words):
        if between:
            return between.join([first, *map(str, words)])
        return f"{first:8}" + "".join(f"{w:>{size}}" for w in words)

    head = f"DMIG{star}", f"{name:8}", 0, form, 2 if star else 1
    second = [line("*", 0, "", len(X))]
    lines = [line(*head), *second] if star else [line(*head, 0, "", "", 4)]
    for j in range(len(X)):
        rows = [i for i in range(j if form == 6 else 0, len(X)) if X[i, j]]
        parts = [[*NODES[i], real(X[i, j], size), ""] for i in rows]
        first = [f"{name:8}", *NODES[j], ""]
        if star:
            lines += [line("DMIG*", *first), *(line("*", *part) for part in parts)]
        else:
            lines.append(line("DMIG", *first, *parts[0]))
            for k in range(1, len(parts), 2):
                lines.append(line("+", *sum(parts[k : k + 2], [])))
    return "\n".join(lines)


def file(path, *parts):
    path = path / "model.pch"
    path.write_text("\n".join(["$TITLE = A WING", *parts, "ENDDATA"]), "utf-8")
    return path


def model(path):
    return file(path, punched("KAAX", S), punched("MAAX", M))


FORMS = [(16, 6, None), (16, 1, None), (8, 6, None), (8, 1, ",")]


@pytest.mark.parametrize("size, form, between", FORMS)
def test_matrices_of_a_punch_file(size, form, between, tmp_path):
    how = size, form, between
    path = file(tmp_path, punched("KAAX", S, *how), punched("MAAX", M, *how))
    plant = load_plant(path, NAMES, push=["21.3", "103.5"], rayleigh=(0.3, 1e-4))
    assert plant.S == pytest.approx(S, rel=5e-3 if size == 8 else 1e-9)
    assert plant.M == pytest.approx(M, rel=5e-3 if size == 8 else 1e-9)
    assert plant.coordinates == ("7.3", "21.1", "21.3", "103.5")
    assert (plant.B == np.eye(4)[:, 2:]).all()
    assert plant.D == pytest.approx(0.3 * plant.M + 1e-4 * plant.S)
    same = load_plant(path, NAMES, push=[2, 3], rayleigh=(0.3, 1e-4), without=[0])
    assert same.coordinates == ("21.1", "21.3", "103.5")
    assert (same.B == np.eye(4)[1:, 2:]).all()
    assert sos.design_pid(plant).status == "feasible"


@pytest.mark.parametrize(
    "wrong, words",
    [
        ((f"{7:16}", f"{'7x':>16}"), "'7x' is no whole number"),
        ((f"{0:16}{6:16}", f"{3:16}{1:16}"), "KAAX has no head"),
        ((f"{6:16}{2:16}", f"{9:16}{2:16}"), "form 9"),
        ((f"{6:16}{2:16}", f"{6:16}{4:16}"), "type 4"),
        (("D+00", "D+xx"), "isn't a number|no number"),
    ],
)
def test_a_card_that_is_no_entry_is_named(wrong, words, tmp_path):
    text = punched("KAAX", S)
    assert wrong[0] in text
    path = file(tmp_path, text.replace(*wrong), punched("MAAX", M))
    with pytest.raises(ValueError, match=words) as fault:
        load_plant(path, NAMES, push=[0], rayleigh=(0, 0))
    assert "line" in str(fault.value)


@pytest.mark.parametrize(
    "beside, words",
    [
        (dict(push=["21.2"]), "none of 0 to 3 or of 7.3, 21.1"),
        (dict(push=[4]), "none of 0 to 3"),
        (dict(push=[True]), "none of 0 to 3"),
        (dict(push="21.3"), "push must be a list"),
        (dict(push=[1], rayleigh=(-1, 0)), "not below 0"),
        (dict(push=[1], rayleigh=0.3), "rayleigh"),
        (dict(push=[1], names=NAMES | {"B": "KAAX"}), "B is there: leave push out"),
        (dict(), r"add D, or pass rayleigh=.*pass push=\['7.3'\].*of 7.3, 21.1, 21.3"),
    ],
)
def test_what_is_said_beside_a_file_is_checked(beside, words, tmp_path):
    path = model(tmp_path)
    asked = dict(names=NAMES) | beside
    if asked.keys() >= {"push"}:
        asked = dict(rayleigh=(0, 0)) | asked
    with pytest.raises(ValueError, match=words):
        load_plant(path, **asked)


def arguments_in(told):
    """The arguments of `load_plant` that a refusal names, as text; 0 for a and b."""
    found = re.findall(
        r"pass (\w+=(?:\{.*?\}|\[.*?\]|\(.*?\)|True))", told, re.IGNORECASE
    )
    return ", ".join(found).replace("(a, b)", "(0, 1e-3)")


def whole_matrices(n=4):
    return dict(M=M, D=0.1 * M, S=S, B=np.eye(n)[:, :1])


def with_row(row, **more):
    """The matrices with a last row that is nothing but what is ``more``."""
    wide = {x: np.pad(v, [[0, 1], [0, x != "B"]]) for x, v in whole_matrices().items()}
    for name, value in more.items():
        wide[name][-1, row] = value
    return wide


def without_mass():
    still = np.diag([1.0, 1, 1, 0])
    return whole_matrices() | {"M": M * still, "D": M * still}


@pytest.mark.parametrize(
    "given, refusals",
    [
        (None, 2),  # a punch file: names, then B and D
        ({x: whole_matrices()[x] for x in "MS"}, 1),
        ({"Maa": M, "Kaa": S, "Daa": M, "B": np.eye(4)}, 1),
        (with_row(0), 1),
        (with_row(-1, M=1e-3, S=1e36), 1),
        (without_mass(), 1),
        ({"own": {"Mff": M, "Kff": S}}, 2),
        ({"job": {"fe": {"Mff": M, "Kff": S}}}, 2),
        ({"Mass": M, "Damp": M, "Stiff": S, "B": np.eye(4)}, 1),
    ],
)
def test_the_cure_that_a_refusal_names_works(given, refusals, tmp_path):
    """Its arguments are passed as they are written, until the file is read."""
    path = model(tmp_path) if given is None else tmp_path / "plant.mat"
    if given is not None:
        scipy.io.savemat(path, given)
    passed = {}
    for _ in range(refusals):
        with pytest.raises(ValueError) as fault:
            load_plant(path, **passed)
        passed |= eval(f"dict({arguments_in(str(fault.value))})")
    assert load_plant(path, **passed).S.any()


def test_calculix_writes_three_files(tmp_path):
    """One half of each matrix by numbers of rows, and the names of the rows."""
    for end, X in ((".sti", S), (".mas", M)):
        i, j = np.nonzero(np.tril(X))
        lines = [f"{a + 1} {b + 1} {X[a, b]:.13e}" for a, b in zip(i, j)]
        (tmp_path / f"job{end}").write_text("\n".join(lines), "utf-8")
    with pytest.raises(FileNotFoundError, match=r"job\.dof is missing"):
        load_plant(tmp_path, push=["103.5"], rayleigh=(0, 0))
    dofs = "\n".join(f"{node}.{direction}" for node, direction in NODES)
    (tmp_path / "job.dof").write_text(dofs, "utf-8")
    plant = load_plant(tmp_path, push=["103.5"], rayleigh=(0, 0))
    assert (plant.S == S).all() and (plant.M == M).all() and plant.B[3, 0] == 1
    assert plant.coordinates == ("7.3", "21.1", "21.3", "103.5")
    with pytest.raises(ValueError, match="put .sti, .mas and .dof into a folder"):
        load_plant(tmp_path / "job.sti")
    (tmp_path / "job.dof").write_text("7.3 21", "utf-8")
    with pytest.raises(ValueError, match="'21' is no node.direction"):
        load_plant(tmp_path)


def test_a_plant_file_says_it_too(tmp_path):
    path = model(tmp_path)
    (tmp_path / "plant.json").write_text(
        f'{{"plant": {{"file": "{path.name}", "names": {{"M": "MAAX", "S": "KAAX"}}, '
        '"push": ["7.3"], "rayleigh": [0, 0.001]}}',
        "utf-8",
    )
    plant = load_plant(tmp_path / "plant.json")
    assert (plant.B[:, 0] == [1, 0, 0, 0]).all() and not plant.D[0, 2]
