"""1000 specifications of Example 1 over (sigma, theta), and 1000 designs.

`staircase` uses that feasibility is monotone: whoever asks for more finds
no more designs. A design that was found serves every cell whose blocks it
keeps, harder ones included, so that few cells need a solver.
"""

import time

import numpy as np
from joblib.externals.loky import get_reusable_executor

import sosbook as sos
from sosbook.frame import Frame
from sosbook.lmi.centre import Blocks, margin, phase_one
from sosbook.maps import sweep
from sosbook.maps.search import replaced, requirements
from sosbook.request import Request

from .cones import Task
from .measure import SMALLEST, record
from .peers import PEERS, NoAnswer, unpacked

__all__ = ["grid", "one_by_one", "records", "staircase"]


def grid(rows=25, columns=40):
    """Requests of Example 1, harder downwards (theta) and right (sigma)."""
    given = sos.thesis.example_1()
    request = Request(given.plant, **given.requirements)
    asked = requirements(request)
    angles = np.radians(np.linspace(70, 22, rows))
    rates = np.linspace(0.3, 1.5, columns)
    return [
        [replaced(request, asked | dict(sigma=s, theta=a)) for s in rates]
        for a in angles
    ]


def point(request):
    """(P, Y) in the plant's own coordinates, or None; and the verdict."""
    task = Task(request, Frame.of(request))
    expressions, unknowns = task.expressions()
    phase = phase_one(Blocks.of(expressions, unknowns))
    if phase.x is None:
        return None, phase.verdict
    return task.home(*unpacked(unknowns, phase.x)), phase.verdict


def keeps(request, P, Y):
    """Whether all blocks are positive definite at (P, Y)."""
    gamma2 = request.gamma and request.gamma**2
    return all(
        margin(g) > SMALLEST for g in request.blocks(P, Y, gamma2).values())


def staircase(requests):
    """Verdicts of a grid that grows harder downwards and to the right.

    The walk starts at the right end of the first row. A feasible cell
    decides all before it, so the walk goes down; an infeasible one decides
    all below it, so the walk goes left.

    Parameters
    ----------
    requests : list of lists of Request

    Returns
    -------
    map : (rows, columns) array of bool
    solves : int
        How many cells needed the solver.
    """
    rows, columns = len(requests), len(requests[0])
    found = np.zeros((rows, columns), bool)
    row, column, solves, known = 0, columns - 1, 0, []
    while row < rows and column >= 0:
        request = requests[row][column]
        feasible = any(keeps(request, P, Y) for P, Y in known[-1:])
        if not feasible:
            answer, _ = point(request)
            solves += 1
            if answer is not None:
                known.append(answer)
                feasible = keeps(request, *answer)
        if feasible:
            found[row, :column + 1] = True
            row += 1
        else:
            column -= 1
    return found, solves


def one_by_one(requests):
    """The same map, one solve for each cell."""
    return np.array([
        [(p := point(r)[0]) is not None and keeps(r, *p) for r in line]
        for line in requests
    ])


def naive(request):
    """cvxpy and Clarabel, built anew; judged by the eigenvalues."""
    task = Task(request)
    peer = PEERS["cvxpy + clarabel"]()
    try:
        answer = peer.solve(peer.prepare(task))
    except NoAnswer:
        return False
    return bool(task.judge(*answer)["margin"] > SMALLEST)


def design(request):
    """A full design; module level, for the worker processes."""
    found = sos.design_pid(
        request.plant, request.U, request.region, request.gamma,
        request.saturation)
    return found.status == "feasible"


def records(quick=False, seed=0):
    """The records of the map and of the designs on two cores."""
    requests = grid(*((10, 16) if quick else (25, 40)))
    flat = [r for line in requests for r in line]
    total = len(flat)
    chosen = np.random.default_rng(seed).choice(
        total, 20 if quick else 60, replace=False)
    point(flat[0]), naive(flat[0])  # to warm up

    def timed(function, *words):
        start = time.perf_counter()
        value = function(*words)
        return value, time.perf_counter() - start

    (stairs, solves), walk = timed(staircase, requests)
    cells, single = timed(one_by_one, requests)
    words, loop = timed(lambda: [naive(flat[k]) for k in chosen])
    truth = cells.ravel()
    common = dict(
        family="map", case="example 1 over sigma and theta", n=2, states=6,
        unknowns=33, vertices=1, clock="whole map", count=total,
        repeats=1, status="right",
        formulation="which specifications have a design")
    yield record(
        **common, competitor="sosbook, staircase", coordinates="frame",
        median_s=walk, min_s=walk, ratio=1.0, measured=total, solves=solves,
        agreement=float((stairs == cells).mean()),
        note=f"{int(stairs.sum())} of {total} cells are feasible; each design "
             "is tried on the next cell before a solve")
    yield record(
        **common, competitor="sosbook, cell by cell", coordinates="frame",
        median_s=single, min_s=single, ratio=single / walk, measured=total,
        solves=total, agreement=1.0)
    scaled = loop * total / len(chosen)
    yield record(
        **common, competitor="cvxpy + clarabel, cell by cell",
        coordinates="raw", median_s=scaled, min_s=scaled,
        ratio=scaled / walk, measured=len(chosen), solves=total,
        agreement=float((truth[chosen] == words).mean()),
        note=f"measured on {len(chosen)} random cells and scaled up; the "
             "agreement is over these")

    both = {}
    sweep(design, flat[:4], n_jobs=2, progress=False)  # starts the workers
    both["sosbook, complete designs"], ours = timed(
        lambda: sweep(design, flat, n_jobs=2, progress=False))
    part = [flat[k] for k in np.resize(chosen, 2 * len(chosen))]
    sweep(naive, part[:4], n_jobs=2, progress=False)
    words, theirs = timed(
        lambda: sweep(naive, part, n_jobs=2, progress=False))
    get_reusable_executor().shutdown()
    common |= dict(
        family="designs", clock="all designs, two cores",
        formulation="one design for each specification, sosbook.maps.sweep")
    yield record(
        **common, competitor="sosbook, complete designs",
        coordinates="frame", median_s=ours, min_s=ours, ratio=1.0,
        measured=total, solves=total,
        agreement=float(np.mean(truth == both["sosbook, complete designs"])))
    scaled = theirs * total / len(part)
    yield record(
        **common, competitor="cvxpy + clarabel, points",
        coordinates="raw", median_s=scaled, min_s=scaled,
        ratio=scaled / ours, measured=len(part), solves=total,
        agreement=float(np.mean(np.resize(truth[chosen], len(part)) == words)),
        note=f"measured on {len(part)} solves and scaled up")
