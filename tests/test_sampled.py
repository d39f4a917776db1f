"""Sampled-data control: against closed forms, simulation and control."""

import copy

import control
import numpy as np
import pytest
from flint import ctx
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm, solve_continuous_are

import sosbook as sos
from sosbook.book import thesis
from sosbook.exact.definite import exact
from sosbook.pendulum import Mip
from sosbook.pendulum.spread import polytope
from sosbook.plants.descriptor import descriptors
from sosbook.sampled import (
    c2d,
    certify_sampled,
    design_sampled_lqr,
    sampled_cost,
    sampled_loop,
)
from sosbook.sampled.balls import balls, middle
from sosbook.sampled.cells import gram_bound
from sosbook.sampled.discretize import SampleTiming, input_vertices
from sosbook.sampled.loops import SampledFamily
from sosbook.sampled.proof import by_balls
from sosbook.sampled.shapes import PlantShape
from tests.cases import campaign, examples
from tests.closed import analyse_loop

U = [[0, 1]]  # phi is integrated
CART = sos.SecondOrderSystem([[1]], [[0]], [[0]], B=[[1]])
ROBUST = [[15.78, 0.49, 1.42, 0.69, 0.22]]


def lag(pole, gain=1.0):
    """x' = pole x + gain u."""
    return sos.DescriptorSystem([[1]], [[pole]], [[gain]])


def random_plant(seed, n=2, m=1):
    rng = np.random.default_rng(seed)
    half = rng.normal(size=(n, n))
    return sos.SecondOrderSystem(
        half @ half.T + np.eye(n),
        rng.normal(size=(n, n)),
        rng.normal(size=(n, n)),
        rng.normal(size=(n, m)) + np.eye(n, m),
    )


def piecewise(d, x, inputs, times, weight=None):
    """x at the end of inputs that are constant between the times.

    With a weight also the integral of x'Qx + u'Ru, by Gauss's rule on
    short pieces: not Van Loan's way.
    """
    A, B, _ = d.state_space()
    N, m = B.shape
    M = np.block([[A, B], [np.zeros((m, N + m))]])
    nodes, parts = np.polynomial.legendre.leggauss(6)
    cost = 0.0
    for u, span in zip(inputs, np.diff(times)):
        xu = np.append(x, u)
        if weight is not None:
            pieces = 2
            for k in range(pieces):
                for node, part in zip(nodes, parts):
                    t = (k + (node + 1) / 2) * span / pieces
                    y = expm(M * t) @ xu
                    cost += part / 2 * span / pieces * (y @ weight @ y)
        x = (expm(M * span) @ xu)[:N]
    return x, cost


def simulate(plant, K, T, delay, x0, steps, weight=None, U=None):
    """u(k) = K x(k T), at the plant from k T + delay on: by pieces."""
    (d,) = descriptors(plant, U)
    x, cost, given = np.array(x0, float), 0.0, {}
    states = [x]
    for k in range(steps):
        given[k] = K @ x
        switches = [j * T + delay for j in range(k + 1)]
        times = [
            k * T,
            *(t for t in switches if k * T + 1e-9 < t < (k + 1) * T - 1e-9),
            (k + 1) * T,
        ]
        inputs = []
        for start in times[:-1]:
            acting = [j for j, t in enumerate(switches) if t <= start + 1e-9]
            inputs.append(given[max(acting)] if acting else np.zeros(len(K)))
        x, more = piecewise(d, x, inputs, times, weight)
        states.append(x)
        cost += more
    return np.array(states), cost


@pytest.mark.parametrize(
    "delay, old, new",
    [(0, 0, 1 - np.exp(-1)), (0.25, None, 1 - np.exp(-0.75)), (1, 1 - np.exp(-1), 0)],
)
def test_hold_of_a_lag_in_closed_form(delay, old, new):
    (step,) = c2d(lag(-1), 1.0, delay)
    assert step.dt == 1.0
    assert step.A[0, 0] == pytest.approx(np.exp(-1))
    assert step.B[0, 0] == pytest.approx(new, rel=1e-12, abs=1e-15)
    if delay:
        old = np.exp(-0.75) - np.exp(-1) if old is None else old
        assert step.A[0, 1] == pytest.approx(old)
        assert step.A[1].tolist() == [0, 0] and step.B[1, 0] == 1
    else:
        assert step.nstates == 1


def test_hold_without_delay_is_python_controls():
    for pole, plant in (
        (None, Mip.printed().plant()),
        (U, Mip.printed().plant()),
        (None, random_plant(3, n=3, m=2)),
    ):
        (d,) = descriptors(plant, pole)
        A, B, _ = d.state_space()
        same = control.sample_system(
            control.ss(A, B, np.eye(len(A)), 0 * B), 0.01, "zoh"
        )
        (ours,) = c2d(plant, 0.01, U=pole)
        assert ours.A == pytest.approx(same.A, rel=1e-12, abs=1e-14)
        assert ours.B == pytest.approx(same.B, rel=1e-12, abs=1e-14)


@pytest.mark.parametrize("delay", [0, 0.03, 0.1, 0.17, 0.3, 0.31])
def test_delayed_loop_is_what_a_simulation_by_pieces_says(delay):
    plant, T, steps = random_plant(1, m=2), 0.1, 12
    rng = np.random.default_rng(0)
    K, x0 = rng.normal(size=(2, 4)), rng.normal(size=4)
    states, _ = simulate(plant, K, T, delay, x0, steps)
    (F,) = sampled_loop(plant, K, T, delay)
    assert len(F) == 4 + 2 * int(np.ceil(round(delay / T, 6)))
    x = np.append(x0, np.zeros(len(F) - 4))
    for expected in states:
        assert x[:4] == pytest.approx(expected, rel=1e-9, abs=1e-9)
        x = F @ x


def test_older_inputs_come_newest_first():
    (step,) = c2d(CART, 1.0, 3.0)
    assert step.A[2:].tolist() == [[0, 0, 0, 0, 0], [0, 0, 1, 0, 0], [0, 0, 0, 1, 0]]
    assert step.A[:2, 2:] == pytest.approx(
        np.array([[0, 0, 0.5], [0, 0, 1]]), rel=1e-12
    )
    assert step.B[:, 0].tolist() == [0, 0, 1, 0, 0]


@pytest.mark.parametrize("delay", [0, 0.1, 0.2, 0.5])
def test_cost_is_the_integral_along_a_simulation(delay):
    T, K, x0 = 0.2, np.array([[-0.5, -1.0]]), [1.0, -0.4]
    Q, R = np.array([[2, 0.3], [0.3, 1]]), np.array([[0.5]])
    weight = np.block([[Q, np.zeros((2, 1))], [np.zeros((1, 2)), R]])
    states, cost = simulate(CART, K, T, delay, x0, 200, weight)
    assert abs(states[-1]).max() < 1e-5
    (ours,) = sampled_cost(CART, K, Q, R, T, delay, x0=x0)
    assert ours == pytest.approx(cost, rel=1e-8)


def test_cost_counts_the_older_inputs_until_they_have_acted():
    """Without feedback each of two old inputs pushes a stable lag."""
    plant, T, delay = lag(-1), 1.0, 1.25
    ours = sampled_cost(plant, [[0]], [[0]], [[3]], T, delay, x0=[0, 1, 2])
    assert ours == pytest.approx([3 * (1 * 1 + 4 * 0.25)])


def test_cost_of_an_unstable_loop_is_infinite():
    assert sampled_cost(CART, [[1, 0]], np.eye(2), [[1]], 0.1) == [np.inf]


def test_lqr_of_an_integrator_in_closed_form():
    """x' = u, Q = R = 1: X solves a scalar quadratic."""
    T = 0.7
    design = design_sampled_lqr(lag(0), [[1]], [[1]], T)
    q, n, r = T, T**2 / 2, T**3 / 3 + T

    def residual(x):
        return q - (x * T + n) ** 2 / (r + T**2 * x)

    assert residual(design.X[0, 0]) == pytest.approx(0, abs=1e-12)
    x = design.X[0, 0]
    assert design.K[0, 0] == pytest.approx(-(x * T + n) / (r + T**2 * x))
    assert design.radius == pytest.approx(1 + T * design.K[0, 0])


def test_short_samples_give_the_continuous_gain():
    for delay_per_T in (0, 1):
        errors = []
        for T in (1e-3, 1e-4):
            plant, Q, R = random_plant(5), np.eye(4), np.eye(1)
            A, B, _ = descriptors(plant)[0].state_space()
            K = -B.T @ solve_continuous_are(A, B, Q, R)
            found = design_sampled_lqr(plant, Q, R, T, delay_per_T * T)
            errors.append(abs(found.K[:, :4] - K).max() / abs(K).max())
        assert errors[0] < 1e-2
        assert errors[1] == pytest.approx(errors[0] / 10, rel=0.1)


@settings(max_examples=examples(6, 12), deadline=None, derandomize=True)
@given(
    seed=st.integers(0, 10**6),
    n=st.integers(1, 2),
    m=st.integers(1, 2),
    late=st.sampled_from([0, 0.4, 1, 1.7, 3]),
)
def test_no_other_gain_costs_less(seed, n, m, late):
    rng = np.random.default_rng(seed)
    plant, T = random_plant(seed, n, min(m, n)), float(rng.uniform(0.05, 0.5))
    T = round(T, 3)
    delay = round(late * T, 6)
    half = rng.normal(size=(2 * n, 2 * n))
    Q, R = half @ half.T + 0.1 * np.eye(2 * n), np.eye(plant.m)
    try:
        best = design_sampled_lqr(plant, Q, R, T, delay)
    except ValueError as error:  # no weight or sample mends this plant
        assert "can't be stabilised" in str(error)
        return
    assert best.radius < 1
    arguments = Q, R, T, delay
    (least,) = sampled_cost(plant, best.K, *arguments)
    assert least == pytest.approx(np.trace(best.X))
    for size in (1e-3, 1e-2, 0.1):
        change = size * abs(best.K).max() * rng.normal(size=best.K.shape)
        (cost,) = sampled_cost(plant, best.K + change, *arguments)
        assert cost >= least * (1 - 1e-9)
    x0 = rng.normal(size=len(best.X))
    (cost,) = sampled_cost(plant, best.K, *arguments, x0=x0)
    assert cost == pytest.approx(x0 @ best.X @ x0)


def test_sampled_pendulum_holds_where_the_continuous_gain_falls():
    """R = 1, one sample late: the continuous gain is too fast."""
    plant = Mip.printed().plant()
    A, B, _ = descriptors(plant, U)[0].state_space()
    K = -B.T @ solve_continuous_are(A, B, np.eye(5), np.eye(1))
    (F,) = sampled_loop(plant, K, 0.01, 0.01, U)
    assert abs(np.linalg.eigvals(F)).max() > 1
    design = design_sampled_lqr(plant, np.eye(5), np.eye(1), 0.01, 0.01, U)
    assert design.radius < 0.999
    assert abs(design.poles()[0]) == design.radius
    assert design.certify(rate=0.999).proven


@pytest.mark.parametrize(
    "change, text",
    [
        (dict(T=0), "T must be positive"),
        (dict(delay=-0.1), "delay must not be negative"),
        (dict(delay=np.nan), "delay must be a finite number"),
        (dict(delay=1e3), "more than 1000 samples"),
        (dict(plant=sos.Polytope([CART, CART])), "pick one plant"),
        (dict(Q=np.eye(3)), "Q has 3 rows, needs 2"),
        (dict(R=[[-1]]), "R must be positive definite"),
        (
            dict(
                plant=sos.SecondOrderSystem(
                    np.diag([1, 0]), np.eye(2), np.eye(2), np.eye(2)
                ),
                Q=np.eye(4),
                R=np.eye(2),
            ),
            "M is singular",
        ),
        (
            dict(
                plant=sos.SecondOrderSystem(
                    np.eye(2), np.zeros((2, 2)), -np.eye(2), [[1], [0]]
                ),
                Q=np.eye(4),
            ),
            "add an input",
        ),
        (
            dict(
                plant=sos.SecondOrderSystem([[1]], [[0]], [[1]], [[1]]), T=float(np.pi)
            ),
            "with another T it does",
        ),
        (dict(Q=np.zeros((2, 2))), "weight it"),
        (dict(plant=sos.DescriptorSystem(np.eye(2), -np.eye(2))), "no B"),
        (dict(plant=lag(1e3), Q=[[1]], T=10.0), "overflows"),
    ],
)
def test_what_cannot_be_is_said(change, text):
    arguments = dict(plant=CART, Q=np.eye(2), R=[[1]], T=0.1, delay=0.0)
    with pytest.raises(ValueError, match=text):
        design_sampled_lqr(**(arguments | change))


def test_a_gain_of_wrong_width_is_refused():
    with pytest.raises(ValueError, match="needs 2, or 3 with the older"):
        sampled_loop(CART, [[1, 1, 1, 1]], 0.1, 0.05)
    with pytest.raises(ValueError, match="x0 must have 2"):
        sampled_cost(CART, [[-1, -1]], np.eye(2), [[1]], 0.1, x0=[1])


def ratios(found, plant, K, T, delay, U=None, count=40, seed=0):
    """How much x'P x falls, at the most, in the loops of random plants of a proof.

    Each plant lies in some cell.
    """
    rng = np.random.default_rng(seed)
    shape = PlantShape.of(plant, input_vertices(plant, U))
    N, worst = shape.N, []
    for _ in range(count):
        if shape.axes:
            w = np.ones(1)
            for t in rng.random(shape.axes):
                w = np.kron(w, [1 - t, t])
        else:
            w = rng.dirichlet(np.ones(len(shape.order)))
        E, both = (np.array(x, float) for x in shape.mixed(exact(w)))
        plain = sos.DescriptorSystem(E, both[:, :N], both[:, N:])
        (F,) = sampled_loop(plain, K, T, delay)
        for corners, P in found.cells:
            share = np.linalg.lstsq(corners[:, shape.order].T, w, rcond=None)[0]
            if share.min() > -1e-9:
                P = np.tensordot(share, P, 1)
                break
        else:
            raise AssertionError("a plant lies in no cell")
        assert np.linalg.eigvalsh(P)[0] > 0
        worst.append(np.linalg.eigvals(np.linalg.solve(P, F.T @ P @ F)).real.max())
    return np.sqrt(max(worst))


@pytest.mark.parametrize("delay", [0.004, *campaign([0, 0.01])])
def test_pendulum_polytope_is_proven_and_its_lyapunov_functions_hold(delay):
    family = polytope(Mip.printed())
    found = certify_sampled(family, ROBUST, 0.01, delay, U)
    assert found.proven, found
    late = f"a delay of {float(delay)} s" if delay else "no delay"
    loop = "the sampled loop of every constant plant of the polytope"
    assert found.claims == (f"{loop}, with a tick every 0.01 s and {late}, is stable",)
    assert ratios(found, family, found.K, 0.01, delay, U) < 1


def test_a_wide_family_needs_several_cells_and_keeps_its_rate():
    light, heavy = (
        sos.SecondOrderSystem([[M]], [[0.1]], [[-1]], [[1]]) for M in (0.5, 5)
    )
    family = sos.Polytope([light, heavy])
    found = certify_sampled(family, [[-4, -3]], 0.2, 0.05, rate=0.97)
    assert found.proven and len(found.cells) > 1
    assert found.claims[0].endswith("decays at least as 0.97^k")
    assert ratios(found, family, [[-4, -3]], 0.2, 0.05) < 0.97
    few = certify_sampled(family, [[-4, -3]], 0.2, 0.05, rate=0.97, cells=1)
    assert not few.proven and "undecided" in few.failed[0]


def test_a_lyapunov_matrix_of_a_file_is_symmetric():
    """A factorization reads one of its triangles alone."""
    family = sos.Polytope(
        [sos.SecondOrderSystem([[M]], [[0]], [[0]], [[1]]) for M in (1, 4)]
    )
    found = by_balls(family, [[-1, -1.5]], 0.3, 0.1)
    assert found.proven
    data = copy.deepcopy(found.data)
    P = data["cells"]["P"][0]
    P[0][1] = repr(float(P[0][1]) * (1 + 1e-13))
    bad = type(found).of(data)
    assert not bad.proven and "P isn't symmetric" in bad.failed[0]


@pytest.mark.parametrize("cells", [True, 0, 1.5, "4"])
def test_cells_are_a_number(cells):
    with pytest.raises(ValueError, match="cells must be 1, 2"):
        certify_sampled(CART, [[-1, -1.5]], 0.2, cells=cells)


@pytest.mark.parametrize(
    "damping, stiffness, gain",
    [(0.02, (1, 50), -1.4), (0.2, (2, 40), -1.4), (0.2, (4, 40), 0.4)],
)
def test_an_unstable_plant_between_stable_vertices_is_found(damping, stiffness, gain):
    """The samples alias the spring's motion: the vertices tell nothing."""
    family = sos.Polytope(
        [sos.SecondOrderSystem([[1]], [[damping]], [[S]], [[1]]) for S in stiffness]
    )
    loops = sampled_loop(family, [[0, gain]], 1.0)
    assert max(abs(np.linalg.eigvals(F)).max() for F in loops) < 1
    between = [
        sampled_loop(family.at([1 - t, t]), [[0, gain]], 1.0)[0]
        for t in np.linspace(0, 1, 41)
    ]
    assert max(abs(np.linalg.eigvals(F)).max() for F in between) > 1
    found = certify_sampled(family, [[0, gain]], 1.0)
    assert not found.proven and found.claims == found.cells == ()


def test_a_family_with_squares_is_cut_until_its_vertices_are_stable():
    """In one piece a vertex is unstable that is no plant."""
    plants = sos.Uncertain(
        lambda v: sos.SecondOrderSystem(1, 0.5 + 4 * (v - 0.4) ** 2, 2, 1), v=(0, 1)
    )
    (K, T), whole = ([[0, -0.001]], 0.01), sos.Polytope(plants.vertices)
    assert not certify_sampled(whole, K, T)
    found = certify_sampled(plants, K, T)
    assert found.proven and "constant plant with v in [0, 1], with" in found.claims[0]
    assert not certify_sampled(plants, [[0, 0.6]], T)  # at v = 0.4 it isn't stable


def family_of(plant, K, T, delay):
    timing, vertices = SampleTiming.of(T, delay), input_vertices(plant, None)
    return SampledFamily.of(plant, vertices, timing, np.asarray(K, float))


@settings(max_examples=8, deadline=None, derandomize=True)
@given(seed=st.integers(0, 10**6), late=st.sampled_from([0, 0.5, 1.5]))
def test_no_loop_of_a_cell_is_further_from_the_mixtures_than_bounded(seed, late):
    rng = np.random.default_rng(seed)
    nominal = random_plant(seed, m=2)
    plant = sos.Polytope(
        [
            sos.SecondOrderSystem(
                *(
                    x * (1 + 0.1 * rng.uniform(-1, 1, x.shape))
                    for x in (nominal.M, nominal.D, nominal.S, nominal.B)
                )
            )
            for _ in range(3)
        ]
    )
    T, K = 0.4, rng.normal(size=(2, 4))
    loops = sampled_loop(plant, K, T, late * T)
    L = np.eye(len(loops[0])) + 0.3 * rng.normal(size=loops[0].shape)
    clock = SampleTiming.of(T, late * T)
    with ctx.workprec(128):
        family = family_of(plant, K, T, late * T)
        gram = middle(gram_bound(family.bends(exact(np.eye(3)), 2, balls(L), clock)))
    found = []
    for w in [np.full(3, 1 / 3), *rng.dirichlet(np.ones(3), 20)]:
        (F,) = sampled_loop(plant.at(w / w.sum()), K, T, late * T)
        flat = sum(share * each for share, each in zip(w, loops))
        off = L @ (F - flat) @ np.linalg.inv(L)
        found.append(np.linalg.norm(off, 2))
        assert np.linalg.eigvalsh(gram - off.T @ off)[0] > -1e-12 * np.trace(gram)
    assert max(found) > 0


def test_the_bound_is_tight_on_a_short_segment():
    """An eighth of the second derivative, for x' = a x: T^2 e^(a T)."""
    a, width, T = -0.5, 1e-3, 2.0
    plant = sos.DescriptorSystem([[1]], [[[a - width / 2]], [[a + width / 2]]], [[1]])
    with ctx.workprec(128):
        family, corners = family_of(plant, [[0]], T, 0.0), exact(np.eye(2))
        bends = family.bends(corners, 1, balls(np.eye(1)), SampleTiming.of(T, 0))
        square = float(gram_bound(bends)[0, 0])
    expected = width**2 * T**2 * np.exp(a * T) / 8
    assert expected**2 <= square == pytest.approx(expected**2, rel=2e-2)


def test_the_proof_refuses_an_unstable_loop_and_a_marginal_one():
    plant = Mip.printed().plant()
    found = certify_sampled(plant, thesis.mip().pid[1], 0.01, 0.01, U)
    assert not found.proven and "spectral radius" in str(found)
    # z'' = u, z' fed back alone: the displacement stays where it is
    assert not certify_sampled(CART, [[0, -1]], 0.1).proven


def test_the_proof_is_about_the_printed_digits():
    found = certify_sampled(CART, [[-1.23456789, -1.5]], 0.1, digits=3)
    assert found.proven
    assert found.K.tolist() == [[-1.23, -1.5]]


@settings(max_examples=examples(8, 15), deadline=None, derandomize=True)
@given(seed=st.integers(0, 10**6), late=st.sampled_from([0, 0.5, 1, 1.3]))
def test_random_sampled_lqr_is_proven_and_half_its_margin_too(seed, late):
    rng = np.random.default_rng(seed)
    T = round(float(rng.uniform(0.02, 0.2)), 3)
    try:
        design = design_sampled_lqr(
            random_plant(seed), np.eye(4), [[1]], T, round(late * T, 6)
        )
    except ValueError as error:
        assert "can't be stabilised" in str(error)
        return
    halfway = (1 + design.radius) / 2
    assert design.certify(rate=halfway, digits=12).proven
    assert not design.certify(rate=design.radius - 1e-6, digits=12).proven


def lead_lag():
    """A sampled controller with a state, which mends a gain's loop."""
    return control.ss([[0.5]], [[0.2, 0.1]], [[-0.4]], [[-1.0, -1.2]], 0.1)


@pytest.mark.parametrize("delay", [0.0, 0.04, 0.1, 0.17])
def test_a_loop_with_a_controller_is_python_controls(delay):
    cart = sos.SecondOrderSystem([[1]], [[0.1]], [[-0.5]], B=[[1]])
    (held,) = c2d(cart, 0.1, delay)
    state = control.ss(held.A, held.B, np.eye(2, held.nstates), np.zeros((2, 1)), 0.1)
    closed = control.feedback(control.series(state, lead_lag()), 1, sign=1)
    (F,) = sampled_loop(cart, lead_lag(), 0.1, delay)
    ours, theirs = (np.sort_complex(np.linalg.eigvals(x)) for x in (F, closed.A))
    assert np.allclose(ours, theirs, atol=1e-7)


def test_a_controller_without_states_is_a_gain():
    cart = sos.SecondOrderSystem([[1]], [[0.1]], [[-0.5]], B=[[1]])
    K = [[-1.0, -1.2]]
    static = control.ss([], [], [], K, 0.1)
    for delay in (0.0, 0.15):
        both = [sampled_loop(cart, law, 0.1, delay)[0] for law in (K, static)]
        assert np.array_equal(*both)
        proofs = [certify_sampled(cart, law, 0.1, delay) for law in (K, static)]
        assert proofs[0].proven and proofs[0].blocks == proofs[1].blocks


def test_a_polytope_with_a_controller_is_proven_or_refused():
    carts = sos.Polytope(
        [sos.SecondOrderSystem([[M]], [[0.1]], [[-0.5]], [[1]]) for M in (0.8, 1.5)]
    )
    assert certify_sampled(carts, lead_lag(), 0.1, 0.05).proven
    late = certify_sampled(carts, lead_lag(), 0.1, 1.0)
    worst = max(
        abs(np.linalg.eigvals(F)).max()
        for F in sampled_loop(carts, lead_lag(), 0.1, 1.0)
    )
    assert worst > 1 and not late.proven and "radius" in late.failed[0]


@pytest.mark.parametrize(
    "controller",
    [
        control.ss([[0.5]], [[0.2]], [[1]], [[0]], 0.1),
        control.ss([[0.5]], [[1, 1]], [[1]], [[0, 0]], 0.2),
        control.ss([[0.5]], [[1, 1]], [[1]], [[0, 0]], 0.1 * (1 + 1e-6)),
        control.ss([[0.5]], [[1, 1]], [[1]], [[0, 0]], float(np.nextafter(0.1, 1))),
    ],
)
def test_a_controller_of_another_kind_is_named(controller):
    cart = sos.SecondOrderSystem([[1]], [[0.1]], [[-0.5]], B=[[1]])
    with pytest.raises(ValueError, match="K must be a controller"):
        sampled_loop(cart, controller, 0.1)


def test_a_controller_of_continuous_time_needs_names():
    cart = sos.SecondOrderSystem([[1]], [[0.1]], [[-0.5]], B=[[1]])
    with pytest.raises(ValueError, match="name what each input measures, of z1, z1'"):
        sampled_loop(cart, control.ss([[-1]], [[1, 1]], [[1]], [[0, 0]]), 0.1)


def test_a_rate_above_one_promises_nothing_and_is_refused():
    cart = sos.SecondOrderSystem([[1]], [[0]], [[0]], [[1]])
    with pytest.raises(ValueError, match="rate must be at most 1"):
        certify_sampled(cart, [[0.5, 0]], 0.2, rate=3)


def test_a_mass_that_vanishes_inside_is_said():
    plants = sos.Polytope(
        [
            sos.SecondOrderSystem([[1]], [[2]], [[1]], [[1]]),
            sos.SecondOrderSystem([[-1]], [[-3]], [[-1]], [[1]]),
        ]
    )
    proof = certify_sampled(plants, [[0, 0]], 0.2)
    assert not proof.proven and "no regular mass" in proof.failed[0]


@pytest.mark.filterwarnings("error")
def test_a_cell_too_wide_for_floats_is_undecided():
    """A cart's pendulum with ranges of mass and length: m L^2 has six vertices."""

    def cart(m, L):
        return sos.SecondOrderSystem(
            [[2 + m, m * L], [m * L, m * L * L]], [[0.1, 0], [0, 0.01]],
            [[0, 0], [0, -9.81 * m * L]], [[1], [0]],
        )  # fmt: skip

    family = sos.Uncertain(cart, m=(0.25, 0.35), L=(0.45, 0.55))
    law = sos.PIDLaw(position=np.eye(2), filter=0.03)
    design = sos.design_pid(family, law=law, region=sos.PoleRegion(sigma=0.5))
    proof = design.controller(T=0.01, delay=0.01).certify(cells=2)
    assert not proof.proven
    assert "undecided" in str(proof)


def test_one_plant_written_twice_is_proven():
    twice = sos.Polytope(
        [sos.SecondOrderSystem([[s]], [[0]], [[0]], [[s]]) for s in (1, 4)]
    )
    assert certify_sampled(twice, [[-1, -1.5]], 0.5).proven


def test_a_static_controller_needs_no_clock():
    cart = sos.SecondOrderSystem([[1]], [[0.1]], [[-0.5]], B=[[1]])
    timeless = control.ss([], [], [], [[-1.0, -1.2]], None)
    assert np.array_equal(
        sampled_loop(cart, timeless, 0.1)[0], sampled_loop(cart, [[-1.0, -1.2]], 0.1)[0]
    )


@pytest.mark.parametrize("k", range(1, 8))
def test_a_delay_of_whole_samples_makes_no_more_registers(k):
    """3 * 0.1 isn't 0.3 in floats, and is three samples all the same."""
    cart = sos.SecondOrderSystem([[1]], [[0]], [[0]], B=[[1]])
    for late in (k * 0.1, np.nextafter(k * 0.1, 9), k * 0.1 * (1 - 1e-11)):
        (step,) = c2d(cart, 0.1, late)
        assert step.nstates == 2 + k
        assert np.array_equal(step.A, c2d(cart, 0.1, k / 10)[0].A)
    (step,) = c2d(cart, 0.1, k * 0.1 + 1e-8)
    assert step.nstates == 2 + k + 1


@pytest.mark.parametrize("m", [3, 5, *campaign([4])])
def test_more_inputs_than_states(m):
    """Two states and no delay: there are no older inputs to be shifted."""
    B = np.arange(1.0, m + 1)[None]
    many = sos.SecondOrderSystem([[2]], [[0.3]], [[1]], B)
    A, held = SampleTiming.of(0.1, 0).held(input_vertices(many, None)[0])
    one = sos.SecondOrderSystem([[2]], [[0.3]], [[1]], [[1]])
    A_one, held_one = SampleTiming.of(0.1, 0).held(input_vertices(one, None)[0])
    np.testing.assert_allclose(A, A_one)
    np.testing.assert_allclose(held, held_one @ B)
    design = design_sampled_lqr(many, np.eye(2), np.eye(m), 0.1)
    assert design.radius < 1 and design.certify().proven


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("rate", [1e-4, 1.0, 1e4])
def test_a_cost_in_any_unit_of_time_is_the_same_and_silent(rate):
    """A free mass, in other units of time: scipy's solver warned of them."""
    mass = sos.SecondOrderSystem([[3 / rate**2]], [[0]], [[0]], [[1]])
    Q, x0 = np.diag([1.0, 1 / rate**2]), [1.0, rate]
    T = 0.3 / rate
    design = design_sampled_lqr(mass, Q, [[1]], T, T)
    wanted = design_sampled_lqr(
        sos.SecondOrderSystem([[3]], [[0]], [[0]], [[1]]), np.eye(2), [[1]], 0.3, 0.3
    )
    np.testing.assert_allclose(design.radius, wanted.radius)
    cost = sampled_cost(mass, design.K, Q, [[1]], T, T, x0=x0)
    in_seconds = sampled_cost(
        wanted.plant, wanted.K, np.eye(2), [[1]], 0.3, 0.3, x0=[1, 1]
    )
    np.testing.assert_allclose(cost * rate, in_seconds)
    assert design.certify().proven


def test_matrices_of_samples_lie_in_a_disk():
    """Eigenvalues of F lie around 0 where those of F - I lie around -1."""
    F = np.array([[0.5, 1.0], [0.0, 0.25]])
    for rate, status in ((0.5001, "feasible"), (0.5, "infeasible")):
        region = sos.LMIRegion.disk(rate, -1)
        loop = analyse_loop(np.eye(2), F - np.eye(2), region=region)
        proof = loop.certify() if status == "feasible" else loop.infeasibility
        assert loop.status == status and proof.verify()
