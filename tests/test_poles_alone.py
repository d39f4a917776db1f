"""One plant of which only the poles are asked is decided, also where floats end.

The plants are none that the placement was made with; whether a pole lies where it
should is computed by mpmath, and files are read by the checker that stands alone.
"""

import mpmath
import numpy as np
import pytest

import sosbook as sos
from benchmarks.plants import beam
from benchmarks.robustness import SYSTEMS, asked_in_units
from sosbook.exact.proof_text import written
from sosbook.proofs.check import Refused, check
from sosbook.synthesis.certificates import prove
from sosbook.synthesis.exclusion import solvable
from sosbook.synthesis.placement import placed_gain
from sosbook.synthesis.pole_proof import decided_by_poles
from sosbook.synthesis.problem import Request
from sosbook.synthesis.rounding import modes_by_rounding
from tests.random_plants import ODD, random_case

UNITS = {"N, m": (1, 1, 1), "odd": ODD, **SYSTEMS}


def modal(seed, gap, inputs=1):
    """Masses with frequencies of which two are nearly alike, and their mixture."""
    rng = np.random.default_rng([seed, 161])
    n = int(rng.integers(2, 6))
    omega = rng.uniform(0.5, 20, n)
    omega[1] = omega[0] * (1 + gap)
    zeta, mass = rng.uniform(0.001, 0.02, n), rng.uniform(0.5, 3, n)
    zeta[1] = zeta[0]
    return sos.SecondOrderSystem(
        np.diag(mass),
        np.diag(2 * zeta * omega * mass),
        np.diag(omega**2 * mass),
        rng.uniform(0.5, 1, (n, inputs)),
    )


def string(n, seed):
    """Unequal masses between unequal springs, pushed at one end."""
    rng = np.random.default_rng([seed, 162])
    k = rng.uniform(0.5, 2, n + 1)
    S = np.diag(k[:-1] + k[1:]) - np.diag(k[1:-1], 1) - np.diag(k[1:-1], -1)
    M = np.diag(rng.uniform(0.5, 2, n))
    return sos.SecondOrderSystem(M, 0.01 * M, S, np.eye(n)[:, -1:])


def true_poles(plant, K, U=None):
    (d,) = Request(plant, U).vertices

    def matrix(x):
        return mpmath.matrix([[mpmath.mpf(repr(float(e))) for e in r] for r in x])

    with mpmath.workdps(120):
        A = matrix(d.E) ** -1 * (matrix(d.A) + matrix(d.Bu) * matrix(K))
        return np.array([complex(s) for s in mpmath.eig(A, left=False, right=False)])


def inside(poles, region):
    """The parts of a `PoleRegion` by themselves, by name."""
    sigma, theta, rho = (region.get(name) for name in ("sigma", "theta", "rho"))
    return (
        (poles.real < -(sigma or 0)).all()
        and (theta is None or (abs(np.angle(-poles)) < theta).all())
        and (rho is None or (abs(poles) < rho).all())
    )


def in_region(plant, region, U=None):
    """A design that does what is asked, by everything that can be asked."""
    asked = {"region": sos.PoleRegion(**region)} | ({} if U is None else {"U": U})
    d = sos.design_pid(plant, **asked)
    assert d.status == "feasible", d.reason
    proof = d.certify()
    assert proof.proven and proof.verify(), str(proof)
    assert list(proof.claims) == check(proof.text)
    assert inside(true_poles(plant, proof.K, U), region)
    assert min(d.margins.values()) > 0
    return d, asked


@pytest.mark.parametrize("gap", [1e-5, 1e-8, 1e-11])
@pytest.mark.parametrize("seed", range(3))
def test_close_frequencies(seed, gap):
    plant = modal(seed, gap)
    in_region(plant, {"sigma": 1.0})


@pytest.mark.parametrize("unit", UNITS)
@pytest.mark.parametrize("region", [{"sigma": 0.5}, {"sigma": 0.3, "rho": 30}])
def test_close_frequencies_in_any_unit(unit, region):
    plant = modal(7, 1e-9)
    asked = {"region": sos.PoleRegion(**region)}
    other, there = asked_in_units(plant, asked, *UNITS[unit])
    d = sos.design_pid(other, **there)
    assert d.status == "feasible", d.reason
    assert d.certify().proven


@pytest.mark.parametrize("n, sigma", [(6, 4.0), (8, 3.0)])
def test_strings_of_masses(n, sigma):
    in_region(string(n, n), {"sigma": sigma})


def test_a_beam_and_integrators():
    plant, _ = beam(3)
    in_region(plant, {"sigma": 20.0})
    near = modal(3, 1e-8)
    in_region(near, {"sigma": 0.2}, U=np.eye(near.n)[:1])


def test_two_inputs_that_are_nearly_one():
    plant = modal(5, 0.0, inputs=2)
    B = np.hstack([plant.B[:, :1], plant.B[:, :1] + 1e-9 * plant.B[:, 1:]])
    same = sos.SecondOrderSystem(plant.M, plant.D, plant.S, B)
    in_region(same, {"sigma": 1.0})


@pytest.mark.parametrize("part", [1e-6, 1e-8, 1e-9, 1e-10])
def test_margins_below_rounding_are_those_of_the_exact_blocks(part):
    """Floats know neither their size nor their sign; mpmath's eigenvalues do."""
    plant = modal(5, 0.0, inputs=2)
    B = np.hstack([plant.B[:, :1], plant.B[:, :1] + part * plant.B[:, 1:]])
    same = sos.SecondOrderSystem(plant.M, plant.D, plant.S, B)
    d = sos.design_pid(same, region=sos.PoleRegion(sigma=1.0))
    assert 0 < min(d.margins.values()) < 1e-9  # what floats are trusted with
    proof = prove(d.request, d.K, d.P, 17)
    assert proof.proven and proof.margins() == d.margins
    values = proof.data["unknowns"]["P"]
    with mpmath.workdps(80):
        P = mpmath.matrix([[mpmath.mpf(x) for x in row] for row in values])
        scale = [1 / mpmath.sqrt(P[i, i]) for i in range(len(P))]
        for i in range(len(P)):
            for j in range(len(P)):
                P[i, j] *= scale[i] * scale[j]
        least = min(mpmath.eigsy(P, eigvals_only=True))
    assert 0.2 < d.margins["P"] / float(least) < 5  # diagonals of one, or nearly


def test_a_mass_that_acceleration_makes_regular():
    near = modal(2, 1e-9)
    M = near.M - near.B @ np.ones((1, near.n))
    plant = sos.SecondOrderSystem(M, near.D, near.S, near.B)
    d = sos.design_pid(
        plant, region=sos.PoleRegion(sigma=0.5), K_A=-np.ones((1, near.n))
    )
    assert d.status == "feasible" and d.certify().proven


def test_a_descriptor_system():
    E, A = np.diag([1.0, 2.0, 3.0]), np.diag([1.0, 2.0 + 2e-10, 3.0])
    plant = sos.DescriptorSystem(E, A, np.ones((3, 1)))
    A[2, 2] = -0.5
    d = sos.design_pid(sos.DescriptorSystem(E, A, np.ones((3, 1))))
    assert plant.order == 3
    assert d.status == "feasible" and d.certify().proven


def test_a_mode_out_of_reach_that_may_stay():
    """The part that inputs reach is placed, the rest is where it should be."""
    near = modal(1, 1e-9)
    n = near.n + 1

    def grown(x, last):
        whole = np.zeros((n, n))
        whole[:-1, :-1], whole[-1, -1] = x, last
        whole[:-1, -1] = 0.1 * last
        return whole

    plant = sos.SecondOrderSystem(
        grown(near.M, 1.0), grown(near.D, 3.0), grown(near.S, 4.0),
        np.vstack([near.B, [[0.0]]]),
    )  # fmt: skip
    request = Request(plant, region=sos.PoleRegion(sigma=0.5))
    K = placed_gain(request)
    assert K is not None and inside(true_poles(plant, K), {"sigma": 0.5})
    in_region(plant, {"sigma": 0.5})
    d = sos.design_pid(plant, region=sos.PoleRegion(sigma=2))
    assert d.status == "infeasible" and d.infeasibility.proven


def test_masses_that_no_direction_controls():
    """Two equal masses with a force each need a first feedback."""
    two = sos.SecondOrderSystem(np.eye(2), 0 * np.eye(2), np.eye(2), np.eye(2))
    request = Request(two, region=sos.PoleRegion(sigma=0.5, rho=3))
    K = placed_gain(request)
    assert inside(true_poles(two, K), {"sigma": 0.5, "rho": 3})
    assert decided_by_poles(request).status == "feasible"


@pytest.mark.parametrize("region", [
    {"sigma": 1.0, "rho": 1.02},
    {"theta": 1e-3},
    {"sigma": 0.5, "rho": 2, "theta": 0.5},
])  # fmt: skip
def test_thin_regions(region):
    plant = string(3, 1)
    request = Request(plant, region=sos.PoleRegion(**region))
    assert inside(true_poles(plant, placed_gain(request)), region)


def test_a_given_gain_is_decided_by_its_poles():
    plant = modal(4, 1e-10)
    region = sos.PoleRegion(sigma=1)
    K = placed_gain(Request(plant, region=region))
    d = sos.analyse_pid(plant, K, region=region)
    assert d.status == "feasible" and (d.K == K).all()
    assert d.certify().proven and (d.certify().K == K).all()
    slowest = -true_poles(plant, K).real.max()
    above = sos.analyse_pid(plant, K, region=sos.PoleRegion(sigma=1.01 * slowest))
    assert above.status == "infeasible" and above.infeasibility.proven
    below = sos.analyse_pid(plant, K, region=sos.PoleRegion(sigma=0.99 * slowest))
    assert below.status == "feasible" and below.certify().proven


def test_what_no_float_does_is_undecided():
    plant = modal(0, 0.0)
    S = plant.S.copy()
    S[1, 1], D = S[0, 0] * (1 + 2**-52), plant.D.copy()
    M = np.eye(plant.n)
    D[:2, :2] = 0.001 * np.eye(2)
    near = sos.SecondOrderSystem(M, D, S, plant.B)
    request = Request(near, region=sos.PoleRegion(sigma=1, theta=0.3))
    d = sos.design_pid(near, region=sos.PoleRegion(sigma=1, theta=0.3))
    assert solvable(request) and d.status == "undecided"
    assert "a gain exists" in d.reason


def test_a_changed_digit_is_refused():
    """Of P's long numbers one digit is moved, and the checksum mended."""
    plant = modal(0, 1e-13)
    proof = sos.design_pid(plant, region=sos.PoleRegion(sigma=1)).certify()
    data = proof.data
    P = data["unknowns"]["P"]
    long = max((e for row in P for e in row), key=len)
    assert len(long.lstrip("-").split("e")[0]) > 17
    for change in (
        lambda x: str(int(x[0]) % 9 + 1) + x[1:] if x[0] != "-" else x[1:],
        lambda x: x.replace("e", "0e"),
        lambda x: x + "0",
        lambda x: x.partition("e")[0] + ".0e" + x.partition("e")[2],
    ):
        rows = [[change(e) if e == long else e for e in row] for row in P]
        changed = dict(data, unknowns={"P": rows})
        assert not type(proof)(written("design", changed)).proven
    P[0][0] = "1" * 2000 + "e-7"
    with pytest.raises(Refused):
        check(written("design", dict(data, unknowns={"P": P})))


@pytest.mark.parametrize(
    "seed",
    [9011, *(pytest.param(x, marks=pytest.mark.slow) for x in (9029, 9127, 9130))],
)
def test_no_gain_lives_on_rounding_errors(seed):
    """A turned plant has a mode within reach by rounding: undecided in all units.

    In decimals each of the plants has a gain; whose, depends on the last digits.
    """
    case = random_case(seed, 6)
    assert "but for rounding" in case.reason
    for units in UNITS.values():
        plant, asked = asked_in_units(case.plant, case.requirements, *units)
        request = Request(plant, **asked)
        assert solvable(request) and modes_by_rounding(request)
        d = sos.design_pid(plant, **asked)
        assert d.status == "undecided" and "last digits" in d.reason


@pytest.mark.parametrize("unit", UNITS)
@pytest.mark.parametrize("push", [1e-15, 1e-30])
def test_a_small_number_is_no_rounding_error(unit, push):
    """An input that hardly moves a mode does move it."""
    plant = sos.SecondOrderSystem(
        np.diag([2.0, 3]), np.diag([0.3, 0.2]), np.diag([5.0, 7]), [[1.0], [push]]
    )
    asked = {"region": sos.PoleRegion(sigma=0.3)}
    plant, asked = asked_in_units(plant, asked, *UNITS[unit])
    assert modes_by_rounding(Request(plant, **asked)) == []
    d = sos.design_pid(plant, **asked)
    assert d.status == "feasible" and d.certify().proven


@pytest.mark.parametrize("gap, found", [(1e-9, 0), (1e-12, 0), (1e-15, 2), (0.0, 2)])
def test_a_mode_is_within_reach_by_digits_or_by_rounding(gap, found):
    """Two masses pushed alike: their difference is moved by the gap alone."""
    S = [[2.0, -1.0], [-1.0, 2.0]]
    plant = sos.SecondOrderSystem(np.eye(2), np.zeros((2, 2)), S, [[1.0], [1.0 - gap]])
    request = Request(plant, region=sos.PoleRegion(sigma=0.5))
    assert len(modes_by_rounding(request)) == found
    still = Request(plant, region=sos.PoleRegion(rho=5))
    assert len(modes_by_rounding(still)) == found  # on the axis, which breaks it, too
