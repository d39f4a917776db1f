"""Gains that are known, and laws that are searched, on both sides of what is true.

The loops are built here from the words of the laws and their truths are floats: poles,
a grid of frequencies, Lyapunov's equation.
"""

import json
from dataclasses import dataclass, field
from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import numpy as np
from mpmath import mp
from scipy.linalg import block_diag, eigvals, solve_continuous_are
from scipy.linalg import solve_continuous_lyapunov as gramian
from scipy.optimize import nnls

import sosbook as sos
from sosbook.exact.checker.families import given_vertices
from sosbook.exact.checker.verdict import asked_of
from sosbook.requirements.base import Requirement
from tests.hunt.truth import norm

FACTORS = (0.5, 0.9, 1.1, 2.0)  # of the true bound: it is broken, or kept
BETWEEN = 6  # plants between the vertices that a truth is taken from
SEARCH = 4  # seconds for a law
CLOSE = 1e-6  # what a truth in floats may be wrong by, of its size


@dataclass(frozen=True, eq=False)
class Ways:
    """What a controller measures and remembers; ``law`` None stands for all of x."""

    law: Any
    noise: Any = None
    filter: float | None = None
    order: int = 0
    rows: dict = field(default_factory=dict)

    def loop(self, v, K):
        """E, A and W of E x' = A x + W w under u = K times what the law has of y.

        ``v``: M, D, S, B and F; x is z, z', integrals of y and what is filtered, or the
        states of a controller.
        """
        n, m, p = len(v.M), v.B.shape[1], v.F.shape[1]
        E, W = block_diag(np.eye(n), v.M), np.vstack([np.zeros((n, p)), v.F])
        A = np.block([[np.zeros((n, n)), np.eye(n)], [-v.S, -v.D]])
        push = np.vstack([np.zeros((n, m)), v.B])
        if self.law is None:
            return E, A + push @ K, W
        none = np.zeros((0, n))
        P, V = (self.rows.get(x, none) for x in ("position", "velocity"))
        y, q, s = block_diag(P, V), len(P), len(P) + len(V)
        noise = np.zeros((s, p))
        if self.noise is not None:
            noise[:q] = self.noise
        if self.order:
            c = self.order
            E, A = block_diag(E, np.eye(c)), block_diag(A, np.zeros((c, c)))
            push, W = block_diag(push, np.eye(c)), np.vstack([W, np.zeros((c, p))])
            seen, heard = block_diag(y, np.eye(c)), np.vstack([noise, np.zeros((c, p))])
            return E, A + push @ K @ seen, W + push @ K @ heard
        a, f = q * bool(self.law.integrate), q * (self.filter is not None)
        at = np.eye(2 * n + a + f)
        y = np.hstack([y, np.zeros((s, a + f))])
        pos, lag = y[:q], at[2 * n + a :]
        signals, heard = [y], [noise]
        rate = (pos - lag) if f else lag
        if f:
            signals.append(rate / self.filter)
            heard.append(noise[:q] / self.filter)
        signals.append(at[2 * n : 2 * n + a])
        heard.append(np.zeros((a, p)))
        K_y, K_w = K @ np.vstack(signals), K @ np.vstack(heard)
        push = np.vstack([push, np.zeros((a + f, m))])
        E = block_diag(E, np.eye(a), (self.filter or 0) * np.eye(f))
        A = block_diag(A, np.zeros((a + f, a + f))) + push @ K_y
        A[2 * n : 2 * n + a] += pos[:a]
        A[2 * n + a :] += rate
        W = np.vstack([W, noise[:a], noise[:f]]) + push @ K_w
        return E, A, W


def any_law(rng, plant):
    """A law of random sensors, memory, noise and structure that its class accepts."""
    while True:
        try:
            return _law(rng, plant)
        except ValueError:  # a sensor that sees nothing, no gain that is free
            continue


def _law(rng, plant):
    n, m, p = plant.n, plant.m, plant.p

    def rows(q):
        few = np.eye(n)[rng.permutation(n)[:q]]
        return few if rng.random() < 0.6 else np.round(rng.standard_normal((q, n)), 2)

    seen = {"position": rows(int(rng.integers(1, n + 1)))}
    q, noise, more = len(seen["position"]), None, {}
    if rng.random() < 0.4:
        more["noise"] = noise = np.round(rng.standard_normal((q, p)) / 3, 2)
    if rng.random() < 0.3:
        order = int(rng.integers(1, 3))
        proper = bool(rng.random() < 0.5)
        if rng.random() < 0.5:
            more["structure"] = {"A_c": "diagonal"}
        law = sos.DynamicLaw(order, **seen, strictly_proper=proper, **more)
        return Ways(law, noise, order=order, rows=seen)
    lag = None
    if rng.random() < 0.5:
        lag = more["filter"] = round(float(10 ** rng.uniform(-2, 0)), 3)
    elif rng.random() < 0.6:
        seen["velocity"] = rows(int(rng.integers(1, n + 1)))
    if rng.random() < 0.4:
        words = [0, 1, "a", "-a", 1]
        pick = rng.integers(0, len(words), (m, q))
        pick[0, 0] = pick[0, 0] or 1  # one gain is free, or there is nothing to find
        more["structure"] = {"K_P": [[words[k] for k in row] for row in pick]}
    law = sos.PIDLaw(**seen, integrate=bool(rng.random() < 0.5), **more)
    return Ways(law, noise, filter=lag, rows=seen)


def decay(E, A, W, C):
    return -eigvals(A, E).real.max()


def energy(E, A, W, C):
    """The H2 norm from w to C x."""
    A, W = np.linalg.solve(E, A), np.linalg.solve(E, W)
    return float(np.sqrt(np.trace(C @ gramian(A, -W @ W.T) @ C.T)))


def truth(quantity, loop, plant):
    """What is true of a loop of a plant."""
    return TRUTHS[quantity][0](*loop, np.eye(len(plant.M), len(loop[0])))


TRUTHS = {  # of a loop; what asks a bound; whether more is better
    "poles": (decay, lambda x: dict(region=sos.LMIRegion.half_plane(x)), True),
    "H-infinity": (norm, lambda x: dict(gamma=x), False),
    "H2": (energy, lambda x: dict(requirements=[sos.H2(x)]), False),
}


@dataclass(frozen=True, eq=False)
class Question:
    """A gain of some ways that is asked for a bound, and what is true of it."""

    words: str
    vertices: list
    ways: Ways
    K: np.ndarray
    quantity: str
    bound: float
    kept: bool  # by all plants that were tried

    def answer(self, limit):
        """What `analyse_pid` says."""
        asked = TRUTHS[self.quantity][1](self.bound)
        if self.ways.law is not None:
            asked["law"] = self.ways.law
        plant = polytope(self.vertices)
        return sos.analyse_pid(
            plant, self.K, **asked, search=sos.Search(time_limit=limit)
        )

    def contradicts(self, design):
        """What is wrong with an answer, in words; empty if nothing is."""
        if design.status == "feasible" and not self.kept:
            return f"{self.words} is proven, and a plant breaks it"
        if design.status != "infeasible" or not design.request.coupling.free:
            return ""
        if self.kept and len(self.vertices) == 1:
            return f"{self.words} is refused, and the plant keeps it"
        file = asked_of(json.loads(design.infeasibility.text))
        if (
            not file.keys() & {"vertex", "place"}
            and len(given_vertices(file["plant"])) > 1
        ):
            return ""  # multipliers of all plants: they name none
        weights = self._named(file)
        if weights is None:
            return f"{self.words}: the plant that is named isn't of the polytope"
        true, more = self._truth(mean(self.vertices, weights)), TRUTHS[self.quantity][2]
        off = CLOSE * (1 + abs(true)) * (1 if more else 1e3)
        stable = true > 0  # of a norm it is; a decay may not be
        if stable and (true > self.bound + off if more else true < self.bound - off):
            return f"{self.words}: the plant that is named keeps it, with {true:.8g}"
        return ""

    def _truth(self, plant):
        return truth(self.quantity, self.ways.loop(plant, self.K), plant)

    def _named(self, file):
        """The weights of the vertices whose loop a refusal is about; None if none."""
        E, A, *_ = loop_in(file)
        loops = [self.ways.loop(x, self.K) for x in self.vertices]
        columns = np.array([np.r_[x[0].ravel(), x[1].ravel(), 1] for x in loops]).T
        sizes = abs(columns).max(1) + 1e-300
        wanted = np.r_[E.ravel(), A.ravel(), 1] / sizes
        weights, rest = nnls(columns / sizes[:, None], wanted)
        return weights if rest < CLOSE * len(wanted) else None


def questions(asked, rng):
    """Gains of the plants of a request, each asked on both sides of what is true."""
    vertices = asked.vertices
    for ways in (Ways(None), any_law(rng, vertices[0])):
        K = gain_of(ways, vertices, rng)
        tried = list(plants(vertices, rng))
        loops = [ways.loop(v, K) for v in tried]
        quantity = str(rng.choice(list(TRUTHS)))
        poles = min(truth("poles", x, v) for x, v in zip(loops, tried))
        if poles < CLOSE * max(abs(x[1]).max() for x in loops):
            quantity = "poles"
        worst = min if TRUTHS[quantity][2] else max
        true = worst(truth(quantity, x, v) for x, v in zip(loops, tried))
        for factor in FACTORS if abs(true) > CLOSE else ():
            bound = float(f"{true * factor:.4g}")
            kept = poles > 0 and (bound < true if TRUTHS[quantity][2] else bound > true)
            who = "K" if ways.law is None else type(ways.law).__name__
            words = f"{quantity} {bound} of a {who}, in truth {true:.6g}"
            yield Question(words, vertices, ways, K, quantity, bound, kept)


def gain_of(ways, vertices, rng):
    """A gain that may stabilise: an optimal regulator, or what a search finds."""
    first = vertices[0]
    if ways.law is None:
        E, A, _ = ways.loop(first, np.zeros((first.m, 2 * first.n)))
        B = np.linalg.solve(E, np.vstack([0 * first.B, first.B]))
        A, one = np.linalg.solve(E, A), np.eye(2 * first.n)
        X = solve_continuous_are(
            A, B, 10.0 ** rng.uniform(-2, 2) * one, np.eye(first.m)
        )
        return np.round(-B.T @ X, 3)
    d = sos.design_pid(
        polytope(vertices), law=ways.law, search=sos.Search(time_limit=SEARCH)
    )
    structure = ways.law.structure(first)
    if d.K is not None:
        return np.vectorize(lambda x: float(f"{x:.6g}"))(d.K)
    kappa = np.round(rng.standard_normal(len(structure.directions)) / 3, 2)
    return np.tensordot(kappa, structure.directions, 1)


def searched(asked, rng):
    """A law, what it is asked, the design, and what contradicts it, in words."""
    vertices = asked.vertices
    ways = any_law(rng, vertices[0])
    scale = float(np.median(np.abs(vertices[0].poles()))) + 1e-3
    sigma = float(f"{scale * 10 ** rng.uniform(-3, 0.3):.3g}")
    region = sos.PoleRegion(sigma=sigma)
    design = sos.design_pid(
        polytope(vertices),
        law=ways.law,
        region=region,
        search=sos.Search(time_limit=SEARCH),
    )
    words = f"a {type(ways.law).__name__} with a decay of {sigma}"
    if design.status == "feasible":
        K = design.certify().K
        worst = min(truth("poles", ways.loop(v, K), v) for v in plants(vertices, rng))
        if worst < sigma * (1 - CLOSE):
            return words, design, f"{words} is proven, and one has {worst:.8g}"
    if design.status == "infeasible":
        return words, design, unmoved(vertices, ways, design.infeasibility, sigma, rng)
    return words, design, ""


def unmoved(vertices, ways, proof, sigma, rng):
    """What contradicts a refusal of all gains: gains that do better, in words."""
    directions = ways.law.structure(vertices[0]).directions
    for size in 10.0 ** rng.uniform(-3, 2, 40):
        K = np.tensordot(size * rng.standard_normal(len(directions)), directions, 1)
        if all(truth("poles", ways.loop(v, K), v) > 1.001 * sigma for v in vertices):
            if all(truth("poles", ways.loop(v, K), v) > sigma
                   for v in plants(vertices, rng)):  # fmt: skip
                return f"{proof.claims[0]}, and a gain does"
    return ""


def polytope(vertices):
    """The plant, or the polytope of them."""
    return vertices[0] if len(vertices) == 1 else sos.Polytope(vertices)


def mean(vertices, weights):
    """A plant between some vertices."""
    parts = {
        x: sum(w * getattr(v, x) for w, v in zip(weights, vertices)) for x in "MDSBF"
    }
    return SimpleNamespace(**parts)


def plants(vertices, rng):
    """The vertices, and plants between them."""
    count = len(vertices)
    between = rng.dirichlet(np.ones(count), BETWEEN * (count > 1))
    return [mean(vertices, w) for w in [*np.eye(count), *between]]


def floats(rows):
    return np.array([[float(Fraction(e)) for e in row] for row in rows])


def loop_in(file):
    """E, A, W and C of the loop that a refusal of a known gain is about."""
    at = file.get("place", [file.get("vertex", 0)] * 2)
    parts = [given_vertices(file["plant"])[k] for k in at]
    v = {x: sum(floats(part[x]) for part in parts) / 2 for x in parts[0]}
    C = floats(file["plant"]["C"]) if "C" in file["plant"] else v.get("C")
    if "M" in v:
        E, A, W = Ways(None).loop(SimpleNamespace(**v), floats(file["K"]))
        return E, A, W, np.eye(len(v["M"]), len(E))
    A = v["A"] + v["B"] @ floats(file["K"]) if file["K"] else v["A"]
    return v["E"], A, v["B_w"], C


def sharp_poles(E, A):
    """The poles to 40 digits: beside large gains floats lose four of slow ones."""
    with mp.workdps(40):
        found = mp.eig(mp.matrix(E) ** -1 * mp.matrix(A), right=False)
    return np.array([complex(x) for x in found])


def true_refusal(file):
    """Whether a known gain breaks what a refusal says; None without an oracle."""
    if file["K"] is None or file["U"]:
        return None
    E, A, W, C = loop_in(file)
    poles = eigvals(A, E)
    if file["kind"] == "growing":
        asked = file["requirement"]
        region = Requirement.read(asked) if asked else sos.LMIRegion.half_plane(0.0)
        return min(x.min() for x in region.distances(poles).values()) < 1e-7
    if file["kind"] == "fixed mode":
        s, asked = (
            complex(*map(float, map(Fraction, file["point"]))),
            file["requirement"],
        )
        region = Requirement.read(asked) if asked else sos.LMIRegion.half_plane(0.0)
        (distance,) = region.distances([s]).values()
        far = 1e-4 * (abs(s) + 1e-3 * abs(poles).max())
        near = min(abs(poles - s)) < far or min(abs(sharp_poles(E, A) - s)) < far
        return bool(near and distance[0] < 1e-7)
    plain = not any(v.get("D_w") for v in given_vertices(file["plant"]))
    if not plain or "requirement" in file:
        return None
    return poles.real.max() > 0 or norm(E, A, W, C) > 0.999 * float(file["bound"])
