"""The pendulum: mechanics from first principles, and the printed digits.

The equations of motion are derived here from energies, in exact
polynomials: s and c stand for sin and cos of theta, w and p for the
rates, alpha and beta for the accelerations.
"""

import flint
import numpy as np
import pytest
from scipy.optimize import nnls

from sosbook.book import thesis
from sosbook.pendulum import R_G, V_MAX, Mip, polytope, vertices

PRINT = thesis.mip()
MIP = Mip.printed()
ROTORS = Mip.from_ratios(30.52, 7.133, 110.6, 208.8, rotors=True)
UNPRINTED = dict(M_b=0.272, l=0.040, r=0.032, M_w=0.027, g=9.8)
NAMES = ("s", "c", "phi", "w", "p", "alpha", "beta", "M_b", "M_w", "l", "r",
         "I_b", "I_w", "I_a", "R", "g")  # fmt: skip
(S, C, PHI, W, P, ALPHA, BETA, M_b, M_w, L, RADIUS, I_b, I_w, I_a, R, G) = (
    flint.fmpq_mpoly_ctx.get(NAMES, "lex").gens()
)


def by_theta(f):
    return C * f.derivative("s") - S * f.derivative("c")


def rate(f):
    """d/dt along the motion."""
    return (
        by_theta(f) * W
        + f.derivative("phi") * P
        + f.derivative("w") * ALPHA
        + f.derivative("p") * BETA
    )


def kinetic(I_w, sign=-1, wheels=M_w, rotors=0):
    """(4.3), from the places of body and wheels; no wheel slips."""
    x, y = -RADIUS * PHI + sign * L * S, L * C
    return (
        M_b * (rate(x) ** 2 + rate(y) ** 2) / 2
        + wheels * rate(-RADIUS * PHI) ** 2
        + I_b * W**2 / 2
        + I_w * P**2
        + rotors
    )


def pendulum(*asked, **also):
    """Left sides of (4.1)."""
    lagrangian = kinetic(*asked, **also) - M_b * G * L * C
    return (
        rate(lagrangian.derivative("w")) - by_theta(lagrangian),
        rate(lagrangian.derivative("p")) - lagrangian.derivative("phi"),
    )


def thesis_rows(a, b, c, d, J=0):
    """Left sides of (4.12), and of `Mip` with the rotors."""
    return (
        c * ALPHA - d * S + (b * C - J) * BETA,
        (b * C - J) * ALPHA - b * S * W**2 + a * BETA,
    )


def same(rows, others):
    """Equal wherever s^2 + c^2 = 1."""
    return all(((f - g) % (S**2 + C**2 - 1)) == 0 for f, g in zip(rows, others))


LETTERS = dict(
    a=RADIUS**2 * (M_b + 2 * M_w) + 2 * I_w,
    b=M_b * L * RADIUS,
    c=I_b + M_b * L**2,
    d=M_b * L * G,
)


def test_equations_of_motion_from_the_energies():
    """(4.3)-(4.12), with x_b = -r phi - l sin and M_w V_w^2."""
    assert same(pendulum(I_w), thesis_rows(**LETTERS))


def test_kinetic_energy():
    """(4.7) with + M_w r^2 phi'^2, and phi'^2 beside the inertia."""
    inertia = M_w * RADIUS**2 / 2 + R**2 * I_a
    body = L**2 * W**2 + RADIUS**2 * P**2 + 2 * L * RADIUS * P * W * C
    mended = M_b * body / 2 + M_w * RADIUS**2 * P**2 + I_b * W**2 / 2 + inertia * P**2
    assert same([kinetic(inertia)], [mended])


def test_what_the_misprints_would_give():
    plus = pendulum(I_w, sign=1)
    assert not same(plus, thesis_rows(**LETTERS))
    assert same(plus, thesis_rows(**LETTERS | {"b": -M_b * L * RADIUS}))
    twice = pendulum(I_w, wheels=2 * M_w)
    assert not same(twice, thesis_rows(**LETTERS))
    assert same(
        twice, thesis_rows(**LETTERS | {"a": RADIUS**2 * (M_b + 4 * M_w) + 2 * I_w})
    )


@pytest.mark.parametrize("sense", [1, -1])
def test_rotors_turn_with_the_body(sense):
    """A rotor's rate is theta' + R (phi' - theta'), R < 0 if reversed.

    The thesis has R phi'. The coupling J doesn't move with cos(theta).
    """
    ratio = sense * R
    rotors = I_a * (W + ratio * (P - W)) ** 2
    disc = M_w * RADIUS**2 / 2
    true = pendulum(disc, rotors=rotors)
    assert not same(true, pendulum(disc + R**2 * I_a))
    assert same(
        true,
        thesis_rows(
            a=LETTERS["a"] - 2 * I_w + 2 * disc + 2 * R**2 * I_a,
            b=LETTERS["b"],
            c=LETTERS["c"] + 2 * (ratio - 1) ** 2 * I_a,
            d=LETTERS["d"],
            J=2 * ratio * (ratio - 1) * I_a,
        ),
    )


def test_rotors_of_the_model():
    mip, share = ROTORS, MIP.I_w - 0.027 * 0.032**2 / 2  # R_g^2 I_a
    assert np.isclose(mip.J, 2 * share, rtol=1e-12)
    assert round(mip.J / mip.b, 3) == 0.325
    assert mip.J / R_G < 0.01 * mip.b  # of J: R - 1 isn't R
    for name in "abcdef":  # c and a are measured as they are
        assert getattr(mip, name) == getattr(MIP, name)
    for v in vertices(mip):
        assert np.isclose(v.J, 2 * v.I_w - 0.027 * 0.032**2)
    # the fall is a little faster, the motors' pole a quarter slower
    assert np.allclose(MIP.plant().poles(), [-45.88, -5.86, 0, 8.10], atol=6e-3)
    assert np.allclose(mip.plant().poles(), [-34.72, -6.26, 0, 8.38], atol=6e-3)


def test_acceleration_solves_the_derived_equations():
    """Numbers put into the polynomials of the energies."""
    theta, w, p, V = 0.7, 1.1, -2.3, 3.0
    alpha, beta = MIP.acceleration([theta, 0.4], [w, p], V)
    numbers = UNPRINTED | dict(s=np.sin(theta), c=np.cos(theta), phi=0.4, w=w, p=p)
    I_body = MIP.c - UNPRINTED["M_b"] * UNPRINTED["l"] ** 2
    numbers |= dict(alpha=alpha, beta=beta, I_b=I_body, I_w=MIP.I_w, I_a=0, R=0)
    exact = [flint.fmpq(*float(numbers[x]).as_integer_ratio()) for x in NAMES]
    left = [row(*exact) for row in pendulum(I_w)]
    torque = MIP.e * V - MIP.f * (p - w)
    for row, force in zip(left, (-torque, torque)):
        assert abs(int(row.p) / int(row.q) - force) < 1e-12


@pytest.mark.parametrize("mip", [MIP, ROTORS])
def test_linearised_it_is_the_plant(mip):
    h = 1e-6
    both = (
        [mip.acceleration(x[:2], x[2:4], x[4]) for x in side * h * np.eye(5)]
        for side in (1, -1)
    )
    slope = np.subtract(*both).T / (2 * h)
    v = mip.plant()
    linear = np.linalg.solve(v.M, np.hstack([-v.S, -v.D, v.B]))
    assert np.allclose(slope, linear, rtol=1e-7, atol=1e-6)


@pytest.mark.parametrize("mip", [MIP, ROTORS])
def test_power_of_the_motors(mip):
    """dE/dt = (e V - f (phi' - theta')) (phi' - theta')."""
    rng = np.random.default_rng(1)
    z, dz, V, h = *rng.normal(size=(2, 2, 40)), 2.0, 1e-5
    ddz = mip.acceleration(z, dz, V)

    def energy(t):
        return mip.energy(z + t * dz, dz + t * ddz)

    slip = dz[1] - dz[0]
    power = (mip.e * V - mip.f * slip) * slip
    assert np.allclose((energy(h) - energy(-h)) / (2 * h), power, rtol=1e-6, atol=1e-9)


# ---- the two linear forms


@pytest.mark.parametrize("mip", [MIP, *vertices(MIP), ROTORS])
def test_both_forms_are_one_plant(mip):
    natural, thesis = mip.plant(F=None), mip.printed_form(F=None)
    for X in (natural.M, natural.D, natural.S):
        assert np.array_equal(X, X.T)
    # the product of M and its adjugate is the printed mass
    a, b, c = mip.a, mip.b - mip.J, mip.c
    assert np.isclose(a * c - b * b, np.linalg.det(natural.M), rtol=1e-12)
    for name in "MDSB":
        ours = [[a, -b], [-b, c]] @ getattr(natural, name)
        assert np.allclose(ours, getattr(thesis, name), rtol=1e-12, atol=1e-20)


# ---- printed digits


def digits(value, unit, places=4):
    return np.round(np.asarray(value) / unit, places) * unit


def test_letters_follow_from_the_unprinted_values():
    """To the last digit: M_b = 0.272, l = 0.040, r = 0.032, ..."""
    said = PRINT.letters
    assert (R_G, V_MAX) == (PRINT.constants["R_g"], PRINT.constants["V_max"])
    corners = vertices(MIP)
    mean, low, high = MIP.a, corners[1].a, corners[2].a
    assert np.allclose(digits([mean, low, high], 1e-3), said["a"], rtol=1e-12)
    for name, unit in [("b", 1e-3), ("c", 1e-3), ("d", 1), ("f", 1)]:
        assert np.isclose(digits(getattr(MIP, name), unit), said[name], rtol=1e-12), (
            name
        )
    assert np.allclose(digits([corners[0].e, corners[3].e], 1), said["e"], rtol=1e-12)
    assert [v.e for v in corners[:2]] == 2 * [corners[0].e]


def test_where_delta_belongs():
    """I_b and C_m have none; I_w has that of e/c over that of e/a."""
    corners = vertices(MIP)
    assert {(v.b, v.c, v.d, v.f) for v in corners} == {(MIP.b, MIP.c, MIP.d, MIP.f)}
    share = [v.I_w / MIP.I_w for v in corners]
    assert np.allclose(share, [1, 0.96 / 1.04, 1.04 / 0.96, 1])
    # Delta alone wouldn't give the printed range of a
    narrow = [MIP.a + 2 * MIP.I_w * x for x in (-0.04, 0.04)]
    assert not np.allclose(digits(narrow, 1e-3), PRINT.letters["a"][1:], rtol=1e-3)


def test_f_a_reconciles_the_four_ratios():
    """Least squares of logarithms, against numpy's."""
    q = PRINT.ratios
    mip = Mip.from_ratios(**q)
    d = MIP.d
    A = [[1, 0, 0], [0, 1, 0], [1, 0, -1], [0, 1, -1]]
    c = np.log(d / q["d_c"])
    right = np.log([q[x] for x in ("e_c", "f_c", "e_a", "f_a")])
    best = np.linalg.lstsq(A, right + [c, c, 0, 0], rcond=None)[0]
    assert np.allclose(np.exp(best), [mip.e, mip.f, 2 * mip.I_w])
    # ratios that agree are kept
    fair = Mip.from_ratios(30, 7, 110, 200, f_a=200 * 7 / 30)
    plain = Mip.from_ratios(30, 7, 110, 200)
    for name in "abcdef":
        assert np.isclose(getattr(fair, name), getattr(plain, name))


# ---- the polytope


def hull_distance(corners, plant):
    """Of (M, D, S, B) from the mixtures, relative to the entries."""

    def entries(v):
        return np.concatenate([getattr(v, x).ravel() for x in "MDSB"])

    A = np.transpose([entries(v) for v in corners])
    size = np.abs(A).max(axis=1)
    keep = size > 0
    A, y = A[keep] / size[keep, None], entries(plant)[keep] / size[keep]
    ones = np.ones((1, A.shape[1]))
    weight = 1e3  # of the sum being one
    return nnls(np.vstack([A, weight * ones]), [*y, weight])[1]


@pytest.mark.parametrize("rotors", [False, True])
def test_the_polytope_holds_just_what_the_spreads_allow(rotors):
    q = PRINT.ratios
    first = q["e_c"], q["f_c"], q["d_c"], q["e_a"]
    mip = Mip.from_ratios(*first, rotors=rotors)
    plants = polytope(mip)
    assert plants.N == 4
    rng = np.random.default_rng(3)
    for body, wheels in rng.uniform(0.96, 1.04, (30, 2)):
        true = Mip.from_ratios(
            q["e_c"] * body, *first[1:3], q["e_a"] * wheels, rotors=rotors
        )
        assert hull_distance(plants.vertices, true.plant()) < 1e-8
    fixed = mip.a - 2 * mip.I_w
    for v in plants.sample(30, seed=1):
        body = v.B[1, 0] / mip.e
        wheels = body * 2 * mip.I_w / (v.M[1, 1] - fixed)
        assert 0.96 - 1e-9 <= body <= 1.04 + 1e-9
        assert 0.96 - 1e-9 <= wheels <= 1.04 + 1e-9


# ---- bad input


@pytest.mark.parametrize(
    "change, message",
    [
        (dict(a=0), "a must be positive"),
        (dict(c=-1), "c must be positive"),
        (dict(b=1), "must be positive"),
        (dict(J=4e-4), "must be positive"),  # not at theta = pi
        (dict(f=np.nan), "f must be a finite number"),
        (dict(I_w="x"), "I_w must be a finite number"),
    ],
)
def test_bad_letters(change, message):
    letters = {x: getattr(MIP, x) for x in "abcdef"}
    with pytest.raises(ValueError, match=message):
        Mip(**letters | change)


def test_bad_ratios_and_spreads():
    with pytest.raises(ValueError, match="e_c must be positive"):
        Mip.from_ratios(0, 1, 1, 1)
    with pytest.raises(ValueError, match="2 I_w - M_w r.2 must be"):
        Mip.from_ratios(30.52, 7.133, 110.6, 2088, rotors=True)
    with pytest.raises(ValueError, match="f_a must be positive"):
        Mip.from_ratios(30.52, 7.133, 110.6, 208.8, f_a=-1)
    with pytest.raises(ValueError, match="r must be positive"):
        Mip.from_ratios(30.52, 7.133, 110.6, 208.8, r=0)
    for spread in (-0.1, 1.0, 1.5):
        with pytest.raises(ValueError, match="spread must lie"):
            vertices(MIP, spread)
    with pytest.raises(ValueError, match="mip has no I_w"):
        polytope(Mip(MIP.a, MIP.b, MIP.c, MIP.d, MIP.e, MIP.f))
