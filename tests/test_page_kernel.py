"""The solver of the rendered page against the package, in a real browser."""

import json
import re
from itertools import count, islice

import numpy as np
import pytest

import sosbook as sos
from sosbook.book import thesis
from sosbook.book.elements.scripts import script
from sosbook.book.kernel import texts
from sosbook.exact.checker import verdict as check
from sosbook.exact.checker.subject import digest
from sosbook.exact.definite import round_digits
from sosbook.exact.proof_file import parse
from sosbook.exact.rational import decimal
from sosbook.requirements.pole_region import LMIRegion
from sosbook.runtime.reading import read_text
from sosbook.solver.barrier import Barrier
from sosbook.synthesis.proofs import DesignProof, DesignRefusal
from sosbook.synthesis.request import Request
from sosbook.synthesis.scaled_lmis import ScaledLMIs
from tests.cases import campaign, random_cost_request, random_plant, random_request
from tests.elements import write_page
from tests.page_requests import page_request
from tests.test_hull import MISLEAD, SUFFICE, box

SOLVE = """requests => {
  const {design, prove, refusalFile} = globalThis.kernel ??= sosKernel();
  return requests.map(([request, exact]) => {
    const r = design(request), kept = {status: r.status, K: r.K, poles: r.poles,
      margins: r.margins, bounded: r.bounded, reason: r.reason};
    if (exact && r.status === "feasible") kept.proof = prove(request, r).text;
    if (exact && r.status === "infeasible")
      kept.refusal = refusalFile(request, r.refusal).text;
    return kept;
  }); }"""


def solved(kernel, requests, exact=1):
    """What the kernel says; every ``exact``-th with a proof."""
    return kernel.evaluate(
        SOLVE, [[page_request(**r), k % exact == 0] for k, r in enumerate(requests)]
    )


def polytopes():
    """Some whose vertices suffice and some others, with K_A or without."""
    rng = np.random.default_rng(5)
    for name, changes in (SUFFICE | MISLEAD).items():
        if name == "a mass that is zero":
            continue
        plant = box(changes)
        all_ = plant.vertices
        for corners in (all_, all_[1:], all_[:-1], all_[::-1]):
            if corners:
                yield dict(plant=sos.Polytope(corners))
        for size in (0.3, 0.1):
            K_A = (size * rng.standard_normal((2, 2))).round(2)
            yield dict(plant=plant, K_A=K_A)
    masses = (np.diag([x, 1.0]) for x in (1, 2, -1.5))  # none is singular
    yield dict(plant=sos.Polytope([sos.SecondOrderSystem(M, *[np.eye(2)] * 3)
                                   for M in masses]))  # fmt: skip
    third = 1 / 3  # 1 - 1/3 and 2 - 4/3 are the same float
    alike = [sos.SecondOrderSystem(k * np.eye(2), np.eye(2), np.eye(2), b * np.eye(2))
             for k, b in ((1, 1), (2, 4))]  # fmt: skip
    yield dict(plant=sos.Polytope(alike), K_A=third * np.eye(2))


def test_a_page_s_theorems_are_the_checker_s_texts():
    """As they are written now; no script of the solver has one of its own."""
    assert texts.stored() == read_text(texts.FILE)
    for path in texts.FILE.parent.glob("*.js"):
        assert not re.search(r"Theta|\bEPE\b|gamma\^2", read_text(path)), path.name


def test_the_page_asks_for_the_package_s_pairs(kernel):
    for asked in polytopes():
        pairs = kernel.evaluate(
            "request => (globalThis.kernel ??= sosKernel()).coupledPairs(request)",
            page_request(**asked),
        )
        assert [tuple(pair) for pair in pairs] == list(Request(**asked).pairs)


def requests(n, count_=None, kind=random_request):
    """Random requests of n degrees of freedom at the most, without end."""
    seeds = (kind(seed) for seed in count())
    return islice((r for r in seeds if r["plant"].n <= n), count_)


def off(K, L):
    """The largest difference of two gains, relative to the largest entry."""
    return np.abs(np.array(K) - L).max() / np.abs(L).max()


def proven(text):
    """Whether a page's file is proven, and to the letter the package's own."""
    kind, data = parse(text)
    cls = {"design": DesignProof, "infeasible design": DesignRefusal}[kind]
    return cls.of(data).text == text and cls(text).proven


def agree(kernel, asked, undecided):
    """No verdict contradicts the package, few are undecided, gains are equal."""
    mine = solved(kernel, asked, exact=5)
    verdicts, apart, of_cones = [], [], []
    for request, r in zip(asked, mine, strict=True):
        theirs = sos.design_pid(**{"coupling": "pairs"} | request)
        if r["status"] == "undecided" and theirs.status == "infeasible":
            # modes out of place refuse it, and multipliers don't: an edge of the LMIs
            if theirs.infeasibility.kind != "infeasible design":
                continue
        verdicts.append((r["status"], theirs.status))
        if r["status"] == theirs.status == "feasible":
            # what has no bound has no centre either, but that of a part, which
            # depends on the coordinates and the accuracy of a Riccati equation
            (of_cones if r["bounded"] else apart).append(off(r["K"], theirs.K))
            if "proof" in r:
                told = [words for words, _ in theirs.request.claims.statements()]
                assert proven(r["proof"]) and check.check(r["proof"]) == told
        if "refusal" in r:
            assert proven(r["refusal"])
            told, refusal = check.check(r["refusal"]), theirs.infeasibility
            if theirs.status == "infeasible" and refusal.kind == "infeasible design":
                many = len(refusal.data["plant"]["vertices"])
                if many == len(request["plant"].vertices):  # else one of them refuses
                    assert told == [*refusal.claims]
    assert not {("feasible", "infeasible"), ("infeasible", "feasible")} & {*verdicts}
    different = [v for v in verdicts if v[0] != v[1]]
    assert len(different) <= undecided, different
    assert max(apart) < 1e-6
    # two of the first 34 requests are
    assert sum(x > 1e-6 for x in of_cones) <= max(2, 0.05 * len(of_cones))
    return verdicts


@pytest.mark.slow
@pytest.mark.parametrize("many", [20, *campaign([100])])
def test_random_requests_have_the_package_s_verdicts_gains_and_proofs(kernel, many):
    verdicts = agree(kernel, list(requests(2, many)), undecided=1 + many // 100)
    for verdict, least in {"feasible": 0.6, "infeasible": 0.06}.items():
        assert verdicts.count((verdict, verdict)) > least * many


@pytest.mark.slow
@pytest.mark.parametrize("many", [10, *campaign([20])])
def test_random_costs_have_the_package_s_verdicts_gains_and_proofs(kernel, many):
    asked = list(requests(2, many, random_cost_request))
    verdicts = agree(kernel, asked, undecided=1)
    for verdict in ("feasible", "infeasible"):
        assert verdicts.count((verdict, verdict)) > many / 4
    costs = [x for r in asked for x in r["requirements"] if x.kind == "cost"]
    assert {x.noise for x in costs} == {"states", "F"}


@pytest.mark.campaign
@pytest.mark.timeout(1800)
def test_a_thousand_random_requests_and_600_random_costs(kernel):
    asked = *islice(requests(2), 100, 200), *islice(requests(3), 200, 1200)
    agree(kernel, list(asked), undecided=20)
    costs = requests(2, kind=random_cost_request)
    agree(kernel, list(islice(costs, 20, 620)), undecided=11)


def test_a_drive_s_far_centre_is_found_by_the_page_too(kernel):
    """The gain doesn't jump with the decay rate, nor from the package to the page."""
    shaft = np.array([[1.0, -1.0], [-1.0, 1.0]])
    plant = sos.SecondOrderSystem(
        np.diag([0.0025, 0.0045]), 0.004 * shaft, 1.9 * shaft, [[1], [0]]
    )
    asked = [
        dict(
            plant=plant,
            U=[[0, 1]],
            region=sos.PoleRegion(sigma=sigma, theta_deg=60, rho=280),
            saturation=sos.Saturation(136, [-1, -1, 0, 0, 0]),
        )
        for sigma in (2.2, 2.65, 2.7, 3.2)
    ]
    for request, r in zip(asked, solved(kernel, asked), strict=True):
        design = sos.design_pid(**request)
        assert design.central and not r["bounded"]
        assert off(r["K"], design.K) < 2e-6


@pytest.mark.parametrize("seed", [415, *campaign([198, 382, 537])])
def test_a_centre_at_the_end_of_a_long_valley_is_found(kernel, seed):
    """Newton's method alone takes hundreds of steps to it."""
    asked = random_cost_request(seed)
    (r,), design = solved(kernel, [asked]), sos.design_pid(**asked)
    assert r["status"] == design.status == "feasible" and not r["bounded"]
    assert off(r["K"], design.K) < 1e-9
    lmis = ScaledLMIs(design.request, design.frame)
    x = lmis.text.packed(lmis.point(design))
    _, decrement = Barrier(lmis.compiled.newton).step(x, 0 * x)
    assert decrement < 0.1  # rounding leaves no less of it in the plant's units


EXAMPLES = {
    "1": thesis.example_1,
    "2": thesis.example_2,
    "3": thesis.example_3,
    "4": thesis.example_4,
}


@pytest.mark.parametrize("name", EXAMPLES)
def test_the_thesis_s_examples_with_both_readings_of_mu(kernel, name):
    example = EXAMPLES[name]()
    asked = [{"plant": example.plant} | example.requirements]
    asked.append(
        asked[0] | {"gamma": getattr(asked[0]["gamma"], "gamma", asked[0]["gamma"])}
    )
    for request, r in zip(asked, solved(kernel, asked), strict=True):
        request = {k: v for k, v in request.items() if v is not None}
        design = sos.design_pid(**request)
        assert r["status"] == design.status == "feasible"
        assert off(r["K"], design.K) < 1e-8
        assert {*r["margins"]} - {"size for u_max"} == {
            str(name) for name in design.margins
        } - {"size for gamma"}
        for name, margin in design.margins.items():
            if name != "size for gamma":
                assert abs(r["margins"][name] - margin) < 1e-9
        poles = [complex(*s) for s in np.reshape(r["poles"], (-1, 2))]
        for s in design.poles().ravel():
            assert min(abs(s - p) for p in poles) < 1e-6 * (1 + abs(s))
        assert DesignProof(r["proof"]).proven


@pytest.mark.parametrize("noise", [None, "F", *campaign(["states"])])
def test_every_block_is_the_theorem_s(kernel, noise):
    """Read from its text: in products L X R in a frame, and at a point by itself."""
    rng = np.random.default_rng(3)
    for n, m, a, vertices in ((1, 1, 1, 1), (2, 1, 1, 2), (2, 2, 2, 3), (4, 2, 2, 2)):
        plant = random_plant(rng, n, m, 2, vertices, 0.1)
        N = 2 * n + a
        root = rng.standard_normal((N, N))
        P, Y, s = root @ root.T, rng.standard_normal((m, N)), 1.7
        asked = dict(
            plant=plant,
            U=np.eye(n)[:a],
            region=sos.PoleRegion(0.3, 0.8, 9),
            gamma=1.3,
            saturation=sos.Saturation(7, rng.standard_normal(N)),
        )
        sizes, J = {"input": s}, np.zeros((0, 0))
        if noise:
            root = rng.standard_normal((N, N - 1))
            asked["requirements"] = [
                sos.QuadraticCost(
                    root @ root.T,
                    plant.vertices[0].B.T @ plant.vertices[0].B,
                    noise,
                    40,
                )
            ]
            q = N if noise == "states" else 2
            J, sizes["cost"] = rng.standard_normal((q, q)), 0.6
            J = J + J.T
        blocks, stated = kernel.evaluate(
            """([request, P, Y, J, sizes]) => {
          const k = globalThis.kernel ??= sosKernel();
          const plain = k.descriptors(request), pairs = k.coupledPairs(request);
          const {asked} = request, I = k.identity(P.length);
          const frame = {T: I, left: I, back: I, scale: 1, own: 1, sizes: {}};
          const blocks = k.assembled(plain, pairs, asked, frame);
          const values = {P: k.matrix(P), Y: k.matrix(Y), J: k.matrix(J)};
          const names = {input: "size for u_max", cost: "size for cost"};
          for (const [name, s] of Object.entries(sizes))
            values[names[name]] = k.matrix([[s]]);
          const list = blocks.at(blocks.packed(values)).map((G, b) => {
            const {name, d} = blocks.list[b], rows = k.rowsOf(G);
            return [name, rows.map((row, i) => row.map((g, j) => g / d[i] / d[j]))];
          });
          const {P: X, Y: Z} = values, {input: u_max, cost = 1} = sizes;
          const J1 = k.scaled(1 / cost, values.J), own = {u_max, cost};
          const point = {P: X, Y: Z, J: J1, sizes: own};
          const there = Object.entries(k.statedAt(plain, pairs, asked, point));
          return [list, there.map(([name, G]) => [name, k.rowsOf(G)])].map(
            Object.fromEntries); }""",
            [page_request(**asked), P.tolist(), Y.tolist(), J.tolist(), sizes],
        )
        request = Request(**asked)
        whole = request.blocks(P, Y, own={"J": J})
        assert len(blocks) == len(whole) + len(sizes)  # and the sizes themselves
        for name, theirs in whole.items():
            owner = name.requirement[0] if name.requirement else ""
            size = sizes.get(owner, 1)
            theirs = (
                size * request.blocks(P / size, Y / size, own={"J": J / size})[name]
            )
            for ours in (blocks, stated):
                assert np.allclose(ours[name], theirs, rtol=1e-11, atol=1e-11), name


def test_a_warm_start_changes_nothing_but_the_time(kernel):
    example = thesis.example_1()
    request = page_request(example.plant, **example.requirements)
    steps, apart = kernel.evaluate(
        """request => {
      const {design} = globalThis.kernel ??= sosKernel();
      let before = null, steps = [0, 0], apart = 0;
      for (let k = 0; k <= 20; k++) {
        const bounds = {sigma: 0.4 + 0.03 * k, gamma: 1.257 - 0.01 * k};
        const asked = {...request, asked: {...request.asked, ...bounds}};
        const cold = design(asked), warm = design(asked, before);
        const K = cold.K.flat(), size = Math.max(...K.map(Math.abs));
        const off = warm.K.flat().map((x, i) => Math.abs(x - K[i]) / size);
        apart = Math.max(apart, ...off);
        steps[0] += cold.steps[0] + cold.steps[1];
        steps[1] += warm.steps[0] + warm.steps[1];
        before = warm;
      }
      return [steps, apart]; }""",
        request,
    )
    assert apart < 1e-8
    assert steps[1] < 0.7 * steps[0]


def test_a_worker_from_the_disk_computes_without_a_network(visit, tmp_path):
    sheet = write_page(tmp_path / "sheet.html", f"<script>{script('kernel')}</script>")
    tab, example = visit(sheet), thesis.example_4()
    verdict = tab.page.evaluate(
        """request => new Promise((done, failed) => {
      const text = `const k = (${sosKernel})();
        onmessage = e => postMessage(k.design(e.data));`;
      const worker = new Worker(URL.createObjectURL(new Blob([text])));
      worker.onmessage = e => done(e.data.status);
      worker.onerror = e => failed(e.message);
      worker.postMessage(request); })""",
        page_request(example.plant, **example.requirements),
    )
    assert verdict == "feasible"
    assert tab.errors == []
    assert all(url.startswith(("file:", "data:", "blob:")) for url in tab.requests)


# ----------------------------------------------------------------- the parts
def test_numbers_are_written_as_python_writes_them(kernel):
    rng = np.random.default_rng(9)
    numbers = [0.0, -0.0, 1.0, 150.0, 0.1, 1e-4, 1e-5, 1e15, 1e16, 1e22, 5e-324, -2.5]
    numbers += list(rng.standard_normal(300) * 10.0 ** rng.integers(-20, 20, 300))
    texts = kernel.evaluate(
        "list => list.map((globalThis.kernel ??= sosKernel()).decimal)",
        [float(x) for x in numbers],
    )
    assert texts == [decimal(float(x)) for x in numbers]


def test_regions_are_rounded_as_the_package_rounds_them(kernel):
    thetas = np.append(
        np.radians(np.arange(0.5, 90.5, 0.5)), np.arange(0.01, 1.57, 0.01)
    )
    sigmas = round_digits(np.random.default_rng(1).uniform(0.01, 9, 400), 3)
    mine, bounds = kernel.evaluate(
        "([t, s]) => { const k = globalThis.kernel ??= sosKernel();"
        "return [t.map(k.sector), s.map(k.twiceAtLeast)]; }",
        [thetas.tolist(), sigmas.tolist()],
    )
    for theta, r in zip(thetas, mine, strict=True):
        assert LMIRegion.sector(theta).beta[0].tolist() == [r["sin"], r["cos"]]
        assert LMIRegion.sector(theta).data()["degrees"] == r["degrees"]
    for sigma, bound in zip(sigmas, bounds, strict=True):
        assert LMIRegion.half_plane(sigma).alpha[0, 0] == bound


def test_the_digest_is_python_s(kernel):
    for text in ("", "abc", "x" * 55, "x" * 56, "x" * 64, json.dumps(list(range(99)))):
        data = {"text": text}
        plain = json.dumps(data, sort_keys=True, separators=(",", ":"))
        mine = kernel.evaluate(
            "t => (globalThis.kernel ??= sosKernel()).sha256(t)", plain
        )
        assert mine == digest(data)


def test_multipliers_that_are_not_exact_refuse_nothing(kernel):
    """Floats are sure, and the word is undecided where no exact ones are found."""
    request = page_request(**random_request(230))
    hasty, careful = kernel.evaluate(
        """request => {
      const {design} = globalThis.kernel ??= sosKernel();
      return [design(request, null, true), design(request)].map(
        ({status, reason}) => [status, reason]); }""",
        request,
    )
    assert hasty[0] == "infeasible"
    assert careful[0] == "undecided" and "no exact ones" in careful[1]


@pytest.mark.parametrize("noise", ["states", "F"])
def test_nothing_of_a_weight_is_left_out_on_the_page(kernel, noise):
    """What weighs outputs is factored exactly; what weighs less than nothing isn't."""
    one = np.eye(2)
    plant = sos.SecondOrderSystem(one, 0.2 * one, [[3, -1], [-1, 2]], one, one)
    asked = []
    for seed in range(6):
        C = np.random.default_rng(seed).normal(size=(1 + seed % 2, 4))
        cost = sos.QuadraticCost(C.T @ C, one, noise, 40.0)
        asked.append({"plant": plant, "requirements": [cost]})
    for found in solved(kernel, asked):
        assert proven(found["proof"]) and check.check(found["proof"])
    request = page_request(**asked[0])
    request["asked"]["Q"] = np.diag([0, 0, 1.0, 0]).tolist()
    request["asked"]["Q"][0][1] = request["asked"]["Q"][1][0] = 1e-13
    said = kernel.evaluate(
        """request => { try { return sosKernel().design(request).status; }
          catch (fault) { return fault.message; } }""",
        request,
    )
    assert "Q has a negative eigenvalue" in said


@pytest.mark.parametrize("sigma", [-0.1, 0, 0.1])
def test_the_page_proves_stability_where_no_bound_does(kernel, sigma):
    plant = sos.SecondOrderSystem(np.eye(1), [[-0.5]], [[2.0]], [[1.0]])
    request = page_request(plant, sigma=sigma, rho=9.0)
    text = kernel.evaluate(
        """request => { const {design, prove} = sosKernel();
          return prove(request, design(request)).text; }""",
        request,
    )
    proof = DesignProof(text)
    assert proven(text) and check.check(text) == list(proof.claims)
    owners = [name.requirement for name in proof.blocks]
    assert (("stability", "stability") in owners) == (sigma < 0)
