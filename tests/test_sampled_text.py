"""Sampled proofs as texts: integers decide them, and floats of their own check them."""

import copy
import json
import subprocess
import sys
from itertools import product
from types import SimpleNamespace

import numpy as np
import pytest

import sosbook as sos
from sosbook.exact.checker import CHECKER, kernel, sampled, verdict
from sosbook.exact.checker.arithmetic import Beyond, Refused, read
from sosbook.exact.checker.language import Reader, parse
from sosbook.sampled import SampledProof, certify_sampled, sampled_loop
from sosbook.sampled.system import SampledSystem
from tests.cases import campaign

SECOND = sos.SecondOrderSystem


def two_masses(m=1.0, k=3.0, g=1.0):
    """Two bodies and a spring between them, the first one driven."""
    return SECOND([[1, 0], [0, m]], [[0.4, -0.1], [-0.1, 0.3]], [[k + 1, -k], [-k, k]],
                  [[g], [0]], [[0], [1]])  # fmt: skip


def masses(*pairs):
    return sos.Polytope([SECOND([[m]], [[d]], [[0.2]], [[1]]) for m, d in pairs])


def driven(m):
    return SECOND([[m]], [[0.4]], [[1]], [[1]], [[1, 0]])


PLAIN = [[0.1]], [[0.1, 0]], [[0.2]], [[-0.3, -0.5]], 0.1
LAW, NOISY = SampledSystem(*PLAIN), SampledSystem(*PLAIN, [[0, 0.1]], [[0, -0.3]])
WEAK, CART = [[-0.3, 0.1, -0.5, -0.1]], [[-1, -1.5]]
SPRING, SOFT = SECOND([[1]], [[0.2]], [[4]], [[1]]), [[-0.5, -0.8]]
RANGES = sos.Uncertain(two_masses, m=(0.8, 1.2), k=(2.5, 3.5))
PRODUCTS = sos.Uncertain(
    lambda m, g: SECOND([[m]], [[0.3]], [[m * g]], [[g]]), m=(1, 1.6), g=(0.3, 0.5)
)
SQUARES = sos.Uncertain(lambda v: SECOND(1, 0.5 + 4 * (v - 0.4) ** 2, 2, 1), v=(0, 1))
MIXED = sos.Uncertain(lambda m, k: SECOND(m, 0.3, k, 1), m=(1, 1.5), k=(0.2, 0.5))
COUPLED = sos.Uncertain(  # E^-1 [A B] isn't affine along m, and E is
    lambda m, k: SECOND(
        [[m, m / 5], [m / 5, 1]], np.diag([0.4, 0.3]), np.diag([k, 2]), [[1], [0]]
    ),
    m=(1, 1.3),
    k=(2, 3),
)
TWO_PARTS = sos.Uncertain(  # the determinants' ratio along m isn't that along p
    lambda m, p: SECOND(m + p, 0.5, 1, 1), m=(1, 1.2), p=(0.3, 0.5)
)
SEEN = sos.HInfinity(9, outputs=sos.Output(position=1) & sos.Output(input=0.1))
CASES = {
    "one plant": (two_masses(), WEAK, 0.1, 0.03),
    "no delay": (two_masses(), WEAK, 0.1, 0.0),
    "whole ticks": (two_masses(), WEAK, 0.1, 3 * 0.1),
    "masses, a simplex": (masses((1, 0.1), (3, 0.1), (1.5, 0.8)), CART, 0.3, 0.1),
    "a box": (RANGES, WEAK, 0.2, 0.05),
    "a box of products": (PRODUCTS, CART, 0.3, 0.0),
    "a mass in two columns": (COUPLED, [[-0.5, 0, -0.8, 0]], 0.1, 0.0),
    "a mass of two parts": (TWO_PARTS, SOFT, 0.1, 0.02),
    "squares": (SQUARES, [[0, -0.001]], 0.01, 0.0),
    "a clock that varies": (SPRING, SOFT, (0.1, 0.3), (0.0, 0.1)),
    "delays beyond a tick": (SPRING, [[-0.1, -0.3]], 0.1, (0.13, 0.19)),
    "a box and jitter": (MIXED, SOFT, (0.1, 0.2), 0.05),
}
NORMS = {
    "a law and a norm": (driven(1), LAW, 0.1, 0.03, SEEN),
    "a law that reads w": (
        sos.Polytope([driven(1), driven(1.2)]), NOISY, 0.1, (0.1, 0.13),
        sos.HInfinity(9),
    ),
}  # fmt: skip
NAMES = tuple(CASES)
PROOFS = {}


def proof(name):
    if name not in PROOFS:
        *asked, norm = CASES[name] + (None,) if name in CASES else NORMS[name]
        PROOFS[name] = certify_sampled(*asked, norm=norm)
    return PROOFS[name]


def floats(x):
    if not hasattr(x, "a"):
        return float(x)
    return np.array([[e / x.d for e in u] for u in x.a]).reshape(x.r, x.c)


def opened(found):
    """The numbers of a proof's text, by name, and what its boxes are of."""
    boxes = []

    class Watched(sampled.Sampled):
        def _times(self, corners, P, edges, T, late, times, at):
            super()._times(corners, P, edges, T, late, times, at)
            boxes.append(SimpleNamespace(
                corners=corners, P=P, T=[*map(float, T)], late=[*map(float, late)],
                b=self.boxes, q=at["q"], f=at["f"],
                whole=self.loop.whole, axes=self.loop.axes,
                share=bool(edges) or T[0] < T[1] or late[0] < late[1]))  # fmt: skip

    text = Watched({"kind": "sampled", **found.data})
    file = text.t.file()
    data = {k: read(v) for k, v in file["data"].items()}
    reader = Reader(data, {}, file["sets"], True)
    for _ in reader.statements(parse("\n".join(file["text"]))):
        pass
    return lambda name: floats(reader.env[name].v), boxes


@pytest.mark.parametrize("name", [*NAMES, *NORMS])
def test_integers_alone_decide(name, tmp_path):
    found = proof(name)
    assert found.proven and not found.examined.alone
    path = tmp_path / "proof.json"
    found.save(path)
    assert [*verdict.check(path.read_text("utf-8"))] == list(found.claims)
    assert SampledProof.load(path).verify()


def test_where_motions_grow_too_fast_in_the_usual_frame_another_is_sought():
    """Two masses, far apart and without a gain: a tick is ten of their periods."""
    stiff, turn = np.array([[1, -1], [-1, 1.001]]), np.array([[0, 0.1], [-0.1, 0]])
    masses = np.diag([0.16, 0.00455])
    plant = sos.SecondOrderSystem(masses, 5e-5 * stiff + turn, 26.5 * stiff, [[1], [0]])
    found = certify_sampled(plant, np.zeros((1, 4)), 0.128)
    assert found.proven and not found.examined.alone


def mixed(weights, several):
    return sum(w * x for w, x in zip(weights, several))


NARROW = {  # where the third order is nothing, so that W must be reached
    "narrow T": (SPRING, SOFT, (0.2, 0.204), 0.05),
    "narrow delay": (SPRING, SOFT, 0.2, (0.05, 0.052)),
    "narrow mass": (sos.Polytope([SECOND([[m]], [[0.3]], [[1]], [[1]])
                                  for m in (1, 1.05)]), [[-1, -1.5]], 0.3, 0.1),
    "narrow spring": (sos.Uncertain(lambda k, d: SECOND(1, d, k, 1), k=(1, 1.01),
                                    d=(0.3, 0.3001)), [[-1, -1.5]], 0.3, 0.0),
}  # fmt: skip


@pytest.mark.parametrize("name", [*NAMES, *NARROW])
def test_no_plant_and_no_clock_is_further_from_the_means_than_its_text_says(name):
    """D'D <= W and F'P F < P, by floats, at plants and clocks by chance.

    A W twice too large, or more, would hide a fault: in narrow boxes it is reached.
    """
    rng = np.random.default_rng(0)
    found = certify_sampled(*NARROW[name]) if name in NARROW else proof(name)
    assert found.proven and not found.examined.alone
    value, boxes = opened(found)
    K, reached = found.K, []
    N = len(value("L.f0")) - len(value("later"))
    for box in rng.permutation(np.array(boxes, object))[:12]:
        L, corners = value(f"L.{box.f}"), box.corners
        Li = np.linalg.inv(L)

        def loop(weights, T, late, L=L, Li=Li, box=box):
            E, x = (mixed(weights, [value(f"{y}.{c}") for c in box.corners])
                    for y in "ex")  # fmt: skip
            plain = sos.DescriptorSystem(E, x[:, :N], x[:, N:])
            late = box.whole * T + late if box.whole else late
            (F,) = sampled_loop(plain, K, T, late)
            more = len(L) - len(F)  # a delay of none has no older input
            assert more == 0
            return L @ F @ Li

        for _ in range(6):
            t = rng.choice([0, 1, 0.5, *rng.random(2)], 2)
            if box.axes:
                p = rng.choice([0, 1, 0.5, *rng.random(3)], box.axes)
                w = np.ones(1)
                for x in p:
                    w = np.kron(w, [1 - x, x])
            else:
                w = rng.dirichlet(np.full(len(corners), rng.choice([0.3, 1, 3])))
            T, late = ((1 - s) * x[0] + s * x[1] for s, x in zip(t, (box.T, box.late)))
            if not late <= T or (late == 0 and box.late[1]):
                continue
            F = loop(w, T, late)
            P = np.eye(len(L))
            if box.P:
                P = mixed(w, [value(x) for x in box.P])
            falls = np.linalg.eigvals(np.linalg.solve(P, F.T @ P @ F)).real.max()
            assert falls < found.rate**2
            if not box.share:
                continue
            flat = 0
            for (a, T1), (b, l1) in product(
                zip((1 - t[0], t[0]), box.T), zip((1 - t[1], t[1]), box.late)
            ):
                if a * b == 0:
                    continue
                names = clock_names(value, box, T1, l1)
                flat = flat + a * b * mixed(
                    w, [value(f"F.{box.f}.{c}.{names}") for c in corners])  # fmt: skip
            D, W = F - flat, value(f"W.{box.b}")
            size = np.trace(W)
            assert np.linalg.eigvalsh(W - D.T @ D)[0] > -1e-12 * size
            shares = np.linalg.solve(W + 1e-13 * size * np.eye(len(W)), D.T @ D)
            reached.append(np.sqrt(max(np.linalg.eigvals(shares).real.max(), 0)))
    top = max(reached, default=0)
    assert top > 0.9 if name in NARROW else top < 1, top


def clock_names(value, box, T, late):
    """The part of a loop's name that says its clock."""

    def name(kind, x):
        for k in ("lo", "hi", *(f"h{j}" for j in range(200))):
            try:
                if abs(value(f"{kind}.{k}") - x) < 1e-12:
                    return k
            except KeyError:
                continue
        raise AssertionError(f"no {kind} is {x}")

    return f"{name('T', T)}.{name('late', late)}"


def outcome(data):
    """What the checker says of ``data``: proven, or not."""
    try:
        whole, _, _ = verdict.written({"kind": "sampled", **data})
        kernel.check(whole)
    except (Refused, Beyond, *kernel.MALFORMED):
        return False
    return True


def places(x, path=()):
    """The place of each number in some data."""
    if isinstance(x, (dict, list)):
        inner = x.items() if isinstance(x, dict) else enumerate(x)
        for k, v in inner:
            yield from places(v, (*path, k))
    elif isinstance(x, str) and x.replace("e-", "").strip("-.0123456789") == "":
        yield path


def at(x, path):
    for k in path:
        x = x[k]
    return x


def radius(data, rng):
    """The largest spectral radius of plants and clocks by chance, of changed data."""
    found = SampledProof.of(data)
    plant = found._plant()[0]
    K, worst = found.K, 0.0
    T, delay = (np.atleast_1d(np.array(x, float)) for x in (found.T, found.delay))
    for k in range(40):
        t, late = (x[0] + (x[-1] - x[0]) * (rng.random() if k > 3 else k % 2)
                   for x in (T, delay))  # fmt: skip
        one = plant
        if plant.family is not None:
            (one,) = plant.family.sample(1, int(rng.integers(1 << 30)))
        elif len(plant.vertices) > 1:
            one = plant.at(rng.dirichlet(np.full(len(plant.vertices), 0.5)))
        if len(T) > 1 and late > t:
            continue
        law = K if late else K[:, : plant.vertices[0].n * 2]  # no older input acts
        worst = max(worst, *(abs(np.linalg.eigvals(F)).max()
                             for F in sampled_loop(one, law, t, late)))  # fmt: skip
    return worst


@pytest.mark.parametrize("name", ["one plant", "masses, a simplex", "a box of products",
                                  "a clock that varies"])  # fmt: skip
@pytest.mark.parametrize("rounds", [2, *campaign([8])])
def test_a_changed_request_is_refused_or_true(name, rounds):
    """Each number that is asked or found, changed: what is accepted holds."""
    rng, data = np.random.default_rng(1), proof(name).data
    assert outcome(data)
    by_key = {}
    for path in places(data):
        by_key.setdefault(path[0], []).append(path)
    accepted = 0
    for key in ("plant", "K", "T", "delay", "rate", "frames", "cells") * rounds:
        path = by_key[key][rng.integers(len(by_key[key]))]
        changed = copy.deepcopy(data)
        old = at(data, path)
        factor = rng.choice([0.3, 0.8, 1.02, 1.5, 4.0, -1.0])
        new = rng.uniform(0.5, 1) if key == "rate" else float(old) * factor + 1e-3
        holder = at(changed, path[:-1])
        holder[path[-1]] = repr(float(f"{new:.9g}")).removesuffix(".0")
        if key in ("T", "delay") and data[key][0] == data[key][1]:
            changed[key] = [holder[path[-1]]] * 2
        if outcome(changed):
            accepted += 1
            assert radius(changed, rng) < float(changed["rate"]) * (1 + 1e-9), path
    assert accepted  # or nothing was tried


@pytest.mark.parametrize("edge, holds", [(1.65, True), (1.74, False)])
def test_the_longest_clock_of_one_plant_is_where_the_radius_is_one(edge, holds):
    """A mass of 10 with friction; constant intervals are stable up to 1.729 s."""
    plant, K = SECOND([[10]], [[1]], [[0]], [[1]]), [[-3.75, -11.5]]
    found = certify_sampled(plant, K, edge)
    assert (found.proven and not found.examined.alone) is holds
    (F,) = sampled_loop(plant, K, edge)
    assert bool(abs(np.linalg.eigvals(F)).max() < 1) is holds


def test_the_words_name_the_clock():
    words = {x: str(proof(x)) for x in NAMES}
    assert (
        "with a tick every 0.1 s and a delay of 0.03 s, is stable" in words["one plant"]
    )
    assert "with a tick every 0.1 s and no delay, is" in words["no delay"]
    assert "and a delay of 0.3 s, is" in words["whole ticks"]
    varied = words["a clock that varies"]
    assert "the sampled loop of the plant is stable for every sequence of" in varied
    assert "with a delay of 0.05 s, is stable for every" in words["a box and jitter"]
    late = words["delays beyond a tick"]
    assert "with a tick every 0.1 s, is stable for every sequence of delays in" in late


def test_a_file_holds_the_digest_of_its_text_and_the_checker_prints_it(tmp_path):
    found = proof("one plant")
    path = tmp_path / "proof.json"
    found.save(path)
    file = json.loads(path.read_text("utf-8"))
    assert file["text"].startswith("sha256:") and len(found.text) < 3000
    done = subprocess.run([sys.executable, "-I", str(CHECKER), str(path), "--text"],
                          capture_output=True, encoding="utf-8")  # fmt: skip
    assert "tick.1.0: rate^2 - F.f0.1.lo.lo' F.f0.1.lo.lo > 0" in done.stdout
    alone = subprocess.run([sys.executable, str(CHECKER / "kernel.py"), str(path)],
                           capture_output=True, encoding="utf-8")  # fmt: skip
    assert alone.returncode == 1 and "the text isn't in the file" in alone.stdout
    other = file | {"text": "sha256:" + "0" * 64}
    path.write_text(json.dumps(other), "utf-8")
    assert not SampledProof.load(path).proven
