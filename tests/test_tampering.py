"""Hundreds of ways to spoil a proof file, and no false claim gets through.

Each change is tried twice: as it is, and with its checksum mended. The
first must always be refused. The second may only be accepted where the
changed file is a proof in its own right: floats then find the poles of the
changed loop where the claims say.
"""

import copy
import json
from fractions import Fraction

import numpy as np
import pytest

import sosbook as sos
from sosbook.lmi.proof import kinds, load
from sosbook.lmi.proof_text import checksum
from sosbook.lmi.rational import decimal
from sosbook.requirements.base import Requirement
from sosbook.synthesis.records import read_request
from tests.least_input import least_input
from tests.least_norm import least_norm
from tests.test_proof_files import BEYOND, ONE, TWO, checker, proof_of

CLASSES = {cls.kind: cls for cls in kinds()}
FEW = {  # small ones, of every kind
    "design": lambda: sos.design_pid(
        TWO,
        ONE,
        region=sos.PoleRegion(0.05, 1.4, 50),
        gamma=3.0,
        saturation=sos.Saturation(200, [0.1, 0, 0]),
        cost=sos.QuadraticCost(np.eye(3), ONE, "F", bound=500.0),
    ).certify(),
    "slack": lambda: proof_of("H-infinity, slack"),
    "infeasible": lambda: proof_of("too little force"),
    "mass": lambda: proof_of("regular mass"),
    "no mass": lambda: proof_of("no mass without input"),
    "loop with a delay": lambda: proof_of("delayed loop"),
    "sampled": lambda: proof_of("sampled"),
    "a slow mode behind a delay": lambda: proof_of("a slow mode behind a delay"),
}
NEW = (  # small ones of each kind, of which the quick lane leaves out the longest
    "little force for a fast fall",
    pytest.param("little force for a slow pair", marks=pytest.mark.slow),
    "a mode at rest",
    "a mode on the imaginary axis",
    "a mode between two plants",
    "a pole of a given loop",
    "a singular mass",
    "a response out of reach",
    "an LMI of one's own",
    "an LMI of one's own, empty",
    "a loop that is late",
    "legendre",
    "interval of one point",
    "observer",
    "no observer",
    "schur",
)
# data that may be other data: names nobody claims anything of, coordinates of
# LMIs, the model that an observer follows, words of an author
FREE = {"name", "witness", "coordinates", "model", "statement", "E", "D_u"}


def leaves(value, path=()):
    """(path, leaf) of everything in nested lists and dicts."""
    items = value.items() if isinstance(value, dict) else enumerate(value)
    for key, inner in items:
        yield (*path, key), inner
        if isinstance(inner, (dict, list)):
            yield from leaves(inner, (*path, key))


def changes(value):
    """What becomes of a value: other signs, digits, types, shapes."""
    if isinstance(value, str):
        yield from ("NaN", "Infinity", "", None, [value], {"x": value}, True, 0)
        if value[-1:].isdigit() and value[:1] in "-0123456789":
            yield value[1:] if value[0] == "-" else "-" + value
            first = next(k for k, c in enumerate(value) if c.isdigit())
            digit = str((int(value[first]) + 3) % 10)
            yield value[:first] + digit + value[first + 1 :]
            yield from (value + "0", "0" + value, value + "e5", "1e400", value + "/0")
            yield float(value) if "/" not in value else 1.5
            if "/" not in value and np.isfinite(float(value)):
                yield decimal(np.nextafter(float(value), np.inf))  # the last bit
        else:
            yield from (value + " x", "poles")
    elif isinstance(value, list):
        yield from (value[:-1], value + value[-1:], value[::-1], [], None, {}, "1")
    elif isinstance(value, dict):
        yield from ([], None, "1", {**value, "extra": "1"})
        for key in value:
            yield {k: v for k, v in value.items() if k != key}
    elif isinstance(value, bool):
        yield from (not value, int(value), None, "true")
    elif isinstance(value, int):
        yield from (value + 1, -value - 1, str(value), True, None, 10**6)
    else:
        yield from ("1", [], {}, 0, True)


def put(whole, path, value):
    found = inner = copy.copy(whole)
    for key in path[:-1]:
        inner[key] = inner = copy.copy(inner[key])
    inner[path[-1]] = value
    return found


def tampered(whole, most=400):
    """Changed contents; an even choice where there are too many."""
    everything = []
    for path, value in leaves(whole):
        if path != ("checksum",):
            same = json.dumps(value, sort_keys=True)
            everything += [
                (path, change)
                for change in changes(value)
                if json.dumps(change, sort_keys=True) != same
            ]
    step = max(1, len(everything) // most)
    for path, change in everything[::step]:
        yield path, put(whole, path, change)


def verdicts(whole):
    """(what the package says, what the checker says)."""
    text = json.dumps(whole)
    kind = whole.get("kind")
    cls = CLASSES.get(kind) if isinstance(kind, str) else None
    package = cls is not None and cls(text).verify()
    try:
        alone = bool(checker.check(text))
    except (checker.Refused, checker.Beyond):
        alone = False
    except checker.MALFORMED:
        alone = False
    return package, alone


def true_claims(whole):
    """Whether the changed file's claims hold, by eigenvalues in floats."""
    if whole["kind"] == "design":
        request = read_request(whole)
        K = np.array(whole["K"], float).reshape(request.plant.m, request.order)
        for d in request.vertices:
            for r in request.demands:
                if r.kept(r.truth([d], K, request.K_A)) < -1e-9:
                    return False
        return True
    if whole["kind"] == "delay":
        A, A_d = (np.array(whole["plant"][x], float) for x in ("A", "A_d"))
        rate, _ = sos.delay.spectrum.slowest_decay(A, A_d, *2 * (float(whole["tau"]),))
        return rate > float(whole["delta"]) - 1e-9
    if whole["kind"] == "regularization":
        plants = [
            [np.array(v[x], float) for x in "MB"] for v in whole["plant"]["vertices"]
        ]
        K_A, beta = np.array(whole["K"], float), float(whole["beta"])
        return all(
            np.linalg.eigvalsh(M - B @ K_A + (M - B @ K_A).T)[0] / 2 > beta**2
            for M, B in plants
        )
    if whole["kind"] == "schur":
        rate = float(whole["rate"])
        return all(
            abs(np.linalg.eigvals(np.array(F, float))).max() < rate
            for F in whole["matrices"]
        )
    if whole["kind"] == "sampled":
        vertices = [
            sos.SecondOrderSystem(*(np.array(v[x], float) for x in "MDSBF"))
            for v in whole["plant"]["vertices"]
        ]
        from sosbook.sampled import sampled_loop

        loops = sampled_loop(
            sos.Polytope(vertices),
            np.array(whole["K"], float),
            float(whole["T"]),
            float(whole["delay"]),
        )
        return all(
            abs(np.linalg.eigvals(F)).max() < float(whole["rate"]) for F in loops
        )
    if whole["kind"] == "fixed mode":
        return true_mode(whole)
    if whole["kind"] == "small input":
        request = read_request(whole)
        least = least_input(request)
        return None if least is None else least > 0.999 * request.saturation.u_max
    if whole["kind"] == "unreached response":
        plant = whole["plant"]["vertices"][whole["vertex"]]
        parts = [np.array(plant[x], float) for x in "MDSBF"]
        return least_norm(*parts) > 0.999 * float(whole["bound"])
    if whole["kind"] == "singular mass":
        i, j = whole["between"]
        E, F = (np.array(whole["plant"]["vertices"][k]["E"], float) for k in (i, j))
        t = np.linspace(0, 1, 10001)
        signs = np.sign(np.linalg.det(E + t[:, None, None] * (F - E)).round(12))
        return len(set(signs)) > 1 or 0 in signs
    if whole["kind"] == "lmi":
        return all(x > -1e-12 for x in least_eigenvalues(whole))
    if whole["kind"] == "observer":
        return observed(whole)
    return None  # no oracle here


def true_mode(whole):
    """The row rank of [A - s E, B] at the mode, and where it lies."""
    parts = [
        [np.array(whole["plant"]["vertices"][k][x], float) for x in "MDSB"]
        for k in whole["place"]
    ]
    M, D, S, B = (sum(x) / 2 for x in zip(*parts))
    n, s = len(M), complex(*(float(Fraction(x)) for x in whole["point"]))
    if whole["K"] is not None:
        K = np.array(whole["K"], float)
        S, D, B = S - B @ K[:, :n], D - B @ K[:, n:], 0 * B
    pencil = np.hstack([s * s * M + s * D + S, B])
    asked = whole["requirement"]
    region = sos.LMIRegion.half_plane(0.0) if asked is None else None
    if asked is not None:
        region = Requirement.read(asked)
    (distance,) = region.distances([s]).values()
    return np.linalg.svd(pencil)[1][-1] < 1e-7 and distance[0] < 1e-7


def least_eigenvalues(whole):
    """Of the blocks of an LMI at its point, in floats."""
    values = {k: np.array(v, float) for k, v in whole["unknowns"].items()}
    for _, constant, terms in whole["expressions"]:
        total = in_floats(constant)
        for name, transposed, left, right in terms:
            x = values[name].T if transposed else values[name]
            total = total + in_floats(left) @ x @ in_floats(right)
        yield np.linalg.eigvalsh(total)[0]


def in_floats(rows):
    return np.array([[float(Fraction(e)) for e in row] for row in rows])


def observed(whole):
    """Whether plant and observer are stable together, at each vertex."""
    K, L, C = (np.array(whole[x], float) for x in "KLC")
    E, A, B = (np.array(whole["model"][x], float) for x in ("E", "A", "Bu"))
    for v in whole["plant"]["vertices"]:
        M, D, S, Bv = (np.array(v[x], float) for x in "MDSB")
        one = np.eye(len(M))
        plant = np.block([[0 * one, one], [np.linalg.solve(M, -np.hstack([S, D]))]])
        push = np.vstack([0 * Bv, np.linalg.solve(M, Bv)])
        follow = np.linalg.solve(E, A + B @ K) + L @ C
        loop = np.block([[plant, push @ K], [-L @ C, follow]])
        if np.linalg.eigvals(loop).real.max() > 1e-9:
            return False
    return True


@pytest.mark.parametrize("name", NEW)
def test_no_tampering_with_the_other_kinds(name):
    """At least a hundred changes each, with the checksum mended."""
    proof = proof_of(name)
    whole = json.loads(proof.text)
    assert proof.proven and verdicts(put(whole, ("claims", 0), "x")) == (False, False)
    tried = accepted = 0
    for path, changed in tampered(whole, most=100):
        changed["checksum"] = checksum(changed)
        package, alone = verdicts(changed)
        tried += 1
        if package or alone:
            accepted += 1
            assert changed["claims"] == whole["claims"], path
            assert path[0] not in ("claims", "kind", "format", "version"), path
            assert package == alone or FREE & set(path), path
            assert true_claims(changed) is not False, path
    assert tried >= 100 and accepted < tried / 5


@pytest.mark.slow
@pytest.mark.parametrize("name", FEW)
def test_no_tampering_gets_a_false_claim_through(name):
    proof = FEW[name]()
    assert proof.proven
    whole = json.loads(proof.text)
    tried = accepted = 0
    for path, changed in tampered(whole):
        assert verdicts(changed) == (False, False), path
        changed["checksum"] = checksum(changed)
        package, alone = verdicts(changed)
        tried += 1
        if not (package or alone):
            continue
        accepted += 1
        # the words name every bound: only other data than theirs may be changed
        assert changed["claims"] == whole["claims"], path
        assert path[0] not in ("claims", "kind", "format", "version"), path
        if path[0] == "blocks":  # in another order, for the checker
            assert sorted(changed["blocks"]) == sorted(whole["blocks"])
        truth = true_claims(changed)
        assert truth is not False, (path, package, alone)
        if name not in BEYOND:
            # the checker doesn't read an angle whose degrees are claimed, nor
            # does it ask where a matrix comes from that may be any: E0, which the
            # package compares with the mean of the masses
            free = path[-1] == "theta" or path[0] in ("E0", "blocks")
            free = free or (whole.get("E0") and "M" in path and alone)
            assert package == alone or free, (path, package, alone)
    assert tried >= 100
    assert accepted < tried / 3
    print(f"{name}: {tried} changes, {accepted} are proofs of other data")


def swapped():
    """Whole parts of one proof in the place of another's."""
    one = json.loads(proof_of("H-infinity, pairs").text)
    other = json.loads(proof_of("cost of noise on F").text)
    for key in one:
        if key not in ("format", "version", "kind", "checksum"):
            if json.dumps(one[key]) != json.dumps(other[key]):
                yield f"{key} of another proof", one | {key: other[key]}
    yield (
        "a pair is dropped",
        one | {"blocks": [b for b in one["blocks"] if b[3:] != [0, 1]]},
    )
    vertices = one["plant"]["vertices"]
    five, pushing, turned = ([[x, "0"], ["0", x]] for x in ("5", "-30", "-1"))
    for what, some in {
        "a vertex is dropped": vertices[:1],
        "a vertex is added": [*vertices, vertices[0] | {"M": five}],
        "a vertex is replaced": [vertices[0], vertices[0] | {"S": pushing}],
        "the input is turned round": [v | {"B": turned} for v in vertices],
    }.items():
        yield what, one | {"plant": one["plant"] | {"vertices": some}}
    yield "vertices instead of pairs", one | {"coupling": "vertices"}
    yield "the claim is wider", one | {"claims": one["claims"] + ["it is optimal"]}
    yield "the claim is narrower", one | {"claims": one["claims"][:1]}
    (bound,) = one["requirements"]
    yield "a smaller bound", one | {"requirements": [bound | {"gamma": "0.1"}]}
    said = [c.replace("2", "0.1") for c in one["claims"]]
    yield (
        "a smaller bound, claimed",
        one | {"requirements": [bound | {"gamma": "0.1"}], "claims": said},
    )
    yield "no requirement", one | {"requirements": []}
    yield "the same twice", one | {"requirements": [bound, bound]}
    refuted = json.loads(proof_of("too little force").text)
    again = json.loads(proof_of("fast with little force").text)
    yield "multipliers of another", refuted | {"multipliers": again["multipliers"]}
    (harder,) = refuted["requirements"]
    easy = [harder | {"u_max": "50"}]
    yield "multipliers of a harder request", refuted | {"requirements": easy}
    yield "no multipliers", refuted | {"multipliers": []}
    yield "one multiplier", refuted | {"multipliers": refuted["multipliers"][:1]}
    turned = [[key, [["-" + e for e in row] for row in z]]
              for key, z in refuted["multipliers"]]  # fmt: skip
    yield "negative multipliers", refuted | {"multipliers": turned}
    mode = json.loads(proof_of("a mode at rest").text)
    slower = mode["requirement"] | {"sigma": "0.001"}
    said = [c.replace("-1", "-0.001") for c in mode["claims"]]
    assert said != mode["claims"]
    yield "a harder region", mode | {"requirement": slower, "claims": said}
    yield "no region", mode | {"requirement": None}
    yield "no rows", mode | {"rows": [["0"] * 4] * len(mode["rows"])}
    yield "another point", mode | {"point": ["5", "0"]}
    yield "a double pole", mode | {"polynomial": ["0", "0", "1"]}
    beside = json.loads(proof_of("a mode beside a sector").text)
    wide = beside["requirement"] | {"theta": "1.5", "degrees": "86"}
    yield "a wider sector", beside | {"requirement": wide}
    fast = json.loads(proof_of("fast with little force").text)
    one_region = next(r for r in fast["requirements"] if r["kind"] == "region")
    others = [r for r in fast["requirements"] if r["kind"] != "region"]
    said = [c.replace("Re s < -3", "Re s < -0.1") for c in fast["claims"]]
    assert said != fast["claims"]
    yield (
        "a harder region than is claimed",
        fast
        | {"requirements": [*others, one_region | {"sigma": "0.1"}], "claims": said},
    )
    own = json.loads(proof_of("an LMI of one's own").text)
    yield "an empty block", own | {"expressions": [["P", [], []]], "blocks": ["P"]}
    yield "another sign", own | {"unknowns": {"P": [["-1", "0"], ["0", "-1"]]}}
    late = json.loads(proof_of("delayed loop").text)
    yield "a longer delay", late | {"tau": "30"}
    yield "faster", late | {"delta": "5"}
    yield "larger exponentials", late | {"exponentials": ["1", "1"]}
    half = [["0.5", "0"], ["0", "0.5"]]
    yield "a smaller feedback", late | {"K": half}
    yield "misprints", late | {"misprints": ["sign"]}


SWAPPED = dict(swapped())


@pytest.mark.parametrize("what", SWAPPED)
def test_parts_of_other_proofs_are_refused(what):
    changed = SWAPPED[what]
    changed["checksum"] = checksum(changed)
    assert verdicts(changed) == (False, False)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "null",
        "[" * 100000,
        '{"format": "sosbook proof"}',
        '{"format": "sosbook proof", "version": 1, "kind": "design", "kind": "x"}',
        '{"format": "sosbook proof", "version": 1, "kind": "design", "x": NaN}',
        "\ufeff{}",
        "{" * 3,
    ],
)
def test_texts_that_are_no_proofs(text, tmp_path):
    for cls in CLASSES.values():
        assert not cls(text).proven and not cls(text).verify()
    with pytest.raises((checker.Refused, checker.Beyond, *checker.MALFORMED)):
        checker.check(text)
    file = tmp_path / "proof.json"
    file.write_text(text, "utf-8")
    with pytest.raises(ValueError, match="proof"):
        load(file)
    assert checker.main([str(file)]) in (1, 2)


def test_what_is_beyond_all_bounds_is_refused_at_once():
    whole = json.loads(proof_of("stability").text)
    for path, value in (
        (("K", 0, 0), "1e999999999"),
        (("unknowns", "P", 0, 0), "9" * 10000),
        (("plant", "vertices"), [whole["plant"]["vertices"][0]] * 3 + [{}]),
    ):
        changed = put(whole, path, value)
        changed["checksum"] = checksum(changed)
        assert verdicts(changed) == (False, False)
