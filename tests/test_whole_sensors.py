"""A sensor on the whole plant sees what a part of it has left out: own eigenvalues."""

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.linalg import block_diag

import sosbook as sos
from sosbook.laws.full_state import FullState
from sosbook.laws.shaped import Filter, ShapedLaw
from sosbook.plants import sparse
from sosbook.plants.as_data import plant_data, read_plant
from tests.cases import by_hand, crossed, later
from tests.test_reduction import beam


def sharp(unit, kind, monkeypatch):
    """A beam with little damping, its actuator at one node, and a row of the next."""
    plant = beam(unit=unit)
    B, row = np.eye(plant.n)[:, [8]] * unit, np.eye(plant.n)[[10]]
    matrices = plant.M, 0.01 * plant.D, plant.S
    if kind == "sparse":
        monkeypatch.setattr(sparse, "MOST_DENSE", 5)
        matrices = map(sp.csc_array, matrices)
    return sos.SecondOrderSystem(*matrices, B), row


def poles(plant, rows, A, B, C, D):
    """Those of the loop with x_c' = A x_c + B y, u = C x_c + D y, of y = rows x."""
    if sp.issparse(plant.M):
        plant = [x.toarray() for x in (plant.M, plant.D, plant.S)] + [plant.B]
        plant = sos.SecondOrderSystem(*map(np.asarray, plant))
    own, push = by_hand(plant)
    top = np.hstack([own + push @ D @ rows, push @ C])
    return np.linalg.eigvals(np.vstack([top, np.hstack([B @ rows, A])]))


def filtered(gain, tau):
    """A, B, C and D of gain times the rate, behind a filter."""
    x = np.array([[1 / tau]])
    return -x, x, -gain * x, gain * x


@pytest.mark.parametrize("unit, kind", [(0.3, "dense"), (9.81, "sparse")])
def test_spillover_by_a_sensor_is_seen(unit, kind, monkeypatch):
    whole, row = sharp(unit, kind, monkeypatch)
    monkeypatch.undo()
    part = whole.reduce(modes=6)
    basis, back = part.reduction.basis, part.reduction.back
    gain = filtered(-1.0, 1e-4)
    rows, few = (np.hstack([x, 0 * x]) for x in (row, row @ basis))
    truth, of_part = poles(whole, rows, *gain), poles(part, few, *gain)
    alone = poles(whole, np.hstack([row @ basis @ back, 0 * row]), *gain)
    assert of_part.real.max() < 0 and alone.real.max() < 0 < 0.4 < truth.real.max()

    law, K = sos.PIDLaw(position=row, filter=1e-4), {"K_P": [[0]], "K_D": [[-1]]}
    design = sos.analyse_pid(part, K, law=part.reduction.law(law))
    assert design.certify().proven
    found = design.check_on(whole)
    assert not found.kept and found.pole.real > 0 and found.of == 2 * whole.n + 1
    assert abs(truth - found.pole).min() < 1e-7 * abs(found.pole)
    refused = design.certify(on=whole)
    cure = "check_on" if sp.issparse(whole.M) else "analyse_pid(whole, K, law=law"
    assert not refused.proven and cure in str(refused)
    bare = sos.analyse_pid(part, K, law=sos.PIDLaw(position=few[:, :6], filter=1e-4))
    for ask in (lambda: bare.check_on(whole), lambda: bare.certify(on=whole)):
        with pytest.raises(ValueError, match=r"law=part\.reduction\.law\(law\)"):
            ask()


def _state(K):
    none = np.zeros((0, 0))
    return none, np.zeros((0, K.shape[1])), np.zeros((1, 0)), K


def laws(row):
    """From a name to the law, its gains, the rows that it sees, and A, B, C, D."""
    one, zero = np.eye(1), np.zeros((1, 1))
    both = block_diag(row, row)
    pos = np.hstack([row, 0 * row])
    pid = {"K_P": [[-0.3]], "K_D": [[-0.02]], "K_I": [[-0.1]]}
    yield (sos.PIDLaw(row, row, integrate=True), pid, both, zero, np.eye(1, 2),
           -0.1 * one, np.array([[-0.3, -0.02]]))  # fmt: skip
    A, B, C = np.array([[-3.0, 2], [0, -9]]), np.ones((2, 1)), np.array([[-0.2, 0.3]])
    yield (sos.DynamicLaw(2, row), dict(A_c=A, B_c=B, C_c=C), pos, A, B, C, zero)
    notch = ShapedLaw(sos.PIDLaw(row), [Filter.notch(20.0, 0.1, 0.6)])
    A = np.array([[0, 1], [-400, -24]])
    yield (notch, {"K_P": [[-0.3]]}, pos, A, np.eye(2)[:, 1:],
           -0.3 * np.array([[0, 4.0 - 24]]), -0.3 * one)  # fmt: skip
    seen = sos.Output(position=row, velocity=0.1 * row)
    mixed = np.hstack([row, 0.1 * row])
    yield (sos.PIDLaw(sensors=seen), {"K_P": [[-0.3]]}, mixed, *_state(-0.3 * one))


@pytest.mark.parametrize("which, kind", crossed(range(4), ["dense", "sparse"]))
def test_every_law_measures_the_whole(which, kind, monkeypatch):
    whole, row = sharp(9.81, kind, monkeypatch)
    monkeypatch.undo()
    law, gains, rows, *system = list(laws(row))[which]
    part = whole.reduce(modes=4)
    design = sos.analyse_pid(part, gains, law=part.reduction.law(law))
    few = rows @ block_diag(*[part.reduction.basis] * 2)
    for plant, seen, own in (
        (whole, rows, design.check_on(whole).poles),
        (part, few, design.poles()),
    ):
        truth = poles(plant, seen, *system)
        apart = abs(own[:, None] - truth).min(axis=1)
        assert (apart < 1e-7 * np.maximum(abs(own), 1)).all()
    rightmost = poles(whole, rows, *system).real.max()
    assert design.check_on(whole).pole.real == pytest.approx(rightmost, rel=1e-6)


def chain(n=6, unit=0.3):
    S = unit * (2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1))
    M, D = unit * np.eye(n), 0.1 * unit * np.eye(n) + 0.05 * S
    return sos.SecondOrderSystem(M, D, S, unit * np.eye(n)[:, :1])


def test_a_late_sensor_and_an_integral_are_those_of_the_whole():
    """lag y' = z5'' - y, and the integral of z5 beside an estimate of the state."""
    whole, row, lag = chain(), np.eye(6)[[4]], 0.2
    part, (own, push) = whole.reduce(modes=3), by_hand(whole)
    late = sos.PIDLaw(sensors=sos.Output(acceleration=row), lag=lag)
    design = sos.analyse_pid(part, [[-0.3]], law=part.reduction.law(late))
    rows = np.hstack([0 * row, row])
    A = -np.eye(1) / lag + rows @ push * -0.3 / lag
    top = np.hstack([own, -0.3 * push])
    truth = np.linalg.eigvals(np.vstack([top, np.hstack([rows @ own / lag, A])]))
    found = design.check_on(whole)
    assert found.pole.real == pytest.approx(truth.real.max(), rel=1e-7)
    assert found.kept == (truth.real.max() < 0)

    law = part.reduction.law(FullState(row))
    design = sos.design_pid(part, law=law, region=sos.PoleRegion(0.05))
    K = part.reduction.lift(design.K)
    seen = np.hstack([row, 0 * row])
    own = own + push @ K[:, :12]
    top = np.hstack([own, push @ K[:, 12:]])
    truth = np.linalg.eigvals(np.vstack([top, np.hstack([seen, [[0.0]]])]))
    found = design.check_on(whole)
    assert found.pole.real == pytest.approx(truth.real.max(), rel=1e-7)
    proof = design.certify(on=whole)
    assert proof.proven == (truth.real.max() < -0.05)


def late_laws(row, lag):
    """From a name to a law with a late acceleration, its K, and its outputs A to D from
    the readings: the place and the late one.
    """
    two = sos.Output(position=row) & sos.Output(acceleration=row + 0.1)
    none = np.zeros((0, 0)), np.zeros((0, 2)), np.zeros((1, 0))
    pid = sos.PIDLaw(sensors=two, lag=lag, integrate=[[1, 0]])
    gains = [[-0.3, -0.05, -0.01]]
    yield pid, gains, (np.zeros((1, 1)), np.eye(1, 2), [[-0.01]], [[-0.3, -0.05]])
    yield sos.PIDLaw(sensors=two, lag=lag), [[-0.3, 0.02]], (*none, [[-0.3, 0.02]])
    free = sos.DynamicLaw(1, sensors=two, lag=lag, strictly_proper=False)
    parts = dict(A_c=[[-3.0]], B_c=[[1.0, 0.5]], C_c=[[-0.2]], D_c=[[-0.1, 0.03]])
    yield free, parts, (*map(np.array, parts.values()),)


@pytest.mark.parametrize("which, unit", [(0, 0.3), (1, 9.81), (2, 0.3)])
def test_late_sensors_of_a_sparse_whole_are_states(which, unit, monkeypatch):
    """lag y' = [z5, z''] - y with z'' by the plant's own matrices."""
    dense, row, lag = chain(unit=unit), np.eye(6)[[4]], 0.2
    monkeypatch.setattr(sparse, "MOST_DENSE", 5)
    M = dense.M + unit * (np.eye(6, k=1) + np.eye(6, k=-1)) / 5
    matrices = M, 0.05 * dense.D, dense.S
    whole = sos.SecondOrderSystem(*map(sp.csc_array, matrices), dense.B)
    monkeypatch.undo()
    own, push = by_hand(sos.SecondOrderSystem(*matrices, dense.B))
    law, K, (A, B, C, D) = list(late_laws(row, lag))[which]
    A, B, C, D = (np.atleast_2d(x).astype(float) for x in (A, B, C, D))
    part = whole.reduce(modes=3)
    design = sos.analyse_pid(part, K, law=part.reduction.law(law))
    now, then = np.hstack([row, 0 * row]), np.hstack([0 * row, row + 0.1])
    top = np.hstack([own + push @ D[:, :1] @ now, push @ C, push @ D[:, 1:]])
    own_states = np.hstack([B[:, :1] @ now, A, B[:, 1:]])
    late = (then @ top - np.eye(1, top.shape[1], top.shape[1] - 1)) / lag
    truth = np.linalg.eigvals(np.vstack([top, own_states, late]))
    found = design.check_on(whole)
    assert found.of == len(truth)
    assert found.pole.real == pytest.approx(truth.real.max(), rel=1e-6)
    assert found.kept == (truth.real.max() < 0)
    for s in found.poles:
        assert abs(truth - s).min() < 1e-7 * abs(s)
    assert not design.certify(on=whole).proven


def test_a_place_that_the_part_keeps_needs_no_other_law():
    whole = chain()
    law = sos.PIDLaw(position=[[0, 1, 0]], filter=0.1)
    part = whole.reduce(rows=[0, 4], modes=1)
    gain = {"K_P": [[-0.05]], "K_D": [[-0.01]]}
    design = sos.analyse_pid(part, gain, law=law)
    rows = np.eye(12)[[4]]
    A, B, C, D = filtered(-0.01, 0.1)
    truth = poles(whole, rows, A, B, C, D - 0.05)
    found = design.check_on(whole)
    assert found.pole.real == pytest.approx(truth.real.max(), rel=1e-7)
    assert truth.real.max() < 0 and found.kept
    proof = design.certify(on=whole)
    assert proof.proven and "reduced" not in proof.claims[0] and "z5" in proof.claims[0]
    gone = sos.analyse_pid(part, gain, law=sos.PIDLaw([[0, 1, 0.1]], filter=0.1))
    with pytest.raises(ValueError, match="z5.* sees modes of the whole"):
        gone.check_on(whole)


def test_states_that_are_balanced_have_no_sensor_of_their_own():
    A, B = by_hand(chain())
    rows = np.eye(12)[[4]]
    whole = sos.DescriptorSystem(np.eye(12), A, B, C=rows)
    part = whole.reduce(states=6)
    law = sos.PIDLaw(position=rows, integrate=True)
    K = {"K_P": [[-0.05]], "K_I": [[-0.002]]}
    design = sos.analyse_pid(part, K, law=part.reduction.law(law))
    one = np.zeros((1, 1)), np.eye(1), -0.002 * np.eye(1), -0.05 * np.eye(1)
    truth = poles(chain(), rows, *one)
    found = design.check_on(whole)
    assert found.of == 13
    assert found.pole.real == pytest.approx(truth.real.max(), rel=1e-7)
    law = sos.PIDLaw(rows @ part.reduction.basis, integrate=True)
    with pytest.raises(ValueError, match="sees modes"):
        sos.analyse_pid(part, K, law=law).check_on(whole)


def test_rows_of_another_width_and_lost_bases_are_refused():
    part = chain().reduce(modes=2)
    with pytest.raises(ValueError, match="position has rows of width 2, needs 6"):
        part.reduction.law(sos.PIDLaw(position=[[1, 0]]))
    again = read_plant(plant_data(part))
    with pytest.raises(ValueError, match="isn't the one that reduce"):
        again.reduction.law(sos.PIDLaw(position=np.eye(6)[[0]]))
    for law in (sos.PIDLaw([[1, 0]]), FullState([[1, 0]])):
        K = np.zeros((1, 1 if law.U is None else 5))
        with pytest.raises(ValueError, match="isn't the one that reduce"):
            sos.analyse_pid(again, K, law=law).check_on(chain())


@pytest.mark.parametrize("asked", [dict(gamma=1e3), dict(requirements=[sos.H2(1e4)])])
def test_a_whole_that_is_unstable_keeps_no_norm(asked, monkeypatch):
    whole, row = sharp(0.3, "dense", monkeypatch)
    matrices = whole.M, whole.D, whole.S, whole.B
    whole = sos.SecondOrderSystem(*matrices, whole.B)
    part = whole.reduce(modes=6)
    law = part.reduction.law(sos.PIDLaw(position=row, velocity=row))
    design = sos.analyse_pid(part, {"K_P": [[0]], "K_D": [[-1]]}, law=law, **asked)
    zero = np.zeros((0, 0)), np.zeros((0, 1)), np.zeros((1, 0)), -np.eye(1)
    assert poles(whole, np.hstack([0 * row, row]), *zero).real.max() > 0.1
    found = design.check_on(whole)
    assert not found.kept and found.broken == (
        "its poles lie left of the imaginary axis",
    )


@pytest.mark.parametrize(
    "elements, unit, filter",
    [(12, 9.81, None), (20, 0.3, 1e-4), *later((12, 9.81, 1e-4), (20, 0.3, None))],
)
def test_a_law_is_proven_on_all_of_a_beam(elements, unit, filter):
    """A search for P, F and G of 48 states took minutes, or found none."""
    plant = beam(elements, unit)
    row, g = np.eye(plant.n)[[10]], 0.05 * unit
    whole = sos.SecondOrderSystem(plant.M, plant.D, plant.S, row.T)
    rows, gain = np.hstack([0 * row, row]), [np.zeros((0, 0)), np.zeros((0, 1))]
    gain += [np.zeros((1, 0)), -g * np.eye(1)]
    law, K = sos.PIDLaw(sensors=sos.Output(velocity=row)), {"K_P": [[-g]]}
    if filter:
        law = sos.PIDLaw(position=row, filter=filter)
        rows, gain = np.hstack([row, 0 * row]), filtered(-g, filter)
        K = {"K_P": [[0]], "K_D": [[-g]]}
    slowest = -poles(whole, rows, *gain).real.max()
    part = whole.reduce(modes=4)
    design = sos.analyse_pid(
        part, K, law=part.reduction.law(law), region=sos.PoleRegion(sigma=0.5 * slowest)
    )
    proof = design.certify(on=whole, time_limit=60)
    assert proof.proven and "of the reduced model" not in str(proof)
    beyond = sos.analyse_pid(
        part, K, law=part.reduction.law(law), region=sos.PoleRegion(sigma=2 * slowest)
    )
    if beyond.status == "feasible":
        assert "doesn't keep it" in str(beyond.certify(on=whole, time_limit=60))
