"""Each `need` of the checker refuses a forged file, and nothing else does so before it.

`forged.json` has changes of proofs, one for a need; those of the language and of single
functions are here. A `need` that is new, or that is never reached, is missing below.
"""

import json
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

import sosbook as sos
from sosbook.exact.checker import (
    arithmetic,
    fixed_mode,
    kernel,
    payment,
    plants,
    verdict,
)
from sosbook.exact.checker.language import Reader, parse
from sosbook.exact.rational import decimal
from sosbook.proofs.subject import compare_plant
from tests.forged import base, changed, decided, needs, refusal
from tests.test_proof_files import proof_of

FORGED = [json.loads(x) for x in Path(__file__).with_name("forged.json").open("rb")]
NINES = "9" * 99_000


def text(lines, multipliers=None, **more):
    """A file of the kernel alone: a text with a number Y, at a point or multiplied."""
    whole = dict(text=lines.split("\n"), data={}, sets={}, unknowns={"Y": "number"})
    whole |= {"point": {"Y": "1"}} if multipliers is None else {}
    whole |= {"multipliers": multipliers} if multipliers is not None else {}
    return whole | more


ONE, TWO_I = {"a": "1"}, {"a": [["1", "0"], ["0", "1"]]}
CHAIN = "a: [1, 0, 0, 0; 1, 1, 0, 0; 0, 1, 1, 0; 0, 0, 1, O(2, 2)] > 0"
AT_A_POINT = {  # from the words of a need to a text
    "kernel": {
        "comes twice": "a: 1 > 0\na: 1 > 0",
        "isn't an identity": "a: 1 == 2",
        "isn't positive ": "a: -1 > 0",
    },
    "language": {
        "not understood": "a: 1 ? 1 > 0",
        "is missing in": "a: (1 > 0",
        "where a matrix is wanted": "a: + > 0",
        "doesn't end": "a: [1 > 0",
        "is the only loop": "for i in pairs 1:\n  a: 1 > 0",
        "an odd indent": "  a: 1 > 0",
        "can't be a name": "he: 1 > 0",
        "neither a definition": "a > 0",
        "is defined twice": "x = 1\nx = 2\na: 1 > 0",
        "states nothing": "a: 1",
        "too much in": "a: 1 > 0 ]",
        "isn't known": "a: x > 0",
        "a division by no number": "a: 1/[1] > 0",
        "no power of a number": "a: [2]^2 > 0",
        "no such entry": "a: at([1], 2, 1) > 0",
        "no such part": "a: pick(3, 2, 1) > 0",
        "the largest of what isn't a number": "a: most(1, [1]) > 0",
        "a matrix without unknowns is needed": "a: exp(1) > 0",
        "the rows of a block matrix differ": "a: [1, 2; 3] > 0",
        "a mirror image of nothing": "a: [., 1; 1, 1] > 0",
        "a number where a block isn't square": CHAIN,
        "there is no set": "for i in s:\n  a.i: 1 > 0",
        "blocks that don't fit": "a: [O(1, 1), O(2, 1)] > 0",
    },
    "arithmetic": {
        "a sum of two shapes": "a: [1] + [1, 2] > 0",
        "a product of shapes that don't fit": "a: [1, 2] [1, 2] > 0",
        "a Kronecker product is too large": "a: kron(O(1, 1999), O(1999, 2)) > 0",
        "the trace of a matrix": "a: tr([1, 2]) > 0",
        "the inverse of a matrix": "a: inv([1, 2]) > 0",
        "that must be regular is singular": "a: inv([0]) > 0",
        "a number and a matrix that isn't square": "a: 1 + [1, 2] > 0",
        "an enclosed matrix where an exact one": "a: near([1]) == [1]",
        "the exponential of a matrix": "a: exp([1, 2]) > 0",
        "an exponential is too large": "a: exp([65]) > 0",
    },
}
MULTIPLIED = {
    "kernel": {
        "comes twice": ("a: -1 > 0\na: -1 > 0", ONE),
        "takes no multiplier": ("a: 0 == 0", ONE),
        "holds for some x only": ("b: Y == 0\na: -1 > 0", ONE),
        "doesn't fit": ("a: -[1] > 0", TWO_I),
        "the multiplier of {label} isn't positive": ("a: -1 > 0", {"a": "-1"}),
        "belongs to no block": ("a: -1 > 0", ONE | {"b": "1"}),
        "none counts": ("a: -1 > 0", {"a": "0"}),
        "a way out": ("a: Y - 1 > 0", ONE),
        "exclude nothing": ("a: 1 > 0", ONE),
    },
    "language": {
        "a product of two unknowns": ("a: Y Y > 0", ONE),
        "kron needs a certain first factor": ("a: kron(Y, [1]) > 0", ONE),
        "the inverse of an unknown": ("a: inv(Y) > 0", ONE),
        "an unknown on the right": ("a: -1 > Y", ONE),
        "no size": ("a: -I(1 + Y) > 0", ONE),
    },
}
LOOP = "for i in s:\n  a.i: 1 > 0"
MORE = [
    ("kernel", "whole", text("a: 1 > 0") | {"text": "sha256:0"}),
    ("kernel", "a point, or multipliers", text("a: 1 > 0", {}, point={})),
    ("kernel", "other unknowns", text("a: 1 > 0", point={})),
    ("kernel", "another shape", text("a: 1 > 0", point={"Y": [["1"]]})),
    ("kernel", "isn't symmetric", text("a: 1 > 0", unknowns={"Y": "symmetric 2"},
                                       point={"Y": [["1", "2"], ["3", "1"]]})),
    ("language", "is given twice", text("a: 1 > 0", ONE, data={"Y": "1"})),
    ("language", "is defined by the file", text("x = 1\na: 1 > 0", data={"x": "1"})),
    ("language", "a power has too", text("a: x^9 > 0", data={"x": NINES})),
    ("language", "a set of another", text(LOOP, sets={"s": [["1", "2"]]})),
    ("language", "are no index words", text(LOOP, sets={"s": [["1 2"]]})),
    ("arithmetic", "isn't a number", text("a: 1 > 0", data={"x": "one"})),
    ("arithmetic", "is too long", text("a: 1 > 0", data={"x": "1" * 100_002})),
    ("arithmetic", "an odd", text("a: 1 > 0", data={"x": {"zeros": [2, 9999]}})),
    ("arithmetic", "rows of a matrix differ",
     text("a: 1 > 0", data={"x": [["1", "2"], ["1"]]})),
]  # fmt: skip
TEXTS = MORE + [
    (module, words, text(*(given if isinstance(given, tuple) else (given,))))
    for table in (AT_A_POINT, MULTIPLIED)
    for module, rows in table.items()
    for words, given in rows.items()
]


def moves(line):
    """What is paid where A moves by 1, of a text with one statement."""
    one = kernel.Reader.read([["2"]])
    reader, known = Reader({"B": one}), {"A": kernel.Reader.read([["1"]])}
    return list(payment.prices(reader, known, parse("A = B\n" + line)))


def check(whole):
    return verdict.check(json.dumps(whole))


def of_files():
    """The module, words, and a call, of what isn't about a text."""
    proof = proof_of("stability")
    whole = json.loads(proof.text)
    known = base("known gain, in a simplex")
    none = {k: v for k, v in known.items() if k != "unknowns"}
    refused = none | {"kind": "infeasible known gain", "multipliers": []}
    bare = {
        k: v for k, v in whole.items() if k in ("format", "version", "kind", "asks")
    }
    for words, file in {
        "no proof file": {},
        "there is no version": {"format": verdict.FORMAT},
        "a file without a text has other keys": bare,
        "the digests are of other data": whole | {"about": {}},
        "isn't what is written": whole | {"sets": {}},
    }.items():
        yield "verdict", words, check, file
    yield "verdict", "no multipliers exclude that", verdict.text_of, refused
    yield "kernel", "a key comes twice", kernel.contents, '{"a": 1, "a": 2}'
    yield "kernel", "too many digits", kernel.contents, "1" * 401
    yield "subject", "that is no number", verdict.wanted_gain, {"K": [[True]]}
    yield "payment", "{x[0]} moves", moves, "x: inv(A) > 0"
    yield "payment", "{label} moves", moves, "x: A == [2]"


def test_every_need_refuses_a_file_that_is_forged(tmp_path, monkeypatch, capsys):
    rows = [*((m, w, kernel.check, file) for m, w, file in TEXTS), *of_files()]
    rows += [(*need, decided, changed(name, how)) for need, name, how in FORGED]
    for name in {name for _, name, _ in FORGED}:
        decided(base(name))  # what isn't changed is a proof
    (tmp_path / "proof.json").write_text(proof_of("stability").text, "utf-8")
    (tmp_path / "gain.json").write_text("[[1, 2]]", "utf-8")
    named = [str(tmp_path / f"{x}.json") for x in ("proof", "gain")]
    gain = [named[0], "--gain", named[1]]
    rows.append(("verdict", "it is about another", verdict.main, gain))
    reached = set()
    for module, words, do, given in rows:
        at = refusal(do, given)
        assert at in needs(), (module, words, at)
        assert at[0] == module and words in needs()[at][1], (module, words, needs()[at])
        reached.add(at)
    monkeypatch.setattr(kernel, "MOST_BYTES", 9)
    reached.add(refusal(kernel.main, named[:1]))
    missing = {x: needs()[x][1] for x in needs().keys() - reached}
    assert not missing


def test_each_number_of_a_region_is_the_one_that_its_words_want():
    asked = base("regions")
    for k, r in enumerate(asked["requirements"]):
        for name in ("alpha", "beta") if r["form"] != "matrices" else ():
            for i, j in np.ndindex(2, 2) if len(r[name]) > 1 else [(0, 0)]:
                for step in (-1e-3, 1e-3):
                    rows = [[float(x) for x in row] for row in r[name]]
                    for a, b in {(i, j), (j, i) if name == "alpha" else (i, j)}:
                        rows[a][b] += step * (1 + abs(rows[a][b]))
                    to = [[decimal(x) for x in row] for row in rows]
                    how = [[["requirements", k, name], to]]
                    at = refusal(decided, changed("regions", how))
                    assert at in needs() and "don't belong" in needs()[at][1], (r, to)


@pytest.mark.parametrize("size", [0.1, 10.0])
def test_a_mode_is_outside_of_a_half_plane_or_a_disk_but_for_a_millionth(size):
    half = [[Fraction(2 * size)]], [[Fraction(1)]]
    disk = [[-size, -3 * size], [-3 * size, -size]], [[0, 1], [0, 0]]  # around 3 size
    disk = [[list(map(Fraction, row)) for row in x] for x in disk]
    for step, out in ((1e-3, True), (1e-8, True), (-1e-8, True), (-1e-3, False)):
        for y in (0.0, 0.7 * size):
            x = Fraction(-size + step * size)
            assert fixed_mode.kept_out(*half, x, Fraction(y)) is out
        for angle in (0.3, 2.5):
            s = 3 * size + size * (1 + step) * np.exp(1j * angle)
            point = Fraction(float(s.real)), Fraction(float(s.imag))
            assert fixed_mode.kept_out(*disk, *point) is out
    c = Fraction(size)  # roots at -c and -c + 3, -c - 3
    h = [c**3 - 9 * c, 3 * c**2 - 9, 3 * c, Fraction(1)]
    assert fixed_mode.mirrored(*half, h)
    assert not fixed_mode.mirrored([[Fraction(2 * size + 1)]], half[1], h)


def test_a_witness_is_no_zero_and_its_form_isn_t_negative():
    name = "a mode beside a sector"
    zero = [[["witness"], [["0", "0"], ["0", "0"]]]]
    deep = {"kind": "region", "name": "mine", "form": "matrices"}
    deep |= {
        "alpha": [["-1000", "0"], ["0", "-1000"]],
        "beta": [["0", "0"], ["0", "0"]],
    }
    for how in (zero, [[["requirement"], deep]]):
        at = refusal(decided, changed(name, how))
        assert "outside(alpha, beta, h, x, y, v)" in needs()[at][1]


def test_columns_that_are_no_inverse_are_refused_at_a_residual_of_three_halves():
    name = "little force for a fast fall"
    rows = [[[decimal(2.5 * float(x)) for x in r] for r in part]
            for part in base(name)["rows"]]  # fmt: skip
    at = refusal(decided, changed(name, [[["rows"], rows]]))
    assert "aren't near an inverse" in needs()[at][1]


@pytest.mark.parametrize("seed", range(30))
def test_determinants_are_those_of_numpy(seed):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 6))
    a = rng.integers(-2, 3, (n, n))
    x = arithmetic.Mat(n, n, a.tolist(), 2)
    assert float(plants.determinant(x)) == pytest.approx(np.linalg.det(a / 2))
    flip = arithmetic.Mat(2, 2, [[-1, -2], [-2, -1]])  # I less twice a matrix of ones
    assert plants.one_sign([flip, flip])
    assert not plants.one_sign([flip, arithmetic.eye(2)])


def test_a_column_that_turns_halfway_isn_t_one():
    """E moves along u v' at both ends of the other parameter, and by both between."""
    rows = {(0, 0): 0, (1, 0): [[1, 0], [0, 0]], (0, 1): 0, (1, 1): [[0, 0], [0, 1]]}
    E = [arithmetic.eye(2) + arithmetic.Mat(2, 2, x or [[0, 0], [0, 0]])
         for x in rows.values()]  # fmt: skip
    points = [tuple(Fraction(e) for u in x.T.a for e in u) for x in E]
    assert not plants.corners_suffice(E, points)
    same = [E[0], E[1], E[0], E[1]]
    assert plants.corners_suffice(same, [points[0], points[1]] * 2)


def test_a_refusal_by_the_sum_of_the_poles_says_which_gains_are_free(tmp_path):
    """Of a law with structure the others may move the sum: here those of a rate."""
    one, tenth = np.eye(2).tolist(), (0.1 * np.eye(2)).tolist()
    plant, form = sos.SecondOrderSystem(one, tenth, one, one), [[1, 0], [0, "a"]]
    law = sos.PIDLaw(position=one, structure={"K_P": form})
    proof = sos.design_pid(plant, law=law, region=sos.PoleRegion(5)).infeasibility
    assert proof.claims[0].startswith("no gain of the law with 2 free numbers moves")
    assert "no gain of the law moves" in proof_of("sum of poles").claims[0]
    file = {"plant": dict(M=one, D=tenth, S=one, B=one, F=[[], []])}
    for structure, same in ((form, True), ([[1, 0], [0, 0]], False), (None, False)):
        asked = {"position": one, "structure": structure and {"K_P": structure}}
        path = tmp_path / "plant.json"
        path.write_text(json.dumps(file | {"law": asked}), "utf-8")
        assert (compare_plant(proof.data, path) == "") is same
