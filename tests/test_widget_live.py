"""A page's explorer with the package behind it says what the page says."""

import html
import json
import re
from urllib.parse import urlencode

import numpy as np
import pytest

import sosbook as sos
from sosbook.book import widgets
from sosbook.book.elements import bench
from sosbook.book.elements.answers import Answers
from sosbook.book.elements.bench import EXAMPLES
from sosbook.book.elements.explorer import design_explorer
from sosbook.synthesis.known_proof import KnownGainProof
from sosbook.synthesis.proofs import DesignProof, DesignRefusal
from tests.cases import by_turns, random_cost_request, random_request
from tests.elements import write_page
from tests.page_requests import page_request
from tests.test_page_elements import stored
from tests.test_page_kernel import off

DESIGN = """([request, prove]) => {
  const k = globalThis.kernel ??= sosKernel(), found = k.design(request);
  const {status, reason, K, poles, margins, bounded} = found;
  const answer = {status, reason, K, poles, margins, bounded};
  return status === "feasible" ? {...answer, ...k.truth(request, found)} : answer; }"""
EXPLORERS = {
    chapter: json.loads(
        re.search(r'<script type="application/json">(.*?)</script>', text)[1]
    )
    for chapter, text in stored()
    if text.startswith("<sos-wish")
}


def places(data, count):
    """The bounds at first, and random ones around them where they move."""
    rng = np.random.default_rng(len(data["title"]))
    for k in range(count + 1):
        far = {x["key"]: x["moves"] and k > 0 for x in data["bounds"]}
        yield {
            x["key"]: float(
                f"{x['value'] * 3 ** (far[x['key']] * rng.uniform(-1, 1)):.3g}"
            )
            for x in data["bounds"]
        }


def asked_at(shown):
    """What is asked; angles are shown in degrees."""
    angle = {"theta": np.radians(min(shown["theta"], 90))} if "theta" in shown else {}
    return shown | angle


@pytest.fixture
def wished(robot):
    """A request of the page: Example 1 with everything."""

    def wished(sigma, **more):
        return page_request(
            robot.plant,
            robot.U,
            region=sos.PoleRegion(sigma, np.pi / 4, 5),
            gamma=1.257,
            saturation=robot.saturation,
            **more,
        )

    return wished


def same(mine, theirs):
    """Whether two answers, of the page and of the package, tell readers the same."""
    assert mine["status"] == theirs["status"]
    if mine["status"] != "feasible":
        assert mine["reason"] == theirs["reason"]
        return
    assert mine["bounded"] == theirs["bounded"]
    assert off(mine["K"], np.array(theirs["K"])) < 1e-6
    for one, two in zip(mine["poles"], theirs["poles"], strict=True):
        one, two = ([complex(*s) for s in loop] for loop in (one, two))
        for s in one:
            assert min(abs(s - t) for t in two) < 1e-5 * (1 + abs(s))
    for key, rel in {"norm": 1e-4, "peak": 2e-3, "cost": 1e-6}.items():
        assert (mine[key] is None) == (theirs[key] is None), key
        assert mine[key] is None or mine[key] == pytest.approx(theirs[key], rel=rel)
    worst = [min(a["margins"], key=a["margins"].get) for a in (mine, theirs)]
    assert worst[0] == worst[1]
    assert mine["margins"][worst[0]] == pytest.approx(
        theirs["margins"][worst[0]], abs=1e-7
    )


def test_the_chapters_with_a_design_have_an_explorer():
    numbers = {chapter[:2] for chapter in EXPLORERS}
    assert numbers >= {"04", "05", "06", "07", "11", "12", "13", "14", "27", "18"}


@pytest.mark.slow
@pytest.mark.parametrize("chapter", by_turns(EXPLORERS, 1))
def test_page_and_package_answer_alike_where_the_book_has_an_explorer(kernel, chapter):
    """Where it starts, and at random places, of which the page may leave one open."""
    data, undecided = EXPLORERS[chapter], 0
    for k, shown in enumerate(places(data, 2)):
        asked = asked_at(shown)
        asked |= {"x0": data["x0"]} if "u_max" in asked else {}
        asked |= {} if data["mu"] is None else {"mu": data["mu"]}
        request = data["request"] | {"asked": asked | (data.get("cost") or {})}
        mine = kernel.evaluate(DESIGN, [request, False])
        theirs = Answers()("move", request)
        if mine["status"] == "undecided" != theirs["status"]:
            undecided += 1
        else:
            same(mine, theirs)
        assert k or mine["status"] == "feasible"
    assert undecided <= 1


@pytest.mark.slow
@pytest.mark.parametrize(
    "request_of, seed",
    [(random_request, k) for k in (1, 2, 5, 308)]
    + [(random_cost_request, k) for k in (3, 308)],
)
def test_page_and_package_say_alike_whether_solutions_are_bounded(
    kernel, request_of, seed
):
    asked = request_of(seed)
    request = page_request(**asked)
    mine, theirs = kernel.evaluate(DESIGN, [request, False]), Answers()("move", request)
    assert mine["status"] == theirs["status"]
    if mine["status"] == "feasible":
        assert mine["bounded"] == theirs["bounded"]


def test_an_answer_does_not_depend_on_the_last_one(wished):
    travelled, direct = Answers(), Answers()
    for sigma in (0.3, 2.3, 0.5):
        travelled("move", wished(sigma))
    one, two = travelled("move", wished(0.7)), direct("move", wished(0.7))
    assert off(one["K"], np.array(two["K"])) < 1e-8


def test_proofs_are_files_of_the_package(wished):
    good, bad = (Answers()("prove", wished(s))["proof"] for s in (0.7, 2.3))
    assert good["proven"] and DesignProof(good["text"]).proven and good["digits"] == 6
    assert bad["proven"] and DesignRefusal(bad["text"]).proven


def test_what_cannot_be_asked_is_said(wished):
    request = wished(0.7)
    request["vertices"][0]["B"] = [[1, 0]]
    answer = Answers()("move", request)
    assert answer["status"] == "undecided" and "B" in answer["reason"]


def of_law(J, **more):
    """A request of the page: a drive whose encoder is the motor's."""
    drive = [
        dict(M=[[0.0025, 0], [0, x]], D=[[0.004, -0.004], [-0.004, 0.004]],
             S=[[1.9, -1.9], [-1.9, 1.9]], B=[[1], [0]])
        for x in (*J, "J")
    ]  # fmt: skip
    family = drive.pop() | {"parameters": [["J", *J]]}
    law = {"position": [[1, 0]], "filter": 0.002, "integrate": [[1]]}
    return {
        "vertices": drive,
        "family": family,
        "U": [[1, 0]],
        "K_A": None,
        "coupling": "pairs",
        "law": law,
        "asked": {"sigma": 3.3},
    } | more


def test_a_law_is_the_package_s_between_the_corners_too():
    """Its gains, and a file that the checker decides; the loop of "own" is theirs."""
    request = of_law([0.003, 0.006])
    answers = Answers()
    found, again = (answers(kind, request) for kind in ("move", "prove"))
    assert found["status"] == "feasible" and again["own"] == found["own"]
    proof = KnownGainProof(again["proof"]["text"])
    assert proof.proven and "J in [0.003, 0.006]" in proof.claims[0]
    on_z, on_rate, on_sum = found["own"][0]
    K_P, K_D, K_I = (found["gains"][x][0][0] for x in ("K_P", "K_D", "K_I"))
    assert (on_z, on_rate, on_sum) == (K_P, K_D / 0.002, K_I)
    for v in request["vertices"]:
        M, D, S, B = (np.array(v[x]) for x in "MDSB")
        A = np.zeros((6, 6))
        A[:2, 2:4], A[4, 0], A[5, [0, 5]] = np.eye(2), 1, (1 / 0.002, -1 / 0.002)
        u = [on_z + on_rate, 0, 0, 0, on_sum, -on_rate]
        A[2:4] = np.linalg.solve(M, np.hstack([-S, -D, np.zeros((2, 2))]) + B * u)
        s = np.linalg.eigvals(A)
        assert s.real.max() < -3.3


def test_a_live_element_asks_the_package_for_a_law(browser, tmp_path):
    """Gains, word and proof are the package's; its own search isn't asked."""
    page, jobs, answers = browser.new_page(), [], Answers()

    def asked(text):
        job = json.loads(text)
        jobs.append((job["kind"], bool(job["request"].get("law"))))
        found = answers(job["kind"], job["request"])
        return json.dumps({"id": job["id"], "by": "the package"} | found)

    page.expose_function("asked", asked)
    home = (
        '<div class="sos-live"><div class="sos-question"><textarea></textarea></div>'
        '<div class="sos-answer"></div>', bench().html, "</div>",
        """<script>document.querySelector(".sos-question textarea").addEventListener(
        "input", ({target}) => asked(target.value).then(text => {
          document.querySelector(".sos-answer").textContent = text; }));</script>""",
    )  # fmt: skip
    typed = EXAMPLES["A pendulum, upright"] | {
        "position": 1, "filter": 0.02, "bounds": "law", "sigma": 2, "theta": 80,
        "rho": 300,
    }  # fmt: skip
    place = write_page(tmp_path / "live.html", *home).as_uri()
    page.goto(f"{place}#sos-bench-1:{urlencode(typed)}")
    page.locator(".sos-say em:has-text('proven')").wait_for()
    found, word = page.evaluate(
        """() => { const {answer, word} = document.querySelector("sos-bench");
        return [answer, word]; }"""
    )
    assert jobs == [("move", True), ("prove", True)] and word == "proven"
    assert found["by"] == "the package" and found["gains"].keys() >= {"K_P", "K_I"}
    assert KnownGainProof(found["proof"]["text"]).proven
    page.close()


@pytest.fixture
def shown(robot):
    return design_explorer(robot.plant, robot.U, region=sos.PoleRegion(0.7, rho=5.0))


def ask(widget, **job):
    widget.question.value = json.dumps(job)
    return json.loads(html.unescape(widget.answer.value))


def test_the_widget_answers_what_the_element_asks(shown, wished, robot):
    widget = widgets.live(shown)
    (picture,) = widget.children[0].outputs
    assert picture["data"]["text/html"].endswith(shown.html)
    assert widget.answer.value == ""
    answer = ask(widget, id=3, key="x", kind="move", request=wished(0.7))
    design = sos.design_pid(
        robot.plant, robot.U, region=sos.PoleRegion(0.7, np.pi / 4, 5),
        gamma=1.257, saturation=robot.saturation,
    )  # fmt: skip
    assert answer["id"] == 3 and answer["by"] == "the package"
    assert off(answer["K"], design.K) < 1e-9
    refused = ask(widget, id=4, key="x", kind="probe", request=wished(2.3))
    assert refused["id"] == 4 and refused["status"] == "infeasible"
    assert "K" not in refused


def test_live_wants_an_explorer():
    with pytest.raises(ValueError, match="needs an explorer"):
        widgets.live("sigma")
