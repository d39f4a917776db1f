"""Plants with parameters in ranges: the builder, the vertices, the words."""

import json
import math
import re
import warnings
from fractions import Fraction
from itertools import product
from math import comb, prod

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse as sp
from flint import fmpq

import sosbook as sos
from sosbook.exact.checker import CHECKER, verdict
from sosbook.exact.proof_file import ProofFile
from sosbook.exact.rational import exact, rational_matrix
from sosbook.plants.bernstein import Box
from sosbook.plants.parametric import ParameterError, parameters
from sosbook.proofs import command
from sosbook.studies import polytopes
from tests.asking import asked_by, asking
from tests.cases import crossed
from tests.processes import alone

I2 = np.eye(2)


def one(M, D=1, S=1, B=1):
    return sos.SecondOrderSystem(M, D, S, B)


def drive(J2, k):
    return sos.SecondOrderSystem(
        [[0.0025, 0], [0, J2]],
        [[0.004, -0.004], [-0.004, 0.004]],
        [[k, -k], [-k, k]],
        [[1], [0]],
    )


def bicycle(v):
    M = np.array([[80.8, 2.32], [2.32, 0.298]])
    C = np.array([[0, 33.9], [-0.85, 1.69]])
    K0, K2 = np.array([[-80.9, -2.6], [-2.6, -0.8]]), np.array([[0, 76.6], [0, 2.65]])
    return sos.SecondOrderSystem(M, v * C, 9.81 * K0 + v**2 * K2, [[0], [1]], I2)


def crane(m, l):
    return sos.SecondOrderSystem(
        [[1000 + m, m * l], [m * l, m * l**2]],
        np.zeros((2, 2)),
        np.diag([0, m * 9.81 * l]),
        [[1], [0]],
    )


def spring(k, ends):
    S = np.zeros((4, 4))
    for i in range(3):
        S[i : i + 2, i : i + 2] += k * np.array([[1, -1], [-1, 1]])
    S[0, 0] += ends
    return S


def chain(m, k):
    M = np.eye(4)
    M[3, 3] = m
    S = spring(k, 2 * k)
    D = np.zeros_like(S)
    D[:] = 0.01 * S
    return sos.SecondOrderSystem(M, D, S, np.eye(4)[:, :1])


def quotients(m, l):
    S = [[9.81 / l, -1 / m], [1 / m, 3]]
    return sos.SecondOrderSystem(I2, 0 * I2, S, [[1 / (m * l**2)], [0]])


def checked(m):
    if m <= 0:
        raise ValueError("a mass is positive")
    return sos.SecondOrderSystem(max(m, 0.5), abs(-m), 1, 1)


def algebra(m, k):
    T = np.array([[1, 0.5], [0, 1]])
    M = np.einsum("ij,jk->ik", T.T, np.diag([m, 2 * m])) @ T
    S = np.linalg.matrix_power(np.array([[k, 0], [1, 1]], object), 2)
    S = S + np.trace(M) * I2 + scipy.linalg.block_diag([[1]], [[1]])
    D = np.kron(np.eye(1), np.array([[k, 0], [0, 1]], object)) + sp.eye(2).toarray()
    return sos.SecondOrderSystem(M, D, S, np.linalg.inv(T)[:, :1])


def first_order(E, k):
    return sos.DescriptorSystem(
        np.diag([1, E]), [[0, 1], [-k, -1]], [[0], [1]], C=[[1, 0]]
    )


PLANTS = {
    drive: dict(J2=(0.003, 0.006), k=(1.7, 2.1)),
    bicycle: dict(v=(1, 10)),
    crane: dict(m=(1000, 2000), l=(8, 16)),
    chain: dict(m=(1, 2), k=(3, 4)),
    quotients: dict(m=(1, 2), l=(0.5, 0.9)),
    checked: dict(m=(1, 2)),
    algebra: dict(m=(1, 2), k=(1, 2)),
    first_order: dict(E=(0.5, 2), k=(1, 3)),
}
families = pytest.mark.parametrize("builder", PLANTS, ids=lambda f: f.__name__)


def family(builder):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", sos.MassWarning)
        return sos.Uncertain(builder, **PLANTS[builder])


def motion(plant):
    """E^-1 [A B_u B_w], which no multiple of a row changes."""
    d = plant.vertices[0]
    if isinstance(plant, sos.DescriptorSystem):
        return np.linalg.solve(d.E, np.hstack([d.A, d.Bu, d.Bw]))
    return np.linalg.solve(d.M, np.hstack([d.D, d.S, d.B, d.F]))


@families
@pytest.mark.filterwarnings("ignore::sosbook.MassWarning")
def test_the_family_has_the_plants_of_its_builder(builder):
    plants, rng = family(builder), np.random.default_rng(3)
    for _ in range(10):
        values = {name: rng.uniform(*ends) for name, ends in PLANTS[builder].items()}
        mine, its = motion(plants.at(**values)), motion(builder(**values))
        assert np.allclose(mine, its, rtol=1e-12, atol=1e-12 * np.abs(its).max())


@families
def test_each_plant_is_a_mean_of_the_vertices(builder):
    """With Bernstein's weights, in exact arithmetic."""
    plants = family(builder)
    stacks = plants.vertices
    kind = "E" if builder is first_order else "M"
    for name in (kind, *("ABC" if builder is first_order else "DS")):
        own = "Bu" if (kind, name) == ("E", "B") else name
        corners = [rationals(v, own) for v in stacks]
        for share in (fmpq(0), fmpq(2, 7), fmpq(1)):
            box = plants.box
            point = {
                k: a + (b - a) * share for k, a, b in zip(box.names, box.low, box.high)
            }
            weights = [
                prod(
                    comb(d, i) * share**i * (1 - share) ** (d - i)
                    for i, d in zip(place, plants.degree.values())
                )
                for place in product(*(range(d + 1) for d in plants.degree.values()))
            ]
            there = plants._at(plants.box.point(point))[name]
            mean = sum((w * x for w, x in zip(weights, corners)), 0 * there)
            assert (mean == there).all()
            assert sum(weights) == 1 and min(weights) >= 0


def rationals(vertex, name):
    if hasattr(vertex, "Bu"):
        return getattr(vertex.map(exact), name)
    return vars(vertex)["_rationals"][name]


def test_corners_are_exact_where_no_power_is_above_one():
    plants = family(drive)
    assert plants.multi_affine and len(plants.vertices) == 4
    corners = list(product((0.003, 0.006), (1.7, 2.1)))
    assert [(v.M[1, 1], v.S[0, 0]) for v in plants.vertices] == corners
    bare = sos.Polytope([drive(*corner) for corner in corners])
    assert plants.polytope() == bare


def test_a_row_s_form_changes_no_vertex():
    """The crane as Lagrange writes it, and its second row divided by m l; m times this
    one is taken from the first.
    """

    def divided(m, l):
        return sos.SecondOrderSystem(
            [[1000 + m, m * l], [1, l]],
            np.zeros((2, 2)),
            np.diag([0, 9.81]),
            [[1], [0]],
        )

    plants = family(crane)
    words = {1: "given (-1)/(l) times row 2", 2: "divided by m*l"}
    assert plants.rows == words and "row 2 was divided by m*l" in repr(plants)
    assert plants.at(m=1500, l=10).M.tolist() == [[1000, 0], [1, 10]]
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # undivided, its rows are Lagrange's
        other = sos.Uncertain(divided, **PLANTS[crane])
    assert plants == other and plants.vertices == other.vertices


def test_a_builder_is_warned_of_once():
    """At the line that makes its plants, whose numbers differ."""

    def skew(m, k):
        warnings.warn("mine", stacklevel=1)
        return sos.SecondOrderSystem(
            [[m, 0.3], [0.1, 1]], np.eye(2), [[k, 1], [1, 2]], [[1], [0]]
        )

    with pytest.warns() as said:
        sos.Uncertain(skew, m=(1, 2), k=(3, 9.81))
    assert [w.category for w in said].count(sos.MassWarning) == 1
    assert {str(w.message)[:20] for w in said} == {"mine", "M isn't symmetric: i"}
    assert {w.filename for w in said} == {__file__}


def test_a_long_family_has_a_short_repr():
    """Of twenty rows that were divided by their mass three are named."""
    n = 20

    def chain(m):
        return sos.SecondOrderSystem(
            np.eye(n), np.eye(n) / m, np.eye(n), np.eye(n)[:, :1]
        )

    told = repr(sos.Uncertain(chain, m=(1, 2)))
    assert told.count("; row") == 3 and told.endswith("; so were 17 rows more>")


def test_halves_lie_inside():
    plants = family(bicycle)
    first, second = plants.halves("v")
    assert str(first.box) == "v in [1, 5.5]" and str(second.box) == "v in [5.5, 10]"
    assert str(plants.halves()) == str((first, second))
    whole = np.array([v.S for v in plants.vertices])
    for half in (first, second):
        S = np.array([v.S for v in half.vertices])
        assert (S.min(axis=0) >= whole.min(axis=0) - 1e-9).all()
        assert (S.max(axis=0) <= whole.max(axis=0) + 1e-9).all()
    assert first.vertices[-1] == second.vertices[0] == plants.at(v=5.5)
    assert first.vertices[0] == plants.at(v=1)


def test_samples_are_inside_and_repeat():
    plants = family(drive)
    again = plants.sample(5, 1)
    assert plants.sample(5, 1) == again != plants.sample(5, 2)
    assert all(0.003 <= v.M[1, 1] <= 0.006 for v in again)
    assert plants.nominal.M[1, 1] == 0.0045


def test_expressions_of_sympy_are_read():
    sympy = pytest.importorskip("sympy")
    m, k = sympy.symbols("m k", positive=True)
    M, S = sympy.Matrix([[m, 0], [0, m / 3]]), sympy.Matrix([[k + 9.81 * m, 0], [0, k]])
    mine = sos.Uncertain(
        lambda m, k: sos.SecondOrderSystem(M, 0 * I2, S, I2), m=(1, 2), k=(5, 6)
    )
    by_numbers = sympy.lambdify((m, k), (M, S))
    for values in ({"m": 1.5, "k": 5}, {"m": 1.2, "k": 5.5}):
        plant, wanted = mine.at(**values), by_numbers(**values)
        assert np.allclose(plant.M, wanted[0]) and np.allclose(plant.S, wanted[1])


REFUSED = {
    "float": (lambda m: one(float(m)), "only a plain number"),
    "math.sqrt": (lambda m: one(math.sqrt(m)), "only a plain number"),
    "np.sqrt": (lambda m: one(np.sqrt(m)), "write its square"),
    "np.sin": (lambda m: one(np.sin(np.array([[m]]))), "sin(q)/q"),
    "a root": (lambda m: one(m**0.5), "whole powers"),
    "an exponent": (lambda m: one(2**m), "range of its own"),
    "np.exp": (lambda m: one(np.exp(m)), "range of its own"),
    "a case": (lambda m: one(m if m > 1.5 else 1), "`m > 1.5`"),
    "equal": (lambda m: one(m if m == 1.5 else 1), "each case"),
    "max": (lambda m: one(max(m, 1.5)), "each case"),
    "np.maximum": (lambda m: one(np.maximum(m, 1.5)), "each case"),
    "float array": (lambda m: one(np.array([[m]], float)), "float array"),
    "inv": (lambda m: one(np.linalg.inv(np.array([[m]]))), "no inverse"),
    "det": (lambda m: one(np.linalg.det(np.array([[m]]))), "no inverse"),
    "eigvals": (lambda m: one(np.linalg.eigvals(np.array([[m]]))), "numpy can't"),
    "a zero": (lambda m: one(1 / (m - 1.5)), "division by m - 1.5"),
    "complex": (lambda m: one(1j * m), "a plant is real"),
    "round": (lambda m: one(round(m, 2)), "only a plain number"),
    "range": (lambda m: [0 for _ in range(m)], "only a plain number"),
    "poles": (lambda m: one(m).poles(), "asks for .poles"),
    "sparse": (lambda m: one(sp.csr_array(np.array([[m]]))), "scipy.sparse"),
    "unused": (lambda m: one(1), "doesn't depend on m"),
    "nothing": (lambda m: None, "must return a plant"),
    "chance": (lambda m: one(m * np.random.default_rng().random()), "of m alone"),
    "a type": (lambda m: one(m if isinstance(m, float) else 2 * m), "of m alone"),
    "nan": (lambda m: one(m, float("nan")), "D[0, 0] = nan"),
    "a vector": (lambda m: one([m, m]), "two dimensions"),
    "an output": (
        lambda m: sos.DescriptorSystem(1, -m, 1, C=[[1 / m]]),
        "C has the denominator m",
    ),
}


@pytest.mark.parametrize("what", REFUSED)
def test_what_is_not_rational_is_refused_in_words(what):
    builder, words = REFUSED[what]
    with pytest.raises(ValueError) as error:
        sos.Uncertain(builder, m=(1, 2))
    assert words in str(error.value)
    if isinstance(error.value, ParameterError) and "alone" not in words:
        assert "sos" not in str(error.value)


def test_a_quotient_has_the_sign_of_its_values():
    """Bounds of the denominator leave its sign open after a common factor went."""
    (x,) = parameters(Box.of(x=(0, 1))).values()
    well, factor = x**2 - x + 0.3, 1 + 0.001 * x**6
    quotient = factor / (-well * factor)
    assert quotient.at((fmpq(1, 2),)) < 0
    assert not quotient > 0


SIGNS = [  # ranges, what is asked, and what the refusal says, if it is refused
    ("m**2 + 1 > 0", (-1, 1), None),
    ("1/(1 + m**2) + 1/(0.26 - m + m**2) > 1/4", (-1, 1), None),
    ("(m - k)**2 + 0.01*k**2 >= 1/1000", (1, 2), None),
    ("abs(m**3 + m) != m**3 + m", (-2, -1), None),
    ("m > 0", (0, 1), "`m > 0` isn't the same"),
    ("m**2 - m + 0.2 > 0", (0, 1), "isn't the same"),
    ("(m - 1/3)**2 >= 0", (0, 1), "isn't decided"),
    ("1/(m - 1/3)**2 > 0", (0, 1), "may be zero"),
    ("1/(m*k - 2) > 0", (1, 2), "may be zero"),
]


@pytest.mark.parametrize(("asked", "ends", "words"), SIGNS)
def test_a_sign_is_looked_for_in_parts_of_the_ranges(asked, ends, words):
    """No word of a refusal is false: what is so everywhere is answered."""
    known = parameters(Box.of(m=ends, k=(1, 2)))
    if words is None:
        assert eval(asked, {}, known) is True
    else:
        with pytest.raises(ParameterError, match=words):
            eval(asked, {}, known)


def test_a_comparison_that_is_caught_is_refused_too():
    def builder(m):
        try:
            inside = 1.4 < m < 1.45
        except ValueError:
            inside = False
        return one(3 if inside else m)

    with pytest.raises(ParameterError, match="`m > 1.4`.*line .*inside = 1.4 < m"):
        sos.Uncertain(builder, m=(1, 2))


def test_the_line_is_quoted():
    def builder(length):
        return one(np.sin(length))

    with pytest.raises(ParameterError, match=r"\[builder, line \d+: return one"):
        sos.Uncertain(builder, length=(1, 2))


@pytest.mark.parametrize(
    ("ranges", "words"),
    [
        ({"m": (2, 1)}, "the range of m is empty"),
        ({"m": (1, 1)}, "the range of m is one number"),
        ({"m": 3}, "m must be a pair"),
        ({"m": (1, np.inf)}, "m must be a finite number"),
        ({"m": ("a", 2)}, "m must be a finite number"),
        ({"m": (False, True)}, "m must be a finite number"),
        ({"k": (1, 2)}, "unexpected keyword argument 'k'"),
        ({"m": (1, 2), "q": (1, 2)}, "unexpected keyword argument 'q'"),
        ({}, "there is no parameter"),
    ],
)
def test_bad_ranges_are_refused(ranges, words):
    with pytest.raises(ValueError, match=words):
        sos.Uncertain(one_of_m, **ranges)


def one_of_m(m):
    return one(m)


def test_numbers_of_any_kind_are_ranges():
    given = [(1, 2), (1.0, np.float64(2)), (Fraction(1), fmpq(2)), (np.int32(1), 2)]
    (box,) = {Box.of(m=ends) for ends in given}
    assert sos.Uncertain(one_of_m, m=(1, 2)).box == box
    assert Box.of(m=(0.1, Fraction(1, 3))).low == (fmpq(1, 10),)


def test_values_out_of_their_range_are_refused():
    plants = family(drive)
    with pytest.raises(ValueError, match=r"k = 3 isn't in \[1.7, 2.1\]"):
        plants.at(J2=0.004, k=3)
    with pytest.raises(ValueError, match="give a value of J2, k"):
        plants.at(J2=0.004)
    with pytest.raises(ValueError, match="'q' is no parameter"):
        plants.halves("q")


def test_parameters_of_two_families_do_not_mix():
    kept = []

    def keeps(m):
        kept.append(m)
        return one(m)

    sos.Uncertain(keeps, m=(1, 2))
    with pytest.raises(ParameterError, match="two families"):
        sos.Uncertain(lambda k: one(k * kept[0]), k=(1, 2))


@pytest.mark.parametrize(
    ("entry", "ends", "where"),
    [
        (lambda c: [[c, 0], [0, 1]], (0, 1), "at or beside c = 0:"),
        (lambda c: [[1, c], [c, 1]], (-2, 2), "between c = 0 and c = -2:"),
        (lambda c: [[(c - 0.5) ** 2, 0], [0, 1]], (0, 1), "at or beside c = 0.5:"),
    ],
)
def test_a_singular_E_is_found(entry, ends, where):
    with pytest.raises(ValueError, match=f"E is singular {where}"):
        sos.Uncertain(lambda c: sos.DescriptorSystem(entry(c), -I2, I2), c=ends)


def test_a_singular_mass_needs_an_acceleration_gain():
    crossing = sos.Uncertain(lambda m: one([[m, 0], [0, 1]], I2, I2, I2), m=(-1, 2))
    with pytest.raises(ValueError, match="M is singular between m = 0.5 and m = -1:"):
        sos.design_pid(crossing)
    mended = sos.design_pid(crossing, K_A=[[-3, 0], [0, 0]])
    assert mended.certify().proven


def test_a_regular_E_is_none():
    """Not even where it is nearly singular, or its vertices are."""
    for low in (1e-6, 1e-3, 1):
        square = sos.Uncertain(
            lambda c, low=low: sos.DescriptorSystem(
                [[(c - 0.5) ** 2 + low, 0], [0, 1]], -I2, I2
            ),
            c=(0, 1),
        )
        assert len(square.vertices) == 3


def test_too_many_vertices_are_refused_with_the_dearest_parameter():
    def builder(**given):
        a, *others = given.values()
        return one(1 + a**2 * sum(others))

    plants = sos.Uncertain(builder, **{f"p{k}": (1, 2) for k in range(8)})
    with pytest.raises(ValueError, match="384 vertices.*p0 costs most"):
        _ = plants.vertices
    with pytest.raises(ValueError, match="cut into fewer pieces"):
        _ = family(bicycle).cut(v=300).vertices


ASKED = dict(region=sos.PoleRegion(sigma=0.3, rho=200))


def checked_by_a_stranger(proof, folder):
    """The claims of the checker, which shares no line with the package."""
    file = folder / "proof.json"
    proof.save(file)
    run = alone(CHECKER, file)
    return run.returncode, run.stdout


@pytest.mark.parametrize(
    "builder, coupling", crossed([drive, first_order, chain], ["pairs", "slack"])
)
def test_a_design_is_proven_for_all_values_of_the_parameters(
    builder, coupling, tmp_path
):
    plants = family(builder)
    design = sos.design_pid(plants, **ASKED, coupling=coupling)
    proof = design.certify()
    code, text = checked_by_a_stranger(proof, tmp_path)
    scope = "constant or changing" if coupling == "pairs" else "constant"
    first = f"every {scope} plant with {plants.box}, under u = K x, is stable"
    assert proof.proven and proof.claims[0] == first
    assert code == 0 and f"- {first}" in text
    for plant in plants.sample(20, 5):
        d = sos.plants.descriptors(plant)[0] if builder is not first_order else None
        d = plant.vertices[0] if d is None else d
        poles = np.linalg.eigvals(np.linalg.solve(d.E, d.A + d.Bu @ proof.K))
        assert poles.real.max() < -0.3 and np.abs(poles).max() < 200


def test_a_file_with_other_ranges_or_polynomials_is_no_proof(tmp_path):
    text = json.dumps(asked_by(sos.design_pid(family(drive), **ASKED).certify()))
    changes = [
        text.replace("0.006", "0.6"),
        text.replace('"J2"]', '"1*J2"]'),
        text.replace('"0.003"', '"3/1000"'),
        text.replace('"J2"', '"x"', 1),
        text.replace('"k"', '"k^9"', 1),
    ]
    for k, other in enumerate(changes):
        assert other != text
        file = tmp_path / f"{k}.json"
        file.write_text(json.dumps(asking(json.loads(other))), "utf-8")
        assert not ProofFile.load(file).proven
        run = alone(CHECKER, file)
        assert run.returncode == 1


def test_every_door_takes_a_family():
    plants, K = family(drive), sos.design_pid(family(drive), **ASKED).K
    changing = "every constant or changing plant with k in [1, "
    where = f"every constant or changing plant with {plants.box}"
    damped = sos.Uncertain(
        lambda k: sos.SecondOrderSystem(I2, I2, [[k, 0], [0, 3]], I2, I2), k=(1, 1.2)
    )
    stable = sos.analyse_pid(plants, K, region=sos.PoleRegion(sigma=0.2))
    assert stable.certify().claims[0].startswith(where)
    late = sos.design_delay_pid(damped, tau=0.05, mu=0.01)
    assert late.certify().claims[0].startswith(changing + "1.2]")
    costs = sos.design_lqr(damped, np.eye(4), I2)
    assert costs.certify().claims[0].startswith(changing + "1.2]")
    sampled = sos.certify_sampled(damped, costs.K, 0.05)
    assert "every constant plant with k in [1, 1.2]" in sampled.claims[0]
    observer = sos.design_observer(damped, costs.K, Q_F=np.ones((8, 1)), R_F=0.1 * I2)
    assert observer.status == "feasible"
    assert observer.analyse().certify().proven
    massless = sos.Uncertain(
        lambda k: sos.SecondOrderSystem(
            [[2, 0], [0, 0]], I2, [[k, -1], [-1, 1]], [[0], [1]]
        ),
        k=(1, 2),
    )
    mended = sos.regularize(massless, beta=0.1)
    assert mended.certify().proven
    assert mended.certify().claims[0].startswith("for every plant with k in [1, 2]")
    design = sos.design_pid(mended, region=sos.PoleRegion(sigma=0.1))
    assert design.certify().claims[0].startswith(changing + "2]")
    assert len(sos.infinite_modes(massless)) == 2
    (best, *_) = sos.admissible_U(damped)
    assert best.admissible
    kept = polytopes.verify_on_samples(sos.design_pid(damped, **ASKED))
    assert min(kept.values()) > 0


def test_a_plant_file_may_have_parameters(tmp_path):
    file = tmp_path / "plant.json"
    plant = {
        "parameters": {"m": [1000, 2000], "l": [8, 16]},
        "M": [["1000 + m", "m*l"], ["m*l", "m*l^2"]],
        "D": [[0, 0], [0, 0]],
        "S": [[0, 0], [0, "9.81*m*l"]],
        "B": [[1], [0]],
    }
    file.write_text(json.dumps({"plant": plant}), "utf-8")
    assert sos.plants.load_plant(file) == family(crane)
    for change, words in [
        ({"M": [["m + sin(l)", 0], [0, 1]]}, "sin in 'm . sin(l)' has no range"),
        ({"M": [["m*(1 + l)", 0], [0, 1]]}, "isn't a polynomial at '*(1+l)'"),
        ({"M": [["m + q", 0], [0, 1]]}, "q in 'm . q' has no range"),
        ({"parameters": {"m": [2, 1], "l": [8, 16]}}, "the range of m is empty"),
        ({"parameters": {"m": 3}}, "parameters must be like"),
        ({"M": 3}, "a matrix must be a list of rows"),
        ({"B": [["1/0"], [0]]}, "divides by zero"),
        ({"Q": [[1]]}, "'Q' isn't known"),
        ({"coordinates": ["x"]}, "coordinates must be 2 different names"),
    ]:
        file.write_text(json.dumps({"plant": plant | change}), "utf-8")
        with pytest.raises(ValueError, match=re.sub(r"([()*+])", r"\\\1", words)):
            sos.plants.load_plant(file)


def test_the_command_designs_for_parameters(tmp_path, capsys):
    file, proof = tmp_path / "plant.json", tmp_path / "proof.json"
    plant = {
        "parameters": {"J2": [0.003, 0.006]},
        "M": [[0.0025, 0], [0, "J2"]],
        "D": [[0.004, -0.004], [-0.004, 0.004]],
        "S": [[2, -2], [-2, 2]],
        "B": [[1], [0]],
    }
    file.write_text(json.dumps({"plant": plant, "region": {"sigma": 0.3}}), "utf-8")
    assert command.main(["design", str(file), "--proof", str(proof)]) == 0
    assert "changing plant with J2 in [0.003, 0.006]" in capsys.readouterr().out
    assert command.main(["verify", str(proof), "--plant", str(file)]) == 0
    plant["parameters"]["J2"][1] = 0.007
    file.write_text(json.dumps({"plant": plant}), "utf-8")
    assert command.main(["verify", str(proof), "--plant", str(file)]) == 1


@pytest.mark.parametrize("pieces", [1, 2, 3])
def test_the_hull_of_the_pieces_holds_the_family(pieces):
    """Each polynomial of degree 3 stays between its coefficients, ever closer."""
    box, rng = Box.of(v=(-1, 2)), np.random.default_rng(pieces)
    monomials = [(e,) for e in range(4)]
    for _ in range(20):
        c = rational_matrix([[fmpq(int(x))] for x in rng.integers(-9, 9, 4)])
        coarse, fine = (
            (box.bernstein(monomials, [3], [n]) @ c).ravel().tolist()
            for n in (pieces, 2 * pieces)
        )
        points = [(fmpq(k, 20),) for k in range(-20, 41)]
        values = [
            (rational_matrix([box.powers(x, monomials)]) @ c)[0, 0] for x in points
        ]
        assert len(coarse) == 2 + 2 * pieces
        assert min(coarse) <= min(fine) <= min(values)
        assert max(coarse) >= max(fine) >= max(values)


def test_where_pieces_meet_the_coefficient_is_a_mean():
    """So `Box.bernstein` may leave it out: whole forms of both halves have it."""
    box = Box.of(v=(1, 4), m=(0, 1))
    monomials, degrees = [(2, 1), (1, 0), (0, 1), (2, 0)], [2, 1]
    one_piece, other = (h.bernstein(monomials, degrees) for h in box.halves("v"))
    kept = box.bernstein(monomials, degrees, [2, 1])
    for m in (0, 1):
        left, right = one_piece[m::2], other[m::2]
        assert (left[2] == right[0]).all()
        assert (2 * left[2] == left[1] + right[1]).all()
        assert (kept[m::2] == np.vstack([left[:2], right[1:]])).all()


def test_pieces_are_counted():
    for bad in ({"v": 0}, {"v": 1.5}, {"q": 2}):
        with pytest.raises(ValueError, match="v must be|'q' is no parameter"):
            family(bicycle).cut(**bad)


def by_thirds(m):
    return sos.SecondOrderSystem([[1 + m / 3]], [[0.3]], [[2 * m]], [[1]], [[1]])


def by_products(m):  # 3 times 0.1 is another float than 0.3
    return sos.SecondOrderSystem([[1 + 3 * m]], [[0.3]], [[2 * m]], [[1]], [[1]])


@pytest.mark.parametrize("build", [by_thirds, by_products])
def test_vertices_out_of_a_family_are_proven_as_their_floats(build):
    """A family's vertices know rationals; a list of plants is what a file can say."""
    vertices = sos.Uncertain(build, m=(0.1, 0.7)).vertices
    asked = dict(region=sos.PoleRegion(sigma=0.1, rho=20))
    for plant in (vertices[0], sos.Polytope(vertices)):
        design = sos.design_pid(plant, **asked)
        assert verdict.check(design.certify().text)[0].endswith("is stable")
        known = sos.analyse_pid(plant, design.K, **asked)
        assert known.status == "feasible" and known.certify().proven
        refused = sos.design_pid(plant, **asked, gamma=1e-9)
        assert refused.status == "infeasible" and refused.infeasibility.proven
