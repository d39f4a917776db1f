"""The page that takes a proof file: it says no more than the checker does."""

import copy
import json
import re
from functools import cache
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
    sampled = sos.certify_sampled(ONE, np.zeros((1, 4)), T=0.1).text
    words = said(tab, "clock.json", sampled)
    assert 'the kind "sampled" (a loop with a clock)' in words
    assert "a tick every 0.1 s, a delay of 0 s" in words and "proven" not in words
    called = dict(inputs=["z1", "z2", "z1'", "z2'"], outputs=["u"])
    law = sos.sampled.SampledSystem([], [], [], [[-1, 0, -1, 0]], 0.1, **called)
    named = sos.certify_sampled(ONE, law, T=0.1).text
    assert "K makes u of z1, z2, z1', z2'" in said(tab, "named.json", named)
    given = '"outputs":["u"]'
    for k, forged in enumerate((
        named.replace('"z2"', '"speed"'),
        named.replace(given, '"outputs":["u1"]'),
        named.replace(given, '"other":["u"]'),
    )):  # fmt: skip
        words = said(tab, f"forged{k}.json", forged)
        assert "refused" in words and "K.inputs and K.outputs" in words
    for more in (
        dict(saturation=sos.Saturation(9, [[1, 0, 0, 0]])),
        dict(saturation=sos.Saturation([9], [1, 0, 0, 0])),
        dict(gamma=sos.HInfinity(9.0, outputs=sos.Output(velocity=[[1, 0]]))),
    ):
        other = sos.design_pid(ONE, **more).certify().text
        assert judged(tab, other)[0]["status"] == "beyond"
    for odd in ('"x"', '"7"', '"1e999"', "0", '"-1"', "[]"):  # some never ended
        text = re.sub(r'"theta.2":"[^"]*"', f'"theta.2":{odd}', proof("places").text)
        assert judged(tab, text)[0]["status"] == "refused"
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
    good, rng = proof(name), np.random.default_rng(7)
    whole_file = json.loads(good.text)
    asked = verdict.asked_of(whole_file)
    files = [good.text, good.text.replace("\n", "\n ")]
    changed = [x for _, x in tampered(whole_file)]
    changed += [asking(x) for _, x in tampered(asked)]
    for form, r in enumerate(asked["requirements"]):
        for key in ("name", "form", "kind", "alpha", "beta"):
            other = copy.deepcopy(asked)
            other["requirements"][form][key] = "constructor"
            changed.append(whole_file | {"asks": other} if key in r else whole_file)
    pick = rng.permutation(len(changed))[:30]
    files += [spread(changed[k]) for k in pick]
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
