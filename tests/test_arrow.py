"""Newton's matrix of many vertices with a slack matrix, against the whole one."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

import sosbook as sos
from sosbook.lmi import Unknown, block, eye, he
from sosbook.solver.blocks import Blocks
from sosbook.solver.matrix import Arrow, ArrowMatrix, Dense, arrow_of
from sosbook.solver.newton import Newton
from sosbook.solver.settings import Settings
from sosbook.solver.structure import UnknownLayout
from sosbook.synthesis.request import Request
from sosbook.synthesis.scaling import Frame
from tests.cases import random_plant, seeds

few = settings(max_examples=40, derandomize=True, deadline=None)


def springs(vertices, n=2, **asked):
    """A chain of uncertain stiffness, and what is asked of it."""
    rng = np.random.default_rng([vertices, n])
    links = np.diff(np.eye(n), axis=0)
    T = links.T @ links + 0.5 * np.eye(n)
    plants = [
        sos.SecondOrderSystem(
            np.eye(n), 0.1 * T, T + np.diag(rng.uniform(0.7, 1.3, n)), np.eye(n)[:, :1]
        )
        for _ in range(vertices)
    ]
    asked = dict(region=sos.PoleRegion(0.1, rho=6)) | asked
    return sos.Polytope(plants), asked | dict(coupling=("slack", 0.2))


def compiled(plant, asked):
    request = Request(plant, **asked)
    expressions, unknowns = request.in_unknowns(Frame.of(request))
    return Blocks(expressions.values(), unknowns), unknowns


#: So few products that every arrow pays, and the best one most.
FEW = property(lambda arrow, count=Arrow.products.fget: count(arrow) / 1e9)


@pytest.fixture
def always(monkeypatch):
    """An arrow wherever there is one."""
    monkeypatch.setattr(Arrow, "products", FEW)
    monkeypatch.setattr(Blocks, "settings", Settings(arrow_from_variables=0))


def random_arrow(rng):
    """An `Arrow` of some unknowns in any order, and a matrix of its form."""
    kinds = rng.permutation([*np.repeat(range(rng.integers(2, 6)), 2), -1, -1])
    layouts, start = [], 0
    for _ in kinds:
        symmetric = bool(rng.integers(2))
        rows = int(rng.integers(2, 4))
        cols = rows if symmetric else int(rng.integers(1, 4))
        layouts.append(UnknownLayout(start, rows, cols, symmetric))
        start += layouts[-1].size
    scalars = start + np.arange(rng.integers(3))
    k = start + len(scalars)
    stacked = SimpleNamespace(layouts=layouts, scalars=scalars, variables=k)
    of = np.concatenate([np.full(u.size, kind) for u, kind in zip(layouts, kinds)])
    of = np.append(of, np.full(len(scalars), -1))
    shared = (of[:, None] == of) | (of[:, None] < 0) | (of < 0)
    H = np.zeros((k, k))
    for kind in range(max(kinds) + 1):  # a sum of positive semidefinite matrices
        some = np.flatnonzero((of == kind) | (of < 0))
        F = rng.standard_normal((len(some), len(some) + 2))
        H[np.ix_(some, some)] += F @ F.T
    assert not H[~shared].any()
    return Arrow(stacked, kinds), layouts, scalars, H


def written(matrix, layouts, scalars, H):
    """The entries of H, written to a matrix part by part."""
    matrix.clear()
    for i, u in enumerate(layouts):
        for v in layouts[i:]:
            part = H[u.start : u.start + u.size, v.start : v.start + v.size]
            if part.any():
                matrix.part(u, v)[...] = part
    for index in scalars:
        matrix.write_column(index, H[:, index])
    return matrix


@pytest.mark.last_digits
@few
@given(st.integers(0, 10**6), st.sampled_from([0, 1, 2]), st.sampled_from([0, 6, 12]))
def test_random_arrows_are_solved_like_whole_matrices(seed, columns, digits):
    """The residual is that of Cholesky's method in any units."""
    rng = np.random.default_rng(seed)
    arrow, layouts, scalars, H = random_arrow(rng)
    units = 10.0 ** (-rng.uniform(0, digits / 2, len(H)))
    H *= np.outer(units, units)
    squares = [units * rng.standard_normal(len(H)) for _ in range(columns)]
    g, ridge = rng.standard_normal(len(H)), 10.0 ** rng.uniform(-15, 0)
    whole = H + sum(np.outer(u, u) for u in squares) + 1e-13 * np.eye(len(H))
    whole += ridge * np.diag(whole.diagonal())
    for matrix in (ArrowMatrix(arrow), Dense(np.empty(H.shape))):
        matrix = written(matrix, layouts, scalars, H)
        for u in squares:
            matrix.add_square(u)
        matrix.add_diagonal(1e-13)
        matrix.fill_empty()
        d = matrix.factor(ridge)(g)
        rows = np.sqrt(whole.diagonal())
        assert (abs(whole @ d - g) / rows).max() < 1e-14 * (rows @ abs(d))


@pytest.mark.parametrize("place", ["leaf", "corner"])
def test_an_arrow_that_is_not_positive_definite_has_no_factor(place):
    arrow, layouts, scalars, H = random_arrow(np.random.default_rng(3))
    where = arrow.inner if place == "leaf" else arrow.border
    bad = H.copy()
    bad[where[0], where[0]] = 1e-3
    assert written(ArrowMatrix(arrow), layouts, scalars, bad).factor(0.0) is None
    bad[where[0], where[0]] = -1.0
    matrix = written(ArrowMatrix(arrow), layouts, scalars, bad)
    with pytest.raises(np.linalg.LinAlgError, match="positive definite"):
        matrix.fill_empty()


def test_variables_that_no_block_holds_are_ones():
    arrow, layouts, scalars, H = random_arrow(np.random.default_rng(4))
    matrix = written(ArrowMatrix(arrow), layouts, scalars, 0 * H)
    matrix.fill_empty()
    assert_allclose(matrix.whole(), np.eye(len(H)))


def leaves(blocks, unknowns):
    """Names of the unknowns of each leaf, and of the border."""
    newton = Newton(blocks)
    found = arrow_of(newton)
    matrices = [u for u in unknowns if u.shape != (1, 1)]
    names, border = [set() for _ in found.sizes], set()
    for u, layout in zip(matrices, newton.layouts):
        leaf, _ = found.places[layout.start]
        (border if leaf < 0 else names[leaf]).add(u.name)
    assert sorted([*found.inner, *found.border]) == list(range(newton.variables))
    return names, border


def test_any_unknowns_that_share_no_block_are_leaves(always):
    """Two unknowns to a leaf here, and a border that no name gives away."""
    n, rng = 2, np.random.default_rng(0)
    shared, written = Unknown("S", n), []
    unknowns = [shared]
    for k in range(4):
        X, Z = Unknown(f"X{k}", n, symmetric=True), Unknown(f"Z{k}", n, symmetric=True)
        unknowns += [X, Z]
        A = rng.standard_normal((n, n))
        written += [X + eye(n), block([[Z, A @ X], [(A @ X).T, eye(n)]])]
        written += [he(A @ shared) - X + 3 * eye(n)]
    names, border = leaves(Blocks(written, unknowns), unknowns)
    assert names == [{f"X{k}", f"Z{k}"} for k in range(4)]
    assert border == {"S"}


def test_there_is_no_arrow_without_a_border_or_with_one_matrix(always):
    plant, asked = springs(3)
    blocks, _ = compiled(plant, {"region": asked["region"]})
    assert arrow_of(Newton(blocks)) is None
    X, Z = (Unknown(name, 2, symmetric=True) for name in "XZ")
    assert arrow_of(Newton(Blocks([X, Z, eye(2) - X], [X, Z]))) is None


def test_few_vertices_take_the_whole_matrix_and_many_an_arrow():
    assert arrow_of(Newton(compiled(*springs(2))[0])) is None
    many = Newton(compiled(*springs(40, 3))[0])
    assert arrow_of(many) is not None
    assert many._arrow.entries < many.variables**2 / 5


def both(monkeypatch, plant, asked):
    """The design with an arrow, and without."""
    found = []
    monkeypatch.setattr(Arrow, "products", FEW)
    for least in (0, 10**9):
        monkeypatch.setattr(Blocks, "settings", Settings(arrow_from_variables=least))
        found.append(sos.design_pid(plant, **asked))
    return found


@pytest.mark.parametrize("vertices, n", [(2, 2), (7, 2), (3, 3)])
def test_an_arrow_changes_no_gain(vertices, n, monkeypatch):
    mine, wanted = both(monkeypatch, *springs(vertices, n))
    assert mine.status == wanted.status == "feasible"
    assert_allclose(mine.K, wanted.K, rtol=0, atol=1e-8 * abs(wanted.K).max())


@pytest.mark.parametrize("seed", seeds(12))
def test_an_arrow_changes_no_verdict(seed, monkeypatch):
    """Most of these plants have no solution, of some nothing is known."""
    rng = np.random.default_rng(seed)
    plant = random_plant(rng, 2, 1, 1, 3, rng.choice([0.05, 0.2, 0.6]))
    asked = dict(region=sos.PoleRegion(10 ** rng.uniform(-1, 0.3)))
    asked["gamma"] = 10 ** rng.uniform(-1.5, 1)
    mine, wanted = both(monkeypatch, plant, asked | dict(coupling=("slack", 0.2)))
    assert mine.status == wanted.status
    if mine.status == "feasible":
        assert_allclose(mine.K, wanted.K, rtol=0, atol=1e-6 * abs(wanted.K).max())


def test_a_matrix_too_large_to_be_whole_is_an_arrow(monkeypatch):
    """The limit counts the numbers that are held."""
    plant, asked = springs(30, 3)
    newton = Newton(compiled(plant, asked)[0])
    between = newton.variables // 2
    assert newton._arrow.entries < 0.9 * between**2
    limited = Settings(most_dense_variables=between)
    monkeypatch.setattr(Blocks, "settings", limited)
    assert sos.design_pid(plant, **asked).status == "feasible"
    monkeypatch.setattr("sosbook.solver.newton.arrow_of", lambda stacked: None)
    refused = sos.design_pid(plant, **asked)
    assert refused.status == "undecided" and "too many" in refused.reason
