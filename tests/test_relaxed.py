"""Two bounds in conflict: how far one goes while the other is kept, by all gains."""

import re

import numpy as np
import pytest

import sosbook as sos
from sosbook.synthesis.structured import advice
from tests.cases import campaign

LAW = sos.PIDLaw([[1]], [[1]])
CASES = {  # M, D, S, B, F; the decay and the effort that are asked; where gains are
    "spring": ((0.3, 0.1, 9.81, 1, 1), 3.0, 0.5, (-40, 9.7), (-12, 0.05)),
    "table": ((2.2, 0.05, 31, 0.7, 3), 2.0, 3.5, (-60, 42), (-20, 0.05)),
}
SLACK = 0.05  # a back-off of 0.01, and the step between numbers that are asked for


def peak(p, r, m, damping, spring):
    """The largest |p + i w r| / |spring - m w^2 + i w damping|: at 0, or where the
    slope in x = w^2 of its square is zero, a quadratic equation.
    """
    more = r**2 * spring**2 - p**2 * (damping**2 - 2 * m * spring)
    root = np.sqrt(np.maximum((m * p**2) ** 2 + r**2 * more, 0))
    x = np.maximum((root - m * p**2) / (m * r**2 + 1e-300), 0)
    high = np.sqrt((p**2 + r**2 * x) / ((spring - m * x) ** 2 + damping**2 * x))
    return np.maximum(high, abs(p / spring))


def of_all_gains(plant, sigma, effort, P, D):
    """The largest decay of an effort, and the least effort of a decay, on grids of
    K_P and K_D, each finer around the best.
    """
    m, d, s, b, f = plant
    best = []
    for decays in True, False:
        ends = np.array([P, D], float)
        for _ in range(4):
            p, r = np.meshgrid(*(np.linspace(*e, 120) for e in ends), indexing="ij")
            damping, spring = d - b * r, s - b * p
            root = np.sqrt(damping**2 - 4 * m * spring + 0j).real
            decay = (damping - root) / (2 * m)
            u = peak(p, r, m, damping, spring) * f
            if decays:
                value = np.where(u <= effort, decay, -np.inf)
            else:
                value = np.where(decay >= sigma, -u, -np.inf)
            k = np.unravel_index(value.argmax(), value.shape)
            wide = np.diff(ends) / 10
            ends = np.array([[p[k]], [r[k]]]) + wide * [-1, 1]
        best.append(abs(value[k]))
    return best


@pytest.mark.parametrize("name", ["spring", *campaign(["table"])])
def test_how_far_each_bound_goes_is_said_and_is_no_better_than_true(name, monkeypatch):
    monkeypatch.setattr(advice, "TRIAL", 200.0)  # whatever else the machine does
    monkeypatch.setattr(advice, "with_memory", lambda request: "")  # not asked here
    matrices, sigma, effort, *where = CASES[name]
    decay, least = of_all_gains(matrices, sigma, effort, *where)
    assert 0 < decay < sigma and least > effort  # they are in conflict
    m, d, s, b, f = matrices
    plant = sos.SecondOrderSystem(m, d, s, b, f)
    bound = sos.HInfinity(effort, outputs=sos.Output(input=1), name="effort")
    asked = dict(law=LAW, requirements=[bound], search=sos.Search(starts=2))
    refused = sos.design_pid(plant, **asked, region=sos.PoleRegion(sigma=sigma))
    assert refused.status == "undecided"
    said = re.findall(
        r"With the others kept, the (\w+) [^.]*? found is (\S+) \(asked: (\S+)\)\.",
        refused.advice,
    )
    assert [(word, float(x)) for word, _, x in said] == [
        ("largest", sigma), ("least", effort)
    ]  # fmt: skip
    fast, small = (float(x) for _, x, _ in said)
    assert decay * (1 - SLACK) < fast < decay
    assert least < small < least * (1 + SLACK)
