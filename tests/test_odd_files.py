"""Odd files of a plant are read alike by the page and by the package, or by neither."""

import base64
import json
import re
import shutil
import sys
import warnings
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
import scipy.io
import scipy.sparse as sp

import sosbook
from sosbook.book.elements.bench import bench
from sosbook.plants import load_plant
from sosbook.proofs.command import main
from tests.processes import process
from tests.test_punch import arguments_in, model

ASSETS = Path(sosbook.__file__).parent / "book" / "elements" / "assets"
ONE = {name: b"2" for name in "MDSB"}
READ = """globalThis.HTMLElement = class {{}};
const {{read}} = await import({module}), check = await import({checks});
Object.assign(check.refusals, {refusals});
const results = [], suspicion = ({{fields}}) => {{
  const matrix = name => [name, check.parsed(name, fields[name] ?? "")];
  try {{ return check.plant(Object.fromEntries([..."MDSBFU"].map(matrix))); }}
  catch {{ return ""; }}
}};
for (const files of {files}) {{
  const given = files.map(([name, content]) =>
    new File([Uint8Array.from(atob(content), c => c.charCodeAt(0))], name));
  try {{
    const found = await read(given);
    results.push({{...found, odd: suspicion(found)}});
  }}
  catch (error) {{ results.push(error.message); }}
}}
console.log(JSON.stringify(results));
"""


def mat(**matrices):
    stream = BytesIO()
    scipy.io.savemat(stream, matrices, do_compression=True)
    return {"plant.mat": stream.getvalue()}


def table(**changed):
    """One number a matrix as CSV, but for the files by name that are ``changed``."""
    own = {name.replace("_", "."): text for name, text in changed.items()}
    left = ONE.keys() - {name.partition(".")[0] for name in own}
    there = {name: text.encode() for name, text in own.items() if text is not None}
    return there | {f"{name}.csv": ONE[name] for name in left}


def words(text):
    return {"plant.json": text.encode()}


def market(kind, lines):
    head = f"%%MatrixMarket matrix coordinate real {kind}"
    count = len(lines.splitlines())
    return table(**WHOLE, S_mtx=f"{head}\n2 2 {count}\n{lines}\n")


PLAIN = '"M": [[2]], "D": [[2]], "S": [[2]], "B": [[2]]'
ALONE = f"{{{PLAIN}}}"
SPARSE = sp.csc_array(([1.0, 2.0, 3.0], [0, 0, 1], [0, 2, 3]), shape=(2, 2))
TWO = dict.fromkeys("MDB", np.eye(2))
ROWS, THREE = "row,column,value", np.array([[3, -1, 0], [-1, 2, -1], [0, -1, 9.81]])
WHOLE = dict.fromkeys(("M_csv", "D_csv", "B_csv"), "2 0\n0 2")
HELD = {"A": np.eye(2) / 2, "B": np.ones((2, 1)), "T": 0.1}
#: Files by name; what both say, or the M, D, S that both read.
ODD = {
    "an entry twice": (market("general", "1 1 1\n1 1 5"), "row 1, column 1 is there"),
    "both triangles": (market("symmetric", "1 2 5\n2 1 4"), r"row [12], column [12]"),
    "no entry twice": (market("general", "2 1 4\n1 1 3"), [[3, 0], [4, 0]]),
    "one triangle": (market("symmetric", "2 1 4\n1 1 3"), [[3, 4], [4, 0]]),
    "a skew one": (market("skew-symmetric", "2 1 4"), [[0, -4], [4, 0]]),
    "a sparse entry twice": (mat(**TWO, S=SPARSE), "row 1, column 1 is there twice"),
    "a key twice": (words(f'{{{PLAIN}, "S": [[3]]}}'), "key 'S' comes twice"),
    "a key twice inside": (words(f'{{"plant": {{{PLAIN}, "M": [[3]]}}}}'), "'M' comes"),
    "escaped": (words(f'{{{PLAIN}, "\\u0053": [[3]]}}'), "key 'S' comes twice"),
    "an unknown key": (words(f'{{{PLAIN}, "C": [[3]]}}'), "'C' isn't known"),
    "K for S": (words(ALONE.replace('"S"', '"K"')), "'K' isn't known, call it S"),
    "a second F": (
        words(f'{{"vertices": [{ALONE}, {{{PLAIN}, "F": [[1]]}}]}}'),
        "vertices differ in size",
    ),
    "a vertex with K": (
        words(f'{{"vertices": [{ALONE}, {{{PLAIN}, "K": [[1]]}}]}}'),
        "'K' isn't known",
    ),
    "vertices and more": (words(f'{{"vertices": [{ALONE}], "M": [[1]]}}'), "only key"),
    "a small number": (table(S_csv="1e-400"), "1e-400 is too small: write 0"),
    "a large number": (table(S_csv="1e400"), "1e400 is too large: choose other units"),
    "a small one in JSON": (words(ALONE.replace("2", "1e-400")), "too small"),
    "a zero": (table(S_csv="0e-400"), [[0]]),
    "Fortran's exponents": (
        table(**WHOLE, S_csv="3.0D+00;-1.D-1\r\n-.1d0;9.81D0\r\n"),
        [[3, -0.1], [-0.1, 9.81]],
    ),
    "a small one of Fortran": (table(S_csv="1D-400"), "1[eD]-400 is too small"),
    "headings": (table(S_csv="S\n1"), "'?\"?S'?\"? is no number"),
    "a T beside A": (mat(**HELD), "call it dt|a state space"),
    "half of three rows": (
        mat(M=np.eye(3), D=np.eye(3), S=np.tril(THREE), B=np.eye(3)),
        np.tril(THREE).tolist(),
    ),
    "rows of nothing": (
        mat(**{x: np.diag([1.0, 0, 2]) for x in "MDSB"}),
        r"rows are empty in .*(without=\[1\]|columns 2)",
    ),
    "small letters": (mat(**{x.lower(): np.eye(1) for x in "MCKB"}), [[1]]),
    "an f": (mat(**dict.fromkeys("MDSBf", np.eye(1))), "f isn't read: call it F"),
    "a complex matrix": (mat(**TWO, S=1j * np.eye(2)), "complex"),
    "a struct": (mat(sys=dict(zip("MCKB", [np.eye(2)] * 4)), note="x"), np.eye(2)),
    "a small struct": (
        mat(sys={x.lower(): sp.csc_array(np.eye(2)) for x in "MDSB"}, info={"x": 1.0}),
        np.eye(2),
    ),
    "two structs": (
        mat(**{x: {y: np.eye(1) for y in "MDSB"} for x in ("up", "down")}),
        "which is the plant, up or down",
    ),
    "a struct in a struct": (mat(sys={"of": {"M": np.eye(1)}}), "D, S, B is missing"),
    "a model in a struct": (
        mat(job={"fe": dict(zip("MCKB", [np.eye(2)] * 4)), "tool": {"name": "x"}}),
        np.eye(2),
    ),
    "two models in structs": (
        mat(job={x: dict.fromkeys("MDSB", np.eye(1)) for x in ("up", "down")}),
        r"which is the plant, job\.up or job\.down",
    ),
    "decimal commas": (table(**WHOLE, S_csv="3,5;1,5\n1;2"), "'?\"?3,5.* with a point"),
    "more than a plant": (mat(**TWO, S=np.eye(2), G=1), np.eye(2).tolist()),
    "no actuator": (mat(**dict.fromkeys("MDS", np.eye(2))), "dd B, a column for"),
    "constructor": (table() | {"constructor.csv": b"1"}, [[2]]),
    "__proto__": (table() | {"__proto__.csv": b"1"}, [[2]]),
}
#: Tables of entries, which are the package's: what it says, or the S that it reads.
LISTED = {
    "Fortran's entries": (
        table(**WHOLE, S_mtx="1 1 3.D0\n2 1 4d+0\n"),
        [[3, 4], [4, 0]],
    ),
    "a table of entries": (
        table(
            M_txt="2 0\n0 2",
            D_csv="2 0\n0 2",
            B_csv=f"{ROWS}\n1,1,2",
            S_csv=f"""
# of all
{ROWS}
1,1,3
2,1,4"""
            + "\n1,2,4",
        ),
        [[3, 4], [4, 0]],
    ),
    "half of such a table": (
        table(**WHOLE, S_csv=f"{ROWS}\n1,1,3\n2,1,4"),
        [[3, 0], [4, 0]],
    ),
    "a column of no number": (table(S_csv=f"{ROWS}\n1,0,3"), "row.*column"),
    "a table without its heading": (
        table(**WHOLE | {"S_csv": None}, K_csv="1 1 3"),
        "row,column,value",
    ),
    "Abaqus's coordinates": (table(**WHOLE, S_mtx="1 1 3\n2 1 4\n"), [[3, 4], [4, 0]]),
    "coordinates and nodes": (
        table(S_mtx="1 1 3\n", M_mtx="1,1,1,1,2\n"),
        "some have nodes, some numbers",
    ),
}


def said(folder, cases):
    """What the page says of each case: fields, what is left out and what the form
    warns of, or an error."""
    deno = shutil.which("deno", path=Path(sys.executable).parent)
    if deno is None:
        pytest.skip("deno isn't installed: pip install deno")
    given = [
        [[name, base64.b64encode(x).decode()] for name, x in files.items()]
        for files in cases
    ]
    module, checks = (
        json.dumps((ASSETS / f).as_uri()) for f in ("files.js", "checks.js")
    )
    refusals, given = json.dumps(bench().data["refusals"]), json.dumps(given)
    text = READ.format(module=module, checks=checks, refusals=refusals, files=given)
    (folder / "read.js").write_text(text, "utf-8")
    done = process(deno, "run", "--no-lock", "--allow-read", folder / "read.js")
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    files = [files for files, _ in ODD.values()]
    return dict(zip(ODD, said(tmp_path_factory.mktemp("page"), files)))


@pytest.mark.parametrize("case", ODD)
def test_page_and_package_read_alike(case, page, tmp_path):
    files, wanted = ODD[case]
    for name, content in files.items():
        (tmp_path / name).write_bytes(content)
    place = tmp_path / next(iter(files)) if len(files) == 1 else tmp_path
    if isinstance(wanted, str):
        with pytest.raises(ValueError, match=wanted):
            load_plant(place)
        assert isinstance(page[case], str) and re.search(wanted, page[case]), page[case]
        return
    with warnings.catch_warnings(record=True) as seen:
        warnings.simplefilter("always")
        plant = load_plant(place)
    assert plant.S.tolist() == np.asarray(wanted).tolist()
    found, left, odd = (page[case].get(x) for x in ("fields", "left", "odd"))
    for name in "MDSB":
        rows = [[float(x) for x in row.split()] for row in found[name].split(";")]
        assert rows == getattr(plant, name).tolist()
    assert bool(left) == any("left out" in str(w.message) for w in seen)
    assert all(left in str(w.message) for w in seen)
    half = "is it half of a"
    assert (half in odd) == any(half in str(w.message) for w in seen)


def test_tables_of_entries_are_for_the_package(tmp_path, monkeypatch):
    """The page says so, with a line that makes a file for it."""
    told = said(tmp_path, [files for files, _ in LISTED.values()])
    for (case, (files, wanted)), words in zip(LISTED.items(), told, strict=True):
        (folder := tmp_path / case).mkdir()
        for name, content in files.items():
            (folder / name).write_bytes(content)
        monkeypatch.chdir(folder)
        assert isinstance(words, str), case
        if isinstance(wanted, str):
            with pytest.raises(ValueError, match=wanted):
                load_plant(folder)
        else:
            assert "it lists entries" in words
            exec(line_of(words), {})
            assert load_plant(folder / "plant.json").S.tolist() == wanted


def line_of(told):
    """The words of Python in a line that the page says."""
    return re.search(r'python -c "(.*?\)\))"', told)[1]


def design_of(told):
    """The words of the command that the page says first."""
    return re.search('python -m sosbook (design) "([^"]*)"', told).groups()


def saved(path, kind):
    """A plant in a file or folder as programs save it, and its S as a page reads it."""
    S = 9.81 * np.array([[3, -1], [-1, 2]])
    given = dict(zip("MDSB", (np.eye(2), 0.3 * np.eye(2), S, np.eye(2)[:, 1:])))
    if kind == "MATLAB 4":
        scipy.io.savemat(path / "my plant.mat", given, format="4")
    elif kind == "MATLAB 7.3":
        h5py = pytest.importorskip("h5py")
        with h5py.File(path / "x.mat", "w") as file:
            file["job/fe/M"] = given.pop("M")
            file["job/fe"].update(given)
            file["job/again"] = file["job"]  # a circle
    elif kind == "large":
        one, n = sp.identity(90), 90
        large = {"M": one, "D": one, "S": sp.diags(9.81 + np.arange(n)), "B": np.eye(n)}
        scipy.io.savemat(path / "x.mat", {k: sp.csc_array(x) for k, x in large.items()})
        S = np.diag(9.81 + np.arange(6))
    else:
        for name, x in given.items():
            np.save(path / f"{name}.npy", x)
    return S


@pytest.mark.parametrize("kind", ["MATLAB 4", "MATLAB 7.3", "large", "a folder"])
def test_both_commands_of_the_page_work(kind, tmp_path, monkeypatch, capsys):
    """One designs, the other makes a file that the page opens."""
    S = saved(tmp_path, kind)
    files = {x.name: x.read_bytes() for x in tmp_path.iterdir()}
    (told,) = said(tmp_path, [files])
    monkeypatch.chdir(tmp_path)
    (tmp_path / "read.js").unlink()
    if kind != "large":
        assert main([*design_of(told)]) == 0
        assert '"proven": true' in capsys.readouterr().out
    exec(line_of(told), {})
    (opened,) = said(tmp_path, [{"plant.json": Path("plant.json").read_bytes()}])
    rows = [[float(x) for x in row.split()] for row in opened["fields"]["S"].split(";")]
    assert np.array(rows) == pytest.approx(S, abs=1e-9)


def test_the_line_of_the_page_runs(tmp_path, monkeypatch):
    """Where the package can read what a page can't, and only there."""
    np.savez(tmp_path / "x y.npz", **dict.fromkeys("MDSB", 2 * np.eye(1)))
    hostile = "a$(touch pwned).h5", "a'); import os; os.system('id.op4"
    (tmp_path / "x.toml").write_text("M = 2\nD = 2\nS = 2\nB = 2", "utf-8")
    model(tmp_path).rename(tmp_path / "x.pch")
    names = "x y.npz", *hostile, "x.pkl", "x.toml", "x.pch", "M.npy"
    told = said(tmp_path, [{name: b""} for name in names])
    assert all("load_plant('YOUR_FILE'" in text for text in told[1:3])
    assert "python" not in told[3] and "load_plant('.')" in told[6]
    assert process(sys.executable, "-c", line_of(told[0]), cwd=tmp_path).returncode == 0
    monkeypatch.chdir(tmp_path)
    for words in told[0], told[4]:
        exec(line_of(words), {})
        written = json.loads((tmp_path / "plant.json").read_text("utf-8"))
        assert written == {x: [[2.0]] for x in "MDSB"} | {"F": [[]]}
        assert load_plant(tmp_path / "plant.json").S == 2
    line, call = line_of(told[5]), "load_plant('x.pch'"
    for _ in range(2):  # what is asked for stands beside the name
        with pytest.raises(ValueError) as asked:
            exec(line, {})
        line = line.replace(call, f"{call}, {arguments_in(str(asked.value))}")
    exec(line, {})
    assert load_plant(tmp_path / "plant.json").S[0, 0] == 3


def test_a_state_space_is_for_the_package(tmp_path, monkeypatch, capsys):
    """The page says the command that works on such a file."""
    (held,) = mat(A=np.array([[0, 1], [2, 0.3]]), B=np.eye(2)[:, 1:]).values()
    (tmp_path / "p.mat").write_bytes(held)
    (told,) = said(tmp_path, [{"p.mat": held}])
    monkeypatch.chdir(tmp_path)
    assert main([*design_of(told)]) == 0
    assert '"proven": true' in capsys.readouterr().out
