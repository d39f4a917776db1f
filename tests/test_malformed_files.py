"""A file that isn't well formed is refused by the name of the field that is wrong.

At each place of what a proof asks a key is dropped, a value becomes one of another
type, or a list is shortened. Python's own errors are no answer, and what is still
accepted is a proof in its own right.
"""

import json
import re

import pytest

from sosbook.exact.checker import fields, kernel, verdict
from sosbook.exact.checker.outputs import SIGNALS
from sosbook.exact.proof_file import KINDS
from tests.asking import mended
from tests.cases import by_turns, campaign
from tests.forged import MORE, base, decided
from tests.hunt.tampering import put, true_claims
from tests.test_proof_files import EXCLUDED, PROOFS

ONE_OF_EACH = (
    *("stability", "H-infinity, slack", "each input, a box", "a range", "scheduled"),
    *("ticks, known gain", "known gain, in a simplex", "delay", "regular mass"),
    *("observer", "no observer", "an LMI of one's own", "an LMI of one's own, empty"),
    *("too little force", "a mode at rest", "a form that grows", "a singular mass"),
    *("little force for a fast fall", "a response out of reach", "sum of poles"),
    *("no controller of any order", "sampled, a law and a norm", "an author's"),
    *("no mass without input", "a loop that is late", "sampled, a box"),
    "a slow mode behind a delay",
)
OTHERS = sorted({*PROOFS, *EXCLUDED, *MORE}.difference(ONE_OF_EACH))
NAMES = (*ONE_OF_EACH, *campaign(OTHERS))
MOST = 200  # changes of a file, an even choice where there are more
OPTIONAL = {  # keys without which a file asks for something else
    *("dt", "states", "reduced", "schedule", "C", "D_u", "D_w", "C_a", "law", "free"),
    *("outputs", "inputs", "u", "Q", "N", "requirement", "P", "G", "share", "box"),
    *("X", "Y", "theorem", "name", *SIGNALS),
}
TYPES = None, True, 7, 1.5, "x", "", "2", [], {}, [[]], ["x"], [["1"]], {"x": "1"}
NUMBER = re.compile(r"-?[\d.]+(e-?\d+|/\d+)?")
ACCEPTED = "accepted"


def places(value, path=()):
    """Each place, of a list its ends alone: (path, what is there)."""
    if isinstance(value, dict):
        items = [*value.items()]
    else:
        ends = {0, 1, len(value) - 2, len(value) - 1} & {*range(len(value))}
        items = [(k, value[k]) for k in sorted(ends)]
    for key, inner in items:
        yield (*path, key), inner
        if isinstance(inner, (dict, list)):
            yield from places(inner, (*path, key))


def without(whole, path):
    """The same without a key, or an entry of a list."""
    *above, last = path
    inner = whole
    for key in above:
        inner = inner[key]
    if isinstance(inner, dict):
        rest = {k: v for k, v in inner.items() if k != last}
    else:
        rest = inner[:last] + inner[last + 1 :]
    return put(whole, above, rest) if above else rest


def malformed(whole, most=MOST):
    """(path, the contents with something wrong there, whether it is plainly wrong)."""
    found = []
    for path, value in places(whole):
        key = isinstance(path[-1], str) and path[-1] not in OPTIONAL
        found.append((path, without(whole, path), key))
        for other in TYPES:
            if json.dumps(other) != json.dumps(value):
                wrong = type(other) is not type(value) and None not in (other, value)
                if isinstance(value, str) and type(other) is int:
                    wrong = not NUMBER.fullmatch(value)  # 7 is one, too
                found.append((path, put(whole, path, other), wrong))
        if isinstance(value, list) and len(value) > 1:
            found.append((path, put(whole, path, value[:1]), False))
    step = max(1, len(found) // most)
    return found[:: step if step % 2 else step + 1]  # of all types


def outcome(do, *given):
    """The words of a refusal, or what else becomes of it; no error is any."""
    try:
        do(*given)
    except verdict.Refused as why:
        return str(why)
    except verdict.Beyond as limit:
        return f"beyond: {limit}"
    return ACCEPTED


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_what_is_asked_is_refused_by_the_name_of_its_field(name):
    accepted = []
    for path, other, wrong in malformed(base(name)):
        if path == ("kind",):
            continue
        said = outcome(decided, other)
        named = any(x in said for x in path if isinstance(x, str))
        if said == ACCEPTED and path[-1] not in ("name", "kind"):
            accepted.append((path, other))
        assert named or not wrong or said == ACCEPTED, (path, said)
    for path, other in accepted[:: 1 + len(accepted) // 8]:
        if path[-1] != "peak":  # its author's class reads it, and the proof doesn't
            assert true_claims(other) is not False, path


@pytest.mark.parametrize(
    "name, key, rows",
    [
        ("ticks, states", "C", []),
        ("ticks, states", "D_u", [["0"], ["0"]]),
        ("closed loop", "D_u", [[]]),
    ],
)
def test_what_moves_outputs_has_as_many_rows_as_they(name, key, rows):
    """Where nothing that is asked has these outputs it was taken as it came."""
    with pytest.raises(verdict.Refused, match="D_u .*has a wrong shape"):
        decided(put(base(name), ("plant", key), rows))


@pytest.mark.slow
@pytest.mark.parametrize("name", by_turns(ONE_OF_EACH, 0, of=3))
def test_a_file_is_refused_and_never_with_an_error_of_python(name):
    whole = json.loads(json.dumps(verdict.stored(verdict.written(base(name))[0])))
    assert outcome(verdict.check, json.dumps(whole)) == ACCEPTED
    for _, other, _ in malformed(whole):
        outcome(verdict.check, json.dumps(other))
        outcome(verdict.check, json.dumps(mended(other)))


@pytest.mark.slow
@pytest.mark.parametrize("name", by_turns(ONE_OF_EACH, 1, of=3))
def test_the_kernel_alone_reads_no_file_with_an_error_of_python(name):
    text, _ = verdict.text_of(base(name))
    for _, other, _ in malformed(json.loads(json.dumps(text.file()))):
        outcome(kernel.check, other)


def test_a_matrix_without_entries_is_no_bomb():
    """A reference to it was laid out before its size was looked at."""
    whole = verdict.written(base("stability"))[0]
    data = whole["data"] | {"K": {"zeros": [10**9, 0]}}
    assert "an odd matrix" in outcome(verdict.check, json.dumps(whole | {"data": data}))


def test_each_kind_is_spoiled_and_each_of_its_fields_has_a_form():
    assert {base(x)["kind"] for x in ONE_OF_EACH} == KINDS.keys()
    asked = {x for _, names in (verdict.KINDS | verdict.SINGLE).values()
             for x in names.split()}  # fmt: skip
    assert asked <= fields.FIELDS.keys() | {"cells", "K"}


def written_for(asked):
    """All that is written for what is asked, but what repeats it."""
    whole, claims, keys = verdict.written(asked)
    rest = {k: x for k, x in whole.items() if k not in ("asks", "about")}
    return json.dumps([rest, claims, claims.author, list(keys.items())])


def others(value):
    """Other values of a leaf that have its form."""
    if isinstance(value, bool):
        yield not value
    elif isinstance(value, int):
        yield from (value + 1, value - 1)
    elif isinstance(value, str):
        yield from ("x", value + "1", value + "x", "0", "-3", "0.5")


UNREAD = {  # what no text and no word holds: by whom it is read, or why by nobody
    "digits": "own.py: no entry of the point has more",
    "requirement.name": "fixed_mode.py: it is a name, and no claim says it",
    "law.signals": "families.py: names, which the claims of refusals don't say",
    "law.states": "families.py: names, which the claims of refusals don't say",
    "requirements.peak": "its author's class: the theorem has the numbers",
    **dict.fromkeys(("witness", "level"), "fixed_mode.py and growing.py decide"),
    **dict.fromkeys(
        ("rows", "columns", "share", "price", "multipliers", "requirements.x0"),
        "small_input.py decides",
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", by_turns(ONE_OF_EACH, 2, of=3))
def test_no_field_is_read_by_nobody(name):
    """What can be changed without another word, line or number isn't in a file."""
    whole, unread = base(name), set()
    before = written_for(whole)
    for turn, (path, value) in enumerate(places(whole)):
        some = [x for x in others(value) if x != value]
        for other in [*some, *some][turn % (len(some) or 1) :][:2]:  # by turns
            try:
                if written_for(put(whole, path, other)) == before:
                    unread.add(".".join(x for x in path if isinstance(x, str)))
            except (verdict.Refused, verdict.Beyond):
                pass
    assert unread <= UNREAD.keys()
