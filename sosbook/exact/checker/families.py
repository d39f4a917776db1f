"""Plants with parameters in ranges, as a file has them, and their vertices."""

import re
from fractions import Fraction
from functools import cache
from math import comb, prod

from .arithmetic import MOST_DIGITS, named, need

MATRICES = {"second order": "M D S B F", "descriptor": "E A B B_w C D_u D_w C_a"}
SIGNAL = r"(?=[\w(-])(?:[\w ()'+#/-]|[.](?! )){1,99}(?<! )"
CONSTANT, CHANGING = "constant", "constant or changing"
BESIDE = "reduced", "states", "dt"  # what any plant may have beside its matrices
MOST_FAMILY = 256  # vertices of a plant with parameters
NAME, DIGITS = r"[A-Za-z_][A-Za-z0-9_]*", rf"[0-9]{{1,{MOST_DIGITS}}}"
FACTOR = (rf"(?:{DIGITS}/{DIGITS}|{DIGITS}(?:[.]{DIGITS})?(?:e[-+]?[0-9]{{1,3}})?"
          rf"|{NAME}(?:\^[0-9]{{1,2}})?)")  # fmt: skip


def keys(what, names, of=""):
    need(set(what) == set(names.split()), f"the keys{of} must be {names}")


def part_of(plant):
    """The first words of a claim about a reduced model: its number of coordinates."""
    if "reduced" not in plant:
        return ""
    kept, of = plant["reduced"]
    need(0 < kept < of, "reduced: nothing is left out")
    return f"of the reduced model ({kept} of {of}): "


def given_vertices(plant):
    """The matrices of each vertex by name; a reduced model has as many as it says."""
    part_of(plant)
    vertices = whole_vertices({k: x for k, x in plant.items() if k not in BESIDE})
    first = vertices[0].get("M", vertices[0].get("E"))
    names = plant.get("states", first)
    good = names is first or ("E" in vertices[0] and len(names) == len(first))
    need(good, "names are of the states of a descriptor form")
    need(len(first) == plant.get("reduced", [len(first)])[0], "other rows are kept")
    return vertices


def whole_vertices(plant):
    """The matrices of each vertex by name: as the file has them, or Bernstein's.

    With parameters p in [a, b] they are polynomials. In Bernstein's form of degree d
    p^e has for i = 0 .. d the coefficients

        c_i = sum_j C(i, j) C(d - i, e - j) b^j a^(e - j) / C(d, e)

    and p^e = sum_i w_i c_i with w_i = C(d, i) t^i (1 - t)^(d - i) >= 0 of sum 1, where
    t = (p - a) / (b - a). With several parameters the products of their w_i have the
    sum 1, too: so every plant is a mean of the vertices. Where a range is cut into
    equal pieces, two of which meet, c_d of the one is c_0 of the other, and, since the
    slope d (c_d - c_(d-1)) / (b - a) is one, too, the mean of c_(d-1) and the other's
    c_1: it is in the hull of the rest and left out.
    """
    need(plant["kind"] in MATRICES, "a plant of this kind isn't known")
    if "parameters" not in plant:
        need(plant["vertices"], "the plant has no vertex")
        alike = plant["kind"] == "descriptor" and "C" not in plant["vertices"][0]
        keys(plant, "kind vertices" + " C D_u" * alike, " of plant")
        return plant["vertices"]
    ends, cells, degrees, read = ranges(plant)

    @cache
    def coefficient(k, place, e):
        (low, high), d, (cell, i) = list(ends.values())[k], degrees[k], place
        step = (high - low) / cells[k]
        a, b = low + cell * step, low + (cell + 1) * step
        return sum(Fraction(comb(i, j) * comb(d - i, e - j), comb(d, e)) * b**j
                   * a ** (e - j) for j in range(e + 1))  # fmt: skip

    def at(place):
        return {x: [[sum((c * prod(coefficient(k, i, e)
                                   for k, (i, e) in enumerate(zip(place, p)))
                          for p, c in entry.items()), Fraction(0))
                     for entry in row] for row in rows]
                for x, rows in read.items()}  # fmt: skip

    return [{x: [[str(e) for e in row] for row in rows]
             for x, rows in at(place).items()}
            for place in places(cells, degrees)]  # fmt: skip


def places(cells, degrees):
    """Of each vertex the piece and the coefficient of each parameter."""
    all_ = [()]
    for d, n in zip(degrees, cells):
        inner = ((c, i) for c in range(n * (d > 1)) for i in range(1, d))
        own = [(0, 0), *inner, (n - 1, d)]
        all_ = [(*place, x) for place in all_ for x in own]
    return all_


def vertex_words(plant, k, many):
    """The k-th of many vertices, from 1: of ranges a corner by its parameters."""
    if plant.get("parameters"):
        _, cells, degrees, _ = ranges(plant)
        place = places(cells, degrees)[k - 1]
        if all(x in ((0, 0), (n - 1, d)) for x, n, d in zip(place, cells, degrees)):
            named = zip(plant["parameters"], place)
            at = [f"{name} = {high if x != (0, 0) else low}"
                  for (name, low, high, *_), x in named]  # fmt: skip
            return "the plant with " + " and ".join(at)
    return f"the vertex {k}" if many > 1 else "the plant"


def ranges(plant):
    """Of the parameters the ends, pieces and degrees; the matrices of polynomials."""
    measured = plant.get("schedule")
    plant = {k: x for k, x in plant.items() if k not in (*BESIDE, "schedule")}
    names = MATRICES[plant["kind"]]
    may = dict.fromkeys(("D_u", "D_w", "C_a")) if "D_u" in names else {}
    keys(may | plant, "kind parameters " + names, " of plant")
    ends, cells = {}, []
    with named("plant.parameters"):
        for name, a, b, *more in plant["parameters"]:
            need(name not in ends, "a parameter comes twice")
            a, b = ends[name] = single(a), single(b)
            need(re.fullmatch(NAME, name) and a < b, f"{name!r:.40} has no range")
            cells += more or [1]
            need(not more or more[0] > 1, "one piece is no cut")
    parts = {x: plant[x] for x in names.split() if plant.get(x) is not None}
    read = {}
    for x, rows in parts.items():
        with named(f"plant.{x}"):
            read[x] = [[polynomial(e, ends) for e in row] for row in rows]
    powers = {p for rows in read.values() for row in rows for e in row for p in e}
    degrees = [max((p[k] for p in powers), default=0) for k in range(len(ends))]
    many = prod(2 + (d - 1) * n for d, n in zip(degrees, cells) if d)
    need(many <= MOST_FAMILY, "the family has too many vertices")
    need(all(degrees), "the plant doesn't depend on one of its parameters")
    if measured is not None:
        scheduled(measured, ends, read)
    return ends, cells, degrees, read


def scheduled(measured, ends, read):
    """See that the inputs are those of B times the weights of corners.

    With a gain for each corner of the measured ranges, K(p) is their mean by weights
    w_i >= 0 of sum 1, products of (p - a)/(b - a) or (b - p)/(b - a). Then B K(p) is
    [w_1 B, w_2 B, ...] times the gains below each other, a constant one.
    """
    good = measured and len(measured) == len({*measured})
    need(good and {*measured} <= ends.keys(), "what is measured is no parameter")
    none = dict.fromkeys(ends, 0)
    weights = [{tuple(none.values()): Fraction(1)}]
    for name in measured:
        (a, b), one = ends[name], tuple((none | {name: 1}).values())
        zero = tuple(none.values())
        down, up = (
            {one: s / (b - a), zero: e / (b - a)} for s, e in ((-1, b), (1, -a))
        )
        weights = [product_of(w, x) for w in weights for x in (down, up)]
    for rows in (read[x] for x in ("B", "D_u") if x in read):
        for row in rows:
            m, rest = divmod(len(row), len(weights))
            need(not rest, "a corner of what is measured has no inputs")
            for j in range(m):
                whole = {}
                for entry in row[j::m]:
                    for place, c in entry.items():
                        whole[place] = whole.get(place, 0) + c
                good = [product_of(whole, w) for w in weights] == row[j::m]
                need(good, "the inputs aren't those of B by the weights of corners")


def product_of(first, second):
    """The product of two polynomials, coefficients by powers."""
    found = {}
    for p, c in first.items():
        for q, d in second.items():
            place = tuple(map(sum, zip(p, q)))
            found[place] = found.get(place, 0) + c * d
    return {place: c for place, c in found.items() if c}


def polynomial(text, ends):
    """Coefficients by powers of the parameters, of a sum of products."""
    need(text, f"{text!r:.40} is no polynomial")
    rest, terms = text.replace(" ", ""), {}
    while rest:
        found = re.match(rf"([-+]?)({FACTOR}(?:\*{FACTOR})*)", rest, re.ASCII)
        need(found and (found[1] or not terms), f"{text!r:.40} is no polynomial")
        c, powers = Fraction(-1 if found[1] == "-" else 1), dict.fromkeys(ends, 0)
        for factor in found[2].split("*"):
            name, _, power = factor.partition("^")
            if name[0].isdigit():
                need(not re.search("/0+$", factor), "a division by zero")
                c *= Fraction(factor)
            else:
                need(name in ends, f"{name:.40} has no range")
                powers[name] += int(power or 1)
        place = tuple(powers.values())
        terms[place], rest = terms.get(place, 0) + c, rest[found.end() :]
    terms = {place: c for place, c in terms.items() if c}
    need(text == in_words(terms, ends), f"{text!r:.40} isn't in its shortest form")
    return terms


def in_words(terms, names):
    """A polynomial as it is written: powers fall, coefficients are short decimals."""
    text = ""
    for powers, c in sorted(terms.items(), reverse=True):
        whole = abs(c) * 10**10  # more decimals than ten are a fraction
        value = str(abs(c)) if whole.denominator > 1 else decimal(abs(c))
        parts = [x if e == 1 else f"{x}^{e}" for x, e in zip(names, powers) if e]
        parts = [value] * (abs(c) != 1 or not parts) + parts
        sign = "-" if c < 0 else "+" if text else ""
        text += (f" {sign} " if text else sign) + "*".join(parts)
    return text or "0"


def single(text):
    return sum(polynomial(text, {}).values(), Fraction(0))


def every(which, scope):
    """Of which plants a proof of some ``scope`` speaks.

    A Lyapunov matrix or functional that all plants share also falls while the plant
    changes: in E(p(t)) x' = A(p(t)) x at each instant it knows p(t) alone. (A mass that
    changes and carries its momentum along obeys (E x)' = A x, which isn't meant.) With
    a matrix of each plant's own nothing is said of a plant that changes. What is about
    no motion, as a regular mass, has no scope.
    """
    return f"every {scope}{' ' * bool(scope)}plant {which}"


def every_plant(plant, many, scope=""):
    """Of which plants a proof says something, see `every`."""
    given = plant.get("parameters", ())
    ranges = [f"{x} in [{a}, {b}]" for x, a, b, *_ in given]
    if ranges:
        *most, last = ranges
        which = f"with {', '.join(most)} and {last}" if most else f"with {last}"
        return every(which + by_corners(plant.get("schedule", ())), scope)
    return every("of the polytope", scope) if many > 1 else "the plant"


def by_corners(measured):
    """That the gain follows what is ``measured``, in words; nothing without it."""
    there = " and ".join(measured)
    return f", with a gain for each corner of {there} by its weight" * bool(there)


def listed(names, many):
    """The ``names`` of so ``many`` signals in words, [a, b]: none is a sentence."""
    good = len({*names}) == len(names) == many
    good = good and all(re.fullmatch(SIGNAL, x) for x in names)
    need(good, "signals have names, each its own")
    return f"[{', '.join(names)}]"


def under(plant, law=None, free=0, late=""):
    """How u comes about, in the words of a claim about a ``plant`` of the file.

    With a ``law`` K multiplies its signals, and gives u and x_c' of ``free`` states.
    ``late`` says of which time x is, where it isn't now.
    """
    states = plant.get("states")
    x = "" if states is None else listed(states, len(states))
    if law is None:
        return f", under u = K x{late}" + f" with x = {x}" * bool(x) + ","
    y, own = law["signals"], law["states"]
    change = ", {0}'" if "dt" not in plant else ", (next {0} - {0})/({1} s)"
    moved = [change.format(x, plant.get("dt")) for x in own[len(own) - free :]]
    moved = "".join(moved)
    memory = f" and the memory {listed(own, len(own))}" if own else ""
    given = f"[u{moved}]" if moved else "u"
    where = f", of the states {x}" * bool(x)
    return f", under {given} = K y with y = {listed(y, len(y))}{memory}{where},"


def ticks(plant):
    """The clock of a plant of discrete time, in the words of a claim."""
    return f" from tick to tick of {plant['dt']} s" if "dt" in plant else ""


def decimal(x):
    """A fraction with a finite decimal expansion, written out."""
    k = next(k for k in range(800) if (x * 10**k).denominator == 1)
    digits = str(abs(x * 10**k)).rjust(k + 1, "0")
    text = digits[: len(digits) - k] + ("." + digits[len(digits) - k :] if k else "")
    return "-" * (x < 0) + text
