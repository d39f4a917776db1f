"""Loops with Jordan blocks: equal modules that push each other."""

import warnings

import numpy as np
import pytest
from scipy.linalg import solve_continuous_lyapunov

import sosbook as sos
from sosbook.synthesis import known_gain, known_lmis
from sosbook.synthesis.starting_points import of_modes
from tests.cases import by_turns, campaign


def row(n, c=0.3, k=9.81):
    """Equal masses, each pushed by the one before."""
    S = k * (np.eye(n) - np.eye(n, k=-1))
    return sos.SecondOrderSystem(
        np.eye(n), c * np.eye(n), S, np.eye(n, 1), np.eye(n, 1)
    )


def followers(n):
    """Each damps its distance to the one before, in odd units."""
    near = np.eye(n) - np.eye(n, k=-1)
    M, some = 0.3 * np.eye(n), np.eye(n, 1)
    return sos.SecondOrderSystem(M, 0.3 * near, 2.2046 * near, some, some)


def cascade(rates):
    """First-order lags, whose states have units far apart."""
    n = len(rates) + 1
    A, some = -2e3 * np.eye(n) + 2e3 * np.diag(rates, -1), np.eye(n, 1)
    return sos.DescriptorSystem(np.eye(n), A, some, some, C=np.eye(n)[-1:])


INTEGRATORS = sos.SecondOrderSystem(
    np.eye(2), np.zeros((2, 2)), [[0, 0], [-1, 0]], np.eye(2), np.eye(2)
)
LOOPS = {  # the first once a week
    "long row": (row(5), None),
    "two oscillators": (row(2, 0.2, 1.0), None),
    "row": (row(3), None),
    "followers": (followers(4), None),
    "lags": (cascade([1, 1, 1]), None),
    "lags in units": (cascade([1e3, 1e-4, 30]), None),
    "integrators": (INTEGRATORS, [[-1, 0, -2, 0], [0, -1, 0, -2]]),
}


@pytest.mark.parametrize("share", [1.05, *campaign([20])])
@pytest.mark.parametrize("name", by_turns(LOOPS, 1, of=4))
def test_norms_of_a_loop_with_a_jordan_block_are_proven(name, share):
    plant, K = LOOPS[name]
    single = isinstance(plant, sos.DescriptorSystem)
    (d,) = plant.vertices if single else sos.plants.descriptors(plant)
    K = np.zeros((plant.m, len(d.E))) if K is None else np.array(K, float)
    A, B = np.linalg.solve(d.E, d.A + d.Bu @ K), np.linalg.solve(d.E, d.Bw)
    rates = np.abs(np.linalg.eigvals(A))
    grid = [0, *np.geomspace(rates.min() / 30, rates.max() * 30, 3000), *rates]
    pencils = 1j * np.reshape(grid, (-1, 1, 1)) * np.eye(len(A)) - A
    answers = d.C @ np.linalg.solve(pencils, B + 0j)
    norm = np.linalg.norm(answers, 2, axis=(1, 2)).max()
    X = solve_continuous_lyapunov(A, -B @ B.T)
    h2 = np.sqrt(np.trace(d.C @ X @ d.C.T))
    asked = dict(K=K, coupling="multipliers")
    for kind, true in ((sos.HInfinity, norm), (sos.H2, h2)):
        kept = kind(float(f"{share * true:.5g}"))
        found = sos.analyse_pid(plant, **asked, requirements=[kept])
        assert found.status == "feasible" and found.certify().proven
        broken = kind(float(f"{0.95 * true:.5g}"))
        found = sos.analyse_pid(plant, **asked, requirements=[broken])
        assert found.status == "infeasible" and found.infeasibility.proven


@pytest.mark.parametrize("apart", by_turns([0, 1e-12, 1e-9, 1e-7, 1e-3], 0))
def test_modes_that_are_nearly_one_are_no_harder(apart):
    n = 4
    M, S = np.diag(1 + apart * np.arange(n)), 1.1 * np.eye(n) - np.eye(n, k=-1)
    some = np.eye(n, 1)
    plant = sos.SecondOrderSystem(M, 0.2 * np.eye(n), S, some, some)
    asked = dict(gamma=1e5, coupling="multipliers")
    assert sos.analyse_pid(plant, np.zeros((1, 2 * n)), **asked).status == "feasible"


@pytest.mark.parametrize("n", [2, 3])
def test_one_matrix_keeps_the_regions_of_a_defective_loop(n):
    A = -np.eye(n) + 0.3 * np.eye(n, k=1)
    P = of_modes(A)
    assert np.linalg.eigvalsh(P)[0] > 0
    T = A @ P
    assert np.linalg.eigvalsh(T + T.T + 2 * 0.9 * P)[-1] < 0  # left of -0.9
    half = np.cos(np.pi / 4)  # and in a sector of 45 degrees
    sector = half * np.block([[T + T.T, T - T.T], [T.T - T, T + T.T]])
    assert np.linalg.eigvalsh(sector)[-1] < 0


def test_twenty_equal_pairs_move_no_mode_that_may_stay():
    k = np.diag(np.repeat(np.linspace(9.81, 490, 10), 2))
    push = np.kron(np.eye(10), [[0, 0], [0.3, 0]])
    D = 0.2 * np.eye(20) + 0.005 * k
    plant = sos.SecondOrderSystem(np.eye(20), D, k - push, np.eye(20))
    design = sos.design_pid(plant, region=sos.PoleRegion(sigma=0.05))
    assert design.status == "feasible" and not design.K.any()


def test_a_searched_gain_without_a_proof_is_shown(monkeypatch):
    plant, _ = LOOPS["two oscillators"]
    law = sos.PIDLaw(position=[[0, 1]], velocity=[[0, 1]])
    asked = dict(law=law, gamma=20.0, search=sos.Search(starts=1))
    assert sos.design_pid(plant, **asked).status == "feasible"
    monkeypatch.setattr(known_gain, "_found", lambda lmis: None)
    design = sos.design_pid(plant, **asked)
    assert design.status == "undecided" and not design.certify().proven
    assert set(design.gains) == {"K_P", "K_D"} and design.hinf() < 20
    assert f"true value {design.hinf():.4g}"[:-1] in design.reason


@pytest.mark.parametrize("size", [1e60, 1e99])
def test_sizes_of_far_entries_are_near_one_and_warn_of_nothing(size, monkeypatch):
    """scipy casts them to whole numbers; where no float holds them they are ones."""
    A = np.array([[-1, size], [0, -1]])
    vectors = np.linalg.eig(A)[1]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = known_lmis._sizes(A, vectors)
    assert 0.1 < abs(A * found / found[:, None]).max() < 10
    for lost in ([np.inf, 1.0], [1.0, 0.0], [np.nan, 1.0]):
        answer = A, (np.array(lost), None)
        monkeypatch.setattr(known_lmis, "matrix_balance", lambda *_, **__: answer)
        assert (known_lmis._sizes(A, vectors) == 1).all()
