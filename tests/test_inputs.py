"""What callers may give, and what they are told when they may not."""

import warnings

import control
import numpy as np
import pytest
import scipy.sparse

import sosbook as sos
from sosbook.analysis.linear import hinf_norm
from sosbook.book import thesis
from sosbook.plants.second_order import MassWarning
from sosbook.requirements.hinf import HInfinity
from sosbook.studies import maps
from tests.cases import campaign

ONE = dict(M=2, D=0.1, S=3, B=1)
RECORDS = np.zeros(2, dtype=[("name", float)])


class Stubborn:
    """An object that makes no array of itself."""

    def __array__(self, dtype=None, copy=None):
        raise RuntimeError("no array for you")


class Table:
    """A table whose columns have names, as pandas makes them."""

    columns = ("load",)

    def __array__(self, dtype=None, copy=None):
        return np.array([[0.1]])


ROBOT = thesis.example_1()
DESIGN = sos.design_pid(ROBOT.plant, ROBOT.U, region=ROBOT.region)
LOOP = DESIGN.loop


def test_numbers_stand_for_one_degree_of_freedom():
    plant = sos.SecondOrderSystem(**ONE, F=1)
    same = sos.SecondOrderSystem([[2]], [[0.1]], [[3]], [[1]], [[1]])
    assert plant == same and hash(plant) == hash(same)
    asked = dict(region=sos.PoleRegion(sigma=0.5), gamma=2.0)
    by_number = sos.design_pid(plant, 1, **asked)
    by_matrix = sos.design_pid(same, [[1]], **asked)
    assert by_number.status == "feasible"
    assert np.array_equal(by_number.K, by_matrix.K)


@pytest.mark.parametrize(
    "kind",
    [
        scipy.sparse.csr_matrix,
        scipy.sparse.csc_array,
        scipy.sparse.dia_matrix,
        lambda x: np.asarray(x).tolist(),
        lambda x: np.asarray(x, np.float32).astype(object),
        lambda x: np.asarray(x).astype(np.int64),
    ],
)
def test_matrices_of_every_kind_give_one_design(kind):
    M, D, S, B = np.diag([10, 11]), [[4, 1], [1, 5]], [[8, 4], [-4, 9]], np.eye(2)
    plain = sos.SecondOrderSystem(M, D, S, B, B)
    other = sos.SecondOrderSystem(*map(kind, map(np.array, (M, D, S, B, B))))
    assert plain == other
    a = sos.design_pid(plain, np.eye(2), gamma=1.3)
    b = sos.design_pid(other, kind(np.eye(2)), gamma=np.float64(1.3))
    assert np.array_equal(a.K, b.K)


def test_a_sparse_acceleration_gain_is_taken():
    plant = ROBOT.plant
    K_A = 0.5 * np.eye(2)
    a = sos.design_pid(plant, ROBOT.U, K_A=K_A)
    b = sos.design_pid(plant, ROBOT.U, K_A=scipy.sparse.csr_matrix(K_A))
    assert np.array_equal(a.K, b.K) and np.array_equal(a.K_A, b.K_A)
    assert b.certify().proven


@pytest.mark.parametrize(
    "make, words",
    [
        (lambda: sos.SecondOrderSystem(**ONE | dict(B=[1, 0])), r"\[\[1, 0\]\] for"),
        (lambda: sos.SecondOrderSystem(**ONE | dict(B=[1, 0])), r"\[1\], \[0\]"),
        (lambda: sos.SecondOrderSystem(**ONE | dict(M=None)), "M is missing"),
        (lambda: sos.SecondOrderSystem(**ONE | dict(D="0.1")), "D .* holds text"),
        (lambda: sos.SecondOrderSystem(**ONE | dict(D=[["0.1"]])), "D .* holds text"),
        (lambda: sos.SecondOrderSystem(**ONE | dict(S=[[True]])), "S .* True or False"),
        (lambda: sos.SecondOrderSystem(**ONE | dict(S=[[10**400]])), "S must be a"),
        (
            lambda: sos.SecondOrderSystem([[True, 0], [0, 1]], *3 * [np.eye(2)]),
            "M .* True or False",
        ),
        (lambda: sos.SecondOrderSystem(**ONE | dict(S=Stubborn())), "S .* no array"),
        (lambda: sos.Saturation(1, [True, 0.5]), "x0 .* True or False"),
        (lambda: sos.Polytope(memoryview(np.eye(2))), "vertices must be a sequence"),
        (
            lambda: sos.admissible_U(ROBOT.plant, candidates=np.array(2.0)),
            "candidates must be a list of matrices U, got ndarray",
        ),
        (lambda: sos.design_pid(ROBOT.plant, coupling=RECORDS), "coupling must be"),
        (
            lambda: sos.QuadraticCost(np.eye(4), np.eye(2), noise=RECORDS),
            "noise must be",
        ),
        (
            lambda: sos.design_delay_pid(ROBOT.plant, tau=0.1, method=RECORDS),
            "method must be",
        ),
        (
            lambda: sos.regularize(sos.SecondOrderSystem(**ONE), choose=RECORDS),
            "choose must be",
        ),
        (lambda: sos.SecondOrderSystem(**ONE | dict(S=[[1j]])), "S .* complex"),
        (lambda: sos.SecondOrderSystem(2, np.eye(2), np.eye(2), np.eye(2)), "M must"),
        (lambda: sos.SecondOrderSystem([[1, 2], [3]], 1, 1, 1), "M .* different len"),
        (lambda: DESIGN.certify(True), "digits must be 1 or more, got True"),
        (lambda: maps.edge("rho", ROBOT.plant, digits=True), "digits must be 1"),
        (lambda: maps.edge("u_max", ROBOT.plant), "u_max needs .* x0"),
        (lambda: sos.PoleRegion(sigma=True), "sigma must be a finite number"),
        (lambda: sos.PoleRegion(sigma=10**400), "sigma must be a finite number"),
        (lambda: sos.PoleRegion(theta=45), "theta_deg"),
        (lambda: sos.PoleRegion(theta_deg=91), r"theta_deg = 91 .* \(0, 90\]"),
        (lambda: sos.PoleRegion(theta_deg=45, theta=1), "not both"),
        (lambda: sos.design_pid(ROBOT.plant, sos.PoleRegion(1)), "by name, as in"),
        (lambda: sos.design_pid([ROBOT.plant, ROBOT.plant]), r"Polytope\(\[\.\.\."),
        (lambda: sos.Polytope([sos.Polytope([ROBOT.plant])]), "join the lists"),
        (lambda: sos.design_pid(ROBOT.plant, [1, 0]), r"U must .* \[\[1, 0\]\]"),
        (lambda: sos.DescriptorSystem([1, 2], np.eye(2)), r"E must .* \[\[1, 2\]\]"),
        (lambda: LOOP.static(w=[1]), "w must hold 2 finite numbers"),
        (lambda: LOOP.static(w=[1, np.nan]), "w must hold 2 finite numbers"),
        (lambda: LOOP.at(0.1).static(w=[1, np.nan]), "w must hold 2 finite"),
        (lambda: LOOP.at(0.1).largest("tau"), "the rest takes neither"),
        (lambda: LOOP.largest("tau", to=3), "the rest takes neither"),
        (lambda: sos.Step(1, start=2, stop=1), "stop = 1 must be after start = 2"),
        (lambda: sos.Sine(1, 3, stop=0), "stop = 0 must be after start = 0"),
        (lambda: DESIGN.controller(T=0.1, units="m"), "units must be a dict of texts"),
        (lambda: DESIGN.controller(T=0.1, units={"u1": 3}), "units must be a dict"),
        (lambda: sos.SecondOrderSystem(**ONE | dict(D=Table())), "D is a table with"),
        (
            lambda: sos.DescriptorSystem(np.eye(2), np.eye(2), 1, D_u=1),
            "B has 1 rows, needs 2",
        ),
    ],
)
def test_errors_name_the_argument_and_the_cure(make, words):
    with pytest.raises(ValueError, match=words):
        make()


def test_degrees_are_the_same_region():
    for degrees, radians in ((45, np.pi / 4), (30.0, np.radians(30)), (90, np.pi / 2)):
        a = sos.PoleRegion(sigma=1, theta_deg=degrees)
        b = sos.PoleRegion(sigma=1, theta=radians)
        assert a.theta == b.theta and repr(a) == repr(b)


@pytest.mark.parametrize(
    "M, words",
    [
        ([[1, 0.5], [0, 1]], "isn't symmetric: .* differs .* by 0.5. That is right"),
        ([[-1, 0], [0, 1]], "negative eigenvalue -1"),
        ([[1, 2], [2, 1]], "negative eigenvalue -1"),
    ],
)
def test_a_strange_mass_is_named_where_it_was_written(M, words):
    with pytest.warns(MassWarning, match=words) as seen:
        sos.SecondOrderSystem(M, np.eye(2), np.eye(2), np.eye(2))
    assert seen[0].filename == __file__


@pytest.mark.parametrize("factor", [0.3, 2.2046, *campaign([1, 1 / 9.81])])
def test_rows_that_were_divided_are_no_error(factor):
    """A crane's load: its row divided by its mass, so they fill one row of M."""
    m, load, g, rope = 100 * factor, 50 * factor, 9.81, 7.0
    lagrange = sos.SecondOrderSystem(
        [[m + load, load * rope], [load * rope, load * rope**2]],
        np.zeros((2, 2)),
        np.diag([0, load * g * rope]),
        [[1], [0]],
    )
    with pytest.warns(MassWarning) as seen:
        divided = sos.SecondOrderSystem(
            [[m, 0], [1, rope]], np.zeros((2, 2)), [[0, -load * g], [0, g]], [[1], [0]]
        )
    assert "missing" not in str(seen[0].message) and "wrong" not in str(seen[0].message)
    assert divided.poles() == pytest.approx(lagrange.poles(), abs=1e-6)


def test_a_row_without_mass_or_input_has_a_cure():
    """Each cure of the message, done: the finite poles are those of the whole."""
    m, k, spring, c = 10.0, 1000.0, 500.0, 20.0
    D, S = np.array([[c, -c], [-c, c]]), np.diag([k, spring])
    with pytest.raises(ValueError, match="of first order: write a DescriptorSystem"):
        sos.SecondOrderSystem(np.diag([m, 0]), D, S, [[1], [0]])
    whole = sos.SecondOrderSystem(np.diag([m, 0]), D, S, np.eye(2)).poles()
    system = sos.DescriptorSystem(
        [[1, 0, 0], [0, m, 0], [-c, 0, c]],
        [[0, 1, 0], [-k, 0, -spring], [0, 0, -spring]],
        [[0], [1], [0]],
    )
    found = sos.analyse_pid(system, np.zeros((1, 3))).poles()
    assert np.poly(found) == pytest.approx(np.poly(whole))
    with pytest.raises(ValueError, match=r"condense solves for z\[1\]"):
        sos.SecondOrderSystem(
            np.diag([m, 0]), np.diag([c, 0]), [[k, -k], [-k, k + spring]], [[1], [0]]
        )
    full = [[k, -k], [-k, k + spring]]
    whole = sos.SecondOrderSystem(
        np.diag([m, 0]), np.diag([c, 0]), full, np.eye(2)
    ).poles()
    solved = sos.SecondOrderSystem(m, c, k - k**2 / (k + spring), 1).poles()
    assert np.poly(solved) == pytest.approx(np.poly(whole))


def test_an_output_may_differ_between_vertices():
    """The acceleration of a mass on an uncertain spring, written out and by C_a."""
    springs, A = (1.0, 2.0), lambda k: [[0, 1], [-k, -0.5]]
    several = [[[-k, -0.5]] for k in springs]
    asked = np.eye(2), [A(k) for k in springs], None, [[0], [1]]
    out, by_rate = (
        sos.DescriptorSystem(*asked, C=several, D_w=[[1]]),
        sos.DescriptorSystem(*asked, C=[[0, 0]], C_a=[[0, 1]]),
    )
    for k, d, other in zip(springs, out.vertices, by_rate.vertices):
        truth = control.system_norm(
            control.ss(A(k), [[0], [1]], [[-k, -0.5]], 1), "inf"
        )
        for plant in (d, other):
            assert hinf_norm(plant, np.zeros((0, 2))) == pytest.approx(truth, rel=1e-6)
    with pytest.raises(ValueError, match="A has 2 vertices, needs 3 or one"):
        sos.DescriptorSystem(*asked, C=[*several, several[0]])
    with pytest.raises(ValueError, match="D_w has 2 columns, needs 1"):
        sos.DescriptorSystem(*asked, C=several, D_w=[[1, 2]])
    same = sos.DescriptorSystem(np.eye(2), [A(k) for k in springs], C=[np.eye(2)] * 2)
    assert same == sos.DescriptorSystem(np.eye(2), [A(k) for k in springs], C=np.eye(2))
    with pytest.raises(ValueError, match=r"C must be one matrix .*, got a list of 2"):
        sos.design_observer(same, np.zeros((0, 2)), np.eye(4), [[1]], C=several)


def test_a_sound_mass_is_taken_in_silence():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for M in (np.eye(2), np.diag([1, 0]), [[2, 0.1 + 0.2], [0.3, 2]]):
            plant = sos.SecondOrderSystem(M, np.eye(2), np.eye(2), np.eye(2))
        sos.Polytope([plant, plant]).sample(3, seed=0)
        assert sos.regularize(plant).regular.n == 2  # M - B K_A isn't symmetric


def test_plants_are_equal_by_their_data():
    two = [sos.SecondOrderSystem(**ONE | dict(S=s)) for s in (3, 4)]
    again = [sos.SecondOrderSystem(**ONE | dict(S=s)) for s in (3.0, 4)]
    assert two == again and two[0] != two[1] and two[0] != "plant"
    assert sos.Polytope(two) == sos.Polytope(again)
    assert sos.Polytope(two) != sos.Polytope(two[:1])
    assert len({sos.Polytope(two), sos.Polytope(again), *two, *again}) == 3
    zero = [sos.SecondOrderSystem(1, d, 1, 1) for d in (0.0, -0.0)]
    assert zero[0] == zero[1] and hash(zero[0]) == hash(zero[1])
    first = [sos.DescriptorSystem(1, -1, 1, C=1, D_u=d) for d in (2, 2.0, 3)]
    assert first[0] == first[1] != first[2]
    assert first[0] != sos.DescriptorSystem(1, -1, 1, C=1)
    assert hash(first[0]) == hash(first[1])


def test_representations_are_short():
    chain = thesis.example_3().plant
    for plant in (ROBOT.plant, chain, sos.Polytope([ROBOT.plant] * 100)):
        assert len(repr(plant)) < 90 and "\n" not in repr(plant)
    assert repr(sos.Polytope([ROBOT.plant] * 100)).startswith("<Polytope: 100 vertices")


REGULAR = sos.regularize(
    sos.SecondOrderSystem(np.diag([2, 0]), np.eye(2), np.eye(2), np.eye(2))
)


@pytest.mark.parametrize(
    "call",
    [
        lambda plant: sos.design_delay_pid(plant, tau=0.1),
        lambda plant: sos.design_observer(plant, [[0]], np.zeros((4, 1)), [[1]]),
        lambda plant: sos.design_sampled_lqr(plant, np.eye(4), np.eye(2), T=0.1),
        lambda plant: sos.sampled.sampled_loop(plant, np.zeros((2, 4)), 0.1),
        lambda plant: sos.regularize(plant),
        lambda plant: sos.admissible_U(plant),
        lambda plant: sos.infinite_modes(plant),
    ],
)
def test_what_is_no_plant_is_named(call):
    with pytest.raises(ValueError, match=r"plant must be .* give its \.regular"):
        call(REGULAR)
    with pytest.raises(ValueError, match=r"plant must be .* got list: wrap it"):
        call([REGULAR.plant])
    with pytest.raises(ValueError, match="plant must be .* got str"):
        call("plant")


def test_a_regularization_brings_its_gain():
    chain = sos.SecondOrderSystem(
        np.diag([2, 0]), np.eye(2), [[2, -1], [-1, 1]], [[0], [1]]
    )
    found = sos.regularize(chain)
    asked = dict(region=sos.PoleRegion(sigma=0.1))
    by_hand = sos.design_pid(chain, K_A=found.K_A, **asked)
    design = sos.design_pid(found, **asked)
    assert np.array_equal(design.K, by_hand.K) and design.request.plant is chain
    assert np.array_equal(design.K_A, found.K_A) and design.certify().proven
    assert sos.analyse_pid(found, design.K, **asked).status == "feasible"
    with pytest.raises(ValueError, match="regularization has its own"):
        sos.design_pid(found, K_A=found.K_A)
    light = sos.SecondOrderSystem(np.diag([1e-4, 1]), np.eye(2), np.eye(2), [[0], [1]])
    with pytest.raises(ValueError, match="infeasible: there is no gain"):
        sos.design_pid(sos.regularize(light, 1.0))


def test_a_number_of_digits_may_be_numpys():
    digits = np.int64(7)
    assert DESIGN.certify(digits).proven == DESIGN.certify(7).proven is True
    region = sos.PoleRegion(sigma=0.3, rho=5)
    edge = maps.edge("sigma", ROBOT.plant, region=region, digits=np.int64(1))
    assert edge.feasible == 4


def test_an_edge_says_which_way_it_looked():
    none = maps.edge("gamma", ROBOT.plant, digits=1)
    assert none.infeasible is None and "down to gamma = 0.001" in none.reason


ONE_MASS = sos.SecondOrderSystem([[1]], [[1]], [[1]], [[1]], [[1]])
TWICE = {
    "region": (sos.PoleRegion(sigma=0.1), sos.LMIRegion.half_plane(0.7, "faster")),
    "saturation": (sos.Saturation(5, [1, 0]), sos.Saturation(3, [0, 1])),
    "gamma": (2.0, HInfinity(0.1)),
}


@pytest.mark.parametrize("name", TWICE)
def test_what_is_asked_in_two_ways_is_not_dropped_in_one(name):
    one, other = TWICE[name]
    doors = [
        lambda **asked: sos.design_pid(ONE_MASS, **asked),
        lambda **asked: sos.analyse_pid(ONE_MASS, [[-1, -1]], **asked),
    ]
    doors.append(lambda **asked: sos.design_lqr(ONE_MASS, np.eye(2), 1, **asked))
    for door in doors:
        with pytest.raises(ValueError, match=f"{name} is given.*in one place"):
            door(**{name: one}, requirements=[other])
        assert door(requirements=[other]).status != "undecided"


@pytest.mark.parametrize("of_a_law", [False, True])
def test_a_loop_and_a_signal_keep_what_they_were_given(of_a_law):
    """A gain that was changed later made another loop of the same object."""
    plant = sos.SecondOrderSystem(0.3, 0.2, 9.81, 1)
    K = np.array([[-1.0]]) if of_a_law else np.array([[-1.0, -2.0]])
    law = sos.PIDLaw(position=[[1]]) if of_a_law else None
    loop = sos.Loop(plant, law, {"K_P": K} if of_a_law else K)
    height = np.array([1.0, 2.0])
    step, sine = sos.Step(height), sos.Sine(height, 3, offset=height)
    K[0, 0] = height[0] = 50.0
    own = [[0, 1], [-10.81 / 0.3, -(0.2 if of_a_law else 2.2) / 0.3]]
    assert np.allclose(np.sort(loop.poles()), np.sort(np.linalg.eigvals(own)))
    assert step([0.0])[0] == sine([0.0])[0] == 1
