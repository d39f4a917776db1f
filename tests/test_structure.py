"""The structure of LMI blocks against their plain derivatives."""

from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import sosbook as sos
from sosbook.book import thesis
from sosbook.lmi import Unknown, block, eye
from sosbook.solver.blocks import Blocks
from sosbook.solver.kronecker import Hessian
from sosbook.solver.newton import Newton
from sosbook.solver.settings import Settings
from sosbook.solver.stacks import Stacked, _Table, gram
from sosbook.solver.sums import Sums
from sosbook.synthesis.request import Request
from sosbook.synthesis.scaled_lmis import ScaledLMIs
from sosbook.synthesis.scaling import Frame
from tests.cases import GRADIENTS, campaign

EXAMPLES = {
    f"{k} {coupling}": (getattr(thesis, f"example_{k}"), coupling)
    for k in (1, 2, 3, 4)
    for coupling in ("pairs", "slack")
}
EXAMPLES["many"] = (lambda: many_vertices(), "pairs")


def many_vertices():
    """Stiffnesses on a grid, and two masses: pairs, whose factors are all different."""
    v, rng = thesis.example_1(), np.random.default_rng(2)
    M, D, S, B, F = (v.plant.vertices[0].__dict__[k] for k in "MDSBF")
    plants = [
        sos.SecondOrderSystem(M * mass, D, S * spring, B, F)
        for mass in (1.0, 1.25)
        for spring in 1 + 0.1 * rng.uniform(-1, 1, 6)
    ]
    return SimpleNamespace(plant=sos.Polytope(plants), requirements=v.requirements)


NOW = "1 slack", "2 pairs", "3 slack", "4 pairs", "many"


@pytest.fixture(params=[*NOW, *campaign(x for x in EXAMPLES if x not in NOW)])
def case(request):
    """Blocks of an example, a random point, and slopes with a lift."""
    make, coupling = EXAMPLES[request.param]
    example = make()
    coupling = ("slack", 0.1) if coupling == "slack" else coupling
    asked = Request(example.plant, coupling=coupling, **example.requirements)
    expressions, unknowns = asked.in_unknowns(Frame.of(asked))
    blocks = Blocks(expressions.values(), unknowns)
    x = np.random.default_rng(1).standard_normal(blocks.variables + 1)
    x[-1] = -1e4  # lifts all blocks until they are positive definite
    return blocks, x


def lifted(blocks, x):
    lift = [-np.eye(len(c)) for c in blocks.constants]
    slopes = [np.concatenate([s, e[None]]) for s, e in zip(blocks.slopes, lift)]
    G = [g + x[-1] * e for g, e in zip(blocks(x[:-1]), lift)]
    return lift, slopes, G


WAYS = {0: Sums, np.inf: _Table}


@pytest.fixture(params=WAYS)
def way(request, monkeypatch):
    """One way to the values of blocks: so large a table is held."""
    monkeypatch.setattr(Blocks, "settings", table_of(request.param))
    return WAYS[request.param]


def table_of(entries):
    return Settings(table_per_product=entries, most_table_entries=entries)


def test_the_adjoint_of_expressions_is_that_of_the_slopes(case):
    blocks, _ = case
    rng = np.random.default_rng(3)
    Z = [rng.standard_normal(c.shape) for c in blocks.constants]
    Z = [z + z.T for z in Z]
    wanted = sum(np.tensordot(s, z, 2) for s, z in zip(blocks.slopes, Z))
    fresh = Blocks(blocks.expressions, blocks.unknowns)
    assert_allclose(fresh.adjoint(Z), wanted, atol=1e-12 * abs(wanted).max())
    assert "slopes" not in vars(fresh)


def test_a_row_is_a_block_of_one_entry(case, way):
    """c + g.x beside the blocks: values, gradients, the Hessian."""
    blocks, x = case
    lift, slopes, G = lifted(blocks, x)
    gradient = np.random.default_rng(4).standard_normal(blocks.variables)
    c = 1 - gradient @ x[:-1]
    slopes.append(np.append(gradient, 0.0)[:, None, None])
    G.append(np.ones((1, 1)))
    stacked = Newton(blocks).joined(lift, (c, gradient))
    assert stacked.degree == Newton(blocks).degree + 1
    found = stacked.unstacked(stacked.at(x))
    for mine, plain in zip(found, G, strict=True):
        assert_allclose(mine, plain, rtol=0, atol=1e-11 * abs(plain).max())
    W = [np.linalg.inv(g) for g in G]
    plain = sum(np.tensordot(s, w, 2) for s, w in zip(slopes, W))
    roots = [np.linalg.inv(np.linalg.cholesky(g)) for g in stacked.at(x)]
    assert_allclose(stacked.adjoint(gram(roots)), plain, atol=1e-11 * abs(plain).max())
    plain = sum(
        np.einsum("aij,jk,bkl,li->ab", s, w, s, w, optimize=True)
        for s, w in zip(slopes, W)
    )
    assert_allclose(Hessian(stacked)(roots), plain, atol=1e-11 * abs(plain).max())


def test_slabs_are_the_same_matrix(case):
    """Unknowns of many rows are taken row by row."""
    blocks, x = case
    stacked = Stacked(blocks)
    rng = np.random.default_rng(2)
    roots = [rng.standard_normal(s.constant.shape) for s in stacked.stacks]
    at_once = Hessian(stacked)(roots)
    stacked.settings = Settings(slabs_from_rows=1)
    in_slabs = Hessian(stacked)(roots)
    assert_allclose(in_slabs, at_once, rtol=0, atol=1e-13 * abs(at_once).max())


def test_sizes_are_those_of_the_slopes(case, way):
    blocks, _ = case
    for c, s, d in zip(blocks.constants, blocks.slopes, blocks.diagonal_scales):
        size = np.abs(np.diag(c)) + np.sqrt(
            (np.diagonal(s, axis1=1, axis2=2) ** 2).sum(axis=0)
        )
        assert (abs(np.log2(size * d**2)) <= 1 + 1e-9).all()


def test_numbers_and_matrices_may_be_mixed():
    """max t with [[X, t C], [t C', I]] > 0: an unknown in the middle."""
    X, t = Unknown("X", 2, symmetric=True), Unknown("t", 1)
    Y = Unknown("Y", 2, 3)
    C = np.arange(6.0).reshape(2, 3)
    g = block([[X, t * C + Y], [(t * C + Y).T, 5 * eye(3)]])
    blocks = Blocks([g, X], [X, t, Y])
    x = np.concatenate([X.pack(9 * np.eye(2)), [0.1], np.full(6, 0.2)])
    stacked = Stacked(blocks)
    for mine, plain in zip(stacked.unstacked(stacked.at(x)), blocks(x)):
        assert_allclose(mine, plain)
    roots = [np.linalg.inv(np.linalg.cholesky(g)) for g in stacked.at(x)]
    W = [np.linalg.inv(g) for g in blocks(x)]
    plain = sum(
        np.einsum("aij,jk,bkl,li->ab", s, w, s, w) for s, w in zip(blocks.slopes, W)
    )
    assert_allclose(Hessian(stacked)(roots), plain, atol=1e-14)


def chain(n):
    T = 2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    B = np.eye(n)[:, ::4]
    plant = sos.SecondOrderSystem(
        np.eye(n), 0.1 * np.eye(n) + 0.05 * T, np.eye(n) + T, B, B
    )
    region = sos.PoleRegion(0.1, np.radians(86), 4)
    return plant, dict(U=B.T, region=region, gamma=0.2)


def test_a_stiff_plant_falls_back_on_the_dense_matrix(monkeypatch):
    """Where conjugate gradients fail the answer is the same."""
    plant, asked = chain(4)
    wanted = sos.design_pid(plant, **asked)
    monkeypatch.setattr(Blocks, "settings", GRADIENTS)
    monkeypatch.setattr(
        "sosbook.solver.newton._conjugate_gradients", lambda *words: (None, 300)
    )
    found = sos.design_pid(plant, **asked)
    assert_allclose(found.K, wanted.K, atol=1e-8 * abs(wanted.K).max())


def test_the_smallest_eigenvalues_and_some_of_the_blocks(case):
    blocks, x = case
    x = x[:-1] / 100
    eigenvalues = [np.linalg.eigvalsh(g)[0] for g in blocks(x)]
    least = Newton(blocks).least(x)
    assert_allclose(least, np.minimum(eigenvalues, 1), atol=1e-9 * max(1, -min(least)))
    places = [2, 0]
    some = Blocks([blocks.expressions[k] for k in places], blocks.unknowns)
    some = Newton(some).least(x)
    assert_allclose(some, least[places], atol=1e-12 * max(1, -min(least)))


@pytest.mark.parametrize("k", [1, 2, 3])
def test_the_first_guess_is_stable(k):
    """The frame's gain, with P = I, is that of a Riccati equation."""
    example = getattr(thesis, f"example_{k}")()
    request = Request(example.plant, U=example.U, K_A=example.requirements.get("K_A"))
    frame = Frame.of(request)
    A, B, _ = request.mean.state_space()
    K = frame.scale * frame.gain @ np.linalg.inv(frame.T)
    assert np.linalg.eigvals(A + B @ K).real.max() < 0
    if k == 1:  # and P = I proves it
        lmis = ScaledLMIs(request, frame)
        assert min(lmis.text.margins(lmis.guess()).values()) > 0


def test_without_multipliers_a_refusal_is_left_open():
    robot = thesis.example_1()
    asked = robot.requirements | {"region": sos.PoleRegion(2, np.pi / 4, 5)}
    request = Request(robot.plant, **asked)
    expressions, unknowns = request.in_unknowns(Frame.of(request))
    blocks = Blocks(expressions.values(), unknowns)
    assert sos.solver.loop.phase_one(blocks).verdict == "infeasible"
    open_ = sos.solver.loop.phase_one(blocks, multipliers=False)
    assert open_.verdict == "undecided" and open_.Z is None


@pytest.mark.parametrize("unit", [0.3, 1e20, *campaign([1e-9, 1e-20])])
def test_a_row_in_another_unit_has_its_own_size(unit):
    """Its diagonal entry has the unit's square, the others in its row the unit."""
    x = [Unknown(name, 1) for name in "abc"]
    row = np.array([[1.0, 0], [0, unit]])
    g = row @ block([[x[0], x[1]], [x[1], x[2]]]) @ row
    (sizes,) = Blocks([g], x).diagonal_scales
    assert sizes == pytest.approx([1, 1 / unit], rel=0.5)


def test_an_entry_that_rounding_made_is_no_entry(monkeypatch):
    """Between E = diag(1, 1) and diag(1, -1) a diagonal entry cancels out."""
    E = [np.eye(2), np.diag([1.0, -1.0])]
    plant = sos.DescriptorSystem(E, np.array([[0.1, 0.7], [0.3, 0.2]]), [[0], [1]])
    lmis = ScaledLMIs(request := Request(plant), Frame.of(request))
    for entries in (0, 1e9):
        monkeypatch.setattr(Blocks, "settings", table_of(entries))
        blocks = Blocks(lmis.text.expressions.values(), lmis.unknowns)
        assert max(d.max() for d in blocks.diagonal_scales) < 100
    assert sos.design_pid(plant).status == "infeasible"


def test_a_matrix_without_a_factor_is_made_again(case, monkeypatch):
    """A factor takes its matrix's place; the next ridge needs the matrix itself."""
    blocks, x = case
    lift, _, _ = lifted(blocks, x)
    newton = Newton(blocks).joined(lift)
    newton.iterative = False
    roots = [np.linalg.inv(np.linalg.cholesky(g)) for g in newton.at(x)]
    g = np.random.default_rng(6).standard_normal(len(x))
    wanted = newton.solver(roots, x)(g)
    monkeypatch.setattr("sosbook.solver.newton.RIDGES", [-2.0, -3.0, 1e-15])
    assert_allclose(newton.solver(roots, x)(g), wanted, rtol=1e-12)
