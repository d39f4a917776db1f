"""A theorem of somebody's own: as a file that anybody checks, and typed in the page."""

import json
import sys

import numpy as np
import pytest

import sosbook as sos
from sosbook.book.elements.own_theorem import own_theorem
from sosbook.exact.checker import CHECKER
from sosbook.plants import descriptors
from sosbook.requirements.in_text import theorem_data
from sosbook.synthesis.request import Request
from tests import energy_to_peak
from tests.cases import campaign
from tests.elements import write_page
from tests.energy_to_peak import PAGE, EnergyToPeak, true_peak
from tests.processes import alone, process

AUTHOR = 5  # the exit code where an author says what his blocks mean


def carts(m2):
    return sos.SecondOrderSystem(
        np.diag([1, m2]), [[0.5, -0.2], [-0.2, 0.2]], [[5, -4], [-4, 4]],
        [[1], [0]], [[0], [1]],
    )  # fmt: skip


LOADS = sos.Polytope([carts(0.5), carts(1.5)])
LIMIT = sos.Saturation(60, [0.1, 0.1, 0, 0])


PACKAGE = """
import contextlib, io, json, sys
from sosbook.proofs.command import main

for path in sys.argv[1:]:
    said = io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
        code = main(["verify", path])
    print(json.dumps([code, said.getvalue()]))
"""


#: The checker as a program, of one file after another.
ALONE = """
import contextlib, io, json, runpy, sys
_, checker, *paths = sys.argv
for path in paths:
    sys.argv, said, code = [checker, path], io.StringIO(), 0
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
        try:
            runpy.run_path(checker, run_name="__main__")
        except SystemExit as end:
            code = end.code
    print(json.dumps([code, said.getvalue()]))
"""


def strangers(*paths):
    """What processes say that never saw the author's code: (code, lines) each."""
    for done in (
        alone("-c", ALONE, CHECKER, *paths, timeout=200),
        process(sys.executable, "-c", PACKAGE, *paths, timeout=200),
    ):
        answers = [json.loads(x) for x in done.stdout.splitlines()]
        assert len(answers) == len(paths), done.stderr
        yield from answers


@pytest.fixture(scope="module", params=["pairs", *campaign(["slack"])])
def proof(request):
    wanted = [EnergyToPeak(0.6), LIMIT]
    design = sos.design_pid(LOADS, requirements=wanted, coupling=request.param)
    return design.certify()


def changed(text, change):
    whole = json.loads(text)
    change(whole)
    return json.dumps(whole)


def own_of(whole):
    return next(r for r in whole["asks"]["requirements"] if "theorem" in r)


def line(old, new):
    """A change of the author's text, where it stands and where it is asked."""

    def change(whole):
        for block in own_of(whole)["theorem"]["blocks"]:
            block[2] = block[2].replace(old, new)
        whole["text"] = [
            x.replace(old, new) if "own." in x else x for x in whole["text"]
        ]

    return change


def number(value):
    def change(whole):
        (name,) = (k for k in whole["data"] if k.endswith(".peak"))
        whole["data"][name] = value

    return change


def redefined(whole):
    """The author's line takes another's name."""
    whole["data"]["Theta"] = [["1"]]


CHANGES = (
    number("0.05"),
    line("C EP'", "9 C EP'"),
    line("W; ", "W > 0\nTheta = -EPE\nmore: [W; "),
    line("he(Theta)", "he(Theta) # "),
    redefined,
    lambda whole: own_of(whole)["theorem"]["blocks"].pop(),
    lambda whole: whole["text"].pop(),
    lambda whole: own_of(whole)["theorem"]["numbers"].update(gamma="1"),
    line("[", "(" * 20_000),
    lambda whole: own_of(whole).update(theorem=None),
    lambda whole: own_of(whole).update(claim=["is perfect"]),
)


def test_a_stranger_checks_the_blocks_quotes_the_author_and_refuses_changes(
    proof, tmp_path
):
    assert proof.proven and json.loads(proof.text)["version"] == 2
    texts = [proof.text, *(changed(proof.text, change) for change in CHANGES)]
    paths = [tmp_path / f"{k}.json" for k in range(len(texts))]
    for path, text in zip(paths, texts, strict=True):
        path.write_text(text, "utf-8")
    words = '"|z(t)| < 0.6 from rest for w of energy one"'
    for k, (code, said) in enumerate(strangers(*paths)):
        if k % len(paths):
            assert code in (1, 2), said
            assert "proven:" not in said.replace("not proven:", ""), said
            continue
        assert code == AUTHOR, said
        assert "plant of the polytope, under u = K x, is stable" in said
        assert f"peak, by its author's theorem: {words}" in said


def test_the_author_reads_his_own_file_as_before(proof, tmp_path):
    proof.save(tmp_path / "peak.json")
    again = type(proof).load(tmp_path / "peak.json")
    assert again.proven and again.claims == proof.claims and again.margins()


def test_implied_stability_is_no_proof_of_it(tmp_path):
    """An author's flag counts for nothing: stability has a block of its own."""
    blocks = theorem_data(EnergyToPeak(0.6), Request(carts(1)), 1)["blocks"]
    assert [where for where, *_ in blocks] == ["pair", "pair"]
    design = sos.design_pid(carts(1), requirements=[EnergyToPeak(0.6), LIMIT])
    text = json.loads(design.certify().text)["text"]
    assert any(x.strip().startswith("stability.") for x in text)


def test_blocks_of_a_size_and_of_a_level_are_those_of_the_class():
    """A requirement with an unknown and a trace: the H2 norm of chapter 41."""
    space = dict(vars(energy_to_peak))
    cells = json.loads(PAGE.read_text("utf-8"))["cells"]
    code = ["".join(c["source"]) for c in cells if c["cell_type"] == "code"]
    wanted = (
        "from sosbook.lmi import Unknown",
        "def true_h2",
        "class H2",
        "@dataclass",
    )
    for source in code:
        if (source.startswith(wanted) and "H2" in source) or "def true_h2" in source:
            exec(source, space)
    for coupling in ("pairs", "slack"):
        asked = [space["H2"](0.7), EnergyToPeak(0.9), LIMIT]
        proof = sos.design_pid(LOADS, requirements=asked, coupling=coupling).certify()
        assert proof.proven and json.loads(proof.text)["version"] == 2


# ------------------------------------------------------------------- in the page
@pytest.fixture
def tab(visit, tmp_path):
    tab = visit(write_page(tmp_path / "theorem.html", own_theorem().html), width=390)
    yield tab
    assert tab.errors == []
    assert tab.page.evaluate("document.documentElement.scrollWidth <= innerWidth")


def typed(tab, *lines, **place):
    """What the element finds for some lines."""
    return tab.page.evaluate(
        """([lines, place]) => {
      const e = document.querySelector("sos-theorem");
      if (lines.length) e.areas.lines.value = lines.join("\\n");
      e.reset({lines: "", ...place});
      const {file, failed, ...rest} = e.result;
      return {...rest, failed, file, said: e.words + e.find("readout").innerText,
              wrong: e.find("fault").textContent}; }""",
        [lines, place],
    )


ENERGY, PEAK = "energy: [-he(Theta), W; ., 1] > 0", "peak: [peak^2, C EP'; ., EPE] > 0"


def test_what_the_page_proves_a_colleague_checks(tab, tmp_path):
    found = typed(tab, peak=0.4)
    assert found["status"] == "feasible" and found["failed"] == []
    tab.page.get_by_role("button", name="Save the proof").click()
    with tab.page.expect_download() as download:
        tab.page.get_by_role("link", name="Download the proof").click()
    download.value.save_as(tmp_path / "my_theorem.json")
    for code, said in strangers(tmp_path / "my_theorem.json"):
        assert code == AUTHOR, said
        assert "|K x(t)| <= 120 from x0" in said
        assert "for every gust w of energy one (peak = 0.4)" in said


def test_its_gain_keeps_the_truth(tab):
    (d,) = descriptors(carts(1))
    for peak in (0.8, 0.5, 0.32):
        found = typed(tab, peak=peak)
        K = np.array(found["K"])
        assert found["reach"][-1][1] == pytest.approx(true_peak(d, K), rel=1e-3)
        assert true_peak(d, K) < peak
        analysis = sos.analyse_pid(carts(1), K, requirements=[EnergyToPeak(peak)])
        assert analysis.status == "feasible"


def test_a_theorem_with_a_slip_proves_a_falsehood_and_is_told(tab):
    found = typed(tab, ENERGY.replace("W", "W/4"), PEAK, peak=0.2)
    assert found["status"] == "feasible"
    assert found["reach"][-1][1] > 0.2 and "has a slip" in found["said"]


def test_too_much_is_no_proof_that_there_is_none(tab):
    found = typed(tab, peak=0.1)
    assert found["status"] == "undecided" and "No design was found" in found["said"]
    assert "floating point" in found["said"]


WRONG = {
    "energy: [-he(Theta), W; ., 1": "a block matrix doesn't end",
    "energy: [-he(Theta), V; ., 1] > 0": "V isn't known",
    "Theta = -EPE": "a line is a name, a colon, a matrix and > 0",
    "for i, j in pairs:": "",
    "energy: Theta > 0": "energy isn't symmetric",
    "energy: [EPE, W; W, 1] > 0": "blocks that don't fit",
    "energy: he(P Theta) > 0": "a product of two unknowns",
    "energy: EPE > 1": "a line is a name, a colon, a matrix and > 0",
    PEAK: "peak comes twice",
}


def test_what_is_wrong_with_a_line_is_said(tab):
    for line, words in WRONG.items():
        found = typed(tab, line, PEAK)
        assert found["status"] == "fault" and found["wrong"], line
        assert words in found["wrong"], line
    assert typed(tab, ENERGY, PEAK)["status"] == "feasible"
