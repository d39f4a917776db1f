"""Why there is no design, in words: each sentence is rendered here at least once."""

import inspect
import re
from pathlib import Path

import numpy as np
import pytest

import sosbook as sos
from sosbook.exact.refusal import Refusal
from sosbook.runtime.time_limit import OutOfTime
from sosbook.solver.loop import Unbounded
from sosbook.synthesis import (
    feasibility,
    objectives,
    reasons,
    regularization,
    slack,
    steps,
)

ONE = [[1.0]]


def mass(M=ONE, D=ONE, S=ONE, B=ONE):
    return sos.SecondOrderSystem(M, D, S, B)


def two(*masses):
    return sos.Polytope([mass(M=[[m]]) for m in masses])


def broken(name, error):
    """The request where a part of `sosbook.synthesis.feasibility` fails."""

    def make(monkeypatch):
        def fail(*_, **__):
            raise error

        monkeypatch.setattr(feasibility, name, fail)
        return sos.design_pid(mass(), region=sos.PoleRegion(sigma=1, rho=9))

    return make


def least_input(plant, x0=(1, 0), **asked):
    limit = sos.Saturation(None, x0)
    return sos.design_pid(plant, **asked, saturation=limit, minimize="u_max")


def late_optimum(monkeypatch):
    def fail(*_, **__):
        raise OutOfTime

    monkeypatch.setattr(objectives, "_least", fail)
    return least_input(mass(S=[[-1.0]]), region=sos.PoleRegion(rho=9))


def no_optimum(monkeypatch):
    def fail(blocks, unknowns, cost, x, gap):
        raise Unbounded("lost", x)

    monkeypatch.setattr(objectives, "any_minimum", fail)
    return least_input(mass(S=[[-1.0]]))


def no_multipliers(monkeypatch):
    """Nothing is proven: what remains is what was seen in floats."""
    monkeypatch.setattr(reasons, "_proven_reach", lambda first: 0.0)
    return nearly_out_of_reach(monkeypatch)


def nearly_out_of_reach(_):
    plant = sos.SecondOrderSystem(
        np.eye(2), 0.01 * np.eye(2), np.diag([1, 1 + 2**-52]), [[1], [1]]
    )
    return sos.design_pid(plant, region=sos.PoleRegion(sigma=1))


REASONS = {  # three more, which take seconds, are read in tests/test_least_bounds
    "No gain moves the mode": lambda _: sos.design_pid(
        sos.SecondOrderSystem(np.eye(2), np.diag([1, -1]), np.eye(2), [[1], [0]])
    ),
    "of vertex 2": lambda _: sos.design_pid(
        sos.Polytope([mass(), mass(D=[[-1.0]], B=[[0.0]])])
    ),
    "This gain leaves a pole": lambda _: sos.analyse_pid(mass(), [[9, 0]]),
    "Between the vertices 1 and 2 a plant has a singular": lambda _: sos.design_pid(
        two(1.0, -1.0)
    ),
    "Exact multipliers of the LMIs exclude every solution": lambda _: sos.design_pid(
        mass(D=[[0.0]], S=[[0.0]]),
        region=sos.PoleRegion(sigma=3),
        saturation=sos.Saturation(1, [1, 0]),
    ),
    "is too small to move the modes at 1 rad/s": lambda _: sos.design_pid(
        mass(D=[[0.0]], S=[[-1.0]]), saturation=sos.Saturation(0.9, [1, 0])
    ),
    "for every slack scalar": lambda _: sos.design_pid(
        two(1.0, 2.0),
        region=sos.PoleRegion(sigma=5),
        saturation=sos.Saturation(0.1, [1, 0]),
        coupling="slack",
    ),
    "by multipliers in floating point|exclude all|neither": nearly_out_of_reach,
    "by multipliers in floating point|found neither": no_multipliers,
    "Stopped after 1e-06 s": lambda _: sos.design_pid(
        mass(), search=sos.Search(time_limit=1e-6)
    ),
    "The request is too large: by far": broken("search", MemoryError("by far")),
    "The numerics gave up": broken("search", FloatingPointError("lost")),
    "Stopped on the way to the centre": broken("finish", OutOfTime()),
    "Stopped before the least u_max was found": late_optimum,
    "can't is proven for these LMIs": no_optimum,
    "K = 0 keeps everything that is asked": lambda _: least_input(mass()),
    "^The least u_max is zero, any": lambda _: sos.analyse_pid(
        mass(), [[0, 0]], saturation=sos.Saturation(None, [1, 0]), minimize="u_max"
    ),
}


@pytest.mark.parametrize("words", REASONS)
def test_each_reason_is_given_where_it_holds(words, monkeypatch):
    design = REASONS[words](monkeypatch)
    assert re.search(words, design.reason), design.reason
    assert design.reason.endswith((".", "?")) and "  " not in design.reason
    if design.status == "infeasible":
        assert design.infeasibility.proven


def test_words_that_no_request_gives_are_known():
    """Each f-string of a reason belongs to a request above or to the list below."""
    rare = {  # need numerics that fail in a way of their own
        "The numerics found a point whose margin": steps,
        "Nothing was found with the slack scalars": slack,
        "No point was found from where": objectives,
        "Exact multipliers exclude all": reasons,
        "Exact multipliers of the LMIs exclude every {names}": objectives,
    }
    for words, module in rare.items():
        assert words in inspect.getsource(module)


def test_advice_on_a_mass_says_no_more_than_is_known(monkeypatch):
    """ "No common K_A" takes a proof: an undecided search says so."""
    made = regularization.Regularization
    assert made(two(1.0, 2.0), 0.1, "undecided").advice == "Ask for a smaller beta."
    never = made(two(1.0, 2.0), 0.1, "undecided")
    monkeypatch.setattr(regularization, "regularize", lambda *_: never)
    assert "nothing proves that there is no gain" in never.advice
    refused = made(two(1.0, 2.0), 0.1, "infeasible")
    assert "No common K_A serves all vertices" in refused.advice


def kinds(of):
    """The kinds of all refusals of the package below a class."""
    for one in of.__subclasses__():
        if one.kind and one.__module__.startswith("sosbook."):
            yield one.kind
        yield from kinds(one)


def test_chapter_41_has_every_reason_of_a_refusal():
    page = Path(__file__).parents[1] / "book" / "33_design_limits.ipynb"
    table = page.read_text("utf-8").split("| Its words |")[1].split(":::")[0]
    assert {k for k in kinds(Refusal) if f"`{k}`" not in table} == set()


@pytest.mark.parametrize("vertices, sigma", [(1, 0.0), (2, 0.0)])
def test_a_pole_that_breaks_what_is_asked_is_named_where_time_is_over(vertices, sigma):
    """Heavily damped and circulatory, n = 40: the exact mode takes long."""
    rng, n = np.random.default_rng(0), 40
    D, B = np.diag(np.linspace(1, 40, n)), np.eye(n)[:, :1]
    turn = np.triu(rng.normal(size=(n, n)).round(3), 1)
    plants = [
        sos.SecondOrderSystem(
            np.eye(n), D, 1e-3 * np.eye(n) + size * (turn - turn.T), B
        )
        for size in (0.003, 0.3)[2 - vertices :]
    ]
    plant = sos.Polytope(plants) if vertices > 1 else plants[0]
    asked = dict(region=sos.PoleRegion(sigma)) if sigma else {}
    known = sos.analyse_pid(
        plant,
        np.zeros((1, 2 * n)),
        coupling="pairs",
        search=sos.Search(time_limit=0.2 if vertices > 1 else 60.0),
        **asked,
    )
    truth = max(plants[-1].poles(), key=lambda s: (s.real, s.imag))
    if vertices == 1:  # of a single loop a form that grows is found soon
        assert known.status == "infeasible" and known.infeasibility.proven
        return
    assert truth.real > 0 and known.status == "undecided"
    place = f"{truth.real:.4g}±{abs(truth.imag):.4g}j rad/s breaks"
    where = " of vertex 2" if vertices > 1 else ""
    assert f"In floats a pole{where} at {place}" in known.reason
    calm = sos.SecondOrderSystem(np.eye(n), D, np.eye(n), B)
    calm = sos.analyse_pid(
        calm, np.zeros((1, 2 * n)), search=sos.Search(time_limit=1e-6)
    )
    assert calm.status == "undecided" and "pole" not in calm.reason


def test_a_reason_names_a_plant_of_ranges_by_its_parameters():
    pendulums = sos.Uncertain(
        lambda s: sos.SecondOrderSystem(0.3, 0.1, 1, s), s=(0, 9.81)
    )
    refused = sos.design_pid(pendulums, region=sos.PoleRegion(sigma=0.3))
    assert "mode of the plant with s = 0 at" in refused.reason
    several = sos.Polytope(list(pendulums.vertices))
    refused = sos.design_pid(several, region=sos.PoleRegion(sigma=0.3))
    assert "mode of vertex 1 at" in refused.reason


def test_the_disk_that_an_undecided_answer_proposes_decides():
    """An H2 norm that no gain lowers so far."""
    x = np.random.default_rng(5).standard_normal((4, 2))
    S, B, F = x[:2] @ x[:2].T, x[2][:, None], x[3][:, None]
    plant = sos.SecondOrderSystem(np.eye(2), 0.1 * np.eye(2), S, B, F=F)
    asked = [sos.H2(1e-3)]
    d = sos.design_pid(plant, requirements=asked)
    assert d.status == "undecided" and "With a disk (rho)" in d.reason
    disk = sos.PoleRegion(rho=50)
    d = sos.design_pid(plant, region=disk, requirements=asked)
    assert d.infeasibility.proven
