"""Texts of proof files, by hand: they say what theorems say, and no other text does."""

import json
import re

import numpy as np
import pytest
from flint import fmpq

import sosbook as sos
from sosbook.delay.proofs import read_delay_request
from sosbook.exact.checker import kernel, verdict
from sosbook.exact.checker.arithmetic import number
from sosbook.exact.checker.text import ratio
from sosbook.exact.rational import exact, read_array, read_fractions, read_number
from sosbook.plants.as_data import read_plant
from sosbook.synthesis.error_loop import vertices_of
from sosbook.synthesis.fixed_mode import FixedModeRefusal
from sosbook.synthesis.known_proof import known_by_theorems
from sosbook.synthesis.observer_problem import ObserverProblem
from sosbook.synthesis.proofs import by_theorems
from sosbook.synthesis.regularity import mass_pairs
from sosbook.theorems import regular_mass
from tests.asking import mended
from tests.cases import campaign
from tests.hunt.tampering import verdicts
from tests.test_proof_files import PROOFS, proof_of


def blocks_of(proof):
    """What the functions of the theorems make of a file's data, by blocks' names."""
    data, kind = proof.data, proof.kind
    if kind == "known gain":
        return known_by_theorems(data)[-1]
    unknowns = data.get("unknowns", {}).items()
    values = {name: exact(read_array(x, None, None)) for name, x in unknowns}
    if kind == "design":
        return by_theorems(data)[-1]
    if kind == "delay":
        request = read_delay_request(data)
        if request.gain is None:
            frame, K = request.frame, exact(read_array(data["K"], None, None))
            values["X"] = K @ exact(frame.T) / exact(frame.scale) @ values["F"].T
        return request.blocks(values, exact)
    if kind == "observer":
        L, bound = read_array(data["L"], None, None), read_number(data["bound"])
        names = "K", "Q_F", "R_F", "C"
        given = (read_array(data[x], None, None) for x in names)
        noises = [read_array(w, None, None) for w in data["noises"]]
        plant = read_plant(data["plant"])
        problem = ObserverProblem(plant, vertices_of(plant), *given, noises)
        return problem.bounded(L, bound).text.blocks(values, exact)
    if kind == "regularization":  # the text is a Schur complement
        plant, n = read_plant(data["plant"]), len(data["K"][0])
        K, beta = exact(read_array(data["K"], None, n)), read_number(data["beta"])
        whole = {
            name: regular_mass(exact(M), exact(B), K, exact(beta))
            for name, (M, B) in mass_pairs(plant).items()
        }
        return {k: g[:n, :n] - g[:n, n:] @ g[n:, :n] for k, g in whole.items()}
    if kind == "lmi":
        blocks = {x: read_fractions(constant) for x, constant, _ in data["expressions"]}
        for name, _, terms in data["expressions"]:
            for unknown, turned, *sides in terms:
                left, right = map(read_fractions, sides)
                x = values[unknown].T if turned else values[unknown]
                blocks[name] = blocks[name] + left @ x @ right
        return blocks
    raise AssertionError(kind)


def key_in(proof, said, block):
    """The name of a block; those of a known gain have names beside their numbers."""
    if proof.kind != "known gain":
        return block
    name, c, kind, i = re.fullmatch(r"(.*) cell (\d+) (.*?) ?(\d+)", block).groups()
    names = [name for _, name, _ in proof.data["cells"]]
    kind = {"": "poles", "stability": "poles"}.get(kind, kind)
    word, _, point = kind.partition(" ")
    place = rf"{names.index(name) + 1}\.{c}"
    own = rf"(\.\d+)?\.of\.{point}" if point else r"(\.\d+)?" * (word == "u_max")
    label = rf"{word}{own}\.{place}(\.{i})?"
    return max((x for x in said if re.fullmatch(label, x)), key=len)


# of sampled loops test_sampled_text holds the blocks to floats
# The others of known gains have its blocks each.
NAMES = [x for x in PROOFS if x not in ("sampled", "known gain")]


@pytest.mark.parametrize("name", [*NAMES, *campaign(["known gain"])])
def test_each_line_says_what_the_theorem_says(name):
    """The two writings of a block are one matrix, but for its requirement's size.

    Any two numbers are, so theirs must be 1 or the size of a matrix in the same file.
    """
    proof = proof_of(name)
    said = proof.measured(lambda block: block)
    sizes = {True: {fmpq(1)}, False: set()}
    for block, matrix in blocks_of(proof).items():
        mine = said[key_in(proof, said, block)]
        size = mine[0, 0] / matrix[0, 0]
        assert size > 0 and mine.shape == matrix.shape
        assert (mine == size * matrix).all()
        sizes[len(mine) > 1].add(size)
    assert sizes[False] <= sizes[True]


# ------------------------------------------------------------------- attacks
def file_of(proof):
    return json.loads(proof.text)


def two():
    one = np.eye(2)
    return sos.SecondOrderSystem(
        [[2, 0], [0, 1]], [[0.4, -0.1], [-0.1, 0.2]], [[6, -2], [-2, 4]], one, one
    )


@pytest.fixture(scope="module")
def bounded():
    asked = dict(gamma=0.5, saturation=sos.Saturation(40, [0.1, 0.1, 0, 0]))
    return sos.design_pid(two(), region=sos.PoleRegion(sigma=0.3), **asked).certify()


def without(whole, start):
    whole["text"] = [x for x in whole["text"] if not x.strip().startswith(start)]


def set_in(whole, part, **more):
    whole[part] |= more


UNIT = [[str(int(i == j)) for j in range(4)] for i in range(4)]
NOUGHT = [["0"] * 4 for _ in range(2)]
ATTACKS = {
    "a block is left out": lambda w: without(w, "u_max:"),
    "all of a requirement is left out": lambda w: without(w, "hinf"),
    "a sign is left out": lambda w: without(w, "sign.gamma"),
    "P may be anything": lambda w: without(w, "P: "),
    "a smaller bound": lambda w: set_in(w, "data", u_max="0.001"),
    "a faster region in words": lambda w: w["data"].update({"sigma.1": "3"}),
    "data that the text defines": lambda w: set_in(w, "data", W=NOUGHT),
    "no pair": lambda w: set_in(w, "sets", pairs=[]),
    "the unit matrix for P": lambda w: set_in(w, "point", P=UNIT),
    "a part is defined anew": lambda w: w["text"].insert(-1, "  Theta = -EPE"),
    "another gain": lambda w: set_in(w, "data", K=NOUGHT),
    "an easier plant": lambda w: w["data"].update({"D.1": [["4", "0"], ["0", "4"]]}),
    "another kind": lambda w: w.update(kind="infeasible design"),
    "words": lambda w: w.update(claims=["it is optimal"]),
    "a requirement isn't asked": lambda w: w["asks"]["requirements"].pop(),
    "one number for two": lambda w: w["asks"]["requirements"][1].update(gamma="=u_max"),
    "a number in the words alone": lambda w: w["asks"]["requirements"][1].update(
        gamma="0.1"
    ),
    "a line in a name": lambda w: w["asks"]["requirements"][0].update(
        name="x\n- all is well"
    ),
}


@pytest.mark.parametrize("attack", ATTACKS)
def test_words_rest_on_the_lines_that_are_written_for_them(attack, bounded):
    whole = file_of(bounded)
    ATTACKS[attack](whole)
    assert verdicts(whole) == (False, False)
    easier = attack == "an easier plant"
    assert verdicts(mended(whole)) == (easier, easier)


def test_a_gain_isn_t_data_of_a_refusal():
    proof = proof_of("too little force")
    whole = file_of(proof)
    whole["unknowns"].pop("Y")
    whole["data"]["Y"] = [["0", "0"]]
    with pytest.raises(kernel.Refused):
        verdict.check(json.dumps(whole))
    assert not type(proof)(json.dumps(whole)).proven


def test_a_refusal_of_a_narrow_sector_says_nothing_of_a_wide_one():
    proof = sos.design_pid(
        sos.SecondOrderSystem([[1]], [[0]], [[0]], [[1]]),
        region=sos.PoleRegion(sigma=3, theta=1.03),
        saturation=sos.Saturation(1, [1, 0]),
    ).infeasibility
    assert proof.kind == "infeasible design" and "59.02 degrees" in proof.claims[0]
    for degrees in ("59.01", "59.1", "89.02"):
        whole = file_of(proof)
        (name,) = (k for k in whole["data"] if k.startswith("degrees"))
        assert whole["data"][name] == "59.02"
        whole["data"][name] = degrees
        with pytest.raises(kernel.Refused, match="don't belong to the sector"):
            verdict.check(json.dumps(whole))
        assert not type(proof)(json.dumps(whole)).proven


def test_multipliers_of_a_harder_request_exclude_no_easier_one():
    """They may exclude more than was asked, and then that has no answer either."""
    proof, seen = proof_of("fast with little force"), set()
    plant = sos.SecondOrderSystem([[1.0]], [[0.0]], [[0.0]], [[1.0]], [[1.0]])
    for u_max in (1.5, 5.0, 8.0, 40.0, 1000.0):
        whole = file_of(proof)
        whole["data"]["u_max"] = f"{u_max:g}"
        try:
            (words,) = verdict.check(json.dumps(whole))
        except kernel.Refused:
            seen.add(False)
            continue
        assert f"<= {u_max:g} from x0" in words
        bound = sos.Saturation(u_max, [1, 0])
        again = sos.design_pid(plant, region=sos.PoleRegion(3), saturation=bound)
        assert again.status == "infeasible"
        seen.add(True)
    assert seen == {True, False}


def unmoved(A, B, **mode):
    """A file of a mode of x' = A x + B u that no gain moves."""
    one = [[str(int(i == j)) for j in range(len(A))] for i in range(len(A))]
    plant = dict(kind="descriptor", C=one[:1], D_u=None)
    plant["vertices"] = [dict(E=one, A=A, B=B, B_w=B)]
    given = dict(plant=plant, U=[], K_A=None, K=None, requirement=None, place=[0, 0])
    return {"kind": "fixed mode", **given, **mode}


PAIR = unmoved(
    [["0", "1", "0"], ["-1", "0", "0"], ["0", "0", "-1"]],
    [["0"], ["0"], ["1"]],
    polynomial=["1", "0", "1"],
    rows=[["1", "0", "0"], ["0", "1", "0"]],
    witness=[],
)
ONE = unmoved(
    [["1", "0"], ["0", "-1"]],
    [["0"], ["1"]],
    polynomial=["-1", "1"],
    rows=[["1", "0"]],
    witness=[["1", "0"]],
)
REAL = unmoved(
    [["0", "1", "0"], ["1", "0", "0"], ["0", "0", "-1"]],
    [["0"], ["0"], ["1"]],
    polynomial=["-1", "0", "1"],
    rows=[["1", "0", "0"], ["0", "1", "0"]],
    witness=[],
)
DISK = {"kind": "region", "name": "disk", "form": "disk", "rho": "2", "centre": "-1"}
DISK |= dict(alpha=[["-2", "1"], ["1", "-2"]], beta=[["0", "1"], ["0", "0"]])
AROUND = unmoved(  # 0 and 3 have the distances 1 and 4 from the centre
    [["0", "1", "0"], ["0", "3", "0"], ["0", "0", "-1"]],
    [["0"], ["0"], ["1"]],
    polynomial=["0", "-3", "1"],
    rows=[["1", "0", "0"], ["0", "1", "0"]],
    witness=[],
) | {"requirement": DISK}
MODES = [
    (ONE, ["1", "0"], True),
    (ONE, ["1000", "0"], False),
    (ONE, ["1001/1000", "0"], False),
    (ONE, ["1", "1/10"], False),
    (PAIR, ["0", "1"], True),
    (PAIR, ["0", "-1"], True),
    (PAIR, ["-7", "55"], False),
    (PAIR, ["0", "0"], False),
    (REAL, ["1", "0"], True),
    (REAL, ["-1", "0"], False),
    (AROUND, ["3", "0"], True),
    (AROUND, ["0", "0"], False),
]


@pytest.mark.parametrize("asked, point, there", MODES)
def test_a_mode_is_where_the_words_say(asked, point, there):
    """That some mode breaks what is asked doesn't put it near any point."""
    proof = FixedModeRefusal.of(
        {k: v for k, v in asked.items() if k != "kind"} | {"point": point}
    )
    assert proof.proven == there
    if there:
        assert verdict.check(proof.text) == list(proof.claims)
        return
    with pytest.raises(kernel.Refused, match="no mode is near|keeps what"):
        verdict.text_of(asked | {"point": point})


LONG = "9" * 9001


@pytest.mark.parametrize("x", ["0", "-3", "7/22", LONG, f"-{LONG}/{LONG[:-1]}8"])
def test_numbers_of_any_length_are_read(x):
    """Python alone reads 4300 digits."""
    assert str(fmpq(ratio(x).numerator, ratio(x).denominator)) == x
    assert number(x) == ratio(x)


@pytest.mark.parametrize("x", ["-0", "07", "4/2", "3/1", "3/0", "1/02", LONG * 12])
def test_a_fraction_has_one_spelling(x):
    with pytest.raises(kernel.Refused):
        ratio(x)
