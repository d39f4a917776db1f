"""Roots of loops with a delay: closed forms, Lambert's W, winding numbers."""

import control
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import lambertw

from sosbook.book import thesis
from sosbook.delay import (
    characteristic_roots,
    delay_margin,
    delayed_loop,
    slowest_decay,
    spectral_abscissa,
    stable_delays,
)
from sosbook.plants.descriptor import descriptors
from tests.cases import examples, later

EXAMPLE_1, EXAMPLE_2 = thesis.delay_example_1(), thesis.delay_example_2()
PRINTED, PUBLISHED = (thesis.delay_example_1(p).plant for p in (False, True))
RAM, K_WING, K_RAM = EXAMPLE_2.plant, EXAMPLE_1.K, EXAMPLE_2.K


def loop(plant, K):
    """A and A_d with an integrator on the first displacement."""
    (d,) = descriptors(plant, U=np.eye(plant.n)[:1])
    return delayed_loop(d, K)


LOOPS = {
    "printed wing": loop(PRINTED, K_WING),
    "published wing": loop(PUBLISHED, K_WING),
    "Ram": loop(RAM, K_RAM),
}


def characteristic(A, A_d, delay, s):
    """s I - A - A_d exp(-s delay), for each s."""
    s = np.asarray(s)[..., None, None]
    return s * np.eye(len(A)) - A - A_d * np.exp(-s * delay)


def residuals(A, A_d, delay, roots):
    """Smallest singular value over the sum of the terms' sizes."""
    T = characteristic(A, A_d, delay, roots)
    size = (
        abs(roots)
        + np.linalg.norm(A)
        + np.linalg.norm(A_d) * abs(np.exp(-roots * delay))
    )
    return np.linalg.svd(T, compute_uv=False)[:, -1] / size


def winding(A, A_d, delay, c):
    """Roots right of c, by the argument principle on a half disk."""
    radius = (
        1
        + 2 * abs(c)
        + np.linalg.norm(A, 2)
        + np.linalg.norm(A_d, 2) * np.exp(-c * delay)
    )
    arc = c + radius * np.exp(1j * np.linspace(-np.pi / 2, np.pi / 2, 800))
    line = c + 1j * radius * np.sinh(np.linspace(5, -5, 20001)) / np.sinh(5)
    sign, _ = np.linalg.slogdet(
        characteristic(A, A_d, delay, np.concatenate([arc, line]))
    )
    turns = np.angle(sign / np.roll(sign, 1))
    assert abs(turns).max() < 1.5, "the contour is too coarse"
    return round(turns.sum() / (2 * np.pi))


def w_roots(a, b, h, branches=40):
    """All roots of s = a + b exp(-s h), by falling real part."""
    k = np.arange(-branches, branches + 1)
    s = a + lambertw(b * h * np.exp(-a * h), k) / h
    return s[np.argsort(-s.real)]


def apart(found, wanted):
    """The largest distance of a found root from the wanted ones."""
    return abs(np.subtract.outer(found, wanted)).min(axis=1).max()


def random_loop(seed):
    """A loop of any rank and scaling, and a delay."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 6))
    r = int(rng.integers(1, n + 1))
    A, L, R = (rng.standard_normal(shape) for shape in ((n, n), (n, r), (r, n)))
    scale = 10 ** rng.uniform(-1, 1, n)
    change = scale[:, None] / scale
    A_d = L @ R * 10 ** rng.uniform(-1.5, 0.5)
    A = A - rng.uniform(0, 2) * np.eye(n)
    return A * change, A_d * change, 10 ** rng.uniform(-2, 0.5)


seeds = st.integers(0, 10**6)


def rates(largest):
    """Zero, or a size that A may have: below 1e-100 it is refused."""
    return st.floats(-largest, largest).filter(lambda a: not 0 < abs(a) < 1e-90)


# ---- roots


@given(rates(5), st.floats(-3, 1.3), st.booleans(), st.floats(-3, 0.7))
@settings(max_examples=examples(25, 60))
def test_scalar_loops_against_lambert_w(a, size, negative, long):
    b, h = (-1) ** negative * 10**size, 10**long
    wanted = w_roots(a, b, h)
    found = characteristic_roots([[a]], [[b]], h, count=20)
    assert len(found) in (20, 21)
    assert residuals([[a]], [[b]], h, found).max() < 1e-12
    # a double root, at the branch point, is good to half the digits
    near = 1e-6 * (1 + abs(wanted[: len(found)]).max())
    assert abs(found.real - wanted.real[: len(found)]).max() < near
    assert apart(found, wanted) < near
    best = spectral_abscissa([[a]], [[b]], h)
    assert best == pytest.approx(wanted[0].real, abs=near)


@pytest.mark.parametrize(
    "a, b, h",
    [
        (0, -300, 1),
        (0, -1, 30),
        (2, 1, 50),
        (0, -1e5, 1e-3),
        (-0.1, -0.0999, 1000),
        (-3, 1e-8, 3),
        (-1, -2, 1e-9),
        (-1e4, 1, 0.01),
    ],
)
def test_extreme_delays_and_gains(a, b, h):
    wanted = w_roots(a, b, h, branches=80)
    found = characteristic_roots([[a]], [[b]], h)
    gap = abs(found.real - wanted.real[: len(found)]).max()
    assert gap < 1e-12 * abs(found).max()
    assert apart(found, wanted) < 1e-12 * abs(found).max()


@pytest.mark.parametrize("h", [1e-7, 1e-9, 1e-12, 2e-16, 1e-90])
def test_a_delay_far_below_the_loops_own_times(h):
    """The root -1 was missed from 1e-12 on; 1e-14 was "too long"."""
    (root,) = characteristic_roots([[0]], [[-1]], h, count=1)
    assert root == pytest.approx(w_roots(0, -1, h)[0] if h > 1e-9 else -1, rel=1e-8)
    A, A_d = [[-1, 2], [0, -3]], [[-0.5, 0], [1, -0.2]]
    wanted = np.linalg.eigvals(np.add(A, A_d)).real.max()
    assert spectral_abscissa(A, A_d, h) == pytest.approx(wanted, rel=1e-6)


@pytest.mark.slow
@given(seeds)
@settings(max_examples=examples(10, 60))
def test_random_roots(seed):
    """Residuals, conjugates, and none is missing: a winding number."""
    A, A_d, h = random_loop(seed)
    roots = characteristic_roots(A, A_d, h)
    assert len(roots) in (10, 11)
    assert residuals(A, A_d, h, roots).max() < 1e-12
    assert (np.diff(roots.real) <= 0).all()
    upper, lower = roots[roots.imag > 0], roots[roots.imag < 0]
    assert np.array_equal(upper.conj(), lower)
    assert spectral_abscissa(A, A_d, h) == pytest.approx(
        roots[0].real, abs=1e-9 * abs(roots).max()
    )
    gaps = -np.diff(roots.real[:7])
    k = int(gaps.argmax())
    c = roots.real[k : k + 2].mean()
    assert winding(A, A_d, h, c) == k + 1


@pytest.mark.parametrize("copies", [2, 3])
def test_multiple_roots_are_counted(copies):
    one = np.eye(copies)
    A, A_d = np.array([[0, 1], [-2, -0.1]]), np.array([[0, 0], [0.5, 0.1]])
    single = characteristic_roots(A, A_d, 0.7, count=6)
    found = characteristic_roots(
        np.kron(one, A), np.kron(one, A_d), 0.7, count=6 * copies
    )
    assert len(found) == 6 * copies
    for root in single:
        assert (abs(found - root) < 1e-9).sum() == copies


def test_a_double_root_that_splits():
    """s + exp(-s - 1) has the double root -1."""
    found = characteristic_roots([[0]], [[-np.exp(-1)]], 1, count=2)
    assert len(found) == 2
    assert abs(found + 1).max() < 1e-6


def test_a_defective_root_is_not_missed():
    """A Jordan block: the scalar's roots, each sixfold."""
    A, A_d = np.eye(6, k=1) - np.eye(6), 0.1 * np.eye(6)
    wanted = w_roots(-1, 0.1, 1)[0].real
    found = characteristic_roots(A, A_d, 1, count=6)
    assert abs(found - wanted).max() < 0.02
    assert spectral_abscissa(A, A_d, 1) == pytest.approx(wanted, abs=0.02)


def test_finitely_many_roots():
    """A cascade: the delay isn't in a loop."""
    A, A_d = [[-1, 5], [0, -2]], [[0, 3], [0, 0]]
    assert np.allclose(characteristic_roots(A, A_d, 1), [-1, -2])
    assert np.allclose(characteristic_roots(A, np.zeros((2, 2)), 1), [-1, -2])


@pytest.mark.parametrize("name", LOOPS)
def test_without_delay(name):
    A, A_d = LOOPS[name]
    poles = np.linalg.eigvals(A + A_d)
    now = characteristic_roots(A, A_d, 0)
    assert len(now) == len(A) and apart(now, poles) < 1e-9
    soon = characteristic_roots(A, A_d, 1e-7, count=len(A))
    assert apart(poles, soon) < 1e-4
    assert spectral_abscissa(A, A_d, 0) == pytest.approx(poles.real.max())


@pytest.mark.parametrize("rate, base", [(1000, 10.0), (0.3, 2.2046), (9.81, 1 / 9.81)])
def test_units_of_time_and_states(rate, base):
    A, A_d = LOOPS["published wing"]
    roots = characteristic_roots(A, A_d, 0.2)
    faster = characteristic_roots(rate * A, rate * A_d, 0.2 / rate)
    assert abs(faster / rate - roots).max() < 1e-10
    scale = base ** np.arange(-6, 8, 2)
    change = scale[:, None] / scale
    other = characteristic_roots(A * change, A_d * change, 0.2)
    assert abs(other - roots).max() < 1e-9


def test_the_loop_is_the_plants():
    """det(s^2 M + s D + S - B (K_P + s K_D + K_I U / s) exp(-s h))."""
    K = np.array(K_WING)
    for s in characteristic_roots(*LOOPS["printed wing"], 0.2, count=6):
        gain = K[:, :3] + s * K[:, 3:6]
        gain[:, :1] += K[:, 6:] / s
        p = PRINTED
        T = s**2 * p.M + s * p.D + p.S - p.B @ gain * np.exp(-0.2 * s)
        sigma = np.linalg.svd(T, compute_uv=False)
        assert sigma[-1] < 1e-12 * sigma[0]


# ---- stable delays


@given(rates(3), rates(3))
@settings(max_examples=40)
def test_margin_of_first_order(a, b):
    """x' = a x + b x(t - h): crosses at w^2 = b^2 - a^2."""
    if abs(a + b) < 1e-3 or abs(a - b) < 1e-3 or abs(b) < 1e-3:
        return
    margin = delay_margin([[a]], [[b]])
    if a + b > 0:
        assert margin == 0
    elif abs(b) < -a:
        assert margin == np.inf
    else:
        wanted = np.arccos(-a / b) / np.sqrt(b**2 - a**2)
        assert margin == pytest.approx(wanted, rel=1e-9)


def test_a_window_that_does_not_begin_at_zero():
    """Gu, Kharitonov and Chen, Stability of Time-Delay Systems."""
    A, A_d = [[0, 1], [-2, 0.1]], [[0, 0], [1, 0]]
    x = (3.99 + np.array([-1, 1]) * np.sqrt(3.99**2 - 12)) / 2
    w = np.sqrt(x)  # s^2 - 0.1 s + 2 = exp(-s h) at s = j w
    ends = np.angle(2 - x + 0.1j * w) % (2 * np.pi) / w
    ((low, high),) = stable_delays(A, A_d, longest=60)
    assert [low, high] == pytest.approx(list(ends), rel=1e-10)
    assert abs(np.array([low, high]) - [0.1002, 1.7178]).max() < 1e-4
    assert delay_margin(A, A_d) == 0


@pytest.mark.parametrize("excess, windows", [(-1e-9, 1), (1e-9, 3)])
def test_a_root_that_nearly_touches_the_axis(excess, windows):
    """z'' + 2 zeta z' + z = k z(t - h), k near the inverse peak gain."""
    zeta = 0.1
    k = 2 * zeta * np.sqrt(1 - zeta**2) * (1 + excess)
    w = np.sqrt(1 - 2 * zeta**2)  # of the peak
    touch = -np.angle(1 - w**2 + 2j * zeta * w) % (2 * np.pi) / w
    A, A_d = [[0, 1], [-1, -2 * zeta]], [[0, 0], [k, 0]]
    found = stable_delays(A, A_d, 12)
    assert len(found) == windows
    margin = delay_margin(A, A_d)
    assert margin == (np.inf if excess < 0 else found[0][1])
    if excess > 0:
        shut, opened = found[0][1], found[1][0]
        assert shut < touch < opened < shut + 1e-3


@given(seeds)
@settings(max_examples=examples(8, 20))
def test_random_windows(seed):
    """Between the ends stability is as the roots say; at them none is."""
    A, A_d, _ = random_loop(seed)
    windows = stable_delays(A, A_d, 3)
    for h in np.random.default_rng(seed).uniform(0, 3, 12):
        inside = any(low < h < high for low, high in windows)
        worst = spectral_abscissa(A, A_d, h)
        assert inside == (worst < 0) or abs(worst) < 1e-9
    for h in {end for pair in windows for end in pair} - {0, 3}:
        assert abs(spectral_abscissa(A, A_d, h)) < 1e-8
    margin = delay_margin(A, A_d)
    first = next((high for low, high in windows if low == 0), 0)
    assert min(margin, 3) == pytest.approx(first)


@pytest.mark.parametrize("name", LOOPS)
def test_margins_against_python_control(name):
    """Phase margins over the frequencies of unit gain."""
    plant, K = {
        "printed wing": (PRINTED, K_WING),
        "Ram": (RAM, K_RAM),
        "published wing": (PUBLISHED, K_WING),
    }[name]
    (d,) = descriptors(plant, U=np.eye(plant.n)[:1])
    A, B, _ = d.state_space()
    opened = control.ss(A, B, -np.array(K), 0)
    _, phases, _, _, w, _ = control.stability_margins(opened, returnall=True)
    wanted = (np.radians(phases) % (2 * np.pi) / w).min()
    margin = delay_margin(*LOOPS[name])
    assert margin == pytest.approx(wanted, rel=1e-5)


def test_loops_that_no_delay_or_every_delay_leaves_stable():
    zero = np.zeros((2, 2))
    assert stable_delays(np.diag([-1, -2]), zero, 5) == [(0, 5)]
    assert stable_delays(np.diag([-1, 2]), zero, 5) == []
    assert stable_delays([[-1]], [[1]], 5) == []  # A + A_d singular
    assert stable_delays(np.diag([0, -1]), np.diag([0, -0.5]), 5) == []
    fixed = np.array([[0, 1, 0], [-1, 0, 0], [0, 0, -1]])
    assert stable_delays(fixed, np.diag([0, 0, -2]), 5) == []
    assert stable_delays([[-3]], [[1]], 5) == [(0, 5)]
    assert stable_delays([[0]], [[-1]], 0) == [(0, 0)]
    assert stable_delays([[0]], [[1]], 0) == []


# ---- slowest decay


@pytest.mark.slow
@pytest.mark.parametrize(
    "A, A_d, low, high",
    [
        ([[0, 1], [-4, -0.3]], [[0, 0], [-0.5, 0.1]], 0, 9),
        *later(
            (*LOOPS["printed wing"], 0.1, 0.3),
            (*LOOPS["Ram"], 0.2, 0.6),
            (*LOOPS["published wing"], 0.1, 0.3),
            ([[0, 1], [-25, -1]], [[0, 0], [-2, 0]], 1, 4),
        ),
    ],
)
def test_slowest_decay_against_a_fine_grid(A, A_d, low, high):
    rate, where = slowest_decay(A, A_d, low, high)
    assert low <= where <= high
    assert rate == pytest.approx(-spectral_abscissa(A, A_d, where))
    grid = np.linspace(low, high, 151)
    rates = [-spectral_abscissa(A, A_d, h) for h in grid]
    assert rate <= min(rates) + 1e-9
    assert rate >= min(rates) - 1e-2


def test_slowest_decay_of_an_oscillator_peaks_inside():
    """The rightmost root is on the axis where a delay touches it."""
    k, w2 = 0.5, 4.0
    A, A_d = [[0, 1], [-w2, -0.2]], [[0, 0], [-k, 0]]
    rate, where = slowest_decay(A, A_d, 0, 3)
    inside = (spectral_abscissa(A, A_d, where + d) for d in (-1e-4, 1e-4))
    assert 0 < where < 3
    assert all(a <= -rate for a in inside)


def test_slowest_decay_at_one_delay():
    assert slowest_decay([[-1]], [[0.5]], 0, 0) == pytest.approx((0.5, 0), rel=1e-12)
    rate, where = slowest_decay([[0]], [[-1]], 0.25, 0.25)
    assert where == 0.25
    assert rate == pytest.approx(-w_roots(0, -1, 0.25)[0].real)


# ---- bad input


@pytest.mark.parametrize(
    "call, message",
    [
        (lambda: spectral_abscissa([[1, 2]], [[1]], 1), "A has 2 columns"),
        (lambda: spectral_abscissa([[1]], np.eye(2), 1), "A_d has 2 rows"),
        (lambda: spectral_abscissa([[np.nan]], [[1]], 1), "A has NaN"),
        (lambda: spectral_abscissa(np.zeros((0, 0)), [[1]], 1), "A is empty"),
        (lambda: spectral_abscissa([[1]], [[1]], -1), "delay must be 0 or more"),
        (lambda: spectral_abscissa([[1]], [[1]], np.inf), "delay must be a fin"),
        (
            lambda: spectral_abscissa([[0, 1e5], [-1e5, 0]], np.eye(2), 1),
            "delay is too long",
        ),
        (lambda: characteristic_roots([[1]], [[1]], 1, 0), "count must be a"),
        (lambda: characteristic_roots([[1]], [[1]], 1, 1.5), "count must be a"),
        (lambda: stable_delays([[1]], [[1]], -1), "longest must be 0 or more"),
        (lambda: slowest_decay([[1]], [[1]], 2, 1), "low must not exceed high"),
        (lambda: slowest_decay([[1]], [[1]], -1, 1), "low must be 0 or more"),
        (lambda: loop(RAM, [[1, 2]]), "K has 2 columns, needs 5"),
    ],
)
def test_bad_input(call, message):
    with pytest.raises(ValueError, match=message):
        call()
