"""The delay theorems, derived again, and what their misprints accept."""

from decimal import Decimal, localcontext

import numpy as np
import pytest
from flint import fmpq, fmpq_mpoly_ctx
from numpy.polynomial import Legendre, Polynomial

import sosbook as sos
from sosbook.book import counterexamples
from sosbook.delay import (
    DelayedLoop,
    analyse_delay,
    characteristic_roots,
    solve_delay,
    spectral_abscissa,
)
from sosbook.delay.request import exp_bound
from sosbook.exact.definite import definite, exact, inverse
from sosbook.lmi import block, he
from sosbook.plants.descriptor import Descriptor
from sosbook.theorems import (
    MISPRINTS,
    Functional,
    Times,
    delay_decay,
    delay_functional,
    delay_stabilization,
    legendre_decay,
    legendre_functional,
)

SYMMETRIC = ("P", "S", "R1", "R3", "Z")
NAMES = ("P", "Q", "S", "R1", "R2", "R3", "Z")


def _grid(entries, rows):
    found = np.empty(len(entries), object)
    for i, entry in enumerate(entries):
        found[i] = entry
    return found.reshape(rows, -1)


def symbols():
    """Generic 2 x 2 matrices of indeterminates, by name."""
    names = [*NAMES, "E", "A", "Ad", "F", "G"]
    labels = [f"{name}{i}" for name in names for i in range(4)]
    free = fmpq_mpoly_ctx.get(labels, "degrevlex").gens()
    free = dict(zip(labels, free))
    places = {
        name: (0, 1, 1, 2) if name in SYMMETRIC else (0, 1, 2, 3) for name in names
    }
    return {
        name: _grid([free[f"{name}{i}"] for i in places[name]], 2) for name in names
    }


# both theorems are of low degree in these, so three samples tell all
RATIONAL_TIMES = {
    "mu > 0": Times(
        *(fmpq(p, q) for p, q in [(2, 5), (1, 5), (1, 10), (9, 4), (7, 8)])
    ),
    "large mu": Times(
        *(fmpq(p, q) for p, q in [(3, 1), (3, 1), (5, 7), (1, 9), (2, 11)])
    ),
    "mu = 0": Times(*(fmpq(p, q) for p, q in [(1, 1), (0, 1), (1, 3), (1, 2), (1, 4)])),
}
at_all_times = pytest.mark.parametrize("t", RATIONAL_TIMES.values(), ids=RATIONAL_TIMES)


def derived(E, A, Ad, v, F, G, t):
    """The bound of (d/dt + 2 delta) V, a form in x, x', x_tau, eta, v.

    The five are picked out of one long vector; v is the integral of x'
    from t - d to t - tau.
    """
    parts = 5 if t.mu else 4
    N = len(E)
    x, rate, late, eta, *drift = np.eye(parts * N, dtype=int).reshape(
        parts, N, parts * N
    )
    w, whole = np.vstack([x, rate]), np.vstack([eta, x - late])
    R = block([[v.R1, v.R2.T], [v.R2, v.R3]])
    e1, e2, mu = t.epsilon1, t.epsilon2, t.mu
    grown = 2 * t.delta * (x.T @ v.P @ x + he(x.T @ v.Q @ eta))
    moved = he(x.T @ v.P @ rate) + he(rate.T @ v.Q @ eta) + he(x.T @ v.Q @ (x - late))
    stored = x.T @ v.S @ x - t.tau * e1 * (late.T @ v.S @ late)
    jensen = t.tau * (w.T @ R @ w) - e1 * (whole.T @ R @ whole)
    loop = A @ x + Ad @ late - E @ rate
    young = 2 * mu * (rate.T @ v.Z @ rate)
    if mu:
        (drift,) = drift
        loop = loop - Ad @ drift
        young = young - e2 / mu * (drift.T @ v.Z @ drift)
    null = e2 * he((x.T @ F + rate.T @ G) @ loop)
    return grown + moved + stored + jensen + young + null


@at_all_times
def test_every_block_of_the_corrected_theorem(t):
    """As polynomials in all matrix entries, block by block."""
    m = symbols()
    v = Functional(*(m[name] for name in NAMES))
    E, A, Ad, F, G = (m[name] for name in ("E", "A", "Ad", "F", "G"))
    wanted = derived(E, A, Ad, v, F, G, t)
    found = -delay_decay(E, A, Ad, v, F, G, t)
    unit = np.full(len(found), fmpq(1))
    if t.mu:
        unit[8:] = -1 / t.epsilon2  # the theorem's fifth unknown is -e2 v
    assert wanted.shape == found.shape
    for i in range(len(found) // 2):
        for j in range(i + 1):
            rows, columns = slice(2 * i, 2 * i + 2), slice(2 * j, 2 * j + 2)
            scaled = wanted[rows, columns] * np.outer(unit[rows], unit[columns])
            gap = scaled - found[rows, columns]
            assert (gap == 0).all(), f"block {i + 1}{j + 1}"
            mirror = found[columns, rows].T - found[rows, columns]
            assert (mirror == 0).all(), f"block {j + 1}{i + 1}"


@pytest.mark.parametrize("misprint", MISPRINTS)
def test_each_misprint_changes_its_block_only(misprint):
    m, t = symbols(), RATIONAL_TIMES["mu > 0"]
    v = Functional(*(m[name] for name in NAMES))
    loop = [m[name] for name in ("E", "A", "Ad")]
    right, wrong = (
        delay_decay(*loop, v, m["F"], m["G"], t, read, fmpq(2))
        for read in ((), (misprint,))
    )
    differ = {(i // 2, j // 2) for i, j in zip(*np.nonzero(right - wrong != 0))}
    assert (
        differ
        == {"sign": {(4, 4)}, "transpose": {(0, 0)}, "alpha": {(4, 1), (1, 4)}}[
            misprint
        ]
    )


def random_functional(rng, N, number=lambda x: x):
    """S, R and Z positive definite, P and Q anything."""

    def positive(size):
        root = rng.integers(-4, 5, (size, size)) / 4
        return root @ root.T + np.eye(size) / 4

    R = positive(2 * N)
    P, Q = rng.integers(-8, 9, (2, N, N)) / 4
    parts = (P + P.T, Q, positive(N), R[:N, :N], R[N:, :N], R[N:, N:], positive(N))
    return Functional(*map(number, parts))


GAUSS = np.polynomial.legendre.leggauss(24)


def integral(f, low, high):
    """Of smooth f; the ends may be complex."""
    nodes, weights = GAUSS
    half = (high - low) / 2
    return half * sum(w * f(low + half * (1 + s)) for s, w in zip(nodes, weights))


def slope(f, t=0.0):
    """f'(t) of an analytic f, to machine precision: complex step."""
    return f(t + 1e-30j).imag / 1e-30


class Motion:
    """x(s): a polynomial with N components, not a solution of anything."""

    def __init__(self, rng, N, degree):
        self.x = [Polynomial(c) for c in rng.standard_normal((N, degree + 1))]

    def __call__(self, s):
        return np.array([p(s) for p in self.x])

    def dx(self, s):
        return np.array([p.deriv()(s) for p in self.x])

    def w(self, s):
        return np.concatenate([self(s), self.dx(s)])


def functional(motion, v, tau, mu, delta):
    """V of Theorem A.3 as a function of t, by its definition.

    The double integrals are single ones: the inner point s lies in
    those windows only that reach back to it.
    """
    R = np.block([[v.R1, v.R2.T], [v.R2, v.R3]])

    def V(t):
        def part(form, signal, weight, low, high):
            return integral(
                lambda s: (
                    np.exp(2 * delta * s)
                    * weight(s)
                    * (signal(t + s) @ form @ signal(t + s))
                ),
                low,
                high,
            )

        x, eta = motion(t), integral(lambda s: motion(t + s), -tau, 0)
        return (
            x @ v.P @ x
            + 2 * x @ v.Q @ eta
            + part(v.S, motion, lambda s: 1, -tau, 0)
            + part(R, motion.w, lambda s: s + tau, -tau, 0)
            + part(v.Z, motion.dx, lambda s: s + tau + mu, -tau - mu, mu - tau)
            + part(v.Z, motion.dx, lambda s: 2 * mu, mu - tau, 0)
        )

    return V


def late_drift(motion, tau, d):
    return motion(-tau) - motion(-d)


def random_plant_in_rationals(rng, N=3, m=2):
    """A descriptor with a regular E, in rationals."""

    def draw(*shape):
        return exact(rng.integers(-9, 10, shape) / 4)

    E = draw(N, N) + 5 * np.eye(N, dtype=int)
    return Descriptor(E, draw(N, N), draw(N, m), draw(N, 1), draw(1, N)), draw


def congruence(parts, matrix):
    """diag(parts) matrix diag(parts)'."""
    size = len(parts)
    left = block(
        [[parts[i] if i == j else 0 for j in range(size)] for i in range(size)]
    )
    return left @ matrix @ left.T


@at_all_times
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_design_theorem_is_a_congruence(seed, t):
    """Theorem 2.3 is A.3 with G = alpha F between F^-1, exactly."""
    rng = np.random.default_rng(seed)
    d, draw = random_plant_in_rationals(rng)
    N, alpha = 3, fmpq(4, 5)
    v = random_functional(rng, N, exact)
    F, K = draw(N, N) + 4 * np.eye(N, dtype=int), draw(2, N)
    bar = inverse(F)
    barred = Functional(*(bar @ getattr(v, n) @ bar.T for n in NAMES))
    wanted = delay_decay(d.E, d.A, d.Bu @ K, v, F, alpha * F, t)
    found = delay_stabilization(d, barred, bar, K @ bar.T, t, alpha)
    parts = [bar] * (5 if t.mu else 4)
    assert (found == congruence(parts, wanted)).all()
    for mine, theirs in zip(delay_functional(barred, t), delay_functional(v, t)):
        assert (mine == congruence([bar, bar], theirs)).all()


@pytest.mark.parametrize("seed", [4, 5])
def test_the_printed_layout_with_e_everywhere_is_congruent(seed):
    """(2.24), (2.25) with the sign mended but E where print has it.

    Print multiplies the loop by E^-1, so its F is ours without the E:
    F = E Fbar, X = K F', and P = E Pbar E' and so on.
    """
    rng = np.random.default_rng(seed)
    d, draw = random_plant_in_rationals(rng)
    N, alpha, t = 3, fmpq(4, 5), RATIONAL_TIMES["mu > 0"]
    E, A, B = d.E, d.A, d.Bu
    tau, mu, delta, e1, e2 = (t.tau, t.mu, t.delta, t.epsilon1, t.epsilon2)
    p = random_functional(rng, N, exact)
    F, K = draw(N, N), draw(2, N)
    X = K @ F.T
    f11 = E @ (2 * delta * p.P + he(p.Q) + tau * p.R1 - e1 * p.R3 + p.S) @ E.T + e2 * (
        A @ F.T @ E.T + E @ F @ A.T
    )
    f21 = E @ (p.P + tau * p.R2) @ E.T - e2 * (E @ F @ E.T - alpha * A @ F.T @ E.T)
    G = alpha * F
    f22 = E @ (tau * p.R3 + 2 * mu * p.Z - e2 * he(G)) @ E.T
    f31 = e1 * p.R3.T @ E.T - p.Q.T @ E.T + e2 * X.T @ B.T
    f32 = e2 * alpha * X.T @ B.T
    f33 = -e1 * (p.R3 + tau * p.S)
    f41 = 2 * delta * p.Q.T @ E.T - e1 * p.R2.T @ E.T
    f42, f43, f44 = p.Q.T @ E.T, e1 * p.R2.T, -e1 * p.R1
    f51, f52 = mu * X.T @ B.T, mu * alpha * X.T @ B.T
    f55 = -mu / e2 * p.Z
    printed = block(
        [
            [f11, f21.T, f31.T, f41.T, f51.T],
            [f21, f22, f32.T, f42.T, f52.T],
            [f31, f32, f33, f43.T, 0],
            [f41, f42, f43, f44, 0],
            [f51, f52, 0, 0, f55],
        ]
    )
    ours = Functional(*(E @ getattr(p, n) @ E.T for n in NAMES))
    found = delay_stabilization(d, ours, E @ F, K @ (E @ F).T, t, alpha)
    one, back = exact(np.eye(N)), inverse(E)
    parts = [one, one, back, back, mu * back]
    assert (-printed == congruence(parts, found)).all()


# Legendre polynomials


def legendre(k, tau):
    """L_k on [-tau, 0], one at 0."""
    return Legendre.basis(k, domain=[-tau, 0])


def bessel_functional(motion, P, S, R, Z, order, tau, mu):
    """V of `legendre_decay` as a function of t, by its definition."""

    def V(t):
        def part(form, signal, weight, low, high):
            return integral(
                lambda s: weight(s) * (signal(t + s) @ form @ signal(t + s)), low, high
            )

        xi = np.concatenate([motion(t), *moments(motion, order, tau, t)])
        return (
            xi @ P @ xi
            + part(S, motion, lambda s: 1, -tau, 0)
            + tau * part(R, motion.dx, lambda s: s + tau, -tau, 0)
            + part(Z, motion.dx, lambda s: s + tau + mu, -tau - mu, mu - tau)
            + part(Z, motion.dx, lambda s: 2 * mu, mu - tau, 0)
        )

    return V


def moments(motion, order, tau, t=0.0):
    """X_k, the integrals of L_k x."""
    return [
        integral(lambda s, k=k: legendre(k, tau)(s) * motion(t + s), -tau, 0)
        for k in range(order)
    ]


def bessel_case(seed, order, degree, tau, mu, d):
    """A motion, a loop it solves at t = 0, V and minus the form there."""
    rng = np.random.default_rng(seed)
    N, motion = 2, Motion(rng, 2, degree)
    P = rng.standard_normal((2 * (1 + order), 2 * (1 + order)))
    P = P + P.T
    v = random_functional(rng, N)
    S, R, Z = v.S, v.R3, v.Z
    A, Ad = rng.standard_normal((2, N, N))
    x = motion(0.0)
    A = A + np.outer(motion.dx(0.0) - A @ x - Ad @ motion(-d), x) / (x @ x)
    t = Times(tau, mu, 0.0, 1 / tau, 1.0)
    parts = [x, motion(-tau), *moments(motion, order, tau)]
    if mu:
        parts.append(late_drift(motion, tau, d) / mu)
    long = np.concatenate(parts)
    form = long @ legendre_decay(A, Ad, P, S, R, Z, order, t) @ long
    V = bessel_functional(motion, P, S, R, Z, order, tau, mu)
    return V, -form, (P, S, t, np.concatenate([x, *parts[2 : 2 + order]]))


@pytest.mark.parametrize("order", [0, 1, 2, 3])
def test_bessel_is_sharp_on_polynomials(order):
    """x' of degree ``order`` is the sum of its Legendre parts."""
    for degree in range(order + 2):
        V, form, _ = bessel_case(degree, order, degree, 0.8, 0.0, 0.8)
        assert slope(V) == pytest.approx(form, rel=1e-11)
    V, form, _ = bessel_case(9, order, order + 2, 0.8, 0.0, 0.8)
    assert slope(V) < form - 1e-6 * abs(form)


@pytest.mark.parametrize("order", [0, 1, 2])
@pytest.mark.parametrize("share", [-1, 0.3, 1])
def test_the_legendre_form_bounds_the_derivative(order, share):
    for seed in range(4):
        tau, mu = 1.3, 0.6
        V, form, _ = bessel_case(seed, order, 4, tau, mu, tau + share * mu)
        assert slope(V) < form


@pytest.mark.parametrize("order", [0, 1, 2, 3])
def test_the_legendre_functional_is_below_v(order):
    """V is at least the form in x and the X_k, by Bessel for S."""
    for seed in range(4):
        V, _, (P, S, t, xi) = bessel_case(seed, order, 4, 1.3, 0.6, 1.3)
        assert V(0.0) > xi @ legendre_functional(P, S, order, t) @ xi


@pytest.mark.parametrize("order", [1, 2, 3])
def test_the_legendre_functional_is_sharp_on_polynomials(order):
    """Of degree below ``order``, with R = Z = 0."""
    rng = np.random.default_rng(order)
    motion, S = Motion(rng, 2, order - 1), random_functional(rng, 2).S
    P, zero = np.eye(2 * (1 + order)), np.zeros((2, 2))
    V = bessel_functional(motion, P, S, zero, zero, order, 1.3, 0.6)
    xi = np.concatenate([motion(0.0), *moments(motion, order, 1.3)])
    t = Times(1.3, 0.6, 0.0, 1 / 1.3, 1.0)
    form = xi @ legendre_functional(P, S, order, t) @ xi
    assert V(0.0) == pytest.approx(form, rel=1e-12)


# Exponentials


@pytest.mark.parametrize("digits", [3, 12])
def test_exponentials_are_rounded_to_the_right_side(digits):
    """Against the decimal module, at 40 digits."""
    rng = np.random.default_rng(2)
    with localcontext(prec=40):
        for p in rng.integers(-30_000, 30_000, 40):
            x = fmpq(int(p), 997)
            true = (Decimal(int(p)) / 997).exp()
            unit = Decimal(10) ** (true.adjusted() - digits + 1)
            for up in (False, True):
                q = exp_bound(x, up, digits)
                bound = Decimal(int(q.p)) / Decimal(int(q.q))
                assert (bound > true) == up
                assert abs(bound - true) <= unit
                assert bound == bound.quantize(unit)
    assert exp_bound(fmpq(0)) == exp_bound(fmpq(0), up=True) == 1


def test_a_request_rounds_its_exponentials_safely():
    loop = DelayedLoop([[-1]], [[0.5]])
    request = sos.delay.DelayRequest(loop, None, 0.4, 0.3, 0.7)
    t = request.times(exact)
    assert (t.tau, t.mu, t.delta) == (1, fmpq(3, 4), fmpq(7, 25))
    shifted = request.at(method="shift").factors(exact)
    with localcontext(prec=40):

        def true(x):
            return Decimal(x).exp()

        def read(q):
            return Decimal(int(q.p)) / int(q.q)

        assert 0 < true("-0.56") - read(t.epsilon1) < Decimal("1e-11")
        assert 0 < true("-0.98") - read(t.epsilon2) < Decimal("1e-11")
        (_, low), (_, high) = shifted
        assert 0 < true("0.07") - read(low) < Decimal("1e-10")
        assert 0 < read(high) - true("0.49") < Decimal("1e-10")


# Misprints


def test_the_printed_theorem_accepts_an_unstable_loop_by_hand():
    """x' = x - 0.1 x(t - d), tau = 1, mu = 0.5, delta = 0.1."""

    def number(x):
        return exact(np.array([[float(x)]]))

    v = Functional(*map(number, (1, 0, 2, 1, 0, 1, -100)))
    request = counterexamples.misprint("sign")
    assert (request.tau, request.mu, request.delta) == (1, 0.5, 0.1)
    t = request.times(exact)
    loop = number(1), number(1), number(-0.1), v, number(-5), number(0), t
    for g in delay_functional(v, t):
        assert definite(g)[0]
    for alpha in (fmpq(1, 100), fmpq(1), fmpq(100)):
        assert definite(delay_decay(*loop, MISPRINTS, alpha))[0]
    assert definite(delay_decay(*loop, ("sign",)))[0]
    assert not definite(delay_decay(*loop))[0]
    root = characteristic_roots([[1]], [[-0.1]], 1.0)[0].real
    assert root == pytest.approx(0.962, abs=5e-4)
    assert root == pytest.approx(1 - 0.1 * np.exp(-root))


@pytest.mark.parametrize("name", MISPRINTS)
def test_one_misprint_alone_accepts_an_unstable_loop(name):
    """Exactly proven LMIs, a root on the right; corrected: refused."""
    request = counterexamples.misprint(name)
    assert request.misprints == (name,)
    wrong = solve_delay(request)
    assert wrong.status == "feasible"
    certificate = wrong.certify()
    assert certificate.proven
    assert certificate.claims == (
        "the LMIs as printed hold: that proves nothing about the loop",
    )
    loop = request.plant
    longest = request.tau + request.mu
    assert spectral_abscissa(loop.A, loop.A_d, longest) > 0.05
    assert wrong.slowest_decay()[0] < -0.05

    right = solve_delay(request.at(misprints=()))
    assert right.status == "infeasible"
    assert right.infeasibility.proven


def test_printed_reads_all_misprints_through_the_public_functions():
    wrong = counterexamples.misprint("sign")
    d = analyse_delay(wrong.plant, tau=1, mu=0.5, delta=0.1, printed=True)
    assert d.request.misprints == MISPRINTS
    assert d.status == "feasible"
    assert d.slowest_decay()[0] < -0.9
    assert "proves nothing" in str(d.certify())
    right = analyse_delay(wrong.plant, tau=1, mu=0.5, delta=0.1)
    assert right.status == "infeasible"
