"""A request as a sentence: printed, read again, in Python and in the page."""

import json
import random
import shutil
import sys
from pathlib import Path

import pytest

import sosbook
from sosbook.requirements.places import canonical
from sosbook.requirements.sentence import CLAUSES, Sentences
from tests.processes import process

SCRIPT = Path(sosbook.__file__).parent / "book/elements/assets/sentence.js"
WORDS = (
    {},
    {"it": "tower", "z": ["drift", "mm"], "w": ["wind", "kN"], "u": ["pull", "kN"]},
    {
        "it": "Last",
        "J": ["Last", "g m²", -3],
        "k": ["shaft", "N m/rad"],
        "z1": "encoder",
    },
)
DRIVE = {
    "plant": {
        "parameters": {"J": [0.003, 0.006], "k": [-1.5, 2e-7]},
        "M": [[0.0025, 0], [0, "J"]],
        "D": [[0, 0], [0, 0]],
        "S": [["k", "-k"], ["-k", "k"]],
        "B": [[1], [0]],
    },
    "U": [[0.0, 1.0]],
}


def ones(n):
    return lambda rows: [1.0] * n


def number(rng):
    """A number of everyday, of a computation, or of another unit."""
    x = rng.choice([rng.randint(1, 400), rng.uniform(0, 9), 10 ** rng.uniform(-12, 12)])
    return float(rng.choice([x, f"{x:.2g}", f"{x:.4g}"]))


def wish(rng):
    """A random plant file that clauses say, and whose rest may be something else."""
    data = json.loads(json.dumps(DRIVE))
    data["words"] = rng.choice(WORDS)
    for name in "Jk":
        low, high = sorted([number(rng), number(rng) * 1.1])
        data["plant"]["parameters"][name] = [-low if name == "k" else low, high + 1]
    region = {}
    for clause in CLAUSES:
        if clause["at"][0] == "region" and rng.random() < 0.4:
            top = clause.get("below", clause.get("most", 1e9))
            region[clause["key"]] = (number(rng) % top or 1.0) * 10 ** min(
                clause.get("shift", 0), 0
            )
    if {"theta", "theta_deg", "overshoot"} <= {*region}:
        del region["theta"]
    data |= {"region": region} if region else {}
    data |= {"gamma": number(rng)} if rng.random() < 0.4 else {}
    if rng.random() < 0.3:
        data["hinf"] = {"gamma": number(rng), "outputs": [{"input": 2}]}
    if rng.random() < 0.5:
        position = rng.choice([[[1.0, 0.0]], [[0.0, 1.0]], [[1.0, 0.0], [0.0, 1.0]]])
        data["law"] = {"position": position, "filter": number(rng)}
        if rng.random() < 0.7:
            data["law"]["integrate"] = rng.choice(
                [True, [[1.0] + [0.0] * (len(position) - 1)]]
            )
        if rng.random() < 0.4:
            data["law"]["structure"] = rng.choice(["diagonal", {"K_P": [["a", 0]]}])
        del data["U"]
    if rng.random() < 0.3:
        data["cost"] = {"Q": 1, "R": 2} | rng.choice([{}, {"bound": number(rng)}])
    if rng.random() < 0.6:
        size = 5 if "law" not in data else 4 + len(data["law"]["position"])
        x0 = [-number(rng) for _ in range(size)]
        data["saturation"] = {"u_max": number(rng), "x0": x0}
        if rng.random() < 0.6:
            speech = Sentences(canonical(data), 2, ones(2))
            data["saturation"]["x0"] = speech._start(-x0[0], speech.data)
    if rng.random() < 0.5:
        data["controller"] = {"T": number(rng)}
        if rng.random() < 0.5:
            data["controller"]["delay"] = rng.choice([0.0, number(rng)])
    return data


def spoiled(rng, text):
    """The text with a part that is gone, twice, or another."""
    a, b = sorted(rng.choices(range(len(text)), k=2))
    b = min(b, a + 12)
    return rng.choice(
        [text[:a] + text[b:], text[:b] + text[a:], text[:a] + "flies" + text[b:]]
    )


def answers(speech, text):
    try:
        return speech.read(text)
    except ValueError as fault:
        return str(fault)


RUN = """
import {Sentences} from %s;
const cases = JSON.parse(await new Response(Deno.stdin.readable).text());
console.log(JSON.stringify(
  cases.map(data => String(new Sentences(data, 2, () => [1, 1])))));
"""


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    """The sentences that the page's script says of cases."""
    deno = shutil.which("deno", path=Path(sys.executable).parent)
    if deno is None:
        pytest.skip("deno isn't installed: pip install deno")
    script = tmp_path_factory.mktemp("page") / "run.mjs"
    script.write_text(RUN % json.dumps(SCRIPT.as_uri()), "utf-8")

    def asked(cases):
        done = process(deno, "run", "--no-lock", "-A", script, input=json.dumps(cases))
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    return asked


@pytest.mark.parametrize("count", [300, pytest.param(5000, marks=pytest.mark.campaign)])
def test_sentences_lead_back_and_a_page_says_the_same(page, count):
    """A request is said and read; what is spoiled is refused, or another request."""
    rng, cases, said, refused = random.Random(63), [], [], 0
    for _ in range(count):
        data = wish(rng)
        speech = Sentences(data, 2, ones(2))
        text = str(speech)
        assert speech.read(text) == canonical(data), text
        loose = rng.choice([text.replace(" ", "_"), text.upper(), text.lower()])
        texts = [loose, spoiled(rng, text), spoiled(rng, text)]
        cases.append(data)
        said.append(text)
        read = [answers(speech, one) for one in texts]
        refused += sum(isinstance(x, str) for x in read[1:])
        for found in read:
            if isinstance(found, dict):
                again = Sentences(found, 2, ones(2))
                assert again.read(str(again)) == found
            else:
                assert found.startswith("character ")
    assert page(cases) == said
    assert 1.2 * count < refused < 1.9 * count


def test_a_structure_is_said_and_kept_or_asked_no_more():
    law = {"position": [[1.0, 0.0], [0.0, 1.0]], "structure": {"K_P": [["a", "a"]]}}
    speech = Sentences({"plant": {}, "law": law, "region": {"sigma": 0.7}}, 2)
    text = "decays with σ = 0.7 s⁻¹, from all positions, and law.structure as given."
    assert str(speech) == f"The loop {text}"
    assert speech.read(str(speech))["law"] == law
    bare = str(speech).replace(", and law.structure as given", "")
    assert speech.read(bare)["law"] == {"position": law["position"]}


@pytest.mark.parametrize(
    "words, said",
    [({}, "from the position z1 alone"), ({"z1": "encoder"}, "from the encoder alone")],
)
def test_a_position_without_a_name_is_called_one(words, said):
    data = {"plant": {}, "law": {"position": [[1.0, 0.0]]}, "words": words}
    (first, _), *_ = Sentences(data, 2).laws()
    assert f"from {first}" == said


@pytest.mark.parametrize(
    "region, words",
    [
        (
            sosbook.PoleRegion(0.3, 0.5, 4),
            "decays with σ = 0.3 s⁻¹, rings within θ = 0",
        ),
        (sosbook.LMIRegion.disk(4), "reacts no faster than 0.25 s"),
        (sosbook.LMIRegion.disk(2, -3), "and disk as given"),
        (sosbook.LMIRegion.sector(0.5, -1), "and sector as given"),
        (sosbook.LMIRegion.half_plane(-1), "and half-plane as given"),
    ],
)
def test_a_region_is_said_where_its_words_mean_it(region, words):
    cart = sosbook.SecondOrderSystem(2, 0.1, 3, 1)
    design = sosbook.design_pid(cart, region=region)
    assert words in design.sentence and design.status == "feasible"
    if "as given" not in words:
        again = sosbook.read_wish(design.sentence.partition(":")[0], cart).asked
        poles = (
            sosbook.PoleRegion(**again["region"])
            if isinstance(again["region"], dict)
            else again["region"]
        )
        for one, other in zip(region.parts, poles.parts, strict=True):
            assert (one.alpha == other.alpha).all() and (one.beta == other.beta).all()
