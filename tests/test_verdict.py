"""The word at a sentence's end is that of its weakest clause."""

import json
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import expm

import sosbook
from tests.processes import process

BOOK = Path(sosbook.__file__).parent / "book"
RUN = """
import "data:text/javascript,globalThis.HTMLElement = class {}";
import {design} from "%(kernel)s/design.js";
import {descriptors} from "%(kernel)s/descriptor.js";
import {prove} from "%(kernel)s/proof.js";
import {truth} from "%(kernel)s/truth.js";
import {rowsOf} from "%(kernel)s/matrices.js";
import {add, eigenvalues, mul, solve} from "%(assets)s/linalg.js";
import {clauses, radius, verdict} from "%(assets)s/verdict.js";
const text = await new Response(Deno.stdin.readable).text();
const {request, clock, slow} = JSON.parse(text);
const found = design(request);
const known = K => {
  const poles = descriptors(request).map(({E, A, Bu}) => eigenvalues(
    solve(rowsOf(E), add(rowsOf(A), mul(rowsOf(Bu), K)))));
  const stable = poles.flat().every(([re]) => re < -1e-9), none = Infinity;
  const wild = {norm: none, peak: none, cost: none};
  return {K, poles, ...(stable ? truth(request, {K, poles}) : wild)};
};
const word = (K, clock = null) => {
  const list = clauses(request, clock, known(K));
  let proven = false;
  try { proven = prove(request, {...found, K}).proven; } catch { }
  const {word, why} = verdict("feasible", list, proven);
  const broken = list.filter(x => x.holds === false).map(x => x.key);
  return {word, why, proven, broken};
};
const size = [-30, -1, 0, .3, .97, 1.03, 1.5, 10];
const spoiled = size.flatMap(s => found.K[0].map((_, j) =>
  [s, j, word(found.K.map(row => row.map((x, k) => k === j ? s * x : x)))]));
console.log(JSON.stringify({
  K: found.K, good: word(found.K), timed: word(found.K, clock),
  late: word(found.K, slow),
  seen: word(found.K, {...clock, measured: ["z1"]}),
  radius: radius(request, found.K, clock),
  slow: radius(request, found.K, slow), spoiled}));
"""
CART = {
    "M": [[1, 0], [0, 0.3]],
    "D": [[0.1, -0.1], [-0.1, 0.1]],
    "S": [[9.81, -9.81], [-9.81, 9.81]],
    "B": [[1], [0]],
    "F": [[0], [1]],
}
ASKED = {"sigma": 0.4, "theta": 1.2, "rho": 40, "gamma": 9, "u_max": 60, "mu": None,
         "x0": [-0.3, -0.3, 0, 0, 0], "cost": 4000, "Q": np.eye(5).tolist(),
         "R": [[0.1]], "noise": "F"}  # fmt: skip
CLOCK = {"T": 0.01, "delay": 0.007}
SLOW = {"T": 0.3, "delay": 0.45}


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """What the page's modules say of gains, good and spoiled."""
    deno = shutil.which("deno", path=Path(sys.executable).parent)
    if deno is None:
        pytest.skip("deno isn't installed: pip install deno")
    script = tmp_path_factory.mktemp("verdict") / "run.mjs"
    where = {x: (BOOK / x).as_uri() for x in ("kernel", "elements/assets")}
    where["assets"] = where.pop("elements/assets")
    script.write_text(RUN % where, "utf-8")
    request = {"vertices": [CART], "U": [[0, 1]], "K_A": None, "coupling": "pairs"}
    asked = {k: x for k, x in ASKED.items() if x is not None}
    given = {"request": request | {"asked": asked}, "clock": CLOCK, "slow": SLOW}
    done = process(deno, "run", "--no-lock", "-A", script, input=json.dumps(given))
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_no_word_without_its_clauses(found):
    """A gain that breaks any of them is neither proven nor feasible."""
    assert found["good"] == {"word": "proven", "why": [], "proven": True, "broken": []}
    seen = set()
    for _, _, one in found["spoiled"]:
        seen |= {*one["broken"]}
        if one["broken"]:
            assert not one["proven"] and one["word"] == "undecided" and one["why"]
        else:
            assert one["word"] == ("proven" if one["proven"] else "feasible")
    assert seen == {"sigma", "theta", "rho", "gamma", "u_max", "cost"}


def test_a_clock_is_checked_and_never_proven(found):
    """By a loop of one's own: the program runs tick by tick."""
    assert found["timed"]["word"] == "part proven"
    assert "inside of the unit circle" in found["timed"]["why"][0]
    assert (
        found["late"]["word"] == "undecided" and "Too slow" in found["late"]["why"][0]
    )
    assert found["seen"]["word"] == "part proven"
    assert "observer from z1 isn't judged" in found["seen"]["why"][0]
    for name, clock in (("radius", CLOCK), ("slow", SLOW)):
        loop = np.linalg.eigvals(ticks(np.array(found["K"]), **clock))
        assert found[name] == pytest.approx(abs(loop).max(), rel=1e-6)


def ticks(K, T, delay):
    """The map of a tick of the program: plant's state, sum, and inputs on their way."""
    M, D, S, B = (np.array(CART[x], float) for x in "MDSB")
    A = np.block([[np.zeros((2, 2)), np.eye(2)],
                  [-np.linalg.solve(M, S), -np.linalg.solve(M, D)]])  # fmt: skip
    push = np.r_[np.zeros(2), np.linalg.solve(M, B).ravel()]
    count = int(delay // T) + 1  # inputs that are still to come or at work

    def run(x, u, dt):
        E = expm(np.block([[A, push[:, None]], [np.zeros((1, 5))]]) * dt)
        return E[:4, :4] @ x + E[:4, 4] * u

    def tick(state):
        x, total, late = state[:4], state[4], list(state[5:])
        queue = [float(K[0] @ np.r_[x, total]), *late]  # the newest first
        rest = delay - T * (delay // T)
        x = run(x, queue[count], rest)
        x = run(x, queue[count - 1], T - rest)
        return np.r_[x, total + T * state[1], queue[:count]]

    return np.column_stack([tick(e) for e in np.eye(5 + count)])
