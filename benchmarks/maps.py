"""1000 specifications of Example 1 over (sigma, theta), and 1000 designs."""

import time
from unittest.mock import patch

import numpy as np
from joblib.externals.loky import get_reusable_executor

from sosbook.book import thesis
from sosbook.lmi.problem import LMIProblem
from sosbook.requirements.hinf import HInfinity
from sosbook.studies.maps import designs, frontier, sweep
from sosbook.studies.maps.search import requirements
from sosbook.synthesis.request import Request

from .competitors import Cvxpy
from .questions import NoAnswer, Pid, right
from .records import record


def grid(rows=25, columns=40):
    """Requests of Example 1, harder downwards (theta) and right (sigma)."""
    given = thesis.example_1()
    request = Request(given.plant, **given.requirements)
    asked = requirements(request)
    angles = np.radians(np.linspace(70, 22, rows))
    rates = np.linspace(0.3, 1.5, columns)
    return [
        [request.with_bounds(asked | dict(sigma=s, theta=a)) for s in rates]
        for a in angles
    ]


def keywords(r):
    """What a request asks, as `design_pid` takes it."""
    return dict(
        U=r.U,
        region=r.region,
        gamma=HInfinity(r.gamma, mu=r.mu),
        saturation=r.saturation,
    )


def point(request):
    """P, Y and so on in the plant's own coordinates, or None."""
    lmis = Pid.of(request, framed=True).lmis
    values = lmis.find(refuse=False, start=lmis.guess()).values
    return None if values is None else lmis.in_plant_units(values)


def keeps(request, answer):
    """Whether all blocks are positive definite at an answer."""
    return right(Pid.of(request).judge(answer))


def staircase(requests):
    """Whether each cell is feasible, by `maps.frontier`, and its solves."""
    easy, find = requests[0][0], LMIProblem.find
    places = [[requirements(r) for r in row] for row in requests]
    with patch.object(LMIProblem, "find", autospec=True, side_effect=find) as finds:
        found = frontier(
            "theta",
            "sigma",
            easy.plant,
            easy.U,
            easy.region,
            HInfinity(easy.gamma, mu=easy.mu),
            easy.saturation,
            values=[row[0]["theta"] for row in places],
            digits=3,
            progress=False,
        )
    cells = [
        [found.status(at["theta"], at["sigma"]) == "feasible" for at in row]
        for row in places
    ]
    return np.array(cells), finds.call_count


def one_by_one(requests):
    """The same map, one solve for each cell."""
    return np.array(
        [
            [(p := point(r)) is not None and keeps(r, p) for r in line]
            for line in requests
        ]
    )


def naive(request):
    """cvxpy and Clarabel, built anew; judged by the eigenvalues."""
    try:
        question, answer = Cvxpy().answer(lambda: Pid.of(request))
    except NoAnswer:
        return False
    return right(question.judge(answer))


def records(quick=False, seed=0):
    """The records of the map and of the designs on two cores."""
    requests = grid(*((10, 16) if quick else (25, 40)))
    flat = [r for line in requests for r in line]
    total = len(flat)
    chosen = np.random.default_rng(seed).choice(
        total, 20 if quick else 100, replace=False
    )
    point(flat[0]), naive(flat[0])  # to warm up

    def timed(function, *words):
        start = time.perf_counter()
        value = function(*words)
        return value, time.perf_counter() - start

    (stairs, solves), walk = timed(staircase, requests)
    cells, single = timed(one_by_one, requests)
    words, loop = timed(lambda: [naive(flat[k]) for k in chosen])
    truth, scale = cells.ravel(), total / len(chosen)
    apart = f"measured on {len(chosen)} random cells and scaled up; "
    common = dict(
        family="map",
        case="example 1 over sigma and theta",
        n=2,
        vertices=1,
        clock="whole map",
        count=total,
        repeats=1,
        status="right",
    )

    def told(who, seconds, agree, note=None, measured=total, solves=total):
        """A record of ``who`` took so many seconds, and which verdicts agree."""
        return record(
            **common,
            competitor=who,
            median_s=seconds,
            min_s=seconds,
            measured=measured,
            solves=solves,
            agreement=float(np.mean(agree)),
            note=note,
        )

    note = f"{int(stairs.sum())} of {total} cells are feasible; each edge has both "
    note += "its proofs"
    yield told("sosbook, staircase", walk, stairs == cells, note, solves=solves)
    yield told("sosbook, cell by cell", single, True)
    yield told(
        "cvxpy + clarabel, cell by cell",
        loop * scale,
        truth[chosen] == words,
        apart + "the agreement is over these",
        len(chosen),
    )

    words_of, plant = [keywords(r) for r in flat], flat[0].plant
    designs(plant, words_of[:50], n_jobs=2, progress=False)  # starts workers
    found, ours = timed(lambda: designs(plant, words_of, n_jobs=2, progress=False))
    words, theirs = timed(
        lambda: sweep(naive, [flat[k] for k in chosen], n_jobs=2, progress=False)
    )
    get_reusable_executor().shutdown()
    common |= dict(family="designs", clock="all designs, two cores")
    found = np.array([d.status == "feasible" for d in found])
    note = "sosbook.studies.maps.designs: each one starts from the last"
    yield told("sosbook, complete designs", ours, truth == found, note)
    yield told(
        "cvxpy + clarabel, points",
        theirs * scale,
        truth[chosen] == words,
        apart + "any feasible point will do",
        len(chosen),
    )
