"""Hundreds of ways to spoil a proof file, and no false claim gets through.

With its text, digests and words written anew it may be a proof in its own right, of a
loop whose poles, by floats, lie where the claims say.
"""

import json

import pytest

import sosbook as sos
from sosbook.exact.checker.verdict import asked_of as asked
from sosbook.exact.proof_file import KINDS, ProofFile, load
from tests.asking import asked_by, asking, mended
from tests.cases import by_turns, campaign, later
from tests.hunt.tampering import (
    leaves,
    of_other_rank,
    put,
    tampered,
    true_claims,
    verdicts,
)
from tests.test_proof_files import BEYOND, checker, proof_of

LONG = (  # more changes each, most of them once a week
    "all at once",
    "H-infinity, slack",
    "too little force",
    "regular mass",
    "no mass without input",
    "delayed loop",
    "sampled",
    "a slow mode behind a delay",
)
NEW = (  # small ones of each kind
    "little force for a fast fall",
    "a mode at rest",
    "a mode on the imaginary axis",
    "a mode between two plants",
    "a pole of a given loop",
    "a singular mass",
    "two forms that grow",
    "a response out of reach",
    "an LMI of one's own",
    "an LMI of one's own, empty",
    "a loop that is late",
    "legendre",
    "interval of one point",
    "observer",
    "no observer",
    "known gain, outputs that differ",
    "known dynamic law",
    "a mode that no sensor sees",
    "sum of poles",
    "no controller of any order",
)


SMALL = (
    *NEW[2:7],
    "stability",
    "acceleration",
    "input in the output, slack",
    "a pole of a closed loop",
    "regular mass",
    "no mass without input",
    "observer",
)


@pytest.mark.parametrize("name", [*by_turns(SMALL, 0), *campaign(["sampled"])])
def test_floats_refuse_no_plant_of_a_file(name):
    """Of sizes and ranks that a request's input may not have; the checker has none."""
    whole = asked_by(proof_of(name))
    accepted = 0
    for path, value in leaves(whole):
        for change in of_other_rank(value):
            changed = asking(put(whole, path, change))
            package, alone = verdicts(changed)
            assert name in BEYOND or package == alone, (path, change)
            accepted += package and change != value
    assert accepted or name == "regular mass"


def test_an_observer_s_outputs_have_as_many_noises():
    """A column of zeros is no other covariance."""
    whole = asked_by(proof_of("observer"))
    wide = asking(put(whole, ("R_F",), [[*row, "0"] for row in whole["R_F"]]))
    assert verdicts(wide) == (False, False)


def test_every_kind_of_file_is_spoiled():
    assert {proof_of(name).kind for name in (*NEW, *LONG)} == set(KINDS)


@pytest.mark.parametrize(
    "name, most",
    [
        *((name, 30) for name in NEW),
        pytest.param("little force for a slow pair", 30, marks=pytest.mark.slow),
        *(pytest.param(name, 30, marks=pytest.mark.slow) for name in LONG),
        *later(*((name, 100) for name in NEW), *((name, 1000) for name in LONG)),
    ],
)
def test_no_tampering_gets_a_false_claim_through(name, most):
    proof = proof_of(name)
    assert proof.proven
    whole = asked_by(proof)
    tried = accepted = 0
    for path, changed in tampered(whole, most):
        package, alone = verdicts(asking(changed))
        tried += 1
        if not (package or alone):
            continue
        accepted += 1
        assert path[0] != "kind", path
        truth = true_claims(changed)
        assert truth is not False, (path, package, alone)
        assert name in BEYOND or package == alone, (path, package, alone)
    assert tried >= min(most, 100)
    assert accepted < tried / 3


@pytest.mark.parametrize("name", ["stability", "delay", *BEYOND])
@pytest.mark.parametrize("key", ["claims", "blocks", "note ", "x"])
def test_a_file_says_nothing_that_isn_t_asked(name, key):
    """A file with its words or blocks, too, proves nothing, even if they're true."""
    proof = proof_of(name)
    asked = asked_by(proof) | {key: list(proof.claims)}
    assert verdicts(asking(asked)) == (False, False)


TEXTS = (
    "all at once",
    "H-infinity, slack",
    "regions",
    "too little force",
    *NEW[1:4],
    *NEW[5:],
    "delay, analysis",
    "sampled",
)


@pytest.mark.parametrize("name", TEXTS)
@pytest.mark.parametrize("most", [20, *campaign([60])])
def test_no_text_says_what_isn_t_asked(name, most):
    """Lines, data, sets and unknowns of a text that were changed, digests mended."""
    whole = json.loads(proof_of(name).text)
    before = asked(whole)
    for path, changed in tampered(whole, most):
        changed = mended(changed)
        package, alone = verdicts(changed)
        assert path[0] in ("asks", "data", "point", "multipliers") or not (
            package or alone
        ), path
        if package or alone:
            now = asked(changed)
            assert now != before and true_claims(now) is not False, path
            assert name in BEYOND or package == alone, path


@pytest.mark.parametrize("sigma", ["0.004", "0.0049999", "0.005", "0.02"])
def test_the_mean_of_the_poles_is_in_no_half_plane_that_begins_there(sigma):
    """It is -0.005, whatever the gain: what is asked left of it can't be had."""
    whole = asked_by(proof_of("a mode that no sensor sees"))
    whole["requirement"] = sos.LMIRegion.half_plane(float(sigma)).data()
    true = float(sigma) >= 0.005
    assert true_claims(whole) == true and verdicts(asking(whole)) == (true, true)


@pytest.mark.parametrize(
    "name, key, bound, true",
    [
        ("little force for a fast fall", "u_max", "1.99", True),  # 2 holds the fall
        ("little force for a fast fall", "u_max", "2.01", False),
        ("a response out of reach", "bound", "0.96", True),  # 0.9624 by least_norm
        ("a response out of reach", "bound", "0.97", False),
    ],
)
def test_a_bound_that_can_be_kept_is_not_refuted(name, key, bound, true):
    whole = asked_by(proof_of(name))
    path = next(p for p, _ in leaves(whole) if p[-1] == key)
    changed = put(whole, path, bound)
    assert true_claims(changed) == true and verdicts(asking(changed)) == (true, true)


def swapped():
    """Whole parts of one proof in the place of another's."""
    one = asked_by(proof_of("H-infinity, pairs"))
    other = asked_by(proof_of("cost of noise on F"))
    for key in one:
        if key != "kind":
            if json.dumps(one[key]) != json.dumps(other[key]):
                yield f"{key} of another proof", one | {key: other[key]}
    vertices = one["plant"]["vertices"]
    five, pushing, turned = ([[x, "0"], ["0", x]] for x in ("5", "-30", "-1"))
    for what, some in {
        "a vertex is added": [*vertices, vertices[0] | {"M": five}],
        "a vertex is replaced": [vertices[0], vertices[0] | {"S": pushing}],
        "the input is turned round": [v | {"B": turned} for v in vertices],
    }.items():
        yield what, one | {"plant": one["plant"] | {"vertices": some}}
    (bound,) = one["requirements"]
    yield "a smaller bound", one | {"requirements": [bound | {"gamma": "0.1"}]}
    yield "the same twice", one | {"requirements": [bound, bound]}
    refuted = asked_by(proof_of("too little force"))
    again = asked_by(proof_of("fast with little force"))
    yield "multipliers of another", refuted | {"multipliers": again["multipliers"]}
    (harder,) = refuted["requirements"]
    easy = [harder | {"u_max": "50"}]
    yield "multipliers of a harder request", refuted | {"requirements": easy}
    yield "no multipliers", refuted | {"multipliers": []}
    yield "one multiplier", refuted | {"multipliers": refuted["multipliers"][:1]}
    turned = [[key, [["-" + e for e in row] for row in z]]
              for key, z in refuted["multipliers"]]  # fmt: skip
    yield "negative multipliers", refuted | {"multipliers": turned}
    mode = asked_by(proof_of("a mode at rest"))
    slower = mode["requirement"] | {"sigma": "0.001"}
    yield "a harder region", mode | {"requirement": slower}
    yield "no region", mode | {"requirement": None}
    yield "no rows", mode | {"rows": [["0"] * 4] * len(mode["rows"])}
    yield "another point", mode | {"point": ["5", "0"]}
    yield "a double pole", mode | {"polynomial": ["0", "0", "1"]}
    mass = asked_by(proof_of("a singular mass"))
    yield "a mass that is regular", mass | {"between": [0, 0]}
    reached = asked_by(proof_of("a response out of reach"))
    yield "a norm that is reached", reached | {"bound": "40"}
    for what, file in {"moves a mode": mode, "reaches an output": reached}.items():
        moved = [v | {"B": [[str(k)] for k, _ in enumerate(v["B"], 1)]}
                 for v in file["plant"]["vertices"]]  # fmt: skip
        plant = file["plant"] | {"vertices": moved}
        yield f"an input that {what}", file | {"plant": plant}
    beside = asked_by(proof_of("a mode beside a sector"))
    wide = beside["requirement"] | {"theta": "1.5", "degrees": "86"}
    yield "a wider sector", beside | {"requirement": wide}
    fast = asked_by(proof_of("fast with little force"))
    one_region = next(r for r in fast["requirements"] if r["kind"] == "region")
    others = [r for r in fast["requirements"] if r["kind"] != "region"]
    slow = [*others, one_region | {"sigma": "0.1"}]
    yield "a harder region than is claimed", fast | {"requirements": slow}
    own = asked_by(proof_of("an LMI of one's own"))
    yield "another sign", own | {"unknowns": {"P": [["-1", "0"], ["0", "-1"]]}}
    late = asked_by(proof_of("delayed loop"))
    yield "a longer delay", late | {"tau": "30"}
    yield "faster", late | {"delta": "5"}
    yield "larger exponentials", late | {"exponentials": ["1", "1"]}
    half = [["0.5", "0"], ["0", "0.5"]]
    yield "a smaller feedback", late | {"K": half}


def test_parts_of_other_proofs_are_refused():
    accepted = [x for x, whole in swapped() if any(verdicts(asking(whole)))]
    assert accepted == []


@pytest.mark.parametrize(
    "text",
    [
        "",
        "null",
        "[" * 100000,
        '{"format": "sosbook proof"}',
        '{"format": "sosbook proof", "version": 2, "kind": "design", "kind": "x"}',
        '{"format": "sosbook proof", "version": 2, "kind": "design", "x": NaN}',
        "\ufeff{}",
        "{" * 3,
    ],
)
def test_texts_that_are_no_proofs(text, tmp_path):
    for cls in map(ProofFile.owner, KINDS):
        assert not cls(text).proven and not cls(text).verify()
    with pytest.raises((checker.Refused, checker.Beyond, *checker.MALFORMED)):
        checker.check(text)
    file = tmp_path / "proof.json"
    file.write_text(text, "utf-8")
    with pytest.raises(ValueError, match="proof"):
        load(file)
    assert checker.main([str(file)]) in (1, 2)


def test_what_is_beyond_all_bounds_is_refused_at_once():
    whole = asked_by(proof_of("stability"))
    for path, value in (
        (("K", 0, 0), "1e999999999"),
        (("unknowns", "P", 0, 0), "9" * 10000),
        (("plant", "vertices"), [whole["plant"]["vertices"][0]] * 3 + [{}]),
    ):
        assert verdicts(asking(put(whole, path, value))) == (False, False)
