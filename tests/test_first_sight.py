"""What floats see at once is proven first, without a search: they decide nothing."""

from dataclasses import replace

import numpy as np
import pytest

import sosbook as sos
from sosbook.plants import descriptors
from sosbook.synthesis import feasibility, objectives, steps
from sosbook.synthesis.request import Request
from sosbook.synthesis.responses import hears_response
from tests.cases import campaign, later

UNITS = [(0.3, 9.81, 1e4), *campaign([(1.0, 1.0, 1.0), (1e-6, 1e3, 9.81)])]
CALM = dict(region=sos.PoleRegion(sigma=1))


def carts(length=1.0, time=1.0, force=1.0, second=0.3, push=((0.0,), (1.0,))):
    """Two carts on springs, the first hardly damped; a wind blows on it."""
    mass = force * time**2 / length
    M, D, S = np.diag([1, second]), np.diag([0.02, 0.1]), [[9.81, 0.0], [-2.0, 4.0]]
    return sos.SecondOrderSystem(
        mass * M,
        mass / time * D,
        mass / time**2 * np.array(S),
        force * np.array(push),
        force * np.array([[1.0], [0]]),
    )


def of_first_order(*scale):
    (d,) = descriptors(carts(*scale))
    return sos.DescriptorSystem(d.E, d.A, d.Bu)


def of_ticks(*scale):
    """The same at ticks, exactly: a mode that isn't moved stays one."""
    flow = np.array([[0.9, 0.3, 0], [0, 1.02, 0], [0.1, 0.2, 0.5]]) * scale[0]
    return sos.DescriptorSystem(np.eye(3) * scale[0], flow, [[1], [0], [1]], dt=0.1)


def families(*scale):
    both = [carts(*scale, push=push) for push in (((0.0,), (1.0,)), ((1.0,), (1.0,)))]
    return sos.Polytope(both[::-1])


def ranges(length, time, force):
    def plant(m):
        return carts(length, time, force, second=m)

    return sos.Uncertain(plant, m=(0.3, 0.5))


def turned(*scale):
    """Masses of two signs, as by a wrong sign in a file."""
    masses = [carts(*scale, second=m, push=np.eye(2)) for m in (0.3, -0.2)]
    return sos.Polytope(masses)


def in_units(plant, more=None):
    def asked(*scale):
        calm = dict(region=sos.PoleRegion(sigma=1 / scale[1]))
        return plant(*scale), calm if more is None else more(*scale)

    return asked


def loud(length, *_):
    """Less than a tenth of what the wind's cart keeps."""
    return dict(gamma=0.3 * length)


ASKED = {
    "a mode": (in_units(carts), "No gain moves the mode"),
    "a mode of first order": (in_units(of_first_order), "No gain moves the mode"),
    "a mode at ticks": (
        in_units(of_ticks, lambda *_: {}),
        "No gain moves the mode at z = 1.02",
    ),
    "a mode of a vertex": (in_units(families), "No gain moves the mode of vertex 2"),
    "a mode of a family": (in_units(ranges), "No gain moves the mode"),
    "a response": (in_units(carts, loud), "no input reaches that response"),
    "a goal": (
        in_units(
            carts, lambda _, t, __: dict(minimize="gamma", region=sos.PoleRegion(1 / t))
        ),
        "No gain moves the mode",
    ),
    "a mass": (in_units(turned), "singular mass matrix"),
}


@pytest.mark.parametrize("scale", UNITS)
@pytest.mark.parametrize("name", ASKED)
def test_it_needs_no_search(name, scale, monkeypatch):
    """A search came first, and took 10 to 60 times as long as the proof."""

    def searched(*_, **__):
        raise AssertionError("a search comes first")

    for module in (feasibility, objectives):
        monkeypatch.setattr(module, "search", searched)
    make, words = ASKED[name]
    plant, asked = make(*scale)
    design = sos.design_pid(plant, **asked)
    assert design.status == "infeasible" and design.infeasibility.verify()
    assert words in design.reason


LATER = tuple(x for x in feasibility.STEPS if x not in steps.AT_FIRST_SIGHT)


def test_what_floats_see_in_vain_changes_no_answer(monkeypatch):
    plant = sos.Polytope([carts(push=np.eye(2), second=m) for m in (0.3, 0.4)])
    design = sos.design_pid(plant, gamma=30, **CALM)
    tried = []

    def applies(case):
        tried.append(case)
        return case.first is None

    early = (replace(step, applies=applies) for step in steps.AT_FIRST_SIGHT)
    monkeypatch.setattr(feasibility, "STEPS", (*early, *LATER))
    monkeypatch.setattr(steps, "seen_modes", lambda request: [(0, 0), (1, 1)])
    again = sos.design_pid(plant, gamma=30, **CALM)
    assert again.status == design.status == "feasible" and len(tried) >= 3
    assert np.array_equal(again.K, design.K)


@pytest.mark.parametrize("name", ["a mode", "a response", *campaign(["a mass"])])
def test_what_floats_overlook_is_found_after_the_search(name, monkeypatch):
    monkeypatch.setattr(feasibility, "STEPS", LATER)
    make, words = ASKED[name]
    plant, asked = make(1.0, 1.0, 1.0)
    design = sos.design_pid(plant, **asked)
    assert design.status == "infeasible" and words in design.reason


@pytest.mark.parametrize("scale", UNITS)
@pytest.mark.parametrize(
    "make, more",
    [
        (carts, {}),
        (families, dict(alpha=0.4)),
        *later((ranges, {}), (of_first_order, dict(alpha=0.4))),
    ],
)
def test_a_late_input_moves_it_no_more(make, more, scale):
    """It was "undecided", and other alphas were said not to be excluded."""
    t, plant = scale[1], make(*scale)
    more = {name: t * x for name, x in more.items()}
    late = dict(tau=0.1 * t, mu=0.05 * t, delta=0.5 / t)
    design = sos.design_delay_pid(plant, **late, **more)
    assert design.status == "infeasible" and design.infeasibility.verify()
    assert design.reason.startswith("No gain moves the mode")
    K = np.ones((1, 4))
    known = sos.analyse_delay(plant, K, **late)
    assert known.status == "infeasible" and known.infeasibility.verify()


def test_a_mode_that_is_fast_enough_forbids_nothing_behind_a_delay():
    design = sos.design_delay_pid(carts(), tau=0.1, delta=0.005)
    assert design.status == "feasible" and design.certify().proven
    edge = sos.delay.largest("delta", carts(), tau=0.1, delta=0.005, alpha=0.4)
    assert edge.value < 0.01 <= edge.beyond and edge.proven


@pytest.mark.parametrize("size", [1e90, 1e-90])
def test_numbers_that_floats_hardly_hold_are_no_error(size):
    late = carts(force=size)
    assert steps.seen_modes(Request(late, requirements=[CALM["region"].parts[0]]))
    assert hears_response(Request(late, gamma=0.3))
    thin = sos.DescriptorSystem(
        np.diag([1.0, size]), -np.eye(2), np.eye(2, 1), np.eye(2), np.eye(2)
    )
    asked = Request(thin, gamma=0.3)
    assert hears_response(asked) and steps.seen_modes(asked) == []


def test_what_floats_cannot_solve_is_left_to_the_search(monkeypatch):
    def unsolved(*_):
        raise np.linalg.LinAlgError("Singular matrix")

    asked = Request(carts(), gamma=0.3)
    assert hears_response(asked)
    monkeypatch.setattr(np.linalg, "solve", unsolved)
    assert not hears_response(asked) and steps.seen_modes(asked) == []
