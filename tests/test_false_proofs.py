"""No proof of what isn't so, by package and checker; oracles are exact (rationals)."""

import json
import re
from dataclasses import dataclass
from fractions import Fraction
from types import SimpleNamespace

import numpy as np
import pytest
from flint import fmpq

import sosbook as sos
from sosbook import proofs
from sosbook.exact.checker import verdict as check
from sosbook.exact.definite import exact, semidefinite
from sosbook.exact.proof import Examined
from sosbook.exact.proof_file import ProofFile, parse
from sosbook.exact.rational import decimals
from sosbook.language import named
from sosbook.lmi import LMIProblem, Unknown, he, symmetric
from sosbook.requirements import LMIRegion, Requirement
from sosbook.requirements.hinf import HInfinity
from sosbook.requirements.stability import Stability
from sosbook.requirements.vocabulary import GAMMA, SIGMA, U_MAX
from sosbook.requirements.weights import semidefinite_weight
from sosbook.runtime.names import sane_name
from sosbook.synthesis.quotient import affine_in_quotient
from sosbook.synthesis.request import Request
from tests import energy_to_peak
from tests.asking import asked_by, asking
from tests.cases import campaign, seeds
from tests.closed import analyse_loop
from tests.hunt import truth
from tests.hunt.tampering import verdicts

ONE = np.eye(2)
PLANT = sos.SecondOrderSystem(
    [[2, 0], [0, 1]], [[0.4, -0.1], [-0.1, 0.2]], [[6, -2], [-2, 4]], ONE, ONE
)
FACTORS = 1.0, 0.3, 1 / 9.81, 2.2046, 1e3


def changed(proof, change):
    """The contents of the file that asks what a proof asks, after a change of that."""
    asked = asked_by(proof)
    change(asked)
    return asking(asked)


def agree(proof):
    """Whether both readers accept a proof, and with the same claims."""
    return proof.proven and check.check(proof.text) == list(proof.claims)


# ---- what weighs a cost
def true_cost(plant, Q):
    """tr W'XW with A'X + XA = -Q without control, in rationals."""
    still = np.zeros((plant.m, 2 * plant.n))
    E, A, W = truth.loop(plant.vertices, [1], still, None)
    return truth.cost_of(E, A, W, still, SimpleNamespace(Q=Q, R=np.eye(plant.m)))


@pytest.mark.parametrize(
    "w, bound, true", [(1e-7, 2.525e6, 5.25e7), (1e-6, 252500, 3e5)]
)
def test_what_weighs_less_than_nothing_is_no_cost(w, bound, true):
    """Nothing of Q is left out because floats take it for a rounding error."""
    plant = sos.SecondOrderSystem(ONE, 2 * w * ONE, w * w * ONE, ONE, [[1.0], [1.0]])
    Q = np.diag([0, 0, 1.0, 0])
    cost = sos.QuadraticCost(Q, ONE, "F", bound=bound)
    proof = sos.analyse_pid(plant, np.zeros((2, 4)), requirements=[cost]).certify()
    assert agree(proof) and true_cost(plant, Q) < bound
    Q[0, 1] = Q[1, 0] = 1e-13
    assert true_cost(plant, Q) == pytest.approx(true, rel=1e-3) and true > bound
    with pytest.raises(ValueError, match="Q has a negative eigenvalue, in the states"):
        sos.QuadraticCost(Q, ONE, "F", bound=bound)

    def weigh(whole):
        asked = whole["requirements"][0]["Q"]
        asked[0][1] = asked[1][0] = "1e-13"

    assert verdicts(changed(proof, weigh)) == (False, False)


def low_rank(seed):
    rng = np.random.default_rng(seed)
    C = rng.normal(size=(rng.integers(1, 4), 4)) * rng.choice(FACTORS, 4)
    return C, rng


@pytest.mark.parametrize("seed", [*range(8), *campaign(range(8, 225))])
def test_weights_of_outputs_are_read_alike(seed):
    C, _ = low_rank(seed)
    given = C.T @ C
    design = sos.design_lqr(PLANT, given, ONE)
    cost = design.request.cost
    assert semidefinite(exact(cost.Q))
    assert semidefinite(exact(cost.Q) - exact((given + given.T) / 2))
    assert np.allclose(cost.Q, given, rtol=1e-12, atol=0)
    assert agree(design.certify())
    refused = sos.design_pid(PLANT, requirements=[cost.with_bound(0.98 * cost.bound)])
    assert agree(refused.infeasibility)


@pytest.mark.parametrize("seed", seeds(8))
def test_an_output_is_weighed_exactly(seed):
    """The file holds C; its cost is that of Q = C'C."""
    C, rng = low_rank(seed)
    noise = "F" if seed % 2 else "states"
    cost = sos.QuadraticCost(C=C, R=ONE, noise=noise)
    design = sos.design_pid(PLANT, requirements=[cost], minimize="cost")
    bound = design.request.cost.bound
    other = sos.design_lqr(PLANT, C.T @ C, ONE, noise=noise).request.cost.bound
    assert bound == pytest.approx(other, rel=0.03)
    proof = design.certify()
    asked = proof.data["requirements"][0]
    assert "Q" not in asked and np.array_equal(np.array(asked["C"], float), C)
    assert agree(proof)
    assert cost.truth(design.request.vertices, proof.K) < bound
    heavier = changed(proof, lambda whole: whole["requirements"][0].update(
        C=[[str(2 * Fraction(e)) if "e" not in e and "." not in e else
            repr(2 * float(e)) for e in row] for row in asked["C"]]
    ))  # fmt: skip
    assert verdicts(heavier) == (False, False)
    refused = sos.design_pid(PLANT, requirements=[cost.with_bound(0.9 * other)])
    assert agree(refused.infeasibility)


STILL = np.eye(2), [[-1, 1], [0, -1]]  # a loop without an input
EMPTY = {
    "no weight": lambda more: sos.design_pid(
        PLANT,
        requirements=[sos.QuadraticCost(np.zeros((4, 4)), ONE, bound=5.0)],
        **more,
    ).certify(),
    "no weight, refused": lambda more: (
        sos.analyse_pid(
            PLANT,
            -np.eye(2, 4),
            requirements=[sos.QuadraticCost(np.zeros((4, 4)), ONE, bound=1e-5)],
        ).infeasibility
    ),
    "no input": lambda more: analyse_loop(
        *STILL, requirements=[sos.QuadraticCost(ONE, [], bound=9.0)], **more
    ).certify(),
    "no input, an output": lambda more: analyse_loop(
        *STILL, requirements=[sos.QuadraticCost(C=[[1, 2]], R=[], bound=9.0)], **more
    ).certify(),
    "no input, refused": lambda more: (
        analyse_loop(
            *STILL, requirements=[sos.QuadraticCost(ONE, [], bound=0.1)]
        ).infeasibility
    ),
}


@pytest.mark.parametrize("name", EMPTY)
def test_weights_of_nothing_are_read_alike(name):
    for more in ({}, {"coupling": "slack"}):
        assert agree(EMPTY[name](more))


@pytest.mark.parametrize("name", "QR")
@pytest.mark.parametrize("factor", FACTORS)
def test_weights_asymmetric_by_a_rounding_are_made_symmetric(name, factor):
    size = 4 if name == "Q" else 2
    X = factor * (np.eye(size) + 0.3)
    X[0, 1] += 5e-13 * factor
    given = {"Q": np.eye(4), "R": ONE} | {name: X}
    design = sos.design_lqr(PLANT, **given)
    held = getattr(design.request.cost, name)
    assert (held == held.T).all() and np.allclose(held, X, rtol=1e-11)
    assert agree(design.certify())
    X[0, 1] += 1e-9 * factor
    with pytest.raises(ValueError, match=f"{name} must be symmetric"):
        sos.QuadraticCost(**given)


def test_what_is_mended_has_no_units():
    """A weight is mended, or refused, alike in all units of the states."""
    rng = np.random.default_rng(5)
    for _ in range(20):
        C, unit = rng.normal(size=(1, 5)), 10.0 ** rng.integers(-9, 9, 5)
        Q = semidefinite_weight("Q", (C * unit).T @ (C * unit))
        assert np.allclose(Q / np.outer(unit, unit), C.T @ C, rtol=1e-12, atol=0)
        bad = np.outer(unit, unit) * (C.T @ C - 1e-9 * np.eye(5))
        with pytest.raises(ValueError, match="negative eigenvalue"):
            semidefinite_weight("Q", (bad + bad.T) / 2)


@pytest.mark.parametrize(
    "more, words",
    [
        (dict(R=ONE), "give one of Q and C"),
        (dict(Q=ONE, C=ONE, R=ONE), "give one of Q and C"),
        (dict(Q=ONE), "R is missing"),
        (dict(Q=ONE, R=[[1, 2], [2, 4]]), "R must be positive definite"),
        (dict(Q=[[1, 1], [1, 0]], R=ONE), "negative eigenvalue, in the states .1, 2."),
        (dict(Q=[[1, 2]], R=ONE), "Q must be square"),
    ],
)
def test_weights_that_are_none_are_named(more, words):
    with pytest.raises(ValueError, match=words):
        sos.QuadraticCost(**more)


# ---- regions that are asked twice
CLEAR = pytest.param(0.743, marks=pytest.mark.last_digits)  # by 1e-17


@pytest.mark.parametrize("sigma", [0.73, 0.739, CLEAR, 0.744, 0.763])
def test_a_wall_beside_a_wall_keeps_its_block(sigma):
    """The second one lies one float further, and a pole between the two."""
    farther, e = float(np.nextafter(sigma, 9)), 5e-17
    region = LMIRegion.half_plane(sigma, "a") & LMIRegion.half_plane(farther, "b")
    plant = sos.SecondOrderSystem([[1]], [[1 + sigma]], [[sigma]], [[1]])
    found = sos.analyse_pid(plant, [[-e, -e]], region=region)
    # s^2 + (D + e) s + S + e, negative at -farther: a pole lies right of it
    damping, at = exact(1 + sigma) + exact(e), exact(farther)
    beyond = at * at - damping * at + exact(sigma) + exact(e) < 0
    proven = found.status == "feasible" and found.certify().proven
    assert not (beyond and proven)
    assert beyond or found.status != "infeasible"
    assert agree(found.certify()) if proven else sigma != 0.743  # a clear one


TWICE = {
    "sigma": sos.PoleRegion(sigma=0.5) & sos.PoleRegion(sigma=0.5, rho=8),
    "all of it": sos.PoleRegion(sigma=0.5) & sos.PoleRegion(sigma=0.5),
    "disk": LMIRegion.disk(8) & LMIRegion.disk(8),
    "mine": LMIRegion([[1]], [[1]], "mine") & LMIRegion.half_plane(0.5),
    "mine, of another size": LMIRegion([[2]], [[2]], "mine")
    & LMIRegion.half_plane(0.5),
    "left of zero": LMIRegion.half_plane(0) & sos.PoleRegion(rho=9),
}


@pytest.mark.parametrize("name", TWICE)
def test_a_region_that_is_named_twice_is_proven_by_both(name):
    design = sos.design_pid(PLANT, region=TWICE[name])
    proof = design.certify()
    assert agree(proof)
    owners = {k.requirement for k in proof.blocks if k.requirement}
    assert owners == {r.key for _, r in design.request.claims.statements()}
    assert len(proof.claims) == 1 + len(design.request.requirements)
    refused = sos.design_pid(
        PLANT,
        region=TWICE[name],
        gamma=1e-4,
        saturation=sos.Saturation(1, [0.1, 0.1, 0, 0]),
    )
    assert refused.status == "infeasible" and agree(refused.infeasibility)


def test_what_excludes_at_sight_does_so_exactly():
    for rho in (0.3, 1 / 9.81, 2.2046, 3.0):
        wall, disk = LMIRegion.half_plane(rho), LMIRegion.disk(rho)
        assert disk.contradicts(wall)
        larger = LMIRegion.disk(float(np.nextafter(rho, 9)))
        assert not larger.contradicts(wall)


def test_each_claim_stands_beside_the_one_who_demands_its_blocks():
    region = sos.PoleRegion(sigma=0.3, theta=1.2, rho=20)
    asked = dict(region=region, gamma=5.0, saturation=sos.Saturation(90, [1, 0, 0, 0]))
    request = Request(PLANT, **asked)
    said = request.claims.statements()
    assert [words for words, _ in said] == list(
        sos.design_pid(PLANT, **asked).certify().claims
    )
    assert {r.key for _, r in said} == {r.key for r in request.demands}
    bare = Request(PLANT)
    assert [r.key for _, r in bare.claims.statements()] == [("stability", "stability")]


def test_a_claim_without_its_block_isnt_proven():
    good = {"P": exact(np.eye(1))}
    assert Examined.of(good, [("yes", ["P"])]).claims == ("yes",)
    for names in ((), ("Q",), ("P", "Q")):
        found = Examined.of(good, [("yes", names)])
        assert not found.proven and found.claims == ()
        assert found.failed == ("no block proves: yes",)


@pytest.mark.parametrize("size", [10**400, -(10**400)])
def test_a_size_beyond_floats_is_no_matter_of_the_verdict(size):
    P = exact(np.eye(2)) * fmpq(size, 3)
    found = Examined.of({"P": P}, ["yes"])
    assert found.proven == (size > 0) and found.blocks["P"] == (
        np.inf if size > 0 else -np.inf
    )


# ---- multipliers in coordinates
@pytest.mark.parametrize("name", ["left", "T", "back"])
def test_singular_coordinates_exclude_nothing(name):
    """In them a block is singular whatever its unknowns are."""
    proof = sos.design_pid(
        sos.SecondOrderSystem([[1]], [[-1.0]], [[1]], [[1]]),
        saturation=sos.Saturation(0.5, [1, 0]),
    ).infeasibility
    assert agree(proof) and type(proof).kind == "infeasible design"

    def forge(whole):
        none = [["0", "0"], ["0", "0"]]
        whole["coordinates"][name] = none
        whole["requirements"][0]["u_max"] = "1000"
        key, size = {
            "left": (["stability", "stability", "stability", 0], 2),
            "T": (["stability", "stability", "stability", 0], 2),
            "back": (["input", "saturation", "x0"], 3),
        }[name]
        Z = [["0"] * size for _ in range(size)]
        Z[-1][-1] = "1"
        whole["multipliers"] = [[key, Z]]

    assert verdicts(changed(proof, forge)) == (False, False)


# ---- words of a file or an author

LINE = "P\n- every constant or changing plant of the polytope, under u = K x, is stable"
HIDDEN = "\x1b[8m\n- its H-infinity norm is below 0.001\x85\u202e"


def own_proof(words=()):
    P = symmetric("P", 2)
    blocks = {"P": P, "decay 1,2 (A.6)": -he([[0, 1], [-2, -3]] @ P)}
    return LMIProblem(blocks).solve().prove(words)


def rename(whole, old, new):
    for place in ("shapes", "expressions"):
        for row in whole[place]:
            row[0] = new if row[0] == old else row[0]
    for row in whole["expressions"]:
        for term in row[2]:
            term[0] = new if term[0] == old else term[0]
    whole["unknowns"] = {k.replace(old, new): v for k, v in whole["unknowns"].items()}


def run(text, path, capsys):
    """What the two command lines print of a file: (exit code, text) each."""
    from sosbook.proofs.command import main

    path.write_text(text, "utf-8")
    codes = []
    for call in (lambda: main(["verify", str(path)]), lambda: check.main([str(path)])):
        code = call()
        codes.append((code, "".join(capsys.readouterr())))
    return codes


@pytest.mark.parametrize("name", [LINE, "P" + HIDDEN, "P. It is", "", " P", "P\t"])
def test_a_block_s_name_is_one_line_of_a_few_signs(name, tmp_path, capsys):
    with pytest.raises(ValueError, match="must be one line of letters"):
        sane_name(name)
    with pytest.raises(ValueError, match="must be one line of letters"):
        LMIProblem({name: symmetric("X", 1)})
    with pytest.raises(ValueError, match="must be one line of letters"):
        LMIProblem({"X": symmetric(name, 1)})
    for old in ("P", "decay 1,2 (A.6)"):
        whole = changed(own_proof(), lambda whole, old=old: rename(whole, old, name))
        assert verdicts(whole) == (False, False)
        for code, printed in run(json.dumps(whole), tmp_path / "proof.json", capsys):
            assert code == 1 and "\x1b" not in printed and "\u202e" not in printed
            assert len(printed.splitlines()) == 1


def test_an_author_s_words_are_quoted(tmp_path, capsys):
    proof = own_proof(("A is stable", HIDDEN))
    assert proof.proven and agree(proof)
    ours, theirs = run(proof.text, tmp_path / "proof.json", capsys)
    assert ours == theirs and ours[0] == 0
    first, claim, *said = ours[1].splitlines()
    assert first == "proven of an author's LMIs:"
    assert claim == f"- {proof.claims[0]}"
    assert [line.split(": ", 1)[1] for line in said] == [
        json.dumps(words) for words in proof.statement
    ]
    assert all("by their author's word alone" in line for line in said)


def test_no_text_of_a_file_moves_the_cursor(tmp_path, capsys):
    proof = sos.design_pid(PLANT, region=sos.PoleRegion(sigma=0.5)).certify()

    def each(whole):
        yield lambda w: w.update({HIDDEN: 1})
        for key in whole:
            yield lambda w, key=key: w.update({key: HIDDEN})
        yield lambda w: w["requirements"][0].update({HIDDEN: "1"})
        for key in whole["requirements"][0]:
            yield lambda w, key=key: w["requirements"][0].update({key: HIDDEN})
        for key in whole["unknowns"]:
            yield lambda w, key=key: w["unknowns"].update({key + HIDDEN: [["1"]]})
        yield lambda w: w["plant"].update(kind=HIDDEN)

    for change in each(asked_by(proof)):
        whole = changed(proof, change)
        path = tmp_path / "proof.json"
        if ProofFile.owner(whole["kind"]) is not None:
            assert verdicts(whole)[0] is False
        for code, printed in run(json.dumps(whole), path, capsys):
            assert code in (1, 2, 3) and printed.replace("\n", "").isprintable()
            assert len(printed.splitlines()) <= 1 and "Traceback" not in printed
            assert not re.search("^(proven|- )", printed, re.M)


def test_a_version_is_a_whole_number():
    proof = own_proof()
    for version in (2.0, True, "2", None, 1, 3):
        whole = json.loads(proof.text) | {"version": version}
        assert verdicts(whole) == (False, False)


# ---- classes of others
def test_a_class_changes_no_proof_that_is_there():
    proof = sos.design_pid(
        PLANT, saturation=sos.Saturation(90, [0.1, 0, 0, 0])
    ).certify()
    small = changed(proof, lambda w: w["requirements"][0].update(u_max="0.001"))

    class Mine(sos.Saturation):
        """Declares no kind, and has neither blocks nor the same words."""

        def once(self, loop):
            return ()

        def claim(self):
            return "whatever"

    assert proof.verify() and verdicts(small) == (False, False)
    asked = Mine(90, [0.1, 0, 0, 0])
    with pytest.raises(ValueError, match="Mine has no kind of its own"):
        sos.design_pid(PLANT, requirements=[asked])


@pytest.mark.parametrize("base", [sos.Saturation, Requirement, LMIRegion, HInfinity])
def test_a_kind_has_one_owner(base):
    for kind in ("input", "region", "stability"):
        with pytest.raises(ValueError, match=f"kind = '{kind}' is that of sosbook"):
            type("Mine", (base,), {"kind": kind})
    with pytest.raises(ValueError, match="must be one line"):
        type("Mine", (base,), {"kind": LINE})
    with pytest.raises(ValueError, match="kind = 'design' is that of sosbook"):
        type("Mine", (proofs.DesignProof,), {"kind": "design"})
    assert Requirement.owner("input") is sos.Saturation
    assert ProofFile.owner("design") is proofs.DesignProof


def test_a_cell_that_is_run_again_takes_its_own_place():
    first, second = (
        type("Again", (Stability,), {"kind": "again", "name": "again"})
        for _ in range(2)
    )
    assert Requirement.owner("again") is second is not first
    for cls in (first, second):
        assert Request(PLANT, requirements=[cls()]).demands


@dataclass(frozen=True, eq=False)
class Trivial(Requirement):
    """Its author says that it implies stability; its block demands nothing."""

    kind = name = "trivial"
    implies_stability = affine_in_quotient = True
    parts = ("block",)

    def pair(self, loop, c):
        for part in self.parts:
            yield part, c.EPE

    def slack(self, loop, c, i):
        return self.pair(loop, c)

    def claim(self):
        return "nothing" + HIDDEN

    def truth(self, loops, K, K_A=None):
        return 0.0


@dataclass(frozen=True, eq=False)
class Empty(Trivial):
    """No block at all."""

    kind = name = "empty"
    parts = ()


@pytest.mark.parametrize("coupling", ["pairs", "slack"])
def test_stability_is_proven_whatever_an_author_says(coupling):
    falling = sos.SecondOrderSystem([[1]], [[-1]], [[1]], [[1]])
    more = dict(coupling=coupling, requirements=[Trivial()])
    found = sos.analyse_pid(falling, [[0, 0]], **more)
    assert found.status == "infeasible"
    design = sos.design_pid(falling, **more)
    assert ("stability", "stability") in [r.key for r in design.request.demands]
    proof = design.certify()
    assert proof.proven and (design.poles().real < 0).all()
    words = proof.claims[1]
    assert words.startswith("trivial, by its author's theorem: \"nothing")
    assert words.isprintable() and len(str(proof).splitlines()) == 3
    assert check.check(proof.text) == list(proof.claims)


class Untold(Trivial):
    """What is named can't be told in one matrix."""

    kind = name = "untold"

    def pair(self, loop, c):
        yield "block", named("half", c.EPE / 2)


@pytest.mark.parametrize("coupling", ["pairs", "slack"])
def test_a_theorem_that_cannot_be_traced_is_decided_here_alone(coupling):
    proof = sos.design_pid(PLANT, requirements=[Untold()], coupling=coupling).certify()
    assert proof.proven and proof.verify() and len(proof.claims) == 2
    with pytest.raises(check.Beyond):
        check.check(proof.text)
    whole = parse(proof.text)[1]
    minus = {k: decimals(-np.array(x, float)) for k, x in whole["unknowns"].items()}
    assert not proofs.DesignProof.of(whole | {"unknowns": minus}).proven


def test_a_requirement_without_blocks_proves_nothing():
    design = sos.design_pid(PLANT, requirements=[Empty()])
    proof = design.certify()
    assert not proof.proven and proof.claims == ()
    assert "an author's claim rests on no block" in proof.failed[0]


def of_block(kind, write):
    """A requirement with one block; its author says that it is affine."""

    def pair(self, loop, c):
        yield kind, write(c)

    return type(kind.title(), (Trivial,), dict(kind=kind, name=kind, pair=pair))()


def lever(masses=(0.5, 1.5)):
    """Masses along two columns: vertices suffice for what is affine."""
    first, second = np.array([[1, 1], [1, 1]]), np.array([[0.25, 0.5], [0.5, 1]])
    return sos.Polytope(
        [
            sos.SecondOrderSystem(ONE + a * first + b * second, ONE, ONE, ONE, ONE)
            for a in masses
            for b in masses
        ]
    )


@pytest.mark.parametrize(
    "requirement, fine",
    [
        # E P E' < 100 isn't affine after a division by E, whatever it says
        (of_block("mass", lambda c: 100 * sos.lmi.eye(4) - c.EPE), False),
        # quadratic in the quotient's B_w
        (of_block("square", lambda c: c.EPE - c.Bw @ c.Bw.T), False),
        # a division by E doesn't leave one entry of an affine block alone
        (of_block("entry", lambda c: c.EPE[:1, :1]), False),
        # a block of the package
        (of_block("fine", lambda c: -he(c.Theta) - c.EPE), True),
        (energy_to_peak.EnergyToPeak(2.0), True),
        (energy_to_peak.EnergyToPeak(), True),
        (sos.QuadraticCost(np.eye(4), ONE, "F", 9.0), True),
        (HInfinity(3.0), True),
        *((part, True) for part in sos.PoleRegion(0.2, 1.2, 8).parts),
    ],
)
def test_affinity_is_tried_before_pairs_are_left_out(requirement, fine):
    plants = lever()
    request = Request(plants)
    assert len(request.pairs) == 4
    assert affine_in_quotient(requirement, request) == fine
    if requirement.parameter is None or requirement.bound is not None:
        asked = Request(plants, requirements=[requirement])
        assert len(asked.pairs) == (4 if fine else 10)


@pytest.mark.parametrize("name", ["P", "P 1", "Y", "V", "size for input saturation"])
def test_an_unknown_that_every_problem_has_is_named(name):
    class Owning(Trivial):
        kind = "owning"

        def unknowns(self, problem):
            return (Unknown(name, 2, symmetric=True),)

    with pytest.raises(ValueError, match=f"an unknown of its own is called '{name}'"):
        sos.design_pid(PLANT, requirements=[Owning()])


def test_a_proof_holds_for_its_number_and_no_harder_one():
    for value in (0.3, 1 / 9.81, 2.2046, 1e9):
        beyond = float(np.nextafter(value, np.inf))
        for parameter in (SIGMA, GAMMA, U_MAX):
            assert parameter.harder_than(value, value) == 0
            assert parameter.harder_than(beyond, value) == parameter.harder
            assert parameter.harder_than(value, beyond) == -parameter.harder


def test_a_requirement_of_another_name_is_called_so_by_both_readers():
    proof = sos.design_pid(PLANT, gamma=5.0).certify()
    whole = changed(proof, lambda asked: asked["requirements"][0].update(name="ours"))
    ours = type(proof)(json.dumps(whole))
    assert agree(ours) and ours.claims[1] == "ours: its H-infinity norm is below 5"


class Bold(LMIRegion):
    """Its author's words say more than its matrices do."""

    kind = "bold"

    def claim(self):
        return "all its poles are real"


def test_an_author_s_region_is_read_as_theirs_and_quoted():
    for region in (Bold.half_plane(0.5), Bold([[2]], [[2]], "mine"), Bold.disk(9.0)):
        design = sos.design_pid(PLANT, region=region)
        proof = design.certify()
        assert proof.proven and type(design.request.parts[0]) is Bold
        said = f'{region.name}, by its author\'s theorem: "all its poles are real"'
        assert proof.claims[1] == said
        assert ("stability", "stability") in [r.key for r in design.request.demands]
        assert list(check.check(proof.text)) == list(proof.claims)
    stuck = sos.SecondOrderSystem(ONE, ONE, ONE, [[1], [1]])
    refused = sos.design_pid(stuck, region=Bold.half_plane(3.0)).infeasibility
    assert agree(refused) and refused.claims[0].endswith(
        "its poles lie in the region alpha + beta s + beta' s* < 0, "
        "with alpha = [[6]] and beta = [[1]]"
    )
