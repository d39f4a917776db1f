"""The kernel of proofs alone, against numpy, differences and eigenvalues."""

import hashlib
import json
import shutil
import sys
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import block_diag

from sosbook.exact.checker import kernel
from sosbook.exact.checker.arithmetic import read
from sosbook.exact.rational import decimal
from sosbook.requirements.pole_region import LMIRegion
from tests.cases import seeds
from tests.mutants import page, page_inputs
from tests.mutants.page_inputs import TEXTS, calls
from tests.processes import alone, process

CALLS = [*calls()]

RNG = np.random.default_rng(8)
DATA = {
    name: RNG.integers(-40, 40, shape) / 8.0
    for name, shape in dict(A=(3, 3), B=(3, 2), C=(2, 3), S=(2, 2)).items()
}
P = np.array([[3.0, 0.5, 0], [0.5, 2, -0.25], [0, -0.25, 1]])
Y = RNG.integers(-40, 40, (2, 3)) / 8.0
A, B, C, S = DATA.values()
VALUES = {
    "A P + B Y": A @ P + B @ Y,
    "he(A P + B Y)/2": (A @ P + B @ Y + (A @ P + B @ Y).T) / 2,
    "-A - 2 P'": -A - 2 * P.T,
    "A + g": A + 0.5 * np.eye(3),
    "g^2 - g/4 + tr(P)": np.array([[0.25 - 0.125 + np.trace(P)]]),
    "[P, Y'; ., g^2]": np.block([[P, Y.T], [Y, 0.25 * np.eye(2)]]),
    "[g, 0; ., P]": block_diag(0.5, P),
    "[0, B; C, 0]": np.block([[np.zeros((3, 3)), B], [C, np.zeros((2, 2))]]),
    "[O(2, 2), I(2); ., -1]": np.block(
        [[np.zeros((2, 2)), np.eye(2)], [np.eye(2), -np.eye(2)]]
    ),
    "kron(S, P)": np.kron(S, P),
    "kron([0, 1; 0, 0], A) P2": np.kron([[0, 1], [0, 0]], A) @ np.kron(np.eye(2), P),
    "inv(A) (B Y)": np.linalg.inv(A) @ B @ Y,
    "rows(B) I(cols(B))": 3 * np.eye(2),
    "pick(2, 3, 2)": np.eye(6)[2:4],
    "at(A, 2, 3) P": A[1, 2] * P,
}


def rows(x):
    return [[str(Fraction(e)) for e in row] for row in np.asarray(x, float).tolist()]


def file_of(text, sets=(), **more):
    data = {k: rows(x) for k, x in DATA.items()} | {"g": "0.5"}
    shapes = {"P": "symmetric 3", "Y": "cols(B) x rows(A)"}
    point = {"point": {"P": rows(P), "Y": rows(Y)}}
    whole = dict(
        text=text.split("\n"), data=data, sets=dict(sets), unknowns=shapes, **point
    )
    whole |= more
    if "multipliers" in more:
        del whole["point"]
    return json.loads(json.dumps(whole))


def value(text, P=P, Y=Y, point=True):
    known = {k: read(rows(x)) for k, x in DATA.items()}
    known |= {"g": Fraction(1, 2)}
    unknown = {"P": read(rows(P)), "Y": read(rows(Y))}
    reader = kernel.Reader(known, unknown, point=point)
    lines = "P2 = [P, 0; 0, P]\n" if "P2" in text else ""
    ((_, _, x, _),) = reader.statements(kernel.parse(f"{lines}x: {text} > 0"))
    return reader, x


def floats(x):
    if kernel.scalar(x):
        return np.array([[float(x)]])
    return np.array([[float(x.at(i, j)) for j in range(x.c)] for i in range(x.r)])


@pytest.mark.parametrize("text", VALUES)
def test_a_text_is_read_as_numpy_reads_it(text):
    assert np.allclose(floats(value(text)[1].v), VALUES[text], rtol=1e-13)


AFFINE = [
    "-[he(A P + B Y), P C'; ., -g]",
    "kron([g, 2; 1, 0], he(A P))",
    "[1, 2 at(A, 1, 1) g; ., tr(P) - g]",
    "[P + tr(P), Y'; ., g^2]",
    "he(kron([0, 1; 0, 0], A P + B Y)) - 3 [P, 0; 0, P]/2",
    "pick(1, 3, 1) P pick(1, 3, 1)' + tr(Y B) I(1)",
    "tr(A P) inv(S) + g^2",
]


@pytest.mark.parametrize("text", AFFINE)
def test_a_sum_leads_back_as_its_differences_do(text):
    reader, x = value(text, point=False)
    n = floats(x.v).shape[0]
    Z = RNG.integers(-9, 9, (n, n)).astype(float)
    Z = Z + Z.T
    exact = read(rows(Z))
    x.adj = exact if not kernel.scalar(x.v) else exact.at(0, 0)
    for y in reversed(reader.tape):
        for z, back in y.back if y.adj is not None else ():
            g = back(y.adj)
            z.adj = g if z.adj is None else z.adj + g
    for name, at in (("P", P), ("Y", Y)):
        found = reader.env[name].adj
        found = np.zeros(at.shape) if found is None else floats(found)
        for i, j in np.ndindex(at.shape):
            moved = at.copy()
            moved[i, j] += 1
            there = value(text, **{name: moved}, point=False)[1]
            slope = (Z * (floats(there.v) - floats(x.v))).sum()
            assert found[i, j] == pytest.approx(slope, abs=1e-9)


def test_a_product_of_two_unknowns_is_a_value_and_no_block():
    assert np.allclose(floats(value("Y P")[1].v), Y @ P)
    for text in ("Y P", "tr(P) Y", "P/tr(P)", "inv(P)", "kron(P, S)", "tr(P)^2"):
        with pytest.raises((kernel.Refused, *kernel.MALFORMED)):
            value(text, point=False)


@pytest.mark.parametrize("seed", seeds(30))
def test_what_is_positive_has_positive_eigenvalues(seed):
    rng = np.random.default_rng(seed)
    n, rank = int(rng.integers(1, 7)), int(rng.integers(1, 9))
    L = rng.integers(-3, 4, (n, rank)).astype(float)
    x = L @ L.T - (seed % 3 == 0) * np.diag(rng.integers(0, 2, n))
    least = np.linalg.eigvalsh(x)[0]
    exact = read(rows(x))
    assert kernel.definite(exact) == (least > 1e-9)
    assert kernel.definite(exact, semi=True) == (least > -1e-9)
    assert kernel.definite(read(rows(x + np.eye(n) / 3))) == (least > -1 / 3)


@pytest.mark.parametrize("size", [1, 10**40, Fraction(1, 10**90)])
@pytest.mark.parametrize("sign", [1, 0, -1])
def test_rounding_never_decides(sign, size):
    """The second pivot is 1e-60 of the first; its sign, and nothing else, counts."""
    last = 1 + Fraction(sign, 10**60)
    x = read([[str(size * e) for e in row] for row in ((1, -1), (-1, last))])
    assert kernel.definite(x) == (sign > 0)
    assert kernel.definite(x, semi=True) == (sign >= 0)


def refused(file):
    try:
        kernel.check(file)
    except (kernel.Refused, *kernel.MALFORMED) as why:
        return str(why) or "malformed"
    return ""


def test_a_point_proves_each_line():
    """What is refused of it is forged in `test_every_need`."""
    good = "n = rows(A)\nP: P > 0\nL: A inv(A) == I(n)\nY: Y' Y >= 0\ng: g > 0\n"
    assert kernel.check(file_of(good)) == ["P", "L", "Y", "g"]
    for text in (
        "P: -P > 0",
        "P: A > 0",
        "Y: Y' Y > 0",
        "Y: -Y' Y >= 0",
        "P: P == I(3)",
    ):
        assert refused(file_of(text)), text


def test_sets_are_loops_over_names():
    text = "for i, j in pairs:\n  x = d.i + d.j\n  x.i.j: x > 0\n"
    data = {"d.1": "1", "d.2": "-0.5", "d.3": "2e-1"}
    more = dict(data=data, unknowns={}, point={})
    pairs = [["1", "1"], ["1", "2"], ["1", "3"]]
    assert kernel.check(file_of(text, {"pairs": pairs}, **more)) == [
        "x.1.1",
        "x.1.2",
        "x.1.3",
    ]
    assert "x.2.3" in refused(file_of(text, {"pairs": [["2", "3"]]}, **more))
    assert refused(file_of(text, {"pairs": [["1"]]}, **more))
    assert refused(file_of(text, {"pairs": [["1", "4"]]}, **more))


def unstable(text="P: P > 0\ndecay: -he(U P) > 0", **Z):
    data = {"U": [["1", "3"], ["0", "-1"]], "e": "-0.1"}
    shapes = {"P": "symmetric 2"}
    return file_of(text, data=data, unknowns=shapes, multipliers=Z)


def test_multipliers_and_what_is_refused_of_them():
    """The row v = (2, 3) has v U = v: no P > 0 has -(U P + P U') > 0."""
    Z = dict(P=[["8", "12"], ["12", "18"]], decay=[["4", "6"], ["6", "9"]])
    assert kernel.check(unstable(**Z)) == ["P", "decay"]
    turned = [["9", "-6"], ["-6", "4"]]
    for change in (
        dict(P=[["8", "12"], ["12", "19"]]),
        dict(decay=turned),
        dict(P=[["-8", "12"], ["12", "18"]]),
        dict(P=[["8", "13"], ["12", "18"]]),
        dict(P=[["8"]]),
        dict(other=[["1"]]),
        dict(P=[["0", "0"]] * 2, decay=[["0", "0"]] * 2),
    ):
        assert refused(unstable(**(Z | change)))
    assert refused(unstable()) and refused(unstable(decay=Z["decay"]))
    lines = "P: P > 0\ndecay: -he(U P) > 0\n"
    assert "isn't positive" in refused(unstable(lines + "e: e > 0", **Z))
    assert kernel.check(unstable(lines + "e: e > 0", e="1"))  # no e is positive
    assert "exclude nothing" in refused(unstable(lines + "e: -e > 0", **Z, e="1"))
    assert "for some x only" in refused(unstable(lines + "e: P >= 0", **Z))
    assert "takes no" in refused(unstable(lines + "e: 0 == 0", **Z, e="1"))


def test_it_runs_alone(tmp_path):
    path = tmp_path / "proof.json"
    for whole, code, words in (
        (file_of("P: P > 0"), 0, "positive definite: P\n"),
        (unstable(P=[["1"]]), 1, "refused: "),
        ({}, 1, "refused: "),
    ):
        path.write_text(json.dumps(whole), "utf-8")
        done = alone(kernel.__file__, path, timeout=60)
        assert done.returncode == code and done.stdout.startswith(words)


HIDDEN = {  # what holds at Y = 0 alone, and a part that there isn't
    "a: -1 > Y": "an unknown on the right",
    "b: O(1, 1) == Y\na: -1 > 0": "an unknown on the right",
    "b: Y == 0\na: -1 > 0": "for some x only",
    "a: -1 I(1 + Y) > 0": "no size",
    "a: -1 - rows(O(Y, 2)) > 0": "no size",
    "a: at([-1, 1], 1, 1 + Y) > 0": "no size",
    "a: at([-1, 1], 1, 3/2) > 0": "no size",
    "a: [-1, 1] pick(1 + Y, 2, 1)' > 0": "no size",
    "a: [-1, 1] pick(3, 2, 1)' > 0": "no such part",
    "a: -1 pick(1, 1 + Y, 1) > 0": "no size",
    "a: 1 - 2 > [Y]": "an unknown on the right",
    "a: -1 > 5": "doesn't fit",
}
READ = """import {Reader} from "@/reader.js"; import {FRACTIONS} from "@/arithmetic.js";
for (const text of JSON.parse(Deno.args[0])) {
  const reader = new Reader(FRACTIONS);
  reader.env.Y = reader.unknown("Y", 1, 1, true);
  let said = "read";
  try { [...reader.statements(text)]; } catch { said = "refused"; }
  console.log(said);
}"""


@pytest.mark.parametrize("text", HIDDEN)
def test_an_unknown_is_nowhere_that_a_sum_doesnt_lead_back_from(text):
    """A multiplier excludes at every Y, and these texts hide Y from it."""
    whole = dict(text=text.split("\n"), data={}, sets={}, unknowns={"Y": "number"})
    for one in ("1", [["1"]]):
        assert HIDDEN[text] in refused(whole | {"multipliers": {"a": one}})


def test_the_page_reads_no_hidden_unknown_either(tmp_path):
    deno = shutil.which("deno", path=Path(sys.executable).parent)
    if deno is None:
        pytest.skip("deno isn't installed: pip install deno")
    folder = (Path(kernel.__file__).parents[2] / "book/kernel").as_uri()
    (tmp_path / "read.js").write_text(READ.replace("@", folder), "utf-8")
    texts = [*HIDDEN, "a: -1 > 0", "a: [1, Y; ., 1] - I(2) > 0", "a: 1 == 1"]
    done = process(deno, "run", "-A", tmp_path / "read.js", json.dumps(texts))
    said = dict(zip(texts, done.stdout.split(), strict=True))
    reads = {text for text, word in said.items() if word == "read"}
    assert reads == {*texts[-3:], "b: Y == 0\na: -1 > 0"}, done.stderr


@pytest.fixture(scope="module")
def page_says():
    """What the page's reader says of small texts, and of single functions."""
    asked = [["text", [x, page_inputs.SETS, page_inputs.DATA]] for x in TEXTS]
    judge = page.Judge(page.body()[0], {}, [*asked, *(["call", x] for x in CALLS)])
    judge.close()
    return judge.answers[: len(TEXTS)], judge.answers[len(TEXTS) :]


def test_small_texts_are_decided_by_the_page_s_reader_as_by_the_checker(page_says):
    """Every second one is true: of each operation, of shapes that fit and don't."""
    for k, (text, said) in enumerate(zip(TEXTS, page_says[0], strict=True)):
        try:
            found = bool(kernel.check(page_inputs.whole(text)))
        except (kernel.Refused, *kernel.MALFORMED):
            found = False
        skew, failed = json.loads(said) if said != "an error" else ([], [text])
        theirs = not failed and ("==" in text or not skew)
        assert found == theirs == (k % 2 == 0), (text, said)


def exact(x):
    """A matrix of the page's arithmetic, in numpy."""
    at = [int(e.rstrip("n")) for e in x["at"]]
    return np.array(at).reshape(x["rows"], x["cols"]) / 10.0 ** x["places"]


TRUE = {  # what single functions of the page answer
    "decimal": decimal,
    "sha256": lambda x: hashlib.sha256(x.encode()).hexdigest(),
    "twiceAtLeast": lambda x: LMIRegion.half_plane(x).alpha.item(),
    "signOfDeterminant": lambda at, n: round(
        np.sign(round(np.linalg.det(np.reshape([int(x[:-1]) for x in at], (n, n)))))
    ),
    "definite": lambda x: bool(
        (exact(x) == exact(x).T).all() and np.linalg.eigvalsh(exact(x))[0] > 1e-9
    ),
    "exactTimes": lambda x, y: exact(x) @ exact(y),
    "exactSum": lambda x, y: exact(x) + exact(y),
    "exactInner": lambda x, y: [[(exact(x) * exact(y)).sum()]],
    "exactScaled": lambda s, x: exact(s) * exact(x),
    "exactTransposed": lambda x: exact(x).T,
}


def test_single_functions_of_the_page_s_reader_are_true(page_says):
    tried = set()
    for (name, *given), said in zip(CALLS, page_says[1], strict=True):
        if name in TRUE:
            tried.add(name)
            said, true = json.loads(said), TRUE[name](*given)
            said = exact(said) if isinstance(said, dict) else said
            assert np.allclose(said, true) if name.startswith("exact") else said == true
        if name in ("staysDefinite", "excludes") and said == "true":
            Z = (
                given[1] if name == "excludes" else [given[1]]
            )  # others may be true, too
            assert all(np.linalg.eigvalsh(exact(x))[0] > 0 for x in Z)
            if name == "excludes":
                constants = (x["constant"] for x in given[0])
                sums = [(exact(x) * exact(z)).sum() for x, z in zip(constants, Z)]
                assert sum(sums) < 1e-9
            tried.add(name)
    assert tried == {*TRUE, "staysDefinite", "excludes"}
