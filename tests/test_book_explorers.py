"""Every explorer that the book shows, against the package at its sliders' places."""

import json
import re

import numpy as np
import pytest

import sosbook as sos
from sosbook.book.notebooks import BOOK
from tests.test_page_elements import stored

pytestmark = pytest.mark.skipif(
    not BOOK.exists(), reason="the package without its book"
)
EXPLORERS = {
    chapter: json.loads(
        re.search(r'<script type="application/json">(.*?)</script>', text)[1]
    )
    for chapter, text in stored()
    if text.startswith("<sos-explorer")
}


def places(data, count):
    """Where the sliders stand at first, and random places around."""
    rng = np.random.default_rng(len(data["title"]))
    yield {s["key"]: s["value"] for s in data["sliders"]}
    for _ in range(count):
        yield {
            s["key"]: float(f"{s['min'] * (s['max'] / s['min']) ** rng.uniform():.3g}")
            for s in data["sliders"]
        }


def asked_at(data, shown):
    """What is asked where the sliders stand; angles are shown in degrees."""
    degrees = {s["key"] for s in data["sliders"] if s["degrees"]}
    return data["fixed"] | {
        key: np.radians(x) if key in degrees else x for key, x in shown.items()
    }


def theirs(data, asked):
    """The package's design."""
    request = data["request"]
    plants = [sos.SecondOrderSystem(**v) for v in request["vertices"]]
    region = {k: asked[k] for k in ("sigma", "theta", "rho") if k in asked}
    bound, weights = asked.get("u_max"), data.get("cost")
    return sos.design_pid(
        plants[0] if len(plants) == 1 else sos.Polytope(plants),
        request["U"] or None,
        region=sos.PoleRegion(**region) if region else None,
        gamma=asked.get("gamma"),
        saturation=None if bound is None else sos.Saturation(bound, data["x0"]),
        cost=weights and sos.QuadraticCost(**weights, bound=asked["cost"]),
        K_A=request["K_A"],
        coupling=request["coupling"],
        mu=data["mu"],
    )


def test_the_chapters_with_a_design_have_an_explorer():
    numbers = {chapter[:2] for chapter in EXPLORERS}
    assert numbers >= {"04", "05", "06", "07", "10", "11", "12", "13", "14", "23"}


@pytest.mark.slow
@pytest.mark.parametrize("chapter", EXPLORERS)
def test_an_explorer_s_designs_are_the_package_s(kernel, chapter):
    data, verdicts = EXPLORERS[chapter], []
    for shown in places(data, 4):
        asked = asked_at(data, shown)
        extra = {"x0": data["x0"]} if "u_max" in asked else {}
        extra |= {} if data["mu"] is None else {"mu": data["mu"]}
        extra |= data.get("cost") or {}
        request = data["request"] | {"asked": asked | extra}
        mine = kernel.evaluate(
            """request => {
          const r = (globalThis.kernel ??= sosKernel()).design(request);
          return {status: r.status, K: r.K, lid: r.lid}; }""",
            request,
        )
        design = theirs(data, asked)
        verdicts.append((mine["status"], design.status))
        if verdicts[-1] == ("feasible", "feasible") and not mine["lid"]:
            apart = np.abs(np.array(mine["K"]) - design.K).max()
            assert apart < 1e-6 * np.abs(design.K).max(), shown
    assert verdicts[0] == ("feasible", "feasible")
    assert all(m in (t, "undecided") for m, t in verdicts), verdicts
    assert sum(m != t for m, t in verdicts) <= 1, verdicts
