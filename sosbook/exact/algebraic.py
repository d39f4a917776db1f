"""Roots of rational polynomials and the regions they lie in, exactly."""

from dataclasses import dataclass

from flint import acb, arb, ctx, fmpq, fmpq_poly

from ..runtime.time_limit import check_time

DEGREE_OF_A_SECOND = 130  # of a polynomial whose roots take about so long
BALL_BITS = 64, 128, 256, 512  # of the balls, the next where one doesn't decide


class _Factor:
    """A polynomial without multiple roots, and balls around these."""

    def __init__(self, polynomial):
        self.polynomial, self._known = polynomial, {}

    def balls(self, bits):
        """Disjoint balls, each with one root."""
        if bits not in self._known:
            check_time((self.polynomial.degree() / DEGREE_OF_A_SECOND) ** 4)
            with ctx.workprec(bits):
                roots = [ball for ball, _ in self.polynomial.complex_roots()]
            self._known[bits] = roots
        return self._known[bits]


@dataclass(frozen=True, eq=False)
class Root:
    """A root ``of`` a `_Factor`: ``index`` says in which of the first balls it is."""

    of: _Factor
    index: int

    def ball(self, bits=BALL_BITS[0]):
        """A complex ball, of ``bits`` or more, with this root and no other."""
        first = self.of.balls(BALL_BITS[0])[self.index]
        if bits == BALL_BITS[0]:
            return first
        overlapping = [b for b in self.of.balls(bits) if b.overlaps(first)]
        return overlapping[0] if len(overlapping) == 1 else first

    @property
    def factor(self):
        """The polynomial without square factors that has this root."""
        return self.of.polynomial

    def __complex__(self):
        mid = self.ball().mid()
        return complex(float(mid.real), float(mid.imag))

    def inside(self, alpha, beta):
        """True if alpha + beta s + beta' conj(s) is negative definite; None if
        unproven.

        None where the root is on the boundary, or too close to it to tell.

        >>> root, = roots_of(fmpq_poly([3, 1]))
        >>> root.inside([[fmpq(2)]], [[fmpq(1)]])  # Re s < -1
        True
        >>> root.inside([[fmpq(6)]], [[fmpq(1)]])  # Re s < -3
        False
        """
        if self.factor.degree() == 1:
            s = -self.factor[0] / self.factor[1]
            return _definite(alpha, beta, s, s, fmpq(0))
        for bits in BALL_BITS:
            check_time()
            s = self.ball(bits)
            with ctx.workprec(bits):
                verdict = _definite(alpha, beta, s, s.conjugate(), arb(0))
            if verdict is not None:
                return verdict
        return False if self._on_boundary(alpha, beta) else None

    def _on_boundary(self, alpha, beta):
        """True if the root certainly lies on a line or circle, the boundary."""
        mirror, reflect = reflections(alpha, beta)
        if mirror is None:
            return False
        common = self.factor.gcd(mirror(self.factor))
        if common.degree() < 1:
            return False
        common, cofactor = _Factor(common), _Factor(self.factor // common)
        for bits in BALL_BITS[1:]:
            check_time()
            balls, own = common.balls(bits), self.ball(bits)
            with ctx.workprec(bits):
                same = [b for b in balls if b.overlaps(own)]
                image = [b for b in balls if b.overlaps(reflect(own))]
            foreign = [b for b in cofactor.balls(bits) if b.overlaps(own)]
            if len(same) == len(image) == 1 and not foreign:
                # the mirror takes roots of `common` to roots of `common`
                return same[0] is image[0]
        return False


def roots_of(polynomial):
    """The distinct roots of a ``polynomial`` with rational coefficients, each once.

    >>> [complex(r) for r in roots_of(fmpq_poly([0, 2, 1]))]
    [0j, (-2+0j)]
    """
    factors = []
    for factor, _ in polynomial.factor_squarefree()[1]:
        shift = next(k for k in range(factor.degree() + 1) if factor[k] != 0)
        if shift:  # the root zero, and the rest
            factors.append(fmpq_poly([0, 1]))
            factor = factor.right_shift(shift)
        if factor.degree() > 0:
            factors.append(factor)
    return [
        Root(f, k) for f in map(_Factor, factors) for k in range(f.polynomial.degree())
    ]


def _definite(alpha, beta, s, conjugate, zero):
    """True if -(alpha + beta s + beta' conj(s)) > 0; None where balls can't tell."""
    k = len(alpha)
    rows = [
        [
            -(zero + alpha[i][j] + beta[i][j] * s + beta[j][i] * conjugate)
            for j in range(k)
        ]
        for i in range(k)
    ]
    for i in range(k):
        pivot = rows[i][i]
        pivot = pivot.real if isinstance(pivot, acb) else pivot
        if pivot <= 0:
            return False
        if not pivot > 0:
            return None
        for j in range(i + 1, k):
            ratio = rows[j][i] / pivot
            rows[j] = [x - ratio * y for x, y in zip(rows[j], rows[i])]
    return True


def reflections(alpha, beta):
    """Two maps that mirror roots, and balls, at the boundary of a region alpha, beta.

    Both are None but for half-planes (one row) and disks.
    """
    if len(alpha) == 1 and beta[0][0] != 0:
        line = -alpha[0][0] / (2 * beta[0][0])
        return (
            lambda q: q(fmpq_poly([2 * line, -1])),
            lambda s: 2 * line - s.conjugate(),
        )
    flat = [x for row in beta for x in row]
    disk = len(alpha) == 2 and flat == [0, 1, 0, 0]
    if disk and alpha[0][0] == alpha[1][1] < 0:
        rho, c = -alpha[0][0], -alpha[0][1]

        def mirror(q):
            moved = q(fmpq_poly([c, 1]))  # the centre is at zero
            n = moved.degree()
            turned = fmpq_poly(
                [moved[n - k] * rho ** (2 * (n - k)) for k in range(n + 1)]
            )
            return turned(fmpq_poly([-c, 1]))

        return mirror, lambda s: c + rho**2 / (s - c).conjugate()
    return None, None
