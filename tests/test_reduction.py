"""A proof of a part says so, and the whole is looked at, or proven."""

import json
import tracemalloc

import control
import numpy as np
import pytest
import scipy.sparse as sp
from scipy.linalg import block_diag, eigh

import sosbook as sos
from benchmarks.elements import beam_element
from sosbook.analysis.large import Pencil
from sosbook.exact.checker import fields, verdict
from sosbook.exact.checker.arithmetic import Refused
from sosbook.exact.checker.families import whole_vertices
from sosbook.plants import sparse
from sosbook.plants.as_data import read_plant
from sosbook.plants.reduction import Reduction
from sosbook.proofs import load
from sosbook.proofs.command import main
from tests.cases import by_hand, later, seeds

UNITS = [1.0, 0.3, 9.81]


def beam_matrices(elements, length, EI, mass):
    """M and S of Euler's elements between free ends."""
    m, s = beam_element(length / elements)
    M, S = np.zeros((2, 2 * elements + 2, 2 * elements + 2))
    for k in range(0, 2 * elements, 2):
        M[k : k + 4, k : k + 4] += mass * m
        S[k : k + 4, k : k + 4] += EI * s
    return M, S


def beam(elements=12, unit=1.0):
    """Clamped at one end, with one damper that isn't proportional."""
    M, S = (unit * x[2:, 2:] for x in beam_matrices(elements, 1.0, 1.0, 1.0))
    D = 1e-4 * S
    D[elements, elements] += 0.05 * unit
    B = np.eye(2 * elements)[:, [elements - 2 + elements % 2]] * unit
    return sos.SecondOrderSystem(M, D, S, B)


def rotor(speed, bearing=1e6, elements=14):
    """A shaft with three discs that turns: planes are coupled by gyroscopic terms."""
    E, density, radius = 2.1e11, 7800.0, 0.02
    area, inertia = np.pi * radius**2, np.pi * radius**4 / 4
    M, S = beam_matrices(elements, 1.0, E * inertia, density * area)
    turning = np.zeros_like(M)
    for node in (elements // 4, elements // 2, 3 * elements // 4):
        M[2 * node, 2 * node] += 8.0
        M[2 * node + 1, 2 * node + 1] += 0.02
        turning[2 * node + 1, 2 * node + 1] += 0.04
    D = 2e-6 * S
    for node in (1, elements - 1):
        S[2 * node, 2 * node] += bearing
        D[2 * node, 2 * node] += 200.0
    zero = np.zeros_like(M)
    G = np.block([[zero, turning], [-turning, zero]])
    places = [2 * (elements // 6), 2 * (elements - elements // 6)]
    B = np.eye(2 * len(M))[:, places + [len(M) + k for k in places]]
    M, S, D = (block_diag(x, x) for x in (M, S, D))
    return sos.SecondOrderSystem(M, D + speed * G, S, B)


def bar(n, unit=1.0):
    """A sparse chain with damping 1e-3 (T + 1), whose poles have a closed form."""
    T = sp.diags([-np.ones(n - 1), 2 * np.ones(n), -np.ones(n - 1)], [-1, 0, 1])
    D = 1e-3 * T + 1e-3 * sp.identity(n)
    B = np.zeros((n, 1))
    B[n // 2 + 3] = unit
    return sos.SecondOrderSystem(unit * sp.identity(n), unit * D, unit * 1e4 * T, B)


def bar_poles(n):
    t = 2 - 2 * np.cos(np.pi * np.arange(1, n + 1) / (n + 1))
    half = 5e-4 * (t + 1)
    return -half + 1j * np.sqrt(1e4 * t - half**2)


def eigenvalues(plant, K):
    A, B = by_hand(plant)
    return np.linalg.eigvals(A + B @ K)


# ---- The part
@pytest.mark.parametrize("unit", UNITS)
def test_modes_are_the_slowest_and_the_gain_is_lifted(unit):
    whole = beam(unit=unit)
    part = whole.reduce(modes=4)
    squares = eigh(whole.S, whole.M, eigvals_only=True)[:4]
    assert part.S == pytest.approx(np.diag(squares), rel=1e-8, abs=1e-6)
    assert part.M == pytest.approx(np.eye(4), abs=1e-12)
    knows = part.reduction
    assert (knows.kept, knows.of) == (4, 24) and knows.whole is whole
    assert knows.back @ knows.basis == pytest.approx(np.eye(4), abs=1e-12)
    K = np.arange(8.0)[None]
    z, v = np.random.default_rng(1).normal(size=(2, 24))
    u = K @ np.concatenate([knows.back @ z, knows.back @ v])
    assert knows.lift(K) @ np.concatenate([z, v]) == pytest.approx(u)


def test_rows_stay_and_the_others_follow_at_rest():
    whole = beam()
    rows = [23, 4, 10]
    part = whole.reduce(rows=rows)
    forces = np.zeros((24, 3))
    forces[rows, range(3)] = 1.0
    still = np.linalg.solve(whole.S, forces)[rows]
    assert np.linalg.inv(part.S) == pytest.approx(still, rel=1e-9)
    lifted = part.reduction.lift(np.ones((1, 6)))
    assert {*np.flatnonzero(lifted)} == {*rows, *(24 + k for k in rows)}
    more = whole.reduce(rows=rows, modes=5)
    exact = np.sort(abs(whole.poles()))[:4]
    near, far = (abs(np.sort(abs(p.poles()))[:4] / exact - 1) for p in (more, part))
    assert near.max() < 1e-4 < far.max()
    assert more.reduction.back @ more.reduction.basis == pytest.approx(np.eye(8))
    assert more.coordinates[:3] == ("z24", "z5", "z11")


def test_a_polytope_is_reduced_to_modes_of_its_mean():
    speeds = sos.Polytope([rotor(v) for v in (0.0, 300.0)])
    part = speeds.reduce(modes=6)
    basis = part.reduction.basis
    assert part.reduction is part.vertices[1].reduction
    for one, of in zip(part.vertices, speeds.vertices):
        assert one.D == pytest.approx(basis.T @ of.D @ basis)
    design = sos.design_pid(part, search=sos.Search(prefer="centre"))
    (first, *_) = design.certify().claims
    assert first.startswith(
        "of the reduced model (6 of 60): every constant or changing plant"
    )


def test_balanced_states_keep_what_is_reached_and_seen():
    plant = beam()
    n = plant.n
    A, B = by_hand(plant)
    C = np.eye(2 * n)[[n - 2]]
    whole = sos.DescriptorSystem(np.eye(2 * n), A, B, C=C)
    part = whole.reduce(states=8)
    (d,) = part.vertices
    grams = [control.lyap(X, Y) for X, Y in ((A, B @ B.T), (A.T, C.T @ C))]
    hankel = np.sqrt(abs(np.linalg.eigvals(grams[0] @ grams[1])))
    tail = np.sort(hankel)[:-8].sum()
    for w in np.geomspace(0.1, 1e4, 200):
        one = C @ np.linalg.solve(1j * w * np.eye(2 * n) - A, B)
        few = d.C @ np.linalg.solve(1j * w * np.eye(8) - d.A, d.Bu)
        assert abs(one - few) <= 2.001 * tail
    design = sos.design_pid(part)
    assert design.certify().claims[0].startswith("of the reduced model (8 of 48): ")
    assert design.check_on(whole).kept


# ---- What a proof of it says
def certificates(tmp_path):
    part = beam(4).reduce(modes=2)
    design = sos.design_pid(part, region=sos.PoleRegion(0.1, rho=60))
    yield design.certify()
    yield sos.analyse_delay(part, np.zeros((1, 4)), tau=0.01, mu=0.01).certify()
    yield sos.design_lqr(part, np.eye(4), np.eye(1)).certify()
    yield sos.analyse_pid(
        part, np.zeros((1, 4)), region=sos.PoleRegion(9)
    ).infeasibility
    yield sos.certify_sampled(part, design.K, T=0.01)


def test_every_kind_of_proof_says_that_it_is_of_a_part(tmp_path):
    kinds = set()
    for proof in certificates(tmp_path):
        assert proof.proven, proof.failed
        kinds.add(proof.kind)
        words = "of the reduced model (2 of 8): "
        assert proof.claims and all(c.startswith(words) for c in proof.claims)
        assert words in str(proof)
        proof.save(tmp_path / "proof.json")
        again = load(tmp_path / "proof.json")
        assert again.proven and again.claims == proof.claims
    assert len(kinds) == 4


def test_a_loop_that_breaks_it_is_of_a_part_in_states():
    """With a filter, of a channel, of a filtered plant: two rows are four states."""
    one = np.eye(3)
    S, B = np.diag([1, 4, 9]), [[1], [0.5], [1]]
    part = sos.SecondOrderSystem(one, 0.1 * one, S, B, one[:, :1]).reduce(modes=2)
    law, gains = sos.PIDLaw([[1, 0]], filter=0.1), {"K_P": [[-1]], "K_D": [[-1]]}
    seen = sos.HInfinity(1e-3, outputs=sos.Output(position=[[1, 0]]))
    rest, region = np.zeros((1, 4)), sos.PoleRegion(3)
    shaped = sos.plants.filtered(part, sos.Output(position=[[1, 0]]), [1], [1, 1])
    for design, states in (
        (sos.analyse_pid(part, gains, law=law, region=region), "5 of 7"),
        (sos.analyse_pid(part, gains, law=law, gamma=1e-3), "5 of 7"),
        (sos.analyse_pid(part, rest, requirements=[seen]), "2 of 3"),
        (sos.analyse_pid(shaped, np.zeros((1, 5)), region=region), "5 of 7"),
    ):
        (claim,) = design.infeasibility.claims
        assert claim.startswith(f"of the reduced model ({states}): ")
        assert design.infeasibility.verify() and states in design._repr_html_()


@pytest.mark.parametrize("seed", seeds(3))
def test_a_loop_whose_numbers_no_float_holds_is_refused(seed, tmp_path):
    """Modes of all digits times a gain and a filter: the file has the rationals."""
    rng = np.random.default_rng(seed)
    one, S = np.eye(5), np.diag([1, 4, 9, 20, 30.0]) + 0.1
    whole = sos.SecondOrderSystem(
        one, 0.1 * one, S, rng.normal(size=(5, 1)), one[:, :1]
    )
    part, law = whole.reduce(modes=2), sos.PIDLaw([[1, 0]], filter=0.3)
    gains = {"K_P": [[-1]], "K_D": [[-9.81]]}
    seen = sos.HInfinity(1e-3, outputs=sos.Output(position=[[1, 0]]))
    for k, asked in enumerate(
        (dict(region=sos.PoleRegion(3)), dict(gamma=1e-3), dict(requirements=[seen]))
    ):
        design = sos.analyse_pid(part, gains, law=law, **asked)
        assert design.status == "infeasible" and design.infeasibility.verify()
        file = tmp_path / f"{k}.json"
        design.infeasibility.save(file)
        again = load(file)
        assert again.proven and again.claims == design.infeasibility.claims
        assert again.claims[0].startswith("of the reduced model (5 of 11): the ")
        loop = read_plant(again.data["plant"])
        assert str(loop.reduction) == "5 of 11" and "no parameter" in repr(loop.family)
        known = sos.analyse_pid(loop, np.zeros((0, 5)), gamma=1e3)
        assert known.status == "feasible" and known.certify().proven


@pytest.mark.parametrize("nothing", [{}, ""])
def test_no_parameter_is_an_empty_list(nothing):
    one = [["1/3"]]
    given = {"E": one, "A": [["-1"]], "B": [[]], "B_w": one, "C": one}
    plant = {"kind": "descriptor", "parameters": [], **given}
    assert read_plant(plant).vertices[0].E == pytest.approx(1 / 3)
    assert whole_vertices(plant)[0]["E"] == one
    with pytest.raises(ValueError, match="no parameter"):
        read_plant(plant | {"parameters": nothing})
    fields.fits(plant, fields.plant, "plant")
    with pytest.raises(Refused, match="plant.parameters: a list"):
        fields.fits(plant | {"parameters": nothing}, fields.plant, "plant")


def test_the_command_and_the_checker_say_it(tmp_path, capsys):
    design = sos.design_pid(beam(4).reduce(modes=2))
    proof = design.certify()
    proof.save(tmp_path / "proof.json")
    assert main(["verify", str(tmp_path / "proof.json")]) == 0
    said = "- of the reduced model (2 of 8): the plant, under u = K x, is stable"
    assert said in capsys.readouterr().out
    assert verdict.check(proof.text) == [said[2:]]
    assert "of the reduced model (2 of 8)" in design._repr_html_()


@pytest.mark.parametrize("wrong", [[8, 8], [3, 8], [2, True], [2], ["2", 8], [0, 8]])
def test_a_file_that_keeps_other_rows_is_refused(wrong):
    text = sos.design_pid(beam(4).reduce(modes=2)).certify().text
    data = json.loads(text)
    data["asks"]["plant"]["reduced"] = wrong
    data["about"]["plant"] = verdict.about(verdict.asked_of(data))["plant"]
    with pytest.raises((verdict.Refused, *verdict.MALFORMED)):
        verdict.check(json.dumps(data))


def test_a_part_isn_t_equal_to_the_same_matrices_and_is_not_reduced_again():
    part = beam(4).reduce(modes=2)
    alone = sos.SecondOrderSystem(part.M, part.D, part.S, part.B)
    assert part != alone
    assert not sos.design_pid(alone).certify().claims[0].startswith("of the reduced")
    with pytest.raises(ValueError, match="reduced already"):
        part.reduce(modes=1)


# ---- The whole
@pytest.mark.parametrize("plant", [beam(), beam(unit=0.3), rotor(300.0)], ids=repr)
def test_what_is_found_is_the_rightmost_pole(plant):
    part = plant.reduce(modes=5)
    slowest = -part.poles().real.max()
    design = sos.design_pid(
        part, region=sos.PoleRegion(1.4 * slowest), search=sos.Search(prefer="least")
    )
    K = part.reduction.lift(design.K)
    truth = eigenvalues(plant, K)
    found = design.check_on(plant)
    assert found.pole.real == pytest.approx(truth.real.max(), rel=1e-6)
    assert found.of == len(truth) and found.kept == (truth.real.max() < -1.4 * slowest)
    assert str(found).startswith("found: ") and "proven" not in str(found)


@pytest.mark.parametrize("sparse_from", [1000, 5])
def test_poles_that_are_not_refined_are_counted(sparse_from, monkeypatch):
    """No factor nearby settles a pole, and Newton's method is told to fail at the two
    slowest of eight pairs.
    """
    monkeypatch.setattr(sparse, "MOST_DENSE", sparse_from)
    whole = bar(8)
    design = sos.analyse_pid(whole.reduce(modes=2), np.zeros((1, 4)))
    all_ = design.check_on(whole)
    assert all_.unsettled == 0 and "not refined" not in str(all_)
    fast = np.sort(abs(all_.poles))[2]
    refined = Pencil.refined
    monkeypatch.setattr(Pencil, "_settled", lambda self, solve, s, q: (s, q, None))
    monkeypatch.setattr(
        Pencil,
        "refined",
        lambda self, s, q: refined(self, s, q) if abs(s) > 0.99 * fast else None,
    )
    found = design.check_on(whole)
    assert found.unsettled == 2 and str(found).endswith("seen, but not refined: 2")
    assert len(found.poles) == len(all_.poles) - 2


@pytest.mark.parametrize("unit", UNITS)
@pytest.mark.parametrize("left_out", ["free", "coupled", "undamped", "pushed"])
def test_what_lies_on_the_axis_isnt_kept(left_out, unit):
    """A row that no gain moves: free, tied to one alike, without damping, or less."""
    S, D = np.diag([4.0, 0, 0]), np.diag([0.0, 1, 1])
    S[1:, 1:] = {"free": [[0, 0], [0, 9]], "coupled": [[1.0, -1], [-1, 1]]}.get(
        left_out, np.diag([2.0, 9])
    )
    D[1, 1] = {"pushed": -1e-11, "coupled": 0.3}.get(left_out, 0.0)
    if left_out == "coupled":
        D[1:, 1:] = 0.3 * S[1:, 1:]
    whole = sos.SecondOrderSystem(
        unit * np.eye(3), unit * D, unit * S, unit * np.eye(3)[:, :1]
    )
    alike = sos.SecondOrderSystem(*3 * [unit * np.eye(3)], whole.B).reduce(rows=[0])
    for region in (None, sos.PoleRegion(1e-3), sos.PoleRegion(theta=1.5)):
        found = sos.analyse_pid(alike, [[0, -1]], region=region).check_on(whole)
        assert not found.kept and found.pole.real > -1e-6, (region, str(found))


@pytest.mark.parametrize("n, unit", [(3000, 9.81), *later((5000, 0.3))])
def test_a_sparse_whole_is_never_dense(n, unit):
    tracemalloc.start()
    whole = bar(n, unit)
    part = whole.reduce(modes=12)
    design = sos.analyse_pid(part, np.zeros((1, 24)))
    found = design.check_on(whole)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < n**2 * 8 / 2  # half of a dense matrix
    truth = bar_poles(n)
    assert abs(found.pole.real / truth.real.max() - 1) < 1e-6
    apart = abs(found.poles[:, None] - truth).min(axis=1)
    assert (apart < 1e-9 * abs(found.poles)).all()
    assert abs(part.poles()).max() == pytest.approx(abs(truth[11]), rel=1e-9)


def test_a_sparse_whole_with_a_gain_and_an_integrator(monkeypatch):
    monkeypatch.setattr(sparse, "MOST_DENSE", 50)
    n = 81
    whole = bar(n)
    part = whole.reduce(modes=3)
    U = part.reduction.basis[[40]]
    design = sos.design_pid(part, U, region=sos.PoleRegion(2e-3, rho=5))
    found = design.check_on(whole)
    K, up = part.reduction.lift(design.K), U @ part.reduction.back
    M, D, S, B = (whole.M.toarray(), whole.D.toarray(), whole.S.toarray(), whole.B)
    A = np.block(
        [
            [np.zeros((n, n)), np.eye(n), np.zeros((n, 1))],
            [B @ K[:, :n] - S, B @ K[:, n : 2 * n] - D, B @ K[:, 2 * n :]],
            [up, np.zeros((1, n + 1))],
        ]
    )
    assert (M == np.eye(n)).all()
    truth = np.linalg.eigvals(A)
    apart = abs(found.poles[:, None] - truth).min(axis=1)
    assert (apart < 1e-6 * np.maximum(abs(found.poles), 1)).all()
    assert found.pole.real == pytest.approx(truth.real.max(), rel=1e-3)


def test_a_proof_of_the_wrong_model():
    """Proven for the part, unstable on the whole: and then a gain that is not."""
    whole = rotor(300.0, elements=15)
    part = whole.reduce(modes=12)
    rho = 3 * np.sqrt(part.S.max())
    bold = sos.design_pid(part, region=sos.PoleRegion(6, rho=rho))
    assert bold.certify().proven
    K = part.reduction.lift(bold.certify().K)
    assert eigenvalues(whole, K).real.max() > 0
    found = bold.check_on(whole)
    assert found.pole.real > 0 and not found.kept
    refused = bold.certify(on=whole)
    assert not refused.proven and "doesn't keep it" in str(refused)

    gentle = sos.design_pid(
        part, region=sos.PoleRegion(6), search=sos.Search(prefer="least")
    )
    proof = gentle.certify(on=whole)
    assert proof.proven and proof.verify() and proof.K.shape == (4, 2 * whole.n)
    assert all("reduced" not in claim for claim in proof.claims)
    assert eigenvalues(whole, proof.K).real.max() < -6
    several = [rotor(v, elements=15) for v in (0.0, 300.0, 600.0)]
    worst = gentle.check_on(sos.Polytope(several))
    reals = [eigenvalues(one, K_of(gentle)).real.max() for one in several]
    assert worst.pole.real == pytest.approx(max(reals), rel=1e-6)


def K_of(design):
    return design.request.plant.reduction.lift(design.K)


def test_bearings_of_negative_stiffness_need_what_was_left_out():
    """A magnetic bearing pulls: the rotor is unstable without the gain."""
    whole = rotor(200.0, bearing=-3e5)
    part = whole.reduce(modes=6)
    assert whole.poles().real.max() > 0 and part.poles().real.max() > 0
    design = sos.design_pid(
        part, region=sos.PoleRegion(20), search=sos.Search(prefer="least")
    )
    truth = eigenvalues(whole, K_of(design)).real.max()
    assert design.certify().proven
    assert design.certify(on=whole).proven == design.check_on(whole).kept
    assert design.check_on(whole).kept == (truth < -20)


# ---- What is refused
def test_errors_name_the_argument_and_the_cure():
    whole, part = beam(), beam().reduce(modes=3)
    for wrong in (0, 24, 2.5, True):
        with pytest.raises(ValueError, match="modes must be"):
            whole.reduce(modes=wrong)
    for rows in ([24], [-1], [1, 1], [0.5], []):
        with pytest.raises(ValueError, match="rows must be different"):
            whole.reduce(rows=rows)
    with pytest.raises(ValueError, match="modes is missing"):
        whole.reduce()
    with pytest.raises(ValueError, match="keeps less than all"):
        Reduction(3, 3)
    free = sos.SecondOrderSystem(
        np.eye(2), np.zeros((2, 2)), np.zeros((2, 2)), np.eye(2)
    )
    with pytest.raises(ValueError, match="moves freely"):
        free.reduce(rows=[0])
    odd = sos.SecondOrderSystem(np.diag([1, -1.0]), np.eye(2), np.eye(2), np.eye(2))
    with pytest.raises(ValueError, match="isn't positive definite"):
        odd.reduce(modes=1)
    design = sos.design_pid(part)
    with pytest.raises(ValueError, match="on has 22 coordinates"):
        design.check_on(beam(11))
    with pytest.raises(ValueError, match="on must be"):
        design.certify(on="beam")
    unstable = sos.DescriptorSystem(
        np.eye(2), np.diag([1.0, -1]), [[1], [1]], C=[[1, 1]]
    )
    with pytest.raises(ValueError, match="only a stable plant"):
        unstable.reduce(states=1)


def test_large_sparse_plants_are_checked_like_others():
    n = 1200
    whole = bar(n)
    for do in (
        whole.poles,
        lambda: sos.design_pid(whole),
        lambda: whole.simulate([0, 1]),
    ):
        with pytest.raises(ValueError, match=r"plant\.reduce"):
            do()
    assert whole == bar(n) and hash(whole) == hash(bar(n)) and whole != bar(n, 2.0)
    with pytest.raises(ValueError):
        whole.M.data[0] = 3.0
    massless = sp.diags([*np.ones(n - 1), 0.0])
    with pytest.raises(ValueError, match=r"condense solves for z\[1199\]"):
        sos.SecondOrderSystem(massless, 0 * massless, whole.S, whole.B)
    with pytest.raises(ValueError, match="NaN or infinite"):
        sos.SecondOrderSystem(np.nan * whole.M, whole.D, whole.S, whole.B)
    with pytest.raises(ValueError, match="D is"):
        sos.SecondOrderSystem(whole.M, whole.D[:-1], whole.S, whole.B)
    with pytest.warns(sos.MassWarning, match="negative eigenvalue"):
        sos.SecondOrderSystem(
            whole.M - 2 * sp.diags([1.0, *np.zeros(n - 1)]), whole.D, whole.S, whole.B
        )


def test_what_is_no_matter_of_the_poles_is_never_dropped_in_silence():
    plant = beam()
    tip = np.eye(plant.n)[:, -2:-1]
    whole = sos.SecondOrderSystem(plant.M, plant.D, plant.S, plant.B, tip)
    part = whole.reduce(modes=3)
    asked = dict(region=sos.PoleRegion(0.3), gamma=0.05)
    design = sos.design_pid(part, **asked)
    with pytest.warns(UserWarning, match="poles alone are proven: H.* by analyse_pid"):
        proof = design.certify(on=whole)
    assert proof.proven and not any("norm" in claim for claim in proof.claims)
    K = part.reduction.lift(design.certify().K)
    cure = sos.analyse_pid(whole, K, gamma=1.02 * largest_gain(whole, K))
    assert cure.certify().proven


def largest_gain(plant, K):
    """The peak of |z(jw)| from w, over frequencies at and between the poles."""
    n = plant.n
    poles = eigenvalues(plant, K)
    places = np.concatenate([np.abs(poles.imag), np.geomspace(1e-2, 1e5, 400)])

    def response(w):
        closed = plant.S + 1j * w * plant.D - w**2 * plant.M
        closed = closed - plant.B @ (K[:, :n] + 1j * w * K[:, n:])
        return np.linalg.norm(np.linalg.solve(closed, plant.F), 2)

    return max(map(response, places))


@pytest.mark.parametrize("heavier, proven", [(1.05, True), (40.0, False)])
def test_of_another_plant_of_the_same_size_all_is_proven(heavier, proven):
    def cart(m):
        return sos.SecondOrderSystem(
            [[m, 0], [0, 0.3]],
            np.diag([0.1, 0.2]),
            [[9.81, -3], [-3, 5]],
            [[1], [0]],
            [[0], [1]],
        )

    design = sos.design_pid(
        cart(1),
        region=sos.PoleRegion(0.3),
        gamma=0.9,
        saturation=sos.Saturation(400.0, [0.1, 0, 0, 0]),
    )
    proof = design.certify(on=cart(heavier))
    assert proof.proven == proven
    if proven:
        text = " ".join(proof.claims)
        assert "norm" in text and "400" in text and "Re s < -0.3" in text
