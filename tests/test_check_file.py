"""The page that takes a proof file: it says no more than the checker does."""

import copy
import json
import re
from functools import cache, partial
from pathlib import Path

import numpy as np
import pytest

import sosbook as sos
from sosbook.book.elements.bench import bench
from sosbook.exact.checker import verdict
from sosbook.exact.proof_file import spread
from tests.asking import asking
from tests.elements import write_page
from tests.hunt.tampering import tampered

NAMES = ["z1", "z2", "z1'", "z2'"]
PAGE = Path(__file__).parents[1] / "book" / "api" / "proof_files.md"
ONE = sos.SecondOrderSystem(
    [[1, 0.2], [0, 2]], [[0.3, -0.1], [-0.1, 0.2]], [[9.81, -1], [-1, 2]],
    [[1], [0]], [[0], [1]],
)  # fmt: skip
TWO = sos.Polytope([ONE, sos.SecondOrderSystem(ONE.M * 1.1, *map(np.asarray, (
    ONE.D, ONE.S, ONE.B, ONE.F)))])  # fmt: skip
ASKED = {
    "stability": lambda: sos.design_pid(ONE),
    "places": lambda: sos.design_pid(
        TWO, [[1, 0]], region=sos.PoleRegion(sigma=0.2, theta=1.2, rho=30)
    ),
    "norm": lambda: sos.design_pid(TWO, gamma=3.0),
    "input": lambda: sos.design_pid(
        ONE, gamma=3.0, saturation=sos.Saturation(50, [0.1, 0, 0, 0])
    ),
    "cost": lambda: sos.design_lqr(ONE, np.eye(4), np.eye(1)),
}


@cache
def proof(name):
    return ASKED[name]().certify()


@pytest.fixture
def tab(visit, tmp_path):
    (block,) = re.findall(r"```\{raw\} html\n(.*?)```", PAGE.read_text("utf-8"), re.S)
    tab = visit(write_page(tmp_path / "page.html", block))
    yield tab
    assert tab.errors == []


def said(tab, name, text):
    """What the page says of a file."""
    file = {"name": name, "mimeType": "application/json", "buffer": text.encode()}
    tab.page.locator("sos-check [type=file]").set_input_files(file)
    words = tab.page.locator("sos-check .sos-readout")
    words.filter(has_text=name).wait_for()
    return words.inner_text()


def spoiled(name):
    """What writes each changed file of a proof: of its text, or of what it asks."""
    whole_file = json.loads(proof(name).text)
    asked = verdict.asked_of(whole_file)
    made = [partial(spread, x) for _, x in tampered(whole_file)]
    made += [partial(anew, x) for _, x in tampered(asked)]
    for form in range(len(asked["requirements"])):
        for key in ("name", "form", "kind", "alpha", "beta"):
            other = copy.deepcopy(asked)
            other["requirements"][form][key] = "constructor"
            made.append(partial(spread, whole_file | {"asks": other}))
    return made


def clocked():
    """Files of loops with a clock: without names, with them, with wrong ones."""
    made = sos.sampled.SampledSystem
    yield sos.certify_sampled(ONE, np.zeros((1, 4)), T=0.1).text
    one = made([], [], [], [[-1, 0, -1, 0]], 0.1, inputs=NAMES, outputs=["u"])
    named = sos.certify_sampled(ONE, one, T=0.1).text
    yield named
    yield named.replace('"z2"', '"speed"')
    for other in ('"outputs":["u1"]', '"other":["u"]'):
        yield named.replace('"outputs":["u"]', other)


def others_with_a_clock():
    """Of two inputs, of an integral, of a plant of first order; right and wrong."""
    made, law = sos.sampled.SampledSystem, [[-1, 0, -1, 0, -0.1], [0, -1, 0, -1, 0]]
    two = sos.SecondOrderSystem(np.eye(2), np.eye(2), [[3, -1], [-1, 2]], np.eye(2))
    for U, D in (([[1, 0]], law), (None, [row[:4] for row in law])):
        called = dict(inputs=[*NAMES, "integral of z1"][: len(D[0])])
        K = made([], [], [], D, 0.1, **called, outputs=["u1", "u2"])
        text = sos.certify_sampled(two, K, T=0.1, U=U).text
        yield text
        for old, new in (("u2", "u3"), ("integral of z1", "z3"), ("z1'", "z1")):
            yield text.replace(f'"{old}"', f'"{new}"')
    first = sos.DescriptorSystem(np.diag([1, 2]), [[-1, 0.2], [0, -1]], [[1], [0]])
    K = made([], [], [], [[-0.5, 0]], 0.1, inputs=["x1", "x2"], outputs=["u"])
    text = sos.certify_sampled(first, K, T=0.1).text
    yield from (text, text.replace('"x2"', '"x3"'), text.replace('["u"]', '["u1"]'))


def odd_angles():
    """Half-angles of sectors that are none; some never ended."""
    for odd in ('"x"', '"7"', '"1.6"', '"0"', '"1e999"', "0", '"-1"', "[]"):
        yield re.sub(r'"theta.2":"[^"]*"', f'"theta.2":{odd}', proof("places").text)


def of_no_page():
    """Files of designs that ask for what no page asks."""
    for more in (
        dict(saturation=sos.Saturation(9, [[1, 0, 0, 0]])),
        dict(saturation=sos.Saturation([9], [1, 0, 0, 0])),
        dict(gamma=sos.HInfinity(9.0, outputs=sos.Output(velocity=[[1, 0]]))),
    ):
        yield sos.design_pid(ONE, **more).certify().text


def anew(asked):
    return spread(asking(asked))


def judged(tab, *texts):
    ask = "texts => texts.map(x => sosModules.kernel.judgedFile(x))"
    return tab.page.evaluate(ask, list(texts))


def test_a_reader_s_file_is_judged_in_plain_words(tab):
    good = proof("norm")
    words = said(tab, "good.json", good.text)
    assert "good.json: proven" in words and "its H-infinity norm is below 3" in words
    for part in ("this page, in fractions", good.data["K"][0][0], "no clock", "--code"):
        assert part in words
    forged = good.text.replace('"gamma":"3"', '"gamma":"2"')
    assert forged != good.text and "forged.json: refused" in said(
        tab, "forged.json", forged
    )
    mine = json.dumps(json.loads(good.text) | {"kind": "<b>mine</b>"})
    words = said(tab, "mine.json", mine)
    assert "mine.json: beyond" in words and '"<b>mine</b>" (unknown here)' in words
    sampled, named, *others = clocked()
    words = said(tab, "clock.json", sampled)
    assert 'the kind "sampled" (a loop with a clock)' in words
    assert "a tick every 0.1 s, a delay of 0 s" in words and "proven" not in words
    words = said(tab, "named.json", named)
    assert "K makes u of z1, z2, z1', z2'" in words
    for k, forged in enumerate(others):
        words = said(tab, f"forged{k}.json", forged)
        assert "refused" in words and "K.inputs and K.outputs" in words
    for other in of_no_page():
        assert judged(tab, other)[0]["status"] == "beyond"
    for text in odd_angles():
        assert judged(tab, text)[0]["status"] == "refused"
    for text in others_with_a_clock():
        (answer,) = judged(tab, text)
        try:
            true = bool(verdict.check(text))
        except (verdict.Refused, *verdict.MALFORMED):
            true = False
        assert answer["status"] == ("beyond" if true else "refused"), text
    for k, text in enumerate(("{", "[]", "null", '{"format": "sosbook proof"}', "")):
        assert f"odd{k}.json: odd. This is no proof file" in said(
            tab, f"odd{k}.json", text
        )


@pytest.mark.parametrize("tag, place", [("check", "readout"), ("bench", "source")])
def test_the_file_that_was_chosen_last_counts(visit, tmp_path, tag, place):
    """Also where the one before is read later."""
    text = re.findall(r"```\{raw\} html\n(.*?)```", PAGE.read_text("utf-8"), re.S)[0]
    shown = {"check": text, "bench": bench().light}[tag]
    tab = visit(write_page(tmp_path / "page.html", shown))
    said = tab.page.evaluate(
        """async ([tag, place]) => {
      const e = document.querySelector(`sos-${tag}`), wait = ms =>
        new Promise(done => setTimeout(done, ms));
      const file = (name, ms) => Object.assign(new File(["{"], name), {
        text: async () => { await wait(ms); return "{"; },
        arrayBuffer: async () => { await wait(ms); return new ArrayBuffer(1); }});
      await Promise.all([e.take([file("slow.json", 60)]), e.take([file("b.json", 1)])]);
      return e.find(place).textContent; }""",
        [tag, place],
    )
    assert said.startswith("b.json: ")


@pytest.mark.parametrize("name", ASKED)
def test_the_page_says_what_the_checker_says(tab, name):
    """Of changed requests, written anew or not, it proves none that isn't proven."""
    good, every = proof(name), spoiled(name)
    pick = np.random.default_rng(7).permutation(len(every))[:30]
    files = [good.text, good.text.replace("\n", "\n ")]
    files += [every[k]() for k in pick]
    answers, proofs = judged(tab, *files), 0
    for text, answer in zip(files, answers):
        try:
            claims = [*verdict.check(text)]
        except (verdict.Refused, verdict.Beyond, *verdict.MALFORMED):
            claims = None
        if answer["status"] == "proven":
            assert claims == answer["claims"]
            proofs += 1
    assert answers[0]["claims"] == list(good.claims)
    assert answers[1]["status"] == "refused" and proofs >= 1
