"""Margins at the plant's input, and the bound that P gives of u."""

import re

import control
import numpy as np
import pytest

import sosbook as sos
from sosbook.analysis.linear import loop_matrix
from sosbook.analysis.margins import DiskMargin, disk_margin, sensitivity_peak
from sosbook.book import thesis
from sosbook.plants.descriptor import descriptors
from tests.cases import crossed, random_plant, seeds
from tests.closed import analyse_loop

ROBOT = thesis.example_1()
FREQUENCIES = np.concatenate([[0], np.geomspace(1e-3, 1e4, 40001)])


@pytest.fixture(params=["robot", 0, 1, 2, 3, 4, 5])
def loop(request):
    """A vertex and a gain."""
    if request.param == "robot":
        asked = dict(region=ROBOT.region, saturation=ROBOT.saturation)
        design = sos.design_pid(ROBOT.plant, ROBOT.U, **asked)
    else:
        rng = np.random.default_rng(request.param)
        plant = random_plant(rng, 1 + request.param % 3, 1 + request.param % 2)
        design = sos.design_pid(plant)
        if design.status != "feasible":
            pytest.skip("u doesn't reach every mode")
    return design.request.vertices[0], design.K


def sensitivity(d, K, w):
    L = -K @ np.linalg.solve(1j * w * d.E - d.A, d.Bu)
    return np.linalg.inv(np.eye(len(K)) + L)


def test_a_disk_margin_shows_factors_and_degrees_that_the_loop_bears():
    """A pendulum upside down, by its eigenvalues."""
    plant, K = sos.SecondOrderSystem(0.3, 0.2, -9.81, 1), np.array([[-12.0, -1.1]])
    (d,) = descriptors(plant)
    shown = repr(disk_margin(d, K))
    low, high, turn = map(
        float, re.search(r"(\S+) to (\S+) t.* (\S+) d", shown).groups()
    )

    def stable(factor):
        A = np.linalg.solve(d.E, d.A + factor * d.Bu @ K + 0j)
        return np.linalg.eigvals(A).real.max() < 0

    assert all(map(stable, np.linspace(low * 1.01, high * 0.99, 99)))
    angles = np.radians(np.linspace(-turn, turn, 99) * 0.99)
    assert all(map(stable, np.exp(1j * angles)))
    assert 9.81 / 12 < low < 1 < high and 0 < turn < 180  # less doesn't hold it up
    assert "unstable" in repr(disk_margin(d, 0 * K))


def test_peaks_against_a_grid_of_frequencies(loop):
    d, K = loop
    S = np.array([sensitivity(d, K, w) for w in FREQUENCIES[1::20]])
    one = np.eye(len(K))
    seen = np.linalg.norm(S, 2, axis=(1, 2)).max()
    assert seen * (1 - 1e-6) < sensitivity_peak(d, K) < max(seen, 1) * 1.01
    skewed = np.linalg.norm(S - one / 2, 2, axis=(1, 2)).max()
    assert skewed * (1 - 1e-6) < 1 / disk_margin(d, K).radius < max(skewed, 0.5) * 1.01


def test_the_loop_bears_what_its_disk_margin_says(loop):
    d, K = loop
    margin = disk_margin(d, K)
    rng = np.random.default_rng(0)

    def stable(factors):
        A = np.linalg.solve(d.E, d.A + d.Bu @ np.diag(factors) @ K + 0j)
        return np.linalg.eigvals(A).real.max() < 0

    low, high = margin.gains
    assert low < 1 < high
    for _ in range(50):
        a = 0.99 * margin.radius * np.exp(2j * np.pi * rng.random(len(K)))
        assert stable((2 + a) / (2 - a))
        assert stable(rng.uniform(low, min(high, 100), len(K)))
    turn = 0.99 * margin.phase
    assert stable(np.exp(1j * turn) * np.ones(len(K)))


def test_a_margin_is_sharp_for_one_input():
    d, K = descriptors(sos.SecondOrderSystem(M=1, D=0, S=0, B=1))[0], [[-1.0, -1.0]]
    K = np.array(K)
    radius = disk_margin(d, K).radius
    angles = np.exp(1j * np.linspace(0, 2 * np.pi, 721))
    a = 1.001 * radius * angles
    worst = max(
        np.linalg.eigvals(
            np.linalg.solve(d.E, d.A + (2 + x) / (2 - x) * d.Bu @ K + 0j)
        ).real.max()
        for x in a
    )
    assert worst > 0
    assert sensitivity_peak(d, K) == pytest.approx(np.sqrt(4 / 3), rel=1e-6)


def test_an_unstable_loop_has_no_margin():
    d = descriptors(sos.SecondOrderSystem(M=1, D=0, S=-1, B=1))[0]
    K = np.zeros((1, 2))
    assert loop_matrix(d, K).shape == (2, 2)
    assert sensitivity_peak(d, K) == np.inf and disk_margin(d, K).radius == 0
    assert DiskMargin(0.0).gains == (1, 1) and DiskMargin(2.0).gains == (0, np.inf)


def test_a_design_knows_its_worst_margin():
    ends = [sos.SecondOrderSystem(1, 0.1, s, 1) for s in (1, 2)]
    design = sos.design_pid(sos.Polytope(ends), region=sos.PoleRegion(sigma=0.5))
    single = [sos.analyse_pid(v, design.K) for v in ends]
    assert design.sensitivity_peak() == max(x.sensitivity_peak() for x in single)
    assert design.disk_margin() == min(
        (x.disk_margin() for x in single), key=lambda m: m.radius
    )
    assert design.sensitivity_peak(samples=20) >= design.sensitivity_peak()


def doyles(q):
    """The observer's loop of Doyle (1978), with sigma = q."""
    plant = sos.DescriptorSystem(
        np.eye(2), [[1, 1], [0, 1]], [[0], [1]], [[1], [1]], [[1, 0]]
    )
    K = sos.design_lqr(plant, q * np.ones((2, 2)), [[1]]).K
    noise = np.sqrt(q) * np.array([[1], [1], [0], [0]])
    return sos.design_observer(plant, K, noise, [[1]])


@pytest.mark.parametrize("q", [5, 60, 3000])
def test_an_observer_may_leave_hardly_any_margin(q):
    """Doyle's closed forms, f = 2 + sqrt(4 + q): gain < 1 + 1 / f^2, S(0) = 1 + f^2."""
    design, f = doyles(q), 2 + np.sqrt(4 + q)
    assert design.K == pytest.approx(np.array([[-f, -f]]), rel=1e-6)
    assert design.L == pytest.approx(np.array([[-f], [-f]]), rel=1e-4)
    own = design.loop.design
    peak, margin = own.sensitivity_peak(), design.loop.margins()
    assert peak == pytest.approx(1 + f**2, rel=1e-3)
    low, high = 1 - (2 * f - 4) / (2 * f**2), 1 + 1 / f**2
    assert low < margin.gains[0] < 1 < margin.gains[1] < high * (1 + 1e-6)
    with_state = sos.analyse_pid(design.plant, design.K)
    assert with_state.sensitivity_peak() < 1 + 1e-6  # Kalman's inequality
    analysed = design.analyse()
    assert analysed.sensitivity_peak() == pytest.approx(peak, rel=1e-6)
    assert analysed.disk_margin().radius == pytest.approx(margin.radius, rel=1e-6)


def observed_loops(seed):
    """An `ObserverDesign`, and its loop gain -K(s) G(s) by python-control."""
    rng = np.random.default_rng(seed)
    n, m, q = 1 + seed % 3, 1 + seed % 2, 1 + seed % 2
    plant = random_plant(rng, n, m, 1, 1 + 2 * (seed % 2), 0.02)
    C = rng.standard_normal((q, 2 * n))
    vertices = descriptors(plant)
    K = sos.design_lqr(
        plant if len(vertices) == 1 else plant.mean, np.eye(2 * n), np.eye(m)
    ).K
    noise = np.vstack([np.eye(2 * n), np.zeros((2 * n, 2 * n))])
    design = sos.design_observer(plant, K, noise, np.eye(q), C=C)
    assert design.L is not None
    law = design.controller()
    loops = []
    for d in vertices:
        A, B, _ = d.state_space()
        loops.append(-control.series(control.ss(A, B, C, 0), law))
    return design, loops


@pytest.mark.parametrize("seed", seeds(6))
def test_margins_with_an_observer_are_those_of_the_composed_loop(seed):
    design, loops = observed_loops(seed)
    seen = skewed = 0.0
    for L in loops:
        values = np.moveaxis(L(1j * FREQUENCIES[::20], squeeze=False), -1, 0)
        one = np.eye(values.shape[1])
        S = np.linalg.inv(one + values)
        seen = max(seen, np.linalg.norm(S, 2, axis=(1, 2)).max())
        skewed = max(skewed, np.linalg.norm(S - one / 2, 2, axis=(1, 2)).max())
    own = design.loop.design
    peak, radius = own.sensitivity_peak(), design.loop.margins().radius
    if design.poles().real.max() >= 0:
        assert peak == np.inf and radius == 0
        return
    assert seen * (1 - 1e-6) < peak < max(seen, 1) * 1.01
    assert skewed * (1 - 1e-6) < 1 / radius < max(skewed, 0.5) * 1.01
    if len(loops) > 1:
        assert own.sensitivity_peak(samples=10, seed=1) >= peak
        assert own.disk_margin(samples=10).radius <= radius


def test_the_loop_with_an_observer_is_the_opened_one_closed():
    design, loops = observed_loops(1)
    whole = sos.observer_loop(design.plant, design.K, design.L, design.C)
    for open_, L, closed in zip(
        design.analyse().request.vertices, loops, whole.vertices, strict=True
    ):
        K = np.hstack([-design.K, design.K])
        assert open_.A + open_.Bu @ K == pytest.approx(closed.A, abs=1e-9)
        assert np.array_equal(open_.E, closed.E)
        poles = np.linalg.eigvals(np.linalg.solve(open_.E, closed.A))
        expected = control.feedback(L, np.eye(L.noutputs)).poles()
        assert np.sort_complex(poles) == pytest.approx(np.sort_complex(expected))


def test_a_loop_that_cannot_be_opened_has_no_margin():
    """Neither a sensitivity of zero nor a division by it."""
    closed = analyse_loop(np.eye(2), [[0, 1], [-2, -3]])
    for ask in (closed.sensitivity_peak, closed.disk_margin):
        with pytest.raises(ValueError, match="no input is left .* analyse_pid"):
            ask()
    idle = sos.analyse_pid(sos.SecondOrderSystem(1, 1, 1, 0), [[0, 0]])
    assert idle.sensitivity_peak() == 1 and idle.disk_margin().radius == 2


@pytest.mark.parametrize("coupling", ["pairs", "slack"])
def test_the_bound_of_the_input_holds(coupling):
    x0 = np.array([1.0, -2.0])
    ends = [sos.SecondOrderSystem(m, 0.1, 1, 1) for m in (1, 1.5)]
    design = sos.design_pid(
        sos.Polytope(ends),
        region=sos.PoleRegion(sigma=0.4, rho=8),
        saturation=sos.Saturation(30, x0),
        coupling=coupling,
    )
    bound = design.peak_bound()
    assert design.peak_input(samples=10) <= bound <= 30
    assert design.peak_bound(x0) == bound
    assert design.peak_bound(-3 * x0) == pytest.approx(3 * bound)
    plain = sos.design_pid(ends[0])
    if coupling == "pairs":
        K, P = plain.K, plain.P
        by_hand = np.sqrt((K @ P @ K.T).item() * (x0 @ np.linalg.solve(P, x0)))
        assert plain.peak_bound(x0) == pytest.approx(by_hand)
    with pytest.raises(ValueError, match="x0 is missing"):
        plain.peak_bound()
    with pytest.raises(ValueError, match="x0 must hold 2"):
        plain.peak_bound([1, 2, 3])


@pytest.mark.parametrize("coupling, mu", crossed(["pairs", "slack"], [0.3, None]))
def test_the_bound_of_the_input_holds_under_disturbances(coupling, mu):
    ends = [sos.SecondOrderSystem(m, 0.1, 1, 1, 1) for m in (1, 1.5)]
    design = sos.design_pid(
        sos.Polytope(ends),
        region=sos.PoleRegion(sigma=0.4, rho=8),
        gamma=sos.HInfinity(2.0, mu=mu),
        saturation=sos.Saturation(60, [0.5, 1]),
        coupling=coupling,
    )
    if coupling == "pairs":  # V' < mu w'w needs this very block
        (d, _), K, P = design.request.vertices, design.K, design.P
        loop = (d.A + d.Bu @ K) @ P @ d.E.T
        block = loop + loop.T + d.Bw @ d.Bw.T / design.mu
        assert np.linalg.eigvalsh(block)[-1] < 0
    t = np.linspace(0, 20, 4001)
    for w in (sos.Step(2.0, stop=1.5), sos.Sine(3, 1.2, stop=8), sos.Step(9, 1, 1.1)):
        energy = np.trapezoid(w(t)[0] ** 2, t)
        bound = design.peak_bound([0.5, 1], 1.01 * energy)
        for answer in design.simulate(t, w=w, x0=[0.5, 1]):
            assert np.abs(design.K @ answer.x).max() < bound
    assert design.peak_bound([0, 0], 1.0) > 0
    with pytest.raises(ValueError, match="energy must not be negative"):
        design.peak_bound([0, 0], -1.0)
    with pytest.raises(ValueError, match="only a design with gamma"):
        sos.design_pid(ends[0]).peak_bound([0, 0], 1.0)
