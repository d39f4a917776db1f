"""Enclosed matrices of the checker, held to mpmath, which knows nothing of them."""

import random
from fractions import Fraction
from itertools import product

import mpmath
import numpy as np
import pytest
from flint import ctx

import sosbook as sos
from sosbook.exact import proof_file, rounded
from sosbook.exact.checker import arithmetic as a
from sosbook.exact.checker.kernel import check
from sosbook.exact.checker.language import Reader, Val
from sosbook.exact.enclosing import Ball, Enclosing
from sosbook.exact.proof import Examined
from sosbook.exact.rounded import Rounded, Rounding, surely
from tests.cases import seeds
from tests.test_balls import binary, hard, truly

UNIT = mpmath.mpf(2) ** -a.BALL
SIZES = Fraction(1, 10**5), Fraction(1, 10), Fraction(1), Fraction(9)


@pytest.fixture(autouse=True)
def many_digits():
    with mpmath.workprec(500), ctx.workprec(2 * a.BALL):
        yield


def matrix(x):
    """A list of rows of fractions, or the middle of a `Mat`, for mpmath."""
    if isinstance(x, a.Mat):
        x = [[Fraction(e, x.d) for e in u] for u in x.a]
    return mpmath.matrix([[mpmath.mpf(e.numerator) / e.denominator for e in u]
                          for u in x])  # fmt: skip


def inside(ball, x):
    """Whether x differs from the middle of the ball by what the ball says, at most."""
    off = (matrix(ball) - x) / UNIT
    rows = [[float(off[i, j]) for j in range(off.cols)] for i in range(off.rows)]
    return np.linalg.norm(rows, 2) <= ball.e * (1 + 1e-9)


def around(x):
    """A ball of the norm around a `Ball`, which has one for each entry."""
    middles, radii = ([[Fraction(int(n)) * Fraction(2) ** int(p)
                        for n, p in (part(e).man_exp() for e in row)]
                       for row in x.m.table()]
                      for part in (lambda e: e.mid(), lambda e: e.rad()))  # fmt: skip
    return widened(a.gather(middles, x.c).near(), a.gather(radii, x.c).long())


def drawn(rng, r, c, size):
    """Fractions, some of which round as badly as any."""
    bad = [1 - Fraction(1, 1 << k) for k in (a.BALL + 1, a.BALL + 3)]
    return [[rng.choice([*bad, Fraction(rng.randint(-(10**6), 10**6), 10**6)]) * size
             for _ in range(c)] for _ in range(r)]  # fmt: skip


def widened(x, e):
    return a.Mat(x.r, x.c, x.a, x.d, x.e + e)


def member(rng, ball):
    """One of the outermost matrices of a ball: a change of rank one."""
    u, v = (np.array([rng.gauss(0, 1) for _ in range(k)]) for k in (ball.r, ball.c))
    change = np.outer(u / np.linalg.norm(u), v / np.linalg.norm(v))
    far = ball.e * (1 - mpmath.mpf(10) ** -12) * UNIT
    return matrix(ball) + far * mpmath.matrix(change.tolist())


@pytest.mark.parametrize("seed", seeds(8))
def test_what_is_made_of_balls_holds_what_is_made_of_their_members(seed):
    rng = random.Random(seed)
    n, m, size = rng.randint(1, 5), rng.randint(1, 4), rng.choice(SIZES)
    p, q = drawn(rng, n, n, size), drawn(rng, n, m, size)
    x, y = a.gather(p, n), a.gather(q, m)
    assert 0 < x.near().e <= n + 1 and inside(x.near(), matrix(p))
    X = widened(x.near(), 1 << rng.choice((20, 100, 125)))
    Y = widened(y.near(), 1 << rng.choice((18, 90, 122)))
    M, P = member(rng, X), member(rng, Y)
    assert inside(X + X, M + M) and inside(X @ Y, M * P)
    assert inside(X @ y, M * matrix(q)) and inside(x @ Y, matrix(p) * P)
    assert (X + X).e == 2 * X.e and inside(X.T, M.T)
    most = (X.e * Y.long() + X.long() * Y.e >> a.BALL) + n + m + 3
    assert (X @ Y).e <= most  # and no wider than it must be
    f = Fraction(rng.randint(-50, 50), 7)
    assert inside(X.times(f), M * (mpmath.mpf(f.numerator) / f.denominator))
    assert X.times(f).e <= abs(f) * X.e + n + 3
    assert X.cut(0, 1, 0, n).e == X.e


def exponential(x, reader):
    E = reader({}).op_exp(Val(x)).v
    return around(E) if isinstance(E, Ball) else E


@pytest.mark.parametrize("reader", [Reader, Enclosing])
@pytest.mark.parametrize("seed", seeds(8))
def test_exponentials_norms_and_signs_are_those_of_every_member(seed, reader):
    rng = random.Random(seed)
    n, size = rng.randint(1, 5), rng.choice((*SIZES, Fraction(3, 16 * 5)))
    p = drawn(rng, n, n, size)
    x = a.gather(p, n)
    E = exponential(x, reader)
    assert inside(E, mpmath.expm(matrix(p))) and E.e < 1 << 70
    wide = widened(x.near(), 1 << rng.choice((20, 100)))
    assert inside(exponential(wide, reader), mpmath.expm(member(rng, wide)))
    true = np.linalg.norm(np.array(p, float), 2)
    assert true * (1 - 1e-12) <= float(a.norm(x)) <= true * 1.12
    M = member(rng, wide)
    rows = [[float(M[i, j]) for j in range(n)] for i in range(n)]
    assert float(a.norm(wide)) >= np.linalg.norm(rows, 2) * (1 - 1e-12)
    S = x @ x.T + a.eye(n).times(Fraction(1, 1000))
    least = np.linalg.eigvalsh(np.array([[float(S.at(i, j)) for j in range(n)]
                                         for i in range(n)]))[0]  # fmt: skip
    if least > 1e-9:
        units = int(least * (1 << 60)) << a.BALL - 60
        for share, so in ((Fraction(999, 1000), True), (Fraction(1001, 1000), False)):
            ball = a.Mat(n, n, S.near().a, 1 << a.BALL, int(units * share))
            assert a.definite(ball.below()) is so


@pytest.mark.parametrize("seed", seeds(4))
def test_the_exponential_of_what_stands_still_is_the_identity(seed):
    rng = random.Random(seed)
    n, still = rng.randint(2, 6), rng.randint(0, 1)
    p = drawn(rng, n, n, rng.choice(SIZES))
    for k in {still, n - 1 - still}:
        p[k] = [Fraction(0)] * n
        for u in p:
            u[k] = Fraction(0)
    row = drawn(rng, n, n, 1)
    row[still] = [Fraction(0)] * n  # moves others, and isn't moved
    for x in (p, row, [[Fraction(0)] * n] * n):
        E = exponential(a.gather(x, n), Enclosing)
        assert inside(E, mpmath.expm(matrix(x))) and E.e < 1 << 70
    assert E.e < 1 << 10


@pytest.mark.parametrize("less, proven", [("-1e-33", True), ("1e-33", False)])
def test_where_few_bits_prove_too_little_the_most_decide(less, proven):
    whole = file_of("a: near(one) - less - one > 0", one=[["1"]], less=[[less]])
    whole["kind"] = "sampled"
    assert Examined.by_kernel(whole, ["said"], {}).proven is proven
    whole["text"] = ("p = near(one) - less - one", "a: at(p, 1, 1) > 0")
    with pytest.raises(a.Refused, match="exact"):
        Examined.by_kernel(whole, ["said"], {})


@pytest.mark.parametrize("seed", seeds(4))
def test_balls_of_entries_hold_what_is_made_of_members(seed):
    rng = random.Random(seed)
    n, m, k = (rng.randint(1, 5) for _ in range(3))
    x, y = (a.gather(drawn(rng, *s, rng.choice(SIZES)), s[1]) for s in ((n, m), (m, k)))
    wide = widened(y.near(), 1 << 90)
    for p, q in ((x.near(), y), (x, wide), (x.near(), wide)):
        P, Q = (member(rng, z) if z.e else matrix(z) for z in (p, q))
        for ways in ((Ball.of(p), q), (p, Ball.of(q)), (Ball.of(p), Ball.of(q))):
            left, right = map(Val, ways)
            both = around(Enclosing({}).op_mul(left, right).v)
            assert inside(both, P * Q) and both.e <= 5 * (p @ q).e + (1 << 12)
            with pytest.raises(a.Refused, match="shapes that don't fit"):
                Enclosing({}).op_mul(left, Val(Ball.of(a.zeros(m + 1, 2))))
        B = Ball.of(q)
        assert inside(around(B + q), Q + matrix(q)) and inside(around(B.T), Q.T)
        assert inside(around(B.times(Fraction(3, 7))), Q * 3 / 7)
        assert inside(around(B.cut(0, 1, 0, k)), Q[0, :])
        true = np.linalg.norm(np.array(Q.tolist(), float), 2)
        assert true * (1 - 1e-12) <= float(B.norm()) <= true * 1.12


@pytest.mark.parametrize("x", [Fraction(1, 8), Fraction(1, 5), Fraction(249, 1000)])
def test_the_series_is_long_enough_where_it_is_longest(x):
    E = a.exponential(a.gather([[x]], 1))
    assert inside(E, matrix([[x]]).apply(mpmath.exp)) and E.e <= 64


@pytest.mark.parametrize("of", [lambda x: x, Ball.of])
def test_a_ball_is_never_taken_for_its_middle(of):
    ball = of(a.gather([[Fraction(2)]], 1).near())
    for use in (
        lambda: ball == ball,
        lambda: ball.dot(ball),
        lambda: ball.at(0, 0),
        lambda: a.inverse(ball),
        lambda: a.trace(ball),
        lambda: a.kron(ball, ball),
        lambda: a.definite(ball),
    ):
        with pytest.raises(a.Refused, match="an exact one is needed"):
            use()


def held(x):
    """A ball of the norm around `Rounded`."""
    middle = a.gather([[Fraction(e) for e in u] for u in x.m.tolist()], x.c).near()
    return widened(middle, int(Fraction(x.off) * (1 << a.BALL)) + 1)


@pytest.mark.parametrize("seed", seeds(8))
def test_floats_with_a_bound_hold_what_is_made_of_members(seed):
    rng = random.Random(seed)
    n, m, k = (rng.randint(1, 6) for _ in range(3))
    size = rng.choice((*SIZES, Fraction(3, 80)))
    x, y = (a.gather(drawn(rng, *s, size), s[1]) for s in ((n, m), (m, k)))
    z = a.gather(drawn(rng, n, n, size), n)
    wide = Rounded.of(y)
    wide.off += 10.0 ** rng.uniform(-16, -4)
    for p, q in ((Rounded.of(x), y), (x, wide), (Rounded.of(x), wide)):
        P, Q = (member(rng, held(u)) if isinstance(u, Rounded) else matrix(u)
                for u in (p, q))  # fmt: skip
        both = p @ q
        assert inside(held(both), P * Q)
        tight = n + m + k + 3 * abs(float(Fraction(wide.off)) / 2**-53)
        assert both.off <= 2**-50 * tight * (1 + float(size)) ** 2 * 6**2
        q = Rounded.of(q)
        assert inside(held(q + q), 2 * Q) and inside(held(q.T), Q.T)
        assert inside(held(q.times(Fraction(-3, 7))), Q * -3 / 7)
        assert inside(held(q.cut(0, 1, 0, k)), Q[0, :])
        true = np.linalg.norm(np.array(Q.tolist(), float), 2)
        assert true * (1 - 1e-12) <= float(q.norm()) <= true * 1.12 + 2 * wide.off
    for off in (0.0, 1e-9, 1e-3):
        ball = Rounded.of(a.gather(drawn(rng, n, n, size), n))
        ball.off += off
        E = ball.exponential()
        assert inside(held(E), mpmath.expm(member(rng, held(ball))))
        assert E.off <= (ball.off + 1e-14) * 100 * np.exp(2 * ball.long)
    whole = Rounding({}).joined(n + m, n + k, [(0, 0, Rounded.of(z)), (n, n, wide)])
    assert inside(held(whole).cut(n, m, n, k), matrix(held(wide)))
    assert whole.off >= wide.off


@pytest.mark.parametrize("seed", seeds(2))
def test_floats_with_a_bound_never_prove_what_may_be_false(seed):
    rng, proven = np.random.default_rng(seed), 0
    for _ in range(200):
        m = hard(rng, int(rng.integers(1, 7)))
        off = abs(m).max() * rng.choice([0.0, 1e-16, 1e-12, 1e-6])
        if Rounded(m / 2, off).positive():
            proven += 1
            far = binary(2 * off * np.eye(len(m)))
            assert truly(binary(m) - far)
    assert proven > 20


def file_of(*lines, **data):
    return dict(text=lines, data=data, sets={}, unknowns={}, point={})


SURE = {  # by floats
    "a: 5.6 - norm([3, 4]) > 0",
    "a: [exp(X), 0; 0, 1] exp([0, 1; -1, 0]) > 0",
    "a: most(2, norm(I(3)), 1) - 2 >= 0",
    "a: norm([3, 4]) - 5 >= 0",
}


@pytest.mark.parametrize(
    "line, good",
    [
        # e = 2.71828 18284 59045 23536 02874 71352 66249 7757..
        ("a: exp(X) - 2.71828182845904523536028747135266249 > 0", True),
        ("a: exp(X) - 2.71828182845904523536028747135266250 > 0", False),
        ("a: 2.71828182845904523536028747135266250 - exp(X) > 0", True),
        ("a: norm([3, 4]) - 5 >= 0", True),
        ("a: 5.6 - norm([3, 4]) > 0", True),
        ("a: most(2, norm(I(3)), 1) - 2 >= 0", True),
        ("a: exp(X) - exp(X) >= 0", False),  # each may be another member
        ("a: [exp(X), 0; 0, 1] exp([0, 1; -1, 0]) > 0", True),  # X + X' decides
        ("a: exp(65 X) > 0", False),  # too large
        ("a: exp([X, X]) > 0", False),  # not square
        ("a: exp(2) > 0", False),  # a number, no matrix
        ("a: near(X) == X", False),
    ],
)
def test_a_text_may_speak_of_enclosed_matrices(line, good):
    file = file_of(line, X=[["1"]])
    sure = surely(file)
    assert sure is (line in SURE) and (good or not sure)
    for reader in (Reader, Enclosing):
        if good:
            assert check(file, of=reader) == ["a"]
        else:
            with pytest.raises(a.Refused):
                check(file, of=reader)


@pytest.mark.parametrize("columns", [1, a.LONG - 1, a.LONG, a.LONG + 9])
def test_products_of_long_rows_are_those_entry_by_entry(columns):
    """Also where all entries are the largest of their length, of either sign."""
    for bits in (1, 7, 8, 60, 131):
        top = 2**bits - 1
        for signs in product((-1, 0, 1), repeat=2):
            x, y = (a.Mat(r, c, [[s * top] * c for _ in range(r)])
                    for (r, c), s in zip([(2, 5), (5, columns)], signs))  # fmt: skip
            assert (x @ y).a == [[5 * signs[0] * signs[1] * top**2] * columns] * 2
        mixed = [
            [(-1) ** (i * j) * (top >> j) for j in range(columns)] for i in range(5)
        ]
        x, y = a.Mat(1, 5, [[3, -top, 0, 1, top]]), a.Mat(5, columns, mixed)
        assert (x @ y).a[0] == [
            sum(u * v for u, v in zip(x.a[0], column)) for column in zip(*mixed)
        ]
    assert (a.zeros(2, 0) @ a.zeros(0, columns)).a == [[0] * columns] * 2


def test_floats_prove_a_long_text_and_rationals_what_is_saved(tmp_path, monkeypatch):
    monkeypatch.setattr(proof_file, "LONG", 0)
    plants = sos.Polytope(
        [sos.SecondOrderSystem([[m]], [[0.003]], [[9.81]], [[1]]) for m in (0.9, 1.1)]
    )
    asked = plants, [[-1, -1.2]], (0.1, 0.2), (0, 0.03)
    proof = sos.certify_sampled(*asked)
    assert proof.proven and proof.examined.by_floats and proof.settled
    assert min(proof.blocks.values()) > 0
    read = proof_file.load(proof.save(tmp_path / "p.json") or tmp_path / "p.json")
    assert read.proven and not read.examined.by_floats and read.claims == proof.claims
    monkeypatch.setattr(rounded, "surely", lambda whole: False)
    other = sos.certify_sampled(*asked)
    assert other.text == proof.text and other.proven
    proof_file._remembered.cache_clear()
    assert not type(proof).of(proof.data).examined.by_floats
