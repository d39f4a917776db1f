"""What is bounded: outputs on z, z', z'', x3, u and w, from some disturbances."""

import json

import control
import numpy as np
import pytest

import sosbook as sos
from sosbook.exact.checker import verdict
from sosbook.plants import descriptors, filtered
from sosbook.proofs.command import main
from sosbook.requirements.base import Requirement
from tests.cases import by_hand, campaign, later, norm_on_a_grid


def plant(rng, n=2, m=1, p=2):
    """A random plant; its mass isn't symmetric."""
    M = np.eye(n) + 0.3 * rng.normal(size=(n, n))
    D, S = (rng.normal(size=(n, n)) for _ in range(2))
    D, S = D @ D.T / 4 + 0.2 * np.eye(n), S @ S.T + np.eye(n)
    B, F = rng.normal(size=(n, m)), rng.normal(size=(n, p))
    return sos.SecondOrderSystem(*(x.round(3) for x in (M, D, S, B, F)))


def standard(one, U, K):
    """A, B and what gives z, z', z'', x3, u, w of the loop, written out."""
    n, a, p, zero = one.n, len(U), one.p, np.zeros
    A, B = by_hand(one)
    A = np.block([[A, zero((2 * n, a))], [U, zero((a, n + a))]])
    A = A + np.vstack([B, zero((a, one.m))]) @ K
    W = np.vstack([zero((n, p)), np.linalg.solve(one.M, one.F), zero((a, p))])
    x, nothing = np.eye(2 * n + a), zero((2 * n + a, p))
    parts = {
        "position": (x[:n], nothing[:n]),
        "velocity": (x[n : 2 * n], nothing[:n]),
        "acceleration": (A[n : 2 * n], W[n : 2 * n]),
        "integral": (x[2 * n :], nothing[:a]),
        "input": (K, zero((one.m, p))),
        "disturbance": (zero((p, 2 * n + a)), np.eye(p)),
    }
    return A, W, parts


def true_norm(one, U, K, rows, inputs):
    """Its largest singular value on a fine grid; rows by signal, stacked."""
    A, W, parts = standard(one, U, K)
    assert np.linalg.eigvals(A).real.max() < 0
    C = np.vstack([sum(R @ parts[k][0] for k, R in part.items()) for part in rows])
    D = np.vstack([sum(R @ parts[k][1] for k, R in part.items()) for part in rows])
    return norm_on_a_grid(A, W[:, inputs], C, D[:, inputs])


SIGNALS = ("position", "velocity", "acceleration", "integral", "input", "disturbance")


def some_rows(rng, one, a, parts=2):
    """Rows on random signals, of some parts with q rows each."""
    wide = dict(zip(SIGNALS, (one.n,) * 3 + (a, one.m, one.p)))
    chosen = []
    for _ in range(parts):
        signals = rng.choice([s for s in SIGNALS if wide[s]], 3, replace=False)
        q = rng.integers(1, 3)
        chosen.append({s: rng.normal(size=(q, wide[s])).round(2) for s in signals})
    return chosen


def stacked(rows):
    first, *others = (sos.Output(**part) for part in rows)
    for other in others:
        first = first & other
    return first


def checked(proof):
    """The claims of a proof, as the package and the checker alone read it."""
    assert proof.proven
    assert json.loads(proof.text)["version"] == 2
    assert list(verdict.check(proof.text)) == list(proof.claims)
    return proof.claims


@pytest.mark.parametrize("seed", [1, *campaign([0, 2, 3])])
def test_for_one_plant_and_a_known_gain_nothing_is_lost(seed):
    rng = np.random.default_rng(seed)
    one, U = plant(rng), np.eye(2)[: seed % 2]
    inputs = [[0, 1], [1]][seed % 2]
    rows = some_rows(rng, one, len(U))
    K = sos.design_pid(one, U, region=sos.PoleRegion(sigma=0.1, rho=20)).K.round(3)
    norm = true_norm(one, U, K, rows, inputs)
    asked = dict(outputs=stacked(rows), inputs=inputs, name="felt")
    known = sos.HInfinity(1.0, **asked)
    assert known.truth(descriptors(one, U), K) == pytest.approx(norm, rel=1e-4)
    for coupling in ("pairs", "multipliers"):
        for factor, verdict_ in ((1.01, "feasible"), (0.99, "infeasible")):
            found = sos.analyse_pid(
                one, K, U, requirements=[sos.HInfinity(factor * norm, **asked)],
                coupling=coupling,
            )  # fmt: skip
            assert found.status == verdict_
            proof = found.certify() if factor > 1 else found.infeasibility
            assert proof.proven
            if coupling == "pairs":
                checked(proof)
    slack = sos.analyse_pid(
        one, K, U, requirements=[sos.HInfinity(1.01 * norm, **asked)], coupling="slack"
    )
    if slack.status == "feasible":  # its scalar is sought on a grid
        assert "felt: its H-infinity norm from w[" in checked(slack.certify())[1]


@pytest.mark.parametrize(
    "seed, coupling", [(1, "slack"), *later((0, "pairs"), (1, "pairs"), (0, "slack"))]
)
def test_a_polytope_keeps_what_is_proven(seed, coupling):
    """Of plants with other masses, springs and inputs, three channels at once."""
    rng = np.random.default_rng(40 + seed)
    first = plant(rng)
    others = [
        sos.SecondOrderSystem(
            *(x * (1 + 0.1 * rng.normal(size=x.shape)).round(2) for x in
              (first.M, first.D, first.S, first.B, first.F))
        )
        for _ in range(2)
    ]  # fmt: skip
    loads, U = sos.Polytope([first, *others]), np.eye(2)[:1]
    a = [{"position": rng.normal(size=(1, 2)).round(2)}, {"input": 0.1 * np.eye(1)}]
    b = [{"velocity": np.eye(2), "disturbance": 0.2 * np.eye(2)}]
    if coupling == "slack":
        b.append({"acceleration": np.array([[0.5, -0.3]])})
    asked = [
        sos.HInfinity(None, outputs=stacked(a), name="quiet"),
        sos.HInfinity(20.0, outputs=stacked(b), inputs=[1], name="felt"),
        sos.HInfinity(30.0),
    ]
    design = sos.design_pid(
        loads, U, requirements=asked, minimize="quiet",
        coupling=("slack", 0.3) if coupling == "slack" else coupling,
        saturation=sos.Saturation(40, [0.5, 0, 0, 0, 0]),
    )  # fmt: skip
    assert design.status == "feasible", design.reason
    assert len(checked(design.certify())) == 5
    by_name = {r.name: r for r in design.request.requirements}
    for one in [*loads.vertices, *loads.sample(8, seed=1)]:
        for name, rows, inputs in (("quiet", a, [0, 1]), ("felt", b, [1])):
            bound = by_name[name].bound
            assert true_norm(one, U, design.K, rows, inputs) < bound


def test_names_tell_channels_apart():
    """Bounds are minimised by name, and gamma= stays the norm to z."""
    rng = np.random.default_rng(3)
    one = plant(rng)
    gust = sos.HInfinity(None, outputs=sos.Output(position=[[1, 0]]), name="gust")
    both = sos.design_pid(
        one, requirements=[gust], gamma=5.0, minimize="gust",
        region=sos.PoleRegion(rho=6),
    )  # fmt: skip
    assert both.gamma == 5.0 and both.status == "feasible"
    bound = next(r.bound for r in both.request.requirements if r.name == "gust")
    K, rows = both.K, [{"position": np.array([[1.0, 0.0]])}]
    norm = true_norm(one, np.zeros((0, 2)), K, rows, [0, 1])
    assert norm < bound < 1.2 * norm
    assert {b.requirement.name for b in both.bounds()} == {"gamma", "gust", "disk"} or (
        len(both.bounds()) == 3
    )
    with pytest.raises(ValueError, match="two requirements are called gamma gust"):
        sos.design_pid(one, requirements=[gust.with_bound(1), gust.with_bound(2)])
    with pytest.raises(ValueError, match="that of another bound"):
        sos.HInfinity(1.0, name="sigma")


def test_words_leave_a_float_s_noise_out_and_data_keep_it():
    noisy = sos.Output(position=[[3 * 0.068, -0.1 - 0.2]], input=1.23456789012345)
    assert noisy.words == "[[0.204, -0.3]] z + 1.23456789012345 u"
    assert noisy.data()[0]["position"] == [[repr(3 * 0.068), repr(-0.1 - 0.2)]]
    assert sos.Output.read(noisy.data()) == noisy != sos.Output([[0.204, -0.3]])


def test_outputs_are_read_again():
    y = sos.Output(position=[[1, 0.1]], input=[[3]], name="y") & sos.Output(velocity=2)
    asked = sos.HInfinity(2.0, outputs=y, inputs=(1, 0), name="gust")
    data = json.loads(json.dumps(asked.data()))
    again = Requirement.read(data)
    assert (
        again.outputs == y
        and again.inputs == (1, 0)
        and again.claim()
        == (
            "gust: its H-infinity norm from w[1], w[0] to y = [[1, 0.1]] z + [[3]] u; "
            "2 z' is below 2"
        )
    )
    assert sos.HInfinity(2.0).data().keys() == {"kind", "name", "gamma", "mu"}


ONE = sos.SecondOrderSystem(np.eye(2), np.eye(2), np.eye(2), [[1], [0]], np.eye(2))


@pytest.mark.parametrize(
    "output, inputs, message",
    [
        (dict(position=[[1, 0, 0]]), None, "width 3, but the plant has 2 degrees of"),
        (dict(input=[[1, 1]]), None, "input has rows of width 2, .* 1 inputs"),
        (dict(disturbance=[[1]]), None, "width 1, but the plant has 2 disturbances"),
        (dict(integral=1), None, "integral is weighed, but the plant has no integrals"),
        (dict(position=1, input=1), None, "a number stands for a multiple"),
        (dict(position=1), [2], "there is no disturbance 2, for the plant has 2"),
        (dict(position=1), [], "inputs must name one or more, each once"),
        (dict(position=1), [0, 0], "each once"),
        (dict(position=1), [-1], "inputs must be 0, 1, ..., got -1"),
        (dict(position=1), 1, "inputs must be a list of numbers, counted from 0"),
        (dict(position=1), "w1", "inputs must be a list of numbers, counted from 0"),
    ],
)
def test_rows_that_do_not_fit_are_named(output, inputs, message):
    with pytest.raises(ValueError, match=message):
        asked = sos.HInfinity(1.0, outputs=sos.Output(**output), inputs=inputs)
        sos.design_pid(ONE, requirements=[asked])


@pytest.mark.parametrize(
    "output, message",
    [
        (dict(), "an Output has no rows"),
        (dict(position=np.zeros((0, 2))), "position has no row"),
        (dict(position=[[1, 0]], input=[[1], [2]]), "position has 1, input has 2"),
        (dict(position=[[1, "a"]]), "position"),
        (dict(position=[[1, np.nan]]), "position"),
        (dict(input=np.inf), "input must be a finite number"),
        (dict(position=1, name="a\nb"), "must be one line of letters"),
    ],
)
def test_an_output_that_is_none_is_named(output, message):
    with pytest.raises(ValueError, match=message):
        sos.Output(**output)


def test_an_acceleration_of_an_uncertain_mass_has_a_P_for_each_plant():
    """Where a mixture of the equations gives it, or vertices suffice, one P will do."""
    rng = np.random.default_rng(11)
    one = plant(rng)
    moved = sos.SecondOrderSystem(one.M * 1.3, one.D, one.S * 0.8, one.B, one.F)
    other = sos.SecondOrderSystem(one.M.T, one.D, one.S, one.B, one.F)
    loads = sos.Polytope([one, moved, other])
    felt = sos.HInfinity(9.0, outputs=sos.Output(acceleration=[[1, 0]]))
    with pytest.raises(ValueError, match='Take coupling="slack"'):
        sos.design_pid(loads, requirements=[felt], coupling="pairs")
    design = sos.design_pid(loads, requirements=[felt], region=sos.PoleRegion(rho=20))
    assert design.request.coupling.own_P and "an acceleration" in design.reason
    assert design.certify().proven
    K = design.K.round(3)
    rows, nothing = [{"acceleration": np.array([[1.0, 0.0]])}], np.zeros((0, 2))
    worst = max(
        true_norm(v, nothing, K, rows, [0, 1])
        for v in [*loads.vertices, *loads.sample(30, seed=0)]
    )
    for factor, status in ((1.03, "feasible"), (0.97, "infeasible")):
        asked = [felt.with_bound(factor * worst)]
        found = sos.analyse_pid(loads, K, requirements=asked)
        assert found.status == status and found.request.coupling.word == "multipliers"
        assert (found.certify() if factor > 1 else found.infeasibility).proven
    with pytest.raises(ValueError, match="its mass is uncertain"):
        sos.analyse_pid(loads, K, requirements=[felt], coupling="pairs")


def test_a_singular_mass_needs_K_A_first():
    massless = sos.SecondOrderSystem(
        np.diag([1, 0]), np.eye(2), np.eye(2), np.eye(2), np.eye(2)
    )
    felt = sos.HInfinity(9.0, outputs=sos.Output(acceleration=1))
    with pytest.raises(ValueError, match="M - B K_A is singular: give an acceleration"):
        sos.design_pid(massless, requirements=[felt])
    K_A = [[0, 0], [0, -0.5]]
    design = sos.design_pid(massless, requirements=[felt], K_A=K_A)
    checked(design.certify())
    heavy = sos.SecondOrderSystem(
        np.diag([1, 0.5]), np.eye(2), np.eye(2), np.eye(2), np.eye(2)
    )
    rows = [{"acceleration": np.eye(2)}]
    assert true_norm(heavy, np.zeros((0, 2)), design.K, rows, [0, 1]) < 9


@pytest.mark.parametrize("length, force", [(0.3, 1), (1, 9.81), (1e3, 0.3)])
def test_units_change_no_bound(length, force):
    """Lengths and forces in other units, and rows that undo it."""
    rng = np.random.default_rng(5)
    one = plant(rng)
    rows = some_rows(rng, one, 0)
    scale = {
        "position": 1 / length, "velocity": 1 / length, "acceleration": 1 / length,
        "input": 1 / force, "disturbance": 1 / force,
    }  # fmt: skip
    moved = sos.SecondOrderSystem(
        *(x * force / length for x in (one.M, one.D, one.S)), one.B, one.F
    )
    told = [{k: R * scale[k] for k, R in part.items()} for part in rows]
    ask = dict(minimize="gamma", saturation=None, region=sos.PoleRegion(rho=8))
    here = sos.design_pid(
        one, requirements=[sos.HInfinity(None, outputs=stacked(rows))], **ask
    )
    there = sos.design_pid(
        moved, requirements=[sos.HInfinity(None, outputs=stacked(told))], **ask
    )
    assert here.status == there.status == "feasible"
    # w is in units of force: the norm from w to y is divided by them
    assert there.gamma * force == pytest.approx(here.gamma, rel=0.012)


def test_plants_may_have_outputs_of_their_own():
    """C, D_u, D_w and C_a of each vertex; families have polynomials in them."""

    def one(k, c):
        return dict(
            E=[[1, 0], [0.2 * k, 2]], A=[[0, 1], [-k, -1]], B=[[0], [1]],
            B_w=[[0.1], [1]], C=[[c, 0], [0, k]], D_u=[[0], [c]], D_w=[[0.1], [c]],
            C_a=[[0, 0.1], [0, 0]],
        )  # fmt: skip

    corners = [one(k, c) for k in (1, 2) for c in (0.5, 1)]
    lists = {name: [v[name] for v in corners] for name in corners[0]}
    loads = sos.DescriptorSystem(**lists)
    family = sos.Uncertain(
        lambda k, c: sos.DescriptorSystem(**one(k, c)), k=(1, 2), c=(0.5, 1)
    )
    bounds = []
    for plants in (loads, family):
        design = sos.design_pid(
            plants, gamma=8.0, coupling=("slack", 0.5),
            region=sos.PoleRegion(rho=30),
        )  # fmt: skip
        claims = checked(design.certify())
        assert "its H-infinity norm is below 8" in claims
        K = design.K.round(3)
        least = sos.analyse_pid(plants, K, minimize="gamma")
        assert least.certify().proven
        true = []
        for k, c in np.random.default_rng(0).uniform([1, 0.5], [2, 1], (10, 2)):
            v = {name: np.array(x, float) for name, x in one(k, c).items()}
            A, W = np.linalg.solve(v["E"], v["A"] + v["B"] @ K), v["B_w"]
            W = np.linalg.solve(v["E"], W)
            C = v["C"] + v["D_u"] @ K + v["C_a"] @ A
            true.append(norm_on_a_grid(A, W, C, v["D_w"] + v["C_a"] @ W))
        assert max(true) < least.gamma < 1.4 * max(true)
        bounds.append(least.gamma)
        refused = sos.analyse_pid(plants, K, gamma=0.9 * max(true))
        assert refused.status == "infeasible" and refused.infeasibility.proven
        checked(refused.infeasibility)
    with pytest.raises(ValueError, match="D_w is given without C"):
        sos.DescriptorSystem(1, -1, 1, 1, D_w=1)


def true_h2(one, U, K, rows, inputs):
    """By python-control, of the loop written out."""
    A, W, parts = standard(one, U, K)
    C = np.vstack([sum(R @ parts[k][0] for k, R in part.items()) for part in rows])
    return control.system_norm(control.ss(A, W[:, inputs], C, 0), 2)


@pytest.mark.parametrize("seed", [1, *campaign([0, 2])])
def test_the_H2_norm_of_one_plant_loses_nothing(seed):
    rng = np.random.default_rng(20 + seed)
    one, U = plant(rng), np.eye(2)[: seed % 2]
    rows = [
        {"position": rng.normal(size=(2, 2)).round(2), "input": np.ones((2, 1))},
        {"velocity": np.array([[1.0, -1.0]])},
    ]
    inputs = [[1], [0, 1], [0]][seed]
    K = sos.design_pid(one, U, region=sos.PoleRegion(sigma=0.1, rho=20)).K.round(3)
    norm = true_h2(one, U, K, rows, inputs)
    for coupling in ("pairs", "multipliers"):
        for factor, status in ((1.01, "feasible"), (0.99, "infeasible")):
            asked = sos.H2(factor * norm, outputs=stacked(rows), inputs=inputs)
            found = sos.analyse_pid(one, K, U, requirements=[asked], coupling=coupling)
            assert asked.truth(descriptors(one, U), K) == pytest.approx(norm)
            if coupling == "multipliers" and factor < 1:
                assert found.status != "feasible"
                continue
            assert found.status == status
            proof = found.certify() if factor > 1 else found.infeasibility
            assert proof.proven
            if coupling == "pairs":
                checked(proof)


@pytest.mark.parametrize("coupling", ["pairs", *campaign(["slack"])])
def test_the_least_H2_norm_is_that_of_the_Riccati_equation(coupling):
    """Of one plant; of several it is kept between them, beside an H-infinity norm."""
    rng = np.random.default_rng(8)
    one = plant(rng)
    y = sos.Output(position=[[1, 0]]) & sos.Output(input=0.2)
    (d,) = descriptors(one)
    A, B, W = d.state_space()
    Q = np.diag([1.0, 0, 0, 0])
    X, _, _ = control.care(A, B, Q, 0.04 * np.eye(1))
    best = float(np.sqrt(np.trace(W.T @ X @ W)))
    ask = dict(requirements=[sos.H2(None, outputs=y)], minimize="h2", coupling=coupling)
    found = sos.design_pid(one, search=sos.Search(backoff=0.001), **ask)
    bound = found.request.requirements[0].bound
    assert best < bound < (1.01 if coupling == "pairs" else 1.1) * best
    checked(found.certify())
    heavy = sos.SecondOrderSystem(1.2 * one.M, one.D, one.S, one.B, one.F)
    stiff = sos.SecondOrderSystem(one.M.T, one.D, 1.1 * one.S, one.B, one.F)
    loads = sos.Polytope([one, heavy, stiff])
    asked = [sos.H2(1.6 * best, outputs=y), sos.HInfinity(20.0)]
    several = sos.design_pid(loads, requirements=asked, coupling=coupling)
    assert several.status == "feasible"
    assert len(checked(several.certify())) == 3
    rows = [{"position": np.array([[1.0, 0]])}, {"input": 0.2 * np.eye(1)}]
    nothing = np.zeros((0, 2))
    for v in [*loads.vertices, *loads.sample(30, seed=2)]:
        assert true_h2(v, nothing, several.K, rows, [0, 1]) < 1.6 * best
    refused = sos.design_pid(
        loads, requirements=[sos.H2(0.9 * best, outputs=y), sos.HInfinity(20.0)]
    )
    assert refused.status == "infeasible"
    checked(refused.infeasibility)


def test_an_infinite_H2_norm_is_named():
    for output in (dict(acceleration=1), dict(disturbance=1)):
        with pytest.raises(ValueError, match="w enters the output at once"):
            sos.design_pid(
                ONE, requirements=[sos.H2(1.0, outputs=sos.Output(**output))]
            )
    with pytest.raises(ValueError, match="h2 needs a plant with F"):
        bare = sos.SecondOrderSystem(1, 1, 1, 1)
        sos.design_pid(bare, requirements=[sos.H2(1.0, outputs=sos.Output(position=1))])


def test_a_file_asks_for_outputs(tmp_path, capsys):
    """Channels by name in JSON, as the command reads them, and its error in words."""
    asked = {
        "plant": {"M": [[2]], "D": [[0.1]], "S": [[1]], "B": [[1]], "F": [[1]]},
        "hinf": [
            {"gamma": 0.8, "outputs": [{"acceleration": 1, "name": "comfort"},
                                       {"input": 0.1}], "name": "ride"},
            {"gamma": 9, "outputs": {"position": [[1]]}, "inputs": [0]},
        ],
        "h2": {"outputs": {"position": 1, "input": [[0.5]]}},
        "minimize": "h2",
    }  # fmt: skip
    file, proof = tmp_path / "plant.json", tmp_path / "proof.json"
    file.write_text(json.dumps(asked), "utf-8")
    assert main(["design", str(file), "--proof", str(proof)]) == 0
    claims = checked(sos.proofs.load(proof))
    assert {*claims[1:3]} == {
        "its H-infinity norm from w[0] to [[1]] z is below 9",
        "ride: its H-infinity norm to comfort = 1 z''; 0.1 u is below 0.8",
    }
    assert claims[3].startswith("its H2 norm to 1 z + [[0.5]] u is below 0.")
    asked["h2"]["outputs"]["positon"] = 1
    file.write_text(json.dumps(asked), "utf-8")
    assert main(["design", str(file), "--proof", str(proof), "--force"]) == 2
    assert "h2: 'positon' isn't known of an output" in capsys.readouterr().err


@pytest.mark.parametrize("noise", ["F", *campaign(["states"])])
def test_a_cost_with_cross_terms_is_that_of_the_Riccati_equation(noise):
    rng = np.random.default_rng(31)
    one, square = plant(rng), rng.normal(size=(5, 6)).round(2)
    whole = square @ square.T
    Q, N, R = whole[:4, :4], whole[:4, 4:], whole[4:, 4:]
    cost = sos.QuadraticCost(Q, R, N=N, noise=noise)
    assert (
        np.abs(np.block([[cost.Q, cost.N], [cost.N.T, cost.R]]) - whole).max() < 1e-12
    )
    (d,) = descriptors(one)
    A, B, W = d.state_space()
    X, _, K = control.care(A, B, Q, R, S=N)
    best = np.trace(X) if noise == "states" else np.trace(W.T @ X @ W)
    assert cost.truth([d], -K) == pytest.approx(best)
    found = sos.design_pid(
        one, requirements=[cost], minimize="cost", search=sos.Search(backoff=1e-3)
    )
    assert best < found.request.cost.bound < 1.01 * best
    checked(found.certify())
    softer = sos.SecondOrderSystem(1.1 * one.M, one.D, 0.9 * one.S, one.B, one.F)
    loads = sos.Polytope([one, softer])
    K = found.K.round(3)
    least = sos.analyse_pid(loads, K, requirements=[cost], minimize="cost")
    worst = max(cost.truth(descriptors(v), K) for v in loads.sample(30, seed=0))
    assert worst < least.request.cost.bound < 1.1 * worst and least.certify().proven
    for wrong, message in (
        (dict(Q=0.1 * np.eye(4), R=R, N=N), "negative eigenvalue"),
        (dict(Q=Q, R=R, N=N.T), "N "),
        (dict(C=Q, R=R, N=N), "N goes with Q"),
    ):
        with pytest.raises(ValueError, match=message):
            sos.QuadraticCost(**wrong)


def test_the_noise_of_a_sensor_is_in_the_force_that_a_law_gives():
    """u = K_P y + K_D (y - xi) / tau, tau xi' = y - xi, y = z + 0.3 w[1]."""
    one = sos.SecondOrderSystem([[2]], [[0.4]], [[3]], [[1]], [[1, 0]])
    law = sos.PIDLaw(position=[[1]], filter=0.2, noise=[[0, 0.3]])
    gain = np.array([[-2 - 1 / 0.2, 0, 1 / 0.2]])
    A = np.array([[0, 1, 0], [-1.5, -0.2, 0], [5, 0, -5]]) + np.outer([0, 0.5, 0], gain)
    W = np.array([[0, 0], [0.5, 0.15 * gain[0, 0]], [0, 1.5]])
    felt = np.vstack([0.1 * A[1], gain])
    through = np.vstack([0.1 * W[1], [0, 0.3 * gain[0, 0]]])
    norm = norm_on_a_grid(A, W, felt, through)
    y = sos.Output(acceleration=0.1) & sos.Output(input=1)
    for factor, status in ((1.01, "feasible"), (0.99, "infeasible")):
        asked = [sos.HInfinity(factor * norm, outputs=y)]
        found = sos.analyse_pid(one, [[-2.0, -1.0]], law=law, requirements=asked)
        assert found.status == status, found.reason
        assert (found.certify() if factor > 1 else found.infeasibility).proven


@pytest.mark.parametrize(
    "num, den",
    [([0.3, 1], [0.2, 0.1, 1]), *later(([1], [0.5, 1]), ([2, 0.1, 3], [1, 0.4, 2]))],
)
def test_a_filter_weighs_frequencies(num, den):
    """W times the response, frequency by frequency, in python-control's hands."""
    rng = np.random.default_rng(2)
    one, U = plant(rng), np.eye(2)[:1]
    rows = [
        {"acceleration": rng.normal(size=(2, 2)).round(2), "input": np.ones((2, 1))}
    ]
    K = sos.design_pid(one, U, region=sos.PoleRegion(sigma=0.1, rho=20)).K.round(3)
    heavy = sos.SecondOrderSystem(1.3 * one.M, one.D, one.S, one.B, one.F)
    whole = filtered(sos.Polytope([one, heavy]), stacked(rows), num, den, U)
    given = np.hstack([K, np.zeros((1, 2 * (len(den) - 1)))])
    A, W, parts = standard(one, U, K)
    C = sum(R @ parts[k][0] for k, R in rows[0].items())
    D = sum(R @ parts[k][1] for k, R in rows[0].items())
    grid = 1j * np.geomspace(1e-2, 1e2, 700)
    plain = control.ss(A, W, C, D)(grid, squeeze=False)
    weight = np.polyval(num, grid) / np.polyval(den, grid)
    sizes = np.linalg.norm((plain * weight).transpose(2, 0, 1), 2, axis=(1, 2))
    asked = sos.HInfinity(1.0)
    assert asked.truth(whole.vertices[:1], given) == pytest.approx(
        sizes.max(), rel=1e-3
    )
    between = [whole.at([1 - t, t]).vertices[0] for t in np.linspace(0, 1, 11)]
    worst = asked.truth(between, given)
    kept = sos.analyse_pid(whole, given, gamma=1.02 * worst)
    assert kept.status == "feasible" and kept.certify().proven
    broken = sos.analyse_pid(whole, given, gamma=0.98 * worst)
    assert broken.status != "feasible"  # a plant in floats needn't have a proof
    assert broken.infeasibility is None or broken.infeasibility.proven
    one_alone = filtered(one, sos.Output(position=1), num, den)
    design = sos.design_pid(one_alone, gamma=5.0, region=sos.PoleRegion(rho=30))
    checked(design.certify())


def test_a_filter_that_is_none_is_named():
    y = sos.Output(position=1)
    for num, den, message in (
        ([1, 0], [1], "isn't proper"),
        ([1], [1, -1], "isn't stable"),
        ([1], [0, 1], "must not be zero"),
        ([], [1, 1], "numerator must be a list of numbers"),
        (1, [1, 1], "numerator must be a list of numbers"),
    ):
        with pytest.raises(ValueError, match=message):
            filtered(ONE, y, num, den)
    with pytest.raises(ValueError, match="plant must be"):
        filtered(ONE.M, y, [1], [1, 1])


@pytest.mark.parametrize(
    "num, den, U", [([1], [0.3, 1], [[1, 0]]), *later(([2, 0.1, 3], [1, 0.4, 2], None))]
)
def test_filters_join_every_plant_of_ranges(num, den, U):
    """Those of the family are those of its plants, and a proof is about all of them."""

    def carts(m, k):
        S = [[k**2 + 1, -1], [-1, 1]]
        return sos.SecondOrderSystem(
            [[m, 0], [0, 1]], [[0.4, -0.1], [-0.1, 0.2]], S, [[1], [0]], [[0], [1]]
        )

    plants, rng = sos.Uncertain(carts, m=(1, 2), k=(0.5, 1.5)), np.random.default_rng(0)
    felt = sos.Output(acceleration=[[0, 1]]) & sos.Output(input=0.1)
    whole = filtered(plants, felt, num, den, U)
    for m, k in rng.uniform([1, 0.5], [2, 1.5], (5, 2)).round(3):
        (mine,) = whole.family.at(m=m, k=k).vertices
        (own,) = filtered(plants.at(m=m, k=k), felt, num, den, U).vertices
        for name in ("E", "A", "Bu", "Bw", "C", "Du", "Dw", "Ca"):
            one, other = getattr(mine, name), getattr(own, name)
            assert np.allclose(
                0 if one is None else one, 0 if other is None else other, atol=1e-12
            )
    place = filtered(plants, sos.Output(position=[[0, 1]]), num, den, U)
    proof = sos.design_pid(place, gamma=9.0, region=sos.PoleRegion(rho=40)).certify()
    assert proof.claims[0].startswith(
        "every constant or changing plant with m in [1, 2] and k in [0.5, 1.5]"
    )
