"""A gamma below what no input reaches is refused, and no other."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import sosbook as sos
from benchmarks.robustness import SYSTEMS, asked_in_units
from sosbook.proofs import UnreachedResponseRefusal
from sosbook.synthesis.request import Request
from sosbook.synthesis.unreached import refuse_by_response
from tests.cases import crossed, seeds
from tests.least_norm import least_norm
from tests.random_plants import ODD, ODD_POWERS, as_units

UNITS = {"N, m": (1, 1, 1), "odd": ODD, **SYSTEMS}


def plant(seed):
    """2 to 4 masses with fewer inputs, and the least norm of any loop."""
    rng = np.random.default_rng(900 + seed)
    n = int(rng.integers(2, 5))
    m = int(rng.integers(1, n))
    X, Y, Z = rng.normal(size=(3, n, n))
    parts = (X @ X.T + np.eye(n), 0.1 * Y @ Y.T + 0.1 * np.eye(n), Z @ Z.T + np.eye(n))
    parts = (*parts, rng.normal(size=(n, m)), rng.normal(size=(n, 2)))
    return sos.SecondOrderSystem(*parts), least_norm(*parts)


@pytest.mark.parametrize("seed", seeds(8))
def test_the_bound_is_exact(seed):
    one, bound = plant(seed)
    U = np.eye(one.n)[:1] if seed % 2 else None
    assert refuse_by_response(Request(one, U, gamma=1.01 * bound)) is None
    proof = refuse_by_response(Request(one, U, gamma=0.97 * bound))
    assert proof.proven and proof.verify()


@pytest.mark.parametrize("unit", [1e-6, 1.0, 1e6, *ODD])
def test_units_and_vertices_do_not_matter(unit):
    one, bound = plant(1)
    other, _ = plant(1)
    soft = sos.SecondOrderSystem(
        other.M * unit, 2 * other.D * unit, other.S * unit, other.B, other.F * unit
    )
    hard = sos.SecondOrderSystem(
        one.M * unit, one.D * unit, one.S * unit, one.B, one.F * unit
    )
    both = Request(sos.Polytope([soft, hard]), gamma=0.97 * bound)
    assert refuse_by_response(both).data["vertex"] == 1


def test_inputs_that_reach_everything_exclude_nothing():
    full = sos.SecondOrderSystem(*[np.eye(2)] * 5)
    assert refuse_by_response(Request(full, gamma=1e-9)) is None


@settings(max_examples=10, deadline=None, derandomize=True, database=None)
@example(11, ODD_POWERS)
@given(st.integers(0, 40), st.tuples(*5 * [st.floats(-9, 9)]))
def test_no_units_hide_a_response(seed, powers):
    one, bound = plant(seed)
    there = as_units(one, powers, 0)
    for factor, excluded in ((0.97, True), (1.01, False)):
        asked = there.requirements({"gamma": factor * bound})
        proof = refuse_by_response(Request(there.plant(one), **asked))
        assert (proof is not None) == excluded


def test_integrators_hold_what_they_integrate():
    """At rest U z = 0: the input stands still only where it holds one coordinate."""
    one = sos.SecondOrderSystem(
        np.eye(2), np.eye(2), [[2.0, -1], [-1, 2]], [[1.0], [0]], [[0.0], [1]]
    )
    held = Request(one, [[0.0, 1]], gamma=0.9)  # z1 = -1 at rest, z2 = 0
    free = Request(one, gamma=0.9)
    assert refuse_by_response(held).proven
    assert refuse_by_response(free) is None


@pytest.mark.parametrize(
    "spring, unit",
    crossed([(1.0, 2e-6), (0.3, 2e-6), (0.3, 0.4), (1e-3, 2e-6), (0.0, 2e-6)], UNITS),
)
def test_the_peak_between_frequencies_is_found(spring, unit):
    """The least norm is 1 / |(k_c, k - w^2 + jwd)| at the worst w, in closed form."""
    (coupling, damping), k = spring, 2.0
    plant = sos.SecondOrderSystem(
        np.eye(2), [[0.1, 0], [0, damping]], [[1, -coupling], [-coupling, k]],
        [[1.0], [0.0]], [[0.0], [1.0]],
    )  # fmt: skip
    peak = 1 / np.sqrt(coupling**2 + damping**2 * (k - damping**2 / 4))
    for share, excluded in [(1 - 1e-9, True), (1 + 1e-9, False)]:
        there, asked = asked_in_units(plant, {"gamma": share * peak}, *UNITS[unit])
        proof = refuse_by_response(Request(there, **asked))
        assert (proof is not None and proof.verify()) == excluded


def test_the_norm_of_a_given_loop_is_found():
    """|1 / (1 - w^2 + 0.6jw)| is largest well below the pole."""
    one = sos.SecondOrderSystem([[1.0]], [[0.6]], [[1.0]], [[1.0]], [[1.0]])
    norm = 1 / (0.6 * np.sqrt(1 - 0.09))
    d = sos.analyse_pid(one, [[0.0, 0.0]], gamma=(1 - 1e-9) * norm)
    assert d.status == "infeasible" and d.infeasibility.proven
    assert sos.analyse_pid(one, [[0.0, 0.0]], gamma=1.001 * norm).status == "feasible"


def test_an_output_that_is_always_zero_hides_nothing():
    A = [[0, 0, 1, 0], [0, 0, 0, 1], [-2, 1, -0.1, 0], [1, -2, 0, -0.1]]
    B, B_w = [[0], [0], [1], [0]], [[0], [0], [0.3], [1]]
    C = [[1, 0, 0, 0], [0, 0, 0, 0], [0, 1, 0, 0]]
    plant = sos.DescriptorSystem(np.eye(4), A, B, B_w, C)
    design = sos.design_pid(plant, gamma=0.1)
    assert design.status == "infeasible"
    assert isinstance(design.infeasibility, UnreachedResponseRefusal)


@pytest.mark.parametrize("s, proven", [(0, True), ("1/1000", True), ("-9/10", False)])
def test_a_response_left_of_the_axis_bounds_no_norm(s, proven):
    """1 / (1 + s) (2 + s) is never above 1/2 in the right half-plane, but 9 at -0.9."""
    one = sos.SecondOrderSystem([[1]], [[3]], [[2]], [[1]], [[1]])
    s = Fraction(s)
    there = 1 / ((1 + s) * (2 + s))
    gamma = float(0.999 * there)
    request = sos.analyse_pid(one, [[0.0, 0.0]], gamma=gamma).request
    v, y = [[(3 + s) * there, there], [0, 0]], [[1], [0]]
    data = UnreachedResponseRefusal.contents(
        request, request.owner("gamma"), 0, [[s], [0]], v, y
    )
    file = UnreachedResponseRefusal.of(data)
    assert file.proven == file.verify() == proven
