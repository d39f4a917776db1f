"""Each `need` of the checker refuses a forged file, and nothing else does so before it.

`forged.json` has changes of proofs, one for a need; those of the language and of single
functions are here. A `need` that is new, or that is never reached, is missing below.
"""

import json
from decimal import Decimal, localcontext
from fractions import Fraction
from itertools import permutations, product
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import hadamard

import sosbook as sos
from sosbook.exact.checker import (
    arithmetic,
    delays,
    families,
    fixed_mode,
    kernel,
    payment,
    plants,
    regions,
    verdict,
)
from sosbook.exact.checker.language import Reader, parse
from sosbook.exact.rational import decimal
from sosbook.proofs.subject import compare_plant
from tests.cases import seeds
from tests.forged import base, changed, decided, needs, refusal
from tests.test_proof_files import proof_of

FORGED = [json.loads(x) for x in Path(__file__).with_name("forged.json").open("rb")]
NINES = "9" * 99_000
TINY = Fraction(1, 10**18)
AS_GOOD = [  # changes of proofs that are proofs
    ("known gain, outputs that differ", [[["plant", "vertices", k, name], x]
     for k in (0, 1)
     for name, x in (("C", [["1", "0"]]), ("D_u", [["0.1"]]), ("D_w", None))]),
    ("an LMI of one's own", [[["expressions", 0, 2, 0, 1], True]]),
    ("each input, a box", [[["requirements", 1, "x0"], [["0.3", "0.1", "0", "0"]]]]),
]  # fmt: skip


def text(lines, multipliers=None, **more):
    """A file of the kernel alone: a text with a number Y, at a point or multiplied."""
    whole = dict(text=lines.split("\n"), data={}, sets={}, unknowns={"Y": "number"})
    whole |= {"point": {"Y": "1"}} if multipliers is None else {}
    whole |= {"multipliers": multipliers} if multipliers is not None else {}
    return whole | more


ONE, TWO_I = {"a": "1"}, {"a": [["1", "0"], ["0", "1"]]}
CORNER = [[0, 0, 1], [0, 0, 0], [0, 0, 0]]
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
        "a matrix is needed, no number": "a: exp(1) > 0",
        "takes another number of arguments": "a: he(1, 2) > 0",
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
        "a matrix without unknowns is needed": ("a: norm(Y) > 0", ONE),
        "an unknown on the right": ("a: -1 > Y", ONE),
        "no size": ("a: -I(1 + Y) > 0", ONE),
    },
}
LOOP = "for i in s:\n  a.i: 1 > 0"


def exponential(x, units=0):
    """e^x by Decimal, and so many units of 2^-128 more, as a fraction."""
    with localcontext(prec=90):
        return str(Fraction(Decimal(x).exp()) + Fraction(units, 1 << 128))


def by_little():
    """Lines, with a number and a matrix, that are false of exponentials and norms."""
    yield "exp(x) - c", exponential("0.1249", 60), [["0.1249"]]
    yield "c - exp(x)", exponential("0.1249", -60), [["0.1249"]]
    yield "c - exp(x)", exponential("0.24", -1000), [["0.24"]]
    yield "c - norm(x)", "1", [["1"]]
    yield "c - norm(x)", "1.999", [[str(e) for e in u] for u in hadamard(4).tolist()]


MORE = [
    ("kernel", "words", text("a: 1 > 0") | {"text": "sha256:0"}),
    ("kernel", "words", text("a: 1 > 0") | {"text": [1]}),
    ("kernel", "names with values", text("a: 1 > 0", data=[])),
    ("kernel", "is no set", text(LOOP, sets={"s": ["1"]})),
    ("kernel", "is no shape", text("a: 1 > 0", unknowns={"Y": "2"})),
    ("kernel", "is no shape", text("a: 1 > 0", unknowns={"Y": "2 x 2 )"})),
    ("kernel", "isn't an identity", text("a: [1] == 1")),
    ("kernel", "isn't positive ", text("a: [1] > O(1, 1)")),
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
    ("arithmetic", "rows of a matrix differ", text("a: 1 > 0", data={"x": [[]]})),
    ("arithmetic", "an odd", text("a: 1 > 0", data={"x": {"zeros": [2000, 1]}})),
    ("arithmetic", "an odd", text("a: 1 > 0", data={"x": {"zeros": [2, 1], "y": 1}})),
    ("language", "a mirror image of nothing", text("a: [2, .; 1, 2] > 0")),
    ("language", "blocks that don't fit", text("a: [[1], O(2, 1); O(1, 1), [1]] > 0")),
    ("kernel", "isn't an identity", text("a: inv(2) == 1")),
    ("kernel", "isn't an identity",  # what 4000 digits and one more say
     text("a: (11/10) y^5 == x", data={"x": "1" + "0" * 4000, "y": "1e800"})),
    ("kernel", "a way out", text("a: Y > 0\nb: Y > 0", ONE | {"b": "1"})),
    ("kernel", "isn't positive ", text("a: [1, 2; 3, 50] > 0")),  # no symmetric one
    ("kernel", "isn't positive ",  # nearly a unit is lost of each entry, ten in all
     text("a: c - near(x) > 0", data={"c": f"{(10 << 128) + 9}/{1 << 128}",
          "x": [[f"{(1 << 148) + (1 << 20) - 1}/{1 << 148}"] * 10] * 10})),
    *(("kernel", "isn't positive ", text(f"a: {line} > 0", data=dict(c=c, x=x)))
      for line, c, x in by_little()),
]  # fmt: skip
TEXTS = MORE + [
    (module, words, text(*(given if isinstance(given, tuple) else (given,))))
    for table in (AT_A_POINT, MULTIPLIED)
    for module, rows in table.items()
    for words, given in rows.items()
]


def scaled(name, key, factor):
    def times(x):
        return decimal(factor * float(x)) if isinstance(x, str) else [*map(times, x)]

    return [times(base(name)[key])]


def edges():
    """The needs, the names and the changes of what is false by little."""
    x = Fraction(8, 1000), Fraction(12, 1000)
    (low, above), (below, high) = map(delays.exponential, x)
    for name, k, e, words in (
        ("legendre, varying", 0, above, "too large a factor"),
        ("legendre, varying", 0, low * Fraction(100001, 100000), "too large a factor"),
        ("legendre, varying", 1, below, "too small a factor"),
        ("legendre, varying", 1, high * Fraction(99999, 100000), "too small a factor"),
        ("delay", 0, Fraction(9232, 10000), "isn't rounded down"),
        ("delay", 1, Fraction(8870, 10000), "isn't rounded down"),
    ):
        yield ("delays", words), name, [[["exponentials", k], str(e)]]
    for low, high, need in (  # of e^32 and e^48, by Decimal
        (1 + TINY, 1, ("delays", "too large a factor")),
        (1 - TINY, 1 - TINY, ("delays", "too small a factor")),
        (1 - TINY, 1 + TINY, ("kernel", "isn't positive ")),
    ):
        far = [low * Fraction(exponential(32)), high * Fraction(exponential(48))]
        far = [["exponentials"], [*map(str, far)]]
        yield need, "legendre, varying", [[["delta"], "40"], far]
    alone = "the multipliers exclude nothing"
    for name in ("little force for a fast fall", "little force for a slow pair"):
        k = len(base(name)["requirements"]) - 1
        for x in ("spread", "blur"):
            tight = [[[x], *scaled(name, x, 0.98)]]
            yield ("small_input", "the part isn't enclosed"), name, tight
        wide = [[[x], *scaled(name, x, 1000)] for x in ("spread", "blur")]
        bound = [["requirements", k, "u_max"], edge(name, wide, k)]
        yield ("small_input", alone), name, [*wide, bound]
        given = base(name)
        none = [[[x], nought(given[x])] for x in ("share", "price")]
        none += [[["multipliers", i, 1], nought(z)]
                 for i, (_, z) in enumerate(given["multipliers"])]  # fmt: skip
        yield ("small_input", alone), name, none
    name, short = "little force for a fast fall", "the multiplier of u_max"
    price = [["price"], *scaled(name, "price", 0.3)]
    far = [[[x], *scaled(name, x, 1e6)] for x in ("spread", "blur")]
    for how in ([price, [["requirements", 0, "u_max"], "0.1"]], far):
        yield ("small_input", short), name, how
    for times in (0.25, 1, 10):
        for x, f in product("ab", (0.6, 0.999, 1.001, 1.6)):
            yield ("regions", "don't belong"), *ellipse(times, **{x: f})


def edge(name, changes, k):
    """The least float of a bound of u, requirement k, that a changed file can't refuse:
    where it lies depends on the processor that made the file.
    """
    low, high = 0.5, 4.0
    while low < (middle := (low + high) / 2) < high:
        bound = [["requirements", k, "u_max"], decimal(middle)]
        if refusal(decided, changed(name, [*changes, bound])) == "accepted":
            low = middle
        else:
            high = middle
    return decimal(high)


def ellipse(times, a=1, b=1):
    """The request of an ellipse by its matrices, times a number, with other words."""
    numbers = [[[-4, 3], [3, -4]], [[0, 1.5], [-0.5, 0]]]
    alpha, beta = ([[decimal(times * e) for e in u] for u in x] for x in numbers)
    words = dict(centre="-3", a=decimal(4.0 * a), b=decimal(2.0 * b))
    r = dict(kind="region", name="mine", form="ellipse", alpha=alpha, beta=beta)
    return "stability", [[["requirements"], [r | words]]]


def nought(x):
    return "0" if isinstance(x, str) else [nought(e) for e in x]


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
    bare = {k: v for k, v in whole.items() if k in verdict.PLAIN} | {"data": {}}
    for words, file in {
        "no proof file": {},
        "there is no version": {"format": verdict.FORMAT},
        "a file without a text has other keys": bare,
        "the digests are of other data": whole | {"about": {}},
        "there is no {x:.40}": whole | {"data": {}},
        "isn't what is written": whole | {"sets": {}},
    }.items():
        yield "verdict", words, check, file
    yield "verdict", "no multipliers exclude that", verdict.text_of, refused
    yield "kernel", "a key comes twice", kernel.contents, '{"a": 1, "a": 2}'
    yield "kernel", "too many digits", kernel.contents, "1" * 401
    yield "subject", "that is no number", verdict.wanted_gain, {"K": [[True]]}
    for line in ("inv(A)", "at(A, 1, 1)", "tr(A)"):
        yield "payment", "{x[0]} moves", moves, f"x: {line} > 0"
    yield "payment", "{label} moves", moves, "x: A == [2]"


def test_every_need_refuses_a_file_that_is_forged(tmp_path, monkeypatch, capsys):
    rows = [*((m, w, kernel.check, file) for m, w, file in TEXTS), *of_files()]
    rows += [
        (*need, decided, changed(name, how)) for need, name, how in (*FORGED, *edges())
    ]
    for name in {name for _, name, _ in FORGED}:
        decided(base(name))  # what isn't changed is a proof
    for name, how in AS_GOOD:
        decided(changed(name, how))
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


def test_a_number_of_more_than_four_thousand_digits_is_read_whole():
    """Python reads fewer at once."""
    long = text("a: y^5 == x", data={"x": "1" + "0" * 4000, "y": "1e800"})
    assert kernel.check(long) == ["a"]


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
    steps = (1e-3, True), (1e-8, True), (-1e-8, True), (-3e-6, False), (-1e-3, False)
    for step, out in steps:
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


def test_words_of_a_region_are_true():
    """An ellipse by its own matrices is taken; Re s < 2.5 doesn't say Re s < -2.5."""
    for times in (0.25, 1, 10):
        (_, (r,)) = ellipse(times)[1][0]
        assert regions.region(r)[2].endswith("half axes 4 and 2 around -3")
    for degrees in (0.3, 30, 68.76, 89):
        found = float(regions.tangent(Fraction(degrees)))
        assert found == pytest.approx(np.tan(np.radians(degrees)), rel=1e-12)
    r = dict(kind="region", name="mine", form="half-plane", sigma="-2.5")
    r |= dict(alpha=[["-5"]], beta=[["1"]])
    asked = changed("stability", [[["requirements"], [r]]])
    text, claims = verdict.text_of(asked)
    kernel.check(text.file())
    assert claims[1].endswith("half-plane Re s < 2.5")


@pytest.mark.parametrize("seed", seeds(5))
def test_a_mode_s_distance_and_mirror_images_are_those_of_numpy(seed):
    rng = np.random.default_rng(seed)
    h = [Fraction(float(x)) for x in rng.normal(size=5)]
    x, y = rng.normal(size=2)
    of = np.polynomial.Polynomial([float(e) for e in h])
    there = [abs(of(x + 1j * y)) * 4, abs(of.deriv()(x + 1j * y))]
    found = fixed_mode.steps(h, Fraction(x), Fraction(y))
    assert [float(e) for e in found] == pytest.approx(np.square(there))
    r, c, a, b = (int(k) for k in rng.integers(1, 9, 4))
    disk = [[-r, -c], [-c, -r]], [[0, 1], [0, 0]]
    disk = [[list(map(Fraction, row)) for row in x] for x in disk]
    for third, same in ((Fraction(r * r, a + r + 1), True), (a + r + 2, False)):
        h = [Fraction(1)]
        for root in (c + a + r + 1, c + third, c + b + r, c + Fraction(r * r, b + r)):
            h = [p - root * q for p, q in zip([0, *h], [*h, 0])]
        assert fixed_mode.mirrored(*disk, h) is same
    assert not fixed_mode.mirrored(*disk, [Fraction(x) for x in (c * c, -2 * c, 1)])
    for roots in ((c + r + 1,), (c + a, c - Fraction(r * r, a))):
        h = [Fraction(1)]
        for root in roots:
            h = [p - root * q for p, q in zip([0, *h], [*h, 0])]
        assert not fixed_mode.mirrored(*disk, h)
    h = [Fraction(x) for x in (c * c - r * r, -2 * c, 1)]  # c + r and c - r
    wide = [[Fraction(0), Fraction(2)], [Fraction(1), Fraction(0)]]
    assert fixed_mode.mirrored(*disk, h) and not fixed_mode.mirrored(disk[0], wide, h)
    line = [[Fraction(2)]], [[Fraction(1)]]
    assert not fixed_mode.mirrored(*line, [Fraction(e) for e in (1, 2, 3, 1)])
    sector = [[[Fraction(0)] * 2] * 2, [[Fraction(1), Fraction(1)]] * 2]
    assert not fixed_mode.mirrored(*sector, [Fraction(0), Fraction(0), Fraction(1)])


@pytest.mark.parametrize("order", [*permutations(range(3))])
@pytest.mark.parametrize("suffice, E, B", [
    (True, lambda p, q, r: (p, 0, 2 * p, 0), lambda p, q, r: (0, 0)),
    (True, lambda p, q, r: (p, 0, 2 * p, 0), lambda p, q, r: (q, r)),
    (True, lambda p, q, r: (p, 0, 2 * p, 0), lambda p, q, r: (p, 2 * p)),
    (True, lambda p, q, r: (p + p * q, 0, p * r, 0), lambda p, q, r: (0, 0)),
    (False, lambda p, q, r: (p, 0, 2 * p, 0), lambda p, q, r: (p, p)),
    (False, lambda p, q, r: (-2 * p, 0, 0, 0), lambda p, q, r: (0, 0)),
    (False, lambda p, q, r: (p - p * q, 0, 0, p * q), lambda p, q, r: (0, 0)),
    (False, lambda p, q, r: (p - p * r, 0, 0, p * r), lambda p, q, r: (q, q)),
    (False, lambda p, q, r: (p + q - p * q, q, 0, p * q), lambda p, q, r: (0, 0)),
])  # fmt: skip
def test_corners_suffice_where_each_change_has_one_column(order, suffice, E, B):
    """E moves in a parameter by multiples of a column, and B along it or not at all."""
    several, points = [], []
    for k in range(8):
        where = [k >> i & 1 for i in order]
        a, b, c, d = E(*where)
        several.append(arithmetic.Mat(2, 2, [[1 + a, b], [c, 1 + d]]))
        points.append(tuple(map(Fraction, (1 + a, c, b, 1 + d, *B(*where)))))
    assert plants.corners_suffice(several, points) is suffice


def test_a_third_column_of_E_moves_too_and_a_box_has_all_its_corners():
    I3 = [arithmetic.eye(3), arithmetic.eye(3) + arithmetic.Mat(3, 3, CORNER)]
    points = [(*map(Fraction, sum(E.T.a, [])), *B) for E, B in zip(I3, ((0,), (1,)))]
    points = [(*p, Fraction(0), Fraction(0)) for p in points]
    assert not plants.corners_suffice(I3, [(*p[:9], 0, p[9], 0) for p in points])
    one, x, y = arithmetic.eye(2), *([[1, 0], [0, 0]], [[0, 0], [0, 1]])
    E = [one, *(one + arithmetic.Mat(2, 2, e) for e in (x, y, [[1, 0], [0, 1]]))]
    points = [tuple(map(Fraction, sum(e.T.a, []))) for e in E]
    assert plants.suffice(E, points) and not plants.suffice(E[:3], points[:3])


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


@pytest.mark.parametrize("seed", seeds(30))
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


def of_design(plant, gain=None, **asked):
    """What a proof of a design, or of a known gain, asks."""
    by = (
        (sos.design_pid, (plant,)) if gain is None else (sos.analyse_pid, (plant, gain))
    )
    proof = by[0](*by[1], region=sos.PoleRegion(0.1, 1.5, 20), **asked).certify()
    data = {k: v for k, v in proof.data.items() if k not in ("claims", "blocks")}
    return {"kind": proof.kind, **data}


def test_three_coefficients_of_a_square_are_no_corners_of_two_ranges():
    """E moves along one column, then along two: between them only pairs speak."""
    one = np.eye(2)
    plants_ = sos.Uncertain(
        lambda p: sos.SecondOrderSystem(
            np.diag([1 + p, 1 + p**2]), 0.3 * one, one, one
        ),
        p=(0, 1),
    )
    for coupling, where in (("vertices", "each of the 3"), ("pairs", "every constant")):
        asked = of_design(plants_, coupling=coupling)
        file, claims = verdict.text_of(asked)
        kernel.check(file.file())
        assert claims[0].startswith(where)


def test_a_range_in_pieces_keeps_them_out_of_a_known_gain_s_corners():
    plants_ = sos.Uncertain(
        lambda p: sos.SecondOrderSystem(1 + p, 0.3, 1 + p**2, 1), p=(0, 1)
    ).cut(p=2)
    asked = of_design(plants_, [[-1.0, -0.5]], coupling="multipliers")
    assert asked["plant"]["parameters"] == [["p", "0", "1", 2]]
    decided(asked)


def test_a_state_that_the_gain_moves_is_no_integral_of_what_is_measured():
    law = sos.DynamicLaw(order=1, position=[[1]])
    gains = {"A_c": [[-2.0]], "B_c": [[1.0]], "C_c": [[-0.1]]}
    seen = sos.HInfinity(50.0, outputs=sos.Output(position=1))
    loop = sos.analyse_pid(
        sos.SecondOrderSystem(1, 0.3, 1, 1, 1), gains, law=law, requirements=[seen]
    )
    assert (
        verdict.check(loop.certify().text)[1]
        == "its H-infinity norm to 1 z is below 50"
    )


def test_what_is_not_enclosed_weakens_a_refusal_in_proportion():
    """Twice the width takes twice as much from the bound, whatever floats found it."""
    name = "little force for a slow pair"
    k = len(base(name)["requirements"]) - 1
    start = [["requirements", k, "x0"], ["0.3", "1", "0", "0.7"]]

    def bound(times):
        wide = [[[x], *scaled(name, x, times)] for x in ("spread", "blur")]
        return float(edge(name, [*wide, start], k))

    one, two, three = map(bound, (500, 1000, 1500))
    assert one > two > three
    assert two - three == pytest.approx(one - two, rel=0.05)


def test_a_vertex_of_ranges_is_named_by_its_parameters():
    """The first parameter changes last, or first: each corner has its own words."""
    plant = {"kind": "second order", "parameters": [["q", "0", "3"], ["r", "5", "7"]]}
    plant |= {x: [["q*r + 1" if x == "D" else "1"]] for x in "MDSBF"}
    built = families.given_vertices(plant)
    for k, v in enumerate(built, 1):
        words = families.vertex_words(plant, k, len(built))
        q, r = (
            float(x.split(" = ")[1]) for x in words.split("with ")[1].split(" and ")
        )
        assert float(Fraction(v["D"][0][0])) == 1 + q * r


@pytest.mark.parametrize("multiplied", [False, True])
def test_the_kernel_alone_says_what_a_point_or_multipliers_show(
    multiplied, tmp_path, capsys
):
    given = text("a: -1 > 0", ONE) if multiplied else text("a: 1 > 0")
    (tmp_path / "file.json").write_text(json.dumps(given), "utf-8")
    assert kernel.main([str(tmp_path / "file.json")]) == 0
    how = "not all positive definite" if multiplied else "positive definite"
    assert capsys.readouterr().out == f"{how}: a\n"


def test_what_a_reader_wants_is_compared_name_by_name(tmp_path):
    """A plant in its envelope says U and K_A, too, by leaving them out."""
    U, plant = [[1.0, 0.0]], dict(M=[[1.0, 0], [0, 1]], D=[[0.3, 0], [0, 0.3]])
    plant |= dict(S=[[1.0, 0], [0, 1]], B=[[1.0, 0], [0, 1]], F=[[], []])
    design = sos.design_pid(sos.SecondOrderSystem(**plant), U=U)
    proof = design.certify()
    gain = [[float(x) for x in row] for row in proof.data["K"]]
    proofs = {"loop": proof.text, "sum": proof_of("sum of poles").text}
    files = dict(
        proofs, bare=plant, whole=dict(plant=plant, U=U), no_U=dict(plant=plant)
    )
    files |= dict(more=dict(plant=plant, U=U, K_A=[[0.1, 0], [0, 0.1]]))
    files |= dict(gain={"K": gain}, other=[[0.0] * 5] * 2)
    for name, value in files.items():
        said = value if isinstance(value, str) else json.dumps(value)
        (tmp_path / name).write_text(said, "utf-8")
    for proof, option, name, code in (
        ("loop", "plant", "bare", 0),
        ("loop", "plant", "whole", 0),
        ("loop", "plant", "no_U", 1),
        ("loop", "plant", "more", 1),
        ("loop", "gain", "gain", 0),
        ("loop", "gain", "other", 1),
        ("sum", "gain", "other", 1),
        ("sum", "plant", "whole", 1),
    ):
        asked = [str(tmp_path / proof), f"--{option}", str(tmp_path / name)]
        assert verdict.main(asked) == code, (proof, option, name)
