"""Large requests: no dense matrix of all variables, in time or in memory."""

import os
import sys

import numpy as np
import pytest
from numpy.testing import assert_allclose

import sosbook as sos
from sosbook.lmi import Unknown, he
from sosbook.solver.blocks import Blocks
from sosbook.solver.bounded import any_centre, bounded
from sosbook.solver.loop import centre, phase_one
from sosbook.solver.newton import Newton
from sosbook.solver.settings import Settings
from sosbook.solver.sums import Sums
from sosbook.synthesis.request import Request
from sosbook.synthesis.scaling import Frame
from tests.cases import DENSE, GRADIENTS, by_turns
from tests.processes import process

FREE_CHAIN = """
import resource, sys
import numpy as np
import sosbook as sos

n = int(sys.argv[1])
links = np.diff(np.eye(n), axis=0)
S = links.T @ links + 0.1 * np.eye(n)
B = np.eye(n)[:, :: 4]
plant = sos.SecondOrderSystem(np.eye(n), 0.02 * S, S, B)
region = sos.PoleRegion(0.1, np.radians(75), 8)
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
design = sos.design_pid(plant, U=B.T, region=region)
after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
unit = 1 if sys.platform == "darwin" else 1024
assert design.status == "feasible", design.reason
print((after - before) * unit)
"""


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="needs the module resource")
def test_an_unbounded_request_of_60_states_needs_no_dense_matrix():
    """One slope a variable as a dense matrix would take 600 MB."""
    command = [sys.executable, "-c", FREE_CHAIN, "30"]
    done = process(*command, check=True, env=os.environ)
    assert int(done.stdout) < 150e6


def lyapunov(A):
    P = Unknown("P", len(A), symmetric=True)
    return Blocks([P, -he(A @ P)], [P]), P


@pytest.mark.parametrize("length", [1e-6, 1.0, 1e6])
def test_the_bound_of_a_cone_holds_a_multiple_of_any_point(length, monkeypatch):
    """No phase one: it would begin anew."""
    monkeypatch.setattr("sosbook.solver.bounded.phase_one", None)
    A = np.array([[0.0, 1.0], [-2.0, -1.0]])
    blocks, P = lyapunov(A)
    X = np.array([[1.0, -0.3], [-0.3, 1.5]])
    x = length * P.pack(X)
    joined, inside = bounded(blocks, [P], x)
    assert all(np.linalg.eigvalsh(g)[0] > 0 for g in joined(inside))
    assert_allclose(inside * np.linalg.norm(x), x * np.linalg.norm(inside))
    found = any_centre(blocks, [P], x)
    assert_allclose(found, centre(joined, inside), rtol=1e-6)
    _, large = bounded(blocks, [P], x, size=14.0)
    assert_allclose(np.linalg.norm(P.unpack(large), 2), 14)


def request_of(plant, asked):
    request = Request(plant, **asked)
    expressions, unknowns = request.in_unknowns(Frame.of(request))
    return Blocks(expressions.values(), unknowns)


def some_plant(rng, n):
    """Random modes, dampers and forces; every second one with a disturbance."""
    Q = np.linalg.qr(rng.standard_normal((n, n)))[0]
    rates = rng.uniform(0.5, 4, n)
    S, D = Q @ np.diag(rates**2) @ Q.T, Q @ np.diag(0.1 * rates) @ Q.T
    B, F = rng.standard_normal((n, max(1, n // 2))), rng.standard_normal((n, 1))
    plant = sos.SecondOrderSystem(np.eye(n), (D + D.T) / 2, (S + S.T) / 2, B, F)
    region = sos.PoleRegion(0.05, np.radians(86), 12)
    asked = dict(region=region, gamma=5.0) if n % 2 else dict(region=region)
    return plant, asked


@pytest.mark.parametrize("n", range(3, 9))
def test_both_ways_take_the_same_newton_step(n, monkeypatch):
    """Whatever the plant and the region."""
    rng = np.random.default_rng(n)
    blocks = request_of(*some_plant(rng, n))
    lifts = [-np.eye(len(c)) for c in blocks.constants]
    monkeypatch.setattr(Blocks, "settings", DENSE)
    dense = Newton(blocks).joined(lifts)
    monkeypatch.setattr(Blocks, "settings", GRADIENTS)
    iterative = Newton(blocks).joined(lifts)
    assert iterative.iterative and not dense.iterative
    x = rng.standard_normal(dense.variables) / 10
    x[-1] = -10 - abs(dense.least(x).min())
    roots = [np.linalg.inv(np.linalg.cholesky(g)) for g in dense.at(x)]
    g = rng.standard_normal(len(x))
    wanted = dense.solver(roots, x, 1e3)(g)
    found = iterative.solver(roots, x, 1e3)(g, 1e-9)
    assert_allclose(found, wanted, atol=1e-6 * abs(wanted).max())


def chain_of(n):
    links = np.diff(np.eye(n), axis=0)
    S = links.T @ links + 0.1 * np.eye(n)
    plant = sos.SecondOrderSystem(np.eye(n), 0.02 * S, S, np.eye(n)[:, ::4])
    return plant, dict(region=sos.PoleRegion(0.1, np.radians(75), 8))


def centre_of(request, conjugate, monkeypatch):
    """The centre's x, by conjugate gradients or by a dense matrix."""
    monkeypatch.setattr(Blocks, "settings", GRADIENTS if conjugate else DENSE)
    blocks = request_of(*request)
    x = phase_one(blocks).x
    newton = blocks.newton
    found = centre(blocks, x)
    assert newton.iterative == conjugate
    return found


def net(rng, n):
    """Masses in a net of random springs, every fourth one with a force."""
    ends = [rng.choice(n, 2, replace=False) for _ in range(2 * n)]
    links = np.array([np.eye(n)[i] - np.eye(n)[j] for i, j in ends])
    L = links.T @ np.diag(rng.uniform(0.5, 2, len(links))) @ links
    B = np.eye(n)[:, ::4]
    M = np.diag(rng.uniform(0.7, 1.4, n))
    plant = sos.SecondOrderSystem(M, 0.1 * np.eye(n) + 0.05 * L, np.eye(n) + L, B, B)
    region = sos.PoleRegion(0.1, np.radians(86), 8)
    return plant, dict(U=B.T, region=region, gamma=0.4)


@pytest.mark.parametrize("n", by_turns([4, 6, 9, 13], 0))
def test_conjugate_gradients_find_the_centre_of_the_dense_matrix(n, monkeypatch):
    request = net(np.random.default_rng(n), n)
    wanted = centre_of(request, False, monkeypatch)
    found = centre_of(request, True, monkeypatch)
    assert_allclose(found, wanted, rtol=0, atol=1e-4 * abs(wanted).max())


def test_few_variables_have_a_table_and_a_matrix_and_many_have_neither():
    stacked = [Newton(request_of(*chain_of(n))) for n in (2, 6, 10, 14, 24)]
    tables = [not isinstance(s.values, Sums) for s in stacked]
    assert tables[0] and not any(tables[2:])
    iterative = [s.iterative for s in stacked]
    assert iterative == sorted(iterative) and iterative[-1] and not iterative[0]


def test_a_matrix_takes_over_where_gradients_take_longer(monkeypatch):
    """No iteration is taken that costs more than the matrix: the answer stays."""
    plant, asked = chain_of(6)
    wanted = sos.design_pid(plant, **asked).K
    monkeypatch.setattr(Blocks, "settings", Settings(expected_iterations=0))
    made, init = [], Newton.__init__

    def remembered(self, *args, **words):
        init(self, *args, **words)
        made.append(self)

    monkeypatch.setattr(Newton, "__init__", remembered)
    found = sos.design_pid(plant, **asked).K
    assert any(newton.iterations for newton in made)
    assert not all(newton.iterative for newton in made if newton.iterations)
    assert_allclose(found, wanted, atol=1e-6 * abs(wanted).max())
