"""Parts of the checker against numpy, and files about seldom plants, true and forged.

A file here is made by the package and decided by the checker; what is false of other
plants is refused of them.
"""

import json
import re
from fractions import Fraction

import numpy as np
import pytest

import sosbook as sos
from sosbook.exact.checker import (
    any_order,
    arithmetic,
    fixed_mode,
    plants,
    regions,
    verdict,
)
from sosbook.exact.checker.verdict import check
from sosbook.exact.rational import decimal
from sosbook.sampled.system import SampledSystem
from tests.cases import seeds
from tests.forged import base, changed, decided, near_a_box, needs, refusal
from tests.hunt.tampering import put
from tests.test_any_order import bound
from tests.test_every_need import of_design
from tests.test_proof_files import A2, LOOP, TWO, growing, proof_of

APART = dict(
    E=[np.eye(2), np.diag([1, 1.5])],
    A=A2,
    B=[[0], [1]],
    B_w=[[0], [1]],
    C=[[[1, 0]], [[1, 0.2]]],
    D_u=[[[0.1]], [[0.2]]],
    D_w=[[[0.3]], [[0]]],
)


def fractions(x):
    return [[Fraction(float(e)) for e in row] for row in np.atleast_2d(x)]


@pytest.mark.parametrize("seed", seeds(8))
def test_matrices_of_a_region_are_those_of_numpy(seed):
    """The half-plane that a vector sees, and the region of s that one of z becomes."""
    rng = np.random.default_rng(seed)
    k = int(rng.integers(1, 4))
    alpha, beta = rng.normal(size=(2, k, k)).round(3)
    alpha, (a, b), dt = alpha + alpha.T, rng.normal(size=(2, k)), 0.3
    v, s = a + 1j * b, complex(*rng.normal(size=2))

    def region(alpha, beta, s):
        x = np.asarray(alpha, float) + np.asarray(beta, float) * s
        return x + np.asarray(beta, float).T * s.conjugate()

    found = fixed_mode.half_plane(
        *(fractions(x) for x in (alpha, beta)), *(fractions(x)[0] for x in (a, b))
    )
    level, re_, im = map(float, found)
    there = level + 2 * ((re_ + 1j * im) * s).real
    assert there == pytest.approx((v.conj() @ region(alpha, beta, s) @ v).real)
    of_z = regions.at_ticks(
        {"dt": "0.3"}, fractions(alpha), fractions(beta), "its poles lie"
    )
    assert of_z[2] == "its poles z lie"
    there = dt * region(*of_z[:2], s)
    assert there == pytest.approx(region(alpha, beta, 1 + dt * s))


@pytest.mark.parametrize("seed", seeds(8))
def test_polynomials_signs_and_digits_are_those_of_numpy(seed):
    rng = np.random.default_rng(seed)
    h, a = rng.integers(-5, 6, 5).tolist(), Fraction(int(rng.integers(-9, 9)), 4)
    there = np.polynomial.Polynomial(h)(np.polynomial.Polynomial([float(a), 1.0]))
    found = [float(x) for x in fixed_mode.moved(h, a)]
    assert found == pytest.approx(np.resize(np.r_[there.coef, np.zeros(5)], 5))
    E = rng.integers(-2, 3, (3, 2, 2))
    several = [arithmetic.Mat(2, 2, x.tolist(), 4) for x in E]  # all below one
    signs = {*np.sign(np.round(np.linalg.det(E))).tolist()}
    assert plants.one_sign(several) is (signs in ({1.0}, {-1.0}))
    x = Fraction(int(rng.integers(-(10**9), 10**9)), int(rng.integers(1, 10**6)))
    for number in (x, x / 10**9, Fraction(-1234567, 10**6), Fraction(1234567, 10**6)):
        said = Fraction(any_order.downwards(number))
        assert 0 <= number - said <= Fraction(11, 10**6) * abs(number)


@pytest.mark.parametrize("seed", seeds(8))
def test_a_root_is_outside_where_the_whole_circle_around_its_place_is(seed):
    """The circle of radius n |h/h'| around c, and the line that a vector sees."""
    rng = np.random.default_rng(seed)
    roots = rng.normal(size=3) + 2
    h, c = np.polynomial.polynomial.polyfromroots(roots), complex(roots[0] + 0.01, 0.02)
    of = np.polynomial.Polynomial(h)
    radius = 3 * abs(of(c) / of.deriv()(c))
    (a, b), beta = rng.normal(size=(2, 2)), rng.normal(size=(2, 2))
    v = a + 1j * b
    turn = v.conj() @ beta @ v
    for share, out in ((1.01, True), (0.99, False), (-1.01, False)):
        level = 2 * abs(turn) * share * radius - 2 * (c * turn).real
        found = fixed_mode.outside(
            fractions(level / (v.conj() @ v).real * np.eye(2)),
            fractions(beta),
            [Fraction(x) for x in h],
            *map(Fraction, (c.real, c.imag)),
            [(Fraction(p), Fraction(q)) for p, q in zip(a, b)],
        )
        assert found is out


def test_a_place_beside_a_half_plane_is_a_millionth_of_its_size_away():
    for size, beta in ((0.1, 1), (10, 0.25), (10, 4)):
        half = fractions([[2 * size * beta]]), fractions([[beta]])
        for off, out in ((0.8e-6, True), (1.2e-6, False)):
            x = Fraction(-size * (1 + off))
            assert fixed_mode.kept_out(*half, x, Fraction(0)) is out


@pytest.mark.parametrize("name", ["a mode at rest", "a mode on a circle"])
def test_a_mode_is_a_root_and_the_point_is_near_it(name):
    asked = base(name)
    x, y = map(Fraction, asked["point"])
    size = Fraction(max(abs(x), abs(y), 1))
    for off in (size / 1000, size / 10, 30 * size):
        there = [str(x + off), str(y)]
        at = refusal(decided, changed(name, [[["point"], there]]))
        assert "no mode is near the point" in needs()[at][1]
    none = [[["polynomial"], ["1"]], [["rows"], []]]
    assert "must be monic" in needs()[refusal(decided, changed(name, none))][1]


def test_the_words_of_each_region_of_z_speak_of_z():
    """At ticks no form is said in the letter s, and the matrices are said in z."""
    for r in base("regions")["requirements"]:
        words = regions.region(r)[2]
        said = regions.of_z(words)
        assert not re.search(r"\bs\b", said)
        assert said == re.sub(r"\bs\b", "z", words).replace("poles lie", "poles z lie")


@pytest.mark.parametrize(
    "E, F, there",
    [
        ([1, 1], [1, -2], True),
        ([1, 0], [1, -1], True),
        ([1, 1], [1, 2], False),
        ([1, -2], [1, -1], False),
        ([0.2, 1], [0.3, 1], False),
    ],
)
def test_a_mass_is_singular_between_two_where_its_determinant_is_zero(E, F, there):
    """Two negative determinants, and one of their sum, are none."""
    zeros = [np.linalg.det(np.diag((1 - t) * np.array(E) + t * np.array(F)))
             for t in np.linspace(0, 1, 101)]  # fmt: skip
    assert bool(min(zeros) <= 1e-12 and max(zeros) >= -1e-12) is there
    how = [
        [["plant", "vertices", k, "E"], [[str(x[0]), "0"], ["0", str(x[1])]]]
        for k, x in enumerate((E, F))
    ]
    for more in ([], [[["plant", "dt"], "0.1"]]):
        at = refusal(decided, changed("a singular mass", how + more))
        assert (at == "accepted") is there
        assert there or "no mass is singular there" in needs()[at][1]


@pytest.mark.parametrize(
    "one, near, far",
    [
        ([[0.5]], [[0.4]], [[-0.5]]),
        ([[2, 0], [0, 2]], [[2.1, -0.1], [-0.1, 2.1]], [[0, 2], [2, 0]]),
    ],
)
def test_vertices_don_t_suffice_where_one_determinant_is_below_zero(one, near, far):
    """x' = -x + u at both, E and A along one column, and no plant is halfway."""
    E = np.array([one, near])
    b = np.ones((len(one), 1))
    asked = of_design(sos.DescriptorSystem(E, -E, E @ b, E @ b))
    assert refusal(decided, asked) == "accepted"
    E = np.array(far)
    for key, x in dict(E=E, A=-E, B=E @ b, B_w=E @ b).items():
        rows = [[decimal(float(e)) for e in row] for row in x]
        asked = put(asked, ["plant", "vertices", 1, key], rows)
    assert refusal(decided, asked) != "accepted"


@pytest.mark.parametrize("coupling", ["pairs", "slack"])
def test_a_bound_of_an_output_of_each_vertex_or_beside_an_integral(coupling):
    plain = {k: x for k, x in APART.items() if k not in ("D_u", "D_w")}
    of_each = (sos.DescriptorSystem(**x) for x in (APART, plain))
    h2 = [sos.H2(9.0)]
    for design in (
        *(sos.design_pid(x, gamma=5.0, coupling=coupling) for x in of_each),
        sos.design_pid(TWO, [[1.0]], requirements=h2, coupling=coupling),
    ):
        proof = design.certify()
        assert check(proof.text) == list(proof.claims)


@pytest.mark.parametrize("name, at", [("a", 0.25), ("b", 3)])
def test_a_refusal_at_a_corner_of_ranges_names_it(name, at):
    """No input moves the second mass, which falls too slowly at one end of a range."""

    def builder(v, m):
        rows = np.diag([0.3 * v, m if name == "a" else 3.25 - m]), np.eye(2)
        return sos.SecondOrderSystem(np.eye(2), *rows, [[1], [0]])

    family = sos.Uncertain(builder, v=(1, 2), m=(0.25, 3))
    region = sos.LMIRegion.half_plane(0.2)
    proof = sos.design_pid(family, region=region).infeasibility
    assert check(proof.text) == list(proof.claims)
    assert f"of the plant with v = 1 and m = {at}," in proof.claims[0]


def carts(m, s):
    """Two carts on springs: the second's mass and the first's spring differ."""
    S = [[1 + s, -1], [-1, 2]]
    return sos.SecondOrderSystem(
        np.diag([1, m]), 0.3 * np.eye(2), S, np.eye(2), np.eye(2)
    )


@pytest.mark.parametrize("norm, coupling", [("gamma", "pairs"), ("h2", "slack")])
def test_an_acceleration_is_that_of_a_mass_that_stays(norm, coupling):
    """Between two masses the inverse is no mean of theirs: of the cart whose mass
    differs nothing is proven by the blocks of vertices and pairs.
    """
    family = sos.Polytope([carts(1.0, 1.0), carts(1.6, 1.9)])
    rows = sos.Output(acceleration=[[1, 0]])
    bound = {
        "gamma": sos.HInfinity(200.0, outputs=rows, inputs=[1]),
        "h2": sos.H2(200.0, outputs=rows, inputs=[1]),
    }[norm]
    proof = sos.design_pid(family, requirements=[bound], coupling=coupling).certify()
    assert check(proof.text) == list(proof.claims)
    asked = {"kind": proof.kind} | {
        k: v for k, v in proof.data.items() if k not in ("claims", "blocks")
    }
    assert refusal(decided, asked) == "accepted"
    rows = [["1", "0.0001"]] if norm == "gamma" else [["0", "0.0001"]]
    other = put(asked, ["requirements", 0, "outputs", 0, "acceleration"], rows)
    other = put(other, ["requirements", 0, "inputs"], [int(norm == "gamma")])
    at = refusal(decided, other)
    assert at in needs() and "isn't an identity" in needs()[at][1]


def refused_for_all(parts, C_y, noise, reached):
    """The refusal of a bound for every controller with a sensor."""
    known = sos.DescriptorSystem(*parts)
    law = sos.DynamicLaw(1, C_y, noise=noise)
    _, proof = bound(known, law, reached)
    assert check(proof.text) == list(proof.claims)
    return proof


def test_a_limit_of_every_controller_counts_what_w_does_at_once():
    """Also of one state, whose motions are one; another sign of D or Z is refused."""
    rng = np.random.default_rng(0)
    A, B, b, c = (rng.normal(size=x).round(3) for x in ((3, 3), (3, 1), (3, 1), (1, 3)))
    parts = [np.eye(3), A, B, np.hstack([b, 0 * b]), np.vstack([c, 0 * c])]
    parts += [[[0], [0.3]], [[0.1, 0], [0, 0.05]]]
    proof = refused_for_all(parts, rng.normal(size=(1, 3)).round(2), [[0, 0.5]], 6.0)
    asked = json.loads(proof.text)["asks"]
    assert {*asked["sides"]} == {"X", "Y"}
    one = [[[1.0]], [[0.5]], [[1.0]], [[1.0, 0]], [[1.0], [0]], [[0], [0.3]]]
    proof = refused_for_all(one, [[1.0]], [[0, 0.5]], 6.0)
    assert len(proof.data["sides"]["X"]["here"]) == 1


def asked_of(proof):
    """What a proof asks, with its kind."""
    data = {k: v for k, v in proof.data.items() if k not in ("claims", "blocks")}
    return {"kind": proof.kind} | data


def test_a_form_grows_under_the_gain_that_is_given():
    """Also at a line that isn't upright, and with masses that aren't symmetric."""
    rows = [[2, 0.3], [0, 0.5]], [[0.02, 0.01], [-0.03, 0.05]], [[9.81, -1], [-0.7, 2]]
    plant = sos.SecondOrderSystem(*rows, np.eye(2))
    wild = np.array([[0, 0, 0.7, 0.1], [0, 0, 0, 0.3]])
    half, sector = sos.LMIRegion.half_plane(0), sos.LMIRegion.sector(0.6)
    for region in (half, sector):
        proof = growing(plant, region, wild).infeasibility
        assert check(proof.text) == list(proof.claims)
    asked = asked_of(growing(plant, half, wild).infeasibility)
    assert refusal(decided, asked) == "accepted"
    calm = [[decimal(-float(x)) for x in row] for row in wild]
    at = refusal(decided, put(asked, ["K"], calm))
    assert "isn't positive" in needs()[at][1]


def test_a_disk_at_ticks_is_stability_where_it_lies_in_the_unit_disk():
    plant = sos.DescriptorSystem(np.eye(2), [[1, 0.1], [0.2, 1]], [[0], [1]], dt=0.1)
    for rho, centre in ((0.9, 0.3), (0.5, 0.5), (0.7, -0.3), (0.9, -0.3)):
        region = sos.LMIRegion.disk(rho, centre)
        proof = sos.design_pid(plant, region=region).certify()
        assert check(proof.text) == list(proof.claims)
        blocks = {x for x in json.loads(proof.text)["text"] if "stab" in x}
        assert bool(blocks) is (rho + abs(centre) > 1)


def test_a_norm_at_ticks_is_to_one_output_of_all_vertices():
    """C and D_w stand at each vertex, and must be alike there."""
    more = dict(C=[[[1, 0]]] * 2, D_w=[[[0.3]]] * 2, D_u=[[[0.1]]] * 2)
    several = APART | more | dict(B_w=[[0], [0.5]])
    proof = sos.certify_sampled(
        sos.DescriptorSystem(**several), [[-0.2, -0.3]], T=0.1, norm=sos.HInfinity(99.0)
    )
    assert check(proof.text) == list(proof.claims)
    asked = asked_of(proof)
    assert refusal(decided, asked) == "accepted"
    for name, x in dict(C=[["1", "0.01"]], D_w=[["0.31"]], D_u=[["0.11"]]).items():
        other = put(asked, ["plant", "vertices", 1, name], x)
        at = refusal(decided, other)
        assert "isn't an identity" in needs()[at][1]


def test_eight_plants_are_a_sampled_box_where_its_sides_are_alike():
    """Plants without parameters: a corner that is elsewhere, or in another's place, is
    no corner of a box."""
    plants = sos.Polytope(
        sos.SecondOrderSystem([[m]], [[d]], [[k]], [[b]])
        for m, b in ((1, 1), (1.01, 1.02))
        for d in (0.3, 0.32)
        for k in (1, 1.03)
    )
    proof = sos.certify_sampled(plants, [[-1, -1.5]], T=0.3)
    assert check(proof.text) == list(proof.claims)
    asked = asked_of(proof)
    order = asked["corners"]
    assert sorted(order) == [*range(8)] and "parameters" not in asked["plant"]
    elsewhere = dict(M=1.0101, D=0.3101, S=1.0101, B=1.0101)
    for vertex, name in [*enumerate(["M", "D", "S", "B"] * 2), (7, "M"), (0, "B")]:
        path = ["plant", "vertices", vertex, name]
        at = refusal(decided, put(asked, path, [[f"{elsewhere[name]}"]]))
        assert "isn't an identity" in needs()[at][1], path
    for i in range(7):
        other = list(order)
        other[i], other[i + 1] = other[i + 1], other[i]
        assert refusal(decided, put(asked, ["corners"], other)) != "accepted"


def test_the_names_of_a_program_are_those_of_the_plant():
    """Of two inputs, of an integral, of a plant of first order; no other is taken."""
    two = sos.SecondOrderSystem(np.eye(2), np.eye(2), [[3, -1], [-1, 2]], np.eye(2))
    first = sos.DescriptorSystem(np.diag([1, 2]), [[-1, 0.2], [0, -1]], [[1], [0]])
    z, u = ["z1", "z2", "z1'", "z2'"], ["u1", "u2"]
    law = np.hstack([-np.eye(2), -np.eye(2), [[-0.1], [0]]])
    for plant, U, D, inputs, outputs in (
        (two, [[1, 0]], law, [*z, "integral of z1"], u),
        (two, [[0.5, 2]], law, [*z, "integral of 0.5 z1 + 2 z2"], u),
        (two, None, law[:, :4], z, u),
        (first, None, [[-0.5, 0]], ["x1", "x2"], ["u"]),
    ):
        K = SampledSystem([], [], [], D, 0.1, inputs=inputs, outputs=outputs)
        proof = sos.certify_sampled(plant, K, T=0.1, U=U)
        assert check(proof.text) == list(proof.claims)
        for where in ("inputs", "outputs"):
            other = put(asked_of(proof), ["K", where, 0], "another")
            at = refusal(decided, other)
            assert at in needs(), at


@pytest.mark.parametrize(
    "name, how, words",
    [
        ("scheduled", [[["plant", "schedule"], ["m", "m"]]], "is no parameter"),
        ("reduced", [[["plant", "reduced"], [2, 2]]], "nothing is left out"),
        ("sampled, masses, a simplex", [[["corners"], [0, 1, 2]]], "of a box are the"),
        ("sampled, a law that reads w", [[["corners"], [0, 1]]], "of a box are the"),
    ],
)
def test_what_is_measured_twice_left_whole_or_no_box_is_refused(name, how, words):
    decided(base(name))
    assert words in needs()[refusal(decided, changed(name, how))][1]


@pytest.mark.parametrize("s, right", [("1/2", True), ("0", True), ("-1/2", False)])
def test_a_response_counts_where_every_loop_that_is_stable_is_bounded(s, right):
    """Left of the axis, also above its middle, the norm says nothing of it."""
    asked = base("a given loop's response")
    values = verdict.text_of(asked)[0].values()
    E, A, B, C, K = (values[x] for x in ("E.1", "A.1", "Bu.1", "C", "K"))
    y = arithmetic.Mat(1, C.r, [[1] * C.r])
    loop = E.times(Fraction(s)) + (A + B @ K).times(Fraction(-1))
    v = y @ C @ arithmetic.inverse(loop)
    rows = [[str(v.at(0, k)) for k in range(v.c)], ["0"] * v.c]
    asked = put(asked, ["bound"], decimal(1e-6))
    for key, x in dict(s=[[s], ["0"]], v=rows, y=[["1"] * C.r, ["0"] * C.r]).items():
        asked = put(asked, [key], x)
    at = refusal(decided, asked)
    assert (at == "accepted") is right
    assert right or "isn't positive" in needs()[at][1]


def test_a_functional_of_order_two_and_boxes_are_read_as_they_are_written():
    late = sos.analyse_delay(LOOP, tau=2.0, method="legendre", order=2).certify()
    for proof in (late, proof_of("known gain, in a box"), near_a_box()):
        assert check(proof.text) == list(proof.claims)


def test_eight_plants_are_a_box_of_a_known_gain_where_its_sides_are_alike():
    """A corner of three parameters that is elsewhere, or in another's place."""
    plants = sos.Polytope(
        sos.SecondOrderSystem([[m]], [[d]], [[k]], [[1]])
        for m in (0.3, 9.81)
        for d in (0.3, 2.5)
        for k in (1, 3.3)
    )
    region = sos.LMIRegion.half_plane(0.01)
    proof = sos.analyse_pid(
        plants, [[-1, -1.5]], region=region, coupling="multipliers"
    ).certify()
    assert check(proof.text) == list(proof.claims)
    asked = asked_of(proof)
    order = asked["corners"]
    assert sorted(order) == [*range(1, 9)]
    for vertex, name in enumerate(["M", "D", "S", "B"] * 2):
        (((old,),)) = asked["plant"]["vertices"][vertex][name]
        path = ["plant", "vertices", vertex, name]
        other = put(asked, path, [[decimal(float(old) + 1e-4)]])
        assert "isn't an identity" in needs()[refusal(decided, other)][1], path
    for i in range(7):
        other = list(order)
        other[i], other[i + 1] = other[i + 1], other[i]
        assert refusal(decided, put(asked, ["corners"], other)) != "accepted"


@pytest.mark.parametrize("seed", seeds(20))
def test_a_ball_of_a_product_encloses_the_products_of_its_ends(seed):
    """Of one entry, exactly: both ends of a ball, times a number or another ball."""
    rng = np.random.default_rng(seed)
    unit = 1 << arithmetic.BALL

    def one(e):
        a = int(rng.integers(-(2**62), 2**62)) << 68
        return arithmetic.Mat(1, 1, [[a + int(rng.integers(2**62))]], unit, e)

    def ends(x):
        return [Fraction(x.a[0][0] + s * x.e, x.d) for s in (-1, 1)]

    def encloses(x, values):
        low, high = ends(x)
        return low <= min(values) and max(values) <= high

    for _ in range(100):
        e = int(rng.integers(1, 9)) << int(rng.integers(0, 100))
        f = Fraction(int(rng.integers(-(10**6), 10**6)), int(rng.integers(1, 10**6)))
        x, y = one(e), one(int(rng.integers(0, 2)) * (e // 3 + 1))
        assert encloses(x.times(f), [f * a for a in ends(x)])
        for p, q in ((x, y), (y, x)):
            assert encloses(p @ q, [a * b for a in ends(p) for b in ends(q)])


def test_pairs_of_vertices_that_a_refusal_or_a_family_needs_are_the_only_ones():
    """Two stable plants, of which the one between isn't; a mass along one column that
    moves with another parameter; and a size of a norm that is known."""
    E = [np.eye(2), [[1.2, -1], [0.6, 0.6]]]
    A = [[-1.5, -1.8], [0.7, -0.2]], [[-0.3, 1.6], [-0.2, 0.1]]
    loop = sos.DescriptorSystem(E, A)
    none = np.zeros((0, 2))
    between = sos.analyse_pid(loop, none, coupling="pairs").infeasibility
    assert any(len(name) == 5 for name, _ in between.data["multipliers"])
    assert check(between.text) == list(between.claims)

    def builder(a, b):
        E = [[2 + a * b + b, 0.1], [a * b - 0.3 * a, 1]]
        return sos.DescriptorSystem(E, [[-1, 0.3], [0.2, -2]], np.eye(2), np.eye(2))

    proof = sos.design_pid(sos.Uncertain(builder, a=(0.1, 0.6), b=(0.2, 1))).certify()
    assert check(proof.text) == list(proof.claims)
    corners = [[str(k)] * 2 for k in (1, 2, 3, 4)]
    assert json.loads(proof.text)["sets"]["pairs"] == corners
    asked = asked_of(proof)
    assert refusal(decided, asked) == "accepted"
    other = put(asked, ["plant", "A", 0, 0], "-1 + 0.1*a")
    assert refusal(decided, other) != "accepted"
    norm = sos.HInfinity(5.0, mu=2.0)
    proof = sos.design_pid(TWO, requirements=[norm]).certify()
    assert check(proof.text) == list(proof.claims)
    assert not any("mu = " in claim for claim in proof.claims)
