"""Multipliers are made exact part by part where blocks share a border only."""

import numpy as np
import pytest
from flint import fmpq

import sosbook as sos
from sosbook.exact import repair as repair_module
from sosbook.exact.adjoint import adjoint
from sosbook.exact.definite import exact, in_floats, positive
from sosbook.exact.repair import _parts, repair_multipliers
from sosbook.lmi import Unknown, he
from sosbook.solver.blocks import Blocks
from sosbook.solver.loop import phase_one
from tests.test_arrow import springs


def star(count, n=2):
    """Blocks that no X_k and S fulfil: every second one wants another sign of S."""
    rng = np.random.default_rng(count)
    S, one = Unknown("S", n), exact(np.eye(n))
    expressions, unknowns = [], [S]
    for k in range(count):
        A = exact(np.round(np.eye(n) + 0.1 * rng.standard_normal((n, n)), 2))
        X = Unknown(f"X{k}", n, symmetric=True)
        unknowns.append(X)
        sign = fmpq((-1) ** k)
        expressions += [one @ X - one, one / 2 - A @ X @ A.T + he(sign * one @ S)]
    return expressions, unknowns


def multipliers(expressions, unknowns):
    phase = phase_one(Blocks([in_floats(g) for g in expressions], unknowns))
    assert phase.verdict == "infeasible"
    return phase.Z


def parts_of(expressions, unknowns):
    """The parts in which multipliers are repaired, by the unknowns' names."""
    (parts,) = _parts(expressions, unknowns)
    return [([unknowns[k].name for k in p.unknowns], p.blocks) for p in parts]


def test_the_parts_share_the_border_only():
    expressions, unknowns = star(3)
    wanted = [(["S", f"X{k}"], [2 * k, 2 * k + 1]) for k in range(3)]
    assert parts_of(expressions, unknowns) == wanted


def test_one_vertex_has_no_parts():
    expressions, unknowns = star(1)
    assert _parts(expressions, unknowns) == []


@pytest.fixture
def sizes(monkeypatch):
    """How many blocks each repair had."""
    found, change = [], repair_module._change

    def noted(expressions, *more):
        found.append(len(expressions))
        return change(expressions, *more)

    monkeypatch.setattr(repair_module, "_change", noted)
    return found


def check(expressions, unknowns, repaired):
    Z, value = repaired
    assert all(map(positive, Z)) and value <= 0
    assert not adjoint(expressions, unknowns, Z).any()


@pytest.mark.parametrize("count", [2, 5])
def test_each_part_cancels_its_share(count, sizes):
    expressions, unknowns = star(count)
    Z = multipliers(expressions, unknowns)
    check(expressions, unknowns, repair_multipliers(expressions, unknowns, Z))
    assert sizes == [2] * count


@pytest.mark.parametrize("fails", ["a system", "a multiplier"])
def test_where_a_part_cannot_all_blocks_do_together(fails, sizes, monkeypatch):
    if fails == "a system":
        noted = repair_module._change

        def for_all(expressions, *more):
            return noted(expressions, *more) if len(expressions) > 2 else None

        monkeypatch.setattr(repair_module, "_change", for_all)
    else:
        stays = repair_module._stays_positive
        monkeypatch.setattr(
            repair_module, "_stays_positive", lambda *z: len(sizes) > 3 and stays(*z)
        )
    expressions, unknowns = star(3)
    Z = multipliers(expressions, unknowns)
    check(expressions, unknowns, repair_multipliers(expressions, unknowns, Z))
    assert sizes[-1] == 6


def test_what_is_too_large_is_not_repaired(monkeypatch):
    expressions, unknowns = star(3)
    Z = multipliers(expressions, unknowns)
    monkeypatch.setattr(repair_module, "MOST_NUMBERS", 10)
    assert repair_multipliers(expressions, unknowns, Z) is None


def test_blocks_of_the_border_alone_belong_to_no_part(sizes):
    expressions, unknowns = star(2)
    one = exact(np.eye(2))
    expressions.append(10 * one - he(one @ unknowns[0]))
    assert [blocks for _, blocks in parts_of(expressions, unknowns)] == [[0, 1], [2, 3]]
    Z = multipliers(expressions, unknowns)
    check(expressions, unknowns, repair_multipliers(expressions, unknowns, Z))
    assert sizes == [2, 2]


@pytest.mark.parametrize("vertices", [2, 5])
def test_a_slack_request_is_refuted_vertex_by_vertex(vertices, sizes):
    plant, asked = springs(vertices, region=sos.PoleRegion(3.0, rho=3.1))
    found = sos.design_pid(plant, **asked)
    assert found.status == "infeasible" and found.infeasibility.proven
    held = {v for name in found.infeasibility.multipliers for v in name.vertices}
    assert len(held) > 1 and sizes == [sizes[0]] * len(held)


def test_sums_of_rationals_don_t_depend_on_the_order_of_denominators():
    X = Unknown("X", 2, symmetric=True)
    one = exact(np.eye(2))
    Z = [one / 3, one / 7, one * fmpq(2, 7), one * fmpq(5, 21), one]
    expressions = [one @ X, -one @ X, one @ X, one @ X / 11, one @ X * fmpq(1, 2)]
    wanted = fmpq(1, 3) + fmpq(1, 7) + fmpq(5, 231) + fmpq(1, 2)
    for order in ([0, 1, 2, 3, 4], [3, 4, 1, 0, 2]):
        found = adjoint([expressions[k] for k in order], [X], [Z[k] for k in order])
        assert found.tolist() == [wanted, 0, wanted]


@pytest.mark.parametrize("unit", [1.0, 0.3, 9.81])
@pytest.mark.parametrize("bounded", [True, False])
def test_what_one_sum_has_alone_isn_t_solved_with_the_others(bounded, unit):
    """P > 0 has an entry for each sum of P; bounds of u and gamma one for Y's."""
    plant = sos.SecondOrderSystem(
        M=np.diag([2.0, 1.0]) * unit,
        D=[[0.4, -0.1], [-0.3, 0.2]],
        S=[[6.0, -2.0], [-2.0, 4.0]],
        B=np.eye(2),
        F=np.eye(2),
    )
    asked = dict(region=sos.PoleRegion(1.0, rho=3.1), gamma=0.01 / unit)
    if bounded:
        asked = dict(
            region=sos.PoleRegion(3.0, rho=3.1),
            saturation=sos.Saturation(5, np.ones(4)),
        )
    refusal = sos.design_pid(plant, **asked).infeasibility
    assert refusal.proven and refusal.verify()
    digits = max(len(str(e)) for Z in refusal.multipliers.values() for e in Z.flat)
    assert digits < 180  # solved together with the others: 196 to 297
