"""Theorem 2.5 and the loop with an observer, against filters and roots."""

import numpy as np
import pytest
from scipy.linalg import solve_continuous_are

import sosbook as sos
from sosbook import design_observer, observer_loop
from sosbook.lmi import Unknown
from sosbook.lmi.solution import LMISolution
from sosbook.pendulum import Mip, reduced
from sosbook.plants.descriptor import descriptors, mean_descriptor
from sosbook.solver.loop import Unbounded
from sosbook.synthesis import observer
from sosbook.synthesis.error_loop import error_loop, observed
from tests.cases import seeds
from tests.closed import analyse_loop

MIP = Mip.printed()
C = np.array([[0, 1, 0], [0, 0, 1]])
NOISE = np.sqrt(np.diag([0.01, 0.1]))


def weights(plant):
    d = mean_descriptor(plant.vertices)
    push = 2 * np.linalg.solve(d.E, d.Bu)
    return np.vstack([push, 0 * push])


def feedback(plant, R):
    d = plant.vertices[0]
    one = sos.DescriptorSystem(d.E, d.A, d.Bu)
    return sos.design_lqr(one, np.eye(3), [[R]]).K


@pytest.fixture(scope="module")
def designs():
    plant = reduced(MIP)
    return {
        R: design_observer(plant, feedback(plant, R), weights(plant), NOISE)
        for R in (1, 2)
    }


@pytest.mark.parametrize("R", [1, 2])
def test_table_4_3(designs, R):
    """K is one vertex's LQR; L is Theorem 2.5's with the weights swapped."""
    printed = {
        1: (
            [34.6136, 3.6216, 1.2728],
            [[-1.9, -0.5], [-1259.9, 197.5], [1975.4, -332.0]],
        ),
        2: (
            [26.3376, 2.6619, 0.9914],
            [[-1.8, -0.4], [-1258.0, 197.6], [1976.3, -330.2]],
        ),
    }[R]
    assert np.allclose(designs[R].K, [printed[0]], rtol=2e-4)
    assert np.allclose(designs[R].L[1:], printed[1][1:], rtol=1e-3)
    assert np.allclose(designs[R].L[0], printed[1][0], atol=0.11)


@pytest.mark.parametrize("R", [1, 2])
def test_the_vertices_are_proven_exactly(designs, R):
    assert designs[R].status == "feasible"
    proof = designs[R].certify()
    assert proof.proven and not proof.failed
    assert proof.claims[0].startswith("at each vertex (not between them)")
    assert set(proof.blocks) >= {"P1", "P2", "decay 4", "cost 4", "trace"}


@pytest.mark.parametrize("R", [1, 2])
def test_the_whole_polytope_is_proven_with_K_and_L_fixed(designs, R):
    found = designs[R]
    claim = "every constant or changing plant of the polytope, under u = K x, is stable"
    assert found.analyse().certify().claims == (claim,)
    loop = observer_loop(found.plant, found.K, found.L, found.C)
    rng = np.random.default_rng(0)
    for weight in rng.dirichlet(np.ones(4), 50):
        E = sum(w * d.E for w, d in zip(weight, loop.vertices))
        A = sum(w * d.A for w, d in zip(weight, loop.vertices))
        assert np.linalg.eigvals(np.linalg.solve(E, A)).real.max() < 0


def test_one_plant_keeps_the_separation():
    """Without uncertainty the loop's poles are those of A + BK, A + LC."""
    plant = reduced(MIP, 0.0)
    d = plant.vertices[0]
    K, L = feedback(plant, 1), np.array([[-1, -1], [-90, 8], [30, -40]])
    A, B, _ = d.state_space()
    wanted = np.concatenate(
        [np.linalg.eigvals(A + B @ K), np.linalg.eigvals(A + L @ C)]
    )
    v = observer_loop(plant, K, L, C).vertices[0]
    found = np.linalg.eigvals(np.linalg.solve(v.E, v.A))
    assert np.allclose(np.sort_complex(found), np.sort_complex(wanted), rtol=1e-6)


def softened(v, m):
    """Its damping comes in squares: a vertex of the hull has less than none."""
    return sos.SecondOrderSystem([[m]], [[0.5 + 4 * (v - 0.4) ** 2]], [[2 * m]], 1)


def test_the_loop_of_a_family_is_one_of_the_same_parameters():
    plants, K, L = (
        sos.Uncertain(softened, v=(0, 1), m=(0.5, 1)),
        [[0, -1]],
        [[-2], [-1]],
    )
    assert min(plants.vertices, key=lambda p: p.D).D < 0
    loop, C = observer_loop(plants, K, L, [[1, 0]]), np.array([[1, 0]])
    mean, true = mean_descriptor(descriptors(plants.polytope())), []
    for v in np.linspace(0, 1, 41):
        for m in (0.5, 0.7, 1):
            (d,) = descriptors(plants.at(v=v, m=m))
            (found,) = loop.family.at(v=v, m=m).vertices
            E, A = error_loop(d, mean, np.array(K))
            A[:2, :2] += mean.E @ L @ C
            assert np.allclose(found.E, E) and np.allclose(found.A, A)
            true.append(-np.linalg.eigvals(np.linalg.solve(E, A)).real.max())
    system, gain = observed(plants, K, L, C)
    kept, broken = (
        sos.analyse_pid(system, gain, region=sos.PoleRegion(share * min(true)))
        for share in (0.97, 1.01)
    )
    assert kept.certify().claims[0].startswith("every constant plant with v in")
    assert broken.infeasibility.proven and "The plant with v = " in broken.reason


@pytest.mark.parametrize("by_lmis, near", [(False, 1e-9), (True, 1e-3)])
def test_one_plant_gives_the_kalman_filter(by_lmis, near, monkeypatch):
    """By the filter's equation, or near it where the LMIs search by themselves."""
    if by_lmis:
        monkeypatch.setattr(observer, "riccati_observer", lambda *a: None)
    plant = reduced(MIP, 0.0)
    d = plant.vertices[0]
    single = sos.DescriptorSystem(d.E, d.A, d.Bu, d.Bw, C)
    A = d.state_space()[0]
    half = np.diag([0.3, 5.0, 4.0])
    Q_F = np.vstack([half, 0 * half])
    design = design_observer(single, feedback(plant, 1), Q_F, NOISE)
    X = solve_continuous_are(A.T, C.T, half @ half.T, NOISE @ NOISE.T)
    kalman = -np.linalg.solve(NOISE @ NOISE.T, C @ X).T
    assert np.allclose(design.L, kalman, rtol=near, atol=near)
    assert design.status == "feasible" and design.certify().proven


def test_the_controller_has_the_printed_poles(designs):
    """(4.28): s = -1694, -10.45, -5.039, from rounded gains."""
    found = np.sort(designs[2].controller().poles().real)
    assert np.allclose(found, [-1694, -10.45, -5.039], rtol=1e-2)


def test_bad_input_is_named():
    plant = reduced(MIP)
    K, Q_F = feedback(plant, 1), weights(plant)
    with pytest.raises(ValueError, match="K has 2 columns, needs 3"):
        design_observer(plant, K[:, :2], Q_F, NOISE)
    with pytest.raises(ValueError, match="Q_F has 3 rows, needs 6"):
        design_observer(plant, K, Q_F[:3], NOISE)
    with pytest.raises(ValueError, match="R_F has 1 rows, needs 2"):
        design_observer(plant, K, Q_F, [[1]])
    for none in (np.zeros((3, 0)), np.zeros((3, 1))):
        with pytest.raises(ValueError, match="B_w is zero or .*: leave it out"):
            design_observer(plant, K, Q_F, NOISE, B_w=none)
    unseen = sos.DescriptorSystem(np.eye(2), [[0, 1], [-2, -3]], [[0], [1]])
    with pytest.raises(ValueError, match="C is missing"):
        design_observer(unseen, [[0, 0]], np.eye(4), [[1]])


@pytest.mark.parametrize("seed", seeds(4))
def test_the_gain_of_one_plant_needs_no_word_on_the_noise_of_the_cost(seed):
    """L is Kalman's for any B_w; without one tr J bounds the error's variances."""
    rng = np.random.default_rng(seed)
    E = np.eye(3) + 0.3 * rng.standard_normal((3, 3))
    A, B = rng.standard_normal((3, 3)), rng.standard_normal((3, 1))
    C, half = rng.standard_normal((2, 3)), rng.standard_normal((3, 3))
    quiet = sos.DescriptorSystem(E, A, B, C=C)
    K = sos.design_lqr(quiet, np.eye(3), [[1]]).K
    asked = quiet, K, np.vstack([half, 0 * half]), NOISE
    design = design_observer(*asked)
    assert design.status == "feasible" and design.certify().proven
    R = NOISE @ NOISE.T
    X = solve_continuous_are(np.linalg.solve(E, A).T, C.T, half @ half.T, R)
    assert np.allclose(design.L, -np.linalg.solve(R, C @ X).T, rtol=1e-6, atol=1e-6)
    assert design.bound == pytest.approx(np.trace(X), rel=2e-4)
    still = sos.DescriptorSystem(E, A, B, np.zeros((3, 1)), C)
    assert np.array_equal(design_observer(still, *asked[1:]).L, design.L)
    other = design_observer(*asked, B_w=rng.standard_normal((3, 2)))
    assert np.allclose(other.L, design.L, rtol=1e-6, atol=1e-6)


def test_a_polytope_without_disturbance_has_an_observer():
    plant = reduced(MIP)
    parts = [[getattr(d, x) for d in plant.vertices] for x in ("E", "A", "Bu")]
    quiet = sos.DescriptorSystem(*parts, C=C)
    design = design_observer(quiet, feedback(plant, 1), weights(plant), NOISE)
    assert design.status == "feasible" and design.certify().proven


def test_an_integral_is_a_state_that_is_measured():
    """What the message for a PID controller's gain advises, done."""
    ends = [sos.SecondOrderSystem(m, 0.1, 1, 1, 1) for m in (1, 1.3)]
    plant, U = sos.Polytope(ends), [[1]]
    K = sos.design_pid(plant, U, region=sos.PoleRegion(sigma=0.4)).K
    with pytest.raises(ValueError, match="K has 3 columns, needs 2: .* no integrators"):
        design_observer(plant, K, np.eye(4), [[1]])
    parts = descriptors(plant, U)
    with_integral = sos.DescriptorSystem(
        *([getattr(d, x) for d in parts] for x in ("E", "A", "Bu", "Bw")),
        C=[[1, 0, 0], [0, 0, 1]],
    )
    noise = np.vstack([np.diag([0.1, 1, 0.01]), np.zeros((3, 3))])
    design = design_observer(with_integral, K, noise, np.eye(2))
    assert design.status == "feasible"
    proof = design.analyse(coupling="slack").certify()
    assert proof.proven


def refused_observers():
    """Observers that aren't found, by what is said of them."""
    plant = reduced(Mip.printed(), 0.2)
    K = feedback(plant, 1)
    yield "in floats", design_observer(plant, K, weights(plant), NOISE)
    ends = [sos.SecondOrderSystem(1, 0.1, s, 1, 1) for s in (-5.0, 6.0)]
    Q_F = [[0], [1], [0], [0]]
    yield ("exactly", design_observer(sos.Polytope(ends), [[-1.0, -2.0]], Q_F, [[1.0]]))


def test_a_refusal_has_a_reason_and_advice():
    for kind, design in refused_observers():
        assert design.status == ("infeasible" if kind == "exactly" else "undecided")
        assert design.reason.endswith(".") and design.advice.endswith(".")
        assert design.advice != design.reason
        exact = design.status == "infeasible"
        assert ("Exact multipliers" in design.reason) == exact, design.reason
        assert design.reason in design._repr_html_().replace("&#x27;", "'")
        assert design.reason in str(design.certify())


@pytest.mark.parametrize("broken", ["bounded", "open"])
def test_a_search_that_finds_nothing_says_so(broken, monkeypatch):
    """Where floats end without a point and without multipliers, too."""

    class Empty:
        unknowns = (Unknown("J", 1),)

        def __init__(self, *given):
            pass

        def solve(self, start=None, refuse=True):
            return LMISolution(None, None)

        def minimize(self, *given):
            return LMISolution(None, None)

    monkeypatch.setattr(observer, "riccati_observer", lambda *a: None)
    monkeypatch.setattr(observer.ObserverProblem, broken, Empty)
    plant = sos.SecondOrderSystem(1, 1, 1, 1, 1)
    design = design_observer(plant, [[-1, -1]], np.eye(4), [[1]], C=[[1, 0]])
    assert design.status == "undecided" and design.L is None
    assert design.reason.startswith("The numerics found ")
    assert "exclude" not in design.reason or "neither" in design.reason


def test_a_gain_that_does_not_stabilise_is_refused():
    plant = reduced(Mip.printed())
    with pytest.raises(ValueError, match="K doesn't stabilise the mean"):
        design_observer(plant, np.zeros((1, 3)), weights(plant), NOISE)


def test_an_unseen_unstable_mode_is_refused():
    plant = sos.SecondOrderSystem(
        np.eye(2), np.zeros((2, 2)), np.diag([-1.0, -2]), np.eye(2), np.eye(2)
    )
    K = sos.design_lqr(plant, np.eye(4), np.eye(2)).K
    with pytest.raises(ValueError, match="C doesn't see an unstable mode"):
        design_observer(plant, K, np.eye(8), [[1]], C=[[1, 0, 0, 0]])
    with pytest.raises(ValueError, match="R_F must be regular"):
        design_observer(plant, K, np.eye(8), [[0]], C=[[1, 0, 0, 0]])


def test_a_loop_without_an_input_is_not_designed_but_analysed():
    loop = sos.DescriptorSystem(np.eye(2), [[0, 1], [-2, -3]])
    with pytest.raises(ValueError, match="nothing to design"):
        sos.design_pid(loop)
    with pytest.raises(ValueError, match="nothing to design"):
        sos.design_lqr(loop, np.eye(2), [[1]])
    assert analyse_loop(loop.E, loop.A).certify().proven


@pytest.mark.parametrize("error", [Unbounded, np.linalg.LinAlgError, ZeroDivisionError])
@pytest.mark.parametrize("place", ["__init__", "open"])
def test_numerics_that_give_up_leave_it_undecided(error, place, monkeypatch):
    """Seen where units lie far apart, or where no least cost is attained."""

    def given_up(*asked):
        raise error("no such minimum")

    monkeypatch.setattr(observer.ObserverProblem, place, given_up)
    monkeypatch.setattr(observer, "riccati_observer", lambda *asked: None)
    plant = sos.SecondOrderSystem(1, 1, 1, 1, 1)
    design = design_observer(plant, [[-1, -1]], np.eye(4), [[1]], C=[[1, 0]])
    assert design.status == "undecided" and "no such minimum" in design.reason
    assert design.advice == design.reason
