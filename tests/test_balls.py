"""Floats with bounds of their errors: they never prove what rationals don't."""

from fractions import Fraction

import numpy as np
import pytest
from flint import fmpq

from sosbook import PoleRegion, Polytope, SecondOrderSystem, design_pid
from sosbook.exact import balls, proof_file
from sosbook.exact.balls import BallReader, certain, surely_positive
from sosbook.exact.checker import arithmetic, kernel
from sosbook.exact.definite import pivots
from sosbook.exact.integers import Swift
from sosbook.exact.rational import rational_matrix

UNITS = 1e-9, 1.0, 9.81, 1e12


def binary(m):
    """The floats as the rationals that they are."""
    return rational_matrix([[fmpq(*float(e).as_integer_ratio()) for e in u] for u in m])


def truly(x):
    """Whether a matrix of rationals is positive definite, by its leading minors."""
    return pivots(x)[-1] > 0


def hard(rng, n):
    """Symmetric floats whose least eigenvalue is lost in their last bits."""
    rank = int(rng.integers(1, n + 1))
    g = rng.integers(-9, 10, (n, rank)) * rng.choice([1.0, 0.1, 0.3, 2.0**-20])
    m = g @ g.T
    m += np.eye(n) * rng.choice([0.0, 1e-17, -1e-17, 1e-15, -1e-15, 1e-13, 1e-9, 1.0])
    d = 10.0 ** rng.uniform(-1, 1, n) if rng.random() < 0.5 else np.ones(n)
    d *= np.array(rng.choice(UNITS, n)) if rng.random() < 0.5 else 1.0
    m = d[:, None] * m * d
    return np.tril(m) + np.tril(m, -1).T


def falsely(rng, rounds):
    """(matrices that floats prove, those that rationals don't), of some ``rounds``."""
    proven, false = 0, []
    for _ in range(rounds):
        m = hard(rng, int(rng.integers(1, 7)))
        e = abs(m) * rng.choice([0.0, 2.0**-53, 1e-12, 1e-6])
        e = np.maximum(e, e.T)
        if surely_positive(m, e):
            proven += 1
            v = np.linalg.eigh(m)[1][:, 0]
            far = binary(m) - binary(e) * np.where(np.outer(v, v) < 0, -1, 1)
            false += [m] if not (truly(binary(m)) and truly(far)) else []
    return proven, false


def test_floats_prove_no_matrix_that_isnt_positive_definite():
    proven, false = falsely(np.random.default_rng(1), 500)
    assert proven > 60 and not false


@pytest.mark.campaign
def test_floats_prove_nothing_false_of_many_matrices():
    proven, false = falsely(np.random.default_rng(2), 40_000)
    assert proven > 5000 and not false


def test_a_stack_is_proven_only_as_a_whole_and_nothing_odd_is():
    m = np.stack([np.eye(2), [[1.0, 1.0], [1.0, 1.0]]])
    assert surely_positive(m[:1], 0 * m[:1]) and not surely_positive(m, 0 * m)
    for odd in (np.nan, np.inf, 1e301, 1e-301):
        assert not surely_positive(np.array([[odd]]), np.zeros((1, 1)))
    assert not surely_positive(np.eye(2), np.full((2, 2), np.nan))


TEXTS = [
    "he(A P + B Y)",
    "[P, C'; ., g I(2)]",
    "kron([g, 2; 2, 1], P) - he(kron([0, 1; 0, 0], A P)) / 3",
    "A P A' / 7 + 2 P",
    "[he(A P), A, B; ., P, Y'; ., ., g]",
]


def random_file(rng, text):
    """A file of one statement, with decimals of odd sizes."""

    def rows(r, c, even=False):
        x = np.round(rng.normal(size=(r, c)), 12) * rng.choice(UNITS)
        x = x + x.T if even else x
        return [[repr(float(e)).removesuffix(".0") for e in u] for u in x]

    point = {"P": rows(2, 2, True), "Y": rows(1, 2)}
    unknowns = {"P": "symmetric 2", "Y": "1 x 2"}
    data = {"A": rows(2, 2), "B": rows(2, 1), "C": rows(2, 2), "g": "0.3"}
    lines = [f"x: {text} > 0"]
    return dict(text=lines, data=data, sets={}, unknowns=unknowns, point=point)


def seen(file, reader):
    """The matrix of a file's statement, as a reader computes it."""
    found = []
    kernel.check(file, lambda label, x, semi: found.append(x) or True, reader)
    return found[0]


@pytest.mark.parametrize("text", TEXTS)
def test_balls_hold_what_rationals_say(text):
    rng = np.random.default_rng(3)
    for _ in range(10):
        file = random_file(rng, text)
        exactly, ball = seen(file, Swift), seen(file, BallReader)
        plain = seen(file, kernel.Reader)
        assert exactly == plain and (not ball.even or plain == plain.T)
        for (i, j), m in np.ndenumerate(ball.m):
            far = abs(Fraction(m) - plain.at(i, j))
            assert far <= Fraction(ball.e[i, j]) < 1e-9 * (1 + abs(plain.at(i, j)))


def test_an_inverse_reads_its_matrix_once(monkeypatch):
    """For each row again, a regulator of 20 masses took seven seconds for it."""
    numbers, honest, n = [], arithmetic.number, 9
    monkeypatch.setattr(arithmetic, "number", lambda x: numbers.append(x) or honest(x))
    A = [["3" if i == j else f"0.{i + j}" for j in range(n)] for i in range(n)]
    P = [["2" if i == j else "0" for j in range(n)] for i in range(n)]
    lines, unknowns = ["x: he(P inv(A)) > 0"], {"P": f"symmetric {n}"}
    file = dict(text=lines, data={"A": A}, sets={}, unknowns=unknowns, point={"P": P})
    seen(file, BallReader)
    assert n**2 <= len(numbers) < 6 * n**2


def loops(P):
    """A file whose loops define matrices by vertices and by pairs."""
    lines = [
        "P: P > 0",
        "for i in all:",
        "  Q.i = he(A.i P A.i') + 2 P",
        "for i, j in pairs:",
        "  R = (Q.i + Q.j)/2",
        "  x.i.j: [R, A.i P; ., P] > 0",
    ]
    data = {f"A.{k}": [["0.5", f"0.{k}"], ["0", "0.3"]] for k in (1, 2, 3)}
    sets = {"all": [["1"], ["2"], ["3"]], "pairs": [["1", "2"], ["2", "3"], ["3", "3"]]}
    unknowns = {"P": "symmetric 2"}
    return dict(text=lines, data=data, sets=sets, unknowns=unknowns, point={"P": P})


@pytest.mark.parametrize("numbers", [2**17, 9])  # all rounds at once, or two
def test_loops_are_computed_together(monkeypatch, numbers):
    monkeypatch.setattr(balls, "NUMBERS", numbers)
    good = loops([["2", "0.1"], ["0.1", "1"]])
    found = {}
    for reader in (kernel.Reader, Swift, BallReader):
        some = found[reader] = []
        kernel.check(good, lambda label, x, semi: some.append(x) or True, reader)
    stacks = [x if x.m.ndim == 3 else x.m[None] for x in found[BallReader][1:]]
    mids = np.concatenate([getattr(x, "m", x) for x in stacks])
    assert found[Swift] == found[kernel.Reader] and len(mids) == 3
    for m, x in zip(mids, found[kernel.Reader][1:]):
        assert np.allclose(m, [[float(x.at(i, j)) for j in range(4)] for i in range(4)])
    assert certain(good)
    thin = [["2", "1.4142135623730951"], ["1.4142135623730951", "1"]]  # by 1e-16
    for P in (thin, [["1", "1"], ["1", "1"]], [["1", "0.1"], ["0.2", "1"]]):
        assert not certain(loops(P))


def test_what_isnt_symmetric_by_its_form_isnt_certain():
    file = loops([["2", "0.1"], ["0.1", "1"]])
    file["text"] = ["P: P > 0", "x: P A.1 + 9 > 0"]
    assert not certain(file)
    file["text"] = ["P: P > 0", "x: A.1 inv(A.1) == I(2)"]
    assert not certain(file) and kernel.check(file) == ["P", "x"]


def test_floats_prove_what_was_just_written_and_rationals_what_is_saved(
    tmp_path, monkeypatch
):
    springs = np.linspace(1, 1.4, 14)
    plants = [
        SecondOrderSystem([[m]], [[0.1]], [[s]], [[1]])
        for m, s in zip(np.linspace(1, 9.81, 14), springs)
    ]
    design = design_pid(Polytope(plants), region=PoleRegion(sigma=0.05))
    monkeypatch.setattr(proof_file, "LONG", 0)
    proof = design.certify()
    assert proof.proven and proof.examined.by_floats and proof.settled
    assert min(proof.blocks.values()) > 0 and not design.certify().failed
    read = proof_file.load(proof.save(tmp_path / "p.json") or tmp_path / "p.json")
    assert read.proven and not read.examined.by_floats
    assert read.claims == proof.claims
    monkeypatch.setattr(type(proof), "verify", lambda self: False)
    with pytest.raises(ArithmeticError, match="rounds in its own way"):
        proof.save(tmp_path / "p.json")
