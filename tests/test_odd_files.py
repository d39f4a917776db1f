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
from sosbook.plants import load_plant
from tests.processes import process

ASSETS = Path(sosbook.__file__).parent / "book" / "elements" / "assets"
ONE = {name: b"2" for name in "MDSB"}
READ = """globalThis.HTMLElement = class {{}};
const {{read}} = await import({module});
const results = [];
for (const files of {files}) {{
  const given = files.map(([name, content]) =>
    new File([Uint8Array.from(atob(content), c => c.charCodeAt(0))], name));
  try {{ results.push(await read(given)); }}
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
    own = {name.replace("_", "."): text.encode() for name, text in changed.items()}
    left = ONE.keys() - {name.partition(".")[0] for name in own}
    return own | {f"{name}.csv": ONE[name] for name in left}


def words(text):
    return {"plant.json": text.encode()}


def market(kind, lines):
    whole = dict.fromkeys(("M_csv", "D_csv", "B_csv"), "2 0\n0 2")
    head = f"%%MatrixMarket matrix coordinate real {kind}"
    count = len(lines.splitlines())
    return table(**whole, S_mtx=f"{head}\n2 2 {count}\n{lines}\n")


PLAIN = '"M": [[2]], "D": [[2]], "S": [[2]], "B": [[2]]'
ALONE = f"{{{PLAIN}}}"
SPARSE = sp.csc_array(([1.0, 2.0, 3.0], [0, 0, 1], [0, 2, 3]), shape=(2, 2))
TWO = dict.fromkeys("MDB", np.eye(2))
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
    "headings": (table(S_csv="S\n1"), "'?\"?S'?\"? is no number"),
    "a T beside A": (mat(**HELD), "call it dt|M, D, S is missing"),
    "small letters": (mat(**{x.lower(): np.eye(1) for x in "MCKB"}), [[1]]),
    "an f": (mat(**dict.fromkeys("MDSBf", np.eye(1))), "f isn't read: call it F"),
    "a complex matrix": (mat(**TWO, S=1j * np.eye(2)), "complex"),
    "a struct": (mat(sys={x: np.eye(1) for x in "MDSB"}), "sys is"),
    "more than a plant": (mat(**TWO, S=np.eye(2), G=1), np.eye(2).tolist()),
    "no actuator": (mat(**dict.fromkeys("MDS", np.eye(2))), "dd B, a column for"),
    "constructor": (table() | {"constructor.csv": b"1"}, [[2]]),
    "__proto__": (table() | {"__proto__.csv": b"1"}, [[2]]),
}


def said(folder, cases):
    """What the page says of each case: fields and what is left out, or an error."""
    deno = shutil.which("deno", path=Path(sys.executable).parent)
    if deno is None:
        pytest.skip("deno isn't installed: pip install deno")
    given = [
        [[name, base64.b64encode(x).decode()] for name, x in files.items()]
        for files in cases
    ]
    module = json.dumps((ASSETS / "files.js").as_uri())
    text = READ.format(module=module, files=json.dumps(given))
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
    assert plant.S.tolist() == wanted
    found, left = page[case]["fields"], page[case]["left"]
    for name in "MDSB":
        rows = [[float(x) for x in row.split()] for row in found[name].split(";")]
        assert rows == getattr(plant, name).tolist()
    assert bool(left) == any("left out" in str(w.message) for w in seen)
    assert all(left in str(w.message) for w in seen)


def test_the_line_of_the_page_runs(tmp_path):
    """Where the package can read what a page can't, and only there."""
    np.savez(tmp_path / "x y.npz", **dict.fromkeys("MDSB", 2 * np.eye(1)))
    hostile = "a$(touch pwned).h5", "a'); import os; os.system('id.op4"
    names = "x y.npz", *hostile, "x.pch"
    told = said(tmp_path, [{name: b""} for name in names])
    line = re.search(r'python -c "(.*)"', told[0])[1]
    assert process(sys.executable, "-c", line, cwd=tmp_path).returncode == 0
    written = json.loads((tmp_path / "plant.json").read_text("utf-8"))
    assert written == {x: [[2.0]] for x in "MDSB"} | {"F": [[]]}
    assert load_plant(tmp_path / "plant.json").S == 2
    assert all("load_plant('YOUR_FILE')" in text for text in told[1:3])
    assert "python" not in told[3]
