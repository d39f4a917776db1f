"""Rows of a family, multiplied by each other: one form, and one verdict."""

from math import prod

import numpy as np
import pytest
from flint import fmpq_mat

import sosbook as sos
from sosbook.exact.checker import verdict
from tests.cases import campaign


def crane(m, l):
    M, D = [[1 + m, m * l], [m * l, m * l**2]], [[0.2, 0], [0, 0]]
    return M, D, [[0, 0], [0, 9.81 * m * l]], [[1], [0]]


def bicycle(v):
    M, C = [[80.8, 2.3], [2.3, 0.298]], [[0, 33.9 * v], [-0.85 * v, 1.68 * v]]
    S = [[-793.6, -25.5 + 76.6 * v**2], [-25.5, -7.88 + 2.65 * v**2]]
    return M, C, S, [[0], [1]]


def three(m, c, k):
    """Unsymmetric, in units of .3, its first and last mass one parameter."""
    M, D = (
        [[m, 0, 0], [0, 0.3, 0], [0, 0, 2 * m]],
        [[c, 0, 0], [0, 0.1, 0], [0, 0, c * m]],
    )
    S = [[2 * k, -k, 0], [-k, 2 * k, -k], [0, -9.81, k]]
    return M, D, S, [[1], [0], [0]]


def gyroscope(a, b):
    """Products of two parameters, in two columns of one row."""
    M, D = [[1, 0], [b, 1]], [[0.3, -a], [a * b, 0.1]]
    return M, D, [[2, b], [0, 5]], [[1, 0], [0, 0.3]]


FAMILIES = {
    crane: dict(m=(0.5, 2), l=(4, 12)),
    bicycle: dict(v=(1, 10)),
    three: dict(m=(1, 2), c=(0.3, 1), k=(5, 9.81)),
    gyroscope: dict(a=(1, 2), b=(0.3, 0.7)),
}


def family(matrices, turns=()):
    """The family with multiples of rows added to rows, (i, j, factor) each."""

    def builder(**values):
        rows = np.hstack([np.array(x, object) for x in matrices(**values)])
        for i, j, factor in turns:
            rows[i] = rows[i] + factor(**values) * rows[j]
        n = len(rows)
        some = rows[:, :n], rows[:, n : 2 * n], rows[:, 2 * n : 3 * n], rows[:, 3 * n :]
        if all(isinstance(x, float) for x in values.values()):
            some = [x.astype(float) for x in some]
        return sos.SecondOrderSystem(*some)

    return sos.Uncertain(builder, **FAMILIES[matrices])


def turned(matrices, rng):
    """The family with such turns at random: their product has the determinant one."""
    names, n = (
        list(FAMILIES[matrices]),
        len(matrices(*[1] * len(FAMILIES[matrices]))[0]),
    )
    turns = []
    for _ in range(int(rng.integers(1, 5))):
        i, j = map(int, rng.choice(n, 2, replace=False))
        some, (scale, shift) = (
            rng.choice(names, rng.integers(1, 3)),
            rng.integers(-3, 4, 2),
        )

        def factor(*, some=some, scale=int(scale), shift=int(shift), **values):
            return scale * prod(values[k] for k in some) + shift

        turns.append((i, j, factor))
    return family(matrices, turns)


def coefficients(plants):
    """By row, the coefficients of all its polynomials."""
    names = "MDSB"
    places = sorted({(n, m) for n in names for m in plants.parts[n].monomials})
    parts = [plants.parts[n].coefficient(m) for n, m in places]
    return [
        [x for part in parts for x in part[i]] for i in range(len(parts[0]))
    ], places


@pytest.mark.filterwarnings("ignore::sosbook.MassWarning")
@pytest.mark.parametrize("seed", [0, *campaign(range(1, 20))])
@pytest.mark.parametrize("matrices", FAMILIES)
def test_multiples_of_rows_added_to_rows_leave_one_form(matrices, seed):
    """Up to sums with numbers, which move no plant in the hull: the rows of both forms
    have the span of one of them. Of several parameters no theorem says that, and one
    writing of five may keep higher powers: once a week some do.
    """
    rng, plain = np.random.default_rng(seed), family(matrices)
    (mine, places), kept = coefficients(plain), 0
    for _ in range(5):
        other = turned(matrices, rng)
        theirs, its_places = coefficients(other)
        if other.degree != plain.degree:
            kept += 1
            assert kept == 1 and seed and len(FAMILIES[matrices]) > 1
            continue
        assert its_places == places
        assert fmpq_mat(mine + theirs).rank() == len(mine) == fmpq_mat(theirs).rank()


@pytest.mark.filterwarnings("ignore::sosbook.MassWarning")
@pytest.mark.parametrize("matrices", [crane, *campaign([gyroscope])])
def test_multiples_of_rows_change_no_verdict_and_no_bound(matrices):
    rng, x0 = np.random.default_rng(3), [1, 0, 0, 0]
    asked = dict(region=sos.PoleRegion(sigma=0.2), saturation=sos.Saturation(None, x0))
    bounds = set()
    for plants in (family(matrices), turned(matrices, rng)):
        design = sos.design_pid(plants, minimize="u_max", coupling="slack", **asked)
        assert design.status == "feasible"
        bounds.add(design.request.saturation.u_max)
    assert max(bounds) <= 1.01 * min(bounds)


def test_the_crane_in_all_writings_takes_four_tenths_of_a_kilonewton():
    """Its first row less m times the divided second, written by hand in Lagrange's."""
    limit = dict(
        region=sos.PoleRegion(0.2), saturation=sos.Saturation(0.45, [1, 0, 0, 0])
    )
    plants = family(crane)
    assert [v.M[0].tolist() for v in plants.vertices] == [[1, 0]] * 4
    design = sos.design_pid(plants, **limit)
    proof = design.certify()
    assert proof.proven and verdict.check(proof.text) == list(proof.claims)
    for m, l in np.random.default_rng(1).uniform((0.5, 4), (2, 12), (100, 2)):
        M, D, S, B = map(np.array, crane(m, l))
        A = np.block(
            [[np.zeros((2, 2)), np.eye(2)], [-np.linalg.solve(M, x) for x in (S, D)]]
        )
        loop = A + np.vstack([0 * B, np.linalg.solve(M, B)]) @ proof.K
        assert np.linalg.eigvals(loop).real.max() < -0.2
