"""Regions of the poles: alpha + beta s + beta' conj(s) < 0."""

from fractions import Fraction
from functools import cache

from .arithmetic import need
from .families import keys
from .text import mat, number, positive, words_of

PI = Fraction(314159265358979323846264338327950288, 10**35)  # rounded down
TINY = Fraction(1, 10**9)
STABLE = "its poles lie left of the imaginary axis"


@cache
def tangent(degrees):
    """A fraction just below the tangent of an angle in (0, 90] degrees."""
    x, term, sums = PI * degrees / 180, Fraction(1), [Fraction(0), Fraction(0)]
    for k in range(33):
        sums[k % 2] += term * (-1) ** (k // 2)
        term = term * x / (k + 1)
    return sums[1] / sums[0]


def near(wanted, written):
    """True if a number is the one that is wanted, or a little more."""
    return 0 <= written - wanted <= TINY * abs(wanted)


FORMS = {
    "half-plane": "sigma",
    "sector": "theta apex degrees",
    "disk": "rho centre",
    "strip": "left right",
    "horizontal strip": "omega",
    "ellipse": "centre a b",
    "matrices": "",
}


def region(r):
    """alpha, beta, and the claim that the region implies.

    They are those of the form that is claimed, but for roundings inwards: what
    excludes them excludes the form.
    """
    form = r["form"]
    need(form in FORMS, f"the form {form!r} isn't known")
    keys(r, "kind name form alpha beta " + FORMS[form])
    k = len(r["alpha"])
    A, B = (mat(r[x], k, k, name=x) for x in ("alpha", "beta"))
    need(A == A.T and k, "alpha must be symmetric")
    alpha, beta = ([[x.at(i, j) for j in range(k)] for i in range(k)] for x in (A, B))
    if form == "half-plane":
        sigma = number(r["sigma"])
        good = beta == [[1]] and near(2 * sigma, alpha[0][0])
        minus = r["sigma"][1:] if sigma < 0 else "-" + r["sigma"]
        text = f"half-plane Re s < {minus if sigma else 0}"
    elif form == "disk":
        rho, centre = positive(r["rho"]), number(r["centre"])
        good = alpha == [[-rho, -centre], [-centre, -rho]] and beta == [[0, 1], [0, 0]]
        text = f"disk of radius {r['rho']} around {r['centre']}"
    elif form == "sector":
        sine, cosine = beta[0]
        degrees, apex = positive(r["degrees"]), number(r["apex"])
        theta = positive(r["theta"]) * 180 / PI
        good = beta == [[sine, cosine], [-cosine, sine]] and min(sine, cosine) > 0
        good = good and alpha[0][0] == alpha[1][1] and max(degrees, theta) <= 90
        good = good and alpha[0][1] == 0 and near(-2 * sine * apex, alpha[0][0])
        good = good and sine <= cosine * min(tangent(degrees), tangent(theta))
        good = good and sine >= cosine * tangent((1 - TINY) * theta)
        least = tangent(degrees - Fraction(1, 100))  # they are rounded up, to that
        good = good and sine >= cosine * least
        text = f"sector of half-angle {r['degrees']} degrees"
        text += f" with apex {r['apex']}" if apex else ""
    elif form == "strip":
        left, right = number(r["left"]), number(r["right"])
        good = beta == [[-1, 0], [0, 1]] and alpha[0][1] == 0
        good = good and near(2 * left, alpha[0][0]) and near(-2 * right, alpha[1][1])
        text = f"strip {r['left']} < Re s < {r['right']}"
    elif form == "horizontal strip":
        limit = -2 * positive(r["omega"])
        good = beta == [[0, 1], [-1, 0]] and alpha[0][1] == 0
        good = good and near(limit, alpha[0][0]) and near(limit, alpha[1][1])
        text = f"horizontal strip |Im s| < {r['omega']}"
    elif form == "ellipse":  # |g x - h + i k y| < radius
        a, b, centre = positive(r["a"]), positive(r["b"]), number(r["centre"])
        g, k = beta[0][1] + beta[1][0], beta[0][1] - beta[1][0]
        h, radius = -alpha[0][1], -alpha[0][0]
        good = beta[0][0] == beta[1][1] == 0 and alpha[0][0] == alpha[1][1]
        good = good and min(g, k) > 0 and (
            radius * max(1 / (g * a), 1 / (k * b)) + abs(h / g - centre) / a <= 1
            and radius * min(1 / (g * a), 1 / (k * b)) >= 1 - TINY
        )  # fmt: skip
        text = f"ellipse of half axes {r['a']} and {r['b']} around {r['centre']}"
    else:
        return alpha, beta, in_matrices(r)
    need(good, f"alpha and beta don't belong to the {form} that is claimed")
    return alpha, beta, "its poles lie in the " + text


def at_ticks(plant, alpha, beta, words):
    """A region of z as one of s, with z = 1 + dt s: alpha + beta s + beta' s* changes.

    Of a plant without ticks nothing does.
    """
    if "dt" not in plant:
        return alpha, beta, words
    dt, k = positive(plant["dt"]), range(len(alpha))
    alpha = [[(alpha[i][j] + beta[i][j] + beta[j][i]) / dt for j in k] for i in k]
    return alpha, beta, of_z(words)


def of_z(words):
    """The words of a region as one of the poles z of a plant of discrete time."""
    for old, new in (("its poles lie", "its poles z lie"), (" s < ", " z < "),
                     ("beta s + beta' s*", "beta z + beta' z*"),
                     ("|Im s|", "|Im z|")):  # fmt: skip
        words = words.replace(old, new)
    return words


def in_matrices(r):
    return (
        "its poles lie in the region alpha + beta s + beta' s* < 0, with alpha = "
        + words_of(r["alpha"]) + " and beta = " + words_of(r["beta"])
    )  # fmt: skip
