"""Rocq proves the poles of a proof file, and nothing else passes; see formal/."""

import json
import random
import shutil
from fractions import Fraction

import numpy as np
import pytest

import sosbook as sos
from formal import collect, gen, rocq
from sosbook.exact.proof_file import ProofFile
from tests import test_sampled_text
from tests.cases import seeds
from tests.closed import analyse_loop
from tests.test_proof_files import proof_of

ONE_INPUT = [[0.0], [1.0]]


def two_masses(stiffness=3.0, mass=1.5, last=1.0):
    return sos.SecondOrderSystem(
        M=[[mass, 0.2], [0, last]],
        D=[[0.3, -0.1], [0.2, 0.3]],
        S=[[stiffness, -1.2], [-0.9, 2]],
        B=ONE_INPUT,
    )


REGIONS = (
    sos.LMIRegion.ellipse(-4, 3.9, 5)
    & sos.LMIRegion.strip(-8, -0.1)
    & sos.LMIRegion.disk(8, -2)
    & sos.LMIRegion.horizontal_strip(6)
    & sos.LMIRegion.sector(1.2, apex=0.3)
    & sos.LMIRegion([[-20.0]], [[1.0]], "mine")
)

PLANTS = {  # unsymmetric, in odd units, uncertain, with U, K_A, E and without an input
    "one plant": lambda: sos.design_pid(two_masses(), U=[[1, 0]]),
    "polytope": lambda: sos.design_pid(
        sos.Polytope(
            [two_masses(), two_masses(9.81 / 3, last=1.1), two_masses(mass=2)]
        ),
        region=sos.PoleRegion(0.01, 1.5, 40),
    ),
    "acceleration": lambda: sos.design_pid(two_masses(), K_A=[[0.1, -0.3]]),
    "every region": lambda: sos.design_pid(two_masses(), region=REGIONS),
    "descriptor": lambda: sos.design_pid(
        sos.DescriptorSystem(
            [np.eye(2), np.diag([1, 1.3])], [[0, 1], [-9.81, -0.3]], [[0], [1]]
        )
    ),
    "no input": lambda: analyse_loop(
        np.eye(2), [[[0, 1], [-2, -3]], [[0, 1], [-3, -2]]]
    ),
}


def file_of(name):
    return PLANTS[name]().certify().text


@pytest.fixture(scope="module")
def theory(tmp_path_factory):
    """The compiled theorems."""
    if not rocq.find():
        pytest.skip(rocq.MISSING)
    folder = tmp_path_factory.mktemp("theory")
    rocq.theory(folder)
    return folder


def test_proofs_are_collected(tmp_path, monkeypatch):
    """As `tasks.py archive` and `formal` do it, beside a program that makes them."""
    monkeypatch.setattr(ProofFile, "of", ProofFile.of)
    collect.start(tmp_path)
    text = file_of("one plant")
    assert [path.read_text("utf-8") for path in tmp_path.iterdir()] == [text]


@pytest.mark.slow
def test_rocq_proves_the_poles_of_files(theory):
    problems = [gen.read(file_of(name)) for name in PLANTS]
    count = rocq.prove(theory, "proofs", [gen.written(p) for p in problems])
    assert count == sum(len(p.regions) for p in problems)


def in_every_region():
    K = sos.design_pid(two_masses(), region=REGIONS).K
    return sos.analyse_pid(two_masses(), K, region=REGIONS, coupling="multipliers")


def with_acceleration():
    plants = sos.Polytope(
        [two_masses(), two_masses(9.81 / 3, last=1.1), two_masses(mass=2)]
    )
    K, K_A = sos.design_pid(two_masses(), U=[[1, 0]]).K, [[0.1, -0.3]]
    return sos.analyse_pid(plants, K, [[1, 0]], K_A=K_A, coupling="multipliers")


KNOWN = {  # by Theorem A; a proof of norms alone says that the loop is stable
    "every region": lambda: in_every_region().certify().text,
    "acceleration": lambda: with_acceleration().certify().text,
    "cells": lambda: proof_of("known gain, in a simplex").text,
    "finer cells": lambda: finer(proof_of("known gain, in a simplex").text),
    "a law": lambda: proof_of("known law").text,
    "a dynamic law": lambda: proof_of("known dynamic law").text,
    "a law's norms": lambda: proof_of("known law, outputs").text,
    "norms": lambda: proof_of("known gain, outputs that differ").text,
}


def finer(text):
    """The proof of one region whose cells are cut further; P is affine in them."""
    whole = json.loads(text)
    ((_, _, old),), cuts, point = whole["asks"]["cells"], [], {}
    number, leaves = 0, 0

    def write(P, FG, ways):
        nonlocal leaves
        if ways:
            (i, j), *rest = ways
            middle = [
                [str((Fraction(a) + Fraction(b)) / 2) for a, b in zip(*rows)]
                for rows in zip(P[i], P[j])
            ]
            cuts.append([i, j])
            for place in (i, j):
                write([middle if k == place else x for k, x in enumerate(P)], FG, rest)
        else:
            leaves += 1
            cuts.append(None)
            names = [f"P.1.{leaves}.{k}" for k in (1, 2, 3)]
            point.update(zip(names, P))
            point.update(zip((f"F.1.{leaves}", f"G.1.{leaves}"), FG))

    for way in old:
        if way is not None:
            cuts.append(way)
            continue
        number += 1
        P = [whole["point"][f"P.1.{number}.{k}"] for k in (1, 2, 3)]
        FG = [whole["point"][f"{x}.1.{number}"] for x in "FG"]
        write(P, FG, [(0, 1), (0, 2), (1, 0)])
    whole["asks"]["cells"][0][2], whole["point"] = cuts, point
    whole["asks"]["unknowns"] = {name: f"={name}" for name in point}
    return json.dumps(whole)


@pytest.fixture(scope="module")
def known():
    """The problems that gen.py reads of proofs of known gains, by name."""
    return {name: gen.read(text()) for name, text in KNOWN.items()}


@pytest.mark.slow
def test_rocq_proves_the_poles_of_known_gains(theory, known):
    texts = [gen.written(problem) for problem in known.values()]
    counts = [len(problem.regions) for problem in known.values()]
    assert rocq.prove(theory, "known", texts) == sum(counts)
    assert dict(zip(known, counts)) == {
        "every region": 7, "acceleration": 1, "cells": 1, "finer cells": 1,
        "a law": 3, "a dynamic law": 1, "a law's norms": 1, "norms": 1,
    }  # fmt: skip
    assert texts[3].count("Cut") == 1 + 2 * 7 and "%nat 1 2" in texts[3]


@pytest.mark.slow
def test_rocq_accepts_no_changed_cells_and_no_changed_law(theory, known):
    cells, law = (gen.written(known[name]) for name in ("finer cells", "a law"))
    tree = "cells := (Cut "
    i, j = (int(x) for x in cells.split(tree)[1].replace("%nat", "").split()[:2])
    other = ({0, 1, 2} - {i, j}).pop()
    changed = {
        "an edge": cells.replace(f"{tree}{i}%nat {j}", f"{tree}{i}%nat {other}"),
        "no edge": cells.replace(f"{tree}{i}%nat {j}", f"{tree}{i}%nat {i}"),
        "no middle": cells.replace("%nat 1 2", "%nat 0 2", 1),
        "one cell": cells.replace("(Cell [:: [:: ", "(Cell [:: [:: -7", 1),
        "no corner": cells.replace("\n [:: (", "\n behead [:: (", 1),
        "a region": cells.replace("in_half_plane 0", "in_half_plane 1"),
        "a sensor": law.replace("(Controller \n [:: [:: ", "(Controller \n [:: [:: -"),
        "a plant": law.replace("(Mechanics [:: [:: ", "(Mechanics [:: [:: 9"),
        "a disk": law.replace("in_disk 20", "in_disk 19"),
    }  # fmt: skip
    for what, text in changed.items():
        assert text not in (cells, law), what
        with pytest.raises(rocq.Failed):
            rocq.prove(theory, "changed", [text])


@pytest.mark.parametrize("name", KNOWN)
def test_the_pencils_have_the_poles_of_the_loop(known, name):
    """Those of each vertex, of M z'' + .. or of a law with its states, by floats."""
    loop = known[name].loop
    _, _, pencils = loop.pencils()
    for (E, A), v in zip(pencils, loop.vertices, strict=True):
        E, A = np.array(E, float), np.array(A, float)
        found = np.linalg.eigvals(np.linalg.solve(E, A))
        assert np.sort_complex(found) == pytest.approx(np.sort_complex(poles(loop, v)))


def floats(matrix):
    return np.array([[float(Fraction(e)) for e in row] for row in matrix])


def poles(loop, v):
    """Eigenvalues of the loop at a vertex, written down a second time."""
    x = {k: floats(v[k]) for k in loop.names}
    K, U, K_A = (np.array(m, float) for m in (loop.K, loop.U, loop.K_A))
    if loop.mechanical:
        n, p = loop.n, loop.p
        M = x["M"] - (x["B"] @ K_A if K_A.size else 0)
        E = np.eye(2 * n + p)
        E[n : 2 * n, n : 2 * n] = M
        A = np.zeros_like(E)
        A[:n, n : 2 * n] = np.eye(n)
        A[n : 2 * n, : 2 * n] = -np.hstack([x["S"], x["D"]])
        if p:
            A[2 * n :, :n] = U
        B = np.zeros((2 * n + p, loop.m))
        B[n : 2 * n] = x["B"]
    else:
        E, A, B = x["E"], x["A"], x["B"]
    if not hasattr(loop, "law"):
        return np.linalg.eigvals(np.linalg.solve(E, A + (B @ K if K.size else 0)))
    law = {k: floats(loop.law[k]) for k in loop.PARTS}
    N, c = len(E), len(law["E"])

    def motion(state):
        """(x', c') of the loop at (x, c), by its equations."""
        x, own = state[:N], state[N:]
        seen = law["rows"] @ x
        u = K @ (law["of_sensors"] @ seen + law["of_states"] @ own)
        free = np.concatenate([np.zeros(c - loop.f), u[loop.m :]])
        own = np.linalg.solve(law["E"], law["A"] @ own + law["B"] @ seen + free)
        return np.concatenate([np.linalg.solve(E, A @ x + B @ u[: loop.m]), own])

    return np.linalg.eigvals(np.transpose([motion(e) for e in np.eye(N + c)]))


def test_a_known_gain_that_is_not_covered_is_refused():
    data = json.loads(proof_of("known law").text)
    disk = next(r for r in data["asks"]["requirements"] if r.get("form") == "disk")
    box = proof_of("known gain, in a box").text
    refused = {
        "ranges": proof_of("known gain").text,
        "cut as one": box,
        "plant of ticks": json.dumps(
            data
            | {"asks": data["asks"] | {"plant": data["asks"]["plant"] | {"dt": "1"}}}
        ),
    }
    for words, text in refused.items():
        with pytest.raises(gen.Refused, match=words):
            gen.read(text)
    disk["form"] = "matrices"
    with pytest.raises(gen.Refused, match="another name"):
        gen.read(json.dumps(data))


def test_cells_that_show_nothing_are_said():
    data = json.loads(proof_of("known dynamic law").text)
    data["data"]["K"] = [[str(-9 * float(x)) for x in row] for row in data["data"]["K"]]
    with pytest.raises(gen.Failed, match="cell's matrix"):
        gen.written(gen.read(json.dumps(data)))


SAMPLED = {  # of one plant, of a box with P at each corner, of a clock that varies
    name: test_sampled_text.CASES[name]
    for name in ("one plant", "a box", "a clock that varies")
}


@pytest.fixture(scope="module")
def sampled():
    """What gen.py writes of sampled loops, and the boxes that it reads."""
    texts = [test_sampled_text.proof(name).text for name in SAMPLED]
    found = [gen.read(text) for text in texts]
    return [gen.written(boxes) for boxes in found], found


@pytest.mark.slow
def test_rocq_proves_the_last_step_of_sampled_loops(theory, sampled):
    texts, found = sampled
    assert rocq.prove(theory, "proofs", texts) == sum(map(len, found)) == 6
    kinds = {"with_P" if box[2] else "plain" for boxes in found for box in boxes}
    assert kinds == {"with_P", "plain"}


@pytest.mark.slow
def test_rocq_accepts_no_changed_ball(theory, sampled):
    text = sampled[0][0]
    ((_, share, _, ((_, ball),)),) = sampled[1][0]
    larger = str(ball.e << 110)
    changed = {
        "a larger radius": text.replace(f"]] {ball.e}", f"]] {larger}"),
        "a middle": text.replace("Ball [:: [:: ", "Ball [:: [:: -", 1),
        "a negative rate": text.replace("contract 5 (", "contract 5 (-"),
        "no witness": text.replace(
            "seq witness := [:: ", "seq witness := [:: ] ++ [:: (0, "
        ),
    }
    assert share == 0
    for what, other in changed.items():
        assert other != text, what
        with pytest.raises(rocq.Failed):
            rocq.prove(theory, "changed", [text, other])


def test_a_ball_exceeds_its_least_form(sampled):
    """The integers that Rocq decides are below each block that the ball encloses."""
    rng = np.random.default_rng(3)
    for _, _, _, corners in (box for boxes in sampled[1] for box in boxes):
        for _, ball in corners:
            least = np.array(gen.least(ball), float) / ball.d
            middle = np.array(ball.a, float) / ball.d
            away = rng.normal(size=middle.shape)
            away *= ball.e / ball.d / np.linalg.norm(away, 2)
            x = middle + away
            assert np.linalg.eigvalsh(x + x.T - least)[0] > -1e-12
            assert np.linalg.eigvalsh(least)[0] > 0


def test_what_the_checker_refuses_is_refused():
    data = json.loads(test_sampled_text.proof("one plant").text)
    data["data"]["rate"] = "0.1"
    with pytest.raises(gen.Failed, match="checker refuses"):
        gen.read(json.dumps(data))


@pytest.mark.slow
def test_rocq_accepts_nothing_that_is_changed(theory):
    problem = gen.read(file_of("one plant"))
    text = gen.written(problem)
    gain = str(problem.loop.K[0][0])
    P, w = "P : seq (seq Z) := [:: [:: ", "w_0 : seq (seq witness) := "
    alpha = "alpha_0 : numbers := [:: [:: "
    changed = {
        "the gain": text.replace(gain, str(-float(gain)), 1),
        "the plant": text.replace("[:: 3; -1.2]", "[:: -3; -1.2]"),
        "the region": text.replace(alpha, alpha + "9"),
        "its words": text.replace("in_half_plane 0", "in_half_plane 0.001"),
        "P": text.replace(P, P + "-"),
        "no witness": text.replace(w, w + "[::]. Definition unused := "),
    }
    for what, other in changed.items():
        assert other != text, what
        with pytest.raises(rocq.Failed):
            rocq.prove(theory, "changed", [text, other])


@pytest.mark.slow
@pytest.mark.parametrize(
    "end, words",
    [
        ("", "doesn't end with all"),
        (gen.END.format("one"), "doesn't end with all"),
        (gen.END.format("one, two"), "axioms"),
    ],
)
def test_rocq_must_say_that_nothing_is_assumed(end, words, theory):
    text = "Axiom bold : False.\nTheorem one : True. exact I. Qed.\n"
    text += "Theorem two : False. exact bold. Qed.\n"
    with pytest.raises(rocq.Failed, match=words):
        rocq.prove(theory, "bold", [text + end])


def test_no_theorem_is_admitted():
    files = list(rocq.HERE.glob("*.v"))
    assert {f.stem for f in files} == set(rocq.THEORY)
    for file in files:
        words = file.read_text("utf-8").split()
        assert not {"Axiom", "Admitted.", "admit.", "Parameter"} & set(words), file


def test_other_files_are_refused_in_one_line(tmp_path, capsys):
    data = json.loads(file_of("one plant"))
    faults = {
        "version": data | {"version": 3},
        "'delay'": data | {"kind": "delay"},
        "without a text": {k: v for k, v in data.items() if k != "text"},
        "common P": data | {"asks": data["asks"] | {"unknowns": {"V": "1"}}},
    }
    for words, changed in faults.items():
        path = tmp_path / "proof.json"
        path.write_text(json.dumps(changed), "utf-8")
        assert gen.main([str(path)]) == 3
        said = capsys.readouterr()
        assert words in said.err and said.err.count("\n") == 1 and not said.out


def test_what_is_false_has_no_witness():
    data = json.loads(file_of("one plant"))
    K = data["data"]["K"]
    data["data"]["K"] = [[str(-float(x)) for x in row] for row in K]
    with pytest.raises(gen.Failed, match="block of a vertex"):
        gen.written(gen.read(json.dumps(data)))
    data["point"]["P"][0][0] = "-1"
    with pytest.raises(gen.Failed, match="P is positive"):
        gen.written(gen.read(json.dumps(data)))


@pytest.mark.parametrize("seed", seeds(8))
def test_a_witness_shows_what_eigenvalues_say(seed):
    draw = random.Random(seed)
    n, scale = draw.randint(1, 6), 10 ** draw.randint(0, 40)
    rows = [[draw.randint(-9, 9) for _ in range(n)] for _ in range(n)]
    floor = draw.choice([-3, 1])  # a matrix above it, or one that isn't definite
    product = gen.product(rows, gen.transposed(rows))
    for i in range(n):
        product[i][i] += floor
    G = [[scale * a for a in row] for row in product]
    least = np.linalg.eigvalsh(np.array(product, float))[0]
    found = gen.witness(G)
    assert (found is not None) == (least > 0)
    if found:
        u, t, L = found
        assert u > 0 and t >= 0
        square = [row + [0] * (n - len(row)) for row in L]
        rest = gen.product(square, gen.transposed(square))
        R = [[Fraction(u) * g - t * a for g, a in zip(x, y)] for x, y in zip(G, rest)]
        for i, row in enumerate(R):
            assert row[i] > sum(abs(a) for j, a in enumerate(row) if j != i)


def test_the_lane_says_loudly_where_rocq_is_missing(monkeypatch, capsys):
    main = pytest.importorskip("formal.__main__").main
    monkeypatch.setattr(rocq, "ensure", lambda: False)
    assert main([]) == 0
    assert "NOTHING WAS PROVEN" in capsys.readouterr().err
    monkeypatch.setattr(shutil, "which", lambda name: None)
    assert not rocq.find()
