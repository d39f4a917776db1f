"""Edges and frontiers: proven on both sides, monotone, the same anyhow."""

import json
import re

import numpy as np
import pytest

import sosbook as sos
from sosbook.book import elements, thesis
from sosbook.book.counterexamples import actuated
from sosbook.studies import maps
from sosbook.synthesis import slack
from sosbook.synthesis.proofs import prove, refuse_design
from tests.cases import examples
from tests.elements import assert_buttons, green, said, write_page

NAMES = ("sigma", "theta", "rho", "gamma", "u_max")


@pytest.fixture(scope="module")
def edges(robot):
    """Of Example 1, to two digits."""
    return {
        name: maps.edge(name, robot.plant, **robot.requirements, digits=2)
        for name in NAMES
    }


@pytest.fixture(scope="module")
def force(robot):
    return maps.frontier(
        "gamma",
        "u_max",
        robot.plant,
        **robot.requirements,
        values=[2, 0.6, 1.2, 0.8],
        progress=False,
    )


def harder(name, value, factor):
    return value * factor if name == "sigma" else value / factor


# ------------------------------------------------------------------- edges
@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_both_sides_are_proven_for_what_they_say(edges, name):
    edge = edges[name]
    assert edge.proven
    for side, design in (
        (edge.feasible, edge.design),
        (edge.infeasible, edge.excluded),
    ):
        asked = maps.requirements(design.request)
        assert np.isclose(asked[name], side, rtol=1e-12)
    others = {
        k: v for k, v in maps.requirements(edge.design.request).items() if k != name
    }
    printed = maps.requirements(maps.request(thesis.example_1()))
    assert others == {k: v for k, v in printed.items() if k != name}


@pytest.mark.parametrize("name", NAMES)
def test_the_sides_are_neighbours_on_the_harder_side(edges, robot, name):
    edge = edges[name]
    printed = maps.requirements(maps.request(robot))[name]
    yes, no = (maps.shown(name, v) for v in (edge.feasible, edge.infeasible))
    assert np.allclose([yes, no], [float(f"{v:.1e}") for v in (yes, no)], rtol=1e-14)
    digits = [
        round(v / 10 ** (np.floor(np.log10(min(yes, no))) - 1)) for v in (yes, no)
    ]
    assert abs(digits[0] - digits[1]) == 1
    assert edge.feasible > printed if name == "sigma" else (edge.feasible < printed)


def test_relaxing_keeps_the_solution(edges):
    """The theorem on edges: with the same P and Y."""
    for name, edge in edges.items():
        known = maps.requirements(edge.design.request)
        easier = edge.design.request.with_bounds(
            known | {name: harder(name, known[name], 0.8)}
        )
        assert prove(easier, edge.design.K, edge.design.P).proven


def test_an_infeasible_request_finds_its_edge_on_the_easier_side(robot):
    asked = robot.requirements | dict(gamma=sos.HInfinity(0.1, mu=1.0))
    edge = maps.edge("gamma", robot.plant, **asked, digits=2)
    assert (edge.feasible, edge.infeasible) == (0.64, 0.63)
    assert edge.proven


@pytest.mark.campaign  # chapter 28 proves this edge, too
def test_an_edge_with_a_lyapunov_matrix_of_bad_condition():
    arm = thesis.example_4()
    edge = maps.edge("sigma", arm.plant, **arm.requirements, digits=2)
    assert edge.proven
    assert (edge.feasible, edge.infeasible) == (6.4, 6.5)


def test_no_edge_is_said_and_not_invented(robot):
    edge = maps.edge("sigma", robot.plant, robot.U, sos.PoleRegion(sigma=0.7), digits=1)
    assert edge.infeasible is None and edge.excluded is None
    assert edge.feasible == 700 and edge.design.certify().proven
    assert "nothing is proven infeasible up to sigma = 700" in edge.reason
    assert not edge.proven and edge.reason in repr(edge)
    with pytest.raises(ValueError, match="one side only"):
        edge.shares


@pytest.mark.slow
def test_no_design_is_said_too():
    mass, little = sos.SecondOrderSystem(0.3, 0, 0, 0.3), sos.Saturation(1, [1, 0])
    region = sos.PoleRegion(sigma=3, rho=5)
    edge = maps.edge("rho", mass, region=region, saturation=little, digits=1)
    assert edge.feasible is None and edge.design is None
    assert edge.excluded.infeasibility.proven
    assert edge.reason == "no design up to rho = 5000"


@pytest.mark.slow
def test_other_couplings_have_edges_too():
    arm = thesis.example_4()
    edge = maps.edge(
        "rho", arm.plant, **arm.requirements, digits=1, coupling=("slack", 0.05)
    )
    assert edge.design.V is not None and edge.design.certify().proven
    assert edge.design.slack == 0.05
    assert set(edge.shares) == {"sigma", "theta", "rho"}


@pytest.mark.campaign  # chapter 28 prints both slopes
@pytest.mark.slow
def test_shares_are_the_slope_of_the_frontier(robot):
    asked = robot.requirements
    shares = maps.edge("u_max", robot.plant, **asked).shares
    assert np.isclose(sum(shares.values()), 1)
    assert set(shares) == set(NAMES)
    assert min(shares.values()) >= 0 and shares["rho"] < 0.01
    ends = [
        maps.edge(
            "u_max", robot.plant, **asked | dict(gamma=sos.HInfinity(g, mu=1.0))
        ).feasible
        for g in (1.257 / 1.2, 1.257 * 1.2)
    ]
    slope = -np.log(ends[1] / ends[0]) / np.log(1.44)
    assert np.isclose(slope, shares["gamma"] / shares["u_max"], rtol=0.03)


def test_shares_do_not_depend_on_units(robot):
    plant = robot.plant
    tons = sos.SecondOrderSystem(  # forces in kilonewtons, w alike
        plant.M / 1e3, plant.D / 1e3, plant.S / 1e3, plant.B, plant.F / 1e3
    )
    asked = robot.requirements | dict(
        saturation=sos.Saturation(0.15, robot.saturation.x0)
    )
    one = maps.edge("gamma", plant, **robot.requirements, digits=2)
    two = maps.edge("gamma", tons, **asked, digits=2)
    assert one.feasible == two.feasible
    for name, share in one.shares.items():
        assert np.isclose(share, two.shares[name], atol=2e-3)


@pytest.mark.parametrize(
    "change, fault",
    [
        (dict(name="speed"), "name = 'speed' must be one of sigma"),
        (dict(digits=0), "digits must be 1, 2, ..., got 0"),
        (dict(digits=2.5), "digits must be 1, 2, ..., got 2.5"),
        (dict(region="disk"), "region must be a PoleRegion"),
        (dict(name="u_max", saturation=None), "u_max needs saturation"),
    ],
)
def test_bad_input_is_named(robot, change, fault):
    asked = dict(name="sigma", plant=robot.plant) | robot.requirements
    with pytest.raises(ValueError, match=fault):
        maps.edge(**asked | change)


def test_gamma_needs_a_disturbance():
    arm = thesis.example_4()
    with pytest.raises(ValueError, match="gamma needs a plant with F"):
        maps.edge("gamma", arm.plant, **arm.requirements)


# --------------------------------------------------------------- frontiers
@pytest.mark.slow
def test_a_frontier_is_a_monotone_staircase(force):
    assert force.values == (2, 1.2, 0.8, 0.6)
    assert all(edge.proven for edge in force.edges)
    assert (np.diff(force.feasible) > 0).all()
    assert (force.infeasible < force.feasible).all()
    for gamma, edge in zip(force.values, force.edges):
        asked = maps.requirements(edge.design.request)
        assert asked["gamma"] <= gamma and asked["u_max"] <= edge.feasible
        asked = maps.requirements(edge.excluded.request)
        assert asked["gamma"] >= gamma and asked["u_max"] >= edge.infeasible


@pytest.mark.slow
def test_each_entry_is_the_edge_found_alone(force, robot):
    for gamma, edge in [*zip(force.values, force.edges)][::2]:
        asked = robot.requirements | dict(gamma=sos.HInfinity(gamma, mu=1.0))
        alone = maps.edge("u_max", robot.plant, **asked, digits=2)
        assert alone.feasible == edge.feasible
        assert alone.infeasible == edge.infeasible


@pytest.mark.slow
def test_status_is_what_the_proofs_say(force, robot):
    seen = set()
    for gamma, u_max in ((0.5, 400), (0.7, 30), (0.7, 130), (0.7, 400), (1.5, 60)):
        status = force.status(gamma, u_max)
        seen.add(status)
        fresh = sos.design_pid(
            robot.plant,
            robot.U,
            region=robot.region,
            gamma=sos.HInfinity(gamma, mu=1.0),
            saturation=sos.Saturation(u_max, robot.saturation.x0),
        )
        assert status in (fresh.status, "undecided")
        found = force.design(gamma, u_max)
        if status == "feasible":
            assert prove(fresh.request, found.K, found.P).proven
    assert seen == {"feasible", "infeasible", "undecided"}
    with pytest.raises(ValueError, match="u_max = -1 must be positive"):
        force.status(1, -1)


def test_the_set_of_bounds_is_convex(force):
    """One certificate excludes a half-plane; no design lies in it."""
    for edge in force.edges:
        d = edge.excluded
        proof = refuse_design(d.request, d.frame, d.multipliers)
        N, n = d.request.order, d.request.plant.n
        Z = {k: z.astype(float) for k, z in proof.multipliers.items()}
        b = np.trace(Z["hinf"][N : N + n, N : N + n])
        c = np.trace(Z["u_max"][N:, N:]) / d.frame.scale**2
        a = proof.value - b * d.gamma**2 - c * edge.infeasible**2
        assert b > 0 and c > 0
        assert (a + b * np.square(force.values) + c * force.feasible**2 > 0).all()


@pytest.mark.campaign  # chapter 28 asks the same
@pytest.mark.slow
def test_sigma_and_theta_are_not_convex(robot):
    front = maps.frontier(
        "sigma",
        "theta",
        robot.plant,
        **robot.requirements,
        values=[0.3, 0.8, 1.3],
        progress=False,
    )
    half = (front.feasible[0] + front.feasible[-1]) / 2
    assert front.status(0.3, front.feasible[0]) == "feasible"
    assert front.status(1.3, front.feasible[-1]) == "feasible"
    assert front.status(0.8, half) == "infeasible"


@pytest.mark.parametrize(
    "change, fault",
    [
        (dict(y="gamma"), "x and y are both"),
        (dict(x="speed"), "must be one"),
        (dict(values=[1]), "values of gamma must be two or more"),
        (dict(values=[1, -1]), "values of gamma"),
    ],
)
def test_bad_frontiers_are_named(robot, change, fault):
    asked = dict(x="gamma", y="u_max", plant=robot.plant, values=[1, 2])
    with pytest.raises(ValueError, match=fault):
        maps.frontier(**asked | robot.requirements | change)


# ------------------------------------------------------------------- atlas
@pytest.fixture(scope="module")
def atlas(force):
    arm = thesis.example_4()
    radius = maps.frontier(
        "sigma", "rho", arm.plant, **arm.requirements, values=[4, 5, 6], progress=False
    )
    return elements.MapAtlas(
        {"The <robot> & co": [force], "Arm": [radius]}, title='a</script><b>"&'
    )


@pytest.fixture(scope="module")
def sheet(atlas, tmp_path_factory):
    return write_page(
        tmp_path_factory.mktemp("page") / "map.html",
        atlas.light,
        "<p>between</p>",
        atlas.light,
    )


def test_the_page_stores_the_proofs(atlas, force):
    data = re.search(r'<script type="application/json">(.*?)</script>', atlas.html)[1]
    assert not re.search(r"(?<![\d.])-0(\.0)?(?=[,\]])|NaN|Infinity", data)
    stored = json.loads(data)
    assert stored["title"] == 'a</script><b>"&'
    (first,) = stored["groups"][0]["maps"]
    assert first["held"] == ["σ = 0.7 1/s", "θ = 45°", "ρ = 5 1/s"]
    for row, edge in zip(first["rows"], force.edges):
        assert row[:2] == [edge.feasible, edge.infeasible]
        K = first["designs"][row[2]]["K"]
        assert np.allclose(K, edge.design.K.ravel(), rtol=6e-4)
        shares = dict(first["refusals"][row[3]]["shares"])
        assert 0.98 <= sum(shares.values()) <= 1.02
    assert "http" not in atlas.html.replace("http://www.w3.org", "")
    assert repr(atlas) == "MapAtlas: 2 frontiers"
    with pytest.raises(ValueError, match="one Frontier or more"):
        elements.MapAtlas({})


def test_the_page_says_what_python_says(visit, sheet, atlas, force):
    tab = visit(sheet)
    box = tab.page.locator("sos-map").first
    words = {
        "feasible": "Certified",
        "infeasible": "Excluded",
        "undecided": "Undecided",
    }
    axes = atlas.data["groups"][0]["maps"][0]
    seen = set()
    for gamma in axes["x"]["values"]:
        box.get_by_role("spinbutton", name="H∞ bound γ").fill(str(gamma))
        for u_max in axes["y"]["values"][::20]:
            box.get_by_role("spinbutton", name="Input bound uₘₐₓ").fill(str(u_max))
            status = force.status(gamma, u_max)
            assert said(box).startswith(words[status])
            seen.add(status)
    assert {"feasible", "infeasible"} <= seen
    assert tab.errors == [] and all(
        r.startswith(("file:", "data:")) for r in tab.requests
    )


def test_names_stand_in_the_page_as_the_book_prints_them(visit, sheet):
    box = visit(sheet).page.locator("sos-map").first
    menu = box.get_by_label("Requirements", exact=True)
    assert menu.inner_text() == "γ and uₘₐₓ"
    bound = box.get_by_role("spinbutton", name="Input bound uₘₐₓ")
    for key, words in ("Down", "certified for γ = "), ("Up", "no design for γ = "):
        for _ in range(8):
            bound.press(f"Page{key}")
        text = box.evaluate("e => e.view.textContent")
        assert re.search(words + r"[\d.]+, uₘₐₓ = \d", text)
        assert "u_max" not in text
    assert "Input bound uₘₐₓ: " in text  # a refusal's share


def test_it_works_by_keyboard_and_says_what_it_does(visit, sheet):
    tab = visit(sheet)
    box = tab.page.locator("sos-map").first
    assert box.locator(".sos-readout").get_attribute("aria-live") == "polite"
    assert said(box).startswith("Certified")
    box.get_by_label("Plant", exact=True).select_option(label="Arm")
    radius = box.get_by_role("spinbutton", name="Disk radius ρ")
    assert radius.get_attribute("aria-valuetext") == "15 s⁻¹"
    for _ in range(3):
        radius.press("ArrowUp")
    assert said(box).startswith("Excluded")
    assert "Disk radius ρ:" in said(box)
    label = box.locator("svg").get_attribute("aria-label")
    assert "ρ = 12 s⁻¹ is infeasible" in label
    ids = tab.page.evaluate("[...document.querySelectorAll('[id]')].map(e => e.id)")
    assert len(ids) == len(set(ids)) > 3
    assert tab.errors == []


def test_reset_a_link_python_and_bands(visit, sheet, atlas, force):
    tab = visit(sheet)
    box = tab.page.locator("sos-map").first
    design = assert_buttons(tab, visit, "sos-map", "Input bound uₘₐₓ")["design"]
    axes = atlas.data["groups"][0]["maps"][0]
    x, y = (axes[k]["values"] for k in "xy")
    shown = [float(box.get_by_role("spinbutton", name=label).input_value())
             for label in ("H∞ bound γ", "Input bound uₘₐₓ")]  # fmt: skip
    at = [x.index(shown[0]), y.index(shown[1])]
    assert design.request.gamma == x[at[0]]
    assert design.request.saturation.u_max in (
        y[at[1] - 1],
        y[min(at[1] + 1, len(y) - 1)],
    )
    assert design.request.saturation.x0.tolist() == force.request.saturation.x0.tolist()
    held = {
        "x": [force.status(v, y[at[1]]) == "feasible" for v in x],
        "y": [force.status(x[at[0]], v) == "feasible" for v in y],
    }
    for key, states in held.items():
        bands, last = green(tab, "sos-map", key), len(states) - 1
        for k, good in enumerate(states):
            assert good in [g for g, a, b in bands if a <= k / last <= b]
    box.get_by_label("Plant", exact=True).select_option(label="Arm")
    box.get_by_role("button", name="Link to this").click()
    again = visit(tab.page.url).page.locator("sos-map").first
    assert again.get_by_label("Plant", exact=True).input_value() == "1"
    box.get_by_role("button", name="As Python").click()
    names = {}
    exec(box.locator("pre").inner_text(), names)
    assert len(names["design"].request.vertices) == 2
    assert tab.errors == []


# -------------------------------------------------- beside designs alone
def test_designs_with_a_law_are_those_of_design_pid():
    cart = sos.SecondOrderSystem(1, 0.1, 2, 1)
    law, region = sos.PIDLaw([[1]], filter=0.05), sos.PoleRegion(sigma=0.2)
    asked = [
        dict(region=region),
        dict(region=region, law=law, search=sos.Search(starts=1)),
        dict(region=region, law=sos.FullState([[1]])),
        dict(region=region, U=[[1]]),
        dict(region=region, law=law, search=sos.Search(starts=1)),
    ]
    found = maps.designs(cart, asked, progress=False)
    assert [d.status for d in found] == ["feasible"] * 5
    assert [d.K.shape for d in found] == [(1, 2), (1, 2), (1, 3), (1, 3), (1, 2)]
    alone = sos.design_pid(cart, law=law, region=region, search=sos.Search(starts=1))
    for place in (1, 4):
        assert (found[place].K == alone.K).all()
        assert found[place].request.coupling.word == "multipliers"


def test_a_gain_that_is_searched_has_an_edge():
    """From an encoder s^2 + .1 s + 2 gets left of any line that a disk allows."""
    cart = sos.SecondOrderSystem(1, 0.1, 2, 1)
    asked = dict(law=sos.PIDLaw([[1]], filter=0.05), search=sos.Search(starts=1))
    region = sos.PoleRegion(sigma=0.3)
    edge = maps.edge("sigma", cart, region=region, digits=1, time_limit=20, **asked)
    assert edge.feasible >= 0.3 and edge.design.certify().proven
    assert edge.design.request.law.searched
    assert edge.design.poles().real.max() < -edge.feasible


def test_with_either_coupling_an_edge_has_the_better_one(monkeypatch):
    """Below the edge no slack scalar has a design, and the gate tries two."""
    monkeypatch.setattr(slack, "STEPS", slack.STEPS[: examples(2, 9)])
    plants = actuated()
    one, edge = (
        maps.edge("rho", plants, coupling=coupling, digits=1, time_limit=60)
        for coupling in ("pairs", "auto")
    )
    assert one.proven and edge.feasible < one.infeasible
    assert edge.design.V is not None and edge.design.certify().proven
    if edge.excluded is not None:
        assert edge.infeasible < edge.feasible
        with pytest.raises(ValueError, match="shares are those of LMIs of the whole"):
            _ = edge.shares


# ------------------------------------------------------------ many designs
@pytest.fixture(scope="module")
def specifications(robot):
    return [
        robot.requirements | dict(gamma=sos.HInfinity(g, mu=1.0))
        for g in (1.0, 1.05, 0.2, 1.15)
    ]


def same(one, two):
    return one.status == two.status and (
        one.K is None
        or np.allclose(one.K, two.K, rtol=1e-9, atol=1e-9 * np.abs(one.K).max())
    )


def test_designs_are_those_of_each_specification_alone(robot, specifications):
    found = maps.designs(robot.plant, specifications, progress=False)
    assert [d.gamma for d in found] == [a["gamma"].gamma for a in specifications]
    for design, asked in zip(found, specifications):
        assert same(design, sos.design_pid(robot.plant, **asked))
    assert [d.status for d in found].count("infeasible") == 1
    assert maps.designs(robot.plant, []) == []


@pytest.mark.campaign  # chapter 28 and test_sweep have workers
@pytest.mark.slow
def test_runs_workers_and_order_change_nothing(robot, specifications, monkeypatch):
    one = maps.designs(robot.plant, specifications, progress=False)
    back = maps.designs(robot.plant, specifications[::-1], progress=False)
    monkeypatch.setattr(maps.series, "DESIGNS_PER_PROCESS", 2)
    two = maps.designs(robot.plant, specifications, n_jobs=2, progress=False)
    assert all(map(same, one, two)) and all(map(same, one, back[::-1]))


def test_designs_with_other_integrators_do_not_start_from_each_other(robot):
    pd = robot.requirements | dict(
        U=None, saturation=sos.Saturation(150, robot.saturation.x0[:4])
    )
    found = maps.designs(robot.plant, [robot.requirements, pd, robot.requirements])
    assert [d.K.shape for d in found] == [(2, 6), (2, 4), (2, 6)]
    assert same(found[1], sos.design_pid(robot.plant, **pd))


@pytest.mark.parametrize(
    "bad, fault", [(dict(gamma=-1), "gamma"), ([1], "specification 1 must be a dict")]
)
def test_a_bad_specification_is_named(robot, bad, fault):
    if isinstance(bad, dict):
        bad = robot.requirements | bad
    with pytest.raises(ValueError, match=fault) as caught:
        maps.designs(robot.plant, [robot.requirements, bad], progress=False)
    if isinstance(bad, dict):
        assert any("specification" in n for n in caught.value.__notes__)


@pytest.mark.campaign  # chapter 28 proves these edges
@pytest.mark.slow
def test_the_two_sides_of_an_edge_are_neighbours():
    """The last design is proven in its own coordinates, if not in others."""
    chain = thesis.example_3()
    found = maps.edge("u_max", chain.plant, **chain.requirements)
    assert found.proven
    assert found.feasible - found.infeasible == pytest.approx(0.1)
